//! Two formulations of the same physics: bodies and matrix exponentials (`plant`) against closed forms (`physics`).

use crate::claims::{Claim, demand};
use console::bench::inertial::{Inertial, momentum_sample, sigma, truth};
use console::bench::modes::Modes;
use nalgebra::SVector;
use physics::appendage::{Appendage, Mode, refit_free_decay_residual};
use physics::free_floating::{Alpha, PlanarArm, accelerations};
use physics::mated;
use physics::momentum::{ChannelSigma, momentum_regressor, noisy_momentum_row};
use physics::slosh::{SloshPropagator, SloshState};
use plant::appendage::{AppendageParameters, SENSORS};
use plant::arm::{ArmMeasurement, ArmNoise, ArmState, FreeFloatingArm};
use plant::arm_parameters::{ArmParameters, Target};
use plant::chain::{Body, Chain, Motion};
use plant::fourier_reference::FourierReference;
use plant::noise::Stream;
use plant::slosh::{SloshTruth, sine_force_n};

/// The table's arm has equal components of r0, which hides a swap of a4 with a5 and of a6 with a7; this one has not.
pub const SKEWED: ArmParameters = ArmParameters { r0_m: [0.99, 0.40], ..ArmParameters::paper_table_ii() };
pub const TARGET: Target = Target { mass_kg: 150.0, com_from_grasp_m: [0.60, 0.15], inertia_com_kg_m2: 40.0 };

/// Its ninth parameter is as large as its eighth.
pub const OFF_AXIS: ArmParameters = SKEWED.with_target(Target { com_from_grasp_m: [-1.0, 1.5], ..TARGET });

/// Any motion of the arm, its base drifting too.
fn random_motion(seed: u64) -> Motion<5> {
    let stream = Stream::new(seed, "motion");
    let scales = [3.0, 3.0, 2.0, 2.0, 2.0, 0.1, 0.1, 0.3, 0.3, 0.3];
    let draw = |i: usize| scales[i] * stream.normal(i as u64);
    Motion { q: SVector::from_fn(|i, _| draw(i)), q_dot: SVector::from_fn(|i, _| draw(5 + i)) }
}

/// Worst difference of regressor · α and the momentum of the bodies over 200 random motions [N m s].
pub fn momentum_discrepancy<const P: usize>(arm: &ArmParameters, alpha: &SVector<f64, P>) -> f64 {
    let reference = FourierReference::trajectory_b();
    let mut simulator = FreeFloatingArm::new(arm, reference, &ArmNoise::none(), 68.0, 0.01, 0, "law");
    let of_motion = |seed| {
        simulator.restore(ArmState { motion: random_motion(seed), sample: 0, excited_sample: 0 });
        let at = simulator.truth();
        let measured = ArmMeasurement {
            omega0_z_rad_s: at.omega0_z_rad_s,
            joint_angle_rad: at.joint_angle_rad,
            joint_rate_rad_s: at.joint_rate_rad_s,
            joint_torque_nm: [0.0; 2],
        };
        let predicted = momentum_regressor::<P>(&momentum_sample(&measured)).dot(alpha);
        (predicted - at.invariants.angular_momentum_com_nms).abs()
    };
    (0..200).map(of_motion).fold(0.0, f64::max)
}

#[test]
fn momentum_of_the_bodies_is_the_regressor_times_the_parameters_read_off_the_bodies() {
    let mated = SKEWED.with_target(TARGET);
    demand(&[
        // Momenta of up to 10³ N m s: rounding 1e-12.
        Claim::at_most(
            "table II",
            momentum_discrepancy::<8>(&ArmParameters::paper_table_ii(), &truth(&ArmParameters::paper_table_ii())),
            1e-10,
        ),
        Claim::at_most("r0 skewed", momentum_discrepancy::<8>(&SKEWED, &truth(&SKEWED)), 1e-10),
        Claim::at_most("mated", momentum_discrepancy::<9>(&mated, &truth(&mated)), 1e-10),
    ]);
}

#[test]
fn momentum_is_predicted_all_along_the_closed_loop_experiments() {
    fn worst<const P: usize, const A: usize>(experiment: &Inertial<P, A>) -> f64 {
        let alpha = truth::<P>(&experiment.arm);
        let record = experiment.record(&ArmNoise::none(), 0, 0);
        record
            .iter()
            .map(|m| (momentum_regressor::<P>(&momentum_sample(m)).dot(&alpha) - 68.0).abs())
            .fold(0.0, f64::max)
    }
    // Drift of Runge–Kutta at 5 ms: 1e-10 N m s in 60 s before capture.
    demand(&[
        Claim::at_most("trajectory B, 60 s", worst(&Inertial::bp1a()), 1e-8),
        Claim::at_most("mated, 120 s", worst(&Inertial::mated()), 1e-8),
    ]);
}

/// Mean square of the residual of the true parameters over the variance its row claims, one kind of sensor noisy.
///
/// The estimator sees all noises at once, where the gyro hides the others (95 % of the variance).
pub fn residual_over_claim(arm: &ArmParameters, noise: ArmNoise, claimed: &ChannelSigma) -> f64 {
    let experiment = Inertial::<9, 10> { arm: *arm, ..Inertial::mated() };
    let (alpha, sigma) = (truth::<9>(arm), claimed.in_channel_order());
    let record = experiment.record(&noise, 1, 0);
    let of_sample = |measured: &ArmMeasurement| {
        let row = noisy_momentum_row::<9>(&momentum_sample(measured), 68.0, &sigma);
        let residual = row.regressor.dot(&alpha) - row.observed;
        residual * residual / row.residual_variance(&alpha)
    };
    record.iter().map(of_sample).sum::<f64>() / record.len() as f64
}

#[test]
fn every_kind_of_sensor_leaves_the_residual_its_row_claims() {
    let kinds = [
        ("gyro", ArmNoise { gyro_arw_rad_sqrt_s: 1e-4, ..ArmNoise::none() }),
        ("joint rates", ArmNoise { joint_rate_sigma_rad_s: 1e-3, ..ArmNoise::none() }),
        ("joint angles", ArmNoise { joint_angle_sigma_rad: 1e-3, joint_angle_lsb_rad: 1e-3, ..ArmNoise::none() }),
    ];
    for (kind, noise) in kinds {
        // 12 000 samples: √(2/N) = 1.3 %, four of them; noise of 1e-3 makes second-order terms of 1e-6.
        let ratio = residual_over_claim(&OFF_AXIS, noise, &sigma(&noise));
        demand(&[Claim::within(format!("{kind}, mean square over claim"), ratio, 0.948, 1.052)]);
    }
}

fn closed_form(arm: &ArmParameters) -> PlanarArm {
    PlanarArm {
        mass_kg: [arm.base_mass_kg, arm.link_mass_kg[0], arm.link_mass_kg[1]],
        inertia_com_kg_m2: [arm.base_inertia_com_kg_m2, arm.link_inertia_com_kg_m2[0], arm.link_inertia_com_kg_m2[1]],
        base_to_joint_m: arm.r0_m,
        joint_to_com_m: arm.l_m,
        com_to_next_m: arm.r_m[0],
    }
}

#[test]
fn parameters_read_off_the_bodies_are_those_of_the_closed_form() {
    for seed in 0..50 {
        let stream = Stream::new(seed, "arm");
        let factor = |i: u64| 0.5 + stream.uniform_pair(i)[0];
        let mut arm = ArmParameters { r0_m: [stream.normal(10), stream.normal(11)], ..ArmParameters::paper_table_ii() };
        arm.base_mass_kg *= factor(0);
        arm.base_inertia_com_kg_m2 *= factor(1);
        for link in 0..2 {
            arm.link_mass_kg[link] *= factor(2 + link as u64);
            arm.link_inertia_com_kg_m2[link] *= factor(4 + link as u64);
            arm.l_m[link] *= factor(6 + link as u64);
            arm.r_m[link] *= factor(8 + link as u64);
        }
        let (read, closed) = (truth::<8>(&arm), closed_form(&arm).minimal_parameters());
        assert!((read - closed).amax() < 1e-12 * closed.amax(), "seed {seed}"); // rounding
        let held = Target { mass_kg: 150.0 * factor(12), ..TARGET };
        let target = mated::Target {
            mass_kg: held.mass_kg,
            inertia_com_kg_m2: held.inertia_com_kg_m2,
            grasp_to_com_m: held.com_from_grasp_m,
        };
        let closed = mated::mated_parameters(&closed_form(&arm), arm.l_m[1] + arm.r_m[1], &target);
        let read = truth::<9>(&arm.with_target(held));
        assert!((read - closed).amax() < 1e-12 * closed.amax(), "mated, seed {seed}");
    }
}

/// Worst difference of accelerations under random torques over 200 random motions, relative to their size.
pub fn acceleration_discrepancy(arm: &ArmParameters, alpha: &Alpha) -> f64 {
    let body = |mass_kg, inertia_com_kg_m2, com_m, outboard_joint_m| Body {
        mass_kg,
        inertia_com_kg_m2,
        com_m,
        outboard_joint_m,
    };
    let link = |i: usize| {
        body(arm.link_mass_kg[i], arm.link_inertia_com_kg_m2[i], [arm.l_m[i], 0.0], [arm.l_m[i] + arm.r_m[i], 0.0])
    };
    let base = body(arm.base_mass_kg, arm.base_inertia_com_kg_m2, [0.0, 0.0], arm.r0_m);
    let chain = Chain::<3, 5>::new([base, link(0), link(1)]);
    let of_motion = |seed| {
        let (motion, stream) = (random_motion(seed), Stream::new(seed, "torque"));
        let torque = [10.0 * stream.normal(0), 10.0 * stream.normal(1)];
        let bodies = chain.acceleration(&motion, &SVector::from([0.0, 0.0, 0.0, torque[0], torque[1]]));
        let rates = [motion.q_dot[2], motion.q_dot[3], motion.q_dot[4]];
        let closed = accelerations(alpha, [motion.q[3], motion.q[4]], rates, torque);
        closed.map_or(f64::INFINITY, |closed| (closed - bodies.fixed_rows::<3>(2)).amax() / bodies.amax())
    };
    (0..200).map(of_motion).fold(0.0, f64::max)
}

#[test]
fn accelerations_of_the_chain_are_those_of_the_closed_form() {
    // Rounding times the condition of the mass matrix, some hundreds.
    demand(&[Claim::at_most("relative", acceleration_discrepancy(&SKEWED, &truth(&SKEWED)), 1e-11)]);
}

/// Worst difference of the mean acceleration along the seed's sine [m/s²], `base_mass_kg` being what `physics` believes.
pub fn slosh_discrepancy(base_mass_kg: f64) -> f64 {
    let tank = plant::slosh::SloshParameters::benchmark();
    let mut craft = SloshTruth::new(&tank, 0.1, 0.0, 0, "law");
    let parameters = physics::slosh::SloshParameters {
        slosh_mass_kg: tank.m_s_kg,
        stiffness_n_m: tank.k_s_n_m,
        damping_n_s_m: tank.c_s_n_s_m,
    };
    let mut model = SloshPropagator::new(parameters, base_mass_kg, SloshState::default());
    let step = |k: u32| {
        let force_n = sine_force_n(0.1 * (f64::from(k) + 0.5), 44.0, 0.01);
        (craft.step(force_n).acceleration_m_s2 - model.step(0.1, force_n)).abs()
    };
    (0..10_000).map(step).fold(0.0, f64::max)
}

#[test]
fn two_bodies_held_exactly_accelerate_as_the_relative_coordinate_says() {
    // Rounding of velocities of metres per second, over 0.1 s, in 10⁴ steps; accelerations are 0.04 m/s².
    demand(&[Claim::at_most("m/s²", slosh_discrepancy(1004.5), 1e-12)]);
}

/// The appendage of the benchmark as `physics` describes it.
pub fn closed_form_appendage() -> Appendage {
    let design = AppendageParameters::design();
    let (coupling, locked) = (design.coupling(), design.hub_locked_modes());
    let mode = |k: usize| Mode { frequency_hz: locked[k].0, damping_ratio: locked[k].1 };
    Appendage {
        inertia_kg_m2: design.total_inertia_kg_m2(),
        coupling: [coupling[0], coupling[1]],
        locked: [mode(0), mode(1)],
    }
}

/// Worst relative difference of frequency and damping from the eigenvalues of the simulated system.
pub fn mode_discrepancy(modes: &[Mode; 2]) -> f64 {
    let numeric = AppendageParameters::design().modes();
    let differ = |(closed, numeric): (&Mode, &plant::appendage::SystemMode)| {
        let frequency = (closed.frequency_hz / numeric.frequency_hz - 1.0).abs();
        frequency.max((closed.damping_ratio / numeric.damping_ratio - 1.0).abs())
    };
    modes.iter().zip(&numeric).map(differ).fold(0.0, f64::max)
}

/// Residual of the simulated free decay with these poles, relative to the decay.
pub fn decay_residual(modes: &[Mode; 2]) -> f64 {
    let record = Modes::bp3a().record(0.0, 0, 0);
    let decay: Vec<f64> = record[200..].iter().flatten().copied().collect();
    let residual = refit_free_decay_residual(modes, &decay, SENSORS, 200.0).expect("four seconds");
    residual.residual_rms_m_s2 / residual.signal_rms_m_s2
}

#[test]
fn eigenvalues_of_the_simulated_appendage_are_the_hub_free_modes_and_its_decay_holds_nothing_else() {
    let modes = closed_form_appendage().hub_free_modes().expect("a heavy hub");
    // Rounding, times 1/ζ = 10² for the damping.
    demand(&[
        Claim::at_most("modes", mode_discrepancy(&modes), 1e-11),
        Claim::at_most("decay", decay_residual(&modes), 1e-9),
    ]);
}
