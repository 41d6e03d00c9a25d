//! Random demands, and how predictions compare with the simulation of the rig that is written. The ranges were chosen before the
//! first run.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use sinew_design::{
    Cycle, Joint, Method, Motion, Requirement, Route, STOCK_DIAMETERS_M, Source, Task, best, designs, simulate,
};

/// What is compared.
pub const KINDS: [&str; 5] = ["pull", "stroke", "heating", "cooling", "first"];

/// One design: what was asked for, and what is predicted over what is simulated, in the order of [`KINDS`].
pub struct Row {
    pub demand: String,
    pub ratios: [f64; 5],
}

/// All of them.
pub struct Outcome {
    pub rows: Vec<Row>,
    /// Demands that no wire meets.
    pub refused: usize,
}

/// One of these, each as likely.
fn one_of<T: Copy>(random: &mut Xoshiro256PlusPlus, of: &[T]) -> T {
    of[random.random_range(0..of.len())]
}

/// Between both, as likely in each octave.
fn between(random: &mut Xoshiro256PlusPlus, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.random_range(0.0..1.0))
}

/// Forces of 0.05 to 30 N over 1 to 40 mm, or torques of 3 to 300 mNm over 15 to 150 degrees; half of them with a supply that is
/// sold, some with a longest cycle, a room, a number of wires, or a source with limits; in air of 5 to 40 °C; on any wire that
/// does it, not only the one that would be chosen.
pub fn demand(random: &mut Xoshiro256PlusPlus) -> Requirement {
    let linear = random.random_range(0.0..1.0) < 0.7;
    let motion = if linear {
        Motion::Linear { force_n: between(random, 0.05, 30.0), stroke_m: between(random, 1e-3, 40e-3) }
    } else {
        Motion::Rotary {
            torque_n_m: between(random, 3e-3, 0.3),
            angle_rad: between(random, 15.0, 150.0).to_radians(),
            joint: one_of(random, &[None, Some(Joint::Pulley), Some(Joint::Lever)]),
        }
    };
    let (room_m, longest_s, count) =
        (between(random, 0.05, 0.5), between(random, 0.5, 20.0), random.random_range(1..8));
    let span_m = if linear { one_of(random, &[None, Some(room_m)]) } else { Some(room_m) };
    let mut source = Source::of_voltage(None);
    if random.random_range(0.0..1.0) < 0.5 {
        source.supply_v = Some(one_of(random, &[3.7, 5.0, 6.0, 7.4, 9.0, 12.0, 24.0, 48.0]));
        source.internal_ohm = one_of(random, &[0.0, 0.0, 0.05, 0.3]);
        source.most_current_a = one_of(random, &[None, None, Some(2.0), Some(10.0)]);
    }
    Requirement {
        motion,
        method: one_of(random, &[None, None, Some(Method::Energy)]),
        cycle_s: one_of(random, &[None, None, Some(longest_s)]),
        span_m,
        route: Route::Straight,
        wires: one_of(random, &[None, None, None, Some(count)]),
        source,
        ambient_c: random.random_range(5.0..40.0),
        life_cycles: None,
    }
}

/// Predicted and simulated designs of so many demands that can be met.
pub fn judge(count: usize, seed: u64) -> Outcome {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut outcome = Outcome { rows: Vec::new(), refused: 0 };
    while outcome.rows.len() < count {
        let asked = demand(&mut random);
        let diameter_m = one_of(&mut random, &STOCK_DIAMETERS_M);
        // half of them the wire that is chosen, half any one that will do
        let chosen = random.random_range(0.0..1.0) < 0.5;
        let all = designs(&asked, if chosen { &STOCK_DIAMETERS_M[..] } else { std::slice::from_ref(&diameter_m) });
        let Some(design) = best(&all) else {
            outcome.refused += 1;
            continue;
        };
        let (rig, predicted) = (design.rig().unwrap(), design.prediction.unwrap());
        let task = Task::new(&rig, design.sizing.wire.stroke_m()).unwrap();
        let simulated = simulate(&rig, &task).unwrap();
        let of = |cycle: &Cycle| [cycle.pull_n, 0.0, cycle.heating_s, cycle.cooling_s, cycle.first_s];
        let (a, b) = (of(&predicted.cycle), simulated.cycle.as_ref().map_or([f64::NAN; 5], of));
        let mut ratios: [f64; 5] = std::array::from_fn(|i| a[i] / b[i]);
        ratios[1] = predicted.stroke_m / simulated.stroke_m;
        let s = &design.sizing;
        let demand = format!(
            "{} x {:.3} mm x {:.1} mm, {:.2} V, {:.2} N, {:.1} C",
            s.wires,
            s.wire.diameter_m * 1e3,
            s.wire.length_m * 1e3,
            s.wire_v(),
            s.tension_n(),
            asked.ambient_c
        );
        outcome.rows.push(Row { demand, ratios });
    }
    outcome
}
