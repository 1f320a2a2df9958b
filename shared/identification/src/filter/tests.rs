use super::*;
use crate::fit::{EstimationSession, LinearisedProblem};
use crate::problem::Problem;
use crate::synthetic::{plant, problem, recording};
use dynamics::description::Plant;

fn whitened(session: &EstimationSession<'_>, linearised: &LinearisedProblem, noise: &NoiseModel) -> Vec<f64> {
    let mut columns = [linearised.nu.clone()];
    linearised.whiten(session, noise, &mut columns).unwrap();
    let [r] = columns;
    r
}

fn linearised<'p>(problem: &'p Problem) -> (EstimationSession<'p>, LinearisedProblem) {
    let session = EstimationSession::new(problem, 1).unwrap();
    let linearised = LinearisedProblem::new(&session, &problem.plant, &session.prior(), &session.noise).unwrap();
    (session, linearised)
}

#[test]
fn innovations_of_the_true_plant_are_white_and_of_unit_size() {
    for (name, duration_s) in [("pendulum", 10.0), ("oscillator", 2.0), ("drive_rig", 2.0), ("tank_planar", 400.0)] {
        let nominal = plant(name);
        let problem = problem(&nominal, recording(&nominal, 5, duration_s));
        let (session, linearised) = linearised(&problem);
        let r = whitened(&session, &linearised, &session.noise);
        let n = r.len() as f64;
        let size = r.iter().map(|r| r * r).sum::<f64>() / n;
        // mean of n squares: five standard errors of sqrt(2/n)
        assert!((size - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{name}: {size}");
        let channels = problem.plant.sensors.len();
        let rho: f64 = (channels..r.len()).map(|t| r[t] * r[t - channels]).sum::<f64>() / n;
        assert!(rho.abs() < 5.0 / n.sqrt(), "{name}: {rho}");
    }
}

#[test]
fn on_a_linear_plant_whitening_for_another_noise_is_the_filter_of_that_noise() {
    let nominal = plant("oscillator");
    let problem = problem(&nominal, recording(&nominal, 2, 0.6));
    let (session, first) = linearised(&problem);
    let mut other = session.noise.clone();
    other.input_sigma[0] *= 7.0;
    other.sensor_sigma[1] *= 0.3;
    let second = LinearisedProblem::new(&session, &problem.plant, &session.prior(), &other).unwrap();
    let (a, b) = (whitened(&session, &first, &other), whitened(&session, &second, &other));
    // derivatives by differences with steps of 1e-6: 1e-6 of the largest innovation
    let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-4, "{worst}");
    assert!(whitened(&session, &first, &session.noise).iter().zip(&a).any(|(a, b)| (a - b).abs() > 0.1));
}

/// Three accelerometers see eight states: what the first readings hardly tell swings in the wide
/// filter by a thousand sigma.
#[test]
fn where_the_pass_starts_leaves_the_likelihood_as_it_was_and_takes_the_swings_out_of_the_innovations() {
    let mut slow = plant("hub_appendage");
    slow.simulation.period_s = 12e-3;
    let nominal = crate::synthetic::with_effect(
        &slow,
        "mode_left_out",
        "mode:bending_2",
        &[("mass_ratio", 0.04), ("frequency", 17.0), ("damping_ratio", 0.02)],
    );
    let problem = problem(&nominal, recording(&nominal, 3, 3.0));
    let (mut session, _) = linearised(&problem);
    // nothing is known of its start, not even that the commands move it
    session.added = std::sync::Arc::new(vec![Vec::new()]);
    let narrow = LinearisedProblem::new(&session, &problem.plant, &session.prior(), &session.noise).unwrap();
    let timeline = &session.timelines[0];
    let mut propagator =
        Propagator::new(&problem, 0, &problem.instance(&problem.plant, &narrow.theta, 0), timeline).unwrap();
    let sigmas = narrow.linears[0].initial_sigma.clone();
    let wide = linearise(&mut propagator, &session.noise, &sigmas, &Start::prior(&sigmas)).unwrap();
    let [swing, none] = [&wide, &narrow.linears[0]].map(|linear| linear.peak(timeline));
    assert!(none < 6.0 && swing > 100.0, "{none} {swing}");
    let mut other = narrow.clone();
    (other.nu, other.linears) = (wide.nu.clone(), vec![wide]);
    let objective = |linearised: &LinearisedProblem| {
        linearised.objective(&session, &linearised.nu, &linearised.theta, &session.noise).unwrap()
    };
    let apart = objective(&narrow) - objective(&other);
    // both are about other trajectories, and centrifugal terms are not linear
    assert!(apart.abs() < 0.5, "{apart}");
}

#[test]
fn pull_is_what_a_pass_of_the_same_gains_from_the_mean_of_the_prior_sees_more() {
    let nominal = plant("oscillator");
    let problem = problem(&nominal, recording(&nominal, 2, 0.6));
    let (session, linearised) = linearised(&problem);
    let timeline = &session.timelines[0];
    let propagator =
        || Propagator::new(&problem, 0, &problem.instance(&problem.plant, &linearised.theta, 0), timeline).unwrap();
    let sigmas = linearised.linears[0].initial_sigma.clone();
    // a millimetre and two centimetres per second off, and gains that hardly mend it
    let start = Start { change: vec![1e-3, -0.02], sigma: vec![1e-5, 1e-4] };
    let linear = linearise(&mut propagator(), &session.noise, &sigmas, &start).unwrap();
    let mut nu = vec![0.0; timeline.value.len()];
    assert!(propagator().pass(&linear.frozen, &(0..linear.layout.len()).collect::<Vec<_>>(), &mut nu));
    let sigma = |k: usize| session.noise.sensor_sigma[timeline.channel[k]];
    let most = |list: &[f64]| list.iter().enumerate().map(|(k, x)| x.abs() / sigma(k)).fold(0.0, f64::max);
    let apart: Vec<f64> = nu.iter().zip(&linear.nu).map(|(a, b)| a - b).collect();
    assert!(most(&linear.pull) > 50.0 && most(&apart) < 1e-3, "{} {}", most(&linear.pull), most(&apart));
}

#[test]
fn coloured_noise_is_whitened_by_its_pole() {
    let nominal = plant("oscillator");
    let problem = problem(&nominal, crate::synthetic::coloured(&nominal, 4, 2.0, 0.8));
    let (session, linearised) = linearised(&problem);
    let rho = |r: &[f64]| (2..r.len()).map(|t| r[t] * r[t - 2]).sum::<f64>() / r.iter().map(|r| r * r).sum::<f64>();
    let mut right = session.noise.clone();
    right.pole.fill(0.8);
    assert!(rho(&whitened(&session, &linearised, &session.noise)) > 0.3);
    // five standard errors
    assert!(rho(&whitened(&session, &linearised, &right)).abs() < 5.0 / (session.samples as f64).sqrt());
}

#[test]
fn what_nothing_drives_gets_a_disturbance() {
    let names = |plant: &Plant| equip(plant).actuators.iter().map(|a| a.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&plant("pendulum")), ["disturbance_pivot"]);
    assert_eq!(names(&plant("oscillator")), ["shaker"]);
}

/// What acts is late by a part of the sampling: position and rate at the samples feel it by
/// different amounts, and the mean alone is the delay of neither.
#[test]
fn a_delay_or_a_lag_of_the_command_is_felt_by_angle_and_rate_as_the_simulation_has_it() {
    let sites = [("actuator_delay", "delay", 1.3e-3), ("actuator_lag", "time_constant", 2.1e-3)];
    for (kind, parameter, value) in sites {
        let mut nominal = plant("drive_rig");
        nominal.simulation.period_s = 10e-3;
        let with = crate::synthetic::with_effect(&nominal, kind, "actuator:motor", &[(parameter, value)]);
        let mut quiet = with.clone();
        quiet.actuators.iter_mut().for_each(|actuator| actuator.noise.value = 0.0);
        for sensor in &mut quiet.sensors {
            sensor.noise = dynamics::description::Noise::default();
            sensor.resolution.value = 0.0;
        }
        let problem = problem(&with, recording(&quiet, 1, 2.0));
        let (session, linearised) = linearised(&problem);
        let sigma = |sample: usize| session.noise.sensor_sigma[session.timelines[0].channel[sample]];
        let worst = linearised.nu.iter().enumerate().map(|(i, nu)| nu.abs() / sigma(i)).fold(0.0, f64::max);
        // the parts of the interval leave 1/60 of what the tilt mends, which is a few standard
        // deviations
        assert!(worst < 0.1, "{kind}: {worst} standard deviations");
    }
}

/// A lag far below the sampling shows the slope at the sample, and is continuous where the command
/// jumps into the reading.
#[test]
fn a_lag_of_an_accelerometer_is_felt_as_the_simulation_has_it() {
    for time_constant_s in [0.3e-3, 4e-3] {
        let mut nominal = plant("oscillator");
        nominal.simulation.period_s = 8e-3;
        let values = [("time_constant", time_constant_s)];
        let with = crate::synthetic::with_effect(&nominal, "sensor_lag", "sensor:acceleration", &values);
        let mut quiet = with.clone();
        quiet.actuators.iter_mut().for_each(|actuator| actuator.noise.value = 0.0);
        for sensor in &mut quiet.sensors {
            sensor.noise = dynamics::description::Noise::default();
            sensor.resolution.value = 0.0;
        }
        let problem = problem(&with, recording(&quiet, 1, 2.0));
        let (session, linearised) = linearised(&problem);
        let sigma = session.noise.sensor_sigma[1];
        let own = linearised.nu.iter().zip(&session.timelines[0].channel).filter(|(_, channel)| **channel == 1);
        let worst = own.skip(10).map(|(nu, _)| nu.abs() / sigma).fold(0.0, f64::max);
        // the parabola leaves a third order in period times frequency; a line between readings
        // leaves forty standard deviations
        assert!(worst < 0.4, "{time_constant_s}: {worst} standard deviations");
    }
}

/// They go through the recursion in eights and what is left of them: each feels its own numbers
/// only, in the same order.
#[test]
fn columns_whitened_together_are_bit_for_bit_those_whitened_alone() {
    let nominal = plant("oscillator");
    let lagged =
        crate::synthetic::with_effect(&nominal, "sensor_lag", "sensor:displacement", &[("time_constant", 3e-3)]);
    let problem = problem(&lagged, recording(&lagged, 2, 0.6));
    let (session, linearised) = linearised(&problem);
    let mut other = session.noise.clone();
    other.input_sigma[0] *= 7.0;
    other.pole.fill(0.6);
    // an eight and the rest, no two alike
    let turned = |k: usize| [&linearised.nu[37 * k..], &linearised.nu[..37 * k]].concat();
    let columns: Vec<Vec<f64>> = (0..11).map(turned).collect();
    for noise in [&session.noise, &other] {
        let mut together = columns.clone();
        linearised.whiten(&session, noise, &mut together).unwrap();
        for (k, (column, together)) in columns.iter().zip(&together).enumerate() {
            let mut alone = [column.clone()];
            linearised.whiten(&session, noise, &mut alone).unwrap();
            assert!(together.iter().zip(&alone[0]).all(|(a, b)| a.to_bits() == b.to_bits()), "column {k}");
        }
    }
}

#[test]
fn a_delayed_reading_of_an_instant_before_the_recording_tells_nothing() {
    let nominal = crate::synthetic::with_effect(&plant("drive_rig"), "sensor_delay", "sensor:rate", &[("delay", 4e-3)]);
    let mut recorded = recording(&nominal, 5, 1.0);
    let rate = recorded.channels.iter_mut().find(|channel| channel.name == "rate").unwrap();
    // whatever it reads
    rate.value[0] += 10.0;
    let problem = problem(&nominal, recorded);
    let (session, linearised) = linearised(&problem);
    let (linear, timeline) = (&linearised.linears[0], &session.timelines[0]);
    let channel = nominal.sensors.iter().position(|sensor| sensor.name == "rate").unwrap();
    let first = (0..timeline.value.len()).find(|sample| timeline.channel[*sample] == channel).unwrap();
    let row = &linear.measurement[first * linear.row_len()..(first + 1) * linear.row_len()];
    assert!(linear.nu[first] == 0.0 && row.iter().all(|h| *h == 0.0), "{} {row:?}", linear.nu[first]);
    let r = whitened(&session, &linearised, &session.noise);
    assert!(r.iter().all(|r| r.abs() < 5.0), "{:?}", r.iter().fold(0.0f64, |most, r| most.max(r.abs())));
}

#[test]
fn readings_that_a_stated_delay_puts_before_the_recording_tell_nothing_and_the_others_are_as_the_simulation_has_them() {
    let mut nominal = plant("drive_rig");
    let period_s = nominal.simulation.period_s;
    let channel = nominal.sensors.iter().position(|sensor| sensor.name == "rate").unwrap();
    let every_s = nominal.sensors[channel].period_s.map_or(period_s, |period| period.value);
    nominal.sensors[channel].delay_s = dynamics::description::Quantity::known(2.5 * every_s);
    let problem = problem(&nominal, recording(&nominal, 5, 1.0));
    let (session, linearised) = linearised(&problem);
    let (linear, timeline) = (&linearised.linears[0], &session.timelines[0]);
    let own: Vec<usize> = (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel).collect();
    let silent = |s: &&usize| {
        let row = &linear.measurement[*s * linear.row_len()..(*s + 1) * linear.row_len()];
        linear.nu[**s] == 0.0 && row.iter().all(|h| *h == 0.0)
    };
    let read: Vec<f64> = own.iter().filter(|s| !silent(s)).map(|s| timeline.stamp_s[*s]).collect();
    assert!(read.iter().all(|stamp| *stamp > 2.5 * every_s) && read[0] < 3.5 * every_s, "{:?}", &read[..3]);
    let r = whitened(&session, &linearised, &session.noise);
    assert!(r.iter().all(|r| r.abs() < 5.0), "{:?}", r.iter().fold(0.0f64, |most, r| most.max(r.abs())));
}

const TRACKER: &str = r#"
format = 1
name = "tracker"
about = "A free body with a gyro and a star tracker"
space = "spatial"

[[body]]
name = "bus"
mass = "18 kg"
inertia = ["0.12 kg*m^2", "0.15 kg*m^2", "0.1 kg*m^2", "0 kg*m^2", "0 kg*m^2", "0 kg*m^2"]
joint = { kind = "free" }

[[sensor]]
name = "gyro"
kind = "gyro"
body = "bus"
axis = "xyz"
noise = "0.1 mrad/s"

[[sensor]]
name = "star_tracker"
kind = "attitude"
body = "bus"
axis = "xyz"
noise = "0.5 mrad"

[initial]
"body:bus.rx" = { rate = { value = "0.3 rad/s", sigma = "0.01 rad/s" } }
"body:bus.ry" = { rate = { value = "-0.4 rad/s", sigma = "0.01 rad/s" } }
"body:bus.rz" = { rate = { value = "0.2 rad/s", sigma = "0.01 rad/s" } }

[simulation]
duration = "60 s"
period = "100 ms"
"#;

#[test]
fn a_star_tracker_may_tell_an_attitude_by_either_of_its_two_rotation_vectors() {
    let nominal = plant_file::parse("tracker.toml", TRACKER).unwrap().plant;
    let mut recorded = recording(&nominal, 7, 60.0);
    let own: Vec<usize> =
        (0..recorded.channels.len()).filter(|c| recorded.channels[*c].name.starts_with("star_tracker")).collect();
    let mut read = 0;
    for k in (0..recorded.channels[own[0]].value.len()).step_by(3) {
        let size = own.iter().map(|c| recorded.channels[*c].value[k].powi(2)).sum::<f64>().sqrt();
        if size > 2.0 {
            read += 1;
            own.iter().for_each(|c| recorded.channels[*c].value[k] *= 1.0 - core::f64::consts::TAU / size);
        }
    }
    assert!(own.len() == 3 && read > 20, "{read}");
    let problem = problem(&nominal, recorded);
    let (session, linearised) = linearised(&problem);
    let r = whitened(&session, &linearised, &session.noise);
    let loudest = r.iter().map(|r| r.abs()).fold(0.0, f64::max);
    // the largest of 3 600 normal numbers
    assert!(loudest < 5.0, "{loudest}");
}

/// An encoder without delay reads the angle: its innovation's variance is the angle's and its own
/// noise's.
#[test]
fn what_the_filter_knows_of_a_state_is_what_an_innovation_has_beside_its_own_noise() {
    let nominal = plant("pendulum");
    let problem = problem(&nominal, recording(&nominal, 5, 4.0));
    let (session, linearised) = linearised(&problem);
    let (linear, timeline) = (&linearised.linears[0], &session.timelines[0]);
    let sigmas = state_sigmas(linear, timeline, &session.noise).unwrap();
    let angle = sigmas[linear.names.iter().position(|name| name == "joint:pivot").unwrap()];
    let found = gains(linear, timeline, &session.noise).unwrap();
    let own = session.noise.sensor_sigma[0];
    let mut beside: Vec<f64> = found.factor.iter().map(|root| (root * root - own * own).max(0.0).sqrt()).collect();
    beside.sort_by(f64::total_cmp);
    let median = beside[beside.len() / 2];
    assert!((angle / median - 1.0).abs() < 0.05, "{angle:e} {median:e}");
}
