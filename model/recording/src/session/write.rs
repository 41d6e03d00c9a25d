//! Writing a recording, cycle by cycle.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::records::{MessageHeader, Metadata, op};
use sinew_clocks::Reading;

use super::about::{ABOUT, About, ENDING, Ended, Ending, Gap, MAX_GAPS, RIG_FILE};
use super::error::Trouble;
use super::layout::{HEAD_BYTES, Layout};
use super::message::{CDR_LE, Event, GAP, LoopFigures, encode_clocks};
use super::{Compression, Head, MESSAGE_ENCODING, SCHEMA_ENCODING, Topic, clocks_topic, topics};
use crate::error::{Error, What};

/// Bytes of a chunk before compression, from which on it is closed.
const CHUNK_BYTES: u64 = 4 << 20;
/// A chunk holds at most so much time, ns: what a killed recorder loses.
const CHUNK_NS: u64 = 1_000_000_000;

/// How to write a recording.
#[derive(Debug, Clone)]
pub struct WriteOptions {
    /// What messages call the file.
    pub name: String,
    /// How chunks are compressed.
    pub compression: Compression,
    /// The last cycle before this file where it continues another one, so that a gap between the two is counted.
    pub after_cycle: Option<u64>,
    /// Bytes of a chunk before compression, from which on it is closed.
    pub chunk_bytes: u64,
}

impl WriteOptions {
    /// Compressed by lz4, on its own, chunks of 4 MiB; `name` is what messages call the file.
    pub fn new(name: impl Into<String>) -> WriteOptions {
        WriteOptions { name: name.into(), compression: Compression::Lz4, after_cycle: None, chunk_bytes: CHUNK_BYTES }
    }
}

/// Writes a recording. What was written up to the last complete chunk can be read whatever happens; a chunk is complete
/// after 4 MiB or a second. Unless [`SessionWriter::finish`] is called the file has no end: it is read all the same, more slowly.
pub struct SessionWriter<W: Write + Seek> {
    name: String,
    mcap: mcap::Writer<Counted<W>>,
    layout_bytes: usize,
    about: About,
    topics: Topics,
    /// The message being put together.
    message: Vec<u8>,
    /// Bytes in the present chunk, before compression, and the time of its first cycle.
    pending: u64,
    pending_from: Option<u64>,
    position: Arc<AtomicU64>,
    /// The position behind the last complete chunk.
    good: u64,
    payload: u64,
    previous: Option<u64>,
    missed: Option<(u64, u64)>,
    ending: Ending,
    /// The ending as of the last complete chunk.
    safe: Ending,
    chunk_bytes: u64,
}

/// What is left of a recording that could not be written to its end.
#[derive(Debug)]
pub struct Abandoned<W> {
    /// What it was written to.
    pub sink: W,
    /// Bytes of it that are complete chunks.
    pub length: u64,
    /// What is in those.
    pub ending: Ending,
}

/// Channel ids of the topics.
#[derive(Debug, Clone, Copy)]
struct Topics {
    cycles: u16,
    events: u16,
    figures: u16,
    clocks: u16,
}

impl<W: Write + Seek> SessionWriter<W> {
    /// Begins a recording.
    ///
    /// # Errors
    /// [`What::Unwritable`] with the system's reason.
    pub fn create(sink: W, about: &About, layout: &Layout, options: WriteOptions) -> Result<SessionWriter<W>, Error> {
        let name = options.name.clone();
        SessionWriter::begin(sink, about, layout, options).map_err(|error| unwritable(&name, &error))
    }

    fn begin(
        sink: W,
        about: &About,
        layout: &Layout,
        options: WriteOptions,
    ) -> Result<SessionWriter<W>, mcap::McapError> {
        let settings = mcap::WriteOptions::new()
            .library(about.software.clone())
            // chunks are closed here, by size and by time
            .chunk_size(None)
            // a chunk is put together in memory and written at once: what is in the file is complete
            .disable_seeking(true)
            .compression_threads(0)
            .compression_level(options.compression.level())
            .compression(options.compression.of_mcap());
        let position = Arc::new(AtomicU64::new(0));
        let mut mcap = settings.create(Counted { sink, position: position.clone() })?;
        // Before any chunk, so that it is found however early the file ends.
        mcap.write_metadata(&Metadata { name: ABOUT.into(), metadata: about.metadata(layout) })?;
        if let Some(text) = &about.rig_toml {
            mcap.attach(&mcap::Attachment {
                log_time: about.started_unix_ns,
                create_time: about.started_unix_ns,
                name: RIG_FILE.into(),
                media_type: "application/toml".into(),
                data: Cow::Borrowed(text.as_bytes()),
            })?;
        }
        mcap.flush()?;
        let good = position.load(Ordering::Relaxed);
        let [cycles, events, figures] = topics(layout).map(|topic| add(&mut mcap, &topic));
        let clocks = add(&mut mcap, &clocks_topic())?;
        let topics = Topics { cycles: cycles?, events: events?, figures: figures?, clocks };
        // What was added is in the first chunk now, which is open.
        Ok(SessionWriter {
            name: options.name,
            mcap,
            layout_bytes: layout.bytes(),
            about: About { rig_toml: None, ..about.clone() },
            topics,
            message: Vec::with_capacity(CDR_LE.len() + HEAD_BYTES + layout.bytes()),
            pending: 0,
            pending_from: None,
            position,
            good,
            payload: 0,
            previous: options.after_cycle,
            missed: None,
            chunk_bytes: options.chunk_bytes,
            ending: Ending::default(),
            safe: Ending::default(),
        })
    }

    /// Adds a cycle: `bytes` are the channels one after the other, each as the layout's fields say, little endian.
    ///
    /// A number that leaves some out is a gap: counted, and written to [`EVENTS`](super::EVENTS).
    ///
    /// # Errors
    /// [`What::Unwritable`]: nothing more can be written then, see [`SessionWriter::abandon`]. [`Trouble::CycleBytes`],
    /// [`Trouble::NotAfter`]: that cycle is not written.
    pub fn cycle(&mut self, head: &Head, bytes: &[u8]) -> Result<(), Error> {
        if bytes.len() != self.layout_bytes {
            return Err(self.trouble(Trouble::CycleBytes { expected: self.layout_bytes, found: bytes.len() }));
        }
        if let Some(previous) = self.previous {
            if head.cycle <= previous {
                return Err(self.trouble(Trouble::NotAfter { previous, found: head.cycle }));
            }
            if head.cycle > previous + 1 {
                self.gap(Gap { from: previous + 1, to: head.cycle - 1 }, head)?;
            }
        }
        self.message.clear();
        head.encode(bytes, &mut self.message);
        let message = std::mem::take(&mut self.message);
        let written = self.message(self.topics.cycles, head.cycle, head.monotonic_ns, &message);
        self.message = message;
        written?;
        self.previous = Some(head.cycle);
        self.ending.cycles += 1;
        let (first, _) = *self.missed.get_or_insert((head.missed, head.missed));
        self.missed = Some((first, head.missed));
        let from_ns = *self.pending_from.get_or_insert(head.monotonic_ns);
        if self.pending >= self.chunk_bytes || head.monotonic_ns.saturating_sub(from_ns) >= CHUNK_NS {
            self.cut()?;
        }
        Ok(())
    }

    fn gap(&mut self, gap: Gap, head: &Head) -> Result<(), Error> {
        self.ending.lost += gap.cycles();
        if self.ending.gaps.len() < MAX_GAPS {
            self.ending.gaps.push(gap);
        } else {
            self.ending.gaps_not_listed += 1;
        }
        self.event(&Event {
            cycle: head.cycle,
            monotonic_ns: head.monotonic_ns,
            kind: GAP.into(),
            from_cycle: gap.from,
            to_cycle: gap.to,
            text: format!("{} cycles lost", gap.cycles()),
            ..Event::default()
        })
    }

    /// Counts what was lost behind the last cycle, up to this number; nothing where there is none missing.
    ///
    /// # Errors
    /// [`What::Unwritable`].
    pub fn lost_to(&mut self, head: &Head) -> Result<(), Error> {
        match self.previous {
            Some(previous) if head.cycle > previous => {
                self.previous = Some(head.cycle);
                self.gap(Gap { from: previous + 1, to: head.cycle }, head)
            }
            _ => Ok(()),
        }
    }

    /// Adds something that happened.
    ///
    /// # Errors
    /// [`What::Unwritable`].
    pub fn event(&mut self, event: &Event) -> Result<(), Error> {
        self.message(self.topics.events, event.cycle, event.monotonic_ns, &event.encode())
    }

    /// Adds the loop's figures.
    ///
    /// # Errors
    /// [`What::Unwritable`].
    pub fn loop_stats(&mut self, figures: &LoopFigures) -> Result<(), Error> {
        self.message(self.topics.figures, figures.cycle, figures.monotonic_ns, &figures.encode())
    }

    /// Adds what the clocks of this machine show beside each other.
    ///
    /// # Errors
    /// [`What::Unwritable`].
    pub fn clocks(&mut self, reading: &Reading) -> Result<(), Error> {
        self.message(self.topics.clocks, 0, reading.monotonic_ns, &encode_clocks(reading))?;
        self.ending.compared(reading);
        Ok(())
    }

    fn message(&mut self, topic: u16, cycle: u64, monotonic_ns: u64, data: &[u8]) -> Result<(), Error> {
        let time = self.about.unix_ns(monotonic_ns);
        // a sequence is only 32 bits wide; the message has the whole number
        let header = MessageHeader { channel_id: topic, sequence: cycle as u32, log_time: time, publish_time: time };
        self.pending += data.len() as u64;
        self.payload += data.len() as u64;
        self.mcap.write_to_known_channel(&header, data).map_err(|error| unwritable(&self.name, &error))
    }

    /// Completes the present chunk and hands it to the system: what was added so far can be read from now on.
    ///
    /// # Errors
    /// [`What::Unwritable`].
    pub fn cut(&mut self) -> Result<(), Error> {
        if self.pending > 0 {
            self.mcap.flush().map_err(|error| unwritable(&self.name, &error))?;
            (self.pending, self.pending_from) = (0, None);
            self.good = self.position.load(Ordering::Relaxed);
            self.safe = self.ending();
        }
        Ok(())
    }

    /// Completes the file and gives back what it was written to; bringing that safely to the disk is the caller's.
    ///
    /// # Errors
    /// [`What::Unwritable`].
    pub fn finish(mut self, ended: Ended) -> Result<W, Error> {
        let name = std::mem::take(&mut self.name);
        self.complete(ended).map_err(|error| unwritable(&name, &error))?;
        Ok(self.mcap.into_inner().sink)
    }

    fn complete(&mut self, ended: Ended) -> Result<(), mcap::McapError> {
        let ending = Ending { ended: Some(ended), ..self.ending() };
        self.mcap.write_metadata(&Metadata { name: ENDING.into(), metadata: ending.metadata() })?;
        self.mcap.finish()?;
        Ok(())
    }

    /// Gives up after a failure: what of it is in complete chunks. Cut off behind them, and [`close_off`] makes it a whole file.
    pub fn abandon(self) -> Abandoned<W> {
        Abandoned { sink: self.mcap.into_inner().sink, length: self.good, ending: self.safe }
    }

    /// What the recording would say of its end now.
    pub fn ending(&self) -> Ending {
        let missed = self.missed.map_or(0, |(first, last)| last.saturating_sub(first));
        Ending { missed, ..self.ending.clone() }
    }

    /// Cycles so far.
    pub fn cycles(&self) -> u64 {
        self.ending.cycles
    }

    /// Bytes in complete chunks: the length of the file so far.
    pub fn bytes(&self) -> u64 {
        self.good
    }

    /// Bytes of all messages so far, before compression.
    pub fn payload(&self) -> u64 {
        self.payload
    }

    fn trouble(&self, trouble: Trouble) -> Error {
        Error::new(&self.name, What::Session(trouble))
    }
}

/// Gives a file that was cut off behind its last complete chunk an end, so that it is whole: without a summary, which there may be
/// no room for, it opens more slowly. Needs 200 bytes or so.
///
/// # Errors
/// Those of `sink`.
pub fn close_off(sink: &mut (impl Write + Seek), length: u64, ending: &Ending) -> io::Result<()> {
    let text = |out: &mut Vec<u8>, text: &str| {
        out.extend((text.len() as u32).to_le_bytes());
        out.extend(text.as_bytes());
    };
    let mut map = Vec::new();
    for (key, value) in ending.metadata() {
        text(&mut map, &key);
        text(&mut map, &value);
    }
    let mut metadata = Vec::new();
    text(&mut metadata, ENDING);
    metadata.extend((map.len() as u32).to_le_bytes());
    metadata.extend(map);
    let mut end = Vec::new();
    // no checksum of the data, no summary: zeros say so
    for (op, body) in [(op::METADATA, &metadata[..]), (op::DATA_END, &[0; 4]), (op::FOOTER, &[0; 20])] {
        end.push(op);
        end.extend((body.len() as u64).to_le_bytes());
        end.extend(body);
    }
    end.extend(mcap::MAGIC);
    sink.seek(SeekFrom::Start(length))?;
    sink.write_all(&end)?;
    sink.flush()
}

/// Adds a topic with its schema.
fn add<W: Write + Seek>(mcap: &mut mcap::Writer<W>, topic: &Topic) -> Result<u16, mcap::McapError> {
    let schema = mcap.add_schema(topic.kind, SCHEMA_ENCODING, topic.schema.as_bytes())?;
    mcap.add_channel(schema, topic.name, MESSAGE_ENCODING, &BTreeMap::new())
}

fn unwritable(name: &str, error: &mcap::McapError) -> Error {
    let reason = match error {
        mcap::McapError::Io(error) => error.to_string(),
        error => error.to_string(),
    };
    Error::new(name, What::Unwritable { reason })
}

/// What is written to, with its position where others can see it.
struct Counted<W> {
    sink: W,
    position: Arc<AtomicU64>,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.sink.write(bytes)?;
        self.position.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

impl<W: Seek> Seek for Counted<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = self.sink.seek(to)?;
        self.position.store(position, Ordering::Relaxed);
        Ok(position)
    }

    fn stream_position(&mut self) -> io::Result<u64> {
        Ok(self.position.load(Ordering::Relaxed))
    }
}
