//! Segments of a recording: where its level or its liveliness changes, over all channels at once.
//!
//! Blocks longer than the slow quarter of each channel's changes give two features: the log of the
//! rms of its differences and its mean. A piecewise-linear model (a free decay is one segment, not
//! a staircase) with its number of pieces decided by a penalised likelihood: a break must gain more
//! than the χ² quantile at the false-alarm level over all places. Breaks that change neither the
//! liveliness by a factor of two nor the level by five deviations are taken back.

use serde::Serialize;

use super::{Check, FALSE_ALARM, Finding, Severity, short, usable};
use crate::spectrum::{Averaging, density};
use channels::{Channel, Recording, Uniform};
use estimation::quantiles::{median, quantile};
use identification::statistics::{chi_squared_quantile, deviation, differences, mean, rms};

const BLOCKS_MAX: usize = 160;
const BLOCKS_MIN: usize = 16;
const BLOCK_SAMPLES_MIN: usize = 16;
/// Fewest blocks in a segment.
const SEGMENT_MIN: usize = 3;

/// What a segment looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Every channel within a factor two of its quietest.
    Quiet,
    /// Short, and livelier than both neighbours: contact, impact, handling.
    Burst,
    Motion,
}

/// A stretch of one character.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Segment {
    pub start_s: f64,
    pub end_s: f64,
    pub kind: Kind,
    /// What changes most at its start: channel and `level` or `liveliness`; empty for the first.
    pub because: String,
}

pub(super) fn examine(recording: &Recording) -> Option<Finding> {
    let segments = propose(recording);
    if segments.len() < 2 {
        return None;
    }
    let list: Vec<String> = segments
        .iter()
        .map(|s| {
            let kind = match s.kind {
                Kind::Quiet => "quiet",
                Kind::Burst => "burst",
                Kind::Motion => "motion",
            };
            let because = if s.because.is_empty() { String::new() } else { format!(" ({})", s.because) };
            format!("{}-{} s {kind}{because}", short(s.start_s), short(s.end_s))
        })
        .collect();
    let names: Vec<&str> = recording.channels.iter().skip(1).map(|c| c.name.as_str()).collect();
    Some(
        Finding::new(Check::Segments, Severity::Note, &recording.channels[0].name, segments.len() as f64, "segments")
            .with(&names)
            .because(list.join("; "))
            .cure("give each its own initial state; take the noise from the quiet, the model from the motion, leave the bursts out"),
    )
}

struct Feature {
    /// Channel and which feature, for the report.
    what: String,
    lively: bool,
    value: Vec<f64>,
    sigma: f64,
    /// Smallest jump worth a break, anywhere ...
    material: f64,
    /// ... and next to each block.
    beside: Vec<f64>,
}

/// Segments in time order, covering the common time of the channels; one when nothing changes or
/// blocks are too few to say.
#[must_use]
pub fn propose(recording: &Recording) -> Vec<Segment> {
    let channels = usable(recording, BLOCKS_MIN * BLOCK_SAMPLES_MIN);
    let start = channels.iter().filter_map(|c| c.time_s.first()).fold(f64::NEG_INFINITY, |m, t| m.max(*t));
    let end = channels.iter().filter_map(|c| c.time_s.last()).fold(f64::INFINITY, |m, t| m.min(*t));
    if channels.is_empty() || end <= start {
        return Vec::new();
    }
    let whole = vec![Segment { start_s: start, end_s: end, kind: Kind::Motion, because: String::new() }];
    let longest = (end - start) / BLOCKS_MIN as f64;
    let chosen: Vec<(&Channel, f64, bool)> =
        channels.iter().filter_map(|c| block_duration(c, longest).map(|(d, slow)| (*c, d, slow))).collect();
    let duration = chosen.iter().map(|(_, d, _)| *d).fold((end - start) / BLOCKS_MAX as f64, f64::max);
    let count = libm::floor((end - start) / duration) as usize;
    let features: Vec<Feature> =
        chosen.iter().filter_map(|(c, _, slow)| features(c, start, duration, count, *slow)).flatten().collect();
    if count < BLOCKS_MIN || features.is_empty() {
        return whole;
    }
    let breaks = settle(&features, partition(&features, count), count);
    let edges: Vec<usize> = core::iter::once(0).chain(breaks).chain(core::iter::once(count)).collect();
    let mut out: Vec<Segment> = Vec::new();
    for (k, w) in edges.windows(2).enumerate() {
        let at = |block: usize| if block == count { end } else { start + block as f64 * duration };
        let because = if k == 0 { String::new() } else { reason(&features, edges[k - 1], w[0], w[1]) };
        out.push(Segment { start_s: at(w[0]), end_s: at(w[1]), kind: kind(&features, &edges, k), because });
    }
    out
}

/// One and a half periods of the slow quarter of a channel's changes [s], and whether these are too
/// slow for blocks up to `longest`: then only its level is looked at. `None` for an oscillation
/// with too few periods: its level is no segment.
fn block_duration(channel: &Channel, longest: f64) -> Option<(f64, bool)> {
    let u = channel.uniform()?;
    let change = differences(&u.value, 1);
    if rms(&change) == 0.0 {
        return None;
    }
    let s = density(&change, u.dt_s, Averaging::for_length(change.len()));
    if let Some(period) = strongest_period(&u) {
        let duration = (1.5 * period).max(BLOCK_SAMPLES_MIN as f64 * u.dt_s);
        return (duration <= longest).then_some((duration, false));
    }
    let total: f64 = s.density.iter().sum();
    let mut sum = 0.0;
    let slow = (0..s.density.len()).find(|&k| {
        sum += s.density[k];
        sum >= 0.25 * total
    })?;
    let (duration, least) = (1.5 / s.frequency_hz[slow.max(1)], BLOCK_SAMPLES_MIN as f64 * u.dt_s);
    let slow = duration.max(least) > longest;
    Some((if slow { least } else { duration.max(least) }, slow)).filter(|(d, _)| *d <= longest)
}

/// Samples whose spectrum is taken in one piece.
const SPECTRUM_SAMPLES_MAX: usize = 1 << 17;

/// Period of an oscillation that holds a third of the power of the channel or of its changes, at
/// least 2.5 of them in the record [s].
///
/// Of a long record fast ones show in the samples of its middle, slow ones in means of neighbours.
fn strongest_period(u: &Uniform) -> Option<f64> {
    let n = u.value.len();
    if n <= SPECTRUM_SAMPLES_MAX {
        return period_of(&u.value, u.dt_s);
    }
    let middle = (n - SPECTRUM_SAMPLES_MAX) / 2;
    let fast = period_of(&u.value[middle..middle + SPECTRUM_SAMPLES_MAX], u.dt_s);
    let size = n.div_ceil(SPECTRUM_SAMPLES_MAX);
    let means: Vec<f64> = u.value.chunks_exact(size).map(mean).collect();
    let slow = period_of(&means, u.dt_s * size as f64);
    [fast, slow].into_iter().flatten().reduce(f64::max)
}

fn period_of(value: &[f64], dt_s: f64) -> Option<f64> {
    let period = |x: &[f64]| {
        let s = density(x, dt_s, Averaging::Multitaper { tapers: 2 });
        let peak = (1..s.density.len()).max_by(|&i, &j| s.density[i].total_cmp(&s.density[j]))?;
        let near: f64 = s.density[peak.saturating_sub(3)..(peak + 4).min(s.density.len())].iter().sum();
        (peak >= 3 && near > s.density.iter().sum::<f64>() / 3.0).then(|| 1.0 / s.frequency_hz[peak])
    };
    [period(value), period(&differences(value, 1))].into_iter().flatten().reduce(f64::max)
}

/// Liveliness and level of a channel by blocks.
fn features(channel: &Channel, start: f64, duration: f64, count: usize, slow: bool) -> Option<Vec<Feature>> {
    let (mut lively, mut level, mut within) = (Vec::new(), Vec::new(), Vec::new());
    let floor =
        crate::lattice::lattice(&channel.value).map_or(1e-9 * deviation(&channel.value), |l| l.step / 12.0_f64.sqrt());
    for b in 0..count {
        let from = channel.time_s.partition_point(|t| *t < start + b as f64 * duration);
        let to = channel.time_s.partition_point(|t| *t < start + (b + 1) as f64 * duration);
        if to < from + BLOCK_SAMPLES_MIN / 2 {
            return None;
        }
        let block = &channel.value[from..to];
        lively.push(libm::log((rms(&differences(block, 1)).powi(2) + floor * floor).sqrt().max(1e-300)));
        level.push(mean(block));
        within.push(deviation(block));
    }
    let samples = channel.value.len() as f64 / count as f64;
    // ln of an rms over m correlated differences scatters by about sqrt(3/(4 m)); 5 % is no break.
    let lively_sigma = scatter(&lively).max((0.75 / samples).sqrt()).max(0.05);
    let spread = median(&mut within.clone()).max(floor);
    let level_sigma = scatter(&level).max(0.25 * spread);
    // A slow channel drifts within any block; only a good part of its range is a step.
    let range = quantile(&mut level.clone(), 0.95) - quantile(&mut level.clone(), 0.05);
    let material = if slow { (5.0 * spread).max(0.3 * range) } else { 5.0 * spread };
    // What the level does everywhere (a random walk) is no break.
    let mut moves: Vec<f64> = (4..count.saturating_sub(4)).map(|k| jump(&level, 0, k, count)).collect();
    let wandering = 1.4826 * median(&mut moves);
    let lively = Feature {
        what: format!("{} liveliness", channel.name),
        lively: true,
        value: lively,
        sigma: lively_sigma,
        material: core::f64::consts::LN_2,
        beside: vec![0.0; count],
    };
    let level = Feature {
        what: format!("{} level", channel.name),
        lively: false,
        value: level,
        sigma: level_sigma,
        material: material.max(5.0 * wandering),
        beside: within.iter().map(|w| 5.0 * w).collect(),
    };
    Some(if slow { vec![level] } else { vec![lively, level] })
}

/// Deviation of a block series about its smooth course: from second differences, robust.
fn scatter(x: &[f64]) -> f64 {
    let mut second: Vec<f64> = x.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    1.4826 * median(&mut second) / 6.0_f64.sqrt()
}

/// Breaks that minimise residual sum + penalty (optimal partitioning, exact).
fn partition(features: &[Feature], count: usize) -> Vec<usize> {
    let places = count as f64;
    let penalty =
        chi_squared_quantile(1.0 - FALSE_ALARM / places, 2.0 * features.len() as f64 + 1.0) + 2.0 * libm::log(places);
    let sums: Vec<Prefix> = features.iter().map(Prefix::new).collect();
    let mut cost = vec![f64::INFINITY; count + 1];
    let mut from = vec![0; count + 1];
    cost[0] = -penalty;
    for end in SEGMENT_MIN..=count {
        for begin in 0..=end - SEGMENT_MIN {
            if cost[begin].is_finite() {
                let total = cost[begin] + penalty + sums.iter().map(|s| s.residual(begin, end)).sum::<f64>();
                if total < cost[end] {
                    (cost[end], from[end]) = (total, begin);
                }
            }
        }
    }
    let (mut breaks, mut at) = (Vec::new(), count);
    while from[at] > 0 {
        at = from[at];
        breaks.push(at);
    }
    breaks.reverse();
    breaks
}

/// Running sums that give the residual of a straight line over any blocks.
struct Prefix {
    y: Vec<f64>,
    ky: Vec<f64>,
    yy: Vec<f64>,
}

impl Prefix {
    fn new(feature: &Feature) -> Self {
        let m = mean(&feature.value);
        let run = |f: &dyn Fn(usize, f64) -> f64| {
            let mut sum = 0.0;
            let mut out = vec![0.0];
            for (k, v) in feature.value.iter().enumerate() {
                sum += f(k, (v - m) / feature.sigma);
                out.push(sum);
            }
            out
        };
        Prefix { y: run(&|_, v| v), ky: run(&|k, v| k as f64 * v), yy: run(&|_, v| v * v) }
    }

    fn residual(&self, begin: usize, end: usize) -> f64 {
        let n = (end - begin) as f64;
        let centre = begin as f64 + 0.5 * (n - 1.0);
        let y = self.y[end] - self.y[begin];
        let ky = self.ky[end] - self.ky[begin] - centre * y;
        let lever = n * (n * n - 1.0) / 12.0;
        (self.yy[end] - self.yy[begin] - y * y / n - ky * ky / lever).max(0.0)
    }
}

/// Takes back the breaks that change nothing by a material size, the smallest first.
fn settle(features: &[Feature], mut breaks: Vec<usize>, count: usize) -> Vec<usize> {
    loop {
        let edges: Vec<usize> =
            core::iter::once(0).chain(breaks.iter().copied()).chain(core::iter::once(count)).collect();
        let change =
            |k: usize| features.iter().map(|f| size(f, edges[k], edges[k + 1], edges[k + 2])).fold(0.0, f64::max);
        let least = (0..breaks.len()).min_by(|&i, &j| change(i).total_cmp(&change(j)));
        match least {
            Some(k) if change(k) < 1.0 => breaks.remove(k),
            _ => return breaks,
        };
    }
}

/// Jump at `at` in material sizes.
fn size(f: &Feature, begin: usize, at: usize, end: usize) -> f64 {
    let near = |side: &[f64]| median(&mut side.to_vec());
    let beside = near(&f.beside[at.saturating_sub(4).max(begin)..at]).max(near(&f.beside[at..(at + 4).min(end)]));
    jump(&f.value, begin, at, end) / f.material.max(beside)
}

/// Jump at `at` between straight lines through both sides; where one side is short, between their
/// means near the break.
fn jump(x: &[f64], begin: usize, at: usize, end: usize) -> f64 {
    let left = &x[at.saturating_sub(4).max(begin)..at];
    let right = &x[at..(at + 4).min(end)];
    (median(&mut right.to_vec()) - median(&mut left.to_vec())).abs()
}

fn reason(features: &[Feature], begin: usize, at: usize, end: usize) -> String {
    let by = |f: &Feature| size(f, begin, at, end);
    features.iter().max_by(|f, g| by(f).total_cmp(&by(g))).map_or_else(String::new, |f| f.what.clone())
}

fn kind(features: &[Feature], edges: &[usize], k: usize) -> Kind {
    let lively = |f: &Feature, k: usize| median(&mut f.value[edges[k]..edges[k + 1]].to_vec());
    let quietest = |f: &Feature| (0..edges.len() - 1).map(|j| lively(f, j)).fold(f64::INFINITY, f64::min);
    let activity = || features.iter().filter(|f| f.lively);
    if activity().all(|f| lively(f, k) < quietest(f) + core::f64::consts::LN_2) && edges.len() > 2 {
        return Kind::Quiet;
    }
    let length = (edges[k + 1] - edges[k]) as f64 / *edges.last().expect("has ends") as f64;
    let above =
        |j: usize| activity().map(|f| lively(f, k) - lively(f, j)).fold(0.0, f64::max) > core::f64::consts::LN_2;
    let livelier = (k == 0 || above(k - 1)) && (k + 2 >= edges.len() || above(k + 1));
    if length < 0.1 && livelier { Kind::Burst } else { Kind::Motion }
}
