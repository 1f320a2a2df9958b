//! `obsid plant new`: a plant file for a rig, proposed from what its recording holds, for the user
//! to fill in.

mod roles;
mod text;

use crate::intake::{self, IntakeArguments};
use crate::{Failure, plants};
use channels::Recording;
use std::path::{Path, PathBuf};
use text::{Proposal, rates};

/// Propose a plant file for a rig, from the channels and units of a recording
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant new --from swing.csv --out pendulum.toml
  obsid plant new --from rig.mcap --out rig.toml        then fill in what is marked FILL IN, and `obsid plant check rig.toml`

The file says at every line what was guessed and why. What only you know (masses, places) stands there with a wide prior.")]
pub struct Arguments {
    /// CSV, CSV.gz or MCAP with channels over time
    #[arg(long, value_name = "RECORDING")]
    from: PathBuf,
    /// The plant file; one that exists is left alone
    #[arg(long, value_name = "FILE")]
    #[arg(required_unless_present = "list", default_value = "")]
    out: PathBuf,
    /// What was proposed as one JSON object on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// # Errors
/// [`Failure::Input`] for a recording that cannot be read or says nothing of motion, and for a file
/// that exists.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let from = &arguments.from;
    if arguments.intake.list {
        return intake::list(&[from], &arguments.intake, arguments.json);
    }
    let imported = recording::read_with(from, &arguments.intake.intake(None)?).map_err(Failure::input)?;
    let parts = recording::segments(imported).map_err(Failure::input)?;
    let parts: Vec<Recording> = parts.into_iter().map(|part| part.recording).collect();
    let name = stem(from);
    let proposal = Proposal::new(&name, from, &parts).map_err(|reason| {
        let help = "give a recording with at least one angle, rate, displacement, velocity or acceleration over time";
        Failure::Input(miette::miette!(help = help, "{}: {reason}", from.display()))
    })?;
    // a proposal that this very program rejects would be worse than none
    plants::parse(&name, &proposal.text)
        .map_err(|_| Failure::Run(format!("{}: the proposal for these channels is no plant file", from.display())))?;
    write_new(&arguments.out, &proposal.text)?;
    crate::print(&if arguments.json {
        proposal.json(&arguments.out)
    } else {
        summary(&proposal, &arguments.out, &parts)
    });
    Ok(())
}

/// A name that a plant can have: the file's, in plain letters.
fn stem(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.split(".csv").next().unwrap_or_default().trim_end_matches(".mcap").to_owned();
    text::plain(&name)
}

fn write_new(path: &Path, text: &str) -> Result<(), Failure> {
    use std::io::Write;
    let file = std::fs::OpenOptions::new().write(true).create_new(true).open(path);
    file.and_then(|mut file| file.write_all(text.as_bytes())).map_err(|error| {
        let help = if error.kind() == std::io::ErrorKind::AlreadyExists {
            "it may hold what you filled in: remove it or give --out another name"
        } else {
            "give --out a path that can be written"
        };
        Failure::Input(miette::miette!(help = help, "--out {}: {error}", path.display()))
    })
}

fn summary(proposal: &Proposal, out: &Path, parts: &[Recording]) -> String {
    let mut text = String::new();
    for line in &proposal.lines {
        text.push_str(line);
        text.push('\n');
    }
    let marks = proposal.text.matches("FILL IN").count() - 1;
    let (period_s, _) = rates(parts);
    text.push_str(&format!(
        "\n{} written: period {} s, {marks} places marked FILL IN; then `obsid plant check {}`\n",
        out.display(),
        super::words::digits(period_s, 6),
        out.display()
    ));
    text
}
