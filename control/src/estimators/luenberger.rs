//! Chapter 9's state estimator: a copy of the linear model beside the wire, pulled to it by the length (eq. 53 and appendix A,
//! "State Estimator").
//!
//! States are elongation, velocity, martensite and temperature. With **constant** gains the whole model is that of the
//! mean slope ∂ξ/∂ϑ = −k/6: the elastic part makes the phase come out right whatever the slope, the temperature only
//! where the wire has that slope. **Scheduled**, model and gains follow the slope at the estimated state. Neither estimates
//! the loss to the air: at rest the temperature is the one at which P = h A_s (T − T_∞) with the h of the model, so that a draught,
//! against which more power is needed, looks like heat (figure 98).

use crate::cycle::{self, COLDEST_C, Curves, HOTTEST_C, Start};
use crate::estimate::{Estimate, Observation};
use crate::lambda;
use crate::lpv::{Coupling, LpvModel, OperatingPoint};
use crate::wire_map::WireMap;
use sinew_physics::WireModel;
use sinew_state_space::place::place_observer;
use sinew_state_space::{Complex, DMatrix, eigenvalues};

/// The poles of the phase and of the temperature, in poles of the wire's temperature h A_s/(m c_p): the thesis wants all of
/// the estimator's beyond 10.
const THERMAL_POLES: [f64; 2] = [11.0, 100.0];
/// The load's poles are left where they are, but for decays slower than this.
const LOAD_POLE: f64 = 16.0;
/// The flattest slope that gains are placed for, as a share of the steepest: flatter ones would ask for gains without bound.
const FLATTEST: f64 = 0.1;
/// Gains in the table, over slopes from 0 to the steepest.
const NODES: usize = 17;
/// Slower than this share of the fastest the air lets a wire lengthen is standing; twice as fast is surely moving.
const STANDING: f64 = 0.14;
/// Bandwidth of the rate that distinguishes the two, in poles of the wire's temperature.
const RATE_POLE: f64 = 40.0;
/// Least inertia of the model: the load follows its wire within this, s. The form needs a mass.
const QUICKEST_S: f64 = 1e-3;

/// Gains on what the length differs by: 1/s, 1/s², 1/(m s), K/(m s).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gains {
    elongation: f64,
    velocity: f64,
    martensite: f64,
    /// Times the slope it was placed for: what is left varies little, and is interpolated.
    temperature_slope: f64,
}

/// A state after the cycle, as far as it does not depend on the error of the length, and how much it changes with that.
#[derive(Debug, Clone, Copy)]
struct Answer {
    alone: f64,
    per_error: f64,
}

/// The state estimator of chapter 9.
#[derive(Debug, Clone)]
pub struct LuenbergerObserver {
    map: WireMap,
    /// Slope by slope; only its entry of the mean slope is used with constant gains.
    gains: [Gains; NODES],
    scheduled: bool,
    /// The steepest slope and the mean one, magnitudes, 1/K.
    steepest: f64,
    mean: f64,
    /// How much flatter a load's spring makes a slope, K: 1/slope grows by it.
    spring_k: f64,
    /// m c_p, J/K, and what a whole transformation releases, J.
    heat_capacity: f64,
    release: f64,
    /// The point the elastic part is taken at: elongation in m, stress in Pa; ξ = ½.
    elongation_0: f64,
    stress_0: f64,
    /// Of the load on its wire: (K + K_SMA)/M in 1/s², B/M in 1/s, force per martensite over M in m/s², 1/M.
    stiffness: f64,
    damping: f64,
    phase_push: f64,
    per_mass: f64,
    /// s/m.
    per_standing_speed: f64,
    elongation: f64,
    velocity: f64,
    martensite: f64,
    temperature: f64,
    /// How fast the length changes, smoothed, m/s: the estimated velocity is wrong while the estimated phase is.
    rate: f64,
    hottest: f64,
    full_power: f64,
    seen: bool,
    start: Start,
}

impl LuenbergerObserver {
    /// Constant gains: one model, that of the mean slope.
    pub fn constant(model: &WireModel) -> LuenbergerObserver {
        LuenbergerObserver::new(model, false)
    }

    /// Gains and model scheduled by the slope.
    pub fn scheduled(model: &WireModel) -> LuenbergerObserver {
        LuenbergerObserver::new(model, true)
    }

    fn new(model: &WireModel, scheduled: bool) -> LuenbergerObserver {
        let mut map = WireMap::new(model);
        let wire_stiffness = map.area / (0.5 * (map.compliance_a + map.compliance_m) * map.length);
        map.mass = map.mass.max((map.spring + wire_stiffness) * QUICKEST_S * QUICKEST_S);

        // the middle of the stroke, in the middle of the loop
        let middle = 0.5 * (map.heating_centre + map.cooling_centre);
        let (mut elongation, mut stress) = (0.5 * map.strain * map.length, 0.0);
        for _ in 0..20 {
            stress = 0.5 * (stress + map.stress(elongation, 0.0));
            elongation = map.elongation(0.5, stress, middle + map.shift * stress);
        }
        let at = OperatingPoint {
            temperature_c: middle + map.shift * stress,
            martensite: 0.5,
            stress_pa: stress,
            heating: true,
        };
        let lpv = LpvModel::of_map(map, Coupling::Thermal);
        let frozen = lpv.coefficients(&at, 0.0);
        let steepest = 0.25 / map.heating_width.min(map.cooling_width);
        let gains = std::array::from_fn(|node| {
            let slope = steepest * (node as f64 / (NODES - 1) as f64).max(FLATTEST);
            gains(&lpv, &at, slope)
        });
        let total = map.spring + frozen.wire_stiffness;
        let mut observer = LuenbergerObserver {
            gains,
            scheduled,
            steepest,
            mean: (0.5 / map.heating_width + 0.5 / map.cooling_width) / 6.0,
            spring_k: map.shift * map.spring * map.per_area * frozen.phase_force / total,
            heat_capacity: map.heat_capacity,
            release: frozen.release,
            elongation_0: elongation,
            stress_0: stress,
            stiffness: total / map.mass,
            damping: map.damping / map.mass,
            phase_push: frozen.phase_force / map.mass,
            per_mass: 1.0 / map.mass,
            per_standing_speed: 1.0 / (STANDING * lambda::speeds(&map, map.full_power).cooling).max(1e-9),
            elongation: 0.0,
            velocity: 0.0,
            martensite: 0.0,
            temperature: 0.0,
            rate: 0.0,
            hottest: 0.0,
            full_power: map.full_power,
            seen: false,
            start: Start::of(model),
            map,
        };
        observer.reset();
        observer
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        self.begin_at(self.start.temperature_c);
    }

    /// Back to the start, for a wire that is known to be as hot as this, °C.
    pub fn begin_at(&mut self, temperature_c: f64) {
        (self.temperature, self.martensite) = (temperature_c, self.start.martensite);
        self.hottest = self.temperature;
        (self.velocity, self.rate, self.seen) = (0.0, 0.0, false);
        self.full_power = self.map.full_power;
        self.elongation = self.map.elongation(self.martensite, self.stress_0, self.temperature);
    }

    /// |∂ξ/∂ϑ|, with the load's spring taking its share, 1/K: the outer curve's for a wire that moves the way its heat balance
    /// says, 0 for one that stands, inside the loop.
    ///
    /// The estimated temperature has no further influence, by design. To the linear model a wire that lengthens faster than predicted
    /// loses more heat, so that it is *hotter*: were the slope to follow that temperature, an estimate above the cooling
    /// curve would flatten the slope and drive itself up.
    #[inline]
    fn slope(&self, heating: bool) -> f64 {
        if heating != (self.rate < 0.0) {
            return 0.0;
        }
        let moving = (self.rate.abs() * self.per_standing_speed - 1.0).clamp(0.0, 1.0);
        let xi = self.martensite.clamp(0.0, 1.0);
        let width = if heating { self.map.heating_width } else { self.map.cooling_width };
        let slope = moving * xi * (1.0 - xi) / width;
        slope / (1.0 + slope * self.spring_k)
    }

    /// The gains for a slope, between two of the table.
    #[inline]
    fn gains_at(&self, slope: f64) -> Gains {
        let place = (slope / self.steepest).clamp(FLATTEST, 1.0) * (NODES - 1) as f64;
        let node = (place as usize).min(NODES - 2);
        let (share, a, b) = (place - node as f64, &self.gains[node], &self.gains[node + 1]);
        let between = |a: f64, b: f64| a + share * (b - a);
        Gains {
            elongation: between(a.elongation, b.elongation),
            velocity: between(a.velocity, b.velocity),
            martensite: between(a.martensite, b.martensite),
            temperature_slope: between(a.temperature_slope, b.temperature_slope),
        }
    }

    /// Takes one cycle in.
    #[inline]
    pub fn update(&mut self, seen: &Observation) -> Estimate {
        cycle::in_steps([seen], |[seen], dt| self.step(seen, dt))
    }

    #[inline]
    fn step(&mut self, seen: &Observation, dt: f64) -> Estimate {
        let m = &self.map;
        let power = cycle::power(m, seen, || m.power_at_full_duty(self.martensite, self.temperature, self.elongation));
        self.full_power = cycle::full_power(m, seen, power, self.full_power);
        // a length that no wire can have is none
        let read = seen.length_m - m.length;
        let measured = read.abs() < m.length;
        if measured && !self.seen {
            // the phase at once, the temperature as it comes
            let stress = m.stress(read, 0.0);
            (self.elongation, self.velocity, self.seen) = (read, 0.0, true);
            self.martensite = m.fraction(read, stress, self.temperature).clamp(0.0, 1.0);
        }
        let stress = cycle::stress(m, seen, self.elongation, self.velocity);
        // what pulls beyond spring, damper and preload
        let pull =
            if seen.tension_n.is_finite() { (stress - m.stress(self.elongation, self.velocity)) * m.area } else { 0.0 };

        let above = self.temperature - m.ambient;
        let slope = if self.scheduled { self.slope(power > m.loss * above) } else { self.mean };
        let gains = self.gains_at(slope);
        let on = if measured { 1.0 } else { 0.0 };
        // 1/slope, fading to 0 where nothing transforms: there the length says nothing of the temperature
        let flattest = if self.scheduled { FLATTEST * self.steepest } else { 0.0 };
        let temperature_gain = on * gains.temperature_slope * slope / (slope * slope + flattest * flattest);

        // x̂⁺ = x̂ + Δt (A x̂⁺ + B P + L e), e = y − Cx̂⁺: implicit, so that no rate of load or sampling is too fast. From the
        // bottom up every state is linear in e, and the first row says e.
        let thermal_mass = self.heat_capacity + self.release * slope;
        let cooling = 1.0 + dt * m.loss / thermal_mass;
        let warm =
            Answer { alone: (above + dt * power / thermal_mass) / cooling, per_error: dt * temperature_gain / cooling };
        let phase = Answer {
            alone: self.martensite - dt * slope / thermal_mass * (power - m.loss * warm.alone),
            per_error: dt * (on * gains.martensite + slope / thermal_mass * m.loss * warm.per_error),
        };
        let drag = 1.0 + dt * self.damping;
        let y = if measured { read } else { self.elongation };
        let push = -self.stiffness * (y - self.elongation_0) + self.phase_push * (phase.alone - 0.5);
        let speed = Answer {
            alone: (self.velocity + dt * (push + pull * self.per_mass)) / drag,
            per_error: dt * (self.stiffness + self.phase_push * phase.per_error + on * gains.velocity) / drag,
        };
        let error = (y - self.elongation - dt * speed.alone) / (1.0 + dt * (speed.per_error + on * gains.elongation));
        let before = self.elongation;
        self.elongation = (y - error).clamp(-m.length, m.length);
        let smoothing = RATE_POLE * m.loss * m.per_heat_capacity;
        self.rate += smoothing / (1.0 + smoothing * dt) * (self.elongation - before - self.rate * dt);
        self.velocity = (speed.alone + speed.per_error * error).clamp(-1e3 * m.length, 1e3 * m.length);
        self.martensite = (phase.alone + phase.per_error * error).clamp(-0.5, 1.5);
        self.temperature = (m.ambient + warm.alone + warm.per_error * error).clamp(COLDEST_C, HOTTEST_C);

        let martensite = self.martensite.clamp(0.0, 1.0);
        let curves = Curves::at(m, martensite, stress);
        self.hottest = cycle::hottest(m, self.hottest, power, dt, self.temperature);
        Estimate {
            temperature_c: self.temperature,
            martensite,
            hottest_c: self.hottest,
            stress_pa: stress,
            heating_curve_c: curves.heating_c,
            cooling_curve_c: curves.cooling_c,
            length_m: m.length + self.elongation,
            loss_w: m.loss * (self.temperature - m.ambient),
            loss_sigma_w: 0.2 * m.loss * (self.temperature - m.ambient).abs(),
            release_j: m.release(stress),
            full_power_w: self.full_power,
            velocity_m_s: self.velocity,
        }
    }
}

/// The gains that place the poles for a slope of this magnitude; all 0 for a wire of which the length says nothing.
fn gains(lpv: &LpvModel, at: &OperatingPoint, slope: f64) -> Gains {
    let form = lpv.martensite_form(at, -slope);
    let placed = poles(lpv, &form.a).and_then(|poles| place_observer(&form.a, &form.c, &poles).ok());
    match placed {
        Some(l) => Gains { elongation: l[0], velocity: l[1], martensite: l[2], temperature_slope: l[3] * slope },
        None => Gains { elongation: 0.0, velocity: 0.0, martensite: 0.0, temperature_slope: 0.0 },
    }
}

/// Where the poles go: the load's own, made to decay fast enough, and those of phase and temperature.
fn poles(lpv: &LpvModel, a: &DMatrix<f64>) -> Option<[Complex<f64>; 4]> {
    let rate = lpv.temperature_pole();
    let load = eigenvalues(&a.view((0, 0), (2, 2)).into_owned()).ok()?;
    let faster = |pole: Complex<f64>| Complex::new(pole.re.min(-LOAD_POLE * rate), pole.im);
    let thermal = THERMAL_POLES.map(|multiple| Complex::new(-multiple * rate, 0.0));
    Some([faster(load[0]), faster(load[1]), thermal[0], thermal[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{hanging, wire};
    use proptest::prelude::*;
    use sinew_physics::Load;

    fn loads() -> Vec<WireModel> {
        [
            hanging(0.2, 40.0, 0.0, 0.2 * 9.80665),
            hanging(0.13, 0.915, 18.0, 1.2),
            hanging(0.08, 30.0, 150.0, 2.4),
            hanging(0.0, 0.0, 0.0, 2.0),
            Load::ImposedForce,
        ]
        .map(|load| WireModel { load, ..wire() })
        .to_vec()
    }

    /// Between the nodes of the table, too, the error decays as placed: no faster than 5 % off, whatever the slope; and
    /// where gains fade it decays all the same.
    #[test]
    fn the_poles_are_where_they_were_placed() {
        for model in loads() {
            let observer = LuenbergerObserver::scheduled(&model);
            let lpv = LpvModel::of_map(observer.map, Coupling::Thermal);
            let at =
                OperatingPoint { temperature_c: 100.0, martensite: 0.5, stress_pa: observer.stress_0, heating: true };
            for k in 0..=200 {
                let slope = observer.steepest * f64::from(k) / 200.0;
                let (a, g) = (lpv.martensite_form(&at, -slope).a, observer.gains_at(slope));
                let fading = slope / (slope * slope + (FLATTEST * observer.steepest).powi(2));
                let per_slope = if slope > 2.0 * FLATTEST * observer.steepest { 1.0 / slope } else { fading };
                let l = [g.elongation, g.velocity, g.martensite, g.temperature_slope * per_slope];
                let mut closed = a.clone();
                for i in 0..4 {
                    closed[(i, 0)] -= l[i];
                }
                let found = eigenvalues(&closed).unwrap();
                assert!(found.iter().all(|pole| pole.re < 0.0), "{slope}: {found:?}");
                if slope > 2.0 * FLATTEST * observer.steepest {
                    for wanted in poles(&lpv, &a).unwrap() {
                        let near = found.iter().map(|p| (p - wanted).norm()).fold(f64::INFINITY, f64::min);
                        assert!(near < 0.05 * wanted.norm(), "{slope}: {wanted} in {found:?}");
                    }
                }
            }
        }
    }

    /// Held, the length as the model has it: the temperature is that at which the air takes the power, the phase that of the
    /// length; in both kinds, at any rate.
    #[test]
    fn at_rest_it_believes_the_power() {
        for dt_s in [1e-4, 1e-3, 1e-2] {
            for mut observer in [LuenbergerObserver::constant(&wire()), LuenbergerObserver::scheduled(&wire())] {
                let (xi, temperature_c) = (0.4, 90.0);
                let m = observer.map;
                let stress = m.stress(0.0, 0.0);
                let length_m = m.length + m.elongation(xi, stress, 80.0 + m.shift * stress);
                let power_w = m.loss * (temperature_c - m.ambient);
                let mut estimate = Estimate::UNKNOWN;
                for _ in 0..(30.0 / dt_s) as usize {
                    let duty = power_w / m.full_power;
                    let seen = Observation { power_w, length_m, ..Observation::nothing(duty, dt_s) };
                    estimate = observer.update(&seen);
                }
                assert!((estimate.temperature_c - temperature_c).abs() < 0.1, "{estimate:?}");
                assert!((estimate.martensite - xi).abs() < 1e-3, "{estimate:?}");
                assert!((estimate.loss_w - power_w).abs() < 1e-3 * power_w);
                assert!((estimate.length_m - length_m).abs() < 1e-7 && estimate.velocity_m_s.abs() < 1e-6);
                assert!(estimate.hottest_c >= estimate.temperature_c);
            }
        }
    }

    fn any_number() -> impl Strategy<Value = f64> {
        prop_oneof![
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(f64::NEG_INFINITY),
            Just(0.0),
            -1e300f64..1e300,
            -1.0f64..1.0,
            0.15f64..0.18,
        ]
    }

    proptest! {
        /// Whatever comes in, what comes out is finite, in range, and recovers.
        #[test]
        fn any_input_is_survived(
            inputs in proptest::collection::vec((any_number(), any_number(), any_number(), any_number(), any_number()), 1..40),
            load in 0usize..5,
            scheduled: bool,
        ) {
            let model = &loads()[load];
            let kind = [LuenbergerObserver::constant, LuenbergerObserver::scheduled][usize::from(scheduled)];
            let mut observer = kind(model);
            for (power_w, duty, length_m, tension_n, dt_s) in inputs {
                let nothing = Observation::nothing(duty, dt_s);
                let e = observer.update(&Observation { power_w, length_m, tension_n, ..nothing });
                let all = [
                    e.temperature_c, e.hottest_c, e.stress_pa, e.heating_curve_c, e.cooling_curve_c, e.length_m,
                    e.loss_w, e.full_power_w, e.velocity_m_s,
                ];
                prop_assert!(all.iter().all(|value| value.is_finite()), "{:?}", e);
                prop_assert!((0.0..=1.0).contains(&e.martensite) && e.hottest_c >= e.temperature_c);
            }
            observer.reset();
            let fresh = kind(model).update(&Observation::nothing(0.1, 1e-3));
            prop_assert_eq!(observer.update(&Observation::nothing(0.1, 1e-3)), fresh);
        }
    }
}
