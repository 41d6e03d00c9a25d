//! Two wires that turn one joint against each other: what is believed of them, and the law from angle to both duties.

mod law;
mod observer;
mod stroke;

pub use law::{JointDemand, JointLaw, JointSettings};
pub use observer::{JointEstimate, JointObserver};
