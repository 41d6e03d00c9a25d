//! Checking all of a recording: every record, every checksum, every index, every cycle.

use std::path::Path;

use mcap::records::{Record, op};

use super::about::{Ending, Gap, MAX_GAPS};
use super::chunk::{Buffers, inner, message};
use super::contents::{ChunkAt, Contents, footer};
use super::file::{RECORD_HEAD, Source, TAIL};
use super::layout::HEAD_BYTES;
use super::message::body;
use super::read::Session;
use super::{CYCLES, Head};
use crate::error::{Error, What};

/// Findings that are listed one by one.
const MAX_FINDINGS: usize = 200;

/// Something about a recording that is not as it should be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Whether it is damage; else it is only worth knowing.
    pub damage: bool,
    /// What it is.
    pub text: String,
}

/// What came of a check.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Checkup {
    /// What was found, in the order of the file.
    pub findings: Vec<Finding>,
    /// Findings beyond those.
    pub more: u64,
    /// Cycles that can be read.
    pub cycles: u64,
    /// Cycles lost between the first and the last one, by their numbers.
    pub lost: u64,
    /// Which ones; the first ten thousand gaps.
    pub gaps: Vec<Gap>,
    /// Periods the driver skipped from the first cycle to the last.
    pub missed: u64,
    /// Chunks there are, and how many of them cannot be read.
    pub chunks: u64,
    /// See `chunks`.
    pub damaged_chunks: u64,
}

impl Checkup {
    /// Whether nothing is damaged. Cycles may have been lost while it was recorded; the file says so then.
    pub fn is_whole(&self) -> bool {
        self.more == 0 && self.findings.iter().all(|finding| !finding.damage)
    }

    fn add(&mut self, damage: bool, text: impl Into<String>) {
        if self.findings.len() < MAX_FINDINGS {
            self.findings.push(Finding { damage, text: text.into() });
        } else {
            self.more += u64::from(damage);
        }
    }
}

/// Checks a recording; `progress` is given how much of the file is done, bytes, and how much there is.
///
/// # Errors
/// Where it cannot be read at all, or is no recording.
pub fn check(path: impl AsRef<Path>, mut progress: impl FnMut(u64, u64)) -> Result<Checkup, Error> {
    let source = Source::open(path.as_ref())?;
    let scanned = Contents::scanned(&source)?;
    let summary = Contents::summarised(&source);
    let mut found = Checkup { chunks: scanned.chunks.len() as u64, ..Checkup::default() };
    check_end(&source, &scanned, summary.as_ref(), &mut found)?;
    let size = source.size;
    // By the scan: what the summary says is compared with that.
    let session = Session::with(source, with_topics(scanned, summary.as_ref()))?;
    let mut walk = CycleWalk::default();
    let mut buffers = Buffers::default();
    for chunk in &session.contents.chunks {
        progress(chunk.offset, size);
        check_chunk(&session, chunk, &mut buffers, &mut walk, &mut found)?;
    }
    progress(size, size);
    found.lost = walk.lost;
    found.cycles = walk.cycles;
    if let (Some(first), Some(last)) = (walk.first, walk.last) {
        found.missed = last.missed.saturating_sub(first.missed);
    }
    found.gaps = walk.gaps;
    match session.ending() {
        None => found.add(false, "it does not say how it ended"),
        Some(ending) => check_ending(ending, &mut found),
    }
    Ok(found)
}

/// What a file with a damaged first chunk does not say about its topics, its summary does.
pub(super) fn with_topics(mut scanned: Contents, summary: Option<&Contents>) -> Contents {
    if let Some(summary) = summary.filter(|_| scanned.topic(CYCLES).is_none()) {
        scanned.topics = summary.topics.clone();
        scanned.schemas = summary.schemas.clone();
    }
    scanned
}

/// The end of the file: data, summary and footer.
fn check_end(
    source: &Source,
    scanned: &Contents,
    summary: Option<&Contents>,
    found: &mut Checkup,
) -> Result<(), Error> {
    if let Some(at) = scanned.broken_at {
        let left = source.size - at;
        found.add(true, format!("from byte {at} on there is no complete record: {left} bytes are cut off or damaged"));
    }
    let Some(footer) = footer(source) else {
        found.add(true, "it has no end: its recorder was killed, or it was cut off later");
        return Ok(());
    };
    if scanned.broken_at.is_none()
        && let Ok(at) = source.record_at(scanned.data_end, op::DATA_END)
        && let Ok(Record::DataEnd(end)) = source.record(&at)
        && end.data_section_crc != 0
    {
        let crc = checksum(source, 0, scanned.data_end)?;
        if crc != end.data_section_crc {
            let said = end.data_section_crc;
            found.add(true, format!("the checksum of all data is {crc:08x}, but the file says {said:08x}"));
        }
    }
    if footer.summary_start == 0 {
        found.add(false, "it has no summary: it opens slowly, `sinew recording recover` makes one");
        return Ok(());
    }
    let Some(summary) = summary else {
        found.add(true, "its summary cannot be read");
        return Ok(());
    };
    if footer.summary_crc != 0 {
        let crc = checksum(source, footer.summary_start, source.size - 12)?;
        if crc != footer.summary_crc {
            let said = footer.summary_crc;
            found.add(true, format!("the checksum of its summary is {crc:08x}, but the file says {said:08x}"));
        }
    }
    let plain = |chunks: &[ChunkAt]| -> Vec<ChunkAt> {
        chunks.iter().map(|chunk| ChunkAt { indexes: Vec::new(), ..chunk.clone() }).collect()
    };
    if plain(&summary.chunks) != plain(&scanned.chunks) {
        let (listed, there) = (summary.chunks.len(), scanned.chunks.len());
        found.add(true, format!("its summary lists other chunks ({listed}) than there are ({there})"));
    }
    if summary.messages != scanned.messages {
        found.add(true, "its summary counts other messages than its indexes");
    }
    Ok(())
}

fn checksum(source: &Source, from: u64, to: u64) -> Result<u32, Error> {
    let mut hasher = crc32fast::Hasher::new();
    let mut bytes = vec![0; 1 << 20];
    let mut at = from;
    while at < to {
        let next = (to - at).min(bytes.len() as u64) as usize;
        source.read_at(at, &mut bytes[..next])?;
        hasher.update(&bytes[..next]);
        at += next as u64;
    }
    Ok(hasher.finalize())
}

/// The cycles so far.
#[derive(Debug, Default)]
struct CycleWalk {
    first: Option<Head>,
    last: Option<Head>,
    cycles: u64,
    lost: u64,
    gaps: Vec<Gap>,
}

/// One chunk: its checksum, its messages, the indexes behind it.
fn check_chunk(
    session: &Session,
    chunk: &ChunkAt,
    buffers: &mut Buffers,
    walk: &mut CycleWalk,
    found: &mut Checkup,
) -> Result<(), Error> {
    let source = &session.source;
    let place = format!("the chunk at byte {}", chunk.offset);
    if let Err(error) = source.chunk(chunk.offset, buffers) {
        if matches!(error.what, What::Unreadable { .. }) {
            return Err(error);
        }
        found.damaged_chunks += 1;
        found.add(true, error.what.to_string());
        return Ok(());
    }
    let records = &buffers.records;
    // Topic and place of each message, as an index has them.
    let mut messages: Vec<(u16, u64)> = Vec::new();
    let mut at = 0;
    while let Some(record) = inner(records, at) {
        let Ok((op, range)) = record else {
            found.add(true, format!("{place} ends in the middle of a record"));
            break;
        };
        let start = at as u64;
        at = range.end;
        if op != op::MESSAGE {
            continue;
        }
        let Ok(message) = message(records, range) else {
            found.add(true, format!("{place} has a message that is too short"));
            continue;
        };
        messages.push((message.topic, start));
        if message.topic != session.topics.cycles {
            continue;
        }
        match body(&records[message.from..message.to]).map(|data| data.split_first_chunk::<HEAD_BYTES>()) {
            Ok(Some((head, channels))) if channels.len() == session.layout().bytes() => {
                check_cycle(Head::of_bytes(head), session.about().rate_hz, &place, walk, found);
            }
            _ => found.add(true, format!("{place} has a cycle that is not as its schema says")),
        }
    }
    let mut indexed = 0;
    for &(topic, offset, _) in &chunk.indexes {
        let index = source.record_at(offset, op::MESSAGE_INDEX).and_then(|at| source.record(&at));
        let Ok(Record::MessageIndex(index)) = index else { continue };
        indexed += index.records.len();
        let here = messages.iter().filter(|(id, _)| *id == topic).map(|(_, at)| *at);
        if !index.records.iter().map(|entry| entry.offset).eq(here) {
            found.add(true, format!("an index behind {place} points to other messages than there are"));
        }
    }
    if indexed != messages.len() {
        found.add(true, format!("the indexes behind {place} have {indexed} of its {} messages", messages.len()));
    }
    Ok(())
}

/// One cycle after the one before.
fn check_cycle(head: Head, rate_hz: f64, place: &str, walk: &mut CycleWalk, found: &mut Checkup) {
    let Some(last) = walk.last else {
        (walk.first, walk.last, walk.cycles) = (Some(head), Some(head), 1);
        return;
    };
    if head.cycle <= last.cycle {
        let what = if head.cycle == last.cycle { "a second time" } else { "out of order" };
        found.add(true, format!("{place} has cycle {} {what}, after {}", head.cycle, last.cycle));
        return;
    }
    if head.monotonic_ns <= last.monotonic_ns {
        found.add(true, format!("{place}: time does not advance from cycle {} to {}", last.cycle, head.cycle));
    }
    if head.missed < last.missed {
        found.add(true, format!("{place}: the count of missed periods falls at cycle {}", head.cycle));
    }
    let gap = head.cycle - last.cycle - 1;
    // A cycle comes a period after the one before, but for those that were missed or lost; a whole second more is no jitter.
    let periods = (gap + 1).saturating_add(head.missed.saturating_sub(last.missed)) as f64;
    let late_s = head.monotonic_ns.saturating_sub(last.monotonic_ns) as f64 * 1e-9 - periods / rate_hz;
    if late_s > 1.0 {
        found.add(false, format!("{late_s:.1} s without a cycle before cycle {}", head.cycle));
    }
    if gap > 0 {
        walk.lost += gap;
        if walk.gaps.len() < MAX_GAPS {
            walk.gaps.push(Gap { from: last.cycle + 1, to: head.cycle - 1 });
        }
    }
    walk.cycles += 1;
    walk.last = Some(head);
}

/// What the file says of its end, beside what is there.
fn check_ending(ending: &Ending, found: &mut Checkup) {
    if ending.cycles != found.cycles {
        let text = format!("it says that it has {} cycles, but {} are there", ending.cycles, found.cycles);
        found.add(true, text);
    }
    // a gap at its very beginning or end is only known to the recorder
    if ending.lost < found.lost {
        found.add(true, format!("it says that {} cycles were lost, but {} are missing", ending.lost, found.lost));
    }
    if ending.lost > 0 {
        let text = format!("{} cycles were lost while it was recorded, in {} gaps", ending.lost, ending.gaps.len());
        found.add(false, text);
        found.lost = ending.lost;
        found.gaps = ending.gaps.clone();
    }
}

// A record's head is what lies between its offset and its body; the footer is the last one before the magic.
const _: () = assert!(TAIL == RECORD_HEAD + 20 + 8);
