//! Bodies, joints, tanks and appendages.

use super::{At, Check, Must, not_positive};
use dynamics::description::{Appendage, Body, JointKind, Mode, Tank, TankModel};
use nalgebra::{Matrix3, Vector3};

impl Check<'_> {
    pub(super) fn bodies(&mut self) {
        let plant = self.plant;
        if plant.bodies.is_empty() {
            let at = At::new("plant", 0, &plant.name);
            self.fault(&at, "body", "the plant has no body", "add a [[body]]");
        }
        self.tree();
        for (i, body) in plant.bodies.iter().enumerate() {
            let at = At::new("body", i, &body.name);
            self.number(&at, "mass", &body.mass_kg, Must::NotNegative);
            self.vector(&at, "com", &body.com_m);
            self.inertia(&at, body);
            self.joint(&at.within("joint", "joint"), body);
        }
    }

    /// Parents exist, come first, and no body carries itself.
    fn tree(&mut self) {
        let plant = self.plant;
        let mut in_circle: Vec<&str> = Vec::new();
        for (i, body) in plant.bodies.iter().enumerate() {
            let Some(parent) = &body.parent else { continue };
            let at = At::new("body", i, &body.name);
            if !self.known_body(&at, "parent", parent) || in_circle.contains(&body.name.as_str()) {
                continue;
            }
            if let Some(circle) = circle(&plant.bodies, i) {
                let mut path = circle.clone();
                path.push(circle[0]);
                let message = format!("bodies carry each other in a cycle: {}", path.join(" → "));
                self.fault(&at, "parent", message, "one of them must have another parent, or none");
                in_circle.extend(circle);
            } else if !plant.bodies[..i].iter().any(|earlier| earlier.name == *parent) {
                let message = format!("{} stands before its parent '{parent}'", at.what);
                self.fault(&at, "parent", message, "parents come before their children");
            }
        }
    }

    fn inertia(&mut self, at: &At, body: &Body) {
        let [xx, yy, zz, xy, xz, yz] = body.inertia_com_kg_m2.map(|q| q.value);
        if let Some(worst) =
            body.inertia_com_kg_m2.iter().find(|q| !q.value.is_finite() || q.sigma.is_some_and(not_positive))
        {
            return self.number(at, "inertia", worst, Must::Finite);
        }
        let massless = body.mass_kg.value == 0.0;
        let carries = self.plant.bodies.iter().any(|other| other.parent.as_ref() == Some(&body.name));
        if massless && carries && [xx, yy, zz, xy, xz, yz].iter().all(|element| *element == 0.0) {
            return; // a massless link between two joints
        }
        if massless {
            let cure = "only a body that carries another may have neither mass nor inertia";
            self.fault(at, "mass", format!("mass of {} is zero", at.what), cure);
        }
        if self.planar() {
            // zero: a point mass; whether anything else turns with it is for the equations
            if zz < 0.0 {
                let message = format!("inertia of {} is negative: {zz} kg*m^2 about z", at.what);
                self.fault(at, "inertia", message, "zero is a point mass");
            }
            return;
        }
        let matrix = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let axes = if (xy, xz, yz) == (0.0, 0.0, 0.0) {
            ["x", "y", "z"]
        } else {
            ["principal axis 1", "principal axis 2", "principal axis 3"]
        };
        let diagonal = axes[0] == "x";
        let mut principal = if diagonal { [xx, yy, zz] } else { matrix.symmetric_eigenvalues().into() };
        if !diagonal {
            principal.sort_by(f64::total_cmp);
        }
        // zero: a thin rod, a point mass; eigenvalues are rounded
        let rounding = if diagonal { 0.0 } else { 1e-12 * principal[2] };
        if let Some(i) = (0..3).find(|i| principal[*i] < -rounding) {
            let [a, b, c] = principal;
            let message = format!("inertia of {} is negative about {}: {a}, {b}, {c} kg*m^2", at.what, axes[i]);
            return self.fault(at, "inertia", message, "no principal moment of inertia is below zero");
        }
        for i in 0..3 {
            let (largest, one, other) = (principal[i], principal[(i + 1) % 3], principal[(i + 2) % 3]);
            // 1e-9: a thin plate is at the limit, its numbers are rounded
            if largest > (one + other) * (1.0 + 1e-9) {
                let message = format!(
                    "inertia of {} about {} violates the triangle inequality: {largest} > {one} + {other} kg*m^2",
                    at.what, axes[i]
                );
                self.fault(at, "inertia", message, "no distribution of mass has it; is it about the centre of mass?");
            }
        }
    }

    fn joint(&mut self, at: &At, body: &Body) {
        let joint = &body.joint;
        match &joint.kind {
            JointKind::Free if body.parent.is_some() => {
                let message = format!("body '{}' is carried by another and free", body.name);
                self.fault(
                    at,
                    "kind",
                    message,
                    "only a body without a parent can be free; use a revolute or prismatic joint",
                );
            }
            JointKind::Free | JointKind::Fixed => {}
            JointKind::Revolute { axis } => self.axis(at, "axis", axis, true),
            JointKind::Prismatic { axis } => self.axis(at, "axis", axis, false),
        }
        self.vector(at, "position", &joint.position_m);
        self.axis(&at.within("orientation", "orientation"), "axis", &joint.orientation.axis, true);
        self.number(at, "orientation", &joint.orientation.angle_rad, Must::Finite);
        self.number(at, "friction", &joint.viscous_friction, Must::NotNegative);
        self.number(at, "rotor_inertia", &joint.rotor_inertia, Must::NotNegative);
        self.number(at, "stiffness", &joint.stiffness, Must::NotNegative);
        self.number(at, "rest", &joint.rest, Must::Finite);
    }

    pub(super) fn tanks(&mut self) {
        let plant = self.plant;
        for (i, tank) in plant.tanks.iter().enumerate() {
            let at = At::new("tank", i, &tank.name);
            self.known_body(&at, "body", &tank.body);
            self.vector(&at, "position", &tank.position_m);
            self.number(&at, "mass", &tank.mass_kg, Must::Positive);
            self.tank_model(&at, tank);
        }
    }

    fn tank_model(&mut self, at: &At, tank: &Tank) {
        match &tank.model {
            TankModel::Spring { axes, stiffness_n_m, damping_n_s_m } => {
                let axes_max = if self.planar() { 2 } else { 3 };
                if axes.is_empty() || axes.len() > axes_max {
                    let message = format!("{} has {} axes", at.what, axes.len());
                    self.fault(at, "axes", message, format!("a slosh mass has 1 to {axes_max} axes"));
                }
                axes.iter().for_each(|axis| self.axis(at, "axes", axis, false));
                self.independent(at, axes);
                for (key, list) in [("stiffness", stiffness_n_m), ("damping", damping_n_s_m)] {
                    if list.len() != axes.len() {
                        let message =
                            format!("{key} of {} has {} numbers for {} axes", at.what, list.len(), axes.len());
                        self.fault(at, key, message, "one number per axis");
                    }
                    list.iter().for_each(|number| self.number(at, key, number, Must::NotNegative));
                }
            }
            TankModel::Pendulum { rest, length_m, damping_n_m_s_rad } => {
                self.axis(at, "rest", rest, false);
                self.number(at, "length", length_m, Must::Positive);
                self.number(at, "damping", damping_n_m_s_rad, Must::NotNegative);
            }
        }
    }

    /// A slosh mass cannot move twice along one direction.
    fn independent(&mut self, at: &At, axes: &[[f64; 3]]) {
        let columns: Vec<Vector3<f64>> = axes.iter().map(|axis| Vector3::from(*axis)).collect();
        let cosine = |a: usize, b: usize| columns[a].dot(&columns[b]).abs();
        // directions a person writes down with four digits
        let parallel = 1.0 - 1e-8;
        let pair = (1..axes.len()).flat_map(|b| (0..b).map(move |a| (a, b))).find(|(a, b)| cosine(*a, *b) > parallel);
        if let Some((a, b)) = pair {
            let message = format!("axes {} and {} of {} are the same direction", a + 1, b + 1, at.what);
            self.fault(at, "axes", message, "name each direction once: a slosh mass moves both ways along it");
        } else if let [a, b, c] = columns[..]
            && a.cross(&b).dot(&c).abs() < 1e-8
        {
            let cure = "three axes span space; two are enough for a plane";
            self.fault(at, "axes", format!("the axes of {} lie in one plane", at.what), cure);
        }
    }

    pub(super) fn appendages(&mut self) {
        let plant = self.plant;
        for (i, appendage) in plant.appendages.iter().enumerate() {
            let at = At::new("appendage", i, &appendage.name);
            self.known_body(&at, "body", &appendage.body);
            for (k, (point, position)) in appendage.points.iter().enumerate() {
                if appendage.points[..k].iter().any(|(earlier, _)| earlier == point) {
                    self.fault(&at, "points", format!("{} has two points '{point}'", at.what), "");
                }
                self.name(&at.within("points", "points"), point, "point", point);
                self.vector(&at.within("points", "points"), point, position);
            }
            if appendage.modes.is_empty() {
                let cure = "add an [[appendage.mode]]; undeformed it belongs to the body's mass and inertia";
                self.fault(&at, "mode", format!("{} has no mode", at.what), cure);
            }
            for (k, mode) in appendage.modes.iter().enumerate() {
                let at = at.within(&format!("mode.{k}"), &format!("mode '{}'", mode.name));
                self.mode(&at, appendage, mode);
            }
        }
    }

    fn mode(&mut self, at: &At, appendage: &Appendage, mode: &Mode) {
        self.number(at, "frequency", &mode.frequency_hz, Must::Positive);
        self.number(at, "damping_ratio", &mode.damping_ratio, Must::NotNegative);
        self.vector(at, "translation", &mode.translation_sqrt_kg);
        self.turning(at, "rotation", &mode.rotation_sqrt_kg_m);
        if mode.shape_per_sqrt_kg.len() != appendage.points.len() {
            let (shapes, points) = (mode.shape_per_sqrt_kg.len(), appendage.points.len());
            let message = format!("{} has {shapes} shapes for {points} points", at.what);
            self.fault(at, "shape", message, "one displacement per point of the appendage");
        }
        for ((point, _), shape) in appendage.points.iter().zip(&mode.shape_per_sqrt_kg) {
            self.vector(&at.within("shape", "shape"), point, shape);
        }
    }
}

/// The bodies that carry body `start` and one another in a cycle with it, if they do.
fn circle(bodies: &[Body], start: usize) -> Option<Vec<&str>> {
    let mut path = vec![bodies[start].name.as_str()];
    let mut at = &bodies[start];
    for _ in 0..bodies.len() {
        let parent = at.parent.as_deref()?;
        if parent == bodies[start].name {
            return Some(path);
        }
        path.push(parent);
        at = bodies.iter().find(|body| body.name == parent)?;
    }
    None
}
