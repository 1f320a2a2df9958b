//! Measured and modelled over time, with the residual under them.

use super::{Curve, Role, draw_curves, draw_lines};
use crate::data::Data;
use crate::panel::{Area, BELOW, Entry, Panel, legend};
use crate::scale::Axis;
use crate::svg::{Figure, Svg};

/// Where the truth lies with 95 % probability.
#[derive(Clone, Copy, Debug)]
pub struct Band<'a> {
    pub x: &'a [f64],
    pub low: &'a [f64],
    pub high: &'a [f64],
}

/// A stretch worth a look.
#[derive(Clone, Debug)]
pub struct Mark {
    pub from: f64,
    pub to: f64,
    pub what: String,
}

/// Time series over each other.
#[derive(Clone, Debug, Default)]
pub struct Overlay<'a> {
    pub quantity: &'a str,
    pub unit: &'a str,
    pub curves: Vec<Curve<'a>>,
    /// The 95 % band of the model after.
    pub band: Option<Band<'a>>,
    /// Measured minus modelled, in a panel of its own.
    pub residual: Vec<Curve<'a>>,
    pub marks: Vec<Mark>,
    /// Meaning of the marks, for the legend.
    pub marks_are: &'a str,
}

const MAIN: f64 = 200.0;
const RESIDUAL: f64 = 90.0;

impl Overlay<'_> {
    /// Curves over time and, below them, the residual on the same time axis, under the title
    /// `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let top = legend(&mut svg, 4.0, &self.entries()) + 8.0;
        let x = || {
            let all = self.curves.iter().chain(&self.residual).flat_map(|c| c.x.iter().copied());
            Axis::tight("time", "s", all)
        };
        let ys = self.curves.iter().flat_map(|c| c.y.iter().copied());
        let band = self.band.iter().flat_map(|b| b.low.iter().chain(b.high).copied());
        let mut main = Panel::new(Area::full(top, MAIN), x(), Axis::linear(self.quantity, self.unit, ys.chain(band)));
        main.x_labelled = self.residual.is_empty();
        self.shade(&mut main);
        if let Some(band) = self.band {
            main.band("area band", band.x, band.low, band.high);
        }
        draw_curves(&mut main, &self.curves);
        main.draw(&mut svg);
        let data = Data::of_curves(("time", "s"), (self.quantity, self.unit), &self.curves);
        if self.residual.is_empty() {
            return svg.figure(claim, top + MAIN + BELOW).data(data);
        }
        let below = Area::full(top + MAIN + 10.0, RESIDUAL);
        let ys = self.residual.iter().flat_map(|c| c.y.iter().copied());
        let mut residual = Panel::new(below, x(), Axis::linear("residual", self.unit, ys));
        self.shade(&mut residual);
        residual.level("zero", 0.0);
        draw_lines(&mut residual, &self.residual);
        residual.draw(&mut svg);
        svg.figure(claim, top + MAIN + 10.0 + RESIDUAL + BELOW).data(data)
    }

    fn shade(&self, panel: &mut Panel) {
        for mark in &self.marks {
            panel.stretch("area mark", mark.from, mark.to, &mark.what);
        }
    }

    fn entries(&self) -> Vec<Entry<'_>> {
        let mut entries: Vec<Entry<'_>> = self.curves.iter().map(entry).collect();
        if self.band.is_some() {
            entries.push(Entry { class: "area band".into(), label: "95 %" });
        }
        if !self.marks.is_empty() {
            entries.push(Entry { class: "area mark".into(), label: self.marks_are });
        }
        entries
    }
}

pub(super) fn entry<'a>(curve: &Curve<'a>) -> Entry<'a> {
    let class = if curve.role == Role::Measured { "dot measured" } else { curve.role.class() };
    Entry { class: class.into(), label: curve.label }
}
