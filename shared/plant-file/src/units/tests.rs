use super::*;
use core::f64::consts::PI;

fn si(text: &str) -> f64 {
    let (number, unit) = split(text).unwrap_or_else(|| panic!("'{text}' has no number"));
    parse(unit).unwrap_or_else(|why| panic!("'{text}': {why}")).to_si(number).unwrap()
}

/// Where the unit is a power of ten, the double next to the decimal number; no rounding in between.
#[test]
fn decimal_units_give_the_nearest_double() {
    for (text, value) in [
        ("5 ms", 0.005),
        ("12 urad", 1.2e-5),
        ("0.1 mrad/s", 1e-4),
        ("3 um", 3e-6),
        ("20 ppm", 2e-5),
        ("7 %", 0.07),
        ("2.2 kN/m", 2200.0),
        ("1.7 MHz", 1.7e6),
        ("0.35 G", 3.5e-5),
        ("-41.3 nT", -4.13e-8),
        ("1e-3 mm^2", 1e-9),
        ("0.3 1/ms", 300.0),
        ("6 cm", 0.06),
        ("100 ug/sqrt(Hz)", 9.80665e-4),
        ("1.5", 1.5),
    ] {
        assert_eq!(si(text), value, "{text}");
    }
}

/// Two roundings beside those of the value written here: 4 ε.
#[test]
fn other_units_agree_with_hand_computed_values() {
    for (text, value) in [
        ("30 deg", PI / 6.0),
        ("1 arcsec", PI / 648_000.0),
        ("2 arcmin", PI / 5400.0),
        ("1 rev", 2.0 * PI),
        ("1000 rpm", 104.719_755_119_659_77),
        ("1 deg/h", 4.848_136_811_095_36e-6),
        ("0.09 deg/sqrt(h)", 2.617_993_877_991_494e-5),
        ("0.09 °/√h", 2.617_993_877_991_494e-5),
        ("0.008 m/s/sqrt(h)", 0.008 / 60.0),
        ("2 d", 172_800.0),
        ("1.5 min", 90.0),
        ("3 g", 29.419_95),
        ("2 mg", 0.019_613_3),
        ("5 lbf", 22.241_108_076_302_5),
        ("1 N m s/rad", 1.0),
        ("4 N·m/rad", 4.0),
        ("2 kg m²", 2.0),
        ("1 m^(1/2)", 1.0),
        ("1 mm^0.5", 0.031_622_776_601_683_79),
        ("9 (m/s)^2", 9.0),
        ("3 sqrt(kg)*m", 3.0),
        ("1 Ω", 1.0),
        ("20 mdeg/s/sqrt(Hz)", 0.02 * PI / 180.0),
    ] {
        let got = si(text);
        assert!((got / value - 1.0).abs() <= 4.0 * f64::EPSILON, "{text}: {got} and not {value}");
    }
}

#[test]
fn dimensions_follow_products_quotients_powers_and_roots() {
    let dimension = |text: &str| parse(text).unwrap().dimension;
    assert_eq!(dimension("N"), dimension("kg*m/s^2"));
    assert_eq!(dimension("J"), dimension("N m"));
    assert_eq!(dimension("W"), dimension("V*A"));
    assert_eq!(dimension("ohm"), dimension("V/A"));
    assert_eq!(dimension("V*s/rad"), dimension("N*m/A"));
    assert_eq!(dimension("T"), dimension("N/A/m"));
    assert_eq!(dimension("ug/sqrt(Hz)"), dimension("m/s^2*sqrt(s)"));
    assert_eq!(dimension("m/s/sqrt(h)"), dimension("m/s^2*sqrt(s)"));
    assert_eq!(dimension("deg/sqrt(h)"), dimension("rad/s*sqrt(s)"));
    assert_eq!(dimension("1/sqrt(kg)"), [-1, 0, 0, 0, 0]);
    assert_eq!(dimension("J/rad^2.5"), dimension("N*m"));
    assert_ne!(dimension("N/m*s"), dimension("N/(m*s)"), "quotients associate from the left");
}

#[test]
fn what_is_no_unit_is_named() {
    for (text, word) in [
        ("furlong", "furlong"),
        ("kgg", "did you mean 'kg'"),
        ("m/", "missing"),
        ("m/(s", "not closed"),
        ("m^x", "'x'"),
        ("m^(1/3)", "1/3"),
        ("m^99", "99"),
        ("m)", "')'"),
        ("sqrt(sqrt(m))", "root"),
        ("((((((((((m))))))))))", "brackets"),
        ("mkg", "mkg"),
    ] {
        let why = parse(text).expect_err(text);
        assert!(why.contains(word), "{text}: {why}");
    }
}

#[test]
fn a_number_ends_where_its_unit_begins() {
    for (text, parts) in [
        ("3 kg", ("3", "kg")),
        ("-1.5e-3N*m", ("-1.5e-3", "N*m")),
        ("+.5 m", ("+.5", "m")),
        ("2. m", ("2.", "m")),
        ("1 e", ("1", "e")),
        ("1e m", ("1", "e m")),
        (" 7 % ", ("7", "%")),
    ] {
        assert_eq!(split(text), Some(parts), "{text}");
    }
    for text in ["", "kg", "-", ".", "+kg", "- 3 kg", "inf kg"] {
        assert_eq!(split(text), None, "{text}");
    }
}
