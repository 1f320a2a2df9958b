//! Numbers with units, priors and scopes; lists of them; directions.

use super::section::{Finding, Node};
use super::units::{self, Unit};
use core::ops::Range;
use dynamics::description::{Quantity, Scope, suggestion};
use toml::de::{DeTable, DeValue};

/// What is to be read.
pub(super) struct Expected<'a> {
    /// As in "mass of body 'hub'".
    pub what: String,
    /// SI.
    pub unit: &'a str,
}

impl Expected<'_> {
    fn unit(&self) -> Unit {
        units::parse(self.unit).expect("units that the reader asks for are written in this crate")
    }

    fn bare(&self) -> bool {
        let unit = self.unit();
        unit.dimension == [0; 5] && unit.radian == 0
    }
}

fn finding(span: Range<usize>, message: String, cure: impl Into<String>) -> Finding {
    Finding { span, message, cure: cure.into() }
}

/// A place that is to be filled in: `"?"` or `"? kg"`, in the number itself or in what it consists
/// of, once however many there are.
fn not_filled_in(node: &Node<'_>, expected: &Expected<'_>) -> Option<Finding> {
    let at = blank(node)?;
    let unit = expected.unit;
    let cure = format!(
        "give value and standard deviation, as in {{ value = \"1 {unit}\", sigma = \"0.1 {unit}\" }}; a number alone is exact"
    );
    Some(finding(at, format!("{} is not filled in", expected.what), cure))
}

fn blank(node: &Node<'_>) -> Option<Range<usize>> {
    match node.get_ref() {
        DeValue::String(text) if text.trim_start().starts_with('?') => Some(node.span()),
        DeValue::Array(nodes) => nodes.iter().find_map(blank),
        DeValue::Table(table) => table.values().filter_map(blank).min_by_key(|span| span.start),
        _ => None,
    }
}

/// A number: `"3 kg"`, a bare one where there is no dimension, or `{ value, sigma, scope }`.
///
/// # Errors
/// Everything that is wrong with it.
pub(super) fn quantity(node: &Node<'_>, expected: &Expected<'_>) -> Result<Quantity, Vec<Finding>> {
    if let Some(finding) = not_filled_in(node, expected) {
        return Err(vec![finding]);
    }
    let DeValue::Table(table) = node.get_ref() else {
        return scalar(node, expected).map(Quantity::known).map_err(|finding| vec![finding]);
    };
    let mut findings = unknown_keys(table, expected);
    let value = required_value(table, node, expected).and_then(|node| scalar(node, expected));
    let prior = prior(table, expected);
    let value = value.map_err(|finding| findings.push(finding)).ok();
    let prior = prior.map_err(|finding| findings.push(finding)).ok();
    match (value, prior) {
        (Some(value), Some((mut sigmas, scope))) if findings.is_empty() => {
            let sigma = sigmas.pop().map(|sigma| sigma.resolve(value)).transpose();
            let sigma = sigma.map_err(|message| vec![finding(node.span(), message, ABSOLUTE)])?;
            Ok(Quantity { value, sigma, scope })
        }
        _ => Err(findings),
    }
}

/// A list of numbers; a single number is a list of one. `{ value = […], sigma = …, scope }` gives
/// all of them a prior: one sigma for all, or a list; `{ unit, values = [1, 2, 3] }` a unit.
///
/// # Errors
/// Everything that is wrong with it.
pub(super) fn list(node: &Node<'_>, expected: &Expected<'_>) -> Result<Vec<Quantity>, Vec<Finding>> {
    if let Some(finding) = not_filled_in(node, expected) {
        return Err(vec![finding]);
    }
    match node.get_ref() {
        DeValue::Array(nodes) => {
            let read: Vec<_> = nodes.iter().map(|node| quantity(node, expected)).collect();
            let findings: Vec<Finding> = read.iter().filter_map(|r| r.as_ref().err()).flatten().cloned().collect();
            if findings.is_empty() { Ok(read.into_iter().filter_map(Result::ok).collect()) } else { Err(findings) }
        }
        DeValue::Table(table) if table.contains_key("values") => values_in_one_unit(table, node, expected),
        DeValue::Table(table) if table.get("value").is_some_and(|value| value.get_ref().is_array()) => {
            let mut findings = unknown_keys(table, expected);
            let values = required_value(table, node, expected).map_err(|finding| vec![finding]);
            let values = values.and_then(|node| list(node, expected));
            let prior = prior(table, expected).map_err(|finding| findings.push(finding)).ok();
            match (values, prior) {
                (Ok(values), Some(prior)) if findings.is_empty() => with_prior(values, &prior, node, expected),
                (Err(more), _) => Err([findings, more].concat()),
                _ => Err(findings),
            }
        }
        _ => quantity(node, expected).map(|quantity| vec![quantity]),
    }
}

fn with_prior(
    values: Vec<Quantity>,
    (sigmas, scope): &(Vec<Sigma>, Scope),
    node: &Node<'_>,
    expected: &Expected<'_>,
) -> Result<Vec<Quantity>, Vec<Finding>> {
    if sigmas.len() > 1 && sigmas.len() != values.len() {
        let message = format!("{} has {} numbers and {} sigmas", expected.what, values.len(), sigmas.len());
        return Err(vec![finding(node.span(), message, "give one sigma for all, or one for each")]);
    }
    let all_zero = values.iter().all(|quantity| quantity.value == 0.0);
    let mut list = Vec::with_capacity(values.len());
    for (i, quantity) in values.into_iter().enumerate() {
        let sigma = match &sigmas[..] {
            // a share of zero is nothing: components that are zero are known
            [Sigma::Relative(_)] if quantity.value == 0.0 && !all_zero => None,
            [one] => Some(one),
            each => each.get(i),
        };
        let sigma = sigma.map(|sigma| sigma.resolve(quantity.value)).transpose();
        let sigma = sigma.map_err(|message| vec![finding(node.span(), message, ABSOLUTE)])?;
        list.push(Quantity { sigma, scope: *scope, ..quantity });
    }
    Ok(list)
}

fn values_in_one_unit(
    table: &DeTable<'_>,
    node: &Node<'_>,
    expected: &Expected<'_>,
) -> Result<Vec<Quantity>, Vec<Finding>> {
    let one = |span, message: String, cure: &str| Err(vec![finding(span, message, cure)]);
    let unit = table.get("unit").and_then(|unit| unit.get_ref().as_str()).unwrap_or("");
    let Some(DeValue::Array(nodes)) = table.get("values").map(|values| values.get_ref()) else {
        return one(
            node.span(),
            format!("values of {} are not a list", expected.what),
            "as in { unit = \"s\", values = [0, 1] }",
        );
    };
    if let Some(key) = table.keys().find(|key| !["unit", "values"].contains(&key.get_ref().as_ref())) {
        return one(
            key.span(),
            format!("{} has no key '{}'", expected.what, key.get_ref()),
            "known keys: unit, values",
        );
    }
    let mut list = Vec::with_capacity(nodes.len());
    for node in nodes.iter() {
        let text = match node.get_ref() {
            DeValue::Integer(number) => plain(number.as_str()),
            DeValue::Float(number) => plain(number.as_str()),
            _ => {
                return one(
                    node.span(),
                    format!("values of {} are plain numbers", expected.what),
                    "their unit stands in 'unit'",
                );
            }
        };
        let value =
            in_si(&text, unit, expected).map_err(|(message, cure)| vec![finding(node.span(), message, cure)])?;
        list.push(Quantity::known(value));
    }
    Ok(list)
}

fn unknown_keys(table: &DeTable<'_>, expected: &Expected<'_>) -> Vec<Finding> {
    let known = ["value", "sigma", "scope"];
    let unknown = table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
    let report = |key: &toml::Spanned<toml::de::DeString<'_>>| {
        let name = key.get_ref();
        finding(key.span(), format!("{} has no key '{name}'", expected.what), suggestion(name, "keys", known))
    };
    unknown.map(report).collect()
}

fn required_value<'d>(
    table: &'d DeTable<'d>,
    node: &Node<'_>,
    expected: &Expected<'_>,
) -> Result<&'d Node<'d>, Finding> {
    let cure = || format!("as in {{ value = \"1 {0}\", sigma = \"0.1 {0}\" }}", expected.unit);
    table.get("value").ok_or_else(|| finding(node.span(), format!("{} has no 'value'", expected.what), cure()))
}

/// A standard deviation, perhaps relative.
#[derive(Clone, Copy)]
enum Sigma {
    Absolute(f64),
    Relative(f64),
}

const ABSOLUTE: &str = "give an absolute sigma, with the unit of the value";

impl Sigma {
    /// # Errors
    /// A share of zero.
    fn resolve(self, value: f64) -> Result<f64, String> {
        match self {
            Self::Relative(share) if value == 0.0 => Err(format!("{} % of 0 is 0", share * 100.0)),
            Self::Relative(share) => Ok(share * value.abs()),
            Self::Absolute(sigma) => Ok(sigma),
        }
    }
}

fn prior(table: &DeTable<'_>, expected: &Expected<'_>) -> Result<(Vec<Sigma>, Scope), Finding> {
    let sigma = |node: &Node<'_>| {
        let relative = node.get_ref().as_str().and_then(|text| text.trim().strip_suffix('%'));
        if let (Some(number), false) = (relative, expected.bare()) {
            let share = number.trim().parse::<f64>().ok().filter(|share| share.is_finite());
            let message = || format!("sigma of {}: '{number}' is not a number", expected.what);
            return share
                .map(|share| Sigma::Relative(share / 100.0))
                .ok_or_else(|| finding(node.span(), message(), ""));
        }
        let expected = Expected { what: format!("sigma of {}", expected.what), unit: expected.unit };
        scalar(node, &expected).map(Sigma::Absolute)
    };
    let sigmas = match table.get("sigma") {
        None => Vec::new(),
        Some(node) => match node.get_ref() {
            DeValue::Array(list) => list.iter().map(sigma).collect::<Result<_, _>>()?,
            _ => vec![sigma(node)?],
        },
    };
    Ok((sigmas, scope(table, expected)?))
}

pub(super) const SCOPES: [(&str, Scope); 3] =
    [("shared", Scope::Shared), ("per recording", Scope::PerRecording), ("per segment", Scope::PerSegment)];

fn scope(table: &DeTable<'_>, expected: &Expected<'_>) -> Result<Scope, Finding> {
    let Some(node) = table.get("scope") else { return Ok(Scope::Shared) };
    let text = node.get_ref().as_str().unwrap_or("");
    let known = SCOPES.iter().find(|(word, _)| *word == text).map(|(_, scope)| *scope);
    known.ok_or_else(|| {
        let message = format!("scope of {} is '{text}', which is unknown", expected.what);
        finding(node.span(), message, suggestion(text, "scopes", SCOPES.iter().map(|(word, _)| *word)))
    })
}

/// One number in SI.
fn scalar(node: &Node<'_>, expected: &Expected<'_>) -> Result<f64, Finding> {
    let read = match node.get_ref() {
        DeValue::String(text) => with_unit(text, expected),
        DeValue::Integer(number) => bare(&plain(number.as_str()), expected),
        DeValue::Float(number) => bare(&plain(number.as_str()), expected),
        _ => {
            let message = format!("{} is not a number with unit", expected.what);
            Err((message, format!("as in \"1 {}\"", expected.unit)))
        }
    };
    read.map_err(|(message, cure)| finding(node.span(), message, cure))
}

fn plain(number: &str) -> String {
    number.replace('_', "")
}

/// A number without quotes: possible where there is no dimension, and for zero, which has any unit.
fn bare(text: &str, expected: &Expected<'_>) -> Result<f64, (String, String)> {
    let value: f64 =
        text.parse().map_err(|_| (format!("{}: '{text}' is not a decimal number", expected.what), String::new()))?;
    if !value.is_finite() {
        return Err((format!("{} is not a finite number: {text}", expected.what), String::new()));
    }
    if value == 0.0 || expected.bare() {
        return Ok(value);
    }
    Err((format!("{} has no unit: {text}", expected.what), format!("as in \"{text} {}\"", expected.unit)))
}

/// Reads `text` as a number with a unit of the expected dimension.
fn with_unit(text: &str, expected: &Expected<'_>) -> Result<f64, (String, String)> {
    let Some((number, unit)) = units::split(text) else {
        let message = format!("{}: '{text}' does not begin with a number", expected.what);
        let cure = units::likely_cure(text).unwrap_or_else(|| format!("as in \"1 {}\"", expected.unit));
        return Err((message, cure));
    };
    if unit.is_empty() {
        return bare(number, expected);
    }
    in_si(number, unit, expected)
}

/// `number` in `unit` as what is expected, SI.
pub(super) fn in_si(number: &str, unit: &str, expected: &Expected<'_>) -> Result<f64, (String, String)> {
    let wanted = expected.unit();
    let given = units::parse(unit).map_err(|why| {
        let text = if unit.starts_with(',') { format!("{number}{unit}") } else { format!("{number} {unit}") };
        let cure =
            units::likely_cure(&text).unwrap_or_else(|| format!("{} is in {}", expected.what, or_plain(expected.unit)));
        (format!("{}: {why}", expected.what), cure)
    })?;
    let gram = units::parse_with_gram(unit).ok().filter(|gram| gram.dimension == wanted.dimension);
    let given = if given.dimension == wanted.dimension { given } else { gram.unwrap_or(given) };
    let rate_in_hertz = wanted.radian != 0 && given.hertz != 0 && wanted.hertz == 0 && wanted.dimension[2] == -2;
    // an angle is no plain number, but 1/s, rad/s and Hz differ only by what is counted
    let angle_for_number = wanted.dimension == [0; 5] && (given.radian != 0) != (wanted.radian != 0);
    if given.dimension != wanted.dimension || angle_for_number {
        let text = format!("{number} {unit}");
        let (is, wants) = (units::called(&given), or_plain(expected.unit));
        return Err((format!("'{text}' is {is}; {} is in {wants}", expected.what), String::new()));
    }
    if rate_in_hertz && wanted.dimension == given.dimension && given.radian == 0 {
        let message = format!("'{number} {unit}' counts cycles; {} is in {}", expected.what, expected.unit);
        return Err((message, format!("1 Hz is \"{} rad/s\"", core::f64::consts::TAU)));
    }
    let value = given.to_si(number).filter(|value| value.is_finite());
    let value =
        value.ok_or_else(|| (format!("{} is not a finite number: {number} {unit}", expected.what), String::new()))?;
    let cycles_from_angle = wanted.hertz == 2 && given.radian == 2 && given.hertz == 0;
    Ok(if cycles_from_angle { value / core::f64::consts::TAU } else { value })
}

fn or_plain(unit: &str) -> &str {
    if unit == "1" { "plain numbers" } else { unit }
}

/// A direction: `"x"`, `"-z"`, or two or three numbers that are not all zero; of length one where
/// it is returned.
///
/// # Errors
/// Message (to follow "axis of body 'hub'") and cure.
pub(super) fn direction(node: &Node<'_>, planar: bool) -> Result<[f64; 3], (String, String)> {
    let example = "as in \"x\", \"-y\" or [0.6, 0.8, 0]";
    let numbers = match node.get_ref() {
        DeValue::String(text) if text.starts_with('?') => return Err(("is not filled in".into(), example.into())),
        DeValue::String(text) => {
            return named_direction(text).ok_or_else(|| (format!("is '{text}', no direction"), example.into()));
        }
        DeValue::Array(list) => list,
        _ => return Err(("is no direction".into(), example.into())),
    };
    let mut axis = [0.0; 3];
    if numbers.len() != 3 && !(planar && numbers.len() == 2) {
        let wanted = if planar { "2 or 3" } else { "3" };
        return Err((format!("has {} numbers, not {wanted}", numbers.len()), example.into()));
    }
    for (component, node) in axis.iter_mut().zip(numbers.iter()) {
        let text = match node.get_ref() {
            DeValue::Integer(number) => plain(number.as_str()),
            DeValue::Float(number) => plain(number.as_str()),
            _ => return Err(("has a component that is no plain number".into(), example.into())),
        };
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite() && value.abs() < 1e100);
        *component = value.ok_or_else(|| (format!("has the component {text}"), example.to_owned()))?;
    }
    let square: f64 = axis.iter().map(|a| a * a).sum();
    if square == 0.0 {
        return Err(("is zero and points nowhere".into(), example.into()));
    }
    // what is a unit vector already keeps its bits: the sum of three squares is rounded to 4 ε at
    // most
    if (square - 1.0).abs() <= 8.0 * f64::EPSILON {
        return Ok(axis);
    }
    Ok(axis.map(|a| a / square.sqrt()))
}

fn named_direction(text: &str) -> Option<[f64; 3]> {
    let (sign, letter) = match text.strip_prefix('-') {
        Some(letter) => (-1.0, letter),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let index = ["x", "y", "z"].iter().position(|axis| *axis == letter)?;
    let mut axis = [0.0; 3];
    axis[index] = sign;
    Some(axis)
}

/// The unit of a number with unit, where it can be read: tells a density from a standard deviation.
pub(super) fn unit_of(node: &Node<'_>) -> Option<Unit> {
    let value = match node.get_ref() {
        DeValue::Table(table) => table.get("value")?.get_ref().as_str()?,
        other => other.as_str()?,
    };
    units::parse(units::split(value)?.1).ok()
}
