//! Chapter 4: treatment, training and fatigue.

use sinew_design::WireRules;
use sinew_physics::effects::TrainingDrift;
use sinew_physics::formulas::{BREAK_IN_CYCLES, CycleUse, cycles_to_failure};
use sinew_physics::{Material, WireModel};
use sinew_plot::Ink;

use crate::axes::TEMPERATURE;
use crate::chapter::Chapter::Four;
use crate::chapter::Place::Figure;
use crate::found::Tried;
use crate::row::Row;
use crate::wires::{imposed, in_a_furnace};

const LIFE: &str = "model/physics/src/formulas/life.rs";

/// Cycles over which the wire of figure 31 settles: after three times as many 95 % of it is done.
const SETTLES_AFTER: f64 = 10.0;
/// What its first cycle moves its temperatures by, K: a size that rigs show, for the picture has no scale.
const FIRST_SHIFT_K: f64 = -0.8;
/// Steps from one end of a cycle to the other.
const STEPS: usize = 400;

/// Where half of the wire is austenite on the way up, °C, in each of so many cycles between 20 and 140 °C under 100 MPa, of a wire whose
/// temperatures settle after so many.
fn turns_c(cycles: usize, settles_after_cycles: f64) -> Tried<Vec<f64>> {
    let mut model: WireModel = in_a_furnace(Material::default(), 1.0);
    model.effects.kinetic.training_drift = TrainingDrift { kelvin_per_cycle: FIRST_SHIFT_K, settles_after_cycles };
    let corners: Vec<[f64; 2]> = (0..=2 * cycles).map(|k| [if k % 2 == 0 { 20.0 } else { 140.0 }, 100.0]).collect();
    let way = imposed(&model, &corners, STEPS)?;
    let half = |cycle: usize| -> Tried<f64> {
        let from = 2 * cycle * STEPS;
        let up = from..=from + STEPS;
        let after = up.clone().find(|i| way.martensite[*i] < 0.5).ok_or("it does not turn")?;
        let before = after.checked_sub(1).ok_or("it has turned before")?;
        let (a, b) = (way.martensite[before], way.martensite[after]);
        let share = (a - 0.5) / (a - b);
        Ok(way.temperature_c[before] + share * (way.temperature_c[after] - way.temperature_c[before]))
    };
    (0..cycles).map(half).collect()
}

pub(crate) fn rows() -> Vec<Row> {
    let figure = |number, title, states| Row::new(Four, Figure(number), title, states);
    vec![
        figure(28, "alloy and M_s", "A few per cent of nickel move M_s over a large range; of others.")
            .not_given("the points: the picture is from the literature"),
        figure(
            29,
            "annealing temperature",
            "Transformation temperature rises with it and recovery stress falls; \
                of others.",
        )
        .not_given("the points: the picture is from the literature"),
        figure(30, "annealing temperature and time", "Both lower plateau stress and strength; of others.")
            .not_given("the surfaces: the picture is from the literature"),
        figure(
            31,
            "two-way training",
            "It is done after some 30 cycles, and lowers the transition \
            temperature.",
        )
        .code("model/physics/src/effects/kinetic.rs", "pub struct TrainingDrift")
        .code(LIFE, "pub fn settled")
        .agrees(|_, found| {
            let turns = turns_c(100, SETTLES_AFTER)?;
            let (first, last) = (turns[0], turns[99]);
            let share = |n: usize| (turns[n] - first) / (last - first);
            found.below("shift of the transition over the training", "K", -5.0, last - first);
            found.near(
                "the same, of the rate and N_0 that are chosen here",
                "K",
                FIRST_SHIFT_K * SETTLES_AFTER,
                0.5,
                last - first,
            );
            found.between("of it done after 10 cycles", "1", 0.58, 0.68, share(10));
            found.above("of it done after 30 cycles", "1", 0.94, share(30));
            found.nothing("shift from cycle 98 to 99", "K", 1e-3, turns[99] - turns[98]);
            // chapter 4's 150 cycles are a wire that settles five times as slowly
            let slow = turns_c(160, BREAK_IN_CYCLES.1 / 3.0)?;
            let done = (slow[150] - slow[0]) / (FIRST_SHIFT_K * BREAK_IN_CYCLES.1 / 3.0);
            found.between("of a slow wire's shift done after 150", "1", 0.93, 0.97, done);
            let cycles: Vec<f64> = (0..turns.len()).map(|n| n as f64).collect();
            found.line(("Cycle", "1"), TEMPERATURE, Ink::Series(0), (cycles, turns));
            Ok(())
        }),
        figure(
            32,
            "fatigue by strain",
            "Life falls with strain, and with how much of the transformation is \
            used.",
        )
        .code(LIFE, "pub fn cycles_to_failure")
        .code("tools/life/src/account.rs", "pub struct Account")
        .agrees(|_, found| {
            let life = |strain: f64, share: f64| cycles_to_failure(&CycleUse { strain, share, ..CycleUse::TABLE });
            let whole = life(0.04, 1.0);
            // the picture's points are not given: what the text and table 3 say of it
            found.near("4 % at 170 MPa, at least (table 3: 100 000)", "1", 1e5, 1.0, whole.least);
            found.near("the same, at most (to a million)", "1", 1e6, 10.0, whole.most);
            let easier = cycles_to_failure(&CycleUse { peak_stress_pa: 100e6, ..CycleUse::TABLE });
            found.above("4 % near 100 MPa, at least (1e5 or more)", "1", 1e5, easier.least);
            found.near("0.5 % (10^7 only below it)", "1", 1e7, 10.0, life(0.005, 1.0).cycles);
            found.below("1 %", "1", 1e7, life(0.01, 1.0).cycles);
            found.above(
                "half of the transformation, over all of it at the same strain",
                "1",
                1.5,
                life(0.02, 0.5).cycles / life(0.02, 1.0).cycles,
            );
            found.near("polished over rough, the most over the least", "1", 10.0, 1e-6, whole.most / whole.least);
            let burnt = cycles_to_failure(&CycleUse { overheated: 1.0, ..CycleUse::TABLE });
            found.equal("at 300 °C, where the shape is lost", "1", 1.0, burnt.cycles);
            let strains: Vec<f64> = (0..=60).map(|k| 0.002 * 30f64.powf(f64::from(k) / 60.0)).collect();
            let falls = strains.windows(2).all(|pair| life(pair[1], 1.0).cycles < life(pair[0], 1.0).cycles);
            found.equal("falls with strain everywhere", "1", 1.0, f64::from(u8::from(falls)));
            let up = ("Cycles to failure, log10", "1");
            let mut draw = |ink: Ink, name: &str, of: &dyn Fn(f64) -> f64| {
                found.line(
                    ("Strain", "1"),
                    up,
                    ink,
                    (strains.clone(), strains.iter().map(|e| of(*e).log10()).collect()),
                );
                found.legend(ink, name);
            };
            draw(Ink::Series(0), "all of the transformation", &|e| life(e, 1.0).cycles);
            draw(Ink::Series(1), "half of it", &|e| life(e, 0.5).cycles);
            draw(Ink::Measured, "all of it: what nearly every wire lasts", &|e| life(e, 1.0).least);
            Ok(())
        }),
        figure(
            33,
            "bending",
            "Beyond 1 % of strain in the outer fibre life is short: bend to no \
                less than 50 diameters.",
        )
        .code("tools/design/src/rules.rs", "pub fn bend_radius_m")
        .agrees(|_, found| {
            let wire = WireRules::of(0.25e-3, 0.1);
            found.near(
                "strain of the outer fibre at the least radius",
                "%",
                1.0,
                1e-9,
                100.0 * 0.5 * wire.diameter_m / wire.bend_radius_m(),
            );
            Ok(())
        }),
    ]
}
