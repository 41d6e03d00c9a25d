//! One period: how long each output is on, and when the converter sweeps its inputs.

use sinew_front_end::FULL_DUTY;

use crate::CHANNELS;

/// A sweep: eight pairs, 1 µs each (data sheet: 2 × 1 MSPS).
pub const SWEEP_NS: u32 = 8_000;
/// How long before the end of an on-phase its sweep begins: it is over by then.
pub const LEAD_NS: u32 = SWEEP_NS + 2_000;
/// From the end of a sweep to the last of its words, at the latest: 16 words at 15.6 MHz (17 µs), and interrupts held up (13 µs).
pub const READ_NS: u32 = 30_000;
/// Between the beginnings of two sweeps, at the least: the second overwrites the first's words.
pub const SPACING_NS: u32 = SWEEP_NS + READ_NS + 2_000;
/// Shortest on-phase of which samples are sent: the converter's filter (39 kHz, first order) has then settled to 0.8 %, alike for the three
/// voltages.
pub const MIN_ON_NS: u32 = 30_000;

/// How long an output of this duty is on.
pub(crate) fn on_ns(duty: u16, period_ns: u32) -> u32 {
    (u64::from(period_ns) * u64::from(duty) / u64::from(FULL_DUTY)) as u32
}

/// How often a clock counts meanwhile, rounded down.
pub(crate) fn cycles(ns: u32, clock_mhz: u32) -> u32 {
    (u64::from(ns) * u64::from(clock_mhz) / 1000) as u32
}

/// One sweep of the converter.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sweep {
    /// Its beginning, from that of the period, ns.
    pub at_ns: u32,
    /// The wires that are seen by it: bit 0 = channel 0.
    pub wires: u8,
}

/// The sweeps of a period, in order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Plan {
    sweeps: [Sweep; CHANNELS],
    count: u8,
}

impl Plan {
    /// No sweep.
    pub const NONE: Plan = Plan { sweeps: [Sweep { at_ns: 0, wires: 0 }; CHANNELS], count: 0 };

    /// Of a period's duties: each wire at the end of its on-phase, at three quarters of the period where that comes first, without an
    /// on-phase at an eighth. Wires whose sweeps would come too close share the earlier one. One that is on for less than
    /// [`MIN_ON_NS`] is not seen.
    pub fn new(duties: &[u16], period_ns: u32) -> Plan {
        let mut plan = Plan::NONE;
        let mut begins = [None; CHANNELS];
        for (begin, duty) in begins.iter_mut().zip(duties) {
            let end_ns = match on_ns(*duty, period_ns) {
                _ if *duty == 0 => period_ns / 8,
                on_ns if on_ns < MIN_ON_NS => continue,
                on_ns => on_ns.min(period_ns / 4 * 3),
            };
            *begin = Some(end_ns.saturating_sub(LEAD_NS));
        }
        while let Some(first) = begins.iter().flatten().min().copied() {
            let mut sweep = Sweep { at_ns: first, wires: 0 };
            for (wire, begin) in begins.iter_mut().enumerate() {
                if begin.is_some_and(|begin| begin - first < SPACING_NS) {
                    sweep.wires |= 1 << wire;
                    *begin = None;
                }
            }
            if let Some(place) = plan.sweeps.get_mut(usize::from(plan.count)) {
                *place = sweep;
                plan.count += 1;
            }
        }
        plan
    }

    /// Its sweeps.
    pub fn sweeps(&self) -> &[Sweep] {
        self.sweeps.get(..usize::from(self.count)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: u32 = 2_000_000;

    fn duty(us: u32) -> u16 {
        (u64::from(us) * 1000 * u64::from(FULL_DUTY)).div_ceil(u64::from(PERIOD_NS)) as u16
    }

    #[test]
    fn every_wire_is_seen_within_its_on_phase() {
        for mut seed in 0..20_000u32 {
            let duties: [u16; CHANNELS] = core::array::from_fn(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if seed >> 29 == 0 { 0 } else { (seed >> 8) as u16 >> (seed >> 29) }
            });
            let plan = Plan::new(&duties, PERIOD_NS);
            let mut seen = 0;
            for (index, sweep) in plan.sweeps().iter().enumerate() {
                assert_eq!(seen & sweep.wires, 0);
                seen |= sweep.wires;
                if let Some(next) = plan.sweeps().get(index + 1) {
                    assert!(next.at_ns - sweep.at_ns >= SPACING_NS);
                }
                for wire in (0..CHANNELS).filter(|wire| sweep.wires >> wire & 1 == 1 && duties[*wire] > 0) {
                    let end_ns = on_ns(duties[wire], PERIOD_NS).min(PERIOD_NS / 4 * 3);
                    assert!(sweep.at_ns + SWEEP_NS < end_ns, "over before the output is");
                    assert!(sweep.at_ns + LEAD_NS + SPACING_NS > end_ns, "at its end");
                    assert!(sweep.at_ns >= MIN_ON_NS - LEAD_NS, "settled");
                }
            }
            for (wire, duty) in duties.iter().enumerate() {
                let on_ns = on_ns(*duty, PERIOD_NS);
                assert_eq!(seen >> wire & 1 == 1, *duty == 0 || on_ns >= MIN_ON_NS, "{duties:?}");
            }
        }
    }

    #[test]
    fn wires_alike_share_a_sweep() {
        let plan = Plan::new(&[duty(500), duty(500), 0, duty(1900)], PERIOD_NS);
        let sweeps = plan.sweeps().iter().map(|sweep| (sweep.at_ns / 1000, sweep.wires));
        assert!(sweeps.eq([(240, 0b0100), (490, 0b0011), (1490, 0b1000)]), "{plan:?}");
        assert_eq!(Plan::new(&[duty(20)], PERIOD_NS).sweeps(), []);
    }
}
