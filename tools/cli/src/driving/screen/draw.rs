//! Draws the screen: a title, a table of all channels, the selected channel's chart, the loop's statistics, the keys.
//!
//! Eighteen channels fit into 80 × 24. Additional space goes to the bars, to columns of lower priority, and to a
//! chart of the selected channel; on smaller screens these shrink first, and the table scrolls. Down to 40 × 15 the title names
//! the faults and the hottest wire, and the details of the selected channel can be had over the table.

use std::ops::Range;

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Block, Borders, Chart, Clear, Dataset, GraphType, Paragraph, Widget, Wrap};

use super::app::{App, HISTORY_S, Message};
use super::help::{draw_help, draw_keys};
use super::machine::{self, draw_machine};
use super::style::Palette;
use super::table::{draw_table, in_sight};
use super::title::title_lines;
use super::view::{Row, View, micros, number};

/// Below this a chart says less than a sparkline.
const CHART_ROWS: u16 = 7;
/// Rows below which the title has one line.
const ROOMY: u16 = 12;
/// Columns below which it may have three.
const NARROW: u16 = 60;

/// Draws everything; how many channels are in sight.
pub fn draw(frame: &mut Frame, app: &App, palette: Palette) -> usize {
    let area = frame.area();
    if area.width < 20 || area.height < 4 {
        frame.render_widget("too small", area);
        return 1;
    }
    let Some(view) = &app.view else {
        frame.render_widget("waiting for the driver …", area);
        return 1;
    };
    let mut rows = Rows { area, next: area.y, last: area.bottom() };
    let titled = match (area.width, area.height) {
        (_, ..ROOMY) => title_lines(view, palette, area.width, 1),
        (..NARROW, _) => title_lines(view, palette, area.width, 3),
        _ => title_lines(view, palette, area.width, 2),
    };
    // from both ends inwards, the table takes what is left
    let title = rows.top(titled.len() as u16);
    let keys = rows.bottom(1);
    let timing = if rows.left() > 3 { rows.bottom(1) } else { Rect::ZERO };
    let table_rows = view.channels.len() as u16 + 1;
    let said = message_line(app, view, palette);
    // what does not fit into a line may take the rows the table does not need
    let needed = (said.width() as u16).div_ceil(area.width).clamp(1, 3);
    let message = match rows.left().saturating_sub(table_rows) {
        _ if rows.left() <= 3 => Rect::ZERO,
        // a table that scrolls anyway has rows to spare
        0 if rows.left() < table_rows && area.height >= ROOMY => rows.bottom(needed),
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
    let sight = in_sight(app.selected, view.channels.len(), table.height.saturating_sub(1) as usize);
    let said = if said.width() == 0 { out_of_sight(view, &sight, palette) } else { said };

    frame.render_widget(Paragraph::new(titled), title);
    if let Some(picture) = &app.machine {
        draw_machine(frame, machine, picture, palette);
    }
    draw_table(frame.buffer_mut(), table, app, view, sight.clone(), palette);
    if course.height >= CHART_ROWS {
        draw_course(frame, course, app, view, palette);
    } else if course.height > 0 {
        draw_sparkline(frame.buffer_mut(), course, app, view, palette);
    }
    frame.render_widget(Paragraph::new(said).wrap(Wrap { trim: false }), message);
    draw_timing(frame.buffer_mut(), timing, view, palette);
    draw_keys(frame.buffer_mut(), keys, app, palette);
    if let Some(from) = app.help {
        draw_help(frame, app, from, palette);
    } else if app.details {
        draw_details(frame, app, view, palette);
    }
    sight.len()
}

/// Which channels that are not in sight have a fault, or are held back.
fn out_of_sight(view: &View, sight: &Range<usize>, palette: Palette) -> Line<'static> {
    let is_above = |index: usize| index < sight.start;
    let of = |is_meant: fn(&Row) -> bool, is_above_it: bool| {
        let there = view.channels.iter().enumerate().filter(|(index, _)| !sight.contains(index));
        let meant = there.filter(|(index, row)| is_above(*index) == is_above_it && is_meant(row));
        meant.map(|(_, row)| row.name.as_str()).collect::<Vec<_>>()
    };
    let has_fault: fn(&Row) -> bool = |row| row.fault.is_some();
    let is_held: fn(&Row) -> bool = |row| row.fault.is_none() && row.held_by.is_some();
    let mut spans = Vec::new();
    for (mark, is_meant, style) in [("✖", has_fault, palette.fault()), ("▼", is_held, palette.warning())] {
        for (arrow, above) in [("↑", true), ("↓", false)] {
            let names = of(is_meant, above);
            if !names.is_empty() {
                spans.push(Span::styled(format!(" {arrow}{mark} {}", names.join(" ")), style));
            }
        }
    }
    if !spans.is_empty() {
        spans.insert(0, Span::raw(" n:"));
    }
    Line::from(spans)
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

/// The selected channel in words and figures: what is wrong with it first.
fn details(row: &Row, palette: Palette) -> Vec<Line<'static>> {
    let pair = |(label, value): (&str, String)| {
        Line::from(vec![Span::styled(format!("{label:<12}"), palette.label()), Span::raw(value)])
    };
    let trouble =
        row.trouble().map(|trouble| Line::styled(format!("{} {trouble}", mark(row)), trouble_style(row, palette)));
    trouble.into_iter().chain(row.details().into_iter().map(pair)).collect()
}

/// The sign of what is wrong with a channel.
fn mark(row: &Row) -> &'static str {
    match (row.fault, row.health, row.held_by) {
        (Some(_), ..) => "✖",
        (None, Some(_), _) => "▲",
        (None, None, Some(_)) => "▼",
        (None, None, None) => "·",
    }
}

fn trouble_style(row: &Row, palette: Palette) -> Style {
    if row.fault.is_some() { palette.fault() } else { palette.warning() }
}

/// The same over the table, where there is no room beside it; the line of the selection stays in sight.
fn draw_details(frame: &mut Frame, app: &App, view: &View, palette: Palette) {
    let Some(row) = view.channels.get(app.selected) else { return };
    let lines = details(row, palette);
    let area = frame.area();
    let width = 50.min(area.width);
    let inside = usize::from(width).saturating_sub(2).max(1);
    let needed: usize = lines.iter().map(|line| line.width().div_ceil(inside).max(1)).sum();
    let height = (needed as u16 + 2).min(area.height);
    let area = Rect { x: area.right() - width, y: area.bottom() - height, width, height };
    let block = Block::bordered().title(format!(" {} ", row.name)).border_style(palette.label());
    frame.render_widget(Clear, area);
    frame.render_widget(Paragraph::new(lines).block(block.title_bottom(" d closes ")).wrap(Wrap { trim: true }), area);
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
    } else if let Some((row, trouble)) = row.and_then(|row| row.trouble().map(|trouble| (row, trouble))) {
        Line::styled(format!(" {} {}: {trouble}", mark(row), row.name), trouble_style(row, palette))
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

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

    use super::super::view::tests::hexapod;
    use super::super::view::{Account, HeldBack};
    use super::*;

    fn screen(app: &App, width: u16, height: u16) -> Vec<String> {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        let mut in_sight = 0;
        terminal.draw(|frame| in_sight = draw(frame, app, Palette::new(true))).unwrap();
        assert!(in_sight <= usize::from(height));
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
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/driving/screen/snapshots").join(name);
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
    fn a_wire_with_an_account_shows_what_is_used_of_its_life_and_its_energy() {
        let mut app = app();
        let selected = app.selected;
        let account = Account { used: "3.1 % (1.0 % to 9.9 %)".into(), energy: "12 kJ".into() };
        app.view.as_mut().unwrap().channels[selected].account = Some(account);
        // beside the chart, and over the table where there is none
        app.details = true;
        for (width, height) in [(200, 60), (80, 24), (40, 15)] {
            let text = screen(&app, width, height).join("\n");
            assert!(text.contains("3.1 % (1.0 %") && text.contains("12 kJ"), "{text}");
        }
        app.details = false;
        assert!(screen(&app, 200, 60).join("\n").contains("12 kJ"));
    }

    #[test]
    fn every_size_can_be_drawn() {
        let mut app = app();
        for entry in [None, Some("45".to_string())] {
            app.entry = entry;
            for help in [None, Some(0), Some(30)] {
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
    fn the_hottest_wire_faults_and_what_holds_a_wire_back_are_there_at_any_size() {
        let mut app = app();
        for count in [1, 18, 64] {
            let mut view = hexapod(count);
            view.channels[0].held_by = Some(HeldBack::Temperature);
            let hottest = view.hottest().unwrap().name.clone();
            app.update(view);
            app.selected = 0;
            for (width, height) in [(40, 15), (80, 24), (200, 60)] {
                let text = screen(&app, width, height).join("\n");
                assert!(text.contains(&format!("hottest {hottest}")), "{text}");
                let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
                assert!(
                    text.contains("▼ temperatu") && words.contains("held back by its temperature budget"),
                    "{text}"
                );
                assert!(count < 18 || text.contains("✖ 1 fault"), "{text}");
                assert!(text.contains("q quit") && text.contains("? help"), "{text}");
            }
        }
    }

    #[test]
    fn faults_that_are_not_in_sight_are_said() {
        let mut app = App::new("quit");
        let mut view = hexapod(64);
        view.channels[60].fault = view.channels[6].fault;
        app.update(view);
        app.selected = 30;
        for (width, height) in [(40, 15), (80, 24)] {
            let text = screen(&app, width, height).join("\n");
            assert!(text.contains("↑✖ middle_left_coxa") && text.contains("✖ 2 faults"), "{text}");
        }
        assert!(screen(&app, 80, 24).join("\n").contains("↓✖ wire_60"));
        // n leads there, and on to the wires that are held back
        let mut seen = Vec::new();
        for _ in 0..3 {
            app.key(KeyEvent::new(KeyCode::Char('n'), KeyModifiers::NONE), 0.0);
            seen.push(app.selected);
        }
        assert_eq!(seen, [60, 6, 11]);
    }

    #[test]
    fn the_help_page_can_be_read_to_its_end_on_a_small_screen() {
        let mut app = app();
        let mut seen = String::new();
        for from in 0..60 {
            app.help = Some(from);
            seen += &screen(&app, 40, 15).join("\n");
        }
        assert!(seen.contains("j k") && seen.contains("--plain"), "{seen}");
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
