//! Compound units as data sheets write them: `ug/sqrt(Hz)`, `m/s/sqrt(h)`, `N*m*s/rad`, `kg m^2`,
//! `°/√h`.
//!
//! A unit is a decimal power, a quotient of two exact numbers and a power of √π, so that "5 ms" is
//! the double next to 0.005 and not a product of two rounded numbers. Products and quotients
//! associate from the left: `N m/rad/s` is (N m/rad)/s.
//!
//! Angles and cycles have no dimension, but a rad/s is not a Hz: both are remembered, so that a
//! frequency given in rad/s is converted and a rate given in Hz is rejected.

use core::f64::consts::PI;

/// Doubled exponents of kg, m, s, A, K.
pub type Dimension = [i32; 5];

/// A unit in SI: `10^ten · numerator / denominator · √π^root_pi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    pub dimension: Dimension,
    /// Doubled exponents of angle and of cycles.
    pub radian: i32,
    pub hertz: i32,
    numerator: f64,
    denominator: f64,
    ten: i32,
    root_pi: i32,
}

/// What a number without a unit has.
pub const NONE: Unit =
    Unit { dimension: [0; 5], radian: 0, hertz: 0, numerator: 1.0, denominator: 1.0, ten: 0, root_pi: 0 };

const fn unit(dimension: Dimension, numerator: f64, denominator: f64, ten: i32) -> Unit {
    Unit { dimension, radian: 0, hertz: 0, numerator, denominator, ten, root_pi: 0 }
}

/// `numerator / denominator · π` radians.
const fn angle(numerator: f64, denominator: f64) -> Unit {
    Unit { radian: 2, root_pi: 2, ..unit([0; 5], numerator, denominator, 0) }
}

const KILOGRAM: Unit = unit([2, 0, 0, 0, 0], 1.0, 1.0, 0);
const STANDARD_GRAVITY: Unit = unit([0, 2, -4, 0, 0], 980_665.0, 1.0, -5);

/// Symbol, unit, and the prefixes it takes.
static UNITS: &[(&str, Unit, &str)] = &[
    ("kg", KILOGRAM, ""),
    ("m", unit([0, 2, 0, 0, 0], 1.0, 1.0, 0), "nuµμmck"),
    ("s", unit([0, 0, 2, 0, 0], 1.0, 1.0, 0), "nuµμm"),
    ("A", unit([0, 0, 0, 2, 0], 1.0, 1.0, 0), "nuµμmk"),
    ("K", unit([0, 0, 0, 0, 2], 1.0, 1.0, 0), "m"),
    ("min", unit([0, 0, 2, 0, 0], 60.0, 1.0, 0), ""),
    ("h", unit([0, 0, 2, 0, 0], 3600.0, 1.0, 0), ""),
    ("d", unit([0, 0, 2, 0, 0], 86_400.0, 1.0, 0), ""),
    ("Hz", Unit { hertz: 2, ..unit([0, 0, -2, 0, 0], 1.0, 1.0, 0) }, "nuµμmkM"),
    ("rad", Unit { radian: 2, ..NONE }, "nuµμm"),
    ("deg", angle(1.0, 180.0), "m"),
    ("°", angle(1.0, 180.0), ""),
    ("arcmin", angle(1.0, 10_800.0), ""),
    ("arcsec", angle(1.0, 648_000.0), "m"),
    ("rev", angle(2.0, 1.0), ""),
    ("rpm", Unit { dimension: [0, 0, -2, 0, 0], ..angle(2.0, 60.0) }, ""),
    ("N", unit([2, 2, -4, 0, 0], 1.0, 1.0, 0), "nuµμmkM"),
    ("Nm", unit([2, 4, -4, 0, 0], 1.0, 1.0, 0), "nuµμmk"),
    ("lbf", unit([2, 2, -4, 0, 0], 44_482_216_152_605.0, 1.0, -13), ""),
    ("Pa", unit([2, -2, -4, 0, 0], 1.0, 1.0, 0), "nuµμmkMG"),
    ("J", unit([2, 4, -4, 0, 0], 1.0, 1.0, 0), "nuµμmkM"),
    ("W", unit([2, 4, -6, 0, 0], 1.0, 1.0, 0), "nuµμmkM"),
    ("V", unit([2, 4, -6, -2, 0], 1.0, 1.0, 0), "nuµμmk"),
    ("C", unit([0, 0, 2, 2, 0], 1.0, 1.0, 0), "nuµμm"),
    ("ohm", unit([2, 4, -6, -4, 0], 1.0, 1.0, 0), "mkM"),
    ("Ω", unit([2, 4, -6, -4, 0], 1.0, 1.0, 0), "mkM"),
    ("H", unit([2, 4, -4, -4, 0], 1.0, 1.0, 0), "nuµμm"),
    ("T", unit([2, 0, -4, -2, 0], 1.0, 1.0, 0), "nuµμm"),
    ("G", unit([2, 0, -4, -2, 0], 1.0, 1.0, -4), "nuµμm"),
    ("g", STANDARD_GRAVITY, "nuµμm"),
    ("ppm", unit([0; 5], 1.0, 1.0, -6), ""),
    ("ppb", unit([0; 5], 1.0, 1.0, -9), ""),
    ("%", unit([0; 5], 1.0, 1.0, -2), ""),
    ("1", NONE, ""),
];

const fn power_of(prefix: char) -> Option<i32> {
    match prefix {
        'n' => Some(-9),
        'u' | 'µ' | 'μ' => Some(-6),
        'm' => Some(-3),
        'c' => Some(-2),
        'k' => Some(3),
        'M' => Some(6),
        'G' => Some(9),
        _ => None,
    }
}

impl Unit {
    /// `number`, a decimal literal, in SI.
    ///
    /// One rounding where the unit is a whole number times a power of ten, at most four where it
    /// has a quotient or π.
    pub fn to_si(&self, number: &str) -> Option<f64> {
        let (mantissa, exponent) = match number.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (number, 0),
        };
        let (scaled, left) = match whole_product(mantissa, self.numerator) {
            Some(product) => (product, 1.0),
            None => (mantissa.to_owned(), self.numerator),
        };
        let scaled: f64 = format!("{scaled}e{}", exponent.saturating_add(self.ten)).parse().ok()?;
        let mut value = scaled * left / self.denominator;
        for _ in 0..self.root_pi.unsigned_abs() / 2 {
            value = if self.root_pi > 0 { value * PI } else { value / PI };
        }
        if self.root_pi % 2 != 0 {
            value = if self.root_pi > 0 { value * PI.sqrt() } else { value / PI.sqrt() };
        }
        Some(value)
    }

    fn times(self, other: Self, sign: i32) -> Self {
        let (up, down) =
            if sign > 0 { (other.numerator, other.denominator) } else { (other.denominator, other.numerator) };
        let add = |a: i32, b: i32| a.saturating_add(sign.saturating_mul(b));
        Self {
            dimension: core::array::from_fn(|i| add(self.dimension[i], other.dimension[i])),
            radian: add(self.radian, other.radian),
            hertz: add(self.hertz, other.hertz),
            numerator: self.numerator * up,
            denominator: self.denominator * down,
            ten: add(self.ten, other.ten),
            root_pi: add(self.root_pi, other.root_pi),
        }
    }

    /// `self^(half_power / 2)`; `None` where a quarter power would be needed.
    fn powered(self, half_power: i32) -> Option<Self> {
        let whole = half_power / 2;
        let mut result = (0..whole.unsigned_abs()).fold(NONE, |product, _| product.times(self, whole.signum()));
        if half_power % 2 != 0 {
            result = result.times(self.square_root()?, half_power.signum());
        }
        Some(result)
    }

    fn square_root(self) -> Option<Self> {
        let odd = |exponent: &i32| exponent % 2 != 0;
        if self.dimension.iter().any(odd) || odd(&self.radian) || odd(&self.hertz) || odd(&self.root_pi) {
            return None;
        }
        // √(10^odd) would be irrational twice over: one ten goes into the numerator
        let borrowed = self.ten.rem_euclid(2);
        Some(Self {
            dimension: self.dimension.map(|exponent| exponent / 2),
            radian: self.radian / 2,
            hertz: self.hertz / 2,
            numerator: (self.numerator * if borrowed == 1 { 10.0 } else { 1.0 }).sqrt(),
            denominator: self.denominator.sqrt(),
            ten: (self.ten - borrowed) / 2,
            root_pi: self.root_pi / 2,
        })
    }
}

/// The decimal literal times a whole number, exactly; `None` where the factor is not whole or the
/// product too long.
fn whole_product(mantissa: &str, factor: f64) -> Option<String> {
    if factor == 1.0 || factor.fract() != 0.0 || factor.abs() > 9e15 || mantissa.len() > 20 {
        return None;
    }
    let (sign, digits) = match mantissa.strip_prefix('-') {
        Some(digits) => ("-", digits),
        None => ("", mantissa.strip_prefix('+').unwrap_or(mantissa)),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let product = format!("{whole}{fraction}").parse::<u128>().ok()?.checked_mul(factor as u128)?;
    let padded = format!("{product:0>width$}", width = fraction.len() + 1);
    let (whole, fraction) = padded.split_at(padded.len() - fraction.len());
    Some(format!("{sign}{whole}.{fraction}"))
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

/// Parses a unit; empty text is [`NONE`].
///
/// # Errors
/// The symbol or place that cannot be read, with the nearest known symbol.
pub fn parse(text: &str) -> Result<Unit, String> {
    parse_as(text, false)
}

/// As [`parse`], with `g` for gram and not for standard gravity: for where that alone makes sense.
///
/// # Errors
/// As [`parse`].
pub fn parse_with_gram(text: &str) -> Result<Unit, String> {
    parse_as(text, true)
}

fn parse_as(text: &str, gram: bool) -> Result<Unit, String> {
    let mut parser = Parser { rest: text.trim(), depth: 0, gram };
    if parser.rest.is_empty() {
        return Ok(NONE);
    }
    let unit = parser.product()?;
    if parser.rest.is_empty() { Ok(unit) } else { Err(format!("unit '{}' ends at '{}'", text.trim(), parser.rest)) }
}

struct Parser<'a> {
    rest: &'a str,
    depth: u32,
    /// `g` is a gram.
    gram: bool,
}

/// Deepest nesting of brackets: a file must not exhaust the stack.
const DEPTH_MAX: u32 = 8;
/// No quantity has a higher power.
const POWER_MAX: i32 = 12;

impl Parser<'_> {
    fn take(&mut self, symbol: char) -> bool {
        let rest = self.rest.trim_start().strip_prefix(symbol);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn product(&mut self) -> Result<Unit, String> {
        let mut result = self.factor()?;
        loop {
            let sign = if self.take('/') {
                -1
            } else if self.take('*') || self.take('·') || self.take('⋅') || self.a_space_multiplies() {
                1
            } else {
                return Ok(result);
            };
            result = result.times(self.factor()?, sign);
        }
    }

    fn a_space_multiplies(&self) -> bool {
        self.rest.starts_with(' ') && !matches!(self.rest.trim_start().chars().next(), None | Some(')'))
    }

    fn factor(&mut self) -> Result<Unit, String> {
        let base = self.primary()?;
        let half_power = if self.take('^') {
            self.exponent()?
        } else if self.take('²') {
            4
        } else if self.take('³') {
            6
        } else {
            return Ok(base);
        };
        base.powered(half_power).ok_or_else(|| "only whole and half powers of units are known".into())
    }

    /// Twice the exponent: `2`, `-1`, `0.5`, `1.5`, `(1/2)`.
    fn exponent(&mut self) -> Result<i32, String> {
        let bracket = self.take('(');
        let end = self.rest.find(|c: char| !c.is_ascii_digit() && !"+-./".contains(c)).unwrap_or(self.rest.len());
        // a slash belongs to the exponent only inside brackets
        let end = if bracket { end } else { self.rest[..end].find('/').unwrap_or(end) };
        let text = &self.rest[..end];
        let number = match text.split_once('/') {
            Some((above, "2")) => above.parse::<f64>().ok(),
            Some(_) => None,
            None => text.parse::<f64>().ok().map(|whole| 2.0 * whole),
        };
        let halves = number.filter(|n| *n == n.floor() && n.abs() <= f64::from(2 * POWER_MAX));
        let stated = if text.is_empty() { self.rest } else { text };
        let halves = halves.ok_or_else(|| format!("'{stated}' is no whole or half power up to {POWER_MAX}"))?;
        self.rest = &self.rest[end..];
        if bracket && !self.take(')') {
            return Err("an exponent's bracket is not closed".into());
        }
        Ok(halves as i32)
    }

    fn primary(&mut self) -> Result<Unit, String> {
        self.rest = self.rest.trim_start();
        if self.take('(') {
            return self.bracketed();
        }
        if self.take('√') {
            self.deeper()?;
            let inner = self.primary()?;
            self.depth -= 1;
            return root(inner);
        }
        let end = self.rest.find(|c: char| !(c.is_alphabetic() || "°%1".contains(c))).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        if name == "sqrt" && self.take('(') {
            return root(self.bracketed()?);
        }
        let unit = symbol(name).ok_or_else(|| unknown(name))?;
        let gravity = |unit: &Unit| self.gram && unit.numerator == STANDARD_GRAVITY.numerator;
        // the prefix is in the power of ten
        let gram = Unit { ten: unit.ten - STANDARD_GRAVITY.ten - 3, ..KILOGRAM };
        Ok(if gravity(&unit) { gram } else { unit })
    }

    fn bracketed(&mut self) -> Result<Unit, String> {
        self.deeper()?;
        let inner = self.product()?;
        self.depth -= 1;
        if self.take(')') { Ok(inner) } else { Err("a bracket is not closed".into()) }
    }

    fn deeper(&mut self) -> Result<(), String> {
        self.depth += 1;
        if self.depth > DEPTH_MAX { Err(format!("more than {DEPTH_MAX} brackets in one another")) } else { Ok(()) }
    }
}

fn root(inner: Unit) -> Result<Unit, String> {
    inner.square_root().ok_or_else(|| "a root of a root is no unit".into())
}

fn unknown(name: &str) -> String {
    if name.is_empty() {
        return "a symbol is missing in the unit".into();
    }
    let known = UNITS.iter().map(|(symbol, ..)| *symbol);
    let near = dynamics::description::nearest(name, known);
    near.map_or_else(
        || format!("unknown unit '{name}'"),
        |near| format!("unknown unit '{name}'; did you mean '{near}'?"),
    )
}

fn symbol(name: &str) -> Option<Unit> {
    if let Some((_, unit, _)) = UNITS.iter().find(|(symbol, ..)| *symbol == name) {
        return Some(*unit);
    }
    let prefix = name.chars().next()?;
    let power = power_of(prefix)?;
    let base = &name[prefix.len_utf8()..];
    let (_, unit, _) = UNITS.iter().find(|(symbol, _, prefixes)| *symbol == base && prefixes.contains(prefix))?;
    Some(Unit { ten: unit.ten + power, ..*unit })
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
