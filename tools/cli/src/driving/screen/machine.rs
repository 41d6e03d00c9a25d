//! Draws the machine that a simulated wire moves.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Line as Text;
use ratatui::widgets::canvas::{Canvas, Circle, Context, Line};
use sinew_demonstrators::{Ink, Picture, Shape};

use super::style::Palette;

/// Fewest rows in which something can be made out, the words beneath it included.
pub const LEAST_ROWS: u16 = 6;
/// Most rows it takes.
pub const MOST_ROWS: u16 = 18;
/// A cell is so many times as high as it is wide.
const CELL: f64 = 2.0;
/// Circles a disc is filled with.
const RINGS: u32 = 4;

/// Draws it, with what there is to say in the last row.
pub fn draw_machine(frame: &mut Frame, area: Rect, picture: &Picture, palette: Palette) {
    if area.height < 2 || area.width == 0 {
        return;
    }
    let drawn = Rect { height: area.height - 1, ..area };
    let said = Rect { y: area.bottom() - 1, height: 1, ..area };
    let (columns, rows) = (f64::from(drawn.width), f64::from(drawn.height));
    let [half_width, half_height] = picture.half_size;
    // metres of a column, so that all of it is seen and nothing is stretched
    let column_m = (2.0 * half_width / columns).max(2.0 * half_height / (CELL * rows));
    let (x, y) = (0.5 * column_m * columns, 0.5 * CELL * column_m * rows);
    let canvas = Canvas::default()
        .marker(Marker::Braille)
        .x_bounds([-x, x])
        .y_bounds([-y, y])
        .paint(|context| picture.shapes.iter().for_each(|shape| paint(context, shape, palette)));
    frame.render_widget(canvas, drawn);
    frame.render_widget(Text::styled(format!(" {}", picture.says), palette.title()), said);
}

fn paint(context: &mut Context<'_>, shape: &Shape, palette: Palette) {
    match *shape {
        Shape::Line { from, to, ink, .. } => {
            context.draw(&Line { x1: from[0], y1: from[1], x2: to[0], y2: to[1], color: colour(ink, palette) })
        }
        Shape::Disc { at, radius, ink } => {
            for ring in 1..=RINGS {
                let radius = radius * f64::from(ring) / f64::from(RINGS);
                context.draw(&Circle { x: at[0], y: at[1], radius, color: colour(ink, palette) });
            }
        }
    }
}

fn colour(ink: Ink, palette: Palette) -> ratatui::style::Color {
    let style = match ink {
        Ink::Frame => Style::new(),
        Ink::Body => palette.bar(),
        Ink::Wire => palette.fault(),
        Ink::Load | Ink::Goal => palette.target(),
    };
    style.fg.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;

    fn drawn(picture: &Picture, width: u16, height: u16) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal
            .draw(|frame| {
                let area = frame.area();
                draw_machine(frame, area, picture, Palette::new(false));
            })
            .unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn a_square_is_as_high_as_wide() {
        let side = |from, to| Shape::Line { from, to, width: 0.0, ink: Ink::Body };
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let shapes = corners.windows(2).map(|pair| side(pair[0], pair[1])).collect();
        let square = Picture { shapes, half_size: [1.0, 1.0], says: "a square".into() };
        let text = drawn(&square, 80, 21);
        let rows: Vec<&str> = text.lines().map(|line| line.trim_matches('"')).collect();
        let filled = |row: &str| row.chars().filter(|c| !matches!(c, ' ' | '\u{2800}')).count();
        let high = rows.iter().take(20).filter(|row| filled(row) > 0).count();
        let wide = rows.iter().take(20).map(|row| filled(row)).max().unwrap();
        assert!((wide as f64 / high as f64 - 2.0).abs() < 0.25, "{wide} columns, {high} rows:\n{text}");
        assert!(rows[20].contains("a square"), "{text}");
    }

    #[test]
    fn no_size_of_the_terminal_breaks_it() {
        let ball = Shape::Disc { at: [5.0, 0.0], radius: 0.1, ink: Ink::Load };
        let picture = Picture { shapes: vec![ball], half_size: [1.0, 0.5], says: "out of sight".into() };
        for (width, height) in [(1, 1), (1, 40), (300, 2), (7, 3)] {
            drawn(&picture, width, height);
        }
    }
}
