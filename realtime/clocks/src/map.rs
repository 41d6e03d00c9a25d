//! Another device's clock, learnt from pairs of times.
//!
//! What is sought is the driver's time less the other's, `y(s)`, at any time `s` of the other. Each pair bounds it: a bracket from both
//! sides, a stamp that was received some time later from above alone. Between pairs only two things are assumed, both of them said in
//! [`ClockRules`]: how far the rates of two clocks are apart at the most, and how fast that may change. The answer at `s` is all that
//! no pair forbids: in the plane of `y(s)` and the rate there, each pair cuts off a half, widened by what the rate may change by
//! meanwhile (½·drift·Δs²), and what is left is a polygon. Its middle is the answer and half its height the error.
//!
//! Bounds by half-planes are those of TICSync (Harrison and Newman, ICRA 2011). For stamps that can only be late the line below all of
//! them that is closest on average is that of Moon, Skelly and Towsley (INFOCOM 1999), found over the convex hull by Zhang, Liu and Xia
//! (INFOCOM 2002); what that line is below the truth by is bounded by how the delays above it are distributed, taken for exponential near
//! their least. Choosing in each interval of time the reading that was least delayed is NTP's clock filter (RFC 5905, section 10).

use std::fmt;

use crate::mapped::{Mapped, Span};

/// Pairs that one answer looks at, at the most: the nearest.
const NEAREST: usize = 128;
/// Late stamps that are needed before they say anything.
const FEWEST_LATE: usize = 16;
/// Odds, as a negative logarithm, that the truth is further below the line over late stamps than is said; and that a stamp
/// which is earlier than that by more is one of a clock that has not been set.
const SURE: f64 = 14.0;
const SURE_OF_A_JUMP: f64 = 25.0;
/// First interval of time that only one pair is kept of, ns.
const FINEST_NS: f64 = 1e6;

/// What is assumed of the other clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockRules {
    /// What its rate and the driver's are apart by at the most, ppm. Crystals are within 50 of what they should be; a computer that is being
    /// synchronised adds up to 500.
    pub max_rate_ppm: f64,
    /// What that may change by in a second, ppm/s: temperature mostly. A crystal that warms up does 0.03.
    pub drift_ppm_per_s: f64,
    /// What the other's stamps are rounded to, ns.
    pub resolution_ns: u64,
    /// The least that late stamps are ever delayed by, ns, and what that is off by. Nothing that only comes late can tell: where it is
    /// not given, all answers are too late by just that.
    pub least_delay_ns: u64,
    /// See `least_delay_ns`.
    pub least_delay_error_ns: u64,
    /// Late stamps must cover so much time, s, before they say anything; and those that are all later than ever, for so long and by more
    /// than twice what delays have been, are of a clock that was set back and not merely delayed.
    pub settle_s: f64,
    /// Pairs older than this are forgotten, s.
    pub window_s: f64,
    /// Pairs that are kept at the most; with more of them, one for each of so many intervals of the window.
    pub pairs: usize,
}

impl Default for ClockRules {
    fn default() -> ClockRules {
        ClockRules {
            max_rate_ppm: 200.0,
            drift_ppm_per_s: 0.02,
            resolution_ns: 0,
            least_delay_ns: 0,
            least_delay_error_ns: 0,
            settle_s: 2.0,
            window_s: 120.0,
            pairs: NEAREST,
        }
    }
}

/// Why a map has begun anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anew {
    /// The other clock went back to an earlier time, by so much, ns: it was reset or set.
    WentBack {
        /// How far, ns.
        by_ns: u64,
    },
    /// It jumped, forward where this is positive.
    Jumped {
        /// How far, ns.
        by_ns: i64,
    },
    /// Its pairs contradict each other: its rate changed by more than was assumed.
    Unsteady,
}

impl fmt::Display for Anew {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Anew::WentBack { by_ns } => {
                write!(f, "the other clock was reset: it shows {} less than before", Span(by_ns))
            }
            Anew::Jumped { by_ns } => {
                let way = if by_ns < 0 { "back" } else { "forward" };
                write!(f, "the other clock jumped {way} by about {}", Span(by_ns.unsigned_abs()))
            }
            Anew::Unsteady => write!(f, "the other clock's rate changed by more than was assumed of it"),
        }
    }
}

/// What came of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Update {
    /// It is kept.
    Kept,
    /// Others beside it say more, or it is out of order.
    Passed,
    /// It contradicts those before: they are forgotten, and it is the first of the new ones.
    Anew(Anew),
}

/// A pair as it is kept: at a time of the other, the driver's time less the other's lies between two bounds. All ns, relative to the first.
#[derive(Debug, Clone, Copy)]
struct Kept {
    at: f64,
    low: f64,
    high: f64,
}

impl Kept {
    fn is_late(&self) -> bool {
        self.low == f64::NEG_INFINITY
    }
}

/// Another device's clock beside the driver's. Adding a pair and asking for a time allocate nothing and take some 30 µs ([`ClockMap::other_at`] 90);
/// nothing in here reads a clock.
#[derive(Debug, Clone)]
pub struct ClockMap {
    rules: ClockRules,
    /// In the order of their times.
    kept: Vec<Kept>,
    /// Time of the first of them, on the other's clock and on the driver's less that.
    origin: Option<(i64, i128)>,
    /// The latest pair, times of the other and the driver.
    latest: (i64, u64),
    /// One pair is kept of each interval of this length, ns.
    interval: f64,
    /// The rate as of the latest pair, to compare late stamps of one interval by.
    rate: f64,
    /// How late stamps have been at the most, ns: known to be delays, for a prompt one has followed; and since the last prompt one.
    longest: f64,
    longest_since: f64,
    /// Why it began anew, and how often.
    anew: Option<Anew>,
    times_anew: u64,
}

impl ClockMap {
    /// One that knows nothing yet.
    pub fn new(rules: ClockRules) -> ClockMap {
        let within = |value: f64, low: f64, high: f64| if value.is_nan() { high } else { value.clamp(low, high) };
        let rules = ClockRules {
            max_rate_ppm: within(rules.max_rate_ppm, 0.001, 100_000.0),
            drift_ppm_per_s: within(rules.drift_ppm_per_s, 0.0, 1000.0),
            settle_s: within(rules.settle_s, 0.0, 1e6),
            window_s: within(rules.window_s, 0.001, 1e9),
            pairs: rules.pairs.clamp(FEWEST_LATE, 1 << 20),
            ..rules
        };
        ClockMap {
            rules,
            kept: Vec::with_capacity(rules.pairs),
            origin: None,
            latest: (0, 0),
            interval: FINEST_NS,
            rate: 0.0,
            longest: 0.0,
            longest_since: 0.0,
            anew: None,
            times_anew: 0,
        }
    }

    /// What is assumed.
    pub fn rules(&self) -> &ClockRules {
        &self.rules
    }

    /// How many pairs it holds.
    pub fn pairs(&self) -> usize {
        self.kept.len()
    }

    /// Why it began anew last, and how often it has.
    pub fn anew(&self) -> (Option<Anew>, u64) {
        (self.anew, self.times_anew)
    }

    /// Adds a time the other clock showed between two times of the driver's: before the other was asked and after its answer came.
    pub fn bracket(&mut self, before_ns: u64, other_ns: i64, after_ns: u64) -> Update {
        let (before_ns, after_ns) = (before_ns.min(after_ns), after_ns.max(before_ns));
        let grain = i128::from(self.rules.resolution_ns);
        let less = |driver_ns: u64| i128::from(driver_ns) - i128::from(other_ns);
        self.add(other_ns, after_ns, Some(less(before_ns) - grain), less(after_ns) + grain)
    }

    /// Adds a pair of times of one moment, of which the driver's is off by `error_ns` at the most.
    pub fn pair(&mut self, driver_ns: u64, other_ns: i64, error_ns: u64) -> Update {
        self.bracket(driver_ns.saturating_sub(error_ns), other_ns, driver_ns.saturating_add(error_ns))
    }

    /// Adds a stamp of the other clock that was received at this time of the driver's: some unknown time later, never earlier. In the
    /// order in which they were received.
    pub fn late(&mut self, received_ns: u64, other_ns: i64) -> Update {
        let surely = self.rules.least_delay_ns.saturating_sub(self.rules.least_delay_error_ns);
        let high = i128::from(received_ns) - i128::from(other_ns) - i128::from(surely);
        self.add(other_ns, received_ns, None, high + i128::from(self.rules.resolution_ns))
    }

    /// Forgets all of it.
    pub fn clear(&mut self) {
        self.kept.clear();
        self.origin = None;
        self.interval = FINEST_NS;
        self.rate = 0.0;
        (self.longest, self.longest_since) = (0.0, 0.0);
    }

    /// The driver's time of a time of the other clock; `None` where that is not known: before enough pairs, and before the first pair
    /// since the other clock was reset.
    pub fn driver_at(&self, other_ns: i64) -> Option<Mapped<u64>> {
        let (_, less) = self.origin?;
        let at = self.at(other_ns)?;
        let found = self.feasible(at, SURE)?;
        self.is_since_it_began(at, &found).then_some(())?;
        let ns = i128::from(other_ns) + less + found.middle().round() as i128;
        Some(Mapped { ns: u64::try_from(ns).ok()?, error_ns: found.error_ns() })
    }

    /// The other's time of a driver's stamp; `None` where that is not known, as in [`ClockMap::driver_at`].
    pub fn other_at(&self, driver_ns: u64) -> Option<Mapped<i64>> {
        let (_, less) = self.origin?;
        let mut other_ns = i128::from(driver_ns) - less - self.kept.last()?.high.round() as i128;
        let mut found = None;
        // The difference changes by the rate's, a thousandth at the most: each round makes what is left a thousandth.
        for _ in 0..3 {
            let at = self.at(i64::try_from(other_ns).ok()?)?;
            let feasible = self.feasible(at, SURE)?;
            other_ns = i128::from(driver_ns) - less - feasible.middle().round() as i128;
            found = Some((at, feasible));
        }
        let (at, found) = found?;
        self.is_since_it_began(at, &found).then_some(())?;
        let error_ns = found.error_ns() as f64 / (1.0 - 1e-6 * self.rules.max_rate_ppm);
        Some(Mapped { ns: i64::try_from(other_ns).ok()?, error_ns: error_ns.ceil() as u64 })
    }

    /// What the other clock runs fast by as of the latest pair, and what that is off by at the most, ppm.
    pub fn rate_ppm(&self) -> Option<(f64, f64)> {
        let found = self.feasible(self.kept.last()?.at, SURE)?;
        let (low, high) = found.rate;
        Some((-0.5e6 * (low + high), 0.5e6 * (high - low)))
    }

    /// A time of the other relative to the first pair.
    fn at(&self, other_ns: i64) -> Option<f64> {
        let (first, _) = self.origin?;
        Some((i128::from(other_ns) - i128::from(first)) as f64)
    }

    /// Whether a time is not before the first pair, where that is the first one after the clock was reset.
    fn is_since_it_began(&self, at: f64, found: &Feasible) -> bool {
        self.times_anew == 0 || at + found.error_ns() as f64 >= 0.0
    }

    fn add(&mut self, other_ns: i64, driver_ns: u64, low: Option<i128>, high: i128) -> Update {
        let Some((first, less)) = self.origin else {
            self.begin(other_ns, driver_ns, low, high);
            return Update::Kept;
        };
        if driver_ns < self.latest.1 {
            return Update::Passed;
        }
        if other_ns < self.latest.0 {
            let anew = Anew::WentBack { by_ns: self.latest.0.abs_diff(other_ns) };
            return self.begin_anew(anew, other_ns, driver_ns, low, high);
        }
        let kept = Kept {
            at: (i128::from(other_ns) - i128::from(first)) as f64,
            low: low.map_or(f64::NEG_INFINITY, |low| (low - less) as f64),
            high: (high - less) as f64,
        };
        match self.contradicts(&kept) {
            Some(anew) => self.begin_anew(anew, other_ns, driver_ns, low, high),
            None => {
                self.latest = (other_ns, driver_ns);
                self.keep(kept)
            }
        }
    }

    fn begin(&mut self, other_ns: i64, driver_ns: u64, low: Option<i128>, high: i128) {
        self.clear();
        self.origin = Some((other_ns, high));
        self.latest = (other_ns, driver_ns);
        let low = low.map_or(f64::NEG_INFINITY, |low| (low - high) as f64);
        self.kept.push(Kept { at: 0.0, low, high: 0.0 });
    }

    fn begin_anew(&mut self, anew: Anew, other_ns: i64, driver_ns: u64, low: Option<i128>, high: i128) -> Update {
        self.begin(other_ns, driver_ns, low, high);
        self.anew = Some(anew);
        self.times_anew += 1;
        Update::Anew(anew)
    }

    /// Whether the clock must have been set for this pair to be.
    fn contradicts(&mut self, new: &Kept) -> Option<Anew> {
        let jumped = |by: f64| Some(Anew::Jumped { by_ns: -by.round() as i64 });
        let found = match self.seek(new.at, SURE_OF_A_JUMP) {
            Found::Nothing { high } => return (new.low > high).then(|| jumped(new.low - high)).flatten(),
            // What was kept of late stamps contradicts itself: all of the latest ones are later than ever.
            Found::Contradiction { by } if by > 0.0 => return jumped(by),
            Found::Contradiction { .. } => return Some(Anew::Unsteady),
            Found::Feasible(found) => found,
        };
        self.rate = 0.5 * (found.rate.0 + found.rate.1);
        if new.is_late() {
            self.note_delay(new, &found);
        }
        let early = found.low - new.high;
        // One that is earlier than ever after late ones tells as well that all of those were delayed.
        if early > 0.0 && !(new.is_late() && self.may_be_delay(early)) {
            return jumped(-early);
        }
        // a late stamp is never too late
        (new.low > found.high).then(|| jumped(new.low - found.high)).flatten()
    }

    /// Takes note of how late a stamp is.
    fn note_delay(&mut self, new: &Kept, found: &Feasible) {
        let passed_s = 1e-9 * (new.at - self.kept.last().map_or(new.at, |last| last.at));
        self.longest *= (-passed_s / self.rules.window_s).exp();
        let delay = new.high - found.high;
        if delay > found.high - found.low {
            self.longest_since = self.longest_since.max(delay);
        } else {
            self.longest = self.longest.max(self.longest_since);
            self.longest_since = 0.0;
        }
    }

    /// Whether stamps may be so much later than others because they were delayed, ns: so they have been before.
    fn may_be_delay(&self, by: f64) -> bool {
        by <= 2.0 * self.longest
    }

    /// Keeps a pair, one of each kind and interval of time: that with the narrower bounds, or that which was less late.
    fn keep(&mut self, new: Kept) -> Update {
        let rival = rival(&self.kept, &new, self.interval);
        if rival.is_some_and(|at| !better(&new, &self.kept[at], self.rate)) {
            return Update::Passed;
        }
        if let Some(at) = rival {
            self.kept.remove(at);
        }
        while self.kept.len() >= self.rules.pairs {
            let span = new.at - self.kept[0].at;
            if span >= 1e9 * self.rules.window_s {
                self.kept.remove(0);
            } else {
                // Ends where the interval is as long as the span: then there are four at the most.
                self.interval *= 2.0;
                self.coarsen();
            }
        }
        self.kept.push(new);
        Update::Kept
    }

    fn coarsen(&mut self) {
        let mut count = 0;
        for next in 0..self.kept.len() {
            let new = self.kept[next];
            let rival = rival(&self.kept[..count], &new, self.interval);
            if rival.is_some_and(|at| !better(&new, &self.kept[at], self.rate)) {
                continue;
            }
            if let Some(at) = rival {
                self.kept.copy_within(at + 1..count, at);
                count -= 1;
            }
            self.kept[count] = new;
            count += 1;
        }
        self.kept.truncate(count);
    }

    /// All that is possible at a time of the other.
    fn feasible(&self, at: f64, sure: f64) -> Option<Feasible> {
        match self.seek(at, sure) {
            Found::Feasible(feasible) => Some(feasible),
            Found::Nothing { .. } | Found::Contradiction { .. } => None,
        }
    }

    fn seek(&self, at: f64, sure: f64) -> Found {
        let near = nearest(&self.kept, at, NEAREST);
        let limit = 1e-6 * self.rules.max_rate_ppm;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for pair in near {
            let slack = self.slack(pair.at - at) + limit * (pair.at - at).abs();
            low = low.max(pair.low - slack);
            high = high.min(pair.high + slack);
        }
        if near.is_empty() {
            return Found::Nothing { high };
        }
        // Only where nothing bounds it from below do the delays of late stamps.
        let mut lines = [Below::default(); 4];
        let mut count = 0;
        if low == f64::NEG_INFINITY {
            for many in [16, 32, 64, 128] {
                let some = nearest(&self.kept, at, many);
                if some.len() < FEWEST_LATE || span_s(some) < self.rules.settle_s {
                    continue;
                }
                let line = self.below(some, at, sure);
                let least = line.value - limit * line.away.abs();
                // All of these are later than others: delayed together, if no more than others were.
                if least <= high || !self.may_be_delay(least - high) {
                    lines[count] = line;
                    count += 1;
                    low = low.max(least);
                }
                if some.len() < many {
                    break;
                }
            }
        }
        if count == 0 && low == f64::NEG_INFINITY {
            return Found::Nothing { high };
        }
        if low > high {
            return Found::Contradiction { by: low - high };
        }
        let mut shape = Shape::rectangle((low, high), (-limit, limit));
        for pair in near {
            let away = pair.at - at;
            let slack = self.slack(away);
            shape.cut(1.0, away, pair.high + slack);
            if !pair.is_late() {
                shape.cut(-1.0, -away, slack - pair.low);
            }
        }
        for line in &lines[..count] {
            shape.cut(-1.0, -line.away, -line.value);
        }
        match shape.extent() {
            Some(feasible) => Found::Feasible(feasible),
            None => Found::Contradiction { by: 0.0 },
        }
    }

    /// What the rate may have changed the difference by over so much time, ns, and half of one for what is rounded.
    fn slack(&self, away: f64) -> f64 {
        0.5 + 0.5e-15 * self.rules.drift_ppm_per_s * away * away
    }

    /// The line below late stamps that is closest to them on average, at their middle, and lower by what it may be above the truth by.
    fn below(&self, late: &[Kept], at: f64, sure: f64) -> Below {
        let count = late.len() as f64;
        let middle = late.iter().map(|pair| pair.at).sum::<f64>() / count;
        let slack = |pair: &Kept| self.slack(pair.at - at);
        let least = |rate: f64| {
            late.iter().map(|pair| pair.high - slack(pair) - rate * (pair.at - middle)).fold(f64::INFINITY, f64::min)
        };
        // concave in the rate: golden section; what it misses by makes the line lower, which is the safe side
        let limit = 1e-6 * self.rules.max_rate_ppm;
        let (mut from, mut to) = (-limit, limit);
        const GOLDEN: f64 = 0.618_033_988_749_894_8;
        let (mut a, mut b) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
        let (mut at_a, mut at_b) = (least(a), least(b));
        for _ in 0..36 {
            if at_a > at_b {
                (to, b, at_b) = (b, a, at_a);
                a = to - GOLDEN * (to - from);
                at_a = least(a);
            } else {
                (from, a, at_a) = (a, b, at_b);
                b = from + GOLDEN * (to - from);
                at_b = least(b);
            }
        }
        let (rate, value) = if at_a > at_b { (a, at_a) } else { (b, at_b) };
        // How late they are beside it. A few that are very late say nothing of the least: the median bounds the mean.
        let mut delays = [0.0; NEAREST];
        let delays = &mut delays[..late.len()];
        for (delay, pair) in delays.iter_mut().zip(late) {
            *delay = pair.high + slack(pair) - rate * (pair.at - middle) - value;
        }
        let mean = delays.iter().sum::<f64>() / count;
        // Where hardly any come close to the least, the least of a part of them is further from
        // that of all: twice so far that of all may be from the least there is.
        let part = late.len() / FEWEST_LATE;
        let parts = delays.chunks_exact(part).map(|part| part.iter().copied().fold(f64::INFINITY, f64::min));
        let of_a_part = parts.sum::<f64>() / (late.len() / part) as f64;
        let (_, median, _) = delays.select_nth_unstable_by(late.len() / 2, f64::total_cmp);
        let typical = mean.min(2.0 * *median);
        let margin = typical * (((sure / (count - 2.0)).exp() - 1.0) * (count - 2.0) / count);
        let margin = margin.max(sure / 7.0 * of_a_part);
        let known =
            2.0 * (self.rules.least_delay_error_ns.min(self.rules.least_delay_ns) + self.rules.resolution_ns) as f64;
        Below { away: middle - at, value: value - margin - known }
    }
}

/// That of the latest two of its kind in the same interval of time: of each kind there is one.
fn rival(kept: &[Kept], new: &Kept, interval: f64) -> Option<usize> {
    let is_one =
        |old: &Kept| (old.at / interval).floor() == (new.at / interval).floor() && old.is_late() == new.is_late();
    (kept.len().saturating_sub(2)..kept.len()).rev().find(|&at| is_one(&kept[at]))
}

/// Whether one pair says more than another one close to it.
fn better(new: &Kept, old: &Kept, rate: f64) -> bool {
    if new.is_late() { new.high - old.high < rate * (new.at - old.at) } else { new.high - new.low < old.high - old.low }
}

/// So many of them that are nearest to a time, at the most.
fn nearest(kept: &[Kept], at: f64, many: usize) -> &[Kept] {
    if kept.len() <= many {
        return kept;
    }
    let here = kept.partition_point(|pair| pair.at < at);
    let from = here.saturating_sub(many / 2).min(kept.len() - many);
    &kept[from..from + many]
}

fn span_s(kept: &[Kept]) -> f64 {
    match kept {
        [first, .., last] => 1e-9 * (last.at - first.at),
        _ => 0.0,
    }
}

/// A line that the truth is above of: its value so far away, ns.
#[derive(Debug, Clone, Copy, Default)]
struct Below {
    away: f64,
    value: f64,
}

enum Found {
    /// It is not bounded from below.
    Nothing {
        high: f64,
    },
    /// It would have to be above one pair by so much to be below another.
    Contradiction {
        by: f64,
    },
    Feasible(Feasible),
}

/// What is possible: the difference at a time, ns, and its rate there.
#[derive(Debug, Clone, Copy)]
struct Feasible {
    low: f64,
    high: f64,
    rate: (f64, f64),
}

impl Feasible {
    fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    fn error_ns(&self) -> u64 {
        (0.5 * (self.high - self.low)).ceil() as u64
    }
}

/// Most corners of a [`Shape`]; what would give it more is left out, which leaves it larger.
const CORNERS: usize = 64;

/// A convex polygon in the plane of difference and rate.
struct Shape {
    corners: [(f64, f64); CORNERS],
    count: usize,
}

impl Shape {
    fn rectangle(difference: (f64, f64), rate: (f64, f64)) -> Shape {
        let mut corners = [(0.0, 0.0); CORNERS];
        corners[0] = (difference.0, rate.0);
        corners[1] = (difference.1, rate.0);
        corners[2] = (difference.1, rate.1);
        corners[3] = (difference.0, rate.1);
        Shape { corners, count: 4 }
    }

    /// Cuts off where `a`·difference + `b`·rate is more than `most`.
    fn cut(&mut self, a: f64, b: f64, most: f64) {
        let beyond = |(difference, rate): (f64, f64)| a * difference + b * rate - most;
        if self.count == 0 || self.corners[..self.count].iter().all(|corner| beyond(*corner) <= 0.0) {
            return;
        }
        let mut left = [(0.0, 0.0); CORNERS];
        let mut count = 0;
        let mut put = |corner| {
            if count < CORNERS {
                left[count] = corner;
            }
            count += 1;
        };
        for i in 0..self.count {
            let (here, next) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (d_here, d_next) = (beyond(here), beyond(next));
            if d_here <= 0.0 {
                put(here);
            }
            if (d_here < 0.0 && d_next > 0.0) || (d_here > 0.0 && d_next < 0.0) {
                let share = d_here / (d_here - d_next);
                put((here.0 + share * (next.0 - here.0), here.1 + share * (next.1 - here.1)));
            }
        }
        if count <= CORNERS {
            (self.corners, self.count) = (left, count);
        }
    }

    /// Its extent; `None` where nothing is left.
    fn extent(&self) -> Option<Feasible> {
        let (first, rest) = self.corners[..self.count].split_first()?;
        let start = Feasible { low: first.0, high: first.0, rate: (first.1, first.1) };
        Some(rest.iter().fold(start, |all, &(difference, rate)| Feasible {
            low: all.low.min(difference),
            high: all.high.max(difference),
            rate: (all.rate.0.min(rate), all.rate.1.max(rate)),
        }))
    }
}

#[cfg(test)]
mod tests;
