//! The step against trajectories computed by a separate program in another language, from the same equations at steps
//! of 2.5 µs (`tests/reference/`). RMS difference over the column's range, at every step size a recording is run with.

use std::io::Read;
use std::path::Path;

use flate2::read::GzDecoder;
use sinew_physics::{Inputs, Wire};
use sinew_rig::Rig;

/// Allowed RMS difference as a share of the column's range.
const COLUMNS: [(&str, f64); 8] = [
    ("current_a", 0.0005),
    ("v1_v", 0.0005),
    ("v2_v", 0.0005),
    ("v3_v", 0.0005),
    ("force_n", 0.002),
    ("position_m", 0.002),
    ("temperature_c", 0.002),
    ("martensite", 0.002),
];
/// Rows are 10 ms apart. A row's duty holds from its time on; its outputs are those at the end of its 10 ms.
const ROW_S: f64 = 0.01;

struct Trajectory {
    duty: Vec<f64>,
    outputs: Vec<[f64; 8]>,
}

fn read(name: &str) -> (Rig, Trajectory) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference");
    let rig = Rig::load(&folder.join(format!("{name}.toml"))).expect("a reference rig");
    let file = std::fs::File::open(folder.join(format!("{name}.csv.gz"))).expect("a reference trajectory");
    let mut text = String::new();
    GzDecoder::new(file).read_to_string(&mut text).expect("gzipped text");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let at = |name: &str| header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("no column {name}"));
    let (duty_at, outputs_at) = (at("duty"), COLUMNS.map(|(name, _)| at(name)));
    let mut trajectory = Trajectory { duty: Vec::new(), outputs: Vec::new() };
    for line in lines {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        trajectory.duty.push(row[duty_at]);
        trajectory.outputs.push(outputs_at.map(|i| row[i]));
    }
    (rig, trajectory)
}

fn agrees(name: &str) {
    let (rig, expected) = read(name);
    let model = &rig.channels[0].model;
    for step_s in [1e-4, 1e-3, 5e-3] {
        let mut wire = Wire::new(model).expect("a valid model");
        let mut squares = [0.0; 8];
        for (duty, expected) in expected.duty.iter().zip(&expected.outputs) {
            let inputs = Inputs { drive: *duty, ..model.rest_inputs() };
            for _ in 0..(ROW_S / step_s).round() as usize {
                wire.step(&inputs, step_s);
            }
            let o = wire.outputs();
            let got = [o.current_a, o.v1_v, o.v2_v, o.v3_v, o.force_n, o.position_m, o.temperature_c, o.martensite];
            for i in 0..8 {
                squares[i] += (got[i] - expected[i]).powi(2);
            }
        }
        for (i, (column, allowed)) in COLUMNS.iter().enumerate() {
            let low = expected.outputs.iter().map(|o| o[i]).fold(f64::INFINITY, f64::min);
            let high = expected.outputs.iter().map(|o| o[i]).fold(f64::NEG_INFINITY, f64::max);
            let rms = (squares[i] / expected.outputs.len() as f64).sqrt();
            println!("{name} at {step_s} s, {column}: {:.4} % of its range", 100.0 * rms / (high - low));
            // the fixed end's tap is at zero volts throughout
            assert!(rms <= allowed * (high - low), "{name} at {step_s} s, {column}: {rms} of {}", high - low);
        }
    }
}

#[test]
fn mass_stairs() {
    agrees("mass-stairs");
}

#[test]
fn mass_cycles() {
    agrees("mass-cycles");
}

#[test]
fn spring_ramps() {
    agrees("spring-ramps");
}

#[test]
fn stiff_sweep() {
    agrees("stiff-sweep");
}

#[test]
fn stiff_mixed() {
    agrees("stiff-mixed");
}

#[test]
fn heavy_thick() {
    agrees("heavy-thick");
}
