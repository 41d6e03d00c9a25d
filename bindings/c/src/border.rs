//! The border: every call of C goes through [`border`], and nothing but a code comes back.

use crate::status::Status;
use sinew_ipc::{Error, Refusal};
use std::any::Any;
use std::cell::RefCell;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Why a call failed.
#[derive(Debug)]
pub(crate) struct Failure {
    status: Status,
    message: String,
    remedy: String,
    refusals: Vec<Refusal>,
}

impl Failure {
    pub fn new(status: Status, message: impl Into<String>, remedy: impl Into<String>) -> Failure {
        Failure { status, message: message.into(), remedy: remedy.into(), refusals: Vec::new() }
    }

    /// An argument that no call takes.
    pub fn argument(message: impl Into<String>, remedy: impl Into<String>) -> Failure {
        Failure::new(Status::SINEW_ERROR_ARGUMENT, message, remedy)
    }

    fn panicked(payload: &(dyn Any + Send)) -> Failure {
        let words = payload.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("no words");
        let message = format!("a mistake of the sinew library itself: {words}");
        Failure::new(
            Status::SINEW_ERROR_PANIC,
            message,
            "close everything, connect again, and report it with these words",
        )
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        let status = match &error {
            Error::RigName { .. } => Status::SINEW_ERROR_RIG_NAME,
            Error::NotRunning { .. } => Status::SINEW_ERROR_NOT_RUNNING,
            Error::Starting { .. } => Status::SINEW_ERROR_STARTING,
            Error::DriverGone { .. } => Status::SINEW_ERROR_DRIVER_GONE,
            Error::Protocol { .. } => Status::SINEW_ERROR_PROTOCOL,
            Error::UnknownChannel { .. } => Status::SINEW_ERROR_UNKNOWN_CHANNEL,
            Error::Channels { .. } => Status::SINEW_ERROR_CHANNELS,
            Error::Refused(_) => Status::SINEW_ERROR_REFUSED,
            Error::RefusedTogether(_) => Status::SINEW_ERROR_REFUSED_TOGETHER,
            Error::NoAnswer { .. } => Status::SINEW_ERROR_NO_ANSWER,
            Error::RuntimeDir { .. } => Status::SINEW_ERROR_RUNTIME_DIR,
            Error::Full { .. } => Status::SINEW_ERROR_FULL,
            Error::NotAdmitted { .. } => Status::SINEW_ERROR_NOT_ADMITTED,
            Error::Gateway { .. } => Status::SINEW_ERROR_GATEWAY,
            Error::Service { .. } => Status::SINEW_ERROR_SERVICE,
            // What only a driver meets, and what a later version may add.
            _ => Status::SINEW_ERROR_OTHER,
        };
        let (message, remedy) = (error.message(), error.remedy());
        let refusals = match error {
            Error::Refused(refusal) => vec![refusal],
            Error::RefusedTogether(refusals) => refusals,
            _ => Vec::new(),
        };
        Failure { status, message, remedy, refusals }
    }
}

/// The call of this thread that failed last, in words.
#[derive(Debug, Default)]
pub(crate) struct Last {
    /// Message and remedy.
    pub text: CString,
    /// The remedy alone.
    pub remedy: CString,
    /// What the driver refused, with the words of each.
    pub refusals: Vec<(Refusal, CString, CString)>,
}

thread_local! {
    static LAST: RefCell<Last> = RefCell::default();
}

/// Text for C, which ends at the first zero: there is none in ours.
fn for_c(text: &str) -> CString {
    CString::new(text.replace('\0', "?")).unwrap_or_default()
}

/// Runs what a call does: its code comes back, its words are kept for [`with_last`].
pub(crate) fn border(call: impl FnOnce() -> Result<Status, Failure>) -> Status {
    let failure = match caught(call) {
        Ok(Ok(status)) => return status,
        Ok(Err(failure)) | Err(failure) => failure,
    };
    let status = failure.status;
    let kept = caught(|| {
        let Failure { message, remedy, refusals, .. } = failure;
        let text = if remedy.is_empty() { message } else { format!("{message}; {remedy}") };
        let words = |refusal: Refusal| {
            let (message, remedy) = (for_c(&refusal.message()), for_c(&refusal.remedy()));
            (refusal, message, remedy)
        };
        let refusals = refusals.into_iter().map(words).collect();
        let last = Last { text: for_c(&text), remedy: for_c(&remedy), refusals };
        // A thread that is just ending keeps nothing.
        let _ = LAST.try_with(|place| place.replace(last));
    });
    kept.map_or(Status::SINEW_ERROR_PANIC, |()| status)
}

/// Looks at the words of the call that failed last in this thread; `nothing` where there are none to be had.
pub(crate) fn with_last<T: Copy>(nothing: T, look: impl FnOnce(&Last) -> T) -> T {
    caught(|| LAST.try_with(|last| look(&last.borrow())).unwrap_or(nothing)).unwrap_or(nothing)
}

/// What has no code to give back: `otherwise` should it panic.
pub(crate) fn calm<T: Copy>(otherwise: T, call: impl FnOnce() -> T) -> T {
    caught(call).unwrap_or(otherwise)
}

/// The one place where a panic is held up. What it has interrupted is never used again: handles are taken out of use by
/// the mutex it leaves poisoned, and the client itself survives it.
fn caught<T>(call: impl FnOnce() -> T) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| Failure::panicked(&*payload))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last() -> String {
        LAST.with(|last| last.borrow().text.to_str().unwrap().to_string())
    }

    #[test]
    fn a_panic_becomes_a_code_with_words() {
        for call in [|| panic!("seven {}", 7), || panic!("seven 7"), || std::panic::panic_any(7)] {
            assert_eq!(border(call), Status::SINEW_ERROR_PANIC);
            assert!(last().starts_with("a mistake of the sinew library itself: "), "{}", last());
            assert!(last().contains("; close everything"), "{}", last());
        }
        assert_eq!(border(|| panic!("seven {}", 7)), Status::SINEW_ERROR_PANIC);
        assert!(last().contains("seven 7"), "{}", last());
        assert_eq!(calm(3, || panic!()), 3);
    }

    #[test]
    fn words_stay_until_the_next_failure_of_the_same_thread() {
        assert_eq!(border(|| Err(Failure::argument("first", "do this"))), Status::SINEW_ERROR_ARGUMENT);
        assert_eq!(border(|| Ok(Status::SINEW_OK)), Status::SINEW_OK);
        std::thread::spawn(|| assert_eq!(last(), "")).join().unwrap();
        assert_eq!(last(), "first; do this");
        assert_eq!(with_last(0, |last| last.remedy.as_bytes().len()), 7);
    }

    #[test]
    fn an_error_keeps_its_words_whole() {
        let error = Error::NotRunning { rig: "a\0b".into(), running: vec![] };
        border(|| Err(error.clone().into()));
        assert_eq!(last(), error.to_string().replace('\0', "?"));
    }
}
