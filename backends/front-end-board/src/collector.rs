//! Takes the sweeps of a period as they come in, and makes samples of those that came in time.

use sinew_front_end::{NOT_SAMPLED, RawSample};

use crate::CHANNELS;
use crate::ad7616::{WORDS, WireCodes, wires};
use crate::period::{Plan, READ_NS, SWEEP_NS};
use crate::scale::{current_code, voltage_code};

/// A sweep is over so much before it could be only if it is another one: the clocks' resolution.
const EARLY_US: u64 = 2;
/// So long before a sweep it is waited for: the firmware's period begins with its frame, the pulses' when that has been decoded and the
/// period computed, some 0.2 ms later on a processor without division.
const NEAR_US: u64 = 450;

/// What came of the present period's sweeps.
#[derive(Debug, Clone)]
pub struct Collector {
    plan: Plan,
    begun_us: u64,
    codes: [Option<WireCodes>; CHANNELS],
}

impl Default for Collector {
    fn default() -> Collector {
        Collector::new()
    }
}

impl Collector {
    /// Of no period.
    pub const fn new() -> Collector {
        Collector { plan: Plan::NONE, begun_us: 0, codes: [None; CHANNELS] }
    }

    /// Another period, at a time of any clock, µs.
    pub fn begin(&mut self, plan: Plan, now_us: u64) {
        *self = Collector { plan, begun_us: now_us, codes: [None; CHANNELS] };
    }

    /// A sweep was over and read, at this time. One that no plan asked for, or that was read so late that another may have begun, is dropped:
    /// a converter that forgot its registers, or one of the period before.
    pub fn swept(&mut self, words: &[u16; WORDS], now_us: u64) {
        let Some(since_us) = now_us.checked_sub(self.begun_us) else { return };
        let sweep = self.plan.sweeps().iter().find(|sweep| {
            let over_us = u64::from(sweep.at_ns + SWEEP_NS) / 1000;
            (over_us.saturating_sub(EARLY_US)..=over_us + u64::from(READ_NS) / 1000).contains(&since_us)
        });
        let Some(sweep) = sweep else { return };
        for (wire, (place, codes)) in self.codes.iter_mut().zip(wires(words)).enumerate() {
            if sweep.wires >> wire & 1 == 1 {
                *place = Some(codes);
            }
        }
    }

    /// Whether it is worth waiting: the last sweep has begun, or is about to, and has not been read, although there is time. One that is
    /// far off is not waited for: its period is cut short.
    pub fn is_near(&self, now_us: u64) -> bool {
        let Some(last) = self.plan.sweeps().last() else { return false };
        let planned = self.plan.sweeps().iter().fold(0, |wires, sweep| wires | sweep.wires);
        let seen = self.codes.iter().map(Option::is_some);
        let read = seen.enumerate().fold(0, |wires, (wire, is_seen)| wires | u8::from(is_seen) << wire);
        let begins_us = self.begun_us + u64::from(last.at_ns) / 1000;
        let over_us = begins_us + u64::from(SWEEP_NS + READ_NS) / 1000;
        planned != read && (begins_us.saturating_sub(NEAR_US)..=over_us).contains(&now_us)
    }

    /// The samples; `supply` is a code of the line.
    pub fn samples(&self, supply: u16, samples: &mut [RawSample]) {
        for (sample, codes) in samples.iter_mut().zip(&self.codes) {
            *sample = match codes {
                Some(wire) => RawSample {
                    v1: voltage_code(wire, wire.v1),
                    v2: voltage_code(wire, wire.v2),
                    v3: voltage_code(wire, wire.v3),
                    current: current_code(wire),
                    supply,
                },
                None => RawSample { supply, v1: NOT_SAMPLED, v2: NOT_SAMPLED, v3: NOT_SAMPLED, current: NOT_SAMPLED },
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: u32 = 2_000_000;
    const WORDS_OF: [u16; WORDS] = [8192; WORDS];

    fn begun() -> Collector {
        let mut collector = Collector::new();
        // 250 µs dark, and about 500 µs on.
        collector.begin(Plan::new(&[0, 16_384, 16_384, 16_384], PERIOD_NS), 1_000_000);
        collector
    }

    fn sampled(collector: &Collector) -> [bool; CHANNELS] {
        let mut samples = [RawSample::NONE; CHANNELS];
        collector.samples(7, &mut samples);
        assert!(samples.iter().all(|sample| sample.supply == 7));
        samples.map(|sample| sample.v3 != NOT_SAMPLED && sample.current != NOT_SAMPLED)
    }

    #[test]
    fn each_sweep_fills_its_own_wires() {
        let mut collector = begun();
        let near = |collector: &Collector, us: u64| collector.is_near(1_000_000 + us);
        for (us, is_near) in [(39, false), (40, true), (500, true), (528, true), (529, false)] {
            assert_eq!(near(&collector, us), is_near, "{us}");
        }
        collector.swept(&WORDS_OF, 1_000_000 + 240 + 8 + 15);
        assert_eq!(sampled(&collector), [true, false, false, false]);
        assert!(near(&collector, 500));
        collector.swept(&WORDS_OF, 1_000_000 + 490 + 8 + 30);
        assert_eq!(sampled(&collector), [true; CHANNELS]);
        assert!(!near(&collector, 500));
        collector.begin(Plan::new(&[0], PERIOD_NS), 2_000_000);
        assert_eq!(sampled(&collector), [false; CHANNELS]);
    }

    #[test]
    fn what_came_too_early_or_too_late_is_not_taken() {
        for us in [0, 100, 240 + 5, 240 + 8 + 31, 490 + 5, 490 + 8 + 31, 5000] {
            let mut collector = begun();
            collector.swept(&WORDS_OF, 1_000_000 + us);
            assert_eq!(sampled(&collector), [false; CHANNELS], "{us}");
        }
        let mut collector = begun();
        collector.swept(&WORDS_OF, 999_000);
        assert_eq!(sampled(&collector), [false; CHANNELS]);
        assert!(!Collector::new().is_near(0));
    }
}
