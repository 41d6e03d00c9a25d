//! `sinew play`: setpoints from a CSV file, row by row at their times, to a running driver; one request for all channels.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use sinew_ipc::{Client, CommandKind, Error, Wanted};

use super::live;
use crate::args;
use crate::commands::unknown_channel;
use crate::driving::score::Score;
use crate::driving::setpoint::Setpoint;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output::{self, counted};

/// A lease is renewed so many times before it runs out.
const RENEWALS: f64 = 3.0;
/// The longest sleep: somebody may want it to end.
const NAP: Duration = Duration::from_millis(20);

/// Runs the command.
pub fn play(args: &args::Play) -> Outcome {
    let score = Score::read(&args.file)?;
    let client = live::connect(&args.target)?;
    let mut channels = Vec::new();
    for name in &score.channels {
        let known = client.channels().iter().map(|info| info.name.as_str());
        let place = format!("{}: rig {}", args.file.display(), client.info().rig);
        channels.push(client.info().index_of(name).ok_or_else(|| unknown_channel(&place, name, known))?);
    }
    for row in &score.rows {
        for (&channel, setpoint) in channels.iter().zip(&row.setpoints) {
            let asked = setpoint.map(|setpoint| (&client.channels()[channel], setpoint));
            if let Some((message, hint)) = asked.and_then(live::beyond) {
                return Err(Failure::input(format!("{}:{}: {message}", args.file.display(), row.line)).hint(hint));
            }
        }
    }
    let asked = ending::asked()?;
    let last_s = score.rows.last().map_or(0.0, |row| row.time_s);
    output::note(format_args!(
        "playing {} for {} of {}, {:.1} s{}; Ctrl-C ends it",
        counted(score.rows.len(), "row"),
        counted(channels.len(), "channel"),
        client.info().rig,
        last_s / args.speed,
        if args.times > 1 { format!(", {} times", args.times) } else { String::new() }
    ));
    let mut player = Player {
        client: &client,
        channels,
        wanted: Vec::new(),
        hold_s: args.hold_s,
        priority: args.priority,
        latest: Duration::ZERO,
    };
    player.claim().map_err(live::failure)?;
    let is_over = || asked.load(Ordering::Relaxed);
    let played = player.play(&score, args.speed, args.times, &is_over);
    // Whatever has happened: the wires are handed back. Were this program killed instead, their leases would see to it.
    let off = if args.keep && played.is_ok() { Ok(()) } else { player.off() };
    player.release();
    let rows = played.map_err(live::failure)?;
    off.map_err(live::failure)?;
    output::print(format_args!(
        "played {rows} rows, the latest {:.1} ms after its time; {}\n",
        player.latest.as_secs_f64() * 1e3,
        if args.keep { "the last setpoints run out with their lease" } else { "its channels are off" }
    ))
}

/// Plays to a driver.
struct Player<'a> {
    client: &'a Client,
    /// Number of each column's channel.
    channels: Vec<usize>,
    /// What is wanted now.
    wanted: Vec<Wanted>,
    hold_s: f64,
    /// Of the claim of all its channels, if they are claimed.
    priority: Option<u32>,
    /// How long after its time a row was taken, at the most.
    latest: Duration,
}

impl Player<'_> {
    /// All rows, so many times; how many were played.
    fn play(&mut self, score: &Score, speed: f64, times: u32, is_over: &impl Fn() -> bool) -> Result<u64, Error> {
        let mut played = 0;
        for _ in 0..times {
            let started = Instant::now();
            for row in &score.rows {
                let due = started + Duration::from_secs_f64(row.time_s / speed);
                if !self.wait_until(due, is_over)? {
                    return Ok(played);
                }
                self.change(&row.setpoints);
                self.send()?;
                self.latest = self.latest.max(due.elapsed());
                played += 1;
            }
        }
        Ok(played)
    }

    /// Keeps what is wanted until then; false where it is over before.
    fn wait_until(&self, due: Instant, is_over: &impl Fn() -> bool) -> Result<bool, Error> {
        let renewal = Duration::from_secs_f64(self.hold_s / RENEWALS);
        let mut renew = Instant::now() + renewal;
        loop {
            if is_over() {
                return Ok(false);
            }
            let now = Instant::now();
            if now >= due {
                return Ok(true);
            }
            if now >= renew {
                self.send()?;
                renew = now + renewal;
            }
            std::thread::sleep(NAP.min(due.min(renew).saturating_duration_since(now)));
        }
    }

    fn change(&mut self, setpoints: &[Option<Setpoint>]) {
        for (&channel, setpoint) in self.channels.iter().zip(setpoints) {
            let Some(setpoint) = setpoint else { continue };
            let (kind, value) = live::command(*setpoint, &self.client.channels()[channel]);
            let channel = channel as u32;
            self.wanted.retain(|wanted| wanted.channel != channel);
            self.wanted.push(Wanted { channel, kind, value });
        }
    }

    fn numbers(&self) -> Vec<u32> {
        self.channels.iter().map(|channel| *channel as u32).collect()
    }

    fn claim(&self) -> Result<(), Error> {
        let Some(priority) = self.priority else { return Ok(()) };
        self.client.claim(&self.numbers(), priority, Duration::from_secs_f64(self.hold_s)).map(|_| ())
    }

    /// A claim that is not let go of lapses.
    fn release(&self) {
        if self.priority.is_some() {
            let _ = self.client.release(&self.numbers());
        }
    }

    fn send(&self) -> Result<(), Error> {
        // of channels that nothing is asked of yet, or no longer
        if self.wanted.len() < self.channels.len() {
            self.claim()?;
        }
        let is_off = self.wanted.iter().all(|wanted| wanted.kind == CommandKind::Off);
        let hold = if is_off { Duration::ZERO } else { Duration::from_secs_f64(self.hold_s) };
        if self.wanted.is_empty() { Ok(()) } else { self.client.set_many(&self.wanted, hold).map(|_| ()) }
    }

    /// Every channel that was commanded.
    fn off(&mut self) -> Result<(), Error> {
        for wanted in &mut self.wanted {
            (wanted.kind, wanted.value) = (CommandKind::Off, 0.0);
        }
        self.send()
    }
}
