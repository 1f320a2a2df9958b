//! Likelihood of a slosh model over an arc: residuals, exact sensitivities, information.
//!
//! The truth has no process noise, so output error is the maximum likelihood. Unknowns, in this order:
//! `[ms, ks, cs, r0, ṙ0, bias]`; damping enters linearly because a short arc may well say it is negative.

use nalgebra::{Matrix6, Vector2, Vector6};
use serde::{Deserialize, Serialize};

use crate::slosh::{SloshParameters, SloshState, TransitionWithSensitivity};
use crate::slosh_arc::{SloshArc, SloshBlock};
use crate::slosh_estimator::SAME_LENGTH;

/// Which unknowns are estimated; the others are known to be zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SloshUnknowns {
    /// Mass, stiffness, damping; quiescent start, calibrated accelerometer.
    Parameters,
    /// Also the slosh state at the start of the arc and the accelerometer bias.
    ParametersStateBias,
}

impl SloshUnknowns {
    pub fn count(self) -> usize {
        match self {
            Self::Parameters => 3,
            Self::ParametersStateBias => 6,
        }
    }
}

/// A complete hypothesis about one arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshHypothesis {
    pub parameters: SloshParameters,
    /// At the start of the arc.
    pub state: SloshState,
    pub bias_m_s2: f64,
}

impl SloshHypothesis {
    pub(crate) fn moved(&self, step: &Vector6<f64>) -> Self {
        let (p, s) = (&self.parameters, &self.state);
        Self {
            parameters: SloshParameters {
                slosh_mass_kg: p.slosh_mass_kg + step[0],
                stiffness_n_m: p.stiffness_n_m + step[1],
                damping_n_s_m: p.damping_n_s_m + step[2],
            },
            state: SloshState { displacement_m: s.displacement_m + step[3], velocity_m_s: s.velocity_m_s + step[4] },
            bias_m_s2: self.bias_m_s2 + step[5],
        }
    }

    pub(crate) fn is_possible(&self) -> bool {
        self.parameters.slosh_mass_kg > 0.0 && self.parameters.stiffness_n_m >= 0.0
    }
}

/// χ² and its quadratic model at one hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Likelihood {
    pub chi_square: f64,
    /// `Jᵀ W J`; rows of unknowns that are not estimated are those of the identity.
    pub information: Matrix6<f64>,
    /// `Jᵀ W e`, zero where not estimated.
    pub gradient: Vector6<f64>,
    pub end: SloshState,
}

/// Walks the arc once. `on_residual` receives each block's residual over its standard deviation.
/// Cost about 40 ns per block; transitions are computed again only where the block length changes.
pub(crate) fn likelihood<const N: usize>(
    arc: &SloshArc<N>,
    base_mass_kg: f64,
    hypothesis: &SloshHypothesis,
    unknowns: SloshUnknowns,
    mut on_residual: impl FnMut(f64),
) -> Likelihood {
    let mut walk = Walk::new(base_mass_kg, hypothesis, arc.block_length_s());
    let mut sums = Likelihood {
        chi_square: 0.0,
        information: Matrix6::zeros(),
        gradient: Vector6::zeros(),
        end: hypothesis.state,
    };
    for block in arc.blocks() {
        let (predicted, sensitivity) = walk.step(&block);
        let weight = 1.0 / block.variance_m2_s2;
        let residual = block.delta_v_m_s - predicted;
        on_residual(residual * libm::sqrt(weight));
        sums.chi_square += residual * residual * weight;
        sums.gradient += sensitivity * (residual * weight);
        sums.information += sensitivity * (sensitivity * weight).transpose();
    }
    sums.end = SloshState { displacement_m: walk.state[0], velocity_m_s: walk.state[1] };
    for i in unknowns.count()..6 {
        sums.gradient[i] = 0.0;
        sums.information.fill_row(i, 0.0);
        sums.information.fill_column(i, 0.0);
        sums.information[(i, i)] = 1.0;
    }
    sums
}

/// Slosh state and its derivatives, block after block.
struct Walk {
    kappa: f64,
    gamma: f64,
    base_mass_kg: f64,
    bias_m_s2: f64,
    parameters: SloshParameters,
    length_s: f64,
    transition: TransitionWithSensitivity,
    state: Vector2<f64>,
    /// By κ, γ, r0, ṙ0.
    derivatives: [Vector2<f64>; 4],
}

impl Walk {
    fn new(base_mass_kg: f64, hypothesis: &SloshHypothesis, length_s: f64) -> Self {
        let parameters = hypothesis.parameters;
        let mu = parameters.reduced_mass_kg(base_mass_kg);
        let (kappa, gamma) = (parameters.stiffness_n_m / mu, parameters.damping_n_s_m / mu);
        Self {
            kappa,
            gamma,
            base_mass_kg,
            bias_m_s2: hypothesis.bias_m_s2,
            parameters,
            length_s,
            transition: TransitionWithSensitivity::new(kappa, gamma, length_s, base_mass_kg),
            state: Vector2::new(hypothesis.state.displacement_m, hypothesis.state.velocity_m_s),
            derivatives: [Vector2::zeros(), Vector2::zeros(), Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)],
        }
    }

    /// Predicted Δv of the block and its derivatives by `[ms, ks, cs, r0, ṙ0, bias]`.
    fn step(&mut self, block: &SloshBlock) -> (f64, Vector6<f64>) {
        if (block.length_s - self.length_s).abs() > SAME_LENGTH * block.length_s {
            self.length_s = block.length_s;
            self.transition = TransitionWithSensitivity::new(self.kappa, self.gamma, self.length_s, self.base_mass_kg);
        }
        let (transition, force, old) = (&self.transition, block.force_vector(), self.state);
        self.state = transition.value.apply(&old, &force);
        let slosh_dv = self.state[1] - old[1];
        let phi = &transition.value.phi;
        let driven = [transition.by_kappa.apply(&old, &force), transition.by_gamma.apply(&old, &force)];
        let mut velocity_change = [0.0; 4];
        for (i, derivative) in self.derivatives.iter_mut().enumerate() {
            let next = phi * *derivative + driven.get(i).copied().unwrap_or_default();
            velocity_change[i] = next[1] - derivative[1];
            *derivative = next;
        }
        let (m_s, k, c) = (self.parameters.slosh_mass_kg, self.parameters.stiffness_n_m, self.parameters.damping_n_s_m);
        let total = self.base_mass_kg + m_s;
        let base_dv = (block.force.impulse_n_s - m_s * slosh_dv) / total;
        let [by_kappa, by_gamma, by_r, by_v] = velocity_change.map(|change| -m_s / total * change);
        // κ = k/μ, γ = c/μ, 1/μ = 1/m0 + 1/ms.
        let per_mu = 1.0 / self.base_mass_kg + 1.0 / m_s;
        let direct = -(slosh_dv + base_dv) / total;
        let by_mass = direct - (by_kappa * k + by_gamma * c) / (m_s * m_s);
        let sensitivity = Vector6::new(by_mass, by_kappa * per_mu, by_gamma * per_mu, by_r, by_v, block.length_s);
        (base_dv + self.bias_m_s2 * block.length_s, sensitivity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slosh::tests::{BASE_MASS_KG, TANK};
    use crate::slosh_arc::SloshSample;
    use std::vec::Vec;

    #[test]
    fn sensitivities_of_every_unknown_equal_central_differences() {
        let mut arc = SloshArc::<64>::default();
        for k in 0..300 {
            let force_n = if k % 90 < 40 { 44.0 } else { -20.0 };
            arc.push(&SloshSample { interval_s: 1.0, force_n, acceleration_m_s2: 0.0, sigma_m_s2: 1.0 })
                .expect("finite");
        }
        let at = SloshHypothesis {
            parameters: TANK,
            state: SloshState { displacement_m: 0.4, velocity_m_s: 0.02 },
            bias_m_s2: 1e-5,
        };
        let predict = |hypothesis: &SloshHypothesis| {
            let mut walk = Walk::new(BASE_MASS_KG, hypothesis, arc.block_length_s());
            arc.blocks().map(|block| walk.step(&block)).collect::<Vec<_>>()
        };
        let analytic = predict(&at);
        let steps = Vector6::new(1e-3, 1e-6, 1e-6, 1e-4, 1e-5, 1e-7);
        for i in 0..6 {
            let mut step = Vector6::zeros();
            step[i] = steps[i];
            let (plus, minus) = (predict(&at.moved(&step)), predict(&at.moved(&-step)));
            let size = analytic.iter().map(|(_, s)| s[i].abs()).fold(0.0, f64::max);
            for ((a, p), m) in analytic.iter().zip(plus).zip(minus) {
                let difference = (p.0 - m.0) / (2.0 * steps[i]);
                assert!((a.1[i] - difference).abs() < 1e-6 * size, "unknown {i}"); // truncation (step/value)², rounding
            }
        }
    }
}
