//! What both generators' truths have in common, for whoever looks for the size of an effect.

use super::bench::Bench;
use super::truth::Truth;

/// A truth that can be simulated, with the coefficients a rig file knows.
pub trait World: Clone {
    /// Steps of the simulations by which levels are found, s: both sides have the same, so its error cancels.
    const LEVEL_STEP_S: f64;
    /// The coefficients under the rig file's keys.
    fn coefficients(&self) -> &Truth;
    /// The same, to change.
    fn coefficients_mut(&mut self) -> &mut Truth;
    /// What perfect sensors would show, by sensor then row.
    fn perfect(&self, bench: &Bench, duty: &[f64], step_s: f64) -> Vec<Vec<f64>>;
}

/// Something that can be put into a truth at a size.
pub trait Concealed<W> {
    /// Puts it in at `size` natural units.
    fn put_into(&self, bench: &Bench, world: &mut W, size: f64);
    /// Largest size, in natural units.
    fn most(&self) -> f64;
    /// It is there or not and has no size.
    fn is_fixed(&self) -> bool;
}
