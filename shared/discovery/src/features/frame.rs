//! The features: for every matched mode its frequency, its damping ratio and its shape, as far as
//! they were measured.
//!
//! `ln f`, `ln ζ` and the components of the shape across the measured one are the features, in this
//! order. A damping ratio is evidence where it was measured with a finite standard deviation, to
//! better than half of itself, and where the plant has any. A shape is evidence where the plant has
//! sensors with the names of its channels, two at least and of one unit.

use super::likelihood::Group;
use super::matching::{self, Alike};
use super::peaks::MeasuredMode;
use super::plant_modes::{PlantMode, plant_modes};
use super::shapes::Across;
use dynamics::description::Plant;
use dynamics::system::System;

/// Largest relative standard deviation of a damping ratio: beyond it its logarithm is far from
/// normal.
const DAMPING_SHARE_MAX: f64 = 0.5;

/// One feature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// Which of the pairs.
    pub pair: usize,
    pub group: Group,
    component: usize,
}

/// Plant and measurement side by side.
pub(super) struct Frame {
    /// Mode of the plant, measured mode.
    pub pairs: Vec<(usize, usize)>,
    pub nominal: Vec<PlantMode>,
    pub rows: Vec<Row>,
    pub sigma: Vec<f64>,
    /// Sensors whose shapes are compared.
    pub channels: Vec<String>,
    /// Per measured mode.
    shapes: Vec<Option<Across>>,
    measured: Vec<f64>,
    /// Measurements that are no evidence, and why.
    pub notes: Vec<String>,
}

impl Frame {
    /// # Errors
    /// The plant has no modes, or a measured mode no frequency.
    pub fn new(plant: &Plant, measured: &[MeasuredMode]) -> Result<Self, String> {
        let channels = common_channels(plant, measured);
        let nominal = plant_modes(plant, &channels).ok_or("the plant cannot be linearised where it begins")?;
        if measured.iter().any(|m| !(m.frequency_hz > 0.0 && m.sigma_hz >= 0.0)) {
            return Err("a measured mode has no positive frequency or no standard deviation".to_owned());
        }
        let shapes: Vec<Option<Across>> = measured.iter().map(|mode| shape_over(mode, &channels)).collect();
        let alike = |i: usize, j: usize| {
            let mac = shapes[j].as_ref()?.mac(&nominal[i].shape);
            Some(Alike { mac, channels: channels.len() })
        };
        let plant_hz: Vec<f64> = nominal.iter().map(|mode| mode.frequency_hz).collect();
        let pairs = matching::pairs(&plant_hz, measured, &alike);
        let mut frame = Self {
            pairs,
            nominal,
            rows: Vec::new(),
            sigma: Vec::new(),
            channels,
            shapes,
            measured: Vec::new(),
            notes: Vec::new(),
        };
        frame.add_features(measured);
        Ok(frame)
    }

    fn add_features(&mut self, measured: &[MeasuredMode]) {
        let mut push = |row: Row, value: f64, sigma: f64| {
            self.rows.push(row);
            self.measured.push(value);
            self.sigma.push(sigma.max(1e-9));
        };
        let (mut vague, mut undamped) = (0, 0);
        for (pair, (_, j)) in self.pairs.iter().enumerate() {
            let mode = &measured[*j];
            let row = Row { pair, group: Group::Frequency, component: 0 };
            push(row, libm::log(mode.frequency_hz), mode.sigma_hz / mode.frequency_hz);
        }
        for (pair, (i, j)) in self.pairs.iter().enumerate() {
            let mode = &measured[*j];
            let known = mode.damping_ratio.is_finite() && mode.damping_sigma.is_finite();
            let share = mode.damping_sigma / mode.damping_ratio;
            let damped = self.nominal[*i].damping_ratio > 0.0;
            if known && !(share > 0.0 && share < DAMPING_SHARE_MAX) {
                vague += 1;
            } else if known && !damped {
                undamped += 1;
            } else if known {
                push(Row { pair, group: Group::Damping, component: 0 }, libm::log(mode.damping_ratio), share);
            }
        }
        for (pair, (_, j)) in self.pairs.iter().enumerate() {
            let Some(across) = &self.shapes[*j] else { continue };
            for component in 0..2 * (self.channels.len() - 1) {
                push(Row { pair, group: Group::Shape, component }, 0.0, across.sigma);
            }
        }
        let notes = [
            (vague, "damping ratios are not known to half their size and are no evidence"),
            (undamped, "modes have no damping in the plant: what was measured there is no evidence of a factor on it"),
        ];
        self.notes = notes.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
    }

    /// Features of a plant's modes, in the order of [`nominal`](Self::nominal); `None` where one is
    /// not finite.
    fn values(&self, modes: &[PlantMode]) -> Option<Vec<f64>> {
        let shapes: Vec<Vec<f64>> = self
            .pairs
            .iter()
            .map(|(i, j)| self.shapes[*j].as_ref().map_or(Vec::new(), |across| across.features(&modes[*i].shape)))
            .collect();
        let value = |row: &Row| {
            let mode = &modes[self.pairs[row.pair].0];
            match row.group {
                Group::Frequency => libm::log(mode.frequency_hz),
                Group::Damping => libm::log(mode.damping_ratio),
                Group::Shape => shapes[row.pair][row.component],
            }
        };
        let values: Vec<f64> = self.rows.iter().map(value).collect();
        values.iter().all(|value| value.is_finite()).then_some(values)
    }

    /// Measured less the plant's.
    ///
    /// # Errors
    /// A feature of the plant is not finite.
    pub fn residual(&self) -> Result<Vec<f64>, String> {
        let values = self.values(&self.nominal).ok_or("a mode of the plant has no finite frequency or shape")?;
        Ok(self.measured.iter().zip(values).map(|(m, v)| m - v).collect())
    }

    /// Features of a changed plant less those of the plant; `None` where it has other modes.
    pub fn moved(&self, changed: &Plant) -> Option<Vec<f64>> {
        let modes = plant_modes(changed, &self.channels)?;
        let modes = if self.channels.is_empty() {
            (modes.len() == self.nominal.len()).then_some(modes)?
        } else {
            super::plant_modes::tracked(&self.nominal, modes)?
        };
        let (before, after) = (self.values(&self.nominal)?, self.values(&modes)?);
        Some(after.iter().zip(before).map(|(a, b)| a - b).collect())
    }

    /// MAC of a plant's mode with the measured one of a pair, where it has a shape.
    pub fn mac(&self, pair: usize, mode: &PlantMode) -> Option<f64> {
        self.shapes[self.pairs[pair].1].as_ref().map(|across| across.mac(&mode.shape))
    }

    /// Features of the given pairs.
    pub fn rows_of(&self, pairs: core::ops::Range<usize>) -> Vec<usize> {
        (0..self.rows.len()).filter(|k| pairs.contains(&self.rows[*k].pair)).collect()
    }
}

/// Channels of the shapes that are sensors of the plant, of the unit that most of them have: a
/// length holds one unit.
fn common_channels(plant: &Plant, measured: &[MeasuredMode]) -> Vec<String> {
    let Ok(system) = System::new(plant) else { return Vec::new() };
    let asked = |name: &str| measured.iter().any(|mode| mode.shape.iter().any(|at| at.channel == name));
    let known: Vec<_> = system.outputs().iter().filter(|output| asked(&output.name)).collect();
    let count = |unit: &str| known.iter().filter(|output| output.unit == unit).count();
    let unit = known.iter().map(|output| output.unit).rev().max_by_key(|unit| count(unit));
    let list: Vec<String> =
        known.iter().filter(|output| Some(output.unit) == unit).map(|output| output.name.clone()).collect();
    if list.len() < 2 { Vec::new() } else { list }
}

/// A mode's shape over all `channels`, if it has them.
fn shape_over(mode: &MeasuredMode, channels: &[String]) -> Option<Across> {
    let at = |channel: &String| mode.shape.iter().find(|at| at.channel == *channel);
    let found: Option<Vec<_>> = channels.iter().map(at).collect();
    let found = found?;
    let (values, sigma): (Vec<_>, Vec<f64>) = found.iter().map(|at| (at.value, at.sigma)).unzip();
    Across::new(&values, &sigma)
}
