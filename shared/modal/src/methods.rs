//! One list of the methods: the requirements of each, and its call.

use crate::era::era;
use crate::gram::output_gram;
use crate::lsce::lsce;
use crate::mac::modal_phase_collinearity;
use crate::maximum_likelihood::{self as ml, MlError, Model, linear_shapes};
use crate::po_moesp::po_moesp;
use crate::rational_fraction::{self, Orders, RfpError};
use crate::record::Record;
use crate::selection::Mode;
use crate::ssi_cov::{Pole, Projection, Realisation, SsiError, realise_by};
use crate::uncertainty::{Blocks, pole_deviations};
use faer::c64;
use std::borrow::Cow;

/// Further roots that take part in the fit of the shapes of LSCE's modes.
const SHAPE_COMPANIONS: usize = 4;

/// Input of a method besides the record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Oscillations sought.
    pub modes: usize,
    /// Block rows of the subspace methods; ERA takes twice as many, LSCE five times as many
    /// coefficients.
    pub block_rows: usize,
    /// The sensors may have a bias: one more state.
    pub bias: bool,
    /// Spectral lines taken by the method that works on lines; all when none.
    pub band_hz: Option<(f64, f64)>,
}

impl Settings {
    /// Settings of the benchmark's study: i = 40, ERA 80, LSCE 200, sensors may have a bias.
    #[must_use]
    pub fn new(modes: usize) -> Self {
        Self { modes, block_rows: 40, bias: true, band_hz: None }
    }
}

/// An oscillation as a method found it.
#[derive(Clone, Debug)]
pub struct Estimate {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Standard deviations that the method states; `None`: it states none.
    pub deviation: Option<Deviation>,
    /// Complex shape per channel, largest component 1.
    pub mode_shape: Vec<c64>,
    /// Standard deviations of real and imaginary parts; empty where the method states none.
    pub shape_deviation: Vec<c64>,
    pub phase_collinearity: f64,
}

/// Standard deviations of frequency and damping, and the correlation of their errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    pub correlation: f64,
}

/// Why a method has no answer.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodError {
    Subspace(SsiError),
    Likelihood(MlError),
    Fraction(RfpError),
    /// The method needs the input of the structure.
    NeedsInput,
}

impl std::fmt::Display for MethodError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Subspace(error) => error.fmt(f),
            Self::Likelihood(error) => error.fmt(f),
            Self::Fraction(error) => error.fmt(f),
            Self::NeedsInput => write!(f, "the input is not known; this method needs it"),
        }
    }
}

impl std::error::Error for MethodError {}

impl From<SsiError> for MethodError {
    fn from(error: SsiError) -> Self {
        Self::Subspace(error)
    }
}

impl From<MlError> for MethodError {
    fn from(error: MlError) -> Self {
        Self::Likelihood(error)
    }
}

impl From<RfpError> for MethodError {
    fn from(error: RfpError) -> Self {
        Self::Fraction(error)
    }
}

/// A method.
pub struct Method {
    /// As the literature spells it, lower case.
    pub name: &'static str,
    pub about: &'static str,
    /// Whether it takes known inputs into account; one that does not sees the segments only.
    pub takes_input: bool,
    pub identify: fn(&Record, &Settings) -> Result<Vec<Estimate>, MethodError>,
}

/// All methods, the estimator of record first.
pub static METHODS: &[Method] = &[
    Method {
        name: "ml",
        about: "maximum likelihood by variable projection",
        takes_input: true,
        identify: by_likelihood,
    },
    Method { name: "lsce", about: "least-squares complex exponential", takes_input: false, identify: by_lsce },
    Method {
        name: "rfp",
        about: "rational fraction polynomials with transient terms",
        takes_input: true,
        identify: by_fraction,
    },
    Method {
        name: "ssi-cov",
        about: "covariance-driven stochastic subspace",
        takes_input: false,
        identify: |record, settings| by_subspace(record, settings, Projection::Covariance),
    },
    Method {
        name: "ssi-data",
        about: "data-driven stochastic subspace",
        takes_input: false,
        identify: |record, settings| by_subspace(record, settings, Projection::Data),
    },
    Method { name: "era", about: "eigensystem realisation", takes_input: false, identify: by_era },
    Method { name: "po-moesp", about: "past-output MOESP subspace", takes_input: true, identify: by_moesp },
];

/// The method of that name.
#[must_use]
pub fn method(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}

impl Estimate {
    fn bare(pole: c64, mode_shape: Vec<c64>) -> Self {
        let omega = pole.norm_sqr().sqrt();
        Self {
            frequency_hz: omega / (2.0 * std::f64::consts::PI),
            damping_ratio: -pole.re / omega,
            deviation: None,
            phase_collinearity: modal_phase_collinearity(&mode_shape),
            mode_shape,
            shape_deviation: Vec::new(),
        }
    }
}

impl From<&Mode> for Estimate {
    fn from(mode: &Mode) -> Self {
        Self {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            deviation: Some(Deviation {
                frequency_hz: mode.sigma_frequency_hz,
                damping_ratio: mode.sigma_damping,
                correlation: mode.correlation,
            }),
            mode_shape: mode.mode_shape.clone(),
            shape_deviation: mode.shape_deviation.clone(),
            phase_collinearity: mode.phase_collinearity,
        }
    }
}

/// The longest segment as a record without inputs: a free decay.
#[must_use]
pub fn longest_segment(record: &Record) -> Record {
    let longest = record.segments.iter().max_by_key(|segment| segment.len()).cloned().unwrap_or(0..0);
    Record::of_outputs(record.sample_rate_hz, record.channels, record.rows(&longest).to_vec())
}

/// A record with its inputs, at rest before; or of one without, the longest decay, which moves from
/// its first sample.
fn driven_or_decaying<'a>(record: &'a Record, settings: &Settings) -> (Cow<'a, Record>, Model) {
    let initial_motion = record.inputs == 0;
    let record = if initial_motion { Cow::Owned(longest_segment(record)) } else { Cow::Borrowed(record) };
    (record, Model { initial_motion, bias: settings.bias, ..Model::FORCED })
}

fn by_likelihood(record: &Record, settings: &Settings) -> Result<Vec<Estimate>, MethodError> {
    let (record, model) = driven_or_decaying(record, settings);
    let start = ml::start(&record, settings.modes)?;
    Ok(estimates(&ml::fit_with_motion(&record, model, &start)?.0))
}

/// The modes of a maximum-likelihood fit.
#[must_use]
pub fn estimates(fit: &ml::Fit) -> Vec<Estimate> {
    (0..fit.poles.len())
        .map(|k| {
            let (f, zeta, both) = fit.variances(k);
            let deviation =
                Deviation { frequency_hz: f.sqrt(), damping_ratio: zeta.sqrt(), correlation: both / (f * zeta).sqrt() };
            Estimate { deviation: Some(deviation), ..Estimate::bare(fit.poles[k], fit.mode_shapes[k].clone()) }
        })
        .collect()
}

fn by_lsce(record: &Record, settings: &Settings) -> Result<Vec<Estimate>, MethodError> {
    // Half of the longest segment at most: as many equations as unknowns.
    let longest = record.segments.iter().map(std::ops::Range::len).max().unwrap_or(0);
    let poles = lsce(record, (5 * settings.block_rows).min(longest / 2), settings.modes + SHAPE_COMPANIONS)?;
    // What else moves would bend the shapes; damping bends nothing there.
    let model = Model { bias: settings.bias, ..Model::FREE };
    let mut estimates = with_shapes(&longest_segment(record), model, &poles);
    let mut oscillates = poles.iter().map(|pole| pole.im > 0.0);
    estimates.retain(|_| oscillates.next().expect("one pole per estimate"));
    estimates.truncate(settings.modes);
    estimates.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok(estimates)
}

fn by_fraction(record: &Record, settings: &Settings) -> Result<Vec<Estimate>, MethodError> {
    let (record, model) = driven_or_decaying(record, settings);
    let band_hz = settings.band_hz.unwrap_or((0.0, 0.5 * record.sample_rate_hz));
    let poles = rational_fraction::of_record(&record, band_hz, Orders::of_modes(settings.modes))?;
    Ok(with_shapes(&record, model, &poles))
}

/// Shapes by linear least squares at poles found otherwise.
fn with_shapes(record: &Record, model: Model, poles: &[c64]) -> Vec<Estimate> {
    poles.iter().zip(linear_shapes(record, model, poles)).map(|(pole, shape)| Estimate::bare(*pole, shape)).collect()
}

fn by_subspace(record: &Record, settings: &Settings, projection: Projection) -> Result<Vec<Estimate>, MethodError> {
    let gram = output_gram(record, settings.block_rows);
    let order = 2 * settings.modes + usize::from(settings.bias);
    let realisation = realise_by(&gram, order, projection)?;
    let poles = oscillations(&realisation, order, record.sample_rate_hz);
    let borrowed: Vec<&Pole> = poles.iter().collect();
    let deviations = pole_deviations(&gram, Blocks::Windows(&[]), &realisation, &borrowed, record.sample_rate_hz);
    let estimate = |(pole, found): (&Pole, crate::uncertainty::PoleDeviation)| Estimate {
        frequency_hz: pole.frequency_hz,
        damping_ratio: pole.damping_ratio,
        deviation: Some(Deviation {
            frequency_hz: found.sigma_frequency_hz,
            damping_ratio: found.sigma_damping,
            correlation: found.correlation,
        }),
        mode_shape: pole.mode_shape.clone(),
        shape_deviation: Vec::new(),
        phase_collinearity: pole.phase_collinearity,
    };
    Ok(poles.iter().zip(deviations).map(estimate).collect())
}

/// Oscillations of an order, in order of frequency.
fn oscillations(realisation: &Realisation, order: usize, sample_rate_hz: f64) -> Vec<Pole> {
    let mut poles = realisation.poles(order.min(realisation.order_max()), sample_rate_hz);
    poles.retain(|pole| pole.eigenvalue.im > 0.0);
    poles
}

fn by_era(record: &Record, settings: &Settings) -> Result<Vec<Estimate>, MethodError> {
    let order = 2 * settings.modes + usize::from(settings.bias);
    let modes = era(record, 2 * settings.block_rows, order)?;
    Ok(modes.into_iter().map(|mode| Estimate::bare(mode.pole, mode.mode_shape)).collect())
}

fn by_moesp(record: &Record, settings: &Settings) -> Result<Vec<Estimate>, MethodError> {
    if record.inputs == 0 {
        return Err(MethodError::NeedsInput);
    }
    // The constant is an input here, not a state.
    let realisation = po_moesp(record, settings.block_rows, 2 * settings.modes)?;
    let poles = oscillations(&realisation, 2 * settings.modes, record.sample_rate_hz);
    Ok(poles.into_iter().map(|pole| Estimate::bare(pole.continuous(), pole.mode_shape)).collect())
}
