//! `sinew`: the command line. Each command is a file in `commands/`; this one only chooses it and turns its end into an exit code.
mod args;
mod failure;
mod screen;
mod setpoint;
fn main() {}
