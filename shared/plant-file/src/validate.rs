//! What no plant can be: every fault at once, each with its place, its numbers and a cure.
//!
//! Holds for plants read from files and plants built in code; the file reader adds where in the
//! text a place stands.

mod beginnings;
mod bodies;
mod equations;
mod inputs;
mod limits;
mod outputs;
mod participation;
mod run;

pub(crate) use equations::with_faults_of_equations;

use dynamics::description::{Plant, Quantity, Space, suggestion};

/// Where in a description something stands: `body` number 2, key `joint.axis`. Nested lists count
/// from 0: `mode.0.frequency`.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// `plant`, `environment`, `body`, `tank`, `appendage`, `actuator`, `controller`, `source`,
    /// `sensor`, `initial`, `segment`, `simulation` or `effect`.
    pub section: &'static str,
    pub index: usize,
    pub key: String,
}

/// Something that cannot be, or is not plausible.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    pub place: Place,
    pub message: String,
    /// Empty where none is known.
    pub cure: String,
    /// Not plausible, but possible.
    pub warning: bool,
    /// Other places whose numbers make it so.
    pub because_of: Vec<Place>,
}

impl core::fmt::Display for Fault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.message)?;
        if self.cure.is_empty() { Ok(()) } else { write!(f, "; {}", self.cure) }
    }
}

/// Every fault, in file order; a plant without errors (warnings aside) can be compiled and
/// simulated.
///
/// Cost: where its parts are possible, one compilation.
pub fn validate(plant: &Plant) -> Vec<Fault> {
    with_faults_of_equations(plant, faults_of_parts(plant))
}

/// What is wrong with each part by itself and with its references.
pub(crate) fn faults_of_parts(plant: &Plant) -> Vec<Fault> {
    let mut check = Check { plant, faults: Vec::new() };
    check.names();
    check.environment();
    check.bodies();
    check.tanks();
    check.appendages();
    check.participation();
    check.actuators();
    check.controllers();
    check.sources();
    check.sensors();
    check.beginnings();
    check.simulation();
    check.sizes();
    check.effects();
    check.faults
}

/// The faults found so far.
struct Check<'p> {
    plant: &'p Plant,
    faults: Vec<Fault>,
}

/// One table of a description: where it is and what it is called in messages.
struct At {
    section: &'static str,
    index: usize,
    prefix: String,
    what: String,
}

impl At {
    fn new(section: &'static str, index: usize, name: &str) -> Self {
        let what = if name.is_empty() { section.to_owned() } else { format!("{section} '{name}'") };
        Self { section, index, prefix: String::new(), what }
    }

    fn within(&self, prefix: &str, what: &str) -> Self {
        let prefix = format!("{}{prefix}.", self.prefix);
        let what = if what.is_empty() { self.what.clone() } else { format!("{what} of {}", self.what) };
        Self { section: self.section, index: self.index, prefix, what }
    }

    fn place(&self, key: &str) -> Place {
        Place { section: self.section, index: self.index, key: format!("{}{key}", self.prefix) }
    }
}

/// What a number must be.
#[derive(Clone, Copy, PartialEq)]
enum Must {
    Finite,
    NotNegative,
    Positive,
}

impl Check<'_> {
    fn fault(&mut self, at: &At, key: &str, message: impl Into<String>, cure: impl Into<String>) {
        let (place, message, cure) = (at.place(key), message.into(), cure.into());
        self.faults.push(Fault { place, message, cure, warning: false, because_of: Vec::new() });
    }

    fn warn(&mut self, at: &At, key: &str, message: impl Into<String>, cure: impl Into<String>) {
        let (place, message, cure) = (at.place(key), message.into(), cure.into());
        self.faults.push(Fault { place, message, cure, warning: true, because_of: Vec::new() });
    }

    /// The last fault also hangs on other numbers.
    fn because_of(&mut self, places: impl IntoIterator<Item = Place>) {
        if let Some(fault) = self.faults.last_mut() {
            fault.because_of.extend(places);
        }
    }

    fn number(&mut self, at: &At, key: &str, quantity: &Quantity, must: Must) {
        let Quantity { value, sigma, .. } = *quantity;
        let what = format!("{key} of {}", at.what);
        let ok = match must {
            Must::Finite => value.is_finite(),
            Must::NotNegative => value.is_finite() && value >= 0.0,
            Must::Positive => value.is_finite() && value > 0.0,
        };
        if !ok {
            let (wrong, cure) = match must {
                _ if !value.is_finite() => ("not a finite number", ""),
                Must::NotNegative => ("negative", "zero or more is possible"),
                _ if value < 0.0 => ("negative", "it must be above zero"),
                _ => ("zero", "it must be above zero"),
            };
            self.fault(at, key, format!("{what} is {wrong}: {value}"), cure);
        }
        if sigma.is_some_and(|sigma| !(sigma.is_finite() && sigma > 0.0)) {
            let sigma = sigma.unwrap_or_default();
            let cure = "a number that is known exactly has no sigma";
            self.fault(at, key, format!("prior standard deviation of {what} is not above zero: {sigma}"), cure);
        }
    }

    fn optional(&mut self, at: &At, key: &str, quantity: Option<&Quantity>, must: Must) {
        if let Some(quantity) = quantity {
            self.number(at, key, quantity, must);
        }
    }

    fn vector(&mut self, at: &At, key: &str, vector: &[Quantity; 3]) {
        // one fault for a vector, not three
        if let Some(worst) = vector.iter().find(|q| !q.value.is_finite() || q.sigma.is_some_and(not_positive)) {
            self.number(at, key, worst, Must::Finite);
        }
        if self.planar() && (vector[2].value != 0.0 || vector[2].sigma.is_some()) {
            let message = format!("{key} of {} has z = {} in a planar plant", at.what, vector[2].value);
            self.fault(at, key, message, "leave z out, or say space = \"spatial\"");
        }
    }

    fn turning(&mut self, at: &At, key: &str, vector: &[Quantity; 3]) {
        if let Some(worst) = vector.iter().find(|q| !q.value.is_finite() || q.sigma.is_some_and(not_positive)) {
            self.number(at, key, worst, Must::Finite);
        }
        if self.planar() && vector[..2].iter().any(|q| q.value != 0.0 || q.sigma.is_some()) {
            let cure = "only z turns in a plane: give one number, or say space = \"spatial\"";
            self.fault(at, key, format!("{key} of {} turns about x or y in a planar plant", at.what), cure);
        }
    }

    const fn planar(&self) -> bool {
        matches!(self.plant.space, Space::Planar)
    }

    /// A unit vector; in a plane along z for turning, in x–y for moving.
    fn axis(&mut self, at: &At, key: &str, axis: &[f64; 3], turns: bool) {
        let norm = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        // nine digits: what a person writes as 0.577350269
        let is_unit = (norm - 1.0).abs() < 1e-6;
        if !is_unit {
            let message = format!("{key} of {} has length {norm}, not one", at.what);
            self.fault(at, key, message, "any vector that is not zero gives a direction");
            return;
        }
        let out_of_plane = if turns { axis[0] != 0.0 || axis[1] != 0.0 } else { axis[2] != 0.0 };
        if self.planar() && out_of_plane {
            let [x, y, z] = axis;
            let (message, cure) = if turns {
                ("turns out of the plane", "in a planar plant only z turns")
            } else {
                ("points out of the plane", "a planar plant moves in x and y")
            };
            self.fault(at, key, format!("{key} = [{x}, {y}, {z}] of {} {message}", at.what), cure);
        }
    }

    /// `name` must be one of `known`; `kind` as in "body".
    fn known<'n>(
        &mut self,
        at: &At,
        key: &str,
        kind: &str,
        name: &str,
        known: impl Iterator<Item = &'n String>,
    ) -> bool {
        let names: Vec<&str> = known.map(String::as_str).collect();
        if names.contains(&name) {
            return true;
        }
        let near = suggestion(name, &plural(kind), names);
        self.fault(at, key, format!("{} names the {kind} '{name}', which does not exist", at.what), near);
        false
    }

    fn known_body(&mut self, at: &At, key: &str, name: &str) -> bool {
        let plant = self.plant;
        self.known(at, key, "body", name, plant.bodies.iter().map(|body| &body.name))
    }

    /// A joint of any kind.
    fn known_joint(&mut self, at: &At, key: &str, name: &str) -> bool {
        let plant = self.plant;
        self.known(at, key, "joint", name, plant.bodies.iter().map(|body| &body.joint.name))
    }

    /// A joint with one degree of freedom.
    fn moving_joint(&mut self, at: &At, key: &str, name: &str) {
        let plant = self.plant;
        let moving: Vec<String> =
            plant.sites(dynamics::description::SiteKind::Joint).into_iter().map(|site| site.name).collect();
        let rigid = plant.joint(name).is_some() && !moving.iter().any(|joint| joint == name);
        if rigid {
            let message = format!("{} needs a revolute or prismatic joint; '{name}' is neither", at.what);
            let cure = if moving.is_empty() { String::new() } else { format!("such are: {}", moving.join(", ")) };
            self.fault(at, key, message, cure);
        } else {
            self.known(at, key, "joint", name, moving.iter());
        }
    }

    fn name(&mut self, at: &At, key: &str, kind: &str, name: &str) {
        if name.is_empty() || name.contains(|c: char| c.is_whitespace() || c.is_control() || ":@.=,#\"'".contains(c)) {
            self.fault(at, key, format!("'{name}' cannot name a {kind}"), "a name has letters, digits, '_' and '-'");
        }
    }

    /// A name is unique; a joint may have its body's.
    fn names(&mut self) {
        let mut seen: std::collections::BTreeMap<&str, String> = std::collections::BTreeMap::new();
        for (at, key, name) in named_things(self.plant) {
            self.name(&at, key, at.section, name);
            let what = if key == "joint.name" { format!("the joint of {}", at.what) } else { at.what.clone() };
            if let Some(other) = seen.get(name) {
                let message = if *other == what {
                    format!("more than one {} is called '{name}'", at.section)
                } else {
                    format!("the name '{name}' is given twice: to {other} and to {what}")
                };
                self.fault(&at, key, message, "every name stands once in a plant");
            } else {
                seen.insert(name, what);
            }
        }
    }
}

/// "bodies", "points of 'panel'".
fn plural(kind: &str) -> String {
    let (noun, rest) = kind.split_once(' ').map_or((kind, String::new()), |(noun, rest)| (noun, format!(" {rest}")));
    noun.strip_suffix('y').map_or_else(|| format!("{noun}s{rest}"), |stem| format!("{stem}ies{rest}"))
}

/// Also of what is no number.
fn not_positive(value: f64) -> bool {
    value.is_nan() || value <= 0.0
}

/// Everything that has a name, with the key that holds it.
fn named_things(plant: &Plant) -> Vec<(At, &'static str, &str)> {
    let mut list: Vec<(At, &'static str, &str)> = Vec::new();
    for (i, body) in plant.bodies.iter().enumerate() {
        list.push((At::new("body", i, &body.name), "name", &body.name));
        if body.joint.name != body.name {
            list.push((At::new("body", i, &body.name), "joint.name", &body.joint.name));
        }
    }
    for (i, tank) in plant.tanks.iter().enumerate() {
        list.push((At::new("tank", i, &tank.name), "name", &tank.name));
    }
    for (i, appendage) in plant.appendages.iter().enumerate() {
        let at = At::new("appendage", i, &appendage.name);
        for (k, mode) in appendage.modes.iter().enumerate() {
            list.push((at.within(&format!("mode.{k}"), &format!("mode '{}'", mode.name)), "name", &mode.name));
        }
        list.push((at, "name", &appendage.name));
    }
    for (i, actuator) in plant.actuators.iter().enumerate() {
        list.push((At::new("actuator", i, &actuator.name), "name", &actuator.name));
    }
    for (i, controller) in plant.controllers.iter().enumerate() {
        list.push((At::new("controller", i, &controller.name), "name", &controller.name));
    }
    for (i, source) in plant.sources.iter().enumerate() {
        list.push((At::new("source", i, &source.name), "name", &source.name));
    }
    for (i, sensor) in plant.sensors.iter().enumerate() {
        list.push((At::new("sensor", i, &sensor.name), "name", &sensor.name));
    }
    for (i, segment) in plant.segments.iter().enumerate() {
        list.push((At::new("segment", i, &segment.name), "name", &segment.name));
    }
    list
}

#[cfg(test)]
mod tests;
