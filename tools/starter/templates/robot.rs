//! Moves the wires of a rig one after the other, and prints where they get.
//!
//! ```text
//! sinew run RIG_NAME.toml       # in one terminal: the driver
//! cargo run                     # in another: this program
//! ```

use sinew_ipc::{Client, Error};
use std::time::{Duration, Instant};

/// How long a setpoint holds unless it is renewed: should this program hang or die, its wire goes off this much later.
const LEASE: Duration = Duration::from_millis(500);
const MOVES_FOR: Duration = Duration::from_secs(2);

fn main() {
    let rig = std::env::args().nth(1).unwrap_or("RIG_NAME".into());
    if let Err(error) = robot(&rig) {
        eprintln!("error: {error}"); // its text ends with what to do about it
        std::process::exit(1);
    }
}

fn robot(rig: &str) -> Result<(), Error> {
    let rig = Client::connect(rig)?;
    for (index, channel) in rig.channels().iter().enumerate() {
        let name = channel.name.as_str();
        // 0: cold and long, 1: hot and short
        for stroke in [0.4, 0.1] {
            let begun = Instant::now();
            while begun.elapsed() < MOVES_FOR {
                rig.set_stroke(name, stroke, LEASE)?;
                std::thread::sleep(LEASE / 5);
            }
            let state = rig.latest().channels()[index];
            let reached = channel.stroke_at_length(state.length_m);
            println!(
                "{}: {:.0} % of {:.0} %, about {:.0} °C",
                channel.name,
                100.0 * reached,
                100.0 * stroke,
                state.temperature_c
            );
        }
        rig.off(name)?;
    }
    Ok(())
}
