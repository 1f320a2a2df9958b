//! Prior standard deviations of the initial state.

use super::tangent_names;
use dynamics::description::{ActuatorKind, Initial, Plant, TankModel};

/// Prior standard deviation of every number of a small change of the initial state: stated, else as
/// `hardly_seen` has it, else wide by its unit.
pub fn initial_sigmas(
    plant: &Plant,
    system: &dynamics::system::System,
    initial: &Initial,
    hardly_seen: &[(String, f64)],
) -> Vec<f64> {
    let names = tangent_names(system);
    let stated = |name: &str| {
        let (coordinate, rate) = name.strip_suffix(".rate").map_or((name, false), |n| (n, true));
        let value = initial.values.iter().find(|value| value.coordinate == coordinate)?;
        let quantity = if rate { value.rate } else { value.position };
        // an angle of a free body is stated as a rotation vector, its tangent is one too
        quantity.sigma
    };
    let unstated = |name: &str, unit: &str| {
        let hardly = hardly_seen.iter().find(|(own, _)| own == name);
        hardly.map_or_else(|| wide(plant, name, unit), |(_, sigma)| *sigma)
    };
    names
        .iter()
        .map(|(name, unit)| stated(name).or_else(|| wheel_sigma(plant, name)).unwrap_or_else(|| unstated(name, unit)))
        .collect()
}

/// That of a wheel's initial speed, where it is stated.
fn wheel_sigma(plant: &Plant, name: &str) -> Option<f64> {
    match &plant.actuator(name.strip_prefix("wheel:")?)?.kind {
        ActuatorKind::Wheel { initial_speed_rad_s, .. } => initial_speed_rad_s.sigma,
        _ => None,
    }
}

/// Largest free motion of a slosh mass [m] or a mode [√kg m] whose prior is unspecified.
const FREE_MOTION: f64 = 0.3;

fn wide(plant: &Plant, name: &str, unit: &str) -> f64 {
    match (name.split(':').next().unwrap_or(""), unit) {
        // as much kinetic as potential energy: a slow mass at the rate of a fast one would leave
        // the linear model at once
        ("tank" | "mode", _) if name.ends_with(".rate") => FREE_MOTION * natural_rate_rad_s(plant, name).unwrap_or(1.0),
        ("tank" | "mode", _) => FREE_MOTION,
        ("wheel", _) => 100.0,
        (_, "m") => 10.0,
        (_, "m/s") => 5.0,
        ("joint" | "body", "rad") => 1.0,
        ("joint" | "body", "rad/s") => 3.0,
        // hidden states of effects start at zero
        _ => 1e-6,
    }
}

/// Natural frequency of the tank (its stiffest direction) or mode that a state belongs to.
fn natural_rate_rad_s(plant: &Plant, state: &str) -> Option<f64> {
    let site = state.split(':').nth(1)?.split('.').next()?;
    let of_mode = plant.appendages.iter().flat_map(|appendage| &appendage.modes).find(|mode| mode.name == site);
    let tank = || {
        let tank = plant.tanks.iter().find(|tank| tank.name == site)?;
        match &tank.model {
            TankModel::Spring { stiffness_n_m, .. } => {
                let stiffest = stiffness_n_m.iter().map(|k| k.value).fold(0.0, f64::max);
                Some((stiffest / tank.mass_kg.value).sqrt())
            }
            TankModel::Pendulum { .. } => None,
        }
    };
    of_mode.map(|mode| core::f64::consts::TAU * mode.frequency_hz.value).or_else(tank).filter(|rate| rate.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;
    use crate::synthetic::{plant, recording};

    #[test]
    fn the_initial_speed_of_a_wheel_is_a_state_of_its_stated_width_and_no_unknown() {
        let mut plant = plant("study_case");
        let mut wheel = String::new();
        for actuator in &mut plant.actuators {
            if let ActuatorKind::Wheel { initial_speed_rad_s, .. } = &mut actuator.kind {
                initial_speed_rad_s.sigma = Some(12.0);
                wheel.clone_from(&actuator.name);
            }
        }
        let system = dynamics::system::System::new(&plant).unwrap();
        let sigmas = initial_sigmas(&plant, &system, &plant.initial, &[]);
        let at = tangent_names(&system).iter().position(|(name, _)| *name == format!("wheel:{wheel}")).unwrap();
        assert_eq!(sigmas[at], 12.0);
        let problem = Problem::new(&plant, &[recording(&plant, 1, 2.0)], &[]).unwrap();
        assert!(problem.unknowns.iter().all(|unknown| unknown.name != format!("{wheel}.initial_speed")));
    }
}
