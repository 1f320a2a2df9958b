//! Likelihood of a slosh model over an arc: residuals, exact sensitivities, information.
//!
//! The truth has no process noise, so output error is the maximum likelihood. Unknowns, in this
//! order: `[ms, ks, cs, r0, ṙ0, bias, thrust scale, thrust delay]`; damping enters linearly because
//! a short arc may well say it is negative. Behind every gap the slosh state is unknown again;
//! those states are solved and eliminated where they arise.

use nalgebra::{Matrix2, Matrix2x6, Matrix6, Matrix6x2, SMatrix, SVector, Vector2, Vector6};
use serde::{Deserialize, Serialize};

use crate::slosh::{NeighbouringSensitivities, SloshParameters, SloshState, TransitionWithSensitivity};
use crate::slosh_arc::{SAME_LENGTH, SloshArc, SloshBlock};

/// Which unknowns are estimated; the others are known to be zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SloshUnknowns {
    /// Mass, stiffness, damping; quiescent start, calibrated accelerometer.
    Parameters,
    /// Also the slosh state at the start of the arc and the accelerometer bias.
    ParametersStateBias,
    /// Also the error of the thrust scale. A single sine cannot tell it from the slosh mass: excite
    /// two tones, or coast.
    ParametersStateBiasScale,
    /// Also the delay of the thrust behind its command, small against the interval of a sample.
    ParametersStateBiasScaleDelay,
}

impl SloshUnknowns {
    /// Unknowns of the likelihood.
    pub fn count(self) -> usize {
        match self {
            Self::Parameters => 3,
            Self::ParametersStateBias => 6,
            Self::ParametersStateBiasScale => 7,
            Self::ParametersStateBiasScaleDelay => 8,
        }
    }

    /// Of `[ms, ks, cs, bias, thrust scale, thrust delay]` so many are estimated, from the front.
    pub(crate) fn kept(self) -> usize {
        if self == Self::Parameters { 3 } else { self.count() - 2 }
    }
}

/// A complete hypothesis about one arc.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SloshHypothesis {
    pub parameters: SloshParameters,
    /// At the start of the arc; an estimate reports it, a fit solves it again.
    pub state: SloshState,
    pub bias_m_s2: f64,
    /// Thrust over its command, less one.
    pub thrust_scale_error: f64,
    /// Of the thrust behind its command.
    pub thrust_delay_s: f64,
}

impl SloshHypothesis {
    /// Moved in `[ms, ks, cs, bias, thrust scale, thrust delay]`.
    pub(crate) fn moved(&self, step: &Vector6<f64>) -> Self {
        let p = &self.parameters;
        let parameters = SloshParameters {
            slosh_mass_kg: p.slosh_mass_kg + step[0],
            stiffness_n_m: p.stiffness_n_m + step[1],
            damping_n_s_m: p.damping_n_s_m + step[2],
        };
        Self {
            parameters,
            state: self.state,
            bias_m_s2: self.bias_m_s2 + step[3],
            thrust_scale_error: self.thrust_scale_error + step[4],
            thrust_delay_s: self.thrust_delay_s + step[5],
        }
    }

    /// The step from `other` to this, as [`Self::moved`] takes it.
    pub(crate) fn offset_from(&self, other: &Self) -> Vector6<f64> {
        let (a, b) = (&self.parameters, &other.parameters);
        Vector6::new(
            a.slosh_mass_kg - b.slosh_mass_kg,
            a.stiffness_n_m - b.stiffness_n_m,
            a.damping_n_s_m - b.damping_n_s_m,
            self.bias_m_s2 - other.bias_m_s2,
            self.thrust_scale_error - other.thrust_scale_error,
            self.thrust_delay_s - other.thrust_delay_s,
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
    /// Of `[ms, ks, cs, bias, thrust scale, thrust delay]`, free states eliminated (Schur
    /// complement); identity for what is not estimated.
    pub information: Matrix6<f64>,
    /// `Jᵀ W e`, zero where not estimated.
    pub gradient: Vector6<f64>,
    /// At the start of the arc and at its end.
    pub start: SloshState,
    pub end: SloshState,
    /// Measured blocks in segments long enough to be used.
    pub blocks: usize,
    /// Free states that were eliminated: two per free segment.
    pub eliminated: usize,
    /// The newest measured block.
    pub newest: NewestBlock,
}

/// Residual of one block and its derivatives, all over the block's standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct NewestBlock {
    pub residual: f64,
    /// By `[ms, ks, cs, bias, thrust scale, thrust delay]`, the free state following.
    pub by: Vector6<f64>,
    /// Share of the block in the fit of its own free state, zero to one.
    pub leverage: f64,
}

/// A segment that begins with an unknown state needs this many measured blocks: two go into the
/// state, and a state that is mostly noise would feed noise into the sensitivities.
pub(crate) const SEGMENT_BLOCKS_MIN: usize = 16;

/// Likelihood of `hypothesis`. `on_residual` receives each used block's residual over its standard
/// deviation.
///
/// Given the parameters, the residuals are linear in the slosh state a free segment begins with;
/// that state is solved and eliminated segment by segment, so any number of segments costs no
/// memory (variable projection, Kaufman's information). One walk, two where states are free; about
/// 40 ns per block and walk.
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
        information: Matrix6::zeros(),
        gradient: Vector6::zeros(),
        start: SloshState::default(),
        end: SloshState::default(),
        blocks: 0,
        eliminated: 0,
        newest: NewestBlock::default(),
    };
    let mut walk = Walk::new(base_mass_kg, hypothesis, arc.block_length_s());
    for i in 0..arc.segments() {
        let (from, until) = arc.segment(i);
        let segment = (from.min(blocks), until.min(blocks));
        let is_free = i > 0 || arc.has_forgotten_the_start() || unknowns != SloshUnknowns::Parameters;
        // Before the arc nothing is commanded; before what is left of one, what is commanded now.
        let before = if i > 0 || arc.has_forgotten_the_start() { None } else { Some(0.0) };
        walk.restart(Vector2::zeros(), before);
        if is_free {
            let Some(state) = best_start(arc, &mut walk, segment) else { continue };
            walk.restart(state, before);
        }
        if i == 0 {
            sums.start = walk.slosh_state();
        }
        sums.add(arc, &mut walk, segment, is_free, &mut on_residual);
        sums.end = walk.slosh_state();
    }
    for known in unknowns.kept()..6 {
        sums.gradient[known] = 0.0;
        sums.information.fill_row(known, 0.0);
        sums.information.fill_column(known, 0.0);
        sums.information[(known, known)] = 1.0;
        sums.newest.by[known] = 0.0;
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

/// `A⁻¹ b` with rows and columns scaled to a unit diagonal first: metres and metres per second
/// differ by ω.
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
        let (mut information, mut gradient) = (Sensitivities::zeros(), Sensitivity::zeros());
        let mut newest = None;
        for block in arc.blocks_of(segment) {
            let (predicted, sensitivity) = walk.step(&block);
            let weight = block.weight();
            let residual = block.delta_v_m_s - predicted;
            if block.is_measured() {
                let over_sigma = libm::sqrt(weight);
                newest = Some((residual * over_sigma, sensitivity * over_sigma));
                self.blocks += 1;
                on_residual(residual * over_sigma);
            }
            self.chi_square += residual * residual * weight;
            gradient += sensitivity * (residual * weight);
            information += sensitivity * (sensitivity * weight).transpose();
        }
        // The state goes, the rest stays.
        const KEPT: [usize; 6] = [0, 1, 2, 5, 6, 7];
        self.information += Matrix6::from_fn(|i, j| information[(KEPT[i], KEPT[j])]);
        self.gradient += Vector6::from_fn(|i, _| gradient[KEPT[i]]);
        if let Some((residual, by)) = newest {
            self.newest = NewestBlock { residual, by: Vector6::from_fn(|i, _| by[KEPT[i]]), leverage: 0.0 };
        }
        if is_free {
            self.eliminated += 2;
            let normal: Matrix2<f64> = information.fixed_view::<2, 2>(3, 3).into();
            let cross = Matrix6x2::from_fn(|i, j| information[(KEPT[i], 3 + j)]);
            let eliminate = |right: &Vector2<f64>| solve_scaled(&normal, right).unwrap_or_default();
            let rows =
                Matrix2x6::from_columns(&core::array::from_fn::<_, 6, _>(|i| eliminate(&cross.row(i).transpose())));
            self.information -= cross * rows;
            if let Some((_, by)) = newest {
                let by_state: Vector2<f64> = by.fixed_rows::<2>(3).into();
                self.newest.by -= rows.transpose() * by_state;
                self.newest.leverage = by_state.dot(&eliminate(&by_state));
            }
            // The state is at its best: its own gradient is zero but for rounding, nothing to carry
            // over.
        }
    }
}

/// By `[ms, ks, cs, r0, ṙ0, bias, thrust scale, thrust delay]`.
pub type Sensitivity = SVector<f64, 8>;
type Sensitivities = SMatrix<f64, 8, 8>;

/// States whose derivatives are carried: by κ, γ, r0, ṙ0, thrust scale, thrust delay.
const CARRIED: usize = 6;

/// Slosh state and its derivatives, block after block.
pub struct Walk {
    kappa: f64,
    gamma: f64,
    base_mass_kg: f64,
    at: SloshHypothesis,
    length_s: f64,
    transition: TransitionWithSensitivity,
    neighbours: NeighbouringSensitivities,
    state: Vector2<f64>,
    derivatives: [Vector2<f64>; CARRIED],
    /// Command before the block; `None` when it is not known.
    last_force_n: Option<f64>,
}

impl Walk {
    /// At the start of the hypothesis; blocks are expected to be `length_s` long, others cost an
    /// exponential.
    pub fn new(base_mass_kg: f64, hypothesis: &SloshHypothesis, length_s: f64) -> Self {
        let parameters = hypothesis.parameters;
        let mu = parameters.reduced_mass_kg(base_mass_kg);
        let (kappa, gamma) = (parameters.stiffness_n_m / mu, parameters.damping_n_s_m / mu);
        let transition = TransitionWithSensitivity::new(kappa, gamma, length_s, base_mass_kg);
        Self {
            kappa,
            gamma,
            base_mass_kg,
            at: *hypothesis,
            length_s,
            transition,
            neighbours: NeighbouringSensitivities::new(&transition, kappa, gamma, length_s, base_mass_kg),
            state: Vector2::new(hypothesis.state.displacement_m, hypothesis.state.velocity_m_s),
            derivatives: Self::START,
            last_force_n: Some(0.0),
        }
    }

    const START: [Vector2<f64>; CARRIED] = {
        let zero = Vector2::new(0.0, 0.0);
        [zero, zero, Vector2::new(1.0, 0.0), Vector2::new(0.0, 1.0), zero, zero]
    };

    pub(crate) fn restart(&mut self, state: Vector2<f64>, last_force_n: Option<f64>) {
        (self.state, self.derivatives, self.last_force_n) = (state, Self::START, last_force_n);
    }

    /// Moments of the thrust, and their derivatives by its scale and its delay: a block that begins
    /// at the last force and ends at its own loses `∫ḟ`, and moves its middle.
    fn thrust(&mut self, block: &SloshBlock) -> [Vector2<f64>; 3] {
        let mean_n = block.force.impulse_n_s / block.length_s;
        let (before_n, after_n) = (self.last_force_n.unwrap_or(mean_n), block.last_force_n);
        self.last_force_n = Some(after_n);
        let moved = Vector2::new(before_n - after_n, (mean_n - (before_n + after_n) / 2.0) * block.length_s);
        let commanded = block.force_vector() + moved * self.at.thrust_delay_s;
        let scale = 1.0 + self.at.thrust_scale_error;
        [commanded * scale, commanded, moved * scale]
    }

    fn slosh_state(&self) -> SloshState {
        SloshState { displacement_m: self.state[0], velocity_m_s: self.state[1] }
    }

    /// Predicted Δv of the block and its derivatives.
    pub fn step(&mut self, block: &SloshBlock) -> (f64, Sensitivity) {
        if (block.length_s - self.length_s).abs() > SAME_LENGTH * block.length_s {
            self.length_s = block.length_s;
            self.transition = self.neighbours.at(self.length_s).unwrap_or_else(|| {
                TransitionWithSensitivity::new(self.kappa, self.gamma, self.length_s, self.base_mass_kg)
            });
        }
        let [force, by_scale, by_delay] = self.thrust(block);
        let (transition, old) = (&self.transition, self.state);
        self.state = transition.value.apply(&old, &force);
        let slosh_dv = self.state[1] - old[1];
        let (phi, gain) = (&transition.value.phi, &transition.value.gain);
        let none = Vector2::zeros();
        let driven = [
            transition.by_kappa.apply(&old, &force),
            transition.by_gamma.apply(&old, &force),
            none,
            none,
            gain * by_scale,
            gain * by_delay,
        ];
        let mut velocity_change = [0.0; CARRIED];
        for ((derivative, drive), change) in self.derivatives.iter_mut().zip(driven).zip(&mut velocity_change) {
            let next = phi * *derivative + drive;
            *change = next[1] - derivative[1];
            *derivative = next;
        }
        let SloshParameters { slosh_mass_kg: m_s, stiffness_n_m: k, damping_n_s_m: c } = self.at.parameters;
        let total = self.base_mass_kg + m_s;
        let base_dv = (force[0] - m_s * slosh_dv) / total;
        let [by_kappa, by_gamma, by_r, by_v, scale, delay] = velocity_change.map(|change| -m_s / total * change);
        // κ = k/μ, γ = c/μ, 1/μ = 1/m0 + 1/ms.
        let per_mu = 1.0 / self.base_mass_kg + 1.0 / m_s;
        let direct = -(slosh_dv + base_dv) / total;
        let by_mass = direct - (by_kappa * k + by_gamma * c) / (m_s * m_s);
        let (scale, delay) = (scale + by_scale[0] / total, delay + by_delay[0] / total);
        let rest = [by_r, by_v, block.length_s, scale, delay];
        let sensitivity =
            Sensitivity::from_iterator([by_mass, by_kappa * per_mu, by_gamma * per_mu].into_iter().chain(rest));
        (base_dv + self.at.bias_m_s2 * block.length_s, sensitivity)
    }
}

#[cfg(test)]
mod tests;
