//! Where the channels measure: nodes, lines between them, and node and direction of each channel.
//!
//! From a universal file (nodes 15 or 2411, lines 82; channels by their names), or from a small
//! TOML file.

use super::degree_of_freedom::{Freedom, of_response};
use crate::Failure;
use crate::plants::utf8_text;
use crate::recordings::nearest;
use recording::UffModel;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// A file that says where the channels are.
const EXAMPLE: &str = "nodes.root = [0, 0, 0]
nodes.tip = [0, 0, 2.5]
lines = [[\"root\", \"tip\"]]
sensors.acc_3 = { node = \"tip\", direction = \"-x\" }";

/// A sensor on the structure.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sensor {
    /// Of the channels of the answer.
    pub channel: usize,
    pub node: usize,
    /// Unit vector.
    pub direction: [f64; 3],
}

/// Nodes, lines and sensors.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Geometry {
    /// Label for a universal file.
    pub labels: Vec<i64>,
    pub nodes_m: Vec<[f64; 3]>,
    /// Indices of nodes, a stroke each.
    pub strokes: Vec<Vec<usize>>,
    pub sensors: Vec<Sensor>,
    pub notes: Vec<String>,
}

/// The geometry of `file`, or where none is stated that of a universal file among `files`.
///
/// # Errors
/// [`Failure::Input`] for a file that cannot be read, and one in which no channel has a place.
pub(super) fn read(
    file: Option<&Path>,
    files: &[std::path::PathBuf],
    channels: &[String],
) -> Result<Option<Geometry>, Failure> {
    let Some(file) = file else {
        let models = files.iter().filter(|file| is_universal(file)).filter_map(|file| recording::read_model(file).ok());
        let found = models.map(|model| of_model(&model, channels)).find(|found| !found.sensors.is_empty());
        return Ok(found);
    };
    let geometry = if is_universal(file) {
        of_model(&recording::read_model(file).map_err(Failure::input)?, channels)
    } else {
        of_text(file, channels)?
    };
    if geometry.sensors.is_empty() {
        return Err(Failure::Input(miette::miette!(
            help = format!("the channels are {}", channels.join(", ")),
            "{} says of no channel at which node it is",
            file.display()
        )));
    }
    Ok(Some(geometry))
}

/// The first line that is not blank opens a dataset.
fn is_universal(file: &Path) -> bool {
    use std::io::Read;
    let mut head = Vec::new();
    let read = std::fs::File::open(file).and_then(|file| file.take(512).read_to_end(&mut head));
    let head = head.trim_ascii_start();
    read.is_ok() && [&b"-1\n"[..], b"-1\r\n"].iter().any(|first| head.starts_with(first))
}

fn of_model(model: &UffModel, channels: &[String]) -> Geometry {
    let place = |label: i64| model.nodes.iter().position(|node| node.label == label);
    let strokes = model.lines.iter().flat_map(|line| &line.strokes);
    let sensor = |(channel, name): (usize, &String)| {
        let freedom = of_response(name)?;
        Some(Sensor { channel, node: place(freedom.node)?, direction: freedom.direction() })
    };
    let mut geometry = Geometry {
        labels: model.nodes.iter().map(|node| node.label).collect(),
        nodes_m: model.nodes.iter().map(|node| node.xyz_m).collect(),
        strokes: strokes.map(|stroke| stroke.iter().filter_map(|label| place(*label)).collect()).collect(),
        sensors: channels.iter().enumerate().filter_map(sensor).collect(),
        notes: model.notes.clone(),
    };
    geometry.tell_of_the_rest(channels);
    geometry
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GeometryFile {
    nodes: BTreeMap<String, [f64; 3]>,
    #[serde(default)]
    lines: Vec<Vec<Spanned<String>>>,
    sensors: BTreeMap<String, SensorEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorEntry {
    node: Spanned<String>,
    direction: Spanned<Direction>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Direction {
    Axis(String),
    Vector([f64; 3]),
}

impl Direction {
    fn unit(&self) -> Option<[f64; 3]> {
        let vector = match self {
            Direction::Vector(vector) => *vector,
            Direction::Axis(name) => {
                let (sign, axis) = name.strip_prefix('-').map_or((1.0, name.as_str()), |axis| (-1.0, axis));
                let axis = ["x", "y", "z"].iter().position(|known| *known == axis.trim_start_matches('+'))?;
                core::array::from_fn(|k| if k == axis { sign } else { 0.0 })
            }
        };
        let size = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        (size > 0.0 && size.is_finite()).then(|| vector.map(|x| x / size))
    }
}

fn of_text(file: &Path, channels: &[String]) -> Result<Geometry, Failure> {
    let name = file.display().to_string();
    let text = utf8_text(file).map_err(|(message, cure)| {
        Failure::Input(miette::miette!(help = cure.unwrap_or_else(|| format!("for example\n{EXAMPLE}")), "{message}"))
    })?;
    let wrong = |at: usize, what: String, cure: String| {
        let line = 1 + text.as_bytes()[..at.min(text.len())].iter().filter(|byte| **byte == b'\n').count();
        Failure::Input(miette::miette!(help = cure, "{name}: line {line}: {what}"))
    };
    let parsed: GeometryFile = toml::from_str(&text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        wrong(at, error.message().replace('\n', ", "), format!("a geometry is, for example\n{EXAMPLE}"))
    })?;
    let names: Vec<&String> = parsed.nodes.keys().collect();
    if let Some((node, _)) = parsed.nodes.iter().find(|(_, xyz)| xyz.iter().any(|x| !x.is_finite())) {
        return Err(wrong(0, format!("node '{node}' is at no finite place"), "give three numbers in metres".into()));
    }
    let place = |node: &Spanned<String>| {
        let known = || names.iter().map(|name| name.as_str());
        names.iter().position(|name| *name == node.get_ref()).ok_or_else(|| {
            let near =
                nearest(node.get_ref(), known()).map_or(String::new(), |near| format!("did you mean '{near}'? "));
            let cure = format!("{near}the nodes are {}", known().collect::<Vec<_>>().join(", "));
            wrong(node.span().start, format!("no node '{}'", node.get_ref()), cure)
        })
    };
    let mut geometry = Geometry {
        labels: (1..).take(names.len()).collect(),
        nodes_m: parsed.nodes.values().copied().collect(),
        ..Geometry::default()
    };
    for stroke in &parsed.lines {
        geometry.strokes.push(stroke.iter().map(place).collect::<Result<_, _>>()?);
    }
    for (channel, entry) in &parsed.sensors {
        let node = place(&entry.node)?;
        let direction = entry.direction.get_ref().unit().ok_or_else(|| {
            let cure = "write \"x\", \"-y\", or three numbers such as [0.7, 0.7, 0]".to_string();
            wrong(entry.direction.span().start, format!("'{channel}' has no direction"), cure)
        })?;
        // A file may describe more sensors than this record has.
        if let Some(channel) = channels.iter().position(|known| known == channel) {
            geometry.sensors.push(Sensor { channel, node, direction });
        }
    }
    geometry.tell_of_the_rest(channels);
    Ok(geometry)
}

impl Geometry {
    /// Node and axis of a channel, where its sensor lies along one.
    pub(super) fn freedom(&self, channel: usize) -> Option<Freedom> {
        let sensor = self.sensors.iter().find(|sensor| sensor.channel == channel)?;
        let axis = sensor.direction.iter().position(|x| x.abs() == 1.0)?;
        Some(Freedom { node: self.labels[sensor.node], axis, negative: sensor.direction[axis] < 0.0 })
    }

    fn tell_of_the_rest(&mut self, channels: &[String]) {
        let without = |k: &usize| !self.sensors.iter().any(|sensor| sensor.channel == *k);
        let rest: Vec<&str> = (0..channels.len()).filter(without).map(|k| channels[k].as_str()).collect();
        if !rest.is_empty() && !self.sensors.is_empty() {
            self.notes.push(format!("without a place on the structure, not drawn: {}", rest.join(", ")));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(text: &str) -> Result<Geometry, String> {
        let unique = text.bytes().fold(0_u64, |sum, byte| sum.wrapping_mul(31).wrapping_add(u64::from(byte)));
        let file = std::env::temp_dir().join(format!("obsid-geometry-{}-{unique}.toml", std::process::id()));
        std::fs::write(&file, text).unwrap();
        let found = read(Some(&file), &[], &["acc_3".into(), "acc_4".into()]);
        std::fs::remove_file(&file).unwrap();
        found.map(|found| found.unwrap()).map_err(|failure| format!("{failure:?}"))
    }

    #[test]
    fn the_example_places_its_sensor_and_tells_of_the_channel_it_lacks() {
        let found = asked(EXAMPLE).unwrap();
        assert_eq!(found.sensors, [Sensor { channel: 0, node: 1, direction: [-1.0, 0.0, 0.0] }]);
        assert_eq!(found.strokes, [[0, 1]]);
        assert!(found.notes[0].contains("acc_4"), "{:?}", found.notes);
    }

    #[test]
    fn a_wrong_geometry_is_refused_with_its_line_and_a_cure() {
        for (text, line, what) in [
            (EXAMPLE.replace("\"root\", \"tip\"", "\"root\", \"top\""), "line 3", "no node 'top'"),
            (EXAMPLE.replace("\"-x\"", "\"u\""), "line 4", "'acc_3' has no direction"),
            (EXAMPLE.replace("[0, 0, 2.5]", "[0, 2.5]"), "line 2", ""),
            (EXAMPLE.replace("acc_3", "acc_9"), "says of no channel", "acc_4"),
        ] {
            // without the frame and the breaks of the message
            let said = asked(&text).unwrap_err();
            let said = said.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
            assert!(said.contains(line) && said.contains(what), "{said}");
        }
    }
}
