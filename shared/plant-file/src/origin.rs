//! Where in the text the parts of a plant stand: faults of the plant become findings in the text.

use super::FileError;
use super::section::{Finding, Reader};
use crate::validate::{Fault, Place};
use core::ops::Range;
use dynamics::description::{Plant, Sensor};
use std::collections::BTreeMap;

/// Which table of the file each part of the plant came from, where the numbering differs.
#[derive(Default)]
pub(super) struct Origin {
    index: BTreeMap<&'static str, Vec<usize>>,
    /// Names of every channel and of the [[sensor]] that it comes from.
    channels: Vec<(String, String)>,
}

impl Origin {
    /// Sorts bodies so that parents come first, else in file order; those in a cycle stay at the
    /// end.
    pub fn put_parents_first(&mut self, plant: &mut Plant) {
        let mut waiting: Vec<usize> = (0..plant.bodies.len()).collect();
        let mut order: Vec<usize> = Vec::with_capacity(waiting.len());
        loop {
            let bodies = &plant.bodies;
            let placed = |name: &String| order.iter().any(|i| bodies[*i].name == *name);
            let unknown = |name: &String| !bodies.iter().any(|body| body.name == *name);
            let ready = |i: &usize| bodies[*i].parent.as_ref().is_none_or(|parent| placed(parent) || unknown(parent));
            let Some(next) = waiting.iter().position(ready) else { break };
            order.push(waiting.remove(next));
        }
        order.extend(waiting);
        plant.bodies = order.iter().map(|i| plant.bodies[*i].clone()).collect();
        self.index.insert("body", order);
    }

    /// Notes the channels that table number `table` of the sensors became.
    pub fn put_channels(&mut self, table: usize, channels: &[Sensor]) {
        self.index.entry("sensor").or_default().extend(channels.iter().map(|_| table));
        let several = channels.len() > 1;
        self.channels.extend(channels.iter().map(|channel| {
            let name = channel.name.rsplit_once('_').filter(|_| several).map_or(&channel.name[..], |(name, _)| name);
            (channel.name.clone(), name.to_owned())
        }));
    }

    /// Faults of the plant as findings in the text, without those that follow from a stand-in.
    pub fn findings(&self, reader: &Reader, plant: &Plant, faults: Vec<Fault>) -> Vec<Finding> {
        let mut said: BTreeMap<Place, usize> = BTreeMap::new();
        let mut findings = Vec::new();
        for Fault { place, message, cure, because_of, .. } in faults {
            let (index, place) = (place.index, self.in_text(place));
            // once for the three channels of one [[sensor]]
            let first = *said.entry(place.clone()).or_insert(index);
            let unread = || {
                is_stand_in(reader, &place) || because_of.into_iter().any(|of| is_stand_in(reader, &self.in_text(of)))
            };
            if first != index || unread() || Self::follows(reader, plant, &place) {
                continue;
            }
            let (message, cure) = match self.channels.get(index).filter(|_| place.section == "sensor") {
                Some((channel, name)) => {
                    let as_in_text = |text: &str| text.replace(&format!("'{channel}'"), &format!("'{name}'"));
                    (as_in_text(&message), as_in_text(&cure))
                }
                None => (message, cure),
            };
            findings.push(Finding { span: span_of(reader, &place), message, cure });
        }
        findings
    }

    /// The place by the numbering of the text.
    fn in_text(&self, place: Place) -> Place {
        let index = self.index.get(place.section).and_then(|of| of.get(place.index)).copied();
        Place { index: index.unwrap_or(place.index), ..place }
    }

    /// Whether a controller is at fault only because its sensor has a stand-in for its kind.
    fn follows(reader: &Reader, plant: &Plant, place: &Place) -> bool {
        let controller = plant.controllers.get(place.index).filter(|_| place.section == "controller");
        let sensor = controller.and_then(|of| match place.key.as_str() {
            "position_sensor" => of.position_sensor.as_ref(),
            "rate_sensor" => of.rate_sensor.as_ref(),
            _ => None,
        });
        sensor.is_some_and(|name| reader.unsure.borrow().contains(name))
    }
}

/// Whether the place, or what holds it, could not be read.
fn is_stand_in(reader: &Reader, place: &Place) -> bool {
    let poisoned = reader.poisoned.borrow();
    enclosing(place).any(|place| poisoned.contains(&place))
}

/// Where the place stands; what holds it, where it is not written.
fn span_of(reader: &Reader, place: &Place) -> Range<usize> {
    let places = reader.places.borrow();
    let whole = Place { key: String::new(), ..place.clone() };
    enclosing(place).chain([whole]).find_map(|place| places.get(&place).cloned()).unwrap_or(0..0)
}

/// `joint.orientation.axis`, `joint.orientation`, `joint`.
fn enclosing(place: &Place) -> impl Iterator<Item = Place> {
    let mut key = Some(place.key.clone());
    let place = place.clone();
    core::iter::from_fn(move || {
        let this = key.take().filter(|key| !key.is_empty())?;
        key = this.rsplit_once('.').map(|(outer, _)| outer.to_owned());
        Some(Place { key: this, ..place.clone() })
    })
}

/// Findings with line and column, in the order of the text.
pub(super) fn locate(file: &str, text: &str, mut findings: Vec<Finding>) -> Vec<FileError> {
    findings.sort_by_key(|finding| finding.span.start);
    let error = |finding: Finding| {
        let before = text.get(..finding.span.start).unwrap_or(text);
        FileError {
            file: file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before.rsplit('\n').next().unwrap_or("").chars().count() + 1,
            message: finding.message,
            cure: finding.cure,
            span: finding.span,
        }
    };
    findings.into_iter().map(error).collect()
}
