//! A chunk: unpacked and checked, and the records inside of it. Memory only grows with what really comes.

use std::io::{self, Read};

use super::Compression;

/// The largest chunk that is read, packed or unpacked, bytes.
pub const MAX_CHUNK: u64 = 64 << 20;

/// A message before its data, with opcode and length.
pub(super) const MESSAGE_HEAD: usize = 9 + 22;

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
pub(super) fn unpack(body: &[u8], records: &mut Vec<u8>) -> Result<ChunkHead, String> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_compression_of_a_long_name_is_refused_in_few_words() {
        let body = [&[0; 28][..], &500u32.to_le_bytes(), &[b'x'; 600]].concat();
        let refused = ChunkHead::parse(&body).unwrap_err();
        assert_eq!(refused, "chunks compressed by \"xxxxxxxxxxxxxxxx\" are not read");
    }
}
