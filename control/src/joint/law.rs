//! From an angle to the duties of both wires.
//!
//! One wire of a moving joint shortens on its heating curve, the other lengthens on its cooling curve; 26 K lie between,
//! which each has to cross when the motion turns. For each wire strain, heat balance and curve (eq. 23, 48, 20) together
//! make a line between how fast it lengthens, how fast its stress rises and what power it gets beyond its loss:
//!
//! ```text
//!     dε/dt = a dσ/dt − b q      a = C + ε_ξ s (m c_p/Q)/α + C θ H s/(α Q),   b = (ε_ξ s − C θ)/Q
//!     q = P − h A_s (T − T_∞),   Q = m c_p + H s,   s = −dξ/dϑ of the curve it is on,   ε_ξ = ∂ε/∂ξ
//! ```
//!
//! Both ends move with the joint and both tensions are the same but for what the joint itself takes, so two powers answer for
//! two rates, angle and tension. The angle comes first: the wire that lengthens is let cool as fast as angle and tension
//! need; where the air is too slow for that, its line says how the tension rises, and the wire that shortens is given the
//! power that moves the joint against it. So at high speeds the stress does what the air cannot: 8 MPa shift a curve by 1 K.
//!
//! Tension is kept at its set value by how fast the lengthening wire is let go; above the upper limit nothing is heated
//! (anti-overload), below the lower one both wires are (anti-slack). A joint that stands on too much tension lets both wires
//! go alike; one that was asked for a tension moves them alike until it has it.

use super::{JointEstimate, stroke_rad};
use crate::Estimate;
use crate::wire_map::WireMap;
use sinew_physics::{Error, Joint, WireModel};

/// Rate at which an error of the angle is made good, 1/s.
const ANGLE_RATE: f64 = 50.0;
/// Rate at which a wrong speed of the joint is made good, 1/s.
const SPEED_RATE: f64 = 100.0;
/// Rate of the integral action, 1/s, and the most it adds, strokes per second.
const INTEGRAL_RATE: f64 = 1.0;
const MOST_INTEGRAL: f64 = 0.05;
/// While the lengthening wire is not on its curve yet: the most speed that is asked for to make an error good, strokes per
/// second, and share of the reference's own speed. More would only be stored as tension, and let go at once.
const MOST_WAITING: (f64, f64) = (0.3, 0.5);
/// Speed no joint reaches, strokes per second.
const MOST_SPEED: f64 = 20.0;
/// An error up to this share of the stroke does not turn the motion, nor does a speed up to this, strokes per second.
const TURN_ERROR: f64 = 0.004;
const TURN_SPEED: f64 = 0.005;
/// Where the reference stands still: error within which the joint is left standing, beyond which both wires moved alike but one
/// a little more make it good, and beyond which the joint has to turn, shares of the stroke; and how far inside the hysteresis both wires are kept meanwhile, K.
const HOLD_WITHIN: f64 = 0.0015;
const HOLD_UNTIL: f64 = 0.004;
const STAND_UNTIL: f64 = 0.03;
const HOLD_INSIDE_K: f64 = 1.0;
/// A standing joint whose tension is above its set value by the first factor is relaxed down to the second. Where the tension
/// itself was asked for, it is changed from the next share off on, either way, until it is right.
const RELAX_FROM: f64 = 1.3;
const RELAX_UNTIL: f64 = 1.05;
const FORCE_WITHIN: f64 = 0.06;
/// How far from its set value the tension may be taken to make an error of the angle good, as a share.
const STAND_ROOM: f64 = 0.15;
/// The tension of a standing joint is changed at this rate, Pa/s, from within so many K of both curves, with this share of the
/// rate at which errors of the angle are made good.
const CHANGE_PA_PER_S: f64 = 50e6;
const CHANGE_READY_K: f64 = 1.5;
const CHANGE_SHARE: f64 = 0.2;
/// A motion that is to go on may be asked to go back by so much, strokes per second.
const MOST_BACK: f64 = 0.3;
/// Rate at which a wire is brought to the curve it is to move on, 1/s, and from how far off in K: heating, cooling.
const CROSS_RATE: f64 = 200.0;
const CROSS_BEYOND_K: (f64, f64) = (0.3, 4.0);
/// Rate of the last part of the way to the cooling curve, 1/s: the wire lets go when it arrives.
const ARRIVE_RATE: f64 = 10.0;
/// Within this of its curve the lengthening wire counts as on it, K.
const ON_CURVE_K: f64 = 0.3;
/// Longest time that the crossing is begun before the motion turns, s.
const MOST_AHEAD_S: f64 = 0.1;
/// Rate at which tension is brought to its set value, 1/s, and the most that costs of a wire's temperature, K/s.
const TENSION_RATE: f64 = 2.0;
const TENSION_K_PER_S: f64 = 50.0;
/// How fast slack wires are warmed along their heating curve, K/s.
const TAUTEN_K_PER_S: f64 = 20.0;
/// Rate at which tension is kept from its upper limit, 1/s, and share of that limit within which heating is cut.
const LIMIT_RATE: f64 = 20.0;
const LIMIT_SHARE: f64 = 0.1;
/// A reference that stands still for so long has stopped, s; one that moves after that has stepped.
const REFERENCE_STOPS_S: f64 = 0.05;
/// Time over which the reference's acceleration is averaged, s.
const REFERENCE_SMOOTH_S: f64 = 0.01;

/// Numbers of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointSettings {
    /// The joint.
    pub joint: Joint,
    /// Tension below which both wires are heated, in N.
    pub minimum_tension_n: f64,
    /// Tension that is kept where the motion leaves it free, in N.
    pub tension_n: f64,
    /// Tension at which nothing is heated any more, in N.
    pub maximum_tension_n: f64,
    /// Least duty of each wire, agonist first: its sensing pulse.
    pub minimum_duty: [f64; 2],
    /// Most duty of each wire.
    pub maximum_duty: [f64; 2],
}

/// One cycle's question: which duties for the next PWM period?
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDemand {
    /// Angle wanted, in rad.
    pub reference_rad: f64,
    /// Tension wanted where the motion leaves it free, in N; NaN = that of the settings.
    pub tension_n: f64,
    /// Time since the last call, in s.
    pub dt_s: f64,
    /// What is believed of joint and wires.
    pub estimate: JointEstimate,
}

/// What a reference that comes value by value is doing: nobody says its speed.
#[derive(Debug, Clone, Copy)]
struct Trend {
    value: f64,
    rate: f64,
    acceleration: f64,
    /// Since the value changed, s.
    age: f64,
}

impl Trend {
    const NONE: Trend = Trend { value: f64::NAN, rate: 0.0, acceleration: 0.0, age: 0.0 };

    fn follow(&mut self, value: f64, dt: f64, most_rate: f64) {
        self.age += dt;
        if value == self.value {
            if self.age > REFERENCE_STOPS_S {
                (self.rate, self.acceleration) = (0.0, 0.0);
            }
            return;
        }
        let rate = (value - self.value) / self.age;
        // A step, the first value or a leap says nothing of a speed.
        if self.age <= REFERENCE_STOPS_S && rate.abs() < most_rate {
            let acceleration = (rate - self.rate) / self.age;
            self.acceleration += (self.age / REFERENCE_SMOOTH_S).min(1.0) * (acceleration - self.acceleration);
            self.rate = rate;
        } else {
            (self.rate, self.acceleration) = (0.0, 0.0);
        }
        (self.value, self.age) = (value, 0.0);
    }
}

/// The line of a wire: dε/dt = a dσ/dt − b q.
#[derive(Debug, Clone, Copy)]
struct Line {
    a: f64,
    b: f64,
}

impl Line {
    /// For a wire whose phase changes by `slope` per kelvin.
    fn of(m: &WireMap, wire: &Estimate, slope: f64) -> Line {
        let compliance = m.compliance_a + wire.martensite * (m.compliance_m - m.compliance_a);
        let s = wire.stress_pa + m.thermoelastic * (wire.temperature_c - m.reference);
        let strain = (m.strain + (m.compliance_m - m.compliance_a) * s).max(1e-4);
        let capacity = m.heat_capacity + wire.release_j * slope;
        let thermal = compliance * m.thermoelastic;
        let a = compliance + (strain * slope * m.heat_capacity + thermal * wire.release_j * slope) * m.shift / capacity;
        // inside the hysteresis power moves nothing, or the wrong way: that is no reason to ask for all of it
        let least = 0.005 * strain * m.per_heat_capacity / m.heating_width;
        Line { a, b: ((strain * slope - thermal) / capacity).max(least) }
    }

    /// q at which the wire lengthens at `rate` while its stress rises by `stress` per second.
    fn heat(&self, stress: f64, rate: f64) -> f64 {
        (self.a * stress - rate) / self.b
    }

    /// How its stress rises where it is made to lengthen at `rate` under q.
    fn stress(&self, rate: f64, heat: f64) -> f64 {
        (rate + self.b * heat) / self.a
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct JointLaw {
    settings: JointSettings,
    maps: [WireMap; 2],
    /// 1 − w of each wire: what of the inner loop's slope there is.
    inner: [f64; 2],
    /// The whole way, rad.
    stroke: f64,
    /// Whether the agonist is the wire that shortens.
    forward: bool,
    /// Whether the joint is left standing where it is.
    holding: bool,
    /// Whether both wires are being moved alike meanwhile: 1 to more tension, −1 to less, 0 not.
    changing: f64,
    integral: f64,
    reference: Trend,
    limited: bool,
    blind: bool,
}

impl JointLaw {
    /// Share of the maximum tension that can be asked for: above it less is heated.
    pub const MOST_TENSION: f64 = 1.0 - LIMIT_SHARE;

    /// The law for two wires in their nominal loads, agonist first.
    ///
    /// # Errors
    /// Parameters that the physics does not accept.
    pub fn new(models: [&WireModel; 2], settings: &JointSettings) -> Result<JointLaw, Error> {
        let mut settings = *settings;
        for side in [0, 1] {
            let sane = |duty: f64, other: f64| if duty.is_finite() { duty.clamp(0.0, 1.0) } else { other };
            settings.maximum_duty[side] = sane(settings.maximum_duty[side], 1.0);
            settings.minimum_duty[side] = sane(settings.minimum_duty[side], 0.0).min(settings.maximum_duty[side]);
        }
        Ok(JointLaw {
            maps: models.map(WireMap::new),
            inner: models.map(|model| 1.0 - model.material.outer_loop_weight),
            stroke: stroke_rad(&settings.joint, models)?,
            settings,
            forward: true,
            holding: false,
            changing: 0.0,
            integral: 0.0,
            reference: Trend::NONE,
            limited: false,
            blind: false,
        })
    }

    /// Forgets the past: as newly made.
    pub fn reset(&mut self) {
        (self.forward, self.integral, self.reference) = (true, 0.0, Trend::NONE);
        (self.holding, self.changing, self.limited, self.blind) = (false, 0.0, false, false);
    }

    /// Whether a limit of the tension had a say in the last cycle.
    pub fn is_limited(&self) -> bool {
        self.limited
    }

    /// Whether the last demand held a number that was none.
    pub fn is_blind(&self) -> bool {
        self.blind
    }

    /// The duties of agonist and antagonist for the next period, always between least and most. A demand that holds
    /// no number gets the least of both.
    #[inline]
    pub fn duties(&mut self, demand: &JointDemand) -> [f64; 2] {
        self.blind = !is_usable(demand);
        if self.blind {
            (self.integral, self.reference) = (0.0, Trend::NONE);
            return self.settings.minimum_duty;
        }
        let (seen, dt, stroke) = (&demand.estimate, demand.dt_s, self.stroke);
        let set_n = self.set_tension_n(demand.tension_n);
        self.reference.follow(demand.reference_rad, dt, MOST_SPEED * stroke);
        let Trend { rate, acceleration, .. } = self.reference;
        let acceleration = acceleration.clamp(-50.0 * MOST_SPEED * stroke, 50.0 * MOST_SPEED * stroke);
        let error = demand.reference_rad - seen.angle_rad;

        let asked = demand.tension_n.is_finite();
        let stands = if asked { STAND_UNTIL } else { HOLD_UNTIL };
        let within = if self.holding { stands } else { HOLD_WITHIN } * stroke;
        self.holding = rate == 0.0 && error.abs() <= within;
        if !self.holding {
            self.choose_direction(seen, rate, acceleration, error);
        }
        let direction = if self.forward { 1.0 } else { -1.0 };
        let (short, long) = if self.forward { (0, 1) } else { (1, 0) };
        let s = &self.settings;
        let (shortens, lengthens) = (&self.maps[short], &self.maps[long]);
        let (wire, other) = (&seen.wires[short], &seen.wires[long]);
        let below_heating = wire.heating_curve_c - wire.temperature_c;
        let above_cooling = other.temperature_c - other.cooling_curve_c;
        let tension = if seen.is_slack { 0.0 } else { 0.5 * (seen.tension_n[0] + seen.tension_n[1]) };

        // Speed wanted, in the direction of the motion.
        let arrived = (1.5 - 0.5 * above_cooling).clamp(0.0, 1.0);
        let most = (MOST_WAITING.0 + arrived * MOST_SPEED) * stroke + MOST_WAITING.1 * rate.abs();
        let wanted = rate + (ANGLE_RATE * error).clamp(-most, most) + self.integral;
        let speed = (wanted * direction).max(-MOST_BACK * stroke);

        // What the joint takes of the wires' pull, and how fast that changes: half of it on either side of the tension.
        let r = s.joint.radius_m;
        let speeding = acceleration + SPEED_RATE * (wanted - seen.rate_rad_s);
        let between = 0.5 * direction * (s.joint.spring_n_m * wanted + s.joint.damping_n_m_s * speeding) / r;

        // The wire that lengthens.
        let on_curve = Line::of(lengthens, other, phase_slope(other.martensite, lengthens.cooling_width));
        let line = {
            let on = (1.0 - above_cooling / ON_CURVE_K).clamp(0.0, 1.0);
            let inside = self.inner[long] * (-above_cooling.max(0.0) / lengthens.cooling_width).exp();
            let share = on + (1.0 - on) * inside;
            Line::of(lengthens, other, share * phase_slope(other.martensite, lengthens.cooling_width))
        };
        let rate_long = r * speed * lengthens.per_length;
        let most_towards = TENSION_K_PER_S * lengthens.heat_capacity * on_curve.b / on_curve.a * lengthens.area;
        let towards = (TENSION_RATE * (set_n - tension)).clamp(-most_towards, most_towards);
        let cross = CROSS_RATE * (above_cooling - CROSS_BEYOND_K.1).max(0.0) + ARRIVE_RATE * above_cooling.max(0.0);
        let least_heat = s.minimum_duty[long] * other.full_power_w - other.loss_w;
        // a wire that is to lengthen is not heated beyond its loss
        let mut heat_long = (on_curve.heat((towards - between) * lengthens.per_area, rate_long)
            - lengthens.heat_capacity * cross)
            .min(0.0)
            .max(least_heat);

        // How the tension rises with that, and what the other wire has to do.
        let mut rise = line.stress(rate_long, heat_long) * lengthens.area + between;
        let mut rate_short = r * speed * shortens.per_length;
        let most_rise = LIMIT_RATE * (s.maximum_tension_n - tension);
        let held_back = rise > most_rise;
        if held_back {
            rise = most_rise;
            let rate = line.a * (rise - between) * lengthens.per_area - line.b * heat_long;
            rate_short = rate.max(0.0) * lengthens.length * shortens.per_length;
        }
        let line = Line::of(shortens, wire, phase_slope(wire.martensite, shortens.heating_width));
        let mut heat_short = line.heat((rise + between) * shortens.per_area, -rate_short)
            + shortens.heat_capacity * CROSS_RATE * (below_heating - CROSS_BEYOND_K.0).max(0.0);

        // A standing joint leaves the tension free: both wires moved alike change it and not the angle.
        self.changing =
            if self.holding { self.change_standing(tension, set_n, asked, error.abs() / stroke) } else { 0.0 };
        if self.changing != 0.0 {
            let up = self.changing > 0.0;
            // to the heating curve to shorten, to the cooling curve to lengthen
            let off_curve = |wire: &Estimate| {
                if up { wire.heating_curve_c - wire.temperature_c } else { wire.temperature_c - wire.cooling_curve_c }
            };
            let ready = seen.wires.iter().all(|wire| off_curve(wire) < CHANGE_READY_K);
            let change = |m: &WireMap, wire: &Estimate, rate: f64| {
                let off = off_curve(wire);
                let heat = if ready {
                    let width = if up { m.heating_width } else { m.cooling_width };
                    let line = Line::of(m, wire, phase_slope(wire.martensite, width));
                    let heat = line.heat(self.changing * CHANGE_PA_PER_S, rate) * self.changing;
                    heat.max(0.0) + m.heat_capacity * ARRIVE_RATE * off
                } else if off < CHANGE_READY_K {
                    -m.heat_capacity * CROSS_RATE * (HOLD_INSIDE_K - off).max(0.0)
                } else {
                    m.heat_capacity * (CROSS_RATE * (off - CROSS_BEYOND_K.1).max(0.0) + ARRIVE_RATE * off)
                };
                heat * self.changing
            };
            let rate = r * ANGLE_RATE * CHANGE_SHARE * error * direction;
            heat_short = change(shortens, wire, -rate * shortens.per_length);
            heat_long = change(lengthens, other, rate * lengthens.per_length);
        } else if self.holding {
            let keep = |m: &WireMap, wire: &Estimate| {
                let low = wire.cooling_curve_c + HOLD_INSIDE_K;
                let high = wire.heating_curve_c - HOLD_INSIDE_K;
                m.heat_capacity * CROSS_RATE * (wire.temperature_c.max(low).min(high) - wire.temperature_c)
            };
            (heat_short, heat_long) = (keep(shortens, wire), keep(lengthens, other));
        }

        // Anti-slack: as far as tension is missing, both are brought to where they shorten, and shorten. Slack wires turn
        // nothing, so what the angle wants is of no account then.
        let missing = (1.0 - tension / s.minimum_tension_n).clamp(0.0, 1.0);
        if missing > 0.0 {
            let tauten = |m: &WireMap, wire: &Estimate| {
                let below = wire.heating_curve_c - wire.temperature_c;
                let moving = m.heat_capacity + wire.release_j * phase_slope(wire.martensite, m.heating_width);
                missing * (m.heat_capacity * CROSS_RATE * below + moving * TAUTEN_K_PER_S)
            };
            let (short_taut, long_taut) = (tauten(shortens, wire), tauten(lengthens, other));
            let slack = missing == 1.0;
            heat_short = if slack { short_taut } else { heat_short.max(short_taut) };
            heat_long = if slack { long_taut } else { heat_long.max(long_taut) };
        }

        // Anti-overload: near the limit less is heated beyond the loss, at the limit nothing is, and above it nothing at all.
        let room = (s.maximum_tension_n - tension) / (LIMIT_SHARE * s.maximum_tension_n);
        let (room, above) = (room.clamp(0.0, 1.0), (-room).clamp(0.0, 1.0));
        let give = |heat: f64, wire: &Estimate, side: usize| {
            let (least, most) = (s.minimum_duty[side], s.maximum_duty[side]);
            let heat = if heat > 0.0 { room * heat } else { heat };
            let duty = (1.0 - above) * (heat + wire.loss_w) / wire.full_power_w;
            // in this order a NaN becomes the least
            duty.max(least).min(most)
        };
        let mut duties = [0.0; 2];
        duties[short] = give(heat_short, wire, short);
        duties[long] = give(heat_long, other, long);
        self.limited = room < 1.0 || missing > 0.0 || held_back;

        // Integral action only while both wires can answer to it.
        let full = duties[short] >= s.maximum_duty[short] || self.limited;
        if !self.holding && arrived > 0.5 && below_heating < 2.0 && !(full && error * direction > 0.0) {
            let most = MOST_INTEGRAL * stroke;
            self.integral = (self.integral + INTEGRAL_RATE * ANGLE_RATE * error * dt).clamp(-most, most);
        }
        duties
    }

    /// The tension to keep, N: what is asked for within the limits.
    fn set_tension_n(&self, asked_n: f64) -> f64 {
        let s = &self.settings;
        let most = Self::MOST_TENSION * s.maximum_tension_n;
        // in this order a NaN is the settings' own
        if asked_n.is_finite() { asked_n.max(s.minimum_tension_n).min(most) } else { s.tension_n }
    }

    /// Which way both wires of a standing joint are to be moved: 1 to more tension, −1 to less, 0 not at all. `off` is the
    /// error in strokes: it is made good on whichever side of the set value the tension has room.
    fn change_standing(&self, tension: f64, set_n: f64, asked: bool, off: f64) -> f64 {
        let (from, until) = if asked { (1.0 + FORCE_WITHIN, 1.0) } else { (RELAX_FROM, RELAX_UNTIL) };
        let above = if self.changing < 0.0 { until } else { from };
        let below = if self.changing > 0.0 { 1.0 } else { 1.0 - FORCE_WITHIN };
        if tension > above * set_n {
            return -1.0;
        }
        if asked && tension < below * set_n {
            return 1.0;
        }
        if off <= if self.changing == 0.0 { HOLD_UNTIL } else { HOLD_WITHIN } {
            return 0.0;
        }
        // on as it was, unless the tension has left what it may be taken to
        if self.changing < 0.0 && tension > (1.0 - STAND_ROOM) * set_n {
            -1.0
        } else if self.changing > 0.0 && tension < (1.0 + STAND_ROOM) * set_n {
            1.0
        } else if tension > set_n {
            -1.0
        } else {
            1.0
        }
    }

    /// Which wire is to shorten. A turn is seen coming by the time that its wire takes to its heating curve.
    fn choose_direction(&mut self, seen: &JointEstimate, rate: f64, acceleration: f64, error: f64) {
        let next = usize::from(self.forward);
        let (m, wire) = (&self.maps[next], &seen.wires[next]);
        let heat = (self.settings.maximum_duty[next] * wire.full_power_w - wire.loss_w).max(1e-9);
        let crossing_s = m.heat_capacity * (wire.heating_curve_c - wire.temperature_c).max(0.0) / heat;
        let zone = TURN_ERROR * self.stroke;
        let beyond = error - error.clamp(-zone, zone);
        let ahead = rate + acceleration * crossing_s.min(MOST_AHEAD_S) + ANGLE_RATE * beyond;
        if self.forward && ahead < -TURN_SPEED * self.stroke {
            self.forward = false;
        } else if !self.forward && ahead > TURN_SPEED * self.stroke {
            self.forward = true;
        }
    }
}

/// −dξ/dϑ on an outer curve (eq. 20), 1/K; kept away from 0, where nothing could be moved.
fn phase_slope(martensite: f64, width: f64) -> f64 {
    let xi = martensite.clamp(0.03, 0.97);
    xi * (1.0 - xi) / width
}

fn is_usable(demand: &JointDemand) -> bool {
    let usable = |value: f64| value.abs() < 1e9;
    let seen = &demand.estimate;
    usable(demand.reference_rad)
        && demand.dt_s > 0.0
        && usable(demand.dt_s)
        && usable(seen.angle_rad)
        && usable(seen.rate_rad_s)
        && seen.tension_n.iter().all(|tension| usable(*tension))
        && seen.wires.iter().all(|wire| usable(wire.temperature_c) && wire.full_power_w > 0.0)
}
