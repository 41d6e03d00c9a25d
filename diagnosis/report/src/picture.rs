//! One picture of a diagnosis, for a paper, a talk or a page of documentation: every recording as measured and simulated.

use maud::Markup;
use sinew_diagnosis::{Diagnosis, Figures, SensorTrace, Traces};
use sinew_plot::{Axis, Ink, Line, Panels, Plot, TWO_IN_A_ROW};
use sinew_recording::Column;

use crate::figures::{Stages, kept_back, time_axis, worst_first};
use crate::words;

/// Most recordings of a picture.
const PANELS: usize = 6;
/// Size of a panel, px.
const PANEL: (f64, f64) = (460.0, 250.0);
const POINTS: usize = 900;

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
    let before = stages.before.map(|(_, name)| (Ink::Before, name));
    let legend = [Some((Ink::Measured, "measured")), before, Some((Ink::After, stages.after.1))];
    Panels {
        title: String::new(),
        row: TWO_IN_A_ROW,
        legend: legend.into_iter().flatten().map(|(ink, name)| (ink, name.to_owned())).collect(),
        panels: panels.into_iter().map(|(recording, sensor)| panel(&stages, recording, sensor)).collect(),
    }
    .draw()
}

fn panel<'a>(stages: &Stages, recording: &'a Traces, sensor: &'a SensorTrace) -> (String, Plot<'a>) {
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
    (caption, plot)
}
