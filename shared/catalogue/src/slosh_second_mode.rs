//! The next slosh mode of a tank.

use super::geometry::perpendicular;
use super::parts;
use core::f64::consts::{FRAC_PI_2, TAU};
use dynamics::description::{Plant, Quantity, Site, SiteKind, Space, Tank, TankModel};
use dynamics::effect::{Effect, EffectParameter, Family, Law, Spread};

/// Second slosh mode: a further mass on springs and dampers, taken out of the rigid body.
pub static EFFECT: Effect = Effect {
    kind: "slosh_second_mode",
    title: "Second slosh mode",
    sites: &[SiteKind::Tank],
    parameters: &[
        EffectParameter::new("mass_ratio", "1", [0.0, 1.0], 0.1, "its slosh mass over that of the first mode")
            .amplitude(),
        EffectParameter::new("frequency", "Hz", [0.005, 10.0], 0.5, "its frequency, tank held").frequency(),
        EffectParameter::new("damping_ratio", "1", [0.0, 0.3], 0.01, "its damping ratio")
            .damping_ratio(0.03, Spread::Absolute(0.05)),
    ],
    law: Law::Structure(build),
    family: Family::Slosh,
    what: "A second mass on springs and dampers where the first one rests, along the same axes (a pendulum's: across its rest), taken out of \
           the rigid body, so that the locked plant is the same. Abramson 1966 (SP-106): m2/m1 is 0.03 in a half-full cylinder.",
    signature: "A notch and peak pair from force to acceleration at its frequency; ringing beside the first mode.",
    confounders: "mode_left_out or appendage_left_out at that frequency, slosh_quadratic_damping, sensor_lever_arm, sensor_scale.",
    experiment: "Another acceleration level: slosh frequencies move with it, structural ones do not.",
    ..Effect::PLAIN
};

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let (ratio, omega, zeta) = (p[0], TAU * p[1], p[2]);
    if ratio == 0.0 {
        return Ok(());
    }
    let space = plant.space;
    let tank = parts::tank_mut(plant, site)?.clone();
    let (axes, at_m) = rest_of(&tank, space);
    let mass = ratio * tank.mass_kg.value;
    parts::take_point_mass(parts::body_mut(plant, &tank.body)?, mass, at_m)?;
    let model = TankModel::Spring {
        stiffness_n_m: vec![Quantity::known(mass * omega * omega); axes.len()],
        damping_n_s_m: vec![Quantity::known(2.0 * zeta * omega * mass); axes.len()],
        axes,
    };
    let name = parts::free_name(plant, &format!("{}_second", tank.name));
    let second =
        Tank { name, body: tank.body, position_m: at_m.map(Quantity::known), mass_kg: Quantity::known(mass), model };
    plant.tanks.push(second);
    Ok(())
}

/// The axes along which a tank's mass moves, and where it rests [m].
fn rest_of(tank: &Tank, space: Space) -> (Vec<[f64; 3]>, [f64; 3]) {
    let position = tank.position_m.map(|x| x.value);
    match &tank.model {
        TankModel::Spring { axes, .. } => (axes.clone(), position),
        TankModel::Pendulum { rest, length_m, .. } => {
            let clocks: &[f64] = if space == Space::Planar { &[0.0] } else { &[0.0, FRAC_PI_2] };
            let at = core::array::from_fn(|i| position[i] + length_m.value * rest[i]);
            (clocks.iter().map(|clock| perpendicular(*rest, *clock)).collect(), at)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::plant;

    #[test]
    fn the_second_mass_has_its_frequency_and_the_locked_plant_stays_the_same() {
        let mut built = plant();
        build(&mut built, &"tank:oxidiser".parse().unwrap(), &[0.1, 0.5, 0.02]).unwrap();
        let second = &built.tanks[1];
        assert_eq!((second.name.as_str(), second.mass_kg.value), ("oxidiser_second", 4.0));
        let TankModel::Spring { stiffness_n_m, damping_n_s_m, .. } = &second.model else { panic!("on springs") };
        let omega = core::f64::consts::PI; // 0.5 Hz
        assert!((stiffness_n_m[0].value - 4.0 * omega * omega).abs() < 1e-13); // rounding
        assert!((damping_n_s_m[0].value - 2.0 * 0.02 * omega * 4.0).abs() < 1e-15);
        let hub = &built.bodies[0];
        assert_eq!(hub.mass_kg.value, 396.0);
        assert!((hub.mass_kg.value * hub.com_m[0].value + 4.0 * 0.1 - 400.0 * 0.02).abs() < 1e-13); // first moment
        assert_eq!(built.tanks[0], plant().tanks[0]);
    }

    #[test]
    fn a_pendulum_s_second_mass_moves_across_its_rest_where_it_hangs() {
        let mut built = plant();
        built.tanks[0].model = TankModel::Pendulum {
            rest: [-1.0, 0.0, 0.0],
            length_m: Quantity::known(0.5),
            damping_n_m_s_rad: Quantity::known(0.0),
        };
        build(&mut built, &"tank:oxidiser".parse().unwrap(), &[0.1, 0.5, 0.02]).unwrap();
        let TankModel::Spring { axes, .. } = &built.tanks[1].model else { panic!("on springs") };
        assert_eq!(axes.len(), 1);
        assert_eq!(axes[0][1].abs(), 1.0);
        assert_eq!(built.tanks[1].position_m.map(|x| x.value), [-0.4, 0.0, 0.0]);
    }

    #[test]
    fn more_mass_than_the_body_has_is_refused() {
        let mut built = plant();
        built.tanks[0].mass_kg.value = 500.0;
        assert!(build(&mut built, &"tank:oxidiser".parse().unwrap(), &[1.0, 0.5, 0.02]).is_err());
    }
}
