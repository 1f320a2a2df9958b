//! Statistics shared by the checks: quantiles of the standard laws, least squares with a covariance
//! that holds for correlated residuals, and the level of the white noise under a signal.

use estimation::consistency::{bartlett_weight, normal_quantile};
use estimation::quantiles::median;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{Beta, ChiSquared, ContinuousCDF, FisherSnedecor, StudentsT};

/// Arithmetic mean; zero of no values.
#[must_use]
pub fn mean(x: &[f64]) -> f64 {
    if x.is_empty() { 0.0 } else { x.iter().sum::<f64>() / x.len() as f64 }
}

/// Root of the mean square about zero.
#[must_use]
pub fn rms(x: &[f64]) -> f64 {
    if x.is_empty() { 0.0 } else { (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt() }
}

/// Root of the mean square about the mean.
#[must_use]
pub fn deviation(x: &[f64]) -> f64 {
    let m = mean(x);
    if x.is_empty() { 0.0 } else { (x.iter().map(|v| (v - m) * (v - m)).sum::<f64>() / x.len() as f64).sqrt() }
}

/// `z` with two-sided normal tail probability `p`.
#[must_use]
pub fn normal_two_sided(p: f64) -> f64 {
    -normal_quantile(0.5 * p.clamp(1e-300, 1.0))
}

/// Upper tail of the normal law.
#[must_use]
pub fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z * core::f64::consts::FRAC_1_SQRT_2)
}

/// `t` with two-sided tail probability `p` of Student's law.
#[must_use]
pub fn student_two_sided(p: f64, freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::INFINITY, |law| -law.inverse_cdf(0.5 * p.max(1e-16)))
}

/// Upper tail of χ² with real-valued degrees of freedom.
#[must_use]
pub fn chi_squared_tail(x: f64, freedom: f64) -> f64 {
    if !x.is_finite() {
        return if x > 0.0 { 0.0 } else { 1.0 };
    }
    ChiSquared::new(freedom.max(1e-3)).map_or(1.0, |law| law.sf(x.max(0.0)))
}

/// Upper tail of the likelihood ratio of `freedom` numbers, some of them nothing at the edge of
/// what they can be where `one_sided`: `½ (χ²_{k−1} + χ²_k)`, exact for one such number among k
/// (Self and Liang, JASA 82, 1987, case 6) and a bound for more of them, at whatever angles: of the
/// mixture's weights those of odd and those of even freedom sum to a half each.
#[must_use]
pub fn chi_bar_squared_tail(x: f64, freedom: usize, one_sided: bool) -> f64 {
    let tail = |free: usize| match free {
        0 => f64::from(u8::from(x <= 0.0)),
        free => chi_squared_tail(x.max(0.0), free as f64),
    };
    if one_sided { 0.5 * (tail(freedom.saturating_sub(1)) + tail(freedom)) } else { tail(freedom) }
}

/// Value of χ² with lower-tail probability `p`.
#[must_use]
pub fn chi_squared_quantile(p: f64, freedom: f64) -> f64 {
    ChiSquared::new(freedom.max(1e-3)).map_or(f64::INFINITY, |law| law.inverse_cdf(p.clamp(1e-15, 1.0 - 1e-15)))
}

/// Upper tail of Fisher's law.
#[must_use]
pub fn fisher_tail(f: f64, above: f64, below: f64) -> f64 {
    if f.is_nan() || f <= 0.0 || above <= 0.0 || below <= 0.0 {
        return 1.0;
    }
    if f.is_infinite() {
        return 0.0;
    }
    FisherSnedecor::new(above, below).map_or(1.0, |law| law.sf(f))
}

/// Probability that the squared correlation of two independent series reaches `r2`, `freedom`
/// degrees being left.
#[must_use]
pub fn squared_correlation_tail(r2: f64, regressors: f64, freedom: f64) -> f64 {
    if freedom <= 0.0 || r2.is_nan() {
        return 1.0;
    }
    Beta::new(0.5 * regressors, 0.5 * freedom).map_or(1.0, |law| law.sf(r2.clamp(0.0, 1.0)))
}

/// Least squares with a covariance that allows for correlated residuals.
#[derive(Clone, Debug)]
pub struct LeastSquares {
    pub coefficients: Vec<f64>,
    /// Standard deviations, Newey–West with the lag of [`least_squares`].
    pub sigma: Vec<f64>,
    pub residual: Vec<f64>,
    /// Rank of the scaled regressors at a relative tolerance of 1e-11.
    pub rank: usize,
    /// Share of the variance about the mean that is explained.
    pub r2: f64,
}

/// Solves `A x ≈ b` in the least-squares sense by QR and the singular values of R.
///
/// Columns are scaled to unit length first; directions below 1e-11 of the largest singular value
/// are left out. The covariance is `(AᵀA)⁻¹ S (AᵀA)⁻¹`, S summed over products `a_t e_t` up to
/// `lag` with Bartlett weights; `lag` 0 still allows for unequal variance. `None` when rows are
/// fewer than columns + 1 or a column is not finite.
///
/// Cost: O(n p² + n p lag).
#[must_use]
pub fn least_squares(columns: &[Vec<f64>], b: &[f64], lag: usize) -> Option<LeastSquares> {
    let (n, p) = (b.len(), columns.len());
    if n < p + 1 || p == 0 || columns.iter().any(|c| c.len() != n) {
        return None;
    }
    let norms: Vec<f64> = columns.iter().map(|c| c.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
    if norms.iter().any(|v| !v.is_finite()) || b.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let scale: Vec<f64> = norms.iter().map(|v| if *v > 0.0 { 1.0 / v } else { 0.0 }).collect();
    let a = DMatrix::from_fn(n, p, |i, j| columns[j][i] * scale[j]);
    let qr = a.clone().qr();
    let mut rotated = DVector::from_column_slice(b);
    qr.q_tr_mul(&mut rotated);
    let svd = qr.r().svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let cut = 1e-11 * svd.singular_values.max();
    let inverse: Vec<f64> = svd.singular_values.iter().map(|s| if *s > cut { 1.0 / s } else { 0.0 }).collect();
    let rank = inverse.iter().filter(|s| **s > 0.0).count();
    let projected = u.transpose() * rotated.rows(0, p);
    let x = v_t.transpose() * DVector::from_fn(p, |i, _| projected[i] * inverse[i]);
    let residual = DVector::from_column_slice(b) - &a * &x;
    let bread = v_t.transpose() * DMatrix::from_diagonal(&DVector::from_fn(p, |i, _| inverse[i] * inverse[i])) * &v_t;
    let cov = &bread * long_run_products(&a, residual.as_slice(), lag) * &bread;
    let freedom = n as f64 / (n - rank).max(1) as f64;
    let spread = deviation(b);
    Some(LeastSquares {
        coefficients: (0..p).map(|j| x[j] * scale[j]).collect(),
        sigma: (0..p).map(|j| (cov[(j, j)].max(0.0) * freedom).sqrt() * scale[j]).collect(),
        r2: if spread > 0.0 { 1.0 - (rms(residual.as_slice()) / spread).powi(2) } else { 0.0 },
        residual: residual.as_slice().to_vec(),
        rank,
    })
}

fn long_run_products(a: &DMatrix<f64>, e: &[f64], lag: usize) -> DMatrix<f64> {
    let scores = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * e[i]);
    let mut sum = scores.tr_mul(&scores);
    let n = scores.nrows();
    for k in 1..=lag.min(n.saturating_sub(1)) {
        let cross = scores.rows(0, n - k).tr_mul(&scores.rows(k, n - k));
        sum += (&cross + cross.transpose()) * bartlett_weight(k, lag);
    }
    sum
}

/// White noise under a signal, from differences of high order.
#[derive(Clone, Copy, Debug)]
pub struct WhiteFloor {
    /// Standard deviation per sample.
    pub sigma: f64,
    /// True when three orders agree within their scatter: the top of the spectrum is flat.
    pub flat: bool,
    /// Equivalent number of independent samples behind `sigma`.
    pub freedom: f64,
}

/// Lowest and highest order of difference compared.
const ORDERS: [usize; 3] = [4, 6, 8];

/// Level of the white noise under a smooth signal.
///
/// The d-th difference of white noise has variance `C(2d, d) σ²`, that of a smooth signal vanishes
/// with d; where the orders 4, 6 and 8 give one σ, that is the noise. The median over blocks keeps
/// a burst or a spike from deciding. Order 8 looks at the top third of the spectrum. `None` below
/// 40 samples. (von Neumann; Gasser, Sroka and Jennen-Steinmetz 1986.)
#[must_use]
pub fn white_floor(x: &[f64]) -> Option<WhiteFloor> {
    if x.len() < 40 {
        return None;
    }
    let sigma: Vec<f64> = ORDERS.iter().map(|&d| difference_sigma(x, d)).collect();
    let freedom = x.len() as f64 / difference_dependence(ORDERS[2]);
    // 4 standard errors of ln sigma (1/sqrt(2 nu)) and 10 %, about 1 dB: what "flat" means to a
    // reader of spectra.
    let band = 4.0 / (2.0 * freedom).sqrt() + 0.1;
    let flat = sigma[2] > 0.0 && sigma[0] / sigma[2] < libm::exp(band) && sigma[2] / sigma[0] < libm::exp(band);
    Some(WhiteFloor { sigma: sigma[2], flat, freedom })
}

/// Standard deviation of the white noise that would give the differences of order `d` their size;
/// median over blocks.
#[must_use]
pub fn difference_sigma(x: &[f64], order: usize) -> f64 {
    let y = differences(x, order);
    let scale = 1.0 / binomial(2 * order, order).sqrt();
    let blocks = (y.len() / 24).clamp(1, 31);
    let size = y.len() / blocks;
    let mut power: Vec<f64> = (0..blocks)
        .map(|b| rms(&y[b * size..if b + 1 == blocks { y.len() } else { (b + 1) * size }]).powi(2))
        .collect();
    // Median of a scaled chi-squared of nu degrees lies at (1 - 2/(9 nu))^3 of its mean (Wilson and
    // Hilferty).
    let nu = size as f64 / difference_dependence(order);
    let correction = (1.0 - 2.0 / (9.0 * nu.max(1.0))).powi(3);
    (median(&mut power) / if blocks > 2 { correction } else { 1.0 }).sqrt() * scale
}

/// Differences of order `order`.
#[must_use]
pub fn differences(x: &[f64], order: usize) -> Vec<f64> {
    let mut y = x.to_vec();
    for _ in 0..order {
        y = y.windows(2).map(|w| w[1] - w[0]).collect();
    }
    y
}

/// Samples of d-th differences of white noise worth one independent sample:
/// `Σ ρ² = C(4d, 2d) / C(2d, d)²`.
#[must_use]
pub fn difference_dependence(order: usize) -> f64 {
    binomial(4 * order, 2 * order) / binomial(2 * order, order).powi(2)
}

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).map(|i| (n - k + i) as f64 / i as f64).product()
}

/// Integrated correlation time in samples: `1 + 2 Σ ρ_k` up to the first non-positive pair sum
/// (Geyer), at least 1.
#[must_use]
pub fn correlation_length(x: &[f64]) -> f64 {
    let (n, m) = (x.len(), mean(x));
    let c0: f64 = x.iter().map(|v| (v - m) * (v - m)).sum();
    if c0 <= 0.0 || n < 4 {
        return 1.0;
    }
    let rho = |k: usize| (0..n - k).map(|i| (x[i] - m) * (x[i + k] - m)).sum::<f64>() / c0;
    let (mut sum, mut k) = (1.0, 1);
    while k + 1 < (n / 2).min(2000) {
        let pair = rho(k) + rho(k + 1);
        if pair <= 0.0 {
            break;
        }
        sum += 2.0 * pair;
        k += 2;
    }
    sum.max(1.0)
}

/// Holm's step-down: p-values made comparable with one level for the whole family, in the order
/// given.
#[must_use]
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&i, &j| p[i].total_cmp(&p[j]));
    let (mut adjusted, mut floor) = (vec![1.0; p.len()], 0.0_f64);
    for (rank, &i) in order.iter().enumerate() {
        floor = floor.max((p[i] * (p.len() - rank) as f64).min(1.0));
        adjusted[i] = floor;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Against counts of draws, numbers that may not be negative at their edge where they would be.
    #[test]
    fn a_number_of_one_sign_has_half_the_chance_and_two_have_no_more() {
        assert_eq!(chi_bar_squared_tail(9.0, 1, true), 0.5 * chi_squared_tail(9.0, 1.0));
        assert_eq!(chi_bar_squared_tail(9.0, 3, false), chi_squared_tail(9.0, 3.0));
        const DRAWS: usize = 100_000;
        for (freedom, one_sided, x) in [(2, 1, 3.0), (4, 1, 6.0), (2, 2, 3.0), (4, 3, 5.0)] {
            let mut noise = Noise::new(3);
            let square = |z: f64, i: usize| if i < one_sided { z.max(0.0).powi(2) } else { z * z };
            let above = (0..DRAWS).filter(|_| (0..freedom).map(|i| square(noise.normal(), i)).sum::<f64>() > x).count();
            let (share, tail) = (above as f64 / DRAWS as f64, chi_bar_squared_tail(x, freedom, true));
            let sigma = (tail * (1.0 - tail) / DRAWS as f64).sqrt();
            let is_exact = one_sided == 1;
            let off = share - tail;
            assert!(off < 4.0 * sigma && (!is_exact || off > -4.0 * sigma), "{freedom} {one_sided}: {share} {tail}");
        }
    }
}
