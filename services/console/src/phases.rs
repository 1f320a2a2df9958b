//! Progress of a diagnosis: its phase, the share of the planned work that is done, and the time
//! that is left.
//!
//! The crates below count work and plan it; the clock is here. What is left takes the time that the
//! work so far has taken: `left = elapsed (1 − share) / share`, by the last plan.

use crate::progress;
use discovery::diagnose::Phase;
use identification::work::Watch;
use indicatif::ProgressBar;
use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two looks at the count.
const LOOK: Duration = Duration::from_millis(100);
/// The time from which on a pace is known.
const PACE_KNOWN_S: f64 = 1.0;
/// Growth of the share from one line to the next where there is no terminal, and change of the
/// whole time that is a line of its own.
const LINE_SHARE: f64 = 0.05;
const LINE_CHANGE: f64 = 0.25;

/// What is being done, in the order of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The channel metadata are checked.
    Labels,
    /// The recordings are examined.
    Examine,
    /// The search itself.
    Search(Phase),
}

impl Stage {
    /// `look at the labels`.
    pub fn words(self) -> &'static str {
        match self {
            Stage::Labels => "look at the labels",
            Stage::Examine => "examine the recordings",
            Stage::Search(phase) => phase.words(),
        }
    }
}

/// Progress on standard error: a bar on a terminal, else lines where they are asked for.
pub struct Phases {
    stage: Arc<Mutex<&'static str>>,
    lines: bool,
    /// Its end stops the display.
    display: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Phases {
    /// Of the work that `watch` sees.
    pub fn new(watch: Watch, lines: bool) -> Self {
        let stage = Arc::new(Mutex::new("begin"));
        let is_terminal = std::io::stderr().is_terminal();
        let display = (is_terminal || lines).then(|| {
            let (end, ended) = channel();
            let stage = stage.clone();
            let show = move || if is_terminal { bar(&watch, &stage, &ended) } else { line_by_line(&watch, &ended) };
            (end, std::thread::spawn(show))
        });
        Phases { stage, lines: lines && !is_terminal, display }
    }

    /// `stage` begins.
    pub fn begin(&self, stage: Stage) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage.words();
        if self.lines {
            crate::tell(stage.words());
        }
    }

    /// Ends the display; removes the bar from the terminal.
    pub fn end(self) {
        if let Some((end, display)) = self.display {
            drop(end);
            // what a display failed of is no failure of the diagnosis
            let _ = display.join();
        }
    }
}

/// Moves a bar until `ended`.
fn bar(watch: &Watch, stage: &Mutex<&'static str>, ended: &Receiver<()>) {
    let bar: ProgressBar = progress::of_shares("{elapsed_precise} [{bar:30}] {percent} %, {msg}");
    let begun = Instant::now();
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let share = watch.share();
        bar.set_position((share * progress::PARTS) as u64);
        let phase = *stage.lock().unwrap_or_else(PoisonError::into_inner);
        let phase = if watch.is_stopped() { "end with what is known" } else { phase };
        let left = left_s(begun.elapsed().as_secs_f64(), watch.outlook());
        bar.set_message(left.map_or(phase.to_owned(), |left| format!("{phase}, {}", time_left(left))));
    }
    bar.finish_and_clear();
}

/// A line for each twentieth of the work, and where the end is elsewhere than was said.
fn line_by_line(watch: &Watch, ended: &Receiver<()>) {
    let (mut told, mut told_s) = (0.0, 0.0);
    let begun = Instant::now();
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let (share, elapsed_s) = (watch.share(), begun.elapsed().as_secs_f64());
        let Some(left_s) = left_s(elapsed_s, watch.outlook()) else { continue };
        let whole_s = elapsed_s + left_s;
        if share >= told + LINE_SHARE || (whole_s - told_s).abs() > LINE_CHANGE * told_s {
            (told, told_s) = (share, whole_s);
            crate::tell(&format!("{:.0} %, {}", 100.0 * share, time_left(left_s)));
        }
    }
}

/// Time that is left at `elapsed_s` of work of which `share` is done; `None` where no pace is
/// known.
fn left_s(elapsed_s: f64, share: f64) -> Option<f64> {
    (elapsed_s >= PACE_KNOWN_S && share > 0.0).then(|| elapsed_s * (1.0 - share).max(0.0) / share)
}

/// `about 40 s left`, with one or two figures.
fn time_left(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("about {} s left", s.ceil().max(1.0)),
        s if s < 100.0 => format!("about {} s left", 5.0 * (s / 5.0).round()),
        s if s < 5400.0 => format!("about {} min left", (s / 60.0).round()),
        s => format!("about {} h left", (s / 3600.0).round()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_told_in_the_unit_it_is_thought_of_in() {
        let told = [0.2, 7.3, 42.0, 130.0, 7300.0].map(time_left);
        let expected = ["1 s", "8 s", "40 s", "2 min", "2 h"].map(|time| format!("about {time} left"));
        assert_eq!(told, expected);
    }

    #[test]
    fn what_is_left_takes_the_time_that_the_work_so_far_has_taken() {
        assert_eq!(left_s(0.5, 0.1), None);
        assert_eq!(left_s(10.0, 0.25), Some(30.0));
        assert_eq!(left_s(20.0, 1.0), Some(0.0));
    }
}
