//! Laws of modes with known input, in a loop and out of it.

use crate::cases::noise::Noise;
use modal::known_input::{Identified, identify};
use modal::maximum_likelihood::Model;
use modal::record::Record;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 50.0;
const SAMPLES: usize = 4000;
const TRUTH: (f64, f64) = (2.0, 0.01);
const SENSOR: f64 = 1e-3;

/// One mode of unit mass; the input of a row comes from the measurement of that row, and a force
/// that is not recorded acts beside it.
fn simulated(seed: u64, mut input: impl FnMut(usize, f64) -> f64, force: f64) -> Record {
    let (mut sensor, mut other) = (Noise::new(seed), Noise::new(seed + 1_000_000));
    let (omega, period) = (TAU * TRUTH.0, 1.0 / RATE_HZ);
    let damped = omega * (1.0 - TRUTH.1 * TRUTH.1).sqrt();
    let (sine, cosine) = libm::sincos(damped * period);
    let (decay, ratio) = (libm::exp(-TRUTH.1 * omega * period), TRUTH.1 * omega / damped);
    let [a, b] = [decay * (cosine + ratio * sine), decay * sine / damped];
    let [c, d] = [-b * omega * omega, decay * (cosine - ratio * sine)];
    let (mut q, mut u, mut y) = ([0.0, 0.0], Vec::new(), Vec::new());
    for t in 0..SAMPLES {
        y.push(q[0] + SENSOR * sensor.normal());
        u.push(input(t, y[t]));
        let f = u[t] + force * other.normal();
        q = [a * q[0] + b * q[1] + (1.0 - a) / (omega * omega) * f, c * q[0] + d * q[1] + b * f];
    }
    Record::of_outputs(RATE_HZ, 1, y).with_input(1, u)
}

/// Proportional and derivative feedback with a held random reference.
fn loop_of(seed: u64, force: f64) -> Record {
    let (mut reference, mut level, mut before) = (Noise::new(seed + 2_000_000), 0.0, 0.0);
    let controlled = move |t: usize, y: f64| {
        if t.is_multiple_of(50) {
            level = 0.02 * reference.normal();
        }
        let u = level - 20.0 * y - 100.0 * (y - before);
        before = y;
        u
    };
    simulated(seed, controlled, force)
}

fn found(record: &Record) -> Identified {
    identify(record, Model::FREE, false, 6).unwrap()
}

/// Errors of frequency and damping in standard deviations.
fn z(found: &Identified) -> [f64; 2] {
    let (f, zeta, _) = found.fit.variances(0);
    [(found.fit.frequency_hz(0) - TRUTH.0) / f.sqrt(), (found.fit.damping_ratio(0) - TRUTH.1) / zeta.sqrt()]
}

#[test]
fn noise_in_the_sample_of_the_input_biases_no_mode() {
    for seed in 0..5 {
        let found = found(&loop_of(seed, 0.0));
        assert!(found.adequate && found.feedback, "{:?}", found.residual);
        assert_eq!(found.fit.poles.len(), 1, "seed {seed}: {:?}", found.fit.poles);
        // Ten deviates of unit variance: one beyond 4 in 1600 runs.
        assert!(z(&found).iter().all(|z| z.abs() < 4.0), "seed {seed}: {:?}", z(&found));
    }
}

#[test]
fn residuals_that_a_disturbance_colours_are_no_modes_of_output_error() {
    for seed in 0..3 {
        let found = found(&loop_of(seed, 0.5));
        let near = z(&found).iter().all(|z| z.abs() < 4.0);
        assert!(!found.adequate || found.assumes_no_disturbance() || near, "seed {seed}: {:?}", z(&found));
    }
}

#[test]
fn in_open_loop_there_is_no_feedback_and_no_assumption() {
    let mut drive = Noise::new(77);
    let record = simulated(5, move |_, _| drive.normal(), 0.0);
    let found = found(&record);
    assert!(found.adequate && !found.feedback && !found.assumes_no_disturbance());
    assert!(z(&found).iter().all(|z| z.abs() < 4.0), "{:?}", z(&found));
}

#[test]
fn absent_samples_leave_the_likelihood_and_nothing_else() {
    let (mut drive, mut lost) = (Noise::new(78), Noise::new(79));
    let mut level = 0.0;
    let held = move |t: usize, _: f64| {
        if t.is_multiple_of(40) {
            level = drive.normal();
        }
        level
    };
    let whole = simulated(6, held, 0.0);
    let mut record = whole.clone();
    record.outputs.iter_mut().filter(|_| lost.uniform() < 0.2).for_each(|y| *y = f64::NAN);
    let (all, some) = (found(&whole), found(&record));
    assert!(some.adequate && some.fit.poles.len() == 1, "{:?}", some.residual);
    assert!(z(&some).iter().all(|z| z.abs() < 4.0), "{:?}", z(&some));
    // A fifth fewer samples: sigmas larger by 1/sqrt(0.8) = 1.12, within their own scatter.
    let ratio = (some.fit.variances(0).1 / all.fit.variances(0).1).sqrt();
    assert!((1.0..1.3).contains(&ratio), "{ratio}");
}
