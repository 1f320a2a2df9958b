//! One craft: who keeps an arc, who folds and who flies may die at any moment, and the posterior is
//! the same to the last bit.

use crate::PARTITIONS;
use crate::ended::KILLED;
use crate::world::World;

/// Physics that the pendulum carries and its file does not state.
const HIDDEN: [&str; 2] = ["--hide", "joint_coulomb@joint:pivot force=0.02"];
const CRAFT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/craft/pendulum.toml");

/// Kills everybody once with `point`, `first` frames behind the begin and so many apart.
fn drill(point: &str, first: u64, apart: u64) {
    let world = World::flying(CRAFT);
    let undisturbed = world.lockstep(&[]);
    let kills: Vec<String> =
        PARTITIONS.iter().zip(0..).map(|(name, k)| format!("{name}@{}:{point}", first + apart * k)).collect();
    let arguments: Vec<&str> = kills.iter().flat_map(|kill| ["--kill", kill]).collect();
    let ended = world.run(&arguments);
    assert_eq!(ended.code, Some(0), "{kills:?}: {ended}");
    assert_eq!(ended.digest(), undisturbed.digest(), "{kills:?}: {ended}");
    assert_eq!(ended.json["generations"], undisturbed.json["generations"], "{kills:?}");
    let died = ended.deaths();
    assert_eq!(died.len(), PARTITIONS.len(), "{ended}");
    assert!(died.iter().all(|death| death.cause == KILLED), "{ended}");
}

#[test]
fn partitions_killed_within_their_arcs_leave_the_posterior_unchanged() {
    drill("frame", 61, 190);
}

#[test]
fn partitions_killed_with_half_a_checkpoint_leave_the_posterior_unchanged() {
    drill("checkpoint", 110, 210);
}

#[test]
fn a_keeper_killed_when_its_arc_has_just_ended_hears_it_again_to_the_same_bytes() {
    let world = World::flying(CRAFT);
    let undisturbed = world.lockstep(&[]);
    // the first arc takes effect a window after the begin and is closed in the frame behind it
    let ended = world.run(&["--kill", "modal-id@340:publish"]);
    assert_eq!(ended.digest(), undisturbed.digest(), "{ended}");
}

#[test]
fn a_keeper_that_is_given_up_is_a_missing_message_and_the_posterior_is_wider() {
    let world = World::flying(CRAFT);
    let whole = world.lockstep(&[]);
    let ended = world.run(&["--kill-always", "slosh-id@60"]);
    let last = |json: &serde_json::Value| json["generations"].as_array().unwrap().last().unwrap().clone();
    let (of_all, of_two) = (last(&whole.json), last(&ended.json));
    let arcs = of_two["chi2_per_row"].as_array().unwrap();
    assert_eq!(arcs.iter().map(|row| row["arc"].as_str().unwrap()).collect::<Vec<_>>(), ["A", "C"], "{ended}");
    let sigmas = |generation: &serde_json::Value| -> Vec<f64> {
        generation["parameters"].as_array().unwrap().iter().map(|row| row["sigma"].as_f64().unwrap()).collect()
    };
    let (narrow, wide) = (sigmas(&of_all), sigmas(&of_two));
    // each is linearised about its own estimate, which changes sigmas by some per cent
    assert!(narrow.iter().zip(&wide).all(|(narrow, wide)| *wide > 0.95 * narrow), "{narrow:?} {wide:?}");
    assert!(narrow.iter().sum::<f64>() < wide.iter().sum::<f64>());
}

/// A model that is refused is diagnosed, augmented and tried again. The arcs are folded in frame
/// 1480; a window of 40 frames later the question is heard; hundreds of frames behind that, as many
/// as its work is worth, the diagnosis answers, and a window later the model is another.
#[test]
fn a_refused_model_ends_as_the_same_better_one_whoever_dies_on_the_way() {
    let world = World::flying(CRAFT);
    let undisturbed = world.lockstep(&HIDDEN);
    let answered = (undisturbed.json["diagnosis"]["t_detected_s"].as_f64().unwrap() * 100.0).round() as u64;
    let midway = 1520 + (answered - 1520) / 2;
    let heard = answered + 41;
    assert!(answered > 1720, "{answered}");
    let kills = [
        ["diagnosis@900:checkpoint".into(), "supervisor@1481:frame".into(), format!("inertial-id@{heard}:frame")],
        [
            "diagnosis@1520:publish".into(),
            format!("supervisor@{midway}:publish"),
            format!("slosh-id@{heard}:checkpoint"),
        ],
        [
            format!("diagnosis@{midway}:frame"),
            format!("sensor-sim@{midway}:frame"),
            format!("supervisor@{heard}:frame"),
        ],
        [
            format!("diagnosis@{answered}:publish"),
            format!("recorder@{midway}:frame"),
            format!("supervisor@{heard}:publish"),
        ],
    ];
    for kills in kills {
        let kills = kills.iter().flat_map(|kill| ["--kill", kill]);
        let ended = world.run(&HIDDEN.into_iter().chain(kills).collect::<Vec<_>>());
        assert_eq!(ended.digest(), undisturbed.digest(), "{ended}");
        assert_eq!(ended.json["diagnosis"], undisturbed.json["diagnosis"], "{ended}");
        assert_eq!(ended.deaths().len(), 3, "{ended}");
    }
}

#[test]
fn without_the_partition_that_diagnoses_a_refused_model_is_refused_with_its_reason() {
    let world = World::flying(CRAFT);
    let ended = world.run(&[&HIDDEN[..], &["--kill-always", "diagnosis@60"]].concat());
    let verdict = &ended.json["verdict"];
    assert_eq!(verdict["accepted"], false, "{ended}");
    assert!(verdict["reason"].as_str().unwrap().starts_with("model refused"), "{ended}");
    assert!(ended.json["diagnosis"].is_null(), "{ended}");
}
