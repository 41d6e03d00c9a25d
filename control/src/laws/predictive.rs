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
use super::optimal::{
    BRING_PER_S, CREEP_BEYOND_WIDTHS, CREEP_PER_S, CREEP_WIDTHS_PER_S, KEEP_PER_S, PAST_WIDTHS, fastest,
};
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
/// Time in which the disturbance is estimated, s, and the share of it that a plan counts.
const DISTURBANCE_S: f64 = 0.01;
const COUNTED: f64 = 0.5;
/// Share of the braking power a plan counts on. Of a shortening wire, at least and at most: between them it falls by so much with the
/// relative standard deviation of the loss, which is what brakes it. Of a lengthening one: the supply is strong and sure.
const SHORTENING: (f64, f64) = (0.7, 0.85);
const UNSURE: f64 = 3.0;
const LENGTHENING: f64 = 0.4;
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
    /// Time since the last plan, s, and the reference of the last cycle, m.
    age_s: f64,
    reference: f64,
    /// Excess temperature that the wire should move by, as the load follows it, and by which it moves beyond that, K.
    moving: f64,
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
            moving: 0.0,
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
        // one that moves is met at the next plan; the first of all, from NaN, has stepped
        let stays = (self.reference - demand.reference_m).abs() < self.hold.reach();
        self.reference = demand.reference_m;
        if let Some(target) = self.hold.decide(m, demand, error, pace, curves, self.lambda) {
            let off = target - seen.temperature_c;
            let rate = KEEP_PER_S + (BRING_PER_S - KEEP_PER_S) * off.abs().min(1.0);
            (self.age_s, self.moving, self.disturbance, self.short) = (f64::INFINITY, 0.0, 0.0, 0.0);
            return (seen.loss_w + m.heat_capacity * rate * off) / seen.full_power_w;
        }
        self.age_s += demand.dt_s;
        if !stays || self.age_s >= PERIOD_S - 0.5 * demand.dt_s {
            self.age_s = 0.0;
            self.planned = self.plan(demand, error, s, curves) / seen.full_power_w;
        }
        self.planned
    }

    /// The power of the next block, W.
    fn plan(&mut self, demand: &Demand, error: f64, s: f64, curves: Curves) -> f64 {
        let seen = &demand.estimate;
        let (m, dt, pace) = (&self.map, demand.dt_s, self.pace.velocity);
        let heating = self.hold.shortens();
        let (width, curve, sign) =
            if heating { (m.heating_width, curves.heating_c, 1.0) } else { (m.cooling_width, curves.cooling_c, -1.0) };
        let branch = m.branch(seen.martensite, s);
        let drag = branch.drag(width).max(1e-6);
        let tracking = self.hold.is_tracking(pace);
        let lead = if tracking { 0.0 } else { self.hold.lead(m, seen.martensite) };
        let keeping_up = if tracking { -sign * pace } else { 0.0 };
        let towards = -sign * seen.velocity_m_s;
        let mut excess = sign * (seen.temperature_c - curve);
        if excess > 0.0 {
            // the load's inertia lets the wire follow late, which the model knows
            let step = PERIOD_S.max(dt);
            self.moving += (excess - self.moving) * step / (step + m.inertia_s());
            let surprise = (towards * drag).max(0.0) - self.moving;
            self.disturbance += (surprise - self.disturbance) * (step / DISTURBANCE_S).min(1.0);
            excess = (excess + COUNTED * self.disturbance).max(0.0);
        } else {
            (self.moving, self.disturbance) = (0.0, 0.0);
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
            reserve: if heating {
                (SHORTENING.1 - UNSURE * seen.loss_sigma_w / loss.max(1e-12)).max(SHORTENING.0)
            } else {
                LENGTHENING
            },
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::{standing, wire};

    /// The model of a plan for the wire of the tests, which takes at most 3 W.
    fn model(map: &WireMap, sign: f64) -> Model<'_> {
        Model {
            map,
            sign,
            width: if sign > 0.0 { map.heating_width } else { map.cooling_width },
            s: 160e6,
            release_j: map.release(160e6),
            loss_per_k: map.loss,
            sure: 1.0,
            reserve: 0.8,
            least: 0.06,
            most: 3.0,
            keeping_up: 0.0,
        }
    }

    fn starts() -> impl Iterator<Item = State> {
        let places = [1e-6, 1e-5, 1e-4, 1e-3, 3e-3].into_iter();
        places.flat_map(|ahead| {
            [-20.0, -1.0, 0.0, 1.0, 8.0, 30.0].into_iter().flat_map(move |excess| {
                [0.05, 0.5, 0.95].map(|martensite| State { ahead, excess, martensite, loss: 0.5 })
            })
        })
    }

    /// The power is always one that there is; at a limit only where the other side of the limit is what would be needed; and else the wire,
    /// run through the plan, comes to rest at the reference.
    #[test]
    fn a_plan_keeps_its_limits_and_ends_at_the_reference() {
        let map = WireMap::new(&wire());
        let (mut within, mut at_limits) = (0, 0);
        for sign in [1.0, -1.0] {
            let model = model(&map, sign);
            for start in starts() {
                let (power, short) = model.power(start, 0.008);
                assert!((model.least..=model.most).contains(&power), "{power}");
                if power == model.least || power == model.most {
                    assert!(
                        (short >= 0.0) == ((power == model.most) == (sign > 0.0)),
                        "{power} W, {short} m of {start:?}"
                    );
                    at_limits += 1;
                } else {
                    let left = model.short(start, power, 0.008);
                    assert!(left.abs() < 0.02 * start.ahead + 4e-6, "{left} m of {start:?} at {power} W");
                    within += 1;
                }
            }
        }
        assert!(within > 20 && at_limits > 20, "{within} {at_limits}");
    }

    /// More power towards the reference never leaves the wire shorter of it: what the search of the power rests on.
    #[test]
    fn what_is_short_falls_with_the_power() {
        let map = WireMap::new(&wire());
        for sign in [1.0, -1.0] {
            let model = model(&map, sign);
            for start in starts() {
                let mut before = f64::INFINITY;
                for k in 0..=20 {
                    let share = f64::from(if sign > 0.0 { k } else { 20 - k }) / 20.0;
                    let short = model.short(start, model.least + share * (model.most - model.least), 0.008);
                    // below the curve more power only stretches the wire
                    assert!(short <= before + 2e-6, "{short} after {before}: {start:?}");
                    before = short;
                }
            }
        }
    }

    /// A rollout's stopping distance is that of a fine integration of the same balance: at constant coefficients,
    /// ė = −b − e/τ, ẋ = −e/κ, in closed form.
    #[test]
    fn a_rollout_stops_where_the_closed_form_says() {
        let map = WireMap::new(&wire());
        let model = model(&map, -1.0);
        for excess in [0.5, 2.0, 6.0] {
            let start = State { ahead: 0.0, excess, martensite: 0.5, loss: 0.5 };
            let branch = map.branch(0.5, model.s);
            let drag = branch.drag(model.width);
            let settle_s =
                drag / (branch.kelvin_per_metre(model.width) + map.latent_kelvin_per_metre(model.release_j, model.s));
            let brake = model.reserve * (model.most - start.loss) * map.per_heat_capacity;
            let b = settle_s * brake;
            let way = settle_s / drag * (excess - b * (1.0 + excess / b).ln());
            let found = -model.short(start, 0.0, 0.0);
            assert!((found / way - 1.0).abs() < 0.08, "{found} m, {way} m from {excess} K");
        }
    }

    /// Between two plans the power stays, however many cycles lie between them.
    #[test]
    fn plans_are_made_at_their_own_rate() {
        let map = WireMap::new(&wire());
        let mut law = ModelPredictive::new(map, 10.0, 1e-5, Range::new(0.02, 1.0, Modulation::Switched));
        let mut changes = 0;
        let mut last = f64::NAN;
        for k in 0..1000 {
            // on its way, near enough to be braked: every cycle it is somewhere else
            let estimate = crate::estimate::Estimate {
                temperature_c: 104.0,
                martensite: 0.5,
                hottest_c: 110.0,
                stress_pa: 160e6,
                heating_curve_c: 103.0,
                cooling_curve_c: 77.0,
                length_m: 0.16342 + 1e-6 * f64::from(k % 97),
                loss_w: 0.5,
                loss_sigma_w: 0.0,
                release_j: map.release(160e6),
                full_power_w: 3.0,
                velocity_m_s: -5e-3,
            };
            let duty =
                law.duty(&Demand { velocity_m_s: -5e-3, dt_s: 1e-4, estimate, ..standing(0.16318, 0.1632) }).unwrap();
            changes += u32::from(duty != last);
            last = duty;
        }
        // a tenth of a second at 500 Hz
        assert!((10..=51).contains(&changes), "{changes}");
    }
}
