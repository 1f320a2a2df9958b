use super::*;
use crate::answer::Name;
use crate::hidden::Hidden;

fn truth(class: Class, noise: NoiseKind, effects: &[(&str, &str)], d: f64) -> Truth {
    let hidden = |(kind, site): &(&str, &str)| Hidden {
        kind: (*kind).to_owned(),
        site: (*site).to_owned(),
        values: vec![("force".to_owned(), 2.0)],
    };
    Truth {
        case: 0,
        class,
        plant: "drive_rig".to_owned(),
        closed_loop: false,
        noise,
        effects: effects.iter().map(hidden).collect(),
        without: Vec::new(),
        planned_d: d,
        d: effects.iter().map(|_| d).collect(),
        held_out_d: d,
        kappa: 0.0,
        rho: 0.0,
        rival: String::new(),
        biased: None,
        window: None,
        numbers: Vec::new(),
        recordings: Vec::new(),
        candidates: 50,
    }
}

fn answer(verdict: &str, names: &[(&str, &str, f64)]) -> Answer {
    let name = |(kind, site, probability): &(&str, &str, f64)| Name {
        kind: (*kind).to_owned(),
        site: (*site).to_owned(),
        probability: *probability,
        status: "confirmed".to_owned(),
        rivals: vec![("joint_lugre".to_owned(), "joint:drive".to_owned(), 1e-9)],
        parameters: vec![("force".to_owned(), 2.3, 0.2)],
        d: 9.0,
    };
    let names = names.iter().map(name).collect();
    Answer {
        verdict: verdict.to_owned(),
        reason: String::new(),
        names,
        located: Vec::new(),
        nominal: Vec::new(),
        crashed: false,
        tried: Vec::new(),
    }
}

fn opened(truth: Truth, answer: Answer) -> Opened {
    Opened { truth, digest: String::new(), answer, seconds: [0.0; 2] }
}

#[test]
fn silence_is_asked_of_right_noise_and_no_physics_of_wrong_noise() {
    let alarm = |noise, verdict: &str| is_false_alarm(&truth(Class::Null, noise, &[], 0.0), &answer(verdict, &[]));
    assert!(!alarm(NoiseKind::Right, "none"));
    for verdict in ["noise_model", "named", "cannot_decide", "not_in_catalogue"] {
        assert!(alarm(NoiseKind::Right, verdict), "{verdict}");
    }
    for verdict in ["none", "noise_model", "cannot_decide"] {
        assert!(!alarm(NoiseKind::Ar08, verdict), "{verdict}");
    }
    for verdict in ["named", "not_separable", "sensor", "not_in_catalogue"] {
        assert!(alarm(NoiseKind::Ar08, verdict), "{verdict}");
    }
    let hidden = truth(Class::Single, NoiseKind::Right, &[("joint_coulomb", "joint:drive")], 9.0);
    assert!(!is_false_alarm(&hidden, &answer("named", &[])));
}

#[test]
fn figures_count_what_they_say() {
    let effect = [("joint_coulomb", "joint:drive")];
    let single = |d: f64| truth(Class::Single, NoiseKind::Right, &effect, d);
    let right = ("joint_coulomb", "joint:drive", 0.8);
    let wrong = ("joint_bouc_wen", "joint:drive", 0.95);
    let both = [("joint_coulomb", "joint:drive"), ("sensor_scale", "sensor:rate")];
    let all = vec![
        opened(single(9.5), answer("named", &[right])),
        opened(single(9.5), answer("named", &[wrong])),
        opened(single(4.5), answer("none", &[right])),
        opened(truth(Class::LeftOut, NoiseKind::Right, &effect, 20.0), answer("named", &[wrong])),
        opened(truth(Class::LeftOut, NoiseKind::Right, &effect, 20.0), answer("not_in_catalogue", &[])),
        opened(truth(Class::LeftOut, NoiseKind::Right, &effect, 14.0), answer("named", &[wrong])),
        opened(
            truth(Class::Pair, NoiseKind::Right, &both, 12.0),
            answer("named", &[right, ("sensor_scale", "sensor:rate", 0.7)]),
        ),
        opened(truth(Class::Pair, NoiseKind::Right, &both, 12.0), answer("named", &[right])),
        opened(truth(Class::Null, NoiseKind::Right, &[], 0.0), answer("none", &[])),
    ];
    let score = score(&all);
    assert_eq!((score.cases, score.nulls, score.false_alarms), (9, 1, 0));
    assert_eq!((score.first_name_share_d8, score.in_set_share_d8), (Some(0.5), Some(0.5)));
    assert_eq!(score.set_size_median, Some(1.0)); // a rival of weight 1e-9 is out of the set
    assert_eq!((score.leave_one_out.n, score.leave_one_out.abstained, score.leave_one_out.false_name), (2, 1, 1));
    assert_eq!((score.pairs.n, score.pairs.both_named), (2, 1));
    assert!((score.parameter_z_rms.unwrap() - 1.5).abs() < 1e-12); // (2.3 - 2) / 0.2
    assert_eq!(score.power.iter().map(|bin| bin.n).sum::<usize>(), 3);
    assert_eq!(score.power.iter().map(|bin| bin.detected).sum::<usize>(), 2);
}

#[test]
fn ideal_power_is_a_half_at_its_threshold() {
    let z = z_m(100.0);
    assert!((z - 4.26489).abs() < 1e-4, "{z}"); // normal quantile at 1 - 1e-5
    assert!((phi(0.0) - 0.5).abs() < 1e-15);
    // of the chances that the tool gave this law; of the plant's entries times sites where it did
    // not look for it
    let hidden = truth(Class::Single, NoiseKind::Right, &[("joint_coulomb", "joint:drive")], z_m(700.0));
    let mut case = opened(hidden, answer("none", &[]));
    case.answer.tried = vec![("joint_coulomb".to_owned(), "joint:drive".to_owned(), 700.0)];
    let ideal = |case: &Opened| power(&[case]).iter().map(|bin| bin.ideal).sum::<f64>();
    assert!((ideal(&case) - 0.5).abs() < 1e-12);
    let without = power(&[&case]).iter().map(|bin| bin.ideal_without_grids).sum::<f64>();
    assert!((without - phi(z_m(700.0) - z_m(50.0))).abs() < 1e-12);
    case.answer.tried[0].1 = "joint:other".to_owned();
    assert!((ideal(&case) - phi(z_m(700.0) - z_m(50.0))).abs() < 1e-12);
}

#[test]
fn the_keys_are_those_of_the_published_table() {
    let value = serde_json::to_value(score(&[])).unwrap();
    let keys: Vec<&String> = value.as_object().unwrap().keys().collect();
    assert_eq!(
        keys,
        [
            "cases",
            "nulls",
            "false_alarms",
            "power",
            "first_name_share_d8",
            "in_set_share_d8",
            "ideal_first_name_share_d8",
            "set_size_median",
            "leave_one_out",
            "pairs",
            "masked",
            "iou_median",
            "parameter_z_rms",
            "parameter_z_below_2_share",
            "heldout_confirmed_share",
            "brier",
        ]
    );
}
