//! What the health table makes of an error, and how the supervisor comes to know.

use super::ward::State;
use super::{Report, Warden};
use crate::checkpoint::Store;
use crate::config::RunConfig;
use crate::health::{HealthAct, Ladder};
use crate::sys::monotonic_ns;
use telemetry::{HealthAction, HealthError, ModeState, PartitionId};

/// The health table at work, and what of it the supervisor has still to hear.
pub(super) struct HealthDesk {
    ladder: Ladder,
    acts: Vec<HealthAct>,
    /// The vehicle is to be made safe, and no status of the mode SAFE has come since.
    is_safe_owed: bool,
    /// Its present life has the order.
    pub is_safe_said: bool,
}

impl HealthDesk {
    pub fn new(run: &RunConfig) -> Self {
        let ladder = Ladder::new(&run.limits.health, &run.partitions);
        HealthDesk { ladder, acts: Vec::new(), is_safe_owed: false, is_safe_said: false }
    }
}

impl Warden<'_> {
    /// What is done about an error: of the ward `index`, or of the run. `is_last`: the partition
    /// has died too often for its row.
    pub(super) fn judge(&mut self, index: Option<usize>, error: HealthError, is_last: bool) -> HealthAction {
        let id = index.map(|index| self.wards[index].id);
        let mut act = self.health.ladder.judge(id, error, monotonic_ns());
        if is_last {
            act.action = act.action.max(HealthAction::GiveUp);
        }
        if act.action == HealthAction::SafeMode {
            (self.health.is_safe_owed, self.health.is_safe_said) = (true, false);
        }
        if act.action > HealthAction::Restart {
            self.tell(&Report::Health(act));
        }
        self.health.acts.push(act);
        act.action
    }

    /// Of a run that stands still although its services were made anew.
    pub(super) fn judge_stall(&mut self) -> Result<(), String> {
        match self.judge(None, HealthError::Stall, false) {
            HealthAction::EndRun => Err("no frame was processed: the health table ends the run".into()),
            _ => Ok(()),
        }
    }

    /// Cold restart: the next life of the ward finds no checkpoint.
    pub(super) fn forget(&mut self, index: usize) {
        let id = self.wards[index].id;
        if let Err(error) = Store::new(&self.owned.dir().own(id), id.text()).clear() {
            // A warm restart is the milder action, and the run goes on.
            crate::sys::tell(&format!("{id}: its checkpoint cannot be removed: {error}\n"));
        }
    }

    /// Tells the supervisor what was done since it last listened. A safe order is repeated to each
    /// of its lives until the mode is SAFE: one that dies with the order in its pipe loses none.
    pub(super) fn tell_acts(&mut self) {
        let is_up =
            |ward: &super::Ward| ward.id == PartitionId::Supervisor && matches!(ward.state, State::Running { .. });
        if !self.supervisor_spoke || !self.wards.iter().any(is_up) {
            return;
        }
        for act in core::mem::take(&mut self.health.acts) {
            self.tell_supervisor(&act.line());
        }
        if self.health.is_safe_owed && !self.health.is_safe_said {
            self.health.is_safe_said = true;
            self.tell_supervisor("SAFE");
        }
    }

    /// The mode in effect, as the supervisor last said.
    pub(super) fn note_mode(&mut self, mode: &str) {
        self.health.is_safe_owed &= mode != ModeState::Safe.text();
    }
}
