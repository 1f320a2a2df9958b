//! `obsid bench bp2-suspension`: spring or pendulum, record by record of new noise, each truth in turn.
//!
//! What is asked: the right name always, a right model that explains its record (z within 4) and a wrong one that does not
//! (z above 50).

use super::tank_model::TankModelChoice;
use crate::bench::campaign::{Answer, Benchmark, Campaign, Cost, Method, Parameter};
use physics::slosh_suspension::SuspensionKind;
use serde::Serialize;
use std::fmt::Write;

/// What was made of one record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// 1 where the name is the true one, else 0.
    pub is_right: f64,
    /// z of χ² of the true model and of the other.
    pub z_right: f64,
    pub z_wrong: f64,
    /// Of rod or stiffness, relative.
    pub error: f64,
    /// Information criterion of the other model less that of the true one.
    pub margin: f64,
    /// Of `k(a) = k0 + k1 a`, in their sigmas.
    pub offset_sigmas: f64,
    pub slope_sigmas: f64,
}

/// Least and greatest over the records.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    pub low: f64,
    pub high: f64,
}

/// A truth over all records.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdicts {
    pub truth: &'static str,
    pub records: usize,
    pub seed: u64,
    pub right: usize,
    /// Named, but wrongly, or not named.
    pub wrong: usize,
    pub z_right: Range,
    pub z_wrong: Range,
    pub error_percent: Range,
    pub error_percent_rms: f64,
    pub margin: Range,
    pub offset_sigmas: Range,
    pub slope_sigmas: Range,
}

/// A campaign's records, judged.
struct Records<'a>(&'a TankModelChoice);

impl Benchmark for Records<'_> {
    fn name(&self) -> &'static str {
        "bp2-suspension"
    }

    fn parameters(&self) -> Option<Vec<Parameter>> {
        None
    }

    fn methods(&self) -> &[Method] {
        &[]
    }

    fn answers(&self, seed: u64, record: usize) -> Vec<Answer> {
        let judged = self.0.judge(seed, record);
        judged.map_or_else(Vec::new, |judged| vec![Answer::bare(judged.numbers())])
    }

    fn costs(&self) -> Vec<Cost> {
        Vec::new()
    }
}

impl Judged {
    fn numbers(&self) -> [f64; 7] {
        let Self { is_right, z_right, z_wrong, error, margin, offset_sigmas, slope_sigmas } = *self;
        [is_right, z_right, z_wrong, error, margin, offset_sigmas, slope_sigmas]
    }
}

/// All records of a campaign; `None` where no record could be judged.
pub fn verdicts(choice: &TankModelChoice, campaign: &Campaign, after_each: &(dyn Fn() + Sync)) -> Option<Verdicts> {
    let judged: Vec<Vec<f64>> = campaign
        .run(&Records(choice), after_each)
        .iter()
        .flatten()
        .map(|answer| answer.found.iter().flatten().map(|found| found.value).collect())
        .collect();
    let range = |place: usize, factor: f64| {
        let values = judged.iter().map(|one| factor * one[place]);
        values.fold(Range { low: f64::INFINITY, high: f64::NEG_INFINITY }, |range, value| Range {
            low: range.low.min(value),
            high: range.high.max(value),
        })
    };
    let right = judged.iter().filter(|one| one[0] == 1.0).count();
    let square: f64 = judged.iter().map(|one| one[3] * one[3]).sum();
    (!judged.is_empty()).then(|| Verdicts {
        truth: if choice.truth == SuspensionKind::Spring { "spring" } else { "pendulum" },
        records: campaign.trials,
        seed: campaign.seed,
        right,
        wrong: campaign.trials - right,
        z_right: range(1, 1.0),
        z_wrong: range(2, 1.0),
        error_percent: range(3, 100.0),
        error_percent_rms: 100.0 * (square / judged.len() as f64).sqrt(),
        margin: range(4, 1.0),
        offset_sigmas: range(5, 1.0),
        slope_sigmas: range(6, 1.0),
    })
}

impl Verdicts {
    /// One line.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("names and numbers always serialise") + "\n"
    }

    pub fn table(&self) -> String {
        let mut text =
            format!("bp2-suspension, truth: {}, {} records, seed {}\n\n", self.truth, self.records, self.seed);
        let _ = writeln!(text, "  right verdicts {}   wrong or none {}", self.right, self.wrong);
        let second = if self.truth == "spring" { "k" } else { "L" };
        for (name, range) in [
            ("z of the right model".to_owned(), self.z_right),
            ("z of the wrong model".to_owned(), self.z_wrong),
            (format!("error of {second} %"), self.error_percent),
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
