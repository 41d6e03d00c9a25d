//! Angle and tension decoupled on the model of both wires: the law a joint has by default.
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
//! Tension is kept at its set value by how fast the lengthening wire is released; above the upper limit nothing is heated
//! (anti-overload), below the lower one both wires are (anti-slack). A resting joint with too much tension releases both wires
//! alike; with a commanded tension it moves them alike until it is reached.

use super::demand::{JointDemand, PairLaw};
use super::observer::JointEstimate;
use super::setup::{JointSettings, PairSetup};
use super::tension::{CROSS_RATE, TensionBounds, mean_tension_n, phase_slope, tautening};
use crate::estimate::Estimate;
use crate::wire_map::WireMap;

/// Rate at which an error of the angle is made good, 1/s.
const ANGLE_RATE: f64 = 50.0;
/// Rate at which a wrong speed of the joint is made good, 1/s.
const SPEED_RATE: f64 = 100.0;
/// Rate of the integral action, 1/s, and the most it adds, strokes per second.
const INTEGRAL_RATE: f64 = 1.0;
const MOST_INTEGRAL: f64 = 0.05;
/// While the lengthening wire is not on its curve yet: the most speed that is asked for to make an error good, strokes per
/// second, and share of the reference's own speed. More would only be stored as tension, and let go at once.
const MOST_WAITING: f64 = 0.3;
const MOST_WAITING_SHARE: f64 = 0.5;
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
/// From how far off the heating and the cooling curve a wire is brought there at [`CROSS_RATE`], K.
const CROSS_BEYOND_HEATING_K: f64 = 0.3;
const CROSS_BEYOND_COOLING_K: f64 = 4.0;
/// Rate of the last part of the way to the cooling curve, 1/s: the wire lets go when it arrives.
const ARRIVE_RATE: f64 = 10.0;
/// Within this of its curve the lengthening wire counts as on it, K.
const ON_CURVE_K: f64 = 0.3;
/// Longest time that the crossing is begun before the motion turns, s.
const MOST_AHEAD_S: f64 = 0.1;
/// Rate at which tension is brought to its set value, 1/s, and the most that costs of a wire's temperature, K/s.
const TENSION_RATE: f64 = 2.0;
const TENSION_K_PER_S: f64 = 50.0;
/// Rate at which tension is kept from its upper limit, 1/s.
const LIMIT_RATE: f64 = 20.0;
/// A reference that stands still for so long has stopped, s; one that moves after that has stepped.
const REFERENCE_STOPS_S: f64 = 0.05;
/// Time over which the reference's acceleration is averaged, s.
const REFERENCE_SMOOTH_S: f64 = 0.01;

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

/// One wire of the pair in this cycle.
#[derive(Debug, Clone, Copy)]
struct Pulling<'a> {
    /// 0 = agonist.
    side: usize,
    map: &'a WireMap,
    seen: &'a Estimate,
}

impl Pulling<'_> {
    /// How far below its heating curve it is, K.
    fn below_heating(&self) -> f64 {
        self.seen.heating_curve_c - self.seen.temperature_c
    }

    /// How far above its cooling curve it is, K.
    fn above_cooling(&self) -> f64 {
        self.seen.temperature_c - self.seen.cooling_curve_c
    }

    /// Its line where its phase changes with `share` of the slope of an outer curve of this width.
    #[inline]
    fn line(&self, share: f64, width: f64) -> Line {
        Line::of(self.map, self.seen, share * phase_slope(self.seen.martensite, width))
    }

    /// Power that keeps it inside its hysteresis, W.
    fn kept(&self) -> f64 {
        let low = self.seen.cooling_curve_c + HOLD_INSIDE_K;
        let high = self.seen.heating_curve_c - HOLD_INSIDE_K;
        let inside = self.seen.temperature_c.max(low).min(high);
        self.map.heat_capacity * CROSS_RATE * (inside - self.seen.temperature_c)
    }

    /// How far it is off the curve it changes its tension along, K: the heating curve to shorten, the cooling curve to lengthen.
    fn off_curve(&self, up: bool) -> f64 {
        if up { self.below_heating() } else { self.above_cooling() }
    }

    /// Power that moves it along that curve while it lengthens at `rate` for the angle's sake, W; until both wires are `ready`,
    /// power that brings it there. `way` = 1 to more tension, −1 to less.
    fn changing(&self, way: f64, ready: bool, rate: f64) -> f64 {
        let (m, up) = (self.map, way > 0.0);
        let off = self.off_curve(up);
        let heat = if ready {
            let line = self.line(1.0, if up { m.heating_width } else { m.cooling_width });
            let heat = line.heat(way * CHANGE_PA_PER_S, rate) * way;
            heat.max(0.0) + m.heat_capacity * ARRIVE_RATE * off
        } else if off < CHANGE_READY_K {
            -m.heat_capacity * CROSS_RATE * (HOLD_INSIDE_K - off).max(0.0)
        } else {
            m.heat_capacity * (CROSS_RATE * (off - CROSS_BEYOND_COOLING_K).max(0.0) + ARRIVE_RATE * off)
        };
        heat * way
    }
}

/// Powers beyond the loss of the wire that shortens and of the one that lengthens, W.
#[derive(Debug, Clone, Copy)]
struct Heat {
    short: f64,
    long: f64,
}

/// The motion wanted of the joint.
#[derive(Debug, Clone, Copy)]
struct Wanted {
    /// In the direction of the motion, rad/s.
    speed: f64,
    /// How fast what the joint itself takes of the wires' pull changes: half of it on either side of the tension, N/s.
    between: f64,
    /// How far the wire that lengthens has come to its curve, 0 to 1.
    arrived: f64,
}

/// Both wires by what the motion asks of them.
#[derive(Debug, Clone, Copy)]
struct Pair<'a> {
    /// The wire that shortens.
    short: Pulling<'a>,
    /// The wire that lengthens.
    long: Pulling<'a>,
    /// 1 where the agonist is the one that shortens, else −1.
    direction: f64,
    /// The mean of both tensions, N; 0 while a wire hangs slack.
    tension: f64,
}

impl<'a> Pair<'a> {
    fn of(maps: &'a [WireMap; 2], seen: &'a JointEstimate, forward: bool) -> Pair<'a> {
        let (short, long) = if forward { (0, 1) } else { (1, 0) };
        let pulling = |side: usize| Pulling { side, map: &maps[side], seen: &seen.wires[side] };
        Pair {
            short: pulling(short),
            long: pulling(long),
            direction: if forward { 1.0 } else { -1.0 },
            tension: mean_tension_n(seen),
        }
    }

    /// Powers that move both wires of a standing joint alike, and one a little more, at `rate` in m/s for the angle's sake.
    fn changing(&self, way: f64, rate: f64) -> Heat {
        let ready = [self.short, self.long].iter().all(|wire| wire.off_curve(way > 0.0) < CHANGE_READY_K);
        Heat {
            short: self.short.changing(way, ready, -rate * self.short.map.per_length),
            long: self.long.changing(way, ready, rate * self.long.map.per_length),
        }
    }

    /// The same powers, but no less than what tightens wires that lack `missing` of the least tension; wires that hang slack turn
    /// nothing, so that what the angle wants is of no account then.
    fn tautened(&self, heat: Heat, missing: f64) -> Heat {
        let missing_of = |wire: &Pulling| missing * tautening(wire.map, wire.seen);
        let (short, long) = (missing_of(&self.short), missing_of(&self.long));
        if missing == 1.0 {
            Heat { short, long }
        } else {
            Heat { short: heat.short.max(short), long: heat.long.max(long) }
        }
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Decoupling {
    settings: JointSettings,
    bounds: TensionBounds,
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
}

impl PairLaw for Decoupling {
    #[inline]
    fn duties(&mut self, demand: &JointDemand) -> Option<[f64; 2]> {
        if !demand.is_usable() {
            (self.integral, self.reference) = (0.0, Trend::NONE);
            return None;
        }
        let (seen, dt, stroke) = (&demand.estimate, demand.dt_s, self.stroke);
        let set_n = self.settings.set_tension_n(demand.tension_n);
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
        let pair = Pair::of(&self.maps, seen, self.forward);
        let wanted = self.wanted(&pair, seen, Trend { acceleration, ..self.reference }, error);
        let (mut heat, held_back) = self.moving(&pair, &wanted, set_n);

        // A standing joint leaves the tension free: both wires moved alike change it and not the angle.
        self.changing =
            if self.holding { self.change_standing(pair.tension, set_n, asked, error.abs() / stroke) } else { 0.0 };
        if self.changing != 0.0 {
            let rate = self.settings.joint.radius_m * ANGLE_RATE * CHANGE_SHARE * error * pair.direction;
            heat = pair.changing(self.changing, rate);
        } else if self.holding {
            heat = Heat { short: pair.short.kept(), long: pair.long.kept() };
        }

        // Anti-slack: as far as tension is missing, both are brought to where they shorten, and shorten.
        let missing = self.bounds.missing(pair.tension);
        if missing > 0.0 {
            heat = pair.tautened(heat, missing);
        }

        // Anti-overload: near the limit less is heated beyond the loss, at the limit nothing is, and above it nothing at all.
        let room = self.bounds.room(pair.tension);
        let given = |wire: &Pulling, heat: f64| self.bounds.given(wire.side, wire.seen, heat, room);
        let (short, long) = (given(&pair.short, heat.short), given(&pair.long, heat.long));
        self.limited = room < 1.0 || missing > 0.0 || held_back;

        // Integral action only while both wires can answer to it.
        let full = short >= self.settings.maximum_duty[pair.short.side] || self.limited;
        let answers = wanted.arrived > 0.5 && pair.short.below_heating() < 2.0;
        if !self.holding && answers && !(full && error * pair.direction > 0.0) {
            let most = MOST_INTEGRAL * stroke;
            self.integral = (self.integral + INTEGRAL_RATE * ANGLE_RATE * error * dt).clamp(-most, most);
        }
        Some(if self.forward { [short, long] } else { [long, short] })
    }

    fn reset(&mut self) {
        (self.forward, self.integral, self.reference) = (true, 0.0, Trend::NONE);
        (self.holding, self.changing, self.limited) = (false, 0.0, false);
    }

    fn is_limited(&self) -> bool {
        self.limited
    }
}

impl Decoupling {
    pub fn new(setup: &PairSetup<'_>) -> Decoupling {
        Decoupling {
            settings: setup.settings,
            bounds: TensionBounds::of(&setup.settings),
            maps: setup.maps,
            inner: setup.models.map(|model| 1.0 - model.material.outer_loop_weight),
            stroke: setup.stroke_rad,
            forward: true,
            holding: false,
            changing: 0.0,
            integral: 0.0,
            reference: Trend::NONE,
            limited: false,
        }
    }

    /// The motion wanted of the joint.
    #[inline]
    fn wanted(&self, pair: &Pair, seen: &JointEstimate, reference: Trend, error: f64) -> Wanted {
        let (stroke, rate, joint) = (self.stroke, reference.rate, &self.settings.joint);
        let arrived = (1.5 - 0.5 * pair.long.above_cooling()).clamp(0.0, 1.0);
        let most = (MOST_WAITING + arrived * MOST_SPEED) * stroke + MOST_WAITING_SHARE * rate.abs();
        let wanted = rate + (ANGLE_RATE * error).clamp(-most, most) + self.integral;
        // what the joint takes of the wires' pull, and how fast that changes
        let speeding = reference.acceleration + SPEED_RATE * (wanted - seen.rate_rad_s);
        Wanted {
            speed: (wanted * pair.direction).max(-MOST_BACK * stroke),
            between: 0.5 * pair.direction * (joint.spring_n_m * wanted + joint.damping_n_m_s * speeding)
                / joint.radius_m,
            arrived,
        }
    }

    /// The powers beyond the loss that move the joint as wanted and bring its tension to `set_n`, and whether the upper limit of
    /// the tension held the motion back.
    #[inline]
    fn moving(&self, pair: &Pair, wanted: &Wanted, set_n: f64) -> (Heat, bool) {
        let s = &self.settings;
        let (shortens, lengthens) = (pair.short.map, pair.long.map);
        let (r, tension, Wanted { speed, between, .. }) = (s.joint.radius_m, pair.tension, *wanted);

        // The wire that lengthens.
        let above_cooling = pair.long.above_cooling();
        let on_curve = pair.long.line(1.0, lengthens.cooling_width);
        let line = {
            let on = (1.0 - above_cooling / ON_CURVE_K).clamp(0.0, 1.0);
            let inside = self.inner[pair.long.side] * (-above_cooling.max(0.0) / lengthens.cooling_width).exp();
            pair.long.line(on + (1.0 - on) * inside, lengthens.cooling_width)
        };
        let rate_long = r * speed * lengthens.per_length;
        let most_towards = TENSION_K_PER_S * lengthens.heat_capacity * on_curve.b / on_curve.a * lengthens.area;
        let towards = (TENSION_RATE * (set_n - tension)).clamp(-most_towards, most_towards);
        let cross =
            CROSS_RATE * (above_cooling - CROSS_BEYOND_COOLING_K).max(0.0) + ARRIVE_RATE * above_cooling.max(0.0);
        let least_heat = s.minimum_duty[pair.long.side] * pair.long.seen.full_power_w - pair.long.seen.loss_w;
        // a wire that is to lengthen is not heated beyond its loss
        let long = (on_curve.heat((towards - between) * lengthens.per_area, rate_long)
            - lengthens.heat_capacity * cross)
            .min(0.0)
            .max(least_heat);

        // How the tension rises with that, and what the other wire has to do.
        let mut rise = line.stress(rate_long, long) * lengthens.area + between;
        let mut rate_short = r * speed * shortens.per_length;
        let most_rise = LIMIT_RATE * (s.maximum_tension_n - tension);
        let held_back = rise > most_rise;
        if held_back {
            rise = most_rise;
            let rate = line.a * (rise - between) * lengthens.per_area - line.b * long;
            rate_short = rate.max(0.0) * lengthens.length * shortens.per_length;
        }
        let line = pair.short.line(1.0, shortens.heating_width);
        let short = line.heat((rise + between) * shortens.per_area, -rate_short)
            + shortens.heat_capacity * CROSS_RATE * (pair.short.below_heating() - CROSS_BEYOND_HEATING_K).max(0.0);
        (Heat { short, long }, held_back)
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
