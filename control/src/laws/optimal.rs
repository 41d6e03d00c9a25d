//! Time-optimal control to a reference: full power or none for as long as the wire can still be stopped, and then
//! along the fastest trajectory that stops there.
//!
//! A sliding mode whose surface is not a straight line but the stopping distance. Where the load is damped, a transforming
//! wire moves by its excess temperature e over the curve it is on, ẋ = −e/κ (eq. 12, 51), and the excess obeys the heat balance
//! (eq. 48): ė = (P − P_loss)/C − e/τ, with τ = κ/(g + H/(C ∂x/∂ξ)) the time in which latent heat and the curve's own slope g
//! use an excess up. From here a wire that is no longer pushed goes on by
//!
//!   Δx(e) = (τ/κ) (e − b ln(1 + e/b)),   b = τ P_brake/C,
//!
//! where what brakes a shortening wire is the air, and what brakes a lengthening one is the supply. So the largest excess
//! from which it still stops at the reference is the inverse of Δx, and that is the surface: below it the power is full (or the wire
//! cools freely), on it the equivalent control (eq. 70) brakes with [`RESERVE_SHORTENING`] or [`RESERVE_LENGTHENING`] of what there is, so that there is something left for what the model
//! does not know. Near the reference the temperature is held as in [`super::sliding`].

use super::hold::Hold;
use super::pace::Pace;
use crate::cycle::Curves;
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;

/// Share of the braking power that the surface counts on, of a shortening and of a lengthening wire.
const RESERVE_SHORTENING: f64 = 0.7;
const RESERVE_LENGTHENING: f64 = 0.4;
/// Fastest return to the surface, in 1/s, and in samples.
const RETURN_PER_S: f64 = 120.0;
const RETURN_SAMPLES: f64 = 4.0;

/// How fast the last correction out of a hold approaches its curve: widths per second, and 1/s of what is beyond so many widths.
pub(super) const CREEP_WIDTHS_PER_S: f64 = 1.5;
pub(super) const CREEP_PER_S: f64 = 15.0;
pub(super) const CREEP_BEYOND_WIDTHS: f64 = 1.5;
/// Rate at which a held wire is kept at its temperature, and brought to it from a kelvin off, 1/s: slow, because every ripple of the
/// temperature ratchets it along the curve that it is nearer to.
pub(super) const KEEP_PER_S: f64 = 1.5;
pub(super) const BRING_PER_S: f64 = 8.0;

/// How far below its curve a wire is kept that is ahead of its reference by as much as it may be near it, and at most, in widths.
pub(super) const PAST_WIDTHS: f64 = 2.0;
const MOST_PAST_WIDTHS: f64 = 2.0;

/// Near-time-optimal sliding mode.
#[derive(Debug, Clone)]
pub struct TimeOptimal {
    map: WireMap,
    /// Fastest return to the surface, 1/s.
    fastest: f64,
    lambda: f64,
    range: Range,
    hold: Hold,
    /// The duty of the period under way.
    given: f64,
    /// Excess temperature that is missing to the surface, K; positive = heat.
    surface: f64,
    pace: Pace,
}

/// Half of a wire's hysteresis: the curve it moves on, which way, and what brakes it there.
struct Approach {
    /// Error that is left, m; positive.
    ahead: f64,
    /// Excess over the curve towards the reference, K.
    excess: f64,
    /// κ, K s/m, and τ, s.
    drag: f64,
    settle_s: f64,
    /// Rate of temperature that the braking counted on makes, K/s.
    brake: f64,
    /// How far below the curve a wire past the reference is to be, K/m, and the width 1/k of the curve, K.
    past: f64,
    width: f64,
}

impl Approach {
    /// The largest excess from which the wire still stops in time; past the reference, how much there is too much of it.
    #[inline]
    fn surface(&self) -> f64 {
        if self.ahead <= 0.0 {
            return (self.ahead * self.past).max(-MOST_PAST_WIDTHS * self.width);
        }
        let b = (self.settle_s * self.brake).max(1e-9);
        let u = self.ahead * self.drag / (self.settle_s * b);
        // y − ln(1+y) = u by one step of Newton, from a guess that is right for small u: nowhere off by more than 2 %
        let guess = (u + (2.0 * u).sqrt()).max(1e-9);
        b * (guess - (guess - (1.0 + guess).ln() - u) * (1.0 + guess) / guess)
    }
}

impl TimeOptimal {
    pub(crate) fn new(map: WireMap, lambda: f64, band: f64, range: Range) -> TimeOptimal {
        let given = range.minimum;
        TimeOptimal {
            fastest: fastest(&map),
            map,
            lambda,
            range,
            hold: Hold::new(band),
            given,
            surface: 0.0,
            pace: Pace::NONE,
        }
    }

    /// The mean duty of the next period.
    #[inline]
    fn wanted(&mut self, demand: &Demand) -> f64 {
        let seen = &demand.estimate;
        let error = seen.length_m - demand.reference_m;
        let m = &self.map;
        let s = seen.stress_pa + m.thermoelastic * (seen.temperature_c - m.reference);
        let loss = seen.loss_w;
        // the curves where the wire stands still: without the drag's share
        let branch = m.branch(seen.martensite, s);
        let still = |curve: f64, width: f64| curve + seen.velocity_m_s * branch.drag(width);
        let curves = Curves {
            heating_c: still(seen.heating_curve_c, m.heating_width),
            cooling_c: still(seen.cooling_curve_c, m.cooling_width),
        };
        let pace = self.pace.velocity;
        if let Some(target) = self.hold.decide(m, demand, error, pace, curves, self.lambda) {
            self.surface = target - seen.temperature_c;
            let rate = KEEP_PER_S + (BRING_PER_S - KEEP_PER_S) * self.surface.abs().min(1.0);
            return (loss + m.heat_capacity * rate * self.surface) / seen.full_power_w;
        }
        let heating = self.hold.shortens();
        let (width, curve) =
            if heating { (m.heating_width, curves.heating_c) } else { (m.cooling_width, curves.cooling_c) };
        let drag = branch.drag(width).max(1e-6);
        let slope = branch.kelvin_per_metre(width);
        let latent = m.latent_kelvin_per_metre(seen.release_j, s);
        let settle_s = drag / (slope + latent);
        let capacity = m.heat_capacity;
        let most = seen.full_power_w * self.range.maximum;
        let gain = self.fastest.min(1.0 / (RETURN_SAMPLES * demand.dt_s));
        let sign = if heating { 1.0 } else { -1.0 };
        let towards = -sign * seen.velocity_m_s;
        let mut excess = sign * (seen.temperature_c - curve);
        if excess > 0.0 {
            // how fast it moves says the same, without the curve's place in it
            excess = 0.5 * (excess + (towards * drag).max(0.0));
        }
        // The period under way is decided already.
        let pending = (self.given * seen.full_power_w - loss) / capacity;
        let dt = demand.dt_s;
        let tracking = self.hold.is_tracking(pace);
        let lead = if tracking { 0.0 } else { self.hold.lead(m, seen.martensite) };
        // what a wire that keeps up with its reference has too much of it
        let keeping_up = if tracking { -sign * pace } else { 0.0 };
        let ahead = sign * error - lead - (towards - keeping_up).max(0.0) * (m.inertia_s() + dt);
        let kept = keeping_up * drag;
        excess += dt * (sign * pending - excess.max(0.0) / settle_s.max(dt));
        let sure = (loss - seen.loss_sigma_w).max(0.2 * loss).max(0.0);
        let brake =
            if heating { RESERVE_SHORTENING * sure } else { RESERVE_LENGTHENING * (most - loss).max(0.0) } / capacity;
        let approach =
            Approach { ahead, excess, drag, settle_s, brake, past: PAST_WIDTHS * width / self.hold.reach(), width };
        let most_excess = approach.surface();
        self.surface = sign * (most_excess + kept - approach.excess);
        // on the surface it brakes by the share counted on; a wire that does not move yet needs no braking
        let moving = ((approach.excess - kept) / most_excess.max(1e-9)).clamp(0.0, 1.0);
        let braking = loss - sign * brake * capacity * moving + sign * capacity * kept / settle_s;
        let mut power = braking + capacity * gain * self.surface;
        if !tracking && error.abs() < self.hold.reach() + lead && excess < 0.0 {
            // A correction out of a hold: below its curve the wire already moves, along the inner loop, by an unknown distance.
            let rate = CREEP_WIDTHS_PER_S * width + CREEP_PER_S * (-excess - CREEP_BEYOND_WIDTHS * width).max(0.0);
            power = if heating { power.min(loss + capacity * rate) } else { power.max(loss - capacity * rate) };
        }
        power / seen.full_power_w
    }
}

/// Fastest return to the surface that load and wire can follow, 1/s, at mid-stroke.
pub(super) fn fastest(m: &WireMap) -> f64 {
    if m.mass <= 0.0 || m.shift <= 0.0 {
        return RETURN_PER_S;
    }
    let s = m.stress(0.5 * m.strain * m.length, 0.0);
    let slope = m.kelvin_per_metre(0.5, m.heating_width, s) + m.latent_kelvin_per_metre(m.release(s), s);
    let stiffness = slope * m.area / m.shift;
    let half = 0.5 * m.damping / m.mass;
    let square = half * half - stiffness / m.mass;
    let fast = if square > 0.0 { half + square.sqrt() } else { (stiffness / m.mass).sqrt() };
    RETURN_PER_S.min(0.5 * fast)
}

impl Law for TimeOptimal {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() || !demand.estimate.temperature_c.is_finite() {
            (self.surface, self.given) = (0.0, self.range.minimum);
            return None;
        }
        self.pace.follow(demand.reference_m, demand.dt_s, self.hold.reach());
        let wanted = self.wanted(demand);
        self.given = self.range.give(wanted);
        Some(self.given)
    }

    fn reset(&mut self) {
        self.range.reset();
        self.hold.reset();
        self.pace = Pace::NONE;
        (self.surface, self.given) = (0.0, self.range.minimum);
    }

    fn surface(&self) -> f64 {
        self.surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wire released with the excess of the surface comes to rest at the reference: ẋ = −e/κ, ė = −brake − e/τ, integrated.
    #[test]
    fn surface_is_the_stopping_distance() {
        for (drag, settle_s, brake) in
            [(407.0, 0.063, 43.0), (407.0, 0.063, 2.0), (11.0, 0.002, 43.0), (407.0, 0.5, 240.0)]
        {
            for ahead in [1e-6, 1e-5, 1e-4, 1e-3] {
                let approach = Approach { ahead, excess: 0.0, drag, settle_s, brake, past: 1.0, width: 3.0 };
                let (mut excess, mut left, dt) = (approach.surface(), ahead, 1e-4 * settle_s);
                while excess > 0.0 {
                    let middle = excess - 0.5 * dt * (brake + excess / settle_s);
                    left -= middle.max(0.0) / drag * dt;
                    excess -= dt * (brake + middle / settle_s);
                }
                assert!(left.abs() < 0.04 * ahead + 1e-9, "{drag} {settle_s} {brake}: {left} of {ahead} left");
            }
        }
    }

    #[test]
    fn past_the_reference_a_wire_is_kept_below_its_curve() {
        let approach = |ahead| Approach {
            ahead,
            excess: 0.0,
            drag: 407.0,
            settle_s: 0.06,
            brake: 40.0,
            past: PAST_WIDTHS * 3.0 / 1e-4,
            width: 3.0,
        };
        assert!((approach(-1e-5).surface() + 0.6).abs() < 1e-12);
        assert!((approach(-1.0).surface() + 6.0).abs() < 1e-12);
    }
}
