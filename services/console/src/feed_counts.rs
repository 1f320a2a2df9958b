//! What became of the samples of real sensors, as a run's result shows it.

use runtime::feed::FeedCounts;
use serde_json::{Value, json};

/// Counts of the feed as the result's JSON has them.
pub fn json_of(counts: &FeedCounts) -> Value {
    json!({
        "received": counts.received, "late": counts.late, "duplicates": counts.duplicates,
        "surplus": counts.surplus, "bad": counts.bad, "empty_frames": counts.empty_frames,
        "strangers": counts.strangers,
    })
}

/// Counts of the feed in a sentence.
pub fn sentence(counts: &FeedCounts) -> String {
    let FeedCounts { received, late, duplicates, surplus, bad, empty_frames, strangers } = counts;
    format!(
        "feed: {received} samples, {late} late, {duplicates} duplicate, {surplus} surplus, {bad} bad; \
         {empty_frames} frames without a sample, {strangers} drivers disconnected\n"
    )
}
