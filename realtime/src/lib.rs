//! What is asked of Linux so that the loop wakes on time, and what was granted.
//!
//! All of it may be refused, by rights, limits or the kernel. Then the answer is not an error but a [`RealtimeReport`]: a
//! row for each request with what it costs to do without and what to type to get it. `realtime = "strict"` in the rig file
//! turns a refusal into a refusal to start. `docs/realtime.md` tells the reasons at length.
//!
//! Unsafe code here is the bare system calls.
//!
//! ```
//! use sinew_realtime::{Wish, prepare_process, prepare_thread};
//!
//! let wish = Wish::OFF; // ask for nothing: an ordinary thread
//! let (_held, mut report) = prepare_process(&wish);
//! prepare_thread(&wish, &mut report);
//! assert_eq!(report.missing().count(), 0, "nothing that was insisted on is missing");
//! ```

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::mem;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;

/// How hard real time is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Ask for nothing: an ordinary thread.
    Off,
    /// Ask for everything, go on without what is refused, and say so.
    Try,
    /// Ask for everything and refuse to start without it.
    Strict,
}

/// What to ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wish {
    /// How hard.
    pub mode: Mode,
    /// Priority under SCHED_FIFO, 1 ..= 99.
    pub priority: u8,
    /// The core to pin the loop to; `None` takes the last one allowed (the first serves most interrupts).
    pub cpu: Option<usize>,
}

impl Wish {
    /// Asks for nothing.
    pub const OFF: Wish = Wish { mode: Mode::Off, priority: 0, cpu: None };
}

/// One request to Linux and its answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Short name, stable for programs: `scheduler`, `core`, `memory`, `prefault`, `timer_slack`, `idle_states`, `kernel`.
    pub id: &'static str,
    /// What was asked for.
    pub asked: String,
    /// Whether all of it was granted.
    pub granted: bool,
    /// Whether `realtime = "strict"` insists on it (the kernel's own build is advice only).
    pub required: bool,
    /// What was found or answered.
    pub found: String,
    /// What it costs to do without.
    pub cost: &'static str,
    /// What to type to get it; empty when granted.
    pub remedy: String,
}

/// Every request and its answer, as `sinew run` reports and `sinew doctor` prints it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RealtimeReport {
    /// How hard it was asked for.
    pub mode: Mode,
    /// The scheduling policy the loop's thread has: `SCHED_FIFO` or `SCHED_OTHER`.
    pub policy: &'static str,
    /// Its priority, 0 under SCHED_OTHER.
    pub priority: u8,
    /// The core it is pinned to.
    pub cpu: Option<usize>,
    /// Whether all memory, present and future, is locked.
    pub locked: bool,
    /// Timer slack of the loop's thread, ns.
    pub timer_slack_ns: u64,
    /// Whether `/dev/cpu_dma_latency` is held at 0.
    pub dma_latency_held: bool,
    /// The requests one by one.
    pub rows: Vec<Row>,
}

impl RealtimeReport {
    fn new(mode: Mode) -> Self {
        RealtimeReport {
            mode,
            policy: "SCHED_OTHER",
            priority: 0,
            cpu: None,
            locked: false,
            timer_slack_ns: timer_slack_ns(),
            dma_latency_held: false,
            rows: Vec::new(),
        }
    }

    /// The requests that were refused.
    pub fn refused(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.granted)
    }

    /// The refusals that `realtime = "strict"` does not put up with.
    pub fn missing(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| !row.granted && row.required)
    }
}

/// Keeps what was granted to the whole process; memory is unlocked and the processor may sleep again when it is dropped.
#[derive(Debug)]
pub struct Held {
    dma_latency: Option<File>,
    locked: bool,
}

/// Several drivers may live in one process (tests do so): the last one out unlocks.
static LOCK_HOLDERS: AtomicUsize = AtomicUsize::new(0);

impl Drop for Held {
    fn drop(&mut self) {
        if self.locked && LOCK_HOLDERS.fetch_sub(1, Ordering::AcqRel) == 1 {
            // SAFETY: munlockall takes no arguments and touches no memory of ours.
            unsafe { libc::munlockall() };
        }
        self.dma_latency = None;
    }
}

/// Bytes of the loop thread's stack that are touched before it runs.
const PREFAULT_STACK: usize = 256 * 1024;
/// Bytes of heap that are touched and given back to the allocator (not to the kernel) before the loop runs.
const PREFAULT_HEAP: usize = 1024 * 1024;
/// Stack of the loop thread.
pub const LOOP_STACK: usize = 2 * 1024 * 1024;

/// Asks for what belongs to the whole process: memory locks, a prefaulted heap, no deep idle states.
pub fn prepare_process(wish: &Wish) -> (Held, RealtimeReport) {
    let mut report = RealtimeReport::new(wish.mode);
    let mut held = Held { dma_latency: None, locked: false };
    if wish.mode == Mode::Off {
        return (held, report);
    }

    let (row, locked) = lock_memory();
    held.locked = locked;
    report.locked = locked;
    report.rows.push(row);

    prefault_heap();

    let path = "/dev/cpu_dma_latency";
    let opened = OpenOptions::new().write(true).open(path).and_then(|mut file| {
        file.write_all(&0i32.to_ne_bytes())?;
        Ok(file)
    });
    report.rows.push(Row {
        id: "idle_states",
        asked: format!("{path} held at 0 µs"),
        granted: opened.is_ok(),
        required: true,
        found: answer(&opened),
        cost: "the processor may enter deep idle states between two cycles and wake 50 to 200 µs late",
        remedy: remedy(&opened, || {
            format!("run as root, or: sudo setfacl -m u:$USER:w {path}   (a udev rule keeps it over a reboot)")
        }),
    });
    report.dma_latency_held = opened.is_ok();
    held.dma_latency = opened.ok();
    (held, report)
}

/// Asks for what belongs to the calling thread, which is to become the loop, and adds the answers to `report`.
pub fn prepare_thread(wish: &Wish, report: &mut RealtimeReport) {
    if wish.mode == Mode::Off {
        return;
    }

    let pinned = pin(wish.cpu);
    report.cpu = pinned.as_ref().ok().copied();
    report.rows.push(Row {
        id: "core",
        asked: match wish.cpu {
            Some(cpu) => format!("pinned to core {cpu}"),
            None => "pinned to the last core allowed".into(),
        },
        granted: pinned.is_ok(),
        required: true,
        found: match &pinned {
            Ok(cpu) => format!("core {cpu}"),
            Err(error) => error.to_string(),
        },
        cost: "the loop moves between cores and finds its data in the wrong cache: some 10 µs a move",
        remedy: remedy(&pinned, || {
            format!("choose `realtime_cpu` in [rig] among the allowed cores ({})", core_list(&allowed_cores()))
        }),
    });

    let scheduled = schedule_fifo(wish.priority);
    if scheduled.is_ok() {
        report.policy = "SCHED_FIFO";
        report.priority = wish.priority;
    }
    report.rows.push(Row {
        id: "scheduler",
        asked: format!("SCHED_FIFO priority {}", wish.priority),
        granted: scheduled.is_ok(),
        required: true,
        found: answer(&scheduled),
        cost: "any other process may take the core: wake-ups late by milliseconds when the machine is busy",
        remedy: remedy(&scheduled, || may_be_granted(&format!("rtprio {}", wish.priority))),
    });

    let slack = set_timer_slack();
    report.timer_slack_ns = timer_slack_ns();
    report.rows.push(Row {
        id: "timer_slack",
        asked: "timer slack 1 ns".into(),
        granted: slack.is_ok(),
        required: true,
        found: format!("{} ns", report.timer_slack_ns),
        cost: "under SCHED_OTHER the kernel may bundle wake-ups: up to 50 µs late",
        remedy: remedy(&slack, || "run outside of the sandbox that filters prctl".into()),
    });

    prefault_stack();
    report.rows.push(Row {
        id: "prefault",
        asked: format!("{} KiB of stack and {} KiB of heap touched", PREFAULT_STACK / 1024, PREFAULT_HEAP / 1024),
        granted: true,
        required: true,
        found: "done".into(),
        cost: "a first touch of a page costs 0.5 to 5 µs in the loop",
        remedy: String::new(),
    });

    report.rows.push(kernel_row());
}

/// What this machine grants and lacks, asked in a thread of its own and given back at once: for `sinew doctor`.
pub fn survey(wish: &Wish) -> RealtimeReport {
    let (held, mut report) = prepare_process(wish);
    std::thread::scope(|scope| {
        let _ = scope.spawn(|| prepare_thread(wish, &mut report)).join();
    });
    drop(held);
    report
}

fn answer<T>(result: &io::Result<T>) -> String {
    match result {
        Ok(_) => "granted".into(),
        Err(error) => error.to_string(),
    }
}

fn remedy<T>(result: &io::Result<T>, text: impl FnOnce() -> String) -> String {
    if result.is_ok() { String::new() } else { text() }
}

/// What a package sets up for those who may be on time.
const LIMITS: &str = "/etc/security/limits.d/sinew.conf";

/// How a user is granted this limit: by joining the group that a package has made, or else by hand.
fn may_be_granted(limit: &str) -> String {
    if Path::new(LIMITS).exists() {
        return format!("sudo usermod -aG realtime $USER, and log in anew: {LIMITS} grants it to that group");
    }
    format!(
        "sudo setcap cap_sys_nice,cap_ipc_lock+ep $(command -v sinew)   (or `@realtime - {limit}` in \
         /etc/security/limits.d/realtime.conf and join that group)"
    )
}

fn core_list(cores: &[usize]) -> String {
    cores.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

fn check(code: libc::c_int) -> io::Result<()> {
    if code == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

fn lock_memory() -> (Row, bool) {
    // Under a finite limit a lock on all *future* memory would make later allocations of the process fail (EAGAIN) once the
    // limit is reached. Rather run unlocked, and say so.
    let result = if memory_lock_is_unlimited() {
        // SAFETY: mlockall takes flags only.
        check(unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) })
    } else {
        Err(io::Error::other("the limit on locked memory is finite (ulimit -l)"))
    };
    if result.is_ok() {
        LOCK_HOLDERS.fetch_add(1, Ordering::AcqRel);
    }
    let row = Row {
        id: "memory",
        asked: "all memory locked (mlockall)".into(),
        granted: result.is_ok(),
        required: true,
        found: answer(&result),
        cost: "a page may be swapped or reclaimed: one cycle late by milliseconds when memory is short",
        remedy: remedy(&result, || may_be_granted("memlock unlimited")),
    };
    (row, result.is_ok())
}

fn memory_lock_is_unlimited() -> bool {
    let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: `limit` is a valid, writable rlimit that outlives the call.
    let known = unsafe { libc::getrlimit(libc::RLIMIT_MEMLOCK, &mut limit) } == 0;
    if known && limit.rlim_cur == libc::RLIM_INFINITY {
        return true;
    }
    /// Number of CAP_IPC_LOCK in linux/capability.h: with it the limit does not apply.
    const CAP_IPC_LOCK: u32 = 14;
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| {
            let line = status.lines().find_map(|line| line.strip_prefix("CapEff:"))?.trim().to_owned();
            u64::from_str_radix(&line, 16).ok()
        })
        .is_some_and(|capabilities| capabilities >> CAP_IPC_LOCK & 1 == 1)
}

/// Grows the heap once and tells glibc to keep what it has, so that ordinary threads seldom need the kernel either.
fn prefault_heap() {
    #[cfg(target_env = "gnu")]
    {
        // SAFETY: mallopt sets a tuning parameter; any value is accepted or ignored.
        unsafe { libc::mallopt(libc::M_TRIM_THRESHOLD, -1) };
    }
    let mut block = vec![0u8; PREFAULT_HEAP];
    for page in block.chunks_mut(4096) {
        page[0] = 1;
    }
    std::hint::black_box(&block);
}

/// Touches the stack below the caller; never inlined, so that its frame is given back.
#[inline(never)]
fn prefault_stack() {
    let mut frame = [0u8; PREFAULT_STACK];
    std::hint::black_box(&mut frame);
}

fn schedule_fifo(priority: u8) -> io::Result<()> {
    let parameters = libc::sched_param { sched_priority: priority.into() };
    // SAFETY: pid 0 is the calling thread, and `parameters` outlives the call.
    check(unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK, &parameters) })
}

/// Puts the calling thread before the machine's ordinary work, where that is allowed: a loop at real time takes a core when it likes,
/// and what empties its ring must not wait behind everybody else for what is left.
pub fn go_first(wish: &Wish) {
    /// As much processor time as nine ordinary threads.
    const NICE: libc::c_int = -10;
    if wish.mode != Mode::Off {
        // SAFETY: plain system call; with 0 Linux takes the calling thread. Refused, the thread stays an ordinary one.
        let _ = unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, NICE) };
    }
}

/// The cores this process may run on.
pub fn allowed_cores() -> Vec<usize> {
    // SAFETY: a cpu_set_t is a plain array of bits, for which all zero is a valid value (the empty set).
    let mut set: libc::cpu_set_t = unsafe { mem::zeroed() };
    // SAFETY: pid 0 is the calling thread; `set` is writable and its size is given.
    if unsafe { libc::sched_getaffinity(0, mem::size_of::<libc::cpu_set_t>(), &mut set) } != 0 {
        return Vec::new();
    }
    // SAFETY: CPU_ISSET reads one bit, and the index is below the size of the set.
    (0..libc::CPU_SETSIZE as usize).filter(|&cpu| unsafe { libc::CPU_ISSET(cpu, &set) }).collect()
}

fn pin(wish: Option<usize>) -> io::Result<usize> {
    let allowed = allowed_cores();
    let cpu = match wish {
        Some(cpu) if allowed.contains(&cpu) => cpu,
        Some(cpu) => return Err(io::Error::other(format!("core {cpu} is not among the allowed ones"))),
        None => *allowed.last().ok_or_else(|| io::Error::other("the allowed cores are not known"))?,
    };
    // SAFETY: as in `allowed_cores`, the empty set is all zero.
    let mut set: libc::cpu_set_t = unsafe { mem::zeroed() };
    // SAFETY: `cpu` came out of a set of the same size, so the bit exists.
    unsafe { libc::CPU_SET(cpu, &mut set) };
    // SAFETY: pid 0 is the calling thread; `set` is readable and its size is given.
    check(unsafe { libc::sched_setaffinity(0, mem::size_of::<libc::cpu_set_t>(), &set) })?;
    Ok(cpu)
}

fn set_timer_slack() -> io::Result<()> {
    // SAFETY: PR_SET_TIMERSLACK takes one number and no pointer.
    check(unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, 1 as libc::c_ulong, 0, 0, 0) })
}

fn timer_slack_ns() -> u64 {
    // SAFETY: PR_GET_TIMERSLACK takes no pointer and returns the number.
    u64::try_from(unsafe { libc::prctl(libc::PR_GET_TIMERSLACK, 0, 0, 0, 0) }).unwrap_or(0)
}

fn kernel_row() -> Row {
    let version = std::fs::read_to_string("/proc/sys/kernel/version").unwrap_or_default();
    let preempt_rt = version.contains("PREEMPT_RT");
    let throttle = std::fs::read_to_string("/proc/sys/kernel/sched_rt_runtime_us").unwrap_or_default();
    Row {
        id: "kernel",
        asked: "a kernel that preempts itself (PREEMPT_RT)".into(),
        granted: preempt_rt,
        required: false,
        found: format!("{}; sched_rt_runtime_us {}", version.trim(), throttle.trim()),
        cost: "rare wake-ups late by 100 µs and more while the kernel is busy elsewhere",
        remedy: if preempt_rt { String::new() } else { "sudo apt install linux-image-rt-amd64   (then reboot)".into() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_asked_for_when_off() {
        let (held, mut report) = prepare_process(&Wish::OFF);
        prepare_thread(&Wish::OFF, &mut report);
        assert!(report.rows.is_empty());
        assert!(!held.locked && held.dma_latency.is_none());
        assert_eq!(report.policy, "SCHED_OTHER");
    }

    #[test]
    fn every_refusal_names_its_cost_and_what_to_type() {
        // A core that does not exist and a priority that does not exist are refused on any machine, to anybody.
        let report = survey(&Wish { mode: Mode::Try, priority: 120, cpu: Some(1023) });
        let ids: Vec<_> = report.rows.iter().map(|row| row.id).collect();
        assert_eq!(ids, ["memory", "idle_states", "core", "scheduler", "timer_slack", "prefault", "kernel"]);
        let refused: Vec<_> = report.missing().map(|row| row.id).collect();
        assert!(refused.contains(&"core") && refused.contains(&"scheduler"), "{refused:?}");
        for row in report.refused() {
            assert!(!row.cost.is_empty() && !row.remedy.is_empty() && !row.found.is_empty(), "{row:?}");
        }
        assert_eq!(report.policy, "SCHED_OTHER");
    }
}
