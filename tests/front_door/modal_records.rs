//! `obsid modal` on records as they are: each file has one defect, and the structure's two modes in
//! it.

use crate::desk::{Folder, number, workspace};
use serde_json::Value;

/// The answer about a file of `records`.
fn answer(file: &str) -> Value {
    answer_with(file, &[])
}

fn answer_with(file: &str, options: &[&str]) -> Value {
    let folder = Folder::new(&format!("modal-{file}"));
    let path = workspace().join("tests/front_door/records").join(file);
    let words: Vec<&str> =
        ["modal", path.to_str().unwrap(), "--json"].into_iter().chain(options.iter().copied()).collect();
    folder.ask(&words).ends_with(0).object()
}

fn of_nature<'a>(answer: &'a Value, nature: &str) -> Vec<&'a Value> {
    answer["modes"].as_array().unwrap().iter().filter(|mode| mode["nature"] == nature).collect()
}

fn did(answer: &Value, check: &str) -> usize {
    answer["examination"].as_array().unwrap().iter().filter(|finding| finding["check"] == check).count()
}

/// The answer has these modes (frequency, damping) within four of its standard deviations, which
/// are not wide, and no other.
fn has_modes(answer: &Value, truth: &[(f64, f64)]) {
    let modes = of_nature(answer, "mode");
    assert_eq!(modes.len(), truth.len(), "{answer:#}");
    for (mode, (frequency_hz, damping)) in modes.iter().zip(truth) {
        let (f_sd, damping_sd) = (number(mode, "frequency_sd"), number(mode, "damping_sd"));
        assert!((number(mode, "frequency_hz") - frequency_hz).abs() < 4.0 * f_sd, "{mode:#}");
        assert!((number(mode, "damping") - damping).abs() < 4.0 * damping_sd, "{mode:#}");
        assert!(f_sd < 0.01 * frequency_hz && damping_sd < 0.4 * damping, "{mode:#}");
    }
}

#[test]
fn samples_that_are_lost_leave_the_modes() {
    for file in ["every_tenth.csv.gz", "three_percent.csv.gz"] {
        let answer = answer(file);
        has_modes(&answer, &[(1.5, 0.01), (4.5, 0.015)]);
        assert_eq!(did(&answer, "missing"), 1, "one note for all gaps: {answer:#}");
    }
}

#[test]
fn held_values_are_read_at_their_rate_and_a_folded_mode_may_be_one() {
    let answer = answer("seven_in_a_row.csv.gz");
    // 50/7 Hz: 4.5 Hz shows at 50/7 − 4.5.
    let modes = of_nature(&answer, "mode");
    assert_eq!(modes.len(), 2, "{answer:#}");
    assert!((number(modes[0], "frequency_hz") - 1.5).abs() < 0.03);
    assert!((number(modes[1], "frequency_hz") - (50.0 / 7.0 - 4.5)).abs() < 0.05);
    let folded = modes[1]["may_be_folded_from_hz"].as_array().unwrap();
    assert!(folded.iter().any(|f| (f.as_f64().unwrap() - 4.5).abs() < 0.05), "{answer:#}");
    assert_eq!(did(&answer, "held"), 3);
}

#[test]
fn a_slower_channel_is_a_channel_with_samples_missing() {
    let answer = answer("one_channel_slower.csv.gz");
    has_modes(&answer, &[(1.5, 0.01), (4.5, 0.015)]);
    assert_eq!(did(&answer, "held"), 1);
}

#[test]
fn stamps_coarser_than_the_clock_change_nothing() {
    let answer = answer("ms_of_300_hz.csv.gz");
    has_modes(&answer, &[(9.0, 0.01), (27.0, 0.015)]);
    assert_eq!(did(&answer, "irregular_time"), 1);
}

#[test]
fn a_late_channel_leaves_the_modes_and_shapes_in_phase() {
    let answer = answer("second_channel_140_ms_late.csv.gz");
    has_modes(&answer, &[(1.5, 0.01), (4.5, 0.015)]);
    assert!(of_nature(&answer, "mode").iter().all(|mode| number(mode, "mpc") > 0.9), "{answer:#}");
    assert_eq!(did(&answer, "delay"), 1);
}

#[test]
fn tones_are_named_and_the_modes_beside_them_stay() {
    for (file, tones) in [("two_tones.csv.gz", 2), ("speed_wanders.csv.gz", 1)] {
        let answer = answer(file);
        has_modes(&answer, &[(2.0, 0.01), (7.0, 0.015)]);
        assert_eq!(of_nature(&answer, "tone").len(), tones, "{answer:#}");
    }
}

#[test]
fn six_records_of_responses_scatter_as_their_deviations_say() {
    let mut squares = Vec::new();
    for record in 0..6 {
        let answer = answer(&format!("frf_noise_{record}.csv.gz"));
        let modes = of_nature(&answer, "mode");
        assert_eq!(modes.len(), 2, "{answer:#}");
        for (mode, (f, zeta)) in modes.iter().zip([(20.0, 0.01), (55.0, 0.02)]) {
            let z = [
                (number(mode, "frequency_hz") - f) / number(mode, "frequency_sd"),
                (number(mode, "damping") - zeta) / number(mode, "damping_sd"),
            ];
            squares.extend(z.map(|z| z * z));
        }
    }
    // 1 % and 99 % of χ² with 24 degrees of freedom.
    let sum: f64 = squares.iter().sum();
    assert!(sum > 10.86 && sum < 42.98, "{squares:?}");
}

/// Nine modes too many of held values, two of the gaps, and a lost collinearity, when a trend was
/// taken out of the table before the examination.
#[test]
fn a_trend_is_taken_out_of_what_the_examination_leaves() {
    let held = answer_with("seven_in_a_row.csv.gz", &["--detrend", "mean"]);
    assert_eq!((of_nature(&held, "mode").len(), did(&held, "held")), (2, 3), "{held:#}");
    let lost = answer_with("every_tenth.csv.gz", &["--detrend", "linear"]);
    has_modes(&lost, &[(1.5, 0.01), (4.5, 0.015)]);
    let late = answer_with("second_channel_140_ms_late.csv.gz", &["--decimate", "2"]);
    has_modes(&late, &[(1.5, 0.01), (4.5, 0.015)]);
    assert_eq!(did(&late, "delay"), 1, "{late:#}");
    assert!(of_nature(&late, "mode").iter().all(|mode| number(mode, "mpc") > 0.9), "{late:#}");
    let folder = Folder::new("modal-slow-channel-decimated");
    let path = workspace().join("tests/front_door/records/one_channel_slower.csv.gz");
    let words = ["modal", path.to_str().unwrap(), "--decimate", "2"];
    folder.ask(&words).refuses(&["decimation by 2 leaves 0 % of a2", "leave out --decimate"]);
}
