//! Takes the sweeps of a period as they come in, and makes samples of those that came in time.

use sinew_front_end::{NOT_SAMPLED, RawSample};

use crate::ad7616::{WORDS, WireCodes, wires};
use crate::period::{Plan, READ_NS, SWEEP_NS};
use crate::pins::CHANNELS;
use crate::scale::{current_code, voltage_code};

/// A sweep is over so much before it could be only if it is another one: the clocks' resolution.
const EARLY_US: u64 = 2;

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

    /// When the last sweep has been read, if it is at all, µs of the same clock; `None` where nothing is awaited any more.
    pub fn awaited_us(&self) -> Option<u64> {
        let last = self.plan.sweeps().last()?;
        let planned = self.plan.sweeps().iter().fold(0, |wires, sweep| wires | sweep.wires);
        let read =
            self.codes.iter().enumerate().fold(0, |wires, (wire, codes)| wires | u8::from(codes.is_some()) << wire);
        (planned != read).then(|| self.begun_us + u64::from(last.at_ns + SWEEP_NS + READ_NS) / 1000)
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
        assert_eq!(collector.awaited_us(), Some(1_000_000 + 490 + 8 + 30));
        collector.swept(&WORDS_OF, 1_000_000 + 240 + 8 + 15);
        assert_eq!(sampled(&collector), [true, false, false, false]);
        assert!(collector.awaited_us().is_some());
        collector.swept(&WORDS_OF, 1_000_000 + 490 + 8 + 30);
        assert_eq!(sampled(&collector), [true; CHANNELS]);
        assert_eq!(collector.awaited_us(), None);
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
        assert_eq!(Collector::new().awaited_us(), None);
    }
}
