//! How well a joint between two wires follows a sine of a quarter of its stroke, by the driver's cycle on the simulated rig:
//! the table in docs/control-laws.md. `cargo run --release -p sinew-lockstep --example joint`

use sinew_backend::{Backend, Sample};
use sinew_driver::{Ask, Beat, Engine, Order};
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

/// Seeds that nothing was tuned on.
const SEEDS: std::ops::Range<u64> = 1000..1005;

fn rig(diameter_mm: f64, supply_v: f64, seed: u64) -> Rig {
    let channel = |name: &str| {
        format!(
            "[[channel]]\nname = \"{name}\"\nwire = {{ diameter_mm = {diameter_mm}, length_mm = 160.0 }}\n\
             taps = {{ ls_mm = 150.0 }}\ndrive = {{ supply_v = {supply_v:.1}, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\n"
        )
    };
    let text = format!(
        "[rig]\nname = \"joint\"\n\n{}{}[[joint]]\nname = \"knee\"\nagonist = \"flexor\"\nantagonist = \"extensor\"\n\
         radius_mm = 8.0\ninertia_kg_mm2 = 2.5\n\n[simulation]\nseed = {seed}\n",
        channel("flexor"),
        channel("extensor")
    );
    Rig::parse(&text, "joint.toml").unwrap_or_else(|e| panic!("{e}"))
}

/// RMS error of the true length in % of the stroke, least and most stress in MPa, over the last two periods or 4 s.
fn track(rig: &Rig, hz: f64) -> [f64; 3] {
    let mut backend = SimulatedRig::new(rig).unwrap_or_else(|e| panic!("{e}"));
    let mut engine = Engine::at_rest(rig, None).unwrap_or_else(|e| panic!("{e}"));
    backend.start().unwrap_or_else(|e| panic!("{e}"));
    let stroke = engine.channels()[0].stroke_range();
    let area_m2 = rig.channels[0].model.geometry.area_m2();
    let mut duty = [0.0; 2];
    let mut samples = [Sample::NONE; 2];
    let judged = (2.0 / hz).max(4.0);
    let seconds = 5.0 + judged.max(1.0 / hz) + 1.0 / hz;
    let (mut sum, mut count, mut least, mut most) = (0.0, 0.0, f64::INFINITY, 0.0_f64);
    for tick in 0..(seconds * rig.rate_hz) as u64 {
        let time = tick as f64 / rig.rate_hz;
        let exchanged = backend.exchange(&duty, &mut samples);
        let wanted = 0.5 + 0.125 * (std::f64::consts::TAU * hz * time).sin();
        let now_ns = (time * 1e9) as u64;
        let ask = Ask::Length(stroke.length_m(wanted));
        engine.take(&Order { ticket: 0, channel: 0, ask, hold_ns: u64::MAX }, now_ns);
        engine.cycle(Beat { now_ns, missed: 0 }, exchanged, &samples, &mut duty, |_| {});
        if time > seconds - judged
            && let Some(truth) = backend.truth(0)
        {
            sum += (stroke.stroke(truth.length_m) - wanted).powi(2);
            count += 1.0;
            let mpa = truth.force_n / area_m2 * 1e-6;
            (least, most) = (least.min(mpa), most.max(mpa));
        }
    }
    [100.0 * (sum / count).sqrt(), least, most]
}

fn main() {
    println!("| wire, supply | Hz | RMS error, median (worst) of {} seeds | stress |", SEEDS.end - SEEDS.start);
    println!("|---|---|---|---|");
    for (diameter_mm, supply_v) in [(0.125, 9.0), (0.05, 12.0), (0.025, 24.0)] {
        for hz in [0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0] {
            let mut runs: Vec<_> = SEEDS.map(|seed| track(&rig(diameter_mm, supply_v, seed), hz)).collect();
            runs.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let (median, worst) = (runs[runs.len() / 2], runs[runs.len() - 1]);
            println!(
                "| {diameter_mm} mm, {supply_v} V | {hz} | {:.2} % ({:.2} %) | {:.0} to {:.0} MPa |",
                median[0], worst[0], median[1], median[2]
            );
        }
    }
}
