//! One picture of a diagnosis, for a paper, a talk or a page of documentation: every recording as measured and simulated.

use maud::{Markup, PreEscaped, html};
use sinew_diagnosis::{Diagnosis, Figures, SensorTrace, Traces};
use sinew_recording::Column;

use crate::figures::{Stages, kept_back, time_axis, worst_first};
use crate::plot::{Axis, DASHES, Ink, Line, Plot};
use crate::words;

/// Most recordings of a picture.
const PANELS: usize = 6;
/// A panel with its caption, and the room around it, px.
const PANEL: (f64, f64) = (460.0, 250.0);
const CAPTION: f64 = 22.0;
const GAP: f64 = 14.0;
/// Height of the legend's one line, px.
const LEGEND: f64 = 26.0;
const POINTS: usize = 900;
const FONT: &str = "font-family: sans-serif; font-size: 13px; fill: #1b2430";

/// A standalone SVG of the recordings, two side by side: the sensor with most to explain over time, or, where the
/// wire's temperature was imposed, over that.
pub(crate) fn picture(diagnosis: &Diagnosis, figures: &Figures) -> Markup {
    let stages = Stages::of(diagnosis.verdict);
    let panels: Vec<(&Traces, &SensorTrace)> = figures
        .recordings
        .iter()
        .filter_map(|recording| Some((recording, *worst_first(diagnosis, &stages, recording).first()?)))
        .take(PANELS)
        .collect();
    let across = panels.len().clamp(1, 2);
    let width = GAP + across as f64 * (PANEL.0 + GAP);
    let height = LEGEND + panels.len().div_ceil(across) as f64 * (CAPTION + PANEL.1 + GAP) + GAP;
    html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (width) " " (height) } width=(width) height=(height) {
            style { (PreEscaped(DASHES)) }
            rect width=(width) height=(height) fill="#ffffff" {}
            (legend(&stages))
            @for (i, (recording, sensor)) in panels.into_iter().enumerate() {
                @let x = GAP + (i % across) as f64 * (PANEL.0 + GAP);
                @let y = LEGEND + (i / across) as f64 * (CAPTION + PANEL.1 + GAP);
                (panel(&stages, recording, sensor, (x, y)))
            }
        }
    }
}

fn legend(stages: &Stages) -> Markup {
    let before = stages.before.map(|(_, name)| (Ink::Before, name));
    let all = [Some((Ink::Measured, "measured")), before, Some((Ink::After, stages.after.1))];
    let width = |name: &str| 34.0 + 6.6 * name.chars().count() as f64 + 22.0;
    let places = all.into_iter().flatten().scan(GAP, |next, (ink, name)| {
        let x = *next;
        *next += width(name);
        Some((x, ink, name))
    });
    html! {
        @for (x, ink, name) in places {
            @let (r, g, b) = ink.rgb();
            @let colour = format!("#{r:02X}{g:02X}{b:02X}");
            // in the plots' quarters of a pixel, so that dashes are as long as there
            g transform={ "translate(" (x) " 16) scale(0.25)" } {
                polyline points="0,0 112,0" fill="none" stroke=(colour) stroke-width=(ink.line().stroke_width) {}
            }
            text x=(x + 34.0) y="20" style=(FONT) { (name) }
        }
    }
}

fn panel(stages: &Stages, recording: &Traces, sensor: &SensorTrace, (left, top): (f64, f64)) -> Markup {
    let furnace = recording.drive_column == Column::TemperatureC;
    let over = if furnace { &recording.drive } else { &recording.time_s };
    let (what, x) = if furnace {
        ("temperature", Axis::around("Temperature", "°C", over.iter().copied()))
    } else {
        ("time", time_axis(over))
    };
    let before = stages.before.map_or(&[][..], |(of, _)| of(sensor));
    let after = (stages.after.0)(sensor);
    let (name, unit) = words::column(sensor.column);
    let y = Axis::around(name, unit, [&sensor.measured, before, after].into_iter().flatten().copied());
    let caption = format!("{}: {}", words::short(&recording.name), y.title());
    let line = |y, ink| Line { x: over, y, ink };
    let plot = Plot {
        title: format!("{name} over {what} in {}, measured and simulated", words::short(&recording.name)),
        size: PANEL,
        x,
        y,
        names_x: true,
        bands: if furnace { Vec::new() } else { kept_back(recording) },
        noise: None,
        lines: vec![line(&sensor.measured, Ink::Measured), line(before, Ink::Before), line(after, Ink::After)],
        points: POINTS,
    };
    html! {
        text x=(left) y=(top + 15.0) style=(FONT) { (caption) }
        svg x=(left) y=(top + CAPTION) width=(PANEL.0) height=(PANEL.1) { (plot.draw()) }
    }
}
