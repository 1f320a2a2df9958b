//! One quantity over another, with the law fitted to it: a force over a speed, a displacement.

use super::overlay::{Band, entry};
use super::{Curve, Role, draw_lines};
use crate::data::Data;
use crate::panel::{Area, BELOW, Entry, Panel, legend};
use crate::scale::Axis;
use crate::svg::{Figure, Svg};

/// A cloud of samples and laws through it.
#[derive(Clone, Debug, Default)]
pub struct Scatter<'a> {
    /// Name and unit of the horizontal axis.
    pub x: (&'a str, &'a str),
    pub y: (&'a str, &'a str),
    /// Measured ones are dots, all others lines.
    pub curves: Vec<Curve<'a>>,
    pub band: Option<Band<'a>>,
}

const SCATTER_HEIGHT: f64 = 300.0;

impl Scatter<'_> {
    /// Samples as dots, laws as lines, the band of 95 % behind them, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let mut entries: Vec<Entry<'_>> = self.curves.iter().map(entry).collect();
        if self.band.is_some() {
            entries.push(Entry { class: "area band".into(), label: "95 %" });
        }
        let top = legend(&mut svg, 4.0, &entries) + 8.0;
        let x = Axis::linear(self.x.0, self.x.1, self.curves.iter().flat_map(|c| c.x.iter().copied()));
        let band = self.band.iter().flat_map(|b| b.low.iter().chain(b.high).copied());
        let y = Axis::linear(self.y.0, self.y.1, self.curves.iter().flat_map(|c| c.y.iter().copied()).chain(band));
        let mut panel = Panel::new(Area::full(top, SCATTER_HEIGHT), x, y);
        panel.level("zero", 0.0);
        if let Some(band) = self.band {
            panel.band("area band", band.x, band.low, band.high);
        }
        let (samples, laws): (Vec<Curve<'_>>, Vec<_>) = self.curves.iter().partition(|c| c.role == Role::Measured);
        draw_lines(&mut panel, &laws);
        for curve in &samples {
            let class = if curve.x.len() > 400 { "dot measured small" } else { "dot measured" };
            panel.labelled(curve.label, |panel| panel.dots(class, curve.x, curve.y));
        }
        panel.draw(&mut svg);
        svg.figure(claim, top + SCATTER_HEIGHT + BELOW).data(Data::of_curves(self.x, self.y, &self.curves))
    }
}
