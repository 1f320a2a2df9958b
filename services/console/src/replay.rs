//! `obsid replay`: a recording through the partitions.

use crate::launch::ResultsFile;
use crate::run::{self, Common};
use crate::{Failure, scenario_file};
use recording::{ChannelMap, ReplayFrames};
use runtime::Scenario;
use runtime::config::ReplayConfig;
use std::path::{Path, PathBuf};

/// Play a recording through the partitions
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid replay slab.csv.gz                                          the channels decide what can be identified
  obsid replay r1.csv.gz --scenario deploy/scenarios/replay-r1.toml the scenario says what is known
  obsid replay log.csv --map map.toml                               own column names: [channels] imu.accel_x = \"ax [m/s^2]\"")]
pub struct Arguments {
    /// MCAP, CSV or CSV.gz (header `name [unit]`, first column `time [s]`)
    recording: PathBuf,
    /// What is known and what is needed
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Which column is which channel
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scenario = match &arguments.scenario {
        Some(path) => scenario_file::read(path)?,
        None => scenario_file::no_scenario(),
    };
    let replay = inspect(&arguments.recording, arguments.map.as_deref(), &scenario)?;
    let results = ResultsFile::new(arguments.common.record.as_deref());
    let run = run::config(scenario, &arguments.common, &results, Some(replay))?;
    run::carry_out(&run, &arguments.common)
}

/// Reads the recording before anything is started: what is wrong with it is said here.
fn inspect(path: &Path, map: Option<&Path>, scenario: &Scenario) -> Result<ReplayConfig, Failure> {
    let imported = recording::read(path).map_err(Failure::input)?;
    let channel_map = map.map(std::fs::read_to_string).transpose().map_err(|error| {
        Failure::Input(miette::miette!("{}: cannot be read: {error}", map.unwrap_or(Path::new("")).display()))
    })?;
    let parsed = match (map, &channel_map) {
        (Some(file), Some(text)) => Some(ChannelMap::parse(&file.display().to_string(), text).map_err(Failure::input)?),
        _ => None,
    };
    let frames = ReplayFrames::new(&imported, parsed.as_ref(), scenario.period_ns()).map_err(Failure::input)?;
    for note in frames.notes() {
        eprintln!("{}: {note}", path.display());
    }
    let carries = frames.identifiable();
    let named = scenario.modal.is_some() || scenario.slosh.is_some() || scenario.inertial.is_some() || scenario.mated.is_some();
    let replay = ReplayConfig {
        path: std::path::absolute(path).unwrap_or_else(|_| path.into()),
        channel_map,
        frames: frames.frame_count(),
        inertial: carries.inertial && (scenario.inertial.is_some() || scenario.mated.is_some()),
        slosh: carries.slosh && scenario.slosh.is_some(),
        modal: carries.modal && (scenario.modal.is_some() || !named),
    };
    if replay.inertial || replay.slosh || replay.modal {
        return Ok(replay);
    }
    Err(nothing_to_identify(path, &carries, named))
}

fn nothing_to_identify(path: &Path, carries: &recording::Domains, named: bool) -> Failure {
    let mut missing = Vec::new();
    if carries.slosh && !named {
        missing.push("slosh needs the hub's mass: --scenario with [slosh.known] m_0_kg");
    }
    if carries.inertial && !named {
        missing.push("inertial parameters need the momentum and a prior: --scenario with [inertial.known]");
    }
    if missing.is_empty() {
        missing.push("its channels serve none of the scenario's experiments; name them with --map");
    }
    Failure::Input(miette::miette!(
        help = missing.join("; "),
        "{}: nothing can be identified from this recording and scenario",
        path.display()
    ))
}
