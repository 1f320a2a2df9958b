//! Numbers as data sheets write them, plurals, lists.

use dynamics::description::{Joint, JointKind, Noise, Quantity};

/// Significant digits without trailing zeros, exponents only far from one.
pub fn digits(value: f64, significant: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { format!("{value}") };
    }
    let rounded: f64 = format!("{value:.*e}", significant.saturating_sub(1)).parse().unwrap_or(value);
    if (1e-4..1e7).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

/// `12 urad`, `0.2 mrad`, `850 N*s/m`: a number in SI with the prefix that makes it short.
pub fn with_unit(value: f64, unit: &str) -> String {
    const PREFIXED: [&str; 6] = ["m", "rad", "N", "A", "V", "s"];
    if unit == "1" || unit == "-" {
        return digits(value, 5);
    }
    let first = unit.split(['/', '*', '^']).next().unwrap_or(unit);
    // a prefix on a powered unit would be powered too
    let plain = PREFIXED.contains(&first) && !unit[first.len()..].starts_with('^');
    let (scale, prefix) = match value.abs() {
        size if !plain || size == 0.0 || size >= 0.05 => (1.0, ""),
        size if size >= 5e-5 => (1e3, "m"),
        size if size >= 5e-8 => (1e6, "u"),
        _ => (1e9, "n"),
    };
    format!("{} {prefix}{unit}", digits(value * scale, 5))
}

/// Value and prior.
pub fn quantity(quantity: Quantity, unit: &str) -> String {
    let sigma = quantity.sigma.map_or(String::new(), |sigma| format!(" +- {}", with_unit(sigma, unit)));
    format!("{}{sigma}", with_unit(quantity.value, unit))
}

/// Noise in the units of data sheets, density where one is stated.
pub fn noise(noise: Noise, unit: &str) -> String {
    match (noise, unit) {
        (Noise::PerSample(sigma) | Noise::Density(sigma), _) if sigma.value == 0.0 => "none".into(),
        (Noise::PerSample(sigma), _) => format!("{} a sample", with_unit(sigma.value, unit)),
        (Noise::Density(density), "rad/s") => {
            format!("{} deg/sqrt(h)", digits(density.value.to_degrees() * 60.0, 4))
        }
        (Noise::Density(density), "m/s^2") => {
            format!("{} ug/sqrt(Hz)", digits(density.value / 9.806_65e-6, 4))
        }
        (Noise::Density(density), _) => format!("{}/sqrt(Hz)", with_unit(density.value, unit)),
    }
}

/// `(0.5, -0.3, 0)`.
pub fn vector(values: &[f64]) -> String {
    let numbers: Vec<String> = values.iter().map(|value| digits(*value, 5)).collect();
    format!("({})", numbers.join(", "))
}

/// `1 body`, `3 bodies`.
pub fn count(number: usize, one: &str) -> String {
    match (number, one.strip_suffix('y')) {
        (1, _) => format!("1 {one}"),
        (_, Some(stem)) => format!("{number} {stem}ies"),
        _ => format!("{number} {one}s"),
    }
}

/// `revolute about z`.
pub fn joint(joint: &Joint) -> String {
    match joint.kind {
        JointKind::Free => "free".into(),
        JointKind::Fixed => "fixed".into(),
        JointKind::Revolute { axis } => format!("revolute about {}", direction(axis)),
        JointKind::Prismatic { axis } => format!("prismatic along {}", direction(axis)),
    }
}

/// `-x`, or the vector.
pub fn direction(axis: [f64; 3]) -> String {
    for (i, name) in ["x", "y", "z"].iter().enumerate() {
        if (0..3).all(|k| axis[k].abs() == f64::from(u8::from(k == i))) {
            return format!("{}{name}", if axis[i] < 0.0 { "-" } else { "" });
        }
    }
    vector(&axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_data_sheets_do() {
        assert_eq!(with_unit(1.2e-5, "rad"), "12 urad");
        assert_eq!(with_unit(850.0, "N*s/m"), "850 N*s/m");
        assert_eq!(with_unit(1e-4, "kg*m^2"), "0.0001 kg*m^2");
        assert_eq!(with_unit(2e-3, "m^2"), "0.002 m^2");
        assert_eq!(with_unit(0.005, "1"), "0.005");
        let walk = Noise::Density(Quantity::known(0.09_f64.to_radians() / 60.0));
        assert_eq!(noise(walk, "rad/s"), "0.09 deg/sqrt(h)");
        assert_eq!(noise(Noise::Density(Quantity::known(30.0 * 9.806_65e-6)), "m/s^2"), "30 ug/sqrt(Hz)");
        assert_eq!(
            (count(1, "body"), count(3, "body"), count(0, "tank")),
            ("1 body".into(), "3 bodies".into(), "0 tanks".into())
        );
    }
}
