//! A force over two coordinates: where in state space the missing physics acts.

use super::heat::Colours;
use crate::data::{Data, named, number};
use crate::panel::{Area, BELOW, Panel};
use crate::scale::Axis;
use crate::svg::{Anchor, Figure, Svg};

/// A surface over two coordinates, as colours; where both signs occur, signs are written over them.
#[derive(Clone, Debug, Default)]
pub struct StateMap<'a> {
    /// Name and unit of the horizontal coordinate, and its ends.
    pub x: (&'a str, &'a str),
    pub x_range: (f64, f64),
    pub y: (&'a str, &'a str),
    pub y_range: (f64, f64),
    /// Meaning of the colour.
    pub force: (&'a str, &'a str),
    /// Ends of the colour scale; those of the data where none are given. Give it to two maps to
    /// compare them.
    pub range: Option<(f64, f64)>,
    /// Rows from the lowest `y` up; NaN for cells without data.
    pub rows: Vec<Vec<f64>>,
    /// Where the recording has been.
    pub visited: (&'a [f64], &'a [f64]),
}

const STATE_MAP_HEIGHT: f64 = 300.0;

impl StateMap<'_> {
    /// Cells over two coordinates, coloured by value, empty without data, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let colours = Colours::new(self.rows.iter().flatten().copied(), self.range);
        let ends = |range: (f64, f64)| [range.0, range.1].into_iter().filter(|_| colours.is_some());
        let area = Area::full(44.0, STATE_MAP_HEIGHT);
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
            if colours.is_signed() {
                signs(&mut panel.inner, colours, &self.rows, area);
            }
            panel.dots("dot measured small", self.visited.0, self.visited.1);
        }
        panel.draw(&mut svg);
        svg.figure(claim, 44.0 + STATE_MAP_HEIGHT + BELOW).data(self.data())
    }

    /// One row per cell: its middle and its value.
    fn data(&self) -> Data {
        let columns = self.rows.first().map_or(0, Vec::len);
        let middle = |(low, high): (f64, f64), k: usize, of: usize| low + (high - low) * (k as f64 + 0.5) / of as f64;
        let header = [named(self.x), named(self.y), named(self.force)];
        Data::new(&header.each_ref().map(String::as_str), columns * self.rows.len(), |cell| {
            let (row, column) = (cell / columns, cell % columns);
            let value = self.rows[row].get(column).copied().unwrap_or(f64::NAN);
            let at = [middle(self.x_range, column, columns), middle(self.y_range, row, self.rows.len()), value];
            at.map(number).to_vec()
        })
    }
}

/// Room of a sign [pixels].
const SIGN: f64 = 26.0;

/// Plus and minus over the cells: both ends of the scale are equally dark where there is no colour.
fn signs(svg: &mut Svg, colours: &Colours, rows: &[Vec<f64>], area: Area) {
    let height = area.height / rows.len() as f64;
    let every = |size: f64| (SIGN / size.max(1e-9)).ceil().max(1.0) as usize;
    for (k, row) in rows.iter().enumerate().skip(every(height) / 2).step_by(every(height)) {
        let width = area.width / row.len().max(1) as f64;
        for (i, value) in row.iter().enumerate().skip(every(width) / 2).step_by(every(width)) {
            let Some(level) = colours.level(*value) else { continue };
            let at = ((i as f64 + 0.5) * width, area.height - (k as f64 + 0.5) * height + 4.0);
            svg.text(colours.ink(level), at, Anchor::Middle, SIGN, if *value < 0.0 { "−" } else { "+" });
        }
    }
}
