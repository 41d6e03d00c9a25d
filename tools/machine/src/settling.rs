//! Whether a wire has settled: successive cycles of heating under one load, compared by where their ends are and at which heat half of the
//! way is done.

use sinew_physics::WireModel;
use sinew_physics::formulas::{cooling_time_s, relaxed};

/// How near successive cycles have to be to be the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Of the strain, hot and cold.
    pub strain: f64,
    /// Of the temperatures at which half of the way is done, both ways, K.
    pub kelvin: f64,
}

/// So many cycles in a row have to agree with the one before each.
pub const IN_A_ROW: usize = 3;

/// What a cycle was like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleEnds {
    /// Strain of the cold wire, which is the longest.
    pub cold: f64,
    /// Of the hot one.
    pub hot: f64,
    /// Temperature above the air at which half of the way is done while it is heated ever more, as reckoned from the power, K: without the
    /// heat of the transformation, which is the same in every cycle.
    pub up_k: f64,
    /// The same while it is heated ever less.
    pub down_k: f64,
}

impl CycleEnds {
    /// Of a cycle's samples, elongation in m and temperature above the air in K, from cold to hot to cold, of a wire of this length in m. `None`
    /// where it does not move.
    pub fn of(samples: &[(f64, f64)], length_m: f64) -> Option<CycleEnds> {
        let extreme = |best: fn(f64, f64) -> f64| samples.iter().map(|(m, _)| *m).reduce(best);
        let (cold_m, hot_m) = (extreme(f64::max)?, extreme(f64::min)?);
        let half_m = 0.5 * (cold_m + hot_m);
        let hottest = samples.iter().position(|(m, _)| *m == hot_m)?;
        let crossed = |pairs: &[(f64, f64)]| {
            let pair = pairs.windows(2).find(|pair| (pair[0].0 - half_m) * (pair[1].0 - half_m) <= 0.0)?;
            let ((from_m, from_k), (to_m, to_k)) = (pair[0], pair[1]);
            let share = if to_m == from_m { 0.5 } else { (half_m - from_m) / (to_m - from_m) };
            Some(from_k + share * (to_k - from_k))
        };
        let (up, down) = samples.split_at(hottest);
        Some(CycleEnds { cold: cold_m / length_m, hot: hot_m / length_m, up_k: crossed(up)?, down_k: crossed(down)? })
    }

    /// Whether it is the same as another one.
    pub fn agrees(&self, other: &CycleEnds, tolerance: &Tolerance) -> bool {
        (self.cold - other.cold).abs() <= tolerance.strain
            && (self.hot - other.hot).abs() <= tolerance.strain
            && (self.up_k - other.up_k).abs() <= tolerance.kelvin
            && (self.down_k - other.down_k).abs() <= tolerance.kelvin
    }
}

/// How many cycles it took until each was like the one before, if [`IN_A_ROW`] were.
pub fn settled_after(cycles: &[CycleEnds], tolerance: &Tolerance) -> Option<usize> {
    let agree: Vec<bool> = cycles.windows(2).map(|pair| pair[1].agrees(&pair[0], tolerance)).collect();
    agree.windows(IN_A_ROW).position(|row| row.iter().all(|agrees| *agrees)).map(|before| before + 1)
}

/// Cycles as they come, period by period.
#[derive(Debug, Clone)]
pub struct Settling {
    tolerance: Tolerance,
    length_m: f64,
    loss_w_per_k: f64,
    /// Of a period, in thermal time constants.
    period: f64,
    /// Temperature above the air, as reckoned from the power, K.
    above_k: f64,
    samples: Vec<(f64, f64)>,
    cycles: Vec<CycleEnds>,
}

impl Settling {
    /// Of a wire that is believed to be like `model`, at so many periods a second.
    pub fn new(tolerance: Tolerance, model: &WireModel, rate_hz: f64) -> Settling {
        let loss_w_per_k = model.constant_loss_w_per_k().max(1e-12);
        Settling {
            tolerance,
            length_m: model.geometry.length_m,
            loss_w_per_k,
            period: 1.0 / (rate_hz * cooling_time_s(model.heat_capacity_j_per_k(), loss_w_per_k)),
            above_k: 0.0,
            samples: Vec::new(),
            cycles: Vec::new(),
        }
    }

    /// A period of the present cycle: elongation at its end, m, and the power in it, W.
    pub fn see(&mut self, elongation_m: f64, power_w: f64) {
        self.above_k = relaxed(self.above_k, power_w / self.loss_w_per_k, self.period);
        self.samples.push((elongation_m, self.above_k));
    }

    /// The present cycle is over; whether the wire has settled.
    pub fn ends_cycle(&mut self) -> bool {
        let ends = CycleEnds::of(&self.samples, self.length_m);
        self.samples.clear();
        match ends {
            Some(ends) => self.cycles.push(ends),
            // a cycle without a way is like no other
            None => self.cycles.clear(),
        }
        self.settled_after().is_some()
    }

    /// The cycles so far, since the wire last did not move.
    pub fn cycles(&self) -> &[CycleEnds] {
        &self.cycles
    }

    /// How many cycles it took, if it has settled.
    pub fn settled_after(&self) -> Option<usize> {
        settled_after(&self.cycles, &self.tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cycle whose half is crossed at these temperatures.
    fn samples(cold_m: f64, hot_m: f64, up_k: f64, down_k: f64) -> Vec<(f64, f64)> {
        let ramp = |centre_k: f64, k: f64| 0.5 + 0.5 * ((k - centre_k) / 5.0).tanh();
        let at = |centre_k: f64, k: f64| (cold_m + (hot_m - cold_m) * ramp(centre_k, k), k);
        let up = (0..=100).map(|k| at(up_k, f64::from(k)));
        let down = (0..=100).rev().map(|k| at(down_k, f64::from(k)));
        up.chain(down).collect()
    }

    #[test]
    fn ends_and_halves_are_where_they_were_made() {
        let ends = CycleEnds::of(&samples(12e-3, 1e-3, 63.0, 41.0), 0.3).unwrap();
        assert!((ends.cold - 0.04).abs() < 1e-6 && (ends.hot - 1e-3 / 0.3).abs() < 1e-6, "{ends:?}");
        assert!((ends.up_k - 63.0).abs() < 0.05 && (ends.down_k - 41.0).abs() < 0.05, "{ends:?}");
        assert_eq!(CycleEnds::of(&[], 0.3), None);
    }

    #[test]
    fn it_has_settled_when_enough_in_a_row_agree() {
        let tolerance = Tolerance { strain: 1e-4, kelvin: 0.2 };
        let at = |cold: f64, up_k: f64| CycleEnds { cold, hot: 0.0, up_k, down_k: 50.0 };
        let moving = [at(0.0400, 60.0), at(0.0403, 60.0), at(0.0405, 59.5), at(0.0405, 59.4)];
        assert_eq!(settled_after(&moving, &tolerance), None);
        let still: Vec<CycleEnds> = moving.into_iter().chain([at(0.04053, 59.4), at(0.04055, 59.3)]).collect();
        assert_eq!(settled_after(&still, &tolerance), Some(3));
        let hotter: Vec<CycleEnds> = moving.into_iter().chain([at(0.04053, 58.0), at(0.04055, 57.9)]).collect();
        assert_eq!(settled_after(&hotter, &tolerance), None, "a temperature moved");
    }
}
