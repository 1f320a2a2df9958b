//! Nodes (datasets 15 and 2411) and trace lines (dataset 82) of a universal file.

use crate::error::RecordingError;
use crate::uff_lines::{Text, cut, number, numbers, shortened};
use crate::uff_model::{Node, TraceLine};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

const EXPORT: &str = "export the geometry again";
/// Difference of two coordinates that were written with six digits.
const ROUNDED: f64 = 2e-5;

/// Nodes by the order of the file, each label once.
#[derive(Default)]
pub(crate) struct Nodes {
    pub all: Vec<Node>,
    by_label: BTreeMap<i64, usize>,
    /// Nodes whose coordinates are said to be in another system than the global one.
    pub in_own_systems: usize,
}

impl Nodes {
    /// A node that stands twice is taken once; at another place it is a contradiction.
    fn push(&mut self, text: &Text<'_>, system: i64, node: Node) -> Result<(), RecordingError> {
        let place = match self.by_label.entry(node.label) {
            Entry::Vacant(free) => {
                free.insert(self.all.len());
                self.all.push(node);
                self.in_own_systems += usize::from(system > 1);
                return Ok(());
            }
            Entry::Occupied(taken) => &self.all[*taken.get()],
        };
        let size = place.xyz_m.iter().chain(&node.xyz_m).fold(0.0_f64, |size, x| size.max(x.abs()));
        if place.xyz_m.iter().zip(&node.xyz_m).all(|(a, b)| (a - b).abs() <= ROUNDED * size) {
            return Ok(());
        }
        let found = format!("node {} is at {:?} and before at {:?}", node.label, node.xyz_m, place.xyz_m);
        Err(text.error(found, "give every node its own label, one structure a file"))
    }
}

/// Dataset 15: label, two coordinate systems, colour and three coordinates in a line.
pub(crate) fn read_nodes(text: &mut Text<'_>, nodes: &mut Nodes) -> Result<(), RecordingError> {
    while let Some(line) = text.body_line()? {
        if line.trim().is_empty() {
            continue;
        }
        let [label, system] = head(text, &line)?;
        let columns = [(40, 53), (53, 66), (66, 79)].map(|(from, to)| number(cut(&line, from, to)));
        let xyz = columns.into_iter().collect::<Option<Vec<f64>>>().or_else(|| {
            let words = line.split_whitespace().skip(4);
            words.map(number).collect()
        });
        nodes.push(text, system, Node { label, xyz_m: place(text, &line, xyz)? })?;
    }
    Ok(())
}

/// Dataset 2411: label, two coordinate systems and colour in a line, three coordinates in the next.
pub(crate) fn read_nodes_of_two_lines(text: &mut Text<'_>, nodes: &mut Nodes) -> Result<(), RecordingError> {
    while let Some(line) = text.body_line()? {
        if line.trim().is_empty() {
            continue;
        }
        let [label, system] = head(text, &line)?;
        let Some(line) = text.body_line()? else {
            return Err(text.error(format!("node {label} has no coordinates"), EXPORT));
        };
        nodes.push(text, system, Node { label, xyz_m: place(text, &line, numbers(&line, &[25]))? })?;
    }
    Ok(())
}

/// Label and coordinate system of a node.
fn head(text: &Text<'_>, line: &str) -> Result<[i64; 2], RecordingError> {
    let columns = integers(line.get(..20).unwrap_or_default()).filter(|columns| columns.len() == 2);
    let words = || {
        let mut words = line.split_whitespace().map(|word| word.parse::<i64>().ok());
        Some([words.next()??, words.next()??])
    };
    let columns = columns.map(|columns| [columns[0], columns[1]]);
    columns.or_else(words).ok_or_else(|| {
        text.error(format!("`{}` does not begin with the label of a node", shortened(line.trim())), EXPORT)
    })
}

fn place(text: &Text<'_>, line: &str, xyz: Option<Vec<f64>>) -> Result<[f64; 3], RecordingError> {
    let xyz = xyz.and_then(|xyz| <[f64; 3]>::try_from(xyz).ok()).filter(|xyz| xyz.iter().all(|x| x.is_finite()));
    xyz.ok_or_else(|| text.error(format!("`{}` does not hold three coordinates", shortened(line.trim())), EXPORT))
}

/// Dataset 82: number and count of entries, a name, labels of nodes; 0 lifts the pen.
pub(crate) fn read_lines_of_trace(text: &mut Text<'_>) -> Result<TraceLine, RecordingError> {
    let head = text.needed_line()?;
    let fields = integers(&head).unwrap_or_default();
    let (Some(&number), Some(&count)) = (fields.first(), fields.get(1)) else {
        let found = format!("`{}` does not hold number and length of a trace line", shortened(head.trim()));
        return Err(text.error(found, EXPORT));
    };
    let name = text.needed_line()?.trim().to_string();
    let mut entries = Vec::new();
    while let Some(line) = text.body_line()? {
        let Some(labels) = integers(&line) else {
            return Err(text.error(format!("`{}` is no line of node labels", shortened(line.trim())), EXPORT));
        };
        entries.extend(labels);
    }
    let announced = usize::try_from(count).unwrap_or(usize::MAX);
    if entries.len() < announced || entries.iter().skip(announced).any(|label| *label != 0) {
        let found = format!("{} entries of a trace line, {count} are announced", entries.len());
        return Err(text.error(found, EXPORT));
    }
    let strokes = entries.split(|label| *label == 0).filter(|stroke| stroke.len() > 1).map(<[i64]>::to_vec);
    Ok(TraceLine { number, name, strokes: strokes.collect() })
}

/// Integers in columns of ten, or as words.
pub(crate) fn integers(line: &str) -> Option<Vec<i64>> {
    let line = line.trim_end();
    let columns = (0..line.len().div_ceil(10)).map(|k| cut(line, 10 * k, 10 * k + 10).parse().ok());
    let words = || line.split_whitespace().map(|word| word.parse().ok()).collect();
    // A column holds one number; digits that run across its edge are words.
    let cut_apart = (1..line.len().div_ceil(10)).any(|k| {
        let digit = |at: usize| line.as_bytes().get(at).is_some_and(u8::is_ascii_digit);
        digit(10 * k - 1) && digit(10 * k) && line.get(10 * k - 10..10 * k).is_some_and(|column| column.contains(' '))
    });
    let in_columns: Option<Vec<i64>> = if cut_apart { None } else { columns.collect() };
    in_columns.or_else(words)
}
