//! `obsid digest FILE.mcap`: identity of the recorded estimates, modes and verdicts.

use crate::{Failure, print};
use std::path::PathBuf;

/// Identity (BLAKE3) of the estimates, modes and verdicts in a recording
#[derive(clap::Args)]
pub struct Arguments {
    /// A recording made by obsid
    file: PathBuf,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let recorded = recording::read_mcap_topics(&arguments.file, telemetry::is_result).map_err(Failure::input)?;
    let digest = recording::digest(&recorded).map_err(Failure::input)?;
    let topics: serde_json::Map<String, serde_json::Value> =
        digest.counts.iter().map(|(topic, count)| (topic.to_string(), (*count).into())).collect();
    if arguments.json {
        print(&format!("{}\n", serde_json::json!({ "digest": digest.hex, "samples": topics })));
    } else {
        print(&format!("{}\n", digest.hex));
        for (topic, count) in &topics {
            print(&format!("{count:>8}  {topic}\n"));
        }
    }
    Ok(())
}
