//! The system calls that a partition needs once its ports exist; the kernel refuses every other one
//! with EPERM.
//!
//! The list is what a partition of the short scenario was seen to call over its life, deaths and
//! restarts of its peers included, and what the C library may call instead of those on another
//! kernel. Starting a process or a thread is not among them, nor is executable memory.

use seccompiler::{
    BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter, SeccompRule,
    apply_filter_all_threads,
};
use std::collections::BTreeMap;

/// Whatever the arguments are.
const FREE: &[libc::c_long] = &[
    // memory
    libc::SYS_brk,
    libc::SYS_madvise,
    libc::SYS_membarrier,
    libc::SYS_mremap,
    libc::SYS_munmap,
    // files: landlock says which
    libc::SYS_close,
    libc::SYS_dup,
    libc::SYS_faccessat,
    libc::SYS_faccessat2,
    libc::SYS_fallocate,
    libc::SYS_fchmod,
    libc::SYS_fcntl,
    libc::SYS_fdatasync,
    libc::SYS_flock,
    libc::SYS_fstat,
    libc::SYS_fsync,
    libc::SYS_ftruncate,
    libc::SYS_getcwd,
    libc::SYS_getdents64,
    libc::SYS_lseek,
    libc::SYS_mkdirat,
    libc::SYS_newfstatat,
    libc::SYS_openat,
    libc::SYS_pread64,
    libc::SYS_pwrite64,
    libc::SYS_read,
    libc::SYS_readlinkat,
    libc::SYS_readv,
    libc::SYS_renameat,
    libc::SYS_renameat2,
    libc::SYS_statx,
    libc::SYS_unlinkat,
    libc::SYS_write,
    libc::SYS_writev,
    // clocks, waiting
    libc::SYS_clock_getres,
    libc::SYS_clock_gettime,
    libc::SYS_clock_nanosleep,
    libc::SYS_epoll_create1,
    libc::SYS_epoll_ctl,
    libc::SYS_epoll_pwait,
    libc::SYS_futex,
    libc::SYS_gettimeofday,
    libc::SYS_nanosleep,
    libc::SYS_ppoll,
    libc::SYS_pselect6,
    libc::SYS_restart_syscall,
    libc::SYS_sched_yield,
    // local sockets
    libc::SYS_accept4,
    libc::SYS_bind,
    libc::SYS_connect,
    libc::SYS_getsockname,
    libc::SYS_getsockopt,
    libc::SYS_recvfrom,
    libc::SYS_recvmsg,
    libc::SYS_sendmsg,
    libc::SYS_sendto,
    libc::SYS_setsockopt,
    libc::SYS_shutdown,
    // the process itself
    libc::SYS_exit,
    libc::SYS_exit_group,
    libc::SYS_getegid,
    libc::SYS_geteuid,
    libc::SYS_getgid,
    libc::SYS_getpid,
    libc::SYS_getppid,
    libc::SYS_getrandom,
    libc::SYS_getrusage,
    libc::SYS_gettid,
    libc::SYS_getuid,
    libc::SYS_rseq,
    libc::SYS_rt_sigaction,
    libc::SYS_rt_sigprocmask,
    libc::SYS_rt_sigreturn,
    libc::SYS_sched_getaffinity,
    libc::SYS_set_robust_list,
    libc::SYS_sigaltstack,
    libc::SYS_umask,
    libc::SYS_uname,
];

/// Older names of calls of [`FREE`], which other machines do not have.
#[cfg(target_arch = "x86_64")]
const OLDER: &[libc::c_long] = &[
    libc::SYS_access,
    libc::SYS_epoll_wait,
    libc::SYS_lstat,
    libc::SYS_mkdir,
    libc::SYS_open,
    libc::SYS_poll,
    libc::SYS_readlink,
    libc::SYS_rename,
    libc::SYS_rmdir,
    libc::SYS_select,
    libc::SYS_stat,
    libc::SYS_time,
    libc::SYS_unlink,
];
#[cfg(not(target_arch = "x86_64"))]
const OLDER: &[libc::c_long] = &[];

/// Refuses all but the calls that a partition needs, to every thread that the process has.
///
/// # Errors
/// When the kernel has no system call filter.
pub fn restrict() -> Result<(), String> {
    let program = program().map_err(|error| error.to_string())?;
    apply_filter_all_threads(&program).map_err(|error| error.to_string())
}

fn program() -> Result<BpfProgram, seccompiler::BackendError> {
    let mut rules: BTreeMap<i64, Vec<SeccompRule>> = FREE.iter().chain(OLDER).map(|&call| (call, vec![])).collect();
    let own = u64::from(std::process::id());
    let no_code = SeccompCmpOp::MaskedEq(libc::PROT_EXEC as u64);
    for (call, argument, length, operation, value) in [
        (libc::SYS_mmap, 2, SeccompCmpArgLen::Dword, no_code.clone(), 0),
        (libc::SYS_mprotect, 2, SeccompCmpArgLen::Dword, no_code, 0),
        (libc::SYS_socket, 0, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, libc::AF_UNIX as u64),
        (libc::SYS_ioctl, 1, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, libc::FIONBIO),
        (libc::SYS_prctl, 0, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, libc::PR_SET_NAME as u64),
        // Its limits are read, never set.
        (libc::SYS_prlimit64, 2, SeccompCmpArgLen::Qword, SeccompCmpOp::Eq, 0),
        // A crash, and a drill's kill of itself.
        (libc::SYS_kill, 0, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, own),
        (libc::SYS_tgkill, 0, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, own),
    ] {
        let condition = SeccompCondition::new(argument, length, operation, value)?;
        rules.insert(call, vec![SeccompRule::new(vec![condition])?]);
    }
    let refused = SeccompAction::Errno(libc::EPERM as u32);
    let machine = std::env::consts::ARCH.try_into()?;
    SeccompFilter::new(rules, refused, SeccompAction::Allow, machine)?.try_into()
}

#[cfg(test)]
mod tests {
    use super::{FREE, OLDER, program};
    use std::collections::BTreeSet;

    #[test]
    fn the_filter_compiles_and_no_call_is_listed_twice_or_starts_a_process() {
        assert!(!program().unwrap().is_empty());
        let all: BTreeSet<_> = FREE.iter().chain(OLDER).collect();
        assert_eq!(all.len(), FREE.len() + OLDER.len());
        let forbidden = [libc::SYS_clone, libc::SYS_clone3, libc::SYS_execve, libc::SYS_execveat, libc::SYS_ptrace];
        assert!(forbidden.iter().all(|call| !all.contains(call)));
    }
}
