//! The pair the unit tests begin with; each changes what it is about.

use super::observer::JointEstimate;
use super::setup::PairSetup;
use super::{JointDemand, JointGains, JointSettings};
use crate::estimate::Estimate;
use crate::testing::wire;
use sinew_physics::{Drive, Geometry, Joint, Material, WireModel};

/// Two wires of 0.05 mm × 160 mm on a lever of 8 mm, of an alloy that is changed.
pub(super) fn pair<T>(change: impl FnOnce(&mut Material), of: impl FnOnce(&PairSetup<'_>) -> T) -> T {
    let mut told = WireModel {
        geometry: Geometry { diameter_m: 0.05e-3, length_m: 0.16 },
        drive: Drive { supply_v: 12.0, ..wire().drive },
        ..wire()
    };
    change(&mut told.material);
    let area_m2 = told.geometry.area_m2();
    let joint = Joint {
        radius_m: 8e-3,
        inertia_kg_m2: 2.5e-6,
        damping_n_m_s: 3.3e-4,
        spring_n_m: 0.0,
        torque_n_m: 0.0,
        pretension_n: 100e6 * area_m2,
    };
    let nominal = WireModel { load: joint.nominal_load(), ..told };
    let settings = JointSettings {
        gains: JointGains::default(),
        joint,
        minimum_tension_n: 50e6 * area_m2,
        tension_n: 200e6 * area_m2,
        maximum_tension_n: 500e6 * area_m2,
        minimum_duty: [0.02; 2],
        maximum_duty: [0.9; 2],
    };
    of(&PairSetup::new([&nominal, &nominal], &settings).unwrap())
}

/// A resistivity that does not change with temperature.
pub(super) fn athermal(material: &mut Material) {
    material.austenite_resistivity_slope_ohm_m_per_k = 0.0;
    material.martensite_resistivity_slope_ohm_m_per_k = 0.0;
}

/// What is asked of a pair that stands, at tensions, N, with both wires in the middle of their hysteresis; a millisecond has passed.
pub(super) fn standing(reference_rad: f64, angle_rad: f64, tension_n: [f64; 2]) -> JointDemand {
    let middle = Estimate {
        temperature_c: 100.0,
        martensite: 0.5,
        hottest_c: 100.0,
        stress_pa: 200e6,
        heating_curve_c: 113.0,
        cooling_curve_c: 87.0,
        length_m: 0.164,
        loss_w: 0.1,
        loss_sigma_w: f64::NAN,
        release_j: 0.04,
        full_power_w: 1.0,
        velocity_m_s: 0.0,
    };
    JointDemand {
        reference_rad,
        tension_n: f64::NAN,
        resistance_ohm: [f64::NAN; 2],
        dt_s: 1e-3,
        estimate: JointEstimate {
            angle_rad,
            rate_rad_s: 0.0,
            tension_n,
            slack_m: 0.0,
            is_slack: false,
            wires: [middle; 2],
        },
    }
}
