//! `obsid diagnose`: what a user is told is missing from a plant, on recordings that the program
//! made itself.

use crate::desk::{Folder, number, workspace};
use serde_json::Value;

const VERDICTS: [&str; 8] =
    ["none", "named", "not_separable", "not_in_catalogue", "noise_model", "sensor", "unobservable", "cannot_decide"];
/// Dry friction of 50 mN m in a pivot that the plant file gives 1.5 mN m s/rad.
const FRICTION: &str = "joint_coulomb@joint:pivot force=0.05";

/// A swing of 8 s at 100 Hz, with what is hidden.
fn swing(folder: &Folder, seed: &str, hide: &[&str], out: &str) {
    let mut arguments = vec!["simulate", "pendulum", "--duration", "8", "--seed", seed, "--out", out];
    hide.iter().for_each(|effect| arguments.extend(["--hide", effect]));
    folder.ask(&arguments).ends_with(0);
}

fn diagnosed(folder: &Folder, arguments: &[&str]) -> Value {
    let all: Vec<&str> = ["diagnose"].iter().chain(arguments).chain(&["--quiet", "--json"]).copied().collect();
    let answer = folder.ask(&all).ends_with(0);
    assert!(answer.stderr.is_empty(), "{answer}");
    answer.object()
}

/// First names and rivals of all effects that stand.
fn names(result: &Value) -> Vec<String> {
    let name = |row: &Value| format!("{}@{}", row["kind"].as_str().unwrap(), row["site"].as_str().unwrap());
    let effects = result["effects"].as_array().unwrap();
    let rivals = effects.iter().flat_map(|effect| effect["rivals"].as_array().unwrap());
    effects.iter().chain(rivals).map(name).collect()
}

/// Every key of the issue, each with its type.
fn check_object(result: &Value) {
    let text = |row: &Value, keys: &[&str]| keys.iter().for_each(|k| assert!(row[*k].is_string(), "{k} of {row}"));
    let numbers = |row: &Value, keys: &[&str]| keys.iter().for_each(|k| assert!(row[*k].is_number(), "{k} of {row}"));
    let rows = |value: &Value| value.as_array().unwrap_or_else(|| panic!("no list: {value}")).clone();
    let pair =
        |value: &Value| assert!(rows(value).len() == 2 && value[0].is_number() && value[1].is_number(), "{value}");
    text(result, &["verdict", "reason", "command"]);
    let answer = rows(&result["answer"]);
    assert!(answer.len() == 3 && answer.iter().all(|s| s.as_str().is_some_and(|s| s.ends_with('.'))), "{answer:?}");
    assert!(VERDICTS.contains(&result["verdict"].as_str().unwrap()), "{}", result["verdict"]);
    for row in rows(&result["doctor"]) {
        text(&row, &["check", "channel", "unit", "evidence", "cure", "recording", "severity"]);
        numbers(&row, &["value"]);
    }
    for row in rows(&result["compare"]["channels"]) {
        text(&row, &["name"]);
        numbers(&row, &["rms", "fit_percent"]);
    }
    for row in rows(&result["where"]) {
        text(&row, &["channel", "site"]);
        numbers(&row, &["p"]);
        pair(&row["time"]);
        pair(&row["band_hz"]);
        rows(&row["states"]);
    }
    for row in rows(&result["effects"]) {
        text(&row, &["kind", "site"]);
        numbers(&row, &["probability", "kappa", "d"]);
        let status = row["status"].as_str().unwrap();
        assert!(["confirmed", "unconfirmed", "rejected", "not_converged"].contains(&status), "{status}");
        for rival in rows(&row["rivals"]) {
            text(&rival, &["kind", "site", "reason"]);
            numbers(&rival, &["probability"]);
        }
        for parameter in rows(&row["parameters"]) {
            text(&parameter, &["name", "unit"]);
            numbers(&parameter, &["value", "sigma"]);
        }
    }
    for row in rows(&result["nominal"]) {
        text(&row, &["name"]);
        numbers(&row, &["before", "after", "sigma", "shift_sigma"]);
    }
    let held = &result["held_out"];
    assert!(["recording", "blocks", "none"].contains(&held["kind"].as_str().unwrap()), "{held}");
    for row in rows(&held["channels"]) {
        text(&row, &["name"]);
        numbers(&row, &["fit_percent_before", "fit_percent_after", "rms_before", "rms_after"]);
    }
    for key in ["loglik_gain", "gain_se", "whiteness_p_before", "whiteness_p_after"] {
        assert!(held.get(key).is_some_and(|v| v.is_number() || v.is_null()), "{key} of {held}");
    }
    assert!(held["gain_ci95"].is_null() || rows(&held["gain_ci95"]).len() == 2, "{held}");
    for row in rows(&result["detection_limits"]) {
        text(&row, &["kind", "site", "unit"]);
        numbers(&row, &["amplitude"]);
    }
    for key in ["next_experiment", "augmented_plant", "report"] {
        assert!(result.get(key).is_some_and(|v| v.is_string() || v.is_null()), "{key}");
    }
}

#[test]
fn hidden_friction_is_named_shown_on_another_recording_and_written_into_a_plant_that_has_it() {
    let folder = Folder::new("diagnose-friction");
    swing(&folder, "1", &[FRICTION], "swing.csv");
    swing(&folder, "2", &[FRICTION], "other.mcap");
    let arguments = ["swing.csv", "--plant", "pendulum", "--held-out", "other.mcap", "--out", "out/report"];
    let result = diagnosed(&folder, &arguments);
    check_object(&result);
    assert!(names(&result).contains(&"joint_coulomb@joint:pivot".into()), "{result}");
    assert_eq!(result["held_out"]["kind"], "recording");
    assert_eq!(result["report"], "out/report/report.html");
    let written: Value = serde_json::from_slice(&folder.bytes("out/report/diagnosis.json")).unwrap();
    assert_eq!(written, result);
    let page = String::from_utf8(folder.bytes("out/report/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    for text in ["joint:pivot", "swing.csv", "other.mcap", "obsid diagnose swing.csv --plant pendulum"] {
        assert!(page.contains(text), "the page does not say `{text}`");
    }
    for outside in ["http:", "https:", "<script ", "NaN"] {
        assert!(!page.contains(outside), "the page has {outside}");
    }
    assert_eq!(result["effects"][0]["status"], "confirmed", "{result}");
    let gain = &result["held_out"]["channels"][0];
    assert!(number(gain, "fit_percent_after") > number(gain, "fit_percent_before"), "{result}");
    let augmented = result["augmented_plant"].as_str().unwrap();
    folder.ask(&["plant", "check", augmented]).ends_with(0);
    folder.ask(&["simulate", augmented, "--duration", "8", "--seed", "3", "--out", "own.csv"]).ends_with(0);
    let own = diagnosed(&folder, &["own.csv", "--plant", augmented]);
    assert_eq!((own["verdict"].as_str(), names(&own).len()), (Some("none"), 0), "its own recording: {own}");
    // what an earlier diagnosis left does not stand beside this one
    swing(&folder, "4", &[], "sound.csv");
    let silent = diagnosed(&folder, &["sound.csv", "--plant", "pendulum", "--out", "out/report"]);
    assert!(silent["augmented_plant"].is_null() && !folder.path().join("out/report/augmented.toml").exists());
    folder.ask(&["diagnose", "own.csv", "--plant", "out/report/augmented.toml"]).refuses(&["augmented.toml"]);
}

#[test]
fn where_nothing_is_missing_nothing_is_named_and_nothing_is_written() {
    let folder = Folder::new("diagnose-null");
    for seed in ["5", "6", "7"] {
        swing(&folder, seed, &[], "sound.csv");
        let result = diagnosed(&folder, &["sound.csv", "--plant", "pendulum"]);
        check_object(&result);
        assert_eq!((result["verdict"].as_str(), names(&result).len()), (Some("none"), 0), "seed {seed}: {result}");
        assert!(result["augmented_plant"].is_null() && result["report"].is_null());
        assert!(!result["detection_limits"].as_array().unwrap().is_empty(), "{result}");
    }
    let told = folder.ask(&["diagnose", "sound.csv", "--plant", "pendulum"]).ends_with(0);
    for text in [
        "sound.csv: 1 channel, 800 samples",
        "lacks nothing",
        "verdict: nothing is missing",
        "--- details ---",
        "the least size that would have been found",
    ] {
        assert!(told.stdout.contains(text), "`{text}` is not in {told}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn the_same_command_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new("diagnose-same");
    swing(&folder, "8", &[], "sound.csv");
    let ask = |threads| {
        let answer =
            folder.ask(&["diagnose", "sound.csv", "--plant", "pendulum", "--out", "r", "--json", "--threads", threads]);
        (answer.ends_with(0).stdout, folder.bytes("r/report.html"), folder.bytes("r/diagnosis.json"))
    };
    assert!(ask("1") == ask("3"));
}

#[test]
fn a_map_joins_other_names_units_and_signs() {
    let folder = Folder::new("diagnose-map");
    swing(&folder, "9", &[], "sound.csv");
    let text = String::from_utf8(folder.bytes("sound.csv")).unwrap();
    let mut turned = String::from("time [s],enc 1 [-],load [V]\n");
    for line in text.lines().skip(1) {
        let (time, value) = line.split_once(',').unwrap();
        turned += &format!("{time},{:e},0.5\n", -value.parse::<f64>().unwrap().to_degrees());
    }
    folder.file("turned.csv", turned);
    folder.file("map.toml", "[channels]\nangle = { name = \"enc 1\", scale = -1, unit = \"deg\" }\n");
    let plain = diagnosed(&folder, &["sound.csv", "--plant", "pendulum"]);
    let mapped = diagnosed(&folder, &["turned.csv", "--plant", "pendulum", "--map", "map.toml"]);
    assert_eq!(mapped["verdict"], plain["verdict"]);
    let fit = |result: &Value| number(&result["compare"]["channels"][0], "rms");
    // there and back in degrees: rounding of the numbers, far below the encoder's 0.2 mrad
    assert!((fit(&mapped) - fit(&plain)).abs() < 1e-6 * fit(&plain), "{} {}", fit(&mapped), fit(&plain));
    let without = folder.ask(&["diagnose", "turned.csv", "--plant", "pendulum"]);
    without.refuses(&["turned.csv", "enc 1", "angle", "--map"]);
}

#[test]
fn a_file_of_two_swings_is_two_recordings_and_two_files_are_fitted_jointly() {
    let folder = Folder::new("diagnose-several");
    swing(&folder, "10", &[], "a.csv");
    swing(&folder, "11", &[], "b.csv");
    let text = |name: &str| String::from_utf8(folder.bytes(name)).unwrap();
    let second = text("b.csv");
    folder.file("both.csv", format!("{}{}", text("a.csv"), second.split_once('\n').unwrap().1));
    let one = diagnosed(&folder, &["both.csv", "--plant", "pendulum"]);
    let two = diagnosed(&folder, &["a.csv", "b.csv", "--plant", "pendulum"]);
    let recordings = |result: &Value| result["recordings"].as_array().unwrap().len();
    assert_eq!((recordings(&one), recordings(&two)), (2, 2));
    assert_eq!(one["recordings"][1]["name"], "both.csv, part 2");
    for key in ["verdict", "nominal", "effects", "detection_limits"] {
        assert_eq!(one[key], two[key], "{key}");
    }
    // a bias and a start of its own for each
    assert_eq!(
        one["nominal"].as_array().unwrap().iter().filter(|n| n["name"].as_str().unwrap().contains("bias")).count(),
        2
    );
}

#[test]
fn evidence_over_frequency_is_an_answer_and_no_time_record() {
    let folder = Folder::new("diagnose-spectrum");
    let rows: String = (0..200).map(|i| format!("{},{}\n", f64::from(i) * 0.5, 1.0 / f64::from(i + 1))).collect();
    folder.file("frf.csv", format!("frequency [Hz],accelerance [m/s^2/N]\n{rows}"));
    let result = diagnosed(&folder, &["frf.csv", "--plant", "pendulum"]);
    check_object(&result);
    assert!(!result["reason"].as_str().unwrap().is_empty() && result["augmented_plant"].is_null());
    swing(&folder, "1", &[], "sound.csv");
    folder
        .ask(&["diagnose", "frf.csv", "sound.csv", "--plant", "pendulum"])
        .refuses(&["frf.csv is a spectrum", "apart"]);
    folder
        .ask(&["diagnose", "sound.csv", "--plant", "pendulum", "--held-out", "frf.csv"])
        .refuses(&["--held-out frf.csv", "spectrum"]);
    folder.ask(&["diagnose", "frf.csv", "--plant", "pendulum", "--held-out", "sound.csv"]).refuses(&[
        "--held-out",
        "a spectrum",
        "leave",
    ]);
}

#[test]
fn what_cannot_be_used_is_refused_with_its_place_and_a_cure() {
    let folder = Folder::new("diagnose-wrong");
    swing(&folder, "1", &[], "sound.csv");
    let refused = |arguments: &[&str], says: &[&str]| {
        let all: Vec<&str> = ["diagnose"].iter().chain(arguments).copied().collect();
        folder.ask(&all).refuses(says);
    };
    refused(&["gone.csv", "--plant", "pendulum"], &["gone.csv", "No such file"]);
    refused(&["sound.csv", "--plant", "pendulm"], &["pendulm", "did you mean 'pendulum'?"]);
    folder.file("empty.csv", "");
    refused(&["empty.csv", "--plant", "pendulum"], &["empty.csv", "empty"]);
    folder.file("short.csv", "time [s],angle [rad]\n0,0.1\n");
    refused(&["short.csv", "--plant", "pendulum"], &["short.csv"]);
    folder.file("words.csv", "time [s],angle [rad]\n0,0.1\n0.01,much\n");
    refused(&["words.csv", "--plant", "pendulum"], &["words.csv", "line 3", "much"]);
    folder.file("metres.csv", "time [s],angle [m]\n0,0.1\n0.01,0.1\n0.02,0.2\n");
    refused(&["metres.csv", "--plant", "pendulum"], &["angle", "metres.csv", "rad", "unit = "]);
    folder.file("other.csv", "time [s],pressure [Pa]\n0,1\n0.01,2\n0.02,2\n");
    refused(&["sound.csv", "--plant", "pendulum", "--held-out", "other.csv"], &["other.csv", "pressure", "angle"]);
    refused(&["sound.csv", "--plant", "pendulum", "--repeat", "other.csv"], &["other.csv", "pressure", "angle"]);
    refused(&["sound.csv", "--plant", "pendulum", "--held-out", "sound.csv"], &["--held-out sound.csv", "same bytes"]);
    refused(&["sound.csv", "--plant", "tank_1d"], &["sound.csv", "angle", "--map"]);
    folder.file("map.toml", "[channels]\nangel = \"angle\"\n");
    refused(
        &["sound.csv", "--plant", "pendulum", "--map", "map.toml"],
        &["map.toml: line 2, column 1", "did you mean 'angle'?"],
    );
    folder.file("far.toml", "[channels]\nangle = \"angel\"\n");
    refused(
        &["sound.csv", "--plant", "pendulum", "--map", "far.toml"],
        &["far.toml: line 2, column 9", "did you mean `angle`?"],
    );
    refused(&["sound.csv", "--plant", "pendulum", "--map", "gone.toml"], &["gone.toml", "--map"]);
    folder.file("bytes.toml", [b'a', b'\n', 0xff]);
    refused(&["sound.csv", "--plant", "pendulum", "--map", "bytes.toml"], &["bytes.toml:2", "UTF-8"]);
    refused(&["sound.csv", "--plant", "bytes.toml"], &["bytes.toml:2", "UTF-8"]);
    refused(&["sound.csv", "--plant", "pendulum", "--out", "sound.csv"], &["--out sound.csv"]);
    std::fs::copy(workspace().join("deploy/plants/pendulum.toml"), folder.path().join("augmented.toml")).unwrap();
    refused(&["sound.csv", "--plant", "augmented.toml", "--out", "."], &["--out .", "write over augmented.toml"]);
}

#[test]
fn a_channel_that_is_missing_is_named_with_the_line_of_a_map() {
    let folder = Folder::new("diagnose-missing");
    folder.ask(&["simulate", "drive_rig", "--duration", "2", "--out", "rig.csv"]).ends_with(0);
    let text = String::from_utf8(folder.bytes("rig.csv")).unwrap();
    folder.file("renamed.csv", text.replacen("angle", "angle_1", 1));
    let answer = folder.ask(&["diagnose", "renamed.csv", "--plant", "drive_rig"]);
    answer.refuses(&["renamed.csv", "no channel 'angle'", "angle = \"angle_1\""]);
}

#[test]
fn modes_that_drift_are_evidence_in_the_list_that_modal_prints_and_those_that_do_not_raise_no_alarm() {
    let folder = Folder::new("diagnose-modes");
    let list = |name: &str, hide: &[&str]| {
        let mut simulate = vec!["simulate", "hub_appendage", "--seed", "3", "--out", "panel.csv"];
        hide.iter().for_each(|effect| simulate.extend(["--hide", effect]));
        folder.ask(&simulate).ends_with(0);
        let channels: Vec<String> = (1..=10).map(|k| format!("acceleration_{k}")).collect();
        let answer = folder
            .ask(&["modal", "panel.csv", "--input", "torque", "--channels", &channels.join(","), "--json"])
            .ends_with(0);
        std::fs::write(folder.path().join(name), &answer.stdout).unwrap();
        answer.object()
    };
    let written = list("linear.json", &[]);
    assert!(written["tracks"].as_array().unwrap().len() == 2, "{}", written["tracks"]);
    let linear = diagnosed(&folder, &["linear.json", "--plant", "hub_appendage"]);
    check_object(&linear);
    assert!(
        linear["notes"].as_array().unwrap().iter().any(|n| n.as_str().unwrap().contains("none drifts")),
        "{linear}"
    );
    list("cubic.json", &["mode_duffing@mode:bending_1 stiffness=4000"]);
    let cubic = diagnosed(&folder, &["cubic.json", "--plant", "hub_appendage"]);
    check_object(&cubic);
    assert_eq!(cubic["verdict"], "not_in_catalogue", "{cubic}");
    let reason = cubic["reason"].as_str().unwrap();
    assert!(reason.contains("frequency of the mode at 1.56") && reason.contains("is not constant"), "{reason}");
    folder
        .ask(&["diagnose", "cubic.json", "panel.csv", "--plant", "hub_appendage"])
        .refuses(&["cubic.json", "on its own"]);
    for flag in ["--held-out", "--repeat"] {
        folder.ask(&["diagnose", "cubic.json", "--plant", "hub_appendage", flag, "panel.csv"]).refuses(&[
            "--held-out",
            "a list of modes",
            "leave",
        ]);
    }
    folder.file("map.toml", "[channels]\nacceleration_1 = \"a\"\n");
    folder.ask(&["diagnose", "cubic.json", "--plant", "hub_appendage", "--map", "map.toml"]).refuses(&[
        "--map",
        "a list of modes",
        "leave",
    ]);
}
