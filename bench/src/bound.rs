//! How fast a wire can settle at all: the time-optimal bound.
//!
//! What is searched for is the shortest time after which the wire stays within a band around a length, for whoever knows the
//! wire, its load and its state exactly, measures without noise or delay and needs no sensing pulse. The power is between nothing
//! and the largest mean power the channel may take, so by Pontryagin's principle the optimal power is at one of its ends until
//! the wire arrives: full power until a first switch, none until a second one (for cooling the other way round), and then the power
//! that holds the temperature, which stops the transformation. Between the second switch and the arrival the load may still creep
//! into the band.
//!
//! Both switches are searched on clones of the simulated wire itself, in steps of a millisecond and with switches between steps.
//! For each length of the second phase the first switch is bisected: heat as long as the wire does not leave the far side of
//! the band. Over that length the arrival falls until it ends abruptly (the wire creeps back), and is searched by sections.

use sinew_physics::{Inputs, Wire};

/// Steps of the searched trajectories, s.
const STEP_S: f64 = 1e-3;
/// Longest that is looked ahead, s.
const LONGEST_S: f64 = 60.0;
/// Time constant with which the hold takes out what is left of a temperature error, s.
const HOLD_S: f64 = 5e-3;
/// A held wire that would take so long to cross the band is at rest, s …
const REST_S: f64 = 2.0;
/// … once it has been so slow for so long, s: no turning point of an oscillation.
const QUIET_S: f64 = 0.06;
/// Longest a hold is watched, s.
const WATCH_S: f64 = 6.0;
/// Bisections of the first switch: LONGEST_S to 10 µs.
const BISECTIONS: u32 = 22;
/// Lengths of the second phase that are tried before the best is searched from its neighbours.
const LENGTHS: usize = 12;
/// Golden sections of that search.
const SECTIONS: u32 = 14;

/// The answer, with the power that reaches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Time after which the wire is in the band for good, s.
    pub settle_s: f64,
    /// When the first power ends, s.
    pub first_s: f64,
    /// How long the second one lasts, s.
    pub second_s: f64,
}

/// What is asked: where to, from where.
#[derive(Debug, Clone, Copy)]
pub struct Aim {
    /// Elongation wanted, m.
    pub target_m: f64,
    /// Half width of the band around it, m.
    pub band_m: f64,
    /// Largest duty, 0..1.
    pub max_duty: f64,
    /// What acts on the wire besides the drive.
    pub inputs: Inputs,
}

/// The bound for bringing `wire` to `aim`; `None` where full power, or none, does not get there within a minute.
pub fn time_optimal(wire: &Wire, aim: &Aim) -> Option<Bound> {
    let search = Search::new(wire, aim)?;
    if search.far_s == 0.0 {
        return Some(Bound { settle_s: 0.0, first_s: 0.0, second_s: 0.0 });
    }
    search.best()
}

/// What became of one choice of switches.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Outcome {
    /// In the band for good after this time, s.
    Settled(f64),
    /// It left the far side of the band.
    TooFar,
    /// It did not get there, or fell back.
    TooShort,
}

struct Search<'a> {
    aim: &'a Aim,
    /// +1 where the wire has to get longer.
    sign: f64,
    /// Duties of the first and the second phase.
    duties: [f64; 2],
    /// The wire under the first duty at every step, up to where it leaves the far side of the band.
    path: Vec<Wire>,
    far_s: f64,
}

impl<'a> Search<'a> {
    fn new(wire: &Wire, aim: &'a Aim) -> Option<Search<'a>> {
        let away = aim.target_m - wire.position_m();
        let sign = away.signum();
        let duties = if sign > 0.0 { [0.0, aim.max_duty] } else { [aim.max_duty, 0.0] };
        let mut search = Search { aim, sign, duties, path: vec![wire.clone()], far_s: 0.0 };
        if away.abs() <= aim.band_m {
            return Some(search);
        }
        let mut now = wire.clone();
        while search.error(&now) < aim.band_m {
            if search.path.len() as f64 * STEP_S > LONGEST_S {
                return None;
            }
            search.drive(&mut now, duties[0], STEP_S);
            search.path.push(now.clone());
        }
        search.far_s = (search.path.len() - 1) as f64 * STEP_S;
        Some(search)
    }

    /// How far beyond the target, m.
    fn error(&self, wire: &Wire) -> f64 {
        self.sign * (wire.position_m() - self.aim.target_m)
    }

    fn drive(&self, wire: &mut Wire, duty: f64, dt_s: f64) {
        wire.step(&Inputs { drive: duty, ..self.aim.inputs }, dt_s);
    }

    /// The wire at the first switch.
    fn at(&self, first_s: f64) -> Wire {
        let index = ((first_s / STEP_S) as usize).min(self.path.len() - 1);
        let mut wire = self.path[index].clone();
        self.drive(&mut wire, self.duties[0], first_s - index as f64 * STEP_S);
        wire
    }

    /// When the first phase has brought the wire into the band, where it has.
    fn entered_s(&self, first_s: f64) -> Option<f64> {
        let last = ((first_s / STEP_S) as usize).min(self.path.len() - 1);
        let band = self.aim.band_m;
        let index = self.path[..=last].partition_point(|wire| self.error(wire) < -band);
        // the path only goes forward
        (index > 0 && index <= last).then(|| {
            let [before, after] = [index - 1, index].map(|i| self.error(&self.path[i]));
            (index as f64 - (after + band) / (after - before)) * STEP_S
        })
    }

    fn outcome(&self, first_s: f64, second_s: f64) -> Outcome {
        let mut wire = self.at(first_s);
        let mut watch = Watch { band: self.aim.band_m, since: self.entered_s(first_s), before: self.error(&wire) };
        if watch.before > watch.band {
            return Outcome::TooFar;
        }
        let mut time = first_s;
        let mut left = second_s;
        while left > 1e-9 {
            let step = left.min(STEP_S);
            self.drive(&mut wire, self.duties[1], step);
            (time, left) = (time + step, left - step);
            if watch.see(time, step, self.error(&wire)) {
                return Outcome::TooFar;
            }
        }
        let mut hold = Hold::at(&wire, self.aim);
        let (end, mut quiet) = (time + WATCH_S, 0.0);
        while time < end && quiet < QUIET_S {
            hold.step(&mut wire, STEP_S);
            time += STEP_S;
            let error = self.error(&wire);
            if watch.see(time, STEP_S, error) {
                return Outcome::TooFar;
            }
            quiet = if wire.velocity_m_s().abs() * REST_S < watch.band { quiet + STEP_S } else { 0.0 };
        }
        watch.since.map_or(Outcome::TooShort, Outcome::Settled)
    }

    /// The latest first switch that does not carry the wire too far, and what comes of it.
    fn latest(&self, second_s: f64) -> Option<Bound> {
        let (mut low, mut high) = (0.0, self.far_s);
        let mut best = None;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            match self.outcome(middle, second_s) {
                Outcome::TooFar => high = middle,
                Outcome::TooShort => low = middle,
                Outcome::Settled(settle_s) => {
                    low = middle;
                    best = Some(Bound { settle_s, first_s: middle, second_s });
                }
            }
            if high - low < 1e-5 {
                break;
            }
        }
        best
    }

    fn best(&self) -> Option<Bound> {
        let better = |a: Option<Bound>, b: Option<Bound>| match (a, b) {
            (Some(a), Some(b)) => Some(if b.settle_s < a.settle_s { b } else { a }),
            (a, b) => a.or(b),
        };
        // from nothing over short ones to as long as the whole way
        let length = |i: usize| self.far_s * (i as f64 / (LENGTHS - 1) as f64).powi(2);
        let tried: Vec<Option<Bound>> = (0..LENGTHS).map(|i| self.latest(length(i))).collect();
        let time = |bound: &Option<Bound>| bound.map_or(f64::INFINITY, |b| b.settle_s);
        let middle = (0..LENGTHS).min_by(|&a, &b| time(&tried[a]).total_cmp(&time(&tried[b])))?;
        let mut best = tried[middle];
        let (mut low, mut high) = (length(middle.saturating_sub(1)), length((middle + 1).min(LENGTHS - 1)));
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let mut inner = [high - golden * (high - low), low + golden * (high - low)];
        let mut values = inner.map(|second_s| self.latest(second_s));
        for _ in 0..SECTIONS {
            best = better(better(best, values[0]), values[1]);
            if time(&values[0]) <= time(&values[1]) {
                high = inner[1];
                inner = [high - golden * (high - low), inner[0]];
                values = [self.latest(inner[0]), values[0]];
            } else {
                low = inner[0];
                inner = [inner[1], low + golden * (high - low)];
                values = [values[1], self.latest(inner[1])];
            }
        }
        better(better(best, values[0]), values[1])
    }
}

/// Notices when the wire enters the band, and when it leaves it again.
struct Watch {
    band: f64,
    since: Option<f64>,
    before: f64,
}

impl Watch {
    /// The error at `time`, a step of `dt` after the last one; true where the far side was left.
    fn see(&mut self, time: f64, dt: f64, error: f64) -> bool {
        if error < -self.band {
            self.since = None;
        } else if self.since.is_none() {
            self.since = Some(time - dt * ((error + self.band) / (error - self.before)).clamp(0.0, 1.0));
        }
        self.before = error;
        error > self.band
    }
}

/// Keeps a wire's temperature: the power that it loses, corrected for what is left of an error.
struct Hold {
    temperature_c: f64,
    heat_capacity_j_per_k: f64,
    loss_w: f64,
    max_duty: f64,
    inputs: Inputs,
}

impl Hold {
    fn at(wire: &Wire, aim: &Aim) -> Hold {
        // both are read off a clone: a wire tells its heat capacity and loss by what a step without power does
        let mut probe = wire.clone();
        let before = probe.energy();
        probe.step(&aim.inputs, 1e-5);
        let after = probe.energy();
        let cooled = probe.temperature_c() - wire.temperature_c();
        Hold {
            temperature_c: wire.temperature_c(),
            heat_capacity_j_per_k: (after.sensible_j - before.sensible_j) / if cooled == 0.0 { 1.0 } else { cooled },
            loss_w: (after.loss_j - before.loss_j) / 1e-5,
            max_duty: aim.max_duty,
            inputs: aim.inputs,
        }
    }

    fn step(&mut self, wire: &mut Wire, dt_s: f64) {
        let missing = self.temperature_c - wire.temperature_c();
        let power_w = self.loss_w + self.heat_capacity_j_per_k * missing / HOLD_S;
        let current_a = wire.outputs().current_a;
        let full_w = current_a * current_a * wire.resistance_ohm();
        let duty = if full_w > 0.0 { (power_w / full_w).clamp(0.0, self.max_duty) } else { 0.0 };
        let before = wire.energy().loss_j;
        wire.step(&Inputs { drive: duty, ..self.inputs }, dt_s);
        self.loss_w = (wire.energy().loss_j - before) / dt_s;
    }
}
