//! Sets up the terminal, shows the screen until the user quits or the driver ends, and restores the terminal in any case.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::crossterm::cursor::Show;
use ratatui::crossterm::event::{self, Event, KeyEventKind};
use ratatui::crossterm::terminal::{EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode};
use ratatui::crossterm::{Command, QueueableCommand};
use sinew_demonstrators::Watch;
use sinew_threads::Thread;

use super::app::{Action, App, Message};
use super::draw::draw;
use super::holding::Holding;
use super::style::Palette;
use crate::driving::live::Live;
use crate::failure::{Failure, Outcome};
use crate::log::{self, Stream};

/// From one picture to the next.
const FRAME: Duration = Duration::from_millis(50);

/// Restores the terminal when it goes out of scope, also by a panic in this thread; messages are kept back until then. ratatui's own way would
/// let whatever thread panics wait for the terminal.
struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        let _ = disable_raw_mode();
        order(LeaveAlternateScreen);
        order(Show);
    }
}

/// Tells the terminal something.
fn order(command: impl Command) {
    let mut words = Picture::default();
    let _ = words.queue(command).and_then(|words| words.flush());
}

/// What is drawn, on its way to the terminal: whoever draws does not wait for it.
#[derive(Default)]
struct Picture(Vec<u8>);

impl Write for Picture {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        // A terminal that is gone is found where there is something to be done about it.
        let _ = log::put(Stream::Out, &self.0);
        self.0.clear();
        Ok(())
    }
}

/// Shows the screen until a key, `over` or the driver's end closes it. `quit_word` is what `q` does, `reset_stop` how the emergency stop is
/// reset, at the driver's own terminal alone; `machine` is what the wires move, where it is simulated.
pub fn show(
    live: &mut Live,
    quit_word: &'static str,
    over: &dyn Fn() -> bool,
    reset_stop: Option<&dyn Fn()>,
    machine: Option<&Watch>,
) -> Outcome {
    let unusable = |error: io::Error| {
        Failure::own(format!("the terminal cannot be used: {error}")).hint("pipe the output to get plain lines")
    };
    let restore = Restore;
    enable_raw_mode().map_err(unusable)?;
    order(EnterAlternateScreen);
    let mut terminal = Terminal::new(CrosstermBackend::new(Picture::default())).map_err(unusable)?;
    let (keys, events) = events().map_err(unusable)?;
    let mut lost_keys = false;
    let palette = Palette::from_environment();
    let mut app = App::new(quit_word);
    app.resets_stop = reset_stop.is_some();
    let mut holding = Holding::new();
    let started = Instant::now();
    loop {
        let now_s = started.elapsed().as_secs_f64();
        app.update(live.look());
        app.machine = machine.map(Watch::picture);
        app.forget(now_s);
        if let Some(lost) = app.view.as_ref().and_then(|view| holding.watch(view)) {
            app.say(Message::Refused(lost), now_s);
        }
        app.held = holding.channels();
        // While the terminal has not taken the last picture there is no use in another one.
        let mut page = app.page;
        let drawn = !log::is_through() || terminal.draw(|frame| page = draw(frame, &app, palette)).is_ok();
        app.page = page;
        // a closed terminal ends the screen without an error
        if !drawn || log::is_gone() || over() || live.ended().is_some() || sinew_threads::is_struck() {
            break;
        }
        let mut action = Action::None;
        let next = Instant::now() + FRAME;
        while action == Action::None {
            match events.recv_timeout(next.saturating_duration_since(Instant::now())) {
                Ok(Event::Key(key)) if key.kind != KeyEventKind::Release => action = app.key(key, now_s),
                Ok(Event::Resize(..)) | Err(RecvTimeoutError::Timeout) => break,
                Ok(_) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    lost_keys = true;
                    action = Action::Quit;
                }
            }
        }
        match action {
            Action::None => {}
            Action::Quit => break,
            Action::Set(channel, setpoint) => {
                let answer = holding.set(live, channel, setpoint);
                say(&mut app, answer, now_s);
            }
            Action::Release(channel) => {
                let answer = holding.release(live, channel);
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
        if let Some(refused) = holding.renew(live) {
            app.say(Message::Refused(refused), now_s);
        }
    }
    drop(terminal);
    drop(restore);
    holding.finish(live);
    if lost_keys && !keys.join().is_ok_and(|read| read.is_some()) {
        return Err(Failure::own(format!("the thread that {} has died", Thread::Keys.row().does))
            .hint("please report it, with what stands above"));
    }
    Ok(())
}

/// Keys and resizes, read by a thread of their own: on a terminal that has gone away crossterm's reader never comes back, and
/// the screen must not wait for it.
fn events() -> io::Result<(JoinHandle<Option<()>>, Receiver<Event>)> {
    let (sender, receiver) = mpsc::channel();
    let is_over = Arc::new(AtomicBool::new(false));
    let over = is_over.clone();
    let start = Thread::Keys.start().ends_when(move || over.load(Ordering::Relaxed));
    let keys = start.spawn(move || {
        while !sinew_threads::is_struck() {
            let read = match event::poll(FRAME) {
                Ok(true) => event::read().map(Some),
                other => other.map(|_| None),
            };
            let goes_on = match read {
                Ok(Some(event)) => sender.send(event).is_ok(),
                Ok(None) => true,
                // a terminal that is gone
                Err(_) => false,
            };
            if !goes_on {
                is_over.store(true, Ordering::Relaxed);
                return;
            }
        }
    })?;
    Ok((keys, receiver))
}

fn say(app: &mut App, answer: Result<String, String>, now_s: f64) {
    let message = match answer {
        Ok(text) => Message::Done(text),
        Err(text) => Message::Refused(text),
    };
    app.say(message, now_s);
}
