//! The case of a plan's entry, by the generator it belongs to.

use crate::generator::case::{self, Case};
use crate::generator::plan::Spec;
use crate::second;

/// Makes it.
pub fn make(spec: &Spec) -> Case {
    if spec.second { second::case::make(spec) } else { case::make(spec) }
}
