//! Frames: round trip, damaged, and arbitrary bytes.

use proptest::prelude::*;
use sinew_front_end::wire::checksum;
use sinew_front_end::{
    ChannelFault, ChannelLimits, ChannelRange, Configure, Decoder, Duty, EnableMode, Error, Features, Frame,
    Identification, MAX_BODY, MAX_CHANNELS, MAX_FRAME, RawSample, Refusal, ResetCause, Samples, State, VERSION, decode,
    encode, encode_hello,
};

fn line(frame: &Frame) -> Vec<u8> {
    let mut line = vec![0; MAX_FRAME];
    let length = encode(frame, &mut line).unwrap();
    line.truncate(length);
    line
}

fn frames(line: &[u8]) -> Vec<Result<Frame, Error>> {
    let mut decoder = Decoder::<MAX_BODY>::new();
    line.iter().filter_map(|byte| decoder.push(*byte).map(|body| body.and_then(decode))).collect()
}

fn limits() -> impl Strategy<Value = ChannelLimits> {
    any::<(u16, u16, u32, u32)>().prop_map(|(max_duty, max_current_ma, heat_ma2_s, drain_ma2)| ChannelLimits {
        max_duty,
        max_current_ma,
        heat_ma2_s,
        drain_ma2,
    })
}

/// Values for all places of a frame; those beyond its channels are not sent and come back as nothing.
fn places<T: Copy + std::fmt::Debug>(
    value: impl Strategy<Value = T>,
    nothing: T,
) -> impl Strategy<Value = (u8, [T; MAX_CHANNELS])> {
    prop::collection::vec(value, 0..=MAX_CHANNELS).prop_map(move |given| {
        let mut all = [nothing; MAX_CHANNELS];
        all[..given.len()].copy_from_slice(&given);
        (given.len() as u8, all)
    })
}

fn frame() -> impl Strategy<Value = Frame> {
    let range = (any::<(u32, u32, u32)>(), limits()).prop_map(|((voltage_uv, current_ua, supply_uv), limits)| {
        ChannelRange { voltage_uv, current_ua, supply_uv, limits }
    });
    let raw = any::<(u16, u16, u16, u16, u16)>().prop_map(|(v1, v2, v3, current, supply)| RawSample {
        v1,
        v2,
        v3,
        current,
        supply,
    });
    let faults = vec![
        ChannelFault::OverCurrent,
        ChannelFault::Heat,
        ChannelFault::Converter,
        ChannelFault::StageHot,
        ChannelFault::Stage,
    ];
    let fault = prop_oneof![5 => Just(None), 1 => prop::sample::select(faults).prop_map(Some)];
    let state = prop::sample::select(&[State::Boot, State::Ready, State::Running, State::Tripped, State::Stopped][..]);
    let enable = prop::sample::select(&[EnableMode::None, EnableMode::Level, EnableMode::Pulses][..]);
    let causes = vec![
        ResetCause::Unknown,
        ResetCause::PowerOn,
        ResetCause::BrownOut,
        ResetCause::Watchdog,
        ResetCause::Software,
    ];
    let cause = prop::sample::select(causes);
    let refusals = vec![Refusal::Channels, Refusal::Period, Refusal::Silence, Refusal::Features];
    let features = any::<[bool; 2]>().prop_map(|[enable, stop]| Features { enable, stop });
    prop_oneof![
        any::<u32>().prop_map(|nonce| Frame::Hello { nonce }),
        Just(Frame::Off),
        any::<u8>().prop_map(|channel| Frame::Clear { channel }),
        (any::<(u32, u32, u16)>(), enable, any::<bool>(), places(limits(), ChannelLimits::default())).prop_map(
            |((session, period_ns, watchdog_periods), enable, uses_stop, (channels, limits))| {
                let session = Configure { session, period_ns, watchdog_periods, enable, uses_stop, channels, limits };
                Frame::Configure(session)
            }
        ),
        (any::<u32>(), 1u32.., any::<bool>(), places(any::<u16>(), 0)).prop_map(
            |(sequence, valid_us, supply, (channels, duty))| Frame::Duty(Duty {
                sequence,
                valid_us,
                supply,
                channels,
                duty
            })
        ),
        (
            any::<(u32, [u8; 16], [u8; 3], u64, u32, u32, u32, u16)>(),
            features,
            (cause, any::<[u32; 2]>()),
            places(range, ChannelRange::default())
        )
            .prop_map(|(given, features, (reset, [user, unused_ms]), places)| {
                let (nonce, name, version, serial, min_period_ns, max_period_ns, max_silence_ns, full_code) = given;
                let (channels, channel) = places;
                Frame::Identification(Identification {
                    nonce,
                    name,
                    version,
                    serial,
                    min_period_ns,
                    max_period_ns,
                    max_silence_ns,
                    full_code,
                    features,
                    reset,
                    user,
                    unused_ms,
                    channels,
                    channel,
                })
            }),
        (any::<u32>(), prop::option::of(prop::sample::select(refusals)))
            .prop_map(|(session, refusal)| Frame::Configured { session, refusal }),
        (any::<(u32, u16, u32, u16, u16)>(), state, places((raw, fault), (RawSample::NONE, None)), any::<[bool; 3]>())
            .prop_map(|((sequence, after_us, clock_us, lost, refused), state, (channels, places), flags)| {
                let [stop_open, reset_pressed, limited] = flags;
                Frame::Samples(Samples {
                    sequence,
                    state,
                    stop_open,
                    reset_pressed,
                    after_us,
                    clock_us,
                    lost,
                    refused,
                    channels,
                    sample: places.map(|(raw, _)| raw),
                    fault: places.map(|(_, fault)| fault),
                    limited: u64::from(limited),
                })
            }),
    ]
}

#[test]
fn the_bytes_are_those_of_the_document() {
    // docs/front-end.md prints these; they must not change within a version.
    let hello = line(&Frame::Hello { nonce: 1 });
    assert_eq!(hello, [0x00, 0x04, 0x02, 0x01, 0x01, 0x01, 0x01, 0x05, 0x7d, 0x4e, 0xd6, 0x79, 0x00]);
    let mut duty = [0; MAX_CHANNELS];
    (duty[0], duty[1]) = (0x0102, 0xffff);
    let duty = line(&Frame::Duty(Duty { sequence: 7, valid_us: 5000, supply: true, channels: 2, duty }));
    assert_eq!(
        duty,
        [
            0x00, 0x04, 0x02, 0x03, 0x07, 0x01, 0x01, 0x03, 0x88, 0x13, 0x01, 0x0b, 0x01, 0x02, 0x02, 0x01, 0xff, 0xff,
            0x48, 0xa9, 0x45, 0xdb, 0x00
        ]
    );
}

#[test]
fn a_hello_has_one_layout_whatever_the_version() {
    let mut other = vec![0; MAX_FRAME];
    let length = encode_hello(VERSION, 1, &mut other).unwrap();
    assert_eq!(other[..length], line(&Frame::Hello { nonce: 1 }));
    let length = encode_hello(1, 1, &mut other).unwrap();
    // As release 0.1's driver sent it.
    assert_eq!(other[..length], [0x00, 0x04, 0x01, 0x01, 0x01, 0x01, 0x01, 0x05, 0xd3, 0x3c, 0x42, 0xff, 0x00]);
}

#[test]
fn how_long_frames_are() {
    // docs/front-end.md has these.
    let length = |frame: &Frame| line(frame).len();
    for channels in [1u8, 4, 18, 64] {
        let full = [1; MAX_CHANNELS];
        let raw = RawSample { v1: 1, v2: 1, v3: 1, current: 1, supply: 1 };
        let duty = Frame::Duty(Duty { sequence: 1, valid_us: 1, supply: true, channels, duty: full });
        let samples = Frame::Samples(Samples {
            sequence: 1,
            state: State::Running,
            stop_open: false,
            reset_pressed: false,
            after_us: 1,
            clock_us: 1,
            lost: 0,
            refused: 0,
            channels,
            sample: [raw; MAX_CHANNELS],
            fault: [None; MAX_CHANNELS],
            limited: 0,
        });
        let n = usize::from(channels);
        // The length a run of 254 bytes without a zero would add is not there: these have zeros in them.
        assert_eq!((length(&duty), length(&samples)), (19 + 2 * n, 27 + 10 * n), "{channels} channels");
    }
}

#[test]
fn what_is_no_frame_is_called_what_it_is() {
    assert_eq!(decode(&[]), Err(Error::Length));
    assert_eq!(decode(&[1, 1, 0, 0, 0, 0]), Err(Error::Version { found: 1 }));
    assert_eq!(decode(&[2, 0x55]), Err(Error::Kind { found: 0x55 }));
    assert_eq!(decode(&[2, 1, 0, 0, 0]), Err(Error::Length));
    assert_eq!(decode(&[2, 4, 9]), Err(Error::Length));
    assert_eq!(decode(&[2, 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 65]), Err(Error::Value), "more channels than there can be");
    assert_eq!(decode(&[2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]), Err(Error::Value), "valid for no time");
    assert_eq!(decode(&[2, 3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0]), Err(Error::Value), "a flag there is not");
    assert_eq!(decode(&[2, 0x82, 0, 0, 0, 0, 5]), Err(Error::Value), "a refusal there is not");
    let mut short = [0; 4];
    assert_eq!(encode(&Frame::Off, &mut short), Err(Error::NoRoom));
    let none = Duty { sequence: 0, valid_us: 1, supply: false, channels: 0, duty: [0; MAX_CHANNELS] };
    for wrong in [Duty { channels: 65, ..none }, Duty { valid_us: 0, ..none }] {
        assert_eq!(encode(&Frame::Duty(wrong), &mut [0; MAX_FRAME]), Err(Error::Value));
    }
    assert_eq!(checksum(&[]), 0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_frame_comes_back(all in prop::collection::vec(frame(), 1..6)) {
        let stream: Vec<u8> = all.iter().flat_map(line).collect();
        prop_assert!(all.iter().all(|frame| line(frame).len() <= MAX_FRAME));
        let found: Vec<Frame> = frames(&stream).into_iter().map(Result::unwrap).collect();
        prop_assert_eq!(found, all);
    }

    #[test]
    fn a_damaged_frame_is_never_taken_for_another(
        frame in frame(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), 0u8..8), 1..4),
    ) {
        let whole = line(&frame);
        let mut stream = whole.clone();
        for (place, bit) in damage {
            let place = place.index(stream.len());
            stream[place] ^= 1 << bit;
        }
        for found in frames(&stream).into_iter().flatten() {
            prop_assert_eq!(&found, &frame);
        }
    }

    #[test]
    fn any_body_is_read_without_panic(body in prop::collection::vec(any::<u8>(), 0..1600), kind in any::<u8>()) {
        let _ = decode(&body);
        let mut known = vec![VERSION, kind % 0x90];
        known.extend(body);
        // What is taken is written as the same bytes again.
        if let Ok(frame) = decode(&known) {
            prop_assert_eq!(frames(&line(&frame)), [Ok(frame)]);
        }
    }
}
