//! Faults of the driver's process and its machine: real processes, real time. The outputs are those of the
//! output log (witness).

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rand::rngs::Xoshiro256PlusPlus;
use rustix::process::Signal;
use sinew_ipc::{Client, DriverHealth, Error, Fault, Mode};

use crate::clocks::Clocks;
use crate::failure::{Failure, expect, unexpected};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::running::{DUTY, How, LONG, PATIENCE, Process, RATE_HZ, Running, SLACK_MS, accounted, command, wait_for};
use crate::site::Site;
use crate::witness::now_ns;

/// Time without punctual control that switches everything off, ms: `sinew_driver::supervisor::OVERRUN_S`.
const OVERRUN_MS: f64 = 250.0;

/// All kinds of this group, and those of the loop that need a process.
pub fn kinds() -> Vec<Kind> {
    vec![
        helper_or_loop_panics("panic_in_the_loop", "the backend panics in the loop's thread", "panic"),
        helper_or_loop_panics("panic_in_a_helper", "the thread that answers clients panics", "panic-helper"),
        loop_stalls(),
        loop_late(),
        dies("driver_killed", "SIGKILL", Signal::KILL),
        dies("driver_segfault", "SIGSEGV", Signal::SEGV),
        dies("driver_aborts", "SIGABRT: what a failed allocation ends in", Signal::ABORT),
        out_of_memory(),
        ends("driver_terminated", "SIGTERM", Signal::TERM),
        ends("driver_interrupted", "SIGINT", Signal::INT),
        stopped(),
        stopped_briefly(),
        clock_step(),
        suspended(),
        starved(),
        second_driver(),
        shared_memory_full_at_the_start(),
        shared_memory_full(),
        no_descriptors(),
        runtime_folder_gone(),
    ]
}

/// A kind whose every try has a driver of its own, all under one name: each start finds what the one before left.
fn fresh(
    name: &'static str,
    injected: &'static str,
    within_ms: f64,
    faults: &'static [Fault],
    one: impl Fn(&Site, Running, &mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Process,
        injected,
        expected: "",
        within: within_ms,
        unit: Unit::Milliseconds,
        lost: "",
        faults,
        carry_out: Box::new(move |site, trials| {
            let rig = site.name(name);
            trials.each(|rng| {
                let running = Running::start(site, &rig, &How::default())?;
                std::thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.02)));
                one(site, running, rng)
            })
        }),
    }
}

fn dies(name: &'static str, injected: &'static str, signal: Signal) -> Kind {
    let one = move |_: &Site, mut running: Running, _: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        // More than once: Rust's own handler lets the first segmentation fault pass that no instruction has made.
        wait_for("its end", || {
            running.process.signal(signal)?;
            running.process.ended()
        })?;
        wait_for("the client to be told", || Ok((running.client.health() == DriverHealth::Died).then_some(())))?;
        match running.client.set_duty("wire0", DUTY, LONG) {
            Err(Error::DriverGone { stopped: false, .. }) => {}
            other => return unexpected(format!("a command to a dead driver: {other:?}")),
        }
        // The next try starts under the same name: leftovers of this one must not prevent it.
        running.powered_until_ms(from)
    };
    Kind {
        expected: "nothing goes out any more; the power stage's own watchdog switches off; clients are told; the next start needs no hand",
        lost: "the run; nothing has to be cleaned up",
        ..fresh(name, injected, SLACK_MS, &[Fault::DriverDied], one)
    }
}

/// The kernel's own killer, in a memory group too small for what the driver is made to take.
fn out_of_memory() -> Kind {
    static GROUPS: AtomicU64 = AtomicU64::new(0);
    let one = |_: &Site, mut running: Running, _: &mut Xoshiro256PlusPlus| {
        let group = std::path::PathBuf::from(format!(
            "/sys/fs/cgroup/memory/sinew-trust-{}-{}",
            std::process::id(),
            GROUPS.fetch_add(1, Ordering::Relaxed)
        ));
        let impossible = |error: std::io::Error| Failure::Impossible(format!("{}: {error}", group.display()));
        std::fs::create_dir(&group).map_err(impossible)?;
        let moved = std::fs::write(group.join("memory.limit_in_bytes"), "16777216")
            .and_then(|()| std::fs::write(group.join("cgroup.procs"), running.process.pid().to_string()));
        let ended = moved.map_err(impossible).and_then(|()| {
            running.process.tell("eat")?;
            wait_for("the kernel to kill it", || running.process.ended())
        });
        let _ = running.process.signal(Signal::KILL);
        let _ = running.process.finish();
        let _ = std::fs::remove_dir(&group);
        ended?;
        expect(running.client.health() == DriverHealth::Died, || "the client is not told".into())?;
        // It may have run on for a while; required is that its outputs never paused before its end.
        let put = running.put()?;
        let gap = put.windows(2).map(|pair| pair[1].at_ns - pair[0].at_ns).max().unwrap_or(0);
        Ok(gap as f64 * 1e-6)
    };
    Kind {
        expected: "killed by the kernel as a whole (no pause longer than this before it); the power stage's own watchdog switches off; clients are told",
        lost: "the run; nothing has to be cleaned up",
        ..fresh(
            "out_of_memory",
            "a thread of it eats the 16 MiB its memory group has left: the kernel's killer",
            OVERRUN_MS,
            &[Fault::DriverDied],
            one,
        )
    }
}

fn ends(name: &'static str, injected: &'static str, signal: Signal) -> Kind {
    let one = move |_: &Site, mut running: Running, _: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        running.process.signal(signal)?;
        let zero_ms = running.zero_ms(from)?;
        let report = running.ended_in_order()?;
        expect(report["ended"] == "stopped", || format!("ended: {}", report["ended"]))?;
        expect(running.client.health() == DriverHealth::Stopped, || "the client is not told".into())?;
        let state = running.client.latest();
        expect(state.channels().iter().all(|c| c.duty == 0.0), || "the last state shows a duty".into())?;
        Ok(zero_ms)
    };
    Kind {
        expected: "outputs zero, report, exit 0",
        lost: "nothing: every period is in the report",
        ..fresh(name, injected, SLACK_MS, &[Fault::Stopping], one)
    }
}

fn helper_or_loop_panics(name: &'static str, injected: &'static str, word: &'static str) -> Kind {
    let one = move |_: &Site, mut running: Running, _: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        running.process.tell(word)?;
        let zero_ms = running.zero_ms(from)?;
        let report = running.ended_in_order()?;
        expect(report["ended"] == "panicked", || format!("ended: {}", report["ended"]))?;
        Ok(zero_ms)
    };
    Kind {
        group: Group::Loop,
        expected: "outputs zero through the backend, report says \"panicked\"",
        lost: "the run",
        ..fresh(name, injected, SLACK_MS, &[Fault::Stopping], one)
    }
}

/// What a gap in the loop has to leave behind: everything off and latched, and a reset that brings it back.
fn overrun(running: &Running, fault: Fault) -> Result<(), Failure> {
    wait_for("the fault", || {
        Ok(running.client.latest().channels().iter().all(|c| c.fault() == Some(fault)).then_some(()))
    })?;
    for channel in ["wire0", "wire1"] {
        wait_for("the reset", || match running.client.reset(channel) {
            Ok(_) => Ok(Some(())),
            Err(Error::Refused(_)) => Ok(None),
            Err(error) => Err(error.into()),
        })?;
    }
    running.at_work()
}

/// Periods with power after a gap that began at `from_ns`, the one that ended it included.
fn powered_after_gap(running: &Running, from_ns: u64) -> Result<f64, Failure> {
    let put = running.put()?;
    let gap = put.windows(2).rposition(|pair| (pair[1].at_ns - pair[0].at_ns) as f64 * 1e-6 > 0.8 * OVERRUN_MS);
    let Some(gap) = gap.filter(|&gap| put[gap + 1].at_ns > from_ns) else { return unexpected("there was no gap") };
    let after = &put[gap + 1..];
    Ok(after.iter().take_while(|put| put.powers()).count() as f64)
}

/// What a driver does after a gap that began at `from_ns`: periods with power, then everything off and latched, and a reset that
/// brings it back.
fn after_gap(running: Running, from_ns: u64) -> Result<f64, Failure> {
    wait_for("the fault", || Ok(running.client.latest().channel[0].fault().map(drop)))?;
    let periods = powered_after_gap(&running, from_ns)?;
    overrun(&running, Fault::CycleOverrun)?;
    running.stop()?;
    Ok(periods)
}

fn loop_stalls() -> Kind {
    let one = |_: &Site, mut running: Running, rng: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        running.process.tell(&format!("stall {}", whole(rng, 320, 600)))?;
        after_gap(running, from)
    };
    Kind {
        group: Group::Loop,
        expected: "all channels off after the gap, latched (until then the power stage's own watchdog); periods with power after it",
        unit: Unit::Periods,
        lost: "the power of all until their reset; the periods of the gap, counted as missed",
        ..fresh("backend_hangs", "an exchange that takes 320 to 600 ms", 1.0, &[Fault::CycleOverrun], one)
    }
}

fn loop_late() -> Kind {
    let one = |_: &Site, mut running: Running, rng: &mut Xoshiro256PlusPlus| {
        for _ in 0..5 {
            running.process.tell(&format!("stall {}", whole(rng, 2, 60)))?;
            std::thread::sleep(Duration::from_millis(80));
        }
        let state = running.client.latest();
        let good = state.channels().iter().all(|c| c.fault().is_none() && c.duty == DUTY);
        // Five gaps and a host that takes the core as well may add up; then it is the other row.
        expect(good || state.channels().iter().all(|c| c.fault() == Some(Fault::CycleOverrun)), || {
            format!("{:?}", state.channels())
        })?;
        let report = running.stop()?;
        expect(report["missed"].as_u64() >= Some(10), || format!("missed: {}", report["missed"]))?;
        Ok(if good { 0.0 } else { 1.0 })
    };
    Kind {
        group: Group::Loop,
        expected: "goes on at the next point of its grid, the periods between counted as missed",
        unit: Unit::Periods,
        lost: "the periods that passed, counted",
        ..fresh("backend_slow", "five exchanges that take 2 to 60 ms", 0.0, &[], one)
    }
}

fn stopped() -> Kind {
    let one = |_: &Site, running: Running, rng: &mut Xoshiro256PlusPlus| {
        running.process.signal(Signal::STOP)?;
        let from = now_ns();
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.35, 0.7)));
        let until_ms = running.powered_until_ms(from)?;
        expect(until_ms < SLACK_MS, || format!("it put something out {until_ms} ms after SIGSTOP"))?;
        running.process.signal(Signal::CONT)?;
        after_gap(running, from)
    };
    Kind {
        expected: "nothing goes out; the power stage's own watchdog switches off; after SIGCONT all channels off, latched; periods with power after it",
        unit: Unit::Periods,
        lost: "the power of all until their reset; the periods of the stop, counted as missed",
        ..fresh(
            "driver_stopped",
            "SIGSTOP for 350 to 700 ms, then SIGCONT",
            1.0,
            &[Fault::CycleOverrun, Fault::DriverDied],
            one,
        )
    }
}

fn stopped_briefly() -> Kind {
    let one = |_: &Site, running: Running, rng: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        running.process.hold()?;
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.005, 0.1)));
        running.process.signal(Signal::CONT)?;
        let cycle = running.client.latest().cycle;
        wait_for("the loop to go on", || Ok((running.client.latest().cycle > cycle + 20).then_some(())))?;
        let gap_ms = (now_ns() - from) as f64 * 1e-6;
        let state = running.client.latest();
        let good = state.channels().iter().all(|c| c.duty == DUTY && c.fault().is_none());
        // A machine that sleeps longer than requested may make it the other row.
        let overrun = || gap_ms > OVERRUN_MS && state.channels().iter().all(|c| c.fault() == Some(Fault::CycleOverrun));
        expect(good || overrun(), || format!("after {gap_ms} ms: {:?}", state.channels()))?;
        let report = running.stop()?;
        expect(report["missed"].as_u64() >= Some(3), || format!("missed: {}", report["missed"]))?;
        Ok(0.0)
    };
    Kind {
        expected: "goes on; the periods between counted as missed",
        unit: Unit::Periods,
        lost: "the periods of the stop, counted as missed",
        ..fresh("driver_stopped_briefly", "SIGSTOP for 5 to 100 ms, then SIGCONT", 0.0, &[], one)
    }
}

/// A clock of the driver's own that is moved while it drives; one driver for all tries.
fn moved(
    name: &'static str,
    injected: &'static str,
    faults: &'static [Fault],
    one: impl Fn(&Clocks, &Running, &mut Xoshiro256PlusPlus) -> Result<f64, Failure> + Send + Sync + 'static,
) -> Kind {
    Kind {
        name,
        group: Group::Process,
        injected,
        expected: "",
        within: 0.0,
        unit: Unit::Periods,
        lost: "",
        faults,
        carry_out: Box::new(move |site, trials| {
            let clocks = Clocks::new(site)?;
            let running = Running::start(site, &site.name(name), &clocks.how())?;
            trials.each(|rng| one(&clocks, &running, rng))?;
            running.stop().map(drop)
        }),
    }
}

fn clock_step() -> Kind {
    let one = |clocks: &Clocks, running: &Running, rng: &mut Xoshiro256PlusPlus| {
        let hold = Duration::from_millis(60);
        let mut stream = running.client.stream()?;
        running.client.set_duty("wire0", 2.0 * DUTY, hold)?;
        let missed = running.client.latest().missed;
        // Up to ten years to either side.
        let year_ns = 365.0 * 86_400.0 * 1e9;
        clocks.set_wall_ns((between(rng, -10.0, 10.0) * year_ns) as i64)?;
        // By the cycles' own times: when they are read does not matter for the lease.
        let mut taken_ns = None;
        let lasted_ns = wait_for("the lease to run out", || {
            while let Some(cycle) = stream.next()? {
                let (wire, now_ns) = (&cycle.channels[0], cycle.header.monotonic_ns);
                match taken_ns {
                    None if wire.duty == 2.0 * DUTY => taken_ns = Some(now_ns),
                    Some(taken_ns) if wire.mode() == Mode::Lapsed => return Ok(Some(now_ns - taken_ns)),
                    _ => {}
                }
            }
            Ok(None)
        })?;
        let lasted_ms = lasted_ns as f64 * 1e-6;
        expect(lasted_ms > 50.0, || format!("a lease of 60 ms lasted {lasted_ms} ms"))?;
        expect(lasted_ms < 60.0 + OVERRUN_MS, || format!("a lease of 60 ms lasted {lasted_ms} ms"))?;
        let state = running.client.latest();
        expect(state.channel[1].duty == DUTY && state.channel[1].fault().is_none(), || {
            format!("{:?}", state.channel[1])
        })?;
        let missed = state.missed - missed;
        // What the machine itself costs is no matter of the clock: much less than the step.
        expect((missed as f64) < 0.2 * RATE_HZ, || format!("{missed} periods missed"))?;
        Ok(0.0)
    };
    Kind {
        expected: "nothing at all: loop, leases and clients live by CLOCK_MONOTONIC, which nobody can set; the lease ends when it should",
        lost: "nothing",
        ..moved("clock_step", "the wall clock set by up to ten years, for this process alone", &[], one)
    }
}

fn suspended() -> Kind {
    let slept_ns = AtomicU64::new(0);
    let one = move |clocks: &Clocks, running: &Running, rng: &mut Xoshiro256PlusPlus| {
        let by = (between(rng, 0.5, 36_000.0) * 1e9) as u64;
        let ahead = slept_ns.fetch_add(by, Ordering::Relaxed) + by;
        clocks.set_suspended_ns(ahead as i64)?;
        let from = now_ns();
        wait_for("the fault", || Ok(running.client.latest().channel[0].fault().map(drop)))?;
        let put = running.put()?;
        let powered = put.iter().filter(|put| put.at_ns > from + 2_000_000 && put.powers()).count();
        overrun(running, Fault::Suspended)?;
        Ok(powered as f64)
    };
    Kind {
        expected: "all channels off in the first cycle after it, latched, although no lease has run out and no period was missed; periods with power after it (counted from 2 ms on)",
        within: 1.0,
        lost: "the power of all until their reset",
        ..moved(
            "machine_suspended",
            "CLOCK_BOOTTIME leaps ahead of CLOCK_MONOTONIC by 0.5 s to 10 h, as after a suspension",
            &[Fault::Suspended],
            one,
        )
    }
}

fn starved() -> Kind {
    Kind {
        name: "cpu_starved",
        group: Group::Process,
        injected: "three busy threads for each core",
        expected: "goes on (SCHED_FIFO), or switches all off as `cycle_overrun`; every period counted; longest time a wire was powered without control",
        within: OVERRUN_MS + SLACK_MS,
        unit: Unit::Milliseconds,
        lost: "the periods the machine takes, counted as missed",
        faults: &[Fault::CycleOverrun],
        carry_out: Box::new(|site, trials| {
            let cores = std::thread::available_parallelism().map_or(2, usize::from);
            let load: Result<Vec<Process>, Failure> = (0..3 * cores)
                .map(|_| Process::start(site, std::process::Command::new(site.itself()?).arg("occupy")))
                .collect();
            let load = load?;
            let running = Running::start(site, &site.name("starved"), &How::default())?;
            let mut seen = running.put()?.len();
            trials.each(|_| {
                std::thread::sleep(Duration::from_millis(100));
                let put = running.put()?;
                let gap = put[seen - 1..].windows(2).map(|pair| pair[1].at_ns - pair[0].at_ns).max().unwrap_or(0);
                seen = put.len();
                let state = running.client.latest();
                if state.channel[0].fault() == Some(Fault::CycleOverrun) {
                    overrun(&running, Fault::CycleOverrun)?;
                } else {
                    let good = state.channels().iter().all(|c| c.duty == DUTY && c.fault().is_none());
                    expect(good, || format!("{:?}", state.channels()))?;
                }
                Ok(gap as f64 * 1e-6)
            })?;
            running.stop()?;
            drop(load);
            Ok(())
        }),
    }
}

fn second_driver() -> Kind {
    Kind {
        name: "second_driver",
        group: Group::Process,
        injected: "another driver for the same rig",
        expected: "refuses, naming the first; puts nothing out; the first does not notice",
        within: 0.0,
        unit: Unit::Periods,
        lost: "nothing",
        faults: &[],
        carry_out: Box::new(|site, trials| {
            let running = Running::start(site, &site.name("second"), &How::default())?;
            let mut stream = running.client.stream()?;
            let pid = running.process.pid().to_string();
            trials.each(|_| {
                let (mut command, log, _) = command(site, &running.rig, 2, &How::default())?;
                let mut second = Process::start(site, &mut command)?;
                let status = second.finish()?;
                expect(!status.success() && second.said().contains(&pid), || format!("{status}: {}", second.said()))?;
                let put = crate::witness::read(&log, 2).unwrap_or_default();
                while let Some(cycle) = stream.next()? {
                    expect(cycle.channels.iter().all(|c| c.duty == DUTY), || "the first is disturbed".into())?;
                }
                expect(stream.lost() == 0, || format!("{} cycles lost", stream.lost()))?;
                Ok(put.iter().filter(|put| put.powers()).count() as f64)
            })?;
            running.stop().map(drop)
        }),
    }
}

/// A program in a mount namespace of its own, where `/dev/shm` has so much room.
const SMALL_SHM: [&str; 4] = ["unshare", "-m", "sh", "-c"];

fn shared_memory_full_at_the_start() -> Kind {
    Kind {
        name: "shared_memory_full_at_start",
        group: Group::Process,
        injected: "16 KiB to 2 MiB left in /dev/shm when the driver starts",
        expected: "refuses, naming what it lacks; nothing goes out",
        within: 0.0,
        unit: Unit::Periods,
        lost: "the start",
        faults: &[],
        carry_out: Box::new(|site, trials| {
            let rig = site.name("shm0");
            trials.each(|rng| {
                let kib = whole(rng, 16, 2048);
                let mount = format!("mount -t tmpfs -o size={kib}k tmpfs /dev/shm && exec \"$0\" \"$@\"");
                let wrapper: Vec<&str> = SMALL_SHM.into_iter().chain([mount.as_str()]).collect();
                let (mut command, log, _) = command(site, &rig, 2, &How { wrapper: &wrapper, ..How::default() })?;
                let mut process = Process::start(site, &mut command)?;
                let status = process.finish()?;
                if process.said().contains("unshare") || process.said().contains("mount:") {
                    return Err(Failure::Impossible(process.said()));
                }
                expect(!status.success() && process.said().contains("shared memory"), || {
                    format!("{status}: {}", process.said())
                })?;
                let put = crate::witness::read(&log, 2).unwrap_or_default();
                Ok(put.iter().filter(|put| put.powers()).count() as f64)
            })
        }),
    }
}

fn shared_memory_full() -> Kind {
    Kind {
        name: "shared_memory_full",
        group: Group::Process,
        injected: "/dev/shm filled to the last byte while it drives",
        expected: "goes on, with the client it has; every cycle accounted for",
        within: 0.0,
        unit: Unit::Periods,
        lost: "what newcomers would need; nothing of those who are there",
        faults: &[],
        carry_out: Box::new(|site, trials| {
            let mount = "mount -t tmpfs -o size=64m tmpfs /dev/shm && exec \"$0\" \"$@\"";
            let wrapper: Vec<&str> = SMALL_SHM.into_iter().chain([mount]).collect();
            let (mut command, log, report) =
                command(site, &site.name("shm"), 2, &How { wrapper: &wrapper, ..How::default() })?;
            let mut process = Process::start(site, &mut command)?;
            wait_for("the driver to start", || match process.ended()? {
                Some(_) => Err(Failure::Impossible(process.said())),
                None => Ok(crate::witness::read(&log, 2).ok().filter(|put| put.len() > 50)),
            })?;
            let filler = format!("/proc/{}/root/dev/shm/filler", process.pid());
            trials.each(|rng| {
                let mut file = std::fs::File::create(&filler)?;
                let chunk = [0u8; 65536];
                while std::io::Write::write_all(&mut file, &chunk).is_ok() {}
                while std::io::Write::write_all(&mut file, &[0]).is_ok() {}
                let before = crate::witness::read(&log, 2)?.len();
                std::thread::sleep(Duration::from_secs_f64(between(rng, 0.05, 0.15)));
                let goes_on = wait_for("cycles while it is full", || {
                    Ok((crate::witness::read(&log, 2)?.len() > before + 10).then_some(()))
                });
                std::fs::remove_file(&filler)?;
                goes_on?;
                expect(process.ended()?.is_none(), || format!("it ended: {}", process.said()))?;
                Ok(0.0)
            })?;
            process.signal(Signal::TERM)?;
            process.finish()?;
            accounted(&report).map(drop)
        }),
    }
}

fn no_descriptors() -> Kind {
    Kind {
        name: "no_file_descriptors",
        group: Group::Process,
        injected: "not one file descriptor more for the driver, while clients come and go",
        expected: "goes on with the clients it has; newcomers are refused or served",
        within: 0.0,
        unit: Unit::Periods,
        lost: "newcomers, while it lasts",
        faults: &[],
        carry_out: Box::new(|site, trials| {
            let running = Running::start(site, &site.name("fds"), &How::default())?;
            let pid = running.process.pid();
            let open = std::fs::read_dir(format!("/proc/{pid}/fd"))?.count();
            let limit = std::process::Command::new("prlimit")
                .args(["--pid", &pid.to_string(), &format!("--nofile={open}:{open}")])
                .status()
                .map_err(|error| Failure::Impossible(format!("prlimit: {error}")))?;
            expect(limit.success(), || "prlimit is refused".into())?;
            let mut stream = running.client.stream()?;
            let mut served = 0;
            trials.each(|_| {
                // Their timeout is short: they are refused, or served, but none may hang.
                let newcomer = Client::connect(&running.rig);
                served += usize::from(newcomer.is_ok());
                running.client.set_duty("wire0", DUTY, LONG)?;
                while let Some(cycle) = stream.next()? {
                    expect(cycle.channels.iter().all(|c| c.duty == DUTY), || "a wire is disturbed".into())?;
                }
                expect(stream.lost() == 0, || format!("{} cycles lost", stream.lost()))?;
                Ok(0.0)
            })?;
            running.stop().map(drop)
        }),
    }
}

fn runtime_folder_gone() -> Kind {
    let one = |site: &Site, rng: &mut Xoshiro256PlusPlus| {
        let folder = tempfile::Builder::new().prefix("sr-").tempdir_in("/tmp")?;
        let how = How { env: vec![("SINEW_RUNTIME_DIR", folder.path().into())], ..How::default() };
        let rig = site.name("gone");
        let start = || -> Result<_, Failure> {
            let (mut command, log, report) = command(site, &rig, 2, &how)?;
            let mut process = Process::start(site, &mut command)?;
            wait_for("the driver to start", || match process.ended()? {
                Some(status) => unexpected(format!("{status}: {}", process.said())),
                None => Ok(crate::witness::read(&log, 2).ok().filter(|put| put.len() > 20).map(drop)),
            })?;
            Ok((process, log, report))
        };
        let (mut process, log, report) = start()?;
        std::fs::remove_dir_all(folder.path())?;
        let before = crate::witness::read(&log, 2)?.len();
        std::thread::sleep(Duration::from_secs_f64(between(rng, 0.02, 0.06)));
        wait_for(
            "cycles without the folder",
            || Ok((crate::witness::read(&log, 2)?.len() > before + 5).then_some(())),
        )?;
        process.signal(Signal::TERM)?;
        process.finish()?;
        accounted(&report)?;
        let (mut next, _, _) = start()?;
        next.signal(Signal::TERM)?;
        expect(next.finish()?.success(), || next.said())?;
        Ok(0.0)
    };
    Kind {
        name: "runtime_folder_removed",
        group: Group::Process,
        injected: "the runtime folder removed under a running driver",
        expected: "goes on and ends in order; the next driver starts without a hand",
        within: 0.0,
        unit: Unit::Periods,
        lost: "newcomers cannot find this run any more",
        faults: &[],
        carry_out: Box::new(move |site, trials| trials.each(|rng| one(site, rng))),
    }
}

/// What is left of the machine when somebody else wants all of it; ends with its parent's patience.
pub fn occupy() {
    let until = std::time::Instant::now() + 30 * PATIENCE;
    let mut number = 1u64;
    while std::time::Instant::now() < until {
        for _ in 0..1_000_000 {
            number = std::hint::black_box(number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1));
        }
    }
}
