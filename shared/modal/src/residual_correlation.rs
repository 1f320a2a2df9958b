//! Correlation of the residuals of neighbouring lines, and what it makes of standard deviations.
//!
//! Windows, zero padding and leakage make the errors of neighbouring lines one error. With
//! `ρ_m = Σ z̄_k z_{k+m} / Σ |z|²` over all lines and channels of the normalised residuals z, the
//! score of a fit, `g_p = Re Σ_k J̄_kp z_k`, has the covariance
//! `M_pq = Re Σ_kl J̄_kp J_lq ρ_{k−l}` instead of `Jᵀ J`.

use faer::{Mat, c64};

/// Most lags: a Hann window correlates two lines, fourfold zero padding eight.
const CORRELATION_LAGS_MAX: usize = 16;
/// Probability that white residuals are taken for correlated ones.
const FALSE_CORRELATION: f64 = 0.01;

/// `ρ₁ … ρ_m` up to the last lag that white noise would not show; empty for white residuals.
///
/// For N white complex residuals `N |ρ|²` is exponential with mean one, for real ones χ²₁, of which
/// the tail is thinner.
pub(crate) fn correlations(residuals: &[Vec<c64>]) -> Vec<c64> {
    let lines = residuals.first().map_or(0, Vec::len);
    let lags = CORRELATION_LAGS_MAX.min(lines / 8);
    let power: f64 = residuals.iter().flatten().map(|z| z.norm_sqr()).sum();
    if lags == 0 || power <= 0.0 {
        return Vec::new();
    }
    let at = |lag: usize| {
        let product = |z: &Vec<c64>| {
            z.iter().zip(&z[lag..]).fold(c64::new(0.0, 0.0), |sum, (early, late)| sum + early.conj() * late)
        };
        residuals.iter().map(product).fold(c64::new(0.0, 0.0), |sum, x| sum + x) / power
    };
    let mut all: Vec<c64> = (1..=lags).map(at).collect();
    let needed = libm::log(lags as f64 / FALSE_CORRELATION) / (residuals.len() * lines) as f64;
    let last = all.iter().rposition(|rho| rho.norm_sqr() > needed).map_or(0, |at| at + 1);
    all.truncate(last);
    all
}

/// Whether these are the correlations of neighbours that are `expected` of windowed segments: that
/// of next neighbours nearer to theirs than to none, all others theirs but for chance. Channels of
/// one record share its force, so that `lines` alone count: `|ρ̂ − ρ|²` is exponential with mean
/// `(1 + 2 Σ ρ²)/lines` (Bartlett 1946). A smooth error of the model is common to all lags; it is
/// taken out.
pub(crate) fn are_of_windows(rho: &[c64], expected: &[f64], lines: usize) -> bool {
    let far = rho.get(expected.len()..).filter(|far| !far.is_empty());
    let common = far.map_or(0.0, |far| (far.iter().map(|rho| rho.re).sum::<f64>() / far.len() as f64).clamp(0.0, 0.5));
    let spread = 1.0 + 2.0 * expected.iter().map(|rho| rho * rho).sum::<f64>();
    let chance = spread * libm::log(CORRELATION_LAGS_MAX as f64 / FALSE_CORRELATION) / lines as f64;
    let expected = |m: usize| expected.get(m).copied().unwrap_or(0.0);
    let own = |rho: &c64| (rho - common) / (1.0 - common);
    let is = |m: usize, rho: &c64| (own(rho) - expected(m)).norm_sqr() < chance;
    rho.first().is_some_and(|rho| own(rho).re > 0.5 * expected(0).max(chance.sqrt()) || is(0, rho))
        && rho.iter().enumerate().skip(1).all(|(m, rho)| is(m, rho))
}

/// `1 + 2 Σ |ρ_m|`: the most that the variance of a sum over lines grows.
pub(crate) fn inflation(rho: &[c64]) -> f64 {
    1.0 + 2.0 * rho.iter().map(|rho| rho.norm_sqr().sqrt()).sum::<f64>()
}

/// `M` of one channel, with `jacobian` one vector over the lines per parameter.
pub(crate) fn score_covariance(jacobian: &[Vec<c64>], rho: &[c64]) -> Mat<f64> {
    let n = jacobian.len();
    Mat::from_fn(n, n, |p, q| {
        let (of_p, of_q) = (&jacobian[p], &jacobian[q]);
        let mut sum: f64 = of_p.iter().zip(of_q).map(|(p, q)| (p.conj() * q).re).sum();
        for (m, rho) in rho.iter().enumerate() {
            let lag = m + 1;
            let later_p = of_p[lag..].iter().zip(of_q).map(|(p, q)| (p.conj() * q * rho).re);
            let later_q = of_p.iter().zip(&of_q[lag..]).map(|(p, q)| (p.conj() * q * rho.conj()).re);
            sum += later_p.sum::<f64>() + later_q.sum::<f64>();
        }
        sum
    })
}

/// The covariance of the score from the scores of the lines themselves, summed over channels, with
/// `lags` neighbours under a falling weight (Newey & West 1987). It sees errors of the model where
/// they are, at the peaks, which a correlation over all lines does not.
pub(crate) fn score_scatter(scores: &[Vec<f64>], lags: usize) -> Mat<f64> {
    let n = scores.len();
    let sum = |p: usize, q: usize, lag: usize| -> f64 {
        scores[p].iter().zip(scores[q].iter().skip(lag)).map(|(early, late)| early * late).sum()
    };
    Mat::from_fn(n, n, |p, q| {
        let falling = |lag: usize| 1.0 - lag as f64 / (lags + 1) as f64;
        sum(p, q, 0) + (1..=lags).map(|lag| falling(lag) * (sum(p, q, lag) + sum(q, p, lag))).sum::<f64>()
    })
}

/// Lines from stacked rows: pairs of real and imaginary parts, or real lines.
pub(crate) fn lines_of(rows: &[f64], rows_per_line: usize) -> Vec<c64> {
    rows.chunks_exact(rows_per_line).map(|x| c64::new(x[0], x.get(1).copied().unwrap_or(0.0))).collect()
}
