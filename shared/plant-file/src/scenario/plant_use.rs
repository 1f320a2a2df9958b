//! The plant that an experiment is simulated on.

use crate::FileError;
use dynamics::description::Plant;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The plant that an experiment is simulated on.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantUse {
    /// A plant file, relative to the scenario's folder, or the name of one that comes with the
    /// program.
    pub file: String,
    /// Numbers that differ from the file's: name and value with unit.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
    /// Effects that the plant carries and no estimator models: `KIND@SITE name=value …`.
    #[serde(default)]
    pub hide: Vec<String>,
    /// The file's text, which comes from who reads the scenario: a partition opens no files.
    #[serde(skip)]
    pub text: String,
}

/// A plant as an experiment uses it.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfiguredPlant {
    pub plant: Plant,
    /// Possible, but not plausible.
    pub warnings: Vec<String>,
}

/// Why a plant cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PlantUseError {
    /// Everything that is wrong with its file.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    File(Vec<FileError>),
    /// A number that cannot be set or an effect that cannot be hidden; `keys` below the plant's.
    #[error("{reason}")]
    Change { keys: Vec<String>, reason: String },
}

impl PlantUse {
    /// The plant with its numbers set and its effects hidden.
    ///
    /// # Errors
    /// See [`PlantUseError`].
    pub fn configure(&self) -> Result<ConfiguredPlant, PlantUseError> {
        let crate::Parsed { mut plant, warnings } =
            crate::parse(&self.file, &self.text).map_err(PlantUseError::File)?;
        let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        warnings.extend(self.change(&mut plant)?);
        Ok(ConfiguredPlant { plant, warnings })
    }

    /// Sets the numbers of `plant` and hides the effects; what of it is not plausible.
    ///
    /// # Errors
    /// [`PlantUseError::Change`].
    pub fn change(&self, plant: &mut Plant) -> Result<Vec<String>, PlantUseError> {
        let mut warnings = Vec::new();
        self.set_numbers(plant)?;
        for (k, text) in self.hide.iter().enumerate() {
            let effect = crate::parse_effect(plant, text)
                .map_err(|reason| PlantUseError::Change { keys: vec!["hide".into(), k.to_string()], reason })?;
            let doubts = crate::effect_warnings(plant, &effect);
            warnings.extend(doubts.iter().map(|doubt| format!("hide '{text}': {doubt}")));
            plant.effects.push(effect);
        }
        Ok(warnings)
    }

    fn set_numbers(&self, plant: &mut Plant) -> Result<(), PlantUseError> {
        let numbers: Vec<String> = self.set.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        crate::set_all(plant, &numbers).map_err(|reason| {
            let guilty = self.set.keys().zip(&numbers).find(|(_, number)| reason.contains(&format!("'{number}'")));
            let keys = ["set".to_owned()].into_iter().chain(guilty.map(|(name, _)| name.clone()));
            PlantUseError::Change { keys: keys.collect(), reason }
        })
    }
}
