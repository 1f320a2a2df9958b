//! What held-out data say of an augmented plant: a gain in log-likelihood, its interval, and a
//! verdict.

use super::ChannelFit;
use crate::statistics::student_two_sided;
use serde::Serialize;

/// What held-out data say of an augmented plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gain {
    pub loglik_gain: f64,
    pub gain_se: f64,
    pub blocks: usize,
    /// Of the blocks.
    pub skewness: f64,
    /// Sum of the signed roots of the blocks in its standard deviations under random signs.
    pub agreement: f64,
    /// Its free run's distance from the data over that of the plant alone: geometric mean of the
    /// rms over channels; one where it was not run, infinite where it diverged.
    pub free_run: f64,
}

/// Ratio of the free runs' distances from the data from which on the augmented plant runs away and
/// its effects are not confirmed. Chosen, no derivation: no name depends on it.
const FREE_RUN_DIVERGENCE_RATIO: f64 = 1.5;
impl Gain {
    /// Confidence interval of the gain at 95 % [nats, all held-out samples together].
    pub fn interval95(&self) -> [f64; 2] {
        self.interval(0.05)
    }

    /// Two-sided, missed with probability `alpha`.
    pub fn interval(&self, alpha: f64) -> [f64; 2] {
        // the spread is that of few blocks
        let t = student_two_sided(alpha, (self.blocks.max(2) - 1) as f64);
        let agrees = self.agreement * self.loglik_gain.signum();
        let at = |t: f64| if agrees > t.abs() { self.studentised(t) } else { t };
        [t, -t].map(|t| self.loglik_gain - at(t) * self.gain_se)
    }

    /// `g⁻¹(x)`.
    fn studentised(&self, x: f64) -> f64 {
        let kappa = self.skewness / (self.blocks.max(2) as f64).sqrt();
        if kappa.abs() < 1e-6 {
            return x;
        }
        3.0 / kappa * (libm::cbrt(1.0 + kappa * (x - kappa / 6.0)) - 1.0)
    }

    /// With free runs of the plant alone and with the effect.
    #[must_use]
    pub fn beside_free_runs(self, before: &[ChannelFit], after: &[ChannelFit]) -> Self {
        let ratio = |(before, after): (&ChannelFit, &ChannelFit)| match (before.rms.is_finite(), after.rms.is_finite())
        {
            (true, true) if before.rms > 0.0 && after.rms > 0.0 => libm::log(after.rms / before.rms),
            (true, false) => f64::INFINITY,
            _ => 0.0,
        };
        let sum: f64 = before.iter().zip(after).map(ratio).sum();
        Self { free_run: libm::exp(sum / before.len().max(1) as f64), ..self }
    }

    /// In free run it is further from the data than the plant alone.
    #[must_use]
    pub fn free_run_diverges(&self) -> bool {
        self.free_run > FREE_RUN_DIVERGENCE_RATIO
    }

    /// Confirmed where the 95 % interval is above zero, rejected where it is below, else unconfirmed.
    pub fn status(&self) -> Status {
        match self.interval95() {
            [low, _] if low > 0.0 => Status::Confirmed,
            [_, high] if high < 0.0 => Status::Rejected,
            _ => Status::Unconfirmed,
        }
    }
}

/// Result of the held-out test of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Confirmed,
    Unconfirmed,
    Rejected,
    NotConverged,
}

/// Sum and standard error of differences in blocks of time.
pub fn blocks(differences: &[(f64, f64)], block_s: f64) -> Gain {
    let mut sums: Vec<f64> = Vec::new();
    let mut current = f64::NEG_INFINITY;
    for (t, d) in differences {
        let block = libm::floor(t / block_s);
        if block != current {
            sums.push(0.0);
            current = block;
        }
        *sums.last_mut().expect("a block was just begun") += d;
    }
    let n = sums.len() as f64;
    let total: f64 = sums.iter().sum();
    let mean = total / n.max(1.0);
    let mut variance: f64 = sums.iter().map(|s| (s - mean) * (s - mean)).sum();
    // neighbours go together where a trajectory drifts
    let next: f64 = sums.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum();
    variance += next.max(0.0);
    let moment = |power: i32| sums.iter().map(|s| (s - mean).powi(power)).sum::<f64>() / n.max(1.0);
    let skewness = moment(3) / moment(2).powf(1.5);
    let freedom = n / (n - 1.0).max(1.0);
    let roots: f64 = sums.iter().map(|s| s.signum() * s.abs().sqrt()).sum();
    let size: f64 = sums.iter().map(|s| s.abs()).sum();
    Gain {
        loglik_gain: total,
        gain_se: if n > 1.0 { (variance * freedom).sqrt() } else { f64::INFINITY },
        blocks: sums.len(),
        skewness: if skewness.is_finite() { skewness } else { 0.0 },
        agreement: if size > 0.0 { roots / size.sqrt() } else { 0.0 },
        free_run: 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    fn gain(sums: &[f64]) -> Gain {
        blocks(&sums.iter().enumerate().map(|(k, d)| (k as f64 + 0.5, *d)).collect::<Vec<_>>(), 1.0)
    }

    #[test]
    fn a_gain_that_few_blocks_hold_stands_where_none_is_against_it_and_a_loss_likewise() {
        let mut sums = vec![1.0; 30];
        sums.extend([150.0, 40.0, 25.0]);
        (0..30).for_each(|k| sums[k] += 0.3 * (k as f64).sin());
        assert_eq!(gain(&sums).status(), Status::Confirmed);
        sums.iter_mut().for_each(|d| *d = -*d);
        assert_eq!(gain(&sums).status(), Status::Rejected);
        // three blocks that the others do not bear out are chance, whatever they hold
        sums = (0..30).map(|k| 0.3 * (k as f64).sin()).chain([150.0, 40.0, 25.0]).collect();
        assert_eq!(gain(&sums).status(), Status::Unconfirmed);
        // nor where most are against it
        sums = (0..303).map(|k| if k % 101 == 50 { 1000.0 } else { -1.0 }).collect();
        assert_eq!(gain(&sums).status(), Status::Unconfirmed);
        // as much of the same by half of the blocks is chance
        sums.iter_mut().enumerate().for_each(|(k, d)| *d = if k % 2 == 0 { d.abs() } else { -d.abs() });
        assert_eq!(gain(&sums).status(), Status::Unconfirmed);
    }

    #[test]
    fn the_interval_of_skewed_gains_holds_their_mean_at_least_as_often_as_it_says_on_either_side() {
        // chi-squared of two degrees less its mean: skewness two
        let (mut hall, mut student) = ([0; 3], [0; 3]);
        for seed in 0..4000 {
            let x = Noise::new(seed).series(60, 1.0);
            let sums: Vec<f64> = x.chunks(2).map(|x| 0.5 * (x[0] * x[0] + x[1] * x[1]) - 1.0).collect();
            let found = gain(&sums);
            hall[found.status() as usize] += 1;
            student[Gain { skewness: 0.0, ..found }.status() as usize] += 1;
        }
        // confirmed, unconfirmed, rejected; 100 ± 10 on each side, fewer for the neighbours that
        // may count as correlated, and where most blocks are against the few that hold the sum
        assert!((1..=130).contains(&hall[0]) && (50..=130).contains(&hall[2]), "{hall:?}");
        assert!(student[0] < 30 && student[2] > 200, "{student:?}");
    }

    /// At a level far out, too. What is frozen foretells `δ` where there is
    /// nothing: it gains `δ r − δ²/2`.
    #[test]
    fn what_is_not_there_is_confirmed_far_out_no_more_often_than_the_level_says() {
        let level = 2e-4;
        let confirmed = [(0.01, 0.0), (0.01, 1.0), (0.3, 1.0)].map(|(size, spread)| {
            let is_confirmed = |seed: &u64| {
                let (r, width) = (Noise::new(*seed).series(30, 1.0), Noise::new(1_000_000 + seed).series(30, spread));
                let own = r.iter().zip(&width).map(|(r, width)| (r, size * libm::exp(*width)));
                let sums: Vec<f64> = own.map(|(r, delta)| delta * r - 0.5 * delta * delta).collect();
                gain(&sums).interval(2.0 * level)[0] > 0.0
            };
            (0..100_000).filter(is_confirmed).count()
        });
        // all blocks alike, and few that hold most of it; 20 ± 4.5 were the mean nothing, fewer for
        // neighbours that count as correlated
        assert!((4..=33).contains(&confirmed[0]) && confirmed.iter().all(|count| *count <= 33), "{confirmed:?}");
    }
}
