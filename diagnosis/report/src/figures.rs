//! The page's figures: measured against simulated, what is left over time and conditions, what each equation lacks.

use maud::{Markup, html};
use sinew_diagnosis::{Diagnosis, Figures, Map, SensorTrace, Traces, UnknownInput, Verdict, Window};
use sinew_plot::quantity::{chi, fixed, percent, quantity};
use sinew_plot::{Axis, Band, Heat, Ink, Line, Plot, extent, heat_scale};
use sinew_recording::Column;

use crate::words;

/// Width of a plot over the page's whole width, and of one of two side by side, px.
const WIDE: f64 = 940.0;
const HALF: f64 = 460.0;
/// Points of all lines of the page together, so that it stays below 2 MB …
const POINTS: usize = 110_000;
/// … and of a line, at most and at least.
const LINE_MOST_POINTS: usize = 1500;
const LINE_LEAST_POINTS: usize = 200;
/// Recordings that are drawn; more are only listed.
const RECORDINGS: usize = 8;
/// Sensors that are in sight at once; more are folded away.
const SENSORS_IN_SIGHT: usize = 3;
/// Half the height of the noise band, in σ of the noise: 95 % of it.
const NOISE_BAND: f64 = 2.0;
/// A cell of a map below this is no more than noise.
const NOISY_CHI: f64 = 1.3;

/// A stage of the model, and what it is called.
type Stage = (fn(&SensorTrace) -> &[f64], &'static str);

/// Which stages of the model are shown as before and after.
pub(crate) struct Stages {
    pub(crate) before: Option<Stage>,
    pub(crate) after: Stage,
    /// The model as given is drawn beside them.
    beside: bool,
}

impl Stages {
    pub(crate) fn of(verdict: Verdict) -> Stages {
        match verdict {
            Verdict::Agrees => {
                Stages { before: None, after: (|s| &s.as_given, "simulated, rig file as given"), beside: false }
            }
            Verdict::ParametersOff => Stages {
                before: Some((|s| &s.as_given, "simulated, rig file as given")),
                after: (|s| &s.improved, "simulated, recalibrated"),
                beside: false,
            },
            Verdict::PhysicsMissing | Verdict::UnknownPhysics => Stages {
                before: Some((|s| &s.recalibrated, "simulated before: best parameters, same physics")),
                after: (|s| &s.improved, "simulated after: with what was found"),
                beside: true,
            },
        }
    }
}

/// Every recording as measured and simulated, with what is left below. The one with the worst window is in sight, the
/// others are folded away.
pub(crate) fn traces(diagnosis: &Diagnosis, figures: &Figures) -> Markup {
    let stages = Stages::of(diagnosis.verdict);
    let recordings = worst_in_front(diagnosis, figures);
    let several = recordings.len() > 1;
    let drawn = &recordings[..recordings.len().min(RECORDINGS)];
    let points = points_per_line(drawn);
    let sheet = |recording, points| Sheet {
        diagnosis,
        recording,
        windows: windows(diagnosis, recording),
        stages: &stages,
        points,
    };
    html! {
        @if let [front, others @ ..] = drawn {
            @let sheet_in_front = sheet(front, points.0);
            (legend(&stages, diagnosis))
            @if several { h3 { "Recording " (words::short(&front.name)) } }
            (sheet_in_front.sensors())
            (sheet_in_front.zoom())
            (sheet_in_front.loops())
            (sheet_in_front.wire())
            @for other in others {
                @let sheet = sheet(other, points.1);
                details {
                    summary { "Recording " (words::short(&other.name)) }
                    (sheet.sensors())
                    (sheet.loops())
                }
            }
            @if recordings.len() > drawn.len() {
                p.muted { "Only " (RECORDINGS) " recordings are drawn; the table of recordings lists them all." }
            }
        } @else {
            p.muted { "No recording was drawn." }
        }
    }
}

fn worst_in_front<'a>(diagnosis: &Diagnosis, figures: &'a Figures) -> Vec<&'a Traces> {
    let worst = |recording: &Traces| {
        windows(diagnosis, recording).iter().map(|w| w.share).filter(|share| *share > 0.0).fold(0.0, f64::max)
    };
    let mut recordings: Vec<&Traces> = figures.recordings.iter().collect();
    let mut front = 0;
    for (i, recording) in recordings.iter().enumerate() {
        if worst(recording) > worst(recordings[front]) {
            front = i;
        }
    }
    if !recordings.is_empty() {
        recordings[..=front].rotate_right(1);
    }
    recordings
}

/// The swatches are drawn as the lines are.
fn legend(stages: &Stages, diagnosis: &Diagnosis) -> Markup {
    html! {
        ul.legend {
            li { (swatch("measured")) "measured" }
            @if stages.beside { li { (swatch("given")) "simulated, rig file as given" } }
            @if let Some((_, name)) = stages.before { li { (swatch("before")) (name) } }
            li { (swatch("after")) (stages.after.1) }
            li { (swatch("kept")) "kept back: never fitted" }
            @if !diagnosis.location.windows.is_empty() { li { (swatch("guilty")) "where the mismatch is" } }
            li { (swatch("noise")) "noise, ±2 σ" }
        }
    }
}

fn swatch(kind: &str) -> Markup {
    html! {
        svg class={ "swatch " (kind) } viewBox="0 0 30 12" width="30" height="12" aria-hidden="true" {
            @if matches!(kind, "kept" | "guilty" | "noise") { rect width="30" height="12" {} }
            @match kind {
                "kept" => rect.bar width="30" height="3" {},
                "guilty" => path d="M1 0V12M29 0V12" {},
                "noise" => {},
                _ => path d="M0 6H30" {},
            }
        }
    }
}

fn windows<'a>(diagnosis: &'a Diagnosis, recording: &Traces) -> Vec<&'a Window> {
    diagnosis.location.windows.iter().filter(|w| w.recording == recording.name).collect()
}

/// Points for each line of the recording in front, and of the others.
fn points_per_line(drawn: &[&Traces]) -> (usize, usize) {
    let lines = |recordings: &[&Traces]| -> usize { recordings.iter().map(|r| 6 * r.sensors.len() + 10).sum() };
    let (front, others) = drawn.split_at(drawn.len().min(1));
    let share = |points: usize, lines: usize| (points / lines.max(1)).clamp(LINE_LEAST_POINTS, LINE_MOST_POINTS);
    let of_front = share(POINTS / 2, lines(front));
    let of_others = share(POINTS.saturating_sub(of_front * lines(front)), lines(others));
    (of_front, of_others)
}

/// One recording's plots.
struct Sheet<'a> {
    diagnosis: &'a Diagnosis,
    recording: &'a Traces,
    windows: Vec<&'a Window>,
    stages: &'a Stages,
    points: usize,
}

impl Sheet<'_> {
    /// The sensors, those with most to explain first.
    fn sensors(&self) -> Markup {
        let sensors = self.worst_first();
        let in_sight = sensors.len().min(SENSORS_IN_SIGHT);
        html! {
            @for sensor in &sensors[..in_sight] { (self.sensor(sensor)) }
            @if sensors.len() > in_sight {
                details {
                    summary { (sensors.len() - in_sight) @if sensors.len() == in_sight + 1 { " more sensor" } @else { " more sensors" } " of this recording" }
                    @for sensor in &sensors[in_sight..] { (self.sensor(sensor)) }
                }
            }
        }
    }

    fn worst_first(&self) -> Vec<&SensorTrace> {
        worst_first(self.diagnosis, self.stages, self.recording)
    }

    fn sensor(&self, sensor: &SensorTrace) -> Markup {
        self.sensor_during(sensor, 0..self.recording.time_s.len(), None)
    }

    /// A closer look at the worst window, where the whole recording is too long to see it.
    fn zoom(&self) -> Markup {
        let time = &self.recording.time_s;
        let worst = self.windows.iter().max_by(|a, b| a.share.total_cmp(&b.share));
        let (Some(window), Some(&sensor), Some((first, last))) =
            (worst, self.worst_first().first(), extent(time.iter().copied()))
        else {
            return html! {};
        };
        let margin = 0.3 * (window.end_s - window.start_s);
        let (from, to) = (window.start_s - margin, window.end_s + margin);
        let inside = time.partition_point(|t| *t < from)..time.partition_point(|t| *t <= to);
        if inside.len() < 10 || to - from > 0.6 * (last - first) {
            return html! {};
        }
        let note = format!("closer, {} s to {} s", fixed(from.max(first), 1), fixed(to.min(last), 1));
        self.sensor_during(sensor, inside, Some(&note))
    }

    fn sensor_during(&self, sensor: &SensorTrace, span: std::ops::Range<usize>, note: Option<&str>) -> Markup {
        let cut = |y: &[f64]| -> Vec<f64> { span.clone().map(|i| y.get(i).copied().unwrap_or(f64::NAN)).collect() };
        let time = cut(&self.recording.time_s);
        let measured = cut(&sensor.measured);
        let as_given = if self.stages.beside { cut(&sensor.as_given) } else { Vec::new() };
        let before = self.stages.before.map(|(of, _)| cut(of(sensor))).unwrap_or_default();
        let after = cut((self.stages.after.0)(sensor));
        let (name, unit) = words::column(sensor.column);
        let y = Axis::around(name, unit, [&measured, &as_given, &before, &after].into_iter().flatten().copied());
        let x = time_axis(&time);
        let line = |y, ink| Line { x: &time, y, ink };
        let lines = vec![
            line(&measured, Ink::Measured),
            line(&as_given, Ink::AsGiven),
            line(&before, Ink::Before),
            line(&after, Ink::After),
        ];
        let left_before = over_noise(&measured, &before, sensor.noise);
        let left_after = over_noise(&measured, &after, sensor.noise);
        let left = |left: &[f64]| extent(left.iter().copied()).map_or(0.0, |(l, h)| l.abs().max(h.abs()));
        let most = left(&left_before).max(left(&left_after)).max(2.0 * NOISE_BAND);
        let title = y.title();
        let main = Plot {
            title: format!("{name} over time in {}, measured and simulated", words::short(&self.recording.name)),
            size: (WIDE, 210.0),
            x: x.clone(),
            y,
            names_x: false,
            bands: self.bands(),
            noise: None,
            lines,
            points: self.points,
        };
        let strip = Plot {
            title: format!("{name}: measured less simulated, over the noise"),
            size: (WIDE, 132.0),
            x,
            y: Axis::left_over(most, NOISE_BAND),
            names_x: true,
            bands: self.bands(),
            noise: Some(NOISE_BAND),
            lines: vec![
                Line { x: &time, y: &left_before, ink: Ink::LeftBefore },
                Line { x: &time, y: &left_after, ink: Ink::LeftAfter },
            ],
            points: self.points,
        };
        html! {
            figure {
                figcaption {
                    b { (title) }
                    @if let Some(note) = note { span.note { (note) } } @else { (self.chis(sensor)) }
                }
                div.scroll {
                    (main.draw())
                    p.strip { "what is left, in units of the noise (" (quantity(sensor.noise, unit)) ")"
                        @if most > 4.0 * NOISE_BAND { ", logarithmic beyond it" }
                        @if self.stages.before.is_some() { "; shaded before, line after" } }
                    (strip.draw())
                }
            }
        }
    }

    fn bands(&self) -> Vec<Band> {
        let guilty = self.windows.iter().map(|w| Band { from: w.start_s, to: w.end_s, ink: Ink::Guilty });
        kept_back(self.recording).into_iter().chain(guilty).collect()
    }

    fn chis(&self, sensor: &SensorTrace) -> Markup {
        let fit = &self.diagnosis.fit;
        let of = |stage: &std::collections::BTreeMap<String, sinew_diagnosis::Misfit>| {
            stage.get(sensor.column.name()).map(|e| chi(e.chi))
        };
        let stages: Vec<String> =
            [&fit.as_given, &fit.recalibrated, &fit.improved].into_iter().filter_map(of).collect();
        html! {
            @if !stages.is_empty() { span.note { "chi " (stages.join(" → ")) } }
        }
    }

    /// Elongation, or the tension where the ends are held, against temperature and against the drive.
    fn loops(&self) -> Markup {
        let sensor = |column| self.recording.sensors.iter().find(|s| s.column == column);
        let Some(answer) = sensor(Column::PositionM).or_else(|| sensor(Column::ForceN)) else {
            return html! {};
        };
        let recording = self.recording;
        let (drive, drive_unit) = words::column(recording.drive_column);
        let mut against = vec![("Wire temperature in the model", "°C", &recording.temperature_c)];
        if recording.drive_column != Column::TemperatureC {
            against.push((drive, drive_unit, &recording.drive));
        }
        let (name, unit) = words::column(answer.column);
        let before = self.stages.before.map_or(&[][..], |(of, _)| of(answer));
        let after = (self.stages.after.0)(answer);
        let y = Axis::around(name, unit, [&answer.measured, before, after].into_iter().flatten().copied());
        let title = y.title();
        html! {
            figure {
                figcaption { b { (title) } span.note { "the hysteresis loops" } }
                div.pair {
                    @for (what, unit, x) in against {
                        @let plot = Plot {
                            title: format!("{name} against {what}, measured and simulated"),
                            size: (HALF, 260.0),
                            x: Axis::around(what, unit, x.iter().copied()),
                            y: y.clone(),
                            names_x: true,
                            bands: Vec::new(),
                            noise: None,
                            lines: vec![
                                Line { x, y: &answer.measured, ink: Ink::Measured },
                                Line { x, y: before, ink: Ink::Before },
                                Line { x, y: after, ink: Ink::After },
                            ],
                            points: self.points,
                        };
                        div.scroll { (plot.draw()) }
                    }
                }
            }
        }
    }

    /// What the wire was given and what became of it.
    fn wire(&self) -> Markup {
        let recording = self.recording;
        let (drive, unit) = words::column(recording.drive_column);
        let x = time_axis(&recording.time_s);
        let strips = [
            (drive, unit, &recording.drive),
            ("Wire temperature in the model", "°C", &recording.temperature_c),
            ("Martensite fraction in the model", "1", &recording.martensite),
        ];
        html! {
            details {
                summary { "Drive, wire temperature and martensite over time" }
                @for (i, (name, unit, values)) in strips.into_iter().enumerate() {
                    @let y = Axis::around(name, unit, values.iter().copied());
                    figure {
                        figcaption { b { (y.title()) } }
                        div.scroll {
                            (Plot {
                                title: format!("{name} over time in {}", words::short(&recording.name)),
                                size: (WIDE, 120.0),
                                x: x.clone(),
                                y,
                                names_x: i == 2,
                                bands: self.bands(),
                                noise: None,
                                lines: vec![Line { x: &recording.time_s, y: values, ink: Ink::Plain }],
                                points: self.points,
                            }.draw())
                        }
                    }
                }
            }
        }
    }
}

/// The sensors of a recording, those with most to explain first.
pub(crate) fn worst_first<'a>(diagnosis: &Diagnosis, stages: &Stages, recording: &'a Traces) -> Vec<&'a SensorTrace> {
    let fit = &diagnosis.fit;
    let stage = if stages.beside { &fit.recalibrated } else { &fit.as_given };
    let chi = |s: &SensorTrace| stage.get(s.column.name()).map_or(f64::NEG_INFINITY, |e| e.chi);
    let mut sensors: Vec<&SensorTrace> = recording.sensors.iter().collect();
    sensors.sort_by(|a, b| chi(b).total_cmp(&chi(a)));
    sensors
}

pub(crate) fn kept_back(recording: &Traces) -> Vec<Band> {
    recording.kept_back.iter().map(|&(from, to)| Band { from, to, ink: Ink::KeptBack }).collect()
}

pub(crate) fn time_axis(time: &[f64]) -> Axis {
    let (first, last) = extent(time.iter().copied()).unwrap_or((0.0, 1.0));
    Axis::spanning("Time", "s", first, last)
}

fn over_noise(measured: &[f64], simulated: &[f64], noise: f64) -> Vec<f64> {
    measured.iter().zip(simulated).map(|(m, s)| (m - s) / noise).collect()
}

/// Residual by condition: before and after side by side on one scale, or once where there is no such difference.
pub(crate) fn maps(diagnosis: &Diagnosis, figures: &Figures) -> Markup {
    let complete = diagnosis.verdict.is_complete();
    html! {
        @for map in figures.maps.iter().filter(|m| !m.before.is_empty()) {
            @let darkest = extent(map.before.iter().chain(&map.after).flatten().copied()).map_or(1.0, |(_, h)| h);
            figure {
                figcaption {
                    b { "chi by " (uncapitalised(&map.x)) " and " (map.y) }
                    span.note { (heat_scale(darkest)) }
                }
                @let stages = [(&map.before, "recalibrated"), (&map.after, if complete { "final model" } else { "with what was found" })];
                div.pair {
                    @for (cells, when) in &stages[usize::from(complete)..] {
                        div {
                            p.strip { (when) "; upwards: " (map.y) }
                            div.scroll {
                                (Heat {
                                    title: format!("chi by {} and {}, {when}", map.x, map.y),
                                    size: (HALF, 250.0),
                                    x_name: &map.x,
                                    x_edges: &map.x_edges,
                                    y_edges: &map.y_edges,
                                    cells,
                                    darkest,
                                    framed: if complete { None } else { guilty_cell(map) },
                                }.draw())
                            }
                        }
                    }
                }
            }
        }
    }
}

fn uncapitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// The cell with most left before, if that is more than noise, as `(y, x)`.
fn guilty_cell(map: &Map) -> Option<(usize, usize)> {
    let rows = map.before.iter().enumerate();
    let cells = rows.flat_map(|(y, row)| row.iter().enumerate().map(move |(x, &chi)| ((y, x), chi)));
    cells.filter(|(_, chi)| *chi > NOISY_CHI).max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(cell, _)| cell)
}

/// What each equation would have to be given, the one that explains most first.
pub(crate) fn unknown_inputs(diagnosis: &Diagnosis, figures: &Figures) -> Markup {
    let mut inputs: Vec<&UnknownInput> = figures.unknown_inputs.iter().collect();
    inputs.sort_by(|a, b| b.score.total_cmp(&a.score));
    let bands: Vec<Band> = figures.recordings.first().map_or_else(Vec::new, |first| {
        windows(diagnosis, first).iter().map(|w| Band { from: w.start_s, to: w.end_s, ink: Ink::Guilty }).collect()
    });
    html! {
        div.pair {
            @for input in inputs {
                @let guilty = diagnosis.location.equation.as_deref() == Some(&input.equation);
                @let y = Axis::around("", &input.unit, input.value.iter().copied().chain([0.0]));
                figure.guilty[guilty] {
                    figcaption {
                        span { b { (input.equation) } ": " (input.what) @if !y.unit().is_empty() { ", " (y.unit()) } }
                        span.note { "explains " (percent(input.score)) }
                    }
                    div.scroll {
                        (Plot {
                            title: format!("{} over time: the {} equation's unknown input", input.what, input.equation),
                            size: (HALF, 150.0),
                            x: time_axis(&input.time_s),
                            y,
                            names_x: true,
                            bands: bands.clone(),
                            noise: None,
                            lines: vec![Line {
                                x: &input.time_s,
                                y: &input.value,
                                ink: if guilty { Ink::After } else { Ink::Plain },
                            }],
                            points: LINE_MOST_POINTS,
                        }.draw())
                    }
                }
            }
        }
    }
}
