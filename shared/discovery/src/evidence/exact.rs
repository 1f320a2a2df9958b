//! Linear numbers that the plant file states as exact, in conflict with their file.
//!
//! Mass, stiffness and damping of a tank's mass, frequency and damping ratio of a mode: a file that
//! states one without a standard deviation may be wrong in it as any file is, and no law of the
//! catalogue has the number's place. Where it is not free the nearest exotic law takes it.
//!
//! | stated | standard deviation of the freed number |
//! |---|---|
//! | a value v | [`EXACT_SHARE`] of v |
//! | no damping | [`DAMPING_RATIO`], in the unit of the number |

use super::decide::{DAMPING_RATIO, EXACT_SHARE};
use dynamics::description::{Plant, TankModel};

/// An exact number, its value and its standard deviation once it is free.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Exact {
    pub name: String,
    pub value: f64,
    pub sigma: f64,
}

/// The exact linear numbers of the tanks and modes of `plant`.
pub(super) fn exact(plant: &Plant) -> Vec<Exact> {
    let damping = |name: &str| {
        let tank = plant.tanks.iter().find(|tank| name.strip_prefix(&*tank.name).is_some_and(|w| w.starts_with('.')));
        let critical = tank.and_then(|tank| match &tank.model {
            TankModel::Spring { stiffness_n_m, .. } => {
                let stiffest = stiffness_n_m.iter().map(|own| own.value).fold(0.0, f64::max);
                Some(2.0 * (stiffest * tank.mass_kg.value).sqrt())
            }
            TankModel::Pendulum { .. } => None,
        });
        DAMPING_RATIO * critical.unwrap_or(1.0)
    };
    let own = |name: &str| {
        let words = [".mass", ".stiffness", ".damping", ".length"];
        let of_tank = plant.tanks.iter().any(|tank| {
            name.strip_prefix(&*tank.name).is_some_and(|rest| words.iter().any(|word| rest.starts_with(word)))
        });
        let modes = plant.appendages.iter().flat_map(|appendage| &appendage.modes);
        let of_mode = |mode: &str| [".frequency", ".damping_ratio"].iter().any(|word| name == format!("{mode}{word}"));
        of_tank || modes.into_iter().any(|mode| of_mode(&mode.name))
    };
    let all = plant.parameters().into_iter().filter(|parameter| parameter.sigma.is_none() && own(&parameter.name));
    all.filter_map(|parameter| {
        let value = parameter.value;
        let sigma = if value > 0.0 {
            EXACT_SHARE * value
        } else if parameter.name.contains(".damping") {
            damping(&parameter.name)
        } else {
            return None;
        };
        (sigma > 0.0).then_some(Exact { name: parameter.name, value, sigma })
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::plant;

    #[test]
    fn an_exact_damping_of_a_tank_may_be_wrong_and_a_stated_one_is_left_to_its_prior() {
        let mut tank = plant("tank_planar");
        assert!(!exact(&tank).iter().any(|own| own.name.contains("damping")));
        tank.visit_quantities(&mut |name, _, quantity| {
            if name.starts_with("fuel.damping") {
                (quantity.value, quantity.sigma) = (0.0, None);
            }
        });
        let found: Vec<Exact> = exact(&tank).into_iter().filter(|own| own.name.contains("damping")).collect();
        assert!(!found.is_empty() && found.iter().all(|own| own.value == 0.0 && own.sigma > 0.0), "{found:?}");
    }
}
