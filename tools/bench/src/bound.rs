//! The time-optimal bound of a wire's settling time.
//!
//! Searches the shortest time after which the wire stays within a band around a length, with the
//! wire, its load and its state known exactly, without noise, delay or sensing pulse. The power is between zero
//! and the largest mean power the channel may take, so by Pontryagin's principle the optimal power is at one of its ends until
//! the wire arrives: full power until a first switch, none until a second one (for cooling the other way round), and then the power
//! that holds the temperature, which stops the transformation. Between the second switch and the arrival the load may still creep
//! into the band.
//!
//! The switches are searched on clones of the simulated wire itself, in steps of a millisecond and with switches between steps.
//! For each length of the second phase the first switch is bisected: as late as the wire still stays on this side of the far
//! edge of the band. Over that length the arrival falls until it ends abruptly (the wire creeps back), and is searched by sections.
//! A load that oscillates when it is stopped has to be stopped in two pulses half an oscillation apart: for such a load two more switches
//! are searched from there, by descent from several stops of that kind.

use sinew_physics::formulas::heating_power_w;
use sinew_physics::{Inputs, Load, Wire, WireModel};

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
/// Steps of each descent from there, where the load rings.
const DESCENT: u32 = 60;

/// The answer, with the power that reaches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Time after which the wire is in the band for good, s.
    pub settle_s: f64,
    /// How long each phase lasts, s: the power that gets the wire there, its opposite, and so on in turn; then the hold.
    pub phases_s: [f64; 4],
}

/// What is commanded: where to, from where.
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
    /// Half a period of a load that rings, s; see [`swing_s`].
    pub swing_s: Option<f64>,
}

/// Half a period of the load's own oscillation on the cold wire's stiffness, s; `None` where half the critical damping, or more,
/// does away with it.
pub fn swing_s(model: &WireModel) -> Option<f64> {
    let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, .. } = model.load else { return None };
    let own = model.cold_stiffness_n_per_m();
    let undamped = (spring_n_per_m + own) / mass_kg;
    let damped = undamped - (0.5 * damping_n_s_per_m / mass_kg).powi(2);
    (damped > 0.75 * undamped).then(|| std::f64::consts::PI / damped.sqrt())
}

/// The bound for bringing `wire` to `aim`; `None` where full power, or none, does not get there within a minute.
pub fn time_optimal(wire: &Wire, aim: &Aim) -> Option<Bound> {
    let search = Search::new(wire, aim)?;
    if search.far_s == 0.0 {
        return Some(Bound { settle_s: 0.0, phases_s: [0.0; 4] });
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

    /// What comes of a first phase and those after it.
    fn outcome(&self, first_s: f64, rest_s: [f64; 3]) -> Outcome {
        let mut wire = self.at(first_s);
        let mut watch = Watch { band: self.aim.band_m, since: self.entered_s(first_s), before: self.error(&wire) };
        if watch.before > watch.band {
            return Outcome::TooFar;
        }
        let mut time = first_s;
        for (phase, mut left) in rest_s.into_iter().enumerate() {
            while left > 1e-9 {
                let step = left.min(STEP_S);
                self.drive(&mut wire, self.duties[(phase + 1) % 2], step);
                (time, left) = (time + step, left - step);
                if watch.see(time, step, self.error(&wire)) {
                    return Outcome::TooFar;
                }
            }
        }
        let mut hold = Hold::at(&wire, self.aim);
        let (end, mut quiet) = (time + WATCH_S, 0.0);
        while time < end && quiet < QUIET_S {
            hold.step(&mut wire, STEP_S);
            time += STEP_S;
            if watch.see(time, STEP_S, self.error(&wire)) {
                return Outcome::TooFar;
            }
            quiet = if wire.velocity_m_s().abs() * REST_S < watch.band { quiet + STEP_S } else { 0.0 };
        }
        watch.since.map_or(Outcome::TooShort, Outcome::Settled)
    }

    /// The latest first switch that does not carry the wire too far, and what comes of it.
    fn latest(&self, rest_s: [f64; 3]) -> Option<Bound> {
        let (mut low, mut high) = (0.0, self.far_s);
        let mut best = None;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            match self.outcome(middle, rest_s) {
                Outcome::TooFar => high = middle,
                Outcome::TooShort => low = middle,
                Outcome::Settled(settle_s) => {
                    low = middle;
                    let [second, third, fourth] = rest_s;
                    best = better(best, Some(Bound { settle_s, phases_s: [middle, second, third, fourth] }));
                }
            }
            if high - low < 1e-5 {
                break;
            }
        }
        best
    }

    fn best(&self) -> Option<Bound> {
        let two = self.two_switches();
        match self.aim.swing_s {
            Some(swing) if swing > 4.0 * STEP_S => self.four_switches(two, swing),
            _ => two,
        }
    }

    fn two_switches(&self) -> Option<Bound> {
        // from nothing over short ones to as long as the whole way
        let length = |i: usize| self.far_s * (i as f64 / (LENGTHS - 1) as f64).powi(2);
        let at = |second_s: f64| self.latest([second_s, 0.0, 0.0]);
        let tried: Vec<Option<Bound>> = (0..LENGTHS).map(|i| at(length(i))).collect();
        let middle = (0..LENGTHS).min_by(|&a, &b| time(tried[a]).total_cmp(&time(tried[b])))?;
        let mut best = tried[middle];
        let (mut low, mut high) = (length(middle.saturating_sub(1)), length((middle + 1).min(LENGTHS - 1)));
        let golden = 0.5 * (5f64.sqrt() - 1.0);
        let mut inner = [high - golden * (high - low), low + golden * (high - low)];
        let mut values = inner.map(at);
        for _ in 0..SECTIONS {
            best = better(better(best, values[0]), values[1]);
            if time(values[0]) <= time(values[1]) {
                high = inner[1];
                inner = [high - golden * (high - low), inner[0]];
                values = [at(inner[0]), values[0]];
            } else {
                low = inner[0];
                inner = [inner[1], low + golden * (high - low)];
                values = [values[1], at(inner[1])];
            }
        }
        better(better(best, values[0]), values[1])
    }

    /// From the best of two switches, and from stops in two blows, a `swing` (half a period) of the load apart.
    fn four_switches(&self, two: Option<Bound>, swing: f64) -> Option<Bound> {
        let mut best = two;
        for blow in [0.25, 0.5, 1.0, 2.0] {
            for again in [0.25, 0.5, 1.0] {
                let start = self.latest([blow * swing, (1.0 - 0.5 * again) * swing, again * swing]);
                best = better(best, start);
            }
        }
        let mut step = 0.25 * swing;
        while step > 0.02 * swing {
            let Some(Bound { phases_s: [_, rest @ ..], .. }) = best else { return best };
            let neighbours = (0..3).flat_map(|i| [-step, step].map(|by| (i, by))).map(|(i, by)| {
                let mut rest = rest;
                rest[i] = (rest[i] + by).max(0.0);
                rest
            });
            let found = neighbours.map(|rest| self.latest(rest)).fold(None, better);
            if time(found) < time(best) - 1e-4 {
                best = found;
            } else {
                step *= 0.5;
            }
        }
        // a swing through the far edge and back may be quicker, or a gentler stop that begins well before it
        let Some(Bound { phases_s, .. }) = best else { return best };
        let gentle = [1.0, 0.95, 0.9].map(|share| [share * self.far_s, 0.1 * swing, 0.5 * swing, 0.1 * swing]);
        let later = [sooner(phases_s, 0.5 * swing), sooner(phases_s, 1.5 * swing), phases_s];
        gentle.into_iter().chain(later).fold(best, |best, start| {
            let Tried { phases_s, value: settle_s } = descend(start, 0.25 * swing, |phases_s| self.arrival(phases_s));
            better(best, Some(Bound { settle_s, phases_s }))
        })
    }

    /// When the wire is in the band for good after these phases, whether it swung through it before or not; of one that does not
    /// stay more than any that does, and the more the farther.
    fn arrival(&self, phases_s: [f64; 4]) -> f64 {
        let [first_s, rest @ ..] = phases_s.map(|phase| phase.max(0.0));
        let first_s = first_s.min(self.far_s);
        let mut wire = self.at(first_s);
        let (mut time, mut arrived) = (first_s, self.entered_s(first_s).unwrap_or(first_s));
        let mut see = |wire: &Wire, time: f64| {
            if self.error(wire).abs() > self.aim.band_m {
                arrived = time;
            }
        };
        see(&wire, time);
        for (phase, mut left) in rest.into_iter().enumerate() {
            while left > 1e-9 {
                let step = left.min(STEP_S);
                self.drive(&mut wire, self.duties[(phase + 1) % 2], step);
                (time, left) = (time + step, left - step);
                see(&wire, time);
            }
        }
        let mut hold = Hold::at(&wire, self.aim);
        let (end, mut quiet) = (time + WATCH_S, 0.0);
        while time < end && quiet < QUIET_S {
            hold.step(&mut wire, STEP_S);
            time += STEP_S;
            see(&wire, time);
            quiet = if wire.velocity_m_s().abs() * REST_S < self.aim.band_m { quiet + STEP_S } else { 0.0 };
        }
        let off = self.error(&wire).abs() / self.aim.band_m;
        if off <= 1.0 { arrived + STEP_S } else { LONGEST_S + off }
    }
}

/// Lengths of the phases that were tried, and what came of them.
#[derive(Clone, Copy)]
struct Tried {
    phases_s: [f64; 4],
    value: f64,
}

/// Nelder and Mead's simplex from `from`, with edges of `size`: where it ends.
fn descend(from: [f64; 4], size: f64, value: impl Fn([f64; 4]) -> f64) -> Tried {
    let tried = |phases_s| Tried { phases_s, value: value(phases_s) };
    let mut best = tried(from);
    for sign in [1.0, -1.0, 0.3] {
        let start = best.phases_s;
        let mut simplex: Vec<Tried> = (0..5)
            .map(|i| {
                let mut corner = start;
                if i > 0 {
                    corner[i - 1] = (corner[i - 1] + sign * size).max(0.0);
                }
                tried(corner)
            })
            .collect();
        for _ in 0..DESCENT {
            simplex.sort_by(|a, b| a.value.total_cmp(&b.value));
            let middle: [f64; 4] =
                std::array::from_fn(|i| simplex[..4].iter().map(|t| t.phases_s[i]).sum::<f64>() / 4.0);
            let worst = simplex[4];
            let at =
                |far: f64| tried(std::array::from_fn(|i| (middle[i] + far * (worst.phases_s[i] - middle[i])).max(0.0)));
            let reflected = at(-1.0);
            let next = if reflected.value < simplex[0].value {
                let further = at(-2.0);
                if further.value < reflected.value { further } else { reflected }
            } else if reflected.value < simplex[3].value {
                reflected
            } else {
                at(if reflected.value < worst.value { -0.5 } else { 0.5 })
            };
            if next.value < worst.value {
                simplex[4] = next;
            } else {
                let towards = simplex[0].phases_s;
                for corner in &mut simplex[1..] {
                    *corner = tried(std::array::from_fn(|i| 0.5 * (corner.phases_s[i] + towards[i])));
                }
            }
        }
        best = simplex.into_iter().fold(best, |best, corner| if corner.value < best.value { corner } else { best });
    }
    best
}

/// The same with the first switch so much earlier.
fn sooner([first, rest @ ..]: [f64; 4], by_s: f64) -> [f64; 4] {
    [(first - by_s).max(0.0), rest[0], rest[1], rest[2]]
}

fn time(bound: Option<Bound>) -> f64 {
    bound.map_or(f64::INFINITY, |bound| bound.settle_s)
}

fn better(a: Option<Bound>, b: Option<Bound>) -> Option<Bound> {
    if time(b) < time(a) { b } else { a }
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
        // both are read off a clone: its heat capacity and loss follow from what a step without power does
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
        let full_w = heating_power_w(1.0, current_a, wire.resistance_ohm());
        let duty = if full_w > 0.0 { (power_w / full_w).clamp(0.0, self.max_duty) } else { 0.0 };
        let before = wire.energy().loss_j;
        wire.step(&Inputs { drive: duty, ..self.inputs }, dt_s);
        self.loss_w = (wire.energy().loss_j - before) / dt_s;
    }
}
