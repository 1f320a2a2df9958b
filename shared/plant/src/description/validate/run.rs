//! Environment, initial states, segments, numerical settings, effects.

use super::{At, Check, Fault, Must};
use crate::description::{ActuatorKind, EffectUse, Initial, JointKind, Plant, SiteKind, TankModel};
use crate::effects::Effect;

impl Check<'_> {
    pub(super) fn environment(&mut self) {
        let environment = &self.plant.environment;
        let at = At::new("environment", 0, "");
        let plant = At::new("plant", 0, &self.plant.name);
        self.vector(&plant, "gravity", &environment.gravity_m_s2);
        self.vector(&at, "constant_force", &environment.constant_force_n);
        self.turning(&at, "constant_torque", &environment.constant_torque_n_m);
        if let Some(gradient) = &environment.gravity_gradient {
            let at = at.within("gravity_gradient", "gravity_gradient");
            self.number(&at, "orbit_rate", &gradient.orbit_rate_rad_s, Must::Positive);
            self.number(&at, "phase", &gradient.phase_rad, Must::Finite);
        }
        if let Some(atmosphere) = &environment.atmosphere {
            let at = at.within("atmosphere", "atmosphere");
            self.number(&at, "density", &atmosphere.density_kg_m3, Must::NotNegative);
            self.vector(&at, "wind", &atmosphere.wind_m_s);
        }
        if let Some(field) = &environment.magnetic_field {
            // not `vector`: a field may cross the plane
            field.field_t.iter().for_each(|component| self.number(&at, "magnetic_field", component, Must::Finite));
        }
    }

    pub(super) fn beginnings(&mut self) {
        let plant = self.plant;
        self.initial(&At::new("initial", 0, ""), &plant.initial);
        for (i, segment) in plant.segments.iter().enumerate() {
            let at = At::new("segment", i, &segment.name);
            self.number(&at, "begin", &segment.begin_s, Must::Finite);
            self.end(&at, &segment.begin_s, segment.end_s.as_ref());
            self.initial(&at.within("initial", "initial"), &segment.initial);
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
            let at = at.within(name, name);
            self.number(&at, "position", &value.position, Must::Finite);
            self.number(&at, "rate", &value.rate, Must::Finite);
        }
        if let Some(momentum) = &initial.momentum_com_n_m_s {
            self.turning(at, "momentum", momentum);
            let free = plant.bodies.iter().any(|body| body.joint.kind == JointKind::Free);
            if !free {
                let cure = "only a system that floats freely has a momentum of its own";
                self.fault(at, "momentum", "momentum of a plant without a free body", cure);
            }
        }
        if initial.on_reference && plant.controllers.is_empty() {
            self.fault(at, "on_reference", "on_reference, and no controller has a reference", "");
        }
    }

    pub(super) fn simulation(&mut self) {
        let settings = &self.plant.simulation;
        let at = At::new("simulation", 0, "");
        for (key, value) in
            [("duration", settings.duration_s), ("period", settings.period_s), ("step", settings.step_s)]
        {
            if !(value > 0.0 && value.is_finite()) {
                self.fault(&at, key, format!("{key} of the simulation is not above zero: {value} s"), "");
            }
        }
        if !(settings.jitter_s >= 0.0 && settings.jitter_s.is_finite()) {
            let message = format!("jitter of the simulation is negative: {} s", settings.jitter_s);
            self.fault(&at, "jitter", message, "");
        }
    }

    pub(super) fn effects(&mut self) {
        let plant = self.plant;
        for (i, effect) in plant.effects.iter().enumerate() {
            let at = At::new("effect", i, &effect.kind);
            match crate::description::known_kind(&effect.kind) {
                Ok(entry) => self.effect(&at, entry, effect),
                Err(message) => self.sentence(&at, "kind", &message),
            }
        }
    }

    fn effect(&mut self, at: &At, entry: &Effect, effect: &EffectUse) {
        if let Err(message) = crate::description::check_site(self.plant, entry, &effect.site) {
            self.sentence(at, "site", &message);
        }
        for (name, quantity) in &effect.values {
            match crate::description::known_parameter(entry, name) {
                Err(message) => self.sentence(at, name, &message),
                Ok(parameter) => {
                    self.number(at, name, quantity, Must::Finite);
                    if quantity.value < parameter.low || quantity.value > parameter.high {
                        let (value, low, high, unit) = (quantity.value, parameter.low, parameter.high, parameter.unit);
                        let message = format!(
                            "{name} = {value} of {} is outside its plausible range {low} … {high} {unit}",
                            at.what
                        );
                        let cure = parameter.what.to_owned();
                        self.faults.push(Fault { place: at.place(name), message, cure, warning: true });
                    }
                }
            }
        }
    }

    /// "message; cure" as one.
    fn sentence(&mut self, at: &At, key: &str, sentence: &str) {
        let (message, cure) = sentence.split_once("; ").unwrap_or((sentence, ""));
        self.fault(at, key, message, cure);
    }
}

/// Every coordinate that can begin somewhere.
fn coordinates(plant: &Plant) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for body in plant.bodies.iter().filter(|body| body.joint.kind == JointKind::Free) {
        let components: &[&str] = match plant.space {
            crate::description::Space::Planar => &["x", "y", "rz"],
            crate::description::Space::Spatial => &["x", "y", "z", "rx", "ry", "rz"],
        };
        list.extend(components.iter().map(|component| format!("body:{}.{component}", body.name)));
    }
    list.extend(plant.sites(SiteKind::Joint).iter().map(ToString::to_string));
    for tank in &plant.tanks {
        let count = match &tank.model {
            TankModel::Spring { axes, .. } => axes.len(),
            TankModel::Pendulum { .. } => {
                if plant.space == crate::description::Space::Planar {
                    1
                } else {
                    2
                }
            }
        };
        list.push(format!("tank:{}", tank.name));
        list.extend((2..=count).map(|k| format!("tank:{}.{k}", tank.name)));
    }
    list.extend(plant.sites(SiteKind::Mode).iter().map(ToString::to_string));
    let wheels = plant.actuators.iter().filter(|actuator| matches!(actuator.kind, ActuatorKind::Wheel { .. }));
    list.extend(wheels.map(|wheel| format!("wheel:{}", wheel.name)));
    list
}
