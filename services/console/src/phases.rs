//! Progress of a diagnosis: its phase, and how much of its limit of work is spent.
//!
//! How many rounds a search needs is known at its end, so that no time of the end is promised: told
//! is the time in which the limit is met at the pace so far, which is the most that is left.

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
const PACE_KNOWN: Duration = Duration::from_secs(2);

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

/// Phases on standard error: a bar on a terminal, else a line for each where they are asked for.
pub struct Phases {
    stage: Arc<Mutex<&'static str>>,
    lines: bool,
    /// Its end stops the bar.
    bar: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Phases {
    /// The work that `watch` sees is at most about `most`.
    pub fn new(watch: Watch, most: f64, lines: bool) -> Self {
        let stage = Arc::new(Mutex::new("begin"));
        let is_terminal = std::io::stderr().is_terminal();
        let bar = is_terminal.then(|| {
            let (end, ended) = channel();
            let stage = stage.clone();
            (end, std::thread::spawn(move || show(&watch, most, &stage, &ended)))
        });
        Phases { stage, lines: lines && !is_terminal, bar }
    }

    /// `stage` begins.
    pub fn begin(&self, stage: Stage) {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner) = stage.words();
        if self.lines {
            crate::tell(stage.words());
        }
    }

    /// Removes the bar from the terminal.
    pub fn end(self) {
        if let Some((end, bar)) = self.bar {
            drop(end);
            // what a bar failed of is no failure of the diagnosis
            let _ = bar.join();
        }
    }
}

/// Moves the bar until `ended`.
fn show(watch: &Watch, most: f64, stage: &Mutex<&'static str>, ended: &Receiver<()>) {
    let bar: ProgressBar = progress::of_shares("{elapsed_precise} [{bar:30}] {percent} % of the limit, {msg}");
    let begun = Instant::now();
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let share = (watch.counted() / most).clamp(0.0, 1.0);
        bar.set_position((share * progress::PARTS) as u64);
        let phase = *stage.lock().unwrap_or_else(PoisonError::into_inner);
        let phase = if watch.is_stopped() { "end with what is known" } else { phase };
        let elapsed = begun.elapsed();
        let left = (elapsed > PACE_KNOWN && share > 0.0).then(|| elapsed.as_secs_f64() * (1.0 - share) / share);
        bar.set_message(left.map_or(phase.to_owned(), |left| format!("{phase}, {}", time_left(left))));
    }
    bar.finish_and_clear();
}

/// `at most about 40 s left`, with one or two figures.
fn time_left(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("at most about {} s left", s.ceil().max(1.0)),
        s if s < 100.0 => format!("at most about {} s left", 10.0 * (s / 10.0).round()),
        s if s < 5400.0 => format!("at most about {} min left", (s / 60.0).round()),
        s => format!("at most about {} h left", (s / 3600.0).round()),
    }
}

#[cfg(test)]
mod tests {
    use super::time_left;

    #[test]
    fn a_time_is_told_in_the_unit_it_is_thought_of_in() {
        let told = [0.2, 7.3, 42.0, 130.0, 7300.0].map(time_left);
        let expected = ["1 s", "8 s", "40 s", "2 min", "2 h"].map(|time| format!("at most about {time} left"));
        assert_eq!(told, expected);
    }
}
