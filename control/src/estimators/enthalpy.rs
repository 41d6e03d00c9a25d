//! Temperature and martensite of a wire, cycle by cycle, from its electrical power and its length.
//!
//! The length says the phase (eq. 6 and 23 with the stress of the load), the power the enthalpy (eq. 48): what is kept
//! is m c_p T − H ξ, so that latent heat is paid by difference and noise of the length never adds up. Two facts
//! bound the drift of that open-loop heat balance: the driving temperature lies between the outer curves of the phase
//! that is measured (g_M ≤ ξ ≤ g_A), and a wire that shortens on its own sits on the heating curve, one that lengthens on the
//! cooling curve. Both pull with bounded gains, so a wrong parameter biases the estimate and can never make it run away.

use super::surface::Surface;
use crate::cycle::{self, COLDEST_C, Curves, HOTTEST_C, Start, inside};
use crate::estimate::{Estimate, Observation};
use crate::lambda;
use crate::wire_map::WireMap;
use sinew_physics::WireModel;
use sinew_physics::formulas::logistic;

// Rates and speeds below are multiples of the wire's own: its λ, and the fastest the air lets it lengthen. The factors are
// those that serve the figure wire of docs/control-laws.md best, and hold for others as those scale.

/// Pull of a temperature outside the outer curves, in λ.
const BOUND_RATE: f64 = 2.0;
/// Pull of a moving wire's temperature to the curve it moves on, in λ.
const BRANCH_RATE: f64 = 0.4;
/// Slower than this share of the cooling speed is standing; four times as fast is surely moving.
const STANDING: f64 = 0.14;
/// And slower than this many standard deviations of the velocity is standing, too.
const STANDING_SIGMA: f64 = 6.0;
/// Bandwidth of the length and velocity kept here, in λ, of a wire that stands: the noise of one reading is twice the
/// accuracy wanted, and no acceleration is needed.
const MOTION_RATE: f64 = 2.0;
/// How many times more bandwidth a moving wire gets, whose lag would cost more than noise does.
const MOTION_GAIN: f64 = 4.0;
/// Share of the cooling speed at which it gets all of that.
const MOTION_SPEED: f64 = 0.27;
/// How much a kelvin of pull changes the estimated loss, 1/K.
const LOSS_PER_K: f64 = 0.035;
/// Power imbalance, as a share of the loss, up to which a pull says something of the loss.
const BALANCE: f64 = 0.25;
/// Fastest that evidence from the length moves the temperature, K/s.
const MOST_K_PER_S: f64 = 60.0;

/// Temperature and martensite of one wire from the enthalpy its power feeds.
#[derive(Debug, Clone)]
pub struct EnthalpyObserver {
    map: WireMap,
    surface: Surface,
    /// λ of the wire, 1/s, and the fastest the air lets it lengthen, m/s.
    lambda: f64,
    cooling_speed: f64,
    /// 1/([`MOTION_SPEED`] · that), s/m.
    per_motion_speed: f64,
    temperature: f64,
    fraction: f64,
    hottest: f64,
    elongation: f64,
    velocity: f64,
    /// Variance of a reading against the prediction, m².
    variance: f64,
    /// Loss to the air over what the model says.
    loss_scale: f64,
    full_power: f64,
    /// Whether a length has come yet.
    seen: bool,
    start: Start,
}

impl EnthalpyObserver {
    /// An estimator for a wire that starts as the model says: at its initial temperature (ambient) and phase.
    pub fn new(model: &WireModel) -> EnthalpyObserver {
        let map = WireMap::new(model);
        let speeds = lambda::speeds(&map, map.full_power);
        let cooling_speed = speeds.cooling.max(1e-3 * map.length * map.strain.max(1e-3));
        let mut estimator = EnthalpyObserver {
            surface: Surface::of(model, &map),
            map,
            lambda: lambda::limits(&map, map.full_power).value.clamp(0.05, 50.0),
            cooling_speed,
            per_motion_speed: 1.0 / (MOTION_SPEED * cooling_speed),
            temperature: 0.0,
            fraction: 0.0,
            hottest: 0.0,
            elongation: 0.0,
            velocity: 0.0,
            variance: 0.0,
            loss_scale: 1.0,
            full_power: map.full_power,
            seen: false,
            start: Start::of(model),
        };
        estimator.reset();
        estimator
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        self.begin_at(self.start.temperature_c);
    }

    /// Back to the start, for a wire that is known to be as hot as this, °C.
    pub fn begin_at(&mut self, temperature_c: f64) {
        (self.temperature, self.fraction) = (temperature_c, self.start.martensite);
        self.surface.settle(temperature_c);
        self.hottest = self.temperature;
        self.seen = false;
        (self.velocity, self.variance, self.loss_scale) = (0.0, 0.0, 1.0);
        self.full_power = self.map.full_power;
        let stress = self.map.stress(self.map.strain * self.map.length, 0.0);
        let theta = self.temperature - stress * self.map.shift;
        self.fraction = self.clipped(self.fraction, theta);
        self.elongation = self.map.elongation(self.fraction, stress, self.temperature);
    }

    /// What the wire gives to its surroundings, W.
    #[inline]
    fn loss_w(&self) -> f64 {
        self.loss_scale * self.surface.loss_w_per_k * (self.temperature - self.surface.temperature_c)
    }

    /// ξ inside the outer curves (eq. 20).
    fn clipped(&self, fraction: f64, theta: f64) -> f64 {
        let m = &self.map;
        let low = logistic(theta, m.cooling_centre, m.cooling_width);
        let high = logistic(theta, m.heating_centre, m.heating_width);
        fraction.clamp(low.min(high), high)
    }

    /// Follows the length with a critically damped α–β filter.
    #[inline]
    fn follow(&mut self, elongation: f64, dt: f64) {
        if !self.seen {
            (self.elongation, self.velocity, self.seen) = (elongation, 0.0, true);
            return;
        }
        let moving = (self.velocity.abs() * self.per_motion_speed).min(1.0);
        let rate = MOTION_RATE * self.lambda * (1.0 + MOTION_GAIN * moving);
        // r = 1/(1+ω dt), α = 1−r², β = (1−r)²
        let keep = 1.0 / (1.0 + rate * dt);
        self.elongation += self.velocity * dt;
        let surprise = elongation - self.elongation;
        self.elongation += (1.0 - keep * keep) * surprise;
        self.velocity += rate * rate * keep * keep * dt * surprise;
        self.variance += (self.lambda * dt).min(1.0) * (surprise * surprise - self.variance);
    }

    /// How far the temperature is off, K/λ: outside the outer curves, or, of a wire that surely moves, off the curve it moves
    /// on.
    #[inline]
    fn pull(&self, curves: &Curves, dt: f64) -> f64 {
        // a phase indistinguishable from the end of its range gives no bound on that side
        let (below, above) = (inside(self.fraction), inside(1.0 - self.fraction));
        if self.temperature > curves.heating_c {
            below * BOUND_RATE * (curves.heating_c - self.temperature)
        } else if self.temperature < curves.cooling_c {
            above * BOUND_RATE * (curves.cooling_c - self.temperature)
        } else if self.velocity.abs() > STANDING * self.cooling_speed {
            let rate = MOTION_RATE * self.lambda;
            let noise = STANDING_SIGMA * rate * (0.5 * rate * dt * self.variance).sqrt();
            let standing = (STANDING * self.cooling_speed).max(noise);
            let sure = ((self.velocity.abs() - standing) / (3.0 * standing)).clamp(0.0, 1.0);
            let curve = if self.velocity < 0.0 { curves.heating_c } else { curves.cooling_c };
            below.min(above) * sure * BRANCH_RATE * (curve - self.temperature)
        } else {
            0.0
        }
    }

    /// Pulls the temperature to where the length says it is, in a cycle in which `heat` was left of the power beyond the
    /// `loss`, W.
    #[inline]
    fn correct(&mut self, curves: &Curves, heat: f64, loss: f64, dt: f64) {
        let pull = self.pull(curves, dt);
        if pull == 0.0 {
            return;
        }
        let pulled = (self.lambda * pull).clamp(-MOST_K_PER_S, MOST_K_PER_S) * dt;
        self.temperature += pulled;
        // What has to be pulled again and again is a loss to the air that is not as the model has it; but only
        // near balance, where the loss is what the power is for.
        let sure = inside(self.fraction).min(inside(1.0 - self.fraction));
        let balanced = (1.0 - heat.abs() / (BALANCE * loss.abs()).max(1e-12)).max(0.0) * sure;
        self.loss_scale = (self.loss_scale - balanced * LOSS_PER_K * pulled).clamp(0.4, 2.5);
    }

    /// Takes one cycle in.
    #[inline]
    pub fn update(&mut self, seen: &Observation) -> Estimate {
        cycle::in_steps([seen], |[seen], dt| self.step(seen, dt))
    }

    #[inline]
    fn step(&mut self, seen: &Observation, dt: f64) -> Estimate {
        // a length that no wire can have is none
        let measured = (seen.length_m - self.map.length).abs() < self.map.length;
        let first = measured && !self.seen;
        if measured {
            self.follow(seen.length_m - self.map.length, dt);
        } else {
            self.velocity = 0.0;
        }
        let m = &self.map;
        let power = cycle::power(m, seen, || m.power_at_full_duty(self.fraction, self.temperature, self.elongation));
        self.full_power = cycle::full_power(m, seen, power, self.full_power);
        let stress = cycle::stress(m, seen, self.elongation, self.velocity);
        let shift = stress * m.shift;
        // heat balance (eq. 48): what is not lost to the air, and what the change of phase releases
        let loss = self.loss_w();
        let heat = power - loss;
        let release = m.release(stress);
        let fraction = if measured {
            m.fraction(self.elongation, stress, self.temperature).clamp(0.0, 1.0)
        } else {
            let predicted = self.temperature + heat * dt * m.per_heat_capacity;
            // along an outer curve only as far as this cycle's heat pays for
            let most = (heat * dt).abs() / release;
            self.fraction + (self.clipped(self.fraction, predicted - shift) - self.fraction).max(-most).min(most)
        };
        // What the first length tells of the phase is no change of it: no heat went into it.
        let change = if first { 0.0 } else { fraction - self.fraction };
        self.temperature += (heat * dt + release * change) * m.per_heat_capacity;
        self.fraction = fraction;

        let curves = Curves::at(m, fraction, stress);
        if measured {
            self.correct(&curves, heat, loss, dt);
        }
        let m = &self.map;
        self.temperature = self.temperature.clamp(COLDEST_C, HOTTEST_C);
        self.surface.follow(self.temperature, self.loss_scale, dt);
        if !measured {
            self.elongation = m.elongation(fraction, stress, self.temperature);
        }
        self.hottest = cycle::hottest(m, self.hottest, power, dt, self.temperature);
        Estimate {
            temperature_c: self.temperature,
            martensite: fraction,
            hottest_c: self.hottest,
            stress_pa: stress,
            heating_curve_c: curves.heating_c,
            cooling_curve_c: curves.cooling_c,
            length_m: m.length + self.elongation,
            loss_sigma_w: 0.2
                * self.loss_scale
                * self.surface.loss_w_per_k
                * (self.temperature - self.surface.temperature_c).abs(),
            release_j: release,
            full_power_w: self.full_power,
            velocity_m_s: self.velocity,
            loss_w: self.loss_w(),
        }
    }
}
