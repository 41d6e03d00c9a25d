//! The equations of one wire at one instant: heat (eq. 48), motion (eq. 51), strain (eq. 23) and resistance (eq. 36–39),
//! for a trial value of the driving temperature at the end of a piece of time. The effects beyond the reference model
//! come in where their [`Terms`] are asked; without any, the equations are the reference model's to the last digit.

use super::reference::{Motion, Reference, State};
use super::terms::{Loss, MOST_STRESS, MovingLoad, STRESS_PA, Terms};
use crate::effects::empirical::Term;
use crate::effects::mechanical::Grip;
use crate::kinetics::{Branch, Direction, Fraction, Point};
use crate::model::WireModel;
use crate::params::DriveKind;
use crate::signals::Inputs;
use crate::twins::Twins;

/// More rounds than strain as a curve of stress needs: from no stress, one for each scale of the curve.
const MOST_ROUNDS: u32 = 40;
/// The same where martensite detwins: halving finds the stresses between which it does, however close they are, and Newton the rest.
const MOST_ROUNDS_OF_TWINS: u32 = 100;
/// Stress is found to this share of itself …
const STRESS_TOLERANCE: f64 = 1e-10;
/// … or to this, in Pa.
const STRESS_TOLERANCE_PA: f64 = 1e-2;
/// Strain never gives way to stress less than this share of what the wire's moduli do.
const LEAST_COMPLIANCE: f64 = 0.1;

/// The residual falls with ϑ at least this fast, K/K, unless a kinetics law has a kink.
const LEAST_SLOPE: f64 = -1e-3;

/// The equations of one wire: the reference model's, and its effects.
#[derive(Debug, Clone)]
pub(crate) struct Balance {
    pub(crate) reference: Reference,
    /// The effects that need more than a coefficient, and any unknown input.
    pub(crate) terms: Option<Box<Terms>>,
}

/// What the end of a piece is solved from, with the equation of motion reduced to what the stress must satisfy.
pub(crate) struct Stage {
    /// h/2: the weight of the end in the heat balance, s.
    pub(crate) heat_tau: f64,
    /// h, s.
    pub(crate) span: f64,
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

/// Strain as a straight line in stress and temperature: free + compliance (σ + θ (T − T_0)) + soft σ.
struct Elastic {
    free: f64,
    compliance: f64,
    /// Gives way to stress but not to temperature, 1/Pa.
    soft: f64,
    /// Stress of a held wire per kelvin, Pa/K: times the compliance its expansion.
    thermoelastic: f64,
    /// Shape strain per ξ that does work.
    shape: f64,
    /// Shape strain that detwinned martensite has gained in the piece, where that is a part of its own.
    gained: f64,
}

/// What the load asks of the wire's end: its strain, or the tension on it.
struct Line {
    inertia: f64,
    stretch: f64,
    push: f64,
    give: f64,
    /// Tension, where that is what is imposed, N.
    force: Option<f64>,
}

/// The heat balance at a trial ϑ: heat = capacity T − work of σ, and the phase that goes with it.
struct Heating {
    heat: f64,
    capacity: f64,
    /// Temperature, where that is imposed, °C.
    imposed: Option<f64>,
    /// Change of ξ in the piece.
    change: f64,
    fraction: Fraction,
    /// Stress at the start of the piece, Pa.
    from_stress: f64,
    /// Stress of the last trial, Pa.
    stress: f64,
}

/// Heat and motion solved at a trial ϑ.
struct Solved {
    temperature: f64,
    stress: f64,
    elastic: Elastic,
    half_work: f64,
    /// Work of what detwins in the piece under the stress of its start, J.
    early_work: f64,
    follow: f64,
}

/// What the coefficients that depend on the end of a piece are taken at: T, R and σ of the last trial.
#[derive(Clone, Copy)]
pub(crate) struct Guess {
    temperature: f64,
    resistance: f64,
    stress: f64,
}

impl State {
    #[inline(always)]
    pub(crate) fn as_guess(&self) -> Guess {
        Guess { temperature: self.temperature, resistance: self.resistance, stress: self.stress }
    }
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
        Balance { reference: Reference::new(model), terms: Terms::of(model) }
    }

    /// Strain of the phase `fraction` (eq. 23), as its tangent at the stress `at`.
    #[inline(always)]
    fn elastic(&self, terms: Option<&Terms>, fraction: &Fraction, at: f64) -> Elastic {
        let (compliance, _) = self.reference.compliance(fraction);
        let shape = self.reference.transformation_strain;
        let thermoelastic = self.reference.thermoelastic;
        let plain =
            Elastic { free: shape * fraction.martensite, compliance, soft: 0.0, thermoelastic, shape, gained: 0.0 };
        match terms {
            None => plain,
            Some(terms) => self.elastic_with(terms, fraction, at, plain),
        }
    }

    fn elastic_with(&self, terms: &Terms, fraction: &Fraction, at: f64, mut elastic: Elastic) -> Elastic {
        let mechanical = &terms.effects.mechanical;
        let xi = fraction.martensite;
        elastic.thermoelastic +=
            mechanical.phase_expansion.extra_per_k(fraction.austenite, fraction.martensite) / elastic.compliance;
        elastic.shape = terms.shape(self.reference.transformation_strain, at);
        if let Some(twins) = &terms.twins {
            let now = twins.at(fraction, at);
            elastic.soft = self.reference.transformation_strain * now.slope;
            elastic.gained = self.reference.transformation_strain * now.gained;
            elastic.free = elastic.shape * xi + self.reference.transformation_strain * now.fraction - elastic.soft * at;
        } else {
            let (_, steeper) = mechanical.stress_dependent_strain.oriented(at);
            elastic.soft = self.reference.transformation_strain * steeper * xi;
            elastic.free = elastic.shape * xi - elastic.soft * at;
        }
        let form = &terms.effects.empirical.mechanical;
        let (linear, square) = (form.get(Term::Stress) / STRESS_PA, form.get(Term::Stress2) / STRESS_PA / STRESS_PA);
        // the library's σ has a bound, beyond which its square no longer grows
        let most = MOST_STRESS * STRESS_PA;
        let (bounded, steeper) = if at < most { (at, 2.0 * square * at) } else { (most, 0.0) };
        let own = terms.own.as_ref().map(|own| own.now()).copied().unwrap_or_default();
        elastic.soft =
            (elastic.soft + linear + steeper + own.strain_per_pa).max((LEAST_COMPLIANCE - 1.0) * elastic.compliance);
        elastic.free += (form.get(Term::Martensite) + form.get(Term::Mixed) * fraction.austenite) * xi
            + square * bounded * bounded
            - steeper * at;
        if let Some(ends) = &terms.ends {
            elastic.free = ends.middle * elastic.free + ends.free;
            elastic.compliance *= ends.middle;
            elastic.soft = ends.middle * elastic.soft + ends.compliance + ends.soft;
        }
        elastic.free += terms.strain() + own.strain_per_fraction * xi;
        elastic.soft += self.reference.frame;
        elastic.shape += self.elastic_work(terms, fraction, at);
        elastic
    }

    /// Strain per ξ that does work on the elasticity of the phases.
    fn elastic_work(&self, terms: &Terms, fraction: &Fraction, stress: f64) -> f64 {
        terms.effects.thermal.elastic_work.strain(self.reference.compliance(fraction).1, stress)
    }

    /// Strain of the wire itself: that of its ends, or its own when it hangs slack between them.
    #[inline(always)]
    pub(crate) fn strain(&self, terms: Option<&Terms>, state: &State) -> f64 {
        let mut ends = state.position * self.reference.per_length;
        if terms.is_some() {
            ends -= self.reference.frame * state.stress;
        }
        if state.stress > 0.0 { ends } else { ends.max(self.free_strain(terms, &state.fraction, state.temperature)) }
    }

    /// Strain without stress (eq. 23 at σ = 0).
    #[inline(always)]
    fn free_strain(&self, terms: Option<&Terms>, fraction: &Fraction, temperature: f64) -> f64 {
        let elastic = self.elastic(terms, fraction, 0.0);
        elastic.free + elastic.compliance * elastic.thermoelastic * (temperature - self.reference.reference_c)
    }

    /// R = ρL/A_c (eq. 36, 37, 39), in Ω.
    #[inline(always)]
    pub(crate) fn resistance(&self, terms: Option<&Terms>, state: &State) -> f64 {
        let unstrained = self.reference.unstrained(
            terms.map(|terms| &terms.effects),
            &state.fraction,
            state.temperature,
            state.stress,
        );
        // a straight line in T reaches zero somewhere; no wire does
        let least = 1e-3 * self.reference.austenite_ohm;
        match terms {
            None => unstrained.max(least) * (1.0 + self.strain(None, state)),
            Some(terms) => {
                let whole = match &terms.ends {
                    None => unstrained,
                    Some(ends) => ends.middle * unstrained + ends.ohm,
                };
                whole.max(least) * self.stretched(terms, state)
            }
        }
    }

    /// Resistance between the fixed end and a point `at` m from it, in Ω.
    pub(crate) fn resistance_up_to(&self, terms: &Terms, state: &State, at: f64) -> f64 {
        let at = at / (1.0 + self.strain(Some(terms), state));
        match &terms.ends {
            None => state.resistance * at * self.reference.per_length,
            Some(ends) => {
                let middle =
                    self.reference.unstrained(Some(&terms.effects), &state.fraction, state.temperature, state.stress);
                ends.up_to(at, self.reference.length, middle) * self.stretched(terms, state)
            }
        }
    }

    /// By what a state's unstrained resistance grows: length, cross-section (eq. 41) and what is unknown of resistivity.
    pub(crate) fn stretched(&self, terms: &Terms, state: &State) -> f64 {
        let (compliance, _) = self.reference.compliance(&state.fraction);
        // a closed form may ask for any strain; no wire gets shorter than nothing, or ten times as long
        (1.0 + self.strain(Some(terms), state)).clamp(0.05, 10.0)
            * terms.effects.electrical.narrowing(state.stress, compliance)
            * terms.resistivity_factor(state)
    }

    /// `asked` clipped into the outer curves at ϑ.
    fn clip(&self, asked: Fraction, theta: f64) -> Fraction {
        match &self.terms {
            None => self.reference.hysteresis.clip(asked, theta),
            Some(terms) => terms.clip(&self.reference.hysteresis, asked, theta),
        }
    }

    /// The wire at rest at `temperature`, its phase clipped into the outer curves at the stress it then has.
    pub(crate) fn at_rest(&mut self, temperature: f64, asked: Fraction, inputs: &Inputs) -> State {
        if let Some(terms) = &mut self.terms {
            terms.twins = self.reference.detwinning.map(Twins::new);
        }
        let mut state = self.equilibrium(temperature, asked, inputs);
        // cold ends, a cooling curve moved by stress and closed forms depend on the state they belong to
        for _ in 0..4 {
            let Some(mut terms) = self.terms.take() else { break };
            if let Some(shift) = terms.cooling_shift(state.stress) {
                self.reference.hysteresis.move_cooling_curve(shift);
            }
            terms.settle(&self.reference, &state, asked, inputs.ambient_c);
            self.terms = Some(terms);
            state = self.equilibrium(temperature, asked, inputs);
        }
        if let Some(twins) = self.terms.as_mut().and_then(|terms| terms.twins.as_mut()) {
            twins.arrive(&state.fraction, state.stress);
        }
        state
    }

    fn equilibrium(&self, temperature: f64, asked: Fraction, inputs: &Inputs) -> State {
        let terms = self.terms.as_deref();
        let (load, shift) = terms.map_or((0.0, 0.0), |terms| (terms.imposed_load(), terms.shift(0.0)));
        let pull = inputs.external_n + load;
        let warm = temperature - self.reference.reference_c;
        let stress_of = |free: f64, compliance: f64| -> f64 {
            let taut = match self.reference.motion {
                Motion::Dynamic { spring, preload, .. } => {
                    (preload + pull - spring * self.reference.length * free)
                        / (self.reference.area + spring * self.reference.length * compliance)
                }
                Motion::Position => (inputs.imposed / self.reference.length - free) / compliance,
                Motion::Force => (inputs.imposed + load) / self.reference.area,
            };
            taut.max(0.0)
        };
        let stress = |fraction: &Fraction| -> f64 {
            let (mut stress, mut bracket) = (0.0, Bracket::default());
            for _ in 0..most_rounds(terms) {
                let elastic = self.elastic(terms, fraction, stress);
                let found = stress_of(
                    elastic.free + elastic.compliance * elastic.thermoelastic * warm,
                    elastic.compliance + elastic.soft,
                );
                let moved = (found - stress).abs();
                let same = !terms.is_some_and(|terms| terms.bends) || is_same_stress(moved, found);
                stress = if same { found } else { bracket.next(terms, stress, found) };
                if same {
                    break;
                }
            }
            stress
        };
        let all_austenite = Fraction { martensite: 0.0, austenite: 1.0 };
        let all_martensite = Fraction { martensite: 1.0, austenite: 0.0 };
        let most = stress(&all_austenite).max(stress(&all_martensite));
        // T − σ(ξ(ϑ))/α − ϑ falls with ϑ: less martensite, more stress
        let hottest = temperature + shift;
        let (mut low, mut high) = (hottest - self.reference.stress_shift * most, hottest);
        for _ in 0..80 {
            let theta = 0.5 * (low + high);
            let fraction = self.clip(asked, theta);
            if hottest - self.reference.stress_shift * stress(&fraction) > theta { low = theta } else { high = theta }
        }
        let theta = 0.5 * (low + high);
        let fraction = self.clip(asked, theta);
        let stress = stress(&fraction);
        let elastic = self.elastic(terms, &fraction, stress);
        let wire_end = self.reference.length
            * (elastic.free
                + elastic.compliance * elastic.thermoelastic * warm
                + (elastic.compliance + elastic.soft) * stress);
        let position = match self.reference.motion {
            Motion::Position => inputs.imposed,
            // a slack wire does not say where the load is: its spring does
            Motion::Dynamic { spring, preload, .. } if stress == 0.0 && spring > 0.0 => (preload + pull) / spring,
            _ => wire_end,
        };
        let mut state = State {
            theta,
            fraction,
            temperature,
            stress,
            position,
            velocity: 0.0,
            resistance: self.reference.austenite_ohm,
        };
        state.resistance = self.resistance(terms, &state);
        state
    }

    /// The phase at the end of a piece at ϑ, on its branch.
    #[inline(always)]
    pub(crate) fn point(&self, terms: Option<&Terms>, branch: &Branch, theta: f64, from: &State) -> Point {
        match terms {
            None => self.reference.hysteresis.on_branch(branch, theta),
            Some(terms) => terms.point(&self.reference.hysteresis, branch, theta, from),
        }
    }

    /// The phase at the end of a piece if ϑ stands still.
    pub(crate) fn standing(&self, terms: Option<&Terms>, from: &State) -> Point {
        match terms {
            None => Point { fraction: from.fraction, slope: 0.0, outer: false },
            Some(terms) => terms.standing(&self.reference.hysteresis, from),
        }
    }

    /// The branch that leaves `from` in `direction`.
    pub(crate) fn reverse(&mut self, direction: Direction, from: &State) -> Branch {
        match &mut self.terms {
            None => self.reference.hysteresis.reverse(direction, from.theta, &from.fraction),
            Some(terms) => terms.reverse(&self.reference.hysteresis, direction, from.theta),
        }
    }

    /// What the equation of motion asks of the stress at the end of a piece:
    /// σ (inertia C + give/L_0) = inertia (C θ (T_0 − T) + x/L_0 − ε_L ξ) + push/L_0.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn stage(
        &self,
        terms: Option<&Terms>,
        inputs: &Inputs,
        start: &State,
        h: f64,
        implicitness: f64,
        heat_base: f64,
        imposed: f64,
        furnace: f64,
    ) -> Stage {
        let tau = implicitness * h;
        let (inertia, push, give, position_base) = match self.reference.motion {
            Motion::Dynamic { mass, mut damping, mut spring, mut preload } => {
                if let Some(terms) = terms {
                    let more = terms.moving_load(start, mass, tau);
                    preload += more.force;
                    spring += more.spring;
                    damping += more.damping;
                }
                // M ẍ + B ẋ + K x = F − A_c σ by the θ-method, times τ²
                let early = h - tau;
                let force = preload + inputs.external_n;
                let pull =
                    force - damping * start.velocity - spring * start.position - self.reference.area * start.stress;
                let position_base = start.position + early * start.velocity;
                let momentum_base = mass * start.velocity + early * pull;
                let inertia = mass + tau * (damping + tau * spring);
                let push = tau * (tau * (force - spring * position_base) + momentum_base);
                (inertia, push, tau * tau * self.reference.area, position_base)
            }
            Motion::Position => (1.0, 0.0, 0.0, imposed),
            Motion::Force => match terms.map(|terms| terms.moving_load(start, 0.0, h)) {
                Some(MovingLoad { force, spring, damping }) if spring != 0.0 || damping != 0.0 => {
                    // B ẋ + K x = F − A_c σ at the end of the piece
                    let push = h * h * (imposed + force - spring * start.position);
                    (h * (damping + h * spring), push, h * h * self.reference.area, start.position)
                }
                _ => (0.0, 0.0, 0.0, start.position),
            },
        };
        Stage {
            heat_tau: 0.5 * h,
            span: h,
            motion_tau: tau,
            heat_base,
            position_base,
            inertia,
            push,
            give,
            force: terms.map_or(imposed, |terms| imposed + terms.imposed_load()),
            temperature: furnace,
        }
    }

    /// All equations at the end of `stage` for a trial ϑ with its phase `point`. The last trial's state serves where
    /// a coefficient depends on it.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn trial(
        &self,
        terms: Option<&Terms>,
        inputs: &Inputs,
        stage: &Stage,
        from: &State,
        theta: f64,
        point: &Point,
        guess: Guess,
    ) -> Trial {
        let tau = stage.heat_tau;
        let fraction = point.fraction;
        // heat balance (eq. 48), with the work of transformation by the trapezoidal rule
        let change = fraction.change_from(&from.fraction);
        let power = self.reference.power(inputs, guess.resistance);
        let loss = match terms {
            None => {
                let coefficient = self.reference.skin.loss_coefficient(guess.temperature - inputs.ambient_c);
                Loss { coefficient, ambient: inputs.ambient_c, fixed: 0.0 }
            }
            Some(terms) => terms.loss_at_end(&self.reference, guess.temperature, power, tau),
        };
        let shape_before = match terms {
            None => self.reference.transformation_strain,
            Some(terms) => {
                terms.shape(self.reference.transformation_strain, from.stress)
                    + self.elastic_work(terms, &from.fraction, from.stress)
            }
        };
        let work_before = 0.5 * self.reference.volume * shape_before * change * from.stress;
        let capacity = self.reference.heat_capacity + tau * loss.coefficient;
        let heat = stage.heat_base
            + tau * (power + loss.coefficient * loss.ambient - loss.fixed)
            + self.reference.latent * change
            + work_before;
        let imposed = (self.reference.drive == DriveKind::Temperature).then_some(stage.temperature);
        let heating =
            Heating { heat, capacity, imposed, change, fraction, from_stress: from.stress, stress: guess.stress };
        let stretch = stage.position_base * self.reference.per_length;
        let line = match self.reference.motion {
            Motion::Force if stage.inertia == 0.0 => {
                Line { inertia: 0.0, stretch, push: 0.0, give: 0.0, force: Some(stage.force) }
            }
            _ => Line { inertia: stage.inertia, stretch, push: stage.push, give: stage.give, force: None },
        };
        let (line, solved) = match terms.and_then(Terms::grip) {
            Some(grip) if !matches!(self.reference.motion, Motion::Position) => {
                self.solve_with_friction(terms, &grip, stage, line, &heating)
            }
            _ => {
                let solved = self.solve(terms, &line, &heating);
                (line, solved)
            }
        };
        let Solved { temperature, stress, elastic, half_work, early_work, follow } = solved;
        let (position, velocity) = match self.reference.motion {
            Motion::Dynamic { .. } => {
                let moved = (line.push - line.give * stress) / line.inertia;
                (stage.position_base + moved, moved / stage.motion_tau)
            }
            Motion::Position => (stage.position_base, 0.0),
            Motion::Force => {
                let thermal = elastic.thermoelastic * (temperature - self.reference.reference_c);
                let soft = elastic.soft * stress;
                (self.reference.length * (elastic.free + elastic.compliance * (stress + thermal) + soft), 0.0)
            }
        };
        let mut state =
            State { theta, fraction, temperature, stress, position, velocity, resistance: guess.resistance };
        state.resistance = self.resistance(terms, &state);
        let mut work = work_before + half_work * stress;
        if terms.is_some() {
            work += early_work;
        }
        let mut residual = temperature - self.reference.stress_shift * stress - theta;
        if let Some(terms) = terms {
            residual += terms.shift(change);
        }
        Trial {
            state,
            power,
            loss: loss.coefficient * (temperature - loss.ambient) + loss.fixed,
            released: self.reference.latent * change + work,
            work,
            residual,
            follow,
        }
    }

    /// Heat and motion together: σ = (pull − follow θ T) / hold in the heat balance.
    #[inline(always)]
    fn solve(&self, terms: Option<&Terms>, line: &Line, heating: &Heating) -> Solved {
        let (mut at, mut bracket) = (heating.stress, Bracket::default());
        let mut rounds = 0;
        loop {
            rounds += 1;
            let elastic = self.elastic(terms, &heating.fraction, at);
            let mut half_work = 0.5 * self.reference.volume * elastic.shape * heating.change;
            let (mut heat, mut early_work) = (heating.heat, 0.0);
            if terms.is_some() {
                let half_gained = 0.5 * self.reference.volume * elastic.gained;
                early_work = half_gained * heating.from_stress;
                heat += early_work;
                half_work += half_gained;
            }
            let (mut pull, mut follow, hold) = match line.force {
                Some(force) => ((force / self.reference.area).max(0.0), 0.0, 1.0),
                None => {
                    let follow = line.inertia * elastic.compliance;
                    let pull = line.inertia * (line.stretch - elastic.free)
                        + follow * elastic.thermoelastic * self.reference.reference_c
                        + line.push * self.reference.per_length;
                    let mut hold = follow + line.give * self.reference.per_length;
                    if terms.is_some() {
                        hold += line.inertia * elastic.soft;
                    }
                    (pull, follow, hold)
                }
            };
            let temperature_at = |pull: f64, follow: f64| match heating.imposed {
                Some(temperature) => temperature,
                None => {
                    (heat * hold + half_work * pull)
                        / (heating.capacity * hold + half_work * follow * elastic.thermoelastic)
                }
            };
            let mut temperature = temperature_at(pull, follow);
            let mut stress = (pull - follow * elastic.thermoelastic * temperature) / hold;
            if stress < 0.0 {
                // slack: a wire cannot push
                (pull, follow, stress) = (0.0, 0.0, 0.0);
                temperature = temperature_at(pull, follow);
            }
            let bends = terms.is_some_and(|terms| terms.bends);
            if !bends || is_same_stress((stress - at).abs(), stress) || rounds == most_rounds(terms) {
                return Solved { temperature, stress, elastic, half_work, early_work, follow: follow / hold };
            }
            at = bracket.next(terms, at, stress);
        }
    }

    /// The load held where it is, if friction can; else friction is the most there is, through the whole piece. Returns
    /// what the load then asks of the wire.
    #[inline(never)]
    fn solve_with_friction(
        &self,
        terms: Option<&Terms>,
        grip: &Grip,
        stage: &Stage,
        mut line: Line,
        heating: &Heating,
    ) -> (Line, Solved) {
        let held = Line { inertia: 1.0, push: 0.0, give: 0.0, force: None, ..line };
        let solved = self.solve(terms, &held, heating);
        // the force on the load is that of the whole piece
        let weight = if self.reference.has_inertia() { stage.motion_tau * stage.span } else { stage.span * stage.span };
        let needed = match line.force {
            Some(force) => self.reference.area * solved.stress - force,
            None => (line.give * solved.stress - line.push) / weight,
        };
        let friction = grip.force(needed);
        if friction == needed {
            return (held, solved);
        }
        match &mut line.force {
            Some(force) => *force += friction,
            None => line.push += weight * friction,
        }
        let solved = self.solve(terms, &line, heating);
        (line, solved)
    }

    /// How fast the residual of `trial` falls with ϑ where ξ has the given slope: the guide of Newton's method.
    #[inline(always)]
    pub(crate) fn residual_slope(
        &self,
        terms: Option<&Terms>,
        stage: &Stage,
        from: &State,
        trial: &Trial,
        slope: f64,
    ) -> f64 {
        let state = &trial.state;
        let mut shape = self.reference.transformation_strain;
        let mut softer = 0.0;
        if let Some(twins) = terms.and_then(|terms| terms.twins.as_ref()) {
            let now = twins.at(&state.fraction, state.stress);
            softer = shape * now.slope;
            shape *= now.per_fraction;
        }
        let mut heat_per_fraction = if self.reference.drive == DriveKind::Temperature {
            0.0
        } else {
            let work = 0.5 * self.reference.volume * shape * (from.stress + state.stress);
            (self.reference.latent + work)
                / (self.reference.heat_capacity + stage.heat_tau * self.reference.skin.loss_w_per_k)
        };
        // d/dξ of C σ = x/L_0 − ε_L ξ − C θ (T − T_0), the ends giving way
        let (compliance, compliance_slope) = self.reference.compliance(&state.fraction);
        let thermal = self.reference.thermoelastic * (state.temperature - self.reference.reference_c);
        let stress_per_fraction = -trial.follow
            * ((shape + compliance_slope * (state.stress + thermal)) / compliance
                + self.reference.thermoelastic * heat_per_fraction);
        if terms.is_some() && self.reference.drive != DriveKind::Temperature {
            // what stress detwins less, as it falls, is heat missing
            heat_per_fraction +=
                0.5 * self.reference.volume * softer * (from.stress + state.stress) * stress_per_fraction
                    / (self.reference.heat_capacity + stage.heat_tau * self.reference.skin.loss_w_per_k);
        }
        let mut gain = heat_per_fraction - self.reference.stress_shift * stress_per_fraction;
        if let Some(terms) = terms {
            gain += terms.shift_per_fraction();
        }
        (gain * slope - 1.0).min(LEAST_SLOPE)
    }
}

/// How many rounds strain as a curve of stress may take.
#[inline(always)]
fn most_rounds(terms: Option<&Terms>) -> u32 {
    if terms.is_some_and(|terms| terms.twins.is_some()) { MOST_ROUNDS_OF_TWINS } else { MOST_ROUNDS }
}

/// Keeps Newton's rounds for the stress together where strain is no longer convex in it. As far as detwinned martensite gives way that is
/// an S, from one flat end of which Newton swings to the other: halve then. Strain grows with stress, so that where a round leads is the
/// side on which the solution is.
struct Bracket {
    low: f64,
    high: f64,
}

impl Default for Bracket {
    fn default() -> Self {
        Bracket { low: f64::NEG_INFINITY, high: f64::INFINITY }
    }
}

impl Bracket {
    /// Where the next round is taken, after one at `at` that led to `found`, in Pa.
    #[inline(always)]
    fn next(&mut self, terms: Option<&Terms>, at: f64, found: f64) -> f64 {
        match terms.and_then(|terms| terms.twins.as_ref()) {
            None => found,
            Some(_) => self.within(at, found),
        }
    }

    fn within(&mut self, at: f64, found: f64) -> f64 {
        let width = self.high - self.low;
        if found > at {
            self.low = at
        } else {
            self.high = at
        }
        let now = self.high - self.low;
        // one side that creeps up is no progress
        let newton_may = now <= 0.5 * width && found > self.low && found < self.high;
        if now.is_infinite() || newton_may { found } else { 0.5 * (self.low + self.high) }
    }
}

/// Whether stress has moved little enough between two rounds, in Pa.
fn is_same_stress(moved: f64, stress: f64) -> bool {
    moved <= STRESS_TOLERANCE * stress + STRESS_TOLERANCE_PA
}
