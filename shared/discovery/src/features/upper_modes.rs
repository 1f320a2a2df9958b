//! Test of the adopted changes on modes that were not fitted: from the lower ones to the upper
//! ones.
//!
//! All amplitudes are fitted to the features of the lower modes and predict those of the upper
//! ones, mode by mode, so that their scatter gives the standard error of the gain. Each change is
//! tested beside the others: the same lower modes without it are fitted again. A change that moves
//! no lower mode (a factor on an upper one), or no upper one, cannot be tested: it is neither
//! confirmed nor rejected.

use super::comparison::{Comparison, MODES_MIN, Member};
use super::likelihood::{Each, Group};
use crate::diagnose::{Diagnosis, HeldOut, HeldOutChannel, HeldOutKind};
use identification::held_out::Status;
use identification::statistics::student_two_sided;
use nalgebra::DMatrix;

/// A change moves a mode when one of its features changes by more: above the rounding of the
/// eigenvalues.
const FEATURE_MOVE_MIN: f64 = 1e-6;

/// Residual of the upper modes under a set fitted to the lower ones.
struct Prediction {
    /// Of all features.
    left: Vec<f64>,
    tau: Each,
    /// Directions in which the amplitudes are not known, times their deviations.
    spread: DMatrix<f64>,
}

/// Gain of the whole set, and the status of each member.
pub(super) fn test_upper_modes(
    comparison: &Comparison<'_>,
    members: &[Member],
    fitted: Option<usize>,
) -> (HeldOut, Vec<Status>) {
    let n = comparison.frame.pairs.len();
    let fitted = fitted.unwrap_or(n.div_ceil(2).max(MODES_MIN)).clamp(1, n);
    let nothing = Diagnosis::cannot_decide(String::new()).held_out;
    let askable: Vec<usize> =
        (0..members.len()).filter(|place| moves_lower(comparison, members, *place, fitted)).collect();
    if fitted + 2 > n || askable.is_empty() {
        return (nothing, vec![Status::Unconfirmed; members.len()]);
    }
    let Some(with) = predict(comparison, members, &askable, fitted) else {
        return (nothing, vec![Status::NotConverged; members.len()]);
    };
    let without = |left_out: &[usize]| {
        let kept: Vec<usize> = (0..members.len()).filter(|place| !left_out.contains(place)).collect();
        let set: Vec<Member> = kept.iter().map(|place| members[*place].clone()).collect();
        let free: Vec<usize> = (0..kept.len()).filter(|k| askable.contains(&kept[*k])).collect();
        predict(comparison, &set, &free, fitted)
    };
    let Some(before) = without(&askable) else { return (nothing, vec![Status::NotConverged; members.len()]) };
    let statuses = (0..members.len()).map(|place| match askable.contains(&place) {
        false => Status::Unconfirmed,
        true => {
            without(&[place]).map_or(Status::NotConverged, |one| Gain::new(comparison, &one, &with, fitted).status())
        }
    });
    let statuses = statuses.collect();
    let gain = Gain::new(comparison, &before, &with, fitted);
    let held_out = HeldOut {
        kind: HeldOutKind::Blocks,
        channels: channels(comparison, &before, &with, fitted),
        loglik_gain: Some(gain.sum),
        gain_se: Some(gain.se),
        gain_ci95: Some(gain.interval()),
        whiteness_p_before: None,
        whiteness_p_after: None,
    };
    (held_out, statuses)
}

fn moves_lower(comparison: &Comparison<'_>, members: &[Member], place: usize, fitted: usize) -> bool {
    let mut others = members.to_vec();
    others.remove(place);
    let rows = comparison.frame.rows_of(0..fitted);
    match (comparison.left(members, &rows), comparison.left(&others, &rows)) {
        (Some(with), Some(without)) => with.iter().zip(&without).any(|(a, b)| (a - b).abs() > FEATURE_MOVE_MIN),
        _ => false,
    }
}

/// The members at `free` are fitted to the lower modes.
fn predict(comparison: &Comparison<'_>, members: &[Member], free: &[usize], fitted: usize) -> Option<Prediction> {
    let low = comparison.frame.rows_of(0..fitted);
    let evidence = comparison.evidence.part(&low);
    let mut set = members.to_vec();
    comparison.refit(&mut set, free, &evidence, &low);
    let likelihood = evidence.best(&comparison.left(&set, &low)?);
    let left = comparison.left(&set, &comparison.all_rows())?;
    // a group without a lower mode is as uncertain as over all modes; nor is the τ of few modes
    // exact
    let tau = Group::ALL.map(|group| match evidence.count(group) {
        0 => comparison.null.tau[group as usize],
        count if count == 1 || free.is_empty() => likelihood.tau[group as usize],
        count => likelihood.tau[group as usize] * (count as f64 / (count as f64 - 1.0)).sqrt(),
    });
    let mut spread = DMatrix::zeros(left.len(), 0);
    if !free.is_empty() {
        let fixed: Vec<Member> = free.iter().map(|place| set[*place].clone()).collect();
        spread = comparison.spread(&fixed, &low, &tau)?.1;
    }
    Some(Prediction { left, tau, spread })
}

/// Gain in log-likelihood over the upper modes.
struct Gain {
    sum: f64,
    se: f64,
    modes: usize,
    /// Root mean square in standard deviations, before and after.
    size: [f64; 2],
}

impl Gain {
    fn new(comparison: &Comparison<'_>, before: &Prediction, after: &Prediction, fitted: usize) -> Self {
        let n = comparison.frame.pairs.len();
        let value = |prediction: &Prediction, mode: usize| {
            let rows = comparison.frame.rows_of(mode..mode + 1);
            let evidence = comparison.evidence.part(&rows).with_columns(&prediction.spread.select_rows(&rows));
            let left: Vec<f64> = rows.iter().map(|k| prediction.left[*k]).collect();
            evidence.at(&left, &prediction.tau)
        };
        let gains: Vec<f64> = (fitted..n).map(|mode| 0.5 * (value(before, mode) - value(after, mode))).collect();
        let sum: f64 = gains.iter().sum();
        let m = gains.len() as f64;
        let se = (gains.iter().map(|g| (g - sum / m) * (g - sum / m)).sum::<f64>() * m / (m - 1.0)).sqrt();
        let rows = comparison.frame.rows_of(fitted..n);
        let size = [before, after].map(|prediction| {
            let square = |k: &usize| {
                let tau = after.tau[comparison.evidence.group[*k] as usize];
                prediction.left[*k] * prediction.left[*k] / (comparison.evidence.sigma[*k].powi(2) + tau * tau)
            };
            rows.iter().map(square).sum::<f64>().sqrt()
        });
        Self { sum, se, modes: gains.len(), size }
    }

    /// Of probability 95 %, by Student's law: the spread is that of few modes.
    fn interval(&self) -> [f64; 2] {
        let t = student_two_sided(0.05, (self.modes.max(2) - 1) as f64);
        [self.sum - t * self.se, self.sum + t * self.se]
    }

    fn status(&self) -> Status {
        let [before, after] = self.size;
        match self.interval() {
            [low, _] if low > 0.0 && after < before => Status::Confirmed,
            [_, high] if high < 0.0 || after > before => Status::Rejected,
            _ => Status::Unconfirmed,
        }
    }
}

/// One channel for each group that the set moves.
fn channels(
    comparison: &Comparison<'_>,
    before: &Prediction,
    after: &Prediction,
    fitted: usize,
) -> Vec<HeldOutChannel> {
    let n = comparison.frame.pairs.len();
    let rows = comparison.frame.rows_of(fitted..n);
    let evidence = comparison.evidence.part(&rows);
    let of = |prediction: &Prediction| -> Vec<f64> { rows.iter().map(|k| prediction.left[*k]).collect() };
    let (before, after) = (of(before), of(after));
    let moved = |group: &Group| {
        evidence
            .group
            .iter()
            .zip(before.iter().zip(&after))
            .any(|(g, (a, b))| g == group && (a - b).abs() > FEATURE_MOVE_MIN)
    };
    let channel = |group: Group| {
        let what = match group {
            Group::Frequency => "ln frequency",
            Group::Damping => "ln damping ratio",
            Group::Shape => "shapes",
        };
        let (rms_before, rms_after) = (evidence.rms_of(&before, group), evidence.rms_of(&after, group));
        HeldOutChannel {
            name: format!("{what} of modes {} to {n}, fitted on {fitted}", fitted + 1),
            fit_percent_before: super::report::fit_percent(rms_before),
            fit_percent_after: super::report::fit_percent(rms_after),
            rms_before,
            rms_after,
        }
    };
    Group::ALL.into_iter().filter(moved).map(channel).collect()
}
