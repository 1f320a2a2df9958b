//! `obsid plant check`: every error and doubt of plant files, with place and cure.

use super::impossible;
use super::words::count;
use crate::located::Located;
use crate::{Failure, plants};
use dynamics::description::Plant;
use plant_file::FileError;
use serde_json::{Value, json};
use simulation::Simulator;
use std::path::{Path, PathBuf};

/// Say what is wrong with plant files, where, and what to do; exit code 3 if anything is
#[derive(clap::Args)]
#[command(after_help = "Examples:
  obsid plant check rig.toml
  obsid plant check deploy/plants/*.toml --json    one object: files[]{file, usable, errors[], warnings[]}")]
pub struct Arguments {
    /// Plant files, or names of built-in plants
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// # Errors
/// [`Failure::Input`] if a file cannot be used; the reports of all others are out by then.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mut objects, mut first) = (Vec::new(), None);
    for path in &arguments.files {
        let Checked { object, said, failure } = check(path);
        objects.push(object);
        if !arguments.json {
            crate::print(&said);
        }
        match (failure, &first) {
            (Some(failure), None) => first = Some(failure),
            (Some(Failure::Input(report)), Some(_)) => {
                crate::tell(&crate::visible::cut_snippets(&format!("{report:?}")))
            }
            (Some(Failure::Run(reason) | Failure::Degraded(reason) | Failure::Usage(reason)), Some(_)) => {
                crate::tell(&reason)
            }
            (None, _) | (Some(Failure::Interrupted), Some(_)) => {}
        }
    }
    if arguments.json {
        crate::print(&format!("{}\n", json!({ "files": objects })));
    }
    first.map_or(Ok(()), Err)
}

struct Checked {
    object: Value,
    said: String,
    failure: Option<Failure>,
}

fn check(path: &Path) -> Checked {
    let name = path.display().to_string();
    let refused = |failure: Failure, errors: Vec<Value>| Checked {
        object: json!({ "file": name, "usable": false, "errors": errors, "warnings": [] }),
        said: String::new(),
        failure: Some(failure),
    };
    let text = match plants::text_of(&name, Path::new("")) {
        Ok(text) => text,
        Err((message, cure)) => {
            let error = json!({ "message": message, "cure": cure });
            return refused(Failure::Input(miette::miette!(help = cure, "{message}")), vec![error]);
        }
    };
    let parsed = match plant_file::parse(&name, &text) {
        Ok(parsed) => parsed,
        Err(errors) => {
            let objects = errors.iter().take(plants::ERRORS_MAX).map(located).collect();
            return refused(plants::refusal(&name, &text, errors), objects);
        }
    };
    for warning in parsed.warnings.iter().take(plants::ERRORS_MAX) {
        let FileError { span, message, cure, .. } = warning.clone();
        let doubt = Located::new(&name, &text, span, message, cure).into_warning();
        crate::tell(&format!("{:?}", miette::Report::new(doubt)));
    }
    let simulator = match Simulator::new(&parsed.plant, 1, &parsed.plant.name) {
        Ok(simulator) => simulator,
        Err(error) => return refused(impossible(path, &error), vec![json!({ "message": error.to_string() })]),
    };
    let states = simulator.system().states().len();
    let summary = summary(&parsed.plant, states);
    let warnings: Vec<Value> = parsed.warnings.iter().map(located).collect();
    Checked {
        said: format!("{name}: {summary}: can be simulated\n"),
        object: json!({ "file": name, "usable": true, "errors": [], "warnings": warnings, "summary": summary }),
        failure: None,
    }
}

fn located(error: &FileError) -> Value {
    json!({ "line": error.line, "column": error.column, "message": error.message, "cure": error.cure })
}

/// `3 bodies, 1 tank, 2 actuators, 5 sensors, 12 states`; what there is none of is left out.
fn summary(plant: &Plant, states: usize) -> String {
    let modes = plant.appendages.iter().map(|appendage| appendage.modes.len()).sum();
    let parts = [
        (plant.bodies.len(), "body"),
        (plant.tanks.len(), "tank"),
        (modes, "mode"),
        (plant.actuators.len(), "actuator"),
        (plant.controllers.len(), "controller"),
        (plant.sensors.len(), "sensor"),
        (plant.effects.len(), "effect"),
        (states, "state"),
    ];
    let present = parts.iter().filter(|(number, _)| *number > 0).map(|(number, one)| count(*number, one));
    present.collect::<Vec<_>>().join(", ")
}
