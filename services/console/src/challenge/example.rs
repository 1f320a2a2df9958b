//! One case as files: what the tool receives, and the truth beside it.

use crate::Failure;
use crate::simulate::with_unit_of_files;
use ::challenge::campaign::open;
use ::challenge::case::{Exam, Truth, case};
use channels::Recording;
use dynamics::description::Plant;
use serde_json::json;
use std::path::Path;

/// Draws case `index` of `seed` and writes it to `folder`.
///
/// # Errors
/// [`Failure::Run`] when a file cannot be written.
pub fn write(seed: u64, index: u64, folder: &Path, as_json: bool) -> Result<(), Failure> {
    let sealed = case(seed, index);
    let truth: Truth = open(&sealed.truth).map_err(Failure::Run)?;
    std::fs::create_dir_all(folder).map_err(|error| cannot(folder, &error))?;
    let mut files = files_of(sealed.exam, folder)?;
    let object = json!({ "seed": seed, "digest": sealed.digest, "truth": truth });
    files.push(text(folder, "truth.json", &format!("{object:#}\n"))?);
    crate::print(&if as_json {
        format!("{}\n", json!({ "seed": seed, "case": index, "plant": truth.plant, "files": files }))
    } else {
        format!("{}, case {index} of seed {seed}: {}\n", truth.plant, files.join(" "))
    });
    Ok(())
}

/// The plant file, the recording and, of a case with an effect, another experiment.
fn files_of(exam: Exam, folder: &Path) -> Result<Vec<String>, Failure> {
    let mut files = vec![plant(folder, "plant.toml", &exam.plant)?, recording(folder, "recording", exam.recording)?];
    if let Some((other, held_out)) = exam.held_out {
        if other != exam.plant {
            files.push(plant(folder, "held_out.toml", &other)?);
        }
        files.push(recording(folder, "held_out", held_out)?);
    }
    Ok(files)
}

fn plant(folder: &Path, name: &str, plant: &Plant) -> Result<String, Failure> {
    text(folder, name, &plant_file::write(plant))
}

fn text(folder: &Path, name: &str, text: &str) -> Result<String, Failure> {
    let path = folder.join(name);
    std::fs::write(&path, text).map_err(|error| cannot(&path, &error))?;
    Ok(name.to_owned())
}

fn recording(folder: &Path, name: &str, mut recording: Recording) -> Result<String, Failure> {
    recording.channels.iter_mut().try_for_each(with_unit_of_files)?;
    let file = format!("{name}.csv.gz");
    recording::write_series(&recording, &folder.join(&file)).map_err(Failure::input)?;
    Ok(file)
}

fn cannot(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Run(format!("{}: cannot be written: {error}", path.display()))
}
