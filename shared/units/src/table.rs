//! The table: every symbol with its spellings, its unit and the prefixes it takes.

use crate::unit::{NONE, Unit, angle, unit};

/// A unit under all its names; the first is the one that is written.
pub(crate) struct Symbol {
    pub names: &'static [&'static str],
    pub unit: Unit,
    /// Prefixes of one letter, for every name.
    prefixes: &'static str,
}

const fn symbol(names: &'static [&'static str], unit: Unit, prefixes: &'static str) -> Symbol {
    Symbol { names, unit, prefixes }
}

const METRE: Unit = unit([0, 1, 0, 0, 0], 1.0, 1.0, 0);
const SECOND: Unit = unit([0, 0, 1, 0, 0], 1.0, 1.0, 0);
const NEWTON: Unit = unit([1, 1, -2, 0, 0], 1.0, 1.0, 0);
const JOULE: Unit = unit([1, 2, -2, 0, 0], 1.0, 1.0, 0);
const TURN: Unit = angle(2.0, 1.0);
pub(crate) const KILOGRAM: Unit = unit([1, 0, 0, 0, 0], 1.0, 1.0, 0);
/// 9.80665 m/s^2, exact by definition (CGPM 1901).
pub(crate) const STANDARD_GRAVITY: Unit = unit([0, 1, -2, 0, 0], 980_665.0, 1.0, -5);
/// 4.4482216152605 N, exact: 0.45359237 kg at standard gravity.
const POUND_N: f64 = 44_482_216_152_605.0;

/// Every symbol.
pub(crate) static SYMBOLS: &[Symbol] = &[
    symbol(&["kg", "kilogram", "kilograms", "Kg", "KG", "kgs", "кг"], KILOGRAM, ""),
    symbol(&["gram", "grams"], unit([1, 0, 0, 0, 0], 1.0, 1e3, 0), "um"),
    symbol(&["lb", "lbs", "lbm"], unit([1, 0, 0, 0, 0], 45_359_237.0, 1.0, -8), ""),
    symbol(&["oz"], unit([1, 0, 0, 0, 0], 28_349_523_125.0, 1.0, -12), ""),
    symbol(&["slug", "slugs"], unit([1, 0, 0, 0, 0], POUND_N, 3048.0, -9), ""),
    symbol(&["m", "meter", "meters", "metre", "metres", "м", "米"], METRE, "numckM"),
    symbol(&["in", "inch", "inches"], unit([0, 1, 0, 0, 0], 254.0, 1.0, -4), ""),
    symbol(&["ft", "foot", "feet"], unit([0, 1, 0, 0, 0], 3048.0, 1.0, -4), ""),
    symbol(&["mile", "miles", "mi"], unit([0, 1, 0, 0, 0], 1_609_344.0, 1.0, -3), ""),
    symbol(&["nmi"], unit([0, 1, 0, 0, 0], 1852.0, 1.0, 0), ""),
    symbol(
        &[
            "s", "sec", "secs", "second", "seconds", "Sec", "Sek", "sek", "Sekunde", "Sekunden", "sekunden", "seg",
            "segundo", "segundos", "secondi", "с", "秒",
        ],
        SECOND,
        "numk",
    ),
    symbol(&["micros"], unit([0, 0, 1, 0, 0], 1.0, 1.0, -6), ""),
    symbol(&["millis"], unit([0, 0, 1, 0, 0], 1.0, 1.0, -3), ""),
    symbol(&["nanos"], unit([0, 0, 1, 0, 0], 1.0, 1.0, -9), ""),
    symbol(&["min", "mins", "minute", "minutes", "Minuten", "мин", "分"], unit([0, 0, 1, 0, 0], 60.0, 1.0, 0), ""),
    symbol(&["h", "hr", "hrs", "hour", "hours", "Std", "Stunden"], unit([0, 0, 1, 0, 0], 3600.0, 1.0, 0), ""),
    symbol(&["d", "day", "days"], unit([0, 0, 1, 0, 0], 86_400.0, 1.0, 0), ""),
    symbol(&["Hz", "hz", "HZ", "hertz", "Hertz", "Гц"], unit([0, 0, -1, 0, 0], 1.0, 1.0, 0).of_cycles(), "numkMG"),
    symbol(&["SPS", "Sps", "sps"], unit([0, 0, -1, 0, 0], 1.0, 1.0, 0).of_cycles(), "kM"),
    symbol(&["kn", "kt", "kts", "knot", "knots"], unit([0, 1, -1, 0, 0], 1852.0, 3600.0, 0), ""),
    symbol(&["fps"], unit([0, 1, -1, 0, 0], 3048.0, 1.0, -4), ""),
    symbol(&["ips"], unit([0, 1, -1, 0, 0], 254.0, 1.0, -4), ""),
    symbol(&["liter", "liters", "litre", "litres"], unit([0, 3, 0, 0, 0], 1.0, 1.0, -3), "m"),
    symbol(&["mph"], unit([0, 1, -1, 0, 0], 1_609_344.0, 3600.0, -3), ""),
    symbol(&["kph", "kmh", "kmph"], unit([0, 1, -1, 0, 0], 1.0, 3600.0, 0).prefixed(3), ""),
    symbol(&["mps"], unit([0, 1, -1, 0, 0], 1.0, 1.0, 0), ""),
    symbol(&["g", "gee", "gees", "g0", "gn", "gravity"], STANDARD_GRAVITY, "num"),
    symbol(&["Gal"], unit([0, 1, -2, 0, 0], 1.0, 1.0, -2), "m"),
    symbol(&["rad", "rads", "radian", "radians", "рад", "弧度"], NONE.of_angle(), "num"),
    symbol(
        &["deg", "degs", "degree", "degrees", "Deg", "Grad", "grados", "gradi", "degré", "degrés", "град", "度"],
        angle(1.0, 180.0),
        "m",
    ),
    symbol(&["arcmin", "arcminute", "arcminutes"], angle(1.0, 10_800.0), ""),
    symbol(&["arcsec", "asec", "arcsecs", "arcsecond", "arcseconds"], angle(1.0, 648_000.0), "m"),
    symbol(
        &[
            "rev",
            "revs",
            "revolution",
            "revolutions",
            "turn",
            "turns",
            "cycles",
            "U",
            "Umdr",
            "Umdrehung",
            "Umdrehungen",
            "tr",
            "tour",
            "tours",
            "giri",
            "giro",
            "obr",
            "об",
            "转",
        ],
        TURN,
        "",
    ),
    symbol(&["rpm", "RPM", "Rpm"], angle(2.0, 60.0).per_second(), "k"),
    symbol(&["rps", "RPS"], TURN.per_second(), ""),
    symbol(&["dps", "DPS"], angle(1.0, 180.0).per_second(), "m"),
    symbol(&["N", "newton", "newtons", "Newton", "Newtons", "Н"], NEWTON, "numkM"),
    symbol(&["daN"], NEWTON.prefixed(1), ""),
    symbol(&["lbf", "lbsf"], unit([1, 1, -2, 0, 0], POUND_N, 1.0, -13), "k"),
    symbol(&["kip", "kips"], unit([1, 1, -2, 0, 0], POUND_N, 1.0, -13).prefixed(3), ""),
    symbol(&["kgf", "kp"], unit([1, 1, -2, 0, 0], 980_665.0, 1.0, -5), ""),
    symbol(&["gf"], unit([1, 1, -2, 0, 0], 980_665.0, 1.0, -5).prefixed(-3), ""),
    symbol(&["ozf"], unit([1, 1, -2, 0, 0], POUND_N, 16.0, -13), ""),
    symbol(&["Nm", "newtonmeter", "newtonmeters", "newtonmetre", "Newtonmeter"], JOULE, "numkM"),
    symbol(&["Ncm"], JOULE.prefixed(-2), ""),
    symbol(&["Nmm"], JOULE.prefixed(-3), ""),
    symbol(&["Ns"], unit([1, 1, -1, 0, 0], 1.0, 1.0, 0), "umk"),
    symbol(&["Nms"], unit([1, 2, -1, 0, 0], 1.0, 1.0, 0), "umk"),
    symbol(&["Am"], unit([0, 1, 0, 1, 0], 1.0, 1.0, 0), ""),
    symbol(&["kgm"], unit([1, 1, 0, 0, 0], 1.0, 1.0, 0), ""),
    symbol(&["ftlbf", "ftlb", "lbft"], unit([1, 2, -2, 0, 0], POUND_N * 3048.0, 1.0, -17), ""),
    symbol(&["inlbf", "inlb", "lbin"], unit([1, 2, -2, 0, 0], POUND_N * 254.0, 1.0, -17), ""),
    symbol(&["J", "joule", "joules", "Joule"], JOULE, "numkM"),
    symbol(&["W", "watt", "watts", "Watt"], unit([1, 2, -3, 0, 0], 1.0, 1.0, 0), "numkM"),
    symbol(&["Pa", "pascal", "pascals"], unit([1, -1, -2, 0, 0], 1.0, 1.0, 0), "numhkMG"),
    symbol(&["bar"], unit([1, -1, -2, 0, 0], 1.0, 1.0, 0).prefixed(5), "m"),
    symbol(&["psi", "PSI", "psia"], unit([1, -1, -2, 0, 0], POUND_N, 64_516.0, -5), "k"),
    symbol(&["atm"], unit([1, -1, -2, 0, 0], 101_325.0, 1.0, 0), ""),
    symbol(&["Torr", "torr", "mmHg"], unit([1, -1, -2, 0, 0], 101_325.0, 760.0, 0), "m"),
    symbol(
        &["A", "amp", "amps", "ampere", "amperes", "Amp", "Amps", "Ampere", "Arms", "A_rms", "А"],
        unit([0, 0, 0, 1, 0], 1.0, 1.0, 0),
        "numk",
    ),
    symbol(
        &["V", "volt", "volts", "Volt", "Volts", "Vrms", "V_rms", "Vdc", "VDC", "Vac", "VAC", "В"],
        unit([1, 2, -3, -1, 0], 1.0, 1.0, 0),
        "numk",
    ),
    symbol(&["C", "coulomb", "coulombs"], unit([0, 0, 1, 1, 0], 1.0, 1.0, 0), "num"),
    symbol(&["ohm", "ohms", "Ohm", "Ohms"], unit([1, 2, -3, -2, 0], 1.0, 1.0, 0), "mkM"),
    symbol(&["H", "henry"], unit([1, 2, -2, -2, 0], 1.0, 1.0, 0), "num"),
    symbol(&["T", "tesla", "Tesla"], unit([1, 0, -2, -1, 0], 1.0, 1.0, 0), "num"),
    symbol(&["gauss", "Gauss", "G", "Gs"], unit([1, 0, -2, -1, 0], 1.0, 1.0, -4), "num"),
    symbol(&["K", "kelvin", "Kelvin"], unit([0, 0, 0, 0, 1], 1.0, 1.0, 0), "m"),
    symbol(&["percent", "pct", "%"], unit([0; 5], 1.0, 1.0, -2), ""),
    symbol(&["ppm"], unit([0; 5], 1.0, 1.0, -6), ""),
    symbol(&["ppb"], unit([0; 5], 1.0, 1.0, -9), ""),
    symbol(&["strain"], NONE, "num"),
    symbol(
        &[
            "-", "1", "count", "counts", "cts", "cnt", "LSB", "lsb", "LSBs", "digit", "digits", "bit", "bits", "tick",
            "ticks", "pulse", "pulses", "steps", "codes", "raw",
        ],
        NONE,
        "",
    ),
    symbol(&["dimensionless", "unitless", "none", "None", "bool", "boolean", "flag", "ratio", "normalized"], NONE, ""),
];

/// Temperatures whose zero is not that of the kelvin: alone, and in no product.
pub(crate) static TEMPERATURES: &[(&[&str], Unit)] = &[
    (
        &["degC", "deg*C", "celsius", "Celsius", "degreesC", "deg_C", "degrees*C", "Grad*C", "gradC", "degré*C"],
        unit([0, 0, 0, 0, 1], 1.0, 1.0, 0).with_zero_at(273.15),
    ),
    (
        &["degF", "deg*F", "fahrenheit", "Fahrenheit"],
        unit([0, 0, 0, 0, 1], 5.0, 9.0, 0).with_zero_at(459.67 * 5.0 / 9.0),
    ),
];

/// What is meant as a whole, and how it is read: pounds times feet are a torque, and nobody means
/// a mass times a length; a servo's g is a mass where a length or a time follows; `ms-1` is what
/// journals print of m s⁻¹.
pub(crate) static WHOLE: &[(&[&str], &str)] = &[
    (&["ft*lb", "lb*ft", "ft*lbs", "lbs*ft"], "ftlbf"),
    (&["in*lb", "lb*in", "in*lbs", "lbs*in"], "inlbf"),
    (&["oz*in", "in*oz", "ozin", "inoz"], "ozf*in"),
    (&["g/s"], "gram/s"),
    (&["ms-1", "ms^-1"], "m/s"),
    (&["ms-2", "ms^-2"], "m/s^2"),
    (&["mms-1", "mms^-1"], "mm/s"),
    (&["cms-1", "cms^-1"], "cm/s"),
    (&["kms-1", "kms^-1"], "km/s"),
    (&["rads-1", "rads^-1"], "rad/s"),
    (&["rads-2", "rads^-2"], "rad/s^2"),
    (&["degs-1", "degs^-1"], "deg/s"),
    (&["degs-2", "degs^-2"], "deg/s^2"),
    (&["kgcm"], "kgf*cm"),
    (&["milli*g"], "mg"),
    (&["micro*g"], "ug"),
    (&["l/min", "L/min", "lpm", "LPM"], "liter/min"),
    (&["ml/min", "mL/min"], "mliter/min"),
    (&["l/s", "L/s"], "liter/s"),
    (&["l/h", "L/h"], "liter/h"),
    (&["r/min"], "rpm"),
    (&["r/s"], "rps"),
    (&["a*u", "n/a", "ADC*counts", "ADC*count"], "1"),
];

/// What data sheets run together, between two strokes of a fraction.
pub(crate) static RUN_TOGETHER: &[(&str, &str)] = &[
    ("Nm", "N*m"),
    ("uNm", "uN*m"),
    ("mNm", "mN*m"),
    ("kNm", "kN*m"),
    ("Ns", "N*s"),
    ("Nms", "N*m*s"),
    ("mNms", "mN*m*s"),
    ("Am^2", "A*m^2"),
    ("Am2", "A*m^2"),
    ("kgm^2", "kg*m^2"),
    ("kgm2", "kg*m^2"),
    ("kgcm^2", "kg*cm^2"),
    ("kgcm2", "kg*cm^2"),
    ("gcm^2", "gram*cm^2"),
    ("gcm2", "gram*cm^2"),
];

/// Power of ten of a prefix of one letter.
fn power_of(prefix: char) -> Option<i32> {
    match prefix {
        'n' => Some(-9),
        'u' => Some(-6),
        'm' => Some(-3),
        'c' => Some(-2),
        'h' => Some(2),
        'k' => Some(3),
        'M' => Some(6),
        'G' => Some(9),
        _ => None,
    }
}

/// Prefixes in words, before names of more than two letters.
const WORDS: &[(&str, char)] =
    &[("nano", 'n'), ("micro", 'u'), ("milli", 'm'), ("centi", 'c'), ("kilo", 'k'), ("mega", 'M')];

/// The symbol that `name` is, its power of ten, and the name it was found under.
pub(crate) fn found(name: &str) -> Option<(&'static Symbol, i32)> {
    if let Some(symbol) = SYMBOLS.iter().find(|symbol| symbol.names.contains(&name)) {
        return Some((symbol, 0));
    }
    let prefix = name.chars().next()?;
    let short = Some((prefix, &name[prefix.len_utf8()..]));
    let long = WORDS.iter().find_map(|(word, prefix)| Some((*prefix, name.strip_prefix(word)?)));
    let long = long.filter(|(_, base)| base.len() > 2);
    [long, short].into_iter().flatten().find_map(|(prefix, base)| {
        let takes = |symbol: &&Symbol| symbol.names.contains(&base) && symbol.prefixes.contains(prefix);
        Some((SYMBOLS.iter().find(takes)?, power_of(prefix)?))
    })
}

/// `name` is one symbol, with a prefix or without.
#[must_use]
pub fn is_symbol(name: &str) -> bool {
    found(name).is_some()
}

/// Every name of the table, without prefixes; of each unit, the first is the one that is written.
pub fn symbols() -> impl Iterator<Item = &'static [&'static str]> {
    SYMBOLS.iter().map(|symbol| symbol.names)
}
