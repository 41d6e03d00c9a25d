//! Streams of setpoints: what a planner tells the driver without waiting for it.

use crate::border::{Failure, border};
use crate::command::{all_of, fits};
use crate::connection::client_of;
use crate::handles::{Handles, alone};
use crate::pointers::{Place, hold, patience, values};
use crate::status::Status;
use crate::structs::{Client, SetpointProgress, Setpoints, Wanted};
use sinew_ipc::{self as ipc, SetpointOptions};
use std::sync::{Arc, Mutex};

/// cbindgen:ignore
type Stream = ipc::Setpoints<Arc<ipc::Client>>;

static STREAMS: Handles<Mutex<Stream>> = Handles::of("stream of setpoints");

/// Opens a stream of setpoints. Each message holds for `hold_s` unless the next one comes (0: the shortest of its channels' defaults), is
/// approached in a straight line within `over_s` from what was wanted before (0: it holds at once; at the most the lease, usually the
/// planner's own period), and is not carried out where the driver gets to it later than `within_s` (0: whenever it comes).
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_setpoints(
    client: *const Client,
    hold_s: f64,
    over_s: f64,
    within_s: f64,
    setpoints: *mut *mut Setpoints,
) -> Status {
    border(|| {
        // SAFETY: room for a pointer.
        let place = unsafe { Place::at(setpoints, "setpoints") }?;
        place.put(std::ptr::null_mut());
        let within = patience(within_s, "within_s")?;
        let options = SetpointOptions {
            hold: hold(hold_s)?,
            over: patience(over_s, "over_s")?,
            within: (!within.is_zero()).then_some(within),
        };
        place.put(STREAMS.open(Mutex::new(Stream::new(client_of(client)?, options))));
        Ok(Status::SINEW_OK)
    })
}

/// Sends setpoints for several channels on their way, all or none, and does not wait: the newest overtakes those that still wait. A refusal is
/// that of an earlier message, and this one is on its way all the same; with every other error it was not sent. `progress`, which may be
/// null, gets what became of the messages so far.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_setpoints_send(
    setpoints: *mut Setpoints,
    wanted: *const Wanted,
    count: usize,
    progress: *mut SetpointProgress,
) -> Status {
    border(|| {
        fits(count)?;
        // SAFETY: so many values.
        let wanted = all_of(unsafe { values(wanted, count, "wanted") }?)?;
        // SAFETY: room or null.
        unsafe { ask(setpoints, progress, |stream| stream.send(&wanted)) }
    })
}

/// Looks for answers to what is on its way, without waiting. `progress`, which may be null, gets what became of the messages so far.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_setpoints_poll(setpoints: *mut Setpoints, progress: *mut SetpointProgress) -> Status {
    // SAFETY: the same pointer, handed on.
    border(|| unsafe { ask(setpoints, progress, Stream::poll) })
}

/// # Safety
/// `progress` is null or room for it.
unsafe fn ask(
    setpoints: *mut Setpoints,
    progress: *mut SetpointProgress,
    ask: impl FnOnce(&mut Stream) -> Result<ipc::Progress, ipc::Error>,
) -> Result<Status, Failure> {
    // SAFETY: the caller's word.
    let place = unsafe { Place::if_any(progress, "progress") }?;
    let stream = STREAMS.get(setpoints)?;
    let mut stream = alone("stream of setpoints", &stream)?;
    let found = ask(&mut stream)?;
    place.inspect(|place| place.put(found.into()));
    Ok(Status::SINEW_OK)
}

/// Closes a stream of setpoints. What the driver has not begun with is not carried out; what is in force holds until its lease ends. Null is
/// fine.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_setpoints_close(setpoints: *mut Setpoints) -> Status {
    border(|| STREAMS.close(setpoints))
}
