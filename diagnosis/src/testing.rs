//! A wire on the bench, simulated: what the tests of this crate make recordings of.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use sinew_physics::WireModel;
use sinew_recording::{Column, Recording};
use sinew_rig::Rig;

/// A rig with every sensor: a 0.125 mm wire of 160 mm against a spring.
pub(crate) const RIG: &str = r#"
[rig]
name = "bench"
rate_hz = 100.0

[[channel]]
name = "wire"

[channel.wire]
diameter_mm = 0.125
length_mm = 160.0

[channel.taps]
l0_mm = 10.0
ls_mm = 140.0

[channel.drive]
supply_v = 6.0
shunt_ohm = 0.1
switch_ohm = 0.02

[channel.load]
mass_kg = 0.13
damping_n_s_per_m = 30.0
spring_n_per_m = 150.0
preload_n = 2.6
"#;

/// The noise of the sensors, by column.
pub(crate) const NOISE: [(Column, f64); 6] = [
    (Column::CurrentA, 4e-4),
    (Column::V1V, 1.5e-3),
    (Column::V2V, 1.5e-3),
    (Column::V3V, 1.5e-3),
    (Column::ForceN, 3e-3),
    (Column::PositionM, 1.5e-5),
];

/// [`RIG`], read.
pub(crate) fn rig() -> Rig {
    Rig::parse(RIG, "rig.toml").expect("a rig")
}

/// The duty at a time: stairs that take the wire through whole and partial loops.
pub(crate) fn stairs(time_s: f64) -> f64 {
    const STAIRS: [f64; 10] = [0.05, 0.30, 0.12, 0.22, 0.02, 0.35, 0.16, 0.25, 0.10, 0.02];
    STAIRS[(time_s / 3.0) as usize % STAIRS.len()]
}

/// Thirty seconds at 100 Hz of this wire, with every sensor and its noise.
pub(crate) fn recording(model: &WireModel, duty: impl Fn(f64) -> f64, seed: u64) -> Recording {
    let times: Vec<f64> = (0..3000).map(|i| f64::from(i) / 100.0).collect();
    let mut recording = Recording::new("run.csv", times.clone()).expect("times");
    recording.set(Column::Duty, times.iter().map(|t| duty(*t)).collect()).expect("a duty");
    let mut columns = vec![Vec::new(); NOISE.len()];
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    for simulated in recording.simulated(model).expect("a wire") {
        let (_, outputs) = simulated.expect("the catalogue's laws");
        for ((column, rms), values) in NOISE.iter().zip(&mut columns) {
            let value = column.of_outputs(&outputs).expect("an output");
            values.push(value + rms * random.sample::<f64, _>(StandardNormal));
        }
    }
    for ((column, _), values) in NOISE.iter().zip(columns) {
        recording.set(*column, values).expect("a column");
    }
    recording
}
