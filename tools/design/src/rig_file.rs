//! A designed wire as a rig file.

use sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
use sinew_physics::{Load, Material};
use sinew_rig::rounded;

use crate::demand::{Motion, Requirement};
use crate::sizing::Sizing;

/// Share of the wire's hot length that the fixed piece of the dual measurement takes.
const FIXED_PIECE: f64 = 0.94;
/// Modulus of martensite that the load's damping is reckoned with, Pa (thesis, nomenclature).
const SOFT_PA: f64 = 28e9;
/// Damping of the load on the soft wire, of the critical; and the share of its weight it takes at the mean speed of heating.
const DAMPING_RATIO: f64 = 0.2;
const DRAG_SHARE: f64 = 0.03;
/// The fastest loop written, Hz: that of the built-in rig.
const RATE_HZ: f64 = 1000.0;
/// What is in series with the wire besides, Ω.
const SHUNT_OHM: f64 = 0.1;
const SWITCH_OHM: f64 = 0.02;

/// The load one wire works against: its preload and its share of the force as a weight. It is damped so lightly that the wire
/// hardly feels it, and so much that the weight does not swing on it for long.
pub fn load_of(sizing: &Sizing) -> Load {
    let preload_n = sizing.tension_n();
    let mass_kg = preload_n / STANDARD_GRAVITY_M_S2;
    let soft_n_per_m = SOFT_PA * sizing.wire.area_m2() / sizing.wire.length_m;
    let swings = 2.0 * DAMPING_RATIO * (soft_n_per_m * mass_kg).sqrt();
    let drags = DRAG_SHARE * preload_n * sizing.heating_s() / sizing.wire.stroke_m();
    Load::SpringMassDamper { mass_kg, damping_n_s_per_m: swings.max(drags), spring_n_per_m: 0.0, preload_n }
}

/// A period of that weight swinging on its cold wire, s.
pub fn swing_s(sizing: &Sizing) -> f64 {
    let soft_n_per_m = SOFT_PA * sizing.wire.area_m2() / sizing.wire.length_m;
    std::f64::consts::TAU * (sizing.tension_n() / STANDARD_GRAVITY_M_S2 / soft_n_per_m).sqrt()
}

/// One of the wires on the bench, as a rig file that the driver takes; `duty` is the most it is heated with.
pub fn rig_file(requirement: &Requirement, sizing: &Sizing, duty: f64) -> String {
    let asked = match requirement.motion {
        Motion::Linear { force_n, stroke_m } => format!("{} N over {} mm", rounded(force_n), rounded(stroke_m * 1e3)),
        Motion::Rotary { torque_n_m, angle_rad, .. } => {
            format!("{} mNm over {} degrees", rounded(torque_n_m * 1e3), rounded(angle_rad.to_degrees()))
        }
    };
    let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, preload_n, .. } = load_of(sizing) else {
        return String::new();
    };
    let length_mm = sizing.wire.length_m * 1e3;
    let lead_ohm = sizing.path.seen_ohm(sizing.internal_ohm);
    let lead = if lead_ohm > 0.0 { format!(", lead_ohm = {}", rounded(lead_ohm)) } else { String::new() };
    let gain = sizing.route.cooling_gain(sizing.wire.diameter_m);
    let material = match gain == 1.0 {
        true => String::new(),
        false => {
            let convection = rounded(gain * Material::default().convection_w_per_m2_k);
            format!("# through the tube it is in\nmaterial = {{ convection_w_per_m2_k = {convection} }}\n")
        }
    };
    let mut supply = String::new();
    if sizing.path.in_series > 1 {
        supply = format!("# its share of {} V over {} in series\n", rounded(sizing.supply_v), sizing.path.in_series);
    }
    if lead_ohm > 0.0 {
        supply.push_str("# lead_ohm: the source's own resistance as one wire sees it\n");
    }
    let limits = match duty < 1.0 {
        true => format!(
            "# with more, the wire would be faster than its load can follow\nlimits = {{ maximum_duty = {} }}\n",
            rounded(duty)
        ),
        false => String::new(),
    };
    format!(
        "# {} for {asked}, by the thesis' rules of chapter 2.\n\
         [rig]\nname = \"designed\"\nrate_hz = {RATE_HZ:.1}\nambient_c = {}\n\n\
         [[channel]]\nname = \"wire\"\n\
         wire = {{ diameter_mm = {}, length_mm = {} }}\n\
         # the fixed piece of the dual measurement; the sliding tap has the rest to travel\n\
         taps = {{ l0_mm = 0.0, ls_mm = {} }}\n\
         {supply}\
         drive = {{ supply_v = {}, shunt_ohm = {SHUNT_OHM}, switch_ohm = {SWITCH_OHM}{lead} }}\n\
         # what the wire works against: the pull that stretches it again and its share of the load, as a weight\n\
         load = {{ mass_kg = {}, damping_n_s_per_m = {}, preload_n = {} }}\n{limits}{material}",
        if sizing.wires == 1 { "A wire".into() } else { format!("One of {} wires", sizing.wires) },
        rounded(requirement.ambient_c),
        rounded(sizing.wire.diameter_m * 1e3),
        rounded(length_mm),
        rounded(length_mm * FIXED_PIECE),
        rounded(sizing.supply_v / f64::from(sizing.path.in_series)),
        rounded(mass_kg),
        rounded(damping_n_s_per_m),
        rounded(preload_n),
    )
}
