//! Units as products of powers of symbols: `m s^-2`, `N·m·s/rad`, `deg/sec`.
//!
//! Products and quotients associate from the left, as in the table: `rad/N/m` is (rad/N)/m. Every
//! symbol is a factor over SI base units; the result takes the name of the SI unit of
//! [`UNITS`] that has its dimension, of several (N m and J, kg/s and N s/m) the one that
//! shares most symbols with the text.

use super::{G0_M_S2, UNITS, Unit};
use crate::error::nearest;
use core::f64::consts::PI;

/// Exponents of kg, m, s, A, K, rad.
type Dimension = [i32; 6];

/// A symbol: its factor over SI as a quotient, and its dimension.
struct Symbol {
    names: &'static [&'static str],
    multiply: f64,
    divide: f64,
    dimension: Dimension,
    /// Prefixes it takes.
    prefixes: &'static str,
}

const fn symbol(
    names: &'static [&'static str],
    (multiply, divide): (f64, f64),
    dimension: Dimension,
    prefixes: &'static str,
) -> Symbol {
    Symbol { names, multiply, divide, dimension, prefixes }
}

const ONE: (f64, f64) = (1.0, 1.0);
const LENGTH: Dimension = [0, 1, 0, 0, 0, 0];
const TIME: Dimension = [0, 0, 1, 0, 0, 0];
const ANGLE: Dimension = [0, 0, 0, 0, 0, 1];
const ANGULAR_RATE: Dimension = [0, 0, -1, 0, 0, 1];
const VELOCITY: Dimension = [0, 1, -1, 0, 0, 0];
const FORCE: Dimension = [1, 1, -2, 0, 0, 0];
const TORQUE: Dimension = [1, 2, -2, 0, 0, 0];
const PRESSURE: Dimension = [1, -1, -2, 0, 0, 0];
const NUMBER: Dimension = [0; 6];
const LBF_N: f64 = 4.448_221_615_260_5;

/// Every symbol, the first name the one that tells units of one dimension apart.
static SYMBOLS: &[Symbol] = &[
    symbol(&["s", "sec", "secs", "second", "seconds", "Sec"], ONE, TIME, "k"),
    symbol(&["ms", "msec", "msecs", "millis", "millisec", "millisecond", "milliseconds"], (1.0, 1e3), TIME, ""),
    symbol(&["us", "usec", "usecs", "micros", "microsec", "microsecond", "microseconds"], (1.0, 1e6), TIME, ""),
    symbol(&["ns", "nsec", "nsecs", "nanos", "nanosec", "nanosecond", "nanoseconds"], (1.0, 1e9), TIME, ""),
    symbol(&["min", "mins", "minute", "minutes"], (60.0, 1.0), TIME, ""),
    symbol(&["h", "hr", "hrs", "hour", "hours"], (3600.0, 1.0), TIME, ""),
    symbol(&["d", "day", "days"], (86_400.0, 1.0), TIME, ""),
    symbol(&["m", "meter", "meters", "metre", "metres"], ONE, LENGTH, "numckM"),
    symbol(&["mm", "millimeter", "millimeters", "millimetre", "millimetres"], (1.0, 1e3), LENGTH, ""),
    symbol(&["in", "inch", "inches"], (0.0254, 1.0), LENGTH, ""),
    symbol(&["ft", "foot", "feet"], (0.3048, 1.0), LENGTH, ""),
    symbol(&["mile", "miles", "mi"], (1609.344, 1.0), LENGTH, ""),
    symbol(&["nmi"], (1852.0, 1.0), LENGTH, ""),
    symbol(&["kn", "kt", "kts", "knot", "knots"], (1852.0, 3600.0), VELOCITY, ""),
    symbol(&["mph"], (1609.344, 3600.0), VELOCITY, ""),
    symbol(&["kph", "kmh", "kmph"], (1e3, 3600.0), VELOCITY, ""),
    symbol(&["mps"], ONE, VELOCITY, ""),
    symbol(&["g", "gee", "gees", "g0", "gn", "gravity"], (G0_M_S2, 1.0), [0, 1, -2, 0, 0, 0], "num"),
    symbol(&["Gal"], (1.0, 100.0), [0, 1, -2, 0, 0, 0], "m"),
    symbol(&["rad", "rads", "radian", "radians"], ONE, ANGLE, "num"),
    symbol(&["deg", "degs", "degree", "degrees", "Deg", "Grad"], (PI, 180.0), ANGLE, "m"),
    symbol(&["arcmin"], (PI, 10_800.0), ANGLE, ""),
    symbol(&["arcsec", "asec"], (PI, 648_000.0), ANGLE, "m"),
    symbol(&["rev", "revs", "revolution", "revolutions", "turn", "turns", "U"], (2.0 * PI, 1.0), ANGLE, ""),
    symbol(&["rpm", "RPM", "Rpm"], (2.0 * PI, 60.0), ANGULAR_RATE, "k"),
    symbol(&["dps", "DPS"], (PI, 180.0), ANGULAR_RATE, "m"),
    symbol(&["rps", "RPS"], (2.0 * PI, 1.0), ANGULAR_RATE, ""),
    symbol(&["Hz", "hz", "HZ", "hertz", "Hertz"], ONE, [0, 0, -1, 0, 0, 0], "mkMG"),
    symbol(&["kg", "kilogram", "kilograms", "Kg", "KG", "kgs"], ONE, [1, 0, 0, 0, 0, 0], ""),
    symbol(&["gram", "grams"], (1.0, 1e3), [1, 0, 0, 0, 0, 0], ""),
    symbol(&["lb", "lbs", "lbm"], (0.453_592_37, 1.0), [1, 0, 0, 0, 0, 0], ""),
    symbol(&["slug", "slugs"], (14.593_902_937_206, 1.0), [1, 0, 0, 0, 0, 0], ""),
    symbol(&["N", "newton", "newtons", "Newton", "Newtons"], ONE, FORCE, "numkM"),
    symbol(&["Nm", "newtonmeter", "newtonmeters", "newtonmetre"], ONE, TORQUE, "numkM"),
    symbol(&["Ns"], ONE, [1, 1, -1, 0, 0, 0], "umk"),
    symbol(&["Nms"], ONE, [1, 2, -1, 0, 0, 0], "umk"),
    symbol(&["Am"], ONE, [0, 1, 0, 1, 0, 0], ""),
    symbol(&["kgm"], ONE, [1, 1, 0, 0, 0, 0], ""),
    symbol(&["lbf", "lbsf"], (LBF_N, 1.0), FORCE, ""),
    symbol(&["kgf", "kp"], (G0_M_S2, 1.0), FORCE, ""),
    symbol(&["ozf"], (LBF_N, 16.0), FORCE, ""),
    symbol(&["ftlbf", "ftlb", "lbft"], (0.3048 * LBF_N, 1.0), TORQUE, ""),
    symbol(&["inlbf", "inlb", "lbin"], (0.0254 * LBF_N, 1.0), TORQUE, ""),
    symbol(&["Pa", "pascal", "pascals"], ONE, PRESSURE, "umhkMG"),
    symbol(&["bar"], (1e5, 1.0), PRESSURE, "m"),
    symbol(&["psi", "PSI"], (LBF_N, 0.0254 * 0.0254), PRESSURE, "k"),
    symbol(&["atm"], (101_325.0, 1.0), PRESSURE, ""),
    symbol(&["Torr", "torr", "mmHg"], (101_325.0, 760.0), PRESSURE, "m"),
    symbol(&["J", "joule", "joules", "Joule"], ONE, TORQUE, "mkM"),
    symbol(&["W", "watt", "watts", "Watt"], ONE, [1, 2, -3, 0, 0, 0], "numkM"),
    symbol(&["A", "amp", "amps", "ampere", "amperes", "Amp", "Amps"], ONE, [0, 0, 0, 1, 0, 0], "numk"),
    symbol(&["V", "volt", "volts", "Volt", "Volts"], ONE, [1, 2, -3, -1, 0, 0], "numk"),
    symbol(&["ohm", "ohms", "Ohm", "Ohms"], ONE, [1, 2, -3, -2, 0, 0], "mkM"),
    symbol(&["H", "henry"], ONE, [1, 2, -2, -2, 0, 0], "um"),
    symbol(&["T", "tesla", "Tesla"], ONE, [1, 0, -2, -1, 0, 0], "num"),
    symbol(&["gauss", "Gauss"], (1.0, 1e4), [1, 0, -2, -1, 0, 0], "m"),
    symbol(&["K", "kelvin", "Kelvin"], ONE, [0, 0, 0, 0, 1, 0], "m"),
    symbol(&["percent", "pct", "%"], (1.0, 100.0), NUMBER, ""),
    symbol(&["ppm"], (1.0, 1e6), NUMBER, ""),
    symbol(
        &["-", "1", "count", "counts", "cts", "LSB", "lsb", "LSBs", "digit", "digits", "bit", "bits", "ticks"],
        ONE,
        NUMBER,
        "",
    ),
    symbol(
        &["dimensionless", "unitless", "none", "None", "bool", "boolean", "flag", "ratio", "n/a", "normalized"],
        ONE,
        NUMBER,
        "",
    ),
];

/// Temperatures whose zero is not that of the kelvin: alone, and in no product.
static OFFSETS: &[(&[&str], Unit)] = &[
    (
        &["degC", "deg*C", "celsius", "Celsius", "degreesC", "deg_C", "degrees*C"],
        Unit { symbol: "degC", si: "K", multiply: 1.0, divide: 1.0, offset: 273.15 },
    ),
    (
        &["degF", "deg*F", "fahrenheit", "Fahrenheit"],
        Unit { symbol: "degF", si: "K", multiply: 5.0, divide: 9.0, offset: 459.67 * 5.0 / 9.0 },
    ),
];

/// `text` with one spelling for signs: `*`, `/`, `^`, letters of ASCII; outer brackets gone.
pub(super) fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut raised = false;
    for c in without_brackets(text.trim()).chars() {
        let power = superscript(c);
        if power.is_some() && !raised {
            plain.push('^');
        }
        raised = power.is_some();
        match power.unwrap_or(c) {
            '°' | 'º' => plain.push_str("deg"),
            '℃' => plain.push_str("degC"),
            'µ' | 'μ' => plain.push('u'),
            'Ω' | '\u{2126}' => plain.push_str("ohm"),
            '·' | '⋅' | '×' | '•' | '\u{00a0}' | ' ' => plain.push('*'),
            '−' | '–' => plain.push('-'),
            other => plain.push(other),
        }
    }
    let plain =
        plain.replace("*per*", "/").replace("**", "^").replace("*/*", "/").replace("/*", "/").replace("*/", "/");
    let plain = plain.replace("*^", "^").replace("^*", "^");
    with_products(&plain)
}

fn without_brackets(text: &str) -> &str {
    let pairs = [('[', ']'), ('(', ')'), ('<', '>'), ('{', '}')];
    let inner = pairs.iter().find_map(|(open, close)| text.strip_prefix(*open)?.strip_suffix(*close));
    // `(m)/(s)` begins and ends with a bracket, too
    inner.filter(|inner| !inner.contains(['(', ')'])).map_or(text, str::trim)
}

fn superscript(c: char) -> Option<char> {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match c {
        '⁻' => Some('-'),
        _ => digits.iter().position(|digit| *digit == c).and_then(|k| char::from_digit(k as u32, 10)),
    }
}

/// A point or a hyphen between letters multiplies; `m/s/s` is a square; newton metres as data
/// sheets run them together.
fn with_products(plain: &str) -> String {
    let all: Vec<char> = plain.chars().collect();
    let between = |i: usize| {
        let letter = |c: Option<&char>| c.is_some_and(|c| c.is_ascii_alphabetic());
        i > 0 && letter(all.get(i + 1)) && (all[i - 1].is_ascii_alphanumeric())
    };
    let product: String =
        all.iter().enumerate().map(|(i, c)| if matches!(c, '.' | '-') && between(i) { '*' } else { *c }).collect();
    match product.as_str() {
        "m/s/s" => "m/s^2".into(),
        _ => product.split('/').map(run_together).collect::<Vec<_>>().join("/"),
    }
}

fn run_together(part: &str) -> &str {
    match part {
        "Nm" => "N*m",
        "uNm" => "uN*m",
        "mNm" => "mN*m",
        "kNm" => "kN*m",
        "Ns" => "N*s",
        "Nms" => "N*m*s",
        "mNms" => "mN*m*s",
        "Am^2" | "Am2" => "A*m^2",
        "kgm^2" | "kgm2" => "kg*m^2",
        other => other,
    }
}

/// A product in the making.
#[derive(Clone)]
struct Product {
    multiply: f64,
    divide: f64,
    dimension: Dimension,
    /// First names of the symbols in it.
    symbols: Vec<&'static str>,
}

const EMPTY: Product = Product { multiply: 1.0, divide: 1.0, dimension: NUMBER, symbols: Vec::new() };

impl Product {
    fn times(&mut self, other: &Product, power: i32) {
        for _ in 0..power.unsigned_abs() {
            let (up, down) = if power > 0 { (other.multiply, other.divide) } else { (other.divide, other.multiply) };
            self.multiply *= up;
            self.divide *= down;
        }
        self.dimension.iter_mut().zip(other.dimension).for_each(|(own, of)| *own += power * of);
        self.symbols.extend(&other.symbols);
    }
}

/// The unit that `plain` spells, in the SI unit of the table of its dimension.
pub(super) fn unit(plain: &str) -> Option<Unit> {
    if let Some((_, unit)) = OFFSETS.iter().find(|(names, _)| names.contains(&plain)) {
        return Some(*unit);
    }
    let product = parse(imperial_torque(plain))?;
    let si = named(&product)?;
    Some(Unit { symbol: si, si, multiply: product.multiply, divide: product.divide, offset: 0.0 })
}

/// Pounds times feet are a torque: nobody means a mass times a length.
fn imperial_torque(plain: &str) -> &str {
    match plain {
        "ft*lb" | "lb*ft" | "ft*lbs" | "lbs*ft" => "ftlbf",
        "in*lb" | "lb*in" | "in*lbs" | "lbs*in" => "inlbf",
        "oz*in" | "in*oz" => "ozf*in",
        other => other,
    }
}

fn named(product: &Product) -> Option<&'static str> {
    let mut best: Option<(usize, &'static str)> = None;
    for unit in UNITS.iter().filter(|unit| unit.symbol == unit.si) {
        let Some(of) = parse(unit.si).filter(|of| of.dimension == product.dimension) else { continue };
        let shared = of.symbols.iter().filter(|name| product.symbols.contains(name)).count();
        if best.is_none_or(|(most, _)| shared > most) {
            best = Some((shared, unit.si));
        }
    }
    best.map(|(_, si)| si)
}

/// Deepest nesting of brackets, and highest power: a file must not exhaust the stack or the time.
const UNIT_DEPTH_MAX: u32 = 4;
const POWER_MAX: i32 = 6;

fn parse(text: &str) -> Option<Product> {
    let mut rest = text;
    let product = product(&mut rest, 0)?;
    rest.is_empty().then_some(product)
}

fn product(rest: &mut &str, depth: u32) -> Option<Product> {
    let mut all = EMPTY;
    let mut sign = 1;
    loop {
        let factor = primary(rest, depth)?;
        all.times(&factor, sign * power(rest)?);
        match rest.chars().next() {
            Some('*') => sign = 1,
            Some('/') => sign = -1,
            _ => return Some(all),
        }
        *rest = &rest[1..];
    }
}

fn primary(rest: &mut &str, depth: u32) -> Option<Product> {
    if let Some(inner) = rest.strip_prefix('(') {
        *rest = inner;
        let inside = if depth < UNIT_DEPTH_MAX { product(rest, depth + 1)? } else { return None };
        *rest = rest.strip_prefix(')')?;
        return Some(inside);
    }
    let end = rest.find(|c: char| !(c.is_ascii_alphabetic() || matches!(c, '%' | '_'))).unwrap_or(rest.len());
    let end = if end == 0 && (rest.starts_with('1') || *rest == "-") { 1 } else { end };
    // `g0` is the one symbol with a digit
    let end = if rest[..end] == *"g" && rest[end..].starts_with('0') { end + 1 } else { end };
    let (name, behind) = rest.split_at(end);
    *rest = behind;
    of_symbol(name)
}

/// The power behind a symbol: `^2`, `^-2`, `^(2)`, `2`, `-2`; 1 where none stands.
fn power(rest: &mut &str) -> Option<i32> {
    let raised = rest.strip_prefix('^');
    let text = raised.unwrap_or(rest);
    let opened = raised.and_then(|text| text.strip_prefix('('));
    let text = opened.unwrap_or(text);
    let signed = text.strip_prefix(['-', '+']).unwrap_or(text);
    let digits = signed.bytes().take_while(u8::is_ascii_digit).count();
    if digits == 0 {
        return if raised.is_some() { None } else { Some(1) };
    }
    let end = text.len() - signed.len() + digits;
    let number = text[..end].trim_start_matches('+').parse::<i32>().ok().filter(|n| n.abs() <= POWER_MAX)?;
    let behind = &text[end..];
    *rest = if opened.is_some() { behind.strip_prefix(')')? } else { behind };
    Some(number)
}

fn of_symbol(name: &str) -> Option<Product> {
    let whole = |symbol: &Symbol, (multiply, divide): (f64, f64)| {
        let symbols = vec![symbol.names[0]];
        Product {
            multiply: symbol.multiply * multiply,
            divide: symbol.divide * divide,
            dimension: symbol.dimension,
            symbols,
        }
    };
    if let Some(symbol) = SYMBOLS.iter().find(|symbol| symbol.names.contains(&name)) {
        return Some(whole(symbol, ONE));
    }
    let prefix = name.chars().next().filter(char::is_ascii)?;
    let ten = match prefix {
        'n' => (1.0, 1e9),
        'u' => (1.0, 1e6),
        'm' => (1.0, 1e3),
        'c' => (1.0, 1e2),
        'h' => (1e2, 1.0),
        'k' => (1e3, 1.0),
        'M' => (1e6, 1.0),
        'G' => (1e9, 1.0),
        _ => return None,
    };
    let base = &name[1..];
    let takes = |symbol: &&Symbol| symbol.names[0] == base && symbol.prefixes.contains(prefix);
    SYMBOLS.iter().find(takes).map(|symbol| whole(symbol, ten))
}

/// `text` with its one unknown symbol replaced by the nearest that is known.
pub(super) fn corrected(text: &str) -> Option<String> {
    let text = without_brackets(text.trim());
    let letter = |c: char| c.is_ascii_alphabetic() || matches!(c, '%' | '_');
    let words = text.split(|c: char| !letter(c)).filter(|word| !word.is_empty());
    let mut unknown = words.filter(|word| of_symbol(word).is_none());
    let (word, None) = (unknown.next()?, unknown.next()) else { return None };
    let names = || SYMBOLS.iter().flat_map(|symbol| symbol.names.iter().copied());
    let begun = |name: &&str| word.len() > 2 && name.to_lowercase().starts_with(&word.to_lowercase());
    let near = names().find(begun).or_else(|| nearest(word, names()))?;
    let better = text.replacen(word, near, 1);
    super::unit_named(&better).map(|_| better)
}
