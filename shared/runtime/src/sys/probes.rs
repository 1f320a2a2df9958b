//! Acts that no partition has a need for, each tried in a way that does no harm where it succeeds.
//! For tests: what is refused is the kernel's answer, not ours.
#![allow(unsafe_code)]

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::Path;

/// An act, and what the kernel said: 0 for done, else the error's number.
pub type Answer = (&'static str, i32);

/// Refused for lack of a right; every other error comes from an act that was let through.
#[must_use]
pub fn is_refused(errno: i32) -> bool {
    errno == libc::EPERM || errno == libc::EACCES
}

/// Tries every act; `own` is the folder of this partition, `other` that of another one, `run` the
/// run's.
#[must_use]
pub fn try_all(run: &Path, own: &Path, other: &Path) -> Vec<Answer> {
    let mut answers = files(run, own, other);
    answers.extend(system_calls());
    answers.push(("start a thread", errno(std::thread::Builder::new().spawn(|| ()).map(|_| ()))));
    answers.push(("start a program", errno(start_a_program())));
    answers
}

fn start_a_program() -> io::Result<()> {
    std::process::Command::new("/bin/true").spawn()?.wait().map(|_| ())
}

fn errno<T>(result: io::Result<T>) -> i32 {
    result.map_or_else(|error| error.raw_os_error().unwrap_or(-1), |_| 0)
}

fn files(run: &Path, own: &Path, other: &Path) -> Vec<Answer> {
    let me = std::process::id();
    let parent = std::os::unix::process::parent_id();
    let outside = std::env::temp_dir().join(format!("obsid-probe-{me}"));
    let folder = Path::new("/dev/shm").join(format!("obsid-probe-{me}"));
    let (link, theirs) = (own.join("link"), other.join("probe"));
    let answers = vec![
        ("read a file of the system", errno(File::open("/etc/passwd"))),
        ("write a file outside", errno(File::create(&outside))),
        ("list the root folder", errno(fs::read_dir("/"))),
        ("open a device", errno(OpenOptions::new().write(true).open("/dev/null"))),
        ("write into another partition's folder", errno(File::create(&theirs))),
        ("list another partition's folder", errno(fs::read_dir(other))),
        ("write the run's configuration", errno(OpenOptions::new().append(true).open(run.join("run.json")))),
        ("read the memory of its parent", errno(File::open(format!("/proc/{parent}/mem")))),
        ("write its own memory as a file", errno(OpenOptions::new().write(true).open("/proc/self/mem"))),
        ("make a folder in shared memory", errno(fs::create_dir(&folder))),
        ("link a file", errno(fs::hard_link(run.join("run.json"), &link))),
        ("link a path", errno(std::os::unix::fs::symlink("/etc/passwd", own.join("path")))),
        ("change the mode of a file", errno(mode_as_it_is(own))),
    ];
    for file in [outside, theirs, link, own.join("path")] {
        let _ = fs::remove_file(file);
    }
    let _ = fs::remove_dir(folder);
    answers
}

fn mode_as_it_is(path: &Path) -> io::Result<()> {
    fs::set_permissions(path, fs::metadata(path)?.permissions())
}

/// A call whose arguments are no address of this process's memory.
fn call(number: libc::c_long, arguments: [libc::c_long; 6]) -> i32 {
    let [a, b, c, d, e, f] = arguments;
    // SAFETY: every argument is a number or a null pointer: the kernel reads and writes no memory
    // of this process, or answers EFAULT.
    let answer = unsafe { libc::syscall(number, a, b, c, d, e, f) };
    if answer >= 0 { 0 } else { io::Error::last_os_error().raw_os_error().unwrap_or(-1) }
}

fn system_calls() -> Vec<Answer> {
    let parent = libc::c_long::from(std::os::unix::process::parent_id());
    let nobody = libc::c_long::from(i32::MAX);
    let user = libc::c_long::from(rustix::process::getuid().as_raw());
    let (family, kind) = (|family: i32| libc::c_long::from(family), libc::c_long::from(libc::SOCK_DGRAM));
    let code = libc::c_long::from(libc::PROT_READ | libc::PROT_EXEC);
    let private = libc::c_long::from(libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
    const SEIZE: libc::c_long = 0x4206;
    let acts: &[(&'static str, libc::c_long, [libc::c_long; 6])] = &[
        ("open an internet socket", libc::SYS_socket, [family(libc::AF_INET), kind, 0, 0, 0, 0]),
        ("open an internet socket (v6)", libc::SYS_socket, [family(libc::AF_INET6), kind, 0, 0, 0, 0]),
        ("talk to the kernel's network", libc::SYS_socket, [family(libc::AF_NETLINK), kind, 0, 0, 0, 0]),
        ("open a raw socket", libc::SYS_socket, [family(libc::AF_PACKET), kind, 0, 0, 0, 0]),
        ("trace a process", libc::SYS_ptrace, [SEIZE, nobody, 0, 0, 0, 0]),
        ("read another process's memory", libc::SYS_process_vm_readv, [parent, 0, 0, 0, 0, 0]),
        ("write another process's memory", libc::SYS_process_vm_writev, [parent, 0, 0, 0, 0, 0]),
        ("signal its parent", libc::SYS_kill, [parent, 0, 0, 0, 0, 0]),
        ("open a handle of its parent", libc::SYS_pidfd_open, [parent, 0, 0, 0, 0, 0]),
        ("execute a program", libc::SYS_execve, [0, 0, 0, 0, 0, 0]),
        ("execute a program (at)", libc::SYS_execveat, [-1, 0, 0, 0, 0, 0]),
        ("set its limits", libc::SYS_prlimit64, [0, libc::RLIMIT_CORE as libc::c_long, 1, 0, 0, 0]),
        ("change its priority", libc::SYS_setpriority, [0, 0, 0, 0, 0, 0]),
        ("change its scheduling", libc::SYS_sched_setscheduler, [0, 0, 0, 0, 0, 0]),
        ("change its user", libc::SYS_setresuid, [user, user, user, 0, 0, 0]),
        ("leave its namespaces", libc::SYS_unshare, [0, 0, 0, 0, 0, 0]),
        ("enter a namespace", libc::SYS_setns, [-1, 0, 0, 0, 0, 0]),
        ("mount a file system", libc::SYS_mount, [0, 0, 0, 0, 0, 0]),
        ("change the root", libc::SYS_chroot, [0, 0, 0, 0, 0, 0]),
        ("reboot", libc::SYS_reboot, [0, 0, 0, 0, 0, 0]),
        ("load a kernel module", libc::SYS_init_module, [0, 0, 0, 0, 0, 0]),
        ("load a kernel program", libc::SYS_bpf, [-1, 0, 0, 0, 0, 0]),
        ("count events of the machine", libc::SYS_perf_event_open, [0, 0, -1, -1, 0, 0]),
        ("use keys of the kernel", libc::SYS_keyctl, [-1, 0, 0, 0, 0, 0]),
        ("queue calls past the filter", libc::SYS_io_uring_setup, [0, 0, 0, 0, 0, 0]),
        ("handle faults of memory", libc::SYS_userfaultfd, [-1, 0, 0, 0, 0, 0]),
        ("make a file without a name", libc::SYS_memfd_create, [0, 0, 0, 0, 0, 0]),
        ("map memory as code", libc::SYS_mmap, [0, 4096, code, private, -1, 0]),
        ("set the clock", libc::SYS_clock_settime, [0, 0, 0, 0, 0, 0]),
        ("open a file by handle", libc::SYS_open_by_handle_at, [-1, 0, 0, 0, 0, 0]),
        ("change its personality", libc::SYS_personality, [0xffff_ffff, 0, 0, 0, 0, 0]),
        ("be dumped", libc::SYS_prctl, [libc::c_long::from(libc::PR_SET_DUMPABLE), 1, 0, 0, 0, 0]),
        ("watch files", libc::SYS_inotify_init1, [0, 0, 0, 0, 0, 0]),
    ];
    acts.iter().map(|&(act, number, arguments)| (act, call(number, arguments))).collect()
}
