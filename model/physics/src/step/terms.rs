//! The effects of one wire as they act from piece to piece: what they remember, and what they come to in the piece under
//! way. A wire of the reference model has none of this.

use super::air::{Air, At, Extra, ExtraForm, Sleeve};
use super::ends::{Beside, Ends, Ledger};
use super::own::{OwnTerms, Size, Undefined};
use super::reference::{Reference, State};
use crate::effects::all::Effects;
use crate::effects::empirical::{Features, Form, Term};
use crate::effects::kinetic::{Grains, LagWeights};
use crate::effects::mechanical::Grip;
use crate::effects::own::{CURRENT, Entry, Quantities};
use crate::effects::sensing::Memory;
use crate::effects::thermal::HeatFlow;
use crate::formulas::WORKING_EXCESS_K;
use crate::kinetics::{Branch, Direction, Fraction, Hysteresis, Point};
use crate::model::WireModel;
use crate::params::DriveKind;
use crate::signals::{Inputs, Outputs};
use crate::twins::Twins;

/// An unknown input to each equation, for whoever looks for what a model leaves out. All zero is none. It holds until
/// it is set again.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Unknown {
    /// Heat into the wire, in W.
    pub heat_w: f64,
    /// Shift of the driving temperature the phase sees, in K, positive hotter.
    pub driving_k: f64,
    /// Strain without stress.
    pub strain: f64,
    /// Relative change of resistivity.
    pub resistivity: f64,
    /// Force on the load, in N, positive making the wire longer; added to an imposed force, or to the tension measured
    /// where the position is imposed.
    pub load_n: f64,
}

/// A loss as a straight line in T: coefficient (T − ambient) + fixed, in W.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Loss {
    pub(crate) coefficient: f64,
    pub(crate) ambient: f64,
    pub(crate) fixed: f64,
}

/// Time over which the rates among the library's functions are means, s.
const RATE_MEMORY_S: f64 = 0.02;
/// Bounds of the library's functions.
const MOST_WARM: f64 = 20.0;
pub(crate) const MOST_STRESS: f64 = 20.0;
const MOST_POSITION: f64 = 3.0;
const MOST_RATE: f64 = 100.0;
const MOST_POWER: f64 = 1000.0;

/// The effects of one wire and their state.
#[derive(Debug, Clone)]
pub(crate) struct Terms {
    pub(crate) effects: Effects,
    pub(crate) unknown: Unknown,
    /// What is around the wire.
    pub(crate) air: Air,
    /// Time at the start of the piece, s since the start.
    pub(crate) time: f64,
    /// ∫|dξ| since the start.
    travel: f64,
    /// Means over the last [`RATE_MEMORY_S`].
    rates: Rates,
    grains: Option<Grains>,
    /// ξ_eq, which the branches belong to.
    equilibrium: Fraction,
    pub(crate) ends: Option<Ends>,
    memory: Option<Memory>,
    /// What is twinned of the martensite.
    pub(crate) twins: Option<Twins>,
    /// ξ as strain needs σ, in a curve.
    pub(crate) bends: bool,
    /// Some empirical form is on: otherwise its library is not evaluated.
    forms: bool,
    /// What users wrote themselves.
    pub(crate) own: Option<OwnTerms>,
    /// x/(ε_L L_0) of 1, in m.
    stroke: f64,
    now: Now,
}

/// Rates among the library's functions.
#[derive(Debug, Clone, Copy, Default)]
struct Rates {
    /// ẋ, m/s.
    velocity: f64,
    /// ξ̇, 1/s.
    phase: f64,
    /// Ṫ, K/s.
    warming: f64,
}

/// Force on the load in a piece, N.
#[derive(Debug, Clone, Copy)]
struct LoadForce {
    /// What does not depend on the load's movement.
    fixed: f64,
    /// All of it, for imposed loads.
    whole: f64,
}

/// How the wire is driven in a piece.
#[derive(Debug, Clone, Copy)]
struct Driven {
    duty: f64,
    /// Electrical power at its start, W.
    power: f64,
    /// On-phase current at its start, A.
    current: f64,
    /// V_s, V.
    supply: f64,
}

/// What pulls on a moving load besides the reference model, as a tangent at its present movement.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovingLoad {
    /// A force, N.
    pub(crate) force: f64,
    /// A spring that takes from it, N/m.
    pub(crate) spring: f64,
    /// A damping that takes from it, N s/m.
    pub(crate) damping: f64,
}

/// What the effects come to in the piece under way.
#[derive(Debug, Clone, Copy)]
struct Now {
    h: f64,
    /// What the phase sees besides T − σ/α, K.
    shift: f64,
    /// Strain without stress that does not depend on the end of the piece.
    strain: f64,
    load: LoadForce,
    /// How ξ lags.
    lag: LagWeights,
    drive: Driven,
    grip: Option<Grip>,
}

impl Terms {
    /// The effects of `model`; `None` where it has none.
    pub(crate) fn of(model: &WireModel) -> Option<Box<Terms>> {
        let stroke = model.material.transformation_strain.max(1e-3) * model.geometry.length_m;
        // amplifiers act on signals, not on the wire: they cost no terms
        let sensing = model.effects.sensing.without_amplifiers();
        let effects = Effects { sensing, own: model.effects.own.acting(), ..model.effects.clone() };
        let twins = model.material.detwinning.map(Twins::new);
        (effects != Effects::default() || twins.is_some()).then(|| {
            let mut terms = Terms::with_stroke(effects, stroke);
            terms.own = OwnTerms::of(model);
            terms.bends |= twins.is_some();
            terms.twins = twins;
            terms
        })
    }

    /// No effect at all: something to hold an unknown input.
    pub(crate) fn none(c: &Reference, state: &State) -> Box<Terms> {
        let mut terms = Terms::with_stroke(Effects::default(), c.transformation_strain.max(1e-3) * c.length);
        terms.equilibrium = state.fraction;
        terms
    }

    fn with_stroke(effects: Effects, stroke: f64) -> Box<Terms> {
        let none = Fraction::of_martensite(1.0);
        let mechanical = &effects.empirical.mechanical;
        let bends =
            effects.mechanical.stress_dependent_strain.stress_scale_pa > 0.0 || mechanical.get(Term::Stress2) != 0.0;
        let forms = effects.empirical.is_on();
        let mut air = Air::new(effects.thermal);
        air.extra.form = forms.then(|| form_of_temperature(&effects.empirical.thermal, 0.0));
        Box::new(Terms {
            effects,
            unknown: Unknown::default(),
            air,
            time: 0.0,
            travel: 0.0,
            rates: Rates::default(),
            grains: None,
            equilibrium: none,
            ends: None,
            memory: None,
            twins: None,
            bends,
            forms,
            own: None,
            stroke,
            now: Now {
                h: 1.0,
                shift: 0.0,
                strain: 0.0,
                load: LoadForce { fixed: 0.0, whole: 0.0 },
                lag: LagWeights::NONE,
                drive: Driven { duty: 0.0, power: 0.0, current: 0.0, supply: 0.0 },
                grip: None,
            },
        })
    }

    /// Starts from rest in `state`.
    pub(crate) fn settle(&mut self, c: &Reference, state: &State, asked: Fraction, ambient: f64) {
        self.equilibrium = state.fraction;
        self.grains = self.effects.kinetic.grains(&c.hysteresis, asked, state.theta);
        self.air.settle(state.temperature, ambient);
        self.ends = Ends::of(c, &self.effects);
        if let Some(mut ends) = self.ends.take() {
            ends.settle(c, &self.around(), state, asked, ambient);
            self.ends = Some(ends);
        }
        let features = self.features(state, 0.0, ambient);
        self.begin_own(state, 0.0, ambient, 0.0);
        if let Some(form) = &mut self.air.extra.form {
            *form = form_of_temperature(&self.effects.empirical.thermal, features.0[Term::Position as usize]);
        }
        self.now.shift = self.shift_of(&features);
        self.now.strain = self.strain_of(&features, state);
        let load = self.load_of(&features);
        self.now.load = LoadForce { fixed: load, whole: load };
    }

    /// Σ c φ of a closed form but for the terms that are solved with the end of a piece.
    fn sum(&self, form: &Form, solved: &[Term], phi: &Features) -> f64 {
        if self.forms { form.sum_without(solved, phi) } else { 0.0 }
    }

    /// What the phase sees besides T − σ/α without the rate of the phase, K.
    fn shift_of(&self, phi: &Features) -> f64 {
        let (known, form) = (&self.effects.kinetic, &self.effects.empirical.kinetic);
        let own = self.own.as_ref().map_or(0.0, |own| own.now().shift);
        self.unknown.driving_k + self.sum(form, &[Term::PhaseRate], phi) - known.moved(self.travel) + own
    }

    /// Strain without stress that is not solved with the end of a piece which begins in `start`.
    fn strain_of(&self, phi: &Features, start: &State) -> f64 {
        let (known, form) = (&self.effects.mechanical, &self.effects.empirical.mechanical);
        let (stress, martensite) = (start.stress, start.fraction.martensite);
        let own = self.own.as_ref().map_or(0.0, |own| own.now().fixed_strain(stress, martensite));
        self.unknown.strain + known.permanent(self.travel) + self.sum(form, &IMPLICIT_STRAIN, phi) + own
    }

    /// Force on the load besides the reference model's, N.
    fn load_of(&self, phi: &Features) -> f64 {
        let own = self.own.as_ref().map_or(0.0, |own| own.now().force);
        self.unknown.load_n + self.sum(&self.effects.empirical.load, &[], phi) + own
    }

    /// What laws may use of a state at `time` s.
    fn quantities(&self, size: &Size, state: &State, time: f64, ambient: f64) -> Quantities {
        let Driven { duty, power, current, supply } = self.now.drive;
        let Rates { velocity, phase, warming } = self.rates;
        let Fraction { martensite, austenite } = state.fraction;
        let tension = size.area * state.stress;
        [
            state.temperature,
            ambient,
            martensite,
            austenite,
            state.stress,
            tension,
            state.position,
            velocity,
            warming,
            phase,
            state.resistance,
            current,
            power,
            duty,
            supply,
            time,
            size.length,
            size.diameter,
            size.surface,
            size.mass,
        ]
    }

    /// Prepares the users' laws for a piece of `h` s that begins in `start`.
    fn begin_own(&mut self, start: &State, time: f64, ambient: f64, h: f64) {
        if let Some(mut own) = self.own.take() {
            own.begin(self.quantities(&own.size, start, time, ambient), start.velocity, h);
            self.own = Some(own);
        }
    }

    /// The first formula of a user's law that was not defined.
    pub(crate) fn undefined(&self) -> Option<Undefined> {
        self.own.as_ref().and_then(OwnTerms::undefined)
    }

    /// How far stress moves the cooling curve besides ϑ, in K; `None` where it does not.
    pub(crate) fn cooling_shift(&self, stress: f64) -> Option<f64> {
        let extra = self.effects.kinetic.unequal_slopes.cooling_extra_k_per_pa;
        (extra != 0.0).then_some(extra * stress)
    }

    /// Prepares the piece of length `h` that begins in `start`.
    pub(crate) fn begin(&mut self, c: &Reference, inputs: &Inputs, start: &State, h: f64) {
        let (t0, t1) = (self.time, self.time + h);
        let ambient = self.air.ambient_over(inputs.ambient_c, t0, t1);
        let power = c.power(inputs, start.resistance);
        let duty = if c.drive == DriveKind::Pwm { inputs.drive } else { 0.0 };
        let drive = Driven { duty, power, current: c.current(inputs, start.resistance), supply: inputs.supply_v };
        self.now.drive = drive;
        self.begin_own(start, t0, ambient.start, h);
        let e = &self.effects;
        let features = self.features(start, t0, ambient.start);
        let extra = self.extra_loss(&features, start);
        self.now = Now {
            h,
            shift: self.shift_of(&features),
            strain: self.strain_of(&features, start),
            load: LoadForce {
                fixed: self.unknown.load_n + self.sum(&e.empirical.load, &MOVED_LOAD, &features),
                whole: self.load_of(&features),
            },
            lag: e.kinetic.lag.weights(h),
            drive,
            grip: e.mechanical.grip(c.area * start.stress),
        };
        self.air.begin(start, h, (t0, t1), ambient, extra);
        if let Some(mut ends) = self.ends.take() {
            ends.begin(c, &self.around(), start, h);
            self.ends = Some(ends);
        }
    }

    /// Closes the piece that went from `start` to `end`, on `branch` if the phase moved, with this ledger for a wire all
    /// like its middle and nothing around it; returns the ledger of what there is.
    pub(crate) fn finish(
        &mut self,
        c: &Reference,
        branch: Option<&Branch>,
        start: &State,
        end: &State,
        mut ledger: Ledger,
    ) -> Ledger {
        let h = self.now.h;
        if let Some(mut ends) = self.ends.take() {
            ledger = ends.advance(c, &self.around(), h, [start, end], ledger);
            self.ends = Some(ends);
        }
        match (&mut self.grains, branch) {
            (Some(grains), Some(branch)) => grains.arrive(&c.hysteresis, branch.direction(), end.theta),
            (Some(grains), None) => grains.stay(&c.hysteresis, end.theta),
            (None, _) => {}
        }
        self.equilibrium = if self.now.lag.end == 1.0 {
            end.fraction
        } else if let Some(branch) = branch {
            self.on_branch(&c.hysteresis, branch, end.theta).fraction
        } else {
            self.standing_equilibrium(&c.hysteresis, end.theta).fraction
        };
        let change = end.fraction.change_from(&start.fraction);
        self.travel += change.abs();
        if self.forms || self.own.is_some() {
            let heard = -(-h / RATE_MEMORY_S).exp_m1();
            let hear = |mean: &mut f64, moved: f64| *mean += heard * (moved / h - *mean);
            hear(&mut self.rates.velocity, end.position - start.position);
            hear(&mut self.rates.phase, change);
            hear(&mut self.rates.warming, end.temperature - start.temperature);
        }
        if let Some(twins) = &mut self.twins {
            twins.arrive(&end.fraction, end.stress);
        }
        self.time += h;
        if let Some(mut own) = self.own.take() {
            let quantities = self.quantities(&own.size, end, self.time, self.air.ambient(At::End));
            own.finish(&quantities, h, self.time);
            self.own = Some(own);
        }
        if let Some(kept) = self.air.finish(end.temperature) {
            ledger.lost -= kept;
        }
        ledger
    }

    /// What the cold ends need to know of the piece.
    fn around(&self) -> Beside<'_> {
        Beside { air: &self.air, effects: &self.effects, power: self.now.drive.power }
    }

    /// The loss besides the mechanisms', in a piece that begins in `start` with these functions.
    fn extra_loss(&self, phi: &Features, start: &State) -> Extra {
        let form = &self.effects.empirical.thermal;
        let (heat, per_k) = self.own.as_ref().map_or((0.0, 0.0), |own| (own.now().heat, own.now().heat_per_k));
        let own = per_k * start.temperature - heat;
        let fixed = self.sum(form, &IMPLICIT_LOSS, phi) - self.unknown.heat_w + own;
        Extra {
            fixed,
            per_k: -per_k,
            form: self.forms.then(|| form_of_temperature(form, phi.0[Term::Position as usize])),
        }
    }
}

/// The part of the empirical loss that depends on T, on a load `moved` so far, in x/(ε_L L_0).
fn form_of_temperature(form: &Form, moved: f64) -> ExtraForm {
    ExtraForm { linear: form.get(Term::Tau) + form.get(Term::MovedWarm) * moved, square: form.get(Term::Tau2) }
}

/// Terms of the empirical strain that are solved with the end of the piece.
const IMPLICIT_STRAIN: [Term; 4] = [Term::Martensite, Term::Mixed, Term::Stress, Term::Stress2];
/// Terms of the empirical load that depend on the load's movement.
const MOVED_LOAD: [Term; 6] = [Term::Position, Term::Position2, Term::Position3, Term::Velocity, Term::Drag, Term::Dry];
/// Terms of the empirical loss that are solved with the end of the piece.
const IMPLICIT_LOSS: [Term; 3] = [Term::Tau, Term::Tau2, Term::MovedWarm];

// heat
impl Terms {
    /// Losses through the surface, with what goes into the ends.
    fn losses(&self, c: &Reference, temperature: f64, at: At, sleeve: Sleeve, power: f64) -> HeatFlow {
        let surface = self.air.surface(&c.skin, temperature, at, sleeve);
        match &self.ends {
            None => surface,
            Some(ends) => {
                let into = ends.loss(temperature, at, power);
                HeatFlow { watts: surface.watts + into.watts, per_k: surface.per_k + into.per_k }
            }
        }
    }

    /// All losses at the start of the piece, W.
    pub(crate) fn loss_at_start(&self, c: &Reference, start: &State, power: f64) -> f64 {
        self.losses(c, start.temperature, At::Start, self.air.sleeve(start.temperature, At::Start), power).watts
    }

    /// All losses at the end of the piece as their tangent at `guess`, which weigh `tau` s in the heat balance.
    pub(crate) fn loss_at_end(&self, c: &Reference, guess: f64, power: f64, tau: f64) -> Loss {
        let flow = self.losses(c, guess, At::End, self.air.sleeve_ahead(), power);
        // a gain that grows with T must not outrun the wire's own capacity within a piece
        let coefficient = flow.per_k.max(-0.5 * c.heat_capacity / tau);
        let ambient = self.air.ambient(At::End);
        Loss { coefficient, ambient, fixed: flow.watts - coefficient * (guess - ambient) }
    }
}

// the phase
impl Terms {
    /// What the phase sees besides T − σ/α at the end of the piece, if ξ changes by `change`, in K.
    pub(crate) fn shift(&self, change: f64) -> f64 {
        self.now.shift + self.shift_per_fraction() * change
    }

    /// How the shift depends on the change of ξ, in K.
    pub(crate) fn shift_per_fraction(&self) -> f64 {
        self.effects.empirical.kinetic.get(Term::PhaseRate) / self.now.h
    }

    /// ξ_eq at ϑ.
    fn on_branch(&self, hysteresis: &Hysteresis, branch: &Branch, theta: f64) -> Point {
        match &self.grains {
            None => hysteresis.on_branch(branch, theta),
            Some(grains) => grains.at(hysteresis, branch.direction(), theta),
        }
    }

    fn standing_equilibrium(&self, hysteresis: &Hysteresis, theta: f64) -> Point {
        match &self.grains {
            None => Point { fraction: hysteresis.clip(self.equilibrium, theta), slope: 0.0, outer: false },
            Some(grains) => grains.standing(hysteresis, theta),
        }
    }

    /// ξ at the end of the piece, which lags behind ξ_eq.
    fn lagging(&self, equilibrium: Point, from: &State) -> Point {
        let LagWeights { end, start, now } = self.now.lag;
        if end == 1.0 {
            return equilibrium;
        }
        let mix = |e: f64, s: f64, f: f64| end * e + start * s + now * f;
        let (e, s, f) = (&equilibrium.fraction, &self.equilibrium, &from.fraction);
        let fraction = Fraction {
            martensite: mix(e.martensite, s.martensite, f.martensite),
            austenite: mix(e.austenite, s.austenite, f.austenite),
        };
        Point { fraction, slope: end * equilibrium.slope, outer: equilibrium.outer }
    }

    /// The phase at the end of the piece at ϑ, on its branch.
    pub(crate) fn point(&self, hysteresis: &Hysteresis, branch: &Branch, theta: f64, from: &State) -> Point {
        self.lagging(self.on_branch(hysteresis, branch, theta), from)
    }

    /// The phase at the end of the piece if ϑ stands still.
    pub(crate) fn standing(&self, hysteresis: &Hysteresis, from: &State) -> Point {
        self.lagging(self.standing_equilibrium(hysteresis, from.theta), from)
    }

    /// The branch that leaves ϑ in `direction`.
    pub(crate) fn reverse(&mut self, hysteresis: &Hysteresis, direction: Direction, theta: f64) -> Branch {
        if let Some(grains) = &mut self.grains {
            grains.reverse(hysteresis, direction, theta);
        }
        hysteresis.reverse(direction, theta, &self.equilibrium)
    }

    /// `asked` clipped into the outer curves at ϑ, for a wire at rest.
    pub(crate) fn clip(&self, hysteresis: &Hysteresis, asked: Fraction, theta: f64) -> Fraction {
        match self.effects.kinetic.grains(hysteresis, asked, theta) {
            None => hysteresis.clip(asked, theta),
            Some(grains) => grains.standing(hysteresis, theta).fraction,
        }
    }

    /// Least and most martensite there can be at ϑ.
    pub(crate) fn bounds(&self, hysteresis: &Hysteresis, theta: f64) -> (Fraction, Fraction) {
        match &self.grains {
            None => (hysteresis.lower(theta), hysteresis.upper(theta)),
            Some(grains) => grains.bounds(hysteresis, theta),
        }
    }
}

// strain and load
impl Terms {
    /// Shape strain per ξ under a stress in Pa, where it is the same for all martensite.
    pub(crate) fn shape(&self, transformation_strain: f64, stress: f64) -> f64 {
        let alike = if self.twins.is_some() { 0.0 } else { transformation_strain };
        self.effects.mechanical.shape(alike, stress)
    }

    /// Constant strain of the piece.
    pub(crate) fn strain(&self) -> f64 {
        self.now.strain
    }

    /// What friction holds in this piece.
    pub(crate) fn grip(&self) -> Option<Grip> {
        self.now.grip
    }

    /// What pulls on the load besides the reference model, N: all of it at its start value, for imposed loads.
    pub(crate) fn imposed_load(&self) -> f64 {
        self.now.load.whole
    }

    /// What pulls on a moving load besides the reference model. The movement weighs `tau` s.
    pub(crate) fn moving_load(&self, start: &State, mass: f64, tau: f64) -> MovingLoad {
        let mut load = self.moving_form(start, mass, tau);
        if let Some(own) = &self.own {
            let now = own.now();
            // as below: what drives the load away must not outrun its mass within a piece
            let per_m = now.force_per_m.min(0.5 * mass / (tau * tau));
            let per_m_s = now.force_per_m_s.min(0.5 * mass / tau);
            load.force += now.force - per_m * start.position - per_m_s * start.velocity;
            load.spring -= per_m;
            load.damping -= per_m_s;
        }
        load
    }

    /// The closed form's part of it.
    fn moving_form(&self, start: &State, mass: f64, tau: f64) -> MovingLoad {
        let form = &self.effects.empirical.load;
        let mut force = self.now.load.fixed;
        if !form.is_on() {
            return MovingLoad { force, spring: 0.0, damping: 0.0 };
        }
        let r = start.position / self.stroke;
        let bounded = r.clamp(-MOST_POSITION, MOST_POSITION);
        let [a, b, c] = [Term::Position, Term::Position2, Term::Position3].map(|term| form.get(term));
        let value = ((c * bounded + b) * bounded + a) * bounded;
        let slope = if bounded == r { ((3.0 * c * r + 2.0 * b) * r + a) / self.stroke } else { 0.0 };
        // what drives the load away must not outrun its mass within a piece
        let slope = slope.min(0.5 * mass / (tau * tau));
        force += value - slope * start.position;
        let v = start.velocity;
        let (velocity, drag, dry) = (form.get(Term::Velocity), form.get(Term::Drag), form.get(Term::Dry));
        let turned = (v / DRY_M_S).tanh();
        let value = velocity * v / VELOCITY_M_S + drag * v.abs() * v / (VELOCITY_M_S * VELOCITY_M_S) + dry * turned;
        let steeper = velocity / VELOCITY_M_S
            + 2.0 * drag * v.abs() / (VELOCITY_M_S * VELOCITY_M_S)
            + dry * (1.0 - turned * turned) / DRY_M_S;
        force += value - steeper * v;
        MovingLoad { force, spring: -slope, damping: -steeper }
    }
}

/// Unit of the library's velocity, m/s.
const VELOCITY_M_S: f64 = 0.01;
/// Speed over which the library's sign of v turns, m/s.
const DRY_M_S: f64 = 1e-4;
/// Unit of the library's stress, Pa.
pub(crate) const STRESS_PA: f64 = 1e8;

// sensing and the library
impl Terms {
    /// The library's functions in a state.
    pub(crate) fn features(&self, state: &State, time: f64, ambient: f64) -> Features {
        let mut phi = [0.0; Term::COUNT];
        if !self.forms {
            return Features(phi);
        }
        let tau = ((state.temperature - ambient) / WORKING_EXCESS_K).clamp(-MOST_WARM, MOST_WARM);
        let stress = (state.stress / STRESS_PA).clamp(0.0, MOST_STRESS);
        let r = (state.position / self.stroke).clamp(-MOST_POSITION, MOST_POSITION);
        let v = (self.rates.velocity / VELOCITY_M_S).clamp(-MOST_RATE, MOST_RATE);
        let xi = state.fraction.martensite;
        for (term, value) in [
            (Term::Tau, tau),
            (Term::Tau2, tau * tau),
            (Term::Martensite, xi),
            (Term::Mixed, xi * state.fraction.austenite),
            (Term::Stress, stress),
            (Term::Stress2, stress * stress),
            (Term::Position, r),
            (Term::Position2, r * r),
            (Term::Position3, r * r * r),
            (Term::Velocity, v),
            (Term::Drag, v.abs() * v),
            (Term::Dry, (self.rates.velocity / DRY_M_S).tanh()),
            (Term::Power, self.now.drive.power.clamp(0.0, MOST_POWER)),
            (Term::Duty, self.now.drive.duty.clamp(0.0, 1.0)),
            (Term::PhaseRate, self.rates.phase.clamp(-MOST_RATE, MOST_RATE)),
            (Term::Warming, (self.rates.warming / 100.0).clamp(-MOST_RATE, MOST_RATE)),
            (Term::MovedWarm, r * tau),
            (Term::Time, time / 100.0),
        ] {
            phi[term as usize] = value;
        }
        Features(phi)
    }

    /// The relative factor on resistivity in a state at the end of the piece.
    pub(crate) fn resistivity_factor(&self, state: &State) -> f64 {
        let form = &self.effects.empirical.electrical;
        let mut change = self.unknown.resistivity;
        if self.forms && form.is_on() {
            change += form.sum(&self.features(state, self.time + self.now.h, self.air.ambient(At::End)));
        }
        if let Some(own) = self.own.as_ref().filter(|own| own.enters(Entry::Resistivity)) {
            let end = self.time + self.now.h;
            change += own.sum(Entry::Resistivity, &self.quantities(&own.size, state, end, self.air.ambient(At::End)));
        }
        (1.0 + change).max(0.05)
    }

    /// The library's functions as they are now, after a step.
    pub(crate) fn features_now(&self, state: &State) -> Features {
        self.features(state, self.time, self.air.ambient(At::End))
    }

    /// Adds what the users' laws make of what sensors see now, after a step.
    pub(crate) fn show_own(&self, state: &State, o: &mut Outputs) {
        if let Some(own) = &self.own {
            let mut quantities = self.quantities(&own.size, state, self.time, self.air.ambient(At::End));
            quantities[CURRENT] = o.current_a;
            own.show(&quantities, o);
        }
    }

    /// Remembers what the delayed sensor shows at the start.
    pub(crate) fn remember(&mut self, o: &Outputs) {
        self.memory = self.effects.sensing.delay.memory(o);
    }

    /// Whether a sensor is delayed.
    pub(crate) fn is_delayed(&self) -> bool {
        self.memory.is_some()
    }

    /// Keeps what the delayed sensor sees at time `t`.
    pub(crate) fn keep(&mut self, t: f64, o: &Outputs) {
        if let Some(memory) = &mut self.memory {
            memory.keep(t, o);
        }
    }

    /// Puts what the delayed sensor shows in its place.
    pub(crate) fn recall(&self, o: &mut Outputs) {
        if let Some(memory) = &self.memory {
            memory.recall(o);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{Detwinning, Drive, Geometry, Initial, Load, Material};

    /// A wire without effects and without detwinning has no terms: it takes the reference model's own steps, bit for bit.
    #[test]
    fn detwinning_makes_terms_and_nothing_else_does() {
        let mut model = WireModel {
            geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
            material: Material::default(),
            taps: None,
            drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
            load: Load::ImposedForce,
            initial: Initial::default(),
            ambient_c: 25.0,
            effects: Effects::default(),
        };
        assert!(Terms::of(&model).is_none());
        model.effects.mechanical.friction.coulomb_n = 0.1;
        assert!(Terms::of(&model).is_some_and(|terms| terms.twins.is_none() && !terms.bends));
        model.effects = Effects::default();
        model.material.detwinning = Some(Detwinning { start_pa: 100e6, finish_pa: 170e6 });
        assert!(Terms::of(&model).is_some_and(|terms| terms.twins.is_some() && terms.bends));
    }
}
