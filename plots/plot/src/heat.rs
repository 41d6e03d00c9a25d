//! Heat maps: chi over two conditions, from pale to dark.

use maud::{Markup, html};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::axis::Axis;
use crate::canvas::{fine, svg};
use crate::chart::{BELOW_WITH_NAME, LEFT, RIGHT, TOP, chart, edge, text};
use crate::quantity::{NONE, is_sane};

/// The darkest shade of a map stands for at least this chi, so that noise stays pale.
const LEAST_DARK: f64 = 3.0;

/// A map of chi over two conditions.
pub struct Heat<'a> {
    /// The text for a reader who does not see it.
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

fn frame_style() -> ShapeStyle {
    ShapeStyle { stroke_width: fine(3.0), ..edge() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_maps_grow_darker_all_the_way() {
        let luminance = |c: RGBColor| 0.2126 * f64::from(c.0) + 0.7152 * f64::from(c.1) + 0.0722 * f64::from(c.2);
        let shades: Vec<f64> = (0..=100).map(|i| luminance(sequential(f64::from(i) / 100.0))).collect();
        assert!(shades.is_sorted_by(|a, b| a > b));
        assert_eq!([depth(0.5, 10.0), depth(10.0, 10.0), depth(f64::NAN, 10.0)], [0.0, 1.0, 0.0]);
    }
}
