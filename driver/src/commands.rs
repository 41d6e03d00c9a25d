//! Handles the clients' requests on an ordinary thread: validates them, passes them to the loop, and answers when the loop has
//! accepted them or with the reason for the refusal.
//!
//! This module alone validates requests; what only the loop can know (a latched fault, whether its cause is gone) comes
//! back from it as an answer. Rules:
//!
//! - Read-only clients may command nothing, members of a stop group nothing but `stop`.
//! - A setpoint needs a channel that exists, finite numbers, a value inside the channel's limits, a hold of one period to
//!   `max_lease_s` (0 = the channel's default).
//! - Lengths are taken between the hot and the cold end of the stroke, as far as the rig's limits allow; strokes from 0 to 1; duties
//!   from 0 (which is the sensing pulse) to `max_duty`; forces only against a spring, where they mean a length.
//! - `off` holds until the next command unless it has a hold time. `off`, `reset` and `stop` may address all channels.
//! - `stop` is answered at once, and before all others; every other request waits for the loop.
//! - Setpoints and `off` for several channels in one request are taken by all or by none, from the same cycle on and with one lease, the shortest
//!   of those they would be granted alone.
//! - Setpoints and resets for a channel that another client has claimed are refused; `off` and `stop` are not (`claims.rs`).
//! - A request that comes after its deadline is refused, and so is one the loop has not begun with by then. Of a stream of setpoints the newest
//!   overtakes those before it that still wait. A request that only switches off is never too late: the loop carries it out as soon as it can.
//! - Setpoints may be approached in a time no longer than their lease; the tension of a joint may not.
//! - `off` overtakes: what was asked of its channel before it and still waits is not carried out, nor is what was answered *busy*.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use sinew_control::{JointLaw, StrokeRange, length_for_force};
use sinew_ipc::{
    ALL_CHANNELS, Asker, Command, CommandKind, CommandServer, Fault, MOST_PRIORITY, Outcome, Reply, Request, Terms,
};
use sinew_physics::WireModel;
use sinew_rig::Rig;
use sinew_ring::Consumer;

use crate::claims::{Claim, Claims};
use crate::cycles::Shared;
use crate::error::Error;
use crate::fault_log::FaultLog;
use crate::inbox::Outbox;
use crate::orders::{Answer, Ask, Occurrence, Told};
use crate::setup::joint_algorithm;
use crate::supervisor::Cooldown;

/// How often everything is looked after while no request is under way: clients of the gateway, events of the loop, the end. The own user's
/// clients ring.
const IDLE_PERIOD: Duration = Duration::from_millis(1);
/// How often the loop's answers are looked for while a request is new, and while one waits for longer than a cycle takes: for a channel that
/// proves itself, or a loop that is held up.
const BUSY_PERIOD: Duration = Duration::from_micros(50);
const WAITING_PERIOD: Duration = Duration::from_micros(500);
const NEW: Duration = Duration::from_millis(5);
/// Requests taken in one round.
const REQUESTS_A_ROUND: usize = 256;
/// How long the loop may take to answer, besides the time a channel may take to prove itself.
const PATIENCE: Duration = Duration::from_secs(2);
/// A duty or stroke this far outside is rounding, not a mistake.
const ROUNDING: f64 = 1e-9;

/// What a channel's requests are checked against.
#[derive(Debug, Clone)]
pub struct ChannelRules {
    model: WireModel,
    /// Least and most tension that may be asked for in its joint, N; `None` where it has a load of its own, or the joint's law knows nothing
    /// of the tension.
    joint_tension_n: Option<(f64, f64)>,
    /// Its stroke.
    pub stroke: StrokeRange,
    /// Shortest length that may be asked for, m.
    pub min_length_m: f64,
    /// Longest length that may be asked for, m.
    pub max_length_m: f64,
    /// Largest duty.
    pub max_duty: f64,
    /// Lease of a setpoint that names none, s.
    pub lease_s: f64,
    /// Shortest lease, s: one period.
    pub min_lease_s: f64,
    /// Longest lease, s.
    pub max_lease_s: f64,
}

impl ChannelRules {
    /// The rules of each channel of a rig.
    ///
    /// # Errors
    /// [`Error::Rig`]: a model whose stroke cannot be worked out.
    pub fn of(rig: &Rig) -> Result<Vec<ChannelRules>, Error> {
        rig.channels
            .iter()
            .enumerate()
            .map(|(index, channel)| {
                let model = rig.nominal_model(index);
                let stroke = StrokeRange::of(&model)
                    .map_err(|e| Error::Rig { place: channel.name.clone(), reason: e.to_string() })?;
                let limits = &channel.limits;
                let (short_m, long_m) = (stroke.hot_m.min(stroke.cold_m), stroke.hot_m.max(stroke.cold_m));
                Ok(ChannelRules {
                    model,
                    joint_tension_n: rig
                        .joint_of(index)
                        .filter(|(joint, _)| joint_algorithm(joint).takes_tension())
                        .map(|(joint, _)| (joint.min_tension_n, JointLaw::MOST_TENSION * joint.max_tension_n)),
                    stroke,
                    // A length the wire cannot reach would only overheat it.
                    min_length_m: limits.min_length_m.max(short_m),
                    max_length_m: limits.max_length_m.min(long_m),
                    max_duty: limits.max_duty,
                    lease_s: limits.lease_s,
                    min_lease_s: 1.0 / rig.rate_hz,
                    max_lease_s: limits.max_lease_s,
                })
            })
            .collect()
    }

    fn within(&self, command: &Command, value: f64, low: f64, high: f64) -> Result<f64, Reply> {
        let slack = ROUNDING * (high - low).abs().max(1.0);
        if value >= low - slack && value <= high + slack {
            Ok(value.clamp(low.min(high), high.max(low)))
        } else {
            Err(Reply::refused(command, Outcome::OutOfRange).range(low, high).because(Fault::SetpointOutOfRange))
        }
    }

    /// Force at a length of the load at rest, N: the inverse of [`length_for_force`].
    fn force_n(&self, length_m: f64) -> f64 {
        self.model.load.pull_at_rest_n(length_m - self.model.geometry.length_m).unwrap_or(f64::NAN)
    }

    /// Judges a request for this channel as a client may send it: any bytes at all. `None` where they are not as many as a request has.
    /// Whatever the bits, it neither panics nor lets anything through but finite values inside the channel's limits.
    pub fn judge(&self, bytes: &[u8]) -> Option<Result<(Ask, f64), Reply>> {
        Command::from_bytes(bytes).map(|command| self.check(&command))
    }

    /// Checks a request for this channel: what to ask of the loop and the lease, s (0: until the next command).
    ///
    /// # Errors
    /// The refusal to send back.
    pub fn check(&self, command: &Command) -> Result<(Ask, f64), Reply> {
        let Some(kind) = command.kind() else { return Err(Reply::refused(command, Outcome::UnknownCommand)) };
        let has_value =
            matches!(kind, CommandKind::Length | CommandKind::Stroke | CommandKind::Duty | CommandKind::Force);
        if !command.hold_s.is_finite() || (has_value && !command.value.is_finite()) {
            let refusal = Reply::refused(command, Outcome::NotFinite);
            return Err(if has_value { refusal.because(Fault::SetpointOutOfRange) } else { refusal });
        }
        let ask = match kind {
            CommandKind::Length => {
                Ask::Length(self.within(command, command.value, self.min_length_m, self.max_length_m)?)
            }
            CommandKind::Stroke => {
                let stroke = self.within(command, command.value, 0.0, 1.0)?;
                // A limit may shorten the stroke at its ends.
                let length_m = self.stroke.length_m(stroke).clamp(self.min_length_m, self.max_length_m);
                Ask::Length(length_m)
            }
            CommandKind::Duty => Ask::Duty(self.within(command, command.value, 0.0, self.max_duty)?),
            CommandKind::Force => match self.joint_tension_n {
                Some((low, high)) => Ask::Tension(self.within(command, command.value, low, high)?),
                None => {
                    let length_m = length_for_force(&self.model, command.value)
                        .map_err(|_| Reply::refused(command, Outcome::Unsupported))?;
                    if !(self.min_length_m..=self.max_length_m).contains(&length_m) {
                        // Longer is less force.
                        let (low, high) = (self.force_n(self.max_length_m), self.force_n(self.min_length_m));
                        self.within(command, command.value, low, high)?;
                    }
                    Ask::Force(length_m.clamp(self.min_length_m, self.max_length_m))
                }
            },
            CommandKind::Off => Ask::Off,
            CommandKind::Reset => return Ok((Ask::Reset, 0.0)),
            // Not for a channel; already handled by the command thread.
            CommandKind::Stop | CommandKind::Claim | CommandKind::Release => {
                return Err(Reply::refused(command, Outcome::UnknownCommand));
            }
        };
        let hold_s = match command.hold_s {
            0.0 if ask == Ask::Off => 0.0,
            _ => self.lease(command)?,
        };
        Ok((ask, hold_s))
    }

    /// The lease that is granted for what was asked, s.
    fn lease(&self, command: &Command) -> Result<f64, Reply> {
        match command.hold_s {
            0.0 => Ok(self.lease_s),
            hold_s if hold_s >= self.min_lease_s * (1.0 - ROUNDING) && hold_s <= self.max_lease_s => Ok(hold_s),
            _ => {
                let refusal = Reply::refused(command, Outcome::HoldOutOfRange);
                Err(refusal.range(self.min_lease_s, self.max_lease_s))
            }
        }
    }

    /// Checks a claim of this channel: its priority, and how long it is to hold without a word of its owner, s.
    fn check_claim(&self, command: &Command) -> Result<(u32, f64), Reply> {
        if !command.hold_s.is_finite() || !command.value.is_finite() {
            return Err(Reply::refused(command, Outcome::NotFinite));
        }
        let most = f64::from(MOST_PRIORITY);
        if !(0.0..=most).contains(&command.value) || command.value.fract() != 0.0 {
            return Err(Reply::refused(command, Outcome::OutOfRange).range(0.0, most));
        }
        Ok((command.value as u32, self.lease(command)?))
    }
}

/// A request the loop has not answered yet.
struct Waiting {
    request: Request,
    /// Answers still missing: more than one where it is for several channels.
    missing: usize,
    /// The answers so far, one for each of its commands.
    replies: Vec<Reply>,
    since: Instant,
}

/// Where requests come in and answers go out.
pub(crate) struct Desk {
    pub port: Option<CommandServer>,
    pub rules: Vec<ChannelRules>,
    pub names: Vec<String>,
    pub outbox: Outbox,
    pub events: Consumer<Told>,
    pub claims: Claims,
    /// The newest message of each stream there was no room for on the way into the loop: what was taken back takes some until the next cycle.
    pub held: Vec<Request>,
}

impl Desk {
    /// Serves until the loop has ended and everything that was under way is answered.
    pub fn serve(mut self, shared: &Shared, fault_log: &Mutex<FaultLog>) {
        let mut waiting: HashMap<u64, Waiting> = HashMap::new();
        loop {
            // Read before the events, so that the last of them are not left behind.
            let ended = shared.ended.load(Ordering::Acquire);
            let stopping = ended || shared.stop.load(Ordering::Relaxed);

            let mut something_happened = false;
            while let Some(Told { cycle, event }) = self.events.pop() {
                if let Occurrence::Answered { ticket, answer } = event.what {
                    self.answered(&mut waiting, ticket, event.channel, cycle, answer, shared);
                } else {
                    fault_log.lock().unwrap_or_else(PoisonError::into_inner).note(&event, &self.names);
                    something_happened = true;
                }
            }
            // A round later: the loop may be in the middle of telling what came to one channel after the other.
            if ended || !something_happened {
                fault_log.lock().unwrap_or_else(PoisonError::into_inner).say(&self.names);
            }
            // A limited batch: a flood of requests does not delay the handling of the loop's answers.
            let mut requests: Vec<Request> =
                (0..REQUESTS_A_ROUND).map_while(|_| self.port.as_mut()?.receive()).collect();
            requests.sort_by_key(|request| !is_stop(request));
            // What was held comes before what is new, so that it is overtaken by that.
            for request in std::mem::take(&mut self.held).into_iter().chain(requests) {
                let stopping = stopping || shared.stop.load(Ordering::Relaxed);
                self.take(request, stopping, &mut waiting, shared);
            }
            let now = Instant::now();
            self.claims.look(now, &shared.claims);
            let now_ns = sinew_ipc::monotonic_ns();
            // Nobody waits any more for what is late, and for what a loop is held up with it is answered. What switches off stays.
            let is_given_up = |w: &Waiting| now - w.since >= PATIENCE || w.request.is_late(now_ns).is_some();
            let is_over = |w: &Waiting| ended || !w.request.only_switches_off() && is_given_up(w);
            let over: Vec<u64> = waiting.iter().filter(|(_, w)| is_over(w)).map(|(ticket, _)| *ticket).collect();
            for ticket in over {
                // One that has begun is answered by what comes of it.
                if !self.outbox.take_back(ticket) && !ended {
                    continue;
                }
                let Some(w) = waiting.remove(&ticket) else { continue };
                let late = w.request.is_late(now_ns);
                let outcome = if ended { Outcome::Stopping } else { late.unwrap_or(Outcome::Busy) };
                refuse_all(shared, w.request, |command| Reply::refused(command, outcome));
            }
            if ended || sinew_threads::is_struck() {
                return;
            }
            match &self.port {
                _ if !self.held.is_empty() || waiting.values().any(|w| now - w.since < NEW) => {
                    std::thread::sleep(BUSY_PERIOD);
                }
                Some(port) => port.wait(if waiting.is_empty() { IDLE_PERIOD } else { WAITING_PERIOD }),
                None => std::thread::sleep(IDLE_PERIOD),
            }
        }
    }

    fn take(&mut self, request: Request, stopping: bool, waiting: &mut HashMap<u64, Waiting>, shared: &Shared) {
        if !request.is_permitted() {
            return refuse_all(shared, request, |command| Reply::refused(command, Outcome::NotPermitted));
        }
        if is_stop(&request) {
            let command = request.commands()[0];
            tracing::info!(client = command.client >> 32, "stop asked for");
            shared.stop.store(true, Ordering::Relaxed);
            return request.reply(vec![Reply::taken(&command, 0.0)]);
        }
        if stopping {
            let stopping = |command: &Command| Reply::refused(command, Outcome::Stopping).because(Fault::Stopping);
            return refuse_all(shared, request, stopping);
        }
        if let Some(outcome) = request.is_late(sinew_ipc::monotonic_ns()) {
            return refuse_all(shared, request, |command| Reply::refused(command, outcome));
        }
        self.overtake(&request, waiting);
        if let Some(kind) = claims_or_releases(&request) {
            return self.hand_on(request, kind, shared);
        }
        let (asker, now) = (request.asker(), Instant::now());
        let terms = request.terms();
        // What is approached, or overtakes, goes as a request for several channels does, be it for one.
        let is_single = terms == Terms::until(terms.until_ns) && request.commands().len() == 1;
        let judged = match request.commands() {
            [command] if is_single => self.judge(command, asker, now).map_err(|reply| vec![reply]),
            several => self.judge_together(several, asker, now).and_then(|checked| approach(several, checked, terms)),
        };
        let Checked { orders, hold_s } = match judged {
            Ok(checked) => checked,
            Err(replies) => return refuse(shared, request, replies),
        };
        let missing = orders.len();
        let is_off = orders.iter().all(|(_, ask, _)| *ask == Ask::Off);
        let sent = if is_single || is_off {
            self.outbox.send(orders.into_iter(), is_off)
        } else {
            self.outbox.send_together(&orders, (terms.over_s * 1e9) as u64)
        };
        let Some(ticket) = sent else {
            if terms.stream != 0 {
                return self.held.push(request);
            }
            return refuse_all(shared, request, |command| Reply::refused(command, Outcome::Busy));
        };
        request.commands().iter().for_each(|command| self.claims.renew(command.channel as usize, asker, now));
        let replies = request.commands().iter().map(|command| Reply::taken(command, hold_s)).collect();
        waiting.insert(ticket, Waiting { request, missing, replies, since: Instant::now() });
    }

    /// A message of a stream takes back those before it that the loop has not begun with; and whatever else is asked for what is held, for it would
    /// come into the loop after that. What switches off is never overtaken: the loop has a lane for it, before all others.
    fn overtake(&mut self, request: &Request, waiting: &mut HashMap<u64, Waiting>) {
        let (asker, stream) = (request.asker(), request.terms().stream);
        let is_held_on = |held: &Request| {
            held.only_switches_off() || stream != 0 && (held.terms().stream, held.asker()) != (stream, asker)
        };
        let (held, overtaken) = std::mem::take(&mut self.held).into_iter().partition(is_held_on);
        self.held = held;
        overtaken.into_iter().for_each(reply_overtaken);
        if stream == 0 {
            return;
        }
        let is_before = |w: &Waiting| {
            (w.request.terms().stream, w.request.asker()) == (stream, asker) && !w.request.only_switches_off()
        };
        let before: Vec<u64> = waiting.iter().filter(|(_, w)| is_before(w)).map(|(ticket, _)| *ticket).collect();
        for ticket in before {
            if self.outbox.take_back(ticket)
                && let Some(w) = waiting.remove(&ticket)
            {
                reply_overtaken(w.request);
            }
        }
    }

    /// Checks the command of a request that has one; it may be for all channels, and is taken by all or by none then.
    fn judge(&self, command: &Command, asker: Asker, now: Instant) -> Result<Checked, Reply> {
        let for_all =
            command.channel == ALL_CHANNELS && matches!(command.kind(), Some(CommandKind::Off | CommandKind::Reset));
        let channels = match command.channel as usize {
            _ if for_all => 0..self.rules.len(),
            channel if channel < self.rules.len() => channel..channel + 1,
            _ => return Err(Reply::refused(command, Outcome::UnknownChannel)),
        };
        let mut checked = Checked::nothing();
        for channel in channels {
            let granted = self.check(channel, command, asker, now);
            checked.add(channel, granted.map_err(|reply| Reply { channel: channel as u32, ..reply })?);
        }
        Ok(checked)
    }

    /// Checks a command for this channel by its rules, and by who has claimed it: switching off is everybody's.
    fn check(&self, channel: usize, command: &Command, asker: Asker, now: Instant) -> Result<(Ask, f64), Reply> {
        let granted = self.rules[channel].check(command)?;
        match self.claims.against(channel, asker, now) {
            Some(claim) if granted.0 != Ask::Off => Err(refused_by(command, &claim, now)),
            _ => Ok(granted),
        }
    }

    /// Claims of channels, or releases: all of them or none, and at once, for the loop has no part in them.
    fn hand_on(&mut self, request: Request, kind: CommandKind, shared: &Shared) {
        let (asker, now) = (request.asker(), Instant::now());
        let mut is_named = vec![false; self.rules.len()];
        let mut check = |command: &Command| -> Result<(usize, u32, f64), Reply> {
            let channel = once(&mut is_named, command)?;
            if kind == CommandKind::Release {
                return Ok((channel, 0, 0.0));
            }
            let (priority, hold_s) = self.rules[channel].check_claim(command)?;
            match self.claims.against_claim(channel, asker, priority, now) {
                Some(claim) => Err(refused_by(command, &claim, now)),
                None => Ok((channel, priority, hold_s)),
            }
        };
        let verdicts: Vec<_> = request.commands().iter().map(&mut check).collect();
        if verdicts.iter().any(Result::is_err) {
            let replies = with_others(request.commands(), &verdicts);
            return refuse(shared, request, replies);
        }
        let granted: Vec<_> = verdicts.into_iter().flatten().collect();
        // one lease for all: the shortest
        let hold_s = granted.iter().map(|(.., hold_s)| *hold_s).fold(f64::INFINITY, f64::min);
        for (channel, priority, _) in granted {
            if kind == CommandKind::Release {
                self.claims.release(channel, asker);
                continue;
            }
            let lost = self.claims.give(channel, asker, priority, Duration::from_secs_f64(hold_s), now);
            if let Some(lost) = lost {
                let (channel, from, to) = (&self.names[channel], lost.owner.pid, asker.pid);
                tracing::info!(channel, from, to, priority, "taken over");
            }
        }
        self.claims.look(now, &shared.claims);
        let replies = request.commands().iter().map(|command| Reply::taken(command, hold_s)).collect();
        request.reply(replies);
    }

    /// Checks the commands of a request that has several: each on its own, and all of them together.
    fn judge_together(&self, commands: &[Command], asker: Asker, now: Instant) -> Result<Checked, Vec<Reply>> {
        let mut checked = Checked::nothing();
        let mut is_named = vec![false; self.rules.len()];
        let mut check = |command: &Command| {
            let channel = once(&mut is_named, command)?;
            let alone = [CommandKind::Reset, CommandKind::Stop, CommandKind::Claim, CommandKind::Release].map(Some);
            let is_alone = alone.contains(&command.kind());
            if is_alone {
                return Err(Reply::refused(command, Outcome::NotTogether));
            }
            Ok((channel, self.check(channel, command, asker, now)?))
        };
        let verdicts: Vec<_> = commands.iter().map(&mut check).collect();
        if verdicts.iter().any(Result::is_err) {
            return Err(with_others(commands, &verdicts));
        }
        verdicts.into_iter().flatten().for_each(|(channel, granted)| checked.add(channel, granted));
        // One lease for all: the shortest, of those that have any.
        let hold_ns = checked.orders.iter().map(|(_, _, hold_ns)| *hold_ns).min().unwrap_or(u64::MAX);
        for (_, ask, hold) in &mut checked.orders {
            *hold = if *ask == Ask::Off { *hold } else { hold_ns };
        }
        Ok(checked)
    }

    /// Takes in an answer of the loop; the last one of a request is sent to whoever asked.
    fn answered(
        &mut self,
        waiting: &mut HashMap<u64, Waiting>,
        ticket: u64,
        channel: u32,
        cycle: u64,
        answer: Answer,
        shared: &Shared,
    ) {
        let Some(w) = waiting.get_mut(&ticket) else { return };
        let commands = w.request.commands();
        // The only one, which may be for all channels, or the one for this channel.
        let place = match commands {
            [_] => Some(0),
            several => several.iter().position(|command| command.channel == channel),
        };
        let Some(place) = place else { return };
        let refused = |outcome| Reply { channel, ..Reply::refused(&commands[place], outcome) };
        let refusal = match answer {
            Answer::Done => None,
            Answer::Latched(fault) => Some(refused(Outcome::Faulted).because(fault)),
            Answer::CauseRemains(fault) => Some(refused(Outcome::CauseRemains).because(fault)),
            Answer::TooHot(fault, Cooldown { longest_s, temperature_c, below_c }) => {
                Some(refused(Outcome::TooHot).because(fault).until(longest_s, temperature_c, below_c))
            }
            Answer::Overtaken => Some(refused(Outcome::Overtaken)),
            Answer::WithOthers => Some(refused(Outcome::WithOthers)),
        };
        let reply = &mut w.replies[place];
        match refusal {
            None if is_taken(reply) => *reply = reply.in_cycle(cycle),
            // Of several for one command the first; it says which channel.
            Some(refusal) if is_taken(reply) => *reply = refusal,
            _ => {}
        }
        w.missing -= 1;
        if w.missing == 0
            && let Some(w) = waiting.remove(&ticket)
        {
            self.outbox.end(ticket);
            if w.replies.iter().all(is_taken) {
                w.request.reply(w.replies);
            } else {
                refuse(shared, w.request, w.replies);
            }
        }
    }
}

/// What a request asks of the loop, and the lease that is granted, s: the shortest of several, 0 where there is none.
struct Checked {
    orders: Vec<(usize, Ask, u64)>,
    hold_s: f64,
}

impl Checked {
    fn nothing() -> Checked {
        Checked { orders: Vec::new(), hold_s: 0.0 }
    }

    fn add(&mut self, channel: usize, (ask, granted_s): (Ask, f64)) {
        // What holds until the next command has no lease.
        if granted_s > 0.0 {
            self.hold_s = if self.hold_s > 0.0 { self.hold_s.min(granted_s) } else { granted_s };
        }
        let hold_ns = if granted_s > 0.0 { (granted_s * 1e9) as u64 } else { u64::MAX };
        self.orders.push((channel, ask, hold_ns));
    }
}

/// Whether it asks for a stop, and for nothing else.
fn is_stop(request: &Request) -> bool {
    matches!(request.commands(), [command] if command.kind() == Some(CommandKind::Stop))
}

/// Whether it claims channels, or releases them, and does nothing else.
fn claims_or_releases(request: &Request) -> Option<CommandKind> {
    let kind = request.commands().first()?.kind()?;
    let is_all = request.commands().iter().all(|command| command.kind() == Some(kind));
    (is_all && matches!(kind, CommandKind::Claim | CommandKind::Release)).then_some(kind)
}

/// The channel of a command among several, of which each is named once.
fn once(is_named: &mut [bool], command: &Command) -> Result<usize, Reply> {
    let channel = command.channel as usize;
    match is_named.get_mut(channel) {
        None => Err(Reply::refused(command, Outcome::UnknownChannel)),
        Some(true) => Err(Reply::refused(command, Outcome::NotTogether)),
        Some(is_named) => {
            *is_named = true;
            Ok(channel)
        }
    }
}

/// Says that it was overtaken, which is no refusal.
fn reply_overtaken(request: Request) {
    let replies = request.commands().iter().map(|command| Reply::refused(command, Outcome::Overtaken)).collect();
    request.reply(replies);
}

/// Setpoints with the time they are to be approached in: no longer than their lease, and not by switching off.
fn approach(commands: &[Command], checked: Checked, terms: Terms) -> Result<Checked, Vec<Reply>> {
    let refused = |outcome| commands.iter().map(|command| Reply::refused(command, outcome)).collect::<Vec<_>>();
    if !terms.over_s.is_finite() {
        return Err(refused(Outcome::NotFinite));
    }
    let is_off = checked.orders.iter().all(|(_, ask, _)| *ask == Ask::Off);
    if terms.over_s == 0.0 || is_off {
        return Ok(checked);
    }
    if !(0.0..=checked.hold_s).contains(&terms.over_s) {
        let replies = refused(Outcome::ApproachOutOfRange).into_iter().map(|reply| reply.range(0.0, checked.hold_s));
        return Err(replies.collect());
    }
    if checked.orders.iter().any(|(_, ask, _)| matches!(ask, Ask::Tension(_))) {
        return Err(refused(Outcome::Unsupported));
    }
    Ok(checked)
}

/// Refused because of another client's claim.
fn refused_by(command: &Command, claim: &Claim, now: Instant) -> Reply {
    Reply::refused(command, Outcome::Claimed).claimed_by(claim.owner.pid, claim.priority, claim.left_s(now))
}

/// The replies to commands of which some are refused: each its own reason, or that of the others.
fn with_others<T>(commands: &[Command], verdicts: &[Result<T, Reply>]) -> Vec<Reply> {
    let refused = |(command, verdict): (&Command, &Result<T, Reply>)| match verdict {
        Ok(_) => Reply::refused(command, Outcome::WithOthers),
        Err(reply) => *reply,
    };
    commands.iter().zip(verdicts).map(refused).collect()
}

fn is_taken(reply: &Reply) -> bool {
    reply.outcome == Outcome::Taken.code()
}

fn refuse(shared: &Shared, request: Request, replies: Vec<Reply>) {
    shared.refusals.fetch_add(1, Ordering::Relaxed);
    request.reply(replies);
}

fn refuse_all(shared: &Shared, request: Request, reply: impl FnMut(&Command) -> Reply) {
    let replies = request.commands().iter().map(reply).collect();
    refuse(shared, request, replies);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::OnceLock;

    /// A wire against a spring, one under a hanging mass, and the two of a joint.
    fn rules() -> &'static [ChannelRules] {
        static RULES: OnceLock<Vec<ChannelRules>> = OnceLock::new();
        RULES.get_or_init(|| {
            let wire = |name: &str, load: &str| {
                format!(
                    "[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
                     drive = {{ supply_v = 6.5, shunt_ohm = 0.1 }}\n{load}\n"
                )
            };
            let text = [
                "[rig]\nname = \"bench\"\n".into(),
                wire("spring", "load = { mass_kg = 0.08, spring_n_per_m = 150.0, preload_n = 2.4 }"),
                wire("mass", "load = { mass_kg = 0.2 }"),
                wire("flexor", ""),
                wire("extensor", ""),
                "[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\nantagonist = \"extensor\"\nradius_mm = 8.0\n\
                 inertia_kg_mm2 = 2.5\nspring_n_mm = 5.0\ntorque_n_mm = 1.0\n"
                    .into(),
            ];
            let rig = Rig::parse(&text.concat(), "bench.toml").unwrap_or_else(|e| panic!("{e}"));
            ChannelRules::of(&rig).unwrap()
        })
    }

    /// A tension is asked of a joint whose law keeps one; of one that knows nothing of it, as of a wire without a spring, none can be.
    #[test]
    fn a_tension_is_asked_of_a_law_that_keeps_one() {
        let wire = |name: &str| {
            format!(
                "[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\ndrive = {{ supply_v = 6.5 }}\n"
            )
        };
        for (word, takes) in [("decoupling", true), ("differential_force", true), ("resistance_polynomials", false)] {
            let text = format!(
                "[rig]\nname = \"bench\"\n{}{}[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\nantagonist = \"extensor\"\n\
                 radius_mm = 8.0\ninertia_kg_mm2 = 2.5\nalgorithm = \"{word}\"\n",
                wire("flexor"),
                wire("extensor")
            );
            let rig = Rig::parse(&text, "bench.toml").unwrap_or_else(|e| panic!("{e}"));
            let rules = ChannelRules::of(&rig).unwrap();
            let command = Command {
                client: 1,
                sequence: 1,
                channel: 0,
                kind: CommandKind::Force.code(),
                value: 2.0,
                hold_s: 1.0,
            };
            match rules[0].check(&command) {
                Ok((Ask::Tension(n), _)) => assert!(takes && n == 2.0, "{word}"),
                Err(reply) => assert!(!takes && reply.outcome == Outcome::Unsupported.code(), "{word}: {reply:?}"),
                Ok(other) => panic!("{word}: {other:?}"),
            }
        }
    }

    /// Numbers that have broken things before, beside any bits.
    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            any::<u64>().prop_map(f64::from_bits),
            prop::sample::select(vec![0.0, -0.0, 1e-320, 1.0, 1e300, f64::MAX, f64::INFINITY, f64::NAN, 0.16, 2.5]),
            -1.0..3.0f64,
        ]
    }

    proptest! {
        #[test]
        fn whatever_is_asked_for_what_is_taken_is_inside_the_limits(
            kind in prop_oneof![0..9u32, any::<u32>()],
            channel in any::<u32>(),
            client in any::<u64>(),
            value in number(),
            hold_s in number(),
        ) {
            let command = Command { client, sequence: client, channel, kind, value, hold_s };
            let mut bytes = Vec::new();
            for word in [client, client, u64::from(channel) | u64::from(kind) << 32, value.to_bits(), hold_s.to_bits()] {
                bytes.extend_from_slice(&word.to_le_bytes());
            }
            for rules in rules() {
                let verdict = rules.judge(&bytes).expect("as many bytes as a command has");
                prop_assert_eq!(format!("{verdict:?}"), format!("{:?}", rules.check(&command)));
                prop_assert!(rules.judge(&bytes[1..]).is_none());
                let Ok((ask, hold_s)) = verdict else { continue };
                prop_assert!(hold_s == 0.0 || (hold_s > 0.0 && hold_s <= rules.max_lease_s), "{hold_s}");
                match ask {
                    Ask::Length(m) | Ask::Force(m) => {
                        prop_assert!((rules.min_length_m..=rules.max_length_m).contains(&m), "{ask:?}");
                    }
                    Ask::Duty(duty) => prop_assert!((0.0..=rules.max_duty).contains(&duty), "{ask:?}"),
                    Ask::Tension(n) => {
                        let (low, high) = rules.joint_tension_n.expect("in a joint");
                        prop_assert!((low..=high).contains(&n), "{ask:?}");
                    }
                    Ask::Off | Ask::Reset => {}
                }
            }
        }
    }
}
