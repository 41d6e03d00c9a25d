//! A robot program: a servo that one wire turns, commanded by pulses as a radio's receiver hands them over.
//!
//! ```text
//! sinew demo servo                           # the driver, the servo, and this program, which is in `sinew` too
//! cargo run -p sinew-ipc --example servo -- servo 4 60            # by hand: type `pulse_us: 1600`
//! ```
//! Its arguments are the rig, the lever in mm, and how many degrees a pulse wider by 1 ms asks for.
//!
//! The wire measures itself, and the driver's law holds its length: all that is left is to turn a pulse's width into a length. It reads a line
//! for each pulse, `pulse_us: 1512.3`, on standard input.

use std::error::Error;
use std::io::BufRead;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use sinew_ipc::Client;

/// The wire, as the rig file calls it.
const WIRE: &str = "horn";
/// Stroke at which the horn stands straight.
const CENTRE: f64 = 0.5;
/// Strokes that are asked for.
const STROKES: [f64; 2] = [0.05, 0.95];
/// Width of the pulse that asks for that, µs.
const CENTRE_US: f64 = 1500.0;
/// Pulses that are hardly meant, µs: noise of a receiver without a sender.
const PULSES_US: [f64; 2] = [800.0, 2200.0];
/// A pulse that differs from what is held by less than this, µs, is jitter.
const STILL_US: f64 = 2.0;
/// Without a pulse for so long the servo lets go, as one does whose sender is switched off.
const SILENCE: Duration = Duration::from_millis(500);
/// How long a setpoint holds: if this program dies, the wire goes off so much later.
const LEASE: Duration = Duration::from_millis(1000);

/// Runs it as a program of its own.
#[allow(dead_code, reason = "`sinew demo` calls `run`")]
fn main() {
    let argument = |place: usize| std::env::args().nth(place);
    let number = |place, otherwise| argument(place).and_then(|word| word.parse().ok()).unwrap_or(otherwise);
    let horn = Horn { lever_m: number(2, 4.0) * 1e-3, degrees_per_ms: number(3, 60.0) };
    if let Err(error) = run(&argument(1).unwrap_or_else(|| "servo".into()), horn) {
        eprintln!("servo: {error}");
        std::process::exit(1);
    }
}

/// What its builder has measured and chosen.
#[derive(Clone, Copy)]
pub struct Horn {
    /// Lever that the wire pulls at, m.
    pub lever_m: f64,
    /// What a pulse wider by 1 ms asks for.
    pub degrees_per_ms: f64,
}

/// Turns the servo of this rig until the receiver's lines end.
pub fn run(rig: &str, horn: Horn) -> Result<(), Box<dyn Error>> {
    let client = Client::connect(rig)?;
    let wire = &client.channels()[client.channel(WIRE)?];
    let mut servo = Servo::new(horn, wire.cold_length_m - wire.hot_length_m);

    // Lines are read by a thread of their own: a receiver that says nothing must not keep this program from noticing.
    let (heard, hears) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let number = line.rsplit(':').next().and_then(|word| word.trim().parse::<f64>().ok());
            let Some(pulse_us) = number else { continue };
            if heard.send(pulse_us).is_err() {
                return;
            }
        }
    });
    loop {
        match hears.recv_timeout(SILENCE) {
            Ok(pulse_us) => {
                let stroke = servo.hears(pulse_us);
                client.set_stroke(WIRE, stroke, LEASE)?;
            }
            Err(RecvTimeoutError::Timeout) => drop(client.off(WIRE)?),
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    client.off(WIRE)?;
    Ok(())
}

/// What this program holds.
pub struct Servo {
    /// Stroke that one µs more asks for.
    stroke_per_us: f64,
    held_us: f64,
}

impl Servo {
    /// For a wire that has this way from cold to hot, m.
    pub fn new(horn: Horn, travel_m: f64) -> Servo {
        let rad_per_us = horn.degrees_per_ms.to_radians() * 1e-3;
        Servo { stroke_per_us: rad_per_us * horn.lever_m / travel_m, held_us: CENTRE_US }
    }

    /// A pulse of this width, µs: the stroke to ask for.
    pub fn hears(&mut self, pulse_us: f64) -> f64 {
        let is_meant = (PULSES_US[0]..=PULSES_US[1]).contains(&pulse_us);
        if is_meant && (pulse_us - self.held_us).abs() > STILL_US {
            self.held_us = pulse_us;
        }
        (CENTRE + (self.held_us - CENTRE_US) * self.stroke_per_us).clamp(STROKES[0], STROKES[1])
    }
}
