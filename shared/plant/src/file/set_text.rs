//! One number of a plant on one line: `link_1.mass = 12.5 kg`.

use super::effect_text::value_in_si;
use super::numbers::Expected;
use crate::description::{ParameterError, Plant, nearest};

/// Gives a parameter of `plant` another value; a value without unit is in SI. Names are those of [`Plant::parameters`].
///
/// # Errors
/// What is unknown or impossible, with the nearest known name; the plant then stays as it was.
pub fn set(plant: &mut Plant, text: &str) -> Result<(), String> {
    let (name, value) = text.split_once('=').ok_or_else(|| format!("'{text}' is not NAME = VALUE UNIT"))?;
    let (name, value) = (name.trim(), value.trim());
    let parameters = plant.parameters();
    let Some(parameter) = parameters.iter().find(|parameter| parameter.name == name) else {
        let nearest = nearest(name, parameters.iter().map(|p| p.name.as_str())).map(str::to_owned);
        return Err(ParameterError::Unknown { name: name.to_owned(), nearest }.to_string());
    };
    let expected = Expected { what: name.to_owned(), unit: &parameter.unit };
    let value = value_in_si(value, &expected).map_err(|(message, cure)| match cure.as_str() {
        "" => message,
        cure => format!("{message}; {cure}"),
    })?;
    let mut changed = plant.clone();
    changed.set_parameter(name, value).map_err(|error| error.to_string())?;
    if let Some(fault) = changed.validate().into_iter().find(|fault| !fault.warning) {
        return Err(fault.message);
    }
    *plant = changed;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::parse;

    fn rig() -> Plant {
        let text = "format = 1\nname = \"rig\"\nspace = \"planar\"\n[[body]]\nname = \"bob\"\nmass = \"2 kg\"\ninertia = \"0.1 kg*m^2\"\njoint = { kind = \"revolute\", name = \"hinge\", friction = \"0.01 N*m*s/rad\" }\n";
        parse("rig.toml", text).unwrap().plant
    }

    #[test]
    fn a_number_is_set_in_its_own_unit_and_nothing_else_changes() {
        let mut plant = rig();
        set(&mut plant, "bob.mass = 1500 g").unwrap();
        let mut expected = rig();
        expected.bodies[0].mass_kg.value = 1.5;
        assert_eq!(plant, expected);
    }

    #[test]
    fn what_cannot_be_is_refused_and_leaves_the_plant_alone() {
        for (text, says) in [
            ("bob.mas = 1 kg", "bob.mass"),
            ("bob.mass = 3 N", "N"),
            ("bob.mass = -3 kg", "mass"),
            ("bob.mass = heavy", "heavy"),
            ("bob.mass", "VALUE"),
        ] {
            let mut plant = rig();
            let error = set(&mut plant, text).unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
            assert_eq!(plant, rig());
        }
    }
}
