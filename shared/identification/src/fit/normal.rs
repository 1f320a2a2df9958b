//! Normal equations with priors, and what they promise.

use super::bounded::bounded;
use super::estimation_session::EstimationSession;
use crate::problem::Unknown;
use estimation::levenberg_marquardt::damped_step;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Whitened normal equations with priors: unknowns in prior standard deviations, then extra
/// columns.
pub struct Normal {
    /// Number of unknowns; extra columns follow.
    pub unknowns: usize,
    pub matrix: DMatrix<f64>,
    /// `Cᵀ r` + prior.
    pub right: DVector<f64>,
    /// `|r|²` and with `Σ ln |S|` and the prior's share the objective, at the present point.
    pub chi2: f64,
    pub objective: f64,
    /// Room of each unknown down and up [prior standard deviations].
    pub room: Vec<[f64; 2]>,
}

/// `Σ ((θ − θ₀)/σ)²`.
pub fn prior_chi2(session: &EstimationSession<'_>, theta: &[f64]) -> f64 {
    theta.iter().zip(&session.problem.unknowns).map(|(t, u)| ((t - u.prior) / u.sigma).powi(2)).sum()
}

impl Normal {
    /// Of products of the whitened innovations, sensitivities and further columns, row by row, j ≥
    /// i.
    pub(super) fn new(
        session: &EstimationSession<'_>,
        theta: &[f64],
        sums: &[f64],
        unknowns: usize,
        log_determinant: f64,
    ) -> Option<Self> {
        let width = sums.len().isqrt();
        let n = width - 1;
        let product = |i: usize, j: usize| sums[i.min(j) * width + i.max(j)];
        let mut matrix = DMatrix::from_fn(n, n, |i, j| product(1 + i, 1 + j));
        let mut right = DVector::from_fn(n, |i, _| product(0, 1 + i));
        for (i, unknown) in session.problem.unknowns.iter().enumerate().take(unknowns) {
            matrix[(i, i)] += 1.0;
            right[i] += (unknown.prior - theta[i]) / unknown.sigma;
        }
        let own = session.problem.unknowns.iter().zip(theta).take(unknowns);
        let room = own.map(|(u, t)| [((u.low - t) / u.sigma).min(0.0), ((u.high - t) / u.sigma).max(0.0)]).collect();
        let chi2 = product(0, 0);
        let objective = chi2 + log_determinant + prior_chi2(session, theta);
        (objective.is_finite() && matrix.iter().all(|v: &f64| v.is_finite())).then_some(Self {
            unknowns,
            matrix,
            right,
            chi2,
            objective,
            room,
        })
    }

    /// Factor of the unknowns' block.
    pub fn factor(&self) -> Option<Cholesky<f64, Dyn>> {
        let n = self.unknowns;
        Cholesky::new(self.matrix.view((0, 0), (n, n)).into_owned())
    }

    /// Step in θ and the decrease of the objective it promises; unknowns at an edge do not leave
    /// their range.
    pub fn step(&self, session: &EstimationSession<'_>, theta: &[f64], damping: f64) -> Option<(Vec<f64>, f64)> {
        let n = self.unknowns;
        let unknowns = &session.problem.unknowns;
        let matrix = self.matrix.view((0, 0), (n, n)).into_owned();
        let right = self.right.rows(0, n).into_owned();
        let leaves = |step: &[f64]| {
            let own = step.iter().zip(theta).zip(unknowns);
            own.into_iter().any(|((s, t), u)| (*t <= u.low && *s < 0.0) || (*t >= u.high && *s > 0.0))
        };
        let mut solved: Vec<f64> = damped_step(matrix.clone(), &right, damping)?.iter().copied().collect();
        if leaves(&solved) {
            let mut damped = matrix;
            (0..n).for_each(|i| damped[(i, i)] *= 1.0 + damping);
            let edge = |at: bool, end: f64| if at { 0.0 } else { end };
            let room =
                |(t, u): (&f64, &Unknown)| [edge(*t <= u.low, f64::NEG_INFINITY), edge(*t >= u.high, f64::INFINITY)];
            let room: Vec<[f64; 2]> = theta.iter().zip(unknowns).map(room).collect();
            solved = bounded(&damped, &right, &room, &(0..n).collect::<Vec<_>>())?.1;
        }
        let promised = solved.iter().zip(right.iter()).map(|(s, right)| s * right).sum();
        Some((solved.iter().zip(unknowns).map(|(s, u)| s * u.sigma).collect(), promised))
    }

    /// Least objective over unknowns and extra columns (linear), unknowns within their ranges, and
    /// where it is: steps of the unknowns [prior standard deviations], then the extra columns'
    /// coefficients.
    pub fn least(&self) -> Option<(f64, Vec<f64>)> {
        let places: Vec<usize> = (0..self.matrix.nrows()).collect();
        let (decrease, x) = bounded(&self.matrix, &self.right, &self.room, &places)?;
        Some((self.objective - decrease, x))
    }

    /// Posterior standard deviations of the unknowns.
    pub fn sigmas(&self, session: &EstimationSession<'_>) -> Vec<f64> {
        let Some(factor) = self.factor() else { return vec![f64::NAN; self.unknowns] };
        let inverse = factor.inverse();
        (0..self.unknowns).map(|i| inverse[(i, i)].max(0.0).sqrt() * session.problem.unknowns[i].sigma).collect()
    }
}
