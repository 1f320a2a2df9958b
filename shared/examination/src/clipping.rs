//! Clipped values: a channel that stands at its extreme more often than its motion has it there.
//!
//! Of the distributions of a motion that turns back by itself the sine's is the steepest at its end:
//! of its samples `arccos(1 - h)/π` lie within h of the amplitude, so that the outermost level of a
//! converter holds at most `1/(√2 - 1)`, 2.41 times as many as the level beside it. A limit collects
//! all that lies beyond it in one level. A channel that rests at its extreme comes there slowly: a
//! limit is met at the speed of the motion. So a channel is clipped if its extreme level holds more
//! than 2.41 times the samples of the level beside it beyond chance, in many visits, which begin
//! with steps of the size of the others.

use crate::lattice::lattice;
use estimation::quantiles::median;
use identification::statistics::normal_two_sided;

/// Probability that the steepest motion of all is called clipped; others are far from it.
const CHANCE: f64 = 1e-4;
/// Samples in the outermost level of a quantised sine over those in the level beside it.
const SINE_RATIO: f64 = 2.414_213_562_373_095;
/// Visits to the extreme: fewer are peaks, or a start and an end at rest.
const VISITS_MIN: usize = 8;
/// Share of the samples at the extreme that one visit may hold.
const LONGEST_VISIT_SHARE: f64 = 0.5;
/// Share of all samples at one extreme beyond which the channel is taken to rest there, between
/// moves that are too fast to show how they end.
const REST_SHARE: f64 = 0.25;
/// Different values of a measurement; a switch has fewer.
const LEVELS_MIN: usize = 16;
/// First step of a visit over the median of the steps that move; of a sine clipped at 97 % of its
/// amplitude it is a quarter of its largest, a third of the median.
const ENTRY_SHARE_MIN: f64 = 0.3;

/// First step of a visit in steps of the converter: of one step it says nothing about the speed.
const ENTRY_STEPS_MIN: f64 = 2.0;

/// Where and how much a channel is clipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clipped {
    /// The limit, in the channel's unit; of two the one that is met more often.
    pub level: f64,
    /// Samples at it, or at both limits where both are met.
    pub samples: usize,
    /// `samples` over all.
    pub share: f64,
}

/// Whether values stand at a limit: see the module's law. `None` also for zero as the extreme (a
/// force, a distance end there by nature), for few levels, and for NaN-free samples below 64.
///
/// ```
/// let clipped = |k: usize| (0.37 * (k as f64)).sin().min(0.8);
/// let values: Vec<f64> = (0..2000).map(clipped).collect();
/// let found = examination::clipping::clipped(&values).unwrap();
/// assert_eq!(found.level, 0.8);
/// assert!((found.share - 0.205).abs() < 0.01); // arccos(0.8)/π
/// ```
#[must_use]
pub fn clipped(values: &[f64]) -> Option<Clipped> {
    let values: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    // cheap first: most channels meet their extremes once
    let visited = [high, low].map(|level| visits(&values, level, 0.0).len() >= VISITS_MIN && level != 0.0);
    if values.len() < 64 || !visited.contains(&true) {
        return None;
    }
    let step = lattice(&values).map_or(0.0, |lattice| lattice.step);
    let mut steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|s| *s > 0.25 * step).collect();
    let usual = median(&mut steps);
    let mut found: Vec<(f64, usize)> = Vec::new();
    for (level, inward) in [(high, -1.0), (low, 1.0)] {
        if level != 0.0
            && let Some(samples) = at_limit(&values, level, inward, step, usual)
        {
            found.push((level, samples));
        }
    }
    let (level, _) = found.iter().copied().max_by_key(|(_, samples)| *samples)?;
    let samples = found.iter().map(|(_, samples)| samples).sum();
    Some(Clipped { level, samples, share: samples as f64 / values.len() as f64 })
}

/// First and one-past-last sample of each stay at a level.
fn visits(values: &[f64], level: f64, tolerance: f64) -> Vec<(usize, usize)> {
    let mut visits: Vec<(usize, usize)> = Vec::new();
    for (k, _) in values.iter().enumerate().filter(|(_, v)| (**v - level).abs() <= tolerance) {
        match visits.last_mut() {
            Some(last) if last.1 == k => last.1 = k + 1,
            _ => visits.push((k, k + 1)),
        }
    }
    visits
}

/// Samples at the extreme, if it is a limit.
fn at_limit(values: &[f64], level: f64, inward: f64, step: f64, usual: f64) -> Option<usize> {
    let visits = visits(values, level, 0.25 * step);
    let samples: usize = visits.iter().map(|(from, to)| to - from).sum();
    let longest = visits.iter().map(|(from, to)| to - from).max()?;
    let rests = samples as f64 > REST_SHARE * values.len() as f64;
    if rests || visits.len() < VISITS_MIN || longest as f64 > LONGEST_VISIT_SHARE * samples as f64 {
        return None;
    }
    let mut entry: Vec<f64> =
        visits.iter().filter(|(from, _)| *from > 0).map(|(from, _)| (values[from - 1] - level).abs()).collect();
    if median(&mut entry) < (ENTRY_SHARE_MIN * usual).max(ENTRY_STEPS_MIN * step) {
        return None;
    }
    // the level beside: one step inward, or the next value where there is no lattice
    let inside = |v: &f64| inward * (v - level) > 0.25 * step;
    let next = values.iter().copied().filter(inside).map(|v| inward * (v - level)).fold(f64::INFINITY, f64::min);
    let width = if step > 0.0 { 1.5 * step } else { next };
    let beside = values.iter().filter(|v| inside(v) && inward * (**v - level) <= width).count() as f64;
    let mut levels: Vec<f64> = values.to_vec();
    levels.sort_unstable_by(f64::total_cmp);
    levels.dedup();
    if levels.len() < LEVELS_MIN {
        return None;
    }
    // of as many independent samples as there are visits, `SINE_RATIO : 1` at most fall at the extreme
    let all = samples as f64 + beside;
    let expected = SINE_RATIO / (1.0 + SINE_RATIO);
    let independent = all * visits.len() as f64 / samples as f64;
    let deviation = (expected * (1.0 - expected) / independent).sqrt();
    (samples as f64 / all - expected > normal_two_sided(2.0 * CHANCE) * deviation
        || beside <= 1.0 && samples > 3 * VISITS_MIN)
        .then_some(samples)
}

#[cfg(test)]
mod tests {
    use super::clipped;
    use crate::noise::Noise;

    #[test]
    fn noise_and_oscillations_are_clipped_where_they_meet_a_limit_quantised_or_not() {
        for seed in 0..20 {
            let mut noise = Noise::new(300 + seed);
            let white = noise.series(4000, 1.0);
            let turn = 0.25 + 0.3 * noise.uniform();
            let beat = |k: i32| 1.0 + 0.2 * (0.13 * turn * f64::from(k)).sin();
            let sine: Vec<f64> = (0..4000).map(|k| (turn * f64::from(k)).sin() * beat(k)).collect();
            for (values, limit) in [(&white, 1.5), (&sine, 0.9)] {
                for step in [0.0, 0.02] {
                    let read = |v: &f64| {
                        let v = v.clamp(-limit, 9.0);
                        if step > 0.0 { (v / step).round() * step } else { v }
                    };
                    let found = clipped(&values.iter().map(read).collect::<Vec<_>>());
                    let found = found.unwrap_or_else(|| panic!("{seed} {limit} {step}"));
                    assert!((found.level + limit).abs() <= step, "{found:?}");
                    let share = values.iter().filter(|v| **v <= -limit).count() as f64 / 4000.0;
                    assert!((found.share - share).abs() < 0.02, "{found:?} {share}");
                }
            }
        }
    }

    #[test]
    fn sines_dwells_switches_and_noise_are_not_clipped() {
        for seed in 0..40 {
            let mut noise = Noise::new(400 + seed);
            for step in [0.003, 0.03, 0.1] {
                let coarse = |v: f64| (v / step).round() * step;
                let turn = 0.01 + 0.3 * noise.uniform();
                let sine: Vec<f64> = (0..5000).map(|k| coarse((turn * f64::from(k)).sin())).collect();
                assert_eq!(clipped(&sine), None, "sine {step} {turn}");
                let white: Vec<f64> = noise.series(5000, 0.3).into_iter().map(coarse).collect();
                assert_eq!(clipped(&white), None, "white {step}");
                // between two places and back in ten samples or more, at rest for a while in each
                let turn = 0.2 * turn;
                let place = |k: i32| {
                    let phase = (turn * f64::from(k)).sin();
                    (3.0 * phase).clamp(-1.0, 1.0)
                };
                let smooth = |k: i32| (1.5 * place(k) - 0.5 * place(k).powi(3)) + 0.5;
                let dwell: Vec<f64> = (0..5000).map(|k| coarse(smooth(k))).collect();
                assert_eq!(clipped(&dwell), None, "dwell {step} {turn}");
            }
            let switch: Vec<f64> = (0..2000).map(|_| if noise.uniform() < 0.5 { 1.0 } else { -1.0 }).collect();
            assert_eq!(clipped(&switch), None);
            let contact: Vec<f64> = noise.series(3000, 1.0).into_iter().map(|v| v.max(0.0)).collect();
            assert_eq!(clipped(&contact), None, "a force that only pushes");
        }
    }
}
