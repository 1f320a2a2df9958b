//! The structure in a universal file: header, nodes, trace lines and mode shapes.
//!
//! Datasets 151 (header), 15 and 2411 (nodes), 82 (trace lines), 55 (data at nodes, of which normal
//! and complex modes are read) and 164 (units). Functions are read by [`crate::read`].
//!
//! Source: University of Cincinnati SDRL, Universal File Datasets 15, 55, 82, 151, 164, 2411.

use crate::error::RecordingError;
use crate::file_name;
use crate::uff::{bytes_of, listed, units};
use crate::uff_dataset::read_function;
use crate::uff_lines::{Text, cut};
use crate::uff_nodes::{Nodes, read_lines_of_trace, read_nodes, read_nodes_of_two_lines};
use crate::uff_shapes::{Shape, read_shape};
use std::collections::BTreeMap;
use std::path::Path;

/// Geometry and modes of one structure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UffModel {
    /// Dataset 151, the first of the file.
    pub header: Option<UffHeader>,
    /// In the order of the file, each label once.
    pub nodes: Vec<Node>,
    pub lines: Vec<TraceLine>,
    /// In the order of the file.
    pub modes: Vec<UffMode>,
    /// What was left out or taken for granted, and why.
    pub notes: Vec<String>,
}

/// What a file says of itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UffHeader {
    pub model_name: String,
    pub description: String,
    /// Program that made the model.
    pub program: String,
    /// Date and time of the model, as the file words them.
    pub date: String,
}

/// A point of the structure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    pub label: i64,
    /// Place in the coordinate system of the file.
    pub xyz_m: [f64; 3],
}

/// Lines that draw a part of the structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceLine {
    pub number: i64,
    pub name: String,
    /// Labels of the nodes of each stroke of the pen, two at least.
    pub strokes: Vec<Vec<i64>>,
}

/// A mode of the structure.
#[derive(Clone, Debug, PartialEq)]
pub struct UffMode {
    /// Undamped natural frequency.
    pub frequency_hz: f64,
    /// Viscous; of hysteretic damping half the loss factor. Zero where the file gives none.
    pub damping_ratio: f64,
    /// In the order of the file, in its scale.
    pub shape: Vec<NodeShape>,
}

/// A mode shape at one node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeShape {
    /// Label of the node.
    pub node: i64,
    /// Real and imaginary parts: x, y, z, and where there are six rotations about x, y, z.
    pub components: Vec<[f64; 2]>,
}

/// Reads the structure of a universal file; one without geometry and shapes gives an empty model.
///
/// ```
/// let file = std::env::temp_dir().join(format!("obsid-model-{}.unv", std::process::id()));
/// std::fs::write(&file, "    -1\n    15\n 7 0 0 0 0.5 0.0 -1.0\n    -1\n").unwrap();
/// let model = recording::read_model(&file)?;
/// assert_eq!((model.nodes[0].label, model.nodes[0].xyz_m), (7, [0.5, 0.0, -1.0]));
/// # std::fs::remove_file(&file).unwrap();
/// # Ok::<(), recording::RecordingError>(())
/// ```
///
/// # Errors
/// Whatever makes a number of the file uncertain; the device's.
pub fn read_model(path: &Path) -> Result<UffModel, RecordingError> {
    let (file, bytes) = (file_name(path), bytes_of(path)?);
    if !bytes.trim_ascii_start().starts_with(b"-1") {
        return Err(RecordingError::BadUff {
            file,
            line: 1,
            found: "no dataset opens with `-1`: this is no universal file".into(),
            cure: "export the geometry and the shapes as a universal file (.unv, .uff)".into(),
        });
    }
    parse(Text::new(&file, &bytes))
}

/// What is collected while the file is read.
#[derive(Default)]
struct Parts {
    model: UffModel,
    nodes: Nodes,
    /// Units of length in the file over the metre.
    length: Option<f64>,
    /// Datasets 55 that hold no mode, by what they are.
    no_modes: BTreeMap<String, usize>,
    others: BTreeMap<String, usize>,
}

fn parse(mut text: Text<'_>) -> Result<UffModel, RecordingError> {
    let mut parts = Parts::default();
    while let Some(line) = text.next_line() {
        if line.trim().is_empty() {
            continue;
        }
        let (id, number) = text.open_dataset(&line)?;
        parts.dataset(&mut text, &id, &number)?;
    }
    let model = parts.finish();
    match model.nodes.iter().find(|node| node.xyz_m.iter().any(|x| !x.is_finite())) {
        Some(node) => {
            let found = format!("node {} is at {:?} m in the unit of dataset 164", node.label, node.xyz_m);
            Err(text.error(found, "export the units again (dataset 164)"))
        }
        None => Ok(model),
    }
}

impl Parts {
    fn dataset(&mut self, text: &mut Text<'_>, id: &str, number: &str) -> Result<(), RecordingError> {
        match id {
            "15" => read_nodes(text, &mut self.nodes),
            "2411" => read_nodes_of_two_lines(text, &mut self.nodes),
            "82" => {
                self.model.lines.push(read_lines_of_trace(text)?);
                Ok(())
            }
            "55" => {
                match read_shape(text)? {
                    Shape::Mode(mode) => self.model.modes.push(mode),
                    Shape::NoMode(what) => *self.no_modes.entry(what).or_default() += 1,
                }
                Ok(())
            }
            "151" => {
                let header = read_header(text)?;
                self.model.header.get_or_insert(header);
                Ok(())
            }
            "58b" => {
                read_function(text, number)?; // its bytes may look like lines
                text.close_dataset()
            }
            "164" => {
                self.length = units(&text.skip_dataset()?).map(|(length, _)| length).or(self.length);
                Ok(())
            }
            _ => {
                text.skip_dataset()?;
                if id != "58" {
                    *self.others.entry(id.to_string()).or_default() += 1;
                }
                Ok(())
            }
        }
    }

    /// Lengths in metres, and the notes.
    fn finish(self) -> UffModel {
        let Parts { mut model, nodes, length, no_modes, others } = self;
        if nodes.in_own_systems > 0 {
            let count = nodes.in_own_systems;
            model.notes.push(format!("{count} nodes name a coordinate system of their own: taken as the global one"));
        }
        model.nodes = nodes.all;
        if let Some(length) = length {
            model.nodes.iter_mut().for_each(|node| node.xyz_m = node.xyz_m.map(|x| x / length));
        } else if !model.nodes.is_empty() {
            model.notes.push("no units (dataset 164): coordinates are taken as metres".into());
        }
        if !no_modes.is_empty() {
            model.notes.push(format!("datasets 55 that are no modes are left out: {}", listed(&no_modes)));
        }
        if !others.is_empty() {
            model.notes.push(format!("datasets that are no geometry and no shape are left out: {}", listed(&others)));
        }
        model
    }
}

fn read_header(text: &mut Text<'_>) -> Result<UffHeader, RecordingError> {
    let mut header = UffHeader::default();
    let mut count = 0_usize;
    while let Some(line) = text.body_line()? {
        let words = line.trim().to_string();
        match count {
            0 => header.model_name = words,
            1 => header.description = words,
            2 => header.program = words,
            3 => header.date = format!("{} {}", cut(&line, 0, 10), cut(&line, 10, 20)).trim().to_string(),
            _ => {}
        }
        count = count.saturating_add(1);
    }
    Ok(header)
}
