//! No step takes memory: what a loop calls after construction and one step of warm-up allocates
//! nothing, on any plant and with any effect.

use crate::subject::{Subject, folder, plant};
use catalogue::EFFECTS;
use dynamics::description::{EffectUse, Integrator, Plant};
use dynamics::dual::Dual;
use dynamics::effect::{Law, sites};
use dynamics::multibody::{
    Data, forward_dynamics, inverse_dynamics, inverse_dynamics_regressor, mass_matrix, momentum,
};
use dynamics::system::{StateSpace, Workspace};
use runtime::sys::allocations;
use simulation::Simulator;

/// More than the slowest sensor's period and the longest delay.
const STEPS: usize = 60;

fn names() -> Vec<String> {
    let files = |under: &str| -> Vec<String> {
        let files = std::fs::read_dir(folder().join(under)).unwrap();
        let names = files.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter_map(|name| Some(format!("{under}{}", name.strip_suffix(".toml")?))).collect()
    };
    let mut names = [files(""), files("rigs/")].concat();
    names.sort();
    assert!(names.len() >= 22, "{names:?}");
    names
}

/// Allocations of `work` on this thread.
fn count(work: impl FnOnce()) -> u64 {
    let before = allocations();
    work();
    allocations() - before
}

/// Allocations of [`STEPS`] periods after one.
fn steps_take(plant: &Plant) -> u64 {
    let kinds: Vec<&str> = plant.effects.iter().map(|effect| effect.kind.as_str()).collect();
    let built = Simulator::new(plant, 1, "allocations");
    let mut simulator = built.unwrap_or_else(|error| panic!("{} with {kinds:?}: {error}", plant.name));
    simulator.step();
    count(|| {
        for _ in 0..STEPS {
            simulator.step();
        }
    })
}

#[test]
fn a_step_that_allocates_is_counted() {
    assert_eq!(count(|| drop(std::hint::black_box(vec![0u8; 100]))), 1);
    let mut grows: Vec<u64> = Vec::with_capacity(1);
    grows.push(1);
    assert_eq!(count(|| grows.push(2)), 1);
    // a step beside which something is taken
    let mut simulator = Simulator::new(&plant("study_case", &[]), 1, "allocations").unwrap();
    simulator.step();
    assert_eq!(count(|| drop(simulator.step().samples.clone())), 1);
}

#[test]
fn simulating_any_plant_allocates_nothing_per_step() {
    for name in names() {
        assert_eq!(steps_take(&plant(&name, &[])), 0, "{name}");
    }
}

#[test]
fn equations_of_any_plant_allocate_nothing() {
    for name in names() {
        let mut subject = Subject::new(plant(&name, &[]));
        let quaternion = |name: &str| name.ends_with(".qw");
        subject.draw(3);
        let unit: Vec<usize> = (0..subject.x.len()).filter(|i| quaternion(&subject.system.states()[*i].name)).collect();
        for at in unit {
            subject.x[at..at + 4].copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
        }
        let Subject { system, x, u, .. } = &subject;
        let (mut real, mut dual) = (Workspace::<f64>::new(system), Workspace::<Dual>::new(system));
        let (mut x_dot, mut y) = (x.clone(), vec![0.0; system.outputs().len()]);
        let mut space = StateSpace::zeros(system);
        let taken = count(|| {
            system.derivative(&mut real, 0.1, x, u, &mut x_dot);
            system.read(&mut real, 0.1, x, u, &mut y);
            system.derivative_and_read(&mut real, 0.1, x, u, &mut x_dot, &mut y);
            system.totals(&mut real, x, u);
            system.linearise_into(&mut dual, 0.1, x, u, &mut space);
        });
        assert_eq!(taken, 0, "{name}");
        assert!(x_dot.iter().chain(&y).all(|value| value.is_finite()), "{name}");
    }
}

#[test]
fn dynamics_of_any_tree_allocate_nothing() {
    for name in names() {
        let system = Subject::new(plant(&name, &[])).system;
        let model = system.model();
        let n = model.v_len();
        let (q, v) = (model.neutral_position(), vec![0.3; n]);
        let (mut data, mut acceleration, mut tau) = (Data::new(model), vec![0.0; n], vec![0.1; n]);
        let mut mass = nalgebra::DMatrix::zeros(n, n);
        let mut regressor = nalgebra::DMatrix::zeros(n, 10 * model.links_len());
        let taken = count(|| {
            forward_dynamics(model, &mut data, &q, &v, &tau, &[], &mut acceleration);
            inverse_dynamics(model, &mut data, &q, &v, &acceleration, &[], &mut tau);
            mass_matrix(model, &mut data, &q, &mut mass);
            momentum(model, &mut data, &q, &v);
            inverse_dynamics_regressor(model, &mut data, &q, &v, &acceleration, &mut regressor);
        });
        assert_eq!(taken, 0, "{name}");
    }
}

fn with(plant: &Plant, kinds: &[&str]) -> Plant {
    let mut with = plant.clone();
    // most effects are not linear: the exact hold refuses them
    with.simulation.integrator = Integrator::RungeKutta4;
    for effect in EFFECTS.iter().filter(|effect| kinds.contains(&effect.kind)) {
        let site = sites(effect, plant).swap_remove(0);
        with.effects.push(EffectUse { kind: effect.kind.to_owned(), site, values: Vec::new() });
    }
    assert_eq!(with.effects.len(), plant.effects.len() + kinds.len(), "an effect of {kinds:?} has no site");
    with
}

#[test]
fn no_effect_of_the_catalogue_makes_a_step_allocate() {
    let plants: Vec<Plant> = names().iter().map(|name| plant(name, &[])).collect();
    let study = plant("study_case", &[]);
    for effect in EFFECTS {
        let place = core::iter::once(&study).chain(&plants).find(|plant| !sites(effect, plant).is_empty());
        let place = place.unwrap_or_else(|| panic!("no plant has a site for {}", effect.kind));
        assert_eq!(steps_take(&with(place, &[effect.kind])), 0, "{} in {}", effect.kind, place.name);
    }
}

fn kind_of(law: &Law) -> usize {
    match law {
        Law::Coordinate(_) => 0,
        Law::Body(_) => 1,
        Law::Actuator(_) => 2,
        Law::Sensor(_) => 3,
        Law::ActuatorFilter(_) => 4,
        Law::SensorFilter(_) => 5,
        Law::Structure(_) => 6,
    }
}

#[test]
fn effects_of_every_kind_of_law_at_once_allocate_nothing_per_step() {
    let kinds = [
        "joint_coulomb",
        "joint_lugre",
        "solar_pressure",
        "mass_depletion",
        "actuator_dead_zone",
        "wheel_imbalance_static",
        "sensor_quadratic",
        "actuator_lag",
        "sensor_delay",
        "slosh_second_mode",
        "mode_left_out",
    ];
    let mut laws = [false; 7];
    for effect in EFFECTS.iter().filter(|effect| kinds.contains(&effect.kind)) {
        laws[kind_of(&effect.law)] = true;
    }
    assert_eq!(laws, [true; 7]);
    assert_eq!(steps_take(&with(&plant("study_case", &[]), &kinds)), 0);
}
