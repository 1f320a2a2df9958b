//! Time × frequency per channel: where and when a residual is not noise.

use super::heat::Colours;
use crate::data::{Data, named, number, quoted};
use crate::panel::{Area, BELOW, Panel};
use crate::scale::Axis;
use crate::svg::{Anchor, Figure, Svg, WIDTH};

/// One channel, one map.
#[derive(Clone, Debug)]
pub struct Tiles<'a> {
    pub name: &'a str,
    /// Edges of the columns; equal steps \[s\].
    pub time_s: (f64, f64),
    /// Edges of the rows, one octave each, from the lowest \[Hz\].
    pub frequency_hz: (f64, f64),
    /// Rows from the lowest frequency up; within a row by time.
    pub rows: Vec<Vec<f64>>,
}

/// Maps over the same colour scale, e.g. before and after side by side.
#[derive(Clone, Debug, Default)]
pub struct TileMap<'a> {
    /// Name and unit of the coloured quantity.
    pub quantity: &'a str,
    pub unit: &'a str,
    /// Ends of the colour scale; those of the data where none are given. Give it to two figures to
    /// compare them.
    pub range: Option<(f64, f64)>,
    pub maps: Vec<Tiles<'a>>,
    /// Maps per line: 1, or 2 to set before beside after.
    pub columns: usize,
}

const BIN_ROW_HEIGHT: f64 = 16.0;
/// The turned label of the frequency fits.
const HEIGHT_MIN: f64 = 100.0;

impl TileMap<'_> {
    /// One map of time and frequency per channel on a common colour scale, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let all = self.maps.iter().flat_map(|m| m.rows.iter().flatten().copied());
        let Some(colours) = Colours::new(all, self.range).filter(|_| !self.maps.is_empty()) else {
            let none = || std::iter::empty::<f64>();
            let panel = Panel::new(
                Area::full(8.0, 80.0),
                Axis::tight("time", "s", none()),
                Axis::linear("frequency", "Hz", none()),
            );
            panel.draw(&mut svg);
            return svg.figure(claim, 88.0 + BELOW);
        };
        colours.legend(&mut svg, 4.0, self.quantity, self.unit);
        let columns = self.columns.clamp(1, 2);
        let mut top = 44.0;
        for line in self.maps.chunks(columns) {
            let height = line
                .iter()
                .map(|m| (BIN_ROW_HEIGHT * m.rows.len() as f64).clamp(HEIGHT_MIN, 240.0))
                .fold(0.0, f64::max);
            for (k, map) in line.iter().enumerate() {
                let width = WIDTH / columns as f64;
                let area = Area { left: 74.0 + k as f64 * width, top: top + 18.0, width: width - 90.0, height };
                svg.text("strong", (area.left, top + 12.0), Anchor::Start, area.width, map.name);
                draw_map(&mut svg, area, map, &colours);
            }
            top += 18.0 + height + BELOW + 8.0;
        }
        svg.figure(claim, top).data(self.data())
    }

    /// One row per bin: map, lower ends of its time and frequency, value.
    fn data(&self) -> Data {
        let columns = |map: &Tiles<'_>| map.rows.first().map_or(0, Vec::len);
        let each = self.maps.iter().enumerate();
        let bins: Vec<(usize, usize, usize)> = each
            .flat_map(|(m, map)| (0..map.rows.len()).flat_map(move |row| (0..columns(map)).map(move |k| (m, row, k))))
            .collect();
        let value = named((self.quantity, self.unit));
        Data::new(&["map", "time [s]", "frequency [Hz]", &value], bins.len(), |bin| {
            let (m, row, column) = bins[bin];
            let (map, (low, high)) = (&self.maps[m], self.maps[m].frequency_hz);
            let time = map.time_s.0 + (map.time_s.1 - map.time_s.0) * column as f64 / columns(map) as f64;
            let frequency = low * libm::pow(high / low, row as f64 / map.rows.len() as f64);
            let bin = map.rows[row].get(column).copied().unwrap_or(f64::NAN);
            vec![quoted(map.name), number(time), number(frequency), number(bin)]
        })
    }
}

fn draw_map(svg: &mut Svg, area: Area, map: &Tiles<'_>, colours: &Colours) {
    let x = Axis::tight("time", "s", [map.time_s.0, map.time_s.1].into_iter());
    let y = Axis::octaves("frequency", "Hz", map.frequency_hz);
    let mut panel = Panel::new(area, x, y);
    let rows = map.rows.len().max(1);
    let height = area.height / rows as f64;
    for (k, row) in map.rows.iter().enumerate() {
        let top = area.height - (k + 1) as f64 * height;
        let pooled = pooled(row, area.width as usize / 2);
        let width = area.width / pooled.len().max(1) as f64;
        colours.row(&mut panel.inner, 0.0, top, (width, height), pooled.into_iter());
    }
    panel.draw(svg);
}

/// At most `count` time–frequency bins, each the value of largest magnitude that it covers.
fn pooled(row: &[f64], count: usize) -> Vec<f64> {
    let size = row.len().div_ceil(count.max(1)).max(1);
    let largest = |tiles: &[f64]| {
        tiles.iter().copied().filter(|v| v.is_finite()).fold(f64::NAN, |m, v| if v.abs() <= m.abs() { m } else { v })
    };
    row.chunks(size).map(largest).collect()
}
