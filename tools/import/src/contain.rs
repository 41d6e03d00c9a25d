//! Other people's code over damaged files: what panics there is an error here, and says nothing of its own.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether a panic of this thread is contained, and so not told.
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Runs it; `None` where it panicked.
pub(crate) fn contained<T>(run: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let told = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !CONTAINED.get() {
                told(info);
            }
        }));
    });
    CONTAINED.set(true);
    // what it was working on is thrown away with it
    let result = panic::catch_unwind(AssertUnwindSafe(run)).ok();
    CONTAINED.set(false);
    result
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_panic_is_nothing_and_the_next_one_is_told_again() {
        assert_eq!(super::contained(|| 7), Some(7));
        assert_eq!(super::contained(|| -> u8 { panic!("over a damaged file") }), None);
        assert!(std::panic::catch_unwind(|| panic!("of our own")).is_err());
    }
}
