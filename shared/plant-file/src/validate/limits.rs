//! Sizes that would not end or not fit in memory, and signals too fast to be followed: mostly
//! mistakes of unit.

use super::{At, Check, Place};
use dynamics::description::{Reading, Sensor, Signal, SignalKind, SiteKind};
use dynamics::effect::{Law, values};

/// Shortest time between samples [s]; more would be a mistake of unit.
const PERIOD_S_MIN: f64 = 1e-6;
/// Integration steps, or samples of one channel, in one control period.
const PER_PERIOD_MAX: f64 = 1e4;
/// Control periods that a delay or a mean reaches back: all of them are kept.
const REACH_PERIODS_MAX: f64 = 1e5;
/// Samples of all channels of a record: 1.6 GB.
const SAMPLES_MAX: f64 = 1e8;
/// Sinusoids of one signal: each costs a sine per period.
const HARMONICS_MAX: u32 = 10_000;

impl Check<'_> {
    pub(super) fn sizes(&mut self) {
        let settings = &self.plant.simulation;
        let (period_s, step_s) = (settings.period_s, settings.step_s);
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if ![settings.duration_s, period_s, step_s].into_iter().all(positive) {
            return; // reported
        }
        let at = At::new("simulation", 0, "");
        if period_s < PERIOD_S_MIN {
            let message = format!("period of the simulation is {period_s} s");
            self.fault(&at, "period", message, "a microsecond at least; is the unit right?");
        }
        if period_s / step_s > PER_PERIOD_MAX {
            let message = format!("a period of {period_s} s takes {:.3e} steps of {step_s} s", period_s / step_s);
            self.fault(&at, "step", message, format!("at most {PER_PERIOD_MAX} are possible; is the unit right?"));
            self.because_of([at.place("period")]);
        } else if step_s > period_s * (1.0 + 1e-9) {
            let message = format!("step of the simulation is longer than its period: {step_s} s > {period_s} s");
            self.warn(&at, "step", message, "no step goes beyond a period: leave it out");
            self.because_of([at.place("period")]);
        }
        let samples = self.channels(period_s);
        self.actuator_delays(period_s);
        self.record(&at, samples);
    }

    /// Checks the timing of every sensor; returns samples per second of the record.
    fn channels(&mut self, period_s: f64) -> f64 {
        let plant = self.plant;
        let recorded = plant.actuators.iter().filter(|actuator| actuator.recorded).count();
        let mut samples_per_s = (recorded as f64).max(1.0) / period_s;
        for (i, sensor) in plant.sensors.iter().enumerate() {
            let at = At::new("sensor", i, &sensor.name);
            let own_s = sensor.period_s.map_or(period_s, |period| period.value);
            if !(own_s > 0.0 && own_s.is_finite()) {
                continue; // reported
            }
            if own_s < PERIOD_S_MIN || period_s / own_s > PER_PERIOD_MAX {
                let message = format!("period of {} is {own_s} s; the simulation's is {period_s} s", at.what);
                let cure = format!("a microsecond at least, and at most {PER_PERIOD_MAX} samples in one period");
                self.fault(&at, "period", message, cure);
                self.because_of([simulation("period")]);
                continue;
            }
            samples_per_s += 1.0 / own_s;
            self.reach(&at, sensor, own_s, period_s);
        }
        samples_per_s
    }

    /// How far back a sensor looks.
    fn reach(&mut self, at: &At, sensor: &Sensor, own_s: f64, period_s: f64) {
        let site_delay_s = self.delay_of_effects_s(SiteKind::Sensor, &sensor.name);
        let delay_s = sensor.delay_s.value + site_delay_s;
        let mean_s = if sensor.reading == Reading::Mean { 2.0 * own_s } else { 0.0 };
        let periods = (delay_s + mean_s) / period_s;
        if periods > REACH_PERIODS_MAX {
            let (key, what) = if delay_s >= mean_s { ("delay", "delay") } else { ("period", "mean") };
            let message = format!("the {what} of {} reaches back over {periods:.3e} control periods", at.what);
            self.fault(at, key, message, format!("at most {REACH_PERIODS_MAX:e} are kept; is the unit right?"));
            self.because_of([simulation("period")]);
        }
    }

    fn actuator_delays(&mut self, period_s: f64) {
        let plant = self.plant;
        for (i, actuator) in plant.actuators.iter().enumerate() {
            let at = At::new("actuator", i, &actuator.name);
            let periods = self.delay_of_effects_s(SiteKind::Actuator, &actuator.name) / period_s;
            if periods > REACH_PERIODS_MAX {
                let message = format!("effects delay {} by {periods:.3e} control periods", at.what);
                self.fault(&at, "name", message, format!("at most {REACH_PERIODS_MAX:e} are kept; is the unit right?"));
                self.because_of([simulation("period")]);
            }
        }
    }

    fn delay_of_effects_s(&self, kind: SiteKind, name: &str) -> f64 {
        let here = |effect: &&dynamics::description::EffectUse| effect.site.kind == kind && effect.site.name == name;
        let delay_s = |used: &dynamics::description::EffectUse| {
            let entry = self.plant.catalogue.effect(&used.kind)?;
            let (Law::SensorFilter(filter) | Law::ActuatorFilter(filter)) = entry.law else { return None };
            Some(filter(&values(entry, used).ok()?).delay_s())
        };
        self.plant.effects.iter().filter(here).filter_map(delay_s).sum()
    }

    fn record(&mut self, at: &At, samples_per_s: f64) {
        let samples = samples_per_s * self.plant.simulation.duration_s;
        if samples > SAMPLES_MAX {
            let message = format!("the record would hold {samples:.3e} samples");
            let cure = format!("at most {SAMPLES_MAX:e}: a shorter duration, longer periods, or fewer channels");
            self.fault(at, "duration", message, cure);
            let sensors = (0..self.plant.sensors.len()).map(|i| At::new("sensor", i, "").place("period"));
            self.because_of(sensors.chain([at.place("period")]));
        }
    }

    pub(super) fn harmonics(&mut self, at: &At, first: u32, last: u32) {
        if last.saturating_sub(first) >= HARMONICS_MAX {
            let message = format!("{} has {} harmonics", at.what, u64::from(last) - u64::from(first) + 1);
            self.fault(at, "last", message, format!("at most {HARMONICS_MAX}; their frequency is k / period"));
        }
    }

    /// What is held over `held_s` cannot swing faster than at half its rate.
    pub(super) fn slow_enough(&mut self, at: &At, signal: &Signal, held_s: f64) {
        let Some((key, frequency_hz)) = fastest(&signal.kind) else { return };
        let limit_hz = 0.5 / held_s;
        if limit_hz > 0.0 && limit_hz.is_finite() && frequency_hz > limit_hz * (1.0 + 1e-9) {
            let message = format!(
                "{} reaches {frequency_hz} Hz, more than the {limit_hz} Hz that can be followed every {held_s} s",
                at.what
            );
            self.warn(at, key, message, "a shorter period of the simulation, or a lower frequency");
            self.because_of([simulation("period"), simulation("step"), at.place("period")]);
        }
    }
}

fn simulation(key: &str) -> Place {
    At::new("simulation", 0, "").place(key)
}

/// Highest frequency of a periodic term, and the key that states it.
fn fastest(kind: &SignalKind) -> Option<(&'static str, f64)> {
    match kind {
        SignalKind::Sine { frequency_hz, .. } | SignalKind::Square { frequency_hz, .. } => {
            Some(("frequency", frequency_hz.value))
        }
        SignalKind::Multisine { period_s, last, .. } => Some(("last", f64::from(*last) / period_s.value)),
        SignalKind::Chirp { begin_hz, end_hz, .. } if begin_hz.value > end_hz.value => {
            Some(("begin_frequency", begin_hz.value))
        }
        SignalKind::Chirp { end_hz, .. } => Some(("end_frequency", end_hz.value)),
        SignalKind::Fourier { period_s, sine, .. } => Some(("period", sine.len() as f64 / period_s.value)),
        _ => None,
    }
}

/// The lowest value that a sum of terms surely takes, and a term that takes it there; `None` where
/// nothing can be said.
pub(super) fn lowest(signals: &[Signal]) -> Option<(f64, usize)> {
    let bounds: Vec<Option<f64>> = signals.iter().map(|signal| lowest_of(&signal.kind)).collect();
    let active =
        |signal: &Signal, t_s: f64| t_s >= signal.begin_s.value && signal.end_s.is_none_or(|end| t_s < end.value);
    let mut least: Option<(f64, usize)> = None;
    // between two beginnings and ends the same terms act
    for edge in signals {
        let t_s = edge.begin_s.value.max(0.0);
        let (mut sum, mut worst) = (0.0, (0.0, 0));
        for (k, _) in signals.iter().enumerate().filter(|(_, signal)| active(signal, t_s)) {
            let value = bounds[k]?;
            sum += value;
            worst = if value < worst.0 { (value, k) } else { worst };
        }
        if least.is_none_or(|(value, _)| sum < value) {
            least = Some((sum, worst.1));
        }
    }
    least
}

fn lowest_of(kind: &SignalKind) -> Option<f64> {
    Some(match kind {
        SignalKind::Constant { value } | SignalKind::Step { size: value } => value.value,
        SignalKind::Sine { amplitude, .. } | SignalKind::Square { amplitude, .. } => -amplitude.value.abs(),
        SignalKind::Chirp { amplitude, .. } => -amplitude.value.abs(),
        // without mean; as low as its root mean square at least
        SignalKind::Multisine { rms, .. } => -rms.value.abs(),
        SignalKind::Pulse { size, .. } | SignalKind::Slew { size, .. } => size.value.min(0.0),
        SignalKind::Staircase { step, .. } => step.value,
        SignalKind::Table { value, .. } => value.iter().copied().fold(f64::INFINITY, f64::min),
        SignalKind::Fourier { .. } => return None,
    })
}
