//! The one table of the answer: effect, parameter, confirmed by, p.

use super::answer::{confirmed_by, estimate};
use super::{Diagnosed, names};
use examination::doctor::p_value;
use identification::statistics::normal_tail;
use std::fmt::Write;

/// Heads of the columns; p is that of the effect alone, before any correction for hypotheses.
pub const COLUMNS: [&str; 5] = ["effect", "site", "parameter ± sd", "confirmed by", "p, one test"];

/// One row per parameter; the effect stands in the first of its rows.
pub fn rows(diagnosed: &Diagnosed) -> Vec<[String; 5]> {
    let mut rows = Vec::new();
    for effect in &diagnosed.diagnosis.effects {
        let one = effect.parameters.len() == 1;
        let written =
            effect.parameters.iter().map(|p| if one { estimate(p) } else { format!("{} {}", p.name, estimate(p)) });
        let mut written: Vec<String> = written.collect();
        if written.is_empty() {
            written.push("–".into());
        }
        let p = p_value(2.0 * normal_tail(effect.d.abs()));
        for (k, parameter) in written.into_iter().enumerate() {
            rows.push(match k {
                0 => [
                    names::spaced(&effect.title),
                    names::site_in_words(&effect.site),
                    parameter,
                    confirmed_by(diagnosed, effect.status),
                    p.clone(),
                ],
                _ => [String::new(), String::new(), parameter, String::new(), String::new()],
            });
        }
    }
    rows
}

/// The table for a terminal; empty without an effect.
pub fn in_words(diagnosed: &Diagnosed) -> String {
    let rows = rows(diagnosed);
    if rows.is_empty() {
        return String::new();
    }
    let head = COLUMNS.map(str::to_owned);
    let all: Vec<&[String; 5]> = std::iter::once(&head).chain(&rows).collect();
    let width = |k: usize| all.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; 5] = std::array::from_fn(width);
    let mut text = String::from("\n");
    for row in all {
        let mut line = String::new();
        row.iter().zip(widths).for_each(|(cell, width)| {
            let _ = write!(line, "{cell:<width$}  ");
        });
        let _ = writeln!(text, "{}", line.trim_end());
    }
    text
}
