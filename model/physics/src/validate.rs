//! The physical range of every parameter: [`WireModel::validate`] names the first one outside it by its rig-file key.

use crate::effects::catalogue;
use crate::error::Error;
use crate::model::WireModel;
use crate::params::{DriveKind, Kinetics, Load};

/// Detwinning takes at least so much stress from its start to its finish, MPa: no wire gets longer at a stroke.
const LEAST_DETWINNING_MPA: f64 = 1.0;

impl WireModel {
    /// Checks every parameter against its physical range.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] with the rig-file key, the value in the rig file's unit, and the range.
    pub fn validate(&self) -> Result<(), Error> {
        let m = &self.material;
        let check = |key: &'static str, found: f64, low: f64, high: f64| {
            // bounds are stated in the rig file's units: a value exactly on one may come back from SI a last digit beyond
            let slack = 8.0 * f64::EPSILON * found.abs();
            if found >= low - slack && found <= high + slack {
                Ok(())
            } else {
                Err(Error::OutOfRange { key, found, low, high })
            }
        };
        check("diameter_mm", self.geometry.diameter_m * 1e3, 0.005, 10.0)?;
        check("length_mm", self.geometry.length_m * 1e3, 1.0, 100_000.0)?;
        check("austenite_modulus_gpa", m.austenite_modulus_pa * 1e-9, 1.0, 300.0)?;
        check("martensite_modulus_gpa", m.martensite_modulus_pa * 1e-9, 1.0, 300.0)?;
        check("transformation_strain", m.transformation_strain, 0.0, 0.15)?;
        check("thermoelastic_mpa_per_k", m.thermoelastic_pa_per_k * 1e-6, -5.0, 5.0)?;
        check("reference_temperature_c", m.reference_temperature_c, -273.15, 500.0)?;
        check("austenite_temperature_c", m.austenite_temperature_c, -200.0, 800.0)?;
        check("martensite_temperature_c", m.martensite_temperature_c, -200.0, 800.0)?;
        check("stress_shift_k_per_mpa", m.stress_shift_k_per_pa * 1e6, 0.0, 1.0)?;
        check("heating_steepness_per_k", m.heating_steepness_per_k, 0.005, 20.0)?;
        check("cooling_steepness_per_k", m.cooling_steepness_per_k, 0.005, 20.0)?;
        check("outer_loop_weight", m.outer_loop_weight, 0.0, 1.0)?;
        check("specific_heat_j_per_kg_k", m.specific_heat_j_per_kg_k, 50.0, 5000.0)?;
        check("latent_heat_j_per_kg", m.latent_heat_j_per_kg, 0.0, 200_000.0)?;
        check("density_kg_per_m3", m.density_kg_per_m3, 1000.0, 20_000.0)?;
        check("convection_w_per_m2_k", m.convection_w_per_m2_k, 0.0, 20_000.0)?;
        check("austenite_resistivity_uohm_cm", m.austenite_resistivity_ohm_m * 1e8, 1.0, 1000.0)?;
        check("martensite_resistivity_uohm_cm", m.martensite_resistivity_ohm_m * 1e8, 1.0, 1000.0)?;
        let slope = "austenite_resistivity_slope_uohm_cm_per_k";
        check(slope, m.austenite_resistivity_slope_ohm_m_per_k * 1e8, -1.0, 1.0)?;
        let slope = "martensite_resistivity_slope_uohm_cm_per_k";
        check(slope, m.martensite_resistivity_slope_ohm_m_per_k * 1e8, -1.0, 1.0)?;
        if let Kinetics::Richards { heating_skew, cooling_skew } = m.kinetics {
            check("heating_skew", heating_skew, 0.05, 20.0)?;
            check("cooling_skew", cooling_skew, 0.05, 20.0)?;
        }
        if let Some(detwinning) = &m.detwinning {
            let start = detwinning.start_pa * 1e-6;
            check("detwinning_start_mpa", start, 0.0, 2000.0)?;
            check("detwinning_finish_mpa", detwinning.finish_pa * 1e-6, start + LEAST_DETWINNING_MPA, 2000.0)?;
        }
        if m.martensite_temperature_c > m.austenite_temperature_c {
            return Err(Error::OutOfRange {
                key: "martensite_temperature_c",
                found: m.martensite_temperature_c,
                low: -200.0,
                high: m.austenite_temperature_c,
            });
        }
        if let Some(taps) = &self.taps {
            let length = self.geometry.length_m * 1e3;
            check("l0_mm", taps.l0_m * 1e3, 0.0, length)?;
            let room = length - taps.l0_m * 1e3;
            let ls = taps.ls_m * 1e3;
            // the second tap at the very end of the wire: a difference of lengths, with the last digits of those
            let at_the_end = (ls - room).abs() <= 8.0 * f64::EPSILON * length;
            check("ls_mm", if at_the_end { room } else { ls }, 0.001 * length, room)?;
        }
        check("supply_v", self.drive.supply_v, 0.0, 1000.0)?;
        check("shunt_ohm", self.drive.shunt_ohm, 0.0, 1000.0)?;
        check("switch_ohm", self.drive.switch_ohm, 0.0, 1000.0)?;
        check("lead_ohm", self.drive.lead_ohm, 0.0, 1000.0)?;
        if let DriveKind::Amplifier(amplifier) = self.drive.kind {
            check("full_current_a", amplifier.full_current_a, 1e-4, 1000.0)?;
            check("filter_hz", amplifier.filter_hz, 0.1, 100_000.0)?;
        }
        if let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, spring_n_per_m, preload_n } = self.load {
            check("mass_kg", mass_kg, 1e-6, 1e4)?;
            check("damping_n_s_per_m", damping_n_s_per_m, 0.0, 1e6)?;
            check("spring_n_per_m", spring_n_per_m, 0.0, 1e7)?;
            check("preload_n", preload_n, -1e5, 1e5)?;
        }
        if let Some(t) = self.initial.temperature_c {
            check("temperature_c", t, -273.15, 800.0)?;
        }
        check("martensite", self.initial.martensite, 0.0, 1.0)?;
        check("ambient_c", self.ambient_c, -200.0, 800.0)?;
        catalogue::validate(self)
    }
}
