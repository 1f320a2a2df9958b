//! Several setups of one structure with common reference sensors (`--setup`).

use super::merge::Merge;
use super::structural_arguments::MergeBy;
use super::time::{self, BLOCK_ROWS, Chosen, OUTPUT_ONLY};
use super::{Arguments, FoundMode, Outcome, Structure};
use crate::{Failure, recordings};
use modal::gram::output_gram;
use modal::record::Record;
use modal::setups::{Merged, MergedMode, Setup, SetupMode, merge, pre_scaled};
use modal::ssi_cov::Pole;
use modal::{Config, ModalError, ModalIdentifier, Mode, OnsetGate, Selection, ShapeScale, StabilityCriteria};
use std::path::PathBuf;

/// Rates of two setups are equal up to the rounding of stamps.
const SAME_RATE: f64 = 1e-4;

/// # Errors
/// [`Failure::Input`] for setups that cannot be read or merged.
pub(super) fn outcome(arguments: &Arguments) -> Result<Outcome, Failure> {
    let asked = &arguments.structural;
    let files: Vec<&PathBuf> = arguments.files.iter().chain(&asked.setup).collect();
    let mut all = Vec::new();
    for file in &files {
        let imported = recording::read_with(file, &arguments.intake.intake(None)?).map_err(Failure::input)?;
        let set = recording::series(imported).map_err(Failure::input)?;
        all.push(time::choose(arguments, &set)?);
    }
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    let references = references(&asked.references, &names, &all)?;
    let chosen: Vec<Chosen> = all.into_iter().map(|chosen| references_first(chosen, &references)).collect();
    let count = references.len();
    let mut setups = Vec::new();
    for (chosen, file) in chosen.iter().zip(&files) {
        let found = fly(arguments, chosen, ShapeScale::FirstChannels(count));
        let found = found.map_err(|error| {
            Failure::Input(miette::miette!(help = "give a longer record of this setup", "{}: {error}", file.display()))
        })?;
        setups.push(Setup { channels: chosen.names.clone(), modes: found.modes.iter().map(of_setup).collect() });
    }
    name_apart(&mut setups, &files, count);
    let merged = merge(&setups, count);
    let mut advice = disagreements(&merged, &names);
    let (method, deviations, modes) = match asked.merge {
        MergeBy::Poser => {
            let whole = merged.modes.iter().filter(|mode| mode.found_in.iter().all(Option::is_some));
            advice.extend(missing(&merged, &names));
            (
                "each setup by covariance-driven stochastic subspace, merged by inverse variance and references (PoSER)",
                "of the setups by inverse variance, widened where they differ by more; shapes at the scale of the references",
                whole.map(of_merged).collect::<Vec<_>>(),
            )
        }
        MergeBy::Preger => (
            "all setups at once, covariances scaled by the references before (PreGER), poles that repeat in six orders",
            "none stated: the setups together have no propagation of their covariances",
            at_once(arguments, &chosen, count)?.iter().map(of_pole).collect(),
        ),
    };
    let records: Vec<String> = chosen.iter().map(time::record_in_words).collect();
    let notes = chosen
        .iter()
        .zip(&names)
        .flat_map(|(chosen, name)| chosen.notes.iter().map(move |note| format!("{name}: {note}")));
    Ok(Outcome {
        method,
        kind: OUTPUT_ONLY,
        deviations,
        channels: merged.channels.clone(),
        record: format!("{} setups with references {}: {}", files.len(), references.join(", "), records.join("; ")),
        modes,
        advice,
        notes: notes.collect(),
        structure: Structure {
            merge: Some(Merge { by: asked.merge, references, files: names, records, setups, merged }),
            ..Structure::default()
        },
        ..Outcome::default()
    })
}

/// The identifier that flies, segments at gaps and where the record jumps.
fn fly(arguments: &Arguments, chosen: &Chosen, shapes: ShapeScale) -> Result<Selection, ModalError> {
    let record = &chosen.record;
    let mut config = Config::new(record.channels, record.sample_rate_hz);
    config.selection.order_max = *arguments.orders.end();
    config.selection.shape_deviations = Some(shapes);
    let (mut identifier, mut gate) = (ModalIdentifier::new(config), OnsetGate::default());
    for (k, row) in record.outputs.chunks_exact(record.channels).enumerate() {
        if chosen.gaps.contains(&k) {
            gate.end_segment(&mut identifier);
            identifier.open_segment();
        }
        gate.push(row, &mut identifier);
    }
    gate.end_segment(&mut identifier);
    identifier.identify_with_reasons()
}

/// The channels named, or those of the same name in all setups.
fn references(asked: &[String], files: &[String], all: &[Chosen]) -> Result<Vec<String>, Failure> {
    for (chosen, file) in all.iter().zip(files) {
        if let Some(missing) = asked.iter().find(|name| !chosen.names.contains(name)) {
            let near = recordings::nearest(missing, chosen.names.iter().map(String::as_str));
            let near = near.map_or(String::new(), |near| format!(" (is it '{near}'?)"));
            return Err(Failure::Input(miette::miette!(
                help = format!("references are channels of every setup; {file} has {}", chosen.names.join(", ")),
                "{file} has no reference '{missing}'{near}"
            )));
        }
    }
    if !asked.is_empty() {
        return Ok(asked.to_vec());
    }
    let common: Vec<String> =
        all[0].names.iter().filter(|name| all.iter().all(|chosen| chosen.names.contains(name))).cloned().collect();
    if common.is_empty() || all.iter().all(|chosen| chosen.names.len() == common.len()) {
        let what = if common.is_empty() { "no channel has" } else { "all channels have" };
        return Err(Failure::Input(miette::miette!(
            help = "name the sensors that stayed at their places: --references a,b",
            "{what} the same name in all {} setups: which are the references?",
            all.len()
        )));
    }
    Ok(common)
}

fn references_first(chosen: Chosen, references: &[String]) -> Chosen {
    let place = |name: &String| chosen.names.iter().position(|known| known == name);
    let mut order: Vec<usize> = references.iter().filter_map(place).collect();
    order.extend((0..chosen.names.len()).filter(|k| !references.contains(&chosen.names[*k])));
    let Record { sample_rate_hz, channels, outputs, .. } = &chosen.record;
    let outputs = outputs.chunks_exact(*channels).flat_map(|row| order.iter().map(|k| row[*k])).collect();
    Chosen {
        names: order.iter().map(|k| chosen.names[*k].clone()).collect(),
        record: Record::of_outputs(*sample_rate_hz, *channels, outputs),
        ..chosen
    }
}

/// Moving sensors that carry one name in several setups are at several places.
fn name_apart(setups: &mut [Setup], files: &[&PathBuf], references: usize) {
    let moving: Vec<String> = setups.iter().flat_map(|setup| setup.channels[references..].to_vec()).collect();
    for (j, setup) in setups.iter_mut().enumerate() {
        let stem = files[j].file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned());
        for name in &mut setup.channels[references..] {
            if moving.iter().filter(|other| *other == name).count() > 1 {
                *name = format!("{stem}:{name}");
            }
        }
    }
}

fn of_setup(mode: &Mode) -> SetupMode {
    SetupMode {
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        sigma_frequency_hz: mode.sigma_frequency_hz,
        sigma_damping: mode.sigma_damping,
        shape: mode.mode_shape.clone(),
        shape_deviation: mode.shape_deviation.clone(),
    }
}

fn of_merged(mode: &MergedMode) -> FoundMode {
    FoundMode {
        frequency_hz: mode.frequency_hz,
        frequency_sd: Some(mode.sigma_frequency_hz).filter(|sigma| sigma.is_finite()),
        damping: Some(mode.damping_ratio),
        damping_sd: Some(mode.sigma_damping).filter(|sigma| sigma.is_finite()),
        phase_collinearity: Some(modal::mac::modal_phase_collinearity(&mode.shape)),
        shape: mode.shape.clone(),
        shape_sd: mode.shape_deviation.clone(),
    }
}

fn of_pole(pole: &Pole) -> FoundMode {
    FoundMode {
        frequency_hz: pole.frequency_hz,
        damping: Some(pole.damping_ratio),
        phase_collinearity: Some(pole.phase_collinearity),
        shape: pole.mode_shape.clone(),
        ..FoundMode::default()
    }
}

/// One identification of all setups.
fn at_once(arguments: &Arguments, chosen: &[Chosen], references: usize) -> Result<Vec<Pole>, Failure> {
    let rate = chosen[0].record.sample_rate_hz;
    if let Some(other) = chosen.iter().find(|other| (other.record.sample_rate_hz / rate - 1.0).abs() > SAME_RATE) {
        return Err(Failure::Input(miette::miette!(
            help = "bring them to one rate with --decimate RATEHz, or merge after identification: --merge poser",
            "setups at {rate:.6} Hz and {:.6} Hz cannot be identified at once",
            other.record.sample_rate_hz
        )));
    }
    let grams: Vec<_> = chosen
        .iter()
        .map(|chosen| output_gram(&super::preparation::between_gaps(chosen.record.clone(), &chosen.gaps), BLOCK_ROWS))
        .collect();
    pre_scaled(&grams, references, *arguments.orders.end(), rate, &StabilityCriteria::default())
        .map_err(|error| Failure::Input(miette::miette!(help = "give longer records", "{error}")))
}

/// Modes at which the references or the frequencies of the setups do not agree.
fn disagreements(merged: &Merged, files: &[String]) -> Vec<String> {
    let mut said = Vec::new();
    for mode in &merged.modes {
        let hz = mode.frequency_hz;
        if !mode.references_agree() {
            said.push(format!(
                "the references do not agree over the setups at {hz:.4} Hz ({:.1} standard deviations, by chance {:.1}): a \
                 reference was moved or its gain changed; shapes are glued along all references together",
                mode.reference_difference, mode.reference_limit
            ));
        }
        let setups = mode.found_in.iter().flatten().count();
        // χ² per degree of freedom: mean 1, standard deviation √(2/(n − 1)).
        let limit = 1.0 + 3.0 * (2.0 / (setups.max(2) - 1) as f64).sqrt();
        if setups > 1 && mode.frequency_spread > limit {
            let spread = mode.frequency_spread.sqrt();
            said.push(format!(
                "the frequencies of {} setups at {hz:.4} Hz differ by {spread:.1} times their standard deviations, which are \
                 widened by that: the structure changed between setups",
                files.len()
            ));
        }
    }
    said
}

/// Modes that some setup does not show.
fn missing(merged: &Merged, files: &[String]) -> Vec<String> {
    let lacking = merged.modes.iter().filter(|mode| mode.found_in.iter().any(Option::is_none));
    let of = |mode: &MergedMode| {
        let lacks = mode.found_in.iter().zip(files).filter(|(found, _)| found.is_none()).map(|(_, file)| file.as_str());
        format!("{:.4} Hz is no mode of {}: left out", mode.frequency_hz, lacks.collect::<Vec<_>>().join(", "))
    };
    lacking.map(of).collect()
}
