//! `obsid gateway`: real sensors through the partitions.

use crate::run::{self, Common};
use crate::scenario_run::LinkKind;
use crate::{Failure, scenario_file};
use runtime::config::ReplayConfig;
use runtime::feed::FeedConfig;
use std::path::{Path, PathBuf};
use telemetry::Domain;

/// Identify from real sensors: drivers write samples to a socket
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid gateway /run/obsid/sensors --scenario craft.toml --duration 600   ten minutes of what drivers write
  obsid gateway /tmp/s --scenario craft.toml --duration 60 --record flight.mcap --json
A driver connects to the socket and writes samples as `obsid icd --c-header` lays them out (deploy/examples/imu-driver).
Counted in the result: samples received, late, duplicate, surplus, bad; frames without a sample.")]
pub struct Arguments {
    /// Unix socket that drivers connect to; it is made
    socket: PathBuf,
    /// What is known of the craft and what is to be identified
    #[arg(long, value_name = "FILE")]
    scenario: PathBuf,
    /// Length of the experiment [s]
    #[arg(long, value_name = "S", value_parser = seconds)]
    duration: f64,
    /// A frame waits so long for samples of its time [ms]
    #[arg(long, value_name = "MS", default_value_t = 20)]
    lateness_ms: u64,
    /// Without a sample for so long frames go on by the clock [ms]
    #[arg(long, value_name = "MS", default_value_t = 1000)]
    silence_ms: u64,
    #[command(flatten)]
    common: Common,
}

/// Forms frames of what drivers write and sends them through the partitions.
///
/// # Errors
/// [`Failure::Input`] where the scenario or the socket's place cannot be used; [`Failure::Run`]
/// where the run fails.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let wrong = |help: &'static str, what: String| Failure::Input(miette::miette!(help = help, "{what}"));
    if arguments.common.link == LinkKind::Lockstep {
        return Err(wrong("use --link shm", "--link lockstep: drivers are processes, lockstep has none".into()));
    }
    let opened = scenario_file::read(&arguments.scenario)?;
    let scenario = &opened.scenario;
    let named = [
        (Domain::Inertial, scenario.inertial.is_some() || scenario.mated.is_some()),
        (Domain::Slosh, scenario.slosh.is_some()),
        (Domain::Modal, scenario.modal.is_some()),
    ];
    let domains: Vec<Domain> = named.iter().filter(|(_, is)| *is).map(|(domain, _)| *domain).collect();
    if domains.is_empty() {
        return Err(wrong(
            "plan one of [modal], [slosh], [inertial], [mated] with what is known, as in deploy/scenarios/replay-r1.toml",
            format!("{}: the scenario plans no experiment", arguments.scenario.display()),
        ));
    }
    let socket = std::path::absolute(&arguments.socket).unwrap_or_else(|_| arguments.socket.clone());
    if !socket.parent().is_some_and(Path::is_dir) {
        let cure = "give the path of a socket in a folder that exists, such as /run/obsid/sensors";
        return Err(wrong(cure, format!("{}: its folder does not exist", socket.display())));
    }
    let frames = scenario.frames(arguments.duration).max(1) + 1;
    let replay = ReplayConfig { path: socket.clone(), channel_map: None, frames, domains };
    let mut run = run::config(opened, &arguments.common, Some(replay))?;
    run.config.feed = Some(FeedConfig {
        socket,
        lateness_ns: arguments.lateness_ms * 1_000_000,
        silence_ns: arguments.silence_ms * 1_000_000,
        // Beside the run's results; `run::carry_out` gives it its place.
        journal: PathBuf::new(),
    });
    run::carry_out(run, &arguments.common)
}

fn seconds(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value: &f64| value.is_finite() && *value > 0.0).ok_or("a number above 0".into())
}
