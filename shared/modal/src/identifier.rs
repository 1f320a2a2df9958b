//! The whole identifier as a partition uses it: samples in, modes out, fixed memory between.
//!
//! The stream is halved in rate several times and each rate has its own accumulator, because i
//! block rows look i samples ahead and a mode far below the sample rate needs a longer look. A mode
//! seen at several rates is reported from the rate at which it persists over most orders, among
//! those at which its predicted variance is within a factor of two of the smallest.

use serde::{Deserialize, Serialize};

use crate::best_rate::keep_best_rate;
use crate::decimation::{HalfBand, PASS_BAND};
use crate::gram::Gram;
use crate::pairs::PairCovariances;
use crate::selection::{Mode, Parts, Selection, SelectionSettings, Swept, select_modes};
use crate::ssi_cov::SsiError;
use crate::streaming::StreamingCovariance;

/// Part of the undecimated rate up to which poles are taken: the last 2 % before the Nyquist
/// frequency fold easily.
const USABLE_BAND: f64 = 0.48;

/// Settings of the identifier.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Config {
    pub channels: usize,
    pub sample_rate_hz: f64,
    /// Block rows i: the covariances reach over 2i samples of each rate.
    pub block_rows: usize,
    /// Frequencies sought; the whole usable band when none.
    pub band_hz: Option<(f64, f64)>,
    /// Number of times the rate is halved; each costs half the accumulation of the one before.
    pub halvings: usize,
    /// Blocks kept at each rate for the spread along the record; as many as pay when none is
    /// stated. One: the newest segment alone.
    pub blocks: Option<usize>,
    pub selection: SelectionSettings,
}

impl Config {
    /// Settings without knowledge of the record: i = 40, three halvings, whole band.
    #[must_use]
    pub fn new(channels: usize, sample_rate_hz: f64) -> Self {
        Self {
            channels,
            sample_rate_hz,
            block_rows: 40,
            band_hz: None,
            halvings: 3,
            blocks: None,
            selection: SelectionSettings::default(),
        }
    }
}

/// Why no answer can be given; an answer without modes is not an error.
#[derive(Clone, Debug, PartialEq)]
pub enum ModalError {
    /// At no rate the record fills enough columns.
    RecordTooShort { samples: u64, need: u64 },
    /// Flat channels.
    NoSignal { samples: u64 },
    /// Numerical failure of the factorisation at every rate.
    DecompositionFailed { rows: usize },
}

impl std::fmt::Display for ModalError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::RecordTooShort { samples, need } => write!(f, "{samples} samples in the record, {need} needed"),
            Self::NoSignal { samples } => write!(f, "the channels are flat over {samples} samples"),
            Self::DecompositionFailed { rows } => write!(f, "decomposition of a {rows}-row matrix did not converge"),
        }
    }
}

impl std::error::Error for ModalError {}

/// Streaming modal identifier.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ModalIdentifier {
    config: Config,
    stages: Vec<HalfBand>,
    /// One per rate: undecimated first.
    covariances: Vec<StreamingCovariance>,
}

impl ModalIdentifier {
    /// Takes all memory of the accumulation. A segment is open from the start.
    #[must_use]
    pub fn new(config: Config) -> Self {
        assert!(config.sample_rate_hz > 0.0);
        assert!(config.selection.order_max > 0);
        let stages = (0..config.halvings).map(|_| HalfBand::new(config.channels)).collect();
        let (channels, block_rows) = (config.channels, config.block_rows);
        let accumulator = || match config.blocks {
            Some(blocks) => StreamingCovariance::with_blocks(channels, block_rows, blocks),
            None => StreamingCovariance::new(channels, block_rows),
        };
        let covariances = (0..=config.halvings).map(|_| accumulator()).collect();
        Self { config, stages, covariances }
    }

    /// The same for a record in memory, in less time and more memory.
    #[must_use]
    pub(crate) fn deferred(mut self) -> Self {
        self.covariances = self.covariances.into_iter().map(StreamingCovariance::deferred).collect();
        self
    }

    /// The settings of [`Self::new`].
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Samples taken into the sums at the full rate.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.covariances[0].samples()
    }

    /// Adds one sample of all channels; no allocation. A value that is not finite ends the segment
    /// and begins another.
    pub fn push(&mut self, sample: &[f64]) {
        assert_eq!(sample.len(), self.config.channels);
        if sample.iter().any(|y| !y.is_finite()) {
            self.open_segment();
            return;
        }
        let (full, decimated) = self.covariances.split_first_mut().expect("there is the full rate");
        full.push(sample);
        let mut current: &[f64] = sample;
        for (stage, covariance) in self.stages.iter_mut().zip(decimated) {
            match stage.push(current) {
                Some(output) => {
                    covariance.push(output);
                    current = output;
                }
                None => return,
            }
        }
    }

    /// Begins a segment: earlier and later samples are unrelated.
    pub fn open_segment(&mut self) {
        self.stages.iter_mut().for_each(HalfBand::clear);
        self.covariances.iter_mut().for_each(StreamingCovariance::open_segment);
    }

    /// Ends the segment; samples are ignored until the next [`Self::open_segment`].
    pub fn close_segment(&mut self) {
        self.covariances.iter_mut().for_each(StreamingCovariance::close_segment);
    }

    /// Modes of all that has been pushed, in order of frequency.
    ///
    /// # Errors
    /// [`ModalError`] when no rate can be solved at all.
    pub fn identify(&mut self) -> Result<Vec<Mode>, ModalError> {
        self.identify_with_reasons().map(|selection| selection.modes)
    }

    /// As [`Self::identify`], with every rejected pole and the reason.
    ///
    /// # Errors
    /// [`ModalError`] when no rate can be solved at all.
    pub fn identify_with_reasons(&mut self) -> Result<Selection, ModalError> {
        let wanted = Wanted { collinearities_min: &[self.config.selection.phase_collinearity_min], ..Wanted::ALL };
        self.select(&self.config, wanted).map(|mut selections| selections.remove(0))
    }

    /// A selection for each of the collinearities wanted, by the selection of other settings.
    ///
    /// # Errors
    /// [`ModalError`] when no rate can be solved at all.
    pub(crate) fn select(&self, config: &Config, wanted: Wanted<'_>) -> Result<Vec<Selection>, ModalError> {
        let rates = self.covariances.iter().enumerate().filter(|(halving, _)| wanted.has(*halving));
        let select = |(halving, covariance): (usize, &StreamingCovariance)| {
            let (gram, blocks) = (covariance.gram(), covariance.complete_blocks());
            (halving, select_at(config, halving, (&gram, Parts::Windows(&blocks)), wanted))
        };
        of_all_rates(config, self.samples(), rates.map(select))
    }
}

/// Selections that are wanted of covariances at several rates.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Least phase collinearities, a selection for each.
    pub collinearities_min: &'a [f64],
    /// Samples of the record per sample of a rate; all rates when empty.
    pub decimations: &'a [usize],
}

impl Wanted<'_> {
    /// Every rate.
    const ALL: Self = Self { collinearities_min: &[], decimations: &[] };

    fn has(self, halving: usize) -> bool {
        self.decimations.is_empty() || self.decimations.contains(&(1 << halving))
    }
}

/// Modes of a stationary record with samples missing, from the pairs that exist, at the same rates
/// as in flight; a selection for each of the collinearities wanted.
///
/// # Errors
/// [`ModalError`] when the pairs are too few, or no channel can be a reference.
pub(crate) fn select_by_pairs(
    rates: &[PairCovariances],
    rows: u64,
    config: &Config,
    wanted: Wanted<'_>,
) -> Result<Vec<Selection>, ModalError> {
    let rates = rates.iter().enumerate().filter(|(halving, _)| wanted.has(*halving));
    let select = |(halving, of): (usize, &PairCovariances)| {
        (halving, select_at(config, halving, (&of.gram(), Parts::Pairs(of)), wanted))
    };
    of_all_rates(config, rows, rates.map(select))
}

fn select_at(
    config: &Config,
    halving: usize,
    (gram, parts): (&Gram, Parts<'_>),
    wanted: Wanted<'_>,
) -> Result<Vec<Selection>, SsiError> {
    let decimation = 1usize << halving;
    let sample_rate_hz = config.sample_rate_hz / decimation as f64;
    let usable_hz = sample_rate_hz * if halving == 0 { USABLE_BAND } else { PASS_BAND };
    let (low, high) = config.band_hz.unwrap_or((0.0, usable_hz));
    let swept = Swept { gram, parts, sample_rate_hz, band_hz: (low, high.min(usable_hz)), decimation };
    select_modes(swept, &config.selection, wanted.collinearities_min)
}

/// Full rate first.
fn of_all_rates(
    config: &Config,
    samples: u64,
    selections: impl Iterator<Item = (usize, Result<Vec<Selection>, SsiError>)>,
) -> Result<Vec<Selection>, ModalError> {
    let mut all: Vec<Selection> = Vec::new();
    for (halving, of_rate) in selections {
        match of_rate {
            Ok(of_rate) => {
                all.resize_with(of_rate.len(), Selection::default);
                for (all, selection) in all.iter_mut().zip(of_rate) {
                    all.modes.extend(selection.modes);
                    all.rejected.extend(selection.rejected);
                }
            }
            Err(error) if halving == 0 => return Err(modal_error(error, config, samples)),
            Err(_) => {} // a decimated record may be too short while the full rate is not
        }
    }
    Ok(all.into_iter().map(keep_best_rate).collect())
}

fn modal_error(error: SsiError, config: &Config, samples: u64) -> ModalError {
    match error {
        SsiError::RecordTooShort { need, .. } => {
            let need = need + 2 * config.block_rows as u64 - 1;
            ModalError::RecordTooShort { samples, need }
        }
        SsiError::NoSignal { .. } => ModalError::NoSignal { samples },
        SsiError::DecompositionFailed { rows } => ModalError::DecompositionFailed { rows },
    }
}
