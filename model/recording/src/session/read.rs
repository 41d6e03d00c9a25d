//! Reading a recording: what it is of, and its cycles one after the other, never more than a chunk of them in memory.

use std::path::Path;

use super::about::{ABOUT, About, ENDING, Ending, RIG_FILE};
use super::chunk::{Buffers, MessageAt, inner, message};
use super::contents::{ChunkAt, Contents};
use super::error::Trouble;
use super::file::Source;
use super::layout::{HEAD_BYTES, Kind, Layout, offsets};
use super::message::{Event, LoopFigures, body, damaged, decode_clocks};
use super::{CLOCKS, CYCLES, Compression, EVENTS, Head, LOOP};
use crate::error::Error;
use mcap::records::op;
use sinew_clocks::{History, Reading};

/// An open recording. Any number of readers may go through it at the same time.
#[derive(Debug)]
pub struct Session {
    pub(super) source: Source,
    pub(super) contents: Contents,
    layout: Layout,
    about: About,
    ending: Option<Ending>,
    pub(super) topics: Topics,
    /// Kind and offset of each field in a channel.
    places: Vec<(Kind, usize)>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Topics {
    pub(super) cycles: u16,
    pub(super) events: Option<u16>,
    pub(super) figures: Option<u16>,
    pub(super) clocks: Option<u16>,
}

/// What a recording takes up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// The file, bytes.
    pub file: u64,
    /// Its chunks, bytes.
    pub packed: u64,
    /// What they hold, bytes.
    pub unpacked: u64,
    /// How many there are.
    pub chunks: usize,
    /// How they are compressed; `None` without a chunk.
    pub compression: Option<Compression>,
}

impl Session {
    /// Opens a recording: reads its summary, or looks through all of it where it has none because its recorder was killed.
    ///
    /// # Errors
    /// [`crate::What::Unreadable`], [`crate::What::Empty`], [`crate::What::Session`].
    pub fn open(path: impl AsRef<Path>) -> Result<Session, Error> {
        let source = Source::open(path.as_ref())?;
        let contents = Contents::of(&source)?;
        Session::with(source, contents)
    }

    pub(super) fn with(source: Source, contents: Contents) -> Result<Session, Error> {
        let Some(cycles) = contents.topic(CYCLES) else {
            if contents.topics.is_empty() && contents.broken_at.is_some() {
                let reason = "the file ends before its first complete chunk";
                return Err(source.trouble(damaged(contents.data_end, reason)));
            }
            let topics = contents.topics.values().map(|topic| topic.name.escape_debug().to_string()).take(12);
            return Err(source.trouble(Trouble::Foreign { topics: topics.collect() }));
        };
        let topic = &contents.topics[&cycles];
        let wrong = |reason: String| source.trouble(Trouble::Schema { reason });
        let schema = contents.schemas.get(&topic.schema).ok_or_else(|| wrong("it has no schema".into()))?;
        if topic.encoding != "cdr" || schema.encoding != "ros2msg" {
            let found = format!("{:?} by {:?}", topic.encoding, schema.encoding);
            return Err(wrong(format!("messages are {found}, expected \"cdr\" by \"ros2msg\"")));
        }
        let mut layout = Layout::parse(&schema.text).map_err(|trouble| source.trouble(trouble))?;
        let rig_toml = contents.attachment(&source, RIG_FILE);
        let about = About::parse(contents.metadata(&source, ABOUT).unwrap_or_default(), rig_toml, &mut layout);
        let ending = contents.metadata(&source, ENDING).map(|map| Ending::parse(&map));
        let (events, figures) = (contents.topic(EVENTS), contents.topic(LOOP));
        let topics = Topics { cycles, events, figures, clocks: contents.topic(CLOCKS) };
        let places = offsets(&layout.fields);
        Ok(Session { source, contents, layout, about, ending, topics, places })
    }

    /// Where it comes from.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// Its channels and their fields.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// What it says of its end; `None` where it broke off.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    /// What messages call it.
    pub fn name(&self) -> &str {
        &self.source.name
    }

    /// Seconds from the start of the recording to this cycle.
    pub fn time_s(&self, head: &Head) -> f64 {
        self.about.time_s(head.monotonic_ns)
    }

    /// How many cycles it holds, by its own indexes.
    pub fn cycle_count(&self) -> u64 {
        self.contents.messages.get(&self.topics.cycles).copied().unwrap_or(0)
    }

    /// What it takes up.
    pub fn size(&self) -> Size {
        let chunks = &self.contents.chunks;
        Size {
            file: self.source.size,
            packed: chunks.iter().map(|chunk| chunk.packed).sum(),
            unpacked: chunks.iter().map(|chunk| chunk.unpacked).sum(),
            chunks: chunks.len(),
            compression: chunks.first().map(|chunk| chunk.compression),
        }
    }

    /// Whether it has a summary at its end, from which it opens quickly. A file without one broke off.
    pub fn has_summary(&self) -> bool {
        self.contents.summary
    }

    /// All cycles, in order.
    pub fn cycles(&self) -> Cycles<'_> {
        Cycles::new(self, 0, self.contents.chunks.len(), f64::NEG_INFINITY, f64::INFINITY)
    }

    /// The cycles from one time to another, s since the start of the recording ([`Session::time_s`]); that at `to_s` is not among them.
    pub fn cycles_between(&self, from_s: f64, to_s: f64) -> Cycles<'_> {
        let start = |ns: u64| self.about.started_unix_ns.abs_diff(ns) as f64 * 1e-9;
        let signed = |ns: u64| if ns < self.about.started_unix_ns { -start(ns) } else { start(ns) };
        // a microsecond of leeway: the time of day is a sum of two clocks, and a float of its difference is coarse
        let touches = |chunk: &&ChunkAt| signed(chunk.end_ns) >= from_s - 1e-6 && signed(chunk.start_ns) <= to_s + 1e-6;
        let chunks = &self.contents.chunks;
        let first = chunks.iter().position(|chunk| touches(&chunk)).unwrap_or(chunks.len());
        let last = chunks.iter().rposition(|chunk| touches(&chunk)).map_or(first, |last| last + 1);
        Cycles::new(self, first, last, from_s, to_s)
    }

    /// The first and the last cycle; `None` without any.
    ///
    /// # Errors
    /// As [`Cycles::next`].
    pub fn span(&self) -> Result<Option<(Head, Head)>, Error> {
        let chunks = self.contents.chunks.len();
        let mut first = self.cycles();
        let Some(first) = first.next()?.map(|cycle| cycle.head) else { return Ok(None) };
        for chunk in (0..chunks).rev() {
            let mut cycles = Cycles::new(self, chunk, chunk + 1, f64::NEG_INFINITY, f64::INFINITY);
            let mut last = None;
            while let Some(cycle) = cycles.next()? {
                last = Some(cycle.head);
            }
            if let Some(last) = last {
                return Ok(Some((first, last)));
            }
        }
        Ok(None)
    }

    /// What happened while recording, in order.
    ///
    /// # Errors
    /// As [`Cycles::next`].
    pub fn events(&self) -> Result<Vec<Event>, Error> {
        self.messages(self.topics.events, Event::decode)
    }

    /// How the driver's loop did, about once a second.
    ///
    /// # Errors
    /// As [`Cycles::next`].
    pub fn loop_figures(&self) -> Result<Vec<LoopFigures>, Error> {
        self.messages(self.topics.figures, LoopFigures::decode)
    }

    /// What the clocks of the recording machine showed beside each other: at the start, now and then, and at the end. None in
    /// recordings that are older than this.
    ///
    /// # Errors
    /// As [`Cycles::next`].
    pub fn clocks(&self) -> Result<Vec<Reading>, Error> {
        self.messages(self.topics.clocks, decode_clocks)
    }

    /// What became of the clocks of the recording machine meanwhile, and system time of any stamp: by what the end has of them, or, where it
    /// broke off, by [`Session::clocks`]; `None` in recordings that are older than this.
    ///
    /// # Errors
    /// As [`Cycles::next`].
    pub fn clock_history(&self) -> Result<Option<History>, Error> {
        let summed_up = self.ending.as_ref().map(|ending| ending.clocks.clone()).filter(|clocks| !clocks.is_empty());
        Ok(History::of(summed_up.map_or_else(|| self.clocks(), Ok)?))
    }

    /// All messages of one of the smaller topics, out of the chunks that have any.
    fn messages<T>(
        &self,
        topic: Option<u16>,
        decode: impl Fn(&[u8]) -> Result<T, &'static str>,
    ) -> Result<Vec<T>, Error> {
        let Some(topic) = topic else { return Ok(Vec::new()) };
        let mut found = Vec::new();
        let mut buffers = Buffers::default();
        for chunk in &self.contents.chunks {
            // behind a chunk that broke off there may be no index, though it has messages
            if !chunk.indexes.is_empty() && chunk.indexes.iter().all(|(id, ..)| *id != topic) {
                continue;
            }
            self.source.chunk(chunk.offset, &mut buffers)?;
            let failed = |reason: &str| self.source.trouble(damaged(chunk.offset, reason));
            let mut at = 0;
            while let Some(record) = inner(&buffers.records, at) {
                let (op, range) = record.map_err(failed)?;
                at = range.end;
                if op != op::MESSAGE {
                    continue;
                }
                let message = message(&buffers.records, range).map_err(failed)?;
                if message.topic == topic {
                    found.push(decode(&buffers.records[message.from..message.to]).map_err(failed)?);
                }
                if found.len() > MAX_MESSAGES {
                    return Err(failed("there are more messages beside the cycles than can be true"));
                }
            }
        }
        Ok(found)
    }
}

/// Most messages of one of the smaller topics that are kept in memory.
const MAX_MESSAGES: usize = 1 << 20;

/// Cycles one after the other. Made by [`Session::cycles`].
#[derive(Debug)]
pub struct Cycles<'a> {
    session: &'a Session,
    /// The next chunk, and the one behind the last.
    chunk: usize,
    end: usize,
    from_s: f64,
    to_s: f64,
    buffers: Buffers,
    /// The next record in the chunk that is unpacked.
    at: usize,
    /// Where that chunk stands, for messages.
    offset: u64,
}

impl<'a> Cycles<'a> {
    fn new(session: &'a Session, chunk: usize, end: usize, from_s: f64, to_s: f64) -> Cycles<'a> {
        Cycles { session, chunk, end, from_s, to_s, buffers: Buffers::default(), at: 0, offset: 0 }
    }

    /// The next cycle; `None` after the last. After an error the next call goes on with the next chunk.
    ///
    /// # Errors
    /// [`crate::What::Unreadable`], and [`crate::What::Session`] for a damaged chunk.
    // Not an iterator: a cycle lies in the reader's own memory and must be let go before the next.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Result<Option<CycleView<'_>>, Error> {
        let found = loop {
            match self.advance() {
                Ok(Some((head, message))) => {
                    let time_s = self.session.time_s(&head);
                    if time_s >= self.to_s {
                        return Ok(None);
                    }
                    if time_s >= self.from_s {
                        break (head, message);
                    }
                }
                Ok(None) => return Ok(None),
                Err(error) => {
                    self.buffers.records.clear();
                    self.at = 0;
                    return Err(error);
                }
            }
        };
        let (head, message) = found;
        let bytes = &self.buffers.records[message.to - self.session.layout.bytes()..message.to];
        let layout = &self.session.layout;
        Ok(Some(CycleView { head, bytes, places: &self.session.places, stride: layout.stride() }))
    }

    /// The next message of the cycles' topic.
    fn advance(&mut self) -> Result<Option<(Head, MessageAt)>, Error> {
        loop {
            let Some(record) = inner(&self.buffers.records, self.at) else {
                if self.chunk >= self.end {
                    return Ok(None);
                }
                self.offset = self.session.contents.chunks[self.chunk].offset;
                self.chunk += 1;
                self.at = 0;
                self.session.source.chunk(self.offset, &mut self.buffers)?;
                continue;
            };
            let failed = |reason: &str| self.session.source.trouble(damaged(self.offset, reason));
            let (op, range) = record.map_err(failed)?;
            self.at = range.end;
            if op != op::MESSAGE {
                continue;
            }
            let message = message(&self.buffers.records, range).map_err(failed)?;
            if message.topic != self.session.topics.cycles {
                continue;
            }
            let data = body(&self.buffers.records[message.from..message.to]).map_err(failed)?;
            let Some((head, channels)) = data.split_first_chunk::<HEAD_BYTES>() else {
                return Err(failed("a cycle is too short"));
            };
            if channels.len() != self.session.layout.bytes() {
                return Err(failed("a cycle is not as long as its schema says"));
            }
            return Ok(Some((Head::of_bytes(head), message)));
        }
    }
}

/// One cycle, in the reader's memory: copy what is to be kept.
#[derive(Debug, Clone, Copy)]
pub struct CycleView<'a> {
    /// Number and time of the cycle.
    pub head: Head,
    bytes: &'a [u8],
    places: &'a [(Kind, usize)],
    stride: usize,
}

impl<'a> CycleView<'a> {
    /// The value of a channel's field, both by number; NaN where there is no such channel or field.
    #[inline]
    pub fn get(&self, channel: usize, field: usize) -> f64 {
        let Some(&(kind, offset)) = self.places.get(field) else { return f64::NAN };
        let at = channel.saturating_mul(self.stride).saturating_add(offset);
        let rest = self.bytes.get(at..).unwrap_or_default();
        match kind {
            Kind::F64 => rest.first_chunk().map_or(f64::NAN, |bytes| f64::from_le_bytes(*bytes)),
            Kind::U32 => rest.first_chunk().map_or(f64::NAN, |bytes| u32::from_le_bytes(*bytes).into()),
        }
    }

    /// All channels, one after the other, each as the layout's fields say, little endian.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }
}
