//! The observer's equation of motion, and its propagation of state and covariance over a step.

use super::config::ObserverConfig;
use super::motion::Motion;

/// Length, velocity, acceleration, and the unknown rest of the heating velocity.
pub(super) const STATES: usize = 4;
/// A covariance or transition of the state, in the order of [`State`]'s fields.
pub(super) type Matrix = [[f64; STATES]; STATES];

/// What the filter carries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct State {
    /// Length, m.
    pub length_m: f64,
    /// Its derivative, m/s.
    pub velocity_m_s: f64,
    /// Its second derivative, m/s².
    pub acceleration_m_s2: f64,
    /// What is unknown of the heating velocity, m/s.
    pub rest_m_s: f64,
}

impl State {
    /// A wire that stands at this length.
    pub fn standing(length_m: f64) -> State {
        State { length_m, ..State::default() }
    }

    /// All zero but for a 1 in one place.
    fn unit(place: usize) -> State {
        let at = |i: usize| f64::from(u8::from(i == place));
        State { length_m: at(0), velocity_m_s: at(1), acceleration_m_s2: at(2), rest_m_s: at(3) }
    }

    fn as_array(&self) -> [f64; STATES] {
        [self.length_m, self.velocity_m_s, self.acceleration_m_s2, self.rest_m_s]
    }

    /// Follows a surprise in the length, in m.
    #[inline]
    pub fn correct(&mut self, gain: &Gain, surprise_m: f64) {
        let [length, velocity, acceleration, rest] = gain.0;
        self.length_m += length * surprise_m;
        self.velocity_m_s += velocity * surprise_m;
        self.acceleration_m_s2 += acceleration * surprise_m;
        self.rest_m_s += rest * surprise_m;
    }

    /// Its part that others see.
    pub fn motion(&self) -> Motion {
        let State { length_m, velocity_m_s, acceleration_m_s2, .. } = *self;
        Motion { length_m, velocity_m_s, acceleration_m_s2 }
    }
}

/// By how much of a surprise in the length each part of the state is corrected, in the order of [`State`]'s fields.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Gain(pub [f64; STATES]);

impl Gain {
    /// Whether every part differs from `other`'s by no more than a share of that.
    pub fn is_near(&self, other: &Gain, share: f64) -> bool {
        self.0.iter().zip(other.0).all(|(a, b)| (a - b).abs() <= share * b.abs())
    }

    /// Of the length itself.
    pub fn of_length(&self) -> f64 {
        self.0[0]
    }
}

/// The equation of motion: x⃛ = stiffness (w − ẋ) − damping ẍ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plant {
    /// ω², 1/s².
    pub stiffness: f64,
    /// 2ζω, 1/s.
    pub damping: f64,
    /// Reciprocal of the longest step of the series in [`Plant::advance`].
    per_step: f64,
    /// Whether eq. 68 is in it at all.
    pub driven: bool,
    /// Velocity that duty 1 heats the wire to, m/s.
    pub full_duty: f64,
    /// Density of the unknown jerk, m²/s⁵, and of the unknown heating velocity, m²/s³.
    jerk_psd: f64,
    rest_psd: f64,
}

impl Plant {
    pub fn new(config: &ObserverConfig, dt_s: f64) -> Plant {
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
    pub fn advance(&self, state: &mut State, w: f64, dt: f64) {
        let State { length_m: x, velocity_m_s: v, acceleration_m_s2: a, rest_m_s: rest } = state;
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
    pub fn discretise(&self, dt: f64) -> Step {
        // The noise of the bare chain is exact for short steps and doubled up from there; without a drive at any length.
        let doublings = if self.driven { (dt * self.per_step * 4.0).log2().ceil().clamp(0.0, 12.0) as i32 } else { 0 };
        let h = dt / 2f64.powi(doublings);
        let mut f = [[0.0; STATES]; STATES];
        for column in 0..STATES {
            let mut unit = State::unit(column);
            self.advance(&mut unit, 0.0, h);
            for (row, value) in f.iter_mut().zip(unit.as_array()) {
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
pub(super) struct Step {
    /// Its length, s.
    pub dt: f64,
    /// Transition matrix.
    f: Matrix,
    /// Process noise gathered over it.
    q: Matrix,
}

impl Step {
    /// Takes a covariance over the step.
    pub fn predict(&self, p: &mut Matrix) {
        let mut next = congruence(&self.f, p);
        for (next, noise) in next.iter_mut().flatten().zip(self.q.iter().flatten()) {
            *next += noise;
        }
        *p = next;
    }
}

/// Takes a measurement of the length with variance `r` into the covariance; returns the gain.
#[inline]
pub(super) fn correct(p: &mut Matrix, r: f64) -> Gain {
    let scale = 1.0 / (p[0][0] + r);
    let row = p[0];
    let gain = row.map(|entry| entry * scale);
    for i in 0..STATES {
        for j in 0..STATES {
            p[i][j] -= gain[i] * row[j];
        }
    }
    Gain(gain)
}
