//! The inputs of a cycle common to all estimators.

use crate::estimate::Observation;
use crate::wire_map::WireMap;
use sinew_physics::WireModel;

/// Coldest temperature an estimate can take, °C.
pub(crate) const COLDEST_C: f64 = -250.0;
/// Hottest temperature an estimate can take, °C.
pub(crate) const HOTTEST_C: f64 = 1000.0;
/// More stress than a wire bears, Pa.
const MOST_PA: f64 = 5e9;
/// Duty from which on a power says what a duty of 1 would give.
const LEAST_DUTY: f64 = 1e-3;
/// Share of its loss to the air that a wire surely has.
const SURE_LOSS: f64 = 0.5;

/// Shorter than that no time has passed, s.
pub(crate) const SHORTEST_STEP_S: f64 = 1e-9;
/// A gap is gone through in steps no longer than that, s: short beside what any wire takes to heat or to cool, longer than a period.
const LONGEST_STEP_S: f64 = 0.025;
/// Longer than that no gap is computed, s: every wire has come to where its power takes it.
const LONGEST_GAP_S: f64 = 120.0;

/// Time that has passed since the cycle before, s; none where that is unknown.
#[inline]
fn elapsed_s(dt_s: f64) -> f64 {
    if dt_s > SHORTEST_STEP_S { dt_s.min(LONGEST_GAP_S) } else { 0.0 }
}

/// Takes a cycle in, the whole time since the one before: where that was a gap, in steps, of which only the last sees what was measured
/// at its end. `step` is given what was seen and how long it took, s.
#[inline]
pub(crate) fn in_steps<const N: usize, T>(
    seen: [&Observation; N],
    mut step: impl FnMut([&Observation; N], f64) -> T,
) -> T {
    let elapsed_s = elapsed_s(seen.first().map_or(0.0, |seen| seen.dt_s));
    if elapsed_s <= LONGEST_STEP_S {
        return step(seen, elapsed_s);
    }
    let steps = (elapsed_s / LONGEST_STEP_S).ceil();
    let dt_s = elapsed_s / steps;
    let within = seen.map(|seen| Observation {
        power_w: seen.power_w,
        tension_n: seen.tension_n,
        ..Observation::nothing(seen.duty, dt_s)
    });
    for _ in 1..steps as usize {
        step(within.each_ref(), dt_s);
    }
    step(seen, dt_s)
}

/// The state a wire starts in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Start {
    pub temperature_c: f64,
    pub martensite: f64,
}

impl Start {
    /// As the model says: at its initial temperature (ambient) and phase.
    pub fn of(model: &WireModel) -> Start {
        Start {
            temperature_c: model.initial.temperature_c.unwrap_or(model.ambient_c),
            martensite: model.initial.martensite,
        }
    }
}

/// Temperatures of the two outer curves of the hysteresis, °C.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Curves {
    pub heating_c: f64,
    pub cooling_c: f64,
}

impl Curves {
    /// At a phase and stress (eq. 20 inverted, shifted by eq. 12).
    #[inline]
    pub fn at(m: &WireMap, martensite: f64, stress_pa: f64) -> Curves {
        let (logit, shift) = (WireMap::logit(martensite), stress_pa * m.shift);
        Curves {
            heating_c: m.heating_centre + m.heating_width * logit + shift,
            cooling_c: m.cooling_centre + m.cooling_width * logit + shift,
        }
    }
}

/// Mean power of the cycle, W: as measured, else what the duty gives of the power at duty 1, else the most there is.
#[inline]
pub(crate) fn power(m: &WireMap, seen: &Observation, at_full_duty: impl FnOnce() -> f64) -> f64 {
    if seen.power_w.is_finite() {
        seen.power_w.clamp(0.0, 100.0 * m.full_power + 100.0)
    } else if seen.duty.is_finite() {
        seen.duty.clamp(0.0, 1.0) * at_full_duty()
    } else {
        m.full_power
    }
}

/// Power at duty 1, W, as the cycle's `power` says it; `before` where nothing was given.
#[inline]
pub(crate) fn full_power(m: &WireMap, seen: &Observation, power: f64, before: f64) -> f64 {
    if seen.duty > LEAST_DUTY && seen.duty <= 1.0 {
        // a supply that has gone is no reason to ask for a thousandfold duty when it comes back
        (power / seen.duty).clamp(0.2 * m.full_power, 5.0 * m.full_power)
    } else {
        before
    }
}

/// Stress in the wire, Pa: by the measured tension, else by the load (eq. 51).
#[inline]
pub(crate) fn stress(m: &WireMap, seen: &Observation, elongation: f64, velocity: f64) -> f64 {
    if seen.tension_n.is_finite() {
        (seen.tension_n * m.per_area).clamp(0.0, MOST_PA)
    } else {
        m.stress(elongation, velocity)
    }
}

/// The temperature the wire cannot be above, °C, after `dt` under this power: half the loss to the air, no latent heat, never
/// below the estimated temperature.
#[inline]
pub(crate) fn hottest(m: &WireMap, before: f64, power: f64, dt: f64, temperature: f64) -> f64 {
    let rise = power - SURE_LOSS * m.loss * (before - m.ambient);
    (before + rise * dt * m.per_heat_capacity).min(HOTTEST_C).max(temperature)
}

/// How far a phase is inside its range at this end: 0 where it is indistinguishable from the end, 1 a few per cent in.
#[inline]
pub(crate) fn inside(fraction: f64) -> f64 {
    (25.0 * (fraction - 0.03)).clamp(0.0, 1.0)
}
