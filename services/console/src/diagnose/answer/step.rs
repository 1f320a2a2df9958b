//! The third sentence: a command, a file, or the data that would decide.

use super::{Diagnosed, Noise, most_shifted, supported};
use crate::diagnose::paragraph::not_found;
use discovery::diagnose::Verdict;
use discovery::mislabelled::{Mislabelled, Mistake};
use dynamics::description::{self, Plant};
use identification::held_out::Status;

/// What to do next.
pub fn step(diagnosed: &Diagnosed) -> String {
    let diagnosis = &diagnosed.diagnosis;
    if let Some(label) = diagnosed.labels.first() {
        return relabel(label);
    }
    let is_open = matches!(diagnosis.verdict, Verdict::NoiseModel | Verdict::CannotDecide | Verdict::None);
    if diagnosed.interrupted && is_open {
        return "diagnose again without an interruption, or with `--effort quick`".into();
    }
    match diagnosis.verdict {
        Verdict::Named | Verdict::Sensor => with_augmented(diagnosed),
        Verdict::NotSeparable => experiment(diagnosed).unwrap_or_else(|| {
            format!(
                "add a sensor, or excite another coordinate, and diagnose both recordings together: no experiment with the inputs of {} separates these effects",
                diagnosed.case.plant_file
            )
        }),
        Verdict::NotInCatalogue if diagnosed.case.fitted.is_empty() => {
            "record the modes at two amplitudes in random order, which separates time from amplitude".into()
        }
        Verdict::NotInCatalogue => {
            "read the law off its map in report.html of `--out`, and give another recording of the experiment with `--held-out`, in which a law recurs".into()
        }
        Verdict::NoiseModel => {
            let file = &diagnosed.case.plant_file;
            let general = || format!("correct the noise that {file} states, and diagnose again");
            Noise::of(&diagnosis.reason).map_or_else(general, |noise| noise.cure(file))
        }
        Verdict::ParameterConflict => {
            format!(
                "measure {}, or widen its standard deviation in {}, and diagnose again",
                most_shifted(&diagnosed.diagnosis).map_or("that parameter", |moved| &moved.name),
                diagnosed.case.plant_file
            )
        }
        Verdict::InputTiming => format!(
            "find out whether commands are held or linear between their stamps, and when they are stamped; correct them, and diagnose again with {}",
            diagnosed.case.plant_file
        ),
        Verdict::CannotDecide => undecided(diagnosed),
        Verdict::None => as_it_is(diagnosed),
    }
}

/// The line of a map that puts a label right.
fn relabel(label: &Mislabelled) -> String {
    let line = |name: &String| match label.mistake {
        Mistake::Factor(factor, _) => format!("`{name} = {{ name = \"{name}\", scale = {:.7} }}`", 1.0 / factor),
        Mistake::Swapped => {
            let other = label.channels.iter().find(|other| *other != name).unwrap_or(name);
            format!("`{name} = \"{other}\"`")
        }
    };
    let lines: Vec<String> = label.channels.iter().map(line).collect();
    format!(
        "correct the header of {}, or give `--map` a file with {} below `[channels]`",
        label.recording,
        lines.join(" and ")
    )
}

/// The plant with the confirmed effects, else what would confirm them.
fn with_augmented(diagnosed: &Diagnosed) -> String {
    let confirmed = supported(&diagnosed.diagnosis).iter().any(|effect| effect.status == Status::Confirmed);
    if let Some(path) = &diagnosed.diagnosis.augmented_plant {
        let commands = diagnosed.case.commands_of_the_fit(path);
        let shown = if commands.len() > 1 {
            "show how the plant with what was confirmed follows it"
        } else {
            "simulates the plant with what was confirmed"
        };
        let all: Vec<String> = commands.iter().map(|command| format!("`{command}`")).collect();
        return format!("{} {shown}", all.join(" and "));
    }
    if confirmed && diagnosed.offered.augmented {
        return "add `--out report` to the command: report/augmented.toml is the plant with what was confirmed".into();
    }
    experiment(diagnosed)
        .unwrap_or_else(|| "record the plant once more and give it with `--held-out`, which confirms or rejects".into())
}

/// The experiment that separates rivals.
fn experiment(diagnosed: &Diagnosed) -> Option<String> {
    if let Some(path) = &diagnosed.diagnosis.next_experiment {
        return Some(format!("fly the experiment of {path} and diagnose both recordings together"));
    }
    let offered = diagnosed.offered.next;
    offered.then(|| "add `--out report` to the command: report/next_experiment.toml separates the rivals".into())
}

/// Sensors whose noise the plant file leaves at zero: no likelihood is defined with them.
fn without_noise(plant: &Plant) -> Vec<String> {
    let is_zero = |noise: &description::Noise| match noise {
        description::Noise::PerSample(sigma) | description::Noise::Density(sigma) => sigma.value <= 0.0,
    };
    plant.sensors.iter().filter(|sensor| is_zero(&sensor.noise)).map(|sensor| format!("'{}'", sensor.name)).collect()
}

fn undecided(diagnosed: &Diagnosed) -> String {
    let silent = without_noise(&diagnosed.case.plant);
    if !silent.is_empty() {
        let (file, names) = (&diagnosed.case.plant_file, silent.join(", "));
        return format!(
            "state the noise of sensor {names} in {file} (its key `noise`, the standard deviation of one sample), and diagnose again; `obsid plant new` estimates it from a recording"
        );
    }
    if let Some(next) = experiment(diagnosed) {
        return next;
    }
    if diagnosed.case.fitted.is_empty() {
        return "measure more modes, or their shapes and damping, and diagnose again".into();
    }
    match diagnosed.case.held_out.is_empty() {
        true => "record the experiment once more and give it with `--held-out`: physics recurs, noise does not".into(),
        false => "record a longer run with more excitation, and diagnose again".into(),
    }
}

/// The plant as it is, and the effect that could hide.
fn as_it_is(diagnosed: &Diagnosed) -> String {
    let plant = &diagnosed.case.plant_file;
    match not_found(&diagnosed.diagnosis).is_empty() {
        true => format!("use {plant} as it is"),
        false => format!("use {plant} as it is; `--json` lists as detection_limits what could stay hidden"),
    }
}
