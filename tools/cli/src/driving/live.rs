//! Connection of the commands to a running driver: selecting it, its state, its answers.

use std::time::{Duration, Instant};

use sinew_driver::report::Quantiles;
use sinew_ipc::{
    ChannelInfo, ChannelState, Client, CommandKind, DriverHealth, Error, Fault, LoopStats, Reason, Refusal, Snapshot,
};
use sinew_sensing::Health;

use super::life;
use crate::args::Target;
use crate::commands::list;
use crate::driving::screen::view::{Row, Timing, View};
use crate::driving::setpoint::Setpoint;
use crate::failure::Failure;

/// Connects to the driver that is meant: the named one, or the only one there is.
pub fn connect(target: &Target) -> Result<Client, Failure> {
    Client::connect(&rig(target)?).map_err(failure)
}

/// The rig that is meant: the named one, whether its driver runs or not, or that of the only driver there is.
pub fn rig(target: &Target) -> Result<String, Failure> {
    if let Some(name) = &target.name {
        return Ok(name.clone());
    }
    let running = Client::discover().map_err(failure)?;
    match running.as_slice() {
        [] => Err(Failure::own("no driver is running")
            .hint("start one: `sinew run RIG.toml`; without a file it is the built-in hexapod")),
        [only] => Ok(only.clone()),
        several => Err(Failure::input(format!("{} drivers are running", several.len()))
            .hint(format!("choose one with --rig: {}", list(several.iter().map(String::as_str))))),
    }
}

/// A client's error, with its remedy as the hint.
pub fn failure(error: Error) -> Failure {
    // an unknown name while other drivers run is a user error
    let slip = matches!(&error, Error::NotRunning { running, .. } if !running.is_empty());
    let (message, remedy) = words(&error);
    let failure = if error.is_bad_input() || slip { Failure::input(message) } else { Failure::own(message) };
    if remedy.is_empty() { failure } else { failure.hint(remedy) }
}

/// An error in words and what to do about it: refused values and ranges in the units they are typed in.
fn words(error: &Error) -> (String, String) {
    match error {
        Error::Refused(refusal) => words_of(refusal),
        Error::RefusedTogether(refusals) => {
            let (messages, remedies): (Vec<_>, Vec<_>) = refusals.iter().map(words_of).unzip();
            let message = match messages.as_slice() {
                [only] => only.clone(),
                several => format!("{}; nothing was carried out", several.join("; ")),
            };
            (message, remedies.into_iter().next().unwrap_or_default())
        }
        _ => (error.message(), error.remedy()),
    }
}

fn words_of(refusal: &Refusal) -> (String, String) {
    let Refusal { channel, kind, value, reason } = refusal;
    let (unit, factor, decimals) = match kind {
        CommandKind::Length => (" mm", 1e3, 2),
        CommandKind::Stroke => (" %", 1e2, 1),
        CommandKind::Force => (" N", 1.0, 3),
        _ => ("", 1.0, 3),
    };
    let name = kind.name();
    match *reason {
        Reason::OutOfRange { low, high } => {
            // rounded inwards, so that what is offered would be taken
            let scale = f64::powi(10.0, decimals);
            let low = (low * factor * scale - 1e-6).ceil() / scale + 0.0;
            let high = (high * factor * scale + 1e-6).floor() / scale;
            let value = value * factor;
            let d = decimals as usize;
            (
                format!("{channel}: {name} {value:.d$}{unit} is outside {low:.d$} to {high:.d$}{unit}"),
                format!("choose a {name} in that range; [channel.limits] and the wire's own stroke bound it"),
            )
        }
        Reason::HoldOutOfRange { low, high } => (
            format!("{channel}: that hold is outside {low} to {high} s"),
            format!("choose --hold from {low} to {high}; maximum_hold_s in [channel.limits] bounds it"),
        ),
        _ => (refusal.message(), refusal.remedy()),
    }
}

/// The same in one line.
fn sentence(error: &Error) -> String {
    match words(error) {
        (message, remedy) if remedy.is_empty() => message,
        (message, remedy) => format!("{message}; {remedy}"),
    }
}

/// A setpoint for a channel as the driver takes it: kind and value in SI.
pub fn command(setpoint: Setpoint, channel: &ChannelInfo) -> (CommandKind, f64) {
    match setpoint {
        Setpoint::Length(m) => (CommandKind::Length, m),
        Setpoint::Stroke(share) => (CommandKind::Stroke, share),
        Setpoint::Way(m) => (CommandKind::Stroke, m / (channel.cold_length_m - channel.hot_length_m).abs()),
        Setpoint::Duty(duty) => (CommandKind::Duty, duty),
        Setpoint::Force(n) => (CommandKind::Force, n),
        Setpoint::Off => (CommandKind::Off, 0.0),
    }
}

/// Looks at a driver again and again.
pub struct Live {
    client: Client,
    /// Cycle and time of an earlier look, ns: for the rate.
    earlier: Option<(u64, u64)>,
    rate_hz: f64,
    /// What is used of each wire's life, and when that was read.
    lives: Vec<Option<String>>,
    lives_read: Option<Instant>,
}

/// Accounts of wires are written each minute: looked at so often.
const LIVES_EVERY: Duration = Duration::from_secs(20);
/// The rate is taken over at least this long, ns.
const RATE_SPAN_NS: u64 = 1_000_000_000;

impl Live {
    /// Over a connection.
    pub fn new(client: Client) -> Live {
        Live { client, earlier: None, rate_hz: f64::NAN, lives: Vec::new(), lives_read: None }
    }

    /// The connection.
    pub fn client(&self) -> &Client {
        &self.client
    }

    /// One look.
    pub fn look(&mut self) -> View {
        let snapshot = self.client.latest();
        let stats = self.client.loop_stats();
        match self.earlier {
            Some((cycle, at_ns)) if snapshot.monotonic_ns >= at_ns + RATE_SPAN_NS => {
                let span_s = (snapshot.monotonic_ns - at_ns) as f64 * 1e-9;
                self.rate_hz = snapshot.cycle.saturating_sub(cycle) as f64 / span_s;
                self.earlier = Some((snapshot.cycle, snapshot.monotonic_ns));
            }
            None if snapshot.cycle > 0 => self.earlier = Some((snapshot.cycle, snapshot.monotonic_ns)),
            _ => {}
        }
        if self.lives_read.is_none_or(|read| read.elapsed() >= LIVES_EVERY) {
            let info = self.client.info();
            let names = self.client.channels().iter().map(|info| info.name.to_string());
            self.lives = life::used(&info.rig.to_string(), info.simulated != 0, names);
            self.lives_read = Some(Instant::now());
        }
        let mut view = view(&self.client, &snapshot, &stats, self.rate_hz);
        for (row, life) in view.channels.iter_mut().zip(&self.lives) {
            row.life.clone_from(life);
        }
        view
    }

    /// Commands a channel for so long; says what was taken, or why not and what to do.
    pub fn set(&self, channel: usize, setpoint: Setpoint, hold: Duration) -> Result<String, String> {
        let (kind, value) = command(setpoint, &self.client.channels()[channel]);
        match self.client.command(channel as u32, kind, value, hold) {
            Ok(_) => Ok(format!("{}: {setpoint}", self.name(channel))),
            Err(error) => Err(sentence(&error)),
        }
    }

    /// Clears a channel's fault; says so, or why not and what to do.
    pub fn reset(&self, channel: usize) -> Result<String, String> {
        match self.client.command(channel as u32, CommandKind::Reset, 0.0, Duration::ZERO) {
            Ok(_) => Ok(format!("{}: reset", self.name(channel))),
            Err(error) => Err(sentence(&error)),
        }
    }

    /// Why there is nothing more to see, once that is so.
    pub fn ended(&self) -> Option<DriverHealth> {
        match self.client.health() {
            ended @ (DriverHealth::Stopped | DriverHealth::Died) => Some(ended),
            _ => None,
        }
    }

    fn name(&self, channel: usize) -> &str {
        self.client.channels().get(channel).map_or("?", |info| info.name.as_str())
    }
}

/// The budget that holds the duty back, if one does.
fn held_by(flags: u32) -> Option<&'static str> {
    match flags {
        _ if flags & ChannelState::FLAG_HEAT_BUDGET != 0 => Some("heat"),
        _ if flags & ChannelState::FLAG_TEMPERATURE_BUDGET != 0 => Some("temperature"),
        _ => None,
    }
}

/// What a client sees, for the screen and for `status`.
fn view(client: &Client, snapshot: &Snapshot, stats: &LoopStats, rate_hz: f64) -> View {
    let info = client.info();
    let seconds = |ns: u64| ns as f64 * 1e-9;
    let channels = client.channels().iter().zip(snapshot.channels()).map(|(info, state)| Row {
        name: info.name.to_string(),
        cold_m: info.cold_length_m,
        hot_m: info.hot_length_m,
        state: *state,
        fault: state.fault().map(Fault::row),
        held_by: held_by(state.flags),
        health: u8::try_from(state.health)
            .ok()
            .and_then(Health::from_code)
            .filter(|health| !health.is_ok())
            .map(Health::describe),
        life: None,
    });
    View {
        rig: info.rig.to_string(),
        pid: info.pid,
        rate_hz: info.rate_hz,
        cycle: snapshot.cycle,
        uptime_s: seconds(snapshot.monotonic_ns.saturating_sub(info.started_ns)),
        age_s: client.age().as_secs_f64(),
        channels: channels.collect(),
        timing: Timing {
            rate_hz,
            missed: snapshot.missed,
            lateness_us: Quantiles::of(&stats.lateness),
            cycle_us: Quantiles::of(&stats.cycle_time),
            allocations: stats.allocations,
            dead: stats.dead_threads().collect(),
            realtime: LoopStats::REALTIME.map(|(bit, name)| (name, stats.realtime & bit != 0)).to_vec(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(kind: CommandKind, value: f64, reason: Reason) -> Error {
        Error::Refused(Refusal { channel: "knee".into(), kind, value, reason })
    }

    #[test]
    fn refusals_speak_in_the_units_that_are_typed() {
        let range = Reason::OutOfRange { low: 0.160_530_1, high: 0.167_046_9 };
        let (message, hint) = words(&refused(CommandKind::Length, 0.155, range));
        assert_eq!(message, "knee: length 155.00 mm is outside 160.54 to 167.04 mm");
        assert!(hint.contains("choose a length"), "{hint}");
        let (message, _) = words(&refused(CommandKind::Stroke, 1.2, Reason::OutOfRange { low: 0.0, high: 1.0 }));
        assert_eq!(message, "knee: stroke 120.0 % is outside 0.0 to 100.0 %");
        let (message, hint) = words(&refused(CommandKind::Duty, 0.1, Reason::HoldOutOfRange { low: 0.01, high: 60.0 }));
        assert_eq!(message, "knee: that hold is outside 0.01 to 60 s");
        assert!(hint.contains("--hold from 0.01 to 60"), "{hint}");
    }

    #[test]
    fn a_wrong_rig_name_is_the_users_slip_and_no_driver_at_all_is_not() {
        let error = |running: &[&str]| {
            let running = running.iter().map(ToString::to_string).collect();
            failure(Error::NotRunning { rig: "hexapood".into(), running })
        };
        assert_eq!(error(&["hexapod"]).code(), 2);
        assert_eq!(error(&[]).code(), 1);
    }
}
