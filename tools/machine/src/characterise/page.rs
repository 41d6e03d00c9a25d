//! The HTML report of a characterisation: parameters, residuals of every recording, and validation on recordings not fitted.

use maud::html;
use sinew_plot::quantity::{fixed, number, shown_unit};
use sinew_plot::{Axis, Ink, Line, Panels, Plot, Section, Sheet, TWO_IN_A_ROW};
use sinew_recording::Column;

use super::{Characterised, Foretold, Recorded};
use crate::report::About;

/// A recording that was not fitted, as it was predicted by the rig file as it was and as it was fitted.
pub type Unseen<'a> = (&'a Recorded, Foretold, Foretold);

/// Size of a plot, px, and most points of a line.
const SIZE: (f64, f64) = (460.0, 280.0);
const POINTS: usize = 2500;

/// What the wire answered with, in the first place: its force where a machine moved it, else where its end was.
fn answer(recorded: &Recorded) -> Column {
    match recorded.recording.get(Column::ForceN) {
        Some(_) => Column::ForceN,
        None => Column::PositionM,
    }
}

/// The page: parameters, how every recording is met, and what was not fitted as it was measured and predicted.
pub fn page(judged: &Characterised, about: &About, unseen: &[Unseen<'_>]) -> String {
    let legend = vec![
        (Ink::Measured, "measured".to_string()),
        (Ink::Before, "foretold by the rig file as it was".to_string()),
        (Ink::After, "foretold by the fitted one".to_string()),
    ];
    // a conversion that did not fall into a row would break the line
    let measured: Vec<(Vec<f64>, Vec<f64>)> = unseen
        .iter()
        .map(|(recorded, _, _)| {
            let values = recorded.recording.get(answer(recorded)).unwrap_or(&[]);
            recorded.recording.time_s().iter().zip(values).filter(|(_, f)| f.is_finite()).map(|(t, f)| (*t, *f)).unzip()
        })
        .collect();
    let panels = unseen
        .iter()
        .zip(&measured)
        .map(|((recorded, before, after), (time_s, measured))| {
            let all_s = recorded.recording.time_s();
            let (name, unit) = match answer(recorded) {
                Column::ForceN => ("Force", "N"),
                _ => ("Elongation", "m"),
            };
            let (before, after) = (before.of(answer(recorded)), after.of(answer(recorded)));
            let all = measured.iter().chain(before).copied();
            let plot = Plot {
                title: format!("{name} over time: {}", recorded.task.name),
                size: SIZE,
                x: Axis::spanning("Time", "s", 0.0, recorded.recording.duration_s()),
                y: Axis::around("", unit, all),
                names_x: true,
                bands: Vec::new(),
                noise: None,
                lines: vec![
                    Line { x: time_s, y: measured, ink: Ink::Measured },
                    Line { x: all_s, y: before, ink: Ink::Before },
                    Line { x: all_s, y: after, ink: Ink::After },
                ],
                points: POINTS,
            };
            (format!("{}, {unit} ({})", recorded.task.name, recorded.task.kind.word()), plot)
        })
        .collect();
    let plots = Panels { title: String::new(), row: TWO_IN_A_ROW, legend, panels }.draw();
    Sheet {
        title: format!("{}: characterised", about.rig),
        class: "agrees",
        heading: html! { "Characterisation of " b { (about.channel) } ", rig " b { (about.rig) } },
        sections: vec![
            Section::unlisted(html! {
                section #answer {
                    h1 { "What no fit saw is foretold to chi " (fixed(judged.chi_unseen, 3)) }
                    p.lead { "chi: RMS of measured less foretold, over the sensors' noise. 1 means that nothing is left to explain." }
                    @for warning in &judged.warnings { p.callout { (warning) } }
                }
            }),
            Section::new("unseen", "Foretold", html! { section #unseen { h2 { "Routines that no fit saw" } figure { (plots) } } }),
            Section::new("recordings", "Recordings", html! {
                section #recordings {
                    h2 { "Recordings" }
                    table {
                        thead { tr { th { "recording" } th { "routine" } th { "s" } th { "chi as believed" } th { "chi fitted" } th { "by sensor" } th { "the fit saw it" } } }
                        tbody { @for met in &judged.recordings { tr {
                            td { (met.recording) } td { (met.routine) } td { (fixed(met.seconds, 0)) }
                            td { (number(met.chi_as_believed)) } td { (fixed(met.chi, 3)) }
                            td { @for (column, misfit) in &met.sensors { (column) " " (fixed(misfit.chi, 2)) " " } }
                            td { (if met.fitted { "yes" } else { "no" }) }
                        } } }
                    }
                }
            }),
            Section::new("parameters", "Parameters", html! {
                section #parameters {
                    h2 { "Parameters" }
                    table {
                        thead { tr { th { "parameter" } th { "given" } th { "fitted" } th { "90 % interval" } th { "unit" } } }
                        tbody { @for (key, p) in &judged.parameters { tr {
                            td { (key) } td { (number(p.given)) } td { (number(p.value)) }
                            td { (number(p.low)) " to " (number(p.high)) } td { (shown_unit(&p.unit)) }
                        } } }
                    }
                }
            }),
            Section::new("again", "Reproduce", html! { section #again { h2 { "Reproduce" } pre { code { (about.command) } } } }),
        ],
    }
    .page()
    .into_string()
}
