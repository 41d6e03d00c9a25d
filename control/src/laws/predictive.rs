//! Model predictive control: the power of the next block of time, from shooting over the wire's model within its limits.
//!
//! Every [`PERIOD_S`] the wire's model is run from the estimated state through a block of constant power and then braked as hard as
//! it may be counted on, until it moves no faster than its reference: by the heat balance (eq. 48) with the loss to the air and the
//! latent heat of where it is, along the curve (eq. 20, 12) and against the drag of the load (eq. 51). What it is short of
//! its reference there falls with the power of the block, so that one number is searched, within the least and the most power:
//! the plan of least time that fulfils both limits, full power (or none) as long as that still stops in time. Only the
//! block's first part is given before it is planned anew.
//!
//! What the model leaves out is a disturbance of the excess temperature, estimated from how the wire moves beside how it should
//! have ([`DISTURBANCE_S`]), so that a plan made by a wrong model still ends at the reference. The terminal set is the band in which
//! [`Hold`] keeps a wire inside its hysteresis: a law of its own, because moving on there costs more than it gains.

use super::hold::Hold;
use super::optimal::fastest;
use super::pace::Pace;
use crate::cycle::Curves;
use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;

/// A plan is made so often, s; in a slower loop, once a period.
pub const PERIOD_S: f64 = 0.002;
/// Length of the block, in samples at least.
const BLOCK_SAMPLES: f64 = 4.0;
/// Steps of a rollout: at most so many, and so many in the time the excess takes to be used up.
const STEPS: usize = 48;
const STEPS_PER_SETTLING: f64 = 6.0;
/// Evaluations between the limits of the power.
const SECANTS: usize = 4;
/// Time in which the disturbance is estimated, s.
const DISTURBANCE_S: f64 = 0.04;
/// Share of the braking power a plan counts on, of a shortening and of a lengthening wire.
const RESERVE_SHORTENING: f64 = 0.7;
const RESERVE_LENGTHENING: f64 = 0.4;
/// How fast the last correction out of a hold approaches its curve: widths per second, and 1/s of what is beyond so many widths.
const CREEP_WIDTHS_PER_S: f64 = 1.5;
const CREEP_PER_S: f64 = 15.0;
const CREEP_BEYOND_WIDTHS: f64 = 1.5;
/// Rate at which a held wire is kept at its temperature, and brought to it from a kelvin off, 1/s.
const KEEP_PER_S: f64 = 1.5;
const BRING_PER_S: f64 = 8.0;
/// How far below its curve a wire past its reference is kept, in widths.
const PAST_WIDTHS: f64 = 2.0;

/// Shooting over the wire's model.
#[derive(Debug, Clone)]
pub struct ModelPredictive {
    map: WireMap,
    lambda: f64,
    range: Range,
    hold: Hold,
    pace: Pace,
    /// Fastest that wire and load can follow, 1/s.
    fastest: f64,
    /// The duty of the period under way, and the one planned for the block, before the switch.
    given: f64,
    planned: f64,
    /// Time since the last plan, s, and the reference it was made for, m.
    age_s: f64,
    reference: f64,
    /// Excess temperature by which the wire moves beyond what the model has, K.
    disturbance: f64,
    /// What the plan is short of the reference with the duty that is given, m; positive = heat.
    short: f64,
}

/// A wire on its way: its state as the model has it, seen in the direction of its way.
#[derive(Debug, Clone, Copy)]
struct State {
    /// Distance to the reference, m; positive.
    ahead: f64,
    /// Excess over the curve towards the reference, K.
    excess: f64,
    martensite: f64,
    /// Loss to the air, W.
    loss: f64,
}

/// The model of a plan, and what is fixed over it.
struct Model<'a> {
    map: &'a WireMap,
    /// +1 shortens, −1 lengthens.
    sign: f64,
    width: f64,
    /// σ + θ(T − T_0), Pa.
    s: f64,
    release_j: f64,
    /// Change of the loss with temperature, W/K.
    loss_per_k: f64,
    /// Share of the loss that is sure, and of the braking power that is counted on.
    sure: f64,
    reserve: f64,
    least: f64,
    most: f64,
    /// Speed of the reference along the way, m/s.
    keeping_up: f64,
}

impl Model<'_> {
    /// The power that brakes a wire of this loss, W.
    #[inline]
    fn brake(&self, loss: f64) -> f64 {
        if self.sign > 0.0 {
            loss - self.reserve * (self.sure * loss - self.least).max(0.0)
        } else {
            loss + self.reserve * (self.most - loss).max(0.0)
        }
    }

    /// How far the wire stops short of its reference after `block_s` of this power and braking; negative = beyond it.
    fn short(&self, start: State, power: f64, block_s: f64) -> f64 {
        let (m, mut now, mut left) = (self.map, start, block_s);
        let expansion = m.thermal_expansion(now.martensite);
        for _ in 0..STEPS {
            let braking = left <= 0.0;
            let power = if braking { self.brake(now.loss) } else { power };
            let rate = self.sign * (power - now.loss) * m.per_heat_capacity;
            if now.excess < 0.0 {
                // between the curves: nothing transforms, and thermal strain moves the wire the wrong way
                if braking && (rate <= 0.0 || self.keeping_up <= 0.0) {
                    return now.ahead;
                }
                let to_curve = if rate > 0.0 { -now.excess / rate } else { f64::INFINITY };
                let step = if braking { to_curve } else { left.min(to_curve) };
                let change = rate * step;
                now.excess = if step == to_curve { 0.0 } else { now.excess + change };
                now.ahead += expansion * change + self.keeping_up * step;
                now.loss += self.sign * self.loss_per_k * change;
                left -= step;
                continue;
            }
            let branch = m.branch(now.martensite, self.s);
            let drag = branch.drag(self.width).max(1e-6);
            let slope = branch.kelvin_per_metre(self.width);
            let settle_s = drag / (slope + m.latent_kelvin_per_metre(self.release_j, self.s));
            let step = if braking { settle_s / STEPS_PER_SETTLING } else { left.min(settle_s) };
            let end = settle_s * rate;
            let decay = (-step / settle_s).exp();
            let excess = end + (now.excess - end) * decay;
            let way = (end * step + (now.excess - end) * settle_s * (1.0 - decay)) / drag;
            let kept = self.keeping_up * drag;
            if braking && excess <= kept {
                // the rest is a triangle: its speed falls in a line to the reference's
                let over = (now.excess - kept).max(0.0);
                return now.ahead - 0.5 * over / drag * step * over / (now.excess - excess).max(1e-12);
            }
            now.ahead -= way - self.keeping_up * step;
            now.martensite -= self.sign * way * m.per_length * m.per_strain(self.s);
            now.loss += self.sign * self.loss_per_k * (excess - now.excess + slope * way);
            now.excess = excess;
            left -= step;
        }
        now.ahead
    }

    /// The power of the block with which the wire stops at its reference, within the limits, and what it is short of it then.
    fn power(&self, start: State, block_s: f64) -> (f64, f64) {
        let (nearest, farthest) = if self.sign > 0.0 { (self.least, self.most) } else { (self.most, self.least) };
        let far = self.short(start, farthest, block_s);
        if far >= 0.0 {
            return (farthest, far);
        }
        let near = self.short(start, nearest, block_s);
        if near <= 0.0 {
            return (nearest, near);
        }
        // what is short falls with the power towards `farthest`: regula falsi, with the Illinois weights
        let (mut low, mut high, mut side) = ((nearest, near), (farthest, far), 0);
        for _ in 0..SECANTS {
            let power = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            let short = self.short(start, power, block_s);
            if short > 0.0 {
                low = (power, short);
                if side == 1 {
                    high.1 *= 0.5;
                }
                side = 1;
            } else {
                high = (power, short);
                if side == -1 {
                    low.1 *= 0.5;
                }
                side = -1;
            }
        }
        let power = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1).max(1e-300);
        (power, 0.0)
    }
}

impl ModelPredictive {
    pub(crate) fn new(map: WireMap, lambda: f64, band: f64, range: Range) -> ModelPredictive {
        ModelPredictive {
            fastest: fastest(&map),
            map,
            lambda,
            hold: Hold::new(band),
            pace: Pace::NONE,
            given: range.minimum,
            planned: range.minimum,
            age_s: f64::INFINITY,
            reference: f64::NAN,
            disturbance: 0.0,
            short: 0.0,
            range,
        }
    }

    /// The mean duty of the next period.
    #[inline]
    fn wanted(&mut self, demand: &Demand) -> f64 {
        let seen = &demand.estimate;
        let m = &self.map;
        let error = seen.length_m - demand.reference_m;
        let s = seen.stress_pa + m.thermoelastic * (seen.temperature_c - m.reference);
        // the curves where the wire stands still: without the drag's share
        let branch = m.branch(seen.martensite, s);
        let still = |curve: f64, width: f64| curve + seen.velocity_m_s * branch.drag(width);
        let curves = Curves {
            heating_c: still(seen.heating_curve_c, m.heating_width),
            cooling_c: still(seen.cooling_curve_c, m.cooling_width),
        };
        let pace = self.pace.velocity;
        if let Some(target) = self.hold.decide(m, demand, error, pace, curves, self.lambda) {
            let off = target - seen.temperature_c;
            let rate = KEEP_PER_S + (BRING_PER_S - KEEP_PER_S) * off.abs().min(1.0);
            (self.age_s, self.disturbance, self.short) = (f64::INFINITY, 0.0, 0.0);
            return (seen.loss_w + m.heat_capacity * rate * off) / seen.full_power_w;
        }
        self.age_s += demand.dt_s;
        let due = self.age_s >= PERIOD_S - 0.5 * demand.dt_s || self.reference != demand.reference_m;
        if due {
            self.age_s = 0.0;
            self.reference = demand.reference_m;
            self.planned = self.plan(demand, error, s, curves) / seen.full_power_w;
        }
        self.planned
    }

    /// The power of the next block, W.
    fn plan(&mut self, demand: &Demand, error: f64, s: f64, curves: Curves) -> f64 {
        let seen = &demand.estimate;
        let (m, dt, pace) = (&self.map, demand.dt_s, self.pace.velocity);
        let heating = self.hold.shortens();
        let (width, curve, sign) = if heating {
            (m.heating_width, curves.heating_c, 1.0)
        } else {
            (m.cooling_width, curves.cooling_c, -1.0)
        };
        let branch = m.branch(seen.martensite, s);
        let drag = branch.drag(width).max(1e-6);
        let tracking = self.hold.is_tracking(pace);
        let lead = if tracking { 0.0 } else { self.hold.lead(m, seen.martensite) };
        let keeping_up = if tracking { -sign * pace } else { 0.0 };
        let towards = -sign * seen.velocity_m_s;
        let mut excess = sign * (seen.temperature_c - curve);
        if excess > 0.0 {
            let surprise = (towards * drag).max(0.0) - excess;
            self.disturbance += (surprise - self.disturbance) * (PERIOD_S.max(dt) / DISTURBANCE_S).min(1.0);
            excess = (excess + 0.5*self.disturbance).max(0.0);
        } else {
            self.disturbance = 0.0;
        }
        let loss = seen.loss_w;
        let model = Model {
            map: m,
            sign,
            width,
            s,
            release_j: seen.release_j,
            loss_per_k: m.loss,
            sure: ((loss - seen.loss_sigma_w) / loss.max(1e-12)).clamp(0.2, 1.0),
            reserve: if heating { *R1 } else { *R2 },
            least: seen.full_power_w * self.range.minimum,
            most: seen.full_power_w * self.range.maximum,
            keeping_up,
        };
        let capacity = m.heat_capacity;
        let ahead = sign * error - lead - (towards - keeping_up).max(0.0) * (m.inertia_s() + dt);
        let settle_s = drag / (branch.kelvin_per_metre(width) + m.latent_kelvin_per_metre(seen.release_j, s));
        // the period under way is decided already
        let pending = sign * (self.given * seen.full_power_w - loss) / capacity;
        excess += dt * (pending - excess.max(0.0) / settle_s.max(dt));
        let block_s = (1.0 / self.fastest).max(BLOCK_SAMPLES * dt);
        let kept = keeping_up * drag;
        let mut power = if ahead > 0.0 {
            let start = State { ahead, excess, martensite: seen.martensite, loss };
            let (power, short) = model.power(start, block_s);
            self.short = sign * short;
            power
        } else {
            // past it: no farther below the curve than the way back is worth
            let target = kept + (ahead * PAST_WIDTHS * width / self.hold.reach()).max(-PAST_WIDTHS * width);
            self.short = sign * ahead;
            loss + sign * capacity * ((target - excess) / block_s + kept / settle_s)
        };
        if !tracking && error.abs() < self.hold.reach() + lead && excess < 0.0 {
            // A correction out of a hold: below its curve the wire already moves, along the inner loop, by an unknown distance.
            let rate = CREEP_WIDTHS_PER_S * width + CREEP_PER_S * (-excess - CREEP_BEYOND_WIDTHS * width).max(0.0);
            power = if heating { power.min(loss + capacity * rate) } else { power.max(loss - capacity * rate) };
        }
        power
    }
}
static R1: std::sync::LazyLock<f64> = std::sync::LazyLock::new(|| std::env::var("R1").ok().and_then(|v| v.parse().ok()).unwrap_or(RESERVE_SHORTENING));
static R2: std::sync::LazyLock<f64> = std::sync::LazyLock::new(|| std::env::var("R2").ok().and_then(|v| v.parse().ok()).unwrap_or(RESERVE_LENGTHENING));

impl Law for ModelPredictive {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() || !demand.estimate.temperature_c.is_finite() {
            (self.short, self.given, self.age_s) = (0.0, self.range.minimum, f64::INFINITY);
            return None;
        }
        self.pace.follow(demand.reference_m, demand.dt_s, self.hold.reach());
        let wanted = self.wanted(demand);
        self.given = self.range.give(wanted);
        Some(self.given)
    }

    fn reset(&mut self) {
        self.range.reset();
        *self = ModelPredictive::new(self.map, self.lambda, self.hold.band(), self.range);
    }

    fn surface(&self) -> f64 {
        self.short
    }
}
