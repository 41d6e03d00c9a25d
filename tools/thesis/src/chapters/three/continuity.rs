//! The model that is chosen, and how it is kept without gaps where its direction changes.

use sinew_physics::formulas::compliance;
use sinew_physics::{Hysteresis, Inputs, KeptHistory, Load, Material, Wire, WireModel};
use sinew_plot::Ink;

use super::shared::{
    BALANCE, KINETICS, LOOP_C, LOOP_MPA, MARTENSITE, MECHANICAL, PARAMS, REFERENCE, displayed, draw_loops, equation,
    figure, whole_strain,
};
use crate::axes::{STRAIN, STRESS, TEMPERATURE, TIME};
use crate::found::{Found, Tried};
use crate::row::Row;
use crate::wires::{MPA, STEP_S, Way, at, imposed, in_a_furnace, largest, least};

pub(super) fn summary() -> Vec<Row> {
    vec![
        equation(23, "the strain, chosen", "Eq. 6 again: the constitutive model that is taken.")
            .code(BALANCE, "Strain of the phase `fraction` (eq. 23)")
            .agrees(whole_strain),
        equation(
            24,
            "the phase, chosen",
            "Logistic curves by the direction of T − σ/α, scaled by how far the \
                last transformation went.",
        )
        .code(KINETICS, "pub(crate) fn reverse")
        .agrees(|_, found| {
            // from ξ = ½ at 80 °C: ξ_M = ½ (1 + e^(k (80 − 93))), then along its own curve
            let material = Material { outer_loop_weight: 0.0, ..Material::default() };
            let way = imposed(&in_a_furnace(material, 0.5), &[[80.0, 0.0], [95.0, 0.0]], 1500)?;
            let scale = 0.5 * (1.0 + (0.31f64 * -13.0).exp());
            found.near(
                "ξ at 95 °C from ½ at 80 °C",
                "1",
                scale / (1.0 + (0.31f64 * 2.0).exp()),
                1e-6,
                way.martensite[1500],
            );
            let way = imposed(&in_a_furnace(material, 0.5), &[[80.0, 0.0], [65.0, 0.0]], 1500)?;
            let scale = 0.5 * (1.0 + (0.31f64 * -13.0).exp());
            let stated = 1.0 - scale * (1.0 - 1.0 / (1.0 + (0.31f64 * -2.0).exp()));
            found.near("ξ at 65 °C from ½ at 80 °C", "1", stated, 1e-6, way.martensite[1500]);
            Ok(())
        }),
        displayed(6, "compliance of the mixture", "C(ξ) = (1−ξ)/E_A + ξ/E_M.")
            .code(MECHANICAL, "pub fn compliance")
            .agrees(|_, found| {
                for xi in [0.0, 0.3, 1.0] {
                    let stated = (1.0 - xi) / 75.0 + xi / 28.0;
                    found.near(
                        &format!("C({xi})"),
                        "1/GPa",
                        stated,
                        1e-12,
                        compliance(1.0 / 75.0, 1.0 / 28.0 - 1.0 / 75.0, xi),
                    );
                }
                Ok(())
            }),
        figure(
            17,
            "strain under stress cycles in slow warming",
            "Five degrees change the strain left after a stress cycle completely. \
                Cycles and rates are not given; ours go to 600 MPa.",
        )
        .code("model/physics/src/step/wire.rs", "pub fn step")
        .agrees(|_, found| {
            let left = |temperature_c: f64| -> Tried<f64> {
                let corners = [[temperature_c, 0.0], [temperature_c, LOOP_MPA], [temperature_c, 0.0]];
                let way = imposed(&in_a_furnace(Material::default(), 0.0), &corners, 1000)?;
                Ok(way.strain[2000])
            };
            found.above("strain left, 90 to 95 °C, of ε_L", "%", 25.0, 100.0 * (left(90.0)? - left(95.0)?) / 0.04);
            let corners: Vec<[f64; 2]> =
                (0..=16).map(|i| [80.0 + 2.0 * f64::from(i), if i % 2 == 0 { 0.0 } else { LOOP_MPA }]).collect();
            let way = imposed(&in_a_furnace(Material::default(), 0.0), &corners, 500)?;
            found.line(STRAIN, STRESS, Ink::Series(0), (way.strain.clone(), way.stress_mpa));
            found.line(TIME, STRAIN, Ink::Series(0), (way.time_s, way.strain));
            Ok(())
        }),
        figure(
            18,
            "stress under strain cycles that die away",
            "Strain 0.03 (1 − cos t)/(1 + t/5) at one temperature, which is not \
                given; ours is 110 °C.",
        )
        .code(REFERENCE, "Stress of a wire held at `position` (eq. 23)")
        .agrees(|_, found| {
            let model = WireModel { load: Load::ImposedPosition, ..in_a_furnace(Material::default(), 0.0) };
            let mut wire = Wire::with_inputs(&model, &Inputs { drive: LOOP_C, ..model.rest_inputs() })?;
            let (mut strain, mut stress, mut jump) = (vec![0.0], vec![0.0], 0f64);
            for k in 1..=30_000 {
                let t = f64::from(k) * STEP_S;
                let wanted = 0.03 * (1.0 - t.cos()) / (1.0 + t / 5.0);
                let imposed = wanted * model.geometry.length_m;
                wire.step(&Inputs { drive: LOOP_C, imposed, ..model.rest_inputs() }, STEP_S);
                let mpa = wire.stress_pa() / MPA;
                jump = jump.max((mpa - stress[stress.len() - 1]).abs());
                strain.push(wanted);
                stress.push(mpa);
            }
            let peak = |from: usize| largest(&stress[from..(from + 6000).min(stress.len())]);
            found.above("peaks fall: first over third", "1", 1.0, peak(0) / peak(12_566));
            found.below("largest change of stress in a millisecond", "MPa", 5.0, jump);
            found.nothing("least stress: a wire cannot push", "MPa", 1e-6, least(&stress).min(0.0));
            found.line(STRAIN, STRESS, Ink::Series(0), (strain, stress));
            Ok(())
        }),
    ]
}

/// The alloy that figures 20 to 25 seem to have: half transformed at 70 °C, A_s = 50 °C by their text, so k = 9.21/40 K; its
/// hysteresis is the nomenclature's 26 K.
fn of_the_figures(weight: f64) -> Material {
    Material {
        austenite_temperature_c: 70.0,
        martensite_temperature_c: 44.0,
        heating_steepness_per_k: 9.21 / 40.0,
        cooling_steepness_per_k: 9.21 / 40.0,
        outer_loop_weight: weight,
        ..Material::default()
    }
}

/// Heated to half, cooled by so much, heated through and cooled again; at zero stress.
fn notched(weight: f64, drop_k: f64) -> Tried<Way> {
    let corners = [[20.0, 0.0], [70.0, 0.0], [70.0 - drop_k, 0.0], [120.0, 0.0], [20.0, 0.0]];
    imposed(&in_a_furnace(of_the_figures(weight), 1.0), &corners, 1000)
}

/// How far below the outer curve the wire is where it is as hot again as where it turned: the outer curve has ½ there.
fn missed(way: &Way) -> f64 {
    0.5 - at(&way.temperature_c[2000..3000], &way.martensite[2000..3000], 70.0)
}

fn draw_notches(found: &mut Found, ways: Vec<(String, Way)>) {
    for (i, (name, way)) in ways.into_iter().enumerate() {
        found.legend(Ink::Series(i as u8), &name);
        found.line(TEMPERATURE, MARTENSITE, Ink::Series(i as u8), (way.temperature_c, way.martensite));
    }
}

/// No step of a way may change the phase by more than a smooth curve does: a twentieth of a kelvin at the steepest slope.
const SMOOTH: f64 = 0.25 * (9.21 / 40.0) * 0.11;

const KEPT: &str = "model/physics/src/kept_history.rs";

/// Steps from 20 °C to 70 °C.
const HEATING_STEPS: usize = 1000;
/// Where the second heating begins.
const TURNED: usize = 2 * HEATING_STEPS - 1;

/// The same way as [`notched`] by the model of eq. 25: temperature and ξ.
fn kept(drop_k: f64) -> (Vec<f64>, Vec<f64>) {
    let corners = [20.0, 70.0, 70.0 - drop_k, 120.0, 20.0];
    let mut phase = KeptHistory::new(&of_the_figures(0.0), corners[0]);
    let leg = |ends: &[f64]| {
        let (from, to) = (ends[0], ends[1]);
        (1..=HEATING_STEPS).map(move |k| from + (to - from) * k as f64 / HEATING_STEPS as f64).collect::<Vec<_>>()
    };
    corners.windows(2).flat_map(leg).map(|theta| (theta, phase.follow(theta))).unzip()
}

/// The largest change from one point to the next.
fn steps(values: &[f64]) -> f64 {
    values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max)
}

pub(super) fn continuity() -> Vec<Row> {
    vec![
        equation(
            25,
            "inner loops that jump",
            "History variables are set to ξ as it is at a reversal, and the curve starts at another ξ than the wire has.",
        )
        .code(KEPT, "pub struct KeptHistory")
        .agrees(|_, found| {
            let seen = kept(20.0);
            let turned = seen.1[TURNED];
            let stated = turned / (1.0 + (9.21 / 40.0 * (90.0 - 70.0f64)).exp());
            found.near("ξ at 90 °C, heated from 50 °C", "1", stated, 1e-3, at(&seen.0[TURNED + 1..3 * HEATING_STEPS], &seen.1[TURNED + 1..3 * HEATING_STEPS], 90.0));
            let begins = turned / (1.0 + (9.21 / 40.0 * (50.0 - 70.0f64)).exp());
            found.near("jump at the reversal", "1", turned - begins, 1e-3, turned - seen.1[TURNED + 1]);
            Ok(())
        }),
        figure(
            20,
            "a long reversal",
            "Heated to half, cooled to A_s, heated through: the model of eq. 25 still looks smooth.",
        )
        .code(KEPT, "pub fn follow")
        .agrees(|_, found| {
            let (temperature, martensite) = kept(20.0);
            found.below("largest step of ξ", "1", 0.02, steps(&martensite));
            found.line(TEMPERATURE, MARTENSITE, Ink::Series(0), (temperature, martensite));
            Ok(())
        }),
        figure(21, "a short reversal", "The same with a slight drop: the model of eq. 25 jumps.")
            .code(KEPT, "pub fn follow")
            .agrees(|_, found| {
                let (temperature, martensite) = kept(2.0);
                found.above("largest step of ξ", "1", 0.1, steps(&martensite));
                found.line(TEMPERATURE, MARTENSITE, Ink::Series(0), (temperature, martensite));
                Ok(())
            }),
        equation(
            26,
            "history variables that leave no gap",
            "At a reversal ξ_M = ξ (1 + e^k(T−A)), ξ_A = (1−ξ)(1 + e^−k(T−M)): \
            the curve starts where the wire is.",
        )
        .code(KINETICS, "history variables of eq. 26, so that ξ is continuous")
        .agrees(|_, found| {
            for drop_k in [2.0, 20.0] {
                let way = notched(0.0, drop_k)?;
                found.below(&format!("largest step of ξ, drop of {drop_k} K"), "1", SMOOTH, way.largest_jump());
            }
            // the curve it then follows: ξ (1 + e^k(T−A)) stays what it was at the reversal
            let way = notched(0.0, 20.0)?;
            let scale = |i: usize| way.martensite[i] * (1.0 + (9.21 / 40.0 * (way.temperature_c[i] - 70.0)).exp());
            found.near("ξ_M half way up, over that at the reversal", "1", 1.0, 1e-6, scale(2500) / scale(2000));
            Ok(())
        }),
        figure(
            22,
            "no gap, by the long way",
            "The implicit history variable leaves no gap, but takes the wire by a \
            long way inside the loop.",
        )
        .code(KINETICS, "pub(crate) fn reverse")
        .agrees(|_, found| {
            let way = notched(0.0, 5.0)?;
            found.below("largest step of ξ", "1", SMOOTH, way.largest_jump());
            found.above("below the outer curve where it turned", "1", 0.05, missed(&way));
            draw_notches(found, vec![("implicit history, w = 0".into(), way)]);
            Ok(())
        }),
        displayed(
            7,
            "the outer loop alone",
            "ξ stays until the outer curve pushes it: the lesser of ξ and the \
            heating curve, the larger of ξ and the cooling curve (its ξ_A read \
            as 1).",
        )
        .code(KINETICS, "the outer one once that has been met")
        .agrees(|_, found| {
            let way = notched(1.0, 20.0)?;
            let drop: Vec<f64> = way.martensite[1000..2000].iter().map(|xi| (xi - 0.5).abs()).collect();
            found.below("ξ moves while it is inside", "1", 0.01, largest(&drop));
            let h = Hysteresis::new(&of_the_figures(1.0));
            let apart = (2700..3000).map(|i| (way.martensite[i] - h.upper(way.temperature_c[i]).martensite).abs());
            found.nothing("off the heating curve once that is met", "1", 1e-6, apart.fold(0.0, f64::max));
            Ok(())
        }),
        figure(
            23,
            "the outer loop",
            "After a short drop the wire is back on the outer curve where it left \
            it.",
        )
        .code(PARAMS, "pub outer_loop_weight")
        .agrees(|_, found| {
            let way = notched(1.0, 5.0)?;
            found.nothing("below the outer curve where it turned", "1", 0.005, missed(&way));
            found.below("largest step of ξ", "1", SMOOTH, way.largest_jump());
            draw_notches(found, vec![("outer loop, w = 1".into(), way)]);
            Ok(())
        }),
        displayed(8, "the weighted sum of both", "ξ is α times the outer loop's and 1 − α times the inner one's.")
            .code(KINETICS, "That is the closed form of the weighted rate law")
            .differs(
                "a sum of fractions that is formed anew each step forgets the history \
                    it started from and depends on the step; the code weighs rates \
                    instead, which is the same to first order and has a closed form \
                    between two reversals",
                |_, found| {
                    let after = |weight: f64, kelvin: f64| -> Tried<f64> {
                        let material = Material { outer_loop_weight: weight, ..Material::default() };
                        let way = imposed(&in_a_furnace(material, 0.5), &[[85.0, 0.0], [85.0 + kelvin, 0.0]], 100)?;
                        Ok(0.5 - way.martensite[100])
                    };
                    let share =
                        |kelvin: f64| -> Tried<f64> { Ok(after(0.8, kelvin)? / after(0.0, kelvin)?) };
                    found.near(
                        "motion over the inner loop's, 6 K after a reversal, α = 0.8",
                        "1",
                        0.2,
                        0.005,
                        share(6.0)?,
                    );
                    found.proof();
                    found.near("the same, 0.05 K after it", "1", 0.2, 0.005, share(0.05)?);
                    Ok(())
                },
            ),
        figure(
            24,
            "the weighted model in a short drop",
            "With α = 0.2, said to prefer the outer loop, the wire returns \
            quickly to the outer curve.",
        )
        .code(PARAMS, "pub outer_loop_weight")
        .differs(
            "α multiplies the outer loop, so that 0.2 prefers the inner one, and \
                    the wire stays off the outer curve; the preference the text and the \
                    figure show is α = 0.8, the model's default",
            |_, found| {
                let (printed, meant) = (notched(0.2, 5.0)?, notched(0.8, 5.0)?);
                found.below("below the outer curve where it turned, α = 0.2", "1", 0.05, missed(&printed));
                found.proof();
                found.below("the same, α = 0.8", "1", 0.05, missed(&meant));
                found.below("largest step of ξ", "1", SMOOTH, meant.largest_jump());
                draw_notches(found, vec![("α = 0.8".into(), meant), ("α = 0.2".into(), printed)]);
                Ok(())
            },
        ),
        figure(25, "the weighted model in a long drop", "The same after a large drop; it is continuous.")
            .code(PARAMS, "pub outer_loop_weight")
            .differs(
                "as in fig. 24, α = 0.2 prefers the inner loop and takes the long \
                way; 0.8 does what is said",
                |_, found| {
                    let (printed, meant) = (notched(0.2, 20.0)?, notched(0.8, 20.0)?);
                    found.below("below the outer curve where it turned, α = 0.2", "1", 0.1, missed(&printed));
                    found.proof();
                    found.below("the same, α = 0.8", "1", 0.1, missed(&meant));
                    found.below("largest step of ξ", "1", SMOOTH, meant.largest_jump());
                    draw_notches(found, vec![("α = 0.8".into(), meant), ("α = 0.2".into(), printed)]);
                    Ok(())
                },
            ),
        figure(
            26,
            "a large inner loop of stress",
            "Stress taken back to half and up again: no jump, and austenite's and \
            martensite's stiffness at the ends. The measured half is a picture \
            without numbers.",
        )
        .code("model/physics/src/step/wire.rs", "pub fn step")
        .agrees(|_, found| {
            let legs = [0.0, 400.0, 200.0, LOOP_MPA, 0.0];
            let way = imposed(&in_a_furnace(Material::default(), 0.0), &legs.map(|mpa| [LOOP_C, mpa]), 2000)?;
            let stiffness =
                |i: usize| (way.stress_mpa[i] - way.stress_mpa[i - 1]) / (way.strain[i] - way.strain[i - 1]) * 1e-3;
            found.near("stiffness of the unloaded austenite", "GPa", 75.0, 1.5, stiffness(1));
            found.near("stiffness of the loaded martensite", "GPa", 28.0, 1.5, stiffness(6001));
            found.below("largest step of ξ", "1", 0.01, way.largest_jump());
            draw_loops(found, [("model", way)]);
            Ok(())
        }),
        figure(
            27,
            "a notch of a tenth of the stress",
            "A drop of 10 % under load: no skip, and soon back on the outer loop. \
            The measured half is a picture without numbers.",
        )
        .code("model/physics/src/step/wire.rs", "pub fn step")
        .agrees(|_, found| {
            let legs = |drop: f64| [0.0, 420.0, 420.0 - drop, LOOP_MPA, 0.0].map(|mpa| [LOOP_C, mpa]);
            let notch = imposed(&in_a_furnace(Material::default(), 0.0), &legs(42.0), 2000)?;
            let plain = imposed(&in_a_furnace(Material::default(), 0.0), &legs(0.0), 2000)?;
            let apart = |mpa: f64| {
                let strain = |way: &Way| at(&way.stress_mpa[4000..6000], &way.strain[4000..6000], mpa);
                (strain(&notch) - strain(&plain)).abs()
            };
            found.below("largest step of ξ", "1", 0.01, notch.largest_jump());
            found.below("off the outer loop, back at the stress of the drop", "1", 0.002, apart(421.0));
            found.below("off the outer loop, a tenth further", "1", 0.0005, apart(462.0));
            draw_loops(found, [("with the notch", notch), ("without", plain)]);
            Ok(())
        }),
    ]
}
