//! The serial line, whatever carries it: bytes wait in a pipe each way.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;

/// Bytes that are taken at once: a packet of USB at full speed.
pub const PACKET: usize = 64;

/// From the driver.
pub static DOWN: Pipe<CriticalSectionRawMutex, 1024> = Pipe::new();
/// To the driver: whole frames that wait to go up.
pub static UP: Pipe<CriticalSectionRawMutex, 2048> = Pipe::new();

/// Sends a frame, or, where there is no room, loses it whole.
pub fn send(frame: &[u8]) {
    if UP.free_capacity() < frame.len() {
        return;
    }
    // At the end of its ring a pipe takes a part.
    let mut rest = frame;
    while let Ok(count) = UP.try_write(rest) {
        rest = rest.get(count..).unwrap_or_default();
        if rest.is_empty() {
            break;
        }
    }
}
