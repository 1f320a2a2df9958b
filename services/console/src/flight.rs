//! A flight in real time whose figures are wanted, not its results.

use crate::scenario_run::{ScenarioRun, frames_expected};
use crate::scratch::Scratch;
use crate::warden_process::{End, Heard, SILENCE, WardenProcess};
use crate::{Failure, run, scenario_file};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// `scenario`, or the short one that is built in, at the speed of the real clock.
///
/// # Errors
/// [`Failure::Input`] for a scenario that cannot be flown.
pub fn in_real_time(scenario: Option<&Path>, common: &run::Common) -> Result<ScenarioRun, Failure> {
    let opened = match scenario {
        Some(path) => scenario_file::read(path)?,
        None => scenario_file::short_scenario()?,
    };
    let mut run = run::config(opened, common, None)?;
    run.config.speed = Some(1.0);
    Ok(run)
}

/// How long `run` lasts by its own clock \[s\].
pub fn length_s(run: &ScenarioRun) -> f64 {
    frames_expected(run) as f64 * run.config.period_ns as f64 * 1e-9
}

/// Flies `run` to its end or for `seconds`, then ends it in order.
///
/// # Errors
/// [`Failure::Run`] when it fails by itself.
pub fn fly(mut run: ScenarioRun, seconds: f64, interrupted: &AtomicBool) -> Result<End, Failure> {
    let scratch = Scratch::new()?;
    run.config.record = scratch.file("results.mcap");
    let bar = bar(seconds.min(length_s(&run)));
    let mut warden = WardenProcess::start(&run.config, None, &scratch, &[]).map_err(Failure::Run)?;
    let (started, mut asked) = (Instant::now(), false);
    let look = Duration::from_millis(200);
    loop {
        if let Heard::Closed = warden.next(look.min(SILENCE)) {
            break;
        }
        bar.set_position(started.elapsed().as_secs());
        let over = started.elapsed().as_secs_f64() >= seconds || interrupted.load(Ordering::Relaxed);
        if over && !asked {
            asked = true;
            warden.terminate();
        }
    }
    bar.finish_and_clear();
    let end = warden.end(&scratch);
    match &end.failure {
        Some(_) if interrupted.load(Ordering::Relaxed) => Err(Failure::Interrupted),
        Some(reason) if !asked => Err(Failure::Run(reason.clone())),
        _ => Ok(end),
    }
}

/// Seconds flown; hidden where standard error is no terminal.
fn bar(seconds: f64) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(seconds.ceil() as u64), target);
    let style = ProgressStyle::with_template("{elapsed_precise} [{bar:30}] {pos}/{len} s in real time");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
