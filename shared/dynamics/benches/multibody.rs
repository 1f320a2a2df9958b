//! Time of one call of the equations of motion: `cargo bench -p obsid-dynamics --bench multibody`.
//!
//! Without a harness: the fastest of many short batches is what the code costs, whatever else the
//! machine does, and needs no statistics; a harness would be compiled by every `cargo test`.

mod least_time;

use dynamics::dual::Dual;
use dynamics::multibody::{Data, JointKind, Link, Model, forward_dynamics, inverse_dynamics, kinematics};
use dynamics::real::Real;
use least_time::least_time_ns;
use nalgebra::{Matrix3, Vector3};
use std::hint::black_box;

fn main() {
    println!("forward dynamics [ns]; inverse dynamics and kinematics in parts of it");
    let spatial = arm(JointKind::FreeSpatial, [Vector3::z(), Vector3::y()].into_iter().cycle().take(6));
    let planar = arm(JointKind::FreePlanar, [Vector3::z(); 2].into_iter());
    let plain = report::<f64>("spatial, free base, 6 joints", &spatial);
    let dual = report::<Dual>("the same with one derivative", &spatial);
    println!("{:32} {:.2} times the plain one", "", dual / plain);
    report::<f64>("planar, free base, 2 joints", &planar);
    report::<Dual>("the same with one derivative", &planar);
}

/// A base and links one behind the other.
fn arm(base: JointKind, axes: impl Iterator<Item = Vector3<f64>>) -> Model {
    let body = |parent, joint, mass_kg: f64| Link {
        parent,
        joint,
        position_m: Vector3::new(0.8, 0.1, 0.0),
        rotation: Matrix3::identity(),
        mass_kg,
        com_m: Vector3::new(0.4, 0.02, 0.0),
        inertia_com_kg_m2: Matrix3::from_diagonal(&Vector3::new(0.1, 0.3, 0.35)) * mass_kg * 0.2,
        armature: 0.0,
    };
    let joints = axes.enumerate().map(|(i, axis)| body(Some(i), JointKind::Revolute { axis }, 12.0));
    let links: Vec<Link> = std::iter::once(body(None, base, 400.0)).chain(joints).collect();
    Model::new(&links, &[], Vector3::zeros()).expect("an arm")
}

/// Prints the line of one model and returns its forward dynamics \[ns\].
fn report<T: Real>(name: &str, model: &Model) -> f64 {
    let lifted = |x: &[f64]| x.iter().map(|x| T::constant(*x)).collect::<Vec<_>>();
    let some = |n: usize| (0..n).map(|i| T::constant(0.1 + 0.07 * i as f64)).collect::<Vec<_>>();
    let (mut q, v, tau, mut a) =
        (lifted(&model.neutral_position()), some(model.v_len()), some(model.v_len()), some(model.v_len()));
    let last = q.len() - 1;
    q[last] = T::constant(0.4);
    let mut data = Data::<T>::new(model);
    let forward = least_time_ns(|| forward_dynamics(model, &mut data, &q, &v, &tau, &[], black_box(&mut a)));
    let mut out = tau.clone();
    let inverse = least_time_ns(|| inverse_dynamics(model, &mut data, &q, &v, &a, &[], black_box(&mut out)));
    let poses = least_time_ns(|| kinematics(model, black_box(&mut data), &q, &v));
    println!("{name:32} {forward:7.0} {:6.2} {:6.2}", inverse / forward, poses / forward);
    forward
}
