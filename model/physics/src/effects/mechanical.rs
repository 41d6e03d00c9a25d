//! Terms of strain, load and friction (eq. 23, 51).

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, held, switch};
use crate::formulas::settled;

/// Terms of strain and load.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mechanical {
    /// Dry friction.
    pub friction: Friction,
    /// Friction in proportion to tension.
    pub capstan: Capstan,
    /// Strain that stays.
    pub ratcheting: Ratcheting,
    /// A frame that gives way.
    pub frame_compliance: FrameCompliance,
    /// Martensite oriented by stress.
    pub stress_dependent_strain: StressDependentStrain,
    /// Shape strain without stress.
    pub two_way: TwoWay,
    /// Expansion of each phase.
    pub phase_expansion: PhaseExpansion,
}

/// `mechanical.friction`: a force of at most this size against the movement of the wire's end (Coulomb): it sticks
/// where less holds it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Friction {
    /// The force, in N.
    pub coulomb_n: f64,
}

/// `mechanical.capstan`: around a pulley or in a sleeve the tension that leads is e^{µθ} times the one that follows
/// (Euler and Eytelwein); it sticks in between.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Capstan {
    /// Coefficient of friction times angle of wrap, µθ.
    pub mu_theta: f64,
}

/// The most that dry friction holds, in N: against getting longer and against getting shorter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Grip {
    pub(crate) against_longer: f64,
    pub(crate) against_shorter: f64,
}

impl Grip {
    /// The friction force on the load where `needed` N hold it still: that, or the most there is.
    pub(crate) fn force(&self, needed: f64) -> f64 {
        needed.max(-self.against_longer).min(self.against_shorter)
    }
}

/// Speed over which the friction that a testing machine measures turns around, in m/s.
const REVERSAL_M_S: f64 = 1e-4;

impl Mechanical {
    /// What friction can hold at a tension of the wire in N. The load pulls e^{µθ} times the wire's tension while it gets
    /// longer, e^{−µθ} times while it gets shorter.
    pub(crate) fn grip(&self, tension: f64) -> Option<Grip> {
        let (coulomb, wrap) = (self.friction.coulomb_n, self.capstan.mu_theta);
        (coulomb > 0.0 || wrap > 0.0).then(|| Grip {
            against_longer: coulomb + tension * wrap.exp_m1(),
            against_shorter: coulomb - tension * (-wrap).exp_m1(),
        })
    }

    /// What a machine that imposes the movement pulls besides the wire's tension, in N, positive with tension.
    pub(crate) fn dragged(&self, tension: f64, velocity: f64) -> f64 {
        let Some(grip) = self.grip(tension) else { return 0.0 };
        let sense = (velocity / REVERSAL_M_S).tanh();
        sense * if sense > 0.0 { grip.against_longer } else { grip.against_shorter }
    }
}

/// `mechanical.ratcheting`: permanent strain gained with every full cycle, a travel of ξ by 2, for good or until it has settled
/// ([`settled`]).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ratcheting {
    /// Strain per cycle; of a wire that settles, in its first one.
    pub strain_per_cycle: f64,
    /// Cycles after which a cycle's strain is e^−1 of the first one's; 0 = it never settles.
    pub settles_after_cycles: f64,
}

impl Ratcheting {
    /// Permanent strain after ξ has travelled ∫|dξ|.
    fn strain(&self, travel: f64) -> f64 {
        settled(self.strain_per_cycle, self.settles_after_cycles, 0.5 * travel)
    }
}

/// `mechanical.frame_compliance`: x = L_0 ε + c A_c σ; the wire's own strain is what resistance and taps see.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameCompliance {
    /// Compliance c of the frame, in m/N.
    pub compliance_m_per_n: f64,
}

/// `mechanical.stress_dependent_strain`: ε_L → ε_L (1 − e^{−σ/scale}); 0 leaves ε_L whole.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StressDependentStrain {
    /// Stress scale, in Pa.
    pub stress_scale_pa: f64,
}

impl StressDependentStrain {
    /// The share of ε_L that a stress in Pa orients, and its slope in 1/Pa.
    pub(crate) fn oriented(&self, stress: f64) -> (f64, f64) {
        if self.stress_scale_pa <= 0.0 {
            return (1.0, 0.0);
        }
        let left = (-stress.max(0.0) / self.stress_scale_pa).exp();
        (1.0 - left, left / self.stress_scale_pa)
    }
}

/// `mechanical.two_way`: shape strain · ξ that needs no stress.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TwoWay {
    /// The strain of full martensite.
    pub strain: f64,
}

/// `mechanical.phase_expansion`: each phase expands by a coefficient of its own. One thermoelastic coefficient θ over the
/// modulus gives the softer martensite the larger expansion, C(ξ) θ (eq. 23), where measured wires have the smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PhaseExpansion {
    /// Of austenite beside θ/E_A, in 1/K.
    pub austenite_extra_per_k: f64,
    /// Of martensite beside θ/E_M, in 1/K.
    pub martensite_extra_per_k: f64,
}

impl PhaseExpansion {
    /// Expansion at a martensite fraction beside C(ξ) θ, in 1/K.
    pub(crate) fn extra_per_k(&self, austenite: f64, martensite: f64) -> f64 {
        self.austenite_extra_per_k * austenite + self.martensite_extra_per_k * martensite
    }
}

impl Mechanical {
    /// Strain that stays after ξ has travelled ∫|dξ|.
    pub(crate) fn permanent(&self, travel: f64) -> f64 {
        self.ratcheting.strain(travel)
    }

    /// Shape strain of full martensite under a stress in Pa, where the material has `transformation_strain`.
    pub(crate) fn shape(&self, transformation_strain: f64, stress: f64) -> f64 {
        let (oriented, _) = self.stress_dependent_strain.oriented(stress);
        transformation_strain * oriented + self.two_way.strain
    }
}

impl<M: Has<Mechanical>> Group<M> for Mechanical {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "mechanical.friction",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "M ẍ + … = … − coulomb sign(ẋ), sticking below it",
            says: "Dry friction holds the wire's end until the pull overcomes it",
            parameters: &[switch!(
                0.0,
                "coulomb_n",
                "N",
                (0.0, 1e4),
                (0.03, 0.3),
                1.0,
                friction.coulomb_n,
                "force of dry friction"
            )],
        },
        Effect {
            id: "mechanical.capstan",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "tension before and behind a pulley differ by up to exp(±mu_theta)",
            says: "Around a pulley or in a sleeve the wire's tension feeds its own friction",
            parameters: &[switch!(
                0.0,
                "mu_theta",
                "1",
                (0.0, 0.6),
                (0.02, 0.25),
                1.0,
                capstan.mu_theta,
                "friction coefficient times angle of wrap"
            )],
        },
        Effect {
            id: "mechanical.ratcheting",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ε → ε + strain_per_cycle N_0 (1 − exp(−n/N_0)), n = ∫|dξ|/2, N_0 = settles_after_cycles; strain_per_cycle n where that is 0",
            says: "Every cycle leaves a little permanent strain, for good or until the wire is broken in",
            parameters: &[
                switch!(
                    0.0,
                    "strain_per_cycle",
                    "1",
                    (-0.02, 0.02),
                    (2e-5, 5e-4),
                    1.0,
                    ratcheting.strain_per_cycle,
                    "permanent strain per full cycle; of a wire that settles, in its first one"
                ),
                held!(
                    0.0,
                    "settles_after_cycles",
                    "1",
                    (0.0, 1e6),
                    (10.0, 50.0),
                    1.0,
                    ratcheting.settles_after_cycles,
                    "full cycles after which a cycle's strain is 37 % of the first one's; 0 never settles. A search leaves it as it is"
                ),
            ],
        },
        Effect {
            id: "mechanical.frame_compliance",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "x = L_0 ε + compliance A_c σ",
            says: "The frame gives way under the wire's tension",
            parameters: &[switch!(
                0.0,
                "compliance_m_per_n",
                "m/N",
                (0.0, 0.1),
                (2e-5, 1e-3),
                1.0,
                frame_compliance.compliance_m_per_n,
                "compliance of the frame"
            )],
        },
        Effect {
            id: "mechanical.stress_dependent_strain",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ε_L → ε_L (1 − exp(−σ/scale))",
            says: "Low stress orients only a part of the martensite",
            parameters: &[switch!(
                0.0,
                "stress_scale_mpa",
                "MPa",
                (0.0, 2000.0),
                (15.0, 150.0),
                1e6,
                stress_dependent_strain.stress_scale_pa,
                "stress that orients all but 37 % of it"
            )],
        },
        Effect {
            id: "mechanical.two_way",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ε → ε + strain ξ",
            says: "The trained wire changes its shape even without stress",
            parameters: &[switch!(
                0.0,
                "strain",
                "1",
                (-0.1, 0.1),
                (0.002, 0.015),
                1.0,
                two_way.strain,
                "strain of full martensite without stress"
            )],
        },
        Effect {
            id: "mechanical.phase_expansion",
            equation: Equation::Mechanical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "strain ((1 − ξ) austenite_extra + ξ martensite_extra) (T − T_0) beside C(ξ) θ (T − T_0)",
            says: "Austenite and martensite expand with temperature each by a coefficient of its own",
            parameters: &[
                switch!(
                    0.0,
                    "austenite_extra_per_k",
                    "1/K",
                    (-1e-3, 1e-3),
                    (-1.2e-5, 1.2e-5),
                    1.0,
                    phase_expansion.austenite_extra_per_k,
                    "expansion of austenite beside θ/E_A"
                ),
                switch!(
                    0.0,
                    "martensite_extra_per_k",
                    "1/K",
                    (-1e-3, 1e-3),
                    (-2.5e-5, 1.2e-5),
                    1.0,
                    phase_expansion.martensite_extra_per_k,
                    "expansion of martensite beside θ/E_M"
                ),
            ],
        },
    ];
}
