//! The messages beside the cycles, what happened, how the loop did and what the clocks showed, as ROS 2 would encode them: schema text
//! and CDR.

use sinew_clocks::Reading;

use super::error::Trouble;

/// The four bytes before every message: CDR, little endian.
pub(super) const CDR_LE: [u8; 4] = [0, 1, 0, 0];
/// Longest sequence or text that is read in a message.
const MAX_ITEMS: usize = 1 << 16;

/// Kinds of [`Event`].
pub const FAULT: &str = "fault";
/// Cycles were lost.
pub const GAP: &str = "gap";
/// Somebody's words.
pub const NOTE: &str = "note";

/// Something that happened while recording.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Event {
    /// The cycle it was seen in, or the first one after it.
    pub cycle: u64,
    /// When, on the clock of [`super::Head::monotonic_ns`].
    pub monotonic_ns: u64,
    /// [`FAULT`], [`GAP`], [`NOTE`] or another word.
    pub kind: String,
    /// The channel's name; empty when it is about all of them.
    pub channel: String,
    /// A fault's code from now on, 0 = cleared.
    pub code: u32,
    /// First and last cycle lost; 0 when none was.
    pub from_cycle: u64,
    /// See `from_cycle`.
    pub to_cycle: u64,
    /// For people.
    pub text: String,
}

impl Event {
    /// Somebody's words.
    pub fn note(cycle: u64, monotonic_ns: u64, text: impl Into<String>) -> Event {
        Event { cycle, monotonic_ns, kind: NOTE.into(), text: text.into(), ..Event::default() }
    }

    pub(super) const TYPE: &str = "sinew_msgs/msg/Event";
    pub(super) const SCHEMA: &str = "\
# Something that happened while recording.
uint64 cycle  # the cycle it was seen in, or the first one after it
uint64 monotonic_ns  # when, CLOCK_MONOTONIC
uint64 from_cycle  # first and last cycle lost; 0 when none was
uint64 to_cycle
uint32 code  # a fault's code from now on, 0 = cleared
string kind  # fault, gap or note
string channel  # its name; empty = about all of them
string text
";

    /// The message on [`super::EVENTS`].
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Encoder::new();
        for value in [self.cycle, self.monotonic_ns, self.from_cycle, self.to_cycle] {
            out.u64(value);
        }
        out.u32(self.code);
        for text in [&self.kind, &self.channel, &self.text] {
            out.text(text);
        }
        out.bytes
    }

    pub(super) fn decode(message: &[u8]) -> Result<Event, &'static str> {
        let mut from = Decoder::new(message)?;
        let mut numbers = [0; 4];
        for number in &mut numbers {
            *number = from.u64()?;
        }
        let [cycle, monotonic_ns, from_cycle, to_cycle] = numbers;
        let code = from.u32()?;
        let (kind, channel, text) = (from.text()?, from.text()?, from.text()?);
        Ok(Event { cycle, monotonic_ns, kind, channel, code, from_cycle, to_cycle, text })
    }
}

/// Durations counted in bins: those that are not empty.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Durations {
    /// Longest duration each bin holds, ns, rising.
    pub up_to_ns: Vec<u64>,
    /// How many it holds.
    pub count: Vec<u64>,
    /// The longest of all, ns.
    pub max_ns: u64,
}

/// How the driver's loop did so far, counted since it started.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LoopFigures {
    /// The latest cycle.
    pub cycle: u64,
    /// When it was asked, on the clock of [`super::Head::monotonic_ns`].
    pub monotonic_ns: u64,
    /// Cycles that ran.
    pub cycles: u64,
    /// Periods skipped because the loop was late.
    pub missed: u64,
    /// Cycles that took longer than a period.
    pub overruns: u64,
    /// Cycles no stream could get.
    pub ring_drops: u64,
    /// Allocations inside the loop.
    pub allocations: u64,
    /// Commands taken.
    pub commands: u64,
    /// Commands refused.
    pub refusals: u64,
    /// Means of real time that were granted: bits of the driver's `LoopStats::RT_…`.
    pub realtime: u32,
    /// Priority under SCHED_FIFO, 0 without.
    pub priority: u32,
    /// How late the loop woke up.
    pub lateness: Durations,
    /// How long a cycle took.
    pub cycle_time: Durations,
    /// Time between two cycles.
    pub period: Durations,
}

impl LoopFigures {
    pub(super) const TYPE: &str = "sinew_msgs/msg/Loop";
    pub(super) const SCHEMA: &str = "\
# How the driver's loop did so far, counted since it started. Durations are counted in bins; those that are not empty are here.
uint64 cycle  # the latest cycle
uint64 monotonic_ns  # when it was asked, CLOCK_MONOTONIC
uint64 cycles  # that ran
uint64 missed  # periods skipped because the loop was late
uint64 overruns  # cycles that took longer than a period
uint64 ring_drops  # cycles no stream could get
uint64 allocations  # inside the loop
uint64 commands  # taken
uint64 refusals  # of commands
uint32 realtime  # means of real time that were granted, a bit each
uint32 priority  # under SCHED_FIFO, 0 without
uint64 lateness_max_ns  # how late the loop woke up
uint64[] lateness_up_to_ns
uint64[] lateness_count
uint64 cycle_time_max_ns  # how long a cycle took
uint64[] cycle_time_up_to_ns
uint64[] cycle_time_count
uint64 period_max_ns  # time between two cycles
uint64[] period_up_to_ns
uint64[] period_count
";

    /// The message on [`super::LOOP`].
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Encoder::new();
        for value in [
            self.cycle,
            self.monotonic_ns,
            self.cycles,
            self.missed,
            self.overruns,
            self.ring_drops,
            self.allocations,
            self.commands,
            self.refusals,
        ] {
            out.u64(value);
        }
        out.u32(self.realtime);
        out.u32(self.priority);
        for durations in [&self.lateness, &self.cycle_time, &self.period] {
            out.u64(durations.max_ns);
            out.u64s(&durations.up_to_ns);
            out.u64s(&durations.count);
        }
        out.bytes
    }

    pub(super) fn decode(message: &[u8]) -> Result<LoopFigures, &'static str> {
        let mut from = Decoder::new(message)?;
        let mut numbers = [0; 9];
        for number in &mut numbers {
            *number = from.u64()?;
        }
        let [cycle, monotonic_ns, cycles, missed, overruns, ring_drops, allocations, commands, refusals] = numbers;
        let (realtime, priority) = (from.u32()?, from.u32()?);
        let mut durations = || {
            let max_ns = from.u64()?;
            Ok::<_, &'static str>(Durations { max_ns, up_to_ns: from.u64s()?, count: from.u64s()? })
        };
        let (lateness, cycle_time, period) = (durations()?, durations()?, durations()?);
        Ok(LoopFigures {
            cycle,
            monotonic_ns,
            cycles,
            missed,
            overruns,
            ring_drops,
            allocations,
            commands,
            refusals,
            realtime,
            priority,
            lateness,
            cycle_time,
            period,
        })
    }
}

/// Type and schema of the messages on [`super::CLOCKS`].
pub(super) const CLOCKS_TYPE: &str = "sinew_msgs/msg/Clocks";
pub(super) const CLOCKS_SCHEMA: &str = "\
# What the clocks of the recording machine showed beside each other. An error is what a time is off by at the most.
uint64 monotonic_ns  # the instant, CLOCK_MONOTONIC
int64 system_ns  # CLOCK_REALTIME, since 1970 (UTC)
uint64 system_error_ns
uint64 boottime_ns  # CLOCK_BOOTTIME
uint64 boottime_error_ns
uint64 raw_ns  # CLOCK_MONOTONIC_RAW, which nobody corrects
uint64 raw_error_ns
uint64 utc_error_ns  # what system time is off from UTC by, as its synchronisation says; 2^64-1 = it is not synchronised
int64 tai_offset_s  # what TAI is ahead of UTC by; 0 = not known
";

/// The message on [`super::CLOCKS`].
pub(super) fn encode_clocks(reading: &Reading) -> Vec<u8> {
    let mut out = Encoder::new();
    for value in [
        reading.monotonic_ns,
        reading.system_ns as u64,
        reading.system_error_ns,
        reading.boottime_ns,
        reading.boottime_error_ns,
        reading.raw_ns,
        reading.raw_error_ns,
        reading.utc_error_ns.unwrap_or(u64::MAX),
        i64::from(reading.tai_offset_s.unwrap_or(0)) as u64,
    ] {
        out.u64(value);
    }
    out.bytes
}

pub(super) fn decode_clocks(message: &[u8]) -> Result<Reading, &'static str> {
    let mut from = Decoder::new(message)?;
    Ok(Reading {
        monotonic_ns: from.u64()?,
        system_ns: from.u64()? as i64,
        system_error_ns: from.u64()?,
        boottime_ns: from.u64()?,
        boottime_error_ns: from.u64()?,
        raw_ns: from.u64()?,
        raw_error_ns: from.u64()?,
        utc_error_ns: Some(from.u64()?).filter(|&ns| ns != u64::MAX),
        tai_offset_s: i32::try_from(from.u64()? as i64).ok().filter(|&seconds| seconds != 0),
    })
}

/// The body of a message, which must be CDR, little endian.
pub(super) fn body(message: &[u8]) -> Result<&[u8], &'static str> {
    match message.split_first_chunk::<4>() {
        Some((&[0, 1, _, _], body)) => Ok(body),
        Some(_) => Err("a message is not CDR, little endian"),
        None => Err("a message is too short"),
    }
}

pub(super) fn damaged(offset: u64, reason: &str) -> Trouble {
    Trouble::Damaged { offset, reason: reason.into() }
}

struct Encoder {
    bytes: Vec<u8>,
}

impl Encoder {
    fn new() -> Encoder {
        Encoder { bytes: CDR_LE.to_vec() }
    }

    fn align(&mut self, to: usize) {
        let end = (self.bytes.len() - CDR_LE.len()).next_multiple_of(to) + CDR_LE.len();
        self.bytes.resize(end, 0);
    }

    fn u32(&mut self, value: u32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
    }

    fn u64s(&mut self, values: &[u64]) {
        self.u32(values.len() as u32);
        for &value in values {
            self.u64(value);
        }
    }

    fn text(&mut self, text: &str) {
        // longer ones would not be read again
        let end = (0..text.len().min(MAX_ITEMS - 1) + 1).rev().find(|&end| text.is_char_boundary(end)).unwrap_or(0);
        self.u32(end as u32 + 1);
        self.bytes.extend(&text.as_bytes()[..end]);
        self.bytes.push(0);
    }
}

struct Decoder<'a> {
    body: &'a [u8],
    at: usize,
}

impl<'a> Decoder<'a> {
    fn new(message: &'a [u8]) -> Result<Decoder<'a>, &'static str> {
        Ok(Decoder { body: body(message)?, at: 0 })
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], &'static str> {
        let from = self.at.next_multiple_of(N);
        let bytes = self.body.get(from..from + N).ok_or("a message is too short")?;
        self.at = from + N;
        bytes.try_into().map_err(|_| "a message is too short")
    }

    fn u32(&mut self) -> Result<u32, &'static str> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, &'static str> {
        self.take().map(u64::from_le_bytes)
    }

    fn items(&mut self) -> Result<usize, &'static str> {
        let items = self.u32()? as usize;
        if items > MAX_ITEMS { Err("a message has too many items") } else { Ok(items) }
    }

    fn u64s(&mut self) -> Result<Vec<u64>, &'static str> {
        (0..self.items()?).map(|_| self.u64()).collect()
    }

    fn text(&mut self) -> Result<String, &'static str> {
        let items = self.items()?;
        let bytes = self.body.get(self.at..self.at + items).ok_or("a message is too short")?;
        self.at += items;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn messages_read_back_as_they_were_written(
            numbers in prop::collection::vec(any::<u64>(), 9),
            code in any::<u32>(),
            texts in prop::collection::vec("\\PC{0,20}", 3),
            bins in prop::collection::vec(any::<u64>(), 0..40),
        ) {
            let event = Event {
                cycle: numbers[0], monotonic_ns: numbers[1], from_cycle: numbers[2], to_cycle: numbers[3], code,
                kind: texts[0].clone(), channel: texts[1].clone(), text: texts[2].clone(),
            };
            prop_assert_eq!(Event::decode(&event.encode()).unwrap(), event);
            let durations = Durations { up_to_ns: bins.clone(), count: bins, max_ns: numbers[4] };
            let figures = LoopFigures {
                cycle: numbers[0], cycles: numbers[5], refusals: numbers[8], priority: code,
                lateness: durations.clone(), period: durations, ..LoopFigures::default()
            };
            prop_assert_eq!(LoopFigures::decode(&figures.encode()).unwrap(), figures);
            let reading = Reading {
                monotonic_ns: numbers[0], system_ns: numbers[1] as i64, system_error_ns: numbers[2], boottime_ns: numbers[3],
                boottime_error_ns: numbers[4], raw_ns: numbers[5], raw_error_ns: numbers[6],
                utc_error_ns: Some(numbers[7]).filter(|&ns| ns != u64::MAX), tai_offset_s: Some(code as i32).filter(|&s| s != 0),
            };
            prop_assert_eq!(decode_clocks(&encode_clocks(&reading)).unwrap(), reading);
        }

        #[test]
        fn no_bytes_make_the_decoder_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let message = [&CDR_LE[..], &bytes].concat();
            let _ = (Event::decode(&message), Event::decode(&bytes), LoopFigures::decode(&message), decode_clocks(&message));
        }
    }

    #[test]
    fn a_text_too_long_is_cut() {
        let event = Event { text: "ä".repeat(MAX_ITEMS), ..Event::default() };
        let back = Event::decode(&event.encode()).unwrap();
        assert!(back.text.len() >= MAX_ITEMS - 2 && event.text.starts_with(&back.text));
    }
}
