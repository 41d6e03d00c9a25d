//! One wire with its load and its heating circuit, stepped through time.
//!
//! A step solves temperature, phase, stress and motion together. The unknown is the driving temperature ϑ at the end:
//! given it, the phase is a closed form (see [`crate::kinetics`]), the heat balance and the equation of motion are
//! linear, and what is left is one monotone equation T(ϑ) − σ(ϑ)/α = ϑ, solved by Newton inside a bracket.
//! In time the method is the trapezoidal rule, for the load exponentially fitted to its fastest rate (Liniger and
//! Willoughby, 1970): second order, and light loads on stiff wires settle instead of ringing. Latent heat is paid for
//! every change of ξ, whatever the step.

use crate::Error;
use crate::kinetics::{Branch, Direction, Fraction, Hysteresis, Point};
use crate::params::{Convection, DriveKind, Load, Mixing, Taps, WireModel};

/// Longest step taken in one piece, in s. Longer ones are divided evenly.
const LONGEST_PIECE_S: f64 = 2.5e-3;
/// An oscillating load gets shorter pieces: this much phase of its oscillation, in rad …
const LONGEST_PIECE_RAD: f64 = 0.35;
/// … but never shorter ones than this, in s: then its ringing is damped rather than followed.
const SHORTEST_PIECE_S: f64 = 0.25e-3;
/// Below this nothing moves, in K: 10⁻¹¹ m on a 160 mm wire.
const THETA_TOLERANCE_K: f64 = 1e-7;
/// ϑ is solved to this share of its movement in the stage. What is left does not add up over steps: phase, heat and
/// force are exact for the ϑ accepted, which lags by a thousandth of a step.
const THETA_TOLERANCE: f64 = 1e-3;
/// The residual falls with ϑ at least this fast, K/K, unless a kinetics law has a kink.
const LEAST_SLOPE: f64 = -1e-3;
/// More than Newton inside a bracket ever needs; bisection alone would reach the tolerance from 10⁴ K in 37.
const MOST_ITERATIONS: u32 = 60;

/// What acts on the wire during a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Duty 0..1, power in W, current in A or temperature in °C, by the drive's kind. A temperature is reached at the
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
    /// Loss to the air ∫h A_s (T − T_∞) dt.
    pub loss_j: f64,
    /// Sensible heat m c_p (T − T_start).
    pub sensible_j: f64,
    /// Latent heat taken up by forming austenite, m ΔH (ξ_start − ξ).
    pub latent_j: f64,
    /// Mechanical work of transformation, −∫A_c L_0 σ ε_L dξ.
    pub work_j: f64,
}

impl EnergyBalance {
    /// What does not add up, in J: rounding, if the equations are solved as written.
    pub fn residual_j(&self) -> f64 {
        self.heat_in_j - self.loss_j - self.sensible_j - self.latent_j - self.work_j
    }
}

/// The equation of motion, or what replaces it.
#[derive(Debug, Clone, Copy)]
enum Motion {
    Dynamic { mass: f64, damping: f64, spring: f64, preload: f64 },
    Position,
    Force,
}

/// Parameters as the step needs them.
#[derive(Debug, Clone)]
struct Constants {
    hysteresis: Hysteresis,
    motion: Motion,
    drive: DriveKind,
    mixing: Mixing,
    /// 1/E_A and 1/E_M − 1/E_A (series), or E_A and E_M − E_A (parallel).
    stiffness_base: f64,
    stiffness_slope: f64,
    transformation_strain: f64,
    thermoelastic: f64,
    reference_c: f64,
    stress_shift: f64,
    length: f64,
    per_length: f64,
    area: f64,
    volume: f64,
    /// The fastest rate at which the load settles on the hot wire, 1/s.
    fastest_rate: f64,
    /// Longest piece of a step, s.
    longest_piece: f64,
    /// m c_p, J/K.
    heat_capacity: f64,
    /// m ΔH, J.
    latent: f64,
    /// h A_s, W/K; with natural convection its value at 1 K.
    loss_w_per_k: f64,
    natural_convection: bool,
    /// ρ_A0 L_0/A_c …: resistances of the unstrained wire, Ω, at T_0 and per K.
    austenite_ohm: f64,
    martensite_ohm: f64,
    austenite_ohm_per_k: f64,
    martensite_ohm_per_k: f64,
    series_ohm: f64,
    taps: Option<Taps>,
}

/// The state at one instant.
#[derive(Debug, Clone, Copy)]
struct State {
    theta: f64,
    fraction: Fraction,
    temperature: f64,
    stress: f64,
    position: f64,
    velocity: f64,
    resistance: f64,
}

/// What the end of a piece is solved from, with the equation of motion reduced to what the stress must satisfy.
struct Stage {
    /// h/2: the weight of the end in the heat balance, s.
    heat_tau: f64,
    /// θh: the weight of the end in the equation of motion, s.
    motion_tau: f64,
    /// m c_p T with the heat of the start, J.
    heat_base: f64,
    /// x with the movement of the start, or the imposed x, m.
    position_base: f64,
    /// M + B τ + K τ².
    inertia: f64,
    /// What moves the load without the wire, over τ².
    push: f64,
    /// A_c τ²: movement per stress, times inertia.
    give: f64,
    /// Imposed tension, N.
    force: f64,
    /// Imposed temperature, °C.
    temperature: f64,
}

/// One evaluation of the coupled equations at a trial ϑ.
struct Trial {
    state: State,
    power: f64,
    loss: f64,
    /// Latent heat and work given off by the change of ξ in this stage, J.
    released: f64,
    work: f64,
    residual: f64,
    /// How much of a stress change the load does not give way to: 1 with fixed ends.
    follow: f64,
}

/// A wire in its load and circuit. Cloning it forks the simulation.
#[derive(Debug, Clone)]
pub struct Wire {
    constants: Constants,
    state: State,
    branch: Option<Branch>,
    /// dϑ/dt over the last two pieces, K/s: they give the guess for the next.
    theta_rates: [f64; 2],
    /// The piece length that `implicitness` belongs to, s.
    fitted_to: f64,
    /// θ of the fitted method: how much of the load's motion is taken from the end of a piece, ½..1.
    implicitness: f64,
    /// The inputs at the end of the last step: imposed quantities run from there.
    imposed: f64,
    power: f64,
    current: f64,
    started: State,
    energy: EnergyBalance,
}

impl WireModel {
    /// Drive off (an imposed temperature stays at its start), nominal supply and ambient, nothing pulling; an imposed
    /// position or force is 0.
    pub fn rest_inputs(&self) -> Inputs {
        let drive = match self.drive.kind {
            DriveKind::Temperature => self.initial.temperature_c.unwrap_or(self.ambient_c),
            _ => 0.0,
        };
        Inputs { drive, supply_v: self.drive.supply_v, ambient_c: self.ambient_c, external_n: 0.0, imposed: 0.0 }
    }
}

impl Wire {
    /// The wire at rest in its load, at its initial temperature and phase, with nothing imposed.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its physical range.
    pub fn new(model: &WireModel) -> Result<Wire, Error> {
        Wire::with_inputs(model, &model.rest_inputs())
    }

    /// The wire at rest under the first inputs of a recording: their imposed temperature, position or force, their
    /// ambient and their external force.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if a parameter is outside its physical range.
    pub fn with_inputs(model: &WireModel, first: &Inputs) -> Result<Wire, Error> {
        model.validate()?;
        let constants = Constants::new(model);
        let temperature = model.initial.temperature_c.unwrap_or(match model.drive.kind {
            DriveKind::Temperature => first.drive,
            _ => first.ambient_c,
        });
        let asked = Fraction::of_martensite(model.initial.martensite);
        let state = constants.at_rest(temperature, asked, first);
        let mut wire = Wire {
            constants,
            state,
            branch: None,
            theta_rates: [0.0; 2],
            fitted_to: 0.0,
            implicitness: 0.5,
            imposed: first.imposed,
            power: 0.0,
            current: 0.0,
            started: state,
            energy: EnergyBalance::default(),
        };
        wire.current = wire.constants.current(first, state.resistance);
        Ok(wire)
    }

    /// Advances by `dt_s` under `inputs`. The answer does not depend on how a span is cut into steps, but for the
    /// second-order error of pieces of at most 2.5 ms. Steps of 10 µs to 10 ms are what it is made for; longer ones are
    /// divided the same way. A zero, negative or non-finite step does nothing.
    pub fn step(&mut self, inputs: &Inputs, dt_s: f64) {
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return;
        }
        let pieces = (dt_s / self.constants.longest_piece - 1e-9).ceil().max(1.0);
        let h = dt_s / pieces;
        let imposed_rate = (inputs.imposed - self.imposed) / dt_s;
        let temperature_rate = match self.constants.drive {
            DriveKind::Temperature => (inputs.drive - self.state.temperature) / dt_s,
            _ => 0.0,
        };
        let mut heat_in = 0.0;
        // a count, not `elapsed < dt`: rounding must not add a piece
        let mut piece = 0.0;
        while piece < pieces {
            heat_in += self.piece(inputs, h, imposed_rate, temperature_rate);
            piece += 1.0;
        }
        self.imposed = inputs.imposed;
        self.power = heat_in / dt_s;
        self.current = self.constants.current(inputs, self.state.resistance);
        self.energy.heat_in_j += heat_in;
        let c = &self.constants;
        self.energy.sensible_j = c.heat_capacity * (self.state.temperature - self.started.temperature);
        self.energy.latent_j = -c.latent * self.state.fraction.change_from(&self.started.fraction);
    }

    /// One piece of length `h`; returns the electrical heat, J.
    fn piece(&mut self, inputs: &Inputs, h: f64, imposed_rate: f64, temperature_rate: f64) -> f64 {
        if h != self.fitted_to {
            self.fitted_to = h;
            self.implicitness = fitted_implicitness(h * self.constants.fastest_rate);
        }
        let c = &self.constants;
        let start = self.state;
        let half = 0.5 * h;
        let power = c.power(inputs, start.resistance);
        let loss = c.loss_coefficient(start.temperature, inputs.ambient_c) * (start.temperature - inputs.ambient_c);
        let heat_base = c.heat_capacity * start.temperature + half * (power - loss);
        let imposed = self.imposed + imposed_rate * h;
        let furnace = start.temperature + temperature_rate * h;
        let stage = c.stage(inputs, &start, h, self.implicitness, heat_base, imposed, furnace);
        let end = self.solve(inputs, &stage, h);
        if !matches!(self.constants.motion, Motion::Dynamic { .. }) {
            self.state.velocity = (self.state.position - start.position) / h;
        }
        self.imposed = imposed;
        let lost = half * (loss + end.loss);
        self.energy.loss_j += lost;
        self.energy.work_j -= end.work;
        if self.constants.drive == DriveKind::Temperature {
            // the furnace supplies whatever the imposed temperature takes
            self.constants.heat_capacity * (end.state.temperature - start.temperature) - end.released + lost
        } else {
            half * (power + end.power)
        }
    }

    /// Solves the piece of length `h` from the present state and moves there.
    fn solve(&mut self, inputs: &Inputs, stage: &Stage, h: f64) -> Trial {
        let from = self.state;
        let [before, last] = self.theta_rates;
        let trial = match self.carry_on(inputs, stage, (2.0 * last - before) * h) {
            Some(trial) => trial,
            None => self.set_out(inputs, stage),
        };
        self.theta_rates = [last, (trial.state.theta - from.theta) / h];
        self.state = trial.state;
        trial
    }

    /// The usual case: ϑ goes on as before, so Newton from the extrapolated ϑ on the same branch needs one or two
    /// trials. The residual has one zero, so one found on the branch's side of the present ϑ is the solution; anything
    /// else is left to [`Wire::set_out`].
    fn carry_on(&mut self, inputs: &Inputs, stage: &Stage, expected: f64) -> Option<Trial> {
        let c = &self.constants;
        let from = &self.state;
        let mut branch = self.branch?;
        let forward = match branch.direction() {
            Direction::Heating => 1.0,
            Direction::Cooling => -1.0,
        };
        let mut theta = from.theta + expected;
        let mut guess = (from.temperature, from.resistance);
        for _ in 0..4 {
            if (theta - from.theta) * forward <= THETA_TOLERANCE_K {
                return None;
            }
            let point = c.hysteresis.on_branch(&branch, theta);
            let trial = c.trial(inputs, stage, from, theta, &point, guess);
            if is_solved(&trial, from.theta) {
                if point.outer {
                    branch.ride_outer();
                    self.branch = Some(branch);
                }
                return Some(trial);
            }
            theta -= trial.residual / c.residual_slope(stage, from, &trial, point.slope);
            guess = (trial.state.temperature, trial.state.resistance);
        }
        None
    }

    /// From standing: finds the direction, reverses the branch if it must, and solves by Newton inside a bracket.
    fn set_out(&mut self, inputs: &Inputs, stage: &Stage) -> Trial {
        let c = &self.constants;
        let from = &self.state;
        let still = Point { fraction: from.fraction, slope: 0.0, outer: false };
        let mut trial = c.trial(inputs, stage, from, from.theta, &still, (from.temperature, from.resistance));
        // the residual falls with ϑ, so its sign where we stand is the direction of motion
        if trial.residual.abs() <= THETA_TOLERANCE_K {
            return trial;
        }
        let direction = if trial.residual > 0.0 { Direction::Heating } else { Direction::Cooling };
        let mut branch = match self.branch {
            Some(branch) if branch.direction() == direction => branch,
            _ => c.hysteresis.reverse(direction, from.theta, &from.fraction),
        };
        // the near end of the bracket is where we stand; the far end is found on the way
        let (mut low, mut high) = match direction {
            Direction::Heating => (from.theta, f64::INFINITY),
            Direction::Cooling => (f64::NEG_INFINITY, from.theta),
        };
        let mut theta = from.theta;
        let mut point = c.hysteresis.on_branch(&branch, theta);
        for _ in 0..MOST_ITERATIONS {
            let mut next = theta - trial.residual / c.residual_slope(stage, from, &trial, point.slope);
            if !(next > low && next < high) {
                next = if low.is_finite() && high.is_finite() {
                    0.5 * (low + high)
                } else {
                    // the slope was no guide: the bare residual leads past the solution
                    theta + 2.0 * trial.residual
                };
            }
            let moved = next - theta;
            theta = next;
            point = c.hysteresis.on_branch(&branch, theta);
            trial = c.trial(inputs, stage, from, theta, &point, (trial.state.temperature, trial.state.resistance));
            if trial.residual > 0.0 {
                low = theta;
            } else {
                high = theta;
            }
            if is_solved(&trial, from.theta) || moved.abs() <= 1e-3 * THETA_TOLERANCE_K {
                break;
            }
        }
        if point.outer {
            branch.ride_outer();
        }
        self.branch = Some(branch);
        trial
    }
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

/// θ that makes the θ-method exact for e^(−z): ½ for slow motion, 1 for motion that is over within the step.
fn fitted_implicitness(z: f64) -> f64 {
    if z < 1e-2 { 0.5 + z / 12.0 } else { 1.0 / -(-z).exp_m1() - 1.0 / z }
}

/// The trial is close enough to the solution, seen from where the stage started.
fn is_solved(trial: &Trial, start_theta: f64) -> bool {
    trial.residual.abs() <= THETA_TOLERANCE_K + THETA_TOLERANCE * (trial.state.theta - start_theta).abs()
}

impl Wire {
    /// What sensors see now, in the on-phase under the supply of the last step.
    pub fn outputs(&self) -> Outputs {
        let (s, c) = (&self.state, &self.constants);
        let voltage = self.current * s.resistance;
        // taps are fixed in space: the wire between fixed end and tap is the same share of the whole as l of L (eq. 42)
        let per_metre = voltage / (c.length * (1.0 + c.strain(s)));
        let (v1, v2) = match c.taps {
            Some(taps) => (per_metre * taps.l0_m, per_metre * (taps.l0_m + taps.ls_m)),
            None => (0.0, 0.0),
        };
        Outputs {
            current_a: self.current,
            v1_v: v1,
            v2_v: v2,
            v3_v: voltage,
            force_n: c.area * s.stress,
            position_m: s.position,
            temperature_c: s.temperature,
            martensite: s.fraction.martensite,
            power_w: self.power,
            resistance_ohm: s.resistance,
        }
    }

    /// Wire temperature T, in °C.
    pub fn temperature_c(&self) -> f64 {
        self.state.temperature
    }

    /// Martensite fraction ξ, 0..1.
    pub fn martensite(&self) -> f64 {
        self.state.fraction.martensite
    }

    /// The phase mixture, both parts to full resolution.
    pub fn fraction(&self) -> Fraction {
        self.state.fraction
    }

    /// Driving temperature ϑ = T − σ/α, in °C.
    pub fn driving_temperature_c(&self) -> f64 {
        self.state.theta
    }

    /// Elongation x = L − L_0, in m.
    pub fn position_m(&self) -> f64 {
        self.state.position
    }

    /// Speed ẋ of the moving end, in m/s; with an imposed load the mean over the last piece of a step.
    pub fn velocity_m_s(&self) -> f64 {
        self.state.velocity
    }

    /// Stress σ, in Pa.
    pub fn stress_pa(&self) -> f64 {
        self.state.stress
    }

    /// Resistance R, in Ω.
    pub fn resistance_ohm(&self) -> f64 {
        self.state.resistance
    }

    /// The energy ledger since the start.
    pub fn energy(&self) -> EnergyBalance {
        self.energy
    }

    /// The outer curves of this wire.
    pub fn hysteresis(&self) -> &Hysteresis {
        &self.constants.hysteresis
    }
}

/// Length L of the cold wire at rest in its load, all martensite at ambient, in m.
///
/// # Errors
/// [`Error::OutOfRange`] if a parameter is outside its physical range.
pub fn cold_length_m(model: &WireModel) -> Result<f64, Error> {
    model.validate()?;
    let c = Constants::new(model);
    let state = c.at_rest(model.ambient_c, Fraction::of_martensite(1.0), &model.rest_inputs());
    Ok(c.length + state.position)
}

/// Length L of the hot wire at rest in its load, in m: transformed to austenite, 40 K above where the load's stress has
/// moved A to.
///
/// # Errors
/// [`Error::OutOfRange`] if a parameter is outside its physical range.
pub fn hot_length_m(model: &WireModel) -> Result<f64, Error> {
    model.validate()?;
    let c = Constants::new(model);
    let inputs = model.rest_inputs();
    let mut stress = 0.0;
    let mut position = 0.0;
    // stress moves A, and the hotter wire is stiffer: settles in two or three rounds
    for _ in 0..8 {
        let temperature = model.material.austenite_temperature_c + stress * c.stress_shift + 40.0;
        let state = c.at_rest(temperature, Fraction::of_martensite(0.0), &inputs);
        (stress, position) = (state.stress, state.position);
    }
    Ok(c.length + position)
}

impl Constants {
    fn new(model: &WireModel) -> Self {
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
        Constants {
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

    /// Compliance C(ξ) and dC/dξ, in 1/Pa (eq. 4 or 3).
    #[inline(always)]
    fn compliance(&self, fraction: &Fraction) -> (f64, f64) {
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
    fn loss_coefficient(&self, temperature: f64, ambient: f64) -> f64 {
        if self.natural_convection {
            self.loss_w_per_k * (temperature - ambient).abs().powf(1.0 / 6.0)
        } else {
            self.loss_w_per_k
        }
    }

    /// Mean electrical heating power, in W.
    fn power(&self, inputs: &Inputs, resistance: f64) -> f64 {
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
    fn current(&self, inputs: &Inputs, resistance: f64) -> f64 {
        match self.drive {
            DriveKind::Pwm => inputs.supply_v / (resistance + self.series_ohm),
            DriveKind::Power => (inputs.drive.max(0.0) / resistance).sqrt(),
            DriveKind::Current => inputs.drive,
            DriveKind::Temperature => 0.0,
        }
    }

    /// Strain of the wire itself: that of its ends, or its own when it hangs slack between them.
    fn strain(&self, state: &State) -> f64 {
        let ends = state.position * self.per_length;
        if state.stress > 0.0 { ends } else { ends.max(self.free_strain(&state.fraction, state.temperature)) }
    }

    /// Strain without stress (eq. 23 at σ = 0).
    fn free_strain(&self, fraction: &Fraction, temperature: f64) -> f64 {
        let (compliance, _) = self.compliance(fraction);
        self.transformation_strain * fraction.martensite
            + compliance * self.thermoelastic * (temperature - self.reference_c)
    }

    /// R = ρL/A_c (eq. 36, 37, 39), in Ω.
    fn resistance(&self, state: &State) -> f64 {
        let warm = state.temperature - self.reference_c;
        let austenite = self.austenite_ohm + self.austenite_ohm_per_k * warm;
        let martensite = self.martensite_ohm + self.martensite_ohm_per_k * warm;
        let unstrained = state.fraction.austenite * austenite + state.fraction.martensite * martensite;
        // a straight line in T reaches zero somewhere; no wire does
        unstrained.max(1e-3 * self.austenite_ohm) * (1.0 + self.strain(state))
    }

    /// The wire at rest at `temperature`, its phase clipped into the outer curves at the stress it then has.
    fn at_rest(&self, temperature: f64, asked: Fraction, inputs: &Inputs) -> State {
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
    fn stage(
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
    fn trial(
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
    fn residual_slope(&self, stage: &Stage, from: &State, trial: &Trial, slope: f64) -> f64 {
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
