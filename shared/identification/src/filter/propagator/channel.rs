//! How a sensor stamps, delays and lags what it reads.

use dynamics::description::{Plant, Reading, Sensor};
use dynamics::lags::{FilterKind, Lag};
use dynamics::system::{FilterPlace, System};

/// Clock, delay and lag of one sensor.
pub(super) struct Channel {
    pub mean: bool,
    /// Stamp = (1 + skew) t + offset; delay on top.
    pub offset_s: f64,
    pub skew: f64,
    pub delay_s: f64,
    pub delay_is_unknown: bool,
    pub lag: Option<Lag>,
}

impl Channel {
    /// Whether a sample is taken at another time than its stamp: clock offset, skew, delay, or
    /// `shift_s` [s].
    pub fn shifted(&self, shift_s: f64) -> bool {
        self.offset_s != 0.0 || self.skew != 0.0 || self.delay_s != 0.0 || shift_s != 0.0
    }
}

pub(super) fn channel(plant: &Plant, system: &System, sensor: &Sensor, index: usize) -> Channel {
    let own = || system.filters().iter().filter(|filter| filter.place == FilterPlace::Output(index));
    let source = sensor.source.as_ref().and_then(|name| plant.sources.iter().find(|source| source.name == *name));
    // two lags of first order in series act as one of the sum, to second order
    let time_constants = own().filter_map(|filter| match filter.kind {
        FilterKind::FirstOrder { time_constant_s } => Some(time_constant_s),
        _ => None,
    });
    let low_pass = sensor.low_pass_hz.map_or(0.0, |f| 1.0 / (core::f64::consts::TAU * f.value));
    let total = low_pass + time_constants.sum::<f64>();
    Channel {
        mean: sensor.reading == Reading::Mean,
        offset_s: source.map_or(0.0, |source| source.clock_offset_s.value),
        skew: source.map_or(0.0, |source| source.clock_skew.value),
        delay_s: sensor.delay_s.value + own().map(|filter| filter.kind.delay_s()).sum::<f64>(),
        delay_is_unknown: sensor.delay_s.sigma.is_some() || own().any(|f| matches!(f.kind, FilterKind::Delay { .. })),
        lag: Lag::new(FilterKind::FirstOrder { time_constant_s: total }),
    }
}
