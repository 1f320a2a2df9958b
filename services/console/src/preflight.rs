//! What a run over shared memory needs of the computer, looked at before anything is started.
//!
//! Each need says what is there and what to do. Without it a run would fail on its way: with
//! SIGBUS where `/dev/shm` is full, with signal 11 where there is no address space.

use crate::Failure;
use rustix::fs::statvfs;
use rustix::process::{Resource, getrlimit};
use std::path::Path;

/// Free bytes in `/dev/shm`: services of 22 topics, 13 MB measured, and checkpoints; twice that.
const SHM_BYTES: u64 = 32 << 20;
/// Files in `/dev/shm`: 23 topics × 7 partitions, segments, connections; 420 measured of 22 × 6.
const SHM_FILES: u64 = 1000;
/// Descriptors of one partition: 176 measured, and what opens for a moment.
const DESCRIPTORS: u64 = 256;
/// Address space of the largest partition: 300 MB measured, maps of services and stacks.
const ADDRESS_SPACE_BYTES: u64 = 512 << 20;

/// One need: what it is, what is needed, what there is, what to do.
struct Need {
    of: String,
    need: u64,
    have: u64,
    unit: &'static str,
    cure: &'static str,
}

/// Looks at shared memory, limits, processors and the clock.
///
/// # Errors
/// [`Failure::Input`] naming need, have and cure of the first that is not met.
pub fn check(root: &Path) -> Result<(), Failure> {
    for need in needs(root) {
        if need.have < need.need {
            let Need { of, need, have, unit, cure } = need;
            return Err(Failure::Input(miette::miette!(
                help = cure,
                "{of}: a run needs {need} {unit}, there are {have}"
            )));
        }
    }
    Ok(())
}

fn needs(root: &Path) -> Vec<Need> {
    let mut all = Vec::new();
    for place in [Path::new("/dev/shm"), root] {
        let Ok(space) = statvfs(place) else { continue };
        let of = |what: &str| format!("{}: {what}", place.display());
        all.push(Need {
            of: of("free memory"),
            need: SHM_BYTES >> 20,
            have: (space.f_bavail * space.f_frsize) >> 20,
            unit: "MB",
            cure: "remove files there, or `mount -o remount,size=256m /dev/shm` (in a container `--shm-size=256m`)",
        });
        // A file system without a limit on files says 0 of 0.
        if space.f_files > 0 {
            all.push(Need {
                of: of("free files (inodes)"),
                need: SHM_FILES,
                have: space.f_favail,
                unit: "",
                cure: "remove files there, or `mount -o remount,nr_inodes=100k /dev/shm`",
            });
        }
    }
    all.push(Need {
        of: "descriptors (ulimit -n)".into(),
        need: DESCRIPTORS,
        have: getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX),
        unit: "",
        cure: "`ulimit -n 1024`, or LimitNOFILE=1024 in the systemd unit",
    });
    all.push(Need {
        of: "address space (ulimit -v)".into(),
        need: ADDRESS_SPACE_BYTES >> 20,
        have: getrlimit(Resource::As).current.unwrap_or(u64::MAX) >> 20,
        unit: "MB",
        cure: "`ulimit -v unlimited`; bound the resident memory instead (MemoryMax= in the systemd unit)",
    });
    all.push(Need {
        of: "clock (CLOCK_MONOTONIC)".into(),
        need: 1,
        have: u64::from(runtime::sys::monotonic_ns() > 0),
        unit: "",
        cure: "a kernel whose monotonic clock runs",
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_computer_is_enough_and_every_need_has_a_cure() {
        let needs = needs(Path::new("/dev/shm"));
        assert!(needs.len() >= 4 && needs.iter().all(|need| !need.cure.is_empty()));
        assert!(check(Path::new("/dev/shm")).is_ok());
    }
}
