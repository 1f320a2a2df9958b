//! Several setups of one structure with common reference sensors (`--setup`).

use super::as_it_is::AsItIs;
use super::merge::Merge;
use super::structural_arguments::MergeBy;
use super::time::examined::{Examined, examined, in_segments, record_in_words, treatments};
use super::time::{BLOCK_ROWS, OUTPUT_ONLY};
use super::{Arguments, FoundMode, Outcome, Structure};
use crate::{Failure, recordings};
use examination::even_record::Treatment;
use modal::gram::output_gram;
use modal::operational::identify;
use modal::record::Record;
use modal::setups::{Merged, MergedMode, Setup, SetupMode, merge, pre_scaled};
use modal::ssi_cov::Pole;
use modal::{Mode, ShapeScale, StabilityCriteria};
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
        all.push(examined(arguments, &set)?);
    }
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    let references = references(&asked.references, &names, &all)?;
    let mut all: Vec<Examined> = all.into_iter().map(|setup| references_first(setup, &references)).collect();
    let count = references.len();
    let (mut setups, mut rests, mut done) = (Vec::new(), Vec::new(), Vec::new());
    for (setup, file) in all.iter_mut().zip(&names) {
        let mut config = setup.config(arguments);
        config.selection.shape_deviations = Some(ShapeScale::FirstChannels(count));
        let found = identify(&setup.record, setup.known(), &config).map_err(|error| {
            Failure::Input(miette::miette!(help = "give a longer record of this setup", "{file}: {error}"))
        })?;
        let of_setup_file =
            |t: Treatment| Treatment { channel: format!("{file} {}", t.channel).trim_end().into(), ..t };
        done.extend(treatments(setup, &found).into_iter().map(of_setup_file));
        setups.push(Setup { channels: setup.names.clone(), modes: found.modes.iter().map(of_setup).collect() });
        rests.push(match found.rest {
            Some(values) => Record::of_outputs(setup.record.sample_rate_hz, setup.record.channels, values),
            None => setup.record.clone(),
        });
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
            at_once(arguments, &all, &rests, (&names, count))?.iter().map(of_pole).collect(),
        ),
    };
    let records: Vec<String> = all.iter().map(record_in_words).collect();
    let of_file = |(setup, name): (&Examined, &String)| -> Vec<String> {
        setup.notes.iter().map(|note| format!("{name}: {note}")).collect()
    };
    let notes = all.iter().zip(&names).flat_map(of_file);
    Ok(Outcome {
        method,
        kind: OUTPUT_ONLY,
        deviations,
        channels: merged.channels.clone(),
        record: format!("{} setups with references {}: {}", files.len(), references.join(", "), records.join("; ")),
        modes,
        advice,
        notes: notes.collect(),
        as_it_is: AsItIs { treatments: done, ..AsItIs::default() },
        structure: Structure {
            merge: Some(Merge { by: asked.merge, references, files: names, records, setups, merged }),
            ..Structure::default()
        },
        ..Outcome::default()
    })
}

/// The channels named, or those of the same name in all setups.
fn references(asked: &[String], files: &[String], all: &[Examined]) -> Result<Vec<String>, Failure> {
    for (setup, file) in all.iter().zip(files) {
        if let Some(missing) = asked.iter().find(|name| !setup.names.contains(name)) {
            let near = recordings::nearest(missing, setup.names.iter().map(String::as_str));
            let near = near.map_or(String::new(), |near| format!(" (is it '{near}'?)"));
            return Err(Failure::Input(miette::miette!(
                help = format!("references are channels of every setup; {file} has {}", setup.names.join(", ")),
                "{file} has no reference '{missing}'{near}"
            )));
        }
    }
    if !asked.is_empty() {
        return Ok(asked.to_vec());
    }
    let common: Vec<String> =
        all[0].names.iter().filter(|name| all.iter().all(|setup| setup.names.contains(name))).cloned().collect();
    if common.is_empty() || all.iter().all(|setup| setup.names.len() == common.len()) {
        let what = if common.is_empty() { "no channel has" } else { "all channels have" };
        return Err(Failure::Input(miette::miette!(
            help = "name the sensors that stayed at their places: --references a,b",
            "{what} the same name in all {} setups: which are the references?",
            all.len()
        )));
    }
    Ok(common)
}

fn references_first(mut setup: Examined, references: &[String]) -> Examined {
    let place = |name: &String| setup.names.iter().position(|known| known == name);
    let mut order: Vec<usize> = references.iter().filter_map(place).collect();
    order.extend((0..setup.names.len()).filter(|k| !references.contains(&setup.names[*k])));
    let Record { sample_rate_hz, channels, outputs, .. } = &setup.record;
    let outputs = outputs.chunks_exact(*channels).flat_map(|row| order.iter().map(|k| row[*k])).collect();
    setup.record = Record::of_outputs(*sample_rate_hz, *channels, outputs);
    setup.names = order.iter().map(|k| setup.names[*k].clone()).collect();
    setup.even.delays_s = order.iter().map(|k| setup.even.delays_s[*k]).collect();
    setup
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

/// One identification of all setups, their tones taken out.
fn at_once(
    arguments: &Arguments,
    all: &[Examined],
    rests: &[Record],
    (files, references): (&[String], usize),
) -> Result<Vec<Pole>, Failure> {
    let rate = rests[0].sample_rate_hz;
    if let Some(other) = rests.iter().find(|other| (other.sample_rate_hz / rate - 1.0).abs() > SAME_RATE) {
        return Err(Failure::Input(miette::miette!(
            help = "bring them to one rate with --decimate RATEHz, or merge after identification: --merge poser",
            "setups at {rate:.6} Hz and {:.6} Hz cannot be identified at once",
            other.sample_rate_hz
        )));
    }
    let late = |setup: &Examined| setup.even.delays_s.iter().position(|delay_s| *delay_s != 0.0);
    if let Some((file, setup, k)) = files.iter().zip(all).find_map(|(file, setup)| Some((file, setup, late(setup)?))) {
        return Err(Failure::Input(miette::miette!(
            help = "merge after identification, which takes the delay out of the shapes: --merge poser",
            "{file}: channel '{}' is {:.4} s behind the others: setups cannot be identified at once",
            setup.names[k],
            setup.even.delays_s[k]
        )));
    }
    let grams: Vec<_> = rests.iter().map(|record| output_gram(&in_segments(record), BLOCK_ROWS)).collect();
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
