//! A stream of setpoints: what a planner that runs a hundred to a thousand times a second tells the driver, without ever waiting for it.
//!
//! Each message is for any number of channels, all or none, as [`Client::set_many`]. The newest wins: one that still waits when the next
//! comes is not carried out. A message may have a deadline, after which it is not carried out either, and its setpoints may be approached in
//! a straight line, a step each cycle of the loop, so that a slow planner moves a fast loop smoothly. Leases, claims and limits are those of
//! any other command.
//!
//! What became of a message is known when its answer has come, which [`Setpoints::send`] and [`Setpoints::poll`] look for: a refusal is the
//! error of a later call. Nothing goes on by itself: with a program that hangs or dies the stream ends, and its last lease with it.

use crate::client::{Client, Taken, Wanted};
use crate::link::Sent;
use crate::{Command, CommandKind, Error, MAX_CHANNELS, Outcome, Terms};
use std::collections::VecDeque;
use std::ops::Deref;
use std::time::{Duration, Instant};

/// Messages that may be without an answer: half of what a client may have, so that there is room for its other requests.
const MOST_ON_THE_WAY: usize = crate::service::MAX_ACTIVE_REQUESTS / 2;

/// How the setpoints of a stream are meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetpointOptions {
    /// How long each holds unless the next one comes; zero: the shortest of its channels' defaults.
    pub hold: Duration,
    /// The time in which each is approached in a straight line from what was wanted before; zero: it holds at once. No longer than the lease;
    /// usually the planner's own period.
    pub over: Duration,
    /// A message the driver gets to later than this is not carried out; `None`: whenever it comes.
    pub within: Option<Duration>,
}

impl Default for SetpointOptions {
    /// Half a second's lease, at once, and not later than a tenth of a second.
    fn default() -> Self {
        SetpointOptions {
            hold: Duration::from_millis(500),
            over: Duration::ZERO,
            within: Some(Duration::from_millis(100)),
        }
    }
}

/// What became of the messages of a stream so far. Those that are in none of the other counts are on their way.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Progress {
    /// Messages given to [`Setpoints::send`].
    pub sent: u64,
    /// In force.
    pub taken: u64,
    /// Not carried out because a later one of the stream, or an `off`, has overtaken them.
    pub overtaken: u64,
    /// Not carried out because they came after their deadline.
    pub late: u64,
    /// Refused for another reason.
    pub refused: u64,
    /// Not sent because too many were without an answer.
    pub held_back: u64,
    /// Number of the cycle in which the last one was taken; 0 = none yet.
    pub cycle: u64,
}

/// How long an answer may be missing before it is looked whether the driver lives.
const SILENCE: Duration = Duration::from_millis(20);

struct Message {
    wanted: Vec<Wanted>,
    sent: Sent,
    since: Instant,
}

/// A stream of setpoints to a driver; of a client that is borrowed ([`Client::setpoints`]) or shared (`Arc<Client>`).
///
/// ```no_run
/// use sinew_ipc::{Client, CommandKind, SetpointOptions, Wanted};
/// use std::time::Duration;
///
/// let client = Client::connect("hexapod")?;
/// let period = Duration::from_millis(10);
/// let mut setpoints = client.setpoints(SetpointOptions { over: period, ..SetpointOptions::default() });
/// for step in 0..1000 {
///     let stroke = 0.2 - 0.1 * (f64::from(step) * 0.02).cos();
///     let pose: Vec<Wanted> = (0..18).map(|channel| Wanted { channel, kind: CommandKind::Stroke, value: stroke }).collect();
///     setpoints.send(&pose)?;
///     std::thread::sleep(period);
/// }
/// println!("{:?}", setpoints.finish()?);
/// # Ok::<(), sinew_ipc::Error>(())
/// ```
pub struct Setpoints<C: Deref<Target = Client>> {
    client: C,
    options: SetpointOptions,
    number: u64,
    on_the_way: VecDeque<Message>,
    progress: Progress,
}

impl Client {
    /// A stream of setpoints, of a client that is borrowed; of a shared one: [`Setpoints::new`].
    pub fn setpoints(&self, options: SetpointOptions) -> Setpoints<&Client> {
        Setpoints::new(self, options)
    }
}

impl<C: Deref<Target = Client>> Setpoints<C> {
    /// A stream beside the client's other requests and streams.
    pub fn new(client: C, options: SetpointOptions) -> Setpoints<C> {
        let number = client.next_stream();
        Setpoints { client, options, number, on_the_way: VecDeque::new(), progress: Progress::default() }
    }

    /// Sends setpoints on their way, for up to [`MAX_CHANNELS`] channels, each named once; does not wait for the driver. Returns
    /// what became of the messages before it.
    ///
    /// # Errors
    /// [`Error::Channels`] for none and for more than there can be, [`Error::DriverGone`], and [`Error::NoAnswer`] where the driver has not
    /// answered for as long as the client is patient: this message was not sent. [`Error::RefusedTogether`] is about an earlier
    /// message; this one is on its way all the same.
    pub fn send(&mut self, wanted: &[Wanted]) -> Result<Progress, Error> {
        if !(1..=MAX_CHANNELS).contains(&wanted.len()) {
            return Err(Error::Channels { found: wanted.len() });
        }
        let earlier = self.poll();
        if let Err(gone @ (Error::DriverGone { .. } | Error::NoAnswer { .. })) = earlier {
            return Err(gone);
        }
        self.progress.sent += 1;
        let SetpointOptions { hold, over, within } = self.options;
        let deadline = within.map_or_else(Terms::default, Terms::within);
        let terms = Terms { over_s: over.as_secs_f64(), stream: self.number, ..deadline };
        let commands = self.client.commands(wanted, hold);
        let has_room = self.on_the_way.len() < MOST_ON_THE_WAY || Command::only_switch_off(&commands);
        match if has_room { self.client.link().send(&commands, terms)? } else { None } {
            Some(sent) => self.on_the_way.push_back(Message { wanted: wanted.to_vec(), sent, since: Instant::now() }),
            None => self.progress.held_back += 1,
        }
        earlier.map(|_| self.progress)
    }

    /// A share of the stroke for every channel, 0 (cold) to 1 (hot), in the rig's order.
    ///
    /// # Errors
    /// As [`Setpoints::send`].
    pub fn send_strokes(&mut self, strokes: &[f64]) -> Result<Progress, Error> {
        let wanted: Vec<Wanted> = (0..)
            .zip(strokes)
            .map(|(channel, stroke)| Wanted { channel, kind: CommandKind::Stroke, value: *stroke })
            .collect();
        self.send(&wanted)
    }

    /// Looks for answers, without waiting; what became of the messages.
    ///
    /// # Errors
    /// [`Error::RefusedTogether`]: why a message was refused, once for each; [`Error::DriverGone`], [`Error::NoAnswer`].
    pub fn poll(&mut self) -> Result<Progress, Error> {
        let mut refused = None;
        // They are answered one after the other, but not always in order: what is overtaken is answered at once.
        let mut left = VecDeque::with_capacity(self.on_the_way.len());
        while let Some(message) = self.on_the_way.pop_front() {
            match self.client.link().poll(&message.sent) {
                None => left.push_back(message),
                Some(replies) => {
                    let outcome = |code: Outcome| replies.iter().any(|reply| reply.outcome == code.code());
                    if outcome(Outcome::Overtaken) {
                        self.progress.overtaken += 1;
                    } else if outcome(Outcome::Late) {
                        self.progress.late += 1;
                    } else {
                        match self.client.taken(&message.wanted, &replies) {
                            Ok(Taken { cycle, .. }) => {
                                self.progress.taken += 1;
                                self.progress.cycle = self.progress.cycle.max(cycle);
                            }
                            Err(error) => {
                                self.progress.refused += 1;
                                refused = Some(error);
                            }
                        }
                    }
                }
            }
        }
        self.on_the_way = left;
        if let Some(error) = refused {
            return Err(error);
        }
        let waited = self.on_the_way.front().map_or(Duration::ZERO, |oldest| oldest.since.elapsed());
        if waited >= SILENCE {
            self.client.link().check()?;
        }
        if waited >= self.client.options().answer {
            return Err(Error::NoAnswer { rig: self.client.info().rig.to_string(), waited });
        }
        Ok(self.progress)
    }

    /// What became of the messages, as of the last look.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Waits for the answers to what is on its way, as long as the client is patient. What is not waited for and dropped is not carried out
    /// where the driver has not begun with it.
    ///
    /// # Errors
    /// As [`Setpoints::poll`].
    pub fn finish(mut self) -> Result<Progress, Error> {
        while !self.on_the_way.is_empty() {
            self.poll()?;
            std::thread::sleep(Duration::from_micros(100));
        }
        Ok(self.progress)
    }
}
