//! The wire the unit tests begin with; each changes what it is about.

use crate::demand::Demand;
use crate::estimate::Estimate;
use sinew_physics::{Drive, DriveKind, Effects, Geometry, Initial, Load, Material, WireModel};

/// A 0.125 mm wire of 160 mm at 6 V that lifts 0.2 kg, well damped.
pub(crate) fn wire() -> WireModel {
    WireModel {
        geometry: Geometry { diameter_m: 0.125e-3, length_m: 0.16 },
        material: Material::default(),
        taps: None,
        drive: Drive { kind: DriveKind::Pwm, supply_v: 6.0, shunt_ohm: 0.1, switch_ohm: 0.0, lead_ohm: 0.0 },
        load: hanging(0.2, 40.0, 0.0, 0.2 * 9.80665),
        initial: Initial::default(),
        ambient_c: 25.0,
        effects: Effects::default(),
    }
}

/// Heat given as it is, by no circuit.
pub(crate) fn by_power() -> Drive {
    Drive { kind: DriveKind::Power, supply_v: 0.0, shunt_ohm: 0.0, switch_ohm: 0.0, lead_ohm: 0.0 }
}

/// A mass (kg) with damping (N s/m) on a spring (N/m) under a preload (N).
pub(crate) fn hanging(mass_kg: f64, damping_n_s_per_m: f64, spring_n_per_m: f64, preload_n: f64) -> Load {
    Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n }
}

/// What is asked of a law that brings a wire of this length, m, to that, by nothing but the length; it stands, and a millisecond has passed.
pub(crate) fn standing(reference_m: f64, length_m: f64) -> Demand {
    Demand {
        reference_m,
        length_m,
        velocity_m_s: 0.0,
        acceleration_m_s2: 0.0,
        resistance_ohm: f64::NAN,
        dt_s: 1e-3,
        estimate: Estimate::UNKNOWN,
    }
}
