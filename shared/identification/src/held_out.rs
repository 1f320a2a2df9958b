//! Frozen parameters on a recording that they were not fitted to.
//!
//! The initial state of each run comes from its first stretch by least squares on the free run. Two measures: free run (rms and
//! fit % = 100 (1 − |e| / |y − mean y|) per channel behind that stretch) and the gain in one-step log-likelihood, summed in blocks of 2 s
//! whose scatter gives its standard error. Confirmed: its 95 % interval is above zero; refused: below. A few blocks may hold most of a gain (the
//! swing that a free law governs), so the interval is Hall's for skewed means (J. R. Statist. Soc. B 54, 1992): with κ = skewness / √n
//!
//! ```text
//! g(t) = t + κ t²/3 + κ² t³/27 + κ/6 = ((1 + κ t/3)³ − 1)/κ + κ/6   is Student's where t is not
//! ```
//!
//! Refused is too what should have shown: the augmented plant itself expects a gain of `½ |δ|²`, `δ` the whitened difference between what both
//! predict. Of numbers known to `P`, by which its prediction moves as `J`, that is uncertain to `√(δᵀ J P Jᵀ δ)` (an amplitude known to one part
//! in d: to `2/d` of it): where the interval does not reach what three of these leave, and nothing is confirmed, the law does not hold there.
//!
//! What two or three blocks hold against the others' word is no skewness but chance: Hall's interval takes the place of Student's only where the
//! blocks agree with their sum: `Σ ±√|d| / √Σ|d|` (of variance one under random signs) of its sign and beyond the quantile.

use crate::filter::{Machine, NoiseModel, gains, initial_sigmas, whiten};
use crate::fit::Engine;
use crate::fit::engine::open;
use crate::problem::Timeline;
use crate::statistics::student_two_sided;
use dynamics::description::Plant;
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;

/// Share of a run that gives its initial state, and its most instants.
const FIRST_SHARE: f64 = 0.15;
const FIRST_EVENTS_MAX: usize = 2000;
/// Length of a block [s]; at least this many blocks are made, at most so many seconds apart.
pub const BLOCK_S: f64 = 2.0;

/// One channel of a free run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChannelFit {
    pub name: String,
    pub rms: f64,
    pub fit_percent: f64,
}

/// A plant with all its numbers, as a predictor.
#[derive(Clone, Copy)]
pub struct Predictor<'a> {
    pub plant: &'a Plant,
    pub theta: &'a [f64],
    pub noise: &'a NoiseModel,
}

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
    /// What the augmented plant itself expects to gain; zero where it was not asked.
    pub foretold: f64,
    /// What it gains at least, if it is right; zero where that was not asked.
    pub least: f64,
    /// Its free run's distance from the data over that of the plant alone: geometric mean of the rms over channels; one where it was not asked,
    /// infinite where it ran away.
    pub free_run: f64,
}

/// What goes this many times as far astray in free run is worth a word beside what single steps say.
const ASTRAY: f64 = 1.5;
/// Standard errors of what is foretold that it may be off by.
const FORETOLD_OFF: f64 = 3.0;

impl Gain {
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

    /// Even its upper bound is below what was foretold.
    pub fn is_short(&self) -> bool {
        self.interval95()[1] < self.foretold
    }

    /// With a standard deviation of what was foretold.
    #[must_use]
    pub fn foretold_to(self, sigma: f64) -> Self {
        Self { least: (self.foretold - FORETOLD_OFF * sigma).max(0.0), ..self }
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
    pub fn is_astray(&self) -> bool {
        self.free_run > ASTRAY
    }

    pub fn status(&self) -> Status {
        match self.interval95() {
            [low, _] if low > 0.0 => Status::Confirmed,
            [_, high] if high < self.least => Status::Refused,
            _ => Status::Unconfirmed,
        }
    }
}

/// Standing of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Confirmed,
    Unconfirmed,
    Refused,
    NotConverged,
}

/// Log-likelihood of `after` above that of `before` on all runs of `engine`, in blocks.
pub fn gain(engine: &Engine<'_>, before: Predictor<'_>, after: (&Engine<'_>, Predictor<'_>)) -> Option<Gain> {
    let (a, white_before) = terms(engine, before)?;
    let (b, white_after) = terms(after.0, after.1)?;
    let apart = white_before.iter().zip(&white_after).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    let gain = blocks(&a.iter().zip(&b).map(|((t, a), (_, b))| (*t, b - a)).collect::<Vec<_>>(), block_s(engine));
    Some(Gain { foretold: 0.5 * apart, ..gain })
}

/// Standard deviation of what the augmented plant foretells, `moved` being that plant with its numbers off by each column of a root of their
/// covariance: exact where predictions are linear in them. A recording's own numbers stay as they were fitted, so that it is rather too large.
///
/// Cost: a prediction for each.
pub fn foretold_sigma(
    (engine, before): (&Engine<'_>, Predictor<'_>),
    (augmented, after): (&Engine<'_>, Predictor<'_>),
    moved: &[Plant],
) -> Option<f64> {
    let white = |engine: &Engine<'_>, predictor: Predictor<'_>| Some(terms(engine, predictor)?.1);
    let (before, own) = (white(engine, before)?, white(augmented, after)?);
    let mut variance = 0.0;
    for plant in moved {
        let off = white(augmented, Predictor { plant, ..after })?;
        let along = before.iter().zip(&own).zip(&off).map(|((before, own), off)| (before - own) * (own - off));
        variance += along.sum::<f64>().powi(2);
    }
    Some(variance.sqrt())
}

/// Log-likelihood of all runs under the predictor's own noise.
pub fn loglik(engine: &Engine<'_>, predictor: Predictor<'_>) -> Option<f64> {
    Some(terms(engine, predictor)?.0.iter().map(|(_, term)| term).sum())
}

/// Length of a block [s]: two seconds, a few samples at least, a thirtieth of the recorded time at most.
pub fn block_s(engine: &Engine<'_>) -> f64 {
    BLOCK_S.max(4.0 * engine.timelines[0].period_s).min((engine.problem.duration_s() / 30.0).max(1e-9))
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
        foretold: 0.0,
        least: 0.0,
        free_run: 1.0,
    }
}

/// Time over all runs and log-likelihood of every instant.
type Terms = Vec<(f64, f64)>;

/// Log-likelihood of every instant, and the whitened innovations.
fn terms(engine: &Engine<'_>, predictor: Predictor<'_>) -> Option<(Terms, Vec<f64>)> {
    let (mut list, mut white) = (Vec::new(), Vec::new());
    let mut origin = 0.0;
    let linears = engine.linearise(predictor.plant, predictor.theta, predictor.noise).ok()?;
    for (linear, timeline) in linears.iter().zip(engine.timelines.iter()) {
        let found = gains(linear, timeline, predictor.noise)?;
        let mut r = linear.nu.clone();
        whiten(linear, timeline, &found, &mut [&mut r]);
        let first = timeline.events.first().map_or(0.0, |event| event.t_s);
        let mut last = first;
        for (k, event) in timeline.events.iter().enumerate().filter(|(_, event)| event.count > 0) {
            let samples = &r[event.first..event.first + event.count];
            let factor = &found.factor[found.factor_first[k]..];
            let scale: f64 = (0..event.count).map(|i| libm::log(factor[i * event.count + i])).sum();
            list.push((origin + event.t_s - first, -0.5 * samples.iter().map(|r| r * r).sum::<f64>() - scale));
            last = event.t_s;
        }
        origin += last - first + 10.0 * BLOCK_S;
        white.append(&mut r);
    }
    Some((list, white))
}

/// Free run of every channel over all runs, initial states from the first stretches.
pub fn free_run(engine: &Engine<'_>, predictor: Predictor<'_>) -> Vec<ChannelFit> {
    let channels = engine.problem.plant.sensors.len();
    let mut sums = vec![[0.0f64; 4]; channels];
    for run in 0..engine.timelines.len() {
        let timeline = &engine.timelines[run];
        let Some((residual, first)) = free_residual(engine, predictor, run) else {
            for sum in &mut sums {
                sum[0] = f64::NAN;
            }
            continue;
        };
        for event in timeline.events.iter().skip(first) {
            for sample in event.first..event.first + event.count {
                let sum = &mut sums[timeline.channel[sample]];
                let y = timeline.value[sample];
                sum[0] += residual[sample] * residual[sample];
                sum[1] += 1.0;
                sum[2] += y;
                sum[3] += y * y;
            }
        }
    }
    let sensors = &engine.problem.plant.sensors;
    (sensors.iter().zip(&sums))
        .filter(|(_, sum)| sum[1] > 0.0)
        .map(|(sensor, sum)| {
            let spread = (sum[3] - sum[2] * sum[2] / sum[1]).max(0.0);
            let fit = if spread > 0.0 { 100.0 * (1.0 - (sum[0] / spread).sqrt()) } else { f64::NEG_INFINITY };
            ChannelFit { name: sensor.name.clone(), rms: (sum[0] / sum[1]).sqrt(), fit_percent: fit }
        })
        .collect()
}

/// Residuals of the free run and the first event behind the stretch that gave the initial state.
pub fn free_residual(engine: &Engine<'_>, predictor: Predictor<'_>, run: usize) -> Option<(Vec<f64>, usize)> {
    let timeline = &engine.timelines[run];
    let instance = engine.problem.instance(predictor.plant, predictor.theta, run);
    let events = timeline.events.len();
    let first = ((events as f64 * FIRST_SHARE) as usize).clamp(events.min(8), FIRST_EVENTS_MAX.max(8)).min(events);
    let stretch = head(timeline, first);
    let mut machine = Machine::new(engine.problem, run, &instance, &stretch).ok()?;
    let sigmas = initial_sigmas(&instance, &machine.system, &engine.problem.runs[run].initial, &[]);
    let x0 = initial(&mut machine, &sigmas, predictor.noise)?;
    let mut machine = Machine::new(engine.problem, run, &instance, timeline).ok()?;
    machine.x0 = x0;
    let mut nu = vec![0.0; timeline.value.len()];
    machine.pass(&open(&machine), &[], &mut nu).then_some((nu, first))
}

fn head(timeline: &Timeline, events: usize) -> Timeline {
    let mut head = timeline.clone();
    head.events.truncate(events);
    let samples = head.events.last().map_or(0, |event| event.first + event.count);
    head.channel.truncate(samples);
    head.value.truncate(samples);
    head.stamp_s.truncate(samples);
    head.interval_s.truncate(samples);
    head
}

/// Initial state by Levenberg–Marquardt on the free run of a stretch, from the filter's first estimates.
fn initial(machine: &mut Machine<'_>, sigmas: &[f64], noise: &NoiseModel) -> Option<Vec<f64>> {
    let n = sigmas.len();
    let prior = machine.x0.clone();
    let frozen = open(machine);
    let weight: Vec<f64> = machine.timeline.channel.iter().map(|c| 1.0 / noise.sensor_sigma[*c]).collect();
    let residual = |machine: &mut Machine<'_>, x0: &[f64]| -> Option<Vec<f64>> {
        machine.x0.copy_from_slice(x0);
        let mut nu = vec![0.0; machine.timeline.value.len()];
        let ok = machine.pass(&frozen, &[], &mut nu);
        nu.iter_mut().zip(&weight).for_each(|(nu, w)| *nu *= w);
        (ok && nu.iter().all(|v| v.is_finite())).then_some(nu)
    };
    let mut x = prior.clone();
    let mut r = residual(machine, &x)?;
    let mut away = vec![0.0; n];
    let cost = |r: &[f64], away: &[f64]| {
        r.iter().map(|v| v * v).sum::<f64>() + away.iter().zip(sigmas).map(|(a, s)| (a / s).powi(2)).sum::<f64>()
    };
    let mut damping = 1e-3;
    for _ in 0..25 {
        let mut columns = Vec::with_capacity(n);
        for i in 0..n {
            let step = 1e-4 * sigmas[i].min(1.0);
            let mut delta = vec![0.0; n];
            delta[i] = step;
            let mut moved = x.clone();
            machine.system.retract(&x, &delta, &mut moved);
            let shifted = residual(machine, &moved)?;
            columns.push(shifted.iter().zip(&r).map(|(a, b)| (b - a) / step * sigmas[i]).collect::<Vec<f64>>());
        }
        let before = cost(&r, &away);
        let mut gained = 0.0;
        for _ in 0..6 {
            let matrix = DMatrix::from_fn(n, n, |i, j| {
                let product = crate::fit::board::dot(&columns[i], &columns[j]) + f64::from(u8::from(i == j));
                if i == j { product * (1.0 + damping) } else { product }
            });
            let right = DVector::from_fn(n, |i, _| crate::fit::board::dot(&columns[i], &r) - away[i] / sigmas[i]);
            let step = Cholesky::new(matrix)?.solve(&right);
            let delta: Vec<f64> = step.iter().zip(sigmas).map(|(s, sigma)| s * sigma).collect();
            let mut moved = x.clone();
            machine.system.retract(&x, &delta, &mut moved);
            let mut moved_away = vec![0.0; n];
            machine.system.difference(&prior, &moved, &mut moved_away);
            if let Some(fresh) = residual(machine, &moved) {
                let after = cost(&fresh, &moved_away);
                if after < before {
                    gained = before - after;
                    (x, r, away) = (moved, fresh, moved_away);
                    damping = (damping * 0.1).max(1e-9);
                    break;
                }
            }
            damping *= 10.0;
        }
        if gained < 1e-6 * before + 1e-6 {
            break;
        }
    }
    Some(x)
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
        assert_eq!(gain(&sums).status(), Status::Refused);
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
        // confirmed, unconfirmed, refused; 100 ± 10 on each side, fewer for the neighbours that may count as correlated, and where most blocks
        // are against the few that hold the sum
        assert!((1..=130).contains(&hall[0]) && (50..=130).contains(&hall[2]), "{hall:?}");
        assert!(student[0] < 30 && student[2] > 200, "{student:?}");
    }

    /// At the level that a suspicion asks, too. What is frozen foretells `δ` where there is nothing: it gains `δ r − δ²/2`.
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
        // all blocks alike, and few that hold most of it; 20 ± 4.5 were the mean nothing, fewer for neighbours that count as correlated
        assert!((4..=33).contains(&confirmed[0]) && confirmed.iter().all(|count| *count <= 33), "{confirmed:?}");
    }
}
