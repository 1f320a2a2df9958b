//! Laws of the checks against a plant: none on its own recordings, a fault where a diagnosis
//! rejects them.

use super::examine;
use super::examine_for;
use crate::synthetic::{plant, recording};
use channels::Recording;
use dynamics::description::{Plant, Quantity};
use examination::doctor::{Check, Finding, Severity};
use identification::problem::Problem;
use identification::work::Watch;

fn of(findings: &[Finding], check: Check) -> Option<&Finding> {
    findings.iter().find(|f| f.check == check)
}

/// Recording of an oscillator with its channel `displacement` changed.
fn changed(nominal: &Plant, duration_s: f64, change: impl Fn(&mut channels::Channel)) -> Recording {
    let mut recorded = recording(nominal, 1, duration_s);
    recorded.channels.iter_mut().filter(|c| c.name == "displacement").for_each(change);
    recorded
}

#[test]
fn a_plant_has_nothing_to_say_of_its_own_recordings() {
    for name in ["pendulum", "oscillator", "drive_rig", "double_pendulum"] {
        let nominal = plant(name);
        for seed in 0..5 {
            let reported = examine(&recording(&nominal, seed, 2.0), &nominal);
            assert!(reported.is_empty(), "{name}, seed {seed}: {reported:#?}");
        }
    }
}

#[test]
fn what_a_diagnosis_rejects_is_a_fault_with_the_cure_of_the_diagnosis() {
    let mut nominal = plant("drive_rig");
    let whole = recording(&nominal, 1, 2.0);
    // its command is no longer stated: it has to be recorded
    nominal.actuators[0].command.clear();
    let without = |names: &[&str]| {
        let channels = whole.channels.iter().filter(|c| !names.contains(&c.name.as_str())).cloned();
        Recording { name: "cut".into(), channels: channels.collect() }
    };
    let mut heavy = whole.clone();
    heavy.channels.iter_mut().for_each(|c| c.unit = "kg".into());
    for (recorded, check) in [
        (without(&["angle", "rate"]), Check::Missing),
        (without(&["motor"]), Check::Missing),
        (heavy, Check::Units),
        (changed(&plant("oscillator"), 0.0, |_| ()), Check::Missing),
    ] {
        let reported = examine(&recorded, &nominal);
        let error = Problem::new(&nominal, core::slice::from_ref(&recorded), &[]).expect_err("rejected");
        let fault = of(&reported, check).unwrap_or_else(|| panic!("{error}: {reported:#?}"));
        assert_eq!(fault.severity, Severity::Fault);
        assert!(fault.evidence.contains(&error.to_string()), "{fault:?}");
        assert_eq!(fault.cure, error.cure("the plant file"));
    }
}

#[test]
fn every_channel_in_another_unit_is_reported_not_the_first_alone() {
    let nominal = plant("drive_rig");
    let mut recorded = recording(&nominal, 1, 2.0);
    recorded.channels.iter_mut().for_each(|c| c.unit = "kg".into());
    let reported = examine(&recorded, &nominal);
    assert_eq!(reported.iter().filter(|f| f.check == Check::Units).count(), recorded.channels.len(), "{reported:#?}");
}

#[test]
fn a_channel_with_stated_noise_that_never_changes_is_a_fault_and_reported_once() {
    let nominal = plant("oscillator");
    let still = |c: &mut channels::Channel| c.value.iter_mut().for_each(|v| *v = 0.01);
    let reported = examine_for(&changed(&nominal, 2.0, still), &nominal, &Watch::default(), &mut |_| ());
    let constant: Vec<&Finding> =
        reported.iter().filter(|f| f.check == Check::Constant && f.channel == "displacement").collect();
    assert!(matches!(constant[..], [Finding { severity: Severity::Fault, .. }]), "{reported:#?}");
}

#[test]
fn a_channel_at_rest_below_its_resolution_is_not_called_stuck() {
    let mut coarse = plant("oscillator");
    let at = coarse.sensors.iter().position(|s| s.name == "displacement").unwrap();
    let sigma = crate::synthetic::sample_sigma(&coarse, "displacement").unwrap();
    let recorded = changed(&coarse, 2.0, |c| c.value.iter_mut().for_each(|v| *v = 0.01));
    for (steps, stuck) in [(20.0, false), (1.0, true)] {
        coarse.sensors[at].resolution = Quantity::known(steps * sigma);
        let reported = examine(&recorded, &coarse);
        assert_eq!(of(&reported, Check::Constant).is_some(), stuck, "{steps} sigma: {reported:#?}");
    }
}

#[test]
fn fewer_readings_than_unknown_parameters_are_reported_and_more_are_not() {
    let nominal = plant("drive_rig");
    let whole = recording(&nominal, 1, 2.0);
    let unknowns = Problem::new(&nominal, core::slice::from_ref(&whole), &[]).unwrap().unknowns.len();
    let sensors = nominal.sensors.len();
    let first = |n: usize| {
        let mut cut = whole.clone();
        cut.channels.iter_mut().for_each(|c| (c.time_s.truncate(n), c.value.truncate(n)).0);
        cut
    };
    assert!(unknowns >= 2 * sensors, "{unknowns}");
    assert!(of(&examine(&first(unknowns / sensors), &nominal), Check::FewSamples).is_some());
    assert!(of(&examine(&first(unknowns / sensors + 1), &nominal), Check::FewSamples).is_none());
}

#[test]
fn steps_off_by_a_unit_of_time_are_hinted_at_and_other_rates_are_not() {
    let nominal = plant("oscillator");
    let scaled = |factor: f64| {
        let mut recorded = recording(&nominal, 1, 2.0);
        recorded.channels.iter_mut().for_each(|c| c.time_s.iter_mut().for_each(|t| *t *= factor));
        examine(&recorded, &nominal)
    };
    let hint = scaled(1e3);
    let hint = of(&hint, Check::TimeUnit).expect("a thousand");
    assert!(hint.evidence.contains("milliseconds labelled seconds"), "{}", hint.evidence);
    assert!(of(&scaled(1e-6), Check::TimeUnit).is_some_and(|f| f.evidence.contains("seconds labelled microseconds")));
    for factor in [1.0, 0.1, 10.0, 100.0, 500.0, 2000.0] {
        assert!(of(&scaled(factor), Check::TimeUnit).is_none(), "{factor}");
    }
}
