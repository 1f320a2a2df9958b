//! Cost of a record; printed, never asserted.

use super::plants;
use crate::Simulator;
use crate::oracle::arm::ArmNoise;
use dynamics::system::{JointReference, Workspace};
use std::time::Instant;

/// `cargo test --release -p obsid-plant -- --ignored --nocapture cost_of_bp1a`
#[test]
#[ignore = "prints times"]
fn cost_of_bp1a_for_60_s_at_100_hz_with_rk4_at_10_ms() {
    for (name, noise) in [("without noise", ArmNoise::none()), ("with noise", ArmNoise::default())] {
        let mut plant = plants::arm(&noise);
        plant.simulation.step_s = 0.01;
        // the least time of each tenth of a second over many records: what else the machine does is
        // left out
        let mut parts_ms = vec![f64::INFINITY; 600];
        for _ in 0..100 {
            let mut simulator = Simulator::new(&plant, 0, "arm").unwrap();
            for best_ms in &mut parts_ms {
                let begin = Instant::now();
                for _ in 0..10 {
                    simulator.step();
                }
                *best_ms = best_ms.min(begin.elapsed().as_secs_f64() * 1e3);
            }
        }
        let best_ms: f64 = parts_ms.iter().sum();
        println!("BP1A, 60 s, 6000 periods of 10 ms, RK4 at 10 ms, {name}: {best_ms:.2} ms");
    }
}

/// What a period is made of.
#[test]
#[ignore = "prints times"]
fn cost_of_bp1a_by_parts() {
    let plant = plants::arm(&ArmNoise::none());
    let simulator = Simulator::new(&plant, 0, "arm").unwrap();
    let system = simulator.system();
    let mut workspace = Workspace::<f64>::new(system);
    let x = Simulator::new(&plant, 0, "arm").unwrap().truth().state.to_vec();
    let (mut x_dot, mut y, u) = (x.clone(), [0.0; 7], [5.0, -3.0]);
    let mut forces = [0.0; 2];
    let at = |name: &str, position: f64| JointReference {
        joint: system.joint(name).unwrap(),
        position,
        rate: 0.1,
        acceleration: 0.2,
    };
    let references = [at("joint1", 0.8), at("joint2", -1.8)];
    // the least of many short runs: what else the machine does is left out
    let time = |what: &str, call: &mut dyn FnMut(f64)| {
        let run = |call: &mut dyn FnMut(f64)| {
            let begin = Instant::now();
            (0..200).for_each(|k| call(f64::from(k)));
            begin.elapsed().as_secs_f64() * 5e6
        };
        println!("{what}: {:.0} ns", (0..3000).map(|_| run(call)).fold(f64::INFINITY, f64::min));
    };
    time("derivative", &mut |t| system.derivative(&mut workspace, t, &x, &u, &mut x_dot));
    time("read", &mut |t| system.read(&mut workspace, t, &x, &u, &mut y));
    time("feed_forward", &mut |_| system.feed_forward(&mut workspace, &references, [0.0, 0.0, 68.0], &mut forces));
    time("derivative and read", &mut |t| system.derivative_and_read(&mut workspace, t, &x, &u, &mut x_dot, &mut y));
}
