//! Progress of a diagnosis: its phase, the share done and the time left.

use crate::forecast::{Forecast, Stage};
use crate::progress;
use identification::work::Watch;
use indicatif::ProgressBar;
use std::io::IsTerminal;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two looks at the count.
const LOOK: Duration = Duration::from_millis(100);
/// The share from which on a time is told: before it, little is known of what follows.
const SHARE_OF_TIMES: f64 = 0.1;

/// Phases on standard error: a bar on a terminal, else a line for each where they are asked for.
pub struct Phases {
    watch: Watch,
    forecast: Arc<Mutex<Forecast>>,
    lines: bool,
    /// Its end stops the bar.
    bar: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Phases {
    /// The work that `watch` sees is at most about `most`.
    pub fn new(watch: Watch, most: f64, lines: bool) -> Self {
        let forecast = Arc::new(Mutex::new(Forecast::new(most)));
        let is_terminal = std::io::stderr().is_terminal();
        let bar = is_terminal.then(|| {
            let (end, ended) = channel();
            let (watch, forecast) = (watch.clone(), forecast.clone());
            (end, std::thread::spawn(move || show(&watch, &forecast, &ended)))
        });
        Phases { watch, forecast, lines: lines && !is_terminal, bar }
    }

    /// `stage` begins.
    pub fn begin(&self, stage: Stage) {
        let work = self.watch.counted();
        self.forecast.lock().unwrap_or_else(PoisonError::into_inner).begin(stage, work);
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

/// Moves the bar until `ended`; a share never falls.
fn show(watch: &Watch, forecast: &Mutex<Forecast>, ended: &Receiver<()>) {
    let bar: ProgressBar = progress::of_shares("{elapsed_precise} [{bar:30}] {percent} % {msg}");
    let (begun, mut share) = (Instant::now(), 0.0_f64);
    while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
        let forecast = forecast.lock().unwrap_or_else(PoisonError::into_inner);
        share = share.max(forecast.share(watch.counted()));
        bar.set_position((share * progress::PARTS) as u64);
        let phase = if watch.is_stopped() { "end with what is known" } else { forecast.words() };
        let left = (share >= SHARE_OF_TIMES).then(|| begun.elapsed().as_secs_f64() * (1.0 - share) / share);
        bar.set_message(left.map_or(phase.to_owned(), |left| format!("{phase}, {}", time_left(left))));
    }
    bar.finish_and_clear();
}

/// `about 40 s left`, with one or two figures: it is right within a factor of two.
fn time_left(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("about {} s left", s.ceil().max(1.0)),
        s if s < 100.0 => format!("about {} s left", 10.0 * (s / 10.0).round()),
        s if s < 5400.0 => format!("about {} min left", (s / 60.0).round()),
        s => format!("about {} h left", (s / 3600.0).round()),
    }
}

#[cfg(test)]
mod tests {
    use super::time_left;

    #[test]
    fn a_time_is_told_in_the_unit_it_is_thought_of_in() {
        let told = [0.2, 7.3, 42.0, 130.0, 7300.0].map(time_left);
        assert_eq!(told, ["about 1 s left", "about 8 s left", "about 40 s left", "about 2 min left", "about 2 h left"]);
    }
}
