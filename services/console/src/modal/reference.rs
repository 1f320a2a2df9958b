//! The modes against those of another answer: MAC matrix and pairs (`--reference`).

use super::degree_of_freedom::of_response;
use super::{FoundMode, Outcome};
use crate::Failure;
use crate::plants::utf8_text;
use modal::c64;
use modal::mode_sets::{Comparison, ModeSet, SetMode, compare};
use recording::UffModel;
use serde::Deserialize;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Cure of a file that holds no modes.
const CURE: &str = "give what `obsid modal … --json` wrote, or a universal file with mode shapes (dataset 55)";
/// Names in a message at most.
const NAMED_MAX: usize = 6;

/// The comparison with a reference.
pub(super) struct Compared {
    pub file: String,
    pub reference: ModeSet,
    pub comparison: Comparison,
}

/// What is read of an answer of `obsid modal --json`.
#[derive(Deserialize)]
struct Answer {
    channels: Vec<String>,
    modes: Vec<AnswerMode>,
}

#[derive(Deserialize)]
struct AnswerMode {
    frequency_hz: f64,
    damping: Option<f64>,
    shape: Vec<Component>,
}

#[derive(Deserialize)]
struct Component {
    re: f64,
    im: f64,
}

/// # Errors
/// [`Failure::Input`] where the file holds no modes with shapes over a channel of this answer.
pub(super) fn compared(file: &Path, outcome: &Outcome) -> Result<Compared, Failure> {
    let name = file.display().to_string();
    let wrong = |what: String, cure: &str| Failure::Input(miette::miette!(help = cure.to_string(), "{name}: {what}"));
    let text = utf8_text(file).map_err(|(message, _)| Failure::Input(miette::miette!(help = CURE, "{message}")))?;
    let (reference, of_nodes) = if text.trim_start().starts_with("-1") {
        (of_model(&recording::read_model(file).map_err(Failure::input)?), true)
    } else {
        let answer: Answer = serde_json::from_str(&text).map_err(|error| wrong(error.to_string(), CURE))?;
        (of_answer(answer).map_err(|what| wrong(what, CURE))?, false)
    };
    if !reference.modes.iter().any(|mode| !mode.shape.is_empty()) {
        return Err(wrong("no mode with a shape".into(), CURE));
    }
    let comparison = compare(&own(outcome, of_nodes), &reference);
    if comparison.common.is_empty() {
        let [rows, columns] = &comparison.unpaired;
        let what = format!("no channel in common: here {}, there {}", some(rows), some(columns));
        return Err(wrong(
            what,
            "channels are paired by name: rename with --channel 'OWN = THEIRS', both answers alike",
        ));
    }
    Ok(Compared { file: name, reference, comparison })
}

/// The modes of this answer; over nodes and directions, where the reference has these.
fn own(outcome: &Outcome, of_nodes: bool) -> ModeSet {
    let geometry = outcome.structure.geometry.as_ref();
    let freedom = |k: usize| {
        let placed = geometry.and_then(|geometry| geometry.freedom(k));
        placed.or_else(|| of_response(&outcome.channels[k])).filter(|_| of_nodes)
    };
    let freedoms: Vec<_> = (0..outcome.channels.len()).map(freedom).collect();
    let sign = |k: usize| if freedoms[k].is_some_and(|f| f.negative) { -1.0 } else { 1.0 };
    let mode = |mode: &FoundMode| SetMode {
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping,
        shape: mode.shape.iter().enumerate().map(|(k, psi)| *psi * sign(k)).collect(),
    };
    let name = |(k, name): (usize, &String)| freedoms[k].map_or(name.clone(), |f| f.name());
    ModeSet {
        channels: outcome.channels.iter().enumerate().map(name).collect(),
        modes: outcome.modes.iter().map(mode).collect(),
    }
}

fn of_answer(answer: Answer) -> Result<ModeSet, String> {
    let (channels, count) = (answer.channels.clone(), answer.channels.len());
    let modes = answer.modes.into_iter().enumerate().map(|(k, mode)| {
        if ![0, count].contains(&mode.shape.len()) {
            return Err(format!("mode {} has {} components, {count} channels are named", k + 1, mode.shape.len()));
        }
        let good = mode.frequency_hz > 0.0 && mode.frequency_hz.is_finite();
        if !good {
            return Err(format!("mode {} is at {} Hz", k + 1, mode.frequency_hz));
        }
        let shape = mode.shape.iter().map(|psi| c64::new(psi.re, psi.im)).collect();
        Ok(SetMode { frequency_hz: mode.frequency_hz, damping_ratio: mode.damping, shape })
    });
    Ok(ModeSet { channels, modes: modes.collect::<Result<_, _>>()? })
}

/// Every translation of every node that some mode moves.
fn of_model(model: &UffModel) -> ModeSet {
    let mut freedoms: Vec<(i64, usize)> = Vec::new();
    for node in model.modes.iter().flat_map(|mode| &mode.shape) {
        for (axis, part) in node.components.iter().take(3).enumerate() {
            if *part != [0.0, 0.0] && !freedoms.contains(&(node.node, axis)) {
                freedoms.push((node.node, axis));
            }
        }
    }
    let modes = model.modes.iter().filter(|mode| mode.frequency_hz > 0.0).map(|mode| {
        let at = |(label, axis): &(i64, usize)| {
            let node = mode.shape.iter().find(|node| node.node == *label);
            let part = node.and_then(|node| node.components.get(*axis)).copied().unwrap_or_default();
            c64::new(part[0], part[1])
        };
        SetMode {
            frequency_hz: mode.frequency_hz,
            damping_ratio: Some(mode.damping_ratio),
            shape: freedoms.iter().map(at).collect(),
        }
    });
    let name = |(node, axis): &(i64, usize)| format!("{node}{}", ["x", "y", "z"][*axis]);
    ModeSet { channels: freedoms.iter().map(name).collect(), modes: modes.collect() }
}

fn some(names: &[String]) -> String {
    let more = names.len().saturating_sub(NAMED_MAX);
    let listed = names.iter().take(NAMED_MAX).cloned().collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{listed} and {more} more") } else { listed }
}

impl Compared {
    /// Channels of one side only, in words.
    pub(super) fn left_out(&self) -> Vec<String> {
        let sides = [("here", &self.comparison.unpaired[0]), ("in the reference", &self.comparison.unpaired[1])];
        let told = sides.into_iter().filter(|(_, names)| !names.is_empty());
        told.map(|(where_, names)| format!("channels only {where_}, not compared: {}", some(names))).collect()
    }

    pub(super) fn as_json(&self, outcome: &Outcome) -> Value {
        let pair = |pair: &modal::mode_sets::Pair| {
            json!({ "row": pair.row + 1, "column": pair.column + 1, "mac": pair.mac,
                "frequency_hz": outcome.modes[pair.row].frequency_hz,
                "reference_frequency_hz": self.reference.modes[pair.column].frequency_hz,
                "frequency_change_percent": 100.0 * pair.frequency_change, "damping_change": pair.damping_change })
        };
        let [own, reference] = &self.comparison.unpaired;
        json!({ "reference": self.file, "channels": self.comparison.common,
            "rows": outcome.modes.iter().map(|mode| mode.frequency_hz).collect::<Vec<_>>(),
            "columns": self.reference.modes.iter().map(|mode| mode.frequency_hz).collect::<Vec<_>>(),
            "values": self.comparison.values, "pairs": self.comparison.pairs.iter().map(pair).collect::<Vec<_>>(),
            "unpaired_channels": { "own": own, "reference": reference } })
    }

    pub(super) fn in_words(&self, outcome: &Outcome) -> String {
        let mut text = format!("\nagainst {}, {} channels in common\n", self.file, self.comparison.common.len());
        let _ = writeln!(
            text,
            "{:>4} {:>9} {:>14} {:>10} {:>6}",
            "mode", "reference", "frequency [Hz]", "change [%]", "MAC"
        );
        for pair in &self.comparison.pairs {
            let hz = report::text::short(outcome.modes[pair.row].frequency_hz);
            let change = 100.0 * pair.frequency_change;
            let _ =
                writeln!(text, "{:>4} {:>9} {hz:>14} {change:>+10.2} {:>6.3}", pair.row + 1, pair.column + 1, pair.mac);
        }
        let alone: Vec<String> = (0..outcome.modes.len())
            .filter(|row| !self.comparison.pairs.iter().any(|pair| pair.row == *row))
            .map(|row| (row + 1).to_string())
            .collect();
        if !alone.is_empty() {
            let _ = writeln!(text, "  no partner in the reference: mode {}", alone.join(", "));
        }
        self.left_out().iter().for_each(|line| text.push_str(&crate::recordings::wrapped(line, "  ")));
        text
    }
}
