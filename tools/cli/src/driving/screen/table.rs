//! The screen's table: a line for each channel, in the columns there is room for.

use std::ops::Range;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::app::App;
use super::style::Palette;
use super::view::{Row, View, number, percent, words};

/// The page of channels that keeps the selection in sight.
pub fn in_sight(selected: usize, count: usize, rows: usize) -> Range<usize> {
    let first = if count <= rows { 0 } else { selected.saturating_sub(rows / 2).min(count - rows) };
    first..count.min(first + rows)
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

/// Draws the channels that are in sight.
pub fn draw_table(buffer: &mut Buffer, area: Rect, app: &App, view: &View, sight: Range<usize>, palette: Palette) {
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
    let count = view.channels.len();
    for (index, row) in view.channels.iter().enumerate().skip(sight.start).take(sight.len()) {
        let y = area.y + 1 + (index - sight.start) as u16;
        let selected = index == app.selected;
        let base = if selected { palette.selected() } else { Style::new() };
        let more = (index == sight.start && index > 0, index + 1 == sight.end && sight.end < count);
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
                        (None, None, Some(held)) => (format!("▼ {}", held.word()), palette.warning()),
                        (None, None, None) => (row.mode().to_string(), base),
                    };
                    put(buffer, x, y, &text, *width, style);
                }
            }
            x += width + 1;
        }
    }
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

/// At most `width` characters, with an ellipsis where something is missing.
fn clip(text: &str, width: usize) -> String {
    match text.chars().count() <= width {
        true => text.to_string(),
        false => text.chars().take(width.saturating_sub(1)).chain(['…']).collect(),
    }
}
