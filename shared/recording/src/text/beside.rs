//! Rows with a preamble beside them: oscilloscopes write keys and values into the first columns, an
//! empty column, and behind it times and samples from the first line on.

use super::dialect::{Dialect, filled};
use super::seen::Layout;
use super::signs::Signs;

/// The layout of such a file; `None` of every other.
pub(super) fn beside(ahead: &[(u64, String)]) -> Option<Layout> {
    let dialect = Dialect { separator: b',', signs: Signs { decimal_comma: false, grouped: false }, labelled: false };
    let rows: Vec<Vec<String>> = ahead.iter().map(|(_, text)| dialect.split_quoted(text)).collect();
    let first = rows.first().filter(|cells| cells.len() > 4 && cells[0].contains(char::is_alphabetic))?;
    let is_number = |cell: &String| cell.parse::<f64>().is_ok();
    let empty = (2..first.len()).find(|at| rows.iter().all(|cells| cells.get(*at).is_some_and(String::is_empty)))?;
    let are_samples =
        |cells: &Vec<String>| filled(cells) == empty + 3 && cells[empty + 1..empty + 3].iter().all(is_number);
    if rows.len() < 2 || !rows.iter().all(are_samples) {
        return None;
    }
    let said = |key: &str| {
        let row = rows.iter().find(|cells| cells[0].eq_ignore_ascii_case(key) && !cells[1].is_empty());
        row.map(|cells| cells[1].clone())
    };
    let name = said("Source").unwrap_or_else(|| "value".into());
    let unit = said("Vertical Units").map_or(String::new(), |unit| format!(" [{unit}]"));
    let of_time = said("Horizontal Units").map_or(String::new(), |unit| format!(" [{unit}]"));
    let mut header = vec![String::new(); empty + 1];
    header.extend([format!("time{of_time}"), format!("{name}{unit}")]);
    let line = ahead[0].0;
    let notes = vec!["a preamble stands beside the rows: the last two columns are the times and the samples".into()];
    let units = Vec::new();
    Some(Layout {
        dialect,
        header,
        units,
        header_line: line,
        first_line: line,
        rows,
        remarks: 0,
        interval: None,
        notes,
    })
}
