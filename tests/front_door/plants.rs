//! Plant files through the program: simulated, checked, described, proposed; bad ones refused at
//! their place.

use crate::desk::{Folder, ask, command, number, workspace};
use recording::Imported;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::Stdio;

/// Names of the plants that come with the program.
fn plants() -> Vec<String> {
    let files = std::fs::read_dir(workspace().join("deploy/plants")).unwrap();
    let names = files.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter_map(|name| name.strip_suffix(".toml").map(String::from)).collect();
    names.sort();
    assert!(names.len() >= 16, "{names:?}");
    names
}

/// Channels of a file: name, unit, samples.
fn channels(file: &Path) -> Vec<(String, String, usize)> {
    let set = recording::series(recording::read(file).unwrap()).unwrap();
    set.recording.channels.into_iter().map(|channel| (channel.name, channel.unit, channel.value.len())).collect()
}

fn simulated(folder: &Folder, arguments: &[&str]) -> Value {
    let mut all = vec!["simulate"];
    all.extend(arguments);
    all.push("--json");
    folder.ask(&all).result()
}

#[test]
fn every_plant_is_checked_and_makes_a_second_of_recording() {
    let folder = Folder::new("plants-all");
    for name in plants() {
        let path = workspace().join(format!("deploy/plants/{name}.toml")).display().to_string();
        let answer = ask(&["plant", "check", &path]).ends_with(0);
        assert!(answer.stdout.contains("can be simulated") && answer.stderr.is_empty(), "{answer}");
        // once by its path, once by its name
        let out = format!("{name}.csv");
        let told = simulated(&folder, &[&path, "--duration", "1", "--out", &out]);
        let written = channels(&folder.path().join(&out));
        assert_eq!(told["channels"].as_array().unwrap().len(), written.len(), "{name}");
        for ((channel, unit, samples), row) in written.iter().zip(told["channels"].as_array().unwrap()) {
            assert_eq!(
                (row["name"].as_str(), row["unit"].as_str()),
                (Some(channel.as_str()), Some(unit.as_str())),
                "{name}"
            );
            assert_eq!(number(row, "samples"), *samples as f64, "{name}: {channel}");
            assert!(*samples > 0, "{name}: {channel} is empty");
        }
        let again = simulated(&folder, &[&name, "--duration", "1", "--out", "again.csv"]);
        assert_eq!(again["channels"], told["channels"]);
        assert_eq!(folder.bytes("again.csv"), folder.bytes(&out), "{name}: the same command gives the same bytes");
    }
}

#[test]
fn an_mcap_holds_what_the_csv_holds() {
    let folder = Folder::new("plants-mcap");
    for name in ["study_case", "study_case_spatial"] {
        simulated(&folder, &[name, "--duration", "1", "--out", "a.mcap"]);
        simulated(&folder, &[name, "--duration", "1", "--out", "a.csv.gz"]);
        let of = |file: &str| recording::series(recording::read(&folder.path().join(file)).unwrap()).unwrap();
        let (mcap, csv) = (of("a.mcap"), of("a.csv.gz"));
        assert_eq!(channels(&folder.path().join("a.mcap")), channels(&folder.path().join("a.csv.gz")));
        for (one, other) in mcap.recording.channels.iter().zip(&csv.recording.channels) {
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&one.value), bits(&other.value), "{name}: {}", one.name);
        }
    }
    assert!(matches!(recording::read(&folder.path().join("a.mcap")), Ok(Imported::Series(_))));
}

#[test]
fn the_seed_decides_the_bytes() {
    let folder = Folder::new("plants-seed");
    for (seed, out) in [("5", "a.mcap"), ("5", "b.mcap"), ("6", "c.mcap")] {
        simulated(&folder, &["drive_rig", "--duration", "1", "--seed", seed, "--out", out]);
    }
    assert_eq!(folder.bytes("a.mcap"), folder.bytes("b.mcap"));
    assert_ne!(folder.bytes("a.mcap"), folder.bytes("c.mcap"));
}

#[test]
fn what_is_hidden_changes_values_and_leaves_no_trace() {
    let folder = Folder::new("plants-hidden");
    let hidden = ["joint_coulomb@joint:drive force=0.3", "sensor_bias@sensor:rate bias=0.01"];
    for (out, ending) in [("plain", "csv"), ("plain", "mcap"), ("other", "csv"), ("other", "mcap")] {
        let file = format!("{out}.{ending}");
        let mut arguments = vec!["drive_rig", "--duration", "1", "--out", &file];
        if out == "other" {
            hidden.iter().for_each(|effect| arguments.extend(["--hide", effect]));
        }
        simulated(&folder, &arguments);
    }
    for ending in ["csv", "mcap"] {
        let (plain, other) = (folder.bytes(&format!("plain.{ending}")), folder.bytes(&format!("other.{ending}")));
        assert_ne!(plain, other, "the effects act");
        let text = String::from_utf8_lossy(&other);
        for word in ["joint_coulomb", "coulomb", "sensor_bias", "bias", "force=0.3", "hide", "effect", "seed"] {
            assert!(!text.contains(word), "`{word}` stands in the {ending}");
        }
        let file = |name: &str| folder.path().join(format!("{name}.{ending}"));
        assert_eq!(channels(&file("plain")), channels(&file("other")));
    }
    let first_line = |file: &str| String::from_utf8(folder.bytes(file)).unwrap().lines().next().unwrap().to_owned();
    assert_eq!(first_line("plain.csv"), first_line("other.csv"));
}

#[test]
fn wrong_effects_numbers_and_places_are_refused_before_anything_is_simulated() {
    let folder = Folder::new("plants-wrong");
    let refused = |extra: &[&str], says: &[&str]| {
        let mut arguments = vec!["simulate", "drive_rig", "--out", "x.csv"];
        arguments.extend(extra);
        folder.ask(&arguments).refuses(says);
        assert!(!folder.path().join("x.csv").exists());
    };
    refused(&["--hide", "joint_coulom@joint:drive force=1"], &["--hide", "joint_coulom", "joint_coulomb"]);
    refused(&["--hide", "joint_coulomb@joint:drve force=1"], &["joint:drve", "joint:drive"]);
    refused(&["--hide", "joint_coulomb@joint:drive forse=1"], &["forse", "force"]);
    refused(&["--hide", "joint_coulomb@joint:drive force=much"], &["much"]);
    refused(&["--hide", "joint_coulomb"], &["--hide"]);
    refused(&["--set", "disc.mas = 3 kg"], &["disc.mas", "disc.mass"]);
    refused(&["--set", "disc.mass = 3 N"], &["disc.mass", "N"]);
    refused(&["--set", "disc.mass = -3 kg"], &["mass"]);
    refused(&["--set", "disc.mass"], &["--set", "disc.mass"]);
    refused(&["--duration", "0"], &["--duration 0", "period"]);
    refused(&["--duration", "nan"], &["NaN", "period"]);
    refused(&["--duration", "1e30"], &["--duration", "period"]);
    for (out, says) in
        [("nowhere/x.csv", "folder does not exist"), (".", "no format"), ("x.txt", ".csv.gz"), (".csv", "no format")]
    {
        folder.ask(&["simulate", "drive_rig", "--out", out]).refuses(&["--out", says]);
    }
    folder.ask(&["simulate", "drive_rg", "--out", "x.csv"]).refuses(&["drive_rg", "did you mean 'drive_rig'?"]);
    folder.ask(&["effects", "--plant", "nowhere.toml"]).refuses(&["nowhere.toml", "cannot be read"]);
    folder.ask(&["effects", "joint_colomb"]).refuses(&["joint_colomb", "joint_coulomb"]);
}

/// A file that is well but for one line.
fn bad(name: &str, line: &str, instead: &str, says: &[&str]) {
    const GOOD: &str = include_str!("../../deploy/plants/double_pendulum.toml");
    assert!(GOOD.contains(line), "{line}");
    let folder = Folder::new(&format!("plants-bad-{name}"));
    let text = GOOD.replacen(line, instead, 1);
    // the line of the word that is wrong, wherever the file has it
    let place = |says: &str| {
        says.strip_prefix("bad.toml@").map(|word| 1 + text.lines().position(|l| l.contains(word)).unwrap())
    };
    let says: Vec<String> =
        says.iter().map(|says| place(says).map_or((*says).to_owned(), |line| format!("bad.toml:{line}:"))).collect();
    let says: &[&str] = &says.iter().map(String::as_str).collect::<Vec<_>>();
    folder.file("bad.toml", &text);
    let checked = folder.ask(&["plant", "check", "bad.toml", "--json"]).ends_with(3).says(says).says(&["bad.toml:"]);
    let object = checked.object();
    let errors = object["files"][0]["errors"].as_array().unwrap();
    assert!(!errors.is_empty() && object["files"][0]["usable"] == false, "{object}");
    assert!(errors.iter().all(|error| number(error, "line") > 0.0), "{object}");
    folder.ask(&["simulate", "bad.toml", "--out", "x.csv"]).refuses(says);
    folder.ask(&["plant", "check", "bad.toml"]).refuses(says);
    folder.ask(&["plant", "describe", "bad.toml"]).refuses(says);
}

#[test]
fn bad_files_are_refused_with_the_word_the_line_and_a_suggestion() {
    bad("negative-mass", "\"0.45 kg\"", "\"-0.45 kg\"", &["bad.toml@-0.45 kg", "mass", "-0.45 kg"]);
    bad(
        "unknown-key",
        "inertia = { value = \"2.4e-3",
        "inertai = { value = \"2.4e-3",
        &["bad.toml@inertai", "inertai", "inertia"],
    );
    bad("wrong-dimension", "\"0.3 kg\"", "\"0.3 m\"", &["bad.toml@\"0.3 m\"", "0.3 m", "a length", "in kg"]);
    bad("unknown-parent", "parent = \"upper\"", "parent = \"uper\"", &["bad.toml@uper", "uper", "upper"]);
    bad("unknown-joint", "joint = \"pivot_1\"", "joint = \"pivot_3\"", &["pivot_3", "pivot_"]);
    bad(
        "cycle",
        "name = \"upper\"\n",
        "name = \"upper\"\nparent = \"lower\"\n",
        &["bad.toml@parent = \"lower\"", "lower", "cycle"],
    );
    let effect = |kind: &str, site: &str| format!("[[effect]]\nkind = \"{kind}\"\nsite = \"{site}\"\n\n[simulation]");
    bad(
        "unknown-effect",
        "[simulation]",
        &effect("joint_coulom", "joint:pivot_1"),
        &["bad.toml@joint_coulom", "joint_coulom", "joint_coulomb"],
    );
    bad(
        "unknown-site",
        "[simulation]",
        &effect("joint_coulomb", "joint:pivot_9"),
        &["bad.toml@pivot_9", "pivot_9", "joint:pivot_"],
    );
    bad("syntax", "space = \"planar\"", "space = planar", &["bad.toml@space = planar"]);
}

#[test]
fn an_inertia_that_no_body_has_is_refused() {
    const GOOD: &str = include_str!("../../deploy/plants/rigid_body_imu.toml");
    let folder = Folder::new("plants-triangle");
    folder.file("bad.toml", GOOD.replace("\"0.0265 kg*m^2\"", "\"0.0365 kg*m^2\""));
    folder.ask(&["plant", "check", "bad.toml"]).refuses(&["bad.toml:12:11", "inertia", "triangle"]);
}

#[test]
fn all_errors_of_all_files_come_at_once() {
    let folder = Folder::new("plants-several");
    const GOOD: &str = include_str!("../../deploy/plants/pendulum.toml");
    folder.file("one.toml", GOOD.replace("1.35 kg", "-1.35 kg").replace("kind = \"encoder\"", "kind = \"encodr\""));
    folder.file("two.toml", GOOD.replace("\"10 ms\"", "\"10 m\""));
    let answer = folder.ask(&["plant", "check", "one.toml", "pendulum", "two.toml", "gone.toml"]).ends_with(3);
    assert!(answer.stdout.starts_with("pendulum: 1 body") && answer.stdout.lines().count() == 1, "{answer}");
    answer.says(&["one.toml:", "-1.35 kg", "encodr", "encoder", "two.toml:", "10 m", "gone.toml", "cannot be read"]);
}

#[test]
fn the_description_of_the_benchmark_arm_says_what_its_momentum_shows() {
    let page = ask(&["plant", "describe", "free_floating_arm"]).ends_with(0);
    for text in ["8 base parameters", "manifold of 7 dimensions: a4·a7 = a5·a6", "423.8", "0.09 deg/sqrt(h)", "110.703"]
    {
        assert!(page.stdout.contains(text), "`{text}` is not in {page}");
    }
    let object = ask(&["plant", "describe", "free_floating_arm", "--json"]).result();
    let span = &object["momentum_span"];
    assert_eq!((number(span, "base_parameters"), number(span, "manifold_dimension")), (8.0, 7.0));
    assert_eq!(span["dependences"][0], "a4·a7 = a5·a6");
    assert_eq!(number(&object["base_parameters"], "count"), 10.0);
    for name in plants() {
        let object = ask(&["plant", "describe", &name, "--json"]).result();
        assert!(number(&object["totals"], "mass_kg") > 0.0, "{name}");
        assert!(ask(&["plant", "describe", &name]).ends_with(0).stdout.contains("base parameter"), "{name}");
    }
}

#[test]
fn parameters_tell_what_an_experiment_would_identify() {
    let object = ask(&["plant", "parameters", "oscillator", "--duration", "8", "--json"]).result();
    let rows = object["parameters"].as_array().unwrap();
    let row = |name: &str| rows.iter().find(|row| row["name"] == name).unwrap_or_else(|| panic!("{name}: {object}"));
    for name in ["carriage.mass", "rail.stiffness", "rail.friction"] {
        assert!(number(row(name), "expected_sigma") < number(row(name), "prior_sigma"), "{name}");
        assert_eq!(row(name)["identifiability"], "identified");
    }
    assert!(row("shaker.noise")["prior_sigma"].is_null() && row("shaker.noise")["expected_sigma"].is_null());
    let page = ask(&["plant", "parameters", "mated", "--duration", "2"]).ends_with(0);
    assert!(page.stdout.contains("not shown by this experiment") && page.stderr.is_empty(), "{page}");
}

#[test]
fn effects_as_json_are_what_the_catalogue_promises() {
    let all = ask(&["effects", "--json"]).result();
    let effects = all["effects"].as_array().unwrap();
    assert!(effects.len() > 80);
    for effect in effects {
        let kind = effect["kind"].as_str().unwrap();
        assert!(kind.chars().all(|c| c.is_ascii_lowercase() || c == '_' || c.is_ascii_digit()), "{kind}");
        for parameter in effect["parameters"].as_array().unwrap() {
            assert!(parameter["name"].is_string() && parameter["unit"].is_string(), "{kind}");
            let [low, high, default] = ["low", "high", "default"].map(|key| number(parameter, key));
            assert!(low <= default && default <= high, "{kind}: {parameter}");
        }
    }
    let of_plant = ask(&["effects", "--plant", "drive_rig", "--json"]).result();
    let coulomb =
        of_plant["effects"].as_array().unwrap().iter().find(|effect| effect["kind"] == "joint_coulomb").unwrap();
    assert_eq!(coulomb["sites"], serde_json::json!(["joint:drive"]));
    assert_eq!(coulomb["parameters"][0]["unit"], "N*m");
}

/// A proposal with every place filled in, as a user would who knows nothing but ones.
fn filled(folder: &Folder, name: &str) {
    let text = String::from_utf8(folder.bytes(name)).unwrap();
    folder.file(name, text.replace("\"? ", "\"1 ").replace("\"?\"", "\"x\""));
}

#[test]
fn a_recording_becomes_a_plant_file_that_can_be_checked_and_simulated() {
    let folder = Folder::new("plants-new");
    for name in plants() {
        simulated(&folder, &[&name, "--duration", "2", "--out", "rig.csv"]);
        let out = format!("{name}.toml");
        let answer = folder.ask(&["plant", "new", "rig.csv", "--out", &out]).ends_with(0);
        assert!(answer.stdout.contains("FILL IN"), "{answer}");
        filled(&folder, &out);
        folder.ask(&["plant", "check", &out]).ends_with(0);
        simulated(&folder, &[&out, "--duration", "1", "--out", "back.csv"]);
    }
    folder.ask(&["plant", "new", "rig.csv", "--out", "pendulum.toml"]).refuses(&["pendulum.toml", "exists"]);
    folder.ask(&["plant", "new", "nothing.csv", "--out", "x.toml"]).refuses(&["nothing.csv"]);
    folder.file("dull.csv", "time [s],pressure [Pa]\n0,1\n1,2\n2,3\n");
    folder.ask(&["plant", "new", "dull.csv", "--out", "x.toml"]).refuses(&["dull.csv", "says anything of motion"]);
}

/// A log of a drive: angle without a unit, torque commanded and measured.
fn drive_log() -> String {
    let row = |k: i32| {
        let t = f64::from(k) * 0.01;
        format!("{t:.2},{},{:.3},{:.4}\n", f64::from(k / 50 % 2), (7.0 * t).sin(), (2.0 * t).sin())
    };
    "time [s],tau_cmd [N*m],tau_fb [N*m],angle\n".to_owned() + &(0..400).map(row).collect::<String>()
}

#[test]
fn what_only_the_user_knows_is_a_blank_that_a_diagnosis_refuses_with_its_line() {
    let folder = Folder::new("plants-blanks");
    folder.file("log.csv", drive_log());
    let angle = ["--channel", "angle = angle [rad]"];
    let new = [&["plant", "new", "log.csv", "--out", "rig.toml", "--json"][..], &angle].concat();
    let object = folder.ask(&new).result();
    assert!(object["to_fill_in"].as_u64().unwrap() >= 3, "{object}");
    let text = String::from_utf8(folder.bytes("rig.toml")).unwrap();
    assert!(!text.contains('%') && text.contains("mass = { value = \"? kg\""), "{text}");
    let line = text.lines().position(|line| line.contains("\"? kg\"")).unwrap() + 1;
    folder.ask(&[&["diagnose", "log.csv", "--plant", "rig.toml"][..], &angle].concat()).refuses(&[
        &format!("rig.toml:{line}:"),
        "mass of body 'part_1' is not filled in",
        "inertia of body 'part_1' is not filled in",
    ]);
}

#[test]
fn a_proposal_believes_the_user_and_asks_for_what_no_name_and_no_unit_tells() {
    let folder = Folder::new("plants-told");
    folder.file("log.csv", drive_log());
    let new =
        |more: &[&str]| folder.ask(&[&["plant", "new", "log.csv", "--out", "rig.toml", "--json"][..], more].concat());
    // nothing tells of motion but a channel without a unit
    new(&["--measured", "tau_cmd", "--command", "tau_fb"]).refuses(&["says anything of motion"]);
    new(&["--measured", "angle"]).refuses(&["'angle'", "does not state its unit", "--channel 'angle = angle [UNIT]'"]);
    new(&["--command", "tau_comd"]).refuses(&["tau_comd", "did you mean 'tau_cmd'?"]);
    let roles = |more: &[&str]| {
        let object = new(&[&["--channel", "angle = angle [deg]"], more].concat()).result();
        std::fs::remove_file(folder.path().join("rig.toml")).unwrap();
        let role = |name: &str| {
            let channels = object["channels"].as_array().unwrap();
            channels.iter().find(|channel| channel["name"] == name).unwrap()["taken_for"].as_str().unwrap().to_owned()
        };
        ["tau_cmd", "tau_fb", "angle"].map(role)
    };
    assert_eq!(roles(&[]), ["command", "torque", "angle"]);
    assert_eq!(roles(&["--command", "tau_fb", "--measured", "tau_cmd"]), ["torque", "command", "angle"]);
}

#[test]
fn a_reader_that_goes_away_ends_the_verbs_quietly() {
    for arguments in
        [&["effects"][..], &["plant", "describe", "study_case"], &["plant", "parameters", "tank_1d", "--duration", "1"]]
    {
        let mut child = command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::with_capacity(1, child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        assert!(!line.is_empty());
        let mut stderr = String::new();
        child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
        let status = child.wait().unwrap();
        assert!(status.success() && stderr.is_empty(), "{arguments:?} {status}: {stderr}");
    }
}

#[test]
fn the_dynamics_benchmark_allocates_nothing_a_step() {
    let object = ask(&["bench", "dynamics", "--json"]).result();
    let cases = object["cases"].as_array().unwrap();
    assert!(cases.len() >= 10);
    for case in cases {
        assert!(number(case, "ns_per_call") > 0.0, "{case}");
        assert_eq!(number(case, "allocations"), 0.0, "{case}");
    }
}
