//! What data sheets say of wires, beside what the model does with the same wires: the time to shorten at the sheet's current, and to
//! cool, hanging under the sheet's pull in still air of 22 °C. The last column is the coefficient of heat transfer with which the model cools
//! as fast as the sheet says, in the mean of the alloys of a diameter: `model/rig/src/wires.rs` has it. The times to shorten are not fitted.
//!
//! ```text
//! cargo run --release -p sinew-rig --example data_sheets
//! ```

use sinew_physics::{Inputs, Wire};
use sinew_rig::{Rig, WIRE_KINDS, WireKind};

const LENGTH_MM: f64 = 100.0;
const AMBIENT_C: f64 = 22.0;
const STEP_S: f64 = 2e-4;
const LONGEST_S: f64 = 60.0;
/// Shortened means to here, of the stroke; as it cools, the sheet leaves out the last half percent of the wire.
const SHORT: f64 = 0.95;
const LEFT_OUT: f64 = 0.005;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    println!("| kind | shortens, s (sheet: about 1) | cools, s | sheet | h for that |\n|---|--:|--:|--:|--:|");
    let (mut heating, mut cooling) = (Vec::new(), Vec::new());
    for alloys in WIRE_KINDS.chunks(2) {
        let fitted = fitted(alloys)?;
        for kind in alloys {
            let h = kind.material().convection_w_per_m2_k;
            let [shortens_s, cools_s] = times(kind, h)?;
            println!("| `{}` | {shortens_s:.2} | {cools_s:.2} | {} | {fitted:.0} |", kind.name, kind.cooling_s);
            heating.push(shortens_s);
            cooling.push(cools_s / kind.cooling_s);
        }
    }
    for (what, mut ratios) in [("shortens", heating), ("cools", cooling)] {
        ratios.sort_by(f64::total_cmp);
        let (least, median, most) = (ratios[0], ratios[ratios.len() / 2], ratios[ratios.len() - 1]);
        println!("{what}, of the sheet's time: median {median:.2}, {least:.2} to {most:.2}");
    }
    Ok(())
}

/// The coefficient with which wires of one diameter cool as their sheet says, in the geometric mean, W/(m² K).
fn fitted(alloys: &[WireKind]) -> Result<f64, Failure> {
    let (mut low, mut high) = (1f64, 2000f64);
    for _ in 0..14 {
        let h = (low * high).sqrt();
        let mut log = 0.0;
        for kind in alloys {
            log += (times(kind, h)?[1] / kind.cooling_s).ln();
        }
        if log > 0.0 { low = h } else { high = h }
    }
    Ok((low * high).sqrt())
}

/// How long it takes to shorten at the sheet's current, and to cool from there, s; the longest where it never does.
fn times(kind: &WireKind, convection_w_per_m2_k: f64) -> Result<[f64; 2], Failure> {
    let bench = |drive: &str| {
        let text = format!(
            "[rig]\nname = \"sheet\"\nambient_c = {AMBIENT_C:?}\n[[channel]]\nname = \"wire\"\n\
             wire = {{ kind = \"{}\", length_mm = {LENGTH_MM:?} }}\ndrive = {{ kind = \"{drive}\" }}\n\
             load = {{ mass_kg = {:?}, damping_n_s_per_m = {:?} }}\n\
             material = {{ convection_w_per_m2_k = {convection_w_per_m2_k:?} }}\n",
            kind.name,
            kind.pull_n / 9.80665,
            kind.pull_n / 0.04
        );
        Rig::parse(&text, "sheet")
    };
    let [hung, heated] = [bench("temperature")?, bench("current")?];
    let rest = |rig: &Rig, drive| Inputs { drive, ..rig.channels[0].model.rest_inputs() };
    let mut wire = Wire::new(&hung.channels[0].model)?;
    let [cold_m, hot_m] = [AMBIENT_C, 250.0].map(|temperature_c| {
        until(&mut wire, &rest(&hung, temperature_c), 2.0, |_| false);
        wire.position_m()
    });
    let (short_m, long_m) = (cold_m - SHORT * (cold_m - hot_m), cold_m - LEFT_OUT * 1e-3 * LENGTH_MM);
    let mut wire = Wire::new(&heated.channels[0].model)?;
    until(&mut wire, &rest(&heated, 0.0), 2.0, |_| false);
    let shortens_s = until(&mut wire, &rest(&heated, kind.current_a), LONGEST_S, |wire| wire.position_m() <= short_m);
    Ok([shortens_s, until(&mut wire, &rest(&heated, 0.0), LONGEST_S, |wire| wire.position_m() >= long_m)])
}

/// Steps a wire until it is so, or the longest is over: the time it took, s.
fn until(wire: &mut Wire, inputs: &Inputs, longest_s: f64, is_so: impl Fn(&Wire) -> bool) -> f64 {
    let mut time_s = 0.0;
    while time_s < longest_s && !is_so(wire) {
        wire.step(inputs, STEP_S);
        time_s += STEP_S;
    }
    time_s
}
