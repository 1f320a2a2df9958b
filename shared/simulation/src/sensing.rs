//! What the sensors make of the true readings: lag and delay, then noise, then range, then
//! quantisation; sample times and stamps.
//!
//! A channel has its own period. Sample n belongs to the instant `n · period`, plus jitter where
//! the plant states it; its noise is number n of the stream named after the sensor, so that no
//! channel knows of another. A delayed channel is read at the earlier instant and stamped with its
//! own.

use super::SimulationError;
use super::history::History;
use super::motion::Dynamics;
use crate::sensor::{quantise, random_walk_sample_sigma};
use dynamics::description::{Noise, Plant, Reading, Sensor};
use dynamics::lags::{FilterKind, Lag, LagState};
use dynamics::noise::Stream;
use dynamics::signal::EDGE_S;
use dynamics::system::{FilterPlace, System};
use serde::{Deserialize, Serialize};

/// Shortest time between samples [s]; more would be a mistake of unit.
const PERIOD_S_MIN: f64 = 1e-6;
/// Sample times stay in order: jitter is cut at this share of the period.
const JITTER_SHARE_MAX: f64 = 0.45;

/// One sample of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Index in `Plant::sensors`.
    pub channel: usize,
    /// By the clock of its source; of a mean: the beginning of the interval.
    pub time_s: f64,
    pub value: f64,
    /// The same before noise, range and quantisation.
    pub noise_free: f64,
}

/// What a channel remembers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ChannelState {
    /// Number of the next sample.
    pub next: u64,
    /// Last measured value; nothing before the first.
    pub latest: Option<f64>,
}

/// What the sensors remember.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SensorsState {
    pub channels: Vec<ChannelState>,
    /// Of all channels, one after the other: at the present instant, or of a mean at its last
    /// sample.
    pub lags: Vec<LagState>,
    /// The lags have taken their first value.
    pub settled: bool,
}

/// One channel.
#[derive(Clone, Debug)]
pub(crate) struct Channel {
    pub period_s: f64,
    pub mean: bool,
    pub delay_s: f64,
    pub lags: Vec<Lag>,
    /// Where its lags are in [`SensorsState::lags`].
    lag_at: usize,
    sigma: f64,
    stream: Stream,
    /// Number of the last sample and its noise.
    noise: (u64, f64),
    range: f64,
    resolution: f64,
    jitter_s: f64,
    jitter_stream: Stream,
    clock: [f64; 2],
}

/// The noise of a sensor's samples.
fn noise_of(sensor: &Sensor, seed: u64, prefix: &str) -> Stream {
    Stream::of_parts(seed, &[prefix, ".", &sensor.name])
}

/// The jitter of the clock that samples a sensor.
fn jitter_of(sensor: &Sensor, seed: u64, prefix: &str) -> Stream {
    Stream::of_parts(seed, &[prefix, ".clock.", sensor.source.as_deref().unwrap_or("")])
}

impl Channel {
    fn new(
        plant: &Plant,
        sensor: &Sensor,
        own: Vec<FilterKind>,
        seed: u64,
        prefix: &str,
    ) -> Result<Self, SimulationError> {
        let period_s = sensor.period_s.map_or(plant.simulation.period_s, |period| period.value);
        let setting = |what: &str, value: f64, why| {
            Err(SimulationError::Setting { what: format!("{what} of sensor '{}'", sensor.name), value, why })
        };
        if !(period_s >= PERIOD_S_MIN && period_s.is_finite()) {
            return setting("period", period_s, "must be at least a microsecond");
        }
        let low_pass = sensor.low_pass_hz.and_then(|cut_off| Lag::low_pass(cut_off.value));
        let delay_s = sensor.delay_s.value + own.iter().map(FilterKind::delay_s).sum::<f64>();
        if !(delay_s >= 0.0 && delay_s.is_finite()) {
            return setting("delay", delay_s, "must not be negative");
        }
        let sigma = match sensor.noise {
            Noise::PerSample(sigma) => sigma.value,
            Noise::Density(density) => random_walk_sample_sigma(density.value, period_s),
        };
        Ok(Self {
            period_s,
            mean: sensor.reading == Reading::Mean,
            delay_s,
            lags: low_pass.into_iter().chain(own.into_iter().filter_map(Lag::new)).collect(),
            lag_at: 0,
            sigma,
            stream: noise_of(sensor, seed, prefix),
            noise: (u64::MAX, 0.0),
            range: sensor.range.map_or(f64::INFINITY, |range| range.value),
            resolution: sensor.resolution.value,
            jitter_s: plant.simulation.jitter_s,
            jitter_stream: jitter_of(sensor, seed, prefix),
            clock: clock(plant, sensor)?,
        })
    }

    /// True instant of sample `n` of a record that began at `start_s`. Channels of one source and
    /// period jitter together.
    fn instant_s(&self, start_s: f64, n: u64) -> f64 {
        let nominal = start_s + n as f64 * self.period_s;
        if self.jitter_s == 0.0 {
            return nominal;
        }
        let limit = JITTER_SHARE_MAX * self.period_s;
        let jitter = self.jitter_s * self.jitter_stream.normal(self.number(start_s, n));
        (nominal + jitter.clamp(-limit, limit)).max(start_s)
    }

    /// Number of the sample in its stream: records that begin later do not repeat the noise of
    /// earlier ones.
    fn number(&self, start_s: f64, n: u64) -> u64 {
        if start_s == 0.0 {
            return n;
        }
        n + libm::round(start_s / self.period_s).max(0.0) as u64
    }

    /// A controller and the record take the same sample: its noise is computed once.
    fn measure(&mut self, truth: f64, number: u64) -> f64 {
        // a perfect channel costs no random number
        if self.sigma > 0.0 && self.noise.0 != number {
            self.noise = (number, self.sigma * self.stream.normal(number));
        }
        quantise((truth + self.noise.1).clamp(-self.range, self.range), self.resolution)
    }

    fn stamp_s(&self, t_s: f64) -> f64 {
        let [offset_s, skew] = self.clock;
        t_s + skew * t_s + offset_s
    }

    fn lag_states<'a>(&self, lags: &'a [LagState]) -> &'a [LagState] {
        &lags[self.lag_at..self.lag_at + self.lags.len()]
    }
}

/// Offset and skew of the sensor's source.
fn clock(plant: &Plant, sensor: &Sensor) -> Result<[f64; 2], SimulationError> {
    let Some(name) = &sensor.source else { return Ok([0.0; 2]) };
    let source = plant.sources.iter().find(|source| source.name == *name);
    source
        .map(|source| [source.clock_offset_s.value, source.clock_skew.value])
        .ok_or_else(|| SimulationError::UnknownSource { sensor: sensor.name.clone(), source_name: name.clone() })
}

/// All sensors of a plant, and scratch for their reading.
pub(crate) struct Sensors {
    pub channels: Vec<Channel>,
    lag_count: usize,
    x: Vec<f64>,
    u: Vec<f64>,
    x_end: Vec<f64>,
    u_end: Vec<f64>,
    y: Vec<f64>,
    y_mean: Vec<f64>,
    /// Instant, slot and age of the readings in `y`; of the mean in `y_mean`, its two instants.
    y_instant: Option<(f64, usize, f64)>,
    mean_interval: Option<[f64; 2]>,
}

impl Sensors {
    /// The sensors of a plant; noise streams are named by `prefix` and the sensor.
    ///
    /// # Errors
    /// [`SimulationError`] where a sensor's filter or timing cannot be simulated.
    pub fn new(plant: &Plant, system: &System, seed: u64, prefix: &str) -> Result<Self, SimulationError> {
        let mut channels = Vec::with_capacity(plant.sensors.len());
        let mut lag_count = 0;
        for (output, sensor) in plant.sensors.iter().enumerate() {
            let own = system.filters().iter().filter(|filter| filter.place == FilterPlace::Output(output));
            let mut channel = Channel::new(plant, sensor, own.map(|filter| filter.kind).collect(), seed, prefix)?;
            channel.lag_at = lag_count;
            lag_count += channel.lags.len();
            channels.push(channel);
        }
        let (n, m, outputs) = (system.states().len(), system.inputs().len(), channels.len());
        Ok(Self {
            channels,
            lag_count,
            x: vec![0.0; n],
            u: vec![0.0; m],
            x_end: vec![0.0; n],
            u_end: vec![0.0; m],
            y: vec![0.0; outputs],
            y_mean: vec![0.0; outputs],
            y_instant: None,
            mean_interval: None,
        })
    }

    /// Noise of other streams from now on: those that [`Sensors::new`] names for `seed` and
    /// `prefix`.
    pub fn draw_from(&mut self, plant: &Plant, seed: u64, prefix: &str) {
        for (channel, sensor) in self.channels.iter_mut().zip(&plant.sensors) {
            channel.stream = noise_of(sensor, seed, prefix);
            channel.jitter_stream = jitter_of(sensor, seed, prefix);
            channel.noise = (u64::MAX, 0.0);
        }
    }

    /// First-order lags of all sensors together.
    pub fn lag_count(&self) -> usize {
        self.lag_count
    }

    /// Some instantaneous channel lags, so that its input must be followed through every piece.
    pub fn follows_lags(&self) -> bool {
        self.channels.iter().any(|channel| !channel.mean && !channel.lags.is_empty())
    }

    /// How far back a reading may reach [s].
    pub fn span_s(&self) -> f64 {
        let reach = |channel: &Channel| {
            let interval = if channel.mean { 2.0 * channel.period_s } else { 0.0 };
            let jitter = if channel.jitter_s > 0.0 { JITTER_SHARE_MAX * channel.period_s } else { 0.0 };
            channel.delay_s + interval + jitter
        };
        self.channels.iter().map(reach).fold(0.0, f64::max)
    }

    /// Most samples that one control period can bring.
    pub fn samples_max(&self, period_s: f64) -> usize {
        self.channels.iter().map(|channel| libm::ceil(period_s / channel.period_s) as usize + 2).sum()
    }

    /// The state before the first period: no sample taken, lags not settled.
    pub fn start(&self) -> SensorsState {
        SensorsState {
            channels: vec![ChannelState::default(); self.channels.len()],
            lags: vec![LagState::default(); self.lag_count],
            settled: false,
        }
    }

    /// Some channel is read at the very beginning of a period.
    pub fn read_beginnings(&self) -> bool {
        self.channels.iter().any(|channel| !channel.mean && channel.delay_s == 0.0 && channel.jitter_s == 0.0)
    }

    /// Readings of an instant that is the beginning of the piece in `slot`; they stand until
    /// [`forget`](Self::forget).
    pub fn know(&mut self, t_s: f64, slot: usize, y: &[f64]) {
        self.y.copy_from_slice(y);
        self.y_instant = Some((t_s, slot, 0.0));
    }

    /// Forgets the readings that are known.
    pub fn forget(&mut self) {
        self.y_instant = None;
    }

    /// Settles the lags on the first readings.
    pub fn settle(&self, state: &mut SensorsState, y: &[f64]) {
        for (channel, value) in self.channels.iter().zip(y) {
            let end = channel.lag_at + channel.lags.len();
            state.lags[channel.lag_at..end].fill(LagState::settled(*value));
        }
        state.settled = true;
    }

    /// Moves the lags of instantaneous channels over a piece, from the readings at its beginning to
    /// those at its end.
    pub fn follow(&self, state: &mut SensorsState, from: &[f64], to: &[f64], length_s: f64) {
        for (channel, (from, to)) in self.channels.iter().zip(from.iter().zip(to)) {
            if channel.mean {
                continue;
            }
            let (mut from, mut to) = (*from, *to);
            for (lag, lag_state) in channel.lags.iter().zip(&mut state.lags[channel.lag_at..]) {
                let before = lag_state.output;
                to = lag.ramp(lag_state, from, to, length_s);
                from = before;
            }
        }
    }

    /// What channel `index` says to a controller at `t_s`, the beginning of a period; `y` holds the
    /// readings of that instant.
    ///
    /// A channel that has no sample now repeats its last one; a mean says its last complete
    /// interval. Times are exact here: jitter is in the record.
    pub fn feedback(
        &mut self,
        dynamics: &mut Dynamics,
        history: &History,
        state: &mut SensorsState,
        index: usize,
        (start_s, t_s): (f64, f64),
        y: &[f64],
    ) -> f64 {
        let channel = &self.channels[index];
        let ChannelState { next, latest } = state.channels[index];
        let due = start_s + next as f64 * channel.period_s <= t_s + EDGE_S;
        if let (Some(latest), true) = (latest, channel.mean || !due) {
            return latest;
        }
        let number = channel.number(start_s, next);
        let truth = if channel.delay_s >= EDGE_S && state.settled && t_s > start_s {
            self.y_instant = None;
            self.instant(dynamics, history, index, t_s - channel.delay_s)
        } else if channel.lags.is_empty() || !state.settled {
            y[index]
        } else {
            channel.lag_states(&state.lags)[channel.lags.len() - 1].output
        };
        let value = self.channels[index].measure(truth, number);
        state.channels[index].latest = Some(value);
        value
    }

    /// Takes all samples that are complete at `end_s`.
    pub fn sample(
        &mut self,
        dynamics: &mut Dynamics,
        history: &History,
        state: &mut SensorsState,
        (start_s, end_s): (f64, f64),
        samples: &mut Vec<Sample>,
    ) {
        self.mean_interval = None;
        for index in 0..self.channels.len() {
            while let Some(sample) = self.next(dynamics, history, state, index, (start_s, end_s)) {
                samples.push(sample);
            }
        }
    }

    /// The next sample of channel `index`, if it is complete at `end_s`.
    fn next(
        &mut self,
        dynamics: &mut Dynamics,
        history: &History,
        state: &mut SensorsState,
        index: usize,
        (start_s, end_s): (f64, f64),
    ) -> Option<Sample> {
        let channel = &self.channels[index];
        let n = state.channels[index].next;
        let nominal_s = |n: u64| start_s + n as f64 * channel.period_s;
        let (instant_s, delay_s) = (channel.instant_s(start_s, n), channel.delay_s);
        let noise_free = if channel.mean {
            let until_s = channel.instant_s(start_s, n + 1);
            if until_s.max(nominal_s(n + 1)) > end_s + EDGE_S {
                return None;
            }
            self.mean(dynamics, history, state, index, [instant_s - delay_s, until_s - delay_s])
        } else {
            // the inputs of an instant are known once its period has begun
            if instant_s.max(nominal_s(n)) >= end_s - EDGE_S {
                return None;
            }
            self.instant(dynamics, history, index, instant_s - delay_s)
        };
        let channel = &mut self.channels[index];
        let value = channel.measure(noise_free, channel.number(start_s, n));
        state.channels[index] = ChannelState { next: n + 1, latest: Some(value) };
        Some(Sample { channel: index, time_s: channel.stamp_s(instant_s), value, noise_free })
    }

    /// Reading of channel `index` at `t_s`, behind its lags.
    fn instant(&mut self, dynamics: &mut Dynamics, history: &History, index: usize, t_s: f64) -> f64 {
        let (slot, since_s) = match self.y_instant {
            Some((cached_s, slot, since_s)) if cached_s == t_s => (slot, since_s),
            _ => {
                let (slot, since_s) = history.state_at(dynamics, t_s, &mut self.x, &mut self.u);
                dynamics.read(t_s, &self.x, &self.u, &mut self.y);
                self.y_instant = Some((t_s, slot, since_s));
                (slot, since_s)
            }
        };
        let channel = &self.channels[index];
        let mut to = self.y[index];
        if channel.lags.is_empty() {
            return to;
        }
        let (lags, from) = history.lagged(slot);
        let lags = channel.lag_states(lags);
        if since_s == 0.0 {
            return lags[lags.len() - 1].output;
        }
        let mut from = from[index];
        for (lag, mut state) in channel.lags.iter().zip(lags.iter().copied()) {
            let before = state.output;
            to = lag.ramp(&mut state, from, to, since_s);
            from = before;
        }
        to
    }

    /// Mean reading of channel `index` over an interval; its lags take the mean as held.
    fn mean(
        &mut self,
        dynamics: &mut Dynamics,
        history: &History,
        state: &mut SensorsState,
        index: usize,
        interval_s: [f64; 2],
    ) -> f64 {
        let [begin_s, end_s] = interval_s;
        if self.mean_interval != Some(interval_s) {
            history.state_at(dynamics, begin_s, &mut self.x, &mut self.u);
            history.state_at(dynamics, end_s, &mut self.x_end, &mut self.u_end);
            self.y_instant = None;
            dynamics.system.read_mean(
                &mut dynamics.workspace,
                begin_s,
                end_s - begin_s,
                &self.x,
                &self.u,
                &self.x_end,
                &self.u_end,
                &mut self.y_mean,
            );
            self.mean_interval = Some(interval_s);
        }
        let channel = &self.channels[index];
        let mut value = self.y_mean[index];
        for (lag, lag_state) in channel.lags.iter().zip(&mut state.lags[channel.lag_at..]) {
            value = lag.hold(lag_state, value, end_s - begin_s);
        }
        value
    }
}
