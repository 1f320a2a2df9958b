//! What a process gives up for good: files outside its places, capabilities, room to raise its
//! limits.

use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, PathBeneath, PathFd, Ruleset, RulesetAttr, RulesetCreatedAttr,
    RulesetStatus, Scope,
};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use rustix::thread::{CapabilitySet, CapabilitySets, set_capabilities, set_no_new_privs};
use std::path::PathBuf;

/// Rights of this version are asked for; an older kernel grants what it knows of them.
const LANDLOCK: ABI = ABI::V6;
/// A partition holds 176 descriptors; a partition that leaks meets this limit before the system's.
const DESCRIPTORS_MAX: u64 = 1024;

/// A folder that stays open, and what for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The folder, and all below it.
    pub path: PathBuf,
    /// Folders and sockets may be made, not only files.
    pub whole: bool,
}

/// No program that this process could start gets more rights than it has.
///
/// # Errors
/// When the kernel does not know it.
pub fn no_new_privileges() -> Result<(), String> {
    set_no_new_privs(true).map_err(|error| error.to_string())
}

/// From now on this thread and its children reach no file outside `places`, no TCP port, and no
/// process outside themselves by signal or abstract socket.
///
/// # Errors
/// When the kernel has no landlock, or has it switched off.
pub fn stay_within(places: &[Place]) -> Result<(), String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let files = AccessFs::ReadFile
        | AccessFs::WriteFile
        | AccessFs::Truncate
        | AccessFs::MakeReg
        | AccessFs::RemoveFile
        | AccessFs::ReadDir;
    let whole: BitFlags<AccessFs> =
        files | AccessFs::MakeDir | AccessFs::RemoveDir | AccessFs::MakeSock | AccessFs::Refer;
    let ruleset = Ruleset::default()
        .handle_access(AccessFs::from_all(LANDLOCK))
        .and_then(|rules| rules.handle_access(AccessNet::from_all(LANDLOCK)))
        .and_then(|rules| rules.scope(Scope::from_all(LANDLOCK)))
        .and_then(|rules| rules.create())
        .map_err(|error| text(&error))?;
    let mut ruleset = ruleset;
    for place in places {
        let folder = PathFd::new(&place.path).map_err(|error| text(&error))?;
        let rights = if place.whole { whole } else { files };
        ruleset = ruleset.add_rule(PathBeneath::new(folder, rights)).map_err(|error| text(&error))?;
    }
    match ruleset.restrict_self().map_err(|error| text(&error))?.ruleset {
        RulesetStatus::NotEnforced => Err("not in this kernel, or switched off".into()),
        RulesetStatus::FullyEnforced | RulesetStatus::PartiallyEnforced => Ok(()),
    }
}

/// Gives up the powers of root. Who writes files where another user's folder is may keep the right
/// to (`keeps_files`); a process that is not root has nothing to give up.
///
/// # Errors
/// When the kernel refuses.
pub fn drop_capabilities(keeps_files: bool) -> Result<(), String> {
    let had = rustix::thread::capabilities(None).map_err(|error| error.to_string())?;
    if had.permitted.is_empty() && had.effective.is_empty() && had.inheritable.is_empty() {
        return Ok(());
    }
    let kept = if keeps_files { CapabilitySet::DAC_OVERRIDE & had.permitted } else { CapabilitySet::empty() };
    let sets = CapabilitySets { effective: kept, permitted: kept, inheritable: CapabilitySet::empty() };
    set_capabilities(None, sets).map_err(|error| error.to_string())
}

/// No core file, few descriptors, and no limit can be raised again.
///
/// # Errors
/// When the kernel refuses.
pub fn freeze_limits() -> Result<(), String> {
    let frozen = [
        Resource::As,
        Resource::Data,
        Resource::Stack,
        Resource::Nproc,
        Resource::Memlock,
        Resource::Sigpending,
        Resource::Msgqueue,
        Resource::Nice,
        Resource::Rtprio,
    ];
    let set = |resource, value| {
        let limit = Rlimit { current: value, maximum: value };
        setrlimit(resource, limit).map_err(|error| format!("{resource:?}: {error}"))
    };
    for resource in frozen {
        set(resource, getrlimit(resource).current)?;
    }
    let descriptors = getrlimit(Resource::Nofile).current.unwrap_or(DESCRIPTORS_MAX);
    set(Resource::Nofile, Some(descriptors.min(DESCRIPTORS_MAX)))?;
    set(Resource::Core, Some(0))
}
