//! What a refused model lacks: the question, the answer of an arc, and whether that was confirmed.

use craft::missing::{Answer, Missing, answer};
use craft::parameters::Parameters;
use dynamics::description::{EffectUse, Plant};
use plant_file::scenario::CraftPlan;
use recording::RecordedRun;
use serde_json::{Value, json};
use std::fmt::Write;
use telemetry::{DIAGNOSIS, ESTIMATE_JOINT, JointEstimate, JointVerdict};

/// A question and its answer.
pub struct MissingOutcome {
    /// Why the supervisor asked.
    refused: JointVerdict,
    arc: String,
    /// `None`: nobody answered.
    answer: Option<Answer>,
    confirmed: bool,
    t_detected_s: Option<f64>,
    /// The craft as its file has it, and with what is missing, which has parameters of its own.
    nominal: Plant,
    augmented: Option<(Plant, Parameters)>,
}

impl MissingOutcome {
    /// Of a run; `None` where no model was refused, or there was no question.
    pub fn read(plan: &CraftPlan, parameters: &Parameters, period_s: f64, recorded: &RecordedRun) -> Option<Self> {
        let estimates: Vec<&JointEstimate> = recorded.of(ESTIMATE_JOINT).map(|(_, sample)| sample).collect();
        let question = estimates.iter().find(|one| one.asks == JointEstimate::ASKS_WHAT_IS_MISSING)?;
        let arc = plan.arcs.get(usize::from(question.verdict_arc))?;
        let nominal = plan.known(arc).ok()?;
        let said = recorded.of(DIAGNOSIS).map(|(_, sample)| sample).next();
        let answer = said.and_then(|said| answer(said, &nominal, parameters).ok());
        let augmented = answer.as_ref().and_then(|answer| answer.augmented(&nominal));
        let augmented = augmented.and_then(|plant| Some((plant.clone(), Parameters::of_plant(&plant).ok()?)));
        let accepted = |one: &&JointEstimate| one.verdict == JointVerdict::Accepted.code();
        let last = estimates.last().copied().filter(accepted);
        let confirmed =
            augmented.as_ref().is_some_and(|(_, own)| last.is_some_and(|one| one.parameter_hash == own.hash));
        Some(Self {
            refused: JointVerdict::from_code(question.verdict)?,
            arc: arc.name.clone(),
            t_detected_s: answer.as_ref().and(said).map(|said| said.frame as f64 * period_s),
            answer,
            confirmed,
            nominal,
            augmented,
        })
    }

    /// The model with what is missing, if any was tried.
    pub fn augmented(&self) -> Option<&(Plant, Parameters)> {
        self.augmented.as_ref()
    }

    /// The effects of the answer: those that are missing, then those that could replace them.
    pub fn named(&self) -> impl Iterator<Item = &Missing> {
        self.answer.iter().flat_map(|answer| &answer.effects)
    }

    /// The model with what is missing predicts the held-out arc.
    pub const fn is_confirmed(&self) -> bool {
        self.confirmed
    }

    /// From the begin of the run to the answer \[s\].
    pub const fn t_detected_s(&self) -> Option<f64> {
        self.t_detected_s
    }

    fn effects(&self) -> impl Iterator<Item = Value> + '_ {
        let effects = self.answer.iter().flat_map(|answer| answer.effects.iter().map(move |one| (answer, one)));
        effects.map(|(answer, one)| {
            let used = EffectUse { kind: one.kind.clone(), site: one.site.clone(), values: Vec::new() };
            let effect = self.nominal.catalogue.effect(&one.kind);
            let unit = |name: &str| effect.and_then(|effect| effect.parameter(name)).map(|parameter| parameter.unit);
            let parameters = one.values.iter().map(|(name, value, sigma)| {
                let unit = unit(name).map(|unit| self.nominal.effect_unit(&used, unit));
                json!({ "name": name, "value": value, "sigma": sigma, "unit": unit })
            });
            let replaces = one.stands_in_for.and_then(|of| answer.effects.get(of));
            json!({
                "kind": one.kind, "site": one.site.to_string(), "probability": one.probability,
                "d": one.significance, "parameters": parameters.collect::<Vec<_>>(),
                "stands_in_for": replaces.map(|of| format!("{}@{}", of.kind, of.site)),
            })
        })
    }

    /// What `--json` shows.
    pub fn json(&self) -> Value {
        json!({
            "asked_by": format!("supervisor: {}", self.refused.text()), "arc": self.arc,
            "verdict": self.answer.as_ref().map(|answer| answer.verdict.text()),
            "effects": self.effects().collect::<Vec<_>>(),
            "confirmed": self.confirmed, "t_detected_s": self.t_detected_s,
        })
    }

    /// For a terminal.
    pub fn words(&self) -> String {
        let Some(answer) = &self.answer else {
            return format!("{}: {} asked what is missing; nobody answered", self.refused.text(), self.arc);
        };
        let mut text = format!("{} ({}); {}", self.refused.text(), self.arc, answer.verdict.text());
        for one in answer.found() {
            let _ = write!(text, "; {} at {}, probability {:.2}", one.kind, one.site, one.probability);
            for (name, value, sigma) in one.values.iter().filter(|(.., sigma)| sigma.is_finite()) {
                let (value, sigma) = report::text::with_sigma(*value, *sigma);
                let _ = write!(text, ", {name} {value} +- {sigma}");
            }
        }
        let tried = if self.confirmed { "; confirmed on the held-out arc" } else { "; not confirmed" };
        text + if self.augmented.is_some() { tried } else { "" }
    }
}
