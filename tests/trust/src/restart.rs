//! A driver that is killed and started again, on a simulated clock: whether the same demand gets the same duty as from one that was never
//! disturbed, and how hot the wire gets meanwhile. Each start finds the record of the output, as [`sinew_driver`] keeps it, or none.
//!
//! A wire cools while nobody drives it, and gets more afterwards, whatever is known of it. So the undisturbed driver's wire has the same
//! history: it is told to be off for as long. What two such drivers differ by whose samples have other noise is measured beside it: on the same
//! length a wire of shape memory may be on one branch of its loop or the other.

use sinew_backend::{Backend, Sample};
use sinew_driver::{Answer, Ask, Beat, Order};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

use crate::failure::Failure;
use crate::mortal::{Mortal, Record, clock_ns};

/// The wires: diameter in mm and supply in V, as in the table of derating in docs/supervisor.md.
const WIRES: [(f64, f64); 4] = [(0.05, 15.0), (0.125, 6.0), (0.125, 12.0), (0.3, 3.0)];
const RATE_HZ: f64 = 500.0;
/// A demand is to have its duty again so long after it was made again, s, and what a duty is averaged over: one that is derated comes and goes.
const SETTLED_S: f64 = 3.0;
const AVERAGED_S: f64 = 1.0;
/// And this is the same duty.
const SAME: f64 = 0.05;
/// How far beyond its limit a wire may come, K.
const PROMISED_K: f64 = 10.0;
/// What a start takes, s, until its first exchange.
const START_S: f64 = 0.2;
/// A driver in between lives for so long, s.
const SHORT_S: f64 = 0.02;

/// What is asked for.
#[derive(Debug, Clone, Copy)]
enum Demand {
    /// A share of the stroke.
    Stroke(f64),
    /// All that it may have, which is derated.
    Full,
}

const DEMANDS: [(&str, Demand); 3] = [
    ("half of the stroke", Demand::Stroke(0.5)),
    ("0.9 of the stroke", Demand::Stroke(0.9)),
    ("full duty", Demand::Full),
];

/// When the driver is killed, and how the next one comes.
#[derive(Debug, Clone, Copy)]
struct Moment {
    what: &'static str,
    /// So long after the demand, s; `None`: before there was one.
    killed_s: Option<f64>,
    /// The next one comes after so long, s, besides what its start takes.
    pause_s: f64,
    /// And so many in between are killed in their first cycles.
    more: usize,
    /// Whether it finds the record.
    remembers: bool,
    /// Whether it is promised the same duty.
    is_promised: bool,
}

const fn moment(what: &'static str, killed_s: Option<f64>, pause_s: f64, more: usize) -> Moment {
    Moment { what, killed_s, pause_s, more, remembers: true, is_promised: true }
}

const MOMENTS: [Moment; 9] = [
    moment("cold", None, 0.0, 0),
    Moment { remembers: false, ..moment("cold, without a record", None, 0.0, 0) },
    moment("0.3 s after the demand", Some(0.3), 0.0, 0),
    moment("1 s after the demand", Some(1.0), 0.0, 0),
    moment("4 s after the demand", Some(4.0), 0.0, 0),
    moment("12 s after the demand", Some(12.0), 0.0, 0),
    moment("4 s after it, for 3 s", Some(4.0), 3.0, 0),
    moment("4 s after it, and 8 more at once", Some(4.0), 0.0, 8),
    Moment { remembers: false, is_promised: false, ..moment("4 s after it, without a record", Some(4.0), 0.0, 0) },
];

/// A wire, which outlives the drivers on it.
struct Bench {
    rig: Rig,
    wires: SimulatedRig,
    driver: Mortal,
    record: Option<Record>,
    tickets: u64,
    hottest_c: f64,
    /// Duties by time, s.
    duties: Vec<(f64, f64)>,
}

impl Bench {
    fn new((diameter_mm, supply_v): (f64, f64), seed: u64) -> Result<Bench, Failure> {
        let area = diameter_mm * diameter_mm;
        let text = format!(
            "[rig]\nname = \"restart\"\nrate_hz = {RATE_HZ:?}\n\n[[channel]]\nname = \"wire\"\n\
             wire = {{ diameter_mm = {diameter_mm:?}, length_mm = 160.0 }}\ntaps = {{ l0_mm = 0.0, ls_mm = 150.0 }}\n\
             drive = {{ supply_v = {supply_v:?}, shunt_ohm = {:?}, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = {:?}, damping_n_s_per_m = {:?}, spring_n_per_m = {:?}, preload_n = {:?} }}\n",
            0.004 / area,
            5.0 * area,
            2000.0 * area,
            10_000.0 * area,
            150.0 * area,
        );
        let mut rig = Rig::parse(&text, "restart.toml").map_err(|e| Failure::Unexpected(e.to_string()))?;
        rig.simulation.seed = seed;
        let mut wires = SimulatedRig::new(&rig).map_err(|e| Failure::Unexpected(e.to_string()))?;
        wires.start().map_err(|e| Failure::Unexpected(e.to_string()))?;
        Ok(Bench {
            driver: started(&rig, &mut wires, Some(Record::rested(&rig)))?,
            rig,
            wires,
            record: None,
            tickets: 0,
            hottest_c: f64::NEG_INFINITY,
            duties: Vec::new(),
        })
    }

    fn watch(&mut self) {
        self.hottest_c = self.wires.truth(0).map_or(f64::NAN, |truth| truth.temperature_c).max(self.hottest_c);
    }

    fn now_ns(&self) -> u64 {
        clock_ns(self.wires.time_s())
    }

    fn cycle(&mut self) {
        let mut samples = [Sample::NONE];
        let exchanged = self.wires.exchange(&self.driver.duty, &mut samples);
        self.watch();
        self.driver.look(&mut self.wires, false);
        let beat = Beat { now_ns: self.now_ns(), missed: 0 };
        self.record = Some(self.driver.cycle(&mut self.wires, beat, exchanged, &samples));
        self.duties.push((self.wires.time_s(), self.driver.snapshot.channel[0].duty));
    }

    fn run_s(&mut self, seconds: f64) -> Result<(), Failure> {
        for _ in 0..(seconds * RATE_HZ) as u64 {
            self.cycle();
            if let Some(fault) = self.driver.snapshot.channel[0].fault() {
                return Err(Failure::Unexpected(format!("{} after {:.2} s", fault.flag(), self.wires.time_s())));
            }
        }
        Ok(())
    }

    /// Makes the demand; when it was taken, s.
    fn demand(&mut self, demand: Demand) -> Result<f64, Failure> {
        let channel = &self.driver.engine.channels()[0];
        self.ask(match demand {
            Demand::Stroke(share) => Ask::Length(channel.stroke_range().length_m(share)),
            Demand::Full => Ask::Duty(self.rig.channels[0].limits.max_duty),
        })
    }

    fn ask(&mut self, ask: Ask) -> Result<f64, Failure> {
        self.tickets += 1;
        let order = Order { ticket: self.tickets, channel: 0, ask, hold_ns: 1_000_000_000_000 };
        let at_ns = self.now_ns();
        match self.driver.engine.take(&order, at_ns) {
            Some(Answer::Done) => Ok(self.wires.time_s()),
            other => Err(Failure::Unexpected(format!("a demand is not taken: {other:?}"))),
        }
    }

    /// Killed between two cycles; its stage keeps its duty until its own watchdog acts, and the next one comes.
    fn killed(&mut self, moment: &Moment, pause_s: f64) -> Result<(), Failure> {
        for _ in 0..((START_S + pause_s) * RATE_HZ) as u64 {
            self.wires.missed(1);
            self.watch();
        }
        self.wires.start().map_err(|e| Failure::Unexpected(e.to_string()))?;
        self.driver = started(&self.rig, &mut self.wires, self.record.filter(|_| moment.remembers))?;
        Ok(())
    }

    fn mean_at(&self, at_s: f64) -> f64 {
        let near: Vec<f64> = self
            .duties
            .iter()
            .filter(|(time_s, _)| (time_s - at_s).abs() <= 0.5 * AVERAGED_S)
            .map(|(_, duty)| *duty)
            .collect();
        near.iter().sum::<f64>() / near.len() as f64
    }
}

fn started(rig: &Rig, wires: &mut SimulatedRig, record: Option<Record>) -> Result<Mortal, Failure> {
    Mortal::started(rig, wires, record).map_err(|e| Failure::Unexpected(e.to_string()))
}

/// The duty three seconds after the demand was made again, and how hot the wire was above its limit at the most, K.
fn duty_again(
    wire: (f64, f64),
    demand: Demand,
    moment: &Moment,
    seed: u64,
    is_killed: bool,
) -> Result<(f64, f64), Failure> {
    let mut bench = Bench::new(wire, seed)?;
    bench.run_s(1.0)?;
    if let Some(killed_s) = moment.killed_s {
        bench.demand(demand)?;
        bench.run_s(killed_s)?;
    }
    if is_killed {
        bench.killed(moment, moment.pause_s)?;
        for _ in 0..moment.more {
            bench.run_s(SHORT_S)?;
            bench.killed(moment, 0.0)?;
        }
    } else {
        // The stage of a dead driver keeps its duty until its own watchdog acts.
        let silence_s = bench.wires.silence_s().unwrap_or(0.0);
        bench.run_s(silence_s)?;
        bench.ask(Ask::Off)?;
        bench.run_s(START_S + moment.pause_s + moment.more as f64 * (SHORT_S + START_S) - silence_s)?;
    }
    let again_s = bench.demand(demand)?;
    bench.run_s(SETTLED_S + AVERAGED_S)?;
    let over_k = bench.hottest_c - bench.rig.channels[0].limits.max_temperature_c;
    Ok((bench.mean_at(again_s + SETTLED_S), over_k))
}

/// What a moment and a demand came to, over the wires.
struct Row {
    /// The worst difference of the duty, and the middle one; and of two that nobody has disturbed.
    off: [f64; 2],
    scatter: [f64; 2],
    over_k: f64,
}

impl Row {
    fn of(demand: Demand, moment: &Moment) -> Result<Row, Failure> {
        let (mut off, mut scatter, mut hottest_k) = (Vec::new(), Vec::new(), f64::NEG_INFINITY);
        for wire in WIRES {
            let (undisturbed, _) = duty_again(wire, demand, moment, 1, false)?;
            let (other, _) = duty_again(wire, demand, moment, 2, false)?;
            let (disturbed, over_k) = duty_again(wire, demand, moment, 2, true)?;
            off.push(disturbed / other - 1.0);
            scatter.push(undisturbed / other - 1.0);
            hottest_k = over_k.max(hottest_k);
        }
        let of = |mut all: Vec<f64>| {
            all.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            [all[all.len() - 1], all[all.len() / 2]]
        };
        Ok(Row { off: of(off), scatter: of(scatter), over_k: hottest_k })
    }
}

/// Measures all of them, and prints the table of docs/trust.md; whether what is promised is kept.
///
/// # Errors
/// A rig that is refused, or a fault where there is none.
pub fn restart() -> Result<bool, Failure> {
    let mut is_kept = true;
    println!(
        "| killed | demand | duty off, worst | median | two undisturbed, worst | median | hottest, K from the limit |\n\
         |---|---|--:|--:|--:|--:|--:|"
    );
    for moment in &MOMENTS {
        for (words, demand) in DEMANDS {
            let Row { off, scatter, over_k } = Row::of(demand, moment)?;
            let [off_worst, off, scatter_worst, scatter] = [off[0], off[1], scatter[0], scatter[1]].map(|x| 100.0 * x);
            println!(
                "| {} | {words} | {off_worst:+.1} % | {off:+.1} % | {scatter_worst:+.1} % | {scatter:+.1} % | {over_k:+.0} |",
                moment.what
            );
            is_kept &= over_k <= PROMISED_K && (!moment.is_promised || off_worst.abs() <= 100.0 * SAME);
        }
    }
    Ok(is_kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_restart_takes_a_wire_beyond_its_limit_and_a_cold_one_gets_what_it_got() {
        for moment in &MOMENTS {
            let Row { off, over_k, .. } = Row::of(Demand::Full, moment).unwrap();
            assert!(over_k <= PROMISED_K, "{}: {over_k} K above the limit", moment.what);
            if moment.killed_s.is_none() {
                assert!(off[0].abs() <= SAME, "{}: {:+.1} %", moment.what, 100.0 * off[0]);
            }
        }
    }
}
