//! Designs by the rules, their predictions beside the simulation, and the driver that runs them.

mod predictions;
mod random;
mod rules;
mod supervised;
