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

/// One mode, 2 Hz and 1 %, recorded with the input: open loop, and under a controller of the
/// measured angle whose input is mostly the sensor's own noise.
#[test]
fn an_input_of_the_sensors_own_noise_gives_the_mode_that_open_loop_gives() {
    let folder = Folder::new("modal-known-input");
    for name in ["open_loop", "sensor_noise_fed_back", "louder_sensor"] {
        let file = format!("{}/tests/data/known_input/{name}.csv.gz", env!("CARGO_MANIFEST_DIR"));
        let object = folder.ask(&["modal", &file, "--input", "u", "--json"]).ends_with(0).object();
        let modes = object["modes"].as_array().unwrap();
        assert_eq!(modes.len(), 1, "{name}: {object}");
        let sigmas = |value: &str, sd: &str, truth: f64| (number(&modes[0], value) - truth) / number(&modes[0], sd);
        // Six deviates of unit variance: one beyond 4 in 2600 sets of records.
        assert!(sigmas("frequency_hz", "frequency_sd", 2.0).abs() < 4.0, "{name}: {object}");
        assert!(sigmas("damping", "damping_sd", 0.01).abs() < 4.0, "{name}: {object}");
        assert!(number(&modes[0], "damping_sd") < 0.003 && modes[0]["sd_basis"].is_string(), "{name}: {object}");
        assert!(object["model_adequate"] == true && object["residual"]["white"] == true, "{name}: {object}");
    }
}

/// The same record without some rows: where the input is the same on both sides it is held, and
/// otherwise not known.
#[test]
fn rows_may_be_absent_where_the_input_is_held_and_nowhere_else() {
    let folder = Folder::new("modal-known-input-gaps");
    let record = |held: usize, lost: &dyn Fn(usize) -> bool| {
        let (mut random, mut q, mut rate, mut u, mut text) =
            (1_u32, 0.0, 0.0, 0.0, String::from("time [s],u [N],y [m]\n"));
        let mut uniform = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(random >> 8) / f64::from(1_u32 << 24) - 0.5
        };
        for row in 0..3000_usize {
            if row.is_multiple_of(held) {
                u = uniform();
            }
            if !lost(row) {
                let _ = writeln!(text, "{:.2},{u},{}", 0.02 * row as f64, q + 1e-3 * uniform());
            }
            // 2 Hz, 1 %; small steps of the exact flow's second order.
            for _ in 0..200 {
                rate += 1e-4 * (u - 157.91367 * q - 0.25132741 * rate);
                q += 1e-4 * rate;
            }
        }
        text
    };
    let lost = |row: usize| row % 50 >= 20 && row % 50 < 24;
    let file = folder.file("held.csv", record(50, &lost));
    let object = folder.ask(&["modal", file, "--input", "u", "--json"]).ends_with(0).object();
    assert!((number(&object["modes"][0], "frequency_hz") - 2.0).abs() < 0.01, "{object}");
    assert!(object["advice"].to_string().contains("240 samples are absent"), "{object}");
    let file = folder.file("changed.csv", record(1, &lost));
    folder.ask(&["modal", file, "--input", "u"]).refuses(&["samples are missing behind 0.38", "equal on both sides"]);
}
