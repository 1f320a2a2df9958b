//! A slosh spring that is really a pendulum.

use super::parts;
use dynamics::description::{Plant, Quantity, Site, SiteKind, Tank, TankModel};
use dynamics::effect::{Effect, EffectParameter, Family, Law, Scan};

/// Slosh stiffness that follows axial acceleration: part of the slosh mass on a rod of length
/// `|a| m / k`.
pub static EFFECT: Effect = Effect {
    kind: "slosh_pendulum",
    title: "Slosh stiffness that follows axial acceleration (pendulum)",
    sites: &[SiteKind::Tank],
    applies: hangs,
    parameters: &[
        EffectParameter::new("fraction", "1", [0.0, 0.999], 0.5, "share of the slosh mass that hangs").amplitude(),
        EffectParameter::new(
            "axial_acceleration",
            "m/s^2",
            [-30.0, 30.0],
            0.1,
            "specific force at which it has the spring's frequency; along z x axis (planar), axis 1 x axis 2 (spatial)",
        )
        .scanned(Scan::SpecificForce),
    ],
    law: Law::Structure(build),
    family: Family::Slosh,
    what: "A share of the slosh mass hangs on a rod of length |a| m / k from a pivot above its rest place, the rest stays on the spring: equal \
           frequencies at axial acceleration a, w^2 in proportion to it otherwise. Abramson 1966 (SP-106). The pendulum starts at rest.",
    signature: "Slosh frequency moves with the square root of thrust per mass; large slosh softens.",
    confounders: "slosh_cubic, the nominal slosh frequency at one thrust level.",
    experiment: "Two thrust levels along the tank's axis, or coast.",
    ..Effect::PLAIN
};

fn hangs(plant: &Plant, site: &Site) -> bool {
    let tank = plant.tanks.iter().find(|tank| tank.name == site.name);
    tank.is_some_and(|tank| tank.axial(plant.space).is_ok())
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let (fraction, acceleration) = (p[0], p[1]);
    if fraction == 0.0 {
        return Ok(());
    }
    let name = parts::free_name(plant, &format!("{}_pendulum", site.name));
    let space = plant.space;
    let tank = parts::tank_mut(plant, site)?;
    let axial = tank.axial(space)?;
    let TankModel::Spring { stiffness_n_m, damping_n_s_m, .. } = &mut tank.model else {
        return Err(format!("{site} is a pendulum already"));
    };
    let (mass, stiffness, damping) = (tank.mass_kg.value, stiffness_n_m[0].value, damping_n_s_m[0].value);
    let length = acceleration.abs() * mass / stiffness;
    if !(length > 0.0 && length.is_finite()) {
        return Err(format!("{acceleration} m/s^2 and a spring of {stiffness} N/m make no pendulum"));
    }
    // hangs against the specific force
    let rest = axial.map(|component| -component * libm::copysign(1.0, acceleration));
    let hanging = Tank {
        name,
        body: tank.body.clone(),
        position_m: core::array::from_fn(|i| Quantity::known(tank.position_m[i].value - length * rest[i])),
        mass_kg: Quantity::known(fraction * mass),
        model: TankModel::Pendulum {
            rest,
            length_m: Quantity::known(length),
            damping_n_m_s_rad: Quantity::known(fraction * damping * length * length),
        },
    };
    for quantity in stiffness_n_m.iter_mut().chain(damping_n_s_m).chain([&mut tank.mass_kg]) {
        quantity.value *= 1.0 - fraction;
    }
    plant.tanks.push(hanging);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::plant;
    use dynamics::description::Space;

    #[test]
    fn spring_and_pendulum_share_mass_place_and_frequency() {
        let mut built = plant();
        build(&mut built, &"tank:oxidiser".parse().unwrap(), &[0.25, 0.3]).unwrap();
        let (spring, pendulum) = (&built.tanks[0], &built.tanks[1]);
        assert_eq!(spring.mass_kg.value + pendulum.mass_kg.value, 40.0);
        let TankModel::Spring { stiffness_n_m, .. } = &spring.model else { panic!("on springs") };
        assert_eq!(stiffness_n_m[0].value / spring.mass_kg.value, 0.75); // 30 N/m over 40 kg, as before
        let TankModel::Pendulum { rest, length_m, damping_n_m_s_rad } = &pendulum.model else { panic!("hangs") };
        assert!((0.3 / length_m.value - 0.75).abs() < 1e-15); // a / L = k / m
        // specific force along z x y = -x: the mass hangs towards +x
        assert_eq!(*rest, [1.0, 0.0, 0.0].map(|x: f64| x + 0.0));
        let place: [f64; 3] = core::array::from_fn(|i| pendulum.position_m[i].value + length_m.value * rest[i]);
        assert!((place[0] - 0.1).abs() < 1e-16 && place[1] == 0.0);
        // damper: c L² θ' is c s' L
        assert!((damping_n_m_s_rad.value - 0.25 * 0.8 * length_m.value * length_m.value).abs() < 1e-16);
    }

    #[test]
    fn what_cannot_hang_is_refused() {
        let site = "tank:oxidiser".parse().unwrap();
        assert!(build(&mut plant(), &site, &[0.5, 0.0]).is_err());
        let mut spatial = plant();
        spatial.space = Space::Spatial;
        assert!(build(&mut spatial, &site, &[0.5, 0.3]).is_err());
        assert!(!hangs(&spatial, &site));
    }

    #[test]
    fn a_tank_that_is_not_alike_along_its_axes_hangs_not() {
        let site: Site = "tank:oxidiser".parse().unwrap();
        let with = |axes: [[f64; 3]; 2], stiffness: [f64; 2], damping: [f64; 2]| {
            let mut spatial = plant();
            spatial.space = Space::Spatial;
            spatial.tanks[0].model = TankModel::Spring {
                axes: axes.to_vec(),
                stiffness_n_m: stiffness.map(Quantity::known).to_vec(),
                damping_n_s_m: damping.map(Quantity::known).to_vec(),
            };
            hangs(&spatial, &site)
        };
        let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        assert!(with([x, y], [30.0; 2], [0.8; 2]));
        assert!(!with([x, y], [30.0, 31.0], [0.8; 2]));
        assert!(!with([x, y], [30.0; 2], [0.8, 0.9]));
        assert!(!with([x, [0.6, 0.8, 0.0]], [30.0; 2], [0.8; 2]));
    }
}
