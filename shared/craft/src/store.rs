//! Rows of arcs, kept frame by frame in memory taken at the start.

use crate::rows::RowShape;
use channels::Recording;
use dynamics::description::Plant;
use plant_file::scenario::{ArcError, ArcPlan, CraftPlan};
use runtime::Frame;
use runtime::experiment::{ExperimentWindow, Step};
use serde::{Deserialize, Serialize};
use telemetry::{CRAFT, Experiment};

/// An arc, as the scenario states it.
pub struct StoredArc {
    /// Its number in the scenario.
    pub number: usize,
    pub name: String,
    /// What is known of the craft, with the commands of the arc.
    pub plant: Plant,
    pub experiment: Experiment,
    shape: RowShape,
}

/// What is kept of an arc: its rows, in the bytes of all, and whether every frame of it was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Kept {
    begin: usize,
    end: usize,
    whole: bool,
}

/// What a restart needs beside the rows.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct StoreState {
    window: ExperimentWindow,
    kept: Vec<Kept>,
}

/// The arcs of a partition.
pub struct Store {
    pub arcs: Vec<StoredArc>,
    experiments: Vec<Experiment>,
    pub state: StoreState,
    /// Rows of all arcs, one behind the other.
    rows: Vec<u8>,
}

impl Store {
    /// Of the arcs of `craft` that `is_kept` chooses.
    ///
    /// # Errors
    /// The plant of an arc cannot be made.
    pub fn new(craft: &CraftPlan, is_kept: impl Fn(&ArcPlan) -> bool) -> Result<Self, ArcError> {
        let mut arcs = Vec::new();
        let mut bytes = 0;
        for (number, arc) in craft.arcs.iter().enumerate().filter(|(_, arc)| is_kept(arc)) {
            let plant = craft.known(arc)?;
            let shape = RowShape::of(&plant);
            bytes += (arc.duration_s / plant.simulation.period_s).ceil() as usize * shape.bytes();
            arcs.push(StoredArc { number, name: arc.name.clone(), plant, shape, experiment: arc.experiment.code() });
        }
        let state = StoreState { kept: vec![Kept::default(); arcs.len()], ..StoreState::default() };
        let experiments = arcs.iter().map(|arc| arc.experiment).collect();
        Ok(Self { arcs, experiments, state, rows: Vec::with_capacity(bytes) })
    }

    /// The arc that is flown: experiments are counted from 1, arcs from 0.
    fn flown(&self) -> Option<usize> {
        let number = self.state.window.generation.checked_sub(1)? as usize;
        self.arcs.iter().position(|arc| arc.number == number)
    }

    /// Takes the rows of `frame`; the arc that is whole with it.
    pub fn take(&mut self, frame: &Frame<'_>) -> Option<usize> {
        let step = self.state.window.step(frame, &self.experiments);
        if step == Step::Abort {
            self.state.kept.iter_mut().filter(|kept| !kept.whole).for_each(|kept| *kept = Kept::default());
        }
        let arc = self.flown()?;
        match step {
            Step::Idle | Step::Abort => None,
            Step::Begin | Step::Go => {
                if step == Step::Begin {
                    let at = self.rows.len();
                    self.state.kept[arc] = Kept { begin: at, end: at, whole: false };
                }
                self.append(arc, frame);
                None
            }
            Step::Close => {
                self.state.kept[arc].whole = true;
                Some(arc)
            }
        }
    }

    fn append(&mut self, arc: usize, frame: &Frame<'_>) {
        for row in frame.samples(CRAFT) {
            // rows of another arc lie behind their own end
            if self.state.kept[arc].end == self.rows.len() && self.rows.len() < self.rows.capacity() {
                self.arcs[arc].shape.append(row, &mut self.rows);
                self.state.kept[arc].end = self.rows.len();
            }
        }
    }

    /// Every frame of the arc was seen.
    #[must_use]
    pub fn is_whole(&self, arc: usize) -> bool {
        self.state.kept[arc].whole
    }

    /// What is kept of an arc; `None` where its rows are lost.
    #[must_use]
    pub fn recording(&self, arc: usize) -> Option<Recording> {
        let (own, kept) = (&self.arcs[arc], self.state.kept[arc]);
        Some(own.shape.recording(&own.name, &own.plant, self.rows.get(kept.begin..kept.end)?))
    }

    /// All rows, for a checkpoint.
    #[must_use]
    pub fn journal(&self) -> &[u8] {
        &self.rows
    }

    /// Takes back what [`Store::journal`] was.
    pub fn take_journal(&mut self, journal: &[u8]) {
        self.rows.clear();
        self.rows.extend_from_slice(journal);
    }
}
