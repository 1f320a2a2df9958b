//! Logarithm of a marginal likelihood by Laplace's method, with bounds.
//!
//! In prior standard deviations the unknowns z have the density `exp(−|z|²/2)` and `−2 ln p` is
//! `c − 2 rᵀ x + xᵀ M x` for a step x from the present point, `M = JᵀJ + 1` (k × k). Free of bounds
//!
//! ```text
//! ln ∫ p(D|z) p(z) dz = −½ c + ½ rᵀ M⁻¹ r − ½ ln det M
//! ```
//!
//! A prior that is cut at a bound has more density inside: the logarithm of the mass that the
//! posterior keeps within its bounds less that of the prior is added (`ln 2 + ln Φ(a/σ_a)` of a
//! one-sided amplitude a). Where the greatest likelihood lies beyond a bound the number is taken at
//! it, with slope g and curvature m given the others:
//!
//! ```text
//! ∫₀^∞ exp(g t − m t²/2) dt = √(2π/m) exp(g²/2m) Φ(g/√m)
//! ```
//!
//! Exact for one bound and a likelihood that is normal about the present point; several bounds are
//! taken as independent given the free parameters.

use identification::fit::Normal;
use identification::fit::bounded::bounded;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Where the range of a number ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bound {
    /// Place in the normal equations.
    pub place: usize,
    /// Room down and up from the present point [prior standard deviations].
    pub room: [f64; 2],
    /// Ends of the prior, relative to its mean [prior standard deviations].
    pub prior: [f64; 2],
}

/// `ln (Φ(b) − Φ(a))`, a < b, without loss in the tails.
pub(super) fn log_mass(a: f64, b: f64) -> f64 {
    if a > 0.0 {
        return log_mass(-b, -a);
    }
    let tail = |z: f64| 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
    let whole = tail(b) - if a.is_finite() { tail(a) } else { 0.0 };
    if whole > 1e-280 {
        return libm::log(whole);
    }
    // far out, the nearer end decides: φ(b)/|b|
    -0.5 * b * b - libm::log(-b * (2.0 * core::f64::consts::PI).sqrt())
}

/// Of all numbers of `normal`, further columns with prior rows of their own among them, up to the
/// constant `−n/2 ln 2π` of n readings; `None` where M is not positive.
pub(super) fn log_marginal(normal: &Normal, bounds: &[Bound]) -> Option<f64> {
    let places: Vec<usize> = (0..normal.matrix.nrows()).collect();
    let mut room = vec![[f64::NEG_INFINITY, f64::INFINITY]; places.len()];
    bounds.iter().for_each(|bound| room[bound.place] = bound.room);
    let (_, x) = bounded(&normal.matrix, &normal.right, &room, &places)?;
    let at_edge = |bound: &Bound| {
        let (at, [down, up]) = (x[bound.place], bound.room);
        (at <= down || at >= up).then_some(Held { place: bound.place, at, is_upper: at >= up })
    };
    let held: Vec<Held> = bounds.iter().filter_map(at_edge).collect();
    Some(Solved::new(normal, &held)?.log_marginal(normal, bounds, &held))
}

/// The normal equations of the unknowns and the columns at `kept`.
pub(super) fn part_of(whole: &Normal, kept: &[usize]) -> Normal {
    let all: Vec<usize> = (0..whole.unknowns).chain(kept.iter().copied()).collect();
    Normal {
        unknowns: whole.unknowns,
        matrix: DMatrix::from_fn(all.len(), all.len(), |i, j| whole.matrix[(all[i], all[j])]),
        right: DVector::from_fn(all.len(), |i, _| whole.right[all[i]]),
        chi2: whole.chi2,
        objective: whole.objective,
        room: all.iter().map(|i| whole.room[*i]).collect(),
    }
}

/// The same with the prior widths of the further columns as these shares of what they are.
pub(super) fn narrowed(whole: &Normal, shares: &[f64]) -> Normal {
    let (first, count) = (whole.unknowns, whole.matrix.nrows());
    let share = |i: usize| if i < first { 1.0 } else { shares[i - first] };
    let prior = |i: usize, j: usize| if i == j && i >= first { 1.0 } else { 0.0 };
    let entry = |i, j| share(i) * share(j) * (whole.matrix[(i, j)] - prior(i, j)) + prior(i, j);
    Normal {
        unknowns: first,
        matrix: DMatrix::from_fn(count, count, entry),
        right: DVector::from_fn(count, |i, _| share(i) * whole.right[i]),
        chi2: whole.chi2,
        objective: whole.objective,
        room: whole.room.iter().enumerate().map(|(i, room)| room.map(|end| end / share(i))).collect(),
    }
}

/// A number at the end of its range: the step to there, and which end it is.
#[derive(Clone, Copy)]
struct Held {
    place: usize,
    at: f64,
    is_upper: bool,
}

/// The free parameters where the others are fixed.
struct Solved {
    free: Vec<usize>,
    factor: Cholesky<f64, nalgebra::Dyn>,
    step: DVector<f64>,
    /// Of all numbers, and `2 rᵀ x − xᵀ M x` of the whole step.
    whole: DVector<f64>,
    decrease: f64,
}

impl Solved {
    fn new(normal: &Normal, held: &[Held]) -> Option<Self> {
        let (matrix, right) = (&normal.matrix, &normal.right);
        let free: Vec<usize> = (0..matrix.nrows()).filter(|i| !held.iter().any(|own| own.place == *i)).collect();
        let factor = Cholesky::new(DMatrix::from_fn(free.len(), free.len(), |i, j| matrix[(free[i], free[j])]))?;
        let own = DVector::from_fn(free.len(), |i, _| {
            right[free[i]] - held.iter().map(|own| matrix[(free[i], own.place)] * own.at).sum::<f64>()
        });
        let step = factor.solve(&own);
        let mut whole = DVector::zeros(matrix.nrows());
        free.iter().zip(step.iter()).for_each(|(i, step)| whole[*i] = *step);
        held.iter().for_each(|own| whole[own.place] = own.at);
        let decrease = 2.0 * right.dot(&whole) - (matrix * &whole).dot(&whole);
        Some(Self { free, factor, step, whole, decrease })
    }

    fn log_marginal(&self, normal: &Normal, bounds: &[Bound], held: &[Held]) -> f64 {
        let log_determinant = 2.0 * self.factor.l_dirty().diagonal().iter().map(|l| libm::log(*l)).sum::<f64>();
        let mut sum = -0.5 * (normal.objective - self.decrease) - 0.5 * log_determinant;
        for bound in bounds {
            let [low, high] = bound.prior;
            sum -= log_mass(low, high);
            sum += match held.iter().find(|own| own.place == bound.place) {
                Some(own) => self.at_the_edge(normal, own),
                None => self.inside(bound),
            };
        }
        sum
    }

    /// `ln` of the posterior's mass within the bounds of a free number.
    fn inside(&self, bound: &Bound) -> f64 {
        let Some(place) = self.free.iter().position(|i| *i == bound.place) else { return 0.0 };
        let mut unit = DVector::zeros(self.free.len());
        unit[place] = 1.0;
        let sigma = self.factor.solve(&unit)[place].max(0.0).sqrt();
        let [down, up] = bound.room;
        log_mass((down - self.step[place]) / sigma, (up - self.step[place]) / sigma)
    }

    /// The one-dimensional integral from an edge inwards, over √(2π).
    fn at_the_edge(&self, normal: &Normal, held: &Held) -> f64 {
        let (matrix, i) = (&normal.matrix, held.place);
        let across = DVector::from_iterator(self.free.len(), self.free.iter().map(|j| matrix[(*j, i)]));
        let m = (matrix[(i, i)] - across.dot(&self.factor.solve(&across))).max(f64::MIN_POSITIVE);
        let g = normal.right[i] - matrix.row(i).transpose().dot(&self.whole);
        let z = if held.is_upper { -g } else { g } / m.sqrt();
        0.5 * z * z + log_mass(f64::NEG_INFINITY, z) - 0.5 * libm::log(m)
    }
}

/// Ends of an amplitude's prior: zero where it has one sign. Its plausible range is no prior, else
/// two names of one law would differ by their ranges.
pub(super) fn cut_at_nothing(low: f64) -> [f64; 2] {
    [if low == 0.0 { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY]
}

#[cfg(test)]
mod tests;
