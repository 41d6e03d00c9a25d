//! The monitor in words: sentences, a line each, for screen readers, braille lines, terminals without a cursor, and logs. What has changed is said, nothing
//! is drawn over, and commands are typed as lines.

use std::io::IsTerminal as _;
use std::thread;
use std::time::{Duration, Instant};

use sinew_rig::nearest;

use super::app::Action;
use super::changes::{self, Changes};
use super::holding::Holding;
use super::view::View;
use crate::driving::live::Live;
use crate::driving::setpoint::Setpoint;
use crate::driving::typed::Lines;
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output::{self, counted};

/// How often leases are looked after, and lines taken.
const LOOK: Duration = Duration::from_millis(50);
/// How often what has changed is said: what happens together is said together.
const TELL: Duration = Duration::from_millis(500);

/// The commands: how each is typed, and what it does.
const COMMANDS: [(&str, &str); 10] = [
    ("set NAME SETPOINT", "hold a channel there: set NAME 40%, 6mm, 2N, duty=0.1; a bare number is the stroke in %"),
    ("off NAME", "switch a channel off"),
    ("release NAME", "let a channel go that is held from here"),
    ("reset NAME", "clear a channel's fault"),
    ("reset-stop", "reset the emergency stop, where `sinew run` was typed"),
    ("status", "how everything is, a line for each channel; Enter alone: in short"),
    ("status NAME", "all there is to know of a channel"),
    ("stop", "stop the driver: all outputs to zero"),
    ("help", "these lines"),
    ("quit", "the end, as by Ctrl-D and Ctrl-C; what is held from here is let go"),
];

/// What a line asks for.
#[derive(Debug, Clone, PartialEq)]
enum Order {
    /// What keys ask for as well.
    Act(Action),
    /// To say something.
    Say(Vec<String>),
    /// To stop the driver.
    Stop,
}

/// How it is to be told.
#[derive(Clone, Copy)]
pub struct Telling<'a> {
    /// What `quit` does: "quit" or "stop".
    pub quit_word: &'static str,
    /// A summary is said so often, unless it is asked for.
    pub every: Option<Duration>,
    /// Stdout is wanted for something else: it is told on stderr.
    pub stdout_taken: bool,
    /// How the emergency stop is reset, at the driver's own terminal alone.
    pub reset_stop: Option<&'a dyn Fn()>,
}

/// Tells of a driver until `quit`, `over` or the driver's end.
pub fn tell(live: &mut Live, over: &dyn Fn() -> bool, telling: Telling<'_>) -> Outcome {
    let (mut changes, mut holding, mut lines) = (Changes::default(), Holding::new(), Lines::default());
    let is_typed = std::io::stdin().is_terminal();
    // a listener knows when it is now; a file does not
    let stamped = !std::io::stdout().is_terminal();
    let say = |view: &View, sentences: Vec<String>| -> Result<bool, Failure> {
        let stamp = if stamped { format!("{:.1} s: ", view.uptime_s) } else { String::new() };
        let text: String =
            sentences.iter().flat_map(|text| text.lines()).map(|line| format!("{stamp}{line}\n")).collect();
        match (text.is_empty(), telling.stdout_taken) {
            (true, _) => Ok(true),
            (false, true) => {
                output::note(text.trim_end());
                Ok(true)
            }
            (false, false) => output::try_print(text),
        }
    };
    let mut view = live.look();
    changes.since(&view);
    let mut greeting = vec![format!(
        "{}: {} at {} Hz, process {}; type help for the commands, Enter for how things are",
        view.rig,
        counted(view.channels.len(), "channel"),
        view.rate_hz,
        view.pid
    )];
    greeting.extend(changes::summary(&view));
    let mut goes_on = say(&view, greeting)?;
    let (mut told, mut summed) = (Instant::now(), Instant::now());
    while goes_on && !over() && !log::is_gone() && live.ended().is_none() && !sinew_threads::is_struck() {
        let line = match lines.is_at_end() {
            // somebody at a terminal wants the end; of a pipe there is no more to come
            true if is_typed => break,
            true => {
                thread::sleep(LOOK);
                None
            }
            // not in the foreground of its terminal now
            false => lines.next(LOOK).unwrap_or_else(|_| {
                thread::sleep(LOOK);
                None
            }),
        };
        view = live.look();
        let mut sentences: Vec<String> = holding.watch(&view).into_iter().collect();
        sentences.extend(holding.renew(live).map(refused));
        if told.elapsed() >= TELL {
            told = Instant::now();
            sentences.extend(changes.since(&view));
        }
        if telling.every.is_some_and(|every| summed.elapsed() >= every) {
            summed = Instant::now();
            sentences.extend(changes::summary(&view));
        }
        let mut ends = false;
        if let Some(line) = line {
            match order(&line, &view, telling) {
                Ok(Order::Say(answer)) => sentences.extend(answer),
                Ok(Order::Stop) => sentences.push(live.stop().unwrap_or_else(refused)),
                Ok(Order::Act(Action::Quit)) => ends = true,
                Ok(Order::Act(action)) => {
                    sentences
                        .extend(act(action, live, &mut holding, telling).map(|answer| answer.unwrap_or_else(refused)));
                }
                Err(why) => sentences.push(refused(why)),
            }
        }
        goes_on = say(&view, sentences)? && !ends;
    }
    // what happened last, as why it ended
    say(&view, changes.since(&live.look()))?;
    holding.finish(live);
    Ok(())
}

fn refused(why: String) -> String {
    format!("refused: {why}")
}

/// Does it; what is to be said of it, or why it was refused.
fn act(action: Action, live: &Live, holding: &mut Holding, telling: Telling<'_>) -> Option<Result<String, String>> {
    match action {
        Action::None | Action::Quit => None,
        Action::Set(channel, setpoint) => Some(holding.set(live, channel, setpoint)),
        Action::Release(channel) => Some(holding.release(live, channel)),
        Action::Reset(channel) => Some(live.reset(channel)),
        Action::ResetStop => {
            telling.reset_stop?();
            Some(Ok("emergency stop reset, if it is closed; reset NAME resets a channel".into()))
        }
    }
}

/// What a line asks for, or what is wrong with it and would be right.
fn order(line: &str, view: &View, telling: Telling<'_>) -> Result<Order, String> {
    let mut rest = line.split_whitespace();
    let Some(word) = rest.next() else { return Ok(Order::Say(changes::summary(view))) };
    // a setpoint may be typed with blanks in it
    let (name, more) = (rest.next(), rest.collect::<Vec<_>>().join(" "));
    let channel = |name: Option<&str>| channel(view, word, name);
    let alone = |order: Order| match name {
        None => Ok(order),
        Some(_) => Err(format!("`{word}` is typed alone")),
    };
    let only = |order: Order| match more.is_empty() {
        true => Ok(order),
        false => Err(format!("`{word}` takes one channel; `{more}` is too much")),
    };
    match word {
        "set" if more.is_empty() && name.is_some() => {
            Err(format!("`{line}` has no setpoint; type it as in set NAME 40%"))
        }
        "set" => {
            let (channel, of) = (channel(name)?, name.unwrap_or_default());
            let setpoint = Setpoint::parse_typed(&more);
            setpoint
                .map(|to| Order::Act(Action::Set(channel, to)))
                .map_err(|e| format!("{of}: {}; {}", e.message, e.hint))
        }
        "off" => only(Order::Act(Action::Set(channel(name)?, Setpoint::Off))),
        "release" => only(Order::Act(Action::Release(channel(name)?))),
        "reset" => only(Order::Act(Action::Reset(channel(name)?))),
        "reset-stop" if telling.reset_stop.is_none() => {
            Err("the emergency stop is reset by its own button, or where `sinew run` was typed".into())
        }
        "reset-stop" => alone(Order::Act(Action::ResetStop)),
        "status" if name.is_some() => {
            let row = &view.channels[channel(name)?];
            let details = row.details().into_iter().map(|(label, value)| format!("{label}: {value}"));
            only(Order::Say(std::iter::once(changes::channel(row)).chain(details).collect()))
        }
        "status" => {
            let channels = view.channels.iter().map(changes::channel);
            Ok(Order::Say(changes::summary(view).into_iter().chain(channels).collect()))
        }
        "stop" => alone(Order::Stop),
        "help" => {
            Ok(Order::Say(COMMANDS.map(|(typed, does)| format!("{typed}: {}", does_here(typed, does, telling))).into()))
        }
        "quit" => alone(Order::Act(Action::Quit)),
        unknown => {
            let words = COMMANDS.map(|(typed, _)| typed.split(' ').next().unwrap_or(typed));
            let near = nearest(unknown, words).map_or_else(String::new, |near| format!("did you mean {near}? "));
            Err(format!("`{unknown}` is no command; {near}help tells them"))
        }
    }
}

/// What a command does, where `quit` ends the driver as well.
fn does_here(typed: &str, does: &str, telling: Telling<'_>) -> String {
    match (typed, telling.quit_word) {
        ("quit", "stop") => {
            "the end of the driver as well, as by Ctrl-D and Ctrl-C: all outputs to zero, then the report".into()
        }
        _ => does.into(),
    }
}

/// The number of a channel.
fn channel(view: &View, word: &str, name: Option<&str>) -> Result<usize, String> {
    let names = || view.channels.iter().map(|row| row.name.as_str());
    let Some(name) = name else { return Err(format!("`{word}` needs the name of a channel; status tells them")) };
    let found = names().position(|there| there == name);
    found.ok_or_else(|| match nearest(name, names()) {
        Some(near) => format!("there is no channel {name}; did you mean {near}?"),
        None => format!("there is no channel {name}; status tells them"),
    })
}

#[cfg(test)]
mod tests {
    use super::super::view::tests::hexapod;
    use super::*;

    const AWAY: Telling<'static> = Telling { quit_word: "quit", every: None, stdout_taken: false, reset_stop: None };

    fn ordered(line: &str) -> Result<Order, String> {
        order(line, &hexapod(18), AWAY)
    }

    #[test]
    fn what_is_typed_is_what_the_keys_do() {
        let act = |line| match ordered(line) {
            Ok(Order::Act(action)) => action,
            other => panic!("{line}: {other:?}"),
        };
        assert_eq!(act("set front_left_femur 40%"), Action::Set(1, Setpoint::Stroke(0.4)));
        assert_eq!(act("  set front_left_femur stroke = 50 % "), Action::Set(1, Setpoint::Stroke(0.5)));
        assert_eq!(act("set front_left_femur 35"), Action::Set(1, Setpoint::parse_typed("35").unwrap()));
        assert_eq!(act("off front_left_coxa"), Action::Set(0, Setpoint::Off));
        assert_eq!(act("release front_left_coxa"), Action::Release(0));
        assert_eq!(act("reset rear_right_tibia"), Action::Reset(17));
        assert_eq!(act("quit"), Action::Quit);
        assert_eq!(ordered("stop"), Ok(Order::Stop));
        let reset = || {};
        let here = Telling { quit_word: "stop", reset_stop: Some(&reset), ..AWAY };
        assert_eq!(order("reset-stop", &hexapod(1), here), Ok(Order::Act(Action::ResetStop)));
    }

    #[test]
    fn what_is_wrong_is_told_with_what_would_be_right() {
        for (line, says) in [
            ("sett front_left_femur 40%", "did you mean set?"),
            ("jump", "help tells them"),
            ("set", "needs the name of a channel"),
            ("set front_left_femur", "has no setpoint"),
            ("set front_left_femor 40%", "did you mean front_left_femur?"),
            ("set front_left_femur up", "front_left_femur: `up` is not a setpoint"),
            ("off", "needs the name"),
            ("off front_left_coxa front_left_femur", "takes one channel"),
            ("stop front_left_coxa", "typed alone"),
            ("quit now", "typed alone"),
            ("reset-stop", "its own button"),
        ] {
            let said = ordered(line).expect_err(line);
            assert!(said.contains(says), "{line}: {said}");
        }
    }

    #[test]
    fn a_channels_status_has_all_of_its_details_and_help_every_command() {
        let Ok(Order::Say(said)) = ordered("status front_left_femur") else { panic!() };
        let said = said.join("\n");
        for word in
            ["front_left_femur: stroke 37 %", "length: ", "temperature: ", "at most: 140 °C", "power: ", "setpoint: "]
        {
            assert!(said.contains(word), "{word}: {said}");
        }
        let Ok(Order::Say(all)) = ordered("status") else { panic!() };
        assert!(all.len() > 18 && all.join("\n").contains("rear_right_tibia: stroke"), "{all:?}");
        let Ok(Order::Say(help)) = ordered("help") else { panic!() };
        for (typed, _) in COMMANDS {
            assert!(help.iter().any(|line| line.starts_with(&format!("{typed}: "))), "{typed}: {help:?}");
            let word = typed.split(' ').next().unwrap();
            assert!(!ordered(word).is_err_and(|why| why.contains("is no command")), "{word}");
        }
        assert_eq!(ordered(""), Ok(Order::Say(changes::summary(&hexapod(18)))));
    }
}
