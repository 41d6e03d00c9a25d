//! Derating: limits the power so that a wire stays within its budgets, before one of them has to switch it off.
//!
//! Two budgets, one curve: from 80 % of a budget on, the allowed power falls linearly, to the power that holds the
//! budget just short of full. A lasting demand is thus held at the limit instead of tripping it, and a short one is not
//! limited. Only what derating cannot prevent trips.
//!
//! **Heat.** The thesis' rule for the continuous current of a wire (eq. 8, 9) as a thermal image of the wire, like the I²t of a motor's
//! protection relay: the budget integrates I²R as measured, and drains in proportion to its level, by
//! `energy_drain_w` when full. So the time constant is `energy_budget_j / energy_drain_w`; a pulse may use the free budget, a
//! lasting power at most the drain. It uses current and voltage, not the wire's state.
//!
//! **Temperature.** What is believed at worst ([`crate::heat`]), which uses the wire's model, its length and its resistance.
//!
//! **Silence.** A driver that dies or stands still leaves its outputs as they are, until whatever is there for it notices. So no more
//! is ever put out than the wire bears for that long and two periods, without any loss to the air, short of
//! [`SILENCE_KEPT_K`] beyond its limit.

use sinew_ipc::ChannelState;

/// Share of a budget from which on the power is derated.
pub const DERATED_FROM: f64 = 0.8;
/// Share of the heat budget at which no more is allowed than drains.
pub const HEAT_KEPT: f64 = 0.95;
/// Share of the temperature's rise at which nothing is allowed.
pub const RISE_KEPT: f64 = 0.98;
/// How far beyond its limit a silence may take a wire, K: half of the 10 K that are promised, for no belief is exact.
pub const SILENCE_KEPT_K: f64 = 5.0;
/// A budget must not be passed in fewer periods than this, however strong the supply or slow the loop.
const FEWEST_PERIODS: f64 = 6.0;

/// What a wire may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budgets {
    /// Heat it may hold beyond what drains, J.
    pub energy_j: f64,
    /// Rate at which a full account drains, W.
    pub drain_w: f64,
    /// Highest temperature, °C.
    pub temperature_c: f64,
    /// Air, °C: where the rise is counted from.
    pub ambient_c: f64,
    /// Largest power there is, W.
    pub full_w: f64,
    /// How fast that heats the wire, K/s.
    pub full_k_per_s: f64,
    /// The loop's period, s.
    pub period_s: f64,
    /// The longest an output can stay as it is with a dead driver, s.
    pub silence_s: f64,
}

/// How the power is to be derated: the budgets with everything worked out that does not change.
#[derive(Debug, Clone, Copy)]
pub struct Derating {
    leak_per_s: f64,
    per_energy_j: f64,
    kept_j: f64,
    per_release_s: f64,
    kept_c: f64,
    w_per_k: f64,
    silence_c: f64,
    silence_w_per_k: f64,
}

/// The power that is allowed, and what keeps it down where it is kept down: `ChannelState::FLAG_…`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Mean power, W; may be negative or NaN, which both mean none.
    pub power_w: f64,
    /// The budget it comes from.
    pub flag: u32,
}

impl Derating {
    /// Derates so that these budgets hold.
    pub fn new(b: &Budgets) -> Derating {
        let period_s = FEWEST_PERIODS * b.period_s;
        // Full power is just allowed at the level where derating begins; one that drains before that level is never derated.
        let release_s = if b.full_w > HEAT_KEPT * b.drain_w {
            let spare_w = b.full_w - DERATED_FROM * b.drain_w;
            ((HEAT_KEPT - DERATED_FROM) * b.energy_j / spare_w).max(period_s)
        } else {
            period_s
        };
        let rise_k = (b.temperature_c - b.ambient_c).max(1.0);
        let band_k = ((RISE_KEPT - DERATED_FROM) * rise_k).max(period_s * b.full_k_per_s);
        Derating {
            leak_per_s: b.drain_w / b.energy_j,
            per_energy_j: 1.0 / b.energy_j,
            kept_j: HEAT_KEPT * b.energy_j,
            per_release_s: 1.0 / release_s,
            kept_c: b.temperature_c - (1.0 - RISE_KEPT) * rise_k,
            w_per_k: b.full_w / band_k,
            silence_c: b.temperature_c + SILENCE_KEPT_K,
            silence_w_per_k: b.full_w / (b.full_k_per_s * (b.silence_s + 2.0 * b.period_s)),
        }
    }

    /// Share of an account that drains in a second, 1/s.
    #[inline]
    pub fn leak_per_s(&self) -> f64 {
        self.leak_per_s
    }

    /// What drains of an account that stands at this, W.
    #[inline]
    pub fn drains_w(&self, energy_j: f64) -> f64 {
        self.leak_per_s * energy_j
    }

    /// How full an account is that stands at this, 1 = its budget.
    #[inline]
    pub fn filled(&self, energy_j: f64) -> f64 {
        self.per_energy_j * energy_j
    }

    /// The power that keeps both budgets.
    #[inline]
    pub fn allowance(&self, energy_j: f64, temperature_c: f64) -> Allowance {
        let by_heat_w = self.drains_w(energy_j) + (self.kept_j - energy_j) * self.per_release_s;
        let by_silence_w = (self.silence_c - temperature_c) * self.silence_w_per_k;
        let by_temperature_w = (self.kept_c - temperature_c) * self.w_per_k;
        // Either is NaN where the temperature is.
        let by_temperature_w = if by_silence_w < by_temperature_w { by_silence_w } else { by_temperature_w };
        if by_heat_w < by_temperature_w {
            Allowance { power_w: by_heat_w, flag: ChannelState::FLAG_HEAT_BUDGET }
        } else {
            Allowance { power_w: by_temperature_w, flag: ChannelState::FLAG_TEMPERATURE_BUDGET }
        }
    }
}

/// Budgets that tests reckon with.
#[cfg(test)]
pub(crate) const EXAMPLE: Budgets = Budgets {
    energy_j: 2.0,
    drain_w: 1.0,
    temperature_c: 150.0,
    ambient_c: 25.0,
    full_w: 3.0,
    full_k_per_s: 200.0,
    period_s: 1e-3,
    silence_s: 0.1,
};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn full_power_passes_up_to_four_fifths_and_what_drains_at_the_end() {
        let derating = Derating::new(&EXAMPLE);
        let at = |share: f64| derating.allowance(share * 2.0, 25.0);
        assert!(at(0.0).power_w > 3.0 && at(0.79).power_w > 3.0);
        assert!((at(0.8).power_w - 3.0).abs() < 1e-9, "{:?}", at(0.8));
        assert!((at(HEAT_KEPT).power_w - HEAT_KEPT).abs() < 1e-9 && at(1.0).power_w < 1.0);
        assert_eq!(at(0.9).flag, ChannelState::FLAG_HEAT_BUDGET);

        let at = |share: f64| derating.allowance(0.0, 25.0 + share * 125.0);
        assert!((at(0.8).power_w - 3.0).abs() < 1e-9 && at(RISE_KEPT).power_w.abs() < 1e-9);
        assert_eq!(at(0.9).flag, ChannelState::FLAG_TEMPERATURE_BUDGET);
        assert!(derating.allowance(0.0, f64::NAN).power_w.is_nan(), "a temperature nobody knows allows nothing");
    }

    proptest! {
        /// However strong or weak the supply, nothing is held back of an account that is not four fifths full.
        #[test]
        fn nothing_is_held_back_below_four_fifths(
            energy_j in 1e-3..100.0f64, drain_w in 1e-3..50.0f64, over in 0.01..5.0f64, share in 0.0..0.8f64,
        ) {
            // (a supply that fills the account in a few periods is no wire's)
            let budgets = Budgets { energy_j, drain_w, full_w: over * drain_w, period_s: 1e-6, ..EXAMPLE };
            prop_assume!(budgets.full_w * budgets.period_s < 0.005 * energy_j);
            let allowed_w = Derating::new(&budgets).allowance(share * energy_j, 25.0).power_w;
            prop_assert!(allowed_w >= budgets.full_w * (1.0 - 1e-9), "{allowed_w} of {budgets:?}");
        }

        /// A permanent demand of full power never exceeds the budget, whatever the wire, the supply and the loop.
        #[test]
        fn what_is_derated_never_fills_the_account(
            energy_j in 1e-3..100.0f64, drain_w in 1e-3..50.0f64, over in 0.2..50.0f64, period_s in 1e-4..0.02f64,
        ) {
            let budgets = Budgets { energy_j, drain_w, full_w: over * drain_w, period_s, ..EXAMPLE };
            // A supply that fills the account in a few periods is no wire's.
            prop_assume!(budgets.full_w * period_s < 0.05 * energy_j);
            let derating = Derating::new(&budgets);
            let (mut account_j, mut given_w) = (0.0f64, 0.0);
            for _ in 0..20_000 {
                account_j = (account_j + (given_w - derating.drains_w(account_j)) * period_s).max(0.0);
                prop_assert!(account_j < energy_j);
                given_w = derating.allowance(account_j, 25.0).power_w.clamp(0.0, budgets.full_w);
            }
            let expected = if over > 1.0 { HEAT_KEPT.min(over) } else { over };
            prop_assert!(account_j <= energy_j * expected + 1e-9);
        }
    }
}
