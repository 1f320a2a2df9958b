//! `obsid identify`: the numbers of one vehicle from all its recordings together.
//!
//! The command line joins recordings with plant files, calls [`identification::joint`] and shows
//! the estimate; it decides nothing.

pub(crate) mod base;
pub(crate) mod conflicts;
mod object;
mod words;

use crate::beside::divided;
use crate::intake::IntakeArguments;
use crate::progress::Share;
use crate::recordings::{self, Evidence};
use crate::{Failure, interrupt, plants};
use base::BaseRow;
use conflicts::Conflict;
use identification::joint::{Arc, JointError, JointFit, Vehicle, identify, predict};
use identification::problem::Problem;
use identification::work::{Watch, Work};
pub(crate) use object::status;
use std::path::{Path, PathBuf};

/// Estimate the numbers of one vehicle from all its recordings, each with a plant file of its own
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid identify E1.csv E3.csv --plant craft.toml                           two recordings of one plant file, jointly
  obsid identify E1.csv=e1.toml E2.csv=e2.toml --predict E4.csv=e4.toml     each with its own commands and rates
  obsid identify swing.csv --plant pendulum.toml --json                     parameters[], arcs[], predicted[] as one object

A number of one name is one number for all recordings; with scope = \"per recording\" each has its own.
Estimated is what the plant files give a sigma. A number with two priors is an error.
Priors count once, every sample once; sigmas are those of the joint posterior. Planar craft also get their base parameters.
`identified` leaves less than a third of the prior's sigma, `not excited` more than 99 % of it.")]
pub struct Arguments {
    /// RECORDING, or RECORDING=PLANT where it has a plant file of its own; divided at the last '='
    #[arg(required = true, value_name = "RECORDING[=PLANT]")]
    recordings: Vec<String>,
    /// Plant file of the recordings that name none
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// Another recording, predicted with the estimate and not fitted; may be repeated
    #[arg(long, value_name = "RECORDING[=PLANT]")]
    predict: Vec<String>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
    /// Threads of work; all cores where none are given; the result is the same
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// A recording joined with its plant.
struct Read {
    file: String,
    digest: String,
    plant_file: String,
    notes: Vec<String>,
    arc: Arc,
}

/// All that is shown.
struct Identified<'a> {
    read: &'a [Read],
    vehicle: &'a Vehicle<'a>,
    fit: JointFit,
    base: Vec<BaseRow>,
    /// Mean squares of the whitened innovations of what was not fitted.
    predicted: Vec<(&'a Read, f64)>,
}

impl Identified<'_> {
    /// Physical parameters that contradict their priors.
    fn conflicts(&self) -> Vec<Conflict> {
        let rows = self.vehicle.unknowns.iter().enumerate().map(|(k, unknown)| {
            (&unknown.name[..], [self.fit.theta[k], self.fit.sigma[k]], [unknown.prior, unknown.sigma])
        });
        conflicts::conflicts(rows)
    }
}

/// # Errors
/// [`Failure::Input`] for recordings and plants that cannot be used together,
/// [`Failure::Interrupted`] once what was known by then is shown.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.intake.list {
        let files: Vec<PathBuf> = arguments.recordings.iter().map(|text| divided(text).0).collect();
        let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        return crate::intake::list(&files, &arguments.intake, arguments.json);
    }
    let mut names = Vec::new();
    let fitted = read_all(&arguments.recordings, arguments, &mut names)?;
    let held_out = read_all(&arguments.predict, arguments, &mut names)?;
    used_twice(&fitted, &held_out)?;
    let watch = Watch::stopped_by(interrupt::flag()?);
    let work = std::sync::Arc::new(Work::watched(f64::INFINITY, watch.clone()));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments.threads.map_or(cores, usize::from);
    let arcs: Vec<Arc> = fitted.iter().map(|one| one.arc.clone()).collect();
    let vehicle = Vehicle::new(&arcs, threads, work).map_err(refused)?;
    let bar = Share::new("identified");
    let fit = identify(&vehicle, &mut |_, share| bar.show(share));
    bar.end();
    let fit = match fit {
        Err(JointError::Interrupted) => return Err(interrupted(arguments.json)),
        found => found.map_err(refused)?,
    };
    let predicted = held_out.iter().filter(|_| !fit.interrupted);
    let predicted = predicted.map(|one| Ok((one, predict(&vehicle, &fit, &one.arc).map_err(refused)?)));
    let predicted = predicted.collect::<Result<_, Failure>>()?;
    let base = base::rows(&vehicle, &fit);
    let found = Identified { read: &fitted, vehicle: &vehicle, fit, base, predicted };
    crate::print(&if arguments.json {
        format!("{}\n", object::object(&found, &again(arguments)))
    } else {
        words::in_words(&found)
    });
    if found.fit.interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

fn refused(error: JointError) -> Failure {
    let cure = error.cure();
    Failure::Input(miette::miette!(help = cure, "{error}"))
}

fn interrupted(json: bool) -> Failure {
    crate::print(if json {
        "{\"interrupted\":true,\"parameters\":[],\"arcs\":[],\"predicted\":[]}\n"
    } else {
        "interrupted: nothing is known before all recordings were heard\n"
    });
    Failure::Interrupted
}

fn read_all(texts: &[String], arguments: &Arguments, names: &mut Vec<String>) -> Result<Vec<Read>, Failure> {
    let mut all = Vec::new();
    for text in texts {
        let (recording, plant) = divided(text);
        let plant = plant.or_else(|| arguments.plant.clone()).ok_or_else(|| {
            Failure::Input(miette::miette!(
                help = format!("give {text}=PLANT.toml, or --plant FILE for all that name none"),
                "{text}: which plant file belongs to it is not said"
            ))
        })?;
        all.extend(read_one(&recording, &plant, arguments, names)?);
    }
    Ok(all)
}

/// The recordings of one file: several where time starts again.
fn read_one(
    recording: &Path,
    plant_file: &Path,
    arguments: &Arguments,
    names: &mut Vec<String>,
) -> Result<Vec<Read>, Failure> {
    let plant = plants::read(plant_file)?;
    let intake = arguments.intake.intake(Some(&plant))?;
    let Evidence::Time(loaded) = recordings::read_evidence(recording, &intake, &plant)? else {
        return Err(Failure::Input(miette::miette!(
            help = "`obsid diagnose` and `obsid modal` take spectra; identify takes time records",
            "{}: this is a spectrum",
            recording.display()
        )));
    };
    let mut all = Vec::new();
    for one in loaded {
        let problem = Problem::new(&plant, std::slice::from_ref(&one.recording), &[]).map_err(|error| {
            let cure = error.cure(&plant_file.display().to_string());
            Failure::Input(miette::miette!(help = cure, "{error}"))
        })?;
        let notes = one.notes.iter().chain(&problem.notes).cloned().collect();
        let name = short_name(&one.recording.name, names);
        let arc = Arc { name, problem };
        all.push(Read { file: one.file, digest: one.digest, plant_file: plant_file.display().to_string(), notes, arc });
    }
    Ok(all)
}

/// The file's name without folder and endings, numbered where another has it.
fn short_name(path: &str, names: &mut Vec<String>) -> String {
    let (file, part) = path.split_once(", part ").map_or((path, None), |(file, part)| (file, Some(part)));
    let stem = Path::new(file).file_name().map_or(file.to_owned(), |name| name.to_string_lossy().into_owned());
    let stem = stem.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or(&stem).to_owned();
    let stem = part.map_or(stem.clone(), |part| format!("{stem}.{part}"));
    let mut name = stem.clone();
    let mut count = 1;
    while names.contains(&name) {
        count += 1;
        name = format!("{stem}#{count}");
    }
    names.push(name.clone());
    name
}

fn used_twice(fitted: &[Read], held_out: &[Read]) -> Result<(), Failure> {
    let same =
        held_out.iter().find(|one| fitted.iter().any(|other| other.digest == one.digest && !one.digest.is_empty()));
    same.map_or(Ok(()), |one| {
        Err(Failure::Input(miette::miette!(
            help = "data that were fitted prove no prediction: give another recording",
            "--predict {}: it is fitted, too",
            one.file
        )))
    })
}

/// The command that was given.
fn again(arguments: &Arguments) -> String {
    let mut words = vec!["obsid".to_owned(), "identify".to_owned()];
    words.extend(arguments.recordings.iter().cloned());
    words.extend(arguments.plant.iter().flat_map(|plant| ["--plant".to_owned(), plant.display().to_string()]));
    words.extend(arguments.predict.iter().flat_map(|one| ["--predict".to_owned(), one.clone()]));
    words.extend(arguments.intake.words());
    recordings::command_line(&words)
}
