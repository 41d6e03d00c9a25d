//! Detects a stuck tap: does the wire still slide through its taps?
//!
//! A tap that sticks to the wire keeps its share of the voltage whatever the wire does: the dual measurement freezes at a
//! plausible length, and nothing in a sample is wrong. With the first tap at the fixed end the voltages have no redundancy
//! to detect it, and the total resistance does not show it either: a wire that is heated inside its hysteresis, one that
//! transforms and one that is jammed all change it alike. The heat balance detects it: a wire that has been heated above
//! any temperature at which it could still be long must have shortened, one that has cooled below any at which it could
//! still be short must have lengthened. If the length has stood still all that time, to within its noise, it is not the
//! wire's length (or the load is jammed, which is as good a reason to stop heating).
//!
//! The temperature is known by two bounds only, from the measured power: the least and the most it can be with the heat
//! capacity, the loss to the air and the power as far off as [`SlideConfig`] allows. A wire that shortens takes up heat of
//! transformation, so then the lower bound restarts at ambient; one that lengthens releases it, and
//! the upper bound restarts at the highest temperature allowed. So the verdict is late, but correct for every
//! wire within those bounds.

use crate::error::{Error, check, check_ordered};
use crate::reading::Reading;

/// How far the filtered length must move to count as moved, in its standard deviations.
const MOVED: f64 = 8.0;
/// Time constant of that filter, s. A length that is missing for longer starts the watch anew.
const FILTER_S: f64 = 0.05;
/// Periods in a row that the evidence has to stand.
const PERIODS: u32 = 2;
/// Within this share of the stroke from its end the length has nowhere to go.
const AT_END: f64 = 0.15;

/// Between which values something lies, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// It is no less than this.
    pub least: f64,
    /// It is no more than this.
    pub most: f64,
}

/// What a [`SlideWatch`] has to know of the wire. Every "most" and "least" is with the errors allowed for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlideConfig {
    /// Length contracted, in m.
    pub hot_length_m: f64,
    /// Length stretched, in m.
    pub cold_length_m: f64,
    /// Above this temperature no martensite is left, in °C.
    pub surely_short_c: f64,
    /// Below this temperature no austenite is left, in °C.
    pub surely_long_c: f64,
    /// Ambient, in °C.
    pub ambient_c: f64,
    /// No wire is allowed to be hotter, in °C.
    pub hottest_c: f64,
    /// Least and most heat capacity, in J/K.
    pub heat_capacity_j_per_k: Bounds,
    /// Least and most loss to the air, in W/K.
    pub loss_w_per_k: Bounds,
    /// Relative error of the measured power.
    pub power_error: f64,
}

impl SlideConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first number that cannot be used, by name.
    pub fn validate(&self) -> Result<(), Error> {
        check_ordered("stroke in m", self.hot_length_m, self.cold_length_m)?;
        check_ordered("temperatures of the hysteresis in °C", self.surely_long_c, self.surely_short_c)?;
        check("ambient in °C", self.ambient_c, -273.15, 1e4)?;
        check("hottest in °C", self.hottest_c, self.ambient_c, 1e4)?;
        for (name, Bounds { least, most }) in
            [("heat capacity in J/K", self.heat_capacity_j_per_k), ("loss in W/K", self.loss_w_per_k)]
        {
            check(name, least, 1e-12, 1e12)?;
            check(name, most, least, 1e12)?;
        }
        check("error of the power", self.power_error, 0.0, 0.9)
    }
}

/// How one bound of the temperature relaxes in a period: [`relaxed`](sinew_physics::formulas::relaxed) with its exponentials
/// taken beforehand.
#[derive(Debug, Clone, Copy)]
struct Relaxation {
    /// Where a watt brings it in the end, K/W: 1 over the loss.
    k_per_w: f64,
    /// What is left after a period of a distance from rest, with the least and with the most heat capacity.
    kept_by_least: f64,
    kept_by_most: f64,
}

impl Relaxation {
    fn of(loss_w_per_k: f64, heat_capacity_j_per_k: Bounds, dt_s: f64) -> Relaxation {
        let kept = |capacity: f64| (-dt_s * loss_w_per_k / capacity).exp();
        Relaxation {
            k_per_w: 1.0 / loss_w_per_k,
            kept_by_least: kept(heat_capacity_j_per_k.least),
            kept_by_most: kept(heat_capacity_j_per_k.most),
        }
    }
}

/// What a period's length makes of the configuration; as good as always the same.
#[derive(Debug, Clone, Copy)]
struct Pace {
    dt_s: f64,
    /// Of the filter on the length.
    gain: f64,
    /// Of the coldest bound, with the most loss, and of the hottest, with the least.
    coldest: Relaxation,
    hottest: Relaxation,
}

impl Pace {
    fn of(c: &SlideConfig, dt_s: f64) -> Pace {
        Pace {
            dt_s,
            gain: dt_s / (FILTER_S + dt_s),
            coldest: Relaxation::of(c.loss_w_per_k.most, c.heat_capacity_j_per_k, dt_s),
            hottest: Relaxation::of(c.loss_w_per_k.least, c.heat_capacity_j_per_k, dt_s),
        }
    }
}

/// Watches one channel's taps.
#[derive(Debug, Clone, Copy)]
pub struct SlideWatch {
    config: SlideConfig,
    pace: Pace,
    /// Bounds of the temperature, °C.
    coldest_c: f64,
    hottest_c: f64,
    /// Filtered length.
    length_m: f64,
    /// Longest since the least temperature began anew, shortest since the most did.
    longest_m: f64,
    shortest_m: f64,
    /// Variance of the filter's output as a share of a sample's.
    share: f64,
    missing_s: f64,
    against: u32,
}

impl SlideWatch {
    /// A watch that knows nothing yet.
    ///
    /// # Errors
    /// As [`SlideConfig::validate`].
    pub fn new(config: SlideConfig) -> Result<SlideWatch, Error> {
        config.validate()?;
        let mut watch = SlideWatch {
            config,
            pace: Pace::of(&config, 1e-3),
            coldest_c: 0.0,
            hottest_c: 0.0,
            length_m: f64::NAN,
            longest_m: f64::NAN,
            shortest_m: f64::NAN,
            share: 1.0,
            missing_s: 0.0,
            against: 0,
        };
        watch.reset();
        Ok(watch)
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        (self.length_m, self.longest_m, self.shortest_m) = (f64::NAN, f64::NAN, f64::NAN);
        (self.coldest_c, self.hottest_c) = (self.config.ambient_c, self.config.hottest_c);
        (self.share, self.missing_s, self.against) = (1.0, 0.0, 0);
    }

    /// Takes one reading and the mean power since the last, in W; true once the length cannot be the wire's.
    /// Whatever is not a number starts the watch anew.
    #[inline]
    pub fn sticks(&mut self, reading: &Reading, power_w: f64, dt_s: f64) -> bool {
        if !(power_w.is_finite() && dt_s > 0.0 && dt_s < 1.0) {
            self.reset();
            return false;
        }
        self.warm_and_cool(power_w.max(0.0), dt_s);
        let Some(length_m) = reading.length() else {
            self.missing_s += dt_s;
            if self.missing_s > FILTER_S {
                self.reset();
            }
            return false;
        };
        self.missing_s = 0.0;
        if self.length_m.is_nan() {
            (self.length_m, self.longest_m, self.shortest_m) = (length_m, length_m, length_m);
        }
        let gain = self.pace.gain;
        self.length_m += gain * (length_m - self.length_m);
        self.share = (1.0 - gain) * (1.0 - gain) * self.share + gain * gain;
        // What it is compared with was such a mean too.
        let noise_m = MOVED * reading.length_sigma_m * (2.0 * self.share).sqrt();
        let c = &self.config;
        self.longest_m = self.longest_m.max(self.length_m);
        self.shortest_m = self.shortest_m.min(self.length_m);
        if self.longest_m - self.length_m > noise_m {
            (self.longest_m, self.coldest_c) = (self.length_m, c.ambient_c);
        }
        if self.length_m - self.shortest_m > noise_m {
            (self.shortest_m, self.hottest_c) = (self.length_m, c.hottest_c);
        }
        let margin_m = AT_END * (c.cold_length_m - c.hot_length_m);
        let too_long = self.length_m > c.hot_length_m + margin_m && self.coldest_c > c.surely_short_c;
        let too_short = self.length_m < c.cold_length_m - margin_m && self.hottest_c < c.surely_long_c;
        self.against = if too_long || too_short { self.against.saturating_add(1) } else { 0 };
        self.against >= PERIODS
    }

    /// Both bounds over one period of this power.
    #[inline]
    fn warm_and_cool(&mut self, power_w: f64, dt_s: f64) {
        if dt_s != self.pace.dt_s {
            self.pace = Pace::of(&self.config, dt_s);
        }
        let (c, pace) = (&self.config, &self.pace);
        // Exact for a constant power: no step of any length overshoots.
        let (weak, strong) = (power_w * (1.0 - c.power_error), power_w * (1.0 + c.power_error));
        let (cold_rest_c, hot_rest_c) =
            (c.ambient_c + weak * pace.coldest.k_per_w, c.ambient_c + strong * pace.hottest.k_per_w);
        let (cold_off_k, hot_off_k) = (self.coldest_c - cold_rest_c, self.hottest_c - hot_rest_c);
        // The heat capacity that leaves the least, or the most, of it.
        let Relaxation { kept_by_least, kept_by_most, .. } = pace.coldest;
        self.coldest_c = cold_rest_c + (cold_off_k * kept_by_least).min(cold_off_k * kept_by_most);
        let Relaxation { kept_by_least, kept_by_most, .. } = pace.hottest;
        self.hottest_c = hot_rest_c + (hot_off_k * kept_by_least).max(hot_off_k * kept_by_most);
    }

    /// Bounds of the wire's temperature as far as the heat tells, in °C.
    pub fn temperature_bounds_c(&self) -> (f64, f64) {
        (self.coldest_c, self.hottest_c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::health::Health;
    use proptest::prelude::*;
    use sinew_physics::formulas::relaxed;

    fn config() -> SlideConfig {
        SlideConfig {
            hot_length_m: 0.1603,
            cold_length_m: 0.1667,
            surely_short_c: 140.0,
            surely_long_c: 64.0,
            ambient_c: 25.0,
            hottest_c: 170.0,
            heat_capacity_j_per_k: Bounds { least: 0.009, most: 0.012 },
            loss_w_per_k: Bounds { least: 0.004, most: 0.011 },
            power_error: 0.05,
        }
    }

    fn reading(length_m: f64) -> Reading {
        Reading {
            length_m,
            resistance_ohm: 11.0,
            resistivity_ohm_m: 8e-7,
            health: Health::Ok,
            length_sigma_m: 60e-6,
            resistance_sigma_ohm: 0.01,
        }
    }

    /// Seconds until the verdict at a constant power and length.
    fn seconds(length_m: f64, power_w: f64) -> Option<f64> {
        let mut watch = SlideWatch::new(config()).unwrap();
        (1..60_000).find(|_| watch.sticks(&reading(length_m), power_w, 1e-3)).map(|n| f64::from(n) * 1e-3)
    }

    #[test]
    fn the_verdict_comes_when_the_bound_passes_and_not_before() {
        // Closed form of the least temperature: rest + (ambient − rest) e^(−t loss/capacity) = 140.
        let rest: f64 = 0.95 * 3.0 / 0.011;
        let expected = 0.012 / 0.011 * (rest / (rest - 115.0)).ln();
        let found = seconds(0.165, 3.0).unwrap();
        assert!((found - expected - 1e-3).abs() < 2e-3, "{found} {expected}");
        // And of the most: from 170 down to 64 with nothing but the sensing pulse.
        let rest: f64 = 1.05 * 0.06 / 0.004;
        let expected = 0.012 / 0.004 * ((145.0 - rest) / (39.0 - rest)).ln();
        let found = seconds(0.162, 0.06).unwrap();
        assert!((found - expected - 1e-3).abs() < 2e-3, "{found} {expected}");
    }

    #[test]
    fn where_the_wire_may_stand_still_there_is_no_verdict() {
        // At its ends, and at a power that any air might take away.
        assert_eq!(seconds(0.1604, 3.0), None, "already short");
        assert_eq!(seconds(0.1666, 0.06), None, "already long");
        assert_eq!(seconds(0.165, 1.0), None, "held");
    }

    #[test]
    fn a_length_that_moves_or_is_lost_starts_anew() {
        let mut watch = SlideWatch::new(config()).unwrap();
        for i in 0..20_000 {
            // A slow drift of 0.3 mm a second.
            assert!(!watch.sticks(&reading(0.1662 - 3e-7 * f64::from(i)), 3.0, 1e-3), "{i}");
        }
        for i in 0..20_000 {
            let lost = if i % 500 < 55 { Reading::none(Health::ProbeLost) } else { reading(0.165) };
            assert!(!watch.sticks(&lost, 3.0, 1e-3), "{i}");
        }
    }

    #[test]
    fn neither_single_bad_samples_nor_the_wrong_direction_keep_the_verdict_back() {
        let first = |step_m: f64| {
            let mut watch = SlideWatch::new(config()).unwrap();
            (0..5000).find(|i| {
                let flapping =
                    if i % 3 == 0 { Reading::none(Health::ProbeLost) } else { reading(0.163 + step_m * f64::from(*i)) };
                watch.sticks(&flapping, 3.0, 1e-3)
            })
        };
        // A tap that sticks while the other one slides makes the length seem to grow while the wire is heated.
        assert!(first(0.0).is_some() && first(1e-6).is_some());
        assert_eq!(first(-1e-6), None, "this one shortens");
    }

    #[test]
    fn configurations_that_cannot_work_are_refused() {
        for bad in [
            SlideConfig { cold_length_m: 0.16, ..config() },
            SlideConfig { surely_long_c: 150.0, ..config() },
            SlideConfig { loss_w_per_k: Bounds { least: 0.0, most: 1.0 }, ..config() },
            SlideConfig { power_error: f64::NAN, ..config() },
        ] {
            assert!(SlideWatch::new(bad).is_err(), "{bad:?}");
        }
    }

    proptest! {
        #[test]
        fn the_bounds_hold_every_wire_within_them(
            capacity in 0.009..0.012f64, loss in 0.004..0.011f64, error in -0.05..0.05f64, start in 25.0..170.0f64,
            powers in prop::collection::vec(0.0..3.0f64, 1..60), dt in 1e-3..0.05f64,
        ) {
            let mut watch = SlideWatch::new(config()).unwrap();
            let mut true_c = start;
            for power in powers {
                watch.sticks(&reading(0.163), power, dt);
                let rest = 25.0 + power * (1.0 + error) / loss;
                true_c = relaxed(true_c, rest, dt * loss / capacity);
                let (low, high) = watch.temperature_bounds_c();
                prop_assert!(low <= true_c + 1e-9 && true_c <= high + 1e-9, "{low} {true_c} {high}");
            }
        }

        #[test]
        fn nothing_it_is_given_breaks_it(
            inputs in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>()), 1..50),
        ) {
            let mut watch = SlideWatch::new(config()).unwrap();
            for (length, power, dt) in inputs {
                watch.sticks(&reading(length), power, dt);
            }
            watch.reset();
            prop_assert!(!watch.sticks(&reading(0.163), 0.1, 1e-3));
        }
    }
}
