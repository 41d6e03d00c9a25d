//! Chapter 11: sliding mode on limited power.

use sinew_bench::Trace;
use sinew_control::{
    Algorithm, AlgorithmKind, Controller, Coupling, Demand, EstimatorKind, LpvModel, Observation, Settings,
    StateEstimator,
};
use sinew_physics::Geometry;
use sinew_physics::formulas::{
    current_a, heating_power_w, resistance_ohm, sliding_surface, sliding_surface_first_order,
};
use sinew_plot::Ink;
use sinew_state_space::convert::discretise;
use sinew_state_space::{Complex, DMatrix, eigenvalues};

use super::nine::{SLOPE_PER_K, middle, rig, simplified};
use crate::axes::TIME;
use crate::chapter::Chapter::Eleven;
use crate::chapter::Place::{Displayed, Equation, Figure};
use crate::found::{Found, Tried};
use crate::lab::{Chosen, Lab, Run};
use crate::row::{Computed, Row};
use crate::wires::{hanging, largest, table_10};

const SURFACES: &str = "model/physics/src/formulas/control.rs";
const SLIDING: &str = "control/src/laws/sliding.rs";
const LPV: &str = "control/src/lpv.rs";

fn equation(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Eleven, Equation(number), title, states)
}

fn displayed(nth: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Eleven, Displayed(nth), title, states)
}

fn figure(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Eleven, Figure(number), title, states)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = review();
    rows.extend(wire());
    rows.extend(figures());
    rows
}

/// The chapter's example: ω = 1, ζ = 0.7, unstable; its surface has λ = 2.
const ZETA: f64 = 0.7;
const LAMBDA: f64 = 2.0;
const DEMO_STEP_S: f64 = 1e-4;

fn example() -> (DMatrix<f64>, DMatrix<f64>) {
    (DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -1.0, 2.0 * ZETA]), DMatrix::from_row_slice(2, 1, &[0.0, 1.0]))
}

/// The example over time under a switch of `most`.
#[derive(Default)]
struct Example {
    time_s: Vec<f64>,
    x: Vec<f64>,
    velocity: Vec<f64>,
    surface: Vec<f64>,
    switched: Vec<f64>,
    /// The switched effort through a low pass of 50 ms.
    low: Vec<f64>,
    /// What keeps it on the surface.
    equivalent: Vec<f64>,
    /// When the surface is first reached, s.
    reached_s: Option<f64>,
}

fn slide(start: f64, most: f64, seconds: f64) -> Tried<Example> {
    let (a, b) = example();
    let (ad, bd) = discretise(&a, &b, DEMO_STEP_S)?;
    let mut z = DMatrix::from_row_slice(2, 1, &[start, 0.0]);
    let mut seen = Example::default();
    let mut low = 0.0;
    let first = sliding_surface_first_order(start, 0.0, LAMBDA);
    for k in 0..(seconds / DEMO_STEP_S).round() as u32 {
        let surface = sliding_surface_first_order(z[0], z[1], LAMBDA);
        let u = if surface == 0.0 { 0.0 } else { -most * surface.signum() };
        low += DEMO_STEP_S / 0.05 * (u - low);
        let time_s = f64::from(k) * DEMO_STEP_S;
        if seen.reached_s.is_none() && surface * first <= 0.0 && first != 0.0 {
            seen.reached_s = Some(time_s);
        }
        seen.time_s.push(time_s);
        seen.x.push(z[0]);
        seen.velocity.push(z[1]);
        seen.surface.push(surface);
        seen.switched.push(u);
        seen.low.push(low);
        // 0 = ẍ + λẋ with ẍ of the example
        seen.equivalent.push(z[0] - 2.0 * ZETA * z[1] - LAMBDA * z[1]);
        z = &ad * z + &bd * u;
    }
    Ok(seen)
}

/// On the surface, the low part of the switched effort is the equivalent one, and the state decays by λ.
fn on_the_surface(_: &Lab, found: &mut Found) -> Computed {
    let seen = slide(1.0, 8.0, 2.5)?;
    let at = |time_s: f64| (time_s / DEMO_STEP_S).round() as usize;
    found.near("ẋ over x on the surface", "1/s", -LAMBDA, 0.02, seen.velocity[at(1.0)] / seen.x[at(1.0)]);
    found.near("x after a second there over x before", "1", (-LAMBDA).exp(), 0.01, seen.x[at(1.5)] / seen.x[at(0.5)]);
    let apart = (seen.low[at(1.0)] - seen.equivalent[at(1.0)]).abs();
    found.below("low part of the switched effort less the equivalent one", "1", 0.2, apart);
    Ok(())
}

/// On the way to the surface σ σ̇ < 0.
fn reaching(_: &Lab, found: &mut Found) -> Computed {
    let seen = slide(1.0, 8.0, 1.0)?;
    let reached = seen.reached_s.ok_or("the surface is not reached")?;
    let way = (reached / DEMO_STEP_S) as usize;
    let rates = seen.surface.windows(2).take(way).map(|pair| pair[0] * (pair[1] - pair[0]) / DEMO_STEP_S);
    found.below("largest σ σ̇ on the way to the surface", "1", 0.0, rates.fold(f64::NEG_INFINITY, f64::max));
    let after = &seen.surface[way + 10..];
    found.below("largest |σ| from then on", "1", 0.01, largest(&after.iter().map(|s| s.abs()).collect::<Vec<_>>()));
    Ok(())
}

fn review() -> Vec<Row> {
    vec![
        displayed(1, "a surface of order n − 1", "σ = (s + λ)^(n−1): for a third-order plant ë + 2λė + λ²e.")
            .code(SURFACES, "pub fn sliding_surface")
            .agrees(|_, found| {
                // (s + λ)² by its action on e^rt, at r = −3 and λ = 10
                let (r, lambda) = (-3.0f64, 10.0f64);
                found.equal("(s + λ)² on e^−3t", "1/s²", (r + lambda).powi(2), sliding_surface(1.0, r, r * r, lambda));
                found.nothing("and on e^−λt", "1/s²", 1e-9, sliding_surface(1.0, -lambda, lambda * lambda, lambda));
                Ok(())
            }),
        displayed(2, "the switch", "One end of the effort on either side of the surface.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(reaching),
        displayed(3, "the switch by sign", "u = −U sign(σ).")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(reaching),
        displayed(4, "the example", "ẍ − 2ζω ẋ + ω² x = u with ω = 1 and ζ = 70 %: unstable.")
            .code("control/state-space/src/spectrum.rs", "pub fn eigenvalues")
            .agrees(|_, found| {
                for pole in eigenvalues(&example().0)? {
                    found.near("real part of a pole", "1/s", 0.7, 1e-9, pole.re);
                    found.near("its distance from the origin", "1/s", 1.0, 1e-9, pole.norm());
                }
                Ok(())
            }),
        displayed(5, "its surface", "σ = ẋ + λx.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(on_the_surface),
        displayed(6, "its motion on the surface", "ẋ = −λx.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(on_the_surface),
        displayed(7, "plants with an input", "ẋ = f(x) + g(x) u + η.")
            .code("control/state-space/src/convert.rs", "pub fn discretise")
            .agrees(reaching),
        displayed(8, "the equivalent effort", "What makes σ̇ vanish.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(on_the_surface),
        equation(67, "reachability", "σ σ̇ < 0.")
            .code("control/src/reach.rs", "The surface is reachable (eq. 67)")
            .agrees(reaching),
        displayed(9, "low and high part", "Of the switched effort the low part alone moves the plant.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(on_the_surface),
        displayed(10, "reachability of a switch", "U has to exceed the equivalent effort and what is unknown.")
            .code("control/src/reach.rs", "The surface is reachable (eq. 67)")
            .agrees(|_, found| {
                // from x = 1 at rest the equivalent effort is 1, and largest while it is reached
                let (strong, weak) = (slide(1.0, 8.0, 3.0)?, slide(1.0, 0.9, 3.0)?);
                found.below("|x| at the end, U = 8", "1", 0.1, strong.x.last().copied().unwrap_or(f64::NAN).abs());
                found.above(
                    "|x| at the end, U = 0.9, less than the equivalent effort",
                    "1",
                    1.0,
                    weak.x.last().copied().unwrap_or(f64::NAN).abs(),
                );
                Ok(())
            }),
        displayed(11, "the example on its surface", "0 = λẋ − (k/m) x − (b/m) ẋ + u_eq.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(on_the_surface),
        displayed(12, "the example's equivalent effort", "u_eq = (b/m − λ) ẋ + (k/m) x.")
            .code(SURFACES, "pub fn sliding_surface_first_order")
            .agrees(|_, found| {
                // b/m = −2ζω, k/m = ω²
                let seen = slide(1.0, 8.0, 2.0)?;
                let i = 10_000;
                let stated = (-2.0 * ZETA - LAMBDA) * seen.velocity[i] + seen.x[i];
                found.near("low part of the switched effort, on the surface", "1", stated, 0.2, seen.low[i]);
                Ok(())
            }),
    ]
}

/// (K + K_SMA)/M, B/M, and what Ṫ pushes with: K_SMA L ε_L (∂ξ/∂T)/M.
fn terms() -> Tried<(f64, f64, f64)> {
    let (_, _, stiffness) = rig()?;
    Ok(((18.0 + stiffness) / 0.13, 0.915 / 0.13, stiffness * 0.233 * 0.04 * SLOPE_PER_K / 0.13))
}

/// Eq. 68 is a row of the velocity form.
fn motion(_: &Lab, found: &mut Found) -> Computed {
    let model = simplified(table_10());
    let form = LpvModel::new(&model, Coupling::Thermal)?.velocity_form(&middle(&model), SLOPE_PER_K);
    let (total, damping, push) = terms()?;
    found.equal("x⃛ by ẋ", "1/s²", -total, form.a[(1, 0)]);
    found.equal("x⃛ by ẍ", "1/s", -damping, form.a[(1, 1)]);
    found.equal("x⃛ by Ṫ", "m/(s² K)", push, form.a[(1, 2)]);
    Ok(())
}

/// Eq. 70 as printed, fed to chapter 9's model: on the surface, the motion has twice the pole −λ and nothing else.
fn equivalent_power(_: &Lab, found: &mut Found) -> Computed {
    let (model, form, _) = rig()?;
    let (total, damping, push) = terms()?;
    let lambda = 10.0;
    let q = 1.0 / form.b[3];
    // P = ((B/M − 2λ) ẍ + ((K + K_SMA)/M − λ²) ẋ)/(push/Q) + h A_s (T − T_∞), ẍ by the states
    let acceleration = form.a.row(1).clone_owned();
    let mut law = acceleration * ((damping - 2.0 * lambda) * q / push);
    law[1] += (total - lambda * lambda) * q / push;
    law[3] += model.constant_loss_w_per_k();
    let mut poles: Vec<Complex<f64>> = eigenvalues(&(&form.a + &form.b * law))?;
    poles.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    // x itself and the phase beside the temperature are not moved by it
    found.nothing("what the law leaves alone", "1/s", 0.01, poles[1].norm());
    for pole in &poles[2..] {
        found.near("pole of the motion", "1/s", lambda, 0.01, -pole.re);
    }
    Ok(())
}

/// What the plain switch does with a wire that is longer, and one that is shorter than commanded.
fn switched(_: &Lab, found: &mut Found) -> Computed {
    let model = hanging();
    let settings = Settings { kind: AlgorithmKind::SlidingModePlain, lambda_per_s: Some(10.0), ..Settings::default() };
    let mut estimator = StateEstimator::new(&model, EstimatorKind::Fused);
    let length_m = 0.166;
    let mut estimate = estimator.update(&Observation { length_m, ..Observation::nothing(0.1, 1e-3) });
    for _ in 0..200 {
        estimate = estimator.update(&Observation { length_m, ..Observation::nothing(0.1, 1e-3) });
    }
    for (what, reference_m, stated) in [("3 mm too long", 0.163, 1.0), ("1 mm too short", 0.167, 0.02)] {
        let mut law = Algorithm::new(&model, &settings);
        let demand = Demand {
            reference_m,
            length_m,
            velocity_m_s: 0.0,
            acceleration_m_s2: 0.0,
            resistance_ohm: f64::NAN,
            dt_s: 1e-3,
            estimate,
        };
        found.equal(&format!("duty of a wire {what} (0.02 is the sensing pulse)"), "1", stated, law.duty(&demand));
    }
    Ok(())
}

fn wire() -> Vec<Row> {
    let model = |nth, title, states| displayed(nth, title, states).code(LPV, "pub fn martensite_form");
    vec![
        model(13, "the wire's temperature", "Ṫ = P/Q − (h A_s/Q)(T − T_∞).").agrees(|_, found| {
            let (model, form, _) = rig()?;
            found.equal("Ṫ by T over Ṫ by P", "W/K", -model.constant_loss_w_per_k(), form.a[(3, 3)] / form.b[3]);
            Ok(())
        }),
        model(14, "its thermal mass", "Q = m c_p − m ΔH ∂ξ/∂T, as in eq. 50.").differs(
            "as in eq. 50: the work of transformation is missing, at the rig's \
                153 MPa a twenty-fifth of the latent heat",
            |_, found| {
                let (model, form, _) = rig()?;
                let stated = model.heat_capacity_j_per_k() - model.latent_heat_j() * SLOPE_PER_K;
                let q = 1.0 / form.b[3];
                found.near("Q at −0.05/K", "J/K", stated, 1e-6 * stated, q);
                found.proof();
                let work = model.geometry.volume_m3() * middle(&model).stress_pa * 0.04 * -SLOPE_PER_K;
                found.near("Q less the work of a kelvin", "J/K", stated, 1e-9 * stated, q - work);
                Ok(())
            },
        ),
        model(15, "its motion", "M ẍ + B ẋ + (K + K_SMA) x = K_SMA L ε_L ξ.").agrees(motion),
        model(16, "its phase", "ξ is a function of T.").agrees(|_, found| {
            let (_, form, _) = rig()?;
            found.equal("ξ̇ over Ṫ", "1/K", SLOPE_PER_K, form.b[2] / form.b[3]);
            Ok(())
        }),
        equation(68, "the motion by temperature", "Differentiated, Ṫ drives the motion by K_SMA L ε_L ∂ξ/∂T.")
            .code(LPV, "pub fn velocity_form")
            .agrees(motion),
        equation(69, "the motion by power", "The same with Ṫ by P − h A_s (T − T_∞).")
            .code(LPV, "pub fn martensite_form")
            .agrees(|_, found| {
                let (_, form, _) = rig()?;
                let jerk = (&form.c * &form.a * &form.a * &form.b)[(0, 0)];
                found.equal("x⃛ by P, times Q", "m/(s² K)", terms()?.2, jerk / form.b[3]);
                Ok(())
            }),
        displayed(17, "the wire's surface", "σ = ẍ + 2λẋ + λ²x, critically damped; the text has λ = −10.")
            .code(SURFACES, "pub fn sliding_surface")
            .differs(
                "−10 is where its poles are; in the surface as printed λ has to be + \
                    10, or the wire would run away on it",
                |_, found| {
                    let root = |lambda: f64| -> Tried<f64> {
                        // the companion of the surface, from its own coefficients
                        let (c0, c1) = (sliding_surface(1.0, 0.0, 0.0, lambda), sliding_surface(0.0, 1.0, 0.0, lambda));
                        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -c0, -c1]);
                        Ok(largest(&eigenvalues(&a)?.iter().map(|pole| pole.re).collect::<Vec<_>>()))
                    };
                    found.near("pole of the surface with λ = −10", "1/s", -10.0, 0.01, root(-10.0)?);
                    found.proof();
                    found.near("pole of the surface with λ = 10", "1/s", -10.0, 0.01, root(10.0)?);
                    Ok(())
                },
            ),
        displayed(18, "staying on it", "σ̇ = 0 is x⃛ + 2λẍ + λ²ẋ = 0.")
            .code(SLIDING, "With the equivalent control that keeps σ = 0 (eq. 70)")
            .agrees(equivalent_power),
        displayed(
            19,
            "the temperature's rate on it",
            "(K_SMA L ε_L/M)(∂ξ/∂T) Ṫ = (B/M − 2λ) ẍ + ((K + K_SMA)/M − λ²) ẋ.",
        )
        .code(SLIDING, "(eq. 70)")
        .agrees(equivalent_power),
        displayed(20, "the power on it, implicit", "The same with Ṫ by P_eq.")
            .code(SLIDING, "(eq. 70)")
            .agrees(equivalent_power),
        equation(70, "the equivalent power", "P_eq is that over (K_SMA L ε_L/(M Q)) ∂ξ/∂T, and the heat loss.")
            .code(SLIDING, "With the equivalent control that keeps σ = 0 (eq. 70)")
            .agrees(equivalent_power),
        displayed(21, "the wire's switch", "Full power on one side of the surface, none on the other.")
            .code("control/src/laws/mod.rs", "\"sliding_mode_plain\"")
            .agrees(switched),
    ]
}

fn draw_example(found: &mut Found, seen: &Example) {
    found.legend(Ink::Series(0), "position, velocity over position");
    found.legend(Ink::Measured, "switched effort");
    found.legend(Ink::Series(1), "its low part");
    found.legend(Ink::Series(2), "equivalent effort");
    found.line(TIME, ("Position", "1"), Ink::Series(0), (seen.time_s.clone(), seen.x.clone()));
    let effort = ("Effort", "1");
    found.line(TIME, effort, Ink::Measured, (seen.time_s.clone(), seen.switched.clone()));
    found.line(TIME, effort, Ink::Series(1), (seen.time_s.clone(), seen.low.clone()));
    found.line(TIME, effort, Ink::Series(2), (seen.time_s.clone(), seen.equivalent.clone()));
    found.line(
        ("Position, in the phase plane", "1"),
        ("Velocity", "1"),
        Ink::Series(0),
        (seen.x.clone(), seen.velocity.clone()),
    );
}

fn draw_steps(found: &mut Found, trace: Trace) {
    found.legend(Ink::Measured, "reference");
    found.legend(Ink::Series(0), "wire");
    let stroke = ("Stroke, 0 cold", "1");
    found.line(TIME, stroke, Ink::Measured, (trace.time_s.clone(), trace.reference));
    found.line(TIME, stroke, Ink::Series(0), (trace.time_s.clone(), trace.stroke));
    found.line(TIME, ("Duty", "1"), Ink::Series(0), (trace.time_s, trace.duty));
}

fn figures() -> Vec<Row> {
    vec![
        figure(
            107,
            "the example under a switch of 8",
            "From x = 0 and ẋ = 0 the surface is reached in about 0.2 s and the \
                origin in about 2 s.",
        )
        .code(SURFACES, "pub fn sliding_surface_first_order")
        .differs(
            "from (0, 0) there is nothing to reach; from x = 1 at rest both times \
                come out",
            |_, found| {
                let printed = slide(0.0, 8.0, 3.0)?;
                found.above("farthest from the origin, from the printed start", "1", 0.1, largest(&printed.x));
                found.proof();
                let seen = slide(1.0, 8.0, 3.0)?;
                found.between("surface reached after, from x = 1", "s", 0.15, 0.3, seen.reached_s.unwrap_or(f64::NAN));
                found.below("|x| after 2 s", "1", 0.05, seen.x[20_000].abs());
                draw_example(found, &seen);
                Ok(())
            },
        ),
        figure(
            108,
            "the example under a switch of 2.8",
            "Barely enough: there is a long delay before the surface is reached.",
        )
        .code(SURFACES, "pub fn sliding_surface_first_order")
        .agrees(|_, found| {
            // the least effort that brings x = 1 back, by bisection
            let (mut little, mut enough) = (0.5, 8.0);
            for _ in 0..12 {
                let most = 0.5 * (little + enough);
                let end = slide(1.0, most, 12.0)?.x.last().copied().unwrap_or(f64::NAN);
                if end.abs() < 0.1 { enough = most } else { little = most }
            }
            found.between("least effort that brings x = 1 back, of 2.8", "1", 0.8, 1.0, enough / 2.8);
            // since when it stays on the surface
            let kept =
                |seen: &Example| seen.surface.iter().rposition(|s| s.abs() > 0.02).map_or(0.0, |i| seen.time_s[i]);
            let [strong, weak] = [slide(1.0, 8.0, 8.0)?, slide(1.0, 2.8, 8.0)?];
            found.above("on the surface for good later than with 8, times", "1", 3.0, kept(&weak) / kept(&strong));
            found.below("|x| at the end", "1", 0.05, weak.x.last().copied().unwrap_or(f64::NAN).abs());
            draw_example(found, &weak);
            Ok(())
        }),
        figure(
            109,
            "a wire to the middle of its stroke",
            "On 3 W the surface is reached, and the power is nearly the \
                equivalent one.",
        )
        .code(SLIDING, "pub struct SlidingMode")
        .agrees(|_, found| {
            let mut run = Run::new("thesis_3w", Chosen::law("sliding_mode"))?;
            let step = run.step(0.5);
            found.between("settled within 2 %", "s", 0.3, 1.5, step.settle_2_percent_s.unwrap_or(f64::NAN));
            found.nothing("mean error at the end, of the stroke", "%", 0.5, 100.0 * step.mean);
            draw_steps(found, run.trace);
            Ok(())
        }),
        figure(110, "two positions on 3 W", "Settled near 1 s, heating and cooling, without overshoot.")
            .code(SLIDING, "pub struct SlidingMode")
            .agrees(|_, found| {
                let mut run = Run::new("thesis_3w", Chosen::law("sliding_mode"))?;
                let [up, down] = [0.7, 0.35].map(|to| run.step(to));
                for (what, step) in [("heating", up), ("cooling", down)] {
                    found.between(
                        &format!("settled within 2 %, {what}"),
                        "s",
                        0.5,
                        1.5,
                        step.settle_2_percent_s.unwrap_or(f64::NAN),
                    );
                    found.below(&format!("overshoot, {what}, of the stroke"), "%", 0.5, 100.0 * step.overshoot);
                }
                draw_steps(found, run.trace);
                Ok(())
            }),
        figure(111, "the same on 1 W", "The surface is reached late, after a second.")
            .code(SLIDING, "pub struct SlidingMode")
            .agrees(|_, found| {
                let (mut strong, mut weak) = (
                    Run::new("thesis_3w", Chosen::law("sliding_mode"))?,
                    Run::new("thesis_1w", Chosen::law("sliding_mode"))?,
                );
                let (strong, first) = (strong.step(0.7), weak.step(0.7));
                let late = |step: &sinew_bench::Step| step.surface_s.unwrap_or(f64::NAN);
                found.above("surface reached later than on 3 W, times", "1", 2.0, late(&first) / late(&strong));
                weak.step(0.35);
                draw_steps(found, weak.trace);
                Ok(())
            }),
        figure(
            112,
            "the rig under a second-order surface",
            "On 6 V, near 1 W at most, at 200 Hz: no overshoot and hardly an \
                error. The measured curve is a picture without numbers.",
        )
        .code("tools/bench/src/plant.rs", "\"thesis_noisy\"")
        .differs(
            "6 V over the rig's wire are 1.4 to 1.6 W by its resistance, not 1 W; \
                the motion is as said",
            |_, found| {
                let g = Geometry { diameter_m: 0.1e-3, length_m: 0.233 };
                let power = |resistivity: f64| {
                    let ohm = resistance_ohm(resistivity, g.length_m, g.area_m2());
                    heating_power_w(1.0, current_a(6.0, ohm, 0.0), ohm)
                };
                found.near("peak power at 6 V, 80 µΩ cm", "W", 1.0, 0.2, power(80e-8));
                found.proof();
                found.between("the same as austenite", "W", 1.35, 1.65, power(86.5e-8));
                found.between("the same as martensite", "W", 1.35, 1.65, power(75e-8));
                let mut run = Run::new("thesis_noisy", Chosen::law("sliding_mode"))?;
                let step = run.step(0.5);
                found.below("overshoot at 200 Hz with noise, of the stroke", "%", 1.0, 100.0 * step.overshoot);
                found.nothing("mean error at the end, of the stroke", "%", 1.0, 100.0 * step.mean);
                draw_steps(found, run.trace);
                Ok(())
            },
        ),
        figure(113, "a first-order surface", "It ends in oscillation about the reference.")
            .code("control/src/laws/mod.rs", "\"sliding_mode_first_order\"")
            .agrees(|_, found| {
                let left = |law: &'static str| -> Tried<(f64, Trace)> {
                    let mut run = Run::new("thesis_3w", Chosen::law(law))?;
                    Ok((100.0 * run.step(0.5).cycle, run.trace))
                };
                let (first, trace) = left("sliding_mode_first_order")?;
                found.above("motion left, of the stroke", "± %", 0.5, first);
                found.above("over that of the second order", "1", 3.0, first / left("sliding_mode")?.0);
                draw_steps(found, trace);
                Ok(())
            }),
    ]
}
