//! Every effect at every site as a direction in innovation space, projected off all nominal
//! unknowns.
//!
//! A candidate is run at a finite amplitude with the nominal gains; the change of the innovations
//! per amplitude is its column `c`, one per direction (azimuth, phase). Off the sensitivities J and
//! priors of the nominal plant it leaves `c'`:
//!
//! ```text
//! T = gᵀ M⁻¹ g,   g = c'ᵀ r,   M = c'ᵀ c',   κ = 1 − |c'|²/|c|²,   amplitude for d: d / |c'|
//! ```
//!
//! T is χ² when the noise is as assumed: it screens and ranks.

pub mod candidates;
mod columns;
pub(crate) mod forcing;
mod instants;
pub(crate) mod kinetic;
mod lines;
mod noise_free;
mod orders;
pub mod refine;
mod specific_force;
mod thin;

pub use candidates::{Candidate, candidates};
pub(crate) use columns::propagator;
pub use columns::{Column, columns};
pub use instants::{Instants, instants};
pub use lines::{Lines, lines};
pub use noise_free::noise_free;
pub use orders::{Orders, orders};
pub(crate) use thin::thin;

use estimation::consistency::score_statistic;
use identification::dot::dot;
use identification::filter::{Gains, NoiseModel};
use identification::fit::{EstimationSession, LinearisedProblem};
use identification::statistics::chi_bar_squared_tail;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Score of one candidate.
#[derive(Clone, Debug)]
pub struct Score {
    /// Index among the columns.
    pub column: usize,
    /// `T` and its degrees of freedom.
    pub statistic: f64,
    pub freedom: usize,
    pub p: f64,
    /// Estimated amplitude along each direction.
    pub amplitude: Vec<f64>,
    /// Share of the effect's energy that the nominal unknowns absorb, κ in [0, 1].
    pub kappa: f64,
    /// Amplitude detectable at six standard errors (in the weakest single direction).
    pub limit: f64,
    /// Whitened and projected, one per direction.
    pub projected: Vec<Vec<f64>>,
}

/// Share of its own square that a column must keep past the projection; below it is collinear with
/// the nominal unknowns (rounding of the projection).
const UNABSORBED_SHARE_MIN: f64 = 1e-7;
/// Standard errors at which an effect counts as detectable. Chosen by custom, no derivation; it
/// sets the reported limits only.
pub const LIMIT_D: f64 = 6.0;

/// Scores of `columns` at `theta` under `noise`; `None` for those that are collinear with the
/// unknowns.
///
/// Cost: one whitening of all columns, then O(samples × unknowns) for each direction.
pub fn scores(
    session: &EstimationSession<'_>,
    linearised: &LinearisedProblem,
    theta: &[f64],
    noise: &NoiseModel,
    columns: &[Column],
) -> Vec<Option<Score>> {
    match Scorer::new(session, linearised, theta, noise) {
        Some(scorer) => scorer.scores(columns),
        None => columns.iter().map(|_| None).collect(),
    }
}

/// Innovations and sensitivities under one noise, for any columns.
pub struct Scorer<'e, 'p> {
    session: &'e EstimationSession<'p>,
    linearised: &'e LinearisedProblem,
    gains: Vec<Gains>,
    projector: Projector,
}

impl<'e, 'p> Scorer<'e, 'p> {
    /// `None`: a covariance is not positive.
    pub fn new(
        session: &'e EstimationSession<'p>,
        linearised: &'e LinearisedProblem,
        theta: &[f64],
        noise: &NoiseModel,
    ) -> Option<Self> {
        let (gains, mut all) = linearised.white(session, noise)?;
        let r = all.remove(0);
        let projector = Projector::new(session, theta, r, all)?;
        Some(Self { session, linearised, gains, projector })
    }

    /// `None` for columns that are collinear with the unknowns.
    pub fn scores(&self, columns: &[Column]) -> Vec<Option<Score>> {
        let mut all: Vec<Vec<f64>> = columns.iter().flat_map(|column| &column.raw).cloned().collect();
        self.linearised.whiten_by(self.session, &self.gains, &mut all);
        let mut rest = &all[..];
        let own = |(index, column): (usize, &Column)| {
            let (raw, behind) = rest.split_at(column.raw.len());
            rest = behind;
            score(index, column, raw, &self.projector)
        };
        columns.iter().enumerate().map(own).collect()
    }
}

/// Projection off the nominal unknowns with their priors.
pub struct Projector {
    jacobian: Vec<Vec<f64>>,
    factor: Option<Cholesky<f64, nalgebra::Dyn>>,
    /// Residual with the unknowns at their maximum.
    pub residual: Vec<f64>,
}

impl Projector {
    /// Off the whitened `jacobian`, of the whitened innovations `r`.
    pub fn new(session: &EstimationSession<'_>, theta: &[f64], r: Vec<f64>, jacobian: Vec<Vec<f64>>) -> Option<Self> {
        let n = jacobian.len();
        if n == 0 {
            return Some(Self { jacobian, factor: None, residual: r });
        }
        let mut matrix = DMatrix::zeros(n, n);
        let mut right = DVector::zeros(n);
        for i in 0..n {
            for j in i..n {
                let product = dot(&jacobian[i], &jacobian[j]);
                (matrix[(i, j)], matrix[(j, i)]) = (product, product);
            }
            matrix[(i, i)] += 1.0;
            let unknown = &session.problem.unknowns[i];
            right[i] = dot(&jacobian[i], &r) + (unknown.prior - theta[i]) / unknown.sigma;
        }
        let factor = Cholesky::new(matrix)?;
        let step = factor.solve(&right);
        let mut residual = r;
        subtract(&mut residual, &jacobian, &step);
        Some(Self { jacobian, factor: Some(factor), residual })
    }

    /// `c − J (JᵀJ + 1)⁻¹ Jᵀ c`, and the norm of the whole projection (prior rows too) squared.
    fn project(&self, c: &[f64]) -> (Vec<f64>, DVector<f64>) {
        let mut out = c.to_vec();
        let Some(factor) = &self.factor else { return (out, DVector::zeros(0)) };
        let right = DVector::from_fn(self.jacobian.len(), |i, _| dot(&self.jacobian[i], c));
        let taken = factor.solve(&right);
        subtract(&mut out, &self.jacobian, &taken);
        (out, taken)
    }
}

fn subtract(from: &mut [f64], columns: &[Vec<f64>], by: &DVector<f64>) {
    for (column, factor) in columns.iter().zip(by.iter()) {
        for (from, c) in from.iter_mut().zip(column) {
            *from -= factor * c;
        }
    }
}

fn score(index: usize, column: &Column, raw: &[Vec<f64>], projector: &Projector) -> Option<Score> {
    let (projected, taken): (Vec<Vec<f64>>, Vec<DVector<f64>>) = raw.iter().map(|c| projector.project(c)).unzip();
    let k = raw.len();
    // inner product with the prior's rows: a direction that a prior forbids is not absorbed
    let inner = |i: usize, j: usize| dot(&projected[i], &projected[j]) + taken[i].dot(&taken[j]);
    let whole: f64 = raw.iter().map(|c| dot(c, c)).sum();
    let matrix = DMatrix::from_fn(k, k, inner);
    let left = matrix.trace();
    if whole.is_nan() || whole <= 0.0 || left <= UNABSORBED_SHARE_MIN * whole {
        return None;
    }
    // r is at the maximum along the unknowns, so that the prior's rows of r add nothing along c
    let mut solved: Vec<f64> = raw.iter().map(|c| dot(c, &projector.residual)).collect();
    let statistic = score_statistic(&mut solved, matrix.clone().as_mut_slice())?;
    let one_sided = k == 1 && column.candidate.one_sided;
    let wrong_sign = one_sided && solved[0] < 0.0;
    let p = if wrong_sign { 1.0 } else { chi_bar_squared_tail(statistic, k, one_sided) };
    let weakest = (0..k).map(|i| matrix[(i, i)]).fold(f64::INFINITY, f64::min);
    Some(Score {
        column: index,
        statistic: if wrong_sign { 0.0 } else { statistic },
        freedom: k,
        p,
        amplitude: solved,
        kappa: (1.0 - left / whole).max(0.0),
        limit: LIMIT_D / weakest.sqrt(),
        projected,
    })
}

/// Number of the event (instant) of each sample, over all runs.
pub fn event_of_sample(session: &EstimationSession<'_>) -> Vec<usize> {
    let mut list = Vec::with_capacity(session.samples);
    let mut number = 0;
    for timeline in session.timelines.iter() {
        for event in timeline.events.iter().filter(|event| event.count > 0) {
            list.extend(core::iter::repeat_n(number, event.count));
            number += 1;
        }
    }
    list
}

/// Cosine between the projected columns of two candidates (along their estimated directions where
/// there are several), in [−1, 1].
pub fn cosine(a: &Score, b: &Score) -> f64 {
    let along = |score: &Score| -> Vec<f64> {
        let n = score.projected[0].len();
        (0..n).map(|s| score.projected.iter().zip(&score.amplitude).map(|(c, a)| a * c[s]).sum()).collect()
    };
    let (u, v) = (along(a), along(b));
    let norm = (dot(&u, &u) * dot(&v, &v)).sqrt();
    if norm > 0.0 { dot(&u, &v) / norm } else { 0.0 }
}
