//! One function at a node: the header and the numbers of dataset 58 or 58b.
//!
//! Record 6 says what the function is and at which nodes, record 7 how its numbers are laid out,
//! records 8 to 11 what they are of; then come `n` values (pairs with the abscissa where its
//! spacing is uneven).

use crate::error::RecordingError;
use crate::function_kind::FunctionKind;
use crate::uff_kind::{OrdinateUnit, kind_of};
use crate::uff_lines::{Text, cut, number, shortened};
use crate::uff_numbers::{Binary, Layout, columns, from_bytes, from_text};

pub(crate) const EXPORT: &str = "export the function again as dataset 58 (double precision keeps the digits)";

/// What the abscissa counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    Time,
    Frequency,
}

/// What an axis measures.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quantity {
    /// Specific data type: 8 displacement, 11 velocity, 12 acceleration, 9 and 13 force, 17 time,
    /// 18 frequency, …
    kind: i64,
    /// Label of the unit.
    unit: String,
}

impl Quantity {
    /// The unit's label, where there is one, in the spelling of the table of units.
    pub fn label(&self) -> Option<&str> {
        (!self.unit.is_empty() && !self.unit.eq_ignore_ascii_case("none")).then_some(self.unit.as_str())
    }

    /// SI unit of the kind of quantity.
    pub fn si(&self) -> Option<&'static str> {
        match self.kind {
            8 => Some("m"),
            11 => Some("m/s"),
            12 => Some("m/s^2"),
            9 | 13 => Some("N"),
            // Whatever the label says.
            _ => self.label().map(|_| "-"),
        }
    }
}

/// A function at a node.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    /// Line of the dataset's number.
    pub line: u64,
    pub domain: Domain,
    pub kind: FunctionKind,
    response: (i64, i64),
    reference: (i64, i64),
    pub ordinate: Quantity,
    /// Of a response to something.
    pub denominator: Option<Quantity>,
    /// Time [s] or frequency [Hz].
    pub abscissa: Vec<f64>,
    pub real: Vec<f64>,
    pub imaginary: Option<Vec<f64>>,
}

impl Function {
    /// Quantity, node and direction of the response, and of the reference of a response to
    /// something.
    pub fn name(&self) -> String {
        let force = |quantity: &Quantity| matches!(quantity.kind, 9 | 13);
        let by_force = self.denominator.as_ref().map(force);
        let what = match (self.ordinate.kind, by_force) {
            (8, None) => "displacement",
            (11, None) => "velocity",
            (12, None) => "acceleration",
            (9 | 13, None) => "force",
            (8, Some(true)) => "receptance",
            (11, Some(true)) => "mobility",
            (12, Some(true)) => "accelerance",
            _ => "response",
        };
        let of = |(node, direction): (i64, i64)| format!("{node}{}", direction_name(direction));
        match &self.denominator {
            None => format!("{what}_{}", of(self.response)),
            Some(_) => format!("{what}_{}_{}", of(self.response), of(self.reference)),
        }
    }

    /// Unit of the ordinate as the file words it, over that of the denominator where there is one;
    /// `-` where the file names none.
    pub fn unit_in_words(&self) -> String {
        let word = |quantity: &Quantity| quantity.label().unwrap_or("-").to_string();
        match &self.denominator {
            None => word(&self.ordinate),
            Some(denominator) => format!("{}/{}", word(&self.ordinate), word(denominator)),
        }
    }
}

fn direction_name(direction: i64) -> String {
    let sign = if direction < 0 { "-" } else { "" };
    let axis = match direction.abs() {
        1 => "x",
        2 => "y",
        3 => "z",
        4 => "rx",
        5 => "ry",
        6 => "rz",
        _ => "",
    };
    format!("{sign}{axis}")
}

pub(crate) fn read_function(text: &mut Text<'_>, number_line: &str) -> Result<Function, RecordingError> {
    let line = text.line;
    let binary = if number_line.trim_start().starts_with("58b") { Some(binary(text, number_line)?) } else { None };
    for _ in 0..5 {
        text.needed_line()?; // what people wrote about it
    }
    let (kind, response, reference) = record_6(text)?;
    let layout = record_7(text)?;
    let abscissa = quantity(&text.needed_line()?);
    let ordinate = quantity(&text.needed_line()?);
    let denominator = quantity(&text.needed_line()?);
    text.needed_line()?; // z axis
    let domain = match (abscissa.kind, kind) {
        // 7, 8: correlations, over lag
        (17, _) | (0 | 1, 0 | 1 | 7 | 8) => Domain::Time,
        (18, _) | (0 | 1, _) => Domain::Frequency,
        (other, _) => {
            let found = format!("the abscissa is neither time (17) nor frequency (18) but of kind {other}");
            return Err(text.error(found, "export functions of time or frequency"));
        }
    };
    let values = match binary {
        Some(binary) => from_bytes(text, &layout, &binary)?,
        None => from_text(text, &layout)?,
    };
    let (x, real, imaginary) = columns(&layout, &values);
    // By what a response is divided, where that is said: a force, or a base that moves.
    let denominator = (denominator.kind > 1 || denominator.label().is_some()).then_some(denominator);
    let kind = kind_of(kind, domain, ordinate.label(), denominator.is_some());
    // Of a spectrum of an output the magnitude is given: in the unit of the quantity itself.
    let (ordinate, denominator) = if kind.is_of_output() {
        let quantity = ordinate.label().map(|label| OrdinateUnit::of(label).quantity).unwrap_or_default();
        (Quantity { unit: quantity, ..ordinate }, None)
    } else {
        (ordinate, denominator)
    };
    Ok(Function { line, domain, kind, response, reference, ordinate, denominator, abscissa: x, real, imaginary })
}

fn binary(text: &Text<'_>, line: &str) -> Result<Binary, RecordingError> {
    let words: Vec<&str> = line.trim_start()["58b".len()..].split_whitespace().collect();
    let field = |k: usize| words.get(k).and_then(|word| word.parse::<usize>().ok());
    let (Some(order), Some(format), Some(bytes)) = (field(0), field(1), field(3)) else {
        return Err(text.error(format!("`{}` is no head of a binary dataset", shortened(line.trim())), EXPORT));
    };
    if format != 2 || !(1..=2).contains(&order) {
        let found =
            format!("floating point format {format}, byte order {order}; read are IEEE 754 (2) and the orders 1 and 2");
        return Err(text.error(found, EXPORT));
    }
    Ok(Binary { little_endian: order == 1, bytes })
}

type Node = (i64, i64);

fn record_6(text: &mut Text<'_>) -> Result<(i64, Node, Node), RecordingError> {
    let line = text.needed_line()?;
    let fields = [(0, 5), (41, 51), (51, 55), (66, 76), (76, 80)].map(|(from, to)| integer(cut(&line, from, to)));
    // Some write words with blanks between instead of columns.
    let words: Vec<&str> = line.split_whitespace().collect();
    let worded = [0, 5, 6, 8, 9].map(|k| words.get(k).and_then(|word| integer(word)));
    let all = |found: [Option<i64>; 5]| found.into_iter().collect::<Option<Vec<i64>>>();
    let Some(found) = all(fields).or_else(|| all(worded)) else {
        return Err(text.error(format!("`{}` does not name function, nodes and directions", shortened(&line)), EXPORT));
    };
    Ok((found[0], (found[1], found[2]), (found[3], found[4])))
}

/// An integer; an empty field counts as 0.
fn integer(text: &str) -> Option<i64> {
    if text.is_empty() { Some(0) } else { text.parse().ok() }
}

fn record_7(text: &mut Text<'_>) -> Result<Layout, RecordingError> {
    let line = text.needed_line()?;
    let wrong = |text: &Text<'_>| {
        let found = format!("`{}` does not say how the numbers are laid out", shortened(&line));
        text.error(found, EXPORT)
    };
    let [kind, values, spacing] =
        [(0, 10), (10, 20), (20, 30)].map(|(from, to)| cut(&line, from, to).parse::<i64>().ok());
    let [first, step] = [(30, 43), (43, 56)].map(|(from, to)| number(cut(&line, from, to)));
    let (kind, values, spacing, first, step) = match (kind, values, spacing, first, step) {
        (Some(kind), Some(values), Some(spacing), Some(first), Some(step)) => (kind, values, spacing, first, step),
        _ => {
            let words: Option<Vec<f64>> = line.split_whitespace().map(number).collect();
            let words = words.filter(|words| words.len() >= 5).ok_or_else(|| wrong(text))?;
            (words[0] as i64, words[1] as i64, words[2] as i64, words[3], words[4])
        }
    };
    let (double, complex) = match kind {
        2 => (false, false),
        4 => (true, false),
        5 => (false, true),
        6 => (true, true),
        _ => return Err(wrong(text)),
    };
    let even = spacing == 1;
    let values = usize::try_from(values).ok().filter(|values| *values >= 2).ok_or_else(|| wrong(text))?;
    if values > text.left() {
        // every value takes a byte at least
        return Err(text.error(format!("{values} values are announced, more than the file has bytes"), EXPORT));
    }
    if even && !(step > 0.0 && first.is_finite()) {
        return Err(text.error(format!("the abscissa begins at {first} and grows by {step}"), EXPORT));
    }
    Ok(Layout { complex, double, values, even, first, step })
}

fn quantity(line: &str) -> Quantity {
    let kind = integer(cut(line, 0, 10)).unwrap_or(0);
    Quantity { kind, unit: cut(line, 47, 67).replace("**", "^") }
}
