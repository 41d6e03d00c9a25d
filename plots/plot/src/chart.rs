//! The axes of a drawing with their numbers.

use plotters::prelude::*;

use crate::axis::Axis;
use crate::canvas::{Area, Drawn, FINE, fine};
use crate::ink::Ink;

/// Room for the numbers on the left and below, and towards the other edges, px.
pub(crate) const LEFT: f64 = 52.0;

const BELOW: f64 = 22.0;

pub(crate) const BELOW_WITH_NAME: f64 = 40.0;

pub(crate) const TOP: f64 = 8.0;

pub(crate) const RIGHT: f64 = 14.0;

/// Size of the numbers, px.
const TEXT: f64 = 12.0;

/// Axes to draw over.
pub(crate) type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Axis, Axis>>;

/// The axes with their numbers, over what is drawn `beneath`.
pub(crate) fn chart<'a, 'b>(
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

/// The backend divides sizes by 1.24.
pub(crate) fn text() -> TextStyle<'static> {
    let (r, g, b) = Ink::Axis.rgb();
    ("sans-serif", FINE * TEXT * 1.24).into_font().color(&RGBColor(r, g, b))
}

/// The edge of what is guilty.
pub(crate) fn edge() -> ShapeStyle {
    let (r, g, b) = Ink::Guilty.rgb();
    ShapeStyle { color: RGBAColor(r, g, b, 1.0), filled: false, stroke_width: fine(1.0) }
}
