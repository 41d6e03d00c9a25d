//! Lines over bands, and residual strips.

use maud::Markup;
use plotters::prelude::*;

use crate::axis::Axis;
use crate::canvas::{Drawn, FINE, fine, svg};
use crate::chart::{Chart, chart, edge};
use crate::ink::Ink;
use crate::quantity::is_sane;

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
    /// The text for a reader who does not see it.
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
