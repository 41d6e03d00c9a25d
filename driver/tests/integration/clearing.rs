//! Hardware that latches its own faults: a reset asks it to forget them, and waits for what the next exchanges tell.

use crate::common::{Fake, rig};
use sinew_backend::{Backend, BackendError, ChannelFault, Sample, Zero};
use sinew_driver::{Answer, Ask, Beat, Engine, Event, Occurrence, Order};
use sinew_ipc::Fault;

/// Latches faults of single channels until it is told to forget them, which takes it some exchanges.
struct Latching {
    fake: Fake,
    latched: Vec<Option<ChannelFault>>,
    /// Whose cause is still there: such a fault is latched anew at once.
    remains: Vec<bool>,
    forgets_in: Vec<u32>,
    takes: u32,
    cleared: u32,
}

impl Backend for Latching {
    fn channels(&self) -> usize {
        self.fake.channels()
    }

    fn start(&mut self) -> Result<(), BackendError> {
        self.fake.start()
    }

    fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
        let duty: Vec<f64> =
            duty.iter().zip(&self.latched).map(|(duty, latched)| if latched.is_some() { 0.0 } else { *duty }).collect();
        self.fake.exchange(&duty, samples)?;
        for (channel, sample) in samples.iter_mut().enumerate() {
            if self.forgets_in[channel] > 0 {
                self.forgets_in[channel] -= 1;
                if self.forgets_in[channel] == 0 && !self.remains[channel] {
                    self.latched[channel] = None;
                }
            }
            if self.latched[channel].is_some() {
                *sample = Sample::NONE;
            }
        }
        let lowest = (0..self.latched.len()).find_map(|channel| Some((channel as u32, self.latched[channel]?)));
        lowest.map_or(Ok(()), |(channel, fault)| Err(BackendError::Channel { channel, fault }))
    }

    fn failure(&self, channel: usize) -> Option<ChannelFault> {
        self.latched[channel]
    }

    fn clear(&mut self, channel: usize) {
        self.cleared += 1;
        self.forgets_in[channel] = self.takes;
    }

    fn silence_s(&self) -> Option<f64> {
        Some(0.1)
    }

    fn stop(&mut self) -> Zero {
        self.fake.stop()
    }
}

struct Bench {
    engine: Engine,
    backend: Latching,
    duty: Vec<f64>,
    samples: Vec<Sample>,
    now_ns: u64,
    answer: Option<Answer>,
    tripped: Vec<(u32, Fault)>,
}

impl Bench {
    fn new(channels: usize, takes: u32) -> Bench {
        let rig = rig("clearing", channels, 1000.0);
        let mut backend = Latching {
            fake: Fake::new(&rig),
            latched: vec![None; channels],
            remains: vec![false; channels],
            forgets_in: vec![0; channels],
            takes,
            cleared: 0,
        };
        backend.start().unwrap();
        let mut bench = Bench {
            engine: Engine::at_rest(&rig, None).unwrap(),
            backend,
            duty: vec![0.0; channels],
            samples: vec![Sample::NONE; channels],
            now_ns: 0,
            answer: None,
            tripped: Vec::new(),
        };
        bench.run(30);
        bench
    }

    fn run(&mut self, cycles: u64) {
        for _ in 0..cycles {
            self.now_ns += 1_000_000;
            let exchanged = self.backend.exchange(&self.duty, &mut self.samples);
            self.engine.note_outputs(&self.backend);
            self.engine.clear(&mut self.backend);
            let (answer, tripped) = (&mut self.answer, &mut self.tripped);
            let tell = |event: Event| match event.what {
                Occurrence::Answered { answer: found, .. } => *answer = Some(found),
                Occurrence::Tripped(fault) => tripped.push((event.channel, fault)),
                _ => {}
            };
            let beat = Beat { now_ns: self.now_ns, missed: 0 };
            self.engine.cycle(beat, exchanged, &self.samples, &mut self.duty, tell);
        }
    }

    fn reset(&mut self, channel: usize) -> Answer {
        self.answer = None;
        let order = Order { ticket: 1, channel, ask: Ask::Reset, hold_ns: 0 };
        if let Some(answer) = self.engine.take(&order, self.now_ns) {
            return answer;
        }
        for _ in 0..200 {
            self.run(1);
            if let Some(answer) = self.answer {
                return answer;
            }
        }
        panic!("a reset was never answered");
    }
}

#[test]
fn several_that_fail_at_once_are_all_off_by_their_own_fault_and_the_others_go_on() {
    let mut bench = Bench::new(4, 2);
    bench.backend.latched[1] = Some(ChannelFault::OverCurrent);
    bench.backend.latched[3] = Some(ChannelFault::Stage);
    bench.run(1);
    assert_eq!(bench.tripped, [(1, Fault::Backend), (3, Fault::Backend)], "in the same cycle");
    bench.run(50);
    let powered: Vec<bool> = bench.duty.iter().map(|duty| *duty > 0.0).collect();
    assert_eq!(powered, [true, false, true, false]);
}

#[test]
fn a_reset_asks_the_hardware_to_forget_and_waits_for_it() {
    for takes in 1..6 {
        let mut bench = Bench::new(2, takes);
        bench.backend.latched = vec![Some(ChannelFault::OverCurrent), Some(ChannelFault::Converter)];
        bench.run(10);
        assert_eq!(bench.reset(1), Answer::Done, "after {takes} exchanges, though the other one still fails");
        assert_eq!(bench.backend.cleared, 1, "asked once");
        bench.run(3);
        assert!(bench.duty[1] > 0.0 && bench.duty[0] == 0.0);
    }
}

#[test]
fn what_the_hardware_does_not_forget_stays_latched() {
    let mut bench = Bench::new(2, 2);
    bench.backend.latched[0] = Some(ChannelFault::OverCurrent);
    bench.backend.remains[0] = true;
    bench.run(10);
    for _ in 0..3 {
        assert_eq!(bench.reset(0), Answer::CauseRemains(Fault::Backend));
        bench.run(20);
        assert_eq!(bench.duty[0], 0.0);
    }
    bench.backend.remains[0] = false;
    assert_eq!(bench.reset(0), Answer::Done);
}
