//! What the way over Zenoh adds to a cycle's latency, and what is lost on it: beside a client of the driver on the same machine.
//!
//! ```text
//! sinew run RIG.toml                                              # a driver, such as 64 channels at 1 kHz
//! cargo run --release -- --rig RIG                                # the bridge
//! cargo run --release --example latency -- RIG tcp/127.0.0.1:7447 30 [FOLDER NAME]
//! cargo run --release --example latency -- --rig 64               # writes a rig file of 64 channels at 1 kHz
//! ```

use std::collections::HashMap;
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sinew_ipc::{Client, monotonic_ns};
use zenoh::sample::Sample;
use zenoh::{Config, Session, Wait};

fn main() -> Result<(), zenoh::Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let (rig, endpoint, seconds, certificate) = match arguments.as_slice() {
        ["--rig", channels] => {
            print!("{}", rig_file(channels.parse()?));
            return Ok(());
        }
        [rig, endpoint, seconds] => (*rig, *endpoint, seconds.parse::<f64>()?, None),
        [rig, endpoint, seconds, folder, name] => (*rig, *endpoint, seconds.parse()?, Some((*folder, *name))),
        _ => return Err("give RIG ENDPOINT SECONDS [FOLDER NAME], or --rig CHANNELS".into()),
    };
    let client = Client::connect(rig)?;
    let session = zenoh::open(settings(endpoint, certificate)?).wait()?;
    let bridge_lost =
        || -> Result<u64, zenoh::Error> { Ok(figures(&session, rig)?["cycles_lost"].as_u64().unwrap_or(0)) };
    let lost_before = bridge_lost()?;

    let (told, heard) = channel();
    let came = move |sample: Sample| {
        let now_ns = monotonic_ns();
        let number = |bytes: &[u8]| bytes.try_into().map(u64::from_le_bytes).unwrap_or(0);
        let message = sample.payload().to_bytes();
        let sequence = sample.attachment().map(|numbers| number(&numbers.to_bytes()[..8]));
        let _ = told.send((number(&message[4..12]), number(&message[12..20]), sequence, now_ns, message.len()));
    };
    let _cycles = session.declare_subscriber(format!("sinew/{rig}/cycles")).callback(came).wait()?;
    let mut stream = client.stream()?;
    let mut direct = HashMap::new();
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    while Instant::now() < end {
        let mut waited = stream.next_within(Duration::from_millis(20))?.map(|cycle| cycle.header.cycle);
        while let Some(cycle) = waited {
            direct.insert(cycle, monotonic_ns());
            waited = stream.next()?.map(|cycle| cycle.header.cycle);
        }
    }

    let (mut over_zenoh, mut by_client, mut added) = (Vec::new(), Vec::new(), Vec::new());
    let (mut received, mut lost, mut before, mut bytes) = (0_u64, 0, None, 0);
    for (cycle, sampled_ns, sequence, came_ns, length) in heard.try_iter() {
        received += 1;
        bytes = length;
        if let (Some(sequence), Some(before)) = (sequence, before) {
            lost += sequence - before - 1;
        }
        before = sequence;
        over_zenoh.push(ms(came_ns, sampled_ns));
        if let Some(&read_ns) = direct.get(&cycle) {
            by_client.push(ms(read_ns, sampled_ns));
            added.push(ms(came_ns, read_ns));
        }
    }
    let channels = client.channels().len();
    println!(
        "{channels} channels at {} Hz for {seconds} s over {endpoint}: {bytes} bytes a cycle",
        client.info().rate_hz
    );
    println!(
        "{received} cycles received, {lost} lost between bridge and subscriber, {} between driver and bridge",
        bridge_lost()? - lost_before
    );
    println!("| | p50, ms | p99, ms | longest, ms |\n|---|--:|--:|--:|");
    row("from the samples to a client of the driver", &mut by_client);
    row("from the samples to the subscriber", &mut over_zenoh);
    row("added, cycle by cycle", &mut added);
    Ok(())
}

fn ms(to_ns: u64, from_ns: u64) -> f64 {
    (to_ns as f64 - from_ns as f64) * 1e-6
}

fn row(what: &str, times: &mut [f64]) {
    times.sort_by(f64::total_cmp);
    let at =
        |share: f64| times.get((times.len() as f64 * share) as usize).or(times.last()).copied().unwrap_or(f64::NAN);
    println!("| {what} | {:.2} | {:.2} | {:.2} |", at(0.5), at(0.99), at(1.0));
}

fn figures(session: &Session, rig: &str) -> Result<Value, zenoh::Error> {
    let reply = session.get(format!("sinew/{rig}/bridge")).wait()?.recv()?;
    let sample = reply.into_result().map_err(|error| format!("{error}"))?;
    Ok(serde_json::from_slice(&sample.payload().to_bytes())?)
}

fn settings(endpoint: &str, certificate: Option<(&str, &str)>) -> Result<Config, zenoh::Error> {
    let mut config = Config::default();
    let mut set = |key: &str, value: Value| config.insert_json5(key, &value.to_string());
    set("mode", json!("client"))?;
    set("connect/endpoints", json!([endpoint]))?;
    set("scouting/multicast/enabled", json!(false))?;
    if let Some((folder, name)) = certificate {
        set("transport/link/tls/root_ca_certificate", json!(format!("{folder}/authority.pem")))?;
        set("transport/link/tls/connect_certificate", json!(format!("{folder}/{name}.pem")))?;
        set("transport/link/tls/connect_private_key", json!(format!("{folder}/{name}.key")))?;
        set("transport/link/tls/enable_mtls", json!(true))?;
    }
    Ok(config)
}

/// A rig of so many wires like the built-in hexapod's, at 1 kHz.
fn rig_file(channels: usize) -> String {
    let wire = "wire = { diameter_mm = 0.125, length_mm = 160.0 }\ntaps = { l0_mm = 0.0, ls_mm = 150.0 }\n\
                drive = { supply_v = 6.5, shunt_ohm = 0.1, switch_ohm = 0.02 }\n\
                load = { mass_kg = 0.08, damping_n_s_per_m = 30.0, spring_n_per_m = 150.0, preload_n = 2.4 }\n";
    let channels = (1..=channels).map(|number| format!("\n[[channel]]\nname = \"wire{number}\"\n{wire}"));
    format!("[rig]\nname = \"many\"\nrate_hz = 1000.0\n{}", channels.collect::<String>())
}
