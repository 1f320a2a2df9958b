//! Time of a simulated period and its parts: `cargo bench -p obsid-simulation --bench simulation`.
//! Benchmark problem 1A, 100 Hz, Runge–Kutta in steps of 10 ms. Why without a harness:
//! `dynamics/benches/multibody.rs`.

#[path = "../../dynamics/benches/least_time/mod.rs"]
mod least_time;

use dynamics::system::{JointReference, Workspace};
use least_time::least_time_ns;
use simulation::Simulator;

const PLANT: &str = include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../deploy/plants/free_floating_arm.toml"));

fn main() {
    let mut plant = plant_file::parse("free_floating_arm", PLANT).expect("a plant of the build").plant;
    plant.simulation.step_s = plant.simulation.period_s;
    let mut simulator = Simulator::new(&plant, 0, "arm").expect("a plant of the build");
    let derivative = parts(&simulator);
    let time = |name: &str, call: &mut dyn FnMut()| {
        let ns = least_time_ns(call);
        println!("{name:24} {ns:7.0} ns {:6.2} derivatives", ns / derivative);
    };
    time("a period with noise", &mut || {
        simulator.step();
    });
    plant.sensors.iter_mut().for_each(|sensor| sensor.noise = Default::default());
    let mut quiet = Simulator::new(&plant, 0, "arm").expect("a plant of the build");
    time("a period without noise", &mut || {
        quiet.step();
    });
}

/// Prints what a period is made of and returns the time of a derivative \[ns\].
fn parts(simulator: &Simulator) -> f64 {
    let system = simulator.system();
    let mut workspace = Workspace::<f64>::new(system);
    let x = system.initial_state(&Default::default(), &|_| None).expect("a state of rest");
    let (mut x_dot, mut y) = (x.clone(), vec![0.0; system.outputs().len()]);
    let (u, mut forces) = ([5.0, -3.0], [0.0; 2]);
    let joint = |name: &str, position: f64| JointReference {
        joint: system.joint(name).expect("a joint of the plant"),
        position,
        rate: 0.1,
        acceleration: 0.2,
    };
    let references = [joint("shoulder", 0.8), joint("elbow", -1.8)];
    let derivative = least_time_ns(|| system.derivative(&mut workspace, 0.0, &x, &u, &mut x_dot));
    println!("{:24} {derivative:7.0} ns", "derivative");
    let mut time = |name: &str, call: &mut dyn FnMut(&mut Workspace<f64>)| {
        let ns = least_time_ns(|| call(&mut workspace));
        println!("{name:24} {ns:7.0} ns {:6.2} derivatives", ns / derivative);
    };
    time("reading", &mut |workspace| system.read(workspace, 0.0, &x, &u, &mut y));
    time("feed forward", &mut |workspace| {
        system.feed_forward(workspace, &references, [0.0, 0.0, 68.0], &mut forces);
    });
    time("derivative and reading", &mut |workspace| {
        system.derivative_and_read(workspace, 0.0, &x, &u, &mut x_dot, &mut y);
    });
    derivative
}
