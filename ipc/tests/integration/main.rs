//! Messages, services and the client between threads and processes.

mod allocations;
mod common;
mod gait;
mod processes;
mod reference;
mod threads;
