//! What a commander may ask, in JSON: the calls of `sinew_ipc::Client` by their names, and their arguments by theirs.

use std::time::Duration;

use serde::{Deserialize, Serialize};
use sinew_ipc::{ALL_CHANNELS, Client, CommandKind, Error, Wanted};

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
}

impl Refused {
    /// With these words.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Refused {
        Refused { message: message.into(), remedy: remedy.into() }
    }
}

impl From<Error> for Refused {
    fn from(error: Error) -> Refused {
        Refused::new(error.message(), error.remedy())
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

    /// Asks the driver, and waits for its answer.
    ///
    /// # Errors
    /// The driver's refusals, and holds longer than a link may have.
    pub fn carry_out(&self, client: &Client) -> Result<(Done, Effect), Refused> {
        let number = |name: &String| client.channel(name).map(|number| number as u32);
        let done = |reply: sinew_ipc::Reply| Done { cycle: reply.cycle, hold_s: reply.hold_s };
        let together = |taken: sinew_ipc::Taken| Done { cycle: taken.cycle, hold_s: taken.hold_s };
        let numbers = |names: &[String]| names.iter().map(number).collect::<Result<Vec<u32>, Error>>();
        Ok(match self {
            Request::Set { channel, kind, value, hold_s } => {
                let (channel, hold) = (number(channel)?, hold(*hold_s)?);
                let kind = kind.command();
                // off holds until the next command
                let asked = if kind == CommandKind::Off { Duration::ZERO } else { hold };
                let answer = done(client.command(channel, kind, *value, asked)?);
                (answer, effect(&[Wanted { channel, kind, value: *value }], hold))
            }
            Request::SetMany { wanted, hold_s } => {
                let wanted = wanted.iter().map(|setpoint| {
                    let kind = setpoint.kind.command();
                    Ok(Wanted { channel: number(&setpoint.channel)?, kind, value: setpoint.value })
                });
                let (wanted, hold) = (wanted.collect::<Result<Vec<Wanted>, Error>>()?, hold(*hold_s)?);
                let off = wanted.iter().all(|wanted| wanted.kind == CommandKind::Off);
                let answer = together(client.set_many(&wanted, if off { Duration::ZERO } else { hold })?);
                (answer, effect(&wanted, hold))
            }
            Request::Off { channel } => {
                let wanted = Wanted { channel: number(channel)?, kind: CommandKind::Off, value: 0.0 };
                (done(client.off(channel)?), effect(&[wanted], Duration::ZERO))
            }
            Request::AllOff {} => {
                let wanted = Wanted { channel: ALL_CHANNELS, kind: CommandKind::Off, value: 0.0 };
                (done(client.all_off()?), effect(&[wanted], Duration::ZERO))
            }
            Request::Reset { channel } => (done(client.reset(channel)?), Effect::default()),
            Request::Claim { channels, priority, hold_s } => {
                let (channels, hold) = (numbers(channels)?, hold(*hold_s)?);
                (together(client.claim(&channels, *priority, hold)?), Effect::default())
            }
            Request::Release { channels } => (together(client.release(&numbers(channels)?)?), Effect::default()),
            Request::Stop {} => (done(client.stop()?), Effect::default()),
        })
    }
}

fn effect(wanted: &[Wanted], hold: Duration) -> Effect {
    let (released, leased): (Vec<&Wanted>, Vec<&Wanted>) =
        wanted.iter().partition(|wanted| wanted.kind == CommandKind::Off);
    let numbers = |wanted: Vec<&Wanted>| wanted.into_iter().map(|wanted| wanted.channel).collect();
    Effect { leased: numbers(leased), hold, released: numbers(released) }
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
    fn only_what_has_power_is_leased() {
        let wanted = |channel, kind| Wanted { channel, kind, value: 0.1 };
        let second = Duration::from_secs(1);
        let mixed = effect(&[wanted(0, CommandKind::Duty), wanted(3, CommandKind::Off)], second);
        assert_eq!(mixed, Effect { leased: vec![0], hold: second, released: vec![3] });
    }
}
