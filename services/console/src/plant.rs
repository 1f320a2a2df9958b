//! `obsid plant`: what a plant file says, checked, described, predicted, and proposed from a
//! recording; the definition of its format.

mod check;
mod describe;
mod format;
mod parameters;
mod propose;
mod words;

pub use propose::plain;

use crate::Failure;
use std::path::Path;

/// Check, describe and propose plant files; print their format
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant check deploy/plants/*.toml                     every error with its place and cure
  obsid plant describe deploy/plants/study_case.toml         masses, modes, base parameters on one page
  obsid plant parameters free_floating_arm --duration 30     what 30 s of its experiment would tell, with sigmas
  obsid plant new rig.csv --out rig.toml                     a plant file to fill in, from a recording's channels
  obsid plant format                                         every key of a plant file, with unit and default")]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(clap::Subcommand)]
enum Verb {
    Check(check::Arguments),
    Describe(describe::Arguments),
    Format(format::Arguments),
    Parameters(parameters::Arguments),
    New(propose::Arguments),
}

/// # Errors
/// [`Failure::Input`] for a file that cannot be used, [`Failure::Run`] for a result that cannot be
/// written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.verb {
        Verb::Check(arguments) => check::run(arguments),
        Verb::Describe(arguments) => describe::run(arguments),
        Verb::Format(arguments) => format::run(arguments),
        Verb::Parameters(arguments) => parameters::run(arguments),
        Verb::New(arguments) => propose::run(arguments),
    }
}

/// A plant that is well-formed and still has no equations or no simulation.
fn impossible(file: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Input(miette::miette!(
        help = "the file is well-formed; change what the message names, see `obsid plant describe` of a plant in deploy/plants",
        "{}: {error}",
        file.display()
    ))
}
