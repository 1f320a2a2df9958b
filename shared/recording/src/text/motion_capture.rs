//! Exports of motion capture: names in several rows, one above the other, and a column of frames.

use super::dialect::Dialect;
use super::interval::{Interval, stated_interval};
use super::seen::Layout;
use super::signs::Signs;

/// Words of OptiTrack for what a column is of.
const TYPES: &[&str] = &["Rigid Body", "Rigid Body Marker", "Marker", "Bone", "Bone Marker", "Labeled Marker"];
/// Rows looked at below those of the names.
const NAMED_ROWS_MAX: usize = 12;

/// The layout of an export of Vicon or OptiTrack; `None` of every other file.
///
/// OptiTrack has rows of types, names and quantities above the axes, and times. Vicon has a row of
/// subjects above the axes, one of units below, the rate in a line of its own and no times; behind
/// the first kind of data another may follow.
pub(super) fn motion_capture(ahead: &[(u64, String)]) -> Option<Layout> {
    let dialect = Dialect { separator: b',', signs: Signs { decimal_comma: false, grouped: false }, labelled: false };
    let lines: Vec<(u64, Vec<String>)> = ahead.iter().map(|(line, text)| (*line, dialect.split_quoted(text))).collect();
    let axes = lines.iter().take(NAMED_ROWS_MAX).position(|(_, cells)| {
        cells.len() > 2 && cells[0] == "Frame" && (cells[1].starts_with("Time") || cells[1] == "Sub Frame")
    })?;
    let is_vicon = lines[axes].1[1] == "Sub Frame";
    let above: Vec<&[String]> = lines[1..axes].iter().map(|(_, cells)| cells.as_slice()).collect();
    let mut names = joined(&above, &lines[axes].1, is_vicon)?;
    let units = if is_vicon { lines.get(axes + 1)?.1.clone() } else { of_optitrack(&lines[0].1, &names) };
    let interval = if is_vicon { of_rate(&lines, axes)? } else { None };
    // where there are times, frames are no channel
    names[usize::from(is_vicon)].clear();
    let is_number = |cell: &String| cell.parse::<f64>().is_ok();
    let is_row = |cells: &[String]| cells.len() == names.len() && cells.first().is_some_and(is_number);
    let first_line = lines[axes..].iter().find(|(_, cells)| is_row(cells))?.0;
    let rows = lines[axes..].iter().map(|(_, cells)| cells.clone()).filter(|cells| is_row(cells)).collect();
    let notes = vec!["the names are joined of several rows above each other".into()];
    let header_line = lines[axes].0;
    Some(Layout { dialect, header: names, units, header_line, first_line, rows, remarks: 0, interval, notes })
}

/// The names of the columns: the texts above an axis, joined by points. A subject stands above
/// the first of its columns alone in an export of Vicon.
fn joined(above: &[&[String]], axes: &[String], is_vicon: bool) -> Option<Vec<String>> {
    let rows: Vec<&&[String]> = above.iter().filter(|cells| cells.len() + 1 >= axes.len() && cells.len() > 2).collect();
    let is_id = |cell: &str| cell.len() >= 16 && cell.bytes().all(|byte| byte.is_ascii_hexdigit());
    let is_name = |cell: &String| !cell.is_empty() && !TYPES.contains(&cell.as_str()) && !is_id(cell);
    let is_telling = |cells: &&&[String]| cells[1] != "ID" && cells[2..].iter().any(is_name);
    let rows: Vec<&[String]> = rows.into_iter().filter(is_telling).copied().collect();
    if rows.is_empty() {
        return None;
    }
    let at = |cells: &[String], column: usize| -> String {
        let from = if is_vicon {
            (2..=column).rev().find(|at| cells.get(*at).is_some_and(|cell| !cell.is_empty()))
        } else {
            Some(column)
        };
        from.and_then(|at| cells.get(at)).cloned().unwrap_or_default()
    };
    let name = |column: usize| {
        let parts = rows.iter().map(|cells| at(cells, column)).chain([axes[column].clone()]);
        parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(".")
    };
    Some((0..axes.len()).map(|column| if column < 2 { axes[column].clone() } else { name(column) }).collect())
}

/// Units of an export of OptiTrack, which its first line states: lengths, and what rotations are.
fn of_optitrack(first: &[String], names: &[String]) -> Vec<String> {
    let said = |key: &str| first.iter().position(|cell| cell == key).and_then(|at| first.get(at + 1)).cloned();
    let length = said("Length Units").map(|unit| unit.to_lowercase()).unwrap_or_default();
    let is_quaternion = said("Rotation Type").is_some_and(|kind| kind.eq_ignore_ascii_case("Quaternion"));
    let of = |name: &String| {
        if name.contains(".Position") {
            length.clone()
        } else if name.contains(".Rotation") {
            if is_quaternion { "-".into() } else { "deg".into() }
        } else {
            String::new()
        }
    };
    names.iter().map(of).collect()
}

/// The rate that stands alone in a line above the names.
fn of_rate(lines: &[(u64, Vec<String>)], axes: usize) -> Option<Option<Interval>> {
    let alone = |cells: &[String]| cells.iter().skip(1).all(String::is_empty) && cells[0].parse::<f64>().is_ok();
    let (line, cells) = lines[..axes].iter().find(|(_, cells)| alone(cells))?;
    let dialect = Dialect { separator: b',', signs: Signs { decimal_comma: false, grouped: false }, labelled: false };
    Some(stated_interval(&[(*line, format!("Sample rate: {}", cells[0]))], dialect))
}
