//! Closed forms for what no mechanism explains: each is Σ c_j φ_j, its φ_j from one fixed library of dimensionless
//! functions of the wire's state, its coefficients in the unit of the equation it stands in.

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs};

/// A function of the library. Each is bounded, so that no coefficient can lead to infinity; rates are means over the
/// last 20 ms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Term {
    /// (T − T∞)/60 K.
    Tau,
    /// ((T − T∞)/60 K)².
    Tau2,
    /// ξ.
    Martensite,
    /// ξ (1 − ξ).
    Mixed,
    /// σ/100 MPa.
    Stress,
    /// (σ/100 MPa)².
    Stress2,
    /// x/(ε_L L_0).
    Position,
    /// (x/(ε_L L_0))².
    Position2,
    /// (x/(ε_L L_0))³.
    Position3,
    /// v/(10 mm/s).
    Velocity,
    /// |v| v/(10 mm/s)².
    Drag,
    /// sign(v), smooth over 0.1 mm/s.
    Dry,
    /// P/1 W.
    Power,
    /// duty.
    Duty,
    /// ξ̇/(1/s).
    PhaseRate,
    /// Ṫ/(100 K/s).
    Warming,
    /// x/(ε_L L_0) · (T − T∞)/60 K.
    MovedWarm,
    /// t/100 s.
    Time,
}

impl Term {
    /// How many there are.
    pub const COUNT: usize = 18;
    /// All of them, in order.
    pub const ALL: [Term; Term::COUNT] = [
        Term::Tau,
        Term::Tau2,
        Term::Martensite,
        Term::Mixed,
        Term::Stress,
        Term::Stress2,
        Term::Position,
        Term::Position2,
        Term::Position3,
        Term::Velocity,
        Term::Drag,
        Term::Dry,
        Term::Power,
        Term::Duty,
        Term::PhaseRate,
        Term::Warming,
        Term::MovedWarm,
        Term::Time,
    ];

    /// Its key in the rig file.
    pub const fn name(self) -> &'static str {
        match self {
            Term::Tau => "tau",
            Term::Tau2 => "tau2",
            Term::Martensite => "martensite",
            Term::Mixed => "mixed",
            Term::Stress => "stress",
            Term::Stress2 => "stress2",
            Term::Position => "position",
            Term::Position2 => "position2",
            Term::Position3 => "position3",
            Term::Velocity => "velocity",
            Term::Drag => "drag",
            Term::Dry => "dry",
            Term::Power => "power",
            Term::Duty => "duty",
            Term::PhaseRate => "phase_rate",
            Term::Warming => "warming",
            Term::MovedWarm => "moved_warm",
            Term::Time => "time",
        }
    }

    /// φ as text.
    pub const fn formula(self) -> &'static str {
        match self {
            Term::Tau => "(T − T∞)/60 K",
            Term::Tau2 => "((T − T∞)/60 K)²",
            Term::Martensite => "ξ",
            Term::Mixed => "ξ (1 − ξ)",
            Term::Stress => "σ/100 MPa",
            Term::Stress2 => "(σ/100 MPa)²",
            Term::Position => "x/(ε_L L_0)",
            Term::Position2 => "(x/(ε_L L_0))²",
            Term::Position3 => "(x/(ε_L L_0))³",
            Term::Velocity => "v/(10 mm/s)",
            Term::Drag => "|v| v/(10 mm/s)²",
            Term::Dry => "sign(v), smooth over 0.1 mm/s",
            Term::Power => "P/1 W",
            Term::Duty => "duty",
            Term::PhaseRate => "ξ̇/(1/s)",
            Term::Warming => "Ṫ/(100 K/s)",
            Term::MovedWarm => "x/(ε_L L_0) · (T − T∞)/60 K",
            Term::Time => "t/100 s",
        }
    }
}

/// The coefficients of one closed form, by [`Term`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Form {
    coefficients: [f64; Term::COUNT],
}

impl Form {
    /// The coefficient of `term`.
    pub(crate) fn get(&self, term: Term) -> f64 {
        self.coefficients[term as usize]
    }

    /// Whether any coefficient is not zero.
    pub(crate) fn is_on(&self) -> bool {
        self.coefficients.iter().any(|c| *c != 0.0)
    }

    /// Σ c_j φ_j.
    pub(crate) fn sum(&self, phi: &Features) -> f64 {
        self.coefficients.iter().zip(&phi.0).map(|(c, phi)| c * phi).sum()
    }

    /// Σ c_j φ_j without the terms that the caller solves together with the state.
    pub(crate) fn sum_without(&self, terms: &[Term], phi: &Features) -> f64 {
        let mut rest = *phi;
        for term in terms {
            rest.0[*term as usize] = 0.0;
        }
        self.sum(&rest)
    }
}

/// The library's functions at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Features(pub(crate) [f64; Term::COUNT]);

/// Closed forms fitted to what no mechanism explains.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Empirical {
    /// Heat lost by the wire, W.
    pub thermal: Form,
    /// Relative change of resistivity, dimensionless.
    pub electrical: Form,
    /// Shift of the driving temperature the phase sees, K.
    pub kinetic: Form,
    /// Strain, dimensionless.
    pub mechanical: Form,
    /// Force on the load, making the wire longer, N.
    pub load: Form,
    /// Error of the position sensor, m.
    pub position: Form,
    /// Error of V_3 over I, Ω.
    pub voltage: Form,
}

impl Empirical {
    /// Whether any form is on.
    pub(crate) fn is_on(&self) -> bool {
        [&self.thermal, &self.electrical, &self.kinetic, &self.mechanical, &self.load, &self.position, &self.voltage]
            .into_iter()
            .any(Form::is_on)
    }
}

/// Reads and writes the coefficient of the library's function `TERM` in one form of the model.
macro_rules! access {
    ($form:ident) => {
        mod $form {
            use crate::effects::empirical::{Empirical, Term};
            use crate::effects::row::{EffectParameter, Has, Null, Place, Role};

            fn get<M: Has<Empirical>, const TERM: usize>(model: &M) -> f64 {
                model.part().$form.coefficients[TERM]
            }

            fn set<M: Has<Empirical>, const TERM: usize>(model: &mut M, value: f64) {
                model.part_mut().$form.coefficients[TERM] = value;
            }

            /// The parameter that is the coefficient of `TERM`: its unit, range and plausible size.
            pub(super) const fn coefficient<M: Has<Empirical>, const TERM: usize>(
                unit: &'static str,
                (low, high): (f64, f64),
                plausible: (f64, f64),
            ) -> EffectParameter<M> {
                let term = Term::ALL[TERM];
                EffectParameter {
                    key: term.name(),
                    unit,
                    role: Role::Switch { null: Null::At(0.0) },
                    low,
                    high,
                    plausible,
                    about: term.formula(),
                    place: Place::Field { get: get::<M, TERM>, set: set::<M, TERM> },
                }
            }
        }
    };
}
access!(thermal);
access!(electrical);
access!(kinetic);
access!(mechanical);
access!(load);
access!(position);
access!(voltage);

impl<M: Has<Empirical>> Group<M> for Empirical {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "empirical.thermal",
            equation: Equation::Thermal,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::Heating,
            term: "loss Σ c φ",
            says: "What the wire loses besides the known losses follows a closed form",
            parameters: &[
                thermal::coefficient::<M, { Term::Tau as usize }>("W", (-10.0, 10.0), (-0.01, 0.01)),
                thermal::coefficient::<M, { Term::Tau2 as usize }>("W", (-10.0, 10.0), (-0.005, 0.005)),
                thermal::coefficient::<M, { Term::Martensite as usize }>("W", (-10.0, 10.0), (-0.03, 0.03)),
                thermal::coefficient::<M, { Term::Mixed as usize }>("W", (-10.0, 10.0), (-0.1, 0.1)),
                thermal::coefficient::<M, { Term::Stress as usize }>("W", (-10.0, 10.0), (-0.02, 0.02)),
                thermal::coefficient::<M, { Term::Position as usize }>("W", (-10.0, 10.0), (-0.03, 0.03)),
                thermal::coefficient::<M, { Term::Velocity as usize }>("W", (-1.0, 1.0), (-0.03, 0.03)),
                thermal::coefficient::<M, { Term::Power as usize }>("W", (-1.0, 1.0), (-0.2, 0.2)),
                thermal::coefficient::<M, { Term::Duty as usize }>("W", (-10.0, 10.0), (-0.2, 0.2)),
                thermal::coefficient::<M, { Term::MovedWarm as usize }>("W", (-10.0, 10.0), (-0.02, 0.02)),
                thermal::coefficient::<M, { Term::Time as usize }>("W", (-10.0, 10.0), (-0.02, 0.02)),
            ],
        },
        Effect {
            id: "empirical.electrical",
            equation: Equation::Electrical,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ρ → ρ (1 + Σ c φ)",
            says: "The resistivity differs from the model's by a closed form",
            parameters: &[
                electrical::coefficient::<M, { Term::Tau as usize }>("1", (-1.0, 1.0), (-0.05, 0.05)),
                electrical::coefficient::<M, { Term::Tau2 as usize }>("1", (-1.0, 1.0), (-0.03, 0.03)),
                electrical::coefficient::<M, { Term::Martensite as usize }>("1", (-1.0, 1.0), (-0.1, 0.1)),
                electrical::coefficient::<M, { Term::Mixed as usize }>("1", (-2.0, 2.0), (-0.2, 0.2)),
                electrical::coefficient::<M, { Term::Stress as usize }>("1", (-1.0, 1.0), (-0.05, 0.05)),
                electrical::coefficient::<M, { Term::Stress2 as usize }>("1", (-1.0, 1.0), (-0.03, 0.03)),
                electrical::coefficient::<M, { Term::Position as usize }>("1", (-1.0, 1.0), (-0.05, 0.05)),
                electrical::coefficient::<M, { Term::Position2 as usize }>("1", (-1.0, 1.0), (-0.05, 0.05)),
                electrical::coefficient::<M, { Term::PhaseRate as usize }>("1", (-1.0, 1.0), (-0.02, 0.02)),
                electrical::coefficient::<M, { Term::MovedWarm as usize }>("1", (-1.0, 1.0), (-0.05, 0.05)),
                electrical::coefficient::<M, { Term::Time as usize }>("1", (-1.0, 1.0), (-0.05, 0.05)),
            ],
        },
        Effect {
            id: "empirical.kinetic",
            equation: Equation::Kinetic,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ϑ → ϑ + Σ c φ",
            says: "The phase sees another temperature than the wire's by a closed form",
            parameters: &[
                kinetic::coefficient::<M, { Term::Tau as usize }>("K", (-100.0, 100.0), (-5.0, 5.0)),
                kinetic::coefficient::<M, { Term::Tau2 as usize }>("K", (-50.0, 50.0), (-3.0, 3.0)),
                kinetic::coefficient::<M, { Term::Stress as usize }>("K", (-100.0, 100.0), (-5.0, 5.0)),
                kinetic::coefficient::<M, { Term::Stress2 as usize }>("K", (-50.0, 50.0), (-3.0, 3.0)),
                kinetic::coefficient::<M, { Term::Position as usize }>("K", (-50.0, 50.0), (-5.0, 5.0)),
                kinetic::coefficient::<M, { Term::Velocity as usize }>("K", (-10.0, 10.0), (-2.0, 2.0)),
                kinetic::coefficient::<M, { Term::Power as usize }>("K", (-50.0, 50.0), (-2.0, 2.0)),
                kinetic::coefficient::<M, { Term::Duty as usize }>("K", (-100.0, 100.0), (-5.0, 5.0)),
                kinetic::coefficient::<M, { Term::PhaseRate as usize }>("K", (0.0, 20.0), (0.0, 1.0)),
                kinetic::coefficient::<M, { Term::Warming as usize }>("K", (-20.0, 20.0), (-2.0, 2.0)),
                kinetic::coefficient::<M, { Term::Time as usize }>("K", (-100.0, 100.0), (-3.0, 3.0)),
            ],
        },
        Effect {
            id: "empirical.mechanical",
            equation: Equation::Mechanical,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ε → ε + Σ c φ",
            says: "The wire is longer than the model says by a closed form",
            parameters: &[
                mechanical::coefficient::<M, { Term::Tau as usize }>("1", (-0.05, 0.05), (-0.001, 0.001)),
                mechanical::coefficient::<M, { Term::Tau2 as usize }>("1", (-0.05, 0.05), (-0.001, 0.001)),
                mechanical::coefficient::<M, { Term::Martensite as usize }>("1", (-0.05, 0.05), (-0.005, 0.005)),
                mechanical::coefficient::<M, { Term::Mixed as usize }>("1", (-0.1, 0.1), (-0.01, 0.01)),
                mechanical::coefficient::<M, { Term::Stress as usize }>("1", (-0.02, 0.02), (-0.001, 0.001)),
                mechanical::coefficient::<M, { Term::Stress2 as usize }>("1", (-0.01, 0.01), (-0.0005, 0.0005)),
                mechanical::coefficient::<M, { Term::Power as usize }>("1", (-0.05, 0.05), (-0.001, 0.001)),
                mechanical::coefficient::<M, { Term::Duty as usize }>("1", (-0.05, 0.05), (-0.002, 0.002)),
                mechanical::coefficient::<M, { Term::Warming as usize }>("1", (-0.005, 0.005), (-0.0005, 0.0005)),
                mechanical::coefficient::<M, { Term::Time as usize }>("1", (-0.05, 0.05), (-0.001, 0.001)),
            ],
        },
        Effect {
            id: "empirical.load",
            equation: Equation::Mechanical,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "M ẍ + … = … + Σ c φ",
            says: "Something else pulls on the load, by a closed form",
            parameters: &[
                load::coefficient::<M, { Term::Dry as usize }>("N", (-10000.0, 0.0), (-0.3, -0.015)),
                load::coefficient::<M, { Term::Velocity as usize }>("N", (-10000.0, 0.0), (-0.3, -0.015)),
                load::coefficient::<M, { Term::Drag as usize }>("N", (-10000.0, 0.0), (-0.2, -0.01)),
                load::coefficient::<M, { Term::Position as usize }>("N", (-10000.0, 10000.0), (-0.5, 0.5)),
                load::coefficient::<M, { Term::Position2 as usize }>("N", (-10000.0, 10000.0), (-0.5, 0.5)),
                load::coefficient::<M, { Term::Position3 as usize }>("N", (-10000.0, 10000.0), (-0.5, 0.5)),
                load::coefficient::<M, { Term::Tau as usize }>("N", (-1000.0, 1000.0), (-0.2, 0.2)),
                load::coefficient::<M, { Term::Martensite as usize }>("N", (-1000.0, 1000.0), (-0.3, 0.3)),
                load::coefficient::<M, { Term::Duty as usize }>("N", (-1000.0, 1000.0), (-0.3, 0.3)),
                load::coefficient::<M, { Term::MovedWarm as usize }>("N", (-1000.0, 1000.0), (-0.3, 0.3)),
                load::coefficient::<M, { Term::Time as usize }>("N", (-1000.0, 1000.0), (-0.2, 0.2)),
            ],
        },
        Effect {
            id: "empirical.position",
            equation: Equation::Sensing,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::FreeEnd,
            term: "x shown = x + Σ c φ",
            says: "The position sensor errs by a closed form",
            parameters: &[
                position::coefficient::<M, { Term::Tau as usize }>("m", (-0.1, 0.1), (-0.0005, 0.0005)),
                position::coefficient::<M, { Term::Martensite as usize }>("m", (-0.1, 0.1), (-0.0005, 0.0005)),
                position::coefficient::<M, { Term::Stress as usize }>("m", (-0.1, 0.1), (-0.0005, 0.0005)),
                position::coefficient::<M, { Term::Position as usize }>("m", (-0.1, 0.1), (-0.001, 0.001)),
                position::coefficient::<M, { Term::Position2 as usize }>("m", (-0.1, 0.1), (-0.001, 0.001)),
                position::coefficient::<M, { Term::Position3 as usize }>("m", (-0.1, 0.1), (-0.001, 0.001)),
                position::coefficient::<M, { Term::Velocity as usize }>("m", (-0.1, 0.1), (-0.0003, 0.0003)),
                position::coefficient::<M, { Term::Dry as usize }>("m", (-0.1, 0.1), (-0.0003, 0.0003)),
                position::coefficient::<M, { Term::Duty as usize }>("m", (-0.1, 0.1), (-0.0003, 0.0003)),
                position::coefficient::<M, { Term::Warming as usize }>("m", (-0.1, 0.1), (-0.0003, 0.0003)),
                position::coefficient::<M, { Term::Time as usize }>("m", (-0.1, 0.1), (-0.001, 0.001)),
            ],
        },
        Effect {
            id: "empirical.voltage",
            equation: Equation::Sensing,
            nature: Nature::Empirical,
            home: Home::Table,
            needs: Needs::Heating,
            term: "V_3 = I (R + Σ c φ)",
            says: "V_3 errs by a closed form of what passes the current",
            parameters: &[
                voltage::coefficient::<M, { Term::Tau as usize }>("Ω", (-100.0, 100.0), (-0.3, 0.3)),
                voltage::coefficient::<M, { Term::Tau2 as usize }>("Ω", (-100.0, 100.0), (-0.2, 0.2)),
                voltage::coefficient::<M, { Term::Martensite as usize }>("Ω", (-100.0, 100.0), (-0.3, 0.3)),
                voltage::coefficient::<M, { Term::Mixed as usize }>("Ω", (-100.0, 100.0), (-0.5, 0.5)),
                voltage::coefficient::<M, { Term::Stress as usize }>("Ω", (-100.0, 100.0), (-0.2, 0.2)),
                voltage::coefficient::<M, { Term::Position as usize }>("Ω", (-100.0, 100.0), (-0.3, 0.3)),
                voltage::coefficient::<M, { Term::Position2 as usize }>("Ω", (-100.0, 100.0), (-0.3, 0.3)),
                voltage::coefficient::<M, { Term::Velocity as usize }>("Ω", (-100.0, 100.0), (-0.2, 0.2)),
                voltage::coefficient::<M, { Term::Power as usize }>("Ω", (-100.0, 100.0), (-0.2, 0.2)),
                voltage::coefficient::<M, { Term::Duty as usize }>("Ω", (-100.0, 100.0), (-0.3, 0.3)),
                voltage::coefficient::<M, { Term::MovedWarm as usize }>("Ω", (-100.0, 100.0), (-0.3, 0.3)),
                voltage::coefficient::<M, { Term::Time as usize }>("Ω", (-100.0, 100.0), (-0.2, 0.2)),
            ],
        },
    ];
}
