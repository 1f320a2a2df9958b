//! One craft through all its arcs: which arc is flown when, the generations of messages, and
//! whether together they give a model.
//!
//! Arcs are flown one after another; each is heard by its keeper at its end, from what the messages
//! before it say (generation 0). Then the mean of all is announced as the common point of
//! linearisation, downhill, until a step is small. The posterior is tested by every arc's noise, by
//! every arc against all others, and by the held-out arc, which is predicted. No partition is a
//! fusion centre: every partition folds the same messages in the order of the arcs; this one
//! announces and judges.

mod announcement;
mod descent;
mod diagnosis;
mod stage;

use craft::fold::{Folded, Predicted};
use craft::message::{Received, received};
use craft::parameters::{Parameters, ParametersError};
use craft::refusal::unexplained;
use descent::Descent;
use plant_file::scenario::{ArcExperiment, CraftPlan, Scenario};
use runtime::{Frame, Outputs, Partition, StateError};
use serde::{Deserialize, Serialize};
use stage::Stage;
use telemetry::{
    DIAGNOSIS, ESTIMATE_JOINT, Experiment, Header, INFORMATION, INFORMATION_INERTIAL, INFORMATION_MODAL,
    INFORMATION_SLOSH, Information, JointEstimate, JointVerdict, MODE, Mode, ModeState, PartitionId, TopicId,
};
use zerocopy::{FromBytes, IntoBytes};

/// Rms step in posterior standard deviations below which the messages' point serves (design page
/// "study case", 4).
const STEP_SIGMA_ENOUGH: f64 = 0.1;
/// Common points of linearisation at most: one or two are needed where the arcs were heard well,
/// eight along the curved ridge of a fuel whose slosh was watched for one period.
const GENERATIONS_MAX: u16 = 16;
/// Pacing windows until a message is missed. Two are needed: one until the announcement takes
/// effect, one until the message does.
const WINDOWS_MAX: u64 = 10;

#[derive(Clone, Debug, Serialize, Deserialize)]
struct State {
    stage: Stage,
    /// Experiments commanded so far.
    flown: Vec<bool>,
    lost: [bool; 3],
    /// Messages of the present generation, as they travelled.
    messages: Vec<Vec<u8>>,
    descent: Descent,
    /// Arcs whose keeper said that the plant cannot predict them.
    unpredictable: Vec<bool>,
    diagnosed: diagnosis::Diagnosed,
}

/// The partition that flies one craft.
pub struct JointSupervisor {
    plan: CraftPlan,
    parameters: Parameters,
    durations: Vec<u64>,
    window: u64,
    /// The run has a partition that says what a refused model lacks.
    is_diagnosed: bool,
    state: State,
}

impl JointSupervisor {
    /// Flies the craft of `scenario`, which is `plan`.
    ///
    /// # Errors
    /// See [`ParametersError`].
    pub fn new(
        scenario: &Scenario,
        plan: &CraftPlan,
        window_frames: u64,
        is_diagnosed: bool,
    ) -> Result<Self, ParametersError> {
        let state = State {
            stage: Stage::Ready { arc: 0 },
            flown: vec![false; plan.arcs.len()],
            lost: [false; 3],
            messages: Vec::new(),
            descent: Descent::default(),
            unpredictable: vec![false; plan.arcs.len()],
            diagnosed: diagnosis::Diagnosed::default(),
        };
        Ok(Self {
            parameters: Parameters::of(plan)?,
            durations: plan.arcs.iter().map(|arc| scenario.frames(arc.duration_s)).collect(),
            plan: plan.clone(),
            window: window_frames,
            is_diagnosed,
            state,
        })
    }

    fn is_held_out(&self, arc: usize) -> bool {
        self.plan.arcs[arc].experiment == ArcExperiment::HeldOut
    }

    fn is_lost(&self, arc: usize) -> bool {
        self.state.lost[usize::from(self.plan.arcs[arc].experiment.owner().code())]
    }

    /// Whether a message of `arc` may still come.
    fn is_awaited(&self, arc: usize) -> bool {
        self.state.flown[arc] && !self.is_lost(arc) && !self.state.unpredictable[arc]
    }

    /// Messages of the generation that is waited for; those of another build are left out.
    fn hear(&mut self, frame: &Frame<'_>) {
        let (generation, held_out) = self.state.stage.awaited();
        for one in INFORMATION.iter().flat_map(|topic| frame.samples(*topic)) {
            if one.generation != generation || (one.held_out == 1) != held_out {
                continue;
            }
            match received(one, &self.parameters) {
                Ok(_) => self.state.messages.push(one.as_bytes().to_vec()),
                // it could be predicted at the point before
                Err(_) if generation > 1 && !held_out => self.state.descent.is_impossible = true,
                Err(_) => {
                    if let Some(arc) = self.state.unpredictable.get_mut(usize::from(one.arc)) {
                        *arc = true;
                    }
                }
            }
        }
    }

    fn received(&self) -> Vec<Received> {
        descent::read(&self.state.messages, &self.parameters)
    }

    fn has_message(&self, arc: usize) -> bool {
        let samples = self.state.messages.iter().filter_map(|bytes| Information::read_from_bytes(bytes).ok());
        samples.map(|sample| usize::from(sample.arc)).any(|of| of == arc)
    }

    /// Every message that can come is there.
    fn all_heard(&self, held_out: bool) -> bool {
        let of_stage = |arc: &usize| self.is_held_out(*arc) == held_out && self.is_awaited(*arc);
        (0..self.plan.arcs.len()).filter(of_stage).all(|arc| self.has_message(arc))
    }

    /// Goes on to the next arc, or to the first common point of linearisation.
    fn go_on(&mut self, mut arc: usize, frame: &Frame<'_>, out: &mut Outputs) {
        while arc < self.plan.arcs.len() && self.is_lost(arc) {
            arc += 1;
        }
        if arc == self.plan.arcs.len() {
            return self.fold(0, frame, out);
        }
        self.state.flown[arc] = true;
        let effective_frame = frame.number + self.window;
        let end_frame = effective_frame + self.durations[arc];
        out.publish(MODE, &self.mode(Some(arc), frame));
        self.state.stage = Stage::Flying { arc, end_frame, until_frame: end_frame + WINDOWS_MAX * self.window };
    }

    fn mode(&self, arc: Option<usize>, frame: &Frame<'_>) -> Mode {
        let experiment = arc.map_or(Experiment::None, |arc| self.plan.arcs[arc].experiment.code());
        let state = match experiment {
            Experiment::Modal => ModeState::PreCaptureModal,
            Experiment::Slosh => ModeState::PreCaptureSlosh,
            Experiment::None => ModeState::Standby,
            _ => ModeState::PreCaptureInertial,
        };
        Mode {
            header: Header::at(frame.t_ns),
            frame: frame.number,
            effective_frame: frame.number + self.window,
            duration_frames: arc.map_or(0, |arc| self.durations[arc]),
            state: state.code(),
            previous: ModeState::Standby.code(),
            experiment: experiment.code(),
            event: crate::mode::Event::Check.code(),
            generation: arc.map_or(0, |arc| arc as u32 + 1),
            ended: u32::from(arc.is_none()),
            measured: 0.0,
            limit: 0.0,
        }
    }

    /// Folds the messages of the lowest point, those of `generation` or of one before, and asks for
    /// what is needed next.
    fn fold(&mut self, generation: u16, frame: &Frame<'_>, out: &mut Outputs) {
        self.state.diagnosed.newest = generation;
        self.state.descent.take(&self.parameters, generation, &self.state.messages);
        self.state.messages.clone_from(&self.state.descent.messages);
        let (lowest, heard) = (self.state.descent.generation, self.received());
        let Some(folded) = Folded::of(&self.parameters, &heard).filter(|_| !heard.is_empty()) else {
            let verdict = self.standing((JointVerdict::NoMessage, None), &heard);
            return self.end(generation, verdict, None, None, frame, out);
        };
        let taken = self.steps_taken(generation);
        if let Some(refused) = unexplained(&heard, self.steps_taken(lowest), usize::from(GENERATIONS_MAX) + 1) {
            let verdict = (JointVerdict::ArcNotExplained, Some(refused.arc));
            return self.refuse(lowest, verdict, &folded, None, frame, out);
        }
        let is_near = folded.step_sigma.is_some_and(|step| step < STEP_SIGMA_ENOUGH);
        let goes_on = generation == 0 || (!is_near && taken < GENERATIONS_MAX);
        let until_frame = frame.number + WINDOWS_MAX * self.window;
        let predicts = (0..self.plan.arcs.len()).any(|arc| self.is_held_out(arc) && self.is_awaited(arc));
        if goes_on {
            let next = self.state.descent.next(&self.parameters, &folded);
            // a step that was turned down leaves the posterior where it was: a point alone is new
            let is_new = lowest == generation;
            let folded = is_new.then_some(&folded);
            out.publish(ESTIMATE_JOINT, &announcement::point(&self.parameters, generation, (folded, &next), frame));
            self.state.messages.clear();
            self.state.stage = Stage::Folding { generation: generation + 1, until_frame };
        } else if is_near && predicts {
            let mut sample = announcement::sample(&self.parameters, lowest, Some(&folded), frame);
            sample.asks = JointEstimate::ASKS_HELD_OUT;
            out.publish(ESTIMATE_JOINT, &sample);
            self.state.stage = Stage::Predicting { generation: lowest, until_frame, fitted: self.state.messages.len() };
        } else {
            // why a model is refused says more than that its steps did not end
            let verdict = match folded.verdict(None) {
                (JointVerdict::NoHeldOut, _) if !is_near => (JointVerdict::NotConverged, None),
                verdict => verdict,
            };
            self.refuse(lowest, verdict, &folded, None, frame, out);
        }
    }

    /// The held-out arc has been predicted, or is missed.
    fn judge(&mut self, generation: u16, fitted: usize, frame: &Frame<'_>, out: &mut Outputs) {
        let heard = self.received();
        let (fitted, held_out) = heard.split_at(fitted.min(heard.len()));
        let Some(folded) = Folded::of(&self.parameters, fitted) else {
            return self.end(generation, (JointVerdict::NoMessage, None), None, None, frame, out);
        };
        let predicted = held_out.first().and_then(|one| folded.predicts(&self.parameters, one));
        let verdict = self.standing(folded.verdict(predicted), fitted);
        self.refuse(generation, verdict, &folded, predicted, frame, out);
    }

    fn end(
        &mut self,
        generation: u16,
        (verdict, arc): (JointVerdict, Option<usize>),
        folded: Option<&Folded>,
        predicted: Option<Predicted>,
        frame: &Frame<'_>,
        out: &mut Outputs,
    ) {
        let mut sample = announcement::sample(&self.parameters, generation, folded, frame);
        announcement::judged(&mut sample, verdict, arc, predicted);
        out.publish(ESTIMATE_JOINT, &sample);
        out.publish(MODE, &self.mode(None, frame));
        self.state.stage = Stage::Ended;
    }
}

impl Partition for JointSupervisor {
    fn id(&self) -> PartitionId {
        PartitionId::Supervisor
    }

    fn inputs(&self) -> &'static [TopicId] {
        &[INFORMATION_INERTIAL.id, INFORMATION_SLOSH.id, INFORMATION_MODAL.id, DIAGNOSIS.id]
    }

    fn frame(&mut self, frame: &Frame<'_>, out: &mut Outputs) {
        for lost in frame.urgent.iter().filter_map(runtime::pacing::given_up) {
            if let Some(domain) = crate::domain_of(lost) {
                self.state.lost[usize::from(domain.code())] = true;
            }
            self.state.diagnosed.lost |= lost == PartitionId::Diagnosis;
        }
        self.hear(frame);
        let over = |until_frame: u64| frame.number >= until_frame;
        match self.state.stage {
            Stage::Ready { arc } => self.go_on(arc, frame, out),
            Stage::Flying { arc, end_frame, until_frame } => {
                // what is held out says nothing until it is asked
                let heard = if self.is_held_out(arc) { over(end_frame) } else { self.has_message(arc) };
                if heard || !self.is_awaited(arc) || over(until_frame) {
                    self.go_on(arc + 1, frame, out);
                }
            }
            Stage::Folding { generation, until_frame } => {
                if self.all_heard(false) || self.state.descent.is_impossible || over(until_frame) {
                    self.fold(generation, frame, out);
                }
            }
            Stage::Predicting { generation, until_frame, fitted } => {
                if self.all_heard(true) || over(until_frame) {
                    self.judge(generation, fitted, frame, out);
                }
            }
            Stage::Diagnosing { until_frame } => self.hear_diagnosis(over(until_frame), frame, out),
            Stage::Ended => {}
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&self.state, state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        self.state = runtime::restore_state(state)?;
        self.take_up_diagnosis();
        Ok(())
    }
}
