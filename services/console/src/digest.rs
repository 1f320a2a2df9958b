//! `obsid digest FILE.mcap`: identity of the recorded estimates, modes and verdicts.

use crate::{Failure, print};
use std::path::{Path, PathBuf};

/// Identity (BLAKE3) of the estimates, modes and verdicts in a recording
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid digest flight.mcap           equal digests: the same results, sample for sample
  obsid digest flight.mcap --json    and how many samples of each topic")]
pub struct Arguments {
    /// A recording made by obsid (MCAP)
    file: PathBuf,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// Prints the digest of the results in a recording, one line or JSON.
///
/// # Errors
/// [`Failure::Input`] where the file is no MCAP of a run, or is damaged.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    check_is_mcap(&arguments.file)?;
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

/// A table holds no results: said before its bytes are called a corrupt MCAP.
fn check_is_mcap(path: &Path) -> Result<(), Failure> {
    let format = match recording::format_name(path) {
        Ok("mcap") => return Ok(()),
        Ok(format) => format,
        Err(recording::RecordingError::UnknownFormat { .. }) if path.is_file() => "unknown format",
        Err(error) => return Err(Failure::input(error)),
    };
    Err(Failure::Input(miette::miette!(
        help =
            "only a run has a digest: `obsid run --record FILE.mcap`, or `obsid replay RECORDING --record FILE.mcap`",
        "{}: not an MCAP file ({format})",
        path.display()
    )))
}
