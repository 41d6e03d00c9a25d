//! Carries a script out: the driver's engine on a simulated rig, on a simulated clock. The rig goes on while the driver is dead, its stage keeps
//! its last duty until its own watchdog acts, and what is judged is the true temperature of the wire, all the time.

use std::fs::File;
use std::io::{BufWriter, Write};

use sinew_backend::{Backend, Sample};
use sinew_driver::{Ask, Beat, Order};
use sinew_ipc::{ChannelState, Mode};
use sinew_rig::{FaultKind, Rig};
use sinew_sim_backend::{SimulatedRig, World};

use super::rig::{Rigs, Witnesses};
use super::script::{Happening, Script, Sticks, Strike, Wish};
use crate::failure::Failure;
use crate::mortal::{Mortal, Record, clock_ns};

/// How far beyond its limit a wire may come, K: where the rig file is true, and where it is up to 30 % off.
const PROMISED_K: f64 = 10.0;
const PROMISED_OFF_K: f64 = 40.0;
/// And, where its stage has stuck under the eyes of a driver, so many periods of full power more.
const PROMISED_STUCK_PERIODS: f64 = 20.0;
/// A history heats its wire if that comes above this share of the rise to its limit.
const HEATED: f64 = 0.8;
/// How long an abandoned wire is watched, s.
const ABANDONED_S: f64 = 10.0;

/// What becomes of the power stage in a history.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// It can be switched off.
    Healthy,
    /// It sticks, and driver, line and converter live on.
    StuckWatched,
    /// It sticks, the converter shows nothing, and the emergency stop is pressed.
    StuckStopped,
    /// It sticks, and the driver is killed at that: the watchdog relay is left.
    StuckAbandoned,
    /// It sticks, and whatever else happens.
    Stuck,
}

impl Stage {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Stage::Healthy => "a healthy stage",
            Stage::StuckWatched => "a stage that sticks watched",
            Stage::StuckStopped => "a stage that sticks unmeasured, and an emergency stop",
            Stage::StuckAbandoned => "a stage that sticks as its driver is killed",
            Stage::Stuck => "a stage that sticks",
        }
    }
}

/// What a history came to.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Whether the rig file was true.
    pub is_true: bool,
    /// What the driver could know its temperature by.
    pub witnesses: Witnesses,
    /// What became of its power stage.
    pub stage: Stage,
    /// Most the wire was above its limit, K; negative below.
    pub over_k: f64,
    /// When that was, s.
    pub hottest_s: f64,
    /// What a wire without any loss gains in a period of full power, K.
    pub full_power_k: f64,
    /// And until the watchdog relay drops out, K.
    pub relay_k: f64,
    /// Most the published temperature was below the true one, K.
    pub under_k: f64,
    /// When that was, s, and how far the wire was above its limit then, K; negative below.
    pub under_s: f64,
    /// See there.
    pub under_at_k: f64,
    /// When the wire came above 80 % of its rise, s; infinite = never.
    pub heated_s: f64,
    /// Starts of the driver.
    pub starts: u32,
    /// Resets that were taken.
    pub resets: u32,
}

impl Outcome {
    /// Whether the wire came above 80 % of its rise.
    pub fn was_heated(&self) -> bool {
        self.heated_s.is_finite()
    }

    /// Whether what is promised of such a history was kept; `None` where nothing is.
    pub fn is_kept(&self) -> Option<bool> {
        self.promised_k().map(|promised_k| self.over_k <= promised_k)
    }

    /// The same in words.
    pub fn promised(&self) -> Option<&'static str> {
        let words = match (self.stage, self.is_true) {
            (Stage::StuckWatched | Stage::StuckStopped, true) => "10 K + 20 periods",
            (Stage::StuckWatched | Stage::StuckStopped, false) => "40 K + 20 periods",
            (Stage::StuckAbandoned, true) => "10 K + 20 periods + the relay's",
            (Stage::StuckAbandoned, false) => "40 K + 20 periods + the relay's",
            (_, true) => "10 K",
            (_, false) => "40 K",
        };
        self.promised_k().map(|_| words)
    }

    /// How far its wire may come beyond the limit, K; `None` where nothing is promised.
    pub fn promised_k(&self) -> Option<f64> {
        let promised_k = if self.is_true { PROMISED_K } else { PROMISED_OFF_K };
        match (self.witnesses, self.stage) {
            (Witnesses::LengthAndResistance, Stage::Healthy) => Some(promised_k),
            (Witnesses::LengthAndResistance, Stage::StuckWatched | Stage::StuckStopped) => {
                Some(promised_k + PROMISED_STUCK_PERIODS * self.full_power_k)
            }
            (Witnesses::LengthAndResistance, Stage::StuckAbandoned) => {
                Some(promised_k + PROMISED_STUCK_PERIODS * self.full_power_k + self.relay_k)
            }
            _ => None,
        }
    }
}

/// The world of a history.
struct Bench {
    wires: SimulatedRig,
    mends: Vec<(FaultKind, f64)>,
    line_back_s: f64,
    limit_c: f64,
    heated_c: f64,
    outcome: Outcome,
}

impl Bench {
    fn true_c(&self) -> f64 {
        self.wires.truth(0).map_or(f64::NAN, |truth| truth.temperature_c)
    }

    fn watch(&mut self) {
        let (true_c, outcome) = (self.true_c(), &mut self.outcome);
        if true_c - self.limit_c > outcome.over_k {
            outcome.over_k = true_c - self.limit_c;
            outcome.hottest_s = self.wires.time_s();
        }
        if true_c > self.heated_c && !outcome.was_heated() {
            outcome.heated_s = self.wires.time_s();
        }
    }

    /// The true temperature beside the published one.
    fn compare(&mut self, published_c: f64) {
        let (true_c, outcome) = (self.true_c(), &mut self.outcome);
        if true_c - published_c > outcome.under_k {
            outcome.under_k = true_c - published_c;
            outcome.under_s = self.wires.time_s();
            outcome.under_at_k = true_c - self.limit_c;
        }
    }

    /// Periods without a driver.
    fn pass(&mut self, periods: u64) {
        for _ in 0..periods {
            self.wires.missed(1);
            self.watch();
            self.mend();
        }
    }

    fn break_down(&mut self, kind: FaultKind, size: f64, seconds: f64) {
        self.wires.faults().set_sized(0, kind, size);
        self.mends.push((kind, self.wires.time_s() + seconds));
    }

    fn is_broken(&self, kind: FaultKind) -> bool {
        self.mends.iter().any(|(broken, _)| *broken == kind)
    }

    fn lose_line(&mut self, seconds: f64) {
        self.break_down(FaultKind::WriteFails, f64::NAN, seconds);
        self.line_back_s = self.wires.time_s() + seconds;
        self.wires.faults().set_backend_error(true);
    }

    fn mend(&mut self) {
        if self.mends.is_empty() {
            return;
        }
        let now_s = self.wires.time_s();
        let faults = self.wires.faults();
        if now_s >= self.line_back_s {
            faults.set_backend_error(false);
        }
        self.mends.retain(|(kind, at_s)| {
            let lasts = *at_s > now_s;
            if !lasts {
                faults.clear(0, *kind);
            }
            lasts
        });
    }

    /// The stage sticks; nothing else is broken from then on but what belongs to that.
    fn stick(&mut self, how: Sticks) {
        let faults = self.wires.faults();
        if how != Sticks::Anyhow {
            faults.clear_all();
            self.mends.clear();
        }
        faults.set(0, FaultKind::StageOn);
        if how == Sticks::Stopped {
            faults.set(0, FaultKind::AdcNan);
            faults.set(0, FaultKind::EstopOpen);
        }
        self.outcome.stage = match how {
            Sticks::Watched => Stage::StuckWatched,
            Sticks::Stopped => Stage::StuckStopped,
            Sticks::Abandoned => Stage::StuckAbandoned,
            Sticks::Anyhow => Stage::Stuck,
        };
    }
}

/// Who sees to it that the wire works: resets what is latched, and asks again for what was wanted last.
struct Operator {
    every_s: f64,
    next_s: f64,
    wanted: Wish,
}

impl Operator {
    /// What he asks for when he looks, and whether he resets the emergency stop.
    fn look(&mut self, now_s: f64, state: &ChannelState) -> (Option<Wish>, bool) {
        if now_s < self.next_s {
            return (None, false);
        }
        self.next_s = now_s + self.every_s;
        let is_stopped = state.flags & ChannelState::FLAG_STOPPED != 0;
        let is_idle = matches!(state.mode(), Mode::Off | Mode::Lapsed) && self.wanted != Wish::Off;
        let wish = match state.fault() {
            Some(_) if state.mode() == Mode::Fault => Some(Wish::Reset),
            _ => is_idle.then_some(self.wanted),
        };
        (wish, is_stopped)
    }
}

/// Carries a script out on its rigs; every cycle into `trace`.
///
/// # Errors
/// A rig file that is refused.
pub fn run(rigs: &Rigs, script: &Script, mut trace: Option<&mut BufWriter<File>>) -> Result<Outcome, Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::Unexpected(format!("a history: {error}"));
    let Rigs { believed, other, truth, is_true, witnesses } = rigs;
    let mut wires = SimulatedRig::new(truth).map_err(|e| wrong(&e))?;
    wires.start().map_err(|e| wrong(&e))?;
    let (limit_c, ambient_c) = (believed.channels[0].limits.max_temperature_c, believed.channels[0].model.ambient_c);
    let (rate_hz, full_k_per_s) = (believed.rate_hz, full_power_k_per_s(truth));
    let periods = |seconds: f64| (seconds * rate_hz) as u64;
    let mut world = Bench {
        wires,
        mends: Vec::new(),
        line_back_s: 0.0,
        limit_c,
        heated_c: ambient_c + HEATED * (limit_c - ambient_c),
        outcome: Outcome {
            is_true: *is_true,
            witnesses: *witnesses,
            stage: Stage::Healthy,
            over_k: f64::NEG_INFINITY,
            hottest_s: 0.0,
            full_power_k: full_k_per_s / rate_hz,
            relay_k: full_k_per_s * truth.backend.enable.dropout_s,
            under_k: f64::NEG_INFINITY,
            under_s: 0.0,
            under_at_k: f64::NAN,
            heated_s: f64::INFINITY,
            starts: 0,
            resets: 0,
        },
    };
    let mut driver: Option<Mortal> = None;
    // It begins with a wire that has rested, of which the record of its output knows.
    let mut record = Some(Record::rested(believed));
    let mut next = Some(Start { pause_s: 0.0, remembers: true, other: false });
    let mut moments = script.moments.iter().peekable();
    let mut sticks = script.sticks;
    let mut operator = Operator { every_s: script.looks_every_s, next_s: 0.0, wanted: Wish::Off };
    let mut samples = [Sample::NONE];
    let mut tickets = 0;
    // What the loop's clock has not seen, s.
    let mut slept_s = 0.0;
    let max_duty = believed.channels[0].limits.max_duty;
    let mut loads: Vec<Load> = Vec::new();
    // The duty that its stage took last.
    let mut given = 0.0;

    while world.wires.time_s() * rate_hz < script.cycles as f64 {
        if script.until_heated && world.outcome.was_heated() {
            break;
        }
        world.mend();
        let now_s = world.wires.time_s();
        if sticks.is_some_and(|one| one.at_s <= now_s && (one.how == Sticks::Anyhow || driver.is_some()))
            && let Some(sticking) = sticks.take()
        {
            world.stick(sticking.how);
            if sticking.how == Sticks::Abandoned {
                world.pass(periods(ABANDONED_S));
                break;
            }
        }
        if let Some(start) = &mut next {
            // Nobody is there for some time; then the next one comes, if its stage can be put to zero.
            world.pass(periods(std::mem::take(&mut start.pause_s)) + 1);
            if world.wires.start().is_ok() {
                let rig = if start.other { other } else { believed };
                let known = record.filter(|_| start.remembers);
                driver = Some(Mortal::started(rig, &mut world.wires, known).map_err(|e| wrong(&e))?);
                world.outcome.starts += 1;
                next = None;
            }
            continue;
        }
        let Some(alive) = &mut driver else { continue };

        let (mut stalled_s, mut suspended_s, mut end) = (0.0, 0.0, None);
        let mut wishes = Vec::new();
        let is_left_alone = matches!(world.outcome.stage, Stage::StuckWatched | Stage::StuckStopped);
        while let Some(moment) = moments.next_if(|moment| moment.at_s <= now_s) {
            match moment.what {
                Happening::Draught(draught) => world.wires.disturb(0, &World { draught, ..World::CALM }),
                Happening::Ask(wish, hold_s) => wishes.push((wish, hold_s)),
                _ if is_left_alone => {}
                Happening::Kill { pause_s, in_order, remembers, other } => {
                    end = Some((in_order, Start { pause_s, remembers, other }));
                }
                Happening::Stall(seconds) => stalled_s += seconds,
                Happening::Suspend(seconds) => suspended_s += seconds,
                Happening::Break { kind, size, seconds } => world.break_down(kind, size, seconds),
                Happening::LostLine(seconds) => world.lose_line(seconds),
                Happening::UnderLoad { strike, share, seconds } => {
                    loads.push(Load { strike, least_duty: share * max_duty, until_s: now_s + seconds });
                }
            }
        }
        loads.retain(|load| now_s < load.until_s && !is_left_alone);
        for load in &loads {
            match load.strike {
                Strike::Kill(pause_s) if alive.duty[0] > load.least_duty => {
                    end = Some((false, Start { pause_s, remembers: true, other: false }));
                }
                Strike::Stall(seconds) if given > load.least_duty => stalled_s += seconds,
                Strike::WriteFails(seconds) if given > load.least_duty && !world.is_broken(FaultKind::WriteFails) => {
                    world.break_down(FaultKind::WriteFails, f64::NAN, seconds);
                }
                _ => {}
            }
        }
        if let Some(&(wish, _)) = wishes.iter().rev().find(|(wish, _)| *wish != Wish::Reset) {
            operator.wanted = wish;
        }
        let state = &alive.snapshot.channel[0];
        let is_latched = state.mode() == Mode::Fault;
        let (wish, resets_stop) = operator.look(now_s, state);
        wishes.extend(wish.map(|wish| (wish, 60.0)));
        for (wish, hold_s) in wishes {
            let range = alive.engine.channels()[0].stroke_range();
            let ask = match wish {
                Wish::Off => Ask::Off,
                Wish::Stroke(stroke) => Ask::Length(range.length_m(stroke)),
                Wish::Duty(share) => Ask::Duty(share * believed.channels[0].limits.max_duty),
                Wish::Reset if !is_latched => continue,
                Wish::Reset => Ask::Reset,
            };
            tickets += 1;
            let order = Order { ticket: tickets, channel: 0, ask, hold_ns: (hold_s * 1e9) as u64 };
            let answer = alive.engine.take(&order, clock_ns(now_s - slept_s));
            world.outcome.resets += u32::from(ask == Ask::Reset && answer.is_none());
        }

        // A cycle, late or not; or the last one.
        let late = periods(stalled_s);
        world.pass(late);
        if late > 0 {
            alive.engine.come_late(late, &mut alive.duty);
        }
        if suspended_s > 0.0 {
            world.pass(periods(suspended_s));
            slept_s += suspended_s;
            alive.engine.was_suspended(suspended_s);
            alive.duty.fill(0.0);
        }
        if let Some((true, start)) = end {
            // Zero, as its end puts it out; `stop` would stop the simulated world as well.
            let is_confirmed = world.wires.start().is_ok();
            // What is kept is as old as the last cycle, as the driver's own.
            record = record.filter(|_| is_confirmed);
            (driver, next) = (None, Some(start));
            continue;
        }
        let exchanged = world.wires.exchange(&alive.duty, &mut samples);
        if world.wires.is_confirmed(0) {
            given = alive.duty[0];
        }
        world.watch();
        alive.look(&mut world.wires, resets_stop);
        if let Some((_, start)) = end {
            (driver, next) = (None, Some(start));
            continue;
        }
        let now_s = world.wires.time_s();
        let beat = Beat { now_ns: clock_ns(now_s - slept_s), missed: late };
        record = Some(alive.cycle(&mut world.wires, beat, exchanged, &samples));
        let state = &alive.snapshot.channel[0];
        world.compare(state.temperature_c);
        if let Some(trace) = &mut trace {
            let breaks: Vec<&str> = world.mends.iter().map(|(kind, _)| kind.word()).collect();
            writeln!(
                trace,
                "{now_s:.4},{:.2},{:.2},{:.2},{:.4},{:.4},{:?},{},{},{}",
                world.true_c(),
                state.temperature_c,
                alive.engine.channels()[0].heat().excess_k(),
                world.wires.truth(0).map_or(f64::NAN, |truth| truth.duty),
                state.duty,
                state.mode(),
                state.fault().map_or("", |fault| fault.flag()),
                state.flags,
                breaks.join(" ")
            )?;
        }
    }
    Ok(world.outcome)
}

/// What strikes above a duty, until then, s.
struct Load {
    strike: Strike,
    least_duty: f64,
    until_s: f64,
}

/// How the next driver comes.
#[derive(Debug, Clone, Copy)]
struct Start {
    pause_s: f64,
    remembers: bool,
    other: bool,
}

/// What full power makes of the hot wire without any loss, K/s.
fn full_power_k_per_s(rig: &Rig) -> f64 {
    let model = &rig.channels[0].model;
    let (m, g) = (&model.material, &model.geometry);
    let hot_ohm = m.austenite_resistivity(m.austenite_temperature_c) * g.length_m / g.area_m2();
    let current_a = model.drive.supply_v / (hot_ohm + model.drive.series_ohm());
    current_a * current_a * hot_ohm / model.heat_capacity_j_per_k()
}
