//! Check of the channel metadata of every record.

use super::Case;
use crate::recordings::Loaded;
use discovery::mislabelled::{Mislabelled, mislabelled};
use identification::work::{Watch, Work};
use std::sync::Arc;

/// Mislabelled channels per recording, the cost of the check, and the hypotheses that were not
/// tested.
pub struct Labels {
    pub labels: Vec<Option<Mislabelled>>,
    pub spent: f64,
    pub left_out: Vec<String>,
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
