//! `obsid partition keeper`: makes the folder of a run, holds it, and removes it with everything in
//! shared memory on SIGTERM. A service manager starts it before the partitions and does
//! what the warden does in `obsid run`.

use crate::partition::{Arguments, Kept};
use crate::run::{self, Common};
use crate::{Failure, preflight, scenario_file, tell, visible};
use runtime::rundir::OwnedRunDir;
use runtime::sys::Notifier;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::path::Path;
use std::process::ExitCode;

/// Keeps the run's folder `folder` until SIGTERM.
pub fn run(arguments: &Arguments) -> ExitCode {
    let kept = &arguments.kept;
    let (Some(folder), Some(record)) = (&arguments.run, &kept.record) else {
        tell("obsid: partition keeper needs --run FOLDER and --record FILE");
        return ExitCode::from(2);
    };
    match keep(folder, record, kept) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(report)) => {
            tell(visible::cut_snippets(&format!("{report:?}")).trim_end());
            ExitCode::from(3)
        }
        Err(failure) => {
            tell(&format!("obsid: keeper: {failure}"));
            ExitCode::from(1)
        }
    }
}

fn keep(folder: &Path, record: &Path, arguments: &Kept) -> Result<(), Failure> {
    let io = |error: std::io::Error| Failure::Run(error.to_string());
    // Before anything exists that a signal could leave behind.
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(io)?;
    let opened = match &arguments.scenario {
        Some(path) => scenario_file::read(path)?,
        None => scenario_file::default_scenario()?,
    };
    let mut run = run::config(opened, &Common::default(), None)?.config;
    run.check_depths().map_err(Failure::Run)?;
    run.record = std::path::absolute(record).map_err(io)?;
    run.record_all = true;
    run.speed = arguments.speed;
    run::order(&mut run, arguments.commands.as_deref(), arguments.keep.as_deref())?;
    let record = run.record.clone();
    run::make_room(&mut run, &record);
    preflight::check(folder.parent().unwrap_or(Path::new("/")))?;
    let owned = OwnedRunDir::create_at(folder, &run).map_err(io)?;
    if let Some(manager) = Notifier::of_environment() {
        manager.say("READY=1");
    }
    signals.forever().next();
    drop(owned);
    Ok(())
}
