//! `obsid diagnose`: physics that a plant file does not model, according to recordings.
//!
//! The command line reads and renames the recordings, calls [`discovery::diagnose`] and shows the
//! diagnosis: as a table for a terminal, as JSON, and with `--out` as a page with figures beside
//! the files that go on (augmented plant, next experiment). It decides nothing.

mod answer;
mod features;
mod figures;
mod files;
mod labels;
mod modes_file;
mod names;
mod object;
mod page;
mod paragraph;
mod responses;
mod sensor_names;
mod summary;
mod words;

use crate::beside::{plant_of, required};
use crate::effort::Effort;
use crate::intake::{self, IntakeArguments};
use crate::phases::{Phases, Shown, Stage};
use crate::recordings::{self, Evidence, Loaded};
use crate::{Failure, interrupt, plants};
use channels::Recording;
use discovery::against_plant::examine_beside;
use discovery::diagnose::{Diagnosis, Options, Phase};
use discovery::evidence::{self, labels::diagnose_beside_labels};
use discovery::mislabelled::Mislabelled;
use discovery::planned_work;
use dynamics::description::Plant;
use examination::doctor::Finding;
use files::OutFiles;
use identification::problem::Problem;
use identification::work::{LABEL_CHECK_SHARE, Watch, Work};
use labels::{Labels, look_at_labels};
use modes_file::ModesFile;
use recording::Spectrum;
use std::path::{Path, PathBuf};

/// Find the physics that a plant file does not model: locate, name, model, confirm on held-out data
#[derive(clap::Args, Clone)]
#[command(after_help = "Examples:
  obsid diagnose swing.csv --plant pendulum.toml --out report      what is missing; report/report.html, report/augmented.toml
  obsid diagnose a.csv b.csv --plant rig.toml --held-out c.csv     fitted jointly to two, tested on a third
  obsid diagnose log.csv --plant rig.toml --map map.toml --json    your own column names; one JSON object
  obsid diagnose modes.json --plant panel.toml                     modes as `obsid modal --json` prints them, and their drift
  obsid diagnose panel.uff --plant panel.toml                      frequency responses: their frequencies, damping and shapes

A map is TOML, left the name in the plant, right the name in the recording:
  [channels]
  rate = \"gyro_z\"
  angle = { name = \"encoder\", scale = -1, unit = \"deg\" }

Without --held-out, blocks of the recordings are predicted from the others. Only what held-out data confirm enters augmented.toml.
Any diagnosis is an answer, also that nothing can be decided: the exit code is 0.
An interruption (Ctrl-C, kill -INT) prints what is known so far, with exit code 130; a second one ends the program at once.")]
pub struct Arguments {
    /// CSV, CSV.gz or MCAP; several are fitted jointly, a file in which time starts again is
    /// several. Or one magnitude spectrum, frequency responses of one structure (UFF, or CSV with
    /// columns `NAME_real`, `NAME_imag`), or one list of modes (.json, as `obsid modal --json`
    /// prints it). RECORDING=PLANT names its plant file, divided at the last '='
    #[arg(required = true, value_name = "RECORDING[=PLANT]")]
    recordings: Vec<PathBuf>,
    /// The plant file that is held against them, or the name of one that comes with the program
    #[arg(long, value_name = "FILE")]
    plant: Option<PathBuf>,
    /// Another recording of the plant, the same experiment once more or another one, predicted at
    /// the end with nothing fitted to it; may be given several times
    #[arg(long, visible_alias = "repeat", value_name = "RECORDING[=PLANT]")]
    held_out: Vec<PathBuf>,
    /// Write report.html, diagnosis.json, augmented.toml, next_experiment.toml to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
    /// How much may be computed before the search ends with what it has; counted, not timed
    #[arg(long, value_enum, default_value_t)]
    effort: Effort,
    /// Believe units, signs and names of all channels: none is suspected or corrected
    #[arg(long)]
    trust_labels: bool,
    /// Percent of the signal below which what the plant misses in free run is not worth a law
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0)]
    worth: f64,
    /// One line on standard error for each phase, also where it is no terminal: else a line for
    /// each tenth of the work, of one that takes more than about five seconds
    #[arg(long)]
    progress: bool,
    /// No progress on standard error
    #[arg(long, conflicts_with = "progress")]
    quiet: bool,
    /// Threads of work; all cores where none are given; the result is the same
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,
    #[command(flatten)]
    intake: IntakeArguments,
}

impl Arguments {
    fn shown(&self) -> Shown {
        match (self.quiet, self.progress) {
            (true, _) => Shown::Nothing,
            (_, true) => Shown::Phases,
            _ => Shown::Share,
        }
    }
}

/// What is diagnosed: a plant and the recordings that it should explain.
struct Case {
    plant: Plant,
    plant_file: String,
    plant_digest: String,
    fitted: Vec<Loaded>,
    held_out: Vec<Loaded>,
    /// Evidence over frequency, and the digest of its file.
    spectra: Vec<(Spectrum, String)>,
    /// Evidence that modes are: a list of them, or what the responses in `spectra` show.
    modes: Option<ModesFile>,
    command: String,
    /// Options that say what the files do not.
    said: Vec<String>,
    effort: Effort,
}

impl Case {
    /// The commands that show how `plant` follows a recording, one after another: that of the
    /// recording which nothing was fitted to, where there is one.
    fn commands_of_the_fit(&self, plant: &str) -> Vec<String> {
        let Some(record) = self.held_out.iter().chain(&self.fitted).next() else {
            let words = ["obsid", "simulate", plant, "--out", "predicted.csv"].map(str::to_owned);
            return vec![recordings::command_line(&words)];
        };
        let simulate = ["obsid", "simulate", plant, "--inputs", &record.file, "--out", "predicted.csv"];
        let compare = ["obsid", "compare", &record.file, "predicted.csv"];
        let line = |words: &[&str]| {
            let words = words.iter().map(|word| (*word).to_owned()).chain(self.said.iter().cloned());
            recordings::command_line(&words.collect::<Vec<_>>())
        };
        vec![line(&simulate), line(&compare)]
    }

    /// Those that are fitted first.
    fn time_records(&self) -> impl Iterator<Item = &Loaded> {
        self.fitted.iter().chain(&self.held_out)
    }

    /// All time records as they are read.
    fn readings(&self) -> Vec<Recording> {
        self.time_records().map(|one| one.recording.clone()).collect()
    }

    fn put_back(&mut self, read: Vec<Recording>) {
        let records = self.fitted.iter_mut().chain(&mut self.held_out);
        records.zip(read).for_each(|(one, read)| one.recording = read);
    }

    /// Puts what is mislabelled right, record by record.
    fn put_right(&mut self, labels: &[Option<Mislabelled>]) {
        let records = self.fitted.iter_mut().chain(&mut self.held_out);
        for (one, label) in records.zip(labels) {
            label.iter().for_each(|label| one.recording = label.cured(&one.recording));
        }
    }
}

/// What was found: per fitted recording what is wrong with it, and the diagnosis; its last three
/// fields are paths here.
struct Diagnosed {
    case: Case,
    findings: Vec<(usize, Finding)>,
    diagnosis: Diagnosis,
    /// The user ended it before its end.
    interrupted: bool,
    labels: Vec<Mislabelled>,
    offered: Offered,
}

/// Files that this diagnosis has, written or not.
struct Offered {
    augmented: bool,
    next: bool,
}

impl Offered {
    fn of(diagnosis: &Diagnosis) -> Self {
        Offered { augmented: diagnosis.augmented_plant.is_some(), next: diagnosis.next_experiment.is_some() }
    }
}

/// # Errors
/// [`Failure::Input`] for a recording, plant or map that cannot be used, [`Failure::Run`] when a
/// result cannot be written, [`Failure::Interrupted`] once what is known so far was printed.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut arguments = arguments.clone();
    let files = arguments.recordings.iter_mut().chain(&mut arguments.held_out);
    let arguments = &Arguments { plant: plant_of(files, arguments.plant.as_deref())?, ..arguments };
    if arguments.intake.list {
        let files: Vec<_> = arguments.recordings.iter().map(PathBuf::as_path).collect();
        return intake::list(&files, &arguments.intake, arguments.json);
    }
    let case = read(arguments)?;
    let out = arguments.out.as_deref().map(|folder| OutFiles::new(folder, &inputs(arguments))).transpose()?;
    let mut diagnosed = diagnosed(case, arguments)?;
    match &out {
        Some(out) => out.write(&mut diagnosed)?,
        None => files::without_files(&mut diagnosed.diagnosis),
    }
    let interrupted = diagnosed.interrupted;
    crate::print(&if arguments.json {
        format!("{}\n", object::object(&diagnosed))
    } else {
        let first = if interrupted { "interrupted: what is known so far\n" } else { "" };
        format!("{first}{}", words::in_words(&diagnosed, out.is_some()))
    });
    if interrupted { Err(Failure::Interrupted) } else { Ok(()) }
}

fn diagnosed(mut case: Case, arguments: &Arguments) -> Result<Diagnosed, Failure> {
    let (problem, options) = problems(&case, arguments)?;
    let watch = Watch::stopped_by(interrupt::flag()?);
    let most = arguments.effort.work();
    let phases = Phases::new(watch.clone(), most, arguments.shown());
    phases.begin(Stage::Labels);
    let most_for_labels = LABEL_CHECK_SHARE * most;
    let trusted = arguments.trust_labels;
    let planned = problem.as_ref().and_then(|problem| planned_work(problem, options.held_out.as_ref()));
    let [of_labels, of_search] = planned.unwrap_or_default();
    let (of_examination, of_search) = (examination_work(&case), of_search.min(most));
    watch.plan(if trusted { 0.0 } else { of_labels.min(most_for_labels) }, of_examination + of_search);
    let mut doubted = if trusted { Labels::trusted(&case) } else { look_at_labels(&case, most_for_labels, &watch) };
    phases.begin(Stage::Examine);
    watch.plan(of_examination, of_search);
    let mut findings = examine_all(&case, &doubted.labels, &watch);
    watch.plan(0.0, of_search);
    let work_max = most - doubted.spent.min(most_for_labels);
    let limited = |options: Options| Options { work_max, watch: watch.clone(), ..options };
    let mut diagnosis = match &problem {
        Some(problem) => decided(&mut case, &mut doubted, arguments, (problem, options, &limited), &mut |phase, _| {
            phases.begin(Stage::Search(phase));
        })?,
        None => match (&case.modes, case.spectra.first()) {
            (Some(modes), _) => modes_file::diagnose(&case.plant, modes),
            (None, Some((spectrum, _))) => features::diagnose(&case.plant, spectrum),
            (None, None) => Diagnosis::cannot_decide("there is no evidence".into()),
        },
    };
    let interrupted = problem.is_some() && watch.is_stopped();
    phases.end();
    if doubted.labels.iter().all(Option::is_none) && !diagnosis.labels.is_empty() {
        findings = examine_all(&case, &doubted.labels, &watch);
    }
    let Labels { labels, left_out, .. } = doubted;
    diagnosis.notes.extend(left_out);
    arguments.effort.cure(&mut diagnosis.notes);
    let labels: Vec<Mislabelled> = labels.into_iter().flatten().collect();
    let diagnosis = diagnosis.of_mislabelled(&labels);
    let offered = Offered::of(&diagnosis);
    Ok(Diagnosed { case, findings, diagnosis, interrupted, labels, offered })
}

/// The diagnosis of time records. Doubted labels are compared with the labels as they are; `case`
/// and `doubted` then have those that the diagnosis has.
fn decided(
    case: &mut Case,
    doubted: &mut Labels,
    arguments: &Arguments,
    (problem, options, limited): (&Problem, Options, &dyn Fn(Options) -> Options),
    progress: &mut dyn FnMut(Phase, f64),
) -> Result<Diagnosis, Failure> {
    let own = limited(options);
    if !doubted.labels.iter().any(Option::is_some) {
        return Ok(evidence::diagnose(problem, &own, progress));
    }
    let (read, plant) = (case.readings(), case.plant.clone());
    let rival = doubted.as_rival(case);
    case.put_right(&doubted.labels);
    case.plant = rival.plant;
    let (corrected, options) = problems(case, arguments)?;
    case.plant = plant;
    let (Some(corrected), other) = (corrected, limited(options)) else {
        return Ok(Diagnosis::cannot_decide("there is no recording".into()));
    };
    let mistakes = (rival.mistakes, rival.log_jacobian);
    let (found, probability) = diagnose_beside_labels((problem, &own), (&corrected, &other), mistakes, progress);
    let labels = doubted.settled(probability);
    if !doubted.labels.iter().any(Option::is_some) {
        case.put_back(read);
    }
    Ok(Diagnosis { labels, ..found })
}

fn read(arguments: &Arguments) -> Result<Case, Failure> {
    let file = required(arguments.plant.as_deref())?;
    let (plant, plant_digest) = plants::read_with_digest(file)?;
    let intake = arguments.intake.intake(Some(&plant))?;
    let evidence = |path: &Path| recordings::read_evidence(path, &intake, &plant);
    let (mut fitted, mut spectra) = (Vec::new(), Vec::new());
    let (lists, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
        arguments.recordings.iter().partition(|path| modes_file::is_one(path));
    let mut modes = alone(&lists, &others)?.map(modes_file::read).transpose()?;
    for path in others {
        match evidence(path)? {
            Evidence::Time(loaded) => fitted.extend(loaded),
            Evidence::Spectrum { spectrum, digest } => spectra.push((spectrum, digest)),
        }
    }
    if fitted.is_empty() && modes.is_none() {
        modes = responses::modes_or_peaks(&mut spectra)?;
    }
    one_kind(&fitted, &spectra, modes.is_some())?;
    unused(arguments, modes.is_some(), !spectra.is_empty())?;
    let time_only = |path: &Path, flag: &str| match evidence(path)? {
        Evidence::Time(loaded) => Ok(loaded),
        Evidence::Spectrum { spectrum, .. } => Err(Failure::Input(miette::miette!(
            help = format!("{flag} takes a time record; leave it out for a diagnosis of spectra"),
            "{flag} {}: this is a spectrum",
            spectrum.file
        ))),
    };
    let mut held_out = Vec::new();
    for path in &arguments.held_out {
        held_out.extend(time_only(path, "--held-out")?);
    }
    used_twice(&fitted, &held_out, "--held-out", "data that were fitted confirm nothing: give another recording")?;
    let plant_file = file.display().to_string();
    Ok(Case {
        plant,
        plant_file,
        plant_digest,
        fitted,
        held_out,
        spectra,
        modes,
        command: again(arguments),
        said: arguments.intake.words(),
        effort: arguments.effort,
    })
}

/// The list of modes, if there is one: then it is all there is.
fn alone<'a>(lists: &[&'a PathBuf], others: &[&'a PathBuf]) -> Result<Option<&'a Path>, Failure> {
    match (lists, others) {
        ([], _) => Ok(None),
        ([list], []) => Ok(Some(list.as_path())),
        ([list, ..], _) => Err(Failure::Input(miette::miette!(
            help = "a list of modes is diagnosed on its own: give one, and compare the answers",
            "{}: a list of modes among other recordings",
            list.display()
        ))),
    }
}

/// Time records, one spectrum, or the responses that modes were found in.
fn one_kind(fitted: &[Loaded], spectra: &[(Spectrum, String)], responses: bool) -> Result<(), Failure> {
    match (spectra, fitted) {
        ([(spectrum, _), ..], [record, ..]) => Err(Failure::Input(miette::miette!(
            help = "diagnose spectra and time records apart; each gives its own answer",
            "{} is a spectrum, {} a time record",
            spectrum.file,
            record.file
        ))),
        ([_, (second, _), ..], []) if !responses => Err(Failure::Input(miette::miette!(
            help = "a spectrum is diagnosed on its own: give one, and compare the answers",
            "{}: a second spectrum",
            second.file
        ))),
        _ => Ok(()),
    }
}

/// What would be read and then left aside: only time records are predicted, and modes have no
/// channels to rename.
fn unused(arguments: &Arguments, modes: bool, spectrum: bool) -> Result<(), Failure> {
    let what = match (modes, spectrum) {
        (true, true) => "frequency responses",
        (true, false) => "a list of modes",
        (_, true) => "a spectrum",
        _ => return Ok(()),
    };
    let given = [
        ("--held-out", !arguments.held_out.is_empty()),
        ("--map", modes && arguments.intake.map.is_some()),
        ("--channel", modes && !arguments.intake.channel.is_empty()),
    ];
    match given.iter().find(|(_, given)| *given) {
        Some((flag, _)) => Err(Failure::Input(miette::miette!(
            help = format!("leave {flag} out for a diagnosis of {what}"),
            "{flag} says nothing of {what}"
        ))),
        None => Ok(()),
    }
}

fn used_twice(fitted: &[Loaded], other: &[Loaded], flag: &str, cure: &str) -> Result<(), Failure> {
    match other.iter().find_map(|o| fitted.iter().find(|f| f.digest == o.digest).map(|f| (o, f))) {
        Some((other, fitted)) => Err(Failure::Input(miette::miette!(
            help = cure.to_owned(),
            "{flag} {}: the same bytes as the recording {}",
            other.file,
            fitted.file
        ))),
        None => Ok(()),
    }
}

/// The problem of the fitted recordings, where they are time records, and the options with those of
/// the others.
fn problems(case: &Case, arguments: &Arguments) -> Result<(Option<Problem>, Options), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments.threads.map_or(cores, usize::from);
    let mut options = Options { threads, worth: 0.01 * arguments.worth, ..Options::default() };
    if case.fitted.is_empty() {
        return Ok((None, options));
    }
    let fitted = problem(case, &case.fitted, "")?;
    if !case.held_out.is_empty() {
        options.held_out = Some(problem(case, &case.held_out, "--held-out ")?);
    }
    Ok((Some(fitted), options))
}

fn problem(case: &Case, loaded: &[Loaded], flag: &str) -> Result<Problem, Failure> {
    let recordings: Vec<_> = loaded.iter().map(|one| one.recording.clone()).collect();
    Problem::new(&case.plant, &recordings, &[])
        .map_err(|error| Failure::Input(miette::miette!(help = error.cure(&case.plant_file), "{flag}{error}")))
}

/// An interruption leaves the rest of the recordings out.
fn examine_all(case: &Case, labels: &[Option<Mislabelled>], watch: &Watch) -> Vec<(usize, Finding)> {
    let mut all = Vec::new();
    let work = Work::watched(f64::INFINITY, watch.clone());
    for (k, (one, label)) in case.fitted.iter().zip(labels).enumerate().take_while(|_| !watch.is_stopped()) {
        work.add(EXAMINATION_WORK * readings(one));
        let found = examine_beside(&one.recording, &case.plant, label.as_ref(), &mut |_| {});
        all.extend(found.into_iter().map(|finding| (k, finding)));
    }
    all
}

/// Work of the examination of a reading, counted as that of the search: about 15 us.
const EXAMINATION_WORK: f64 = 1.5e4;

fn examination_work(case: &Case) -> f64 {
    EXAMINATION_WORK * case.fitted.iter().map(readings).sum::<f64>()
}

fn readings(loaded: &Loaded) -> f64 {
    loaded.recording.channels.iter().map(|channel| channel.value.len() as f64).sum()
}

/// Every file that is read.
fn inputs(arguments: &Arguments) -> Vec<&Path> {
    let files = arguments.recordings.iter().chain(&arguments.held_out).chain(&arguments.intake.map);
    files.chain(&arguments.plant).map(PathBuf::as_path).collect()
}

/// The command that makes the result again.
fn again(arguments: &Arguments) -> String {
    let mut words = vec!["obsid".to_owned(), "diagnose".to_owned()];
    words.extend(arguments.recordings.iter().map(|path| path.display().to_string()));
    let one = |flag: &str, path: &Path| [flag.to_owned(), path.display().to_string()];
    arguments.plant.iter().for_each(|path| words.extend(one("--plant", path)));
    arguments.held_out.iter().for_each(|path| words.extend(one("--held-out", path)));
    words.extend(arguments.intake.words());
    arguments.out.iter().for_each(|path| words.extend(one("--out", path)));
    if arguments.effort != Effort::default() {
        words.extend(["--effort".to_owned(), arguments.effort.name().to_owned()]);
    }
    if arguments.trust_labels {
        words.push("--trust-labels".to_owned());
    }
    if arguments.worth != 0.0 {
        words.extend(["--worth".to_owned(), arguments.worth.to_string()]);
    }
    recordings::command_line(&words)
}
