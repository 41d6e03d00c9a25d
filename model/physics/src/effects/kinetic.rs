//! Terms of the phase (eq. 20–26).

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, switch};
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

/// `kinetic.curves`: the outer curves g(z) become g(w(z)), with a smooth rising w of its own for each.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CurveShapes {
    /// w of the heating curve.
    pub heating: Warp,
    /// w of the cooling curve.
    pub cooling: Warp,
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

/// One grain: how much hotter than the mean it transforms, the share it stands for, its phase and branch.
#[derive(Debug, Clone, Copy)]
struct Grain {
    offset: f64,
    share: f64,
    fraction: Fraction,
    branch: Option<Branch>,
}

/// The grains of a wire, all at one ϑ.
#[derive(Debug, Clone)]
pub(crate) struct Grains([Grain; GRAINS]);

impl Distributed {
    /// The grains, all with the phase `fraction` clipped into their own curves at ϑ.
    pub(crate) fn grains(&self, hysteresis: &Hysteresis, fraction: Fraction, theta: f64) -> Option<Grains> {
        (self.spread_k > 0.0).then(|| {
            Grains(NODES.map(|(at, share)| {
                let offset = at * self.spread_k;
                Grain { offset, share, fraction: hysteresis.clip(fraction, theta - offset), branch: None }
            }))
        })
    }
}

impl Grains {
    /// The mixture of all grains.
    fn mean(&self, point: impl Fn(&Grain) -> Point) -> Point {
        let mut mean = Point { fraction: Fraction { martensite: 0.0, austenite: 0.0 }, slope: 0.0, outer: false };
        for grain in &self.0 {
            let one = point(grain);
            mean.fraction.martensite += grain.share * one.fraction.martensite;
            mean.fraction.austenite += grain.share * one.fraction.austenite;
            mean.slope += grain.share * one.slope;
        }
        mean
    }

    /// The mixture and its slope at ϑ, each grain on its branch; one that has none stands still.
    pub(crate) fn at(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        self.mean(|grain| match &grain.branch {
            Some(branch) => hysteresis.on_branch(branch, theta - grain.offset),
            None => grain.standing(hysteresis, theta),
        })
    }

    /// The mixture if ϑ stands still, held between curves that may have moved.
    pub(crate) fn standing(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        self.mean(|grain| grain.standing(hysteresis, theta))
    }

    /// Sets out from ϑ in `direction`.
    pub(crate) fn reverse(&mut self, hysteresis: &Hysteresis, direction: Direction, theta: f64) {
        for grain in &mut self.0 {
            grain.branch = Some(hysteresis.reverse(direction, theta - grain.offset, &grain.fraction));
        }
    }

    /// Moves to ϑ along the branches.
    pub(crate) fn arrive(&mut self, hysteresis: &Hysteresis, theta: f64) {
        for grain in &mut self.0 {
            let Some(branch) = &mut grain.branch else { continue };
            let point = hysteresis.on_branch(branch, theta - grain.offset);
            if point.outer {
                branch.ride_outer();
            }
            grain.fraction = point.fraction;
        }
    }

    /// Stays at ϑ.
    pub(crate) fn stay(&mut self, hysteresis: &Hysteresis, theta: f64) {
        for grain in &mut self.0 {
            grain.fraction = grain.standing(hysteresis, theta).fraction;
        }
    }

    /// Least and most martensite there can be at ϑ.
    pub(crate) fn bounds(&self, hysteresis: &Hysteresis, theta: f64) -> (Fraction, Fraction) {
        let still = |fraction| Point { fraction, slope: 0.0, outer: false };
        let lower = self.mean(|grain| still(hysteresis.lower(theta - grain.offset)));
        let upper = self.mean(|grain| still(hysteresis.upper(theta - grain.offset)));
        (lower.fraction, upper.fraction)
    }
}

impl Grain {
    fn standing(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        Point { fraction: hysteresis.clip(self.fraction, theta - self.offset), slope: 0.0, outer: false }
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

/// `kinetic.training_drift`: A and M move by this with every full cycle, a travel of ξ by 2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrainingDrift {
    /// Shift per cycle, in K.
    pub kelvin_per_cycle: f64,
}

impl TrainingDrift {
    /// How far A and M have moved after ξ has travelled ∫|dξ|, in K.
    fn shift(&self, travel: f64) -> f64 {
        self.kelvin_per_cycle * 0.5 * travel
    }
}

impl Kinetic {
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
            term: "g(z) → g(w(z)), w(0) = 0, ln w' linear between nodes at z = k (ϑ − centre) = ±4, ±2, 0",
            says: "The transformation curves follow no closed form",
            parameters: &[
                switch!(
                    0.0,
                    "heating_cold_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.cold_tail,
                    "ln of the factor on the heating curve's steepness at z = -4"
                ),
                switch!(
                    0.0,
                    "heating_cold_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.cold_shoulder,
                    "ln of the factor on the heating curve's steepness at z = -2"
                ),
                switch!(
                    0.0,
                    "heating_hot_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.hot_shoulder,
                    "ln of the factor on the heating curve's steepness at z = 2"
                ),
                switch!(
                    0.0,
                    "heating_hot_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.heating.hot_tail,
                    "ln of the factor on the heating curve's steepness at z = 4"
                ),
                switch!(
                    0.0,
                    "cooling_cold_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.cold_tail,
                    "ln of the factor on the cooling curve's steepness at z = -4"
                ),
                switch!(
                    0.0,
                    "cooling_cold_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.cold_shoulder,
                    "ln of the factor on the cooling curve's steepness at z = -2"
                ),
                switch!(
                    0.0,
                    "cooling_hot_shoulder",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.hot_shoulder,
                    "ln of the factor on the cooling curve's steepness at z = 2"
                ),
                switch!(
                    0.0,
                    "cooling_hot_tail",
                    "1",
                    (-3.0, 3.0),
                    (-1.0, 1.0),
                    1.0,
                    curves.cooling.hot_tail,
                    "ln of the factor on the cooling curve's steepness at z = 4"
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
            term: "A, M → A, M + drift ∫|dξ|/2",
            says: "Every cycle moves the transformation temperatures a little",
            parameters: &[switch!(
                0.0,
                "kelvin_per_cycle",
                "K",
                (-50.0, 50.0),
                (-1.0, 1.0),
                1.0,
                training_drift.kelvin_per_cycle,
                "shift of A and M per full cycle"
            )],
        },
    ];
}
