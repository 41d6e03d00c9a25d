//! Terms of the heat balance (eq. 48).

use super::row::{Effect, Equation, Group, Has, Home, Nature, Needs, shape, switch};
use crate::formulas::{CONVECTION_EXPONENT, WORKING_EXCESS_K, convection_growth};

/// Terms of the heat balance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Thermal {
    /// Moving air for a while.
    pub draught: Draught,
    /// A film of air that thins as the wire heats.
    pub natural_convection: NaturalConvection,
    /// Heat radiated away.
    pub radiation: Radiation,
    /// Heat conducted into the clamps.
    pub end_conduction: EndConduction,
    /// A tube between wire and air.
    pub sheath: Sheath,
    /// A room that warms or cools.
    pub ambient_drift: AmbientDrift,
    /// Another wire close by.
    pub neighbour: Neighbour,
    /// Work on what the phases stretch unequally.
    pub elastic_work: ElasticWork,
}

/// Time scale of a draught's edges, s: a logistic edge rises from 10 % to 90 % in 4.39 of it, 0.15 s.
const DRAUGHT_EDGE_S: f64 = 0.034;
/// Stefan and Boltzmann's constant σ_SB, in W/(m² K⁴).
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// 0 °C, in K.
const ZERO_CELSIUS_K: f64 = 273.15;

/// `thermal.draught`: h → h (1 + gain) from start to end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draught {
    /// Share by which h rises.
    pub gain: f64,
    /// Begin, s since the start of the recording.
    pub start_s: f64,
    /// End, s since the start of the recording.
    pub end_s: f64,
}

impl Default for Draught {
    fn default() -> Self {
        Draught { gain: 0.0, start_s: 0.0, end_s: 1e7 }
    }
}

impl Draught {
    /// The factor on h at time `t`, in s: 1 + gain · w(t), the window w having logistic edges.
    fn factor(&self, t: f64) -> f64 {
        if self.gain == 0.0 {
            return 1.0;
        }
        let edge = |since: f64| 1.0 / (1.0 + (-since / DRAUGHT_EDGE_S).exp());
        1.0 + self.gain * (edge(t - self.start_s) - edge(t - self.end_s)).max(0.0)
    }
}

/// `thermal.natural_convection`: h → h (|T − T∞|/60 K)^exponent (eq. 34 has 1/6).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NaturalConvection {
    /// The exponent n.
    pub exponent: f64,
}

impl NaturalConvection {
    /// The factor (|ΔT|/60 K)^n on h.
    fn factor(&self, above_ambient: f64) -> f64 {
        if self.exponent == 0.0 { 1.0 } else { (above_ambient.abs() / WORKING_EXCESS_K).powf(self.exponent) }
    }
}

/// `thermal.radiation`: loss ε σ_SB A_s (T⁴ − T∞⁴), temperatures in kelvin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Radiation {
    /// Emissivity ε, 0..1.
    pub emissivity: f64,
}

impl Radiation {
    /// Loss at a wire temperature in °C, from a surface in m².
    fn loss(&self, surface: f64, temperature: f64, ambient: f64) -> HeatFlow {
        let strength = self.emissivity * STEFAN_BOLTZMANN * surface;
        let (hot, cold) = ((temperature + ZERO_CELSIUS_K).max(0.0), (ambient + ZERO_CELSIUS_K).max(0.0));
        let cube = hot * hot * hot;
        HeatFlow { watts: strength * (hot * cube - cold.powi(4)), per_k: 4.0 * strength * cube }
    }
}

/// `thermal.end_conduction`: heat flows along the wire, k A_c ∂²T/∂s², into clamps that stay at ambient.
///
/// At rest the wire is a fin on each clamp, T(s) − T∞ = (T − T∞)(1 − e^{−s/ℓ}), ℓ = √(k A_c/(h π d)), s from a clamp; the
/// cold zones reach a few ℓ far. There the wire is computed in cells, each with its own heat balance, phase and
/// resistance; what lies between the zones is one piece, whose temperature T is the one that is reported. See `ends.rs`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndConduction {
    /// Thermal conductivity k of the wire, in W/(m K).
    pub conductivity_w_per_m_k: f64,
}

/// Cells that the cold zone at a clamp is cut into: of steps in temperature that get finer towards mid-wire, where most
/// of the zone's length is.
pub(crate) const CELLS: usize = 12;

impl EndConduction {
    /// How many parts of the wire have temperatures of their own, besides its middle.
    pub(crate) fn parts(&self) -> usize {
        if self.conductivity_w_per_m_k > 0.0 { CELLS } else { 0 }
    }
}

/// `thermal.sheath`: the wire loses k_i (T − T_s) to a sleeve, instead of h A_s (T − T∞) to the air;
/// C Ṫ_s = k_i (T − T_s) − k_o (T_s − T∞). Draught and natural convection then act on k_o.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheath {
    /// Heat capacity C of the sleeve, in J/K.
    pub heat_capacity_j_per_k: f64,
    /// Conductance k_i from wire to sleeve, in W/K.
    pub inner_w_per_k: f64,
    /// Conductance k_o from sleeve to air, in W/K.
    pub outer_w_per_k: f64,
}

/// Conductance of a thin sleeve towards its thin wire, in W/K.
const SHEATH_INNER_W_PER_K: f64 = 0.02;
/// The same towards the air, in W/K.
const SHEATH_OUTER_W_PER_K: f64 = 0.008;

impl Default for Sheath {
    fn default() -> Self {
        Sheath { heat_capacity_j_per_k: 0.0, inner_w_per_k: SHEATH_INNER_W_PER_K, outer_w_per_k: SHEATH_OUTER_W_PER_K }
    }
}

impl Sheath {
    /// Whether there is one.
    pub fn is_on(&self) -> bool {
        self.heat_capacity_j_per_k > 0.0
    }

    /// T_s with nothing flowing into the sleeve on balance, in °C.
    pub fn settled(&self, temperature: f64, ambient: f64) -> f64 {
        let both = self.inner_w_per_k + self.outer_w_per_k;
        if both > 0.0 { ambient + (temperature - ambient) * self.inner_w_per_k / both } else { ambient }
    }
}

/// `thermal.ambient_drift`: T∞ → T∞ + rate · t.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AmbientDrift {
    /// Rate, in K/s.
    pub rate_k_per_s: f64,
}

/// `thermal.neighbour`: loss g (T − T_n) to another wire at T_n.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Neighbour {
    /// Conductance g between the wires, in W/K.
    pub conductance_w_per_k: f64,
}

/// `thermal.elastic_work`: heat share ½ A_c L_0 σ² C'(ξ) ξ̇, C the compliance. Eq. 48 takes the work of σ on ε_L alone; eq. 29 takes it
/// on all of ε, of which the elastic part comes back over a cycle only where both phases are equally stiff.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ElasticWork {
    /// Share of that heat which there is: 1 closes the balance of energy.
    pub share: f64,
}

impl ElasticWork {
    /// Strain per ξ that does this work at a stress, where ξ changes the compliance by so much, in 1/Pa.
    pub(crate) fn strain(&self, compliance_slope: f64, stress: f64) -> f64 {
        0.5 * self.share * compliance_slope * stress
    }
}

/// A flow of heat out of the wire at a temperature, and how it grows with that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HeatFlow {
    /// In W.
    pub(crate) watts: f64,
    /// In W/K.
    pub(crate) per_k: f64,
}

/// The wire's surface as the reference model has it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Skin {
    /// A_s, m².
    pub(crate) area: f64,
    /// h A_s, W/K; with natural convection its value at 1 K.
    pub(crate) loss_w_per_k: f64,
    /// Whether h follows eq. 34.
    pub(crate) natural: bool,
}

impl Skin {
    /// Loss coefficient h A_s at `above` K over ambient, in W/K.
    #[inline]
    pub(crate) fn loss_coefficient(&self, above: f64) -> f64 {
        if self.natural { self.loss_w_per_k * convection_growth(above) } else { self.loss_w_per_k }
    }
}

/// What is around a wire at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Around {
    /// T∞, °C.
    pub(crate) ambient: f64,
    /// Factor on h of air that moves.
    pub(crate) stirred: f64,
    /// T_s of the sleeve at T = 0 °C, °C, and how it follows T, K/K.
    pub(crate) sleeve: f64,
    pub(crate) sleeve_per_k: f64,
    /// Temperature of the neighbouring wire, °C; ambient where nobody says.
    pub(crate) neighbour: Option<f64>,
}

impl Thermal {
    /// T∞ at the time `t` in s, where the recording has `ambient`, in °C.
    pub(crate) fn ambient(&self, ambient: f64, t: f64) -> f64 {
        ambient + self.ambient_drift.rate_k_per_s * t
    }

    /// The factor on h that the time `t` in s alone makes.
    pub(crate) fn stirring(&self, t: f64) -> f64 {
        self.draught.factor(t)
    }

    /// The factor on h that the temperature makes, `above` K over ambient.
    pub(crate) fn convection(&self, above: f64) -> f64 {
        self.natural_convection.factor(above)
    }

    /// Loss to the air through the film, of a wire `above` its air.
    pub(crate) fn film(&self, skin: &Skin, above: f64, stirred: f64) -> HeatFlow {
        let exponent = self.natural_convection.exponent + if skin.natural { CONVECTION_EXPONENT } else { 0.0 };
        let film = skin.loss_coefficient(above) * stirred * self.convection(above);
        HeatFlow { watts: film * above, per_k: (1.0 + exponent) * film }
    }

    /// All that a wire at `temperature` loses through its surface.
    pub(crate) fn losses(&self, skin: &Skin, temperature: f64, around: &Around) -> HeatFlow {
        let mut flow = if self.sheath.is_on() {
            let inner = self.sheath.inner_w_per_k;
            HeatFlow {
                watts: inner * (temperature - around.sleeve - around.sleeve_per_k * temperature),
                per_k: inner * (1.0 - around.sleeve_per_k),
            }
        } else {
            self.film(skin, temperature - around.ambient, around.stirred)
        };
        if self.radiation.emissivity > 0.0 {
            let radiated = self.radiation.loss(skin.area, temperature, around.ambient);
            flow.watts += radiated.watts;
            flow.per_k += radiated.per_k;
        }
        if self.neighbour.conductance_w_per_k > 0.0 {
            let between = self.neighbour.conductance_w_per_k;
            flow.watts += between * (temperature - around.neighbour.unwrap_or(around.ambient));
            flow.per_k += between;
        }
        flow
    }
}

impl<M: Has<Thermal>> Group<M> for Thermal {
    const ROWS: &'static [Effect<M>] = &[
        Effect {
            id: "thermal.draught",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "h → h (1 + gain) from start_s to end_s",
            says: "For a while the air moved and took more heat from the wire",
            parameters: &[
                switch!(
                    0.0,
                    "gain",
                    "1",
                    (-0.95, 20.0),
                    (0.15, 1.5),
                    1.0,
                    draught.gain,
                    "share by which the heat loss rises"
                ),
                shape!(0.0, "start_s", "s", (0.0, 1e7), (0.0, 100.0), 1.0, draught.start_s, "when it begins"),
                shape!(1e7, "end_s", "s", (0.0, 1e7), (0.0, 100.0), 1.0, draught.end_s, "when it ends"),
            ],
        },
        Effect {
            id: "thermal.natural_convection",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "h → h (|T − T∞|/60 K)^exponent",
            says: "The hotter the wire, the better the air it stirs cools it",
            parameters: &[switch!(
                0.0,
                "exponent",
                "1",
                (0.0, 1.0),
                (0.1, 0.35),
                1.0,
                natural_convection.exponent,
                "exponent of the temperature difference"
            )],
        },
        Effect {
            id: "thermal.radiation",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "loss ε σ_SB A_s (T⁴ − T∞⁴)",
            says: "The wire radiates heat away",
            parameters: &[switch!(
                0.0,
                "emissivity",
                "1",
                (0.0, 1.0),
                (0.2, 0.9),
                1.0,
                radiation.emissivity,
                "emissivity of the wire's surface"
            )],
        },
        Effect {
            id: "thermal.end_conduction",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "+ k A_c ∂²T/∂s² along the wire, T = T∞ at both clamps: cold zones of a few ℓ = √(k d/(4 h))",
            says: "The clamps keep the ends of the wire cold",
            parameters: &[switch!(
                0.0,
                "conductivity_w_per_m_k",
                "W/(m K)",
                (0.0, 500.0),
                (8.0, 40.0),
                1.0,
                end_conduction.conductivity_w_per_m_k,
                "thermal conductivity k along the wire"
            )],
        },
        Effect {
            id: "thermal.sheath",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "loss inner (T − T_s) instead of h A_s (T − T∞); C Ṫ_s = inner (T − T_s) − outer (T_s − T∞)",
            says: "A tube or sleeve around the wire stores heat and passes it on to the air",
            parameters: &[
                switch!(
                    0.0,
                    "heat_capacity_j_per_k",
                    "J/K",
                    (0.0, 1000.0),
                    (0.002, 0.05),
                    1.0,
                    sheath.heat_capacity_j_per_k,
                    "heat capacity C of the sleeve"
                ),
                shape!(
                    SHEATH_INNER_W_PER_K,
                    "inner_w_per_k",
                    "W/K",
                    (0.0, 100.0),
                    (0.004, 0.1),
                    1.0,
                    sheath.inner_w_per_k,
                    "conductance from wire to sleeve"
                ),
                shape!(
                    SHEATH_OUTER_W_PER_K,
                    "outer_w_per_k",
                    "W/K",
                    (0.0, 100.0),
                    (0.003, 0.05),
                    1.0,
                    sheath.outer_w_per_k,
                    "conductance from sleeve to air"
                ),
            ],
        },
        Effect {
            id: "thermal.ambient_drift",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "T∞ → T∞ + rate t",
            says: "The air around the wire warmed or cooled in a straight line",
            parameters: &[switch!(
                0.0,
                "rate_k_per_s",
                "K/s",
                (-10.0, 10.0),
                (-0.1, 0.1),
                1.0,
                ambient_drift.rate_k_per_s,
                "rate of the ambient temperature"
            )],
        },
        Effect {
            id: "thermal.neighbour",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "loss conductance (T − T_neighbour)",
            says: "Heat passes between this wire and the one beside it",
            parameters: &[switch!(
                0.0,
                "conductance_w_per_k",
                "W/K",
                (0.0, 10.0),
                (2e-4, 5e-3),
                1.0,
                neighbour.conductance_w_per_k,
                "conductance between the wires"
            )],
        },
        Effect {
            id: "thermal.elastic_work",
            equation: Equation::Thermal,
            nature: Nature::Mechanism,
            home: Home::Table,
            needs: Needs::Heating,
            term: "heat + share ½ A_c L_0 σ² dC/dξ ξ̇",
            says: "Where martensite is softer, transforming under stress does elastic work, which is heat",
            parameters: &[switch!(
                0.0,
                "share",
                "1",
                (-10.0, 10.0),
                (0.5, 1.5),
                1.0,
                elastic_work.share,
                "share of that work; 1 closes the balance of energy"
            )],
        },
    ];
}
