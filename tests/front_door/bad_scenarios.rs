//! Scenario files with unknown keys and numbers that cannot be: refused at their place before
//! anything starts.

use crate::desk::{Folder, scenario};

const MODAL: &str = "[modal]\nduration_s = 3.0\nplant = { file = \"hub_appendage\" }\n";
const SLOSH: &str = "[slosh]\nduration_s = 6.0\nplant = { file = \"tank_1d\" }\n";
const ARM: &str = "[inertial]\nduration_s = 3.0\ntrajectory = \"b\"\nplant = { file = \"free_floating_arm\" }\n[inertial.known]\nh_cm_nms = 68.0\n";
const PRIOR: &str = "prior = [60.9, 58.2, 26.5, 24.2, 24.2, 10.4, 10.4, 21.8]\n";

/// Runs a scenario that begins with `format` and `name`, so that `text` starts on line 3.
fn refused(text: &str, says: &[&str]) {
    let folder = Folder::new(&format!("scenario-{}", says.concat().replace(|c: char| !c.is_alphanumeric(), "-")));
    folder.file("wrong.toml", format!("format = 1\nname = \"wrong\"\n{text}"));
    folder.ask(&["run", "wrong.toml", "--link", "lockstep", "--json"]).refuses(says);
    folder.ask(&["run", "wrong.toml", "--json"]).refuses(says);
}

#[test]
fn an_unknown_key_a_wrong_type_and_bad_syntax_are_shown_at_their_place() {
    refused(&format!("{MODAL}colour = 3\n"), &["wrong.toml:6:1", "colour", "`torque_nm`"]);
    refused("[modal]\nduration_s = \"long\"\n", &["wrong.toml:4:14", "long"]);
    refused("[modal\n", &["wrong.toml:3:"]);
}

#[test]
fn a_plant_that_cannot_be_flown_is_refused_at_its_place() {
    let modal = |plant: &str| format!("[modal]\nduration_s = 3.0\nplant = {plant}\n");
    refused(&modal("{ file = \"another\" }"), &["wrong.toml:5:18", "another", "cannot be read", "hub_appendage"]);
    let tank = |key: &str| format!("[modal]\nduration_s = 3.0\n[modal.plant]\nfile = \"tank_1d\"\n{key}\n");
    refused(&tank("set.\"fuel.mas\" = \"3 kg\""), &["wrong.toml:7:", "fuel.mas", "fuel.mass"]);
    refused(
        &tank("[modal.plant.set]\n\"fuel.damping.x\" = \"0.1 N*s/m\"\n\"fuel.mass\" = \"3 N\""),
        &["wrong.toml:9:", "fuel.mass", "3 N"],
    );
    let hide = "hide = [\n  \"slosh_cubic@tank:fuel stiffness=0.02\",\n  \"slosh_cubik@tank:fuel\",\n]";
    refused(&tank(hide), &["wrong.toml:9:3", "slosh_cubik", "slosh_cubic"]);
    refused(&tank("text = \"format = 1\""), &["wrong.toml:7:1", "unknown field `text`", "file"]);
    let mated = "[mated]\nduration_s = 3.0\ntrajectory = \"mated\"\nplant = { file = \"mated\" }\ngrasps = \"nothing\"\n[mated.known]\nh_cm_nms = 68.0\nprior = [167.0, 291.0, 416.0, 136.0, 136.0, 158.0, 141.0, 314.0, -18.0]\n";
    refused(mated, &["wrong.toml:6:9", "nothing", "no such body"]);
}

#[test]
fn a_number_that_no_system_has_is_shown_with_its_limit() {
    refused("[modal]\nduration_s = -3.0\n", &["wrong.toml:4:14", "modal.duration_s = -3", "above 0"]);
    refused("[modal]\nduration_s = nan\n", &["wrong.toml:4:14", "NaN"]);
    refused("[modal]\nduration_s = 1e300\n", &["wrong.toml:4:14", "1e300", "10000000"]);
    refused(&format!("{MODAL}pulse_s = -1.0\n"), &["wrong.toml:6:11", "modal.pulse_s", "-1"]);
    refused(&format!("{MODAL}[modal.known]\nrate_hz = 1e5\n"), &["wrong.toml:7:11", "modal.known.rate_hz", "1 to 64"]);
    refused(&format!("{MODAL}[modal.known]\nrate_hz = 33.0\n"), &["wrong.toml:7:11", "whole number of rows"]);
    refused(&format!("{MODAL}[modal.known]\nband_hz = [40.0, 4.0]\n"), &["wrong.toml:7:11", "[40, 4]"]);
    refused(&format!("{MODAL}[modal.known]\nchannels = [0]\n"), &["wrong.toml:7:12", "numbered from 1"]);
    refused(&format!("{MODAL}[modal.need]\nsigma_percent = {{ f7 = 1.0 }}\n"), &["wrong.toml:7:", "f7", "zeta1"]);
    refused(&format!("{SLOSH}[slosh.known]\nm_0_kg = 0.0\n"), &["wrong.toml:7:10", "slosh.known.m_0_kg = 0"]);
    refused(
        &format!("{SLOSH}[slosh.known]\nm_0_kg = 1.0\ninterval_s = 0.013\n"),
        &["wrong.toml:8:14", "0.013", "whole number of frames"],
    );
    refused(&format!("{SLOSH}[slosh.known]\nm_0_kg = 1.0\nexpected = [-1.0, 2.0, 3.0]\n"), &["wrong.toml:8:12", "-1"]);
    refused(&format!("{ARM}prior = [1.0]\n"), &["wrong.toml:9:9", "needs 8 numbers"]);
    refused(&format!("{ARM}{PRIOR}joint_rate_sigma_rad_s = -1.0\n"), &["wrong.toml:10:26", "-1"]);
    refused(&format!("window_frames = 100000\n{MODAL}"), &["wrong.toml:3:17", "at most 102"]);
    refused(&format!("frame_period_ms = 0\n{MODAL}"), &["wrong.toml:3:19", "1 to 1000"]);
    refused(&format!("{MODAL}[capture]\nsettle_s = -5.0\n"), &["wrong.toml:7:12", "-5"]);
    refused(&format!("{MODAL}[capture]\nbase_rate_limit_rad_s = 0.0\n"), &["wrong.toml:7:25", "above 0"]);
}

#[test]
fn every_fault_is_named_at_once() {
    refused(
        &format!("{MODAL}pulse_s = -1.0\n[capture]\nsettle_s = -5.0\n"),
        &["wrong.toml:6:11", "modal.pulse_s", "wrong.toml:8:12", "capture.settle_s"],
    );
}

#[test]
fn a_scenario_that_plans_nothing_or_states_no_plant_is_not_flown() {
    refused("", &["wrong.toml", "plans no experiment", "[modal]"]);
    refused("[modal]\nduration_s = 3.0\n", &["wrong.toml", "modal.plant is missing", "obsid replay"]);
    crate::desk::ask(&["run", &scenario("replay-slab.toml")]).refuses(&["replay-slab.toml", "modal.plant is missing"]);
}

#[test]
fn a_scenario_that_cannot_be_read_is_refused() {
    let folder = Folder::new("scenario-files");
    folder.ask(&["run", "nowhere.toml"]).refuses(&["nowhere.toml", "No such file", "deploy/scenarios"]);
    folder.ask(&["run", "."]).refuses(&["a folder"]);
    folder.file("bytes.toml", [0xff, 0xfe, 0x00]);
    folder.ask(&["run", "bytes.toml"]).refuses(&["bytes.toml:1", "UTF-8", "save it as UTF-8"]);
    folder.file("old.toml", "format = 2\nname = \"x\"\n");
    folder.ask(&["run", "old.toml"]).refuses(&["old.toml:1:10", "format = 2", "format 1"]);
}

#[test]
fn warnings_of_a_scenarios_plant_are_shown() {
    let folder = Folder::new("scenario-warnings");
    let plant = std::fs::read_to_string(crate::desk::workspace().join("deploy/plants/tank_1d.toml")).unwrap();
    let (before, period) = plant.split_once("\nperiod = ").unwrap();
    let rest = period.split_once('\n').unwrap();
    folder.file("doubtful.toml", format!("{before}\nperiod = {}\nstep = \"1000 s\"\n{}", rest.0, rest.1));
    folder.ask(&["plant", "check", "doubtful.toml"]).says(&["longer than its period"]);
    let slosh = "[slosh]\nduration_s = 6.0\nplant = { file = \"doubtful.toml\" }\n[slosh.known]\nm_0_kg = 1000.0\n";
    folder.file("flight.toml", format!("format = 1\nname = \"doubt\"\n{slosh}"));
    folder
        .ask(&["run", "flight.toml", "--link", "lockstep"])
        .says(&["warning: doubtful.toml:", "longer than its period"]);
}

#[test]
fn a_file_wins_over_the_plant_of_its_name_that_comes_with_the_program() {
    let folder = Folder::new("scenario-shadow");
    let plants = crate::desk::workspace().join("deploy/plants");
    std::fs::copy(plants.join("oscillator.toml"), folder.path().join("pendulum")).unwrap();
    let own = folder.ask(&["plant", "check", "pendulum"]).ends_with(0).says(&["'pendulum' is the file pendulum"]);
    let built_in = crate::desk::ask(&["plant", "check", "pendulum"]).ends_with(0);
    assert!(own.stdout != built_in.stdout && built_in.stderr.is_empty(), "{own}{built_in}");
    folder.ask(&["plant", "check", "./oscillator"]).refuses(&["./oscillator", "cannot be read"]);
}
