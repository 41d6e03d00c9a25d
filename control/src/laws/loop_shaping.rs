//! H∞ loop shaping on the logistic model (table 5: "Fermi–Dirac statistics model, robust H∞ loop shaping").
//!
//! Jayender, Patel, Nikumb and Ostojic (*H∞ loop shaping controller for shape memory alloy actuators*, CDC 2005; *Modeling and control of shape
//! memory alloy actuators*, IEEE Trans. Control Systems Technology 16, 2008) take the martensite fraction for a Fermi–Dirac distribution of the
//! temperature, which is the logistic curve of eq. 20, linearise it, and design by McFarlane and Glover's loop shaping: a weight W₁ gives
//! the plant G the open loop that is wanted, and the controller that is most robust against errors of the shaped plant's normalised coprime
//! factors is known in closed form from two Riccati equations.
//!
//! Ours: the plant, in strokes by duty, at the steepest point of the heating curve, its slope k/4,
//!
//! ```text
//! C Ṫ = P_max u − h A_s T − H ẏ,   τ ẏ = T (k/4) − y       τ: the load's drag, eq. 12 and 51
//! ```
//!
//! W₁ = k_w (s + λ/10)/s, with k_w such that the open loop crosses 1 at λ, and 1.1 times the least γ. The controller runs in the observer form
//! with the duty that was given, and W₁ in Hanus' self-conditioned form (both as in Skogestad and Postlethwaite, *Multivariable Feedback
//! Control*, chapter 9), so that limits do not wind it up; both are stepped implicitly. The hysteresis is to it an error of the model.

use crate::demand::{Demand, Law, Range};
use crate::wire_map::WireMap;
use sinew_state_space::riccati::care;
use sinew_state_space::{DMatrix, eigenvalues};

/// States of the shaped plant: stroke, temperature in strokes, and the weight's integral.
const STATES: usize = 3;
/// Corner of the weight's integral action, in λ.
const CORNER: f64 = 0.1;
/// γ, in the least that there is.
const ABOVE_LEAST: f64 = 1.1;
/// Quickest load that is told from one without inertia and drag, s.
const QUICKEST_S: f64 = 1e-3;

type Matrix = [[f64; STATES]; STATES];
type Vector = [f64; STATES];

/// The shaped plant's controller: x̂' = (A + HC) x̂ − H y + B u, u = K x̂.
#[derive(Debug, Clone, Copy)]
struct Shaped {
    observer: Matrix,
    injection: Vector,
    input: Vector,
    gain: Vector,
    /// The weight's gain k_w, and its corner, 1/s.
    weight: f64,
    corner: f64,
}

/// The shaped plant A, B, C of a plant and its weight.
struct Plant {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    weight: f64,
}

impl Plant {
    /// Of the wire at the steepest point of its heating curve; the loop crosses 1 at `lambda`, 1/s.
    fn shaped(m: &WireMap, lambda: f64, stroke_m: f64) -> Plant {
        let stress = m.stress(0.5 * m.length * m.strain, 0.0);
        let branch = m.branch(0.5, stress);
        // a stroke's worth of temperature, and the time in which the load follows
        let kelvin = branch.kelvin_per_metre(m.heating_width) * stroke_m;
        let rate = 1.0 / (branch.drag(m.heating_width) * stroke_m / kelvin).max(QUICKEST_S);
        let heat = m.heat_capacity * kelvin;
        let latent = m.release(stress) / heat * rate;
        let loss = m.loss * m.per_heat_capacity;
        // stroke, and temperature over `kelvin`
        let (a, b) = ([[-rate, rate], [latent, -loss - latent]], [0.0, m.full_power / heat]);
        // |G| at jλ: y = b rate / ((s + rate)(s + loss + latent) − rate latent)
        let square = |re: f64, im: f64| (re * re + im * im).sqrt();
        let below = square(rate * loss - lambda * lambda, lambda * (rate + loss + latent));
        let plant = rate * b[1] / below;
        let corner = CORNER * lambda;
        let weight = 1.0 / (plant * square(1.0, CORNER));
        let through = weight * corner * b[1];
        Plant {
            a: DMatrix::from_row_slice(3, 3, &[a[0][0], a[0][1], 0.0, a[1][0], a[1][1], through, 0.0, 0.0, 0.0]),
            b: DMatrix::from_row_slice(3, 1, &[0.0, weight * b[1], 1.0]),
            c: DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0]),
            weight,
        }
    }

    /// McFarlane and Glover's controller of this plant: injection H, gain K, and γ.
    fn robust(&self) -> Option<(DMatrix<f64>, DMatrix<f64>, f64)> {
        let (a, b, c, one) = (&self.a, &self.b, &self.c, DMatrix::identity(1, 1));
        let x = care(a, b, &(c.transpose() * c), &one).ok()?;
        let z = care(&a.transpose(), &c.transpose(), &(b * b.transpose()), &one).ok()?;
        let largest = eigenvalues(&(&x * &z)).ok()?.iter().fold(0.0, |most: f64, pole| most.max(pole.re));
        let gamma = ABOVE_LEAST * (1.0 + largest).sqrt();
        let per = 1.0 / (gamma * gamma);
        let inner = DMatrix::identity(STATES, STATES) * (1.0 - per) - &x * &z * per;
        let gain = -b.transpose() * inner.try_inverse()? * x;
        Some((-z * c.transpose(), gain, gamma))
    }
}

impl Shaped {
    fn designed(m: &WireMap, lambda: f64, stroke_m: f64) -> Option<Shaped> {
        let plant = Plant::shaped(m, lambda, stroke_m);
        let (injection, gain, _) = plant.robust()?;
        let observer = &plant.a + &injection * &plant.c;
        let sound = observer.iter().chain(gain.iter()).chain(plant.b.iter()).all(|value| value.is_finite());
        sound.then(|| Shaped {
            observer: std::array::from_fn(|i| std::array::from_fn(|j| observer[(i, j)])),
            injection: std::array::from_fn(|i| injection[i]),
            input: std::array::from_fn(|i| plant.b[i]),
            gain: std::array::from_fn(|i| gain[i]),
            weight: plant.weight,
            corner: CORNER * lambda,
        })
    }

    /// x̂ after `dt`, implicitly.
    #[inline]
    fn observed(&self, before: &Vector, output: f64, input: f64, dt: f64) -> Vector {
        let right: Vector =
            std::array::from_fn(|i| before[i] + dt * (self.input[i] * input - self.injection[i] * output));
        let left: Matrix =
            std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)) - dt * self.observer[i][j]));
        let after = solved(&left, &right);
        // what has overflowed is forgotten
        if after.iter().all(|state| state.is_finite()) { after } else { [0.0; STATES] }
    }
}

/// M x = v by Cramer's rule.
#[inline]
fn solved(m: &Matrix, v: &Vector) -> Vector {
    let det = |a: &Vector, b: &Vector, c: &Vector| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    // columns
    let [a, b, c]: [Vector; STATES] = std::array::from_fn(|j| std::array::from_fn(|i| m[i][j]));
    let whole = det(&a, &b, &c);
    [det(v, &b, &c) / whole, det(&a, v, &c) / whole, det(&a, &b, v) / whole]
}

/// u = W₁ K∞ y.
#[derive(Debug, Clone)]
pub struct LoopShaping {
    /// None where there is no such controller.
    shaped: Option<Shaped>,
    stroke_m: f64,
    range: Range,
    /// x̂, the weight's integral, and what went into the shaped plant in the cycle before.
    state: Vector,
    integral: f64,
    given: f64,
}

impl LoopShaping {
    pub(crate) fn new(map: &WireMap, lambda: f64, stroke_m: f64, range: Range) -> LoopShaping {
        let shaped = Shaped::designed(map, lambda, stroke_m);
        LoopShaping { shaped, stroke_m, range, state: [0.0; STATES], integral: 0.0, given: 0.0 }
    }
}

impl Law for LoopShaping {
    #[inline]
    fn duty(&mut self, demand: &Demand) -> Option<f64> {
        if !demand.is_usable() {
            return None;
        }
        let Some(k) = &self.shaped else { return Some(self.range.minimum) };
        let short_of = (demand.reference_m - demand.length_m) / self.stroke_m;
        self.state = k.observed(&self.state, short_of, self.given, demand.dt_s);
        let asked: f64 = k.gain.iter().zip(&self.state).map(|(gain, state)| gain * state).sum();
        let wanted = k.weight * (asked + k.corner * self.integral);
        // in this order a NaN becomes the minimum
        let duty = wanted.max(self.range.minimum).min(self.range.maximum);
        self.given = duty / k.weight - k.corner * self.integral;
        self.integral = (self.integral + demand.dt_s * duty / k.weight) / (1.0 + demand.dt_s * k.corner);
        Some(duty)
    }

    fn reset(&mut self) {
        (self.state, self.integral, self.given) = ([0.0; STATES], 0.0, 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demand::Modulation;
    use crate::testing::{hanging, standing, wire};
    use sinew_physics::WireModel;
    use sinew_state_space::Complex;

    const LAMBDA: f64 = 10.0;
    const STROKE_M: f64 = 6e-3;

    fn maps() -> [WireMap; 2] {
        [wire(), WireModel { load: hanging(0.13, 0.9, 18.0, 1.4), ..wire() }].map(|model| WireMap::new(&model))
    }

    /// C (jω − A)⁻¹ B.
    fn response(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, omega: f64) -> Complex<f64> {
        let complex = |m: &DMatrix<f64>| m.map(|value| Complex::new(value, 0.0));
        let resolvent = DMatrix::identity(a.nrows(), a.nrows()) * Complex::new(0.0, omega) - complex(a);
        (complex(c) * resolvent.try_inverse().unwrap() * complex(b))[(0, 0)]
    }

    /// The shaped loop crosses 1 where it should; the wire's slope there is the logistic curve's, k/4.
    #[test]
    fn the_open_loop_crosses_at_lambda() {
        for m in maps() {
            let plant = Plant::shaped(&m, LAMBDA, STROKE_M);
            let gain = response(&plant.a, &plant.b, &plant.c, LAMBDA).norm();
            assert!((gain - 1.0).abs() < 1e-9, "{gain}");
            // at rest the stroke follows the heat lost: power over loss over the kelvins of a stroke
            let still = response(&plant.a, &plant.b, &plant.c, 1e-7).norm() * 1e-7 / (plant.weight * CORNER * LAMBDA);
            let slope =
                1.0 / (m.branch(0.5, m.stress(0.5 * m.length * m.strain, 0.0)).kelvin_per_metre(m.heating_width));
            assert!((still / (m.full_power / m.loss * slope / STROKE_M) - 1.0).abs() < 1e-6, "{still}");
        }
    }

    /// What the design promises, against a computation that does not know how it was made: the closed loop is stable, and from any
    /// disturbance of the coprime factors to input and output no frequency is amplified by more than γ; near some it nearly is.
    #[test]
    fn no_frequency_is_amplified_beyond_gamma() {
        for m in maps() {
            let plant = Plant::shaped(&m, LAMBDA, STROKE_M);
            let (injection, gain, gamma) = plant.robust().unwrap();
            let observer = &plant.a + &injection * &plant.c + &plant.b * &gain;
            let mut all = DMatrix::zeros(6, 6);
            all.view_mut((0, 0), (3, 3)).copy_from(&plant.a);
            all.view_mut((0, 3), (3, 3)).copy_from(&(&plant.b * &gain));
            all.view_mut((3, 0), (3, 3)).copy_from(&(-&injection * &plant.c));
            all.view_mut((3, 3), (3, 3)).copy_from(&observer);
            assert!(eigenvalues(&all).unwrap().iter().all(|pole| pole.re < 0.0));
            let mut most = 0f64;
            for k in 0..400 {
                let omega = 10f64.powf(-3.0 + f64::from(k) * 0.02);
                let g = response(&plant.a, &plant.b, &plant.c, omega);
                // u = K y, positive feedback
                let k = response(&observer, &-&injection, &gain, omega);
                let apart = (g * k - 1.0).norm_sqr();
                most = most.max(((1.0 + k.norm_sqr()) * (1.0 + g.norm_sqr()) / apart).sqrt());
            }
            assert!(most <= gamma * (1.0 + 1e-6) && most > 0.8 * gamma && gamma < 5.0, "{most} {gamma}");
        }
    }

    fn demand(error_m: f64, dt_s: f64) -> Demand {
        Demand { dt_s, ..standing(0.163, 0.163 + error_m) }
    }

    /// Run cycle by cycle within its limits it is the transfer function it was designed as: a slow sine of the error comes out
    /// with the gain and the phase of W₁K.
    #[test]
    fn runs_as_designed() {
        let m = maps()[0];
        let mut law = LoopShaping::new(&m, LAMBDA, STROKE_M, Range::new(-1.0, 1.0, Modulation::Switched));
        // both signs have to be had: no wire takes that, but a transfer function does
        (law.range.minimum, law.range.maximum) = (-10.0, 10.0);
        let plant = Plant::shaped(&m, LAMBDA, STROKE_M);
        let (injection, gain, _) = plant.robust().unwrap();
        let observer = &plant.a + &injection * &plant.c + &plant.b * &gain;
        let (omega, dt) = (6.0, 1e-4);
        let s = Complex::new(0.0, omega);
        let weight = (s + CORNER * LAMBDA) / s * plant.weight;
        let expected = response(&observer, &-&injection, &gain, omega) * weight;
        let (mut sine, mut cosine) = (0.0, 0.0);
        let period = (std::f64::consts::TAU / omega / dt).round() as usize;
        for k in 0..20 * period {
            let phase = omega * dt * k as f64;
            let duty = law.duty(&demand(-1e-3 * STROKE_M * phase.sin(), dt)).unwrap();
            if k >= 19 * period {
                sine += duty * phase.sin() * 2.0 / period as f64;
                cosine += duty * phase.cos() * 2.0 / period as f64;
            }
        }
        let found = Complex::new(sine, cosine) / 1e-3;
        assert!((found / expected - 1.0).norm() < 0.02, "{found} {expected}");
    }

    /// Held off its reference for long, it lets go at once when it is past it; whatever the time since the last call.
    #[test]
    fn does_not_wind_up() {
        let mut law = LoopShaping::new(&maps()[0], LAMBDA, STROKE_M, Range::new(0.02, 1.0, Modulation::Switched));
        (0..60_000).for_each(|_| assert!(law.duty(&demand(3e-3, 1e-3)).unwrap() <= 1.0));
        assert_eq!(law.duty(&demand(3e-3, 1e-3)), Some(1.0));
        let given: Vec<f64> = (0..6000).map(|_| law.duty(&demand(-1e-3, 1e-3)).unwrap()).collect();
        // off the limit within 1/λ, and at the other as soon as its integral is
        assert!(given[100] < 0.8 && given[5999] == 0.02, "{:?}", given.iter().step_by(100).collect::<Vec<_>>());
        assert!((0.02..=1.0).contains(&law.duty(&demand(1e8, 1e8)).unwrap()));
        assert_eq!(law.duty(&demand(f64::NAN, 1e-3)), None);
        law.reset();
        assert_eq!(law.duty(&demand(0.0, 1e-3)), Some(0.02));
    }
}
