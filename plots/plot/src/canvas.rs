//! The SVG element that a drawing stands in. Drawn in quarters of a pixel, since the backend rounds to whole units.

use maud::{Markup, PreEscaped, html};
use plotters::coord::Shift;
use plotters::prelude::*;

/// Units of the drawing per pixel.
pub(crate) const FINE: f64 = 4.0;

/// How a drawing went.
pub(crate) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// What is drawn on.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The drawing's frame: what the backend wrote, as a picture with a title that fills the width it is given.
pub(crate) fn svg(title: &str, (width, height): (f64, f64), draw: impl FnOnce(&Area<'_>) -> Drawn) -> Markup {
    let size = (fine(width), fine(height));
    let mut written = String::new();
    let drawn = {
        let area = SVGBackend::with_string(&mut written, size).into_drawing_area();
        draw(&area).and_then(|()| area.present())
    };
    let body = written.split_once('>').and_then(|(_, rest)| rest.rsplit_once("</svg>")).map(|(body, _)| body);
    html! {
        @match (drawn, body) {
            (Ok(()), Some(body)) => {
                svg viewBox={ "0 0 " (size.0) " " (size.1) } role="img" style={ "--least:" (width * 0.8) "px" } {
                    title { (title) }
                    (PreEscaped(body))
                }
            }
            _ => p.muted { "This plot could not be drawn: " (title) }
        }
    }
}

/// Pixels in units of the drawing.
pub(crate) fn fine(pixels: f64) -> u32 {
    (FINE * pixels).round() as u32
}
