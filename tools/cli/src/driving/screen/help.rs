//! What the keys do: the line at the bottom, and the page.

use ratatui::Frame;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph, Widget, Wrap};

use super::app::App;
use super::style::Palette;

/// Draws the line of keys: those that there is room for.
pub fn draw_keys(buffer: &mut Buffer, area: Rect, app: &App, palette: Palette) {
    // what is left out first where there is no room has the highest number
    let mut keys = vec![
        (2, "↑↓", "select"),
        (3, "+−", "stroke"),
        (7, "0-9", "type"),
        (8, "space", "let go"),
        (4, "o", "off"),
        (5, "r", "reset"),
        (6, "d", "details"),
        (9, "n", "next trouble"),
        (1, "?", "help"),
        (0, "q", app.quit_word),
    ];
    if app.resets_stop && app.is_stopped() {
        keys.insert(6, (0, "x", "e-stop reset"));
    }
    let cells = |keys: &[(u32, &str, &str)]| {
        1 + keys.iter().map(|(_, key, what)| key.chars().count() + what.chars().count() + 3).sum::<usize>()
    };
    while cells(&keys) > usize::from(area.width) + 2 && keys.len() > 1 {
        let least = keys.iter().map(|(place, ..)| *place).max();
        keys.retain(|(place, ..)| Some(*place) != least);
    }
    let mut spans = vec![Span::raw(" ")];
    for (_, key, what) in keys {
        spans.push(Span::styled(key, palette.title()));
        spans.push(Span::styled(format!(" {what}  "), palette.label()));
    }
    Line::from(spans).render(area, buffer);
}

/// The help page, from this of its lines on where it does not fit.
pub fn draw_help(frame: &mut Frame, app: &App, from: u16, palette: Palette) {
    let keys = [
        ("↑ ↓  j k", "select a channel; PgUp, PgDn, Home, End"),
        ("n", "select the next one with a fault, or held back"),
        ("+ −", "stroke up or down by 5 %"),
        ("0-9 … Enter", "type a stroke, or 164mm, 2N, duty=0.1"),
        ("o", "channel off"),
        ("space", "let go of a channel held from here (*)"),
        ("r", "reset a latched fault"),
        ("x", "reset the emergency stop, where `sinew run` was typed"),
        ("d", "details of the channel: energy, life, setpoint, claim"),
        (
            "q, Ctrl-C",
            match app.quit_word {
                "stop" => "stop the driver: outputs to zero, then the report",
                _ => "leave; the driver goes on",
            },
        ),
    ];
    let area = frame.area();
    let width = 74.min(area.width);
    // in a column of their own where there is room for one
    let column = if width < 74 { 0 } else { 16 };
    let mut text: String = keys.map(|(key, what)| format!("{key:<column$}  {what}\n")).concat();
    text += "
The bar runs from cold and long to hot and short; ┃ is the target.
A channel set here is held (*) until you let go or leave.
✖ a latched fault, ▲ a bad sample, ▼ held back: by what.
late: how late the loop woke, in µs: 50 % / 99 % / 99.9 % / most.
cycle: how long a cycle took, 50 % / most. ≈ marks an estimate.
rt: means of real time granted; `sinew doctor` says what to type.
In words, for a screen reader: `sinew monitor --plain`.";
    let inside = usize::from(width).saturating_sub(2).max(1);
    let needed: usize = text.lines().map(|line| line.chars().count().div_ceil(inside).max(1)).sum();
    let height = (needed as u16 + 2).min(area.height);
    let area = Rect { x: (area.width - width) / 2, y: (area.height - height) / 2, width, height };
    let hidden = (needed as u16 + 2).saturating_sub(height);
    let closes = if hidden > from { " ↓ more, any other key closes " } else { " any key closes " };
    let block = Block::bordered().title(" keys and signs ").title_bottom(closes).border_style(palette.label());
    frame.render_widget(Clear, area);
    let page = Paragraph::new(text).block(block).wrap(Wrap { trim: false });
    frame.render_widget(page.scroll((from.min(hidden), 0)), area);
}
