use super::*;

fn si(number: &str, unit: &str) -> f64 {
    parse(unit).unwrap_or_else(|fault| panic!("'{unit}': {fault:?}")).to_si(number).unwrap()
}

#[test]
fn every_name_is_of_one_unit_alone() {
    let mut all: Vec<&str> = symbols().flatten().copied().collect();
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count, "a name stands twice");
    assert!(count > 150 && all.iter().all(|name| parse(name).is_ok()));
}

#[test]
fn a_number_in_a_text_and_a_number_of_a_column_become_the_same() {
    for unit in ["ms", "deg", "rpm", "mg", "N/mm", "N*m/deg", "psi", "lbf", "km/h", "1/min", "degF", "in/s", "%"] {
        let [factor, divisor, offset] = parse(unit).unwrap().conversion();
        let (text, column) = (si("2.5", unit), 2.5 * factor / divisor + offset);
        // at most four roundings on each side
        assert!((text - column).abs() <= 8.0 * f64::EPSILON * text.abs(), "{unit}: {text} {column}");
    }
}

#[test]
fn a_power_belongs_to_the_symbol_before_it_and_a_one_takes_none() {
    assert_eq!(si("3", "kgm2"), 3.0);
    assert_eq!(parse("kgm2").unwrap().dimension, parse("kg*m^2").unwrap().dimension);
    assert_eq!(si("1", "m s-2"), si("1", "m/s/s"));
    for text in ["100", "12 Hz", "10^3 N", "1000/min"] {
        assert!(parse(text).is_err(), "{text}");
    }
}

#[test]
fn a_gram_is_meant_where_it_is_said_to_be() {
    let [gravity, gram] = [parse("g*cm^2"), parse_with_gram("g*cm^2")].map(|unit| unit.unwrap().dimension);
    assert!(gravity != gram && gram == parse("kg*m^2").unwrap().dimension);
    assert_eq!(parse("g/s").unwrap().dimension, parse("kg/s").unwrap().dimension);
}
