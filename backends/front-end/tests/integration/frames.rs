//! Frames: round trip, damaged, and arbitrary bytes.

use proptest::prelude::*;
use sinew_front_end::wire::checksum;
use sinew_front_end::{
    ChannelFault, ChannelLimits, ChannelRange, Configure, Decoder, Duty, Error, Frame, Identification, MAX_BODY,
    MAX_CHANNELS, MAX_FRAME, RawSample, Refusal, Samples, State, decode, encode,
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
    let fault = prop_oneof![
        5 => Just(None),
        1 => Just(Some(ChannelFault::OverCurrent)),
        1 => Just(Some(ChannelFault::Heat)),
        1 => Just(Some(ChannelFault::Stage)),
    ];
    let state = prop_oneof![Just(State::Boot), Just(State::Ready), Just(State::Running), Just(State::Tripped)];
    prop_oneof![
        any::<u32>().prop_map(|nonce| Frame::Hello { nonce }),
        Just(Frame::Off),
        (any::<(u32, u32, u16)>(), places(limits(), ChannelLimits::default())).prop_map(
            |((session, period_ns, watchdog_periods), (channels, limits))| {
                Frame::Configure(Configure { session, period_ns, watchdog_periods, channels, limits })
            }
        ),
        (any::<u32>(), places(any::<u16>(), 0)).prop_map(|(sequence, (channels, duty))| Frame::Duty(Duty {
            sequence,
            channels,
            duty
        })),
        (any::<(u32, [u8; 16], [u8; 3], u64, u32, u32, u32, u16)>(), places(range, ChannelRange::default())).prop_map(
            |((nonce, name, version, serial, min_period_ns, max_period_ns, max_silence_ns, full_code), places)| {
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
                    channels,
                    channel,
                })
            }
        ),
        (any::<u32>(), prop_oneof![Just(None), Just(Some(Refusal::Period)), Just(Some(Refusal::Silence))])
            .prop_map(|(session, refusal)| Frame::Configured { session, refusal }),
        (any::<(u32, u16, u32, u16, u16)>(), state, places((raw, fault), (RawSample::NONE, None)), any::<bool>())
            .prop_map(|((sequence, after_us, clock_us, lost, refused), state, (channels, places), limited)| {
                Frame::Samples(Samples {
                    sequence,
                    state,
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
    assert_eq!(hello, [0x00, 0x04, 0x01, 0x01, 0x01, 0x01, 0x01, 0x05, 0xd3, 0x3c, 0x42, 0xff, 0x00]);
    let mut duty = [0; MAX_CHANNELS];
    (duty[0], duty[1]) = (0x0102, 0xffff);
    let duty = line(&Frame::Duty(Duty { sequence: 7, channels: 2, duty }));
    assert_eq!(
        duty,
        [0x00, 0x04, 0x01, 0x03, 0x07, 0x01, 0x01, 0x0a, 0x02, 0x02, 0x01, 0xff, 0xff, 0xc5, 0x5b, 0x72, 0x4a, 0x00]
    );
}

#[test]
fn what_is_no_frame_is_called_what_it_is() {
    assert_eq!(decode(&[]), Err(Error::Length));
    assert_eq!(decode(&[2, 1, 0, 0, 0, 0]), Err(Error::Version { found: 2 }));
    assert_eq!(decode(&[1, 0x55]), Err(Error::Kind { found: 0x55 }));
    assert_eq!(decode(&[1, 1, 0, 0, 0]), Err(Error::Length));
    assert_eq!(decode(&[1, 4, 9]), Err(Error::Length));
    assert_eq!(decode(&[1, 3, 0, 0, 0, 0, 65]), Err(Error::Value), "more channels than there can be");
    let mut short = [0; 4];
    assert_eq!(encode(&Frame::Off, &mut short), Err(Error::NoRoom));
    let too_many = Frame::Duty(Duty { sequence: 0, channels: 65, duty: [0; MAX_CHANNELS] });
    assert_eq!(encode(&too_many, &mut [0; MAX_FRAME]), Err(Error::Value));
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
        let mut known = vec![1, kind % 0x90];
        known.extend(body);
        // What is taken is written as the same bytes again.
        if let Ok(frame) = decode(&known) {
            prop_assert_eq!(frames(&line(&frame)), [Ok(frame)]);
        }
    }
}
