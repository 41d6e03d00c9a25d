//! The HTML report: one self-contained page with plots, and the plots as a separate image.

use maud::{Markup, html};
use sinew_plot::quantity::{fixed, number, shown_unit};
use sinew_plot::{Drawing, Ink, Panels, Section, Sheet, TWO_IN_A_ROW, Trace};

use crate::analysis::loops::level_name;
use crate::analysis::sweep::{Response, responses};
use crate::analysis::{Finding, Run};
use crate::plan::RoutineKind;
use crate::report::{OnRig, Report, value};
use crate::run::Row;
use crate::stage::Part;

/// The drawings of a run and what their inks stand for.
fn drawings(run: &Run<'_>) -> (Vec<(Ink, String)>, Vec<Drawing>) {
    match run.kind {
        RoutineKind::DirectStrain | RoutineKind::DirectLoad => loops(run),
        RoutineKind::ConstantForceSweep | RoutineKind::ConstantStrainSweep | RoutineKind::TrackingSweep => {
            let all = responses(run);
            let (legend, mut drawings) = over_time(run);
            drawings.splice(0..0, bode(run, &all));
            (legend, drawings)
        }
        RoutineKind::PositionRegulation
        | RoutineKind::PositionTracking
        | RoutineKind::Programme
        | RoutineKind::BreakIn => over_time(run),
    }
}

/// Force over elongation and over time, a line for each heating level (figure 85).
fn loops(run: &Run<'_>) -> (Vec<(Ink, String)>, Vec<Drawing>) {
    let levels = run.options.heating.len();
    let mut loops: Vec<Trace> = Vec::new();
    let mut times: Vec<Trace> = Vec::new();
    for level in 0..levels {
        let ink = Ink::Series(level as u8);
        let (mut x, mut t, mut y) = (Vec::new(), Vec::new(), Vec::new());
        let mut start_s = None;
        for (stage, rows) in run.stretches() {
            let (Part::Loading { level: of, .. } | Part::Unloading { level: of, .. }) = stage.part else { continue };
            if of != level {
                continue;
            }
            for row in rows.iter().filter(|row| row.reading.force_is_new) {
                x.push(row.reading.position_m);
                t.push(row.time_s - *start_s.get_or_insert(row.time_s));
                y.push(row.reading.force_n);
            }
        }
        loops.push(Trace { ink, x, y: y.clone() });
        times.push(Trace { ink, x: t, y });
    }
    let legend = (0..levels).map(|level| (Ink::Series(level as u8), level_name(run, level))).collect();
    let drawing = |name, x, traces| Drawing { name, unit: "N", x, decades: (false, false), traces };
    let drawings = vec![
        drawing("Load over displacement", ("Displacement", "m"), loops),
        drawing("Load over time", ("Time", "s"), times),
    ];
    (legend, drawings)
}

/// Amplitude and phase over frequency.
fn bode(run: &Run<'_>, all: &[Response]) -> Vec<Drawing> {
    let frequencies: Vec<f64> = all.iter().map(|r| r.frequency_hz).collect();
    let closed = run.kind.is_closed_loop();
    let force = run.kind == RoutineKind::ConstantStrainSweep;
    let amplitude = all
        .iter()
        .map(|r| match (closed, force) {
            (true, _) => r.gain.value,
            (false, true) => 2.0 * r.answer.amplitude.value,
            (false, false) => 2e3 * r.answer.amplitude.value,
        })
        .collect();
    let (name, unit) = match (closed, force) {
        (true, _) => ("Amplitude over the reference's", "1"),
        (false, true) => ("Swing of the force", "N"),
        (false, false) => ("Stroke", "mm"),
    };
    let trace = |y: Vec<f64>| vec![Trace { ink: Ink::After, x: frequencies.clone(), y }];
    vec![
        Drawing { name, unit, x: ("Frequency", "Hz"), decades: (true, true), traces: trace(amplitude) },
        Drawing {
            name: "Phase",
            unit: "°",
            x: ("Frequency", "Hz"),
            decades: (true, false),
            traces: trace(all.iter().map(|r| r.phase_deg.value).collect()),
        },
    ]
}

/// Everything over time.
fn over_time(run: &Run<'_>) -> (Vec<(Ink, String)>, Vec<Drawing>) {
    let x: Vec<f64> = run.rows.iter().map(|row| row.time_s).collect();
    let trace = |ink: Ink, of: &dyn Fn(&Row) -> f64| Trace { ink, x: x.clone(), y: run.rows.iter().map(of).collect() };
    let hangs = |row: &Row| run.kind.is_closed_loop() && run.stages[row.directive.stage].part != Part::Prepare;
    let mut position = Vec::new();
    let mut legend = vec![(Ink::After, "measured".to_string())];
    if run.kind.is_closed_loop() {
        let reference = |row: &Row| if hangs(row) { row.directive.target } else { f64::NAN };
        position.push(trace(Ink::Before, &reference));
        legend.push((Ink::Before, "reference".to_string()));
    }
    position.push(trace(Ink::After, &|row| row.reading.position_m));
    let drawing = |name, unit, traces| Drawing { name, unit, x: ("Time", "s"), decades: (false, false), traces };
    let drawings = vec![
        drawing("Elongation", "m", position),
        drawing("Power", "W", vec![trace(Ink::After, &|row| row.reading.power_w())]),
        drawing(
            "Force",
            "N",
            vec![trace(Ink::After, &|row| if row.reading.force_is_new { row.reading.force_n } else { f64::NAN })],
        ),
        drawing(
            "Resistance",
            "Ω",
            vec![trace(Ink::After, &|row| row.reading.resistance_ohm(50.0 * run.spec.current_step_a.max(1e-6)))],
        ),
    ];
    (legend, drawings)
}

/// The plots of a run as a standalone SVG.
pub fn picture(run: &Run<'_>) -> String {
    let (legend, drawings) = drawings(run);
    let panels = drawings.iter().map(Drawing::plot).collect();
    Panels { title: String::new(), row: TWO_IN_A_ROW, legend, panels }.draw().into_string()
}

/// The page: `report.html`.
pub fn page(run: &Run<'_>, report: &Report) -> String {
    let (legend, drawings) = drawings(run);
    let panels = drawings.iter().map(Drawing::plot).collect();
    let plots = Panels { title: String::new(), row: TWO_IN_A_ROW, legend, panels }.draw();
    Sheet {
        title: format!("{}: {}", report.about.rig, report.routine),
        class: "agrees",
        heading: html! { b { (report.routine) } " of " b { (report.about.channel) } ", rig " b { (report.about.rig) } },
        sections: vec![
            Section::unlisted(answer(report)),
            Section::new("plots", "Plots", html! { section #plots { h2 { "Plots" } figure { (plots) } } }),
            Section::new("numbers", "Numbers", numbers(&report.findings)),
            Section::new("asked", "Asked for", asked(run)),
            Section::new("again", "Reproduce", again(report)),
        ],
    }
    .page()
    .into_string()
}

fn answer(report: &Report) -> Markup {
    let known = report.findings.iter().filter(|f| f.value.is_some()).count();
    html! {
        section #answer {
            h1 { (report.routine) ": " (known) " numbers of " (report.findings.len()) }
            p.lead {
                (fixed(report.seconds, 1)) " s on " (report.place()) (report.about.rig) ", " (report.rows) " rows, " (report.ending) "."
            }
            @if let Some(OnRig { position, load }) = &report.running {
                p { "Position: " (position) ". Force: reckoned from the load, " (load) "." }
            }
            @if report.partial { p.callout { "Partial: the numbers are of what was completed." } }
            @for note in &report.notes { p.callout { (note) } }
        }
    }
}

fn numbers(findings: &[Finding]) -> Markup {
    html! {
        section #numbers {
            h2 { "Numbers" }
            p.muted { "± is one standard uncertainty." }
            table {
                thead { tr { th { "what" } th { "of" } th { "value" } th { "unit" } th { "how" } } }
                tbody {
                    @for finding in findings {
                        tr {
                            td { (finding.name) }
                            td { (finding.of) }
                            @match value(finding) {
                                Some(value) => { td { (value) } td { (shown_unit(finding.unit)) } }
                                None => { td { "–" } td {} }
                            }
                            td.muted { (finding.how) }
                        }
                    }
                }
            }
        }
    }
}

fn asked(run: &Run<'_>) -> Markup {
    let o = run.options;
    let list = |values: &[f64], scale: f64| values.iter().map(|v| number(v * scale)).collect::<Vec<_>>().join(", ");
    let mut rows: Vec<(&str, String)> = vec![
        ("heating", format!("{} of {} {}", o.quantity.word(), list(&o.heating, 1.0), o.quantity.unit())),
        ("chamber", o.chamber_c.map_or("off".into(), |c| format!("{} °C", number(c)))),
    ];
    if let Some(programme) = &o.programme {
        rows[0] = ("programme", format!("{}, {} rows", programme.name(), programme.rows()));
        rows.push(("takes", format!("{} s", number(programme.duration_s()))));
        return table(rows);
    }
    match run.kind {
        RoutineKind::DirectStrain => rows.push(("strains", format!("{} %", list(&o.strains, 100.0)))),
        RoutineKind::DirectLoad => rows.push(("loads", format!("{} N", list(&o.loads_n, 1.0)))),
        RoutineKind::ConstantForceSweep | RoutineKind::BreakIn => {
            rows.push(match &o.own_load {
                Some(load) => ("load", load.to_string()),
                None => ("load", format!("{} N", list(&o.loads_n[..o.loads_n.len().min(1)], 1.0))),
            });
        }
        RoutineKind::ConstantStrainSweep => {
            rows.push(("strain", format!("{} %", list(&o.strains[..o.strains.len().min(1)], 100.0))))
        }
        _ => {
            rows.push(("places", format!("{} % strain", list(&o.strains, 100.0))));
            rows.push(("law", format!("{}, estimator {}", o.law.word(), o.estimator.word())));
        }
    }
    match (&o.own_load, run.kind.is_closed_loop()) {
        (_, false) => {}
        (Some(load), true) => rows.push(("load", load.to_string())),
        (None, true) => {
            rows.push(("hanging load", format!("{} N", number(o.plant.load_n))));
            rows.push(("mass played", format!("{} kg", number(o.plant.mass_kg))));
            rows.push(("proportional part", format!("{} m/(N s)", number(o.plant.mobility_m_per_n_s))));
        }
    }
    match run.kind {
        RoutineKind::DirectStrain | RoutineKind::DirectLoad => {
            rows.push(("speed", format!("{} mm/s", number(o.speed_m_s * 1e3))));
        }
        RoutineKind::PositionRegulation => rows.push(("each held for", format!("{} s", number(o.hold_s)))),
        _ => rows.push(("wave", format!("{} of {} Hz", o.shape.word(), list(&o.frequencies_hz, 1.0)))),
    }
    if run.kind == RoutineKind::BreakIn {
        let within = &o.tolerance;
        rows.push((
            "settled within",
            format!("{} % of strain, {} K", number(100.0 * within.strain), number(within.kelvin)),
        ));
    }
    rows.push(("cycles", o.cycles.to_string()));
    table(rows)
}

fn table(rows: Vec<(&str, String)>) -> Markup {
    html! {
        section #asked {
            h2 { "Asked for" }
            table { tbody { @for (name, value) in rows { tr { th { (name) } td { (value) } } } } }
        }
    }
}

fn again(report: &Report) -> Markup {
    html! {
        section #again {
            h2 { "Reproduce" }
            pre { code { (report.about.command) } }
            p.muted { "sinew " (report.about.version) }
        }
    }
}
