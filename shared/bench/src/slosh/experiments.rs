//! Force records of BP2 beside the seed's sine: a burst with coasting, and repeated bursts within a
//! stroke.

use dynamics::description::{Plant, Quantity, Signal, SignalKind};

/// A signal from `begin_s` to `end_s`.
fn between(kind: SignalKind, begin_s: f64, end_s: f64) -> Signal {
    Signal { kind, begin_s: Quantity::known(begin_s), end_s: Some(Quantity::known(end_s)) }
}

/// Whole cycles of a square wave of force at the slosh mode, then nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bursts {
    pub amplitude_n: f64,
    /// Cycles of one burst.
    pub cycles: u32,
    /// Half of it a multiple of the sample interval.
    pub cycle_s: f64,
    /// From one burst to the next.
    pub repeat_s: f64,
    /// End of the record.
    pub duration_s: f64,
}

impl Bursts {
    /// Replaces the first actuator's command, and the duration.
    pub(super) fn command(&self, plant: &mut Plant) {
        let length_s = f64::from(self.cycles) * self.cycle_s;
        let signals = self.begins_s().map(|begin_s| {
            let (amplitude, frequency_hz) = (Quantity::known(self.amplitude_n), Quantity::known(1.0 / self.cycle_s));
            between(SignalKind::Square { amplitude, frequency_hz }, begin_s, begin_s + length_s)
        });
        plant.actuators[0].command = signals.collect();
        plant.simulation.duration_s = self.duration_s;
    }

    fn begins_s(self) -> impl Iterator<Item = f64> {
        let bursts = ((self.duration_s - f64::from(self.cycles) * self.cycle_s) / self.repeat_s).floor() as u32 + 1;
        (0..bursts).map(move |k| f64::from(k) * self.repeat_s)
    }
}

/// Replaces the first actuator's command by single cycles of a square wave, one after the other,
/// and the duration.
pub(super) fn quicken(plant: &mut Plant, amplitude_n: f64, cycles_s: &[f64], duration_s: f64) {
    let mut begin_s = 0.0;
    let cycle = |cycle_s: &f64| {
        let (amplitude, frequency_hz) = (Quantity::known(amplitude_n), Quantity::known(1.0 / cycle_s));
        let signal = between(SignalKind::Square { amplitude, frequency_hz }, begin_s, begin_s + cycle_s);
        begin_s += cycle_s;
        signal
    };
    plant.actuators[0].command = cycles_s.iter().map(cycle).collect();
    plant.simulation.duration_s = duration_s;
}
