//! Plots as inline SVG: lines over bands, residual strips, heat maps.
//!
//! Drawn in quarters of a pixel, since the backend rounds to whole units. Every ink has a colour of its own, by which the
//! page's style sheet gives it its dash and its colour on a dark screen; a reader without colours tells them by the dash.

use maud::{Markup, PreEscaped, html};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
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

/// The darkest shade of a map stands for at least this chi, so that noise stays pale.
const LEAST_DARK: f64 = 3.0;

/// The dashes of the inks, as a style sheet.
pub(crate) const DASHES: &str = include_str!("dashes.css");

/// What is drawn with. After Okabe and Ito, so that colour-blind readers can tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Measured: a broad pale line, on which the models' lie.
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
    /// One of several lines that are compared, by its place among them; see [`Ink::SERIES`].
    Series(u8),
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

    /// How many lines that are compared can be told apart: one further takes the ink of the first again.
    pub const SERIES: u8 = 10;

    /// Its colour, distinct from every other's: the style sheet's handle.
    pub const fn rgb(self) -> (u8, u8, u8) {
        match self {
            Ink::Measured => (0xA9, 0xB3, 0xBE),
            Ink::AsGiven => (0xCC, 0x79, 0xA7),
            Ink::Before => (0xD5, 0x5E, 0x00),
            Ink::After => (0x00, 0x72, 0xB2),
            Ink::Plain => (0x4B, 0x55, 0x63),
            Ink::LeftBefore => (0xD5, 0x5E, 0x01),
            Ink::LeftAfter => (0x00, 0x72, 0xB3),
            Ink::KeptBack => (0x6B, 0x77, 0x85),
            Ink::Guilty => (0xE6, 0x9F, 0x00),
            Ink::Noise => (0x56, 0xB4, 0xE9),
            Ink::Series(place) => match place % Ink::SERIES {
                0 => (0x00, 0x72, 0xB4),
                1 => (0xD5, 0x5E, 0x02),
                2 => (0x00, 0x9E, 0x73),
                3 => (0xCC, 0x79, 0xA8),
                4 => (0xE6, 0x9F, 0x01),
                5 => (0x56, 0xB4, 0xEA),
                6 => (0x8C, 0x5E, 0x2A),
                7 => (0x44, 0x4C, 0x56),
                8 => (0x8A, 0x8F, 0x00),
                _ => (0x7F, 0x3F, 0xBF),
            },
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

    /// How its lines are drawn.
    pub(crate) fn line(self) -> ShapeStyle {
        let width = match self {
            Ink::Measured => 4.0,
            Ink::LeftAfter => 1.1,
            Ink::Grid | Ink::Axis => 1.0,
            Ink::AsGiven | Ink::Plain => 1.4,
            Ink::Series(_) => 1.6,
            _ => 1.8,
        };
        ShapeStyle { color: self.colour(), filled: false, stroke_width: fine(width) }
    }

    fn fill(self) -> ShapeStyle {
        ShapeStyle { color: self.colour(), filled: true, stroke_width: 0 }
    }
}

/// How an axis runs from its low to its high end.
#[derive(Debug, Clone, PartialEq)]
enum Scale {
    Linear,
    /// Linear near 0 and logarithmic beyond ± this.
    Logarithmic(f64),
    /// As much room for each decade.
    Decades,
    /// As much room for each stretch between two edges.
    Steps(Vec<f64>),
}

/// One axis: what is on it, its unit, and the range shown.
#[derive(Debug, Clone)]
pub struct Axis {
    name: String,
    unit: String,
    prefix: Prefix,
    scale: Scale,
    /// In the prefixed unit, as are the ticks.
    low: f64,
    high: f64,
    ticks: Vec<f64>,
    /// Of the ticks' numbers.
    decimals: usize,
}

impl Axis {
    /// An axis that shows every one of `values` with a little air around them.
    pub fn around(name: &str, unit: &str, values: impl Iterator<Item = f64>) -> Axis {
        let (low, high) = extent(values).unwrap_or((0.0, 1.0));
        let axis = Axis::spanning(name, unit, low, high);
        let air = 0.05 * (axis.high - axis.low);
        Axis { low: axis.low - air, high: axis.high + air, ..axis }
    }

    /// An axis from `low` to `high` and no further.
    pub fn spanning(name: &str, unit: &str, low: f64, high: f64) -> Axis {
        let [low, high] = [low, high].map(|v| if is_sane(v) { v } else { 0.0 });
        let prefix = Prefix::of_axis(low.abs().max(high.abs()), unit);
        let [mut low, mut high] = [low.min(high) / prefix.factor, low.max(high) / prefix.factor];
        let magnitude = low.abs().max(high.abs());
        if high - low <= 1e-6 * magnitude {
            // a line that does not move is shown in the middle
            let half = if magnitude == 0.0 { 1.0 } else { 0.1 * magnitude };
            (low, high) = (low - half, high + half);
        }
        let unit = prefix.unit(unit);
        Axis { name: name.into(), unit, prefix, scale: Scale::Linear, low, high, ticks: Vec::new(), decimals: 0 }
    }

    /// An axis from `low` to `high`, both above 0, with as much room for each decade.
    pub fn decades(name: &str, unit: &str, low: f64, high: f64) -> Axis {
        let sane = low > 0.0 && is_sane(high) && high > low;
        let (low, high) = if sane { (low, high) } else { (1.0, 10.0) };
        let unit = Prefix::NONE.unit(unit);
        Axis { scale: Scale::Decades, prefix: Prefix::NONE, unit, low, high, ..Axis::spanning(name, "1", low, high) }
    }

    /// An axis of what is left, over the noise, up to ±`most`: logarithmic beyond the noise where that is far.
    pub fn left_over(most: f64, noise: f64) -> Axis {
        let scale = if most > 4.0 * noise { Scale::Logarithmic(noise) } else { Scale::Linear };
        Axis { scale, ..Axis::spanning("", "1", -most, most) }
    }

    /// An axis with as much room for each of the stretches between `edges`.
    pub fn steps(name: &str, edges: &[f64]) -> Axis {
        let scale = Scale::Steps(edges.to_vec());
        let (low, high) = extent(edges.iter().copied()).unwrap_or((0.0, 1.0));
        Axis { scale, prefix: Prefix::NONE, low, high, ..Axis::spanning(name, "1", low, high) }
    }

    /// The same axis for values in another unit: one of its units is `of` theirs, as µs are 1e-6 for values in s.
    pub fn scaled(self, of: f64) -> Axis {
        Axis { prefix: Prefix { factor: of, ..self.prefix }, ..self }
    }

    /// Name and unit, as in "Elongation, mm".
    pub fn title(&self) -> String {
        if self.unit().is_empty() { self.name.clone() } else { format!("{}, {}", self.name, self.unit()) }
    }

    /// Its unit with its prefix; empty for a pure number.
    pub fn unit(&self) -> &str {
        self.unit.trim()
    }

    /// Where `value` is drawn: at the nearest end if it is outside; none where there is no number.
    fn place(&self, value: f64) -> Option<f64> {
        is_sane(value).then(|| (value / self.prefix.factor).clamp(self.low, self.high))
    }

    /// How far from the low end to the high end a value is, 0..1.
    fn fraction(&self, value: f64) -> f64 {
        let fraction = match &self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic(width) => {
                let [value, low, high] = [value, self.low, self.high].map(|v| (v / width).asinh());
                (value - low) / (high - low)
            }
            Scale::Decades => (value / self.low).ln() / (self.high / self.low).ln(),
            Scale::Steps(edges) => {
                let step = edges.partition_point(|e| *e <= value).clamp(1, (edges.len() - 1).max(1)) - 1;
                let within = match edges.get(step..step + 2) {
                    Some(&[from, to]) if to > from => (value - from) / (to - from),
                    _ => 0.0,
                };
                (step as f64 + within) / (edges.len().max(2) - 1) as f64
            }
        };
        if fraction.is_finite() { fraction.clamp(0.0, 1.0) } else { 0.0 }
    }

    /// The value so far from the low end to the high one.
    fn at(&self, fraction: f64) -> f64 {
        match &self.scale {
            Scale::Logarithmic(width) => {
                let [low, high] = [self.low, self.high].map(|v| (v / width).asinh());
                width * (low + fraction * (high - low)).sinh()
            }
            Scale::Decades => self.low * (self.high / self.low).powf(fraction),
            Scale::Linear | Scale::Steps(_) => self.low + fraction * (self.high - self.low),
        }
    }

    /// The same axis with at most `most` ticks.
    fn ticked(&self, most: usize) -> Axis {
        let mut axis = self.clone();
        axis.ticks = match &self.scale {
            Scale::Linear => {
                // three at least, or nobody can read a value off
                let inside = |step: f64| ((self.high / step).floor() - (self.low / step).ceil()) as usize + 1;
                let step = |n: usize| nice_step((self.high - self.low) / n as f64);
                let most = most.max(2);
                let step = (most..2 * most).map(step).find(|s| inside(*s) >= 3).unwrap_or_else(|| step(2 * most));
                axis.decimals = (-(step * 1.0001).log10().floor()).clamp(0.0, 8.0) as usize;
                let (first, last) = ((self.low / step).ceil(), (self.high / step).floor());
                (0..=(last - first).clamp(0.0, 50.0) as usize).map(|i| (first + i as f64) * step).collect()
            }
            Scale::Logarithmic(_) => {
                let decades = (1..=15).map(|k| 10f64.powi(k)).filter(|t| *t <= self.high);
                let every = decades.clone().count().div_ceil((most / 2).max(1)).max(1);
                decades.step_by(every).flat_map(|t| [-t, t]).chain([0.0]).collect()
            }
            Scale::Decades => {
                let from = self.low.log10().floor() as i32;
                let to = self.high.log10().ceil() as i32;
                let ticks = |of: &[f64]| -> Vec<f64> {
                    let all = (from..=to).flat_map(|k| of.iter().map(move |m| m * 10f64.powi(k)));
                    all.filter(|t| (self.low * 0.9999..=self.high * 1.0001).contains(t)).collect()
                };
                let all = ticks(&[1.0, 2.0, 5.0]);
                if all.len() <= most { all } else { ticks(&[1.0]) }
            }
            Scale::Steps(edges) => {
                edges.iter().copied().step_by(1 + edges.len() / (most + 1)).filter(|e| is_sane(*e)).collect()
            }
        };
        axis
    }

    fn tick(&self, value: f64) -> String {
        match self.scale {
            Scale::Linear if self.decimals < 8 && value.abs() < 1e7 => fixed(value, self.decimals),
            _ => number(value),
        }
    }
}

/// 1, 2 or 5 times a power of ten, and at least `least`.
fn nice_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|n| n * decade).find(|step| *step >= least * 0.9999).unwrap_or(10.0 * decade)
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        from + (self.fraction(*value) * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.low..self.high
    }
}

/// A line through points; a NaN in either coordinate breaks it.
pub struct Line<'a> {
    /// Across.
    pub x: &'a [f64],
    /// Up; as many.
    pub y: &'a [f64],
    /// What with.
    pub ink: Ink,
}

/// A stretch of the horizontal axis.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// What with.
    pub ink: Ink,
}

/// Lines over bands.
pub struct Plot<'a> {
    /// What a reader who does not see it is told.
    pub title: String,
    /// Width and height, px.
    pub size: (f64, f64),
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Whether the horizontal axis says what is on it; the vertical one is named by the text around the plot.
    pub names_x: bool,
    /// Drawn beneath the lines.
    pub bands: Vec<Band>,
    /// Half the height of a band of noise around 0.
    pub noise: Option<f64>,
    /// The lines, the last on top.
    pub lines: Vec<Line<'a>>,
    /// Most points a line is drawn with.
    pub points: usize,
}

type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

impl Plot<'_> {
    /// The drawing, for a page or for a picture of its own.
    pub fn draw(&self) -> Markup {
        svg(&self.title, self.size, |area| {
            let (width, height) = self.size;
            let x = self.x.ticked((width / 65.0) as usize);
            let y = self.y.ticked((height / 28.0).clamp(3.0, 7.0) as usize);
            let name = self.names_x.then(|| self.x.title());
            let mut chart = chart(area, x, y, |chart| self.bands(chart), name)?;
            for line in &self.lines {
                for run in runs(line, self.points, &self.x, &self.y, self.size) {
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
                let bar = self.y.at(1.0 - 4.0 / self.size.1);
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
}

/// The axes with their numbers, over what is drawn `beneath`.
fn chart<'a, 'b>(
    area: &'a Area<'b>,
    x: Axis,
    y: Axis,
    beneath: impl FnOnce(&mut Chart<'a, 'b>) -> Drawn,
    x_name: Option<String>,
) -> Result<Chart<'a, 'b>, DrawingAreaErrorKind<std::io::Error>> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(fine(TOP))
        .margin_right(fine(RIGHT))
        .x_label_area_size(fine(if x_name.is_some() { BELOW_WITH_NAME } else { BELOW }))
        .y_label_area_size(fine(LEFT))
        .build_cartesian_2d(x.clone(), y.clone())?;
    beneath(&mut chart)?;
    let (x_tick, y_tick) = (|v: &f64| x.tick(*v), |v: &f64| y.tick(*v));
    let mut mesh = chart.configure_mesh();
    mesh.light_line_style(TRANSPARENT)
        .bold_line_style(Ink::Grid.line())
        .axis_style(Ink::Axis.line())
        .label_style(text())
        .axis_desc_style(text())
        .set_all_tick_mark_size(fine(4.0))
        .x_label_formatter(&x_tick)
        .y_label_formatter(&y_tick);
    if let Some(name) = x_name {
        mesh.x_desc(name);
    }
    mesh.draw()?;
    Ok(chart)
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
pub struct Heat<'a> {
    /// What a reader who does not see it is told.
    pub title: String,
    /// Width and height, px.
    pub size: (f64, f64),
    /// What is across, with its unit.
    pub x_name: &'a str,
    /// Edges of the cells across, one more than there are columns.
    pub x_edges: &'a [f64],
    /// Edges of the cells upwards, one more than there are rows.
    pub y_edges: &'a [f64],
    /// `[y][x]`; NaN where there is nothing.
    pub cells: &'a [Vec<f64>],
    /// What is drawn darkest.
    pub darkest: f64,
    /// The cell that is framed, as `(y, x)`.
    pub framed: Option<(usize, usize)>,
}

impl Heat<'_> {
    /// An SVG element, to stand inside a page.
    pub fn draw(&self) -> Markup {
        let (x, y) = (Axis::steps(self.x_name, self.x_edges), Axis::steps("", self.y_edges));
        svg(&self.title, self.size, |area| {
            let name = Some(self.x_name.to_owned());
            let mut chart = chart(area, x.ticked(12), y.ticked(9), |_| Ok(()), name)?;
            let wide = (self.size.0 - LEFT - RIGHT) / self.x_edges.len() as f64 > 30.0;
            let high = (self.size.1 - TOP - BELOW_WITH_NAME) / self.y_edges.len() as f64 > 13.0;
            for ((row, column), chi) in self.values() {
                let (Some(corners), true) = (self.corners(row, column, &x, &y), is_sane(chi)) else { continue };
                let depth = depth(chi, self.darkest);
                chart.draw_series([Rectangle::new(corners, sequential(depth).filled())])?;
                let [(left, low), (right, high_edge)] = corners;
                if wide && high {
                    let ink = if depth > 0.5 { RGBColor(255, 255, 254) } else { RGBColor(17, 24, 38) };
                    let style = text().color(&ink).pos(Pos::new(HPos::Center, VPos::Center));
                    let centre = (0.5 * (left + right), 0.5 * (low + high_edge));
                    chart.draw_series([Text::new(crate::quantity::chi(chi), centre, style)])?;
                }
            }
            let framed = self.framed.and_then(|(row, column)| self.corners(row, column, &x, &y));
            if let Some([(left, low), (right, high)]) = framed {
                let frame = [(left, low), (right, low), (right, high), (left, high), (left, low)];
                chart.draw_series([PathElement::new(frame, frame_style())])?;
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
}

/// 0 at a chi of 1 or less, 1 at `darkest`: by the logarithm, since a chi of 3 is already far from 1.
fn depth(chi: f64, darkest: f64) -> f64 {
    let depth = chi.max(1.0).ln() / darkest.max(LEAST_DARK).ln();
    if depth.is_finite() { depth.clamp(0.0, 1.0) } else { 0.0 }
}

/// The scale of the maps, from noise to the darkest, with its two numbers.
pub fn heat_scale(darkest: f64) -> Markup {
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
            " " (if is_sane(darkest) { crate::quantity::chi(darkest.max(LEAST_DARK)) } else { NONE.into() })
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

/// Least and largest of the values that are numbers.
pub fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
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
fn runs(line: &Line<'_>, most: usize, x: &Axis, y: &Axis, size: (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let length = line.x.len().min(line.y.len());
    let (xs, ys) = (&line.x[..length], &line.y[..length]);
    let mut runs: Vec<Vec<(f64, f64)>> = vec![Vec::new()];
    // points that fall on one another are one, or a line of them would have no direction to be drawn in
    let place = |x_value, y_value| {
        [(x, x_value, size.0), (y, y_value, size.1)].map(|(axis, v, s)| (FINE * s * axis.fraction(v)).round())
    };
    let mut before = None;
    for i in thinned(ys, most) {
        match (x.place(xs[i]), y.place(ys[i])) {
            (Some(x), Some(y)) => {
                let here = Some(place(x, y));
                if before != here {
                    runs.last_mut().into_iter().for_each(|run| run.push((x, y)));
                    before = here;
                }
            }
            _ => {
                runs.push(Vec::new());
                before = None;
            }
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
                svg viewBox={ "0 0 " (size.0) " " (size.1) } role="img" style={ "--least:" (width * 0.8) "px" } {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_style_sheet_knows_every_ink_and_no_two_are_alike() {
        let style = include_str!("style.css");
        let all: Vec<Ink> = Ink::ALL.into_iter().chain((0..Ink::SERIES).map(Ink::Series)).collect();
        for (i, &ink) in all.iter().enumerate() {
            let (r, g, b) = ink.rgb();
            assert!(style.contains(&format!("=\"#{r:02X}{g:02X}{b:02X}\"]")), "{ink:?}");
            assert!(all[..i].iter().all(|other| other.rgb() != ink.rgb()), "{ink:?}");
        }
    }

    #[test]
    fn ticks_are_round_numbers_inside_the_range() {
        for (low, high, most, expected, decimals) in [
            (0.0, 90.0, 10, &[0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0][..], 0),
            (1.78, 2.1, 7, &[1.8, 1.85, 1.9, 1.95, 2.0, 2.05, 2.1], 2),
            (-3.0, 5.0, 4, &[-2.0, 0.0, 2.0, 4.0], 0),
        ] {
            let axis = Axis::spanning("", "1", low, high).ticked(most);
            assert_eq!(axis.ticks.len(), expected.len(), "{:?}", axis.ticks);
            assert!(axis.ticks.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{:?}", axis.ticks);
            assert_eq!(axis.decimals, decimals);
        }
    }

    #[test]
    fn a_logarithmic_axis_is_linear_within_the_noise_and_has_its_ticks_at_decades() {
        let axis = Axis::left_over(300.0, 2.0).ticked(4);
        let mut ticks = axis.ticks.clone();
        ticks.sort_by(f64::total_cmp);
        assert_eq!(ticks, [-100.0, -10.0, 0.0, 10.0, 100.0]);
        assert_eq!(axis.fraction(0.0), 0.5);
        assert!((axis.at(axis.fraction(37.0)) - 37.0).abs() < 1e-9);
        assert_eq!(Axis::left_over(5.0, 2.0).scale, Scale::Linear);
    }

    #[test]
    fn stretches_between_edges_have_the_same_room() {
        let axis = Axis::steps("", &[0.0, 1.0, 10.0, 1000.0]);
        assert_eq!([0.0, 1.0, 10.0, 1000.0].map(|e| (3.0 * axis.fraction(e)).round()), [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(axis.fraction(5.5), 0.5);
    }

    #[test]
    fn an_axis_chooses_its_prefix_and_survives_any_range() {
        assert_eq!(Axis::around("Elongation", "m", [0.0, 0.0076].into_iter()).title(), "Elongation, mm");
        assert_eq!(Axis::around("Tension", "N", [0.98, 1.0].into_iter()).title(), "Tension, N");
        for (low, high) in
            [(f64::NAN, 1.0), (5.0, 5.0), (0.0, 0.0), (-1e300, 1e300), (1.0, 1.0 + 1e-15), (1e-300, 2e-300), (3.0, 1.0)]
        {
            let axis = Axis::spanning("", "1", low, high).ticked(7);
            assert!(axis.low < axis.high, "{low} to {high}");
            assert!(axis.ticks.len() <= 51 && axis.ticks.iter().all(|t| t.is_finite()), "{low} to {high}");
        }
    }

    #[test]
    fn thinning_keeps_spikes_and_gaps() {
        let mut y: Vec<f64> = (0..10_000).map(|i| f64::from(i % 7)).collect();
        y[4321] = 1e3;
        y[6000..7000].fill(f64::NAN);
        let kept = thinned(&y, 500);
        assert!(kept.len() <= 500 && kept.contains(&4321) && kept.is_sorted());
        assert!(kept.iter().any(|&i| y[i].is_nan()));
        assert_eq!(thinned(&y[..100], 500), (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn the_maps_grow_darker_all_the_way() {
        let luminance = |c: RGBColor| 0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2);
        let shades: Vec<f64> = (0..=100).map(|i| luminance(sequential(f64::from(i) / 100.0))).collect();
        assert!(shades.is_sorted_by(|a, b| a > b));
        assert_eq!([depth(0.5, 10.0), depth(10.0, 10.0), depth(f64::NAN, 10.0)], [0.0, 1.0, 0.0]);
    }

    #[test]
    fn decades_have_the_same_room() {
        let axis = Axis::decades("Frequency", "Hz", 0.05, 5.0).ticked(9);
        assert!((axis.fraction(0.5) - 0.5).abs() < 1e-12 && (axis.at(0.5) - 0.5).abs() < 1e-12);
        let shown: Vec<String> = axis.ticks.iter().map(|t| axis.tick(*t)).collect();
        assert_eq!(shown, ["0.05", "0.1", "0.2", "0.5", "1", "2", "5"]);
        assert_eq!(axis.title(), "Frequency, Hz");
        for (low, high) in [(0.0, 1.0), (-1.0, f64::NAN), (2.0, 1.0)] {
            let axis = Axis::decades("", "1", low, high).ticked(5);
            assert!(axis.low < axis.high && axis.fraction(f64::MIN_POSITIVE) == 0.0);
        }
    }
}
