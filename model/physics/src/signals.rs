//! What goes into a wire and what comes out of it.

/// What acts on the wire during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Duty 0..1, power in W, current in A or temperature in °C, by the drive's kind; an amplifier takes a duty. A temperature is reached at the
    /// end of the step.
    pub drive: f64,
    /// Supply voltage V_s, in V.
    pub supply_v: f64,
    /// Ambient temperature T_∞, in °C.
    pub ambient_c: f64,
    /// External force on the load, in N, positive pulling the wire longer.
    pub external_n: f64,
    /// Imposed elongation in m or tension in N, reached at the end of the step; not read with a spring-mass-damper.
    pub imposed: f64,
}

/// What sensors see at the end of a step: voltages and current in the on-phase of the PWM.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// On-phase current I, in A.
    pub current_a: f64,
    /// First tap, in V; 0 without taps.
    pub v1_v: f64,
    /// Second tap, in V; 0 without taps.
    pub v2_v: f64,
    /// Moving end, in V.
    pub v3_v: f64,
    /// Wire tension A_c σ, in N.
    pub force_n: f64,
    /// Elongation L − L_0, in m, positive longer.
    pub position_m: f64,
    /// Wire temperature T, in °C.
    pub temperature_c: f64,
    /// Martensite fraction ξ, 0..1.
    pub martensite: f64,
    /// Mean heating power over the last step, in W.
    pub power_w: f64,
    /// Resistance R of the wire, in Ω.
    pub resistance_ohm: f64,
}

/// Where the energy went since the start, in J. Heat in equals the sum of the others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EnergyBalance {
    /// Electrical heat ∫P dt.
    pub heat_in_j: f64,
    /// Loss ∫h A_s (T − T_∞) dt to the air, and by whatever other way heat leaves for good.
    pub loss_j: f64,
    /// Heat kept by a sleeve around the wire.
    pub sheath_j: f64,
    /// Sensible heat m c_p (T − T_start).
    pub sensible_j: f64,
    /// Latent heat taken up by forming austenite, m ΔH (ξ_start − ξ).
    pub latent_j: f64,
    /// Mechanical work of transformation, −∫A_c L_0 σ ε_L dξ; of ξ_S where twinned martensite is a part of its own, so that what detwins
    /// it is in there. The wire turns it into heat, without any that is latent.
    pub work_j: f64,
}

impl EnergyBalance {
    /// What does not add up, in J: rounding, if the equations are solved as written.
    pub fn residual_j(&self) -> f64 {
        self.heat_in_j - self.loss_j - self.sheath_j - self.sensible_j - self.latent_j - self.work_j
    }
}
