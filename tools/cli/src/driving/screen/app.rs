//! The screen's state: selection, input line, last message, and recent history of every channel.

use std::collections::VecDeque;

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use sinew_demonstrators::Picture;

use super::view::{Row, View};
use crate::driving::setpoint::Setpoint;

/// How long the curves look back, s.
pub const HISTORY_S: f64 = 30.0;
/// By how much `+` and `-` move the stroke.
const STEP: f64 = 0.05;
/// Lines the help page has at the most.
const LONGEST_HELP: u16 = 40;

/// One moment of a channel.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Driver time, s.
    pub time_s: f64,
    /// Share of the stroke.
    pub stroke: f64,
    /// Share asked for; NaN when none is.
    pub target: f64,
}

/// What a key press asks of the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Nothing, or only the screen changes.
    None,
    /// Command a channel and hold it there.
    Set(usize, Setpoint),
    /// Let a held channel go.
    Release(usize),
    /// Clear a channel's fault.
    Reset(usize),
    /// Reset the emergency stop.
    ResetStop,
    /// Leave the screen.
    Quit,
}

/// What is said in the message line.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// A thing done.
    Done(String),
    /// A thing refused, with the remedy.
    Refused(String),
}

/// The screen's state.
#[derive(Debug)]
pub struct App {
    /// The latest look, if there was one.
    pub view: Option<View>,
    /// What the wires move looks like, where it is simulated.
    pub machine: Option<Picture>,
    /// Index of the channel the keys act on.
    pub selected: usize,
    /// What is being typed.
    pub entry: Option<String>,
    /// The message line, and until when it stands (screen time, s).
    pub message: Option<(Message, f64)>,
    /// The help page is up, from this of its lines on.
    pub help: Option<u16>,
    /// The selected channel's details are up.
    pub details: bool,
    /// How many channels were in sight in the last picture.
    pub page: usize,
    /// What `q` does, for the key line: "quit" or "stop".
    pub quit_word: &'static str,
    /// Whether the emergency stop may be reset here: at the driver's own terminal.
    pub resets_stop: bool,
    /// Channels this screen holds by renewing their lease.
    pub held: Vec<usize>,
    history: Vec<VecDeque<Moment>>,
}

impl App {
    /// A fresh screen.
    pub fn new(quit_word: &'static str) -> Self {
        App {
            view: None,
            machine: None,
            selected: 0,
            entry: None,
            message: None,
            help: None,
            details: false,
            page: 10,
            quit_word,
            resets_stop: false,
            held: Vec::new(),
            history: Vec::new(),
        }
    }

    /// Takes a new look at the driver.
    pub fn update(&mut self, view: View) {
        self.history.resize_with(view.channels.len(), VecDeque::new);
        self.selected = self.selected.min(view.channels.len().saturating_sub(1));
        for (past, row) in self.history.iter_mut().zip(&view.channels) {
            // another driver under the same name starts at zero again
            if past.back().is_some_and(|last| last.time_s > view.uptime_s) {
                past.clear();
            }
            if past.back().is_some_and(|last| last.time_s == view.uptime_s) {
                continue;
            }
            while past.front().is_some_and(|first| first.time_s < view.uptime_s - HISTORY_S) {
                past.pop_front();
            }
            past.push_back(Moment { time_s: view.uptime_s, stroke: row.stroke(), target: row.target() });
        }
        self.view = Some(view);
    }

    /// Whether an emergency stop holds everything off.
    pub fn is_stopped(&self) -> bool {
        self.view.as_ref().is_some_and(|view| view.channels.iter().any(Row::is_stopped))
    }

    /// What a channel did lately, oldest first.
    pub fn history(&self, channel: usize) -> impl Iterator<Item = &Moment> {
        self.history.get(channel).into_iter().flatten()
    }

    /// Shows a message for a while.
    pub fn say(&mut self, message: Message, now_s: f64) {
        let stands_s = if matches!(message, Message::Refused(_)) { 12.0 } else { 4.0 };
        self.message = Some((message, now_s + stands_s));
    }

    /// Forgets a message that has stood long enough.
    pub fn forget(&mut self, now_s: f64) {
        if self.message.as_ref().is_some_and(|(_, until)| *until < now_s) {
            self.message = None;
        }
    }

    /// One key.
    pub fn key(&mut self, key: KeyEvent, now_s: f64) -> Action {
        if key.modifiers.contains(KeyModifiers::CONTROL) && matches!(key.code, KeyCode::Char('c' | 'C')) {
            return Action::Quit;
        }
        if self.entry.is_some() {
            return self.type_key(key, now_s);
        }
        if let Some(from) = self.help {
            self.help = match key.code {
                KeyCode::Down | KeyCode::PageDown | KeyCode::Char('j') => {
                    Some(from.saturating_add(4).min(LONGEST_HELP))
                }
                KeyCode::Up | KeyCode::PageUp | KeyCode::Char('k') => Some(from.saturating_sub(4)),
                _ => None,
            };
            return Action::None;
        }
        let count = self.view.as_ref().map_or(0, |view| view.channels.len());
        match key.code {
            KeyCode::Char('q' | 'Q') => return Action::Quit,
            KeyCode::Char('?' | 'h') | KeyCode::F(1) => self.help = Some(0),
            KeyCode::Esc => (self.message, self.details) = (None, false),
            _ if count == 0 => {}
            KeyCode::Up | KeyCode::Char('k') => self.selected = self.selected.saturating_sub(1),
            KeyCode::Down | KeyCode::Char('j') => self.selected = (self.selected + 1).min(count - 1),
            KeyCode::PageUp => self.selected = self.selected.saturating_sub(self.page),
            KeyCode::PageDown => self.selected = (self.selected + self.page).min(count - 1),
            KeyCode::Home | KeyCode::Char('g') => self.selected = 0,
            KeyCode::End | KeyCode::Char('G') => self.selected = count - 1,
            KeyCode::Char('n') => self.select_next_trouble(),
            KeyCode::Char('d') => self.details = !self.details,
            KeyCode::Char('+' | '=') | KeyCode::Right => return self.nudge(STEP),
            KeyCode::Char('-' | '_') | KeyCode::Left => return self.nudge(-STEP),
            KeyCode::Char('o') => return Action::Set(self.selected, Setpoint::Off),
            KeyCode::Char('r') => return Action::Reset(self.selected),
            KeyCode::Char('x') if self.resets_stop => return Action::ResetStop,
            KeyCode::Char('x') => {
                let refused = "the emergency stop is reset by its own button, or with x where `sinew run` was typed";
                self.say(Message::Refused(refused.into()), now_s);
            }
            KeyCode::Char(' ') => return Action::Release(self.selected),
            KeyCode::Char(c) if c.is_ascii_digit() || c == '.' => self.entry = Some(c.to_string()),
            KeyCode::Char('s') | KeyCode::Enter => self.entry = Some(String::new()),
            _ => {}
        }
        Action::None
    }

    /// Selects the next channel that has a fault or is held back.
    fn select_next_trouble(&mut self) {
        let Some(view) = &self.view else { return };
        let has_trouble = |row: &Row| row.fault.is_some() || row.held_by.is_some();
        let (after, count) = (self.selected + 1, view.channels.len());
        let mut next = (0..count).map(|step| (after + step) % count);
        self.selected = next.find(|index| has_trouble(&view.channels[*index])).unwrap_or(self.selected);
    }

    fn type_key(&mut self, key: KeyEvent, now_s: f64) -> Action {
        let Some(entry) = &mut self.entry else { return Action::None };
        match key.code {
            KeyCode::Esc => self.entry = None,
            KeyCode::Backspace => {
                entry.pop();
            }
            KeyCode::Char(c) if entry.chars().count() < 24 && !c.is_control() => entry.push(c),
            KeyCode::Enter => {
                let typed = self.entry.take().unwrap_or_default();
                if typed.trim().is_empty() {
                    return Action::None;
                }
                match Setpoint::parse_typed(&typed) {
                    Ok(setpoint) => return Action::Set(self.selected, setpoint),
                    Err(error) => {
                        let name = self.view.as_ref().and_then(|view| view.channels.get(self.selected));
                        let name = name.map_or("", |row| row.name.as_str());
                        self.say(Message::Refused(format!("{name}: {}; {}", error.message, error.hint)), now_s);
                    }
                }
            }
            _ => {}
        }
        Action::None
    }

    /// Moves the selected channel's stroke from its target, or from where it is, to the next whole step.
    fn nudge(&self, by: f64) -> Action {
        let Some(row) = self.view.as_ref().and_then(|view| view.channels.get(self.selected)) else {
            return Action::None;
        };
        let from = [row.target(), row.stroke(), 0.0].into_iter().find(|share| share.is_finite()).unwrap_or(0.0);
        let steps = from / STEP;
        // a hair beyond, so that a target that already is on a step moves by a whole one
        let next = if by > 0.0 { (steps + 1e-6).floor() + 1.0 } else { (steps - 1e-6).ceil() - 1.0 };
        Action::Set(self.selected, Setpoint::Stroke((next * STEP).clamp(0.0, 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::view::tests::hexapod;
    use super::*;

    fn press(app: &mut App, code: KeyCode) -> Action {
        app.key(KeyEvent::new(code, KeyModifiers::NONE), 0.0)
    }

    fn app() -> App {
        let mut app = App::new("quit");
        app.update(hexapod(18));
        app
    }

    #[test]
    fn the_selection_stays_inside_the_table() {
        let mut app = app();
        press(&mut app, KeyCode::Up);
        assert_eq!(app.selected, 0);
        for _ in 0..40 {
            press(&mut app, KeyCode::Down);
        }
        assert_eq!(app.selected, 17);
        app.update(hexapod(3));
        assert_eq!(app.selected, 2);
    }

    #[test]
    fn plus_and_minus_step_to_whole_steps_and_stop_at_the_ends() {
        let mut app = app();
        let mut view = hexapod(1);
        for (at, plus, minus) in [(0.42, 0.45, 0.40), (0.45, 0.50, 0.40), (1.0, 1.0, 0.95), (0.0, 0.05, 0.0)] {
            let row = &mut view.channels[0];
            row.state.target_m = row.cold_m - at * (row.cold_m - row.hot_m);
            app.update(view.clone());
            for (key, expected) in [('+', plus), ('-', minus)] {
                let Action::Set(0, Setpoint::Stroke(found)) = press(&mut app, KeyCode::Char(key)) else {
                    panic!("{at} {key}")
                };
                assert!((found - expected).abs() < 1e-9, "{at} {key}: {found}");
            }
        }
    }

    #[test]
    fn digits_are_typed_until_enter_sends_them() {
        let mut app = app();
        for key in ['3', '5', '7'] {
            assert_eq!(press(&mut app, KeyCode::Char(key)), Action::None);
        }
        press(&mut app, KeyCode::Backspace);
        let Action::Set(0, Setpoint::Stroke(stroke)) = press(&mut app, KeyCode::Enter) else { panic!() };
        assert!((stroke - 0.35).abs() < 1e-12);
        // q is a letter while typing, and a bad entry is explained
        press(&mut app, KeyCode::Char('9'));
        assert_eq!(press(&mut app, KeyCode::Char('q')), Action::None);
        assert_eq!(press(&mut app, KeyCode::Enter), Action::None);
        assert!(matches!(&app.message, Some((Message::Refused(_), _))));
        press(&mut app, KeyCode::Char('9'));
        press(&mut app, KeyCode::Esc);
        assert_eq!(app.entry, None);
        assert_eq!(press(&mut app, KeyCode::Char('q')), Action::Quit);
    }

    #[test]
    fn the_help_page_swallows_one_key() {
        let mut app = app();
        press(&mut app, KeyCode::Char('?'));
        assert!(app.help.is_some());
        assert_eq!(press(&mut app, KeyCode::Char('o')), Action::None);
        assert!(app.help.is_none());
        assert_eq!(press(&mut app, KeyCode::Char('o')), Action::Set(0, Setpoint::Off));
    }

    #[test]
    fn no_key_does_harm_before_the_first_look() {
        let mut app = App::new("quit");
        for code in [KeyCode::Up, KeyCode::Down, KeyCode::End, KeyCode::Char('+'), KeyCode::Char('o'), KeyCode::Enter] {
            assert_eq!(press(&mut app, code), Action::None);
        }
    }

    #[test]
    fn the_past_is_kept_for_its_time_and_forgotten_with_its_driver() {
        let mut app = App::new("quit");
        let mut view = hexapod(1);
        for tick in 0..1000 {
            view.uptime_s = f64::from(tick) * 0.1;
            app.update(view.clone());
        }
        let kept: Vec<f64> = app.history(0).map(|moment| moment.time_s).collect();
        assert!(kept.len() >= 300 && kept[0] >= 99.9 - HISTORY_S - 1e-9, "{}", kept.len());
        view.uptime_s = 0.5;
        app.update(view);
        assert_eq!(app.history(0).count(), 1);
    }
}
