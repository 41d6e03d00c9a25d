//! A simulated wire as a part of other simulators: a channel of a rig file as an FMU, which Simulink, Modelica tools and FMPy load
//! (FMI 3.0, co-simulation).
//!
//! | module | |
//! |---|---|
//! | [`variables`] | what a channel has to offer: its inputs, outputs and parameters, with units |
//! | [`instance`] | one wire that is being simulated: what a simulator may do with it, and when |
//! | [`description`] | `modelDescription.xml` |
//! | [`package`] | the file itself |
//! | [`fmi3`] | the C interface over an [`instance::Instance`] |
//!
//! `docs/fmu.md` is the guide.

pub mod description;
pub mod fmi3;
pub mod instance;
pub mod package;
pub mod variables;
