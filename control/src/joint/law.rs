//! The law that runs on a joint, and the limits of the tension around it; chosen once, dispatched without indirection.

use super::demand::{JointDemand, PairLaw};
use super::setup::{JointSettings, MOST_TENSION, PairSetup};
use super::tension::TensionGuard;
use super::{AnyJointLaw, JointAlgorithmKind, TensionKept};
use sinew_physics::{Error, WireModel};

/// A joint's law.
#[derive(Debug, Clone)]
pub struct JointLaw {
    law: AnyJointLaw,
    /// None around a law that keeps the limits of the tension itself.
    guard: Option<TensionGuard>,
    minimum_duty: [f64; 2],
    blind: bool,
}

impl JointLaw {
    /// Share of the maximum tension that can be asked for: above it less is heated.
    pub const MOST_TENSION: f64 = MOST_TENSION;

    /// The law for two wires in their nominal loads, agonist first.
    ///
    /// # Errors
    /// Parameters that the physics does not accept.
    pub fn new(kind: JointAlgorithmKind, models: [&WireModel; 2], settings: &JointSettings) -> Result<JointLaw, Error> {
        let setup = PairSetup::new(models, settings)?;
        let guarded = kind.row().tension != TensionKept::Within;
        Ok(JointLaw {
            law: AnyJointLaw::new(kind, &setup),
            guard: guarded.then(|| TensionGuard::new(&setup)),
            minimum_duty: setup.settings.minimum_duty,
            blind: false,
        })
    }

    /// Forgets the past: as newly made.
    pub fn reset(&mut self) {
        self.law.reset();
        if let Some(guard) = &mut self.guard {
            guard.reset();
        }
        self.blind = false;
    }

    /// Whether a limit of the tension had a say in the last cycle.
    pub fn is_limited(&self) -> bool {
        self.law.is_limited() || self.guard.as_ref().is_some_and(TensionGuard::is_limited)
    }

    /// Whether the last demand held a number that was none.
    pub fn is_blind(&self) -> bool {
        self.blind
    }

    /// The duties of agonist and antagonist for the next period, always between least and most. A demand that holds
    /// no number gets the least of both.
    #[inline]
    pub fn duties(&mut self, demand: &JointDemand) -> [f64; 2] {
        let wanted = self.law.duties(demand);
        self.blind = wanted.is_none();
        match (wanted, &mut self.guard) {
            (None, _) => self.minimum_duty,
            (Some(wanted), None) => wanted,
            (Some(wanted), Some(guard)) => guard.guard(wanted, demand),
        }
    }
}
