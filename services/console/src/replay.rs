//! `obsid replay`: a recording through the partitions.

use crate::intake::{self, IntakeArguments};
use crate::plants::utf8_text;
use crate::run::{self, Common};
use crate::{Failure, scenario_file};
use plant_file::scenario::Scenario;
use recording::{ChannelMap, Channels, Imported, ReplayFrames};
use runtime::config::ReplayConfig;
use std::path::{Path, PathBuf};
use telemetry::Domain;

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
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// Sends a recording through the partitions and shows what they identify.
///
/// # Errors
/// [`Failure::Input`] where scenario, map or recording cannot be used; [`Failure::Run`] where the
/// run fails.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.intake.list {
        return intake::list(&[&arguments.recording], &arguments.intake, arguments.common.json);
    }
    let opened = match &arguments.scenario {
        Some(path) => scenario_file::read(path)?,
        None => scenario_file::no_scenario()?,
    };
    let replay = inspect(&arguments.recording, &arguments.intake, &opened.scenario)?;
    if arguments.common.record.as_deref().is_some_and(|record| is_same_file(record, &arguments.recording)) {
        return Err(Failure::Input(miette::miette!(
            help = "give --record another file",
            "{}: --record would write over the recording that is replayed",
            arguments.recording.display()
        )));
    }
    run::carry_out(run::config(opened, &arguments.common, Some(replay))?, &arguments.common)
}

fn is_same_file(one: &Path, other: &Path) -> bool {
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

/// Reads the recording before anything is started: what is wrong with it is said here.
fn inspect(path: &Path, said: &IntakeArguments, scenario: &Scenario) -> Result<ReplayConfig, Failure> {
    let (channel_map, name) = map_text(said)?;
    let parsed = channel_map.as_deref().map(|text| ChannelMap::of_replay(&name, text)).transpose();
    let (intake, parsed) = parsed.map_err(Failure::input)?.unwrap_or_default();
    let imported = recording::read_with(path, &intake).map_err(Failure::input)?;
    let frames = ReplayFrames::new(&imported, parsed.as_ref(), scenario.period_ns()).map_err(Failure::input)?;
    for note in frames.notes() {
        crate::tell(&format!("{}: {note}", path.display()));
    }
    let carries = frames.identifiable();
    let named =
        scenario.modal.is_some() || scenario.slosh.is_some() || scenario.inertial.is_some() || scenario.mated.is_some();
    let identifiable = [
        (Domain::Inertial, carries.inertial && (scenario.inertial.is_some() || scenario.mated.is_some())),
        (Domain::Slosh, carries.slosh && scenario.slosh.is_some()),
        (Domain::Modal, carries.modal && (scenario.modal.is_some() || !named)),
    ];
    let replay = ReplayConfig {
        path: std::path::absolute(path).unwrap_or_else(|_| path.into()),
        channel_map,
        frames: frames.frame_count(),
        domains: identifiable.iter().filter(|(_, can_be)| *can_be).map(|(domain, _)| *domain).collect(),
    };
    if !replay.domains.is_empty() {
        return Ok(replay);
    }
    Err(nothing_to_identify(path, &carries, named, &found(&imported, parsed.as_ref())))
}

/// What is said as the text of a map, and whose text it is: the partitions read it again.
fn map_text(said: &IntakeArguments) -> Result<(Option<String>, String), Failure> {
    let alone = said.time_column.is_none() && said.channel.is_empty() && said.dataset.is_none();
    match &said.map {
        Some(file) if alone => {
            let text = utf8_text(file).map_err(|(message, cure)| {
                let cure =
                    cure.unwrap_or_else(|| "give --map the path of a map file, see `obsid replay --help`".into());
                Failure::Input(miette::miette!(help = cure, "{message}"))
            })?;
            Ok((Some(text), file.display().to_string()))
        }
        None if alone => Ok((None, String::new())),
        _ => Ok((Some(said.intake(None)?.to_map_text()), "the options".into())),
    }
}

/// Channels found in a table, for a message.
fn found(imported: &Imported, map: Option<&ChannelMap>) -> String {
    let Imported::Table(table) = imported else { return "a recorded run".into() };
    let Ok(channels) = Channels::find(table, map) else { return String::new() };
    channels.found().map(|(channel, _)| channel.name).collect::<Vec<_>>().join(", ")
}

fn nothing_to_identify(path: &Path, carries: &recording::Domains, named: bool, found: &str) -> Failure {
    let mut missing = Vec::new();
    if carries.slosh && !named {
        missing.push(
            "slosh needs the hub's mass: --scenario with [slosh.known] m_0_kg (see deploy/scenarios/replay-r1.toml)",
        );
    }
    if carries.inertial && !named {
        missing.push("inertial parameters need the momentum and a prior: --scenario with [inertial.known]");
    }
    if missing.is_empty() {
        missing.push(
            "slosh needs a force and an acceleration along one axis, modes need accelerometers (accel.1, ...), inertial \
             parameters need imu.rate_z with two joints' angles and rates; columns of other names are mapped with --map",
        );
    }
    if named {
        missing.push("the scenario must have the section of what is to be identified: [slosh], [modal], [inertial]");
    }
    Failure::Input(miette::miette!(
        help = missing.join("; "),
        "{}: nothing can be identified from this recording{} (channels found: {found})",
        path.display(),
        if named { " and scenario" } else { "" }
    ))
}
