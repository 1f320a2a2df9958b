//! A joint whose axis is not where the drawing has it.

use super::geometry::{across, tilted};
use dynamics::description::{JointKind, Plant, Site, SiteKind, Space};
use dynamics::effect::{Effect, EffectParameter, Family, Law};

/// Misalignment of a joint's axis: `a → cos e a + sin e (e1 t1 + e2 t2) / e`, joint frame.
pub static EFFECT: Effect = Effect {
    kind: "joint_axis_misalignment",
    title: "Misalignment of a joint's axis",
    sites: &[SiteKind::Joint],
    applies: in_space,
    parameters: &[
        EffectParameter::new("tilt_1", "rad", [-0.2, 0.2], 0.01, "tilt of the true axis towards t1 = z x axis")
            .amplitude(),
        EffectParameter::new("tilt_2", "rad", [-0.2, 0.2], 0.0, "tilt towards t2 = axis x t1").amplitude(),
    ],
    law: Law::Structure(build),
    family: Family::MassProperties,
    what: "Axis a -> cos e a + sin e (e1 t1 + e2 t2) / e in the joint's own frame, e the length of the tilt (e1, e2); for an axis along z, \
           t1 is x. At zero coordinate nothing moves. Only in space: in the plane all axes are z.",
    signature: "Motion of this joint turns or pushes the base a little about the other axes, with the joint's own time course.",
    confounders: "inertia_error and com_shift of what the joint carries (products of inertia); sensor_misalignment of the gyro.",
    experiment: "Move the joint over a large range: a tilted axis sweeps a cone, a product of inertia turns with the link.",
    ..Effect::PLAIN
};

fn in_space(plant: &Plant, _: &Site) -> bool {
    plant.space == Space::Spatial
}

fn build(plant: &mut Plant, site: &Site, p: &[f64]) -> Result<(), String> {
    let tilt = [p[0], p[1]];
    if tilt == [0.0; 2] {
        return Ok(());
    }
    if plant.space == Space::Planar {
        return Err("in the plane all axes are z".to_owned());
    }
    let found = plant.bodies.iter_mut().find(|body| body.joint.name == site.name);
    let joint = &mut found.ok_or_else(|| format!("no joint '{}'", site.name))?.joint;
    match &mut joint.kind {
        JointKind::Revolute { axis } | JointKind::Prismatic { axis } => *axis = tilted(*axis, across(*axis), tilt),
        JointKind::Free | JointKind::Fixed => return Err(format!("{site} has no axis")),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{EFFECT, build};
    use crate::trial::plant;
    use dynamics::description::{JointKind, Space};
    use dynamics::effect::sites;

    #[test]
    fn only_the_axis_of_the_joint_is_turned_by_the_length_of_the_tilt() {
        let mut before = plant();
        before.space = Space::Spatial;
        let mut built = before.clone();
        let site = "joint:elbow".parse().unwrap();
        build(&mut built, &site, &[0.0, 0.0]).unwrap();
        assert_eq!(built, before);
        build(&mut built, &site, &[0.06, -0.08]).unwrap();
        let JointKind::Revolute { axis } = built.bodies[1].joint.kind else { panic!("an elbow turns") };
        let expected = [0.6 * libm::sin(0.1), -0.8 * libm::sin(0.1), libm::cos(0.1)];
        assert!((0..3).all(|i| (axis[i] - expected[i]).abs() < 1e-15), "{axis:?}"); // rounding
        built.bodies[1].joint.kind = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
        assert_eq!(built, before);
    }

    #[test]
    fn it_has_no_site_in_the_plane() {
        assert!(sites(&EFFECT, &plant()).is_empty());
        assert!(build(&mut plant(), &"joint:elbow".parse().unwrap(), &[0.1, 0.0]).is_err());
    }
}
