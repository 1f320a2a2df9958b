//! A unit out of its text: products and quotients of powers and roots of symbols.

use crate::table::{KILOGRAM, STANDARD_GRAVITY, TEMPERATURES, WHOLE, found};
use crate::text::plain;
use crate::unit::{NONE, Unit};

/// Why a text is no unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A symbol that the table does not have.
    Unknown(String),
    /// Signs in a wrong place, as a sentence.
    Malformed(String),
}

/// A unit with the symbols that spell it, by their first names.
#[derive(Clone, Debug, PartialEq)]
pub struct Spelled {
    pub unit: Unit,
    pub symbols: Vec<&'static str>,
}

/// The unit that `text` spells; empty text is [`NONE`].
///
/// # Errors
/// The symbol or place that cannot be read.
pub fn parse(text: &str) -> Result<Unit, Fault> {
    spelled(text).map(|spelled| spelled.unit)
}

/// As [`parse`], with `g` for gram and not for standard gravity: for where that alone makes sense.
///
/// # Errors
/// As [`parse`].
pub fn parse_with_gram(text: &str) -> Result<Unit, Fault> {
    spelled_with_gram(text).map(|spelled| spelled.unit)
}

/// As [`parse`], with the symbols.
///
/// # Errors
/// As [`parse`].
pub fn spelled(text: &str) -> Result<Spelled, Fault> {
    read(text, false)
}

/// As [`parse_with_gram`], with the symbols.
///
/// # Errors
/// As [`parse`].
pub fn spelled_with_gram(text: &str) -> Result<Spelled, Fault> {
    read(text, true)
}

fn read(text: &str, gram: bool) -> Result<Spelled, Fault> {
    let plain = plain(text);
    if plain.is_empty() {
        return Ok(Spelled { unit: NONE, symbols: Vec::new() });
    }
    if let Some((_, unit)) = TEMPERATURES.iter().find(|(names, _)| names.contains(&plain.as_str())) {
        return Ok(Spelled { unit: *unit, symbols: vec!["K"] });
    }
    let whole = WHOLE.iter().find(|(names, _)| names.contains(&plain.as_str()));
    let mut parser = Parser { rest: whole.map_or(plain.as_str(), |(_, meant)| meant), depth: 0, gram, symbols: vec![] };
    let unit = parser.product()?;
    if !parser.rest.is_empty() {
        return Err(Fault::Malformed(format!("unit '{}' ends at '{}'", text.trim(), parser.rest)));
    }
    Ok(Spelled { unit, symbols: parser.symbols })
}

struct Parser<'a> {
    rest: &'a str,
    depth: u32,
    /// `g` is a gram.
    gram: bool,
    symbols: Vec<&'static str>,
}

/// Deepest nesting of brackets: a file must not exhaust the stack.
const DEPTH_MAX: u32 = 4;
/// No quantity has a higher power.
const POWER_MAX: i32 = 12;

impl Parser<'_> {
    fn take(&mut self, symbol: char) -> bool {
        let rest = self.rest.strip_prefix(symbol);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn product(&mut self) -> Result<Unit, Fault> {
        let mut result = self.factor()?;
        loop {
            let sign = if self.take('/') {
                -1
            } else if self.take('*') {
                1
            } else {
                return Ok(result);
            };
            result = result.times(self.factor()?, sign);
        }
    }

    fn factor(&mut self) -> Result<Unit, Fault> {
        let is_one = self.rest.starts_with('1');
        let base = self.primary()?;
        let signed = self.rest.strip_prefix(['-', '+']).unwrap_or(self.rest);
        let half_power = if self.take('^') {
            self.exponent()?
        } else if signed.starts_with(|c: char| c.is_ascii_digit()) && !is_one {
            self.whole_exponent()?
        } else {
            return Ok(base);
        };
        base.powered(half_power).ok_or_else(|| Fault::Malformed("only whole and half powers of units are known".into()))
    }

    /// Twice the exponent: `2`, `-1`, `0.5`, `1.5`, `(1/2)`.
    fn exponent(&mut self) -> Result<i32, Fault> {
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
        let stated = if text.is_empty() { self.rest } else { text };
        let halves = bounded(number, stated)?;
        self.rest = &self.rest[end..];
        if bracket && !self.take(')') {
            return Err(Fault::Malformed("an exponent's bracket is not closed".into()));
        }
        Ok(halves)
    }

    /// Twice the exponent that stands behind a symbol without a sign: `m2`, `s-2`.
    fn whole_exponent(&mut self) -> Result<i32, Fault> {
        let sign = usize::from(self.rest.starts_with(['-', '+']));
        let digits = self.rest[sign..].bytes().take_while(u8::is_ascii_digit).count();
        let text = &self.rest[..sign + digits];
        let halves = bounded(text.parse::<f64>().ok().map(|whole| 2.0 * whole), text)?;
        self.rest = &self.rest[sign + digits..];
        Ok(halves)
    }

    fn primary(&mut self) -> Result<Unit, Fault> {
        if self.take('(') {
            return self.bracketed();
        }
        if self.take('√') {
            self.deeper()?;
            let inner = self.primary()?;
            self.depth -= 1;
            return root(inner);
        }
        let letter = |c: char| c.is_alphabetic() || matches!(c, '%' | '_');
        let end = self.rest.find(|c| !letter(c)).unwrap_or(self.rest.len());
        let end = if end == 0 && (self.rest.starts_with('1') || self.rest == "-") { 1 } else { end };
        // `g0` is the one symbol with a digit
        let end = if &self.rest[..end] == "g" && self.rest[end..].starts_with('0') { end + 1 } else { end };
        let (name, rest) = self.rest.split_at(end);
        self.rest = rest;
        if name == "sqrt" && self.take('(') {
            return root(self.bracketed()?);
        }
        if name.is_empty() {
            let place = if rest.is_empty() { String::new() } else { format!(" at '{rest}'") };
            return Err(Fault::Malformed(format!("a symbol is missing in the unit{place}")));
        }
        let (symbol, ten) = found(name).ok_or_else(|| Fault::Unknown(name.to_owned()))?;
        self.symbols.push(symbol.names[0]);
        // the prefix is in the power of ten
        let is_gram = self.gram && symbol.unit == STANDARD_GRAVITY;
        Ok(if is_gram { KILOGRAM.prefixed(ten - 3) } else { symbol.unit.prefixed(ten) })
    }

    fn bracketed(&mut self) -> Result<Unit, Fault> {
        self.deeper()?;
        let inner = self.product()?;
        self.depth -= 1;
        if self.take(')') { Ok(inner) } else { Err(Fault::Malformed("a bracket is not closed".into())) }
    }

    fn deeper(&mut self) -> Result<(), Fault> {
        self.depth += 1;
        if self.depth <= DEPTH_MAX {
            return Ok(());
        }
        Err(Fault::Malformed(format!("more than {DEPTH_MAX} brackets in one another")))
    }
}

/// Twice an exponent, where it is a whole number within bounds.
fn bounded(halves: Option<f64>, stated: &str) -> Result<i32, Fault> {
    let halves = halves.filter(|n| *n == n.floor() && n.abs() <= f64::from(2 * POWER_MAX));
    let halves =
        halves.ok_or_else(|| Fault::Malformed(format!("'{stated}' is no whole or half power up to {POWER_MAX}")))?;
    Ok(halves as i32)
}

fn root(inner: Unit) -> Result<Unit, Fault> {
    inner.square_root().ok_or_else(|| Fault::Malformed("a root of a root is no unit".into()))
}
