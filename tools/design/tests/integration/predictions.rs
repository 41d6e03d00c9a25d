//! What is predicted is what the simulation of the written rig does.

use crate::random::{KINDS, judge};
use sinew_design::{Design, Motion, Obstacle, Requirement, Source, Task, predict, simulate};

/// Share of the designs that must be within 10 % of the simulation, for each of pull, stroke, heating, cooling, and the first time.
const LEAST_SHARE: f64 = 0.95;

fn within_ten_percent(count: usize, seed: u64) {
    let outcome = judge(count, seed);
    for (i, kind) in KINDS.iter().enumerate() {
        let off: Vec<_> =
            outcome.rows.iter().filter(|row| row.ratios[i].is_nan() || (row.ratios[i] - 1.0).abs() > 0.1).collect();
        let said: Vec<String> = off.iter().map(|row| format!("{}: {:.3}", row.demand, row.ratios[i])).collect();
        let share = 1.0 - off.len() as f64 / count as f64;
        assert!(share >= LEAST_SHARE, "{kind}: {share} of the designs\n{}", said.join("\n"));
    }
}

#[test]
fn thirty_random_designs_do_what_is_predicted() {
    within_ten_percent(30, 3);
}

/// The same of 200; as figures: `cargo run --release -p sinew-design --example demands`.
#[test]
#[ignore = "a minute"]
fn two_hundred_random_designs_do_what_is_predicted() {
    within_ten_percent(200, 1);
}

fn lift(force_n: f64, stroke_m: f64) -> Requirement {
    Requirement::of(Motion::Linear { force_n, stroke_m })
}

/// Where the air is natural convection, the wire hangs on a spring, and the phases mix otherwise, it is predicted as well.
#[test]
fn other_air_loads_and_mixing_are_predicted() {
    let design = Design::of(&lift(0.8, 6e-3), 0.125e-3);
    let tables = [
        "material = { convection = \"natural\" }\n",
        "material = { mixing = \"parallel\", outer_loop_weight = 0.3 }\n",
        "material = { kinetics = \"liang_rogers\" }\n",
    ];
    let hung = design.rig_text.replace("preload_n = ", "spring_n_per_m = 40.0, preload_n = ");
    let texts = tables.iter().map(|table| format!("{}{table}", design.rig_text)).chain([hung]);
    for text in texts {
        let rig = sinew_rig::Rig::parse(&text, "another").unwrap_or_else(|error| panic!("{error}"));
        let stroke_m = 0.85 * sinew_control::StrokeRange::of(&rig.nominal_model(0)).unwrap().stroke_m();
        let said = predict(&rig, stroke_m).unwrap().cycle;
        let done = simulate(&rig, &Task::new(&rig, stroke_m).unwrap()).unwrap().cycle.unwrap();
        for (predicted, simulated) in
            [(said.heating_s, done.heating_s), (said.cooling_s, done.cooling_s), (said.pull_n, done.pull_n)]
        {
            assert!((predicted / simulated - 1.0).abs() < 0.1, "{text}\n{said:?}\n{done:?}");
        }
        assert!((said.hottest_c - done.hottest_c).abs() < 4.0, "{text}\n{said:?}\n{done:?}");
    }
}

/// The voltage a weak supply lacks is right: a little less does not do, a little more does.
#[test]
fn the_voltage_that_is_needed_is_the_one_that_does() {
    let with = |volts: f64| Requirement { source: Source::of_voltage(Some(volts)), ..lift(0.8, 6e-3) };
    for diameter_m in [0.1e-3, 0.15e-3, 0.31e-3] {
        let sinew_design::Shortfall::WeakSupply(needed_v) =
            Design::of(&with(0.5), diameter_m).shortfall.expect("0.5 V is too little")
        else {
            panic!("{diameter_m}: something else is wrong")
        };
        assert!(Design::of(&with(0.97 * needed_v), diameter_m).shortfall.is_some(), "{diameter_m} {needed_v}");
        let enough = Design::of(&with(1.03 * needed_v), diameter_m);
        assert!(enough.shortfall.is_none(), "{diameter_m} {needed_v}: {:?}", enough.shortfall);
    }
}

#[test]
fn a_stroke_the_wire_does_not_have_is_said() {
    let rig = Design::of(&lift(0.8, 6e-3), 0.125e-3).rig().unwrap();
    let Err(Obstacle::TooShort { stroke_m }) = predict(&rig, 8e-3) else { panic!() };
    assert!(predict(&rig, stroke_m).is_ok() && stroke_m > 6e-3, "{stroke_m}");
}
