//! Good files to begin with: small, and with something of everything a format has.

use std::io::Cursor;

use sinew_recording::session::{
    About, Compression, Ended, Event, Field, Head, Layout, LoopFigures, SessionWriter, WriteOptions,
};

/// A recording in CSV.
pub const CSV: &[u8] =
    b"time_s,duty,supply_v,position_m,v1_v\n0,0,6,0.001,0.1\n0.1,0.5,5.9,,0.11\n0.2,1,nan,0.002,0.12\n\
    0.3,0.25,6.01,-0.0005,1e-3\n0.5,0,6,0.001,\n";

/// A rig file.
pub const RIG: &[u8] = br#"[rig]
name = "bench"
rate_hz = 1000.0
ambient_c = 25.0

[[channel]]
name = "wire"
wire = { diameter_mm = 0.125, length_mm = 160.0 }
taps = { ls_mm = 150.0 }
drive = { kind = "pwm", supply_v = 6.0, shunt_ohm = 0.1 }
load = { mass_kg = 0.2, damping_n_s_per_m = 40.0, preload_n = 1.96 }
material = { austenite_temperature_c = 93.0 }
effects."thermal.draught" = { gain = 0.35, start_s = 33.0, end_s = 52.0 }

[recording.columns]
position_m = { column = "Pos", scale = -1.0, offset = 0.0 }

[simulation]
seed = 3
"#;

/// A session of two wires in a few chunks, with events, figures and a gap: a driver's, or rows of a test.
pub fn session(compression: Compression, driver: bool) -> Vec<u8> {
    let names = ["duty", "supply_v", "current_a", "v1_v", "v2_v", "v3_v", "length_m"];
    let fields = if driver {
        names.iter().map(|name| Field::f64(name, "V")).chain([Field::u32("backend"), Field::u32("mode")]).collect()
    } else {
        ["time_s", "duty", "position_m"].iter().map(|name| Field::f64(name, "")).collect()
    };
    let channels = if driver { vec!["wire".to_string(), "Two".into()] } else { vec!["wire".to_string()] };
    let Ok(layout) = Layout::new(channels, fields) else { unreachable!("a good layout") };
    let about = About {
        rig: "bench".into(),
        rate_hz: 1000.0,
        software: "sinew".into(),
        kind: if driver { "driver" } else { "test" }.into(),
        simulated: true,
        started_unix_ns: 1_700_000_000_000_000_000,
        started_monotonic_ns: 1_000_000,
        rig_toml: Some(String::from_utf8_lossy(RIG).into_owned()),
        extra: Default::default(),
    };
    let options = WriteOptions { compression, ..WriteOptions::new("seed.mcap") };
    let write = || -> Result<Vec<u8>, sinew_recording::Error> {
        let mut writer = SessionWriter::create(Cursor::new(Vec::new()), &about, &layout, options)?;
        let values = layout.bytes() / 8;
        for cycle in (1..=5).chain(8..=12) {
            let at = |value: usize| 0.25 + (cycle as usize + value) as f64 * 0.01;
            let bytes: Vec<u8> = (0..values)
                .flat_map(|value| if driver && value % 8 == 7 { [0; 8] } else { at(value).to_le_bytes() })
                .collect();
            writer.cycle(&Head { cycle, monotonic_ns: cycle * 1_000_000, missed: cycle / 4 }, &bytes)?;
            if cycle % 5 == 0 {
                writer.event(&Event::note(cycle, cycle * 1_000_000, "half of it"))?;
                writer.loop_stats(&LoopFigures { cycle, monotonic_ns: cycle * 1_000_000, ..LoopFigures::default() })?;
                writer.cut()?;
            }
        }
        Ok(writer.finish(Ended::Complete)?.into_inner())
    };
    match write() {
        Ok(bytes) => bytes,
        Err(error) => unreachable!("into memory: {error}"),
    }
}
