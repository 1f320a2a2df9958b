//! What the warden does about a death: restart, renewal of the services, giving up.

use super::ward::{DeathMark, State};
use super::{EXIT_FINAL, EXIT_STOPPED, EXIT_VANISHED, LineBuffer, Report, Warden};
use crate::config::GivenUp;
use crate::deaths::DeathRow;
use crate::sys::monotonic_ns;
use rustix::process::Signal;
use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;
use std::time::{Duration, Instant};
use telemetry::{HealthAction, HealthError, PartitionId};

impl Warden<'_> {
    /// Notices who has died before anything is done about it: what one death takes is no delay of
    /// the next one's notice.
    pub(super) fn bury(&mut self) -> Result<(), String> {
        let noticed: Vec<(usize, u64)> =
            (0..self.wards.len()).filter(|&at| self.wards[at].is_dead()).map(|at| (at, monotonic_ns())).collect();
        noticed.into_iter().try_for_each(|(index, noticed_ns)| self.bury_one(index, noticed_ns))
    }

    fn bury_one(&mut self, index: usize, noticed_ns: u64) -> Result<(), String> {
        self.wards[index].look();
        // Whoever was taken down with the one before has been buried.
        let State::Running { child, .. } = &mut self.wards[index].state else { return Ok(()) };
        let pid = child.id();
        let status = child.try_wait().map_err(|error| format!("waiting for {}: {error}", self.wards[index].id))?;
        let Some(status) = status else { return Ok(()) };
        let mut services_lost = status.code() == Some(EXIT_VANISHED) || self.wards[index].fails_again(status);
        if self.wards[index].id == PartitionId::Supervisor {
            self.listen_to_supervisor();
            self.pipe = LineBuffer::default();
            services_lost |= !self.services_exist;
        }
        self.after_death(index, pid, status, noticed_ns)?;
        if services_lost {
            self.renew_services()?;
        }
        Ok(())
    }

    /// Takes everybody down and has the supervisor make the services anew; checkpoints and outboxes
    /// carry the run over.
    ///
    /// Services vanish with the last process that holds them (who starts holds none yet), and one
    /// whose maker dies half-way bricks its name. Whoever had ended in order starts again too: its
    /// samples went with the services.
    pub(super) fn renew_services(&mut self) -> Result<(), String> {
        // All at once: what one leaves of its memory takes milliseconds.
        self.signal_running(Signal::KILL);
        for index in 0..self.wards.len() {
            let ward = &mut self.wards[index];
            match &mut ward.state {
                State::Waiting { .. } | State::GivenUp => continue,
                State::Done => {}
                State::Running { child, .. } => {
                    let (pid, noticed_ns) = (child.id(), monotonic_ns());
                    let _ = child.wait();
                    ward.cause = Signal::KILL.as_raw() as u32;
                    self.note_death(index, pid, "taken down, services have vanished", noticed_ns);
                }
            }
            // No death of its own: it does not count towards giving it up.
            let ward = &mut self.wards[index];
            ward.epoch += 1;
            ward.state = State::Waiting { until: Instant::now() };
        }
        (self.services_exist, self.first_end) = (false, None);
        self.pipe = LineBuffer::default();
        self.owned.dir().clear_services().map_err(|error| format!("services cannot be removed: {error}"))
    }

    /// Into the log; the figures of the life that ended are kept.
    pub(super) fn note_death(&mut self, index: usize, pid: u32, cause: &str, noticed_ns: u64) {
        let ward = &mut self.wards[index];
        let hung_ms = ward.hung_ms.take();
        ward.close_life(self.owned.dir(), &mut self.deaths);
        let (partition, epoch) = (ward.id.to_string(), ward.epoch);
        self.deaths.note(DeathRow {
            partition: partition.clone(),
            epoch,
            pid,
            cause: if hung_ms.is_some() { "hang".into() } else { cause.into() },
            t_s: noticed_ns.saturating_sub(self.started_ns) as f64 * 1e-9,
            noticed_ns,
            detect_ms: hung_ms.or(self.alertness.delay_ms(noticed_ns)),
            recover_ms: None,
        });
        self.tell(&Report::Death { partition, pid, cause: cause.into(), epoch, t_ns: noticed_ns });
    }

    pub(super) fn after_death(
        &mut self,
        index: usize,
        pid: u32,
        status: ExitStatus,
        noticed_ns: u64,
    ) -> Result<(), String> {
        let ward = &mut self.wards[index];
        let told_to_end = self.ending && status.code() == Some(EXIT_STOPPED);
        if status.success() || told_to_end {
            ward.state = State::Done;
            ward.close_life(self.owned.dir(), &mut self.deaths);
            self.first_end.get_or_insert_with(Instant::now);
            return Ok(());
        }
        ward.cause = status.signal().or(status.code().map(|code| 256 + code)).unwrap_or(0) as u32;
        let cause = match (status.code(), status.signal()) {
            (Some(code), _) => format!("exit code {code}"),
            (None, Some(signal)) => format!("signal {signal}"),
            (None, None) => "unknown".into(),
        };
        let error = if ward.hung_ms.is_some() { HealthError::Hang } else { error_of(status) };
        self.note_death(index, pid, &cause, noticed_ns);
        if status.code() == Some(EXIT_FINAL) {
            return Err(format!("{} cannot run: see its message", self.wards[index].id));
        }
        let is_last = self.note_recent_death(index);
        match self.judge(Some(index), error, is_last) {
            HealthAction::EndRun => {
                return Err(format!("{} {error}: the health table ends the run", self.wards[index].id));
            }
            HealthAction::GiveUp => return self.give_up(index),
            HealthAction::ColdRestart => self.forget(index),
            HealthAction::SafeMode | HealthAction::Restart => {}
        }
        let ward = &mut self.wards[index];
        let wait_ms = ward.wait_ms(&self.limits.of(ward.id).back_off_ms);
        ward.epoch += 1;
        self.supervisor_heard = Instant::now();
        ward.state = State::Waiting { until: Instant::now() + Duration::from_millis(wait_ms) };
        Ok(())
    }

    /// Whether it is one death too many for the row of the partition. Deaths count together while
    /// they are recent, or while nothing has moved on between them (a slow loop).
    fn note_recent_death(&mut self, index: usize) -> bool {
        let ward = &mut self.wards[index];
        let limits = self.limits.of(ward.id);
        let window = Duration::from_secs(limits.restarts_within_s);
        let (frame, reach) = (self.last_frame, 2 * self.window_frames);
        ward.deaths.retain(|death| death.at.elapsed() < window || death.frame + reach > frame);
        ward.deaths.push(DeathMark { at: Instant::now(), frame });
        ward.deaths.len() as u32 > limits.restarts_max
    }

    fn give_up(&mut self, index: usize) -> Result<(), String> {
        let ward = &mut self.wards[index];
        let (id, deaths) = (ward.id, ward.deaths.len());
        ward.state = State::GivenUp;
        self.tell(&Report::GivenUp { partition: id.to_string() });
        if self.limits.of(id).given_up == GivenUp::EndRun {
            return Err(format!("{id} was given up after {deaths} deaths"));
        }
        self.tell_supervisor(&format!("LOST {id}"));
        Ok(())
    }
}

/// How a process that was not killed for a hang came to its end.
fn error_of(status: ExitStatus) -> HealthError {
    let from_outside = [Signal::KILL, Signal::TERM, Signal::INT].map(Signal::as_raw);
    match status.signal() {
        Some(signal) if from_outside.contains(&signal) => HealthError::Kill,
        Some(_) => HealthError::Crash,
        None => HealthError::Exit,
    }
}
