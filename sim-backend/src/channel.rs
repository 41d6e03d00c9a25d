//! One channel of the virtual rig: a wire in its load, its power stage and its converter, in the order of a period.

use sinew_backend::{ChannelFault, Sample, Truth};
use sinew_physics::effects::{Gain, Offset};
use sinew_physics::{Inputs, Outputs, Surroundings, Wire};
use sinew_rig::{FaultKind, SamplingCircuit};

use crate::circuit::{Defects, flow};
use crate::converter::{Converter, MIN_ON_TIME_S, Pins};
use crate::fault::{Acting, Schedule};

/// A converter input that touches nothing drifts about this share of the supply …
const FLOATING_MEAN: f64 = 0.25;
/// … by this share (standard deviation) …
const FLOATING_SPREAD: f64 = 0.08;
/// … forgetting where it was in this time, s: the bias current of the input on its cable.
const FLOATING_TIME_S: f64 = 0.02;

/// What the world around a wire does to it beyond its rig file, see
/// [`SimulatedRig::disturb`](crate::SimulatedRig::disturb).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct World {
    /// Air that is warmer (colder) than the rig file's by this, K.
    pub ambient_k: f64,
    /// A draught: the share by which the air takes more heat from the wire.
    pub draught: f64,
    /// Pull on the load beside its own, N, positive making the wire longer.
    pub pull_n: f64,
    /// Share of the supply there is.
    pub supply: f64,
}

impl World {
    /// As the rig file says.
    pub const CALM: World = World { ambient_k: 0.0, draught: 0.0, pull_n: 0.0, supply: 1.0 };
}

impl Default for World {
    fn default() -> World {
        World::CALM
    }
}

/// The world as the rig file says it is.
#[derive(Debug, Clone, Copy)]
struct Nominal {
    /// Supply, V.
    supply_v: f64,
    /// Air, °C.
    ambient_c: f64,
}

#[derive(Debug, Clone)]
pub(crate) struct Channel {
    /// The duty in force, 0..1, and how long ago it was taken, periods.
    pub duty: f64,
    unheard: u64,
    /// Whether the last duty it was given was taken.
    pub is_confirmed: bool,
    /// What has failed of it in the last exchange.
    pub failure: Option<ChannelFault>,
    pub wire: Wire,
    inputs: Inputs,
    /// The supply now.
    supply_v: f64,
    nominal: Nominal,
    /// What other wires do to this one in the period under way.
    around: Surroundings,
    /// Outside the taps: shunt, switch, leads and the supply's own.
    series_ohm: f64,
    /// The supply's own of it, through which others at the same supply draw, too.
    source_ohm: f64,
    /// At the moving end, inside V_3, while nothing is broken.
    contact_ohm: f64,
    /// What the amplifiers make of V_3 and the current.
    gain: Gain,
    /// What they show of nothing.
    offset: Offset,
    /// Whether there are taps.
    taps: bool,
    /// Switch and shunt between the wire and ground, Ω, where one input sees supply and current.
    low_ohm: Option<f64>,
    /// Where on the wire a tap sticks, as the share of the wire's voltage that it sees.
    stuck: [Option<f64>; 2],
    converter: Converter,
    /// Electrical heat up to the start of the period just past, J, how long that was, s, and the duty in force then.
    heat_before_j: f64,
    past_s: f64,
    past_duty: f64,
    /// What it should have been: another where the stage conducts on its own.
    past_asked: f64,
    last: Sample,
    /// Wander of a floating input, in standard deviations.
    floating: f64,
    length_m: f64,
    area_m2: f64,
    pub schedule: Schedule,
}

impl Channel {
    pub fn new(wire: Wire, channel: &sinew_rig::Channel, seed: u64, schedule: Schedule) -> Channel {
        let model = &channel.model;
        let drive = &model.drive;
        let sensing = &model.effects.sensing;
        let low_ohm = match channel.adc.circuit {
            SamplingCircuit::SeparateTaps => None,
            SamplingCircuit::Shared => Some(drive.low_ohm()),
        };
        Channel {
            duty: 0.0,
            unheard: 0,
            is_confirmed: true,
            failure: None,
            inputs: model.rest_inputs(),
            wire,
            supply_v: drive.supply_v,
            nominal: Nominal { supply_v: drive.supply_v, ambient_c: model.ambient_c },
            around: Surroundings::default(),
            series_ohm: model.outside_ohm(),
            source_ohm: model.effects.electrical.supply_sag.source_ohm,
            contact_ohm: sensing.contact_resistance.ohm,
            gain: sensing.gain,
            offset: sensing.offset,
            taps: model.taps.is_some(),
            low_ohm,
            stuck: [None; 2],
            converter: Converter::new(&channel.adc, drive.supply_v, low_ohm, seed),
            heat_before_j: 0.0,
            past_s: 0.0,
            past_duty: 0.0,
            past_asked: 0.0,
            last: Sample::NONE,
            floating: 0.0,
            length_m: model.geometry.length_m,
            area_m2: model.geometry.area_m2(),
            schedule,
        }
    }

    pub fn disturb(&mut self, world: &World) {
        let Nominal { supply_v, ambient_c } = self.nominal;
        self.supply_v = supply_v * world.supply;
        self.inputs.ambient_c = ambient_c + world.ambient_k;
        self.inputs.external_n = world.pull_n;
        self.wire.set_draught(world.draught);
    }

    /// What acts on the wire, with the present supply and nothing driven.
    pub fn inputs(&self) -> Inputs {
        Inputs { drive: 0.0, supply_v: self.supply_v, ..self.inputs }
    }

    /// What is left of a supply behind the source resistance that others at it draw through, V.
    fn behind_others(&self, supply_v: f64) -> f64 {
        supply_v - self.source_ohm * self.around.others_a
    }

    /// Lets other wires act on this one in the next period.
    #[inline]
    pub fn surround(&mut self, around: Surroundings) {
        around.warm(&mut self.wire);
        self.around = around;
    }

    /// Prepares for one period of the duty in force: sets what acts on the wire while it passes. `live`: the stage has
    /// a supply.
    #[inline]
    pub fn begin(&mut self, period_s: f64, acting: &Acting, live: bool) {
        let supply_v = self.behind_others(self.supply_v * acting.supply());
        let duty = match (live, acting.has(FaultKind::StageOn)) {
            (false, _) => 0.0,
            (true, true) => 1.0,
            (true, false) => self.duty,
        };
        self.wire.set_jammed(acting.has(FaultKind::Jammed));
        self.inputs.drive = duty;
        self.inputs.supply_v = if acting.is_none() {
            supply_v
        } else {
            // the wire's model has a supply with the whole circuit: pass the one that drives the same current
            let ohm = self.wire.resistance_ohm();
            let flow = flow(supply_v, self.series_ohm, ohm, &self.defects(acting));
            flow.wire_a * (ohm + self.series_ohm + self.contact_ohm)
        };
        (self.past_duty, self.past_asked) = (duty, self.duty);
        self.past_s = period_s;
        self.heat_before_j = self.wire.energy().heat_in_j;
    }

    /// Lets the period pass, for a wire with a load of its own.
    #[inline]
    pub fn pass(&mut self) {
        self.wire.step(&self.inputs, self.past_s);
    }

    /// The wire with what acts on it, for the joint it turns, which steps it.
    #[inline]
    pub fn wire_in_joint(&mut self) -> (&mut Wire, &Inputs) {
        (&mut self.wire, &self.inputs)
    }

    /// Mean power into the wire in the period just past, W.
    fn power_w(&self) -> f64 {
        if self.past_s > 0.0 { (self.wire.energy().heat_in_j - self.heat_before_j) / self.past_s } else { 0.0 }
    }

    /// Samples at the end of the on-phase that closes the period just past; an input that is shared also in the
    /// off-phase that opened it.
    #[inline]
    pub fn sample(&mut self, period_s: f64, acting: &Acting) -> Sample {
        let outputs = self.wire.outputs();
        let lasts = |share: f64| share * period_s >= MIN_ON_TIME_S * (1.0 - 1e-9);
        let (on, off) = (lasts(self.past_duty), lasts(1.0 - self.past_duty));
        let supply_v = self.supply_v * acting.supply();
        let mut pins = if on {
            Pins {
                taps: self.taps.then_some([outputs.v1_v, outputs.v2_v]),
                v3_v: outputs.v3_v,
                current_a: outputs.current_a,
                supply_v,
            }
        } else {
            let Offset { v1_v, v2_v, v3_v, current_a, .. } = self.offset;
            Pins { taps: self.taps.then_some([v1_v, v2_v]), v3_v, current_a, supply_v }
        };
        if acting.is_none() {
            self.stuck = [None; 2];
            if let Some(low_ohm) = self.low_ohm {
                self.share(&mut pins, low_ohm, (on, off), acting);
            }
            self.last = self.converter.sample(&pins);
            return self.last;
        }
        if on {
            self.stick(&mut pins, &outputs, acting.get(FaultKind::ProbeStuck));
            self.broken_circuit(&mut pins, outputs.resistance_ohm, &self.defects(acting));
        }
        if let Some(low_ohm) = self.low_ohm {
            // the converter follows the commanded duty, whatever the stage does
            let phases = (lasts(self.past_asked), lasts(1.0 - self.past_asked));
            self.share(&mut pins, low_ohm, phases, acting);
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

    /// Moves the pins from a circuit with the fixed end on ground to one where switch and shunt lie between: the taps
    /// stand on their voltage, and the supply is seen through the wire while the switch is open, by the amplifier that
    /// is V_3's in the other circuit. Without an on-phase (`phases.0`) nothing but the supply is sampled, without an
    /// off-phase (`phases.1`) not the supply.
    fn share(&self, pins: &mut Pins, low_ohm: f64, (on, off): (bool, bool), acting: &Acting) {
        pins.v3_v = f64::NAN;
        // what a stage that conducts badly adds below the input
        let low_ohm_now = low_ohm + acting.get(FaultKind::StageWeak).unwrap_or(0.0);
        let low_v = low_ohm_now * self.unamplified(pins.current_a);
        let seen_v = if acting.has(FaultKind::StageOn) && self.past_duty > 0.0 {
            low_v
        } else if acting.has(FaultKind::OpenWire) {
            0.0
        } else {
            pins.supply_v
        };
        pins.supply_v = if off { self.gain.v3 * seen_v + self.offset.v3_v } else { f64::NAN };
        if on {
            pins.taps = pins.taps.map(|taps| taps.map(|tap| tap + low_v));
            pins.current_a *= low_ohm_now / low_ohm;
        } else {
            // the converter waits for the on-phase
            pins.current_a = f64::NAN;
            pins.taps = None;
        }
    }

    /// The current behind what its amplifier shows, A.
    fn unamplified(&self, current_a: f64) -> f64 {
        (current_a - self.offset.current_a) / self.gain.current
    }

    /// Lets a tap (1 or 2) keep its place on the wire instead of its place in space.
    fn stick(&mut self, pins: &mut Pins, outputs: &Outputs, tap: Option<f64>) {
        let wire_v = self.unamplified(outputs.current_a) * outputs.resistance_ohm;
        let offsets = [self.offset.v1_v, self.offset.v2_v];
        let Some(taps) = &mut pins.taps else { return };
        for (index, pin) in taps.iter_mut().enumerate() {
            let sticks = tap == Some((index + 1) as f64) && wire_v > 0.0;
            self.stuck[index] = sticks.then(|| self.stuck[index].unwrap_or_else(|| (*pin - offsets[index]) / wire_v));
            if let Some(share) = self.stuck[index] {
                *pin = share * wire_v + offsets[index];
            }
        }
    }

    /// What is wrong with the circuit, the contact that was never good included.
    fn defects(&self, acting: &Acting) -> Defects {
        let defects = acting.defects();
        Defects { contact_ohm: defects.contact_ohm + self.contact_ohm, ..defects }
    }

    /// What the pins see of the circuit when it is not whole. They are right already as far as the wire's own current
    /// goes (all the taps see, and what the sensors add to it); what the break adds passes the same amplifiers.
    fn broken_circuit(&self, pins: &mut Pins, wire_ohm: f64, defects: &Defects) {
        let flow = flow(self.behind_others(pins.supply_v), self.series_ohm, wire_ohm, defects);
        pins.v3_v += self.gain.v3 * (flow.v3_v - flow.wire_a * (wire_ohm + self.contact_ohm));
        pins.current_a += self.gain.current * (flow.total_a - flow.wire_a);
    }

    /// Lets a tap (1, 2, or 3 for the moving end) float: high impedance, wandering, with or without an on-phase.
    fn lose_probe(&mut self, pins: &mut Pins, tap: f64, period_s: f64) {
        let keep = (-period_s / FLOATING_TIME_S).exp();
        self.floating = keep * self.floating + (1.0 - keep * keep).sqrt() * self.converter.draw();
        let level = self.supply_v * (FLOATING_MEAN + FLOATING_SPREAD * self.floating);
        match (tap as u32, &mut pins.taps) {
            (1, Some(taps)) => taps[0] = level,
            (2, Some(taps)) => taps[1] = level,
            (3, _) => match self.low_ohm {
                // a shared input sees this level in both phases
                Some(low_ohm) => (pins.current_a, pins.supply_v) = (level / low_ohm, level),
                None => pins.v3_v = level,
            },
            _ => {}
        }
    }

    /// Gives the stage a duty for the next period; where its writes fail it keeps the one it has.
    #[inline]
    pub fn put(&mut self, duty: f64, acting: &Acting) {
        self.is_confirmed = !acting.has(FaultKind::WriteFails);
        if self.is_confirmed {
            (self.duty, self.unheard) = (duty, 0);
        }
    }

    /// A period passes for the stage: one that has not been heard of for as many switches itself off.
    #[inline]
    pub fn watch(&mut self, most_periods: u64) {
        if self.unheard >= most_periods {
            self.duty = 0.0;
        }
        self.unheard = self.unheard.saturating_add(1);
    }

    /// Nothing has flowed: after start and stop.
    pub fn at_rest(&mut self) {
        (self.past_duty, self.past_asked) = (0.0, 0.0);
        self.past_s = 0.0;
    }

    pub fn truth(&self) -> Truth {
        // of the wire itself, not of sensors that may lag or err
        let wire = &self.wire;
        Truth {
            length_m: self.length_m + wire.position_m(),
            velocity_m_s: wire.velocity_m_s(),
            temperature_c: wire.temperature_c(),
            martensite: wire.martensite(),
            force_n: self.area_m2 * wire.stress_pa(),
            resistance_ohm: wire.resistance_ohm(),
            power_w: self.power_w(),
            duty: self.past_duty,
        }
    }
}
