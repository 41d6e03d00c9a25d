//! Who is connected, and every refusal, counted.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Add;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::Serialize;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::limits::Limits;

/// What a server refuses, and what it is counted as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "ALL says what each is")]
pub enum Refusal {
    ConnectionsAtOnce,
    ConnectionsASecond,
    StalledConnections,
    ForeignHosts,
    ForeignOrigins,
    ClientsAtOnce,
    BytesASecond,
    MessagesASecond,
    OddMessages,
    SlowClients,
    WrongTokens,
    CommandsWithoutToken,
    RequestsUnanswered,
    WrongPins,
    PinsASecond,
}

impl Refusal {
    /// Each of them, in the order above: its name in figures, and one in words.
    const ALL: [(Refusal, &str, &str); 15] = [
        (Refusal::ConnectionsAtOnce, "connections_at_once", "too many connections are open"),
        (Refusal::ConnectionsASecond, "connections_a_second", "too many connections a second"),
        (Refusal::StalledConnections, "stalled_connections", "a request that took too long"),
        (Refusal::ForeignHosts, "foreign_hosts", "a request for another host"),
        (Refusal::ForeignOrigins, "foreign_origins", "a page of another origin"),
        (Refusal::ClientsAtOnce, "clients_at_once", "too many clients are connected"),
        (Refusal::BytesASecond, "bytes_a_second", "too many bytes a second"),
        (Refusal::MessagesASecond, "messages_a_second", "too many messages a second"),
        (Refusal::OddMessages, "odd_messages", "a message that is too long, or none that a client of this kind sends"),
        (Refusal::SlowClients, "slow_clients", "a client that does not fetch what it is sent"),
        (Refusal::WrongTokens, "wrong_tokens", "a wrong token"),
        (Refusal::CommandsWithoutToken, "commands_without_token", "a command of a page that may only watch"),
        (Refusal::RequestsUnanswered, "requests_unanswered", "too many requests without an answer yet"),
        (Refusal::WrongPins, "wrong_pins", "a wrong PIN"),
        (Refusal::PinsASecond, "pins_a_second", "a PIN before the pause after wrong ones was over"),
    ];

    /// In words.
    pub fn words(self) -> &'static str {
        Refusal::ALL[self as usize].2
    }
}

/// Who is connected to a server, and what it has refused.
#[derive(Debug)]
pub struct Traffic {
    limits: Limits,
    connections: Arc<Semaphore>,
    clients: Arc<Semaphore>,
    connected: AtomicU64,
    opened: AtomicU64,
    refused: [AtomicU64; Refusal::ALL.len()],
}

/// Figures of a server's traffic, at one moment.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Figures {
    /// Connections accepted since the server was opened.
    pub connections: u64,
    /// Of these, open now.
    pub connections_open: usize,
    /// Live clients since then; one that connects anew counts again.
    pub clients: u64,
    /// Of these, open now.
    pub clients_open: usize,
    /// What was refused since the server was opened: how often, by its name; docs/scope.md explains each.
    pub refused: BTreeMap<&'static str, u64>,
    /// All of that together.
    pub refused_in_all: u64,
}

impl Traffic {
    /// None yet.
    pub fn new(limits: Limits) -> Traffic {
        Traffic {
            connections: Arc::new(Semaphore::new(limits.connections)),
            clients: Arc::new(Semaphore::new(limits.clients)),
            connected: AtomicU64::new(0),
            opened: AtomicU64::new(0),
            refused: [const { AtomicU64::new(0) }; Refusal::ALL.len()],
            limits,
        }
    }

    /// What is allowed.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// A connection's place, until it is dropped; none where all are taken, which is counted.
    pub fn connect(&self) -> Option<OwnedSemaphorePermit> {
        self.place(&self.connections, &self.connected, Refusal::ConnectionsAtOnce)
    }

    /// A live client's place, until it is dropped; none where all are taken, which is counted.
    pub fn open_client(&self) -> Option<OwnedSemaphorePermit> {
        self.place(&self.clients, &self.opened, Refusal::ClientsAtOnce)
    }

    fn place(&self, places: &Arc<Semaphore>, taken: &AtomicU64, none: Refusal) -> Option<OwnedSemaphorePermit> {
        let place = places.clone().try_acquire_owned().ok();
        if place.is_some() {
            taken.fetch_add(1, Ordering::Relaxed);
        } else {
            self.refuse(none);
        }
        place
    }

    /// Counts a refusal.
    pub fn refuse(&self, what: Refusal) {
        self.refused[what as usize].fetch_add(1, Ordering::Relaxed);
    }

    /// How it is now.
    pub fn figures(&self) -> Figures {
        let counts = self.refused.each_ref().map(|count| count.load(Ordering::Relaxed));
        Figures {
            connections: self.connected.load(Ordering::Relaxed),
            connections_open: self.limits.connections - self.connections.available_permits(),
            clients: self.opened.load(Ordering::Relaxed),
            clients_open: self.limits.clients - self.clients.available_permits(),
            refused: Refusal::ALL.iter().zip(counts).map(|((_, name, _), count)| (*name, count)).collect(),
            refused_in_all: counts.iter().sum(),
        }
    }
}

/// Those of two ports together.
impl Add for Figures {
    type Output = Figures;

    fn add(mut self, other: Figures) -> Figures {
        for (name, count) in other.refused {
            *self.refused.entry(name).or_default() += count;
        }
        Figures {
            connections: self.connections + other.connections,
            connections_open: self.connections_open + other.connections_open,
            clients: self.clients + other.clients,
            clients_open: self.clients_open + other.clients_open,
            refused: self.refused,
            refused_in_all: self.refused_in_all + other.refused_in_all,
        }
    }
}

/// One line for the end of a run.
impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "clients served: {} (connections: {}); ", self.clients, self.connections)?;
        if self.refused_in_all == 0 {
            return write!(f, "nothing refused");
        }
        write!(f, "refused: {}", self.refused_in_all)?;
        let kinds = Refusal::ALL.iter().filter_map(|(_, name, words)| Some((self.refused.get(name)?, words)));
        for (i, (count, words)) in kinds.filter(|(count, _)| **count > 0).enumerate() {
            write!(f, "{} {count} × {words}", if i == 0 { " –" } else { "," })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_refusal_has_its_own_row() {
        let traffic = Traffic::new(Limits::default());
        for (place, (refusal, name, words)) in Refusal::ALL.into_iter().enumerate() {
            assert_eq!((refusal as usize, refusal.words()), (place, words));
            traffic.refuse(refusal);
            let figures = traffic.figures();
            assert_eq!((figures.refused[name], figures.refused_in_all), (1, place as u64 + 1));
            assert!(figures.to_string().contains(&format!("1 × {words}")), "{figures}");
        }
        assert_eq!(traffic.figures().refused.len(), Refusal::ALL.len(), "no two of one name");
    }

    #[test]
    fn figures_of_two_ports_add_up() {
        let [one, other] = [(); 2].map(|()| Traffic::new(Limits::default()));
        let _places = [one.connect(), other.connect(), other.connect(), other.open_client()];
        one.refuse(Refusal::ForeignHosts);
        other.refuse(Refusal::ForeignHosts);
        other.refuse(Refusal::WrongPins);
        let both = one.figures() + other.figures();
        assert_eq!((both.connections, both.connections_open, both.clients, both.clients_open), (3, 3, 1, 1));
        assert_eq!((both.refused["foreign_hosts"], both.refused["wrong_pins"], both.refused_in_all), (2, 1, 3));
    }

    #[test]
    fn places_are_free_again_once_they_are_left() {
        let traffic = Traffic::new(Limits { connections: 2, clients: 1, ..Limits::default() });
        assert_eq!(traffic.figures().to_string(), "clients served: 0 (connections: 0); nothing refused");
        let (one, two) = (traffic.connect(), traffic.connect());
        assert!(one.is_some() && two.is_some() && traffic.connect().is_none());
        drop(one);
        assert!(traffic.connect().is_some());
        let client = traffic.open_client();
        assert!(client.is_some() && traffic.open_client().is_none());
        let figures = traffic.figures();
        assert_eq!(
            (figures.connections, figures.connections_open, figures.clients, figures.clients_open),
            (3, 1, 1, 1)
        );
        assert_eq!(
            figures.to_string(),
            "clients served: 1 (connections: 3); refused: 2 – 1 × too many connections are open, 1 × too many clients are connected"
        );
    }
}
