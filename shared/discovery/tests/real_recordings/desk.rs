//! What every test needs: recordings as channels, plants, and the diagnosis in print.

use channels::Recording;
use discovery::diagnose::{Diagnosis, Options, diagnose};
use dynamics::description::Plant;
use identification::problem::Problem;
use std::path::PathBuf;

/// The folder of the recordings; `None` (said) where there is none.
pub fn folder(recording: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/recordings"));
    let root = std::env::var_os("OBSID_RECORDINGS").map_or_else(beside, PathBuf::from);
    let folder = root.join(recording);
    if folder.join("README.md").is_file() {
        return Some(folder);
    }
    let required = std::env::var("OBSID_REQUIRE").is_ok_and(|list| list.split(',').any(|word| word == "recordings"));
    assert!(!required, "recordings are required, {} is not there", folder.display());
    println!("skipped: {} is not there", folder.display());
    None
}

/// All recordings of a file: one for each time that time begins again.
pub fn read(folder: &std::path::Path, file: &str) -> Vec<Recording> {
    let sets = recording::segments(recording::read(&folder.join(file)).unwrap()).unwrap();
    let one =
        |(k, set): (usize, recording::SeriesSet)| Recording { name: format!("{file}#{}", k + 1), ..set.recording };
    sets.into_iter().enumerate().map(one).collect()
}

pub fn rig(name: &str) -> Plant {
    let path = format!("{}/../../deploy/plants/rigs/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    plant_file::parse(name, &std::fs::read_to_string(path).unwrap()).unwrap().plant
}

/// Diagnosis of one recording, printed.
pub fn diagnosed(title: &str, plant: &Plant, recording: &Recording) -> Diagnosis {
    let problem = Problem::new(plant, core::slice::from_ref(recording), &[]).unwrap();
    let begin = std::time::Instant::now();
    let found = diagnose(&problem, &Options { threads: 2, ..Options::default() }, &mut |_, _| {});
    println!("\n== {title}: {} samples, {:.1} s of work", problem.samples(), begin.elapsed().as_secs_f64());
    print(&found);
    found
}

fn print(found: &Diagnosis) {
    println!("{:?}: {}", found.verdict, found.reason);
    for channel in &found.compare.channels {
        println!("  compare {}: rms {:.4e}, fit {:.1} %", channel.name, channel.rms, channel.fit_percent);
    }
    for effect in &found.effects {
        println!(
            "  {}@{} p {:.3} {:?} kappa {:.2} d {:.1}",
            effect.kind, effect.site, effect.probability, effect.status, effect.kappa, effect.d
        );
        for parameter in &effect.parameters {
            println!("    {} = {:.5e} ± {:.1e} {}", parameter.name, parameter.value, parameter.sigma, parameter.unit);
        }
        for rival in effect.rivals.iter().take(5) {
            println!("    rival {}@{} {:.3}: {}", rival.kind, rival.site, rival.probability, rival.reason);
        }
    }
    for nominal in &found.nominal {
        println!(
            "  {} {:.5e} -> {:.5e} ± {:.1e} ({:.1} sigma)",
            nominal.name, nominal.before, nominal.after, nominal.sigma, nominal.shift_sigma
        );
    }
    let held_out = &found.held_out;
    println!("  held out {:?}, gain {:?} ± {:?}", held_out.kind, held_out.loglik_gain, held_out.gain_se);
    for channel in &held_out.channels {
        println!(
            "    {}: rms {:.4e} -> {:.4e}, fit {:.2} -> {:.2} %",
            channel.name, channel.rms_before, channel.rms_after, channel.fit_percent_before, channel.fit_percent_after
        );
    }
    for note in &found.notes {
        println!("  note: {note}");
    }
}
