//! A whole driver: starts and stops lock, services, real time, loop, publisher and command thread in order.

use std::sync::atomic::Ordering;
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use sinew_ipc::gateway::{Access, Readers};
use sinew_ipc::{
    ChannelInfo, ChannelState, CommandServer, CyclePublisher, HeldCycle, Info, LoopStats, Name, RigLock, Server,
    Snapshot, StateWriter,
};
use sinew_rig::{RealtimeMode, Rig};
use sinew_ring::ring;

use crate::baseline;
use crate::claims::Claims;
use crate::commands::{ChannelRules, Desk};
use crate::cycles::{Cycles, Outlet, Remains, Shared};
use crate::engine::Engine;
use crate::error::Error;
use crate::fault_log::FaultLog;
use crate::grid::Pace;
use crate::inbox::way_in;
use crate::memory::Memory;
use crate::orders::Told;
use crate::program::Program;
use crate::publish::{self, Tap};
use crate::report::{self, BareLoop, ChannelReport, FaultRecord, Quantiles, RunReport};
use sinew_backend::allocations;
use sinew_backend::{Backend, Zero};
use sinew_realtime as realtime;
use sinew_realtime::{Held, Mode, RealtimeReport, Wish};
use sinew_threads::{Start, Thread, caught};

/// Runs that are tried at a start.
const RUNS: usize = 8;
/// Events that may be on their way out of it.
const EVENTS: usize = 8192;
/// The ring to the publisher holds so much time, s, and at least so many cycles, but no more than so many bytes: on a busy machine an
/// ordinary thread may not run for a second.
const RING_S: f64 = 2.0;
const RING_CYCLES: usize = 256;
const RING_BYTES: usize = 64 << 20;

/// How to run, beyond what the rig file says.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Stop by itself after so long, s of the loop's clock; `None` = never.
    pub duration_s: Option<f64>,
    /// What the channels do while nobody commands them.
    pub program: Option<Program>,
    /// Run a bare timer loop for so long, s, in the same thread right before the loop, and report its latency as the floor.
    pub floor_s: Option<f64>,
    /// Whether the backend is a simulation, for clients to know.
    pub simulated: bool,
    /// Without any service to other processes (and without the lock on the rig's name): for benchmarks.
    pub private: bool,
}

/// Ends a driver from another thread: outputs go to zero within a period, whatever the thread that holds the driver waits for.
#[derive(Debug, Clone)]
pub struct Stopper {
    shared: Arc<Shared>,
}

impl Stopper {
    /// Asks the loop to end. Returns at once.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// The same because of a thread whose death a driver must not outlive: the report will say so. Takes no lock and waits for nothing.
    pub fn fail(&self) {
        self.shared.fail();
    }

    /// Whether the loop has ended and its outputs were put to zero.
    pub fn has_ended(&self) -> bool {
        self.shared.ended.load(Ordering::Acquire)
    }
}

/// A driver that runs.
#[derive(Debug)]
pub struct Driver;

/// The loop's progress, as seen from outside without disturbing it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stats {
    /// Whether the loop still runs.
    pub running: bool,
    /// Cycles so far.
    pub cycles: u64,
    /// Periods missed so far.
    pub missed: u64,
    /// Faults latched so far, and leases run out.
    pub faults: u64,
}

/// Shows the loop's progress to another thread.
#[derive(Debug, Clone)]
pub struct Progress {
    shared: Arc<Shared>,
    fault_log: Arc<Mutex<FaultLog>>,
}

impl Progress {
    /// The loop's progress.
    pub fn stats(&self) -> Stats {
        let fault_log = self.fault_log.lock().unwrap_or_else(PoisonError::into_inner);
        Stats {
            running: !self.shared.ended.load(Ordering::Acquire),
            cycles: self.shared.cycles.load(Ordering::Relaxed),
            missed: self.shared.missed.load(Ordering::Relaxed),
            faults: fault_log.faults.len() as u64 + fault_log.not_listed,
        }
    }
}

/// The hold on a running driver. Dropped without [`DriverHandle::join`], it stops the driver and waits for it.
#[derive(Debug)]
pub struct DriverHandle {
    shared: Arc<Shared>,
    fault_log: Arc<Mutex<FaultLog>>,
    threads: Option<Threads>,
    rig: String,
    names: Vec<String>,
    rate_hz: f64,
    realtime: RealtimeReport,
    _held: Held,
}

#[derive(Debug)]
struct Threads {
    main: JoinHandle<Option<(Remains, Option<BareLoop>)>>,
    publisher: JoinHandle<Option<()>>,
    desk: JoinHandle<Option<()>>,
}

/// The driver's ends of its services to other processes; a private driver has none.
#[derive(Default)]
struct Services {
    state: Option<StateWriter>,
    cycles: Option<CyclePublisher>,
    commands: Option<CommandServer>,
}

impl Services {
    /// Takes the rig's name and opens the services under it. Where anybody may make files somebody may have taken the name of one: another run
    /// has others.
    fn open(rig: &Rig, rules: &[ChannelRules], simulated: bool) -> Result<Services, Error> {
        let is_over = |tried: &Result<_, _>| !matches!(tried, Err(Error::Services(sinew_ipc::Error::Service { .. })));
        let mut attempts = (1..RUNS).map(|_| Services::open_once(rig, rules, simulated));
        attempts.find(is_over).unwrap_or_else(|| Services::open_once(rig, rules, simulated))
    }

    fn open_once(rig: &Rig, rules: &[ChannelRules], simulated: bool) -> Result<Services, Error> {
        let lock = RigLock::acquire(&rig.name)?;
        // with the laws of a catalogue, which a session of it cannot have at hand
        let rig_text = rig.to_toml();
        lock.leave_rig_text(&rig_text)?;
        let mut info = info(rig, rules)?;
        info.simulated = simulated.into();
        let mut server = Server::create(lock, &info)?;
        if rig.access.is_open() {
            server.open_gateway(&info, &access_of(rig)?, &rig_text)?;
        }
        let (state, cycles, commands) = server.split();
        Ok(Services { state: Some(state), cycles: Some(cycles), commands: Some(commands) })
    }
}

/// What the loop writes to: the blackboard, or nothing.
struct Blackboard(Option<StateWriter>);

impl Outlet for Blackboard {
    #[inline]
    fn latest(&mut self, snapshot: &Snapshot) {
        if let Some(writer) = &mut self.0 {
            writer.update(snapshot);
        }
    }

    #[inline]
    fn stats(&mut self, stats: &LoopStats) {
        if let Some(writer) = &mut self.0 {
            writer.update_stats(stats);
        }
    }
}

/// What a rig file asks of Linux.
pub fn wish_of(rig: &Rig) -> Wish {
    Wish {
        mode: match rig.realtime.mode {
            RealtimeMode::Off => Mode::Off,
            RealtimeMode::Try => Mode::Try,
            RealtimeMode::Strict => Mode::Strict,
        },
        priority: rig.realtime.priority.min(99) as u8,
        cpu: rig.realtime.cpu.map(|cpu| cpu as usize),
    }
}

/// Which other users a rig file lets in, and to do what.
///
/// # Errors
/// [`sinew_ipc::Error::UnknownGroup`].
pub fn access_of(rig: &Rig) -> Result<Access, sinew_ipc::Error> {
    let readers = match rig.access.read_group.as_deref() {
        None => Readers::Nobody,
        Some(sinew_rig::Access::EVERYONE) => Readers::Everyone,
        Some(group) => Readers::Group(group.into()),
    };
    Access::new(rig.access.command_group.as_deref(), rig.access.stop_group.as_deref(), &readers)
}

impl Driver {
    /// Starts a driver for a rig on a backend: takes the rig's name, opens the services, starts the backend (outputs zero) and lets
    /// the loop run on a thread of its own. Returns when it runs.
    ///
    /// # Errors
    /// Everything that is found out before the first cycle; then nothing is left running and outputs are zero.
    pub fn start<B: Backend + 'static>(rig: &Rig, backend: B, options: Options) -> Result<DriverHandle, Error> {
        Driver::start_tapped(rig, backend, options, Vec::new())
    }

    /// The same with observers of every cycle, such as a black box, in this order.
    ///
    /// # Errors
    /// As [`Driver::start`].
    pub fn start_tapped<B: Backend + 'static>(
        rig: &Rig,
        backend: B,
        options: Options,
        taps: Vec<Box<dyn Tap>>,
    ) -> Result<DriverHandle, Error> {
        let program = options.program.clone();
        let backend_is_new = backend.is_at_rest();
        let mut engine = if backend_is_new { Engine::at_rest(rig, program) } else { Engine::new(rig, program) }?;
        engine.bear_silence(backend.silence_s().ok_or(Error::Endless)?);
        let channels = engine.channels().len();
        if backend.channels() != channels {
            return Err(Error::Channels { expected: channels, found: backend.channels() });
        }
        let rules = ChannelRules::of(rig)?;
        let names: Vec<String> = rig.channels.iter().map(|channel| channel.name.clone()).collect();
        let pace = match (rig.simulation.pace, rig.simulation.speed) {
            (sinew_rig::Pace::AsFastAsPossible, _) => Pace::Simulated { speed: f64::INFINITY },
            (sinew_rig::Pace::RealTime, 1.0) => Pace::RealTime,
            (sinew_rig::Pace::RealTime, speed) => Pace::Simulated { speed },
        };
        // A loop that never sleeps would occupy its core permanently.
        let wish = if pace == Pace::RealTime { wish_of(rig) } else { Wish::OFF };

        let services =
            if options.private { Services::default() } else { Services::open(rig, &rules, options.simulated)? };

        // After the services, so that their memory is locked with the rest.
        let (held, realtime) = realtime::prepare_process(&wish);
        let period_ns = (1e9 / rig.rate_hz).round() as u64;
        let fitting = RING_BYTES / (channels * size_of::<ChannelState>());
        let room = ((RING_S * rig.rate_hz) as usize).min(fitting).max(RING_CYCLES);
        let (outbox, orders) = way_in();
        let (events, events_out) = ring(vec![Told::NONE; EVENTS]);
        let (published, publishing) = ring((0..room).map(|_| HeldCycle::new(channels)));
        let shared = Arc::new(Shared::default());
        let fault_log = Arc::new(Mutex::new(FaultLog::default()));
        let memory = if backend_is_new { Memory::default() } else { Memory::of(&backend, channels) };
        let looping = Cycles {
            backend,
            memory,
            engine,
            outlet: Blackboard(services.state),
            orders,
            events,
            published,
            period_ns,
            pace,
            periods: options.duration_s.map_or(u64::MAX, |seconds| (seconds * rig.rate_hz).round().max(0.0) as u64),
            stats: LoopStats::new(),
        };

        let (ready, started) = mpsc::channel();
        let (floor_s, rate_hz) = (options.floor_s, rig.rate_hz);
        let main = {
            let shared = shared.clone();
            let body = move || run_loop(looping, wish, realtime, floor_s, rate_hz, &shared, &ready);
            Thread::Loop.start().stack(realtime::LOOP_STACK).spawn(body).map_err(Error::Thread)?
        };
        let realtime = match started.recv() {
            Ok(Ok(realtime)) => realtime,
            failed => {
                let _ = main.join();
                // Without a message it panicked before its first cycle.
                let died = || Error::Thread(std::io::Error::other("the loop's thread died while it started"));
                return Err(failed.ok().and_then(Result::err).unwrap_or_else(died));
            }
        };

        let publisher = {
            let start = helper(Thread::Publisher, &shared);
            let shared = shared.clone();
            start.spawn(move || {
                realtime::go_first(&wish);
                publish::publish(publishing, services.cycles, taps, &shared);
            })
        };
        let desk = {
            let start = helper(Thread::Desk, &shared);
            let (shared, fault_log) = (shared.clone(), fault_log.clone());
            let claims = Claims::of(rig);
            let desk = Desk {
                port: services.commands,
                rules,
                names: names.clone(),
                outbox,
                events: events_out,
                claims,
                held: Vec::new(),
            };
            start.spawn(move || {
                // Whoever switches something off waits for it.
                realtime::go_first(&wish);
                desk.serve(&shared, &fault_log);
            })
        };
        let (publisher, desk) = match (publisher, desk) {
            (Ok(publisher), Ok(desk)) => (publisher, desk),
            (Err(error), _) | (_, Err(error)) => {
                shared.stop.store(true, Ordering::Relaxed);
                let _ = main.join();
                return Err(Error::Thread(error));
            }
        };
        Ok(DriverHandle {
            shared,
            fault_log,
            threads: Some(Threads { main, publisher, desk }),
            rig: rig.name.clone(),
            names,
            rate_hz,
            realtime,
            _held: held,
        })
    }
}

/// The loop's thread from its first to its last instruction.
fn run_loop<B: Backend>(
    mut looping: Cycles<B, Blackboard>,
    wish: Wish,
    mut realtime: RealtimeReport,
    floor_s: Option<f64>,
    rate_hz: f64,
    shared: &Shared,
    ready: &mpsc::Sender<Result<RealtimeReport, Error>>,
) -> (Remains, Option<BareLoop>) {
    let _said = SaysItEnded(shared);
    realtime::prepare_thread(&wish, &mut realtime);
    let refused: Vec<String> = realtime
        .missing()
        .map(|row| format!("{} ({}); without it {}; to get it: {}", row.asked, row.found, row.cost, row.remedy))
        .collect();
    let failure = if wish.mode == Mode::Strict && !refused.is_empty() {
        Some(Error::NotRealtime { refused })
    } else {
        match caught(|| looping.backend.start()) {
            Ok(started) => started.err().map(Error::Backend),
            Err(words) => {
                Some(Error::Thread(std::io::Error::other(format!("the backend panicked while it started: {words}"))))
            }
        }
    };
    if let Some(error) = failure {
        // It did not come up, and the error says so.
        let _ = looping.backend.stop();
        let _ = ready.send(Err(error));
        return (Remains::nothing(), None);
    }
    looping.memory.recall(&mut looping.engine, &looping.backend);
    looping.stats.realtime = bits(&realtime);
    looping.stats.priority = realtime.priority.into();
    looping.stats.cpu = realtime.cpu.map_or(-1, |cpu| cpu as i32);
    let _ = ready.send(Ok(realtime));
    let floor = floor_s.filter(|_| looping.pace == Pace::RealTime).map(|s| baseline::bare_loop(rate_hz, s));
    (looping.run(shared), floor)
}

fn bits(realtime: &RealtimeReport) -> u32 {
    let granted = |id: &str| realtime.rows.iter().any(|row| row.id == id && row.granted);
    let rows = [
        ("scheduler", LoopStats::RT_FIFO),
        ("memory", LoopStats::RT_LOCKED),
        ("prefault", LoopStats::RT_PREFAULTED),
        ("core", LoopStats::RT_PINNED),
        ("timer_slack", LoopStats::RT_SLACK),
        ("idle_states", LoopStats::RT_LATENCY),
    ];
    rows.iter().filter(|(id, _)| granted(id)).fold(0, |bits, (_, bit)| bits | bit)
}

/// A helper that dies takes the driver along in good order: outputs to zero, report. It works until the loop has ended.
fn helper(thread: Thread, shared: &Arc<Shared>) -> Start {
    let (over, failed) = (shared.clone(), shared.clone());
    thread.start().ends_when(move || over.ended.load(Ordering::Acquire)).on_death(move || failed.fail())
}

/// Says that the loop's thread has ended, also where it died beyond all that is caught in there: who waits for its end must not wait for ever.
struct SaysItEnded<'a>(&'a Shared);

impl Drop for SaysItEnded<'_> {
    fn drop(&mut self) {
        self.0.ended.store(true, Ordering::Release);
    }
}

fn info(rig: &Rig, rules: &[ChannelRules]) -> Result<Info, sinew_ipc::Error> {
    let channels = rig.channels.iter().zip(rules).map(|(channel, rules)| {
        Ok(ChannelInfo {
            name: Name::new(&channel.name)?,
            min_length_m: rules.min_length_m,
            max_length_m: rules.max_length_m,
            hot_length_m: rules.stroke.hot_m,
            cold_length_m: rules.stroke.cold_m,
            rest_length_m: channel.model.geometry.length_m,
            max_duty: rules.max_duty,
            max_current_a: channel.limits.max_current_a,
            max_power_w: channel.limits.max_power_w,
            max_temperature_c: channel.limits.max_temperature_c,
            lease_s: rules.lease_s,
        })
    });
    let channels: Vec<ChannelInfo> = channels.collect::<Result<_, sinew_ipc::Error>>()?;
    Info::new(&rig.name, rig.rate_hz, &channels)
}

impl DriverHandle {
    /// Asks the loop to end: outputs go to zero within a period. Returns at once; [`DriverHandle::join`] waits.
    pub fn stop(&self) {
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// What ends it from another thread.
    pub fn stopper(&self) -> Stopper {
        Stopper { shared: self.shared.clone() }
    }

    /// Whether the loop still runs. It may have ended by itself: its time is over, a client asked for it, its code panicked.
    pub fn is_running(&self) -> bool {
        !self.shared.ended.load(Ordering::Acquire)
    }

    /// Resets the emergency stop, as somebody who stands by the rig may: with the next cycle, if it is closed. Nothing starts by it.
    pub fn reset_emergency_stop(&self) {
        self.shared.reset_stop.store(true, Ordering::Relaxed);
    }

    /// What Linux granted.
    pub fn realtime(&self) -> &RealtimeReport {
        &self.realtime
    }

    /// The loop's progress, now and later.
    pub fn progress(&self) -> Progress {
        Progress { shared: self.shared.clone(), fault_log: self.fault_log.clone() }
    }

    /// Waits until the loop has ended (without stopping it) and returns the run's report.
    pub fn join(mut self) -> RunReport {
        let (remains, floor) = self.wait();
        self.report(remains, floor)
    }

    fn wait(&mut self) -> (Remains, Option<BareLoop>) {
        let Some(threads) = self.threads.take() else { return (Remains::nothing(), None) };
        // The loop catches its own panics; should its thread have died nevertheless, what its outputs are is not known.
        let died = || (Remains { zero: Zero::Unconfirmed, ..Remains::nothing() }, None);
        let ended = threads.main.join().ok().flatten().unwrap_or_else(died);
        let _ = threads.publisher.join();
        let _ = threads.desk.join();
        ended
    }

    fn report(&self, remains: Remains, floor: Option<BareLoop>) -> RunReport {
        let fault_log = std::mem::take(&mut *self.fault_log.lock().unwrap_or_else(PoisonError::into_inner));
        let name = |channel: u32| self.names.get(channel as usize).cloned().unwrap_or_default();
        let stats = &remains.stats;
        RunReport {
            schema: report::SCHEMA,
            rig: self.rig.clone(),
            ended: remains.ending,
            seconds: (stats.cycles + stats.missed) as f64 / self.rate_hz,
            rate_hz: self.rate_hz,
            channels: self.names.len(),
            cycles: stats.cycles,
            missed: stats.missed,
            missed_by_wakeup: remains.missed.by_wakeup,
            missed_by_cycle: remains.missed.by_cycle,
            lateness_us: Quantiles::of(&stats.lateness),
            cycle_us: Quantiles::of(&stats.cycle_time),
            period_us: Quantiles::of(&stats.period),
            floor,
            allocations_in_loop: allocations::is_counting().then_some(stats.allocations),
            unpublished: stats.ring_drops + self.shared.unsent.load(Ordering::Relaxed),
            rt: self.realtime.clone(),
            faults: fault_log
                .faults
                .iter()
                .map(|&(at_ns, channel, fault)| FaultRecord {
                    time_s: at_ns.saturating_sub(remains.start_ns) as f64 * 1e-9,
                    channel: name(channel),
                    flag: fault.flag(),
                    cause: fault.cause(),
                })
                .collect(),
            faults_not_listed: fault_log.not_listed + self.shared.events_lost.load(Ordering::Relaxed),
            leases_lapsed: fault_log.lapsed,
            threads_died: sinew_threads::rows(sinew_threads::dead()).map(|row| row.name).collect(),
            backend_error: remains.last_error.map(|error| error.to_string()),
            outputs_confirmed_zero: remains.zero == Zero::Confirmed,
            black_boxes: Vec::new(),
            black_box_error: None,
            channel: remains
                .last
                .channels()
                .iter()
                .zip(&self.names)
                .map(|(state, name)| ChannelReport {
                    name: name.clone(),
                    length_m: state.length_m,
                    target_m: state.target_m,
                    duty: state.duty,
                    fault: state.fault().map(|fault| fault.flag()),
                })
                .collect(),
        }
    }
}

impl Drop for DriverHandle {
    fn drop(&mut self) {
        self.stop();
        self.wait();
    }
}
