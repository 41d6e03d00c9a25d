//! The ways in: over loopback, where every user of this machine may watch, and over the network, where nobody may who has not had the
//! PIN.

use std::net::IpAddr;
use std::sync::Arc;

use sinew_server::Traffic;

use crate::access::AccessControl;
use crate::lock::{Lock, Pin};

/// One of them. Each has places of its own: whoever floods the network's takes none on loopback.
pub struct Entrance {
    pub access: AccessControl,
    pub traffic: Arc<Traffic>,
    /// On the network: what has to be opened first.
    pub lock: Option<Lock>,
}

/// What happens on the network that somebody at the terminal wants to know.
#[derive(Debug)]
pub enum Event {
    /// A page had the right PIN.
    Entered {
        /// Where it is.
        from: Option<IpAddr>,
    },
    /// Ten PINs were wrong, and there is another one.
    Renewed {
        /// The one that is right now, `4821 7735`.
        pin: String,
        /// Where the last wrong one came from.
        from: Option<IpAddr>,
    },
}

impl Event {
    pub(crate) fn renewed(pin: &Pin, from: Option<IpAddr>) -> Event {
        Event::Renewed { pin: pin.spaced(), from }
    }
}

/// What those on the network need to come in.
#[derive(Debug)]
pub struct Invitation {
    /// Addresses to be opened in a browser, those by number first.
    pub urls: Vec<String>,
    /// The PIN to be typed there, `4821 7735`.
    pub pin: String,
    /// The certificate's SHA-256, to be compared with what the browser shows, `3A:F0:…`.
    pub fingerprint: String,
    /// Whether the certificate is a new one, so that every browser warns.
    pub is_new: bool,
}
