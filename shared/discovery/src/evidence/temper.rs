//! Tempering: what a gain in log-likelihood is worth where innovations are not independent.
//!
//! ```text
//! δ_k = ln p_a(y_k) − ln p_b(y_k),   D = Σ δ_k,   V = n (γ₀ + 2 Σ_{l≤L} (1 − l/(L+1)) γ_l),   L = n^{1/3}
//! gain that counts: D min(1, 2 |D| / V)
//! ```
//!
//! In a right model V ≈ 2 |D| (the likelihood ratio of two normal models has twice its mean for
//! variance). A brief effect has few instants and keeps about `2 n_eff` nats.

/// `D` and the gain that counts, of log-likelihoods of the same instants under two models.
pub(super) fn tempered(ours: &[f64], theirs: &[f64]) -> [f64; 2] {
    let difference: Vec<f64> = ours.iter().zip(theirs).map(|(a, b)| a - b).collect();
    let whole: f64 = difference.iter().sum();
    let variance = long_run_variance(&difference);
    let share = if variance > 0.0 { (2.0 * whole.abs() / variance).min(1.0) } else { 1.0 };
    [whole, whole * share]
}

/// Of the sum of `series`, by Bartlett's window.
fn long_run_variance(series: &[f64]) -> f64 {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n.max(1) as f64;
    let lags = libm::cbrt(n as f64) as usize;
    let product =
        |lag: usize| -> f64 { series.iter().zip(series.iter().skip(lag)).map(|(a, b)| (a - mean) * (b - mean)).sum() };
    let weight = |lag: usize| 1.0 - lag as f64 / (lags + 1) as f64;
    let beside: f64 = (1..=lags).map(|lag| 2.0 * weight(lag) * product(lag)).sum();
    (product(0) + beside).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// Log-likelihoods of `r` under no mean and under a mean `m`.
    fn models(r: &[f64], mean: f64) -> [Vec<f64>; 2] {
        [mean, 0.0].map(|m| r.iter().map(|r| -0.5 * (r - m) * (r - m)).collect())
    }

    #[test]
    fn a_true_gain_is_kept_and_one_of_noise_that_remembers_is_not() {
        let (mut kept, mut lost) = (0.0, 0.0);
        for seed in 0..40 {
            let white = Noise::new(seed).series(2000, 1.0);
            let shifted: Vec<f64> = white.iter().map(|r| r + 0.3).collect();
            let [ours, theirs] = models(&shifted, 0.3);
            let [whole, counts] = tempered(&ours, &theirs);
            kept += counts / whole / 40.0;
            // AR(1) of pole 0.9 and variance one, its mean taken for a law
            let mut slow = Vec::new();
            let mut v = 0.0;
            for r in &white {
                v = 0.9 * v + (1.0 - 0.81f64).sqrt() * r;
                slow.push(v);
            }
            let mean = slow.iter().sum::<f64>() / slow.len() as f64;
            let [ours, theirs] = models(&slow, mean);
            let [whole, counts] = tempered(&ours, &theirs);
            lost += counts / whole.max(1e-9) / 40.0;
        }
        // V is estimated to √(2L/n) = 11 %, and a share stops at one
        assert!(kept > 0.9, "{kept}");
        // nineteen times the variance of a mean of white noise, of which the window sees a part
        assert!(lost < 0.25, "{lost}");
    }
}
