//! Of modes seen at several rates, the one that is reported; and merged modes, which only a fast
//! rate shows.
//!
//! A rate looks over the time of its block rows. A fast one may take close modes for one wide mode,
//! where a slower one tells them apart. A rate that shows two modes tells them apart: neither is a
//! merger of the other.

use crate::mac::modal_assurance_criterion;
use crate::selection::{Mode, Selection};
use crate::stabilisation::{RejectedPole, Rejection};
use crate::uncertainty::relative_variance;

/// Variances of one mode at two rates this close count as equal; then persistence over the orders
/// decides, which sees bias.
const RATE_VARIANCE_SLACK: f64 = 2.0;

/// Deviations from which dampings at two rates are not of one mode: estimates from the same samples
/// have errors in common, so that three are less than once in a thousand modes.
const DISAGREEMENT_SIGMA: f64 = 3.0;
/// Orders over which poles persist that are taken for those of a mode, as in the selection of
/// modes.
const PERSISTENT_ORDERS: usize = 6;

/// Of modes that are the same at several rates, the one that persists over most orders among those
/// of small variance.
pub(crate) fn keep_best_rate(mut all: Selection) -> Selection {
    let variance = |mode: &Mode| {
        relative_variance(mode.sigma_frequency_hz / mode.frequency_hz, mode.sigma_damping, mode.damping_ratio)
    };
    all.modes.sort_by(|a, b| variance(a).total_cmp(&variance(b)));
    let mut groups: Vec<Vec<Mode>> = Vec::new();
    for mode in all.modes {
        match groups.iter_mut().find(|group| same_mode(&group[0], &mode)) {
            Some(group) => group.push(mode),
            None => groups.push(vec![mode]),
        }
    }
    let mut modes: Vec<Mode> = Vec::new();
    for (k, mut group) in groups.clone().into_iter().enumerate() {
        let (beside, elsewhere) = others(k, &groups);
        let narrow = narrower(&group, &elsewhere).map(|narrow| narrow.decimation);
        if let Some(decimation) = narrow.or_else(|| unresolved_in_place(&group, &beside, &all.rejected)) {
            all.rejected.extend(group.iter().map(|mode| left_out(mode, decimation)));
            continue;
        }
        let slack = RATE_VARIANCE_SLACK * variance(&group[0]);
        let mut best = 0;
        for (index, mode) in group.iter().enumerate().skip(1) {
            if variance(mode) <= slack && mode.orders_found > group[best].orders_found {
                best = index;
            }
        }
        let kept = group.swap_remove(best);
        all.rejected.extend(group.iter().map(|mode| left_out(mode, kept.decimation)));
        modes.push(kept);
    }
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Selection { modes, rejected: all.rejected }
}

/// Modes of the other groups: of those that a rate shows together with group `k`, and so tells
/// apart from it; and of those that no rate shows
/// together with it.
fn others(k: usize, groups: &[Vec<Mode>]) -> (Vec<&Mode>, Vec<&Mode>) {
    let at = |decimation: usize| groups[k].iter().any(|mode| mode.decimation == decimation);
    let is_beside = |group: &[Mode]| group.iter().any(|mode| at(mode.decimation));
    let of = |beside: bool| {
        let others = groups.iter().enumerate().filter(move |(other, _)| *other != k);
        others.filter(|(_, group)| is_beside(group) == beside).flat_map(|(_, group)| group).collect()
    };
    (of(true), of(false))
}

/// The slowest rate that shows a mode.
fn slowest(group: &[Mode]) -> usize {
    group.iter().map(|mode| mode.decimation).max().unwrap_or(1)
}

/// A narrower mode within the half-power width of that of `group`, among those seen only at rates
/// slower than all that show it.
///
/// A fast rate looks over a short time and takes close modes for one wide one; the slow rate, which
/// tells them apart, would show the wide one too if it existed.
fn narrower<'a>(group: &[Mode], elsewhere: &[&'a Mode]) -> Option<&'a Mode> {
    let (mode, slowest) = (&group[0], slowest(group));
    let is_narrower = |other: &&&Mode| {
        other.decimation > slowest
            && (other.frequency_hz - mode.frequency_hz).abs() <= 2.0 * mode.damping_ratio * mode.frequency_hz
            && other.damping_ratio < mode.damping_ratio
            && other.sigma_frequency_hz < mode.sigma_frequency_hz
    };
    elsewhere.iter().find(is_narrower).copied()
}

/// A slower rate than all that show the mode of `group` where narrower poles persist within its
/// half-power width, over [`PERSISTENT_ORDERS`] orders, whose damping is not resolved but is not
/// that of the mode, and which are not of a mode `beside` it: modes that the record is too short
/// for, which the fast rate takes for one wide one.
fn unresolved_in_place(group: &[Mode], beside: &[&Mode], rejected: &[RejectedPole]) -> Option<usize> {
    let (mode, slowest) = (&group[0], slowest(group));
    let in_place = |pole: &&RejectedPole| {
        let Rejection::NotResolved { damping_ratio, sigma_damping, sigma_frequency_hz } = pole.reason else {
            return false;
        };
        let is = |other: &&Mode| {
            let together = sigma_frequency_hz.hypot(other.sigma_frequency_hz);
            (pole.frequency_hz - other.frequency_hz).abs() <= DISAGREEMENT_SIGMA * together
        };
        pole.decimation > slowest
            && mode.damping_ratio - damping_ratio > DISAGREEMENT_SIGMA * mode.sigma_damping.hypot(sigma_damping)
            && (pole.frequency_hz - mode.frequency_hz).abs() <= 2.0 * mode.damping_ratio * mode.frequency_hz
            && !beside.iter().any(is)
    };
    let mut poles: Vec<(usize, usize)> =
        rejected.iter().filter(in_place).map(|pole| (pole.decimation, pole.order)).collect();
    poles.sort_unstable();
    poles.dedup();
    let rate = poles.chunk_by(|a, b| a.0 == b.0).find(|of_rate| of_rate.len() >= PERSISTENT_ORDERS)?;
    Some(rate[0].0)
}

fn left_out(mode: &Mode, better_decimation: usize) -> RejectedPole {
    RejectedPole {
        decimation: mode.decimation,
        order: mode.order,
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        reason: Rejection::BetterElsewhere { decimation: better_decimation },
    }
}

/// Frequencies within their bandwidth or three deviations, and shapes alike; or nearly one
/// frequency.
fn same_mode(a: &Mode, b: &Mode) -> bool {
    let apart = (a.frequency_hz - b.frequency_hz).abs();
    let together = (a.sigma_frequency_hz * a.sigma_frequency_hz + b.sigma_frequency_hz * b.sigma_frequency_hz).sqrt();
    let bandwidth = a.damping_ratio.max(b.damping_ratio) * a.frequency_hz;
    let mac = modal_assurance_criterion(&a.mode_shape, &b.mode_shape);
    (apart <= bandwidth.max(3.0 * together) && mac > 0.8) || (a.decimation != b.decimation && apart <= 3.0 * together)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_noise::Noise;
    use faer::c64;

    fn seen(frequency_hz: f64, damping_ratio: f64, decimation: usize, shape: &[f64]) -> Mode {
        Mode {
            frequency_hz,
            damping_ratio,
            sigma_frequency_hz: 0.1 * damping_ratio * frequency_hz,
            sigma_damping: 0.15 * damping_ratio,
            correlation: 0.0,
            mode_shape: shape.iter().map(|x| c64::new(*x, 0.0)).collect(),
            shape_deviation: Vec::new(),
            phase_collinearity: 1.0,
            channel_share: Vec::new(),
            dominant_channel: 0,
            orders_found: 20,
            order: 10,
            decimation,
        }
    }

    /// A wide mode and a narrow one within its half-power width, outside of both half widths.
    fn pair(noise: &mut Noise) -> [(f64, f64); 2] {
        let (f, zeta) = (noise.between(1.0, 2.0), noise.between(0.01, 0.03));
        let (share, widths) = (noise.between(0.1, 0.4), noise.between(1.45, 1.9));
        [(f, zeta), (f * (1.0 + widths * zeta), share * zeta)]
    }

    const SHAPES: [[f64; 3]; 2] = [[1.0, 0.5, -0.3], [0.4, -1.0, 0.8]];

    fn kept(modes: Vec<Mode>, rejected: Vec<RejectedPole>) -> Vec<(f64, usize)> {
        let kept = keep_best_rate(Selection { modes, rejected });
        kept.modes.iter().map(|mode| (mode.frequency_hz, mode.decimation)).collect()
    }

    fn unresolved(frequency_hz: f64, damping_ratio: f64, decimation: usize, order: usize) -> RejectedPole {
        let sigmas = (0.4 * damping_ratio, 0.3 * damping_ratio * frequency_hz);
        let reason = Rejection::NotResolved { damping_ratio, sigma_damping: sigmas.0, sigma_frequency_hz: sigmas.1 };
        RejectedPole { decimation, order, frequency_hz, damping_ratio, reason }
    }

    #[test]
    fn both_modes_of_a_close_pair_are_kept_that_one_rate_tells_apart() {
        let mut noise = Noise::new(360_101);
        for _ in 0..200 {
            let [wide, narrow] = pair(&mut noise);
            let fast = || vec![seen(wide.0, wide.1, 1, &SHAPES[0]), seen(narrow.0, narrow.1, 1, &SHAPES[1])];
            // The slow rate does not resolve the wide one,
            let mut modes = fast();
            modes.push(seen(narrow.0, narrow.1, 4, &SHAPES[1]));
            assert_eq!(kept(modes, Vec::new()).len(), 2, "{wide:?} {narrow:?}");
            // or neither.
            let poles = (2..30).map(|order| unresolved(narrow.0, narrow.1, 4, order)).collect();
            assert_eq!(kept(fast(), poles).len(), 2, "{wide:?} {narrow:?}");
        }
    }

    #[test]
    fn a_wide_mode_at_a_fast_rate_is_left_out_for_the_pair_of_a_slow_one() {
        let mut noise = Noise::new(360_102);
        for _ in 0..200 {
            let [(f, zeta), _] = pair(&mut noise);
            let merged = || seen(f, zeta, 1, &[0.7, 0.4, 0.1]);
            let pair = [0.8, -0.8].map(|widths| f * (1.0 + widths * zeta));
            let slow = [0, 1].map(|k| seen(pair[k], 0.2 * zeta, 4, &SHAPES[k]));
            let modes = kept([merged()].into_iter().chain(slow).collect(), Vec::new());
            assert!(modes.len() == 2 && modes.iter().all(|mode| mode.1 == 4), "{modes:?}");
            let poles = (2..30).flat_map(|order| pair.map(|f| unresolved(f, 0.2 * zeta, 4, order))).collect();
            assert!(kept(vec![merged()], poles).is_empty());
        }
    }
}
