//! `obsid modal` as a user has it: a universal file in, modes out as words, one object and a table.

use crate::desk::{Folder, number};
use std::fmt::Write;

const MODES: [(f64, f64); 2] = [(12.0, 0.01), (31.0, 0.006)];
/// Of each mode at the two nodes.
const SHAPES: [[f64; 2]; 2] = [[1.0, 0.6], [-0.7, 1.0]];

/// Accelerances of two nodes by a force at the first, 0 to 50 Hz in steps of 0.05 Hz, as dataset 58
/// in double precision.
fn universal_file() -> String {
    let mut text = String::new();
    for node in 0..2 {
        text += "    -1\n    58\nbeam\nNONE\nNONE\nNONE\nNONE\n";
        let _ = writeln!(text, "    4         0    0         0 NONE      {:10}   3 NONE               1   3", node + 1);
        text += "         6      1001         1  0.00000E+00  5.00000E-02  0.00000E+00\n";
        for (kind, unit) in [(18, "Hz"), (12, "m/s**2"), (13, "N"), (0, "NONE")] {
            let _ = writeln!(text, "{kind:10}    0    0    0 NONE                 {unit:<20}");
        }
        for line in 0..1001 {
            let f = 0.05 * f64::from(line);
            let (mut re, mut im) = (0.0, 0.0);
            for ((natural, zeta), shape) in MODES.iter().zip(&SHAPES) {
                // −ω² φ φ₁ / (ωₙ² − ω² + 2 i ζ ωₙ ω), in units of hertz: the factor cancels.
                let (real, imaginary) = (natural * natural - f * f, 2.0 * zeta * natural * f);
                let scale = -f * f * shape[node] * shape[0] / (real * real + imaginary * imaginary);
                (re, im) = (re + scale * real, im - scale * imaginary);
            }
            let _ = write!(text, "{:>20}{:>20}", format!("{re:.12E}"), format!("{im:.12E}"));
            if line % 2 == 1 {
                text.push('\n');
            }
        }
        text += "\n    -1\n";
    }
    text
}

#[test]
fn a_universal_file_of_responses_gives_its_modes_as_an_object_and_as_a_table() {
    let folder = Folder::new("modal-uff");
    let file = folder.file("beam.uff", universal_file());
    let answer = folder.ask(&["modal", file, "--orders", "2..12", "--csv", "modes.csv", "--json"]).ends_with(0);
    let object = answer.object();
    let modes = object["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 2, "{answer}");
    assert_eq!(object["channels"].as_array().unwrap().len(), 2);
    let table = String::from_utf8(folder.bytes("modes.csv")).unwrap();
    let rows: Vec<&str> = table.lines().collect();
    assert!(rows.len() == 3 && rows[0].starts_with("mode,frequency [Hz],frequency_sd [Hz],damping [-]"), "{rows:?}");
    for ((mode, (frequency_hz, zeta)), row) in modes.iter().zip(MODES).zip(&rows[1..]) {
        // Thirteen digits in the file.
        assert!((number(mode, "frequency_hz") / frequency_hz - 1.0).abs() < 1e-7, "{mode}");
        assert!((number(mode, "damping") / zeta - 1.0).abs() < 1e-5, "{mode}");
        let cell: f64 = row.split(',').nth(1).unwrap().parse().unwrap();
        assert_eq!(cell, number(mode, "frequency_hz"), "every digit");
    }
}

#[test]
fn a_universal_file_that_is_cut_is_refused_with_its_line() {
    let folder = Folder::new("modal-uff-cut");
    let text = universal_file();
    let file = folder.file("cut.uff", &text[..text.len() - 200]);
    folder.ask(&["modal", file]).refuses(&["cut.uff: line ", "the file ends after line"]);
}
