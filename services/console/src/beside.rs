//! `RECORDING=PLANT`: a recording with the plant file that flew it.

use crate::Failure;
use std::path::{Path, PathBuf};

/// `RECORDING[=PLANT]` at its last '='; a file of the whole name has no plant in it.
pub fn divided(text: &str) -> (PathBuf, Option<PathBuf>) {
    match text.rsplit_once('=') {
        Some((recording, plant)) if !Path::new(text).exists() && !recording.is_empty() && !plant.is_empty() => {
            (recording.into(), Some(plant.into()))
        }
        _ => (text.into(), None),
    }
}

/// Takes the plants out of `files`; the one that is held against all of them: theirs, or `given`.
///
/// # Errors
/// Two plant files.
pub fn plant_of<'f>(
    files: impl Iterator<Item = &'f mut PathBuf>,
    given: Option<&Path>,
) -> Result<Option<PathBuf>, Failure> {
    let mut one = given.map(Path::to_path_buf);
    for file in files {
        // a name that is no text is that of a file alone
        let Some((recording, Some(plant))) = file.to_str().map(divided) else { continue };
        *file = recording;
        if let Some(first) = one.as_ref().filter(|first| **first != plant) {
            return Err(Failure::Input(miette::miette!(
                help = "one plant file is held against all recordings: diagnose them apart, or \
                    `obsid identify` the numbers that they share",
                "two plant files: {} and {}",
                first.display(),
                plant.display()
            )));
        }
        one = Some(plant);
    }
    Ok(one)
}

/// # Errors
/// No plant file is named.
pub fn required(plant: Option<&Path>) -> Result<&Path, Failure> {
    plant.ok_or_else(|| {
        Failure::Usage("no plant file is held against the recordings: give --plant FILE, or RECORDING=FILE".into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plant_stands_behind_the_last_equals_sign() {
        let plant = |text: &str| divided(text).1.map(|path| path.display().to_string());
        assert_eq!(plant("a.csv=craft.toml").as_deref(), Some("craft.toml"));
        assert_eq!(plant("run=3.csv=craft.toml").as_deref(), Some("craft.toml"));
        assert_eq!(divided("run=3.csv=craft.toml").0, Path::new("run=3.csv"));
        assert_eq!((plant("a.csv"), plant("a.csv="), plant("=a.csv")), (None, None, None));
    }

    #[test]
    fn recordings_with_one_plant_have_it_and_with_two_are_refused_with_both() {
        let of = |names: &[&str], given: Option<&str>| {
            let mut files: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            plant_of(files.iter_mut(), given.map(Path::new)).map(|plant| (plant, files))
        };
        let (plant, files) = of(&["1.csv=a.toml", "2.csv"], None).unwrap();
        assert_eq!((plant, files), (Some("a.toml".into()), vec!["1.csv".into(), "2.csv".into()]));
        assert_eq!(of(&["1.csv"], Some("b.toml")).unwrap().0, Some("b.toml".into()));
        assert!(required(of(&["1.csv"], None).unwrap().0.as_deref()).is_err());
        let Err(Failure::Input(report)) = of(&["1.csv=a.toml"], Some("b.toml")) else { panic!("two plants") };
        assert!(report.to_string().contains("a.toml and b.toml") || report.to_string().contains("b.toml and a.toml"));
    }
}
