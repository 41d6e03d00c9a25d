//! What is known of one wire's life.

use serde::{Deserialize, Serialize};
use sinew_physics::formulas::{self, BREAK_IN_CYCLES, CycleUse};
use sinew_recording::Utc;

use crate::counter::{Counter, Cycle};
use crate::wire::{Identity, Sample, Wire};

/// Version of an account's file.
pub const SCHEMA: &str = "sinew.life-account/1";

/// A share of a wire's life, with the interval in which it is for most wires.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Of the wires that last longest.
    pub least: f64,
    /// In the middle.
    pub middle: f64,
    /// Of the wires that break first.
    pub most: f64,
}

impl Share {
    /// Adds what a cycle uses (Miner): so much of what the wire would last if all were like it.
    fn add(&mut self, cycle: &Cycle) {
        let life = formulas::cycles_to_failure(&CycleUse {
            peak_stress_pa: cycle.stress_pa,
            strain: cycle.strain,
            share: cycle.share,
            overheated: cycle.overheated,
        });
        self.least += cycle.weight / life.most;
        self.middle += cycle.weight / life.cycles;
        self.most += cycle.weight / life.least;
    }
}

/// One wire's account. It is what stands in its file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Account {
    /// Version of the file.
    pub schema: String,
    /// Name of the rig.
    pub rig: String,
    /// Name of the channel.
    pub channel: String,
    /// Whether it is a simulated wire's.
    pub simulated: bool,
    /// Which wire it is.
    pub wire: Identity,
    /// When it was begun, UTC.
    pub since: String,
    /// When it was last written, UTC.
    pub updated: String,
    /// Runs of the driver that have added to it.
    pub runs: u64,
    /// How long the wire was watched, s.
    pub watched_s: f64,
    /// How long of that it was heated, not just measured, s.
    pub powered_s: f64,
    /// Electrical energy it has taken in, J: where its power was known.
    #[serde(default)]
    pub energy_j: f64,
    /// How long it was hotter than it may be, s.
    pub over_limit_s: f64,
    /// How long its temperature was not known, s: it is taken not to have been overheated then.
    pub without_temperature_s: f64,
    /// The hottest it was, °C; `None` where that was never known.
    pub hottest_c: Option<f64>,
    /// Cycles that have closed, of any size.
    pub cycles: f64,
    /// The transformation they ran through, in whole cycles.
    pub whole_cycles: f64,
    /// What they used.
    pub used: Share,
    /// What is open.
    pub counter: Counter,
}

impl Account {
    /// A new one, of a wire that has done nothing yet.
    pub fn new(rig: &str, channel: &str, simulated: bool, wire: &Wire) -> Account {
        let now = Utc::now().to_string();
        Account {
            schema: SCHEMA.into(),
            rig: rig.into(),
            channel: channel.into(),
            simulated,
            wire: wire.identity.clone(),
            since: now.clone(),
            updated: now,
            runs: 0,
            watched_s: 0.0,
            powered_s: 0.0,
            energy_j: 0.0,
            over_limit_s: 0.0,
            without_temperature_s: 0.0,
            hottest_c: None,
            cycles: 0.0,
            whole_cycles: 0.0,
            used: Share::default(),
            counter: Counter::default(),
        }
    }

    /// Takes a state in. Constant time, but for the few cycles that close with it.
    pub fn see(&mut self, wire: &Wire, sample: &Sample) {
        self.watched_s += sample.seconds;
        if sample.powered {
            self.powered_s += sample.seconds;
        }
        if sample.power_w.is_finite() {
            self.energy_j += sample.power_w * sample.seconds;
        }
        if sample.temperature_c.is_finite() {
            self.hottest_c = Some(self.hottest_c.map_or(sample.temperature_c, |c| c.max(sample.temperature_c)));
            if sample.temperature_c > wire.limit_c {
                self.over_limit_s += sample.seconds;
            }
        } else {
            self.without_temperature_s += sample.seconds;
        }
        let Some(moment) = wire.moment(sample) else { return };
        let Account { counter, cycles, whole_cycles, used, .. } = self;
        counter.see(&moment, |cycle| {
            *cycles += cycle.weight;
            *whole_cycles += cycle.weight * cycle.share;
            used.add(cycle);
        });
    }

    /// What it comes to now, with what is open.
    pub fn report(&self) -> Report {
        let (mut cycles, mut whole_cycles, mut used) = (self.cycles, self.whole_cycles, self.used);
        for cycle in self.counter.open() {
            cycles += cycle.weight;
            whole_cycles += cycle.weight * cycle.share;
            used.add(&cycle);
        }
        // as many again as it has had, for as long as that leaves of its life
        let left = |used: f64| (used > 0.0).then(|| (cycles * (1.0 - used) / used).max(0.0));
        let hours_left = |used: f64| (used > 0.0).then(|| (self.powered_s / 3600.0 * (1.0 - used) / used).max(0.0));
        Report {
            rig: self.rig.clone(),
            channel: self.channel.clone(),
            simulated: self.simulated,
            wire: self.wire.clone(),
            since: self.since.clone(),
            updated: self.updated.clone(),
            runs: self.runs,
            hours_watched: self.watched_s / 3600.0,
            hours_powered: self.powered_s / 3600.0,
            energy_j: self.energy_j,
            over_limit_s: self.over_limit_s,
            without_temperature_s: self.without_temperature_s,
            hottest_c: self.hottest_c,
            cycles,
            whole_cycles,
            equivalent_cycles: used.middle * formulas::cycles_to_failure(&CycleUse::TABLE).cycles,
            used,
            remaining_cycles: left(used.middle),
            remaining_cycles_least: left(used.most),
            remaining_cycles_most: left(used.least),
            remaining_hours: hours_left(used.middle),
            broken_in: BrokenIn::after(whole_cycles),
        }
    }

    /// Whether every number in it can be what it stands for.
    pub(crate) fn is_sound(&self) -> bool {
        let sums = [
            self.watched_s,
            self.powered_s,
            self.energy_j,
            self.over_limit_s,
            self.without_temperature_s,
            self.cycles,
            self.whole_cycles,
            self.used.least,
            self.used.middle,
            self.used.most,
        ];
        sums.iter().all(|sum| sum.is_finite() && *sum >= 0.0)
            && [self.wire.diameter_m, self.wire.length_m].iter().all(|m| m.is_finite() && *m > 0.0)
            && self.hottest_c.is_none_or(f64::is_finite)
            && self.counter.is_sound()
    }
}

/// Whether a wire's strain and temperatures have settled, by how many whole cycles it has had.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BrokenIn {
    /// Fewer than it takes at least.
    No,
    /// As many as it takes some wires.
    Probably,
    /// More than it takes any.
    Yes,
}

impl BrokenIn {
    fn after(cycles: f64) -> BrokenIn {
        match BREAK_IN_CYCLES {
            (least, _) if cycles < least => BrokenIn::No,
            (_, most) if cycles < most => BrokenIn::Probably,
            _ => BrokenIn::Yes,
        }
    }

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            BrokenIn::No => "no",
            BrokenIn::Probably => "probably",
            BrokenIn::Yes => "yes",
        }
    }
}

/// What an account comes to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Name of the rig.
    pub rig: String,
    /// Name of the channel.
    pub channel: String,
    /// Whether it is a simulated wire's.
    pub simulated: bool,
    /// Which wire.
    pub wire: Identity,
    /// When it was begun, UTC.
    pub since: String,
    /// When it was last written, UTC.
    pub updated: String,
    /// Runs of the driver.
    pub runs: u64,
    /// Hours watched.
    pub hours_watched: f64,
    /// Hours heated.
    pub hours_powered: f64,
    /// Electrical energy taken in, J.
    pub energy_j: f64,
    /// Seconds hotter than its limit.
    pub over_limit_s: f64,
    /// Seconds without a temperature.
    pub without_temperature_s: f64,
    /// The hottest it was, °C.
    pub hottest_c: Option<f64>,
    /// Cycles of any size, open ones as halves.
    pub cycles: f64,
    /// The same in whole transformations.
    pub whole_cycles: f64,
    /// How many cycles of table 3 (170 MPa, 4 %, not overheated) would have used as much.
    pub equivalent_cycles: f64,
    /// Share of its life used: 1 is where such wires break.
    pub used: Share,
    /// Cycles left if they go on as they were; `None` before there are any.
    pub remaining_cycles: Option<f64>,
    /// The same of the wires that break first.
    pub remaining_cycles_least: Option<f64>,
    /// And of those that last longest.
    pub remaining_cycles_most: Option<f64>,
    /// Hours heated that are left, likewise.
    pub remaining_hours: Option<f64>,
    /// Whether it is broken in.
    pub broken_in: BrokenIn,
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::Rig;

    fn run(account: &mut Account, wire: &Wire, cycles: u32, low: f64, stress_pa: f64, temperature_c: f64) {
        for step in 0..cycles * 40 {
            let phase = f64::from(step) / 40.0 * std::f64::consts::TAU;
            let martensite = low + (1.0 - low) * (0.5 + 0.5 * phase.cos());
            let strain = wire.material.transformation_strain * martensite;
            account.see(
                wire,
                &Sample {
                    seconds: 0.1,
                    powered: step % 2 == 0,
                    power_w: 2.0,
                    martensite,
                    strain,
                    stress_pa,
                    temperature_c,
                },
            );
        }
    }

    #[test]
    fn whole_cycles_under_the_tables_stress_use_the_tables_life() {
        let rig = Rig::hexapod();
        let wire = Wire::of(&rig, 0);
        let mut account = Account::new("rig", "wire", false, &wire);
        run(&mut account, &wire, 200, 0.0, 170e6, 60.0);
        let report = account.report();
        assert!((report.cycles - 200.0).abs() < 0.6, "{}", report.cycles);
        // its transformation strain is table 3's 4 %
        let strain = wire.material.transformation_strain;
        let life = formulas::cycles_to_failure(&CycleUse { strain, ..CycleUse::TABLE });
        assert!((report.used.middle * life.cycles / report.cycles - 1.0).abs() < 0.01);
        assert!((report.used.most * life.least / report.cycles - 1.0).abs() < 0.01);
        assert!((report.used.least * life.most / report.cycles - 1.0).abs() < 0.01);
        let left = report.remaining_cycles.unwrap();
        assert!((left / (life.cycles - report.cycles) - 1.0).abs() < 0.01);
        assert!((report.hours_powered * 2.0 / report.hours_watched - 1.0).abs() < 1e-9);
        assert_eq!((report.broken_in, report.hottest_c, report.over_limit_s), (BrokenIn::Yes, Some(60.0), 0.0));
    }

    #[test]
    fn partial_loops_and_less_stress_use_less_and_heat_uses_more() {
        let rig = Rig::hexapod();
        let wire = Wire::of(&rig, 0);
        let used = |low: f64, stress_pa: f64, temperature_c: f64| {
            let mut account = Account::new("rig", "wire", false, &wire);
            run(&mut account, &wire, 20, low, stress_pa, temperature_c);
            (account.report().used.middle, account.over_limit_s)
        };
        let (whole, _) = used(0.0, 170e6, 60.0);
        assert!(used(0.5, 170e6, 60.0).0 < 0.2 * whole);
        assert!(used(0.0, 100e6, 60.0).0 < 0.2 * whole);
        let (hot, over_s) = used(0.0, 170e6, wire.limit_c + 60.0);
        assert!(hot > 1.5 * whole && over_s > 70.0, "{hot} {whole} {over_s}");
    }

    #[test]
    fn a_wire_that_is_only_held_or_not_known_uses_nothing() {
        let rig = Rig::hexapod();
        let wire = Wire::of(&rig, 0);
        let mut account = Account::new("rig", "wire", false, &wire);
        for k in 0..10_000 {
            let martensite = if k % 2 == 0 { 0.5 } else { 0.52 };
            let unknown = if k % 7 == 0 { f64::NAN } else { martensite };
            let sample = Sample {
                seconds: 0.001,
                powered: true,
                power_w: if k % 2 == 0 { 3.0 } else { f64::NAN },
                martensite: unknown,
                strain: f64::NAN,
                stress_pa: f64::NAN,
                temperature_c: f64::NAN,
            };
            account.see(&wire, &sample);
        }
        let report = account.report();
        assert_eq!((report.cycles, report.used, report.remaining_cycles), (0.0, Share::default(), None));
        assert_eq!((report.broken_in, report.hottest_c), (BrokenIn::No, None));
        assert!((report.without_temperature_s - 10.0).abs() < 1e-6);
        assert!((report.energy_j - 15.0).abs() < 1e-6, "what is not known adds nothing: {} J", report.energy_j);
    }
}
