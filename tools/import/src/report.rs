//! What was understood, as a table to confirm and as the text of a mapping.

use std::fmt::Write as _;

use crate::guess::{Guess, Understood};
use crate::reading::figure;
use crate::table::Table;

/// The table to confirm: what the file is, its columns, and what is in doubt.
pub fn confirm(file: &str, table: &Table, guess: &Guess) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{file}: {}", table.kind);
    if let Some(first) = table.format.first_line {
        let names = match table.format.header_line {
            Some(0) | None => "no names".to_string(),
            Some(line) => format!("names from line {line}"),
        };
        let _ = writeln!(text, "{} rows from line {first}, {names}", table.len());
    } else {
        let _ = writeln!(text, "{} rows", table.len());
    }
    for note in &table.notes {
        let _ = writeln!(text, "  {note}");
    }
    text.push('\n');
    let head = ["column", "understood as", "unit", "factor", "offset", "from", "to"].map(String::from);
    let mut rows = vec![head];
    for Understood { column, quantity, unit, scale, offset, range: (low, high), .. } in &guess.columns {
        let used = quantity.is_some();
        let number = |value: f64| if value.is_nan() { "-".to_string() } else { figure(value) };
        rows.push([
            shown(column),
            quantity.unwrap_or("(not used)").to_string(),
            unit.clone(),
            if used { shortest(*scale) } else { String::new() },
            if used { shortest(*offset) } else { String::new() },
            number(*low),
            number(*high),
        ]);
    }
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..7).map(width).collect();
    for row in &rows {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(k, (cell, width))| {
                let blanks = " ".repeat(width - cell.chars().count());
                if k < 3 { format!("{cell}{blanks}") } else { format!("{blanks}{cell}") }
            })
            .collect();
        let _ = writeln!(text, "{}", cells.join("  ").trim_end());
    }
    text.push('\n');
    for understood in &guess.columns {
        if understood.quantity.is_none() {
            let _ = writeln!(text, "  {}: {}", shown(&understood.column), understood.words);
        }
        for words in &understood.evidence {
            let _ = writeln!(text, "  {}: {words}", shown(&understood.column));
        }
    }
    let doubts = guess.columns.iter().flat_map(|u| u.doubts.iter().map(|words| (shown(&u.column), words)));
    for (column, words) in doubts {
        let _ = writeln!(text, "? {column}: {words}");
    }
    for words in &guess.doubts {
        let _ = writeln!(text, "? {words}");
    }
    text
}

/// The mapping as the text of a file, with the evidence and the doubts as comments.
pub fn mapping(file: &str, table: &Table, guess: &Guess) -> String {
    let mut head = vec![
        format!("How {} is read: found by `sinew import --guess`, to be confirmed.", shown(file)),
        format!("{}; value = scale × number + offset.", table.kind),
    ];
    head.extend(guess.doubts.iter().map(|words| format!("? {words}")));
    let mut remarks = Vec::new();
    for understood in &guess.columns {
        let of = understood.quantity.unwrap_or_default().to_string();
        if understood.quantity.is_none() {
            remarks.push((of.clone(), format!("not used: {}: {}", shown(&understood.column), understood.words)));
            continue;
        }
        remarks.extend(understood.evidence.iter().map(|words| (of.clone(), words.clone())));
        remarks.extend(understood.doubts.iter().map(|words| (of.clone(), format!("? {words}"))));
    }
    guess.mapping.to_toml(&head, &remarks)
}

/// A factor with all its digits, as short as it can be.
fn shortest(value: f64) -> String {
    let plain = format!("{value}");
    let short = format!("{value:.6}");
    if plain.len() > 9 { figure_of(value, &short) } else { plain }
}

fn figure_of(value: f64, short: &str) -> String {
    match value.abs() {
        m if m >= 1e-3 => short.trim_end_matches('0').trim_end_matches('.').to_string(),
        _ => format!("{value:.4e}"),
    }
}

fn shown(column: &str) -> String {
    crate::error::shorten(column)
}
