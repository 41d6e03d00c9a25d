//! A transformation seen as a step: base lines before and after it, and the tangent where it is steepest.

use serde::Serialize;

use crate::branch::{Branch, Stretch};
use crate::error::Error;
use crate::fit::{Line, tangent};

/// Between the tangents' start and finish of a logistic curve of steepness k lie so many 1/k.
pub const STRAIN_SPAN: f64 = 4.0;

/// A number, and how far it moves with the choice of tangents.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Half of the range it takes over all stretches that tangents may be laid through.
    pub by_choice: f64,
}

impl Estimate {
    /// From what each choice gives, the usual one first.
    pub(crate) fn of(choices: &[f64]) -> Estimate {
        let (low, high) = choices.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        Estimate { value: choices[0], by_choice: 0.5 * (high - low) }
    }
}

/// Start and finish of a transformation, in its own order: on cooling it starts hot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Transition {
    /// A_s or M_s, °C.
    pub start_c: Estimate,
    /// A_f or M_f, °C.
    pub finish_c: Estimate,
    /// Change between the base lines at the steepest place, in the curve's unit.
    pub step: f64,
}

impl Transition {
    /// Half-way between start and finish, °C.
    pub fn middle_c(&self) -> f64 {
        0.5 * (self.start_c.value + self.finish_c.value)
    }

    /// From start to finish, K.
    pub fn span_k(&self) -> f64 {
        (self.finish_c.value - self.start_c.value).abs()
    }

    /// Steepness of the logistic curve with these tangents, 1/K.
    pub fn steepness_per_k(&self) -> f64 {
        STRAIN_SPAN / self.span_k()
    }
}

/// What tangents are laid through, as shares of the way from start to finish: half the stretch around the steepest place, and how far from that
/// place base lines begin. The first is the usual one.
const CHOICES: [(f64, f64); 5] = [(0.25, 1.25), (0.15, 1.25), (0.35, 1.25), (0.25, 1.0), (0.25, 1.75)];
/// Base lines are laid through at least so many samples, over so much of the way from start to finish.
const LEAST_ROWS: usize = 5;
const LEAST_BASE: f64 = 0.3;
/// Where nothing is known yet, slopes are of so much of the sweep on either side, at so many places.
const FIRST_HALF: f64 = 0.04;
const PLACES: usize = 200;
/// The step must be so many times the scatter about its base lines.
const STANDS_OUT: f64 = 6.0;

/// The transformation of a branch.
pub(crate) fn transition(branch: &Branch) -> Result<Transition, Error> {
    let flat = || Error::Flat { branch: branch.stretch.name() };
    let (mut at_c, slope) =
        steepest(branch, branch.coldest_c(), branch.hottest_c(), FIRST_HALF * branch.span_k()).ok_or_else(flat)?;
    let mean = |points: &[(f64, f64)]| points.iter().map(|(_, y)| y).sum::<f64>() / points.len().max(1) as f64;
    let rim = (branch.points.len() / 20).max(3);
    let rise = mean(&branch.points[branch.points.len() - rim..]) - mean(&branch.points[..rim]);
    let mut span_k = (rise / slope).abs().max(branch.span_k() / PLACES as f64);
    let mut found = Err(flat());
    for _ in 0..4 {
        let tangents = Tangents::laid(branch, at_c, span_k, CHOICES[0]);
        if let Ok(tangents) = &tangents {
            (at_c, span_k) = (tangents.at_c, tangents.finish_c - tangents.start_c);
        }
        found = tangents;
    }
    let usual = found?;
    if !usual.stands_out(branch) {
        return Err(flat());
    }
    // a choice that the curve has no room for is none
    let all: Vec<Tangents> =
        CHOICES[1..].iter().filter_map(|c| Tangents::laid(branch, at_c, span_k, *c).ok()).collect();
    let over =
        |of: fn(&Tangents) -> f64| Estimate::of(&std::iter::once(&usual).chain(&all).map(of).collect::<Vec<_>>());
    let (cold, hot) = (over(|t| t.start_c), over(|t| t.finish_c));
    Ok(match branch.stretch {
        Stretch::Heating => Transition { start_c: cold, finish_c: hot, step: usual.step() },
        Stretch::Cooling => Transition { start_c: hot, finish_c: cold, step: -usual.step() },
    })
}

/// The steepest place between two temperatures, and the slope there, from tangents through `half` on either side.
fn steepest(branch: &Branch, low_c: f64, high_c: f64, half: f64) -> Option<(f64, f64)> {
    let place = |i: usize| low_c + (high_c - low_c) * (i as f64 + 0.5) / PLACES as f64;
    let slopes = (0..PLACES).filter_map(|i| Some((place(i), tangent(&branch.points, place(i), half)?.slope)));
    slopes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

/// Tangents as they are laid: on the cold and on the hot side, and at the steepest place.
struct Tangents {
    cold: Line,
    hot: Line,
    at_c: f64,
    /// Where they meet: cold and hot end.
    start_c: f64,
    finish_c: f64,
}

impl Tangents {
    /// Around a transformation that is about here and about so wide.
    fn laid(branch: &Branch, at_c: f64, span_k: f64, (half, base): (f64, f64)) -> Result<Tangents, Error> {
        let base_line = |is_cold: bool| {
            let end_c = if is_cold { at_c - base * span_k } else { at_c + base * span_k };
            let needed_c = if is_cold { end_c - LEAST_BASE * span_k } else { end_c + LEAST_BASE * span_k };
            let points =
                if is_cold { branch.between(f64::NEG_INFINITY, end_c) } else { branch.between(end_c, f64::INFINITY) };
            let reaches = if is_cold { branch.coldest_c() <= needed_c } else { branch.hottest_c() >= needed_c };
            match Line::through(points.iter().copied()) {
                Some(line) if reaches && points.len() >= LEAST_ROWS => Ok(line),
                _ => Err(branch.no_base_line(is_cold, needed_c)),
            }
        };
        let (cold, hot) = (base_line(true)?, base_line(false)?);
        let flat = || Error::Flat { branch: branch.stretch.name() };
        let near = half * span_k;
        let (at_c, _) = steepest(branch, at_c - 0.5 * span_k, at_c + 0.5 * span_k, near).ok_or_else(flat)?;
        let steep = tangent(&branch.points, at_c, near).ok_or_else(flat)?;
        let (start_c, finish_c) = (steep.meets(&cold).ok_or_else(flat)?, steep.meets(&hot).ok_or_else(flat)?);
        let is_within = branch.coldest_c() <= start_c && start_c < finish_c && finish_c <= branch.hottest_c();
        if is_within { Ok(Tangents { cold, hot, at_c, start_c, finish_c }) } else { Err(flat()) }
    }

    /// From the cold base line to the hot one.
    fn step(&self) -> f64 {
        self.hot.y(self.at_c) - self.cold.y(self.at_c)
    }

    /// Whether the step is more than what scatters about its base lines.
    fn stands_out(&self, branch: &Branch) -> bool {
        let about = |points: &[(f64, f64)], line: &Line| {
            let sum: f64 = points.iter().map(|(t, y)| (y - line.y(*t)).powi(2)).sum();
            (sum / points.len().max(1) as f64).sqrt()
        };
        let below = branch.between(f64::NEG_INFINITY, self.start_c - 0.5 * (self.finish_c - self.start_c));
        let above = branch.between(self.finish_c + 0.5 * (self.finish_c - self.start_c), f64::INFINITY);
        self.step().abs() > STANDS_OUT * about(below, &self.cold).max(about(above, &self.hot))
    }
}
