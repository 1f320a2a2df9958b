//! One table of a plant file under the reader's hand: it remembers which keys it was asked for and
//! collects what is wrong.
//!
//! Nothing here returns early: a value that cannot be read is reported, replaced by a stand-in, and
//! its place is marked, so that what follows from the stand-in is not reported as well.

use super::numbers::{self, Expected};
use crate::validate::Place;
use core::cell::{Cell, RefCell};
use core::ops::Range;
use dynamics::description::{Plant, Quantity, SiteKind, Space, nearest, suggestion};
use std::collections::{BTreeMap, BTreeSet};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

pub(super) type Node<'d> = Spanned<DeValue<'d>>;

/// What was found wrong, still without line and column.
#[derive(Clone, Debug)]
pub(super) struct Finding {
    pub span: Range<usize>,
    pub message: String,
    pub cure: String,
}

/// What all sections of a file share.
#[derive(Default)]
pub(super) struct Reader {
    pub findings: RefCell<Vec<Finding>>,
    /// Where each place of the description stands in the text.
    pub places: RefCell<BTreeMap<Place, Range<usize>>>,
    /// Places that hold a stand-in.
    pub poisoned: RefCell<BTreeSet<Place>>,
    /// `None`: not readable; then nothing is said about what one space lacks.
    pub space: Cell<Option<Space>>,
    /// Names of what has a stand-in for its kind: nothing can be said about its unit.
    pub unsure: RefCell<BTreeSet<String>>,
}

/// One table.
pub(super) struct Section<'r, 'd> {
    pub reader: &'r Reader,
    /// As messages call it: `body 'hub'`.
    pub what: String,
    pub place: Place,
    pub span: Range<usize>,
    table: &'d DeTable<'d>,
    asked: RefCell<Vec<String>>,
    missing: RefCell<Vec<(String, String)>>,
    /// Its kind is unknown: then nothing can be said about its keys.
    lenient: Cell<bool>,
    /// What it refers to is unknown: then nothing can be said about the dimension of its numbers.
    any_unit: Cell<bool>,
}

impl<'r, 'd> Section<'r, 'd> {
    /// A table of the document at the bytes `span`; `what` names it in messages, `place` in
    /// findings about the plant.
    pub fn new(reader: &'r Reader, table: &'d DeTable<'d>, span: Range<usize>, place: Place, what: String) -> Self {
        reader.places.borrow_mut().insert(place.clone(), span.clone());
        Self {
            reader,
            what,
            place,
            span,
            table,
            asked: RefCell::default(),
            missing: RefCell::default(),
            lenient: Cell::new(false),
            any_unit: Cell::new(false),
        }
    }

    /// May be in a plane.
    pub fn planar(&self) -> bool {
        self.reader.space.get() != Some(Space::Spatial)
    }

    /// May be in space.
    pub fn spatial(&self) -> bool {
        self.reader.space.get() != Some(Space::Planar)
    }

    /// The place of `key`.
    pub fn at(&self, key: &str) -> Place {
        let key = if self.place.key.is_empty() { key.to_owned() } else { format!("{}.{key}", self.place.key) };
        Place { key, ..self.place.clone() }
    }

    /// The node at `key`; from now on the key is known.
    pub fn get(&self, key: &str) -> Option<&'d Node<'d>> {
        self.asked.borrow_mut().push(key.to_owned());
        let node = self.table.get(key)?;
        self.reader.places.borrow_mut().insert(self.at(key), node.span());
        Some(node)
    }

    /// Whether the file has the key; the key does not become known by it.
    pub fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Keys in the order of the text.
    pub fn keys(&self) -> Vec<&'d str> {
        let mut keys: Vec<_> = self.table.keys().map(|key| (key.span().start, key.get_ref().as_ref())).collect();
        keys.sort_unstable();
        keys.into_iter().map(|(_, key)| key).collect()
    }

    /// Reports at `key`'s value, or at the table where it is absent.
    pub fn error(&self, key: &str, message: impl Into<String>, cure: impl Into<String>) {
        let place = self.at(key);
        let span = self.reader.places.borrow().get(&place).cloned().unwrap_or_else(|| self.span.clone());
        self.reader.poisoned.borrow_mut().insert(place);
        let finding = Finding { span, message: message.into(), cure: cure.into() };
        self.reader.findings.borrow_mut().push(finding);
    }

    /// Marks `key` without a report: what follows from it was reported already.
    pub fn poison(&self, key: &str) {
        self.reader.poisoned.borrow_mut().insert(self.at(key));
    }

    /// Remembered until `finish`: a key that is misspelt is reported once, as unknown.
    pub fn missing(&self, key: &str, cure: &str) {
        self.poison(key);
        if !self.lenient.get() && !self.table.contains_key(key) {
            self.missing.borrow_mut().push((key.to_owned(), cure.to_owned()));
        }
    }

    /// A required value; its absence is reported with an example.
    fn required(&self, key: &str, cure: &str) -> Option<&'d Node<'d>> {
        let node = self.get(key);
        if node.is_none() {
            self.missing(key, cure);
        }
        node
    }

    fn wrong_type(&self, key: &str, node: &Node<'d>, wanted: &str) {
        let message = format!("{key} of {} is {}, not {wanted}", self.what, type_of(node));
        self.error(key, message, "");
    }

    /// The text at `key`; `None` where it is missing, or of another type (reported).
    pub fn text(&self, key: &str) -> Option<String> {
        let node = self.get(key)?;
        let text = node.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(key, node, "a text");
        }
        text.map(str::to_owned)
    }

    /// A required text; empty where it is missing.
    pub fn required_text(&self, key: &str, cure: &str) -> String {
        if self.table.contains_key(key) {
            return self.text(key).unwrap_or_default();
        }
        self.get(key);
        self.missing(key, cure);
        String::new()
    }

    /// True or false; `default` where it is missing, or of another type (reported).
    pub fn flag(&self, key: &str, default: bool) -> bool {
        let Some(node) = self.get(key) else { return default };
        node.get_ref().as_bool().unwrap_or_else(|| {
            self.wrong_type(key, node, "true or false");
            default
        })
    }

    /// A required whole number.
    pub fn count(&self, key: &str) -> u32 {
        let Some(node) = self.required(key, "a whole number") else { return 1 };
        let integer = node.get_ref().as_integer();
        let number = integer.and_then(|i| u32::from_str_radix(i.as_str(), i.radix()).ok());
        number.unwrap_or_else(|| {
            match integer {
                Some(i) => self.error(
                    key,
                    format!("{key} of {} is {}", self.what, i.as_str()),
                    format!("a whole number from 0 to {}", u32::MAX),
                ),
                None => self.wrong_type(key, node, "a whole number"),
            }
            1
        })
    }

    /// One of a list of words; `None` where it is missing (reported if there is no `default`) or
    /// unknown (reported).
    pub fn word<T: Copy>(&self, key: &str, words: &[(&str, T)], default: Option<T>) -> Option<T> {
        let names = || words.iter().map(|(word, _)| *word);
        if !self.table.contains_key(key) {
            self.get(key);
            if default.is_none() {
                self.missing(key, &format!("one of {}", names().collect::<Vec<_>>().join(", ")));
            }
            return default;
        }
        let text = self.text(key)?;
        let found = words.iter().find(|(word, _)| *word == text).map(|(_, value)| *value);
        if found.is_none() {
            let near = nearest(&text, names()).map(|word| format!("did you mean '{word}'?"));
            let cure = near.unwrap_or_else(|| format!("one of {}", names().collect::<Vec<_>>().join(", ")));
            self.error(key, format!("{key} of {} is '{text}', which is unknown", self.what), cure);
        }
        found
    }

    /// A number with unit, if it stands there.
    pub fn quantity(&self, key: &str, unit: &str) -> Option<Quantity> {
        let node = self.get(key)?;
        Some(self.read(key, node, unit))
    }

    /// A number in `unit`; `default`, known exactly, where it is missing or cannot be read
    /// (reported).
    pub fn quantity_or(&self, key: &str, unit: &str, default: f64) -> Quantity {
        self.quantity(key, unit).unwrap_or(Quantity::known(default))
    }

    /// A number in `unit`; 1 stands in where it is missing (reported with an example).
    pub fn required_quantity(&self, key: &str, unit: &str) -> Quantity {
        match self.required(key, &format!("as in {key} = \"1 {unit}\"")) {
            Some(node) => self.read(key, node, unit),
            None => Quantity::known(1.0),
        }
    }

    /// Reads `node` as what `key` is; a stand-in of one where it cannot be read.
    pub fn read(&self, key: &str, node: &Node<'d>, unit: &str) -> Quantity {
        let expected = Expected { what: format!("{key} of {}", self.what), unit };
        numbers::quantity(node, &expected).unwrap_or_else(|findings| {
            self.unreadable(key, findings);
            Quantity::known(1.0)
        })
    }

    /// A number that has no prior.
    pub fn known_number(&self, key: &str, unit: &str) -> Option<f64> {
        let quantity = self.quantity(key, unit)?;
        if quantity.sigma.is_some() {
            self.error(key, format!("{key} of {} cannot be estimated", self.what), "leave sigma out");
        }
        Some(quantity.value)
    }

    /// A list of numbers with unit, of any length; a single number counts as a list of one.
    pub fn list(&self, key: &str, unit: &str) -> Option<Vec<Quantity>> {
        let node = self.get(key)?;
        let expected = Expected { what: format!("{key} of {}", self.what), unit };
        let list = numbers::list(node, &expected).unwrap_or_else(|findings| {
            self.unreadable(key, findings);
            Vec::new()
        });
        Some(list)
    }

    fn unreadable(&self, key: &str, findings: Vec<Finding>) {
        self.poison(key);
        if !self.any_unit.get() && !self.lenient.get() {
            self.reader.findings.borrow_mut().extend(findings);
        }
    }

    /// A vector of translation: three numbers, in a plane also two.
    pub fn vector(&self, key: &str, unit: &str) -> Option<[Quantity; 3]> {
        let list = self.list(key, unit)?;
        let zero = Quantity::known(0.0);
        match list[..] {
            [x, y, z] => Some([x, y, z]),
            [x, y] if self.planar() => Some([x, y, zero]),
            _ => {
                self.wrong_length(key, list.len(), if self.planar() { "2 (x, y)" } else { "3 (x, y, z)" });
                Some([zero; 3])
            }
        }
    }

    /// A vector in `unit`; zero where it is missing or cannot be read (reported).
    pub fn vector_or_zero(&self, key: &str, unit: &str) -> [Quantity; 3] {
        self.vector(key, unit).unwrap_or_default()
    }

    /// A vector in `unit`; zero stands in where it is missing (reported with an example).
    pub fn required_vector(&self, key: &str, unit: &str) -> [Quantity; 3] {
        if !self.table.contains_key(key) {
            self.get(key);
            let example = if self.planar() { format!("[\"0 {unit}\", 0]") } else { format!("[\"0 {unit}\", 0, 0]") };
            self.missing(key, &format!("as in {key} = {example}"));
        }
        self.vector_or_zero(key, unit)
    }

    /// A vector of rotation: three numbers, in a plane also the one about z.
    pub fn turning(&self, key: &str, unit: &str) -> Option<[Quantity; 3]> {
        let list = self.list(key, unit)?;
        let zero = Quantity::known(0.0);
        match list[..] {
            [x, y, z] => Some([x, y, z]),
            [z] if self.planar() => Some([zero, zero, z]),
            _ => {
                self.wrong_length(key, list.len(), if self.planar() { "1 (about z)" } else { "3 (x, y, z)" });
                Some([zero; 3])
            }
        }
    }

    /// Reports a list of another length than `wanted`, once a list.
    pub fn wrong_length(&self, key: &str, length: usize, wanted: &str) {
        // a list that could not be read was reported as such
        if !self.reader.poisoned.borrow().contains(&self.at(key)) {
            let plural = if length == 1 { "" } else { "s" };
            self.error(key, format!("{key} of {} has {length} number{plural}, not {wanted}", self.what), "");
        }
    }

    /// A direction as a unit vector: `"x"`, `"-y"`, or numbers; `None` where it is absent.
    pub fn axis(&self, key: &str) -> Option<[f64; 3]> {
        let node = self.get(key)?;
        let axis = self.direction(key, node);
        Some(axis.unwrap_or([0.0, 0.0, 1.0]))
    }

    /// A unit vector; x stands in where it is missing (reported with an example).
    pub fn required_axis(&self, key: &str) -> [f64; 3] {
        if !self.table.contains_key(key) {
            self.get(key);
            self.missing(key, &format!("as in {key} = \"x\" or {key} = [0.6, 0.8]"));
            return [1.0, 0.0, 0.0];
        }
        self.axis(key).unwrap_or([1.0, 0.0, 0.0])
    }

    /// Reads one direction; `None` where it cannot be read, which is then reported.
    pub fn direction(&self, key: &str, node: &Node<'d>) -> Option<[f64; 3]> {
        match numbers::direction(node, self.planar()) {
            Ok(axis) => Some(axis),
            Err((message, cure)) => {
                self.error(key, format!("{key} of {} {message}", self.what), cure);
                None
            }
        }
    }

    /// The table at `key`.
    pub fn section(&self, key: &str, what: &str) -> Option<Section<'r, 'd>> {
        let node = self.get(key)?;
        let DeValue::Table(table) = node.get_ref() else {
            self.wrong_type(key, node, "a table { … }");
            return None;
        };
        Some(self.inner(table, node, self.at(key), what))
    }

    fn inner(&self, table: &'d DeTable<'d>, node: &Node<'d>, place: Place, what: &str) -> Self {
        let inner = Section::new(self.reader, table, node.span(), place, format!("{what} of {}", self.what));
        inner.lenient.set(self.lenient.get());
        inner.any_unit.set(self.any_unit.get());
        inner
    }

    /// The tables at `key`: a list of them, or one alone. Their places are `key.0`, `key.1`, ….
    pub fn sections(&self, key: &str, what: &str) -> Vec<Section<'r, 'd>> {
        let Some(node) = self.get(key) else { return Vec::new() };
        let nodes: Vec<&'d Node<'d>> = match node.get_ref() {
            DeValue::Array(list) => list.iter().collect(),
            _ => vec![node],
        };
        let mut sections = Vec::with_capacity(nodes.len());
        for (i, node) in nodes.into_iter().enumerate() {
            let DeValue::Table(table) = node.get_ref() else {
                self.wrong_type(key, node, "a table { … } or a list of tables");
                continue;
            };
            let place = self.at(&format!("{key}.{i}"));
            sections.push(self.inner(table, node, place, what));
        }
        sections
    }

    /// Says nothing about the keys of this table: what they should be is unknown.
    pub fn be_lenient(&self) {
        self.lenient.set(true);
    }

    /// Says nothing about the dimension of what is read from now on.
    pub fn take_any_unit(&self) {
        self.any_unit.set(true);
    }

    /// What the description calls `name` stands here at `key`.
    pub fn also(&self, key: &str, name: &str) {
        let (key, name) = (self.at(key), self.at(name));
        let span = self.reader.places.borrow().get(&key).cloned();
        self.reader.places.borrow_mut().extend(span.map(|span| (name.clone(), span)));
        let poisoned = self.reader.poisoned.borrow().contains(&key);
        if poisoned {
            self.reader.poisoned.borrow_mut().insert(name);
        }
    }

    /// Whether the kind of the part `name` is a stand-in.
    pub fn is_unsure(&self, name: &str) -> bool {
        self.reader.unsure.borrow().contains(name)
    }

    /// Whether nothing can be said about the unit of `joint`.
    pub fn is_unsure_of_joint(&self, plant: &Plant, joint: &str) -> bool {
        let moves = plant.sites(SiteKind::Joint).iter().any(|site| site.name == joint);
        !moves || self.is_unsure(joint)
    }

    /// The kind of the part `name` is a stand-in.
    pub fn be_unsure(&self, name: &str) {
        self.reader.unsure.borrow_mut().insert(name.to_owned());
    }

    /// Reports every key that is missing and every key that is unknown.
    pub fn finish(&self) {
        let asked = self.asked.borrow();
        let unknown = |name: &str| !asked.iter().any(|known| known == name);
        let mut misspelt: Vec<&str> = Vec::new();
        for (key, _) in self.table.iter().filter(|(key, _)| unknown(key.get_ref()) && !self.lenient.get()) {
            let (name, span) = (key.get_ref().as_ref(), key.span());
            let known = || asked.iter().map(String::as_str);
            misspelt.extend(nearest(name, known()));
            let finding = Finding {
                span,
                message: format!("{} has no key '{name}'", self.what),
                cure: suggestion(name, "keys", known()),
            };
            self.reader.findings.borrow_mut().push(finding);
        }
        for (key, cure) in self.missing.borrow().iter().filter(|(key, _)| !misspelt.contains(&key.as_str())) {
            self.error(key, format!("{} lacks '{key}'", self.what), cure.as_str());
        }
    }

    /// The tables `[[key]]` of a file.
    pub fn tables(&self, key: &'static str) -> Vec<Section<'r, 'd>> {
        let mut sections = self.sections(key, key);
        for (index, section) in sections.iter_mut().enumerate() {
            section.place = Place { section: key, index, key: String::new() };
            section.what = format!("{key} number {}", index + 1);
            self.reader.places.borrow_mut().insert(section.place.clone(), section.span.clone());
        }
        sections
    }

    /// The table `[key]` of a file.
    pub fn table(&self, key: &'static str) -> Option<Section<'r, 'd>> {
        let mut section = self.section(key, key)?;
        section.place = Place { section: key, index: 0, key: String::new() };
        section.what = format!("[{key}]");
        self.reader.places.borrow_mut().insert(section.place.clone(), section.span.clone());
        Some(section)
    }

    /// Reads the required name, by which messages then call the table.
    pub fn name(&mut self, kind: &str) -> String {
        let name = self.required_text("name", "every name stands once in a plant");
        if !name.is_empty() {
            self.what = format!("{kind} '{name}'");
        }
        name
    }
}

fn type_of(node: &Node<'_>) -> &'static str {
    match node.get_ref() {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}
