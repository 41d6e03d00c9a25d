//! A plot that owns its numbers and chooses its axes by them.

use crate::axis::Axis;
use crate::ink::Ink;
use crate::plot::{Line, Plot};

/// Size of such a plot, px: two stand beside one another.
const SIZE: (f64, f64) = (460.0, 280.0);
/// Most points of a line.
const POINTS: usize = 3000;

/// Numbers over numbers, to be drawn as a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// What with.
    pub ink: Ink,
    /// Across.
    pub x: Vec<f64>,
    /// Up; as many.
    pub y: Vec<f64>,
}

/// A plot before its lines are borrowed.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// What is on the vertical axis.
    pub name: &'static str,
    /// The unit of what is on it.
    pub unit: &'static str,
    /// The same of the horizontal one: name and unit.
    pub x: (&'static str, &'static str),
    /// Whether each axis, horizontal and vertical, has as much room for each decade.
    pub decades: (bool, bool),
    /// The lines, the last on top.
    pub traces: Vec<Trace>,
}

impl Drawing {
    /// The plot and its caption: the name with the unit the axis has chosen.
    pub fn plot(&self) -> (String, Plot<'_>) {
        let all = |pick: fn(&Trace) -> &Vec<f64>| self.traces.iter().flat_map(move |t| pick(t).iter().copied());
        let axis = |name: &str, unit: &str, decades: bool, pick: fn(&Trace) -> &Vec<f64>| {
            let values = || all(pick).filter(|v| v.is_finite());
            let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
            match decades {
                true => Axis::decades(name, unit, 0.8 * low, 1.25 * high),
                false => Axis::around(name, unit, values()),
            }
        };
        let y = axis(self.name, self.unit, self.decades.1, |t| &t.y);
        let caption = y.title();
        let plot = Plot {
            title: self.name.into(),
            size: SIZE,
            x: axis(self.x.0, self.x.1, self.decades.0, |t| &t.x),
            y,
            names_x: true,
            bands: Vec::new(),
            noise: None,
            lines: self.traces.iter().map(|t| Line { x: &t.x, y: &t.y, ink: t.ink }).collect(),
            points: POINTS,
        };
        (caption, plot)
    }
}
