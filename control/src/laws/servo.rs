//! Robust servo on the exact velocity linearisation (chapter 10, eq. 60–65).
//!
//! Differentiated once, the wire in its load is linear in (ẋ, ẍ, Ṫ) with coefficients that vary with ∂ξ/∂T alone (eq. 63); with the
//! error beside them (eq. 64) a linear-quadratic regulator finds Ṗ = −K (x_ref − x, ẋ, ẍ, Ṫ). It is integrated as it stands, step by
//! step: ΔP = −K ((x_ref − x) Δt, Δx, Δẋ, ΔT) differentiates nothing but states and is eq. 65 where K is constant. P itself is
//! what is limited, so that there is no windup, and gain changes are bumpless.
//!
//! The static servo is the thesis': temperature alone changes the phase. It overshoots by a quarter, and scheduling its gains alone
//! hardly improves that: it does not model that the load's drag lets the wire lag behind its temperature (eq. 12 and 51).
//! So the scheduled servo is designed on all couplings of the reference model.

use super::linearised::CONSTANT_SLOPE_PER_K;
use crate::demand::{Demand, Law, Range};
use crate::lpv::{Coupling, LpvModel, OperatingPoint};
use crate::wire_map::WireMap;
use sinew_physics::WireModel;
use sinew_state_space::DMatrix;
use sinew_state_space::riccati::lqr;
use sinew_state_space::servo::augment;

/// Flattest |∂ξ/∂T| that the gains are scheduled to, in shares of the steepest. Below they keep: gains for a wire that answers
/// nothing let power pile up that it does answer to when its transformation begins.
const FLATTEST: f64 = 0.4;
/// Points of the schedule.
const POINTS: usize = 17;

/// The gains K of Ṗ = −K (x_ref − x, ẋ, ẍ, Ṫ).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gains {
    /// On the error x_ref − x, W/(m s).
    error: f64,
    /// On ẋ, W/m.
    velocity: f64,
    /// On ẍ, W s/m.
    acceleration: f64,
    /// On Ṫ, W/K.
    temperature_rate: f64,
}

impl Gains {
    const NONE: Gains = Gains { error: 0.0, velocity: 0.0, acceleration: 0.0, temperature_rate: 0.0 };
}

/// The power asked for, and the state it was asked for at.
#[derive(Debug, Clone, Copy)]
struct Asked {
    power_w: f64,
    length_m: f64,
    velocity_m_s: f64,
    temperature_c: f64,
}

/// Which ∂ξ/∂T the gains are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Schedule {
    /// [`CONSTANT_SLOPE_PER_K`], always.
    Static,
    /// That of the branch of the hysteresis the wire is on, as estimated.
    Scheduled,
}

/// Ṗ = −K (x_ref − x, ẋ, ẍ, Ṫ).
#[derive(Debug, Clone)]
pub struct VelocityServo {
    map: WireMap,
    /// Gains from the flattest |∂ξ/∂T| to the steepest, evenly spaced; all the same where they are static.
    gains: [Gains; POINTS],
    flattest: f64,
    per_step: f64,
    /// Whether there are gains for this wire at all.
    designed: bool,
    range: Range,
    /// The cycle before; `None` in the first.
    last: Option<Asked>,
}

/// Gains of the regulator at one slope, for an integral gain of `integral_w_per_m_s`: weight 1 on Ṗ, its square on the error,
/// nothing on the rest, as in the thesis.
fn gains(lpv: &LpvModel, at: &OperatingPoint, slope: f64, integral_w_per_m_s: f64) -> Option<Gains> {
    let plant = lpv.velocity_form(at, -slope);
    let (a, b) = augment(&plant.a, &plant.b, &plant.c).ok()?;
    let mut weight = DMatrix::zeros(4, 4);
    weight[(0, 0)] = integral_w_per_m_s * integral_w_per_m_s;
    let k = lqr(&a, &b, &weight, &DMatrix::identity(1, 1)).ok()?;
    k.iter().all(|gain| gain.is_finite()).then(|| Gains {
        error: k[0],
        velocity: k[1],
        acceleration: k[2],
        temperature_rate: k[3],
    })
}

impl VelocityServo {
    pub(crate) fn new(
        model: &WireModel,
        map: WireMap,
        schedule: Schedule,
        coupling: Coupling,
        integral_w_per_m_s: f64,
        range: Range,
    ) -> VelocityServo {
        let steepest = 0.25 / map.heating_width.min(map.cooling_width);
        let flattest = FLATTEST * steepest;
        let step = (steepest - flattest) / (POINTS - 1) as f64;
        let stress_pa = map.stress(0.5 * map.length * map.strain, 0.0);
        let at = OperatingPoint {
            temperature_c: map.heating_centre + stress_pa * map.shift,
            martensite: 0.5,
            stress_pa,
            heating: true,
        };
        let mut table = [Gains::NONE; POINTS];
        let mut designed = false;
        if let Ok(lpv) = LpvModel::new(model, coupling) {
            designed = true;
            for (point, entry) in table.iter_mut().enumerate() {
                let slope = match schedule {
                    Schedule::Static => CONSTANT_SLOPE_PER_K,
                    Schedule::Scheduled => flattest + point as f64 * step,
                };
                match gains(&lpv, &at, slope, integral_w_per_m_s) {
                    Some(gains) => *entry = gains,
                    None => designed = false,
                }
            }
        }
        VelocityServo { map, gains: table, flattest, per_step: 1.0 / step, designed, range, last: None }
    }

    /// The gains at a slope, between the points of the schedule.
    #[inline]
    fn gains_at(&self, slope: f64) -> Gains {
        // in this order a NaN becomes the flattest
        let place = ((slope - self.flattest) * self.per_step).max(0.0).min((POINTS - 1) as f64);
        let below = (place as usize).min(POINTS - 2);
        let (low, high, share) = (&self.gains[below], &self.gains[below + 1], place - below as f64);
        let between = |low: f64, high: f64| low + share * (high - low);
        Gains {
            error: between(low.error, high.error),
            velocity: between(low.velocity, high.velocity),
            acceleration: between(low.acceleration, high.acceleration),
            temperature_rate: between(low.temperature_rate, high.temperature_rate),
        }
    }
}

impl Law for VelocityServo {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        let seen = &demand.estimate;
        if !self.designed || !demand.is_usable() || !seen.is_usable() {
            self.last = None;
            return None;
        }
        let (low, high) = (self.range.minimum * seen.full_power_w, self.range.maximum * seen.full_power_w);
        let now = Asked {
            power_w: low,
            length_m: seen.length_m,
            velocity_m_s: seen.velocity_m_s,
            temperature_c: seen.temperature_c,
        };
        let last = self.last.unwrap_or(now);
        let k = self.gains_at(self.map.slope_here(last.power_w > seen.loss_w, seen));
        let mut change = k.error * (demand.reference_m - seen.length_m) * demand.dt_s;
        change += k.velocity * (now.length_m - last.length_m);
        change += k.acceleration * (now.velocity_m_s - last.velocity_m_s);
        change += k.temperature_rate * (now.temperature_c - last.temperature_c);
        // in this order a NaN becomes the least
        let power_w = (last.power_w - change).max(low).min(high);
        self.last = Some(Asked { power_w, ..now });
        Some(self.range.give(power_w / seen.full_power_w))
    }

    fn reset(&mut self) {
        self.range.reset();
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::estimate::Estimate;
    use crate::stroke::StrokeRange;
    use crate::testing::{by_power, standing, wire};
    use sinew_physics::{Load, Wire};

    fn model() -> WireModel {
        WireModel { drive: by_power(), ..wire() }
    }

    fn servo(schedule: Schedule, coupling: Coupling, integral: f64) -> VelocityServo {
        let range = Range::new(0.0, 1.0, Modulation::Switched);
        VelocityServo::new(&model(), WireMap::new(&model()), schedule, coupling, integral, range)
    }

    fn each(k: Gains) -> [f64; 4] {
        [k.error, k.velocity, k.acceleration, k.temperature_rate]
    }

    /// Mean overshoot of three steps, shares of the step, where the state is known exactly.
    fn overshoot(schedule: Schedule, coupling: Coupling) -> f64 {
        let (model, full_power_w, dt_s) = (model(), 3.0, 1e-3);
        let mut servo = servo(schedule, coupling, 5000.0);
        let mut wire = Wire::new(&model).unwrap();
        let map = WireMap::new(&model);
        let range = StrokeRange::of(&model).unwrap();
        let mut inputs = model.rest_inputs();
        let overshoots = [0.4, 0.8, 0.4].map(|stroke| {
            let reference_m = range.length_m(stroke);
            let start = model.geometry.length_m + wire.position_m();
            let mut most = 0f64;
            for _ in 0..6000 {
                wire.step(&inputs, dt_s);
                let length_m = model.geometry.length_m + wire.position_m();
                let duty = servo.duty(&Demand {
                    reference_m,
                    length_m,
                    velocity_m_s: wire.velocity_m_s(),
                    acceleration_m_s2: 0.0,
                    resistance_ohm: f64::NAN,
                    dt_s,
                    estimate: Estimate {
                        temperature_c: wire.temperature_c(),
                        martensite: wire.martensite(),
                        stress_pa: wire.stress_pa(),
                        length_m,
                        velocity_m_s: wire.velocity_m_s(),
                        loss_w: map.loss * (wire.temperature_c() - map.ambient),
                        full_power_w,
                        ..Estimate::UNKNOWN
                    },
                });
                inputs.drive = duty.unwrap() * full_power_w;
                most = most.max((length_m - reference_m) / (reference_m - start));
            }
            most
        });
        overshoots.iter().sum::<f64>() / 3.0
    }

    /// The drag in the model removes the overshoot, not the schedule.
    #[test]
    fn the_drag_matters_more_than_the_schedule() {
        let fixed = overshoot(Schedule::Static, Coupling::Thermal);
        let scheduled = overshoot(Schedule::Scheduled, Coupling::Thermal);
        let coupled = overshoot(Schedule::Static, Coupling::Full);
        let both = overshoot(Schedule::Scheduled, Coupling::Full);
        assert!(scheduled > 0.8 * fixed && coupled < 0.5 * fixed && both < 0.5 * fixed);
    }

    /// The thesis' weight on the thesis' model at its slope: the integral gain is the weight's root, and the poles are those that
    /// an independent solution finds.
    #[test]
    fn gains_are_those_of_the_regulator() {
        let map = WireMap::new(&model());
        let lpv = LpvModel::new(&model(), Coupling::Thermal).unwrap();
        let stress_pa = map.stress(0.5 * map.length * map.strain, 0.0);
        let at = OperatingPoint { temperature_c: 113.0, martensite: 0.5, stress_pa, heating: true };
        let k = each(gains(&lpv, &at, 0.05, 500.0).unwrap());
        assert!((k[0] - 500.0).abs() < 1e-6, "{k:?}");
        // Kalman's identity, |1 + K (jω − A)⁻¹ B|² = 1 + |weight · C (jω − A)⁻¹ B|², at any frequency
        let plant = lpv.velocity_form(&at, -0.05);
        let (a, b) = augment(&plant.a, &plant.b, &plant.c).unwrap();
        for omega in [0.3, 2.0, 11.0, 90.0] {
            let s = sinew_state_space::Complex::new(0.0, omega);
            let resolvent = DMatrix::identity(4, 4).map(|v: f64| s * v) - a.map(|v| s * 0.0 + v);
            let answer = resolvent.try_inverse().unwrap() * b.map(|v| s * 0.0 + v);
            let loop_gain = (0..4).fold(s * 0.0, |sum, i| sum + answer[i] * k[i]);
            let (left, right) = ((loop_gain + 1.0).norm_sqr(), 1.0 + (answer[0] * 500.0).norm_sqr());
            assert!((left / right - 1.0).abs() < 1e-6, "{omega}: {left} {right}");
        }
    }

    /// Between its points the schedule is what the regulator would have been there, within a hundredth.
    #[test]
    fn the_schedule_interpolates() {
        let servo = servo(Schedule::Scheduled, Coupling::Full, 5000.0);
        let lpv = LpvModel::new(&model(), Coupling::Full).unwrap();
        let map = WireMap::new(&model());
        let stress_pa = map.stress(0.5 * map.length * map.strain, 0.0);
        let temperature_c = map.heating_centre + stress_pa * map.shift;
        let at = OperatingPoint { temperature_c, martensite: 0.5, stress_pa, heating: true };
        for slope in [0.0325, 0.041, 0.05, 0.0769] {
            let exact = each(gains(&lpv, &at, slope, 5000.0).unwrap());
            for (found, exact) in each(servo.gains_at(slope)).into_iter().zip(exact) {
                assert!((found / exact - 1.0).abs() < 0.01, "{slope}: {found} {exact}");
            }
        }
        assert_eq!(servo.gains_at(0.0), servo.gains_at(f64::NAN));
        assert_eq!(servo.gains_at(0.0), servo.gains[0]);
    }

    /// A load without mass has no such model: the servo never heats.
    #[test]
    fn a_wire_that_cannot_be_modelled_is_not_heated() {
        let mut massless = model();
        massless.load = Load::ImposedForce;
        let range = Range::new(0.02, 1.0, Modulation::Switched);
        let mut servo =
            VelocityServo::new(&massless, WireMap::new(&massless), Schedule::Static, Coupling::Thermal, 500.0, range);
        let estimate = Estimate {
            temperature_c: 25.0,
            martensite: 1.0,
            length_m: 0.166,
            velocity_m_s: 0.0,
            loss_w: 0.0,
            full_power_w: 3.0,
            stress_pa: 1e8,
            ..Estimate::UNKNOWN
        };
        let demand = Demand { estimate, ..standing(0.16, 0.166) };
        assert_eq!(servo.duty(&demand), None);
    }
}
