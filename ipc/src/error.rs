//! What can go wrong between the driver and its clients, and what to do about it.

use crate::{CommandKind, Fault, MOST_PRIORITY, Name, Outcome};
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// Every way a call of this crate can fail.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// A rig name outside the allowed characters or too long.
    RigName {
        /// The name as given.
        name: String,
    },
    /// A channel name that does not fit into a message.
    Name {
        /// The name as given.
        name: String,
    },
    /// No channels, or more than fit into a message.
    Channels {
        /// How many there were.
        found: usize,
    },
    /// A driver for this rig name is already running.
    AlreadyRunning {
        /// The rig's name.
        rig: String,
        /// Process id of that driver; 0 when it is just starting.
        pid: u32,
    },
    /// No driver for this rig name is running.
    NotRunning {
        /// The rig's name.
        rig: String,
        /// The rigs that are running.
        running: Vec<String>,
    },
    /// A driver holds the rig but has not opened its services in time.
    Starting {
        /// The rig's name.
        rig: String,
        /// Process id of that driver.
        pid: u32,
    },
    /// The driver this client was connected to is gone.
    DriverGone {
        /// The rig's name.
        rig: String,
        /// Process id it had.
        pid: u32,
        /// Whether it stopped in order (true) or died.
        stopped: bool,
    },
    /// Driver and client speak different versions of the messages.
    Protocol {
        /// The rig's name.
        rig: String,
        /// Version of the driver.
        found: u32,
        /// Version of this library.
        expected: u32,
    },
    /// There is no channel of that name.
    UnknownChannel {
        /// The name as given.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// The driver refused a command.
    Refused(Refusal),
    /// The driver refused a request for several channels, for these reasons; it has carried out none of it.
    RefusedTogether(Vec<Refusal>),
    /// The driver did not answer in time.
    NoAnswer {
        /// The rig's name.
        rig: String,
        /// How long this client waited.
        waited: Duration,
    },
    /// The folder for locks and sockets cannot be used.
    RuntimeDir {
        /// The folder.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// The driver serves no more of something at once.
    Full {
        /// The rig's name.
        rig: String,
        /// Of what.
        what: &'static str,
        /// How many it serves.
        most: u32,
    },
    /// The driver is another user's, and lets only others look.
    NotAdmitted {
        /// The rig's name.
        rig: String,
        /// Number of the driver's user.
        user: u32,
        /// Group whose members may command; empty = nobody's.
        command_group: String,
        /// Group whose members may look; empty = nobody's.
        read_group: String,
    },
    /// The gateway for other users cannot be opened, or could be anybody's.
    Gateway {
        /// The folder or the socket.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// There is no group of that name.
    UnknownGroup {
        /// The name as given.
        name: String,
    },
    /// Shared memory could not be set up or opened.
    Service {
        /// Which part.
        what: &'static str,
        /// iceoryx2's own words.
        reason: String,
    },
}

/// Why the driver refused a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// The channel's name; "all channels" for commands that name none.
    pub channel: String,
    /// What was asked for.
    pub kind: CommandKind,
    /// The value asked for, in SI units.
    pub value: f64,
    /// Why not.
    pub reason: Reason,
}

/// The reason of a [`Refusal`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// The driver has no channel of that number.
    UnknownChannel,
    /// The driver does not know that kind of command.
    UnknownCommand,
    /// Value or hold is NaN or infinite.
    NotFinite,
    /// The value is outside this range, in SI units.
    OutOfRange {
        /// Smallest value allowed.
        low: f64,
        /// Largest value allowed.
        high: f64,
    },
    /// The hold is outside this range, s.
    HoldOutOfRange {
        /// Shortest hold allowed, s.
        low: f64,
        /// Longest hold allowed, s.
        high: f64,
    },
    /// The channel is off by this latched fault.
    Faulted(Fault),
    /// The cause of this fault is still there.
    CauseRemains(Fault),
    /// The wire has to cool before this fault can be cleared.
    TooHot {
        /// The fault.
        fault: Fault,
        /// How long that takes at the most, s; NaN where it is not known.
        longest_s: f64,
        /// What is believed of its temperature, °C.
        temperature_c: f64,
        /// What that has to come down to, °C. Where it has, the heat account has to drain.
        below_c: f64,
    },
    /// The channel's sensors have not proved themselves yet.
    Waiting,
    /// This channel cannot do that.
    Unsupported,
    /// Too many commands at once.
    Busy,
    /// The driver is stopping.
    Stopping,
    /// An `off`, or a request for several channels, that was asked for later has overtaken it.
    Overtaken,
    /// Another setpoint of the same request was refused.
    WithOthers,
    /// The request names the channel twice, or asks beside others for what is asked for alone.
    NotTogether,
    /// Another client has claimed the channel.
    Claimed {
        /// Its process id.
        owner: u32,
        /// Priority of its claim.
        priority: u32,
        /// How long the claim holds unless it is renewed, s.
        left_s: f64,
    },
    /// The setpoint of a stream came after its deadline.
    Late,
    /// The time to approach the setpoint in is outside this range, s.
    ApproachOutOfRange {
        /// Shortest time, s.
        low: f64,
        /// Longest time, s: the lease.
        high: f64,
    },
    /// Who asks may look but not command: that may members of this group (empty: the driver's own user alone).
    NotPermitted {
        /// The group.
        group: Name,
    },
    /// An answer this library does not know.
    Unknown(u32),
}

impl Reason {
    /// The number it has in messages: that of an [`Outcome`], or one this library does not know.
    pub const fn outcome(&self) -> u32 {
        let outcome = match self {
            Reason::UnknownChannel => Outcome::UnknownChannel,
            Reason::UnknownCommand => Outcome::UnknownCommand,
            Reason::NotFinite => Outcome::NotFinite,
            Reason::OutOfRange { .. } => Outcome::OutOfRange,
            Reason::HoldOutOfRange { .. } => Outcome::HoldOutOfRange,
            Reason::Faulted(_) => Outcome::Faulted,
            Reason::CauseRemains(_) => Outcome::CauseRemains,
            Reason::TooHot { .. } => Outcome::TooHot,
            Reason::Waiting => Outcome::Waiting,
            Reason::Unsupported => Outcome::Unsupported,
            Reason::Busy => Outcome::Busy,
            Reason::Stopping => Outcome::Stopping,
            Reason::Overtaken => Outcome::Overtaken,
            Reason::WithOthers => Outcome::WithOthers,
            Reason::NotTogether => Outcome::NotTogether,
            Reason::NotPermitted { .. } => Outcome::NotPermitted,
            Reason::Claimed { .. } => Outcome::Claimed,
            Reason::Late => Outcome::Late,
            Reason::ApproachOutOfRange { .. } => Outcome::ApproachOutOfRange,
            Reason::Unknown(code) => return *code,
        };
        outcome.code()
    }
}

impl Error {
    /// What a person can do about it; empty where the message says all there is.
    pub fn remedy(&self) -> String {
        match self {
            Error::RigName { .. } => "use 1 to 48 of the characters A-Z a-z 0-9 _ . -".into(),
            Error::Name { .. } => "use 1 to 64 bytes without a zero byte".into(),
            Error::Channels { .. } => format!("a rig has 1 to {} channels", crate::MAX_CHANNELS),
            Error::AlreadyRunning { rig, pid: 0 } => {
                format!("stop it with `sinew stop --rig {rig}`, or give this rig another name")
            }
            Error::AlreadyRunning { rig, pid } => {
                format!("stop it with `sinew stop --rig {rig}` or `kill {pid}`, or give this rig another name")
            }
            Error::NotRunning { running, .. } if running.is_empty() => "start the driver: `sinew run RIG.toml`".into(),
            Error::NotRunning { running, .. } => {
                format!("start it: `sinew run RIG.toml`; running: {}", running.join(", "))
            }
            Error::Starting { pid, .. } => {
                format!("try again in a moment; if it stays so, look what process {pid} does")
            }
            Error::DriverGone { stopped: true, .. } => Fault::Stopping.remedy().into(),
            Error::DriverGone { stopped: false, .. } => Fault::DriverDied.remedy().into(),
            Error::Protocol { found, expected, .. } if found > expected => {
                "build this program against the driver's version of sinew-ipc".into()
            }
            Error::Protocol { .. } => "restart the driver with the sinew this program was built with".into(),
            Error::UnknownChannel { name, known } => match nearest(name, known) {
                Some(near) => format!("did you mean {near:?}?"),
                None => format!("there are: {}", known.join(", ")),
            },
            Error::Refused(refusal) => refusal.remedy(),
            Error::RefusedTogether(refusals) => refusals.first().map(Refusal::remedy).unwrap_or_default(),
            Error::NoAnswer { .. } => {
                "the driver runs but does not answer: see `sinew status` for overruns, and `sinew doctor`".into()
            }
            Error::RuntimeDir { .. } => {
                "make it a folder of your own with mode 0700, or name another one in SINEW_RUNTIME_DIR".into()
            }
            Error::Full { .. } => "end programs that are not needed any more, or try again in a moment".into(),
            Error::NotAdmitted { command_group, read_group, .. } => {
                match (command_group.as_str(), read_group.as_str()) {
                    ("", "") => "name a read_group or command_group in [access] of its rig file".into(),
                    (group, "") | ("", group) => join(group),
                    (commanders, readers) => format!("{} (to look: {readers})", join(commanders)),
                }
            }
            Error::Gateway { .. } => {
                "make its folder the driver's user's own with mode 0755 (docs/access.md tells how), or name \
                                   another one in SINEW_GATE_DIR"
                    .into()
            }
            Error::UnknownGroup { name } => {
                format!("create it with `sudo groupadd {name}`, or mend [access] in the rig file")
            }
            Error::Service { .. } => {
                "check the space left in /dev/shm and the number of programs connected (256 at most)".into()
            }
        }
    }

    /// Whether this is the caller's mistake (a name, a value) and not a failure of the machine or the driver.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Error::RigName { .. } | Error::Name { .. } | Error::Channels { .. } | Error::UnknownChannel { .. } => true,
            Error::UnknownGroup { .. } => true,
            Error::Refused(refusal) => refusal.is_bad_input(),
            Error::RefusedTogether(refusals) => refusals.iter().any(Refusal::is_bad_input),
            _ => false,
        }
    }

    /// What is wrong, without the remedy.
    pub fn message(&self) -> String {
        match self {
            Error::RigName { name } => format!("{name:?} is no rig name"),
            Error::Name { name } => format!("{name:?} is no channel name"),
            Error::Channels { found } => format!("a rig with {found} channels"),
            Error::AlreadyRunning { rig, pid: 0 } => format!("a driver for rig {rig:?} is already starting"),
            Error::AlreadyRunning { rig, pid } => {
                format!("a driver for rig {rig:?} is already running as process {pid}")
            }
            Error::NotRunning { rig, .. } => format!("no driver for rig {rig:?} is running"),
            Error::Starting { rig, pid } => {
                format!("the driver for rig {rig:?} (process {pid}) has not finished starting")
            }
            Error::DriverGone { rig, pid, stopped: true } => {
                format!("the driver for rig {rig:?} (process {pid}) has stopped")
            }
            Error::DriverGone { rig, pid, stopped: false } => {
                format!("the driver for rig {rig:?} (process {pid}) has died")
            }
            Error::Protocol { rig, found, expected } => {
                format!("the driver for rig {rig:?} speaks protocol {found}, this program protocol {expected}")
            }
            Error::UnknownChannel { name, .. } => format!("there is no channel {name:?}"),
            Error::Refused(refusal) => refusal.message(),
            Error::RefusedTogether(refusals) => {
                let reasons: Vec<String> = refusals.iter().map(Refusal::message).collect();
                format!("{}; nothing of the request was carried out", reasons.join("; "))
            }
            Error::NoAnswer { rig, waited } => {
                format!("the driver for rig {rig:?} has not answered for {:.1} s", waited.as_secs_f64())
            }
            Error::RuntimeDir { path, reason } => format!("cannot use {}: {reason}", path.display()),
            Error::Full { rig, what, most } => {
                format!("the driver for rig {rig:?} serves {most} {what} at once, and all are taken")
            }
            Error::NotAdmitted { rig, user, .. } => {
                format!("the driver for rig {rig:?} belongs to user {user}, and this user may neither look nor command")
            }
            Error::Gateway { path, reason } => format!("cannot use {}: {reason}", path.display()),
            Error::UnknownGroup { name } => format!("there is no group {name:?}"),
            Error::Service { what, reason } => format!("shared memory of {what}: {reason}"),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message())?;
        match self.remedy() {
            remedy if remedy.is_empty() => Ok(()),
            remedy => write!(f, "; {remedy}"),
        }
    }
}

impl std::error::Error for Error {}

impl Refusal {
    /// Whether the request itself is the mistake.
    fn is_bad_input(&self) -> bool {
        matches!(
            self.reason,
            Reason::UnknownChannel
                | Reason::UnknownCommand
                | Reason::NotFinite
                | Reason::OutOfRange { .. }
                | Reason::HoldOutOfRange { .. }
                | Reason::Unsupported
                | Reason::NotTogether
        )
    }

    /// What is wrong, without the remedy.
    pub fn message(&self) -> String {
        let Refusal { channel, kind, value, reason } = self;
        let (name, unit) = (kind.name(), kind.unit());
        match reason {
            Reason::UnknownChannel => format!("the driver has no channel {channel:?}"),
            Reason::UnknownCommand => format!("the driver does not know the command {name:?}"),
            Reason::NotFinite => format!("{channel}: {name} or hold is not a finite number"),
            Reason::OutOfRange { low, high } => {
                format!("{channel}: {name} {value}{unit} is outside {low:.6}{unit} to {high:.6}{unit}")
            }
            Reason::HoldOutOfRange { low, high } => format!("{channel}: hold is outside {low} s to {high} s"),
            Reason::Faulted(fault) => format!("{channel} is off ({}): {}", fault.flag(), fault.cause()),
            Reason::CauseRemains(fault) => {
                format!("{channel} cannot be reset ({}): the cause is still there: {}", fault.flag(), fault.cause())
            }
            Reason::TooHot { fault, temperature_c, below_c, .. } if *temperature_c <= *below_c => {
                format!("{channel} cannot be reset yet ({}): its heat account has to drain", fault.flag())
            }
            Reason::TooHot { fault, temperature_c, below_c, .. } => format!(
                "{channel} cannot be reset yet ({}): it is believed at {temperature_c:.0} °C and has to come down to {below_c:.0} °C",
                fault.flag()
            ),
            Reason::Waiting => format!("{channel} has not proved its sensors yet"),
            Reason::Unsupported => format!("{channel} cannot do {name}"),
            Reason::Busy => format!("{channel}: the driver is busy with other commands"),
            Reason::Stopping => format!("{channel}: {}", Fault::Stopping.cause()),
            Reason::Overtaken => format!("{channel}: {name} was overtaken by a later request and not carried out"),
            Reason::WithOthers => format!("{channel}: {name} was refused together with others"),
            Reason::NotTogether if matches!(kind, CommandKind::Reset | CommandKind::Stop) => {
                format!("{channel}: {name} has to be asked for alone")
            }
            Reason::NotTogether if matches!(kind, CommandKind::Claim | CommandKind::Release) => {
                format!("{channel} stands twice in the request, or {name} beside something else")
            }
            Reason::Claimed { owner, priority, left_s } => format!(
                "{channel} is claimed by process {owner} with priority {priority}, for {left_s:.1} s more unless it renews that"
            ),
            Reason::NotTogether => format!("{channel} stands twice in the request"),
            Reason::Late => format!("{channel}: {name} came after its deadline and was not carried out"),
            Reason::ApproachOutOfRange { low, high } => {
                format!("{channel}: the time to approach it in is outside {low} s to {high} s, the lease")
            }
            Reason::NotPermitted { group } if *group == Name::EMPTY => {
                format!("{channel}: commands are taken from the driver's own user alone")
            }
            Reason::NotPermitted { group } => {
                format!("{channel}: commands are taken from members of group {group} alone")
            }
            Reason::Unknown(code) => format!("{channel}: refused for a reason this program does not know ({code})"),
        }
    }

    /// What a person can do about it.
    pub fn remedy(&self) -> String {
        match self.reason {
            Reason::UnknownChannel => "connect again: the driver may have been restarted with another rig file".into(),
            Reason::UnknownCommand | Reason::Unknown(_) => "use driver and program of the same version".into(),
            Reason::NotFinite => "send a finite number".into(),
            Reason::OutOfRange { .. } => Fault::SetpointOutOfRange.remedy().into(),
            Reason::HoldOutOfRange { .. } => "choose a hold inside that range; 0 takes the channel's default".into(),
            Reason::Faulted(fault) | Reason::CauseRemains(fault) => fault.remedy().into(),
            // rounded up, so that it is taken then
            Reason::TooHot { longest_s, .. } if longest_s.is_finite() => {
                format!("reset it again in {:.1} s: it has cooled by then", (longest_s * 10.0).ceil() / 10.0)
            }
            Reason::TooHot { .. } => "reset it again when it has cooled".into(),
            Reason::Waiting => Fault::NoSample.remedy().into(),
            Reason::Unsupported => "use length, stroke or duty".into(),
            Reason::Busy => "send it again, and less often".into(),
            Reason::Stopping => Fault::Stopping.remedy().into(),
            Reason::Overtaken => "ask for it again, if the wire is to be powered after all".into(),
            Reason::WithOthers => "mend what the others were refused for".into(),
            Reason::NotTogether => {
                "name each channel once, and ask for a reset, a stop, claims or releases alone".into()
            }
            Reason::Claimed { priority, .. } if priority < MOST_PRIORITY => {
                "wait until it lets go, or claim the channel with a higher priority; switch a wire off anybody may"
                    .into()
            }
            Reason::Claimed { .. } => "wait until it lets go; switch a wire off anybody may".into(),
            Reason::Late => "send it earlier, or with a later deadline; a busy machine needs some milliseconds".into(),
            Reason::ApproachOutOfRange { .. } => "choose a shorter time, or a longer hold".into(),
            Reason::NotPermitted { group } if group == Name::EMPTY => {
                "name a command_group in [access] of the rig file".into()
            }
            Reason::NotPermitted { group } => join(group.as_str()),
        }
    }
}

/// How to become a member of a group.
fn join(group: &str) -> String {
    format!("ask to be added to group {group} (`sudo usermod -aG {group} $USER`), then log in again")
}

/// The known name closest to a mistyped one, if one is close.
fn nearest<'a>(name: &str, known: &'a [String]) -> Option<&'a str> {
    known
        .iter()
        .map(|k| (strsim::osa_distance(name, k), k.as_str()))
        .min_by_key(|(d, _)| *d)
        .filter(|(d, _)| *d <= 1 + name.chars().count() / 4)
        .map(|(_, k)| k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistyped_channel_is_recognised() {
        let known = vec!["front_left_coxa".to_string(), "front_left_femur".to_string()];
        let e = Error::UnknownChannel { name: "front_left_cxa".into(), known: known.clone() };
        assert_eq!(e.to_string(), "there is no channel \"front_left_cxa\"; did you mean \"front_left_coxa\"?");
        let e = Error::UnknownChannel { name: "wire".into(), known };
        assert!(e.to_string().contains("there are: front_left_coxa, front_left_femur"), "{e}");
    }

    #[test]
    fn a_refusal_carries_the_remedy_of_its_fault() {
        for row in &crate::FAULT_TABLE {
            let refusal = Refusal {
                channel: "wire".into(),
                kind: CommandKind::Stroke,
                value: 0.4,
                reason: Reason::Faulted(row.fault),
            };
            let text = Error::Refused(refusal).to_string();
            assert!(text.contains(row.flag) && text.contains(row.cause) && text.contains(row.remedy), "{text}");
        }
    }

    #[test]
    fn a_reset_that_comes_too_early_is_told_when() {
        let said = |longest_s, temperature_c| {
            let reason = Reason::TooHot { fault: Fault::OverTemperature, longest_s, temperature_c, below_c: 163.0 };
            Error::Refused(Refusal { channel: "wire".into(), kind: CommandKind::Reset, value: 0.0, reason }).to_string()
        };
        assert_eq!(
            said(3.11, 168.4),
            "wire cannot be reset yet (over_temperature): it is believed at 168 °C and has to come down to 163 °C; \
             reset it again in 3.2 s: it has cooled by then"
        );
        assert!(said(1.0, 80.0).contains("its heat account has to drain; reset it again in 1.0 s"));
        assert!(!said(f64::NAN, f64::NAN).contains("NaN s"), "{}", said(f64::NAN, f64::NAN));
    }

    #[test]
    fn messages_begin_small_and_have_no_full_stop() {
        let samples = [
            Error::RigName { name: "a b".into() },
            Error::AlreadyRunning { rig: "x".into(), pid: 7 },
            Error::NotRunning { rig: "x".into(), running: vec!["y".into()] },
            Error::Protocol { rig: "x".into(), found: 2, expected: 1 },
            Error::NoAnswer { rig: "x".into(), waited: Duration::from_millis(1500) },
        ];
        for e in samples {
            let text = e.to_string();
            assert!(!text.starts_with(char::is_uppercase) && !text.ends_with('.') && text.contains("; "), "{text}");
        }
    }
}
