//! Fusion of all measurements of a wire: length by dual measurement, resistance of the whole wire,
//! electrical power, and the model.
//!
//! Two Kalman filters, each with what the other says as given, so that noise of one cannot circulate:
//!
//! - **Motion**: length and a slowly decaying bias of the velocity. The velocity itself comes from the wire: one that is
//!   hotter than its heating curve shortens by its excess temperature over κ, the drag's share of the stress shift (eq. 12, 51),
//!   one that is colder than its cooling curve lengthens, and in between only thermal strain moves it (eq. 6). The filter
//!   so needs little bandwidth where a filter without model would lag.
//! - **Heat**: temperature, loss to the air, resistivity of both phases and place of both curves. The heat balance (eq. 48)
//!   predicts, with the phase from the length (eq. 6, 23). Two measurements correct: the resistivity R A_c/L
//!   (eq. 39, 44: the length is known, so what is left of the resistance is temperature, which is a thermometer for a wire that stands still), and
//!   for a wire that moves the curve it has to be on. The covariance attributes a difference to
//!   loss, resistivities or curves.
//!
//! Without a length the motion goes on by the model alone: a kelvin changes the resistance as much as a quarter of a millimetre does,
//! so that it says nothing of the length that the heat balance does not say better.

use super::surface::Surface;
use crate::cycle::{self, COLDEST_C, Curves, HOTTEST_C, SHORTEST_STEP_S, Start, inside};
use crate::estimate::{Estimate, Observation};
use crate::lambda;
use crate::wire_map::WireMap;
use sinew_physics::WireModel;
use sinew_physics::formulas::{logistic, resistivity_ohm_m};

/// Correlation time of the velocity's bias, s.
const BIAS_TIME_S: f64 = 0.1;
/// Spread of the bias of a standing wire, in the cooling speed, and of a moving one, as a share of its velocity.
const BIAS_STANDING: f64 = 0.015;
const BIAS_MOVING: f64 = 0.12;
/// Fastest a wire is taken to follow its temperature, 1/s: with a load that hardly damps it, a kelvin of error is half a millimetre.
const STIFFEST_PER_S: f64 = 20.0;
/// What is left of the error of a moving wire's excess temperature, in widths 1/k.
const EXCESS_MODEL: f64 = 0.04;
/// Time over which innovations of the length are averaged, in samples, and the mean (in standard deviations) beyond which the
/// model has lost the wire.
const LOST_SAMPLES: f64 = 12.0;
const LOST_SIGMAS: f64 = 1.2;
/// Time over which what the model leaves out keeps its sign, s: a measurement that is wrong by the model counts once in it.
const MODEL_TIME_S: f64 = 0.1;
/// What the model leaves out of the resistivity, as a share of it.
const RESISTIVITY_MODEL: f64 = 0.7e-3;
/// Noise of a resistance at the least, as a share of it, and where nothing is said of it. That of the current is the larger part of it.
const RESISTANCE_NOISE: f64 = 1e-3;
/// What it leaves out of the curve a moving wire is on, in widths 1/k.
const CURVE_MODEL: f64 = 0.35;
/// Share of the cooling speed below which a wire counts as standing; four times as fast is surely moving.
const STANDING: f64 = 0.14;
/// Share of the latent heat that is not as the model has it.
const LATENT_MODEL: f64 = 0.05;
/// Share of a change of temperature that is not as the model has it, where the curves say nothing of it: heat capacity is none of the filter's
/// states. Without it a wire that heats and cools quicker than believed is taken for one of another resistivity, and is tens of kelvins hotter.
const CAPACITY_MODEL: f64 = 0.2;
/// Time over which what the heat balance is linearised at is averaged, s: gains that follow the noise of what they correct are biased by it.
const LINEAR_TIME_S: f64 = 1.0;
/// Time, s, in which what resistance is read by is learned at the hot end, where nothing else tells the temperature; less and less after it.
const LEARNED_HOT_S: f64 = 4.0;
/// Drift of the heat filter's states, per √s. What changes a resistivity takes days.
const DRIFT: Spread =
    Spread { temperature_k: 0.3, loss: 0.15, resistivities: 3e-4, curves_widths: 0.03, latent_heat: 0.01 };
/// Their spread at the start.
const AT_START: Spread =
    Spread { temperature_k: 6.0, loss: 0.3, resistivities: 0.01, curves_widths: 1.2, latent_heat: 0.2 };
/// Innovations beyond so many standard deviations count as that many: a model that is wrong is no reason to jump.
const HUBER: f64 = 3.0;
/// Rate at which the strain is learned from a wire at its cold end, 1/s.
const STRAIN_RATE: f64 = 4.0;
/// Colder than its cooling curve by so many widths on top of what the air's fastest cooling needs, a wire is at its cold end.
const COLD: f64 = 2.0;
/// Faster than any wire moves, m/s.
const MOST_M_PER_S: f64 = 100.0;

/// States of the heat filter.
const STATES: usize = 7;
const T: usize = 0;
/// Loss to the air over what the model says.
const LOSS: usize = 1;
/// Resistivity of austenite and martensite over what the model says, less 1.
const RHO_A: usize = 2;
const RHO_M: usize = 3;
/// How far the heating and the cooling curve lie above where the model has them, K.
const HEATING: usize = 4;
const COOLING: usize = 5;
/// Latent heat over what the model says.
const LATENT: usize = 6;

/// Standard deviations of the heat filter's states.
#[derive(Debug, Clone, Copy)]
struct Spread {
    temperature_k: f64,
    /// Shares of what the model says, here and below.
    loss: f64,
    resistivities: f64,
    /// Places of both curves, in widths 1/k.
    curves_widths: f64,
    latent_heat: f64,
}

impl Spread {
    /// State by state, for a wire.
    fn of_states(&self, m: &WireMap) -> [f64; STATES] {
        let curves = self.curves_widths;
        [
            self.temperature_k,
            self.loss,
            self.resistivities,
            self.resistivities,
            curves * m.heating_width,
            curves * m.cooling_width,
            self.latent_heat,
        ]
    }
}

/// A scalar that says something of the heat filter's state: `surprise` = measured − predicted, the slopes of the prediction (all
/// others are 0) and its variance.
struct Evidence<const N: usize> {
    surprise: f64,
    slopes: [(usize, f64); N],
    variance: f64,
}

/// The heat filter's state and covariance.
#[derive(Debug, Clone)]
struct Heat {
    state: [f64; STATES],
    covariance: [[f64; STATES]; STATES],
}

impl Heat {
    fn new(temperature_c: f64, map: &WireMap) -> Heat {
        let mut covariance = [[0.0; STATES]; STATES];
        for (k, spread) in AT_START.of_states(map).into_iter().enumerate() {
            covariance[k][k] = spread * spread;
        }
        Heat { state: [temperature_c, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0], covariance }
    }

    /// Moves the covariance on where the temperature depends on itself, on the loss and on the latent heat by these.
    #[inline]
    fn predict(&mut self, own: f64, loss: f64, latent: f64, noise: &[f64; STATES]) {
        let p = &mut self.covariance;
        // T' = own·T + loss·s: one row and column change
        let mut row = [0.0; STATES];
        for (k, entry) in row.iter_mut().enumerate() {
            *entry = own * p[T][k] + loss * p[LOSS][k] + latent * p[LATENT][k];
        }
        let corner = own * row[T] + loss * row[LOSS] + latent * row[LATENT];
        for k in 1..STATES {
            p[T][k] = row[k];
            p[k][T] = row[k];
        }
        p[T][T] = corner;
        for (k, noise) in noise.iter().enumerate() {
            p[k][k] += noise;
        }
    }

    /// Takes a measurement in. Joseph's form is not needed: gains are small and the drift keeps the covariance up.
    /// `learns`: the share of each state's correction that is taken, 0 for one that is considered and not learned (Schmidt's filter).
    #[inline]
    fn correct<const N: usize>(&mut self, seen: &Evidence<N>, learns: &[f64; STATES]) {
        let p = &mut self.covariance;
        let mut column = [0.0; STATES];
        for (state, slope) in seen.slopes {
            for (entry, covariance) in column.iter_mut().zip(p[state]) {
                *entry += slope * covariance;
            }
        }
        let spread = seen.variance + seen.slopes.iter().map(|(state, slope)| slope * column[*state]).sum::<f64>();
        if !(spread > 0.0 && spread.is_finite() && seen.surprise.is_finite()) {
            return;
        }
        let scale = 1.0 / spread;
        let most = HUBER * spread.sqrt();
        let surprise = seen.surprise.max(-most).min(most);
        for k in 0..STATES {
            let gain = column[k] * scale;
            self.state[k] += learns[k] * gain * surprise;
            for ((entry, column), other) in p[k].iter_mut().zip(column).zip(learns) {
                *entry -= (learns[k] + other - learns[k] * other) * gain * column;
            }
        }
    }
}

/// What the heat balance is linearised at where no curve tells the temperature: averages, not the estimates of the moment.
#[derive(Debug, Clone, Copy)]
struct Linear {
    /// Loss over what the model says.
    loss: f64,
    /// What the model says of it, W.
    loss_w: f64,
    /// Rate of the temperature without what latent heat makes of it, K/s.
    k_per_s: f64,
}

impl Linear {
    /// Of a wire at rest in its air.
    const AT_REST: Linear = Linear { loss: 1.0, loss_w: 0.0, k_per_s: 0.0 };

    #[inline]
    fn follow(&mut self, loss: f64, loss_w: f64, k_per_s: f64, dt: f64) {
        let (slowly, quickly) = (dt / (dt + LINEAR_TIME_S), dt / (dt + MODEL_TIME_S));
        self.loss += slowly * (loss - self.loss);
        self.loss_w += slowly * (loss_w - self.loss_w);
        self.k_per_s += quickly * (k_per_s - self.k_per_s);
    }
}

/// The motion filter's state and covariance.
#[derive(Debug, Clone, Copy)]
struct Motion {
    /// Elongation, m.
    x: f64,
    /// Velocity by the model, m/s.
    model: f64,
    /// Velocity beyond the model's, m/s.
    bias: f64,
    /// Variances of both and their covariance.
    xx: f64,
    xb: f64,
    bb: f64,
}

impl Motion {
    #[inline]
    fn correct(&mut self, surprise: f64, slope: f64, variance: f64) {
        let spread = slope * slope * self.xx + variance;
        if !(spread > 0.0 && spread.is_finite() && surprise.is_finite()) {
            return;
        }
        let (gain, gain_b) = (slope * self.xx / spread, slope * self.xb / spread);
        self.x += gain * surprise;
        self.bias += gain_b * surprise;
        self.bb -= gain_b * slope * self.xb;
        self.xb *= 1.0 - gain * slope;
        self.xx *= 1.0 - gain * slope;
    }
}

/// The velocity by the model.
#[derive(Debug, Clone, Copy)]
struct ModelVelocity {
    velocity_m_s: f64,
    /// By how much it falls per metre, 1/s.
    falls_per_s: f64,
    /// What it may be off, m/s.
    doubt_m_s: f64,
}

/// Length, temperature, phase and loss of one wire from all that is measured of it.
#[derive(Debug, Clone)]
pub struct FusedEstimator {
    map: WireMap,
    cooling_speed: f64,
    /// Time in which the load's inertia follows its damping, s.
    inertia_s: f64,
    motion: Motion,
    heat: Heat,
    surface: Surface,
    linear: Linear,
    /// How long the wire has been at its hot end, s.
    hot_s: f64,
    fraction: f64,
    /// Transformation strain over what the model says.
    strain: f64,
    /// Rate of the temperature in the last cycle, K/s.
    rate: f64,
    hottest: f64,
    full_power: f64,
    /// Mean innovation of the length, in standard deviations.
    astray: f64,
    /// Variance of a length, m²: as said, else as seen.
    variance: f64,
    /// Whether a length has come yet.
    seen: bool,
    start: Start,
}

impl FusedEstimator {
    /// An estimator for a wire that starts as the model says: at its initial temperature (ambient) and phase.
    pub fn new(model: &WireModel) -> FusedEstimator {
        let map = WireMap::new(model);
        let speeds = lambda::speeds(&map, map.full_power);
        let start = Start::of(model);
        let mut estimator = FusedEstimator {
            cooling_speed: speeds.cooling.max(1e-3 * map.length * map.strain.max(1e-3)),
            inertia_s: map.inertia_s(),
            motion: Motion { x: 0.0, model: 0.0, bias: 0.0, xx: 0.0, xb: 0.0, bb: 0.0 },
            heat: Heat::new(start.temperature_c, &map),
            surface: Surface::of(model, &map),
            linear: Linear::AT_REST,
            hot_s: 0.0,
            fraction: 1.0,
            strain: 1.0,
            rate: 0.0,
            hottest: start.temperature_c,
            full_power: map.full_power,
            astray: 0.0,
            variance: 0.0,
            seen: false,
            start,
            map,
        };
        estimator.reset();
        estimator
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        self.begin_at(self.start.temperature_c);
    }

    /// Back to the start, for a wire that is known to be as hot as this, °C.
    pub fn begin_at(&mut self, temperature_c: f64) {
        let m = &self.map;
        self.heat = Heat::new(temperature_c, m);
        self.surface.settle(temperature_c);
        (self.linear, self.hot_s) = (Linear::AT_REST, 0.0);
        let stress = m.stress(m.strain * m.length, 0.0);
        self.fraction = self.start.martensite.clamp(0.0, 1.0);
        let x = m.elongation(self.fraction, stress, temperature_c);
        let spread = 0.3 * m.strain * m.length;
        self.motion = Motion { x, model: 0.0, bias: 0.0, xx: spread * spread, xb: 0.0, bb: 0.0 };
        (self.rate, self.hottest, self.full_power) = (0.0, temperature_c, m.full_power);
        self.strain = 1.0;
        (self.astray, self.variance, self.seen) = (0.0, (0.01 * spread).powi(2), false);
    }

    /// Phase at an elongation and stress (eq. 6, 23), for the strain as learned.
    #[inline]
    fn fraction_at(&self, x: f64, stress: f64) -> f64 {
        (self.map.fraction(x, stress, self.heat.state[T]) / self.strain).clamp(0.0, 1.0)
    }

    /// What the model says of the velocity.
    #[inline]
    fn model_velocity(&self, dt: f64) -> ModelVelocity {
        let m = &self.map;
        let temperature = self.heat.state[T];
        let stress = m.stress(self.motion.x, 0.0);
        let fraction = self.fraction_at(self.motion.x, stress);
        let s = stress + m.thermoelastic * (temperature - m.reference);
        let curves = Curves::at(m, fraction, stress);
        let above = temperature - (curves.heating_c + self.heat.state[HEATING]);
        let below = temperature - (curves.cooling_c + self.heat.state[COOLING]);
        let (excess, width) = if above > 0.0 {
            (above, m.heating_width)
        } else if below < 0.0 && !self.is_cold(below, fraction, s) {
            (below, m.cooling_width)
        } else {
            let velocity_m_s = m.thermal_expansion(fraction) * self.rate;
            return ModelVelocity { velocity_m_s, falls_per_s: 0.0, doubt_m_s: 0.0 };
        };
        let branch = m.branch(fraction, s);
        let slope = branch.kelvin_per_metre(width);
        let k = slope / (branch.drag(width).max(slope / STIFFEST_PER_S) + slope * dt);
        ModelVelocity {
            velocity_m_s: -excess * k / slope + m.thermal_expansion(fraction) * self.rate,
            falls_per_s: k,
            doubt_m_s: EXCESS_MODEL * width * k / slope,
        }
    }

    /// Takes one cycle in.
    #[inline]
    pub fn update(&mut self, seen: &Observation) -> Estimate {
        cycle::in_steps([seen], |[seen], dt| self.step(seen, dt))
    }

    #[inline]
    fn step(&mut self, seen: &Observation, dt: f64) -> Estimate {
        let length_seen = seen.length_m - self.map.length;
        // a length that no wire can have is none
        let measured = length_seen.abs() < self.map.length;
        let velocity = self.follow(if measured { length_seen } else { f64::NAN }, seen, dt);
        let velocity = if self.is_sane(velocity) {
            velocity
        } else {
            // Inputs that no wire gives: forget what they did rather than pass it on. That no wire is like this does not make
            // this one cold: it is as hot as it can have been.
            let hottest = if self.hottest.is_finite() { self.hottest } else { HOTTEST_C };
            self.begin_at(hottest.clamp(self.start.temperature_c, HOTTEST_C));
            0.0
        };
        let m = &self.map;
        let x = self.motion.x;

        let power = cycle::power(m, seen, || m.power_at_full_duty(self.fraction, self.heat.state[T], x));
        self.full_power = cycle::full_power(m, seen, power, self.full_power);
        let stress = cycle::stress(m, seen, x, velocity);

        let before = self.heat.state[T];
        self.balance(power, stress, dt);
        let fraction = self.fraction;
        let curves = Curves::at(&self.map, fraction, stress);
        if measured && dt > 0.0 {
            let patience = MODEL_TIME_S / dt.max(1e-6);
            self.weigh_resistivity(seen, patience);
            if !self.learn_strain(curves.cooling_c, stress, dt) {
                self.weigh_curves(&curves, velocity, patience);
            }
        }
        self.keep_in_range();
        self.surface.follow(self.heat.state[T], self.heat.state[LOSS], dt);
        let (m, state) = (&self.map, &self.heat.state);
        let temperature = state[T];
        if dt > 0.0 {
            let fresh = (dt / 0.02).min(1.0);
            self.rate += fresh * ((temperature - before) / dt - self.rate);
        }
        self.hottest = cycle::hottest(m, self.hottest, power, dt, temperature);
        Estimate {
            temperature_c: temperature,
            martensite: fraction,
            hottest_c: self.hottest,
            stress_pa: stress,
            heating_curve_c: curves.heating_c + state[HEATING],
            cooling_curve_c: curves.cooling_c + state[COOLING],
            length_m: m.length + x,
            full_power_w: self.full_power,
            velocity_m_s: velocity,
            loss_sigma_w: self.heat.covariance[LOSS][LOSS].max(0.0).sqrt()
                * self.surface.loss_w_per_k
                * (temperature - self.surface.temperature_c).abs(),
            release_j: state[LATENT] * m.release(stress),
            loss_w: state[LOSS] * self.surface.loss_w_per_k * (temperature - self.surface.temperature_c),
        }
    }

    /// The heat balance (eq. 48): the phase from the length, the temperature and its covariance one cycle on.
    #[inline]
    fn balance(&mut self, power: f64, stress: f64, dt: f64) {
        let fraction = self.fraction_at(self.motion.x, stress);
        // Until a length has come the phase is the model's guess, and costs nothing.
        let change = if self.seen { fraction - self.fraction } else { 0.0 };
        self.fraction = fraction;
        let m = &self.map;
        let release = m.release(stress) * m.per_heat_capacity;
        let surface = self.surface;
        let loss = surface.loss_w_per_k * (self.heat.state[T] - surface.temperature_c);
        let heat = power - self.heat.state[LOSS] * loss;
        let released = release * change;
        let rise = heat * dt * m.per_heat_capacity + self.heat.state[LATENT] * released;
        self.heat.state[T] += rise;
        let mut noise = DRIFT.of_states(m).map(|rate| rate * rate * dt);
        // within the loop the curves say how hot it is
        let beyond = 1.0 - inside(fraction).min(inside(1.0 - fraction));
        self.linear.follow(self.heat.state[LOSS], loss, heat * m.per_heat_capacity, dt);
        let linear = if beyond > 0.0 {
            self.linear
        } else {
            Linear { loss: self.heat.state[LOSS], loss_w: loss, ..self.linear }
        };
        let (latent, stored) = (LATENT_MODEL * release * change, beyond * CAPACITY_MODEL * linear.k_per_s * dt);
        noise[T] += (latent * latent + stored * stored) * (MODEL_TIME_S / dt.max(1e-6)).min(100.0);
        let per_kelvin = surface.loss_w_per_k * dt * m.per_heat_capacity;
        self.heat.predict(1.0 - linear.loss * per_kelvin, -linear.loss_w * dt * m.per_heat_capacity, released, &noise);
    }

    /// Keeps the heat filter's state to what a wire can have.
    #[inline]
    fn keep_in_range(&mut self) {
        let (m, state) = (&self.map, &mut self.heat.state);
        state[T] = state[T].clamp(COLDEST_C, HOTTEST_C);
        state[LOSS] = state[LOSS].clamp(0.2, 5.0);
        state[LATENT] = state[LATENT].clamp(0.3, 2.0);
        for resistivity in [RHO_A, RHO_M] {
            state[resistivity] = state[resistivity].clamp(-0.3, 0.3);
        }
        let gap = 0.5 * (m.heating_centre - m.cooling_centre).max(0.0);
        state[HEATING] = state[HEATING].clamp(-gap, 20.0);
        state[COOLING] = state[COOLING].clamp(-20.0, gap);
    }

    /// Whether length, velocity and covariances are such as a wire can have.
    #[inline]
    fn is_sane(&self, velocity: f64) -> bool {
        let (motion, heat) = (&self.motion, &self.heat);
        motion.x.abs() < self.map.length
            && velocity.abs() < MOST_M_PER_S
            && motion.xx + motion.bb < 1.0
            && heat.covariance[T][T] < 1e9
            && heat.state[T].is_finite()
    }

    /// The motion filter's cycle; returns the velocity.
    #[inline]
    fn follow(&mut self, elongation: f64, seen: &Observation, dt: f64) -> f64 {
        let measured = elongation.is_finite();
        let variance = match seen.length_sigma_m {
            sigma if sigma > 0.0 && sigma < 1.0 => sigma * sigma,
            _ => self.variance,
        };
        if measured && !self.seen {
            self.motion = Motion { x: elongation, model: 0.0, bias: 0.0, xx: variance, xb: 0.0, bb: 0.0 };
            self.seen = true;
            // What is learned of the phase is no change of it: no heat went into it.
            self.fraction = self.fraction_at(elongation, self.map.stress(elongation, 0.0));
            return 0.0;
        }
        let ModelVelocity { velocity_m_s, falls_per_s, doubt_m_s } = self.model_velocity(dt);
        let ends = (!measured).then(|| self.ends());
        let before = self.motion.x;
        let follows = dt / (dt + self.inertia_s).max(SHORTEST_STEP_S);
        let m = &mut self.motion;
        m.model += follows * (velocity_m_s - m.model);
        let velocity = m.model;
        let spread = BIAS_STANDING * self.cooling_speed + BIAS_MOVING * (velocity + m.bias).abs() + doubt_m_s;
        // twelve samples on the same side: then the bias may be anything up to the velocity that explains it
        let lost = ((self.astray.abs() - LOST_SIGMAS) / LOST_SIGMAS).clamp(0.0, 1.0);
        let spread = spread + lost * 0.5 * self.cooling_speed;
        let keep = BIAS_TIME_S / (BIAS_TIME_S + dt);
        let own = 1.0 - falls_per_s * dt;
        m.x += dt * (velocity + m.bias);
        m.bias *= keep;
        let (xx, xb, bb) = (m.xx, m.xb, m.bb);
        m.xx = own * own * xx + 2.0 * own * dt * xb + dt * dt * bb;
        m.xb = keep * (own * xb + dt * bb);
        m.bb = keep * keep * bb + spread * spread * (1.0 - keep * keep);
        if measured {
            let surprise = elongation - m.x;
            let spread = (m.xx + variance).max(1e-18);
            self.astray += (surprise / spread.sqrt() - self.astray) / LOST_SAMPLES;
            self.variance += (dt / 1.0).min(0.1) * ((surprise * surprise - m.xx).max(0.05 * spread) - self.variance);
            m.correct(surprise, 1.0, variance);
        }
        if let Some((hot, cold)) = ends {
            self.astray = 0.0;
            // No model leads a wire past its ends. A length that was measured beyond them stays where it was.
            let kept = m.x.clamp(hot.min(before), cold.max(before));
            if kept != m.x {
                (m.x, m.bias, m.model) = (kept, 0.0, 0.0);
                return 0.0;
            }
        }
        velocity + self.motion.bias
    }

    /// Elongations of the wire as wholly austenite and as wholly martensite, in m.
    #[inline]
    fn ends(&self) -> (f64, f64) {
        let (m, temperature) = (&self.map, self.heat.state[T]);
        let stress = m.stress(self.motion.x, 0.0);
        let (one, other) = (m.elongation(0.0, stress, temperature), m.elongation(self.strain, stress, temperature));
        (one.min(other), one.max(other))
    }

    #[inline]
    fn weigh_resistivity(&mut self, seen: &Observation, patience: f64) {
        let (m, state) = (&self.map, &self.heat.state);
        let resistance = seen.resistance_ohm;
        let measured = resistivity_ohm_m(resistance, m.length + self.motion.x, m.area);
        if !(measured > 0.0 && measured.is_finite()) {
            return;
        }
        let xi = self.fraction;
        let (rho, slope) = m.resistivity(xi, state[T], (state[RHO_A], state[RHO_M]));
        let (austenite, martensite) = m.resistivities(state[T]);
        let told = seen.resistance_sigma_ohm / resistance;
        let noise = if told.is_finite() { told.max(RESISTANCE_NOISE) } else { RESISTANCE_NOISE };
        let doubt = noise * noise + RESISTIVITY_MODEL * RESISTIVITY_MODEL * patience;
        let per = 1.0 / rho;
        let seen = Evidence {
            surprise: measured * per - 1.0,
            slopes: [(T, slope * per), (RHO_A, (1.0 - xi) * austenite * per), (RHO_M, xi * martensite * per)],
            variance: doubt,
        };
        // At its hot end nothing but resistance and power tell how hot a wire is. What they are read by is learned from them there with less
        // and less weight: a bias, however small, would carry temperature, loss and resistivity away together for as long as the wire is held,
        // and no measurement would object.
        let inside = inside(self.fraction);
        self.hot_s = if inside > 0.0 { 0.0 } else { self.hot_s + MODEL_TIME_S / patience };
        let known = inside.max(LEARNED_HOT_S / (LEARNED_HOT_S + self.hot_s));
        let mut learns = [known; STATES];
        (learns[T], learns[LOSS]) = (1.0, 1.0);
        self.heat.correct(&seen, &learns);
    }

    /// Whether a wire this far above its cooling curve (K) cannot be on its way along it.
    #[inline]
    fn is_cold(&self, above: f64, fraction: f64, s: f64) -> bool {
        let m = &self.map;
        let drag = m.branch(fraction, s).drag(m.cooling_width);
        fraction > 0.6 && above < -COLD * m.cooling_width - self.cooling_speed * drag
    }

    /// At the cold end the phase is known, and what is left of the length is strain. Whether the wire is there.
    #[inline]
    fn learn_strain(&mut self, cooling: f64, stress: f64, dt: f64) -> bool {
        let m = &self.map;
        let (temperature, width) = (self.heat.state[T], m.cooling_width);
        let cooling = cooling + self.heat.state[COOLING];
        let found = m.fraction(self.motion.x, stress, temperature) / self.strain;
        let s = stress + m.thermoelastic * (temperature - m.reference);
        let cold = self.is_cold(temperature - cooling, found, s);
        let noise = 3.0 * self.motion.xx.max(0.0).sqrt() / (m.length * m.strain);
        if !(cold || found > 1.02 + noise) {
            return false;
        }
        let expected = if cold {
            let centre = m.cooling_centre + stress * m.shift + self.heat.state[COOLING];
            logistic(temperature, centre, width)
        } else {
            1.0
        };
        let off = found / expected.max(0.5) - 1.0;
        let off = off - off.clamp(-0.02 - noise, 0.02 + noise);
        let strain = (self.strain * (1.0 + (STRAIN_RATE * dt).min(1.0) * off)).clamp(0.5, 1.6);
        // what is learned of the strain is no change of phase
        self.fraction = (self.fraction * self.strain / strain).clamp(0.0, 1.0);
        self.strain = strain;
        cold
    }

    #[inline]
    fn weigh_curves(&mut self, curves: &Curves, velocity: f64, patience: f64) {
        let m = &self.map;
        let state = &self.heat.state;
        let (heating, cooling) = (curves.heating_c + state[HEATING], curves.cooling_c + state[COOLING]);
        let temperature = state[T];
        // a phase indistinguishable from the end of its range gives no bound on that side
        let (low, high) = (inside(self.fraction), inside(1.0 - self.fraction));
        let standing = STANDING * self.cooling_speed;
        let moving = ((velocity.abs() - standing) / (3.0 * standing)).clamp(0.0, 1.0);
        let (curve, offset, width, sure) = if temperature > heating {
            (heating, HEATING, m.heating_width, low)
        } else if temperature < cooling {
            (cooling, COOLING, m.cooling_width, high)
        } else if velocity < 0.0 {
            (heating, HEATING, m.heating_width, moving * low.min(high))
        } else {
            (cooling, COOLING, m.cooling_width, moving * low.min(high))
        };
        if sure < 1e-3 {
            return;
        }
        let xi = self.fraction.clamp(0.03, 0.97);
        let phase = (self.motion.xx.max(0.0).sqrt() / (m.length * m.strain)) / (xi * (1.0 - xi));
        let doubt = width * (CURVE_MODEL + phase) / sure;
        let seen = Evidence {
            surprise: curve - temperature,
            slopes: [(T, 1.0), (offset, -1.0)],
            variance: doubt * doubt * patience,
        };
        self.heat.correct(&seen, &[1.0; STATES]);
    }
}
