//! The words of the call that failed last, each thread its own.

use crate::border::{Failure, border, with_last};
use crate::pointers::Place;
use crate::status::Status;
use crate::structs::Refusal;
use std::ffi::c_char;

/// What went wrong in the call of this thread that failed last, and after a semicolon what to do about it; empty before the first.
/// Valid until the next call of this thread that fails.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_last_error() -> *const c_char {
    with_last(c"".as_ptr(), |last| last.text.as_ptr())
}

/// What to do about it, alone; empty where the error says all there is. Valid as long.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_last_remedy() -> *const c_char {
    with_last(c"".as_ptr(), |last| last.remedy.as_ptr())
}

/// How many commands the driver refused in the call of this thread that failed last: 0 unless that was
/// `SINEW_ERROR_REFUSED` or `SINEW_ERROR_REFUSED_TOGETHER`.
#[unsafe(no_mangle)]
pub extern "C" fn sinew_refusals() -> usize {
    with_last(0, |last| last.refusals.len())
}

/// One of them, from 0.
///
/// # Safety
/// As `sinew.h` says of pointers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn sinew_refusal(index: usize, refusal: *mut Refusal) -> Status {
    border(|| {
        // SAFETY: room for it.
        let place = unsafe { Place::at(refusal, "refusal") }?;
        let found = with_last(None, |last| {
            let (refusal, message, remedy) = last.refusals.get(index)?;
            Some(Refusal::of(refusal, message.as_ptr(), remedy.as_ptr()))
        });
        let found = found.ok_or_else(|| {
            Failure::argument(format!("there is no refusal {index}"), "ask sinew_refusals how many there are")
        })?;
        place.put(found);
        Ok(Status::SINEW_OK)
    })
}
