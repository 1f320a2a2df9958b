//! Sensitivities weighed by what the noise of sensors *and actuators* leaves of them.
//!
//! A command is held over a control period, and so is its noise `w`: what the sensors say of one
//! parameter then has the covariance `Σ = G Q Gᵀ + R` over the whole record, `G` from every held
//! `w` to every reading. `Jᵀ Σ⁻¹ J` is the information of a maximum-likelihood fit in innovation
//! form; `Σ^(−1/2) J` is what a Kalman filter of the plant, linear about the nominal motion, makes
//! of each column of `J` read as a record: its innovations over their standard deviation (Kailath,
//! Sayed and Hassibi 2000, ch. 9).
//!
//! Readings are taken at the instants they tell of (a delayed one earlier), means as the integral
//! over their interval, a low-pass as a first-order lag. Lags and gates that effects put on
//! channels are left out of `G` (not of `J`).

use super::{Channel, Recording, Simulate};
use dynamics::description::{Plant, Reading};
use dynamics::dual::Dual;
use dynamics::lags::FilterKind;
use dynamics::system::{StateSpace, System, Workspace};
use estimation::matrix_exponential;
use nalgebra::{DMatrix, DVector};

/// An instant meant to lie on an edge may miss it by rounding \[s\].
const EDGE_S: f64 = 1e-9;

/// How a channel reads the linear plant.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Instant,
    /// Over so many seconds; its integral is this extra state.
    Mean {
        extra: usize,
        length_s: f64,
    },
    /// Behind a lag of this time constant; its output is this extra state.
    Lagged {
        extra: usize,
        time_constant_s: f64,
    },
}

/// A channel that has weight.
struct Sensed {
    output: usize,
    variance: f64,
    kind: Kind,
}

/// One reading: when, of which channel, and its row in the columns.
struct Sample {
    instant_s: f64,
    channel: usize,
    row: usize,
}

/// Turns the stacked `columns` (channels with weight one below the other) into whitened ones.
///
/// # Errors
/// The simulator's. Cost: one linearisation and one exponential a period, three products with the
/// covariance a reading.
pub(super) fn whiten(
    noisy: &Plant,
    quiet: &Plant,
    (nominal, weight): (&Recording, &[f64]),
    (duration_s, simulate): (f64, Simulate<'_>),
    columns: &mut [DVector<f64>],
) -> Result<(), Box<dyn core::error::Error>> {
    let (sensed, extras) = channels(quiet, nominal, weight);
    let samples = samples(quiet, nominal, weight, &sensed);
    if noisy.actuators.iter().all(|actuator| actuator.noise.value == 0.0) {
        for sample in &samples {
            let sigma = sensed[sample.channel].variance.sqrt();
            columns.iter_mut().for_each(|column| column[sample.row] /= sigma);
        }
        return Ok(());
    }
    let mut samples = samples.iter().peekable();
    let mut filter: Option<(Filter, Workspace<Dual>)> = None;
    (simulate.motion)(quiet, duration_s, &mut |period| {
        let (filter, workspace) = filter.get_or_insert_with(|| {
            let noise = held_noise(noisy, period.system);
            (Filter::new(period.system, noise, extras, columns.len()), Workspace::new(period.system))
        });
        if period.restarts {
            filter.restart();
        }
        filter.begin(&period.system.linearise(workspace, period.begin_s, period.state, period.inputs), &sensed);
        let mut now_s = period.begin_s;
        // means that end with the record have no period behind them
        let until_s = if period.last { period.end_s + EDGE_S } else { period.end_s - EDGE_S };
        while let Some(sample) = samples.next_if(|sample| sample.instant_s < until_s) {
            filter.advance(sample.instant_s - now_s);
            now_s = now_s.max(sample.instant_s);
            filter.update(&sensed[sample.channel], sample.row, columns);
        }
        filter.advance(period.end_s - now_s);
    })
}

/// Inputs with held noise, and its variance.
fn held_noise(noisy: &Plant, system: &System) -> Vec<(usize, f64)> {
    let variance = |actuator: usize| noisy.actuators[actuator].noise.value * noisy.actuators[actuator].noise.value;
    let commanded = |role| role == dynamics::system::InputRole::Command;
    let inputs = system.inputs().iter().enumerate().filter(|(_, input)| commanded(input.role));
    inputs.map(|(i, input)| (i, variance(input.actuator))).filter(|(_, variance)| *variance > 0.0).collect()
}

/// Channels with weight in the order of the record, and the number of states they need besides the
/// plant's.
fn channels(quiet: &Plant, nominal: &Recording, weight: &[f64]) -> (Vec<Sensed>, usize) {
    let mut extras = 0;
    let mut sensed = Vec::new();
    for (channel, weight) in weighted(nominal, weight) {
        let output = sensor(quiet, channel);
        let sensor = &quiet.sensors[output];
        let lag = sensor.low_pass_hz.map(|cut_off| 1.0 / (core::f64::consts::TAU * cut_off.value));
        let kind = match (sensor.reading, lag) {
            (Reading::Mean, _) => {
                let length_s = sensor.period_s.map_or(quiet.simulation.period_s, |period| period.value);
                Kind::Mean { extra: extras, length_s }
            }
            (Reading::Instant, Some(time_constant_s)) if time_constant_s > 0.0 => {
                Kind::Lagged { extra: extras, time_constant_s }
            }
            _ => Kind::Instant,
        };
        extras += usize::from(!matches!(kind, Kind::Instant));
        sensed.push(Sensed { output, variance: 1.0 / (weight * weight), kind });
    }
    (sensed, extras)
}

fn weighted<'a>(nominal: &'a Recording, weight: &'a [f64]) -> impl Iterator<Item = (&'a Channel, f64)> {
    nominal.channels.iter().zip(weight.iter().copied()).filter(|(_, weight)| *weight > 0.0)
}

fn sensor(quiet: &Plant, channel: &Channel) -> usize {
    let found = quiet.sensors.iter().position(|sensor| sensor.name == channel.name);
    found.expect("a channel with weight is a sensor's")
}

/// All readings in the order of what they tell of.
fn samples(quiet: &Plant, nominal: &Recording, weight: &[f64], sensed: &[Sensed]) -> Vec<Sample> {
    let mut samples = Vec::new();
    let mut row = 0;
    for (index, (channel, _)) in weighted(nominal, weight).enumerate() {
        let sensor = &quiet.sensors[sensed[index].output];
        let source = sensor.source.as_ref().and_then(|name| quiet.sources.iter().find(|source| source.name == *name));
        let (offset_s, skew) = source.map_or((0.0, 0.0), |s| (s.clock_offset_s.value, s.clock_skew.value));
        let of_effects = quiet
            .effects
            .iter()
            .filter(|used| used.site.name == sensor.name)
            .filter_map(|used| effect_delay_s(quiet, used));
        let delay_s = sensor.delay_s.value + of_effects.sum::<f64>();
        let length_s = if let Kind::Mean { length_s, .. } = sensed[index].kind { length_s } else { 0.0 };
        for stamp_s in &channel.time_s {
            let instant_s = (stamp_s - offset_s) / (1.0 + skew) - delay_s + length_s;
            samples.push(Sample { instant_s, channel: index, row });
            row += 1;
        }
    }
    samples.sort_by(|a, b| a.instant_s.total_cmp(&b.instant_s));
    samples
}

fn effect_delay_s(quiet: &Plant, used: &dynamics::description::EffectUse) -> Option<f64> {
    let entry = quiet.catalogue.effect(&used.kind)?;
    let dynamics::effect::Law::SensorFilter(filter) = entry.law else { return None };
    let kind: FilterKind = filter(&dynamics::effect::values(entry, used).ok()?);
    Some(kind.delay_s())
}

/// A Kalman filter of `[δx; w; extras]`, and what it makes of every column.
struct Filter {
    states: usize,
    noise: Vec<(usize, f64)>,
    /// Rates of all its states.
    rates: DMatrix<f64>,
    /// Rows of the readings: by output.
    readings: DMatrix<f64>,
    covariance: DMatrix<f64>,
    /// One column per parameter.
    estimate: DMatrix<f64>,
}

impl Filter {
    fn new(system: &System, noise: Vec<(usize, f64)>, extras: usize, columns: usize) -> Self {
        let states = system.states().len();
        let n = states + noise.len() + extras;
        Self {
            states,
            noise,
            rates: DMatrix::zeros(n, n),
            readings: DMatrix::zeros(system.outputs().len(), n),
            covariance: DMatrix::zeros(n, n),
            estimate: DMatrix::zeros(n, columns),
        }
    }

    /// The state is known: what is uncertain of it is a parameter.
    fn restart(&mut self) {
        self.covariance.fill(0.0);
        self.estimate.fill(0.0);
    }

    /// A period begins: new noise is held, the equations are linear about its beginning.
    fn begin(&mut self, about: &StateSpace, sensed: &[Sensed]) {
        let (n, m) = (self.states, self.noise.len());
        for k in 0..m {
            self.forget(n + k);
            self.covariance[(n + k, n + k)] = self.noise[k].1;
        }
        self.rates.fill(0.0);
        self.rates.view_mut((0, 0), (n, n)).copy_from(&about.a);
        self.readings.view_mut((0, 0), about.c.shape()).copy_from(&about.c);
        for (k, (input, _)) in self.noise.iter().enumerate() {
            self.rates.view_mut((0, n + k), (n, 1)).copy_from(&about.b.column(*input));
            self.readings.column_mut(n + k).copy_from(&about.d.column(*input));
        }
        for channel in sensed {
            let (extra, gain) = match channel.kind {
                Kind::Instant => continue,
                Kind::Mean { extra, .. } => (extra, 1.0),
                Kind::Lagged { extra, time_constant_s } => (extra, 1.0 / time_constant_s),
            };
            let row = n + m + extra;
            let reading = self.readings.row(channel.output) * gain;
            self.rates.row_mut(row).copy_from(&reading);
            if let Kind::Lagged { .. } = channel.kind {
                self.rates[(row, row)] = -gain;
            }
        }
    }

    fn advance(&mut self, length_s: f64) {
        if length_s <= EDGE_S {
            return;
        }
        let phi = transition(&self.rates * length_s);
        self.estimate = &phi * &self.estimate;
        let moved = &phi * &self.covariance * phi.transpose();
        // rounding that is not symmetric grows where the plant runs away
        self.covariance = (&moved + moved.transpose()) * 0.5;
    }

    /// Takes one reading of every column; writes its innovation over its standard deviation in its
    /// place.
    fn update(&mut self, channel: &Sensed, row: usize, columns: &mut [DVector<f64>]) {
        let first = self.states + self.noise.len();
        let n = self.covariance.nrows();
        let h = match channel.kind {
            Kind::Instant => self.readings.row(channel.output).transpose(),
            Kind::Mean { extra, length_s } => {
                DVector::from_fn(n, |i, _| if i == first + extra { 1.0 / length_s } else { 0.0 })
            }
            Kind::Lagged { extra, .. } => DVector::from_fn(n, |i, _| if i == first + extra { 1.0 } else { 0.0 }),
        };
        let seen = &self.covariance * &h;
        let variance = h.dot(&seen) + channel.variance;
        let deviation = variance.sqrt();
        for (p, column) in columns.iter_mut().enumerate() {
            let innovation = column[row] - h.dot(&self.estimate.column(p));
            self.estimate.column_mut(p).axpy(innovation / variance, &seen, 1.0);
            column[row] = innovation / deviation;
        }
        self.covariance.ger(-1.0 / variance, &seen, &seen, 1.0);
        if let Kind::Mean { extra, .. } = channel.kind {
            self.forget(first + extra);
        }
    }

    /// One state begins anew at zero.
    fn forget(&mut self, state: usize) {
        self.covariance.row_mut(state).fill(0.0);
        self.covariance.column_mut(state).fill(0.0);
        self.estimate.row_mut(state).fill(0.0);
    }
}

/// `e^m`, by the first terms of the series where the step is short.
fn transition(m: DMatrix<f64>) -> DMatrix<f64> {
    const TERMS: u32 = 8;
    // 0.1⁹/9! = 3e-15 is left
    if m.norm() > 0.1 {
        return matrix_exponential(m);
    }
    let identity = DMatrix::<f64>::identity(m.nrows(), m.ncols());
    let mut sum = identity.clone();
    for term in (1..=TERMS).rev() {
        sum = &identity + &m * sum / f64::from(term);
    }
    sum
}
