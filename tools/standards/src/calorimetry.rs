//! Heat flow over temperature, as a differential scanning calorimeter measures it (ASTM F2004): the tangents of a peak's flanks meet the
//! base line at the start and the finish of the transformation.

use serde::Serialize;

use crate::branch::{Branch, Stretch};
use crate::error::Error;
use crate::fit::{Line, tangent};
use crate::transition::Estimate;

/// Between the tangents' start and finish of a logistic transformation's peak, k sech²(k x/2)/4, lie so many 1/k: the flanks are steepest at
/// x = ± 2 artanh(1/√3)/k, and their tangents meet the base line √3/2 · 2/k further out.
pub const LOGISTIC_SPAN: f64 = 6.098_050_807_568_877;

/// A peak.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Peak {
    /// A_s or M_s, °C.
    pub start_c: Estimate,
    /// A_p or M_p, °C.
    pub peak_c: f64,
    /// A_f or M_f, °C.
    pub finish_c: Estimate,
    /// Area between the curve and the base line, heat flow × K; over the rate of the sweep (K/s) it is the heat.
    pub area: f64,
    /// Where a second peak stands that has more than a tenth of this one's height, °C: an R-phase, most likely.
    pub second_c: Option<f64>,
}

impl Peak {
    /// Half-way between start and finish, °C.
    pub fn middle_c(&self) -> f64 {
        0.5 * (self.start_c.value + self.finish_c.value)
    }

    /// From start to finish, K.
    pub fn span_k(&self) -> f64 {
        (self.finish_c.value - self.start_c.value).abs()
    }

    /// Steepness of the logistic transformation with this peak, 1/K.
    pub fn steepness_per_k(&self) -> f64 {
        LOGISTIC_SPAN / self.span_k()
    }
}

/// Both peaks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Calorimetry {
    /// On heating: A_s, A_p, A_f.
    pub heating: Peak,
    /// On cooling: M_s, M_p, M_f.
    pub cooling: Peak,
}

/// Transformation temperatures from a heat flow of any unit and sign over temperatures in °C, in the order they were measured.
///
/// # Errors
/// What the curve lacks, and where it would have to be measured.
pub fn calorimetry(temperature_c: &[f64], heat_flow: &[f64]) -> Result<Calorimetry, Error> {
    let of = |stretch| peak(&Branch::of(temperature_c, heat_flow, stretch)?);
    Ok(Calorimetry { heating: of(Stretch::Heating)?, cooling: of(Stretch::Cooling)? })
}

/// What is averaged over for the height and the place of a peak, as a share of the sweep; how many places are looked at.
const SMOOTH: f64 = 0.01;
const PLACES: usize = 400;
/// Half of the stretch that a flank's tangent is laid through, in widths of the peak at half height; the first is the usual one.
const HALVES: [f64; 4] = [0.2, 0.12, 0.16, 0.28];
/// The base line begins so many of these widths from the peak, and is so long at least. A logistic peak is down to 10⁻³ there.
const BASE: f64 = 2.2;
const LEAST_BASE: f64 = 0.3;
/// Share of the places that are most of them, and how often they are chosen anew.
const MOST: f64 = 0.5;
const TRIMS: usize = 20;
/// A peak is as many times as high as what scatters about the base line.
const STANDS_OUT: f64 = 6.0;
/// A second peak is at least so high beside the first, and the valley between no more than this of it.
const SECOND: f64 = 0.1;
const VALLEY: f64 = 0.7;

fn peak(branch: &Branch) -> Result<Peak, Error> {
    let flat = || Error::Flat { branch: branch.stretch.name() };
    let half = SMOOTH * branch.span_k();
    let step = (branch.span_k() - 2.0 * half) / PLACES as f64;
    let smooth: Vec<(f64, f64)> = (0..=PLACES)
        .map(|i| branch.coldest_c() + half + step * i as f64)
        .filter_map(|t| Some((t, tangent(&branch.points, t, half)?.at)))
        .collect();
    // a peak is the smaller part of a sweep: the first base line is that of most places, wherever the sweep ends
    let mut base = most(&smooth).ok_or_else(flat)?;
    let mut found = None;
    for _ in 0..3 {
        let over = |(t, y): &(f64, f64)| (y - base.y(*t)).abs();
        let top = (0..smooth.len()).max_by(|a, b| over(&smooth[*a]).total_cmp(&over(&smooth[*b]))).ok_or_else(flat)?;
        let peak_c = smooth[top].0;
        let height = smooth[top].1 - base.y(peak_c);
        let low = smooth[..top].iter().rposition(|p| over(p) < 0.5 * height.abs());
        let high = smooth[top..].iter().position(|p| over(p) < 0.5 * height.abs()).map(|at| top + at);
        let (Some(low), Some(high)) = (low, high) else {
            return Err(branch.no_base_line(low.is_none(), peak_c));
        };
        let width = smooth[high].0 - smooth[low].0;
        let (cold_c, hot_c) = (peak_c - BASE * width, peak_c + BASE * width);
        for (is_cold, needed_c, there) in [
            (true, cold_c - LEAST_BASE * width, branch.coldest_c() <= cold_c - LEAST_BASE * width),
            (false, hot_c + LEAST_BASE * width, branch.hottest_c() >= hot_c + LEAST_BASE * width),
        ] {
            if !there {
                return Err(branch.no_base_line(is_cold, needed_c));
            }
        }
        let beside = branch.between(f64::NEG_INFINITY, cold_c).iter().chain(branch.between(hot_c, f64::INFINITY));
        base = Line::through(beside.copied()).ok_or_else(flat)?;
        found = Some((top, peak_c, height, width));
    }
    let (top, peak_c, height, width) = found.ok_or_else(flat)?;
    let beside = || {
        let cold = branch.between(f64::NEG_INFINITY, peak_c - BASE * width);
        cold.iter().chain(branch.between(peak_c + BASE * width, f64::INFINITY))
    };
    let scatter =
        (beside().map(|(t, y)| (y - base.y(*t)).powi(2)).sum::<f64>() / beside().count().max(1) as f64).sqrt();
    if height.abs() < STANDS_OUT * scatter {
        return Err(flat());
    }
    let flank = |is_cold: bool| -> Result<Estimate, Error> {
        let (from, to) = if is_cold { (peak_c - 1.5 * width, peak_c) } else { (peak_c, peak_c + 1.5 * width) };
        let meets = |share: f64| {
            let place = |i: usize| from + (to - from) * i as f64 / PLACES as f64;
            let tangents = (0..=PLACES).filter_map(|i| tangent(&branch.points, place(i), share * width));
            let steepest = tangents.max_by(|a, b| a.slope.abs().total_cmp(&b.slope.abs()))?;
            steepest.meets(&base)
        };
        let choices: Vec<f64> = HALVES.iter().filter_map(|share| meets(*share)).collect();
        if choices.is_empty() { Err(flat()) } else { Ok(Estimate::of(&choices)) }
    };
    let (cold, hot) = (flank(true)?, flank(false)?);
    let (start_c, finish_c) = if branch.stretch == Stretch::Heating { (cold, hot) } else { (hot, cold) };
    let area = branch
        .between(cold.value - width, hot.value + width)
        .windows(2)
        .map(|pair| {
            let over = |(t, y): (f64, f64)| y - base.y(t);
            0.5 * (over(pair[0]) + over(pair[1])) * (pair[1].0 - pair[0].0)
        })
        .sum();
    let second_c = second(&smooth, top, &base, height);
    Ok(Peak { start_c, peak_c, finish_c, area, second_c })
}

/// The line of most points: laid through all, and again through those that are nearest to it.
fn most(points: &[(f64, f64)]) -> Option<Line> {
    let mut line = Line::through(points.iter().copied())?;
    let mut nearest = points.to_vec();
    for _ in 0..TRIMS {
        nearest.sort_by(|a, b| (a.1 - line.y(a.0)).abs().total_cmp(&(b.1 - line.y(b.0)).abs()));
        line = Line::through(nearest[..(MOST * points.len() as f64) as usize].iter().copied())?;
    }
    Some(line)
}

/// The highest other peak of the same sign, with a valley before it.
fn second(smooth: &[(f64, f64)], top: usize, base: &Line, height: f64) -> Option<f64> {
    let over = |i: usize| (smooth[i].1 - base.y(smooth[i].0)) / height;
    let mut found: Option<(f64, f64)> = None;
    for outward in [(0..top).rev().collect::<Vec<_>>(), (top + 1..smooth.len()).collect()] {
        let mut valley = 1.0_f64;
        for i in outward {
            valley = valley.min(over(i));
            if over(i) > SECOND && valley < VALLEY * over(i) && found.is_none_or(|(best, _)| over(i) > best) {
                found = Some((over(i), smooth[i].0));
            }
        }
    }
    found.map(|(_, t)| t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heat flow of logistic transformations at centre and steepness, on a sloping base line; cooling gives heat off.
    fn curve(a: f64, m: f64, k: f64, r_phase: f64) -> (Vec<f64>, Vec<f64>) {
        let peak = move |x: f64| 0.25 * k / (0.5 * k * x).cosh().powi(2);
        let up = (0..=1200).map(|i| -20.0 + 0.15 * f64::from(i));
        let base = |t: f64| 0.01 + 2e-5 * t;
        let heats = up.clone().map(move |t| (t, base(t) + 5.0 * peak(t - a)));
        let cools = up.rev().map(move |t| (t, -base(t) - 5.0 * (peak(t - m) + r_phase * peak(t - m - 30.0))));
        heats.chain(cools).unzip()
    }

    #[test]
    fn temperatures_and_area_of_logistic_peaks_are_those_of_closed_form() {
        let (t, q) = curve(93.0, 67.0, 0.4, 0.0);
        let found = calorimetry(&t, &q).expect("two peaks");
        let half = 0.5 * LOGISTIC_SPAN / 0.4;
        for (found, expected) in [
            (found.heating.start_c.value, 93.0 - half),
            (found.heating.finish_c.value, 93.0 + half),
            (found.cooling.start_c.value, 67.0 + half),
            (found.cooling.finish_c.value, 67.0 - half),
            (found.heating.peak_c, 93.0),
            (found.cooling.peak_c, 67.0),
        ] {
            assert!((found - expected).abs() < 0.4, "{found}, not {expected}");
        }
        assert!((found.heating.area - 5.0).abs() < 0.05 && (found.cooling.area + 5.0).abs() < 0.05, "{found:?}");
        assert_eq!((found.heating.second_c, found.cooling.second_c), (None, None));
    }

    #[test]
    fn an_r_phase_is_seen_beside_the_larger_peak() {
        let (t, q) = curve(93.0, 40.0, 0.5, 0.3);
        let second = calorimetry(&t, &q).expect("two peaks").cooling.second_c.expect("a second one");
        assert!((second - 70.0).abs() < 1.0, "{second}");
    }

    #[test]
    fn the_span_is_that_of_the_closed_form() {
        let place = 2.0 * (1.0 / 3f64.sqrt()).atanh() + 3f64.sqrt();
        assert!((LOGISTIC_SPAN - 2.0 * place).abs() < 1e-3, "{}", 2.0 * place);
    }

    #[test]
    fn a_sweep_that_ends_in_the_peak_is_refused_with_where_to_go() {
        let (t, q) = curve(93.0, 67.0, 0.4, 0.0);
        let kept: Vec<(f64, f64)> = t.iter().zip(&q).filter(|(t, _)| **t < 100.0).map(|(t, q)| (*t, *q)).collect();
        let (t, q): (Vec<f64>, Vec<f64>) = kept.into_iter().unzip();
        let error = calorimetry(&t, &q).expect_err("no base line");
        assert!(error.to_string().contains("above 1"), "{error}");
    }
}
