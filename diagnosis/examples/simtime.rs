//! dev
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let rig = sinew_rig::Rig::load(std::path::Path::new(&a[1])).unwrap();
    let m0 = rig.channels[0].model.clone();
    let r = sinew_recording::read(
        std::path::Path::new(&a[2]),
        &sinew_recording::Options { model: Some(&m0), ..Default::default() },
    )
    .unwrap();
    let inputs: Vec<_> = r.inputs_for(&m0).unwrap().collect();
    let time = |m: &sinew_physics::WireModel| {
        let mut best = 1e9f64;
        for _ in 0..4 {
            let t = Instant::now();
            let mut w = sinew_physics::Wire::with_inputs(m, &inputs[0].0).unwrap();
            let mut s = 0.0;
            for (i, dt) in &inputs {
                w.step(i, *dt);
                s += w.outputs().position_m;
            }
            std::hint::black_box(s);
            best = best.min(t.elapsed().as_secs_f64() * 1e3);
        }
        best
    };
    let base = time(&m0);
    println!("reference {base:.1} ms");
    for e in sinew_physics::effects::catalogue() {
        let mut m = m0.clone();
        for p in e.parameters {
            let v = p.plausible.0 + 0.3 * (p.plausible.1 - p.plausible.0);
            let v = if p.key == "start_s" {
                10.0
            } else if p.key == "end_s" {
                30.0
            } else {
                v
            };
            (p.set)(&mut m, v);
        }
        if m.validate().is_err() {
            println!("{} invalid", e.id);
            continue;
        }
        println!("{} {:.1} x", e.id, time(&m) / base);
    }
}
