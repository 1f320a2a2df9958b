//! The modes as a universal file (`--uff`).

use super::degree_of_freedom::of_response;
use super::geometry::{Geometry, Sensor};
use super::{FoundMode, Outcome};
use crate::Failure;
use crate::recordings::tool;
use recording::{Node, NodeShape, TraceLine, UffHeader, UffMode, UffModel, write_model};
use std::collections::BTreeMap;
use std::path::Path;

/// Writes geometry and modes; gives what was taken for granted.
///
/// Without a geometry the channels that name node and direction are written at these, and where
/// none do every channel becomes a node that moves along z.
///
/// # Errors
/// [`Failure::Input`] without shapes, [`Failure::Run`] where the file cannot be written.
pub(super) fn write(outcome: &Outcome, file: &Path) -> Result<Vec<String>, Failure> {
    if !outcome.modes.iter().any(|mode| !mode.shape.is_empty()) {
        return Err(Failure::Input(miette::miette!(
            help = "give complex responses or a time record with modes in it, or leave out --uff",
            "--uff: there is no mode with a shape to write"
        )));
    }
    let mut notes = Vec::new();
    let geometry = outcome.structure.geometry.clone().unwrap_or_else(|| {
        let (geometry, note) = from_names(&outcome.channels);
        notes.push(note);
        geometry
    });
    let label = |node: usize| geometry.labels[node];
    let node = |(k, xyz_m): (usize, &[f64; 3])| Node { label: label(k), xyz_m: *xyz_m };
    let line = |(k, stroke): (usize, &Vec<usize>)| TraceLine {
        number: k as i64 + 1,
        name: format!("line {}", k + 1),
        strokes: vec![stroke.iter().map(|node| label(*node)).collect()],
    };
    let header = UffHeader { model_name: outcome.record.clone(), program: tool(), ..UffHeader::default() };
    let model = UffModel {
        header: Some(header),
        // Nodes made of names have no places.
        nodes: if outcome.structure.geometry.is_some() {
            geometry.nodes_m.iter().enumerate().map(node).collect()
        } else {
            Vec::new()
        },
        lines: geometry.strokes.iter().enumerate().map(line).collect(),
        modes: outcome
            .modes
            .iter()
            .filter(|mode| !mode.shape.is_empty())
            .map(|mode| of_mode(mode, &geometry))
            .collect(),
        notes: Vec::new(),
    };
    write_model(&model, file).map_err(|error| Failure::Run(error.to_string()))?;
    Ok(notes)
}

fn of_mode(mode: &FoundMode, geometry: &Geometry) -> UffMode {
    let mut shape: BTreeMap<i64, Vec<[f64; 2]>> = BTreeMap::new();
    for (node, displacement) in displacements(mode, geometry) {
        shape.insert(geometry.labels[node], displacement.to_vec());
    }
    UffMode {
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping.unwrap_or(0.0),
        shape: shape.into_iter().map(|(node, components)| NodeShape { node, components }).collect(),
    }
}

/// Displacement of every node that a channel measures: the sum of its components along the
/// directions of the sensors.
pub(super) fn displacements(mode: &FoundMode, geometry: &Geometry) -> BTreeMap<usize, [[f64; 2]; 3]> {
    let mut nodes: BTreeMap<usize, [[f64; 2]; 3]> = BTreeMap::new();
    for Sensor { channel, node, direction } in &geometry.sensors {
        let Some(psi) = mode.shape.get(*channel).filter(|psi| psi.re.is_finite() && psi.im.is_finite()) else {
            continue;
        };
        for (part, along) in nodes.entry(*node).or_default().iter_mut().zip(direction) {
            part[0] += along * psi.re;
            part[1] += along * psi.im;
        }
    }
    nodes
}

fn from_names(channels: &[String]) -> (Geometry, String) {
    let named = channels.iter().any(|name| of_response(name).is_some());
    let mut geometry = Geometry::default();
    for (channel, name) in channels.iter().enumerate() {
        let (label, direction) = match of_response(name) {
            Some(freedom) => (freedom.node, freedom.direction()),
            None if named => continue,
            None => (channel as i64 + 1, [0.0, 0.0, 1.0]),
        };
        let node = geometry.labels.iter().position(|known| *known == label).unwrap_or_else(|| {
            geometry.labels.push(label);
            geometry.nodes_m.push([0.0; 3]);
            geometry.labels.len() - 1
        });
        geometry.sensors.push(Sensor { channel, node, direction });
    }
    let note = if named {
        "the universal file has no geometry: nodes and directions are those in the names of the channels"
    } else {
        "the universal file has no geometry: channel k is node k, moving along z; give --geometry"
    };
    (geometry, note.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use modal::c64;

    #[test]
    fn what_is_written_is_read_again_and_sensors_along_minus_x_turn_the_sign() {
        let mode = FoundMode {
            frequency_hz: 12.5,
            damping: Some(0.25),
            shape: vec![c64::new(1.0, 0.0), c64::new(-0.5, 0.125)],
            ..FoundMode::default()
        };
        let channels = vec!["acceleration_3z".into(), "acceleration_7-x".into()];
        let outcome = Outcome { channels, modes: vec![mode], ..Outcome::default() };
        let file = std::env::temp_dir().join(format!("obsid-modal-export-{}.unv", std::process::id()));
        let notes = write(&outcome, &file).unwrap();
        let read = recording::read_model(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert!(notes[0].contains("names of the channels"));
        let mode = &read.modes[0];
        // Six digits in the file; the damping comes from the eigenvalue.
        assert!((mode.frequency_hz - 12.5).abs() < 1e-4 && (mode.damping_ratio - 0.25).abs() < 1e-5);
        assert_eq!(mode.shape[0].components[2], [1.0, 0.0]);
        assert_eq!(mode.shape[1].components[0], [0.5, -0.125]);
    }
}
