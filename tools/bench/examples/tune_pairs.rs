//! Gains of the laws of a joint that have any, each found with the same number of tries: `tune_pairs [TRIES] [LAW…]`. A try is a set of gains
//! drawn from the same ranges for all, run through the steps of the bench and two sines on seeds to develop with; what counts is the mean of
//! what a score counts. The laws without lengths are tuned where a resistance says one. Their files in `control/src/joint/` carry what was found.

use rayon::prelude::*;
use sinew_bench::row::STEPS;
use sinew_bench::{Choice, Plant, Session, idle, score, sine, step};

/// Seeds of a try.
const SEEDS: std::ops::Range<u64> = score::DEVELOPMENT..score::DEVELOPMENT + 2;
/// From what gains are drawn, the same share of each decade: what an error of the whole stroke is answered with, integral and derivative time, s.
const RANGES: [(f64, f64); 3] = [(0.3, 100.0), (0.05, 10.0), (0.002, 0.2)];
/// What is wanted of steady error, overshoot and sines of 0.25 and 1 Hz, shares of the stroke.
const WANTED: [f64; 4] = [0.003, 0.005, 0.004, 0.004];

/// A number from 0 to 1 of a place in a sequence, the same on every run: van der Corput's, in the base of its dimension.
fn spread(mut place: usize, base: usize) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while place > 0 {
        share /= base as f64;
        value += share * (place % base) as f64;
        place /= base;
    }
    value
}

/// How far a law with these gains is from what is wanted: 1 and less is there.
fn cost(plant: &Plant, law: &str, gains: [f64; 3], seed: u64) -> f64 {
    let choice = Choice { controller: law.into(), estimator: "joint".into(), sensing: "dual".into() };
    let mut rig = plant.believed(&choice, seed).unwrap_or_else(|error| panic!("{error}"));
    let stroke_m = Session::new(&rig, &plant.truth(&rig)).unwrap_or_else(|error| panic!("{error}")).stroke().stroke_m();
    let (proportional, joint) = (gains[0] / stroke_m, &mut rig.joints[0]);
    joint.proportional_per_m = Some(proportional);
    joint.integral_per_m_s = Some(proportional / gains[1]);
    joint.derivative_s_per_m = Some(proportional * gains[2]);
    let mut session = Session::new(&rig, &plant.truth(&rig)).unwrap_or_else(|error| panic!("{error}"));
    idle(&mut session, 0.5);
    let steps = STEPS.map(|to| step(&mut session, to, 3.0, false, |_, _| ()));
    let mean = |of: fn(&sinew_bench::Step) -> f64| steps.iter().map(of).sum::<f64>() / steps.len() as f64;
    let found = [
        mean(|step| step.rms),
        mean(|step| step.overshoot),
        sine(&mut session, 0.5, 0.25, 0.25).rms,
        sine(&mut session, 0.5, 0.25, 1.0).rms,
    ];
    if session.fault().is_some() {
        return score::WORST;
    }
    let shares = found.iter().zip(WANTED).map(|(found, wanted)| (found / wanted).min(10.0 * score::WORST));
    shares.sum::<f64>() / found.len() as f64
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let tries = arguments.next().map_or(40, |word| word.parse().expect("a number of tries"));
    let asked: Vec<String> = arguments.collect();
    let with_gains = sinew_rig::JointAlgorithm::ALL.into_iter().filter(|(_, law)| law.takes("pi_proportional_per_mm"));
    for (law, _) in with_gains.filter(|(word, _)| asked.is_empty() || asked.iter().any(|asked| asked == word)) {
        let plant = Plant::named(if law.contains("resistance") { "pair_athermal" } else { "pair" }).expect("a plant");
        let mut found: Vec<(f64, [f64; 3])> = (1..=tries)
            .into_par_iter()
            .map(|place| {
                let drawn = |k: usize| {
                    let (low, high) = RANGES[k];
                    low * (high / low).powf(spread(place, [2, 3, 5][k]))
                };
                let gains = [drawn(0), drawn(1), drawn(2)];
                (SEEDS.map(|seed| cost(plant, law, gains, seed)).sum::<f64>() / SEEDS.count() as f64, gains)
            })
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (cost, [proportional, integral_s, derivative_s]) in found.iter().take(3) {
            println!(
                "{law} on {}: {cost:.2} with {proportional:.2} / S, {integral_s:.2} s, {derivative_s:.3} s",
                plant.name
            );
        }
        println!("{law} at worst: {:.2}", found.last().map_or(f64::NAN, |(cost, _)| *cost));
    }
}
