//! A figure as a zoomable HTML page: one file with the curves, the plotting library and its controls, which
//! needs no network and sends no data.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde::Serialize;
use sinew_plot::web::{CHART, INKS, UPLOT, UPLOT_LICENSE, UPLOT_STYLE};
use sinew_plot::{Ink, head};

use crate::Kind;
use crate::figure::Figure;

/// The page's own script and styles, which are in it; nothing is fetched.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

#[derive(Serialize)]
struct Data<'a> {
    legend: Vec<Entry<'a>>,
    panels: Vec<PanelData<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    name: &'a str,
    ink: i32,
}

#[derive(Serialize)]
struct PanelData<'a> {
    kind: &'static str,
    caption: &'a str,
    x_title: &'a str,
    x_unit: &'a str,
    y_title: &'a str,
    y_unit: &'a str,
    curves: Vec<CurveData>,
}

#[derive(Serialize)]
struct CurveData {
    ink: i32,
    /// Points: all of one coordinate as little-endian f32 in base64, then all of the other.
    points: String,
}

/// The page knows inks by number: those of a series by their place, the pale one of what was commanded, the plain one.
fn number(ink: Ink) -> i32 {
    match ink {
        Ink::Series(place) => place.into(),
        Ink::Measured => -1,
        _ => -2,
    }
}

impl Figure {
    /// The page.
    pub fn html(&self) -> String {
        self.page().into_string()
    }

    fn page(&self) -> Markup {
        let panels = self.panels.iter().map(|panel| PanelData {
            kind: panel.kind.name(),
            caption: &panel.caption,
            x_title: &panel.x.title,
            x_unit: panel.x.unit,
            y_title: &panel.y.title,
            y_unit: panel.y.unit,
            curves: panel
                .curves
                .iter()
                .map(|curve| CurveData { ink: number(curve.ink), points: packed(&curve.x, &curve.y) })
                .collect(),
        });
        let legend = self.legend.iter().map(|(ink, name)| Entry { name, ink: number(*ink) });
        let data = Data { legend: legend.collect(), panels: panels.collect() };
        // "<" would end the script at "</script>", or begin a comment in it
        let json = serde_json::to_string(&data).unwrap_or_else(|_| "{}".into()).replace('<', "\\u003c");
        let over_time = self.panels.iter().any(|panel| panel.kind == Kind::Time);
        html! {
            (DOCTYPE)
            html lang="en" {
                (head(&self.title, POLICY, &[UPLOT_STYLE, INKS, include_str!("../page/figure.css")]))
                body {
                    header {
                        h1 { (self.title) }
                        div id="legend" role="group" aria-label="Curves" {}
                    }
                    main id="panels" {}
                    p id="hint" {
                        "Drag to zoom, turn the wheel over a curve, double-click for all of it"
                        @if over_time { "; panels over time move together" }
                        ". Click a name to hide its curves. " span id="cursor" {}
                    }
                    noscript { "This page draws its curves with a script of its own, which is switched off here." }
                    script { (PreEscaped("/*\n")) (PreEscaped(UPLOT_LICENSE)) (PreEscaped("*/\n")) (PreEscaped(UPLOT)) }
                    script { (PreEscaped(CHART)) }
                    script type="application/json" id="data" { (PreEscaped(json)) }
                    script { (PreEscaped(include_str!("../page/figure.js"))) }
                }
            }
        }
    }
}

/// Both coordinates as f32 in base64: an f32 has seven digits, more than a screen can show.
fn packed(x: &[f64], y: &[f64]) -> String {
    let bytes: Vec<u8> = x.iter().chain(y).flat_map(|v| (*v as f32).to_le_bytes()).collect();
    BASE64_STANDARD.encode(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Curve, Panel};
    use sinew_plot::Field;

    #[test]
    fn a_page_stands_alone_and_cannot_be_broken_out_of() {
        let name = "</script><script>alert(1)</script><!--";
        let curve = Curve { ink: Ink::Series(0), name: name.into(), x: vec![0.0, 1.0], y: vec![1.0, f64::NAN] };
        let y = Field { title: name.into(), unit: "1" };
        let panel = Panel { kind: Kind::Time, caption: name.into(), x: Field::of("time_s"), y, curves: vec![curve] };
        let figure = Figure {
            title: name.into(),
            legend: vec![(Ink::Series(0), name.into())],
            panels: vec![panel],
            notes: vec![],
        };
        let page = figure.html();
        assert_eq!(page.matches("<script").count(), 4);
        assert_eq!(page.matches("</script>").count(), 4);
        assert!(!page.contains("alert(1)<") && !page.contains("src=") && !page.contains("href="));
    }
}
