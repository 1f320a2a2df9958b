//! `obsid bench PROBLEM`: seeded Monte Carlo of a benchmark problem against its truth and its Cramér–Rao bound.
//!
//! Truth comes from `plant`, estimates from the code that flies (`physics`, `modal`) and from the literature's baselines.
//! A command line gives the same bytes on any number of cores, the measured times excepted.

pub mod campaign;
pub mod dynamics;
pub mod inertial;
pub mod modes;
pub mod report;
mod simulated;
pub mod slosh;

use crate::{Failure, print};
use campaign::{Benchmark, Campaign};
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
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// The benchmark problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Problem {
    /// Inertial parameters of a free-floating arm from the conservation of momentum
    #[value(name = "bp1a")]
    Inertial,
    /// Sloshing propellant on one axis
    #[value(name = "bp2")]
    Slosh,
    /// Modes of a flexible appendage from a free decay
    #[value(name = "bp3a")]
    Modes,
    /// Nanoseconds and allocations of the equations of motion; --trials and --seed have no part in it
    Dynamics,
}

/// # Errors
/// [`Failure::Run`] when the truth has no Cramér–Rao bound.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match arguments.problem {
        Problem::Inertial => measure(arguments, &inertial::Inertial::bp1a()),
        Problem::Slosh => measure(arguments, &slosh::Slosh::bp2()),
        Problem::Modes => measure(arguments, &modes::Modes::bp3a()),
        Problem::Dynamics => dynamics::run(arguments.json),
    }
}

fn measure(arguments: &Arguments, benchmark: &impl Benchmark) -> Result<(), Failure> {
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
    print(&if arguments.json { report.json() } else { report.table() });
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
