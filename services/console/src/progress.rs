//! A progress bar on standard error, only where somebody looks at it.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;

/// Frames done of a run whose length is known about.
pub struct Progress(ProgressBar);

impl Progress {
    pub fn new(frames: u64) -> Self {
        let target =
            if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(frames), target);
        let style = ProgressStyle::with_template("{elapsed_precise} [{bar:30}] frame {pos}/{len} {msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Progress(bar)
    }

    pub fn show(&self, frame: u64, mode: &str) {
        self.0.set_position(frame);
        self.0.set_message(mode.to_string());
    }

    /// A line above the bar; on standard error also without a terminal.
    pub fn note(&self, line: &str) {
        self.0.suspend(|| crate::tell(line));
    }

    pub fn end(&self) {
        self.0.finish_and_clear();
    }
}
