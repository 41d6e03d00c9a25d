//! What a wire is made of and what it hangs in: the parameters of the model, in SI.
//!
//! Temperatures are in °C: only differences and offsets of them occur in the equations.
//! What makes a whole wire of them is [`WireModel`](crate::WireModel).

/// The alloy. Defaults are those of a trained Flexinol-type NiTi wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus of austenite, E_A, in Pa.
    pub austenite_modulus_pa: f64,
    /// Young's modulus of martensite, E_M, in Pa.
    pub martensite_modulus_pa: f64,
    /// Largest shape-memory strain ε_L, dimensionless.
    pub transformation_strain: f64,
    /// Thermoelastic coefficient θ, in Pa/K.
    pub thermoelastic_pa_per_k: f64,
    /// Temperature T_0 from which thermal strain and resistivity are counted, in °C.
    pub reference_temperature_c: f64,
    /// Centre A of the transformation on heating at zero stress, in °C.
    pub austenite_temperature_c: f64,
    /// Centre M of the transformation on cooling at zero stress, in °C.
    pub martensite_temperature_c: f64,
    /// Shift 1/α of A and M with stress, in K/Pa.
    pub stress_shift_k_per_pa: f64,
    /// Steepness k_A of the heating curve, in 1/K.
    pub heating_steepness_per_k: f64,
    /// Steepness k_M of the cooling curve, in 1/K.
    pub cooling_steepness_per_k: f64,
    /// Weight w of the outer loop: 0 = implicit inner loop only, 1 = outer loop only.
    pub outer_loop_weight: f64,
    /// Specific heat c_p, in J/(kg K).
    pub specific_heat_j_per_kg_k: f64,
    /// Latent heat of transformation ΔH, in J/kg.
    pub latent_heat_j_per_kg: f64,
    /// Density ρ_d, in kg/m³.
    pub density_kg_per_m3: f64,
    /// Convection coefficient h, in W/(m² K).
    pub convection_w_per_m2_k: f64,
    /// Resistivity ρ_A0 of austenite at T_0, in Ω m.
    pub austenite_resistivity_ohm_m: f64,
    /// Resistivity ρ_M0 of martensite at T_0, in Ω m.
    pub martensite_resistivity_ohm_m: f64,
    /// Slope α_A of austenite's resistivity, in Ω m/K.
    pub austenite_resistivity_slope_ohm_m_per_k: f64,
    /// Slope α_M of martensite's resistivity, in Ω m/K.
    pub martensite_resistivity_slope_ohm_m_per_k: f64,
    /// The law of the outer transformation curves.
    pub kinetics: Kinetics,
    /// When the phase moves along them.
    pub criterion: Criterion,
    /// Where twinned martensite is a part of its own; `None` where all martensite is detwinned.
    pub detwinning: Option<Detwinning>,
    /// How the moduli of the phases combine.
    pub mixing: Mixing,
    /// How the loss to the air depends on temperature.
    pub convection: Convection,
}

impl Default for Material {
    fn default() -> Self {
        Material {
            austenite_modulus_pa: 75e9,
            martensite_modulus_pa: 28e9,
            transformation_strain: 0.04,
            thermoelastic_pa_per_k: 0.55e6,
            reference_temperature_c: 20.0,
            austenite_temperature_c: 93.0,
            martensite_temperature_c: 67.0,
            stress_shift_k_per_pa: 0.125e-6,
            heating_steepness_per_k: 0.31,
            cooling_steepness_per_k: 0.31,
            outer_loop_weight: 0.8,
            specific_heat_j_per_kg_k: 836.0,
            latent_heat_j_per_kg: 24200.0,
            density_kg_per_m3: 6450.0,
            convection_w_per_m2_k: 121.2,
            austenite_resistivity_ohm_m: 86.5e-8,
            martensite_resistivity_ohm_m: 75.0e-8,
            austenite_resistivity_slope_ohm_m_per_k: 0.05e-8,
            martensite_resistivity_slope_ohm_m_per_k: 0.15e-8,
            kinetics: Kinetics::Logistic,
            criterion: Criterion::DrivingTemperature,
            detwinning: None,
            mixing: Mixing::Series,
            convection: Convection::Constant,
        }
    }
}

/// The law of the outer transformation curves g_A and g_M. All but [`Kinetics::Logistic`] are there for comparison.
/// The bounded laws (linear to Liang–Rogers) start and finish 9.21/k apart, centred on A and M.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kinetics {
    /// Linear in the distance to the finish temperature (eq. 15).
    Linear,
    /// Square root of it (eq. 16).
    SquareRoot,
    /// Tanaka's exponential, 1 % left at the finish temperature (eq. 17).
    Tanaka,
    /// Liang and Rogers' cosine (eq. 18).
    LiangRogers,
    /// The logistic curve (eq. 20): the reference.
    Logistic,
    /// Richards' generalised logistic curve (eq. 21); a skew of 1 is the logistic one.
    Richards {
        /// v_A of the heating curve, dimensionless.
        heating_skew: f64,
        /// v_M of the cooling curve, dimensionless.
        cooling_skew: f64,
    },
}

/// When the phase moves, and which way. All but [`Criterion::DrivingTemperature`] are there for comparison: where they are not met the
/// phase stands still, whatever the outer curves say. Starts and finishes lie half of 9.21/k to either side of A and M.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// By the direction of ϑ = T − σ/α, without bounds (eq. 12): the reference.
    DrivingTemperature,
    /// Tanaka's, by the direction of the stress: towards austenite as it falls, from A_s on; towards martensite as it rises, from M_s on;
    /// neither finishes (eq. 8).
    Tanaka,
    /// Liang and Rogers', by the direction of the temperature, between start and finish (eq. 9).
    LiangRogers,
    /// Brinson's, by the direction of the stress, between start and finish (eq. 10).
    Brinson,
    /// Elahinia and Ahmadian's, by the direction of ϑ, between start and finish (eq. 11).
    ElahiniaAhmadian,
}

/// The stresses between which twinned martensite becomes detwinned, along a cosine (Brinson 1993, whose NiTi has 100 and 170 MPa). Only
/// what is detwinned has the strain ε_L; what stress has detwinned stays so until it is austenite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detwinning {
    /// Stress σ_s up to which twinned martensite stays as it is, in Pa.
    pub start_pa: f64,
    /// Stress σ_f from which on all of it is detwinned, in Pa.
    pub finish_pa: f64,
}

/// How the moduli of the two phases combine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mixing {
    /// Same stress in both phases, compliances add (Reuss, eq. 4): the reference.
    Series,
    /// Same strain in both phases, moduli add (Voigt, eq. 3).
    Parallel,
}

/// How the loss to the air depends on temperature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convection {
    /// h is constant: the reference.
    Constant,
    /// h = 65.5 exp(−D/4) (T − T_∞)^(1/6), D in mm (eq. 34); the material's `convection_w_per_m2_k` is not used.
    Natural,
}

/// The wire's size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// Diameter d, in m.
    pub diameter_m: f64,
    /// Hot and unloaded length L_0, in m.
    pub length_m: f64,
}

impl Geometry {
    /// Cross-section A_c, in m².
    pub fn area_m2(&self) -> f64 {
        std::f64::consts::FRAC_PI_4 * self.diameter_m * self.diameter_m
    }

    /// Surface A_s towards the air, in m².
    pub fn surface_m2(&self) -> f64 {
        std::f64::consts::PI * self.diameter_m * self.length_m
    }

    /// Volume A_c L_0, in m³.
    pub fn volume_m3(&self) -> f64 {
        self.area_m2() * self.length_m
    }
}

/// Where the two fixed probes of the dual measurement touch, counted from the fixed end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taps {
    /// Position l_0 of the first tap, in m.
    pub l0_m: f64,
    /// Distance l_s from the first to the second tap, in m.
    pub ls_m: f64,
}

/// What the drive's input column means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DriveKind {
    /// Duty 0..1 of the supply.
    Pwm,
    /// Heating power in W, given to the wire as it is.
    Power,
    /// A steady current in A; P = I²R.
    Current,
    /// Duty 0..1 of a current amplifier (fig. 64, 83); P = I²R of the current that it regulates.
    Amplifier(Amplifier),
    /// The wire's temperature in °C, imposed as in a furnace: no heat balance.
    Temperature,
}

/// The current amplifier of fig. 64 and 83: the PWM passes a first-order low-pass, and what comes out of that sets the current, whatever the
/// wire's resistance, up to what the supply drives through it (the compliance limit). The ripple that the low-pass leaves of the PWM is
/// left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplifier {
    /// Current at duty 1, in A.
    pub full_current_a: f64,
    /// Cut-off of the low-pass, in Hz.
    pub filter_hz: f64,
}

/// The heating circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// What the input means.
    pub kind: DriveKind,
    /// Supply voltage V_s, in V.
    pub supply_v: f64,
    /// Current shunt, in Ω.
    pub shunt_ohm: f64,
    /// Switch in its on state, in Ω.
    pub switch_ohm: f64,
    /// Leads outside the taps, in Ω.
    pub lead_ohm: f64,
}

/// What the moving end pulls against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// M ẍ + B ẋ + K x = F_preload + F_ext − A_c σ (eq. 51). A hanging mass has K = 0 and F_preload = M g.
    SpringMassDamper {
        /// Moving mass M, in kg.
        mass_kg: f64,
        /// Damping B, in N s/m.
        damping_n_s_per_m: f64,
        /// Spring K, in N/m.
        spring_n_per_m: f64,
        /// Pull at x = 0, in N.
        preload_n: f64,
    },
    /// The elongation is an input; the tension follows.
    ImposedPosition,
    /// The tension is an input; the elongation follows.
    ImposedForce,
}

/// The state at the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Initial {
    /// Wire temperature, in °C; `None` = ambient, or the first imposed temperature.
    pub temperature_c: Option<f64>,
    /// Martensite fraction, clipped into the outer curves.
    pub martensite: f64,
}

impl Default for Initial {
    fn default() -> Self {
        Initial { temperature_c: None, martensite: 1.0 }
    }
}
