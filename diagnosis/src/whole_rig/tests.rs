use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use sinew_recording::{Column, Recording, simulated_together};
use sinew_rig::Rig;

use super::*;
use crate::testing::{NOISE, RIG, stairs};

/// Two wires like the one on the bench, which share what `change` makes of the rig.
fn rig(change: impl Fn(&mut Rig)) -> Rig {
    let (head, wire) = RIG.split_once("[[channel]]").expect("a channel");
    let wires = ["left", "right"].map(|name| format!("[[channel]]{}", wire.replace("\"wire\"", &format!("{name:?}"))));
    let mut rig = Rig::parse(&format!("{head}{}{}", wires[0], wires[1]), "rig.toml").expect("a rig");
    change(&mut rig);
    rig
}

/// One run of both wires of a true rig under programmes of their own, with every sensor and its noise.
fn recorded(truth: &Rig, seed: u64) -> Vec<WireRecordings> {
    let times: Vec<f64> = (0..3000).map(|i| f64::from(i) / 100.0).collect();
    let programme = |wire: usize| -> Vec<f64> {
        times.iter().map(|t| stairs(t * (1.0 - 0.2 * wire as f64) + 7.0 * wire as f64)).collect()
    };
    let mut run: Vec<(usize, Recording)> = (0..2)
        .map(|wire| {
            let mut recording = Recording::new(format!("run-{wire}.csv"), times.clone()).expect("times");
            recording.set(Column::Duty, programme(wire)).expect("a duty");
            (wire, recording)
        })
        .collect();
    let inputs: Vec<(usize, &Recording)> = run.iter().map(|(wire, recording)| (*wire, recording)).collect();
    let seen = simulated_together(truth, &inputs).expect("wires");
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    for ((_, recording), rows) in run.iter_mut().zip(seen) {
        for (column, rms) in NOISE {
            let mut noisy = |outputs: &sinew_physics::Outputs| {
                column.of_outputs(outputs).expect("an output") + rms * random.sample::<f64, _>(StandardNormal)
            };
            let values = rows.iter().map(|(_, outputs)| noisy(outputs)).collect();
            recording.set(column, values).expect("a column");
        }
    }
    run.into_iter()
        .map(|(channel, recording)| WireRecordings { channel, recordings: vec![recording], held_out: Vec::new() })
        .collect()
}

fn answer(truth: &Rig, seed: u64) -> RigDiagnosis {
    let settings = Settings { seed: 1, jobs: 0, thorough: false, progress: &|_, _| () };
    let outcome = diagnose_rig(&rig(|_| ()), &recorded(truth, seed), &settings).expect("an answer");
    println!("{}\n{:#?}\n{:#?}", outcome.diagnosis.summary, outcome.diagnosis.shared, outcome.diagnosis.tried);
    outcome.diagnosis
}

fn share_a_supply(rig: &mut Rig) {
    for channel in &mut rig.channels {
        channel.model.effects.electrical.supply_sag.source_ohm = 0.3;
        channel.supply = Some("bench".to_string());
    }
}

fn heat_each_other(rig: &mut Rig) {
    let names: Vec<String> = rig.channels.iter().rev().map(|channel| channel.name.clone()).collect();
    for (channel, other) in rig.channels.iter_mut().zip(names) {
        channel.model.effects.thermal.neighbour.conductance_w_per_k = 0.001;
        channel.neighbour = Some(other);
    }
}

/// That one finding is confirmed and its interval holds the truth, give or take as much again.
fn assert_shared(answer: &RigDiagnosis, id: &str, key: &str, truth: f64) {
    let confirmed: Vec<&SharedFinding> =
        answer.shared.iter().filter(|finding| finding.grade != Grade::Suspected).collect();
    assert_eq!(confirmed.iter().map(|finding| finding.id.as_str()).collect::<Vec<_>>(), [id], "{}", answer.summary);
    let size = &confirmed[0].parameters[key];
    let reach = size.high - size.low;
    assert!((size.value - truth).abs() < reach, "{size:?}");
    assert!(reach < 0.5 * truth, "{size:?}");
    assert_eq!(answer.verdict, Verdict::PhysicsMissing);
}

fn assert_no_effects(answer: &RigDiagnosis) {
    for (name, diagnosis) in &answer.channels {
        let named: Vec<&str> =
            diagnosis.effects.iter().filter(|e| e.grade != Grade::Suspected).map(|e| e.id.as_str()).collect();
        assert!(named.is_empty(), "{name}: {named:?}");
    }
}

#[test]
fn wires_that_heat_each_other_share_that() {
    let answer = answer(&rig(heat_each_other), 2);
    assert_shared(&answer, "shared.neighbour_heating", "conductance_w_per_k", 0.001);
    assert_no_effects(&answer);
}

#[test]
fn wires_that_have_nothing_in_common_share_nothing() {
    let answer = answer(&rig(|_| ()), 3);
    assert_eq!(answer.shared, []);
    assert_no_effects(&answer);
}

#[test]
fn what_one_wire_has_alone_is_its_own() {
    let truth = rig(|rig| rig.channels[1].model.effects.mechanical.friction.coulomb_n = 0.12);
    let answer = answer(&truth, 4);
    assert_eq!(answer.shared, []);
    assert_eq!(answer.channels["right"].effects[0].id, "mechanical.friction");
    assert_eq!(answer.channels["left"].verdict, Verdict::Agrees);
}

#[test]
fn a_shared_supply_is_found_beside_what_one_wire_has_alone() {
    let truth = rig(|rig| {
        share_a_supply(rig);
        rig.channels[0].model.effects.mechanical.friction.coulomb_n = 0.12;
    });
    let answer = answer(&truth, 5);
    assert_shared(&answer, "shared.supply_resistance", "source_ohm", 0.3);
    assert_eq!(answer.channels["left"].effects[0].id, "mechanical.friction");
}

#[test]
fn wires_need_company_and_the_same_runs() {
    let rig = rig(|_| ());
    let settings = Settings { seed: 1, jobs: 1, thorough: false, progress: &|_, _| () };
    let mut wires = recorded(&rig, 1);
    wires[1].recordings.clear();
    assert!(matches!(diagnose_rig(&rig, &wires, &settings), Err(Error::UnevenWires { .. })));
    wires.pop();
    assert!(matches!(diagnose_rig(&rig, &wires, &settings), Err(Error::FewWires { found: 1 })));
}

/// Moves every parameter of every wire to where its prior says it may be, within two σ.
fn off_by_tolerances(rig: &mut Rig, seed: u64) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    for channel in 0..rig.channels.len() {
        for (key, prior) in rig.channels[channel].priors_in_force() {
            let Some(value) = rig.parameter(channel, &key) else { continue };
            let moved = value + prior.sigma(value) * random.sample::<f64, _>(StandardNormal).clamp(-2.0, 2.0);
            // the room is the same for all wires
            if key != "ambient_c" {
                rig.set_parameter(channel, &key, moved).expect("a value a wire can have");
            }
        }
    }
}

/// How often what is shared is found, and how often where there is nothing. `SEEDS=1-8 cargo test --release -p
/// sinew-diagnosis --lib whole_rig::tests::how_often -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes: it counts, and asserts nothing of a single case"]
fn how_often_what_is_shared_is_found() {
    let seeds = std::env::var("SEEDS").unwrap_or_else(|_| "1-4".to_string());
    let (first, last) = seeds.split_once('-').expect("SEEDS=FIRST-LAST");
    let [first, last] = [first, last].map(|seed| seed.parse::<u64>().expect("a seed"));
    let wanted = std::env::var("KINDS").unwrap_or_else(|_| "nothing supply neighbours friction".to_string());
    for kind in wanted.split(' ') {
        let mut right = 0;
        for seed in first..=last {
            let truth = rig(|rig| {
                off_by_tolerances(rig, seed);
                match kind {
                    "supply" => share_a_supply(rig),
                    "neighbours" => heat_each_other(rig),
                    "friction" => rig.channels[1].model.effects.mechanical.friction.coulomb_n = 0.12,
                    _ => {}
                }
            });
            let settings = Settings { seed: 1, jobs: 0, thorough: false, progress: &|_, _| () };
            let began = std::time::Instant::now();
            let found =
                diagnose_rig(&rig(|_| ()), &recorded(&truth, 100 + seed), &settings).expect("an answer").diagnosis;
            let shared: Vec<String> = found
                .shared
                .iter()
                .map(|finding| format!("{:?} {} {:?}", finding.grade, finding.id, finding.parameters.values()))
                .collect();
            let confirmed: Vec<&str> =
                found.shared.iter().filter(|f| f.grade != Grade::Suspected).map(|f| f.id.as_str()).collect();
            let expected: &[&str] = match kind {
                "supply" => &["shared.supply_resistance"],
                "neighbours" => &["shared.neighbour_heating"],
                _ => &[],
            };
            right += usize::from(confirmed == expected);
            let wires: Vec<String> = found
                .channels
                .iter()
                .map(|(name, wire)| {
                    let named: Vec<&str> = wire.effects.iter().map(|effect| effect.id.as_str()).collect();
                    format!("{name} {} {named:?} chi {:.2}", wire.verdict.name(), wire.remains.chi)
                })
                .collect();
            println!("{kind} {seed} {:.0} s: {shared:?}; {wires:?}", began.elapsed().as_secs_f64());
        }
        println!("{kind}: what is shared right in {right} of {}", last - first + 1);
    }
}
