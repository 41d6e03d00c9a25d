//! Conversion of commands in strokes and forces to lengths.

use sinew_physics::{Load, WireModel};

/// Why a command cannot be turned into a length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CommandError {
    /// A force was asked for of a load without a spring: its tension does not depend on the length.
    NoSpring,
    /// The tension of this load is imposed from outside.
    LoadUnknown,
    /// Not a number.
    NotFinite {
        /// What was given.
        found: f64,
    },
}

impl std::fmt::Display for CommandError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            CommandError::NoSpring => write!(f, "a hanging mass pulls with the same force at every length"),
            CommandError::LoadUnknown => write!(f, "the load is imposed from outside, its force follows no law"),
            CommandError::NotFinite { found } => write!(f, "expected a number, found {found}"),
        }
    }
}

impl std::error::Error for CommandError {}

/// Wire length at which the load at rest pulls with `force_n`: F = F_preload − K x (eq. 51 at rest), in m.
///
/// # Errors
/// A load without a spring, an imposed load, a force that is not finite.
pub fn length_for_force(model: &WireModel, force_n: f64) -> Result<f64, CommandError> {
    if !force_n.is_finite() {
        return Err(CommandError::NotFinite { found: force_n });
    }
    match model.load {
        Load::SpringMassDamper { .. } => {
            let elongation_m = model.load.elongation_at_rest_m(force_n).ok_or(CommandError::NoSpring)?;
            Ok(model.geometry.length_m + elongation_m)
        }
        Load::ImposedPosition | Load::ImposedForce => Err(CommandError::LoadUnknown),
    }
}

/// Stroke of a wire: 0 % at the cold length, 100 % at the hot one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrokeRange {
    /// Length of the cold wire in its load, in m.
    pub cold_m: f64,
    /// Length of the hot wire in its load, in m.
    pub hot_m: f64,
}

impl StrokeRange {
    /// The stroke of a wire model in its load.
    ///
    /// # Errors
    /// A parameter outside its physical range.
    pub fn of(model: &WireModel) -> Result<StrokeRange, sinew_physics::Error> {
        Ok(StrokeRange { cold_m: sinew_physics::cold_length_m(model)?, hot_m: sinew_physics::hot_length_m(model)? })
    }

    /// The whole stroke, in m; positive for a wire that shortens when hot.
    pub fn stroke_m(&self) -> f64 {
        self.cold_m - self.hot_m
    }

    /// Length at a stroke of 0 (cold) to 1 (hot), in m.
    pub fn length_m(&self, stroke: f64) -> f64 {
        self.cold_m - stroke * self.stroke_m()
    }

    /// Stroke 0..1 at a length; NaN for a wire without stroke.
    pub fn stroke(&self, length_m: f64) -> f64 {
        (self.cold_m - length_m) / self.stroke_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{hanging, wire};

    fn model(load: Load) -> WireModel {
        WireModel { load, ..wire() }
    }

    fn mass_on(spring_n_per_m: f64) -> Load {
        hanging(0.1, 10.0, spring_n_per_m, 2.0)
    }

    #[test]
    fn a_spring_turns_force_into_length() {
        let length = length_for_force(&model(mass_on(150.0)), 1.4).unwrap();
        assert!((length - 0.164).abs() < 1e-12, "{length}");
    }

    #[test]
    fn a_mass_cannot_be_commanded_by_force() {
        assert_eq!(length_for_force(&model(mass_on(0.0)), 1.4), Err(CommandError::NoSpring));
        assert_eq!(length_for_force(&model(Load::ImposedForce), 1.4), Err(CommandError::LoadUnknown));
        assert!(matches!(length_for_force(&model(mass_on(1.0)), f64::NAN), Err(CommandError::NotFinite { .. })));
    }

    #[test]
    fn stroke_runs_from_cold_to_hot() {
        let range = StrokeRange::of(&model(mass_on(0.0))).unwrap();
        assert!(range.stroke_m() > 0.005 && range.stroke_m() < 0.009, "{range:?}");
        assert!((range.length_m(0.0) - range.cold_m).abs() < 1e-15);
        assert!((range.length_m(1.0) - range.hot_m).abs() < 1e-15);
        assert!((range.stroke(range.length_m(0.37)) - 0.37).abs() < 1e-12);
    }
}
