//! The loop that simulates the microcontroller: time by an absolute timer, bytes from the line, fault injection by orders.

use std::os::fd::{AsFd, OwnedFd};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};

use rustix::event::{PollFd, PollFlags, poll};
use rustix::time::{
    Itimerspec, TimerfdClockId, TimerfdFlags, TimerfdTimerFlags, Timespec, timerfd_create, timerfd_settime,
};
use serde::Serialize;
use sinew_backend::clock::now_ns;
use sinew_front_end::{ChannelFault, Event, FULL_DUTY, Firmware, MAX_CHANNELS};
use sinew_rig::{FaultKind, Rig};

use crate::error::Error;
use crate::line::{Direction, Spoilt};
use crate::port::{Port, Read};
use crate::truth::Truth;
use crate::wires::Wires;
use crate::wiring::{Mount, Wrong};

/// Longest sleep, so that orders are taken, and how often a line with nobody on it is looked at, ns.
const NAP_NS: u64 = 5_000_000;
const ALONE_NS: u64 = 1_000_000;

/// How to run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// A serial device; `None` = a pseudo-terminal.
    pub device: Option<PathBuf>,
    /// Where to leave a link to the pseudo-terminal, which stays when that is another one.
    pub link: Option<PathBuf>,
    /// What is wrong with the line, to the front-end and from it.
    pub spoilt: [Spoilt; 2],
    /// Seed of what is wrong with it.
    pub seed: u64,
    /// End by itself after so long, ns; `None` = never.
    pub duration_ns: Option<u64>,
    /// Tell every change of what is put out.
    pub tell_outputs: bool,
    /// Where to write every wire's true temperature, a row of CSV every 10 ms: the wires outlive the driver.
    pub truth: Option<PathBuf>,
    /// What is wrong with the wiring.
    pub wrong: Vec<Wrong>,
    /// What is at the terminals, by the channels' places in the rig; wires where nothing is said.
    pub mounts: Vec<Mount>,
}

/// What can be done to it while it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// Takes the line away; the pseudo-terminal is gone.
    Disconnect,
    /// Brings it back: another pseudo-terminal under the same link.
    Connect,
    /// Nothing passes for so long, ns, then everything at once.
    Stall(u64),
    /// Another kind of bad line, to the front-end and from it.
    Spoil([Spoilt; 2]),
    /// A power stage breaks.
    Break(u8, ChannelFault),
    /// It is whole again.
    Mend(u8),
    /// Something of the simulated wires breaks, by the channel's place in the rig: a stage that conducts, an emergency stop that is
    /// pressed.
    Fault(usize, FaultKind),
    /// It is whole again.
    Whole(usize, FaultKind),
    /// Something else is at a channel's terminals, by its place in the rig.
    Mount(usize, Mount),
    /// Something more is wrong with the wiring.
    Wire(Wrong),
    /// The wiring is right, and the wires are new.
    Rewire,
    /// The end.
    Quit,
}

/// Something that happened, and when.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Told {
    /// CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
    /// What.
    #[serde(flatten)]
    pub what: What,
}

/// Kinds of [`Told`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum What {
    /// The line is there; the driver is to open this.
    Port {
        /// The device.
        path: PathBuf,
    },
    /// The line was taken away.
    Disconnected,
    /// A driver has said what the wires may have.
    Configured {
        /// The period, ns.
        period_ns: u32,
    },
    /// It asked for what cannot be had.
    Refused,
    /// Outputs follow the duty frames.
    Running,
    /// Outputs are off.
    Off {
        /// `watchdog`, `driver` or `emergency_stop`.
        why: &'static str,
        /// How long no good frame had come, ns; for the watchdog.
        silent_ns: Option<u64>,
        /// Whether anything was put out until then; for the watchdog.
        powered: Option<bool>,
    },
    /// What is put out is another from now on; where [`Options::tell_outputs`] asks for it.
    Outputs {
        /// The duties, of 65535, by place.
        duty: Vec<u16>,
    },
    /// A channel is off.
    Fault {
        /// Its place.
        channel: u8,
        /// What it is.
        fault: &'static str,
    },
    /// It has ended.
    Ended {
        /// Its figures.
        figures: Figures,
    },
}

/// What a run came to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Figures {
    /// Wake-ups for something due.
    pub wakeups: u64,
    /// Worst lateness of one, ns.
    pub late_ns: u64,
}

/// A front-end on a thread of this process. Dropped, it ends.
#[derive(Debug)]
pub struct Host {
    orders: Sender<Order>,
    put: Arc<[AtomicU16]>,
    path: PathBuf,
    told: Receiver<Told>,
    thread: Option<JoinHandle<Result<Figures, Error>>>,
}

impl Host {
    /// Starts it for a rig's wires.
    ///
    /// # Errors
    /// Whatever [`run`] finds out before its line is there.
    pub fn start(rig: &Rig, options: Options) -> Result<Host, Error> {
        let (orders, taken) = mpsc::channel();
        let (tell, told) = mpsc::channel();
        let put: Arc<[AtomicU16]> = (0..MAX_CHANNELS).map(|_| AtomicU16::new(0)).collect();
        let (rig, shown) = (rig.clone(), put.clone());
        let thread = thread::spawn(move || {
            run(&rig, &options, &taken, shown, &mut |told| {
                let _ = tell.send(told);
            })
        });
        loop {
            match told.recv() {
                Ok(Told { what: What::Port { path }, .. }) => {
                    return Ok(Host { orders, put, path, told, thread: Some(thread) });
                }
                Ok(_) => {}
                Err(_) => {
                    return Err(match thread.join() {
                        Ok(Err(error)) => error,
                        _ => Error::Timer(std::io::Error::other("the front-end's thread died while it started")),
                    });
                }
            }
        }
    }

    /// What the driver is to open.
    pub fn path(&self) -> &std::path::Path {
        &self.path
    }

    /// The next thing that has happened, in order.
    pub fn told(&self) -> Option<Told> {
        self.told.try_recv().ok()
    }

    /// Does something to it.
    pub fn order(&self, order: Order) {
        let _ = self.orders.send(order);
    }

    /// What is put out at a place, 0 ..= 1.
    pub fn put_out(&self, place: usize) -> f64 {
        self.put.get(place).map_or(0.0, |put| f64::from(put.load(Ordering::Relaxed)) / f64::from(FULL_DUTY))
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.order(Order::Quit);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Runs a front-end until it is stopped, in the calling thread. `put` shows the present outputs.
///
/// # Errors
/// A line, a timer or wires that cannot be had.
pub fn run(
    rig: &Rig,
    options: &Options,
    orders: &Receiver<Order>,
    put: Arc<[AtomicU16]>,
    tell: &mut dyn FnMut(Told),
) -> Result<Figures, Error> {
    let (mut wires, who) = Wires::new(rig, put, &options.wrong, &options.mounts)?;
    wires.changes = options.tell_outputs.then(Vec::new);
    let timer = timerfd_create(TimerfdClockId::Monotonic, TimerfdFlags::NONBLOCK | TimerfdFlags::CLOEXEC)
        .map_err(|error| Error::Timer(error.into()))?;
    let mut device = Device {
        options,
        wires,
        firmware: Firmware::new(who),
        down: Direction::new(options.spoilt[0], options.seed),
        up: Direction::new(options.spoilt[1], options.seed.wrapping_add(1)),
        port: None,
        alone: false,
        timer,
        figures: Figures::default(),
        truth: options.truth.as_deref().map(|path| Truth::create(path, rig)).transpose()?,
    };
    device.connect(tell)?;
    let figures = device.run(orders, tell)?;
    tell(Told { monotonic_ns: now_ns(), what: What::Ended { figures } });
    Ok(figures)
}

struct Device<'o> {
    options: &'o Options,
    wires: Wires,
    firmware: Firmware,
    down: Direction,
    up: Direction,
    port: Option<Port>,
    /// Nobody is at the other end.
    alone: bool,
    timer: OwnedFd,
    figures: Figures,
    truth: Option<Truth>,
}

impl Device<'_> {
    fn run(&mut self, orders: &Receiver<Order>, tell: &mut dyn FnMut(Told)) -> Result<Figures, Error> {
        let end_ns = self.options.duration_ns.map_or(u64::MAX, |duration_ns| now_ns().saturating_add(duration_ns));
        let mut due_ns = u64::MAX;
        loop {
            // Time first: bytes that accumulated on the line since the last poll are evaluated by it.
            let mut now = now_ns();
            if now >= due_ns {
                self.figures.wakeups += 1;
                self.figures.late_ns = self.figures.late_ns.max(now - due_ns);
            }
            self.wires.now_ns = now;
            self.firmware.poll(now, &mut self.wires);
            match orders.try_recv() {
                Ok(Order::Quit) => break,
                Ok(order) => self.obey(order, now, tell)?,
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => {}
            }
            self.receive(now);
            while let Some(frame) = self.down.arrived(now) {
                self.firmware.receive(&frame, now, &mut self.wires);
            }
            now = now_ns();
            self.wires.now_ns = now;
            let next_ns = self.firmware.poll(now, &mut self.wires);
            self.send(now);
            for (monotonic_ns, duty) in self.wires.changes.iter_mut().flat_map(std::mem::take) {
                tell(Told { monotonic_ns, what: What::Outputs { duty } });
            }
            for event in std::mem::take(&mut self.wires.told) {
                tell(Told { monotonic_ns: now, what: what(event) });
            }
            if let Some(truth) = &mut self.truth {
                truth.write(now, &mut self.wires)?;
            }
            if now >= end_ns {
                break;
            }
            let line_ns = self.down.due_ns().into_iter().chain(self.up.due_ns());
            due_ns = line_ns.chain(next_ns).min().unwrap_or(u64::MAX);
            self.sleep(due_ns, now)?;
        }
        if let Some(truth) = &mut self.truth {
            truth.finish()?;
        }
        Ok(self.figures)
    }

    fn connect(&mut self, tell: &mut dyn FnMut(Told)) -> Result<(), Error> {
        let port = match &self.options.device {
            Some(path) => Port::device(path, 2_000_000)?,
            None => Port::pty(self.options.link.as_deref())?,
        };
        tell(Told { monotonic_ns: now_ns(), what: What::Port { path: port.path.clone() } });
        self.port = Some(port);
        Ok(())
    }

    fn obey(&mut self, order: Order, now: u64, tell: &mut dyn FnMut(Told)) -> Result<(), Error> {
        match order {
            Order::Disconnect => {
                self.port = None;
                self.down.clear();
                self.up.clear();
                tell(Told { monotonic_ns: now_ns(), what: What::Disconnected });
            }
            Order::Connect if self.port.is_none() => self.connect(tell)?,
            Order::Connect | Order::Quit => {}
            Order::Stall(time_ns) => {
                self.down.stall(now.saturating_add(time_ns));
                self.up.stall(now.saturating_add(time_ns));
            }
            Order::Spoil([down, up]) => (self.down.spoilt, self.up.spoilt) = (down, up),
            Order::Break(channel, fault) => {
                if let Some(broken) = self.wires.broken.get_mut(usize::from(channel)) {
                    *broken = Some(fault);
                }
            }
            Order::Fault(channel, kind) => drop(self.wires.faults().set(channel, kind)),
            Order::Whole(channel, kind) => drop(self.wires.faults().clear(channel, kind)),
            Order::Mount(channel, mount) => self.wires.mount(channel, mount)?,
            Order::Wire(wrong) => {
                let all: Vec<Wrong> = self.wires.wrong().iter().copied().chain([wrong]).collect();
                self.wires.wire(&all)?;
            }
            Order::Rewire => self.wires.wire(&[])?,
            Order::Mend(channel) => {
                if let Some(broken) = self.wires.broken.get_mut(usize::from(channel)) {
                    *broken = None;
                }
            }
        }
        Ok(())
    }

    fn receive(&mut self, now: u64) {
        let Some(port) = &self.port else { return };
        let mut buffer = [0; 4096];
        match port.read(&mut buffer) {
            Read::Bytes(count) => {
                self.alone = false;
                self.down.put(&buffer[..count], now);
            }
            Read::Nothing => self.alone = false,
            Read::Alone => self.alone = true,
        }
    }

    fn send(&mut self, now: u64) {
        let sent = std::mem::take(&mut self.wires.sent);
        self.up.put(&sent, now);
        while let Some(frame) = self.up.arrived(now) {
            if let Some(port) = &self.port {
                port.write(&frame);
            }
        }
    }

    /// Until something is due, or comes.
    fn sleep(&self, due_ns: u64, now: u64) -> Result<(), Error> {
        let listens = self.port.as_ref().filter(|_| !self.alone);
        let nap_ns = if self.port.is_some() && self.alone { ALONE_NS } else { NAP_NS };
        let until_ns = due_ns.min(now + nap_ns);
        let at = Timespec { tv_sec: (until_ns / 1_000_000_000) as i64, tv_nsec: (until_ns % 1_000_000_000) as _ };
        let once = Itimerspec { it_interval: Timespec { tv_sec: 0, tv_nsec: 0 }, it_value: at };
        timerfd_settime(&self.timer, TimerfdTimerFlags::ABSTIME, &once).map_err(|error| Error::Timer(error.into()))?;
        let timer = PollFd::new(&self.timer, PollFlags::IN);
        let waited = match listens {
            Some(port) => {
                let fd = port.as_fd();
                poll(&mut [timer, PollFd::from_borrowed_fd(fd, PollFlags::IN)], None)
            }
            None => poll(&mut [timer], None),
        };
        match waited {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(Error::Timer(error.into())),
        }
    }
}

impl std::fmt::Debug for Device<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Device").field("state", &self.firmware.state()).finish_non_exhaustive()
    }
}

fn what(event: Event) -> What {
    match event {
        Event::Configured { period_ns } => What::Configured { period_ns },
        Event::Refused(_) => What::Refused,
        Event::Running => What::Running,
        Event::Silent { since_ns, powered } => {
            What::Off { why: "watchdog", silent_ns: Some(since_ns), powered: Some(powered) }
        }
        Event::Off => What::Off { why: "driver", silent_ns: None, powered: None },
        Event::Stopped => What::Off { why: "emergency_stop", silent_ns: None, powered: None },
        Event::Fault { channel, fault } => What::Fault {
            channel,
            fault: match fault {
                ChannelFault::OverCurrent => "over_current",
                ChannelFault::Heat => "heat",
                ChannelFault::Converter => "converter",
                ChannelFault::StageHot => "stage_hot",
                ChannelFault::Stage => "stage",
            },
        },
    }
}
