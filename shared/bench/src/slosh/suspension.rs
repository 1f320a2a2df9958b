//! `obsid bench bp2-suspension`: spring or pendulum, record by record of new noise, each truth in
//! turn.
//!
//! Requirements: the right hypothesis always, a right model that explains its record (z within 4)
//! with its length within 0.2 % and its mass within three sigma, and a wrong one that does not
//! explain it (z above 50).

use super::tank_model::TankModelChoice;
use crate::campaign::Campaign;
use crate::slosh_suspension::SuspensionKind;
use serde::Serialize;
use std::fmt::Write;

/// What was made of one record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// Whether the name is the true one; none: not named.
    pub is_right: Option<bool>,
    /// z of χ² of the true model and of the other.
    pub z_right: f64,
    pub z_wrong: f64,
    /// Of rod or stiffness, relative.
    pub error: f64,
    /// Error of the slosh mass in its sigmas.
    pub mass_sigmas: f64,
    /// Information criterion of the other model less that of the true one.
    pub margin: f64,
    /// Of `k(a) = k0 + k1 a`, in their sigmas.
    pub offset_sigmas: f64,
    pub slope_sigmas: f64,
}

/// Least and greatest over the records that were judged; NaN where one of them is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    pub low: f64,
    pub high: f64,
}

/// A truth over all records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdicts {
    pub problem: &'static str,
    pub trials: usize,
    pub seed: u64,
    pub right: usize,
    /// Named, but wrongly.
    pub wrong: usize,
    /// Both models were fitted, neither stands.
    pub undecided: usize,
    /// A model could not be fitted.
    pub failed: usize,
    pub z_right: Range,
    pub z_wrong: Range,
    pub error_percent: Range,
    pub error_percent_rms: f64,
    pub mass_sigmas: Range,
    pub margin: Range,
    pub offset_sigmas: Range,
    pub slope_sigmas: Range,
}

/// All records of a campaign; `None` where no record could be judged.
pub fn verdicts(choice: &TankModelChoice, campaign: &Campaign, after_each: &(dyn Fn() + Sync)) -> Option<Verdicts> {
    let all = campaign.each(&|record| choice.judge(campaign.seed, record), after_each);
    let judged: Vec<Judged> = all.into_iter().flatten().collect();
    let named = |kind: Option<bool>| judged.iter().filter(|one| one.is_right == kind).count();
    let range = |of: fn(&Judged) -> f64| {
        let wider = |range: Range, one: f64| Range {
            low: if one < range.low || one.is_nan() { one } else { range.low },
            high: if one > range.high || one.is_nan() { one } else { range.high },
        };
        judged.iter().map(of).fold(Range { low: f64::INFINITY, high: f64::NEG_INFINITY }, wider)
    };
    let square: f64 = judged.iter().map(|one| one.error * one.error).sum();
    (!judged.is_empty()).then(|| Verdicts {
        problem: if choice.truth == SuspensionKind::Spring { SPRING } else { PENDULUM },
        trials: campaign.trials,
        seed: campaign.seed,
        right: named(Some(true)),
        wrong: named(Some(false)),
        undecided: named(None),
        failed: campaign.trials - judged.len(),
        z_right: range(|one| one.z_right),
        z_wrong: range(|one| one.z_wrong),
        error_percent: range(|one| 100.0 * one.error),
        error_percent_rms: 100.0 * (square / judged.len() as f64).sqrt(),
        mass_sigmas: range(|one| one.mass_sigmas),
        margin: range(|one| one.margin),
        offset_sigmas: range(|one| one.offset_sigmas),
        slope_sigmas: range(|one| one.slope_sigmas),
    })
}

const SPRING: &str = "bp2-suspension, truth: spring";
const PENDULUM: &str = "bp2-suspension, truth: pendulum";

impl Verdicts {
    /// One line.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("names and numbers always serialise") + "\n"
    }

    /// The counts and ranges as text.
    pub fn table(&self) -> String {
        let Self { problem, trials, seed, right, wrong, undecided, failed, .. } = self;
        let mut text = format!("{problem}, {trials} records, seed {seed}\n\n");
        let _ = writeln!(text, "  right {right}   wrong {wrong}   undecided {undecided}   failed {failed}");
        let second = if *problem == SPRING { "k" } else { "L" };
        for (name, range) in [
            ("z of the right model".to_owned(), self.z_right),
            ("z of the wrong model".to_owned(), self.z_wrong),
            (format!("error of {second} %"), self.error_percent),
            ("error of the mass, sigmas".to_owned(), self.mass_sigmas),
            ("BIC wrong - right".to_owned(), self.margin),
            ("k0 of k(a) = k0 + k1 a, sigmas".to_owned(), self.offset_sigmas),
            ("k1, sigmas".to_owned(), self.slope_sigmas),
        ] {
            let _ = writeln!(text, "  {name:<32} {:>12.3} to {:>12.3}", range.low, range.high);
        }
        let _ = writeln!(text, "  {:<32} {:>12.3}", format!("RMSE of {second} %"), self.error_percent_rms);
        text
    }
}
