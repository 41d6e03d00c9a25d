//! The equations of one wire at one instant: heat (eq. 48), motion (eq. 51), strain (eq. 23) and resistance (eq. 36–39),
//! for a trial value of the driving temperature at the end of a piece of time.

use crate::kinetics::{Fraction, Hysteresis, Point};
use crate::params::{Convection, DriveKind, Load, Mixing, Taps, WireModel};
use crate::signals::Inputs;

/// Longest step taken in one piece, in s. Longer ones are divided evenly.
const LONGEST_PIECE_S: f64 = 2.5e-3;
/// An oscillating load gets shorter pieces: this much phase of its oscillation, in rad …
const LONGEST_PIECE_RAD: f64 = 0.35;
/// … but never shorter ones than this, in s: then its ringing is damped rather than followed.
const SHORTEST_PIECE_S: f64 = 0.25e-3;

/// The residual falls with ϑ at least this fast, K/K, unless a kinetics law has a kink.
const LEAST_SLOPE: f64 = -1e-3;

/// The equation of motion, or what replaces it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Motion {
    Dynamic { mass: f64, damping: f64, spring: f64, preload: f64 },
    Position,
    Force,
}

/// Parameters as the step needs them.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    pub(crate) hysteresis: Hysteresis,
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
    /// h A_s, W/K; with natural convection its value at 1 K.
    pub(crate) loss_w_per_k: f64,
    pub(crate) natural_convection: bool,
    /// ρ_A0 L_0/A_c …: resistances of the unstrained wire, Ω, at T_0 and per K.
    pub(crate) austenite_ohm: f64,
    pub(crate) martensite_ohm: f64,
    pub(crate) austenite_ohm_per_k: f64,
    pub(crate) martensite_ohm_per_k: f64,
    pub(crate) series_ohm: f64,
    pub(crate) taps: Option<Taps>,
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

/// What the end of a piece is solved from, with the equation of motion reduced to what the stress must satisfy.
pub(crate) struct Stage {
    /// h/2: the weight of the end in the heat balance, s.
    pub(crate) heat_tau: f64,
    /// θh: the weight of the end in the equation of motion, s.
    pub(crate) motion_tau: f64,
    /// m c_p T with the heat of the start, J.
    pub(crate) heat_base: f64,
    /// x with the movement of the start, or the imposed x, m.
    pub(crate) position_base: f64,
    /// M + B τ + K τ².
    pub(crate) inertia: f64,
    /// What moves the load without the wire, over τ².
    pub(crate) push: f64,
    /// A_c τ²: movement per stress, times inertia.
    pub(crate) give: f64,
    /// Imposed tension, N.
    pub(crate) force: f64,
    /// Imposed temperature, °C.
    pub(crate) temperature: f64,
}

/// One evaluation of the coupled equations at a trial ϑ.
pub(crate) struct Trial {
    pub(crate) state: State,
    pub(crate) power: f64,
    pub(crate) loss: f64,
    /// Latent heat and work given off by the change of ξ in this stage, J.
    pub(crate) released: f64,
    pub(crate) work: f64,
    pub(crate) residual: f64,
    /// How much of a stress change the load does not give way to: 1 with fixed ends.
    pub(crate) follow: f64,
}
impl Balance {
    pub(crate) fn new(model: &WireModel) -> Self {
        let (m, g) = (&model.material, &model.geometry);
        let area = g.area_m2();
        let ohm_per_resistivity = g.length_m / area;
        let mass = m.density_kg_per_m3 * g.volume_m3();
        let (stiffness_base, stiffness_slope) = match m.mixing {
            Mixing::Series => {
                let austenite = 1.0 / m.austenite_modulus_pa;
                (austenite, 1.0 / m.martensite_modulus_pa - austenite)
            }
            Mixing::Parallel => (m.austenite_modulus_pa, m.martensite_modulus_pa - m.austenite_modulus_pa),
        };
        let convection = match m.convection {
            Convection::Constant => m.convection_w_per_m2_k,
            Convection::Natural => 65.5 * (-0.25 * g.diameter_m * 1e3).exp(), // eq. 34
        };
        let settling = Settling::of(model);
        Balance {
            hysteresis: Hysteresis::new(m),
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
            drive: model.drive.kind,
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
            heat_capacity: mass * m.specific_heat_j_per_kg_k,
            latent: mass * m.latent_heat_j_per_kg,
            loss_w_per_k: convection * g.surface_m2(),
            natural_convection: m.convection == Convection::Natural,
            austenite_ohm: m.austenite_resistivity_ohm_m * ohm_per_resistivity,
            martensite_ohm: m.martensite_resistivity_ohm_m * ohm_per_resistivity,
            austenite_ohm_per_k: m.austenite_resistivity_slope_ohm_m_per_k * ohm_per_resistivity,
            martensite_ohm_per_k: m.martensite_resistivity_slope_ohm_m_per_k * ohm_per_resistivity,
            series_ohm: model.drive.shunt_ohm + model.drive.switch_ohm + model.drive.lead_ohm,
            taps: model.taps,
        }
    }

    /// Whether the load moves by its own equation of motion.
    pub(crate) fn has_inertia(&self) -> bool {
        matches!(self.motion, Motion::Dynamic { .. })
    }

    /// Compliance C(ξ) and dC/dξ, in 1/Pa (eq. 4 or 3).
    #[inline(always)]
    pub(crate) fn compliance(&self, fraction: &Fraction) -> (f64, f64) {
        let linear = self.stiffness_base + self.stiffness_slope * fraction.martensite;
        match self.mixing {
            Mixing::Series => (linear, self.stiffness_slope),
            Mixing::Parallel => {
                let c = 1.0 / linear;
                (c, -self.stiffness_slope * c * c)
            }
        }
    }

    /// Loss coefficient h A_s at `temperature`, in W/K.
    pub(crate) fn loss_coefficient(&self, temperature: f64, ambient: f64) -> f64 {
        if self.natural_convection {
            self.loss_w_per_k * (temperature - ambient).abs().powf(1.0 / 6.0)
        } else {
            self.loss_w_per_k
        }
    }

    /// Mean electrical heating power, in W.
    pub(crate) fn power(&self, inputs: &Inputs, resistance: f64) -> f64 {
        match self.drive {
            DriveKind::Pwm => {
                let current = inputs.supply_v / (resistance + self.series_ohm);
                inputs.drive * current * current * resistance
            }
            DriveKind::Power => inputs.drive,
            DriveKind::Current => inputs.drive * inputs.drive * resistance,
            DriveKind::Temperature => 0.0,
        }
    }

    /// Current in the on-phase, in A.
    pub(crate) fn current(&self, inputs: &Inputs, resistance: f64) -> f64 {
        match self.drive {
            DriveKind::Pwm => inputs.supply_v / (resistance + self.series_ohm),
            DriveKind::Power => (inputs.drive.max(0.0) / resistance).sqrt(),
            DriveKind::Current => inputs.drive,
            DriveKind::Temperature => 0.0,
        }
    }

    /// Strain of the wire itself: that of its ends, or its own when it hangs slack between them.
    pub(crate) fn strain(&self, state: &State) -> f64 {
        let ends = state.position * self.per_length;
        if state.stress > 0.0 { ends } else { ends.max(self.free_strain(&state.fraction, state.temperature)) }
    }

    /// Strain without stress (eq. 23 at σ = 0).
    pub(crate) fn free_strain(&self, fraction: &Fraction, temperature: f64) -> f64 {
        let (compliance, _) = self.compliance(fraction);
        self.transformation_strain * fraction.martensite
            + compliance * self.thermoelastic * (temperature - self.reference_c)
    }

    /// R = ρL/A_c (eq. 36, 37, 39), in Ω.
    pub(crate) fn resistance(&self, state: &State) -> f64 {
        let warm = state.temperature - self.reference_c;
        let austenite = self.austenite_ohm + self.austenite_ohm_per_k * warm;
        let martensite = self.martensite_ohm + self.martensite_ohm_per_k * warm;
        let unstrained = state.fraction.austenite * austenite + state.fraction.martensite * martensite;
        // a straight line in T reaches zero somewhere; no wire does
        unstrained.max(1e-3 * self.austenite_ohm) * (1.0 + self.strain(state))
    }

    /// The wire at rest at `temperature`, its phase clipped into the outer curves at the stress it then has.
    pub(crate) fn at_rest(&self, temperature: f64, asked: Fraction, inputs: &Inputs) -> State {
        let stress = |fraction: &Fraction| -> f64 {
            let (compliance, _) = self.compliance(fraction);
            let free = self.free_strain(fraction, temperature);
            let taut = match self.motion {
                Motion::Dynamic { spring, preload, .. } => {
                    (preload + inputs.external_n - spring * self.length * free)
                        / (self.area + spring * self.length * compliance)
                }
                Motion::Position => (inputs.imposed / self.length - free) / compliance,
                Motion::Force => inputs.imposed / self.area,
            };
            taut.max(0.0)
        };
        let all_austenite = Fraction { martensite: 0.0, austenite: 1.0 };
        let all_martensite = Fraction { martensite: 1.0, austenite: 0.0 };
        let most = stress(&all_austenite).max(stress(&all_martensite));
        // T − σ(ξ(ϑ))/α − ϑ falls with ϑ: less martensite, more stress
        let (mut low, mut high) = (temperature - self.stress_shift * most, temperature);
        for _ in 0..80 {
            let theta = 0.5 * (low + high);
            let fraction = self.hysteresis.clip(asked, theta);
            if temperature - self.stress_shift * stress(&fraction) > theta { low = theta } else { high = theta }
        }
        let theta = 0.5 * (low + high);
        let fraction = self.hysteresis.clip(asked, theta);
        let stress = stress(&fraction);
        let (compliance, _) = self.compliance(&fraction);
        let wire_end = self.length * (self.free_strain(&fraction, temperature) + compliance * stress);
        let position = match self.motion {
            Motion::Position => inputs.imposed,
            // a slack wire does not say where the load is: its spring does
            Motion::Dynamic { spring, preload, .. } if stress == 0.0 && spring > 0.0 => {
                (preload + inputs.external_n) / spring
            }
            _ => wire_end,
        };
        let mut state =
            State { theta, fraction, temperature, stress, position, velocity: 0.0, resistance: self.austenite_ohm };
        state.resistance = self.resistance(&state);
        state
    }

    /// What the equation of motion asks of the stress at the end of a piece:
    /// σ (inertia C + give/L_0) = inertia (C θ (T_0 − T) + x/L_0 − ε_L ξ) + push/L_0.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn stage(
        &self,
        inputs: &Inputs,
        start: &State,
        h: f64,
        implicitness: f64,
        heat_base: f64,
        imposed: f64,
        furnace: f64,
    ) -> Stage {
        let tau = implicitness * h;
        let (inertia, push, give, position_base) = match self.motion {
            Motion::Dynamic { mass, damping, spring, preload } => {
                // M ẍ + B ẋ + K x = F − A_c σ by the θ-method, times τ²
                let early = h - tau;
                let force = preload + inputs.external_n;
                let pull = force - damping * start.velocity - spring * start.position - self.area * start.stress;
                let position_base = start.position + early * start.velocity;
                let momentum_base = mass * start.velocity + early * pull;
                let inertia = mass + tau * (damping + tau * spring);
                let push = tau * (tau * (force - spring * position_base) + momentum_base);
                (inertia, push, tau * tau * self.area, position_base)
            }
            Motion::Position => (1.0, 0.0, 0.0, imposed),
            Motion::Force => (1.0, 0.0, 0.0, 0.0),
        };
        Stage {
            heat_tau: 0.5 * h,
            motion_tau: tau,
            heat_base,
            position_base,
            inertia,
            push,
            give,
            force: imposed,
            temperature: furnace,
        }
    }

    /// All equations at the end of `stage` for a trial ϑ with its phase `point`. Temperature and resistance of the last
    /// trial serve where a coefficient depends on them.
    #[inline(always)]
    pub(crate) fn trial(
        &self,
        inputs: &Inputs,
        stage: &Stage,
        from: &State,
        theta: f64,
        point: &Point,
        guess: (f64, f64),
    ) -> Trial {
        let (temperature_guess, resistance_guess) = guess;
        let tau = stage.heat_tau;
        let fraction = point.fraction;
        let (compliance, _) = self.compliance(&fraction);
        let shape = self.transformation_strain * fraction.martensite;
        // σ = (pull − follow θ T) / hold
        let (mut pull, mut follow, hold) = match self.motion {
            Motion::Force => ((stage.force / self.area).max(0.0), 0.0, 1.0),
            _ => {
                let follow = stage.inertia * compliance;
                let stretch = stage.position_base * self.per_length - shape;
                let pull = stage.inertia * stretch
                    + follow * self.thermoelastic * self.reference_c
                    + stage.push * self.per_length;
                (pull, follow, follow + stage.give * self.per_length)
            }
        };
        // heat balance (eq. 48), with the work of transformation by the trapezoidal rule
        let change = fraction.change_from(&from.fraction);
        let half_work = 0.5 * self.volume * self.transformation_strain * change;
        let loss_coefficient = self.loss_coefficient(temperature_guess, inputs.ambient_c);
        let power = self.power(inputs, resistance_guess);
        let capacity = self.heat_capacity + tau * loss_coefficient;
        let heat = stage.heat_base
            + tau * (power + loss_coefficient * inputs.ambient_c)
            + self.latent * change
            + half_work * from.stress;
        let furnace = self.drive == DriveKind::Temperature;
        let temperature_at = |pull: f64, follow: f64| {
            if furnace {
                stage.temperature
            } else {
                (heat * hold + half_work * pull) / (capacity * hold + half_work * follow * self.thermoelastic)
            }
        };
        let mut temperature = temperature_at(pull, follow);
        let mut stress = (pull - follow * self.thermoelastic * temperature) / hold;
        if stress < 0.0 {
            // slack: a wire cannot push
            (pull, follow, stress) = (0.0, 0.0, 0.0);
            temperature = temperature_at(pull, follow);
        }
        let (position, velocity) = match self.motion {
            Motion::Dynamic { .. } => {
                let moved = (stage.push - stage.give * stress) / stage.inertia;
                (stage.position_base + moved, moved / stage.motion_tau)
            }
            Motion::Position => (stage.position_base, 0.0),
            Motion::Force => {
                let thermal = self.thermoelastic * (temperature - self.reference_c);
                (self.length * (shape + compliance * (stress + thermal)), 0.0)
            }
        };
        let mut state =
            State { theta, fraction, temperature, stress, position, velocity, resistance: resistance_guess };
        state.resistance = self.resistance(&state);
        let work = half_work * (from.stress + stress);
        Trial {
            state,
            power,
            loss: loss_coefficient * (temperature - inputs.ambient_c),
            released: self.latent * change + work,
            work,
            residual: temperature - self.stress_shift * stress - theta,
            follow: follow / hold,
        }
    }

    /// How fast the residual of `trial` falls with ϑ where ξ has the given slope: the guide of Newton's method.
    pub(crate) fn residual_slope(&self, stage: &Stage, from: &State, trial: &Trial, slope: f64) -> f64 {
        let state = &trial.state;
        let heat_per_fraction = if self.drive == DriveKind::Temperature {
            0.0
        } else {
            let work = 0.5 * self.volume * self.transformation_strain * (from.stress + state.stress);
            (self.latent + work) / (self.heat_capacity + stage.heat_tau * self.loss_w_per_k)
        };
        // d/dξ of C σ = x/L_0 − ε_L ξ − C θ (T − T_0), the ends giving way
        let (compliance, compliance_slope) = self.compliance(&state.fraction);
        let thermal = self.thermoelastic * (state.temperature - self.reference_c);
        let stress_per_fraction = -trial.follow
            * ((self.transformation_strain + compliance_slope * (state.stress + thermal)) / compliance
                + self.thermoelastic * heat_per_fraction);
        let gain = heat_per_fraction - self.stress_shift * stress_per_fraction;
        (gain * slope - 1.0).min(LEAST_SLOPE)
    }
}

/// How the load settles on the stiffest state of its wire.
pub(crate) struct Settling {
    /// The fastest decay of an overdamped load, or the angular frequency of an oscillating one, 1/s.
    fastest_rate: f64,
    /// Longest piece that follows it, s.
    longest_piece: f64,
}

impl Settling {
    pub(crate) fn of(model: &WireModel) -> Self {
        let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, .. } = model.load else {
            return Settling { fastest_rate: 0.0, longest_piece: LONGEST_PIECE_S };
        };
        let (m, g) = (&model.material, &model.geometry);
        let stiffest = m.austenite_modulus_pa.max(m.martensite_modulus_pa);
        let square = (spring_n_per_m + stiffest * g.area_m2() / g.length_m) / mass_kg;
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
