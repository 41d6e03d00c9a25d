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
    /// Any number; the answer carries it.
    pub session: u32,
    /// Length of a period, ns.
    pub period_ns: u32,
    /// Periods without a good frame after which outputs go off.
    pub watchdog_periods: u16,
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

/// Why a configuration is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// More channels than there are, or none.
    Channels,
    /// A period it cannot keep.
    Period,
    /// Outputs would stay on longer without a frame than it allows.
    Silence,
}

/// Samples up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Samples {
    /// That of the duty frame whose period they are of.
    pub sequence: u32,
    /// How it is.
    pub state: State,
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
    /// Which duties were cut down to their limit: bit 0 = channel 0.
    pub limited: u64,
}

/// Codes of the converters at the end of an on-phase; [`NOT_SAMPLED`] where there was none.
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
}

/// What is wrong with a channel. Its output is off until it was asked for nothing for a while.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelFault {
    /// The current was above its limit in two periods one after the other.
    OverCurrent,
    /// I²t was used up.
    Heat,
    /// It was on and no current could be measured, in two periods one after the other.
    Converter,
    /// The power stage says so itself: over-temperature.
    StageHot,
    /// The power stage says so itself, or does not follow.
    Stage,
}

impl State {
    fn code(self) -> u8 {
        match self {
            State::Boot => 0,
            State::Ready => 1,
            State::Running => 2,
            State::Tripped => 3,
        }
    }

    fn of(code: u8) -> Result<State, Error> {
        [State::Boot, State::Ready, State::Running, State::Tripped]
            .into_iter()
            .find(|state| state.code() == code)
            .ok_or(Error::Value)
    }
}

impl ChannelFault {
    fn code(fault: Option<ChannelFault>) -> u8 {
        match fault {
            None => 0,
            Some(ChannelFault::OverCurrent) => 1,
            Some(ChannelFault::Heat) => 2,
            Some(ChannelFault::Converter) => 3,
            Some(ChannelFault::StageHot) => 4,
            Some(ChannelFault::Stage) => 5,
        }
    }

    fn of(code: u8) -> Result<Option<ChannelFault>, Error> {
        use ChannelFault::*;
        [None, Some(OverCurrent), Some(Heat), Some(Converter), Some(StageHot), Some(Stage)]
            .into_iter()
            .find(|fault| ChannelFault::code(*fault) == code)
            .ok_or(Error::Value)
    }
}

impl Refusal {
    fn code(refusal: Option<Refusal>) -> u8 {
        match refusal {
            None => 0,
            Some(Refusal::Channels) => 1,
            Some(Refusal::Period) => 2,
            Some(Refusal::Silence) => 3,
        }
    }

    fn of(code: u8) -> Result<Option<Refusal>, Error> {
        [None, Some(Refusal::Channels), Some(Refusal::Period), Some(Refusal::Silence)]
            .into_iter()
            .find(|refusal| Refusal::code(*refusal) == code)
            .ok_or(Error::Value)
    }
}

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
                self.u8(configure.channels)?;
                let limits = configure.limits.get(..usize::from(configure.channels)).ok_or(Error::Value)?;
                limits.iter().try_for_each(|limits| self.limits(limits))
            }
            Frame::Duty(duty) => {
                self.u8(DUTY)?;
                self.u32(duty.sequence)?;
                self.u8(duty.channels)?;
                let duties = duty.duty.get(..usize::from(duty.channels)).ok_or(Error::Value)?;
                duties.iter().try_for_each(|duty| self.u16(*duty))
            }
            Frame::Off => self.u8(OFF),
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
                self.u8(Refusal::code(*refusal))
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
        self.u16(samples.after_us)?;
        self.u32(samples.clock_us)?;
        self.u16(samples.lost)?;
        self.u16(samples.refused)?;
        self.u8(samples.channels)?;
        self.u8(u8::from(faulty))?;
        for raw in sample {
            for code in [raw.v1, raw.v2, raw.v3, raw.current, raw.supply] {
                self.u16(code)?;
            }
        }
        if faulty {
            self.u64(samples.limited)?;
            fault.iter().try_for_each(|fault| self.u8(ChannelFault::code(*fault)))?;
        }
        Ok(())
    }
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
                let (watchdog_periods, channels) = (self.u16()?, self.channels()?);
                let mut limits = [ChannelLimits::default(); MAX_CHANNELS];
                for limits in limits.iter_mut().take(channels.into()) {
                    *limits = self.limits()?;
                }
                Frame::Configure(Configure { session, period_ns, watchdog_periods, channels, limits })
            }
            DUTY => {
                let (sequence, channels) = (self.u32()?, self.channels()?);
                let mut duty = [0; MAX_CHANNELS];
                for duty in duty.iter_mut().take(channels.into()) {
                    *duty = self.u16()?;
                }
                Frame::Duty(Duty { sequence, channels, duty })
            }
            OFF => Frame::Off,
            IDENTIFICATION => Frame::Identification(self.identification()?),
            CONFIGURED => Frame::Configured { session: self.u32()?, refusal: Refusal::of(self.u8()?)? },
            SAMPLES => Frame::Samples(self.samples()?),
            found => return Err(Error::Kind { found }),
        })
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
        let mut samples = Samples {
            sequence: self.u32()?,
            state: State::of(self.u8()?)?,
            after_us: self.u16()?,
            clock_us: self.u32()?,
            lost: self.u16()?,
            refused: self.u16()?,
            channels: self.channels()?,
            sample: [RawSample::NONE; MAX_CHANNELS],
            fault: [None; MAX_CHANNELS],
            limited: 0,
        };
        let faulty = match self.u8()? {
            0 => false,
            1 => true,
            _ => return Err(Error::Value),
        };
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
                *fault = ChannelFault::of(self.u8()?)?;
            }
        }
        Ok(samples)
    }
}
