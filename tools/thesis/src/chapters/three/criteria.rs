//! When it transforms: the criteria, and a calorimeter's curves.

use sinew_physics::{Criterion, Kinetics, Material};
use sinew_plot::Ink;

use super::shared::{FORMULAS, KINETICS, LOOP_C, LOOP_MPA, draw_loops, equation, figure, moved, superelastic};
use crate::axes::TEMPERATURE;
use crate::found::{Found, Tried};
use crate::row::Row;
use crate::wires::{Way, at, imposed, in_a_furnace, largest, least};

const CRITERIA: &str = "model/physics/src/criteria.rs";
/// Starts and finishes lie so far from A and M, K: half of 9.21/k.
const HALF_BAND_K: f64 = 4.605_170_186 / 0.31;
/// α, MPa/K.
const MPA_PER_K: f64 = 8.0;
/// Points of a leg.
const STEPS: usize = 2000;
/// ξ that has moved, beyond the rounding of what stands still.
const MOVED: f64 = 1e-6;

fn by(criterion: Criterion) -> Material {
    Material { criterion, ..Material::default() }
}

/// Stress of a line of the phase diagram at the loops' temperature, MPa.
fn line_mpa(temperature_c: f64) -> f64 {
    (LOOP_C - temperature_c) * MPA_PER_K
}

/// The first and the last point of a leg between which the phase moves.
fn moving(way: &Way, leg: usize) -> Tried<(usize, usize)> {
    let points = leg * STEPS..(leg + 1) * STEPS;
    let moves = |i: &usize| (way.martensite[i + 1] - way.martensite[*i]).abs() > MOVED;
    let first = points.clone().find(moves).ok_or("the phase does not move")?;
    let last = points.rev().find(moves).ok_or("the phase does not move")?;
    Ok((first, last + 1))
}

/// What ξ moves by, at most, over a way.
fn travel(way: &Way) -> f64 {
    largest(&way.martensite) - least(&way.martensite)
}

/// Heated through and cooled under 100 MPa.
fn heated(material: Material) -> Tried<Way> {
    imposed(&in_a_furnace(material, 1.0), &[[20.0, 100.0], [180.0, 100.0], [20.0, 100.0]], STEPS)
}

/// A loop by stress that is all but closed: a notch of a tenth in the middle of its loading.
fn notched(found: &mut Found, name: &str, criterion: Criterion) -> Tried<()> {
    let corners = [0.0, 344.0, 309.6, LOOP_MPA, 0.0].map(|mpa| [LOOP_C, mpa]);
    let material = Material { outer_loop_weight: 0.0, ..by(criterion) };
    let way = imposed(&in_a_furnace(material, 0.0), &corners, STEPS)?;
    // the rest of the curve is as steep as k/4 of what is left
    found.below(&format!("{name}: largest step of ξ, with a notch"), "1", 0.01, way.largest_jump());
    found.nothing(
        &format!("{name}: ξ given back in the notch"),
        "1",
        1e-9,
        way.martensite[STEPS] - way.martensite[2 * STEPS],
    );
    Ok(())
}

pub(super) fn criteria() -> Vec<Row> {
    vec![
        equation(
            8,
            "Tanaka's criteria",
            "Transformation goes on while the stress falls and is below −(T − A_s) C_A, \
                or rises and is above (T − M_s) C_M.",
        )
        .code(CRITERIA, "Criterion::Tanaka")
        .differs(
            "the minus before (T − A_s) would ask for a push; without it A_s's line is that of eq. 10",
            |_, found| {
                let way = superelastic(by(Criterion::Tanaka), LOOP_MPA)?;
                let ((up, _), (down, _)) = (moving(&way, 0)?, moving(&way, 1)?);
                let (m_s, a_s) = (line_mpa(67.0 + HALF_BAND_K), line_mpa(93.0 - HALF_BAND_K));
                found.near("begins to turn martensite at 110 °C", "MPa", m_s, 0.5, way.stress_mpa[up]);
                found.near("begins to turn austenite there", "MPa", -a_s, 0.5, way.stress_mpa[down]);
                found.proof();
                found.near("the same, without the minus", "MPa", a_s, 0.5, way.stress_mpa[down]);
                let under_heat = heated(by(Criterion::Tanaka))?;
                // no finish: on past M_f's line the curve goes to its end
                let m_f = line_mpa(67.0 - HALF_BAND_K);
                let at_m_f = at(&way.stress_mpa[..STEPS], &way.martensite[..STEPS], m_f);
                found.above("ξ gained beyond M_f's line", "1", 0.005, largest(&way.martensite) - at_m_f);
                found.nothing("ξ moved by heat under constant stress", "1", 0.0, travel(&under_heat));
                notched(found, "Tanaka", Criterion::Tanaka)?;
                draw_loops(found, [("eq. 8", way), ("eq. 12", superelastic(Material::default(), LOOP_MPA)?)]);
                Ok(())
            },
        ),
        equation(
            9,
            "Liang and Rogers' criteria",
            "It goes on while the temperature rises between A_s + σ/C_A and A_f + σ/C_A, \
            or falls between M_s + σ/C_M and M_f + σ/C_M.",
        )
        .code(CRITERIA, "Criterion::LiangRogers")
        .agrees(|_, found| {
            let way = heated(by(Criterion::LiangRogers))?;
            let ((up, hot), (down, cold)) = (moving(&way, 0)?, moving(&way, 1)?);
            for (what, centre, stated) in [
                ("turns austenite from", up, 93.0 - HALF_BAND_K),
                ("turns austenite up to", hot, 93.0 + HALF_BAND_K),
                ("turns martensite from", down, 67.0 + HALF_BAND_K),
                ("turns martensite down to", cold, 67.0 - HALF_BAND_K),
            ] {
                found.near(&format!("{what}, under 100 MPa"), "°C", stated + 12.5, 0.2, way.temperature_c[centre]);
            }
            // what a logistic curve has left at its bounds: from 1/(1 + 0.01) to 0.01 of that
            found.near("ξ left in the heat, logistic", "1", 0.01, 1e-6, least(&way.martensite));
            let cosine = Material { kinetics: Kinetics::LiangRogers, ..by(Criterion::LiangRogers) };
            found.nothing("ξ left in the heat, on its own cosine", "1", 1e-9, least(&heated(cosine)?.martensite));
            let loading = superelastic(by(Criterion::LiangRogers), LOOP_MPA)?;
            found.nothing("ξ moved by stress at constant temperature", "1", 0.0, travel(&loading));
            // loaded past all of M's band, cooled from there: nothing is left to meet
            let lost = imposed(
                &in_a_furnace(by(Criterion::LiangRogers), 0.0),
                &[[LOOP_C, 0.0], [LOOP_C, LOOP_MPA], [80.0, LOOP_MPA]],
                STEPS,
            )?;
            found.nothing("ξ gained by cooling, once stress has passed the band", "1", 0.0, travel(&lost));
            draw_loops(found, [("eq. 9", loading), ("eq. 12", superelastic(Material::default(), LOOP_MPA)?)]);
            Ok(())
        }),
        equation(
            10,
            "Brinson's criteria",
            "It goes on while the stress falls between (T − A_s) C_A and (T − A_f) C_A, \
            or rises between (T − M_s) C_M and (T − M_f) C_M.",
        )
        .code(CRITERIA, "Criterion::Brinson")
        .agrees(|_, found| {
            let way = superelastic(by(Criterion::Brinson), LOOP_MPA)?;
            let ((up, full), (down, end)) = (moving(&way, 0)?, moving(&way, 1)?);
            for (what, point, stated) in [
                ("turns martensite from", up, 67.0 + HALF_BAND_K),
                ("turns martensite up to", full, 67.0 - HALF_BAND_K),
                ("turns austenite from", down, 93.0 - HALF_BAND_K),
                ("turns austenite down to", end, 93.0 + HALF_BAND_K),
            ] {
                found.near(&format!("{what}, at 110 °C"), "MPa", line_mpa(stated), 0.7, way.stress_mpa[point]);
            }
            found.nothing("ξ moved by heat under constant stress", "1", 0.0, travel(&heated(by(Criterion::Brinson))?));
            notched(found, "Brinson", Criterion::Brinson)?;
            draw_loops(found, [("eq. 10", way), ("eq. 12", superelastic(Material::default(), LOOP_MPA)?)]);
            Ok(())
        }),
        equation(
            11,
            "Elahinia and Ahmadian's criteria",
            "The direction is that of T − σ/C, so that stress alone moves the phase; still \
            bounded: T between A_s and A_f, or between M_f and A_s, each + σ/C.",
        )
        .code(CRITERIA, "Criterion::ElahiniaAhmadian")
        .differs(
            "the A_s of the second line stands where eq. 9, 10 and 13 have M_s; with A_s \
            the first 4 K of the band would be passed over",
            |_, found| {
                let way = heated(by(Criterion::ElahiniaAhmadian))?;
                let ((up, hot), (down, cold)) = (moving(&way, 0)?, moving(&way, 1)?);
                let seen = |point: usize| way.temperature_c[point] - 12.5;
                found.near("turns austenite from, less σ/C", "°C", 93.0 - HALF_BAND_K, 0.2, seen(up));
                found.near("turns austenite up to", "°C", 93.0 + HALF_BAND_K, 0.2, seen(hot));
                found.near("turns martensite from", "°C", 93.0 - HALF_BAND_K, 0.2, seen(down));
                found.near("turns martensite down to", "°C", 67.0 - HALF_BAND_K, 0.2, seen(cold));
                found.proof();
                found.near("turns martensite from M_s", "°C", 67.0 + HALF_BAND_K, 0.2, seen(down));
                let curve = |criterion| -> Tried<Way> {
                    let cosine = Material { kinetics: Kinetics::LiangRogers, ..by(criterion) };
                    superelastic(Material { outer_loop_weight: 0.0, ..cosine }, LOOP_MPA)
                };
                // where the curve ends at the bounds, eq. 11 is eq. 12
                let (bounded, free) = (curve(Criterion::ElahiniaAhmadian)?, curve(Criterion::DrivingTemperature)?);
                let apart: Vec<f64> =
                    bounded.martensite.iter().zip(&free.martensite).map(|(a, b)| (a - b).abs()).collect();
                found.above("ξ moved by stress alone", "1", 0.99, travel(&bounded));
                found.nothing("from eq. 12, on cosine curves", "1", 1e-5, largest(&apart));
                notched(found, "Elahinia", Criterion::ElahiniaAhmadian)?;
                draw_loops(found, [("eq. 11, cosine", bounded), ("eq. 12, cosine", free)]);
                Ok(())
            },
        ),
        equation(
            12,
            "the direction of transformation",
            "Towards austenite while Ṫ − σ̇/C > 0, towards martensite while it is \
                < 0, without bounds.",
        )
        .code(FORMULAS, "pub fn stress_shift_k")
        .code(KINETICS, "dϑ/dt > 0: towards austenite (eq. 12)")
        .agrees(|_, found| {
            // 1/α = 0.125 K/MPa: 24 MPa count as 3 K
            found.above("martensite gained by + 2 K and + 24 MPa", "1", 0.0, moved(2.0, 24.0)?);
            found.below("martensite gained by + 4 K and + 24 MPa", "1", 0.0, moved(4.0, 24.0)?);
            found.nothing("martensite gained by + 3 K and + 24 MPa", "1", 1e-9, moved(3.0, 24.0)?);
            Ok(())
        }),
        figure(
            10,
            "a calorimeter's curves",
            "Heat flows most where the transformation is fastest: at A on \
                heating, at M on cooling.",
        )
        .code(KINETICS, "pub struct Hysteresis")
        .agrees(|_, found| {
            let way =
                imposed(&in_a_furnace(Material::default(), 1.0), &[[20.0, 0.0], [140.0, 0.0], [20.0, 0.0]], 2400)?;
            let rate = |range: std::ops::Range<usize>| -> (Vec<f64>, Vec<f64>) {
                let of = range.map(|i| {
                    let kelvin = way.temperature_c[i + 1] - way.temperature_c[i];
                    let middle = 0.5 * (way.temperature_c[i + 1] + way.temperature_c[i]);
                    // latent heat of a kelvin's change
                    (middle, -24.2 * (way.martensite[i + 1] - way.martensite[i]) / kelvin.abs())
                });
                of.unzip()
            };
            let (heating, cooling) = (rate(0..2400), rate(2400..4800));
            found.near("most heat taken up at", "°C", 93.0, 0.1, at(&heating.1, &heating.0, largest(&heating.1)));
            found.near("most heat given off at", "°C", 67.0, 0.1, at(&cooling.1, &cooling.0, least(&cooling.1)));
            found.legend(Ink::Series(0), "heating");
            found.legend(Ink::Series(1), "cooling");
            let flow = ("Latent heat taken up, J/(g K)", "1");
            found.line(TEMPERATURE, flow, Ink::Series(0), heating);
            found.line(TEMPERATURE, flow, Ink::Series(1), cooling);
            Ok(())
        }),
    ]
}
