//! Steps of one wire under every law, converter noise on: the command that reproduces the tables of docs/control-laws.md.
//!
//! `cargo run --release -p sinew-control --example step` prints the table, `… --example step -- LAW…` that of some laws on the wire
//! as modelled; `… --example step -- trace LAW RATE_HZ SEED` one run as CSV on stdout. A LAW is its word in the rig file, with
//! `+loss` for the heat loss fed forward (`-loss` for not), `+rapid` for rapid heating and `+whole` for whole periods after it.

#[path = "../tests/integration/rig.rs"]
mod rig;

use rig::{Bench, CONVERTER, STEPS, Step, duty_for_power, figure_wire};
use sinew_control::{AlgorithmKind, EstimatorKind, Modulation, Priming, Settings, default_lambda};
use sinew_physics::WireModel;

/// The default law was not tuned on them.
const SEEDS: std::ops::Range<u64> = 2001..2021;
/// With which options a law is in the table besides as it is.
const OPTIONS: [(&str, &str); 5] = [
    ("sliding_mode", "+whole"),
    ("pi", "+loss"),
    ("pi", "+rapid"),
    ("pid", "+loss"),
    ("input_output_linearised_constant", "-loss"),
];

/// What the table is made of, besides the default law.
fn laws() -> Vec<String> {
    let others = AlgorithmKind::ALL.into_iter().filter(|kind| *kind != AlgorithmKind::TimeOptimal);
    let with_options = |word: &'static str| {
        let options = OPTIONS.into_iter().filter(move |(law, _)| *law == word);
        std::iter::once(word.to_string()).chain(options.map(|(law, option)| format!("{law}{option}")))
    };
    others.flat_map(|kind| with_options(kind.word())).collect()
}

/// A law's settings by its word and options.
fn settings(law: &str, maximum_duty: f64) -> Option<Settings> {
    let word = law.split(['+', '-']).next()?;
    let kind = AlgorithmKind::named(word)?;
    let mut settings = Settings { kind, maximum_duty, ..Settings::default() };
    let mut options = &law[word.len()..];
    while !options.is_empty() {
        let end = options[1..].find(['+', '-']).map_or(options.len(), |end| end + 1);
        match &options[..end] {
            "+loss" => settings.heat_loss_feedforward = Some(true),
            "-loss" => settings.heat_loss_feedforward = Some(false),
            "+rapid" => settings.rapid_heating = Some(Priming::Temperature),
            "+whole" => settings.modulation = Modulation::WholePeriods,
            _ => return None,
        }
        options = &options[end..];
    }
    Some(settings)
}

/// The middle one of the runs. The limits differ from run to run with the state the step before left.
fn median(runs: &[Step], of: impl Fn(&Step) -> f64) -> f64 {
    let mut values: Vec<f64> = runs.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// All steps for all seeds; per step the settling times sorted, the worst overshoot and rms, the limits.
fn table(title: &str, plant: &WireModel, believed: &WireModel, power_w: f64, law: &str, rate_hz: f64, patience: f64) {
    let Some(settings) = settings(law, duty_for_power(believed, power_w)) else { usage() };
    let mut runs: Vec<Vec<Step>> = vec![Vec::new(); STEPS.len()];
    let mut worst_k = 0f64;
    for seed in SEEDS {
        let mut bench =
            Bench::with_estimator(plant, believed, &settings, rate_hz, CONVERTER, seed, EstimatorKind::Fused);
        bench.idle(0.3);
        for (run, &(stroke, seconds)) in runs.iter_mut().zip(&STEPS) {
            run.push(bench.step_to(stroke, patience * seconds, |_, _, _| ()));
        }
        worst_k = worst_k.max(bench.worst_temperature_error);
    }
    let seeds = SEEDS.end - SEEDS.start;
    println!("{title}: {}, {rate_hz} Hz, {seeds} seeds, temperature estimated to {worst_k:.1} K", law);
    for (run, &(stroke, _)) in runs.iter_mut().zip(&STEPS) {
        run.sort_by(|a, b| a.settle_s.total_cmp(&b.settle_s));
        let good = run.iter().filter(|step| step.meets_figure()).count();
        let worst = |f: fn(&Step) -> f64| run.iter().map(f).fold(0f64, f64::max);
        println!(
            "  to {:>3.0} %: settled {:.2} / {:.2} s (median / worst), limit {:.2} s (fastest possible {:.2}, medians), \
             overshoot {:.2} %, rms {:.2} %, figure met {good}/{}",
            stroke * 100.0,
            run[run.len() / 2].settle_s,
            run[run.len() - 1].settle_s,
            median(run, Step::limit_s),
            median(run, |step| step.fastest_s),
            worst(|s| s.overshoot) * 100.0,
            worst(|s| s.rms) * 100.0,
            run.len()
        );
    }
}

fn trace(law: &str, rate_hz: f64, seed: u64) {
    let model = figure_wire();
    let Some(settings) = settings(law, duty_for_power(&model, 3.0)) else { usage() };
    let mut bench = Bench::with_estimator(&model, &model, &settings, rate_hz, CONVERTER, seed, EstimatorKind::Fused);
    println!(
        "time_s,error_percent,temperature_c,estimated_c,heating_curve_c,cooling_curve_c,martensite,estimated,duty"
    );
    bench.idle(0.3);
    let mut start = 0.0;
    for &(stroke, seconds) in &STEPS {
        bench.step_to(stroke, seconds, |bench, t, error| {
            let e = &bench.estimate;
            println!(
                "{:.4},{:.4},{:.3},{:.3},{:.3},{:.3},{:.5},{:.5},{:.4}",
                start + t,
                error * 100.0,
                bench.wire.temperature_c(),
                e.temperature_c,
                e.heating_curve_c,
                e.cooling_curve_c,
                bench.wire.martensite(),
                e.martensite,
                bench.duty()
            );
        });
        start += seconds;
    }
}

fn usage() -> ! {
    eprintln!("usage: step [LAW[+loss|-loss][+rapid][+whole]… | trace LAW RATE_HZ SEED]");
    std::process::exit(2)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let model = figure_wire();
    match &arguments[..] {
        [word, law, rate, seed] if word == "trace" => match (rate.parse(), seed.parse()) {
            (Ok(rate), Ok(seed)) => return trace(law, rate, seed),
            _ => usage(),
        },
        [] => {}
        laws => {
            for law in laws {
                table("as modelled", &model, &model, 3.0, law, 1e3, 1.0);
            }
            return;
        }
    }
    println!("{:#?}", default_lambda(&model, 3.0));
    for rate_hz in [1e3, 2e3, 5e3, 1e4] {
        table("as modelled", &model, &model, 3.0, "time_optimal", rate_hz, 1.0);
    }
    for law in laws() {
        for rate_hz in [1e3, 1e4] {
            table("as modelled", &model, &model, 3.0, &law, rate_hz, 1.0);
        }
    }
    for (title, plant) in rig::misjudged(&model) {
        table(title, &plant, &model, 3.0, "time_optimal", 1e3, 1.0);
    }
    for (title, model, power_w) in rig::other_wires() {
        println!("{title}: {:?}", default_lambda(&model, power_w));
        table(title, &model, &model, power_w, "time_optimal", 1e3, 5.0);
    }
}
