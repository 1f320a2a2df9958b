//! Why an answer is what it is, in words.

use super::Shown;
use crate::diagnose::Verdict;
use crate::evidence::decide::LEVEL;
use crate::evidence::hypothesis::{Hypothesis, SHIFTED_INPUTS};
use crate::evidence::timing::shift_of;

/// Probability from which a sentence names what else may be.
const INSTEAD: f64 = 0.05;

impl Shown<'_> {
    pub(super) fn reason(&self) -> String {
        let leader = &self.leader().model;
        let moved = |shift: f64| leader.key().replace(SHIFTED_INPUTS, &shifted_inputs(shift));
        let key = shift_of(&leader.set).map_or_else(|| leader.key(), moved);
        let odds = self.pool.log_odds(self.decision.leader);
        let beside = self.law.map_or(String::new(), |law| format!("; {}", law.words));
        let reason = match self.verdict() {
            Verdict::NotInCatalogue | Verdict::CannotDecide if self.is_smaller() => {
                format!("{key}: {odds:.1} nats ahead of the plant without a finding, and more is left")
            }
            Verdict::CannotDecide if self.decision.verdict == Verdict::CannotDecide => format!(
                "the plant or the noise is not as the file states, and the recording does not tell which: {key} leads (probability {:.2}){}{}",
                self.decision.of_kind,
                self.instead(),
                self.remainder()
            ),
            Verdict::CannotDecide if self.law.is_none() => {
                format!("the search ended at the limit of its work before all laws were compared{}", self.remainder())
            }
            Verdict::NotInCatalogue | Verdict::CannotDecide => {
                return self.law.map_or(String::new(), |law| format!("{}{}", law.words, self.remainder()));
            }
            Verdict::Named | Verdict::Sensor => {
                format!("{key}: {odds:.1} nats ahead of the plant without a finding, prior and multiplicity counted")
            }
            Verdict::NotSeparable if self.decision.found >= LEVEL => format!(
                "something is missing (probability {:.3}), and several laws explain it: {key} leads, {odds:.1} nats ahead of the plant without a finding",
                self.decision.found
            ),
            Verdict::NotSeparable => format!(
                "a law is missing, or a number of the file is wrong: {key} leads (probability {:.2}), {odds:.1} nats ahead of the plant without a finding{}",
                self.decision.of_kind,
                self.instead()
            ),
            Verdict::ParameterConflict => {
                format!("{key}: {odds:.1} nats ahead of the number as the file states it{}", self.doubt())
            }
            Verdict::InputTiming => {
                format!("{key}: {odds:.1} nats ahead of inputs held from their stamps{}", self.doubt())
            }
            Verdict::NoiseModel => {
                let beside = if self.doubt().is_empty() { "; no physics is missing beside it" } else { "" };
                format!("the noise is not as stated{beside}: {}{}{}", self.noise(), self.doubt(), self.remainder())
            }
            _ if self.is_irrelevant() && !matches!(self.decision.verdict, Verdict::None) => self.not_worth(&key),
            _ => format!(
                "nothing is missing that this recording could show; see the detection limits{}",
                self.remainder()
            ),
        };
        let unworthy = match &self.unworthy[..] {
            [] => String::new(),
            names => format!("; seen and not worth adding: {}", names.join(", ")),
        };
        format!("{reason}{unworthy}{beside}")
    }

    /// The probability of a word that is below the level, and what else may be.
    fn doubt(&self) -> String {
        let of_kind = self.decision.of_kind;
        if of_kind >= LEVEL || self.instead().is_empty() {
            return String::new();
        }
        format!("; probability {of_kind:.2}{}", self.instead())
    }

    /// The names outside the leading model with their probabilities.
    fn instead(&self) -> String {
        let leading = &self.models[self.decision.leader].members;
        let mut all: Vec<(f64, &String)> = (self.names.iter().enumerate())
            .filter(|(place, _)| leading.iter().all(|(_, own)| own != place))
            .map(|(place, name)| (self.decision.inclusion[place], name))
            .filter(|(probability, _)| *probability >= INSTEAD)
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let each: Vec<String> = all.iter().map(|(probability, name)| format!("{name} ({probability:.2})")).collect();
        if each.is_empty() { String::new() } else { format!("; it may be instead: {}", each.join(", ")) }
    }

    /// What free runs of the plant alone miss beyond the noise, in words.
    fn remainder(&self) -> String {
        let felt = self.compared.as_ref().filter(|compared| compared.relevance().is_some());
        felt.map_or(String::new(), |compared| {
            let share = 100.0 * compared.remains();
            format!(
                "; free runs of {:.3} s miss {share:.2} % of the signal beyond what noise explains",
                compared.window_s
            )
        })
    }

    /// Why a model that is there is not worth adding.
    fn not_worth(&self, key: &str) -> String {
        let Some(compared) = &self.compared else { return String::new() };
        format!(
            "nothing worth adding: what remains is {:.2} % of the signal over {:.3} s; seen and not worth adding: {key}, which explains {:.1} % of it",
            100.0 * compared.remains(),
            compared.window_s,
            100.0 * compared.relevance().unwrap_or(0.0).max(0.0)
        )
    }

    /// Fitted noise over stated, in words.
    fn noise(&self) -> String {
        let (noise, stated) = (&self.leader().model.noise, &self.session.noise);
        let sensors = self.session.problem.plant.sensors.iter().enumerate().map(|(i, sensor)| {
            let colour = if noise.pole[i] == 0.0 { String::new() } else { format!(", pole {:.2}", noise.pole[i]) };
            format!("{} x{:.2}{colour}", sensor.name, noise.sensor_sigma[i] / stated.sensor_sigma[i])
        });
        let inputs = self.session.noise_names.iter().enumerate();
        let stated_inputs = inputs.filter(|(i, _)| self.session.disturbance_sigma[*i].is_infinite());
        let inputs =
            stated_inputs.map(|(i, name)| format!("{name} x{:.2}", noise.input_sigma[i] / stated.input_sigma[i]));
        let unstated = self.leader().model.set.iter().filter_map(|own| match own {
            Hypothesis::Disturbance(k, name) => {
                Some(format!("disturbance of {name} {:.3e}, which is not stated", noise.input_sigma[*k]))
            }
            _ => None,
        });
        sensors.chain(inputs).chain(unstated).collect::<Vec<_>>().join(", ")
    }
}

/// `inputs 0.5 samples earlier than they are stamped, as linear ones between stamps are`.
fn shifted_inputs(shift_samples: f64) -> String {
    let way = if shift_samples < 0.0 { "earlier" } else { "later" };
    let linear = if (shift_samples + 0.5).abs() < 0.05 { ", as linear ones between stamps are" } else { "" };
    format!("inputs {:.2} samples {way} than they are stamped{linear}", shift_samples.abs())
}
