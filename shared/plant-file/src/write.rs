//! A plant as a file that parses to an equal plant: SI units, shortest digits that read back to the
//! same double, no comments.

mod parts;

use core::fmt::Write;
use dynamics::description::{EffectUse, Environment, Initial, Plant, Quantity, Scope, Space};

/// The plant file of `plant`; equal plants give equal text.
///
/// A plant without errors ([`validate`](crate::validate::validate)) reads back equal.
pub fn write(plant: &Plant) -> String {
    let mut file = Writer { text: String::new(), planar: plant.space == Space::Planar };
    file.line("format", "1");
    file.text("name", &plant.name);
    file.text("about", &plant.about);
    file.text("space", if file.planar { "planar" } else { "spatial" });
    file.vector("gravity", &plant.environment.gravity_m_s2, "m/s^2");
    file.environment(&plant.environment);
    plant.bodies.iter().for_each(|body| file.body(body));
    plant.tanks.iter().for_each(|tank| file.tank(tank));
    plant.appendages.iter().for_each(|appendage| file.appendage(appendage));
    plant.actuators.iter().for_each(|actuator| file.actuator(plant, actuator));
    plant.controllers.iter().for_each(|controller| file.controller(plant, controller));
    plant.sources.iter().for_each(|source| file.source(source));
    plant.sensors.iter().for_each(|sensor| file.sensor(plant, sensor));
    file.initial(plant, "[initial]", &plant.initial);
    for segment in &plant.segments {
        file.header("[[segment]]");
        file.text("name", &segment.name);
        file.quantity("begin", &segment.begin_s, "s");
        segment.end_s.iter().for_each(|end| file.quantity("end", end, "s"));
        file.initial(plant, "[segment.initial]", &segment.initial);
    }
    file.simulation(&plant.simulation);
    plant.effects.iter().for_each(|effect| file.effect(plant, effect));
    file.text
}

struct Writer {
    text: String,
    planar: bool,
}

/// Shortest digits that read back to the same double.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) { format!("{value}") } else { format!("{value:e}") }
}

/// TOML's basic string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04X}", c as u32)),
            c => quoted.push(c),
        }
    }
    quoted + "\""
}

fn with_unit(value: f64, unit: &str) -> String {
    if value == 0.0 || unit == "1" || unit.is_empty() { number(value) } else { format!("\"{} {unit}\"", number(value)) }
}

fn value(quantity: &Quantity, unit: &str) -> String {
    let plain = with_unit(quantity.value, unit);
    if quantity.sigma.is_none() && quantity.scope == Scope::Shared {
        return plain;
    }
    let mut text = format!("{{ value = {plain}");
    if let Some(sigma) = quantity.sigma {
        let _ = write!(text, ", sigma = {}", with_unit(sigma, unit));
    }
    match quantity.scope {
        Scope::Shared => {}
        Scope::PerRecording => text.push_str(", scope = \"per recording\""),
        Scope::PerSegment => text.push_str(", scope = \"per segment\""),
    }
    text + " }"
}

fn list<'q>(quantities: impl IntoIterator<Item = &'q Quantity>, unit: &str) -> String {
    let values: Vec<String> = quantities.into_iter().map(|quantity| value(quantity, unit)).collect();
    format!("[{}]", values.join(", "))
}

fn direction(axis: &[f64; 3]) -> String {
    for (letter, sign, i) in
        [("x", 1.0, 0), ("-x", -1.0, 0), ("y", 1.0, 1), ("-y", -1.0, 1), ("z", 1.0, 2), ("-z", -1.0, 2)]
    {
        if (0..3).all(|k| axis[k] == if k == i { sign } else { 0.0 }) {
            return quoted(letter);
        }
    }
    let [x, y, z] = axis.map(number);
    format!("[{x}, {y}, {z}]")
}

fn is_zero(quantity: &Quantity) -> bool {
    *quantity == Quantity::known(0.0)
}

impl Writer {
    fn header(&mut self, header: &str) {
        let _ = writeln!(self.text, "\n{header}");
    }

    fn line(&mut self, key: &str, value: &str) {
        let _ = writeln!(self.text, "{key} = {value}");
    }

    fn text(&mut self, key: &str, text: &str) {
        self.line(key, &quoted(text));
    }

    fn quantity(&mut self, key: &str, quantity: &Quantity, unit: &str) {
        self.line(key, &value(quantity, unit));
    }

    /// Leaves out what the reader supplies.
    fn unless_zero(&mut self, key: &str, quantity: &Quantity, unit: &str) {
        if !is_zero(quantity) {
            self.quantity(key, quantity, unit);
        }
    }

    /// `[x, y]` in a plane.
    fn components<'q>(&self, vector: &'q [Quantity; 3]) -> &'q [Quantity] {
        if self.planar && is_zero(&vector[2]) { &vector[..2] } else { vector }
    }

    fn vector(&mut self, key: &str, vector: &[Quantity; 3], unit: &str) {
        if !vector.iter().all(is_zero) {
            self.line(key, &list(self.components(vector), unit));
        }
    }

    fn turning_text(&self, vector: &[Quantity; 3], unit: &str) -> String {
        if self.planar { value(&vector[2], unit) } else { list(vector, unit) }
    }

    fn turning(&mut self, key: &str, vector: &[Quantity; 3], unit: &str) {
        if !vector.iter().all(is_zero) {
            self.line(key, &self.turning_text(vector, unit));
        }
    }

    fn environment(&mut self, environment: &Environment) {
        let Environment { gravity_m_s2, .. } = *environment;
        if *environment == (Environment { gravity_m_s2, ..Environment::default() }) {
            return;
        }
        self.header("[environment]");
        self.vector("constant_force", &environment.constant_force_n, "N");
        self.turning("constant_torque", &environment.constant_torque_n_m, "N*m");
        if let Some(gradient) = &environment.gravity_gradient {
            let (rate, phase) = (value(&gradient.orbit_rate_rad_s, "rad/s"), value(&gradient.phase_rad, "rad"));
            self.line("gravity_gradient", &format!("{{ orbit_rate = {rate}, phase = {phase} }}"));
        }
        if let Some(atmosphere) = &environment.atmosphere {
            let density = value(&atmosphere.density_kg_m3, "kg/m^3");
            let wind = list(self.components(&atmosphere.wind_m_s), "m/s");
            self.line("atmosphere", &format!("{{ density = {density}, wind = {wind} }}"));
        }
        if let Some(field) = &environment.magnetic_field {
            self.line("magnetic_field", &list(self.components(&field.field_t), "T"));
        }
    }

    fn initial(&mut self, plant: &Plant, header: &str, initial: &Initial) {
        if *initial == Initial::default() {
            return;
        }
        self.header(header);
        if let Some(momentum) = &initial.momentum_com_n_m_s {
            self.line("momentum", &self.turning_text(momentum, "N*m*s"));
        }
        if initial.on_reference {
            self.line("on_reference", "true");
        }
        for of in &initial.values {
            let (unit, rate_unit) = plant.initial_unit(&of.coordinate);
            let both = format!("{{ position = {}, rate = {} }}", value(&of.position, unit), value(&of.rate, rate_unit));
            self.line(&quoted(&of.coordinate), &both);
        }
    }

    fn effect(&mut self, plant: &Plant, effect: &EffectUse) {
        self.header("[[effect]]");
        self.text("kind", &effect.kind);
        self.text("site", &effect.site.to_string());
        let entry = plant.catalogue.effect(&effect.kind);
        for (name, quantity) in &effect.values {
            let parameter = entry.and_then(|entry| entry.parameters.iter().find(|parameter| parameter.name == *name));
            let unit = parameter.map_or("1", |parameter| parameter.unit);
            let unit = super::run::readable(plant.effect_unit(effect, unit));
            self.quantity(name, quantity, &unit);
        }
    }
}
