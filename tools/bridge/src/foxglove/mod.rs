//! The bridge to Foxglove and what speaks its WebSocket protocol: every cycle, with the schemas and the encoding of recordings.
//!
//! An ordinary thread ([`watch`](crate::watch)) reads every cycle as any client does, encodes each once and puts it into a ring of the latest
//! messages (`feed`). Each viewer has a place in that ring (`session`): one that fetches too slowly loses the oldest messages,
//! which is counted and said to it. Nobody ever waits for a viewer.

mod feed;
mod protocol;
mod server;
mod session;

pub use server::Foxglove;
