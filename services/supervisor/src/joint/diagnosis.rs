//! A refused model: what it lacks is asked for once, and the model with it is tried like the first.

use super::descent::Descent;
use super::stage::Stage;
use super::{JointSupervisor, WINDOWS_MAX, announcement};
use craft::fold::{Folded, Predicted};
use craft::message::Received;
use craft::missing::{Answer, answer};
use craft::parameters::Parameters;
use runtime::{Frame, Outputs};
use serde::{Deserialize, Serialize};
use telemetry::{DIAGNOSIS, Diagnosis, ESTIMATE_JOINT, JointEstimate, JointVerdict, MODE};
use zerocopy::{FromBytes, IntoBytes};

/// The question, and what became of it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Diagnosed {
    /// The partition that would answer was given up.
    pub lost: bool,
    asked: bool,
    /// The answer that the model was augmented with, as it travelled; empty before.
    answer: Vec<u8>,
    /// The newest generation of messages; once asked, of those of the refused model.
    pub newest: u16,
    /// Generation of the messages that the question is about.
    generation: u16,
    /// The verdict that asked, by its code, and the arc that it names.
    question: Option<(u16, u16)>,
    /// The first generation of the augmented model.
    first: u16,
}

impl JointSupervisor {
    /// Common steps behind the messages of `generation`. A model that was augmented begins anew:
    /// its first messages are about the point that the diagnosis has given.
    pub(super) fn steps_taken(&self, generation: u16) -> u16 {
        generation.saturating_sub(self.state.diagnosed.first)
    }

    /// `verdict`, where it may stand behind an answer. An arc that named what is missing is fitted
    /// with it: it is held out no more, and a model that leaves it out has not explained it.
    pub(super) fn standing(
        &self,
        verdict: (JointVerdict, Option<usize>),
        heard: &[Received],
    ) -> (JointVerdict, Option<usize>) {
        let Some((code, arc)) = self.state.diagnosed.question else { return verdict };
        let arc = usize::from(arc);
        let reason = JointVerdict::from_code(code).unwrap_or(JointVerdict::Undecided);
        match verdict.0 {
            JointVerdict::Accepted if self.is_held_out(arc) => (JointVerdict::NoHeldOut, None),
            JointVerdict::Accepted | JointVerdict::NoMessage if heard.iter().all(|one| one.arc != arc) => {
                (reason, Some(arc))
            }
            _ => verdict,
        }
    }

    /// Ends with `verdict`. Where that rejects a model for the first time, and there is a partition
    /// that may say what is missing, it has its say first.
    pub(super) fn refuse(
        &mut self,
        generation: u16,
        (verdict, arc): (JointVerdict, Option<usize>),
        folded: &Folded,
        predicted: Option<Predicted>,
        frame: &Frame<'_>,
        out: &mut Outputs,
    ) {
        let held_out = (0..self.plan.arcs.len()).find(|arc| self.is_held_out(*arc));
        let of = match verdict {
            JointVerdict::ArcNotExplained | JointVerdict::ArcsContradict => arc,
            JointVerdict::HeldOutMissed => held_out,
            _ => None,
        };
        let asked = of.filter(|_| self.is_diagnosed && !self.state.diagnosed.lost && !self.state.diagnosed.asked);
        let Some(of) = asked else {
            return self.end(generation, (verdict, arc), Some(folded), predicted, frame, out);
        };
        let mut sample = announcement::sample(&self.parameters, generation, Some(folded), frame);
        announcement::judged(&mut sample, verdict, Some(of), predicted);
        sample.asks = JointEstimate::ASKS_WHAT_IS_MISSING;
        out.publish(ESTIMATE_JOINT, &sample);
        (self.state.diagnosed.asked, self.state.diagnosed.generation) = (true, generation);
        self.state.diagnosed.question = Some((verdict.code(), of as u16));
        let diagnosis = craft::pace::frames_max(frame.period_ns);
        let until_frame = frame.number + WINDOWS_MAX * self.window + diagnosis;
        self.state.stage = Stage::Diagnosing { until_frame };
    }

    /// Waits for the answer. With an effect in it the model goes on; without one, or without an
    /// answer, the verdict that was published stands.
    pub(super) fn hear_diagnosis(&mut self, is_over: bool, frame: &Frame<'_>, out: &mut Outputs) {
        let said = frame.samples(DIAGNOSIS).iter().rfind(|one| self.heard_answer(one).is_some());
        if let Some(said) = said
            && let Some(theta) = self.augment(said)
        {
            self.state.diagnosed.answer = said.as_bytes().to_vec();
            let generation = self.state.diagnosed.newest;
            (self.state.diagnosed.first, self.state.descent) = (generation + 1, Descent::default());
            out.publish(ESTIMATE_JOINT, &announcement::point(&self.parameters, generation, (None, &theta), frame));
            self.state.messages.clear();
            let until_frame = frame.number + WINDOWS_MAX * self.window;
            self.state.stage = Stage::Folding { generation: generation + 1, until_frame };
        } else if said.is_some() || self.state.diagnosed.lost || is_over {
            out.publish(MODE, &self.mode(None, frame));
            self.state.stage = Stage::Ended;
        }
    }

    /// The answer of `sample`, if it is one to this question.
    fn heard_answer(&self, sample: &Diagnosis) -> Option<Answer> {
        let plant = self.plan.known(self.plan.arcs.first()?).ok()?;
        answer(sample, &plant, &self.parameters).ok().filter(|one| one.generation == self.state.diagnosed.generation)
    }

    /// Takes the parameters of the model with what is missing; where its first linearisation is.
    /// `None` where nothing can be added.
    fn augment(&mut self, sample: &Diagnosis) -> Option<Vec<f64>> {
        let plant = self.plan.known(self.plan.arcs.first()?).ok()?;
        let answer = self.heard_answer(sample)?;
        let augmented = answer.augmented(&plant)?;
        let parameters = Parameters::of_plant(&augmented).ok()?;
        let known = |name: &str| {
            let at = self.parameters.unknowns.iter().position(|unknown| unknown.name == name)?;
            answer.theta.get(at).copied()
        };
        let theta = parameters.unknowns.iter().map(|unknown| known(&unknown.name).unwrap_or(unknown.prior)).collect();
        self.parameters = parameters;
        Some(theta)
    }

    /// Behind a restart: the parameters are those of the model that was augmented.
    pub(super) fn take_up_diagnosis(&mut self) {
        if let Ok(sample) = Diagnosis::read_from_bytes(&self.state.diagnosed.answer) {
            let _ = self.augment(&sample);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use craft::message::received;
    use telemetry::{Information, Sample};

    /// Flies arcs A, B and C and holds D out.
    fn supervisor() -> JointSupervisor {
        let text = include_str!("../../../../tests/data/craft/pendulum.toml");
        let plant = include_str!("../../../../deploy/plants/pendulum.toml");
        let opened = plant_file::scenario::open("pendulum", text, |_| Ok(plant.into())).unwrap();
        let craft = opened.scenario.craft.clone().unwrap();
        JointSupervisor::new(&opened.scenario, &craft, 40, true).unwrap()
    }

    fn messages(supervisor: &JointSupervisor, arcs: &[usize]) -> Vec<Received> {
        let parameters = &supervisor.parameters;
        let (count, parameter_hash) = (parameters.len() as u16, parameters.hash);
        let of = |arc: &usize| {
            let sample = Information { arc: *arc as u16, count, parameter_hash, rows: 9, ..Information::zeroed_at(0) };
            received(&sample.sealed(), parameters).unwrap()
        };
        arcs.iter().map(of).collect()
    }

    #[test]
    fn a_held_out_arc_that_named_what_is_missing_confirms_nothing() {
        let mut supervisor = supervisor();
        let heard = messages(&supervisor, &[0, 1, 2]);
        let accepted = (JointVerdict::Accepted, None);
        assert_eq!(supervisor.standing(accepted, &heard), accepted);
        supervisor.state.diagnosed.question = Some((JointVerdict::HeldOutMissed.code(), 3));
        assert_eq!(supervisor.standing(accepted, &heard), (JointVerdict::NoHeldOut, None));
        // a refusal needs no confirmation
        let refused = (JointVerdict::ArcsContradict, Some(1));
        assert_eq!(supervisor.standing(refused, &heard), refused);
    }

    #[test]
    fn a_model_that_leaves_out_the_arc_that_refused_the_first_one_has_not_explained_it() {
        let mut supervisor = supervisor();
        let reason = JointVerdict::ArcNotExplained;
        supervisor.state.diagnosed.question = Some((reason.code(), 2));
        let accepted = (JointVerdict::Accepted, None);
        assert_eq!(supervisor.standing(accepted, &messages(&supervisor, &[0, 1, 2])), accepted);
        assert_eq!(supervisor.standing(accepted, &messages(&supervisor, &[0, 1])), (reason, Some(2)));
    }
}
