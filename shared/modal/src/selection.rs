//! Automatic selection of physical modes from the order sweep of one record.
//!
//! A track of stable poles is a mode when it spans enough orders and the pole chosen from it is
//! resolved: damping at least three standard deviations above zero and frequency known to a
//! fraction of the bandwidth. No model order has to be given:
//!
//! - when some order leaves a white residual (a free decay with sensor noise), the lowest such
//!   order is the model: poles that appear only above it model noise, and modes are reported from
//!   it;
//! - otherwise (ambient excitation) modes are reported from an order at which all resolved modes
//!   have appeared, the lowest whose predicted variance is within `DEVIATION_SLACK` of the
//!   smallest: at lower orders the unmodelled modes bias those in the model. A track that ends
//!   before that order is a mode if the model there still has a pole for it.

use faer::c64;

use crate::adequacy::chi_square_tail;
use crate::gram::Gram;
use crate::pairs::PairCovariances;
use crate::shape_uncertainty::{ShapeScale, shape_deviations};
use crate::ssi_cov::{Pole, Realisation, SsiError, realise};
use crate::stabilisation::{RejectedPole, Rejection, StabilityCriteria, Track, is_in_model, tracks};
use crate::stretch::Stretch;
use crate::uncertainty::{BlockProduct, Blocks, PoleDeviation, pole_deviations, residual};
use crate::weighting::homogeneous;

/// Variances this close to the smallest count as equal; the lowest order wins.
const DEVIATION_SLACK: f64 = 1.2;
/// Poles of a track whose deviation is computed to see whether it is resolved.
const CANDIDATES_FIRST: usize = 2;
/// Poles of a resolved track whose deviation is computed to choose the one reported.
const CANDIDATES_LAST: usize = 4;
/// States beyond the order at which the last mode appeared: one more pair models the remainder,
/// which would otherwise bias a mode.
const ORDER_MARGIN: usize = 2;
/// Least damping ratio in its standard deviations: some hundred tracks are judged per record, 0.1 %
/// of noise passes 3.
const DAMPING_SIGNIFICANCE: f64 = 3.0;

/// Probability of the coherence of chance: α = 1 % over M = 10⁴ products (frequencies and dampings
/// that a record of some thousand samples tells apart).
const CHANCE: f64 = 1e-6;

/// Whether chance reaches a coherence less often than [`CHANCE`]: a pole has 4 l real numbers of
/// shape to fit to it, so that its square is at most χ² of as many degrees.
fn is_beyond_chance(coherence: f64, channels: usize) -> bool {
    coherence.is_infinite() || chi_square_tail(coherence * coherence, 4.0 * channels as f64) < CHANCE
}

/// An identified mode.
#[derive(Clone, Debug)]
pub struct Mode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub sigma_frequency_hz: f64,
    pub sigma_damping: f64,
    /// Of the errors of frequency and damping.
    pub correlation: f64,
    /// Complex shape per channel, largest component 1.
    pub mode_shape: Vec<c64>,
    /// Standard deviations of real and imaginary parts; empty where none were asked for.
    pub shape_deviation: Vec<c64>,
    pub phase_collinearity: f64,
    pub channel_share: Vec<f64>,
    pub dominant_channel: usize,
    pub orders_found: usize,
    /// Order of the pole reported.
    pub order: usize,
    pub decimation: usize,
}

/// Criteria of the selection.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SelectionSettings {
    pub stability: StabilityCriteria,
    /// Largest model order of the sweep.
    pub order_max: usize,
    /// Orders in which a mode has to repeat; all of them when the record has a lower rank.
    pub orders_needed: usize,
    pub phase_collinearity_min: f64,
    /// The scale at which the modes get the deviations of their shapes, too; none when not stated.
    pub shape_deviations: Option<ShapeScale>,
}

impl Default for SelectionSettings {
    fn default() -> Self {
        Self {
            stability: StabilityCriteria::default(),
            order_max: 30,
            orders_needed: 6,
            phase_collinearity_min: 0.5,
            shape_deviations: None,
        }
    }
}

/// Modes and rejected poles of one record at one sample rate.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    pub modes: Vec<Mode>,
    pub rejected: Vec<RejectedPole>,
}

/// Parts of a record at one rate.
#[derive(Clone, Copy)]
pub(crate) enum Parts<'a> {
    /// Without a break; none when there are few.
    Windows(&'a [Stretch]),
    /// Pairs of samples.
    Pairs(&'a PairCovariances),
}

/// What is swept at one sample rate.
#[derive(Clone, Copy)]
pub(crate) struct Swept<'a> {
    pub gram: &'a Gram,
    pub parts: Parts<'a>,
    pub sample_rate_hz: f64,
    /// Frequencies sought.
    pub band_hz: (f64, f64),
    /// Samples of the record per sample of this rate.
    pub decimation: usize,
}

/// Sweeps all orders and selects the modes within the band; from one sweep a selection for each of
/// the least phase collinearities.
///
/// # Errors
/// [`SsiError`] of the factorisation; an absence of modes is not an error.
pub(crate) fn select_modes(
    swept: Swept<'_>,
    settings: &SelectionSettings,
    collinearities_min: &[f64],
) -> Result<Vec<Selection>, SsiError> {
    let Swept { mut gram, parts, sample_rate_hz, band_hz, decimation } = swept;
    let mut realisation = realise(gram, settings.order_max)?;
    let weighted;
    let products: Vec<BlockProduct>;
    // Pairs are taken of ambient records alone, whose residual is never white.
    let (blocks, complete_order) = match parts {
        Parts::Windows(stretches) => {
            let mut stretches = stretches;
            weighted = homogeneous(stretches, (gram.channels, gram.block_rows), &realisation);
            if let Some((sum, blocks)) = &weighted {
                realisation = realise(sum, settings.order_max)?;
                (gram, stretches) = (sum, blocks);
            }
            products = stretches.iter().map(|stretch| BlockProduct::new(stretch, &realisation)).collect();
            (Blocks::Windows(&products), complete_order(gram, &realisation))
        }
        Parts::Pairs(pairs) => (Blocks::Pairs(pairs), None),
    };
    let mut selection = Selection::default();
    let mut poles = Vec::new();
    for order in 1..=realisation.order_max() {
        for pole in realisation.poles(order, sample_rate_hz) {
            match settings.stability.hard_rejection(&pole, band_hz) {
                Some(reason) => selection.rejected.push(rejected(&pole, decimation, reason)),
                None => poles.push(pole),
            }
        }
    }
    let orders_needed = if realisation.order_max() < settings.order_max { 1 } else { settings.orders_needed };
    let mut stable = Vec::new();
    for track in tracks(poles, &settings.stability) {
        let reason = if track.poles.len() < orders_needed {
            Rejection::NotStable { orders_found: track.poles.len(), orders_needed }
        } else if let Some(complete_order) = complete_order.filter(|&complete| track.poles[0].order > complete) {
            Rejection::ModelsNoise { complete_order }
        } else {
            stable.push(track);
            continue;
        };
        selection.rejected.extend(track.poles.iter().map(|pole| rejected(pole, decimation, reason)));
    }
    let appraisal = Appraisal { gram, blocks, realisation: &realisation, sample_rate_hz, decimation, complete_order };
    let first = appraisal.best(&stable, |track| positions(track, complete_order.unwrap_or(0), CANDIDATES_FIRST));
    let of = |collinearity_min: &f64| {
        let settings = SelectionSettings { phase_collinearity_min: *collinearity_min, ..*settings };
        appraisal.select(&stable, &first, selection.clone(), &settings)
    };
    Ok(collinearities_min.iter().map(of).collect())
}

/// Lowest order that leaves a white residual; `None` when not even the largest does.
fn complete_order(gram: &Gram, realisation: &Realisation) -> Option<usize> {
    let is_white = |order: usize| residual(gram, realisation, order).is_white();
    let (mut low, mut high) = (0, realisation.order_max());
    if !is_white(high) {
        return None;
    }
    while high - low > 1 {
        let middle = low.midpoint(high);
        if is_white(middle) { high = middle } else { low = middle }
    }
    Some(high)
}

fn rejected(pole: &Pole, decimation: usize, reason: Rejection) -> RejectedPole {
    RejectedPole {
        decimation,
        order: pole.order,
        frequency_hz: pole.frequency_hz,
        damping_ratio: pole.damping_ratio,
        reason,
    }
}

fn not_resolved(pole: &Pole, deviation: PoleDeviation) -> Rejection {
    Rejection::NotResolved {
        damping_ratio: pole.damping_ratio,
        sigma_damping: deviation.sigma_damping,
        sigma_frequency_hz: deviation.sigma_frequency_hz,
    }
}

fn refusal(pole: &Pole, deviation: PoleDeviation, settings: &SelectionSettings) -> Option<Rejection> {
    let bandwidth_hz = 2.0 * pole.damping_ratio * pole.frequency_hz;
    // Written so that a deviation that is not a number counts as unresolved.
    let resolved = deviation.sigma_damping * DAMPING_SIGNIFICANCE < pole.damping_ratio
        && deviation.sigma_frequency_hz < 0.5 * bandwidth_hz;
    if !resolved {
        return Some(not_resolved(pole, deviation));
    }
    (pole.phase_collinearity < settings.phase_collinearity_min).then_some(Rejection::PhaseNotCollinear {
        phase_collinearity: pole.phase_collinearity,
        needed: settings.phase_collinearity_min,
    })
}

/// Input of the standard deviations.
struct Appraisal<'a> {
    gram: &'a Gram,
    blocks: Blocks<'a>,
    realisation: &'a Realisation,
    sample_rate_hz: f64,
    decimation: usize,
    complete_order: Option<usize>,
}

impl Appraisal<'_> {
    /// Modes of the `stable` tracks whose `first` poles are resolved; the reasons of the others
    /// join those of `selection`.
    fn select(
        &self,
        stable: &[Track],
        first: &[Option<(&Pole, PoleDeviation)>],
        mut selection: Selection,
        settings: &SelectionSettings,
    ) -> Selection {
        let mut resolved = Vec::new();
        for (track, best) in stable.iter().zip(first) {
            let refused = |(pole, deviation): &(&Pole, PoleDeviation)| {
                let by_chance = !is_beyond_chance(deviation.coherence, pole.mode_shape.len());
                if by_chance { Some(not_resolved(pole, *deviation)) } else { refusal(pole, *deviation, settings) }
            };
            match best.as_ref().map(refused) {
                Some(None) => resolved.push(track.clone()),
                Some(Some(reason)) => {
                    let of_track = track.poles.iter().map(|pole| rejected(pole, self.decimation, reason));
                    selection.rejected.extend(of_track);
                }
                None => {}
            }
        }
        // Every mode found has to be part of the model a mode is reported from.
        let order_of_all = resolved.iter().map(|track| track.poles[0].order).max().unwrap_or(0) + ORDER_MARGIN;
        let order_min = self.complete_order.unwrap_or(order_of_all);
        let count = if self.complete_order.is_some() { 1 } else { CANDIDATES_LAST };
        let best = self.best(&resolved, |track| positions(track, order_min, count));
        let model = self.realisation.poles(order_min.clamp(1, self.realisation.order_max()), self.sample_rate_hz);
        for (k, (track, (pole, deviation))) in resolved.iter().zip(best.into_iter().flatten()).enumerate() {
            let is_absent = || pole.order < order_min && !is_in_model(pole, &model, &resolved[..k], &resolved[k + 1..]);
            let absent = || is_absent().then_some(Rejection::NotInModel { order_min });
            match refusal(pole, deviation, settings).or_else(absent) {
                None => selection.modes.push(Mode {
                    shape_deviation: settings.shape_deviations.map_or(Vec::new(), |scale| self.of_shape(pole, scale)),
                    ..mode(pole, deviation, track.poles.len(), self.decimation)
                }),
                Some(reason) => selection.rejected.push(rejected(pole, self.decimation, reason)),
            }
        }
        selection.modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        selection
    }

    /// Deviations of the components of a shape; none from pairs of samples, whose covariances have
    /// no windows to propagate.
    fn of_shape(&self, pole: &Pole, scale: ShapeScale) -> Vec<c64> {
        let Blocks::Windows(products) = self.blocks else { return Vec::new() };
        let residual = residual(self.gram, self.realisation, pole.order);
        shape_deviations(self.gram, products, self.realisation, &residual, pole, scale)
    }

    /// Of each track the pole of lowest order among `candidates` (positions) whose variance is
    /// close to the smallest.
    fn best<'t>(
        &self,
        tracks: &'t [Track],
        candidates: impl Fn(&Track) -> Vec<usize>,
    ) -> Vec<Option<(&'t Pole, PoleDeviation)>> {
        let counts: Vec<Vec<usize>> = tracks.iter().map(candidates).collect();
        let poles: Vec<&Pole> =
            tracks.iter().zip(&counts).flat_map(|(track, at)| at.iter().map(|&at| &track.poles[at])).collect();
        let deviations = pole_deviations(self.gram, self.blocks, self.realisation, &poles, self.sample_rate_hz);
        let mut appraised: Vec<(&Pole, PoleDeviation)> = poles.into_iter().zip(deviations).collect();
        let mut best = Vec::new();
        for at in counts {
            let of_track: Vec<_> = appraised.drain(..at.len()).collect();
            let variance = |(pole, deviation): &(&Pole, PoleDeviation)| deviation.relative_to_ideal(pole);
            let smallest = of_track.iter().map(variance).fold(f64::INFINITY, f64::min);
            best.push(of_track.into_iter().find(|candidate| variance(candidate) <= DEVIATION_SLACK * smallest));
        }
        best
    }
}

/// Up to `count` positions of a track from `order_min` on, evenly spread; the last pole if the
/// track ends earlier.
fn positions(track: &Track, order_min: usize, count: usize) -> Vec<usize> {
    let length = track.poles.len();
    let first = track.poles.iter().position(|pole| pole.order >= order_min).unwrap_or(length - 1);
    let step = (length - first).div_ceil(count);
    (first..length).step_by(step).collect()
}

pub(crate) fn mode(pole: &Pole, deviation: PoleDeviation, orders_found: usize, decimation: usize) -> Mode {
    let mut dominant_channel = 0;
    for (channel, share) in pole.channel_share.iter().enumerate() {
        if *share > pole.channel_share[dominant_channel] {
            dominant_channel = channel;
        }
    }
    Mode {
        frequency_hz: pole.frequency_hz,
        damping_ratio: pole.damping_ratio,
        sigma_frequency_hz: deviation.sigma_frequency_hz,
        sigma_damping: deviation.sigma_damping,
        correlation: deviation.correlation,
        mode_shape: pole.mode_shape.clone(),
        shape_deviation: Vec::new(),
        phase_collinearity: pole.phase_collinearity,
        channel_share: pole.channel_share.clone(),
        dominant_channel,
        orders_found,
        order: pole.order,
        decimation,
    }
}
