//! Terms of the phase (eq. 20–26).

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, held, shape, switch};
use crate::formulas::settled;
use crate::kinetics::{Branch, Direction, Fraction, Hysteresis, Point};
use crate::params::{Kinetics, Material};
use crate::warp::Warp;

/// Terms of the phase.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Kinetic {
    /// Curves with unequal shoulders.
    pub asymmetry: Asymmetry,
    /// Curves that follow no closed form.
    pub curves: CurveShapes,
    /// Another stress slope on cooling.
    pub unequal_slopes: UnequalSlopes,
    /// Grains that transform at different temperatures.
    pub distributed: Distributed,
    /// A phase that takes its time.
    pub lag: Lag,
    /// Transformation temperatures that move with use.
    pub training_drift: TrainingDrift,
}

/// `kinetic.asymmetry`: the logistic curves become Richards curves with these skews (eq. 21). Where the material's law
/// is Richards' already, its skews are multiplied by these; the other laws have no skew and stay as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asymmetry {
    /// v_A of the heating curve.
    pub heating_skew: f64,
    /// v_M of the cooling curve.
    pub cooling_skew: f64,
}

impl Default for Asymmetry {
    fn default() -> Self {
        Asymmetry { heating_skew: 1.0, cooling_skew: 1.0 }
    }
}

/// `kinetic.curves`: the outer curves g(z) become g(w(z)), with a smooth rising w of its own for each, and inside them a part
/// of the wire moves as hysterons do.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurveShapes {
    /// w of the heating curve.
    pub heating: Warp,
    /// w of the cooling curve.
    pub cooling: Warp,
    /// What is inside them.
    pub hysterons: Hysterons,
}

/// A Preisach operator of few parameters: plays between the outer curves, which are moved apart or together by a normally
/// distributed half-width. Each holds its phase until it meets a curve, so a return to an extreme wipes out what was inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hysterons {
    /// Share of the wire, 0 to 1; the rest is on the branches of eq. 26.
    pub share: f64,
    /// Standard deviation of the half-widths beside that of the outer curves, in K.
    pub spread_k: f64,
}

impl Default for Hysterons {
    fn default() -> Self {
        Hysterons { share: 0.0, spread_k: 3.0 }
    }
}

/// `kinetic.unequal_slopes`: on cooling the curve's centre is M + extra · σ, besides 1/α which moves both.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UnequalSlopes {
    /// Extra shift of M with stress, in K/Pa.
    pub cooling_extra_k_per_pa: f64,
}

/// `kinetic.distributed`: grains whose A and M are together spread normally; each has its own branch.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distributed {
    /// Standard deviation of the grains' temperatures, in K.
    pub spread_k: f64,
}

/// Grains that stand for the distribution.
const GRAINS: usize = 9;
/// Where they lie, in standard deviations, and the share of the wire each stands for: Gauss and Hermite's nodes.
const NODES: [(f64, f64); GRAINS] = [
    (-4.512_745_863_399_783, 2.234_584_400_774_658_6e-5),
    (-3.205_429_002_856_47, 2.789_141_321_231_769e-3),
    (-2.076_847_978_677_83, 4.991_640_676_521_787e-2),
    (-1.023_255_663_789_133, 0.244_097_502_894_939_2),
    (0.0, 0.406_349_206_349_206_3),
    (1.023_255_663_789_133, 0.244_097_502_894_939_2),
    (2.076_847_978_677_83, 4.991_640_676_521_787e-2),
    (3.205_429_002_856_47, 2.789_141_321_231_769e-3),
    (4.512_745_863_399_783, 2.234_584_400_774_658_6e-5),
];

/// The same for hysterons, which are fewer: ±√(5 ± √10) and 0.
const HYSTERONS: usize = 5;
const HYSTERON_NODES: [(f64, f64); HYSTERONS] = [
    (-2.856_970_013_872_805_6, 1.125_741_132_772_068_8e-2),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_63),
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_63),
    (2.856_970_013_872_805_6, 1.125_741_132_772_068_8e-2),
];

/// One grain: how much hotter than the mean it transforms, the share it stands for, its phase and branch.
#[derive(Debug, Clone, Copy)]
struct Grain {
    offset: f64,
    share: f64,
    fraction: Fraction,
    branch: Option<Branch>,
}

/// One hysteron: its half-width beyond that of the outer curves, K, the share it stands for, and its phase.
#[derive(Debug, Clone, Copy)]
struct Hysteron {
    half_width: f64,
    share: f64,
    fraction: Fraction,
}

/// The parts of a wire whose phases differ, all at one ϑ.
#[derive(Debug, Clone)]
pub(crate) struct Grains {
    /// The first `count` of them.
    grains: [Grain; GRAINS],
    count: usize,
    hysterons: Option<[Hysteron; HYSTERONS]>,
}

impl Kinetic {
    /// The parts, all with the phase `fraction` clipped into their own curves at ϑ; `None` where the wire is all alike.
    pub(crate) fn grains(&self, hysteresis: &Hysteresis, fraction: Fraction, theta: f64) -> Option<Grains> {
        let (spread, hysterons) = (self.distributed.spread_k, &self.curves.hysterons);
        if spread <= 0.0 && hysterons.share <= 0.0 {
            return None;
        }
        let on_branches = 1.0 - hysterons.share;
        let grain = |(at, share): (f64, f64)| {
            let offset = at * spread;
            let fraction = hysteresis.clip(fraction, theta - offset);
            Grain { offset, share: share * on_branches, fraction, branch: None }
        };
        let (grains, count) = match (on_branches > 0.0, spread > 0.0) {
            (false, _) => ([grain((0.0, 0.0)); GRAINS], 0),
            (true, false) => ([grain((0.0, 1.0)); GRAINS], 1),
            (true, true) => (NODES.map(grain), GRAINS),
        };
        let hysteron = |(at, share): (f64, f64)| {
            let half_width = at * hysterons.spread_k;
            let fraction = hysteresis.play(half_width, fraction, theta).fraction;
            Hysteron { half_width, share: share * hysterons.share, fraction }
        };
        Some(Grains { grains, count, hysterons: (hysterons.share > 0.0).then(|| HYSTERON_NODES.map(hysteron)) })
    }
}

impl Grains {
    fn grains(&self) -> &[Grain] {
        &self.grains[..self.count]
    }

    fn hysterons(&self) -> &[Hysteron] {
        self.hysterons.as_ref().map_or(&[], |hysterons| hysterons)
    }

    /// The mixture of all parts.
    fn mean(&self, of_grain: impl Fn(&Grain) -> Point, of_hysteron: impl Fn(&Hysteron) -> Point) -> Point {
        let mut mean = Point { fraction: Fraction { martensite: 0.0, austenite: 0.0 }, slope: 0.0, outer: false };
        let grains = self.grains().iter().map(|grain| (grain.share, of_grain(grain)));
        let hysterons = self.hysterons().iter().map(|hysteron| (hysteron.share, of_hysteron(hysteron)));
        for (share, one) in grains.chain(hysterons) {
            mean.fraction.martensite += share * one.fraction.martensite;
            mean.fraction.austenite += share * one.fraction.austenite;
            mean.slope += share * one.slope;
        }
        mean
    }

    /// The mixture and its slope at ϑ on the way in `direction`, each grain on its branch; one that has none stands still.
    pub(crate) fn at(&self, hysteresis: &Hysteresis, direction: Direction, theta: f64) -> Point {
        self.mean(
            |grain| match &grain.branch {
                Some(branch) => hysteresis.on_branch(branch, theta - grain.offset),
                None => grain.standing(hysteresis, theta),
            },
            |hysteron| hysteresis.play_on(direction, hysteron.half_width, hysteron.fraction, theta),
        )
    }

    /// The mixture if ϑ stands still, held between curves that may have moved.
    pub(crate) fn standing(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        self.mean(|grain| grain.standing(hysteresis, theta), |hysteron| hysteron.standing(hysteresis, theta))
    }

    /// Sets out from ϑ in `direction`.
    pub(crate) fn reverse(&mut self, hysteresis: &Hysteresis, direction: Direction, theta: f64) {
        for grain in &mut self.grains[..self.count] {
            grain.branch = Some(hysteresis.reverse(direction, theta - grain.offset, &grain.fraction));
        }
        // between curves that may have moved since
        for hysteron in self.hysterons.iter_mut().flatten() {
            hysteron.fraction = hysteron.standing(hysteresis, theta).fraction;
        }
    }

    /// Moves to ϑ in `direction`, grains along their branches.
    pub(crate) fn arrive(&mut self, hysteresis: &Hysteresis, direction: Direction, theta: f64) {
        for grain in &mut self.grains[..self.count] {
            let Some(branch) = &mut grain.branch else { continue };
            let point = hysteresis.on_branch(branch, theta - grain.offset);
            if point.outer {
                branch.ride_outer();
            }
            grain.fraction = point.fraction;
        }
        for hysteron in self.hysterons.iter_mut().flatten() {
            hysteron.fraction = hysteresis.play_on(direction, hysteron.half_width, hysteron.fraction, theta).fraction;
        }
    }

    /// Stays at ϑ.
    pub(crate) fn stay(&mut self, hysteresis: &Hysteresis, theta: f64) {
        for grain in &mut self.grains[..self.count] {
            grain.fraction = grain.standing(hysteresis, theta).fraction;
        }
        for hysteron in self.hysterons.iter_mut().flatten() {
            hysteron.fraction = hysteron.standing(hysteresis, theta).fraction;
        }
    }

    /// Least and most martensite there can be at ϑ.
    pub(crate) fn bounds(&self, hysteresis: &Hysteresis, theta: f64) -> (Fraction, Fraction) {
        let still = |fraction| Point { fraction, slope: 0.0, outer: false };
        let (none, all) = (Fraction::of_martensite(0.0), Fraction::of_martensite(1.0));
        let lower = self.mean(
            |grain| still(hysteresis.lower(theta - grain.offset)),
            |hysteron| still(hysteresis.play(hysteron.half_width, none, theta).fraction),
        );
        let upper = self.mean(
            |grain| still(hysteresis.upper(theta - grain.offset)),
            |hysteron| still(hysteresis.play(hysteron.half_width, all, theta).fraction),
        );
        (lower.fraction, upper.fraction)
    }
}

impl Grain {
    fn standing(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        Point { fraction: hysteresis.clip(self.fraction, theta - self.offset), slope: 0.0, outer: false }
    }
}

impl Hysteron {
    fn standing(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        Point { slope: 0.0, ..hysteresis.play(self.half_width, self.fraction, theta) }
    }
}

/// `kinetic.lag`: τ ξ̇ = ξ_eq − ξ, where ξ_eq has the branches and reversals.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lag {
    /// Time constant τ, in s.
    pub seconds: f64,
}

/// What ξ at the end of a piece is mixed of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LagWeights {
    /// ξ_eq at its end.
    pub(crate) end: f64,
    /// ξ_eq at its start.
    pub(crate) start: f64,
    /// ξ at its start.
    pub(crate) now: f64,
}

impl LagWeights {
    /// ξ is ξ_eq.
    pub(crate) const NONE: LagWeights = LagWeights { end: 1.0, start: 0.0, now: 0.0 };
}

impl Lag {
    /// How ξ at the end of a piece of length `h` s is mixed: exact for a ξ_eq that moves in a straight line.
    pub(crate) fn weights(&self, h: f64) -> LagWeights {
        if self.seconds <= 0.0 {
            return LagWeights::NONE;
        }
        let z = h / self.seconds;
        let left = (-z).exp();
        // (1 − e^{−z})/z
        let mean = if z > 1e-8 { -(-z).exp_m1() / z } else { 1.0 - 0.5 * z };
        LagWeights { end: 1.0 - mean, start: (mean - left).max(0.0), now: left }
    }
}

/// `kinetic.training_drift`: A and M move by this with every full cycle, a travel of ξ by 2, for good or until they have settled
/// ([`settled`]).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrainingDrift {
    /// Shift per cycle, in K; of a wire that settles, in its first one.
    pub kelvin_per_cycle: f64,
    /// Cycles after which a cycle's shift is e^−1 of the first one's; 0 = it never settles.
    pub settles_after_cycles: f64,
}

impl TrainingDrift {
    /// How far A and M have moved after ξ has travelled ∫|dξ|, in K.
    fn shift(&self, travel: f64) -> f64 {
        settled(self.kelvin_per_cycle, self.settles_after_cycles, 0.5 * travel)
    }
}

impl Kinetic {
    /// How many parts of the wire have phases of their own.
    pub(crate) fn parts(&self) -> usize {
        let of = |is_on: bool, count: usize| if is_on { count } else { 0 };
        let hysterons = of(self.curves.hysterons.share > 0.0, HYSTERONS);
        if self.distributed.spread_k > 0.0 { GRAINS + hysterons } else { 1 + hysterons }
    }

    /// The curves of a material, shaped.
    pub(crate) fn curves(&self, material: &Material) -> Hysteresis {
        let mut curves = self.skewed(material);
        curves.shape(self.curves.heating, self.curves.cooling);
        curves
    }

    /// The curves of a material with their skews.
    fn skewed(&self, material: &Material) -> Hysteresis {
        let mut material = *material;
        let skew = &self.asymmetry;
        if (skew.heating_skew, skew.cooling_skew) != (1.0, 1.0) {
            let (heating, cooling) = match material.kinetics {
                Kinetics::Logistic => (1.0, 1.0),
                Kinetics::Richards { heating_skew, cooling_skew } => (heating_skew, cooling_skew),
                _ => return Hysteresis::new(&material),
            };
            material.kinetics = Kinetics::Richards {
                heating_skew: heating * skew.heating_skew,
                cooling_skew: cooling * skew.cooling_skew,
            };
        }
        Hysteresis::new(&material)
    }

    /// How far A and M have moved after ξ has travelled ∫|dξ|, in K.
    pub(crate) fn moved(&self, travel: f64) -> f64 {
        self.training_drift.shift(travel)
    }
}

impl<M: Has<Kinetic>> Group<M> for Kinetic {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "kinetic.asymmetry",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::SkewedCurves,
            term: "g = (1 + v exp(k (ϑ − centre)))^(−1/v) (eq. 21)",
            says: "The transformation begins and ends with unequal shoulders",
            parameters: &[
                switch!(
                    1.0,
                    "heating_skew",
                    "1",
                    (0.05, 20.0),
                    (0.4, 3.0),
                    1.0,
                    asymmetry.heating_skew,
                    "skew v of the heating curve"
                ),
                switch!(
                    1.0,
                    "cooling_skew",
                    "1",
                    (0.05, 20.0),
                    (0.4, 3.0),
                    1.0,
                    asymmetry.cooling_skew,
                    "skew v of the cooling curve"
                ),
            ],
        },
        Effect {
            id: "kinetic.curves",
            equation: Equation::Kinetic,
            nature: Nature::Shape,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "g(z) → g(w(z)), w(0) = 0, ln w' linear between nodes at z = k (ϑ − centre) = ±4, ±2, ±1, 0; ξ of a share is held between g_M(ϑ + d) and g_A(ϑ − d), d normal",
            says: "The transformation curves follow no closed form",
            parameters: &[
                switch!(
                    0.0,
                    "heating_cold_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.cold.tail,
                    "ln of the factor on the heating curve's steepness at z = -4"
                ),
                switch!(
                    0.0,
                    "heating_cold_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.cold.shoulder,
                    "ln of the factor on the heating curve's steepness at z = -2"
                ),
                switch!(
                    0.0,
                    "heating_cold_knee",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.cold.knee,
                    "ln of the factor on the heating curve's steepness at z = -1"
                ),
                switch!(
                    0.0,
                    "heating_hot_knee",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.hot.knee,
                    "ln of the factor on the heating curve's steepness at z = 1"
                ),
                switch!(
                    0.0,
                    "heating_hot_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.hot.shoulder,
                    "ln of the factor on the heating curve's steepness at z = 2"
                ),
                switch!(
                    0.0,
                    "heating_hot_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.hot.tail,
                    "ln of the factor on the heating curve's steepness at z = 4"
                ),
                switch!(
                    0.0,
                    "cooling_cold_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.cold.tail,
                    "ln of the factor on the cooling curve's steepness at z = -4"
                ),
                switch!(
                    0.0,
                    "cooling_cold_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.cold.shoulder,
                    "ln of the factor on the cooling curve's steepness at z = -2"
                ),
                switch!(
                    0.0,
                    "cooling_cold_knee",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.cold.knee,
                    "ln of the factor on the cooling curve's steepness at z = -1"
                ),
                switch!(
                    0.0,
                    "cooling_hot_knee",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.hot.knee,
                    "ln of the factor on the cooling curve's steepness at z = 1"
                ),
                switch!(
                    0.0,
                    "cooling_hot_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.hot.shoulder,
                    "ln of the factor on the cooling curve's steepness at z = 2"
                ),
                switch!(
                    0.0,
                    "cooling_hot_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.hot.tail,
                    "ln of the factor on the cooling curve's steepness at z = 4"
                ),
                switch!(
                    0.0,
                    "hysteron_share",
                    "1",
                    (0.0, 1.0),
                    (0.0, 1.0),
                    1.0,
                    curves.hysterons.share,
                    "share of the wire that moves as hysterons do inside the outer curves"
                ),
                shape!(
                    3.0,
                    "hysteron_spread_k",
                    "K",
                    (0.0, 30.0),
                    (0.0, 6.0),
                    1.0,
                    curves.hysterons.spread_k,
                    "standard deviation of the hysterons' half-widths"
                ),
            ],
        },
        Effect {
            id: "kinetic.unequal_slopes",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "M → M + extra σ",
            says: "Stress moves the transformation on cooling by another slope than on heating",
            parameters: &[switch!(
                0.0,
                "cooling_extra_k_per_mpa",
                "K/MPa",
                (-1.0, 1.0),
                (-0.06, 0.06),
                1e-6,
                unequal_slopes.cooling_extra_k_per_pa,
                "extra shift of M with stress"
            )],
        },
        Effect {
            id: "kinetic.distributed",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ξ = mean of ξ(ϑ − s) over grains, s normal with deviation spread",
            says: "Grains of the wire transform at different temperatures, so the curves have soft tails",
            parameters: &[switch!(
                0.0,
                "spread_k",
                "K",
                (0.0, 100.0),
                (2.0, 12.0),
                1.0,
                distributed.spread_k,
                "standard deviation of the grains' temperatures"
            )],
        },
        Effect {
            id: "kinetic.lag",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "seconds ξ̇ = ξ_eq − ξ",
            says: "The phase follows its equilibrium with a delay of its own",
            parameters: &[switch!(
                0.0,
                "seconds",
                "s",
                (0.0, 100.0),
                (0.03, 0.6),
                1.0,
                lag.seconds,
                "time constant of the phase"
            )],
        },
        Effect {
            id: "kinetic.training_drift",
            equation: Equation::Kinetic,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "A, M → A, M + drift N_0 (1 − exp(−n/N_0)), n = ∫|dξ|/2, N_0 = settles_after_cycles; drift n where that is 0",
            says: "Every cycle moves the transformation temperatures a little, for good or until the wire is broken in",
            parameters: &[
                switch!(
                    0.0,
                    "kelvin_per_cycle",
                    "K",
                    (-50.0, 50.0),
                    (-1.0, 1.0),
                    1.0,
                    training_drift.kelvin_per_cycle,
                    "shift of A and M per full cycle; of a wire that settles, in its first one"
                ),
                held!(
                    0.0,
                    "settles_after_cycles",
                    "1",
                    (0.0, 1e6),
                    (10.0, 50.0),
                    1.0,
                    training_drift.settles_after_cycles,
                    "full cycles after which a cycle's shift is 37 % of the first one's; 0 never settles. A search leaves it as it is"
                ),
            ],
        },
    ];
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn hysterons(share: f64, spread_k: f64) -> Kinetic {
        let curves = CurveShapes { hysterons: Hysterons { share, spread_k }, ..CurveShapes::default() };
        Kinetic { curves, ..Kinetic::default() }
    }

    /// ξ after ϑ has gone from one of `path` to the next.
    fn through(kinetic: &Kinetic, path: &[f64]) -> f64 {
        let curves = kinetic.curves(&Material::default());
        let mut grains = kinetic.grains(&curves, Fraction::of_martensite(1.0), path[0]).expect("parts");
        for leg in path.windows(2) {
            let direction = if leg[1] > leg[0] { Direction::Heating } else { Direction::Cooling };
            grains.reverse(&curves, direction, leg[0]);
            let before = grains.standing(&curves, leg[0]).fraction.martensite;
            let there = grains.at(&curves, direction, leg[0]).fraction.martensite;
            assert!((there - before).abs() < 1e-12, "a jump at {}: {before} {there}", leg[0]);
            grains.arrive(&curves, direction, leg[1]);
        }
        grains.standing(&curves, *path.last().expect("a place")).fraction.martensite
    }

    proptest! {
        /// What makes a Preisach operator (Mayergoyz 1986).
        #[test]
        fn hysterons_forget_what_was_inside_and_their_loops_are_congruent(
            spread in 0.0f64..6.0,
            [low, inner_low, inner_high, high] in prop::array::uniform4(40.0f64..120.0).prop_map(|mut t| {
                t.sort_by(f64::total_cmp);
                t
            }),
            other in 40.0f64..120.0,
        ) {
            let all = hysterons(1.0, spread);
            // an inner loop is wiped out by a return to the extreme around it
            let plain = through(&all, &[20.0, high]);
            let looped = through(&all, &[20.0, high, low, inner_high, inner_low, high]);
            prop_assert!((plain - looped).abs() < 1e-12, "{plain} {looped}");
            // and the change over a loop between the same extremes does not depend on what was before it
            let rise = |before: &[f64]| {
                let to = |end: &[f64]| through(&all, &[before, end].concat());
                to(&[inner_low, inner_high]) - to(&[inner_low, inner_high, inner_low])
            };
            let (from_cold, from_hot) = (rise(&[20.0, inner_high]), rise(&[20.0, high.max(other), inner_low.min(other)]));
            prop_assert!((from_cold - from_hot).abs() < 1e-12, "{from_cold} {from_hot}");
        }

        #[test]
        fn a_wire_of_branches_and_hysterons_is_their_mean(
            share in 0.01f64..0.99,
            path in prop::collection::vec(40.0f64..120.0, 2..12),
        ) {
            let path = [&[20.0], path.as_slice()].concat();
            let none = through(&hysterons(1e-12, 2.0), &path);
            let all = through(&hysterons(1.0, 2.0), &path);
            let mixed = through(&hysterons(share, 2.0), &path);
            prop_assert!((mixed - (1.0 - share) * none - share * all).abs() < 1e-9);
        }
    }
}
