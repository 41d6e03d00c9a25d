//! A channel's limits on the device itself, independent of the driver.

use crate::frame::{ChannelFault, ChannelLimits, FULL_DUTY};

/// Periods one after the other with too much current, with none measured, or with one in the dark, before a channel is switched off:
/// one bad conversion is no fault, two periods are what an electrical fault may take.
const STRIKES: u8 = 2;
/// mA² µs in one mA² s.
const PER_SECOND: u64 = 1_000_000;
/// A current with duty 0 is one above this share of the largest allowed, and of the converter's full scale, whose noise and offset are
/// far smaller.
const DARK_SHARE: u32 = 20;
const DARK_SCALE_SHARE: u32 = 50;

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

    /// I²t beyond what drains that may be on an account, mA² µs.
    fn budget(&self) -> u64 {
        u64::from(self.heat_ma2_s) * PER_SECOND
    }

    /// And what is a fault: a fifth more.
    fn trip(&self) -> u64 {
        self.budget() + self.budget() / 5
    }
}

/// One channel's account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Guard {
    /// I²t beyond what has drained, mA² µs.
    heat: u64,
    /// The last current that was measured in an on-phase, mA.
    on_ma: Option<u32>,
    strikes: u8,
    blind: u8,
    /// Periods with duty 0 that showed a current, since one that showed none.
    lit: u8,
    pub fault: Option<ChannelFault>,
    /// Whether the power stage was found to conduct with duty 0: only its supply can be taken from it.
    pub conducts: bool,
}

/// A period that is over as far as its samples go.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Period {
    /// The duty that was put out.
    pub duty: u16,
    /// Current in the on-phase, with duty 0 in the dark, mA; `None` = not measured.
    pub current_ma: Option<u32>,
    /// Full scale of the current, mA.
    pub full_scale_ma: u32,
    /// Whether a conversion fits into the on-phase: where not, none is expected.
    pub measurable: bool,
    /// What the power stage says of itself.
    pub stage: Option<ChannelFault>,
    /// Time since the last one, µs.
    pub elapsed_us: u32,
}

impl Guard {
    /// With nothing on its account, which may have nothing on it.
    pub const NEW: Guard = Guard { heat: 0, on_ma: None, strikes: 0, blind: 0, lit: 0, fault: None, conducts: false };

    /// Other limits than before. They leave as much of the budget as there was: who has just started does not know how hot its wires are,
    /// so that its first account is full, and no message cools a wire.
    pub fn configure(&mut self, before: &ChannelLimits, limits: &ChannelLimits) {
        let wider = limits.budget().saturating_sub(before.budget());
        self.heat = self.heat.max(limits.budget().min(self.heat.saturating_add(wider)));
    }

    /// The duty that is put out in the next period where `asked` is, within the limit of the duty: so much that the account is not
    /// overdrawn. On a full one that is what drains, by the last current measured, or else by the largest allowed; but `least`,
    /// in which a current can be measured, is always left.
    pub fn permit(&self, limits: &ChannelLimits, asked: u16, least: u16, period_us: u32) -> u16 {
        let square = u64::from(self.on_ma.unwrap_or(limits.max_current_ma.into())).pow(2).max(1);
        let spare = limits.budget().saturating_sub(self.heat) / u64::from(period_us.max(1));
        let mean = spare.saturating_add(limits.drain_ma2.into());
        let drains = (mean.saturating_mul(FULL_DUTY.into()) / square).min(FULL_DUTY.into()) as u16;
        asked.min(drains.max(least))
    }

    /// Forgets its fault, unless its cause may still be there, or the next would be heat. If it is, and nobody could know, two periods
    /// show it anew. A full account alone keeps no other fault: it starts full, and lets no more flow than drains.
    pub fn clear(&mut self, limits: &ChannelLimits, stage: Option<ChannelFault>) {
        let most = if self.fault == Some(ChannelFault::Heat) { limits.budget() / 5 * 4 } else { limits.trip() };
        let is_hot = self.heat > most;
        if stage.is_none() && self.lit == 0 && !is_hot {
            (self.fault, self.conducts, self.strikes, self.blind) = (None, false, 0, 0);
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
        if on && period.measurable {
            self.on_ma = period.current_ma.or(self.on_ma);
        }
        let is_lit = !on && self.is_current(limits, period, current_ma);
        if is_lit {
            self.lit = self.lit.saturating_add(1);
        } else if !on && period.current_ma.is_some() {
            self.lit = 0;
        }

        // What flows with the gate closed flows all the time.
        let share = if is_lit { FULL_DUTY } else { period.duty };
        let mean = u64::from(current_ma).pow(2).saturating_mul(share.into()) / u64::from(FULL_DUTY);
        let (before, elapsed_us) = (self.heat, u64::from(period.elapsed_us));
        self.heat = (self.heat.saturating_add(mean.saturating_mul(elapsed_us)))
            .saturating_sub(u64::from(limits.drain_ma2).saturating_mul(elapsed_us));
        // An account that is full because nothing was known, or by a narrower limit, drains.
        let hot = self.heat > before && self.heat > limits.trip();
        self.conducts |= self.lit >= STRIKES;

        let fault = match () {
            () if period.stage.is_some() => period.stage,
            () if self.conducts => Some(ChannelFault::Stage),
            () if self.strikes >= STRIKES => Some(ChannelFault::OverCurrent),
            () if hot => Some(ChannelFault::Heat),
            () if self.blind >= STRIKES => Some(ChannelFault::Converter),
            () => None,
        };
        // The first cause stays; one that is still there keeps the channel off.
        let new = fault.filter(|_| self.fault.is_none());
        self.fault = self.fault.or(fault);
        new
    }

    /// Whether this is a current and not what a converter shows of none. A channel that may have none is no wire: nobody knows what its
    /// converter is connected to.
    fn is_current(&self, limits: &ChannelLimits, period: &Period, current_ma: u32) -> bool {
        let most_ma = u32::from(limits.max_current_ma);
        most_ma > 0 && current_ma > (most_ma / DARK_SHARE).max(period.full_scale_ma / DARK_SCALE_SHARE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: ChannelLimits =
        ChannelLimits { max_duty: FULL_DUTY, max_current_ma: 500, heat_ma2_s: 20_000, drain_ma2: 40_000 };
    const GOOD: Period = Period {
        duty: 6553,
        current_ma: Some(400),
        full_scale_ma: 800,
        measurable: true,
        stage: None,
        elapsed_us: 1000,
    };
    const DARK: Period = Period { duty: 0, current_ma: Some(0), ..GOOD };
    const COLD: Guard = Guard::NEW;

    #[test]
    fn two_strikes_and_no_rest() {
        let mut guard = COLD;
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: Some(501), ..GOOD }), None);
        assert_eq!(guard.judge(&LIMITS, &GOOD), None);
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: Some(501), ..GOOD }), None);
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: None, ..GOOD }), None, "not the same twice");
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: None, ..GOOD }), Some(ChannelFault::Converter));
        for _ in 0..1000 {
            assert_eq!(guard.judge(&LIMITS, &DARK), None);
        }
        assert_eq!(guard.fault, Some(ChannelFault::Converter), "time heals nothing");
        guard.clear(&LIMITS, Some(ChannelFault::StageHot));
        assert!(guard.fault.is_some(), "the stage says otherwise");
        guard.clear(&LIMITS, None);
        assert_eq!(guard.fault, None);
        // The cause is still there: as many periods as the first time.
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: None, ..GOOD }), None);
        assert_eq!(guard.judge(&LIMITS, &Period { current_ma: None, ..GOOD }), Some(ChannelFault::Converter));
    }

    #[test]
    fn heat_is_what_does_not_drain() {
        // 0.4 A at full duty: 160000 mA² less 40000 that drain fill 20000 mA² s in a sixth of a second, and a fifth of it more
        // in a fifth more.
        let mut guard = COLD;
        let full = Period { duty: FULL_DUTY, ..GOOD };
        let periods = (1..).find(|_| guard.judge(&LIMITS, &full).is_some());
        assert!(matches!(periods, Some(200..=204)), "{periods:?}");
        guard.clear(&LIMITS, None);
        assert_eq!(guard.fault, Some(ChannelFault::Heat), "the wire is as hot as before");
        // From 1.2 to 0.8 of the budget 40000 mA² need 0.2 s.
        let periods = (1..).find(|_| {
            guard.judge(&LIMITS, &DARK);
            guard.clear(&LIMITS, None);
            guard.fault.is_none()
        });
        assert!(matches!(periods, Some(200..=204)), "{periods:?}");
        // at a quarter of the duty it lasts for ever
        let mut guard = COLD;
        let quarter = Period { duty: FULL_DUTY / 4, ..GOOD };
        assert!((0..10_000).all(|_| guard.judge(&LIMITS, &quarter).is_none()));
    }

    #[test]
    fn a_full_account_is_given_what_drains_and_never_trips() {
        let mut guard = COLD;
        guard.configure(&ChannelLimits::default(), &LIMITS);
        assert_eq!(guard.heat, LIMITS.budget());
        // Nothing was measured yet: 40000 of 500² mA².
        let permit = |guard: &Guard| guard.permit(&LIMITS, FULL_DUTY, 327, 1000);
        assert_eq!(permit(&guard), (0.16 * f64::from(FULL_DUTY)) as u16);
        for _ in 0..10_000 {
            let period = Period { duty: permit(&guard), ..GOOD };
            assert_eq!(guard.judge(&LIMITS, &period), None);
        }
        // 40000 of 400² mA².
        assert!(permit(&guard).abs_diff(FULL_DUTY / 4) <= 1, "{}", permit(&guard));
        // What is less is not cut, and what a current can be measured in is always left.
        assert_eq!(guard.permit(&LIMITS, 1000, 327, 1000), 1000);
        let dry = ChannelLimits { drain_ma2: 0, ..LIMITS };
        assert_eq!(guard.permit(&dry, FULL_DUTY, 327, 1000), 327);
        // A cold one is not cut until it would be overdrawn.
        assert_eq!(COLD.permit(&LIMITS, FULL_DUTY, 327, 1000), FULL_DUTY);
        assert!(COLD.permit(&LIMITS, FULL_DUTY, 327, 1_000_000) < FULL_DUTY);
    }

    #[test]
    fn no_configuration_leaves_more_of_a_budget_than_there_was() {
        let mut guard = COLD;
        guard.configure(&ChannelLimits::default(), &LIMITS);
        let wide = ChannelLimits { heat_ma2_s: 50_000, ..LIMITS };
        guard.configure(&LIMITS, &wide);
        assert_eq!(guard.heat, wide.budget());
        guard.configure(&wide, &LIMITS);
        assert_eq!(guard.heat, wide.budget(), "nor less of a wire's heat");
        assert_eq!(guard.judge(&LIMITS, &Period { duty: 327, ..GOOD }), None, "which drains and is no fault");
        guard.configure(&LIMITS, &wide);
        assert!(guard.heat <= wide.budget());
    }

    #[test]
    fn a_current_in_the_dark_is_heat_and_a_fault() {
        let mut guard = COLD;
        let lit = Period { current_ma: Some(300), ..DARK };
        // 8 bit of noise, or 10 mA of offset, are none.
        assert!((0..1000).all(|_| guard.judge(&LIMITS, &Period { current_ma: Some(25), ..DARK }).is_none()));
        assert_eq!((guard.heat, guard.lit), (0, 0));
        assert_eq!(guard.judge(&LIMITS, &lit), None);
        assert!(guard.heat > 49_000_000, "90000 mA² less 40000 for a ms: {}", guard.heat);
        assert_eq!(guard.judge(&LIMITS, &DARK), None);
        assert_eq!(guard.judge(&LIMITS, &lit), None, "one bad conversion is no fault");
        // What a driven period shows is nothing of it.
        assert_eq!(guard.judge(&LIMITS, &GOOD), None);
        assert_eq!(guard.judge(&LIMITS, &lit), Some(ChannelFault::Stage));
        guard.clear(&LIMITS, None);
        assert!(guard.fault.is_some() && guard.conducts, "it conducts");
        guard.judge(&LIMITS, &DARK);
        guard.clear(&LIMITS, None);
        assert_eq!((guard.fault, guard.conducts), (None, false));
        // A channel that may have no current is no wire.
        let mut guard = COLD;
        let nothing = ChannelLimits { max_current_ma: 0, ..LIMITS };
        assert!((0..10).all(|_| guard.judge(&nothing, &lit).is_none()));
    }
}
