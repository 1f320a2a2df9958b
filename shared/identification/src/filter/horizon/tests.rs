//! Predictions over a horizon against the filter's own, and against their variance.

use super::*;
use crate::filter::{gains, whiten};
use crate::fit::{EstimationSession, LinearisedProblem};
use crate::synthetic::{plant, problem, recording};

fn about(name: &str, duration_s: f64, factor: f64, seen: &mut dyn FnMut(&Linear, &Timeline, &NoiseModel)) {
    let nominal = plant(name);
    let problem = problem(&nominal, recording(&nominal, 3, duration_s));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let found = LinearisedProblem::new(&session, &nominal, &session.prior(), &session.noise).unwrap();
    let mut noise = session.noise.clone();
    noise.input_sigma.iter_mut().for_each(|sigma| *sigma *= factor);
    seen(&found.linears[0], &session.timelines[0], &noise);
}

#[test]
fn a_window_of_one_event_is_the_filter_s_own_prediction_of_the_first_channel_under_any_noise() {
    for (name, factor) in [("drive_rig", 1.0), ("drive_rig", 3.0), ("pendulum", 2.0)] {
        about(name, 2.0, factor, &mut |linear, timeline, noise| {
            let found = ahead((linear, &linear.nu), timeline, noise, 1, 10).unwrap();
            let own = gains(linear, timeline, noise).unwrap();
            let mut r = linear.nu.clone();
            whiten(linear, timeline, &own, &mut [&mut r]);
            for (k, event) in timeline.events.iter().enumerate().skip(11).filter(|(_, event)| event.count > 0) {
                // of an event's samples the first one is predicted without the others
                let (root, sample) = (own.factor[own.factor_first[k]], event.first);
                let off = found.residual[sample] / root - r[sample];
                assert!(off.abs() < 1e-6 && (found.variance[sample].sqrt() / root - 1.0).abs() < 1e-9, "{name}: {off}");
            }
            assert!(found.residual[..timeline.events[10].first].iter().all(|r| r.is_nan()));
        });
    }
}

#[test]
fn a_right_plant_is_off_by_what_its_noise_explains_over_any_horizon() {
    about("drive_rig", 30.0, 1.0, &mut |linear, timeline, noise| {
        for window in [1, 20, 100] {
            let found = ahead((linear, &linear.nu), timeline, noise, window, 10).unwrap();
            let all = found.residual.iter().zip(&found.variance).filter(|(_, v)| v.is_finite());
            let (sum, count) = all.fold((0.0, 0.0), |(sum, count), (e, v)| (sum + e * e / v, count + 1.0));
            // some twenty windows at least, each about one draw
            assert!((0.5..1.6).contains(&(sum / count)), "{window}: {}", sum / count);
        }
    });
}
