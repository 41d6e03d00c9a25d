//! What is in a file: by its own summary, or by looking through it where it has none that can be trusted.

use std::collections::BTreeMap;
use std::io;

use mcap::records::{self, Record, op};

use super::Compression;
use super::about::{ABOUT, ENDING, RIG_FILE};
use super::chunk::{Buffers, ChunkHead, inner};
use super::file::{RECORD_HEAD, RecordAt, Source, Step, TAIL, parse};
use super::message::damaged;
use crate::error::Error;

/// Most chunks of a file.
const MAX_CHUNKS: usize = 1 << 20;

/// Most topics, and most bytes of all their schemas and names.
const MAX_TOPICS: usize = 256;

const MAX_DESCRIPTION: usize = 4 << 20;

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
