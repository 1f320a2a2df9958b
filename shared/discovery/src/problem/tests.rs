use super::*;
use crate::synthetic::{plant, recording};

#[test]
fn a_channel_that_is_called_otherwise_is_named_with_the_nearest_and_a_map_joins_it() {
    let nominal = plant("oscillator");
    let mut recorded = recording(&nominal, 1, 0.2);
    let at = recorded.channels.iter().position(|c| c.name == "displacement").unwrap();
    recorded.channels[at].name = "displacement_1".to_owned();
    let error = Problem::new(&nominal, core::slice::from_ref(&recorded), &[]).unwrap_err();
    assert!(error.to_string().contains("did you mean 'displacement_1'"), "{error}");
    let map = [("displacement".to_owned(), "displacement_1".to_owned())];
    assert_eq!(Problem::new(&nominal, &[recorded], &map).unwrap().samples(), 200);
}

#[test]
fn another_unit_is_an_error() {
    let nominal = plant("oscillator");
    let mut recorded = recording(&nominal, 1, 0.2);
    recorded.channels.iter_mut().filter(|c| c.name == "displacement").for_each(|c| c.unit = "mm".to_owned());
    let error = Problem::new(&nominal, &[recorded], &[]).unwrap_err();
    assert!(matches!(error, ProblemError::Unit { .. }), "{error}");
}

#[test]
fn numbers_per_recording_become_one_unknown_a_recording() {
    let nominal = plant("pendulum");
    let both = [recording(&nominal, 1, 0.5), recording(&nominal, 2, 0.5)];
    let one = Problem::new(&nominal, &both[..1], &[]).unwrap();
    let two = Problem::new(&nominal, &both, &[]).unwrap();
    assert_eq!(two.unknowns.len(), one.unknowns.len() + 1);
    assert!(two.unknowns.iter().any(|u| u.name == "angle.bias@2" && u.recording == Some(1)));
}

#[test]
fn a_split_keeps_every_sample_once() {
    let nominal = plant("pendulum");
    let whole = crate::synthetic::problem(&nominal, recording(&nominal, 1, 2.0));
    let (first, last) = whole.split(0.7);
    assert_eq!(first.samples() + last.samples(), whole.samples());
    assert!(first.runs[0].end_s <= last.runs[0].begin_s);
}
