//! Good files to begin with: small, and with something of everything a format has.

use std::io::Cursor;

use sinew_front_end::{
    ChannelLimits, Configure, Decoder, Duty, EnableMode, Frame, MAX_BODY, MAX_CHANNELS, MAX_FRAME, encode,
};
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

[channel.effects."own.creep"]
says = "Under tension the wire flows"
enters = "strain"
formula = "max(flowed, 0) * clamp(austenite, 0.1, 1)^2"
rate = 2e-6
parameters.rate = { unit = "1/(MPa s)", null = 0.0, range = [0.0, 1e-3], about = "how fast" }
states.flowed = { unit = "%", start = 0.0, rate = "rate * (stress - 20 [MPa])" }

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

/// Frames of every kind, as they go over the line, one after the other; and each one's body alone.
pub fn lines() -> Vec<Vec<u8>> {
    let limits = ChannelLimits { max_duty: 30_000, max_current_ma: 700, heat_ma2_s: 500_000, drain_ma2: 90_000 };
    let frames = [
        Frame::Hello { nonce: 7 },
        Frame::Configure(Configure {
            session: 1,
            period_ns: 1_000_000,
            watchdog_periods: 5,
            enable: EnableMode::Pulses,
            uses_stop: true,
            channels: 3,
            limits: [limits; MAX_CHANNELS],
        }),
        Frame::Duty(Duty { sequence: 1, valid_us: 5000, supply: true, channels: 3, duty: [300; MAX_CHANNELS] }),
        Frame::Off,
        Frame::Clear { channel: 2 },
        Frame::Configured { session: 1, refusal: None },
    ];
    let lines: Vec<Vec<u8>> = frames
        .iter()
        .filter_map(|frame| {
            let mut line = [0; MAX_FRAME];
            let length = encode(frame, &mut line).ok()?;
            Some(line[..length].to_vec())
        })
        .collect();
    let mut bodies = Vec::new();
    for line in &lines {
        let mut decoder = Decoder::<MAX_BODY>::new();
        bodies.extend(line.iter().filter_map(|&byte| decoder.push(byte).and_then(Result::ok).map(<[u8]>::to_vec)));
    }
    bodies.push(lines.concat());
    bodies.extend(lines);
    bodies
}

/// A front-end that is configured, armed, driven, left alone and driven again: a script of [`crate::firmware`].
pub fn firmware() -> Vec<Vec<u8>> {
    let configure =
        [&[1u8, 0, 0, 0, 0][..], &[0xff, 0x7f, 0xff, 0x7f, 0, 0, 8, 0, 0, 0, 4, 0].repeat(3), &[0; 4]].concat();
    let nothing = [2u8, 0, 0, 0, 0];
    let half = [&[0x42u8][..], &[0, 0x40].repeat(3), &[0; 4]].concat();
    let period = [7u8, 10, 100, 0];
    // the same with level and emergency stop, which is pressed, released, and a channel's fault forgotten
    let guarded = [&[1u8, 5, 0, 0, 0], &configure[5..]].concat();
    let (open, closed, clear) = ([0x45u8, 1], [0x45u8, 0], [0x85u8, 1, 0, 0, 0, 0]);
    let silence = [7u8, 17, 0, 0];
    let driven = [&half[..], &period].concat().repeat(6);
    let armed = [&configure[..], &nothing, &period, &nothing, &period].concat();
    vec![
        [&armed[..], &driven, &silence, &nothing, &period, &nothing, &period, &driven].concat(),
        [&armed[..], &driven, &[5, 0, 0, 0, 0], &half, &period].concat(),
        [&armed[..], &driven, &configure, &half, &[6, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9]].concat(),
        [&guarded[..], &nothing, &period, &nothing, &period, &driven, &open, &period, &driven, &closed, &clear]
            .concat(),
    ]
}

/// Requests of every kind, cycles, bad samples, errors, resets: scripts of [`crate::command`].
pub fn commands() -> Vec<Vec<u8>> {
    let every: Vec<u8> = (0..8u8).flat_map(|kind| [kind << 3, kind % 4, 16 + 9 * kind, 3 | 5 << 3]).collect();
    let bad = [4u8; 24];
    let lengths = [0u8, 0, 90, 3 | 20 << 3, 0, 2, 96, 3 | 20 << 3, 7 | 20 << 3, 3 | 9 << 3];
    let faults = [&bad[..], &bad, &[3 | 4 << 3, 5 | 4 << 3, 1, 6 | 9 << 3], &[5 << 3, 0x80, 0, 3 | 30 << 3]].concat();
    vec![every.clone(), [&lengths[..], &faults, &lengths].concat(), [&every[..], &faults, &every].concat()]
}

/// Visitors who come, ask, are answered, send rubbish, flood, hang up: scripts of [`crate::gate`].
pub fn visitors() -> Vec<Vec<u8>> {
    // what a step does is its lower three bits; the byte behind it chooses a visitor
    let come = [0u8, 0, 0, 0];
    let ask = [1u8, 0, 0, 1, 1, 0];
    let desk = [7 | 0x80 | 15 << 3, 0];
    let fetch = [6 | 8, 0, 6 | 8, 1];
    let flood = [1 | 7 << 3, 0].into_iter().chain([0; 22]).collect::<Vec<u8>>();
    let rubbish = [&[3 | 3 << 3, 1][..], b"GET / HTTP/1.1\r\n\0\0"].concat();
    let longer = [4 | 3 << 3, 0, 0, 4 | 7 << 3, 1, 0];
    let handed = [1 | 0x80, 0, 0, 2 | 0x40, 1, 0];
    let leave = [5, 0, 5 | 1 << 3, 1, 6, 0, 6, 1];
    vec![
        [&come[..], &ask, &desk, &fetch, &ask, &[7, 0], &leave, &come, &ask, &desk].concat(),
        [&come[..], &rubbish, &ask, &desk, &come, &longer, &desk, &handed, &desk, &fetch].concat(),
        [&come[..], &flood, &flood, &desk, &flood, &desk, &flood, &desk, &flood, &[6, 0]].concat(),
    ]
}

/// Drivers a visitor can look at and ask, with words of their memory changed: scripts of [`crate::visit`].
pub fn drivers() -> Vec<Vec<u8>> {
    let answer = [&[0u8][..], &[0; 8], &[3, 0, 0, 0], &[0; 44]].concat();
    let refusal = [&[0u8][..], &[0; 8], &[6, 0, 0, 0, 6, 0, 0, 0], &[0x7f; 40]].concat();
    let nothing = [0u8; 9];
    // the head one further, a slot's cycle another
    let more = [3u8, 2 << 1, 6, 6 << 1 | 1, 0, 12, 7, 0, 0, 0, 0, 0, 0, 0, 4 << 1, 6, 9];
    vec![
        // as it should be, with two answers
        [&[0x80 | 2 << 1][..], &answer, &refusal, &nothing].concat(),
        // first words of another kind
        [&[0x40 | 2 << 1 | 1][..], &[2, 8, 9, 12, 2, 20, 77, 0], &answer].concat(),
        // cycles that come, and come otherwise
        [&[2u8 << 1][..], &[0], &more, &more, &more, &[1, 0, 6], &more].concat(),
        [&[2u8 << 1][..], &more, &more, &nothing].concat(),
        // no memory, and memory that is none
        vec![0],
        [&[1u8 << 1, 26][..], b"sinewbrd", &[1; 200]].concat(),
    ]
}

/// Formats of real converters' elements and a scan of each: for [`crate::scan`].
pub fn scans() -> Vec<Vec<u8>> {
    let scan: Vec<u8> = (0..64u8).map(|byte| byte.wrapping_mul(37)).collect();
    let device = |elements: &[(u8, &str)]| {
        let lines = elements.iter().flat_map(|(index, text)| [&[*index][..], text.as_bytes(), b"\n"].concat());
        [elements.len() as u8].into_iter().chain(lines).chain(scan.iter().copied()).collect::<Vec<u8>>()
    };
    vec![
        // ina2xx-adc, with its timestamp
        device(&[
            (0, "le:u16/16>>0"),
            (1, "le:u16/16>>0"),
            (2, "le:u16/16>>0"),
            (3, "le:s16/16>>0"),
            (4, "le:s64/64>>0"),
        ]),
        // ad7124, max1363, an accelerometer's upper bits
        device(&[(0, "be:u24/32>>8"), (3, "be:u12/16>>0"), (1, "be:s12/16>>4")]),
        // a quaternion beside a voltage
        device(&[(9, "le:s16/16X4>>0"), (2, "le:s8/8>>0")]),
    ]
}
