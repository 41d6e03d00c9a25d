//! Keeps every wire whole: decides, each period and before any controller is asked, whether a channel may be powered.
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
//! only a healthy one gets what its controller asks for. A *latched* one gets exactly nothing, no sensing pulse either: after
//! an electrical fault even that may feed a short or an arc, and after any other the wire is to cool. It keeps its first cause
//! until somebody resets it; then the sensing pulse comes back and the channel has to prove itself again before the fault is
//! cleared. If the cause is still there, it latches within [`DEBOUNCE_SAMPLES`] periods.
//!
//! Which faults there are, what they are called and what to do about them stands in one table, [`sinew_ipc::fault`].
//! The debouncing is chosen so that noise never trips:
//!
//! | evidence | threshold | periods | why noise cannot |
//! |---|---|---|---|
//! | health of a sample | 8 standard deviations clear of anything healthy (`sinew-sensing`) | 2 | 10⁻¹⁵ a sample, 10⁻³⁰ twice in a row |
//! | current in the on-phase | `max_current_a` + 8 standard deviations of the converter | 2 | the same |
//! | estimated temperature, energy account | the limit | 2 | both are integrals: noise moves them by less than 0.1 K |
//! | overrun | [`OVERRUN_RUN`] late cycles in a row, or one gap of [`LARGEST_GAP_S`] | | single late wake-ups are only counted |
//! | stale setpoint | the lease's end | 1 | a clock has no noise |
//!
//! The first bad sample already takes the controller's duty away: a channel is at the sensing pulse one period after a
//! fault has begun, and off after two.

use sinew_ipc::Fault;
use sinew_sensing::Health;

/// Good samples in a row that make a channel fit to be powered.
pub const PROOF_SAMPLES: u32 = 8;
/// Bad samples in a row that latch a fault.
pub const DEBOUNCE_SAMPLES: u32 = 2;
/// A channel that has neither proved itself nor shown a clear fault for so long (s) is latched with the last thing wrong.
pub const PROOF_TIMEOUT_S: f64 = 1.0;
/// Late cycles in a row (each of them missed at least one period) that switch everything off.
pub const OVERRUN_RUN: u32 = 20;
/// One gap without control, s, that switches everything off: longer than a busy machine makes, shorter than it takes to
/// overheat a wire at full power by more than its latent heat.
pub const LARGEST_GAP_S: f64 = 0.25;
/// The estimate must have come down by so much, K, before a temperature fault can be reset.
pub const TEMPERATURE_MARGIN_K: f64 = 10.0;
/// The energy account must have drained to this share of its budget before an energy fault can be reset.
pub const ENERGY_MARGIN: f64 = 0.8;

/// What a channel's guard holds it to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GuardLimits {
    /// Largest current in the on-phase, noise allowed for, A.
    pub max_current_a: f64,
    /// Highest estimated temperature, °C.
    pub max_temperature_c: f64,
    /// Heat the wire may take beyond what drains, J.
    pub energy_budget_j: f64,
    /// Rate at which the energy account drains, W.
    pub energy_drain_w: f64,
}

/// Everything a guard judges by in one period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Whether current was driven in the period the sample is from: with duty 0 there is nothing to see.
    pub driven: bool,
    /// Verdict on the sample.
    pub health: Health,
    /// Current in the on-phase, A, as sampled.
    pub current_a: f64,
    /// Mean power into the wire over the time since the last cycle, W.
    pub power_w: f64,
    /// Estimated temperature of the wire, °C.
    pub temperature_c: f64,
    /// Time since the last cycle, s.
    pub dt_s: f64,
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
    limits: GuardLimits,
    state: State,
    /// Good samples in a row while proving.
    good_samples: u32,
    /// How long it has been proving, s.
    proving_s: f64,
    /// Bad samples in a row, and what the first of them showed.
    bad_samples: u32,
    suspect: Fault,
    hot_periods: u32,
    spent_periods: u32,
    /// The energy account: what went in less what drained, never below 0, J.
    energy_j: f64,
    temperature_c: f64,
    latched: Option<Fault>,
}

impl Guard {
    /// A guard that trusts nothing yet.
    pub fn new(limits: GuardLimits) -> Guard {
        Guard {
            limits,
            state: State::Proving,
            good_samples: 0,
            proving_s: 0.0,
            bad_samples: 0,
            suspect: Fault::NoSample,
            hot_periods: 0,
            spent_periods: 0,
            energy_j: 0.0,
            temperature_c: f64::NAN,
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

    /// Whether the channel is proving itself, after the start or a reset.
    pub fn is_proving(&self) -> bool {
        self.state == State::Proving
    }

    /// What the energy account stands at, J.
    pub fn energy_j(&self) -> f64 {
        self.energy_j
    }

    /// Judges one period. Constant time, no allocation; NaN in the evidence is a fault and not a panic.
    #[inline]
    pub fn judge(&mut self, evidence: &Evidence) -> (Permit, Option<Change>) {
        self.temperature_c = evidence.temperature_c;
        let drained = (evidence.power_w - self.limits.energy_drain_w) * evidence.dt_s;
        self.energy_j = (self.energy_j + drained).max(0.0);

        if self.state == State::Latched {
            return (Permit::Off, None);
        }

        // Budgets first: they hold whatever the sample looks like. Written so that NaN counts as too hot.
        let hot = !(evidence.temperature_c <= self.limits.max_temperature_c);
        self.hot_periods = if hot { self.hot_periods + 1 } else { 0 };
        let spent = !(self.energy_j <= self.limits.energy_budget_j);
        self.spent_periods = if spent { self.spent_periods + 1 } else { 0 };
        if self.hot_periods >= DEBOUNCE_SAMPLES {
            return (Permit::Off, self.trip(Fault::OverTemperature));
        }
        if self.spent_periods >= DEBOUNCE_SAMPLES {
            return (Permit::Off, self.trip(Fault::EnergyBudget));
        }

        if evidence.driven {
            match wrong_with(evidence, &self.limits) {
                None => {
                    self.bad_samples = 0;
                    self.good_samples = self.good_samples.saturating_add(1);
                }
                Some(fault) => {
                    if self.bad_samples == 0 {
                        self.suspect = fault;
                    }
                    self.bad_samples += 1;
                    self.good_samples = 0;
                    if self.bad_samples >= DEBOUNCE_SAMPLES {
                        return (Permit::Off, self.trip(self.suspect));
                    }
                    // Whatever is wrong, it is not the moment to heat.
                    return (Permit::SensingPulse, None);
                }
            }
        }

        if self.state == State::Healthy {
            return (Permit::Power, None);
        }
        self.proving_s += evidence.dt_s;
        if self.good_samples >= PROOF_SAMPLES {
            self.state = State::Healthy;
            self.latched = None;
            return (Permit::Power, Some(Change::Proved));
        }
        if self.proving_s > PROOF_TIMEOUT_S {
            return (Permit::Off, self.trip(self.suspect));
        }
        (Permit::SensingPulse, None)
    }

    /// Latches a fault found elsewhere (backend, overrun). The first cause stays: a second one changes nothing. Returns the
    /// change, if it is one.
    #[inline]
    pub fn trip(&mut self, fault: Fault) -> Option<Change> {
        let news = self.state != State::Latched;
        self.state = State::Latched;
        // A cause that comes back while the channel proves itself after a reset is still the first one, if it is the same;
        // another one is news.
        self.latched = Some(if news { fault } else { self.latched.unwrap_or(fault) });
        self.bad_samples = 0;
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
        let cool = self.temperature_c <= self.limits.max_temperature_c - TEMPERATURE_MARGIN_K;
        let rested = self.energy_j <= ENERGY_MARGIN * self.limits.energy_budget_j;
        // Both, whatever the first cause was: it would trip again in the next period.
        if !cool || !rested {
            return Err(fault);
        }
        self.state = State::Proving;
        self.proving_s = 0.0;
        self.suspect = fault;
        Ok(true)
    }
}

/// The fault a sample shows, if any.
#[inline]
fn wrong_with(evidence: &Evidence, limits: &GuardLimits) -> Option<Fault> {
    // Over-current before the sample's own verdict: a short shows as both, and this is the one that burns.
    match evidence.health {
        Health::Ok if evidence.current_a > limits.max_current_a => Some(Fault::OverCurrent),
        Health::Ok => None,
        Health::NoSample => Some(Fault::NoSample),
        Health::NotFinite => Some(Fault::NotFinite),
        Health::Saturated => Some(Fault::Saturated),
        Health::SupplyDip => Some(Fault::SupplyDip),
        // Current was asked for and none flows, nor is there a voltage: the break is before the taps.
        Health::NoCurrent | Health::OpenWire => Some(Fault::OpenWire),
        Health::ShortedWire => Some(Fault::ShortedWire),
        Health::ProbeLost => Some(Fault::ProbeLost),
        Health::OutOfRange => Some(Fault::OutOfRange),
        Health::Stuck => Some(Fault::Stuck),
    }
}

/// Watches over the loop's own punctuality.
#[derive(Debug, Clone, Copy, Default)]
pub struct Punctuality {
    late_run: u32,
}

impl Punctuality {
    /// Takes one cycle: how many periods it missed and how long there was no control, s. `true` when everything is to be
    /// switched off.
    #[inline]
    pub fn lost(&mut self, missed: u64, dt_s: f64) -> bool {
        self.late_run = if missed > 0 { self.late_run.saturating_add(1) } else { 0 };
        let lost = self.late_run >= OVERRUN_RUN || (missed > 0 && dt_s >= LARGEST_GAP_S);
        if lost {
            self.late_run = 0;
        }
        lost
    }

    /// Whether the last cycle was on time.
    pub fn on_time(&self) -> bool {
        self.late_run == 0
    }
}
