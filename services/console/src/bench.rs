//! `obsid bench PROBLEM`: seeded Monte Carlo of a benchmark problem against its truth and its
//! Cramér–Rao bound.
//!
//! A command line gives the same bytes on any number of cores, the measured times excepted.

mod hidden_effects;
mod modal_records;
mod study_case;

use crate::{Failure, print};
use bench::campaign::{Benchmark, Campaign};
use bench::{evaluation, inertial, modes, slosh};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// Seeded Monte Carlo of a benchmark problem, beside the Cramér-Rao bound and the published figures
#[derive(clap::Args)]
pub struct Arguments {
    problem: Problem,
    /// Independent records
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    trials: u32,
    /// The same seed gives the same records
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Of bp1a, mated, bp3a and bp3b only these methods, separated by commas
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Of bp1a and mated: where methods that need a start are started, relative to the truth
    #[arg(long)]
    start: Option<f64>,
    /// Of study-case: every effect of the catalogue hidden once, at a site and of a size drawn from
    /// the seed, and what the flight makes of it
    #[arg(long)]
    hidden: bool,
    /// With --hidden only these effects, separated by commas
    #[arg(long, value_delimiter = ',', requires = "hidden", value_name = "KIND")]
    only: Vec<String>,
    /// Of modal-records only this kind of record, as its table names it; may be repeated
    #[arg(long, value_name = "NAME")]
    kind: Vec<String>,
    /// One JSON object on standard output
    #[arg(long, conflicts_with = "md")]
    json: bool,
    /// A table of Markdown, as in deploy/measured.md
    #[arg(long)]
    md: bool,
}

/// The benchmark problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Problem {
    /// Inertial parameters of a free-floating arm: momentum and dynamic equation
    #[value(name = "bp1a")]
    Inertial,
    /// The same with a late gyro and a torque from outside, both to be found
    #[value(name = "bp1a-late")]
    Late,
    /// The same with the systematic errors that the data sheets of the sensors allow
    #[value(name = "bp1a-sheet")]
    Sheet,
    /// The same without a designed input: what an ordinary move tells
    #[value(name = "bp1a-operational")]
    Operational,
    /// Inertial parameters of a free-flying arm, its mass among them
    #[value(name = "bp1b")]
    Flying,
    /// The nine parameters of the arm that holds a target
    #[value(name = "mated")]
    Mated,
    /// The same with the momentum unknown and a wheel modulated
    #[value(name = "mated-wheel")]
    MatedWheel,
    /// Mass, centre of mass and inertia of the target, from before and after capture
    #[value(name = "target")]
    Target,
    /// Sloshing propellant on one axis
    #[value(name = "bp2")]
    Slosh,
    /// The same from two cycles of a square wave and coasting; start, bias and thrust scale unknown
    #[value(name = "bp2-burst")]
    SloshBurst,
    /// The same within half a metre of stroke, with the paper's accelerometer and with one of lower
    /// noise
    #[value(name = "bp2-stroke")]
    SloshStroke,
    /// Tanks drawn at random, found from the scan alone
    #[value(name = "bp2-global")]
    SloshGlobal,
    /// Spring or pendulum, record by record: right and wrong verdicts, both models' z
    #[value(name = "bp2-suspension")]
    SloshSuspension,
    /// Slosh on two springs in the plane, from accelerometer and gyro
    #[value(name = "bp2-planar")]
    SloshPlanar,
    /// Spring or pendulum, from three levels of thrust
    #[value(name = "bp2-tank-model")]
    SloshTankModel,
    /// Modes of a flexible appendage struck by a torque pulse
    #[value(name = "bp3a")]
    Modes,
    /// The same while a control loop turns the hub: hub-free modes with the torque known,
    /// closed-loop modes from outputs alone
    #[value(name = "bp3b")]
    ModesInLoop,
    /// Modes of random structures from records as they are: samples missing, values held, channels
    /// late, tones
    #[value(name = "modal-records")]
    ModalRecords,
    /// One craft flown through all arcs in one thread, trial k with seed + k: the figures of its
    /// joint estimate
    #[value(name = "study-case")]
    StudyCase,
    /// Nanoseconds and allocations of the equations of motion; --trials and --seed have no part in
    /// it
    Dynamics,
}

/// # Errors
/// [`Failure::Run`] when the truth has no Cramér–Rao bound.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.hidden && arguments.problem != Problem::StudyCase {
        return Err(Failure::Usage("--hidden belongs to study-case: obsid bench study-case --hidden".into()));
    }
    if !arguments.kind.is_empty() && arguments.problem != Problem::ModalRecords {
        return Err(Failure::Usage("--kind belongs to modal-records: obsid bench modal-records --kind clean".into()));
    }
    let form = match (arguments.json, arguments.md) {
        (true, _) => Form::Object,
        (_, true) => Form::Markdown,
        _ => Form::Text,
    };
    let mut answers = Answers { form, objects: Vec::new() };
    answer(arguments, &mut answers)?;
    answers.end();
    Ok(())
}

/// How answers are written.
enum Form {
    Text,
    Markdown,
    Object,
}

/// Answers of the benchmarks of a problem: tables as they come, objects together in one.
struct Answers {
    form: Form,
    objects: Vec<String>,
}

impl Answers {
    /// An answer that has no table of Markdown is the one of a terminal, line by line.
    fn add(&mut self, table: impl FnOnce() -> String, markdown: Option<String>, object: impl FnOnce() -> String) {
        match self.form {
            Form::Object => self.objects.push(object()),
            Form::Markdown => print(&markdown.unwrap_or_else(|| format!("```\n{}```\n", table()))),
            Form::Text => print(&table()),
        }
    }

    /// The only object as it is, several as `benchmarks` of one.
    fn end(&self) {
        match &self.objects[..] {
            [] => {}
            [one] => print(one),
            several => {
                let objects: Vec<&str> = several.iter().map(|object| object.trim_end()).collect();
                print(&format!("{{\"benchmarks\":[{}]}}\n", objects.join(",")));
            }
        }
    }
}

fn answer(arguments: &Arguments, to: &mut Answers) -> Result<(), Failure> {
    match arguments.problem {
        Problem::Inertial => measure(arguments, to, &chosen(inertial::Inertial::bp1a(), arguments)?),
        Problem::Late => measure(arguments, to, &inertial::late::Late::bp1a()),
        Problem::Sheet => measure(arguments, to, &inertial::sheet::Sheet::bp1a()),
        Problem::Operational => measure(arguments, to, &inertial::operational::Operational::bp1a()),
        Problem::MatedWheel => measure(arguments, to, &inertial::wheel::Wheel::mated()),
        Problem::Flying => measure(arguments, to, &inertial::flying::Flying::bp1b()),
        Problem::Mated => measure(arguments, to, &chosen(inertial::Inertial::mated(), arguments)?),
        Problem::Target => measure(arguments, to, &inertial::target::Chain::bp1()),
        Problem::Slosh => measure(arguments, to, &slosh::Slosh::bp2()),
        Problem::SloshBurst => measure(arguments, to, &slosh::Slosh::burst()),
        Problem::SloshStroke => {
            measure(arguments, to, &slosh::Slosh::stroke(1.0))?;
            measure(arguments, to, &slosh::Slosh::stroke(0.0013 / 0.008))
        }
        Problem::SloshGlobal => measure(arguments, to, &slosh::global::RandomTanks::new()),
        Problem::SloshSuspension => {
            judge(arguments, to, &slosh::tank_model::TankModelChoice::pendulum())?;
            judge(arguments, to, &slosh::tank_model::TankModelChoice::spring())
        }
        Problem::SloshPlanar => measure(arguments, to, &slosh::planar::Planar::bp2()),
        Problem::SloshTankModel => {
            measure(arguments, to, &slosh::tank_model::TankModelChoice::pendulum())?;
            measure(arguments, to, &slosh::tank_model::TankModelChoice::spring())
        }
        Problem::Modes => measure_modes(arguments, to, &[modes::Modes::bp3a()]),
        Problem::ModesInLoop => measure_modes(arguments, to, &[modes::Modes::bp3b(), modes::Modes::bp3b_outputs()]),
        Problem::ModalRecords => modal_records::measure(arguments, to),
        Problem::StudyCase if arguments.hidden => hidden_effects::measure(arguments, to),
        Problem::StudyCase => study_case::measure(arguments, to),
        Problem::Dynamics => {
            let cases = evaluation::cases(&runtime::sys::allocations);
            to.add(|| evaluation::table(&cases), None, || evaluation::json(&cases));
            Ok(())
        }
    }
}

/// Every name is one of the `known` of its noun.
fn ask(noun: &str, names: &[String], known: &[&str]) -> Result<(), Failure> {
    match names.iter().find(|name| !known.contains(&name.as_str())) {
        None => Ok(()),
        Some(unknown) => Err(Failure::Input(miette::miette!(
            help = format!("the {noun}s of this benchmark are '{}'", known.join("', '")),
            "no {noun} '{unknown}'"
        ))),
    }
}

/// The methods asked for.
fn chosen<const P: usize, const A: usize>(
    all: inertial::Inertial<P, A>,
    arguments: &Arguments,
) -> Result<inertial::Inertial<P, A>, Failure> {
    let known: Vec<&str> = all.methods().iter().map(|method| method.name).collect();
    ask("method", &arguments.methods, &known)?;
    let names: Vec<&str> = arguments.methods.iter().map(String::as_str).collect();
    let all = match arguments.start {
        None => all,
        Some(share) if (0.01..=100.0).contains(&share) => all.starting_at(share),
        Some(share) => return Err(Failure::Input(miette::miette!("--start {share}: between 0.01 and 100"))),
    };
    Ok(if names.is_empty() { all } else { all.only(&names) })
}

/// Those of `benchmarks` that know one of the methods asked for.
fn measure_modes(arguments: &Arguments, to: &mut Answers, benchmarks: &[modes::Modes]) -> Result<(), Failure> {
    let known: Vec<&str> = benchmarks.iter().flat_map(|b| b.methods()).map(|method| method.name).collect();
    ask("method", &arguments.methods, &known)?;
    for benchmark in benchmarks {
        let chosen = benchmark.clone().only(&arguments.methods);
        if !chosen.methods().is_empty() {
            measure(arguments, to, &chosen)?;
        }
    }
    Ok(())
}

fn measure(arguments: &Arguments, to: &mut Answers, benchmark: &impl Benchmark) -> Result<(), Failure> {
    let parameters = benchmark.parameters().ok_or_else(|| {
        Failure::Run(format!(
            "{}: the experiment leaves a parameter without trace, so there is no bound",
            benchmark.name()
        ))
    })?;
    let campaign = Campaign::new(arguments.trials as usize, arguments.seed);
    let bar = progress_bar(u64::from(arguments.trials));
    let answers = campaign.run(benchmark, &|| bar.inc(1));
    bar.finish_and_clear();
    let report = campaign.report(benchmark, &parameters, &answers);
    to.add(|| report.table(), Some(report.markdown()), || report.json());
    Ok(())
}

fn judge(arguments: &Arguments, to: &mut Answers, choice: &slosh::tank_model::TankModelChoice) -> Result<(), Failure> {
    let campaign = Campaign::new(arguments.trials as usize, arguments.seed);
    let bar = progress_bar(u64::from(arguments.trials));
    let verdicts = slosh::suspension::verdicts(choice, &campaign, &|| bar.inc(1));
    bar.finish_and_clear();
    let verdicts = verdicts.ok_or_else(|| Failure::Run("bp2-suspension: no record could be judged".into()))?;
    to.add(|| verdicts.table(), None, || verdicts.json());
    Ok(())
}

fn progress_bar(trials: u64) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(trials), target);
    let style = ProgressStyle::with_template("{elapsed_precise} [{bar:30}] record {pos}/{len}, {eta} left");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
