//! What one evaluation of the equations of motion costs, in time and in allocations.
//!
//! Times are of the fastest of many batches, so that a busy machine shows as little as it can; they
//! are reported, never judged.

use crate::simulated::built_in;
use dynamics::description::Plant;
use dynamics::multibody::{
    Data, JointKind, Link, Model, PARAMETERS_PER_LINK, forward_dynamics, inverse_dynamics, inverse_dynamics_regressor,
};
use dynamics::system::Workspace;
use nalgebra::{DMatrix, Matrix3, Vector3};
use serde_json::json;
use simulation::Simulator;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

/// Plants whose derivative and simulator are measured.
const PLANTS: [&str; 5] = ["free_floating_arm", "tank_planar", "hub_appendage", "study_case", "study_case_spatial"];
/// A batch is shorter than a time slice of the scheduler.
const BATCH_S: f64 = 2e-4;
const BATCHES: usize = 100;

/// One measured call.
pub struct Case {
    pub name: String,
    pub ns_per_call: f64,
    /// Of one call, once warm.
    pub allocations: f64,
}

/// Every case; `allocations` counts those of this thread so far.
///
/// # Panics
/// A built-in plant cannot be simulated.
pub fn cases(allocations: &dyn Fn() -> u64) -> Vec<Case> {
    let mut cases = Cases { found: Vec::new(), allocations };
    for (name, base) in [("spatial", JointKind::FreeSpatial), ("planar", JointKind::FreePlanar)] {
        cases.tree(name, &tree(base));
    }
    for name in PLANTS {
        cases.whole(name);
    }
    cases.minute_of_bp1a();
    cases.found
}

/// One JSON object on one line.
pub fn json(cases: &[Case]) -> String {
    let one =
        |case: &Case| json!({ "name": case.name, "ns_per_call": case.ns_per_call, "allocations": case.allocations });
    format!("{}\n", json!({ "cases": cases.iter().map(one).collect::<Vec<_>>() }))
}

/// For a reader.
pub fn table(cases: &[Case]) -> String {
    let mut text = format!("{:<52} {:>14} {:>12}\n", "", "ns a call", "allocations");
    for case in cases {
        let _ = writeln!(text, "{:<52} {:>14.1} {:>12}", case.name, case.ns_per_call, case.allocations);
    }
    text.push_str("\nFastest of many batches; allocations of one call, once warm.\n");
    text
}

struct Cases<'a> {
    found: Vec<Case>,
    allocations: &'a dyn Fn() -> u64,
}

impl Cases<'_> {
    /// Time and allocations of `call`; the first calls warm up.
    fn measure(&mut self, name: String, mut call: impl FnMut()) {
        let begin = Instant::now();
        let mut warm_up = 0_u32;
        while warm_up < 3 || begin.elapsed().as_secs_f64() < BATCH_S {
            call();
            warm_up += 1;
        }
        let batch = (f64::from(warm_up) * BATCH_S / begin.elapsed().as_secs_f64()).max(1.0) as u32;
        let before = (self.allocations)();
        (0..batch).for_each(|_| call());
        let allocations = ((self.allocations)() - before) as f64 / f64::from(batch);
        let fastest_s = (0..BATCHES).map(|_| {
            let begin = Instant::now();
            (0..batch).for_each(|_| call());
            begin.elapsed().as_secs_f64()
        });
        let ns_per_call = fastest_s.fold(f64::INFINITY, f64::min) * 1e9 / f64::from(batch);
        self.found.push(Case { name, ns_per_call, allocations });
    }

    fn tree(&mut self, name: &str, model: &Model) {
        let n = model.v_len();
        let name = format!("{name} free-floating arm, {} joints", model.links_len() - 1);
        let mut q = model.neutral_position();
        let joints = model.q_index(1);
        q[joints..].iter_mut().enumerate().for_each(|(i, q)| *q = 0.3 + 0.1 * i as f64);
        let v: Vec<f64> = (0..n).map(|i| 0.2 - 0.03 * i as f64).collect();
        let tau: Vec<f64> = (0..n).map(|i| if i < n + 1 - model.links_len() { 0.0 } else { 1.0 }).collect();
        let (mut data, mut a, mut out) = (Data::<f64>::new(model), vec![0.0; n], vec![0.0; n]);
        let mut regressor = DMatrix::zeros(n, PARAMETERS_PER_LINK * model.links_len());
        self.measure(format!("forward dynamics, {name}"), || {
            forward_dynamics(model, &mut data, black_box(&q), &v, &tau, &[], black_box(&mut a));
        });
        self.measure(format!("inverse dynamics, {name}"), || {
            inverse_dynamics(model, &mut data, black_box(&q), &v, &a, &[], black_box(&mut out));
        });
        self.measure(format!("regressor, {name}"), || {
            inverse_dynamics_regressor(model, &mut data, black_box(&q), &v, &a, black_box(&mut regressor));
        });
    }

    fn whole(&mut self, name: &str) {
        let plant = built_in(name);
        let mut simulator = simulator(name, &plant);
        let x = simulator.truth().state.to_vec();
        let u = simulator.step().inputs.clone();
        let system = simulator.system().clone();
        let (mut ws, mut x_dot) = (Workspace::<f64>::new(&system), x.clone());
        self.measure(format!("derivative, {name}"), || {
            system.derivative(&mut ws, 0.0, black_box(&x), &u, black_box(&mut x_dot));
        });
        let period = plant.simulation.period_s;
        self.measure(format!("simulator step of {} ms, {name}", period * 1e3), || {
            black_box(simulator.step());
        });
    }

    /// 60 s of the benchmark's arm at 100 Hz, one step of RK4 a period.
    fn minute_of_bp1a(&mut self) {
        let mut plant = built_in("free_floating_arm");
        plant.simulation.step_s = 0.01;
        let mut simulator = simulator("free_floating_arm", &plant);
        self.measure("60 s of BP1A, 100 Hz, RK4 of 10 ms".into(), || {
            // the trajectory is periodic: one minute is as the other
            for _ in 0..6000 {
                black_box(simulator.step());
            }
        });
    }
}

/// A base of 400 kg with an arm: six joints in space, two in a plane.
fn tree(base: JointKind) -> Model {
    let (y, z) = (Vector3::y(), Vector3::z());
    let body = |parent, joint, x: f64, mass_kg: f64| Link {
        parent,
        joint,
        position_m: Vector3::new(x, 0.1, 0.0),
        rotation: Matrix3::identity(),
        mass_kg,
        com_m: Vector3::new(0.5 * x, 0.02, 0.0),
        inertia_com_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.1, 0.3, 0.35)) * mass_kg * 0.2,
        armature: 0.0,
    };
    let axes = if base == JointKind::FreePlanar { vec![z, z] } else { vec![z, y, y, z, y, z] };
    let mut links = vec![body(None, base, 0.8, 400.0)];
    for (i, axis) in axes.into_iter().enumerate() {
        links.push(body(Some(i), JointKind::Revolute { axis }, 0.7, 12.0 - i as f64));
    }
    Model::new(&links, &[], Vector3::zeros()).expect("an arm of bodies with mass on a free base is a mechanism")
}

fn simulator(name: &str, plant: &Plant) -> Simulator {
    Simulator::new(plant, 1, name).unwrap_or_else(|error| panic!("{name}: {error}"))
}
