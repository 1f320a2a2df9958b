//! A panel: two axes, their grid, and the drawing between them.

use crate::decimate;
use crate::scale::Axis;
use crate::svg::{Anchor, FONT, Svg, WIDTH};
use crate::text::{escape, width_em};
use std::fmt::Write;

/// Room left of a panel for tick labels and the turned label.
pub const LEFT: f64 = 74.0;
/// Width of a panel that fills a figure.
pub const PLOT_WIDTH: f64 = WIDTH - LEFT - 14.0;
/// Room below a panel whose horizontal axis is labelled.
pub const BELOW: f64 = 40.0;

/// Distance of measured dots on top of a model [px].
const SAMPLE_SPACING: f64 = 6.0;

/// Where a panel lies.
#[derive(Clone, Copy)]
pub struct Area {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Area {
    /// As wide as the figure allows.
    pub fn full(top: f64, height: f64) -> Self {
        Area { left: LEFT, top, width: PLOT_WIDTH, height }
    }
}

/// Two axes and the drawing between them, in pixels from the upper left corner.
pub struct Panel {
    pub area: Area,
    x: Axis,
    y: Axis,
    pub inner: Svg,
    /// Drawn, but in another panel's figure: no labels below.
    pub x_labelled: bool,
}

impl Panel {
    /// An empty panel at `area`; the drawing calls fill it.
    pub fn new(area: Area, x: Axis, y: Axis) -> Self {
        Panel { area, x, y, inner: Svg::default(), x_labelled: true }
    }

    /// Horizontal place of `x` from the left end of the axis [px].
    pub fn x_px(&self, x: f64) -> f64 {
        self.x.place(x) * self.area.width
    }

    /// Vertical place of `y` from the top of the axis [px].
    pub fn y_px(&self, y: f64) -> f64 {
        (1.0 - self.y.place(y)) * self.area.height
    }

    fn points<'a>(&'a self, x: &'a [f64], y: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        x.iter().zip(y).map(|(x, y)| (self.x_px(*x), self.y_px(*y)))
    }

    /// A line through the samples: extremes per pixel column.
    pub fn line(&mut self, class: &str, x: &[f64], y: &[f64]) {
        let runs = decimate::line(self.points(x, y));
        self.inner.path(class, &runs);
    }

    /// Dots, one per pixel and a half.
    pub fn dots(&mut self, class: &str, x: &[f64], y: &[f64]) {
        let points = decimate::dots(self.points(x, y), 1.5);
        self.inner.dots(class, &points);
    }

    /// What `draw` draws belongs to the curve `label`, which the readout names.
    pub fn labelled(&mut self, label: &str, draw: impl FnOnce(&mut Self)) {
        if label.is_empty() {
            return draw(self);
        }
        self.inner.raw(&format!("<g data-label=\"{}\">", escape(label)));
        draw(self);
        self.inner.raw("</g>");
    }

    /// Samples in the horizontal range.
    fn shown(&self, x: &[f64]) -> f64 {
        x.iter().filter(|x| (0.0..=1.0).contains(&self.x.place(**x))).count() as f64
    }

    /// Measured samples on top of the models: dots with room between them, so that a line below
    /// stays visible.
    pub fn samples(&mut self, x: &[f64], y: &[f64]) {
        let points = decimate::dots(self.points(x, y), SAMPLE_SPACING);
        self.inner.dots("dot measured small", &points);
    }

    /// Measured samples that [`Panel::samples`] leaves out, below the models: dots while they can
    /// be told apart, else the line through the extremes, open where the record has a gap.
    pub fn samples_below(&mut self, x: &[f64], y: &[f64]) {
        let shown = self.shown(x);
        if shown <= self.area.width / SAMPLE_SPACING {
            return;
        }
        if shown <= 0.6 * self.area.width {
            return self.dots("dot measured", x, y);
        }
        let mut steps: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let gap = 5.0 * steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY);
        let hole = |i: usize| i > 0 && (x[i] - x[i - 1] > gap || x[i] < x[i - 1]);
        let n = x.len().min(y.len());
        let points = (0..n).flat_map(|i| {
            let hole = hole(i).then_some((f64::NAN, f64::NAN));
            hole.into_iter().chain([(self.x_px(x[i]), self.y_px(y[i]))])
        });
        let runs = decimate::line(points);
        self.inner.path("line measured", &runs);
    }

    /// The area between two lines.
    pub fn band(&mut self, class: &str, x: &[f64], low: &[f64], high: &[f64]) {
        let n = x.len().min(low.len()).min(high.len());
        let usable: Vec<usize> = (0..n).filter(|&i| low[i].is_finite() && high[i].is_finite()).collect();
        let upper = decimate::line(usable.iter().map(|&i| (self.x_px(x[i]), self.y_px(high[i])))).concat();
        let lower = decimate::line(usable.iter().map(|&i| (self.x_px(x[i]), self.y_px(low[i])))).concat();
        if upper.len() > 1 {
            let outline = upper.into_iter().chain(lower.into_iter().rev()).collect();
            self.inner.path(class, &[outline]);
        }
    }

    /// A stretch of the horizontal axis from top to bottom, with its meaning under the pointer.
    pub fn stretch(&mut self, class: &str, from: f64, to: f64, what: &str) {
        let (left, right) = (self.x_px(from).clamp(0.0, self.area.width), self.x_px(to).clamp(0.0, self.area.width));
        if left.is_finite() && right.is_finite() {
            self.inner.raw(&format!("<g><title>{}</title>", escape(what)));
            self.inner.rect(class, left, 0.0, (right - left).max(1.0), self.area.height);
            self.inner.raw("</g>");
        }
    }

    /// A line across at height `y`.
    pub fn level(&mut self, class: &str, y: f64) {
        let at = self.y_px(y);
        if at.is_finite() {
            self.inner.line(class, (0.0, at), (self.area.width, at));
        }
    }

    /// Axes, grid and content.
    pub fn draw(self, svg: &mut Svg) {
        let Area { left, top, width, height } = self.area;
        let empty = self.x.is_empty() || self.y.is_empty();
        svg.rect("plot", left, top, width, height);
        if empty {
            svg.text("faint", (left + width / 2.0, top + height / 2.0 + 4.0), Anchor::Middle, width, "no data");
        } else {
            self.horizontal(svg);
            self.vertical(svg);
            svg.clipped(&self.axes(), (left, top, width, height), &self.inner);
        }
        svg.rect("frame", left, top, width, height);
        let count = y_ticks(height);
        let (x, y) = (left - 58.0, top + height / 2.0);
        svg.turned_text("label", (x, y), Anchor::Middle, height + 24.0, &self.y.label(count), -90);
        if self.x_labelled {
            let at = (left + width / 2.0, top + height + 34.0);
            svg.text("label", at, Anchor::Middle, width, &self.x.label(x_ticks(width)));
        }
    }

    /// Both axes as attributes, in the numbers of their labels, for the readout and the zoom.
    fn axes(&self) -> String {
        let mut text = String::from(" class=\"panel\"");
        let counts = [x_ticks(self.area.width), y_ticks(self.area.height)];
        for ((name, axis), count) in [("x", &self.x), ("y", &self.y)].into_iter().zip(counts) {
            if let Some((low, high, logarithmic)) = axis.ends(count) {
                let label = escape(&axis.label(count));
                let _ = write!(text, " data-{name}=\"{low:?} {high:?}\" data-{name}name=\"{label}\"");
                text.push_str(&if logarithmic { format!(" data-{name}log=\"1\"") } else { String::new() });
            }
        }
        text
    }

    fn horizontal(&self, svg: &mut Svg) {
        let Area { left, top, width, height } = self.area;
        let mut free = left - 20.0;
        svg.raw(if self.x_labelled { "<g class=\"xticks\" data-labelled=\"1\">" } else { "<g class=\"xticks\">" });
        for tick in self.x.ticks(x_ticks(width)) {
            let x = left + tick.place * width;
            svg.line("grid", (x, top), (x, top + height));
            let half = FONT * width_em(&tick.label) / 2.0;
            // A label that would touch its neighbour or leave the figure is left out; its grid line
            // stays.
            if self.x_labelled && x - half > free && x + half < WIDTH {
                svg.text("tick", (x, top + height + 16.0), Anchor::Middle, WIDTH, &tick.label);
                free = x + half + 4.0;
            }
        }
        svg.raw("</g>");
    }

    fn vertical(&self, svg: &mut Svg) {
        let Area { left, top, width, height } = self.area;
        for tick in self.y.ticks(y_ticks(height)) {
            let y = top + (1.0 - tick.place) * height;
            svg.line("grid", (left, y), (left + width, y));
            svg.text("tick", (left - 6.0, y + 4.0), Anchor::End, 50.0, &tick.label);
        }
    }
}

fn x_ticks(width: f64) -> usize {
    (width / 90.0).clamp(2.0, 10.0) as usize
}

fn y_ticks(height: f64) -> usize {
    (height / 38.0).clamp(2.0, 8.0) as usize
}

/// One line of a legend.
pub struct Entry<'a> {
    /// Class of the sample drawn: `line …`, `dot …`, `ring …`, `…-fill` or `area …`.
    pub class: String,
    pub label: &'a str,
}

/// Draws the legend from `top` in as many lines as it takes; gives the height used.
pub fn legend(svg: &mut Svg, top: f64, entries: &[Entry<'_>]) -> f64 {
    const SAMPLE: f64 = 26.0;
    let (mut x, mut y) = (LEFT, top + 12.0);
    for entry in entries.iter().filter(|entry| !entry.label.is_empty()) {
        let width = (SAMPLE + FONT * width_em(entry.label)).min(PLOT_WIDTH);
        if x > LEFT && x + width > LEFT + PLOT_WIDTH {
            (x, y) = (LEFT, y + 18.0);
        }
        if entry.class.starts_with("dot") {
            svg.dots(&entry.class, &[(x + 4.0, y - 4.0), (x + 10.0, y - 6.0), (x + 16.0, y - 3.0)]);
        } else if entry.class.starts_with("ring") || entry.class.ends_with("-fill") {
            svg.circle(&entry.class, x + 10.0, y - 4.0, 3.0);
        } else if entry.class.starts_with("area") {
            svg.rect(&entry.class, x, y - 9.0, 20.0, 10.0);
        } else {
            svg.path(&entry.class, &[vec![(x, y - 4.0), (x + 20.0, y - 4.0)]]);
        }
        svg.text("tick", (x + SAMPLE, y), Anchor::Start, width - SAMPLE + 1.0, entry.label);
        x += width + 16.0;
    }
    if entries.is_empty() { 0.0 } else { y + 6.0 - top }
}
