//! A channel's limits on the device itself, independent of the driver.

use crate::frame::{ChannelFault, ChannelLimits, FULL_DUTY};

/// Periods one after the other with too much current, or with none measured, before a channel is switched off: one bad
/// conversion is no fault, two periods are what an electrical fault may take.
const STRIKES: u8 = 2;
/// Frames one after the other that ask nothing of a channel before its fault is forgotten.
const REST_FRAMES: u8 = 3;
/// mA² µs in one mA² s.
const PER_SECOND: u64 = 1_000_000;

impl ChannelLimits {
    /// The narrower of two.
    pub fn narrower(&self, other: &ChannelLimits) -> ChannelLimits {
        ChannelLimits {
            max_duty: self.max_duty.min(other.max_duty),
            max_current_ma: self.max_current_ma.min(other.max_current_ma),
            heat_ma2_s: self.heat_ma2_s.min(other.heat_ma2_s),
            drain_ma2: self.drain_ma2.min(other.drain_ma2),
        }
    }
}

/// One channel's account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Guard {
    /// I²t beyond what has drained, mA² µs.
    heat: u64,
    strikes: u8,
    blind: u8,
    rest: u8,
    pub fault: Option<ChannelFault>,
}

/// A period that is over as far as its samples go.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Period {
    /// The duty that was put out.
    pub duty: u16,
    /// Current in the on-phase, mA; `None` = not measured.
    pub current_ma: Option<u32>,
    /// Whether a conversion fits into the on-phase: where not, none is expected.
    pub measurable: bool,
    /// What the power stage says of itself.
    pub stage: Option<ChannelFault>,
    /// Time since the last one, µs.
    pub elapsed_us: u32,
}

impl Guard {
    /// With nothing on its account.
    pub const NEW: Guard = Guard { heat: 0, strikes: 0, blind: 0, rest: 0, fault: None };

    /// What a duty frame asks of the channel: nothing, often enough, lets its fault be forgotten.
    pub fn asked(&mut self, duty: u16) {
        self.rest = if duty == 0 { self.rest.saturating_add(1) } else { 0 };
        if self.rest >= REST_FRAMES {
            self.fault = None;
            (self.strikes, self.blind) = (0, 0);
        }
    }

    /// Judges a period; the fault, where it is a new one.
    pub fn judge(&mut self, limits: &ChannelLimits, period: &Period) -> Option<ChannelFault> {
        let on = period.duty > 0;
        // An unmeasured current counts as the largest allowed.
        let current_ma = period.current_ma.unwrap_or(if on { limits.max_current_ma.into() } else { 0 });
        let over = on && current_ma > u32::from(limits.max_current_ma);
        self.strikes = if over { self.strikes.saturating_add(1) } else { 0 };
        let blind = on && period.measurable && period.current_ma.is_none();
        self.blind = if blind { self.blind.saturating_add(1) } else { 0 };

        let square = u64::from(current_ma).pow(2);
        let mean = if on { square * u64::from(period.duty) / u64::from(FULL_DUTY) } else { 0 };
        let elapsed_us = u64::from(period.elapsed_us);
        self.heat = (self.heat.saturating_add(mean.saturating_mul(elapsed_us)))
            .saturating_sub(u64::from(limits.drain_ma2).saturating_mul(elapsed_us));
        let hot = self.heat > u64::from(limits.heat_ma2_s) * PER_SECOND;

        let fault = match () {
            () if period.stage.is_some() => period.stage,
            () if self.strikes >= STRIKES => Some(ChannelFault::OverCurrent),
            () if hot => Some(ChannelFault::Heat),
            () if self.blind >= STRIKES => Some(ChannelFault::Converter),
            () => None,
        };
        // The first cause stays; one that is still there keeps the channel off.
        let new = fault.filter(|_| self.fault.is_none());
        if fault.is_some() {
            self.fault = self.fault.or(fault);
            self.rest = 0;
        }
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ChannelLimits =
        ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 500, heat_ma2_s: 20_000, drain_ma2: 40_000 };
    const GOOD: Period = Period { duty: 6553, current_ma: Some(400), measurable: true, stage: None, elapsed_us: 1000 };

    #[test]
    fn two_strikes_and_rest() {
        let mut guard = Guard::NEW;
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: Some(501), ..GOOD }), None);
        assert_eq!(guard.judge(&LIMITS, &GOOD), None);
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: Some(501), ..GOOD }), None);
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: None, ..GOOD }), None, "not the same twice");
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: None, ..GOOD }), Some(ChannelFault::Converter));
        for duty in [0, 0, 1, 0, 0] {
            guard.asked(duty);
            assert!(guard.fault.is_some());
        }
        guard.asked(0);
        assert_eq!(guard.fault, None);
    }

    #[test]
    fn heat_is_what_does_not_drain() {
        // 0.4 A at full duty: 160000 mA² less 40000 that drain fill 20000 mA² s in a sixth of a second.
        let mut guard = Guard::NEW;
        let full = Period { duty: FULL_DUTY, ..GOOD };
        let periods = (1..).find(|_| guard.judge(&LIMITS, &full).is_some());
        assert!(matches!(periods, Some(166..=168)), "{periods:?}");
        // at a quarter of the duty it lasts for ever
        let mut guard = Guard::NEW;
        let quarter = Period { duty: FULL_DUTY / 4, ..GOOD };
        assert!((0..10_000).all(|_| guard.judge(&LIMITS, &quarter).is_none()));
    }
}
