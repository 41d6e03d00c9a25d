//! One channel of the virtual rig: a wire in its load, its power stage and its converter, in the order a period meets them.

use sinew_driver::{Sample, Truth};
use sinew_physics::{Inputs, Wire};
use sinew_rig::FaultKind;

use crate::circuit::{Defects, flow};
use crate::converter::{Converter, MIN_ON_TIME_S, Pins};
use crate::fault::{Acting, Schedule};

/// A converter input that touches nothing drifts about this share of the supply …
const FLOATING_MEAN: f64 = 0.25;
/// … by this share (standard deviation) …
const FLOATING_SPREAD: f64 = 0.08;
/// … forgetting where it was in this time, s: the bias current of the input on its cable.
const FLOATING_TIME_S: f64 = 0.02;

#[derive(Debug, Clone)]
pub(crate) struct Channel {
    /// The duty in force, 0..1.
    pub duty: f64,
    pub wire: Wire,
    inputs: Inputs,
    supply_v: f64,
    series_ohm: f64,
    /// Whether there are taps.
    taps: bool,
    converter: Converter,
    /// Mean power into the wire in the period just past, W, and the duty that was in force then.
    power_w: f64,
    past_duty: f64,
    last: Sample,
    /// Wander of a floating input, in standard deviations.
    floating: f64,
    length_m: f64,
    pub schedule: Schedule,
}

impl Channel {
    pub fn new(wire: Wire, channel: &sinew_rig::Channel, seed: u64, schedule: Schedule) -> Channel {
        let model = &channel.model;
        let drive = &model.drive;
        Channel {
            duty: 0.0,
            inputs: model.rest_inputs(),
            wire,
            supply_v: drive.supply_v,
            series_ohm: drive.shunt_ohm + drive.switch_ohm + drive.lead_ohm,
            taps: model.taps.is_some(),
            converter: Converter::new(&channel.adc, drive.supply_v, seed),
            power_w: 0.0,
            past_duty: 0.0,
            last: Sample::NONE,
            floating: 0.0,
            length_m: model.geometry.length_m,
            schedule,
        }
    }

    /// Lets one period of the duty in force pass.
    #[inline]
    pub fn advance(&mut self, period_s: f64, acting: &Acting) {
        let supply_v = self.supply_v * acting.supply();
        self.inputs.drive = self.duty;
        self.inputs.supply_v = if acting.is_none() {
            supply_v
        } else {
            // the wire knows a supply behind the series resistance: give it the one that drives the same current
            let ohm = self.wire.resistance_ohm();
            flow(supply_v, self.series_ohm, ohm, &acting.defects()).wire_a * (ohm + self.series_ohm)
        };
        self.wire.step(&self.inputs, period_s);
        self.past_duty = self.duty;
    }

    /// Samples at the end of the on-phase that closes the period [`Channel::advance`] has just let pass.
    #[inline]
    pub fn sample(&mut self, period_s: f64, acting: &Acting) -> Sample {
        let outputs = self.wire.outputs();
        self.power_w = outputs.power_w;
        let on = self.past_duty * period_s >= MIN_ON_TIME_S * (1.0 - 1e-9);
        let supply_v = self.supply_v * acting.supply();
        let mut pins = if on {
            Pins {
                taps: self.taps.then_some([outputs.v1_v, outputs.v2_v]),
                v3_v: outputs.v3_v,
                current_a: outputs.current_a,
                supply_v,
            }
        } else {
            Pins { taps: self.taps.then_some([0.0; 2]), v3_v: 0.0, current_a: 0.0, supply_v }
        };
        if acting.is_none() {
            self.last = self.converter.sample(&pins);
            return self.last;
        }
        if on {
            self.broken_circuit(&mut pins, outputs.resistance_ohm, &acting.defects());
        }
        if let Some(tap) = acting.get(FaultKind::ProbeLost) {
            self.lose_probe(&mut pins, tap, period_s);
        }
        let sample = self.converter.sample(&pins);
        if acting.has(FaultKind::AdcNan) {
            return Sample::NONE;
        }
        if acting.has(FaultKind::AdcSaturated) {
            return self.converter.saturated(self.taps);
        }
        if !acting.has(FaultKind::AdcStuck) {
            self.last = sample;
        }
        self.last
    }

    /// What the pins see of the circuit when it is not whole. The taps are right already: they follow the wire's current.
    fn broken_circuit(&self, pins: &mut Pins, wire_ohm: f64, defects: &Defects) {
        let flow = flow(pins.supply_v, self.series_ohm, wire_ohm, defects);
        pins.v3_v = flow.v3_v;
        pins.current_a = flow.total_a;
    }

    /// Lets a tap (1, 2, or 3 for the moving end) float: high impedance, wandering, with or without an on-phase.
    fn lose_probe(&mut self, pins: &mut Pins, tap: f64, period_s: f64) {
        let keep = (-period_s / FLOATING_TIME_S).exp();
        self.floating = keep * self.floating + (1.0 - keep * keep).sqrt() * self.converter.draw();
        let level = self.supply_v * (FLOATING_MEAN + FLOATING_SPREAD * self.floating);
        match (tap as u32, &mut pins.taps) {
            (1, Some(taps)) => taps[0] = level,
            (2, Some(taps)) => taps[1] = level,
            (3, _) => pins.v3_v = level,
            _ => {}
        }
    }

    /// Nothing is put out any more.
    pub fn switch_off(&mut self) {
        self.duty = 0.0;
    }

    /// Nothing flows, and nothing has: after stop.
    pub fn at_rest(&mut self) {
        self.duty = 0.0;
        self.past_duty = 0.0;
        self.power_w = 0.0;
    }

    pub fn truth(&self) -> Truth {
        let outputs = self.wire.outputs();
        Truth {
            length_m: self.length_m + outputs.position_m,
            velocity_m_s: self.wire.velocity_m_s(),
            temperature_c: outputs.temperature_c,
            martensite: outputs.martensite,
            force_n: outputs.force_n,
            resistance_ohm: outputs.resistance_ohm,
            power_w: self.power_w,
            duty: self.past_duty,
        }
    }
}
