//! Parts of a description that structural effects change.

use dynamics::description::{
    Appendage, Body, Joint, JointKind, Mode, Orientation, Plant, Quantity, Sensor, Site, Source, Space, Tank,
};

/// The sensor that a site names.
///
/// # Errors
/// The plant has no such sensor.
pub fn sensor_mut<'a>(plant: &'a mut Plant, site: &Site) -> Result<&'a mut Sensor, String> {
    let found = plant.sensors.iter_mut().find(|sensor| sensor.name == site.name);
    found.ok_or_else(|| format!("no sensor '{}'", site.name))
}

/// Components of a vector that a plant feels: two in the plane.
pub fn axes(plant: &Plant) -> usize {
    if plant.space == Space::Planar { 2 } else { 3 }
}

/// The clock of a sensor; a sensor without a source gets a clock of its own.
pub fn clock_mut<'a>(plant: &'a mut Plant, site: &Site) -> Result<&'a mut Source, String> {
    let sensor = sensor_mut(plant, site)?;
    let name = sensor.source.get_or_insert_with(|| format!("{}_clock", sensor.name)).clone();
    if !plant.sources.iter().any(|source| source.name == name) {
        let zero = Quantity::known(0.0);
        plant.sources.push(Source { name: name.clone(), clock_offset_s: zero, clock_skew: zero });
    }
    Ok(plant.sources.iter_mut().find(|source| source.name == name).expect("it has just been added if it was not there"))
}

/// The body called `name`.
///
/// # Errors
/// The plant has no such body.
pub fn body_mut<'a>(plant: &'a mut Plant, name: &str) -> Result<&'a mut Body, String> {
    let found = plant.bodies.iter_mut().find(|body| body.name == name);
    found.ok_or_else(|| format!("no body '{name}'"))
}

/// The tank that a site names.
///
/// # Errors
/// The plant has no such tank.
pub fn tank_mut<'a>(plant: &'a mut Plant, site: &Site) -> Result<&'a mut Tank, String> {
    let found = plant.tanks.iter_mut().find(|tank| tank.name == site.name);
    found.ok_or_else(|| format!("no tank '{}'", site.name))
}

/// The appendage of the mode that a site names, and the index of the mode in it.
pub fn mode_mut<'a>(plant: &'a mut Plant, site: &Site) -> Result<(&'a mut Appendage, usize), String> {
    let place = |appendage: &Appendage| appendage.modes.iter().position(|mode| mode.name == site.name);
    let found = plant.appendages.iter_mut().find_map(|appendage| place(appendage).map(|place| (appendage, place)));
    found.ok_or_else(|| format!("no mode '{}'", site.name))
}

/// `wanted`, or the first of `wanted_2`, `wanted_3`, ... that no body, joint, tank, appendage or
/// mode is called.
pub fn free_name(plant: &Plant, wanted: &str) -> String {
    let taken = |name: &str| {
        plant.bodies.iter().any(|body| body.name == name || body.joint.name == name)
            || plant.tanks.iter().any(|tank| tank.name == name)
            || plant.appendages.iter().any(|a| a.name == name || a.modes.iter().any(|mode| mode.name == name))
    };
    let numbered = (2u32..).map(|number| format!("{wanted}_{number}"));
    core::iter::once(wanted.to_owned()).chain(numbered).find(|name| !taken(name)).expect("names do not run out")
}

/// Takes a point mass out of a rigid body: mass, centre of mass and inertia about it follow, so
/// that body and point mass together are the body that was. A planar body, whose inertia is about z
/// alone, stays one.
pub fn take_point_mass(body: &mut Body, mass_kg: f64, at_m: [f64; 3]) -> Result<(), String> {
    let mass = body.mass_kg.value;
    let rest = mass - mass_kg;
    if rest <= 0.0 {
        return Err(format!("{mass_kg} kg are more than the {mass} kg of {}", body.name));
    }
    let r: [f64; 3] = core::array::from_fn(|i| at_m[i] - body.com_m[i].value);
    // two point masses about their common centre of mass: reduced mass m (M - m) / M at what
    // becomes r M / (M - m)
    let reduced = mass_kg * mass / rest;
    let [x, y, z] = r;
    let lost = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z].map(|square| reduced * square);
    // in space no body has inertia about z and none about x and y
    let planar = body.inertia_com_kg_m2[0].value == 0.0 && body.inertia_com_kg_m2[1].value == 0.0;
    for (i, (inertia, lost)) in body.inertia_com_kg_m2.iter_mut().zip(lost).enumerate() {
        if !planar || i == 2 {
            inertia.value -= lost;
        }
    }
    for (com, r) in body.com_m.iter_mut().zip(r) {
        com.value -= r * mass_kg / rest;
    }
    body.mass_kg.value = rest;
    if body.inertia_com_kg_m2[2].value < 0.0 {
        return Err(format!("{mass_kg} kg that far out have more inertia than {}", body.name));
    }
    Ok(())
}

/// A joint that has been split between its motor and its link.
pub struct SplitJoint {
    /// Place of the link among the bodies; its joint is the gear, free as yet. The motor is the
    /// body before it.
    pub link: usize,
    /// Name of the gear's joint.
    pub gear: String,
    /// About the joint's axis, or masses along it.
    pub motor_inertia: f64,
    pub link_inertia: f64,
}

/// Splits a joint: a motor keeps its name, place, actuators and friction, the link follows on a
/// joint of its own called `NAME_gear`.
///
/// The motor's inertia is the joint's rotor inertia; where none is stated, `share` of the link's
/// inertia about the joint, taken out of the link: a rotor turns about the joint, so that the link
/// keeps its mass where it is, as far as its inertia about its own centre goes. Either way motor
/// and link moving as one are the joint that was.
pub fn split_joint(plant: &mut Plant, site: &Site, share: f64) -> Result<SplitJoint, String> {
    let motor_name = free_name(plant, &format!("{}_motor", site.name));
    let gear_name = free_name(plant, &format!("{}_gear", site.name));
    let place = plant.bodies.iter().position(|body| body.joint.name == site.name);
    let place = place.ok_or_else(|| format!("no joint '{}'", site.name))?;
    let link = &mut plant.bodies[place];
    let whole = inertia_about_joint(link).ok_or_else(|| format!("{site} has more than one degree of freedom"))?;
    let rotor = link.joint.rotor_inertia.value;
    let taken = if rotor == 0.0 { share } else { 0.0 };
    // of mass and of inertia about the centre: that inertia first
    let own = about_centre(link).unwrap_or(0.0);
    let turning = if own > 0.0 { (taken * whole / own).min(1.0) } else { 0.0 };
    let heavy = if whole > own { (taken * whole - own).max(0.0) / (whole - own) } else { 0.0 };
    let part = |of: Quantity, share: f64| Quantity::known(share * of.value);
    let zero = Quantity::known(0.0);
    let gear = Joint {
        name: gear_name.clone(),
        kind: link.joint.kind,
        position_m: [zero; 3],
        orientation: Orientation::default(),
        viscous_friction: zero,
        rotor_inertia: zero,
        stiffness: zero,
        rest: zero,
    };
    let motor = Body {
        name: motor_name.clone(),
        parent: link.parent.replace(motor_name),
        joint: core::mem::replace(&mut link.joint, gear),
        mass_kg: part(link.mass_kg, heavy),
        com_m: link.com_m,
        inertia_com_kg_m2: link.inertia_com_kg_m2.map(|inertia| part(inertia, turning)),
    };
    link.mass_kg.value *= 1.0 - heavy;
    link.inertia_com_kg_m2.iter_mut().for_each(|inertia| inertia.value *= 1.0 - turning);
    let rest = link.clone();
    plant.bodies.insert(place, motor);
    check_participation(plant, &rest)?;
    let motor_inertia = if rotor == 0.0 { share * whole } else { rotor };
    Ok(SplitJoint { link: place + 1, gear: gear_name, motor_inertia, link_inertia: (1.0 - taken) * whole })
}

/// Inertia of a body about its own joint, `a·I a + m |a × c|²`, or its mass along a prismatic
/// joint.
fn inertia_about_joint(body: &Body) -> Option<f64> {
    match body.joint.kind {
        JointKind::Prismatic { .. } => Some(body.mass_kg.value),
        JointKind::Revolute { axis } => {
            let arm = super::geometry::cross_f64(axis, body.com_m.map(|x| x.value));
            Some(about_centre(body)? + body.mass_kg.value * super::geometry::dot(arm, arm))
        }
        JointKind::Free | JointKind::Fixed => None,
    }
}

/// Inertia of a body about its centre of mass along the axis of its own revolute joint, `a·I a`.
fn about_centre(body: &Body) -> Option<f64> {
    let JointKind::Revolute { axis: a } = body.joint.kind else { return None };
    let [xx, yy, zz, xy, xz, yz] = body.inertia_com_kg_m2.map(|i| i.value);
    let products = 2.0 * (a[0] * a[1] * xy + a[0] * a[2] * xz + a[1] * a[2] * yz);
    Some(a[0] * a[0] * xx + a[1] * a[1] * yy + a[2] * a[2] * zz + products)
}

/// Moments of inertia about the axes of the body's own frame.
pub fn inertia_about_frame(body: &Body) -> [f64; 3] {
    let c = body.com_m.map(|x| x.value);
    let square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    core::array::from_fn(|axis| body.inertia_com_kg_m2[axis].value + body.mass_kg.value * (square - c[axis] * c[axis]))
}

/// An appendage of one mode on the body at `site`, hub-locked: its frequency and damping ratio, its
/// participations of translation and rotation.
///
/// # Errors
/// There is no such body, or it has less mass or inertia than the mode.
pub fn add_mode(
    plant: &mut Plant,
    site: &Site,
    [frequency_hz, damping_ratio]: [f64; 2],
    translation_sqrt_kg: [f64; 3],
    rotation_sqrt_kg_m: [f64; 3],
) -> Result<(), String> {
    let name = free_name(plant, &format!("{}_appendage", site.name));
    let mode = Mode {
        name: free_name(plant, &format!("{}_mode", site.name)),
        frequency_hz: Quantity::known(frequency_hz),
        damping_ratio: Quantity::known(damping_ratio),
        translation_sqrt_kg: translation_sqrt_kg.map(Quantity::known),
        rotation_sqrt_kg_m: rotation_sqrt_kg_m.map(Quantity::known),
        shape_per_sqrt_kg: Vec::new(),
    };
    let body = body_mut(plant, &site.name)?.clone();
    plant.appendages.push(Appendage { name, body: site.name.clone(), points: Vec::new(), modes: vec![mode] });
    check_participation(plant, &body)
}

/// A further mode of the appendage that has the one at `site`.
///
/// # Errors
/// There is no such mode, or the body has less mass or inertia than its modes.
pub fn add_mode_beside(plant: &mut Plant, site: &Site, mode: Mode) -> Result<(), String> {
    let (appendage, _) = mode_mut(plant, site)?;
    appendage.modes.push(mode);
    let body = appendage.body.clone();
    let body = body_mut(plant, &body)?.clone();
    check_participation(plant, &body)
}

/// The modes on a body leave it some mass and inertia of its own: `m - sum of d^2 > 0` along each
/// axis, likewise for rotation.
///
/// # Errors
/// They do not; the mass matrix would not be positive.
pub fn check_participation(plant: &Plant, body: &Body) -> Result<(), String> {
    let modes = || plant.appendages.iter().filter(|a| a.body == body.name).flat_map(|a| &a.modes);
    let sum = |of: fn(&Mode) -> &[Quantity; 3], axis: usize| -> f64 {
        modes().map(|mode| of(mode)[axis].value * of(mode)[axis].value).sum()
    };
    let m = body.mass_kg.value;
    for (axis, inertia) in inertia_about_frame(body).into_iter().enumerate() {
        let (translation, rotation) = (sum(|m| &m.translation_sqrt_kg, axis), sum(|m| &m.rotation_sqrt_kg_m, axis));
        if translation >= m {
            return Err(format!("modes carry {translation} kg of the {m} kg of {}", body.name));
        }
        if rotation > inertia {
            return Err(format!("modes carry {rotation} kg m^2 of the {inertia} kg m^2 of {}", body.name));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::plant;

    #[test]
    fn the_point_mass_and_the_rest_are_the_body_that_was() {
        let before = plant().bodies[0].clone();
        let mut rest = before.clone();
        let (m, at) = (7.0, [0.5, -0.3, 0.2]);
        take_point_mass(&mut rest, m, at).unwrap();
        let about_origin = |body: &Body| -> [f64; 10] {
            let (m, [x, y, z], i) =
                (body.mass_kg.value, body.com_m.map(|c| c.value), body.inertia_com_kg_m2.map(|i| i.value));
            let second = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z];
            core::array::from_fn(|k| match k {
                0 => m,
                1..4 => m * [x, y, z][k - 1],
                _ => i[k - 4] + m * second[k - 4],
            })
        };
        let zero = Quantity::known(0.0);
        let point = Body {
            mass_kg: Quantity::known(m),
            com_m: at.map(Quantity::known),
            inertia_com_kg_m2: [zero; 6],
            ..before.clone()
        };
        let (whole, a, b) = (about_origin(&before), about_origin(&rest), about_origin(&point));
        for k in 0..10 {
            assert!((a[k] + b[k] - whole[k]).abs() < 1e-12, "{k}"); // rounding of numbers up to 400
        }
        assert!(take_point_mass(&mut rest, 500.0, at).is_err());
    }

    #[test]
    fn a_planar_body_keeps_no_inertia_out_of_its_plane() {
        let mut rest = plant().bodies[0].clone();
        for i in [0, 1, 3, 4, 5] {
            rest.inertia_com_kg_m2[i].value = 0.0;
        }
        let before = rest.inertia_com_kg_m2[2].value;
        take_point_mass(&mut rest, 7.0, [0.5, -0.3, 0.0]).unwrap();
        assert!(rest.inertia_com_kg_m2[2].value < before);
        assert!([0, 1, 3, 4, 5].iter().all(|i| rest.inertia_com_kg_m2[*i].value == 0.0));
    }

    #[test]
    fn a_free_name_is_free() {
        assert_eq!(free_name(&plant(), "hub"), "hub_2");
        assert_eq!(free_name(&plant(), "boom"), "boom");
    }
}
