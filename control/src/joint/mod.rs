//! Two antagonistic wires on one joint: their observer, and the law from angle to both duties.

mod law;
mod observer;
mod stroke;

pub use law::{JointDemand, JointLaw, JointSettings};
pub use observer::{JointEstimate, JointObserver};
