//! The rival criteria of transformation (eq. 8–11): when the phase moves, and along which curve.
//!
//! Eq. 12 needs nothing of this: its direction is that of ϑ, and its curves have no ends. The rivals hold the phase still wherever they
//! are not met, so that ϑ may move past a curve without it. Where they are met again the curve sets out from the phase there is, by
//! eq. 26 taken at its word: what holds for eq. 12 inside its loop (ξ_M and η_A up to 1) goes on beyond it here, and nothing jumps.

use crate::kinetics::{Curve, Direction, Fraction, Hysteresis, Point};
use crate::params::Criterion;

/// Nothing moves below this, in K: the rounding of a temperature that is held.
const STILL_K: f64 = 1e-10;
/// The same of stress, in Pa: 1/α makes 10⁻¹⁰ K of it.
const STILL_PA: f64 = 1e-3;

/// Where temperature, stress and ϑ would go in a piece if the phase stood still: what drives it, and not what it makes of that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Drift {
    /// K.
    pub(crate) temperature: f64,
    /// Pa.
    pub(crate) stress: f64,
    /// K.
    pub(crate) theta: f64,
}

impl Criterion {
    /// The way the phase moves, or `None` where it stands still. What the criterion asks for has to be where ϑ goes as well: on the way
    /// back nobody's curve is followed.
    pub(crate) fn admits(self, drift: &Drift) -> Option<Direction> {
        let way = |moved: f64, still: f64| match moved {
            m if m > still => Some(Direction::Heating),
            m if m < -still => Some(Direction::Cooling),
            _ => None,
        };
        let of_theta = way(drift.theta, STILL_K)?;
        let asked = match self {
            Criterion::Tanaka | Criterion::Brinson => way(-drift.stress, STILL_PA)?,
            Criterion::LiangRogers => way(drift.temperature, STILL_K)?,
            Criterion::ElahiniaAhmadian | Criterion::DrivingTemperature => of_theta,
        };
        (asked == of_theta).then_some(of_theta)
    }

    /// Between which z = k (ϑ − centre) the phase moves on the way in `direction`.
    fn bounds(self, direction: Direction) -> (f64, f64) {
        let half = Curve::HALF_SPAN;
        match (self, direction) {
            (Criterion::DrivingTemperature, _) => (f64::NEG_INFINITY, f64::INFINITY),
            // a start and no finish
            (Criterion::Tanaka, Direction::Heating) => (-half, f64::INFINITY),
            (Criterion::Tanaka, Direction::Cooling) => (f64::NEG_INFINITY, half),
            (Criterion::LiangRogers | Criterion::Brinson | Criterion::ElahiniaAhmadian, _) => (-half, half),
        }
    }
}

/// The curve that a rival criterion follows from where it was met.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Path {
    direction: Direction,
    /// The least and the largest ϑ at which the phase moves, °C as the curve sees it.
    bounds: (f64, f64),
    /// ϑ where it set out, within those.
    origin: f64,
    /// The part that grows less and less, ξ heating and 1 − ξ cooling, over its curve there: ξ_M or η_A of eq. 26.
    scale: f64,
    /// The phase where it set out.
    from: Fraction,
    /// How fast the curve is gone through: the implicit loop's share inside the outer loop, all of it beyond that.
    share: f64,
}

impl Path {
    /// The way in `direction` from (ϑ, ξ).
    pub(crate) fn new(
        criterion: Criterion,
        hysteresis: &Hysteresis,
        direction: Direction,
        theta: f64,
        at: &Fraction,
    ) -> Path {
        let curve = hysteresis.curve(direction);
        let (low, high) = criterion.bounds(direction);
        let bounds = (curve.theta_at(low), curve.theta_at(high));
        let origin = theta.clamp(bounds.0, bounds.1);
        let scale = leaving(direction, at) / leaving(direction, &curve.point(origin).fraction);
        let share = if scale < 1.0 { hysteresis.inner_share() } else { 1.0 };
        Path { direction, bounds, origin, scale, from: *at, share }
    }

    pub(crate) fn direction(&self) -> Direction {
        self.direction
    }

    /// The mixture and its slope at ϑ.
    #[inline(never)]
    pub(crate) fn at(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        let held = Point { fraction: self.from, slope: 0.0, outer: false };
        let curve = hysteresis.curve(self.direction);
        let bounded = theta.clamp(self.bounds.0, self.bounds.1);
        // the end of a bounded curve has nothing left to go by
        if bounded == self.origin || !self.scale.is_finite() {
            return held;
        }
        let moves = bounded == theta;
        let inner = curve.point(self.origin + self.share * (bounded - self.origin));
        let left = self.scale * leaving(self.direction, &inner.fraction);
        let outer = curve.point(bounded);
        // inside the loop the outer curve is met in the end; beyond it, it never is
        let met = self.scale <= 1.0 && leaving(self.direction, &outer.fraction) < left;
        let (left, slope) = if met {
            (leaving(self.direction, &outer.fraction), outer.slope)
        } else {
            (left, self.share * self.scale * inner.slope)
        };
        let fraction = match self.direction {
            Direction::Heating => Fraction { martensite: left, austenite: 1.0 - left },
            Direction::Cooling => Fraction { martensite: 1.0 - left, austenite: left },
        };
        Point { fraction, slope: if moves { slope } else { 0.0 }, outer: false }
    }
}

/// The phase that a transformation in `direction` uses up.
fn leaving(direction: Direction, fraction: &Fraction) -> f64 {
    match direction {
        Direction::Heating => fraction.martensite,
        Direction::Cooling => fraction.austenite,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Kinetics, Material};
    use proptest::prelude::*;

    const RIVALS: [Criterion; 4] =
        [Criterion::Tanaka, Criterion::LiangRogers, Criterion::Brinson, Criterion::ElahiniaAhmadian];

    const LAWS: [Kinetics; 5] =
        [Kinetics::Linear, Kinetics::SquareRoot, Kinetics::Tanaka, Kinetics::LiangRogers, Kinetics::Logistic];

    /// The table of eq. 8–12: who moves the phase by temperature alone, who by stress alone.
    #[test]
    fn each_criterion_asks_its_own_quantity() {
        let warmer = Drift { temperature: 1.0, stress: 0.0, theta: 1.0 };
        let tighter = Drift { temperature: 0.0, stress: 8e6, theta: -1.0 };
        let both = Drift { temperature: 2.0, stress: 8e6, theta: 1.0 };
        for (criterion, by_heat, by_stress, by_both) in [
            (Criterion::Tanaka, None, Some(Direction::Cooling), None),
            (Criterion::LiangRogers, Some(Direction::Heating), None, Some(Direction::Heating)),
            (Criterion::Brinson, None, Some(Direction::Cooling), None),
            (Criterion::ElahiniaAhmadian, Some(Direction::Heating), Some(Direction::Cooling), Some(Direction::Heating)),
            (
                Criterion::DrivingTemperature,
                Some(Direction::Heating),
                Some(Direction::Cooling),
                Some(Direction::Heating),
            ),
        ] {
            assert_eq!(criterion.admits(&warmer), by_heat, "{criterion:?}");
            assert_eq!(criterion.admits(&tighter), by_stress, "{criterion:?}");
            assert_eq!(criterion.admits(&both), by_both, "{criterion:?}");
        }
    }

    /// Within its loop and unbounded, a path is the branch that eq. 12 follows.
    #[test]
    fn without_bounds_a_path_is_the_branch() {
        for weight in [0.0, 0.8, 1.0] {
            let h = Hysteresis::new(&Material { outer_loop_weight: weight, ..Material::default() });
            for (direction, to) in [(Direction::Heating, 30.0), (Direction::Cooling, -30.0)] {
                let (theta, at) = (80.0, Fraction::of_martensite(0.45));
                let branch = h.reverse(direction, theta, &at);
                let path = Path::new(Criterion::DrivingTemperature, &h, direction, theta, &at);
                for i in 1..=300 {
                    let there = theta + to * f64::from(i) / 300.0;
                    let (a, b) = (h.on_branch(&branch, there), path.at(&h, there));
                    assert!((a.fraction.martensite - b.fraction.martensite).abs() < 1e-12, "w {weight} {there}");
                    assert!((a.slope - b.slope).abs() < 1e-12, "w {weight} {there}: {} {}", a.slope, b.slope);
                }
            }
        }
    }

    proptest! {
        /// From anywhere, also from where no loop has been, in any way: it starts where it is and only goes on.
        #[test]
        fn a_path_starts_where_it_is_and_never_turns_back(
            which in 0usize..4, law in 0usize..5, weight in 0.0f64..=1.0,
            theta in -40.0f64..220.0, martensite in 0.0f64..=1.0, heats in any::<bool>(),
        ) {
            let kinetics = LAWS[law];
            let h = Hysteresis::new(&Material { kinetics, outer_loop_weight: weight, ..Material::default() });
            let direction = if heats { Direction::Heating } else { Direction::Cooling };
            let at = Fraction::of_martensite(martensite);
            let path = Path::new(RIVALS[which], &h, direction, theta, &at);
            let forward = if heats { 1.0 } else { -1.0 };
            let mut before = leaving(direction, &at);
            for i in 0..4000 {
                let p = path.at(&h, theta + forward * 0.05 * f64::from(i));
                let now = leaving(direction, &p.fraction);
                prop_assert!((-1e-12..=1.0 + 1e-12).contains(&now) && p.slope.is_finite(), "{now} {}", p.slope);
                prop_assert!(now <= before + 1e-12, "turned back from {before} to {now}");
                if i == 0 {
                    prop_assert!((now - before).abs() < 1e-12, "jumps from {before} to {now}");
                }
                before = now;
            }
        }
    }
}
