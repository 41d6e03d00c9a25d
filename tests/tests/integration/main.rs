//! Across processes: real driver, real shared memory, simulated wires.

mod access;
mod bindings_c;
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
mod neighbours;
mod process_faults;
mod recording;
mod report;
mod restart;
mod scope;
mod simulate;
mod stop;
mod terminals;
mod threads;
mod together;
mod tune;
