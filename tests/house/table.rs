//! Every figure of the house in one table, for people and for programs.
//!
//! ```sh
//! cargo test --release --test house the_table_of_the_house -- --nocapture
//! ```

use crate::findings::Findings;
use crate::sizes::Counts;
use crate::{circles, public_names, wide_comments, wording};
use serde_json::{Map, Value, json};
use std::fmt::Write;

struct Row {
    key: &'static str,
    value: Value,
    /// What the law asks, and whether it holds.
    law: Option<(String, bool)>,
}

fn row(key: &'static str, value: impl Into<Value>) -> Row {
    Row { key, value: value.into(), law: None }
}

fn below(key: &'static str, value: usize, limit: usize) -> Row {
    Row { key, value: value.into(), law: Some((format!("< {limit}"), value < limit)) }
}

fn none(key: &'static str, value: usize) -> Row {
    Row { key, value: value.into(), law: Some(("none".to_owned(), value == 0)) }
}

fn rounded(value: f64) -> Value {
    json!((value * 10.0).round() / 10.0)
}

fn percent(part: usize, of: usize) -> f64 {
    100.0 * part as f64 / of.max(1) as f64
}

fn largest(circles: &[circles::Circle]) -> usize {
    circles.first().map_or(0, |circle| circle.members.len())
}

fn rows(found: &Findings) -> Vec<Row> {
    let Findings { circles, constants, matches, names, pages, sizes, twice, wide_comments, wording } = found;
    let all = &sizes.all;
    let total = |of: fn(&public_names::Names) -> usize| names.values().map(of).sum::<usize>();
    let (items, undocumented) = (total(|own| own.items), total(|own| own.undocumented.len()));
    let constants_all = constants.all.values().map(Vec::len).sum::<usize>();
    let documented = Row {
        key: "public items documented [%]",
        value: rounded(percent(items - undocumented, items)),
        law: Some((
            format!(">= {:.0}", 100.0 * public_names::DOCUMENTED_MIN),
            items as f64 * public_names::DOCUMENTED_MIN <= (items - undocumented) as f64,
        )),
    };
    let size = largest(&circles.of_files);
    let largest_circle = Row {
        key: "largest circle of files",
        value: size.into(),
        law: Some((format!("<= {}", circles::FILES_MAX), size <= circles::FILES_MAX)),
    };
    vec![
        row("circles of files", circles.of_files.len()),
        largest_circle,
        row("circles of files, parents' uses of their parts counted", circles.with_parents.len()),
        row("largest of these", largest(&circles.with_parents)),
        row("circles of subjects (modules below a root)", circles.of_subjects.len()),
        none("circles of crates", circles.of_crates.len()),
        row("files", all.files),
        row("files over 350 lines", sizes.long_files.len()),
        row("lines", all.lines),
        row("lines of code", all.code),
        row("lines of documentation [%]", rounded(percent(all.doc, all.lines))),
        row("lines of comments [%]", rounded(percent(all.comments, all.lines))),
        below("comments over 100 columns", wide_comments.len(), wide_comments::COMMENTS_MAX),
        row("functions", sizes.functions.len()),
        row("lines of a function, median", sizes.quantile(0.5)),
        row("lines of a function, 90 %", sizes.quantile(0.9)),
        row("lines of a function, 99 %", sizes.quantile(0.99)),
        row("functions over 70 lines", sizes.long_functions.len()),
        row("assertions per thousand lines of code", rounded(all.per_kline(all.assertions))),
        row("named numeric constants", constants_all),
        row("named numeric constants per thousand lines of code", rounded(all.per_kline(constants_all))),
        none("names with several values in a crate", constants.ambiguous.values().map(Vec::len).sum()),
        none("named methods that are written twice", twice.len()),
        none("lines that decide on the name of an effect", matches.lines.len()),
        row("lines that pass the name of a parameter to a function", matches.arguments.len()),
        row("public items", items),
        documented,
        row("public names that other crates can reach", total(|own| own.reachable)),
        row("public names that no other crate uses", total(|own| own.unused.len())),
        row("doc tests", pages.doc_tests),
        none("crates without a complete front page", pages.incomplete.len()),
        below("phrases of the old wording", wording.len(), wording::OCCURRENCES_MAX),
    ]
}

/// Figures of a crate by the name of the column.
fn columns(found: &Findings, krate: &str, counts: &Counts) -> Vec<(&'static str, Value)> {
    let constants = found.constants.all[krate].len();
    let names = &found.names[krate];
    vec![
        ("files", counts.files.into()),
        ("code", counts.code.into()),
        ("assertions/k", rounded(counts.per_kline(counts.assertions))),
        ("constants", constants.into()),
        ("constants/k", rounded(counts.per_kline(constants))),
        ("ambiguous", found.constants.ambiguous[krate].len().into()),
        ("public", names.items.into()),
        ("documented %", rounded(percent(names.items - names.undocumented.len(), names.items))),
        ("reachable", names.reachable.into()),
        ("unused", names.unused.len().into()),
    ]
}

fn text(found: &Findings) -> String {
    let mut text = String::new();
    for Row { key, value, law } in rows(found) {
        let (law, holds) =
            law.map_or((String::new(), ""), |(law, holds)| (law, if holds { "holds" } else { "BROKEN" }));
        writeln!(text, "{}", format!("{key:<56} {value:>8}  {law:<6} {holds}").trim_end()).unwrap();
    }
    for (place, (krate, counts)) in found.sizes.crates.iter().enumerate() {
        let columns = columns(found, krate, counts);
        let width = |name: &str| name.len().max(7) + 2;
        if place == 0 {
            let head: String = columns.iter().map(|(name, _)| format!("{name:>0$}", width(name))).collect();
            write!(text, "\n{:<24}{head}\n", "crate").unwrap();
        }
        let values: String =
            columns.iter().map(|(name, value)| format!("{:>1$}", value.to_string(), width(name))).collect();
        writeln!(text, "{krate:<24}{values}").unwrap();
    }
    text
}

fn object(found: &Findings) -> Value {
    let rows: Map<String, Value> = rows(found).into_iter().map(|row| (row.key.to_owned(), row.value)).collect();
    let of = |krate: &String, counts| {
        let columns = columns(found, krate, counts).into_iter();
        Value::Object(columns.map(|(name, value)| (name.to_owned(), value)).collect())
    };
    let crates: Map<String, Value> =
        found.sizes.crates.iter().map(|(krate, counts)| (krate.clone(), of(krate, counts))).collect();
    json!({ "house": rows, "crates": crates })
}

#[test]
fn the_table_of_the_house() {
    let found = crate::findings();
    println!("\n{}\n{:#}", text(found), object(found));
}

#[test]
fn the_table_says_which_laws_are_broken() {
    let lib = format!("//! {}\npub fn f() {{}}\n", "told ".repeat(25));
    let found = Findings::of(&crate::house::House::trial(&[("src/lib.rs", &lib)]));
    let text = text(&found);
    let line = |key: &str| text.lines().find(|line| line.starts_with(key)).unwrap().split_whitespace().last().unwrap();
    assert_eq!(line("phrases of the old wording"), "BROKEN");
    assert_eq!(line("public items documented"), "BROKEN");
    assert_eq!(line("comments over 100 columns"), "holds");
    assert!(text.lines().last().unwrap().starts_with("shared/trial "), "{text}");
    assert_eq!(object(&found)["house"]["phrases of the old wording"], 25);
    assert_eq!(object(&found)["crates"]["shared/trial"]["public"], 1);
}
