//! Connection of the commands to a running driver: selecting it, its state, its answers.

use std::time::{Duration, Instant};

use sinew_driver::report::Quantiles;
use sinew_ipc::{ChannelInfo, Client, CommandKind, DriverHealth, Error, Fault, LoopStats, Reason, Refusal, Snapshot};
use sinew_sensing::Health;

use super::life;
use crate::args::Target;
use crate::commands::list;
use crate::driving::screen::view::{Account, HeldBack, Row, Timing, View};
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
    failure_of(error, &[])
}

/// The same of a request for these setpoints: refused values and ranges in the units they were given in.
pub fn failure_of(error: Error, asked: &[Asked<'_>]) -> Failure {
    // an unknown name while other drivers run is a user error
    let slip = matches!(&error, Error::NotRunning { running, .. } if !running.is_empty());
    let (message, remedy) = words(&error, asked);
    let failure = if error.is_bad_input() || slip { Failure::input(message) } else { Failure::own(message) };
    if remedy.is_empty() { failure } else { failure.hint(remedy) }
}

/// A setpoint that a channel was asked for.
pub type Asked<'a> = (&'a ChannelInfo, Setpoint);

/// What is wrong with a setpoint for a channel by the limits that it publishes, and what to do; `None` where nothing is. Forces only the driver judges.
pub fn beyond((info, setpoint): Asked<'_>) -> Option<(String, String)> {
    let (kind, value) = command(setpoint, info);
    let (low, high) = match kind {
        CommandKind::Length => (info.min_length_m, info.max_length_m),
        CommandKind::Stroke => (0.0, 1.0),
        CommandKind::Duty => (0.0, info.max_duty),
        _ => return None,
    };
    // as generous as the driver is with what rounding leaves
    let slack = 1e-9;
    let reason = Reason::OutOfRange { low, high };
    let refusal = Refusal { channel: info.name.to_string(), kind, value, reason };
    (value < low - slack || value > high + slack).then(|| words_of(&refusal, &[(info, setpoint)]))
}

/// An error in words and what to do about it.
fn words(error: &Error, asked: &[Asked<'_>]) -> (String, String) {
    match error {
        Error::Refused(refusal) => words_of(refusal, asked),
        Error::RefusedTogether(refusals) => {
            let (messages, remedies): (Vec<_>, Vec<_>) =
                refusals.iter().map(|refusal| words_of(refusal, asked)).unzip();
            let message = match messages.as_slice() {
                [only] => only.clone(),
                several => format!("{}; nothing was carried out", several.join("; ")),
            };
            (message, remedies.into_iter().next().unwrap_or_default())
        }
        _ => (error.message(), error.remedy()),
    }
}

fn words_of(refusal: &Refusal, asked: &[Asked<'_>]) -> (String, String) {
    let Refusal { channel, kind, value, reason } = refusal;
    let asked = asked.iter().find(|(info, _)| info.name.as_str() == channel);
    let setpoint = match (asked, kind) {
        (Some((_, setpoint)), _) => Some(*setpoint),
        (None, CommandKind::Length) => Some(Setpoint::Length(*value)),
        (None, CommandKind::Stroke) => Some(Setpoint::Stroke(*value)),
        (None, CommandKind::Duty) => Some(Setpoint::Duty(*value)),
        (None, CommandKind::Force) => Some(Setpoint::Force(*value)),
        (None, _) => None,
    };
    match (*reason, setpoint) {
        (Reason::OutOfRange { low, high }, Some(setpoint)) => {
            let stroke_m = asked.map_or(f64::NAN, |(info, _)| stroke_m(info));
            let (outside, nearest) = setpoint.outside(low, high, stroke_m);
            (
                format!("{channel}: {outside}"),
                format!("the nearest is {nearest}; [channel.limits] and the wire's own stroke bound it"),
            )
        }
        (Reason::HoldOutOfRange { low, high }, _) => (
            format!("{channel}: that hold is outside {low} to {high} s"),
            format!("choose --hold from {low} to {high}; maximum_hold_s in [channel.limits] bounds it"),
        ),
        _ => (refusal.message(), refusal.remedy()),
    }
}

/// The same in one line.
fn sentence(error: &Error, asked: &[Asked<'_>]) -> String {
    match words(error, asked) {
        (message, remedy) if remedy.is_empty() => message,
        (message, remedy) => format!("{message}; {remedy}"),
    }
}

/// How long a channel's stroke is, m.
fn stroke_m(channel: &ChannelInfo) -> f64 {
    (channel.cold_length_m - channel.hot_length_m).abs()
}

/// A setpoint for a channel as the driver takes it: kind and value in SI.
pub fn command(setpoint: Setpoint, channel: &ChannelInfo) -> (CommandKind, f64) {
    match setpoint {
        Setpoint::Length(m) => (CommandKind::Length, m),
        Setpoint::Stroke(share) => (CommandKind::Stroke, share),
        Setpoint::Way(m) => (CommandKind::Stroke, m / stroke_m(channel)),
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
    /// What held each channel back when something last did, and when that was.
    held: Vec<Option<(HeldBack, Instant)>>,
    /// What each wire's account comes to, and when that was read.
    accounts: Vec<Option<Account>>,
    accounts_read: Option<Instant>,
}

/// Accounts of wires are written each minute: looked at so often.
const ACCOUNTS_EVERY: Duration = Duration::from_secs(20);
/// What holds a channel back is shown for so long: where a law switches its duty on and off, so do the flags, cycle by cycle.
const HELD_SHOWS: Duration = Duration::from_secs(1);
/// The rate is taken over at least this long, ns.
const RATE_SPAN_NS: u64 = 1_000_000_000;

impl Live {
    /// Over a connection.
    pub fn new(client: Client) -> Live {
        Live { client, earlier: None, rate_hz: f64::NAN, held: Vec::new(), accounts: Vec::new(), accounts_read: None }
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
        if self.accounts_read.is_none_or(|read| read.elapsed() >= ACCOUNTS_EVERY) {
            let info = self.client.info();
            let names = self.client.channels().iter().map(|info| info.name.to_string());
            self.accounts = life::used(&info.rig.to_string(), info.simulated != 0, names);
            self.accounts_read = Some(Instant::now());
        }
        let mut view = view(&self.client, &snapshot, &stats, self.rate_hz);
        self.held.resize(view.channels.len(), None);
        for ((row, account), held) in view.channels.iter_mut().zip(&self.accounts).zip(&mut self.held) {
            row.account.clone_from(account);
            let before = held.filter(|(_, seen)| seen.elapsed() < HELD_SHOWS);
            *held = match (row.held_by, before) {
                // a dark period of one that is held back for another reason
                (Some(HeldBack::Cooling), Some((before, _))) => Some((before, Instant::now())),
                (Some(now), _) => Some((now, Instant::now())),
                (None, before) => before,
            };
            row.held_by = held.map(|(held, _)| held);
        }
        view
    }

    /// Commands a channel for so long; says what was taken, or why not and what to do.
    pub fn set(&self, channel: usize, setpoint: Setpoint, hold: Duration) -> Result<String, String> {
        let info = &self.client.channels()[channel];
        let (kind, value) = command(setpoint, info);
        match self.client.command(channel as u32, kind, value, hold) {
            Ok(_) => Ok(format!("{}: {setpoint}", info.name)),
            Err(error) => Err(sentence(&error, &[(info, setpoint)])),
        }
    }

    /// Clears a channel's fault; says so, or why not and what to do.
    pub fn reset(&self, channel: usize) -> Result<String, String> {
        match self.client.command(channel as u32, CommandKind::Reset, 0.0, Duration::ZERO) {
            Ok(_) => Ok(format!("{}: reset", self.name(channel))),
            Err(error) => Err(sentence(&error, &[])),
        }
    }

    /// Asks the driver to stop; says so, or why not and what to do.
    pub fn stop(&self) -> Result<String, String> {
        match self.client.stop() {
            // another client was quicker
            Ok(_) | Err(Error::DriverGone { .. }) => Ok("the driver stops, outputs at zero".into()),
            Err(error) => Err(sentence(&error, &[])),
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

/// What a client sees, for the screen and for `status`.
fn view(client: &Client, snapshot: &Snapshot, stats: &LoopStats, rate_hz: f64) -> View {
    let info = client.info();
    let seconds = |ns: u64| ns as f64 * 1e-9;
    let channels = client.channels().iter().zip(snapshot.channels()).map(|(info, state)| Row {
        name: info.name.to_string(),
        cold_m: info.cold_length_m,
        hot_m: info.hot_length_m,
        limit_c: info.max_temperature_c,
        state: *state,
        fault: state.fault().map(Fault::row),
        held_by: HeldBack::of(info, state),
        health: u8::try_from(state.health)
            .ok()
            .and_then(Health::from_code)
            .filter(|health| !health.is_ok())
            .map(Health::describe),
        account: None,
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
    use sinew_ipc::Name;

    use super::*;

    fn refused(kind: CommandKind, value: f64, reason: Reason) -> Error {
        Error::Refused(Refusal { channel: "knee".into(), kind, value, reason })
    }

    fn knee() -> ChannelInfo {
        ChannelInfo {
            name: Name::new("knee").unwrap(),
            cold_length_m: 0.169,
            hot_length_m: 0.160,
            min_length_m: 0.161,
            max_length_m: 0.169,
            max_duty: 0.5,
            ..ChannelInfo::EMPTY
        }
    }

    #[test]
    fn a_setpoint_beyond_the_published_limits_is_found_before_it_is_sent() {
        let info = knee();
        for within in
            [Setpoint::Way(0.009), Setpoint::Stroke(1.0), Setpoint::Length(0.161), Setpoint::Duty(0.5), Setpoint::Off]
        {
            assert_eq!(beyond((&info, within)), None);
        }
        for (setpoint, nearest) in [
            (Setpoint::Way(0.012), "stroke=9.00mm"),
            (Setpoint::Length(0.1605), "length=161.00mm"),
            (Setpoint::Length(0.2), "length=169.00mm"),
            (Setpoint::Duty(0.6), "duty=0.500"),
        ] {
            let (message, hint) = beyond((&info, setpoint)).expect("it is beyond");
            assert!(message.starts_with("knee: ") && hint.contains(nearest), "{message}; {hint}");
        }
    }

    #[test]
    fn refusals_speak_in_the_units_that_are_typed() {
        let range = Reason::OutOfRange { low: 0.160_530_1, high: 0.167_046_9 };
        let (message, hint) = words(&refused(CommandKind::Length, 0.155, range), &[]);
        assert_eq!(message, "knee: length 155.00 mm is outside 160.54 to 167.04 mm");
        assert!(hint.contains("the nearest is length=160.54mm"), "{hint}");
        let share = Reason::OutOfRange { low: 0.0, high: 1.0 };
        let (message, _) = words(&refused(CommandKind::Stroke, 1.2, share), &[]);
        assert_eq!(message, "knee: stroke 120.0 % is outside 0.0 to 100.0 %");
        // the same share, asked for as a way
        let info = knee();
        let (message, hint) = words(&refused(CommandKind::Stroke, 1.2, share), &[(&info, Setpoint::Way(0.0108))]);
        assert_eq!(message, "knee: stroke 10.80 mm is outside 0.00 to 9.00 mm");
        assert!(hint.contains("the nearest is stroke=9.00mm"), "{hint}");
        let (message, hint) =
            words(&refused(CommandKind::Duty, 0.1, Reason::HoldOutOfRange { low: 0.01, high: 60.0 }), &[]);
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
