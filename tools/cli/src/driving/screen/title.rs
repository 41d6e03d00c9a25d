//! The screen's title: faults, wires that are held back, the hottest of them, and what else there is room for.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use super::style::Palette;
use super::view::{NEAR, View, words};
use crate::output::counted;

/// The title, in as many lines as it takes up to so many. What concerns the wires' safety is always there; of the rest, what there is room for.
pub fn title_lines(view: &View, palette: Palette, width: u16, most: usize) -> Vec<Line<'static>> {
    let faults = view.channels.iter().filter(|row| row.fault.is_some()).count();
    let held = view.channels.iter().filter(|row| row.fault.is_none() && row.held_by.is_some()).count();
    let name = Span::styled(format!(" sinew · {} ", view.rig), palette.title().add_modifier(Modifier::REVERSED));
    // what is left out first has the highest number, what stays has none
    let mut parts = vec![(None, name)];
    if view.age_s > 0.5 {
        parts.push((None, Span::styled(format!("▲ nothing new for {:.1} s", view.age_s), palette.warning())));
    }
    match (faults, view.first_of_several()) {
        (0, _) => {}
        (count, first) => {
            parts.push((None, Span::styled(format!("✖ {}", counted(count, "fault")), palette.fault())));
            if let Some((name, fault)) = first {
                parts.push((None, Span::styled(format!("first {name}: {}", words(fault.flag)), palette.fault())));
            }
        }
    }
    if held > 0 {
        parts.push((None, Span::styled(format!("▼ {held} held back"), palette.warning())));
    }
    if let Some(row) = view.hottest() {
        let (now, limit) = (row.state.temperature_c, row.limit_c);
        let style = if now > NEAR * limit { palette.warning() } else { Style::new() };
        parts.push((None, Span::styled(format!("hottest {} {now:.0}/{limit:.0} °C", row.name), style)));
    }
    let channels = format!("{} at {:.0} Hz", counted(view.channels.len(), "channel"), view.rate_hz);
    parts.push((Some(1), Span::raw(channels)));
    parts.push((Some(2), Span::raw(clock(view.uptime_s))));
    parts.push((Some(3), Span::raw(format!("pid {}", view.pid))));
    let with = |least: u32, most: usize| {
        let kept = parts.iter().filter(|(left_out, _)| left_out.is_none_or(|place| place < least));
        wrapped(kept.map(|(_, span)| span.clone()), width, most)
    };
    // rather without the rest than in one line more
    let mut tries = (1..=most).flat_map(|lines| [4, 3, 2, 1].map(|least| (least, lines)));
    let fitting = tries.find_map(|(least, lines)| with(least, lines).ok());
    fitting.unwrap_or_else(|| with(1, most).unwrap_or_else(|lines| lines))
}

/// Parts in lines, two cells between them; too many lines, or too long ones, are an error, and cut.
fn wrapped(
    parts: impl Iterator<Item = Span<'static>>,
    width: u16,
    most: usize,
) -> Result<Vec<Line<'static>>, Vec<Line<'static>>> {
    let (mut lines, mut line) = (Vec::new(), Line::default());
    for part in parts {
        if line.width() > 0 && line.width() + 2 + part.width() > width as usize {
            lines.push(std::mem::take(&mut line));
        }
        let gap = match (line.width(), lines.len()) {
            (0, 0) => "",
            (0, _) => " ",
            _ => "  ",
        };
        line.push_span(gap);
        line.push_span(part);
    }
    lines.push(line);
    let is_cut = lines.len() > most || lines.iter().any(|line| line.width() > width as usize);
    lines.truncate(most);
    if is_cut { Err(lines) } else { Ok(lines) }
}

/// Hours, minutes and seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    match whole / 3600 {
        0 => format!("{}:{:02}", whole / 60, whole % 60),
        hours => format!("{hours}:{:02}:{:02}", whole / 60 % 60, whole % 60),
    }
}
