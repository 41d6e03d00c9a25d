//! Commands: setpoints with their leases, `off`, `reset`, `stop`.

use crate::border::{Failure, border};
use crate::connection::client_of;
use crate::pointers::{Place, hold, text, values};
use crate::status::Status;
use crate::structs::{Client, Taken, Wanted};
use sinew_ipc::{self as ipc, CommandKind, Error, MAX_CHANNELS};
use std::ffi::c_char;

fn kind_of(code: u32) -> Result<CommandKind, Failure> {
    CommandKind::from_code(code).ok_or_else(|| {
        Failure::argument(
            format!("{code} is no kind of command"),
            "use one of SinewCommandKind, such as SINEW_COMMAND_KIND_STROKE",
        )
    })
}

/// A count that is no count of anything is not read to its end.
pub(crate) fn fits(count: usize) -> Result<(), Failure> {
    if count > MAX_CHANNELS { Err(Error::Channels { found: count }.into()) } else { Ok(()) }
}

/// Setpoints as C gives them.
pub(crate) fn all_of(wanted: &[Wanted]) -> Result<Vec<ipc::Wanted>, Failure> {
    let one = |&Wanted { channel, kind, value }: &Wanted| Ok(ipc::Wanted { channel, kind: kind_of(kind)?, value });
    wanted.iter().map(one).collect()
}

/// Any command to a channel by name.
///
/// # Safety
/// `channel` is null or text, `taken` null or room for it.
unsafe fn set(
    client: *const Client,
    channel: *const c_char,
    kind: impl FnOnce() -> Result<CommandKind, Failure>,
    value: f64,
    hold_s: f64,
    taken: *mut Taken,
) -> Status {
    border(|| {
        // SAFETY: the caller's word.
        let (channel, place) = unsafe { (text(channel, "channel")?, Place::if_any(taken, "taken")?) };
        let reply = client_of(client)?.set(channel, kind()?, value, hold(hold_s)?)?;
        place.inspect(|place| place.put(reply.into()));
        Ok(Status::SINEW_OK)
    })
}

/// A command to the driver as a whole.
fn ask(client: *const Client, ask: impl FnOnce(&ipc::Client) -> Result<ipc::Reply, ipc::Error>) -> Status {
    border(|| {
        ask(&*client_of(client)?)?;
        Ok(Status::SINEW_OK)
    })
}

/// Holds a wire length, m, for `hold_s` unless renewed; 0 takes the channel's own default. Comes back once the driver has taken the command.
/// Send setpoints several times per lease: when a lease ends, its wire goes off.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_set_length(
    client: *const Client,
    channel: *const c_char,
    length_m: f64,
    hold_s: f64,
) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || Ok(CommandKind::Length), length_m, hold_s, std::ptr::null_mut()) }
}

/// Holds a share of the stroke, 0 (cold) to 1 (hot), like `sinew_set_length`.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_set_stroke(
    client: *const Client,
    channel: *const c_char,
    stroke: f64,
    hold_s: f64,
) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || Ok(CommandKind::Stroke), stroke, hold_s, std::ptr::null_mut()) }
}

/// Gives a duty, 0 to 1, without control, like `sinew_set_length`.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_set_duty(
    client: *const Client,
    channel: *const c_char,
    duty: f64,
    hold_s: f64,
) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || Ok(CommandKind::Duty), duty, hold_s, std::ptr::null_mut()) }
}

/// Holds a tension, N, like `sinew_set_length`.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_set_force(
    client: *const Client,
    channel: *const c_char,
    force_n: f64,
    hold_s: f64,
) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || Ok(CommandKind::Force), force_n, hold_s, std::ptr::null_mut()) }
}

/// Any command of `SinewCommandKind` to a channel by name. `taken`, which may be null, gets the cycle and the lease.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_set(
    client: *const Client,
    channel: *const c_char,
    kind: u32,
    value: f64,
    hold_s: f64,
    taken: *mut Taken,
) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || kind_of(kind), value, hold_s, taken) }
}

/// Setpoints for several channels in one request: all of them are in force from the same cycle on, or none is, and `sinew_refusal` has each
/// refused channel's own reason. They hold for `hold_s` unless renewed; 0 takes the shortest of the channels' defaults. An off among
/// setpoints holds until the next command. `taken`, which may be null, gets the cycle and the lease.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_set_many(
    client: *const Client,
    wanted: *const Wanted,
    count: usize,
    hold_s: f64,
    taken: *mut Taken,
) -> Status {
    border(|| {
        fits(count)?;
        // SAFETY: so many values, and room or null.
        let (wanted, place) = unsafe { (values(wanted, count, "wanted")?, Place::if_any(taken, "taken")?) };
        let client = client_of(client)?;
        let answer = client.set_many(&all_of(wanted)?, hold(hold_s)?)?;
        place.inspect(|place| place.put(answer.into()));
        Ok(Status::SINEW_OK)
    })
}

/// Has these channels to itself: setpoints and resets of other clients are refused with this process's id, until it lets go of them or `hold_s`
/// has passed without a word of it (0: the channels' default lease). Off and stop stay open to everybody. All of them or none; a
/// higher priority, 0 to 9, takes a channel over. `taken`, which may be null, gets the lease.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_claim(
    client: *const Client,
    channels: *const u32,
    count: usize,
    priority: u32,
    hold_s: f64,
    taken: *mut Taken,
) -> Status {
    border(|| {
        fits(count)?;
        // SAFETY: so many values, and room or null.
        let (channels, place) = unsafe { (values(channels, count, "channels")?, Place::if_any(taken, "taken")?) };
        let answer = client_of(client)?.claim(channels, priority, hold(hold_s)?)?;
        place.inspect(|place| place.put(answer.into()));
        Ok(Status::SINEW_OK)
    })
}

/// Lets go of these channels; one that this client has not claimed stays as it is.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_release(client: *const Client, channels: *const u32, count: usize) -> Status {
    border(|| {
        fits(count)?;
        // SAFETY: so many values.
        let channels = unsafe { values(channels, count, "channels")? };
        client_of(client)?.release(channels)?;
        Ok(Status::SINEW_OK)
    })
}

/// Only the sensing pulse from now on.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_off(client: *const Client, channel: *const c_char) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || Ok(CommandKind::Off), 0.0, 0.0, std::ptr::null_mut()) }
}

/// Only the sensing pulse on every channel from now on.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_all_off(client: *const Client) -> Status {
    ask(client, ipc::Client::all_off)
}

/// Clears a latched fault whose cause has gone.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_reset(client: *const Client, channel: *const c_char) -> Status {
    // SAFETY: the same pointers, handed on.
    unsafe { set(client, channel, || Ok(CommandKind::Reset), 0.0, 0.0, std::ptr::null_mut()) }
}

/// Stops the driver: outputs to zero, then it ends.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_stop(client: *const Client) -> Status {
    ask(client, ipc::Client::stop)
}
