//! A driver of no wires, for the tests: publishes states that can be checked for being whole, and answers commands.

use sinew_ipc::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Where waiting becomes a failure. Machines are busy.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A client that gives its driver time.
pub fn patient(rig: &str) -> Client {
    let options = ClientOptions { connect: PATIENCE, answer: PATIENCE };
    Client::connect_with(rig, options).unwrap_or_else(|e| panic!("{e}"))
}

/// A rig name no other test has.
pub fn rig(test: &str) -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    format!("t-{}-{}-{test}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed))
}

/// `n` channels called c0, c1, …
pub fn info(rig: &str, n: usize, rate_hz: f64) -> Info {
    info_of(rig, &(0..n).map(|i| format!("c{i}")).collect::<Vec<_>>(), rate_hz)
}

/// Channels of these names.
pub fn info_of(rig: &str, names: &[String], rate_hz: f64) -> Info {
    let channels: Vec<ChannelInfo> = names
        .iter()
        .map(|name| ChannelInfo {
            name: Name::new(name).unwrap(),
            min_length_m: 0.155,
            max_length_m: 0.17,
            hot_length_m: 0.16,
            cold_length_m: 0.166,
            lease_s: 0.5,
            ..ChannelInfo::EMPTY
        })
        .collect();
    Info::new(rig, rate_hz, &channels).unwrap()
}

/// A state in which every field of every channel follows from the cycle, so that parts of two can be told.
pub fn state(cycle: u64, channels: usize) -> Snapshot {
    let mut s = Snapshot::new(channels);
    s.cycle = cycle;
    s.monotonic_ns = monotonic_ns();
    s.missed = cycle * 3;
    s.state = DriverState::Running.code();
    for (i, c) in s.channel[..channels].iter_mut().enumerate() {
        let x = (cycle * 64 + i as u64) as f64;
        *c = ChannelState {
            velocity_m_s: x + 0.25,
            acceleration_m_s2: -x,
            lease_s: x + 0.5,
            v1_v: -x,
            current_a: x + 0.75,
            mode: Mode::Length.code(),
            flags: cycle as u32,
            ..ChannelState::from_parts(&[x; ChannelState::FLOATS], &[0; ChannelState::CODES])
        };
    }
    s
}

/// Whether these channels are all of this cycle.
pub fn assert_whole(cycle: u64, missed: u64, channels: &[ChannelState]) {
    assert_eq!(missed, cycle * 3, "header of cycle {cycle}");
    for (i, c) in channels.iter().enumerate() {
        let x = (cycle * 64 + i as u64) as f64;
        let fields =
            [c.measured_length_m, c.velocity_m_s - 0.25, -c.acceleration_m_s2, c.target_m, c.duty, c.resistance_ohm];
        let others = [c.temperature_c, c.martensite, c.power_w, c.surface, c.lease_s - 0.5];
        assert!(fields.iter().chain(&others).all(|f| *f == x), "cycle {cycle}, channel {i}: {c:?}");
        assert_eq!(c.flags, cycle as u32, "cycle {cycle}, channel {i}");
    }
}

/// Answers as a driver would: checks the range, grants the lease.
pub fn decide(command: &Command) -> Reply {
    match command.kind() {
        None => Reply::refused(command, Outcome::UnknownCommand),
        Some(_) if command.channel != ALL_CHANNELS && command.channel >= 64 => {
            Reply::refused(command, Outcome::UnknownChannel)
        }
        Some(_) if !command.value.is_finite() => Reply::refused(command, Outcome::NotFinite),
        Some(CommandKind::Stroke) if !(0.0..=1.0).contains(&command.value) => {
            Reply::refused(command, Outcome::OutOfRange).range(0.0, 1.0)
        }
        Some(CommandKind::Force) => Reply::refused(command, Outcome::Unsupported),
        Some(CommandKind::Reset) => Reply::refused(command, Outcome::CauseRemains).because(Fault::OpenWire),
        Some(_) => Reply::taken(command, if command.hold_s > 0.0 { command.hold_s } else { 0.5 }),
    }
}

/// A driver in threads of this process: a loop at `rate_hz` and an ordinary thread.
pub struct Driver {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Driver {
    pub fn start(rig: &str, channels: usize, rate_hz: f64) -> Driver {
        Driver::with(&info(rig, channels, rate_hz), decide)
    }

    pub fn with(info: &Info, mut decide: impl FnMut(&Command) -> Reply + Send + 'static) -> Driver {
        let (channels, rate_hz) = (info.channels().len(), info.rate_hz);
        let server = Server::create(RigLock::acquire(info.rig.as_str()).unwrap(), info).unwrap();
        let (mut writer, mut cycles, mut commands) = server.split();
        let stop = Arc::new(AtomicBool::new(false));
        let (send, receive) = std::sync::mpsc::channel::<Snapshot>();
        let period = Duration::from_secs_f64(1.0 / rate_hz);
        let stopped = stop.clone();
        let looping = std::thread::spawn(move || {
            let mut cycle = 0;
            let mut next = Instant::now();
            while !stopped.load(Ordering::Relaxed) {
                cycle += 1;
                let s = state(cycle, channels);
                writer.update(&s);
                if send.send(s).is_err() {
                    break;
                }
                next += period;
                std::thread::sleep(next.saturating_duration_since(Instant::now()));
            }
            let mut last = state(cycle + 1, channels);
            last.state = DriverState::Stopped.code();
            writer.update(&last);
        });
        let publishing = std::thread::spawn(move || {
            loop {
                match receive.recv_timeout(Duration::from_millis(1)) {
                    Ok(s) => {
                        cycles.push_snapshot(&s);
                        while let Ok(s) = receive.try_recv() {
                            cycles.push_snapshot(&s);
                        }
                        cycles.flush();
                        cycles.ring();
                    }
                    Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
                    Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
                }
                commands.serve(&mut decide);
            }
        });
        Driver { stop, threads: vec![looping, publishing] }
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            thread.join().unwrap();
        }
    }
}

/// Waits for something that must come true; the limit only ends a test that has failed.
pub fn until(what: &str, mut check: impl FnMut() -> bool) {
    let started = Instant::now();
    while !check() {
        assert!(started.elapsed() < PATIENCE, "never: {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
