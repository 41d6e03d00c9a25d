//! What is to be said of a driver where nothing is drawn: how things are, and what has changed since that was last said.

use sinew_ipc::Mode;

use super::view::{HeldBack, NEAR, Row, View, number, percent, words};
use crate::output::counted;

/// So much hotter or colder the hottest wire is worth a word, K, if the last one is so long ago, s.
const STEP_K: f64 = 20.0;
const STEP_S: f64 = 10.0;
/// Share of its limit below which the hottest wire is no longer near it.
const AWAY: f64 = 0.8;
/// So many names are said, and how many more there are.
const MOST_NAMES: usize = 4;

/// What was last said.
#[derive(Debug, Default)]
pub struct Changes {
    channels: Vec<Said>,
    first: Option<String>,
    is_stopped: bool,
    stands: bool,
    dead: usize,
    hottest: Option<Hottest>,
}

/// What was last said of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Said {
    mode: Mode,
    fault: Option<&'static str>,
    held_by: Option<HeldBack>,
}

/// What was last said of the hottest wire.
#[derive(Debug)]
struct Hottest {
    temperature_c: f64,
    at_s: f64,
    is_near: bool,
}

impl Said {
    fn of(row: &Row) -> Said {
        // the emergency stop is said once for all
        let held_by = row.held_by.filter(|held| *held != HeldBack::Stop);
        Said { mode: row.state.mode(), fault: row.fault.map(|fault| fault.flag), held_by }
    }
}

impl Changes {
    /// What has changed since the last look, a sentence each. The first look is what later ones are compared with, and says nothing.
    pub fn since(&mut self, view: &View) -> Vec<String> {
        let is_first = self.channels.is_empty();
        let mut sentences = self.of_all(view);
        let mut grouped: Vec<(String, Vec<&str>)> = Vec::new();
        let now: Vec<Said> = view.channels.iter().map(Said::of).collect();
        for ((row, before), now) in view.channels.iter().zip(&self.channels).zip(&now) {
            for phrase in changed(row, before, now) {
                match grouped.iter_mut().find(|(there, _)| *there == phrase) {
                    Some((_, names)) => names.push(&row.name),
                    None => grouped.push((phrase, vec![&row.name])),
                }
            }
        }
        self.channels = now;
        let all = view.channels.len();
        sentences.extend(grouped.into_iter().map(|(phrase, names)| format!("{}: {phrase}", named(&names, all))));
        if is_first { Vec::new() } else { sentences }
    }

    /// Of that what concerns not one channel.
    fn of_all(&mut self, view: &View) -> Vec<String> {
        let mut sentences = Vec::new();
        let stands = view.stands_still();
        if std::mem::replace(&mut self.stands, stands.is_some()) != stands.is_some() {
            sentences.push(stands.unwrap_or_else(|| "the loop runs again".into()));
        }
        if std::mem::replace(&mut self.dead, view.timing.dead.len()) < view.timing.dead.len() {
            sentences.extend(view.lacks());
        }
        let is_stopped = view.channels.iter().any(Row::is_stopped);
        if std::mem::replace(&mut self.is_stopped, is_stopped) != is_stopped {
            sentences.push(stop_words(is_stopped).into());
        }
        let first = view.first_of_several().map(|(name, fault)| first_words(name, fault.flag));
        if first != self.first {
            self.first.clone_from(&first);
            sentences.extend(first);
        }
        sentences.extend(self.of_the_hottest(view));
        sentences
    }

    /// Of the hottest wire: where it comes near its limit, or away from it again, and now and then where it has changed much.
    fn of_the_hottest(&mut self, view: &View) -> Option<String> {
        let row = view.hottest()?;
        let temperature_c = row.state.temperature_c;
        let at_s = view.uptime_s;
        let Some(said) = &mut self.hottest else {
            self.hottest = Some(Hottest { temperature_c, at_s, is_near: temperature_c > NEAR * row.limit_c });
            return None;
        };
        let is_near = temperature_c > if said.is_near { AWAY } else { NEAR } * row.limit_c;
        let is_far = (temperature_c - said.temperature_c).abs() >= STEP_K && at_s - said.at_s >= STEP_S;
        if is_near == said.is_near && !is_far {
            return None;
        }
        *said = Hottest { temperature_c, at_s, is_near };
        Some(format!("{}{}", if is_near { "near its limit: " } else { "" }, hottest_words(row)))
    }
}

/// What has changed of a channel.
fn changed(row: &Row, before: &Said, now: &Said) -> Vec<String> {
    let mut phrases = Vec::new();
    match (before.fault, row.fault) {
        (was, Some(fault)) if was != Some(fault.flag) => {
            phrases.push(format!("fault, {}: {}; {}", words(fault.flag), fault.cause, fault.remedy));
        }
        (Some(_), None) => phrases.push(format!("fault cleared, now {}", mode_words(now.mode))),
        (None, None) if before.mode != now.mode => phrases.push(format!("now {}", mode_words(now.mode))),
        _ => {}
    }
    // after a fault it gets nothing anyway
    match (before.held_by, now.held_by) {
        _ if now.fault.is_some() => {}
        (was, Some(held)) if was != Some(held) => phrases.push(format!("held back by {}", held.by())),
        (Some(_), None) => phrases.push("no longer held back".into()),
        _ => {}
    }
    phrases
}

/// How things are, a sentence for each thing.
pub fn summary(view: &View) -> Vec<String> {
    let mut counts: Vec<(Mode, usize)> = Vec::new();
    for mode in view.channels.iter().map(|row| row.state.mode()) {
        match counts.iter_mut().find(|(there, _)| *there == mode) {
            Some((_, count)) => *count += 1,
            None => counts.push((mode, 1)),
        }
    }
    let modes: Vec<String> = counts.iter().map(|(mode, count)| format!("{count} {}", mode_words(*mode))).collect();
    let mut sentences = vec![format!("{}: {}", counted(view.channels.len(), "channel"), modes.join(", "))];
    sentences.extend(view.stands_still());
    sentences.extend(view.lacks());
    if view.channels.iter().any(Row::is_stopped) {
        sentences.push(stop_words(true).into());
    }
    let faults = view.channels.iter().filter(|row| row.fault.is_some()).count();
    match faults {
        0 => sentences.push("no fault".into()),
        count => sentences.push(counted(count, "fault")),
    }
    sentences.extend(view.first_of_several().map(|(name, fault)| first_words(name, fault.flag)));
    for row in &view.channels {
        if let Some(trouble) = row.trouble().filter(|_| row.fault.is_some() || row.held_by.is_some()) {
            sentences.push(format!("{}: {trouble}", row.name));
        }
    }
    sentences.extend(view.hottest().map(hottest_words));
    let t = &view.timing;
    let rate = if t.rate_hz.is_finite() { format!(" at {:.0} Hz", t.rate_hz) } else { String::new() };
    let late_ms = number(1e-3 * t.lateness_us.max, 0, 2);
    sentences.push(format!("loop{rate}: {} missed, at most {late_ms} ms late", counted(t.missed as usize, "cycle")));
    sentences
}

/// A channel in a sentence.
pub fn channel(row: &Row) -> String {
    let share = |share: f64| percent(share).trim_start().to_string();
    let trouble = row.trouble().unwrap_or_else(|| mode_words(row.state.mode()).into());
    let target = row.target();
    let target = if target.is_finite() { format!(", target {} %", share(target)) } else { String::new() };
    let celsius = number(row.state.temperature_c, 0, 0);
    format!("{}: stroke {} %{target}, {celsius} °C, {trouble}", row.name, share(row.stroke()))
}

fn hottest_words(row: &Row) -> String {
    format!("hottest is {}: {:.0} of at most {:.0} °C, estimated", row.name, row.state.temperature_c, row.limit_c)
}

fn first_words(name: &str, flag: &str) -> String {
    format!("of several faults the first was that of {name}: {}", words(flag))
}

fn stop_words(is_stopped: bool) -> &'static str {
    if is_stopped { "the emergency stop holds everything off" } else { "the emergency stop is reset" }
}

fn mode_words(mode: Mode) -> &'static str {
    match mode {
        Mode::Waiting => "waiting for its sensors",
        Mode::Off => "off",
        Mode::Length => "commanded to a length",
        Mode::Duty => "commanded to a duty",
        Mode::Force => "commanded to a force",
        Mode::Program => "following the driver's program",
        Mode::Fault => "off by a fault",
        Mode::Lapsed => "off, its lease ran out",
    }
}

/// Names in a sentence; not more than can be listened to.
fn named(names: &[&str], of: usize) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_string(),
        all if all.len() == of => format!("all {of} channels"),
        few if few.len() <= MOST_NAMES => few.join(", "),
        many => format!("{} and {} more", many[..MOST_NAMES - 1].join(", "), many.len() + 1 - MOST_NAMES),
    }
}

#[cfg(test)]
mod tests {
    use sinew_ipc::ChannelState;

    use super::super::view::tests::hexapod;
    use super::*;

    /// A view in which nothing is wrong.
    fn good() -> View {
        let mut view = hexapod(18);
        for row in &mut view.channels {
            (row.fault, row.health, row.held_by) = (None, None, None);
            (row.state.mode, row.state.temperature_c) = (Mode::Program.code(), 60.0);
        }
        view
    }

    #[test]
    fn nothing_is_said_while_nothing_changes() {
        let mut changes = Changes::default();
        let mut view = good();
        assert!(changes.since(&view).is_empty(), "the first look is what it is compared with");
        for row in &mut view.channels {
            (row.state.length_m, row.state.duty, row.state.power_w) = (row.hot_m, 0.7, 1.0);
        }
        view.uptime_s += 100.0;
        assert!(changes.since(&view).is_empty());
    }

    #[test]
    fn faults_what_holds_back_and_modes_are_said_once_and_together_where_they_are_the_same() {
        let (mut changes, mut view) = (Changes::default(), good());
        changes.since(&view);
        view.channels[2].fault = hexapod(18).channels[6].fault;
        view.channels[2].state.mode = Mode::Fault.code();
        for index in [3, 4] {
            view.channels[index].held_by = Some(HeldBack::Heat);
        }
        let said = changes.since(&view);
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(
            said[0].starts_with("front_left_tibia: fault, open wire: no current flows; check the wire"),
            "{said:?}"
        );
        assert_eq!(said[1], "front_right_coxa, front_right_femur: held back by its heat budget");
        assert!(changes.since(&view).is_empty());
        view.channels[2].fault = None;
        view.channels.iter_mut().for_each(|row| row.state.mode = Mode::Off.code());
        view.channels[3].held_by = None;
        view.channels[4].held_by = Some(HeldBack::Temperature);
        let said = changes.since(&view);
        assert_eq!(
            said,
            [
                "front_left_coxa, front_left_femur, front_right_coxa and 14 more: now off",
                "front_left_tibia: fault cleared, now off",
                "front_right_coxa: no longer held back",
                "front_right_femur: held back by its temperature budget",
            ]
        );
        view.channels.iter_mut().for_each(|row| row.state.mode = Mode::Length.code());
        assert_eq!(changes.since(&view), ["all 18 channels: now commanded to a length"]);
    }

    #[test]
    fn an_emergency_stop_and_a_loop_that_stands_are_said_once_for_all() {
        let (mut changes, mut view) = (Changes::default(), good());
        changes.since(&view);
        for row in &mut view.channels {
            row.state.flags = ChannelState::FLAG_STOPPED;
            row.held_by = Some(HeldBack::Stop);
        }
        assert_eq!(changes.since(&view), ["the emergency stop holds everything off"]);
        view.age_s = 3.0;
        let said = changes.since(&view);
        assert!(said.len() == 1 && said[0].contains("the loop stands still"), "{said:?}");
        view = good();
        let said = changes.since(&view);
        assert_eq!(said, ["the loop runs again", "the emergency stop is reset"]);
    }

    #[test]
    fn the_hottest_is_said_near_its_limit_and_otherwise_now_and_then() {
        let (mut changes, mut view) = (Changes::default(), good());
        let mut at = |temperature_c: f64, later_s: f64| {
            view.uptime_s += later_s;
            view.channels[5].state.temperature_c = temperature_c;
            changes.since(&view)
        };
        assert!(at(61.0, 0.0).is_empty());
        assert!(at(90.0, 5.0).is_empty(), "it is not long ago");
        assert_eq!(at(90.0, 6.0), ["hottest is front_right_tibia: 90 of at most 140 °C, estimated"]);
        assert!(at(100.0, 60.0).is_empty(), "it is not much hotter");
        let near = at(127.0, 0.5);
        assert!(
            near.len() == 1 && near[0].starts_with("near its limit: hottest is front_right_tibia: 127"),
            "{near:?}"
        );
        assert!(at(120.0, 0.5).is_empty(), "it is still near");
        let away = at(105.0, 0.5);
        assert!(away.len() == 1 && away[0].starts_with("hottest is"), "{away:?}");
    }

    #[test]
    fn a_summary_names_all_there_is_to_know() {
        let said = summary(&hexapod(18)).join("\n");
        for word in
            ["18 channels: 17 following", "1 off by a fault", "1 fault\n", "middle_left_coxa: open wire: no current"]
        {
            assert!(said.contains(word), "{word}: {said}");
        }
        assert!(
            said.contains("middle_right_tibia: held back by its heat budget") && said.contains("hottest is "),
            "{said}"
        );
        assert_eq!(
            channel(&hexapod(1).channels[0]),
            "front_left_coxa: stroke 0 %, target 2 %, 40 °C, following the driver's program"
        );
        assert!(!summary(&good()).join("\n").contains("held back"));
    }
}
