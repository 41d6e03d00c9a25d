//! Connect, close, and what does not change while the driver runs.

use crate::border::{Failure, border};
use crate::handles::Handles;
use crate::pointers::{Place, Places, patience, text};
use crate::status::Status;
use crate::structs::{ChannelInfo, Client, Info, NAME_SIZE, name};
use sinew_ipc::{self as ipc, ClientOptions, PROTOCOL};
use std::ffi::c_char;
use std::sync::Arc;

const ABI: u32 = match u32::from_str_radix(env!("SINEW_ABI"), 10) {
    Ok(abi) => abi,
    Err(_) => panic!("build.rs writes a number"),
};
// Structs of C are those of the messages: another protocol is another layout.
const _: () = assert!(PROTOCOL == 7 && ABI == 3, "raise ABI in build.rs with the protocol, and both numbers here");

static CLIENTS: Handles<ipc::Client> = Handles::of("client");

/// The client a handle is for.
pub(crate) fn client_of(client: *const Client) -> Result<Arc<ipc::Client>, Failure> {
    CLIENTS.get(client)
}

/// Version of the calls and structs this library has: `SINEW_ABI` of the header it was built with.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_abi() -> u32 {
    ABI
}

/// Version of the messages this library speaks; a driver of another one is refused by `sinew_connect`.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_protocol() -> u32 {
    PROTOCOL
}

/// Connects to the driver of this rig: the own user's, or another user's through its gateway. `*client` is null unless this comes to
/// `SINEW_OK`. Waits up to 2 s for a driver that is just starting, and later up to 1 s for the answer to a command.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_connect(rig: *const c_char, client: *mut *mut Client) -> Status {
    let ClientOptions { connect, answer } = ClientOptions::default();
    // SAFETY: the same pointers, handed on.
    unsafe { sinew_connect_with(rig, connect.as_secs_f64(), answer.as_secs_f64(), client) }
}

/// Connects with patience of one's own: for a driver that is just starting, and for the answer to a command, s.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_connect_with(
    rig: *const c_char,
    connect_s: f64,
    answer_s: f64,
    client: *mut *mut Client,
) -> Status {
    border(|| {
        // SAFETY: room for a pointer.
        let place = unsafe { Place::at(client, "client") }?;
        place.put(std::ptr::null_mut());
        // SAFETY: text.
        let rig = unsafe { text(rig, "rig") }?;
        let options =
            ClientOptions { connect: patience(connect_s, "connect_s")?, answer: patience(answer_s, "answer_s")? };
        place.put(CLIENTS.open(ipc::Client::connect_with(rig, options)?));
        Ok(Status::SINEW_OK)
    })
}

/// Closes a client. Setpoints it has given hold until their leases end; `sinew_all_off` ends them at once. Streams and fault watches that were
/// opened with it stay good, and are closed by calls of their own. Null is fine.
///
/// # Safety
/// None is needed: what is no open client is an error.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_close(client: *mut Client) -> Status {
    border(|| CLIENTS.close(client))
}

/// Names of the rigs a driver is running for, sorted: writes as many as there is room for, and how many there are.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_discover(rigs: *mut [c_char; NAME_SIZE], room: usize, found: *mut usize) -> Status {
    border(|| {
        // SAFETY: room for so many names, and for a number.
        let (places, count) = unsafe { (Places::at(rigs, room, "rigs")?, Place::at(found, "found")?) };
        let running = ipc::Client::discover()?;
        count.put(running.len());
        places.put(running.iter().map(|rig| name(rig)));
        Ok(Status::SINEW_OK)
    })
}

/// What does not change while the driver runs.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_info(client: *const Client, info: *mut Info) -> Status {
    border(|| {
        // SAFETY: room for it.
        let place = unsafe { Place::at(info, "info") }?;
        place.put(Info::of(&*client_of(client)?));
        Ok(Status::SINEW_OK)
    })
}

/// The channels, in the rig's order: writes as many as there is room for (`SINEW_MAX_CHANNELS` is always enough), and how many there are.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_channels(
    client: *const Client,
    channels: *mut ChannelInfo,
    room: usize,
    found: *mut usize,
) -> Status {
    border(|| {
        // SAFETY: room for so many, and for a number.
        let (places, count) = unsafe { (Places::at(channels, room, "channels")?, Place::at(found, "found")?) };
        let client = client_of(client)?;
        count.put(client.channels().len());
        places.put(client.channels().iter().map(ChannelInfo::from));
        Ok(Status::SINEW_OK)
    })
}

/// The number of the channel with this name; a mistyped one is told which was meant.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_channel(client: *const Client, channel: *const c_char, number: *mut u32) -> Status {
    border(|| {
        // SAFETY: text, and room for a number.
        let (channel, place) = unsafe { (text(channel, "channel")?, Place::at(number, "number")?) };
        place.put(client_of(client)?.channel(channel)? as u32);
        Ok(Status::SINEW_OK)
    })
}

/// The text of the rig file as the driver read it: as many bytes as there is room for, the last of them a zero, and how many the whole needs
/// with its zero. 0 where the driver left none.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_rig_text(
    client: *const Client,
    text: *mut c_char,
    room: usize,
    needed: *mut usize,
) -> Status {
    border(|| {
        // SAFETY: room for so many bytes, and for a number.
        let (places, count) = unsafe { (Places::at(text, room, "text")?, Place::at(needed, "needed")?) };
        let whole = client_of(client)?.rig_text()?;
        let bytes = whole.as_ref().map_or(&[][..], |whole| whole.as_bytes());
        count.put(if whole.is_some() { bytes.len() + 1 } else { 0 });
        let shown = bytes.iter().take(room.saturating_sub(1));
        places.put(shown.map(|&byte| byte as c_char).chain([0]));
        Ok(Status::SINEW_OK)
    })
}
