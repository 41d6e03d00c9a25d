//! A running routine: its stages in turn, as a state machine over readings. No clock, no I/O.

use std::sync::Arc;

use sinew_physics::WireModel;
use sinew_rig::Machine as Spec;

use crate::hanging::{Disturbance, Hanging, Loop, Plant};
use crate::machine::{Heater, Order, Reading, Travel, delay_s};
use crate::programme::{End, Programme};
use crate::settling::Settling;
use crate::stage::{Heat, Motion, Part, Stage, Until};
use crate::wave::Quantity;

/// How near the wire's end has to be to where it was sent, microsteps.
const ARRIVED_STEPS: f64 = 2.0;
/// The chamber counts as settled once it has been this near its setpoint, K, for this long, s.
const SETTLED_K: f64 = 0.3;
const SETTLED_S: f64 = 20.0;
/// Crossover of the load's controller times the delay of the force, rad; its integral is so much slower.
const SERVO_TURN: f64 = 0.45;
const SERVO_RESET: f64 = 3.0;
/// Below this share of the load the wire is still being taken up: the integral waits, and the cross-head goes this fast, m/s.
const TAKEN_UP: f64 = 0.3;
const TAKE_UP_M_S: f64 = 5e-3;
/// A current below so many steps of its measurement gives no resistance.
const LEAST_STEPS: f64 = 50.0;

/// What a routine wants done in the next period, and what a recording should say of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directive {
    /// For the machine.
    pub order: Order,
    /// Elongation, m, or force, N, that is aimed at; NaN where neither is.
    pub target: f64,
    /// What is commanded of the heater, in its quantity's unit.
    pub heat: f64,
    /// The law's duty; NaN where none is at work.
    pub duty: f64,
    /// Pull on the hanging mass beside its load, N.
    pub disturbance_n: f64,
    /// Index of the stage.
    pub stage: usize,
}

/// A routine and how far it is.
#[derive(Debug, Clone)]
pub struct Routine {
    stages: Vec<Stage>,
    spec: Spec,
    /// Stiffness of the wire where it is stiffest, N/m.
    stiffness_n_per_m: f64,
    hanging: Option<Hanging>,
    programme: Option<Arc<Programme>>,
    settling: Option<Settling>,
    /// What was commanded of the heater last, in its quantity's unit.
    heat: f64,
    at: usize,
    /// Periods in the present stage.
    periods: u64,
    settled_s: f64,
    /// Integral of the load's controller, m/s.
    integral_m_s: f64,
}

impl Routine {
    /// The stages in their order, on a wire that is believed to be like `model`.
    pub fn new(stages: Vec<Stage>, model: &WireModel, spec: &Spec) -> Routine {
        Routine {
            stages,
            spec: *spec,
            stiffness_n_per_m: model.stiffest_n_per_m(),
            hanging: None,
            programme: None,
            settling: None,
            heat: 0.0,
            at: 0,
            periods: 0,
            settled_s: 0.0,
            integral_m_s: 0.0,
        }
    }

    /// With a mass on the wire and a law that moves it, for stages that let it hang.
    pub fn with_plant(mut self, model: &WireModel, plant: Plant, disturbances: Vec<Disturbance>, by: &Loop) -> Routine {
        self.hanging = Some(Hanging::new(model, plant, disturbances, by));
        self
    }

    /// With a programme, for stages that follow one.
    pub fn with_programme(mut self, programme: Arc<Programme>) -> Routine {
        self.programme = Some(programme);
        self
    }

    /// Which ends as soon as the wire has settled.
    pub(crate) fn until_settled(mut self, settling: Settling) -> Routine {
        self.settling = Some(settling);
        self
    }

    /// All stages; of a routine that ended because the wire had settled, those that were run.
    pub fn stages(&self) -> &[Stage] {
        &self.stages
    }

    /// How long all of it is likely to take, s.
    pub fn expected_s(&self) -> f64 {
        self.stages.iter().map(|stage| stage.expected_s).sum()
    }

    /// Share of it that is done, 0..1.
    pub fn progress(&self) -> f64 {
        let before: f64 = self.stages[..self.at.min(self.stages.len())].iter().map(|stage| stage.expected_s).sum();
        let within = self.stages.get(self.at).map_or(0.0, |stage| self.in_stage_s().min(stage.expected_s));
        (before + within) / self.expected_s().max(1e-9)
    }

    /// What to do next, after the last reading; `None` when the routine is done.
    pub fn next(&mut self, reading: &Reading) -> Option<Directive> {
        let is_cycle = |stage: &Stage| matches!(stage.part, Part::Cycle { .. });
        let in_cycle = self.stages.get(self.at).is_some_and(is_cycle);
        if let Some(settling) = self.settling.as_mut().filter(|_| in_cycle && self.periods > 0) {
            settling.see(reading.position_m, self.heat);
        }
        while self.is_over(reading)? {
            if self.stages.get(self.at).is_some_and(is_cycle)
                && self.settling.as_mut().is_some_and(Settling::ends_cycle)
            {
                // what would have come is not left out: it is not needed
                self.stages.truncate(self.at + 1);
            }
            self.at += 1;
            self.periods = 0;
            self.settled_s = 0.0;
            let hangs = |stage: &Stage| matches!(stage.motion, Motion::Hang(_));
            if !self.stages.get(self.at).is_some_and(hangs) {
                self.hanging.iter_mut().for_each(Hanging::hold);
            }
        }
        let stage = *self.stages.get(self.at)?;
        let dt_s = 1.0 / self.spec.rate_hz;
        let now_s = self.in_stage_s();
        let (mut duty, mut disturbance_n) = (f64::NAN, 0.0);
        let mut law_w = 0.0;
        let (travel, target) = match stage.motion {
            Motion::Stay => (Travel::At(0.0), f64::NAN),
            Motion::To(position_m, speed_m_s) => (Travel::To { position_m, speed_m_s }, position_m),
            Motion::Pull(speed_m_s) => (Travel::At(speed_m_s), f64::NAN),
            Motion::Left(newton) => (Travel::Left, newton),
            // what is commanded now is to be reached at the end of the period
            Motion::Brought(reference) => (Travel::Left, reference.at(now_s + dt_s)),
            Motion::Force(newton) => (Travel::At(self.servo(newton, reading, dt_s)), newton),
            Motion::Follow => {
                // what is commanded now is to be reached at the end of the period
                match self.programme.as_ref().map(|programme| programme.end_at(now_s + dt_s)) {
                    Some(End::At(elongation_m)) => {
                        (Travel::At((elongation_m - reading.position_m) / dt_s), elongation_m)
                    }
                    Some(End::Pulled(newton)) => (Travel::At(self.servo(newton, reading, dt_s)), newton),
                    Some(End::Left) => (Travel::Left, f64::NAN),
                    None => (Travel::At(0.0), f64::NAN),
                }
            }
            Motion::Hang(reference) => {
                // what is commanded now is to be reached at the end of the period
                let reference_m = reference.at(now_s + dt_s);
                let least_a = LEAST_STEPS * self.spec.current_step_a.max(1e-6);
                let commanded = self.hanging.as_mut().map(|plant| plant.period(reading, reference_m, dt_s, least_a));
                let speed_m_s = commanded.as_ref().map_or(0.0, |commanded| commanded.speed_m_s);
                if let Some(commanded) = commanded {
                    (duty, disturbance_n, law_w) = (commanded.duty, commanded.disturbance_n, commanded.power_w);
                }
                (Travel::At(speed_m_s), reference_m)
            }
        };
        let (heater, heat) = match stage.heat {
            // how much that takes, the driver knows
            Heat::Law if matches!(stage.motion, Motion::Brought(_)) => (Heater::Length(target), f64::NAN),
            Heat::Law => (Heater::Power(law_w), law_w),
            // the middle of the period, for what changes within it
            Heat::Follow => match &self.programme {
                Some(programme) => {
                    let value = programme.heat_at(now_s + 0.5 * dt_s);
                    (of(programme.quantity(), value), value)
                }
                None => (Heater::Off, 0.0),
            },
            Heat::Program(quantity, wave) => {
                let value = wave.at(now_s + 0.5 * dt_s);
                (of(quantity, value), value)
            }
        };
        self.heat = heat;
        self.periods += 1;
        let order = Order { travel, heater, chamber_c: stage.chamber_c };
        Some(Directive { order, target, heat, duty, disturbance_n, stage: self.at })
    }

    fn in_stage_s(&self) -> f64 {
        self.periods as f64 / self.spec.rate_hz
    }

    /// Whether the present stage is over; `None` when there is none.
    fn is_over(&mut self, reading: &Reading) -> Option<bool> {
        let stage = self.stages.get(self.at)?;
        let now_s = self.in_stage_s();
        // a whole number of periods, whatever the rounding
        let has_passed = |seconds: f64| now_s >= seconds - 1e-6;
        let over = match stage.until {
            Until::Seconds(seconds) => has_passed(seconds),
            Until::Arrived => match stage.motion {
                Motion::To(position_m, _) => {
                    (reading.position_m - position_m).abs() <= ARRIVED_STEPS * self.spec.microstep_m + 1e-7
                }
                _ => true,
            },
            Until::ForceOver(newton) => self.periods > 0 && reading.force_n >= newton,
            Until::ForceUnder(newton) => self.periods > 0 && reading.force_n <= newton,
            Until::ChamberSettled => {
                let near = stage.chamber_c.is_none_or(|wanted| (reading.chamber_c - wanted).abs() <= SETTLED_K);
                self.settled_s = if near { self.settled_s + 1.0 / self.spec.rate_hz } else { 0.0 };
                stage.chamber_c.is_none() || self.settled_s >= SETTLED_S
            }
        };
        Some(over || has_passed(stage.most_s))
    }

    /// Speed that brings the force to `newton`, m/s.
    fn servo(&mut self, newton: f64, reading: &Reading, dt_s: f64) -> f64 {
        let rate = SERVO_TURN / delay_s(&self.spec);
        let error_m = (newton - reading.force_n) / self.stiffness_n_per_m.max(1e-9);
        if reading.force_n < TAKEN_UP * newton && self.integral_m_s <= 0.0 {
            return TAKE_UP_M_S;
        }
        let wanted = rate * error_m + self.integral_m_s;
        let given = wanted.clamp(-self.spec.max_speed_m_s, self.spec.max_speed_m_s);
        if given == wanted {
            self.integral_m_s += rate * rate / SERVO_RESET * error_m * dt_s;
        }
        given
    }
}

/// The amplifier at a value of a quantity.
fn of(quantity: Quantity, value: f64) -> Heater {
    match quantity {
        _ if value.is_nan() || value <= 0.0 => Heater::Off,
        Quantity::Voltage => Heater::Voltage(value),
        Quantity::Current => Heater::Current(value),
        Quantity::Power => Heater::Power(value),
        Quantity::Duty => Heater::Duty(value),
    }
}
