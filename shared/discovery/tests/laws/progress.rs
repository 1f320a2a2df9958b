//! Progress is measured in work, which a test can know, instead of time.

use discovery::diagnose::Options;
use discovery::evidence::diagnose;
use discovery::planned_work;
use dynamics::description::Plant;
use identification::problem::Problem;
use identification::work::{Watch, share_done};

fn plant(text: &str) -> Plant {
    plant_file::parse("plant.toml", text).unwrap().plant
}

fn recorded(nominal: &Plant, truth: &Plant, seed: u64, duration_s: f64) -> Problem {
    let recording = simulation::record(truth, seed, duration_s, &mut |_| {}).unwrap();
    Problem::new(nominal, &[recording], &[]).unwrap()
}

/// Name, plant as stated, plant as it is, length, whether another recording is held out.
fn cases() -> Vec<(&'static str, Plant, Plant, f64, bool)> {
    let pendulum = plant(include_str!("../../../../deploy/plants/pendulum.toml"));
    let oscillator = plant(include_str!("../../../../deploy/plants/oscillator.toml"));
    let friction = |force: f64| {
        let mut truth = pendulum.clone();
        truth.add_effect("joint_coulomb", &"joint:pivot".parse().unwrap(), &[("force", force)]).unwrap();
        truth
    };
    vec![
        ("nothing", pendulum.clone(), pendulum.clone(), 6.0, false),
        ("nothing, held out", oscillator.clone(), oscillator.clone(), 1.5, true),
        ("friction", pendulum.clone(), friction(0.02), 8.0, false),
        ("friction, held out", pendulum.clone(), friction(0.05), 6.0, true),
    ]
}

#[test]
fn a_share_grows_to_one_and_is_about_half_where_half_of_the_work_is_done() {
    for (name, nominal, truth, duration_s, has_held_out) in cases() {
        let held_out = has_held_out.then(|| recorded(&nominal, &truth, 12, duration_s));
        let watch = Watch::default();
        let options = Options { held_out, watch: watch.clone(), ..Options::default() };
        let (mut shares, mut begun) = (Vec::new(), Vec::new());
        diagnose(&recorded(&nominal, &truth, 11, duration_s), &options, &mut |phase, share| {
            shares.push(share);
            begun.push((phase, watch.counted()));
        });
        let (plans, whole) = (watch.plans(), watch.counted());
        let at = |part: f64| share_done(&plans, part * whole);
        let parts: Vec<f64> = (0..=40).map(|k| at(f64::from(k) / 40.0)).collect();
        assert!(parts.is_sorted() && shares.is_sorted(), "{name}: {parts:?}");
        assert!((watch.share() - 1.0).abs() < 1e-9, "{name}: {} at the end", watch.share());
        assert!((0.25..=0.75).contains(&at(0.5)), "{name}: {} at the half; {begun:?}", at(0.5));
    }
}

#[test]
fn the_plan_of_a_command_is_known_from_the_size_of_its_problem() {
    let (_, nominal, truth, ..) = cases().remove(0);
    let of = |duration_s: f64| planned_work(&recorded(&nominal, &truth, 1, duration_s), None).unwrap();
    let ([_, short], [_, long]) = (of(5.0), of(10.0));
    assert!((long / short - 2.0).abs() < 0.1, "{short} {long}");
}
