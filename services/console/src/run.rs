//! `obsid run`: a scenario through the partitions.

use crate::launch;
use crate::outcome::Outcome;
use crate::partition;
use crate::scenario_run::{LinkKind, ScenarioRun};
use crate::scratch::{ResultsFile, Scratch};
use crate::{Failure, feed_counts, hidden, limits_file, preflight, scenario_file, table, trace_file};
use plant_file::scenario::{Opened, Scenario};
use runtime::RunConfig;
use runtime::config::{Fault, KillPoint, ReplayConfig, Sabotage};
use runtime::feed::FeedCounts;
use runtime::recordings::{self, RemovedRecordings};
use std::path::{Path, PathBuf};
use telemetry::PartitionId;

/// Simulate a scenario and identify it on the way
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid run                                    the default scenario
  obsid run --record flight.mcap               and keep every sample
  obsid run --trace flight.json                and what every process did when, for ui.perfetto.dev
  obsid run --link lockstep --seed 7 --json    in one thread, another seed, result as JSON
  obsid run --speed 1                          in real time
  obsid run --speed 1 --windows --json         each partition held to its CPU window (partitions[].cpu_window)
  obsid run --commands campaign.toml           with a stored sequence of commands
  obsid run --keep /var/lib/obsid              with the parameter tables that were activated last
  obsid run deploy/scenarios/study-case.toml   one craft, identified by all partitions together")]
pub struct Arguments {
    /// Scenario file; without one the benchmark's (deploy/scenarios/default.toml, built in)
    scenario: Option<PathBuf>,
    #[command(flatten)]
    pub common: Common,
    /// Simulated over real time at most; without it as fast as the slowest partition
    #[arg(long, value_name = "N", value_parser = positive)]
    speed: Option<f64>,
    /// Give each partition the CPU window of the table of limits (runtime_us in every period_ms):
    /// SCHED_DEADLINE, or what the system allows of it, which is said
    #[arg(long, requires = "speed")]
    windows: bool,
    /// Seed of every noise stream, and of a craft's numbers; without it the scenario's
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Physics that the craft carries and no partition models, as in a plant file's `hide`; may be
    /// repeated
    #[arg(long, value_name = "KIND@SITE name=value …")]
    hide: Vec<String>,
    /// Stored sequence of commands (see obsid command), or a recording whose commands are repeated
    #[arg(long, value_name = "FILE")]
    commands: Option<PathBuf>,
    /// Folder that keeps activated parameter tables and the log of restarts beyond the run; the run
    /// begins with the tables that it holds
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
}

/// What `run` and `replay` have in common.
#[derive(Default, clap::Args)]
pub struct Common {
    /// What carries the samples
    #[arg(long, value_enum, default_value = "shm")]
    pub link: LinkKind,
    /// Write every sample to this MCAP file
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Write frames, sends, waits, modes and restarts to this file, which ui.perfetto.dev opens
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// One JSON object on standard output, all else on standard error
    #[arg(long)]
    pub json: bool,
    /// Table of limits and actions per partition; without it deploy/partitions.toml, built in
    #[arg(long, value_name = "FILE")]
    pub partitions: Option<PathBuf>,
    /// Start each partition from its own binary in this folder, as in an on-board computer's image
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,
    /// Drill: switch a safeguard off
    #[arg(long, hide = true, value_parser = sabotage)]
    sabotage: Option<Sabotage>,
    /// Drill: kill a partition once, NAME@FRAME[:connect|frame|publish|checkpoint]
    #[arg(long, hide = true, value_parser = kill)]
    kill: Vec<Fault>,
    /// Drill: kill a partition in every life from this frame on, NAME@FRAME
    #[arg(long, hide = true, value_parser = kill_always)]
    kill_always: Vec<Fault>,
    /// Drill: a partition hangs, NAME@FRAME
    #[arg(long, hide = true, value_parser = hang)]
    hang: Vec<Fault>,
    /// Drill: a damaged sample goes out in this frame, or of a topic from it on, FRAME[:TOPIC]
    #[arg(long, hide = true, value_parser = corrupt)]
    corrupt: Vec<Fault>,
    /// Drill: a partition reports so many events in every frame, NAME@COUNT
    #[arg(long, hide = true, value_parser = flood)]
    flood: Vec<Fault>,
    /// Drill: a partition tries what it has no right to
    #[arg(long, hide = true, value_parser = probe)]
    probe: Vec<Fault>,
    /// Drill: shorter limits, milliseconds until a hang is called one
    #[arg(long, hide = true)]
    hang_ms: Option<u64>,
    /// Drill: seconds without a frame until a run has failed
    #[arg(long, hide = true)]
    stall_s: Option<u64>,
}

/// Runs a scenario as processes and shows the results beside the truth.
///
/// # Errors
/// [`Failure::Input`] where the scenario cannot be simulated; [`Failure::Run`] where the run fails
/// or misses what it needs.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let opened = match &arguments.scenario {
        Some(path) if arguments.hide.is_empty() => scenario_file::read(path)?,
        Some(path) => scenario_file::read_hiding(path, &arguments.hide)?,
        None if !arguments.hide.is_empty() => return Err(hidden::without_craft("the default scenario")),
        None => scenario_file::default_scenario()?,
    };
    can_be_simulated(&opened.scenario, arguments.scenario.as_deref())?;
    let mut run = config(opened, &arguments.common, None)?;
    run.config.seed = arguments.seed.unwrap_or(run.scenario.seed);
    run.config.speed = arguments.speed;
    run.config.windows = arguments.windows;
    order(&mut run.config, arguments.commands.as_deref(), arguments.keep.as_deref())?;
    carry_out(run, &arguments.common)
}

/// Commands and tables with which the run begins.
///
/// # Errors
/// [`Failure::Input`] for a sequence or a folder that cannot be used.
pub fn order(config: &mut RunConfig, commands: Option<&Path>, keep: Option<&Path>) -> Result<(), Failure> {
    if let Some(file) = commands {
        (config.commands, config.tables) = crate::command::read_sequence(file, &config.partitions)?;
    }
    if let Some(folder) = keep {
        if !folder.is_dir() {
            let cure = "make the folder: activated tables and the log of restarts are kept in it";
            return Err(Failure::Input(miette::miette!(help = cure, "{}: no such folder", folder.display())));
        }
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
        config.tables = crate::tables::stored_tables(&folder);
        config.keep = Some(folder);
    }
    Ok(())
}

/// A scenario for a recording states no plant: there is nothing to simulate.
fn can_be_simulated(scenario: &Scenario, file: Option<&Path>) -> Result<(), Failure> {
    let file = file.unwrap_or(Path::new("the default scenario")).display();
    let without_plant = [
        ("modal", scenario.modal.as_ref().is_some_and(|modal| modal.plant.is_none())),
        ("slosh", scenario.slosh.as_ref().is_some_and(|slosh| slosh.plant.is_none())),
        ("inertial", scenario.inertial.as_ref().is_some_and(|arm| arm.plant.is_none())),
        ("mated", scenario.mated.as_ref().is_some_and(|arm| arm.plant.is_none())),
    ];
    if let Some((name, _)) = without_plant.iter().find(|(_, missing)| *missing) {
        return Err(Failure::Input(miette::miette!(
            help = "state the plant as in deploy/scenarios/default.toml, or give this scenario to \
                    `obsid replay RECORDING --scenario FILE`",
            "{file}: {name}.plant is missing: there is nothing to simulate"
        )));
    }
    let benchmark = scenario.modal.is_some() || scenario.slosh.is_some() || scenario.inertial.is_some();
    if !benchmark && scenario.mated.is_none() && scenario.craft.is_none() {
        return Err(Failure::Input(miette::miette!(
            help = "plan one of [modal], [slosh], [inertial], [mated] at least, as in deploy/scenarios/default.toml, or a [craft], as in study-case.toml",
            "{file}: the scenario plans no experiment"
        )));
    }
    Ok(())
}

/// Runs, reads the results, shows them; of a run that failed as far as it got.
///
/// # Errors
/// [`Failure::Input`] when there is no place for the run or its recording, [`Failure::Run`] when it
/// failed, [`Failure::Degraded`] when it ended without all that it was to deliver.
pub fn carry_out(mut run: ScenarioRun, common: &Common) -> Result<(), Failure> {
    run.config.check_depths().map_err(Failure::Run)?;
    // Before there is anything that a signal could leave behind.
    let signals = launch::take_signals().map_err(|error| Failure::Run(format!("signals: {error}")))?;
    let scratch = Scratch::new()?;
    if let Some(record) = &common.record {
        make_room(&mut run.config, record);
    }
    let results = ResultsFile::new(common.record.as_deref(), &scratch)?;
    run.config.record = results.path().to_path_buf();
    if common.record.is_some() {
        run.config.results = Some(scratch.file("results.mcap"));
    }
    if let Some(feed) = &mut run.config.feed {
        feed.journal = scratch.file("feed.journal");
    }
    if common.link == LinkKind::Shm {
        preflight::check(scratch.root())?;
    }
    let traced = trace_folder(common, &scratch)?;
    run.config.trace.clone_from(&traced);
    let finished = launch::launch(&run, common.link, common.images.as_deref(), &scratch, signals);
    if let (Some(folder), Some(file)) = (&traced, &common.trace) {
        match trace_file::write(folder, &finished.deaths, file) {
            Ok(events) => crate::tell(&format!("{events} events -> {}", file.display())),
            Err(error) => crate::tell(&format!("{}: the trace cannot be written: {error}", file.display())),
        }
    }
    let recorded = run.config.results.as_ref().map_or_else(|| results.is_written(), |path| path.exists());
    let outcome = Outcome::read(&run, finished, recorded);
    let fed = run.config.feed.as_ref().and_then(|feed| runtime::feed::newest_counts(&feed.journal));
    crate::print(&shown(&outcome, fed.as_ref(), common.json));
    let losses = outcome.losses();
    match outcome.failure {
        Some(reason) => Err(Failure::Run(reason)),
        None if losses.is_empty() => Ok(()),
        None => Err(Failure::Degraded(losses.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))),
    }
}

/// Puts an earlier recording aside and removes the oldest, where the limits keep any.
pub fn make_room(config: &mut RunConfig, record: &Path) {
    let Some(older) = &config.limits.recording.older else { return };
    match recordings::make_room(record, older, runtime::sys::unix_ns() / 1_000_000_000) {
        Ok(removed) => config.removed = removed,
        Err(error) => crate::tell(&format!("{}: older recordings cannot be kept: {error}", record.display())),
    }
}

fn shown(outcome: &Outcome, fed: Option<&FeedCounts>, as_json: bool) -> String {
    if !as_json {
        return table::outcome(outcome) + &fed.map(feed_counts::sentence).unwrap_or_default();
    }
    let mut object = outcome.json();
    if let Some(counts) = fed {
        object["feed"] = feed_counts::json_of(counts);
    }
    format!("{object}\n")
}

/// Where processes leave their markers; that the file can be written is found out before the run.
fn trace_folder(common: &Common, scratch: &Scratch) -> Result<Option<PathBuf>, Failure> {
    let Some(file) = &common.trace else { return Ok(None) };
    let wrong = |what: String, cure: &'static str| Failure::Input(miette::miette!(help = cure, "{what}"));
    if common.link == LinkKind::Lockstep {
        return Err(wrong("--trace: in lockstep there are no processes to trace".into(), "use --link shm"));
    }
    let folder = scratch.file("trace");
    std::fs::File::create(file)
        .and_then(|_| std::fs::create_dir(&folder))
        .map_err(|error| {
            let cure = "--trace takes the path of a file, in a folder that exists and may be written to";
            wrong(format!("{}: cannot be written: {error}", file.display()), cure)
        })
        .map(|()| Some(folder))
}

/// The run that the arguments describe; where its results go is found out last, by [`carry_out`].
///
/// # Errors
/// When the table of limits cannot be used.
pub fn config(opened: Opened, common: &Common, replay: Option<ReplayConfig>) -> Result<ScenarioRun, Failure> {
    let partitions = partition::of_run(opened.scenario.craft.is_some());
    let table = limits_file::read(common.partitions.as_deref(), &partitions)?;
    let mut limits = table;
    limits.stall_s = common.stall_s.unwrap_or(limits.stall_s);
    if let Some(hang_ms) = common.hang_ms {
        limits.partitions.iter_mut().for_each(|row| row.hang_ms = hang_ms);
    }
    let Opened { mut scenario, text, files, .. } = opened;
    scenario.assume_rest(replay.is_some());
    let config = RunConfig {
        scenario: text,
        files,
        name: scenario.name.clone(),
        period_ns: scenario.period_ns(),
        seed: scenario.seed,
        window_frames: scenario.window_frames,
        checkpoint_frames: (scenario.window_frames / 4).max(1),
        replay,
        feed: None,
        record: PathBuf::new(),
        record_all: common.record.is_some(),
        trace: None,
        results: None,
        windows: false,
        speed: None,
        partitions,
        limits,
        tables: Vec::new(),
        keep: None,
        removed: RemovedRecordings::default(),
        commands: Vec::new(),
        sabotage: common.sabotage.unwrap_or_default(),
        faults: [&common.kill, &common.kill_always, &common.hang, &common.corrupt, &common.flood, &common.probe]
            .into_iter()
            .flatten()
            .copied()
            .collect(),
    };
    Ok(ScenarioRun { config, scenario })
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a number above 0".into()),
    }
}

fn sabotage(text: &str) -> Result<Sabotage, String> {
    let found = Sabotage::NAMES.iter().find(|(name, _)| *name == text);
    found.map(|(_, sabotage)| *sabotage).ok_or_else(|| format!("one of {}", names(Sabotage::NAMES)))
}

fn names<T>(list: &[(&'static str, T)]) -> String {
    list.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

fn place(text: &str) -> Result<(PartitionId, u64), String> {
    let (name, frame) = text.split_once('@').ok_or("NAME@FRAME")?;
    let partition = PartitionId::named(name).ok_or_else(|| format!("no partition is called '{name}'"))?;
    Ok((partition, frame.parse().map_err(|_| format!("'{frame}' is not a frame number"))?))
}

fn kill(text: &str) -> Result<Fault, String> {
    let (text, point) = text.split_once(':').unwrap_or((text, "frame"));
    let (partition, frame) = place(text)?;
    let found = KillPoint::NAMES.iter().find(|(name, _)| *name == point);
    let (_, point) = *found.ok_or_else(|| format!("one of {}", names(KillPoint::NAMES)))?;
    Ok(Fault::Kill { partition, frame, point })
}

fn kill_always(text: &str) -> Result<Fault, String> {
    place(text).map(|(partition, frame)| Fault::KillAlways { partition, frame })
}

fn hang(text: &str) -> Result<Fault, String> {
    place(text).map(|(partition, frame)| Fault::Hang { partition, frame })
}

fn flood(text: &str) -> Result<Fault, String> {
    let (partition, events) = place(text)?;
    let events = u32::try_from(events).map_err(|error| error.to_string())?;
    Ok(Fault::Flood { partition, events })
}

fn probe(text: &str) -> Result<Fault, String> {
    let partition = PartitionId::named(text).ok_or_else(|| format!("no partition is called '{text}'"))?;
    Ok(Fault::Probe { partition })
}

fn corrupt(text: &str) -> Result<Fault, String> {
    let (frame, topic) = text.split_once(':').map_or((text, None), |(frame, topic)| (frame, Some(topic)));
    let unknown = |name: &str| format!("no topic is called '{name}'; `obsid icd` lists them");
    let topic = topic.map(|name| telemetry::topic_named(name).ok_or_else(|| unknown(name))).transpose()?;
    frame.parse().map(|frame| Fault::Corrupt { frame, topic }).map_err(|_| format!("'{frame}' is not a frame number"))
}
