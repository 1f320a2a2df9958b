//! The combinations of a planar craft's numbers that its motion can tell, under short names.
//!
//! For a free hub with a tree of revolute links, springs of fuel, flexible modes and wheels. Bodies
//! that are fixed to a link count as part of it. With `m_k` the masses beyond joint k, its link
//! included, and `p_k` where joint k sits on its inboard link:
//! `M = Σ m`, `h = m₀ c₀ + Σ m_k p_k`, `J0 = I₀ + m₀ |c₀|² + Σ m_k |p_k|²`, and for link i the same
//! about its joint: `s_i` (2), `J_i`. How masses divide between a link's own and what it carries
//! leaves no trace in the motion (design page "study case", 2).

use super::{ActuatorKind, Body, JointKind, Mode, Plant, Quantity, Space, TankModel};

/// A number that motion tells, SI.
#[derive(Clone, Debug, PartialEq)]
pub struct BaseValue {
    /// As `M`, `hx`, `s1x`, `kx_ms`, `Pr1`.
    pub name: String,
    pub unit: &'static str,
    pub value: f64,
}

/// Mass \[kg\], first moment [kg m] and second moment [kg m²] about the origin of a link's axes.
#[derive(Clone, Copy, Default)]
struct Moments {
    mass_kg: f64,
    first_kg_m: [f64; 2],
    second_kg_m2: f64,
}

impl Moments {
    fn add_point(&mut self, mass_kg: f64, [x, y]: [f64; 2]) {
        self.mass_kg += mass_kg;
        self.first_kg_m[0] += mass_kg * x;
        self.first_kg_m[1] += mass_kg * y;
        self.second_kg_m2 += mass_kg * (x * x + y * y);
    }
}

/// Where a body's axes stand in those of the link that it is part of.
#[derive(Clone, Copy)]
struct Place {
    link: usize,
    at_m: [f64; 2],
    angle_rad: f64,
}

impl Place {
    fn point(&self, position: &[Quantity; 3]) -> [f64; 2] {
        let (sin, cos) = (libm::sin(self.angle_rad), libm::cos(self.angle_rad));
        let [x, y] = [position[0].value, position[1].value];
        [self.at_m[0] + cos * x - sin * y, self.at_m[1] + sin * x + cos * y]
    }
}

impl Plant {
    /// The numbers that motion tells, in the order hub, links, fuel, modes, wheels; none for a
    /// plant in space or one whose root is not free or that slides in a joint.
    #[must_use]
    pub fn planar_base_values(&self) -> Vec<BaseValue> {
        let Some(links) = self.links() else { return Vec::new() };
        let mut list = Vec::new();
        let mut put = |name: String, unit, value| list.push(BaseValue { name, unit, value });
        let hub = links[0].1;
        put("M".into(), "kg", hub.mass_kg);
        put("hx".into(), "kg*m", hub.first_kg_m[0]);
        put("hy".into(), "kg*m", hub.first_kg_m[1]);
        put("J0".into(), "kg*m^2", hub.second_kg_m2);
        for (i, (_, link)) in links.iter().enumerate().skip(1) {
            put(format!("s{i}x"), "kg*m", link.first_kg_m[0]);
            put(format!("s{i}y"), "kg*m", link.first_kg_m[1]);
            put(format!("J{i}"), "kg*m^2", link.second_kg_m2);
        }
        for (i, (body, _)) in links.iter().enumerate().skip(1) {
            put(format!("Ir{i}"), "kg*m^2", body.joint.rotor_inertia.value);
        }
        for (i, (body, _)) in links.iter().enumerate().skip(1) {
            put(format!("fv{i}"), "N*m*s/rad", body.joint.viscous_friction.value);
        }
        self.fuel(&mut put);
        let modes: Vec<&Mode> = self.appendages.iter().flat_map(|appendage| &appendage.modes).collect();
        for (k, mode) in modes.iter().enumerate() {
            self.mode(k + 1, mode, &mut put);
        }
        self.wheels(&mut put);
        list
    }

    /// Each link with its moments, all that hangs on it included as points at its joints; the hub
    /// first.
    fn links(&self) -> Option<Vec<(&Body, Moments)>> {
        if self.space != Space::Planar || self.bodies.first()?.joint.kind != JointKind::Free {
            return None;
        }
        let mut places: Vec<Place> = Vec::new();
        let mut links: Vec<(&Body, Moments)> = Vec::new();
        let mut inboard: Vec<Option<(usize, [f64; 2])>> = Vec::new();
        for body in &self.bodies {
            let parent = body.parent.as_ref().and_then(|name| self.bodies.iter().position(|other| other.name == *name));
            let carried = parent.map(|parent| places[parent]);
            let place = match (&body.joint.kind, carried) {
                (JointKind::Fixed, Some(parent)) => {
                    let turn = body.joint.orientation.angle_rad.value * body.joint.orientation.axis[2];
                    Place { at_m: parent.point(&body.joint.position_m), angle_rad: parent.angle_rad + turn, ..parent }
                }
                (JointKind::Revolute { .. }, Some(parent)) => {
                    inboard.push(Some((parent.link, parent.point(&body.joint.position_m))));
                    links.push((body, Moments::default()));
                    Place { link: links.len() - 1, at_m: [0.0; 2], angle_rad: 0.0 }
                }
                (JointKind::Free, None) if links.is_empty() => {
                    inboard.push(None);
                    links.push((body, Moments::default()));
                    Place { link: 0, at_m: [0.0; 2], angle_rad: 0.0 }
                }
                _ => return None,
            };
            let own = &mut links[place.link].1;
            own.add_point(body.mass_kg.value, place.point(&body.com_m));
            own.second_kg_m2 += body.inertia_com_kg_m2[2].value;
            places.push(place);
        }
        for k in (1..links.len()).rev() {
            let (parent, at_m) = inboard[k]?;
            let mass_kg = links[k].1.mass_kg;
            links[parent].1.add_point(mass_kg, at_m);
        }
        Some(links)
    }

    fn fuel(&self, put: &mut dyn FnMut(String, &'static str, f64)) {
        let many = self.tanks.len() > 1;
        for (k, tank) in self.tanks.iter().enumerate() {
            let end = if many { (k + 1).to_string() } else { String::new() };
            let mass_kg = tank.mass_kg.value;
            put(format!("ms{end}"), "kg", mass_kg);
            if let TankModel::Spring { axes, stiffness_n_m, damping_n_s_m } = &tank.model {
                for (axis, stiffness) in axes.iter().zip(stiffness_n_m) {
                    put(format!("k{}_ms{end}", letter(axis)), "1/s^2", stiffness.value / mass_kg);
                }
                for (axis, damping) in axes.iter().zip(damping_n_s_m) {
                    put(format!("c{}_ms{end}", letter(axis)), "1/s", damping.value / mass_kg);
                }
            }
            put(format!("bx{end}"), "m", tank.position_m[0].value);
            put(format!("by{end}"), "m", tank.position_m[1].value);
        }
    }

    fn mode(&self, k: usize, mode: &Mode, put: &mut dyn FnMut(String, &'static str, f64)) {
        let turn = mode.rotation_sqrt_kg_m[2].value;
        put(format!("w{k}"), "rad/s", core::f64::consts::TAU * mode.frequency_hz.value);
        put(format!("z{k}"), "1", mode.damping_ratio.value);
        put(format!("Pr{k}"), "sqrt(kg)*m", turn);
        let along = |vector: &[Quantity; 3]| -> Vec<(&'static str, f64)> {
            let seen = |axis: &usize| vector[*axis].value != 0.0 || vector[*axis].sigma.is_some();
            let shown: Vec<usize> = (0..2).filter(seen).collect();
            let name = |axis: usize| if shown.len() == 1 { "" } else { ["x", "y"][axis] };
            shown.iter().map(|axis| (name(*axis), vector[*axis].value)).collect()
        };
        for (axis, value) in along(&mode.translation_sqrt_kg) {
            put(format!("Pt{axis}_Pr{k}"), "1/m", value / turn);
        }
        let points = self.appendages.iter().find(|one| one.modes.iter().any(|m| m.name == mode.name));
        let points = points.map_or(&[][..], |one| &one.points);
        for ((point, _), shape) in points.iter().zip(&mode.shape_per_sqrt_kg) {
            let first = |name: &str| name.chars().next();
            let alone = points.iter().filter(|(other, _)| first(other) == first(point)).count() == 1;
            let short = if alone { first(point).map(String::from).unwrap_or_default() } else { format!("_{point}") };
            for (axis, value) in along(shape) {
                put(format!("ph{short}{axis}_Pr{k}"), "m", value * turn);
            }
        }
    }

    fn wheels(&self, put: &mut dyn FnMut(String, &'static str, f64)) {
        let wheel = |kind: &ActuatorKind| match kind {
            ActuatorKind::Wheel { inertia_kg_m2, viscous_friction_n_m_s_rad, .. } => {
                Some((inertia_kg_m2.value, viscous_friction_n_m_s_rad.value))
            }
            _ => None,
        };
        let wheels: Vec<(f64, f64)> = self.actuators.iter().filter_map(|actuator| wheel(&actuator.kind)).collect();
        for (k, (inertia_kg_m2, friction)) in wheels.iter().enumerate() {
            let end = if wheels.len() > 1 { (k + 1).to_string() } else { String::new() };
            put(format!("Jw{end}"), "kg*m^2", *inertia_kg_m2);
            put(format!("fw{end}"), "N*m*s/rad", *friction);
        }
    }
}

fn letter(axis: &[f64; 3]) -> &'static str {
    let largest = (0..3).max_by(|a, b| axis[*a].abs().total_cmp(&axis[*b].abs())).unwrap_or(0);
    ["x", "y", "z"][largest]
}
