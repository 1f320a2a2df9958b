//! Trajectories of markers and bodies by tabs: exports of Qualisys, with keys above and perhaps no
//! names, and `.trc` files, with a name above three axes.

use super::dialect::Dialect;
use super::interval::{Interval, stated_interval};
use super::seen::Layout;
use super::signs::Signs;

/// Lines above the rows.
const ABOVE_MAX: usize = 40;
/// Columns of a body: position, three angles, residual, a matrix of rotation.
const OF_BODY: usize = 16;

type Line = (u64, Vec<String>);

/// Names and units by column, and the line they are of.
struct Named {
    line: u64,
    names: Vec<String>,
    units: Vec<String>,
    interval: Option<Interval>,
}

/// The layout of such a file; `None` of every other.
pub(super) fn trajectories(ahead: &[(u64, String)]) -> Option<Layout> {
    let signs = Signs { decimal_comma: false, grouped: false };
    let dialect = Dialect { separator: b'\t', signs, labelled: false };
    let lines: Vec<Line> = ahead.iter().map(|(line, text)| (*line, dialect.split_quoted(text))).collect();
    let is_number = |cell: &String| cell.parse::<f64>().is_ok();
    let is_row = |cells: &[String]| {
        cells.len() > 2 && cells.iter().all(|cell| cell.is_empty() || is_number(cell)) && is_number(&cells[0])
    };
    let is_first = |at: &usize| is_row(&lines[*at].1) && lines.get(at + 1).is_none_or(|(_, cells)| is_row(cells));
    let first = (0..lines.len().min(ABOVE_MAX)).find(is_first)?;
    let (above, rows) = lines.split_at(first);
    let width = rows[0].1.iter().rposition(|cell| !cell.is_empty())? + 1;
    let named = of_qualisys(above, dialect, width).or_else(|| of_trc(above, width))?;
    Some(Layout {
        dialect,
        header: named.names,
        units: named.units,
        header_line: named.line,
        first_line: rows[0].0,
        rows: rows.iter().map(|(_, cells)| cells.clone()).filter(|cells| is_row(cells)).collect(),
        remarks: 0,
        interval: named.interval,
        notes: vec!["names and units of the columns are made of the lines above the rows".into()],
    })
}

/// The cells behind a key.
fn behind<'a>(above: &'a [Line], key: &str) -> Option<(u64, Vec<&'a str>)> {
    let (line, cells) = above.iter().find(|(_, cells)| cells[0] == key)?;
    Some((*line, cells[1..].iter().map(String::as_str).filter(|cell| !cell.is_empty()).collect()))
}

/// Positions in mm and angles in degrees, as the program always writes them.
fn of_qualisys(above: &[Line], dialect: Dialect, width: usize) -> Option<Named> {
    behind(above, "NO_OF_FRAMES")?;
    let bodies = behind(above, "BODY_NAMES");
    let (of_names, parts): (_, &[&str]) = match &bodies {
        Some(bodies) => (bodies.clone(), &["x", "y", "z", "roll", "pitch", "yaw", "residual"]),
        None => (behind(above, "MARKER_NAMES")?, &["x", "y", "z"]),
    };
    let each = if bodies.is_some() { OF_BODY } else { parts.len() };
    let counters = width.checked_sub(each * of_names.1.len()).filter(|counters| *counters <= 2)?;
    // the names of the first two columns stand above them, if they are there
    let titles = above.last().map(|(_, cells)| cells.as_slice()).unwrap_or_default();
    let mut names: Vec<String> = titles.iter().take(counters).cloned().collect();
    let mut units: Vec<String> =
        names.iter().map(|name| if name == "Time" { "s".into() } else { String::new() }).collect();
    let has_times = units.iter().any(|unit| unit == "s");
    names.iter_mut().filter(|name| has_times && *name != "Time").for_each(String::clear);
    for body in &of_names.1 {
        for at in 0..each {
            names.push(parts.get(at).map_or_else(
                || format!("{body}.rotation[{}]", at.saturating_sub(parts.len())),
                |part| format!("{body}.{part}"),
            ));
            units.push(match at {
                3..6 => "deg".into(),
                _ if at < parts.len() => "mm".into(),
                _ => "-".into(),
            });
        }
    }
    let (line, rate) = behind(above, "FREQUENCY")?;
    let interval =
        stated_interval(&[(line, format!("Sample rate: {}", rate.first()?))], dialect).filter(|_| !has_times);
    Some(Named { line: of_names.0, names, units, interval })
}

/// A name above each three axes; the unit of all stands in a line of keys and one of values.
fn of_trc(above: &[Line], width: usize) -> Option<Named> {
    above.first().filter(|(_, cells)| cells[0] == "PathFileType")?;
    let at = above.iter().position(|(_, cells)| cells[0] == "Frame#")?;
    let ((line, markers), (_, axes)) = (&above[at], above.get(at + 1)?);
    let said = |key: &str| {
        let (keys, values) = above[..at]
            .windows(2)
            .map(|pair| (&pair[0].1, &pair[1].1))
            .find(|(keys, _)| keys.iter().any(|of| of == key))?;
        values.get(keys.iter().position(|of| of == key)?).cloned()
    };
    let of_lengths = said("Units").unwrap_or_default();
    let name = |column: usize| {
        let marker = markers.iter().take(column + 1).rfind(|cell| !cell.is_empty()).cloned().unwrap_or_default();
        let axis = axes.get(column).map(|axis| axis.trim_end_matches(|c: char| c.is_ascii_digit()).to_lowercase());
        axis.filter(|axis| !axis.is_empty()).map_or(marker.clone(), |axis| format!("{marker}.{axis}"))
    };
    let names = (0..width).map(|column| match column {
        0 => String::new(),
        1 => "Time".into(),
        _ => name(column),
    });
    let units = (0..width).map(|column| match column {
        0 => String::new(),
        1 => "s".into(),
        _ => of_lengths.clone(),
    });
    Some(Named { line: *line, names: names.collect(), units: units.collect(), interval: None })
}
