//! Likelihood of a slosh model over an arc: residuals, exact sensitivities, information.
//!
//! The truth has no process noise, so output error is the maximum likelihood. Unknowns, in this order:
//! `[ms, ks, cs, r0, ṙ0, bias]`; damping enters linearly because a short arc may well say it is negative. Behind every
//! gap the slosh state is unknown again; those states are solved and eliminated where they arise.

use nalgebra::{Matrix2, Matrix2x4, Matrix4, Matrix4x2, Matrix6, Vector2, Vector4, Vector6};
use serde::{Deserialize, Serialize};

use crate::slosh::{NeighbouringSensitivities, SloshParameters, SloshState, TransitionWithSensitivity};
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
    /// At the start of the arc; an estimate reports it, a fit solves it again.
    pub state: SloshState,
    pub bias_m_s2: f64,
}

impl SloshHypothesis {
    /// Moved in `[ms, ks, cs, bias]`.
    pub(crate) fn moved(&self, step: &Vector4<f64>) -> Self {
        let p = &self.parameters;
        let parameters = SloshParameters {
            slosh_mass_kg: p.slosh_mass_kg + step[0],
            stiffness_n_m: p.stiffness_n_m + step[1],
            damping_n_s_m: p.damping_n_s_m + step[2],
        };
        Self { parameters, state: self.state, bias_m_s2: self.bias_m_s2 + step[3] }
    }

    /// The step in `[ms, ks, cs, bias]` from `other` to this.
    pub(crate) fn offset_from(&self, other: &Self) -> Vector4<f64> {
        let (a, b) = (&self.parameters, &other.parameters);
        Vector4::new(
            a.slosh_mass_kg - b.slosh_mass_kg,
            a.stiffness_n_m - b.stiffness_n_m,
            a.damping_n_s_m - b.damping_n_s_m,
            self.bias_m_s2 - other.bias_m_s2,
        )
    }

    pub(crate) fn is_possible(&self) -> bool {
        self.parameters.slosh_mass_kg > 0.0 && self.parameters.stiffness_n_m >= 0.0
    }
}

/// χ² and its quadratic model at one hypothesis, the slosh states at free starts at their best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Likelihood {
    pub chi_square: f64,
    /// Of `[ms, ks, cs, bias]`, free states eliminated (Schur complement); identity for a bias that is not estimated.
    pub information: Matrix4<f64>,
    /// `Jᵀ W e`, zero where not estimated.
    pub gradient: Vector4<f64>,
    /// At the start of the arc and at its end.
    pub start: SloshState,
    pub end: SloshState,
    /// Measured blocks in segments long enough to be used.
    pub blocks: usize,
    /// Free states that were eliminated: two per free segment.
    pub eliminated: usize,
    /// Residual of the last measured block over its standard deviation.
    pub last_residual: f64,
}

/// A segment that begins with an unknown state needs this many measured blocks: two go into the state, and a state that
/// is mostly noise would feed noise into the sensitivities.
pub(crate) const SEGMENT_BLOCKS_MIN: usize = 16;

/// Likelihood of `hypothesis`. `on_residual` receives each used block's residual over its standard deviation.
///
/// Given the parameters, the residuals are linear in the slosh state a free segment begins with; that state is solved
/// and eliminated segment by segment, so any number of segments costs no memory (variable projection, Kaufman's
/// information). One walk, two where states are free; about 40 ns per block and walk.
pub(crate) fn likelihood<const N: usize>(
    arc: &SloshArc<N>,
    base_mass_kg: f64,
    hypothesis: &SloshHypothesis,
    unknowns: SloshUnknowns,
    on_residual: impl FnMut(f64),
) -> Likelihood {
    likelihood_until(arc, arc.len(), base_mass_kg, hypothesis, unknowns, on_residual)
}

/// [`likelihood`] of the first `blocks` alone.
pub(crate) fn likelihood_until<const N: usize>(
    arc: &SloshArc<N>,
    blocks: usize,
    base_mass_kg: f64,
    hypothesis: &SloshHypothesis,
    unknowns: SloshUnknowns,
    mut on_residual: impl FnMut(f64),
) -> Likelihood {
    let mut sums = Likelihood {
        chi_square: 0.0,
        information: Matrix4::zeros(),
        gradient: Vector4::zeros(),
        start: SloshState::default(),
        end: SloshState::default(),
        blocks: 0,
        eliminated: 0,
        last_residual: 0.0,
    };
    let mut walk = Walk::new(base_mass_kg, hypothesis, arc.block_length_s());
    for i in 0..arc.segments() {
        let (from, until) = arc.segment(i);
        let segment = (from.min(blocks), until.min(blocks));
        let is_free = i > 0 || arc.has_forgotten_the_start() || unknowns == SloshUnknowns::ParametersStateBias;
        walk.restart(Vector2::zeros());
        if is_free {
            let Some(state) = best_start(arc, &mut walk, segment) else { continue };
            walk.restart(state);
        }
        if i == 0 {
            sums.start = walk.slosh_state();
        }
        sums.add(arc, &mut walk, segment, is_free, &mut on_residual);
        sums.end = walk.slosh_state();
    }
    if unknowns == SloshUnknowns::Parameters {
        sums.gradient[3] = 0.0;
        sums.information.fill_row(3, 0.0);
        sums.information.fill_column(3, 0.0);
        sums.information[(3, 3)] = 1.0;
    }
    sums
}

/// Numbers of the first block and of the one behind the last.
type Segment = (usize, usize);

/// The state at the start of a segment that leaves the least χ²; `None` when too few blocks tell.
fn best_start<const N: usize>(arc: &SloshArc<N>, walk: &mut Walk, segment: Segment) -> Option<Vector2<f64>> {
    let (mut normal, mut right, mut measured) = (Matrix2::zeros(), Vector2::zeros(), 0);
    for block in arc.blocks_of(segment) {
        let (predicted, sensitivity) = walk.step(&block);
        let (by_start, weight) = (sensitivity.fixed_rows::<2>(3), block.weight());
        right += by_start * ((block.delta_v_m_s - predicted) * weight);
        normal += by_start * (by_start * weight).transpose();
        measured += usize::from(block.is_measured());
    }
    if measured < SEGMENT_BLOCKS_MIN {
        return None;
    }
    solve_scaled(&normal, &right)
}

/// `A⁻¹ b` with rows and columns scaled to a unit diagonal first: metres and metres per second differ by ω.
pub(crate) fn solve_scaled(normal: &Matrix2<f64>, right: &Vector2<f64>) -> Option<Vector2<f64>> {
    let scale = normal.diagonal().map(|value| 1.0 / libm::sqrt(value));
    let scaling = Matrix2::from_diagonal(&scale);
    Some(scaling * (scaling * normal * scaling).cholesky()?.solve(&(scaling * right)))
}

impl Likelihood {
    /// One segment, from the state the walk stands at.
    fn add<const N: usize>(
        &mut self,
        arc: &SloshArc<N>,
        walk: &mut Walk,
        segment: Segment,
        is_free: bool,
        on_residual: &mut impl FnMut(f64),
    ) {
        let (mut information, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
        for block in arc.blocks_of(segment) {
            let (predicted, sensitivity) = walk.step(&block);
            let weight = block.weight();
            let residual = block.delta_v_m_s - predicted;
            if block.is_measured() {
                self.last_residual = residual * libm::sqrt(weight);
                self.blocks += 1;
                on_residual(self.last_residual);
            }
            self.chi_square += residual * residual * weight;
            gradient += sensitivity * (residual * weight);
            information += sensitivity * (sensitivity * weight).transpose();
        }
        // Order [ms, ks, cs, r0, ṙ0, bias]: parameters and bias stay, the state goes.
        const KEPT: [usize; 4] = [0, 1, 2, 5];
        let kept = Matrix4::from_fn(|i, j| information[(KEPT[i], KEPT[j])]);
        self.information += kept;
        self.gradient += Vector4::from_fn(|i, _| gradient[KEPT[i]]);
        if is_free {
            self.eliminated += 2;
            let normal: Matrix2<f64> = information.fixed_view::<2, 2>(3, 3).into();
            let cross = Matrix4x2::from_fn(|i, j| information[(KEPT[i], 3 + j)]);
            let eliminate = |right: &Vector2<f64>| solve_scaled(&normal, right).unwrap_or_default();
            let rows =
                Matrix2x4::from_columns(&core::array::from_fn::<_, 4, _>(|i| eliminate(&cross.row(i).transpose())));
            self.information -= cross * rows;
            // The state is at its best: its own gradient is zero but for rounding, nothing to carry over.
        }
    }
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
    neighbours: NeighbouringSensitivities,
    state: Vector2<f64>,
    /// By κ, γ, r0, ṙ0.
    derivatives: [Vector2<f64>; 4],
}

impl Walk {
    fn new(base_mass_kg: f64, hypothesis: &SloshHypothesis, length_s: f64) -> Self {
        let parameters = hypothesis.parameters;
        let mu = parameters.reduced_mass_kg(base_mass_kg);
        let (kappa, gamma) = (parameters.stiffness_n_m / mu, parameters.damping_n_s_m / mu);
        let transition = TransitionWithSensitivity::new(kappa, gamma, length_s, base_mass_kg);
        Self {
            kappa,
            gamma,
            base_mass_kg,
            bias_m_s2: hypothesis.bias_m_s2,
            parameters,
            length_s,
            transition,
            neighbours: NeighbouringSensitivities::new(&transition, kappa, gamma, length_s, base_mass_kg),
            state: Vector2::new(hypothesis.state.displacement_m, hypothesis.state.velocity_m_s),
            derivatives: Self::START,
        }
    }

    const START: [Vector2<f64>; 4] =
        [Vector2::new(0.0, 0.0), Vector2::new(0.0, 0.0), Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0)];

    fn restart(&mut self, state: Vector2<f64>) {
        (self.state, self.derivatives) = (state, Self::START);
    }

    fn slosh_state(&self) -> SloshState {
        SloshState { displacement_m: self.state[0], velocity_m_s: self.state[1] }
    }

    /// Predicted Δv of the block and its derivatives by `[ms, ks, cs, r0, ṙ0, bias]`.
    fn step(&mut self, block: &SloshBlock) -> (f64, Vector6<f64>) {
        if (block.length_s - self.length_s).abs() > SAME_LENGTH * block.length_s {
            self.length_s = block.length_s;
            self.transition = self.neighbours.at(self.length_s).unwrap_or_else(|| {
                TransitionWithSensitivity::new(self.kappa, self.gamma, self.length_s, self.base_mass_kg)
            });
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
        let moved = |step: &Vector6<f64>| {
            let mut hypothesis = at.moved(&Vector4::new(step[0], step[1], step[2], step[5]));
            hypothesis.state.displacement_m += step[3];
            hypothesis.state.velocity_m_s += step[4];
            hypothesis
        };
        let steps = Vector6::new(1e-3, 1e-6, 1e-6, 1e-4, 1e-5, 1e-7);
        for i in 0..6 {
            let mut step = Vector6::zeros();
            step[i] = steps[i];
            let (plus, minus) = (predict(&moved(&step)), predict(&moved(&-step)));
            let size = analytic.iter().map(|(_, s)| s[i].abs()).fold(0.0, f64::max);
            for ((a, p), m) in analytic.iter().zip(plus).zip(minus) {
                let difference = (p.0 - m.0) / (2.0 * steps[i]);
                assert!((a.1[i] - difference).abs() < 1e-6 * size, "unknown {i}"); // truncation (step/value)², rounding
            }
        }
    }
}
