//! `obsid plant new`: a plant file for a rig, proposed from what its recording holds, for the user
//! to fill in.

mod beginning;
mod mechanism;
mod names;
mod parts;
mod roles;
mod samples;
mod text;

pub use names::plain;

use crate::intake::{self, IntakeArguments};
use crate::recordings::{self, nearest};
use crate::{Failure, plants};
use channels::Recording;
use recording::units::NOT_STATED;
use roles::Told;
use samples::rates;
use std::path::{Path, PathBuf};
use text::Proposal;

/// Propose a plant file for a rig, from the channels and units of a recording
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant new swing.csv --out pendulum.toml
  obsid plant new drive.csv --command Iq_set --measured speed --out drive.toml
  obsid plant new log.csv --channel 'speed = n [rpm]' --out rig.toml      a unit that the file does not state

What only you know (masses, places) stands in the file as \"? kg\", marked FILL IN: `obsid plant check` lists what is left, and
`obsid diagnose` begins when all is filled in. The file says at every line what was guessed and why.")]
pub struct Arguments {
    /// Recording of any format, with channels over time
    #[arg(value_name = "RECORDING", required_unless_present = "from")]
    recording: Option<PathBuf>,
    /// The same
    #[arg(long, value_name = "RECORDING", conflicts_with = "recording", hide = true)]
    from: Option<PathBuf>,
    /// The plant file; one that exists is left alone
    #[arg(long, value_name = "FILE")]
    #[arg(required_unless_present = "list")]
    out: Option<PathBuf>,
    /// A channel that was set, not measured, whatever its name and unit say; may be repeated
    #[arg(long, value_name = "NAME")]
    command: Vec<String>,
    /// A channel that a sensor read; may be repeated
    #[arg(long, value_name = "NAME")]
    measured: Vec<String>,
    /// What was proposed as one JSON object on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    intake: IntakeArguments,
}

/// # Errors
/// [`Failure::Input`] for a recording that cannot be read or says nothing of motion, for a channel
/// that it has not, and for a file that exists.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let from = arguments.recording.as_ref().or(arguments.from.as_ref());
    let from = from.ok_or_else(|| Failure::Run("no recording was given".into()))?;
    if arguments.intake.list {
        return intake::list(&[from], &arguments.intake, arguments.json);
    }
    let out = arguments.out.as_deref().ok_or_else(|| Failure::Run("--out FILE is missing".into()))?;
    let parts: Vec<Recording> =
        recordings::read(from, &arguments.intake.intake(None)?, None)?.into_iter().map(|part| part.recording).collect();
    let told = told(arguments, &parts[0])?;
    let name = stem(from);
    let proposal = Proposal::new(&name, from, &parts, &told)
        .map_err(|(reason, cure)| Failure::Input(miette::miette!(help = cure, "{}: {reason}", from.display())))?;
    // a proposal that this very program rejects would be worse than none
    plants::parse(&name, &proposal.filled())
        .map_err(|_| Failure::Run(format!("{}: the proposal for these channels is no plant file", from.display())))?;
    write_new(out, &proposal.text)?;
    for question in &proposal.asked {
        crate::tell(&format!("note: {question}"));
    }
    crate::print(&if arguments.json { proposal.json(out) } else { summary(&proposal, out, &parts) });
    Ok(())
}

/// `--command` and `--measured`, each a channel with a unit that can be one.
fn told(arguments: &Arguments, recording: &Recording) -> Result<Told, Failure> {
    let refuse = |cure: String, what: String| Err(Failure::Input(miette::miette!(help = cure, "{what}")));
    for (flag, names) in [("--command", &arguments.command), ("--measured", &arguments.measured)] {
        for name in names {
            let Some(channel) = recording.channel_named(name) else {
                let all = || recording.channels.iter().map(|channel| channel.name.as_str());
                let near = nearest(name, all()).map_or(String::new(), |near| format!("did you mean '{near}'? "));
                let all = all().take(NAMES_SHOWN).collect::<Vec<_>>().join(", ");
                return refuse(
                    format!("{near}channels: {all}"),
                    format!("{flag} '{name}': no channel of {}", recording.name),
                );
            };
            if channel.unit == NOT_STATED {
                return refuse(
                    format!(
                        "say it: --channel '{name} = {name} [UNIT]', as in [N], [N*m], [A], [rad], [rad/s], [m/s^2]"
                    ),
                    format!("{flag} '{name}': {} does not state its unit", recording.name),
                );
            }
            if flag == "--command" && arguments.measured.contains(name) {
                return refuse("say one of the two".into(), format!("'{name}' is --command and --measured"));
            }
        }
    }
    Ok(Told { commands: arguments.command.clone(), measured: arguments.measured.clone() })
}

/// Names that an error lists.
const NAMES_SHOWN: usize = 30;

/// A name that a plant can have: the file's, in plain letters.
fn stem(path: &Path) -> String {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.split(".csv").next().unwrap_or_default().trim_end_matches(".mcap").to_owned();
    names::plain(&name)
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
    let (period_s, _) = rates(parts);
    let (out, blanks) = (out.display(), proposal.blanks());
    let places = if blanks == 1 { "place" } else { "places" };
    text.push_str(&format!(
        "\n{out} written: period {} s, {blanks} {places} to FILL IN; then `obsid plant check {out}`\n",
        super::words::digits(period_s, 6)
    ));
    text
}
