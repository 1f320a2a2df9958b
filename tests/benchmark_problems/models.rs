//! Closed forms (`physics`) along the experiments that the general plant simulates from its files:
//! what a record must obey.
//!
//! State by state the two are compared in `plant_dynamics`.

use crate::claims::{Claim, demand};
use bench::inertial::{Inertial, planar_arm, sigma, truth};
use bench::modes::{Modes, SENSORS};
use bench::slosh::Slosh;
use dynamics::description::{Noise, Plant, Quantity, SensorKind};
use dynamics::noise::Stream;
use dynamics::system::{System, Workspace};
use nalgebra::SVector;
use physics::appendage::{Appendage, Mode, refit_free_decay_residual};
use physics::free_floating::{Alpha, accelerations};
use physics::mated::{Target, mated_parameters};
use physics::momentum::{ChannelSigma, momentum_regressor, noisy_momentum_row};
use physics::slosh::{SloshParameters, SloshPropagator, SloshState};

/// A number of the plant by its name.
pub fn number(plant: &Plant, name: &str) -> f64 {
    plant.parameters().into_iter().find(|parameter| parameter.name == name).expect("a number of the benchmark").value
}

/// The plant with some numbers replaced.
pub fn with(mut plant: Plant, changes: &[(&str, f64)]) -> Plant {
    changes.iter().for_each(|(name, value)| plant.set_parameter(name, *value).expect("a number of the benchmark"));
    plant
}

/// The table's arm has equal components of r0, which hides a swap of a4 with a5 and of a6 with a7;
/// this one has not.
const SKEWED: (&str, f64) = ("shoulder.position.y", 0.40);

/// Trajectory B with the skewed arm.
pub fn skewed() -> Inertial<8, 9> {
    let mut arm = Inertial::bp1a();
    arm.plant = with(arm.plant, &[SKEWED]);
    arm
}

/// The experiment after capture, the arm skewed and its ninth parameter as large as its eighth.
pub fn off_axis() -> Inertial<9, 10> {
    let mut arm = Inertial::mated();
    let changes = [SKEWED, ("target.com.x", -1.0), ("target.com.y", 1.5)];
    arm.plant = with(arm.plant, &changes);
    arm
}

/// Worst difference of regressor · α and the momentum that the experiment began with, perfect
/// sensors [N m s].
pub fn momentum_discrepancy<const P: usize, const A: usize>(
    experiment: &Inertial<P, A>,
    alpha: &SVector<f64, P>,
) -> f64 {
    let h_nms = number(&experiment.plant, "initial.momentum.z");
    let off = |sample| (momentum_regressor::<P>(sample).dot(alpha) - h_nms).abs();
    experiment.noise_free().iter().map(off).fold(0.0, f64::max)
}

#[test]
fn momentum_is_predicted_all_along_the_closed_loop_experiments() {
    fn worst<const P: usize, const A: usize>(experiment: &Inertial<P, A>) -> f64 {
        momentum_discrepancy(experiment, &truth(&experiment.plant))
    }
    // Drift of Runge–Kutta at 5 ms: 1e-10 N m s in 60 s before capture.
    demand(&[
        Claim::at_most("trajectory B, 60 s", worst(&Inertial::bp1a()), 1e-8),
        Claim::at_most("r0 skewed, 60 s", worst(&skewed()), 1e-8),
        Claim::at_most("mated, 120 s", worst(&Inertial::mated()), 1e-8),
        Claim::at_most("mated off the axis, 120 s", worst(&off_axis()), 1e-8),
    ]);
}

/// Mean square of the residual of the true parameters over the variance its row claims, one kind of
/// sensor noisy.
///
/// The estimator sees all noises at once, where the gyro hides the others (95 % of the variance).
pub fn residual_over_claim(experiment: &Inertial<9, 10>, claimed: &ChannelSigma) -> f64 {
    let (alpha, sigma) = (truth::<9>(&experiment.plant), claimed.in_channel_order());
    let record = experiment.record(1, 0);
    let of_sample = |sample| {
        let row = noisy_momentum_row::<9>(sample, experiment.settings.h_nms, &sigma);
        let residual = row.regressor.dot(&alpha) - row.observed;
        residual * residual / row.residual_variance(&alpha)
    };
    record.iter().map(of_sample).sum::<f64>() / record.len() as f64
}

/// The arm with its target off the axis, all sensors perfect but those of one kind, whose samples
/// have `sigma` and the step `lsb`.
pub fn one_kind_noisy(noisy: fn(&SensorKind) -> bool, sigma: f64, lsb: f64) -> Inertial<9, 10> {
    let mut experiment = off_axis();
    for sensor in &mut experiment.plant.sensors {
        let share = if noisy(&sensor.kind) { 1.0 } else { 0.0 };
        sensor.noise = Noise::PerSample(Quantity::known(share * sigma));
        sensor.resolution = Quantity::known(share * lsb);
    }
    experiment
}

pub fn is_angle(kind: &SensorKind) -> bool {
    matches!(kind, SensorKind::Encoder { .. })
}

#[test]
fn every_kind_of_sensor_leaves_the_residual_its_row_claims() {
    let kinds = [
        ("gyro", one_kind_noisy(|kind| matches!(kind, SensorKind::Gyro { .. }), 1e-3, 0.0)),
        ("joint rates", one_kind_noisy(|kind| matches!(kind, SensorKind::JointRate { .. }), 1e-3, 0.0)),
        ("joint angles", one_kind_noisy(is_angle, 1e-3, 1e-3)),
    ];
    for (kind, experiment) in kinds {
        // 12 000 samples: √(2/N) = 1.3 %, four of them; noise of 1e-3 makes second-order terms of
        // 1e-6.
        let ratio = residual_over_claim(&experiment, &sigma(&experiment.plant));
        demand(&[Claim::within(format!("{kind}, mean square over claim"), ratio, 0.948, 1.052)]);
    }
}

#[test]
fn parameters_read_off_the_bodies_are_those_of_the_closed_form() {
    const SCALED: [&str; 10] = [
        "hub.mass",
        "hub.inertia.zz",
        "link_1.mass",
        "link_1.com.x",
        "link_1.inertia.zz",
        "link_2.mass",
        "link_2.com.x",
        "link_2.inertia.zz",
        "elbow.position.x",
        "grasp.position.x",
    ];
    let nominal = Inertial::mated().plant;
    for seed in 0..50 {
        let stream = Stream::new(seed, "arm");
        let scaled = |(i, name): (usize, &&'static str)| {
            (*name, (0.5 + stream.uniform_pair(i as u64)[0]) * number(&nominal, name))
        };
        let mut changes: Vec<(&str, f64)> = SCALED.iter().enumerate().map(scaled).collect();
        changes.extend([("shoulder.position.x", stream.normal(20)), ("shoulder.position.y", stream.normal(21))]);
        let mated = with(nominal.clone(), &changes);
        let target = Target {
            mass_kg: number(&mated, "target.mass"),
            inertia_com_kg_m2: number(&mated, "target.inertia.zz"),
            grasp_to_com_m: ["target.com.x", "target.com.y"].map(|name| number(&mated, name)),
        };
        let closed = mated_parameters(&planar_arm(&mated), number(&mated, "grasp.position.x"), &target);
        assert!((truth::<9>(&mated) - closed).amax() < 1e-12 * closed.amax(), "mated, seed {seed}"); // rounding
        let mut alone = mated.clone();
        alone.bodies.retain(|body| body.name != "target");
        let closed = planar_arm(&alone).minimal_parameters();
        assert!((truth::<8>(&alone) - closed).amax() < 1e-12 * closed.amax(), "seed {seed}");
    }
}

/// Worst difference of accelerations under random torques over 200 random motions, relative to the
/// largest.
pub fn acceleration_discrepancy(plant: &Plant, alpha: &Alpha) -> f64 {
    let system = System::new(plant).expect("the arm of the benchmark");
    let mut workspace = Workspace::new(&system);
    let states = system.states();
    let state = |name: &str| states.iter().position(|state| state.name == name).expect("a state of the arm");
    let [angle_1, angle_2] = ["joint:shoulder", "joint:elbow"].map(state);
    let turning = ["body:hub.rz.rate", "joint:shoulder.rate", "joint:elbow.rate"].map(state);
    let mut of_motion = |seed| {
        let stream = Stream::new(seed, "motion");
        let x: Vec<f64> = (0..states.len()).map(|i| stream.normal(i as u64)).collect();
        let torque = [10.0 * stream.normal(20), 10.0 * stream.normal(21)];
        let mut x_dot = vec![0.0; x.len()];
        system.derivative(&mut workspace, 0.0, &x, &torque, &mut x_dot);
        let closed = accelerations(alpha, [x[angle_1], x[angle_2]], turning.map(|index| x[index]), torque);
        let bodies = SVector::<f64, 3>::from(turning.map(|index| x_dot[index]));
        closed.map_or(f64::INFINITY, |closed| (closed - bodies).amax() / bodies.amax())
    };
    (0..200).map(&mut of_motion).fold(0.0, f64::max)
}

/// Worst difference of the mean acceleration along the seed's sine [m/s²], `base_mass_kg` being
/// what `physics` believes.
pub fn slosh_discrepancy(base_mass_kg: f64) -> f64 {
    let bp2 = Slosh::bp2();
    let parameters = SloshParameters {
        slosh_mass_kg: number(&bp2.plant, "fuel.mass"),
        stiffness_n_m: number(&bp2.plant, "fuel.stiffness.x"),
        damping_n_s_m: number(&bp2.plant, "fuel.damping.x"),
    };
    let quiet = Slosh { plant: with(bp2.plant.clone(), &[("accelerometer.noise", 0.0)]), ..bp2 };
    let mut model = SloshPropagator::new(parameters, base_mass_kg, SloshState::default());
    let off = |sample: &physics::slosh_arc::SloshSample| {
        (sample.acceleration_m_s2 - model.step(sample.interval_s, sample.force_n)).abs()
    };
    quiet.record(0, 0).iter().map(off).fold(0.0, f64::max)
}

#[test]
fn a_sloshing_craft_under_held_thrust_accelerates_as_the_relative_coordinate_says() {
    // Rounding of velocities of metres per second, over 0.1 s, in 10⁴ steps; accelerations are 0.04
    // m/s².
    demand(&[Claim::at_most("m/s²", slosh_discrepancy(1004.5), 1e-12)]);
}

/// The appendage of the benchmark as `physics` describes it.
pub fn closed_form_appendage() -> Appendage {
    let plant = Modes::bp3a().plant;
    let at = |name: &str| number(&plant, name);
    let mode = |name: &str| Mode {
        frequency_hz: at(&format!("{name}.frequency")),
        damping_ratio: at(&format!("{name}.damping_ratio")),
    };
    Appendage {
        inertia_kg_m2: at("hub.inertia.zz") + at("hub.mass") * at("hub.com.x") * at("hub.com.x"),
        coupling: ["bending_1.rotation.z", "bending_2.rotation.z"].map(at),
        locked: ["bending_1", "bending_2"].map(mode),
    }
}

/// Residual of the simulated free decay with these poles, relative to the decay.
pub fn decay_residual(modes: &[Mode; 2]) -> f64 {
    let decay: Vec<f64> = Modes::bp3a().noise_free_decay().iter().flatten().copied().collect();
    let residual = refit_free_decay_residual(modes, &decay, SENSORS, 200.0).expect("four seconds");
    residual.residual_rms_m_s2 / residual.signal_rms_m_s2
}

#[test]
fn the_simulated_decay_holds_the_hub_free_modes_and_nothing_else() {
    let modes = closed_form_appendage().hub_free_modes().expect("a heavy hub");
    // The hub turns on at θ' = 2 Nms / 177.5 kg m² = 0.0113 rad/s: what a deflection adds to the
    // centripetal acceleration along the sensor's axis is θ'² / ω1² = 1.3e-6 of what its
    // oscillation gives.
    demand(&[Claim::at_most("decay", decay_residual(&modes), 2e-6)]);
}
