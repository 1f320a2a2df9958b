//! What structural engineers ask of `obsid modal`: comparison, geometry, setups, poles by hand,
//! lower rates, universal files.

use crate::desk::{Folder, number};
use std::fmt::Write;

const RATE_HZ: f64 = 50.0;
/// Frequency [Hz], damping, and a component at each of six sensors.
const MODES: [(f64, f64, [f64; 6]); 2] =
    [(2.1, 0.015, [1.0, 0.8, 0.6, 0.5, 0.3, -0.4]), (5.3, 0.01, [-0.5, 0.7, 1.0, -0.6, 0.8, 0.9])];

/// A linear congruential generator and the sum of twelve uniform numbers.
struct Noise(u64);

impl Noise {
    fn normal(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 33) as f64 / f64::from(1_u32 << 31);
        }
        sum
    }
}

/// Ambient motion of some sensors as a table, under names of one's own.
fn ambient(seed: u64, sensors: &[(usize, &str)]) -> String {
    let (mut noise, mut state) = (Noise(seed), [[0.0; 2]; 2]);
    let mut text = String::from("t [s]");
    sensors.iter().for_each(|(_, name)| text.push_str(&format!(",{name} [m/s^2]")));
    for row in 0..6500 {
        for ((hz, zeta, _), state) in MODES.iter().zip(&mut state) {
            let omega = std::f64::consts::TAU * hz / RATE_HZ;
            let rho = (-zeta * omega).exp();
            let turn = (omega * (1.0 - zeta * zeta).sqrt()).cos();
            let y = 2.0 * rho * turn * state[0] - rho * rho * state[1] + omega * zeta.sqrt() * noise.normal();
            *state = [y, state[0]];
        }
        if row < 500 {
            continue;
        }
        let _ = write!(text, "\n{}", f64::from(row - 500) / RATE_HZ);
        for (sensor, _) in sensors {
            let y: f64 = MODES.iter().zip(&state).map(|((.., shape), state)| shape[*sensor] * state[0]).sum();
            let _ = write!(text, ",{:.7}", y + 0.01 * noise.normal());
        }
    }
    text + "\n"
}

const THREE: [(usize, &str); 3] = [(0, "a"), (1, "b"), (2, "c")];

#[test]
fn modes_against_their_own_answer_are_the_same_and_channels_of_one_side_are_named() {
    let folder = Folder::new("modal-reference");
    let file = folder.file("today.csv", ambient(1, &THREE));
    let before = folder.ask(&["modal", file, "--json"]).ends_with(0);
    folder.file("before.json", &before.stdout);
    let object = folder.ask(&["modal", file, "--reference", "before.json", "--json"]).result();
    let mac = &object["mac"];
    assert_eq!(mac["pairs"].as_array().unwrap().len(), 2, "{mac}");
    for (k, pair) in mac["pairs"].as_array().unwrap().iter().enumerate() {
        assert!((number(pair, "mac") - 1.0).abs() < 1e-12 && number(pair, "frequency_change_percent") == 0.0);
        assert!(mac["values"][k][1 - k].as_f64().unwrap() < 0.9, "{mac}");
    }
    let other = folder.file("other.csv", ambient(2, &[(0, "a"), (2, "c"), (4, "e")]));
    let said = folder.ask(&["modal", other, "--reference", "before.json"]).ends_with(0).stdout;
    assert!(said.contains("2 channels in common") && said.contains("only here, not compared: e"), "{said}");
    let strange = folder.file("strange.csv", ambient(2, &[(3, "x"), (4, "y")]));
    folder.ask(&["modal", strange, "--reference", "before.json"]).refuses(&["no channel in common"]);
    folder.ask(&["modal", strange, "--reference", "strange.csv"]).refuses(&["strange.csv"]);
}

#[test]
fn shape_deviations_of_an_output_only_record_stand_beside_the_shapes() {
    let folder = Folder::new("modal-shape-sd");
    let file = folder.file("run.csv", ambient(3, &THREE));
    let object = folder.ask(&["modal", file, "--json", "--csv", "modes.csv"]).result();
    for mode in object["modes"].as_array().unwrap() {
        let truth = MODES.iter().find(|truth| (truth.0 - number(mode, "frequency_hz")).abs() < 0.2).unwrap().2;
        let component = |k: usize, key: &str, part: &str| mode[key][k][part].as_f64().unwrap();
        let unit = (0..3).find(|k| component(*k, "shape", "re") == 1.0).unwrap();
        assert_eq!(component(unit, "shape_sd", "re"), 0.0, "the component that holds the scale");
        for k in (0..3).filter(|k| *k != unit) {
            let (psi, sd) = (component(k, "shape", "re"), component(k, "shape_sd", "re"));
            // One seed, held to five deviations; tests of the crate hold their size.
            assert!((psi - truth[k] / truth[unit]).abs() < 5.0 * sd && sd < 0.1, "{mode}");
        }
    }
    let table = String::from_utf8(folder.bytes("modes.csv")).unwrap();
    assert!(table.lines().next().unwrap().ends_with("shape_c_re_sd [-],shape_c_im_sd [-]"), "{table}");
}

#[test]
fn a_geometry_moves_on_the_page_and_goes_with_the_modes_into_a_universal_file() {
    let folder = Folder::new("modal-geometry");
    let file = folder.file("run.csv", ambient(4, &THREE));
    let geometry = "nodes.p = [0, 0, 0]\nnodes.q = [1, 0, 0]\nnodes.r = [2, 0, 0]\nlines = [[\"p\", \"q\", \"r\"]]\n\
        sensors.a = { node = \"p\", direction = \"z\" }\nsensors.b = { node = \"q\", direction = \"-z\" }\n\
        sensors.c = { node = \"r\", direction = \"z\" }\n";
    folder.file("beam.toml", geometry);
    let written = ["--out", "page", "--uff", "beam.unv", "--singular-values", "values.csv"];
    let words: Vec<&str> = ["modal", file, "--geometry", "beam.toml"].into_iter().chain(written).collect();
    folder.ask(&words).ends_with(0);
    let page = String::from_utf8(folder.bytes("page/modal.html")).unwrap();
    assert!(page.contains(" data-structure=") && page.contains("prefers-reduced-motion"));
    assert!(page.contains("Shapes against shapes") && page.contains("singular value 1"));
    let values = String::from_utf8(folder.bytes("values.csv")).unwrap();
    assert!(values.starts_with("frequency [Hz],singular_1,singular_2,singular_3\n"), "{}", &values[..80]);
    // The file read again is the same set of modes, up to its six digits.
    let again = folder.ask(&["modal", file, "--geometry", "beam.toml", "--reference", "beam.unv", "--json"]).result();
    assert_eq!(again["mac"]["unpaired_channels"]["own"].as_array().unwrap().len(), 0, "{}", again["mac"]);
    for pair in again["mac"]["pairs"].as_array().unwrap() {
        assert!(number(pair, "mac") > 1.0 - 1e-9 && number(pair, "frequency_change_percent").abs() < 1e-3, "{pair}");
    }
    folder.file("wrong.toml", geometry.replace("\"q\", \"r\"", "\"q\", \"s\""));
    folder.ask(&["modal", file, "--geometry", "wrong.toml"]).refuses(&["wrong.toml: line 4: no node 's'"]);
}

#[test]
fn three_setups_with_two_references_are_one_structure() {
    let folder = Folder::new("modal-setups");
    let places = [[(0, "r1"), (1, "r2"), (2, "p")], [(0, "r1"), (1, "r2"), (3, "p")], [(1, "r2"), (0, "r1"), (4, "q")]];
    for (k, place) in places.iter().enumerate() {
        folder.file(&format!("s{k}.csv"), ambient(10 + k as u64, place));
    }
    let truth = |k: usize, f: f64| MODES.iter().find(|truth| (truth.0 - f).abs() < 0.2).unwrap().2[k];
    for by in ["poser", "preger"] {
        let words = ["modal", "s0.csv", "--setup", "s1.csv,s2.csv", "--references", "r1,r2", "--merge", by, "--json"];
        let object = folder.ask(&words).result();
        assert_eq!(object["setups"].as_array().unwrap().len(), 3);
        let channels: Vec<&str> = object["channels"].as_array().unwrap().iter().map(|c| c.as_str().unwrap()).collect();
        assert_eq!(channels, ["r1", "r2", "s0:p", "s1:p", "q"]);
        let modes = object["modes"].as_array().unwrap();
        assert_eq!(modes.len(), 2, "{by}: {object}");
        for mode in modes {
            let part = |k: usize| mode["shape"][k]["re"].as_f64().unwrap();
            for (k, f) in (0..5).map(|k| (k, number(mode, "frequency_hz"))) {
                let expected = truth(k, f) / truth(0, f) * part(0);
                // Some per cent of the largest component after 120 s.
                assert!((part(k) - expected).abs() < 0.15, "{by}, component {k}: {} for {expected}", part(k));
            }
        }
    }
    folder.ask(&["modal", "s0.csv", "--setup", "s1.csv"]).refuses(&["all channels have the same name"]);
    folder
        .ask(&["modal", "s0.csv", "--setup", "s2.csv", "--references", "r1,r3"])
        .refuses(&["no reference 'r3'", "s0.csv has r1, r2, p"]);
}

/// Tones were modes of every setup, and held values gave modes, when setups were read without the
/// examination.
#[test]
fn setups_are_examined_as_single_records_are() {
    let folder = Folder::new("modal-setups-examined");
    let with_a_tone = |text: String| -> String {
        let mut row = -1.0;
        let line = |line: &str| {
            row += 1.0;
            let mut cells = line.split(',').map(str::to_owned).collect::<Vec<_>>();
            for cell in cells.iter_mut().skip(1).filter(|_| row > 0.0) {
                let wanders = 0.04 * 15.0 * (std::f64::consts::TAU * row / RATE_HZ / 90.0).sin();
                let tone = (std::f64::consts::TAU * (8.0 * row / RATE_HZ + wanders)).sin();
                *cell = format!("{:.7}", cell.parse::<f64>().unwrap() + tone);
            }
            cells.join(",") + "\n"
        };
        text.lines().map(line).collect()
    };
    folder.file("s0.csv", with_a_tone(ambient(10, &[(0, "r1"), (1, "r2"), (2, "p")])));
    folder.file("s1.csv", ambient(11, &[(0, "r1"), (1, "r2"), (3, "q")]));
    for by in ["poser", "preger"] {
        let words = ["modal", "s0.csv", "--setup", "s1.csv", "--references", "r1,r2", "--merge", by, "--json"];
        let object = folder.ask(&words).result();
        assert_eq!(object["modes"].as_array().unwrap().len(), 2, "{by}: {object}");
        let of_first = object["setups"][0]["modes"].as_array().unwrap();
        assert_eq!(of_first.len(), 2, "the tone is no mode of its setup: {object}");
        let tone = &object["examination"][0];
        assert!(tone["check"] == "tone" && (number(tone, "value") - 8.0).abs() < 0.01, "{object}");
        assert_eq!(tone["channel"], "s0.csv");
    }
}

#[test]
fn poles_picked_by_hand_are_the_modes_with_their_own_deviations() {
    let folder = Folder::new("modal-select");
    let file = folder.file("run.csv", ambient(5, &THREE));
    let object = folder.ask(&["modal", file, "--select", "12:5.2,10:2", "--json"]).result();
    let modes = object["modes"].as_array().unwrap();
    assert_eq!(modes.len(), 2);
    for (mode, (hz, ..)) in modes.iter().zip(MODES) {
        let sd = number(mode, "frequency_sd");
        assert!((number(mode, "frequency_hz") - hz).abs() < 5.0 * sd && sd < 0.05, "{mode}");
    }
    folder.ask(&["modal", file, "--select", "900:5"]).refuses(&["no oscillation of order 900"]);
    folder.ask(&["modal", file, "--select", "2:20"]).refuses(&["order 2 has no pole there", "the nearest is at"]);
    folder.ask(&["modal", file, "--band", "30..50"]).refuses(&["the record ends at", "give a band below it"]);
}

#[test]
fn a_lower_rate_keeps_the_modes_and_one_that_does_not_divide_is_refused() {
    let folder = Folder::new("modal-decimate");
    let file = folder.file("run.csv", ambient(6, &THREE));
    let words = ["modal", file, "--decimate", "25Hz", "--detrend", "linear", "--json"];
    let object = folder.ask(&words).result();
    assert_eq!(object["modes"].as_array().unwrap().len(), 2, "{object}");
    let notes = object["notes"].to_string();
    assert!(notes.contains("pass band to 10.0000 Hz") && notes.contains("line of least squares"), "{notes}");
    for (mode, (hz, ..)) in object["modes"].as_array().unwrap().iter().zip(MODES) {
        assert!((number(mode, "frequency_hz") - hz).abs() < 5.0 * number(mode, "frequency_sd"), "{mode}");
    }
    folder.ask(&["modal", file, "--decimate", "18Hz"]).refuses(&["18 Hz is no whole part", "--decimate 2"]);
}
