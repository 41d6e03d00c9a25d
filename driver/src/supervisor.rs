//! The safety supervisor: decides, each period and before any controller runs, whether a channel may be powered.
//!
//! A channel is in one of three states:
//!
//! ```text
//!   proving --- PROOF_SAMPLES good samples in a row ---> healthy
//!      |  ^                                                 |
//!      |  '-- reset, cause gone --- latched <-- a fault ----'
//!      '---------- a fault ------------^
//! ```
//!
//! *Proving* and *healthy* channels get at least the sensing pulse, because without current there is nothing to measure;
//! only a healthy one gets its controller's duty. A *latched* one gets duty 0, no sensing pulse either: after
//! an electrical fault even that may feed a short or an arc, and after any other the wire has to cool. It keeps its first cause
//! until a client resets it; then the sensing pulse restarts and the channel goes through *proving* again before the fault is
//! cleared. If the cause is still present, it latches within [`DEBOUNCE_SAMPLES`] periods.
//!
//! All faults with names and remedies are in one table, [`sinew_ipc::fault`].
//! The debouncing is chosen so that noise never trips:
//!
//! | evidence | threshold | periods | why noise cannot |
//! |---|---|---|---|
//! | an intermittent contact | every second sample bad, see [`MOST_UNREST`] | 32 | as above, many times over |
//! | health of a sample | 8 standard deviations clear of anything healthy (`sinew-sensing`) | 2 | 10⁻¹⁵ a sample, 10⁻³⁰ twice in a row |
//! | current in the on-phase | `max_current_a` + 8 standard deviations of the converter | 2 | the same |
//! | temperature at worst, heat account | the limit | 2 | both are integrals: noise moves them by less than 0.1 K |
//! | overrun | late without a break for [`OVERRUN_S`], one gap or many | | late wake-ups now and then are only counted |
//! | stale setpoint | the lease's end | 1 | a clock has no noise |
//!
//! The first bad sample already replaces the controller's duty: a channel is at the sensing pulse one period after a
//! fault has begun, and off after two.

use sinew_ipc::Fault;
use sinew_sensing::Health;

use crate::heat::{Heat, Passed};

/// Good samples in a row that make a channel fit to be powered.
pub const PROOF_SAMPLES: u32 = 8;
/// Bad samples in a row that latch a fault.
pub const DEBOUNCE_SAMPLES: u32 = 2;
/// A contact that flaps so that no two samples in a row are bad latches too: every second sample bad does in 32 periods,
/// every third never.
pub const MOST_UNREST: u32 = 16;
/// A channel that has neither proved itself nor shown a clear fault for so long (s, and four times [`PROOF_SAMPLES`] periods)
/// is latched with the last thing wrong.
pub const PROOF_TIMEOUT_S: f64 = 1.0;
/// Time without punctual control, s, that switches everything off: one gap, or a row of cycles each of which missed a period.
/// Longer than a busy machine makes, shorter than it takes to overheat a wire at full power by more than its latent heat.
pub const OVERRUN_S: f64 = 0.25;
/// Periods that must be missed in that time: on a very slow loop a single one is no overrun.
pub const OVERRUN_PERIODS: u64 = 3;
/// The estimate must have come down by so much, K, before a temperature fault can be reset.
pub const TEMPERATURE_MARGIN_K: f64 = 10.0;
/// The energy account must have drained to this share of its budget before an energy fault can be reset.
pub const ENERGY_MARGIN: f64 = 0.8;

/// Everything a guard judges by in one period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Whether current was driven in the period the sample is from: with duty 0 there is nothing to see.
    pub driven: bool,
    /// Verdict on the sample.
    pub health: Health,
    /// What it shows of the output stage, driven or not.
    pub stage: Option<Fault>,
    /// Current in the on-phase, A, as sampled.
    pub current_a: f64,
    /// What has passed for the wire's heat since the last cycle.
    pub heat: Passed,
}

/// What a channel may be given for the next period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Permit {
    /// Exactly nothing.
    Off,
    /// The sensing pulse and nothing more.
    SensingPulse,
    /// What its controller asks for.
    Power,
}

/// What a wire has to wait for that is too hot to be reset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cooldown {
    /// How long at the most while it gets nothing, s; NaN where that is not known.
    pub longest_s: f64,
    /// What is believed of its temperature, °C.
    pub temperature_c: f64,
    /// What that has to come down to, °C. Where it has, the heat account is too full.
    pub below_c: f64,
}

/// What changed in a channel's state in one period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// A fault was latched.
    Tripped(Fault),
    /// The channel has proved itself; a fault latched before is cleared.
    Proved,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Proving,
    Healthy,
    Latched,
}

/// The supervisor of one channel.
#[derive(Debug, Clone)]
pub struct Guard {
    /// Largest current in the on-phase, noise allowed for, A.
    max_current_a: f64,
    /// What is believed of the wire's heat.
    heat: Heat,
    state: State,
    /// Good samples in a row while proving.
    good_samples: u32,
    /// How long since it began to prove itself, s and periods.
    proving_s: f64,
    proving_periods: u32,
    /// Bad samples in a row, and what the first of them showed.
    bad_samples: u32,
    /// Rises by 2 with a bad sample and falls by 1 with a good one: a flapping contact, never bad twice in a row.
    unrest: u32,
    suspect: Fault,
    hot_periods: u32,
    spent_periods: u32,
    /// Looks in a row at a stage that conducts with its gate closed.
    stuck_looks: u32,
    latched: Option<Fault>,
}

impl Guard {
    /// A guard that trusts nothing yet of a wire whose heat is believed to be this. `max_current_a` is the largest current in the
    /// on-phase, noise allowed for, A.
    pub fn new(max_current_a: f64, heat: Heat) -> Guard {
        Guard {
            max_current_a,
            heat,
            state: State::Proving,
            good_samples: 0,
            proving_s: 0.0,
            proving_periods: 0,
            bad_samples: 0,
            unrest: 0,
            suspect: Fault::NoSample,
            hot_periods: 0,
            spent_periods: 0,
            stuck_looks: 0,
            latched: None,
        }
    }

    /// The fault that is latched: the first cause, until it is reset and the channel has proved itself again.
    pub fn fault(&self) -> Option<Fault> {
        self.latched
    }

    /// Whether the channel obeys its controller.
    pub fn is_healthy(&self) -> bool {
        self.state == State::Healthy
    }

    /// Whether the channel is off by a fault, and nobody has reset it.
    pub fn is_latched(&self) -> bool {
        self.state == State::Latched
    }

    /// Whether the channel is proving itself, after the start or a reset.
    pub fn is_proving(&self) -> bool {
        self.state == State::Proving
    }

    /// What is believed of the wire's heat.
    #[inline]
    pub fn heat(&self) -> &Heat {
        &self.heat
    }

    /// The same, to be told what is known from elsewhere.
    pub fn heat_mut(&mut self) -> &mut Heat {
        &mut self.heat
    }

    /// Whether the output stage is known to conduct with its gate closed, so that only its supply can be taken from it.
    pub fn must_cut(&self) -> bool {
        self.latched == Some(Fault::StageOn) && self.state == State::Latched
    }

    /// What of the wire's heat is in the way of a reset; `None` where nothing is.
    pub fn cooldown(&self) -> Option<Cooldown> {
        let budgets = self.heat.budgets();
        let below_c = budgets.temperature_c - TEMPERATURE_MARGIN_K;
        let below_j = ENERGY_MARGIN * budgets.energy_j;
        let temperature_c = self.heat.temperature_c();
        let is_over = temperature_c <= below_c && self.heat.account_j() <= below_j;
        let longest_s = self.heat.longest_s(below_c, below_j);
        (!is_over).then_some(Cooldown { longest_s, temperature_c, below_c })
    }

    /// Judges one period. Constant time, no allocation; NaN in the evidence is a fault and not a panic.
    #[inline]
    pub fn judge(&mut self, evidence: &Evidence) -> (Permit, Option<Change>) {
        self.heat.pass(&evidence.heat);
        let Passed { power_w, dt_s, .. } = evidence.heat;

        // A stage that conducts by itself is reported whatever else is latched: it keeps heating. But a frozen converter
        // repeats the current as well.
        let seen = evidence.stage == Some(Fault::StageOn) && self.latched != Some(Fault::Stuck);
        if seen {
            self.stuck_looks = self.stuck_looks.saturating_add(1);
        } else if !evidence.driven {
            // Only a dark period can clear a fault detected in one.
            self.stuck_looks = 0;
        }
        if self.stuck_looks >= DEBOUNCE_SAMPLES && !self.must_cut() {
            self.trip(Fault::StageOn);
            self.latched = Some(Fault::StageOn);
            return (Permit::Off, Some(Change::Tripped(Fault::StageOn)));
        }

        if self.state == State::Latched {
            return (Permit::Off, None);
        }

        // A wire that is too hot even for the sensing pulse cannot prove anything meanwhile.
        if evidence.driven {
            self.proving_s += dt_s;
            self.proving_periods = self.proving_periods.saturating_add(1);
        }

        // Budgets first: they apply to any sample. What is unknown counts as too much.
        let (temperature_c, budgets) = (self.heat.temperature_c(), self.heat.budgets());
        let hot = temperature_c.is_nan() || temperature_c > budgets.temperature_c;
        self.hot_periods = if hot { self.hot_periods + 1 } else { 0 };
        let spent = power_w.is_nan() || dt_s.is_nan() || self.heat.account_j() > budgets.energy_j;
        self.spent_periods = if spent { self.spent_periods + 1 } else { 0 };
        if self.hot_periods >= DEBOUNCE_SAMPLES {
            return (Permit::Off, self.trip(Fault::OverTemperature));
        }
        if self.spent_periods >= DEBOUNCE_SAMPLES {
            return (Permit::Off, self.trip(Fault::EnergyBudget));
        }

        if evidence.driven {
            match wrong_with(evidence, self.max_current_a) {
                None => {
                    self.bad_samples = 0;
                    self.unrest = self.unrest.saturating_sub(1);
                    self.good_samples = self.good_samples.saturating_add(1);
                }
                Some(fault) => {
                    if self.bad_samples == 0 {
                        self.suspect = fault;
                    }
                    self.bad_samples += 1;
                    self.unrest += 2;
                    self.good_samples = 0;
                    if self.bad_samples >= DEBOUNCE_SAMPLES || self.unrest >= MOST_UNREST {
                        return (Permit::Off, self.trip(self.suspect));
                    }
                    // With any bad sample: no heating.
                    return (Permit::SensingPulse, None);
                }
            }
        }
        if self.stuck_looks > 0 {
            // One more dark period, as confirmation; the next sample may still be of a period with duty.
            return (Permit::Off, None);
        }

        if self.state == State::Healthy {
            return (Permit::Power, None);
        }
        if self.good_samples >= PROOF_SAMPLES {
            self.state = State::Healthy;
            self.latched = None;
            return (Permit::Power, Some(Change::Proved));
        }
        if self.proving_s > PROOF_TIMEOUT_S && self.proving_periods > 4 * PROOF_SAMPLES {
            return (Permit::Off, self.trip(self.suspect));
        }
        (Permit::SensingPulse, None)
    }

    /// Latches a fault found elsewhere (backend, overrun). While one is latched the first cause stays, and a second one changes
    /// nothing; a channel that was proving itself after a reset takes the new one. Returns the change, if it is one.
    #[inline]
    pub fn trip(&mut self, fault: Fault) -> Option<Change> {
        let news = self.state != State::Latched;
        if news {
            self.latched = Some(fault);
        }
        self.state = State::Latched;
        self.bad_samples = 0;
        self.unrest = 0;
        self.good_samples = 0;
        self.hot_periods = 0;
        self.spent_periods = 0;
        news.then_some(Change::Tripped(fault))
    }

    /// Asks to clear the latched fault. What can be known without current is checked at once; the rest by the channel proving
    /// itself under the sensing pulse, after which [`Guard::judge`] reports [`Change::Proved`] or the fault again.
    /// Returns whether there is something to prove (`false`: nothing was latched).
    ///
    /// # Errors
    /// The latched fault, when its cause is plainly still there.
    pub fn reset(&mut self) -> Result<bool, Fault> {
        let Some(fault) = self.latched else { return Ok(false) };
        if self.state == State::Proving {
            return Ok(true);
        }
        if fault.needs_restart() {
            return Err(fault);
        }
        // Whatever the first cause was: it would trip again in the next period.
        if self.cooldown().is_some() {
            return Err(fault);
        }
        self.state = State::Proving;
        self.proving_s = 0.0;
        self.proving_periods = 0;
        self.suspect = fault;
        Ok(true)
    }
}

/// The fault a sample shows, if any.
#[inline]
fn wrong_with(evidence: &Evidence, max_current_a: f64) -> Option<Fault> {
    // Over-current before the sample's own verdict: a short shows as both, and over-current is the dangerous one.
    match evidence.health {
        // A stage fault explains the sample's other symptoms.
        _ if evidence.stage.is_some() => evidence.stage,
        Health::Ok if evidence.current_a > max_current_a => Some(Fault::OverCurrent),
        Health::Ok => None,
        Health::NoSample => Some(Fault::NoSample),
        Health::NotFinite => Some(Fault::NotFinite),
        Health::Saturated => Some(Fault::Saturated),
        Health::SupplyDip => Some(Fault::SupplyDip),
        // A duty was commanded, but there is neither current nor voltage: the stage, or the lead from it.
        Health::NoCurrent => Some(Fault::StageWeak),
        Health::OpenWire => Some(Fault::OpenWire),
        Health::ShortedWire => Some(Fault::ShortedWire),
        Health::ProbeLost => Some(Fault::ProbeLost),
        Health::OutOfRange => Some(Fault::OutOfRange),
        Health::Stuck => Some(Fault::Stuck),
        Health::ProbeStuck => Some(Fault::ProbeStuck),
    }
}

/// Watches over the loop's own punctuality.
#[derive(Debug, Clone, Copy, Default)]
pub struct Punctuality {
    late_s: f64,
    missed: u64,
}

impl Punctuality {
    /// Takes one cycle: how many periods it missed and how long there was no control, s. `true` when everything is to be
    /// switched off.
    #[inline]
    pub fn lost(&mut self, missed: u64, dt_s: f64) -> bool {
        if missed == 0 {
            *self = Punctuality::default();
            return false;
        }
        self.late_s += dt_s;
        self.missed = self.missed.saturating_add(missed);
        let lost = self.late_s >= OVERRUN_S && self.missed >= OVERRUN_PERIODS;
        if lost {
            // The next row is counted from here; a late last cycle still stands in the way of a reset.
            (self.late_s, self.missed) = (0.0, 1);
        }
        lost
    }

    /// Whether the last cycle was on time.
    pub fn on_time(&self) -> bool {
        self.missed == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Budgets;
    use proptest::prelude::*;

    const BUDGETS: Budgets = crate::budget::EXAMPLE;
    const QUIET: Passed = Passed {
        power_w: 0.1,
        dt_s: 1e-3,
        estimate_c: 30.0,
        martensite: 1.0,
        is_measured: true,
        cooling_curve_c: 25.0,
        length_m: f64::NAN,
        cold_c: None,
    };

    fn new() -> Guard {
        Guard::new(0.7, Heat::at_rest(BUDGETS, crate::heat::EXAMPLE))
    }

    fn heated(power_w: f64) -> Passed {
        Passed { power_w, ..QUIET }
    }
    const GOOD: Evidence = Evidence { driven: true, health: Health::Ok, stage: None, current_a: 0.5, heat: QUIET };

    fn healthy() -> Guard {
        let mut guard = new();
        for _ in 0..PROOF_SAMPLES {
            guard.judge(&GOOD);
        }
        assert!(guard.is_healthy());
        guard
    }

    #[test]
    fn the_energy_account_fills_drains_and_trips() {
        let mut guard = healthy();
        // 3 W in, 1 W drains of 2 J, undisturbed by derating: full after τ ln(3/2) = 0.81 s, and one period of debouncing.
        let heating = Evidence { heat: heated(3.0), ..GOOD };
        let tripped = (1..5000).find(|_| guard.judge(&heating).1.is_some());
        assert!(matches!(tripped, Some(811..=814)), "{tripped:?}");
        assert_eq!(guard.fault(), Some(Fault::EnergyBudget));
        assert_eq!(guard.reset(), Err(Fault::EnergyBudget), "still full");
        let resting = Evidence { driven: false, heat: heated(0.0), ..GOOD };
        for _ in 0..460 {
            assert_eq!(guard.judge(&resting), (Permit::Off, None));
        }
        assert!(guard.heat().account_j() < ENERGY_MARGIN * BUDGETS.energy_j);
        assert_eq!(guard.reset(), Ok(true));
        for _ in 0..20_000 {
            guard.judge(&GOOD);
        }
        // 0.1 W for good fills a tenth of it.
        assert!((guard.heat().account_j() - 0.2).abs() < 1e-3, "{}", guard.heat().account_j());
    }

    #[test]
    fn a_temperature_nobody_knows_is_too_hot() {
        let mut guard = healthy();
        let unknown = Evidence { heat: Passed { estimate_c: f64::NAN, ..QUIET }, ..GOOD };
        assert_eq!(guard.judge(&unknown).1, None);
        assert_eq!(guard.judge(&unknown), (Permit::Off, Some(Change::Tripped(Fault::OverTemperature))));
        assert!(guard.reset().is_err(), "still unknown");
    }

    #[test]
    fn a_power_nobody_knows_is_too_much_and_does_not_clear_the_account() {
        let mut guard = healthy();
        for _ in 0..500 {
            guard.judge(&Evidence { heat: heated(3.0), ..GOOD });
        }
        let account_j = guard.heat().account_j();
        let unknown = Evidence { heat: heated(f64::NAN), ..GOOD };
        assert_eq!(guard.judge(&unknown).1, None);
        assert_eq!(guard.judge(&unknown), (Permit::Off, Some(Change::Tripped(Fault::EnergyBudget))));
        assert_eq!(guard.heat().account_j(), account_j);
    }

    #[test]
    fn flapping_contacts_never_prove_themselves_and_are_latched_in_the_end() {
        let mut guard = new();
        let bad = Evidence { health: Health::ProbeLost, ..GOOD };
        let tripped = (0..3000).find(|k| guard.judge(if k % 3 == 0 { &bad } else { &GOOD }).1.is_some());
        assert!(matches!(tripped, Some(1000..=1010)), "{tripped:?}");
        assert_eq!(guard.fault(), Some(Fault::ProbeLost));
    }

    #[test]
    fn a_contact_that_flaps_under_power_latches_and_a_rare_bad_sample_does_not() {
        let bad = Evidence { health: Health::ProbeLost, ..GOOD };
        let mut guard = healthy();
        let tripped = (0..100).find(|k| guard.judge(if k % 2 == 0 { &bad } else { &GOOD }).1.is_some());
        assert_eq!(tripped, Some(28), "every second one bad");
        let mut guard = healthy();
        assert!((0..3000).all(|k| guard.judge(if k % 3 == 0 { &bad } else { &GOOD }).1.is_none()), "every third");
    }

    #[test]
    fn without_current_there_is_nothing_to_judge() {
        let mut guard = healthy();
        let dark = Evidence { driven: false, health: Health::NoSample, current_a: f64::NAN, ..GOOD };
        for _ in 0..100 {
            assert_eq!(guard.judge(&dark), (Permit::Power, None));
        }
        // And where there should be a current, none means an open circuit.
        let none = Evidence { health: Health::NoCurrent, ..GOOD };
        guard.judge(&none);
        assert_eq!(guard.judge(&none).1, Some(Change::Tripped(Fault::StageWeak)));
    }

    #[test]
    fn a_stage_that_conducts_in_the_dark_is_latched_over_everything_and_for_good() {
        let dark = Evidence { driven: false, health: Health::NoCurrent, heat: heated(0.0), ..GOOD };
        let stuck = Evidence { stage: Some(Fault::StageOn), ..dark };
        let mut guard = healthy();
        assert_eq!(guard.judge(&stuck), (Permit::Off, None), "once more in the dark");
        assert_eq!(guard.judge(&dark).0, Permit::Power, "one look is noise");
        guard.judge(&stuck);
        assert_eq!(guard.judge(&GOOD), (Permit::Off, None), "an on-phase says nothing of the stage");
        assert_eq!(guard.judge(&stuck), (Permit::Off, Some(Change::Tripped(Fault::StageOn))));
        assert!(guard.must_cut());
        assert_eq!(guard.judge(&stuck), (Permit::Off, None), "told once");
        assert_eq!(guard.reset(), Err(Fault::StageOn));
        // Whatever was latched before, this is what matters now.
        let mut guard = healthy();
        guard.trip(Fault::OverTemperature);
        guard.judge(&stuck);
        assert_eq!(guard.judge(&stuck).1, Some(Change::Tripped(Fault::StageOn)));
        assert_eq!(guard.fault(), Some(Fault::StageOn));
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![5 => -1e3..1e3f64, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(-1e300)]
    }

    proptest! {
        #[test]
        fn power_is_only_given_on_good_evidence(
            history in prop::collection::vec(
                (any::<bool>(), 0u8..22, number(), number(), number(), 0u8..40), 1..400),
        ) {
            let mut guard = new();
            let mut good_in_a_row = 0;
            let mut ever_proved = false;
            for (driven, health, current_a, power_w, temperature_c, whim) in history {
                // Mostly healthy, or nothing would ever happen.
                let health = Health::from_code(health).unwrap_or(Health::Ok);
                let heat = Passed { power_w, estimate_c: temperature_c, ..QUIET };
                let evidence = Evidence { driven, health, stage: None, current_a, heat };
                let before = guard.fault();
                let was_latched = before.is_some() && !guard.is_proving();
                let (permit, change) = guard.judge(&evidence);
                if driven {
                    good_in_a_row = if health.is_ok() { good_in_a_row + 1 } else { 0 };
                }
                match change {
                    Some(Change::Proved) => {
                        prop_assert!(good_in_a_row >= PROOF_SAMPLES);
                        ever_proved = true;
                    }
                    Some(Change::Tripped(fault)) => {
                        prop_assert!(!was_latched);
                        prop_assert_eq!(guard.fault(), Some(fault));
                        prop_assert_eq!(permit, Permit::Off);
                    }
                    None => {}
                }
                if was_latched {
                    prop_assert_eq!((permit, guard.fault()), (Permit::Off, before));
                }
                if permit == Permit::Power {
                    prop_assert!(ever_proved && guard.fault().is_none());
                    prop_assert!(!driven || health.is_ok());
                }
                prop_assert!(guard.heat().account_j() >= 0.0);
                match whim {
                    0 => { guard.trip(Fault::Backend); good_in_a_row = 0; }
                    1 => { let _ = guard.reset(); good_in_a_row = 0; }
                    _ => {}
                }
            }
        }
    }
}
