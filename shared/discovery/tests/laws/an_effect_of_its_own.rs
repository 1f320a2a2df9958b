//! An effect that exists in this test alone is simulated, screened, refitted, reported and written,
//! without another line of the program.

use discovery::diagnose::{Options, Verdict};
use discovery::evidence::diagnose;
use dynamics::both;
use dynamics::description::SiteKind;
use dynamics::effect::{Action, Catalogue, Effect, EffectParameter, Family, Law, Local};
use dynamics::real::Real;
use identification::problem::Problem;

/// Damping that is large where the joint is far out: what a cam or an eddy-current brake does.
static OWN: Effect = Effect {
    kind: "damping_of_this_test",
    title: "Damping that grows with the square of the angle",
    sites: &[SiteKind::Joint],
    parameters: &[EffectParameter::new("damping", "J s/*^2", [0.0, 1e3], 0.05, "coefficient c").amplitude()],
    law: Law::Coordinate(both!(law)),
    family: Family::Damping,
    what: "F = -c q^2 q'",
    signature: "Damping at large angles, none near zero.",
    confounders: "joint_cubic_damping.",
    experiment: "Swing about another rest position.",
    ..Effect::PLAIN
};

fn law<T: Real>(local: &Local<'_, T>, p: &[f64], action: &mut Action<T>) {
    action.force -= (local.coordinate * local.coordinate * local.rate).scale(p[0]);
}

#[test]
fn an_effect_that_only_this_test_knows_is_found_and_its_plant_is_written_and_read() {
    let entries: Vec<&'static Effect> = catalogue::EFFECTS.iter().copied().chain([&OWN]).collect();
    let catalogue = Catalogue::new(entries.leak());
    let text = include_str!("../../../../deploy/plants/pendulum.toml");
    let plant = plant_file::parse_with(catalogue, "pendulum", text).unwrap().plant;
    let joint = plant.sites(SiteKind::Joint)[0].clone();
    let mut hidden = plant.clone();
    hidden.add_effect("damping_of_this_test", &joint, &[("damping", 0.4)]).unwrap();
    hidden.simulation.integrator = dynamics::description::Integrator::RungeKutta4;
    let recording = simulation::record(&hidden, 3, 30.0, &mut |_| {}).unwrap();
    let problem = Problem::new(&plant, &[recording], &[]).unwrap();
    let found = diagnose(&problem, &Options::default(), &mut |_, _| {});
    assert!(matches!(found.verdict, Verdict::Named | Verdict::NotSeparable), "{:?} {}", found.verdict, found.reason);
    let named = &found.effects[0];
    assert_eq!((named.kind.as_str(), named.title.as_str()), (OWN.kind, OWN.title), "{:?}", found.effects);
    let damping = &named.parameters[0];
    assert!((damping.value - 0.4).abs() < 4.0 * damping.sigma && damping.sigma < 0.1, "{damping:?}");
    let written = plant_file::write(&hidden);
    assert_eq!(plant_file::parse_with(catalogue, "hidden", &written).unwrap().plant.effects, hidden.effects);
    assert!(plant_file::parse("hidden", &written).is_err(), "no other catalogue knows it");
}
