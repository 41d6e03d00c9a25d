//! Chapter 7: the dual measurement.

use sinew_bench::sensing::{self, Heating, Place as Taps_, Summary, THESIS};
use sinew_physics::formulas::{
    STANDARD_GRAVITY_M_S2, dual_variance, mixture, phase_resistivity, resistance_ohm, resistivity_ohm_m,
    share_between_taps,
};
use sinew_physics::{Drive, DriveKind, Hysteresis, Inputs, Material, Taps, Wire, WireModel};
use sinew_plot::Ink;

use crate::axes::TIME;
use crate::chapter::Chapter::Seven;
use crate::chapter::Place::{Equation, Figure, Table};
use crate::found::{Found, Tried};
use crate::lab::{Chosen, Lab, Run};
use crate::row::Row;
use crate::wires::{MPA, STEP_S, hanging, in_a_furnace, largest};

const ELECTRICAL: &str = "model/physics/src/formulas/electrical.rs";
const EFFECTS: &str = "model/physics/src/effects/electrical.rs";
const SENSING: &str = "tools/bench/src/sensing/mod.rs";

fn equation(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Seven, Equation(number), title, states)
}

fn figure(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Seven, Figure(number), title, states)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = resistance();
    rows.extend(lengths());
    rows.extend(experiment());
    rows
}

/// Resistance of an austenite wire at 160 °C under 200 MPa.
fn under_stress(change: impl Fn(&mut WireModel)) -> Tried<f64> {
    let mut model = in_a_furnace(Material::default(), 0.0);
    change(&mut model);
    let inputs =
        |mpa: f64| Inputs { drive: 160.0, imposed: mpa * MPA * model.geometry.area_m2(), ..model.rest_inputs() };
    let mut wire = Wire::with_inputs(&model, &inputs(200.0))?;
    wire.step(&inputs(200.0), STEP_S);
    Ok(wire.resistance_ohm())
}

fn resistance() -> Vec<Row> {
    vec![
        equation(36, "resistivity of the mixture", "ρ = (1−ξ) ρ_A + ξ ρ_M.").code(ELECTRICAL, "pub fn mixture").agrees(
            |_, found| {
                found.equal("ξ = 0.3", "µΩ cm", 0.7 * 86.5 + 0.3 * 75.0, mixture(0.7, 0.3, 86.5, 75.0));
                Ok(())
            },
        ),
        equation(
            37,
            "resistivity by temperature",
            "Each phase's rises by its α with the temperature over T_0: 0.05 and \
                0.15 µΩ cm/K.",
        )
        .code(ELECTRICAL, "pub fn phase_resistivity")
        .agrees(|_, found| {
            let m = Material::default();
            found.equal("austenite, 60 K over T_0", "µΩ cm", 86.5 + 0.05 * 60.0, m.austenite_resistivity(80.0) * 1e8);
            found.equal("martensite, 60 K over T_0", "µΩ cm", 75.0 + 0.15 * 60.0, m.martensite_resistivity(80.0) * 1e8);
            found.equal("the formula", "µΩ cm", 75.0 + 0.15 * 60.0, phase_resistivity(75.0, 0.15, 60.0));
            Ok(())
        }),
        equation(38, "resistivity by stress", "Novák adds β σ to each phase's; no β is given.")
            .code(EFFECTS, "electrical.resistivity_stress")
            .agrees(|_, found| {
                // the effect's β is relative to ρ
                let plain = under_stress(|_| ())?;
                let with = under_stress(|model| model.effects.electrical.resistivity_stress.austenite_per_pa = 1e-10)?;
                found.near(
                    "resistance at 200 MPa over that without, β = 10⁻¹⁰/Pa of ρ",
                    "1",
                    1.0 + 1e-10 * 200e6,
                    1e-9,
                    with / plain,
                );
                Ok(())
            }),
        equation(39, "resistance", "R = ρ L/A.").code(ELECTRICAL, "pub fn resistance_ohm").agrees(|_, found| {
            found.equal(
                "80 µΩ cm, 160 mm, 0.0123 mm²",
                "Ω",
                80e-8 * 0.16 / 1.23e-8,
                resistance_ohm(80e-8, 0.16, 1.23e-8),
            );
            Ok(())
        }),
        equation(40, "length by strain", "L = l_0 (1 + ε), so that strain alone raises the resistance.")
            .code("model/physics/src/step/balance.rs", "R = ρL/A_c (eq. 36, 37, 39)")
            .agrees(|_, found| {
                let model = in_a_furnace(Material::default(), 0.0);
                let g = model.geometry;
                let strain = 200e6 / 75e9 + 0.55e6 * 140.0 / 75e9;
                let rho = model.material.austenite_resistivity(160.0);
                found.near(
                    "resistance at 200 MPa and 160 °C",
                    "Ω",
                    rho * g.length_m * (1.0 + strain) / g.area_m2(),
                    1e-6,
                    under_stress(|_| ())?,
                );
                Ok(())
            }),
        equation(41, "cross-section by stress", "A = π r_0² (1 − ν σ/E)².")
            .code(EFFECTS, "electrical.poisson_area")
            .agrees(|_, found| {
                let with = under_stress(|model| model.effects.electrical.poisson_area.ratio = 0.33)?;
                let narrower = 1.0 - 0.33 * 200.0 / 75e3;
                found.near(
                    "resistance over that of a wire that keeps its section",
                    "1",
                    1.0 / (narrower * narrower),
                    1e-6,
                    with / under_stress(|_| ())?,
                );
                Ok(())
            }),
    ]
}

/// A wire that hangs at taps, heated half way, and its voltages.
fn tapped(taps: Taps) -> Tried<(WireModel, Wire)> {
    let model = WireModel {
        taps: Some(taps),
        drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.02, lead_ohm: 0.0 },
        ..hanging()
    };
    let mut wire = Wire::new(&model)?;
    for _ in 0..700 {
        wire.step(&Inputs { drive: 0.35, ..model.rest_inputs() }, STEP_S);
    }
    Ok((model, wire))
}

const THEIRS: Taps = Taps { l0_m: 0.091, ls_m: 0.055 };
const LONG: Taps = Taps { l0_m: 0.0, ls_m: 0.150 };

fn lengths() -> Vec<Row> {
    vec![
        equation(
            42,
            "length by three voltages",
            "L = l_0 + l_s (V_3 − V_1)/(V_2 − V_1), whatever phase, stress and \
                temperature.",
        )
        .code(ELECTRICAL, "pub fn share_between_taps")
        .agrees(|_, found| {
            let (model, wire) = tapped(THEIRS)?;
            let o = wire.outputs();
            let length = THEIRS.length_m(share_between_taps(o.v1_v, o.v2_v, o.v3_v));
            found.near(
                "measured less true length, half transformed",
                "mm",
                0.0,
                1e-9,
                1e3 * (length - model.geometry.length_m - wire.position_m()),
            );
            Ok(())
        }),
        equation(43, "length by two voltages", "With l_0 = 0 it is l_s V_3/V_2.")
            .code(ELECTRICAL, "pub fn length_m")
            .agrees(|_, found| {
                let (model, wire) = tapped(LONG)?;
                let o = wire.outputs();
                let length = model.geometry.length_m + wire.position_m();
                found.near("l_s V_3/V_2", "mm", 1e3 * length, 1e-9, 1e3 * LONG.ls_m * o.v3_v / o.v2_v);
                found.near(
                    "the formula",
                    "mm",
                    1e3 * length,
                    1e-9,
                    1e3 * LONG.length_m(share_between_taps(o.v1_v, o.v2_v, o.v3_v)),
                );
                Ok(())
            }),
        equation(44, "resistivity by two voltages", "ρ = (A/l_s)(V_2 − V_1)/I.")
            .code(ELECTRICAL, "pub fn resistivity_ohm_m")
            .agrees(|_, found| {
                let (model, wire) = tapped(THEIRS)?;
                let o = wire.outputs();
                let area = model.geometry.area_m2();
                let rho = resistivity_ohm_m((o.v2_v - o.v1_v) / o.current_a, THEIRS.ls_m, area);
                let m = &model.material;
                let stated = mixture(
                    1.0 - wire.martensite(),
                    wire.martensite(),
                    m.austenite_resistivity(wire.temperature_c()),
                    m.martensite_resistivity(wire.temperature_c()),
                );
                found.near("resistivity, half transformed", "µΩ cm", stated * 1e8, 1e-6, rho * 1e8);
                Ok(())
            }),
        Row::new(
            Seven,
            Table(6),
            "the wire of the experiment",
            "160 mm hot, 168.1 mm cold, 0.125 mm, 12.6 mg, A_f = 90 °C.",
        )
        .code("tools/bench/src/sensing/sweep.rs", "pub fn believed")
        .agrees(|_, found| {
            let model = sensing::believed(THEIRS, 200.0);
            found.near("mass", "mg", 12.6, 0.1, 1e6 * model.geometry.mass_kg(&model.material));
            found.equal("hot length", "mm", 160.0, 1e3 * model.geometry.length_m);
            found.equal(
                "cold length, unloaded",
                "mm",
                168.1,
                1e3 * model.geometry.length_m * (1.0 + model.material.transformation_strain),
            );
            found.near(
                "martensite left at A_f",
                "1",
                0.01,
                1e-9,
                Hysteresis::new(&model.material).upper(90.0).martensite,
            );
            Ok(())
        }),
        Row::new(
            Seven,
            Table(7),
            "where the taps were",
            "L = 160 mm, l_s = 55 mm, l_0 = 91 mm; the text would rather have l_0 \
                = 0 and l_s near L.",
        )
        .code("tools/bench/src/sensing/sweep.rs", "Table 7: l_0 = 91 mm, l_s = 55 mm")
        .agrees(|_, found| {
            found.equal("second tap", "mm", 146.0, 1e3 * THEIRS.second_m());
            // deviation of a length, in volts' worth: l_s/(V_2 − V_1) is the same for both
            let share = |taps: Taps| (0.165 - taps.l0_m) / taps.ls_m;
            let ratio = (dual_variance(share(THEIRS)) / dual_variance(share(LONG))).sqrt();
            found.between("noise of table 7's length over the better place's", "1", 1.0, 3.0, ratio);
            Ok(())
        }),
    ]
}

/// Chapter 7's own arrangement with the noise of its own part.
fn summary(lab: &Lab) -> Tried<Summary> {
    let all = &lab.sensing()?.summary;
    let own = |s: &&Summary| s.taps == Taps_::Thesis && s.heating == Heating::Current && s.noise == "part";
    all.iter().find(own).copied().ok_or_else(|| "no such arrangement".into())
}

/// The slow sweep of current under a load, gf: time, current, elongation in mm, resistance; table 6's wire.
fn sweep(load_gf: f64) -> Tried<[Vec<f64>; 4]> {
    let believed = sensing::believed(THEIRS, load_gf);
    let model = WireModel { drive: Drive { kind: DriveKind::Current, ..believed.drive }, ..believed };
    let mut wire = Wire::new(&model)?;
    let mut seen: [Vec<f64>; 4] = Default::default();
    for k in 0..8000 {
        let share = f64::from(k) / 8000.0;
        let current = 0.04 + 0.21 * if share < 0.5 { 2.0 * share } else { 2.0 - 2.0 * share };
        wire.step(&Inputs { drive: current, ..model.rest_inputs() }, 5.0 * STEP_S);
        for (of, value) in seen.iter_mut().zip([share * 40.0, current, 1e3 * wire.position_m(), wire.resistance_ohm()])
        {
            of.push(value);
        }
    }
    Ok(seen)
}

/// What the thesis' own measurement could tell from no error: its deviation, 0.154 mm of a stroke of 8.2 mm, %.
const TELLABLE_PERCENT: f64 = 100.0 * 0.154 / 8.2;

const LOADS_GF: [f64; 3] = [100.0, 200.0, 300.0];

fn experiment() -> Vec<Row> {
    vec![
        figure(
            75,
            "what drove the experiment",
            "40 to 250 mA and back in 40 s, under 300, 200 and 100 gf, which are \
            about 240, 160 and 80 MPa.",
        )
        .code(SENSING, "**The drive** is the thesis' current")
        .agrees(|_, found| {
            for (i, load_gf) in LOADS_GF.into_iter().enumerate() {
                let area = hanging().geometry.area_m2();
                found.near(
                    &format!("stress of {load_gf} gf"),
                    "MPa",
                    [80.0, 160.0, 240.0][i],
                    1.0,
                    load_gf * 1e-3 * STANDARD_GRAVITY_M_S2 / area / MPA,
                );
                let [time, current, elongation, _] = sweep(load_gf)?;
                found.legend(Ink::Series(i as u8), &format!("{load_gf} gf"));
                found.line(TIME, ("Current", "A"), Ink::Series(i as u8), (time.clone(), current));
                found.line(TIME, ("Elongation, mm", "1"), Ink::Series(i as u8), (time, elongation));
            }
            Ok(())
        }),
        figure(
            76,
            "length by resistance",
            "A line through resistance leaves a standard deviation of 9.95 % of \
            the stroke, and turns back at the ends.",
        )
        .code(SENSING, "by resistance and one straight line")
        .differs(
            "the nomenclature's martensite gains 0.2 % of resistivity a kelvin, \
                so that warming the cold wire, which hardly moves it, changes its \
                resistance several times as much as transforming it does: the line \
                of the model's wire is worse than that of the measured one",
            |lab, found| {
                let s = summary(lab)?;
                found.near(
                    "deviation by resistance, of the stroke",
                    "%",
                    THESIS.resistance_percent,
                    0.2 * THESIS.resistance_percent,
                    s.resistance_percent,
                );
                found.proof();
                let m = sensing::believed(THEIRS, 200.0).material;
                let warming = 160.0 * (m.martensite_resistivity(70.0) - m.martensite_resistivity(25.0));
                let transforming = 160.0 * m.austenite_resistivity(80.0) - 168.1 * m.martensite_resistivity(80.0);
                found.between(
                    "resistance gained from 25 to 70 °C, cold, over that of the \
                    transformation at 80 °C",
                    "1",
                    3.0,
                    10.0,
                    (warming / transforming).abs(),
                );
                found.above(
                    "deviation by resistance over that by two taps",
                    "1",
                    3.0,
                    s.resistance_percent / s.dual_percent,
                );
                for (i, load_gf) in LOADS_GF.into_iter().enumerate() {
                    let [_, _, elongation, resistance] = sweep(load_gf)?;
                    found.legend(Ink::Series(i as u8), &format!("{load_gf} gf"));
                    found.line(
                        ("Elongation, mm", "1"),
                        ("Resistance", "Ω"),
                        Ink::Series(i as u8),
                        (elongation, resistance),
                    );
                }
                Ok(())
            },
        ),
        figure(
            77,
            "length by two taps",
            "Straight, with a standard deviation of 0.154 mm, 1.7 % of a stroke \
            of 8.2 mm, mostly within 0.5 mm.",
        )
        .code(SENSING, "by\n//! the dual measurement (eq. 42)")
        .differs(
            "noise of a step of the named part is more than the thesis found, so \
                its voltages were averaged or the steps smaller than they are given; \
                the noise that would give its figure is a stated share of it",
            |lab, found| {
                let s = summary(lab)?;
                found.near("deviation by two taps", "mm", THESIS.dual_mm, 0.2 * THESIS.dual_mm, s.dual_mm);
                found.proof();
                let noises = &lab.sensing()?.noises;
                let of = |name: &str| {
                    noises.iter().find(|noise| noise.name == name).map_or(f64::NAN, |noise| noise.voltage_v)
                };
                let implied = of("implied") / of("part");
                found.near(
                    "deviation over the thesis', over what the noises are to each other",
                    "1",
                    1.0,
                    0.1,
                    s.dual_mm / THESIS.dual_mm * implied,
                );
                Ok(())
            },
        ),
        figure(
            78,
            "PI on the true length, 200 gf",
            "Settled in less than five seconds at each position, without a steady \
            error.",
        )
        .code("control/src/laws/pid.rs", "pub struct Pid {")
        .agrees(|_, found| {
            let mut run = Run::new("thesis_3w", Chosen::law("pi"))?;
            for to in [0.6, 0.3] {
                let step = run.step(to);
                let mut late = step;
                for _ in 0..3 {
                    late = run.step(to);
                }
                found.below(
                    &format!("settled within 2 % at a stroke of {to}"),
                    "s",
                    5.0,
                    step.settle_2_percent_s.unwrap_or(f64::NAN),
                );
                found.nothing("mean error nine seconds later, of the stroke", "%", TELLABLE_PERCENT, 100.0 * late.mean);
            }
            let trace = run.trace;
            found.legend(Ink::Measured, "reference");
            found.legend(Ink::Series(0), "wire");
            let stroke = ("Stroke, 0 cold", "1");
            found.line(TIME, stroke, Ink::Measured, (trace.time_s.clone(), trace.reference));
            found.line(TIME, stroke, Ink::Series(0), (trace.time_s, trace.stroke));
            Ok(())
        }),
        figure(79, "PI on resistance", "By resistance an error stays, at every load.")
            .code("model/rig/src/tables/control.rs", "resistance")
            .agrees(|_, found| {
                by_sensing(found, "resistance", |found, what, error| found.above(what, "%", TELLABLE_PERCENT, error))
            }),
        figure(80, "PI on the dual measurement", "By two taps none stays.")
            .code("sensing/src/length.rs", "pub struct LengthSensor")
            .agrees(|_, found| {
                by_sensing(found, "dual", |found, what, error| found.below(what, "%", TELLABLE_PERCENT, error))
            }),
    ]
}

/// PI under three loads by a way of sensing: the mean error at two positions, once it has settled.
fn by_sensing(found: &mut Found, sensing: &'static str, want: fn(&mut Found, &str, f64)) -> crate::row::Computed {
    for (i, (plant, load)) in
        [("load_100gf", "100 gf"), ("figure", "200 gf"), ("load_300gf", "300 gf")].into_iter().enumerate()
    {
        let mut run = Run::new(plant, Chosen { law: "pi", estimator: None, sensing: Some(sensing) })?;
        let errors = [0.6, 0.3].map(|to| {
            for _ in 0..3 {
                run.step(to);
            }
            100.0 * run.step(to).mean.abs()
        });
        want(found, &format!("larger mean error at two positions, {load}, of the stroke"), largest(&errors));
        let trace = run.trace;
        let error = trace.stroke.iter().zip(&trace.reference).map(|(a, b)| 100.0 * (b - a)).collect();
        found.legend(Ink::Series(i as u8), load);
        found.line(TIME, ("Error, % of the stroke", "1"), Ink::Series(i as u8), (trace.time_s, error));
    }
    Ok(())
}
