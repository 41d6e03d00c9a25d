//! Chapter 10: linearising controllers.

use sinew_bench::{Step, Trace};
use sinew_control::{Coupling, LpvModel, StateSpace};
use sinew_physics::{Inputs, Load, Material, Wire, WireModel};
use sinew_plot::Ink;
use sinew_state_space::derive::jacobian;
use sinew_state_space::rank::{controllability_rank, observability_rank};
use sinew_state_space::riccati::lqr;
use sinew_state_space::servo::augment;
use sinew_state_space::{Complex, DMatrix, DVector, eigenvalues};

use super::nine::{SLOPE_PER_K, middle, rig, simplified};
use crate::axes::TIME;
use crate::chapter::Chapter::Ten;
use crate::chapter::Place::{Displayed, Equation, Figure};
use crate::found::{Found, Tried};
use crate::lab::{Chosen, Lab, Run};
use crate::row::{Computed, Row};
use crate::wires::{STEP_S, hanging, largest, least, table_10};

const LPV: &str = "control/src/lpv.rs";
const LINEARISED: &str = "control/src/laws/linearised.rs";
const SERVO: &str = "control/src/laws/servo.rs";
const DERIVE: &str = "control/state-space/src/derive.rs";

/// M and B of table 10.
const MASS_KG: f64 = 0.13;
const DAMPING_N_S_PER_M: f64 = 0.915;

fn equation(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Ten, Equation(number), title, states)
}

fn displayed(nth: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Ten, Displayed(nth), title, states)
}

fn figure(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Ten, Figure(number), title, states)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = input_output();
    rows.extend(velocity());
    rows
}

/// (K + K_SMA)/M and K_SMA L ε_L/M.
fn shares(stiffness: f64) -> (f64, f64) {
    ((18.0 + stiffness) / MASS_KG, stiffness * 0.233 * 0.04 / MASS_KG)
}

/// Chapter 10's system: differentiated once, at a slope.
fn velocities(slope: f64) -> Tried<StateSpace> {
    let model = simplified(table_10());
    Ok(LpvModel::new(&model, Coupling::Thermal)?.velocity_form(&middle(&model), slope))
}

/// The wire of chapter 9's form under P = α u + β with β the loss and α times a factor: its system from u to x.
fn linearised(factor: f64) -> Tried<(StateSpace, f64)> {
    let (_, form, stiffness) = rig()?;
    let (total, push) = shares(stiffness);
    let q = 1.0 / form.b[3];
    let alpha = factor * total / (push * SLOPE_PER_K) * q;
    let mut a = form.a.clone();
    // β = h A_s (T − T_∞)
    let loss = -form.a[(3, 3)] * q;
    for i in 0..4 {
        a[(i, 3)] += form.b[i] * loss;
    }
    Ok((StateSpace { a, b: &form.b * alpha, ..form }, total))
}

/// x⃛ as u = 1 begins: C A² B.
fn jerk(form: &StateSpace) -> f64 {
    (&form.c * &form.a * &form.a * &form.b)[(0, 0)]
}

/// The poles of a matrix, nearest to the origin first.
fn poles(a: &DMatrix<f64>) -> Tried<Vec<Complex<f64>>> {
    let mut poles = eigenvalues(a)?;
    poles.sort_by(|x, y| x.norm().total_cmp(&y.norm()));
    Ok(poles)
}

fn third_derivative(_: &Lab, found: &mut Found) -> Computed {
    let (_, form, stiffness) = rig()?;
    let (total, push) = shares(stiffness);
    found.equal("x⃛ by ẋ", "1/s²", -total, form.a[(1, 0)]);
    found.equal("x⃛ by ẍ", "1/s", -DAMPING_N_S_PER_M / MASS_KG, form.a[(1, 1)]);
    found.equal("x⃛ by ξ̇", "m/s²", push, form.a[(1, 2)]);
    Ok(())
}

fn input_output() -> Vec<Row> {
    vec![
        equation(
            55,
            "the length, differentiated",
            "Three times differentiated, the length has ẋ, ẍ and ξ̇ in it, and \
                the power behind ξ̇.",
        )
        .code(LINEARISED, "eq. 55")
        .agrees(third_derivative),
        equation(56, "the phase by power", "ξ̇ = (∂ξ/∂T)(P − h A_s (T − T_∞))/Q.")
            .code(LPV, "pub fn martensite_form")
            .agrees(|_, found| {
                let (model, form, _) = rig()?;
                let q = 1.0 / form.b[3];
                found.equal("ξ̇ by P, times Q", "1/K", SLOPE_PER_K, form.b[2] * q);
                found.equal(
                    "ξ̇ by T, times −Q/(h A_s)",
                    "1/K",
                    SLOPE_PER_K,
                    -form.a[(2, 3)] * q / model.constant_loss_w_per_k(),
                );
                Ok(())
            }),
        equation(57, "the length by power", "Eq. 55 with eq. 56: the power enters x⃛ by K_SMA L ε_L (∂ξ/∂T)/(M Q).")
            .code(LINEARISED, "Differentiated until the power appears")
            .agrees(|_, found| {
                let (_, form, stiffness) = rig()?;
                let stated = shares(stiffness).1 * SLOPE_PER_K * form.b[3];
                found.equal("x⃛ by P", "m/(s³ W)", stated, jerk(&form));
                Ok(())
            }),
        equation(58, "the law that cancels", "P = α u + h A (T − T_∞), α = Q (K_SMA + K)/(K_SMA e_L ∂ξ/∂T).")
            .code(LINEARISED, "P = α u + β")
            .differs(
                "e_L has to be the length L ε_L for eq. 57 to become eq. 59, while \
                    the chapter before uses it for the strain",
                |_, found| {
                    let (printed, total) = linearised(0.233)?;
                    found.near("x⃛ by u, times M/(K + K_SMA), e_L = ε_L", "1", 1.0, 0.01, jerk(&printed) / total);
                    found.proof();
                    let (meant, total) = linearised(1.0)?;
                    found.near("the same, e_L = L ε_L", "1", 1.0, 1e-9, jerk(&meant) / total);
                    Ok(())
                },
            ),
        equation(
            59,
            "what is left",
            "An integrator times the load's own second order: (K + K_SMA)/(M s³ + \
                B s² + (K + K_SMA) s).",
        )
        .code(LINEARISED, "leaves 1/s times the load's own modes (eq. 59)")
        .agrees(|_, found| {
            let (form, total) = linearised(1.0)?;
            let poles = poles(&form.a)?;
            let half = 0.5 * DAMPING_N_S_PER_M / MASS_KG;
            found.nothing("integrator", "1/s", 1e-3, poles[0].norm());
            // the fourth state, the difference of phase and temperature, is not driven
            found.nothing("what the input does not reach", "1/s", 1e-3, poles[1].norm());
            found.near("damping of the load's pair", "1/s", -half, 1e-6, poles[2].re);
            found.near("frequency of the load's pair", "1/s", (total - half * half).sqrt(), 1e-6, poles[2].im.abs());
            found.equal("x⃛ by u", "1/s³", total, jerk(&form));
            Ok(())
        }),
        displayed(
            1,
            "the hidden dynamics",
            "Left to itself the temperature obeys Ṫ = P_ss/(m c_p) − h A (T + \
                T_∞)/(m c_p).",
        )
        .code("model/physics/src/formulas/thermal.rs", "pub fn relaxed")
        .differs(
            "the loss is to the air, T − T_∞: with the printed sign a wire \
                without power would cool to −25 °C in air of 25 °C",
            |_, found| {
                let model = hanging();
                let mut wire = Wire::new(&model)?;
                for _ in 0..30_000 {
                    wire.step(&Inputs { drive: 0.2, ..model.rest_inputs() }, STEP_S);
                }
                let over = 0.2 / model.constant_loss_w_per_k();
                found.near("where a wire on 0.2 W settles, simulated", "°C", over - 25.0, 0.1, wire.temperature_c());
                found.proof();
                found.near("the same with T − T_∞", "°C", over + 25.0, 0.1, wire.temperature_c());
                Ok(())
            },
        ),
        figure(
            100,
            "root locus of the proportional loop",
            "The loop is stable as long as the gain is not too high; a slope that \
                is wrong moves along the locus.",
        )
        .code(LINEARISED, "pub struct InputOutputLinearised")
        .agrees(|_, found| {
            let (form, _) = linearised(1.0)?;
            let closed = |gain: f64| -> Tried<Vec<Complex<f64>>> {
                // the state that is not reached stays at 0, and does not count
                poles(&(&form.a - &form.b * &form.c * gain))
            };
            let fastest = |gain: f64| -> Tried<f64> {
                Ok(largest(
                    &closed(gain)?.iter().filter(|pole| pole.norm() > 1e-3).map(|pole| pole.re).collect::<Vec<_>>(),
                ))
            };
            // M s³ + B s² + K' s + K' g: stable for g below B/M
            let limit = DAMPING_N_S_PER_M / MASS_KG;
            found.below("largest real part, gain 0.9 B/M", "1/s", 0.0, fastest(0.9 * limit)?);
            found.above("largest real part, gain 1.1 B/M", "1/s", 0.0, fastest(1.1 * limit)?);
            let (mut x, mut y) = (Vec::new(), Vec::new());
            for i in 0..200 {
                for pole in closed(0.01 * 1.045f64.powi(i))? {
                    x.push(pole.re);
                    y.push(pole.im);
                    // points, no line between poles of different branches
                    x.push(f64::NAN);
                    y.push(f64::NAN);
                }
            }
            found.line(("Real part, 1/s", "1"), ("Imaginary part, 1/s", "1"), Ink::Series(0), (x, y));
            Ok(())
        }),
        figure(
            101,
            "linearised with estimated coefficients",
            "Far from the transformation the inversion asks for too much, and the \
                wire does not come to rest.",
        )
        .code("control/src/wire_map.rs", "LEAST_SLOPE")
        .agrees(|_, found| {
            let (steps, trace) = steps("thesis_3w", "input_output_linearised")?;
            found.above(
                "what is left of motion, of the stroke",
                "± %",
                0.5,
                100.0 * largest(&steps.map(|step| step.cycle)),
            );
            draw_steps(found, trace);
            Ok(())
        }),
        figure(
            102,
            "linearised with a constant slope",
            "With −0.05/K throughout it does as well: what counts is that the \
                heat loss is fed forward.",
        )
        .code(LINEARISED, "CONSTANT_SLOPE_PER_K")
        .agrees(|_, found| {
            let middle = |steps: [Step; 3]| {
                let mut rms = steps.map(|step| 100.0 * step.rms);
                rms.sort_by(f64::total_cmp);
                rms[1]
            };
            let whole = middle(steps("thesis_3w", "input_output_linearised")?.0);
            let (constant, trace) = steps("thesis_3w", "input_output_linearised_constant")?;
            let constant = middle(constant);
            let blind = middle(steps("thesis_no_feedforward", "input_output_linearised")?.0);
            found.below(
                "error with the slope constant less that of the whole law, over what \
                    the loss not fed forward adds",
                "1",
                0.5,
                (constant - whole) / (blind - whole),
            );
            found.above("what the loss not fed forward adds to the error, of the stroke", "%", 1.0, blind - whole);
            draw_steps(found, trace);
            Ok(())
        }),
    ]
}

/// Steps to 40, 80 and 40 % on a plant of chapter 11, and the way.
fn steps(plant: &str, law: &'static str) -> Tried<([Step; 3], Trace)> {
    let mut run = Run::new(plant, Chosen::law(law))?;
    let steps = [0.4, 0.8, 0.4].map(|to| run.step(to));
    Ok((steps, run.trace))
}

/// Held at 40 % for twelve seconds: the mean error at the end, % of the stroke, and the way.
fn held(law: &'static str) -> Tried<(f64, Trace)> {
    let mut run = Run::new("thesis_3w", Chosen::law(law))?;
    let steps = [0.4; 4].map(|to| run.step(to));
    Ok((100.0 * steps[3].mean, run.trace))
}

fn draw_steps(found: &mut Found, trace: Trace) {
    found.legend(Ink::Measured, "reference");
    found.legend(Ink::Series(0), "wire");
    let stroke = ("Stroke, 0 cold", "1");
    found.line(TIME, stroke, Ink::Measured, (trace.time_s.clone(), trace.reference));
    found.line(TIME, stroke, Ink::Series(0), (trace.time_s.clone(), trace.stroke));
    found.line(TIME, ("Duty", "1"), Ink::Series(0), (trace.time_s, trace.duty));
}

/// Complex steps through a system of one's own with a product and an exponential in it, beside derivatives by hand.
pub(crate) fn linearisation(_: &Lab, found: &mut Found) -> Computed {
    let f = |z: &DVector<Complex<f64>>| DVector::from_vec(vec![z[1], -z[0] * z[1] + (z[0] * 2.0).exp() * z[2]]);
    let jacobian = jacobian(f, &DVector::from_vec(vec![0.3, -0.5, 2.0]));
    let e = 0.6f64.exp();
    for ((row, column), stated) in [((0, 1), 1.0), ((1, 0), 0.5 + 2.0 * e * 2.0), ((1, 1), -0.3), ((1, 2), e)] {
        found.equal(&format!("∂f_{}/∂z_{}", row + 1, column + 1), "1", stated, jacobian[(row, column)]);
    }
    Ok(())
}

/// The velocity form is chapter 9's, differentiated: with ξ̇ = (∂ξ/∂T) Ṫ put in.
fn differentiated(_: &Lab, found: &mut Found) -> Computed {
    let (_, form, stiffness) = rig()?;
    let velocities = velocities(SLOPE_PER_K)?;
    let (total, push) = shares(stiffness);
    found.equal("ẍ̇ by ẋ", "1/s²", -total, velocities.a[(1, 0)]);
    found.equal("ẍ̇ by ẍ", "1/s", -DAMPING_N_S_PER_M / MASS_KG, velocities.a[(1, 1)]);
    found.equal("ẍ̇ by Ṫ", "m/(s² K)", SLOPE_PER_K * push, velocities.a[(1, 2)]);
    found.equal("pole of Ṫ: that of T", "1/s", form.a[(3, 3)], velocities.a[(2, 2)]);
    found.equal("Ṫ̇ by Ṗ: T by P", "K/J", form.b[3], velocities.b[2]);
    Ok(())
}

/// Gains of the regulator of the figures, Q = diag(25·10⁴, 0, 0, 0) and R = 1, at a slope, and the closed loop.
fn servo(slope: f64) -> Tried<(DMatrix<f64>, DMatrix<f64>)> {
    let plant = velocities(slope)?;
    let (a, b) = augment(&plant.a, &plant.b, &plant.c)?;
    let mut q = DMatrix::zeros(4, 4);
    q[(0, 0)] = 25e4;
    let k = lqr(&a, &b, &q, &DMatrix::identity(1, 1))?;
    let closed = a - b * &k;
    Ok((k, closed))
}

/// How fast the rate of a temperature changes under constant power, K/s², and what eq. 62 and eq. 62 with the change of Q say of it,
/// a third of the way through the transformation.
fn second_rate() -> Tried<[f64; 3]> {
    let material = Material { transformation_strain: 0.0, outer_loop_weight: 1.0, ..Material::default() };
    let model = WireModel { material, load: Load::ImposedForce, ..hanging() };
    let mut wire = Wire::new(&model)?;
    let mut seen = Vec::new();
    let mut at = 0;
    for k in 0..4000 {
        wire.step(&Inputs { drive: 1.0, ..model.rest_inputs() }, STEP_S);
        seen.push((wire.temperature_c(), wire.martensite()));
        if at == 0 && wire.martensite() < 0.67 {
            at = k;
        }
    }
    let q = |xi: f64| model.heat_capacity_j_per_k() + model.latent_heat_j() * 0.31 * xi * (1.0 - xi);
    // over a hundredth of a second each way
    let h = 10.0 * STEP_S;
    let (before, here, after) = (seen[at - 10], seen[at], seen[at + 10]);
    let rate = (after.0 - before.0) / (2.0 * h);
    let second = (after.0 - 2.0 * here.0 + before.0) / (h * h);
    let by_loss = -model.constant_loss_w_per_k() * rate / q(here.1);
    let by_mass = -(q(after.1) - q(before.1)) / (2.0 * h) / q(here.1) * rate;
    Ok([second, by_loss, by_loss + by_mass])
}

fn velocity() -> Vec<Row> {
    vec![
        displayed(2, "a nonlinear system", "ẋ = F(x, u), y = G(x, u).")
            .code(DERIVE, "pub fn jacobian")
            .agrees(linearisation),
        displayed(3, "its Taylor series", "δẋ = A δx + B δu, δy = C δx + D δu.")
            .code(DERIVE, "pub fn jacobian")
            .agrees(linearisation),
        displayed(4, "its matrices at a point", "The gradients of F and G at an equilibrium.")
            .code(DERIVE, "pub fn jacobian")
            .agrees(linearisation),
        displayed(5, "deviations", "δx and δu are counted from the point.")
            .code(DERIVE, "pub fn jacobian")
            .agrees(linearisation),
        displayed(6, "velocities of the state", "ẍ = A ẋ + B u̇: differentiated once, without approximation.")
            .code(LPV, "pub fn velocity_form")
            .agrees(differentiated),
        displayed(7, "velocities of the output", "ẏ = C ẋ + D u̇.").code(LPV, "pub fn velocity_form").agrees(
            |_, found| {
                let form = velocities(SLOPE_PER_K)?;
                found.equal("ẏ by ẋ", "1", 1.0, form.c[(0, 0)]);
                found.nothing("ẏ by Ṗ", "1", 0.0, form.d[(0, 0)]);
                Ok(())
            },
        ),
        displayed(8, "their matrices", "The gradients of F and G wherever the state is.")
            .code(DERIVE, "pub fn jacobian")
            .agrees(linearisation),
        equation(60, "the motion, differentiated", "x⃛ has K_SMA L ε_L ξ̇/M in it.")
            .code(LPV, "pub fn velocity_form")
            .agrees(third_derivative),
        equation(61, "the same by temperature", "x⃛ has K_SMA L ε_L (∂ξ/∂T) Ṫ/M in it.")
            .code(LPV, "pub fn velocity_form")
            .agrees(differentiated),
        equation(62, "the heat balance, differentiated", "T̈ = (Ṗ − h A_s Ṫ)/Q.")
            .code(LPV, "no form knows the term −(Q̇/Q)Ṫ")
            .differs(
                "Q changes with the slope, and its change adds −(Q̇/Q) Ṫ, which is \
                    larger than what eq. 62 has",
                |_, found| {
                    let [second, printed, whole] = second_rate()?;
                    found.near(
                        "T̈ a third of the way through, simulated",
                        "K/s²",
                        printed,
                        0.05 * printed.abs(),
                        second,
                    );
                    found.proof();
                    found.near("the same with −(Q̇/Q) Ṫ", "K/s²", whole, 0.05 * whole.abs(), second);
                    Ok(())
                },
            ),
        equation(63, "the state space in velocities", "States ẋ, ẍ, Ṫ; controllable and observable.")
            .code(LPV, "pub fn velocity_form")
            .agrees(|lab, found| {
                differentiated(lab, found)?;
                let form = velocities(SLOPE_PER_K)?;
                found.equal("rank of controllability", "1", 3.0, controllability_rank(&form.a, &form.b)? as f64);
                found.equal("rank of observability", "1", 3.0, observability_rank(&form.a, &form.c)? as f64);
                Ok(())
            }),
        displayed(9, "the error as a state", "z is the error above the velocities.")
            .code("control/state-space/src/servo.rs", "pub fn augment")
            .agrees(augmented),
        equation(64, "the servo's system", "The error's rate is −ẋ; below it stands eq. 63.")
            .code("control/state-space/src/servo.rs", "pub fn augment")
            .agrees(augmented),
        figure(
            103,
            "symmetric root locus",
            "At Q = diag(25·10⁴, 0, 0, 0), R = 1 one pair stays near the load's \
                poles, the others are near the heat transfer's; the loop is \
                underdamped.",
        )
        .code("control/state-space/src/riccati.rs", "pub fn lqr")
        .agrees(|_, found| {
            let (_, closed) = servo(SLOPE_PER_K)?;
            let poles = poles(&closed)?;
            let plant = self::poles(&velocities(SLOPE_PER_K)?.a)?;
            found.near("pair over the load's own", "1", 1.0, 0.05, poles[3].norm() / plant[2].norm());
            found.below("largest real part", "1/s", 0.0, largest(&poles.iter().map(|p| p.re).collect::<Vec<_>>()));
            found.above("the slow pair is underdamped: imaginary part", "1/s", 0.1, poles[0].im.abs());
            let (mut x, mut y) = (Vec::new(), Vec::new());
            for i in -20..60 {
                let plant = velocities(SLOPE_PER_K)?;
                let (a, b) = augment(&plant.a, &plant.b, &plant.c)?;
                let mut q = DMatrix::zeros(4, 4);
                q[(0, 0)] = 25e4 * 1.3f64.powi(i);
                let k = lqr(&a, &b, &q, &DMatrix::identity(1, 1))?;
                for pole in self::poles(&(a - b * k))? {
                    x.extend([pole.re, f64::NAN]);
                    y.extend([pole.im, f64::NAN]);
                }
            }
            found.line(("Real part, 1/s", "1"), ("Imaginary part, 1/s", "1"), Ink::Series(0), (x, y));
            Ok(())
        }),
        equation(
            65,
            "the servo, integrated",
            "The law needs ∫e and the state: nothing is differentiated, and no \
                error stays.",
        )
        .code(SERVO, "is eq. 65 where K is constant")
        .code(SERVO, "pub struct VelocityServo")
        .agrees(|_, found| {
            let (error, _) = held("velocity_servo")?;
            found.nothing("mean error after twelve seconds, of the stroke", "%", 1.0, error);
            let first = 100.0 * Run::new("thesis_3w", Chosen::law("velocity_servo"))?.step(0.4).mean;
            found.below("the same over that after three", "1", 0.25, (error / first).abs());
            Ok(())
        }),
        figure(
            104,
            "gains over the slope",
            "Within the transformation, ∂ξ/∂T < −0.05/K, all gains are nearly \
                constant but that on Ṫ, which goes with ∂ξ/∂T.",
        )
        .code(SERVO, "fn gains(")
        .agrees(gains),
        figure(105, "the servo with scheduled gains", "Mediocre until the transformation begins, then quickly there.")
            .code("control/src/laws/mod.rs", "velocity_servo_scheduled")
            .agrees(|_, found| {
                let (error, trace) = held("velocity_servo_scheduled")?;
                found.nothing("mean error after twelve seconds, of the stroke", "%", 2.0, error);
                draw_steps(found, trace);
                Ok(())
            }),
        figure(106, "the servo with constant gains", "It overshoots by 26 % of the step, and leaves no error.")
            .code(SERVO, "The static servo is the thesis'")
            .agrees(|_, found| {
                let mut run = Run::new("thesis_3w", Chosen::law("velocity_servo"))?;
                let steps = [0.4, 0.8, 0.4, 0.15].map(|to| run.step(to));
                let overshoot = steps.map(|step| 100.0 * step.overshoot / (step.to - step.from).abs());
                found.between("largest overshoot, of its step", "%", 15.0, 40.0, largest(&overshoot));
                draw_steps(found, run.trace);
                Ok(())
            }),
        equation(66, "the length by power", "X/P = 1/(Q s + h A_s) · (∂ξ/∂T) K_SMA L ε_L/(M s² + B s + K + K_SMA).")
            .code(LPV, "pub fn velocity_form")
            .agrees(|_, found| {
                let (model, _, stiffness) = rig()?;
                let form = velocities(SLOPE_PER_K)?;
                let inverse = form.a.clone().try_inverse().ok_or("no inverse")?;
                let still = -(&form.c * inverse * &form.b)[(0, 0)];
                let stated =
                    SLOPE_PER_K * stiffness * 0.233 * 0.04 / ((18.0 + stiffness) * model.constant_loss_w_per_k());
                found.near("length by power, at rest", "m/W", stated, 1e-9 * stated.abs(), still);
                let poles = poles(&form.a)?;
                found.equal("thermal pole", "1/s", -model.constant_loss_w_per_k() * form.b[2], poles[0].re);
                found.near(
                    "frequency of the load, squared",
                    "1/s²",
                    shares(stiffness).0,
                    1e-6 * shares(stiffness).0,
                    poles[2].norm_sqr(),
                );
                Ok(())
            }),
    ]
}

fn augmented(_: &Lab, found: &mut Found) -> Computed {
    let plant = velocities(SLOPE_PER_K)?;
    let (a, b) = augment(&plant.a, &plant.b, &plant.c)?;
    found.equal("ė by ẋ", "1", -1.0, a[(0, 1)]);
    found.nothing("ė by the rest", "1", 0.0, a[(0, 0)].abs() + a[(0, 2)].abs() + a[(0, 3)].abs());
    found.nothing("below it, eq. 63", "1", 0.0, (a.view((1, 1), (3, 3)) - &plant.a).norm());
    found.equal("Ṫ̇ by Ṗ", "K/J", plant.b[2], b[3]);
    found.equal("rank of controllability", "1", 4.0, controllability_rank(&a, &b)? as f64);
    Ok(())
}

fn gains(_: &Lab, found: &mut Found) -> Computed {
    let slopes: Vec<f64> = (2..=31).map(|i| -0.0025 * f64::from(i)).collect();
    let gains = slopes.iter().map(|slope| Ok(servo(*slope)?.0)).collect::<Tried<Vec<_>>>()?;
    let of = |i: usize| -> Vec<f64> { gains.iter().map(|k| k[i]).collect() };
    let within = |i: usize| -> f64 {
        let active: Vec<f64> =
            slopes.iter().zip(of(i)).filter(|(slope, _)| **slope <= -0.05).map(|(_, k)| k.abs()).collect();
        largest(&active) / least(&active)
    };
    let steepest = -slopes[slopes.len() - 1] / 0.05;
    found.near("gain on Ṫ, largest over least beyond −0.05/K", "1", steepest, 0.1 * steepest, within(3));
    found.near("gain on the error, largest over least", "1", 1.0, 1e-6, within(0));
    found.between("gain on ẋ, largest over least", "1", 1.0, 1.25, within(1));
    found.between("gain on ẍ, largest over least", "1", 1.0, 1.25, within(2));
    for (i, name) in ["Gain on the error", "Gain on ẋ", "Gain on ẍ", "Gain on Ṫ"].into_iter().enumerate() {
        found.line(("∂ξ/∂T, 1/K", "1"), (name, "1"), Ink::Series(0), (slopes.clone(), of(i)));
    }
    Ok(())
}
