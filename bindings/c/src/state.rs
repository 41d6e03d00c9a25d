//! The latest state, how the driver and its loop do, and every cycle.

use crate::border::border;
use crate::connection::client_of;
use crate::handles::{Handles, alone};
use crate::pointers::{Place, patience};
use crate::status::Status;
use crate::structs::{Client, Cycle, CycleStream, DriverHealth, LoopStats, MAX_CHANNELS};
use sinew_ipc::{self as ipc, ChannelState, Snapshot};
use std::sync::Mutex;

static STREAMS: Handles<Mutex<ipc::CycleStream>> = Handles::of("stream");

/// Writes the channels that are there, and leaves the others as they were: most rigs have few.
fn put_channels(channels: &[ChannelState], place: *mut [ChannelState; MAX_CHANNELS]) {
    let count = channels.len().min(MAX_CHANNELS);
    // SAFETY: `place` lies in a struct of C's with room for `MAX_CHANNELS`, and what is read lies elsewhere.
    unsafe { place.cast::<ChannelState>().copy_from_nonoverlapping(channels.as_ptr(), count) }
}

/// The latest state: one whole cycle, never parts of two. Does not wait, and goes on giving the last one after the driver's end.
/// Channels that are not there are left as they were.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_latest(client: *const Client, snapshot: *mut Snapshot) -> Status {
    border(|| {
        // SAFETY: room for it.
        let place = unsafe { Place::at(snapshot, "snapshot") }?.pointer();
        client_of(client)?.with_latest(|latest| {
            // SAFETY: fields of a struct there is room for.
            unsafe {
                (&raw mut (*place).cycle).write(latest.cycle);
                (&raw mut (*place).monotonic_ns).write(latest.monotonic_ns);
                (&raw mut (*place).missed).write(latest.missed);
                (&raw mut (*place).channels).write(latest.channels().len() as u32);
                (&raw mut (*place).state).write(latest.state);
                put_channels(latest.channels(), &raw mut (*place).channel);
            }
        });
        Ok(Status::SINEW_OK)
    })
}

/// How the driver is, and the age of its latest state, s. Either may be null.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_health(client: *const Client, health: *mut DriverHealth, age_s: *mut f64) -> Status {
    border(|| {
        // SAFETY: room for each, or null.
        let (place, age) = unsafe { (Place::if_any(health, "health")?, Place::if_any(age_s, "age_s")?) };
        let client = client_of(client)?;
        place.inspect(|place| place.put(client.health().into()));
        age.inspect(|age| age.put(client.age().as_secs_f64()));
        Ok(Status::SINEW_OK)
    })
}

/// How the loop does.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_loop_stats(client: *const Client, stats: *mut LoopStats) -> Status {
    border(|| {
        // SAFETY: room for it.
        let place = unsafe { Place::at(stats, "stats") }?;
        place.put((&client_of(client)?.loop_stats()).into());
        Ok(Status::SINEW_OK)
    })
}

/// Sleeps until the driver has something new, `SINEW_NOTHING` when that took longer. Comes back at once when something has come since the last
/// call. Threads that sleep at the same time do so best with a client each.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_wait(client: *const Client, timeout_s: f64) -> Status {
    border(|| {
        let client = client_of(client)?;
        let woken = client.wait(patience(timeout_s, "timeout_s")?)?;
        Ok(if woken { Status::SINEW_OK } else { Status::SINEW_NOTHING })
    })
}

/// Every cycle from now on, in order. Buffers about two seconds; who falls behind further loses the oldest, and is told how many. A driver serves 64
/// streams at once.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_stream(client: *const Client, stream: *mut *mut CycleStream) -> Status {
    border(|| {
        // SAFETY: room for a pointer.
        let place = unsafe { Place::at(stream, "stream") }?;
        place.put(std::ptr::null_mut());
        place.put(STREAMS.open(Mutex::new(client_of(client)?.stream()?)));
        Ok(Status::SINEW_OK)
    })
}

/// The next cycle, waiting for it up to so long; `SINEW_NOTHING` when none came. `SINEW_ERROR_DRIVER_GONE` once everything the driver had sent
/// is read. Channels that are not there are left as they were.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_stream_next(stream: *mut CycleStream, timeout_s: f64, cycle: *mut Cycle) -> Status {
    border(|| {
        // SAFETY: room for it.
        let place = unsafe { Place::at(cycle, "cycle") }?.pointer();
        let timeout = patience(timeout_s, "timeout_s")?;
        let stream = STREAMS.get(stream)?;
        let mut stream = alone("stream", &stream)?;
        let Some(next) = stream.next_within(timeout)? else { return Ok(Status::SINEW_NOTHING) };
        // SAFETY: fields of a struct there is room for.
        unsafe {
            (&raw mut (*place).cycle).write(next.header.cycle);
            (&raw mut (*place).monotonic_ns).write(next.header.monotonic_ns);
            (&raw mut (*place).missed).write(next.header.missed);
            (&raw mut (*place).lost).write(next.lost);
            (&raw mut (*place).channels).write(next.channels.len().min(MAX_CHANNELS) as u32);
            put_channels(next.channels, &raw mut (*place).channel);
        }
        Ok(Status::SINEW_OK)
    })
}

/// Cycles received so far, and lost since the first one received: exactly those the driver ran and this reader did not get. Either may be null.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_stream_counts(stream: *const CycleStream, received: *mut u64, lost: *mut u64) -> Status {
    border(|| {
        // SAFETY: room for each, or null.
        let (got, missing) = unsafe { (Place::if_any(received, "received")?, Place::if_any(lost, "lost")?) };
        let stream = STREAMS.get(stream)?;
        let stream = alone("stream", &stream)?;
        got.inspect(|place| place.put(stream.received()));
        missing.inspect(|place| place.put(stream.lost()));
        Ok(Status::SINEW_OK)
    })
}

/// Closes a stream. Null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_stream_close(stream: *mut CycleStream) -> Status {
    border(|| STREAMS.close(stream))
}
