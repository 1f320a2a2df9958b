//! Numbers with their intervals, one per line.

use super::Role;
use crate::data::{Data, named, number, quoted};
use crate::panel::BELOW;
use crate::scale::Axis;
use crate::svg::{Anchor, FONT, Figure, Svg, WIDTH};
use crate::text::width_em;

/// A value with its interval.
#[derive(Clone, Debug)]
pub struct Bar {
    pub label: String,
    pub value: f64,
    /// 95 %; equal to the value without an interval.
    pub interval: (f64, f64),
    pub role: Role,
    /// Right of the bar: a verdict, a number.
    pub note: String,
}

/// Bars from zero, or points with intervals where zero is far away.
#[derive(Clone, Debug, Default)]
pub struct Bars<'a> {
    pub quantity: &'a str,
    pub unit: &'a str,
    pub bars: Vec<Bar>,
    /// A value to compare with: a threshold, the truth.
    pub reference: Option<f64>,
    pub from_zero: bool,
}

const BAR_ROW_HEIGHT: f64 = 26.0;
const TOP: f64 = 10.0;

impl Bars<'_> {
    /// One row per bar with its interval, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let widest = |texts: &mut dyn Iterator<Item = &str>, max: f64| {
            texts.map(|t| FONT * width_em(t)).fold(0.0, f64::max).min(max)
        };
        let left = widest(&mut self.bars.iter().map(|b| b.label.as_str()), 280.0) + 16.0;
        let right = widest(&mut self.bars.iter().map(|b| b.note.as_str()), 230.0) + 16.0;
        let (width, height) = (WIDTH - left - right, BAR_ROW_HEIGHT * self.bars.len().max(2) as f64);
        let numbers = self.bars.iter().flat_map(|b| [b.value, b.interval.0, b.interval.1]);
        let zero = self.from_zero.then_some(0.0);
        let axis = Axis::linear(self.quantity, self.unit, numbers.chain(self.reference).chain(zero));
        svg.rect("plot", left, TOP, width, height);
        if axis.is_empty() || self.bars.is_empty() {
            svg.text("faint", (left + width / 2.0, TOP + height / 2.0 + 4.0), Anchor::Middle, width, "no data");
        }
        let x = |value: f64| left + axis.place(value) * width;
        scale(&mut svg, &axis, (left, width), height);
        for (what, class) in [(zero, "zero"), (self.reference, "line truth")] {
            if let Some(at) = what.map(&x).filter(|at| at.is_finite()) {
                svg.line(class, (at, TOP), (at, TOP + height));
            }
        }
        for (k, bar) in self.bars.iter().enumerate() {
            let y = TOP + (k as f64 + 0.5) * BAR_ROW_HEIGHT;
            svg.text("label", (left - 8.0, y + 4.0), Anchor::End, left - 12.0, &bar.label);
            svg.text("tick", (left + width + 8.0, y + 4.0), Anchor::Start, right - 10.0, &bar.note);
            self.draw_bar(&mut svg, bar, y, &x);
        }
        svg.figure(claim, TOP + height + BELOW).data(self.data())
    }

    fn data(&self) -> Data {
        let value = named((self.quantity, self.unit));
        Data::new(&["name", &value, "95 % from", "95 % to"], self.bars.len(), |k| {
            let bar = &self.bars[k];
            vec![quoted(&bar.label), number(bar.value), number(bar.interval.0), number(bar.interval.1)]
        })
    }

    fn draw_bar(&self, svg: &mut Svg, bar: &Bar, y: f64, x: &dyn Fn(f64) -> f64) {
        let (fill, stroke) = match bar.role {
            Role::After => ("after-fill", "line after"),
            Role::Measured | Role::Truth => ("measured-fill", "line measured"),
            Role::Before | Role::Rival => ("before-fill", "line before"),
        };
        let at = x(bar.value);
        if !at.is_finite() {
            return;
        }
        if self.from_zero {
            let zero = x(0.0);
            svg.rect(fill, zero.min(at), y - 6.0, (at - zero).abs(), 12.0);
        } else {
            svg.circle(fill, at, y, 4.0);
        }
        let (low, high) = (x(bar.interval.0), x(bar.interval.1));
        if low.is_finite() && high.is_finite() && high > low {
            let class = if self.from_zero { "line measured" } else { stroke };
            svg.path(
                class,
                &[
                    vec![(low, y), (high, y)],
                    vec![(low, y - 4.0), (low, y + 4.0)],
                    vec![(high, y - 4.0), (high, y + 4.0)],
                ],
            );
        }
    }
}

fn scale(svg: &mut Svg, axis: &Axis, (left, width): (f64, f64), height: f64) {
    let count = (width / 90.0).max(2.0) as usize;
    for tick in axis.ticks(count) {
        let x = left + tick.place * width;
        svg.line("grid", (x, TOP), (x, TOP + height));
        svg.text("tick", (x, TOP + height + 16.0), Anchor::Middle, 80.0, &tick.label);
    }
    svg.rect("frame", left, TOP, width, height);
    svg.text("label", (left + width / 2.0, TOP + height + 34.0), Anchor::Middle, width + 120.0, &axis.label(count));
}
