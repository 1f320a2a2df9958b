//! A progress bar on standard error, only where somebody looks at it.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// Frames done of a run whose length is known about.
pub struct Progress(ProgressBar);

impl Progress {
    /// A bar of `frames` frames on standard error; hidden where that is no terminal.
    pub fn new(frames: u64) -> Self {
        let target =
            if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(frames), target);
        let style = ProgressStyle::with_template("{elapsed_precise} [{bar:30}] frame {pos}/{len} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Progress(bar)
    }

    /// Moves the bar to `frame` and shows the mode beside it.
    pub fn show(&self, frame: u64, mode: &str) {
        self.0.set_position(frame);
        self.0.set_message(mode.to_string());
    }

    /// A line above the bar; on standard error also without a terminal.
    pub fn note(&self, line: &str) {
        self.0.suspend(|| crate::tell(line));
    }

    /// Removes the bar from the terminal.
    pub fn end(&self) {
        self.0.finish_and_clear();
    }
}

/// The parts that a bar of shares has.
pub const PARTS: f64 = 1000.0;

/// A bar of `PARTS` on standard error; hidden where that is no terminal.
pub fn of_shares(template: &str) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(PARTS as u64), target);
    bar.set_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}

/// Share done of work that has no countable steps.
pub struct Share(ProgressBar);

impl Share {
    /// `what` is a participle: "simulated".
    pub fn new(what: &str) -> Self {
        let bar = of_shares("{elapsed_precise} [{bar:30}] {percent} % {msg}, {eta} left");
        bar.set_message(what.to_string());
        Share(bar)
    }

    /// `share` of 1 is all.
    pub fn show(&self, share: f64) {
        self.0.set_position((share.clamp(0.0, 1.0) * PARTS) as u64);
    }

    /// Removes the bar from the terminal.
    pub fn end(&self) {
        self.0.finish_and_clear();
    }
}
