//! Holding a wire at its reference. Crossing the hysteresis moves a wire the wrong way by its thermal strain, and its
//! readings are noisier than the required accuracy: so within a band around the reference its temperature is held
//! until its mean error leaves the band.

use crate::cycle::Curves;
use crate::demand::Demand;
use crate::wire_map::WireMap;

/// Time over which the error of a held wire is averaged, in 1/λ.
const AVERAGE: f64 = 4.0;
/// A hold lasts this long before its mean error is judged, in 1/λ.
const AT_LEAST: f64 = 1.5;
/// What the first error of a hold is worth as averaging time, in 1/λ.
const FIRST: f64 = 0.3;
/// Where a hold begins for a wire that comes from being too long, and from too short, in hold bands.
const ARRIVE_SHORTENING: f64 = 0.8;
const ARRIVE_LENGTHENING: f64 = 0.4;
/// Mean error at which a hold ends if the wire can be moved along the curve it stands near, in hold bands.
const LEAVE_ALONG: f64 = 1.7;
/// The same if it has to cross the hysteresis.
const LEAVE_ACROSS: f64 = 2.2;
/// Error at which a hold ends at once, in hold bands.
const LEAVE_AT_ONCE: f64 = 4.0;
/// How far off the heating and the cooling curve a held wire's temperature is kept, in widths 1/k of the curve.
const RETREAT: f64 = 3.0;
/// Rate at which the mean error of a held wire is trimmed away by its thermal strain, 1/s, and fastest change of its
/// temperature for that, K/s.
const TRIM_RATE: f64 = 0.7;
const MOST_TRIM_K_PER_S: f64 = 12.0;
/// Mean error from which it is, in hold bands.
const TRIM_FROM: f64 = 0.3;

/// Velocity of a reference from which it is followed, in hold bands per second.
const TRACKING: f64 = 3.0;
/// A wire ahead of a moving reference waits for it so long before it turns round, s.
const PATIENCE_S: f64 = 0.5;

/// A wire left standing near its reference.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    on: bool,
    /// Half width of the band, m.
    band: f64,
    /// Mean error since the hold began, m.
    error: f64,
    /// How long that is averaged over, s.
    time: f64,
    /// Whether the wire comes, or came, from being too long.
    shortens: bool,
    reference: f64,
    /// The temperature it is held at, °C.
    temperature: f64,
}

impl Hold {
    pub fn new(band: f64) -> Hold {
        Hold { on: false, band, error: 0.0, time: 0.0, shortens: true, reference: f64::NAN, temperature: f64::NAN }
    }

    pub fn reset(&mut self) {
        *self = Hold::new(self.band);
    }

    /// Half width of the band, m.
    pub fn band(&self) -> f64 {
        self.band
    }

    /// Whether a reference of this velocity, m/s, is followed rather than waited for.
    pub fn is_tracking(&self, pace: f64) -> bool {
        pace.abs() > TRACKING * self.band
    }

    /// Error within which a wire is near enough to be held again soon, m.
    pub fn reach(&self) -> f64 {
        LEAVE_AT_ONCE * self.band
    }

    /// Whether the wire comes from being too long, and so shortens along its heating curve.
    pub fn shortens(&self) -> bool {
        self.shortens
    }

    /// How far before the reference a wire is to arrive on its curve, so that it is there once it is held: the thermal strain of
    /// the retreat from the curve, m.
    #[inline]
    pub fn lead(&self, map: &WireMap, fraction: f64) -> f64 {
        let retreat = if self.shortens { RETREAT * map.heating_width } else { RETREAT * map.cooling_width };
        map.thermal_expansion(fraction) * retreat
    }

    /// Begins, goes on with or ends holding the wire, whose estimated error is `error` and whose reference moves by `pace`,
    /// between the curves of a wire at rest (`curves`); λ sets the time scale. While it is held: the temperature to hold it at.
    ///
    /// That is the one it came with, inside the hysteresis, trimmed by its thermal strain: away from the curve that it is nearer
    /// to nothing else moves it. Back towards the curve it would transform as well, and far more: so the trim goes one way
    /// only.
    #[inline]
    pub fn decide(
        &mut self,
        map: &WireMap,
        demand: &Demand,
        error: f64,
        pace: f64,
        curves: Curves,
        lambda: f64,
    ) -> Option<f64> {
        let (seen, band) = (&demand.estimate, self.band);
        let expansion = map.thermal_expansion(seen.martensite).max(1e-12);
        let (high, low) =
            (curves.heating_c - RETREAT * map.heating_width, curves.cooling_c + RETREAT * map.cooling_width);
        if self.is_tracking(pace) {
            // It will come to a wire that is ahead of it sooner than that could cross its hysteresis.
            let ahead = if pace < 0.0 { -error } else { error };
            let waits = ahead < self.reach() + PATIENCE_S * pace.abs();
            (self.on, self.shortens, self.reference) = (false, (pace < 0.0) == waits, demand.reference_m);
            return None;
        }
        if self.reference != demand.reference_m {
            // a reference that creeps does not end a hold by itself
            let moved = self.error + self.reference - demand.reference_m;
            self.reference = demand.reference_m;
            if self.on && moved.abs() <= self.reach() {
                self.error = moved;
            } else {
                (self.on, self.shortens) = (false, error > 0.0);
            }
        }
        if self.on {
            self.time += demand.dt_s;
            // what is left when the temperature is where it is to be
            let left = error - expansion * (seen.temperature_c - self.temperature);
            self.error += (left - self.error) * (demand.dt_s / self.time.min(AVERAGE / lambda)).min(1.0);
            let middle = 0.5 * (low + high);
            let along = if self.temperature > middle { self.error } else { -self.error };
            let judged = self.time * lambda > AT_LEAST;
            let off = judged && (along > LEAVE_ALONG * band || along < -LEAVE_ACROSS * band);
            if off || left.abs() > self.reach() {
                self.on = false;
                self.shortens = if off { self.error > 0.0 } else { left > 0.0 };
                return None;
            }
            let over = self.error - self.error.max(-TRIM_FROM * band).min(TRIM_FROM * band);
            let trim = (TRIM_RATE * over / expansion).clamp(-MOST_TRIM_K_PER_S, MOST_TRIM_K_PER_S) * demand.dt_s;
            let trimmed = if self.temperature > middle {
                self.temperature - trim.max(0.0).min(self.temperature - middle)
            } else {
                self.temperature + (-trim).max(0.0).min((middle - self.temperature).max(0.0))
            };
            let kept = trimmed.min(high).max(low);
            self.error += expansion * (kept - self.temperature);
            self.temperature = kept;
        } else {
            if error.abs() > self.reach() + self.lead(map, seen.martensite) {
                self.shortens = error > 0.0;
            }
            let (ahead, arrive) = if self.shortens { (error, ARRIVE_SHORTENING) } else { (-error, ARRIVE_LENGTHENING) };
            if ahead > arrive * band + self.lead(map, seen.martensite) {
                return None;
            }
            self.temperature = seen.temperature_c.min(high).max(low);
            let left = error - expansion * (seen.temperature_c - self.temperature);
            (self.on, self.error, self.time) = (true, left, FIRST / lambda);
        }
        Some(self.temperature)
    }
}
