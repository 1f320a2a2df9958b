//! Examination of a recording on its own: what is wrong with it before any model is held against
//! it.
//!
//! Each check is a test with a stated false-alarm level, [`FALSE_ALARM`] per check and recording,
//! corrected for the number of channels, pairs and places it looks at; on top of significance a
//! finding must be material (a stated size that changes what an engineer does). No check knows a
//! recording by name. Findings carry their numbers, the evidence and the cure.
//!
//! What a plant adds, names and units it needs, noise it states, its step of time, is in
//! `discovery::against_plant`. Deliberately absent: which of its parameters cannot be found (that
//! is answered by its regressor).

mod axes;
mod clock;
mod content;
mod derived;
mod excitation;
mod feedback;
mod kinship;
mod levels;
pub mod quantity;
mod sampling;
pub mod segments;
mod stretch;
#[cfg(test)]
mod tests;

use serde::Serialize;

use channels::{Channel, Recording};

/// Probability that one check raises a finding on one recording that is sound.
pub const FALSE_ALARM: f64 = 1e-4;

/// What was tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// A channel that the plant needs and the recording does not hold.
    Missing,
    /// Too few samples for their spread, or for the plant's unknown numbers.
    FewSamples,
    /// Channels without enough samples, or with values that are not finite.
    NotFinite,
    DuplicateStamps,
    BackwardStamps,
    Gaps,
    Jitter,
    IrregularTime,
    /// Sources of different rate.
    Rate,
    /// A channel that is logged faster than it is updated.
    Held,
    /// Steps that are the plant's in another unit of time.
    TimeUnit,
    Constant,
    Copied,
    Derived,
    Saturation,
    Quantisation,
    Spikes,
    /// An angle that jumps by one turn.
    WrappedAngle,
    Aliasing,
    NoiseLevel,
    Lag,
    /// A channel that is later than others of its quantity.
    Delay,
    ClockSkew,
    Units,
    Sign,
    Scale,
    Offset,
    Axes,
    Feedback,
    Excitation,
    NoSignal,
    Segments,
}

/// What the finding asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Good to know; nothing has to change.
    Note,
    /// Estimates are biased or weakened unless it is allowed for.
    Warning,
    /// The data cannot be used as they are.
    Fault,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    pub check: Check,
    pub channel: String,
    /// The other channels concerned.
    pub others: Vec<String>,
    pub value: f64,
    /// Standard deviation of `value`, where it is an estimate.
    pub sigma: Option<f64>,
    pub unit: String,
    pub severity: Severity,
    pub evidence: String,
    pub cure: String,
}

impl Finding {
    /// A finding on `channel` with its value in `unit` (`-`: dimensionless); evidence and cure are
    /// still empty.
    pub fn new(check: Check, severity: Severity, channel: &str, value: f64, unit: &str) -> Self {
        Finding {
            check,
            channel: channel.into(),
            others: Vec::new(),
            value,
            sigma: None,
            unit: unit.into(),
            severity,
            evidence: String::new(),
            cure: String::new(),
        }
    }

    /// With the other channels that the finding concerns.
    pub fn with(mut self, others: &[&str]) -> Self {
        self.others = others.iter().map(|s| (*s).to_string()).collect();
        self
    }

    /// With the standard deviation of the value, in its unit; dropped where it is not finite.
    pub fn sigma(mut self, sigma: f64) -> Self {
        self.sigma = sigma.is_finite().then_some(sigma);
        self
    }

    /// With the evidence: one sentence with its statistic and probability.
    pub fn because(mut self, evidence: String) -> Self {
        self.evidence = evidence;
        self
    }

    /// With what the operator can do about it.
    pub fn cure(mut self, cure: impl Into<String>) -> Self {
        self.cure = cure.into();
        self
    }
}

/// All findings, in the order of [`Check`], worst first within one check.
///
/// Stamps that jump back cut the recording into runs, each examined on its own; a finding of
/// several runs is reported once, from the run with the most samples. Cost: about `pairs × n × 400`
/// multiplications; 55 000 samples of two channels below 1 s.
#[must_use]
pub fn examine(recording: &Recording) -> Vec<Finding> {
    examine_with(recording, &mut |_| ())
}

/// As [`examine`]; `progress` receives the share that is done, never less than before.
#[must_use]
pub fn examine_with(recording: &Recording, progress: &mut dyn FnMut(f64)) -> Vec<Finding> {
    let mut findings = clock::examine(recording);
    let mut runs = clock::runs(recording);
    let size = |r: &Recording| r.channels.iter().map(|c| c.value.len()).sum::<usize>();
    runs.sort_by_key(|run| core::cmp::Reverse(size(run)));
    let (count, all) = (runs.len(), runs.iter().map(|run| size(run)).sum::<usize>().max(1) as f64);
    let mut done = 0.0;
    for run in &runs {
        let own = size(run) as f64;
        for mut finding in examine_run(run, &mut |share| progress((done + share * own) / all)) {
            let known =
                |f: &Finding| f.check == finding.check && f.channel == finding.channel && f.others == finding.others;
            if !findings.iter().any(known) {
                if count > 1 {
                    finding.evidence.push_str(&format!(" (run from {} s)", short(start_s(run))));
                }
                findings.push(finding);
            }
        }
        done += own;
    }
    progress(1.0);
    in_order(findings)
}

/// By check, worst first within one.
#[must_use]
pub fn in_order(mut findings: Vec<Finding>) -> Vec<Finding> {
    findings.sort_by(|a, b| a.check.cmp(&b.check).then(b.severity.cmp(&a.severity)));
    findings
}

fn examine_run(run: &Recording, progress: &mut dyn FnMut(f64)) -> Vec<Finding> {
    let mut findings = levels::examine(run, &mut |share| progress(0.25 * share));
    let (unwrapped, wraps) = levels::unwrap_angles(run);
    findings.extend(wraps);
    let dead: Vec<String> = findings.iter().filter(|f| f.check == Check::Constant).map(|f| f.channel.clone()).collect();
    let mut live = unwrapped;
    if !dead.is_empty() {
        live.to_mut().channels.retain(|c| !dead.contains(&c.name));
    }
    let seen = stretch::liveliest(&live);
    progress(0.3);
    let derived = derived::examine(&seen, &mut |share| progress(0.3 + 0.25 * share));
    let pairs: Vec<(String, String)> =
        derived.iter().flat_map(|f| f.others.iter().map(|o| (f.channel.clone(), o.clone()))).collect();
    findings.extend(content::examine(&seen));
    findings.extend(derived);
    progress(0.6);
    findings.extend(kinship::examine(&seen, &pairs, &mut |share| progress(0.6 + 0.1 * share)));
    findings.extend(axes::examine(&seen));
    let held: Vec<String> = findings.iter().filter(|f| f.check == Check::Held).map(|f| f.channel.clone()).collect();
    findings.extend(sampling::late(&seen, &held));
    progress(0.75);
    findings.extend(feedback::examine(&seen));
    progress(0.8);
    findings.extend(excitation::examine(&seen));
    progress(0.85);
    drop(seen);
    findings.extend(segments::examine(&live));
    progress(1.0);
    findings
}

/// Below this a p value says no more than that chance is ruled out: model errors are larger.
const P_PRINTED_MIN: f64 = 1e-12;

/// `1.2e-8`, `0.40`, `< 1e-12`: a p value with two digits, for a cell of a table.
pub fn p_value(p: f64) -> String {
    match p {
        p if !p.is_finite() => "–".into(),
        p if p < P_PRINTED_MIN => "< 1e-12".into(),
        p if p < 1e-3 => format!("{p:.1e}"),
        p => format!("{p:.*}", (1.0 - libm::floor(libm::log10(p))).clamp(0.0, 5.0) as usize),
    }
}

/// `p = 1.2e-8`, `p < 1e-12`: a p value with two digits, for a sentence.
pub fn probability(p: f64) -> String {
    let value = p_value(p);
    if value.starts_with('<') { format!("p {value}") } else { format!("p = {value}") }
}

fn start_s(run: &Recording) -> f64 {
    run.channels.first().and_then(|c| c.time_s.first().copied()).unwrap_or(0.0)
}

/// Channels that can be put on an even grid of at least `samples_min`.
fn usable(recording: &Recording, samples_min: usize) -> Vec<&Channel> {
    recording.channels.iter().filter(|c| c.uniform().is_some_and(|u| u.value.len() >= samples_min)).collect()
}

/// A number for a sentence: four significant digits.
pub fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let exponent = libm::floor(libm::log10(x.abs())) as i32;
    if (-3..5).contains(&exponent) {
        let text = format!("{:.*}", (3 - exponent).max(0) as usize, x);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        format!("{x:.3e}")
    }
}
