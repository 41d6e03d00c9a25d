//! What is true of a wire in the second generator: the coefficients a rig file has, the structure it cannot have, and
//! what is concealed.

use super::super::generator::truth::Truth;
use super::grains::Ranks;

/// A wire, its rig and its surroundings.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// Coefficients and constants under the rig file's keys; of its terms beyond the reference only gains are used.
    pub plain: Truth,
    /// What the reference model is built otherwise in.
    pub structure: Structure,
    /// What is concealed.
    pub hidden: Hidden,
}

/// Structure of this generator's wires.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// The grains.
    pub ranks: Ranks,
    /// Loss by a correlation of temperature instead of a constant.
    pub correlated_air: bool,
    /// Conductivity of the wire towards its clamps, W/(m K); 0 = ends lose nothing.
    pub ends: f64,
    /// Inertia of a pulley as a mass at its rim, kg.
    pub pulley: f64,
    /// Friction of the bias spring in its guide, N.
    pub guide: f64,
}

/// Concealed effects in SI units; 0 = not there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hidden {
    /// Wind: relative rise of loss, from, until, s.
    pub wind: [f64; 3],
    /// Emissivity.
    pub emissivity: f64,
    /// Sleeve: J/K, W/K to the wire, W/K to the air.
    pub sleeve: [f64; 3],
    /// Rise of ambient, K/s.
    pub ambient_rate: f64,
    /// Share of the elastic work that becomes heat.
    pub elastic_work: f64,
    /// Resistance ahead of the taps, Ω.
    pub lead: f64,
    /// Relative rise of resistivity with stress, 1/Pa, of austenite and martensite.
    pub piezo: [f64; 2],
    /// R-phase in the resistivity: Ω m, °C, K.
    pub r_phase: [f64; 3],
    /// Drift of A and M with cycles, K.
    pub training: f64,
    /// Time constant with which the phase follows, s.
    pub lag: f64,
    /// Friction of the load, N.
    pub friction: f64,
    /// Friction over a pulley: μ times angle.
    pub capstan: f64,
    /// Strain left by a cycle.
    pub ratcheting: f64,
    /// Compliance of the frame, m/N.
    pub frame: f64,
    /// Stress that orients martensite, Pa.
    pub orienting: f64,
    /// Resistance of a joint inside V_3, Ω.
    pub joint: f64,
    /// Deflection of the probe, m/N.
    pub probe: f64,
    /// Delay of the encoder, s.
    pub delay: f64,
    /// Creep of the crimp: slip per decade, m, and its time, s.
    pub creep: [f64; 2],
    /// Moisture: heat it takes to dry, J.
    pub moisture: f64,
    /// Enclosure: heat capacity, J/K, and conductance to the room, W/K.
    pub enclosure: [f64; 2],
    /// A joint that heats: Ω per W, and its time, s.
    pub hot_joint: [f64; 2],
    /// Pickup of the PWM's edges: V of the supply times duty.
    pub pickup: f64,
    /// Share of the shape strain that the R-phase keeps back on cooling.
    pub plateau: f64,
    /// Tendon: compliance, m/N, and its time, s.
    pub tendon: [f64; 2],
    /// Detents: N and pitch, m.
    pub detents: [f64; 2],
}
