//! Writes a long session of simulated wires in little time, for measuring what reads it: `FILE.mcap CHANNELS RATE_HZ CYCLES`.
//!
//! ```text
//! cargo run --release -p sinew-replay --example session -- long.mcap 64 5000 130000
//! ```

use std::fs::File;
use std::io::BufWriter;

use sinew_backend::{Backend, Sample};
use sinew_driver::{Ask, Beat, Engine, Order};
use sinew_ipc::{DriverState, Snapshot};
use sinew_recorder::layout;
use sinew_recording::session::{About, Ended, Head, SessionWriter, WriteOptions};
use sinew_replay::encode;
use sinew_rig::Rig;
use sinew_sim_backend::SimulatedRig;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, path, channels, rate_hz, cycles] = args.as_slice() else {
        return Err("give FILE.mcap CHANNELS RATE_HZ CYCLES".into());
    };
    let (channels, rate_hz, cycles): (usize, f64, u64) = (channels.parse()?, rate_hz.parse()?, cycles.parse()?);
    let mut text = format!("[rig]\nname = \"long\"\nrate_hz = {rate_hz:.1}\n");
    for channel in 0..channels {
        text += &format!(
            "\n[[channel]]\nname = \"wire_{channel}\"\nwire = {{ diameter_mm = 0.125, length_mm = 160.0 }}\n\
             taps = {{ ls_mm = 150.0 }}\ndrive = {{ supply_v = 6.0, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
             load = {{ mass_kg = 0.2, damping_n_s_per_m = 40.0, spring_n_per_m = 150.0, preload_n = 1.96133 }}\n\
             control = {{ sensing_duty = 0.1 }}\n"
        );
    }
    let rig = Rig::parse(&text, "long.toml")?;
    let mut backend = SimulatedRig::new(&rig)?;
    let mut engine = Engine::at_rest(&rig, None)?;
    backend.start()?;
    let names: Vec<String> = rig.channels.iter().map(|channel| channel.name.clone()).collect();
    let about = About {
        rig: rig.name.clone(),
        rate_hz,
        software: concat!("sinew ", env!("CARGO_PKG_VERSION")).into(),
        kind: "driver".into(),
        simulated: true,
        started_unix_ns: 1_700_000_000_000_000_000,
        started_monotonic_ns: 0,
        rig_toml: Some(text),
        extra: Default::default(),
    };
    let sink = BufWriter::new(File::create(path)?);
    let mut writer = SessionWriter::create(sink, &about, &layout(names)?, WriteOptions::new(path))?;
    let (mut duty, mut samples) = (vec![0.0; channels], vec![Sample::NONE; channels]);
    let (mut state, mut bytes) = (Snapshot::new(channels), Vec::new());
    let period_ns = (1e9 / rate_hz).round() as u64;
    for cycle in 1..=cycles {
        let now_ns = (cycle - 1) * period_ns;
        let exchanged = backend.exchange(&duty, &mut samples);
        let channel = (cycle as usize * 7) % (channels * 200);
        if channel < channels && cycle > 100 {
            // one after the other to another place
            let stroke = 0.1 + 0.7 * ((cycle / 1000) as f64 * 0.37).fract();
            let length_m = engine.channels()[channel].stroke_range().length_m(stroke);
            engine.take(&Order { ticket: 0, channel, ask: Ask::Length(length_m), hold_ns: u64::MAX }, now_ns);
        }
        engine.cycle(Beat { now_ns, missed: 0 }, exchanged, &samples, &mut duty, |_| {});
        engine.describe(now_ns, DriverState::Running, &mut state);
        encode(state.channels(), &mut bytes);
        writer.cycle(&Head { cycle, monotonic_ns: now_ns, missed: 0 }, &bytes)?;
    }
    writer.finish(Ended::Complete)?;
    println!("{path}: {} bytes", std::fs::metadata(path)?.len());
    Ok(())
}
