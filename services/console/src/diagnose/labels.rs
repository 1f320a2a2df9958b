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
        all.left_out.extend(work.note().map(|note| format!("{}: {note}", one.recording.name)));
    }
    all
}
