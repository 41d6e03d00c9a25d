//! Which way round a position is, by what heat does: it shortens a wire. And where its zero is.

use sinew_recording::Column;

use crate::bench::Bench;
use crate::reading::{Reading, figure};
use crate::statistics::{correlation, delayed, quantiles};

/// Time constants of heating and cooling that are tried, s.
const CONSTANTS_S: [f64; 10] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// How well heat and position have to go together for a direction to be seen.
const SEEN: f64 = 0.6;

/// What heats the wire, over time.
pub(crate) struct Heat<'a> {
    /// What it is called.
    pub by: &'a str,
    pub time_s: &'a [f64],
    pub values: Vec<f64>,
    /// A temperature acts at once, power does after a while.
    pub at_once: bool,
}

impl Heat<'_> {
    /// How a column goes with it, r from −1 to 1; the delay is the one with which it goes best.
    fn goes_with(&self, values: &[f64]) -> f64 {
        let mut best = correlation(&self.values, values);
        if self.at_once {
            return best;
        }
        let lasts_s = self.time_s.last().zip(self.time_s.first()).map_or(0.0, |(last, first)| last - first);
        for constant_s in CONSTANTS_S.into_iter().filter(|c| *c < 0.3 * lasts_s) {
            let r = correlation(&delayed(self.time_s, &self.values, constant_s), values);
            if r.abs() > best.abs() {
                best = r;
            }
        }
        best
    }
}

/// Proposes direction and zero of a position, and says why; `shortening`: its name says that it counts shortening.
pub(crate) fn position(
    reading: &mut Reading,
    raw: &[f64],
    heat: Option<&Heat<'_>>,
    bench: Option<&Bench>,
    shortening: bool,
) {
    let values = reading.values(raw);
    let [low, high] = quantiles(&values, [0.01, 0.99]);
    let moved = high - low;
    if moved.is_nan() || moved <= 0.0 {
        return reading.doubt("does not move");
    }
    let absolute = bench.is_some_and(|b| low > 0.7 * b.length_m && high < 1.3 * b.length_m && moved < 0.2 * b.length_m);
    let r = heat.map(|heat| heat.goes_with(&values));
    let by = heat.map_or("", |heat| heat.by);
    let imposed = bench.is_some_and(|bench| bench.imposed == Some(Column::PositionM));
    let turned = match r {
        _ if imposed => {
            reading.because("the rig file imposes it: heat says nothing of its direction");
            shortening
        }
        Some(r) if r > SEEN && !absolute => {
            reading.because(format!(
                "goes up by {} mm as {by} heats (r = {r:.2}), and heat shortens a wire",
                figure(moved * 1e3)
            ));
            true
        }
        Some(r) if r < -SEEN => {
            reading.because(format!(
                "goes down by {} mm as {by} heats (r = {r:.2}): longer is positive",
                figure(moved * 1e3)
            ));
            if shortening {
                reading.doubt("its name says shortening, but it goes down with heat: left as it is");
            }
            false
        }
        Some(r) => {
            reading
                .doubt(format!("does not go with {by} (r = {r:.2}): its direction is not seen{}", taken(shortening)));
            shortening
        }
        None => {
            reading.doubt(format!("nothing that heats is known: its direction is not seen{}", taken(shortening)));
            shortening
        }
    };
    if turned {
        reading.turn_round("longer");
    }
    zero(reading, raw, absolute, turned, moved, bench);
}

fn taken(shortening: bool) -> &'static str {
    if shortening { ", turned round by its name" } else { ", longer is taken as positive" }
}

fn zero(reading: &mut Reading, raw: &[f64], absolute: bool, turned: bool, moved: f64, bench: Option<&Bench>) {
    const FREE: &str = "[channel.sensors] position_zero = \"free\" in the rig file";
    let Some(bench) = bench else {
        return reading.doubt("whether its zero is the wire's length L_0 cannot be seen without --rig");
    };
    if absolute {
        reading.offset -= bench.length_m;
        return reading
            .because(format!("lies around the wire's length: less L_0 = {} m of the rig file", bench.length_m));
    }
    if bench.free_zero {
        return;
    }
    let values = reading.values(raw);
    let [low, high] = quantiles(&values, [0.01, 0.99]);
    let first = values.iter().copied().find(|v| v.is_finite()).unwrap_or(0.0);
    let length_m = bench.length_m;
    if low < -0.002 * length_m || high > 0.12 * length_m {
        let at = if first.abs() < 0.1 * moved { ", as one set to 0 when cold" } else { "" };
        reading.doubt(format!(
            "{} to {} mm is no elongation from L_0{at}: its zero is another, so set {FREE}",
            figure(low * 1e3),
            figure(high * 1e3)
        ));
    } else if turned {
        reading.doubt(format!("turned round its zero is hardly L_0: set {FREE} unless it is"));
    }
}

/// The sign of a tension: a wire pulls.
pub(crate) fn force(reading: &mut Reading, raw: &[f64]) {
    let values = reading.values(raw);
    let [low, middle, high] = quantiles(&values, [0.02, 0.5, 0.98]);
    if middle < 0.0 && high < 0.2 * low.abs() {
        reading.because(format!("is {} to {} N, and a wire pulls, never pushes", figure(low), figure(high)));
        reading.turn_round("tension");
    } else if low < -0.05 * high.abs() {
        reading.doubt(format!("goes down to {} N, and a wire cannot push: is its zero right?", figure(low)));
    }
}
