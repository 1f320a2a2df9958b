//! The parameters that all arcs of a craft share: the one list, its hash and its blocks.

use dynamics::description::{ActuatorKind, Plant};
use identification::joint::{JointUnknown, shared_unknowns};
use nalgebra::DVector;
use plant_file::scenario::{ArcError, CraftPlan};
use telemetry::{COMMANDS_MAX, INFORMATION_MAX, ParameterBlock, READINGS_MAX, layout_hash};

/// The list.
#[derive(Clone, Debug)]
pub struct Parameters {
    pub unknowns: Vec<JointUnknown>,
    /// One of each unknown.
    pub blocks: Vec<ParameterBlock>,
    /// CRC-32 over names, units, priors and sigmas, in their order: messages are in standard
    /// deviations from these priors.
    pub hash: u32,
}

/// Why a craft cannot be identified by messages.
#[derive(Debug, thiserror::Error)]
pub enum ParametersError {
    #[error(transparent)]
    Arc(#[from] ArcError),
    #[error("the craft has no arc")]
    NoArc,
    #[error("no number of the craft states a sigma: there is nothing to identify")]
    Nothing,
    #[error("the craft has {count} {what}: a sample holds at most {limit}")]
    TooMany { count: usize, what: &'static str, limit: usize },
}

impl Parameters {
    /// Of a craft: commands change from arc to arc, numbers do not.
    ///
    /// # Errors
    /// See [`ParametersError`].
    pub fn of(craft: &CraftPlan) -> Result<Self, ParametersError> {
        let arc = craft.arcs.first().ok_or(ParametersError::NoArc)?;
        Self::of_plant(&craft.known(arc)?)
    }

    /// Of a plant.
    ///
    /// # Errors
    /// As [`Parameters::of`].
    pub fn of_plant(plant: &Plant) -> Result<Self, ParametersError> {
        let unknowns = shared_unknowns(plant);
        for (count, what, limit) in [
            (unknowns.len(), "numbers with a sigma that all arcs share", INFORMATION_MAX),
            (plant.actuators.len(), "actuators", COMMANDS_MAX),
            (plant.sensors.len(), "sensors", READINGS_MAX),
        ] {
            if count > limit {
                return Err(ParametersError::TooMany { count, what, limit });
            }
        }
        if unknowns.is_empty() {
            return Err(ParametersError::Nothing);
        }
        let blocks = unknowns.iter().map(|unknown| block(plant, &unknown.name)).collect();
        let hash = unknowns.iter().fold(0, |hash, unknown| {
            let hash = layout_hash(layout_hash(hash, unknown.name.as_bytes()), unknown.unit.as_bytes());
            [unknown.prior, unknown.sigma].iter().fold(hash, |hash, number| layout_hash(hash, &number.to_le_bytes()))
        });
        Ok(Self { unknowns, blocks, hash })
    }

    #[must_use]
    pub fn len(&self) -> usize {
        self.unknowns.len()
    }

    /// Never: a craft without an unknown is no craft to identify.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.unknowns.is_empty()
    }

    /// `(θ − θ₀)/σ₀`.
    #[must_use]
    pub fn deviations(&self, theta: &[f64]) -> DVector<f64> {
        DVector::from_fn(self.len(), |i, _| (theta[i] - self.unknowns[i].prior) / self.unknowns[i].sigma)
    }

    /// The values at `d`, within what is possible.
    #[must_use]
    pub fn values(&self, d: &DVector<f64>) -> Vec<f64> {
        let value =
            |(unknown, d): (&JointUnknown, &f64)| (unknown.prior + d * unknown.sigma).clamp(unknown.low, unknown.high);
        self.unknowns.iter().zip(d.iter()).map(value).collect()
    }

    /// Places of the parameters of `block`; all of them for [`ParameterBlock::Whole`].
    #[must_use]
    pub fn of_block(&self, block: ParameterBlock) -> Vec<usize> {
        let is_in = |i: &usize| block == ParameterBlock::Whole || self.blocks[*i] == block;
        (0..self.len()).filter(is_in).collect()
    }
}

/// By what the first word of the name is called in the plant.
fn block(plant: &Plant, name: &str) -> ParameterBlock {
    let first = name.split('.').next().unwrap_or("");
    let is_mode = |modes: &[dynamics::description::Mode]| modes.iter().any(|mode| mode.name == first);
    let actuator = plant.actuators.iter().find(|actuator| actuator.name == first);
    if plant.tanks.iter().any(|tank| tank.name == first) {
        ParameterBlock::Slosh
    } else if plant.appendages.iter().any(|appendage| appendage.name == first || is_mode(&appendage.modes)) {
        ParameterBlock::Modal
    } else if plant.sensor(first).is_some() || plant.sources.iter().any(|source| source.name == first) {
        ParameterBlock::Sensor
    } else if actuator.is_some_and(|actuator| !matches!(actuator.kind, ActuatorKind::JointTorque { .. })) {
        ParameterBlock::Wheel
    } else {
        ParameterBlock::Inertial
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial;

    #[test]
    fn every_number_of_the_study_case_is_in_the_block_of_its_part() {
        let parameters = Parameters::of_plant(&trial::plant("study_case")).unwrap();
        let of = |name: &str| {
            let at = parameters.unknowns.iter().position(|unknown| unknown.name == name).unwrap();
            parameters.blocks[at]
        };
        assert_eq!(of("hub.mass"), ParameterBlock::Inertial);
        assert_eq!(of("shoulder.friction"), ParameterBlock::Inertial);
        assert_eq!(of("fuel.stiffness.x"), ParameterBlock::Slosh);
        assert_eq!(of("bending_1.frequency"), ParameterBlock::Modal);
        assert_eq!(of("wheel.inertia"), ParameterBlock::Wheel);
        assert_eq!(of("gyro.scale"), ParameterBlock::Sensor);
        assert_eq!(parameters.of_block(ParameterBlock::Whole).len(), parameters.len());
        let parts = ParameterBlock::ALL.iter().filter(|block| **block != ParameterBlock::Whole);
        assert_eq!(parts.map(|block| parameters.of_block(*block).len()).sum::<usize>(), parameters.len());
    }

    #[test]
    fn another_prior_another_name_and_another_order_have_another_hash() {
        let plant = trial::plant("oscillator");
        let hash = |plant: &Plant| Parameters::of_plant(plant).unwrap().hash;
        assert_eq!(hash(&plant), hash(&plant.clone()));
        let changed = |change: &dyn Fn(usize, &mut dynamics::description::Quantity)| {
            let (mut other, mut k) = (plant.clone(), 0);
            other.visit_quantities(&mut |_, _, quantity| {
                if quantity.sigma.is_some() {
                    change(k, quantity);
                    k += 1;
                }
            });
            hash(&other)
        };
        assert_ne!(changed(&|k, q| q.value += f64::from(u8::from(k == 0)) * 1e-9), hash(&plant));
        assert_ne!(changed(&|k, q| q.sigma = q.sigma.map(|s| if k == 0 { 1.1 * s } else { s })), hash(&plant));
        assert_ne!(changed(&|k, q| q.sigma = q.sigma.filter(|_| k != 0)), hash(&plant));
    }
}
