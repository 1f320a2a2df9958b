//! What the supervisor's process does about the words of the warden.

use super::{Process, ProcessError};
use crate::pacing::GIVEN_UP;
use crate::watch::Told;
use telemetry::{COMMAND, Command, EventCode, Header, Opcode, PartitionId};

impl Process<'_> {
    /// Reports what was done about errors, makes the vehicle safe, spreads who was given up.
    pub(super) fn obey_warden(&mut self, told: Option<Told>) -> Result<(), ProcessError> {
        let Some(told) = told else { return Ok(()) };
        for act in told.acts {
            let (arguments, used) = act.arguments();
            self.runner.event_as(act.severity(), EventCode::HealthActed, &arguments[..used])?;
        }
        if told.safe {
            self.runner.take_own_command(Opcode::Safe, PartitionId::Supervisor.code())?;
        }
        for lost in told.lost {
            self.runner.publish_status(COMMAND, &give_up(lost))?;
            self.runner.event(EventCode::GivenUp, &[lost.code().into()])?;
            self.runner.link_mut().bury_the_dead();
            self.wake_everybody();
        }
        Ok(())
    }
}

fn give_up(lost: PartitionId) -> Command {
    Command { header: Header::at(0), id: u64::from(lost.code()), opcode: GIVEN_UP, argument: lost.code().into() }
}
