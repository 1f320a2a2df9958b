//! Likelihood of residual frequencies under a plant, its unknowns' priors and a discrepancy of unknown size.
//!
//! `r = ln f_measured − ln f_plant ~ N(0, C)`, `C = diag(σ²) + J P Jᵀ + τ² 1`: what the peaks are known to, what the priors of the plant's
//! numbers allow (J: derivatives of ln f by them, P: their variances), and what no plant of a few numbers explains (τ, by maximum
//! likelihood). With few modes τ decides what is significant: a plant that misses every mode by a per cent is not refuted by peaks
//! known to a millionth, but a change that takes the misses away is.

use nalgebra::{Cholesky, DMatrix, DVector};

/// Modes that were matched, and what is known of them.
pub(super) struct Evidence {
    /// Of ln f.
    pub sigma: Vec<f64>,
    /// Derivatives of ln f by unknowns times their prior sigmas: matched modes × unknowns.
    pub prior: DMatrix<f64>,
}

/// Value of the likelihood for one residual.
#[derive(Clone, Copy, Debug)]
pub(super) struct Likelihood {
    /// −2 ln L without constants.
    pub objective: f64,
    pub tau: f64,
    /// Root mean square of the residual behind the nominal unknowns.
    pub rms: f64,
}

/// Least and largest ln τ.
const LN_TAU: [f64; 2] = [-12.0, 0.0];

impl Evidence {
    pub fn covariance(&self, tau: f64) -> DMatrix<f64> {
        let n = self.sigma.len();
        let own = DMatrix::from_fn(n, n, |i, j| if i == j { self.sigma[i] * self.sigma[i] + tau * tau } else { 0.0 });
        own + &self.prior * self.prior.transpose()
    }

    /// Evidence of some of the modes.
    pub fn part(&self, rows: core::ops::Range<usize>) -> Self {
        Self { sigma: self.sigma[rows.clone()].to_vec(), prior: self.prior.rows(rows.start, rows.len()).into_owned() }
    }

    pub fn at(&self, residual: &[f64], tau: f64) -> f64 {
        let r = DVector::from_row_slice(residual);
        let Some(factor) = Cholesky::new(self.covariance(tau)) else { return f64::INFINITY };
        let log: f64 = factor.l_dirty().diagonal().iter().map(|d| libm::log(*d)).sum();
        r.dot(&factor.solve(&r)) + 2.0 * log
    }

    /// Best τ by a grid and golden section.
    pub fn best(&self, residual: &[f64]) -> Likelihood {
        let [low, high] = LN_TAU;
        let value = |ln_tau: f64| self.at(residual, libm::exp(ln_tau));
        let at = |k: i32| low + (high - low) * f64::from(k) / 24.0;
        let least = (0..=24).min_by(|a, b| value(at(*a)).total_cmp(&value(at(*b)))).unwrap_or(0);
        let ln_tau = golden(at((least - 1).max(0)), at((least + 1).min(24)), 30, &value);
        let tau = libm::exp(ln_tau);
        Likelihood { objective: value(ln_tau), tau, rms: self.rms(residual, tau) }
    }

    /// Residual that is left when the nominal unknowns have taken their part.
    pub fn left(&self, residual: &[f64], tau: f64) -> Vec<f64> {
        let r = DVector::from_row_slice(residual);
        let Some(factor) = Cholesky::new(self.covariance(tau)) else { return residual.to_vec() };
        let taken = &self.prior * (self.prior.transpose() * factor.solve(&r));
        (r - taken).iter().copied().collect()
    }

    /// What these modes know of the amplitude of a change that moves them by `slope` each.
    pub fn precision(&self, slope: &[f64], tau: f64) -> f64 {
        let slope = DVector::from_row_slice(slope);
        let factor = Cholesky::new(self.covariance(tau));
        factor.map_or(1e-300, |factor| slope.dot(&factor.solve(&slope)).max(1e-300))
    }

    fn rms(&self, residual: &[f64], tau: f64) -> f64 {
        crate::statistics::rms(&self.left(residual, tau))
    }

    /// Cosine between two directions behind the nominal unknowns.
    pub fn cosine(&self, a: &[f64], b: &[f64], tau: f64) -> f64 {
        let Some(factor) = Cholesky::new(self.covariance(tau)) else { return 0.0 };
        let (a, b) = (DVector::from_row_slice(a), DVector::from_row_slice(b));
        let (of_a, of_b) = (factor.solve(&a), factor.solve(&b));
        let size = (a.dot(&of_a) * b.dot(&of_b)).sqrt();
        if size > 0.0 { a.dot(&of_b) / size } else { 0.0 }
    }
}

/// Minimum of `f` in `[a, b]` by golden section.
pub(super) fn golden(mut a: f64, mut b: f64, steps: usize, f: &dyn Fn(f64) -> f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut c, mut d) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut at_c, mut at_d) = (f(c), f(d));
    for _ in 0..steps {
        if at_c < at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - GOLDEN * (b - a);
            at_c = f(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + GOLDEN * (b - a);
            at_d = f(d);
        }
    }
    0.5 * (a + b)
}
