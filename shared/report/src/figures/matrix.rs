//! Every pair of a list as a number: angles between rivals, correlations, shapes against shapes.

use super::heat::Colours;
use crate::data::{Data, named, number, quoted};
use crate::svg::{Anchor, FONT, Figure, Svg, WIDTH};
use crate::text::{short, width_em};

/// A square or oblong matrix; rows carry names, columns their numbers.
#[derive(Clone, Debug, Default)]
pub struct Matrix<'a> {
    pub quantity: &'a str,
    pub unit: &'a str,
    pub rows: Vec<String>,
    /// Names of the columns; those of the rows where empty.
    pub columns: Vec<String>,
    /// One row per name.
    pub values: Vec<Vec<f64>>,
    pub range: Option<(f64, f64)>,
}

const LEGEND: f64 = 40.0;

impl Matrix<'_> {
    /// One coloured cell per pair, with its value, under the title `claim`.
    #[must_use]
    pub fn draw(&self, claim: &str) -> Figure {
        let mut svg = Svg::default();
        let Some(colours) = Colours::new(self.values.iter().flatten().copied(), self.range) else {
            svg.text("faint", (WIDTH / 2.0, 40.0), Anchor::Middle, WIDTH, "no data");
            return svg.figure(claim, 64.0);
        };
        colours.legend(&mut svg, 4.0, self.quantity, self.unit);
        let columns = if self.columns.is_empty() { &self.rows } else { &self.columns };
        let numbered = |k: usize, name: &str| format!("{}  {name}", k + 1);
        let widest = self.rows.iter().enumerate().map(|(k, n)| FONT * width_em(&numbered(k, n))).fold(40.0, f64::max);
        let left = (widest + 16.0).min(330.0);
        let cell = ((WIDTH - left - 10.0) / columns.len().max(1) as f64).min(56.0);
        let height = cell.clamp(16.0, 24.0);
        let top = LEGEND + 22.0;
        for k in 0..columns.len() {
            let at = (left + (k as f64 + 0.5) * cell, top - 6.0);
            if cell >= 16.0 || k % 5 == 4 {
                svg.text("tick", at, Anchor::Middle, 40.0, &(k + 1).to_string());
            }
        }
        for (i, values) in self.values.iter().enumerate() {
            let y = top + i as f64 * height;
            let name = self.rows.get(i).map_or("", String::as_str);
            svg.text("label", (left - 8.0, y + height / 2.0 + 4.0), Anchor::End, left - 12.0, &numbered(i, name));
            for (j, value) in values.iter().take(columns.len()).enumerate() {
                draw_cell(&mut svg, &colours, *value, (left + j as f64 * cell, y), (cell, height));
            }
        }
        let mut bottom = top + self.values.len() as f64 * height + 8.0;
        if !self.columns.is_empty() {
            for (k, name) in columns.iter().enumerate() {
                svg.text("tick", (left, bottom + 12.0), Anchor::Start, WIDTH - left, &numbered(k, name));
                bottom += 16.0;
            }
        }
        svg.figure(claim, bottom + 8.0).data(self.data())
    }

    /// One row per pair.
    fn data(&self) -> Data {
        let names = if self.columns.is_empty() { &self.rows } else { &self.columns };
        let name = |names: &[String], k: usize| quoted(names.get(k).map_or("", String::as_str));
        let value = named((self.quantity, self.unit));
        Data::new(&["row", "column", &value], self.values.len() * names.len(), |pair| {
            let (i, j) = (pair / names.len(), pair % names.len());
            let value = self.values[i].get(j).copied().unwrap_or(f64::NAN);
            vec![name(&self.rows, i), name(names, j), number(value)]
        })
    }
}

fn draw_cell(svg: &mut Svg, colours: &Colours, value: f64, at: (f64, f64), size: (f64, f64)) {
    let Some(level) = colours.level(value) else {
        svg.text("faint", (at.0 + size.0 / 2.0, at.1 + size.1 / 2.0 + 4.0), Anchor::Middle, size.0, "–");
        return;
    };
    svg.rect(&colours.class(level), at.0, at.1, size.0 - 1.0, size.1 - 1.0);
    // Three digits; where they do not fit the colour alone speaks.
    let text = three_digits(value);
    if FONT * width_em(&text) <= size.0 {
        let at = (at.0 + size.0 / 2.0, at.1 + size.1 / 2.0 + 4.0);
        svg.text(colours.ink(level), at, Anchor::Middle, size.0, &text);
    }
}

fn three_digits(value: f64) -> String {
    let size = value.abs();
    if size >= 1000.0 || (size > 0.0 && size < 0.01) {
        return if size < 0.01 && size > 0.0 { "0.00".into() } else { short(value) };
    }
    let decimals = if size >= 100.0 {
        0
    } else if size >= 10.0 {
        1
    } else {
        2
    };
    format!("{value:.decimals$}")
}
