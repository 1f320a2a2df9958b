//! The command line `obsid`: one file per subcommand, each with its arguments and what it does.
//!
//! What it is: [`main`] parses the arguments, calls the subcommand and returns its exit code: 0
//! done, 1 the run failed, 2 usage, 3 bad input, 4 the run ended degraded, 130 interrupted.
//! `launch` starts a run (its process supervisor is `partition warden`), shows its progress and
//! stops it; a console that dies ends no run badly. Every other file reads, calls one library and
//! prints.
//!
//! May import: every crate.
//!
//! Must never know: how a quantity is estimated or an effect is decided; it shows results and
//! computes none. Nothing imports it but the program itself.
//!
//! ```no_run
//! use console::Failure;
//!
//! // `obsid doctor rig.csv --plant rig.toml`: findings to standard output
//! let exit_code: std::process::ExitCode = console::main();
//!
//! // how a subcommand ends without success: exit code 1 here, 3 for `Failure::Input`
//! let failure = Failure::Run("the run ended before its results".into());
//! eprintln!("obsid: {failure}");
//! std::process::exit(i32::from(exit_code != std::process::ExitCode::SUCCESS));
//! ```
#![forbid(unsafe_code)]

mod attach;
mod bench;
mod beside;
mod bridge;
mod budget;
mod challenge;
mod command;
mod compare;
mod completions;
mod design;
mod diagnose;
mod digest;
mod doctor;
mod drill;
mod effects;
mod effort;
mod events;
mod feed_counts;
mod flight;
mod gateway;
mod hidden;
mod icd;
mod identify;
mod intake;
mod interrupt;
mod keeper;
mod latency;
mod launch;
mod limits_file;
mod located;
mod man;
mod modal;
mod notes;
mod outcome;
mod paper;
mod partition;
mod phases;
mod plant;
mod plants;
mod preflight;
mod progress;
mod recordings;
mod replay;
mod run;
mod scenario_file;
mod scenario_run;
mod scratch;
mod simulate;
mod table;
mod tables;
mod toml_file;
mod top;
mod trace_file;
mod truth;
mod visible;
mod warden_process;

use clap::{Parser, Subcommand};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why a subcommand ends without success.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The run failed.
    #[error("{0}")]
    Run(String),
    /// What the user gave cannot be used; the report says where and what to do.
    #[error("bad input")]
    Input(miette::Report),
    /// The command line lacks something; how to say it.
    #[error("{0}")]
    Usage(String),
    /// The run got to its end, but lost samples or a partition on the way: its results are not
    /// whole.
    #[error("degraded: {0}")]
    Degraded(String),
    /// The user ended it; what was known was printed.
    #[error("interrupted")]
    Interrupted,
}

impl Failure {
    fn input(error: impl miette::Diagnostic + Send + Sync + 'static) -> Self {
        Failure::Input(miette::Report::new(error))
    }
}

#[derive(Parser)]
#[command(name = "obsid", version, about = "On-board system identification for servicing spacecraft", after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  obsid run                                        the default scenario, as processes over shared memory
  obsid run deploy/scenarios/default.toml --json   another scenario, result as one JSON object
  obsid replay slab.csv.gz                         a recording through the partitions
  obsid gateway /run/obsid/sensors --scenario c.toml --duration 60   real sensors through the partitions
  obsid bridge --connect tcp/10.0.0.1:7447 --mirror /run/obsid-far/obsid-far   the run of another computer
  obsid drill --kills 100                          faults into real runs: kills, hangs, corruption, full disks
  obsid latency                                    the link beside what the machine itself costs
  obsid budget                                     each partition in real time against its budget
  obsid top                                        watch a run that flies
  obsid events --min-severity warning              what its partitions reported
  obsid command ping all                           command it
  obsid tables dump                                its parameter tables
  obsid simulate study_case --out flight.mcap      what the sensors of a plant would say
  obsid plant describe study_case                  a plant on one page: masses, modes, base parameters
  obsid design bp1a --out arm.toml                 more informative joint motion, within the limits
  obsid doctor rig.csv --plant rig.toml            what is wrong with a recording, with the cure
  obsid compare flight.csv simulated.csv           how far apart two recordings are, and by what
  obsid diagnose swing.csv --plant pendulum.toml   physics that the plant file does not model, with proof
  obsid identify a.csv b.csv --plant craft.toml    numbers of one vehicle from all its recordings
  obsid modal slab.csv.gz --out report             modes of a recording: frequencies, damping, shapes
  obsid digest flight.mcap                         identity of the recorded results
  obsid icd --md                                   the interface control document
  obsid completions bash                           completion of subcommands and options in a shell

Exit codes: 0 done, 1 the run failed, 2 usage, 3 bad input, 4 the run ended degraded, 130 interrupted.";

const BENCH_EXAMPLES: &str = "Examples:
  obsid bench bp1a                               100 records of the arm, beside the Cramer-Rao bound
  obsid bench bp2 --trials 1000 --seed 7 --json  slosh, more records, another seed, result as JSON
  obsid bench target                             the target's mass, centre and inertia through the whole chain
  obsid bench bp2-planar                         slosh in the plane, from accelerometer and gyro
  obsid bench dynamics                           nanoseconds and allocations of the equations of motion";

const DESIGN_EXAMPLES: &str = "Examples:
  obsid design slosh                                        thrust within half a metre of stroke, two hours
  obsid design slosh --stroke-max-m 0.25 --out tank.toml    a narrower tank, as a plant for 'obsid simulate'";

#[derive(Subcommand)]
enum Command {
    Run(run::Arguments),
    Drill(drill::Arguments),
    Latency(latency::Arguments),
    Budget(budget::Arguments),
    Top(top::Arguments),
    Events(events::Arguments),
    #[command(name = "command")]
    Order(command::Arguments),
    Tables(tables::Arguments),
    #[command(after_help = BENCH_EXAMPLES)]
    Bench(bench::Arguments),
    #[command(after_help = DESIGN_EXAMPLES)]
    Design(design::Arguments),
    Replay(replay::Arguments),
    Gateway(gateway::Arguments),
    Bridge(bridge::Arguments),
    Simulate(simulate::Arguments),
    Effects(effects::Arguments),
    Plant(plant::Arguments),
    Doctor(doctor::Arguments),
    Compare(compare::Arguments),
    Challenge(challenge::Arguments),
    Modal(modal::Arguments),
    Diagnose(diagnose::Arguments),
    Identify(identify::Arguments),
    Digest(digest::Arguments),
    Icd(icd::Arguments),
    Completions(completions::Arguments),
    Man(man::Arguments),
    Partition(partition::Arguments),
}

/// Parses the command line, carries the subcommand out, turns the outcome into an exit code.
#[must_use]
pub fn main() -> ExitCode {
    keep_messages_on_one_line();
    runtime::sys::keep_own_rights();
    let result = match Arguments::parse().command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Drill(arguments) => drill::run(&arguments),
        Command::Latency(arguments) => latency::run(&arguments),
        Command::Budget(arguments) => budget::run(&arguments),
        Command::Top(arguments) => top::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Gateway(arguments) => gateway::run(&arguments),
        Command::Bridge(arguments) => bridge::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Events(arguments) => events::run(&arguments),
        Command::Order(arguments) => command::run(&arguments),
        Command::Tables(arguments) => tables::run(&arguments),
        Command::Design(arguments) => design::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Effects(arguments) => effects::run(&arguments),
        Command::Plant(arguments) => plant::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Challenge(arguments) => challenge::run(&arguments),
        Command::Modal(arguments) => modal::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Digest(arguments) => digest::run(&arguments),
        Command::Icd(arguments) => icd::run(&arguments),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Man(arguments) => man::run(&arguments),
        Command::Partition(arguments) if arguments.are_of_keeper() => return keeper::run(&arguments),
        Command::Partition(arguments) => return partition::run(&arguments),
    };
    match result {
        Ok(()) if OUTPUT_LOST.load(Ordering::Relaxed) => ExitCode::from(1),
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Run(reason)) => {
            tell(&format!("obsid: {reason}"));
            ExitCode::from(1)
        }
        Err(degraded @ Failure::Degraded(_)) => {
            tell(&format!("obsid: {degraded}"));
            ExitCode::from(4)
        }
        Err(Failure::Input(report)) => {
            tell(visible::cut_snippets(&format!("{report:?}")).trim_end());
            ExitCode::from(3)
        }
        Err(Failure::Usage(lacking)) => {
            tell(&format!("error: {lacking}"));
            ExitCode::from(2)
        }
        Err(Failure::Interrupted) => ExitCode::from(interrupt::EXIT_CODE),
    }
}

/// In a log or a pipe a message stays on its line, so that it can be searched for; a terminal wraps
/// it.
fn keep_messages_on_one_line() {
    use std::io::IsTerminal;
    if !std::io::stderr().is_terminal() {
        // An error says that somebody set one before, which only a second call could have done.
        let _ = miette::set_hook(Box::new(|_| Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())));
    }
}

/// A result could not be printed (a full disk).
static OUTPUT_LOST: AtomicBool = AtomicBool::new(false);

/// Prints to standard output; that the reader has gone away (`| head -1`) is no failure.
fn print(text: &str) {
    use std::io::Write;
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(visible::visible(text).as_bytes()).and_then(|()| out.flush())
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        OUTPUT_LOST.store(true, Ordering::Relaxed);
        tell(&format!("obsid: standard output: {error}"));
    }
}

/// Says a line on standard error; a closed standard error is no failure.
fn tell(text: &str) {
    runtime::sys::tell(&format!("{}\n", visible::visible_but_colours(text)));
}
