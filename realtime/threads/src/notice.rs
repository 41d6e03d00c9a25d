//! The notice of a death: what a thread that panics reports comes after what has to be done about it, not before.
//!
//! A panic is reported by the process's hook before the thread unwinds: a backtrace takes 100 ms to look up, and an unread standard
//! error blocks for ever. On a thread of sinew's the hook does what has to be done at once, and stores the message; the code that
//! catches the panic reports it.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::sync::Once;

/// What is done in the hook, before the thread unwinds.
pub(crate) type AtOnce = Box<dyn FnOnce()>;

#[derive(Default)]
struct Notice {
    words: String,
    at_once: Option<AtOnce>,
}

thread_local! {
    /// Of a panic of this thread; `None` on a thread whose panics are reported by the hook that was there before.
    static NOTICE: RefCell<Option<Notice>> = const { RefCell::new(None) };
}

/// As [`catch_unwind`], with nothing printed on the way.
///
/// # Errors
/// The message of a panic, with its place.
pub fn caught<T>(body: impl FnOnce() -> T) -> Result<T, String> {
    caught_with(None, body)
}

/// The same; a panic does this before anything is unwound.
pub(crate) fn caught_with<T>(at_once: Option<AtOnce>, body: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !is_noted(info) {
                before(info);
            }
        }));
    });
    let notice = Some(Notice { words: String::new(), at_once });
    let outer = NOTICE.with_borrow_mut(|place| std::mem::replace(place, notice));
    let result = catch_unwind(AssertUnwindSafe(body));
    let notice = NOTICE.with_borrow_mut(|place| std::mem::replace(place, outer)).unwrap_or_default();
    result.map_err(|payload: Box<dyn Any + Send>| {
        // Dropping what was thrown may run anybody's code.
        std::mem::forget(payload);
        notice.words
    })
}

fn is_noted(info: &PanicHookInfo) -> bool {
    // A panic inside of this very borrow, or while the thread ends, is reported as everywhere else.
    let taken = NOTICE.try_with(|notice| match notice.try_borrow_mut().as_deref_mut() {
        Ok(Some(notice)) => {
            notice.words = info.to_string();
            Some(notice.at_once.take())
        }
        _ => None,
    });
    match taken {
        Ok(Some(at_once)) => {
            at_once.into_iter().for_each(|act| act());
            true
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::rc::Rc;

    #[test]
    fn the_words_come_with_the_place_and_only_to_who_caught_them() {
        assert_eq!(caught(|| 3), Ok(3));
        let notice = caught(|| panic!("the script says: {}", "panic")).unwrap_err();
        assert!(notice.contains("the script says: panic") && notice.contains("notice.rs"), "{notice}");
        // Afterwards this thread is as before.
        assert!(catch_unwind(|| panic!("reported by the hook that was there")).is_err());
        assert_eq!(caught(|| 4), Ok(4));
    }

    #[test]
    fn what_is_to_be_done_is_done_before_anything_is_unwound_and_only_for_a_panic_that_gets_so_far() {
        struct Unwound(Rc<Cell<u32>>, Rc<Cell<u32>>);
        impl Drop for Unwound {
            fn drop(&mut self) {
                self.1.set(self.0.get());
            }
        }
        let (done, seen) = (Rc::new(Cell::new(0)), Rc::new(Cell::new(9)));
        let counts = done.clone();
        let act: AtOnce = Box::new(move || counts.set(counts.get() + 1));
        let inner = caught_with(Some(act), || {
            let _unwound = Unwound(done.clone(), seen.clone());
            assert!(caught(|| panic!("which goes no further")).is_err());
            assert_eq!(done.get(), 0);
            panic!("and one that does");
        });
        assert!(inner.unwrap_err().contains("and one that does"));
        assert_eq!((done.get(), seen.get()), (1, 1));
    }
}
