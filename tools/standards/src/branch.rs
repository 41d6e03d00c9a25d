//! The stretches of a sweep: heating and cooling, in whichever order they were measured.

use crate::error::Error;

/// Fewest samples of a stretch.
const LEAST_ROWS: usize = 20;
/// A temperature that changes by less, K, was not swept.
const LEAST_SWEEP_K: f64 = 5.0;

/// Which way the temperature went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stretch {
    /// Up.
    Heating,
    /// Down.
    Cooling,
}

impl Stretch {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Stretch::Heating => "heating",
            Stretch::Cooling => "cooling",
        }
    }
}

/// The heating and the cooling of a curve over temperature, °C, whichever was measured first; each in ascending order of temperature.
///
/// # Errors
/// Where it goes one way only, or has hardly any samples.
pub fn stretches(temperature_c: &[f64], y: &[f64]) -> Result<[Vec<(f64, f64)>; 2], Error> {
    let of = |stretch| Branch::of(temperature_c, y, stretch).map(|branch| branch.points);
    Ok([of(Stretch::Heating)?, of(Stretch::Cooling)?])
}

/// A stretch of a curve in the order of its temperature, °C.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Branch {
    pub stretch: Stretch,
    /// In ascending order of temperature.
    pub points: Vec<(f64, f64)>,
    /// In the order of measurement: the first and the last sample's place.
    pub from: usize,
    pub to: usize,
}

impl Branch {
    /// The longest stretch of a curve over temperature in this direction.
    pub(crate) fn of(temperature_c: &[f64], y: &[f64], stretch: Stretch) -> Result<Branch, Error> {
        let rows: Vec<(f64, f64)> = temperature_c
            .iter()
            .copied()
            .zip(y.iter().copied())
            .filter(|(t, y)| t.is_finite() && y.is_finite())
            .collect();
        if rows.len() < LEAST_ROWS || temperature_c.len() != y.len() {
            return Err(Error::Short { found: rows.len().min(y.len()), least: LEAST_ROWS });
        }
        let way = match stretch {
            Stretch::Heating => 1.0,
            Stretch::Cooling => -1.0,
        };
        // the pair of samples, one before the other, that are furthest apart this way
        let (mut least, mut best) = (0, (0, 0, 0.0));
        for (i, (t, _)) in rows.iter().enumerate() {
            if way * (t - rows[least].0) <= 0.0 {
                least = i;
            }
            let rise = way * (t - rows[least].0);
            if rise > best.2 {
                best = (least, i, rise);
            }
        }
        let (from, to, rise) = best;
        if rise < LEAST_SWEEP_K || to + 1 - from < LEAST_ROWS {
            return Err(Error::NoSweep { what: stretch.name(), found_k: rise });
        }
        let mut points = rows[from..=to].to_vec();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Branch { stretch, points, from, to })
    }

    /// From the coldest to the hottest, K.
    pub(crate) fn span_k(&self) -> f64 {
        self.hottest_c() - self.coldest_c()
    }

    pub(crate) fn coldest_c(&self) -> f64 {
        self.points.first().map_or(f64::NAN, |(t, _)| *t)
    }

    pub(crate) fn hottest_c(&self) -> f64 {
        self.points.last().map_or(f64::NAN, |(t, _)| *t)
    }

    /// Those between two temperatures.
    pub(crate) fn between(&self, low_c: f64, high_c: f64) -> &[(f64, f64)] {
        let from = self.points.partition_point(|(t, _)| *t < low_c);
        let to = self.points.partition_point(|(t, _)| *t <= high_c).max(from);
        &self.points[from..to]
    }

    /// A missing base line on the cold or the hot side of a transformation.
    pub(crate) fn no_base_line(&self, is_cold_side: bool, needed_c: f64) -> Error {
        let side = if is_cold_side == (self.stretch == Stretch::Heating) { "before" } else { "after" };
        Error::NoBaseLine { branch: self.stretch.name(), side, needed_c }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_are_found_in_either_order() {
        let up: Vec<f64> = (0..50).map(f64::from).collect();
        let down: Vec<f64> = up.iter().rev().copied().collect();
        for (t, heats_from) in [([up.clone(), down.clone()].concat(), 0), ([down, up].concat(), 50)] {
            let y: Vec<f64> = (0..t.len()).map(|i| i as f64).collect();
            let heating = Branch::of(&t, &y, Stretch::Heating).expect("it is heated");
            let cooling = Branch::of(&t, &y, Stretch::Cooling).expect("it is cooled");
            assert_eq!(heating.from, heats_from);
            assert_eq!(cooling.points.len(), 50);
            assert_eq!(cooling.points[0].0, 0.0);
        }
        let flat = Branch::of(&[20.0; 40], &[0.0; 40], Stretch::Heating);
        assert_eq!(flat, Err(Error::NoSweep { what: "heating", found_k: 0.0 }));
    }
}
