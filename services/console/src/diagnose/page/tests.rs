//! The page and the words of a diagnosis made up for the purpose: every figure, every table,
//! nothing that is no number.

use super::super::{Case, Diagnosed, Offered, answer, object, words};
use super::{Texts, page};
use crate::effort::Effort;
use crate::plants;
use crate::recordings::Loaded;
use channels::{Channel, Recording, Role};
use discovery::diagnose::*;
use identification::held_out::{ChannelFit, Status};

fn loaded(name: &str) -> Loaded {
    let time_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.05).collect();
    let value = time_s.iter().map(|t| (2.0 * t).cos()).collect();
    let channel = Channel { name: "angle".into(), unit: "rad".into(), time_s, value, role: Role::Output };
    let recording = Recording { name: name.into(), channels: vec![channel] };
    Loaded {
        file: name.into(),
        recording,
        notes: vec!["a note <of> the import".into()],
        origin_s: 0,
        digest: "af13".into(),
    }
}

/// Tiles of two lengths over four octaves; a burst stands out before.
fn tiles() -> Vec<Tile> {
    let mut tiles = Vec::new();
    for octave in 0..4 {
        let band_hz = [if octave == 0 { 0.0 } else { 0.5 * f64::powi(2.0, octave) }, f64::powi(2.0, octave)];
        let length = if octave < 2 { 4.0 } else { 2.0 };
        let mut begin = 0.0;
        while begin < 20.0 {
            let burst = octave == 2 && begin == 8.0;
            let z_before = if burst { 25.0 } else { 0.3 };
            tiles.push(Tile {
                channel: "angle".into(),
                time: [begin, begin + length],
                band_hz,
                z_before,
                z_after: -0.4,
            });
            begin += length;
        }
    }
    tiles
}

fn law_map() -> LawMap {
    let cell = |i: i32, j: i32| {
        let (x, y) = (0.2 * f64::from(i), 0.5 * f64::from(j));
        let value = if (i, j) == (0, 0) { f64::NAN } else { 0.3 * (y + 0.25).signum() };
        LawCell { x, y, value, sigma: 0.01 }
    };
    let cells = (-4..4).flat_map(|i| (-3..3).map(move |j| cell(i, j))).collect();
    let named = |name: &str, unit: &str| (name.to_owned(), unit.to_owned());
    LawMap {
        quantity: "force at joint:pivot".into(),
        unit: "N*m".into(),
        x: named("pivot", "rad"),
        y: named("rate of pivot", "rad/s"),
        cells,
    }
}

fn curve(kind: &str, slope: f64) -> EvidenceCurve {
    let time_s: Vec<f64> = (0..200).map(|i| 0.1 * f64::from(i)).collect();
    let gain = time_s.iter().map(|t| slope * t).collect();
    EvidenceCurve { kind: kind.into(), site: "joint:pivot".into(), time_s, gain }
}

fn figures() -> Figures {
    let time_s: Vec<f64> = (0..400).map(|i| 0.05 * f64::from(i)).collect();
    let swing = |decay: f64| time_s.iter().map(|t| (-decay * t).exp() * (2.0 * t).cos()).collect::<Vec<f64>>();
    let overlay = Overlay {
        channel: "angle".into(),
        unit: "rad".into(),
        measured: swing(0.05),
        before: swing(0.02),
        after: swing(0.049),
        time_s,
    };
    Figures {
        tiles: tiles(),
        evidence: vec![curve("joint_coulomb", 9.0), curve("joint_viscous", 2.0)],
        law_maps: vec![law_map()],
        angles: Angles {
            names: vec!["joint_coulomb@joint:pivot".into(), "joint_viscous@joint:pivot".into()],
            cosine: vec![vec![1.0, 0.8], vec![0.8, 1.0]],
        },
        overlays: vec![overlay],
    }
}

/// A diagnosis in which everything is there.
fn full() -> Diagnosis {
    let mut d = Diagnosis::cannot_decide("joint_coulomb at joint:pivot (probability 0.93)".into());
    d.verdict = Verdict::Named;
    d.compare.channels = vec![ChannelFit { name: "angle".into(), rms: 0.31, fit_percent: 43.9 }];
    d.located = vec![Where {
        channel: "angle".into(),
        site: "joint:pivot".into(),
        time: [1.5, 18.0],
        band_hz: [0.0, 10.0],
        states: vec!["rate of pivot".into()],
        p: 0.0,
    }];
    d.effects = vec![EffectReport {
        kind: "joint_coulomb".into(),
        title: "Coulomb friction in a joint".into(),
        site: "joint:pivot".into(),
        probability: 0.93,
        status: Status::Confirmed,
        rivals: vec![Rival {
            kind: "joint_viscous".into(),
            site: "joint:pivot".into(),
            probability: 0.07,
            reason: "fits worse by 5.2 in BIC".into(),
        }],
        parameters: vec![ParameterReport::inside("force".into(), (0.3, 0.004), "N*m".into())],
        kept: Vec::new(),
        kappa: 0.34,
        d: 12.0,
        evidence: None,
    }];
    d.nominal =
        vec![Nominal { name: "pivot.friction".into(), before: 0.022, after: 0.0014, sigma: 4e-5, shift_sigma: -51.0 }];
    d.held_out = HeldOut {
        kind: HeldOutKind::Recording,
        channels: vec![HeldOutChannel {
            name: "angle".into(),
            fit_percent_before: 43.9,
            fit_percent_after: 92.2,
            rms_before: 0.31,
            rms_after: 0.04,
        }],
        loglik_gain: Some(184.0),
        gain_se: Some(22.0),
        gain_ci95: Some([140.0, 228.0]),
        whiteness_p_before: Some(0.0),
        whiteness_p_after: Some(0.4),
    };
    d.detection_limits = vec![DetectionLimit {
        kind: "joint_cubic_stiffness".into(),
        site: "joint:pivot".into(),
        amplitude: 0.07,
        unit: "N*m/rad^3".into(),
    }];
    d.not_found = vec!["bar.mass".into()];
    d.notes = vec!["to bound the work these were left out: points of grids".into()];
    d.figures = figures();
    d
}

fn diagnosed(diagnosis: Diagnosis) -> Diagnosed {
    let plant = plants::parse("pendulum", plants::built_in("pendulum").unwrap()).unwrap().plant;
    let case = Case {
        plant,
        plant_file: "pendulum.toml".into(),
        plant_digest: "0d3a".into(),
        fitted: vec![loaded("swing.csv")],
        held_out: vec![loaded("other.csv")],
        spectra: Vec::new(),
        modes: None,
        command: "obsid diagnose swing.csv --plant pendulum.toml".into(),
        said: Vec::new(),
        effort: Effort::default(),
    };
    let offered = Offered::of(&diagnosis);
    Diagnosed { case, findings: Vec::new(), diagnosis, interrupted: false, labels: Vec::new(), offered }
}

fn html(diagnosis: Diagnosis) -> String {
    String::from_utf8(
        page(&diagnosed(diagnosis), &Texts { augmented: None, next: Some("format = 1\n[simulation]\n") }).html(),
    )
    .unwrap()
}

#[test]
fn the_answer_says_what_on_which_data_and_what_to_do_and_opens_page_terminal_and_object() {
    let found = diagnosed(full());
    let said = answer::answer(&found);
    assert_eq!(
        said,
        [
            "The plant lacks one effect: Coulomb friction in joint pivot, 0.3000 ± 0.0040 N m.",
            "It raises the fit of angle in other.csv, not used in fitting, from 43.9 to 92.2 %.",
            "Record the plant once more and give it with `--held-out`, which confirms or rejects.",
        ]
    );
    let first = html(full()).split("<p class=\"verdict\">").nth(1).unwrap().split("</p>").next().unwrap().to_owned();
    assert_eq!(first.replace("<code>", "`").replace("</code>", "`"), said.join(" "));
    let text = words::in_words(&found, false);
    assert!(text.starts_with(&said[0]) && text.contains("\n--- details ---\n"), "{text}");
    assert_eq!(object::object(&found)["answer"], serde_json::json!(said));
}

#[test]
fn a_plant_that_is_written_is_the_next_step_and_one_that_is_not_says_how() {
    let mut found = full();
    found.augmented_plant = Some("out/augmented.toml".into());
    let mut found = diagnosed(found);
    let step = |found: &Diagnosed| answer::answer(found)[2].clone();
    let command =
        "`obsid simulate out/augmented.toml --inputs other.csv --out predicted.csv` and `obsid compare other.csv";
    assert!(step(&found).to_lowercase().starts_with(command), "{}", step(&found));
    found.diagnosis.augmented_plant = None;
    assert!(step(&found).contains("`--out report`"), "{}", step(&found));
}

#[test]
fn every_figure_of_the_method_is_drawn_with_its_axes_and_its_claim() {
    let text = html(full());
    // tiles, evidence, force over two states, force along each, angles, overlay
    assert_eq!(text.matches("<figure>").count(), 7, "{}", text.matches("<h3>").count());
    for words in [
        "angle: the innovations stand out by 25 standard errors before, 0 after",
        "Coulomb friction in joint pivot: 1",
        "the middle half of it between 5 and 15 s",
        "force at joint:pivot that the data ask for over pivot and rate of pivot",
        "force at joint:pivot along rate of pivot: from -0.3 to 0.3 N*m",
        "37 degrees apart",
        "angle: fit 43.9 % before, 92.2 % after, in free run",
        "time [s]",
        "frequency [Hz]",
        "rate of pivot [rad/s]",
        "obsid diagnose swing.csv --plant pendulum.toml",
        "0d3a",
    ] {
        assert!(text.contains(words), "`{words}` is not on the page");
    }
    for outside in ["http:", "https:", "<script ", "<img", "url(", "NaN"] {
        assert!(!text.contains(outside), "{outside}");
    }
    if let Ok(folder) = std::env::var("OBSID_GALLERY") {
        std::fs::write(format!("{folder}/diagnosis.html"), text).unwrap();
    }
}

#[test]
fn figures_of_numbers_that_are_none_are_left_out_and_nothing_panics() {
    let mut d = full();
    d.figures.tiles.iter_mut().for_each(|t| (t.z_before, t.z_after) = (f64::NAN, f64::INFINITY));
    d.figures.tiles.push(Tile {
        channel: "x".into(),
        time: [0.0, 0.0],
        band_hz: [0.0, 0.0],
        z_before: 1.0,
        z_after: 1.0,
    });
    d.figures.evidence.push(EvidenceCurve { kind: "a".into(), site: "b".into(), time_s: vec![0.0], gain: Vec::new() });
    d.figures.law_maps[0].cells.iter_mut().for_each(|c| (c.value, c.sigma) = (f64::NAN, 0.0));
    d.figures.angles.cosine = vec![vec![f64::NAN]];
    d.figures.overlays[0].before = vec![f64::NAN; 3];
    d.held_out.channels[0].fit_percent_before = f64::NEG_INFINITY;
    d.effects[0].parameters[0].sigma = f64::NAN;
    let text = html(d.clone());
    assert!(!text.contains("NaN") && text.ends_with("</html>\n"));
    let text = words::in_words(&diagnosed(d), false);
    assert!(!text.contains("NaN") && text.contains("verdict: the missing physics is named"), "{text}");
    let empty = html(Diagnosis::cannot_decide("nothing moves".into()));
    assert!(empty.contains("These recordings decide nothing: nothing moves.") && !empty.contains("<figure>"));
}

#[test]
fn every_verdict_has_three_sentences_without_an_identifier() {
    let all = [
        (Verdict::None, "lacks nothing"),
        (Verdict::Named, "lacks one effect: Coulomb friction"),
        (Verdict::NotSeparable, "pivot (probability 0.93), or Viscous friction in joint pivot (probability 0.07)"),
        (Verdict::NotInCatalogue, "catalogue does not contain"),
        (Verdict::NoiseModel, "Nothing to see"),
        (Verdict::Sensor, "A sensor is at fault"),
        (Verdict::CannotDecide, "decide nothing: nothing to see"),
    ];
    for (verdict, says) in all {
        let d = Diagnosis { verdict, reason: "nothing to see".into(), ..full() };
        let said = answer::answer(&diagnosed(d));
        assert!(said[0].contains(says), "{verdict:?}: {said:?}");
        for sentence in &said {
            let whole = sentence.ends_with('.') && sentence.chars().next().is_some_and(|c| !c.is_lowercase());
            assert!(whole && !sentence.contains("joint_") && !sentence.contains("joint:"), "{verdict:?}: {sentence}");
        }
    }
}

#[test]
fn the_object_has_the_keys_of_the_diagnosis_and_those_of_the_desk() {
    let value = object::object(&diagnosed(full()));
    let keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(&keys[..6], ["verdict", "reason", "doctor", "compare", "where", "effects"]);
    assert!(value["effects"][0]["rivals"][0]["reason"].is_string() && value["where"][0]["p"].is_number());
    assert_eq!(value["recordings"][0]["digest"], "af13");
}

#[test]
fn a_force_of_no_channel_shows_at_its_site() {
    let mut found = full();
    found.located[0].channel.clear();
    found.located[0].site = "joint:pivot".into();
    let text = words::in_words(&diagnosed(found), false).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        text.contains("is most significant at joint pivot between") && text.contains("where: at joint pivot,"),
        "{text}"
    );
}

#[test]
fn a_free_run_that_gets_worse_beside_a_confirmed_gain_is_explained() {
    let mut found = full();
    found.held_out.channels[0].fit_percent_after = 43.1;
    let said = answer::answer(&diagnosed(found));
    assert!(said[1].contains("one-step predictions does: gain in log-likelihood 184 ± 22"), "{said:?}");
}
