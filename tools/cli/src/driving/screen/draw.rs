//! Draws the screen: a title, a table of all channels, the selected channel's chart, the loop's statistics, the keys.
//!
//! Eighteen channels fit into 80 × 24. Additional space goes to the bars, to columns of lower priority, and to a
//! chart of the selected channel; on smaller screens these shrink first, and the table scrolls.

use crate::output::counted;
use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Borders, Chart, Clear, Dataset, GraphType, Paragraph, Widget, Wrap};
use sinew_ipc::{ChannelState, Detail, Mode};

use super::app::{App, HISTORY_S, Message};
use super::machine::{self, draw_machine};
use super::style::Palette;
use super::view::{Row, View, micros, number, percent};

/// Below this a chart says less than a sparkline.
const CHART_ROWS: u16 = 7;

/// Draws everything.
pub fn draw(frame: &mut Frame, app: &App, palette: Palette) {
    let area = frame.area();
    if area.width < 20 || area.height < 4 {
        frame.render_widget("too small", area);
        return;
    }
    let Some(view) = &app.view else {
        frame.render_widget("waiting for the driver …", area);
        return;
    };
    let mut rows = Rows { area, next: area.y, last: area.bottom() };
    // from both ends inwards, the table takes what is left
    let title = rows.top(1);
    let keys = rows.bottom(1);
    let timing = if rows.left() > 3 { rows.bottom(1) } else { Rect::ZERO };
    let table_rows = view.channels.len() as u16 + 1;
    let said = message_line(app, view, palette);
    // what does not fit into a line may take the rows the table does not need
    let needed = (said.width() as u16).div_ceil(area.width).clamp(1, 3);
    let message = match rows.left().saturating_sub(table_rows) {
        _ if rows.left() <= 3 => Rect::ZERO,
        spare => rows.bottom(needed.min(spare.max(1))),
    };
    let machine = match (&app.machine, rows.left().saturating_sub(table_rows)) {
        (Some(_), machine::LEAST_ROWS..) => rows.top((rows.left() - table_rows).min(machine::MOST_ROWS)),
        _ => Rect::ZERO,
    };
    let spare = rows.left().saturating_sub(table_rows);
    let course = match spare {
        0 => Rect::ZERO,
        1..CHART_ROWS => rows.bottom(1),
        _ => rows.bottom(spare.min(24)),
    };
    let table = rows.top(rows.left());

    draw_title(frame.buffer_mut(), title, view, palette);
    if let Some(picture) = &app.machine {
        draw_machine(frame, machine, picture, palette);
    }
    draw_table(frame.buffer_mut(), table, app, view, palette);
    if course.height >= CHART_ROWS {
        draw_course(frame, course, app, view, palette);
    } else if course.height > 0 {
        draw_sparkline(frame.buffer_mut(), course, app, view, palette);
    }
    frame.render_widget(Paragraph::new(said).wrap(Wrap { trim: false }), message);
    draw_timing(frame.buffer_mut(), timing, view, palette);
    draw_keys(frame.buffer_mut(), keys, app, palette);
    if app.help {
        draw_help(frame, app, palette);
    }
}

/// Hands out rows from the top and the bottom.
struct Rows {
    area: Rect,
    next: u16,
    last: u16,
}

impl Rows {
    fn left(&self) -> u16 {
        self.last - self.next
    }

    fn top(&mut self, height: u16) -> Rect {
        let height = height.min(self.left());
        let taken = Rect { y: self.next, height, ..self.area };
        self.next += height;
        taken
    }

    fn bottom(&mut self, height: u16) -> Rect {
        let height = height.min(self.left());
        self.last -= height;
        Rect { y: self.last, height, ..self.area }
    }
}

fn draw_title(buffer: &mut Buffer, area: Rect, view: &View, palette: Palette) {
    let faults = view.channels.iter().filter(|row| row.fault.is_some()).count();
    let mut spans = vec![
        Span::styled(format!(" sinew · {} ", view.rig), palette.title().add_modifier(Modifier::REVERSED)),
        Span::raw(format!(
            "  {} at {:.0} Hz  {}  pid {}",
            counted(view.channels.len(), "channel"),
            view.rate_hz,
            clock(view.uptime_s),
            view.pid
        )),
    ];
    match faults {
        0 => {}
        1 => spans.push(Span::styled("  ✖ 1 fault", palette.fault())),
        n => spans.push(Span::styled(format!("  ✖ {n} faults"), palette.fault())),
    }
    if let Some((name, fault)) = view.first_of_several() {
        spans.push(Span::styled(format!(", first {name}: {}", words(fault.flag)), palette.fault()));
    }
    if view.age_s > 0.5 {
        spans.push(Span::styled(format!("  ▲ nothing new for {:.1} s", view.age_s), palette.warning()));
    }
    Line::from(spans).render(area, buffer);
}

/// One column of the table.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Name,
    Bar,
    Stroke,
    Target,
    Length,
    Duty,
    Resistance,
    Temperature,
    Martensite,
    Power,
    State,
}

/// The columns that fit, with their widths; one cell stands between two of them.
fn columns(width: u16, view: &View) -> Vec<(Column, u16)> {
    use Column::*;
    let longest = view.channels.iter().map(|row| row.name.chars().count()).max().unwrap_or(4) as u16;
    let mut chosen = vec![
        (Name, longest.clamp(7, 24)),
        (Bar, 8),
        (Stroke, 4),
        (Target, 4),
        (Length, 7),
        (Duty, 4),
        (Resistance, 6),
        (Temperature, 4),
        (Martensite, 4),
        (Power, 5),
        (State, 12),
    ];
    let needed = |chosen: &[(Column, u16)]| 1 + chosen.iter().map(|(_, w)| w + 1).sum::<u16>();
    for least in [Length, Martensite, Resistance, Power, Temperature, Duty, Target, Bar, Stroke, State] {
        if needed(&chosen) <= width {
            break;
        }
        chosen.retain(|(column, _)| *column != least);
    }
    let spare = width.saturating_sub(needed(&chosen));
    let state_extra = (spare / 4).min(12);
    for (column, w) in &mut chosen {
        match column {
            State => *w += state_extra,
            Bar => *w += (spare - state_extra).min(52),
            _ => {}
        }
    }
    chosen
}

fn heading(column: Column, width: u16) -> String {
    let w = width as usize;
    match column {
        Column::Name => format!("{:<w$}", "channel"),
        Column::Bar if w >= 12 => format!("cold{:>rest$}", "hot", rest = w - 4),
        Column::Bar => format!("{:<w$}", "stroke"),
        Column::Stroke => format!("{:>w$}", "%"),
        Column::Target => format!("{:>w$}", "→ %"),
        Column::Length => format!("{:>w$}", "mm"),
        Column::Duty => format!("{:>w$}", "duty"),
        Column::Resistance => format!("{:>w$}", "Ω"),
        Column::Temperature => format!("{:>w$}", "≈°C"),
        Column::Martensite => format!("{:>w$}", "≈ξ"),
        Column::Power => format!("{:>w$}", "W"),
        Column::State => format!("{:<w$}", "state"),
    }
}

fn draw_table(buffer: &mut Buffer, area: Rect, app: &App, view: &View, palette: Palette) {
    if area.height == 0 {
        return;
    }
    let columns = columns(area.width, view);
    let put = |buffer: &mut Buffer, x: u16, y: u16, text: &str, width: u16, style: Style| {
        let room = area.right().saturating_sub(x).min(width);
        buffer.set_stringn(x, y, clip(text, room as usize), room as usize, style);
    };
    let mut x = area.x + 1;
    for (column, width) in &columns {
        put(buffer, x, area.y, &heading(*column, *width), *width, palette.label());
        x += width + 1;
    }
    let visible = (area.height - 1) as usize;
    if visible == 0 {
        return;
    }
    let count = view.channels.len();
    // the page that keeps the selection in sight
    let first = if count <= visible { 0 } else { app.selected.saturating_sub(visible / 2).min(count - visible) };
    for (index, row) in view.channels.iter().enumerate().skip(first).take(visible) {
        let y = area.y + 1 + (index - first) as u16;
        let selected = index == app.selected;
        let base = if selected { palette.selected() } else { Style::new() };
        let more = (index == first && first > 0, index == first + visible - 1 && index + 1 < count);
        let marker = match (selected, more) {
            (true, _) => "▶",
            (_, (true, _)) => "↑",
            (_, (_, true)) => "↓",
            _ => " ",
        };
        put(buffer, area.x, y, marker, 1, base);
        let mut x = area.x + 1;
        for (column, width) in &columns {
            let w = *width as usize;
            let number = |value: f64, decimals: usize| number(value, w, decimals);
            match column {
                Column::Name if app.held.contains(&index) => {
                    put(buffer, x, y, &format!("{}*", clip(&row.name, w - 1)), *width, base)
                }
                Column::Name => put(buffer, x, y, &row.name, *width, base),
                Column::Bar => draw_bar(buffer, Rect { x, y, width: *width, height: 1 }, row, palette),
                Column::Stroke => put(buffer, x, y, &format!("{:>w$}", percent(row.stroke())), *width, base),
                Column::Target => {
                    put(buffer, x, y, &format!("{:>w$}", percent(row.target())), *width, palette.target())
                }
                Column::Length => put(buffer, x, y, &number(row.state.length_m * 1e3, 2), *width, base),
                Column::Duty => put(buffer, x, y, &number(row.state.duty, 2), *width, base),
                Column::Resistance => put(buffer, x, y, &number(row.state.resistance_ohm, 2), *width, base),
                Column::Temperature => put(buffer, x, y, &number(row.state.temperature_c, 0), *width, base),
                Column::Martensite => put(buffer, x, y, &number(row.state.martensite, 2), *width, base),
                Column::Power => put(buffer, x, y, &number(row.state.power_w, 2), *width, base),
                Column::State => {
                    let (text, style) = match (row.fault, row.health, row.held_by) {
                        (Some(fault), _, _) => (format!("✖ {}", words(fault.flag)), palette.fault()),
                        (None, Some(health), _) => (format!("▲ {health}"), palette.warning()),
                        (None, None, Some(budget)) => (format!("▼ {budget}"), palette.warning()),
                        (None, None, None) => (row.mode().to_string(), base),
                    };
                    put(buffer, x, y, &text, *width, style);
                }
            }
            x += width + 1;
        }
    }
}

/// A flag as a person would write it.
fn words(flag: &str) -> String {
    flag.replace('_', " ")
}

/// The stroke as a bar from cold (left) to hot (right) in eighths of a cell, with the target as a mark on it.
fn draw_bar(buffer: &mut Buffer, area: Rect, row: &Row, palette: Palette) {
    const EIGHTHS: [&str; 8] = [" ", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let width = area.width as usize;
    let stroke = row.stroke();
    let eighths = if stroke.is_finite() { (stroke.clamp(0.0, 1.0) * (width * 8) as f64).round() as usize } else { 0 };
    let target = row.target();
    let mark = target.is_finite().then(|| (target.clamp(0.0, 1.0) * (width - 1) as f64).round() as usize);
    for at in 0..width {
        let filled = eighths.saturating_sub(at * 8).min(8);
        let (symbol, style) = match filled {
            _ if !stroke.is_finite() => ("╌", palette.label()),
            0 => ("·", palette.label()),
            8 => ("█", palette.bar()),
            part => (EIGHTHS[part], palette.bar()),
        };
        let (symbol, style) = match mark {
            Some(mark) if mark == at && filled == 8 => ("┃", palette.target_on_bar()),
            Some(mark) if mark == at => ("┃", palette.target()),
            _ => (symbol, style),
        };
        buffer.set_string(area.x + at as u16, area.y, symbol, style);
    }
}

/// The selected channel's stroke over the last seconds in one line.
fn draw_sparkline(buffer: &mut Buffer, area: Rect, app: &App, view: &View, palette: Palette) {
    const LEVELS: [&str; 8] = ["▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"];
    let Some(row) = view.channels.get(app.selected) else { return };
    let label = format!(" {} ", row.name);
    let tail = format!(" {HISTORY_S:.0} s");
    let room = (area.width as usize).saturating_sub(label.chars().count() + tail.chars().count());
    let mut line = vec![None; room];
    for moment in app.history(app.selected) {
        let age = (view.uptime_s - moment.time_s) / HISTORY_S;
        let at = ((1.0 - age) * room as f64).ceil() as usize;
        if (1..=room).contains(&at) && moment.stroke.is_finite() {
            line[at - 1] = Some((moment.stroke.clamp(0.0, 1.0) * 7.0).round() as usize);
        }
    }
    let curve: String = line.iter().map(|level| level.map_or(" ", |level| LEVELS[level])).collect();
    Line::from(vec![
        Span::styled(label, palette.label()),
        Span::styled(curve, palette.bar()),
        Span::styled(tail, palette.label()),
    ])
    .render(area, buffer);
}

/// The selected channel's course as a chart, its figures beside it.
fn draw_course(frame: &mut Frame, area: Rect, app: &App, view: &View, palette: Palette) {
    let Some(row) = view.channels.get(app.selected) else { return };
    let side = if area.width >= 70 { (area.width / 3).clamp(28, 44) } else { 0 };
    let chart = Rect { width: area.width - side, ..area };
    let points = |value: fn(&super::app::Moment) -> f64| -> Vec<(f64, f64)> {
        let point = |moment| (moment_age(moment, view), 100.0 * value(moment));
        app.history(app.selected).map(point).filter(|(_, y)| y.is_finite()).collect()
    };
    let (strokes, targets) = (points(|moment| moment.stroke), points(|moment| moment.target));
    let dataset =
        |data, marker, style, kind| Dataset::default().marker(marker).graph_type(kind).style(style).data(data);
    let widget = Chart::new(vec![
        dataset(&targets, Marker::Dot, palette.target(), GraphType::Scatter),
        dataset(&strokes, Marker::Braille, palette.bar(), GraphType::Line),
    ])
    .block(Block::new().borders(Borders::TOP).border_style(palette.label()).title(Line::from(vec![
        Span::styled(format!(" {} ", row.name), palette.title()),
        Span::styled("⣀⠤⠒ stroke ", palette.bar()),
        Span::styled("••• target ", palette.target()),
    ])))
    .x_axis(Axis::default().bounds([-HISTORY_S, 0.0]).style(palette.label()).labels([
        format!("−{HISTORY_S:.0} s"),
        format!("−{:.0} s", HISTORY_S / 2.0),
        "now".to_string(),
    ]))
    .y_axis(Axis::default().bounds([0.0, 100.0]).style(palette.label()).labels(["  0 %", " 50 %", "100 %"]));
    frame.render_widget(widget, chart);
    if side > 0 {
        let area = Rect { x: chart.right(), width: side, ..area };
        let block = Block::new().borders(Borders::TOP).border_style(palette.label());
        let inner = block.inner(area);
        // a cell between the last moment of the curve and the words
        let inner = Rect { x: inner.x + 1, width: inner.width - 1, ..inner };
        frame.render_widget(block, area);
        frame.render_widget(Paragraph::new(details(row, palette)).wrap(Wrap { trim: true }), inner);
    }
}

fn moment_age(moment: &super::app::Moment, view: &View) -> f64 {
    moment.time_s - view.uptime_s
}

/// The details as they have always stood; a field that the table adds comes behind them.
const DETAILS: [&str; 7] =
    ["length_m", "target_m", "velocity_m_s", "power_w", "resistance_ohm", "temperature_c", "martensite"];

/// The selected channel in words and figures.
fn details(row: &Row, palette: Palette) -> Vec<Line<'static>> {
    let pair = |label: &str, value: String| {
        Line::from(vec![Span::styled(format!("{label:<12}"), palette.label()), Span::raw(value)])
    };
    let mut lines = Vec::new();
    let added = ChannelState::FIELDS.iter().map(|field| field.name).filter(|name| !DETAILS.contains(name));
    for field in DETAILS.into_iter().chain(added).filter_map(ChannelState::field) {
        let Some(detail) = field.detail else { continue };
        lines.push(pair(detail.label, in_its_unit(field.of(&row.state), field.unit, &detail)));
        if field.name == "target_m" {
            lines.push(pair("range", format!("{:.1} … {:.1} mm", row.hot_m * 1e3, row.cold_m * 1e3)));
        }
    }
    let lease_s = row.state.lease_s;
    let setpoint = match lease_s.is_finite() {
        true => format!("held for {lease_s:.1} s more"),
        false if row.state.mode() == Mode::Program => "the driver's own".into(),
        false => "none".into(),
    };
    lines.push(pair("setpoint", setpoint));
    if let Some(owner) = row.owner() {
        lines.push(pair("claimed by", owner));
    }
    if let Some(life) = &row.life {
        lines.push(pair("life used", life.clone()));
    }
    if let Some(fault) = row.fault {
        lines.push(Line::styled(format!("✖ {}: {}", words(fault.flag), fault.cause), palette.fault()));
        lines.push(Line::raw(fault.remedy));
    } else if let Some(health) = row.health {
        lines.push(Line::styled(format!("▲ sample: {health}"), palette.warning()));
    } else if let Some(budget) = row.held_by {
        lines.push(Line::styled(format!("▼ held back by its {budget} budget"), palette.warning()));
    }
    lines
}

/// A value as the details show it: lengths and speeds in mm, a dash where it is not known.
fn in_its_unit(value: f64, unit: &str, detail: &Detail) -> String {
    let (factor, unit) = match unit {
        "m" => (1e3, "mm"),
        "m/s" => (1e3, "mm/s"),
        other => (1.0, other),
    };
    let decimals = detail.decimals;
    let text = match value.is_finite() {
        true => format!("{:.decimals$} {unit}", value * factor),
        false => "–".into(),
    };
    if detail.is_estimate { format!("{text} (estimated)") } else { text }
}

/// What is being typed, or was answered, or is to be known of the selected channel.
fn message_line(app: &App, view: &View, palette: Palette) -> Line<'static> {
    let row = view.channels.get(app.selected);
    if let Some(entry) = &app.entry {
        let name = row.map_or("", |row| row.name.as_str());
        Line::from(vec![
            Span::raw(format!(" set {name}: ")),
            Span::styled(entry.clone(), palette.title()),
            Span::styled("▏", palette.target()),
            Span::styled("  45 or 45% stroke, 164mm, 2N, duty=0.1; Enter sends, Esc drops it", palette.label()),
        ])
    } else if let Some((message, _)) = &app.message {
        match message {
            Message::Done(text) => Line::styled(format!(" ✔ {text}"), palette.good()),
            Message::Refused(text) => Line::styled(format!(" ✖ {text}"), palette.fault()),
        }
    } else if let Some((row, fault)) = row.and_then(|row| row.fault.map(|fault| (row, fault))) {
        Line::styled(format!(" ✖ {}: {}; {}", row.name, fault.cause, fault.remedy), palette.fault())
    } else {
        Line::default()
    }
}

fn draw_timing(buffer: &mut Buffer, area: Rect, view: &View, palette: Palette) {
    let t = &view.timing;
    let label = |text: &'static str| Span::styled(text, palette.label());
    let q = t.lateness_us;
    let missed = if t.missed > 0 { palette.warning() } else { Style::new() };
    let mut spans = Vec::new();
    if !t.dead.is_empty() {
        // Before everything that may be cut off.
        spans.push(Span::styled(format!(" died: {} ", view.dead_names()), palette.warning()));
    }
    spans.extend([
        label(" loop "),
        Span::raw(format!("{} Hz", number(t.rate_hz, 0, 0))),
        label("  missed "),
        Span::styled(t.missed.to_string(), missed),
        label("  late µs "),
        Span::raw(format!("{}/{}/{}/{}", micros(q.p50), micros(q.p99), micros(q.p999), micros(q.max))),
        label("  cycle "),
        Span::raw(format!("{}/{}", micros(t.cycle_us.p50), micros(t.cycle_us.max))),
        label("  rt"),
    ]);
    let granted = t.realtime.iter().filter(|(_, granted)| *granted).count();
    let style = if granted < t.realtime.len() { palette.warning() } else { Style::new() };
    spans.push(Span::styled(format!(" {granted}/{}", t.realtime.len()), style));
    if area.width >= 110 {
        let refused: Vec<&str> = t.realtime.iter().filter(|(_, granted)| !granted).map(|(name, _)| *name).collect();
        if !refused.is_empty() {
            spans.push(Span::styled(format!(", not: {}", refused.join(", ")), palette.warning()));
        }
    }
    Line::from(spans).render(area, buffer);
}

fn draw_keys(buffer: &mut Buffer, area: Rect, app: &App, palette: Palette) {
    let long = area.width >= 78;
    let mut spans = vec![Span::raw(" ")];
    for (key, what, always) in [
        ("↑↓", "select", true),
        ("+−", "stroke", true),
        ("0-9", "type", false),
        ("space", "let go", false),
        ("o", "off", true),
        ("r", "reset", true),
        ("x", "e-stop reset", app.resets_stop && app.is_stopped()),
        ("?", "help", true),
        ("q", app.quit_word, true),
    ] {
        if always || (long && key != "x") {
            spans.push(Span::styled(key, palette.title()));
            spans.push(Span::styled(format!(" {what}  "), palette.label()));
        }
    }
    Line::from(spans).render(area, buffer);
}

fn draw_help(frame: &mut Frame, app: &App, palette: Palette) {
    let text = format!(
        "\
↑ ↓  j k          select a channel
+ −               stroke up or down by 5 %
0-9 … Enter       type a stroke, or 164mm, 2N, duty=0.1
o                 channel off
space             let go of a channel held from here (*)
r                 reset a latched fault
x                 reset the emergency stop, where `sinew run` was typed
q, Ctrl-C         {}

The bar runs from cold and long to hot and short; ┃ is the target.
A channel set here is held (*) until you let go or leave.
late: how late the loop woke, in µs: 50 % / 99 % / 99.9 % / most.
cycle: how long a cycle took, 50 % / most. ≈ marks an estimate.
rt: means of real time granted; `sinew doctor` says what to type.",
        match app.quit_word {
            "stop" => "stop the driver: outputs to zero, then the report",
            _ => "leave; the driver goes on",
        }
    );
    let area = frame.area();
    let width = 74.min(area.width);
    let height = (text.lines().count() as u16 + 2).min(area.height);
    let area = Rect { x: (area.width - width) / 2, y: (area.height - height) / 2, width, height };
    let block =
        Block::bordered().title(" keys and signs ").title_bottom(" any key closes ").border_style(palette.label());
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(text).block(block), area);
}

/// Hours, minutes and seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    match whole / 3600 {
        0 => format!("{}:{:02}", whole / 60, whole % 60),
        hours => format!("{hours}:{:02}:{:02}", whole / 60 % 60, whole % 60),
    }
}

/// At most `width` characters, with an ellipsis where something is missing.
fn clip(text: &str, width: usize) -> String {
    match text.chars().count() <= width {
        true => text.to_string(),
        false => text.chars().take(width.saturating_sub(1)).chain(['…']).collect(),
    }
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::super::view::tests::hexapod;
    use super::*;

    fn screen(app: &App, width: u16, height: u16) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| draw(frame, app, Palette::new(true))).unwrap();
        let buffer = terminal.backend().buffer();
        let line = |y| (0..width).map(|x| buffer[(x, y)].symbol()).collect::<String>().trim_end().to_string();
        (0..height).map(line).collect()
    }

    fn app() -> App {
        let mut app = App::new("quit");
        let mut view = hexapod(18);
        let end_s = view.uptime_s;
        for tick in (0..=150).rev() {
            view.uptime_s = end_s - f64::from(tick) * 0.2;
            let share = 0.5 + 0.4 * (view.uptime_s * 0.5).sin();
            let row = &mut view.channels[3];
            row.state.length_m = row.cold_m - share * (row.cold_m - row.hot_m);
            row.state.target_m = row.cold_m - (if share > 0.5 { 0.9 } else { 0.1 }) * (row.cold_m - row.hot_m);
            app.update(view.clone());
        }
        app.selected = 3;
        app
    }

    /// Compares with a stored picture; `UPDATE_SNAPSHOTS=1 cargo test` stores what is drawn now, to be looked at.
    fn compare(lines: &[String], name: &str) {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/screen/snapshots").join(name);
        let drawn = lines.join("\n") + "\n";
        if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
            std::fs::write(&path, &drawn).unwrap();
        }
        let stored = std::fs::read_to_string(&path).unwrap();
        assert!(drawn == stored, "differs from {name}:\n{drawn}");
    }

    #[test]
    fn eighteen_channels_fit_into_80_by_24() {
        let lines = screen(&app(), 80, 24);
        compare(&lines, "80x24.txt");
        for row in hexapod(18).channels {
            assert!(lines.iter().any(|line| line.contains(&row.name)), "{}", row.name);
        }
    }

    #[test]
    fn a_larger_screen_gets_a_chart_and_details() {
        let lines = screen(&app(), 120, 40);
        compare(&lines, "120x40.txt");
        let text = lines.join("\n");
        assert!(text.contains("estimated") && text.contains("100 %"));
    }

    #[test]
    fn a_wire_with_an_account_shows_what_is_used_of_its_life() {
        let mut app = app();
        let selected = app.selected;
        app.view.as_mut().unwrap().channels[selected].life = Some("3.1 % (1.0 % to 9.9 %)".into());
        let text = screen(&app, 160, 50).join("\n");
        assert!(text.contains("life used") && text.contains("3.1 % (1.0 %"), "{text}");
    }

    #[test]
    fn every_size_can_be_drawn() {
        let mut app = app();
        for entry in [None, Some("45".to_string())] {
            app.entry = entry;
            for help in [false, true] {
                app.help = help;
                for width in [1, 5, 19, 20, 30, 41, 57, 80, 100, 200] {
                    for height in [1, 3, 4, 5, 8, 12, 24, 27, 50, 90] {
                        screen(&app, width, height);
                    }
                }
            }
        }
    }

    #[test]
    fn the_table_scrolls_with_the_selection() {
        let mut app = App::new("quit");
        app.update(hexapod(64));
        for selected in [0, 20, 40, 63] {
            app.selected = selected;
            let lines = screen(&app, 80, 24);
            let name = format!("▶{}", app.view.as_ref().unwrap().channels[selected].name);
            assert!(lines.iter().any(|line| line.contains(&name)), "{name}\n{}", lines.join("\n"));
        }
    }

    #[test]
    fn a_fault_is_named_and_explained_without_colour() {
        let mut app = app();
        app.selected = 6;
        for (width, height) in [(80, 24), (120, 40)] {
            let text = screen(&app, width, height).join("\n");
            assert!(text.contains("✖ open wire"), "{text}");
            assert!(text.contains("no current flows"), "{text}");
        }
    }

    #[test]
    fn a_long_answer_takes_the_curves_place_and_no_channels() {
        let mut app = app();
        let answer = "front_right_coxa: length 155.00 mm is outside 160.54 to 167.04 mm; choose a length in that range";
        app.say(Message::Refused(answer.into()), 0.0);
        let lines = screen(&app, 80, 24);
        let text = lines.join(" ");
        assert!(answer.split(' ').all(|word| text.contains(word)), "{}", lines.join("\n"));
        assert!(hexapod(18).channels.iter().all(|row| text.contains(&row.name)), "{}", lines.join("\n"));
    }

    #[test]
    fn unknown_values_show_a_dash() {
        let mut view = hexapod(1);
        let row = &mut view.channels[0];
        row.state.length_m = f64::NAN;
        row.state.target_m = f64::NAN;
        row.state.resistance_ohm = f64::NAN;
        row.state.temperature_c = f64::INFINITY;
        let mut app = App::new("quit");
        app.update(view);
        let text = screen(&app, 120, 40).join("\n");
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
    }
}
