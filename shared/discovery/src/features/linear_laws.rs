//! Which forces of the catalogue a list of modes can show: those that are linear in the motion.
//!
//! A law that is linear has one stiffness and one damping, whatever the amplitude, and the
//! linearised plant with it has the frequencies and damping ratios that are measured. Dry friction,
//! hysteresis and play have none of their own: linearised at rest they are a stiff damper or
//! nothing at all, while the modes of a record depend on its amplitude. Such a law is not a
//! hypothesis here.
//!
//! The linear laws are found by evaluation, not listed: the plant is evaluated with the law and
//! without. The accelerations that the law adds must be zero at rest and must grow a thousandfold
//! when all rates, or all positions, do.

use super::plant_modes::at_rest;
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, Law};
use dynamics::system::{System, Workspace};

/// Rates [1/s, m/s, rad/s] between which a damper must be linear, and relative tolerance.
const RATES: [f64; 2] = [1e-3, 1.0];
const RATES_AGREE: f64 = 1e-6;
/// Positions likewise; the inertia of a turned part changes them by the order of the larger one.
const POSITIONS: [f64; 2] = [1e-6, 1e-3];
const POSITIONS_AGREE: f64 = 1e-2;

/// Entries and sites of the linear laws on joints, tanks, modes and bodies that have an effect
/// there.
pub(super) fn of(plant: &Plant) -> Vec<(&'static Effect, Site)> {
    let pushes = |law: &Law| matches!(law, Law::Coordinate(_) | Law::Body(_));
    let mut list = Vec::new();
    for effect in plant.catalogue.entries().iter().filter(|e| pushes(&e.law) && e.hidden_states == 0) {
        let sites = effect.sites.iter().filter(|kind| !matches!(kind, SiteKind::Sensor | SiteKind::Actuator));
        for site in sites.flat_map(|kind| plant.sites(*kind)).filter(|site| (effect.applies)(plant, site)) {
            if is_linear(plant, effect, &site) == Some(true) {
                list.push((*effect, site));
            }
        }
    }
    list
}

/// `None` where the plant cannot be evaluated with it.
fn is_linear(plant: &Plant, effect: &Effect, site: &Site) -> Option<bool> {
    let mut with = plant.clone();
    with.add_effect(effect.kind, site, &[]).ok()?;
    let (before, after) = (System::new(plant).ok()?, System::new(&with).ok()?);
    if before.states().len() != after.states().len() {
        return None;
    }
    let rest = at_rest(plant, &before)?;
    let rates = |system: &System, x: &[f64]| {
        let mut x_dot = vec![0.0; x.len()];
        let u = vec![0.0; system.inputs().len()];
        system.derivative(&mut Workspace::new(system), 0.0, x, &u, &mut x_dot);
        x_dot
    };
    // accelerations added by the law when all rates, or all positions, are off by `size`
    let added = |size: f64, of_rates: bool| -> Vec<f64> {
        let moved = before.states().iter().zip(&rest).map(|(state, x)| {
            let is_rate = state.name.ends_with(".rate");
            if is_rate == of_rates { x + size } else { *x }
        });
        let x: Vec<f64> = moved.collect();
        rates(&after, &x).iter().zip(rates(&before, &x)).map(|(a, b)| a - b).collect()
    };
    let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let (at_rest, fast, far) = (added(0.0, true), added(RATES[1], true), added(POSITIONS[1], false));
    let something = largest(&fast).max(largest(&far));
    let grows = |small: &[f64], large: &[f64], by: f64, agree: f64| {
        let off = small.iter().zip(large).fold(0.0, |most: f64, (s, l)| most.max((by * s - l).abs()));
        off <= agree * largest(large).max(1e-9 * something)
    };
    Some(
        something > 0.0
            && largest(&at_rest) <= 1e-9 * something
            && grows(&added(RATES[0], true), &fast, RATES[1] / RATES[0], RATES_AGREE)
            && grows(&added(POSITIONS[0], false), &far, POSITIONS[1] / POSITIONS[0], POSITIONS_AGREE),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_offers_its_damper_and_its_spring_and_neither_dry_friction_nor_a_cubic_law() {
        let kinds: Vec<&str> = of(&crate::synthetic::plant("oscillator")).iter().map(|(e, _)| e.kind).collect();
        for linear in ["joint_viscous", "joint_stiffness"] {
            assert!(kinds.contains(&linear), "{linear} is not in {kinds:?}");
        }
        for other in
            ["joint_coulomb", "joint_stribeck", "joint_cubic_damping", "joint_cubic_stiffness", "joint_torque_bias"]
        {
            assert!(!kinds.contains(&other), "{other} is in {kinds:?}");
        }
    }
}
