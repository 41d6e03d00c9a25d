//! Random demands, designed, predicted, and judged by the simulation of the rig that is written: how often both agree within 10 %.
//!
//! `cargo run --release -p sinew-design --example demands -- [COUNT [SEED]]`; 200 and 1 without.

#[path = "../tests/integration/random.rs"]
mod random;

use random::{KINDS, Outcome, judge};

fn main() {
    let number =
        |nth: usize, otherwise: u64| std::env::args().nth(nth).and_then(|text| text.parse().ok()).unwrap_or(otherwise);
    let (count, seed) = (number(1, 200) as usize, number(2, 1));
    let Outcome { rows, refused } = judge(count, seed);
    println!("demand, pull, stroke, heating, cooling, first: predicted over simulated");
    for row in &rows {
        let ratios: Vec<String> = row.ratios.iter().map(|ratio| format!("{ratio:.3}")).collect();
        println!("{:60} {}", row.demand, ratios.join(" "));
    }
    println!(
        "{} designs of {} demands; for the others no wire does all that is asked",
        rows.len(),
        rows.len() + refused
    );
    for (i, kind) in KINDS.iter().enumerate() {
        let mut off: Vec<f64> = rows.iter().map(|row| (row.ratios[i] - 1.0).abs()).collect();
        off.sort_by(f64::total_cmp);
        let within = off.iter().filter(|off| **off <= 0.1).count();
        println!(
            "{kind:8} within 10 %: {within} of {}; off by {:.2} % (median), {:.2} % (most)",
            off.len(),
            100.0 * off[off.len() / 2],
            100.0 * off[off.len() - 1]
        );
    }
}
