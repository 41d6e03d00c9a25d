//! How much anybody may ask of a server: clients, bytes and rates.
//!
//! Whoever has an account on this machine may connect, and a client may have gone wrong. Each figure is well above what clients
//! need: a page of the scope that holds 64 wires sends 220 messages a second, of 40 kB.

use std::time::{Duration, Instant};

/// What is allowed; of a server that users start, [`Limits::default`].
#[derive(Debug, Clone)]
pub struct Limits {
    /// Connections open at once, those of live clients among them.
    pub connections: usize,
    /// New connections. A page of the scope takes eleven: its files and the live one.
    pub connecting: Flow,
    /// How long a connection that is not live may last, whatever it does meanwhile: its request and the answer.
    pub request: Duration,
    /// Live clients at once: connections that last, by WebSocket.
    pub clients: usize,
    /// Bytes that a connection sends, with everything that HTTP and WebSocket add. More at once than the longest message.
    pub bytes: Flow,
    /// Messages that a live client sends.
    pub messages: Flow,
    /// Longest message that a live client may send, bytes.
    pub message: usize,
    /// Requests of a page of the scope that it has not had the answer of.
    pub unanswered: usize,
    /// Wrong PINs of pages of a scope on the network, whoever sends them.
    pub pins: Flow,
    /// Longest frame of curves to a page of the scope, bytes: what there is beyond comes in the next one.
    pub frame: usize,
    /// How long a live client may take to fetch one message. There is never more than that one waiting for it.
    pub patience: Duration,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            connections: 64,
            connecting: Flow { at_once: 128.0, a_second: 64.0 },
            request: Duration::from_secs(10),
            clients: 16,
            bytes: Flow { at_once: 512e3, a_second: 256e3 },
            messages: Flow { at_once: 1000.0, a_second: 500.0 },
            message: 64 << 10,
            unanswered: 128,
            pins: Flow { at_once: 10.0, a_second: 1.0 / 60.0 },
            frame: 8 << 20,
            patience: Duration::from_secs(30),
        }
    }
}

/// So many at once, and so many a second in the long run.
#[derive(Debug, Clone, Copy)]
pub struct Flow {
    /// What may come at once after a pause.
    pub at_once: f64,
    /// What may come for ever, 1/s.
    pub a_second: f64,
}

/// What is left of a [`Flow`]: a bucket of tokens.
#[derive(Debug)]
pub struct Allowance {
    flow: Flow,
    left: f64,
    at: Instant,
}

impl Allowance {
    /// All of it, at this moment.
    pub fn new(flow: Flow, now: Instant) -> Allowance {
        Allowance { flow, left: flow.at_once, at: now }
    }

    /// Takes so much of it; false, and takes nothing, where less is left.
    pub fn take(&mut self, amount: f64, now: Instant) -> bool {
        let passed_s = now.saturating_duration_since(self.at).as_secs_f64();
        self.left = (self.left + passed_s * self.flow.a_second).min(self.flow.at_once);
        self.at = self.at.max(now);
        let enough = amount <= self.left;
        if enough {
            self.left -= amount;
        }
        enough
    }

    /// Puts back what was taken and turned out not to be needed.
    pub fn put_back(&mut self, amount: f64) {
        self.left = (self.left + amount).min(self.flow.at_once);
    }

    /// How long it takes until so much of it is there.
    pub fn wait(&self, amount: f64, now: Instant) -> Duration {
        let missing_s =
            (amount - self.left) / self.flow.a_second - now.saturating_duration_since(self.at).as_secs_f64();
        Duration::try_from_secs_f64(missing_s).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_allowance_lets_its_burst_through_and_then_its_rate() {
        let start = Instant::now();
        let after = |ms| start + Duration::from_millis(ms);
        let mut allowance = Allowance::new(Flow { at_once: 3.0, a_second: 10.0 }, start);
        assert_eq!([(); 4].map(|()| allowance.take(1.0, start)), [true, true, true, false]);
        assert!(!allowance.take(1.0, after(90)) && allowance.take(1.0, after(110)), "one in a tenth of a second");
        allowance.put_back(1.0);
        assert!(allowance.take(1.0, after(110)) && !allowance.take(0.2, after(110)), "what was put back, and no more");
        assert_eq!(allowance.wait(1.0, after(110)).as_millis(), 90, "what a tenth of a second has brought is spent");
        assert_eq!((allowance.wait(1.0, after(150)).as_millis(), allowance.wait(1.0, after(900)).as_millis()), (50, 0));
        assert!(!allowance.take(3.1, after(60_000)), "a pause saves up no more than the burst");
        assert!(allowance.take(3.0, after(60_000)), "what was refused took nothing");
        assert!(!allowance.take(0.5, after(0)), "a moment that is past brings nothing");
        let through = (0..1000).filter(|i| allowance.take(1.0, after(120_000 + 10 * i))).count();
        assert_eq!(through, 3 + 99, "ten seconds of a hundred a second");
    }

    #[test]
    fn the_limits_fit_each_other() {
        let limits = Limits::default();
        assert!(limits.bytes.at_once > 2.0 * limits.message as f64, "else the longest message is never let through");
        assert!(limits.connections > limits.clients, "live ones leave room for others' requests");
    }
}
