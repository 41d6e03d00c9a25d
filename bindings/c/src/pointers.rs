//! What C hands over: looked at before it is used. Everything here is unsafe for one reason: that a pointer which is neither null nor
//! misaligned leads to what the header says cannot be seen from here; that is C's part of the contract. And what else is asked of libc.

use crate::border::Failure;
use std::ffi::{CStr, c_char};
use std::time::Duration;

/// Longest text that is read, bytes: no name is longer, and text without an end is not followed beyond it.
const LONGEST: usize = 255;
/// The longest wait; `INFINITY` means this.
const FOR_EVER: Duration = Duration::from_secs(1 << 32);

/// A place of C's to write to.
pub(crate) struct Place<T>(*mut T);

impl<T: Copy> Place<T> {
    /// # Safety
    /// `at` is null, or leads to room for a `T` until the place is dropped.
    pub unsafe fn at(at: *mut T, what: &str) -> Result<Place<T>, Failure> {
        usable(at, what)?;
        Ok(Place(at))
    }

    /// The same, for what may be left out.
    ///
    /// # Safety
    /// As [`Place::at`].
    pub unsafe fn if_any(at: *mut T, what: &str) -> Result<Option<Place<T>>, Failure> {
        if at.is_null() {
            return Ok(None);
        }
        // SAFETY: the caller's word, handed on.
        unsafe { Place::at(at, what) }.map(Some)
    }

    pub fn put(&self, value: T) {
        // SAFETY: room for a `T` was promised when the place was made.
        unsafe { self.0.write(value) }
    }

    pub fn pointer(&self) -> *mut T {
        self.0
    }
}

/// A row of places of C's.
pub(crate) struct Places<T>(*mut T, usize);

impl<T: Copy> Places<T> {
    /// Null is good for a row without room.
    ///
    /// # Safety
    /// `at` is null, or leads to room for so many until the places are dropped.
    pub unsafe fn at(at: *mut T, room: usize, what: &str) -> Result<Places<T>, Failure> {
        if room > 0 {
            usable(at, what)?;
        }
        Ok(Places(at, room))
    }

    /// As many as there is room for.
    pub fn put(&self, values: impl Iterator<Item = T>) {
        for (place, value) in values.take(self.1).enumerate() {
            // SAFETY: below the room that was promised when the places were made.
            unsafe { self.0.add(place).write(value) }
        }
    }
}

/// So many of C's values.
///
/// # Safety
/// `at` is null, or leads to so many valid values (which fit into memory), which nobody changes while they are looked at.
pub(crate) unsafe fn values<'a, T: Copy>(at: *const T, count: usize, what: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    usable(at, what)?;
    // SAFETY: not null and aligned; the rest is the caller's word.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// C's text.
///
/// # Safety
/// `at` is null, or leads to text that ends with a zero byte, or to more than 255 bytes.
pub(crate) unsafe fn text<'a>(at: *const c_char, what: &str) -> Result<&'a str, Failure> {
    usable(at, what)?;
    // SAFETY: not beyond the first zero byte or the 255th other one.
    let length = (0..=LONGEST).find(|&place| unsafe { at.add(place).read() } == 0);
    let Some(length) = length else {
        let remedy = "give a name that ends with a zero byte; channels have at most 64 bytes, rigs 48";
        return Err(Failure::argument(format!("{what} has no end within {LONGEST} bytes"), remedy));
    };
    // SAFETY: so many bytes and the zero after them have just been read.
    let bytes = unsafe { std::slice::from_raw_parts(at.cast(), length + 1) };
    let text = CStr::from_bytes_with_nul(bytes).ok().and_then(|text| text.to_str().ok());
    text.ok_or_else(|| Failure::argument(format!("{what} is no UTF-8"), "write it as it stands in the rig file"))
}

fn usable<T>(at: *const T, what: &str) -> Result<(), Failure> {
    if at.is_null() {
        return Err(Failure::argument(format!("{what} is null"), format!("hand over the address of {what}")));
    }
    if !at.is_aligned() {
        let remedy = format!("hand over the address of a variable of the type of {what}");
        return Err(Failure::argument(format!("{what} is at an odd address"), remedy));
    }
    Ok(())
}

/// How long to wait.
pub(crate) fn patience(seconds: f64, what: &str) -> Result<Duration, Failure> {
    match seconds > FOR_EVER.as_secs_f64() {
        true => Ok(FOR_EVER),
        false => time(seconds, what, "0 does not wait, INFINITY waits for ever"),
    }
}

/// For how long a setpoint is asked to hold. Which times are taken is judged by the driver.
pub(crate) fn hold(seconds: f64) -> Result<Duration, Failure> {
    time(seconds, "hold_s", "give seconds; 0 takes the channel's default")
}

fn time(seconds: f64, what: &str, remedy: &str) -> Result<Duration, Failure> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|_| Failure::argument(format!("{what} = {seconds} is no time"), remedy))
}

/// Has this called in every process that is forked from here on.
pub(crate) fn after_fork(call: extern "C" fn()) {
    // SAFETY: `call` is there for as long as the program; it is only remembered. It can fail for want of memory alone.
    unsafe { libc::pthread_atfork(None, None, Some(call)) };
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::null;

    #[test]
    fn text_is_read_to_its_end_and_no_further_than_names_go() {
        let long = [b'x'; LONGEST + 1];
        let mut just = [b'x'; LONGEST + 1];
        just[LONGEST] = 0;
        // SAFETY: text with an end, and more than 255 bytes.
        unsafe {
            assert_eq!(text(c"left".as_ptr(), "channel").unwrap(), "left");
            assert_eq!(text(c"".as_ptr(), "channel").unwrap(), "");
            assert_eq!(text(just.as_ptr().cast(), "channel").unwrap().len(), LONGEST);
            assert!(text(long.as_ptr().cast(), "channel").is_err());
            assert!(text(c"\xff".as_ptr(), "channel").is_err());
            assert!(text(null(), "channel").is_err());
        }
    }

    #[test]
    fn times_that_are_none_are_refused() {
        for none in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            assert!(patience(none, "timeout_s").is_err() && hold(none).is_err(), "{none}");
        }
        assert_eq!(patience(f64::INFINITY, "timeout_s").unwrap(), FOR_EVER);
        assert!(std::time::Instant::now().checked_add(FOR_EVER).is_some(), "the client adds it to now");
        assert!(hold(f64::INFINITY).is_err());
        assert_eq!(hold(0.5).unwrap(), Duration::from_millis(500));
    }
}
