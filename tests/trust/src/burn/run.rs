//! Carries a script out: the driver's engine on a simulated rig, on a simulated clock. The rig goes on while the driver is dead, its stage keeps
//! its last duty until its own watchdog acts, and what is judged is the true temperature of the wire, all the time.

use std::fs::File;
use std::io::{BufWriter, Write};

use sinew_backend::{Backend, Sample};
use sinew_driver::heat::Recalled;
use sinew_driver::{Ask, Beat, Engine, Order, SupplySwitch};
use sinew_ipc::{DriverState, Snapshot};
use sinew_rig::{FaultKind, Rig};
use sinew_sim_backend::{SimulatedRig, World};

use super::rig::{Plan, Witnesses};
use super::script::{Happening, Script, Wish};
use crate::failure::Failure;

/// How far beyond its limit a wire may come, K: where the rig file is true, and where it is up to 30 % off.
const PROMISED_K: f64 = 10.0;
const PROMISED_OFF_K: f64 = 40.0;
/// A history heats its wire if that comes above this share of the rise to its limit.
const HEATED: f64 = 0.8;

/// What a history came to.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Whether the rig file was true.
    pub is_true: bool,
    /// What the driver could know its temperature by.
    pub witnesses: Witnesses,
    /// Whether its power stage stuck at some moment.
    pub was_stuck: bool,
    /// Most the wire was above its limit, K; negative below.
    pub over_k: f64,
    /// The same in periods of full power, K of one of which a wire without any loss gains.
    pub over_periods: f64,
    /// Most the published temperature was below the true one, K.
    pub under_k: f64,
    /// Whether the wire was heated above 80 % of its rise.
    pub was_heated: bool,
    /// Starts of the driver.
    pub starts: u32,
    /// Resets that were taken.
    pub resets: u32,
}

impl Outcome {
    /// Whether what is promised of such a history was kept; `None` where nothing is.
    pub fn is_kept(&self) -> Option<bool> {
        self.excess_k().map(|excess_k| excess_k <= 0.0)
    }

    /// How far the wire came beyond what is promised of such a history, K; `None` where nothing is.
    pub fn excess_k(&self) -> Option<f64> {
        let promised_k = if self.is_true { PROMISED_K } else { PROMISED_OFF_K };
        let is_promised = self.witnesses == Witnesses::LengthAndResistance && !self.was_stuck;
        is_promised.then_some(self.over_k - promised_k)
    }
}

/// The driver while it lives.
struct Driver {
    engine: Engine,
    duty: [f64; 1],
    snapshot: Box<Snapshot>,
    supply: SupplySwitch,
}

/// A record of the output as the driver keeps it.
#[derive(Clone, Copy)]
struct Record {
    recalled: Recalled,
    at_s: f64,
}

/// The world of a history.
struct Bench {
    wires: SimulatedRig,
    mends: Vec<(FaultKind, f64)>,
    limit_c: f64,
    heated_c: f64,
    outcome: Outcome,
}

impl Bench {
    fn true_c(&self) -> f64 {
        self.wires.truth(0).map_or(f64::NAN, |truth| truth.temperature_c)
    }

    fn watch(&mut self) {
        let true_c = self.true_c();
        self.outcome.over_k = self.outcome.over_k.max(true_c - self.limit_c);
        self.outcome.was_heated |= true_c > self.heated_c;
    }

    /// Periods without a driver.
    fn pass(&mut self, periods: u64) {
        for _ in 0..periods {
            self.wires.missed(1);
            self.watch();
        }
    }

    fn mend(&mut self) {
        let now_s = self.wires.time_s();
        let faults = self.wires.faults();
        self.mends.retain(|(kind, at_s)| {
            let lasts = *at_s > now_s;
            if !lasts {
                faults.clear(0, *kind);
            }
            lasts
        });
    }
}

/// Carries a script out on the rig of a seed; every cycle into `trace`.
///
/// # Errors
/// A rig file that is refused.
pub fn run(seed: u64, script: &Script, mut trace: Option<&mut BufWriter<File>>) -> Result<Outcome, Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::Unexpected(format!("history {seed}: {error}"));
    let plan = Plan::of(seed);
    let (is_true, witnesses) = (plan.is_true, plan.witnesses());
    let [believed, other, truth] = plan.rigs()?;
    let mut wires = SimulatedRig::new(&truth).map_err(|e| wrong(&e))?;
    wires.start().map_err(|e| wrong(&e))?;
    let (limit_c, ambient_c) = (believed.channels[0].limits.max_temperature_c, believed.channels[0].model.ambient_c);
    let rate_hz = believed.rate_hz;
    let mut world = Bench {
        wires,
        mends: Vec::new(),
        limit_c,
        heated_c: ambient_c + HEATED * (limit_c - ambient_c),
        outcome: Outcome {
            is_true,
            witnesses,
            was_stuck: false,
            over_k: f64::NEG_INFINITY,
            over_periods: f64::NEG_INFINITY,
            under_k: f64::NEG_INFINITY,
            was_heated: false,
            starts: 0,
            resets: 0,
        },
    };
    let mut driver: Option<Driver> = None;
    // It begins with a wire that has rested, of which the record of its output knows.
    let rested = Recalled { temperature_c: ambient_c, account_j: 0.0, given_w: 0.0, since_s: 0.0 };
    let mut record = Some(Record { recalled: rested, at_s: 0.0 });
    let mut next = Some(Start { pause_s: 0.0, remembers: true, other: false });
    let mut moments = script.moments.iter().peekable();
    let mut samples = [Sample::NONE];
    let mut tickets = 0;

    while world.wires.time_s() * rate_hz < script.cycles as f64 {
        world.mend();
        let now_s = world.wires.time_s();
        let now_ns = (now_s * 1e9) as u64 + 1_000_000_000;
        if let Some(start) = &mut next {
            // Nobody is there for some time; then the next one comes, if its stage can be put to zero.
            world.pass((std::mem::take(&mut start.pause_s) * rate_hz) as u64 + 1);
            world.mend();
            if world.wires.start().is_ok() {
                let rig = if start.other { &other } else { &believed };
                let known = record.filter(|_| start.remembers);
                driver = Some(started(rig, &world.wires, known).map_err(|e| wrong(&e))?);
                world.outcome.starts += 1;
                next = None;
            }
            continue;
        }
        let Some(alive) = &mut driver else { continue };

        let (mut stalled_s, mut is_killed) = (0.0, None);
        let mut wishes = Vec::new();
        while let Some(moment) = moments.next_if(|moment| moment.at_s <= now_s) {
            match moment.what {
                Happening::Kill { pause_s, remembers, other } => is_killed = Some(Start { pause_s, remembers, other }),
                Happening::Stall(seconds) => stalled_s += seconds,
                Happening::Break(kind, seconds) => {
                    world.wires.faults().set(0, kind);
                    world.mends.push((kind, now_s + seconds));
                    world.outcome.was_stuck |= kind == FaultKind::StageOn;
                }
                Happening::Draught(draught) => world.wires.disturb(0, &World { draught, ..World::CALM }),
                Happening::Ask(wish) => wishes.push(wish),
            }
        }
        let is_latched = alive.snapshot.channel[0].fault().is_some();
        if script.is_eager && is_latched {
            wishes.push(Wish::Reset);
        }
        for wish in wishes {
            let range = alive.engine.channels()[0].stroke_range();
            let ask = match wish {
                Wish::Off => Ask::Off,
                Wish::Stroke(stroke) => Ask::Length(range.length_m(stroke)),
                Wish::Duty(share) => Ask::Duty(share * believed.channels[0].limits.max_duty),
                Wish::Reset if !is_latched => continue,
                Wish::Reset => Ask::Reset,
            };
            tickets += 1;
            let answer =
                alive.engine.take(&Order { ticket: tickets, channel: 0, ask, hold_ns: 60_000_000_000 }, now_ns);
            world.outcome.resets += u32::from(ask == Ask::Reset && answer.is_none());
        }

        // A cycle, late or not; or the last one.
        let late = (stalled_s * rate_hz) as u64;
        world.pass(late);
        if late > 0 {
            alive.engine.come_late(late, &mut alive.duty);
        }
        let exchanged = world.wires.exchange(&alive.duty, &mut samples);
        world.watch();
        alive.engine.note_outputs(&world.wires);
        alive.engine.clear(&mut world.wires);
        alive.supply.look(&world.wires, &mut alive.engine, false);
        if is_killed.is_some() {
            (driver, next) = (None, is_killed);
            continue;
        }
        let now_s = world.wires.time_s();
        let beat = Beat { now_ns: (now_s * 1e9) as u64 + 1_000_000_000, missed: late };
        alive.engine.cycle(beat, exchanged, &samples, &mut alive.duty, |_| {});
        alive.supply.switch(&alive.engine, &mut world.wires);
        alive.engine.describe(beat.now_ns, DriverState::Running, &mut alive.snapshot);
        let channel = &alive.engine.channels()[0];
        let (temperature_c, account_j) = (channel.heat().temperature_c(), channel.heat().account_j());
        let recalled = Recalled { temperature_c, account_j, given_w: channel.most_given_w(), since_s: 0.0 };
        record = Some(Record { recalled, at_s: now_s });
        let state = &alive.snapshot.channel[0];
        world.outcome.under_k = world.outcome.under_k.max(world.true_c() - state.temperature_c);
        if let Some(trace) = &mut trace {
            let breaks: Vec<&str> = world.mends.iter().map(|(kind, _)| kind.word()).collect();
            writeln!(
                trace,
                "{now_s:.4},{:.2},{:.2},{:.2},{:.4},{:.4},{:?},{},{},{}",
                world.true_c(),
                state.temperature_c,
                channel.heat().excess_k(),
                world.wires.truth(0).map_or(f64::NAN, |truth| truth.duty),
                state.duty,
                state.mode(),
                state.fault().map_or("", |fault| fault.flag()),
                state.flags,
                breaks.join(" ")
            )?;
        }
    }
    world.outcome.over_periods = world.outcome.over_k / full_power_k_per_s(&truth) * rate_hz;
    Ok(world.outcome)
}

/// How the next driver comes.
#[derive(Debug, Clone, Copy)]
struct Start {
    pause_s: f64,
    remembers: bool,
    other: bool,
}

fn started(rig: &Rig, wires: &SimulatedRig, record: Option<Record>) -> Result<Driver, sinew_driver::Error> {
    let mut engine = Engine::new(rig, None)?;
    engine.bear_silence(wires.silence_s().unwrap_or(f64::NAN));
    if let Some(record) = record {
        let since_s = wires.time_s() - record.at_s;
        engine.recall(0, &Recalled { since_s, ..record.recalled });
    }
    Ok(Driver { engine, duty: [0.0], snapshot: Box::new(Snapshot::new(1)), supply: SupplySwitch::default() })
}

/// What full power makes of the hot wire without any loss, K/s.
fn full_power_k_per_s(rig: &Rig) -> f64 {
    let model = &rig.channels[0].model;
    let (m, g) = (&model.material, &model.geometry);
    let hot_ohm = m.austenite_resistivity(m.austenite_temperature_c) * g.length_m / g.area_m2();
    let current_a = model.drive.supply_v / (hot_ohm + model.drive.series_ohm());
    current_a * current_a * hot_ohm / model.heat_capacity_j_per_k()
}
