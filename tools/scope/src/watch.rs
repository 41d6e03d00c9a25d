//! The thread that watches the driver: every cycle into the history, a look at everything else some times a second.

use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;
use sinew_ipc::{Client, ClientOptions, CycleStream, DriverHealth, Error, Histogram, Snapshot};
use sinew_sensing::Health;
use sinew_server::Figures;

use crate::history::History;
use crate::quantity;
use crate::shared::Shared;
use crate::view::json;

/// Between two looks at what is not a curve: modes, faults, the loop.
pub const LOOK: Duration = Duration::from_millis(100);
/// Between two attempts to find a driver, or a line, again.
pub const RETRY: Duration = Duration::from_millis(300);
/// A rate is counted over at least this long.
const RATE_SPAN: Duration = Duration::from_secs(1);

#[derive(Serialize)]
struct Status {
    kind: &'static str,
    driver: &'static str,
    pid: u32,
    cycle: u64,
    uptime_s: f64,
    rate_hz: f64,
    missed: u64,
    /// What is lost with threads of the driver that have died.
    dead: Vec<String>,
    lost: u64,
    lateness_us: Quantiles,
    cycle_us: Quantiles,
    recording: Option<crate::record::State>,
    traffic: Figures,
    channels: Vec<State>,
}

#[derive(Serialize)]
struct Quantiles {
    p50: f64,
    p99: f64,
    max: f64,
}

#[derive(Serialize)]
struct State {
    mode: &'static str,
    lease_s: f64,
    temperature_c: f64,
    health: Option<&'static str>,
    fault: Option<FaultText>,
}

#[derive(Serialize)]
struct FaultText {
    flag: &'static str,
    cause: &'static str,
    remedy: &'static str,
}

impl Quantiles {
    fn of(histogram: &Histogram) -> Quantiles {
        let us = |ns: u64| ns as f64 * 1e-3;
        Quantiles { p50: us(histogram.quantile(0.5)), p99: us(histogram.quantile(0.99)), max: us(histogram.max()) }
    }
}

/// Watches until the scope is to stop; `stream` is that of the driver the view was made with.
pub fn watch(shared: &Shared, mut stream: CycleStream) {
    let stopping = || shared.stop.load(Ordering::Relaxed);
    while !stopping() && !sinew_threads::is_struck() {
        let client = shared.view().client.clone();
        if let Some(client) = client {
            follow(shared, &client, &mut stream);
        }
        if stopping() {
            break;
        }
        {
            let mut view = shared.view();
            view.client = None;
            view.history.gap(shared.seconds(sinew_ipc::monotonic_ns()));
            let traffic = shared.figures();
            view.status = json(&serde_json::json!({ "kind": "status", "driver": "gone", "traffic": traffic }));
        }
        while !stopping() && !sinew_threads::is_struck() {
            std::thread::sleep(RETRY);
            let options = ClientOptions { connect: Duration::ZERO, ..ClientOptions::default() };
            let found = Client::connect_with(&shared.name, options).and_then(|client| Ok((client.stream()?, client)));
            if let Ok((new, client)) = found {
                stream = new;
                shared.view().meet(Arc::new(client), shared.options.commands);
                break;
            }
        }
    }
}

/// Follows one driver to its end.
fn follow(shared: &Shared, client: &Client, stream: &mut CycleStream) {
    let mut looked: Option<Instant> = None;
    let mut rate = Rate::new();
    while !shared.stop.load(Ordering::Relaxed) && !sinew_threads::is_struck() {
        // all available cycles are read at once, so that the lock is taken once a batch
        let waited = match stream.next_within(Duration::from_millis(20)) {
            Ok(Some(cycle)) => {
                let mut view = shared.view();
                take(shared, &mut view.history, &cycle);
                loop {
                    match stream.next() {
                        Ok(Some(cycle)) => take(shared, &mut view.history, &cycle),
                        Ok(None) => break Ok(()),
                        Err(error) => break Err(error),
                    }
                }
            }
            Ok(None) => Ok(()),
            Err(error) => Err(error),
        };
        if looked.is_none_or(|at| at.elapsed() >= LOOK) {
            looked = Some(Instant::now());
            let status = status(shared, client, stream, &mut rate);
            shared.view().status = status;
        }
        match waited {
            Ok(()) if client.health() == DriverHealth::Stopped => return,
            Ok(()) => {}
            // whatever it is, a new connection is the remedy
            Err(Error::DriverGone { .. } | Error::Service { .. }) => return,
            Err(_) => return,
        }
    }
}

fn take(shared: &Shared, history: &mut History, cycle: &sinew_ipc::Cycle<'_>) {
    let time_s = shared.seconds(cycle.header.monotonic_ns);
    if cycle.lost > 0 {
        history.gap(time_s);
    }
    history.push(time_s, cycle.channels.iter().flat_map(quantity::values));
}

fn status(shared: &Shared, client: &Client, stream: &CycleStream, rate: &mut Rate) -> String {
    let snapshot = client.latest();
    let stats = client.loop_stats();
    let states = snapshot.channels().iter().map(|state| State {
        mode: state.mode().name(),
        lease_s: state.lease_s,
        temperature_c: state.temperature_c,
        health: u8::try_from(state.health)
            .ok()
            .and_then(Health::from_code)
            .filter(|health| !health.is_ok())
            .map(Health::describe),
        fault: state.fault().map(|fault| FaultText {
            flag: fault.flag(),
            cause: fault.cause(),
            remedy: fault.remedy(),
        }),
    });
    json(&Status {
        kind: "status",
        driver: client.health().name(),
        pid: client.info().pid,
        cycle: snapshot.cycle,
        uptime_s: snapshot.monotonic_ns.saturating_sub(client.info().started_ns) as f64 * 1e-9,
        rate_hz: rate.of(&snapshot),
        missed: snapshot.missed,
        dead: stats
            .dead_threads()
            .map(|row| format!("The thread that {} has died: {}.", row.does, row.words))
            .collect(),
        lost: stream.lost(),
        lateness_us: Quantiles::of(&stats.lateness),
        cycle_us: Quantiles::of(&stats.cycle_time),
        recording: shared.recorder.lock().unwrap_or_else(PoisonError::into_inner).state(),
        traffic: shared.figures(),
        channels: states.collect(),
    })
}

/// Cycles a second, as they really come.
struct Rate {
    since: Option<(u64, u64)>,
    hz: f64,
}

impl Rate {
    fn new() -> Rate {
        Rate { since: None, hz: f64::NAN }
    }

    fn of(&mut self, now: &Snapshot) -> f64 {
        match self.since {
            Some((cycle, at_ns)) if now.monotonic_ns >= at_ns + RATE_SPAN.as_nanos() as u64 => {
                self.hz = now.cycle.saturating_sub(cycle) as f64 / ((now.monotonic_ns - at_ns) as f64 * 1e-9);
                self.since = Some((now.cycle, now.monotonic_ns));
            }
            None if now.cycle > 0 => self.since = Some((now.cycle, now.monotonic_ns)),
            _ => {}
        }
        self.hz
    }
}
