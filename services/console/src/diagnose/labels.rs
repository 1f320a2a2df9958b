//! Check of the channel metadata of every record.

use super::Case;
use crate::recordings::Loaded;
use discovery::diagnose::LabelReport;
use discovery::evidence::labels::{is_wrong, log_jacobian as log_jacobian_of, with_noise_of};
use discovery::mislabelled::{Mislabelled, mislabelled};
use dynamics::description::Plant;
use identification::work::{Watch, Work};
use std::sync::Arc;

/// Mislabelled channels per recording, the cost of the check, and the hypotheses that were not
/// tested.
pub struct Labels {
    pub labels: Vec<Option<Mislabelled>>,
    pub spent: f64,
    pub left_out: Vec<String>,
}

/// Corrected labels as a rival of the labels as they are.
pub struct Rival {
    pub mistakes: usize,
    pub log_jacobian: f64,
    pub plant: Plant,
}

/// Within `most`; every record has its share of what is left.
pub fn look_at_labels(case: &Case, most: f64, watch: &Watch) -> Labels {
    let records: Vec<&Loaded> = case.time_records().collect();
    let mut all = Labels { labels: Vec::new(), spent: 0.0, left_out: Vec::new() };
    for (k, one) in records.iter().enumerate() {
        let share = (most - all.spent).max(0.0) / (records.len() - k) as f64;
        let work = Arc::new(Work::watched(share, watch.clone()));
        let found = if watch.is_stopped() { None } else { mislabelled(&one.recording, &case.plant, &work) };
        all.labels.push(found);
        all.spent += work.spent();
        // those that follow may be read as this one
        watch.plan_now(all.spent / (k + 1) as f64 * (records.len() - k - 1) as f64);
        all.left_out.extend(work.note().map(|note| format!("{}: {note}", one.recording.name)));
    }
    all.keep_those_of_fitted(case.fitted.len());
    all
}

impl Labels {
    /// No label is suspected, on the user's word.
    pub fn trusted(case: &Case) -> Self {
        Self { labels: vec![None; case.time_records().count()], spent: 0.0, left_out: Vec::new() }
    }

    /// What the corrected problem has to answer for: `ln |∂y'/∂y|` of all readings, the number of
    /// different mistakes, and the plant with the noise of corrected commands, where all fitted
    /// recordings have them alike.
    pub fn as_rival(&self, case: &Case) -> Rival {
        let mut distinct: Vec<&Mislabelled> = Vec::new();
        let mut log_jacobian = 0.0;
        for (one, label) in case.time_records().zip(&self.labels) {
            let Some(label) = label else { continue };
            log_jacobian += log_jacobian_of(&one.recording, &case.plant, label);
            if !distinct.iter().any(|known| known.is_like(label)) {
                distinct.push(label);
            }
        }
        let fitted = &self.labels[..case.fitted.len().min(self.labels.len())];
        let in_all = |own: &&&Mislabelled| fitted.iter().all(|label| label.as_ref().is_some_and(|l| l.is_like(own)));
        let common: Vec<Mislabelled> = distinct.iter().filter(in_all).map(|label| (*label).clone()).collect();
        Rival { mistakes: distinct.len(), log_jacobian, plant: with_noise_of(&case.plant, &common) }
    }

    /// Labels that are wrong with `probability`, as entries of a diagnosis; those that the evidence
    /// does not show to be wrong are doubted no longer.
    pub fn settled(&mut self, probability: f64) -> Vec<LabelReport> {
        let is_wrong = is_wrong(probability);
        let doubted = self.labels.iter().flatten();
        let reports = doubted.map(|label| label.report(Some(probability), is_wrong)).collect();
        if !is_wrong {
            self.labels.fill(None);
        }
        reports
    }

    /// What one recording alone shows, which is to test what was found, is no mistake of its label:
    /// it may be what the plant lacks.
    fn keep_those_of_fitted(&mut self, fitted: usize) {
        let fitted = fitted.min(self.labels.len());
        let (own, others) = self.labels.split_at_mut(fitted);
        for label in others {
            let is_like = |known: &Option<Mislabelled>| {
                known.as_ref().zip(label.as_ref()).is_some_and(|(known, label)| known.is_like(label))
            };
            if own.iter().any(is_like) {
                continue;
            }
            let said = label.take().map(|label| {
                format!(
                    "{}: {}, in a recording that was not fitted alone: it was left as it is",
                    label.recording,
                    label.in_words()
                )
            });
            self.left_out.extend(said);
        }
    }
}
