//! Time per call, printed:
//! `cargo test --release -p obsid-plant --lib multibody::tests::speed -- --ignored --nocapture`.

use super::invariance::table_ii_arm;
use super::*;
use std::time::Instant;

/// Nanoseconds per call of the fastest of many batches.
fn time_ns(mut call: impl FnMut()) -> f64 {
    let batch = 500; // shorter than a time slice of the scheduler
    (0..600)
        .map(|_| {
            let start = Instant::now();
            (0..batch).for_each(|_| call());
            start.elapsed().as_secs_f64() * 1e9 / f64::from(batch)
        })
        .fold(f64::INFINITY, f64::min)
}

fn report<T: Real>(name: &str, model: &Model) {
    let state = Draw::new(1).state(model);
    let lift = |x: &[f64]| x.iter().map(|x| T::constant(*x)).collect::<Vec<_>>();
    let (q, v, tau) = (lift(&state.q), lift(&state.v), lift(&state.tau));
    let mut a = lift(&state.a);
    let mut data = Data::<T>::new(model);
    let forward = time_ns(|| forward_dynamics(model, &mut data, &q, &v, &tau, &[], std::hint::black_box(&mut a)));
    let mut out = tau.clone();
    let inverse = time_ns(|| inverse_dynamics(model, &mut data, &q, &v, &a, &[], std::hint::black_box(&mut out)));
    let poses = time_ns(|| kinematics(model, std::hint::black_box(&mut data), &q, &v));
    println!("{name:42} forward {forward:7.1} ns   inverse {inverse:7.1} ns   kinematics {poses:7.1} ns");
}

#[test]
#[ignore = "prints times"]
fn nanoseconds_per_call() {
    let spatial = six_joint_arm(JointKind::FreeSpatial, Vector3::zeros());
    report::<f64>("spatial, free base, 6 joints", &spatial);
    report::<Dual>("spatial, free base, 6 joints, dual", &spatial);
    report::<f64>("spatial, fixed base, 6 joints", &six_joint_arm(JointKind::Fixed, GRAVITY));
    report::<f64>("planar, free base, 2 joints", &table_ii_arm());
    report::<Dual>("planar, free base, 2 joints, dual", &table_ii_arm());
}
