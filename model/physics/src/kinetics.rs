//! The phase: outer transformation curves, and the branch between them that the wire is on.
//!
//! Everything here is a function of the driving temperature ϑ = T − σ/α alone, not of time: between two reversals the
//! martensite fraction is a closed form of ϑ, so a step of any length lands on the same curve.

use crate::params::{Kinetics, Material};
use crate::warp::{Warp, Warped};

/// ln(1/0.01²): the bounded laws put A_s and A_f where the logistic curve has 1 % left, 9.21/k apart (after eq. 20).
const BOUNDED_SPAN: f64 = 9.210_340_371_976_184;

/// The phase mixture. Both parts are carried, so that the small one keeps its resolution far from transformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fraction {
    /// ξ, 0..1.
    pub martensite: f64,
    /// 1 − ξ, 0..1.
    pub austenite: f64,
}

impl Fraction {
    /// The mixture with the given martensite fraction.
    pub fn of_martensite(martensite: f64) -> Self {
        Fraction { martensite, austenite: 1.0 - martensite }
    }

    /// With `change` more martensite, as far as there is any to gain or lose.
    pub(crate) fn moved(&self, change: f64) -> Self {
        let change = change.clamp(-self.martensite, self.austenite);
        Fraction { martensite: self.martensite + change, austenite: self.austenite - change }
    }

    /// Less martensite than `other`, decided on whichever part resolves it.
    fn is_hotter_than(&self, other: &Fraction) -> bool {
        if self.martensite > 0.5 { self.austenite > other.austenite } else { self.martensite < other.martensite }
    }

    /// ξ − `from`.ξ without cancellation.
    pub(crate) fn change_from(&self, from: &Fraction) -> f64 {
        if self.martensite > 0.5 { from.austenite - self.austenite } else { self.martensite - from.martensite }
    }
}

/// A fraction and its slope dξ/dϑ, in 1/K.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    pub(crate) fraction: Fraction,
    pub(crate) slope: f64,
    /// The wire rides on the outer curve here.
    pub(crate) outer: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Law {
    Linear,
    SquareRoot,
    TanakaHeating,
    TanakaCooling,
    LiangRogers,
    Logistic,
    Richards { skew: f64 },
}

/// One outer curve: ξ as a function of ϑ after a complete transformation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curve {
    law: Law,
    centre_c: f64,
    steepness_per_k: f64,
    /// What its shape differs by from the law's.
    warp: Option<Warped>,
}

impl Curve {
    /// Half of what a bounded law's start and finish are apart, as z = k (ϑ − centre).
    pub(crate) const HALF_SPAN: f64 = 0.5 * BOUNDED_SPAN;

    /// ϑ where z = k (ϑ − centre) is this.
    pub(crate) fn theta_at(&self, z: f64) -> f64 {
        self.centre_c + z / self.steepness_per_k
    }

    /// The same as [`Curve::at`], for those who are not in a hurry: a call site less to inline.
    #[inline(never)]
    pub(crate) fn point(&self, theta: f64) -> Point {
        self.at(theta)
    }

    #[inline(always)]
    fn at(&self, theta: f64) -> Point {
        let k = self.steepness_per_k;
        let z = k * (theta - self.centre_c);
        match &self.warp {
            None => self.of_law(z, k),
            Some(warp) => {
                let warped = warp.at(z);
                self.of_law(warped.z, k * warped.slope)
            }
        }
    }

    /// The law at its argument z, which rises by `k` with every kelvin here.
    #[inline(always)]
    fn of_law(&self, z: f64, k: f64) -> Point {
        if self.law == Law::Logistic {
            // eq. 20, from the side that does not overflow
            let e = (-z.abs()).exp();
            let large = 1.0 / (1.0 + e);
            let small = e * large;
            let slope = -k * small * large;
            let fraction = if z > 0.0 {
                Fraction { martensite: small, austenite: large }
            } else {
                Fraction { martensite: large, austenite: small }
            };
            return Point { fraction, slope, outer: true };
        }
        self.at_uncommon(z, k)
    }

    #[cold]
    fn at_uncommon(&self, z: f64, k: f64) -> Point {
        let left = 0.5 - z / BOUNDED_SPAN; // distance to the finish temperature over the span: x^b of eq. 13
        let x = left.clamp(0.0, 1.0);
        let moving = if left > 0.0 && left < 1.0 { -k / BOUNDED_SPAN } else { 0.0 }; // dx/dϑ
        let (martensite, austenite, slope) = match self.law {
            Law::Linear => (x, 1.0 - x, moving), // eq. 15
            Law::SquareRoot => {
                // eq. 16
                let root = x.sqrt();
                (root, (1.0 - x) / (1.0 + root), moving * 0.5 / root.max(1e-6))
            }
            Law::TanakaHeating => {
                // eq. 17, carried on beyond A_f instead of rounded to zero there
                let exponent = (BOUNDED_SPAN * 0.5 * (left - 1.0)).min(0.0);
                let m = exponent.exp();
                (m, -exponent.exp_m1(), if left < 1.0 { -0.5 * k * m } else { 0.0 })
            }
            Law::TanakaCooling => {
                let exponent = (-BOUNDED_SPAN * 0.5 * left).min(0.0);
                let a = exponent.exp();
                (-exponent.exp_m1(), a, if left > 0.0 { -0.5 * k * a } else { 0.0 })
            }
            Law::LiangRogers => {
                // eq. 18: (1 − cos πx)/2 is sin²(πx/2)
                let (s, c) = (std::f64::consts::FRAC_PI_2 * x).sin_cos();
                (s * s, c * c, moving * std::f64::consts::PI * s * c)
            }
            Law::Richards { skew } => {
                // eq. 21
                let grown = skew * z.min(700.0).exp();
                let exponent = -grown.ln_1p() / skew;
                let m = exponent.exp();
                (m, -exponent.exp_m1(), -k * m * grown / (skew * (1.0 + grown)))
            }
            Law::Logistic => unreachable!("handled by the caller"),
        };
        Point { fraction: Fraction { martensite, austenite }, slope, outer: true }
    }
}

/// The two outer curves and how strongly the wire is drawn to them.
#[derive(Debug, Clone, Copy)]
pub struct Hysteresis {
    heating: Curve,
    cooling: Curve,
    /// 1 − w: how much of the implicit inner loop's motion is left inside the outer curves.
    inner_share: f64,
    /// The tails may cross when the curves differ in more than their centre.
    tails_cross: bool,
    /// How far stress has moved the cooling curve besides ϑ, in K; see [`crate::effects::UnequalSlopes`].
    cooling_shift: f64,
    /// It may move again.
    cooling_moves: bool,
}

/// Which way ϑ moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// dϑ/dt > 0: towards austenite (eq. 12).
    Heating,
    /// dϑ/dt < 0: towards martensite.
    Cooling,
}

/// The inner curve since the last reversal: ξ_M g_A on heating, 1 − η_A (1 − g_M) on cooling, with g taken at a
/// temperature that runs (1 − w) times as fast as ϑ. That is the closed form of the weighted rate law, for any kinetics.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Branch {
    direction: Direction,
    /// ϑ of the reversal, as the curve sees it.
    reversal_theta: f64,
    /// ξ_M or η_A.
    scale: f64,
    /// 1 − scale.
    rest: f64,
}

impl Hysteresis {
    /// The curves of `material`; ϑ is counted at zero stress.
    pub fn new(material: &Material) -> Self {
        let (heating, cooling) = match material.kinetics {
            Kinetics::Linear => (Law::Linear, Law::Linear),
            Kinetics::SquareRoot => (Law::SquareRoot, Law::SquareRoot),
            Kinetics::Tanaka => (Law::TanakaHeating, Law::TanakaCooling),
            Kinetics::LiangRogers => (Law::LiangRogers, Law::LiangRogers),
            Kinetics::Logistic => (Law::Logistic, Law::Logistic),
            Kinetics::Richards { heating_skew, cooling_skew } => {
                (Law::Richards { skew: heating_skew }, Law::Richards { skew: cooling_skew })
            }
        };
        Hysteresis {
            heating: Curve {
                law: heating,
                centre_c: material.austenite_temperature_c,
                steepness_per_k: material.heating_steepness_per_k,
                warp: None,
            },
            cooling: Curve {
                law: cooling,
                centre_c: material.martensite_temperature_c,
                steepness_per_k: material.cooling_steepness_per_k,
                warp: None,
            },
            inner_share: 1.0 - material.outer_loop_weight,
            tails_cross: heating != cooling
                || material.heating_steepness_per_k != material.cooling_steepness_per_k
                || material.austenite_temperature_c < material.martensite_temperature_c
                || !matches!(material.kinetics, Kinetics::Logistic),
            cooling_shift: 0.0,
            cooling_moves: false,
        }
    }

    /// Gives the heating and the cooling curve shapes of their own.
    pub(crate) fn shape(&mut self, heating: Warp, cooling: Warp) {
        self.heating.warp = heating.ready();
        self.cooling.warp = cooling.ready();
        self.tails_cross |= self.heating.warp != self.cooling.warp;
    }

    /// The outer curve that a way in `direction` ends on.
    pub(crate) fn curve(&self, direction: Direction) -> &Curve {
        match direction {
            Direction::Heating => &self.heating,
            Direction::Cooling => &self.cooling,
        }
    }

    /// 1 − w.
    pub(crate) fn inner_share(&self) -> f64 {
        self.inner_share
    }

    /// Moves the cooling curve to `shift` K above where the material has it.
    pub(crate) fn move_cooling_curve(&mut self, shift: f64) {
        self.cooling_shift = shift;
        self.cooling_moves = true;
        self.tails_cross = true;
    }

    /// g_A: the most martensite there can be at ϑ (°C).
    pub fn upper(&self, theta: f64) -> Fraction {
        self.heating.at(theta).fraction
    }

    /// g_M: the least martensite there can be at ϑ (°C). Where the tails of unequal curves cross, g_A bounds it:
    /// the loop has no negative width.
    pub fn lower(&self, theta: f64) -> Fraction {
        self.lower_point(theta).fraction
    }

    fn lower_point(&self, theta: f64) -> Point {
        if self.tails_cross {
            return self.lower_beside(&self.heating.at(theta), theta);
        }
        self.cooling.at(theta - self.cooling_shift)
    }

    /// The same where the tails may cross, beside the heating curve at ϑ.
    #[inline(always)]
    fn lower_beside(&self, heating: &Point, theta: f64) -> Point {
        let cooling = self.cooling.at(theta - self.cooling_shift);
        if heating.fraction.is_hotter_than(&cooling.fraction) { *heating } else { cooling }
    }

    /// `fraction` clipped into the outer curves at ϑ.
    pub fn clip(&self, fraction: Fraction, theta: f64) -> Fraction {
        let (upper, lower) = (self.upper(theta), self.lower(theta));
        if fraction.is_hotter_than(&lower) {
            lower
        } else if upper.is_hotter_than(&fraction) {
            upper
        } else {
            fraction
        }
    }

    /// `fraction` held at ϑ between the outer curves moved apart by `half_width` K each way: a play. Where they are moved so far
    /// together that they cross, the heating curve leads.
    pub(crate) fn play(&self, half_width: f64, fraction: Fraction, theta: f64) -> Point {
        let held = Point { fraction, slope: 0.0, outer: false };
        let lower = self.lower_point(theta + half_width);
        let risen = if fraction.is_hotter_than(&lower.fraction) { lower } else { held };
        let upper = self.heating.at(theta - half_width);
        if upper.fraction.is_hotter_than(&risen.fraction) { upper } else { risen }
    }

    /// The same on the way in `direction` from where `fraction` was held already: the curve behind only falls away.
    pub(crate) fn play_on(&self, direction: Direction, half_width: f64, fraction: Fraction, theta: f64) -> Point {
        if self.cooling_moves {
            return self.play(half_width, fraction, theta);
        }
        let held = Point { fraction, slope: 0.0, outer: false };
        match direction {
            Direction::Heating => {
                let upper = self.heating.at(theta - half_width);
                if upper.fraction.is_hotter_than(&fraction) { upper } else { held }
            }
            Direction::Cooling => {
                let lower = self.cooling.at(theta + half_width);
                if !fraction.is_hotter_than(&lower.fraction) {
                    held
                } else if self.tails_cross || half_width < 0.0 {
                    self.play(half_width, fraction, theta)
                } else {
                    lower
                }
            }
        }
    }

    /// The branch that leaves (ϑ, ξ) in `direction`: history variables of eq. 26, so that ξ is continuous.
    pub(crate) fn reverse(&self, direction: Direction, theta: f64, at: &Fraction) -> Branch {
        let reversal_theta = self.seen(direction, theta);
        let (scale, rest) = match direction {
            Direction::Heating => {
                let g = self.heating.at(reversal_theta).fraction;
                if g.martensite > 0.0 {
                    let scale = at.martensite / g.martensite;
                    (scale.min(1.0), (-at.change_from(&g) / g.martensite).max(0.0))
                } else {
                    (1.0, 0.0)
                }
            }
            Direction::Cooling => {
                let g = self.cooling.at(reversal_theta).fraction;
                if g.austenite > 0.0 {
                    // above 1 only where the tails cross; there g_A holds ξ, see `on_branch`
                    ((at.austenite / g.austenite).min(1.0), (at.change_from(&g) / g.austenite).max(0.0))
                } else {
                    (1.0, 0.0)
                }
            }
        };
        Branch { direction, reversal_theta, scale, rest }
    }

    /// ϑ as the curve of this direction sees it.
    #[inline(always)]
    fn seen(&self, direction: Direction, theta: f64) -> f64 {
        match direction {
            Direction::Heating => theta,
            Direction::Cooling => theta - self.cooling_shift,
        }
    }

    /// The mixture and its slope at ϑ on `branch`: the inner curve, or the outer one once that has been met. Where tails of
    /// unequal curves cross, the far curve holds an inner branch that would leave the loop there.
    pub(crate) fn on_branch(&self, branch: &Branch, theta: f64) -> Point {
        match branch.direction {
            Direction::Heating => {
                let upper = self.heating.at(theta);
                if branch.rest == 0.0 {
                    // on the outer curve already (ξ_M = 1): it is below the slower inner curve from here on
                    return upper;
                }
                let inner = self.inner(branch, theta);
                if upper.fraction.is_hotter_than(&inner.fraction) {
                    return upper;
                }
                if !self.tails_cross {
                    return inner;
                }
                let lower = self.lower_beside(&upper, theta);
                if inner.fraction.is_hotter_than(&lower.fraction) { lower.held() } else { inner }
            }
            Direction::Cooling => {
                let upper = self.tails_cross.then(|| self.heating.at(theta));
                let lower = match &upper {
                    Some(upper) => self.lower_beside(upper, theta),
                    None => self.lower_point(theta),
                };
                if branch.rest == 0.0 {
                    return lower;
                }
                let inner = self.inner(branch, theta);
                if inner.fraction.is_hotter_than(&lower.fraction) {
                    return lower;
                }
                match upper {
                    Some(upper) if upper.fraction.is_hotter_than(&inner.fraction) => upper.held(),
                    _ => inner,
                }
            }
        }
    }

    /// The inner curve of `branch`, whatever the outer ones say.
    #[inline(always)]
    fn inner(&self, branch: &Branch, theta: f64) -> Point {
        let since = self.seen(branch.direction, theta) - branch.reversal_theta;
        let slowed = branch.reversal_theta + self.inner_share * since;
        let Branch { scale, rest, .. } = *branch;
        let (g, fraction) = match branch.direction {
            Direction::Heating => {
                let g = self.heating.at(slowed);
                let Fraction { martensite, austenite } = g.fraction;
                (g, Fraction { martensite: scale * martensite, austenite: rest + scale * austenite })
            }
            Direction::Cooling => {
                let g = self.cooling.at(slowed);
                let Fraction { martensite, austenite } = g.fraction;
                (g, Fraction { martensite: rest + scale * martensite, austenite: scale * austenite })
            }
        };
        Point { fraction, slope: self.inner_share * scale * g.slope, outer: false }
    }
}

impl Point {
    /// Held by the far curve, not met by the near one: the inner branch goes on.
    fn held(self) -> Point {
        Point { outer: false, ..self }
    }
}

impl Branch {
    /// From where the wire rides on the outer curve, ξ_M (η_A) is 1: the inner curve no longer matters.
    pub(crate) fn ride_outer(&mut self) {
        self.scale = 1.0;
        self.rest = 0.0;
    }

    pub(crate) fn direction(&self) -> Direction {
        self.direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formulas::logistic;
    use crate::warp::Side;
    use proptest::prelude::*;

    fn laws() -> [Kinetics; 6] {
        [
            Kinetics::Linear,
            Kinetics::SquareRoot,
            Kinetics::Tanaka,
            Kinetics::LiangRogers,
            Kinetics::Logistic,
            Kinetics::Richards { heating_skew: 2.0, cooling_skew: 0.5 },
        ]
    }

    #[test]
    fn parts_always_add_to_one_and_slopes_match_differences() {
        for kinetics in laws() {
            let h = Hysteresis::new(&Material { kinetics, ..Material::default() });
            for i in 0..2000 {
                let theta = 20.0 + 0.06 * f64::from(i);
                for curve in [h.heating, h.cooling] {
                    let p = curve.at(theta);
                    assert!((p.fraction.martensite + p.fraction.austenite - 1.0).abs() < 1e-12, "{kinetics:?} {theta}");
                    let d = 1e-5;
                    let (above, below) = (curve.at(theta + d).fraction, curve.at(theta - d).fraction);
                    let measured = above.change_from(&below) / (2.0 * d);
                    let kink = matches!(kinetics, Kinetics::Linear | Kinetics::SquareRoot | Kinetics::Tanaka);
                    if !kink {
                        assert!((measured - p.slope).abs() < 1e-6, "{kinetics:?} {theta}: {measured} {}", p.slope);
                    }
                }
            }
        }
    }

    #[test]
    fn a_shaped_curve_keeps_its_centre_and_its_slope_is_the_derivative() {
        for kinetics in [Kinetics::Logistic, Kinetics::LiangRogers] {
            let material = Material { kinetics, ..Material::default() };
            let (plain, mut shaped) = (Hysteresis::new(&material), Hysteresis::new(&material));
            let hot_tail = Warp { hot: Side { tail: -1.0, ..Side::default() }, ..Warp::default() };
            let cold_shoulder = Warp { cold: Side { shoulder: 0.5, ..Side::default() }, ..Warp::default() };
            shaped.shape(hot_tail, cold_shoulder);
            let centre = material.austenite_temperature_c;
            assert!((shaped.upper(centre).martensite - plain.upper(centre).martensite).abs() < 1e-12);
            // a flatter hot tail leaves more martensite in the heat
            let hot = centre + 3.0 / material.heating_steepness_per_k;
            assert!(shaped.upper(hot).martensite > plain.upper(hot).martensite + 1e-3, "{kinetics:?}");
            for i in 0..2000 {
                let theta = 20.0 + 0.06 * f64::from(i);
                for curve in [shaped.heating, shaped.cooling] {
                    let d = 1e-5;
                    let (above, below) = (curve.at(theta + d).fraction, curve.at(theta - d).fraction);
                    let (measured, slope) = (above.change_from(&below) / (2.0 * d), curve.at(theta).slope);
                    assert!((measured - slope).abs() < 1e-5, "{kinetics:?} {theta}: {measured} {slope}");
                }
            }
        }
    }

    #[test]
    fn richards_with_unit_skew_is_logistic() {
        let logistic = Hysteresis::new(&Material::default());
        let richards = Hysteresis::new(&Material {
            kinetics: Kinetics::Richards { heating_skew: 1.0, cooling_skew: 1.0 },
            ..Material::default()
        });
        for i in 0..200 {
            let theta = 10.0 + f64::from(i);
            assert!((logistic.upper(theta).martensite - richards.upper(theta).martensite).abs() < 1e-14);
        }
    }

    /// The curve that keeps the small phase's digits is the one formula of eq. 20.
    #[test]
    fn logistic_curves_are_the_formula() {
        let (m, h) = (Material::default(), Hysteresis::new(&Material::default()));
        for i in 0..200 {
            let theta = f64::from(i);
            let (upper, lower) = (
                logistic(theta, m.austenite_temperature_c, 1.0 / m.heating_steepness_per_k),
                logistic(theta, m.martensite_temperature_c, 1.0 / m.cooling_steepness_per_k),
            );
            assert!((h.upper(theta).martensite - upper).abs() < 1e-14, "{theta}");
            assert!((h.lower(theta).martensite - lower).abs() < 1e-14, "{theta}");
        }
    }

    #[test]
    fn austenite_keeps_its_resolution_in_the_cold() {
        let h = Hysteresis::new(&Material::default());
        let cold = h.upper(-100.0).austenite;
        let expected = (0.31f64 * (-100.0 - 93.0)).exp();
        assert!((cold / expected - 1.0).abs() < 1e-9, "{cold} {expected}");
    }

    /// The closed form against the rate law of the design, integrated in small steps by Runge–Kutta.
    #[test]
    fn inner_branch_solves_the_weighted_rate_equation() {
        for weight in [0.0, 0.3, 0.8, 1.0] {
            let m = Material { outer_loop_weight: weight, ..Material::default() };
            let h = Hysteresis::new(&m);
            let start = Fraction::of_martensite(0.45);
            let theta0 = 78.0;
            let start = h.clip(start, theta0);
            let branch = h.reverse(Direction::Heating, theta0, &start);
            let xi_m = start.martensite / h.upper(theta0).martensite;
            let rate = |xi: f64| (1.0 - weight) * m.heating_steepness_per_k * (xi * xi / xi_m - xi);
            let (mut xi, n) = (start.martensite, 20_000);
            let step = 30.0 / f64::from(n);
            for i in 0..n {
                let theta = theta0 + step * f64::from(i + 1);
                let k1 = rate(xi);
                let k2 = rate(xi + 0.5 * step * k1);
                let k3 = rate(xi + 0.5 * step * k2);
                let k4 = rate(xi + step * k3);
                xi += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                xi = xi.min(h.upper(theta).martensite);
                let closed = h.on_branch(&branch, theta).fraction.martensite;
                assert!((closed - xi).abs() < 1e-5, "w {weight} ϑ {theta}: {closed} {xi}");
            }
        }
    }

    proptest! {
        #[test]
        fn any_path_stays_between_the_outer_curves_and_is_continuous(
            law in 0usize..6,
            weight in 0.0f64..=1.0,
            k_a in 0.05f64..1.0,
            k_m in 0.05f64..1.0,
            width in 0.0f64..60.0,
            shape in prop::option::of(prop::array::uniform12(-1.5f64..1.5)),
            path in prop::collection::vec(0.0f64..160.0, 1..40),
        ) {
            let material = Material {
                kinetics: laws()[law],
                outer_loop_weight: weight,
                heating_steepness_per_k: k_a,
                cooling_steepness_per_k: k_m,
                martensite_temperature_c: 93.0 - width,
                ..Material::default()
            };
            let mut h = Hysteresis::new(&material);
            if let Some(s) = shape {
                let side = |s: &[f64]| Side { knee: s[0], shoulder: s[1], tail: s[2] };
                let warp = |s: &[f64]| Warp { cold: side(&s[..3]), hot: side(&s[3..]) };
                h.shape(warp(&s[..6]), warp(&s[6..]));
            }
            let mut theta = 25.0;
            let mut at = h.clip(Fraction::of_martensite(1.0), theta);
            for target in path {
                let direction = if target > theta { Direction::Heating } else { Direction::Cooling };
                let branch = h.reverse(direction, theta, &at);
                let there = h.on_branch(&branch, theta).fraction;
                prop_assert!((there.martensite - at.martensite).abs() < 1e-9, "jump {} to {}", at.martensite, there.martensite);
                let next = h.on_branch(&branch, target).fraction;
                prop_assert!(next.martensite.is_finite() && next.austenite >= 0.0 && next.martensite >= 0.0);
                prop_assert!(next.martensite <= h.upper(target).martensite + 1e-12);
                prop_assert!(next.martensite >= h.lower(target).martensite - 1e-12);
                let change = next.martensite - at.martensite;
                let towards = if direction == Direction::Heating { -change } else { change };
                prop_assert!(towards >= -1e-12, "moved against its direction by {}", towards);
                theta = target;
                at = next;
            }
        }
    }
}
