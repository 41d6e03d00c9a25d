//! Numbers and tables as the terminal shows them.

/// Rows of cells as lines, the first column to the left, the last as it is, the others to the right.
pub fn columns<const N: usize>(rows: Vec<[String; N]>) -> String {
    let widths: [usize; N] = std::array::from_fn(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for row in &rows {
        let mut line = String::new();
        for (i, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[i].saturating_sub(cell.chars().count()));
            let gap = if i == 0 { "" } else { "  " };
            let (before, after) = if i == 0 || i + 1 == N && N > 5 { ("", pad.as_str()) } else { (pad.as_str(), "") };
            line += &format!("{gap}{before}{cell}{after}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// A number with four digits.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return format!("{value}");
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let places = (3 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.places$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let said = [0.0, 121.2, 0.04, 24200.0, 0.31, 1.5e-5, 113.0449, -2.0].map(number);
        assert_eq!(said, ["0", "121.2", "0.04", "24200", "0.31", "1.50e-5", "113", "-2"]);
    }
}
