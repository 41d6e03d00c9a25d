//! Debug.
use sinew_bench::*;
use sinew_physics::Inputs;
fn main() {
    let plant = Plant::named("chapter_9").unwrap();
    let believed = plant.believed(&Choice::default(), 1).unwrap();
    let mut s = Session::new(&believed, &plant.truth(&believed)).unwrap();
    idle(&mut s, 0.5);
    for to in [0.4, 0.8, 0.4, 0.15, 0.3] {
        step(&mut s, to, plant.watch_s, false, |_, _| ());
    }
    let mut free = s.wire().unwrap().clone();
    let inputs = s.inputs().unwrap();
    let r = s.stroke();
    let mut k = 0;
    let reference = r.length_m(0.2);
    step(&mut s, 0.2, 1.0, false, |m, e| {
        free.step(&Inputs { drive: 0.0, ..inputs }, 1e-3);
        let fe = (0.233 + free.position_m() - reference) / r.stroke_m();
        if k % 20 == 0 || (k > 600 && k < 720 && k % 5 == 0) {
            println!(
                "{k} T {:.2} x {:+.3}% duty {:.3}   free T {:.2} x {:+.3}%",
                m.truth.temperature_c,
                100.0 * e,
                m.duty,
                free.temperature_c(),
                100.0 * fe
            );
        }
        k += 1;
    });
}
