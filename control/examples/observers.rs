//! The estimates for a wire compared with the truth: the command that reproduces the numbers of docs/control-laws.md,
//! "Linear models and observers".
//!
//! `cargo run --release -p sinew-control --example observers` prints the tables;
//! `… --example observers -- trace` one run of steps as CSV on stdout.

#[path = "../tests/integration/observing.rs"]
mod observing;
#[path = "../tests/integration/rig.rs"]
mod rig;

use observing::{ESTIMATORS, Watch, draught, table_10, transients};
use rig::{CONVERTER, figure_wire};
use sinew_physics::WireModel;

/// None of them was looked at while the observers were written.
const SEEDS: std::ops::Range<u64> = 4001..4011;

fn main() {
    let model = figure_wire();
    if std::env::args().nth(1).as_deref() == Some("trace") {
        let mut watch = Watch::new(&model, &model, 1e3, CONVERTER, 1);
        println!("time_s,temperature_c,martensite,constant_c,constant,scheduled_c,scheduled,enthalpy_c,enthalpy");
        for k in 0..12_000 {
            let t = f64::from(k) * 1e-3;
            let stroke = if t % 4.0 < 2.0 { 0.3 } else { 0.7 };
            watch.cycle(watch.bench.range.length_m(stroke));
            print!("{t:.3},{:.3},{:.5}", watch.bench.wire.temperature_c(), watch.bench.wire.martensite());
            for estimate in &watch.estimates {
                print!(",{:.3},{:.5}", estimate.temperature_c, estimate.martensite);
            }
            println!();
        }
        return;
    }
    compare("0.125 mm × 160 mm, 0.2 kg hanging, 40 N s/m", &model);
    compare("table 10: 0.1 mm × 233 mm, 0.13 kg, 0.915 N s/m, 18 N/m", &table_10());
}

/// Errors of every estimator on one wire, means over the seeds.
fn compare(title: &str, model: &WireModel) {
    let count = (SEEDS.end - SEEDS.start) as f64;
    let mut steps = vec![(0.0, 0.0); ESTIMATORS.len()];
    let mut blown = vec![(0.0, 0.0, 0.0); ESTIMATORS.len()];
    let mut truth = 0.0;
    for seed in SEEDS {
        for (sum, off) in steps.iter_mut().zip(transients(&mut Watch::new(model, model, 1e3, CONVERTER, seed))) {
            sum.0 += off.martensite / count;
            sum.1 += off.temperature_k / count;
        }
        let found = draught(&mut Watch::new(model, model, 1e3, CONVERTER, seed));
        truth += found.truth_k / count;
        for (i, sum) in blown.iter_mut().enumerate() {
            sum.0 += found.changes_k[i] / count;
            sum.1 += found.errors_k[i] / count;
            sum.2 += found.martensite_errors[i] / count;
        }
    }
    println!("{title}, PI at 1 kHz, {count} seeds");
    println!("  steps between 30 % and 70 % of the stroke, rms:");
    for ((name, _), (martensite, temperature)) in ESTIMATORS.iter().zip(&steps) {
        println!("    {name:<22} martensite {:.2} %, temperature {temperature:.1} K", martensite * 100.0);
    }
    println!("  a draught of 50 %: from 2.0 to 2.5 s the wire is {truth:+.1} K from before, on average");
    for ((name, _), (change, error, martensite)) in ESTIMATORS.iter().zip(&blown) {
        let martensite = martensite * 100.0;
        println!(
            "    {name:<22} believes {change:+.1} K; after 3 s {error:+.1} K and {martensite:+.2} % martensite off"
        );
    }
}
