//! `obsid bench study-case`: one craft, flown through all arcs in one thread by the partitions'
//! own code; how its joint estimates lie about the truths drawn.

use super::{Answers, Arguments};
use crate::outcome::{Generation, JointOutcome, JointRow, Outcome};
use crate::run::{Common, config};
use crate::scenario_run::LinkKind;
use crate::scratch::Scratch;
use crate::{Failure, launch, scenario_file};
use plant_file::scenario::Opened;
use serde_json::{Value, json};
use std::fmt::Write;
use telemetry::JointVerdict;

/// Half the width of a 95 % interval [standard deviations].
const HALF_WIDTH: f64 = 1.96;

/// What one flight came to.
struct Trial {
    seed: u64,
    accepted: bool,
    words: String,
    generations: usize,
    /// By arc.
    chi2_per_row: Vec<(String, f64)>,
    predicted: Option<f64>,
    nees: Option<f64>,
    /// Name, error over sigma, and whether the sigma is below a fifth of the truth; of base
    /// parameters.
    z: Vec<(String, f64, bool)>,
    /// Of the plant file's own parameters.
    physical_z: Vec<f64>,
    wall_s: f64,
}

/// # Errors
/// [`Failure::Run`] where a flight fails or is interrupted.
pub(super) fn measure(arguments: &Arguments, to: &mut Answers) -> Result<(), Failure> {
    let seeds = (0..u64::from(arguments.trials)).map(|trial| arguments.seed.wrapping_add(trial));
    let trials = seeds.map(fly).collect::<Result<Vec<Trial>, Failure>>()?;
    let figures = Figures::of(&trials);
    let object = || {
        let rows: Vec<Value> = trials.iter().map(Trial::json).collect();
        let object =
            json!({ "problem": "study-case", "seed": arguments.seed, "trials": rows, "figures": figures.json() });
        format!("{object}\n")
    };
    to.add(|| figures.rows().map(|row| row.join("  ") + "\n").concat(), Some(markdown(&figures, &trials)), object);
    Ok(())
}

fn fly(seed: u64) -> Result<Trial, Failure> {
    let (joint, wall_s) = flown(scenario_file::study_case()?, seed)?;
    Trial::of(seed, &joint, wall_s).ok_or_else(|| Failure::Run(format!("seed {seed}: no generation of messages")))
}

/// One flight of `opened` in lockstep, and how long it took \[s\].
///
/// # Errors
/// [`Failure::Run`] where it fails or is interrupted.
pub(super) fn flown(opened: Opened, seed: u64) -> Result<(JointOutcome, f64), Failure> {
    let mut run = config(opened, &Common::default(), None)?;
    run.config.seed = seed;
    let scratch = Scratch::new()?;
    run.config.record = scratch.file("results.mcap");
    let signals = launch::take_signals().map_err(|error| Failure::Run(format!("signals: {error}")))?;
    let finished = launch::launch(&run, LinkKind::Lockstep, None, &scratch, signals);
    let outcome = Outcome::read(&run, finished, true);
    let failed = |reason: String| Failure::Run(format!("seed {seed}: {reason}"));
    if let Some(reason) = outcome.failure {
        return Err(failed(reason));
    }
    let joint = outcome.joint.ok_or_else(|| failed("no joint estimate".into()))?;
    Ok((joint, outcome.wall_s))
}

impl Trial {
    fn of(seed: u64, joint: &JointOutcome, wall_s: f64) -> Option<Self> {
        let last: &Generation = joint.generations.last()?;
        let (base, physical): (Vec<&JointRow>, Vec<&JointRow>) = last.rows.iter().partition(|row| row.block == "base");
        Some(Self {
            seed,
            accepted: joint.verdict == JointVerdict::Accepted,
            words: joint.words(),
            generations: joint.generations.len(),
            chi2_per_row: last.arcs.iter().map(|row| (row.arc.clone(), row.chi2_per_row)).collect(),
            predicted: joint.predicted.as_ref().map(|(_, chi2, _)| *chi2),
            nees: last.nees,
            z: base.iter().map(|row| (row.name.clone(), row.z(), row.is_bounded())).collect(),
            physical_z: physical.iter().map(|row| row.z()).collect(),
            wall_s,
        })
    }

    fn json(&self) -> Value {
        let chi2 = self.chi2_per_row.iter().map(|(arc, value)| json!({ "arc": arc, "value": value }));
        json!({
            "seed": self.seed, "accepted": self.accepted, "reason": self.words, "generations": self.generations,
            "chi2_per_row": chi2.collect::<Vec<_>>(), "predicted_chi2_per_row": self.predicted, "nees": self.nees,
            "rms_z_base": rms(self.z.iter().map(|(_, z, _)| *z)), "rms_z": rms(self.physical_z.iter().copied()),
            "z_max": self.z_max(), "wall_s": self.wall_s,
        })
    }

    fn z_max(&self) -> f64 {
        let all = self.z.iter().map(|(_, z, _)| *z).chain(self.physical_z.iter().copied());
        all.map(f64::abs).fold(0.0, f64::max)
    }
}

/// Over all flights.
struct Figures {
    accepted: usize,
    trials: usize,
    /// Rms error over bound of each base parameter whose bound is below a fifth in every flight.
    ratios: Vec<(String, f64)>,
    coverage_percent: f64,
    nees: Vec<f64>,
    predicted: Vec<f64>,
}

impl Figures {
    fn of(trials: &[Trial]) -> Self {
        let names: Vec<String> =
            trials.first().map_or(Vec::new(), |trial| trial.z.iter().map(|(name, ..)| name.clone()).collect());
        let ratio = |(i, name): (usize, String)| {
            let of: Option<Vec<f64>> =
                trials.iter().map(|trial| trial.z.get(i).filter(|(.., known)| *known).map(|(_, z, _)| *z)).collect();
            of.map(|z| (name, rms(z.into_iter())))
        };
        let z: Vec<f64> = trials.iter().flat_map(|trial| &trial.z).map(|(_, z, _)| z.abs()).collect();
        let inside = z.iter().filter(|z| **z < HALF_WIDTH).count();
        Self {
            accepted: trials.iter().filter(|trial| trial.accepted).count(),
            trials: trials.len(),
            ratios: names.into_iter().enumerate().filter_map(ratio).collect(),
            coverage_percent: 100.0 * inside as f64 / z.len().max(1) as f64,
            nees: trials.iter().filter_map(|trial| trial.nees).collect(),
            predicted: trials.iter().filter_map(|trial| trial.predicted).collect(),
        }
    }

    fn worst(&self) -> (&str, f64) {
        let worst = self.ratios.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        worst.map_or(("", f64::NAN), |(name, ratio)| (name, *ratio))
    }

    /// Figure, must and found.
    fn rows(&self) -> [[String; 3]; 6] {
        let (name, ratio) = self.worst();
        let of_all = rms(self.ratios.iter().map(|(_, ratio)| *ratio));
        let range = |values: &[f64], digits: usize| {
            let (low, high) =
                values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
            format!("{:.digits$} ({low:.digits$} to {high:.digits$})", mean(values))
        };
        [
            ["flights accepted".into(), "all".into(), format!("{} of {}", self.accepted, self.trials)],
            ["RMSE over bound, of all parameters".into(), "".into(), format!("{of_all:.2}")],
            ["RMSE over bound, largest".into(), "1.2 over 100 flights".into(), format!("{ratio:.2} ({name})")],
            ["in 95 % intervals".into(), "93-97 %".into(), format!("{:.1} %", self.coverage_percent)],
            ["NEES a parameter, mean and range".into(), "0.9-1.15".into(), range(&self.nees, 2)],
            ["held out, chi2 a reading".into(), "0.98-1.02".into(), range(&self.predicted, 3)],
        ]
    }

    fn json(&self) -> Value {
        let ratios = self.ratios.iter().map(|(name, ratio)| json!({ "name": name, "rmse_over_bound": ratio }));
        json!({
            "accepted": self.accepted, "trials": self.trials, "rmse_over_bound": ratios.collect::<Vec<_>>(),
            "coverage_percent": self.coverage_percent, "nees": mean(&self.nees),
            "predicted_chi2_per_row": mean(&self.predicted),
        })
    }
}

fn markdown(figures: &Figures, trials: &[Trial]) -> String {
    let mut text = "| figure | must | found |\n|---|---|---|\n".to_owned();
    for [name, must, found] in figures.rows() {
        let _ = writeln!(text, "| {name} | {must} | {found} |");
    }
    text += "\n| seed | verdict | chi2 a reading of the arcs | held out | NEES a parameter | rms z, physical and base | largest z | generations |\n";
    text += "|---|---|---|---|---|---|---|---|\n";
    for trial in trials {
        let chi2: Vec<String> = trial.chi2_per_row.iter().map(|(_, value)| format!("{value:.3}")).collect();
        let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |value| format!("{value:.digits$}"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.2}, {:.2} | {:.1} | {} |",
            trial.seed,
            trial.words,
            chi2.join(", "),
            number(trial.predicted, 3),
            number(trial.nees, 2),
            rms(trial.physical_z.iter().copied()),
            rms(trial.z.iter().map(|(_, z, _)| *z)),
            trial.z_max(),
            trial.generations
        );
    }
    text
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    libm::sqrt(sum / f64::from(count.max(1)))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
