//! Faults as they come and go, and their words.

use crate::border::{border, calm};
use crate::connection::client_of;
use crate::handles::{Handles, alone};
use crate::pointers::{Place, patience};
use crate::status::Status;
use crate::structs::{Client, FaultChange, FaultWatch};
use sinew_ipc::{self as ipc, FAULT_TABLE, FaultRow, Mode};
use std::ffi::{CStr, CString, c_char};
use std::sync::{Arc, LazyLock, Mutex};

/// cbindgen:ignore
type Watch = ipc::FaultWatch<Arc<ipc::Client>>;

static WATCHES: Handles<Mutex<Watch>> = Handles::of("fault watch");

/// Fault changes from now on; the first reported are the faults that are there already. Faults stay latched until somebody resets them, so looking
/// now and then misses none but those that are reset in between.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_faults(client: *const Client, faults: *mut *mut FaultWatch) -> Status {
    border(|| {
        // SAFETY: room for a pointer.
        let place = unsafe { Place::at(faults, "faults") }?;
        place.put(std::ptr::null_mut());
        place.put(WATCHES.open(Mutex::new(Watch::new(client_of(client)?))));
        Ok(Status::SINEW_OK)
    })
}

/// The next change, waiting for it up to so long; `SINEW_NOTHING` when none came. When the driver has died each channel changes to
/// `SINEW_FAULT_DRIVER_DIED` once; then, if asked to wait, `SINEW_ERROR_DRIVER_GONE`.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_faults_next(
    faults: *mut FaultWatch,
    timeout_s: f64,
    change: *mut FaultChange,
) -> Status {
    border(|| {
        // SAFETY: room for it.
        let place = unsafe { Place::at(change, "change") }?;
        let timeout = patience(timeout_s, "timeout_s")?;
        let watch = WATCHES.get(faults)?;
        let Some(next) = alone("fault watch", &watch)?.wait(timeout)? else { return Ok(Status::SINEW_NOTHING) };
        place.put((&next).into());
        Ok(Status::SINEW_OK)
    })
}

/// Closes a fault watch. Null is fine.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_faults_close(faults: *mut FaultWatch) -> Status {
    border(|| WATCHES.close(faults))
}

/// The words of a fault, each with its zero byte.
struct Words {
    flag: CString,
    cause: CString,
    remedy: CString,
}

fn word(fault: u32, which: fn(&Words) -> &CString) -> *const c_char {
    static WORDS: LazyLock<Vec<Words>> = LazyLock::new(|| {
        let with_zero = |text: &str| CString::new(text).unwrap_or_default();
        let words = |row: &FaultRow| Words {
            flag: with_zero(row.flag),
            cause: with_zero(row.cause),
            remedy: with_zero(row.remedy),
        };
        FAULT_TABLE.iter().map(words).collect()
    });
    calm(c"".as_ptr(), || {
        let row = (fault as usize).checked_sub(1).and_then(|place| WORDS.get(place));
        row.map_or(c"".as_ptr(), |words| which(words).as_ptr())
    })
}

/// The short name of a fault in reports; empty for 0 and for what this version does not know. The text stays.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_fault_flag(fault: u32) -> *const c_char {
    word(fault, |words| &words.flag)
}

/// What happened, as the end of "the channel is off because …"; empty as for `sinew_fault_flag`.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_fault_cause(fault: u32) -> *const c_char {
    word(fault, |words| &words.cause)
}

/// What a person can do about it; empty as for `sinew_fault_flag`.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_fault_remedy(fault: u32) -> *const c_char {
    word(fault, |words| &words.remedy)
}

/// The name of what a channel is doing, a `SinewMode`; empty for what this version does not know. The text stays.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_mode_name(mode: u32) -> *const c_char {
    let name: &CStr = match Mode::from_code(mode) {
        Some(Mode::Waiting) => c"waiting",
        Some(Mode::Off) => c"off",
        Some(Mode::Length) => c"length",
        Some(Mode::Duty) => c"duty",
        Some(Mode::Force) => c"force",
        Some(Mode::Program) => c"program",
        Some(Mode::Fault) => c"fault",
        Some(Mode::Lapsed) => c"lapsed",
        None => c"",
    };
    name.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(at: *const c_char) -> &'static str {
        // SAFETY: every one of these calls gives text that stays.
        unsafe { CStr::from_ptr(at) }.to_str().unwrap()
    }

    #[test]
    fn every_fault_and_mode_has_its_words_and_nothing_else_has() {
        for row in &FAULT_TABLE {
            let code = row.fault.code();
            let words = [sinew_fault_flag(code), sinew_fault_cause(code), sinew_fault_remedy(code)].map(text);
            assert_eq!(words, [row.flag, row.cause, row.remedy]);
        }
        for code in 0..64 {
            assert_eq!(text(sinew_mode_name(code)), Mode::from_code(code).map_or("", Mode::name));
        }
        for code in [0, FAULT_TABLE.len() as u32 + 1, u32::MAX] {
            assert_eq!(text(sinew_fault_flag(code)), "");
        }
        assert_eq!(text(sinew_mode_name(u32::MAX)), "");
    }
}
