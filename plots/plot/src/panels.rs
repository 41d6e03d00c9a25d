//! Plots side by side under one legend as a standalone image, for a paper, a talk or a page of documentation.

use maud::{Markup, PreEscaped, html};

use crate::ink::{DASHES, Ink};
use crate::plot::Plot;

/// Room above a panel for its caption, and around it, px.
const CAPTION: f64 = 22.0;
const GAP: f64 = 14.0;
/// Height of a line of the legend, px.
const LEGEND: f64 = 26.0;
/// Width of the legend's sample of a line, and of a letter beside it, px.
const SAMPLE: f64 = 34.0;
const LETTER: f64 = 6.6;
/// Room for the title, px.
const TITLE: f64 = 30.0;
const HEADING: &str = "font-family: sans-serif; font-size: 17px; fill: #1b2430";
const FONT: &str = "font-family: sans-serif; font-size: 13px; fill: #1b2430";

/// A title, a legend, and plots with their captions: beside one another where there is room, as the words of a text.
pub struct Panels<'a> {
    /// On top; nothing where it is empty.
    pub title: String,
    /// What the inks stand for.
    pub legend: Vec<(Ink, String)>,
    /// Room for a row of plots, px; the picture is no wider than its plots are.
    pub row: f64,
    /// The plots.
    pub panels: Vec<(String, Plot<'a>)>,
}

/// A row that takes two of the plots that stand two beside one another in this project's pictures, px.
pub const TWO_IN_A_ROW: f64 = 2.0 * 460.0 + GAP;

impl Panels<'_> {
    /// A standalone SVG.
    pub fn draw(&self) -> Markup {
        let (places, inside, below) = self.places();
        let width = inside + 2.0 * GAP;
        let (legend, lines) = self.legend(width);
        let title = if self.title.is_empty() { 0.0 } else { TITLE };
        let top = title + LEGEND * lines as f64;
        let height = top + below + GAP;
        html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (width) " " (height) } width=(width) height=(height) {
                style { (PreEscaped(DASHES)) }
                rect width=(width) height=(height) fill="#ffffff" {}
                @if !self.title.is_empty() { text x=(GAP) y="22" style=(HEADING) { (self.title) } }
                g transform={ "translate(0 " (title) ")" } { (legend) }
                @for ((caption, plot), (x, y)) in self.panels.iter().zip(places) {
                    @let (wide, high) = plot.size;
                    @let (x, y) = (GAP + x, top + y);
                    text x=(x) y=(y + 15.0) style=(FONT) { (caption) }
                    svg x=(x) y=(y + CAPTION) width=(wide) height=(high) { (plot.draw()) }
                }
            }
        }
    }

    /// Where each plot stands, how wide their rows are, and how high all of them.
    fn places(&self) -> (Vec<(f64, f64)>, f64, f64) {
        let (mut x, mut y, mut row, mut widest) = (0.0, 0.0, 0.0f64, 0.0f64);
        let mut places = Vec::with_capacity(self.panels.len());
        for (_, plot) in &self.panels {
            let (wide, high) = plot.size;
            if x > 0.0 && x + wide > self.row + 0.5 {
                (x, y, row) = (0.0, y + row, 0.0);
            }
            places.push((x, y));
            widest = widest.max(x + wide);
            x += wide + GAP;
            row = row.max(CAPTION + high + GAP);
        }
        (places, widest, y + row)
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
