//! `obsid doctor` and `obsid compare`: what a user is told about recordings, with exit codes, keys
//! and pages.

use crate::desk::{Answer, Folder, ask};
use serde_json::Value;

/// A noise that repeats, in [-1, 1).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }
}

/// Samples at 50 Hz of two tones, given by its `value` of time and noise.
fn csv(header: &str, seed: u64, value: impl Fn(f64, &mut Noise) -> String) -> String {
    let mut noise = Noise(seed);
    let row = |i: u32| {
        let t_s = f64::from(i) * 0.02;
        format!("{t_s:.3},{}\n", value(t_s, &mut noise))
    };
    format!("{header}\n{}", (0..3000).map(row).collect::<String>())
}

fn swing(t_s: f64) -> f64 {
    (2.0 * t_s).sin() + 0.3 * (9.1 * t_s).cos()
}

/// A sound recording, and one that follows it by 60 ms.
fn pair(folder: &Folder) {
    let sound = |seed, lag: f64| {
        csv("time [s],angle [rad]", seed, move |t, n| format!("{:.9}", swing(t - lag) + 0.002 * n.next()))
    };
    folder.file("real.csv", sound(1, 0.06));
    folder.file("simulated.csv", sound(2, 0.0));
}

fn findings(result: &Value) -> &Vec<Value> {
    result["doctor"].as_array().unwrap()
}

/// Whether a finding of `check` concerns `channel`.
fn has(result: &Value, check: &str, channel: &str) -> bool {
    let concerns = |f: &Value| f["channel"] == channel || f["others"].as_array().unwrap().iter().any(|o| o == channel);
    findings(result).iter().any(|f| f["check"] == check && concerns(f))
}

fn is_whole_page(folder: &Folder, path: &str, says: &[&str]) {
    let page = String::from_utf8(folder.bytes(path)).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"), "{path}");
    // the page's own script is in the page
    for outside in ["http:", "https:", "<script src", "<link", "@import", "NaN"] {
        assert!(!page.contains(outside), "{path} has {outside}");
    }
    for text in says {
        assert!(page.contains(text), "{path} does not say `{text}`");
    }
}

#[test]
fn a_copied_and_a_dead_channel_are_named_with_evidence_and_cure_and_a_sound_one_is_not() {
    let folder = Folder::new("doctor");
    let header = "time [s],angle [rad],again [rad],dead [V],rate [rad/s]";
    folder.file(
        "rig.csv",
        csv(header, 5, |t, n| {
            let angle = swing(t) + 0.002 * n.next();
            let rate = 2.0 * (2.0 * t).cos() - 2.73 * (9.1 * t).sin() + 0.002 * n.next();
            format!("{angle:.9},{:.9},0.5,{rate:.9}", 2.0 * angle)
        }),
    );
    let result = folder.ask(&["doctor", "rig.csv", "--json"]).result();
    assert!(has(&result, "copied", "again") && !has(&result, "derived", "again"), "{result}");
    assert!(has(&result, "constant", "dead"), "{result}");
    assert!(!has(&result, "derived", "rate") && !has(&result, "copied", "rate"), "{result}");
    for finding in findings(&result) {
        for key in ["recording", "check", "severity", "channel", "unit", "evidence", "cure"] {
            assert!(finding[key].as_str().is_some(), "{key} of {finding}");
        }
        assert!(!finding["evidence"].as_str().unwrap().is_empty() && !finding["cure"].as_str().unwrap().is_empty());
        assert!(finding["value"].is_number() && finding["recording"] == "rig.csv", "{finding}");
    }
    assert!(result["report"].is_null());
    let Answer { stdout, .. } = folder.ask(&["doctor", "rig.csv"]).ends_with(0);
    for text in
        ["rig.csv: 4 channels, 3000 samples over 59.98 s at 50 Hz", "constant", "cure: ", "all 3000 samples are 0.5"]
    {
        assert!(stdout.contains(text), "`{text}` is not in {stdout}");
    }
}

#[test]
fn a_report_of_the_doctor_is_one_page_and_the_same_every_time() {
    let folder = Folder::new("doctor-page");
    pair(&folder);
    let ask = || folder.ask(&["doctor", "real.csv", "simulated.csv", "--out", "a/b", "--json"]).result();
    assert_eq!(ask()["report"], "a/b/doctor.html");
    let first = folder.bytes("a/b/doctor.html");
    ask();
    assert!(first == folder.bytes("a/b/doctor.html"));
    is_whole_page(&folder, "a/b/doctor.html", &["real.csv", "simulated.csv", "obsid doctor real.csv", "<svg"]);
    folder.ask(&["doctor", "real.csv", "--out", "real.csv"]).refuses(&["--out real.csv"]);
}

#[test]
fn the_plant_says_what_is_an_input_and_names_that_do_not_meet_are_told() {
    let folder = Folder::new("doctor-plant");
    folder.ask(&["simulate", "drive_rig", "--duration", "4", "--out", "rig.csv"]).ends_with(0);
    let result = folder.ask(&["doctor", "rig.csv", "--plant", "drive_rig", "--json"]).result();
    let channels = result["recordings"][0]["channels"].as_array().unwrap();
    let roles: Vec<(&str, &str)> =
        channels.iter().map(|c| (c["name"].as_str().unwrap(), c["role"].as_str().unwrap())).collect();
    assert_eq!(roles, [("motor", "input"), ("angle", "output"), ("rate", "output")]);
    assert!(!findings(&result).iter().any(|f| f["severity"] == "fault"), "a sound recording: {result}");
    let renamed = String::from_utf8(folder.bytes("rig.csv")).unwrap().replacen("angle [", "angel [", 1);
    folder.file("renamed.csv", renamed);
    let notes = folder.ask(&["doctor", "renamed.csv", "--plant", "drive_rig", "--json"]).result();
    let notes = notes["recordings"][0]["notes"].to_string();
    assert!(notes.contains("'angel'") && notes.contains("is it 'angle'?"), "{notes}");
    folder.ask(&["doctor", "rig.csv", "--plant", "pendulum_on_mars"]).refuses(&["pendulum_on_mars"]);
    folder.ask(&["doctor", "rig.csv", "--plant", "tank_1d"]).refuses(&["motor, angle, rate", "thrust, accelerometer"]);
}

#[test]
fn what_a_diagnosis_would_refuse_is_a_fault_of_the_doctor_with_the_cure() {
    let folder = Folder::new("doctor-refused");
    folder.ask(&["simulate", "drive_rig", "--duration", "4", "--out", "rig.csv"]).ends_with(0);
    let sound = String::from_utf8(folder.bytes("rig.csv")).unwrap();
    folder.file("kg.csv", sound.replacen("angle [rad]", "angle [kg]", 1));
    folder.file("renamed.csv", sound.replacen("angle [", "angel [", 1));
    for (file, check, cure) in
        [("kg.csv", "units", "unit = \"rad\""), ("renamed.csv", "missing", "[channels] angle = \"angel\"")]
    {
        folder.ask(&["diagnose", file, "--plant", "drive_rig"]).ends_with(3);
        let result = folder.ask(&["doctor", file, "--plant", "drive_rig", "--json"]).result();
        let fault = findings(&result).iter().find(|f| f["check"] == check && f["severity"] == "fault");
        let fault = fault.unwrap_or_else(|| panic!("{file}: {result}"));
        assert!(fault["channel"] == "angle" && fault["cure"].as_str().unwrap().contains(cure), "{fault}");
        let Answer { stdout, .. } = folder.ask(&["doctor", file, "--plant", "drive_rig"]).ends_with(0);
        assert!(stdout.contains("cure the faults first") && !stdout.contains("nothing found"), "{stdout}");
    }
}

#[test]
fn neither_a_dead_channel_nor_a_handful_of_samples_can_be_used_as_they_are() {
    let folder = Folder::new("doctor-little");
    folder.file("dead.csv", csv("time [s],angle [rad]", 1, |_, _| "4.0".into()));
    folder.file("two.csv", "time [s],angle [rad]\n0,1\n0.1,1.2\n");
    for (file, says) in [("dead.csv", "all 3000 samples are 4"), ("two.csv", "2 samples: the level of their noise")] {
        let Answer { stdout, .. } = folder.ask(&["doctor", file]).ends_with(0);
        assert!(stdout.contains(says) && !stdout.contains("as they are"), "{stdout}");
    }
}

#[test]
fn recordings_one_after_another_in_a_file_are_examined_one_by_one() {
    let folder = Folder::new("doctor-parts");
    let once = csv("time [s],height [m]", 3, |t, n| format!("{:.6}", 20.0 - 0.5 * t * t + 0.01 * n.next()));
    let rows = once.split_once('\n').unwrap().1;
    folder.file("drops.csv", format!("{once}{rows}"));
    let result = folder.ask(&["doctor", "drops.csv", "--json"]).result();
    let names: Vec<&str> =
        result["recordings"].as_array().unwrap().iter().map(|r| r["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["drops.csv, part 1", "drops.csv, part 2"]);
}

#[test]
fn a_lag_is_concluded_with_its_size_and_its_sigma() {
    let folder = Folder::new("compare");
    pair(&folder);
    let answer = folder.ask(&["compare", "real.csv", "simulated.csv", "--json", "--out", "."]);
    let result = answer.result();
    assert_eq!(result["report"], "./compare.html");
    is_whole_page(&folder, "compare.html", &["real.csv against simulated.csv", "differs by a lag of", "<svg"]);
    let channel = &result["compare"]["channels"][0];
    assert_eq!((channel["name"].as_str(), channel["verdict"].as_str()), (Some("angle"), Some("lag")));
    let number = |key: &str| channel[key].as_f64().unwrap_or_else(|| panic!("{key} of {channel}"));
    assert!((number("lag_s") - 0.06).abs() < 5.0 * number("lag_sigma_s").max(1e-6), "{channel}");
    assert!(number("fit_percent") < number("lag_fit_percent") && number("rms") > 0.01, "{channel}");
    let same = folder.ask(&["compare", "real.csv", "real.csv"]).ends_with(0);
    assert!(same.stdout.contains("identical"), "{same}");
}

#[test]
fn recordings_without_a_common_channel_are_refused_with_the_names_of_both_sides() {
    let folder = Folder::new("compare-names");
    pair(&folder);
    folder.file("other.csv", csv("time [s],anglle [rad]", 1, |t, _| format!("{:.6}", swing(t))));
    folder.ask(&["compare", "real.csv", "other.csv", "--json"]).refuses(&[
        "no common channel",
        "real.csv has angle",
        "other.csv has anglle",
        "is 'anglle' the simulated 'angle'?",
    ]);
    folder.file("short.csv", "time [s],angle [rad]\n0,1\n1,2\n2,3\n");
    folder.file("spectrum.csv", "frequency [Hz],a [m]\n0,1\n1,2\n2,3\n");
    folder.ask(&["compare", "real.csv", "nowhere.csv"]).refuses(&["nowhere.csv"]);
    folder.ask(&["doctor", "spectrum.csv"]).refuses(&["spectrum.csv"]);
    ask(&["doctor"]).ends_with(2).says(&["<RECORDING>"]);
    ask(&["compare", "one.csv"]).ends_with(2).says(&["<SIMULATED>"]);
}
