//! Chapter 9: the linear model with varying parameters, and its estimators.

use sinew_bench::{Choice, Plant, Trace};
use sinew_control::{Coupling, LpvModel, OperatingPoint, StateSpace};
use sinew_physics::{Hysteresis, Inputs, Load, Material, Wire, WireModel};
use sinew_plot::Ink;
use sinew_state_space::place::place_observer;
use sinew_state_space::rank::{controllability_rank, observability_rank};
use sinew_state_space::{Complex, DMatrix, convert, eigenvalues};

use crate::axes::TIME;
use crate::chapter::Chapter::Nine;
use crate::chapter::Place::{Displayed, Equation, Figure, Table};
use crate::found::{Found, Tried};
use crate::lab::{Chosen, Lab, Run};
use crate::row::{Computed, Row};
use crate::wires::{MPA, STEP_S, hanging, in_a_furnace, largest, table_10};

const LPV: &str = "control/src/lpv.rs";
const BALANCE: &str = "model/physics/src/step/balance.rs";
const MECHANICAL: &str = "model/physics/src/formulas/mechanical.rs";
const OBSERVER: &str = "control/src/estimators/luenberger.rs";
const KINETICS: &str = "model/physics/src/kinetics.rs";

fn equation(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Nine, Equation(number), title, states)
}

fn displayed(nth: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Nine, Displayed(nth), title, states)
}

fn figure(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Nine, Figure(number), title, states)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = review();
    rows.extend(linear());
    rows.extend(estimators());
    rows
}

/// As the chapter simplifies it: one modulus, no thermal strain.
pub(crate) fn simplified(model: WireModel) -> WireModel {
    let material = Material { martensite_modulus_pa: 75e9, thermoelastic_pa_per_k: 0.0, ..model.material };
    WireModel { material, ..model }
}

/// Half transformed, heating, at the stress of the preload; with a slope of −0.05/K.
pub(crate) const SLOPE_PER_K: f64 = -0.05;
pub(crate) fn middle(model: &WireModel) -> OperatingPoint {
    let stress_pa = model.load.pull_at_rest_n(0.0).unwrap_or(0.0) / model.geometry.area_m2();
    let temperature_c = model.material.austenite_at_c(stress_pa);
    OperatingPoint { temperature_c, martensite: 0.5, stress_pa, heating: true }
}

/// Table 10's rig as the chapter has it, its linear model with ξ as a state, and its K_SMA in N/m.
pub(crate) fn rig() -> Tried<(WireModel, StateSpace, f64)> {
    let model = simplified(table_10());
    let form = LpvModel::new(&model, Coupling::Thermal)?.martensite_form(&middle(&model), SLOPE_PER_K);
    let stiffness = model.geometry.stiffness_n_per_m(75e9);
    Ok((model, form, stiffness))
}

/// A held wire that cools from austenite: how its stress changes over how its phase does, MPa.
fn held_stress_per_martensite() -> Tried<f64> {
    let model = WireModel { load: Load::ImposedPosition, ..simplified(in_a_furnace(Material::default(), 0.0)) };
    let imposed = 600.0 * MPA / 75e9 * model.geometry.length_m;
    let inputs = |drive: f64| Inputs { drive, imposed, ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(&model, &inputs(180.0))?;
    let before = (wire.stress_pa(), wire.martensite());
    for k in 1..=500 {
        wire.step(&inputs(180.0 - 0.1 * f64::from(k)), STEP_S);
    }
    Ok((wire.stress_pa() - before.0) / MPA / (wire.martensite() - before.1))
}

fn review() -> Vec<Row> {
    vec![
        displayed(
            1,
            "the strain, once more",
            "ε = σ/E + ε_L ξ + Θ T, with one modulus and the thermal part mostly \
                left out.",
        )
        .code(BALANCE, "Strain of the phase `fraction` (eq. 23)")
        .agrees(|_, found| {
            let model = simplified(in_a_furnace(Material { stress_shift_k_per_pa: 0.0, ..Material::default() }, 0.5));
            let way = crate::wires::imposed(&model, &[[80.0, 0.0], [80.0, 200.0]], 10)?;
            found.near("strain at ξ = ½ and 200 MPa", "1", 200e6 / 75e9 + 0.02, 1e-9, way.strain[10]);
            Ok(())
        }),
        equation(
            45,
            "stress by strain and phase",
            "σ̇ = E ε̇ + E ε_L ξ̇: martensite that forms in a held wire would \
                raise its stress by 3000 MPa.",
        )
        .code(LPV, "pub fn stress_form")
        .differs(
            "the sign of the second term is that of Ω in eq. 2, −E ε_L: a held \
                wire slackens as it becomes martensite",
            |_, found| {
                let found_mpa = held_stress_per_martensite()?;
                found.near("stress per martensite of a held wire", "MPa", 75e3 * 0.04, 30.0, found_mpa);
                found.proof();
                found.near("the same, with the sign of eq. 2", "MPa", -75e3 * 0.04, 30.0, found_mpa);
                Ok(())
            },
        ),
        equation(46, "the phase, once more", "The cooling curve is printed as (1 − ξ_A)/(1 + e^−k(T − M)) + ξ_A.")
            .code(KINETICS, "pub struct Hysteresis")
            .differs(
                "with this sign martensite would grow with temperature; eq. 24 has \
                    e^+k(T − M), which the code takes",
                |_, found| {
                    let code = Hysteresis::new(&Material::default()).lower(72.0).martensite;
                    found.near(
                        "ξ 5 K above M, cooling from austenite",
                        "1",
                        1.0 / (1.0 + (-0.31f64 * 5.0).exp()),
                        1e-6,
                        code,
                    );
                    found.proof();
                    found.near("the same by eq. 24", "1", 1.0 / (1.0 + (0.31f64 * 5.0).exp()), 1e-12, code);
                    Ok(())
                },
            ),
        equation(47, "rate of the phase", "ξ̇ = ∂ξ/∂T Ṫ + ∂ξ/∂σ σ̇, with ∂ξ/∂σ = −(1/α) ∂ξ/∂T.")
            .code(LPV, "ξ̇ = ξ' (Ṫ − σ̇/α)")
            .agrees(|_, found| {
                let (total, by_temperature, by_stress) = phase_rates(&hanging(), 1.0)?;
                let apart: Vec<f64> = total
                    .iter()
                    .zip(by_temperature.iter().zip(&by_stress))
                    .map(|(all, (t, s))| (all - t - s).abs())
                    .collect();
                let most = largest(&total.iter().map(|rate| rate.abs()).collect::<Vec<_>>());
                found.below("ξ̇ less both parts, of the largest ξ̇", "%", 2.0, 100.0 * largest(&apart) / most);
                Ok(())
            }),
        equation(48, "the heat balance, once more", "m c_p Ṫ = P + m ΔH ξ̇ + A L σ ε_L ξ̇ − h A_s (T − T_∞).")
            .code(BALANCE, "heat balance (eq. 48)")
            .agrees(|_, found| {
                let model = table_10();
                let mut wire = Wire::new(&model)?;
                for k in 0..3000 {
                    wire.step(&Inputs { drive: if k < 1500 { 1.2 } else { 0.1 }, ..model.rest_inputs() }, STEP_S);
                }
                found.nothing("what does not add up", "J", 1e-9, wire.energy().residual_j());
                Ok(())
            }),
        equation(49, "the phase by temperature alone", "ξ̇ = ∂ξ/∂T Ṫ, where stress hardly moves the phase.")
            .code(LPV, "Thermal,")
            .agrees(|_, found| {
                let (_, form, _) = rig()?;
                // row of ξ over row of T, whatever drives them
                found.equal("ξ̇ over Ṫ as the power drives them", "1/K", SLOPE_PER_K, form.b[2] / form.b[3]);
                found.equal("ξ̇ over Ṫ as they cool", "1/K", SLOPE_PER_K, form.a[(2, 3)] / form.a[(3, 3)]);
                Ok(())
            }),
        equation(
            50,
            "heat by temperature alone",
            "(m c_p − m ΔH ∂ξ/∂T) Ṫ = P − h A_s (T − T_∞): Q has no work of \
                transformation.",
        )
        .code(LPV, "Q: sensible and latent heat of a kelvin")
        .differs(
            "eq. 48, from which it comes, has the work A L σ ε_L ξ̇, which at the \
                rig's 153 MPa is a twenty-fifth of the latent heat; the code's Q has \
                it",
            |_, found| {
                let (model, form, _) = rig()?;
                let q = 1.0 / form.b[3];
                let stated = model.heat_capacity_j_per_k() - model.latent_heat_j() * SLOPE_PER_K;
                found.near("Q at −0.05/K", "J/K", stated, 1e-6 * stated, q);
                found.proof();
                let work = model.geometry.volume_m3() * middle(&model).stress_pa * 0.04 * -SLOPE_PER_K;
                found.near("Q less the work of a kelvin", "J/K", stated, 1e-9 * stated, q - work);
                Ok(())
            },
        ),
        figure(
            89,
            "what moves the phase",
            "Of a wire on constant power that drives table 10's rig, temperature \
                moves the phase, hardly stress.",
        )
        .code("model/physics/src/step/wire.rs", "pub fn step")
        .agrees(|_, found| {
            let (total, by_temperature, by_stress) = phase_rates(&table_10(), 1.2)?;
            let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
            found.below("ξ̇ by stress over that by temperature, RMS", "1", 0.3, rms(&by_stress) / rms(&by_temperature));
            let time: Vec<f64> = (0..total.len()).map(|i| i as f64 * STEP_S).collect();
            let axis = ("Rate of the martensite fraction, 1/s", "1");
            for (ink, name, rate) in
                [(0, "by temperature", by_temperature), (1, "by stress", by_stress), (2, "all", total)]
            {
                found.legend(Ink::Series(ink), name);
                found.line(TIME, axis, Ink::Series(ink), (time.clone(), rate));
            }
            Ok(())
        }),
        equation(51, "the load", "M ẍ + B ẋ + K x = −F_SMA + F_preload + F_ext.")
            .code(MECHANICAL, "pub fn load_pull_n")
            .agrees(|_, found| {
                let model = table_10();
                let mut wire = Wire::new(&model)?;
                found.near(
                    "pull of the load on the wire at rest",
                    "N",
                    1.2 - 18.0 * wire.position_m(),
                    1e-9,
                    wire.tension_n(),
                );
                // released by a pull of 0.1 N from outside: the acceleration of the first 0.1 ms
                wire.step(&Inputs { external_n: 0.1, ..model.rest_inputs() }, 1e-5);
                found.near("acceleration by 0.1 N more", "m/s²", 0.1 / 0.13, 0.01, wire.velocity_m_s() / 1e-5);
                Ok(())
            }),
        displayed(2, "force and stress", "F = A σ.").code("model/physics/src/step/wire.rs", "pub fn tension_n").agrees(
            |_, found| {
                let wire = Wire::new(&table_10())?;
                found.equal(
                    "tension over stress",
                    "m²",
                    std::f64::consts::FRAC_PI_4 * 1e-8,
                    wire.tension_n() / wire.stress_pa(),
                );
                Ok(())
            },
        ),
        displayed(3, "position and strain", "x = L ε.")
            .code("model/physics/src/step/wire.rs", "pub fn position_m")
            .agrees(|_, found| {
                let model = table_10();
                let wire = Wire::new(&model)?;
                let c = 1.0 / 28e9;
                let strain = c * wire.stress_pa() + 0.04 * wire.martensite() + c * 0.55e6 * 5.0;
                found.near("elongation of the cold wire", "m", 0.233 * strain, 1e-8, wire.position_m());
                Ok(())
            }),
        displayed(4, "stiffness of the wire", "K_SMA = A E/L.").code(MECHANICAL, "pub fn stiffness_n_per_m").agrees(
            |_, found| {
                let stated = std::f64::consts::FRAC_PI_4 * 1e-8 * 75e9 / 0.233;
                found.near(
                    "table 10's wire as austenite",
                    "N/m",
                    stated,
                    1e-6,
                    table_10().geometry.stiffness_n_per_m(75e9),
                );
                Ok(())
            },
        ),
    ]
}

/// The rate of the phase along a heating by constant power, and its parts by temperature and by stress, 1/s.
fn phase_rates(model: &WireModel, power_w: f64) -> Tried<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let mut wire = Wire::new(model)?;
    let (mut total, mut by_temperature, mut by_stress) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..2500 {
        let before = (wire.temperature_c(), wire.martensite(), wire.stress_pa());
        wire.step(&Inputs { drive: power_w, ..model.rest_inputs() }, STEP_S);
        // the slope of the heating curve, which the wire is on from cold
        let xi = 0.5 * (before.1 + wire.martensite());
        let slope = -model.material.heating_steepness_per_k * xi * (1.0 - xi);
        total.push((wire.martensite() - before.1) / STEP_S);
        by_temperature.push(slope * (wire.temperature_c() - before.0) / STEP_S);
        by_stress.push(-slope * model.material.stress_shift_k_per_pa * (wire.stress_pa() - before.2) / STEP_S);
    }
    Ok((total, by_temperature, by_stress))
}

fn linear() -> Vec<Row> {
    vec![
        equation(52, "the state space with stress", "States x, ẋ, σ, T; the power enters σ by −(∂ξ/∂T)/Q and T by W.")
            .code(LPV, "pub fn stress_form")
            .differs(
                "the entry of σ has lost the factor E ε_L, as the entry of A beside \
                    it shows, and W means 1/Q",
                |_, found| {
                    let model = simplified(table_10());
                    let form = LpvModel::new(&model, Coupling::Thermal)?.stress_form(&middle(&model), SLOPE_PER_K);
                    let ratio = form.b[2] / form.b[3];
                    found.near("power into σ over power into T", "Pa/K", -SLOPE_PER_K, 1e-6, ratio);
                    found.proof();
                    found.near("the same over −E ε_L ∂ξ/∂T", "1", 1.0, 1e-9, ratio / (-75e9 * 0.04 * SLOPE_PER_K));
                    found.near("σ̇ over ẋ, times L/E", "1", 1.0, 1e-9, form.a[(2, 1)] * 0.233 / 75e9);
                    let cooling = form.a[(2, 3)] / (75e9 * 0.04 * SLOPE_PER_K * -form.a[(3, 3)]);
                    found.near("entry of A beside it, over E ε_L (∂ξ/∂T) h A_s/Q", "1", 1.0, 1e-9, cooling);
                    Ok(())
                },
            ),
        equation(
            53,
            "the state space with the phase",
            "States x, ẋ, ξ, T: the wire is a spring K_SMA that the strain L ε_L \
                ξ pushes. Observable, not controllable: rank 3 of 4.",
        )
        .code(LPV, "pub fn martensite_form")
        .agrees(|_, found| {
            let (_, form, stiffness) = rig()?;
            let (a, b) = (&form.a, &form.b);
            found.equal("ẍ by x", "1/s²", -(18.0 + stiffness) / 0.13, a[(1, 0)]);
            found.equal("ẍ by ẋ", "1/s", -0.915 / 0.13, a[(1, 1)]);
            found.equal("ẍ by ξ", "m/s²", stiffness * 0.233 * 0.04 / 0.13, a[(1, 2)]);
            found.equal("ξ̇ by T over Ṫ by T", "1/K", SLOPE_PER_K, a[(2, 3)] / a[(3, 3)]);
            found.equal("power into ξ over power into T", "1/K", SLOPE_PER_K, b[2] / b[3]);
            found.equal("rank of controllability", "1", 3.0, controllability_rank(a, b)? as f64);
            found.equal("rank of observability", "1", 4.0, observability_rank(a, &form.c)? as f64);
            Ok(())
        }),
        equation(54, "stress as an output", "The stress is −E ε + E ε_L ξ.").code(LPV, "pub fn stress_form").differs(
            "by the strain of the same chapter it is E ε − E ε_L ξ: both signs \
                are turned, as that of eq. 45 is",
            |_, found| {
                let model = simplified(table_10());
                let wire = Wire::new(&model)?;
                let strain = wire.position_m() / model.geometry.length_m;
                let stated = (-75e9 * strain + 75e9 * 0.04 * wire.martensite()) / MPA;
                found.near("stress of the wire at rest", "MPa", stated, 1.0, wire.stress_pa() / MPA);
                found.proof();
                found.near("the same with both signs turned", "MPa", -stated, 1e-3, wire.stress_pa() / MPA);
                Ok(())
            },
        ),
        displayed(5, "range of the slope", "−k/4 < ∂ξ/∂T < 0.").code(LPV, "pub fn slope_per_k").agrees(|_, found| {
            let lpv = LpvModel::new(&table_10(), Coupling::Thermal)?;
            let h = Hysteresis::new(&Material::default());
            let slope = |t: f64, heating: bool| {
                let martensite = if heating { h.upper(t).martensite } else { h.lower(t).martensite };
                lpv.slope_per_k(&OperatingPoint { temperature_c: t, martensite, stress_pa: 0.0, heating })
            };
            let all: Vec<f64> = (0..1500).flat_map(|i| [true, false].map(|up| slope(0.1 * f64::from(i), up))).collect();
            found.near("steepest", "1/K", -0.31 / 4.0, 1e-9, crate::wires::least(&all));
            found.below("flattest", "1/K", 0.0, largest(&all));
            Ok(())
        }),
        figure(
            92,
            "poles and gains over the slope",
            "In the middle of the transformation the thermal mass is largest: \
                temperature answers least, and the phase most.",
        )
        .code(LPV, "pub fn martensite_form")
        .agrees(|_, found| {
            let model = simplified(table_10());
            let lpv = LpvModel::new(&model, Coupling::Thermal)?;
            let slopes: Vec<f64> = (0..=155).map(|i| -0.0005 * f64::from(i)).collect();
            let forms: Vec<StateSpace> =
                slopes.iter().map(|slope| lpv.martensite_form(&middle(&model), *slope)).collect();
            let pole: Vec<f64> = forms.iter().map(|form| form.a[(3, 3)]).collect();
            let (to_t, to_xi): (Vec<f64>, Vec<f64>) = forms.iter().map(|form| (form.b[3], form.b[2])).unzip();
            let last = slopes.len() - 1;
            found.equal("pole of T without transformation", "1/s", -lpv.temperature_pole(), pole[0]);
            found.above("pole of T, without over with transformation", "1", 2.0, pole[0] / pole[last]);
            found.above("gain to T, without over with transformation", "1", 2.0, to_t[0] / to_t[last]);
            found.nothing("gain to ξ without transformation", "1/J", 1e-12, to_xi[0]);
            found.below("gain to ξ with transformation", "1/J", -1.0, to_xi[last]);
            let across = ("∂ξ/∂T, 1/K", "1");
            found.line(across, ("Pole of the temperature, 1/s", "1"), Ink::Series(0), (slopes.clone(), pole));
            found.line(across, ("Power to temperature rate, K/J", "1"), Ink::Series(0), (slopes.clone(), to_t));
            found.line(across, ("Power to phase rate, 1/J", "1"), Ink::Series(0), (slopes, to_xi));
            Ok(())
        }),
    ]
}

/// Table 10's rig in units in which its states are of a size, an observer with poles beyond ten times its own thermal one, and those.
fn observer() -> Tried<(DMatrix<f64>, Vec<Complex<f64>>, StateSpace)> {
    let (_, form, _) = rig()?;
    let poles: Vec<Complex<f64>> = [-8.0, -12.0, -16.0, -20.0].map(|re| Complex::new(re, 0.0)).to_vec();
    Ok((place_observer(&form.a, &form.c, &poles)?, poles, form))
}

/// The error of the estimate decays by A − L C, whatever the input and the estimate do.
pub(crate) fn observer_error(_: &Lab, found: &mut Found) -> Computed {
    let (l, poles, form) = observer()?;
    let closed = &form.a - &l * &form.c;
    let mut got: Vec<f64> = eigenvalues(&closed)?.iter().map(|pole| pole.re).collect();
    let mut wanted: Vec<f64> = poles.iter().map(|pole| pole.re).collect();
    got.sort_by(f64::total_cmp);
    wanted.sort_by(f64::total_cmp);
    for (got, wanted) in got.iter().zip(&wanted) {
        found.near("pole of the error", "1/s", *wanted, 1e-3, *got);
    }
    // x and x̂ each by their own equation, the input the same; their difference by exp((A − L C) t)
    let (dt, steps) = (1e-4, 2000);
    let (ad, bd) = convert::discretise(&form.a, &form.b, dt)?;
    let inputs = DMatrix::from_fn(4, 2, |i, j| if j == 0 { form.b[i] } else { l[i] });
    let (od, obd) = convert::discretise(&closed, &inputs, dt)?;
    let mut x = DMatrix::from_row_slice(4, 1, &[1e-3, 0.0, 0.2, 5.0]);
    let (mut estimate, start) = (DMatrix::zeros(4, 1), x.clone());
    for k in 0..steps {
        let u = if k % 400 < 200 { 1.0 } else { 0.0 };
        // the observer sees the output held over the step: in the middle of it
        let next = &ad * &x + &bd * u;
        let y = 0.5 * (x[0] + next[0]);
        estimate = &od * &estimate + &obd * DMatrix::from_row_slice(2, 1, &[u, y]);
        x = next;
    }
    let predicted = convert::exponential(&(&closed * (dt * f64::from(steps))))? * start;
    let error = &x - &estimate;
    found.near("error of T after 0.2 s, over exp((A − L C) t) e(0)", "1", 1.0, 0.02, error[3] / predicted[3]);
    Ok(())
}

/// PI on chapter 11's plant with one of chapter 9's observers: RMS errors of phase and temperature over steps, and the way.
fn observed(estimator: &'static str) -> Tried<(f64, f64, Trace)> {
    let mut run = Run::new("thesis_3w", Chosen { estimator: Some(estimator), ..Chosen::law("pi") })?;
    let steps = [0.4, 0.8, 0.4].map(|to| run.step(to));
    let mean = |of: fn(&sinew_bench::Step) -> f64| (steps.iter().map(|s| of(s).powi(2)).sum::<f64>() / 3.0).sqrt();
    Ok((mean(|s| s.martensite_rms), mean(|s| s.temperature_rms_k), run.trace))
}

fn draw_estimates(found: &mut Found, trace: Trace) {
    found.legend(Ink::Measured, "true");
    found.legend(Ink::Series(1), "estimated");
    let temperature = ("Temperature", "°C");
    found.line(TIME, temperature, Ink::Measured, (trace.time_s.clone(), trace.temperature_c));
    found.line(TIME, temperature, Ink::Series(1), (trace.time_s.clone(), trace.estimated_c));
    let martensite = ("Martensite fraction", "1");
    found.line(TIME, martensite, Ink::Measured, (trace.time_s.clone(), trace.martensite));
    found.line(TIME, martensite, Ink::Series(1), (trace.time_s, trace.estimated_martensite));
}

fn estimators() -> Vec<Row> {
    vec![
        displayed(
            6,
            "the estimator",
            "The model runs beside the wire, corrected by L times what the output \
                differs by.",
        )
        .code(OBSERVER, "pub struct LuenbergerObserver")
        .agrees(observer_error),
        displayed(7, "the estimator, gathered", "The same with A − L C in one matrix.")
            .code(OBSERVER, "pub struct LuenbergerObserver")
            .agrees(observer_error),
        displayed(8, "the error", "What the state is less its estimate.")
            .code("control/state-space/src/place.rs", "pub fn place_observer")
            .agrees(observer_error),
        displayed(9, "the error's rate", "The rates' difference.")
            .code("control/state-space/src/place.rs", "pub fn place_observer")
            .agrees(observer_error),
        displayed(
            10,
            "how the error decays",
            "ė = (A − L C) e where the model is exact; for 0.125 mm the wire's \
                own pole is −0.7228/s, and the estimator's are beyond −7.228/s.",
        )
        .code("control/state-space/src/place.rs", "pub fn place_observer")
        .code(OBSERVER, "const THERMAL_POLES")
        .agrees(|lab, found| {
            let measured = Material { convection_w_per_m2_k: 121.8, ..Material::default() };
            let model = WireModel { material: measured, ..hanging() };
            found.near(
                "pole of the temperature of 0.125 mm",
                "1/s",
                0.7228,
                1e-4,
                LpvModel::new(&model, Coupling::Thermal)?.temperature_pole(),
            );
            observer_error(lab, found)
        }),
        figure(
            93,
            "an estimator of average properties",
            "Constant gains get position and phase right, and temperature wrong.",
        )
        .code(OBSERVER, "pub fn constant")
        .agrees(|_, found| {
            let (martensite, temperature, trace) = observed("luenberger")?;
            found.below("RMS error of the phase", "1", 0.1, martensite);
            found.above("RMS error of the temperature", "K", 5.0, temperature);
            draw_estimates(found, trace);
            Ok(())
        }),
        figure(
            94,
            "a gain-scheduled estimator",
            "Scheduled gains get the temperature right too, once their first \
                error has gone.",
        )
        .code(OBSERVER, "pub fn scheduled")
        .agrees(|_, found| {
            let (martensite, temperature, trace) = observed("luenberger_scheduled")?;
            found.below("RMS error of the phase", "1", 0.1, martensite);
            found.below(
                "RMS error of the temperature, over that of constant gains",
                "1",
                0.5,
                temperature / observed("luenberger")?.1,
            );
            draw_estimates(found, trace);
            Ok(())
        }),
        Row::new(Nine, Table(10), "the rig", "0.1 mm × 233 mm of wire on 0.13 kg, 18 N/m and 0.915 N s/m.")
            .code("tools/bench/src/plant.rs", "name: \"chapter_9\"")
            .agrees(|_, found| {
                let rig = Plant::named("chapter_9").ok_or("no such plant")?.believed(&Choice::default(), 1)?;
                let model = &rig.channels.first().ok_or("no channel")?.model;
                let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, .. } = model.load else {
                    return Err("another load".into());
                };
                found.equal("mass", "kg", 0.13, mass_kg);
                found.equal("spring", "N/m", 18.0, spring_n_per_m);
                found.equal("damping", "N s/m", 0.915, damping_n_s_per_m);
                found.equal("diameter", "mm", 0.1, model.geometry.diameter_m * 1e3);
                found.equal("length", "mm", 233.0, model.geometry.length_m * 1e3);
                Ok(())
            }),
        figure(
            96,
            "the estimator on the rig, measured",
            "After 0.4 s the estimates are where they can be: phase 0.5 to 1, \
                temperature in the transformation.",
        )
        .not_given("the measured curves, the controller's gains and the supply"),
        figure(
            97,
            "the estimator on the rig, simulated",
            "It follows once the transformation begins, near 0.4 s; the wire \
                overshoots.",
        )
        .code("tools/bench/src/plant.rs", "name: \"chapter_9\"")
        .differs(
            "the gains of its PI are not given; with the rig file's own the wire \
                arrives without overshoot. The estimator does what is said",
            |_, found| {
                let mut run =
                    Run::new("chapter_9", Chosen { estimator: Some("luenberger_scheduled"), ..Chosen::law("pi") })?;
                let step = run.step(0.5);
                let trace = run.trace;
                found.above("overshoot, of the stroke", "%", 0.5, 100.0 * step.overshoot);
                found.proof();
                let begins =
                    trace.martensite.iter().position(|xi| *xi < 0.95).map_or(f64::NAN, |i| trace.time_s[i] - 0.5);
                found.between("transformation begins after", "s", 0.1, 0.8, begins);
                let late = trace.time_s.iter().zip(trace.martensite.iter().zip(&trace.estimated_martensite));
                let errors: Vec<f64> = late.filter(|(t, _)| **t > 1.5).map(|(_, (a, b))| (a - b).abs()).collect();
                found.below(
                    "largest error of the phase, a second after it is commanded and later",
                    "1",
                    0.15,
                    largest(&errors),
                );
                draw_estimates(found, trace);
                Ok(())
            },
        ),
        figure(
            98,
            "blowing on the wire",
            "The air cools the wire, the controller heats it, and the estimate \
                rises where the temperature does not.",
        )
        .code(OBSERVER, "looks like heat (figure 98)")
        .agrees(|_, found| {
            let mut run = Run::new("thesis_3w", Chosen { estimator: Some("luenberger"), ..Chosen::law("pi") })?;
            run.step(0.5);
            let before = *run.trace.estimated_c.last().ok_or("nothing was seen")?;
            let truth = *run.trace.temperature_c.last().ok_or("nothing was seen")?;
            run.trace = Trace::default();
            let disturbed = run.draught(0.5);
            let end = |of: &[f64]| of.last().copied().unwrap_or(f64::NAN);
            found.above("the estimate rises by", "K", 5.0, end(&run.trace.estimated_c) - before);
            found.below("the wire itself changes by", "K", 3.0, (end(&run.trace.temperature_c) - truth).abs());
            found.above("error of the estimate after a second", "K", 1.0, disturbed.temperature_error_k);
            draw_estimates(found, run.trace);
            Ok(())
        }),
    ]
}
