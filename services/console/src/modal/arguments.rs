//! Arguments of `obsid modal`.

use super::structural_arguments::StructuralArguments;
use crate::intake::IntakeArguments;
use crate::recordings;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Modes of a recording: frequency, damping and shape with standard deviations, and what the record
/// cannot tell
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid modal slab.csv.gz --channels acceleration_z --from 5    one channel, the first seconds left out
  obsid modal panel.csv --input torque --out report             with a recorded input: maximum likelihood, modal.html
  obsid modal point_1.csv point_2.csv point_3.csv --json        frequency responses of one structure, as one object
  obsid modal beam.uff --csv modes.csv                          a universal file (dataset 58); the modes as a table
  obsid modal panel.csv --input torque --json > modes.json      what `obsid diagnose modes.json --plant FILE` asks for drift
  obsid modal run.mcap --orders 2..60                           order sweep up to 60
  obsid modal beam.uff --band 20..200                           the modes between 20 and 200 Hz alone
  obsid modal today.csv --reference modes.json --out report     MAC matrix and changes of frequency against earlier modes
  obsid modal panel.csv --geometry panel.toml --out report      shapes that move on the structure
  obsid modal a.csv --setup b.csv,c.csv --references r1,r2      three setups with two sensors that stayed
  obsid modal slab.csv --select 14:5.2,20:17.7                  poles picked from the stabilisation diagram")]
pub struct Arguments {
    /// CSV, CSV.gz, UFF or MCAP; several files of frequency responses are channels of one structure
    #[arg(required = true, value_name = "FILE")]
    pub(super) files: Vec<PathBuf>,
    /// A channel that drives the structure, held from sample to sample
    #[arg(long, value_name = "CHANNEL")]
    pub(super) input: Option<String>,
    /// Response channels; all others but the input when not given
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub(super) channels: Vec<String>,
    /// Model orders of the sweep
    #[arg(long, default_value = ORDERS, value_parser = orders)]
    pub(super) orders: RangeInclusive<usize>,
    /// Leave out what lies before [s]
    #[arg(long, value_name = "SECONDS")]
    pub(super) from: Option<f64>,
    /// Leave out what lies behind [s]
    #[arg(long, value_name = "SECONDS")]
    pub(super) to: Option<f64>,
    /// Report the modes of this band alone [Hz]
    #[arg(long, value_parser = band, value_name = "LOW..HIGH")]
    pub(super) band: Option<(f64, f64)>,
    /// One JSON object on standard output
    #[arg(long)]
    pub(super) json: bool,
    /// Write the modes to this file, a row for each
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Write modal.html, one page with figures, to this folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) structural: StructuralArguments,
    #[command(flatten)]
    pub(super) intake: IntakeArguments,
}

#[cfg(test)]
impl Arguments {
    /// As a command line gives them.
    pub(super) fn of(words: &[&str]) -> Self {
        let command = <Self as clap::Args>::augment_args(clap::Command::new("modal").no_binary_name(true));
        let matches = command.try_get_matches_from(words).expect("arguments");
        <Self as clap::FromArgMatches>::from_arg_matches(&matches).expect("arguments")
    }
}

/// Orders of the sweep by default.
const ORDERS: &str = "2..30";

fn orders(text: &str) -> Result<RangeInclusive<usize>, String> {
    let wrong = || format!("'{text}' is no range of orders; write 2..60");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let low: usize = low.parse().map_err(|_| wrong())?;
    let high: usize = high.trim_start_matches('=').parse().map_err(|_| wrong())?;
    if low >= 1 && low <= high && high <= 200 { Ok(low..=high) } else { Err(wrong()) }
}

/// `20..200`: two frequencies [Hz], the second above the first.
fn band(text: &str) -> Result<(f64, f64), String> {
    let wrong = || format!("'{text}' is no band of frequencies in hertz; write 20..200");
    let (low, high) = text.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|f| f.is_finite() && *f >= 0.0).ok_or_else(wrong);
    let (low, high) = (number(low)?, number(high)?);
    if low < high { Ok((low, high)) } else { Err(wrong()) }
}

/// The command that gives the same again.
pub(super) fn again(arguments: &Arguments) -> String {
    let mut words = vec!["obsid".to_string(), "modal".into()];
    words.extend(arguments.files.iter().map(|file| file.display().to_string()));
    words.extend(arguments.intake.words());
    words.extend(arguments.input.iter().flat_map(|input| ["--input".into(), input.clone()]));
    if !arguments.channels.is_empty() {
        words.extend(["--channels".into(), arguments.channels.join(",")]);
    }
    words.extend(["--orders".into(), format!("{}..{}", arguments.orders.start(), arguments.orders.end())]);
    words.extend(arguments.from.iter().flat_map(|t| ["--from".into(), t.to_string()]));
    words.extend(arguments.to.iter().flat_map(|t| ["--to".into(), t.to_string()]));
    words.extend(arguments.band.iter().flat_map(|(low, high)| ["--band".into(), format!("{low}..{high}")]));
    words.extend(arguments.structural.words());
    words.extend(arguments.csv.iter().flat_map(|file| ["--csv".into(), file.display().to_string()]));
    words.extend(arguments.out.iter().flat_map(|out| ["--out".into(), out.display().to_string()]));
    recordings::command_line(&words)
}
