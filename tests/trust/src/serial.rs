//! Faults of a front-end, its line and its driver: a driver's process, and the firmware of a front-end on a
//! thread of this one, with a pseudo-terminal between them. The outputs are measured at the front-end, not as reported by
//! the driver.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU16;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rand::rngs::Xoshiro256PlusPlus;
use rustix::process::Signal;
use sinew_front_end::{FULL_DUTY, MAX_CHANNELS};
use sinew_front_end_host::{Options, Order, Spoilt, Told, What, run};
use sinew_ipc::{CycleStream, DriverHealth, Fault};
use sinew_realtime as realtime;
use sinew_realtime::Wish;
use sinew_rig::Rig;

use crate::driven::{Bench, CHANNELS, DUTY, Hardware, PULSE, struck};
use crate::failure::{Failure, expect, unexpected};
use crate::kind::{Group, Kind, Unit, between, whole};
use crate::running::{LONG, SLACK_MS, wait_for};
use crate::witness::{Put, now_ns};

/// A period, ms.
const PERIOD_MS: f64 = 1e3 / Line::RATE_HZ;
/// Silence the front-end bears, in periods and ms.
const WATCHDOG_PERIODS: u32 = 10;
const SILENCE_MS: f64 = WATCHDOG_PERIODS as f64 * PERIOD_MS;
/// Share of the frames a bad line spoils, each way.
const SHARE: f64 = 0.2;
/// Setpoints that follow each other on a bad line, each lower than the one before.
const STEPS: usize = 12;

/// All kinds of this group.
pub fn kinds() -> Vec<Kind> {
    vec![
        driver_killed(),
        driver_stopped(),
        unplugged(),
        stalls(),
        front_end_restarts(),
        bad(
            "line_loses_frames",
            "one frame in five is lost, each way, for 0.6 s",
            Spoilt { lost: SHARE, ..Spoilt::default() },
        ),
        bad(
            "line_damages_frames",
            "a bit is turned in one frame in five, each way, for 0.6 s",
            Spoilt { damaged: SHARE, ..Spoilt::default() },
        ),
        bad(
            "line_swaps_frames",
            "one frame in five comes after the next one, each way, for 0.6 s",
            Spoilt { swapped: SHARE, ..Spoilt::default() },
        ),
    ]
}

/// A front-end on a thread of this process. Dropped, it dies with its line.
struct FrontEnd {
    orders: Sender<Order>,
    told: Receiver<Told>,
    thread: Option<JoinHandle<()>>,
}

impl FrontEnd {
    fn start(rig: &Rig, link: &Path, seed: u64) -> Result<FrontEnd, Failure> {
        let (orders, taken) = mpsc::channel();
        let (tell, told) = mpsc::channel();
        let options = Options { link: Some(link.into()), seed, tell_outputs: true, ..Options::default() };
        let rig = rig.clone();
        let thread = thread::spawn(move || {
            // As punctual as a microcontroller, where Linux allows it; the driver's loop has the last core.
            let wish = Wish { mode: realtime::Mode::Try, priority: 60, cpu: Some(0) };
            let (_held, mut report) = realtime::prepare_process(&wish);
            realtime::prepare_thread(&wish, &mut report);
            let put: Arc<[AtomicU16]> = (0..MAX_CHANNELS).map(|_| AtomicU16::new(0)).collect();
            let _ = run(&rig, &options, &taken, put, &mut |told| drop(tell.send(told)));
        });
        match told.recv() {
            Ok(_) => Ok(FrontEnd { orders, told, thread: Some(thread) }),
            Err(_) => unexpected("the front-end does not start"),
        }
    }
}

impl Drop for FrontEnd {
    fn drop(&mut self) {
        let _ = self.orders.send(Order::Quit);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A front-end at the end of its line.
struct Line {
    link: PathBuf,
    front_end: FrontEnd,
    /// Every change of the front-end's outputs since the last try began.
    outputs: Vec<Put>,
}

impl Hardware for Line {
    const GROUP: Group = Group::Serial;
    // One late by a period loses a sample.
    const RATE_HZ: f64 = 100.0;
    // Half of what one step of a duty on the line is worth, and a bit.
    const STEP: f64 = 0.6 / FULL_DUTY as f64;

    fn wired(text: &str, folder: &Path) -> String {
        format!(
            "{text}\n[backend]\nkind = \"serial\"\nserial.port = \"{}\"\nserial.watchdog_periods = {WATCHDOG_PERIODS}\n",
            folder.join("line").display()
        )
    }

    fn start(rig: &Rig, folder: &Path) -> Result<Line, Failure> {
        let link = folder.join("line");
        let front_end = FrontEnd::start(rig, &link, 1)?;
        Ok(Line { link, front_end, outputs: Vec::new() })
    }

    fn put_out(&mut self) -> Option<[f64; CHANNELS]> {
        self.look();
        self.outputs.last().and_then(|put| put.duty.as_slice().try_into().ok())
    }

    fn forget(&mut self) {
        self.outputs.drain(..self.outputs.len() - 1);
    }
}

impl Line {
    fn order(&self, order: Order) {
        let _ = self.front_end.orders.send(order);
    }

    /// Takes in what the front-end has put out meanwhile.
    fn look(&mut self) {
        while let Ok(told) = self.front_end.told.try_recv() {
            if let What::Outputs { duty } = told.what {
                let duty = duty.iter().map(|code| f64::from(*code) / f64::from(FULL_DUTY)).collect();
                self.outputs.push(Put { at_ns: told.monotonic_ns, duty });
            }
        }
    }

    /// Waits until the front-end puts nothing out: ms from `from_ns` to that.
    fn off_ms(&mut self, from_ns: u64) -> Result<f64, Failure> {
        wait_for("outputs off", || {
            self.look();
            let zero = self.outputs.last().filter(|put| !put.powers());
            Ok(zero.map(|zero| zero.at_ns.saturating_sub(from_ns) as f64 * 1e-6))
        })
    }

    /// Nothing has gone out since the outputs went off, and nothing does for some time more.
    fn stays_off(&mut self) -> Result<(), Failure> {
        let changes = self.outputs.len();
        thread::sleep(Duration::from_secs_f64(6.0 * PERIOD_MS * 1e-3));
        self.look();
        expect(self.outputs.len() == changes && !self.outputs.last().is_some_and(Put::powers), || {
            format!("before any reset: {:?}", self.outputs.get(changes..))
        })
    }
}

fn driver_killed() -> Kind {
    let one = |bench: &mut Bench<Line>, _: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        let client = bench.kill_driver()?;
        let off_ms = bench.hardware.off_ms(from)?;
        bench.hardware.stays_off()?;
        expect(client.health() == DriverHealth::Died, || "the client is not told".into())?;
        Ok(off_ms)
    };
    Kind {
        expected: "the front-end switches off after 10 periods (100 ms) of silence, and is there for the next driver as it is",
        lost: "the run; the next driver needs no hand, nor does the front-end",
        ..struck(
            "line_driver_killed",
            "SIGKILL to a driver with a front-end",
            SILENCE_MS + SLACK_MS,
            &[Fault::DriverDied],
            one,
        )
    }
}

fn driver_stopped() -> Kind {
    let one = |bench: &mut Bench<Line>, rng: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        bench.driver()?.process.signal(Signal::STOP)?;
        thread::sleep(Duration::from_secs_f64(between(rng, 0.35, 0.6)));
        bench.driver()?.process.signal(Signal::CONT)?;
        let off_ms = bench.hardware.off_ms(from)?;
        bench.driver()?.latched(&[Fault::CycleOverrun, Fault::Backend, Fault::NoSample])?;
        bench.hardware.stays_off()?;
        Ok(off_ms)
    };
    Kind {
        expected: "the front-end switches off after 10 periods (100 ms) of silence; after SIGCONT it puts nothing out, all channels are latched",
        lost: "the power of all until their reset; the periods of the stop, counted as missed",
        ..struck(
            "line_driver_stopped",
            "SIGSTOP for 350 to 600 ms to a driver with a front-end, then SIGCONT",
            SILENCE_MS + SLACK_MS,
            &[Fault::CycleOverrun, Fault::Backend],
            one,
        )
    }
}

fn unplugged() -> Kind {
    let one = |bench: &mut Bench<Line>, rng: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        bench.hardware.order(Order::Disconnect);
        let off_ms = bench.hardware.off_ms(from);
        let latched = bench.driver()?.latched_by_the_backend();
        thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.2)));
        // Whatever came of it: the next try needs the line.
        bench.hardware.order(Order::Connect);
        let off_ms = off_ms?;
        latched?;
        bench.hardware.stays_off()?;
        Ok(off_ms)
    };
    Kind {
        expected: "the front-end switches off after 10 periods (100 ms) of silence, the driver latches all; plugged in again, a reset brings them back",
        lost: "the power of all until line and reset; the driver goes on",
        ..struck(
            "line_unplugged",
            "the line is taken away for 100 to 300 ms",
            SILENCE_MS + SLACK_MS,
            &[Fault::Backend],
            one,
        )
    }
}

fn stalls() -> Kind {
    let one = |bench: &mut Bench<Line>, rng: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        bench.hardware.order(Order::Stall(whole(rng, 150_000_000, 400_000_000)));
        let off_ms = bench.hardware.off_ms(from)?;
        // The second sample that does not come switches off before the silence does.
        bench.driver()?.latched(&[Fault::NoSample, Fault::Backend, Fault::CycleOverrun])?;
        // Everything that was under way arrives in here.
        thread::sleep(Duration::from_millis(420).saturating_sub(Duration::from_nanos(now_ns() - from)));
        bench.hardware.stays_off()?;
        Ok(off_ms)
    };
    Kind {
        expected: "the front-end switches off after 10 periods (100 ms) of silence, the driver latches all; the old frames that come then put nothing out",
        lost: "the power of all until their reset; the driver goes on",
        ..struck(
            "line_stalls",
            "nothing passes for 150 to 400 ms, then everything at once",
            SILENCE_MS + SLACK_MS,
            &[Fault::NoSample, Fault::Backend],
            one,
        )
    }
}

fn front_end_restarts() -> Kind {
    let one = |bench: &mut Bench<Line>, rng: &mut Xoshiro256PlusPlus| {
        let from = now_ns();
        bench.hardware.order(Order::Quit);
        let latched = bench.driver()?.latched_by_the_backend();
        let latched_ms = (now_ns() - from) as f64 * 1e-6;
        thread::sleep(Duration::from_secs_f64(between(rng, 0.0, 0.2)));
        // The old one removes its link when it ends, so it has to have ended first.
        if let Some(thread) = bench.hardware.front_end.thread.take() {
            let _ = thread.join();
        }
        bench.hardware.front_end = FrontEnd::start(&bench.rig, &bench.hardware.link, whole(rng, 0, u64::MAX))?;
        bench.hardware.outputs.clear();
        latched?;
        // Time to find it and to go on talking to it.
        thread::sleep(Duration::from_millis(250));
        bench.hardware.look();
        expect(bench.hardware.outputs.is_empty(), || format!("before any reset: {:?}", bench.hardware.outputs))?;
        Ok(latched_ms)
    };
    Kind {
        expected: "all latched, here in ms from its end; the new one is found and told its limits, puts nothing out until a reset, then works",
        lost: "the power of all until the reset; the driver goes on",
        ..struck(
            "front_end_restarts",
            "the front-end ends with outputs on; a new one comes 0 to 200 ms later",
            2.0 * PERIOD_MS + SLACK_MS,
            &[Fault::Backend],
            one,
        )
    }
}

fn bad(name: &'static str, injected: &'static str, spoilt: Spoilt) -> Kind {
    let one = move |bench: &mut Bench<Line>, _: &mut Xoshiro256PlusPlus| {
        bench.hardware.order(Order::Spoil([spoilt; 2]));
        let driven = drive_down(bench);
        // Whatever came of it: the next try needs a good line.
        bench.hardware.order(Order::Spoil([Spoilt::default(); 2]));
        driven
    };
    Kind {
        unit: Unit::Periods,
        expected: "a sample that does not come takes the power away for that period, the second in a row latches; periods without a sample until off",
        lost: "samples; nothing goes out that was not asked for, and nothing older after something newer",
        ..struck(name, injected, 2.0, &[Fault::NoSample], one)
    }
}

/// One setpoint after the other, each lower than the one before: the most periods without a sample until off.
fn drive_down(bench: &mut Bench<Line>) -> Result<f64, Failure> {
    let before_ns = bench.driver()?.client.latest().monotonic_ns;
    let mut stream = bench.driver()?.client.stream()?;
    let mut asked: Vec<Vec<f64>> = DUTY.iter().map(|duty| vec![0.0, PULSE, *duty]).collect();
    let mut run = Judged { cycles_ns: [before_ns, 0, 0, 0], ..Judged::default() };
    for step in 1..=STEPS {
        for (number, (asked, duty)) in asked.iter_mut().zip(DUTY).enumerate() {
            let duty = duty - 0.005 * step as f64;
            asked.push(duty);
            match bench.driver()?.client.set_duty(&format!("wire{number}"), duty, LONG) {
                // One that is latched refuses.
                Ok(_) | Err(sinew_ipc::Error::Refused(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        thread::sleep(Duration::from_millis(25));
        judge(&mut stream, &mut run)?;
    }
    bench.hardware.look();
    outputs_are(&bench.hardware.outputs, &asked)?;
    Ok(run.wires.iter().map(|run| run.worst).max().unwrap_or(0).into())
}

/// Samples of a channel that did not come.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    now: u32,
    worst: u32,
    over: bool,
}

/// All of them, and when the driver's own cycles were.
#[derive(Debug, Clone, Copy, Default)]
struct Judged {
    wires: [Run; CHANNELS],
    /// The times of the last cycles, newest first, ns.
    cycles_ns: [u64; 4],
}

impl Judged {
    /// The longest the machine has lately kept the driver from its cycle, ms.
    fn late_ms(&self) -> f64 {
        let gaps = self.cycles_ns.windows(2).filter(|pair| pair[1] > 0).map(|pair| pair[0].saturating_sub(pair[1]));
        gaps.max().unwrap_or(0) as f64 * 1e-6
    }
}

/// What the driver did in every cycle of a bad line.
fn judge(stream: &mut CycleStream, judged: &mut Judged) -> Result<(), Failure> {
    while let Some(cycle) = stream.next()? {
        judged.cycles_ns.rotate_right(1);
        judged.cycles_ns[0] = cycle.header.monotonic_ns;
        let late_ms = judged.late_ms();
        for (run, wire) in judged.wires.iter_mut().zip(cycle.channels) {
            run.now = if wire.current_a.is_nan() { run.now + 1 } else { 0 };
            match wire.fault() {
                None if run.over => return unexpected(format!("not latched any more: {wire:?}")),
                None => {
                    run.worst = run.worst.max(run.now);
                    expect(run.now == 0 || wire.duty < PULSE + Line::STEP, || format!("heated unseen: {wire:?}"))?;
                }
                Some(fault) => {
                    if !std::mem::replace(&mut run.over, true) {
                        run.worst = run.worst.max(run.now);
                        // Where the machine delays the driver for long, it or the front-end's watchdog detects that first.
                        let known = match fault {
                            Fault::NoSample => true,
                            Fault::CycleOverrun => late_ms > PERIOD_MS,
                            Fault::Backend => late_ms > 0.7 * SILENCE_MS,
                            _ => false,
                        };
                        expect(known, || format!("latched though late by {late_ms:.0} ms only: {fault:?}, {wire:?}"))?;
                    }
                    expect(wire.duty == 0.0, || format!("latched and heated: {wire:?}"))?;
                }
            }
        }
    }
    expect(stream.lost() == 0, || format!("{} cycles lost here", stream.lost()))
}

/// Everything put out was asked for, setpoints in the order they were.
fn outputs_are(outputs: &[Put], asked: &[Vec<f64>]) -> Result<(), Failure> {
    for (place, asked) in asked.iter().enumerate() {
        let mut before = f64::INFINITY;
        for put in outputs {
            let duty = put.duty.get(place).copied().unwrap_or(f64::NAN);
            expect(asked.iter().any(|asked| (duty - asked).abs() < Line::STEP), || format!("nobody asked for {duty}"))?;
            if duty > PULSE + Line::STEP {
                expect(duty <= before, || format!("{duty} after {before}"))?;
                before = duty;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duty_nobody_asked_for_or_an_old_one_is_found() {
        let put = |duty: &[f64]| duty.iter().map(|duty| Put { at_ns: 0, duty: vec![*duty] }).collect::<Vec<_>>();
        let asked = [vec![0.0, PULSE, 0.1, 0.09]];
        outputs_are(&put(&[0.1, PULSE, 0.1, 0.0, 0.09]), &asked).unwrap();
        for (wrong, word) in [(&[0.1, 0.2][..], "nobody asked"), (&[0.1, 0.09, 0.1], "after"), (&[f64::NAN], "nobody")]
        {
            let failure = outputs_are(&put(wrong), &asked).unwrap_err();
            assert!(failure.to_string().contains(word), "{wrong:?}: {failure}");
        }
    }
}
