//! This machine's figures: a rig of scripted wires under control, in real time, beside a bare timer loop in the same thread.
//!
//! `cargo run --release -p sinew-driver --example figures [CHANNELS] [RATE_HZ] [SECONDS]` prints the run's report as JSON.

#[path = "../tests/integration/common.rs"]
mod common;

use common::{Fake, rig};
use sinew_backend::allocations::CountingAllocator;
use sinew_driver::{Driver, Options, Program};
use sinew_rig::RealtimeMode;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let number = |at: usize, default: f64| std::env::args().nth(at).map_or(Ok(default), |text| text.parse::<f64>());
    let (channels, rate_hz, seconds) = (number(1, 18.0)? as usize, number(2, 1000.0)?, number(3, 10.0)?);
    let mut rig = rig(&format!("figures-{}", std::process::id()), channels, rate_hz);
    rig.realtime.mode = RealtimeMode::Try;
    let options = Options {
        duration_s: Some(seconds),
        program: Some(Program::tripod(channels, 6.0)),
        floor_s: Some(seconds),
        ..Options::default()
    };
    let mut report = Driver::start(&rig, Fake::new(&rig), options)?.join();
    report.channel.truncate(1);
    println!("{}", serde_json::to_string_pretty(&report)?);
    Ok(())
}
