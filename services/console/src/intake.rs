//! What a user says beside a recording: the options that every command which reads one has.

use crate::Failure;
use crate::plants::utf8_text;
use crate::recordings::nearest;
use dynamics::description::Plant;
use recording::intake::map_example;
use recording::{Assignment, Intake, ListedDataset, TimeColumn};
use report::text::short;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What the file does not say.
#[derive(clap::Args, Clone, Default)]
#[command(next_help_heading = "What the file does not say")]
pub struct IntakeArguments {
    /// Column of the times and its unit: stamp:us, counter:100Hz, row:100Hz where there is no clock
    #[arg(long, value_name = "NAME[:UNIT]")]
    pub time_column: Option<String>,
    /// A channel under your own name with its unit, 'OWN = THEIRS [UNIT]'; may be repeated
    #[arg(long, value_name = "CHANNEL")]
    pub channel: Vec<String>,
    /// TOML file that says the same for the next file of the kind: [channels] own = "theirs [unit]"
    #[arg(long, value_name = "FILE")]
    pub map: Option<PathBuf>,
    /// Dataset, topic or message that is meant, where a file holds several
    #[arg(long, visible_alias = "topic", value_name = "NAME")]
    pub dataset: Option<String>,
    /// List datasets, channels, units, rates and spans of the files, and do no more
    #[arg(long)]
    pub list: bool,
}

impl IntakeArguments {
    /// What is said, the command line before the map.
    ///
    /// # Errors
    /// [`Failure::Input`] for an option or a map that cannot be read, and for an own name that
    /// `plant` has not.
    pub fn intake(&self, plant: Option<&Plant>) -> Result<Intake, Failure> {
        let time_column = self.time_column.as_deref().map(TimeColumn::parse).transpose().map_err(Failure::input)?;
        let channels = self.channel.iter().map(|text| Assignment::parse(text)).collect::<Result<_, _>>();
        let channels = channels.map_err(Failure::input)?;
        let mut intake = Intake { time_column, dataset: self.dataset.clone(), channels, ..Intake::default() };
        if let Some(map) = &self.map {
            let text = utf8_text(map).map_err(|(message, cure)| {
                let cure = cure.unwrap_or_else(|| format!("--map takes the path of a TOML file, {}", map_example()));
                Failure::Input(miette::miette!(help = cure, "{message}"))
            })?;
            intake.read_map(&map.display().to_string(), &text).map_err(Failure::input)?;
        }
        if let Some(plant) = plant {
            check_names(&intake, plant)?;
        }
        Ok(intake)
    }

    /// The words of a command line that say the same.
    pub fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        let mut add = |flag: &str, value: &str| words.extend([flag.to_owned(), value.to_owned()]);
        self.time_column.iter().for_each(|value| add("--time-column", value));
        self.channel.iter().for_each(|value| add("--channel", value));
        self.map.iter().for_each(|value| add("--map", &value.display().to_string()));
        self.dataset.iter().for_each(|value| add("--dataset", value));
        words
    }
}

/// Every own name is one of the plant's.
fn check_names(intake: &Intake, plant: &Plant) -> Result<(), Failure> {
    let sensors = plant.sensors.iter().map(|sensor| sensor.name.as_str());
    let known: Vec<&str> = sensors.chain(plant.actuators.iter().map(|actuator| actuator.name.as_str())).collect();
    match intake.channels.iter().find(|of| !known.contains(&of.own.as_str())) {
        None => Ok(()),
        Some(of) => {
            let near = nearest(&of.own, known.iter().copied());
            let meant = near.map_or(String::new(), |near| format!("did you mean '{near}'? "));
            let cure = format!("{meant}left stands the name in the plant: {}", known.join(", "));
            let found = format!("'{}' is no sensor or actuator of plant '{}'", of.own, plant.name);
            Err(Failure::input(of.unknown_own(found, cure)))
        }
    }
}

/// Prints what the files hold.
///
/// # Errors
/// [`Failure::Input`] for a file that cannot be read.
pub fn list(files: &[&Path], arguments: &IntakeArguments, as_json: bool) -> Result<(), Failure> {
    let intake = arguments.intake(None)?;
    let mut all = Vec::new();
    for file in files {
        all.push((file.display().to_string(), recording::list(file, &intake).map_err(Failure::input)?));
    }
    crate::print(&if as_json { format!("{}\n", json(&all)) } else { in_words(&all) });
    Ok(())
}

fn json(all: &[(String, Vec<ListedDataset>)]) -> Value {
    let dataset = |dataset: &ListedDataset| {
        let channel = |c: &recording::ListedChannel| json!({ "name": c.name, "unit": c.unit, "samples": c.samples, "rate_hz": c.rate_hz, "start_s": c.start_s, "end_s": c.end_s });
        json!({ "name": dataset.name, "channels": dataset.channels.iter().map(channel).collect::<Vec<_>>(), "notes": dataset.notes })
    };
    let file = |(file, datasets): &(String, Vec<ListedDataset>)| json!({ "file": file, "datasets": datasets.iter().map(dataset).collect::<Vec<_>>() });
    let files: Vec<Value> = all.iter().map(file).collect();
    let datasets: Vec<Value> = all.iter().flat_map(|(_, datasets)| datasets.iter().map(dataset)).collect();
    json!({ "files": files, "datasets": datasets })
}

fn in_words(all: &[(String, Vec<ListedDataset>)]) -> String {
    let mut text = String::new();
    for (file, datasets) in all {
        let _ = writeln!(text, "{file}");
        for dataset in datasets {
            if !dataset.name.is_empty() {
                let _ = writeln!(text, "dataset {}", dataset.name);
            }
            let _ = writeln!(
                text,
                "  {:<36} {:<10} {:>10} {:>12} {:>12} {:>12}",
                "channel", "unit", "samples", "rate [Hz]", "from [s]", "to [s]"
            );
            for c in &dataset.channels {
                let number = |value: Option<f64>| value.map_or("-".into(), short);
                let unit = c.unit.as_deref().unwrap_or("not stated");
                let (rate, start, end) = (number(c.rate_hz), number(c.start_s), number(c.end_s));
                let _ =
                    writeln!(text, "  {:<36} {unit:<10} {:>10} {rate:>12} {start:>12} {end:>12}", c.name, c.samples);
            }
            for note in &dataset.notes {
                text.push_str(&crate::recordings::wrapped(&format!("note: {note}"), "  "));
            }
        }
    }
    text
}
