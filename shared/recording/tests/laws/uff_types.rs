//! What a function of a universal file is decides what is read of it; several groups are a choice.

use crate::universal_files::{Dataset, RESPONSE, TIME, random, refusal, spectrum, table};
use crate::{Numbers, scratch};
use recording::{FunctionKind, Imported, Spectrum, groups, read, read_group};
use std::path::{Path, PathBuf};

/// A file of this folder's own: two modes, and one decay, with noise.
fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/uff").join(name)
}

fn spectrum_of(name: &str) -> Spectrum {
    match read(&data(name)).unwrap() {
        Imported::Spectrum(spectrum) => spectrum,
        other => panic!("{name}: {other:?}"),
    }
}

const COHERENCE: Dataset =
    Dataset { kind: 6, ordinate: (0, "NONE"), denominator: (0, "NONE"), nodes: [(1, 3), (2, -1)], ..RESPONSE };
const PSD: Dataset =
    Dataset { kind: 9, layout: 4, ordinate: (12, "(m/s**2)**2/Hz"), denominator: (0, "NONE"), ..RESPONSE };

#[test]
fn coherences_and_densities_beside_responses_leave_exactly_the_responses() {
    let alone = spectrum_of("frf_only.uff");
    for (name, left_out) in [
        ("frf_and_complex_coded_coherence.uff", "1 coherence function is no response: left out"),
        ("frf_and_complex_coded_psd.uff", "2 power spectral densities are no responses: left out"),
    ] {
        let beside = spectrum_of(name);
        assert!(!beside.columns.is_empty() && beside.columns.len().is_multiple_of(2), "{name}");
        assert_eq!(beside.columns[..], alone.columns[..beside.columns.len()], "{name}");
        assert_eq!(beside.frequency_hz, alone.frequency_hz);
        assert_eq!(beside.notes, [left_out], "{name}");
    }
    assert!(alone.columns.iter().all(|column| column.kind == FunctionKind::Response));
}

#[test]
fn powers_of_an_output_are_given_as_their_roots_in_the_unit_of_the_output() {
    for (name, kind) in [
        ("psd_only.uff", FunctionKind::PowerSpectralDensity),
        ("autospectrum_power.uff", FunctionKind::AutoSpectrum { power: true }),
    ] {
        let read = spectrum_of(name);
        assert!(read.notes.is_empty(), "{name}: {:?}", read.notes);
        for column in &read.columns {
            assert_eq!((column.unit, column.kind), ("m/s^2", kind), "{name}");
        }
        // the first number of both files
        assert!((read.columns[0].values[0] - 4.47097e-6_f64.sqrt()).abs() < 1e-15, "{name}");
    }
    let power = [4.0, 9.0, 16.0, 0.0, 25.0];
    let g = Dataset { ordinate: (12, "g^2"), kind: 2, ..PSD };
    let of_g = spectrum("g.uff", g.ascii(&power).as_bytes());
    assert_eq!((of_g.columns[0].unit, of_g.columns[0].values[0]), ("m/s^2", 2.0 * 9.80665));
    let linear = Dataset { ordinate: (12, "m/s**2"), kind: 2, ..PSD };
    let of_linear = spectrum("linear.uff", linear.ascii(&power).as_bytes());
    assert_eq!(of_linear.columns[0].kind, FunctionKind::AutoSpectrum { power: false });
    assert_eq!(of_linear.columns[0].values, power);
}

#[test]
fn a_unit_that_neither_a_label_nor_a_dataset_states_is_assumed_with_a_note() {
    let complex: Vec<f64> = [3.0, -4.0].repeat(5);
    let silent = Dataset { ordinate: (12, "NONE"), ..RESPONSE };
    let read = spectrum("silent.uff", silent.ascii(&complex).as_bytes());
    assert!(
        read.notes.iter().any(|note| note.contains("SI is assumed: ") && note.contains("m/s^2")),
        "{:?}",
        read.notes
    );
    let stated = Dataset { ordinate: (12, "m/s**2"), denominator: (13, "N"), ..RESPONSE };
    let read = spectrum("stated.uff", stated.ascii(&complex).as_bytes());
    assert!(read.notes.is_empty(), "{:?}", read.notes);
}

#[test]
fn a_complex_spectrum_of_an_output_is_its_magnitude_and_a_cross_spectrum_over_an_input_a_response() {
    let complex: Vec<f64> = [3.0, -4.0].repeat(5);
    let of_output = Dataset { kind: 12, denominator: (0, "NONE"), ..RESPONSE };
    let read = spectrum("spectrum.uff", of_output.ascii(&complex).as_bytes());
    assert_eq!((read.columns.len(), read.columns[0].kind), (1, FunctionKind::Spectrum));
    assert_eq!(read.columns[0].values, [5.0; 5]);
    let cross = Dataset { kind: 3, ..RESPONSE };
    let read = spectrum("cross.uff", cross.ascii(&complex).as_bytes());
    assert_eq!(read.columns[0].kind, FunctionKind::Response);
    assert_eq!(read.columns[0].name, "accelerance_1z_2-x_real");
    let alone = Dataset { kind: 3, denominator: (0, "NONE"), ..RESPONSE };
    assert!(refusal("cross_alone.uff", alone.ascii(&complex).as_bytes()).contains("1 cross spectrum: no time history"));
}

#[test]
fn what_shows_no_resonances_is_refused_by_its_name() {
    let coherence = COHERENCE.ascii(&[0.9, 0.0].repeat(5));
    let error = refusal("coherence.uff", (coherence.clone() + &coherence).as_bytes());
    assert!(error.contains("coherence.uff: line 2: 2 coherence functions: no time history, response"), "{error}");
    assert!(error.contains("cure: export the frequency responses"), "{error}");
    let indicator = Dataset { kind: 18, ..PSD };
    assert!(refusal("mif.uff", indicator.ascii(&[1.0; 5]).as_bytes()).contains("1 function of another type"));
    let negative = refusal("negative.uff", PSD.ascii(&[1.0, 2.0, -3.0, 4.0, 5.0]).as_bytes());
    assert!(negative.contains("power spectral density `acceleration_1z` has -3 at 5 Hz"), "{negative}");
    let phase = Dataset { layout: 6, ..PSD };
    let imaginary = refusal("phase.uff", phase.ascii(&[1.0, 2.0].repeat(5)).as_bytes());
    assert!(imaginary.contains("has an imaginary part at 0 Hz"), "{imaginary}");
}

#[test]
fn a_last_row_that_is_filled_up_with_zeros_is_the_row_without_them() {
    let plain = read(&data("plain.uff")).unwrap();
    let Imported::Table(plain) = plain else { panic!("a table") };
    for name in ["even_padded.uff", "uneven_padded.uff"] {
        let Imported::Table(padded) = read(&data(name)).unwrap() else { panic!("{name}") };
        assert_eq!(padded.columns, plain.columns, "{name}");
        let apart = |(a, b): (&f64, &f64)| (a - b).abs();
        assert!(padded.time_s.iter().zip(&plain.time_s).map(apart).fold(0.0, f64::max) < 1e-9, "{name}");
        assert_eq!(padded.time_s.len(), 601);
    }
    // A row of zeros too many, and a surplus that is not zero, are mistakes.
    let text = TIME.ascii(&[1.0, 2.0, 3.0, 4.0, 5.0]);
    let last = text.lines().nth(14).unwrap();
    let zero = "  0.000000000000E+00";
    assert_eq!(table("padded.uff", text.replace(last, &format!("{last}{zero}{zero}")).as_bytes()).time_s.len(), 5);
    let long = text.replace(last, &format!("{last}{zero}{zero}{zero}{zero}"));
    assert!(refusal("long.uff", long.as_bytes()).contains("line 15: 9 numbers, 5 are announced"));
    let row = text.replace(last, &format!("{last}\n{zero}"));
    assert!(refusal("row.uff", row.as_bytes()).contains("stands where `-1` closes"));
    let other = text.replace(last, &format!("{last}  1.000000000000E-20"));
    assert!(refusal("other.uff", other.as_bytes()).contains("6 numbers, 5 are announced"));
}

#[test]
fn groups_of_a_whole_test_are_named_and_one_is_chosen_by_its_name() {
    let path = scratch("whole.uff");
    let fine = Dataset { values: 9, even: Some((0.0, 1.25)), ..RESPONSE };
    let slow = Dataset { even: Some((0.0, 0.1)), nodes: [(1, 1), (0, 0)], ..TIME };
    let text = TIME.ascii(&random(5))
        + &COHERENCE.ascii(&[0.9, 0.0].repeat(5))
        + &RESPONSE.ascii(&random(10))
        + &fine.ascii(&random(18))
        + &slow.ascii(&random(5));
    std::fs::write(&path, text).unwrap();
    let found = groups(&path).unwrap();
    let names: Vec<&str> = found.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(
        names,
        ["time 1", "coherence functions", "responses (5 lines)", "responses (9 lines)", "time 2", "time"]
    );
    let error = read(&path).unwrap_err().explain();
    let listed = "'time 1', 'responses (5 lines)', 'responses (9 lines)', 'time 2', 'time'";
    assert!(error.contains(&format!("the file holds several datasets: {listed}")), "{error}");
    assert!(error.contains("cure: choose one: --dataset 'time 1'"), "{error}");
    let Imported::Spectrum(chosen) = read_group(&path, "responses (9 lines)").unwrap() else { panic!("a spectrum") };
    assert_eq!(chosen.frequency_hz.len(), 9);
    let note =
        "2 time histories, 1 coherence function are no responses: left out; 1 response of other datasets: left out";
    assert_eq!(chosen.notes, [note]);
    let Imported::Series(all) = read_group(&path, "time").unwrap() else { panic!("channels") };
    assert_eq!(all.recording.channels.len(), 2);
    assert!(matches!(read_group(&path, "time 2").unwrap(), Imported::Table(_)));
    let unknown = read_group(&path, "time 3\n").unwrap_err().explain();
    assert!(unknown.contains(&format!("no dataset is called 'time 3\\n'; there are: {listed}")), "{unknown}");
    let coherence = read_group(&path, "coherence functions").unwrap_err().explain();
    assert!(coherence.contains("1 coherence function: no time history, response or spectrum"), "{coherence}");
}

#[test]
fn of_a_test_with_one_time_history_and_one_response_either_can_be_had() {
    let (both, lengths) = (data("time_and_frf_of_one_test.uff"), data("two_lengths.uff"));
    assert!(read(&both).unwrap_err().explain().contains("'time', 'responses'"));
    let Imported::Table(time) = read_group(&both, "time").unwrap() else { panic!("a table") };
    let Imported::Table(plain) = read(&data("plain.uff")).unwrap() else { panic!("a table") };
    assert_eq!(time.columns, plain.columns);
    assert!(matches!(read_group(&both, "responses").unwrap(), Imported::Spectrum(_)));
    assert!(read(&lengths).unwrap_err().explain().contains("'time 1', 'time 2', 'time'"));
    let Imported::Table(first) = read_group(&lengths, "time 1").unwrap() else { panic!("a table") };
    assert_eq!(first.columns, plain.columns);
}

#[test]
fn many_groups_are_listed_in_part_and_named_apart() {
    let text: String =
        (0..30).map(|k| Dataset { even: Some((f64::from(k), 2.5)), ..RESPONSE }.ascii(&random(10))).collect();
    let error = refusal("many.uff", text.as_bytes());
    assert!(error.contains("'responses 1', 'responses 2'") && error.contains(" and 10 more"), "{error}");
    let path = scratch("many.uff");
    for group in groups(&path).unwrap() {
        let Imported::Spectrum(spectrum) = group.imported else { panic!("a spectrum") };
        assert_eq!(format!("responses {}", spectrum.frequency_hz[0] + 1.0), group.name);
    }
}

#[test]
fn a_damaged_test_of_many_datasets_gives_groups_or_an_error_with_a_cure() {
    let bytes: Vec<u8> = ["time_and_frf_of_one_test.uff", "two_lengths.uff", "autospectrum_power.uff"]
        .iter()
        .flat_map(|name| std::fs::read(data(name)).unwrap())
        .chain(RESPONSE.binary(true, &[0; 80]))
        .collect();
    let path = scratch("damaged_groups.uff");
    let mut numbers = Numbers(58);
    for k in 0..300 {
        let mut damaged = bytes.clone();
        match k % 3 {
            0 => damaged.truncate(numbers.below(bytes.len())),
            1 => damaged[numbers.below(bytes.len())] ^= 1 << numbers.below(8),
            _ => (0..4).for_each(|_| damaged[numbers.below(1200)] = b"-1 589\nE."[numbers.below(9)]),
        }
        std::fs::write(&path, &damaged).unwrap();
        match groups(&path) {
            Ok(groups) => assert!(!groups.is_empty()),
            Err(error) => assert!(error.explain().contains("cure: "), "{error}"),
        }
        if let Err(error) = read_group(&path, "time") {
            assert!(error.explain().contains("cure: "), "{error}");
        }
    }
}
