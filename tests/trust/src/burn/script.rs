//! What happens in a history, and when: drawn first, carried out afterwards. So a script can be varied, and one that burns a wire cut down to
//! what it takes.

use std::fmt;

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use sinew_rig::FaultKind;

use crate::kind::{between, whole};

/// Cycles of a history after its wire is hot, at the most, whatever its rate: what is longer is cut.
const MOST_CYCLES: u64 = 40_000;
/// How long a history is, s.
const LENGTH_S: (f64, f64) = (10.0, 120.0);
/// Things of one kind in a script at the most.
const MOST_OF_A_KIND: u64 = 300;

/// What a client asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// Off.
    Off,
    /// A share of the stroke, 0 = cold.
    Stroke(f64),
    /// A share of the largest duty.
    Duty(f64),
    /// A reset.
    Reset,
}

/// What a load brings about: the current of a wire that is heated disturbs the machine that drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strike {
    /// The driver is killed as soon as it puts that much out: its machine browns out. The next one comes after so long, s, with its record.
    Kill(f64),
    /// The loop is not there for so long, s, while that much is in force.
    Stall(f64),
    /// The stage takes no other duty for so long, s.
    WriteFails(f64),
}

/// Something that happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Happening {
    /// The driver is gone; the next one comes after so long, s.
    Kill {
        /// Until the next one comes.
        pause_s: f64,
        /// Whether it was stopped in good order; else it was killed between its exchange and the rest of its cycle.
        in_order: bool,
        /// Whether the next one finds the record of the output.
        remembers: bool,
        /// Whether it has another rig file.
        other: bool,
    },
    /// The loop is not there for so long, s.
    Stall(f64),
    /// The machine is suspended for so long, s.
    Suspend(f64),
    /// Something breaks.
    Break {
        /// What.
        kind: FaultKind,
        /// Its size; NaN = the kind's default.
        size: f64,
        /// For so long, s.
        seconds: f64,
    },
    /// The line to the outputs is silent for so long, s: nothing is written and nothing is read.
    LostLine(f64),
    /// A draught of this strength from now on.
    Draught(f64),
    /// Somebody asks for something, for so long, s.
    Ask(Wish, f64),
    /// For so long, s, this strikes whenever a duty above a share of the largest is given.
    UnderLoad {
        /// What.
        strike: Strike,
        /// Of the largest duty.
        share: f64,
        /// For so long, s.
        seconds: f64,
    },
}

/// A happening at its time, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// When.
    pub at_s: f64,
    /// What.
    pub what: Happening,
}

impl fmt::Display for Wish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Wish::Off => f.write_str("off"),
            Wish::Stroke(stroke) => write!(f, "stroke {:.0} %", 100.0 * stroke),
            Wish::Duty(share) => write!(f, "duty {:.0} % of the largest", 100.0 * share),
            Wish::Reset => f.write_str("reset"),
        }
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:9.4} s  ", self.at_s)?;
        match self.what {
            Happening::Kill { pause_s, in_order, remembers, other } => {
                let end = if in_order { "stopped" } else { "killed" };
                let record = if remembers { "its record" } else { "no record" };
                let file = if other { ", another rig file" } else { "" };
                write!(f, "{end}; the next one after {pause_s:.3} s with {record}{file}")
            }
            Happening::Stall(seconds) => write!(f, "the loop is not there for {seconds:.4} s"),
            Happening::Suspend(seconds) => write!(f, "suspended for {seconds:.3} s"),
            Happening::Break { kind, size, seconds } if size.is_nan() => {
                write!(f, "{} for {seconds:.3} s", kind.word())
            }
            Happening::Break { kind, size, seconds } => write!(f, "{} of {size:.2} for {seconds:.3} s", kind.word()),
            Happening::LostLine(seconds) => write!(f, "no line for {seconds:.3} s"),
            Happening::Draught(strength) => write!(f, "a draught of {strength:.2}"),
            Happening::Ask(wish, hold_s) => write!(f, "{wish}, for {hold_s:.2} s"),
            Happening::UnderLoad { strike, share, seconds } => {
                write!(f, "for {seconds:.2} s, whenever more than {:.0} % is given: ", 100.0 * share)?;
                match strike {
                    Strike::Kill(pause_s) => write!(f, "killed; the next one after {pause_s:.3} s with its record"),
                    Strike::Stall(seconds) => write!(f, "the loop is not there for {seconds:.4} s"),
                    Strike::WriteFails(seconds) => write!(f, "no other duty is taken for {seconds:.3} s"),
                }
            }
        }
    }
}

/// What a script is made to meet while its wire is being heated, besides what happens by chance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// Kills as soon as power is given.
    Kills,
    /// Stalls while power is given.
    Stalls,
    /// A stage that takes no other duty while power is given.
    Writes,
    /// A load that jams.
    Jams,
    /// A client that wants everything and nothing by turns.
    Turns,
    /// Nothing more.
    Nothing,
}

impl Aim {
    /// By chance. Nobody jams a wire at the worst moment whose beliefs are off: a slow jam of one that loses 30 % less than is believed is
    /// seen by nothing, and goes 40 % further above the air than the power tells.
    pub fn by_chance(rng: &mut Xoshiro256PlusPlus, is_true: bool) -> Aim {
        let aim = [Aim::Kills, Aim::Stalls, Aim::Writes, Aim::Jams, Aim::Turns, Aim::Nothing][rng.random_range(0..6)];
        if aim == Aim::Jams && !is_true { Aim::Turns } else { aim }
    }

    /// Whether it needs outputs that stand for long in silence, and a supply that nobody switches.
    pub fn needs_silence(self) -> bool {
        matches!(self, Aim::Kills | Aim::Stalls | Aim::Writes)
    }
}

/// How a power stage sticks in a history, for good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sticking {
    /// When, s.
    pub at_s: f64,
    /// And what is left of the rest.
    pub how: Sticks,
}

/// What is left of driver, line and converter once a stage sticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sticks {
    /// They live on: nothing but orders and draughts happens any more.
    Watched,
    /// The converter shows nothing any more, and somebody presses the emergency stop.
    Stopped,
    /// The driver is killed at that, and nobody starts another.
    Abandoned,
    /// Whatever else happens goes on happening.
    Anyhow,
}

/// A history's script.
#[derive(Debug, Clone)]
pub struct Script {
    /// How long it goes on, periods.
    pub cycles: u64,
    /// How often the operator looks, s: he resets what is latched, the emergency stop too, and asks again for what was wanted last. 0 = as
    /// fast as allowed.
    pub looks_every_s: f64,
    /// Whether it ends as soon as the wire is hot.
    pub until_heated: bool,
    /// Whether its power stage sticks.
    pub sticks: Option<Sticking>,
    /// What happens, in the order of time.
    pub moments: Vec<Moment>,
}

/// What breaks by chance.
const BREAKS: [FaultKind; 9] = [
    FaultKind::WriteFails,
    FaultKind::WriteFails,
    FaultKind::AdcStuck,
    FaultKind::AdcNan,
    FaultKind::Jammed,
    FaultKind::SupplyDip,
    FaultKind::BackendError,
    FaultKind::EstopOpen,
    FaultKind::EstopReset,
];

/// What draws a happening.
type Drawn = fn(&mut Xoshiro256PlusPlus) -> Happening;

/// Everything that may happen.
const KINDS: [Drawn; 7] = [breaks, lost_line, draught, kill, stall, suspend, asks];

impl Script {
    /// Nothing but full power, asked for all along: how a wire is heated that nothing happens to.
    pub fn calm(rate_hz: f64) -> Script {
        let moments = vec![Moment { at_s: 0.0, what: HEAT }];
        let cycles = ((LENGTH_S.1 * rate_hz) as u64).min(5 * MOST_CYCLES);
        Script { cycles, looks_every_s: 0.0, until_heated: true, sticks: None, moments }
    }

    /// By chance, at a rate of the loop in Hz, for a wire that gets hot in so long, s. What happens does so once it is hot: at its limit or in
    /// a heating edge; where that is `early`, from the start.
    pub fn by_chance(
        rng: &mut Xoshiro256PlusPlus,
        rate_hz: f64,
        warm_s: f64,
        early: bool,
        sticks: Option<Sticks>,
    ) -> Script {
        let looks_every_s = if rng.random::<bool>() { 0.0 } else { log_between(rng, 0.02, 2.0) };
        // An operator who looks seldom needs some looks to begin.
        let warm_s = warm_s + 3.0 * looks_every_s;
        let from_s = if early { 0.0 } else { warm_s };
        let wanted_s = (warm_s + log_between(rng, 3.0, LENGTH_S.1)).clamp(LENGTH_S.0, LENGTH_S.1);
        let cycles = ((wanted_s * rate_hz) as u64).min((warm_s * rate_hz) as u64 + MOST_CYCLES);
        let seconds = cycles as f64 / rate_hz;
        let mut moments = vec![Moment { at_s: 0.0, what: HEAT }];
        match rng.random_range(0..3) {
            // It is held at its limit.
            0 => {}
            // It is heated again and again.
            1 => {
                let mut at_s = warm_s;
                while at_s < seconds && moments.len() < MOST_OF_A_KIND as usize {
                    let what = if rng.random::<bool>() { Wish::Off } else { Wish::Stroke(between(rng, 0.0, 0.5)) };
                    moments.push(Moment { at_s, what: Happening::Ask(what, FOR_LONG_S) });
                    at_s += between(rng, 0.02, 1.5) * warm_s;
                    moments.push(Moment { at_s, what: HEAT });
                    at_s += between(rng, 0.1, 1.5) * warm_s;
                }
            }
            // Everybody wants something else.
            _ => {
                let a_second = log_between(rng, 0.2, 20.0);
                for _ in 0..number(rng, a_second, seconds - warm_s) {
                    moments.push(Moment { at_s: between(rng, warm_s, seconds), what: asks(rng) });
                }
            }
        }
        // Clients that ask for the same in a loop.
        for _ in 0..whole(rng, 0, 2) {
            let Happening::Ask(wish, _) = asks(rng) else { continue };
            let wish = if rng.random::<bool>() { Wish::Reset } else { wish };
            let (every_s, hold_s) = (log_between(rng, 0.02, 2.0), log_between(rng, 0.1, FOR_LONG_S));
            let mut at_s = between(rng, from_s, seconds);
            for _ in 0..whole(rng, 2, MOST_OF_A_KIND) {
                moments.push(Moment { at_s, what: Happening::Ask(wish, hold_s) });
                at_s += every_s;
            }
        }
        let edges: Vec<f64> = moments.iter().filter(|moment| moment.what == HEAT).map(|moment| moment.at_s).collect();
        for what in &KINDS[..KINDS.len() - 1] {
            if rng.random::<bool>() {
                continue;
            }
            let a_second = log_between(rng, 0.03, 3.0);
            for _ in 0..number(rng, a_second, seconds - from_s) {
                let edge_s = edges[rng.random_range(0..edges.len())].max(from_s);
                let at_s = if rng.random::<bool>() {
                    edge_s + between(rng, 0.0, 1.2) * warm_s
                } else {
                    between(rng, from_s, seconds)
                };
                moments.push(Moment { at_s, what: what(rng) });
            }
        }
        let sticks = sticks.map(|how| Sticking { at_s: between(rng, 0.9 * warm_s, seconds.max(warm_s)), how });
        let mut script = Script { cycles, looks_every_s, until_heated: false, sticks, moments };
        script.tidy(rate_hz);
        script
    }

    /// The same with what it aims at, for a wire that gets hot in so long, s.
    pub fn aimed(mut self, rng: &mut Xoshiro256PlusPlus, aim: Aim, rate_hz: f64, warm_s: f64) -> Script {
        let seconds = self.cycles as f64 / rate_hz;
        if let Some(sticking) = self.sticks {
            // All is well until then, and nothing but the sensing pulse is asked for any more.
            if rng.random::<bool>() {
                let from_s = sticking.at_s - log_between(rng, 1.0 / rate_hz, 1.0);
                self.moments.retain(|moment| match moment.what {
                    Happening::Ask(..) => moment.at_s < from_s,
                    Happening::Draught(_) => true,
                    _ => false,
                });
                self.moments.push(Moment { at_s: from_s, what: Happening::Ask(Wish::Off, FOR_LONG_S) });
            }
            self.tidy(rate_hz);
            return self;
        }
        if aim == Aim::Nothing {
            return self;
        }
        // Mostly nothing else happens.
        if rng.random_range(0..4) > 0 {
            self.moments.clear();
        }
        if rng.random_range(0..4) > 0 {
            self.looks_every_s = 0.0;
        }
        let share = between(rng, 0.0, 0.9);
        let what = match aim {
            Aim::Kills => Strike::Kill(between(rng, 0.0, 0.2)).under_load(share, 0.0),
            Aim::Stalls => Strike::Stall(between(rng, 0.05, UNSEEN_STALL_S)).under_load(share, 0.0),
            Aim::Writes => Strike::WriteFails(log_between(rng, 0.03, 0.3)).under_load(share, 0.0),
            Aim::Jams => Happening::Break { kind: FaultKind::Jammed, size: f64::NAN, seconds: 0.0 },
            Aim::Turns | Aim::Nothing => HEAT,
        };
        // It is heated again and again, and each time that happens at another moment.
        let mut at_s = 0.0;
        while at_s < seconds && self.moments.len() < MOST_OF_A_KIND as usize {
            self.moments.push(Moment { at_s, what: HEAT });
            let lasts_s = warm_s * log_between(rng, 0.1, 10.0);
            let from_s = at_s + between(rng, 0.0, 1.5) * warm_s;
            self.moments.push(Moment { at_s: from_s, what: what.lasting(lasts_s) });
            at_s = from_s + if aim == Aim::Turns { between(rng, 0.0, 0.5) * warm_s } else { lasts_s };
            let wish = if rng.random::<bool>() { Wish::Off } else { Wish::Stroke(between(rng, 0.0, 1.0)) };
            self.moments.push(Moment { at_s, what: Happening::Ask(wish, FOR_LONG_S) });
            at_s += between(rng, 0.02, 1.0) * warm_s;
        }
        self.tidy(rate_hz);
        self
    }

    fn tidy(&mut self, rate_hz: f64) {
        let seconds = self.cycles as f64 / rate_hz;
        self.moments.retain(|moment| moment.at_s >= 0.0 && moment.at_s <= seconds);
        self.moments.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    }

    /// The same without jams of the load.
    pub fn without_jams(&self) -> Script {
        let mut script = self.clone();
        script.moments.retain(|moment| !matches!(moment.what, Happening::Break { kind: FaultKind::Jammed, .. }));
        script
    }

    /// One that is a little different, mostly before `hottest_s`, the moment when its wire was hottest; of a wire that gets hot in `warm_s`.
    /// `with`: another script for the same wire, parts of which may be taken over, and when that one was hottest.
    pub fn varied(
        &self,
        rng: &mut Xoshiro256PlusPlus,
        rate_hz: f64,
        warm_s: f64,
        hottest_s: f64,
        with: (&Script, f64),
    ) -> Script {
        let mut script = self.clone();
        let seconds = self.cycles as f64 / rate_hz;
        for _ in 0..whole(rng, 1, 3) {
            // What led to the hottest moment began a period or a heating before it.
            let back_s = log_between(rng, 1.0 / rate_hz, (2.0 * warm_s).max(0.5));
            let near_s = |rng: &mut Xoshiro256PlusPlus| {
                if rng.random_range(0..8) == 0 {
                    between(rng, 0.0, seconds)
                } else {
                    hottest_s - between(rng, 0.0, back_s)
                }
            };
            let moments = &mut script.moments;
            let one = nearest(rng, moments, near_s);
            match (whole(rng, 0, 11), one) {
                // Another thing.
                (0..=2, _) => moments.push(Moment { at_s: near_s(rng), what: any(rng) }),
                // What led to it, again and again, in a rhythm.
                (3, _) => {
                    let led: Vec<Moment> = (moments.iter())
                        .filter(|moment| (hottest_s - back_s..=hottest_s).contains(&moment.at_s))
                        .take(8)
                        .copied()
                        .collect();
                    let every_s = back_s * between(rng, 1.0, 1.5);
                    for round in 1..=whole(rng, 1, 8) {
                        let later = |moment: &Moment| Moment { at_s: moment.at_s + round as f64 * every_s, ..*moment };
                        moments.extend(led.iter().map(later));
                    }
                }
                // One thing in a rhythm.
                (4, one) => {
                    let what = one.map_or_else(|| any(rng), |one| moments[one].what);
                    let (every_s, from_s) = (log_between(rng, 2.0 / rate_hz, 1.0), near_s(rng));
                    for round in 0..whole(rng, 2, 30) {
                        moments.push(Moment { at_s: from_s + round as f64 * every_s, what });
                    }
                }
                // Full power before it all.
                (5, _) => moments.push(Moment { at_s: near_s(rng), what: HEAT }),
                (6, Some(one)) => drop(moments.remove(one)),
                (7, Some(one)) => moments[one].at_s += back_s * between(rng, -1.0, 1.0),
                (8 | 9, Some(one)) => moments[one].what = moments[one].what.stretched(log_between(rng, 0.3, 3.0)),
                // What led another one to its hottest moment.
                (10, _) => {
                    let (other, its_hottest_s) = with;
                    let shift_s = hottest_s - its_hottest_s;
                    let led = other
                        .moments
                        .iter()
                        .filter(|moment| (its_hottest_s - back_s.max(warm_s)..=its_hottest_s).contains(&moment.at_s));
                    let led = led.map(|moment| Moment { at_s: moment.at_s + shift_s, ..*moment });
                    moments.extend(led.take(MOST_OF_A_KIND as usize));
                }
                _ => script.looks_every_s = if rng.random::<bool>() { 0.0 } else { log_between(rng, 0.02, 2.0) },
            }
            if let Some(sticking) = &mut script.sticks
                && rng.random_range(0..4) == 0
            {
                sticking.at_s = between(rng, 0.0, seconds);
            }
        }
        script.tidy(rate_hz);
        script
    }
}

/// The moment that is nearest to a time.
fn nearest(
    rng: &mut Xoshiro256PlusPlus,
    moments: &[Moment],
    at_s: impl Fn(&mut Xoshiro256PlusPlus) -> f64,
) -> Option<usize> {
    let at_s = at_s(rng);
    let after = moments.partition_point(|moment| moment.at_s < at_s);
    (!moments.is_empty()).then(|| after.min(moments.len() - 1))
}

impl Strike {
    fn under_load(self, share: f64, seconds: f64) -> Happening {
        Happening::UnderLoad { strike: self, share, seconds }
    }
}

impl Happening {
    /// The same for so long, s, where it lasts.
    fn lasting(self, seconds: f64) -> Happening {
        match self {
            Happening::Break { kind, size, .. } => Happening::Break { kind, size, seconds },
            Happening::UnderLoad { strike, share, .. } => Happening::UnderLoad { strike, share, seconds },
            other => other,
        }
    }

    /// The same so many times as long.
    fn stretched(self, times: f64) -> Happening {
        match self {
            Happening::Kill { pause_s, in_order, remembers, other } => {
                Happening::Kill { pause_s: (pause_s * times).min(MOST_PAUSE_S), in_order, remembers, other }
            }
            Happening::Stall(seconds) => Happening::Stall((seconds * times).min(MOST_STALL_S)),
            Happening::Suspend(seconds) => Happening::Suspend(seconds * times),
            Happening::Break { kind, size, seconds } => Happening::Break { kind, size, seconds: seconds * times },
            Happening::LostLine(seconds) => Happening::LostLine(seconds * times),
            Happening::Draught(strength) => Happening::Draught((strength * times).min(1.0)),
            Happening::Ask(wish, hold_s) => Happening::Ask(wish, hold_s * times),
            Happening::UnderLoad { strike, share, seconds } => {
                let strike = match strike {
                    Strike::Kill(pause_s) => Strike::Kill((pause_s * times).min(MOST_PAUSE_S)),
                    Strike::Stall(seconds) => Strike::Stall((seconds * times).min(MOST_STALL_S)),
                    Strike::WriteFails(seconds) => Strike::WriteFails(seconds * times),
                };
                Happening::UnderLoad { strike, share, seconds }
            }
        }
    }
}

const FOR_LONG_S: f64 = 60.0;
const HEAT: Happening = Happening::Ask(Wish::Duty(1.0), FOR_LONG_S);
const MOST_PAUSE_S: f64 = 60.0;
const MOST_STALL_S: f64 = 5.0;
/// The longest silence of the loop that is no fault.
const UNSEEN_STALL_S: f64 = 0.249;

/// Evenly on a logarithmic scale.
fn log_between(rng: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

/// How many things happen in so many seconds, at a rate.
fn number(rng: &mut Xoshiro256PlusPlus, a_second: f64, seconds: f64) -> u64 {
    ((a_second * seconds.max(0.0) + rng.random::<f64>()) as u64).min(MOST_OF_A_KIND)
}

fn any(rng: &mut Xoshiro256PlusPlus) -> Happening {
    KINDS[rng.random_range(0..KINDS.len())](rng)
}

fn breaks(rng: &mut Xoshiro256PlusPlus) -> Happening {
    let kind = BREAKS[rng.random_range(0..BREAKS.len())];
    let size = if kind == FaultKind::SupplyDip { between(rng, 0.0, 0.95) } else { f64::NAN };
    Happening::Break { kind, size, seconds: log_between(rng, 0.01, 5.0) }
}

fn lost_line(rng: &mut Xoshiro256PlusPlus) -> Happening {
    Happening::LostLine(log_between(rng, 0.01, 3.0))
}

fn draught(rng: &mut Xoshiro256PlusPlus) -> Happening {
    Happening::Draught(if rng.random::<bool>() { between(rng, 0.0, 1.0) } else { 0.0 })
}

fn kill(rng: &mut Xoshiro256PlusPlus) -> Happening {
    let pause_s = match whole(rng, 0, 9) {
        0..=4 => between(rng, 0.0, 0.3),
        5..=8 => between(rng, 0.0, 5.0),
        _ => between(rng, 0.0, MOST_PAUSE_S),
    };
    let (remembers, in_order) = (rng.random::<bool>(), rng.random_range(0..4) == 0);
    Happening::Kill { pause_s, in_order, remembers, other: rng.random_range(0..4) == 0 }
}

fn stall(rng: &mut Xoshiro256PlusPlus) -> Happening {
    let longest_s = if rng.random_range(0..10) == 0 { MOST_STALL_S } else { UNSEEN_STALL_S };
    Happening::Stall(between(rng, 0.001, longest_s))
}

fn suspend(rng: &mut Xoshiro256PlusPlus) -> Happening {
    Happening::Suspend(log_between(rng, 0.01, 20.0))
}

fn asks(rng: &mut Xoshiro256PlusPlus) -> Happening {
    let wish = match whole(rng, 0, 6) {
        0 => Wish::Off,
        1 => Wish::Stroke(between(rng, 0.0, 1.0)),
        2 => Wish::Stroke(1.0),
        3 => Wish::Duty(between(rng, 0.0, 1.0)),
        4 => Wish::Reset,
        _ => Wish::Duty(1.0),
    };
    Happening::Ask(wish, log_between(rng, 0.1, FOR_LONG_S))
}
