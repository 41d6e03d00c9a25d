//! The smallest possible tracking error of a plant's wire on the bench's sines: `follow [PLANT]`.

use sinew_bench::{Choice, Plant, follow, row};
use sinew_control::StrokeRange;
use sinew_physics::Wire;

fn main() {
    let name = std::env::args().nth(1).unwrap_or("figure".into());
    let plant = Plant::named(&name).expect("a plant of the bench");
    let believed = plant.believed(&Choice::default(), 1).expect("a rig");
    let truth = plant.truth(&believed);
    let model = &truth.channels[0].model;
    for frequency_hz in [0.25, 0.5, 1.0, 2.0, 4.0] {
        let course = follow::Course {
            range: StrokeRange::of(model).expect("a stroke"),
            rest_m: model.geometry.length_m,
            middle: row::SINE_MIDDLE,
            swing: row::SINE_SWING,
            frequency_hz,
            max_duty: believed.channels[0].limits.max_duty,
            inputs: model.rest_inputs(),
        };
        let start = std::time::Instant::now();
        let least = follow::least_error(&Wire::new(model).expect("a wire"), &course);
        println!("{frequency_hz} Hz: {:.2} % of the stroke ({:.1} s)", 100.0 * least, start.elapsed().as_secs_f64());
    }
}
