//! The firmware over a scripted microcontroller and clock.

use proptest::prelude::*;
use sinew_front_end::{
    ChannelFault, ChannelLimits, ChannelRange, Configure, Decoder, Duty, Event, FULL_DUTY, Firmware, Frame, Hardware,
    Identification, MAX_BODY, MAX_CHANNELS, MAX_FRAME, RawSample, Refusal, Samples, State, decode, encode,
};

const PERIOD_NS: u64 = 1_000_000;
const FULL_CODE: u16 = 4095;

/// Limits no wire here reaches.
const WIDE: ChannelLimits =
    ChannelLimits { max_duty: 60_000, max_current_ma: 2_000, heat_ma2_s: u32::MAX, drain_ma2: 1_000_000 };

fn who(channels: u8) -> Identification {
    Identification {
        nonce: 0,
        name: *b"test\0\0\0\0\0\0\0\0\0\0\0\0",
        version: [1, 2, 3],
        serial: 42,
        min_period_ns: 50_000,
        max_period_ns: 100_000_000,
        max_silence_ns: 200_000_000,
        full_code: FULL_CODE,
        channels,
        channel: [ChannelRange { voltage_uv: 10_000_000, current_ua: 4_095_000, supply_uv: 20_000_000, limits: WIDE };
            MAX_CHANNELS],
    }
}

/// Peripherals that write down what they are told. A code of the current is a milliampere.
struct Bench {
    put: Vec<u16>,
    current: u16,
    sent: Vec<u8>,
    told: Vec<Event>,
    periods: usize,
}

impl Hardware for Bench {
    fn begin_period(&mut self, duty: &[u16], _: u32) {
        self.put = duty.to_vec();
        self.periods += 1;
    }

    fn off(&mut self) {
        self.put.fill(0);
    }

    fn samples(&mut self, samples: &mut [RawSample]) {
        for (raw, duty) in samples.iter_mut().zip(&self.put) {
            if *duty > 0 {
                *raw = RawSample { v1: 1, v2: 2, v3: 3, current: self.current, supply: 5 };
            }
        }
    }

    fn send(&mut self, line: &[u8]) {
        self.sent.extend(line);
    }

    fn tell(&mut self, event: Event) {
        self.told.push(event);
    }
}

/// A front-end with a driver's end of the line and a clock.
struct Line {
    firmware: Firmware,
    bench: Bench,
    now_ns: u64,
    sequence: u32,
}

impl Line {
    fn new(channels: u8) -> Line {
        let bench = Bench { put: Vec::new(), current: 300, sent: Vec::new(), told: Vec::new(), periods: 0 };
        Line { firmware: Firmware::new(who(channels)), bench, now_ns: 5_000, sequence: 100 }
    }

    /// Configured and running.
    fn running(channels: u8) -> Line {
        let mut line = Line::new(channels);
        assert_eq!(line.configure(channels, PERIOD_NS as u32, 5, WIDE), None);
        line.periods(&vec![0; channels.into()], 3);
        assert_eq!(line.firmware.state(), State::Running);
        line
    }

    fn give(&mut self, frame: &Frame) {
        let mut bytes = [0; MAX_FRAME];
        let length = encode(frame, &mut bytes).unwrap();
        self.firmware.receive(&bytes[..length], self.now_ns, &mut self.bench);
    }

    fn answers(&mut self) -> Vec<Frame> {
        let mut decoder = Decoder::<MAX_BODY>::new();
        let sent = std::mem::take(&mut self.bench.sent);
        sent.iter().filter_map(|byte| decoder.push(*byte).map(|body| decode(body.unwrap()).unwrap())).collect()
    }

    fn configure(&mut self, channels: u8, period_ns: u32, watchdog: u16, limits: ChannelLimits) -> Option<Refusal> {
        let limits = [limits; MAX_CHANNELS];
        self.give(&Frame::Configure(Configure {
            session: 9,
            period_ns,
            watchdog_periods: watchdog,
            channels: channels.min(64),
            limits,
        }));
        match self.answers().last() {
            Some(Frame::Configured { session: 9, refusal }) => *refusal,
            other => panic!("{other:?}"),
        }
    }

    fn duty(&mut self, duties: &[u16]) {
        self.sequence += 1;
        let mut duty = [0; MAX_CHANNELS];
        duty[..duties.len()].copy_from_slice(duties);
        self.give(&Frame::Duty(Duty { sequence: self.sequence, channels: duties.len() as u8, duty }));
    }

    /// Lets time pass, polling when the firmware asks for it.
    fn pass(&mut self, time_ns: u64) {
        let end_ns = self.now_ns + time_ns;
        loop {
            let next_ns = self.firmware.poll(self.now_ns, &mut self.bench);
            match next_ns.filter(|next_ns| *next_ns <= end_ns) {
                Some(next_ns) => {
                    assert!(next_ns > self.now_ns, "time goes on");
                    self.now_ns = next_ns;
                }
                None => break,
            }
        }
        self.now_ns = end_ns;
    }

    /// Whole periods, a frame at the beginning of each; the last answer.
    fn periods(&mut self, duties: &[u16], count: usize) -> Samples {
        for _ in 0..count {
            self.duty(duties);
            self.pass(PERIOD_NS);
        }
        match self.answers().last() {
            Some(Frame::Samples(samples)) => *samples,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn it_says_who_it_is() {
    let mut line = Line::new(3);
    line.give(&Frame::Hello { nonce: 77 });
    let answers = line.answers();
    let [Frame::Identification(found)] = answers[..] else { panic!("{} answers", answers.len()) };
    assert_eq!((found.nonce, found.serial, found.channels, found.max_silence_ns), (77, 42, 3, 200_000_000));
    assert_eq!(found.channel[..3], who(3).channel[..3]);
    assert_eq!(line.firmware.state(), State::Boot);
}

#[test]
fn it_refuses_what_it_cannot_keep() {
    let mut line = Line::new(3);
    assert_eq!(line.configure(4, PERIOD_NS as u32, 5, WIDE), Some(Refusal::Channels));
    assert_eq!(line.configure(0, PERIOD_NS as u32, 5, WIDE), Some(Refusal::Channels));
    assert_eq!(line.configure(3, 49_999, 5, WIDE), Some(Refusal::Period));
    assert_eq!(line.configure(3, 0, 5, WIDE), Some(Refusal::Period));
    assert_eq!(line.configure(3, PERIOD_NS as u32, 201, WIDE), Some(Refusal::Silence));
    assert_eq!(line.configure(3, PERIOD_NS as u32, 0, WIDE), Some(Refusal::Silence));
    assert_eq!(line.firmware.state(), State::Boot);
    // Without a configuration nothing is output, and the answer states that.
    line.duty(&[100, 100, 100]);
    line.pass(10 * PERIOD_NS);
    assert!(line.bench.put.iter().all(|duty| *duty == 0));
    assert!(matches!(line.answers()[..], [Frame::Samples(Samples { state: State::Boot, channels: 0, .. })]));
    assert_eq!(line.configure(2, PERIOD_NS as u32, 200, WIDE), None);
}

#[test]
fn it_arms_on_zeros_samples_in_the_period_and_answers_in_time() {
    let mut line = Line::new(2);
    line.configure(2, PERIOD_NS as u32, 5, WIDE);
    // No zeros, no power.
    let answer = line.periods(&[10_000, 0], 20);
    assert_eq!((answer.state, line.bench.put.clone()), (State::Ready, vec![0, 0]));
    line.periods(&[0, 0], 1);
    assert_eq!(line.periods(&[10_000, 0], 1).state, State::Ready, "one frame of zeros is not enough");
    line.periods(&[0, 0], 2);
    for (duty, after_us) in [(1, 125), (20_000, 305), (40_000, 610), (60_000, 750)] {
        let answer = line.periods(&[duty, 0], 1);
        assert_eq!((answer.state, answer.sequence, answer.after_us), (State::Running, line.sequence, after_us));
        assert_eq!(line.bench.put, [duty, 0]);
        assert_eq!(answer.sample[0], RawSample { v1: 1, v2: 2, v3: 3, current: 300, supply: 5 });
        assert_eq!(answer.sample[1], RawSample::NONE);
    }
    let answer = line.periods(&[FULL_DUTY, 5], 1);
    assert_eq!((answer.limited, line.bench.put.clone()), (1, vec![60_000, 5]), "cut down to the limit, and told");
}

#[test]
fn silence_switches_off_in_time_and_only_zeros_bring_it_back() {
    let mut line = Line::running(2);
    line.periods(&[30_000, 100], 10);
    // The last frame came a period ago, and its duties go on until four more have passed.
    line.pass(4 * PERIOD_NS - 1);
    assert_eq!(line.bench.put, [30_000, 100]);
    line.pass(1);
    assert_eq!((line.firmware.state(), line.bench.put.clone()), (State::Tripped, vec![0, 0]));
    assert_eq!(line.bench.told.last(), Some(&Event::Silent { since_ns: 5 * PERIOD_NS, powered: true }));
    assert!(matches!(line.answers().last(), Some(Frame::Samples(Samples { state: State::Tripped, .. }))));
    // A driver that resumes after a stall heats nothing.
    let answer = line.periods(&[30_000, 100], 50);
    assert_eq!((answer.state, line.bench.put.clone()), (State::Tripped, vec![0, 0]));
    assert_eq!(line.periods(&[0, 0], 2).state, State::Running);
    line.periods(&[30_000, 0], 1);
    assert_eq!(line.bench.put, [30_000, 0]);
}

#[test]
fn old_and_doubled_frames_do_not_count() {
    let mut line = Line::running(1);
    line.periods(&[500], 3);
    let old = line.sequence;
    line.periods(&[600], 3);
    line.sequence = old - 1;
    line.duty(&[9_000]);
    assert_eq!(line.bench.put, [600]);
    for _ in 0..10 {
        // The same frame again and again feeds no watchdog.
        line.sequence = old;
        line.duty(&[9_000]);
        line.pass(PERIOD_NS);
    }
    assert_eq!(line.firmware.state(), State::Tripped);
    let Some(Frame::Samples(last)) = line.answers().last().copied() else { panic!("no answer") };
    assert!(last.refused >= 5, "{last:?}");
    // What was left out is counted.
    line.sequence = old + 20;
    assert_eq!(line.periods(&[0], 1).lost, (old + 20 - (old + 3)) as u16);
}

#[test]
fn a_flood_of_frames_heats_no_more() {
    let mut line = Line::running(1);
    line.periods(&[6_000], 5);
    let before = line.bench.periods;
    for _ in 0..1000 {
        line.duty(&[6_000]);
        line.pass(PERIOD_NS / 100);
    }
    assert!(line.bench.periods - before <= 20, "{} periods in 10", line.bench.periods - before);
    // After a stall, the newest of what comes at once is put out.
    line.pass(PERIOD_NS);
    for duty in [1_000, 2_000, 3_000] {
        line.duty(&[duty]);
    }
    line.pass(PERIOD_NS);
    assert_eq!(line.bench.put, [3_000]);
}

#[test]
fn samples_carry_the_number_of_their_own_frame_whatever_the_phase() {
    // Once a frame comes too soon, those after it come in step again, each answered under its own number before the next.
    for phase in [1, 10, 30, 45, 49] {
        let mut line = Line::running(1);
        line.periods(&[500], 3);
        line.duty(&[600]);
        line.pass(PERIOD_NS * phase / 100);
        line.answers();
        for turn in 0..20 {
            line.duty(&[1_000 + turn]);
            let own = line.sequence;
            line.pass(PERIOD_NS);
            let answers: Vec<u32> = line
                .answers()
                .iter()
                .map(|frame| match frame {
                    Frame::Samples(samples) => samples.sequence,
                    other => panic!("{other:?}"),
                })
                .collect();
            if turn > 1 {
                assert_eq!(answers, [own], "phase {phase} turn {turn}");
                assert_eq!(line.bench.put, [1_000 + turn]);
            }
        }
    }
}

#[test]
fn a_channel_with_too_much_current_goes_off_alone() {
    let mut line = Line::running(3);
    line.periods(&[500, 500, 500], 5);
    line.bench.current = 2_500;
    let answer = line.periods(&[0, 500, 0], 3);
    assert_eq!(answer.fault[..3], [None, Some(ChannelFault::OverCurrent), None]);
    assert_eq!(answer.sample[1], RawSample::NONE);
    assert_eq!(line.bench.put, [0, 0, 0]);
    line.bench.current = 300;
    let answer = line.periods(&[500, 500, 500], 5);
    assert_eq!((answer.fault[1], line.bench.put.clone()), (Some(ChannelFault::OverCurrent), vec![500, 0, 500]));
    line.periods(&[500, 0, 500], 3);
    assert_eq!(line.periods(&[500, 500, 500], 1).fault[1], None);
    assert_eq!(line.bench.put, [500, 500, 500]);
}

#[test]
fn no_configuration_widens_what_the_device_bears() {
    let mut line = Line::new(1);
    let all = ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 60_000, ..WIDE };
    line.configure(1, PERIOD_NS as u32, 5, all);
    line.periods(&[0], 2);
    line.periods(&[FULL_DUTY], 1);
    assert_eq!(line.bench.put, [60_000]);
    line.bench.current = 2_001;
    assert_eq!(line.periods(&[FULL_DUTY], 3).fault[0], Some(ChannelFault::OverCurrent));
}

#[test]
fn a_heat_account_survives_a_new_configuration() {
    let limits = ChannelLimits { heat_ma2_s: 1_000, drain_ma2: 10, ..WIDE };
    let mut line = Line::new(1);
    line.configure(1, PERIOD_NS as u32, 5, limits);
    line.periods(&[0], 2);
    // 0.3 A at nine tenths: 1000 mA² s last 12 ms.
    line.periods(&[60_000], 9);
    assert_eq!(line.configure(1, PERIOD_NS as u32, 5, limits), None);
    line.periods(&[0], 2);
    assert_eq!(line.periods(&[60_000], 5).fault[0], Some(ChannelFault::Heat));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_comes_nothing_is_put_out_beyond_the_limits(
        pieces in prop::collection::vec(
            (prop::collection::vec(any::<u8>(), 0..40), 0..8u8, any::<u16>(), 0..3_000_000u64, any::<u16>()), 1..80),
    ) {
        let mut line = Line::running(2);
        for (junk, what, duty, time_ns, current) in pieces {
            line.bench.current = current;
            match what {
                0 => line.firmware.receive(&junk, line.now_ns, &mut line.bench),
                1 => line.give(&Frame::Off),
                2 => line.sequence = line.sequence.wrapping_add(duty.into()),
                3 => line.duty(&[0, 0]),
                _ => line.duty(&[duty, duty / 2]),
            }
            line.pass(time_ns);
            prop_assert!(line.bench.put.iter().all(|duty| *duty <= 60_000));
            if line.firmware.state() != State::Running {
                prop_assert!(line.bench.put.iter().all(|duty| *duty == 0));
            }
        }
        line.pass(5 * PERIOD_NS);
        prop_assert!(line.bench.put.iter().all(|duty| *duty == 0), "silence is always off");
    }
}

#[test]
fn it_fits_a_small_microcontroller() {
    let bytes = std::mem::size_of::<Firmware>();
    println!("Firmware: {bytes} bytes, Frame: {} bytes", std::mem::size_of::<Frame>());
    assert!(bytes <= 8 * 1024, "{bytes}");
}
