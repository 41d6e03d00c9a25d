//! Axes: the range shown in the prefix that suits it, linear, logarithmic or in steps, with ticks at round numbers.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};

use crate::quantity::{Prefix, fixed, is_sane, number};

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
    pub(crate) low: f64,
    pub(crate) high: f64,
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
    pub(crate) fn place(&self, value: f64) -> Option<f64> {
        is_sane(value).then(|| (value / self.prefix.factor).clamp(self.low, self.high))
    }

    /// How far from the low end to the high end a value is, 0..1.
    pub(crate) fn fraction(&self, value: f64) -> f64 {
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
    pub(crate) fn at(&self, fraction: f64) -> f64 {
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
    pub(crate) fn ticked(&self, most: usize) -> Axis {
        let mut axis = self.clone();
        axis.ticks = match &self.scale {
            Scale::Linear => {
                // three at least, for values to be readable
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

    pub(crate) fn tick(&self, value: f64) -> String {
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

/// Least and largest of the values that are numbers.
pub fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| is_sane(*v)).fold(None, |extent, v| match extent {
        None => Some((v, v)),
        Some((low, high)) => Some((v.min(low), v.max(high))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
