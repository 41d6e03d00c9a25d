//! Plots side by side under one legend as a picture of its own, for a paper, a talk or a page of documentation.

use maud::{Markup, PreEscaped, html};

use crate::plot::{DASHES, Ink, Plot};

/// Room above a panel for its caption, and around it, px.
const CAPTION: f64 = 22.0;
const GAP: f64 = 14.0;
/// Height of a line of the legend, px.
const LEGEND: f64 = 26.0;
/// Width of the legend's sample of a line, and of a letter beside it, px.
const SAMPLE: f64 = 34.0;
const LETTER: f64 = 6.6;
const FONT: &str = "font-family: sans-serif; font-size: 13px; fill: #1b2430";

/// A legend, and plots with their captions, two in a row.
pub struct Panels<'a> {
    /// What the inks stand for.
    pub legend: Vec<(Ink, String)>,
    /// Plots of one size.
    pub panels: Vec<(String, Plot<'a>)>,
}

impl Panels<'_> {
    /// A standalone SVG.
    pub fn draw(&self) -> Markup {
        let (wide, high) = self.panels.first().map_or((0.0, 0.0), |(_, plot)| plot.size);
        let across = self.panels.len().clamp(1, 2);
        let width = GAP + across as f64 * (wide + GAP);
        let (legend, lines) = self.legend(width);
        let top = LEGEND * lines as f64;
        let height = top + self.panels.len().div_ceil(across) as f64 * (CAPTION + high + GAP) + GAP;
        html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (width) " " (height) } width=(width) height=(height) {
                style { (PreEscaped(DASHES)) }
                rect width=(width) height=(height) fill="#ffffff" {}
                (legend)
                @for (i, (caption, plot)) in self.panels.iter().enumerate() {
                    @let x = GAP + (i % across) as f64 * (wide + GAP);
                    @let y = top + (i / across) as f64 * (CAPTION + high + GAP);
                    text x=(x) y=(y + 15.0) style=(FONT) { (caption) }
                    svg x=(x) y=(y + CAPTION) width=(wide) height=(high) { (plot.draw()) }
                }
            }
        }
    }

    /// The legend in as many lines as it takes, and how many those are.
    fn legend(&self, width: f64) -> (Markup, usize) {
        let (mut x, mut line) = (GAP, 0);
        let places: Vec<(f64, usize, Ink, &str)> = self
            .legend
            .iter()
            .map(|(ink, name)| {
                let long = SAMPLE + LETTER * name.chars().count() as f64 + 22.0;
                if x > GAP && x + long > width {
                    (x, line) = (GAP, line + 1);
                }
                let place = (x, line, *ink, name.as_str());
                x += long;
                place
            })
            .collect();
        let drawn = html! {
            @for (x, line, ink, name) in places {
                @let y = LEGEND * line as f64;
                @let (r, g, b) = ink.rgb();
                @let colour = format!("#{r:02X}{g:02X}{b:02X}");
                // in the plots' quarters of a pixel, so that dashes are as long as there
                g transform={ "translate(" (x) " " (y + 16.0) ") scale(0.25)" } {
                    polyline points="0,0 112,0" fill="none" stroke=(colour) stroke-width=(ink.line().stroke_width) {}
                }
                text x=(x + SAMPLE) y=(y + 20.0) style=(FONT) { (name) }
            }
        };
        (drawn, line + 1)
    }
}

/// A sample of an ink's line, for the legend of a page.
pub fn sample(ink: Ink) -> Markup {
    let (r, g, b) = ink.rgb();
    html! {
        svg.swatch viewBox="0 0 120 48" width="30" height="12" aria-hidden="true" {
            polyline points="4,24 116,24" fill="none" stroke=(format!("#{r:02X}{g:02X}{b:02X}")) stroke-width=(ink.line().stroke_width) {}
        }
    }
}
