//! The suite every [`Backend`] has to pass, simulated or real: call [`suite`] from its tests.
//!
//! It drives all channels with up to full duty for a few periods, so on real wires it is not harmless, but short.

use crate::allocations;
use crate::backend::{Backend, BackendError, Sample};

const EMPTY: Sample =
    Sample { v1_v: f64::NAN, v2_v: f64::NAN, v3_v: f64::NAN, current_a: f64::NAN, supply_v: f64::NAN };

/// Largest current, as a share of the one in the on-phase, that still counts as none (offset and noise of a converter).
const NO_CURRENT: f64 = 0.05;

/// Runs every rule of the contract against backends made by `make`, a fresh one for each rule. The rig behind must have
/// healthy wires. Returns whether allocations could be counted (that is, [`crate::CountingAllocator`] is installed).
///
/// # Panics
/// With the rule that is broken.
pub fn suite<B: Backend>(mut make: impl FnMut() -> B) -> bool {
    refuses_to_exchange_unless_started(make());
    starts_and_stops_at_zero(make());
    measures_while_it_drives(make());
    accepts_every_duty_in_range_and_no_other(make());
    checks_the_number_of_values(make());
    survives_missed_periods(make());
    stops_any_time(make());
    does_not_allocate(make())
}

fn buffers<B: Backend>(backend: &B) -> (Vec<f64>, Vec<Sample>) {
    let channels = backend.channels();
    assert!(channels > 0, "a backend has at least one channel");
    (vec![0.0; channels], vec![EMPTY; channels])
}

fn drive<B: Backend>(backend: &mut B, value: f64, periods: usize) -> Vec<Sample> {
    let (mut duty, mut samples) = buffers(backend);
    duty.fill(value);
    for _ in 0..periods {
        assert_eq!(backend.exchange(&duty, &mut samples), Ok(()), "duty {value} is in range");
    }
    samples
}

fn power_w<B: Backend>(backend: &B) -> f64 {
    (0..backend.channels()).filter_map(|channel| backend.truth(channel)).map(|truth| truth.power_w).sum()
}

fn refuses_to_exchange_unless_started<B: Backend>(mut backend: B) {
    let (duty, mut samples) = buffers(&backend);
    assert_eq!(backend.exchange(&duty, &mut samples), Err(BackendError::NotStarted), "exchange before start");
    assert_eq!(backend.start(), Ok(()));
    assert_eq!(backend.exchange(&duty, &mut samples), Ok(()), "exchange after start");
    backend.stop();
    assert_eq!(backend.exchange(&duty, &mut samples), Err(BackendError::NotStarted), "exchange after stop");
}

fn starts_and_stops_at_zero<B: Backend>(mut backend: B) {
    assert_eq!(backend.start(), Ok(()));
    // The sample of the first exchange is from before anything was put out; that of the second, from a period of duty 0.
    let at_start = drive(&mut backend, 0.0, 2);
    assert_eq!(power_w(&backend), 0.0, "no power after start");
    let driven = drive(&mut backend, 0.1, 3);
    backend.stop();
    assert_eq!(power_w(&backend), 0.0, "no power after stop");
    assert_eq!(backend.start(), Ok(()), "a stopped backend starts again");
    let again = drive(&mut backend, 0.0, 2);
    for (channel, driven) in driven.iter().enumerate() {
        for (when, sample) in [("start", &at_start[channel]), ("a second start", &again[channel])] {
            // NaN, "not sampled", is what we expect; a converter may as well say nothing flows.
            assert!(
                sample.current_a.is_nan() || sample.current_a.abs() <= NO_CURRENT * driven.current_a,
                "channel {channel} carries {} A after {when}, before any duty was given",
                sample.current_a
            );
        }
    }
}

fn measures_while_it_drives<B: Backend>(mut backend: B) {
    assert_eq!(backend.start(), Ok(()));
    for value in [0.02, 0.5, 1.0] {
        let samples = drive(&mut backend, value, 3);
        for (channel, sample) in samples.iter().enumerate() {
            // An input shared by supply and shunt stands in for V3 with the supply, for which it needs an off-phase.
            let voltage = sample.v3_v.is_finite() || sample.supply_v.is_finite() || value == 1.0;
            assert!(
                voltage && sample.current_a.is_finite() && sample.current_a > 0.0,
                "channel {channel} is not measured at duty {value}: {sample:?}"
            );
            assert!(!sample.v1_v.is_infinite() && !sample.v2_v.is_infinite() && !sample.supply_v.is_infinite());
            if let Some(truth) = backend.truth(channel) {
                let numbers =
                    [truth.length_m, truth.velocity_m_s, truth.temperature_c, truth.force_n, truth.resistance_ohm];
                assert!(numbers.iter().all(|number| number.is_finite()), "channel {channel}: {truth:?}");
                assert!((0.0..=1.0).contains(&truth.martensite), "channel {channel}: {truth:?}");
                assert!(truth.power_w > 0.0, "channel {channel} takes no power at duty {value}");
            }
        }
    }
    assert!(backend.truth(backend.channels()).is_none(), "there is no truth about a channel that does not exist");
    backend.stop();
}

fn accepts_every_duty_in_range_and_no_other<B: Backend>(mut backend: B) {
    assert_eq!(backend.start(), Ok(()));
    for value in [0.0, f64::MIN_POSITIVE, 0.02, 0.5, 1.0] {
        drive(&mut backend, value, 1);
    }
    let (mut duty, mut samples) = buffers(&backend);
    let last = duty.len() - 1;
    for bad in [f64::NAN, f64::INFINITY, -0.001, 1.001] {
        duty[last] = bad;
        let answer = backend.exchange(&duty, &mut samples);
        assert_eq!(answer, Err(BackendError::BadDuty { channel: last as u32 }), "duty {bad}");
    }
    backend.stop();
}

fn checks_the_number_of_values<B: Backend>(mut backend: B) {
    assert_eq!(backend.start(), Ok(()));
    let (duty, mut samples) = buffers(&backend);
    let channels = backend.channels();
    let wrong = |found: usize| Err(BackendError::WrongCount { expected: channels as u32, found: found as u32 });
    let mut long = duty.clone();
    long.push(0.0);
    assert_eq!(backend.exchange(&long, &mut samples), wrong(channels + 1), "a duty too many");
    samples.pop();
    assert_eq!(backend.exchange(&duty, &mut samples), wrong(channels - 1), "a sample too few");
    backend.stop();
}

fn survives_missed_periods<B: Backend>(mut backend: B) {
    assert_eq!(backend.start(), Ok(()));
    drive(&mut backend, 0.02, 2);
    for periods in [1, 3, 50] {
        backend.missed(periods);
        let samples = drive(&mut backend, 0.02, 1);
        assert!(samples.iter().all(|sample| sample.current_a.is_finite()), "measured after {periods} missed periods");
    }
    backend.stop();
}

fn stops_any_time<B: Backend>(mut backend: B) {
    backend.stop();
    assert_eq!(backend.start(), Ok(()), "stop before start does no harm");
    drive(&mut backend, 0.3, 2);
    backend.stop();
    backend.stop();
    assert_eq!(power_w(&backend), 0.0, "no power after two stops");
}

fn does_not_allocate<B: Backend>(mut backend: B) -> bool {
    assert_eq!(backend.start(), Ok(()));
    let (mut duty, mut samples) = buffers(&backend);
    let before = allocations::calls_of_this_thread();
    for period in 0..200 {
        duty.fill(f64::from(period % 11) / 10.0);
        if period % 50 == 49 {
            backend.missed(2);
        }
        if backend.exchange(&duty, &mut samples).is_err() {
            panic!("exchange failed in period {period}");
        }
    }
    let calls = allocations::calls_of_this_thread() - before;
    assert_eq!(calls, 0, "exchange called the allocator {calls} times in 200 periods");
    backend.stop();
    allocations::is_counting()
}
