//! Noisy lengths in, length, velocity and acceleration out.
//!
//! A Kalman filter. Without a [`Drive`] it runs on the bare chain length → velocity → acceleration, moved by an unknown,
//! white jerk: third order, for any wire and load. With one it knows eq. 68, the load that follows the heating,
//! M x⃛ + B ẍ + K ẋ = K_w L ε_L ξ̇, and the unknown is the rate of transformation: a velocity modelled as a random walk, less
//! the known effect of the duty. Two advantages: the random walk is a velocity instead of a jerk, so less noise reaches the
//! acceleration, and the load's own dynamics are predicted instead of followed. `examples/closed_loop.rs` has the figures.
//!
//! The filter settles to constant gains; once it has, an update is a handful of multiplications. The covariance is only
//! propagated while it changes: after the start, after missing samples, and while steps or noise differ from nominal.

mod config;
mod motion;
mod plant;

pub use config::{Drive, ObserverConfig};
pub use motion::Motion;

use crate::error::{Error, check};
use plant::{Gain, Matrix, Plant, STATES, State, Step, correct};

/// Steps and deviations within this of nominal use the nominal gains: the optimum is that flat.
const NOMINAL: f64 = 0.2;

/// Bound of the iterations at construction. Only a load slower than minutes gets there, and its gains are good by then.
const MOST_STEPS: u32 = 2_000_000;

/// Estimates the motion of one wire.
#[derive(Debug, Clone)]
pub struct MotionObserver {
    plant: Plant,
    state: State,
    steady_gain: Gain,
    nominal_dt: f64,
    nominal_sigma: f64,
    duty: f64,
    age_s: f64,
    missed: u32,
    /// Updates until the gains count as settled again; 0 = settled.
    unsettled: u32,
    settle: u32,
    started: bool,
    covariance: Matrix,
    steady_covariance: Matrix,
    /// The model over a step of nominal length, and over the step last needed that was not.
    nominal_step: Step,
    other_step: Step,
    config: ObserverConfig,
}

impl MotionObserver {
    /// An observer for samples arriving at `rate_hz`; the gains are worked out here.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a rate outside 1 Hz – 1 MHz, else as [`ObserverConfig::validate`].
    pub fn new(rate_hz: f64, config: ObserverConfig) -> Result<MotionObserver, Error> {
        check("rate in Hz", rate_hz, 1.0, 1e6)?;
        config.validate()?;
        // Slower than that, and the gains drown in the rounding of the covariance.
        check("observer bandwidth in Hz", config.bandwidth_hz, 1e-5 * rate_hz, 10e3)?;
        let dt = 1.0 / rate_hz;
        let plant = Plant::new(&config, dt);
        let nominal_step = plant.discretise(dt);
        let mut observer = MotionObserver {
            plant,
            state: State::default(),
            steady_gain: Gain::default(),
            nominal_dt: dt,
            nominal_sigma: config.length_sigma_m,
            duty: 0.0,
            age_s: f64::INFINITY,
            missed: 0,
            unsettled: 0,
            settle: 0,
            started: false,
            covariance: [[0.0; STATES]; STATES],
            steady_covariance: [[0.0; STATES]; STATES],
            nominal_step,
            other_step: nominal_step,
            config,
        };
        // Iterate the Riccati equation until the gains stand still, and for as long as they take to change: they may also
        // pause where they turn.
        let r = config.length_sigma_m * config.length_sigma_m;
        let first = observer.first_covariance(r);
        let mut p = first;
        let mut gain = correct(&mut p, r);
        let mut still = 0.0;
        for _ in 1..MOST_STEPS {
            nominal_step.predict(&mut p);
            let next = correct(&mut p, r);
            let moved = !gain.is_near(&next, 1e-9);
            gain = next;
            still = if moved { 0.0 } else { still + gain.of_length() };
            if still > 2.0 {
                break;
            }
        }
        observer.steady_gain = gain;
        observer.steady_covariance = p;
        // And once more to see when, after a start, they may be taken for settled.
        let mut p = first;
        let mut step = 1;
        let mut quiet = 0.0;
        while quiet < 1.0 && step < MOST_STEPS {
            nominal_step.predict(&mut p);
            let settled = correct(&mut p, r).is_near(&gain, 1e-3);
            quiet = if settled { quiet + gain.of_length() } else { 0.0 };
            step += 1;
        }
        observer.settle = step;
        Ok(observer)
    }

    /// The configuration it was made from.
    pub fn config(&self) -> &ObserverConfig {
        &self.config
    }

    /// Takes the length of this cycle, or `None` (or NaN) where there is none, `dt_s` after the last call.
    ///
    /// Before the first length the motion is all zero. A `dt_s` that is not positive and finite counts as nominal.
    #[inline]
    pub fn update(&mut self, length: Option<f64>, dt_s: f64) -> Motion {
        self.update_weighted(length, self.nominal_sigma, dt_s)
    }

    /// As [`MotionObserver::update`], with the standard deviation of this very length, in m.
    #[inline]
    pub fn update_weighted(&mut self, length: Option<f64>, sigma_m: f64, dt_s: f64) -> Motion {
        let length = match length {
            Some(value) if value.is_finite() && sigma_m > 0.0 && sigma_m < f64::INFINITY => value,
            _ => return self.coast(dt_s),
        };
        if !self.started {
            return self.begin(length, sigma_m);
        }
        let dt = if dt_s > 0.0 && dt_s < f64::INFINITY { dt_s } else { self.nominal_dt };
        self.age_s += dt;
        if self.age_s > self.config.max_age_s.max(2.0 * self.nominal_dt) {
            return self.begin(length, sigma_m);
        }
        self.plant.advance(&mut self.state, self.plant.full_duty * self.duty, dt);
        let nominal_dt = (dt - self.nominal_dt).abs() <= NOMINAL * self.nominal_dt;
        let nominal = nominal_dt && (sigma_m - self.nominal_sigma).abs() <= NOMINAL * self.nominal_sigma;
        let gain =
            if nominal && self.unsettled == 0 { self.steady_gain } else { self.transient_gain(dt, nominal, sigma_m) };
        self.state.correct(&gain, length - self.state.length_m);
        (self.age_s, self.missed) = (0.0, 0);
        self.motion()
    }

    /// Tells the duty (0..1) from now until the next update; without a [`Drive`] it makes no difference.
    #[inline]
    pub fn set_duty(&mut self, duty: f64) {
        self.duty = if duty.is_finite() { duty } else { 0.0 };
    }

    /// The present estimate.
    pub fn motion(&self) -> Motion {
        self.state.motion()
    }

    /// The estimate `ahead_s` from now under the present duty, to make up for a known delay; changes nothing.
    pub fn ahead(&self, ahead_s: f64) -> Motion {
        let mut state = self.state;
        if self.started && ahead_s.is_finite() && ahead_s > 0.0 {
            self.plant.advance(&mut state, self.plant.full_duty * self.duty, ahead_s.min(self.config.max_age_s));
        }
        state.motion()
    }

    /// Time since the last length that was taken in, in s; infinite before the first.
    pub fn age_s(&self) -> f64 {
        self.age_s
    }

    /// Updates since then that brought no length.
    pub fn missed(&self) -> u32 {
        self.missed
    }

    /// Whether the gains have settled, so that the standard deviations are those of the steady state.
    pub fn settled(&self) -> bool {
        self.started && self.unsettled == 0
    }

    /// Standard deviations of the present estimate, as the observer itself sees them; zero before the first length.
    pub fn deviation(&self) -> Motion {
        let p = if self.settled() { &self.steady_covariance } else { &self.covariance };
        let sigma = |i: usize| p[i][i].max(0.0).sqrt();
        Motion { length_m: sigma(0), velocity_m_s: sigma(1), acceleration_m_s2: sigma(2) }
    }

    /// Forgets everything but its configuration.
    pub fn reset(&mut self) {
        self.state = State::default();
        self.covariance = [[0.0; STATES]; STATES];
        (self.duty, self.age_s, self.missed, self.unsettled, self.started) = (0.0, f64::INFINITY, 0, 0, false);
    }

    fn first_covariance(&self, r: f64) -> Matrix {
        let mut p = [[0.0; STATES]; STATES];
        p[0][0] = r;
        p[1][1] = self.config.start_velocity_m_s.powi(2);
        p[2][2] = self.config.start_acceleration_m_s2.powi(2);
        if self.plant.driven {
            p[3][3] = p[1][1];
        }
        p
    }

    #[cold]
    fn begin(&mut self, length: f64, sigma_m: f64) -> Motion {
        self.state = State::standing(length);
        self.covariance = self.first_covariance(sigma_m * sigma_m);
        self.unsettled = self.settle;
        (self.age_s, self.missed, self.started) = (0.0, 0, true);
        self.motion()
    }

    /// Leaves the settled state, or stays out of it, and steps the covariance.
    fn predict_covariance(&mut self, dt: f64) {
        if self.unsettled == 0 {
            self.covariance = self.steady_covariance;
        }
        if (dt - self.nominal_dt).abs() <= NOMINAL * self.nominal_dt {
            self.nominal_step.predict(&mut self.covariance);
        } else {
            if (dt - self.other_step.dt).abs() > NOMINAL * self.other_step.dt {
                self.other_step = self.plant.discretise(dt);
            }
            self.other_step.predict(&mut self.covariance);
        }
    }

    #[inline]
    fn transient_gain(&mut self, dt: f64, nominal: bool, sigma_m: f64) -> Gain {
        self.predict_covariance(dt);
        self.unsettled = if nominal { self.unsettled.saturating_sub(1) } else { self.settle.max(1) };
        correct(&mut self.covariance, sigma_m * sigma_m)
    }

    /// A cycle without a length: prediction only, for as long as that means anything.
    #[inline]
    fn coast(&mut self, dt_s: f64) -> Motion {
        self.missed = self.missed.saturating_add(1);
        if !self.started {
            return self.motion();
        }
        let dt = if dt_s > 0.0 && dt_s < f64::INFINITY { dt_s } else { self.nominal_dt };
        self.age_s += dt;
        if self.age_s > self.config.max_age_s {
            self.state = State::standing(self.state.length_m);
        } else {
            self.plant.advance(&mut self.state, self.plant.full_duty * self.duty, dt);
            self.predict_covariance(dt);
            self.unsettled = self.settle.max(1);
        }
        self.motion()
    }
}

#[cfg(test)]
mod tests;
