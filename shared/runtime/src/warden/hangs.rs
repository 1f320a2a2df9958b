//! Who lives and does nothing: the supervisor's word, its own silence, and a run that stands still.

use super::ward::State;
use super::{RENEW_AFTER, Report, START_LIMIT, TICK, WORK_STALLS, Warden};
use rustix::process::{Pid, Signal, kill_process};
use std::io::Write;
use std::time::{Duration, Instant};
use telemetry::PartitionId;

impl Warden<'_> {
    pub(super) fn tell_supervisor(&mut self, line: &str) {
        for ward in &mut self.wards {
            if let (PartitionId::Supervisor, State::Running { child, .. }) = (ward.id, &mut ward.state)
                && let Some(stdin) = &mut child.stdin
            {
                // A dying supervisor receives the order again after its restart.
                let _ = writeln!(stdin, "{line}");
            }
        }
    }

    pub(super) fn listen_to_supervisor(&mut self) {
        let running = self.wards.iter_mut().find(|ward| ward.id == PartitionId::Supervisor);
        let Some(State::Running { child, .. }) = running.map(|ward| &mut ward.state) else { return };
        let Some(stdout) = &mut child.stdout else { return };
        let lines = self.pipe.read(stdout);
        // A process that dies closes its pipe before its end can be seen.
        child.stdout.take_if(|_| self.pipe.is_closed);
        for line in lines {
            (self.supervisor_heard, self.supervisor_spoke) = (Instant::now(), true);
            self.obey(&line);
        }
    }

    pub(super) fn end_supervisor_hang(&mut self) {
        let hang = Duration::from_millis(self.limits.of(PartitionId::Supervisor).hang_ms);
        let limit = if self.supervisor_spoke { hang } else { hang.max(START_LIMIT) };
        if !self.services_exist || self.supervisor_heard.elapsed() < limit {
            return;
        }
        let silent_ms = self.supervisor_heard.elapsed().as_secs_f64() * 1e3;
        self.supervisor_heard = Instant::now();
        let epoch = self.wards.iter().find(|ward| ward.id == PartitionId::Supervisor).map_or(0, |ward| ward.epoch);
        self.end_hang(PartitionId::Supervisor.text(), &epoch.to_string(), silent_ms);
    }

    pub(super) fn obey(&mut self, line: &str) {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["READY"] => {
                self.services_exist = true;
                let lost: Vec<_> =
                    self.wards.iter().filter(|w| matches!(w.state, State::GivenUp)).map(|w| w.id).collect();
                for id in lost {
                    self.tell_supervisor(&format!("LOST {id}"));
                }
            }
            ["STATUS", frame, mode] => {
                let frame = frame.parse().unwrap_or(self.last_frame);
                if frame > self.last_frame {
                    self.last_frame = frame;
                    self.last_advance = Instant::now();
                    self.renew_after = RENEW_AFTER;
                }
                self.note_mode(mode);
                let mode = mode.to_string();
                let _ = std::fs::write(
                    self.owned.dir().status(),
                    serde_json::json!({ "frame": frame, "mode": mode }).to_string(),
                );
                self.tell(&Report::Status { frame, mode });
            }
            ["WORKS", _] => self.last_work = Instant::now(),
            ["WAITS", ..] => self.waits = line["WAITS".len()..].trim_start().to_string(),
            ["HANG", name, epoch, silent_ms] => self.end_hang(name, epoch, silent_ms.parse().unwrap_or(0.0)),
            ["SILENT", name] => self.end_silence(name),
            _ => crate::sys::tell(&format!("the supervisor said something unknown: {line}\n")),
        }
    }

    /// A supervisor that has come back never hears who hung before: a hang, unless that one has
    /// just been started.
    pub(super) fn end_silence(&mut self, name: &str) {
        let Some(ward) = self.wards.iter().find(|ward| ward.id.text() == name) else { return };
        let limit = Duration::from_millis(self.limits.of(ward.id).hang_ms).max(START_LIMIT);
        let epoch = ward.epoch.to_string();
        if let State::Running { since, .. } = ward.state
            && since.elapsed() >= limit
        {
            self.end_hang(name, &epoch, since.elapsed().as_secs_f64() * 1e3);
        }
    }

    /// Who does nothing before its first sign of life: no other process knows of it yet.
    pub(super) fn end_still(&mut self) {
        if self.last_still.elapsed() < TICK {
            return;
        }
        self.last_still = Instant::now();
        for index in 0..self.wards.len() {
            let ward = &mut self.wards[index];
            let limit = Duration::from_millis(self.limits.of(ward.id).hang_ms);
            let Some(still) = ward.still().filter(|still| *still >= limit) else { continue };
            let (name, epoch) = (ward.id.text(), ward.epoch.to_string());
            self.end_hang(name, &epoch, still.as_secs_f64() * 1e3);
        }
    }

    pub(super) fn end_hang(&mut self, name: &str, epoch: &str, silent_ms: f64) {
        let Some(index) = self.wards.iter().position(|ward| ward.id.text() == name) else { return };
        if self.wards[index].epoch.to_string() != epoch {
            // Of a life that is over: its next one has not been heard.
            return self.tell_supervisor(&format!("RENEWED {name}"));
        }
        let Some(pid) = self.wards[index].pid() else { return };
        let ward = &mut self.wards[index];
        if ward.is_starved(pid, silent_ms) {
            self.tell_supervisor(&format!("STARVED {name}"));
            return self.tell(&Report::Starved { partition: name.into() });
        }
        ward.hung_ms = Some(silent_ms);
        if let State::Running { child, .. } = &ward.state {
            let _ = kill_process(Pid::from_child(child), Signal::KILL);
        }
        self.tell(&Report::Hang { partition: name.into() });
    }

    /// Processes that live and do no frame: services that cannot be used any more. Renewed they are
    /// as good as new; a run that stands still all the same has failed.
    pub(super) fn end_stall(&mut self) -> Result<(), String> {
        let still = self.last_advance.elapsed();
        // who works beside its loop does no frame and is well; but no work lasts for ever
        let idle = still.min(self.last_work.elapsed());
        let limit = Duration::from_secs(self.limits.stall_s);
        let passed = [(idle, limit), (still, limit * WORK_STALLS)].into_iter().find(|(waited, most)| waited > most);
        if let Some((_, most)) = passed {
            let waits = if self.waits.is_empty() { String::new() } else { format!("{}: ", self.waits) };
            let (seconds, last) = (most.as_secs(), self.last_frame);
            return Err(format!("{waits}no frame was processed for {seconds} s (last: {last})"));
        }
        if idle > self.renew_after && self.services_exist && self.first_end.is_none() {
            self.renew_after = still + self.renew_after * 2;
            self.tell(&Report::Stall { waits: self.waits.clone(), since_s: still.as_secs_f64() });
            self.judge_stall()?;
            self.renew_services()?;
        }
        Ok(())
    }
}
