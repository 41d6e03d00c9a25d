//! The conformance suite every [`Backend`] has to pass, simulated or real: call [`suite`] from its tests with a [`Bench`].
//!
//! It drives all channels with up to full duty for a few periods: on real wires not harmless, but short.

use std::time::Instant;

use crate::allocations;
use crate::backend::{Backend, Zero};
use crate::error::{BackendError, ChannelFault};
use sinew_sensing::Sample;

/// Largest current, as a share of the one in the on-phase, that still counts as none (offset and noise of a converter).
const NO_CURRENT: f64 = 0.05;
/// Exchanges that are timed, and how many of them may yield the processor voluntarily before they count as waiting.
const TIMED: usize = 200;
const WAITS: u64 = TIMED as u64 / 10;

/// Where a backend stands while it is tested: makes it, and does to its hardware what the suite asks for. What a bench cannot
/// do is left at its default, and the rule that needs it is skipped and named in [`Findings::skipped`].
pub trait Bench {
    /// What is tested.
    type Backend: Backend;

    /// A fresh backend with healthy wires, not started.
    fn backend(&mut self) -> Self::Backend;

    /// Waits for the next period. Nothing to wait for where an exchange is itself what makes a period pass.
    fn pace(&mut self) {}

    /// Within how many periods what is done to the hardware shows in an exchange, and a driven wire in its sample.
    fn patience(&self) -> usize {
        3
    }

    /// The present output duty of a channel, 0 ..= 1, measured outside of the backend; `None` where it cannot be measured.
    fn put_out(&mut self, channel: usize) -> Option<f64> {
        let _ = channel;
        None
    }

    /// Whether reaching the hardware yields the processor whatever the backend does, as a bus behind the kernel's files may.
    fn hardware_waits(&self) -> bool {
        false
    }

    /// Takes the hardware away under the running backend; whether that can be done here.
    fn unplug(&mut self) -> bool {
        false
    }

    /// Brings it back.
    fn plug_in(&mut self) {}

    /// Breaks one channel of the hardware; what is to be reported of it, or `None` where that cannot be done here.
    fn break_channel(&mut self, channel: usize) -> Option<ChannelFault> {
        let _ = channel;
        None
    }

    /// Mends it.
    fn mend_channel(&mut self, channel: usize) {
        let _ = channel;
    }
}

/// What a run of the suite found beside that every rule was kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Findings {
    /// Whether allocations could be counted, that is, [`crate::allocations::CountingAllocator`] is installed.
    pub counts_allocations: bool,
    /// Time of an exchange, ns: the median and the worst of some hundred. Measured, not judged: machines are busy.
    pub exchange_ns: [u64; 2],
    /// Rules the bench could not put to the test.
    pub skipped: Vec<&'static str>,
}

/// Runs every rule of the contract, each against a fresh backend.
///
/// # Panics
/// With the rule that is broken.
pub fn suite<B: Bench>(bench: &mut B) -> Findings {
    let mut findings = Findings { counts_allocations: false, exchange_ns: [0; 2], skipped: Vec::new() };
    bounds_its_silence(&mut Stand::new(bench));
    refuses_to_exchange_unless_started(&mut Stand::new(bench));
    starts_and_stops_at_zero(&mut Stand::new(bench));
    measures_while_it_drives(&mut Stand::new(bench));
    accepts_every_duty_in_range_and_no_other(&mut Stand::new(bench));
    checks_the_number_of_values(&mut Stand::new(bench));
    survives_missed_periods(&mut Stand::new(bench));
    stops_any_time(&mut Stand::new(bench));
    findings.counts_allocations = does_not_allocate(&mut Stand::new(bench));
    findings.exchange_ns = does_not_wait(&mut Stand::new(bench));
    if bench.hardware_waits() {
        findings.skipped.push("does not wait");
    }
    if !goes_off_when_unplugged_and_comes_back(&mut Stand::new(bench)) {
        findings.skipped.push("goes off when unplugged and comes back");
    }
    if !reports_the_fault_of_a_channel(&mut Stand::new(bench)) {
        findings.skipped.push("reports the fault of a channel");
    }
    findings
}

/// A backend on its bench, with what goes in and out of it.
struct Stand<'b, B: Bench> {
    bench: &'b mut B,
    backend: B::Backend,
    duty: Vec<f64>,
    samples: Vec<Sample>,
}

impl<'b, B: Bench> Stand<'b, B> {
    fn new(bench: &'b mut B) -> Stand<'b, B> {
        let backend = bench.backend();
        let channels = backend.channels();
        assert!(channels > 0, "a backend has at least one channel");
        Stand { bench, backend, duty: vec![0.0; channels], samples: vec![Sample::NONE; channels] }
    }

    fn start(&mut self) {
        assert_eq!(self.backend.start(), Ok(()), "a backend starts, and starts again once stopped");
    }

    /// One period, or two where the last exchange came late; samples are as the loop hands them over.
    fn exchange(&mut self) -> Result<(), BackendError> {
        self.bench.pace();
        if !self.backend.is_due() {
            self.bench.pace();
        }
        self.samples.fill(Sample::NONE);
        self.backend.exchange(&self.duty, &mut self.samples)
    }

    /// Periods of the same duty on all channels.
    fn drive(&mut self, value: f64, periods: usize) {
        self.duty.fill(value);
        for _ in 0..periods {
            assert_eq!(self.exchange(), Ok(()), "duty {value} is in range");
        }
    }

    /// Drives until every channel has been measured under this duty; at once, or within the bench's patience.
    fn drive_until_measured(&mut self, value: f64) {
        // The sample of the first exchange belongs to the period before.
        self.drive(value, 2);
        for _ in 0..self.bench.patience() {
            self.drive(value, 1);
            if self.samples.iter().all(|sample| sample.current_a.is_finite()) {
                return;
            }
        }
        panic!("not every channel is measured at duty {value}: {:?}", self.samples);
    }

    /// Exchanges until one ends as wanted.
    fn exchange_until(&mut self, what: &str, is_so: impl Fn(&Result<(), BackendError>) -> bool) {
        let mut last = Ok(());
        for _ in 0..self.bench.patience() {
            last = self.exchange();
            if is_so(&last) {
                return;
            }
        }
        panic!("{what}: not within {} periods, the last exchange gave {last:?}", self.bench.patience());
    }

    /// Asserts that a channel took nothing in the period just past and gets nothing now, by whatever can be seen of it.
    fn is_zero(&mut self, channel: usize, when: &str) {
        if let Some(truth) = self.backend.truth(channel) {
            assert_eq!(truth.power_w, 0.0, "channel {channel} takes power {when}");
        }
        self.puts_out_nothing(channel, when);
    }

    fn puts_out_nothing(&mut self, channel: usize, when: &str) {
        let mut seen = None;
        for _ in 0..self.bench.patience() {
            seen = self.bench.put_out(channel);
            if seen.is_none_or(|duty| duty == 0.0) {
                return;
            }
            self.bench.pace();
        }
        panic!("channel {channel} is driven with {seen:?} {when}");
    }

    fn all_zero(&mut self, when: &str) {
        (0..self.duty.len()).for_each(|channel| self.is_zero(channel, when));
    }
}

fn bounds_its_silence<B: Bench>(stand: &mut Stand<'_, B>) {
    let silence_s = stand.backend.silence_s();
    assert!(silence_s.is_some_and(|s| (0.0..=10.0).contains(&s)), "outputs stay as they are for {silence_s:?} s");
}

fn refuses_to_exchange_unless_started<B: Bench>(stand: &mut Stand<'_, B>) {
    assert_eq!(stand.exchange(), Err(BackendError::NotStarted), "exchange before start");
    stand.start();
    assert_eq!(stand.exchange(), Ok(()), "exchange after start");
    let _ = stand.backend.stop();
    assert_eq!(stand.exchange(), Err(BackendError::NotStarted), "exchange after stop");
}

fn starts_and_stops_at_zero<B: Bench>(stand: &mut Stand<'_, B>) {
    stand.start();
    // The sample of the first exchange is from before anything was put out; that of the second, from a period of duty 0.
    stand.drive(0.0, 2);
    let at_start = stand.samples.clone();
    stand.all_zero("after start");
    stand.drive_until_measured(0.1);
    let driven = stand.samples.clone();
    for channel in 0..driven.len() {
        assert!(stand.backend.is_confirmed(channel), "channel {channel} is measured, but its output is not confirmed");
    }
    assert_eq!(stand.backend.stop(), Zero::Confirmed, "nothing is wrong, so that zero is confirmed");
    stand.all_zero("after stop");
    stand.start();
    stand.drive(0.0, 2);
    for (channel, driven) in driven.iter().enumerate() {
        for (when, sample) in [("start", &at_start[channel]), ("a second start", &stand.samples[channel])] {
            // NaN, "not sampled", is what we expect; a converter may as well say nothing flows.
            assert!(
                sample.current_a.is_nan() || sample.current_a.abs() <= NO_CURRENT * driven.current_a,
                "channel {channel} carries {} A after {when}, before any duty was given",
                sample.current_a
            );
        }
    }
    let _ = stand.backend.stop();
}

fn measures_while_it_drives<B: Bench>(stand: &mut Stand<'_, B>) {
    stand.start();
    for value in [0.02, 0.5, 1.0] {
        stand.drive_until_measured(value);
        for (channel, sample) in stand.samples.iter().enumerate() {
            // An input shared by supply and shunt stands in for V3 with the supply, for which it needs an off-phase.
            let voltage = sample.v3_v.is_finite() || sample.supply_v.is_finite() || value == 1.0;
            assert!(voltage && sample.current_a > 0.0, "channel {channel} is not measured at duty {value}: {sample:?}");
            assert!(!sample.v1_v.is_infinite() && !sample.v2_v.is_infinite() && !sample.supply_v.is_infinite());
            if let Some(truth) = stand.backend.truth(channel) {
                let numbers =
                    [truth.length_m, truth.velocity_m_s, truth.temperature_c, truth.force_n, truth.resistance_ohm];
                assert!(numbers.iter().all(|number| number.is_finite()), "channel {channel}: {truth:?}");
                assert!((0.0..=1.0).contains(&truth.martensite), "channel {channel}: {truth:?}");
                assert!(truth.power_w > 0.0, "channel {channel} takes no power at duty {value}");
            }
        }
    }
    let channels = stand.duty.len();
    assert!(stand.backend.truth(channels).is_none(), "there is no truth about a channel that does not exist");
    let _ = stand.backend.stop();
}

fn accepts_every_duty_in_range_and_no_other<B: Bench>(stand: &mut Stand<'_, B>) {
    stand.start();
    for value in [0.0, f64::MIN_POSITIVE, 0.02, 0.5, 1.0] {
        stand.drive(value, 1);
    }
    let last = stand.duty.len() - 1;
    for bad in [f64::NAN, f64::INFINITY, -0.001, 1.001] {
        stand.duty.fill(0.02);
        stand.duty[last] = bad;
        let answer = stand.exchange();
        assert_eq!(answer, Err(BackendError::BadDuty { channel: last as u32 }), "duty {bad}");
        assert!(stand.samples.iter().all(|sample| sample.current_a.is_nan()), "a refused exchange brings no sample");
        (0..=last).for_each(|channel| stand.puts_out_nothing(channel, "after a duty out of range"));
    }
    let _ = stand.backend.stop();
}

fn checks_the_number_of_values<B: Bench>(stand: &mut Stand<'_, B>) {
    stand.start();
    let channels = stand.duty.len();
    let wrong = |found: usize| Err(BackendError::WrongCount { expected: channels as u32, found: found as u32 });
    stand.duty.push(0.0);
    assert_eq!(stand.exchange(), wrong(channels + 1), "a duty too many");
    stand.duty.pop();
    stand.samples.pop();
    assert_eq!(stand.exchange(), wrong(channels - 1), "a sample too few");
    let _ = stand.backend.stop();
}

fn survives_missed_periods<B: Bench>(stand: &mut Stand<'_, B>) {
    stand.start();
    stand.drive_until_measured(0.02);
    for periods in [1, 3, 50] {
        stand.backend.missed(periods);
        let measured = (0..stand.bench.patience()).any(|_| {
            stand.drive(0.02, 1);
            stand.samples.iter().all(|sample| sample.current_a.is_finite())
        });
        assert!(measured, "measured after {periods} missed periods");
    }
    let _ = stand.backend.stop();
}

fn stops_any_time<B: Bench>(stand: &mut Stand<'_, B>) {
    let _ = stand.backend.stop();
    stand.start();
    stand.drive(0.3, 2);
    let _ = stand.backend.stop();
    let _ = stand.backend.stop();
    stand.all_zero("after two stops");
}

fn does_not_allocate<B: Bench>(stand: &mut Stand<'_, B>) -> bool {
    stand.start();
    let mut calls = 0;
    for period in 0..200 {
        stand.duty.fill(f64::from(period % 11) / 10.0);
        stand.bench.pace();
        let before = allocations::calls_of_this_thread();
        if period % 50 == 49 {
            stand.backend.missed(2);
        }
        stand.backend.is_due();
        let answer = stand.backend.exchange(&stand.duty, &mut stand.samples);
        calls += allocations::calls_of_this_thread() - before;
        assert_eq!(answer, Ok(()), "exchange failed in period {period}");
    }
    assert_eq!(calls, 0, "exchange called the allocator {calls} times in 200 periods");
    let _ = stand.backend.stop();
    allocations::is_counting()
}

/// An exchange takes what is there. One that waited would yield the processor, which Linux counts, however busy it is.
fn does_not_wait<B: Bench>(stand: &mut Stand<'_, B>) -> [u64; 2] {
    stand.start();
    stand.drive(0.02, 2);
    let mut times_ns = Vec::with_capacity(TIMED);
    let mut waits = 0;
    for _ in 0..TIMED {
        stand.bench.pace();
        let (before, began) = (voluntary_switches(), Instant::now());
        stand.backend.is_due();
        let answer = stand.backend.exchange(&stand.duty, &mut stand.samples);
        times_ns.push(u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX));
        waits += voluntary_switches() - before;
        assert_eq!(answer, Ok(()));
    }
    assert!(waits <= WAITS || stand.bench.hardware_waits(), "{waits} of {TIMED} exchanges waited for something");
    let _ = stand.backend.stop();
    times_ns.sort_unstable();
    [times_ns[TIMED / 2], times_ns[TIMED - 1]]
}

fn goes_off_when_unplugged_and_comes_back<B: Bench>(stand: &mut Stand<'_, B>) -> bool {
    stand.start();
    stand.drive_until_measured(0.1);
    if !stand.bench.unplug() {
        let _ = stand.backend.stop();
        return false;
    }
    let everything = |answer: &Result<(), BackendError>| answer.is_err_and(|error| error.channel().is_none());
    stand.exchange_until("the hardware is gone, which is reported", everything);
    for _ in 0..3 {
        let answer = stand.exchange();
        assert!(everything(&answer), "the hardware is still gone: {answer:?}");
        assert!(stand.samples.iter().all(|sample| sample.current_a.is_nan()), "nothing is measured of it");
    }
    stand.all_zero("with the hardware unplugged");
    stand.bench.plug_in();
    stand.duty.fill(0.0);
    stand.exchange_until("plugged in again it works by itself, without a new start", Result::is_ok);
    stand.drive_until_measured(0.1);
    let _ = stand.backend.stop();
    true
}

fn reports_the_fault_of_a_channel<B: Bench>(stand: &mut Stand<'_, B>) -> bool {
    stand.start();
    stand.drive_until_measured(0.1);
    let broken = stand.duty.len() - 1;
    let Some(fault) = stand.bench.break_channel(broken) else {
        let _ = stand.backend.stop();
        return false;
    };
    let expected = BackendError::Channel { channel: broken as u32, fault };
    stand.exchange_until("the fault of a channel is reported", |answer| *answer == Err(expected));
    assert!(stand.samples[broken].current_a.is_nan(), "a failed channel has no sample");
    let others = (0..stand.bench.patience()).any(|_| {
        let _ = stand.exchange();
        stand.samples[..broken].iter().all(|sample| sample.current_a.is_finite())
    });
    assert!(others, "the other channels go on");
    stand.is_zero(broken, "with its power stage failed");
    stand.bench.mend_channel(broken);
    // As the supervisor does: off until reset.
    stand.duty[broken] = 0.0;
    stand.backend.clear(broken);
    stand.exchange_until("a channel that is mended, off and reset is well again", Result::is_ok);
    stand.drive_until_measured(0.1);
    let _ = stand.backend.stop();
    true
}

/// How often the calling thread has yielded its processor voluntarily, to wait.
#[allow(unsafe_code)]
fn voluntary_switches() -> u64 {
    // SAFETY: all zeros are a valid rusage, and getrusage writes into no more than that.
    let mut usage: libc::rusage = unsafe { std::mem::zeroed() };
    // SAFETY: the pointer is to a live rusage; with RUSAGE_THREAD the call cannot fail.
    unsafe { libc::getrusage(libc::RUSAGE_THREAD, &mut usage) };
    usage.ru_nvcsw.unsigned_abs()
}
