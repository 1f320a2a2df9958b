//! Groups of channels side by side, as TwinCAT Scope exports them: lines of properties above, each
//! led by its key in every group, and the times of the group below its keys.

use super::dialect::Dialect;
use super::seen::Layout;
use super::signs::Signs;

/// Lines in which the properties stand.
const PROPERTIES_MAX: usize = 40;
/// The property that states the times to be in ms.
const SAMPLE_TIME: &str = "SampleTime[ms]";

/// The layout of such a file; `None` of every other.
pub(super) fn groups(ahead: &[(u64, String)]) -> Option<Layout> {
    [b'\t', b';', b',', b'|'].into_iter().find_map(|separator| divided(ahead, separator))
}

fn divided(ahead: &[(u64, String)], separator: u8) -> Option<Layout> {
    let point = Signs { decimal_comma: false, grouped: false };
    let dialect = Dialect { separator, signs: point, labelled: false };
    let lines: Vec<(u64, Vec<String>)> = ahead.iter().map(|(line, text)| (*line, dialect.split_quoted(text))).collect();
    let head = &lines[..lines.len().min(PROPERTIES_MAX)];
    let times = head.iter().position(|(_, cells)| cells[0] == SAMPLE_TIME)?;
    let (header_line, names) = head[..times].iter().rfind(|(_, cells)| cells[0] == "Name" && cells.len() > 1)?;
    let keys: Vec<usize> =
        (0..names.len()).filter(|at| head[times].1.get(*at).is_some_and(|of| of == SAMPLE_TIME)).collect();
    let comma = |text: &str| separator != b',' && text.contains(',');
    let rows = &lines[times + 1..];
    let is_number = |cell: &String| cell.replace(',', ".").parse::<f64>().is_ok();
    let is_row =
        |cells: &[String]| is_number(&cells[0]) && cells[1..].iter().all(|cell| cell.is_empty() || is_number(cell));
    let first = rows.iter().position(|(_, cells)| is_row(cells))?;
    let rows: Vec<Vec<String>> =
        rows[first..].iter().map(|(_, cells)| cells.clone()).filter(|cells| is_row(cells)).collect();
    let decimal_comma = rows.iter().flatten().any(|cell| comma(cell));
    let of_property = |key: &str| head.iter().find(|(_, cells)| cells[0] == key).map(|(_, cells)| cells.as_slice());
    let stated = of_property("Unit").unwrap_or_default();
    let header = (0..names.len()).map(|at| match keys.iter().position(|key| *key == at) {
        Some(0) => "time".into(),
        Some(group) => format!("time {}", group + 1),
        None => names[at].clone(),
    });
    let unit = |at: usize| match stated.get(at) {
        _ if keys.contains(&at) => "ms".into(),
        // `Nm (Torque)`, `(None)`
        Some(text) => text.split('(').next().unwrap_or_default().trim().to_owned(),
        None => String::new(),
    };
    Some(Layout {
        dialect: Dialect { signs: Signs { decimal_comma, grouped: false }, ..dialect },
        header: header.collect(),
        units: (0..names.len()).map(unit).collect(),
        header_line: *header_line,
        first_line: lines[times + 1 + first].0,
        rows,
        remarks: 0,
        interval: None,
        notes: vec!["properties of the channels stand above the rows, times in ms below their keys".into()],
    })
}
