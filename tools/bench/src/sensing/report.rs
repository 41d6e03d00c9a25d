//! The report of the experiment: errors of length by estimator and arrangement, compared with the thesis.

use serde::Serialize;

use super::sweep::{Condition, Heating, Place};

/// What the thesis reports: standard deviations of the error of length, mm and percent of the stroke.
pub const THESIS: Thesis = Thesis { dual_mm: 0.154, dual_percent: 1.7, resistance_percent: 9.95 };

/// Figures of the thesis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Thesis {
    /// Dual measurement, mm.
    pub dual_mm: f64,
    /// Dual measurement, as the thesis puts it in percent of the stroke.
    pub dual_percent: f64,
    /// Resistance and a line, percent of the stroke.
    pub resistance_percent: f64,
}

/// RMS noise of the converter, without its steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// A word for it.
    pub name: &'static str,
    /// Of a voltage, V.
    pub voltage_v: f64,
    /// Of the current, A.
    pub current_a: f64,
}

impl Noise {
    /// Table 9's INA219: steps of 6 mV and 0.8 mA, each over √12.
    pub const PART: Noise = Noise { name: "part", voltage_v: 6e-3 / SQRT_12, current_a: 0.8e-3 / SQRT_12 };
}

const SQRT_12: f64 = 3.464_101_615_137_754_6;

/// Error of one estimator over one sweep. Lengths in mm, percent of the sweep's true stroke.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `dual` and `resistance` (single samples), `dual_filtered` (the driver's motion observer over `dual`), or the name of a
    /// state estimator.
    pub estimator: String,
    /// What is not as believed.
    pub condition: Condition,
    /// Where the taps are.
    pub taps: Place,
    /// What heats.
    pub heating: Heating,
    /// Name of the noise.
    pub noise: &'static str,
    /// Hanging load, gf.
    pub load_gf: f64,
    /// What the wire really moved.
    pub stroke_mm: f64,
    /// RMS error.
    pub rms_mm: f64,
    /// Largest error.
    pub max_mm: f64,
    /// Mean error.
    pub bias_mm: f64,
    /// RMS error.
    pub rms_percent: f64,
    /// Largest error.
    pub max_percent: f64,
    /// Share of the samples without a length, percent.
    pub lost_percent: f64,
    /// RMS error while the probe was off; absent where it never was, or where there was no length then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_while_lost_mm: Option<f64>,
}

/// RMS error of single dual measurements over all loads, in one arrangement with everything as believed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    /// Where the taps are.
    pub taps: Place,
    /// What heats.
    pub heating: Heating,
    /// Name of the noise.
    pub noise: &'static str,
    /// Dual measurement, mm.
    pub dual_mm: f64,
    /// Dual measurement, percent of the stroke.
    pub dual_percent: f64,
    /// Resistance and a line, percent of the stroke.
    pub resistance_percent: f64,
}

/// Everything the experiment found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// What the thesis reports.
    pub thesis: Thesis,
    /// Seed of the noise.
    pub seed: u64,
    /// The noises.
    pub noises: Vec<Noise>,
    /// Over all loads.
    pub summary: Vec<Summary>,
    /// One row a sweep and estimator.
    pub rows: Vec<Row>,
}
