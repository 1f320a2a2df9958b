//! `obsid plant parameters`: every number of a plant, and what its own experiment would tell of the
//! uncertain ones.

use super::impossible;
use super::words::digits;
use crate::progress::Share;
use crate::{Failure, plants, simulate};
use dynamics::description::{Parameter, Scope};
use identification::information::{Blind, Expected, Prediction, Simulate, predict};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// List every number of a plant, and what its experiment would tell of those with a prior
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant parameters free_floating_arm
  obsid plant parameters rig.toml --duration 5 --json        what 5 s of it tell
  obsid plant parameters rig.toml --set 'angle.noise = 1 mrad'

Expected sigmas are the Cramer-Rao bound of the priors and the readings together: commands as they are recorded, with the noise
that the file states for sensors and actuators.")]
pub struct Arguments {
    /// A plant file, or the name of a built-in plant
    plant: PathBuf,
    /// Length of the experiment [s]; the plant file's where none is given
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// Another value of a number, 'NAME = VALUE UNIT'; may be repeated
    #[arg(long, value_name = "NUMBER")]
    set: Vec<String>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// # Errors
/// [`Failure::Input`] for a plant that cannot be simulated.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut plant = plants::read(&arguments.plant)?;
    simulate::change(&mut plant, &arguments.set, &[])?;
    let duration_s = simulate::duration(arguments.duration, &plant)?;
    let bar = Share::new("predicted");
    let simulate = Simulate {
        record: &|plant, duration_s| Ok(simulation::record(plant, 0, duration_s, &mut |_| {})?),
        motion: &|plant, duration_s, visit| Ok(simulation::motion(plant, duration_s, visit)?),
    };
    let prediction = predict(&plant, duration_s, simulate, &mut |share| bar.show(share));
    bar.end();
    let prediction = prediction.map_err(|error| impossible(&arguments.plant, &error))?;
    let numbers = plant.parameters();
    crate::print(&if arguments.json {
        format!("{}\n", as_json(&plant.name, duration_s, &numbers, &prediction))
    } else {
        page(duration_s, &numbers, &prediction)
    });
    Ok(())
}

const fn scope(scope: Scope) -> &'static str {
    match scope {
        Scope::Shared => "shared",
        Scope::PerRecording => "per recording",
        Scope::PerSegment => "per segment",
    }
}

fn found<'p>(prediction: &'p Prediction, name: &str) -> Option<&'p Expected> {
    prediction.parameters.iter().find(|expected| expected.name == name)
}

fn as_json(name: &str, duration_s: f64, numbers: &[Parameter], prediction: &Prediction) -> Value {
    let number = |number: &Parameter| {
        let expected = found(prediction, &number.name);
        json!({
            "name": number.name, "unit": number.unit, "value": number.value, "prior_sigma": number.sigma,
            "scope": scope(number.scope), "expected_sigma": expected.map(|e| e.sigma),
            "expected_sigma_alone": expected.map(|e| e.sigma_alone), "identifiability": expected.map(|e| e.identifiability.text()),
        })
    };
    let blind = |blind: &Blind| {
        let weights = blind.weights.iter().map(|(name, weight)| json!({ "name": name, "weight": weight }));
        json!({ "weights": weights.collect::<Vec<_>>(), "posterior_over_prior": blind.ratio })
    };
    json!({
        "plant": name, "duration_s": duration_s, "samples": prediction.samples,
        "parameters": numbers.iter().map(number).collect::<Vec<_>>(),
        "not_found": prediction.blind.iter().map(blind).collect::<Vec<_>>(),
        "sensors_without_noise": prediction.without_noise,
    })
}

fn page(duration_s: f64, numbers: &[Parameter], prediction: &Prediction) -> String {
    let width = numbers.iter().map(|number| number.name.len()).max().unwrap_or(0).max(9);
    let (uncertain, known): (Vec<_>, Vec<_>) = numbers.iter().partition(|number| number.sigma.is_some());
    let mut text = format!(
        "{:<width$}  {:<12} {:>14} {:>11} {:>11} {:>9}  {:<13} identifiability\n",
        "parameter", "unit", "value", "prior", "expected", "%", "scope"
    );
    for number in &uncertain {
        text.push_str(&row(number, found(prediction, &number.name), width));
    }
    let _ = writeln!(
        text,
        "\n{} of {} numbers have a prior; expected: after {duration_s} s of the file's own experiment ({} samples)",
        uncertain.len(),
        numbers.len(),
        prediction.samples
    );
    not_found(prediction, &mut text);
    if !prediction.without_noise.is_empty() {
        let names = prediction.without_noise.join(", ");
        let _ = writeln!(text, "\nwithout noise or resolution, hence without weight here: {names}");
    }
    let _ = writeln!(text, "\n{:<width$}  {:<12} {:>14}", "known", "unit", "value");
    for number in &known {
        let _ = writeln!(text, "{:<width$}  {:<12} {:>14}", number.name, number.unit, digits(number.value, 6));
    }
    text
}

/// An uncertain number.
fn row(number: &Parameter, expected: Option<&Expected>, width: usize) -> String {
    let short = |value: f64| digits(value, 3);
    let percent = expected.filter(|e| e.value != 0.0).map(|e| digits(100.0 * e.sigma / e.value.abs(), 2));
    format!(
        "{:<width$}  {:<12} {:>14} {:>11} {:>11} {:>9}  {:<13} {}\n",
        number.name,
        number.unit,
        digits(number.value, 6),
        number.sigma.map_or("-".into(), short),
        expected.map_or("-".into(), |e| short(e.sigma)),
        percent.unwrap_or_else(|| "-".into()),
        scope(number.scope),
        // what is only noise is not in the mean
        expected.map_or("of the noise", |expected| expected.identifiability.text())
    )
}

fn not_found(prediction: &Prediction, text: &mut String) {
    if prediction.blind.is_empty() {
        return;
    }
    let sigma = |name: &str| found(prediction, name).map_or((0.0, ""), |e| (e.prior_sigma, e.unit.as_str()));
    let _ = writeln!(text, "\nnot shown by this experiment (a move by one prior sigma that hardly changes a reading):");
    for blind in &prediction.blind {
        let term = |(name, weight): &(String, f64)| {
            let (sigma, unit) = sigma(name);
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            let move_by = digits(weight * sigma, 3);
            format!("{name} {}{move_by}{unit}", if *weight < 0.0 { "" } else { "+" })
        };
        let terms: Vec<String> = blind.weights.iter().map(term).collect();
        let _ = writeln!(text, "  {}", terms.join(", "));
    }
}
