//! `--inputs`: the commands of a recording, in the place of the plant's own.

use crate::intake::IntakeArguments;
use crate::{Failure, recordings};
use dynamics::description::Plant;
use identification::{held_out, problem};
use std::path::Path;

/// What is said of a recording needs one.
///
/// # Errors
/// [`Failure::Input`] where there is none.
pub fn are_given(inputs: Option<&Path>, intake: &IntakeArguments) -> Result<(), Failure> {
    if inputs.is_some() || (intake.words().is_empty() && !intake.list) {
        return Ok(());
    }
    Err(Failure::Input(miette::miette!(
        help = "give --inputs FILE, or leave the options out that say what a file does not",
        "options say what the recording does not, and there is no --inputs"
    )))
}

/// Where a prediction begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Start {
    /// In the state that its first stretch shows, with its own parameters (biases)
    Recording,
    /// As the plant file states
    Plant,
}

/// The plant with the recorded commands, and the end of the recording \[s\].
///
/// # Errors
/// [`Failure::Input`] for a recording that cannot be read, or whose commands are not the plant's.
pub fn driven(plant: &Plant, (file, start): (&Path, Start), intake: &IntakeArguments) -> Result<(Plant, f64), Failure> {
    let intake = intake.intake(Some(plant))?;
    let mut parts = recordings::read_evidence(file, &intake, plant).and_then(|evidence| match evidence {
        recordings::Evidence::Time(parts) => Ok(parts),
        recordings::Evidence::Spectrum { .. } => {
            Err(refused(file, "this is a spectrum", "--inputs takes a time record, with commands over time"))
        }
    })?;
    if parts.len() > 1 {
        let what = format!("time starts again: {} recordings one after another", parts.len());
        return Err(refused(file, &what, "split the file where time starts again, and give one part"));
    }
    let loaded = parts.remove(0);
    loaded.notes.iter().for_each(|note| crate::tell(&format!("note: {note}")));
    let begun = match start {
        Start::Recording => held_out::begun(plant, &loaded.recording, 1),
        Start::Plant => None,
    };
    if begun.is_none() && start == Start::Recording {
        crate::tell(
            "note: begins in the state of the plant file: the recording has no reading of it, or the plant has segments",
        );
    }
    let plant = begun.as_ref().unwrap_or(plant);
    let driven = problem::driven(plant, &loaded.recording)
        .map_err(|error| refused(file, &error.to_string(), &error.cure("the plant file")))?;
    for name in &driven.own_command {
        crate::tell(&format!(
            "warning: {} has no command of actuator '{name}': it keeps the plant's own; --channel '{name} = THEIRS [UNIT]' says which it is",
            file.display()
        ));
    }
    let first_s = driven.plant.segments.first().map_or(0.0, |segment| segment.begin_s.value);
    super::duration(Some(driven.end_s - first_s), &driven.plant)?;
    Ok((driven.plant, driven.end_s))
}

fn refused(file: &Path, what: &str, cure: &str) -> Failure {
    Failure::Input(miette::miette!(help = cure.to_owned(), "--inputs {}: {what}", file.display()))
}
