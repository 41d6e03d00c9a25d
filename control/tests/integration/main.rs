//! Laws and estimators on simulated wires.

mod closed_loop;
mod joint;
mod joint_laws;
mod laws;
mod observers;
mod observing;
mod rig;
mod tables;
