//! Environment, numerical settings, effects.

use super::{At, Check, Must};
use dynamics::description::{EffectUse, implausible};
use dynamics::effect::{Effect, Needs};

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
        self.felt(&at);
    }

    /// Atmosphere and field act through effects alone.
    fn felt(&mut self, at: &At) {
        let plant = self.plant;
        let stated = &plant.environment;
        for (key, given, needs) in [
            ("atmosphere", stated.atmosphere.is_some(), Needs::Atmosphere),
            ("magnetic_field", stated.magnetic_field.is_some(), Needs::MagneticField),
        ] {
            let entries = plant.catalogue.entries().iter().filter(|effect| effect.needs == needs);
            let kinds: Vec<&str> = entries.map(|effect| effect.kind).collect();
            if given && !plant.effects.iter().any(|effect| kinds.contains(&effect.kind.as_str())) {
                let cure = format!("add an [[effect]]: {}", kinds.join(", "));
                self.warn(at, key, format!("nothing in the plant feels the {key}").replace('_', " "), cure);
            }
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
            match plant.catalogue.known(&effect.kind) {
                Ok(entry) => self.effect(&at, entry, effect),
                Err(message) => self.sentence(&at, "kind", &message),
            }
        }
    }

    fn effect(&mut self, at: &At, entry: &'static Effect, effect: &EffectUse) {
        if let Err(message) = dynamics::description::check_site(self.plant, entry, &effect.site) {
            self.sentence(at, "site", &message);
        }
        for (name, quantity) in &effect.values {
            match dynamics::description::known_parameter(entry, name) {
                Err(message) => self.sentence(at, name, &message),
                Ok(_) => self.number(at, name, quantity, Must::Finite),
            }
        }
        for (name, message, cure) in implausible(self.plant, entry, effect) {
            self.warn(at, name, message, cure);
        }
    }

    /// "message; cure" as one.
    fn sentence(&mut self, at: &At, key: &str, sentence: &str) {
        let (message, cure) = sentence.split_once("; ").unwrap_or((sentence, ""));
        self.fault(at, key, message, cure);
    }
}
