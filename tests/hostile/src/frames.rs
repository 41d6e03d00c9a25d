//! Bytes for a front-end: off the line into its decoder, and through its firmware to its outputs.

use std::sync::LazyLock;

use sinew_front_end::{
    ChannelLimits, ChannelRange, Configure, Decoder, Duty, EnableMode, Features, Firmware, Frame, Hardware,
    Identification, MAX_BODY, MAX_CHANNELS, MAX_FRAME, RawSample, ResetCause, State, StopPins, decode, encode,
};

use crate::script::Script;

/// Channels of the front-end: a few, so that most inputs are about all of them.
const CHANNELS: usize = 3;
/// Longest it may go on by itself, ns.
const MOST_SILENCE_NS: u64 = 50_000_000;
/// What its hardware bears: no configuration goes beyond.
const HARDWARE: ChannelLimits =
    ChannelLimits { max_duty: 40_000, max_current_ma: 2000, heat_ma2_s: 4_000_000, drain_ma2: 250_000 };

static FRONT_END: LazyLock<Identification> = LazyLock::new(|| {
    let range = ChannelRange { voltage_uv: 8_000_000, current_ua: 3_000_000, supply_uv: 16_000_000, limits: HARDWARE };
    Identification {
        nonce: 0,
        name: *b"hostile\0\0\0\0\0\0\0\0\0",
        version: [1, 2, 3],
        serial: 7,
        min_period_ns: 50_000,
        max_period_ns: 100_000_000,
        max_silence_ns: MOST_SILENCE_NS as u32,
        full_code: 4095,
        features: Features { enable: true, stop: true },
        reset: ResetCause::Unknown,
        user: 0,
        unused_ms: 0,
        channels: CHANNELS as u8,
        channel: [range; MAX_CHANNELS],
    }
});

/// Bytes off a line, into the decoder: they are frames or they are not, and a frame is the same when it is sent again.
///
/// # Panics
/// Where the decoder breaks a promise.
pub fn line(bytes: &[u8]) {
    let mut decoder = Decoder::<MAX_BODY>::new();
    for &byte in bytes {
        if let Some(Ok(body)) = decoder.push(byte) {
            again(body);
        }
    }
    // And past the checksum, which hardly any bytes have right.
    again(bytes);
}

/// What is read of a body is written and read back.
fn again(body: &[u8]) {
    let Ok(frame) = decode(body) else { return };
    let mut line = [0; MAX_FRAME];
    let length = encode(&frame, &mut line).unwrap_or_else(|e| panic!("was read, cannot be written: {e}: {frame:?}"));
    let mut decoder = Decoder::<MAX_BODY>::new();
    let mut found = None;
    for &byte in &line[..length] {
        if let Some(body) = decoder.push(byte) {
            found = Some(body.and_then(decode));
        }
    }
    assert_eq!(found, Some(Ok(frame)), "another frame came back");
}

/// A script for the firmware: frames, damaged ones, any bytes, and time that passes.
///
/// Whatever it is, nothing is put out beyond the limits of hardware and configuration, nothing unless it runs, nothing when no good
/// frame has come for longer than the front-end and the last frame allow, nothing while the emergency stop it was told to look at was seen
/// open, and the enable pin is on only where all of that lets something be put out; what it sends can be read, and names the session
/// under which anything was put out last.
///
/// # Panics
/// Where the firmware breaks a promise.
pub fn firmware(bytes: &[u8]) {
    let mut script = Script::new(bytes);
    let mut bench = Bench {
        firmware: Firmware::new(*FRONT_END),
        stage: Stage::new(),
        now_ns: 1,
        heard_ns: 0,
        valid_ns: 0,
        sequence: 0,
    };
    while let Some(step) = script.step() {
        match step % 8 {
            0 => bench.send(&Frame::Hello { nonce: script.u32() }, &mut script),
            1 => {
                let wanted = configure(&mut script);
                bench.send(&Frame::Configure(wanted), &mut script);
            }
            // the usual case most of the time
            2..=4 => {
                let skip = if step & 0x80 == 0 { 1 } else { script.u32() };
                bench.sequence = bench.sequence.wrapping_add(skip);
                let mut duty = [0; MAX_CHANNELS];
                for duty in &mut duty[..CHANNELS] {
                    *duty = if step & 0x40 == 0 { 0 } else { script.u16() };
                }
                let whims = step & 0x20 != 0;
                let channels = if whims { script.byte() % MAX_CHANNELS as u8 } else { CHANNELS as u8 };
                let valid_us = if whims { script.u32() } else { u32::MAX };
                let supply = step & 0x10 == 0;
                bench.send(
                    &Frame::Duty(Duty { sequence: bench.sequence, valid_us, supply, channels, duty }),
                    &mut script,
                );
            }
            5 if step & 0x80 != 0 => bench.send(&Frame::Clear { channel: script.byte() }, &mut script),
            5 if step & 0x40 != 0 => {
                let pins = script.byte();
                let stop = StopPins { closed: pins & 1 == 0, reset_pressed: pins & 2 != 0 };
                bench.stage.stop = (pins & 4 == 0).then_some(stop);
            }
            5 => bench.send(&Frame::Off, &mut script),
            6 => {
                let most = usize::from(script.byte() % 64);
                let raw = script.bytes(most);
                bench.line(raw);
            }
            _ => {
                // from a µs to longer than any silence
                let step_us = 1u64 << (script.byte() % 18);
                bench.stage.current = script.u16();
                bench.wait(step_us * 1000);
            }
        }
    }
    // And whatever it was doing: the driver falls silent.
    bench.wait(MOST_SILENCE_NS + 1);
    assert!(bench.stage.put.iter().all(|duty| *duty == 0), "powered by nobody: {:?}", bench.stage.put);
    assert!(!bench.stage.is_enabled, "enabled by nobody");
    // Who is asked for nothing may go on running on nothing.
    assert!(bench.firmware.put_out().iter().all(|duty| *duty == 0));
}

/// The firmware on its stage, with time of its own.
struct Bench {
    firmware: Firmware,
    stage: Stage,
    now_ns: u64,
    /// When the last good frame came that says that there is a driver.
    heard_ns: u64,
    /// How long the last duty frame of them is valid.
    valid_ns: u64,
    sequence: u32,
}

impl Bench {
    fn send(&mut self, frame: &Frame, script: &mut Script) {
        let mut line = [0; MAX_FRAME];
        let Ok(length) = encode(frame, &mut line) else { return };
        let good = line[..length].to_vec();
        let mut line = good.clone();
        let damage = script.u32();
        if damage & 0xf0 == 0xf0 {
            let at = damage as usize % length;
            line[at] ^= (damage >> 24) as u8;
        }
        // What is whole counts as heard; whether a configuration is taken, the firmware says.
        let whole = line == good;
        match frame {
            Frame::Configure(wanted) if whole => {
                self.stage.wanted = wanted.limits.map(|limits| limits.max_duty.min(HARDWARE.max_duty));
                self.stage.watches = wanted.uses_stop;
                (self.heard_ns, self.valid_ns) = (self.now_ns, u64::MAX);
            }
            // One that is not taken, being older than the last, says nothing.
            Frame::Duty(duty) if whole => {
                let valid_ns = u64::from(duty.valid_us) * 1000;
                (self.heard_ns, self.valid_ns) = (self.now_ns, self.valid_ns.max(valid_ns));
            }
            _ => {}
        }
        self.line(&line);
    }

    fn line(&mut self, bytes: &[u8]) {
        self.firmware.receive(bytes, self.now_ns, &mut self.stage);
        self.look();
    }

    /// Lets time pass; the firmware is called when it asks to be, as a timer would.
    fn wait(&mut self, ns: u64) {
        let end_ns = self.now_ns + ns;
        let mut calls = 0u32;
        loop {
            let next_ns = self.firmware.poll(self.now_ns, &mut self.stage);
            self.look();
            calls += 1;
            // A period is 50 µs at least, and has a beginning, a sampling, an end and four looks at the emergency stop.
            assert!(u64::from(calls) < 16 + ns / 5000, "it asks to be called for ever");
            match next_ns {
                Some(next_ns) if next_ns <= end_ns => self.now_ns = self.now_ns.max(next_ns),
                _ => break,
            }
        }
        self.now_ns = end_ns;
        self.firmware.poll(self.now_ns, &mut self.stage);
        self.look();
    }

    fn look(&self) {
        let put = &self.stage.put;
        let powered = put.iter().any(|duty| *duty > 0);
        for (channel, (duty, most)) in put.iter().zip(&self.stage.max_duty).enumerate() {
            assert!(duty <= most, "channel {channel} gets {duty}, may have {most}");
        }
        if powered {
            assert_eq!(self.firmware.state(), State::Running, "powered and not running");
            let silent_ns = self.now_ns - self.heard_ns;
            let most_ns = MOST_SILENCE_NS.min(self.valid_ns);
            assert!(silent_ns <= most_ns, "powered {silent_ns} ns after the last good frame, may be for {most_ns}");
        }
        if powered || self.stage.is_enabled {
            assert_eq!(self.firmware.state(), State::Running, "enabled and not running");
            assert!(!self.stage.saw_open, "the emergency stop was seen open");
        }
    }
}

/// A power stage that remembers what it is told, and the other end of the line.
struct Stage {
    /// What is put out.
    put: Vec<u16>,
    /// What may be, by hardware and the configuration in force.
    max_duty: [u16; MAX_CHANNELS],
    /// The same by the configuration sent last.
    wanted: [u16; MAX_CHANNELS],
    /// What the converters show.
    current: u16,
    /// The enable pin; what the emergency stop's pins show, and whether it was open when it was last looked at, if it is to be looked at
    /// by the configuration in force and by the one sent last.
    is_enabled: bool,
    stop: Option<StopPins>,
    saw_open: bool,
    is_watching: bool,
    watches: bool,
    /// Session of the configuration in force, and of the one under which anything was put out last.
    session: u32,
    user: u32,
    decoder: Decoder<MAX_BODY>,
}

impl Stage {
    fn new() -> Stage {
        Stage {
            put: Vec::new(),
            max_duty: [0; MAX_CHANNELS],
            wanted: [0; MAX_CHANNELS],
            current: 0,
            is_enabled: false,
            stop: Some(StopPins { closed: true, reset_pressed: false }),
            saw_open: false,
            is_watching: false,
            watches: false,
            session: 0,
            user: 0,
            decoder: Decoder::new(),
        }
    }
}

impl Hardware for Stage {
    fn begin_period(&mut self, duty: &[u16], period_ns: u32) {
        assert!(period_ns > 0 && duty.len() <= CHANNELS, "{period_ns} ns, {} channels", duty.len());
        duty.clone_into(&mut self.put);
        if duty.iter().any(|duty| *duty > 0) {
            self.user = self.session;
        }
    }

    fn off(&mut self) {
        self.put.fill(0);
    }

    fn enable(&mut self, on: bool) {
        self.is_enabled = on;
    }

    fn stop_inputs(&mut self) -> Option<StopPins> {
        self.saw_open = self.stop.is_none_or(|stop| !stop.closed);
        self.stop
    }

    fn samples(&mut self, samples: &mut [RawSample]) {
        let code = self.current;
        samples.fill(RawSample { v1: 100, v2: 200, v3: 300, current: code, supply: 3000 });
    }

    fn send(&mut self, line: &[u8]) {
        let mut frames = 0;
        for &byte in line {
            let Some(body) = self.decoder.push(byte) else { continue };
            match body.and_then(decode) {
                Ok(Frame::Configured { refusal: None, session }) => {
                    (self.max_duty, self.is_watching) = (self.wanted, self.watches);
                    self.session = session;
                    self.saw_open &= self.is_watching;
                }
                Ok(Frame::Identification(who)) => {
                    assert_eq!(who.user, self.user, "who has used it");
                    assert!(
                        who.unused_ms == 0 || self.put.iter().all(|duty| *duty == 0),
                        "used, and says for how long not"
                    );
                }
                Ok(Frame::Configured { .. } | Frame::Samples(_)) => {}
                other => panic!("it sent {other:?}"),
            }
            frames += 1;
        }
        assert_eq!(frames, 1, "one call, one frame");
    }
}

/// Mostly one that is taken.
fn configure(script: &mut Script) -> Configure {
    let whim = script.u32();
    let mut limits = [ChannelLimits::default(); MAX_CHANNELS];
    for limits in &mut limits[..CHANNELS] {
        let (duty, current) = (script.u16(), script.u16());
        *limits = ChannelLimits {
            max_duty: duty,
            max_current_ma: current,
            heat_ma2_s: script.u32(),
            drain_ma2: script.u32(),
        };
    }
    Configure {
        session: whim,
        period_ns: if whim & 0x10 == 0 { 1_000_000 } else { script.u32() },
        watchdog_periods: if whim & 0x20 == 0 { 5 } else { script.u16() },
        enable: [EnableMode::None, EnableMode::Level, EnableMode::Pulses, EnableMode::Level][whim as usize & 3],
        uses_stop: whim & 4 != 0,
        channels: if whim & 0x40 == 0 { CHANNELS as u8 } else { script.byte() % MAX_CHANNELS as u8 },
        limits,
    }
}
