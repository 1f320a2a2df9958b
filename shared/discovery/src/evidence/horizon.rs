//! Does it matter: distances from the data over a horizon, on data that no fit has seen.
//!
//! A free run is comparable only as long as disturbances have not driven the plant away. Windows of
//! several lengths are run, since over long ones what counts is how well parameters are known, too;
//! an effect matters if it does at some length. Of each channel of each recording, e being the
//! distance and v what the better plant's noise gives it (no disturbance above its stated size, the
//! readings' as fitted beside these) with what its parameters give it, as well as they are known,
//!
//! ```text
//! share = 1 − Σ (e_after² − v) / Σ (e_before² − v)        of the misfit that noise cannot explain
//! ```
//!
//! A distance is a running sum of disturbances and no white noise: of n samples with correlations
//! ρ(τ) the mean of e²/v has the width of that of `n / Σ_τ (1 − |τ|/n) ρ(τ)²` independent ones.

use super::decide::{MAIN_SHARE, RELEVANT_SHARE, SEEN_SHARE, WORSE};
use identification::filter::{Linear, NoiseModel, ahead};
use identification::fit::EstimationSession;
use identification::held_out::{Gain, block_s, blocks};
use identification::problem::Timeline;
use identification::statistics::chi_squared_quantile;

/// Windows of a run: the whole, and shorter ones by this factor, so many lengths. Budgets.
const WINDOW_RATIO: usize = 4;
const LENGTHS_MAX: usize = 5;
const EVENTS_MIN: usize = 4;
/// Share of a run behind which windows begin: its initial state is known by then.
const BEGIN_SHARE: usize = 20;
/// Fewest blocks of time that an error is taken from.
const BLOCKS_MIN: f64 = 16.0;

/// Where a sample belongs.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Place of its channel and recording among all.
    site: usize,
    /// Over all runs.
    t_s: f64,
}

/// Distances of one model from data, over windows of each length.
#[derive(Clone)]
pub(super) struct Horizons {
    samples: Vec<Sample>,
    /// Names of recording and channel.
    sites: Vec<String>,
    /// Standard deviation of the readings of each site, and variance of their own noise where that
    /// is white.
    spread: Vec<f64>,
    white: Vec<f64>,
    lengths: Vec<Length>,
    block_s: f64,
    duration_s: f64,
}

#[derive(Clone)]
struct Length {
    /// In events, and \[s\].
    window: usize,
    window_s: f64,
    residual: Vec<f64>,
    variance: Vec<f64>,
}

/// Two models over the horizon at which the better one explains most.
pub(super) struct Compared {
    pub window_s: f64,
    pub sites: Vec<Site>,
    /// What the squares fall by, and what they were, in units of the noise.
    whole: Gain,
    before: f64,
}

/// One channel of one recording; root mean squares.
pub(super) struct Site {
    pub name: String,
    pub before: f64,
    pub after: f64,
    pub noise: f64,
    /// What noise cannot explain before, over the standard deviation of the readings.
    pub of_signal: f64,
    /// Of the misfit that noise cannot explain; `None` where noise explains all of it.
    pub share: Option<f64>,
    pub is_worse: bool,
}

impl Horizons {
    /// Of a model under its `noise`; what `explaining` noise gives a distance is no misfit. `None`
    /// where a covariance is not positive.
    pub(super) fn new(
        session: &EstimationSession<'_>,
        linears: &[Linear],
        noise: &NoiseModel,
        explaining: &NoiseModel,
    ) -> Option<Self> {
        let channels = session.problem.plant.sensors.len();
        let name = |site: usize| {
            let (recording, sensor) = (site / channels, &session.problem.plant.sensors[site % channels]);
            format!("{} of {}", sensor.name, session.problem.recordings[recording])
        };
        let (mut samples, mut values, mut origin) = (Vec::new(), Vec::new(), 0.0);
        for (run, timeline) in session.timelines.iter().enumerate() {
            let recording = session.problem.runs[run].recording;
            let first = timeline.events.first().map_or(0.0, |event| event.t_s);
            for event in &timeline.events {
                for sample in event.first..event.first + event.count {
                    let site = recording * channels + timeline.channel[sample];
                    samples.push(Sample { site, t_s: origin + event.t_s - first });
                    values.push(timeline.value[sample]);
                }
            }
            origin += timeline.events.last().map_or(0.0, |event| event.t_s - first);
        }
        let most = session.timelines.iter().map(|timeline| timeline.events.len()).max().unwrap_or(0);
        let (mut lengths, mut window) = (Vec::new(), most.max(EVENTS_MIN));
        while lengths.len() < LENGTHS_MAX && window >= EVENTS_MIN {
            let mut length = Length {
                window,
                window_s: window as f64 / most.max(1) as f64 * origin / session.timelines.len().max(1) as f64,
                residual: Vec::new(),
                variance: Vec::new(),
            };
            for (linear, timeline) in linears.iter().zip(session.timelines.iter()) {
                let own = (linear, &linear.nu[..]);
                let run = |noise: &NoiseModel| ahead(own, timeline, noise, window, begin_of(timeline));
                length.residual.extend(run(noise)?.residual);
                length.variance.extend(run(explaining)?.variance);
            }
            lengths.push(length);
            window /= WINDOW_RATIO;
        }
        let sites = session.problem.recordings.len() * channels;
        let spread = (0..sites).map(|site| spread(&samples, &values, site)).collect();
        let (block_s, duration_s) = (block_s(session), origin);
        let white = (0..sites).map(|site| site % channels);
        let white = white.map(|k| if explaining.pole[k] == 0.0 { explaining.sensor_sigma[k].powi(2) } else { 0.0 });
        let (sites, white) = ((0..sites).map(name).collect(), white.collect());
        Some(Self { samples, sites, spread, white, lengths, block_s, duration_s })
    }

    /// With the variance that the parameters' posterior gives: `columns` J L are changes of
    /// all innovations, L Lᵀ its covariance.
    pub(super) fn with_parameters(
        mut self,
        session: &EstimationSession<'_>,
        linears: &[Linear],
        noise: &NoiseModel,
        columns: &[Vec<f64>],
    ) -> Option<Self> {
        for length in &mut self.lengths {
            for column in columns {
                let mut place = 0;
                for (linear, timeline) in linears.iter().zip(session.timelines.iter()) {
                    let nu = &column[place..place + linear.nu.len()];
                    let change = ahead((linear, nu), timeline, noise, length.window, begin_of(timeline))?.residual;
                    length.variance[place..].iter_mut().zip(&change).for_each(|(v, change)| *v += change * change);
                    place += change.len();
                }
            }
        }
        Some(self)
    }

    /// This model beside `before`, the plant that it is to be better than, over the windows at
    /// which it explains most; a channel is worse where it is so over the longest, a plain free
    /// run.
    pub(super) fn beside(&self, before: &Self) -> Option<Compared> {
        let lengths = self.lengths.iter().zip(&before.lengths);
        let all: Vec<Compared> = lengths.map(|(after, before)| self.over(after, before)).collect();
        let worse: Vec<bool> = all.first()?.sites.iter().map(|site| site.is_worse).collect();
        let explained = |own: &Compared| own.relevance().unwrap_or(f64::NEG_INFINITY);
        let mut best = all.into_iter().max_by(|a, b| explained(a).total_cmp(&explained(b)))?;
        best.sites.iter_mut().zip(worse).for_each(|(site, worse)| site.is_worse = worse);
        Some(best)
    }

    fn over(&self, after: &Length, before: &Length) -> Compared {
        let block_s = self.block_of(after);
        let sums = Sums { own: self, after, before, block_s };
        let all: Vec<usize> = (0..self.sites.len()).filter(|site| sums.of(*site, &|_, _, v| v) > 0.0).collect();
        let level = 2.0 * WORSE / all.len().max(1) as f64;
        // every length looks at every channel: by chance each may be felt at any
        let by_chance = WORSE / (all.len() * self.lengths.len()).max(1) as f64;
        let site = |site: &usize| sums.site(*site, level, by_chance);
        let whole = blocks(&sums.series(None, &|before, after, v| (before - after) / v), block_s);
        let before = sums.series(None, &|before, _, v| before / v).iter().map(|(_, own)| own).sum();
        Compared { window_s: after.window_s, sites: all.iter().map(site).collect(), whole, before }
    }

    /// A window is one block, as long as there are enough of them \[s\].
    fn block_of(&self, length: &Length) -> f64 {
        self.block_s.max(length.window_s).min(self.duration_s / BLOCKS_MIN)
    }
}

/// Events behind which windows begin.
fn begin_of(timeline: &Timeline) -> usize {
    timeline.events.len() / BEGIN_SHARE
}

fn spread(samples: &[Sample], values: &[f64], site: usize) -> f64 {
    let own = || samples.iter().zip(values).filter(|(sample, _)| sample.site == site).map(|(_, value)| *value);
    let count = own().count().max(1) as f64;
    let mean = own().sum::<f64>() / count;
    (own().map(|y| (y - mean) * (y - mean)).sum::<f64>() / count).sqrt()
}

/// Sums over the samples of two models at one length: functions of both squares and the variance.
struct Sums<'a> {
    own: &'a Horizons,
    after: &'a Length,
    before: &'a Length,
    block_s: f64,
}

type Term<'t> = &'t dyn Fn(f64, f64, f64) -> f64;

impl Sums<'_> {
    fn series(&self, site: Option<usize>, term: Term<'_>) -> Vec<(f64, f64)> {
        let both = self.before.residual.iter().zip(&self.after.residual).zip(&self.after.variance);
        let own = self.own.samples.iter().zip(both);
        own.filter(|(sample, (_, v))| site.is_none_or(|site| site == sample.site) && v.is_finite())
            .map(|(sample, ((before, after), v))| (sample.t_s, term(before * before, after * after, *v)))
            .filter(|(_, term)| !term.is_nan())
            .collect()
    }

    /// Distances of one of the models, in standard deviations of the noise.
    fn whitened(&self, model: &Length, site: usize) -> Vec<f64> {
        let both = model.residual.iter().zip(&self.after.variance);
        let own = self.own.samples.iter().zip(both).filter(|(sample, (_, v))| sample.site == site && v.is_finite());
        own.map(|(_, (e, v))| e / v.sqrt()).filter(|r| !r.is_nan()).collect()
    }

    fn of(&self, site: usize, term: Term<'_>) -> f64 {
        self.series(Some(site), term).iter().map(|(_, own)| own).sum()
    }

    fn site(&self, site: usize, level: f64, by_chance: f64) -> Site {
        let count = self.of(site, &|_, _, _| 1.0).max(1.0);
        let mean = |term: Term<'_>| self.of(site, term) / count;
        let (before, after, noise) = (mean(&|b, _, _| b), mean(&|_, a, _| a), mean(&|_, _, v| v));
        let change = blocks(&self.series(Some(site), &|b, a, _| b - a), self.block_s);
        let driven = 1.0 - (self.own.white[site] / noise).min(1.0);
        let exceeds = |model: &Length, chance: f64| exceeds_noise(&self.whitened(model, site), driven, chance);
        let is_felt = before > noise && exceeds(self.before, by_chance);
        let loses = change.interval(level)[1] < 0.0 && after > (1.0 + RELEVANT_SHARE) * before;
        Site {
            name: self.own.sites[site].clone(),
            before: before.sqrt(),
            after: after.sqrt(),
            noise: noise.sqrt(),
            of_signal: (before - noise).max(0.0).sqrt() / self.own.spread[site].max(f64::MIN_POSITIVE),
            share: is_felt.then(|| 1.0 - (after - noise).max(0.0) / (before - noise)),
            // a model as near as its noise lets it be is not worse
            is_worse: loses && after > noise && exceeds(self.after, 0.5 * level),
        }
    }
}

/// The mean square of distances lies above what that of noise with their correlations reaches but
/// with a probability of `by_chance`: χ² of as many degrees of freedom as they have independent
/// values. `driven` is the share of the noise that is not white: it has no larger correlation.
fn exceeds_noise(whitened: &[f64], driven: f64, by_chance: f64) -> bool {
    let square = whitened.iter().map(|r| r * r).sum::<f64>();
    let freedom = independent(whitened, square, driven);
    !whitened.is_empty() && square / whitened.len() as f64 > chi_squared_quantile(1.0 - by_chance, freedom) / freedom
}

/// Independent values among these: `n / Σ (1 − |τ|/n) ρ(τ)²`, at least one. Products at a lag are
/// over all squares, and so smaller than ρ by 1 − |τ|/n again; their own error makes up for it.
fn independent(whitened: &[f64], square: f64, driven: f64) -> f64 {
    let n = whitened.len();
    let term = |lag: usize| {
        let rho = whitened.iter().zip(&whitened[lag..]).map(|(a, b)| a * b).sum::<f64>() / square;
        let rho = rho.abs().min(driven);
        (1.0 - lag as f64 / n as f64) * rho * rho
    };
    // lags in steps of an eighth: those of a vibration are met at changing phases
    let (mut lag, mut before, mut sum) = (1, 1.0, 0.0);
    let mut last = 0;
    while lag < n {
        let own = term(lag);
        sum += if lag == last + 1 { own } else { 0.5 * (before + own) * (lag - last) as f64 };
        (before, last) = (own, lag);
        lag += (lag / 8).max(1);
    }
    (n as f64 / (1.0 + 2.0 * sum)).max(1.0)
}

impl Compared {
    /// Over all channels it comes nearer to the data, or goes further away, by more than chance;
    /// the latter by what a reader sees.
    pub(super) fn is_better(&self) -> bool {
        self.whole.interval(2.0 * WORSE)[0] > 0.0
    }

    pub(super) fn is_worse(&self) -> bool {
        let is_far = self.sites.iter().any(|site| site.after > site.noise);
        is_far && self.whole.interval(2.0 * WORSE)[1] < 0.0 && -self.whole.loglik_gain > RELEVANT_SHARE * self.before
    }

    /// The largest share of a channel; `None` where noise explains all misfit of all.
    pub(super) fn relevance(&self) -> Option<f64> {
        self.sites.iter().filter_map(|site| site.share).reduce(f64::max)
    }

    /// Of some channel's misfit that noise cannot explain the model takes away a share that
    /// matters: of one that a reader of an overlay sees, what he sees; of a smaller one, most of
    /// it, since a law that leaves the greater part of a small remainder is one of many such. Below
    /// `worth` of the signal nothing matters. True where noise explains everything.
    pub(super) fn is_worth_adding(&self, worth: f64) -> bool {
        let felt = || self.sites.iter().filter_map(|site| Some((site.share?, site.of_signal)));
        let least = |of_signal: f64| if of_signal < SEEN_SHARE { MAIN_SHARE } else { RELEVANT_SHARE };
        let is_worth = |(share, of_signal): (f64, f64)| of_signal >= worth && share >= least(of_signal);
        felt().next().is_none() || felt().any(is_worth)
    }

    /// The largest part of a channel that the plant without hypotheses misses.
    pub(super) fn remains(&self) -> f64 {
        self.sites.iter().map(|site| site.of_signal).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests;
