//! Values as colours: levels, runs of equal colour, the bar of the colour scale.

use crate::panel::LEFT;
use crate::scale::Axis;
use crate::style::LEVELS;
use crate::svg::{Anchor, Svg};

/// A colour scale.
pub struct Colours {
    low: f64,
    high: f64,
    /// Two colours, one per sign; else one.
    signed: bool,
}

impl Colours {
    /// Over the finite elements of `values`, or over `range` where one is given. A scale with both
    /// signs is symmetric about zero.
    pub fn new(values: impl Iterator<Item = f64>, range: Option<(f64, f64)>) -> Option<Self> {
        let finite = values.filter(|v| v.is_finite());
        let found = finite.fold(None, |r: Option<(f64, f64)>, v| Some(r.map_or((v, v), |(l, h)| (l.min(v), h.max(v)))));
        let (low, high) = range.or(found)?;
        let signed = low < 0.0 && high > 0.0;
        let size = low.abs().max(high.abs()).clamp(1e-150, 1e150);
        Some(match signed {
            true => Colours { low: -size, high: size, signed },
            false if high > low => Colours { low, high, signed },
            false => Colours { low: low - 0.5 * size, high: low + 0.5 * size, signed },
        })
    }

    /// Both signs occur: the two ends look alike without colour.
    pub fn is_signed(&self) -> bool {
        self.signed
    }

    /// Level of a value; `None` for NaN and infinity.
    pub fn level(&self, value: f64) -> Option<usize> {
        let share = (value - self.low) / (self.high - self.low);
        value.is_finite().then(|| ((share * LEVELS as f64).max(0.0) as usize).min(LEVELS - 1))
    }

    /// CSS class of a level: `d0` … on a signed scale, `q0` … on one of one sign.
    pub fn class(&self, level: usize) -> String {
        format!("{}{level}", if self.signed { 'd' } else { 'q' })
    }

    /// Class of text that can be read on a level, in both forms of the page.
    pub fn ink(&self, level: usize) -> &'static str {
        let strong = if self.signed { (2 * level as i32 + 1 - LEVELS as i32).unsigned_abs() as usize } else { level };
        if strong > LEVELS / 2 - 2 { "on-high" } else { "label" }
    }

    /// A row of cells of equal size; cells of equal colour become one rectangle.
    pub fn row(&self, svg: &mut Svg, left: f64, top: f64, size: (f64, f64), values: impl Iterator<Item = f64>) {
        let mut run: Option<(usize, usize, usize)> = None;
        let mut flush = |run: Option<(usize, usize, usize)>| {
            if let Some((level, first, count)) = run {
                // A hair wider than the cell: no seams between neighbours.
                svg.rect(
                    &self.class(level),
                    left + first as f64 * size.0,
                    top,
                    count as f64 * size.0 + 0.3,
                    size.1 + 0.3,
                );
            }
        };
        for (k, value) in values.enumerate() {
            run = match (self.level(value), run) {
                (Some(level), Some((known, first, count))) if level == known => Some((level, first, count + 1)),
                (level, before) => {
                    flush(before);
                    level.map(|level| (level, k, 1))
                }
            };
        }
        flush(run);
    }

    /// The bar of the scale with its ticks; 34 px high.
    pub fn legend(&self, svg: &mut Svg, top: f64, quantity: &str, unit: &str) {
        const SCALE_WIDTH: f64 = 240.0;
        let axis = Axis::tight(quantity, unit, [self.low, self.high].into_iter());
        let step = SCALE_WIDTH / LEVELS as f64;
        for level in 0..LEVELS {
            svg.rect(&self.class(level), LEFT + level as f64 * step, top, step + 0.3, 10.0);
        }
        svg.rect("frame", LEFT, top, SCALE_WIDTH, 10.0);
        for tick in axis.ticks(4) {
            svg.text("tick", (LEFT + tick.place * SCALE_WIDTH, top + 24.0), Anchor::Middle, 60.0, &tick.label);
        }
        svg.text("label", (LEFT + SCALE_WIDTH + 28.0, top + 10.0), Anchor::Start, 390.0, &axis.label(4));
    }
}
