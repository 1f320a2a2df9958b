//! Numbers with units as data sheets write them: `12 ug/sqrt(Hz)`, `0.1 m/s/sqrt(h)`, `3 kg m^2`.
//!
//! The units are those of the crate `units`; here stand what divides a number from its unit, what a
//! dimension is called, and what to write instead of what cannot be read.

use units::Fault;
pub use units::{NONE, Unit};

/// Parses a unit; empty text is [`NONE`].
///
/// # Errors
/// The symbol or place that cannot be read, with the nearest known symbol.
pub fn parse(text: &str) -> Result<Unit, String> {
    readable(text, units::parse(text))
}

/// As [`parse`], with `g` for gram and not for standard gravity: for where that alone makes sense.
///
/// # Errors
/// As [`parse`].
pub fn parse_with_gram(text: &str) -> Result<Unit, String> {
    readable(text, units::parse_with_gram(text))
}

/// Temperatures of a plant file are differences as well as values: their zero is that of the
/// kelvin.
fn readable(text: &str, read: Result<Unit, Fault>) -> Result<Unit, String> {
    match read {
        Ok(unit) if unit.has_own_zero() => Err(format!("'{}' does not begin at absolute zero", text.trim())),
        Ok(unit) => Ok(unit),
        Err(Fault::Malformed(why)) => Err(why),
        Err(Fault::Unknown(name)) => {
            let near = dynamics::description::nearest(&name, units::symbols().flatten().copied());
            let hint = near.map(|near| format!("; did you mean '{near}'?")).unwrap_or_default();
            Err(format!("unknown unit '{name}'{hint}"))
        }
    }
}

/// Divides "−1.5e-3 N*m" into its number and its unit.
pub fn split(text: &str) -> Option<(&str, &str)> {
    let text = text.trim();
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return None;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits((end + 1 + sign).min(bytes.len()));
        if exponent > 0 {
            end += 1 + sign + exponent;
        }
    }
    Some((&text[..end], text[end..].trim_start()))
}

/// What a dimension is called, for messages.
pub fn called(unit: &Unit) -> &'static str {
    let found = QUANTITIES.iter().find(|(text, _)| parse(text).is_ok_and(|known| known.dimension == unit.dimension));
    if unit.dimension == [0; 5] && unit.radian != 0 {
        return "an angle";
    }
    if unit.dimension == [0, 0, -2, 0, 0] {
        return if unit.hertz != 0 { "a frequency" } else { "an angular rate" };
    }
    found.map_or("something else", |(_, name)| name)
}

static QUANTITIES: &[(&str, &str)] = &[
    ("1", "a plain number"),
    ("kg", "a mass"),
    ("m", "a length"),
    ("s", "a time"),
    ("A", "a current"),
    ("K", "a temperature"),
    ("m/s", "a velocity"),
    ("m/s^2", "an acceleration"),
    ("rad/s^2", "an angular acceleration"),
    ("kg*m^2", "an inertia"),
    ("N", "a force"),
    ("N*m", "a torque"),
    ("N/m", "a stiffness"),
    ("N*s/m", "a damping"),
    ("N*m*s", "an angular damping or momentum"),
    ("V", "a voltage"),
    ("V*s", "a back-emf constant"),
    ("ohm", "a resistance"),
    ("T", "a magnetic field"),
    ("W", "a power"),
    ("m^2", "an area"),
    ("kg/m^3", "a density"),
    ("1/sqrt(s)", "an angle random walk"),
    ("m/s/sqrt(s)", "a velocity random walk"),
    ("sqrt(kg)", "a participation of translation"),
    ("sqrt(kg)*m", "a participation of rotation"),
    ("1/sqrt(kg)", "a mass-normalised shape"),
];

mod cures;

pub use cures::likely_cure;

#[cfg(test)]
mod tests;
