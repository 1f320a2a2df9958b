//! What the partition that flies publishes in the default mission, read back from its recording:
//! both estimates of the arm, the sensor sheet's sigma, what the data did to the prior, and the
//! target's numbers.

use bench::inertial::{Inertial, truth};
use nalgebra::{SMatrix, SVector};
use recording::RecordedRun;
use std::path::PathBuf;
use std::process::Command;
use telemetry::{
    ESTIMATE_INERTIAL, ESTIMATE_INERTIAL_TORQUE, ESTIMATE_TARGET, Estimate, Identifiability, InertialEstimate, Phase,
    TargetEstimate, Topic,
};

/// A run's own folder, gone when the run is.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("obsid-mission-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Folder(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// One arm experiment and what follows; the default scenario without slosh and modal.
fn flown(name: &str, change: impl Fn(&mut String)) -> RecordedRun {
    let folder = Folder::new(name);
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/deploy/scenarios/default.toml");
    let text = std::fs::read_to_string(default).expect("the default scenario");
    let (head, rest) = text.split_at(text.find("# BP3A").expect("modal comes first"));
    let mut text = format!("{head}{}", &rest[rest.find("# BP1A").expect("then the arm")..]);
    // Capture waits for the models that are left out here.
    text = text.replace("operator_override = false", "operator_override = true");
    change(&mut text);
    let (scenario, file) = (folder.0.join("scenario.toml"), folder.0.join("flight.mcap"));
    std::fs::write(&scenario, text).expect("a scenario");
    let mut command = Command::new(env!("CARGO_BIN_EXE_obsid"));
    let run = command.args(["run", "--link", "lockstep", "--json", "--record"]).arg(&file).arg(&scenario);
    let out = run.output().expect("it runs");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    recording::read_mcap_topics(&file, telemetry::is_result).expect("a recording")
}

fn last(recorded: &RecordedRun, topic: Topic<InertialEstimate>, phase: Phase) -> InertialEstimate {
    let closing = |sample: &&InertialEstimate| sample.estimate.closing == 1 && sample.estimate.phase == phase.code();
    let all = recorded.of(topic).map(|(_, sample)| sample);
    *all.filter(closing).last().expect("an experiment was closed")
}

fn nees<const P: usize>(estimate: &Estimate, truth: &SVector<f64, P>) -> f64 {
    assert_eq!((estimate.status, usize::from(estimate.count)), (0, P));
    let error = SVector::<f64, P>::from_fn(|i, _| estimate.values[i] - truth[i]);
    let covariance = SMatrix::<f64, P, P>::from_fn(|i, j| estimate.covariance[i][j]);
    error.dot(&covariance.cholesky().expect("positive").solve(&error))
}

fn targets(recorded: &RecordedRun) -> Vec<TargetEstimate> {
    recorded.of(ESTIMATE_TARGET).map(|(_, target)| *target).collect()
}

fn target_nees(found: &TargetEstimate) -> f64 {
    let error = SVector::<f64, 4>::from(found.values) - SVector::<f64, 4>::from([150.0, 0.60, 0.15, 40.0]);
    let covariance = SMatrix::<f64, 4, 4>::from_fn(|i, j| found.covariance[i][j]);
    error.dot(&covariance.cholesky().expect("positive").solve(&error))
}

/// χ², 99.9 %, of 4, 8 and 9 degrees of freedom.
const CHI_SQUARE_4: f64 = 18.5;
const CHI_SQUARE_8: f64 = 26.1;
const CHI_SQUARE_9: f64 = 27.9;
const CHI_SQUARE_13: f64 = 34.5;

#[test]
fn both_estimates_of_the_arm_are_published_in_both_phases_and_the_target_is_weighed() {
    let recorded = flown("default", |_| ());
    let (eight, nine) = (truth::<8>(&Inertial::bp1a().plant), truth::<9>(&Inertial::mated().plant));
    for topic in [ESTIMATE_INERTIAL, ESTIMATE_INERTIAL_TORQUE] {
        let (before, after) = (last(&recorded, topic, Phase::PreCapture), last(&recorded, topic, Phase::Mated));
        let found = (nees(&before.estimate, &eight), nees(&after.estimate, &nine));
        assert!(found.0 < CHI_SQUARE_8 && found.1 < CHI_SQUARE_9, "{found:?}");
    }
    let before = last(&recorded, ESTIMATE_INERTIAL, Phase::PreCapture);
    for i in 0..8 {
        let (consider, noise) = (before.consider_sigma_kg_m2[i], before.estimate.covariance[i][i].sqrt());
        assert!(consider > 0.1 * noise && consider < 20.0 * noise, "a{}: {consider} beside {noise}", i + 1);
    }
    assert_eq!(before.estimate.identifiability[..8], [Identifiability::Identified.code(); 8], "{before:?}");
    let [stated, found] = targets(&recorded)[..] else { panic!("stated and found") };
    assert!(stated.is_intact() && found.is_intact());
    assert_eq!((stated.origin, stated.status, found.origin, found.status), (0, 0, 2, 0));
    assert!(target_nees(&found) < CHI_SQUARE_4, "{found:?}");
    // eight and nine parameters, eleven numbers of the data sheet, fifteen unknowns
    assert!(found.fit_degrees == 13 && found.fit_chi_square < CHI_SQUARE_13, "{found:?}");
    assert!(found.covariance[0][0].sqrt() < 0.75, "better than what was stated alone: {found:?}");
}

#[test]
fn a_target_that_is_not_what_it_says_is_refused_and_so_is_a_statement_with_a_wrong_crc() {
    // The mass is off by 10 kg, thirteen of its own sigmas and some twenty of what is found.
    let lies = flown("lies", |text| *text = text.replace("mass_kg = 150.6", "mass_kg = 160.6"));
    let [_, found] = targets(&lies)[..] else { panic!("stated and found") };
    assert_eq!((found.origin, found.status), (1, 2));
    assert!(found.chi_square > CHI_SQUARE_4, "{}", found.chi_square);
    assert!(target_nees(&found) < CHI_SQUARE_4, "what is found stands alone: {found:?}");
    let broken = flown("crc", |text| *text = text.replace("mass_kg = 150.6", "mass_kg = 150.6\ncrc32 = 1"));
    let [stated, found] = targets(&broken)[..] else { panic!("stated and found") };
    assert_eq!((stated.status, found.origin, found.status), (1, 1, 0));
}

#[test]
fn an_arm_that_is_not_the_one_of_the_data_sheet_is_noticed_by_the_targets_fit() {
    // The sheet puts the shoulder 50 mm off and claims to know it to 0.1 mm: a4 over a5 says
    // otherwise, whatever the masses.
    let told = |text: &mut String| {
        let lengths = text.replace("\nlength_sd_m = 0.01\n", "\nlength_sd_m = 0.0001\n");
        assert!(lengths != *text, "the sheet's sigma stands in the default scenario");
        *text = lengths.replace("shoulder_m = [0.99, 0.99]", "shoulder_m = [0.94, 0.99]");
    };
    let recorded = flown("other-arm", told);
    let [_, found] = targets(&recorded)[..] else { panic!("stated and found") };
    assert_eq!((found.origin, found.status), (1, telemetry::TARGET_CONTRADICTED), "{found:?}");
    assert!(found.fit_chi_square > CHI_SQUARE_13);
}
