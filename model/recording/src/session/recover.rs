//! Making a whole recording of what is left of one that broke off or was damaged.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use mcap::records::op;

use super::about::{Ended, Ending, Gap};
use super::check::with_topics;
use super::chunk::{Buffers, ChunkHead, decompress, inner, message};
use super::contents::Contents;
use super::error::Trouble;
use super::file::{RECORD_HEAD, Source};
use super::layout::HEAD_BYTES;
use super::message::{Event, GAP, LoopFigures, body, decode_clocks};
use super::read::Session;
use super::write::{SessionWriter, WriteOptions};
use super::{Compression, Head};
use crate::error::{Error, What};
use crate::write::part_path;

/// How many places that only look like a chunk are tried before the search for more of them is given up.
const MOST_TRIES: usize = 1000;
/// How much is searched at once, bytes.
const WINDOW: usize = 1 << 20;

/// What was kept and what is missing.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Recovered {
    /// Cycles in the new file.
    pub cycles: u64,
    /// Of these, cycles out of a chunk that broke off. Nothing says whether their numbers are right: a chunk's checksum is for the
    /// whole of it.
    pub unchecked: u64,
    /// Cycles missing between the first and the last one.
    pub lost: u64,
    /// Which ones.
    pub gaps: Vec<Gap>,
    /// Chunks that could not be read, by where they begin, each with the reason.
    pub damaged: Vec<(u64, String)>,
    /// Bytes of the old file that belong to nothing complete.
    pub left_over: u64,
    /// Messages that were passed over because they are not as they should be.
    pub passed_over: u64,
}

/// Writes all that can be read of a recording into a new one. The old one stays as it is; the new one appears when it is complete.
/// `progress` is given how much of the file is done, bytes, and how much there is.
///
/// # Errors
/// Where the old one cannot be read at all or has no complete chunk, and [`What::Unwritable`] for the new one.
pub fn recover(
    path: impl AsRef<Path>,
    output: impl AsRef<Path>,
    mut progress: impl FnMut(u64, u64),
) -> Result<Recovered, Error> {
    let output = output.as_ref();
    let source = Source::open(path.as_ref())?;
    let scanned = Contents::scanned(&source)?;
    let summary = Contents::summarised(&source);
    let mut found = Recovered::default();
    let mut places: Vec<u64> = scanned.chunks.iter().map(|chunk| chunk.offset).collect();
    let mut torn = scanned.broken_at;
    if let Some(at) = scanned.broken_at {
        let more = match &summary {
            Some(summary) => summary.chunks.iter().map(|chunk| chunk.offset).filter(|&offset| offset >= at).collect(),
            None => search(&source, at + 1)?,
        };
        // What only broke off is at the very end; damage in the middle leaves no part that can be trusted.
        if !more.is_empty() {
            torn = None;
        }
        places.extend(more);
    }
    let size = source.size;
    let mut scanned = scanned;
    let mut buffers = Buffers::default();
    // What the topics are stands in the first chunk; should just that one have broken off, its beginning will do.
    if let Some(at) = torn.filter(|_| scanned.chunks.is_empty())
        && unpack_part(&source, at, &mut buffers)
    {
        scanned.described_in(&buffers.records);
    }
    let session = Session::with(source, with_topics(scanned, summary.as_ref()))?;
    let part = part_path(output);
    let unwritable =
        |error: io::Error| Error::new(&output.to_string_lossy(), What::Unwritable { reason: error.to_string() });
    let file = File::options().write(true).create_new(true).open(&part).map_err(unwritable)?;
    let kept = Kept { session: &session, found: &mut found }.write(file, output, &places, torn, &mut progress);
    let done = kept.and_then(|file| {
        file.sync_all().map_err(unwritable)?;
        fs::rename(&part, output).map_err(unwritable)
    });
    if let Err(error) = done {
        let _ = fs::remove_file(&part);
        return Err(error);
    }
    progress(size, size);
    Ok(found)
}

/// What goes from the old file into the new one.
struct Kept<'a> {
    session: &'a Session,
    found: &'a mut Recovered,
}

impl Kept<'_> {
    fn write(
        mut self,
        file: File,
        output: &Path,
        places: &[u64],
        torn: Option<u64>,
        progress: &mut impl FnMut(u64, u64),
    ) -> Result<File, Error> {
        let session = self.session;
        let mut about = session.about().clone();
        about.extra.insert("recovered".into(), "true".into());
        let compression = session.size().compression.unwrap_or(Compression::Lz4);
        let options = WriteOptions { compression, ..WriteOptions::new(output.to_string_lossy()) };
        let mut writer = SessionWriter::create(file, &about, session.layout(), options)?;
        let mut buffers = Buffers::default();
        for &offset in places {
            progress(offset, session.source.size);
            match session.source.chunk(offset, &mut buffers) {
                Ok(_) => drop(self.copy(&buffers.records, &mut writer)?),
                Err(error) if matches!(error.what, What::Unreadable { .. }) => return Err(error),
                Err(error) => self.found.damaged.push((offset, error.what.to_string())),
            }
        }
        if let Some(at) = torn {
            self.found.left_over = session.source.size - at;
            if unpack_part(&session.source, at, &mut buffers) {
                self.found.unchecked = self.copy(&buffers.records, &mut writer)?;
            }
        }
        let ending = writer.ending();
        if ending.cycles == 0 {
            let reason = "nothing of it can be read".into();
            return Err(session.source.trouble(Trouble::Damaged { offset: 0, reason }));
        }
        // How it ended is known where only the summary is missing.
        let ended = match session.ending() {
            Some(Ending { ended: Some(ended), cycles, .. }) if *cycles == ending.cycles => *ended,
            _ => Ended::Recovered,
        };
        (self.found.cycles, self.found.lost, self.found.gaps) = (ending.cycles, ending.lost, ending.gaps);
        writer.finish(ended)
    }

    /// Copies the messages of a chunk; how many cycles there were.
    fn copy(&mut self, records: &[u8], writer: &mut SessionWriter<File>) -> Result<u64, Error> {
        let topics = self.session.topics;
        let before = writer.cycles();
        let mut at = 0;
        while let Some(Ok((op, range))) = inner(records, at) {
            at = range.end;
            if op != op::MESSAGE {
                continue;
            }
            let Ok(message) = message(records, range) else {
                self.found.passed_over += 1;
                continue;
            };
            let data = &records[message.from..message.to];
            let copied = if message.topic == topics.cycles {
                match body(data).map(|data| data.split_first_chunk::<HEAD_BYTES>()) {
                    Ok(Some((head, channels))) => writer.cycle(&Head::of_bytes(head), channels),
                    _ => self.session.source.damaged_message(),
                }
            } else if Some(message.topic) == topics.figures {
                match LoopFigures::decode(data) {
                    Ok(figures) => writer.loop_stats(&figures),
                    Err(_) => self.session.source.damaged_message(),
                }
            } else if Some(message.topic) == topics.clocks {
                match decode_clocks(data) {
                    Ok(reading) => writer.clocks(&reading),
                    Err(_) => self.session.source.damaged_message(),
                }
            } else if Some(message.topic) == topics.events {
                match Event::decode(data) {
                    // gaps are counted anew
                    Ok(event) if event.kind == GAP => Ok(()),
                    Ok(event) => writer.event(&event),
                    Err(_) => self.session.source.damaged_message(),
                }
            } else {
                Ok(())
            };
            match copied {
                Ok(()) => {}
                Err(error) if matches!(error.what, What::Session(_)) => self.found.passed_over += 1,
                Err(error) => return Err(error),
            }
        }
        Ok(writer.cycles() - before)
    }
}

/// Unpacks what there is of a chunk that broke off here; false where there is none.
fn unpack_part(source: &Source, at: u64, buffers: &mut Buffers) -> bool {
    let most = (source.size - at).min(super::MAX_CHUNK + RECORD_HEAD);
    let mut bytes = vec![0; most as usize];
    if source.read_at(at, &mut bytes).is_err() || bytes.first() != Some(&op::CHUNK) {
        return false;
    }
    let body = bytes.get(RECORD_HEAD as usize..).unwrap_or_default();
    let Ok(head) = ChunkHead::parse(body) else { return false };
    // An error is what is expected: it breaks off. What came before it stays.
    let _ = decompress(&head, &body[head.bytes..], &mut buffers.records);
    !buffers.records.is_empty()
}

impl Source {
    fn damaged_message(&self) -> Result<(), Error> {
        Err(self.trouble(Trouble::Damaged { offset: 0, reason: "a message is damaged".into() }))
    }
}

/// Looks for chunks behind a place where records stopped making sense: what looks like one and has the right checksum is one.
fn search(source: &Source, from: u64) -> Result<Vec<u64>, Error> {
    const HEAD: usize = RECORD_HEAD as usize + ChunkHead::MOST;
    let mut places = Vec::new();
    let mut buffers = Buffers::default();
    let mut window = Vec::new();
    let (mut at, mut tries) = (from, 0);
    'windows: while at + (HEAD as u64) < source.size && tries < MOST_TRIES {
        let length = (source.size - at).min(WINDOW as u64) as usize;
        window.resize(length, 0);
        source.read_at(at, &mut window)?;
        for start in 0..length - HEAD {
            let head = &window[start..start + HEAD];
            // no chunk that is read is as long as 16 MiB · 256: the upper bytes of its length are 0
            if head[0] != op::CHUNK || head[5..9] != [0; 4] {
                continue;
            }
            let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]);
            let plausible = ChunkHead::parse(&head[RECORD_HEAD as usize..]).is_ok_and(|chunk| {
                chunk.crc != 0
                    && chunk.start_ns <= chunk.end_ns
                    && u64::from(length) == chunk.packed + chunk.bytes as u64
            });
            if !plausible {
                continue;
            }
            let offset = at + start as u64;
            match source.chunk(offset, &mut buffers) {
                Ok(_) => {
                    places.push(offset);
                    at = offset + RECORD_HEAD + u64::from(length);
                    continue 'windows;
                }
                Err(error) if matches!(error.what, What::Unreadable { .. }) => return Err(error),
                Err(_) => tries += 1,
            }
        }
        at += (length - HEAD) as u64;
    }
    Ok(places)
}
