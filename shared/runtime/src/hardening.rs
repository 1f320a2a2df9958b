//! What a partition gives up once its ports exist, and which of it this computer could take away.
//!
//! Files, capabilities and limits first ([`Hardening::confine`]), while threads can still be
//! started: they inherit. Then system calls, for all threads at once ([`Hardening::filter`]). What
//! the kernel does not have is reported, and the run goes on without.

use crate::RunConfig;
use crate::config::Sabotage;
use crate::rundir::{RunDir, SHARED_MEMORY};
use crate::sys;
use serde::{Deserialize, Serialize};
use std::path::Path;
use telemetry::PartitionId;

/// Which barriers stand around a partition.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hardening {
    /// Nothing that it starts gets more rights.
    pub no_new_privileges: bool,
    /// Powers of root are given up.
    pub capabilities: bool,
    /// Limits are frozen, no core file is written.
    pub limits: bool,
    /// Files outside its places are closed to it (landlock).
    pub files: bool,
    /// Its folder is closed to other partitions: the run's folder lies outside `/dev/shm`, in which
    /// every partition may write.
    pub own_folder: bool,
    /// System calls that it does not need are refused (seccomp).
    pub system_calls: bool,
    /// What does not stand, and why.
    pub missing: Vec<String>,
}

impl Hardening {
    /// The first part: before the partition's threads are started.
    #[must_use]
    pub fn confine(dir: &RunDir, id: PartitionId, run: &RunConfig) -> Self {
        let mut all = Hardening::default();
        if run.sabotage == Sabotage::NoHardening {
            all.missing.push("switched off".into());
            return all;
        }
        all.no_new_privileges = all.stands("no_new_privs", sys::no_new_privileges());
        all.limits = all.stands("limits", sys::freeze_limits());
        all.capabilities = all.stands("capabilities", sys::drop_capabilities(id == PartitionId::Recorder));
        all.files = all.stands("landlock", sys::stay_within(&places(dir, id, run)));
        all.own_folder = all.files && !dir.path().starts_with(SHARED_MEMORY);
        if all.files && !all.own_folder {
            all.missing.push(format!("checkpoints of others: the run's folder lies in {SHARED_MEMORY} (OBSID_ROOT)"));
        }
        all
    }

    /// The second part: when all threads exist.
    pub fn filter(&mut self, run: &RunConfig) {
        if run.sabotage != Sabotage::NoHardening {
            self.system_calls = self.stands("seccomp", sys::restrict_system_calls());
        }
    }

    fn stands(&mut self, what: &str, result: Result<(), String>) -> bool {
        let stands = result.is_ok();
        self.missing.extend(result.err().map(|error| format!("{what}: {error}")));
        stands
    }
}

/// What a partition needs of the file system.
fn places(dir: &RunDir, id: PartitionId, run: &RunConfig) -> Vec<sys::Place> {
    let place = |path: &Path, whole| sys::Place { path: path.into(), whole };
    let mut places =
        vec![place(Path::new(SHARED_MEMORY), false), place(&dir.iceoryx_root(), true), place(&dir.own(id), false)];
    places.extend(run.keep.as_deref().map(|folder| place(folder, false)));
    if id == PartitionId::Recorder {
        // A recording is repaired as a second file beside it.
        let files = [Some(&run.record), run.results.as_ref()].into_iter().flatten();
        places.extend(files.filter_map(|file| file.parent()).map(|folder| place(folder, false)));
    }
    places
}

/// For tests: every act of [`sys::try_forbidden_acts`], as a line on standard error.
pub fn probe(dir: &RunDir, id: PartitionId) {
    let other = if id == PartitionId::Recorder { PartitionId::Supervisor } else { PartitionId::Recorder };
    let answers = sys::try_forbidden_acts(dir.path(), &dir.own(id), &dir.own(other));
    let answers: Vec<String> = answers.iter().map(|(act, errno)| format!("\"{act}\":{errno}")).collect();
    sys::tell(&format!("probes of {id}: {{{}}}\n", answers.join(",")));
}
