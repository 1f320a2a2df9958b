//! `[[body]]`, `[[tank]]`, `[[appendage]]`.

use super::section::Section;
use dynamics::description::{Appendage, Body, Joint, JointKind, Mode, Orientation, Quantity, Tank, TankModel};

#[derive(Clone, Copy)]
enum Kind {
    Free,
    Fixed,
    Revolute,
    Prismatic,
}

const KINDS: [(&str, Kind); 4] =
    [("free", Kind::Free), ("fixed", Kind::Fixed), ("revolute", Kind::Revolute), ("prismatic", Kind::Prismatic)];

/// Reads one `[[body]]`.
pub(super) fn body(section: &mut Section<'_, '_>) -> Body {
    let name = section.name("body");
    let parent = section.text("parent");
    let joint = match section.section("joint", "joint") {
        Some(of) => joint(&of, &name),
        None => {
            section.missing("joint", "as in joint = { kind = \"revolute\", axis = \"z\", position = [\"1 m\", 0] }");
            joint_at_rest(&name)
        }
    };
    let body = Body {
        parent,
        joint,
        mass_kg: section.required_quantity("mass", "kg"),
        com_m: section.vector_or_zero("com", "m"),
        inertia_com_kg_m2: inertia(section),
        name,
    };
    section.finish();
    body
}

fn joint_at_rest(name: &str) -> Joint {
    let none = Quantity::known(0.0);
    Joint {
        name: name.to_owned(),
        kind: JointKind::Fixed,
        position_m: [none; 3],
        orientation: Orientation::default(),
        viscous_friction: none,
        rotor_inertia: none,
        stiffness: none,
        rest: none,
    }
}

fn joint(section: &Section<'_, '_>, body: &str) -> Joint {
    let mut joint = joint_at_rest(body);
    joint.name = section.text("name").unwrap_or_else(|| body.to_owned());
    joint.position_m = section.vector_or_zero("position", "m");
    joint.orientation = orientation(section, "orientation");
    let Some(kind) = section.word("kind", &KINDS, None) else {
        section.be_lenient();
        section.be_unsure(&joint.name);
        section.finish();
        // what refers to it wants a joint that moves
        return Joint { kind: JointKind::Revolute { axis: [0.0, 0.0, 1.0] }, ..joint };
    };
    joint.kind = match kind {
        Kind::Free => JointKind::Free,
        Kind::Fixed => JointKind::Fixed,
        Kind::Revolute if section.planar() => {
            JointKind::Revolute { axis: section.axis("axis").unwrap_or([0.0, 0.0, 1.0]) }
        }
        Kind::Revolute => JointKind::Revolute { axis: section.required_axis("axis") },
        Kind::Prismatic => JointKind::Prismatic { axis: section.required_axis("axis") },
    };
    if matches!(kind, Kind::Revolute | Kind::Prismatic) {
        let [friction, inertia, stiffness] =
            if joint.is_prismatic() { ["N*s/m", "kg", "N/m"] } else { ["N*m*s/rad", "kg*m^2", "N*m/rad"] };
        joint.viscous_friction = section.quantity_or("friction", friction, 0.0);
        joint.rotor_inertia = section.quantity_or("rotor_inertia", inertia, 0.0);
        joint.stiffness = section.quantity_or("stiffness", stiffness, 0.0);
        joint.rest = section.quantity_or("rest", joint.unit(), 0.0);
    }
    section.finish();
    joint
}

/// `{ axis, angle }`; about z where no axis is stated.
pub(super) fn orientation(section: &Section<'_, '_>, key: &str) -> Orientation {
    let Some(inner) = section.section(key, key) else { return Orientation::default() };
    let axis = if inner.planar() { inner.axis("axis").unwrap_or([0.0, 0.0, 1.0]) } else { inner.required_axis("axis") };
    let orientation = Orientation { axis, angle_rad: inner.required_quantity("angle", "rad") };
    inner.finish();
    orientation
}

/// One number in a plane; xx, yy, zz or xx, yy, zz, xy, xz, yz in space.
fn inertia(section: &Section<'_, '_>) -> [Quantity; 6] {
    let zero = Quantity::known(0.0);
    let stand_in = [Quantity::known(1.0); 3];
    let Some(list) = section.list("inertia", "kg*m^2") else {
        let example = if section.planar() { "\"1 kg*m^2\"" } else { "[\"1 kg*m^2\", \"1 kg*m^2\", \"1 kg*m^2\"]" };
        section.missing("inertia", &format!("as in inertia = {example}, about the centre of mass"));
        return [stand_in[0], stand_in[1], stand_in[2], zero, zero, zero];
    };
    match list[..] {
        [zz] if section.planar() => [zero, zero, zz, zero, zero, zero],
        [xx, yy, zz] if section.spatial() => [xx, yy, zz, zero, zero, zero],
        [xx, yy, zz, xy, xz, yz] if section.spatial() => [xx, yy, zz, xy, xz, yz],
        _ => {
            let wanted = if section.planar() { "1 (about z)" } else { "3 (xx, yy, zz) or 6 (xx, yy, zz, xy, xz, yz)" };
            section.wrong_length("inertia", list.len(), wanted);
            [stand_in[0], stand_in[1], stand_in[2], zero, zero, zero]
        }
    }
}

/// Reads one `[[tank]]`.
pub(super) fn tank(section: &mut Section<'_, '_>) -> Tank {
    let name = section.name("tank");
    let body = section.required_text("body", "the body that holds it");
    let position_m = section.required_vector("position", "m");
    let mass_kg = section.required_quantity("mass", "kg");
    let model = match section.word("kind", &[("spring", true), ("pendulum", false)], None) {
        Some(true) => spring(section),
        Some(false) => TankModel::Pendulum {
            rest: section.required_axis("rest"),
            length_m: section.required_quantity("length", "m"),
            damping_n_m_s_rad: section.quantity_or("damping", "N*m*s/rad", 0.0),
        },
        None => {
            section.be_lenient();
            TankModel::Pendulum {
                rest: [1.0, 0.0, 0.0],
                length_m: Quantity::known(1.0),
                damping_n_m_s_rad: Quantity::known(0.0),
            }
        }
    };
    section.finish();
    Tank { name, body, position_m, mass_kg, model }
}

fn spring(section: &Section<'_, '_>) -> TankModel {
    let axes = axes(section);
    let per_axis = |key: &str, unit: &str, list: Option<Vec<Quantity>>| match list {
        // one number for all axes
        Some(list) if list.len() == 1 => vec![list[0]; axes.len()],
        Some(list) if list.len() == axes.len() => list,
        Some(list) => {
            section.wrong_length(key, list.len(), &format!("{} (one for each axis)", axes.len()));
            vec![Quantity::known(1.0); axes.len()]
        }
        None => {
            if key == "stiffness" {
                section.missing(key, &format!("as in {key} = \"1 {unit}\", one for each axis"));
            }
            vec![Quantity::known(0.0); axes.len()]
        }
    };
    TankModel::Spring {
        stiffness_n_m: per_axis("stiffness", "N/m", section.list("stiffness", "N/m")),
        damping_n_s_m: per_axis("damping", "N*s/m", section.list("damping", "N*s/m")),
        axes,
    }
}

/// `axis = "x"` or `axes = ["x", "y"]`.
fn axes(section: &Section<'_, '_>) -> Vec<[f64; 3]> {
    if let Some(axis) = section.axis("axis") {
        section.also("axis", "axes");
        return vec![axis];
    }
    let Some(node) = section.get("axes") else {
        section.missing("axis", "as in axis = \"y\", or axes = [\"x\", \"y\"]");
        return vec![[1.0, 0.0, 0.0]];
    };
    let Some(list) = node.get_ref().as_array() else {
        section.error("axes", format!("axes of {} are no list", section.what), "as in axes = [\"x\", \"y\"]");
        return vec![[1.0, 0.0, 0.0]];
    };
    list.iter().map(|node| section.direction("axes", node).unwrap_or([1.0, 0.0, 0.0])).collect()
}

/// Reads one `[[appendage]]` with its modes.
pub(super) fn appendage(section: &mut Section<'_, '_>) -> Appendage {
    let name = section.name("appendage");
    let body = section.required_text("body", "the body it is clamped to");
    let mut points = Vec::new();
    if let Some(inner) = section.section("points", "points") {
        points = inner.keys().into_iter().map(|point| (point.to_owned(), inner.vector_or_zero(point, "m"))).collect();
    }
    let names: Vec<String> = points.iter().map(|(name, _)| name.clone()).collect();
    let modes = section.sections("mode", "mode").iter_mut().map(|section| mode(section, &names)).collect();
    section.finish();
    Appendage { name, body, points, modes }
}

fn mode(section: &mut Section<'_, '_>, points: &[String]) -> Mode {
    let name = section.name("mode");
    let mode = Mode {
        frequency_hz: section.required_quantity("frequency", "Hz"),
        damping_ratio: section.required_quantity("damping_ratio", "1"),
        translation_sqrt_kg: section.vector_or_zero("translation", "sqrt(kg)"),
        rotation_sqrt_kg_m: section.turning("rotation", "sqrt(kg)*m").unwrap_or_default(),
        shape_per_sqrt_kg: shape(section, points),
        name,
    };
    section.finish();
    mode
}

/// One displacement per point of the appendage.
fn shape(section: &Section<'_, '_>, points: &[String]) -> Vec<[Quantity; 3]> {
    let Some(inner) = section.section("shape", "shape") else {
        if !points.is_empty() {
            let example =
                format!("shape.{} = [\"0.1 1/sqrt(kg)\", 0{}]", points[0], if section.planar() { "" } else { ", 0" });
            section.missing("shape", &format!("the displacement of every point, as in {example}"));
        }
        return vec![Default::default(); points.len()];
    };
    let read = |point: &String| {
        inner.vector(point, "1/sqrt(kg)").unwrap_or_else(|| {
            inner.missing(point, "every point of the appendage moves in every mode, if only by zero");
            Default::default()
        })
    };
    let shapes = points.iter().map(read).collect();
    inner.finish();
    shapes
}
