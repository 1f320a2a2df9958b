//! Sums over time: the evidence for a model, a sum of squares.

use super::overlay::{Mark, entry};
use super::{Curve, draw_lines};
use crate::data::Data;
use crate::panel::{Area, BELOW, Entry, Panel, legend};
use crate::scale::Axis;
use crate::svg::{Figure, Svg};
use crate::text::short;

/// Sums over time: a line that climbs evenly is evidence everywhere, a step is one event.
#[derive(Clone, Debug, Default)]
pub struct Cumulative<'a> {
    pub quantity: &'a str,
    pub unit: &'a str,
    pub curves: Vec<Curve<'a>>,
    /// The height that decides.
    pub threshold: Option<f64>,
    pub marks: Vec<Mark>,
    pub marks_are: &'a str,
}

const CUMULATIVE_HEIGHT: f64 = 190.0;

impl Cumulative<'_> {
    /// The curves over time, with the threshold as a line, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let mut entries: Vec<Entry<'_>> =
            self.curves.iter().map(|c| Entry { class: c.role.class().into(), ..entry(c) }).collect();
        let decides = self.threshold.map(|t| format!("decides at {}", short(t))).unwrap_or_default();
        entries.push(Entry { class: "line truth".into(), label: &decides });
        if !self.marks.is_empty() {
            entries.push(Entry { class: "area mark".into(), label: self.marks_are });
        }
        let top = legend(&mut svg, 4.0, &entries) + 8.0;
        let x = Axis::tight("time", "s", self.curves.iter().flat_map(|c| c.x.iter().copied()));
        let ys = self.curves.iter().flat_map(|c| c.y.iter().copied()).chain(self.threshold);
        let mut panel = Panel::new(Area::full(top, CUMULATIVE_HEIGHT), x, Axis::linear(self.quantity, self.unit, ys));
        for mark in &self.marks {
            panel.stretch("area mark", mark.from, mark.to, &mark.what);
        }
        panel.level("zero", 0.0);
        draw_lines(&mut panel, &self.curves);
        if let Some(threshold) = self.threshold {
            panel.level("line truth", threshold);
        }
        panel.draw(&mut svg);
        let data = Data::of_curves(("time", "s"), (self.quantity, self.unit), &self.curves);
        svg.figure(claim, top + CUMULATIVE_HEIGHT + BELOW).data(data)
    }
}
