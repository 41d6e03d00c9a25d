//! What a commander may ask, in JSON: the calls of `sinew_ipc::Client` by their names, and their arguments by theirs.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use sinew_ipc::{ALL_CHANNELS, Client, CommandKind, Error, Reply, Taken, Wanted};

/// The lease of a setpoint that names none: as of a stream of setpoints.
const USUAL_HOLD_S: f64 = 0.5;
/// The longest lease: with a link that is silent instead of closed a wire is off within this time.
pub const LONGEST_HOLD_S: f64 = 3.0;

/// A call. Lengths in m, strokes and duties 0..1, forces in N, holds in s.
#[derive(Debug, Deserialize, PartialEq)]
#[serde(tag = "call", rename_all = "snake_case", deny_unknown_fields)]
pub enum Request {
    /// A setpoint, which holds unless it is renewed.
    Set { channel: String, kind: Kind, value: f64, hold_s: Option<f64> },
    /// Several, in force from the same cycle on, or none.
    SetMany { wanted: Vec<Setpoint>, hold_s: Option<f64> },
    /// Only the sensing pulse on a channel.
    Off { channel: String },
    /// On every channel.
    AllOff {},
    /// Clear a latched fault whose cause has gone.
    Reset { channel: String },
    /// Have channels to oneself.
    Claim { channels: Vec<String>, priority: u32, hold_s: Option<f64> },
    /// Let go of them.
    Release { channels: Vec<String> },
    /// Stop the driver.
    Stop {},
}

/// A setpoint of several.
#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Setpoint {
    channel: String,
    kind: Kind,
    /// Left out for `off`.
    #[serde(default)]
    value: f64,
}

/// What is asked for of a channel.
#[derive(Debug, Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Length,
    Stroke,
    Duty,
    Force,
    Off,
}

impl Kind {
    fn command(self) -> CommandKind {
        match self {
            Kind::Length => CommandKind::Length,
            Kind::Stroke => CommandKind::Stroke,
            Kind::Duty => CommandKind::Duty,
            Kind::Force => CommandKind::Force,
            Kind::Off => CommandKind::Off,
        }
    }
}

/// What has become of it.
#[derive(Debug, Serialize, PartialEq)]
pub struct Done {
    /// The cycle from which on it is in force.
    pub cycle: u64,
    /// The lease as granted, s; 0 where there is none.
    pub hold_s: f64,
}

/// Why nothing has.
#[derive(Debug, Serialize, PartialEq)]
pub struct Refused {
    /// What is amiss.
    pub message: String,
    /// What to do.
    pub remedy: String,
    /// Whether the driver may have taken it all the same.
    #[serde(skip)]
    pub is_open: bool,
}

impl Refused {
    /// With these words.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Refused {
        Refused { message: message.into(), remedy: remedy.into(), is_open: false }
    }
}

impl From<Error> for Refused {
    fn from(error: Error) -> Refused {
        let is_open = matches!(error, Error::NoAnswer { .. });
        Refused { is_open, ..Refused::new(error.message(), error.remedy()) }
    }
}

/// Which channels get power by a request, or are claimed, and for how long; which do not any more.
#[derive(Debug, Default, PartialEq)]
pub struct Effect {
    /// Channels with a lease from now on.
    pub leased: Vec<u32>,
    /// How long it lasts.
    pub hold: Duration,
    /// Channels without one.
    pub released: Vec<u32>,
}

impl Request {
    /// Reads one.
    ///
    /// # Errors
    /// What is amiss with the text, in words.
    pub fn read(text: &[u8]) -> Result<Request, Refused> {
        serde_json::from_slice(text).map_err(|error| {
            let example =
                r#"write it like {"call": "set", "channel": "left", "kind": "stroke", "value": 0.4, "hold_s": 0.5}"#;
            Refused::new(format!("no request: {error}"), example)
        })
    }

    /// Whether all that it asks for is less power: that is never refused for its rate or for who is there.
    pub fn only_switches_off(&self) -> bool {
        match self {
            Request::Off { .. } | Request::AllOff {} | Request::Stop {} | Request::Release { .. } => true,
            Request::Set { kind, .. } => *kind == Kind::Off,
            Request::SetMany { wanted, .. } => wanted.iter().all(|setpoint| setpoint.kind == Kind::Off),
            Request::Reset { .. } | Request::Claim { .. } => false,
        }
    }

    /// What it does to the leases of channels, once the driver has taken it.
    ///
    /// # Errors
    /// Channels there are not, holds longer than a link may have.
    pub fn effect(&self, client: &Client) -> Result<Effect, Refused> {
        let number = |name: &String| client.channel(name).map(|number| number as u32);
        Ok(match self {
            Request::Set { channel, kind: Kind::Off, .. } | Request::Off { channel } => {
                Effect { released: vec![number(channel)?], ..Effect::default() }
            }
            Request::Set { channel, hold_s, .. } => {
                Effect { leased: vec![number(channel)?], hold: hold(*hold_s)?, ..Effect::default() }
            }
            Request::SetMany { wanted, hold_s } => {
                let (off, set): (Vec<_>, Vec<_>) = wanted.iter().partition(|setpoint| setpoint.kind == Kind::Off);
                let numbers = |of: Vec<&Setpoint>| -> Result<Vec<u32>, Error> {
                    of.iter().map(|setpoint| number(&setpoint.channel)).collect()
                };
                Effect { leased: numbers(set)?, hold: hold(*hold_s)?, released: numbers(off)? }
            }
            Request::AllOff {} | Request::Stop {} => Effect { released: vec![ALL_CHANNELS], ..Effect::default() },
            Request::Claim { hold_s, .. } => Effect { hold: hold(*hold_s)?, ..Effect::default() },
            Request::Reset { .. } | Request::Release { .. } => Effect::default(),
        })
    }

    /// Asks the driver, and waits for its answer. `hold` is that of the [`Effect`].
    ///
    /// # Errors
    /// The driver's refusals.
    pub fn carry_out(&self, client: &Client, hold: Duration) -> Result<Done, Refused> {
        let number = |name: &String| client.channel(name).map(|number| number as u32);
        let numbers = |names: &[String]| names.iter().map(number).collect::<Result<Vec<u32>, Error>>();
        let alone = |reply: Reply| Done { cycle: reply.cycle, hold_s: reply.hold_s };
        let together = |taken: Taken| Done { cycle: taken.cycle, hold_s: taken.hold_s };
        Ok(match self {
            Request::Set { channel, kind: Kind::Off, .. } | Request::Off { channel } => alone(client.off(channel)?),
            Request::Set { channel, kind, value, .. } => alone(client.set(channel, kind.command(), *value, hold)?),
            Request::SetMany { wanted, .. } => {
                let wanted = wanted.iter().map(|setpoint| {
                    let (channel, kind) = (number(&setpoint.channel)?, setpoint.kind.command());
                    Ok(Wanted { channel, kind, value: setpoint.value })
                });
                let off = self.only_switches_off();
                let wanted = wanted.collect::<Result<Vec<Wanted>, Error>>()?;
                // off holds until the next command
                together(client.set_many(&wanted, if off { Duration::ZERO } else { hold })?)
            }
            Request::AllOff {} => alone(client.all_off()?),
            Request::Reset { channel } => alone(client.reset(channel)?),
            Request::Claim { channels, priority, .. } => {
                together(client.claim(&numbers(channels)?, *priority, hold)?)
            }
            Request::Release { channels } => together(client.release(&numbers(channels)?)?),
            Request::Stop {} => alone(client.stop()?),
        })
    }
}

fn hold(hold_s: Option<f64>) -> Result<Duration, Refused> {
    let hold_s = hold_s.unwrap_or(USUAL_HOLD_S);
    // also what is no number
    if !(hold_s > 0.0 && hold_s <= LONGEST_HOLD_S) {
        let remedy = format!("hold for up to {LONGEST_HOLD_S} s and ask again before it has passed");
        return Err(Refused::new(format!("a hold of {hold_s} s: over a network a lease is short"), remedy));
    }
    Ok(Duration::from_secs_f64(hold_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Request, Refused> {
        Request::read(text.as_bytes())
    }

    #[test]
    fn requests_are_the_clients_calls_and_nothing_else() {
        let set = read(r#"{"call":"set","channel":"left","kind":"stroke","value":0.4,"hold_s":0.5}"#).unwrap();
        let expected = Request::Set { channel: "left".into(), kind: Kind::Stroke, value: 0.4, hold_s: Some(0.5) };
        assert!(set == expected && !set.only_switches_off());
        let many =
            r#"{"call":"set_many","wanted":[{"channel":"a","kind":"off"},{"channel":"b","kind":"duty","value":0.1}]}"#;
        assert!(!read(many).unwrap().only_switches_off());
        for off in [
            r#"{"call":"off","channel":"left"}"#,
            r#"{"call":"all_off"}"#,
            r#"{"call":"stop"}"#,
            r#"{"call":"release","channels":["left"]}"#,
            r#"{"call":"set","channel":"left","kind":"off","value":0}"#,
            r#"{"call":"set_many","wanted":[{"channel":"a","kind":"off"}]}"#,
        ] {
            assert!(read(off).unwrap().only_switches_off(), "{off}");
        }
        for bad in [
            "",
            "null",
            "[]",
            r#"{"call":"heat"}"#,
            r#"{"call":"set","channel":"left"}"#,
            r#"{"call":"set","channel":"left","kind":"stroke","value":"much"}"#,
            r#"{"call":"set","channel":"left","kind":"stroke","value":0.4,"hold":9}"#,
            r#"{"call":"claim","channels":["left"],"priority":-1}"#,
        ] {
            let refused = read(bad).unwrap_err();
            assert!(refused.message.starts_with("no request: ") && refused.remedy.contains("call"), "{bad}");
        }
    }

    #[test]
    fn a_lease_over_a_network_is_short() {
        assert_eq!(hold(None).unwrap(), Duration::from_millis(500));
        assert_eq!(hold(Some(3.0)).unwrap(), Duration::from_secs(3));
        for bad in [0.0, -1.0, 3.1, 1e300, f64::INFINITY, f64::NAN] {
            assert!(hold(Some(bad)).is_err(), "{bad}");
        }
    }
    #[test]
    fn what_was_not_answered_may_have_been_taken() {
        let error = Error::NoAnswer { rig: "bench".into(), waited: Duration::from_secs(1) };
        assert!(Refused::from(error).is_open);
        assert!(!Refused::from(Error::Channels { found: 0 }).is_open);
    }
}
