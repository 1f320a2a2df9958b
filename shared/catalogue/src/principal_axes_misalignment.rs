//! Principal axes that are not where the data sheet draws them.

use super::geometry::cross_f64;
use super::parts;
use dynamics::description::{Plant, Site, SiteKind, Space};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Misalignment of the principal axes: `I → R I Rᵀ` about the centre of mass.
pub static EFFECT: Effect = Effect {
    kind: "principal_axes_misalignment",
    title: "Misalignment of the principal axes of inertia (products of inertia other than stated)",
    sites: &[SiteKind::Body],
    applies: spatial,
    parameters: &[
        EffectParameter::new("turn_x", "rad", [-0.5, 0.5], 0.01, "rotation vector of the inertia, body x").amplitude(),
        EffectParameter::new("turn_y", "rad", [-0.5, 0.5], 0.0, "rotation vector of the inertia, body y").amplitude(),
        EffectParameter::new("turn_z", "rad", [-0.5, 0.5], 0.0, "rotation vector of the inertia, body z").amplitude(),
    ],
    law: Law::Structure(build),
    family: Family::MassProperties,
    what: "I -> R I R' about the centre of mass, R the turn by the rotation vector: principal moments unchanged, to first order products of \
           inertia of the turn times the difference of two moments.",
    signature: "Spin about one axis leaks into the others (dynamic imbalance); nothing about an axis of symmetry.",
    confounders: "sensor_misalignment of all axes of a gyro by one turn (the same where nothing pushes), com_shift under thrust, \
                  inertia_error; nothing is left of it where the products of inertia are estimated.",
    experiment: "A second sensor of attitude (star tracker), or torques about known axes.",
    ..Effect::PLAIN
};

fn spatial(plant: &Plant, _: &Site) -> bool {
    plant.space == Space::Spatial
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let turn = [p[0], p[1], p[2]];
    if turn == [0.0; 3] {
        return Ok(());
    }
    let inertia = &mut parts::body_mut(plant, &site.name)?.inertia_com_kg_m2;
    let [xx, yy, zz, xy, xz, yz] = inertia.each_ref().map(|quantity| quantity.value);
    // R I R' = R (R I)' for a symmetric I
    let half = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| turned(row, turn));
    let whole: [[f64; 3]; 3] = core::array::from_fn(|i| turned(core::array::from_fn(|j| half[j][i]), turn));
    let values = [whole[0][0], whole[1][1], whole[2][2], whole[0][1], whole[0][2], whole[1][2]];
    inertia.iter_mut().zip(values).for_each(|(quantity, value)| quantity.value = value);
    Ok(())
}

/// `v` turned by the rotation vector `r`:
/// `v cos a + (r × v) sin a / a + r (r · v) (1 − cos a) / a²`.
fn turned(v: [f64; 3], r: [f64; 3]) -> [f64; 3] {
    let square: f64 = r.iter().map(|r| r * r).sum();
    let angle = libm::sqrt(square);
    // below 1e-4 rad the series are exact to rounding
    let (along, about) = if angle < 1e-4 {
        (1.0 - square / 6.0, 0.5 - square / 24.0)
    } else {
        (libm::sin(angle) / angle, (1.0 - libm::cos(angle)) / square)
    };
    let (cross, dot) = (cross_f64(r, v), r[0] * v[0] + r[1] * v[1] + r[2] * v[2]);
    core::array::from_fn(|i| libm::cos(angle) * v[i] + along * cross[i] + about * dot * r[i])
}

#[cfg(test)]
mod tests {
    use super::build;
    use crate::trial::plant;
    use dynamics::description::{Quantity, Space};

    fn turned(moments: [f64; 3], turn: [f64; 3]) -> [f64; 6] {
        let mut built = plant();
        built.space = Space::Spatial;
        let [x, y, z] = moments;
        built.bodies[0].inertia_com_kg_m2 = [x, y, z, 0.0, 0.0, 0.0].map(Quantity::known);
        build(&mut built, &"body:hub".parse().unwrap(), &turn).unwrap();
        built.bodies[0].inertia_com_kg_m2.map(|quantity| quantity.value)
    }

    #[test]
    fn a_turn_about_z_gives_the_tensor_of_mohrs_circle() {
        let (x, y, z, a) = (2.0, 5.0, 6.0, 0.3_f64);
        let found = turned([x, y, z], [0.0, 0.0, a]);
        let (mean, half) = (0.5 * (x + y), 0.5 * (x - y));
        let circle =
            [mean + half * (2.0 * a).cos(), mean - half * (2.0 * a).cos(), z, half * (2.0 * a).sin(), 0.0, 0.0];
        found.iter().zip(circle).for_each(|(a, b)| assert!((a - b).abs() < 1e-14, "{found:?} {circle:?}"));
    }

    #[test]
    fn principal_moments_stay_and_small_turns_are_those_of_the_series() {
        let trace_and_square = |i: [f64; 6]| {
            let [xx, yy, zz, xy, xz, yz] = i;
            (xx + yy + zz, xx * xx + yy * yy + zz * zz + 2.0 * (xy * xy + xz * xz + yz * yz))
        };
        let (trace, square) = trace_and_square(turned([2.0, 5.0, 6.0], [0.4, -0.2, 0.3]));
        assert!((trace - 13.0).abs() < 1e-13 && (square - 65.0).abs() < 1e-12);
        let small = turned([2.0, 5.0, 6.0], [0.0, 0.0, 1e-5]);
        assert!((small[3] - -3.0e-5).abs() < 1e-13, "{small:?}");
    }
}
