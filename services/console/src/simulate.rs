//! `obsid simulate`: the recording that a plant's sensors would make.

mod inputs;

use crate::intake::{self, IntakeArguments};
use crate::progress::Share;
use crate::{Failure, plants};
use channels::{Channel, Recording};
use dynamics::description::Plant;
use report::text::short;
use serde_json::json;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Most memory that a simulated record takes \[bytes\]: a quarter of a small machine's 8 GiB, since
/// what is written is held once more.
const RECORD_MAX: f64 = 2.0 * 1024.0 * 1024.0 * 1024.0;
/// Time and value of a sample \[bytes\].
const SAMPLE: f64 = 16.0;

/// Simulate a plant file and write what its sensors and commands say
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid simulate deploy/plants/drive_rig.toml --out rig.csv
  obsid simulate deploy/plants/drive_rig.toml --hide 'joint_coulomb@joint:drive force=0.3' --out hidden.mcap
  obsid simulate augmented.toml --inputs rig.csv --out predicted.csv      the commands of a recording through a plant, without noise
  obsid simulate deploy/plants/pendulum.toml --set 'bar.mass = 1.2 kg' --seed 7 --duration 30 --out run.csv.gz

What is hidden leaves no trace in the file; `obsid effects` lists what can be hidden. A file that exists is replaced, once the new one
is whole.")]
pub struct Arguments {
    /// A plant file, or the name of one that comes with the program (see deploy/plants)
    plant: PathBuf,
    /// An effect that the plant carries besides, 'KIND@SITE name=value ...'; may be repeated
    #[arg(long, value_name = "EFFECT")]
    hide: Vec<String>,
    /// Another value of a number, 'NAME = VALUE UNIT', names as `obsid plant parameters` lists
    /// them; may be repeated
    #[arg(long, value_name = "NUMBER")]
    set: Vec<String>,
    /// The same seed gives the same recording
    #[arg(long, default_value_t = 1, conflicts_with = "inputs")]
    seed: u64,
    /// Length [s]; the plant file's where none is given
    #[arg(long, value_name = "S", conflicts_with = "inputs")]
    duration: Option<f64>,
    /// A recording: its commands drive the plant, as long as it lasts, from the state it begins in;
    /// the prediction has no noise
    #[arg(long, value_name = "FILE")]
    inputs: Option<PathBuf>,
    /// Where a prediction begins
    #[arg(long, value_enum, default_value_t = inputs::Start::Recording, requires = "inputs")]
    start: inputs::Start,
    /// Where to write: .csv, .csv.gz or .mcap
    #[arg(long, value_name = "FILE", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// What was written as one JSON object on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// # Errors
/// [`Failure::Input`] for a plant or an effect that cannot be, [`Failure::Run`] when the file
/// cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let (true, Some(file)) = (arguments.intake.list, &arguments.inputs) {
        return intake::list(&[file], &arguments.intake, arguments.json);
    }
    inputs::are_given(arguments.inputs.as_deref(), &arguments.intake)?;
    let out = arguments.out.as_deref().ok_or_else(|| Failure::Run("--out FILE is missing".into()))?;
    let mut plant = plants::read(&arguments.plant)?;
    change(&mut plant, &arguments.set, &arguments.hide)?;
    may_be_written(&arguments.plant, out)?;
    let mut duration_s = duration(arguments.duration, &plant)?;
    if let Some(file) = &arguments.inputs {
        may_be_written(file, out)?;
        (plant, duration_s) = inputs::driven(&plant, (file, arguments.start), &arguments.intake)?;
    }
    let bar = Share::new("simulated");
    let recording = simulation::record(&plant, arguments.seed, duration_s, &mut |share| bar.show(share));
    bar.end();
    let recording = recording.map_err(|error| {
        let help =
            "`obsid plant check FILE` says what the plant itself lacks; --set and --hide may ask for what cannot be";
        Failure::Input(miette::miette!(help = help, "{}: {error}", arguments.plant.display()))
    })?;
    let mut recording = Recording { name: out.display().to_string(), ..recording };
    recording.channels.iter_mut().try_for_each(with_unit_of_files)?;
    let notes = recording::write_series(&recording, out).map_err(Failure::input)?;
    notes.iter().for_each(|note| crate::tell(&format!("note: {note}")));
    crate::print(&if arguments.json {
        summary_json(arguments, duration_s, &recording)
    } else {
        summary(duration_s, &recording)
    });
    Ok(())
}

/// The length asked for, else the plant file's.
///
/// # Errors
/// [`Failure::Input`]: less than a control period, no number of seconds, or more than memory holds.
pub fn duration(requested_s: Option<f64>, plant: &Plant) -> Result<f64, Failure> {
    let (duration_s, period_s) = (requested_s.unwrap_or(plant.simulation.duration_s), plant.simulation.period_s);
    let whose = if requested_s.is_some() { "--duration" } else { "[simulation] duration" };
    let refuse = |cure: String, what: String| Err(Failure::Input(miette::miette!(help = cure, "{whose} {what}")));
    if !(duration_s >= period_s && duration_s.is_finite()) {
        let cure = format!("give seconds, at least one control period ({period_s} s)");
        return refuse(cure, format!("{duration_s}: the plant's control period is {period_s} s"));
    }
    // what no memory holds is found out now, not after an hour
    let channels = (plant.sensors.len() + plant.actuators.len()).max(1);
    let bytes_a_second = SAMPLE * channels as f64 / period_s;
    if duration_s * bytes_a_second > RECORD_MAX {
        let gib = |bytes: f64| short(bytes / f64::from(1 << 30));
        let (need, most) = (gib(duration_s * bytes_a_second), gib(RECORD_MAX));
        let cure = format!(
            "give at most {} s, or a longer period in [simulation] of the plant file",
            short((RECORD_MAX / bytes_a_second).floor())
        );
        let what = format!(
            "{duration_s} s of {channels} channels every {period_s} s take {need} GiB of memory, at most {most} GiB"
        );
        return refuse(cure, what);
    }
    Ok(duration_s)
}

/// A place that cannot be written, and a plant file that would be overwritten, are found out before
/// the simulation.
fn may_be_written(plant: &Path, out: &Path) -> Result<(), Failure> {
    let refuse = |help: &str, what: &str| {
        Err(Failure::Input(miette::miette!(help = help.to_owned(), "--out {}: {what}", out.display())))
    };
    let name = out.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    if ![".csv", ".csv.gz", ".mcap"].iter().any(|ending| name.ends_with(ending) && name.len() > ending.len()) {
        return refuse("end it in .mcap, .csv or .csv.gz", "the name says no format that is written");
    }
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return refuse("make the folder first", "its folder does not exist");
    }
    if out.is_dir() {
        return refuse("give the path of a file", "this is a folder");
    }
    if matches!((plant.canonicalize(), out.canonicalize()), (Ok(one), Ok(other)) if one == other) {
        return refuse("give --out another file", "it would write over a file that is read");
    }
    Ok(())
}

/// Applies `--set` and `--hide` to a plant.
///
/// # Errors
/// [`Failure::Input`].
pub fn change(plant: &mut Plant, set: &[String], hide: &[String]) -> Result<(), Failure> {
    // all at once: an inertia can only be scaled as a whole
    plant_file::set_all(plant, set).map_err(|reason| refused("--set", &set.join("', '"), &reason))?;
    for text in hide {
        let effect = plant_file::parse_effect(plant, text).map_err(|reason| refused("--hide", text, &reason))?;
        for doubt in plant_file::effect_warnings(plant, &effect) {
            crate::tell(&format!("warning: --hide '{text}': {doubt}"));
        }
        plant.effects.push(effect);
    }
    Ok(())
}

fn refused(flag: &str, text: &str, reason: &str) -> Failure {
    let help = match flag {
        "--hide" => {
            "as in 'joint_coulomb@joint:NAME force=0.3'; `obsid effects --plant FILE` lists kinds, sites and names"
        }
        _ => "as in 'link_1.mass = 12 kg'; `obsid plant parameters FILE` lists the names",
    };
    Failure::Input(miette::miette!(help = help, "{flag} '{text}': {reason}"))
}

/// Spells the unit of a channel as files do.
///
/// # Errors
/// [`Failure::Run`]: recordings have no such unit.
pub fn with_unit_of_files(channel: &mut Channel) -> Result<(), Failure> {
    let unit = recording::units::unit_named(&channel.unit).ok_or_else(|| {
        Failure::Run(format!("channel '{}': recordings have no unit '{}'", channel.name, channel.unit))
    })?;
    channel.unit = unit.si.to_owned();
    Ok(())
}

fn summary(duration_s: f64, recording: &Recording) -> String {
    let mut text = format!("{:<28} {:<10} {:>10} {:>14} {:>14}\n", "channel", "unit", "samples", "least", "greatest");
    for channel in &recording.channels {
        let (least, greatest) = extremes(&channel.value);
        let _ = writeln!(
            text,
            "{:<28} {:<10} {:>10} {least:>14.6e} {greatest:>14.6e}",
            channel.name,
            channel.unit,
            channel.value.len()
        );
    }
    let _ = writeln!(text, "\n{} channels, {duration_s} s -> {}", recording.channels.len(), recording.name);
    text
}

fn summary_json(arguments: &Arguments, duration_s: f64, recording: &Recording) -> String {
    let channel = |channel: &Channel| {
        let (least, greatest) = extremes(&channel.value);
        json!({ "name": channel.name, "unit": channel.unit, "samples": channel.value.len(), "least": least, "greatest": greatest })
    };
    let channels: Vec<_> = recording.channels.iter().map(channel).collect();
    format!(
        "{}\n",
        json!({ "out": recording.name, "seed": arguments.seed, "duration_s": duration_s, "channels": channels })
    )
}

/// (0, 0) of a channel without samples.
fn extremes(values: &[f64]) -> (f64, f64) {
    let fold = |better: fn(f64, f64) -> f64| values.iter().copied().reduce(better).unwrap_or(0.0);
    (fold(f64::min), fold(f64::max))
}
