//! The program `sinew`, run as its users run it.

mod around;
mod bench_control;
mod design;
mod exchange;
mod life;
mod plot;
mod run;
mod simulate;
mod support;
mod test_machine;
mod thesis;
mod usage;
