//! Terms of resistance and circuit (eq. 36–41).

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, shape, switch};

/// Terms of resistance and circuit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Electrical {
    /// A supply that gives way.
    pub supply_sag: SupplySag,
    /// Leads outside the taps.
    pub lead_resistance: LeadResistance,
    /// Resistivity under stress.
    pub resistivity_stress: ResistivityStress,
    /// A cross-section that narrows under stress.
    pub poisson_area: PoissonArea,
    /// The R-phase.
    pub r_phase: RPhase,
}

/// `electrical.supply_sag`: I = V_s/(R + … + R_source); the supply recorded is its open-circuit voltage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SupplySag {
    /// Resistance inside the supply, in Ω.
    pub source_ohm: f64,
}

/// `electrical.lead_resistance`: adds to the leads the rig file gives, I = V_s/(R + … + R_lead).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeadResistance {
    /// Resistance of the leads outside the taps, in Ω.
    pub lead_ohm: f64,
}

/// `electrical.resistivity_stress`: ρ_A → ρ_A (1 + β_A σ), ρ_M → ρ_M (1 + β_M σ) (eq. 38, its β relative to ρ).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResistivityStress {
    /// β_A of austenite, in 1/Pa.
    pub austenite_per_pa: f64,
    /// β_M of martensite, in 1/Pa.
    pub martensite_per_pa: f64,
}

/// `electrical.poisson_area`: A = A_c (1 − ν σ/E)², E = 1/C(ξ) (eq. 41).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PoissonArea {
    /// Poisson's ratio ν.
    pub ratio: f64,
}

impl PoissonArea {
    /// A_c/A at a stress in Pa, with the compliance 1/E in 1/Pa.
    fn factor(&self, stress: f64, compliance: f64) -> f64 {
        let narrower = (1.0 - self.ratio * stress * compliance).max(0.5);
        1.0 / (narrower * narrower)
    }
}

/// `electrical.r_phase`: ρ → ρ + peak e^{−½((T − T_R)/width)²} ξ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RPhase {
    /// Height of the bump, in Ω m.
    pub peak_ohm_m: f64,
    /// Its middle T_R, in °C.
    pub temperature_c: f64,
    /// Its width (standard deviation), in K.
    pub width_k: f64,
}

/// Middle of the R-phase's bump in NiTi, in °C.
const R_PHASE_C: f64 = 55.0;
/// Its width, in K.
const R_PHASE_WIDTH_K: f64 = 10.0;

impl Default for RPhase {
    fn default() -> Self {
        RPhase { peak_ohm_m: 0.0, temperature_c: R_PHASE_C, width_k: R_PHASE_WIDTH_K }
    }
}

impl RPhase {
    /// What it adds to martensite's resistivity, in Ω m.
    fn resistivity(&self, temperature: f64) -> f64 {
        if self.peak_ohm_m == 0.0 {
            return 0.0;
        }
        let z = (temperature - self.temperature_c) / self.width_k;
        self.peak_ohm_m * (-0.5 * z * z).exp()
    }
}

/// Resistances of a wire that would be all of one phase, in Ω.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PhaseOhms {
    pub(crate) austenite: f64,
    pub(crate) martensite: f64,
}

impl Electrical {
    /// What is in series with the wire, in Ω, where the rig file has `series_ohm`.
    pub(crate) fn in_series(&self, series_ohm: f64) -> f64 {
        series_ohm + self.lead_resistance.lead_ohm + self.supply_sag.source_ohm
    }

    /// What becomes of the phases' resistances at a stress in Pa and a temperature in °C; `ohm_per_resistivity` is Ω of the
    /// wire per Ω m.
    #[inline]
    pub(crate) fn resistances(
        &self,
        mut of: PhaseOhms,
        stress: f64,
        temperature: f64,
        ohm_per_resistivity: f64,
    ) -> PhaseOhms {
        of.austenite *= 1.0 + self.resistivity_stress.austenite_per_pa * stress;
        of.martensite *= 1.0 + self.resistivity_stress.martensite_per_pa * stress;
        // carried by the martensite fraction
        of.martensite += self.r_phase.resistivity(temperature) * ohm_per_resistivity;
        of
    }

    /// By what the resistance grows as the cross-section narrows at a stress in Pa, with the compliance 1/E in 1/Pa.
    pub(crate) fn narrowing(&self, stress: f64, compliance: f64) -> f64 {
        self.poisson_area.factor(stress, compliance)
    }
}

impl<M: Has<Electrical>> Group<M> for Electrical {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "electrical.supply_sag",
            equation: Equation::Electrical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Supply,
            term: "I = V_s/(R + R_circuit + source_ohm)",
            says: "The supply's voltage sags under the wire's current",
            parameters: &[switch!(
                0.0,
                "source_ohm",
                "Ω",
                (0.0, 1000.0),
                (0.1, 0.8),
                1.0,
                supply_sag.source_ohm,
                "resistance inside the supply"
            )],
        },
        Effect {
            id: "electrical.lead_resistance",
            equation: Equation::Electrical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Supply,
            term: "I = V_s/(R + R_circuit + lead_ohm)",
            says: "The leads to the wire have a resistance the rig file does not give",
            parameters: &[switch!(
                0.0,
                "lead_ohm",
                "Ω",
                (0.0, 1000.0),
                (0.05, 0.5),
                1.0,
                lead_resistance.lead_ohm,
                "resistance of the leads outside the taps"
            )],
        },
        Effect {
            id: "electrical.resistivity_stress",
            equation: Equation::Electrical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ρ_A → ρ_A (1 + β_A σ), ρ_M → ρ_M (1 + β_M σ) (eq. 38)",
            says: "Stress changes the resistivity",
            parameters: &[
                switch!(
                    0.0,
                    "austenite_per_gpa",
                    "1/GPa",
                    (-5.0, 5.0),
                    (0.05, 0.6),
                    1e-9,
                    resistivity_stress.austenite_per_pa,
                    "relative change β_A of austenite's resistivity per stress"
                ),
                switch!(
                    0.0,
                    "martensite_per_gpa",
                    "1/GPa",
                    (-5.0, 5.0),
                    (0.05, 0.6),
                    1e-9,
                    resistivity_stress.martensite_per_pa,
                    "relative change β_M of martensite's resistivity per stress"
                ),
            ],
        },
        Effect {
            id: "electrical.poisson_area",
            equation: Equation::Electrical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "A = A_c (1 − ν σ/E)² (eq. 41)",
            says: "The wire narrows as it is stretched",
            parameters: &[switch!(
                0.0,
                "ratio",
                "1",
                (0.0, 0.5),
                (0.25, 0.45),
                1.0,
                poisson_area.ratio,
                "Poisson's ratio ν"
            )],
        },
        Effect {
            id: "electrical.r_phase",
            equation: Equation::Electrical,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Nothing,
            term: "ρ → ρ + peak exp(−½((T − temperature)/width)²) ξ",
            says: "The R-phase raises the resistivity around a temperature while there is martensite",
            parameters: &[
                switch!(
                    0.0,
                    "peak_uohm_cm",
                    "µΩ·cm",
                    (-200.0, 200.0),
                    (4.0, 13.0),
                    1e-8,
                    r_phase.peak_ohm_m,
                    "height of the bump"
                ),
                shape!(
                    R_PHASE_C,
                    "temperature_c",
                    "°C",
                    (-200.0, 800.0),
                    (35.0, 80.0),
                    1.0,
                    r_phase.temperature_c,
                    "temperature of its middle"
                ),
                shape!(
                    R_PHASE_WIDTH_K,
                    "width_k",
                    "K",
                    (0.1, 200.0),
                    (4.0, 25.0),
                    1.0,
                    r_phase.width_k,
                    "its standard deviation"
                ),
            ],
        },
    ];
}
