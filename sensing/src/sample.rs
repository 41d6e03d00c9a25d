//! The converter's readings of one period.

/// What the converter saw in one period: all of it in the on-phase, save the supply of a shared input. NaN = not sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// First tap against ground, V1, in V.
    pub v1_v: f64,
    /// Second tap against ground, V2, in V.
    pub v2_v: f64,
    /// Moving end against ground, V3, in V; not sampled where the input is shared.
    pub v3_v: f64,
    /// Current through the wire, in A.
    pub current_a: f64,
    /// Supply, in V; NaN = not measured. Of a shared input: as it saw it in the off-phase of the same period.
    pub supply_v: f64,
}

impl Sample {
    /// A period in which nothing was sampled.
    pub const NONE: Sample =
        Sample { v1_v: f64::NAN, v2_v: f64::NAN, v3_v: f64::NAN, current_a: f64::NAN, supply_v: f64::NAN };
}

impl Default for Sample {
    fn default() -> Self {
        Sample::NONE
    }
}
