//! `sinew bench loop`: the driver with simulated wires at a given size, compared with a bare timer loop in the same thread, and
//! the cost of each part of a cycle.

use std::fmt::Write as _;
use std::time::Instant;

use serde::Serialize;
use sinew_backend::{Backend, Sample};
use sinew_driver::report::{BareLoop, Quantiles};
use sinew_driver::{Beat, Driver, Engine, Options, Program, RunReport};
use sinew_ipc::{ChannelInfo, Client, DriverState, Histogram, Info, Name, RigLock, Server, Snapshot};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

use super::live;
use super::run::driver_failure;
use crate::args;
use crate::driving::screen::view::micros;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

/// Cycles the parts are measured over.
const PART_CYCLES: u64 = 20_000;
/// Cycles before that, for the channels to prove their sensors and start to move.
const WARM_UP_CYCLES: u64 = 2_000;

/// What a part of a cycle costs by itself, in a busy loop of an ordinary thread.
#[derive(Debug, Serialize)]
struct Parts {
    /// The simulated wires: one exchange, µs.
    exchange_us: f64,
    /// Sensing, supervisor and control of all channels, µs.
    engine_us: f64,
    /// The same for one channel, ns.
    engine_ns_per_channel: f64,
    /// One update of the blackboard, µs.
    publish_us: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report<'a> {
    schema: &'static str,
    channels: u32,
    rate_hz: f64,
    seconds: f64,
    bare_loop: Option<&'a BareLoop>,
    driver: &'a RunReport,
    /// Lateness of the driver over that of the bare loop.
    lateness_ratio: Option<Quantiles>,
    /// How many wake-ups were how late.
    histogram: Vec<Bin>,
    parts: Parts,
}

/// One octave of lateness.
#[derive(Debug, PartialEq, Serialize)]
struct Bin {
    /// From here, µs.
    from_us: f64,
    /// To below here, µs.
    to_us: f64,
    /// Wake-ups of the bare loop.
    bare_loop: u64,
    /// Wake-ups of the driver.
    driver: u64,
}

/// Runs the command.
pub fn bench_loop(args: &args::BenchLoop) -> Outcome {
    let rig = rig(args.channels, args.rate_hz)?;
    let asked = ending::asked()?;
    log::never_wait()?;
    let parts = parts(&rig)?;
    output::note(format_args!("a bare timer loop for {0} s, then the driver for {0} s …", args.duration_s));
    let backend = SimulatedRig::new(&rig).map_err(Failure::own)?;
    let options = Options {
        duration_s: Some(args.duration_s),
        program: Some(Program::tripod(rig.channels.len(), 6.0)),
        floor_s: Some(args.duration_s),
        simulated: true,
        ..Options::default()
    };
    let driver = Driver::start(&rig, backend, options).map_err(|error| driver_failure(&rig, error))?;
    let client = Client::connect(&rig.name).map_err(live::failure)?;
    while driver.is_running() && !asked.load(std::sync::atomic::Ordering::Relaxed) {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    driver.stop();
    let run = driver.join();
    log::part();
    // what was written last stays readable after the driver's end
    let looped = client.loop_stats();
    let report = Report {
        schema: "sinew.bench.loop/1",
        channels: args.channels,
        rate_hz: args.rate_hz,
        seconds: run.seconds,
        lateness_ratio: run.floor.as_ref().map(|bare| ratio(run.lateness_us, bare.lateness_us)),
        bare_loop: run.floor.as_ref(),
        histogram: histogram(run.floor.as_ref().map(|bare| &bare.lateness), &looped.lateness),
        driver: &run,
        parts,
    };
    if args.json { output::print_json(&report) } else { output::print(text(&report)) }
}

/// The built-in hexapod's wires as often as needed, under a name nobody else has.
fn rig(channels: u32, rate_hz: f64) -> Result<Rig, Failure> {
    let mut rig = Rig::hexapod();
    rig.name = format!("bench-{}", std::process::id());
    rig.rate_hz = rate_hz;
    let wires = std::mem::take(&mut rig.channels);
    rig.channels = wires
        .iter()
        .cycle()
        .take(channels as usize)
        .enumerate()
        .map(|(index, wire)| {
            let mut wire = wire.clone();
            wire.name = format!("wire_{}", index + 1);
            wire
        })
        .collect();
    rig.check_drivable().map_err(Failure::input)?;
    Ok(rig)
}

/// Times the parts of a cycle one by one.
fn parts(rig: &Rig) -> Result<Parts, Failure> {
    let count = rig.channels.len();
    let program = Program::tripod(count, 6.0);
    let mut backend = SimulatedRig::new(rig).map_err(Failure::own)?;
    let mut engine = Engine::at_rest(rig, Some(program)).map_err(Failure::own)?;
    let channels: Vec<ChannelInfo> = rig
        .channels
        .iter()
        .map(|channel| Ok(ChannelInfo { name: Name::new(&channel.name)?, ..ChannelInfo::EMPTY }))
        .collect::<Result<_, sinew_ipc::Error>>()
        .map_err(live::failure)?;
    let lock = RigLock::acquire(&rig.name).map_err(live::failure)?;
    let info = Info::new(&rig.name, rig.rate_hz, &channels).map_err(live::failure)?;
    let (mut writer, _cycles, _commands) = Server::create(lock, &info).map_err(live::failure)?.split();

    backend.start().map_err(Failure::own)?;
    let mut snapshot = Snapshot::new(count);
    let (mut duty, mut samples) = (vec![0.0; count], vec![Sample::NONE; count]);
    let period_ns = (1e9 / rig.rate_hz) as u64;
    let mut spent = [0u64; 3];
    for cycle in 0..WARM_UP_CYCLES + PART_CYCLES {
        let now_ns = (cycle + 1) * period_ns;
        let started = Instant::now();
        let exchanged = backend.exchange(&duty, &mut samples);
        let sampled = Instant::now();
        engine.cycle(Beat { now_ns, missed: 0 }, exchanged, &samples, &mut duty, |_| {});
        engine.describe(now_ns, DriverState::Running, &mut snapshot);
        snapshot.cycle = cycle;
        let decided = Instant::now();
        writer.update(&snapshot);
        let published = Instant::now();
        if cycle >= WARM_UP_CYCLES {
            for (spent, span) in spent.iter_mut().zip([sampled - started, decided - sampled, published - decided]) {
                *spent += span.as_nanos() as u64;
            }
        }
    }
    let _ = backend.stop();
    let [exchange_us, engine_us, publish_us] = spent.map(|ns| ns as f64 * 1e-3 / PART_CYCLES as f64);
    Ok(Parts { exchange_us, engine_us, engine_ns_per_channel: engine_us * 1e3 / count as f64, publish_us })
}

/// Both histograms by octaves, from the first to the last that is not empty.
fn histogram(bare: Option<&Histogram>, driver: &Histogram) -> Vec<Bin> {
    const OCTAVES: usize = 31;
    let octaves = |histogram: &Histogram| {
        let mut counts = [0; OCTAVES];
        for (first_ns, _, count) in histogram.filled() {
            counts[(first_ns.max(1).ilog2() as usize).min(OCTAVES - 1)] += count;
        }
        counts[OCTAVES - 1] += histogram.overflow();
        counts
    };
    let (bare, driver) = (bare.map(octaves).unwrap_or([0; OCTAVES]), octaves(driver));
    let filled = |octave: &usize| bare[*octave] + driver[*octave] > 0;
    let (Some(first), Some(last)) = ((0..OCTAVES).find(filled), (0..OCTAVES).rev().find(filled)) else {
        return Vec::new();
    };
    let edge_us = |octave: usize| (1u64 << octave) as f64 * 1e-3;
    (first..=last)
        .map(|octave| Bin {
            from_us: edge_us(octave),
            to_us: edge_us(octave + 1),
            bare_loop: bare[octave],
            driver: driver[octave],
        })
        .collect()
}

/// A count as a bar on a logarithmic scale, so that a single late wake-up is still seen.
fn bar(count: u64, most: u64) -> String {
    let log = |n: u64| (n as f64 + 1.0).log10();
    let cells = if count == 0 { 0.0 } else { 20.0 * log(count) / log(most) };
    "█".repeat((cells.round() as usize).max(usize::from(count > 0)))
}

fn ratio(driver: Quantiles, bare: Quantiles) -> Quantiles {
    Quantiles {
        p50: driver.p50 / bare.p50,
        p99: driver.p99 / bare.p99,
        p999: driver.p999 / bare.p999,
        max: driver.max / bare.max,
    }
}

fn text(report: &Report) -> String {
    let run = report.driver;
    let mut text = format!(
        "{} simulated wires at {} Hz for {:.1} s\n\n{:<22} {:>8} {:>8} {:>8} {:>8} {:>8}\n",
        report.channels, report.rate_hz, report.seconds, "µs", "p50", "p99", "p999", "max", "missed"
    );
    let mut row = |name: &str, q: Quantiles, missed: String| {
        let cells = [q.p50, q.p99, q.p999, q.max].map(|us| format!("{:>8}", micros(us)));
        let _ = writeln!(text, "{name:<22} {} {missed:>8}", cells.join(" "));
    };
    if let Some(bare) = report.bare_loop {
        row("lateness, bare loop", bare.lateness_us, bare.missed.to_string());
    }
    row("lateness, driver", run.lateness_us, run.missed.to_string());
    if let Some(ratio) = report.lateness_ratio {
        row("  ratio", ratio, String::new());
    }
    row("cycle", run.cycle_us, String::new());
    row("period", run.period_us, String::new());
    let most = report.histogram.iter().map(|bin| bin.bare_loop.max(bin.driver)).max().unwrap_or(1);
    let _ = writeln!(text, "\n{:>17}  {:<30} driver   (bars: logarithmic)", "lateness µs", "bare loop");
    for bin in &report.histogram {
        let (bare, driver) = (bar(bin.bare_loop, most), bar(bin.driver, most));
        let range = format!("{} – {}", micros(bin.from_us), micros(bin.to_us));
        let line = format!("{range:>17} {:>8} {bare:<21} {:>8} {driver}", bin.bare_loop, bin.driver);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let parts = &report.parts;
    let _ = writeln!(
        text,
        "\na cycle's parts by themselves, mean: simulated wires {:.2} µs, sensing + supervisor + control {:.2} µs \
         ({:.0} ns a channel), blackboard {:.2} µs",
        parts.exchange_us, parts.engine_us, parts.engine_ns_per_channel, parts.publish_us
    );
    let _ = writeln!(
        text,
        "missed: {} woken too late, {} cycles too long; allocations in the loop: {}; {} {}",
        run.missed_by_wakeup,
        run.missed_by_cycle,
        run.allocations_in_loop.map_or("not counted".into(), |count| count.to_string()),
        run.rt.policy,
        if run.rt.locked { "memory locked" } else { "memory not locked" },
    );
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_histograms_share_their_octaves_and_lose_no_wakeup() {
        let (mut bare, mut driver) = (Histogram::new(), Histogram::new());
        for ns in [900, 1000, 20_000, 21_000] {
            bare.record(ns);
        }
        for ns in [20_000, 3_000_000, 5_000_000_000] {
            driver.record(ns);
        }
        let bins = histogram(Some(&bare), &driver);
        assert_eq!(bins.iter().map(|bin| bin.bare_loop).sum::<u64>(), 4);
        assert_eq!(bins.iter().map(|bin| bin.driver).sum::<u64>(), 3);
        let both = bins.iter().find(|bin| bin.bare_loop == 2 && bin.driver == 1).expect("20 µs");
        assert!(both.from_us <= 20.0 && both.to_us > 21.0, "{both:?}");
        assert!(bins.windows(2).all(|pair| pair[0].to_us == pair[1].from_us));
        assert_eq!(histogram(None, &Histogram::new()), []);
    }

    #[test]
    fn a_single_late_wakeup_is_seen_beside_a_million() {
        assert_eq!(bar(0, 1_000_000), "");
        assert!(!bar(1, 1_000_000).is_empty());
        assert_eq!(bar(1_000_000, 1_000_000).chars().count(), 20);
    }

    #[test]
    fn the_bench_rig_has_as_many_wires_as_asked_for() {
        for channels in [1, 18, 64] {
            let rig = rig(channels, 5000.0).unwrap();
            assert_eq!(rig.channels.len(), channels as usize);
            assert_eq!(rig.rate_hz, 5000.0);
        }
    }
}
