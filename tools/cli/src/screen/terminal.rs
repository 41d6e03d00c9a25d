//! Sets up the terminal, shows the screen until the user quits or the driver ends, and restores the terminal in any case.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyEventKind};
use sinew_ipc::Mode;

use super::app::{Action, App, Message};
use super::draw::draw;
use super::style::Palette;
use super::view::Row;
use crate::commands::live::Live;
use crate::failure::{Failure, Outcome};
use crate::setpoint::Setpoint;

/// From one picture to the next.
const FRAME: Duration = Duration::from_millis(50);
/// Lease of what the screen holds.
const HOLD: Duration = Duration::from_millis(1500);
/// From one renewal to the next.
const RENEW: Duration = Duration::from_millis(400);
/// A command shows in the published state this much later at most.
const SHOWS: Duration = Duration::from_millis(20);
/// An `off` this short lets a channel go: it lapses at once and without fault.
const RELEASE: Duration = Duration::from_millis(50);

/// A channel this screen holds.
struct Held {
    channel: usize,
    setpoint: Setpoint,
    since: Instant,
    /// What the driver published of it once the command was in force. Anything else later is somebody else's command.
    seen: Option<(Mode, u64)>,
}

/// What tells one setpoint of a channel from another.
fn mark(row: &Row) -> (Mode, u64) {
    (row.state.mode(), row.state.target_m.to_bits())
}

/// Restores the terminal when it goes out of scope, also by a panic in this thread; ratatui's hook does it before the
/// message of any panic is printed.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        let _ = ratatui::try_restore();
    }
}

/// Shows the screen until a key, `over` or the driver's end closes it. `quit_word` is what `q` does, `reset_stop` how the emergency stop is
/// reset, at the driver's own terminal alone.
pub fn show(
    live: &mut Live,
    quit_word: &'static str,
    over: &dyn Fn() -> bool,
    reset_stop: Option<&dyn Fn()>,
) -> Outcome {
    let restore = Restore;
    let mut terminal = ratatui::try_init().map_err(|error| {
        Failure::own(format!("the terminal cannot be used: {error}")).hint("pipe the output to get plain lines")
    })?;
    let events = events();
    let palette = Palette::from_environment();
    let mut app = App::new(quit_word);
    app.resets_stop = reset_stop.is_some();
    let mut held: Vec<Held> = Vec::new();
    let mut renewed = Instant::now();
    let started = Instant::now();
    loop {
        let now_s = started.elapsed().as_secs_f64();
        app.update(live.look());
        app.forget(now_s);
        if let Some(view) = &app.view {
            let mut lost = None;
            held.retain_mut(|held| {
                let row = &view.channels[held.channel];
                let now = mark(row);
                if held.seen.is_none() && held.since.elapsed() >= SHOWS {
                    held.seen = Some(now);
                }
                let ours = held.seen.is_none_or(|seen| seen == now);
                if !ours && row.fault.is_none() {
                    lost = Some(row.name.clone());
                }
                ours
            });
            if let Some(name) = lost {
                app.say(Message::Refused(format!("{name}: taken from this screen by another command")), now_s);
            }
        }
        app.held = held.iter().map(|held| held.channel).collect();
        let drawn = terminal.draw(|frame| draw(frame, &app, palette));
        // a closed terminal ends the screen without an error
        if drawn.is_err() || over() || live.ended().is_some() {
            break;
        }
        let mut action = Action::None;
        let next = Instant::now() + FRAME;
        while action == Action::None {
            match events.recv_timeout(next.saturating_duration_since(Instant::now())) {
                Ok(Event::Key(key)) if key.kind != KeyEventKind::Release => action = app.key(key, now_s),
                Ok(Event::Resize(..)) | Err(RecvTimeoutError::Timeout) => break,
                Ok(_) => {}
                Err(RecvTimeoutError::Disconnected) => action = Action::Quit,
            }
        }
        match action {
            Action::None => {}
            Action::Quit => break,
            Action::Set(channel, setpoint) => {
                held.retain(|held| held.channel != channel);
                // off needs no lease
                let hold = if setpoint == Setpoint::Off { Duration::ZERO } else { HOLD };
                let answer = live.set(channel, setpoint, hold);
                if answer.is_ok() {
                    held.push(Held { channel, setpoint, since: Instant::now(), seen: None });
                }
                say(&mut app, answer, now_s);
            }
            Action::Release(channel) => {
                held.retain(|held| held.channel != channel);
                let answer = live.set(channel, Setpoint::Off, RELEASE).map(|_| "let go".into());
                say(&mut app, answer, now_s);
            }
            Action::Reset(channel) => {
                let answer = live.reset(channel);
                say(&mut app, answer, now_s);
            }
            Action::ResetStop => {
                if let Some(reset) = reset_stop {
                    reset();
                }
                let done = "emergency stop reset, if it is closed; r resets a channel";
                say(&mut app, Ok(done.into()), now_s);
            }
        }
        if renewed.elapsed() >= RENEW {
            renewed = Instant::now();
            held.retain(|held| {
                // not before its own setpoint has been seen in force: this renewal could be over another's command
                let quiet = held.setpoint == Setpoint::Off || held.seen.is_none();
                let answer = if quiet { Ok(String::new()) } else { live.set(held.channel, held.setpoint, HOLD) };
                let kept = answer.is_ok();
                if !kept {
                    say(&mut app, answer, now_s);
                }
                kept
            });
        }
    }
    drop(restore);
    if terminal.show_cursor().is_err() {
        // the terminal is gone; dropped, it would complain to a stderr that is gone as well
        std::mem::forget(terminal);
    }
    if live.ended().is_none() {
        for held in held {
            let _ = live.set(held.channel, Setpoint::Off, RELEASE);
        }
    }
    Ok(())
}

/// Keys and resizes, read by a thread of their own: on a terminal that has gone away crossterm's reader never comes back, and
/// the screen must not wait for it.
fn events() -> Receiver<Event> {
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        while let Ok(event) = event::read() {
            if sender.send(event).is_err() {
                break;
            }
        }
    });
    receiver
}

fn say(app: &mut App, answer: Result<String, String>, now_s: f64) {
    let message = match answer {
        Ok(text) => Message::Done(text),
        Err(text) => Message::Refused(text),
    };
    app.say(message, now_s);
}
