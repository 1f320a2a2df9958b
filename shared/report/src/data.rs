//! The data behind a figure as CSV in a link: bounded in size, without a file or a network.

use crate::curve::Curve;
use std::fmt::Write;

/// Rows of one figure; longer data keep every k-th row, and the link says so.
const ROWS_MAX: usize = 2000;

/// Comma-separated rows under a heading, every `step`-th of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Data {
    csv: String,
    step: usize,
}

impl Data {
    /// `count` rows of which `row` writes the k-th; a header of quoted names.
    pub fn new(header: &[&str], count: usize, row: impl Fn(usize) -> Vec<String>) -> Self {
        let step = count.div_ceil(ROWS_MAX).max(1);
        let mut csv = header.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(",");
        csv.push('\n');
        for k in (0..count).step_by(step) {
            csv.push_str(&row(k).join(","));
            csv.push('\n');
        }
        Data { csv, step }
    }

    /// One row per sample: name of the curve, horizontal and vertical value.
    pub fn of_curves(x: (&str, &str), y: (&str, &str), curves: &[Curve<'_>]) -> Self {
        let length = |c: &Curve<'_>| c.x.len().min(c.y.len());
        let step = curves.iter().map(length).sum::<usize>().div_ceil(ROWS_MAX).max(1);
        let kept: Vec<(usize, usize)> = (curves.iter().enumerate())
            .flat_map(|(c, curve)| (0..length(curve)).step_by(step).map(move |k| (c, k)))
            .collect();
        let row = |i: usize| {
            let (curve, k) = (&curves[kept[i].0], kept[i].1);
            vec![quoted(curve.label), number(curve.x[k]), number(curve.y[k])]
        };
        // the few rows beyond the bound that rounding leaves are kept
        let mut data = Data::new(&["curve", &named(x), &named(y)], 0, row);
        (0..kept.len()).for_each(|i| {
            data.csv.push_str(&row(i).join(","));
            data.csv.push('\n');
        });
        Data { step, ..data }
    }

    /// The element that a reader clicks to have the rows as a file.
    pub fn link(&self, title: &str) -> String {
        let what = if self.step == 1 { "data".to_owned() } else { format!("data, 1 of {} samples", self.step) };
        let name = file_name(title);
        format!(
            " <a class=\"data\" download=\"{name}.csv\" href=\"data:text/csv;charset=utf-8,{}\">{what}</a>",
            encoded(&self.csv)
        )
    }
}

/// Name and unit as the heading of a column.
pub fn named((quantity, unit): (&str, &str)) -> String {
    if matches!(unit, "" | "-") { quantity.to_owned() } else { format!("{quantity} [{unit}]") }
}

/// A number with seven digits; without a value the cell is empty.
pub fn number(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(f64::NAN);
    if rounded.is_finite() { format!("{rounded:?}") } else { String::new() }
}

/// Text as one cell.
pub fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// Letters and digits of a title, at most 40 of them.
fn file_name(title: &str) -> String {
    let words = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let joined = words.collect::<Vec<_>>().join("-").to_lowercase();
    let name: String = joined.chars().take(40).collect();
    if name.is_empty() { "figure".into() } else { name }
}

/// Every byte that an address does not hold as `%XX`.
fn encoded(text: &str) -> String {
    let mut out = String::with_capacity(text.len() * 5 / 4);
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~,".contains(&byte) {
            out.push(char::from(byte));
        } else {
            let _ = write!(out, "%{byte:02X}");
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figures::Role;

    #[test]
    fn the_link_holds_every_number_and_nothing_that_ends_it() {
        let (x, y) = ([0.0, 0.5], [1e-9, f64::NAN]);
        let curve = Curve { label: "a, \"b\" <c>", role: Role::After, x: &x, y: &y };
        let data = Data::of_curves(("time", "s"), ("rate", "rad/s"), &[curve]);
        assert_eq!(data.csv, "curve,time [s],rate [rad/s]\n\"a, \"\"b\"\" <c>\",0.0,1e-9\n\"a, \"\"b\"\" <c>\",0.5,\n");
        let link = data.link("Rate: 3 % <off>");
        assert!(link.contains("download=\"rate-3-off.csv\"") && link.contains(">data</a>"), "{link}");
        assert!(!link.contains("<c>") && link.matches('"').count() == 6, "{link}");
    }

    #[test]
    fn a_long_record_keeps_every_kth_sample_and_says_so() {
        let x: Vec<f64> = (0..50_000).map(f64::from).collect();
        let curve = |label| Curve { label, role: Role::After, x: &x, y: &x };
        let data = Data::of_curves(("t", "s"), ("y", "-"), &[curve("a"), curve("b")]);
        assert!(data.csv.lines().count() <= ROWS_MAX + 3, "{}", data.csv.lines().count());
        assert!(data.link("").contains("1 of 50 samples"));
        let rows = Data::new(&["k"], 9000, |k| vec![number(k as f64)]);
        assert!(rows.csv.lines().count() <= ROWS_MAX + 1 && rows.csv.starts_with("k\n0.0\n5.0\n"));
    }
}
