//! The tables of docs/board.md: `cargo run -p sinew-front-end-board --example noise_budget`.

#[path = "common/budget.rs"]
mod budget;

use budget::{CANDIDATES, LENGTH_M, RATE_HZ, SENSING_DUTY, WANTED_M, current_a, rows, shunt_noise_v, sigma_m, total_v};
use sinew_front_end_board::{LEAD_NS, SHUNT_OHM};

const SWITCH_OHM: f64 = 0.05;

fn main() {
    let current_a = current_a(SHUNT_OHM, SWITCH_OHM);
    let on_s = SENSING_DUTY / RATE_HZ;
    let seen_s = on_s - f64::from(LEAD_NS) * 1e-9;
    println!(
        "Sensing pulse {:.0} µs, seen {:.0} µs after its beginning; {:.2} A\n",
        on_s * 1e6,
        seen_s * 1e6,
        current_a
    );
    println!(
        "| converter | inputs, at once | noise, mV | σ of a length, µm | settled to 0.1 % after, µs | missing of the sensing pulse |"
    );
    println!("|---|--:|--:|--:|--:|--:|");
    for candidate in &CANDIDATES {
        println!(
            "| {} | {}, {} | {:.3} | {:.1} | {:.0} | {:.2} % |",
            candidate.name,
            candidate.inputs,
            candidate.at_once,
            candidate.sigma_v() * 1e3,
            sigma_m(candidate.sigma_v(), current_a) * 1e6,
            candidate.settled_s(1e-3) * 1e6,
            candidate.missing(seen_s) * 100.0,
        );
    }
    println!();
    for candidate in &CANDIDATES {
        println!("{}: {}.", candidate.name, candidate.source);
    }
    println!("\n| cause | by | noise, mV | σ of a length, µm |");
    println!("|---|---|--:|--:|");
    let rows = rows();
    let print = |cause: &str, by: &str, noise_v: f64| {
        println!("| {cause} | {by} | {:.4} | {:.2} |", noise_v * 1e3, sigma_m(noise_v, current_a) * 1e6);
    };
    for row in &rows {
        print(row.cause, row.by, row.noise_v);
    }
    print("**board**", "the first four", total_v(&rows[..4]));
    print("**all**", &format!("wanted: {:.0} µm", WANTED_M * 1e6), total_v(&rows));
    println!("\nσ of a current: {:.2} mA. Length {:.0} mm.", shunt_noise_v() / SHUNT_OHM * 1e3, LENGTH_M * 1e3);
}
