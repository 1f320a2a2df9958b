//! Units accepted in files, and what they are in SI: the one table.
//!
//! Values are converted once, at this border: `SI = value * multiply / divide + offset`. Powers of
//! ten divide or multiply by an exact number, so that 5 ms is the f64 nearest to 0.005.

mod composed;

use core::f64::consts::PI;

/// One spelling of a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    pub symbol: &'static str,
    /// The SI unit it is converted to.
    pub si: &'static str,
    multiply: f64,
    divide: f64,
    offset: f64,
}

impl Unit {
    /// `value` in this unit, expressed in [`Unit::si`].
    #[must_use]
    pub fn to_si(&self, value: f64) -> f64 {
        let scaled = value * self.multiply / self.divide;
        // A sum with 0 would turn -0 into 0: what is SI already stays bit for bit what it is.
        if self.offset == 0.0 { scaled } else { scaled + self.offset }
    }
}

const fn u(symbol: &'static str, si: &'static str, multiply: f64, divide: f64) -> Unit {
    Unit { symbol, si, multiply, divide, offset: 0.0 }
}

/// Unit of a channel whose file states none: no unit of a plant equals it.
pub const NOT_STATED: &str = "?";

/// Standard gravity [m/s^2], exact by definition (CGPM 1901).
const G0_M_S2: f64 = 9.806_65;

/// Every accepted unit.
pub static UNITS: &[Unit] = &[
    u("-", "-", 1.0, 1.0),
    u("%", "-", 1.0, 100.0),
    u("s", "s", 1.0, 1.0),
    u("ms", "s", 1.0, 1e3),
    u("us", "s", 1.0, 1e6),
    u("ns", "s", 1.0, 1e9),
    u("min", "s", 60.0, 1.0),
    u("h", "s", 3600.0, 1.0),
    u("d", "s", 86_400.0, 1.0),
    u("Hz", "Hz", 1.0, 1.0),
    u("kHz", "Hz", 1e3, 1.0),
    u("m", "m", 1.0, 1.0),
    u("cm", "m", 1.0, 1e2),
    u("mm", "m", 1.0, 1e3),
    u("um", "m", 1.0, 1e6),
    u("km", "m", 1e3, 1.0),
    u("in", "m", 0.0254, 1.0),
    u("ft", "m", 0.3048, 1.0),
    u("m/s", "m/s", 1.0, 1.0),
    u("mm/s", "m/s", 1.0, 1e3),
    u("km/s", "m/s", 1e3, 1.0),
    u("m/s^2", "m/s^2", 1.0, 1.0),
    u("mm/s^2", "m/s^2", 1.0, 1e3),
    u("g", "m/s^2", G0_M_S2, 1.0),
    u("mg", "m/s^2", G0_M_S2, 1e3),
    u("ug", "m/s^2", G0_M_S2, 1e6),
    u("m/s^3", "m/s^3", 1.0, 1.0),
    u("m^2", "m^2", 1.0, 1.0),
    u("m^3", "m^3", 1.0, 1.0),
    u("1/s", "1/s", 1.0, 1.0),
    // Frequency responses: receptance, mobility, accelerance, and those of a torque.
    u("m/N", "m/N", 1.0, 1.0),
    u("m/s/N", "m/s/N", 1.0, 1.0),
    u("m/s^2/N", "m/s^2/N", 1.0, 1.0),
    u("rad/N/m", "rad/N/m", 1.0, 1.0),
    u("rad/s/N/m", "rad/s/N/m", 1.0, 1.0),
    u("rad/s^2/N/m", "rad/s^2/N/m", 1.0, 1.0),
    u("rad", "rad", 1.0, 1.0),
    u("mrad", "rad", 1.0, 1e3),
    u("deg", "rad", PI, 180.0),
    u("rev", "rad", 2.0 * PI, 1.0),
    u("rad/s", "rad/s", 1.0, 1.0),
    u("mrad/s", "rad/s", 1.0, 1e3),
    u("deg/s", "rad/s", PI, 180.0),
    u("deg/h", "rad/s", PI, 180.0 * 3600.0),
    u("rpm", "rad/s", 2.0 * PI, 60.0),
    u("rad/s^2", "rad/s^2", 1.0, 1.0),
    u("deg/s^2", "rad/s^2", PI, 180.0),
    u("mrad/s^2", "rad/s^2", 1.0, 1e3),
    u("rpm/s", "rad/s^2", 2.0 * PI, 60.0),
    u("kg", "kg", 1.0, 1.0),
    u("kg/s", "kg/s", 1.0, 1.0),
    u("g/s", "kg/s", 1.0, 1e3),
    u("kg*m", "kg*m", 1.0, 1.0),
    u("kg*m^2", "kg*m^2", 1.0, 1.0),
    u("kg/m^3", "kg/m^3", 1.0, 1.0),
    u("N", "N", 1.0, 1.0),
    u("mN", "N", 1.0, 1e3),
    u("kN", "N", 1e3, 1.0),
    u("uN", "N", 1.0, 1e6),
    u("lbf", "N", 4.448_221_615_260_5, 1.0),
    u("N*s", "N*s", 1.0, 1.0),
    u("N/m", "N/m", 1.0, 1.0),
    u("N/mm", "N/m", 1e3, 1.0),
    u("kN/m", "N/m", 1e3, 1.0),
    u("N*s/m", "N*s/m", 1.0, 1.0),
    u("N*m", "N*m", 1.0, 1.0),
    u("mN*m", "N*m", 1.0, 1e3),
    u("uN*m", "N*m", 1.0, 1e6),
    u("kN*m", "N*m", 1e3, 1.0),
    u("N*m/rad", "N*m/rad", 1.0, 1.0),
    u("N*m/deg", "N*m/rad", 180.0, PI),
    u("N*m*s/rad", "N*m*s/rad", 1.0, 1.0),
    u("N*m/A", "N*m/A", 1.0, 1.0),
    u("mN*m/A", "N*m/A", 1.0, 1e3),
    u("N*m*s", "N*m*s", 1.0, 1.0),
    u("mN*m*s", "N*m*s", 1.0, 1e3),
    u("Pa", "Pa", 1.0, 1.0),
    u("hPa", "Pa", 1e2, 1.0),
    u("kPa", "Pa", 1e3, 1.0),
    u("MPa", "Pa", 1e6, 1.0),
    u("bar", "Pa", 1e5, 1.0),
    u("T", "T", 1.0, 1.0),
    u("mT", "T", 1.0, 1e3),
    u("uT", "T", 1.0, 1e6),
    u("nT", "T", 1.0, 1e9),
    u("K", "K", 1.0, 1.0),
    Unit { symbol: "degC", si: "K", multiply: 1.0, divide: 1.0, offset: 273.15 },
    u("V", "V", 1.0, 1.0),
    u("mV", "V", 1.0, 1e3),
    u("A", "A", 1.0, 1.0),
    u("mA", "A", 1.0, 1e3),
    u("uA", "A", 1.0, 1e6),
    u("ohm", "ohm", 1.0, 1.0),
    u("H", "H", 1.0, 1.0),
    u("mH", "H", 1.0, 1e3),
    u("V*s/rad", "V*s/rad", 1.0, 1.0),
    u("A*m^2", "A*m^2", 1.0, 1.0),
    u("W", "W", 1.0, 1.0),
    u("mW", "W", 1.0, 1e3),
    u("J", "J", 1.0, 1.0),
];

/// The unit spelled `text`: an entry of [`UNITS`], or a product of powers of units as files write
/// them (`m s^-2`, `N·m`, `deg/sec`, `dps`, `in/s`), where its dimension is one of the table.
///
/// ```
/// use recording::units::unit_named;
///
/// for spelling in ["m/s^2", "m/s2", "m s-2", "m·s⁻²", "meters/sec^2", "(m/s/s)"] {
///     assert_eq!(unit_named(spelling).unwrap().si, "m/s^2", "{spelling}");
/// }
/// assert_eq!(unit_named("dps").unwrap().to_si(180.0), core::f64::consts::PI);
/// assert_eq!(unit_named("N/n"), None);
/// ```
#[must_use]
pub fn unit_named(text: &str) -> Option<Unit> {
    let plain = composed::plain(text);
    let listed = |symbol: &str| UNITS.iter().find(|unit| unit.symbol == symbol).copied();
    match plain.as_str() {
        "" | "1" => listed("-"),
        symbol => listed(symbol).or_else(|| composed::unit(symbol)),
    }
}

/// A spelling that is known in place of `text`, which is not: the one symbol of it that is unknown
/// replaced by the nearest, everything else left as it stands, so that the dimension stays what the
/// file means.
#[must_use]
pub fn nearest_spelling(text: &str) -> Option<String> {
    composed::corrected(text)
}

/// `text` as it stands in the table, where it is an SI unit there.
pub(crate) fn si_unit(text: &str) -> Option<&'static str> {
    if text == NOT_STATED {
        return Some(NOT_STATED);
    }
    UNITS.iter().find(|unit| unit.symbol == text && unit.si == text).map(|unit| unit.si)
}

/// The spellings that are converted to `si`, as a list for a reader.
#[must_use]
pub fn accepted_for(si: &str) -> String {
    UNITS.iter().filter(|unit| unit.si == si).map(|unit| unit.symbol).collect::<Vec<_>>().join(", ")
}

impl Unit {
    /// A unit that is `multiply / divide` of the SI unit `si`.
    pub(crate) fn scaled(si: &'static str, multiply: f64, divide: f64) -> Self {
        Unit { symbol: si, si, multiply, divide, offset: 0.0 }
    }

    /// Of a number whose unit is not stated.
    pub(crate) fn not_stated() -> Self {
        Unit::scaled(NOT_STATED, 1.0, 1.0)
    }
}
