//! Attitudes read as rotation vectors, which are told apart by whole turns alone:
//!
//! ```text
//! r and r (1 − 2π/|r|) are the same rotation
//! ```
//!
//! A tracker that turns on past half a turn jumps from one to the other. The prediction takes the
//! one of the two that is nearer to the reading.

use crate::problem::{Event, Timeline};
use core::f64::consts::TAU;
use dynamics::description::{Plant, SensorKind, Space};

/// Cosine between axes up to which they are square to each other.
const SQUARE: f64 = 1e-6;

/// Channels of one rotation vector.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Attitude([usize; 3]);

/// Whole rotation vectors among the sensors of `plant`: three of one body on axes that are square
/// to each other.
pub(super) fn attitudes(plant: &Plant) -> Vec<Attitude> {
    let mut found = Vec::new();
    if plant.space == Space::Planar {
        return found;
    }
    let mut open: Vec<(usize, &str, [f64; 3])> = Vec::new();
    for (channel, sensor) in plant.sensors.iter().enumerate() {
        if let SensorKind::Attitude { body, axis } = &sensor.kind {
            open.push((channel, body, *axis));
        }
    }
    while let Some((first, body, axis)) = open.first().cloned() {
        let dot = |a: &[f64; 3], b: &[f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>().abs();
        let mut own = vec![(first, axis)];
        for (channel, _, axis) in open.iter().skip(1).filter(|(_, other, _)| *other == body) {
            if own.len() < 3 && own.iter().all(|(_, other)| dot(other, axis) < SQUARE) {
                own.push((*channel, *axis));
            }
        }
        open.retain(|(channel, ..)| own.iter().all(|(other, _)| other != channel));
        if let [(x, _), (y, _), (z, _)] = own[..] {
            found.push(Attitude([x, y, z]));
        }
    }
    found
}

impl Attitude {
    /// Turns what is predicted of the samples of `event`, `out`, to the rotation vector that is
    /// nearer to theirs, where it is read whole.
    pub fn turn(&self, timeline: &Timeline, event: &Event, out: &mut [f64]) {
        let channels = &timeline.channel[event.first..event.first + event.count];
        let slots = self.0.map(|channel| channels.iter().position(|other| *other == channel));
        let [Some(x), Some(y), Some(z)] = slots else { return };
        let slots = [x, y, z];
        let size = slots.iter().map(|slot| out[*slot] * out[*slot]).sum::<f64>().sqrt();
        if size == 0.0 {
            return;
        }
        let factor = 1.0 - TAU / size;
        let off = |factor: f64| -> f64 {
            slots.iter().map(|slot| (timeline.value[event.first + slot] - factor * out[*slot]).powi(2)).sum()
        };
        if off(factor) < off(1.0) {
            slots.iter().for_each(|slot| out[*slot] *= factor);
        }
    }
}
