//! How long a request for all channels takes, from another process: until it is answered, and until what it asks for is decided upon in a cycle.
//!
//! ```text
//! cargo run --release --bin sinew -- run                       # the driver, on simulated wires
//! cargo run --release -p sinew-ipc --example latency -- RIG 2000   # requests
//! ```
//!
//! Beside it, in the same run: the same as a stream of setpoints that nobody waits for, and as one request for each channel, one after the
//! other.

use std::time::{Duration, Instant};

use sinew_ipc::{Client, CommandKind, Error, SetpointOptions, Wanted, monotonic_ns};

const LEASE: Duration = Duration::from_secs(2);
/// Requests are spread over the loop's phase by a pause that is no multiple of its period.
const PAUSE: Duration = Duration::from_micros(3_137);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let rig = arguments.next().unwrap_or_else(|| "hexapod".into());
    let requests = arguments.next().map_or(Ok(2000), |text| text.parse())?;
    let client = Client::connect(&rig)?;
    let channels = client.channels().len() as u32;
    let pose = |value| -> Vec<Wanted> {
        (0..channels).map(|channel| Wanted { channel, kind: CommandKind::Stroke, value }).collect()
    };
    println!("{rig}: {channels} channels at {} Hz, {requests} requests", client.info().rate_hz);
    println!("| | p50, ms | p99, ms | longest, ms |\n|---|--:|--:|--:|");

    let mut stream = client.stream()?;
    let (mut answered, mut begun) = (Vec::new(), Vec::new());
    let mut asked = Vec::new();
    for request in 0..requests {
        let (at_ns, started) = (monotonic_ns(), Instant::now());
        let taken = client.set_many(&pose(0.1 + 0.1 * f64::from(request % 2)), LEASE)?;
        answered.push(started.elapsed().as_secs_f64() * 1e3);
        asked.push((taken.cycle, at_ns));
        std::thread::sleep(PAUSE);
        while let Some(cycle) = stream.next()? {
            while let Some(&(number, at_ns)) = asked.first()
                && number <= cycle.header.cycle
            {
                if number == cycle.header.cycle {
                    begun.push((cycle.header.monotonic_ns as f64 - at_ns as f64) * 1e-6);
                }
                asked.remove(0);
            }
        }
    }
    row("all in one request: answered", &mut answered);
    row("decided upon in a cycle that began", &mut begun);

    // One message after the other, so that it is known which one a cycle has taken.
    let mut setpoints = client.setpoints(SetpointOptions { hold: LEASE, ..SetpointOptions::default() });
    let (mut sent, mut begun) = (Vec::new(), Vec::new());
    for message in 0..requests {
        let (at_ns, started) = (monotonic_ns(), Instant::now());
        let taken = setpoints.send(&pose(0.1 + 0.1 * f64::from(message % 2)))?.taken;
        sent.push(started.elapsed().as_secs_f64() * 1e3);
        std::thread::sleep(PAUSE);
        let found = setpoints.poll()?;
        while let Some(cycle) = stream.next()? {
            if found.taken > taken && found.cycle == cycle.header.cycle {
                begun.push((cycle.header.monotonic_ns as f64 - at_ns as f64) * 1e-6);
            }
        }
    }
    println!("{:?}", setpoints.finish()?);
    row("a message of a stream: sent", &mut sent);
    row("decided upon in a cycle that began", &mut begun);

    let mut singly = Vec::new();
    for request in 0..requests / 20 {
        let started = Instant::now();
        for wanted in pose(0.1 + 0.1 * f64::from(request % 2)) {
            match client.command(wanted.channel, wanted.kind, wanted.value, LEASE) {
                Ok(_) | Err(Error::Refused(_)) => {}
                Err(error) => return Err(error.into()),
            }
        }
        singly.push(started.elapsed().as_secs_f64() * 1e3);
    }
    row("a request for each, the last answered", &mut singly);
    client.all_off()?;
    Ok(())
}

fn row(what: &str, found_ms: &mut [f64]) {
    found_ms.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| found_ms[((found_ms.len() - 1) as f64 * share).round() as usize];
    println!("| {what} | {:.2} | {:.2} | {:.2} |", at(0.5), at(0.99), at(1.0));
}
