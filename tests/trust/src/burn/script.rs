//! What happens in a history, and when: drawn first, carried out afterwards. So a script can be varied, and one that burns a wire cut down to
//! what it takes.

use std::fmt;

use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;
use sinew_rig::FaultKind;

use crate::kind::{between, whole};

/// Cycles of a history at the most, whatever its rate and length: what is longer is cut.
const MOST_CYCLES: u64 = 60_000;

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

/// Something that happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Happening {
    /// The driver is killed between its exchange and the rest of its cycle; the next one comes after so long, s.
    Kill {
        /// Until the next one comes.
        pause_s: f64,
        /// Whether that one finds the record of the output.
        remembers: bool,
        /// Whether it has another rig file.
        other: bool,
    },
    /// The loop is not there for so long, s.
    Stall(f64),
    /// Something breaks, for so long, s; infinite = for good.
    Break(FaultKind, f64),
    /// A draught of this strength from now on.
    Draught(f64),
    /// Somebody asks for something.
    Ask(Wish),
}

/// A happening at its time, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// When.
    pub at_s: f64,
    /// What.
    pub what: Happening,
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:9.4} s  ", self.at_s)?;
        match self.what {
            Happening::Kill { pause_s, remembers, other } => {
                let record = if remembers { "its record" } else { "no record" };
                let file = if other { ", another rig file" } else { "" };
                write!(f, "killed; the next one after {pause_s:.3} s with {record}{file}")
            }
            Happening::Stall(seconds) => write!(f, "the loop is not there for {seconds:.4} s"),
            Happening::Break(kind, seconds) => write!(f, "{} for {seconds:.3} s", kind.word()),
            Happening::Draught(strength) => write!(f, "a draught of {strength:.2}"),
            Happening::Ask(Wish::Off) => f.write_str("off"),
            Happening::Ask(Wish::Stroke(stroke)) => write!(f, "stroke {:.0} %", 100.0 * stroke),
            Happening::Ask(Wish::Duty(share)) => write!(f, "duty {:.0} % of the largest", 100.0 * share),
            Happening::Ask(Wish::Reset) => f.write_str("reset"),
        }
    }
}

/// A history's script.
#[derive(Debug, Clone)]
pub struct Script {
    /// How long it goes on, periods.
    pub cycles: u64,
    /// Whether somebody resets whatever is latched as fast as allowed.
    pub is_eager: bool,
    /// What happens, in the order of time.
    pub moments: Vec<Moment>,
}

/// What breaks by chance.
const BREAKS: [FaultKind; 6] = [
    FaultKind::WriteFails,
    FaultKind::AdcStuck,
    FaultKind::AdcNan,
    FaultKind::Jammed,
    FaultKind::SupplyDip,
    FaultKind::BackendError,
];

/// What draws a happening.
type Drawn<'a> = &'a dyn Fn(&mut Xoshiro256PlusPlus) -> Happening;

impl Script {
    /// By chance, at a rate of the loop in Hz. `has_stuck_stage`: at some moment the power stage sticks for good.
    pub fn by_chance(rng: &mut Xoshiro256PlusPlus, rate_hz: f64, has_stuck_stage: bool) -> Script {
        let cycles = ((between(rng, 10.0, 120.0) * rate_hz) as u64).min(MOST_CYCLES);
        let seconds = cycles as f64 / rate_hz;
        let is_eager = rng.random::<bool>();
        let mut script =
            Script { cycles, is_eager, moments: vec![Moment { at_s: 0.0, what: Happening::Ask(Wish::Duty(1.0)) }] };
        // How often things happen, a second: from a quiet hour to a day on which nothing works.
        let (mischief, kills, stalls) = (between(rng, 0.0, 0.5), between(rng, 0.0, 0.5), between(rng, 0.0, 3.0));
        let forgetful = between(rng, 0.0, 1.0);
        let kinds: [(f64, Drawn); 6] = [
            (mischief, &breaks),
            (0.5 * mischief, &draught),
            (if is_eager { 20.0 } else { 2.0 }, &asks),
            (2.0, &|_| Happening::Ask(Wish::Reset)),
            (stalls, &stall),
            (kills, &move |rng| kill(rng, forgetful)),
        ];
        for (a_second, what) in kinds {
            let times = (a_second * seconds + rng.random::<f64>()) as u64;
            for _ in 0..times {
                script.moments.push(Moment { at_s: between(rng, 0.0, seconds), what: what(rng) });
            }
        }
        if has_stuck_stage {
            let at_s = between(rng, 0.1, 0.9) * seconds;
            script.moments.push(Moment { at_s, what: Happening::Break(FaultKind::StageOn, f64::INFINITY) });
        }
        script.sort();
        script
    }

    fn sort(&mut self) {
        self.moments.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    }

    /// One that is a little different.
    pub fn varied(&self, rng: &mut Xoshiro256PlusPlus, rate_hz: f64) -> Script {
        let mut script = self.clone();
        let seconds = self.cycles as f64 / rate_hz;
        for _ in 0..whole(rng, 1, 4) {
            let one = if script.moments.is_empty() { None } else { Some(rng.random_range(0..script.moments.len())) };
            match (whole(rng, 0, 7), one) {
                // Another thing, at another time.
                (0 | 1, _) => {
                    let what = any(rng);
                    script.moments.push(Moment { at_s: between(rng, 0.0, seconds), what });
                }
                // The same again and again, in a rhythm.
                (2, one) => {
                    let what = match one {
                        Some(one) if rng.random::<bool>() => script.moments[one].what,
                        _ => any(rng),
                    };
                    let (every_s, from_s) = (between(rng, 0.01, 1.0), between(rng, 0.0, seconds));
                    for number in 0..whole(rng, 3, 40) {
                        script.moments.push(Moment { at_s: from_s + number as f64 * every_s, what });
                    }
                }
                // Full power before it all.
                (3, Some(one)) => {
                    let at_s = (script.moments[one].at_s - between(rng, 0.0, 2.0)).max(0.0);
                    script.moments.push(Moment { at_s, what: Happening::Ask(Wish::Duty(1.0)) });
                }
                (4, Some(one)) => drop(script.moments.remove(one)),
                (5, Some(one)) => script.moments[one].at_s = between(rng, 0.0, seconds),
                (6, Some(one)) => script.moments[one].what = any(rng),
                _ => script.is_eager = !script.is_eager,
            }
        }
        script.moments.retain(|moment| moment.at_s <= seconds);
        script.sort();
        script
    }
}

fn any(rng: &mut Xoshiro256PlusPlus) -> Happening {
    match whole(rng, 0, 6) {
        0 => breaks(rng),
        1 => draught(rng),
        2 => kill(rng, 0.5),
        3 | 4 => stall(rng),
        _ => asks(rng),
    }
}

fn breaks(rng: &mut Xoshiro256PlusPlus) -> Happening {
    Happening::Break(BREAKS[rng.random_range(0..BREAKS.len())], between(rng, 0.01, 3.0))
}

fn draught(rng: &mut Xoshiro256PlusPlus) -> Happening {
    Happening::Draught(if rng.random::<bool>() { between(rng, 0.0, 1.0) } else { 0.0 })
}

fn kill(rng: &mut Xoshiro256PlusPlus, forgetful: f64) -> Happening {
    let pause_s = match whole(rng, 0, 9) {
        0..=4 => between(rng, 0.0, 0.3),
        5..=8 => between(rng, 0.0, 10.0),
        _ => between(rng, 0.0, 60.0),
    };
    Happening::Kill { pause_s, remembers: rng.random::<f64>() > forgetful, other: rng.random_range(0..4) == 0 }
}

fn stall(rng: &mut Xoshiro256PlusPlus) -> Happening {
    let longest_s = if rng.random_range(0..10) == 0 { 5.0 } else { 0.249 };
    Happening::Stall(between(rng, 0.001, longest_s))
}

fn asks(rng: &mut Xoshiro256PlusPlus) -> Happening {
    Happening::Ask(match whole(rng, 0, 5) {
        0 => Wish::Off,
        1 => Wish::Stroke(between(rng, 0.0, 1.0)),
        2 => Wish::Stroke(1.0),
        3 => Wish::Duty(between(rng, 0.0, 1.0)),
        _ => Wish::Duty(1.0),
    })
}
