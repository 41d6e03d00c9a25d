//! A scripted backend of the driver's own tests: first-order wires, deterministic noise, faults by period. Much less than the
//! simulated rig of `sinew-sim-backend`, and independent of it.
#![allow(dead_code)]

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use sinew_backend::{Backend, BackendError, ChannelFault, Past, Sample, Truth, Zero, check_exchange};
use sinew_rig::Rig;

/// A rig of equal wires on bias springs.
pub fn rig(name: &str, channels: usize, rate_hz: f64) -> Rig {
    let mut text = format!("[rig]\nname = \"{name}\"\nrate_hz = {rate_hz:.1}\nambient_c = 25.0\nrealtime = \"off\"\n");
    for channel in 0..channels {
        text += &format!(
            "[[channel]]\nname = \"wire{channel}\"\n\
             wire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
             taps = {{ l0_mm = 0.0, ls_mm = 150.0 }}\n\
             drive = {{ supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = 0.1, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }}\n"
        );
    }
    match Rig::parse(&text, name) {
        Ok(rig) => rig,
        Err(error) => panic!("{error}"),
    }
}

/// What goes wrong with one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mishap {
    NoSample,
    NanVoltage,
    InfiniteCurrent,
    Saturated,
    OpenWire,
    ShortedWire,
    ProbeLost,
    SupplyDip,
    /// A wire partly bridged: more current than allowed.
    OverCurrent,
    SupplyHigh,
    /// Nothing comes out of the output stage.
    StageOff,
    /// The output stage conducts at half the supply's voltage.
    StageWeak,
    /// The output stage conducts whatever it is told.
    StageOn,
    /// The converter repeats its last codes.
    Stuck,
    /// The backend says that this channel has failed.
    ChannelError,
    /// The backend says that it has failed as a whole.
    WholeError,
}

/// From when to when (periods), where, what.
pub type Script = Vec<(Range<u64>, usize, Mishap)>;

#[derive(Debug, Clone, Copy)]
struct Wire {
    temperature_c: f64,
    duty: f64,
    last: Sample,
}

/// What a test can see of a backend that a driver owns.
#[derive(Debug, Default)]
pub struct Watch {
    pub stopped: AtomicBool,
    pub periods: AtomicU64,
    pub panic_at: AtomicU64,
}

pub struct Fake {
    wires: Vec<Wire>,
    period_s: f64,
    period: u64,
    running: bool,
    /// The supply was cut.
    pub cut: bool,
    noise: u64,
    pub script: Script,
    pub watch: Arc<Watch>,
    /// Duty that went to each channel in each period; only with `keep`, because it allocates.
    pub log: Vec<Vec<f64>>,
    pub keep: bool,
    /// What its outputs are called, where they are to outlive it.
    pub outlives: Option<String>,
    /// What its outputs show for a mark of whoever used them last.
    pub mark: u64,
}

const SUPPLY_V: f64 = 6.5;
const SERIES_OHM: f64 = 0.12;
const AREA_M2: f64 = 1.227_184_630_308_513e-8;

impl Fake {
    pub fn new(rig: &Rig) -> Fake {
        let wire = Wire { temperature_c: 25.0, duty: 0.0, last: Sample::NONE };
        Fake {
            wires: vec![wire; rig.channels.len()],
            period_s: 1.0 / rig.rate_hz,
            period: 0,
            running: false,
            cut: false,
            noise: 0x9e37_79b9_7f4a_7c15,
            script: Vec::new(),
            watch: Arc::new(Watch { panic_at: AtomicU64::new(u64::MAX), ..Watch::default() }),
            log: Vec::new(),
            keep: false,
            outlives: None,
            mark: 1,
        }
    }

    /// About normal, standard deviation 1.
    fn noise(&mut self) -> f64 {
        let mut sum = 0.0;
        for _ in 0..4 {
            self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (self.noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        }
        sum * 3f64.sqrt()
    }

    fn length_m(wire: &Wire) -> f64 {
        // Hot 160.6 mm, cold 166.9 mm, the transformation a straight line from 75 to 105 °C.
        0.1669 - 0.0063 * ((wire.temperature_c - 75.0) / 30.0).clamp(0.0, 1.0)
    }

    fn resistance_ohm(wire: &Wire) -> f64 {
        82e-8 * Self::length_m(wire) / AREA_M2
    }

    fn advance(&mut self, periods: u64) {
        for wire in &mut self.wires {
            let r = Self::resistance_ohm(wire);
            let current_a = SUPPLY_V / (r + SERIES_OHM);
            let power_w = wire.duty * current_a * current_a * r;
            // Heat capacity with the latent heat spread over it, and the loss to the air.
            let rate = (power_w - 7.6e-3 * (wire.temperature_c - 25.0)) / 0.0145;
            wire.temperature_c += rate * self.period_s * periods as f64;
        }
        self.period += periods;
        self.watch.periods.store(self.period, Ordering::Relaxed);
    }

    fn mishap(&self, channel: usize) -> Option<Mishap> {
        self.script.iter().find(|(when, where_, _)| *where_ == channel && when.contains(&self.period)).map(|s| s.2)
    }

    fn sample(&mut self, channel: usize, mishap: Option<Mishap>) -> Sample {
        let wire = self.wires[channel];
        if wire.duty == 0.0 && (mishap != Some(Mishap::StageOn) || self.cut) {
            return Sample::NONE;
        }
        let supply_v = match mishap {
            Some(Mishap::SupplyDip) => 0.5 * SUPPLY_V,
            Some(Mishap::SupplyHigh) => 1.35 * SUPPLY_V,
            _ => SUPPLY_V,
        };
        let r = match mishap {
            Some(Mishap::ShortedWire) => 0.05,
            Some(Mishap::OpenWire) => 1e7,
            Some(Mishap::OverCurrent) => 0.74 * Self::resistance_ohm(&wire),
            _ => Self::resistance_ohm(&wire),
        };
        let stage_ohm = match mishap {
            Some(Mishap::StageOff) => 1e9,
            Some(Mishap::StageWeak) => r,
            _ => 0.0,
        };
        let current_a = supply_v / (r + SERIES_OHM + stage_ohm);
        let v3_v = current_a * r;
        let v2_v = v3_v * 0.150 / Self::length_m(&wire);
        let mut sample = Sample {
            v1_v: 0.0015 * self.noise(),
            v2_v: v2_v + 0.0015 * self.noise(),
            v3_v: v3_v + 0.0015 * self.noise(),
            current_a: current_a + 0.0004 * self.noise(),
            supply_v: supply_v + 0.003 * self.noise(),
        };
        match mishap {
            Some(Mishap::NoSample) => sample = Sample::NONE,
            Some(Mishap::NanVoltage) => sample.v3_v = f64::NAN,
            Some(Mishap::InfiniteCurrent) => sample.current_a = f64::INFINITY,
            Some(Mishap::Saturated) => (sample.v2_v, sample.v3_v) = (10.0, 10.0),
            Some(Mishap::ProbeLost) => sample.v2_v = 0.0015 * self.noise(),
            Some(Mishap::Stuck) => sample = wire.last,
            _ => {}
        }
        self.wires[channel].last = sample;
        sample
    }
}

impl Backend for Fake {
    fn channels(&self) -> usize {
        self.wires.len()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.running = true;
        self.watch.stopped.store(false, Ordering::Relaxed);
        for wire in &mut self.wires {
            wire.duty = 0.0;
        }
        Ok(())
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        if !self.running {
            return Err(BackendError::NotStarted);
        }
        check_exchange(self.wires.len(), duty, samples)?;
        self.advance(1);
        assert!(self.period < self.watch.panic_at.load(Ordering::Relaxed), "the script says: panic");
        let mut answer = Ok(());
        for (channel, sample) in samples.iter_mut().enumerate() {
            let mishap = self.mishap(channel);
            *sample = self.sample(channel, mishap);
            if mishap == Some(Mishap::ChannelError) {
                *sample = Sample::NONE;
                let fault = ChannelFault::Converter;
                answer = answer.and(Err(BackendError::Channel { channel: channel as u32, fault }));
            }
            if mishap == Some(Mishap::WholeError) {
                answer = Err(BackendError::Io { os_error: 5 });
            }
        }
        for (wire, duty) in self.wires.iter_mut().zip(duty) {
            wire.duty = if answer.is_err_and(|error| error.channel().is_none()) { 0.0 } else { *duty };
        }
        if self.keep {
            self.log.push(duty.to_vec());
        }
        answer
    }

    fn cut(&mut self) -> bool {
        self.cut = true;
        true
    }

    fn missed(&mut self, periods: u64) {
        self.advance(periods);
    }

    fn silence_s(&self) -> Option<f64> {
        Some(0.1)
    }

    fn is_at_rest(&self) -> bool {
        self.outlives.is_none()
    }

    fn past(&self, _: usize) -> Past {
        Past { mark: self.mark, ..Past::UNKNOWN }
    }

    fn mark(&self, _: usize) -> u64 {
        self.mark
    }

    fn output_name(&self, channel: usize) -> Option<String> {
        self.outlives.as_ref().map(|name| format!("{name}/{channel}"))
    }

    fn stop(&mut self) -> Zero {
        self.running = false;
        for wire in &mut self.wires {
            wire.duty = 0.0;
        }
        self.watch.stopped.store(true, Ordering::Relaxed);
        Zero::Confirmed
    }

    fn truth(&self, channel: usize) -> Option<Truth> {
        let wire = self.wires.get(channel)?;
        let resistance_ohm = Self::resistance_ohm(wire);
        let current_a = SUPPLY_V / (resistance_ohm + SERIES_OHM);
        Some(Truth {
            length_m: Self::length_m(wire),
            velocity_m_s: 0.0,
            temperature_c: wire.temperature_c,
            martensite: 1.0 - ((wire.temperature_c - 75.0) / 30.0).clamp(0.0, 1.0),
            force_n: 2.4,
            resistance_ohm,
            power_w: wire.duty * current_a * current_a * resistance_ohm,
            duty: wire.duty,
        })
    }
}
