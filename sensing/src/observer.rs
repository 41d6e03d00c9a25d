//! Noisy lengths in, length, velocity and acceleration out.
//!
//! A Kalman filter. Without a [`Drive`] it runs on the bare chain length → velocity → acceleration, moved by an unknown,
//! white jerk: third order, for any wire and load. With one it knows eq. 68, the load that follows the heating,
//! M x⃛ + B ẍ + K ẋ = K_w L ε_L ξ̇, and what is unknown is how fast the wire transforms: a velocity that wanders, less
//! what the duty is known to do. That pays twice: what wanders is a velocity instead of a jerk, so less noise reaches the
//! acceleration, and the load's own dynamics are foreseen instead of followed. `examples/closed_loop.rs` has the figures.
//!
//! The filter settles to constant gains; once it has, an update is a handful of multiplications. The covariance is only
//! carried while it changes: after the start, after missing samples, and while steps or noise differ from nominal.

use crate::Error;
use crate::error::check;

/// Length and its first two derivatives; positive = longer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Wire length, in m.
    pub length_m: f64,
    /// Its first derivative, in m/s.
    pub velocity_m_s: f64,
    /// Its second derivative, in m/s².
    pub acceleration_m_s2: f64,
}

impl Motion {
    /// The critically damped sliding surface ẍ + 2λẋ + λ²(x − x_ref) of chapter 11, in m/s².
    pub fn surface(&self, lambda_per_s: f64, reference_m: f64) -> f64 {
        self.acceleration_m_s2 + lambda_per_s * (2.0 * self.velocity_m_s + lambda_per_s * (self.length_m - reference_m))
    }
}

/// What is known of the load and of the heating (eq. 68–69): x⃛ = ω²(u w₁ + d − ẋ) − 2ζω ẍ, with the duty u and the
/// unknown rest d of the heating velocity.
///
/// Take the wire at its stiffest (austenite): too stiff by a third does no harm, too soft does where the load is slow.
/// Leave `full_duty_m_s` at zero where the load is fast beside the sliding surface (ω above about 10 λ): foreseeing
/// every single pulse then only brings back the chatter. Where the load is slow, a quarter of the outer curves' speed helps; more than
/// that overstates a wire inside its hysteresis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// ω = √((K + K_wire)/M), in rad/s.
    pub natural_rad_s: f64,
    /// ζ = B/(2 √((K + K_wire) M)).
    pub damping_ratio: f64,
    /// Velocity w₁ that duty 1 heats the wire to (negative: heat shortens), in m/s; zero = the duty is not used.
    pub full_duty_m_s: f64,
}

impl Drive {
    /// From the load of eq. 51: mass in kg, damping in N s/m, the load's spring and the wire's own stiffness E A/L
    /// together in N/m; and the velocity at full duty in m/s.
    pub fn of_load(mass_kg: f64, damping_n_s_per_m: f64, stiffness_n_per_m: f64, full_duty_m_s: f64) -> Drive {
        Drive {
            natural_rad_s: (stiffness_n_per_m / mass_kg).sqrt(),
            damping_ratio: 0.5 * damping_n_s_per_m / (stiffness_n_per_m * mass_kg).sqrt(),
            full_duty_m_s,
        }
    }
}

/// How to build a [`MotionObserver`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObserverConfig {
    /// Nominal standard deviation of a length, in m; [`crate::LengthSensor::expected_sigma_m`].
    pub length_sigma_m: f64,
    /// Bandwidth, in Hz: the one trade between noise and lag. Without a drive it is the corner ω of the third-order
    /// Butterworth filter the observer settles to (jerk density q = ω⁶ σ² dt); the acceleration lags by 2/ω. With a
    /// drive it is the corner at which the rest of the heating velocity is followed (density ω⁴ σ² dt). It means the same at
    /// every rate; noise falls as 1/√rate.
    pub bandwidth_hz: f64,
    /// What is known of load and heating, if anything.
    pub drive: Option<Drive>,
    /// Spread of the velocity before the first sample, in m/s.
    pub start_velocity_m_s: f64,
    /// Spread of the acceleration before the first sample, in m/s².
    pub start_acceleration_m_s2: f64,
    /// Longest time to predict without a sample, in s; then the wire is taken to stand where it was last predicted, and the
    /// next sample starts anew.
    pub max_age_s: f64,
}

impl Default for ObserverConfig {
    fn default() -> Self {
        ObserverConfig {
            length_sigma_m: 60e-6,
            bandwidth_hz: 7.0,
            drive: None,
            start_velocity_m_s: 0.02,
            start_acceleration_m_s2: 0.5,
            max_age_s: 0.05,
        }
    }
}

impl ObserverConfig {
    /// The default for lengths of this standard deviation, in m, where load and heating are known.
    pub fn with_drive(length_sigma_m: f64, drive: Drive) -> ObserverConfig {
        ObserverConfig { length_sigma_m, bandwidth_hz: 10.0, drive: Some(drive), ..ObserverConfig::default() }
    }

    /// The bandwidth in Hz that tracks best, in the mean square and without a drive, a jerk of this rms size in m/s³ that holds
    /// for `hold_s` between changes. An honest bound for a wire is ω² times its heating velocity, held for as long
    /// as the controller leaves the power on. It is an upper bound for what serves a controller, which suffers from the
    /// noise of the acceleration more than from its lag.
    pub fn bandwidth_for_jerk(jerk_m_s3: f64, hold_s: f64, length_sigma_m: f64, rate_hz: f64) -> f64 {
        let density = 2.0 * jerk_m_s3 * jerk_m_s3 * hold_s;
        (density * rate_hz / (length_sigma_m * length_sigma_m)).powf(1.0 / 6.0) / std::f64::consts::TAU
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// The first number that cannot be used, by name.
    pub fn validate(&self) -> Result<(), Error> {
        check("standard deviation of the length in m", self.length_sigma_m, 1e-12, 1.0)?;
        check("observer bandwidth in Hz", self.bandwidth_hz, 0.01, 10e3)?;
        if let Some(drive) = self.drive {
            check("natural frequency in rad/s", drive.natural_rad_s, 1e-3, 1e6)?;
            check("damping ratio", drive.damping_ratio, 0.0, 1e6)?;
            check("velocity at full duty in m/s", drive.full_duty_m_s, -100.0, 100.0)?;
        }
        check("spread of the first velocity in m/s", self.start_velocity_m_s, 1e-9, 100.0)?;
        check("spread of the first acceleration in m/s²", self.start_acceleration_m_s2, 1e-9, 1e6)?;
        check("longest prediction in s", self.max_age_s, 1e-6, 1.0)
    }
}

/// Length, velocity, acceleration, and the unknown rest of the heating velocity.
const STATES: usize = 4;
type Vector = [f64; STATES];
type Matrix = [[f64; STATES]; STATES];

/// Steps and deviations within this of nominal use the nominal gains: the optimum is that flat.
const NOMINAL: f64 = 0.2;

/// Bound of the iterations at construction. Only a load slower than minutes gets there, and its gains are good by then.
const MOST_STEPS: u32 = 2_000_000;

/// The equation of motion: x⃛ = stiffness (w − ẋ) − damping ẍ.
#[derive(Debug, Clone, Copy)]
struct Plant {
    stiffness: f64,
    damping: f64,
    /// Reciprocal of the longest step of the series in [`Plant::advance`].
    per_step: f64,
    /// Whether eq. 68 is in it at all.
    driven: bool,
    full_duty: f64,
    jerk_psd: f64,
    rest_psd: f64,
}

impl Plant {
    fn new(config: &ObserverConfig, dt_s: f64) -> Plant {
        let corner = std::f64::consts::TAU * config.bandwidth_hz;
        let floor = config.length_sigma_m * config.length_sigma_m * dt_s;
        let mut plant = Plant {
            stiffness: 0.0,
            damping: 0.0,
            per_step: 0.0,
            driven: false,
            full_duty: 0.0,
            jerk_psd: corner.powi(6) * floor,
            rest_psd: 0.0,
        };
        if let Some(drive) = config.drive {
            // Modes much faster than the sampling are over within a step. Slowed to a few of them per step they still are, and
            // the series of `advance` stays short, over the longest prediction too. Slowing keeps the slow pole of an
            // overdamped load, ω/2ζ, where it is.
            let longest = config.max_age_s.max(2.0 * dt_s);
            let fastest = (4.0 / dt_s).min(250.0 / longest);
            let (natural, damping) = (drive.natural_rad_s, 2.0 * drive.damping_ratio * drive.natural_rad_s);
            let slowed = (2.0 * fastest / damping).min(1.0);
            let (natural, damping) = (natural * slowed.sqrt(), damping * slowed);
            let slowed = (fastest / natural).min(1.0);
            let (natural, damping) = (natural * slowed, damping * slowed);
            plant.stiffness = natural * natural;
            plant.damping = damping;
            plant.per_step = 2.0 * natural.max(damping);
            plant.driven = true;
            plant.full_duty = drive.full_duty_m_s;
            plant.jerk_psd = 0.0;
            plant.rest_psd = corner.powi(4) * floor;
        }
        plant
    }

    /// The state `dt` later, under a heating velocity of `w` on top of the state's own.
    #[inline]
    fn advance(&self, state: &mut Vector, w: f64, dt: f64) {
        let [x, v, a, rest] = state;
        if !self.driven {
            *x += dt * (*v + 0.5 * dt * *a);
            *v += dt * *a;
            return;
        }
        let parts = (dt * self.per_step).ceil().clamp(1.0, 1024.0);
        let h = dt / parts;
        for _ in 0..parts as u32 {
            // Taylor series: each derivative of a follows from the two before it.
            let j = self.stiffness * (*rest + w - *v) - self.damping * *a;
            let j1 = -self.stiffness * *a - self.damping * j;
            let j2 = -self.stiffness * j - self.damping * j1;
            let j3 = -self.stiffness * j1 - self.damping * j2;
            let rise = h * (j + h * (1.0 / 2.0) * (j1 + h * (1.0 / 3.0) * (j2 + h * (1.0 / 4.0) * j3)));
            let gain = h * h * (0.5 * j + h * (1.0 / 6.0) * (j1 + h * (1.0 / 4.0) * (j2 + h * (1.0 / 5.0) * j3)));
            let way = h * h * h * (1.0 / 6.0) * (j + h * (1.0 / 4.0) * (j1 + h * (1.0 / 5.0) * j2));
            *x += h * (*v + 0.5 * h * *a) + way;
            *v += h * *a + gain;
            *a += rise;
        }
    }

    /// Transition matrix and process noise over `dt`.
    fn discretise(&self, dt: f64) -> Step {
        // The noise of the bare chain is exact for short steps and doubled up from there; without a drive at any length.
        let doublings = if self.driven { (dt * self.per_step * 4.0).log2().ceil().clamp(0.0, 12.0) as i32 } else { 0 };
        let h = dt / 2f64.powi(doublings);
        let mut f = [[0.0; STATES]; STATES];
        for column in 0..STATES {
            let mut unit = [0.0; STATES];
            unit[column] = 1.0;
            self.advance(&mut unit, 0.0, h);
            for (row, value) in f.iter_mut().zip(unit) {
                row[column] = value;
            }
        }
        let mut q = [[0.0; STATES]; STATES];
        let jerk = [h * h / 2.0, h, 1.0, 0.0];
        let jerk_power = [2, 1, 0, 0];
        let k = self.stiffness;
        let rest = [k * h * h * h / 6.0, k * h * h / 2.0, k * h, 1.0];
        let rest_power = [3, 2, 1, 0];
        for r in 0..STATES {
            for c in 0..STATES {
                // ∫ of tᵐ tⁿ from 0 to h, each normalised to its value at h.
                let jerks = jerk[r] * jerk[c] / f64::from(jerk_power[r] + jerk_power[c] + 1);
                let rests = rest[r] * rest[c] / f64::from(rest_power[r] + rest_power[c] + 1);
                q[r][c] = h * (self.jerk_psd * jerks + self.rest_psd * rests);
            }
        }
        for _ in 0..doublings {
            let moved = congruence(&f, &q);
            for r in 0..STATES {
                for c in 0..STATES {
                    q[r][c] += moved[r][c];
                }
            }
            f = product(&f, &f);
        }
        Step { dt, f, q }
    }
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut out = [[0.0; STATES]; STATES];
    for r in 0..STATES {
        for c in 0..STATES {
            out[r][c] = (0..STATES).map(|k| a[r][k] * b[k][c]).sum();
        }
    }
    out
}

/// F P Fᵀ.
fn congruence(f: &Matrix, p: &Matrix) -> Matrix {
    let fp = product(f, p);
    let mut out = [[0.0; STATES]; STATES];
    for r in 0..STATES {
        for c in r..STATES {
            out[r][c] = (0..STATES).map(|k| fp[r][k] * f[c][k]).sum();
            out[c][r] = out[r][c];
        }
    }
    out
}

/// The model over one step.
#[derive(Debug, Clone, Copy)]
struct Step {
    dt: f64,
    f: Matrix,
    q: Matrix,
}

impl Step {
    fn predict(&self, p: &mut Matrix) {
        let mut next = congruence(&self.f, p);
        for (next, noise) in next.iter_mut().flatten().zip(self.q.iter().flatten()) {
            *next += noise;
        }
        *p = next;
    }
}

/// Takes a measurement of the length with variance `r` into the covariance; returns the gain.
fn correct(p: &mut Matrix, r: f64) -> Vector {
    let scale = 1.0 / (p[0][0] + r);
    let row = p[0];
    let gain = row.map(|entry| entry * scale);
    for i in 0..STATES {
        for j in 0..STATES {
            p[i][j] -= gain[i] * row[j];
        }
    }
    gain
}

/// Estimates the motion of one wire.
#[derive(Debug, Clone)]
pub struct MotionObserver {
    plant: Plant,
    state: Vector,
    steady_gain: Vector,
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
            state: [0.0; STATES],
            steady_gain: [0.0; STATES],
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
            let moved = gain.iter().zip(next).any(|(a, b)| (a - b).abs() > 1e-9 * b.abs());
            gain = next;
            still = if moved { 0.0 } else { still + gain[0] };
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
            let settled = correct(&mut p, r).iter().zip(gain).all(|(a, b)| (a - b).abs() <= 1e-3 * b.abs());
            quiet = if settled { quiet + gain[0] } else { 0.0 };
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
        let surprise = length - self.state[0];
        for (value, gain) in self.state.iter_mut().zip(gain) {
            *value += gain * surprise;
        }
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
        let [length_m, velocity_m_s, acceleration_m_s2, _] = self.state;
        Motion { length_m, velocity_m_s, acceleration_m_s2 }
    }

    /// The estimate `ahead_s` from now under the present duty, to make up for a known delay; changes nothing.
    pub fn ahead(&self, ahead_s: f64) -> Motion {
        let mut state = self.state;
        if self.started && ahead_s.is_finite() && ahead_s > 0.0 {
            self.plant.advance(&mut state, self.plant.full_duty * self.duty, ahead_s.min(self.config.max_age_s));
        }
        let [length_m, velocity_m_s, acceleration_m_s2, _] = state;
        Motion { length_m, velocity_m_s, acceleration_m_s2 }
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
        self.state = [0.0; STATES];
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
        self.state = [length, 0.0, 0.0, 0.0];
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

    fn transient_gain(&mut self, dt: f64, nominal: bool, sigma_m: f64) -> Vector {
        self.predict_covariance(dt);
        self.unsettled = if nominal { self.unsettled.saturating_sub(1) } else { self.settle.max(1) };
        correct(&mut self.covariance, sigma_m * sigma_m)
    }

    /// A cycle without a length: prediction only, for as long as that means anything.
    fn coast(&mut self, dt_s: f64) -> Motion {
        self.missed = self.missed.saturating_add(1);
        if !self.started {
            return self.motion();
        }
        let dt = if dt_s > 0.0 && dt_s < f64::INFINITY { dt_s } else { self.nominal_dt };
        self.age_s += dt;
        if self.age_s > self.config.max_age_s {
            self.state = [self.state[0], 0.0, 0.0, 0.0];
        } else {
            self.plant.advance(&mut self.state, self.plant.full_duty * self.duty, dt);
            self.predict_covariance(dt);
            self.unsettled = self.settle.max(1);
        }
        self.motion()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng, rngs::SmallRng};
    use rand_distr::StandardNormal;

    const DRIVE: Drive = Drive { natural_rad_s: 170.0, damping_ratio: 0.6, full_duty_m_s: -0.01 };

    fn bare(rate_hz: f64, bandwidth_hz: f64) -> MotionObserver {
        MotionObserver::new(rate_hz, ObserverConfig { bandwidth_hz, ..ObserverConfig::default() }).unwrap()
    }

    fn driven(rate_hz: f64) -> MotionObserver {
        MotionObserver::new(rate_hz, ObserverConfig::with_drive(60e-6, DRIVE)).unwrap()
    }

    /// Rms error at rest of length, velocity and acceleration, after the gains have settled.
    fn noise(mut observer: MotionObserver, rate_hz: f64, seconds: f64) -> Motion {
        let mut rng = SmallRng::seed_from_u64(3);
        let mut sums = [0.0; 3];
        let (settle, cycles) = (2.0 * rate_hz, seconds * rate_hz);
        for cycle in 0..(settle + cycles) as u32 {
            let length = 0.163 + 60e-6 * rng.sample::<f64, _>(StandardNormal);
            let m = observer.update(Some(length), 1.0 / rate_hz);
            if f64::from(cycle) >= settle {
                for (sum, e) in sums.iter_mut().zip([m.length_m - 0.163, m.velocity_m_s, m.acceleration_m_s2]) {
                    *sum += e * e;
                }
            }
        }
        let [length_m, velocity_m_s, acceleration_m_s2] = sums.map(|sum: f64| (sum / cycles).sqrt());
        Motion { length_m, velocity_m_s, acceleration_m_s2 }
    }

    #[test]
    fn gains_are_those_of_butterworth_when_sampled_fast() {
        let observer = bare(1e6, 20.0);
        let (omega, dt) = (std::f64::consts::TAU * 20.0, 1e-6);
        let expected = [2.0 * omega * dt, 2.0 * omega.powi(2) * dt, omega.powi(3) * dt];
        for (gain, expected) in observer.steady_gain.iter().zip(expected) {
            assert!((gain / expected - 1.0).abs() < 2e-3, "{gain} for {expected}");
        }
    }

    #[test]
    fn settled_gains_are_where_the_covariance_goes() {
        for mut observer in [bare(1000.0, 7.0), driven(1000.0), driven(100.0), bare(10e3, 30.0)] {
            observer.update(Some(0.163), observer.nominal_dt);
            let mut p = observer.covariance;
            let r = observer.nominal_sigma.powi(2);
            let mut gain = [0.0; STATES];
            for _ in 0..observer.settle + 20_000 {
                observer.nominal_step.predict(&mut p);
                gain = correct(&mut p, r);
            }
            for (limit, steady) in gain.iter().zip(observer.steady_gain) {
                assert!((limit - steady).abs() <= 1e-4 * steady.abs(), "{gain:?} {:?}", observer.steady_gain);
            }
        }
    }

    #[test]
    fn noise_is_a_hundredth_of_what_differences_at_200_hz_have() {
        // Differences: √2 σ/T and √6 σ/T².
        let (velocity, acceleration) = (2f64.sqrt() * 60e-6 * 200.0, 6f64.sqrt() * 60e-6 * 200.0 * 200.0);
        for observer in [bare(1000.0, 7.0), driven(1000.0)] {
            let m = noise(observer, 1000.0, 20.0);
            assert!(m.length_m < 20e-6, "{m:?}");
            assert!(m.velocity_m_s < velocity / 20.0, "{m:?}");
            assert!(m.acceleration_m_s2 < acceleration / 300.0, "{m:?}");
        }
    }

    #[test]
    fn noise_falls_with_the_square_root_of_the_rate() {
        let (slow, fast) = (noise(bare(1e3, 10.0), 1e3, 40.0), noise(bare(10e3, 10.0), 10e3, 40.0));
        let ratio = slow.acceleration_m_s2 / fast.acceleration_m_s2;
        assert!((ratio / 10f64.sqrt() - 1.0).abs() < 0.15, "{ratio}");
    }

    #[test]
    fn its_own_deviation_bounds_the_noise_at_rest() {
        for observer in [bare(1000.0, 7.0), driven(1000.0)] {
            let own = {
                let mut settled = observer.clone();
                for _ in 0..5000 {
                    settled.update(Some(0.163), 1e-3);
                }
                assert!(settled.settled());
                settled.deviation()
            };
            let m = noise(observer, 1000.0, 20.0);
            assert!(m.length_m < own.length_m && m.length_m > 0.3 * own.length_m, "{m:?} {own:?}");
            assert!(m.velocity_m_s < own.velocity_m_s && m.acceleration_m_s2 < own.acceleration_m_s2, "{m:?} {own:?}");
        }
    }

    #[test]
    fn knows_the_load_it_was_told() {
        // Eq. 68 itself, integrated finely: the observer with the right drive and duty is far nearer than the bare chain.
        let truth_drive = Drive { natural_rad_s: 40.0, damping_ratio: 0.3, full_duty_m_s: -0.04 };
        let config = ObserverConfig::with_drive(60e-6, truth_drive);
        let mut observers = [MotionObserver::new(1000.0, config).unwrap(), bare(1000.0, 7.0)];
        let mut rng = SmallRng::seed_from_u64(5);
        let (mut x, mut v, mut a) = (0.165f64, 0.0f64, 0.0f64);
        let mut worst = [0.0f64; 2];
        for cycle in 0..3000u32 {
            // Some heating, in pulses, about the duty that would hold the wire; the rest is constant.
            let duty = if (cycle / 40) % 5 == 0 { 1.0 } else { 0.0 };
            for _ in 0..100 {
                let j = 1600.0 * (0.008 - 0.04 * duty - v) - 24.0 * a;
                (x, v, a) = (x + 1e-5 * v, v + 1e-5 * a, a + 1e-5 * j);
            }
            let length = x + 60e-6 * rng.sample::<f64, _>(StandardNormal);
            for (observer, worst) in observers.iter_mut().zip(&mut worst) {
                observer.set_duty(duty);
                let m = observer.update(Some(length), 1e-3);
                if cycle > 1000 {
                    *worst = worst.max((m.acceleration_m_s2 - a).abs());
                }
            }
        }
        assert!(worst[0] < 0.05 && worst[0] < 0.1 * worst[1], "{worst:?}");
    }

    #[test]
    fn an_overdamped_load_keeps_its_slow_pole() {
        let light = Drive::of_load(1e-4, 40.0, 4e3, 0.0);
        let observer = MotionObserver::new(1000.0, ObserverConfig::with_drive(60e-6, light)).unwrap();
        assert!((observer.plant.stiffness / observer.plant.damping / 100.0 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn predicts_while_lengths_are_missing_and_says_how_old_it_is() {
        let mut observer = bare(1000.0, 20.0);
        assert_eq!(observer.age_s(), f64::INFINITY);
        assert_eq!(observer.update(None, 1e-3), Motion::default());
        let at = |t: f64| 0.16 + 0.02 * t;
        for k in 0..2000 {
            observer.update(Some(at(1e-3 * f64::from(k))), 1e-3);
        }
        let before = observer.deviation();
        for k in 2000..2020 {
            let length = [None, Some(f64::NAN), Some(f64::INFINITY)][k as usize % 3];
            let m = observer.update(length, 1e-3);
            assert!((m.length_m - at(1e-3 * f64::from(k))).abs() < 1e-6, "{m:?}");
            assert_eq!(observer.missed(), k as u32 - 1999);
        }
        assert!((observer.age_s() - 0.020).abs() < 1e-9);
        assert!(observer.deviation().length_m > 2.0 * before.length_m, "covariance grows");
        // Having lost some, it trusts the next length more than a settled observer would.
        let estimate = observer.motion().length_m;
        let m = observer.update(Some(at(2.020) + 1e-3), 1e-3);
        assert!(m.length_m - estimate > 1e-3 * observer.steady_gain[0] * 2.0);
        assert_eq!((observer.missed(), observer.age_s()), (0, 0.0));
        // Too long: it stands still, and starts anew with the next length.
        for _ in 0..60 {
            observer.update(None, 1e-3);
        }
        assert_eq!(observer.motion().velocity_m_s, 0.0);
        let m = observer.update(Some(0.2), 1e-3);
        assert_eq!(m, Motion { length_m: 0.2, velocity_m_s: 0.0, acceleration_m_s2: 0.0 });
    }

    #[test]
    fn a_cold_start_on_a_moving_wire_is_caught_up_with_soon() {
        // In 0.1 s, not in the several 1/ω that constant gains would take from a wrong velocity.
        let mut observer = bare(1000.0, 3.0);
        let mut m = Motion::default();
        for k in 0..100 {
            m = observer.update(Some(0.16 + 0.02 * 1e-3 * f64::from(k)), 1e-3);
        }
        assert!((m.velocity_m_s - 0.02).abs() < 0.02 * 0.1, "{m:?}");
    }

    #[test]
    fn looks_ahead_without_moving() {
        let mut observer = bare(1000.0, 20.0);
        for k in 0..3000 {
            observer.update(Some(0.16 + 0.02 * 1e-3 * f64::from(k)), 1e-3);
        }
        let now = observer.motion();
        assert!((observer.ahead(0.004).length_m - now.length_m - 0.02 * 0.004).abs() < 1e-8);
        assert_eq!(observer.ahead(f64::NAN), now);
        assert_eq!(observer.motion(), now);
    }

    #[test]
    fn rejects_what_it_cannot_use() {
        assert!(MotionObserver::new(0.0, ObserverConfig::default()).is_err());
        assert!(MotionObserver::new(f64::NAN, ObserverConfig::default()).is_err());
        let config = ObserverConfig { bandwidth_hz: f64::NAN, ..ObserverConfig::default() };
        assert!(MotionObserver::new(1000.0, config).is_err());
        let drive = Drive { damping_ratio: -1.0, ..DRIVE };
        assert!(MotionObserver::new(1000.0, ObserverConfig::with_drive(60e-6, drive)).is_err());
    }

    #[test]
    fn the_bandwidth_of_a_jerk_is_the_one_of_its_density() {
        let hz = ObserverConfig::bandwidth_for_jerk(400.0, 0.005, 60e-6, 1000.0);
        let density = (std::f64::consts::TAU * hz).powi(6) * 60e-6f64.powi(2) * 1e-3;
        assert!((density / (2.0 * 400.0 * 400.0 * 0.005) - 1.0).abs() < 1e-9);
    }

    fn any_observer() -> impl Strategy<Value = (f64, MotionObserver)> {
        let drive = (0.0f64..5.0, -2.0f64..2.0, -0.1f64..0.1).prop_map(|(natural, damping, full_duty_m_s)| Drive {
            natural_rad_s: 10f64.powf(natural),
            damping_ratio: 10f64.powf(damping),
            full_duty_m_s,
        });
        (2.0f64..4.0, 0.0f64..1.6, proptest::option::of(drive)).prop_map(|(rate, bandwidth, drive)| {
            let rate_hz = 10f64.powf(rate);
            let bandwidth_hz = 10f64.powf(bandwidth);
            let config = ObserverConfig { bandwidth_hz, drive, ..ObserverConfig::default() };
            (rate_hz, MotionObserver::new(rate_hz, config).unwrap())
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn exact_for_constant_acceleration_at_any_rate_and_step(
            rate in 2.0f64..4.0, bandwidth_hz in 3.0f64..30.0, v in -0.05f64..0.05, a in -0.5f64..0.5, seed: u64,
        ) {
            let rate_hz = 10f64.powf(rate);
            // a run of missing lengths must not be taken for a new start
            let config = ObserverConfig { bandwidth_hz, max_age_s: 1.0, ..ObserverConfig::default() };
            let mut observer = MotionObserver::new(rate_hz, config).unwrap();
            let mut rng = SmallRng::seed_from_u64(seed);
            let (mut t, mut m) = (0.0, Motion::default());
            let until = 30.0 / bandwidth_hz;
            while t < until {
                let dt = rng.random_range(0.3..1.9) / rate_hz;
                t += dt;
                // One in ten does not arrive.
                let length = (rng.random_range(0..10) != 0).then_some(0.16 + t * (v + 0.5 * a * t));
                m = observer.update(length, dt);
            }
            prop_assert!((m.length_m - (0.16 + t * (v + 0.5 * a * t))).abs() < 1e-9, "{m:?}");
            prop_assert!((m.velocity_m_s - (v + a * t)).abs() < 1e-7, "{m:?}");
            prop_assert!((m.acceleration_m_s2 - a).abs() < 1e-5, "{m:?} {a}");
        }

        #[test]
        fn exact_for_constant_velocity_with_any_drive(
            (rate_hz, mut observer) in any_observer(), v in -0.05f64..0.05, duty in 0.0f64..1.0,
        ) {
            // As slow as the slowest of observer and load, with margin; unknown loads may be slower than any run.
            let plant = observer.plant;
            let slow = if plant.driven { plant.stiffness.sqrt().min(plant.stiffness / plant.damping) } else { f64::INFINITY };
            let slow = slow.min(observer.config.bandwidth_hz);
            prop_assume!(slow > 1.0);
            observer.set_duty(duty);
            let cycles = (200.0 * rate_hz / slow) as u32;
            prop_assume!(cycles < 200_000);
            let mut m = Motion::default();
            for k in 0..cycles {
                m = observer.update(Some(0.16 + v * f64::from(k) / rate_hz), 1.0 / rate_hz);
            }
            prop_assert!((m.velocity_m_s - v).abs() < 1e-5, "{m:?} {v} {plant:?}");
            prop_assert!(m.acceleration_m_s2.abs() < 1e-2, "{m:?} {plant:?}");
        }

        #[test]
        fn stable_and_finite_whatever_comes((rate_hz, mut observer) in any_observer(), seed: u64) {
            let mut rng = SmallRng::seed_from_u64(seed);
            for _ in 0..5000 {
                let dt = match rng.random_range(0..50) {
                    0 => rng.random_range(0.0..100.0) / rate_hz,
                    1 => [f64::NAN, -1.0, 0.0, f64::INFINITY, 1e300][rng.random_range(0..5)],
                    _ => rng.random_range(0.5..1.5) / rate_hz,
                };
                observer.set_duty(if rng.random_range(0..20) == 0 { f64::NAN } else { rng.random_range(0.0..1.0) });
                let length = match rng.random_range(0..20) {
                    0 => Some(f64::NAN),
                    1 | 2 => None,
                    _ => Some(0.163 + 60e-6 * rng.sample::<f64, _>(StandardNormal)),
                };
                let m = observer.update_weighted(length, 60e-6 * rng.random_range(0.5..3.0), dt);
                let d = observer.deviation();
                for value in [m.length_m, m.velocity_m_s, m.acceleration_m_s2, d.length_m, d.velocity_m_s] {
                    prop_assert!(value.is_finite(), "{m:?} {d:?}");
                }
            }
            // Whatever that did to it, a second of good lengths puts it right.
            for _ in 0..(2.0 * rate_hz) as u32 {
                observer.set_duty(0.0);
                let m = observer.update(Some(0.163), 1.0 / rate_hz);
                prop_assert!(m.length_m.is_finite());
            }
            prop_assert!((observer.motion().length_m - 0.163).abs() < 1e-3, "{:?}", observer.motion());
        }

        #[test]
        fn shifted_and_scaled_lengths_give_shifted_and_scaled_motion(
            (rate_hz, observer) in any_observer(), shift in -0.1f64..0.1, scale in 0.1f64..10.0, seed: u64,
        ) {
            let mut rng = SmallRng::seed_from_u64(seed);
            let (mut plain, mut other) = (observer.clone(), observer);
            for _ in 0..500 {
                let length = 0.16 + 1e-3 * rng.sample::<f64, _>(StandardNormal);
                let dt = rng.random_range(0.5..1.5) / rate_hz;
                let a = plain.update(Some(length), dt);
                let b = other.update(Some(scale * length + shift), dt);
                prop_assert!((scale * a.length_m + shift - b.length_m).abs() < 1e-9 * scale);
                prop_assert!((scale * a.velocity_m_s - b.velocity_m_s).abs() < 1e-7 * scale * rate_hz);
            }
        }
    }
}
