//! One partition in the warden's care: its process, its deaths, the figures of all its lives.

use super::START_LIMIT;
use super::looks::Looks;
use super::window::{self, Window};
use crate::config::PartitionLimits;
use crate::deaths::DeathLog;
use crate::rundir::RunDir;
use crate::statistics::{LifeFigures, PartitionRow};
use crate::usage::{self, Activity, Usage};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fd::OwnedFd;
use rustix::process::Signal;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, ExitStatus};
use std::time::{Duration, Instant};
use telemetry::PartitionId;

/// Of the time in which nothing was heard: one of the three beats. One is slept away regularly, and
/// a process that hangs waits for no processor at all, unless it loops.
const STARVED_SHARE: f64 = 1.0 / 3.0;
/// Of its window: a process that is let wait by the kernel has used all of it, but for what the
/// first and the last period of the silence hide.
const THROTTLED_SHARE: f64 = 0.5;
/// Silent again within this time: the same want of a processor.
const STARVED_AGAIN: Duration = Duration::from_secs(1);
/// A loop without end on a busy computer waits for a processor most of the time, too: it is ended
/// after half a minute of three beats each.
const STARVED_TIMES_MAX: u32 = 200;

/// Where a partition stands.
pub(super) enum State {
    Waiting { until: Instant },
    Running { child: Child, pidfd: OwnedFd, since: Instant },
    Done,
    GivenUp,
}

/// When a partition died, and how far the run was.
pub(super) struct DeathMark {
    pub at: Instant,
    pub frame: u64,
}

/// A partition, and what is known of its lives.
pub(super) struct Ward {
    pub id: PartitionId,
    pub state: State,
    pub deaths: Vec<DeathMark>,
    pub epoch: u32,
    /// Of the last death, as in [`crate::life::Life`].
    pub cause: u32,
    /// Killed for a hang: since its last sign of life \[ms\].
    pub hung_ms: Option<f64>,
    /// What it was seen to have done before anybody expects to hear it, and when that was new.
    last_act: Option<(Activity, Instant)>,
    /// Of the lives that are over, and of the present one as last looked at.
    past: LifeFigures,
    looks: Looks,
    starved_at: Option<Instant>,
    starved_times: u32,
    /// Its last life ended by a fault of its own, and nothing was made of it.
    failed: bool,
    /// Lives in a row that ended before a frame of samples newer than their start.
    lives_in_vain: usize,
    past_usage: Usage,
    usage: Usage,
    /// CPU window of the present or last life.
    window: Window,
    has_window: bool,
}

impl Ward {
    pub fn new(id: PartitionId) -> Self {
        Ward {
            id,
            state: State::Waiting { until: Instant::now() },
            deaths: Vec::new(),
            epoch: 0,
            cause: 0,
            hung_ms: None,
            last_act: None,
            past: LifeFigures::default(),
            looks: Looks::default(),
            starved_at: None,
            starved_times: 0,
            failed: false,
            lives_in_vain: 0,
            past_usage: Usage::default(),
            usage: Usage::default(),
            window: Window::default(),
            has_window: false,
        }
    }

    /// Gives a life that has begun its work the window of `row`; says which, once a life.
    pub fn give_window(&mut self, row: &PartitionLimits) -> Option<&str> {
        let State::Running { child, since, .. } = &self.state else { return None };
        if self.has_window || since.elapsed() < window::AFTER {
            return None;
        }
        (self.window, self.has_window) = (window::give(child.id(), row), true);
        Some(&self.window.text)
    }

    pub fn is_over(&self) -> bool {
        matches!(self.state, State::Done | State::GivenUp)
    }

    /// Process id, while one runs.
    pub fn pid(&self) -> Option<u32> {
        if let State::Running { child, .. } = &self.state { Some(child.id()) } else { None }
    }

    /// Its process has ended and is not waited for yet.
    pub fn is_dead(&self) -> bool {
        let State::Running { pidfd, .. } = &self.state else { return false };
        let now = Timespec { tv_sec: 0, tv_nsec: 0 };
        poll(&mut [PollFd::new(pidfd, PollFlags::IN)], Some(&now)).is_ok_and(|count| count > 0)
    }

    /// What the kernel counts of its process; of a dead one, before it is waited for, all but
    /// sizes.
    pub fn look(&mut self) {
        let Some(mut now) = self.pid().and_then(Usage::of) else { return };
        now.keep_sizes(&self.usage);
        self.looks.note(Instant::now(), &now);
        self.usage = now;
    }

    /// Whether it ended by a fault of its own (no signal from outside), and the life before, too:
    /// what both used is broken, and only the services are common
    /// to both.
    pub fn fails_again(&mut self, status: ExitStatus) -> bool {
        let from_outside = [Signal::KILL, Signal::TERM].map(|signal| Some(signal.as_raw())).contains(&status.signal());
        let failed = !from_outside && !status.success() && status.code().is_none_or(|code| code == 1);
        let again = failed && self.failed;
        self.failed = failed && !again;
        again
    }

    /// Whether its process is silent for lack of a processor: it waited for one for a good part of
    /// the time since its last sign of life, or has used up its window. Who computes without a
    /// window, sleeps or is stopped is not starved.
    pub fn is_starved(&mut self, pid: u32, silent_ms: f64) -> bool {
        let now = Usage::of(pid).unwrap_or_default();
        let silence = Duration::try_from_secs_f64(silent_ms * 1e-3).ok();
        let since = silence.and_then(|silence| Instant::now().checked_sub(silence));
        let (waited_before_s, ran_before_s) = self.looks.before(since);
        self.looks.note(Instant::now(), &now);
        let is_kept_waiting = (now.wait_s - waited_before_s) * 1e3 > STARVED_SHARE * silent_ms;
        let ran_ms = (now.run_s - ran_before_s) * 1e3;
        let is_throttled =
            self.has_window && self.window.share.is_some_and(|share| ran_ms > THROTTLED_SHARE * share * silent_ms);
        let starved = usage::state(pid) != Some('T') && (is_kept_waiting || is_throttled);
        let again = self.starved_at.replace(Instant::now()).is_some_and(|at| at.elapsed() < STARVED_AGAIN);
        self.starved_times = if again { self.starved_times + 1 } else { 1 };
        starved && self.starved_times <= STARVED_TIMES_MAX
    }

    /// For how long a life younger than [`START_LIMIT`] has done nothing: it is stopped, or sleeps
    /// and is not woken. Whoever starts waits for nobody so long. An older life is watched by its
    /// signs of life.
    pub fn still(&mut self) -> Option<Duration> {
        let State::Running { child, since, .. } = &self.state else { return None };
        let young = (since.elapsed() < START_LIMIT).then(|| child.id());
        let now = young.and_then(Activity::of).filter(|now| !now.busy);
        self.last_act = now.map(|now| match self.last_act {
            Some((before, at)) if before == now => (now, at),
            _ => (now, Instant::now()),
        });
        self.last_act.map(|(_, at)| at.elapsed())
    }

    /// Start of its next life; `None` where it waits for none.
    pub fn due(&self, services_exist: bool) -> Option<Instant> {
        let State::Waiting { until } = self.state else { return None };
        (self.id == PartitionId::Supervisor || services_exist).then_some(until)
    }

    /// What its process has left of this life.
    pub fn figures(&self, dir: &RunDir) -> Option<LifeFigures> {
        LifeFigures::read(&dir.statistics(self.id)).filter(|figures| figures.epoch == self.epoch)
    }

    /// A life is over: its figures are kept.
    pub fn close_life(&mut self, dir: &RunDir, log: &mut DeathLog) {
        let figures = self.figures(dir);
        let worked = figures.as_ref().is_some_and(|figures| figures.fresh_ns.is_some());
        self.lives_in_vain = if worked { 0 } else { self.lives_in_vain + 1 };
        if let Some(figures) = figures {
            figures.fresh_ns.into_iter().for_each(|fresh_ns| log.recovered(self.id.text(), self.epoch, fresh_ns));
            self.past.add(&figures);
            // A life that came to a fresh frame had what it needs.
            self.failed &= figures.fresh_ns.is_none();
        }
        (self.has_window, self.looks, self.last_act) = (false, Looks::default(), None);
        self.past_usage.add(&core::mem::take(&mut self.usage));
    }

    /// Wait before its next life \[ms\]: a back-off breaks a loop of starts that fail, and a life
    /// that worked ends such a loop.
    pub fn wait_ms(&self, back_off_ms: &[u64]) -> u64 {
        let wait = back_off_ms.get(self.lives_in_vain.saturating_sub(1)).or(back_off_ms.last());
        wait.copied().unwrap_or(0)
    }

    /// Its row of the table, over all lives that are over.
    pub fn row(&self) -> PartitionRow {
        PartitionRow {
            restarts: self.epoch,
            restart_cause: self.cause,
            given_up: matches!(self.state, State::GivenUp),
            cpu_window: self.window.text.clone(),
            ..self.past.row(self.id.text(), self.past_usage)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::process::{Pid, PidfdFlags, kill_process, pidfd_open};

    fn started(words: &[&str]) -> (Ward, Pid) {
        let child = std::process::Command::new(words[0]).args(&words[1..]).spawn().unwrap();
        let pid = Pid::from_child(&child);
        let pidfd = pidfd_open(pid, PidfdFlags::empty()).unwrap();
        let mut ward = Ward::new(PartitionId::SloshId);
        ward.state = State::Running { child, pidfd, since: Instant::now() };
        (ward, pid)
    }

    fn end(mut ward: Ward) {
        let State::Running { child, .. } = &mut ward.state else { unreachable!() };
        child.kill().unwrap();
        child.wait().unwrap();
    }

    /// Until it has been seen to do nothing for so long.
    fn seen_still(ward: &mut Ward, limit: Duration) {
        while ward.still().is_none_or(|still| still < limit) {
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_young_life_that_is_stopped_or_sleeps_for_ever_is_seen_and_one_that_goes_on_begins_anew() {
        const LIMIT: Duration = Duration::from_millis(20);
        let (mut ward, pid) = started(&["sleep", "60"]);
        seen_still(&mut ward, LIMIT);
        let before = ward.last_act.unwrap();
        for signal in [Signal::STOP, Signal::CONT] {
            // A signal wakes it: what it does then begins its silence anew.
            kill_process(pid, signal).unwrap();
            seen_still(&mut ward, LIMIT);
        }
        assert!(ward.last_act.unwrap().1 > before.1);
        let State::Running { since, .. } = &mut ward.state else { unreachable!() };
        *since -= START_LIMIT;
        assert_eq!(ward.still(), None, "an older one is watched by its signs of life");
        end(ward);
    }

    #[test]
    fn a_young_life_that_computes_or_wakes_again_and_again_is_not_still() {
        let (mut ward, _) = started(&["sh", "-c", "while :; do :; done"]);
        while Activity::of(ward.pid().unwrap()).is_none_or(|activity| activity.run_ns < 300_000_000) {
            assert_eq!(ward.still().filter(|still| *still >= Duration::from_millis(150)), None);
        }
        end(ward);
    }

    #[test]
    fn waits_grow_with_lives_that_came_to_nothing_and_begin_again_after_one_that_worked() {
        let folder = std::env::temp_dir().join(format!("obsid-ward-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (dir, mut log) = (RunDir::at(&folder), DeathLog::default());
        let mut ward = Ward::new(PartitionId::SloshId);
        let mut wait_after = |ward: &mut Ward, fresh_ns| {
            let figures = LifeFigures { epoch: ward.epoch, fresh_ns, ..LifeFigures::default() };
            let path = dir.statistics(ward.id);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, serde_json::to_vec(&figures).unwrap()).unwrap();
            ward.close_life(&dir, &mut log);
            ward.epoch += 1;
            ward.wait_ms(&[0, 50, 200])
        };
        let waits = [Some(1), Some(2), None, None, None, None, Some(3), None].map(|fresh| wait_after(&mut ward, fresh));
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(waits, [0, 0, 0, 50, 200, 200, 0, 0]);
    }
}
