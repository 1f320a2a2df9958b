//! Initial states and segments.

use super::{At, Check, Must};
use dynamics::description::{
    ActuatorKind, Initial, InitialValue, JointKind, Plant, Prescribed, SiteKind, Space, TankModel,
};

impl Check<'_> {
    pub(super) fn beginnings(&mut self) {
        let plant = self.plant;
        self.initial(&At::new("initial", 0, ""), &plant.initial);
        for (i, segment) in plant.segments.iter().enumerate() {
            let at = At::new("segment", i, &segment.name);
            self.number(&at, "begin", &segment.begin_s, Must::NotNegative);
            self.end(&at, &segment.begin_s, segment.end_s.as_ref());
            self.initial(&at.within("initial", "initial"), &segment.initial);
            self.order(&at, i);
        }
    }

    /// Segments follow one another within the record.
    fn order(&mut self, at: &At, index: usize) {
        let plant = self.plant;
        let (begin_s, duration_s) = (plant.segments[index].begin_s.value, plant.simulation.duration_s);
        if begin_s >= duration_s {
            let message = format!("{} begins at {begin_s} s, and the record ends at {duration_s} s", at.what);
            self.warn(at, "begin", message, "nothing of it is recorded");
            self.because_of([At::new("simulation", 0, "").place("duration")]);
        }
        let Some(earlier) = index.checked_sub(1).map(|before| &plant.segments[before]) else { return };
        let before = At::new("segment", index - 1, &earlier.name);
        if begin_s <= earlier.begin_s.value {
            let message =
                format!("{} begins at {begin_s} s, not after {} at {} s", at.what, before.what, earlier.begin_s.value);
            self.fault(at, "begin", message, "segments stand in the order of time");
            self.because_of([before.place("begin")]);
        } else if let Some(end) = earlier.end_s.filter(|end| end.value > begin_s) {
            let message = format!("{} ends at {} s, after {} begins at {begin_s} s", before.what, end.value, at.what);
            self.fault(&before, "end", message, "segments follow one another: leave end out, or end it earlier");
            self.because_of([at.place("begin")]);
        }
    }

    fn initial(&mut self, at: &At, initial: &Initial) {
        let plant = self.plant;
        let known = coordinates(plant);
        for (i, value) in initial.values.iter().enumerate() {
            let name = &value.coordinate;
            if initial.values[..i].iter().any(|earlier| earlier.coordinate == *name) {
                self.fault(at, name, format!("'{name}' begins twice"), "");
            }
            self.known(at, name, "coordinate", name, known.iter());
            self.not_imposed(at, value);
            let at = at.within(name, name);
            self.number(&at, "position", &value.position, Must::Finite);
            self.number(&at, "rate", &value.rate, Must::Finite);
        }
        if let Some(momentum) = &initial.momentum_com_n_m_s {
            self.turning(at, "momentum", momentum);
            let free = plant.bodies.first().is_some_and(|body| body.joint.kind == JointKind::Free);
            if !free {
                let cure = "only a system that floats freely, its first body free, has a momentum of its own";
                self.fault(at, "momentum", "momentum of a plant whose first body is not free", cure);
                self.because_of([At::new("body", 0, "").place("joint.kind")]);
            }
        }
        if initial.on_reference && plant.controllers.is_empty() {
            self.fault(at, "on_reference", "on_reference, and no controller has a reference", "");
        }
    }

    /// A joint whose motion is imposed begins where that motion does.
    fn not_imposed(&mut self, at: &At, value: &InitialValue) {
        let joint = value.coordinate.strip_prefix("joint:");
        for (i, actuator) in self.plant.actuators.iter().enumerate() {
            let ActuatorKind::PrescribedJoint { joint: imposed, what } = &actuator.kind else { continue };
            let (name, driver) = (&value.coordinate, &actuator.name);
            if joint != Some(imposed.as_str()) {
                continue;
            }
            let key = match what {
                Prescribed::Position => name.clone(),
                Prescribed::Rate if value.rate.value != 0.0 => format!("{name}.rate"),
                _ => continue,
            };
            let message = format!("'{name}' cannot begin anywhere: '{driver}' imposes its motion");
            self.fault(at, &key, message, "leave it out, or let the command begin there");
            self.because_of(["kind", "what", "joint"].map(|key| At::new("actuator", i, "").place(key)));
        }
    }
}

/// Every coordinate that can begin somewhere.
fn coordinates(plant: &Plant) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    let planar = plant.space == Space::Planar;
    for body in plant.bodies.iter().filter(|body| body.joint.kind == JointKind::Free) {
        let components: &[&str] = if planar { &["x", "y", "rz"] } else { &["x", "y", "z", "rx", "ry", "rz"] };
        list.extend(components.iter().map(|component| format!("body:{}.{component}", body.name)));
    }
    list.extend(plant.sites(SiteKind::Joint).iter().map(ToString::to_string));
    for tank in &plant.tanks {
        let count = match &tank.model {
            TankModel::Spring { axes, .. } => axes.len(),
            TankModel::Pendulum { .. } => 2 - usize::from(planar),
        };
        list.push(format!("tank:{}", tank.name));
        list.extend((2..=count).map(|k| format!("tank:{}.{k}", tank.name)));
    }
    list.extend(plant.sites(SiteKind::Mode).iter().map(ToString::to_string));
    let wheels = plant.actuators.iter().filter(|actuator| matches!(actuator.kind, ActuatorKind::Wheel { .. }));
    list.extend(wheels.map(|wheel| format!("wheel:{}", wheel.name)));
    list
}
