//! `obsid design PROBLEM`: experiments that tell more, within what the hardware allows.

mod inertial;
mod slosh;

use crate::Failure;

/// Design an experiment: least bound of the parameters within the limits
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    problem: Problem,
}

#[derive(clap::Subcommand)]
enum Problem {
    /// Joint motion of the free-floating arm
    #[command(name = "bp1a")]
    Inertial(inertial::Arguments),
    /// Thrust for slosh on one axis
    #[command(name = "slosh")]
    Slosh(slosh::Arguments),
}

/// # Errors
/// [`Failure::Input`] for a limits file that cannot be used, [`Failure::Run`] for limits that allow
/// nothing and a result that cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match &arguments.problem {
        Problem::Inertial(arguments) => inertial::run(arguments),
        Problem::Slosh(arguments) => slosh::run(arguments),
    }
}
