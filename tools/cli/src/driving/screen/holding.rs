//! Channels that are commanded from here: their leases are renewed until they are let go, or somebody else commands them.

use std::time::{Duration, Instant};

use sinew_ipc::Mode;

use super::view::{Row, View};
use crate::driving::live::Live;
use crate::driving::setpoint::Setpoint;

/// Lease of what is held.
const HOLD: Duration = Duration::from_millis(1500);
/// From one renewal to the next.
const RENEW: Duration = Duration::from_millis(400);
/// A command shows in the published state this much later at most.
const SHOWS: Duration = Duration::from_millis(20);
/// An `off` this short lets a channel go: it lapses at once and without fault.
const RELEASE: Duration = Duration::from_millis(50);

/// All that is held from here.
#[derive(Debug)]
pub struct Holding {
    held: Vec<Held>,
    renewed: Instant,
}

/// A channel that is held.
#[derive(Debug)]
struct Held {
    channel: usize,
    setpoint: Setpoint,
    since: Instant,
    /// What the driver published of it once the command was in force. Anything else later is somebody else's command.
    seen: Option<(Mode, u64)>,
}

/// What tells one setpoint of a channel from another.
fn mark(row: &Row) -> (Mode, u64) {
    (row.state.mode(), row.state.target_m.to_bits())
}

impl Holding {
    /// Nothing yet.
    pub fn new() -> Holding {
        Holding { held: Vec::new(), renewed: Instant::now() }
    }

    /// The channels that are held.
    pub fn channels(&self) -> Vec<usize> {
        self.held.iter().map(|held| held.channel).collect()
    }

    /// Commands a channel, and holds it there; says what was taken, or why not and what to do.
    pub fn set(&mut self, live: &Live, channel: usize, setpoint: Setpoint) -> Result<String, String> {
        // off needs no lease
        let hold = if setpoint == Setpoint::Off { Duration::ZERO } else { HOLD };
        // what is refused leaves the setpoint before it in force, and held
        let answer = live.set(channel, setpoint, hold)?;
        self.held.retain(|held| held.channel != channel);
        self.held.push(Held { channel, setpoint, since: Instant::now(), seen: None });
        Ok(answer)
    }

    /// Lets a channel go, whoever holds it.
    pub fn release(&mut self, live: &Live, channel: usize) -> Result<String, String> {
        self.held.retain(|held| held.channel != channel);
        live.set(channel, Setpoint::Off, RELEASE).map(|_| "let go".into())
    }

    /// Forgets what is no longer held from here, and says so where another command has taken it.
    pub fn watch(&mut self, view: &View) -> Option<String> {
        let mut lost = None;
        self.held.retain_mut(|held| {
            let row = &view.channels[held.channel];
            let now = mark(row);
            if held.seen.is_none() && held.since.elapsed() >= SHOWS {
                held.seen = Some(now);
            }
            let ours = held.seen.is_none_or(|seen| seen == now);
            if !ours && row.fault.is_none() {
                lost = Some(format!("{}: taken from this screen by another command", row.name));
            }
            ours
        });
        lost
    }

    /// Renews the leases when it is time; says what was refused.
    pub fn renew(&mut self, live: &Live) -> Option<String> {
        if self.renewed.elapsed() < RENEW {
            return None;
        }
        self.renewed = Instant::now();
        let mut refused = None;
        self.held.retain(|held| {
            // not before its own setpoint has been seen in force: this renewal could be over another's command
            let quiet = held.setpoint == Setpoint::Off || held.seen.is_none();
            match if quiet { Ok(String::new()) } else { live.set(held.channel, held.setpoint, HOLD) } {
                Ok(_) => true,
                Err(why) => {
                    refused = Some(why);
                    false
                }
            }
        });
        refused
    }

    /// Lets everything go that is still held.
    pub fn finish(self, live: &Live) {
        if live.ended().is_none() {
            for held in self.held {
                let _ = live.set(held.channel, Setpoint::Off, RELEASE);
            }
        }
    }
}
