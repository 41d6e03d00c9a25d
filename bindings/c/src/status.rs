//! What a call comes to.

/// cbindgen:rename-all=None
/// What a call comes to. Errors are below zero; `sinew_last_error` has their words.
// Named as C sees them: a program's first lines are full of them.
#[allow(non_camel_case_types, clippy::upper_case_acronyms)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// Done.
    SINEW_OK = 0,
    /// Nothing has come in the time given. No error.
    SINEW_NOTHING = 1,
    /// An argument that no call takes: null, text without an end, a time that is none.
    SINEW_ERROR_ARGUMENT = -1,
    /// What was handed over is not, or not any more, what the call is for: it has been closed, or was never opened.
    SINEW_ERROR_HANDLE = -2,
    /// Another thread is using this stream or fault watch.
    SINEW_ERROR_IN_USE = -3,
    /// A mistake of the library itself. Nothing of it has got out; the words say what to report.
    SINEW_ERROR_PANIC = -4,
    /// An error this table has no code for; its words say all.
    SINEW_ERROR_OTHER = -5,
    /// A rig name outside the allowed characters or too long.
    SINEW_ERROR_RIG_NAME = -6,
    /// No driver for this rig is running.
    SINEW_ERROR_NOT_RUNNING = -7,
    /// A driver holds the rig but has not opened its services in time.
    SINEW_ERROR_STARTING = -8,
    /// The driver this client was connected to is gone: connect again for the next one.
    SINEW_ERROR_DRIVER_GONE = -9,
    /// Driver and library speak different versions of the messages.
    SINEW_ERROR_PROTOCOL = -10,
    /// There is no channel of that name.
    SINEW_ERROR_UNKNOWN_CHANNEL = -11,
    /// No channels, or more than a rig can have.
    SINEW_ERROR_CHANNELS = -12,
    /// The driver refused a command; see `sinew_refusal`.
    SINEW_ERROR_REFUSED = -13,
    /// The driver refused a request for several channels and carried out none of it; see `sinew_refusal`.
    SINEW_ERROR_REFUSED_TOGETHER = -14,
    /// The driver did not answer in time.
    SINEW_ERROR_NO_ANSWER = -15,
    /// The folder for locks and sockets cannot be used.
    SINEW_ERROR_RUNTIME_DIR = -16,
    /// The driver serves no more of something at once.
    SINEW_ERROR_FULL = -17,
    /// The driver is another user's, and lets only others look.
    SINEW_ERROR_NOT_ADMITTED = -18,
    /// The gateway for other users could be anybody's.
    SINEW_ERROR_GATEWAY = -19,
    /// Shared memory could not be opened.
    SINEW_ERROR_SERVICE = -20,
}
