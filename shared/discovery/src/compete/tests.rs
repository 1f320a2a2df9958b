use super::subsets::tests::column;
use super::*;
use crate::synthetic::{plant, problem, recording, with_effect};

/// The hub of `effect`, its amplitude found as so many of its standard errors.
fn significant_at(kind: &str, site: &str, values: &[(&str, f64)], sigmas: f64) -> bool {
    let nominal = plant("hub_appendage");
    let problem = problem(&nominal, recording(&nominal, 3, 2.0));
    let session = EstimationSession::new(&problem, 1).unwrap();
    let mut augmented = with_effect(&nominal, kind, site, values);
    augmented.effects[0].values[0].1.sigma = Some(values[0].1);
    let augmented = problem.with_plant(&augmented);
    let own = EstimationSession::like(&session, &augmented).unwrap();
    let mut fit = identification::fit::fit(&own, &augmented.plant, &own.prior(), &own.noise, 1).unwrap();
    let at = augmented.unknowns.iter().position(|unknown| unknown.parameter.starts_with("effect.")).unwrap();
    fit.theta[at] = sigmas * fit.sigma[at];
    let noise = session.noise.clone();
    let (plant, optima) = (augmented.plant.clone(), Vec::new());
    drop(own);
    let refit = FittedModel { plant, problem: augmented, fit, noise: noise.clone(), objective: 0.0, free: 1, optima };
    let subset = Subset { members: vec![0], free: 1, bic: 0.0, noise: noise.clone(), amplitudes: vec![vec![1.0]] };
    let (objective, ratio, p, bic, veto, free) = (0.0, 0.0, 1.0, 0.0, Veto::Passed, 1);
    let (is_settled, is_compared, refit) = (true, true, Some(refit));
    let hypothesis =
        ModelHypothesis { subset, objective, ratio, p, noise, veto, refit, is_settled, is_compared, bic, free };
    hypothesis.all_amplitudes_significant(&session, &[column(kind, site, 1)])
}

/// The free start of a mode fits any tone of a reading, whatever its share.
#[test]
fn a_mode_of_zero_share_is_insignificant_and_a_law_without_a_start_of_its_own_is_not_tested() {
    let mode = [("mass_ratio", 5e-3), ("frequency", 16.0), ("damping_ratio", 4e-3)];
    for (sigmas, expected) in [(1.0, false), (3.0, true)] {
        assert_eq!(significant_at("mode_left_out", "mode:bending_2", &mode, sigmas), expected, "{sigmas}");
    }
    // of that the ratio of likelihoods has spoken
    assert!(significant_at("sensor_bias", "sensor:acceleration_10", &[("bias", 1e-3)], 1.0));
}
