//! Progress of a diagnosis: its phase, the share of the planned work that is done, and the time
//! that is left.
//!
//! A terminal has a bar. Elsewhere a log has a line for each tenth of the work: what decides is the
//! work that is counted, so that a short diagnosis has no line and one of minutes is never silent
//! for long.
//!
//! The crates below count work and plan it; the clock is here. What is left takes the time that the
//! work so far has taken: `left = elapsed (1 − share) / share`, by the last plan. A search may
//! find more to compare than was planned; what its limit still allows is said beside that.

use crate::progress;
use discovery::diagnose::Phase;
use identification::work::{OVERRUN, Watch};
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
/// What the limit allows is said where it is so many times what is planned.
const ALLOWED_RATIO: f64 = 2.0;
/// Growth of the share from one line of a log to the next.
const LOGGED_SHARE: f64 = 0.1;
/// Work from one line of a log to the next: about 5 to 30 s of one core.
const LOGGED_WORK: [f64; 2] = [5e9, 3e10];
/// Growth of the share from one line to the next where every phase is a line, and change of the
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

/// How much of the progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Nothing.
    Nothing,
    /// A bar on a terminal, else a line for each tenth of the work.
    Share,
    /// A bar on a terminal, else a line for each phase and each twentieth of the work.
    Phases,
}

/// Progress on standard error.
pub struct Phases {
    stage: Arc<Mutex<&'static str>>,
    lines: bool,
    /// Its end stops the display.
    display: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Phases {
    /// Of the work that `watch` sees, which has the limit `most`.
    pub fn new(watch: Watch, most: f64, shown: Shown) -> Self {
        let stage = Arc::new(Mutex::new("begin"));
        let is_terminal = std::io::stderr().is_terminal();
        let display = (shown != Shown::Nothing).then(|| {
            let (end, ended) = channel();
            let stage = stage.clone();
            let show = move || match shown {
                _ if is_terminal => bar(&watch, most, &stage, &ended),
                Shown::Phases => line_by_line(&watch, most, &ended),
                _ => log(&watch, most, &stage, &ended),
            };
            (end, std::thread::spawn(show))
        });
        Phases { stage, lines: shown == Shown::Phases && !is_terminal, display }
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
fn bar(watch: &Watch, most: f64, stage: &Mutex<&'static str>, ended: &Receiver<()>) {
    let bar: ProgressBar = progress::of_shares("{elapsed_precise} [{bar:30}] {percent} %, {msg}");
    let begun = Instant::now();
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let share = watch.share();
        bar.set_position((share * progress::PARTS) as u64);
        let phase = phase_of(watch, stage);
        let left = left_in_words(watch, most, begun.elapsed().as_secs_f64());
        bar.set_message(left.map_or(phase.to_owned(), |left| format!("{phase}, {left}")));
    }
    bar.finish_and_clear();
}

/// The phase that is being done, in words.
fn phase_of(watch: &Watch, stage: &Mutex<&'static str>) -> &'static str {
    let phase = *stage.lock().unwrap_or_else(PoisonError::into_inner);
    if watch.is_stopped() { "end with what is known" } else { phase }
}

/// A line for each tenth of the work.
fn log(watch: &Watch, most: f64, stage: &Mutex<&'static str>, ended: &Receiver<()>) {
    let mut logged = Logged::default();
    let begun = Instant::now();
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let (share, counted) = (watch.share(), watch.counted());
        if logged.is_due(share, counted) {
            let left = left_in_words(watch, most, begun.elapsed().as_secs_f64());
            let left = left.map_or(String::new(), |left| format!(", {left}"));
            crate::tell(&format!("diagnose: {:.0} %, {}{left}", 100.0 * share, phase_of(watch, stage)));
        }
    }
}

/// The share and the work at the last line of a log.
#[derive(Default)]
struct Logged {
    share: f64,
    work: f64,
}

impl Logged {
    /// Whether a line is due at a `share` done by `work`; from then on it is the last one.
    fn is_due(&mut self, share: f64, work: f64) -> bool {
        let since = work - self.work;
        let is_due = since >= LOGGED_WORK[1] || (since >= LOGGED_WORK[0] && share >= self.share + LOGGED_SHARE);
        if is_due {
            *self = Logged { share, work };
        }
        is_due
    }
}

/// A line for each twentieth of the work, and where the end is elsewhere than was said.
fn line_by_line(watch: &Watch, most: f64, ended: &Receiver<()>) {
    let (mut told, mut told_s) = (0.0, 0.0);
    let begun = Instant::now();
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let (share, elapsed_s) = (watch.share(), begun.elapsed().as_secs_f64());
        let Some(left_s) = left_s(elapsed_s, watch.outlook()) else { continue };
        let whole_s = elapsed_s + left_s;
        if share >= told + LINE_SHARE || (whole_s - told_s).abs() > LINE_CHANGE * told_s {
            (told, told_s) = (share, whole_s);
            let left = left_in_words(watch, most, elapsed_s).unwrap_or_else(|| time_left(left_s));
            crate::tell(&format!("{:.0} %, {left}", 100.0 * share));
        }
    }
}

/// What is left, and what the limit of the work allows where that is much more.
fn left_in_words(watch: &Watch, most: f64, elapsed_s: f64) -> Option<String> {
    let left = left_s(elapsed_s, watch.outlook())?;
    let allowed = allowed_s(elapsed_s, watch.counted(), most);
    Some(match allowed > ALLOWED_RATIO * left {
        true => format!("about {} left, {} at most", time(left), time(allowed)),
        false => time_left(left),
    })
}

/// Time that the limit `most` and the fits that end beyond it allow, at the pace so far.
fn allowed_s(elapsed_s: f64, counted: f64, most: f64) -> f64 {
    elapsed_s * (OVERRUN * most / counted.max(1.0) - 1.0).max(0.0)
}

/// Time that is left at `elapsed_s` of work of which `share` is done; `None` where no pace is
/// known.
fn left_s(elapsed_s: f64, share: f64) -> Option<f64> {
    (elapsed_s >= PACE_KNOWN_S && share > 0.0).then(|| elapsed_s * (1.0 - share).max(0.0) / share)
}

/// `about 40 s left`.
fn time_left(seconds: f64) -> String {
    format!("about {} left", time(seconds))
}

/// `40 s`, with one or two figures.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{} s", s.ceil().max(1.0)),
        s if s < 100.0 => format!("{} s", 5.0 * (s / 5.0).round()),
        s if s < 5400.0 => format!("{} min", (s / 60.0).round()),
        s => format!("{} h", (s / 3600.0).round()),
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
    fn a_log_has_a_line_for_each_tenth_of_a_long_work_and_none_of_a_short_one() {
        let lines = |whole: f64| {
            let mut logged = Logged::default();
            let shares = (1..=1000).map(|k| f64::from(k) / 1000.0);
            shares.filter(|share| logged.is_due(*share, share * whole)).count()
        };
        assert_eq!(lines(4e9), 0);
        // a share that is rounded down waits for the next thousandth
        assert!((9..=10).contains(&lines(1e11)), "{}", lines(1e11));
        // never silent for longer than the work between two lines may be
        assert!((90..=100).contains(&lines(3e12)), "{}", lines(3e12));
    }

    #[test]
    fn what_is_left_takes_the_time_that_the_work_so_far_has_taken() {
        assert_eq!(left_s(0.5, 0.1), None);
        assert_eq!(left_s(10.0, 0.25), Some(30.0));
        assert_eq!(left_s(20.0, 1.0), Some(0.0));
    }

    #[test]
    fn the_limit_of_the_work_bounds_the_time_that_is_left_at_the_pace_so_far() {
        // half of what is counted and a half beyond it, at 1 ns each
        assert_eq!(allowed_s(50.0, 5e10, 1e11), 100.0);
        assert_eq!(allowed_s(150.0, 2e11, 1e11), 0.0);
    }
}
