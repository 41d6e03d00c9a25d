//! A figure as an SVG, drawn by the project's plots.

use sinew_plot::{Axis, Line, Panels, Plot, TWO_IN_A_ROW, extent};

use crate::Kind;
use crate::figure::{Figure, Panel};

/// Size of a panel over time, and of any other, px.
const WIDE: (f64, f64) = (934.0, 190.0);
const HALF: (f64, f64) = (460.0, 340.0);

impl Figure {
    /// A standalone SVG.
    pub fn svg(&self) -> String {
        let last_over_time = self.panels.iter().rposition(|panel| panel.kind == Kind::Time);
        let time = self.panels.iter().filter(|panel| panel.kind == Kind::Time);
        let time = extent(time.flat_map(|panel| &panel.curves).flat_map(|curve| curve.x.iter().copied()));
        let panels = self.panels.iter().enumerate().map(|(i, panel)| {
            let (x, y) = axes(panel, time);
            let caption = match panel.kind {
                Kind::Time => y.title(),
                Kind::Lateness => panel.caption.clone(),
                _ if y.unit().is_empty() => panel.caption.clone(),
                _ => format!("{}, {}", panel.caption, y.unit()),
            };
            let is_time = panel.kind == Kind::Time;
            let plot = Plot {
                title: format!("{}: {}", self.title, panel.caption),
                size: if is_time { WIDE } else { HALF },
                x,
                y,
                // the panels over time share their axis: it is named once, below the last
                names_x: !is_time || Some(i) == last_over_time,
                bands: Vec::new(),
                noise: None,
                lines: panel.curves.iter().map(|curve| Line { x: &curve.x, y: &curve.y, ink: curve.ink }).collect(),
                points: usize::MAX,
            };
            (caption, plot)
        });
        Panels { title: self.title.clone(), legend: self.legend.clone(), row: TWO_IN_A_ROW, panels: panels.collect() }
            .draw()
            .into_string()
    }
}

/// The axes of a panel; those over time all show the same stretch.
fn axes(panel: &Panel, time: Option<(f64, f64)>) -> (Axis, Axis) {
    let x = || panel.curves.iter().flat_map(|curve| curve.x.iter().copied());
    let y = || panel.curves.iter().flat_map(|curve| curve.y.iter().copied());
    match panel.kind {
        Kind::Time => {
            let (from, to) = time.unwrap_or((0.0, 1.0));
            (Axis::spanning(&panel.x.title, panel.x.unit, from, to), Axis::around(&panel.y.title, panel.y.unit, y()))
        }
        Kind::Lateness => {
            let decades = |(low, high): (f64, f64)| (10f64.powf(low.log10().floor()), high);
            let (low, high) = extent(x()).map_or((1e-6, 1e-3), decades);
            let (least, _) = extent(y()).unwrap_or((1e-6, 1.0));
            (
                Axis::decades("Duration", "µs", low * 1e6, high * 1.1e6).scaled(1e-6),
                Axis::decades(&panel.y.title, "1", least.max(1e-9), 1.0),
            )
        }
        _ => (Axis::around(&panel.x.title, panel.x.unit, x()), Axis::around(&panel.y.title, panel.y.unit, y())),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Curve;
    use sinew_plot::{Field, Ink};

    pub(crate) fn figure() -> Figure {
        let x: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01).collect();
        let y: Vec<f64> = x.iter().map(|t| 0.16 + 0.003 * t.sin()).collect();
        let curve = |ink| Curve { ink, name: "one <two>".into(), x: x.clone(), y: y.clone() };
        let panel = |kind, x: &str, y: &str| Panel {
            kind,
            caption: Field::of(y).title,
            x: Field::of(x),
            y: Field::of(y),
            curves: vec![curve(Ink::Measured), curve(Ink::Series(0))],
        };
        Figure {
            title: "a & b".into(),
            legend: vec![(Ink::Series(0), "one <two>".into())],
            panels: vec![
                panel(Kind::Time, "time_s", "length_m"),
                panel(Kind::Hysteresis, "temperature_c", "length_m"),
                panel(Kind::Lateness, "time_s", "duty"),
            ],
            notes: Vec::new(),
        }
    }

    #[test]
    fn a_picture_has_all_its_panels_and_its_names_are_escaped() {
        let svg = figure().svg();
        assert!(svg.starts_with("<svg xmlns=") && svg.contains("a &amp; b") && svg.contains("one &lt;two&gt;"));
        assert_eq!(svg.matches("stroke=\"#0072B4\"").count(), 1 + 3, "the legend's sample and a curve a panel");
        assert!(svg.contains(">Wire length, mm<"), "in the prefix that suits it");
    }
}
