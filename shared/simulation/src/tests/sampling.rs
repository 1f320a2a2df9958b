//! Sample instants, stamps, rates, range and quantisation.

use super::plants::{self, q};
use crate::Simulator;
use dynamics::description::{Initial, InitialValue, Noise, Plant, SignalKind, Source};

/// A cart that moves with 0.5 m/s from 1 m.
fn coasting() -> Plant {
    let mut plant = plants::cart(vec![]);
    let value = InitialValue { coordinate: "joint:cart".to_owned(), position: q(1.0), rate: q(0.5) };
    plant.initial = Initial { values: vec![value], ..Initial::default() };
    plant
}

/// (stamp, value) of channel 0 over `periods`.
fn samples(plant: &Plant, periods: usize) -> Vec<(f64, f64)> {
    let mut simulator = Simulator::new(plant, 2, "cart").unwrap();
    let mut all = Vec::new();
    for _ in 0..periods {
        let row = simulator.step();
        all.extend(row.samples.iter().filter(|sample| sample.channel == 0).map(|sample| (sample.time_s, sample.value)));
    }
    all
}

#[test]
fn jittered_readings_belong_to_their_stamps() {
    let mut plant = coasting();
    plant.simulation.jitter_s = 2e-3;
    let taken = samples(&plant, 500);
    assert_eq!(taken.len(), 500);
    for (stamp, value) in &taken {
        assert!((value - (1.0 + 0.5 * stamp)).abs() < 1e-12, "{stamp}: {value}"); // rounding of 500 steps
    }
    let jitter: Vec<f64> = taken.iter().enumerate().map(|(k, (stamp, _))| stamp - 0.01 * k as f64).collect();
    let sigma = (jitter.iter().map(|j| j * j).sum::<f64>() / 500.0).sqrt();
    // cut at 2.25 sigma: variance falls to 0.89; relative standard error 1/√1000 = 3 %
    assert!((sigma / 2e-3 - 0.945).abs() < 0.1, "{sigma}");
    assert!(taken.windows(2).all(|pair| pair[0].0 < pair[1].0));
}

#[test]
fn a_delayed_sensor_says_what_was() {
    for delay in [0.004, 0.01, 0.0273] {
        let mut plant = coasting();
        plant.sensors[0].delay_s = q(delay);
        for (stamp, value) in samples(&plant, 100) {
            let then = (stamp - delay).max(0.0);
            assert!((value - (1.0 + 0.5 * then)).abs() < 1e-12, "{stamp}"); // rounding
        }
    }
}

#[test]
fn slow_and_fast_sensors_keep_their_own_time() {
    for (period, count) in [(0.05, 20), (0.0025, 400), (0.03, 34), (0.004, 250)] {
        let mut plant = coasting();
        plant.sensors[0].period_s = Some(q(period));
        let taken = samples(&plant, 100);
        assert_eq!(taken.len(), count, "period {period}");
        for (n, (stamp, value)) in taken.iter().enumerate() {
            assert!((stamp - period * n as f64).abs() < 1e-12);
            assert!((value - (1.0 + 0.5 * stamp)).abs() < 1e-12);
        }
    }
}

#[test]
fn means_are_of_the_interval_that_begins_at_the_stamp() {
    for period in [0.01, 0.03, 0.005] {
        let mut plant = plants::slosh();
        plant.simulation.integrator = dynamics::description::Integrator::RungeKutta4;
        plant.simulation.period_s = 0.01;
        plant.simulation.step_s = 0.01;
        plant.tanks.clear();
        plant.actuators[0].command = plants::always(SignalKind::Staircase { step: q(10.0), every_s: q(0.03) });
        plant.sensors[0].period_s = Some(q(period));
        for (stamp, value) in samples(&plant, 60) {
            let force = 10.0 * (1.0 + ((stamp + 1e-9) / 0.03).floor());
            assert!((value - force / 1004.5).abs() < 1e-12, "period {period}, {stamp}: {value}"); // rounding of Δv/Δt
        }
    }
}

#[test]
fn stamps_are_by_the_clock_of_the_source() {
    let mut plant = coasting();
    plant.sources = vec![Source { name: "imu".to_owned(), clock_offset_s: q(0.25), clock_skew: q(1e-4) }];
    plant.sensors[0].source = Some("imu".to_owned());
    for (k, (stamp, value)) in samples(&plant, 100).into_iter().enumerate() {
        let t = 0.01 * k as f64;
        assert!((stamp - ((1.0 + 1e-4) * t + 0.25)).abs() < 1e-14);
        assert!((value - (1.0 + 0.5 * t)).abs() < 1e-12);
    }
}

#[test]
fn noise_comes_before_range_and_range_before_quantisation() {
    let mut plant = coasting();
    plant.sensors[0].noise = Noise::PerSample(q(0.3));
    plant.sensors[0].range = Some(q(1.23));
    plant.sensors[0].resolution = q(0.1);
    let taken = samples(&plant, 400);
    assert!(taken.iter().all(|(_, value)| *value <= 1.2 + 1e-12 && (value / 0.1 - (value / 0.1).round()).abs() < 1e-9));
    let clipped = taken.iter().filter(|(_, value)| *value > 1.15).count();
    assert!(clipped > 200 && clipped < 400, "{clipped} of 400 at the limit"); // the mean passes 1.23 after 46 samples
}

#[test]
fn density_becomes_the_deviation_of_one_sample() {
    for period in [0.01, 0.0025, 0.05] {
        let mut plant = coasting();
        plant.sensors[0].noise = Noise::Density(q(2e-3));
        plant.sensors[0].period_s = Some(q(period));
        let errors: Vec<f64> = samples(&plant, 4000).iter().map(|(t, value)| value - (1.0 + 0.5 * t)).collect();
        let n = errors.len() as f64;
        let density = (errors.iter().map(|e| e * e).sum::<f64>() / n * period).sqrt();
        // relative standard error of a deviation 1/√(2N); 4.5 of them
        assert!((density / 2e-3 - 1.0).abs() < 4.5 / (2.0 * n).sqrt(), "{density}");
    }
}

#[test]
fn readings_settled_behind_a_low_pass_lag_by_its_time_constant() {
    let mut plant = coasting();
    plant.sensors[0].low_pass_hz = Some(q(2.0));
    let tau = 1.0 / (core::f64::consts::TAU * 2.0);
    plant.simulation.step_s = 0.005;
    for (stamp, value) in samples(&plant, 200) {
        // ramp through a first-order lag that starts settled
        let expected = 1.0 + 0.5 * (stamp - tau * (1.0 - (-stamp / tau).exp()));
        assert!((value - expected).abs() < 1e-12, "{stamp}: {value} {expected}"); // rounding
    }
}
