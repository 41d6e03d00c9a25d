//! The shutdown notice: what a thread that panics reports comes after the outputs are zero, not before.
//!
//! A panic is reported by the process's hook before the thread unwinds: a backtrace takes 100 ms to look up, and an unread standard
//! error blocks for ever. On a thread of the driver the hook only stores the message; the code that catches the panic switches off
//! and then reports it.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::Once;

thread_local! {
    /// The message of a panic of this thread; `None` on a thread whose panics are reported at once.
    static NOTICE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// As [`catch_unwind`], with nothing printed on the way.
///
/// # Errors
/// The message of a panic, with its place.
pub(crate) fn caught<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !is_noted(info) {
                before(info);
            }
        }));
    });
    NOTICE.with_borrow_mut(|notice| *notice = Some(String::new()));
    let result = catch_unwind(AssertUnwindSafe(body));
    let notice = NOTICE.with_borrow_mut(Option::take).unwrap_or_default();
    result.map_err(|payload: Box<dyn Any + Send>| {
        // Dropping what was thrown may run anybody's code.
        std::mem::forget(payload);
        notice
    })
}

fn is_noted(info: &PanicHookInfo) -> bool {
    // A panic inside of this very borrow, or while the thread ends, is reported as everywhere else.
    NOTICE
        .try_with(|notice| match notice.try_borrow_mut().as_deref_mut() {
            Ok(Some(notice)) => {
                *notice = info.to_string();
                true
            }
            _ => false,
        })
        .unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_come_with_the_place_and_only_to_who_caught_them() {
        assert_eq!(caught(|| 3), Ok(3));
        let notice = caught(|| panic!("the script says: {}", "panic")).unwrap_err();
        assert!(notice.contains("the script says: panic") && notice.contains("shutdown_notice.rs"), "{notice}");
        // Afterwards this thread is as before.
        assert!(catch_unwind(|| panic!("reported by the hook that was there")).is_err());
        assert_eq!(caught(|| 4), Ok(4));
    }
}
