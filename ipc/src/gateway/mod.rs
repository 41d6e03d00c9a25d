//! How other users reach a driver: a door with a porter, and a board behind glass.
//!
//! What iceoryx2 keeps is the driver's user's alone (mode 0600), because whoever may map it may also write to it. Others
//! come by the gate, which exists only where the rig file has `[access]`:
//!
//! - the **door** is a Unix socket `RIG.sock` in the gate's folder ([`gate_dir`]). The kernel says who knocks (user, groups); the
//!   [`Access`] of the rig decides what he may do;
//! - the **board** is shared memory with the latest state and the last two seconds of cycles. It is sealed before it is handed
//!   out: the kernel refuses every way of writing to it but the driver's own mapping;
//! - **commands** travel over the socket, each a message of fixed size, and are judged at the same desk as everybody's.
//!
//! A visitor costs the driver one descriptor and one entry of a `poll`. There is no thread for him, nothing waits for him, and
//! who sends rubbish or does not read his answers is shown out.
//!
//! The loop knows nothing of this: the board is written by the publisher's thread, the porter stands at the desk's.

mod access;
mod board;
mod connection;
mod endpoint;
#[doc(hidden)]
pub mod fuzzing;
mod listener;
mod messages;
mod pages;
mod peer;

pub use access::{Access, Readers, Role};
pub use endpoint::{Doorway, gate_dir, survey};

pub(crate) use board::{Board, Follower};
pub(crate) use connection::Visit;
pub(crate) use endpoint::{Door, open_doors};
pub(crate) use listener::{Answer, Porter};

/// Visitors at once, of all users.
#[doc(hidden)]
pub const MAX_VISITORS: usize = 384;
/// Visitors at once of one user, so that nobody can keep the others out.
#[doc(hidden)]
pub const MAX_VISITORS_OF_A_USER: usize = 256;
