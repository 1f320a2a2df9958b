//! One table, one parser: a unit is the same unit in a plant file and in a recording.

use plant_file::units::{Unit, parse, parse_with_gram};

/// Spellings of one symbol with every prefix, and of compounds.
fn spellings() -> Vec<String> {
    let names = || units::symbols().flatten();
    let prefixed = ["", "n", "u", "µ", "m", "c", "h", "k", "M", "G", "micro", "milli", "kilo"]
        .iter()
        .flat_map(|prefix| names().map(move |name| format!("{prefix}{name}")));
    let compounds = [
        "m s^-2",
        "N·m",
        "deg/sec",
        "kg m2",
        "g·cm²",
        "g/s",
        "oz-in",
        "lb·ft",
        "V/(rad/s)",
        "°/s²",
        "U/min",
        "1/min",
        "N*m*s/rad",
        "kN/mm",
        "rev/min",
        "mm/s/s",
        "J/kg",
        "m/s^2/N",
        "a.u.",
        "Umdr./min",
        "rad/N/m",
        "kgf/cm²",
    ];
    prefixed.chain(compounds.map(str::to_owned)).filter(|text| units::parse(text).is_ok()).collect()
}

#[test]
fn a_spelling_of_a_plant_file_is_one_of_a_recording_with_the_same_factor_and_dimension() {
    let all = spellings();
    assert!(all.len() > 400, "{}", all.len());
    for text in &all {
        let readings = || [parse(text), parse_with_gram(text)].into_iter().flatten();
        let Some(channel) = recording::units::unit_named(text) else {
            let may_be_two_things = text.ends_with('G') || recording::units::two_meanings(text).is_some();
            let known = |unit: &Unit| {
                let si = recording::units::UNITS.iter().map(|unit| parse(unit.si)).collect::<Vec<_>>();
                si.into_iter().flatten().any(|si| (si.dimension, si.radian) == (unit.dimension, unit.radian))
            };
            assert!(may_be_two_things || !readings().any(|unit| known(&unit)), "'{text}' is no unit of a recording");
            continue;
        };
        let wanted = parse(channel.si).unwrap();
        let Some(own) = readings().find(|unit| unit.dimension == wanted.dimension) else {
            assert!(channel.to_si(0.0) != 0.0, "'{text}' is no unit of a plant file");
            continue;
        };
        assert_eq!(own.radian, wanted.radian, "{text}");
        let (of_file, of_channel) = (own.to_si("1").unwrap(), channel.to_si(1.0));
        assert!((of_file / of_channel - 1.0).abs() <= 4.0 * f64::EPSILON, "{text}: {of_file} and {of_channel}");
    }
}
