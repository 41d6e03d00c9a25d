//! Angle, tension, temperatures and phases of a pair of wires on one joint, from both lengths, resistances and powers.
//!
//! Two lengths measure the same angle twice; the tension is not measured. It follows from the wires' constitutive
//! law: a wire whose phase and temperature are known has just one stress at a given length (eq. 23). So the observer runs
//! the reference model of both wires on the joint's own equation of motion, fed with the measured powers, and corrects it by
//! the innovations:
//! - The angle by the mean of both measured angles, each weighted by its noise. The model predicts the joint's motion, so
//!   the filter can be slow without lagging: noise of a length never reaches a wire's hysteresis.
//! - The temperatures by the same innovation, of the wire that is on the curve it would have to move along.
//! - The phases, where the innovation stays larger than noise: inside the hysteresis the model's memory is wrong.
//! - Each temperature by the wire's resistance (eq. 36): the only measurement of an error common to both wires. A repeated
//!   correction of this kind is attributed to a loss to the air other than the model's.

use super::stroke::stroke_rad;
use crate::cycle::{self, COLDEST_C, Curves, HOTTEST_C};
use crate::estimate::{Estimate, Observation};
use crate::wire_map::WireMap;
use sinew_physics::{Drive, DriveKind, Effects, Error, Inputs, Joint, Load, Material, Wire, WireModel};

/// Rate at which the angle follows what is measured, 1/s; and that of slack wires, which the model knows nothing of.
const ANGLE_RATE: f64 = 25.0;
const SLACK_RATE: f64 = 100.0;
/// Rate at which the temperatures follow a surprise of the angle, 1/s.
const SURPRISE_RATE: f64 = 20.0;
/// Within this of its curve a wire counts as standing on it, K: wholly at the first, no longer at the second.
const ON_CURVE_K: f64 = 0.5;
const OFF_CURVE_K: f64 = 1.5;
/// Rate at which a temperature follows the wire's resistance, 1/s.
const RESISTANCE_RATE: f64 = 1.0;
/// Rate at which the surprise is averaged before the phases are doubted, and at which they are corrected then, 1/s.
const DOUBT_RATE: f64 = 25.0;
const PHASE_RATE: f64 = 50.0;
/// An average surprise up to this share of the stroke, and so many of its standard deviations, is no reason for doubt.
const DOUBT_STROKE: f64 = 0.002;
const DOUBT_SIGMA: f64 = 4.0;
/// How much a kelvin of correction by the resistance changes the estimated loss, 1/K, and how far it can.
const LOSS_PER_K: f64 = 0.01;
const LEAST_LOSS_SCALE: f64 = 0.4;
const MOST_LOSS_SCALE: f64 = 2.5;
/// Fastest that evidence moves a temperature, K/s.
const MOST_K_PER_S: f64 = 200.0;
/// Rate at which the slack is averaged, 1/s, and from which share of the stroke on it is one.
const SLACK_AVERAGE: f64 = 10.0;
const SLACK_STROKE: f64 = 0.02;
/// Stress at which the sensitivity of the angle to temperature is reckoned, Pa.
const MIDDLE_PA: f64 = 300e6;

/// The estimate of a joint and its wires.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointEstimate {
    /// Angle θ, in rad, positive where the agonist is shorter.
    pub angle_rad: f64,
    /// Its rate, in rad/s.
    pub rate_rad_s: f64,
    /// Tension of agonist and antagonist, in N.
    pub tension_n: [f64; 2],
    /// How much longer both wires together measure than the joint holds their ends apart, in m; averaged over 0.1 s.
    pub slack_m: f64,
    /// Whether that is so much that a wire hangs slack.
    pub is_slack: bool,
    /// The wires, agonist first.
    pub wires: [Estimate; 2],
}

/// One wire of the pair.
#[derive(Debug, Clone)]
struct Side {
    map: WireMap,
    wire: Wire,
    inputs: Inputs,
    /// Elongation at angle 0, m.
    rest: f64,
    /// Change of strain per kelvin of a wire that transforms, latent heat paid, 1/K.
    strain_per_k: f64,
    full_power: f64,
    loss_scale: f64,
    hottest: f64,
}

impl Side {
    fn stiffness(&self) -> f64 {
        if self.wire.tension_n() > 0.0 { self.map.stiffness(self.wire.martensite()) } else { 0.0 }
    }

    /// Elongation that a measured length says, m; `None` for a length no wire can have.
    fn elongation(&self, length_m: f64) -> Option<f64> {
        let elongation = length_m - self.map.length;
        (elongation.abs() < self.map.length).then_some(elongation)
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct JointObserver {
    joint: Joint,
    sides: [Side; 2],
    /// The wires as they started.
    fresh: [Wire; 2],
    stroke: f64,
    angle: f64,
    rate: f64,
    /// Average of what the measured angle is off the predicted one, rad.
    doubt: f64,
    slack: f64,
    /// Whether an angle has come yet.
    seen: bool,
}

impl JointObserver {
    /// An observer for two wires in their nominal loads, agonist first; effects beyond the reference model are left out.
    ///
    /// # Errors
    /// Parameters that the physics does not accept.
    pub fn new(joint: &Joint, models: [&WireModel; 2]) -> Result<JointObserver, Error> {
        joint.validate(models)?;
        let rest = joint.rest_m(models)?;
        let side = |model: &WireModel, rest: f64| -> Result<Side, Error> {
            let map = WireMap::new(model);
            let model = WireModel {
                load: Load::ImposedPosition,
                drive: Drive { kind: DriveKind::Power, ..model.drive },
                // nor what it would have to remember to be corrected
                material: Material { detwinning: None, ..model.material },
                effects: Effects::default(),
                ..model.clone()
            };
            let inputs = Inputs { imposed: rest, ..model.rest_inputs() };
            let slope = 0.25 / map.heating_width;
            let strain_per_k = map.strain * slope / (1.0 + slope * map.release(MIDDLE_PA) * map.per_heat_capacity);
            let wire = Wire::with_inputs(&model, &inputs)?;
            Ok(Side {
                full_power: map.full_power,
                hottest: wire.temperature_c(),
                strain_per_k: strain_per_k.max(1e-9),
                map,
                wire,
                inputs,
                rest,
                loss_scale: 1.0,
            })
        };
        let sides = [side(models[0], rest[0])?, side(models[1], rest[1])?];
        Ok(JointObserver {
            joint: *joint,
            fresh: sides.each_ref().map(|side| side.wire.clone()),
            stroke: stroke_rad(joint, models)?,
            sides,
            angle: 0.0,
            rate: 0.0,
            doubt: 0.0,
            slack: 0.0,
            seen: false,
        })
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        for (side, fresh) in self.sides.iter_mut().zip(&self.fresh) {
            side.wire.clone_from(fresh);
            side.hottest = fresh.temperature_c();
            (side.loss_scale, side.full_power) = (1.0, side.map.full_power);
        }
        (self.angle, self.rate, self.doubt, self.slack, self.seen) = (0.0, 0.0, 0.0, 0.0, false);
    }

    /// Takes one cycle of both wires in, agonist first. Their tensions are not read: they are what is looked for.
    #[inline]
    pub fn update(&mut self, seen: [&Observation; 2]) -> JointEstimate {
        cycle::in_steps(seen, |seen, dt| self.step(seen, dt))
    }

    #[inline]
    fn step(&mut self, seen: [&Observation; 2], dt: f64) -> JointEstimate {
        let taut = self.sides.iter().all(|side| side.wire.tension_n() > 0.0);
        let predicted = self.predict(dt);
        let (surprise, sigma) = self.surprise(seen, predicted, dt);
        let follow = if taut { ANGLE_RATE } else { SLACK_RATE };
        self.angle = predicted + (follow * dt).min(1.0) * surprise;

        self.doubt += (DOUBT_RATE * dt).min(1.0) * (surprise - self.doubt);
        let credible = DOUBT_STROKE * self.stroke + DOUBT_SIGMA * sigma * (0.5 * DOUBT_RATE * dt).sqrt();
        let beyond = if taut { self.doubt - self.doubt.clamp(-credible, credible) } else { 0.0 };
        let surprise = if taut { surprise } else { 0.0 };
        let r = self.joint.radius_m;
        let (angle, rate) = (self.angle, self.rate);
        let mut wires = [Estimate::UNKNOWN; 2];
        for (index, side) in self.sides.iter_mut().enumerate() {
            let shortens = if index == 0 { r } else { -r };
            wires[index] = side.update(seen[index], dt, shortens * surprise, shortens * beyond, shortens * angle);
            wires[index].velocity_m_s = -shortens * rate;
        }
        if !self.is_sane() {
            // inputs that no joint gives: forget what they did rather than pass it on
            self.reset();
            wires = self.sides.each_mut().map(|side| side.update(&Observation::nothing(0.0, 0.0), 0.0, 0.0, 0.0, 0.0));
        }
        let noise = sigma * r * (SLACK_AVERAGE * dt).sqrt();
        JointEstimate {
            angle_rad: self.angle,
            rate_rad_s: self.rate,
            tension_n: self.sides.each_ref().map(|side| side.wire.tension_n()),
            slack_m: self.slack,
            is_slack: self.slack > SLACK_STROKE * self.stroke * r + 5.0 * noise,
            wires,
        }
    }

    /// Whether what it believes are numbers.
    #[inline]
    fn is_sane(&self) -> bool {
        let of_wire = |side: &Side| side.wire.temperature_c().is_finite() && side.wire.tension_n().is_finite();
        self.angle.is_finite() && self.rate.is_finite() && self.slack.is_finite() && self.sides.iter().all(of_wire)
    }

    /// The angle after `dt` by the joint's own equation; implicit, because the wires' stiffness is far faster than a period.
    fn predict(&mut self, dt: f64) -> f64 {
        if dt <= 0.0 {
            return self.angle;
        }
        let (j, [agonist, antagonist]) = (&self.joint, &self.sides);
        let torque = j.radius_m * (agonist.wire.tension_n() - antagonist.wire.tension_n()) + j.torque_n_m
            - j.spring_n_m * self.angle;
        let stiffness = j.radius_m * j.radius_m * (agonist.stiffness() + antagonist.stiffness()) + j.spring_n_m;
        let inertia = j.inertia_kg_m2 / dt;
        self.rate = (inertia * self.rate + torque) / (inertia + j.damping_n_m_s + stiffness * dt);
        self.angle + self.rate * dt
    }

    /// What the measured angle is off the predicted one, and its standard deviation, rad; 0 without a measurement.
    fn surprise(&mut self, seen: [&Observation; 2], predicted: f64, dt: f64) -> (f64, f64) {
        let per_radius = 1.0 / self.joint.radius_m;
        let (mut sum, mut weights, mut longer, mut count) = (0.0, 0.0, 0.0, 0);
        for (index, (side, seen)) in self.sides.iter().zip(seen).enumerate() {
            let Some(elongation) = side.elongation(seen.length_m) else { continue };
            let shortens = if index == 0 { -per_radius } else { per_radius };
            // an unknown noise is assumed to be a hundredth of the stroke
            let sigma =
                if seen.length_sigma_m.is_finite() { seen.length_sigma_m * per_radius } else { 0.01 * self.stroke };
            let weight = 1.0 / (sigma * sigma).max(1e-18);
            sum += weight * shortens * (elongation - side.rest);
            weights += weight;
            longer += elongation - side.rest;
            count += 1;
        }
        if count == 0 {
            return (0.0, 0.0);
        }
        if count == 2 {
            self.slack += (SLACK_AVERAGE * dt).min(1.0) * (longer - self.slack);
        }
        let measured = sum / weights;
        if !self.seen {
            (self.seen, self.angle) = (true, measured);
            return (measured - predicted, 0.0);
        }
        (measured - predicted, 1.0 / weights.sqrt())
    }
}

impl Side {
    /// One cycle of one wire. `shorter` and `beyond` say how much shorter it was found than predicted, in m: in this cycle,
    /// and on average beyond what noise makes; `shortened` is how much shorter than at angle 0 the joint now holds it.
    fn update(&mut self, seen: &Observation, dt: f64, shorter: f64, beyond: f64, shortened: f64) -> Estimate {
        let m = &self.map;
        let power = cycle::power(m, seen, || m.full_power);
        self.full_power = cycle::full_power(m, seen, power, self.full_power);
        let (temperature, martensite) = (self.wire.temperature_c(), self.wire.martensite());
        let (stress, elongation) = (self.wire.stress_pa(), self.wire.position_m());

        // How much too cold the model is, as a rate: by the angle, if the wire stands on the curve it has to move along …
        let curves = Curves::at(m, martensite, stress);
        let inside = if shorter > 0.0 { curves.heating_c - temperature } else { temperature - curves.cooling_c };
        let on_curve = ((OFF_CURVE_K - inside) / (OFF_CURVE_K - ON_CURVE_K)).clamp(0.0, 1.0);
        let mut warmer = 0.5 * SURPRISE_RATE * on_curve * shorter * m.per_length / self.strain_per_k;
        // … and by the resistance.
        if seen.resistance_ohm > 0.0 && seen.resistance_ohm.is_finite() {
            let ohm_per_k = m.resistance(martensite, temperature + 1.0, elongation)
                - m.resistance(martensite, temperature, elongation);
            if ohm_per_k.abs() > 1e-9 {
                let cold = ((seen.resistance_ohm - self.wire.resistance_ohm()) / ohm_per_k).clamp(-50.0, 50.0);
                let step = (RESISTANCE_RATE * dt).min(1.0) * cold;
                warmer += RESISTANCE_RATE * cold;
                self.loss_scale = (self.loss_scale - LOSS_PER_K * step).clamp(LEAST_LOSS_SCALE, MOST_LOSS_SCALE);
            }
        }
        let warmer = warmer.clamp(-MOST_K_PER_S, MOST_K_PER_S);

        if beyond != 0.0 {
            let strain_per_fraction = m.strain + (m.compliance_m - m.compliance_a) * stress;
            let fraction = -beyond * m.per_length / strain_per_fraction.max(1e-4);
            self.wire.correct(0.0, (PHASE_RATE * dt).min(1.0) * fraction);
        }
        // The model's own loss is that of the rig file; the estimated difference is added as power, as is a correction.
        let less_loss = (1.0 - self.loss_scale) * m.loss * (temperature - m.ambient);
        let drive = power + less_loss + m.heat_capacity * warmer;
        self.wire.step(&Inputs { drive, imposed: self.rest - shortened, ..self.inputs }, dt);

        let temperature = self.wire.temperature_c().clamp(COLDEST_C, HOTTEST_C);
        if temperature != self.wire.temperature_c() {
            self.wire.correct(temperature - self.wire.temperature_c(), 0.0);
        }
        let (martensite, stress) = (self.wire.martensite(), self.wire.stress_pa());
        self.hottest = cycle::hottest(m, self.hottest, power, dt, temperature);
        let curves = Curves::at(m, martensite, stress);
        Estimate {
            temperature_c: temperature,
            martensite,
            hottest_c: self.hottest,
            stress_pa: stress,
            heating_curve_c: curves.heating_c,
            cooling_curve_c: curves.cooling_c,
            length_m: m.length + self.rest - shortened,
            loss_w: self.loss_scale * m.loss * (temperature - m.ambient),
            // it is learned without a measure of how well
            loss_sigma_w: f64::NAN,
            release_j: m.release(stress),
            full_power_w: self.full_power,
            velocity_m_s: f64::NAN,
        }
    }
}
