//! The file as records: walked from one to the next with bounded memory, its chunks unpacked and checked.
//!
//! Written against <https://mcap.dev/spec>. Everything is read at a position of its own, so that many readers may share a file, and
//! nothing a file claims is believed before there is that much of it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::os::unix::fs::FileExt;
use std::path::Path;

use mcap::records::{self, Record, op};

use super::Compression;
use super::about::{ABOUT, ENDING, RIG_FILE};
use super::error::Trouble;
use super::message::damaged;
use crate::error::{Error, What};

/// The largest chunk that is read, packed or unpacked, bytes.
pub const MAX_CHUNK: u64 = 64 << 20;
/// The largest other record that is read, bytes.
pub(super) const MAX_RECORD: u64 = 16 << 20;
/// Most chunks of a file.
const MAX_CHUNKS: usize = 1 << 20;
/// Most topics, and most bytes of all their schemas and names.
const MAX_TOPICS: usize = 256;
const MAX_DESCRIPTION: usize = 4 << 20;
/// Opcode and length before every record.
pub(super) const RECORD_HEAD: u64 = 9;
/// Footer record and the magic at the end.
pub(super) const TAIL: u64 = RECORD_HEAD + 20 + 8;
/// A message before its data, with opcode and length.
pub(super) const MESSAGE_HEAD: usize = 9 + 22;

/// A file that is read at positions.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) name: String,
    pub(super) file: File,
    pub(super) size: u64,
}

/// What a record is made of, as far as its length is at stake: mostly its texts lie about it.
enum Piece {
    /// So many bytes.
    Bytes(usize),
    /// A text behind its length.
    Text,
    /// Pairs of whatever size behind their length in bytes.
    Pairs,
    /// Pairs of texts behind their length in bytes.
    Texts,
}

/// Takes a record that is no chunk apart. The parser underneath makes room for a text as long as it says it is, up to 4 GiB,
/// before it looks for it; so that is looked at first.
fn parse(op: u8, body: &[u8]) -> Result<Record<'_>, String> {
    use Piece::{Bytes, Pairs, Text, Texts};
    let pieces: &[Piece] = match op {
        op::HEADER => &[Text, Text],
        op::SCHEMA => &[Bytes(2), Text, Text],
        op::CHANNEL => &[Bytes(4), Text, Text, Texts],
        op::CHUNK => &[Bytes(28), Text],
        op::CHUNK_INDEX => &[Bytes(32), Pairs, Bytes(8), Text],
        // behind them its length and its checksum, which the parser takes for granted
        op::ATTACHMENT => &[Bytes(16), Text, Text, Bytes(8 + 4)],
        op::ATTACHMENT_INDEX => &[Bytes(40), Text, Text],
        op::METADATA => &[Text, Texts],
        op::METADATA_INDEX => &[Bytes(16), Text],
        _ => &[],
    };
    if !pieces_fit(pieces, body) {
        return Err("it is too short for what it says it holds".into());
    }
    mcap::parse_record(op, body).map_err(|error| error.to_string())
}

/// Whether every piece lies within the record.
fn pieces_fit(pieces: &[Piece], body: &[u8]) -> bool {
    fn skip(rest: &mut &[u8], bytes: usize) -> bool {
        rest.split_at_checked(bytes).map(|(_, behind)| *rest = behind).is_some()
    }
    fn length(rest: &mut &[u8]) -> Option<usize> {
        let (bytes, behind) = rest.split_first_chunk()?;
        *rest = behind;
        Some(u32::from_le_bytes(*bytes) as usize)
    }
    let mut rest = body;
    pieces.iter().all(|piece| match piece {
        Piece::Bytes(bytes) => skip(&mut rest, *bytes),
        Piece::Text | Piece::Pairs => length(&mut rest).is_some_and(|bytes| skip(&mut rest, bytes)),
        Piece::Texts => {
            let Some(bytes) = length(&mut rest).filter(|bytes| *bytes <= rest.len()) else { return false };
            let end = rest.len() - bytes;
            while rest.len() > end {
                if !length(&mut rest).is_some_and(|bytes| skip(&mut rest, bytes)) {
                    return false;
                }
            }
            true
        }
    })
}

/// Where a record stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RecordAt {
    pub(super) op: u8,
    pub(super) offset: u64,
    /// Bytes of its body.
    pub(super) length: u64,
}

impl RecordAt {
    pub(super) fn end(&self) -> u64 {
        self.offset + RECORD_HEAD + self.length
    }
}

impl Source {
    /// Opens a file and looks whether it begins as MCAP does.
    pub(super) fn open(path: &Path) -> Result<Source, Error> {
        let name = path.to_string_lossy().into_owned();
        let unreadable = |e: io::Error| Error::new(&name, What::Unreadable { reason: e.to_string() });
        let file = File::open(path).map_err(unreadable)?;
        let size = file.metadata().map_err(unreadable)?.len();
        let source = Source { name: name.clone(), file, size };
        let mut magic = [0; 8];
        let there = source.size.min(8) as usize;
        source.read_at(0, &mut magic[..there])?;
        if there == 0 {
            return Err(Error::new(&name, What::Empty));
        }
        if magic[..there] != mcap::MAGIC[..there] {
            let found = match magic {
                [0x1f, 0x8b, ..] => "compressed by gzip",
                bytes if bytes[..there].iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace()) => "text",
                _ => "something else",
            };
            return Err(source.trouble(Trouble::NotMcap { found }));
        }
        Ok(source)
    }

    pub(super) fn trouble(&self, trouble: Trouble) -> Error {
        Error::new(&self.name, What::Session(trouble))
    }

    pub(super) fn unreadable(&self, error: &io::Error) -> Error {
        Error::new(&self.name, What::Unreadable { reason: error.to_string() })
    }

    pub(super) fn read_at(&self, offset: u64, bytes: &mut [u8]) -> Result<(), Error> {
        self.file.read_exact_at(bytes, offset).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => self.trouble(damaged(offset, "the file ends in the middle of a record")),
            _ => self.unreadable(&error),
        })
    }

    /// Reads the body of a record.
    pub(super) fn body(&self, at: &RecordAt, body: &mut Vec<u8>) -> Result<(), Error> {
        let limit = if at.op == op::CHUNK { MAX_CHUNK } else { MAX_RECORD };
        if at.length > limit {
            return Err(self.trouble(Trouble::TooLarge { offset: at.offset, found: at.length, limit }));
        }
        if at.end() > self.size {
            return Err(self.trouble(damaged(at.offset, "the file ends in the middle of this record")));
        }
        body.resize(at.length as usize, 0);
        self.read_at(at.offset + RECORD_HEAD, body)
    }

    /// Reads and takes apart a record that is no chunk.
    pub(super) fn record(&self, at: &RecordAt) -> Result<Record<'static>, Error> {
        let mut body = Vec::new();
        self.body(at, &mut body)?;
        parse(at.op, &body).map(Record::into_owned).map_err(|reason| self.trouble(damaged(at.offset, &reason)))
    }

    /// The record that begins here, which has to be one of these.
    pub(super) fn record_at(&self, offset: u64, op: u8) -> Result<RecordAt, Error> {
        let mut head = [0; RECORD_HEAD as usize];
        self.read_at(offset, &mut head)?;
        let length = u64::from_le_bytes([head[1], head[2], head[3], head[4], head[5], head[6], head[7], head[8]]);
        let at = RecordAt { op: head[0], offset, length };
        if at.op != op || length > self.size || at.end() > self.size {
            return Err(self.trouble(damaged(offset, "the index points to something else")));
        }
        Ok(at)
    }

    /// All records from here to there, one after the other.
    pub(super) fn walk(&self, from: u64, to: u64) -> Walk<'_> {
        Walk { reader: BufReader::with_capacity(1 << 14, At { file: &self.file, position: from }), at: from, to }
    }

    /// Reads and unpacks a chunk.
    pub(super) fn chunk(&self, offset: u64, buffers: &mut Buffers) -> Result<ChunkHead, Error> {
        let at = self.record_at(offset, op::CHUNK)?;
        self.body(&at, &mut buffers.packed)?;
        unpack(&buffers.packed, &mut buffers.records).map_err(|reason| self.trouble(damaged(offset, &reason)))
    }
}

/// Scratch space for unpacking chunks.
#[derive(Debug, Default)]
pub(super) struct Buffers {
    pub(super) packed: Vec<u8>,
    /// The records of the chunk.
    pub(super) records: Vec<u8>,
}

/// What stands before a chunk's data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ChunkHead {
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    pub(super) unpacked: u64,
    pub(super) packed: u64,
    pub(super) compression: Compression,
    pub(super) crc: u32,
    /// Bytes of this head itself.
    pub(super) bytes: usize,
}

impl ChunkHead {
    /// Longest head, bytes.
    pub(super) const MOST: usize = 8 + 8 + 8 + 4 + 4 + 4 + 8;

    pub(super) fn parse(body: &[u8]) -> Result<ChunkHead, String> {
        let short = || "the chunk's head is incomplete".to_string();
        let u64_at =
            |at: usize| body.get(at..at + 8).and_then(|b| b.try_into().ok()).map(u64::from_le_bytes).ok_or_else(short);
        let u32_at =
            |at: usize| body.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes).ok_or_else(short);
        let name_bytes = u32_at(28)? as usize;
        let name = body.get(32..).and_then(|rest| rest.get(..name_bytes)).ok_or_else(short)?;
        let compression = Compression::of_name(name).ok_or_else(|| {
            // a damaged length may make a name of the whole chunk
            let name = String::from_utf8_lossy(&name[..name.len().min(16)]);
            format!("chunks compressed by {name:?} are not read")
        })?;
        let at = 32 + name_bytes;
        Ok(ChunkHead {
            start_ns: u64_at(0)?,
            end_ns: u64_at(8)?,
            unpacked: u64_at(16)?,
            crc: u32_at(24)?,
            compression,
            packed: u64_at(at)?,
            bytes: at + 8,
        })
    }
}

/// Unpacks the body of a chunk and compares its checksum.
fn unpack(body: &[u8], records: &mut Vec<u8>) -> Result<ChunkHead, String> {
    let head = ChunkHead::parse(body)?;
    let data = &body[head.bytes..];
    if head.packed != data.len() as u64 {
        return Err(format!("the chunk has {} bytes, but says {}", data.len(), head.packed));
    }
    decompress(&head, data, records).map_err(|error| error.to_string())?;
    if records.len() as u64 != head.unpacked {
        return Err(format!("the chunk unpacks to {} bytes, but says {}", records.len(), head.unpacked));
    }
    let crc = crc32fast::hash(records);
    if head.crc != 0 && head.crc != crc {
        return Err(format!("the chunk's checksum is {crc:08x}, but it says {:08x}", head.crc));
    }
    Ok(head)
}

/// Unpacks as much as there is, up to what the head says; an error leaves what came before it.
pub(super) fn decompress(head: &ChunkHead, data: &[u8], records: &mut Vec<u8>) -> io::Result<()> {
    records.clear();
    if head.unpacked > MAX_CHUNK {
        return Err(io::Error::other(format!("{} bytes unpacked are more than {MAX_CHUNK}", head.unpacked)));
    }
    // One byte more than it may have shows that it has more; memory only grows with what really comes.
    let most = head.unpacked + 1;
    match head.compression {
        Compression::None => records.extend_from_slice(data),
        Compression::Lz4 => drop(lz4::Decoder::new(data)?.take(most).read_to_end(records)?),
        Compression::Zstd => drop(zstd::Decoder::with_buffer(data)?.take(most).read_to_end(records)?),
    }
    Ok(())
}

/// A file at a position of its own.
struct At<'a> {
    file: &'a File,
    position: u64,
}

impl Read for At<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read_at(bytes, self.position)?;
        self.position += read as u64;
        Ok(read)
    }
}

impl Seek for At<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(by) => self.position.checked_add_signed(by),
            SeekFrom::End(_) => None,
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

/// Records one after the other; what is inside of chunks is passed over.
pub(super) struct Walk<'a> {
    reader: BufReader<At<'a>>,
    at: u64,
    to: u64,
}

/// How far records go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// Here is one, complete.
    Record(RecordAt),
    /// There are no more.
    End,
    /// From here on there is no complete record.
    Broken(u64),
}

impl Walk<'_> {
    pub(super) fn step(&mut self) -> io::Result<Step> {
        if self.at == self.to {
            return Ok(Step::End);
        }
        let broken = Ok(Step::Broken(self.at));
        if self.to.saturating_sub(self.at) < RECORD_HEAD {
            return broken;
        }
        let mut head = [0; RECORD_HEAD as usize];
        match self.reader.read_exact(&mut head) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return broken,
            read => read?,
        }
        let length = u64::from_le_bytes([head[1], head[2], head[3], head[4], head[5], head[6], head[7], head[8]]);
        if head[0] == 0 || length > self.to - self.at - RECORD_HEAD {
            return broken;
        }
        let at = RecordAt { op: head[0], offset: self.at, length };
        self.at = at.end();
        self.reader.seek_relative(length as i64)?;
        Ok(Step::Record(at))
    }
}

/// One message in a chunk.
#[derive(Debug, Clone, Copy)]
pub(super) struct MessageAt {
    pub(super) topic: u16,
    /// Where its data begin and end among the chunk's records.
    pub(super) from: usize,
    pub(super) to: usize,
}

/// The record of a chunk that begins here: opcode, body, and where the next one begins. `None` at the end.
pub(super) fn inner(records: &[u8], at: usize) -> Option<Result<(u8, std::ops::Range<usize>), &'static str>> {
    let rest = records.get(at..).filter(|rest| !rest.is_empty())?;
    let Some((head, body)) = rest.split_first_chunk::<9>() else {
        return Some(Err("the chunk ends in the middle of a record"));
    };
    let length = u64::from_le_bytes([head[1], head[2], head[3], head[4], head[5], head[6], head[7], head[8]]);
    if length > body.len() as u64 {
        return Some(Err("the chunk ends in the middle of a record"));
    }
    let from = at + 9;
    Some(Ok((head[0], from..from + length as usize)))
}

/// The message in this body of a record, which stands here in the chunk.
pub(super) fn message(records: &[u8], body: std::ops::Range<usize>) -> Result<MessageAt, &'static str> {
    const HEAD: usize = MESSAGE_HEAD - 9;
    let head = records[body.clone()].first_chunk::<HEAD>().ok_or("a message is too short")?;
    Ok(MessageAt { topic: u16::from_le_bytes([head[0], head[1]]), from: body.start + HEAD, to: body.end })
}

/// A chunk of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ChunkAt {
    pub(super) offset: u64,
    /// Bytes of the whole record.
    pub(super) length: u64,
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    pub(super) packed: u64,
    pub(super) unpacked: u64,
    pub(super) compression: Compression,
    /// The indexes behind it: each topic's offset and number of messages (0 where only the offset is known).
    pub(super) indexes: Vec<(u16, u64, u64)>,
}

/// A topic of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) schema: u16,
}

/// A schema of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) text: Vec<u8>,
}

/// What is in a file, by its own summary or by looking through it.
#[derive(Debug, Clone, Default)]
pub(super) struct Contents {
    pub(super) schemas: BTreeMap<u16, Schema>,
    pub(super) topics: BTreeMap<u16, Topic>,
    pub(super) chunks: Vec<ChunkAt>,
    pub(super) metadata: Vec<(RecordAt, String)>,
    pub(super) attachments: Vec<(RecordAt, String)>,
    /// Messages of each topic, by the summary's statistics or the indexes behind the chunks.
    pub(super) messages: BTreeMap<u16, u64>,
    /// Where complete records end, for a file that stops in the middle.
    pub(super) broken_at: Option<u64>,
    /// Whether the file has a summary.
    pub(super) summary: bool,
    /// Where the data end: complete records up to here.
    pub(super) data_end: u64,
    /// Bytes of schemas and topics so far.
    description: usize,
}

impl Contents {
    /// Of a file: by its summary where it has a good one, else by looking through all of it.
    pub(super) fn of(source: &Source) -> Result<Contents, Error> {
        match Contents::summarised(source) {
            Some(contents) => Ok(contents),
            None => Contents::scanned(source),
        }
    }

    /// By the summary; `None` where there is none to be trusted.
    pub(super) fn summarised(source: &Source) -> Option<Contents> {
        let footer = footer(source)?;
        if footer.summary_start == 0 || footer.summary_start > source.size - TAIL {
            return None;
        }
        let mut contents = Contents { summary: true, data_end: footer.summary_start, ..Contents::default() };
        let mut walk = source.walk(footer.summary_start, source.size - TAIL);
        loop {
            let at = match walk.step().ok()? {
                Step::Record(at) => at,
                Step::End => return Some(contents),
                Step::Broken(_) => return None,
            };
            let record = match at.op {
                op::SUMMARY_OFFSET => continue,
                _ => source.record(&at).ok()?,
            };
            match record {
                Record::ChunkIndex(index) => {
                    if contents.chunks.len() >= MAX_CHUNKS {
                        return None;
                    }
                    contents.chunks.push(ChunkAt {
                        offset: index.chunk_start_offset,
                        length: index.chunk_length,
                        start_ns: index.message_start_time,
                        end_ns: index.message_end_time,
                        packed: index.compressed_size,
                        unpacked: index.uncompressed_size,
                        compression: Compression::of_name(index.compression.as_bytes())?,
                        indexes: index.message_index_offsets.iter().map(|(&topic, &at)| (topic, at, 0)).collect(),
                    });
                }
                Record::MetadataIndex(index) => {
                    let at = source.record_at(index.offset, op::METADATA).ok()?;
                    contents.beside(at, index.name);
                }
                Record::AttachmentIndex(index) => {
                    let at = source.record_at(index.offset, op::ATTACHMENT).ok()?;
                    contents.beside(at, index.name);
                }
                Record::Statistics(statistics) => contents.messages = statistics.channel_message_counts,
                other => contents.describe(&other),
            }
        }
    }

    /// By looking through the whole file, as far as it goes.
    pub(super) fn scanned(source: &Source) -> Result<Contents, Error> {
        let unreadable = |error: io::Error| source.unreadable(&error);
        let mut contents = Contents { data_end: source.size.min(8), ..Contents::default() };
        let mut walk = source.walk(contents.data_end, source.size);
        let mut buffers = Buffers::default();
        loop {
            let at = match walk.step().map_err(unreadable)? {
                Step::Record(at) => at,
                Step::End => break,
                Step::Broken(at) => {
                    contents.broken_at = Some(at);
                    break;
                }
            };
            match at.op {
                op::DATA_END | op::FOOTER => break,
                op::CHUNK => {
                    let mut body = [0; ChunkHead::MOST];
                    let there = (at.length as usize).min(body.len());
                    source.read_at(at.offset + RECORD_HEAD, &mut body[..there])?;
                    // no chunk at all: the length led nowhere
                    let Ok(head) = ChunkHead::parse(&body[..there]) else {
                        contents.broken_at = Some(at.offset);
                        break;
                    };
                    if contents.chunks.len() >= MAX_CHUNKS {
                        let reason = format!("there are more than {MAX_CHUNKS} chunks");
                        return Err(source.trouble(damaged(at.offset, &reason)));
                    }
                    contents.chunks.push(ChunkAt {
                        offset: at.offset,
                        length: at.end() - at.offset,
                        start_ns: head.start_ns,
                        end_ns: head.end_ns,
                        packed: head.packed,
                        unpacked: head.unpacked,
                        compression: head.compression,
                        indexes: Vec::new(),
                    });
                    // What the topics are stands in the first chunk that has any.
                    if contents.topics.is_empty() && source.chunk(at.offset, &mut buffers).is_ok() {
                        contents.described_in(&buffers.records);
                    }
                }
                op::MESSAGE_INDEX => {
                    if let (Ok(Record::MessageIndex(index)), Some(chunk)) =
                        (source.record(&at), contents.chunks.last_mut())
                    {
                        let messages = index.records.len() as u64;
                        if chunk.indexes.len() < MAX_TOPICS {
                            chunk.indexes.push((index.channel_id, at.offset, messages));
                        }
                        *contents.messages.entry(index.channel_id).or_default() += messages;
                    }
                }
                op::SCHEMA | op::CHANNEL => {
                    if let Ok(record) = source.record(&at) {
                        contents.describe(&record);
                    }
                }
                op::METADATA => {
                    if let Ok(Record::Metadata(metadata)) = source.record(&at) {
                        contents.beside(at, metadata.name);
                    }
                }
                op::ATTACHMENT => {
                    if let Ok(Record::Attachment { header, .. }) = source.record(&at) {
                        contents.beside(at, header.name);
                    }
                }
                _ => {}
            }
            contents.data_end = at.end();
        }
        Ok(contents)
    }

    /// Takes note of metadata and attachments, those that mean something here.
    fn beside(&mut self, at: RecordAt, name: String) {
        let list = if at.op == op::METADATA { &mut self.metadata } else { &mut self.attachments };
        if [ABOUT, ENDING, RIG_FILE].contains(&name.as_str()) && list.len() < MAX_TOPICS {
            list.push((at, name));
        }
    }

    /// Takes schemas and topics out of a chunk's records.
    pub(super) fn described_in(&mut self, records: &[u8]) {
        let mut at = 0;
        while let Some(Ok((op, body))) = inner(records, at) {
            at = body.end;
            if matches!(op, op::SCHEMA | op::CHANNEL)
                && let Ok(record) = parse(op, &records[body])
            {
                self.describe(&record);
            }
        }
    }

    fn describe(&mut self, record: &Record<'_>) {
        // what a hostile file has too much of is passed over
        let bytes = match record {
            Record::Schema { header, data } => header.name.len() + header.encoding.len() + data.len(),
            Record::Channel(channel) => channel.topic.len() + channel.message_encoding.len(),
            _ => return,
        };
        self.description += bytes;
        if self.description > MAX_DESCRIPTION || self.topics.len().max(self.schemas.len()) >= MAX_TOPICS {
            return;
        }
        match record {
            Record::Schema { header, data } => {
                let schema =
                    Schema { name: header.name.clone(), encoding: header.encoding.clone(), text: data.to_vec() };
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => {
                let topic = Topic {
                    name: channel.topic.clone(),
                    encoding: channel.message_encoding.clone(),
                    schema: channel.schema_id,
                };
                self.topics.insert(channel.id, topic);
            }
            _ => {}
        }
    }

    /// The number of a topic.
    pub(super) fn topic(&self, name: &str) -> Option<u16> {
        self.topics.iter().find(|(_, topic)| topic.name == name).map(|(&id, _)| id)
    }

    /// The metadata of this name, the last one.
    pub(super) fn metadata(&self, source: &Source, name: &str) -> Option<BTreeMap<String, String>> {
        let (at, _) = self.metadata.iter().rev().find(|(_, known)| known == name)?;
        match source.record(at) {
            Ok(Record::Metadata(metadata)) => Some(metadata.metadata),
            _ => None,
        }
    }

    /// The attachment of this name, as text.
    pub(super) fn attachment(&self, source: &Source, name: &str) -> Option<String> {
        let (at, _) = self.attachments.iter().find(|(_, known)| known == name)?;
        match source.record(at) {
            Ok(Record::Attachment { data, .. }) => String::from_utf8(data.into_owned()).ok(),
            _ => None,
        }
    }
}

/// The footer, where the file ends with one.
pub(super) fn footer(source: &Source) -> Option<records::Footer> {
    let at = source.size.checked_sub(TAIL)?;
    let mut tail = [0; TAIL as usize];
    source.read_at(at, &mut tail).ok()?;
    if tail[0] != op::FOOTER || tail[TAIL as usize - 8..] != *mcap::MAGIC {
        return None;
    }
    match mcap::parse_record(op::FOOTER, &tail[RECORD_HEAD as usize..TAIL as usize - 8]) {
        Ok(Record::Footer(footer)) => Some(footer),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compression_of_a_long_name_is_refused_in_few_words() {
        let body = [&[0; 28][..], &500u32.to_le_bytes(), &[b'x'; 600]].concat();
        let refused = ChunkHead::parse(&body).unwrap_err();
        assert_eq!(refused, "chunks compressed by \"xxxxxxxxxxxxxxxx\" are not read");
    }

    #[test]
    fn a_text_that_claims_to_be_longer_than_its_record_gets_no_room() {
        let lies = [0xf2, 0x73, 0x20, 0x6e, b'x'];
        for (op, before) in [
            (op::HEADER, 0),
            (op::SCHEMA, 2),
            (op::CHANNEL, 4),
            (op::ATTACHMENT, 16),
            (op::ATTACHMENT_INDEX, 40),
            (op::METADATA, 0),
            (op::METADATA_INDEX, 16),
        ] {
            let body = [&vec![0; before][..], &lies].concat();
            assert_eq!(parse(op, &body).unwrap_err(), "it is too short for what it says it holds", "{op}");
        }
        // an attachment that ends behind its length, where its checksum should be
        let cut = [&[0; 16][..], &[1, 0, 0, 0, b'n', 0, 0, 0, 0], &[0; 8]].concat();
        assert_eq!(parse(op::ATTACHMENT, &cut).unwrap_err(), "it is too short for what it says it holds");
        // the first text of a pair is good, the second lies
        let pair = [&[0, 0, 0, 0, 14, 0, 0, 0, 1, 0, 0, 0, b'a'][..], &lies, &[0; 4]].concat();
        assert!(parse(op::METADATA, &pair).is_err());
        let good = [1, 0, 0, 0, b'n', 10, 0, 0, 0, 1, 0, 0, 0, b'a', 1, 0, 0, 0, b'b'];
        assert!(matches!(parse(op::METADATA, &good), Ok(Record::Metadata(m)) if m.metadata["a"] == "b"));
    }
}
