//! A robot program: balances a ball on a beam that one wire tilts, by what a camera says of the ball.
//!
//! ```text
//! sinew demo ball-on-beam                    # the driver, the beam, and this program, which is in `sinew` too
//! cargo run -p sinew-ipc --example ball_on_beam < /dev/ttyACM0    # with a camera of your own
//! ```
//!
//! Two loops, as in chapter 12: the driver's law holds the wire's length, and this program says which. It reads a line for each picture of the
//! camera, `ball_mm: 12.3`, on standard input, and knows of the machine what its builder has measured: the lever, where the beam is
//! about level, how a ball rolls. It sees nothing else.

use std::error::Error;
use std::io::BufRead;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use sinew_ipc::Client;

/// The wire, as the rig file calls it.
const WIRE: &str = "tilt";
/// Lever it pulls at, m.
const LEVER_M: f64 = 0.030;
/// Stroke at which the beam is about level: what is wrong with it the sum of the errors finds.
const LEVEL: f64 = 0.5;
/// Strokes that are asked for: the ends of the way are slow.
const STROKES: [f64; 2] = [0.1, 0.9];
/// Acceleration of a solid ball down a slope, m/s² per rad: 5/7 g.
const ROLLS: f64 = 5.0 / 7.0 * 9.80665;
/// Between two pictures, s.
const PICTURE_S: f64 = 0.02;
/// The ball's motion is to swing in so fast, rad/s, with this damping.
const SWING_RAD_S: f64 = 3.0;
const DAMPING: f64 = 0.9;
/// What the error adds up to, rad of tilt per m and s, and the most of it, rad.
const SUM: f64 = 0.02;
const MOST_SUM_RAD: f64 = 0.03;
/// Share of a surprise that is believed of place and speed.
const BELIEVES: [f64; 2] = [0.3, 0.03];
/// A camera that says nothing for so long sees no ball.
const SILENCE: Duration = Duration::from_millis(300);
/// How long a setpoint holds: if this program dies, the wire goes off so much later.
const LEASE: Duration = Duration::from_millis(500);

/// Runs it as a program of its own.
#[allow(dead_code, reason = "`sinew demo` calls `run`")]
fn main() {
    let rig = std::env::args().nth(1).unwrap_or_else(|| "ball-on-beam".into());
    if let Err(error) = run(&rig) {
        eprintln!("ball_on_beam: {error}");
        std::process::exit(1);
    }
}

/// Balances the ball of this rig until the camera's lines end.
pub fn run(rig: &str) -> Result<(), Box<dyn Error>> {
    let client = Client::connect(rig)?;
    let wire = &client.channels()[client.channel(WIRE)?];
    let mut balance = Balance::new(wire.cold_length_m - wire.hot_length_m);

    // Lines are read by a thread of their own: a camera that says nothing must not keep this program from noticing.
    let (seen, sees) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let number = line.rsplit(':').next().and_then(|word| word.trim().parse::<f64>().ok());
            let Some(ball_mm) = number else { continue };
            if seen.send(ball_mm * 1e-3).is_err() {
                return;
            }
        }
    });
    loop {
        let stroke = match sees.recv_timeout(SILENCE) {
            Ok(ball_m) => balance.sees(ball_m),
            Err(RecvTimeoutError::Timeout) => balance.sees_nothing(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        client.set_stroke(WIRE, stroke, LEASE)?;
    }
    client.off(WIRE)?;
    Ok(())
}

/// What this program knows of the ball, and what it has asked for.
pub struct Balance {
    /// Way of the wire from cold to hot, m.
    travel_m: f64,
    ball: Option<Rolling>,
}

struct Rolling {
    at_m: f64,
    speed_m_s: f64,
    tilt_rad: f64,
    sum_rad: f64,
}

impl Balance {
    /// For a wire that has this way from cold to hot, m.
    pub fn new(travel_m: f64) -> Balance {
        Balance { travel_m, ball: None }
    }

    /// The camera sees the ball at this distance from the pivot, m: the stroke to ask for.
    pub fn sees(&mut self, seen_m: f64) -> f64 {
        let ball = self.ball.get_or_insert(Rolling { at_m: seen_m, speed_m_s: 0.0, tilt_rad: 0.0, sum_rad: 0.0 });
        // where it should be by now, and what of the difference is believed
        let speed_m_s = ball.speed_m_s - PICTURE_S * ROLLS * (ball.tilt_rad - ball.sum_rad);
        let at_m = ball.at_m + PICTURE_S * 0.5 * (ball.speed_m_s + speed_m_s);
        let surprise_m = seen_m - at_m;
        ball.at_m = at_m + BELIEVES[0] * surprise_m;
        ball.speed_m_s = speed_m_s + BELIEVES[1] / PICTURE_S * surprise_m;

        ball.sum_rad = (ball.sum_rad + SUM * ball.at_m * PICTURE_S).clamp(-MOST_SUM_RAD, MOST_SUM_RAD);
        let wanted = SWING_RAD_S * SWING_RAD_S * ball.at_m + 2.0 * DAMPING * SWING_RAD_S * ball.speed_m_s;
        let [least, most] = STROKES.map(|stroke| (stroke - LEVEL) * self.travel_m / LEVER_M);
        ball.tilt_rad = (wanted / ROLLS + ball.sum_rad).clamp(least, most);
        LEVEL + ball.tilt_rad * LEVER_M / self.travel_m
    }

    /// It sees no ball: the stroke to ask for is that of a level beam.
    pub fn sees_nothing(&mut self) -> f64 {
        self.ball = None;
        LEVEL
    }
}
