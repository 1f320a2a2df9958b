//! The answer of the tool, reduced to the fields of the score.

use crate::case::Exam;
use channels::Recording;
use discovery::diagnose::{Diagnosis, Options, Verdict};
use discovery::evidence::diagnose;
use dynamics::description::Plant;
use identification::problem::Problem;
use serde::Serialize;
use serde_json::Value;

/// Smallest weight of a rival in the answered set: ΔBIC = 12 to a first name of weight one half.
pub const IN_SET: f64 = 1e-3;

/// A named effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Name {
    pub kind: String,
    pub site: String,
    pub probability: f64,
    /// Spelled as in the report.
    pub status: String,
    pub rivals: Vec<(String, String, f64)>,
    pub parameters: Vec<(String, f64, f64)>,
    pub d: f64,
}

/// One answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    pub verdict: String,
    pub reason: String,
    pub names: Vec<Name>,
    /// Channel, time [s, s].
    pub located: Vec<(String, [f64; 2])>,
    /// Nominal parameters: name, estimate, sigma.
    pub nominal: Vec<(String, f64, f64)>,
    /// The diagnosis panicked.
    pub crashed: bool,
    /// Kind and site of every tested law, and its number of hypotheses: the points of its grid.
    #[serde(skip)]
    pub tried: Vec<(String, String, f64)>,
}

/// Serialised with the names of the report.
fn spelled<T: Serialize>(value: &T) -> String {
    match serde_json::to_value(value) {
        Ok(Value::String(text)) => text,
        _ => String::new(),
    }
}

impl Answer {
    fn of(diagnosis: &Diagnosis) -> Self {
        let names = diagnosis.effects.iter().map(|effect| Name {
            kind: effect.kind.clone(),
            site: effect.site.clone(),
            probability: effect.probability,
            status: spelled(&effect.status),
            rivals: effect.rivals.iter().map(|r| (r.kind.clone(), r.site.clone(), r.probability)).collect(),
            parameters: effect.parameters.iter().map(|p| (p.name.clone(), p.value, p.sigma)).collect(),
            d: effect.d,
        });
        Self {
            verdict: spelled(&diagnosis.verdict),
            reason: diagnosis.reason.clone(),
            names: names.collect(),
            located: diagnosis.located.iter().map(|w| (w.channel.clone(), w.time)).collect(),
            nominal: diagnosis.nominal.iter().map(|n| (n.name.clone(), n.after, n.sigma)).collect(),
            crashed: false,
            tried: diagnosis.tried.iter().map(|law| (law.kind.clone(), law.site.clone(), law.chances)).collect(),
        }
    }

    fn none(reason: String, crashed: bool) -> Self {
        let verdict = spelled(&Verdict::CannotDecide);
        let (names, located, nominal, tried) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { verdict, reason, names, located, nominal, crashed, tried }
    }

    /// The verdict is `verdict`.
    #[must_use]
    pub fn is(&self, verdict: &str) -> bool {
        self.verdict == verdict
    }

    /// Number of hypotheses of a law; `None`: it was not tested.
    #[must_use]
    pub fn chances(&self, kind: &str, site: &str) -> Option<f64> {
        self.tried.iter().find(|(own, at, _)| own == kind && at == site).map(|(.., chances)| *chances)
    }

    /// The verdict reports unmodelled physics or a sensor fault, identified or not.
    #[must_use]
    pub fn detects(&self) -> bool {
        ["named", "not_separable", "sensor", "not_in_catalogue"].contains(&self.verdict.as_str())
    }

    /// The first name and its rivals above [`IN_SET`]: kind, site, probability.
    #[must_use]
    pub fn set(&self) -> Vec<(&str, &str, f64)> {
        let Some(first) = self.names.first().filter(|_| self.detects()) else { return Vec::new() };
        let rivals = first.rivals.iter().filter(|(.., p)| *p >= IN_SET).map(|(k, s, p)| (k.as_str(), s.as_str(), *p));
        std::iter::once((first.kind.as_str(), first.site.as_str(), first.probability)).chain(rivals).collect()
    }
}

fn problem(plant: &Plant, recording: &Recording) -> Result<Problem, String> {
    Problem::new(plant, std::slice::from_ref(recording), &[]).map_err(|error| error.to_string())
}

/// Diagnoses an exam. The tool receives only the plant and the recordings.
#[must_use]
pub fn ask(exam: &Exam) -> Answer {
    let diagnosed = || -> Result<Diagnosis, String> {
        let held_out = exam.held_out.as_ref().map(|(plant, recording)| problem(plant, recording)).transpose()?;
        let options = Options { without: exam.without.clone(), held_out, threads: 1, ..Options::default() };
        Ok(diagnose(&problem(&exam.plant, &exam.recording)?, &options, &mut |_, _| {}))
    };
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(diagnosed)) {
        Ok(Ok(diagnosis)) => Answer::of(&diagnosis),
        Ok(Err(reason)) => Answer::none(reason, false),
        Err(_) => Answer::none("the diagnosis panicked".to_owned(), true),
    }
}
