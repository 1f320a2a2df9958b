//! A force over two coordinates: where in state space the missing physics acts.

use super::heat::Colours;
use crate::panel::{Area, BELOW, Panel};
use crate::scale::Axis;
use crate::svg::{Figure, Svg};

/// A surface over two coordinates, as colours.
#[derive(Clone, Debug, Default)]
pub struct StateMap<'a> {
    /// Name and unit of the horizontal coordinate, and its ends.
    pub x: (&'a str, &'a str),
    pub x_range: (f64, f64),
    pub y: (&'a str, &'a str),
    pub y_range: (f64, f64),
    /// What the colour says.
    pub force: (&'a str, &'a str),
    /// Rows from the lowest `y` up; NaN where the data say nothing.
    pub rows: Vec<Vec<f64>>,
    /// Where the recording has been.
    pub visited: (&'a [f64], &'a [f64]),
}

const HEIGHT: f64 = 300.0;

impl StateMap<'_> {
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let colours = Colours::new(self.rows.iter().flatten().copied(), None);
        let ends = |range: (f64, f64)| [range.0, range.1].into_iter().filter(|_| colours.is_some());
        let area = Area::full(44.0, HEIGHT);
        let x = Axis::tight(self.x.0, self.x.1, ends(self.x_range));
        let mut panel = Panel::new(area, x, Axis::tight(self.y.0, self.y.1, ends(self.y_range)));
        if let Some(colours) = &colours {
            colours.legend(&mut svg, 4.0, self.force.0, self.force.1);
            let height = area.height / self.rows.len() as f64;
            for (k, row) in self.rows.iter().enumerate() {
                let top = area.height - (k + 1) as f64 * height;
                let width = area.width / row.len().max(1) as f64;
                colours.row(&mut panel.inner, 0.0, top, (width, height), row.iter().copied());
            }
            panel.dots("dot measured small", self.visited.0, self.visited.1);
        }
        panel.draw(&mut svg);
        svg.figure(claim, 44.0 + HEIGHT + BELOW)
    }
}
