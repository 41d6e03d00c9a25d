//! Open files of a driver: what a full house takes, and asking the system for as many.
//!
//! Many systems start every program with a soft limit of 1024, for the sake of `select(2)`, which nothing here uses; the hard
//! limit, up to which a program may help itself, is far higher.

use crate::gateway::MAX_GATEWAY_CLIENTS;
use crate::service::{MAX_CLIENTS, MAX_STREAMS};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// Of each client of the driver's own user, and of each stream it reads (measured: `as_many_clients_as_promised_and_not_one_more`).
const OF_A_CLIENT: usize = 5;
const OF_A_STREAM: usize = 1;
/// The driver's own: locks, shared memory, log, backend, black box.
const OWN: usize = 128;

/// Descriptors of a driver with all the clients it serves: of its own user and through the gateway.
pub const ALL_CLIENTS: u64 = (OWN + MAX_CLIENTS * OF_A_CLIENT + MAX_STREAMS * OF_A_STREAM + MAX_GATEWAY_CLIENTS) as u64;

/// Lets this process have as many descriptors open as the system allows it (the soft limit becomes the hard one), and says how
/// many that are. Call it before anything is opened. Where it is refused the limit stays what it was.
pub fn raise_limit() -> u64 {
    let limit = getrlimit(Resource::Nofile);
    if limit.current != limit.maximum {
        let _ = setrlimit(Resource::Nofile, Rlimit { current: limit.maximum, maximum: limit.maximum });
    }
    getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX)
}

/// How many descriptors a driver of this user may have: the hard limit.
pub fn allowed() -> u64 {
    getrlimit(Resource::Nofile).maximum.unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_raised_as_far_as_it_goes() {
        assert_eq!(raise_limit(), allowed());
        assert_eq!(getrlimit(Resource::Nofile).current, getrlimit(Resource::Nofile).maximum);
        assert!((1500..4096).contains(&ALL_CLIENTS), "{ALL_CLIENTS}");
    }
}
