//! What the observer's tuning costs in the loop: a 0.125 mm × 160 mm wire with 0.2 kg under sliding-mode control.
//!
//! `cargo run --release -p sinew-sensing --example closed_loop [λ in 1/s]` prints, for each way to get σ, the settling
//! time and overshoot of a 40 % step by heating, of the step back by cooling, and the rms error while holding.
//! The wire here is a small one (outer curves, one slope inside, eq. 48 and 51), enough to rank observers; the driver's own
//! figures come from the reference model.

use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::StandardNormal;
use sinew_sensing::{Drive, Motion, MotionObserver, ObserverConfig, Tuning};

const HEAT_CAPACITY: f64 = 12.664e-6 * 836.0;
const LATENT: f64 = 12.664e-6 * 24200.0;
const LOSS: f64 = 121.2 * std::f64::consts::PI * 0.125e-3 * 0.160;
const AMBIENT: f64 = 25.0;
const HEATING: f64 = 113.0;
const COOLING: f64 = 87.0;
const STEEPNESS: f64 = 0.31;
const INSIDE: f64 = 0.2;
const STROKE: f64 = 0.04 * 0.160;
const MASS: f64 = 0.2;
const DAMPING: f64 = 40.0;
const POWER: f64 = 3.0;
const HOT_LENGTH: f64 = 0.1603;

struct Wire {
    t: f64,
    xi: f64,
    x: f64,
    v: f64,
    a: f64,
}

fn sigmoid(z: f64) -> f64 {
    1.0 / (1.0 + z.exp())
}

impl Wire {
    fn new() -> Wire {
        Wire { t: AMBIENT, xi: 1.0, x: HOT_LENGTH + STROKE, v: 0.0, a: 0.0 }
    }

    fn step(&mut self, power: f64, dt: f64) {
        let heat = power - LOSS * (self.t - AMBIENT);
        let (upper, lower) = (sigmoid(STEEPNESS * (self.t - HEATING)), sigmoid(STEEPNESS * (self.t - COOLING)));
        let own = STEEPNESS * self.xi * (1.0 - self.xi);
        let riding = (heat > 0.0 && self.xi >= upper - 1e-6) || (heat < 0.0 && self.xi <= lower + 1e-6);
        let slope = if riding { own } else { INSIDE * own };
        let dt_k = heat / (HEAT_CAPACITY + LATENT * slope) * dt;
        self.t += dt_k;
        let (upper, lower) = (sigmoid(STEEPNESS * (self.t - HEATING)), sigmoid(STEEPNESS * (self.t - COOLING)));
        self.xi = (self.xi - slope * dt_k).clamp(lower, upper);
        let modulus = 1.0 / ((1.0 - self.xi) / 75e9 + self.xi / 28e9);
        let stiffness = modulus * std::f64::consts::FRAC_PI_4 * 0.125e-3f64.powi(2) / 0.160;
        self.a = (stiffness * (HOT_LENGTH + STROKE * self.xi - self.x) - DAMPING * self.v) / MASS;
        self.v += self.a * dt;
        self.x += self.v * dt;
    }
}

/// Ways to get the motion: an observer, or differences of every n-th sample as in the thesis.
enum Estimator {
    Observer(Box<MotionObserver>),
    Differences { every: u32, count: u32, last: [f64; 3], held: Motion, dt: f64 },
    Truth,
}

struct Result {
    heating_s: f64,
    heating_over: f64,
    cooling_s: f64,
    cooling_over: f64,
    hold_rms_m: f64,
}

fn run(rate: f64, lambda: f64, sigma: f64, estimator: &mut Estimator, seed: u64) -> Result {
    let mut rng = SmallRng::seed_from_u64(seed);
    let mut wire = Wire::new();
    let dt = 1.0 / rate;
    let sub = (dt / 10e-6).round().max(1.0) as u32;
    let mut result =
        Result { heating_s: 0.0, heating_over: 0.0, cooling_s: 0.0, cooling_over: 0.0, hold_rms_m: 0.0 };
    let (mut next, mut duty) = (0.02, 0.02);
    let mut squares = (0.0, 0u32);
    for cycle in 0..(8.0 * rate) as u32 {
        let time = f64::from(cycle) * dt;
        // From the cold end to 70 %, to hold, then 30 %.
        let (reference, start) = match time {
            t if t < 1.0 => (HOT_LENGTH + 0.7 * STROKE, 0.0),
            t if t < 3.5 => (HOT_LENGTH + 0.3 * STROKE, 1.0),
            _ => (HOT_LENGTH + 0.7 * STROKE, 3.5),
        };
        // Sampled in the on-phase at the start of the period; what is decided at its end acts one period later.
        let sample = wire.x + sigma * rng.sample::<f64, _>(StandardNormal);
        let truth = Motion { length_m: wire.x, velocity_m_s: wire.v, acceleration_m_s2: wire.a };
        for _ in 0..sub {
            wire.step(POWER * duty, dt / f64::from(sub));
        }
        let applied = duty;
        duty = next;
        let motion = match estimator {
            Estimator::Observer(observer) => {
                // The sample is one period old: first it, then the duty of the period after it.
                let motion = observer.update(Some(sample), dt);
                observer.set_duty(applied);
                motion
            }
            Estimator::Truth => truth,
            Estimator::Differences { every, count, last, held, dt } => {
                if *count % *every == 0 {
                    let step = *dt * f64::from(*every);
                    if *count == 0 {
                        *last = [sample; 3];
                    }
                    *last = [sample, last[0], last[1]];
                    *held = Motion {
                        length_m: sample,
                        velocity_m_s: (last[0] - last[1]) / step,
                        acceleration_m_s2: (last[0] - 2.0 * last[1] + last[2]) / (step * step),
                    };
                }
                *count += 1;
                *held
            }
        };
        next = if motion.surface(lambda, reference) > 0.0 { 1.0 } else { 0.02 };
        let error = wire.x - reference;
        if time >= 1.0 {
            let since = time - start;
            let (settled, over, beyond) = if time < 3.5 {
                (&mut result.heating_s, &mut result.heating_over, -error)
            } else {
                (&mut result.cooling_s, &mut result.cooling_over, error)
            };
            if error.abs() > 0.005 * STROKE {
                *settled = since;
            }
            *over = over.max(beyond / STROKE);
            if (2.5..3.5).contains(&time) || time > 7.0 {
                squares = (squares.0 + error * error, squares.1 + 1);
            }
        }
    }
    result.hold_rms_m = (squares.0 / f64::from(squares.1)).sqrt();
    result
}

fn main() {
    let lambda = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(10.0);
    println!("λ = {lambda} 1/s, noise of a length 60 µm rms");
    println!("rate Hz  estimator               heating s  over %   cooling s  over %   hold rms µm");
    let show = |rate: f64, name: &str, make: &dyn Fn() -> Estimator| {
        let runs: Vec<Result> = (0..4).map(|seed| run(rate, lambda, 60e-6, &mut make(), seed)).collect();
        let worst = |f: &dyn Fn(&Result) -> f64| runs.iter().map(f).fold(0.0, f64::max);
        println!(
            "{rate:>7}  {name:<22}  {:>9.3}  {:>6.2}   {:>9.3}  {:>6.2}   {:>10.1}",
            worst(&|r| r.heating_s),
            100.0 * worst(&|r| r.heating_over),
            worst(&|r| r.cooling_s),
            100.0 * worst(&|r| r.cooling_over),
            1e6 * worst(&|r| r.hold_rms_m),
        );
    };
    let observer = |rate: f64, config: ObserverConfig| {
        Estimator::Observer(Box::new(MotionObserver::new(rate, config).expect("a valid configuration")))
    };
    for rate in [1e3, 5e3, 10e3] {
        show(rate, "the true motion", &|| Estimator::Truth);
        let every = (rate / 200.0) as u32;
        for (name, every) in [("differences at 200 Hz", every), ("differences", 1)] {
            let dt = 1.0 / rate;
            show(rate, name, &|| Estimator::Differences {
                every,
                count: 0,
                last: [0.0; 3],
                held: Motion::default(),
                dt,
            });
        }
        for hz in [5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 90.0] {
            let config = ObserverConfig { tuning: Tuning::Bandwidth { hz }, ..ObserverConfig::default() };
            show(rate, &format!("observer {hz} Hz"), &|| observer(rate, config));
        }
        for (tag, natural, full) in [("", 130.0, -0.043), (" stiff", 180.0, -0.043), (" half", 130.0, -0.02), (" double", 130.0, -0.086), (" zero", 130.0, -0.0)] {
        for rest in [0.003, 0.01, 0.03, 0.1] {
            let drive = Drive {
                natural_rad_s: natural,
                damping_ratio: 0.77,
                full_duty_m_s: full,
                rest_m_s: rest,
                rest_time_s: 0.05,
            };
            let config = ObserverConfig {
                tuning: Tuning::Jerk { rms_m_s3: 1.0, hold_s: 0.01 },
                drive: Some(drive),
                ..ObserverConfig::default()
            };
            show(rate, &format!("with drive, rest {rest}{tag}"), &|| observer(rate, config));
        }
        }
    }
}
