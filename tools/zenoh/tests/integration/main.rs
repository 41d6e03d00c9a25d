//! The bridge to Zenoh, with real drivers on simulated wires and real sessions of Zenoh; what is watched of commands is what the
//! driver publishes.

mod commands;
mod program;
mod streams;
mod world;
