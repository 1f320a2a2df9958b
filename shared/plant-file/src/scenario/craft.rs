//! One craft, flown through all its arcs: one plant file, and what each arc commands.

use super::PlantUse;
use crate::FileError;
use dynamics::description::Plant;
use serde::Deserialize;
use std::collections::BTreeMap;
use telemetry::{Domain, Experiment};

/// A craft and its arcs.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CraftPlan {
    /// Its file states what is known of it: numbers with their priors. It is simulated with numbers
    /// drawn from these, those of `set` apart, and with the effects of `hide`.
    pub plant: PlantUse,
    /// In the order in which they are flown and folded.
    #[serde(rename = "arc")]
    pub arcs: Vec<ArcPlan>,
}

/// One arc: what is commanded, for how long, and whose it is.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArcPlan {
    pub name: String,
    pub experiment: ArcExperiment,
    pub duration_s: f64,
    /// Control period; without it the plant's.
    #[serde(default)]
    pub period_ms: Option<u64>,
    /// By actuator, as a plant file writes its `command`; an actuator that is not here rests.
    #[serde(default)]
    pub commands: BTreeMap<String, toml::Value>,
    /// By controller, as a plant file writes its `reference`; one that is not here keeps the
    /// plant's.
    #[serde(default)]
    pub references: BTreeMap<String, toml::Value>,
}

/// What an arc is flown for; it says whose arc it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ArcExperiment {
    Modal,
    Slosh,
    Inertial,
    /// To be predicted, not to be fitted.
    HeldOut,
}

/// Why the plant of an arc cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ArcError {
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    File(Vec<FileError>),
    #[error("{arc}: {key}.{name}: the plant has no {what} of that name")]
    Unknown { arc: String, key: &'static str, name: String, what: &'static str },
    #[error("{arc}: {reason}")]
    Arc { arc: String, reason: String },
}

impl ArcExperiment {
    /// As modes carry it.
    #[must_use]
    pub const fn code(self) -> Experiment {
        match self {
            Self::Modal => Experiment::Modal,
            Self::Slosh => Experiment::Slosh,
            Self::Inertial => Experiment::Inertial,
            Self::HeldOut => Experiment::HeldOut,
        }
    }

    /// Whose partition keeps the arc; the arm's flies what is held out.
    #[must_use]
    pub const fn owner(self) -> Domain {
        match self {
            Self::Modal => Domain::Modal,
            Self::Slosh => Domain::Slosh,
            Self::Inertial | Self::HeldOut => Domain::Inertial,
        }
    }
}

impl CraftPlan {
    /// The plant as it is known, with the commands of `arc`.
    ///
    /// # Errors
    /// See [`ArcError`].
    pub fn known(&self, arc: &ArcPlan) -> Result<Plant, ArcError> {
        let failed = |reason: String| ArcError::Arc { arc: arc.name.clone(), reason };
        // faults of the file itself have their places in it
        crate::parse(&self.plant.file, &self.plant.text).map_err(ArcError::File)?;
        let mut document: toml::Table =
            toml::from_str(&self.plant.text).map_err(|error| failed(error.message().to_owned()))?;
        arc.put(&mut document, "actuator", ("commands", "command"), &arc.commands)?;
        arc.put(&mut document, "controller", ("references", "reference"), &arc.references)?;
        let simulation = document.entry("simulation").or_insert_with(|| toml::Value::Table(toml::Table::new()));
        if let Some(simulation) = simulation.as_table_mut() {
            simulation.insert("duration".into(), format!("{} s", arc.duration_s).into());
            if let Some(period_ms) = arc.period_ms {
                simulation.insert("period".into(), format!("{period_ms} ms").into());
            }
        }
        let text = toml::to_string(&document).map_err(|error| failed(error.to_string()))?;
        let parsed = crate::parse(&self.plant.file, &text).map_err(|errors| {
            failed(errors.iter().map(|error| error.message.clone()).collect::<Vec<_>>().join("; "))
        })?;
        Ok(parsed.plant)
    }
}

impl ArcPlan {
    /// Puts what this arc states into the tables `kind` of a plant file; actuators of which it
    /// states nothing lose their command.
    fn put(
        &self,
        document: &mut toml::Table,
        kind: &'static str,
        (key, own): (&'static str, &str),
        stated: &BTreeMap<String, toml::Value>,
    ) -> Result<(), ArcError> {
        let mut tables: Vec<&mut toml::Table> = document
            .get_mut(kind)
            .and_then(toml::Value::as_array_mut)
            .map(|tables| tables.iter_mut().filter_map(toml::Value::as_table_mut).collect())
            .unwrap_or_default();
        let name = |table: &toml::Table| table.get("name").and_then(toml::Value::as_str).map(str::to_owned);
        let known: Vec<Option<String>> = tables.iter().map(|table| name(table)).collect();
        let unknown = stated.keys().find(|name| !known.iter().flatten().any(|known| known == *name));
        if let Some(name) = unknown {
            return Err(ArcError::Unknown { arc: self.name.clone(), key, name: name.clone(), what: kind });
        }
        for (table, name) in tables.iter_mut().zip(&known) {
            match name.as_ref().and_then(|name| stated.get(name)) {
                Some(signal) => drop(table.insert(own.into(), signal.clone())),
                None if own == "command" => drop(table.remove(own)),
                None => {}
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CRAFT: &str = include_str!("../../../../deploy/plants/study_case.toml");

    fn craft(arc: &str) -> (CraftPlan, ArcPlan) {
        let plan = format!("plant = {{ file = \"study_case\" }}\n[[arc]]\nname = \"E\"\n{arc}");
        let mut plan: CraftPlan = toml::from_str(&plan).unwrap();
        plan.plant.text = CRAFT.into();
        let arc = plan.arcs[0].clone();
        (plan, arc)
    }

    #[test]
    fn an_arc_changes_commands_references_and_times_and_no_number_of_the_craft() {
        let (plan, arc) = craft(
            "experiment = \"slosh\"\nduration_s = 30.0\nperiod_ms = 50\n\
             commands.wheel = { kind = \"constant\", value = \"0.1 N*m\" }\n\
             references.elbow_loop = { kind = \"constant\", value = \"-1 rad\" }",
        );
        let known = plan.known(&arc).unwrap();
        let file = crate::parse("study_case", CRAFT).unwrap().plant;
        assert_eq!((known.simulation.duration_s, known.simulation.period_s), (30.0, 0.05));
        let command = |plant: &Plant, name: &str| plant.actuator(name).unwrap().command.len();
        assert_eq!((command(&known, "wheel"), command(&known, "thruster_1")), (1, 0));
        assert_eq!(known.controllers[0].reference, file.controllers[0].reference);
        assert_ne!(known.controllers[1].reference, file.controllers[1].reference);
        let numbers = |plant: &Plant| {
            let all = plant.parameters().into_iter();
            all.filter(|p| p.sigma.is_some()).map(|p| (p.name, p.value, p.sigma)).collect::<Vec<_>>()
        };
        assert_eq!(numbers(&known), numbers(&file));
        assert!(numbers(&known).len() > 30);
    }

    #[test]
    fn a_command_of_an_actuator_that_the_plant_does_not_have_is_refused_by_name() {
        let (plan, arc) = craft(
            "experiment = \"modal\"\nduration_s = 1.0\ncommands.weel = { kind = \"constant\", value = \"0.1 N*m\" }",
        );
        let error = plan.known(&arc).unwrap_err().to_string();
        assert!(error.contains("E: commands.weel") && error.contains("actuator"), "{error}");
    }

    #[test]
    fn a_signal_that_is_none_is_refused_with_its_arc() {
        let (plan, arc) = craft("experiment = \"modal\"\nduration_s = 1.0\ncommands.wheel = { kind = \"wobble\" }");
        let error = plan.known(&arc).unwrap_err().to_string();
        assert!(error.starts_with("E: ") && error.contains("wobble"), "{error}");
    }
}
