//! What is special about modes of a record as it is: tones among them, complex shapes, folding, and
//! what the examination of the record found.

use examination::even_record::Treatment;
use serde_json::{Value, json};

/// What a line of the answer is.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Nature {
    Mode {
        /// Not collinear, and no delay explains it.
        complex: bool,
        /// Frequencies that would show at the same place, where the record was read below its rate.
        folded: Vec<f64>,
        /// Tones within its half-power band, which were taken out.
        tones_hz: Vec<f64>,
    },
    Tone {
        wander_hz: f64,
    },
}

/// Of a time record without inputs; empty for others.
#[derive(Clone, Debug, Default)]
pub(super) struct AsItIs {
    /// One for each mode; all are modes when empty.
    pub natures: Vec<Nature>,
    pub treatments: Vec<Treatment>,
}

impl AsItIs {
    /// `mode` or `tone`.
    pub fn nature(&self, k: usize) -> &'static str {
        if matches!(self.natures.get(k), Some(Nature::Tone { .. })) { "tone" } else { "mode" }
    }

    /// As the table of the answer has it.
    pub fn in_table(&self, k: usize) -> &'static str {
        match self.natures.get(k) {
            Some(Nature::Tone { .. }) => "tone",
            Some(Nature::Mode { complex: true, .. }) => "mode, complex shape",
            Some(Nature::Mode { folded, .. }) if !folded.is_empty() => "mode, may be folded",
            Some(Nature::Mode { tones_hz, .. }) if !tones_hz.is_empty() => "mode, under a tone",
            _ => "mode",
        }
    }

    /// What is known of line `k` beside the numbers, into its object.
    pub fn describe(&self, k: usize, object: &mut Value) {
        object["nature"] = json!(self.nature(k));
        match self.natures.get(k) {
            Some(Nature::Tone { wander_hz }) => object["wander_hz"] = json!(wander_hz),
            Some(Nature::Mode { complex, folded, tones_hz }) => {
                object["complex_shape"] = json!(complex);
                object["may_be_folded_from_hz"] = json!(folded);
                object["tones_on_it_hz"] = json!(tones_hz);
            }
            None => {}
        }
    }

    pub fn examination(&self) -> Value {
        let of = |t: &Treatment| json!({ "check": t.check, "channel": t.channel, "value": t.value, "unit": t.unit, "did": t.did });
        self.treatments.iter().map(of).collect()
    }

    /// One line per finding, those of several channels together; then the folding.
    pub fn lines(&self, frequencies_hz: &[f64]) -> Vec<String> {
        let mut lines: Vec<(String, String, Vec<&str>)> = Vec::new();
        for t in &self.treatments {
            let what = if matches!(t.check, "tone" | "hidden") {
                format!("{:.4} Hz", t.value)
            } else {
                t.check.replace('_', " ")
            };
            match lines.iter_mut().find(|(check, did, _)| *check == what && *did == t.did) {
                Some((_, _, channels)) => channels.push(&t.channel),
                None => lines.push((what, t.did.clone(), vec![&t.channel])),
            }
        }
        let mut said: Vec<String> = lines
            .into_iter()
            .map(|(what, did, channels)| match channels.join(", ") {
                empty if empty.is_empty() => format!("{what}: {did}"),
                channels => format!("{what}, {channels}: {did}"),
            })
            .collect();
        for (nature, f) in self.natures.iter().zip(frequencies_hz) {
            if let Nature::Mode { folded, .. } = nature
                && !folded.is_empty()
            {
                let images: Vec<String> = folded.iter().take(4).map(|f| format!("{f:.4}")).collect();
                let more = if folded.len() > 4 { ", …" } else { "" };
                said.push(format!(
                    "{f:.4} Hz may be folded: at the rate at which the values change, {}{more} Hz show there, too",
                    images.join(", ")
                ));
            }
        }
        said
    }
}
