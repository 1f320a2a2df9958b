//! Tables: numbers aligned on the decimal point, with their standard deviations.

use crate::text::{escape, short, with_sigma};
use std::fmt::Write;

/// One entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A name or a word.
    Text(String),
    /// Sentences, which need width; line breaks stay.
    Prose(String),
    /// A word with its severity: `note`, `warning` or `fault`.
    Severity(String),
    Number(f64),
    /// Value and standard deviation.
    Estimate(f64, f64),
    /// A number as formatted by the caller.
    Written(String),
    None,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.into())
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Cell::None, Cell::Number)
    }
}

impl Cell {
    /// Value and, where there is one, its standard deviation, as text.
    fn number(&self) -> Option<(String, Option<String>)> {
        match self {
            Cell::Number(value) => Some((short(*value), None)),
            Cell::Estimate(value, sigma) => {
                let (value, sigma) = with_sigma(*value, *sigma);
                Some((value, Some(sigma)))
            }
            Cell::Written(text) => Some((text.clone(), None)),
            _ => None,
        }
    }
}

/// A table: a heading per column, cells per row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    pub caption: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table with these column heads and no rows.
    #[must_use]
    pub fn new(caption: &str, columns: &[&str]) -> Self {
        Table { caption: caption.into(), columns: columns.iter().map(|c| (*c).into()).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// When it has not one cell per column.
    pub fn row(&mut self, cells: Vec<Cell>) {
        assert!(cells.len() == self.columns.len());
        self.rows.push(cells);
    }

    pub(crate) fn html(&self) -> String {
        let widths: Vec<Widths> =
            (0..self.columns.len()).map(|k| Widths::of(self.rows.iter().map(|r| &r[k]))).collect();
        let mut html = String::from("<div class=\"wide\"><table>");
        if !self.caption.is_empty() {
            let _ = write!(html, "<caption>{}</caption>", escape(&self.caption));
        }
        html.push_str("<thead><tr>");
        for (name, width) in self.columns.iter().zip(&widths) {
            let class = if width.whole > 0 { " class=\"n\"" } else { "" };
            let _ = write!(html, "<th{class}>{}</th>", escape(name));
        }
        html.push_str("</tr></thead><tbody>");
        for row in &self.rows {
            html.push_str("<tr>");
            for (cell, width) in row.iter().zip(&widths) {
                html.push_str(&width.cell(cell));
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</tbody></table></div>\n");
        html
    }
}

/// Characters before the point and from the point on, of the values and the deviations of a column.
#[derive(Default)]
struct Widths {
    whole: usize,
    fraction: usize,
    sigma_whole: usize,
    sigma_fraction: usize,
}

fn parts(number: &str) -> (&str, &str) {
    number.split_at(number.find(['.', 'e']).unwrap_or(number.len()))
}

impl Widths {
    fn of<'a>(cells: impl Iterator<Item = &'a Cell>) -> Self {
        let mut widths = Widths::default();
        for (value, sigma) in cells.filter_map(Cell::number) {
            let (whole, fraction) = parts(&value);
            widths.whole = widths.whole.max(whole.chars().count());
            widths.fraction = widths.fraction.max(fraction.chars().count());
            if let Some(sigma) = sigma {
                let (whole, fraction) = parts(&sigma);
                widths.sigma_whole = widths.sigma_whole.max(whole.chars().count());
                widths.sigma_fraction = widths.sigma_fraction.max(fraction.chars().count());
            }
        }
        widths
    }

    fn cell(&self, cell: &Cell) -> String {
        if let Some((value, sigma)) = cell.number() {
            let mut html = format!("<td class=\"n\">{}", aligned(&value, self.whole, self.fraction));
            if self.sigma_whole > 0 {
                let text = sigma.unwrap_or_default();
                html.push_str(if text.is_empty() { "   " } else { " ± " });
                html.push_str(&aligned(&text, self.sigma_whole, self.sigma_fraction));
            }
            html.push_str("</td>");
            return html;
        }
        match cell {
            Cell::Prose(text) => format!("<td class=\"prose\">{}</td>", escape(text).replace('\n', "<br/>")),
            Cell::Severity(text) => format!("<td class=\"s-{}\">{}</td>", escape(text), escape(text)),
            Cell::Text(text) => format!("<td class=\"name\">{}</td>", breakable(text)),
            _ if self.whole > 0 => format!("<td class=\"n\">{}</td>", aligned("–", self.whole, self.fraction)),
            _ => "<td>–</td>".into(),
        }
    }
}

/// A name that may go on in the next line behind its `@` and `:`.
fn breakable(name: &str) -> String {
    name.split_inclusive(['@', ':']).map(escape).collect::<Vec<_>>().join("<wbr/>")
}

/// Both sides of the point in boxes of their own, so that copied text carries no filling.
fn aligned(number: &str, whole_ch: usize, fraction_ch: usize) -> String {
    let (whole, fraction) = parts(number);
    // A minus sign is wider than a digit in most fonts.
    let wider = if whole.starts_with('-') { ".4" } else { "" };
    let mut html =
        format!("<span class=\"i\" style=\"width:{}{wider}ch\">{}</span>", whole_ch, escape(&whole.replace('-', "−")));
    if fraction_ch > 0 {
        let _ = write!(
            html,
            "<span class=\"f\" style=\"width:{fraction_ch}ch\">{}</span>",
            escape(&fraction.replace('-', "−"))
        );
    }
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_of_a_column_has_its_point_at_the_same_place() {
        let mut table = Table::new("masses", &["name", "estimate [kg]"]);
        for (value, sigma) in [(28.7, 0.41), (1004.5, 12.0), (-0.031_23, 0.000_45)] {
            table.row(vec!["m".into(), Cell::Estimate(value, sigma)]);
        }
        let html = table.html();
        // The boxes of the fractions, which end at the same edge, are equally wide: so the points
        // stand below each other.
        assert_eq!(html.matches("<span class=\"i\" style=\"width:4").count(), 3, "{html}");
        assert_eq!(html.matches("<span class=\"f\" style=\"width:6ch\">").count(), 6, "{html}");
        for text in [">28<", ">.70<", ">1004<", ">−0<", ">.03123<", ">.00045<", " ± "] {
            assert!(html.contains(text), "{text}: {html}");
        }
    }

    #[test]
    fn what_is_missing_is_a_dash_and_not_a_number() {
        let mut table = Table::new("", &["x"]);
        table.row(vec![Cell::Number(f64::NAN)]);
        table.row(vec![Cell::None]);
        assert!(!table.html().contains("NaN") && table.html().matches('–').count() == 2);
    }
}
