//! Faults of a driver of Linux's own outputs, its guard and its converters: a driver's process with its guard,
//! on a simulated kernel in a mounted folder. The outputs are the kernel's, which keeps the last duty written.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use rand::rngs::Xoshiro256PlusPlus;
use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use sinew_ipc::{DriverHealth, Fault};
use sinew_linux_tree::{Scans, TRIGGER, Tree};
use sinew_rig::Rig;

use crate::driven::{Bench, CHANNELS, Hardware, PULSE, struck};
use crate::failure::{Failure, expect, unexpected};
use crate::kind::{Group, Kind, between};
use crate::running::{SLACK_MS, wait_for};

/// Silence the guard bears, ms.
const GUARD_MS: f64 = 100.0;
/// Between two beats to the guard, ms, and how long its echo may be missing.
const BEAT_MS: f64 = GUARD_MS / 5.0;
const ECHO_MS: f64 = 2.0 * GUARD_MS;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![driver_killed(), driver_stopped(), guard_killed(), guard_stopped(), unplugged(), converter_fails()]
}

/// A simulated kernel.
struct Kernel(Tree);

impl Hardware for Kernel {
    const GROUP: Group = Group::Linux;
    const RATE_HZ: f64 = 200.0;
    // The kernel counts ns of a period.
    const STEP: f64 = 1e-6;

    fn wired(text: &str, root: &Path) -> String {
        let mut text = text.to_owned();
        for channel in 0..CHANNELS {
            let converter = format!("2-00{:02x}", 0x48 + channel);
            let wired = format!(
                "name = \"wire{channel}\"\nlinux = {{ pwm = \"pwmchip0/{channel}\", v1 = \"{converter}:in_voltage0\", \
                 v2 = \"{converter}:in_voltage1\", v3 = \"{converter}:in_voltage2\", supply = \"{converter}:in_voltage3\", \
                 current = \"{converter}:in_current0\" }}"
            );
            text = text.replace(&format!("name = \"wire{channel}\""), &wired);
        }
        format!(
            "{text}\n[backend]\nkind = \"linux\"\nlinux = {{ root = \"{}\", sampling = \"buffer\", phase = \"synchronised\", \
             trigger = \"{TRIGGER}\", guard_ms = {GUARD_MS} }}\n",
            root.display()
        )
    }

    fn start(rig: &Rig, root: &Path) -> Result<Kernel, Failure> {
        let mut tree = Tree::mount(rig, Scans::OnPhase, root)
            .map_err(|error| Failure::Impossible(format!("no file system in user space ({error})")))?;
        tree.run();
        Ok(Kernel(tree))
    }

    fn put_out(&mut self) -> Option<[f64; CHANNELS]> {
        let kernel = self.0.kernel();
        Some(std::array::from_fn(|channel| kernel.output(channel).duty()))
    }
}

impl Kernel {
    /// Waits until nothing is put out: ms from `from` to the moment the last output went off.
    fn off_ms(&self, from: Instant) -> Result<f64, Failure> {
        wait_for("outputs off", || {
            let kernel = self.0.kernel();
            let off = (0..CHANNELS).all(|channel| kernel.output(channel).duty() == 0.0);
            let last = (0..CHANNELS).filter_map(|channel| kernel.output(channel).changed).max();
            Ok(if off { last.map(|last| last.saturating_duration_since(from).as_secs_f64() * 1e3) } else { None })
        })
    }

    /// Nothing more than the sensing pulse is put out for some time.
    fn stays_off(&mut self) -> Result<(), Failure> {
        for _ in 0..20 {
            thread::sleep(Duration::from_secs_f64(1.0 / Kernel::RATE_HZ));
            let put = self.put_out();
            expect(put.iter().flatten().all(|duty| *duty <= PULSE), || format!("before any reset: {put:?}"))?;
        }
        Ok(())
    }
}

/// The driver's guard.
fn guard(bench: &Bench<Kernel>) -> Result<Pid, Failure> {
    let tasks = PathBuf::from(format!("/proc/{}/task", bench.driver()?.process.pid()));
    for task in fs::read_dir(tasks)? {
        let children = fs::read_to_string(task?.path().join("children"))?;
        if let Some(pid) = children.split_whitespace().find_map(|pid| Pid::from_raw(pid.parse().ok()?)) {
            return Ok(pid);
        }
    }
    unexpected("the driver has no guard")
}

fn strike(pid: Pid, signal: Signal) -> Result<(), Failure> {
    kill_process(pid, signal).map_err(|error| Failure::Unexpected(format!("{signal:?}: {error}")))
}

fn driver_killed() -> Kind {
    let one = |bench: &mut Bench<Kernel>, _: &mut Xoshiro256PlusPlus| {
        let guard = guard(bench)?;
        let from = Instant::now();
        let client = bench.kill_driver()?;
        let off_ms = bench.hardware.off_ms(from)?;
        bench.hardware.stays_off()?;
        expect(client.health() == DriverHealth::Died, || "the client is not told".into())?;
        wait_for("the guard to end", || Ok(test_kill_process(guard).is_err().then_some(())))?;
        Ok(off_ms)
    };
    Kind {
        expected: "its guard puts the outputs to zero at once, and ends; the next driver needs no hand",
        lost: "the run",
        ..struck(
            "linux_driver_killed",
            "SIGKILL to a driver of Linux's own outputs",
            SLACK_MS,
            &[Fault::DriverDied],
            one,
        )
    }
}

fn driver_stopped() -> Kind {
    let one = |bench: &mut Bench<Kernel>, rng: &mut Xoshiro256PlusPlus| {
        let from = Instant::now();
        bench.driver()?.process.signal(Signal::STOP)?;
        thread::sleep(Duration::from_secs_f64(between(rng, 0.35, 0.6)));
        let off_ms = bench.hardware.off_ms(from);
        bench.driver()?.process.signal(Signal::CONT)?;
        let off_ms = off_ms?;
        bench.driver()?.latched(&[Fault::CycleOverrun, Fault::Backend])?;
        bench.hardware.stays_off()?;
        Ok(off_ms)
    };
    Kind {
        expected: "its guard puts the outputs to zero after guard_ms (100 ms) of silence; after SIGCONT all channels are latched",
        ..struck(
            "linux_driver_stopped",
            "SIGSTOP to a driver of Linux's own outputs, SIGCONT after 350 to 600 ms",
            GUARD_MS + SLACK_MS,
            &[Fault::CycleOverrun, Fault::Backend],
            one,
        )
    }
}

fn guard_killed() -> Kind {
    let one = |bench: &mut Bench<Kernel>, _: &mut Xoshiro256PlusPlus| {
        let guard = guard(bench)?;
        let from = Instant::now();
        strike(guard, Signal::KILL)?;
        let off_ms = bench.hardware.off_ms(from)?;
        bench.driver()?.latched(&[Fault::Backend, Fault::CycleOverrun])?;
        bench.hardware.stays_off()?;
        Ok(off_ms)
    };
    Kind {
        expected: "the driver puts the outputs to zero at its next beat (a fifth of guard_ms), latches all, and starts a new guard",
        ..struck("linux_guard_killed", "SIGKILL to the guard", BEAT_MS + SLACK_MS, &[Fault::Backend], one)
    }
}

fn guard_stopped() -> Kind {
    let one = |bench: &mut Bench<Kernel>, _: &mut Xoshiro256PlusPlus| {
        let guard = guard(bench)?;
        let from = Instant::now();
        strike(guard, Signal::STOP)?;
        let off_ms = bench.hardware.off_ms(from);
        strike(guard, Signal::CONT)?;
        let off_ms = off_ms?;
        bench.driver()?.latched(&[Fault::Backend, Fault::CycleOverrun])?;
        bench.hardware.stays_off()?;
        Ok(off_ms)
    };
    Kind {
        expected: "the driver misses its echoes for twice guard_ms and puts the outputs to zero; with an echo again it works after a reset",
        ..struck(
            "linux_guard_stopped",
            "SIGSTOP to the guard, SIGCONT once the outputs are off",
            ECHO_MS + BEAT_MS + SLACK_MS,
            &[Fault::Backend],
            one,
        )
    }
}

fn unplugged() -> Kind {
    let one = |bench: &mut Bench<Kernel>, rng: &mut Xoshiro256PlusPlus| {
        let from = Instant::now();
        bench.hardware.0.kernel().unplug();
        let latched = bench.driver()?.latched_by_the_backend();
        let latched_ms = from.elapsed().as_secs_f64() * 1e3;
        thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.05)));
        bench.hardware.0.kernel().plug_in();
        latched?;
        bench.hardware.stays_off()?;
        Ok(latched_ms)
    };
    Kind {
        expected: "all latched, here in ms from its end; what comes back is found again, puts nothing out until a reset, then works",
        ..struck(
            "linux_chips_unplugged",
            "PWM chips and converters vanish and come back",
            2e3 / Kernel::RATE_HZ + SLACK_MS,
            &[Fault::Backend],
            one,
        )
    }
}

fn converter_fails() -> Kind {
    let one = |bench: &mut Bench<Kernel>, rng: &mut Xoshiro256PlusPlus| {
        let victim = usize::from(between(rng, 0.0, 1.0) < 0.5);
        let from = Instant::now();
        bench.hardware.0.kernel().converters[victim].broken = true;
        wait_for("its output off", || Ok(bench.hardware.put_out().filter(|put| put[victim] == 0.0)))?;
        let changed = bench.hardware.0.kernel().output(victim).changed;
        let off_ms = changed.map_or(f64::NAN, |at| at.saturating_duration_since(from).as_secs_f64() * 1e3);
        let fault = wait_for("the fault", || Ok(bench.driver()?.client.latest().channel[victim].fault()))?;
        bench.hardware.0.kernel().converters[victim].broken = false;
        expect(matches!(fault, Fault::Backend | Fault::NoSample), || format!("recognised as {fault:?}"))?;
        let (other, state) = (1 - victim, bench.driver()?.client.latest());
        expect(state.channel[other].fault().is_none(), || format!("the other wire: {:?}", state.channel[other]))?;
        // Not at once: it may just have a dark period.
        wait_for("the other wire's power", || Ok(bench.hardware.put_out().filter(|put| put[other] > PULSE)))?;
        Ok(off_ms)
    };
    Kind {
        expected: "that channel off and latched; the other one works on",
        lost: "that channel's power until its reset",
        ..struck(
            "linux_converter_fails",
            "reads of one converter answer EIO",
            2e3 / Kernel::RATE_HZ + SLACK_MS,
            &[Fault::Backend, Fault::NoSample],
            one,
        )
    }
}
