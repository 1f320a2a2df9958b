//! The partition that keeps the arcs of one domain and says what they know of the whole craft.
//!
//! Rows are gathered frame by frame into memory taken at the start. At its end an arc is heard
//! through growing windows, from what the messages of earlier arcs say; then it answers every
//! announced point of linearisation with one message. Both are work that a frame leaves: what they
//! publish belongs to that frame, at whatever speed they are done.

use crate::fold::fold;
use crate::message::{Received, Tag, received, sample};
use crate::missing::answer;
use crate::parameters::{Parameters, ParametersError};
use crate::places::Places;
use crate::store::Store;
use identification::joint::{Arc, JointError, Message, Vehicle};
use identification::problem::Problem;
use identification::work::Work;
use plant_file::scenario::CraftPlan;
use runtime::{Frame, Outputs, Partition, StateError};
use telemetry::{
    CRAFT, DIAGNOSIS, Diagnosis, Domain, ESTIMATE_JOINT, Experiment, INFORMATION, INFORMATION_INERTIAL,
    INFORMATION_MODAL, INFORMATION_SLOSH, Information, JointEstimate, PartitionId, TopicId,
};
use zerocopy::{FromBytes, IntoBytes};

/// Work that a frame leaves.
struct Due {
    frame: u64,
    t_ns: u64,
    what: What,
}

enum What {
    /// The arc of this index has ended.
    Hear(usize),
    /// Messages of the next generation, or the held-out arc, at `theta`.
    Answer { theta: Vec<f64>, generation: u16, held_out: bool },
}

/// The partition.
pub struct Keeper {
    id: PartitionId,
    parameters: Parameters,
    store: Store,
    /// Per arc, values of the unknowns that it alone has, once they were estimated.
    own: Vec<Vec<f64>>,
    /// The first messages of all arcs, as they travel.
    heard: Vec<Vec<u8>>,
    /// The answer whose effects the plants carry by now, as it travelled; empty before.
    answer: Vec<u8>,
    due: Option<Due>,
}

impl Keeper {
    /// The keeper of the arcs of `domain`.
    ///
    /// # Errors
    /// See [`ParametersError`].
    pub fn new(id: PartitionId, domain: Domain, craft: &CraftPlan) -> Result<Self, ParametersError> {
        let parameters = Parameters::of(craft)?;
        let store = Store::new(craft, |arc| arc.experiment.owner() == domain)?;
        let own = vec![Vec::new(); store.arcs.len()];
        Ok(Self { id, parameters, store, own, heard: Vec::new(), answer: Vec::new(), due: None })
    }

    /// The first messages of other arcs are what this one begins with.
    fn hear_others(&mut self, frame: &Frame<'_>) {
        let inputs = self.inputs();
        for topic in INFORMATION.iter().filter(|topic| inputs.contains(&topic.id)) {
            for message in frame.samples(*topic) {
                if message.generation == 0 && received(message, &self.parameters).is_ok() {
                    self.heard.push(message.as_bytes().to_vec());
                }
            }
        }
    }

    /// Takes what is missing into the plants of all arcs: from then on messages speak of the
    /// parameters of that model.
    fn augment(&mut self, said: &Diagnosis) -> Option<()> {
        let found = answer(said, &self.store.arcs.first()?.plant, &self.parameters).ok()?;
        let augmented = self.store.arcs.iter().map(|arc| found.augmented(&arc.plant));
        let augmented = augmented.collect::<Option<Vec<_>>>()?;
        self.parameters = Parameters::of_plant(augmented.first()?).ok()?;
        self.store.arcs.iter_mut().zip(augmented).for_each(|(arc, plant)| arc.plant = plant);
        self.answer = said.as_bytes().to_vec();
        Some(())
    }

    /// What was announced and asked for.
    fn asked(&self, frame: &Frame<'_>) -> Option<What> {
        let asking = frame.samples(ESTIMATE_JOINT).iter().rfind(|one| one.parameter_hash == self.parameters.hash)?;
        let theta = asking.theta[..self.parameters.len()].to_vec();
        match asking.asks {
            JointEstimate::ASKS_NEXT_GENERATION => {
                Some(What::Answer { theta, generation: asking.generation + 1, held_out: false })
            }
            JointEstimate::ASKS_HELD_OUT => Some(What::Answer { theta, generation: asking.generation, held_out: true }),
            _ => None,
        }
    }

    /// The likelihood of an arc, as one vehicle of one arc.
    fn of_arc<T>(&self, arc: usize, use_it: impl FnOnce(&Vehicle<'_>) -> Result<T, JointError>) -> Option<T> {
        let own = &self.store.arcs[arc];
        let recording = self.store.recording(arc)?;
        let problem = Problem::new(&own.plant, &[recording], &[]).ok()?;
        let arcs = [Arc { name: own.name.clone(), problem }];
        let work = std::sync::Arc::new(Work::of(f64::INFINITY));
        let vehicle = Vehicle::new(&arcs, 1, work).ok()?;
        use_it(&vehicle).ok()
    }

    /// Hears an arc from the fold of what is known; its message where it ended.
    fn heard(&mut self, arc: usize) -> Option<(Message, Vec<f64>)> {
        let earlier = self.heard.iter().filter_map(|bytes| Information::read_from_bytes(bytes).ok());
        let earlier: Vec<Received> = earlier.filter_map(|one| received(&one, &self.parameters).ok()).collect();
        let known = fold(&self.parameters, &earlier)?;
        let start = self.parameters.values(&known.mean);
        let reduced = self.of_arc(arc, |vehicle| {
            let places = Places::of(vehicle);
            let theta = places.joined(vehicle, &start, &[]);
            let (theta, message) = vehicle.hear(0, &places.widened(&known), theta)?;
            places.reduced(vehicle, theta, &message)
        })?;
        self.own[arc] = reduced.own;
        Some((reduced.message, reduced.shared))
    }

    /// What a whole arc says at `theta`.
    fn answered(&mut self, arc: usize, theta: &[f64], held_out: bool) -> Option<Message> {
        let own = self.own[arc].clone();
        let reduced = self.of_arc(arc, |vehicle| {
            let places = Places::of(vehicle);
            if held_out {
                let at = vehicle.own_settled(0, places.joined(vehicle, theta, &own))?;
                let message = vehicle.message(0, &at)?;
                return places.reduced(vehicle, at, &message);
            }
            places.message(vehicle, theta, own)
        })?;
        self.own[arc] = reduced.own;
        Some(reduced.message)
    }

    fn publish(&self, mut sample: Information, due: &Due, out: &mut Outputs) {
        sample.header.t_meas_ns = due.t_ns;
        sample.frame = due.frame;
        let own = match self.id {
            PartitionId::SloshId => INFORMATION_SLOSH,
            PartitionId::ModalId => INFORMATION_MODAL,
            _ => INFORMATION_INERTIAL,
        };
        out.publish(own, &sample);
    }
}

impl Partition for Keeper {
    fn id(&self) -> PartitionId {
        self.id
    }

    fn inputs(&self) -> &'static [TopicId] {
        match self.id {
            PartitionId::SloshId => {
                &[CRAFT.id, INFORMATION_INERTIAL.id, INFORMATION_MODAL.id, ESTIMATE_JOINT.id, DIAGNOSIS.id]
            }
            PartitionId::ModalId => {
                &[CRAFT.id, INFORMATION_INERTIAL.id, INFORMATION_SLOSH.id, ESTIMATE_JOINT.id, DIAGNOSIS.id]
            }
            _ => &[CRAFT.id, INFORMATION_SLOSH.id, INFORMATION_MODAL.id, ESTIMATE_JOINT.id, DIAGNOSIS.id],
        }
    }

    fn frame(&mut self, frame: &Frame<'_>, _out: &mut Outputs) {
        self.hear_others(frame);
        for said in frame.samples(DIAGNOSIS) {
            self.augment(said);
        }
        let mut what = self.asked(frame);
        if let Some(arc) = self.store.take(frame) {
            let fitted = self.store.arcs[arc].experiment != Experiment::HeldOut;
            what = fitted.then_some(What::Hear(arc)).or(what);
        }
        self.due = what.map(|what| Due { frame: frame.number, t_ns: frame.t_ns, what });
    }

    fn has_work(&self) -> bool {
        self.due.is_some()
    }

    /// Passes over stored arcs: up to minutes.
    fn work(&mut self, out: &mut Outputs) {
        let Some(due) = self.due.take() else { return };
        match &due.what {
            What::Hear(arc) => {
                let tag = Tag { arc: self.store.arcs[*arc].number, generation: 0, held_out: false };
                let found = self.heard(*arc);
                let (message, theta) = found.as_ref().map_or((None, &[][..]), |(m, theta)| (Some(m), theta));
                let said = sample(message, &self.parameters, theta, tag);
                if message.is_some() {
                    self.heard.push(said.as_bytes().to_vec());
                }
                self.publish(said, &due, out);
            }
            What::Answer { theta, generation, held_out } => {
                for arc in 0..self.store.arcs.len() {
                    let is_held_out = self.store.arcs[arc].experiment == Experiment::HeldOut;
                    if is_held_out != *held_out || !self.store.is_whole(arc) {
                        continue;
                    }
                    let message = self.answered(arc, theta, *held_out);
                    let tag = Tag { arc: self.store.arcs[arc].number, generation: *generation, held_out: *held_out };
                    self.publish(sample(message.as_ref(), &self.parameters, theta, tag), &due, out);
                }
            }
        }
    }

    fn save(&mut self, state: &mut Vec<u8>) -> Result<(), StateError> {
        runtime::save_state(&(&self.store.state, &self.own, &self.heard, &self.answer), state)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), StateError> {
        let answer: Vec<u8>;
        (self.store.state, self.own, self.heard, answer) = runtime::restore_state(state)?;
        if let Ok(said) = Diagnosis::read_from_bytes(&answer) {
            self.augment(&said);
        }
        Ok(())
    }

    fn journal(&self) -> &[u8] {
        self.store.journal()
    }

    fn take_journal(&mut self, journal: &[u8]) {
        self.store.take_journal(journal);
    }
}
