//! Steps of the reference wire under every law, noise on: the numbers of docs/control.md.
//!
//! `cargo run -p sinew-control --example step [-- --trace LAW]`

#[path = "../tests/rig/mod.rs"]
mod rig;

use rig::{Bench, CONVERTER, Noise, Step, duty_for_power, figure_wire};
use sinew_control::{AlgorithmKind, Modulation, Settings, default_lambda};

fn main() {
    let var = |k: &str, d: f64| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let model = figure_wire();
    let maximum_duty = duty_for_power(&model, 3.0);
    println!("{:?}", default_lambda(&model, 3.0));
    let lam = var("LAM", 0.0);
    let settings = Settings { maximum_duty, lambda_per_s: (lam > 0.0).then_some(lam),
      kind: match var("KIND", 0.0) as u8 {1=>AlgorithmKind::SlidingMode2Plain,2=>AlgorithmKind::SlidingMode1,3=>AlgorithmKind::Pi,_=>AlgorithmKind::SlidingMode2},
      modulation: if var("SW",0.0)>0.0 {Modulation::Switched} else {Modulation::Duty},
      ..Settings::default() };
    let noise = if var("NN", 0.0) > 0.0 { Noise { voltage_v: 0.0, current_a: 0.0, bits: 24 } } else { CONVERTER };
    let mut plant = model.clone();
    plant.material.convection_w_per_m2_k *= var("H", 1.0);
    plant.material.latent_heat_j_per_kg *= var("LAT", 1.0);
    let stages = [(0.4, 3.0), (0.3, 3.0), (0.7, 3.0), (0.3, 4.0), (0.6, 3.0), (0.2, 4.0)];
    let rate = var("RATE", 1000.0);
    let trace = var("TRACE", 0.0);
    let mut worst = [Step::default(); 6];
    let mut terr: f64 = 0.0; let mut all: Vec<Vec<Step>> = vec![vec![]; 6];
    for seed in (if trace>0.0 {trace as u64} else {1})..=(if trace > 0.0 { trace as u64 } else { var("SEEDS",40.0) as u64 }) {
        let mut b = Bench::new(&plant, &model, &settings, rate, noise, seed);
        for _ in 0..(0.3 * rate) as usize { b.cycle(b.range.cold_m + 1e-3); }
        let mut base = 0.0;
        for (i, &(to, s)) in stages.iter().enumerate() {
            let mut k = 0u32;
            let every = (rate * var("EVERY", 0.03)) as u32;
            let step = b.step_to(to, s, |b, t, e| {
                k += 1;
                if trace > 0.0 && k % every == 0 {
                    let es = &b.estimate;
                    println!("{:.3} {to} e%={:.3} T={:.1} That={:.1} xi={:.3} {:.3} v={:.2} hi={:.1} lo={:.1} duty={:.2}", base + t, e * 100.0, b.wire.temperature_c(), es.temperature_c, b.wire.martensite(), es.martensite, b.wire.velocity_m_s() * 1e3, es.heating_curve_c, es.cooling_curve_c, b.duty());
                }
            });
            base += s;
            all[i].push(step);
            let w = &mut worst[i];
            *w = Step { from: step.from, to, settle_s: w.settle_s.max(step.settle_s), overshoot: w.overshoot.max(step.overshoot), fastest_s: step.fastest_s, bias: w.bias.abs().max(step.bias.abs()), rms: w.rms.max(step.rms) };
        }
        terr = terr.max(b.worst_temperature_error);
    }
    if var("STAT", 1.0) > 0.0 && trace == 0.0 {
        let mut bad = 0;
        for (i, a) in all.iter_mut().enumerate() {
            a.sort_by(|a, b| a.settle_s.total_cmp(&b.settle_s));
            let limit = if i == 0 || i == 2 || i == 4 { 1.2 } else { 1.2 * a[0].fastest_s };
            let b = a.iter().filter(|s| s.settle_s > (if i % 2 == 0 { 1.2 } else { 1.2 * s.fastest_s }) || s.overshoot > 0.01).count();
            bad += b;
            let q = |f: f64| a[((a.len() - 1) as f64 * f) as usize].settle_s;
            print!("[→{:.0} lim {:.2} med {:.2} 90% {:.2} bad {b}] ", a[0].to * 100.0, limit, q(0.5), q(0.9));
        }
        println!("BAD {bad}");
    } else if trace == 0.0 { for w in worst { print!("[{:.0}→{:.0}: {:.2}s ({:.2}) ov {:.2}% b {:.2}] ", w.from * 100.0, w.to * 100.0, w.settle_s, w.fastest_s, w.overshoot * 100.0, w.bias * 100.0); } println!("Terr {terr:.1}"); }
}
