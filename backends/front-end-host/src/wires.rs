//! The peripherals: a power stage and converters with simulated wires on them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU16, Ordering};

use sinew_backend::clock::now_ns;
use sinew_backend::{Backend as _, Sample};
use sinew_front_end::{
    ChannelFault, ChannelLimits, ChannelRange, Event, FULL_DUTY, Features, Hardware, Identification, MAX_CHANNELS,
    NOT_SAMPLED, RawSample, ResetCause, StopPins,
};
use sinew_rig::{EnableSignal, Rig, SamplingCircuit};
use sinew_sim_backend::{FaultHandle, SimulatedRig};

use crate::error::Error;
use crate::wiring::{Mount, Wiring, Wrong};

/// The largest code of the converters.
const FULL_CODE: u16 = 65_534;
/// The firmware's own limits, independent of the driver: silence, current and I²t.
const MAX_SILENCE_NS: u32 = 1_000_000_000;
const LIMITS: ChannelLimits =
    ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 20_000, heat_ma2_s: u32::MAX, drain_ma2: 25_000_000 };
/// A pause is computed up to so many periods: wires have cooled by then, and the line does not wait.
const LONGEST_PAUSE: u64 = 2_000;

/// What switches the supply of the simulated power stages.
#[derive(Debug, Clone, Copy)]
enum Supply {
    /// Nothing: it is there.
    Always,
    /// The level of the enable pin.
    Level(bool),
    /// A watchdog relay: it drops out so long after the last edge of the pin, ns.
    Relay { level: bool, edge_ns: Option<u64>, dropout_ns: u64 },
}

impl Supply {
    fn of(rig: &Rig) -> Supply {
        let enable = &rig.backend.enable;
        match enable.signal {
            EnableSignal::None => Supply::Always,
            EnableSignal::Level => Supply::Level(false),
            EnableSignal::Pulses => {
                Supply::Relay { level: false, edge_ns: None, dropout_ns: (enable.dropout_s * 1e9) as u64 }
            }
        }
    }

    fn put(&mut self, on: bool, now_ns: u64) {
        match self {
            Supply::Always => {}
            Supply::Level(level) => *level = on,
            Supply::Relay { level, edge_ns, .. } => {
                if std::mem::replace(level, on) != on {
                    *edge_ns = Some(now_ns);
                }
            }
        }
    }

    fn is_on(&self, at_ns: u64) -> bool {
        match *self {
            Supply::Always => true,
            Supply::Level(level) => level,
            Supply::Relay { edge_ns, dropout_ns, .. } => {
                edge_ns.is_some_and(|edge_ns| at_ns.saturating_sub(edge_ns) < dropout_ns)
            }
        }
    }
}

/// Power stage, converters and wires.
pub(crate) struct Wires {
    /// The rig as its file says it is.
    as_filed: Rig,
    rig: SimulatedRig,
    wiring: Wiring,
    supply: Supply,
    /// Channels of the rig by their place on the front-end.
    places: Vec<usize>,
    ranges: [ChannelRange; MAX_CHANNELS],
    period_ns: u64,
    duty: Vec<f64>,
    off: Vec<f64>,
    samples: Vec<Sample>,
    /// When the last simulated period was, on the caller's clock.
    simulated_ns: Option<u64>,
    /// Now, on the caller's clock.
    pub now_ns: u64,
    /// The present outputs, for observers in tests.
    pub put: Arc<[AtomicU16]>,
    /// Every change of what is put out, and when it was made; `None` where nobody asks.
    pub changes: Option<Vec<(u64, Vec<u16>)>>,
    pub broken: [Option<ChannelFault>; MAX_CHANNELS],
    pub sent: Vec<u8>,
    pub told: Vec<Event>,
}

impl Wires {
    pub fn new(
        rig: &Rig,
        put: Arc<[AtomicU16]>,
        wrong: &[Wrong],
        mounts: &[Mount],
    ) -> Result<(Wires, Identification), Error> {
        let channels = rig.channels.len();
        let places: Vec<usize> = (0..channels).map(|index| rig.front_end_index(index).unwrap_or(0) as usize).collect();
        let used = places.iter().map(|place| place + 1).max().unwrap_or(0);
        if used > MAX_CHANNELS {
            return Err(Error::Channels { found: used });
        }
        let mut ranges = [ChannelRange::default(); MAX_CHANNELS];
        for (channel, place) in rig.channels.iter().zip(&places) {
            ranges[*place] = range(channel);
        }
        let period_ns = (1e9 / rig.rate_hz).round() as u64;
        let mut name = [0; 16];
        name[..10].copy_from_slice(b"sinew-host");
        let who = Identification {
            nonce: 0,
            name,
            version: [0, 1, 0],
            serial: rig.name.bytes().fold(1, |hash: u64, byte| hash.wrapping_mul(31).wrapping_add(byte.into())),
            // Its wires are simulated in steps of the rig's own period and no other.
            min_period_ns: period_ns as u32,
            max_period_ns: period_ns as u32,
            max_silence_ns: MAX_SILENCE_NS.max(u32::try_from(2 * period_ns).unwrap_or(u32::MAX)),
            full_code: FULL_CODE,
            features: Features {
                enable: rig.backend.enable.signal != EnableSignal::None,
                stop: rig.backend.estop.fitted,
            },
            reset: ResetCause::PowerOn,
            user: 0,
            unused_ms: 0,
            channels: used as u8,
            channel: ranges,
        };
        let (simulated, wiring) = wired(rig, wrong, mounts)?;
        let wires = Wires {
            as_filed: rig.clone(),
            rig: simulated,
            wiring,
            supply: Supply::of(rig),
            places,
            ranges,
            period_ns,
            duty: vec![0.0; channels],
            off: vec![0.0; channels],
            samples: vec![Sample::NONE; channels],
            simulated_ns: None,
            now_ns: 0,
            put,
            changes: None,
            broken: [None; MAX_CHANNELS],
            sent: Vec::new(),
            told: Vec::new(),
        };
        Ok((wires, who))
    }

    /// Something else at a channel's terminals: of wires a new one.
    ///
    /// # Errors
    /// Wires that cannot be simulated.
    pub fn mount(&mut self, channel: usize, mount: Mount) -> Result<(), Error> {
        let mut mounts = self.wiring.mounts().to_vec();
        let Some(place) = mounts.get_mut(channel) else { return Ok(()) };
        *place = mount;
        (self.rig, self.wiring) = wired(&self.as_filed, self.wiring.wrong(), &mounts)?;
        Ok(())
    }

    /// Wired otherwise, with new wires.
    ///
    /// # Errors
    /// Wires that cannot be simulated.
    pub fn wire(&mut self, wrong: &[Wrong]) -> Result<(), Error> {
        (self.rig, self.wiring) = wired(&self.as_filed, wrong, self.wiring.mounts())?;
        Ok(())
    }

    /// What is wrong with the wiring.
    pub fn wrong(&self) -> &[Wrong] {
        self.wiring.wrong()
    }

    fn show(&mut self, duty: &[u16]) {
        let mut changed = false;
        for (place, put) in self.put.iter().enumerate() {
            let duty = duty.get(place).copied().unwrap_or(0);
            changed |= put.swap(duty, Ordering::Relaxed) != duty;
        }
        if let Some(changes) = self.changes.as_mut().filter(|_| changed) {
            let used = self.places.iter().map(|place| place + 1).max().unwrap_or(0);
            changes.push((now_ns(), self.put.iter().take(used).map(|put| put.load(Ordering::Relaxed)).collect()));
        }
    }

    /// Lets the time pass in which nobody sampled, but for the last period, with nothing put out.
    pub fn rest(&mut self) {
        let before_ns = *self.simulated_ns.get_or_insert(self.now_ns);
        let gone = self.now_ns.saturating_sub(before_ns) / self.period_ns;
        if gone < 2 {
            return;
        }
        for period in 1..gone.min(LONGEST_PAUSE) {
            self.switch(before_ns + period * self.period_ns);
            let _ = self.rig.period(&self.off, &mut self.samples);
        }
        self.simulated_ns = Some(before_ns + (gone - 1) * self.period_ns);
    }

    /// Gives the stages the supply they have at a time, or takes it.
    fn switch(&mut self, at_ns: u64) {
        if self.is_live(at_ns) {
            self.rig.restore();
        } else {
            self.rig.cut();
        }
    }

    /// Whether the stages have a supply at a time.
    fn is_live(&self, at_ns: u64) -> bool {
        self.supply.is_on(at_ns) && self.wiring.is_enabled()
    }

    /// What breaks things in the simulated rig.
    pub fn faults(&self) -> FaultHandle {
        self.rig.faults()
    }

    /// What the wires really have, °C.
    pub fn temperatures_c(&self) -> impl Iterator<Item = f64> {
        (0..self.places.len()).map(|channel| self.rig.truth(channel).map_or(f64::NAN, |truth| truth.temperature_c))
    }
}

impl Hardware for Wires {
    fn begin_period(&mut self, duty: &[u16], _: u32) {
        for (of_wire, place) in self.duty.iter_mut().zip(&self.places) {
            *of_wire = f64::from(duty.get(*place).copied().unwrap_or(0)) / f64::from(FULL_DUTY);
        }
        self.show(duty);
    }

    fn off(&mut self) {
        self.duty.fill(0.0);
        self.show(&[]);
    }

    fn samples(&mut self, samples: &mut [RawSample]) {
        self.rest();
        self.simulated_ns = Some(self.now_ns);
        self.switch(self.now_ns);
        let stages = self.wiring.of_stages(&self.duty);
        let wires = self.wiring.of_wires(&stages);
        if self.rig.period(&wires, &mut self.samples).is_err() && self.samples.is_empty() {
            return;
        }
        let read = self.wiring.read(&self.duty, &stages, self.is_live(self.now_ns), &self.samples);
        for (sample, place) in read.iter().zip(&self.places) {
            let range = &self.ranges[*place];
            if let Some(raw) = samples.get_mut(*place) {
                *raw = RawSample {
                    v1: code(sample.v1_v, range.voltage_uv),
                    v2: code(sample.v2_v, range.voltage_uv),
                    v3: code(sample.v3_v, range.voltage_uv),
                    current: code(sample.current_a, range.current_ua),
                    supply: code(sample.supply_v, range.supply_uv),
                };
            }
        }
    }

    fn enable(&mut self, on: bool) {
        self.supply.put(on, self.now_ns);
    }

    /// As the simulated rig showed them in its last period.
    fn stop_inputs(&mut self) -> Option<StopPins> {
        let inputs = self.rig.stop_inputs()?;
        Some(StopPins { closed: self.wiring.sees_closed(inputs.is_closed), reset_pressed: inputs.is_reset_pressed })
    }

    fn stage_fault(&mut self, channel: usize) -> Option<ChannelFault> {
        self.broken.get(channel).copied().flatten()
    }

    fn send(&mut self, line: &[u8]) {
        self.sent.extend_from_slice(line);
    }

    fn tell(&mut self, event: Event) {
        self.told.push(event);
    }
}

/// Simulated wires in a wiring.
fn wired(rig: &Rig, wrong: &[Wrong], mounts: &[Mount]) -> Result<(SimulatedRig, Wiring), Error> {
    let (real, wiring) = Wiring::new(rig, wrong, mounts, rig.simulation.seed);
    let mut simulated = SimulatedRig::new(&real).map_err(Error::Wires)?;
    wiring.break_wires(&simulated.faults());
    // A simulated rig starts whatever happens.
    let _ = simulated.start();
    // It shows the emergency stop's contact open until its first period.
    let (off, mut samples) = (vec![0.0; rig.channels.len()], vec![Sample::NONE; rig.channels.len()]);
    let _ = simulated.period(&off, &mut samples);
    Ok((simulated, wiring))
}

/// The converters a rig file describes.
fn range(channel: &sinew_rig::Channel) -> ChannelRange {
    let (adc, drive) = (&channel.adc, &channel.model.drive);
    let low_ohm = drive.low_ohm();
    let current_a = match adc.circuit {
        SamplingCircuit::Shared if low_ohm > 0.0 => adc.voltage_range_v / low_ohm,
        _ => adc.current_range_a,
    };
    let micro = |value: f64| (value * 1e6).round().clamp(1.0, u32::MAX.into()) as u32;
    ChannelRange {
        voltage_uv: micro(adc.voltage_range_v),
        current_ua: micro(current_a),
        supply_uv: micro(adc.voltage_range_v.max(1.5 * drive.supply_v)),
        limits: LIMITS,
    }
}

/// The code of a value; full scale is micro-units.
fn code(value: f64, full: u32) -> u16 {
    if value.is_nan() {
        return NOT_SAMPLED;
    }
    (value * 1e6 / f64::from(full) * f64::from(FULL_CODE)).round().clamp(0.0, FULL_CODE.into()) as u16
}
