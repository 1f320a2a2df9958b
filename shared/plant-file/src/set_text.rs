//! Numbers of a plant on one line each: `link_1.mass = 12.5 kg`.

use super::effect_text::value_in_si;
use super::numbers::Expected;
use dynamics::description::{Parameter, ParameterError, Plant, nearest};

/// Gives a parameter of `plant` another value; a value without unit is in SI. Names are those of
/// [`Plant::parameters`].
///
/// # Errors
/// What is unknown or impossible, with the nearest known name; the plant then stays as it was.
pub fn set(plant: &mut Plant, text: &str) -> Result<(), String> {
    apply(plant, &[text]).map_err(|refused| refused.why)
}

/// Gives several parameters other values, one text each, and checks the plant when all are given:
/// an inertia can only be scaled as a whole.
///
/// # Errors
/// As of [`set`], with the text or texts that make it.
pub fn set_all<T: AsRef<str>>(plant: &mut Plant, texts: &[T]) -> Result<(), String> {
    let texts: Vec<&str> = texts.iter().map(AsRef::as_ref).collect();
    apply(plant, &texts).map_err(|Refused { guilty, why }| {
        let quoted: Vec<String> = guilty.iter().map(|text| format!("'{text}'")).collect();
        format!("{}: {why}", quoted.join(", "))
    })
}

/// Why, and the texts that make it.
struct Refused<'t> {
    guilty: Vec<&'t str>,
    why: String,
}

fn apply<'t>(plant: &mut Plant, texts: &[&'t str]) -> Result<(), Refused<'t>> {
    let changed = with(plant, texts)?;
    if let Some(why) = first_fault(&changed) {
        return Err(Refused { guilty: culprits(plant, texts, &why), why });
    }
    *plant = changed;
    Ok(())
}

/// The plant with all texts applied, not checked as a whole.
fn with<'t>(plant: &Plant, texts: &[&'t str]) -> Result<Plant, Refused<'t>> {
    let mut changed = plant.clone();
    let parameters = plant.parameters();
    let mut given: Vec<&str> = Vec::with_capacity(texts.len());
    for text in texts {
        let refused = |why: String| Refused { guilty: vec![text], why };
        let (name, value) = one(&parameters, text).map_err(refused)?;
        if given.contains(&name) {
            return Err(refused(format!("{name} is set twice")));
        }
        given.push(name);
        changed.set_parameter(name, value).map_err(|error| refused(error.to_string()))?;
    }
    Ok(changed)
}

/// Name and value, SI.
fn one<'t>(parameters: &[Parameter], text: &'t str) -> Result<(&'t str, f64), String> {
    let (name, value) = text.split_once('=').ok_or_else(|| format!("'{text}' is not NAME = VALUE UNIT"))?;
    let (name, value) = (name.trim(), value.trim());
    let Some(parameter) = parameters.iter().find(|parameter| parameter.name == name) else {
        let nearest = nearest(name, parameters.iter().map(|p| p.name.as_str())).map(str::to_owned);
        return Err(ParameterError::Unknown { name: name.to_owned(), nearest }.to_string());
    };
    let expected = Expected { what: name.to_owned(), unit: &parameter.unit };
    let value = value_in_si(value, &expected).map_err(|(message, cure)| match cure.as_str() {
        "" => message,
        cure => format!("{message}; {cure}"),
    })?;
    Ok((name, value))
}

fn first_fault(plant: &Plant) -> Option<String> {
    let fault = crate::validate::validate(plant).into_iter().find(|fault| !fault.warning)?;
    Some(fault.to_string())
}

/// The texts without which the fault is gone, each by itself; all, where none is.
fn culprits<'t>(plant: &Plant, texts: &[&'t str], why: &str) -> Vec<&'t str> {
    let gone_without = |left_out: usize| {
        let rest: Vec<&str> = texts.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, text)| *text).collect();
        with(plant, &rest).is_ok_and(|changed| first_fault(&changed).as_deref() != Some(why))
    };
    let guilty: Vec<&str> = (0..texts.len()).filter(|i| gone_without(*i)).map(|i| texts[i]).collect();
    if guilty.is_empty() { texts.to_vec() } else { guilty }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parse;

    fn rig() -> Plant {
        let text = "format = 1\nname = \"rig\"\nspace = \"planar\"\n[[body]]\nname = \"bob\"\nmass = \"2 kg\"\ninertia = \"0.1 kg*m^2\"\njoint = { kind = \"revolute\", name = \"hinge\", friction = \"0.01 N*m*s/rad\" }\n";
        parse("rig.toml", text).unwrap().plant
    }

    fn block() -> Plant {
        let text = "format = 1\nname = \"block\"\nspace = \"spatial\"\n[[body]]\nname = \"hub\"\nmass = \"2 kg\"\ninertia = [\"1 kg*m^2\", \"1 kg*m^2\", \"1 kg*m^2\"]\njoint = { kind = \"free\" }\n";
        parse("block.toml", text).unwrap().plant
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

    #[test]
    fn an_inertia_is_scaled_as_a_whole_though_no_single_step_is_possible() {
        let mut plant = block();
        assert!(set(&mut plant, "hub.inertia.xx = 10").is_err());
        set_all(&mut plant, &["hub.inertia.xx = 10", "hub.inertia.yy = 10", "hub.inertia.zz = 10 kg*m^2"]).unwrap();
        assert_eq!(plant.bodies[0].inertia_com_kg_m2.map(|q| q.value), [10.0, 10.0, 10.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn an_error_names_the_text_that_makes_it() {
        let mut plant = block();
        let error = set_all(&mut plant, &["hub.mass = 3 kg", "hub.inertia.xx = 10", "hub.com.x = 1 cm"]).unwrap_err();
        assert!(error.starts_with("'hub.inertia.xx = 10': ") && error.contains("triangle"), "{error}");
        let error = set_all(&mut plant, &["hub.mass = 3 kg", "hub.com.x = 1 kg"]).unwrap_err();
        assert!(error.starts_with("'hub.com.x = 1 kg': "), "{error}");
        let error = set_all(&mut plant, &["hub.mass = 3 kg", "hub.mass = 4 kg"]).unwrap_err();
        assert!(error.contains("twice"), "{error}");
        assert_eq!(plant, block());
    }
}
