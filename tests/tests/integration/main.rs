//! Across processes: real driver, real shared memory, simulated wires.

mod access;
mod black_box;
mod circles;
mod clients;
mod commands;
mod diagnose;
mod effects;
mod exchange;
mod faults;
mod front_end;
mod lifecycle;
mod linux;
mod manifests;
mod process_faults;
mod recording;
mod report;
mod scope;
mod simulate;
mod stop;
mod terminals;
mod threads;
mod tune;
