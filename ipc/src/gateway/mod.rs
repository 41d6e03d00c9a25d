//! The gateway: how other users reach a driver.
//!
//! What iceoryx2 keeps is the driver's user's alone (mode 0600), because whoever may map it may also write to it. Others
//! come through the gateway, which exists only where the rig file has `[access]`:
//!
//! - the **endpoint** is a Unix socket `RIG.sock` in the gateway's folder ([`gateway_dir`]). The kernel says who connects (user,
//!   groups); the [`Access`] of the rig decides what he may do;
//! - the **listener** accepts connections, keeps a **session** for each, reads their requests and sends the replies. Requests are
//!   messages of equal parts, at most 64, and are judged by the same thread as everybody's;
//! - the **board** is shared memory with the latest state and the last two seconds of cycles. It is sealed before it is handed
//!   out: the kernel refuses every way of writing to it but the driver's own mapping;
//! - the **connection** is the client's side of all that.
//!
//! A session costs the driver one descriptor and one entry of a `poll`. There is no thread for it, nothing waits for it, and
//! a client that sends anything but requests, or does not read its replies, is disconnected.
//!
//! The loop knows nothing of this: the board is written by the publisher's thread, the listener runs on the command server's.

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
pub use endpoint::{EndpointState, gateway_dir, survey};

pub(crate) use board::{Board, BoardReader};
pub(crate) use connection::Connection;
pub(crate) use endpoint::{Endpoint, open_endpoints};
pub(crate) use listener::{Answer, Listener};

/// Sessions at once, of all users.
#[doc(hidden)]
pub const MAX_GATEWAY_CLIENTS: usize = 384;
/// Sessions at once of one user, so that nobody can keep the others out.
#[doc(hidden)]
pub const MAX_GATEWAY_CLIENTS_OF_A_USER: usize = 256;
