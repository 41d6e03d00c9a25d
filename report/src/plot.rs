//! Plots as inline SVG: lines over bands, residual strips, heat maps.
//!
//! Drawn in quarters of a pixel, since the backend rounds to whole units. Every ink has a colour of its own, by which the
//! page's style sheet gives it its dash and its colour on a dark screen; a reader without colours tells them by the dash.

use maud::{Markup, PreEscaped, html};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::quantity::{NONE, Prefix, fixed, is_sane, number};

/// Units of the drawing per pixel.
const FINE: f64 = 4.0;
/// Room for the numbers on the left and below, and towards the other edges, px.
const LEFT: f64 = 52.0;
const BELOW: f64 = 22.0;
const BELOW_WITH_NAME: f64 = 40.0;
const TOP: f64 = 8.0;
const RIGHT: f64 = 14.0;
/// Size of the numbers, px.
const TEXT: f64 = 12.0;

/// What is drawn with. After Okabe and Ito, so that colour-blind readers can tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    /// Measured: a thin dark line.
    Measured,
    /// The model as given, where it is neither before nor after: dotted.
    AsGiven,
    /// The model before: dashed.
    Before,
    /// The model after: solid.
    After,
    /// What needs no comparison, such as the drive.
    Plain,
    /// What is left before, as an area.
    LeftBefore,
    /// What is left after.
    LeftAfter,
    /// The band of a kept-back part.
    KeptBack,
    /// The band of a guilty window, and the frame of a guilty cell.
    Guilty,
    /// The band of the noise.
    Noise,
    /// Axes and their numbers.
    Axis,
    /// The grid.
    Grid,
}

impl Ink {
    #[cfg(test)]
    pub(crate) const ALL: [Ink; 12] = [
        Ink::Measured,
        Ink::AsGiven,
        Ink::Before,
        Ink::After,
        Ink::Plain,
        Ink::LeftBefore,
        Ink::LeftAfter,
        Ink::KeptBack,
        Ink::Guilty,
        Ink::Noise,
        Ink::Axis,
        Ink::Grid,
    ];

    /// Its colour, distinct from every other's: the style sheet's handle.
    pub(crate) const fn rgb(self) -> (u8, u8, u8) {
        match self {
            Ink::Measured => (0x33, 0x3D, 0x47),
            Ink::AsGiven => (0xCC, 0x79, 0xA7),
            Ink::Before => (0xD5, 0x5E, 0x00),
            Ink::After => (0x00, 0x72, 0xB2),
            Ink::Plain => (0x4B, 0x55, 0x63),
            Ink::LeftBefore => (0xD5, 0x5E, 0x01),
            Ink::LeftAfter => (0x00, 0x72, 0xB3),
            Ink::KeptBack => (0x6B, 0x77, 0x85),
            Ink::Guilty => (0xE6, 0x9F, 0x00),
            Ink::Noise => (0x56, 0xB4, 0xE9),
            Ink::Axis => (0x5F, 0x6B, 0x7A),
            Ink::Grid => (0xE3, 0xE7, 0xEC),
        }
    }

    fn colour(self) -> RGBAColor {
        let (r, g, b) = self.rgb();
        let opacity = match self {
            Ink::KeptBack => 0.13,
            Ink::Guilty => 0.24,
            Ink::Noise => 0.35,
            Ink::LeftBefore => 0.55,
            _ => 1.0,
        };
        RGBAColor(r, g, b, opacity)
    }

    fn line(self) -> ShapeStyle {
        let width = match self {
            Ink::Measured | Ink::LeftAfter => 1.1,
            Ink::Grid | Ink::Axis => 1.0,
            Ink::AsGiven | Ink::Plain => 1.4,
            _ => 1.8,
        };
        ShapeStyle { color: self.colour(), filled: false, stroke_width: fine(width) }
    }

    fn fill(self) -> ShapeStyle {
        ShapeStyle { color: self.colour(), filled: true, stroke_width: 0 }
    }
}

/// One axis: what is on it, its unit, and the range shown.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    name: String,
    unit: String,
    prefix: Prefix,
    /// In the prefixed unit.
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis that shows every one of `values` with a little air around them.
    pub(crate) fn around(name: &str, unit: &str, values: impl Iterator<Item = f64>) -> Axis {
        let (low, high) = extent(values).unwrap_or((0.0, 1.0));
        let air = 0.05 * (high - low);
        Axis::spanning(name, unit, low - air, high + air)
    }

    /// An axis from `low` to `high` and no further.
    pub(crate) fn spanning(name: &str, unit: &str, low: f64, high: f64) -> Axis {
        let [low, high] = [low, high].map(|v| if is_sane(v) { v } else { 0.0 });
        let magnitude = low.abs().max(high.abs());
        // a prefix is chosen without the air at the ends, which must not tip it over
        let prefix = Prefix::of_axis(magnitude / 1.05, unit);
        let [mut low, mut high] = [low.min(high) / prefix.factor, low.max(high) / prefix.factor];
        let least = 1e-6 * low.abs().max(high.abs()).max(1e-3);
        if high - low < least {
            // a line that does not move is shown in the middle
            let half = if low == 0.0 && high == 0.0 { 1.0 } else { 0.1 * low.abs().max(high.abs()).max(least) };
            (low, high) = (low - half, high + half);
        }
        Axis { name: name.into(), unit: prefix.unit(unit), prefix, low, high }
    }

    /// Name and unit, as in "Elongation, mm".
    pub(crate) fn title(&self) -> String {
        if self.unit.is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit) }
    }

    /// Its unit with its prefix; empty for a pure number.
    pub(crate) fn unit(&self) -> &str {
        self.unit.trim()
    }

    /// Where `value` is drawn: at the nearest end if it is outside; none where there is no number.
    fn place(&self, value: f64) -> Option<f64> {
        is_sane(value).then(|| (value / self.prefix.factor).clamp(self.low, self.high))
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }

    /// A number on it: as many decimals as steps of about a tenth of the range need.
    fn tick(&self, value: f64) -> String {
        let decimals = -((self.high - self.low) / 9.0).log10().floor();
        if decimals > 7.0 { number(value) } else { fixed(value, decimals.max(0.0) as usize) }
    }
}

/// A line through points; a NaN in either coordinate breaks it.
pub(crate) struct Line<'a> {
    pub(crate) x: &'a [f64],
    pub(crate) y: &'a [f64],
    pub(crate) ink: Ink,
}

/// A stretch of the horizontal axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) ink: Ink,
}

/// Lines over bands.
pub(crate) struct Plot<'a> {
    /// What a reader who does not see it is told.
    pub(crate) title: String,
    /// Width and height, px.
    pub(crate) size: (f64, f64),
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    /// Whether the horizontal axis says what is on it; the vertical one is named by the text around the plot.
    pub(crate) names_x: bool,
    pub(crate) bands: Vec<Band>,
    /// Half the height of a band of noise around 0.
    pub(crate) noise: Option<f64>,
    pub(crate) lines: Vec<Line<'a>>,
    /// Most points a line is drawn with.
    pub(crate) points: usize,
}

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

impl Plot<'_> {
    pub(crate) fn draw(&self) -> Markup {
        svg(&self.title, self.size, |area| {
            let below = if self.names_x { BELOW_WITH_NAME } else { BELOW };
            let mut chart = ChartBuilder::on(area)
                .margin_top(fine(TOP))
                .margin_right(fine(RIGHT))
                .x_label_area_size(fine(below))
                .y_label_area_size(fine(LEFT))
                .build_cartesian_2d(self.x.range(), self.y.range())?;
            self.bands(&mut chart)?;
            self.axes(&mut chart)?;
            for line in &self.lines {
                for run in runs(line, self.points, &self.x, &self.y) {
                    draw_run(&mut chart, run, line.ink)?;
                }
            }
            Ok(())
        })
    }

    fn bands(&self, chart: &mut Chart<'_, '_>) -> Drawn {
        let (low, high) = (self.y.low, self.y.high);
        for band in &self.bands {
            let (Some(from), Some(to)) = (self.x.place(band.from), self.x.place(band.to)) else { continue };
            if to <= from {
                continue;
            }
            chart.draw_series([Rectangle::new([(from, low), (to, high)], band.ink.fill())])?;
            if band.ink == Ink::KeptBack {
                // a bar along the top, which a grey print keeps
                let bar = high - (high - low) * 4.0 / self.size.1;
                chart.draw_series([Rectangle::new([(from, bar), (to, high)], Ink::Axis.fill())])?;
            }
            if band.ink == Ink::Guilty {
                let edges = [from, to].map(|x| PathElement::new([(x, low), (x, high)], edge()));
                chart.draw_series(edges)?;
            }
        }
        if let Some((low, high)) = self.noise.and_then(|n| Some((self.y.place(-n)?, self.y.place(n)?))) {
            chart.draw_series([Rectangle::new([(self.x.low, low), (self.x.high, high)], Ink::Noise.fill())])?;
        }
        Ok(())
    }

    fn axes(&self, chart: &mut Chart<'_, '_>) -> Drawn {
        let (x_tick, y_tick) = (|x: &f64| self.x.tick(*x), |y: &f64| self.y.tick(*y));
        let mut mesh = chart.configure_mesh();
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(Ink::Grid.line())
            .axis_style(Ink::Axis.line())
            .x_labels((self.size.0 / 90.0) as usize)
            .y_labels((self.size.1 / 34.0).clamp(3.0, 7.0) as usize)
            .label_style(text())
            .axis_desc_style(text())
            .set_all_tick_mark_size(fine(4.0))
            .x_label_formatter(&x_tick)
            .y_label_formatter(&y_tick);
        if self.names_x {
            mesh.x_desc(self.x.title());
        }
        mesh.draw()
    }
}

/// Draws what lies between two gaps.
fn draw_run(chart: &mut Chart<'_, '_>, run: Vec<(f64, f64)>, ink: Ink) -> Drawn {
    match (&run[..], ink) {
        (&[point], _) => {
            chart.draw_series([Circle::new(point, fine(1.2), ink.fill())])?;
        }
        (_, Ink::LeftBefore) => {
            chart.draw_series(AreaSeries::new(run, 0.0, ink.colour()).border_style(TRANSPARENT))?;
        }
        _ => {
            chart.draw_series(LineSeries::new(run, ink.line()))?;
        }
    }
    Ok(())
}

/// A map of chi over two conditions.
pub(crate) struct Heat<'a> {
    /// What a reader who does not see it is told.
    pub(crate) title: String,
    /// Width and height, px.
    pub(crate) size: (f64, f64),
    pub(crate) x_name: &'a str,
    pub(crate) x_edges: &'a [f64],
    pub(crate) y_edges: &'a [f64],
    /// `[y][x]`; NaN where there is nothing.
    pub(crate) cells: &'a [Vec<f64>],
    /// What is drawn darkest.
    pub(crate) darkest: f64,
    /// The cell that is framed, as `(y, x)`.
    pub(crate) framed: Option<(usize, usize)>,
}

impl Heat<'_> {
    pub(crate) fn draw(&self) -> Markup {
        let x = Axis::around(self.x_name, "1", self.x_edges.iter().copied()).without_air(self.x_edges);
        let y = Axis::around("", "1", self.y_edges.iter().copied()).without_air(self.y_edges);
        svg(&self.title, self.size, |area| {
            let mut chart = ChartBuilder::on(area)
                .margin_top(fine(TOP))
                .margin_right(fine(RIGHT))
                .x_label_area_size(fine(BELOW_WITH_NAME))
                .y_label_area_size(fine(LEFT))
                .build_cartesian_2d(x.range(), y.range())?;
            let (x_tick, y_tick) = (|v: &f64| x.tick(*v), |v: &f64| y.tick(*v));
            chart
                .configure_mesh()
                .disable_mesh()
                .axis_style(Ink::Axis.line())
                .x_labels(6)
                .y_labels(6)
                .label_style(text())
                .axis_desc_style(text())
                .set_all_tick_mark_size(fine(4.0))
                .x_label_formatter(&x_tick)
                .y_label_formatter(&y_tick)
                .x_desc(self.x_name)
                .draw()?;
            let roomy = self.size.0 / self.x_edges.len().max(1) as f64 > 30.0;
            for ((row, column), chi) in self.values() {
                let (Some(corners), true) = (self.corners(row, column, &x, &y), is_sane(chi)) else { continue };
                let shade = sequential(self.depth(chi));
                chart.draw_series([Rectangle::new(corners, shade.filled())])?;
                if self.framed == Some((row, column)) {
                    let [(left, low), (right, high)] = corners;
                    let frame = [(left, low), (right, low), (right, high), (left, high), (left, low)];
                    chart.draw_series([PathElement::new(frame, frame_style())])?;
                }
                if roomy {
                    let ink = if self.depth(chi) > 0.45 { RGBColor(255, 255, 254) } else { RGBColor(17, 24, 38) };
                    let style = text().color(&ink).pos(Pos::new(HPos::Center, VPos::Center));
                    let [(left, low), (right, high)] = corners;
                    let written = crate::quantity::chi(chi);
                    chart.draw_series([Text::new(written, (0.5 * (left + right), 0.5 * (low + high)), style)])?;
                }
            }
            Ok(())
        })
    }

    fn values(&self) -> impl Iterator<Item = ((usize, usize), f64)> + '_ {
        let rows = self.cells.iter().enumerate();
        rows.flat_map(|(row, cells)| cells.iter().enumerate().map(move |(column, &chi)| ((row, column), chi)))
    }

    fn corners(&self, row: usize, column: usize, x: &Axis, y: &Axis) -> Option<[(f64, f64); 2]> {
        let at = |axis: &Axis, edges: &[f64], i: usize| axis.place(*edges.get(i)?);
        Some([
            (at(x, self.x_edges, column)?, at(y, self.y_edges, row)?),
            (at(x, self.x_edges, column + 1)?, at(y, self.y_edges, row + 1)?),
        ])
    }

    /// 0 at noise, 1 at the darkest: by the logarithm, since a chi of 3 is already far from 1.
    fn depth(&self, chi: f64) -> f64 {
        depth(chi, self.darkest)
    }
}

/// 0 at a chi of 1 or less, 1 at `darkest`.
fn depth(chi: f64, darkest: f64) -> f64 {
    let depth = chi.max(1.0).ln() / darkest.max(1.5).ln();
    if depth.is_finite() { depth.clamp(0.0, 1.0) } else { 0.0 }
}

/// The scale of the maps, from noise to the darkest, with its two numbers.
pub(crate) fn heat_scale(darkest: f64) -> Markup {
    let stops: Vec<String> = (0..=8)
        .map(|i| {
            let RGBColor(r, g, b) = sequential(f64::from(i) / 8.0);
            format!("#{r:02X}{g:02X}{b:02X}")
        })
        .collect();
    html! {
        span.scale {
            "chi 1 or less "
            svg viewBox="0 0 90 10" width="90" height="10" role="img" {
                title { "From light, noise, to dark, the largest mismatch" }
                @for (i, stop) in stops.iter().enumerate() { rect x=(i * 10) width="10" height="10" fill=(stop) {} }
            }
            " " (if is_sane(darkest) { crate::quantity::chi(darkest.max(1.5)) } else { NONE.into() })
        }
    }
}

/// From pale yellow to dark blue; its luminance falls all the way, so that a grey print keeps the order.
fn sequential(depth: f64) -> RGBColor {
    const STOPS: [(u8, u8, u8); 5] = [(255, 255, 224), (199, 233, 180), (65, 182, 196), (34, 94, 168), (8, 29, 88)];
    let place = depth.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let below = (place as usize).min(STOPS.len() - 2);
    let ((r0, g0, b0), (r1, g1, b1), t) = (STOPS[below], STOPS[below + 1], place - below as f64);
    let mix = |a: u8, b: u8| (f64::from(a) + t * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(r0, r1), mix(g0, g1), mix(b0, b1))
}

impl Axis {
    fn without_air(mut self, edges: &[f64]) -> Axis {
        if let Some((low, high)) = extent(edges.iter().copied())
            && high / self.prefix.factor > low / self.prefix.factor
        {
            (self.low, self.high) = (low / self.prefix.factor, high / self.prefix.factor);
        }
        self
    }
}

/// Least and largest of the values that are numbers.
pub(crate) fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| is_sane(*v)).fold(None, |extent, v| match extent {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

/// The indices that show a line of `len` points with at most `most`: the least and the largest of every stretch, so that
/// no spike is lost, and one missing where all of a stretch is.
pub(crate) fn thinned(y: &[f64], most: usize) -> Vec<usize> {
    if y.len() <= most || most < 4 {
        return (0..y.len().min(most.max(4))).collect();
    }
    let stretches = most / 2;
    let mut kept = Vec::with_capacity(most);
    for i in 0..stretches {
        let stretch = i * y.len() / stretches..(i + 1) * y.len() / stretches;
        let numbers = || stretch.clone().filter(|&j| is_sane(y[j]));
        let least = numbers().min_by(|&a, &b| y[a].total_cmp(&y[b]));
        let largest = numbers().max_by(|&a, &b| y[a].total_cmp(&y[b]));
        match (least, largest) {
            (Some(a), Some(b)) if a == b => kept.push(a),
            (Some(a), Some(b)) => kept.extend([a.min(b), a.max(b)]),
            _ => kept.push(stretch.start),
        }
    }
    kept
}

/// A line's points as they are drawn, cut at its gaps.
fn runs(line: &Line<'_>, most: usize, x: &Axis, y: &Axis) -> Vec<Vec<(f64, f64)>> {
    let length = line.x.len().min(line.y.len());
    let (xs, ys) = (&line.x[..length], &line.y[..length]);
    let mut runs: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
    for i in thinned(ys, most) {
        match (x.place(xs[i]), y.place(ys[i])) {
            (Some(x), Some(y)) => runs.last_mut().into_iter().for_each(|run| run.push((x, y))),
            _ => runs.push(Vec::new()),
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// The drawing's frame: what the backend wrote, as a picture with a title that fills the width it is given.
fn svg(title: &str, (width, height): (f64, f64), draw: impl FnOnce(&Area<'_>) -> Drawn) -> Markup {
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
                svg viewBox={ "0 0 " (size.0) " " (size.1) } role="img" style={ "--least:" (width * 0.7) "px" } {
                    title { (title) }
                    (PreEscaped(body))
                }
            }
            _ => p.muted { "This plot could not be drawn: " (title) }
        }
    }
}

fn fine(pixels: f64) -> u32 {
    (FINE * pixels).round() as u32
}

/// The backend divides sizes by 1.24.
fn text() -> TextStyle<'static> {
    let (r, g, b) = Ink::Axis.rgb();
    ("sans-serif", FINE * TEXT * 1.24).into_font().color(&RGBColor(r, g, b))
}

fn edge() -> ShapeStyle {
    let (r, g, b) = Ink::Guilty.rgb();
    ShapeStyle { color: RGBAColor(r, g, b, 1.0), filled: false, stroke_width: fine(1.0) }
}

fn frame_style() -> ShapeStyle {
    ShapeStyle { stroke_width: fine(3.0), ..edge() }
}
