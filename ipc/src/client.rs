//! What a robot program links: find the driver, read what it knows, command it.
//!
//! A [`Client`] may be shared between threads, and any number of them (256 in all) may be connected to one driver, from
//! one process or many. Reading the latest state never waits for anything. When the driver ends or dies, reading keeps
//! giving the last state it wrote, [`Client::is_alive`] says no, and commands fail with [`Error::DriverGone`]; connect again for the next one.
//!
//! A driver of one's own is reached over iceoryx2's shared memory, another user's through its [gateway](crate::gateway), where it has one;
//! nothing else differs.

use crate::link::{Link, Waiter};
use crate::stream::CycleStream;
use crate::{
    ALL_CHANNELS, ChannelInfo, Clocks, Command, CommandKind, DriverState, Error, Fault, Info, LoopStats, MAX_CHANNELS,
    Outcome, Reason, Refusal, Reply, Snapshot,
};
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, TryLockError};
use std::time::{Duration, Instant};

/// How long a client is willing to wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClientOptions {
    /// For a driver that is just starting, when connecting.
    pub connect: Duration,
    /// For the answer to a command.
    pub answer: Duration,
}

impl Default for ClientOptions {
    fn default() -> Self {
        ClientOptions { connect: Duration::from_secs(2), answer: Duration::from_secs(1) }
    }
}

/// How the driver is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DriverHealth {
    /// Services are there, the loop does not run yet.
    Starting,
    /// The loop runs.
    Running,
    /// Its process lives but the loop has not written for so long.
    Stalled {
        /// Age of the latest state.
        age: Duration,
    },
    /// It is stopping or has stopped in order.
    Stopped,
    /// It ended without stopping.
    Died,
}

impl DriverHealth {
    /// In a word, the same wherever it is said: `starting`, `running`, `stalled`, `stopped`, `died`.
    pub const fn name(self) -> &'static str {
        match self {
            DriverHealth::Starting => "starting",
            DriverHealth::Running => "running",
            DriverHealth::Stalled { .. } => "stalled",
            DriverHealth::Stopped => "stopped",
            DriverHealth::Died => "died",
        }
    }
}

/// One setpoint of several, see [`Client::set_many`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted {
    /// Number of the channel.
    pub channel: u32,
    /// What is asked for: a length, a stroke, a duty, a force, or off.
    pub kind: CommandKind,
    /// Value in SI units; 0 for off.
    pub value: f64,
}

/// What became of a request for several channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taken {
    /// Number of the cycle from which on all of it is in force.
    pub cycle: u64,
    /// The lease as granted, s; 0 where there is none.
    pub hold_s: f64,
}

/// A connection to a running driver.
pub struct Client {
    info: Info,
    sequence: AtomicU64,
    number: u64,
    options: ClientOptions,
    sleeper: Mutex<Option<Waiter>>,
    link: Arc<Link>,
}

impl Client {
    /// Connects to the driver of this rig.
    ///
    /// # Errors
    /// [`Error::NotRunning`] (with the rigs that are), [`Error::Starting`], [`Error::Protocol`], [`Error::RigName`],
    /// [`Error::Full`], [`Error::Service`], [`Error::RuntimeDir`]; at another user's gatewayway [`Error::NotAdmitted`], [`Error::Gateway`].
    pub fn connect(rig: &str) -> Result<Client, Error> {
        Client::connect_with(rig, ClientOptions::default())
    }

    /// Connects with patience of one's own.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub fn connect_with(rig: &str, options: ClientOptions) -> Result<Client, Error> {
        let (link, info) = Link::find(rig, options.connect)?;
        Ok(Client::over(link, info, options))
    }

    pub(crate) fn over(link: Link, info: Info, options: ClientOptions) -> Client {
        static CLIENTS: AtomicU64 = AtomicU64::new(1);
        Client {
            info,
            sequence: AtomicU64::new(1),
            number: u64::from(std::process::id()) << 32 | CLIENTS.fetch_add(1, Ordering::Relaxed) & 0xffff_ffff,
            options,
            sleeper: Mutex::new(None),
            link: Arc::new(link),
        }
    }

    /// Names of the rigs a driver is running for, sorted: the own user's, and those whose gateway a driver listens at.
    ///
    /// # Errors
    /// [`Error::RuntimeDir`].
    pub fn discover() -> Result<Vec<String>, Error> {
        crate::run::running()
    }

    /// Whether the driver is another user's, reached through its gateway.
    pub fn is_foreign(&self) -> bool {
        self.link.is_foreign()
    }

    /// What does not change while the driver runs: rate, channels, limits.
    pub fn info(&self) -> &Info {
        &self.info
    }

    /// The text of the rig file as the driver read it, the built-in rig's too; `None` where the driver left none.
    ///
    /// # Errors
    /// [`Error::RuntimeDir`].
    pub fn rig_text(&self) -> Result<Option<String>, Error> {
        self.link.rig_text()
    }

    /// The channels, in the rig's order.
    pub fn channels(&self) -> &[ChannelInfo] {
        self.info.channels()
    }

    /// The number of a channel.
    ///
    /// # Errors
    /// [`Error::UnknownChannel`] with the names there are.
    pub fn channel(&self, name: &str) -> Result<usize, Error> {
        self.info.index_of(name).ok_or_else(|| Error::UnknownChannel {
            name: name.to_string(),
            known: self.channels().iter().map(|c| c.name.as_str().to_string()).collect(),
        })
    }

    /// The latest state: one whole cycle, never parts of two. Does not wait.
    pub fn latest(&self) -> Snapshot {
        self.link.with_latest(|latest| *latest)
    }

    /// The latest state, into a place of the caller's.
    pub fn latest_into(&self, snapshot: &mut Snapshot) {
        self.link.with_latest(|latest| snapshot.copy_from(latest));
    }

    /// Looks at the latest state. The copy from shared memory is the only one made: only after copying can it be told that
    /// the driver did not write meanwhile.
    pub fn with_latest<T>(&self, look: impl FnOnce(&Snapshot) -> T) -> T {
        self.link.with_latest(look)
    }

    /// How the loop does.
    pub fn loop_stats(&self) -> LoopStats {
        self.link.stats()
    }

    /// Every cycle from now on, in order.
    ///
    /// # Errors
    /// [`Error::Full`] when 64 streams are open already, [`Error::Service`].
    pub fn stream(&self) -> Result<CycleStream, Error> {
        let latest = self.with_latest(|state| state.cycle);
        CycleStream::new(&self.link, latest)
    }

    /// Sleeps until the driver has something new, up to `timeout`; false when nothing came. Returns at once when something
    /// has come since the last call. For several threads that sleep at the same time, give each a [`Client::waiter`].
    ///
    /// # Errors
    /// [`Error::DriverGone`], [`Error::Service`].
    pub fn wait(&self, timeout: Duration) -> Result<bool, Error> {
        match self.sleeper.try_lock() {
            Ok(mut sleeper) => match &mut *sleeper {
                Some(waiter) => waiter.wait(timeout),
                none => none.insert(Waiter::new(&self.link)?).wait(timeout),
            },
            Err(TryLockError::WouldBlock) => Waiter::new(&self.link)?.wait(timeout),
            Err(TryLockError::Poisoned(_)) => Waiter::new(&self.link)?.wait(timeout),
        }
    }

    /// A sleeper of one's own.
    ///
    /// # Errors
    /// [`Error::Full`] when 256 of them exist already, [`Error::Service`].
    pub fn waiter(&self) -> Result<Waiter, Error> {
        Waiter::new(&self.link)
    }

    /// Fault changes from now on.
    pub fn faults(&self) -> FaultWatch<&Client> {
        FaultWatch::new(self)
    }

    /// The clocks of this machine beside the driver's, compared now: system time, TAI and boot time of its stamps, each with its error.
    ///
    /// All stamps of a driver are CLOCK_MONOTONIC, which runs at the rate of system time and is never set. So one comparison does until
    /// somebody sets the system's clock, which [`Clocks::refresh`] says. It takes some µs. A device's own clock is a [`sinew_clocks::ClockMap`]'s.
    pub fn clocks(&self) -> Clocks {
        Clocks::now()
    }

    /// Age of the latest state.
    pub fn age(&self) -> Duration {
        self.with_latest(age_of)
    }

    /// How the driver is.
    pub fn health(&self) -> DriverHealth {
        // Asked in this order: what is written before dying is seen.
        let lives = self.link.driver_lives();
        let (state, age) = self.with_latest(|s| (s.state(), age_of(s)));
        match state {
            DriverState::Stopped => DriverHealth::Stopped,
            _ if !lives => DriverHealth::Died,
            DriverState::Stopping => DriverHealth::Stopped,
            DriverState::Starting => DriverHealth::Starting,
            DriverState::Running if age > self.longest_gap() => DriverHealth::Stalled { age },
            DriverState::Running => DriverHealth::Running,
        }
    }

    /// Whether the driver's process lives and its loop runs.
    pub fn is_alive(&self) -> bool {
        matches!(self.health(), DriverHealth::Starting | DriverHealth::Running)
    }

    /// The age of the latest state from which on the loop counts as standing still.
    fn longest_gap(&self) -> Duration {
        let periods = if self.info.rate_hz > 0.0 { 20.0 / self.info.rate_hz } else { 0.0 };
        Duration::from_secs_f64((0.5 + periods).min(60.0))
    }

    /// Holds a wire length, m, for `hold` unless renewed ([`Duration::ZERO`]: the channel's default). Returns the driver's reply with
    /// the lease as granted, once the loop has it.
    ///
    /// # Errors
    /// [`Error::UnknownChannel`], [`Error::Refused`] with the reason and what to do, [`Error::DriverGone`], [`Error::NoAnswer`].
    pub fn set_length(&self, channel: &str, length_m: f64, hold: Duration) -> Result<Reply, Error> {
        self.set(channel, CommandKind::Length, length_m, hold)
    }

    /// Holds a share of the stroke, 0 (cold) to 1 (hot).
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn set_stroke(&self, channel: &str, stroke: f64, hold: Duration) -> Result<Reply, Error> {
        self.set(channel, CommandKind::Stroke, stroke, hold)
    }

    /// Gives a duty, 0 to 1, without control.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn set_duty(&self, channel: &str, duty: f64, hold: Duration) -> Result<Reply, Error> {
        self.set(channel, CommandKind::Duty, duty, hold)
    }

    /// Holds a tension, N.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn set_force(&self, channel: &str, force_n: f64, hold: Duration) -> Result<Reply, Error> {
        self.set(channel, CommandKind::Force, force_n, hold)
    }

    /// Only the sensing pulse from now on.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn off(&self, channel: &str) -> Result<Reply, Error> {
        self.set(channel, CommandKind::Off, 0.0, Duration::ZERO)
    }

    /// Only the sensing pulse on every channel from now on.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn all_off(&self) -> Result<Reply, Error> {
        self.command(ALL_CHANNELS, CommandKind::Off, 0.0, Duration::ZERO)
    }

    /// Clears a latched fault whose cause has gone.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn reset(&self, channel: &str) -> Result<Reply, Error> {
        self.set(channel, CommandKind::Reset, 0.0, Duration::ZERO)
    }

    /// Stops the driver: outputs to zero, then it ends.
    ///
    /// # Errors
    /// [`Error::DriverGone`], [`Error::NoAnswer`].
    pub fn stop(&self) -> Result<Reply, Error> {
        self.command(ALL_CHANNELS, CommandKind::Stop, 0.0, Duration::ZERO)
    }

    /// Any command to a channel by name.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn set(&self, channel: &str, kind: CommandKind, value: f64, hold: Duration) -> Result<Reply, Error> {
        self.command(self.channel(channel)? as u32, kind, value, hold)
    }

    /// Any command to a channel by number ([`ALL_CHANNELS`] for all). What the driver would refuse is not checked here: there is
    /// one judge.
    ///
    /// # Errors
    /// As [`Client::set_length`].
    pub fn command(&self, channel: u32, kind: CommandKind, value: f64, hold: Duration) -> Result<Reply, Error> {
        let wanted = Wanted { channel, kind, value };
        // as many as were asked for
        let reply = self.ask(&[wanted], hold)?[0];
        match self.refusal(&wanted, &reply) {
            None => Ok(reply),
            Some(refusal) => Err(Error::Refused(refusal)),
        }
    }

    /// Setpoints for several channels in one request: all of them are in force from the same cycle on, or none is. They hold for `hold` unless
    /// renewed ([`Duration::ZERO`]: the shortest of the channels' defaults); an `off` among setpoints holds until the next command.
    ///
    /// ```no_run
    /// use sinew_ipc::{Client, CommandKind, Wanted};
    /// use std::time::Duration;
    ///
    /// let client = Client::connect("hexapod")?;
    /// let pose: Vec<Wanted> =
    ///     (0..18).map(|channel| Wanted { channel, kind: CommandKind::Stroke, value: 0.4 }).collect();
    /// let taken = client.set_many(&pose, Duration::from_millis(200))?;
    /// println!("in force from cycle {} on", taken.cycle);
    /// # Ok::<(), sinew_ipc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Channels`] for none and for more than [`MAX_CHANNELS`]; [`Error::RefusedTogether`] with every channel's own reason;
    /// [`Error::DriverGone`], [`Error::NoAnswer`].
    pub fn set_many(&self, wanted: &[Wanted], hold: Duration) -> Result<Taken, Error> {
        if !(1..=MAX_CHANNELS).contains(&wanted.len()) {
            return Err(Error::Channels { found: wanted.len() });
        }
        self.taken(wanted, &self.ask(wanted, hold)?)
    }

    /// What became of setpoints that were asked for together, by the replies to each.
    pub(crate) fn taken(&self, wanted: &[Wanted], replies: &[Reply]) -> Result<Taken, Error> {
        let refused: Vec<Refusal> =
            wanted.iter().zip(replies).filter_map(|(wanted, reply)| self.refusal(wanted, reply)).collect();
        match refused.is_empty() {
            true => Ok(Taken { cycle: replies[0].cycle, hold_s: replies[0].hold_s }),
            // What only goes with the others is no reason of its own.
            false => Err(Error::RefusedTogether(
                refused.into_iter().filter(|refusal| refusal.reason != Reason::WithOthers).collect(),
            )),
        }
    }

    /// The number of a new stream of setpoints.
    pub(crate) fn next_stream(&self) -> u64 {
        self.sequence.fetch_add(1, Ordering::Relaxed)
    }

    pub(crate) fn link(&self) -> &Link {
        &self.link
    }

    pub(crate) fn options(&self) -> ClientOptions {
        self.options
    }

    /// Has these channels to itself: setpoints and resets of other clients are refused, with the id of this process, until it lets go of
    /// them or `hold` has passed without it asking anything of them ([`Duration::ZERO`]: the channels' default lease). `off` and `stop`
    /// stay open to everybody. All of them are claimed, or none; the two wires of a joint go together.
    ///
    /// A channel that another client has claimed is taken over by a higher priority, 0 to [`MOST_PRIORITY`](crate::MOST_PRIORITY): the loser's next setpoint is
    /// refused with [`Reason::Claimed`], and what it asked for last holds until its lease runs out or the new owner commands.
    ///
    /// # Errors
    /// As [`Client::set_many`]; [`Reason::Claimed`] where somebody has claimed one with this priority or a higher.
    pub fn claim(&self, channels: &[u32], priority: u32, hold: Duration) -> Result<Taken, Error> {
        self.set_many(&all(channels, CommandKind::Claim, priority.into()), hold)
    }

    /// Lets go of these channels. One that this client has not claimed, or no longer, stays as it is.
    ///
    /// # Errors
    /// As [`Client::set_many`].
    pub fn release(&self, channels: &[u32]) -> Result<Taken, Error> {
        self.set_many(&all(channels, CommandKind::Release, 0.0), Duration::ZERO)
    }

    fn ask(&self, wanted: &[Wanted], hold: Duration) -> Result<Vec<Reply>, Error> {
        self.link.ask(&self.commands(wanted, hold), self.options.answer)
    }

    /// The commands of a request of its own number.
    pub(crate) fn commands(&self, wanted: &[Wanted], hold: Duration) -> Vec<Command> {
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed);
        // An `off` beside setpoints does not run out with them.
        let is_mixed = wanted.iter().any(|wanted| wanted.kind != CommandKind::Off);
        let command = |&Wanted { channel, kind, value }: &Wanted| Command {
            client: self.number,
            sequence,
            channel,
            kind: kind.code(),
            value,
            hold_s: if is_mixed && kind == CommandKind::Off { 0.0 } else { hold.as_secs_f64() },
        };
        wanted.iter().map(command).collect()
    }

    fn refusal(&self, &Wanted { channel, kind, value }: &Wanted, reply: &Reply) -> Option<Refusal> {
        let reason = self.reason(reply, kind)?;
        let channel = match self.channels().get(channel as usize) {
            Some(info) => info.name.to_string(),
            None if channel == ALL_CHANNELS => "all channels".into(),
            None => format!("number {channel}"),
        };
        Some(Refusal { channel, kind, value, reason })
    }

    fn reason(&self, reply: &Reply, kind: CommandKind) -> Option<Reason> {
        // A fault this version does not know is still a fault.
        let fault = Fault::from_code(reply.fault).unwrap_or(Fault::Backend);
        Some(match Outcome::from_code(reply.outcome) {
            Some(Outcome::Taken) => return None,
            Some(Outcome::UnknownChannel) => Reason::UnknownChannel,
            Some(Outcome::UnknownCommand) => Reason::UnknownCommand,
            Some(Outcome::NotFinite) => Reason::NotFinite,
            Some(Outcome::OutOfRange) => Reason::OutOfRange { low: reply.low, high: reply.high },
            Some(Outcome::HoldOutOfRange) => Reason::HoldOutOfRange { low: reply.low, high: reply.high },
            Some(Outcome::Faulted) => Reason::Faulted(fault),
            Some(Outcome::CauseRemains) => Reason::CauseRemains(fault),
            Some(Outcome::TooHot) => {
                Reason::TooHot { fault, longest_s: reply.hold_s, temperature_c: reply.value, below_c: reply.high }
            }
            Some(Outcome::Waiting) => Reason::Waiting,
            Some(Outcome::Unsupported) => Reason::Unsupported,
            Some(Outcome::Busy) => Reason::Busy,
            Some(Outcome::Stopping) => Reason::Stopping,
            Some(Outcome::Overtaken) => Reason::Overtaken,
            Some(Outcome::WithOthers) => Reason::WithOthers,
            Some(Outcome::NotTogether) => Reason::NotTogether,
            Some(Outcome::Claimed) => {
                Reason::Claimed { owner: reply.owner, priority: reply.value as u32, left_s: reply.hold_s }
            }
            Some(Outcome::Late) => Reason::Late,
            Some(Outcome::ApproachOutOfRange) => Reason::ApproachOutOfRange { low: reply.low, high: reply.high },
            Some(Outcome::NotPermitted) => Reason::NotPermitted { group: self.link.group_for(kind) },
            None => Reason::Unknown(reply.outcome),
        })
    }
}

/// The same of each of these channels.
fn all(channels: &[u32], kind: CommandKind, value: f64) -> Vec<Wanted> {
    channels.iter().map(|&channel| Wanted { channel, kind, value }).collect()
}

fn age_of(snapshot: &Snapshot) -> Duration {
    Duration::from_nanos(crate::monotonic_ns().saturating_sub(snapshot.monotonic_ns))
}

/// One change of a channel's fault.
#[derive(Debug, Clone, PartialEq)]
pub struct FaultChange {
    /// Number of the channel.
    pub channel: usize,
    /// Its name.
    pub name: String,
    /// The fault before, if any.
    pub before: Option<Fault>,
    /// The fault from now on; `None` = cleared.
    pub after: Option<Fault>,
    /// The cycle it was seen in.
    pub cycle: u64,
    /// When, CLOCK_MONOTONIC, ns.
    pub monotonic_ns: u64,
}

/// Watches for faults. Since faults stay latched until somebody resets them, looking now and then misses none but those that
/// are reset in between. The first look reports every fault that is there.
pub struct FaultWatch<C: Deref<Target = Client>> {
    client: C,
    seen: Vec<Option<Fault>>,
    found: std::collections::VecDeque<FaultChange>,
    gone: bool,
}

impl<C: Deref<Target = Client>> FaultWatch<C> {
    /// Fault changes from now on, of a client that is borrowed ([`Client::faults`]) or shared (`Arc<Client>`).
    pub fn new(client: C) -> FaultWatch<C> {
        FaultWatch { seen: vec![None; client.channels().len()], client, found: Default::default(), gone: false }
    }

    /// The next change since the last look, if any; never waits. When the driver has died each channel changes to
    /// [`Fault::DriverDied`] once.
    pub fn poll(&mut self) -> Option<FaultChange> {
        if self.found.is_empty() && !self.gone {
            let died = self.client.health() == DriverHealth::Died;
            let FaultWatch { client, seen, found, .. } = self;
            client.with_latest(|snapshot| {
                for (channel, (state, seen)) in snapshot.channels().iter().zip(seen).enumerate() {
                    let after = if died { Some(Fault::DriverDied) } else { state.fault() };
                    if after != *seen {
                        found.push_back(FaultChange {
                            channel,
                            name: client.channels()[channel].name.to_string(),
                            before: *seen,
                            after,
                            cycle: snapshot.cycle,
                            monotonic_ns: snapshot.monotonic_ns,
                        });
                        *seen = after;
                    }
                }
            });
            self.gone = died;
        }
        self.found.pop_front()
    }

    /// The next change, waiting for it up to `timeout`.
    ///
    /// # Errors
    /// [`Error::DriverGone`] once all that is known has been reported, [`Error::Service`].
    pub fn wait(&mut self, timeout: Duration) -> Result<Option<FaultChange>, Error> {
        let end = Instant::now() + timeout;
        loop {
            if let Some(change) = self.poll() {
                return Ok(Some(change));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            match self.client.wait(left) {
                Ok(_) => {}
                Err(gone) => return self.poll().map(Some).ok_or(gone),
            }
        }
    }
}

impl<C: Deref<Target = Client>> Iterator for FaultWatch<C> {
    type Item = FaultChange;

    /// As [`FaultWatch::poll`].
    fn next(&mut self) -> Option<FaultChange> {
        self.poll()
    }
}
