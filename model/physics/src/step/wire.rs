//! One wire with its load and its heating circuit, stepped through time.
//!
//! A step solves temperature, phase, stress and motion together. The unknown is the driving temperature ϑ at the end:
//! given it, the phase is a closed form (see [`crate::kinetics`]), the heat balance and the equation of motion are
//! linear (see `balance.rs`), and what is left is one monotone equation T(ϑ) − σ(ϑ)/α = ϑ, solved by Newton
//! inside a bracket. In time the method is the trapezoidal rule, for the load exponentially fitted to its fastest rate
//! (Liniger and Willoughby, 1970): second order, and light loads on stiff wires settle instead of ringing. Latent heat
//! is paid for every change of ξ, whatever the step.

use super::balance::{Balance, Stage, Trial};
use super::ends::Ledger;
use super::own::Undefined;
use super::reference::{Motion, Reference, State, fitted_implicitness};
use super::terms::{Terms, Unknown};
use crate::criteria::{Drift, Path};
use crate::error::Error;
use crate::formulas;
use crate::kinetics::{Branch, Direction, Fraction, Hysteresis, Point};
use crate::model::WireModel;
use crate::params::{Amplifier, Criterion, DriveKind};
use crate::signals::{EnergyBalance, Inputs, Outputs};

/// Below this nothing moves, in K: 10⁻¹¹ m on a 160 mm wire.
const THETA_TOLERANCE_K: f64 = 1e-7;
/// ϑ is solved to this share of its movement in the stage. What is left does not add up over steps: phase, heat and
/// force are exact for the ϑ accepted, which lags by a thousandth of a step.
const THETA_TOLERANCE: f64 = 1e-3;
/// Rates are differences over a step: no shorter one has any, s.
const SHORTEST_STEP_S: f64 = 1e-12;
/// More than Newton inside a bracket ever needs; bisection alone would reach the tolerance from 10⁴ K in 37.
const MOST_ITERATIONS: u32 = 60;
/// A load that no wire moves, kg: what jams one.
const JAMMED_KG: f64 = 1e12;

/// dϑ/dt of the last two pieces, K/s.
#[derive(Debug, Clone, Copy, Default)]
struct Rates {
    before: f64,
    last: f64,
}

/// A wire in its load and circuit. Cloning it forks the simulation.
#[derive(Debug, Clone)]
pub struct Wire {
    balance: Balance,
    state: State,
    branch: Option<Branch>,
    /// What a rival criterion follows in place of the branch; `None` while it holds the phase still.
    path: Option<Path>,
    /// They give the guess for the next piece.
    theta_rates: Rates,
    /// The piece length that `implicitness` belongs to, s.
    fitted_to: f64,
    /// θ of the fitted method: how much of the load's motion is taken from the end of a piece, ½..1.
    implicitness: f64,
    /// The inputs at the end of the last step: imposed quantities run from there.
    imposed: f64,
    power: f64,
    current: f64,
    started: State,
    /// Time since the start, s.
    elapsed: f64,
    energy: EnergyBalance,
    /// Pieces may be as long as this where the load alone asks for shorter ones, s.
    long_piece: f64,
    /// The amplifier that the wire's current comes from, and what that is set to, behind its low-pass, A.
    amplifier: Option<(Amplifier, f64)>,
    /// Mass of the load where that is jammed now, kg.
    free_mass_kg: Option<f64>,
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
        let mut balance = Balance::new(model);
        let temperature = model.initial.temperature_c.unwrap_or(match model.drive.kind {
            DriveKind::Temperature => first.drive,
            _ => first.ambient_c,
        });
        let asked = Fraction::of_martensite(model.initial.martensite);
        let state = balance.at_rest(temperature, asked, first);
        let mut wire = Wire {
            balance,
            state,
            branch: None,
            path: None,
            theta_rates: Rates::default(),
            fitted_to: 0.0,
            implicitness: 0.5,
            imposed: first.imposed,
            power: 0.0,
            current: 0.0,
            started: state,
            elapsed: 0.0,
            energy: EnergyBalance::default(),
            long_piece: 0.0,
            // the low-pass starts empty
            amplifier: match model.drive.kind {
                DriveKind::Amplifier(amplifier) => Some((amplifier, 0.0)),
                _ => None,
            },
            free_mass_kg: None,
        };
        if wire.amplifier.is_none() {
            wire.current = wire.balance.reference.current(first, state.resistance);
        }
        let seen = wire.seen();
        if let Some(terms) = &mut wire.balance.terms {
            terms.remember(&seen);
        }
        Ok(wire)
    }

    /// Sets the unknown input to each equation, for whoever looks for what the model leaves out; it holds until it is set
    /// again.
    pub fn set_unknown(&mut self, unknown: Unknown) {
        match &mut self.balance.terms {
            Some(terms) => terms.unknown = unknown,
            None if unknown == Unknown::default() => {}
            None => {
                let mut terms = Terms::none(&self.balance.reference, &self.state);
                terms.unknown = unknown;
                self.balance.terms = Some(terms);
            }
        }
    }

    /// Moves the air from now on, so that it takes `gain` more of the heat it takes at rest (0.5 = half as much again; never
    /// less than −1); it holds until it is set again, and acts beside `thermal.draught`. The first one allocates.
    pub fn set_draught(&mut self, gain: f64) {
        let stirred = 1.0 + gain.max(-1.0);
        match &mut self.balance.terms {
            Some(terms) => terms.air.stirred = stirred,
            None if stirred == 1.0 => {}
            None => {
                let mut terms = Terms::none(&self.balance.reference, &self.state);
                terms.air.stirred = stirred;
                self.balance.terms = Some(terms);
            }
        }
    }

    /// Jams the load where it is, so that it stands still however the wire pulls, or frees it again. A length that is imposed
    /// is nobody's to jam.
    pub fn set_jammed(&mut self, jammed: bool) {
        let Motion::Dynamic { mass, .. } = &mut self.balance.reference.motion else { return };
        match (jammed, self.free_mass_kg) {
            (true, None) => {
                self.free_mass_kg = Some(std::mem::replace(mass, JAMMED_KG));
                self.state.velocity = 0.0;
            }
            (false, Some(free_kg)) => (*mass, self.free_mass_kg) = (free_kg, None),
            _ => {}
        }
    }

    /// Takes pieces up to `longest_s` from now on, where the load's own oscillation asks for shorter ones. As stable, and
    /// several times as fast; what oscillates faster than that is damped instead of followed. At 0 the wire takes its own
    /// pieces again, which are never longer than these. For searches, which end with a simulation in the wire's own pieces.
    pub fn take_long_pieces(&mut self, longest_s: f64) {
        self.long_piece = longest_s;
    }

    /// Sets the temperature of the wire beside this one, in °C, for `thermal.neighbour`; it holds until it is set again.
    /// Before that it is ambient.
    pub fn set_neighbour_c(&mut self, temperature_c: f64) {
        if let Some(terms) = &mut self.balance.terms {
            terms.air.neighbour_c = Some(temperature_c);
        }
    }

    /// Advances by `dt_s` under `inputs`. The answer does not depend on how a span is cut into steps, but for the
    /// second-order error of pieces of at most 2.5 ms. Steps of 10 µs to 10 ms are what it is made for; longer ones are
    /// divided the same way. A negative or non-finite step, or one of less than a picosecond, does nothing.
    pub fn step(&mut self, inputs: &Inputs, dt_s: f64) {
        if !(dt_s >= SHORTEST_STEP_S && dt_s.is_finite()) {
            return;
        }
        let longest = self.balance.reference.longest_piece.max(self.long_piece);
        let pieces = (dt_s / longest - 1e-9).ceil().max(1.0);
        let h = dt_s / pieces;
        let imposed_rate = (inputs.imposed - self.imposed) / dt_s;
        let temperature_rate = match self.balance.reference.drive {
            DriveKind::Temperature => (inputs.drive - self.state.temperature) / dt_s,
            _ => 0.0,
        };
        if let Some(terms) = &mut self.balance.terms {
            terms.time = self.elapsed;
        }
        let mut heat_in = 0.0;
        // a count, not `elapsed < dt`: rounding must not add a piece
        let mut piece = 0.0;
        if self.amplifier.is_some() || self.has_rival() {
            heat_in = self.rare_pieces(inputs, h, pieces, imposed_rate, temperature_rate);
            piece = pieces;
        }
        while piece < pieces {
            heat_in += if self.balance.terms.is_some() {
                self.piece::<true, false>(inputs, h, imposed_rate, temperature_rate)
            } else {
                self.piece::<false, false>(inputs, h, imposed_rate, temperature_rate)
            };
            piece += 1.0;
        }
        self.elapsed += dt_s;
        self.imposed = inputs.imposed;
        self.power = heat_in / dt_s;
        self.current = match self.amplifier {
            None => self.balance.reference.current(inputs, self.state.resistance),
            Some((_, set_a)) => self.regulated_a(set_a, inputs.supply_v),
        };
        self.energy.heat_in_j += heat_in;
        let c = &self.balance;
        self.energy.sensible_j = c.reference.heat_capacity * (self.state.temperature - self.started.temperature);
        self.energy.latent_j = -c.reference.latent * self.state.fraction.change_from(&self.started.fraction);
        if self.balance.terms.is_some() {
            self.keep_for_later();
        }
    }

    /// Whether its phase moves by another criterion than eq. 12.
    fn has_rival(&self) -> bool {
        self.balance.reference.criterion != Criterion::DrivingTemperature
    }

    /// The pieces of a step under an amplifier, which is set to what its low-pass makes of the duty, or by a rival criterion: apart, so that no
    /// other wire pays for them. Returns the electrical heat, J.
    #[cold]
    #[inline(never)]
    fn rare_pieces(&mut self, inputs: &Inputs, h: f64, pieces: f64, imposed_rate: f64, temperature_rate: f64) -> f64 {
        let mut inputs = *inputs;
        let duty = inputs.drive;
        let (mut heat_in, mut piece) = (0.0, 0.0);
        while piece < pieces {
            if let Some((amplifier, set_a)) = self.amplifier {
                let (end_a, mean_a) = amplifier.follow(set_a, duty, h);
                inputs.drive = self.regulated_a(mean_a, inputs.supply_v);
                self.amplifier = Some((amplifier, end_a));
            }
            // a wire without effects has no terms to ask: the two need not be told apart here
            heat_in += self.piece::<true, true>(&inputs, h, imposed_rate, temperature_rate);
            piece += 1.0;
        }
        heat_in
    }

    /// What an amplifier that is set to this drives through the wire as it is, A.
    fn regulated_a(&self, set_a: f64, supply_v: f64) -> f64 {
        formulas::regulated_a(set_a, supply_v, self.state.resistance, self.balance.reference.series_ohm)
    }

    /// What the effects need of the end of a step.
    fn keep_for_later(&mut self) {
        let delayed = self.balance.terms.as_ref().is_some_and(|terms| terms.is_delayed());
        let seen = delayed.then(|| self.seen());
        if let Some(terms) = &mut self.balance.terms {
            self.energy.sheath_j = terms.air.sheath_j();
            if let Some(ends) = &terms.ends {
                self.energy.sensible_j = ends.middle * self.energy.sensible_j + ends.sensible;
                self.energy.latent_j = ends.middle * self.energy.latent_j + ends.latent;
            }
            terms.time = self.elapsed;
            if let Some(seen) = seen {
                terms.keep(self.elapsed, &seen);
            }
        }
    }

    /// The effects, where there are any: known when compiled, so that the reference model does not pay for them.
    #[inline(always)]
    fn terms<const EFFECTS: bool>(&self) -> Option<&Terms> {
        if EFFECTS { self.balance.terms.as_deref() } else { None }
    }

    /// One piece of length `h`; returns the electrical heat, J.
    fn piece<const EFFECTS: bool, const RARE: bool>(
        &mut self,
        inputs: &Inputs,
        h: f64,
        imposed_rate: f64,
        temperature_rate: f64,
    ) -> f64 {
        if h != self.fitted_to {
            self.fitted_to = h;
            self.implicitness = fitted_implicitness(h * self.balance.reference.fastest_rate);
        }
        let start = self.state;
        if EFFECTS {
            self.begin_effects(inputs, h);
        }
        let c = &self.balance;
        let half = 0.5 * h;
        let power = c.reference.power(inputs, start.resistance);
        let terms = self.terms::<EFFECTS>();
        let loss = match terms {
            None => loss_to_air(&c.reference, start.temperature - inputs.ambient_c),
            Some(terms) => terms.loss_at_start(&c.reference, &start, power),
        };
        let heat_base = c.reference.heat_capacity * start.temperature + half * (power - loss);
        let imposed = self.imposed + imposed_rate * h;
        let furnace = start.temperature + temperature_rate * h;
        let stage = c.stage(terms, inputs, &start, h, self.implicitness, heat_base, imposed, furnace);
        let end = self.solve::<EFFECTS, RARE>(inputs, &stage, h);
        if !self.balance.reference.has_inertia() {
            self.state.velocity = (self.state.position - start.position) / h;
        }
        self.imposed = imposed;
        let lost = half * (loss + end.loss);
        let heat_in = if self.balance.reference.drive == DriveKind::Temperature {
            // the furnace supplies whatever the imposed temperature takes
            self.balance.reference.heat_capacity * (end.state.temperature - start.temperature) - end.released + lost
        } else {
            half * (power + end.power)
        };
        let mut ledger = Ledger { heat_in, lost, work: end.work };
        if EFFECTS {
            ledger = self.finish_effects(&start, ledger);
        }
        self.energy.work_j -= ledger.work;
        self.energy.loss_j += ledger.lost;
        ledger.heat_in
    }

    fn begin_effects(&mut self, inputs: &Inputs, h: f64) {
        let c = &mut self.balance;
        let Some(mut terms) = c.terms.take() else { return };
        if let Some(shift) = terms.cooling_shift(self.state.stress) {
            c.reference.hysteresis.move_cooling_curve(shift);
        }
        terms.begin(&c.reference, inputs, &self.state, h);
        c.terms = Some(terms);
    }

    /// Closes a piece that began in `start`.
    fn finish_effects(&mut self, start: &State, ledger: Ledger) -> Ledger {
        let c = &mut self.balance;
        let Some(mut terms) = c.terms.take() else { return ledger };
        let branch = if self.state.theta == start.theta { None } else { self.branch.as_ref() };
        let ledger = terms.finish(&c.reference, branch, start, &self.state, ledger);
        c.terms = Some(terms);
        ledger
    }

    /// Solves the piece of length `h` from the present state and moves there.
    fn solve<const EFFECTS: bool, const RARE: bool>(&mut self, inputs: &Inputs, stage: &Stage, h: f64) -> Trial {
        let from = self.state;
        let Rates { before, last } = self.theta_rates;
        let trial = match self.carry_on::<EFFECTS>(inputs, stage, (2.0 * last - before) * h) {
            Some(trial) => trial,
            None => self.set_out::<EFFECTS, RARE>(inputs, stage),
        };
        self.theta_rates = Rates { before: last, last: (trial.state.theta - from.theta) / h };
        self.state = trial.state;
        trial
    }

    /// The usual case: ϑ goes on as before, so Newton from the extrapolated ϑ on the same branch needs one or two
    /// trials. The residual has one zero, so one found on the branch's side of the present ϑ is the solution; anything
    /// else is left to [`Wire::set_out`].
    fn carry_on<const EFFECTS: bool>(&mut self, inputs: &Inputs, stage: &Stage, expected: f64) -> Option<Trial> {
        let (c, terms) = (&self.balance, self.terms::<EFFECTS>());
        let from = &self.state;
        let mut branch = self.branch?;
        let forward = match branch.direction() {
            Direction::Heating => 1.0,
            Direction::Cooling => -1.0,
        };
        let mut theta = from.theta + expected;
        let mut guess = from.as_guess();
        for _ in 0..4 {
            if (theta - from.theta) * forward <= THETA_TOLERANCE_K {
                return None;
            }
            let point = c.point(terms, &branch, theta, from);
            let trial = c.trial(terms, inputs, stage, from, theta, &point, guess);
            if is_solved(&trial, from.theta) {
                if point.outer {
                    branch.ride_outer();
                    self.branch = Some(branch);
                }
                return Some(trial);
            }
            theta -= trial.residual / c.residual_slope(terms, stage, from, &trial, point.slope);
            guess = trial.state.as_guess();
        }
        None
    }

    /// From standing: finds the direction, reverses the branch if it must, and solves by Newton inside a bracket.
    fn set_out<const EFFECTS: bool, const RARE: bool>(&mut self, inputs: &Inputs, stage: &Stage) -> Trial {
        // a rival has no branch to carry on, so that every piece of its wire comes by here
        if RARE && self.has_rival() {
            return self.solve_by_rival::<EFFECTS>(inputs, stage);
        }
        let from = &self.state;
        let terms = self.terms::<EFFECTS>();
        let still = self.balance.standing(terms, from);
        let trial = self.balance.trial(terms, inputs, stage, from, from.theta, &still, from.as_guess());
        // the residual falls with ϑ, so its sign where we stand is the direction of motion
        if trial.residual.abs() <= THETA_TOLERANCE_K {
            return trial;
        }
        let direction = if trial.residual > 0.0 { Direction::Heating } else { Direction::Cooling };
        let mut branch = match self.branch {
            Some(branch) if branch.direction() == direction => branch,
            _ => self.balance.reverse(direction, from),
        };
        let (c, terms) = (&self.balance, self.terms::<EFFECTS>());
        let (trial, point) =
            bracketed(c, terms, inputs, stage, from, direction, trial, |theta| c.point(terms, &branch, theta, from));
        if point.outer {
            branch.ride_outer();
        }
        self.branch = Some(branch);
        trial
    }

    /// By a rival criterion, which is asked where the piece would go if the phase stood still. Where it is not met that is where the piece
    /// goes: temperature and stress do not depend on ϑ but through the phase.
    #[cold]
    #[inline(never)]
    fn solve_by_rival<const EFFECTS: bool>(&mut self, inputs: &Inputs, stage: &Stage) -> Trial {
        let (c, terms, from) = (&self.balance, self.terms::<EFFECTS>(), &self.state);
        let still = Point { fraction: from.fraction, slope: 0.0, outer: false };
        let mut trial = c.trial(terms, inputs, stage, from, from.theta, &still, from.as_guess());
        trial = c.trial(terms, inputs, stage, from, from.theta, &still, trial.state.as_guess());
        let drift = Drift {
            temperature: trial.state.temperature - from.temperature,
            stress: trial.state.stress - from.stress,
            theta: trial.residual,
        };
        let reference = &c.reference;
        let Some(direction) = reference.criterion.admits(&drift) else {
            trial.state.theta += trial.residual;
            self.path = None;
            return trial;
        };
        let path = match self.path {
            Some(path) if path.direction() == direction => path,
            _ => Path::new(reference.criterion, &reference.hysteresis, direction, from.theta, &from.fraction),
        };
        let (trial, _) =
            bracketed(c, terms, inputs, stage, from, direction, trial, |theta| path.at(&reference.hysteresis, theta));
        self.path = Some(path);
        trial
    }
}

/// Solves by Newton inside a bracket, from the `trial` where the wire stands on in `direction`, along the phase that `point_at` has for a
/// ϑ. Returns the solution and its phase.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn bracketed(
    c: &Balance,
    terms: Option<&Terms>,
    inputs: &Inputs,
    stage: &Stage,
    from: &State,
    direction: Direction,
    mut trial: Trial,
    point_at: impl Fn(f64) -> Point,
) -> (Trial, Point) {
    // the near end of the bracket is where we stand; the far end is found on the way
    let (mut low, mut high) = match direction {
        Direction::Heating => (from.theta, f64::INFINITY),
        Direction::Cooling => (f64::NEG_INFINITY, from.theta),
    };
    let mut theta = from.theta;
    let mut point = point_at(theta);
    let mut newton_may = true;
    for _ in 0..MOST_ITERATIONS {
        let width = high - low;
        let mut next = theta - trial.residual / c.residual_slope(terms, stage, from, &trial, point.slope);
        if !(newton_may && next > low && next < high) {
            next = if width.is_finite() {
                0.5 * (low + high)
            } else {
                // the slope was no guide: the bare residual leads past the solution
                theta + 2.0 * trial.residual
            };
        }
        let moved = next - theta;
        theta = next;
        point = point_at(theta);
        trial = c.trial(terms, inputs, stage, from, theta, &point, trial.state.as_guess());
        if trial.residual > 0.0 {
            low = theta;
        } else {
            high = theta;
        }
        // across a whole transformation Newton can swing from one flat end to the other: halve then
        newton_may = high - low <= 0.5 * width;
        if is_solved(&trial, from.theta) || moved.abs() <= 1e-3 * THETA_TOLERANCE_K {
            break;
        }
    }
    (trial, point)
}

/// What the air takes from a wire `above` it without effects, in W (eq. 27).
fn loss_to_air(reference: &Reference, above: f64) -> f64 {
    reference.skin.loss_coefficient(above) * above
}

/// The trial is close enough to the solution, seen from where the stage started.
fn is_solved(trial: &Trial, start_theta: f64) -> bool {
    trial.residual.abs() <= THETA_TOLERANCE_K + THETA_TOLERANCE * (trial.state.theta - start_theta).abs()
}

impl Wire {
    /// Moves temperature and phase by what an observer knows better, K and martensite fraction, the phase no further than the
    /// outer curves allow. The end stays where it is, so that a held wire's stress follows (eq. 23). No energy is booked: it
    /// is the knowledge that changes. Does nothing to a wire with effects or detwinning, or for a number that is none.
    pub fn correct(&mut self, kelvins: f64, martensite: f64) {
        let c = &self.balance;
        if c.terms.is_some() || !(kelvins.is_finite() && martensite.is_finite()) {
            return;
        }
        let mut state = self.state;
        state.temperature += kelvins;
        let wanted = Fraction::of_martensite((state.fraction.martensite + martensite).clamp(0.0, 1.0));
        state.fraction = wanted;
        // the curves move with the stress, and that with the phase: two rounds are within a thousandth of a kelvin
        for _ in 0..2 {
            if matches!(c.reference.motion, Motion::Position) {
                state.stress = c.reference.stress_held(&state.fraction, state.temperature, state.position);
            }
            state.theta = state.temperature - c.reference.stress_shift * state.stress;
            state.fraction = c.reference.hysteresis.clip(wanted, state.theta);
        }
        state.resistance = c.resistance(None, &state);
        self.state = state;
        (self.branch, self.path) = (None, None);
        self.theta_rates = Rates::default();
    }

    /// What sensors see now, in the on-phase under the supply of the last step.
    pub fn outputs(&self) -> Outputs {
        let mut outputs = self.seen();
        if let Some(terms) = &self.balance.terms {
            terms.recall(&mut outputs);
        }
        outputs
    }

    /// What sensors see without delay.
    fn seen(&self) -> Outputs {
        let (s, c) = (&self.state, &self.balance);
        let voltage = self.current * s.resistance;
        // taps are fixed in space: the wire between fixed end and tap is the same share of the whole as l of L (eq. 42)
        let per_metre = voltage / (c.reference.length * (1.0 + c.strain(c.terms.as_deref(), s)));
        let (v1, v2) = match c.reference.taps {
            Some(taps) => (per_metre * taps.l0_m, per_metre * taps.second_m()),
            None => (0.0, 0.0),
        };
        let mut outputs = Outputs {
            current_a: self.current,
            v1_v: v1,
            v2_v: v2,
            v3_v: voltage,
            force_n: c.reference.area * s.stress,
            position_m: s.position,
            temperature_c: s.temperature,
            martensite: s.fraction.martensite,
            power_w: self.power,
            resistance_ohm: s.resistance,
        };
        if let Some(terms) = &c.terms {
            self.add_effects(terms, &mut outputs);
        }
        if let Some(amplifiers) = &c.reference.amplifiers {
            amplifiers.amplify(&mut outputs);
        }
        outputs
    }

    /// What the effects make of what sensors see.
    fn add_effects(&self, terms: &Terms, o: &mut Outputs) {
        let (s, c, sensing) = (&self.state, &self.balance, &terms.effects.sensing);
        let phi = terms.features_now(s);
        if let Some(taps) = c.reference.taps {
            let second = taps.second_m() - sensing.drawn_m(o.force_n);
            o.v1_v = self.current * c.resistance_up_to(terms, s, taps.l0_m);
            o.v2_v = self.current * c.resistance_up_to(terms, s, second);
        }
        o.v3_v += self.current * (sensing.contact_ohm() + terms.effects.empirical.voltage.sum(&phi));
        o.position_m += terms.effects.empirical.position.sum(&phi);
        if matches!(c.reference.motion, Motion::Position) {
            o.force_n += terms.effects.mechanical.dragged(o.force_n, s.velocity) + terms.imposed_load();
        }
        terms.show_own(s, o);
    }

    /// Wire temperature T, in °C.
    pub fn temperature_c(&self) -> f64 {
        self.state.temperature
    }

    /// Martensite fraction ξ, 0..1.
    pub fn martensite(&self) -> f64 {
        self.state.fraction.martensite
    }

    /// Detwinned part ξ_S of the martensite fraction, 0..ξ: all of it where the material has no detwinning.
    pub fn detwinned(&self) -> f64 {
        let twins = self.balance.terms.as_ref().and_then(|terms| terms.twins.as_ref());
        twins.map_or(self.state.fraction.martensite, |twins| twins.fraction())
    }

    /// The phase mixture, both parts to full resolution.
    pub fn fraction(&self) -> Fraction {
        self.state.fraction
    }

    /// Driving temperature ϑ = T − σ/α that the phase sees, in °C.
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

    /// Tension A_c σ, in N.
    pub fn tension_n(&self) -> f64 {
        self.balance.reference.area * self.state.stress
    }

    /// Resistance R, in Ω.
    pub fn resistance_ohm(&self) -> f64 {
        self.state.resistance
    }

    /// Current I in the on-phase under the supply of the last step, in A: of the wire, not as an amplifier shows it.
    pub fn current_a(&self) -> f64 {
        self.current
    }

    /// Least and most martensite there can be at ϑ; with `kinetic.lag`, to which ξ lags behind.
    pub fn bounds(&self) -> (Fraction, Fraction) {
        let theta = self.state.theta;
        match &self.balance.terms {
            None => (self.balance.reference.hysteresis.lower(theta), self.balance.reference.hysteresis.upper(theta)),
            Some(terms) => terms.bounds(&self.balance.reference.hysteresis, theta),
        }
    }

    /// The first formula of a user's law that was not defined where the wire went; it counted as zero there.
    pub fn undefined(&self) -> Option<Undefined> {
        self.balance.terms.as_ref().and_then(|terms| terms.undefined())
    }

    /// The energy ledger since the start.
    pub fn energy(&self) -> EnergyBalance {
        self.energy
    }

    /// The outer curves of this wire.
    pub fn hysteresis(&self) -> &Hysteresis {
        &self.balance.reference.hysteresis
    }
}
/// Length L of the cold wire at rest in its load, all martensite at ambient, in m.
///
/// # Errors
/// [`Error::OutOfRange`] if a parameter is outside its physical range.
pub fn cold_length_m(model: &WireModel) -> Result<f64, Error> {
    model.validate()?;
    let mut c = Balance::new(model);
    let state = c.at_rest(model.ambient_c, Fraction::of_martensite(1.0), &model.rest_inputs());
    Ok(c.reference.length + state.position)
}

/// Length L of the hot wire at rest in its load, in m: transformed to austenite, [`formulas::SURELY_HOT_K`] above where the load's stress has
/// moved A to.
///
/// # Errors
/// [`Error::OutOfRange`] if a parameter is outside its physical range.
pub fn hot_length_m(model: &WireModel) -> Result<f64, Error> {
    model.validate()?;
    let mut c = Balance::new(model);
    let inputs = model.rest_inputs();
    let mut stress = 0.0;
    let mut position = 0.0;
    // stress moves A, and the hotter wire is stiffer: settles in two or three rounds
    for _ in 0..8 {
        let temperature = model.material.austenite_at_c(stress) + formulas::SURELY_HOT_K;
        let state = c.at_rest(temperature, Fraction::of_martensite(0.0), &inputs);
        (stress, position) = (state.stress, state.position);
    }
    Ok(c.reference.length + position)
}
