//! The evidence of a plant and its noise against importance sampling of the same integral.

use super::*;
use crate::evidence::model::{Ground, Model, settled};
use crate::noise::Noise;
use crate::synthetic::{plant, recording};
use identification::fit::fit;
use identification::problem::Problem;

const DRAWS: usize = 2500;

/// `ln ∫ p(D|θ, η) p(θ) p(η)` over unknowns and noise by draws from a normal density about the mode
/// with one and a half times its variance, and the standard error of that logarithm.
fn sampled(session: &EstimationSession<'_>, model: &Model) -> [f64; 2] {
    let prior = NoisePrior::new(session, &[]);
    let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
    let linear = Linearly { session, linearised, theta, extra: &[], room: &[] };
    let normal = linear.normal(&model.noise).unwrap();
    let root = normal.factor().unwrap().inverse().cholesky().unwrap().unpack() * 1.5f64.sqrt();
    let held = linear.held(&model.noise, &prior).unwrap();
    let wide: Vec<f64> = held.here(&model.noise).unwrap().second.iter().map(|second| (3.0 / second).sqrt()).collect();
    let mut noise = Noise::new(5);
    let logs: Vec<f64> = (0..DRAWS)
        .filter_map(|_| {
            let u = DVector::from_vec(noise.series(theta.len(), 1.0));
            let v = noise.series(wide.len(), 1.0);
            let z = &root * &u;
            let unknowns = theta.iter().zip(z.iter()).zip(&session.problem.unknowns);
            let at: Vec<f64> = unknowns.map(|((theta, z), unknown)| theta + z * unknown.sigma).collect();
            let coordinates = prior.coordinates().into_iter().zip(v.iter().zip(&wide));
            let eta = coordinates.fold(model.noise.clone(), |eta, (own, (v, w))| moved(&eta, own, v * w));
            let nu = session.innovations(&model.problem.plant, &at, &linearised.linears, &|_| true)?;
            let objective = linearised.objective(session, &nu, &at, &eta)? + prior.price(&eta);
            let drawn = u.norm_squared() + v.iter().map(|v| v * v).sum::<f64>();
            Some(-0.5 * objective + 0.5 * drawn)
        })
        .collect();
    let widths = root.diagonal().iter().chain(&wide).map(|width| libm::log(*width)).sum::<f64>();
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = logs.iter().map(|log| libm::exp(log - most)).collect();
    let mean = weights.iter().sum::<f64>() / DRAWS as f64;
    let spread = weights.iter().map(|w| (w / mean - 1.0).powi(2)).sum::<f64>() / DRAWS as f64;
    [most + libm::log(mean) + widths, (spread / DRAWS as f64).sqrt()]
}

#[test]
fn the_evidence_of_a_plant_with_its_noise_is_the_integral_over_both() {
    for (name, duration_s) in [("pendulum", 2.0), ("drive_rig", 1.5)] {
        let nominal = plant(name);
        let problem = Problem::new(&nominal, &[recording(&nominal, 3, duration_s)], &[]).unwrap();
        let session = EstimationSession::new(&problem, 1).unwrap();
        let stated = fit(&session, &nominal, &session.prior(), &session.noise, 4).unwrap();
        let start = (session.prior(), &stated.theta[..]);
        let model = settled(Ground { session: &session }, &[], problem.clone(), start, &session.noise).unwrap();
        let [summed, error] = sampled(&session, &model);
        assert!(error < 0.2, "{name}: draws miss the mode, {error}");
        // Laplace's own error: an unstated disturbance's 0.15 nats each, and skewness
        assert!(
            (model.log_marginal - summed).abs() < 0.4 + 3.0 * error,
            "{name}: {} {summed} ± {error}",
            model.log_marginal
        );
    }
}
