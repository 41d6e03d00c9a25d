//! The machine simulated: stepper and frame, load cell, amplifier with its filter, chamber with its controller, and the wire.

use std::f64::consts::TAU;

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;
use rand_distr::{Distribution, StandardNormal};
use sinew_physics::formulas::current_a;
use sinew_physics::{DriveKind, Inputs, Load, Wire, WireModel};
use sinew_rig::Machine as Spec;

use crate::machine::{Heater, Machine, MachineError, Order, Reading, Travel};

/// Longest step of the simulation, s: a quarter of the amplifier's time constant.
const LONGEST_STEP_S: f64 = 1e-3;
/// Conversions of the thermocouple a second (MAX31850), and their step, K.
const CHAMBER_RATE_HZ: f64 = 10.0;
const CHAMBER_STEP_K: f64 = 0.25;
/// The chamber's controller aims at this time constant, s, and takes an error back in so many of them.
const CHAMBER_AIM_S: f64 = 10.0;
const CHAMBER_RESET: f64 = 4.0;
/// The elements can hold the warmest chamber with this much to spare.
const CHAMBER_RESERVE: f64 = 1.1;
/// A current below so many steps of its measurement gives no resistance.
const LEAST_STEPS: f64 = 50.0;
/// Weight of the newest resistance in what the amplifier's feedback goes by: a few periods.
const NEWEST: f64 = 0.3;

/// A machine and a wire that exist in the computer only.
#[derive(Debug, Clone)]
pub struct SimulatedMachine {
    spec: Spec,
    wire: Wire,
    inputs: Inputs,
    /// Resistance outside the wire, Ω.
    series_ohm: f64,
    crosshead: Crosshead,
    amplifier: Amplifier,
    chamber: Chamber,
    force_n: f64,
    /// Periods and steps since the start: times are their multiples, so that nothing adds up.
    periods: u64,
    steps: u64,
    conversions: u64,
    chamber_conversions: u64,
    random: Xoshiro256PlusPlus,
    taps: bool,
}

impl SimulatedMachine {
    /// Mounts a wire, slack by nothing at the elongation 0, in a room of its model's ambient temperature.
    ///
    /// # Errors
    /// [`MachineError::Wire`] where a parameter is outside its physical range.
    pub fn new(model: &WireModel, spec: &Spec, seed: u64) -> Result<SimulatedMachine, MachineError> {
        let mounted = mounted(model);
        let inputs = mounted.rest_inputs();
        let wire = Wire::with_inputs(&mounted, &inputs).map_err(MachineError::Wire)?;
        Ok(SimulatedMachine {
            spec: *spec,
            amplifier: Amplifier { current_a: 0.0, believed_ohm: wire.resistance_ohm() },
            wire,
            inputs,
            series_ohm: model.drive.series_ohm(),
            crosshead: Crosshead::default(),
            chamber: Chamber::new(model.ambient_c, spec),
            force_n: 0.0,
            periods: 0,
            steps: 0,
            conversions: 0,
            chamber_conversions: 0,
            random: Xoshiro256PlusPlus::seed_from_u64(seed),
            taps: model.taps.is_some(),
        })
    }

    /// The wire in it.
    pub fn wire(&self) -> &Wire {
        &self.wire
    }

    fn draw(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    /// A measurement with its noise and step.
    fn measured(&mut self, value: f64, noise: f64, step: f64) -> f64 {
        let noisy = value + noise * self.draw();
        if step > 0.0 { (noisy / step).round() * step } else { noisy }
    }
}

/// The wire as the machine holds it: its end is where the cross-head is, and a steady current heats it.
pub fn mounted(model: &WireModel) -> WireModel {
    let mut mounted = model.clone();
    mounted.drive.kind = DriveKind::Current;
    mounted.load = Load::ImposedPosition;
    mounted
}

impl Machine for SimulatedMachine {
    fn spec(&self) -> &Spec {
        &self.spec
    }

    fn is_simulated(&self) -> bool {
        true
    }

    fn exchange(&mut self, order: &Order) -> Result<Reading, MachineError> {
        let spec = self.spec;
        let period_s = 1.0 / spec.rate_hz;
        let count = (period_s / LONGEST_STEP_S).ceil().max(1.0);
        let step_s = period_s / count;
        let wanted_a = self.amplifier.wanted(order.heater);
        let (mut amps, mut volts, mut taps) = (0.0, 0.0, [0.0; 2]);
        let (mut force_is_new, mut chamber_is_new) = (false, false);
        self.crosshead.plan(&order.travel, &spec, self.wire.tension_n(), period_s);
        for step in 1..=count as u64 {
            self.steps += 1;
            let time_s = self.steps as f64 * step_s;
            // the amplifier gives no more than its supply drives
            let most_a = current_a(spec.heater_supply_v, self.wire.resistance_ohm(), self.series_ohm);
            self.amplifier.step(wanted_a, most_a, spec.heater_cutoff_hz, step_s);
            self.chamber.step(step_s);
            self.inputs.drive = self.amplifier.current_a;
            self.inputs.ambient_c = self.chamber.air_c;
            self.inputs.imposed =
                self.crosshead.at(step as f64 / count) - spec.compliance_m_per_n * self.wire.tension_n();
            self.wire.step(&self.inputs, step_s);
            let seen = self.wire.outputs();
            amps += seen.current_a * seen.current_a / count;
            volts += seen.v3_v * seen.v3_v / count;
            taps[0] += seen.v1_v * seen.v1_v / count;
            taps[1] += seen.v2_v * seen.v2_v / count;
            let due = |rate_hz: f64| (time_s * rate_hz + 1e-6).floor() as u64;
            if due(spec.force_rate_hz) > self.conversions {
                self.conversions = due(spec.force_rate_hz);
                self.force_n = self.measured(seen.force_n, spec.force_noise_n, 0.0);
                force_is_new = true;
            }
            if due(CHAMBER_RATE_HZ) > self.chamber_conversions {
                self.chamber_conversions = due(CHAMBER_RATE_HZ);
                self.chamber.shown_c = self.measured(self.chamber.air_c, spec.chamber_noise_k, CHAMBER_STEP_K);
                self.chamber.control(order.chamber_c, 1.0 / CHAMBER_RATE_HZ);
                chamber_is_new = true;
            }
        }
        self.periods += 1;
        let current_a = self.measured(amps.sqrt(), spec.current_noise_a, spec.current_step_a);
        let voltage_v = self.measured(volts.sqrt(), spec.voltage_noise_v, spec.voltage_step_v);
        let taps_v = match self.taps {
            true => Some(taps.map(|tap| self.measured(tap.sqrt(), spec.voltage_noise_v, spec.voltage_step_v))),
            false => None,
        };
        self.amplifier.learn(voltage_v, current_a, LEAST_STEPS * spec.current_step_a.max(1e-6));
        let crosshead_m = self.crosshead.counted_m;
        Ok(Reading {
            time_s: self.periods as f64 * period_s,
            position_m: crosshead_m - spec.compliance_m_per_n * self.force_n,
            crosshead_m,
            force_n: self.force_n,
            force_is_new,
            current_a,
            voltage_v,
            taps_v,
            chamber_c: self.chamber.shown_c,
            chamber_is_new,
        })
    }
}

/// A stepper on a lead screw. Its driver follows a speed or a position within an acceleration; a period ends on a whole
/// microstep, and within it the cross-head goes evenly, for the rotor smooths the steps.
#[derive(Debug, Clone, Default)]
struct Crosshead {
    /// Where its steps have brought it by the end of the period, m, and where it was at the start of it.
    counted_m: f64,
    before_m: f64,
    /// Where the driver would be without steps, m, and how fast, m/s.
    position_m: f64,
    speed_m_s: f64,
}

impl Crosshead {
    /// Plans a period.
    fn plan(&mut self, travel: &Travel, spec: &Spec, tension_n: f64, period_s: f64) {
        let most = spec.max_acceleration_m_s2 * period_s;
        let wanted = match *travel {
            Travel::At(speed_m_s) => speed_m_s,
            Travel::Left => 0.0,
            Travel::To { position_m, speed_m_s } => {
                let way = position_m + spec.compliance_m_per_n * tension_n - self.position_m;
                // as fast as it can still stop from, and never past the end within this period
                let stopping = (2.0 * spec.max_acceleration_m_s2 * way.abs()).sqrt();
                way.signum() * speed_m_s.abs().min(stopping).min(way.abs() / period_s)
            }
        };
        let wanted = if wanted.is_finite() { wanted.clamp(-spec.max_speed_m_s, spec.max_speed_m_s) } else { 0.0 };
        self.speed_m_s += (wanted - self.speed_m_s).clamp(-most, most);
        let end_m = 0.5 * spec.travel_m;
        let next_m = self.position_m + self.speed_m_s * period_s;
        self.position_m = next_m.clamp(-end_m, end_m);
        if self.position_m != next_m {
            self.speed_m_s = 0.0;
        }
        self.before_m = self.counted_m;
        self.counted_m = (self.position_m / spec.microstep_m).round() * spec.microstep_m;
    }

    /// Where it is after this share of the period, m.
    fn at(&self, share: f64) -> f64 {
        self.before_m + share * (self.counted_m - self.before_m)
    }
}

/// A current amplifier behind a filter of first order, led by the machine's feedback to a voltage, current or power.
#[derive(Debug, Clone)]
struct Amplifier {
    current_a: f64,
    /// The wire's resistance as last measured, Ω.
    believed_ohm: f64,
}

impl Amplifier {
    fn wanted(&self, heater: Heater) -> f64 {
        let ohm = self.believed_ohm.max(1e-6);
        let amps = match heater {
            // an amplifier has neither a switch nor a law: no routine of a machine asks for these
            Heater::Off | Heater::Duty(_) | Heater::Length(_) => 0.0,
            Heater::Current(amps) => amps,
            Heater::Voltage(volts) => volts / ohm,
            Heater::Power(watts) => (watts.max(0.0) / ohm).sqrt(),
        };
        // in this order a NaN becomes nothing
        f64::max(amps, 0.0)
    }

    fn step(&mut self, wanted_a: f64, most_a: f64, cutoff_hz: f64, step_s: f64) {
        let share = 1.0 - (-TAU * cutoff_hz * step_s).exp();
        self.current_a += share * (wanted_a.min(most_a) - self.current_a);
        // below the last step of the amplifier's input nothing flows
        if self.current_a < 1e-7 {
            self.current_a = 0.0;
        }
    }

    fn learn(&mut self, volts: f64, amps: f64, least_a: f64) {
        if amps > least_a && volts > 0.0 {
            self.believed_ohm += NEWEST * (volts / amps - self.believed_ohm);
        }
    }
}

/// Air in a box with thermo-electric elements, a thermocouple and a controller of its own.
#[derive(Debug, Clone)]
struct Chamber {
    air_c: f64,
    room_c: f64,
    /// What its walls let through, W/K.
    leak_w_per_k: f64,
    time_s: f64,
    power_w: f64,
    most_w: f64,
    range_c: (f64, f64),
    shown_c: f64,
    integral_w: f64,
}

impl Chamber {
    fn new(room_c: f64, spec: &Spec) -> Chamber {
        let reach = (spec.chamber_max_c - room_c).abs().max((room_c - spec.chamber_min_c).abs()).max(1.0);
        Chamber {
            air_c: room_c,
            room_c,
            leak_w_per_k: spec.chamber_power_w / (CHAMBER_RESERVE * reach),
            time_s: spec.chamber_time_s,
            power_w: 0.0,
            most_w: spec.chamber_power_w,
            range_c: (spec.chamber_min_c, spec.chamber_max_c),
            shown_c: room_c,
            integral_w: 0.0,
        }
    }

    fn step(&mut self, step_s: f64) {
        if self.leak_w_per_k > 0.0 {
            let rests_at = self.room_c + self.power_w / self.leak_w_per_k;
            self.air_c += (1.0 - (-step_s / self.time_s).exp()) * (rests_at - self.air_c);
        }
    }

    /// One cycle of its controller: proportional and integral, the integral not wound up.
    fn control(&mut self, wanted_c: Option<f64>, step_s: f64) {
        let Some(wanted_c) = wanted_c.filter(|c| c.is_finite()) else {
            (self.power_w, self.integral_w) = (0.0, 0.0);
            return;
        };
        let error = wanted_c.clamp(self.range_c.0, self.range_c.1) - self.shown_c;
        let gain = self.leak_w_per_k * self.time_s / CHAMBER_AIM_S;
        let asked = gain * error + self.integral_w;
        self.power_w = asked.clamp(-self.most_w, self.most_w);
        if self.power_w == asked {
            self.integral_w += gain * error * step_s / (CHAMBER_RESET * CHAMBER_AIM_S);
        }
    }
}
