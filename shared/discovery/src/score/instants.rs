//! Instants at which innovations jump: candidate onsets of sudden effects.
//!
//! A filter that trusts its sensors forgets a step within a few samples, and no grid of times meets
//! these. White noise has no sample of this size; of a persistent misfit the largest samples are no
//! jumps, because sizes are relative to the channel's own. A single wrong reading jumps, too: where
//! it explains the data better than a lasting step, nothing begins there.

use super::{Candidate, columns, scores};
use dynamics::description::{Plant, Site, SiteKind};
use dynamics::effect::{Effect, EffectParameter, Law, Role};
use estimation::quantiles::median;
use identification::filter::NoiseModel;
use identification::fit::{EstimationSession, LinearisedProblem};
use identification::problem::Timeline;
use identification::statistics::chi_squared_quantile;

/// Instants of each list.
pub const INSTANTS: usize = 4;
/// Family-wise level at which white noise would have a sample as large. Chosen, no derivation.
const JUMP_LEVEL: f64 = 1e-3;
/// Share of a channel's samples within which a jump must be alone, and their least number: behind
/// it the filter settles.
const JUMP_ISOLATION_SHARE: usize = 64;
const JUMP_ISOLATION_MIN: usize = 3;
/// Ratio of the jumps to the next largest sample; samples of a heavy tail do not reach it. Chosen,
/// no derivation.
const JUMP_RATIO_MIN: f64 = 1.5;
/// Median of |z| of a normal variable.
const MEDIAN: f64 = 0.674_489_750_196_081_7;

/// Instants of every channel and of all together \[s\], in order of time, and the number of samples
/// tested.
#[derive(Clone, Debug, Default)]
pub struct Instants {
    pub channels: Vec<Vec<f64>>,
    pub pooled: Vec<f64>,
    pub looked: usize,
}

/// Jumps of the innovations of the longest run under `noise`, each between its sample and the one
/// before; its columns are taken along the trajectory `along`.
///
/// Cost: two columns a jump.
pub fn instants(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    along: (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    noise: &NoiseModel,
) -> Instants {
    let mut found = Instants::default();
    let mut r = [linearised.nu.clone()];
    let longest = (0..session.timelines.len()).max_by_key(|run| session.timelines[*run].value.len());
    let Some((run, _)) = longest.zip(linearised.whiten(session, noise, &mut r)) else { return found };
    let timeline = &session.timelines[run];
    let mut pool: Vec<(f64, [f64; 2])> = Vec::new();
    for (channel, sensor) in plant.sensors.iter().enumerate() {
        let own: Vec<usize> = samples_of(timeline, channel);
        found.looked = found.looked.max(own.len());
        let jumps = jumps(&own.iter().map(|s| r[0][session.offsets[run] + s]).collect::<Vec<_>>());
        let edges = jumps.iter().map(|(_, k)| edge(timeline, &own, *k)).collect::<Vec<_>>();
        let stays = stay((session, linearised), along, plant, theta, noise, (&sensor.name, &edges));
        let all = jumps.iter().zip(&edges).zip(stays);
        let own: Vec<(f64, [f64; 2])> =
            all.filter(|(_, stays)| *stays).map(|((jump, edge), _)| (jump.0, *edge)).collect();
        found.channels.push(first(&own));
        pool.extend(own);
    }
    pool.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1[0].total_cmp(&b.1[0])));
    found.pooled = first(&pool);
    found
}

fn samples_of(timeline: &Timeline, channel: usize) -> Vec<usize> {
    (0..timeline.value.len()).filter(|s| timeline.channel[*s] == channel).collect()
}

/// Interval from the middle between a channel's sample `k` and the one before to the middle between
/// it and the next one, in the time of the laws [s]; that of the last sample ends at itself.
fn edge(timeline: &Timeline, own: &[usize], k: usize) -> [f64; 2] {
    let at = |k: usize| timeline.stamp_s[own[k]] - timeline.shift_s[timeline.channel[own[k]]];
    let until = if k + 1 < own.len() { 0.5 * (at(k) + at(k + 1)) } else { at(k) };
    [0.5 * (at(k - 1) + at(k)), until]
}

/// The step of a reading: the law of a sensor with an onset and a duration, and these two.
fn reading_step(plant: &Plant) -> Option<(&'static Effect, &'static EffectParameter, &'static EffectParameter)> {
    let of_a_sensor = plant.catalogue.entries().iter().filter(|effect| matches!(effect.law, Law::Sensor(_)));
    let times =
        |effect: &'static Effect| Some((effect, effect.with_role(Role::Onset)?, effect.with_role(Role::Duration)?));
    of_a_sensor.copied().find_map(times)
}

/// Which jumps of a sensor's innovations are rather a lasting step of its readings than one wrong
/// reading.
fn stay(
    (session, linearised): (&EstimationSession<'_>, &LinearisedProblem),
    along: (&EstimationSession<'_>, &LinearisedProblem),
    plant: &Plant,
    theta: &[f64],
    noise: &NoiseModel,
    (sensor, edges): (&str, &[[f64; 2]]),
) -> Vec<bool> {
    let Some((effect, onset, lasting)) = reading_step(plant).filter(|_| !edges.is_empty()) else {
        return vec![false; edges.len()];
    };
    let site = Site { kind: SiteKind::Sensor, name: sensor.to_owned() };
    let of = |begin: f64, duration: f64| Candidate {
        effect,
        site: site.clone(),
        inner: vec![(onset.name, begin), (lasting.name, duration)],
        directions: vec![Vec::new()],
        one_sided: false,
        high: effect.parameters[0].high,
        at: None,
        felt: None,
        tries: 1,
    };
    let both = |[begin, until]: &[f64; 2]| [of(*begin, lasting.default), of(*begin, until - begin)];
    let list: Vec<Candidate> = edges.iter().flat_map(both).collect();
    let found = columns(along, plant, theta, &list);
    let scored = scores(session, linearised, theta, noise, &found);
    let statistic = |begin: f64, lasts: bool| {
        let is_own = |inner: &[(&str, f64)]| inner[0].1 == begin && (inner[1].1 == lasting.default) == lasts;
        let own = found.iter().zip(&scored).find(|(column, _)| is_own(&column.candidate.inner));
        own.and_then(|(_, score)| score.as_ref()).map_or(0.0, |score| score.statistic)
    };
    edges.iter().map(|[begin, _]| statistic(*begin, true) > statistic(*begin, false)).collect()
}

/// The largest few in order of time, each once: channels of several rates show one instant within
/// an interval.
fn first(jumps: &[(f64, [f64; 2])]) -> Vec<f64> {
    let mut list: Vec<[f64; 2]> = Vec::new();
    for (_, own) in jumps {
        let is_known = |other: &[f64; 2]| (own[0] - other[0]).abs() <= (own[1] - own[0]).max(other[1] - other[0]);
        if list.len() < INSTANTS && !list.iter().any(is_known) {
            list.push(*own);
        }
    }
    let mut list: Vec<f64> = list.into_iter().map(|[begin, _]| begin).collect();
    list.sort_by(f64::total_cmp);
    list
}

/// Size and index of samples larger than any of white noise and than all their neighbours, largest
/// first.
fn jumps(r: &[f64]) -> Vec<(f64, usize)> {
    if r.len() < 2 * JUMP_ISOLATION_MIN {
        return Vec::new();
    }
    let scale = median(&mut r.iter().map(|r| r.abs()).collect::<Vec<f64>>()) / MEDIAN;
    // a channel of mostly equal values has no scale
    if scale <= 0.0 || !scale.is_finite() {
        return Vec::new();
    }
    let sizes: Vec<f64> = r.iter().map(|r| r.abs() / scale).collect();
    let least = chi_squared_quantile(1.0 - JUMP_LEVEL / r.len() as f64, 1.0).sqrt();
    let reach = (r.len() / JUMP_ISOLATION_SHARE).max(JUMP_ISOLATION_MIN);
    let about = |k: usize| &sizes[k.saturating_sub(reach)..(k + reach + 1).min(sizes.len())];
    let is_jump = |k: &usize| sizes[*k] > least && about(*k).iter().all(|other| *other <= sizes[*k]);
    let mut list: Vec<(f64, usize)> = (1..sizes.len()).filter(is_jump).map(|k| (sizes[k], k)).collect();
    list.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let below = |count: usize| list.get(count).map_or(least, |next| next.0);
    let apart = |count: &usize| list[count - 1].0 > JUMP_RATIO_MIN * below(*count);
    let count = (1..=list.len().min(INSTANTS)).rev().find(apart).unwrap_or(0);
    list.truncate(count);
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    #[test]
    fn a_step_that_the_filter_forgets_has_its_two_edges_and_noise_of_any_size_has_none() {
        for (seed, size) in [(1, 1.0), (2, 1e-3), (3, 50.0)] {
            let noise: Vec<f64> = Noise::new(seed).series(800, size);
            assert_eq!(jumps(&noise), []);
            let mut stepped = noise;
            for (edge, sign) in [(300, 1.0), (420, -1.0)] {
                (0..8).for_each(|k| stepped[edge + k] += sign * 40.0 * size * 0.5f64.powi(k as i32));
            }
            let mut edges: Vec<usize> = jumps(&stepped).iter().map(|(_, k)| *k).collect();
            edges.sort_unstable();
            assert_eq!(edges, [300, 420]);
        }
    }
}
