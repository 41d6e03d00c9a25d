//! Sliding mode control of a wire (chapter 11) on the second-order surface.
//!
//! The thesis' law takes ẍ from the length, differentiated twice; at the accuracy of one reading in a hundred of the
//! stroke that is all noise. [`Law::Equivalent`] takes it from the wire instead: where the load is damped, the speed of a
//! transforming wire is its excess temperature over the curve it is on, v = −(T − T_b(x))/κ with κ = B/(αA_c) (the stress shift
//! of the drag, eq. 12 and 51), and so the surface σ = ẍ + 2λẋ + λ²(x − x_ref) is one in temperature:
//! σ = (2λ/κ)(T_b(x) + κ(λ/2)(x − x_ref) − T) up to the slow drift of T_b. The power that keeps σ = 0 follows from the heat
//! balance as in eq. 70, and is what a switch between maximum and minimum power is modulated to.
//!
//! Three things of the wire that the surface does not know are dealt with apart:
//! - Crossing the hysteresis moves the wire the wrong way by its thermal strain. So a wire within a band around the
//!   reference is held at the temperature it has, and left there until its mean error says otherwise.
//! - A wire that lengthens is slow to move and quick to stop: it approaches [`COOLING_HASTE`] times as steeply.
//! - The last correction out of a hold is crept at.

use crate::demand::Range;
use crate::wire_map::WireMap;
use crate::{Controller, Demand};

/// How much steeper a cooling wire approaches: heating brakes it with several times the power that cools it.
pub const COOLING_HASTE: f64 = 3.5;
/// Time over which the error of a held wire is averaged, in 1/λ.
const AVERAGE: f64 = 4.0;
/// A hold lasts this long before its mean error is judged, in 1/λ.
const AT_LEAST: f64 = 1.5;
/// What the first error of a hold is worth as averaging time, in 1/λ.
const FIRST: f64 = 0.3;
/// Where a hold begins for a wire that comes from being too long, and from too short, in hold bands.
const ARRIVE: (f64, f64) = (1.0, 0.8);
/// Mean error at which a hold ends if the wire can be moved along the curve it stands near, in hold bands.
const LEAVE_ALONG: f64 = 1.7;
/// The same if it has to cross the hysteresis.
const LEAVE_ACROSS: f64 = 2.2;
/// Error at which a hold ends at once, in hold bands.
const LEAVE_AT_ONCE: f64 = 4.0;
/// How far off the heating and the cooling curve a held wire's temperature is kept, in widths 1/k of the curve.
const RETREAT: (f64, f64) = (1.35, 0.8);
/// Within this of its curve, in widths, and within [`LEAVE_AT_ONCE`] of the reference, a wire is crept at.
const CREEP_WITHIN: f64 = 0.6;
/// Rate of creeping, in widths times λ.
const CREEP: f64 = 0.06;
/// Least rate, as a share of that, of a wire that does not move as it should: the integral action of this law.
const CREEP_AT_LEAST: f64 = 0.5;
/// Share of the believed loss that is made up for on the way: what is missing lets a wire arrive slowly, not run past.
const MADE_UP: f64 = 0.975;

/// How σ becomes power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// The thesis' law as it stands: maximum power where the measured σ > 0, minimum elsewhere.
    Plain,
    /// With the equivalent control that keeps σ = 0 (eq. 70), in the wire's estimated state.
    Equivalent,
}

/// A wire left standing near its reference.
#[derive(Debug, Clone, Copy)]
struct Hold {
    on: bool,
    /// Mean error since the hold began, m.
    error: f64,
    /// How long that is averaged over, s.
    time: f64,
    /// Whether the wire comes, or came, from being too long.
    from_long: bool,
    reference: f64,
}

impl Hold {
    const NONE: Hold = Hold { on: false, error: 0.0, time: 0.0, from_long: true, reference: f64::NAN };
}

/// Critically damped second-order surface σ = ẍ + 2λẋ + λ²(x − x_ref).
#[derive(Debug, Clone)]
pub struct SlidingMode2 {
    map: WireMap,
    lambda: f64,
    law: Law,
    range: Range,
    /// Half width of the hold band, m.
    band: f64,
    /// 1/κ at mid-stroke, m/(K s): from a rate of temperature to σ.
    per_kelvin: f64,
    hold: Hold,
    surface: f64,
    blind: bool,
}

impl SlidingMode2 {
    pub(crate) fn new(map: WireMap, lambda: f64, law: Law, band: f64, range: Range) -> SlidingMode2 {
        let lead = 0.5 * map.kelvin_per_metre(0.5, map.heating_width, map.stress(0.0, 0.0));
        let per_kelvin = 1.0 / (map.drag + lead / lambda).max(1e-12);
        SlidingMode2 { map, lambda, law, range, band, per_kelvin, hold: Hold::NONE, surface: 0.0, blind: false }
    }

    /// λ, in 1/s.
    pub fn lambda_per_s(&self) -> f64 {
        self.lambda
    }

    /// Whether the wire is being held where it stands, within the band around its reference.
    pub fn is_holding(&self) -> bool {
        self.hold.on
    }

    /// Begins, goes on with or ends holding the wire.
    #[inline]
    fn decide_hold(&mut self, demand: &Demand, error: f64) {
        let (band, seen, hold) = (self.band, &demand.estimate, &mut self.hold);
        if hold.reference != demand.reference_m {
            // a reference that creeps does not end a hold by itself
            let moved = hold.error + hold.reference - demand.reference_m;
            hold.reference = demand.reference_m;
            if hold.on && moved.abs() <= LEAVE_AT_ONCE * band {
                hold.error = moved;
            } else {
                (hold.on, hold.from_long) = (false, error > 0.0);
            }
        }
        if hold.on {
            hold.time += demand.dt_s;
            let apart = demand.length_m - demand.reference_m - hold.error;
            hold.error += apart * (demand.dt_s / hold.time.min(AVERAGE / self.lambda)).min(1.0);
            let near_heating = 2.0 * seen.temperature_c > seen.heating_curve_c + seen.cooling_curve_c;
            let along = if near_heating { hold.error } else { -hold.error };
            let judged = hold.time * self.lambda > AT_LEAST;
            let off = judged && (along > LEAVE_ALONG * band || along < -LEAVE_ACROSS * band);
            if off || error.abs() > LEAVE_AT_ONCE * band {
                hold.on = false;
                hold.from_long = if off { hold.error > 0.0 } else { error > 0.0 };
            }
        } else {
            if error.abs() > LEAVE_AT_ONCE * band {
                hold.from_long = error > 0.0;
            }
            let (ahead, arrive) = if hold.from_long { (error, ARRIVE.0) } else { (-error, ARRIVE.1) };
            if ahead <= arrive * band {
                (hold.on, hold.error, hold.time) = (true, error, FIRST / self.lambda);
            }
        }
    }

    /// Equivalent control: the mean duty that keeps σ = 0.
    #[inline]
    fn equivalent(&mut self, demand: &Demand) -> f64 {
        let seen = &demand.estimate;
        let error = seen.length_m - demand.reference_m;
        self.decide_hold(demand, error);
        let (m, lambda) = (&self.map, self.lambda);
        // the curves where the wire stands still: without the drag's share of the stress
        let drag_k = m.stress(seen.length_m - m.length, 0.0) * m.shift - seen.stress_pa * m.shift;
        let (heating, cooling) = (seen.heating_curve_c + drag_k, seen.cooling_curve_c + drag_k);
        let drag = m.drag;
        let (target, width) = if self.hold.on {
            let low = cooling + RETREAT.1 * m.cooling_width;
            let high = heating - RETREAT.0 * m.heating_width;
            (seen.temperature_c.min(high).max(low), m.heating_width)
        } else {
            let (curve, width, haste) = if error > 0.0 {
                (heating, m.heating_width, lambda)
            } else {
                (cooling, m.cooling_width, COOLING_HASTE * lambda)
            };
            // besides the drag, the lead that keeps a load without any from following too closely
            let s = seen.stress_pa + m.thermoelastic * (seen.temperature_c - m.reference);
            let lead = 0.5 * m.kelvin_per_metre(seen.martensite, width, s);
            (curve + 0.5 * (haste * drag + lead) * error, width)
        };
        let mut rate = 2.0 * lambda * (target - seen.temperature_c);
        let mut transforming = 0.0;
        if !self.hold.on {
            let xi = seen.martensite.clamp(0.03, 0.97);
            transforming = xi * (1.0 - xi) / width * m.release(seen.stress_pa);
            if error.abs() < LEAVE_AT_ONCE * self.band {
                let (creep, within) = (CREEP * lambda * width, CREEP_WITHIN * width);
                let towards = if error > 0.0 { -seen.velocity_m_s } else { seen.velocity_m_s };
                // slower than half of what the surface asks: the curve is not where it is believed to be
                let least =
                    if towards < 0.25 * lambda * error.abs() { CREEP_AT_LEAST * creep } else { f64::NEG_INFINITY };
                if error > 0.0 {
                    let most = creep + 2.0 * lambda * (heating - within - seen.temperature_c).max(0.0);
                    rate = rate.max(least).min(most);
                } else {
                    let most = creep + 2.0 * lambda * (seen.temperature_c - cooling - within).max(0.0);
                    rate = rate.min(-least).max(-most);
                }
            }
        }
        self.surface = rate * self.per_kelvin;
        let share = if self.hold.on { 1.0 } else { MADE_UP };
        (share * seen.loss_w + (m.heat_capacity + transforming) * rate) / seen.full_power_w
    }
}

impl Controller for SlidingMode2 {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> f64 {
        self.blind = !demand.is_usable();
        if self.blind {
            self.surface = 0.0;
            return self.range.minimum;
        }
        if self.law == Law::Equivalent && demand.estimate.temperature_c.is_finite() {
            let wanted = self.equivalent(demand);
            return self.range.give(wanted);
        }
        let error = demand.length_m - demand.reference_m;
        self.surface = demand.acceleration_m_s2 + self.lambda * (2.0 * demand.velocity_m_s + self.lambda * error);
        self.range.switch(self.surface)
    }

    fn reset(&mut self) {
        self.range.reset();
        self.hold = Hold::NONE;
        self.surface = 0.0;
        self.blind = false;
    }

    fn surface(&self) -> f64 {
        self.surface
    }

    fn is_blind(&self) -> bool {
        self.blind
    }
}
