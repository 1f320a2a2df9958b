//! The plant that an experiment is simulated on.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The plant that an experiment is simulated on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantUse {
    /// A plant file, relative to the scenario's folder, or the name of one that comes with the program.
    pub file: String,
    /// Numbers that differ from the file's: name and value with unit.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
    /// Effects that the plant carries and no estimator is told of: `KIND@SITE name=value …`.
    #[serde(default)]
    pub hide: Vec<String>,
    /// The file's text, filled in where the scenario is read: a partition opens no files.
    #[serde(default)]
    pub text: String,
}
