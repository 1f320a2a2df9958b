//! What a run was to deliver and did not: samples that never came, partitions that were given up.
//!
//! A sample that was rejected (`bad` of a partition's row) is no loss by itself: where it stood for
//! a good one, that one is missing and counted as lost.

use runtime::statistics::PartitionRow;
use serde_json::{Value, json};
use std::fmt::{self, Display, Formatter};
use std::path::Path;

/// Kind of a loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LossKind {
    /// The partition ended before the run: its results are missing from then on.
    GivenUp,
    /// Samples that the partition was sent and never received.
    SamplesLost,
    /// The file of `--record` ends or has a gap; the results are whole.
    RecordingStopped,
}

/// A loss, by the partition that had it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    pub partition: String,
    pub kind: LossKind,
    /// Samples; of a partition that was given up its restarts; of a recording 1.
    pub count: u64,
    /// What else is known of it.
    pub detail: String,
}

impl Loss {
    /// All losses that the rows of a run tell.
    #[must_use]
    pub fn all(rows: &[PartitionRow]) -> Vec<Self> {
        let of_row = |row: &PartitionRow| {
            let given_up = row.given_up.then_some((LossKind::GivenUp, u64::from(row.restarts)));
            let lost = (row.lost > 0).then_some((LossKind::SamplesLost, row.lost));
            let name = row.name.clone();
            let found = [given_up, lost].into_iter().flatten();
            found.map(move |(kind, count)| Loss { partition: name.clone(), kind, count, detail: String::new() })
        };
        rows.iter().flat_map(of_row).collect()
    }

    /// What the recorder left beside the `results` when the disk of the recording was full.
    #[must_use]
    pub fn of_recording(results: &Path) -> Option<Self> {
        let detail = std::fs::read_to_string(results.with_extension("stopped")).ok()?;
        Some(Loss { partition: "recorder".into(), kind: LossKind::RecordingStopped, count: 1, detail })
    }

    /// As an entry of `loss` in the object that `--json` prints.
    #[must_use]
    pub fn json(&self) -> Value {
        let kind = match self.kind {
            LossKind::GivenUp => "given_up",
            LossKind::SamplesLost => "samples_lost",
            LossKind::RecordingStopped => "recording_stopped",
        };
        let mut object = json!({ "partition": self.partition, "kind": kind, "count": self.count });
        if !self.detail.is_empty() {
            object["detail"] = json!(self.detail);
        }
        object
    }
}

impl Display for Loss {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        let Loss { partition, kind, count, detail } = self;
        let samples = if *count == 1 { "sample" } else { "samples" };
        match kind {
            LossKind::GivenUp => write!(to, "{partition} was given up after {count} restarts"),
            LossKind::SamplesLost => write!(to, "{partition} lost {count} {samples}"),
            LossKind::RecordingStopped => write!(to, "{detail}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_loss_is_told_and_restarts_and_rejected_samples_alone_are_none() {
        let row = |name: &str| PartitionRow { name: name.into(), restarts: 3, bad: 2, ..PartitionRow::default() };
        assert!(Loss::all(&[row("slosh-id")]).is_empty());
        let rows = [PartitionRow { given_up: true, ..row("slosh-id") }, PartitionRow { lost: 1, ..row("modal-id") }];
        let told: Vec<String> = Loss::all(&rows).iter().map(Loss::to_string).collect();
        assert_eq!(told, ["slosh-id was given up after 3 restarts", "modal-id lost 1 sample"]);
    }
}
