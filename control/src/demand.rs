//! A controller's input and output of each cycle, and the modulation of power that all sliding modes share.

use crate::estimate::Estimate;

/// One cycle's question: which duty for the next PWM period?
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Wire length wanted, in m.
    pub reference_m: f64,
    /// Wire length, in m.
    pub length_m: f64,
    /// Its first derivative, in m/s.
    pub velocity_m_s: f64,
    /// Its second derivative, in m/s².
    pub acceleration_m_s2: f64,
    /// Resistance of the whole wire, in Ω; NaN where none was measured.
    pub resistance_ohm: f64,
    /// Time since the last call, in s.
    pub dt_s: f64,
    /// The state estimator's estimate of this cycle; [`Estimate::UNKNOWN`] where none runs.
    pub estimate: Estimate,
}

impl Demand {
    /// Everything a law of motion needs is a number, and one that does not overflow when squared.
    pub fn is_usable(&self) -> bool {
        let usable = |value: f64| value.abs() < 1e9;
        usable(self.reference_m)
            && usable(self.length_m)
            && usable(self.velocity_m_s)
            && usable(self.acceleration_m_s2)
            && self.dt_s > 0.0
            && usable(self.dt_s)
    }
}

/// A law from length to duty.
pub trait Controller {
    /// The duty for the next period, always between the minimum and the maximum it was made with.
    /// A demand that is not usable, or without the estimate that the law cannot do without, gets the minimum and sets
    /// [`Controller::is_blind`].
    fn duty(&mut self, demand: &Demand) -> f64;

    /// Forgets the past: as newly made.
    fn reset(&mut self);

    /// The sliding surface σ of the last cycle, positive = heat; m/s² for second order, m/s for first, 0 where the law has none.
    fn surface(&self) -> f64;

    /// Whether the last demand held a number that was none, or lacked an estimate that the law cannot do without.
    fn is_blind(&self) -> bool;
}

/// One of the laws from length to duty, as a channel runs it.
pub(crate) trait Law {
    /// The duty for the next period, between the least and the most of its [`Range`]; `None` where the demand is not usable, or
    /// lacks the estimate that this law cannot do without.
    fn duty(&mut self, demand: &Demand) -> Option<f64>;

    /// Forgets the past: as newly made.
    fn reset(&mut self);

    /// The sliding surface of the last cycle, see [`Controller::surface`]; most laws have none.
    fn surface(&self) -> f64 {
        0.0
    }
}

/// When the power is switched between its maximum and its minimum, so that its mean is the one wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Modulation {
    /// Inside the PWM period: on for a share of it. The default.
    Switched,
    /// Once per PWM period: on or off for all of it, the error carried over to the next. For drives that cannot do
    /// better. The ripple makes a held wire creep shorter: its pulses move it along the heating curve, its pauses not back.
    WholePeriods,
}

/// Least and most duty, and the error-feedback switch between them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    pub minimum: f64,
    pub maximum: f64,
    modulation: Modulation,
    /// Duty owed: wanted so far minus given so far.
    owed: f64,
}

impl Range {
    pub fn new(minimum: f64, maximum: f64, modulation: Modulation) -> Range {
        let maximum = if maximum.is_finite() { maximum.clamp(0.0, 1.0) } else { 1.0 };
        let minimum = if minimum.is_finite() { minimum.clamp(0.0, maximum) } else { 0.0 };
        Range { minimum, maximum, modulation, owed: 0.0 }
    }

    /// Of a difference of two duties: as far below nothing as above it.
    pub fn difference(most: f64) -> Range {
        Range { minimum: -most, maximum: most, modulation: Modulation::Switched, owed: 0.0 }
    }

    /// Maximum where σ says heat, minimum elsewhere.
    #[inline]
    pub fn switch(&self, surface: f64) -> f64 {
        if surface > 0.0 { self.maximum } else { self.minimum }
    }

    pub fn reset(&mut self) {
        self.owed = 0.0;
    }

    /// The duty to give where `wanted` is wanted on average.
    #[inline]
    pub fn give(&mut self, wanted: f64) -> f64 {
        // in this order a NaN becomes the minimum
        let wanted = wanted.max(self.minimum).min(self.maximum);
        match self.modulation {
            Modulation::Switched => wanted,
            Modulation::WholePeriods => {
                let owed = self.owed + wanted;
                let given = if owed >= 0.5 * (self.minimum + self.maximum) { self.maximum } else { self.minimum };
                self.owed = owed - given;
                given
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_periods_keep_the_mean() {
        let mut range = Range::new(0.02, 0.9, Modulation::WholePeriods);
        for wanted in [0.02, 0.1, 0.37, 0.9] {
            let mean = (0..10_000).map(|_| range.give(wanted)).sum::<f64>() / 10_000.0;
            assert!((mean - wanted).abs() < 1e-3, "{wanted}: {mean}");
        }
    }

    #[test]
    fn switching_back_owes_nothing_from_saturation() {
        let mut range = Range::new(0.0, 1.0, Modulation::WholePeriods);
        (0..1000).for_each(|_| assert_eq!(range.give(5.0), 1.0));
        let on = (0..10).map(|_| range.give(-5.0)).sum::<f64>();
        assert!(on <= 1.0, "{on}");
    }

    #[test]
    fn a_range_is_a_range_whatever_it_is_made_of() {
        for (minimum, maximum) in [(0.5, 0.1), (f64::NAN, f64::NAN), (-1.0, 7.0)] {
            let mut range = Range::new(minimum, maximum, Modulation::Switched);
            let given = range.give(0.3);
            assert!((0.0..=1.0).contains(&given) && range.minimum <= range.maximum);
        }
    }
}
