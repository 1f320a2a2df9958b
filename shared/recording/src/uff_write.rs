//! Geometry and mode shapes as a universal file: datasets 151, 164, 15, 82 and 55.
//!
//! SI units. The format holds six digits of a number. A shape whose imaginary parts are all zero is
//! written as a normal mode, another one with its eigenvalue as a complex mode.
//!
//! Source: University of Cincinnati SDRL, Universal File Datasets 15, 55, 82, 151, 164.

use crate::error::RecordingError;
use crate::file_name;
use crate::uff_model::{UffMode, UffModel};
use core::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

/// Writes a structure and its modes.
///
/// ```
/// use recording::{Node, NodeShape, UffMode, UffModel, read_model, write_model};
/// let file = std::env::temp_dir().join(format!("obsid-write-{}.unv", std::process::id()));
/// let shape = vec![NodeShape { node: 7, components: vec![[1.0, 0.0], [0.0, 0.0], [-0.5, 0.0]] }];
/// let modes = vec![UffMode { frequency_hz: 12.5, damping_ratio: 0.01, shape }];
/// let nodes = vec![Node { label: 7, xyz_m: [0.5, 0.0, 2.0] }];
/// let model = UffModel { nodes, modes, ..UffModel::default() };
/// write_model(&model, &file)?;
/// assert_eq!(read_model(&file)?.modes, model.modes);
/// # std::fs::remove_file(&file).unwrap();
/// # Ok::<(), recording::RecordingError>(())
/// ```
///
/// # Errors
/// The device's.
pub fn write_model(model: &UffModel, path: &Path) -> Result<(), RecordingError> {
    std::fs::write(path, text(model)).map_err(|reason| RecordingError::Io {
        file: file_name(path),
        action: "write",
        reason,
    })
}

fn text(model: &UffModel) -> String {
    let mut out = String::new();
    if let Some(header) = &model.header {
        let lines = [&header.model_name, &header.description, &header.program].map(|line| one_line(line));
        dataset(&mut out, 151, &lines.join("\n"));
    }
    let one = "1.00000000000000000D+00";
    dataset(
        &mut out,
        164,
        &format!("         1SI: Meter (newton)           2\n{one:>25}{one:>25}{one:>25}\n{one:>25}"),
    );
    if !model.nodes.is_empty() {
        let node = |node: &crate::Node| format!("{:10}{:10}{:10}{:10}{}", node.label, 0, 0, 0, reals(&node.xyz_m));
        dataset(&mut out, 15, &model.nodes.iter().map(node).collect::<Vec<_>>().join("\n"));
    }
    for line in &model.lines {
        let entries: Vec<i64> = line.strokes.join(&0);
        let rows = entries.chunks(8).map(|row| row.iter().map(|label| format!("{label:10}")).collect::<String>());
        let rows = rows.collect::<Vec<_>>().join("\n");
        dataset(
            &mut out,
            82,
            &format!("{:10}{:10}{:10}\n{}\n{rows}", line.number, entries.len(), 0, one_line(&line.name)),
        );
    }
    for (k, mode) in model.modes.iter().enumerate() {
        dataset(&mut out, 55, &of_mode(mode, k + 1));
    }
    out
}

fn dataset(out: &mut String, number: u32, body: &str) {
    let _ = writeln!(out, "    -1\n{number:6}\n{body}\n    -1");
}

/// As a line of a record: without breaks, 80 characters.
fn one_line(text: &str) -> String {
    let line: String = text.chars().map(|c| if c.is_ascii_graphic() { c } else { ' ' }).take(80).collect();
    if line.trim().is_empty() { "NONE".into() } else { line }
}

fn of_mode(mode: &UffMode, number: usize) -> String {
    let complex = mode.shape.iter().flat_map(|node| &node.components).any(|[_, im]| *im != 0.0);
    let (analysis, kind) = if complex { (3, 5) } else { (2, 2) };
    let values = if complex {
        let omega = TAU * mode.frequency_hz;
        let across = (1.0 - mode.damping_ratio * mode.damping_ratio).max(0.0).sqrt();
        vec![-mode.damping_ratio * omega, omega * across, 0.0, 0.0, 0.0, 0.0]
    } else {
        vec![mode.frequency_hz, 0.0, mode.damping_ratio, 0.0]
    };
    let title = format!("Mode {number}, {} Hz", mode.frequency_hz);
    let mut out = format!("{title}\nNONE\nNONE\nNONE\nNONE\n");
    // Structural, the analysis, translations, displacement, the kind of numbers, three a node.
    let _ = writeln!(out, "{:10}{analysis:10}{:10}{:10}{kind:10}{:10}", 1, 2, 8, 3);
    let _ = write!(out, "{:10}{:10}{:10}{number:10}\n{}", 2, values.len(), 0, reals(&values));
    for node in &mode.shape {
        let parts = node.components.iter().flat_map(|[re, im]| if complex { vec![*re, *im] } else { vec![*re] });
        let _ = write!(out, "\n{:10}\n{}", node.node, reals(&parts.collect::<Vec<_>>()));
    }
    out
}

/// Six numbers a line, each in thirteen columns.
fn reals(values: &[f64]) -> String {
    let number = |x: &f64| {
        let text = format!("{x:.5E}");
        let (digits, power) = text.split_once('E').unwrap_or((&text, "0"));
        let (sign, power) = power.strip_prefix('-').map_or(('+', power), |power| ('-', power));
        format!("{:>13}", format!("{digits}E{sign}{power:0>2}"))
    };
    values.chunks(6).map(|row| row.iter().map(number).collect::<String>()).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Node, NodeShape, TraceLine, UffHeader, read_model};

    #[test]
    fn a_structure_that_was_written_is_read_as_it_was_up_to_the_six_digits_of_the_format() {
        let shape = |components: [[[f64; 2]; 3]; 2]| {
            let node = |(k, components): (usize, [[f64; 2]; 3])| NodeShape {
                node: k as i64 + 101,
                components: components.to_vec(),
            };
            components.into_iter().enumerate().map(node).collect::<Vec<_>>()
        };
        let real = shape([[[1.0, 0.0], [0.0, 0.0], [-0.123_456_789, 0.0]], [[1e-12, 0.0], [0.0, 0.0], [0.5, 0.0]]]);
        let complex = shape([[[1.0, 0.0], [0.0, 0.0], [-0.25, 0.062_5]], [[0.0, -1e-7], [0.0, 0.0], [0.5, 0.0]]]);
        let model = UffModel {
            header: Some(UffHeader { model_name: "panel".into(), ..UffHeader::default() }),
            nodes: (0..2).map(|k| Node { label: k + 101, xyz_m: [0.1 * k as f64, -2.0, 1e-3] }).collect(),
            lines: vec![TraceLine { number: 1, name: "edge".into(), strokes: vec![vec![101, 102], vec![102, 101]] }],
            modes: vec![
                UffMode { frequency_hz: 1.234_567_89, damping_ratio: 0.012_3, shape: real },
                UffMode { frequency_hz: 45.6, damping_ratio: 0.003, shape: complex },
            ],
            notes: Vec::new(),
        };
        let file = std::env::temp_dir().join(format!("obsid-uff-write-{}.unv", std::process::id()));
        write_model(&model, &file).unwrap();
        let read = read_model(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        assert_eq!((read.nodes.len(), &read.lines, read.modes.len()), (2, &model.lines, 2));
        for (a, b) in read.modes.iter().zip(&model.modes) {
            // Half a unit of the sixth digit; damping is a quotient of two such numbers.
            assert!((a.frequency_hz / b.frequency_hz - 1.0).abs() < 1e-5);
            assert!((a.damping_ratio / b.damping_ratio - 1.0).abs() < 2e-5);
            let parts = |mode: &UffMode| -> Vec<f64> {
                mode.shape.iter().flat_map(|node| node.components.iter().flatten().copied()).collect()
            };
            for (x, y) in parts(a).iter().zip(parts(b)) {
                assert!((x - y).abs() <= 1e-5 * y.abs(), "{x} for {y}");
            }
        }
    }
}
