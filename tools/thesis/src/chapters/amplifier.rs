//! The current amplifier of chapters 6 and 8.

use sinew_physics::{Amplifier, Drive, DriveKind, Geometry, Inputs, Wire, WireModel};
use sinew_plot::Ink;

use crate::axes::TIME;
use crate::found::{Found, Tried};
use crate::lab::Lab;
use crate::row::Computed;
use crate::wires::{BY_POWER, hanging};

/// An amplifier of 0.4 A at duty 1 from this supply.
fn amplified(supply_v: f64) -> Drive {
    Drive { kind: DriveKind::Amplifier(Amplifier { full_current_a: 0.4, filter_hz: 40.0 }), supply_v, ..BY_POWER }
}

/// The current that a wire of this length gets, A, step by step of 0.1 ms, and its resistance in the end, Ω.
fn amplified_current(drive: Drive, length_m: f64, duties: &[(f64, f64)]) -> Tried<(Vec<f64>, f64)> {
    let model = WireModel { drive, geometry: Geometry { diameter_m: 0.125e-3, length_m }, ..hanging() };
    let mut of = Wire::new(&model)?;
    let mut seen = Vec::new();
    for (duty, seconds) in duties {
        for _ in 0..(seconds * 1e4).round() as usize {
            of.step(&Inputs { drive: *duty, ..model.rest_inputs() }, 1e-4);
            seen.push(of.current_a());
        }
    }
    Ok((seen, of.resistance_ohm()))
}

/// Fig. 64: the current follows the duty through the low-pass, whatever the wire, as far as the supply goes.
pub(super) fn regulated(_: &Lab, found: &mut Found) -> Computed {
    // 3 dB at 40 Hz is a time constant of 1/(2π 40 Hz) = 3.98 ms
    let (rise, _) = amplified_current(amplified(24.0), 0.16, &[(0.5, 0.02)])?;
    let settled = rise.iter().position(|a| *a > 0.2 * (1.0 - (-1f64).exp())).map_or(f64::NAN, |i| (i + 1) as f64 * 0.1);
    found.near("63 % of a step of the duty after", "ms", 1e3 / (std::f64::consts::TAU * 40.0), 0.1, settled);
    let mut resistances = Vec::new();
    for (i, length_m) in [0.1, 0.16, 0.3].into_iter().enumerate() {
        let (seen, ohm) = amplified_current(amplified(24.0), length_m, &[(0.5, 3.0)])?;
        found.near(
            &format!("current at half duty, {:.0} mm of wire", 1e3 * length_m),
            "A",
            0.2,
            1e-6,
            seen[seen.len() - 1],
        );
        resistances.push(ohm);
        let time: Vec<f64> = (1..=400).map(|k| f64::from(k) * 1e-4).collect();
        found.legend(Ink::Series(i as u8), &format!("{:.0} mm", 1e3 * length_m));
        found.line(TIME, ("Current", "A"), Ink::Series(i as u8), (time, seen[..400].to_vec()));
    }
    found.above("whose resistances differ by a factor of", "1", 2.0, resistances[2] / resistances[0]);
    // the supply's end: no more than it drives through the wire
    let (seen, ohm) = amplified_current(amplified(3.0), 0.3, &[(1.0, 1.0)])?;
    found.near(
        "current at full duty from too little supply, over V_s/R",
        "1",
        1.0,
        1e-6,
        seen[seen.len() - 1] * ohm / 3.0,
    );
    // P = I²R: what heats goes with the square of the duty
    let power = |duty: f64| -> Tried<f64> {
        let model = WireModel { drive: amplified(24.0), ..hanging() };
        let mut of = Wire::new(&model)?;
        for _ in 0..200 {
            of.step(&Inputs { drive: duty, ..model.rest_inputs() }, 1e-3);
        }
        let settled = of.outputs();
        Ok(settled.power_w / settled.resistance_ohm)
    };
    found.near("I² at a fifth of the duty, over that at two fifths", "1", 0.25, 1e-4, power(0.2)? / power(0.4)?);
    Ok(())
}

/// Fig. 83: what the low-pass leaves of the PWM.
pub(super) fn ripple(_: &Lab, found: &mut Found) -> Computed {
    let amplifier = Amplifier { full_current_a: 0.4, filter_hz: 40.0 };
    // a period of PWM at half duty through the low-pass, in its steady state
    let ripple = |pwm_hz: f64| {
        let half_s = 0.5 / pwm_hz;
        let mut set_a = 0.2;
        for _ in 0..(2.0 * pwm_hz) as usize {
            set_a = amplifier.follow(amplifier.follow(set_a, 1.0, half_s).0, 0.0, half_s).0;
        }
        let (top, _) = amplifier.follow(set_a, 1.0, half_s);
        (top - set_a) / 0.2
    };
    found.below("ripple at 738 Hz, peak to peak over the mean", "1", 0.02, ripple(738.0));
    found.proof();
    found.below("the same at 11 kHz", "1", 0.02, ripple(11_000.0));
    found.near(
        "the same at 738 Hz by tanh(πf/2f_pwm), twice",
        "1",
        2.0 * (std::f64::consts::FRAC_PI_2 * 40.0 / 738.0).tanh(),
        1e-3,
        ripple(738.0),
    );
    Ok(())
}
