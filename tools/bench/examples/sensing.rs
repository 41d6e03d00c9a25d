//! Prints the experiment of chapter 7: `cargo run --release -p sinew-bench --example sensing [SEED] [--json]`.

use serde::Serialize;
use sinew_bench::sensing::{Plan, experiment};
use sinew_control::EstimatorKind;

/// The word a choice has in JSON.
fn word(value: &impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(String::from)).unwrap_or_default()
}

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let json = arguments.iter().position(|a| a == "--json").map(|at| arguments.remove(at)).is_some();
    let seed = arguments.first().and_then(|a| a.parse().ok()).unwrap_or(1000);
    let report = experiment(&Plan::new(seed, EstimatorKind::ALL.map(|kind| (kind.word().into(), kind)).to_vec()));
    if json {
        println!("{}", serde_json::to_string_pretty(&report).expect("numbers and words"));
        return;
    }
    let thesis = report.thesis;
    println!(
        "thesis: dual {} mm, {} % of the stroke; resistance {} %",
        thesis.dual_mm, thesis.dual_percent, thesis.resistance_percent
    );
    for noise in &report.noises {
        println!("noise {}: {:.3} mV, {:.3} mA rms", noise.name, 1e3 * noise.voltage_v, 1e3 * noise.current_a);
    }
    println!("\n| noise | taps | heating | dual mm | dual % | resistance % |\n|---|---|---|--:|--:|--:|");
    for s in &report.summary {
        let (taps, heating) = (word(&s.taps), word(&s.heating));
        println!(
            "| {} | {taps} | {heating} | {:.3} | {:.2} | {:.1} |",
            s.noise, s.dual_mm, s.dual_percent, s.resistance_percent
        );
    }
    println!(
        "\n| condition | noise | taps | heating | gf | estimator | rms mm | max mm | bias mm | rms % | max % | lost % | \
         rms mm while lost |\n|---|---|---|---|--:|---|--:|--:|--:|--:|--:|--:|--:|"
    );
    for r in &report.rows {
        println!(
            "| {} | {} | {} | {} | {} | {} | {:.3} | {:.3} | {:+.3} | {:.2} | {:.1} | {:.1} | {} |",
            word(&r.condition),
            r.noise,
            word(&r.taps),
            word(&r.heating),
            r.load_gf,
            r.estimator,
            r.rms_mm,
            r.max_mm,
            r.bias_mm,
            r.rms_percent,
            r.max_percent,
            r.lost_percent,
            r.rms_while_lost_mm.map_or("–".into(), |rms| format!("{rms:.3}")),
        );
    }
}
