//! Comments that are wider than a page.

use crate::house::House;
use crate::source::LineKind;

/// Code may be 120 columns wide, what is read as prose no more than this.
const COLUMNS_MAX: usize = 100;
/// A table or an address now and then.
pub const COMMENTS_MAX: usize = 50;

/// `path:line, n columns` of every line outside tests that is nothing but a comment.
pub fn measure(house: &House) -> Vec<String> {
    let mut found = Vec::new();
    for (_, source) in house.own_sources() {
        let lines = [LineKind::Doc, LineKind::Comment].into_iter().flat_map(|kind| source.lines_of(kind));
        let mut wide: Vec<(usize, usize)> = lines.map(|(line, text)| (line, text.chars().count())).collect();
        wide.retain(|(_, columns)| *columns > COLUMNS_MAX);
        wide.sort_unstable();
        found.extend(wide.iter().map(|(line, columns)| format!("{}:{line}, {columns} columns", source.path)));
    }
    found
}

#[test]
fn fewer_than_fifty_comments_are_wider_than_a_hundred_columns() {
    let found = &crate::findings().wide_comments;
    assert!(
        found.len() < COMMENTS_MAX,
        "{}\n{} lines. Cure: break them at 100 columns.",
        found.join("\n"),
        found.len()
    );
}

#[test]
fn a_wide_comment_is_seen_and_wide_code_is_not() {
    let wide = "x".repeat(97);
    let text = format!(
        "//! {wide}\n/// {}\nfn f() {{ {wide}() }}\n    // {wide}\n#[cfg(test)]\nmod t {{\n // {wide}{wide}\n}}\n",
        "µ".repeat(96)
    );
    let found = measure(&House::trial(&[("src/lib.rs", &text)]));
    assert_eq!(found, ["shared/trial/src/lib.rs:1, 101 columns", "shared/trial/src/lib.rs:4, 104 columns"]);
}
