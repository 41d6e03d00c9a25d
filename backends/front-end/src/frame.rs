//! The frame format: every kind, its fields and their units. Numbers are little-endian; `docs/front-end.md` has the offsets.

use crate::error::Error;
use crate::version::VERSION;
use crate::wire;

/// Most channels of a front-end.
pub const MAX_CHANNELS: usize = 64;
/// Instead of a code: nothing was sampled.
pub const NOT_SAMPLED: u16 = u16::MAX;
/// The duty that is always on.
pub const FULL_DUTY: u16 = u16::MAX;
/// Bytes of a front-end's name.
pub const NAME_BYTES: usize = 16;

const HELLO: u8 = 0x01;
const CONFIGURE: u8 = 0x02;
const DUTY: u8 = 0x03;
const OFF: u8 = 0x04;
const CLEAR: u8 = 0x05;
const IDENTIFICATION: u8 = 0x81;
const CONFIGURED: u8 = 0x82;
const SAMPLES: u8 = 0x83;

/// A frame, either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "frames live on the stack of whoever handles them; there is no heap")]
pub enum Frame {
    /// Down: who is there? Answered by an identification that carries the same number. Nothing else changes.
    Hello {
        /// Any number.
        nonce: u32,
    },
    /// Down: what the wires may have.
    Configure(Configure),
    /// Down: the duties of the period that begins with this frame.
    Duty(Duty),
    /// Down: all outputs off, now.
    Off,
    /// Down: a client has reset a channel; its fault is to be forgotten, unless its cause may still be there.
    Clear {
        /// Which.
        channel: u8,
    },
    /// Up: who is there, and what it can do.
    Identification(Identification),
    /// Up: whether a configuration is in force.
    Configured {
        /// The configuration's.
        session: u32,
        /// Why it is not; the one before it is gone as well.
        refusal: Option<Refusal>,
    },
    /// Up: what was sampled in the period of a duty frame, and how the front-end is.
    Samples(Samples),
}

/// What the wires may have. Limits are the narrower of these and the front-end's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Configure {
    /// A random number, not 0, by which the front-end names whoever drove its outputs last; the answer carries it.
    pub session: u32,
    /// Length of a period, ns.
    pub period_ns: u32,
    /// Periods without a good frame after which outputs go off.
    pub watchdog_periods: u16,
    /// What its enable pin is to carry while outputs may be powered.
    pub enable: EnableMode,
    /// Whether the contact of its emergency stop has to be closed for anything to be put out.
    pub uses_stop: bool,
    /// How many of the channels are used, from the first.
    pub channels: u8,
    /// Of each of them.
    pub limits: [ChannelLimits; MAX_CHANNELS],
}

/// What one channel may have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChannelLimits {
    /// Largest duty, of 65535; more is cut down to it.
    pub max_duty: u16,
    /// Largest current in the on-phase, mA; more switches the channel off.
    pub max_current_ma: u16,
    /// Largest I²t beyond what drains, mA² s; more switches the channel off.
    pub heat_ma2_s: u32,
    /// What drains of it: the mean square of the current that may flow for ever, mA².
    pub drain_ma2: u32,
}

/// Duties down.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Duty {
    /// One more than that of the frame before it.
    pub sequence: u32,
    /// So long after it came no output is on any more unless another one came, µs; 0 is no frame.
    pub valid_us: u32,
    /// Whether the enable pin may be on.
    pub supply: bool,
    /// How many channels follow: all that are used.
    pub channels: u8,
    /// Of each, of 65535.
    pub duty: [u16; MAX_CHANNELS],
}

/// Who is there, and what it can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identification {
    /// That of the hello it answers.
    pub nonce: u32,
    /// Name of the firmware, UTF-8, zeros behind it.
    pub name: [u8; NAME_BYTES],
    /// Its version: major, minor, patch.
    pub version: [u8; 3],
    /// Serial number of the device.
    pub serial: u64,
    /// Shortest period, ns.
    pub min_period_ns: u32,
    /// Longest period, ns.
    pub max_period_ns: u32,
    /// Longest time it goes on without a good frame, ns, whatever a configuration says.
    pub max_silence_ns: u32,
    /// The largest code of its converters; it stands for full scale.
    pub full_code: u16,
    /// Which pins it has beside those of the channels.
    pub features: Features,
    /// Why it last started.
    pub reset: ResetCause,
    /// Session of the configuration under which anything was put out last, since it started; 0 = nothing was.
    pub user: u32,
    /// For how long nothing has been put out, ms, at the most since it started; 4294967295 = that or more.
    pub unused_ms: u32,
    /// How many channels there are.
    pub channels: u8,
    /// Of each of them.
    pub channel: [ChannelRange; MAX_CHANNELS],
}

/// What a channel's converters measure, and what its hardware bears.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChannelRange {
    /// Full scale of V1, V2 and V3, µV.
    pub voltage_uv: u32,
    /// Full scale of the current, µA.
    pub current_ua: u32,
    /// Full scale of the supply, µV.
    pub supply_uv: u32,
    /// What the hardware bears: no configuration goes beyond.
    pub limits: ChannelLimits,
}

/// Pins beside those of the channels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Features {
    /// One that switches the supply of all power stages.
    pub enable: bool,
    /// Those of an emergency stop.
    pub stop: bool,
}

/// What an enable pin carries while outputs may be powered.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum EnableMode {
    /// Nothing: it is not used, and stays off.
    #[default]
    None,
    /// A level.
    Level,
    /// An edge a period, for a watchdog relay.
    Pulses,
}

/// Why a microcontroller last started.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum ResetCause {
    /// It cannot tell.
    #[default]
    Unknown,
    /// Its supply came.
    PowerOn,
    /// Its supply was too low for a while.
    BrownOut,
    /// Its own watchdog: the firmware stood still.
    Watchdog,
    /// The firmware itself, or a debugger.
    Software,
}

/// Why a configuration is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// More channels than there are, or none.
    Channels,
    /// A period it cannot keep.
    Period,
    /// Outputs would stay on longer without a frame than it allows.
    Silence,
    /// An enable pin or an emergency stop that it has not.
    Features,
}

/// Samples up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// That of the duty frame whose period they are of.
    pub sequence: u32,
    /// How it is.
    pub state: State,
    /// Whether the emergency stop's contact was open at any time since the samples before.
    pub stop_open: bool,
    /// Whether its reset button is pressed.
    pub reset_pressed: bool,
    /// From the beginning of the duty frame's period to this frame, µs; 65535 = that or more.
    pub after_us: u16,
    /// Its clock, µs, from any beginning, overflowing.
    pub clock_us: u32,
    /// Duty frames that did not come, as their sequence tells, overflowing.
    pub lost: u16,
    /// Frames that came damaged, doubled, in the wrong order or too early, overflowing.
    pub refused: u16,
    /// How many channels follow: all that are used.
    pub channels: u8,
    /// Of each.
    pub sample: [RawSample; MAX_CHANNELS],
    /// What is wrong with each.
    pub fault: [Option<ChannelFault>; MAX_CHANNELS],
    /// Which duties were cut down to a limit, or to what drains of a full account of I²t: bit 0 = channel 0.
    pub limited: u64,
}

/// Codes of the converters at the end of an on-phase, with duty 0 in the dark, [`NOT_SAMPLED`] where there was none. A channel that
/// was not given the duty its frame asked for has none but the supply's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawSample {
    /// First tap, of the voltages' full scale.
    pub v1: u16,
    /// Second tap.
    pub v2: u16,
    /// The moving end.
    pub v3: u16,
    /// Current, of its full scale.
    pub current: u16,
    /// Supply, of its full scale.
    pub supply: u16,
}

impl RawSample {
    /// Nothing was sampled.
    pub const NONE: RawSample =
        RawSample { v1: NOT_SAMPLED, v2: NOT_SAMPLED, v3: NOT_SAMPLED, current: NOT_SAMPLED, supply: NOT_SAMPLED };
}

/// What a front-end is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Not configured: outputs off.
    Boot,
    /// Configured, not yet asked for nothing often enough to be trusted with something: outputs off.
    Ready,
    /// Outputs as the duty frames say.
    Running,
    /// Silence has switched outputs off; leaves as `Ready` does.
    Tripped,
    /// The emergency stop has switched outputs off; leaves as `Ready` does, once its contact is closed.
    Stopped,
}

/// What is wrong with a channel. Its output is off until it is told to forget that, see [`Frame::Clear`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelFault {
    /// The current was above its limit in two periods one after the other.
    OverCurrent,
    /// I²t went a fifth beyond its budget, although the duty had been cut down before.
    Heat,
    /// It was on and no current could be measured, in two periods one after the other.
    Converter,
    /// The power stage says so itself: over-temperature.
    StageHot,
    /// The power stage says so itself, or conducted with duty 0 in two such periods one after the other.
    Stage,
}

/// The codes of a field's values on the line: their places in a table.
macro_rules! codes {
    ($of:ty: $($value:expr),+ $(,)?) => {
        impl Coded for $of {
            const ALL: &'static [$of] = &[$($value),+];
        }
    };
}

trait Coded: Copy + PartialEq + 'static {
    const ALL: &'static [Self];

    fn code(self) -> u8 {
        Self::ALL.iter().position(|value| *value == self).unwrap_or(0) as u8
    }

    fn of(code: u8) -> Result<Self, Error> {
        Self::ALL.get(usize::from(code)).copied().ok_or(Error::Value)
    }
}

codes!(bool: false, true);
codes!(State: State::Boot, State::Ready, State::Running, State::Tripped, State::Stopped);
codes!(EnableMode: EnableMode::None, EnableMode::Level, EnableMode::Pulses);
codes!(
    ResetCause: ResetCause::Unknown,
    ResetCause::PowerOn,
    ResetCause::BrownOut,
    ResetCause::Watchdog,
    ResetCause::Software,
);
codes!(
    Option<ChannelFault>: None,
    Some(ChannelFault::OverCurrent),
    Some(ChannelFault::Heat),
    Some(ChannelFault::Converter),
    Some(ChannelFault::StageHot),
    Some(ChannelFault::Stage),
);
codes!(
    Option<Refusal>: None,
    Some(Refusal::Channels),
    Some(Refusal::Period),
    Some(Refusal::Silence),
    Some(Refusal::Features),
);

/// Writes a frame as it goes over the line, zeros and checksum included; gives how many bytes that is. A `line` of
/// [`wire::MAX_FRAME`] bytes holds any frame.
///
/// # Errors
/// [`Error::NoRoom`] where `line` is too short, [`Error::Value`] for more channels than there can be.
pub fn encode(frame: &Frame, line: &mut [u8]) -> Result<usize, Error> {
    let mut body = [0; wire::MAX_BODY];
    let mut to = Writer { body: &mut body, at: 0 };
    to.frame(frame)?;
    let length = to.at;
    wire::put(body.get(..length).ok_or(Error::NoRoom)?, line)
}

/// Reads a body that came off the line whole, see [`wire::Decoder::push`].
///
/// # Errors
/// Whatever is wrong with it.
pub fn decode(body: &[u8]) -> Result<Frame, Error> {
    let mut from = Reader { body };
    match from.u8()? {
        VERSION => {}
        found => return Err(Error::Version { found }),
    }
    let frame = from.frame()?;
    if from.body.is_empty() { Ok(frame) } else { Err(Error::Length) }
}

/// Writes a hello as a front-end of protocol `version` reads it: its layout is that of all versions, so that each finds out what the
/// other speaks. Otherwise as [`encode`].
///
/// # Errors
/// [`Error::NoRoom`] where `line` is too short.
pub fn encode_hello(version: u8, nonce: u32, line: &mut [u8]) -> Result<usize, Error> {
    let [a, b, c, d] = nonce.to_le_bytes();
    wire::put(&[version, HELLO, a, b, c, d], line)
}

/// As [`decode`], of frames that go down: a hello is one whatever its version.
pub(crate) fn decode_on_device(body: &[u8]) -> Result<Frame, Error> {
    match (decode(body), body) {
        (Err(Error::Version { .. }), [_, HELLO, a, b, c, d]) => {
            Ok(Frame::Hello { nonce: u32::from_le_bytes([*a, *b, *c, *d]) })
        }
        (decoded, _) => decoded,
    }
}

struct Writer<'a> {
    body: &'a mut [u8],
    at: usize,
}

impl Writer<'_> {
    fn bytes(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let end = self.at + bytes.len();
        self.body.get_mut(self.at..end).ok_or(Error::NoRoom)?.copy_from_slice(bytes);
        self.at = end;
        Ok(())
    }

    fn u8(&mut self, value: u8) -> Result<(), Error> {
        self.bytes(&[value])
    }

    fn u16(&mut self, value: u16) -> Result<(), Error> {
        self.bytes(&value.to_le_bytes())
    }

    fn u32(&mut self, value: u32) -> Result<(), Error> {
        self.bytes(&value.to_le_bytes())
    }

    fn u64(&mut self, value: u64) -> Result<(), Error> {
        self.bytes(&value.to_le_bytes())
    }

    /// Two flags in a byte, the first as its lowest bit.
    fn bits(&mut self, [first, second]: [bool; 2]) -> Result<(), Error> {
        self.u8(first.code() | second.code() << 1)
    }

    fn limits(&mut self, limits: &ChannelLimits) -> Result<(), Error> {
        self.u16(limits.max_duty)?;
        self.u16(limits.max_current_ma)?;
        self.u32(limits.heat_ma2_s)?;
        self.u32(limits.drain_ma2)
    }

    fn frame(&mut self, frame: &Frame) -> Result<(), Error> {
        self.u8(VERSION)?;
        match frame {
            Frame::Hello { nonce } => {
                self.u8(HELLO)?;
                self.u32(*nonce)
            }
            Frame::Configure(configure) => {
                self.u8(CONFIGURE)?;
                self.u32(configure.session)?;
                self.u32(configure.period_ns)?;
                self.u16(configure.watchdog_periods)?;
                self.u8(configure.enable.code())?;
                self.u8(configure.uses_stop.code())?;
                self.u8(configure.channels)?;
                let limits = configure.limits.get(..usize::from(configure.channels)).ok_or(Error::Value)?;
                limits.iter().try_for_each(|limits| self.limits(limits))
            }
            Frame::Duty(duty) => {
                self.u8(DUTY)?;
                self.u32(duty.sequence)?;
                self.u32(valid(duty.valid_us)?)?;
                self.bits([duty.supply, false])?;
                self.u8(duty.channels)?;
                let duties = duty.duty.get(..usize::from(duty.channels)).ok_or(Error::Value)?;
                duties.iter().try_for_each(|duty| self.u16(*duty))
            }
            Frame::Off => self.u8(OFF),
            Frame::Clear { channel } => {
                self.u8(CLEAR)?;
                self.u8(*channel)
            }
            Frame::Identification(who) => {
                self.u8(IDENTIFICATION)?;
                self.u32(who.nonce)?;
                self.bytes(&who.name)?;
                self.bytes(&who.version)?;
                self.u64(who.serial)?;
                self.u32(who.min_period_ns)?;
                self.u32(who.max_period_ns)?;
                self.u32(who.max_silence_ns)?;
                self.u16(who.full_code)?;
                self.bits([who.features.enable, who.features.stop])?;
                self.u8(who.reset.code())?;
                self.u32(who.user)?;
                self.u32(who.unused_ms)?;
                self.u8(who.channels)?;
                let ranges = who.channel.get(..usize::from(who.channels)).ok_or(Error::Value)?;
                ranges.iter().try_for_each(|range| {
                    self.u32(range.voltage_uv)?;
                    self.u32(range.current_ua)?;
                    self.u32(range.supply_uv)?;
                    self.limits(&range.limits)
                })
            }
            Frame::Configured { session, refusal } => {
                self.u8(CONFIGURED)?;
                self.u32(*session)?;
                self.u8(refusal.code())
            }
            Frame::Samples(samples) => self.samples(samples),
        }
    }

    fn samples(&mut self, samples: &Samples) -> Result<(), Error> {
        let channels = usize::from(samples.channels);
        let (Some(sample), Some(fault)) = (samples.sample.get(..channels), samples.fault.get(..channels)) else {
            return Err(Error::Value);
        };
        // Faults and cut duties are rare: they are only there when there are any.
        let faulty = fault.iter().any(Option::is_some) || samples.limited != 0;
        self.u8(SAMPLES)?;
        self.u32(samples.sequence)?;
        self.u8(samples.state.code())?;
        self.bits([samples.stop_open, samples.reset_pressed])?;
        self.u16(samples.after_us)?;
        self.u32(samples.clock_us)?;
        self.u16(samples.lost)?;
        self.u16(samples.refused)?;
        self.u8(samples.channels)?;
        self.u8(faulty.code())?;
        for raw in sample {
            for code in [raw.v1, raw.v2, raw.v3, raw.current, raw.supply] {
                self.u16(code)?;
            }
        }
        if faulty {
            self.u64(samples.limited)?;
            fault.iter().try_for_each(|fault| self.u8(fault.code()))?;
        }
        Ok(())
    }
}

/// The validity of a duty frame: one that is none is no frame.
fn valid(valid_us: u32) -> Result<u32, Error> {
    if valid_us > 0 { Ok(valid_us) } else { Err(Error::Value) }
}

struct Reader<'a> {
    body: &'a [u8],
}

impl Reader<'_> {
    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        let (first, rest) = self.body.split_first_chunk::<N>().ok_or(Error::Length)?;
        self.body = rest;
        Ok(*first)
    }

    fn u8(&mut self) -> Result<u8, Error> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, Error> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Error> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Error> {
        self.array().map(u64::from_le_bytes)
    }

    fn value<T: Coded>(&mut self) -> Result<T, Error> {
        T::of(self.u8()?)
    }

    fn bits(&mut self) -> Result<[bool; 2], Error> {
        let bits = self.u8()?;
        if bits <= 0b11 { Ok([bits & 1 != 0, bits & 2 != 0]) } else { Err(Error::Value) }
    }

    fn channels(&mut self) -> Result<u8, Error> {
        let channels = self.u8()?;
        if usize::from(channels) <= MAX_CHANNELS { Ok(channels) } else { Err(Error::Value) }
    }

    fn limits(&mut self) -> Result<ChannelLimits, Error> {
        Ok(ChannelLimits {
            max_duty: self.u16()?,
            max_current_ma: self.u16()?,
            heat_ma2_s: self.u32()?,
            drain_ma2: self.u32()?,
        })
    }

    fn frame(&mut self) -> Result<Frame, Error> {
        Ok(match self.u8()? {
            HELLO => Frame::Hello { nonce: self.u32()? },
            CONFIGURE => {
                let (session, period_ns) = (self.u32()?, self.u32()?);
                let (watchdog_periods, enable, uses_stop) = (self.u16()?, self.value()?, self.value()?);
                let channels = self.channels()?;
                let mut limits = [ChannelLimits::default(); MAX_CHANNELS];
                for limits in limits.iter_mut().take(channels.into()) {
                    *limits = self.limits()?;
                }
                Frame::Configure(Configure {
                    session,
                    period_ns,
                    watchdog_periods,
                    enable,
                    uses_stop,
                    channels,
                    limits,
                })
            }
            DUTY => {
                let (sequence, valid_us) = (self.u32()?, valid(self.u32()?)?);
                let [supply, false] = self.bits()? else { return Err(Error::Value) };
                let channels = self.channels()?;
                let mut duty = [0; MAX_CHANNELS];
                for duty in duty.iter_mut().take(channels.into()) {
                    *duty = self.u16()?;
                }
                Frame::Duty(Duty { sequence, valid_us, supply, channels, duty })
            }
            OFF => Frame::Off,
            CLEAR => Frame::Clear { channel: self.u8()? },
            IDENTIFICATION => Frame::Identification(self.identification()?),
            CONFIGURED => Frame::Configured { session: self.u32()?, refusal: self.value()? },
            SAMPLES => Frame::Samples(self.samples()?),
            found => return Err(Error::Kind { found }),
        })
    }

    fn features(&mut self) -> Result<Features, Error> {
        let [enable, stop] = self.bits()?;
        Ok(Features { enable, stop })
    }

    fn identification(&mut self) -> Result<Identification, Error> {
        let mut who = Identification {
            nonce: self.u32()?,
            name: self.array()?,
            version: self.array()?,
            serial: self.u64()?,
            min_period_ns: self.u32()?,
            max_period_ns: self.u32()?,
            max_silence_ns: self.u32()?,
            full_code: self.u16()?,
            features: self.features()?,
            reset: self.value()?,
            user: self.u32()?,
            unused_ms: self.u32()?,
            channels: self.channels()?,
            channel: [ChannelRange::default(); MAX_CHANNELS],
        };
        for range in who.channel.iter_mut().take(who.channels.into()) {
            *range = ChannelRange {
                voltage_uv: self.u32()?,
                current_ua: self.u32()?,
                supply_uv: self.u32()?,
                limits: self.limits()?,
            };
        }
        Ok(who)
    }

    fn samples(&mut self) -> Result<Samples, Error> {
        let (sequence, state, [stop_open, reset_pressed]) = (self.u32()?, self.value()?, self.bits()?);
        let mut samples = Samples {
            sequence,
            state,
            stop_open,
            reset_pressed,
            after_us: self.u16()?,
            clock_us: self.u32()?,
            lost: self.u16()?,
            refused: self.u16()?,
            channels: self.channels()?,
            sample: [RawSample::NONE; MAX_CHANNELS],
            fault: [None; MAX_CHANNELS],
            limited: 0,
        };
        let faulty: bool = self.value()?;
        let channels = usize::from(samples.channels);
        for raw in samples.sample.iter_mut().take(channels) {
            *raw = RawSample {
                v1: self.u16()?,
                v2: self.u16()?,
                v3: self.u16()?,
                current: self.u16()?,
                supply: self.u16()?,
            };
        }
        if faulty {
            samples.limited = self.u64()?;
            for fault in samples.fault.iter_mut().take(channels) {
                *fault = self.value()?;
            }
        }
        Ok(samples)
    }
}
