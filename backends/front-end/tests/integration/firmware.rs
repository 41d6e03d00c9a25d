//! The firmware over a scripted microcontroller and clock.

use proptest::prelude::*;
use sinew_front_end::{
    ChannelFault, ChannelLimits, ChannelRange, Configure, Decoder, Duty, EnableMode, Event, FULL_DUTY, Features,
    Firmware, Frame, Hardware, Identification, MAX_BODY, MAX_CHANNELS, MAX_FRAME, NOT_SAMPLED, RawSample, Refusal,
    ResetCause, Samples, State, StopPins, decode, encode, encode_hello,
};

const PERIOD_NS: u64 = 1_000_000;
const FULL_CODE: u16 = 4095;

/// A sensing pulse.
const PULSE: u16 = 1_000;
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
        features: Features { enable: true, stop: true },
        reset: ResetCause::BrownOut,
        user: 0,
        unused_ms: 0,
        channels,
        channel: [ChannelRange { voltage_uv: 10_000_000, current_ua: 4_095_000, supply_uv: 20_000_000, limits: WIDE };
            MAX_CHANNELS],
    }
}

/// Peripherals that write down what they are told. A code of the current is a milliampere.
struct Bench {
    put: Vec<u16>,
    current: u16,
    /// Currents with duty 0, by channel; those beyond are not sampled.
    dark: Vec<u16>,
    stage: Option<ChannelFault>,
    /// The enable pin, and how often its level has changed.
    enabled: bool,
    edges: usize,
    stop: Option<StopPins>,
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
        for (channel, (raw, duty)) in samples.iter_mut().zip(&self.put).enumerate() {
            let dark = self.dark.get(channel).copied();
            if let Some(current) = if *duty > 0 { Some(self.current) } else { dark } {
                *raw = RawSample { v1: 1, v2: 2, v3: 3, current, supply: 5 };
            }
        }
    }

    fn stage_fault(&mut self, channel: usize) -> Option<ChannelFault> {
        self.stage.filter(|_| channel == 0)
    }

    fn enable(&mut self, on: bool) {
        self.edges += usize::from(self.enabled != on);
        self.enabled = on;
    }

    fn stop_inputs(&mut self) -> Option<StopPins> {
        self.stop
    }

    fn send(&mut self, line: &[u8]) {
        self.sent.extend(line);
    }

    fn tell(&mut self, event: Event) {
        self.told.push(event);
    }
}

const CLOSED: Option<StopPins> = Some(StopPins { closed: true, reset_pressed: false });
const OPEN: Option<StopPins> = Some(StopPins { closed: false, reset_pressed: false });

/// What a driver asks for beside limits.
#[derive(Clone, Copy)]
struct Wish {
    enable: EnableMode,
    uses_stop: bool,
}

const PLAIN: Wish = Wish { enable: EnableMode::None, uses_stop: false };

/// A front-end with a driver's end of the line and a clock.
struct Line {
    firmware: Firmware,
    bench: Bench,
    now_ns: u64,
    sequence: u32,
    valid_us: u32,
    supply: bool,
}

impl Line {
    fn new(channels: u8) -> Line {
        Line::of(who(channels))
    }

    fn of(who: Identification) -> Line {
        let bench = Bench {
            put: Vec::new(),
            current: 300,
            dark: Vec::new(),
            stage: None,
            enabled: false,
            edges: 0,
            stop: CLOSED,
            sent: Vec::new(),
            told: Vec::new(),
            periods: 0,
        };
        let firmware = Firmware::new(who);
        Line { firmware, bench, now_ns: 5_000, sequence: 100, valid_us: u32::MAX, supply: true }
    }

    /// Configured and running, with its current measured.
    fn running(channels: u8) -> Line {
        Line::running_with(channels, WIDE, PLAIN)
    }

    fn running_with(channels: u8, limits: ChannelLimits, wish: Wish) -> Line {
        let mut line = Line::new(channels);
        assert_eq!(line.wish(channels, PERIOD_NS as u32, 5, limits, wish), None);
        line.periods(&vec![0; channels.into()], 3);
        assert_eq!(line.firmware.state(), State::Running);
        line.periods(&vec![PULSE; channels.into()], 1);
        line
    }

    /// Lets an account drain.
    fn cool(&mut self, limits: ChannelLimits) {
        let periods = u64::from(limits.heat_ma2_s) * 1000 / u64::from(limits.drain_ma2);
        let nothing = vec![0; self.firmware.put_out().len()];
        self.periods(&nothing, periods as usize + 2);
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
        self.wish(channels, period_ns, watchdog, limits, PLAIN)
    }

    fn wish(
        &mut self,
        channels: u8,
        period_ns: u32,
        watchdog: u16,
        limits: ChannelLimits,
        Wish { enable, uses_stop }: Wish,
    ) -> Option<Refusal> {
        let limits = [limits; MAX_CHANNELS];
        self.give(&Frame::Configure(Configure {
            session: 9,
            period_ns,
            watchdog_periods: watchdog,
            enable,
            uses_stop,
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
        let (sequence, valid_us, supply) = (self.sequence, self.valid_us, self.supply);
        self.give(&Frame::Duty(Duty { sequence, valid_us, supply, channels: duties.len() as u8, duty }));
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
fn it_says_who_drove_its_outputs_last_and_for_how_long_nobody_has() {
    let mut line = Line::new(1);
    let said = |line: &mut Line| {
        line.give(&Frame::Hello { nonce: 1 });
        match line.answers()[..] {
            [Frame::Identification(who)] => (who.user, who.unused_ms),
            ref other => panic!("{other:?}"),
        }
    };
    assert_eq!(said(&mut line), (0, 0), "it has just started");
    line.now_ns += 3_000_000_000;
    assert_eq!(said(&mut line), (0, 3000));
    // A configuration and frames of zeros drive nothing.
    line.configure(1, PERIOD_NS as u32, 5, WIDE);
    line.periods(&[0], 10);
    assert_eq!(said(&mut line), (0, 3010));
    line.duty(&[PULSE]);
    assert_eq!(said(&mut line), (9, 0));
    line.pass(PERIOD_NS);
    line.answers();
    line.periods(&[0], 20);
    assert_eq!(said(&mut line), (9, 20));
    // Silent, and on until it trips after five periods.
    line.periods(&[PULSE], 1);
    line.pass(2_000_000_000);
    line.answers();
    let (user, unused_ms) = said(&mut line);
    assert!(user == 9 && (1990..=2000).contains(&unused_ms), "{unused_ms}");
    // Somebody else who drives it, and one that is refused.
    line.configure(2, PERIOD_NS as u32, 5, WIDE);
    line.give(&Frame::Configure(Configure {
        session: 10,
        period_ns: PERIOD_NS as u32,
        watchdog_periods: 5,
        enable: EnableMode::None,
        uses_stop: false,
        channels: 1,
        limits: [WIDE; MAX_CHANNELS],
    }));
    line.answers();
    line.periods(&[0], 3);
    assert_eq!(said(&mut line).0, 9);
    line.periods(&[PULSE], 1);
    assert_eq!(said(&mut line).0, 10);
    // A stage that conducts by itself is in use.
    line.bench.dark = vec![400];
    line.periods(&[0], 500);
    assert_eq!(said(&mut line), (10, 0));
    line.bench.dark = vec![0];
    line.periods(&[0], 10);
    line.give(&Frame::Clear { channel: 0 });
    line.periods(&[0], 10);
    let (_, unused_ms) = said(&mut line);
    assert!((10..=22).contains(&unused_ms), "{unused_ms} ms, though it conducted");
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
    line.periods(&[PULSE, 0], 1);
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
}

/// Limits with which a full account drains within a second.
const NARROW: ChannelLimits = ChannelLimits { heat_ma2_s: 10_000, drain_ma2: 10_000, ..WIDE };

#[test]
fn a_fault_is_forgotten_when_it_is_told_and_not_before() {
    let mut line = Line::running_with(2, NARROW, PLAIN);
    line.cool(NARROW);
    line.bench.current = 2_500;
    assert_eq!(line.periods(&[500, 0], 2).fault[..2], [Some(ChannelFault::OverCurrent), None]);
    line.bench.current = 300;
    assert_eq!(line.periods(&[0, 0], 1000).fault[0], Some(ChannelFault::OverCurrent), "idle frames clear nothing");
    line.give(&Frame::Clear { channel: 1 });
    line.give(&Frame::Clear { channel: 2 });
    line.give(&Frame::Clear { channel: 255 });
    let answer = line.periods(&[500, 500], 1);
    assert_eq!((answer.fault[0], answer.refused), (Some(ChannelFault::OverCurrent), 2), "another's, and none's");
    // The stage still says so.
    line.bench.stage = Some(ChannelFault::StageHot);
    line.give(&Frame::Clear { channel: 0 });
    line.bench.stage = None;
    assert_eq!(line.periods(&[500, 500], 1).fault[0], Some(ChannelFault::OverCurrent));
    line.give(&Frame::Clear { channel: 0 });
    assert_eq!(line.periods(&[500, 500], 3).fault[0], None);
    assert_eq!(line.bench.put, [500, 500]);
    // Where the cause is still there, two periods show it.
    line.bench.current = 2_500;
    line.periods(&[500, 0], 2);
    line.give(&Frame::Clear { channel: 0 });
    assert_eq!(line.periods(&[500, 0], 1).fault[0], None);
    assert_eq!(line.periods(&[500, 0], 1).fault[0], Some(ChannelFault::OverCurrent));
}

#[test]
fn a_hot_wire_s_fault_is_not_forgotten_before_it_has_cooled() {
    let mut line = Line::running_with(1, NARROW, PLAIN);
    // Twice the current from one period to the next: more than it can be cut down for.
    line.bench.current = 1_900;
    let periods = (0..100).find(|_| line.periods(&[FULL_DUTY], 1).fault[0] == Some(ChannelFault::Heat));
    assert_eq!(periods, Some(0), "a fifth beyond the budget in one period of forty times the heat");
    // From 1.2 to 0.8 of 10000 mA² s, of which 10000 mA² drain, in 0.4 s.
    for cooled_ms in 0..600 {
        line.give(&Frame::Clear { channel: 0 });
        if line.periods(&[0], 1).fault[0].is_none() {
            assert!(cooled_ms > 350, "{cooled_ms} ms");
            return;
        }
    }
    panic!("never");
}

#[test]
fn a_firmware_that_has_just_booted_takes_its_wires_for_hot() {
    let mut line = Line::new(1);
    line.configure(1, PERIOD_NS as u32, 5, NARROW);
    line.periods(&[0], 2);
    // Nothing was measured: 10000 of 2000² mA², which is less than the 5 µs a conversion needs, and what two periods drained.
    let answer = line.periods(&[40_000], 1);
    assert_eq!(answer.limited, 1);
    assert!((328..500).contains(&line.bench.put[0]), "{:?}", line.bench.put);
    assert_eq!(answer.sample[0].current, 300, "which can be measured");
    // 10000 of 300² mA².
    let answer = line.periods(&[40_000], 10);
    assert!((7_200..=7_700).contains(&line.bench.put[0]), "{:?}", line.bench.put);
    assert_eq!(answer.limited, 1);
    // The sensing pulse goes through, and time passes without a fault.
    assert_eq!((line.periods(&[PULSE], 1).limited, line.bench.put.clone()), (0, vec![PULSE]));
    assert_eq!(line.periods(&[40_000], 20_000).fault[0], None);
    assert!(line.bench.put[0] < 7_700, "and without more heat: {:?}", line.bench.put);
    // A new configuration is no boot, and cools nothing either.
    line.configure(1, PERIOD_NS as u32, 5, NARROW);
    line.periods(&[0], 2);
    line.periods(&[40_000], 10);
    assert!(line.bench.put[0] < 7_900, "{:?}", line.bench.put);
    // Once it has cooled, it is given what is asked for.
    line.cool(NARROW);
    assert_eq!((line.periods(&[40_000], 1).limited, line.bench.put.clone()), (0, vec![40_000]));
}

#[test]
fn a_frame_is_valid_for_as_long_as_it_says_and_the_watchdog_allows() {
    for (valid_us, off_ns) in [(2_000, 2 * PERIOD_NS), (1, 1_000), (6_000, 5 * PERIOD_NS), (u32::MAX, 5 * PERIOD_NS)] {
        let mut line = Line::running(1);
        line.periods(&[20_000], 10);
        line.valid_us = valid_us;
        line.duty(&[20_000]);
        line.pass(off_ns - 1);
        assert_eq!((line.firmware.state(), &line.bench.put[..]), (State::Running, &[20_000][..]), "{valid_us} µs");
        line.pass(1);
        assert_eq!((line.firmware.state(), &line.bench.put[..]), (State::Tripped, &[0][..]), "{valid_us} µs");
        let Some(Frame::Samples(last)) = line.answers().last().copied() else { panic!("no answer") };
        assert_eq!((last.state, last.sequence), (State::Tripped, line.sequence));
    }
}

#[test]
fn what_the_device_has_not_is_refused() {
    let plain = Identification { features: Features::default(), ..who(1) };
    let period_ns = PERIOD_NS as u32;
    for enable in [EnableMode::Level, EnableMode::Pulses] {
        let wish = Wish { enable, ..PLAIN };
        assert_eq!(Line::of(plain).wish(1, period_ns, 5, WIDE, wish), Some(Refusal::Features));
        assert_eq!(Line::new(1).wish(1, period_ns, 5, WIDE, wish), None);
    }
    let wish = Wish { uses_stop: true, ..PLAIN };
    assert_eq!(Line::of(plain).wish(1, period_ns, 5, WIDE, wish), Some(Refusal::Features));
    assert_eq!(Line::new(1).wish(1, period_ns, 5, WIDE, wish), None);
    assert_eq!(Line::of(plain).configure(1, period_ns, 5, WIDE), None);
}

#[test]
fn the_enable_pin_is_on_in_running_alone_and_only_where_the_frame_lets_it() {
    let mut line = Line::new(1);
    let level = Wish { enable: EnableMode::Level, ..PLAIN };
    line.wish(1, PERIOD_NS as u32, 5, WIDE, level);
    line.periods(&[0], 1);
    assert!(!line.bench.enabled, "not armed");
    line.periods(&[0], 1);
    assert!(line.bench.enabled, "with the first period that is");
    line.periods(&[500], 5);
    // At once, though it asks for the same duty.
    line.supply = false;
    line.pass(PERIOD_NS / 10);
    line.duty(&[500]);
    assert!(!line.bench.enabled);
    line.pass(PERIOD_NS);
    line.periods(&[500], 3);
    assert!(!line.bench.enabled);
    line.supply = true;
    line.periods(&[500], 1);
    assert!(line.bench.enabled);
    // Off, a configuration, a trip: the last one also with nothing put out, since only gates keep it off.
    line.give(&Frame::Off);
    assert!(!line.bench.enabled);
    line.periods(&[0], 2);
    assert!(line.bench.enabled);
    line.wish(1, PERIOD_NS as u32, 5, WIDE, level);
    assert!(!line.bench.enabled);
    line.periods(&[0], 2);
    line.pass(4 * PERIOD_NS);
    assert_eq!((line.firmware.state(), line.bench.enabled), (State::Tripped, false));
    // Who does not ask for it has none.
    let mut line = Line::running(1);
    line.periods(&[500], 5);
    assert!(!line.bench.enabled && line.bench.edges == 0);
}

#[test]
fn a_watchdog_relay_gets_an_edge_a_period_until_there_is_nobody() {
    let mut line = Line::running_with(1, WIDE, Wish { enable: EnableMode::Pulses, ..PLAIN });
    let before = line.bench.edges;
    line.periods(&[500], 20);
    assert_eq!(line.bench.edges - before, 20);
    line.supply = false;
    line.periods(&[500], 3);
    let before = line.bench.edges;
    line.periods(&[500], 20);
    assert_eq!((line.bench.edges, line.bench.enabled), (before, false));
    line.supply = true;
    line.periods(&[500], 3);
    line.pass(20 * PERIOD_NS);
    let before = line.bench.edges;
    line.pass(20 * PERIOD_NS);
    assert_eq!((line.bench.edges, line.bench.enabled), (before, false), "silence ends it");
}

const GUARDED: Wish = Wish { enable: EnableMode::Level, uses_stop: true };

#[test]
fn an_open_stop_switches_off_in_the_poll_that_sees_it() {
    let mut line = Line::running_with(2, WIDE, GUARDED);
    line.periods(&[30_000, 100], 5);
    line.duty(&[30_000, 100]);
    line.pass(PERIOD_NS / 10);
    line.answers();
    line.bench.stop = OPEN;
    line.firmware.poll(line.now_ns, &mut line.bench);
    assert_eq!((line.firmware.state(), &line.bench.put[..]), (State::Stopped, &[0, 0][..]));
    assert!(!line.bench.enabled);
    assert_eq!(line.bench.told.last(), Some(&Event::Stopped));
    let Some(Frame::Samples(said)) = line.answers().last().copied() else { panic!("no answer") };
    assert!(said.state == State::Stopped && said.stop_open, "{said:?}");
    // Whatever comes, as long as it is open.
    for duties in [[30_000, 100], [0, 0]] {
        let answer = line.periods(&duties, 10);
        assert_eq!((answer.state, answer.stop_open, &line.bench.put[..]), (State::Stopped, true, &[0, 0][..]));
        assert!(answer.sample[1].current == NOT_SAMPLED && !line.bench.enabled);
    }
    // Nor two frames of zeros that a stalled line delivers at once.
    line.sequence += 2;
    let (mut bytes, mut length) = ([0; MAX_FRAME], 0);
    for sequence in [line.sequence - 1, line.sequence] {
        let zeros = Duty { sequence, valid_us: u32::MAX, supply: true, channels: 2, duty: [0; MAX_CHANNELS] };
        length += encode(&Frame::Duty(zeros), &mut bytes[length..]).unwrap();
    }
    line.firmware.receive(&bytes[..length], line.now_ns, &mut line.bench);
    assert_eq!((line.firmware.state(), line.bench.enabled), (State::Stopped, false));
    line.give(&Frame::Off);
    line.wish(2, PERIOD_NS as u32, 5, WIDE, GUARDED);
    assert_eq!(line.periods(&[0, 0], 5).state, State::Stopped);
    // Closed, it waits for two frames of zeros that came since.
    line.bench.stop = CLOSED;
    let answer = line.periods(&[30_000, 100], 10);
    assert_eq!((answer.state, answer.stop_open, &line.bench.put[..]), (State::Stopped, false, &[0, 0][..]));
    assert_eq!(line.periods(&[0, 0], 1).state, State::Stopped);
    assert_eq!(line.periods(&[0, 0], 1).state, State::Running);
    line.periods(&[30_000, 100], 1);
    assert_eq!((&line.bench.put[..], line.bench.enabled), (&[30_000, 100][..], true));
}

#[test]
fn an_opening_shorter_than_a_period_is_not_missed() {
    let mut line = Line::running_with(1, WIDE, GUARDED);
    line.periods(&[500], 5);
    line.duty(&[500]);
    line.pass(PERIOD_NS * 3 / 10);
    // A firmware that is only called when it asks to be looks four times a period.
    line.answers();
    let next_ns = line.firmware.poll(line.now_ns, &mut line.bench).unwrap();
    assert!(next_ns <= line.now_ns + PERIOD_NS / 4, "{next_ns}");
    line.bench.stop = OPEN;
    line.now_ns = next_ns;
    line.pass(1);
    line.bench.stop = CLOSED;
    assert_eq!((line.firmware.state(), &line.bench.put[..]), (State::Stopped, &[0][..]));
    let said: Vec<bool> = line
        .answers()
        .iter()
        .map(|frame| match frame {
            Frame::Samples(samples) => samples.stop_open,
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(!said.is_empty() && said.iter().all(|open| *open), "{said:?}");
    line.pass(PERIOD_NS / 2);
    // Said once more with the next samples, and not for ever.
    assert!(!line.periods(&[500], 2).stop_open);
    assert_eq!(line.firmware.state(), State::Stopped);
    line.bench.stop = Some(StopPins { closed: true, reset_pressed: true });
    assert!(line.periods(&[0], 1).reset_pressed);
    // Where its pins show nothing it is open; where nobody asked for it nobody looks.
    line.bench.stop = None;
    assert_eq!(line.periods(&[0], 3).state, State::Stopped);
    let mut line = Line::running(1);
    line.bench.stop = OPEN;
    assert_eq!(line.periods(&[500], 3).state, State::Running);
}

#[test]
fn a_stage_that_conducts_in_the_dark_is_seen_booked_and_loses_its_supply() {
    let limits = ChannelLimits { max_current_ma: 1_000, ..NARROW };
    let mut line = Line::running_with(2, limits, Wish { enable: EnableMode::Level, ..PLAIN });
    line.cool(NARROW);
    line.bench.dark = vec![3, 2];
    let answer = line.periods(&[0, 500], 100);
    let dark = RawSample { v1: 1, v2: 2, v3: 3, current: 3, supply: 5 };
    assert_eq!((answer.sample[0], answer.fault[0]), (dark, None), "what is converted in the dark goes up");
    line.bench.dark = vec![600, 2];
    let answer = line.periods(&[0, 500], 1);
    assert_eq!((answer.sample[0].current, answer.fault[0], line.bench.enabled), (600, None, true));
    let answer = line.periods(&[0, 500], 1);
    assert_eq!(answer.fault[..2], [Some(ChannelFault::Stage), None]);
    assert_eq!(answer.sample[0].current, 600, "so that the driver sees it twice as well");
    assert!(!line.bench.enabled);
    let answer = line.periods(&[0, 500], 5);
    assert_eq!(
        (answer.fault[0], answer.sample[0], line.bench.enabled),
        (Some(ChannelFault::Stage), RawSample::NONE, false)
    );
    // While it conducts it is not forgotten; without a supply nobody can know.
    line.give(&Frame::Clear { channel: 0 });
    assert!(line.periods(&[0, 0], 1).fault[0].is_some());
    line.bench.dark = vec![3, 2];
    line.periods(&[0, 0], 1);
    line.give(&Frame::Clear { channel: 0 });
    assert_eq!((line.periods(&[0, 0], 1).fault[0], line.bench.enabled), (None, true));
    // A current beside a duty that was not put out says nothing of the wire, and nor does none.
    line.pass(10 * PERIOD_NS);
    assert_eq!(line.firmware.state(), State::Tripped);
    let answer = line.periods(&[500, 0], 1);
    assert_eq!(answer.sample[0], RawSample { supply: 5, ..RawSample::NONE });
    assert_eq!(answer.sample[1].current, 2);
}

#[test]
fn heat_that_flows_in_the_dark_is_on_the_account() {
    let mut line = Line::running_with(1, NARROW, PLAIN);
    line.cool(NARROW);
    line.bench.dark = vec![900];
    // 0.81 A² fill 10000 mA² s in 13 ms.
    line.periods(&[0], 20);
    line.bench.dark = vec![0];
    line.periods(&[0], 2);
    line.give(&Frame::Clear { channel: 0 });
    assert_eq!(line.periods(&[0], 1).fault[0], Some(ChannelFault::Stage), "too hot to be reset");
}

#[test]
fn a_hello_of_any_version_is_answered_in_its_own() {
    let mut line = Line::new(1);
    let mut bytes = [0; MAX_FRAME];
    let length = encode_hello(1, 5, &mut bytes).unwrap();
    line.firmware.receive(&bytes[..length], line.now_ns, &mut line.bench);
    let answers = line.answers();
    assert!(
        matches!(answers[..], [Frame::Identification(who)] if who.nonce == 5 && who.reset == ResetCause::BrownOut),
        "{answers:?}"
    );
}

#[test]
fn no_configuration_widens_what_the_device_bears() {
    let mut line = Line::new(1);
    let all = ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 60_000, ..WIDE };
    line.configure(1, PERIOD_NS as u32, 5, all);
    line.periods(&[0], 2);
    line.periods(&[PULSE], 1);
    line.periods(&[FULL_DUTY], 1);
    assert_eq!(line.bench.put, [60_000]);
    line.bench.current = 2_001;
    assert_eq!(line.periods(&[FULL_DUTY], 3).fault[0], Some(ChannelFault::OverCurrent));
    // I²t and what drains: a full account gets what the device's own limit lets drain, and no more.
    let ranges = ChannelRange { limits: NARROW, ..who(1).channel[0] };
    let mut line = Line::of(Identification { channel: [ranges; MAX_CHANNELS], ..who(1) });
    line.configure(1, PERIOD_NS as u32, 5, ChannelLimits { heat_ma2_s: u32::MAX, drain_ma2: u32::MAX, ..WIDE });
    line.periods(&[0], 2);
    line.periods(&[PULSE], 1);
    line.periods(&[FULL_DUTY], 100);
    assert!(line.bench.put[0] < 8_000, "{:?}", line.bench.put);
    // Narrower ones hold.
    line.configure(1, PERIOD_NS as u32, 5, ChannelLimits { max_duty: 2_000, max_current_ma: 250, ..NARROW });
    line.periods(&[0], 2);
    line.periods(&[FULL_DUTY], 1);
    assert_eq!(line.bench.put, [2_000]);
    assert_eq!(line.periods(&[FULL_DUTY], 2).fault[0], Some(ChannelFault::OverCurrent));
}

#[test]
fn a_heat_account_survives_a_new_configuration() {
    let mut line = Line::running_with(1, NARROW, PLAIN);
    line.cool(NARROW);
    // 0.3 A at nine tenths less what drains: 10000 mA² s last 138 ms.
    line.periods(&[60_000], 130);
    assert_eq!(line.configure(1, PERIOD_NS as u32, 5, NARROW), None);
    line.periods(&[0], 2);
    line.periods(&[60_000], 20);
    assert!(line.bench.put[0] < 8_000, "{:?}", line.bench.put);
    // And a fault.
    line.bench.current = 2_500;
    assert_eq!(line.periods(&[500], 2).fault[0], Some(ChannelFault::OverCurrent));
    assert_eq!(line.configure(1, PERIOD_NS as u32, 5, NARROW), None);
    assert_eq!(line.periods(&[0], 5).fault[0], Some(ChannelFault::OverCurrent));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn whatever_comes_nothing_is_put_out_beyond_the_limits(
        pieces in prop::collection::vec(
            (prop::collection::vec(any::<u8>(), 0..40), 0..12u8, any::<u16>(), 0..3_000_000u64, any::<u16>()), 1..80),
    ) {
        let mut line = Line::running_with(2, WIDE, GUARDED);
        for (junk, what, duty, time_ns, current) in pieces {
            line.bench.current = current;
            match what {
                0 => line.firmware.receive(&junk, line.now_ns, &mut line.bench),
                1 => line.give(&Frame::Off),
                2 => line.sequence = line.sequence.wrapping_add(duty.into()),
                3 => line.duty(&[0, 0]),
                4 => line.give(&Frame::Clear { channel: (duty % 3) as u8 }),
                5 => line.bench.stop = if duty % 4 == 0 { OPEN } else { CLOSED },
                6 => line.bench.dark = vec![duty; 2],
                7 => line.supply = duty % 4 != 0,
                _ => line.duty(&[duty, duty / 2]),
            }
            line.pass(time_ns);
            prop_assert!(line.bench.put.iter().all(|duty| *duty <= 60_000));
            if line.firmware.state() != State::Running {
                prop_assert!(line.bench.put.iter().all(|duty| *duty == 0) && !line.bench.enabled);
            }
            prop_assert!(line.supply || what != 3 && what < 8 || !line.bench.enabled, "the frame forbids it");
            prop_assert!(line.bench.stop == CLOSED || time_ns < PERIOD_NS / 4 || !line.bench.enabled);
        }
        line.pass(5 * PERIOD_NS);
        prop_assert!(line.bench.put.iter().all(|duty| *duty == 0) && !line.bench.enabled, "silence is always off");
    }
}

#[test]
fn it_fits_a_small_microcontroller() {
    let bytes = std::mem::size_of::<Firmware>();
    println!("Firmware: {bytes} bytes, Frame: {} bytes", std::mem::size_of::<Frame>());
    assert!(bytes <= 8 * 1024, "{bytes}");
}
