//! Significance independent of the noise model: Bartlett window over the products of column and
//! residual.

use estimation::consistency::long_run_score;

/// Robust form of one score.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Robust {
    pub z: f64,
    /// Lag of the window, in instants.
    pub lag: usize,
    /// Instants that carry the effect: `(Σ c²)² / Σ c⁴`.
    pub instants: f64,
    /// Largest z that any amplitude can reach.
    pub ceiling: f64,
}

/// [`long_run_score`] of the products of column and residual, summed per instant.
pub fn robust(c: &[f64], r: &[f64], events: &[usize]) -> Robust {
    let instants = events.last().map_or(0, |last| last + 1);
    let mut s = vec![0.0; instants];
    let mut power = vec![0.0; instants];
    for ((c, r), event) in c.iter().zip(r).zip(events) {
        s[*event] += c * r;
        power[*event] += c * c;
    }
    let total: f64 = power.iter().sum();
    let fourth: f64 = power.iter().map(|p| p * p).sum();
    if total <= 0.0 || instants < 10 {
        return Robust::default();
    }
    let carrying = total * total / fourth;
    let score = long_run_score(&s);
    Robust { z: score.z, lag: score.lag, instants: carrying, ceiling: (carrying / (score.lag + 1) as f64).sqrt() }
}
