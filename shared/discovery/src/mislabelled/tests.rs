//! Laws of labels: what is mistaken is found with its factor, what is not is left alone.

use super::*;
use crate::synthetic::{plant, recording};
use identification::work::{LABEL_CHECK_SHARE, NORMAL_WORK};

fn times(recording: &Recording, channel: &str, factor: f64) -> Recording {
    let mut changed = recording.clone();
    let own = changed.channels.iter_mut().find(|c| c.name == channel).expect("it is recorded");
    own.value.iter_mut().for_each(|value| *value *= factor);
    changed
}

fn labels() -> Arc<Work> {
    Arc::new(Work::of(LABEL_CHECK_SHARE * NORMAL_WORK))
}

/// Whether the plant follows a recording with its own numbers, as it is labelled.
fn is_followed(recording: &Recording, plant: &Plant) -> bool {
    is_near(&PlantEvaluator::new(plant, &labels()).predicted(recording, ParameterChoice::ByContinuation))
}

/// Channels and factor of what is found.
fn found(recording: &Recording, plant: &Plant) -> Option<(Vec<String>, f64)> {
    mislabelled(recording, plant, &labels()).map(|m| (m.channels.clone(), m.factor()))
}

#[test]
fn a_channel_in_another_unit_or_of_another_sign_is_found_with_its_factor_and_is_put_right() {
    let nominal = plant("drive_rig");
    let whole = recording(&nominal, 5, 1.0);
    let degree = 180.0 / PI;
    let cases = [("rate", degree), ("angle", degree), ("rate", -1.0), ("rate", 1e-3), ("angle", 1e3), ("motor", 1e3)];
    for (channel, factor) in cases {
        let reported = found(&times(&whole, channel, factor), &nominal).expect("it is far off");
        assert_eq!(reported.0, [channel.to_owned()], "{channel} x{factor}");
        assert!((reported.1 / factor - 1.0).abs() < 1e-12, "{channel} x{factor}: {reported:?}");
    }
}

#[test]
fn all_angles_of_a_file_in_degrees_are_one_mistake() {
    let nominal = plant("double_pendulum");
    let whole = recording(&nominal, 5, 4.0);
    let degree = 180.0 / PI;
    let wrong = times(&times(&whole, "angle_1", degree), "angle_2", degree);
    let reported = found(&wrong, &nominal);
    assert!(
        matches!(&reported, Some((channels, factor)) if channels.len() == 2 && (factor / degree - 1.0).abs() < 1e-12),
        "{reported:?}"
    );
}

#[test]
fn nothing_is_mislabelled_where_physics_alone_is_unmodelled_however_large() {
    let nominal = plant("pendulum");
    let mut with = nominal.clone();
    with.add_effect("joint_coulomb", &"joint:pivot".parse().unwrap(), &[("force", 0.05)]).unwrap();
    for plant in [&nominal, &with] {
        assert!(found(&recording(plant, 6, 10.0), &nominal).is_none(), "{}", plant.name);
    }
    let drive = plant("drive_rig");
    let mut slow = drive.clone();
    slow.add_effect("joint_coulomb", &"joint:drive".parse().unwrap(), &[("force", 0.5)]).unwrap();
    assert!(!is_followed(&recording(&slow, 6, 2.0), &drive));
    assert!(found(&recording(&slow, 6, 2.0), &drive).is_none());
}

/// A free response divided by anything is one still: what it misses is no unit.
#[test]
fn of_a_free_response_no_unit_is_reported() {
    let mut nominal = plant("oscillator");
    nominal.actuators[0].command.clear();
    nominal.actuators[0].recorded = false;
    let mut released = nominal.clone();
    released.initial.values = vec![dynamics::description::InitialValue {
        coordinate: "joint:rail".into(),
        position: dynamics::description::Quantity::known(2e-2),
        rate: dynamics::description::Quantity::known(0.0),
    }];
    let mut rubbed = released.clone();
    rubbed.add_effect("joint_coulomb", &"joint:rail".parse().unwrap(), &[("force", 1.0)]).unwrap();
    for plant in [&rubbed, &crate::noisier::of_higher_variance(&released, 10.0)] {
        let recorded = recording(plant, 8, 2.0);
        assert!(!is_followed(&recorded, &nominal));
        assert!(found(&recorded, &nominal).is_none());
    }
}

#[test]
fn two_swapped_channels_are_detected_and_corrected() {
    let nominal = plant("double_pendulum");
    let mut wrong = recording(&nominal, 5, 4.0);
    let whole = wrong.clone();
    for channel in &mut wrong.channels {
        channel.name = match channel.name.as_str() {
            "angle_1" => "angle_2".into(),
            "angle_2" => "angle_1".into(),
            other => other.into(),
        };
    }
    let reported = mislabelled(&wrong, &nominal, &labels()).expect("the plant cannot follow it");
    assert_eq!(reported.mistake, Mistake::Swapped);
    for channel in &whole.channels {
        let cured = reported.cured(&wrong);
        let own = cured.channels.iter().find(|c| c.name == channel.name).unwrap();
        assert_eq!(own.value, channel.value, "{}", channel.name);
    }
}

#[test]
fn a_long_recording_is_tested_by_a_first_part_that_is_missed_and_then_as_a_whole() {
    let nominal = plant("drive_rig");
    let whole = recording(&nominal, 5, 4.0);
    assert!(PlantEvaluator::new(&nominal, &labels()).samples(&whole) > FIRST_PART_READINGS);
    let degree = 180.0 / PI;
    assert_eq!(
        found(&times(&whole, "rate", degree), &nominal).expect("it is far off"),
        (vec!["rate".to_owned()], degree)
    );
    // what explains the beginning alone is no mistake of the label
    let mut changing = whole.clone();
    let rate = changing.channels.iter_mut().find(|c| c.name == "rate").expect("it is recorded");
    let most = rate.value.len() * 3 / 4;
    rate.value[..most].iter_mut().for_each(|value| *value *= degree);
    assert!(found(&changing, &nominal).is_none());
}

#[test]
fn what_a_beginning_at_rest_does_not_show_the_whole_does() {
    let mut nominal = plant("drive_rig");
    nominal.simulation.period_s = 2e-3;
    let late = recording(&nominal, 5, 2.0);
    // as long again and more at rest before it: the noise of a rate in degrees is missed by far,
    // and nothing is above it
    let mut rate_noise = crate::noise::Noise::new(9);
    let sigma = crate::synthetic::sample_sigma(&nominal, "rate").expect("it is stated");
    let (lead, step) = (6000, nominal.simulation.period_s);
    let mut whole = late.clone();
    for channel in &mut whole.channels {
        let rest: Vec<f64> = match channel.name.as_str() {
            "rate" => rate_noise.series(lead, sigma),
            _ => vec![0.0; lead],
        };
        channel.value.splice(0..0, rest);
        channel.time_s = (0..channel.value.len()).map(|k| k as f64 * step).collect();
    }
    let degree = 180.0 / PI;
    let wrong = times(&whole, "rate", degree);
    let asked = |recording: &Recording| PlantEvaluator::new(&nominal, &labels()).samples(recording);
    assert!(asked(&wrong.beginning(FIRST_PART_READINGS as f64 / asked(&wrong) as f64)) < 2 * lead);
    assert_eq!(found(&wrong, &nominal).expect("it is far off"), (vec!["rate".to_owned()], degree));
}

#[test]
fn without_budget_no_metadata_is_reported_and_that_is_said_and_testing_costs_no_more_than_the_budget() {
    let drive = plant("drive_rig");
    let wrong = times(&recording(&drive, 5, 2.0), "rate", 180.0 / PI);
    let by = |most: f64| {
        let work = Arc::new(Work::of(most));
        (mislabelled(&wrong, &drive, &work).is_some(), work)
    };
    let (reported, little) = by(1e6);
    assert!(!reported && little.note().expect("it is said").contains(OMITTED_PARTS));
    let (reported, enough) = by(LABEL_CHECK_SHARE * NORMAL_WORK);
    assert!(reported && enough.note().is_none());
    // what is begun is ended, and the whole is asked of what explains a part
    let all = enough.spent();
    for share in [0.1, 0.2, 0.3, 0.5, 0.7, 0.9] {
        let (reported, work) = by(share * all);
        assert!(work.spent() < (share + 0.5) * all, "{share}: {:e} of {all:e}", work.spent());
        assert!(reported || work.note().is_some(), "{share}");
    }
    // a large misfit that no label explains
    let mut rubbed = drive.clone();
    rubbed.add_effect("joint_coulomb", &"joint:drive".parse().unwrap(), &[("force", 0.5)]).unwrap();
    let rubbed = recording(&rubbed, 6, 2.0);
    let work = labels();
    assert!(mislabelled(&rubbed, &drive, &work).is_none() && work.note().is_none());
    let tenth = Arc::new(Work::of(0.1 * work.spent()));
    assert!(mislabelled(&rubbed, &drive, &tenth).is_none() && tenth.note().is_some());
    assert!(tenth.spent() < 0.3 * work.spent(), "{:e} of {:e}", tenth.spent(), work.spent());
}

#[test]
fn where_no_mistake_explains_a_beginning_none_is_sought_in_the_whole() {
    let drive = plant("drive_rig");
    let mut rubbed = drive.clone();
    rubbed.add_effect("joint_coulomb", &"joint:drive".parse().unwrap(), &[("force", 0.5)]).unwrap();
    let [short, long] = [2.0, 8.0].map(|duration_s| {
        let work = labels();
        assert!(mislabelled(&recording(&rubbed, 6, duration_s), &drive, &work).is_none() && work.note().is_none());
        work.spent()
    });
    assert!(long < 2.0 * short, "{long:e} {short:e}");
}
