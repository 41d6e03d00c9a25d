//! The reference model's parameters as the step needs them, and its equations at one instant: compliance (eq. 4), current and
//! power, resistance (eq. 36–39), the stress of a wire that is held (eq. 23). Products that do not change are taken
//! beforehand; the formulas themselves stand in [`crate::formulas`].

use crate::effects::all::Effects;
use crate::effects::electrical::PhaseOhms;
use crate::effects::sensing::Amplifiers;
use crate::effects::thermal::Skin;
use crate::formulas;
use crate::kinetics::{Fraction, Hysteresis};
use crate::model::WireModel;
use crate::params::{Convection, Criterion, Detwinning, DriveKind, Load, Mixing, Taps};
use crate::signals::Inputs;

/// Longest step taken in one piece, in s. Longer ones are divided evenly.
const LONGEST_PIECE_S: f64 = 2.5e-3;
/// The same where temperature and the wire's end are both given, in s: a furnace ramps by 0.02 K in that time.
const LONGEST_FURNACE_PIECE_S: f64 = 0.1;
/// An oscillating load gets shorter pieces: this much phase of its oscillation, in rad …
const LONGEST_PIECE_RAD: f64 = 0.35;
/// … but never shorter ones than this, in s: then its ringing is damped rather than followed.
const SHORTEST_PIECE_S: f64 = 0.25e-3;

/// The equation of motion, or what replaces it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Motion {
    Dynamic { mass: f64, damping: f64, spring: f64, preload: f64 },
    Position,
    Force,
}

/// Parameters as the step needs them.
#[derive(Debug, Clone)]
pub(crate) struct Reference {
    pub(crate) hysteresis: Hysteresis,
    pub(crate) criterion: Criterion,
    pub(crate) detwinning: Option<Detwinning>,
    pub(crate) motion: Motion,
    pub(crate) drive: DriveKind,
    pub(crate) mixing: Mixing,
    /// 1/E_A and 1/E_M − 1/E_A (series), or E_A and E_M − E_A (parallel).
    pub(crate) stiffness_base: f64,
    pub(crate) stiffness_slope: f64,
    pub(crate) transformation_strain: f64,
    pub(crate) thermoelastic: f64,
    pub(crate) reference_c: f64,
    pub(crate) stress_shift: f64,
    pub(crate) length: f64,
    pub(crate) per_length: f64,
    pub(crate) area: f64,
    pub(crate) volume: f64,
    /// The fastest rate at which the load settles on the hot wire, 1/s.
    pub(crate) fastest_rate: f64,
    /// Longest piece of a step, s.
    pub(crate) longest_piece: f64,
    /// m c_p, J/K.
    pub(crate) heat_capacity: f64,
    /// m ΔH, J.
    pub(crate) latent: f64,
    /// The surface towards the air.
    pub(crate) skin: Skin,
    /// ρ_A0 L_0/A_c …: resistances of the unstrained wire, Ω, at T_0 and per K.
    pub(crate) austenite_ohm: f64,
    pub(crate) martensite_ohm: f64,
    pub(crate) austenite_ohm_per_k: f64,
    pub(crate) martensite_ohm_per_k: f64,
    pub(crate) series_ohm: f64,
    pub(crate) taps: Option<Taps>,
    /// Ω of the wire per Ω m of resistivity.
    pub(crate) ohm_per_resistivity: f64,
    /// A frame's strain of the wire's length per stress, 1/Pa.
    pub(crate) frame: f64,
    /// Sensors that do not show just what there is.
    pub(crate) amplifiers: Option<Amplifiers>,
}

/// The state at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) theta: f64,
    pub(crate) fraction: Fraction,
    pub(crate) temperature: f64,
    pub(crate) stress: f64,
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    pub(crate) resistance: f64,
}

impl Reference {
    pub(crate) fn new(model: &WireModel) -> Self {
        let (m, g) = (&model.material, &model.geometry);
        let area = g.area_m2();
        let effects = &model.effects;
        let ohm_per_resistivity = g.length_m / area;
        let (stiffness_base, stiffness_slope) = match m.mixing {
            Mixing::Series => {
                let austenite = 1.0 / m.austenite_modulus_pa;
                (austenite, 1.0 / m.martensite_modulus_pa - austenite)
            }
            Mixing::Parallel => (m.austenite_modulus_pa, m.martensite_modulus_pa - m.austenite_modulus_pa),
        };
        let settling = Settling::of(model);
        Reference {
            hysteresis: effects.kinetic.curves(m),
            criterion: m.criterion,
            detwinning: m.detwinning,
            motion: match model.load {
                Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } => Motion::Dynamic {
                    mass: mass_kg,
                    damping: damping_n_s_per_m,
                    spring: spring_n_per_m,
                    preload: preload_n,
                },
                Load::ImposedPosition => Motion::Position,
                Load::ImposedForce => Motion::Force,
            },
            drive: match model.drive.kind {
                // the wire is given the current that its amplifier regulates
                DriveKind::Amplifier(_) => DriveKind::Current,
                kind => kind,
            },
            mixing: m.mixing,
            stiffness_base,
            stiffness_slope,
            transformation_strain: m.transformation_strain,
            thermoelastic: m.thermoelastic_pa_per_k,
            reference_c: m.reference_temperature_c,
            stress_shift: m.stress_shift_k_per_pa,
            length: g.length_m,
            per_length: 1.0 / g.length_m,
            area,
            volume: g.volume_m3(),
            fastest_rate: settling.fastest_rate,
            longest_piece: settling.longest_piece,
            heat_capacity: model.heat_capacity_j_per_k(),
            latent: model.latent_heat_j(),
            skin: Skin {
                area: g.surface_m2(),
                loss_w_per_k: model.loss_w_per_k(1.0),
                natural: m.convection == Convection::Natural,
            },
            austenite_ohm: m.austenite_resistivity_ohm_m * ohm_per_resistivity,
            martensite_ohm: m.martensite_resistivity_ohm_m * ohm_per_resistivity,
            austenite_ohm_per_k: m.austenite_resistivity_slope_ohm_m_per_k * ohm_per_resistivity,
            martensite_ohm_per_k: m.martensite_resistivity_slope_ohm_m_per_k * ohm_per_resistivity,
            series_ohm: model.outside_ohm() + effects.sensing.contact_ohm(),
            taps: model.taps,
            ohm_per_resistivity,
            amplifiers: effects.sensing.amplifiers(),
            frame: effects.mechanical.frame_compliance.compliance_m_per_n * area / g.length_m,
        }
    }

    /// Whether the load moves by its own equation of motion.
    pub(crate) fn has_inertia(&self) -> bool {
        matches!(self.motion, Motion::Dynamic { .. })
    }

    /// Compliance C(ξ) and dC/dξ, in 1/Pa (eq. 4 or 3).
    #[inline(always)]
    pub(crate) fn compliance(&self, fraction: &Fraction) -> (f64, f64) {
        let linear = formulas::compliance(self.stiffness_base, self.stiffness_slope, fraction.martensite);
        match self.mixing {
            Mixing::Series => (linear, self.stiffness_slope),
            Mixing::Parallel => {
                let c = 1.0 / linear;
                (c, -self.stiffness_slope * c * c)
            }
        }
    }

    /// Mean electrical heating power, in W.
    pub(crate) fn power(&self, inputs: &Inputs, resistance: f64) -> f64 {
        match self.drive {
            DriveKind::Pwm => {
                let current = formulas::current_a(inputs.supply_v, resistance, self.series_ohm);
                formulas::heating_power_w(inputs.drive, current, resistance)
            }
            DriveKind::Power => inputs.drive,
            DriveKind::Current | DriveKind::Amplifier(_) => formulas::heating_power_w(1.0, inputs.drive, resistance),
            DriveKind::Temperature => 0.0,
        }
    }

    /// Current in the on-phase, in A.
    pub(crate) fn current(&self, inputs: &Inputs, resistance: f64) -> f64 {
        match self.drive {
            DriveKind::Pwm => formulas::current_a(inputs.supply_v, resistance, self.series_ohm),
            DriveKind::Power => (inputs.drive.max(0.0) / resistance).sqrt(),
            DriveKind::Current | DriveKind::Amplifier(_) => inputs.drive,
            DriveKind::Temperature => 0.0,
        }
    }

    /// Stress of a wire held at `position` (eq. 23), Pa; a wire cannot push.
    pub(crate) fn stress_held(&self, fraction: &Fraction, temperature: f64, position: f64) -> f64 {
        let (compliance, _) = self.compliance(fraction);
        let shape = self.transformation_strain * fraction.martensite;
        let thermal = compliance * self.thermoelastic * (temperature - self.reference_c);
        ((position * self.per_length - shape - thermal) / compliance).max(0.0)
    }

    /// Resistance of the unstrained wire, all of it in this phase at this temperature, in Ω (eq. 36, 37).
    #[inline(always)]
    pub(crate) fn unstrained(
        &self,
        effects: Option<&Effects>,
        fraction: &Fraction,
        temperature: f64,
        stress: f64,
    ) -> f64 {
        let warm = temperature - self.reference_c;
        let mut of = PhaseOhms {
            austenite: formulas::phase_resistivity(self.austenite_ohm, self.austenite_ohm_per_k, warm),
            martensite: formulas::phase_resistivity(self.martensite_ohm, self.martensite_ohm_per_k, warm),
        };
        if let Some(effects) = effects {
            of = effects.electrical.resistances(of, stress, temperature, self.ohm_per_resistivity);
        }
        formulas::mixture(fraction.austenite, fraction.martensite, of.austenite, of.martensite)
    }
}

/// θ that makes the θ-method exact for e^(−z): ½ for slow motion, 1 for motion that is over within the step.
pub(crate) fn fitted_implicitness(z: f64) -> f64 {
    if z < 1e-2 { 0.5 + z / 12.0 } else { 1.0 / -(-z).exp_m1() - 1.0 / z }
}

/// How the load settles on the stiffest state of its wire.
struct Settling {
    /// The fastest decay of an overdamped load, or the angular frequency of an oscillating one, 1/s.
    fastest_rate: f64,
    /// Longest piece that follows it, s.
    longest_piece: f64,
}

impl Settling {
    fn of(model: &WireModel) -> Self {
        let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, .. } = model.load else {
            // in a furnace with its end held nothing has a time of its own: the phase is a closed form from reversal to
            // reversal, and only effects that lag by a piece ask for short ones
            let furnace = model.drive.kind == DriveKind::Temperature;
            let longest_piece = if furnace { LONGEST_FURNACE_PIECE_S } else { LONGEST_PIECE_S };
            return Settling { fastest_rate: 0.0, longest_piece };
        };
        let square = (spring_n_per_m + model.stiffest_n_per_m()) / mass_kg;
        let half = 0.5 * damping_n_s_per_m / mass_kg;
        if half * half > square {
            Settling { fastest_rate: half + (half * half - square).sqrt(), longest_piece: LONGEST_PIECE_S }
        } else {
            let frequency = square.sqrt();
            let longest_piece = (LONGEST_PIECE_RAD / frequency).clamp(SHORTEST_PIECE_S, LONGEST_PIECE_S);
            Settling { fastest_rate: frequency, longest_piece }
        }
    }
}
