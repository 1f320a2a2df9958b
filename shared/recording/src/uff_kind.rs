//! The type of a function of a universal file, first field of record 6, and what its unit says of
//! it.
//!
//! Types: 0 unknown, 1 time response, 2 auto spectrum, 3 cross spectrum, 4 frequency response, 5
//! transmissibility, 6 coherence, 7 and 8 correlations, 9 and 10 power and energy spectral density,
//! 12 spectrum, 21 and 26 partial and multiple coherence.

use crate::function_kind::FunctionKind;
use crate::uff_dataset::Domain;
use crate::units::unit_named;

/// What a function is by its type, its axis and the unit of its ordinate; `divided` by the quantity
/// of an input.
pub(crate) fn kind_of(kind: i64, domain: Domain, label: Option<&str>, divided: bool) -> FunctionKind {
    if domain == Domain::Time {
        return if matches!(kind, 7 | 8) { FunctionKind::Correlation } else { FunctionKind::Time };
    }
    let unit = label.map(OrdinateUnit::of);
    let power = unit.as_ref().map(|unit| unit.power);
    match kind {
        4 | 5 => FunctionKind::Response,
        3 if divided => FunctionKind::Response,
        3 => FunctionKind::CrossSpectrum,
        2 => FunctionKind::AutoSpectrum { power: !matches!(power, Some(Power::One | Power::Root)) },
        9 | 10 if power == Some(Power::Root) => FunctionKind::AutoSpectrum { power: false },
        9 | 10 => FunctionKind::PowerSpectralDensity,
        6 | 21 | 26 => FunctionKind::Coherence,
        12 => FunctionKind::Spectrum,
        0 | 1 => of_unknown_type(unit, label, divided),
        _ => FunctionKind::Other,
    }
}

fn of_unknown_type(unit: Option<OrdinateUnit>, label: Option<&str>, divided: bool) -> FunctionKind {
    let of_response = |label: &str| unit_named(label).is_some_and(|unit| unit.si.ends_with("/N"));
    match unit {
        _ if divided || label.is_some_and(of_response) => FunctionKind::Response,
        Some(OrdinateUnit { power: Power::Square, density: true, .. }) => FunctionKind::PowerSpectralDensity,
        Some(OrdinateUnit { power: Power::Square, .. }) => FunctionKind::AutoSpectrum { power: true },
        _ => FunctionKind::Unknown,
    }
}

/// Which power of the quantity a spectrum holds, by its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Power {
    /// Its magnitude: `m/s^2`.
    One,
    /// Its magnitude over the root of the bandwidth: `m/s^2/sqrt(Hz)`.
    Root,
    /// Its square: `(m/s^2)^2`.
    Square,
    /// The unit is not known.
    Unclear,
}

/// The unit of a spectrum, taken apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OrdinateUnit {
    pub power: Power,
    /// Per hertz.
    density: bool,
    /// Unit of the quantity itself.
    pub quantity: String,
}

impl OrdinateUnit {
    /// `(m/s^2)^2/Hz`, `m^2/s^4`, `g^2`, `m/s^2/sqrt(Hz)`, `m/s^2`.
    pub fn of(label: &str) -> Self {
        for root in ["/sqrt(Hz)", "/rtHz", "/Hz^0.5", "/Hz^(1/2)"] {
            if let Some(quantity) = without_end(label, root) {
                return OrdinateUnit { power: Power::Root, density: true, quantity };
            }
        }
        let (squared, density) = match without_end(label, "/Hz") {
            Some(squared) => (squared, true),
            None => (label.to_string(), false),
        };
        let square = |quantity: String| OrdinateUnit { power: Power::Square, density, quantity };
        let inner = squared.strip_suffix("^2").map(str::trim);
        let bracketed = inner.and_then(|inner| inner.strip_prefix('(')?.strip_suffix(')'));
        if let Some(quantity) = bracketed {
            return square(quantity.trim().to_string());
        }
        if let Some(quantity) = inner.filter(|inner| inner.contains('^') && unit_named(inner).is_some()) {
            return square(quantity.to_string());
        }
        match halved(&squared) {
            Some(quantity) => square(quantity),
            None if unit_named(&squared).is_some() => OrdinateUnit { power: Power::One, density, quantity: squared },
            None => OrdinateUnit { power: Power::Unclear, density, quantity: squared },
        }
    }
}

/// `text` without `end`, in any case of letters.
fn without_end(text: &str, end: &str) -> Option<String> {
    let at = text.len().checked_sub(end.len())?;
    text.get(at..).filter(|found| found.eq_ignore_ascii_case(end))?;
    Some(text[..at].trim().to_string())
}

/// A product of even powers with every exponent halved: `m/s^2` of `m^2/s^4`.
fn halved(unit: &str) -> Option<String> {
    let half = |factor: &str| {
        let (base, exponent) = factor.split_once('^').filter(|(base, _)| !base.trim().is_empty())?;
        match exponent.trim().parse::<u32>().ok().filter(|n| *n > 0 && n.is_multiple_of(2))? / 2 {
            1 => Some(base.trim().to_string()),
            n => Some(format!("{}^{n}", base.trim())),
        }
    };
    let above = |part: &str| part.split('*').map(half).collect::<Option<Vec<_>>>().map(|all| all.join("*"));
    unit.split('/').map(above).collect::<Option<Vec<_>>>().map(|parts| parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_says_which_power_of_the_quantity_it_holds() {
        let cases = [
            ("(m/s^2)^2", Power::Square, "m/s^2"),
            ("(m/s^2)^2/Hz", Power::Square, "m/s^2"),
            ("m^2/s^4", Power::Square, "m/s^2"),
            ("m/s^2^2/HZ", Power::Square, "m/s^2"),
            ("g^2/Hz", Power::Square, "g"),
            ("m^2", Power::Square, "m"),
            ("m/s^2", Power::One, "m/s^2"),
            ("g", Power::One, "g"),
            ("m/s^2/sqrt(Hz)", Power::Root, "m/s^2"),
            ("EU", Power::Unclear, "EU"),
            ("^2", Power::Unclear, "^2"),
        ];
        for (label, power, quantity) in cases {
            let unit = OrdinateUnit::of(label);
            assert_eq!((unit.power, unit.quantity.as_str()), (power, quantity), "{label}");
        }
    }

    #[test]
    fn a_type_is_what_it_stands_for_and_type_0_what_its_axis_and_unit_say() {
        let kind = |kind, label, divided| kind_of(kind, Domain::Frequency, label, divided);
        assert_eq!(kind(4, None, false), FunctionKind::Response);
        assert_eq!(kind(3, None, true), FunctionKind::Response);
        assert_eq!(kind(3, None, false), FunctionKind::CrossSpectrum);
        assert_eq!(kind(2, Some("(m/s^2)^2"), false), FunctionKind::AutoSpectrum { power: true });
        assert_eq!(kind(2, Some("m/s^2"), false), FunctionKind::AutoSpectrum { power: false });
        assert_eq!(kind(2, None, false), FunctionKind::AutoSpectrum { power: true });
        assert_eq!(kind(9, None, false), FunctionKind::PowerSpectralDensity);
        assert_eq!(kind(0, Some("g^2/Hz"), false), FunctionKind::PowerSpectralDensity);
        assert_eq!(kind(0, Some("m/s^2/N"), false), FunctionKind::Response);
        assert_eq!(kind(0, Some("m/s^2"), false), FunctionKind::Unknown);
        assert_eq!(kind(18, None, false), FunctionKind::Other);
        assert_eq!(kind_of(0, Domain::Time, None, false), FunctionKind::Time);
        assert_eq!(kind_of(8, Domain::Time, None, false), FunctionKind::Correlation);
    }
}
