//! The steps of one plant under one choice, compared with the bound: `steps PLANT CONTROLLER ESTIMATOR SENSING SEEDS`.

use sinew_bench::{Choice, Plant, Session, idle, step};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize| arguments.get(i).map(String::as_str).filter(|word| *word != "-");
    let plant = Plant::named(word(0).unwrap_or("figure")).expect("a plant of the bench");
    let choice = Choice::default().with(word(1), word(2), word(3));
    let seeds: u64 = word(4).map_or(1, |word| word.parse().expect("a number of seeds"));
    for seed in 1..=seeds {
        let believed = plant.believed(&choice, seed).unwrap_or_else(|error| panic!("{error}"));
        let mut session = Session::new(&believed, &plant.truth(&believed)).unwrap_or_else(|error| panic!("{error}"));
        idle(&mut session, 0.5);
        for to in [0.4, 0.8, 0.4, 0.15, 0.3, 0.2] {
            let step = step(&mut session, to, plant.watch_s, true, |_, _| ());
            println!(
                "seed {seed}  {:>5.1} -> {:>4.1} %  settled {:>7}  bound {:>7}  ratio {:>5}  overshoot {:.2} %  mean {:+.2} %  rms {:.2} %  cycle {:.2} %  T {:.1} K",
                100.0 * step.from,
                100.0 * step.to,
                step.settle_s.map_or("never".into(), |s| format!("{s:.3} s")),
                step.bound_s.map_or("none".into(), |s| format!("{s:.3} s")),
                step.ratio().map_or("-".into(), |r| format!("{r:.2}")),
                100.0 * step.overshoot,
                100.0 * step.mean,
                100.0 * step.rms,
                100.0 * step.cycle,
                step.temperature_rms_k,
            );
        }
        if let Some(fault) = session.fault() {
            println!("seed {seed}  fault: {fault:?}");
        }
    }
}
