//! The effect of the observer's tuning in closed loop: a 0.125 mm × 160 mm wire with 0.2 kg under sliding-mode control.
//!
//! `cargo run --release -p sinew-sensing --example closed_loop [λ in 1/s] [rate in Hz] [mass in kg]` prints, for each way to get σ, the
//! time to settle within ±0.5 % of stroke and the overshoot of a 40 % step by heating and of the step back by cooling, and the
//! rms error while holding, the worst of three seeds; first with the bare relay, then with the power in proportion to σ
//! within a layer about the surface, around the mean of what was applied (the equivalent control), at the best layer and time
//! constant for each observer. The wire here is a small one (outer curves, one slope inside, eq. 48 and 51): enough to rank
//! observers; the driver's own figures come from the reference model.

#[path = "common/estimator.rs"]
mod estimator;

use estimator::Estimator;
use rand::{RngExt, SeedableRng, rngs::SmallRng};
use rand_distr::StandardNormal;
use sinew_sensing::{Drive, Motion, ObserverConfig};

const HEAT_CAPACITY: f64 = 12.664e-6 * 836.0;
const LATENT: f64 = 12.664e-6 * 24200.0;
const LOSS: f64 = 121.2 * std::f64::consts::PI * 0.125e-3 * 0.160;
const AMBIENT: f64 = 25.0;
const HEATING: f64 = 113.0;
const COOLING: f64 = 87.0;
const STEEPNESS: f64 = 0.31;
const INSIDE: f64 = 0.2;
const STROKE: f64 = 0.04 * 0.160;
const DAMPING: f64 = 40.0;
const POWER: f64 = 3.0;
const HOT_LENGTH: f64 = 0.1603;

struct Wire {
    mass: f64,
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
    fn new(mass: f64) -> Wire {
        Wire { mass, t: AMBIENT, xi: 1.0, x: HOT_LENGTH + STROKE, v: 0.0, a: 0.0 }
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
        self.a = (stiffness * (HOT_LENGTH + STROKE * self.xi - self.x) - DAMPING * self.v) / self.mass;
        self.v += self.a * dt;
        self.x += self.v * dt;
    }
}

/// How σ becomes a duty.
#[derive(Clone, Copy)]
enum Law {
    Relay,
    /// Width of the layer in m of σ/λ², and time constant of the equivalent control in s.
    Layer(f64, f64),
}

struct Figures {
    heating_s: f64,
    heating_over: f64,
    cooling_s: f64,
    cooling_over: f64,
    hold_rms_m: f64,
}

fn run(mass: f64, rate: f64, lambda: f64, law: Law, mut estimator: Option<Estimator>, seed: u64) -> Figures {
    let mut rng = SmallRng::seed_from_u64(seed);
    let mut wire = Wire::new(mass);
    let dt = 1.0 / rate;
    let sub = (dt / 50e-6).round().max(1.0) as u32;
    let mut result = Figures { heating_s: 0.0, heating_over: 0.0, cooling_s: 0.0, cooling_over: 0.0, hold_rms_m: 0.0 };
    let (mut next, mut duty, mut equivalent) = (0.02, 0.02, 0.02);
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
        let sample = wire.x + 60e-6 * rng.sample::<f64, _>(StandardNormal);
        let truth = Motion { length_m: wire.x, velocity_m_s: wire.v, acceleration_m_s2: wire.a };
        for _ in 0..sub {
            wire.step(POWER * duty, dt / f64::from(sub));
        }
        let applied = duty;
        duty = next;
        let motion = match &mut estimator {
            Some(estimator) => {
                let motion = estimator.update(sample, dt);
                // The sample is one period old, so what comes next for the observer is the duty of the period just past.
                if let Estimator::Observer(observer) = estimator {
                    observer.set_duty(applied);
                }
                motion
            }
            None => truth,
        };
        let surface = motion.surface(lambda, reference) / (lambda * lambda);
        match law {
            Law::Relay => next = if surface > 0.0 { 1.0 } else { 0.02 },
            Law::Layer(width, tau) => {
                next = (equivalent + surface / width).clamp(0.02, 1.0);
                equivalent += dt / tau * (next - equivalent);
            }
        }
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
    let argument = |n: usize, default: f64| std::env::args().nth(n).map_or(Ok(default), |text| text.parse());
    let (Ok(lambda), Ok(rate), Ok(mass)) = (argument(1, 10.0), argument(2, 1000.0), argument(3, 0.2)) else {
        eprintln!("usage: closed_loop [λ in 1/s] [rate in Hz] [mass in kg]");
        std::process::exit(2);
    };
    let mut laws = vec![];
    for width in [1e-3, 3e-3, 6e-3, 12e-3, 25e-3] {
        laws.extend([0.03, 0.1, 0.3].map(|tau| Law::Layer(width, tau)));
    }
    let mut rows: Vec<(String, Option<Estimator>)> = vec![
        ("the true motion".into(), None),
        ("differences at 200 Hz".into(), Some(Estimator::differences(rate, 200.0, false))),
        ("differences of means at 200 Hz".into(), Some(Estimator::differences(rate, 200.0, true))),
    ];
    for bandwidth_hz in [3.0, 5.0, 7.0, 10.0, 15.0, 30.0] {
        let config = ObserverConfig { bandwidth_hz, ..ObserverConfig::default() };
        rows.push((format!("observer, {bandwidth_hz} Hz"), Some(Estimator::observer(rate, config))));
    }
    // The wire's stiffness lies between 2100 N/m (martensite) and 5800 N/m (austenite).
    for (name, stiffness, full_duty_m_s) in [
        ("drive, 2800 N/m", 2.8e3, 0.0),
        ("drive, 5800 N/m", 5.8e3, 0.0),
        ("drive, 8000 N/m", 8e3, 0.0),
        ("drive, 5800 N/m, −5 mm/s", 5.8e3, -0.005),
        ("drive, 5800 N/m, −20 mm/s", 5.8e3, -0.02),
    ] {
        for bandwidth_hz in [5.0, 10.0, 20.0] {
            let drive = Drive::of_load(mass, DAMPING, stiffness, full_duty_m_s);
            let config = ObserverConfig { bandwidth_hz, ..ObserverConfig::with_drive(60e-6, drive) };
            rows.push((format!("{name}, {bandwidth_hz} Hz"), Some(Estimator::observer(rate, config))));
        }
    }
    println!("λ = {lambda} 1/s at {rate} Hz, {mass} kg, noise of a length 60 µm rms, stroke {:.1} mm", 1e3 * STROKE);
    println!();
    println!(
        "| σ from | relay: hold µm | layer mm, s | heating s | overshoot % | cooling s | undershoot % | hold µm |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|");
    for (name, estimator) in rows {
        let worst = |law: Law| {
            let runs = (0..3).map(|seed| run(mass, rate, lambda, law, estimator.clone(), seed));
            runs.reduce(|a, b| Figures {
                heating_s: a.heating_s.max(b.heating_s),
                heating_over: a.heating_over.max(b.heating_over),
                cooling_s: a.cooling_s.max(b.cooling_s),
                cooling_over: a.cooling_over.max(b.cooling_over),
                hold_rms_m: a.hold_rms_m.max(b.hold_rms_m),
            })
            .expect("some runs")
        };
        // One per cent over, or 10 µm, is as bad as a fifth of a second.
        let cost = |f: &Figures| {
            f.heating_s + 0.5 * f.cooling_s + 20.0 * (f.heating_over + f.cooling_over) + f.hold_rms_m / 50e-6
        };
        let best = laws.iter().map(|&law| (law, worst(law))).min_by(|a, b| cost(&a.1).total_cmp(&cost(&b.1)));
        let Some((Law::Layer(width, tau), f)) = best else { continue };
        println!(
            "| {name} | {:.0} | {}, {tau} | {:.2} | {:.1} | {:.2} | {:.1} | {:.0} |",
            1e6 * worst(Law::Relay).hold_rms_m,
            1e3 * width,
            f.heating_s,
            100.0 * f.heating_over,
            f.cooling_s,
            100.0 * f.cooling_over,
            1e6 * f.hold_rms_m
        );
    }
}
