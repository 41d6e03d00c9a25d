//! All effects of one wire.

use super::electrical::Electrical;
use super::empirical::Empirical;
use super::kinetic::Kinetic;
use super::mechanical::Mechanical;
use super::own::Own;
use super::sensing::Sensing;
use super::thermal::Thermal;

/// Every effect beyond the reference model, in SI, grouped by the equation it is a term of. The default has none of
/// them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects {
    /// Terms of the heat balance.
    pub thermal: Thermal,
    /// Terms of resistance and circuit.
    pub electrical: Electrical,
    /// Terms of the phase.
    pub kinetic: Kinetic,
    /// Terms of strain and load.
    pub mechanical: Mechanical,
    /// What the sensors add.
    pub sensing: Sensing,
    /// Closed forms for what no mechanism explains.
    pub empirical: Empirical,
    /// What users wrote themselves.
    pub own: Own,
}
