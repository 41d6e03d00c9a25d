//! What is believed of a wire's heat: its temperature at worst and its heat account, through starts, gaps and silences.
//!
//! What is not known is assumed to be the worst. Five things make up the belief:
//!
//! - **The estimate** of a protective estimator: what power, length and resistance say of the wire since they have been watched.
//! - **The heat that was surely put in**: what power alone leaves in the wire under the [most loss](MOST_LOSS) that is believed. Where the load is
//!   jammed, length and resistance stand, and an estimator that takes them for a wire in a draught is too cold by tens of kelvins; the
//!   estimate is no colder than this.
//! - **The excess**: how much hotter the wire may be than that, because it was not watched before. A wire whose history is unknown is at
//!   its limit. Of two equal wires that get the same power the hotter one comes down to the other, so the excess decays by
//!   the loss to the air: by the [slowest](SLOWEST_LOSS) that is believed, and more slowly while the wire may have latent
//!   heat to release that the estimate does not know of.
//! - **What nobody sees**: while a wire is not measured, or is [jammed](crate::jam), it is no colder than one that cools by the slowest law
//!   (with the latent heat it may release), however the estimate goes on. That of an unmeasured wire ends with the next measurements.
//! - **The account**: the thermal image by current and resistance alone (see [`crate::budget`]), integrated exactly however
//!   long the gap.
//!
//! A witness ends an excess early: length and resistance that both say a cold wire ([`ColdWitness`](crate::cold::ColdWitness)). Where they disagree, the worst
//! case stays.

use sinew_physics::WireModel;
use sinew_physics::formulas::{WORKING_EXCESS_K, logistic, relaxed};

use crate::budget::{Allowance, Budgets, Derating};
use crate::jam::{JamWatch, Stand};

/// Share of the loss to the air that a wire surely has: beliefs may be 30 % off.
pub const SLOWEST_LOSS: f64 = 0.7;
/// The most loss to the air that is believed, as a multiple of the model's: a draught that takes half as much again, and a bit.
pub const MOST_LOSS: f64 = 1.6;
/// Samples in a row in which the witnesses must agree on a cold wire.
const AGREEING: u32 = 8;
/// An excess below this is none, K.
const NO_EXCESS_K: f64 = 0.5;
/// An excess is gone through in steps no longer than that, s, and for no longer than that.
const STEP_S: f64 = 0.025;
const LONGEST_S: f64 = 600.0;
/// Time in which an estimator finds back to a wire that is measured again, s.
const FINDS_BACK_S: f64 = 0.1;
/// A memory that says so much less, K, than a measured phase allows that is surely not at its cold end, is wrong.
const CONTRADICTED_K: f64 = 20.0;
const SURELY_INSIDE: f64 = 0.9;

/// How a wire cools that nobody measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cooling {
    /// Heat capacity of the wire, J/K.
    pub heat_capacity_j_per_k: f64,
    /// That of a sleeve around it, which cools with it, J/K; 0 where its rig file states none.
    pub sleeve_j_per_k: f64,
    /// Least loss to the air, W/K, through the sleeve where there is one.
    pub loss_w_per_k: f64,
    /// Most loss to its surroundings, W/K.
    pub most_loss_w_per_k: f64,
    /// Heat it releases when all of it turns martensite, J.
    pub latent_j: f64,
    /// Where it does so: centre of the cooling curve at the preload, °C, and width, K (eq. 20).
    pub centre_c: f64,
    /// See there.
    pub width_k: f64,
}

impl Cooling {
    /// As a rig file's wire cools at the slowest.
    pub fn of(model: &WireModel) -> Cooling {
        let m = &model.material;
        let sheath = &model.effects.thermal.sheath;
        let (inner, outer) = (sheath.inner_w_per_k, sheath.outer_w_per_k);
        let in_air = model.loss_w_per_k(WORKING_EXCESS_K);
        let [least, most] = if sheath.is_on() {
            // as one body with its sleeve, and no faster than heat gets into that and out of it
            [inner * outer / (inner + outer).max(f64::MIN_POSITIVE), inner]
        } else {
            [in_air, in_air]
        };
        Cooling {
            heat_capacity_j_per_k: model.heat_capacity_j_per_k(),
            sleeve_j_per_k: sheath.heat_capacity_j_per_k,
            loss_w_per_k: SLOWEST_LOSS * least,
            most_loss_w_per_k: MOST_LOSS * most,
            latent_j: model.latent_heat_j(),
            centre_c: m.martensite_temperature_c,
            width_k: 1.0 / m.cooling_steepness_per_k,
        }
    }

    /// Rate at which an excess goes, 1/s, of a wire that may be this hot. `phase_known`: its latent heat is in the estimate.
    fn rate_per_s(&self, temperature_c: f64, phase_known: bool) -> f64 {
        let xi = if phase_known { 0.0 } else { logistic(temperature_c, self.centre_c, self.width_k) };
        let latent_j_per_k = self.latent_j * xi * (1.0 - xi) / self.width_k;
        self.loss_w_per_k / (self.heat_capacity_j_per_k + self.sleeve_j_per_k + latent_j_per_k)
    }

    /// Temperature, °C, at the most, of a wire that was this hot, after so long at this power, W: with the least loss, the latent heat that it
    /// may release as it cools, and none that it takes up.
    fn at_most_c(&self, temperature_c: f64, power_w: f64, ambient_c: f64, seconds: f64) -> f64 {
        let Cooling { heat_capacity_j_per_k, sleeve_j_per_k, loss_w_per_k, latent_j, centre_c, width_k, .. } = *self;
        let seconds = seconds.min(LONGEST_S);
        let steps = (seconds / STEP_S).ceil().max(1.0);
        (0..steps as u32).fold(temperature_c, |now_c, _| {
            let heat_w = power_w - loss_w_per_k * (now_c - ambient_c);
            // what its sleeve takes up of a power is not counted on
            let (xi, sleeve) =
                if heat_w < 0.0 { (logistic(now_c, centre_c, width_k), sleeve_j_per_k) } else { (0.0, 0.0) };
            now_c + heat_w * seconds / steps / (heat_capacity_j_per_k + sleeve + latent_j * xi * (1.0 - xi) / width_k)
        })
    }

    /// Share of its heat that it loses in a second at the most, 1/s: by its fastest law.
    fn most_leak_per_s(&self) -> f64 {
        self.most_loss_w_per_k / self.heat_capacity_j_per_k
    }

    /// Temperature, °C, at the most, of a wire that was this hot, after so long without power: by its slowest law.
    pub fn cooled_c(&self, temperature_c: f64, ambient_c: f64, seconds: f64) -> f64 {
        ambient_c + self.decayed_k((temperature_c - ambient_c).max(0.0), ambient_c, seconds, false)
    }

    /// How long it takes at the most, s, until a wire that is this hot, °C, is no hotter than `below_c`, in air that is colder than that: the
    /// slowest law in closed form, with all the latent heat it may release on the way given off at the end of it, where that takes longest.
    fn longest_s(&self, temperature_c: f64, below_c: f64, ambient_c: f64) -> f64 {
        if temperature_c <= below_c {
            return 0.0;
        }
        let end_k = below_c - ambient_c;
        let released_j = self.latent_j * logistic(below_c, self.centre_c, self.width_k);
        let stored_j_per_k = self.heat_capacity_j_per_k + self.sleeve_j_per_k;
        let sensible_s = stored_j_per_k / self.loss_w_per_k * ((temperature_c - ambient_c) / end_k).ln();
        sensible_s + released_j / (self.loss_w_per_k * end_k)
    }

    /// What is left of an excess over a wire of `estimate_c`, K.
    fn decayed_k(&self, excess_k: f64, estimate_c: f64, seconds: f64, phase_known: bool) -> f64 {
        if phase_known || seconds <= STEP_S {
            let rate_per_s = self.rate_per_s(estimate_c + excess_k, phase_known);
            return relaxed(excess_k, 0.0, rate_per_s * seconds);
        }
        let seconds = seconds.min(LONGEST_S);
        let steps = (seconds / STEP_S).ceil();
        (0..steps as u32).fold(excess_k, |left_k, _| {
            relaxed(left_k, 0.0, self.rate_per_s(estimate_c + left_k, false) * seconds / steps)
        })
    }
}

/// What a period adds to the belief.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passed {
    /// Mean power into the wire at the most, W.
    pub power_w: f64,
    /// Time since the last one, s.
    pub dt_s: f64,
    /// Temperature by a protective estimator, °C.
    pub estimate_c: f64,
    /// Martensite by it, and whether that comes from a length measured in this period.
    pub martensite: f64,
    /// See there.
    pub is_measured: bool,
    /// Temperature of the cooling curve at that phase, °C: a measured wire is not colder.
    pub cooling_curve_c: f64,
    /// Observed length, m; NaN where there is none.
    pub length_m: f64,
    /// The temperature it cannot be above, °C, where the witnesses see a cold wire.
    pub cold_c: Option<f64>,
}

/// What a record says of a wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recalled {
    /// Temperature at worst then, °C.
    pub temperature_c: f64,
    /// Temperature that it surely had then, °C; NaN where that is not known.
    pub surely_c: f64,
    /// The account then, J; NaN where only the temperature is known.
    pub account_j: f64,
    /// The most its output can have given it since, until it fell silent, W.
    pub given_w: f64,
    /// How long ago that was, s.
    pub since_s: f64,
}

/// The belief of one wire.
#[derive(Debug, Clone)]
pub struct Heat {
    budgets: Budgets,
    derating: Derating,
    cooling: Cooling,
    /// The account: what went in less what drained, never below 0, J.
    account_j: f64,
    /// What is left of it after a period of a length, s, that has hardly ever another.
    kept: (f64, f64),
    /// The same of the heat that is surely in it.
    surely_kept: (f64, f64),
    estimate_c: f64,
    martensite: f64,
    excess_k: f64,
    /// How much hotter it may be because it is not measured, K.
    unseen_k: f64,
    /// Where the load says when the wire has to move: whether it does.
    jam: Option<JamWatch>,
    /// Heat beyond the air's temperature that is surely in the wire, besides what turned it austenite, J.
    surely_j: f64,
    /// Temperature that was assumed, until the first estimate makes an excess of it, °C.
    assumed_c: Option<f64>,
    /// Measurements still to come that may belie the memory it came from.
    unconfirmed_memory: u32,
    agreeing: u32,
}

impl Heat {
    /// A wire that is known to be at rest in its air.
    pub fn at_rest(budgets: Budgets, cooling: Cooling) -> Heat {
        Heat {
            derating: Derating::new(&budgets),
            budgets,
            cooling,
            account_j: 0.0,
            kept: (f64::NAN, f64::NAN),
            surely_kept: (f64::NAN, f64::NAN),
            estimate_c: f64::NAN,
            martensite: f64::NAN,
            excess_k: 0.0,
            unseen_k: 0.0,
            jam: None,
            surely_j: 0.0,
            assumed_c: Some(budgets.ambient_c),
            unconfirmed_memory: 0,
            agreeing: 0,
        }
    }

    /// The same, whose load says when it has to move.
    pub fn watched_for_jams(self, jam: Option<JamWatch>) -> Heat {
        Heat { jam, ..self }
    }

    /// An output can stay as it is for so long, s.
    pub fn bear_silence(&mut self, silence_s: f64) {
        self.budgets.silence_s = silence_s;
        self.derating = Derating::new(&self.budgets);
    }

    /// From now on the wire is one whose history is unknown: at its limit.
    pub fn forget(&mut self) {
        self.assume(self.budgets.temperature_c, self.budgets.energy_j);
        self.unconfirmed_memory = 0;
    }

    /// From now on the wire may be this hot, °C, and its account stands at this, J: what a memory says. One that does not know the account
    /// (NaN) counts on what goes with the temperature; one that does not know that is none.
    pub fn remember(&mut self, temperature_c: f64, account_j: f64) {
        if !temperature_c.is_finite() {
            return self.forget();
        }
        let account_j = if account_j.is_finite() { account_j } else { self.account_at_j(temperature_c) };
        self.assume(temperature_c.min(self.budgets.temperature_c), account_j.clamp(0.0, self.budgets.energy_j));
        self.unconfirmed_memory = AGREEING;
    }

    /// From now on the wire is one of which a record says this: what its output gave it in silence without any loss, and then no more than
    /// it surely loses. Whether it is one that can be: else the history is unknown.
    pub fn recall(&mut self, recalled: &Recalled) -> bool {
        let &Recalled { temperature_c, surely_c, account_j, given_w, since_s } = recalled;
        if !(temperature_c.is_finite() && given_w.is_finite() && since_s >= 0.0) {
            self.forget();
            return false;
        }
        let silence_s = (self.budgets.silence_s + 2.0 * self.budgets.period_s).min(since_s);
        let given_j = given_w.max(0.0) * silence_s;
        let hottest_c = temperature_c + given_j / self.cooling.heat_capacity_j_per_k;
        let cooled_c = self.cooling.cooled_c(hottest_c, self.budgets.ambient_c, since_s - silence_s);
        let drained = (-self.derating.leak_per_s() * (since_s - silence_s)).exp();
        self.remember(cooled_c, (account_j + given_j) * drained);
        // A load that was jammed may be so still, and its wire says nothing of its heat.
        let surely_k = (surely_c - self.budgets.ambient_c) * (-self.cooling.most_leak_per_s() * since_s).exp();
        self.surely_j = self.cooling.heat_capacity_j_per_k * surely_k.max(0.0); // NaN is none
        true
    }

    /// From now on the wire is one whose history is unknown, but for this: so long, s, nothing was given to it. It was at its limit, and cools
    /// by its slowest law.
    pub fn was_unused(&mut self, since_s: f64) {
        let Budgets { temperature_c, energy_j: account_j, .. } = self.budgets;
        self.recall(&Recalled { temperature_c, surely_c: f64::NAN, account_j, given_w: 0.0, since_s });
    }

    /// The account of a wire that is as hot as this, °C, and may have been so for long, J.
    fn account_at_j(&self, temperature_c: f64) -> f64 {
        let Budgets { ambient_c, temperature_c: limit_c, energy_j, .. } = self.budgets;
        let share = (temperature_c - ambient_c) / (limit_c - ambient_c).max(1.0);
        share.clamp(0.0, 1.0) * energy_j
    }

    fn assume(&mut self, temperature_c: f64, account_j: f64) {
        self.assumed_c = Some(temperature_c.max(self.budgets.ambient_c));
        self.account_j = account_j;
        self.agreeing = 0;
    }

    /// What it is held to.
    pub fn budgets(&self) -> &Budgets {
        &self.budgets
    }

    /// The temperature the wire has at worst, °C; NaN is unknown, and the worst of all. While a history is unknown that is the limit:
    /// nothing is given to such a wire, so that it was never hotter.
    #[inline]
    pub fn temperature_c(&self) -> f64 {
        match self.assumed_c {
            Some(assumed_c) => assumed_c,
            None => {
                let added_k = self.excess_k.max(self.unseen_k);
                if added_k > 0.0 {
                    self.estimate_c.max((self.estimate_c + added_k).min(self.budgets.temperature_c))
                } else {
                    self.estimate_c
                }
            }
        }
    }

    /// The temperature the wire has at the least, °C: what power alone leaves in it under the most loss.
    #[inline]
    pub fn surely_c(&self) -> f64 {
        self.budgets.ambient_c + self.surely_j / self.cooling.heat_capacity_j_per_k
    }

    /// Whether its load is held: then what its length says of its temperature is wrong, and so is what an estimator learns from it.
    #[inline]
    pub fn is_jammed(&self) -> bool {
        self.jam.as_ref().is_some_and(JamWatch::is_held)
    }

    /// How much of it is for want of a history, K.
    pub fn excess_k(&self) -> f64 {
        if self.assumed_c.is_some() { self.temperature_c() - self.budgets.ambient_c } else { self.excess_k }
    }

    /// How long it takes at the most, s, until the wire is no hotter than this, °C, and its account no fuller than that, J, while it gets
    /// nothing. NaN where that is not known, or never. Constant time.
    pub fn longest_s(&self, temperature_c: f64, account_j: f64) -> f64 {
        let cools_s = self.cooling.longest_s(self.temperature_c(), temperature_c, self.budgets.ambient_c);
        let drains_s = (self.account_j / account_j).ln().max(0.0) / self.derating.leak_per_s();
        // NaN stays NaN
        if cools_s < drains_s { drains_s } else { cools_s }
    }

    /// What the account stands at, J.
    #[inline]
    pub fn account_j(&self) -> f64 {
        self.account_j
    }

    /// How full the account is, 1 = its budget.
    #[inline]
    pub fn filled(&self) -> f64 {
        self.derating.filled(self.account_j)
    }

    /// The power that keeps the wire within its budgets, and within them after the longest silence.
    #[inline]
    pub fn allowance(&self) -> Allowance {
        self.derating.allowance(self.account_j, self.temperature_c())
    }

    /// The same after so long, s, under so much, W, of which no cycle has heard yet, and without any loss.
    #[inline]
    pub fn allowance_after(&self, given_w: f64, seconds: f64) -> Allowance {
        // No longer than until the output goes off by itself.
        let seconds = seconds.min(self.budgets.silence_s + 2.0 * self.budgets.period_s);
        let gained_k = given_w / self.budgets.full_w * self.budgets.full_k_per_s * seconds;
        self.derating.allowance(self.account_j + given_w * seconds, self.temperature_c() + gained_k)
    }

    /// How long the largest power takes to heat the wire to its limit, without any loss, s; negative or NaN: it may be there.
    #[inline]
    pub fn spare_s(&self) -> f64 {
        (self.budgets.temperature_c - self.temperature_c()) / self.budgets.full_k_per_s
    }

    /// Whether the wire may have so much, W, without being derated.
    #[inline]
    pub fn allows(&self, power_w: f64) -> bool {
        self.allowance().power_w >= power_w
    }

    /// A period or a gap has passed. Constant time for a period; no allocation. An unknown power leaves the account as it is.
    #[inline]
    pub fn pass(&mut self, passed: &Passed) {
        let &Passed { power_w, dt_s, estimate_c, martensite, is_measured, .. } = passed;
        let before = std::mem::replace(&mut self.martensite, martensite);
        let before_c = self.temperature_c();
        // Nothing here cools a wire below its air, and one whose length says that it is partly austenite is no colder than its cooling
        // curve; NaN stays NaN.
        let is_inside = is_measured && martensite < SURELY_INSIDE;
        let least_c = if is_inside { passed.cooling_curve_c } else { self.budgets.ambient_c };
        let estimate_c = if estimate_c < least_c { least_c } else { estimate_c };
        if !(power_w.is_nan() || dt_s.is_nan()) {
            self.fill(power_w, dt_s);
            self.surely_fill(power_w, dt_s, martensite - before);
        }
        let surely_c = self.surely_c();
        let estimate_c = if estimate_c < surely_c { surely_c } else { estimate_c };
        self.estimate_c = estimate_c;
        let assumed = self.assumed_c.take();
        if let Some(assumed_c) = assumed {
            self.excess_k = (assumed_c - estimate_c).max(0.0);
        }
        if is_measured && self.unconfirmed_memory > 0 {
            self.unconfirmed_memory -= 1;
            // A wire that is shorter than any as cold as remembered: somebody has heated it meanwhile.
            if is_inside && passed.cooling_curve_c > passed.estimate_c + self.excess_k + CONTRADICTED_K {
                self.unconfirmed_memory = 0;
                self.account_j = self.budgets.energy_j;
                self.excess_k = (self.budgets.temperature_c - estimate_c).max(0.0);
            }
        }
        if self.excess_k > 0.0 {
            // Heat that the estimate lets the wire take up to turn austenite may have been in it all along.
            let taken_up = before - martensite;
            if !is_measured && assumed.is_none() && taken_up > 0.0 {
                self.excess_k += self.cooling.latent_j * taken_up / self.cooling.heat_capacity_j_per_k;
            }
            self.decay(passed);
        }
        if assumed.is_none() {
            self.add_unseen(passed, before_c, surely_c);
        }
    }

    /// What may be beyond the estimate because nothing shows it: `before_c` is what was believed before, `surely_c` what power leaves at the
    /// least.
    fn add_unseen(&mut self, passed: &Passed, before_c: f64, surely_c: f64) {
        let &Passed { power_w, dt_s, is_measured, martensite, length_m, .. } = passed;
        let length_m = if is_measured { length_m } else { f64::NAN };
        let stand = Stand { least_c: surely_c, most_c: before_c, martensite, length_m, dt_s };
        let is_held = self.jam.as_mut().is_some_and(|jam| jam.look(&stand));
        if is_measured && !is_held {
            // A gap before one measurement is no time in which it was measured.
            let measured_s = if dt_s > 0.0 { dt_s.min(self.budgets.period_s) } else { 0.0 };
            let left_k = self.unseen_k * FINDS_BACK_S / (FINDS_BACK_S + measured_s);
            self.unseen_k = if left_k < NO_EXCESS_K { 0.0 } else { left_k };
            return;
        }
        let most_c = self.cooling.at_most_c(before_c, power_w, self.budgets.ambient_c, dt_s);
        let added_k = most_c - self.estimate_c;
        // NaN adds nothing: an unknown estimate allows nothing anyway.
        if is_held {
            self.excess_k = self.excess_k.max(added_k);
        } else {
            self.unseen_k = added_k.max(0.0);
        }
    }

    /// The account.
    #[inline]
    fn fill(&mut self, power_w: f64, dt_s: f64) {
        let leak_per_s = self.derating.leak_per_s();
        self.account_j = leaked_j(self.account_j, power_w, leak_per_s, dt_s, &mut self.kept).max(0.0);
    }

    /// The heat that is surely in the wire, by its enthalpy (eq. 48) with the most loss.
    /// `turned` is how much more of it is martensite than before; NaN where that is not known.
    #[inline]
    fn surely_fill(&mut self, power_w: f64, dt_s: f64, turned: f64) {
        let left_j = leaked_j(self.surely_j, power_w, self.cooling.most_leak_per_s(), dt_s, &mut self.surely_kept);
        let released_j = if turned.is_nan() { 0.0 } else { self.cooling.latent_j * turned };
        self.surely_j = (left_j + released_j).max(0.0);
    }

    fn decay(&mut self, passed: &Passed) {
        let &Passed { dt_s, is_measured, .. } = passed;
        let estimate_c = self.estimate_c;
        if dt_s > 0.0 {
            self.excess_k = self.cooling.decayed_k(self.excess_k, estimate_c, dt_s, is_measured);
        }
        self.agreeing = match passed.cold_c {
            Some(_) => self.agreeing + 1,
            None if is_measured => 0,
            None => self.agreeing,
        };
        if let Some(cold_c) = passed.cold_c.filter(|_| self.agreeing >= AGREEING) {
            self.excess_k = self.excess_k.min((cold_c - estimate_c).max(0.0));
            self.account_j = self.account_j.min(self.account_at_j(cold_c));
        }
        if self.excess_k < NO_EXCESS_K {
            self.excess_k = 0.0;
        }
    }
}

/// A store of heat that loses of itself so much in a second: E' = P − E/τ, exactly, however long (for constant power). `kept` is what is
/// left of it after a period of a length, s, that has hardly ever another.
#[inline]
fn leaked_j(energy_j: f64, power_w: f64, leak_per_s: f64, dt_s: f64, kept: &mut (f64, f64)) -> f64 {
    if kept.0 != dt_s {
        *kept = (dt_s, (-leak_per_s * dt_s).exp());
    }
    let settled_j = power_w / leak_per_s;
    settled_j + (energy_j - settled_j) * kept.1
}

/// A wire that tests reckon with: that of [`crate::budget::EXAMPLE`], which takes 3 W at 200 K/s.
#[cfg(test)]
pub(crate) const EXAMPLE: Cooling = Cooling {
    heat_capacity_j_per_k: 0.015,
    sleeve_j_per_k: 0.0,
    loss_w_per_k: SLOWEST_LOSS * 0.008,
    most_loss_w_per_k: MOST_LOSS * 0.008,
    latent_j: 1.0,
    centre_c: 60.0,
    width_k: 4.0,
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget;
    use proptest::prelude::*;

    const PERIOD_S: f64 = 1e-3;

    fn at_rest() -> Heat {
        Heat::at_rest(budget::EXAMPLE, EXAMPLE)
    }

    fn forgotten() -> Heat {
        let mut heat = at_rest();
        heat.forget();
        heat
    }

    /// Nothing measured, nothing given, an estimate of a cold wire.
    const DARK: Passed = Passed {
        power_w: 0.0,
        dt_s: PERIOD_S,
        estimate_c: 25.0,
        martensite: 1.0,
        is_measured: false,
        cooling_curve_c: 25.0,
        length_m: f64::NAN,
        cold_c: None,
    };

    #[test]
    fn a_wire_without_history_is_at_its_limit_and_gets_nothing() {
        let heat = forgotten();
        assert_eq!((heat.temperature_c(), heat.filled()), (150.0, 1.0));
        assert!(!heat.allows(0.0), "{:?}", heat.allowance());
        assert_eq!(at_rest().temperature_c(), 25.0);
        assert!(at_rest().allows(3.0));
    }

    /// The belief is never below a wire that was at its limit, austenite, with the least loss that is believed, cooling along its
    /// cooling curve: that wire's own heat balance (eq. 48), integrated finely.
    #[test]
    fn a_forgotten_wire_cools_no_faster_than_the_slowest_one() {
        let (mut heat, mut truth_c, mut xi) = (forgotten(), 150.0, 0.0);
        let Cooling { heat_capacity_j_per_k, loss_w_per_k, latent_j, centre_c, width_k, .. } = EXAMPLE;
        let (mut least_k, mut most_k) = (f64::INFINITY, 0.0f64);
        for _ in 0..60_000 {
            heat.pass(&DARK);
            for _ in 0..4 {
                // explicit: the loss first, then what is released by the step in phase
                truth_c -= loss_w_per_k * (truth_c - 25.0) * 0.25 * PERIOD_S / heat_capacity_j_per_k;
                let along = logistic(truth_c, centre_c, width_k);
                truth_c += (along - xi).max(0.0) * latent_j
                    / (heat_capacity_j_per_k + latent_j * along * (1.0 - along) / width_k);
                xi = xi.max(logistic(truth_c, centre_c, width_k));
            }
            least_k = least_k.min(heat.temperature_c() - truth_c);
            most_k = most_k.max(heat.temperature_c() - truth_c);
        }
        assert!(least_k > -1.0 && most_k < 3.0, "between {least_k} and {most_k} K above it");
        assert!(heat.temperature_c() < 30.0, "and it comes down: {}", heat.temperature_c());
    }

    #[test]
    fn witnesses_that_agree_end_it_and_one_that_does_not_begins_anew() {
        let cold = Passed { is_measured: true, cold_c: Some(45.0), ..DARK };
        let mut heat = forgotten();
        for _ in 0..AGREEING - 1 {
            heat.pass(&cold);
        }
        heat.pass(&Passed { cold_c: None, ..cold });
        assert!(heat.temperature_c() > 140.0, "{}", heat.temperature_c());
        for _ in 0..AGREEING {
            heat.pass(&cold);
        }
        assert!((heat.temperature_c() - 45.0).abs() < 1e-9 && heat.filled() < 0.17, "{heat:?}");
        assert!(heat.allows(3.0));
    }

    #[test]
    fn it_is_cold_after_the_longest_time_and_not_long_before() {
        for (below_c, below_j) in [(140.0, 1.0), (140.0, 0.2), (70.0, 1.0)] {
            let mut heat = forgotten();
            let longest_s = heat.longest_s(below_c, below_j);
            let is_there = |heat: &Heat| heat.temperature_c() <= below_c && heat.account_j() <= below_j;
            let mut took_s = 0.0;
            while !is_there(&heat) {
                heat.pass(&DARK);
                took_s += PERIOD_S;
                assert!(took_s < longest_s + 0.01, "{below_c} °C, {below_j} J: not in {longest_s} s");
            }
            assert!(longest_s < 3.0 * took_s, "{below_c} °C, {below_j} J: {took_s} s, not {longest_s}");
        }
        assert_eq!(at_rest().longest_s(140.0, 0.5), 0.0);
        let mut unknown = at_rest();
        unknown.pass(&Passed { estimate_c: f64::NAN, ..DARK });
        assert!(unknown.longest_s(140.0, 0.5).is_nan());
    }

    #[test]
    fn a_memory_is_taken_at_its_word_unless_the_length_belies_it() {
        let mut heat = at_rest();
        heat.remember(80.0, 0.5);
        assert_eq!((heat.temperature_c(), heat.account_j()), (80.0, 0.5));
        heat.pass(&Passed { is_measured: true, ..DARK });
        assert!((heat.temperature_c() - 80.0).abs() < 0.1);
        // Its phase says that it cannot be below 130 °C.
        heat.pass(&Passed { is_measured: true, martensite: 0.95, cooling_curve_c: 130.0, ..DARK });
        assert!((heat.temperature_c() - 80.0).abs() < 0.1, "at its cold end a phase says nothing");
        heat.pass(&Passed { is_measured: true, martensite: 0.5, cooling_curve_c: 130.0, ..DARK });
        assert!((heat.temperature_c() - 150.0).abs() < 0.1 && heat.filled() == 1.0, "{heat:?}");
        let mut heat = at_rest();
        heat.remember(87.5, f64::NAN);
        assert_eq!(heat.filled(), 0.5);
        heat.remember(f64::NAN, 0.0);
        assert_eq!(heat.temperature_c(), 150.0, "a memory of nothing");
    }

    #[test]
    fn a_wire_that_was_not_used_cools_by_its_slowest_law_from_its_limit() {
        let mut heat = at_rest();
        heat.was_unused(0.0);
        assert_eq!((heat.temperature_c(), heat.filled()), (150.0, 1.0));
        // As one that was watched all along.
        let mut watched = forgotten();
        (0..10_000).for_each(|_| watched.pass(&DARK));
        heat.was_unused(10.0);
        // (until the output is silent it may have been given what it had)
        let (known_c, watched_c) = (heat.temperature_c(), watched.temperature_c());
        assert!((watched_c - 1.0..watched_c + 5.0).contains(&known_c), "{known_c} {watched_c}");
        heat.was_unused(600.0);
        assert!(heat.temperature_c() < 30.0 && heat.filled() < 0.01, "{heat:?}");
        heat.was_unused(f64::NAN);
        assert_eq!(heat.temperature_c(), 150.0);
    }

    /// What a jammed wire surely has is no less because its driver was born anew.
    #[test]
    fn heat_that_was_surely_put_in_outlasts_a_restart() {
        let heated = Passed { power_w: 3.0, ..DARK };
        let mut before = at_rest();
        (0..200).for_each(|_| before.pass(&heated));
        let surely_c = before.surely_c();
        assert!((50.0..66.0).contains(&surely_c), "of 40 K at the most: {surely_c}");
        let (temperature_c, account_j) = (before.temperature_c(), before.account_j());
        let record = |surely_c| Recalled { temperature_c, surely_c, account_j, given_w: 0.0, since_s: 0.2 };
        let mut after = at_rest();
        assert!(after.recall(&record(surely_c)));
        // 0.2 s of the most loss, 1.6 · 0.008 W/K of 0.015 J/K.
        let expected_c = 25.0 + (surely_c - 25.0) * (-1.6 * 0.008 / 0.015 * 0.2f64).exp();
        assert!((after.surely_c() - expected_c).abs() < 1e-9, "{} {expected_c}", after.surely_c());
        assert!(after.recall(&record(f64::NAN)));
        assert_eq!(after.surely_c(), 25.0, "a record that does not know it");
    }

    /// An estimate that falls at once to the air's temperature, or one that goes on cooling by the wire's own law with its heat balance.
    #[test]
    fn a_wire_nobody_sees_is_no_colder_than_its_slowest_law_and_one_that_is_seen_is() {
        let hot = Passed { estimate_c: 120.0, is_measured: true, ..DARK };
        let mut heat = at_rest();
        (0..100).for_each(|_| heat.pass(&hot));
        assert_eq!(heat.temperature_c(), 120.0);
        // A tenth of a second: of 95 K of excess it loses e^(−0.1 s · 0.0056/0.015 s) at the least.
        (0..100).for_each(|_| heat.pass(&DARK));
        let slowest_c = EXAMPLE.at_most_c(120.0, 0.0, 25.0, 0.1);
        assert!((heat.temperature_c() - slowest_c).abs() < 0.1, "{} {slowest_c}", heat.temperature_c());
        assert!((115.0..119.0).contains(&slowest_c), "{slowest_c}");
        // As hot in one gap.
        let mut gap = at_rest();
        gap.pass(&hot);
        gap.pass(&Passed { dt_s: 0.1, ..DARK });
        assert!((gap.temperature_c() - slowest_c).abs() < 0.1, "{} {slowest_c}", gap.temperature_c());
        // One measurement after a gap is one measurement.
        let mut stalled = heat.clone();
        stalled.pass(&Passed { dt_s: 0.24, estimate_c: 60.0, is_measured: true, ..DARK });
        assert!(stalled.temperature_c() > slowest_c - 2.0, "{}", stalled.temperature_c());
        // And it is over half a second after it is seen again.
        (0..500).for_each(|_| heat.pass(&Passed { estimate_c: 60.0, is_measured: true, ..DARK }));
        assert!(heat.temperature_c() < 61.0, "{}", heat.temperature_c());
    }

    #[test]
    fn latent_heat_the_estimate_lets_an_unmeasured_wire_take_up_counts_as_heat() {
        let mut heat = at_rest();
        heat.remember(80.0, 0.0);
        heat.pass(&DARK);
        let before_k = heat.excess_k();
        heat.pass(&Passed { estimate_c: 70.0, martensite: 0.9, ..DARK });
        // A tenth of 1 J in 0.015 J/K, less what a period's cooling takes.
        assert!((heat.excess_k() - before_k - 0.1 / 0.015).abs() < 0.1, "{} after {before_k}", heat.excess_k());
    }

    proptest! {
        /// One gap or many cycles: the account is the same, to rounding.
        #[test]
        fn the_account_does_not_depend_on_how_time_is_cut(
            power_w in 0.0..5.0f64, periods in 1usize..5000, cuts in 1usize..40,
        ) {
            let (mut whole, mut cut) = (at_rest(), at_rest());
            let seconds = periods as f64 * PERIOD_S;
            whole.pass(&Passed { power_w, dt_s: seconds, ..DARK });
            for _ in 0..cuts {
                cut.pass(&Passed { power_w, dt_s: seconds / cuts as f64, ..DARK });
            }
            prop_assert!((whole.account_j() - cut.account_j()).abs() < 1e-9 * (1.0 + whole.account_j()));
        }

        /// And so is the excess, nearly.
        #[test]
        fn nor_does_the_excess(periods in 1usize..20_000) {
            let (mut whole, mut cut) = (forgotten(), forgotten());
            for heat in [&mut whole, &mut cut] {
                heat.pass(&Passed { dt_s: 0.0, ..DARK });
            }
            whole.pass(&Passed { dt_s: periods as f64 * PERIOD_S, ..DARK });
            for _ in 0..periods {
                cut.pass(&DARK);
            }
            prop_assert!((whole.temperature_c() - cut.temperature_c()).abs() < 1.0, "{whole:?} {cut:?}");
        }
    }
}
