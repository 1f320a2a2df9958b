//! A recorded motion as a smooth function of time: cubic smoothing spline, broken where the motion
//! has a kink.
//!
//! A displacement that is imposed is measured like anything else, and its rate and acceleration are
//! wanted. A spline through all samples turns noise into accelerations and rings at kinks. Here
//! `Σ (y − f)² + α ∫ f″²` is minimised (Reinsch, Numer. Math. 10, 1967), α by generalised
//! cross-validation (Craven and Wahba, 1979), and curvature is not penalised at knots at which the
//! slope jumps. Value, rate and acceleration are those of one function.
//!
//! With `γ` the second derivatives at the inner knots, `B = R + α QᵀQ`, `B γ = Qᵀ y`,
//! `f = y − α Q γ`; Q takes second differences of slopes, R is tridiagonal. A kink at knot k is row
//! k of Qᵀ left out: both sides are natural splines that share its value. Under the spline's prior
//! `γ` has covariance `c B⁻¹`, `c = (Qᵀy)ᵀγ / n`: the gain of leaving row k out is
//! `γ_k² / (c (B⁻¹)_kk)`, χ² with one degree of freedom. Knots proposed so are kept where
//! cross-validation agrees.
//!
//! Assumes increasing times and noise that is white and as large everywhere. Cost: O(n) for each α;
//! some forty of them a round.

use crate::statistics::chi_squared_quantile;
use dynamics::signal::SignalValue;
use estimation::golden_section;

/// Probability of a kink in a motion that has none.
const KINK_ALPHA: f64 = 1e-3;
const ROUNDS_MAX: usize = 8;
/// Range of ln(α / h³): no smoothing one can see; below where rounding of QᵀQ reaches R.
const LN_ALPHA: [f64; 2] = [-7.0, 23.0];
/// Below so many samples nothing can be said of noise.
const SAMPLES_MIN: usize = 12;

/// The function.
#[derive(Clone, Debug)]
pub struct SmoothMotion {
    time_s: Vec<f64>,
    value: Vec<f64>,
    /// Second derivatives at the knots, zero at the ends and at kinks.
    curvature: Vec<f64>,
    kinks: Vec<usize>,
    sigma: f64,
}

impl SmoothMotion {
    /// Motion behind the samples `value` at increasing `time_s`, two of them at least.
    ///
    /// # Panics
    /// When the lengths differ, or there are fewer than two samples.
    pub fn new(time_s: &[f64], value: &[f64]) -> Self {
        assert!(time_s.len() == value.len());
        assert!(time_s.len() >= 2);
        let mut band = Band::new(time_s, value);
        if time_s.len() < SAMPLES_MIN {
            return Self::of(time_s, &band.solve(0.0), Vec::new());
        }
        let mut kinks: Vec<usize> = Vec::new();
        let mut best = band.best();
        for _ in 0..ROUNDS_MAX {
            let found = band.kinks(&best, &kinks);
            if found.is_empty() {
                break;
            }
            // the crests of a sine gain as well, but predict no better:
            // ln GCV ≈ ln σ² + 2 (degrees of freedom) / n
            band.set_free(&found, false);
            let broken = band.best();
            let n = time_s.len() as f64;
            let better = n * (libm::log(best.gcv) - libm::log(broken.gcv));
            if better.is_nan() || better < 2.0 * libm::log(n) * found.len() as f64 {
                band.set_free(&found, true);
                break;
            }
            kinks.extend(found);
            kinks.sort_unstable();
            best = broken;
        }
        Self::of(time_s, &best, kinks)
    }

    fn of(time_s: &[f64], spline: &Spline, kinks: Vec<usize>) -> Self {
        Self {
            time_s: time_s.to_vec(),
            value: spline.value.clone(),
            curvature: spline.gamma.clone(),
            kinks,
            sigma: spline.sigma,
        }
    }

    /// Times at which the rate jumps \[s\].
    pub fn kinks_s(&self) -> Vec<f64> {
        self.kinks.iter().map(|k| self.time_s[*k]).collect()
    }

    /// Times and values of the knots; natural cubic splines join them from kink to kink.
    pub(super) fn knots(&self) -> (&[f64], &[f64]) {
        (&self.time_s, &self.value)
    }

    /// Places of the kinks among the knots.
    pub(super) fn kinks(&self) -> &[usize] {
        &self.kinks
    }

    /// Standard deviation of the noise that was taken off [unit of the motion].
    pub fn sigma(&self) -> f64 {
        self.sigma
    }

    /// Value and its two derivatives; before the first and behind the last sample the motion rests.
    /// Cost: a binary search.
    pub fn at(&self, t_s: f64) -> SignalValue {
        let last = self.time_s.len() - 1;
        if t_s < self.time_s[0] || t_s > self.time_s[last] {
            let value = if t_s < self.time_s[0] { self.value[0] } else { self.value[last] };
            return SignalValue { value, rate: 0.0, acceleration: 0.0 };
        }
        let right = self.time_s.partition_point(|time| *time <= t_s).clamp(1, last);
        let left = right - 1;
        let h = self.time_s[right] - self.time_s[left];
        let (b, a) = ((t_s - self.time_s[left]) / h, (self.time_s[right] - t_s) / h);
        let (y_0, y_1) = (self.value[left], self.value[right]);
        let (m_0, m_1) = (self.curvature[left], self.curvature[right]);
        SignalValue {
            value: a * y_0 + b * y_1 + h * h / 6.0 * ((a * a - 1.0) * a * m_0 + (b * b - 1.0) * b * m_1),
            rate: (y_1 - y_0) / h + h / 6.0 * ((3.0 * b * b - 1.0) * m_1 - (3.0 * a * a - 1.0) * m_0),
            acceleration: a * m_0 + b * m_1,
        }
    }
}

/// Solution for one α.
struct Spline {
    value: Vec<f64>,
    gamma: Vec<f64>,
    /// Diagonal of B⁻¹.
    inverse: Vec<f64>,
    gcv: f64,
    sigma: f64,
    /// `(Qᵀy)ᵀ γ`
    energy: f64,
}

/// Pentadiagonal system over all knots; of the ends and of kinks the equation is `γ = 0`. Times in
/// mean steps.
struct Band<'a> {
    h: Vec<f64>,
    step_s: f64,
    y: &'a [f64],
    free: Vec<bool>,
}

impl<'a> Band<'a> {
    fn new(time_s: &[f64], y: &'a [f64]) -> Self {
        let n = y.len();
        let step_s = (time_s[n - 1] - time_s[0]) / (n - 1) as f64;
        let h = time_s.windows(2).map(|w| (w[1] - w[0]) / step_s).collect();
        let free = (0..n).map(|i| i > 0 && i + 1 < n).collect();
        Self { h, step_s, y, free }
    }

    fn set_free(&mut self, knots: &[usize], free: bool) {
        knots.iter().for_each(|k| self.free[*k] = free);
    }

    /// Row i of Qᵀ: weights of samples i − 1, i, i + 1.
    fn q(&self, i: usize) -> [f64; 3] {
        if !self.free[i] {
            return [0.0; 3];
        }
        let (left, right) = (1.0 / self.h[i - 1], 1.0 / self.h[i]);
        [left, -left - right, right]
    }

    /// Diagonal and two upper bands of B.
    fn matrix(&self, alpha: f64) -> [Vec<f64>; 3] {
        let n = self.y.len();
        let mut bands = [vec![1.0; n], vec![0.0; n], vec![0.0; n]];
        for i in (0..n).filter(|i| self.free[*i]) {
            let q = self.q(i);
            bands[0][i] = (self.h[i - 1] + self.h[i]) / 3.0 + alpha * q.iter().map(|q| q * q).sum::<f64>();
            if self.free[i + 1] {
                let next = self.q(i + 1);
                bands[1][i] = self.h[i] / 6.0 + alpha * (q[1] * next[0] + q[2] * next[1]);
            }
            if i + 2 < n && self.free[i + 2] {
                bands[2][i] = alpha * q[2] * self.q(i + 2)[0];
            }
        }
        bands
    }

    /// The spline for `alpha` (in mean steps cubed): factor `L D Lᵀ`, bands of the inverse by
    /// Hutchinson and de Hoog (Numer. Math. 47, 1985).
    fn solve(&self, alpha: f64) -> Spline {
        let n = self.y.len();
        let [diagonal, first, second] = self.matrix(alpha);
        let (mut d, mut l_1, mut l_2) = (diagonal, vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            if i >= 1 {
                d[i] -= l_1[i - 1] * l_1[i - 1] * d[i - 1];
            }
            if i >= 2 {
                d[i] -= l_2[i - 2] * l_2[i - 2] * d[i - 2];
            }
            let carried = if i >= 1 { l_1[i - 1] * l_2[i - 1] * d[i - 1] } else { 0.0 };
            l_1[i] = (first[i] - carried) / d[i];
            l_2[i] = second[i] / d[i];
        }
        let right: Vec<f64> = (0..n).map(|i| self.second_difference(i)).collect();
        let mut gamma = right.clone();
        for i in 1..n {
            gamma[i] -= l_1[i - 1] * gamma[i - 1] + if i >= 2 { l_2[i - 2] * gamma[i - 2] } else { 0.0 };
        }
        gamma.iter_mut().zip(&d).for_each(|(g, d)| *g /= d);
        for i in (0..n - 1).rev() {
            gamma[i] -= l_1[i] * gamma[i + 1] + if i + 2 < n { l_2[i] * gamma[i + 2] } else { 0.0 };
        }
        let inverse = inverse_bands(&d, &l_1, &l_2);
        self.spline(alpha, gamma, &right, inverse)
    }

    fn second_difference(&self, i: usize) -> f64 {
        if !self.free[i] {
            return 0.0;
        }
        (self.y[i + 1] - self.y[i]) / self.h[i] - (self.y[i] - self.y[i - 1]) / self.h[i - 1]
    }

    fn spline(&self, alpha: f64, mut gamma: Vec<f64>, right: &[f64], inverse: [Vec<f64>; 3]) -> Spline {
        let n = self.y.len();
        let mut value = self.y.to_vec();
        let mut trace = 0.0;
        for i in (0..n).filter(|i| self.free[*i]) {
            let q = self.q(i);
            (0..3).for_each(|k| value[i + k - 1] -= alpha * q[k] * gamma[i]);
            trace += inverse[0][i] * q.iter().map(|q| q * q).sum::<f64>();
            let next = self.q(i + 1);
            trace += 2.0 * inverse[1][i] * (q[1] * next[0] + q[2] * next[1]);
            if i + 2 < n {
                trace += 2.0 * inverse[2][i] * q[2] * self.q(i + 2)[0];
            }
        }
        let freedom = (alpha * trace).max(1e-9);
        let rss: f64 = value.iter().zip(self.y).map(|(f, y)| (f - y) * (f - y)).sum();
        let energy = gamma.iter().zip(right).map(|(g, r)| g * r).sum();
        gamma.iter_mut().for_each(|g| *g /= self.step_s * self.step_s);
        let [inverse, ..] = inverse;
        Spline {
            value,
            gamma,
            inverse,
            gcv: n as f64 * rss / (freedom * freedom),
            sigma: (rss / freedom).sqrt(),
            energy,
        }
    }

    /// Least generalised cross-validation: a grid, then golden section about its least point.
    fn best(&self) -> Spline {
        const GRID_POINTS: usize = 16;
        let [low, high] = LN_ALPHA;
        let at = |k: usize| low + (high - low) * k as f64 / (GRID_POINTS - 1) as f64;
        let gcv = |ln_alpha: f64| self.solve(libm::exp(ln_alpha)).gcv;
        let grid: Vec<f64> = (0..GRID_POINTS).map(|k| gcv(at(k))).collect();
        let least = (0..GRID_POINTS).min_by(|a, b| grid[*a].total_cmp(&grid[*b])).expect("the grid has points");
        if least == 0 {
            // nothing to take off
            return Spline { gcv: grid[0], ..self.solve(0.0) };
        }
        let best = golden_section::minimise(at(least - 1), at((least + 1).min(GRID_POINTS - 1)), 10, gcv);
        self.solve(libm::exp(best))
    }

    /// Knots whose curvature is beyond what the spline's prior allows; of neighbours the largest.
    fn kinks(&self, spline: &Spline, known: &[usize]) -> Vec<usize> {
        let n = self.y.len();
        let count = self.free.iter().filter(|free| **free).count() as f64;
        let scale = spline.energy / count;
        if count < SAMPLES_MIN as f64 || scale.is_nan() || scale <= 0.0 {
            return Vec::new();
        }
        let level = chi_squared_quantile(1.0 - KINK_ALPHA / count, 1.0);
        let unit = self.step_s * self.step_s;
        let gain = |i: usize| {
            let gamma = spline.gamma[i] * unit;
            if self.free[i] { gamma * gamma / (scale * spline.inverse[i]) } else { 0.0 }
        };
        let gains: Vec<f64> = (0..n).map(gain).collect();
        let most = gains.iter().copied().fold(0.0, f64::max);
        // what one kink leaks to its neighbours goes when it is let go: only the largest of a round
        let mut found: Vec<usize> = Vec::new();
        for i in (1..n - 1).filter(|i| gains[*i] > level && gains[*i] > 0.25 * most) {
            let near = i.saturating_sub(3)..(i + 4).min(n);
            let largest = near.clone().all(|j| gains[j] < gains[i] || j == i || (gains[j] == gains[i] && j > i));
            if largest && !known.iter().any(|k| near.contains(k)) {
                found.push(i);
            }
        }
        found
    }
}

/// Diagonal and two upper bands of the inverse of `L D Lᵀ`.
fn inverse_bands(d: &[f64], l_1: &[f64], l_2: &[f64]) -> [Vec<f64>; 3] {
    let n = d.len();
    let mut s = [vec![0.0; n + 2], vec![0.0; n + 2], vec![0.0; n + 2]];
    for i in (0..n).rev() {
        let (a, b) = (l_1[i], l_2[i]);
        s[1][i] = -a * s[0][i + 1] - b * s[1][i + 1];
        s[2][i] = -a * s[1][i + 1] - b * s[0][i + 2];
        s[0][i] = 1.0 / d[i] - a * s[1][i] - b * s[2][i];
    }
    s
}

#[cfg(test)]
mod tests;
