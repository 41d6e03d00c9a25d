//! The file as records: walked from one to the next with bounded memory.
//!
//! Written against <https://mcap.dev/spec>. Everything is read at a position of its own, so that many readers may share a file, and
//! nothing a file claims is believed before there is that much of it.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::{Record, op};

use super::chunk::{Buffers, ChunkHead, MAX_CHUNK, unpack};
use super::error::Trouble;
use super::message::damaged;
use crate::error::{Error, What};

/// The largest other record that is read, bytes.
pub(super) const MAX_RECORD: u64 = 16 << 20;

/// Opcode and length before every record.
pub(super) const RECORD_HEAD: u64 = 9;

/// Footer record and the magic at the end.
pub(super) const TAIL: u64 = RECORD_HEAD + 20 + 8;

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
pub(super) fn parse(op: u8, body: &[u8]) -> Result<Record<'_>, String> {
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
        At { file: &self.file, position: offset }.read_exact(bytes).map_err(|error| match error.kind() {
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

/// Reads at a position, as much as is there at once. No reader goes by where another has left the file.
#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], position: u64) -> io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, bytes, position)
}

#[cfg(windows)]
fn read_at(file: &File, bytes: &mut [u8], position: u64) -> io::Result<usize> {
    std::os::windows::fs::FileExt::seek_read(file, bytes, position)
}

/// A file at a position of its own.
struct At<'a> {
    file: &'a File,
    position: u64,
}

impl Read for At<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = read_at(self.file, bytes, self.position)?;
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

#[cfg(test)]
mod tests {
    use super::*;

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
