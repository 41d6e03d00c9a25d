//! Detects faults of the output stage: does it follow its gate?
//!
//! A transistor mostly fails closed: it heats its wire at full power whatever its duty, and the on-phase, in
//! which everything is measured, looks normal. Only the off-phase shows the fault.
//!
//! - Where supply and current share an input, the off-phase is sampled in every period: if the input reads the same in both
//!   phases the switch has no effect, conducting (a current) or not (the supply).
//! - With separate inputs it takes a *dark* period, one with duty 0, to detect it. A dark period costs a length sample, so it is
//!   inserted only on suspicion: the channel gets only the sensing pulse, and the wire shortens nevertheless,
//!   or it is not at its cold end and does not lengthen, or has no time to show that; or its duty is derated and it stays hot. Suspicion
//!   alone trips nothing (the wire may have been pulled): a current in the dark period does, see [`crate::supervisor`].
//!
//! A stage that conducts badly shows as a voltage drop beyond that of the wire and the known resistances.

use sinew_ipc::Fault;
use sinew_sensing::{Circuit, Health, LengthSensor, Motion, Reading, Sample};

/// More than this share of the nominal supply left in stage and leads, beyond what their resistances take, is a weak stage.
const WEAK: f64 = 0.25;
/// More than this share of the nominal supply is too much.
const HIGH: f64 = 1.25;
/// A shared input that shows the same in both phases, to this share of what it shows and this many standard deviations.
const SAME: f64 = 0.1;
const GUARD: f64 = 8.0;
/// The load's swing is over so long after the heat has gone, s.
const SWING_S: f64 = 0.02;
/// Share of the time in which full power heats a wire beyond its limit that may go by before it is looked at: a suspicion costs a sample.
const PATIENCE: f64 = 0.25;
/// Between two looks at where the wire has gone, s.
const LOOK_S: f64 = 0.05;
/// Longest between two dark periods of a wire that stands where it is not cold, s: each one that shows nothing doubles it.
const LONGEST_S: f64 = 1.0;
/// Between two dark periods while the duty is derated, s. Both are shorter where full power heats the wire beyond its limit in less.
const DERATED_S: f64 = 0.1;
/// Share of the stroke that is motion, and not noise or the load's swing.
const MOVED: f64 = 0.01;
/// Within this share of the stroke from the cold end the wire has nowhere to lengthen to.
const COLD_END: f64 = 0.15;
/// Fewest periods between two dark ones: on a slow loop they must not take the length away. With the one in which the stage is seen, the one
/// that confirms it and the one in which the supply goes, fewer than 20.
const FEWEST_PERIODS: f64 = 16.0;
/// Fewest periods in which a wire is watched before it is said to stand.
const WATCHED_PERIODS: f64 = 4.0;

/// Watches the output stage of one channel.
#[derive(Debug, Clone)]
pub struct StageWatch {
    nominal_v: f64,
    /// Everything between supply and wire that is known, Ω.
    series_ohm: f64,
    /// Switch and shunt below a shared input, Ω.
    low_ohm: Option<f64>,
    /// What counts as a current, A, and what no wire of this kind carries.
    least_a: f64,
    most_a: f64,
    sigma_v: f64,
    /// The end of the converter's range, V.
    full_v: f64,
    /// Whether the converter's noise changes its codes: then codes that repeat are a frozen converter's.
    noise_tells: bool,
    last: Sample,
    cold_m: f64,
    stroke_m: f64,
    /// How long no more than the sensing pulse was given, s, and since the last look.
    low_s: f64,
    since_look_s: f64,
    look_every_s: f64,
    /// Where the wire was then.
    looked_m: f64,
    /// Since the last dark period, s, whatever was asked for meanwhile: orders by turns hide no stage.
    since_dark_s: f64,
    /// How long it was derated since the last dark period, s, and how long ago.
    derated_s: f64,
    since_derated_s: f64,
}

impl StageWatch {
    /// A watch of the stage before a wire that is measured so. `most_a` is the largest current it may carry.
    pub fn new(
        sensor: &LengthSensor,
        nominal_v: f64,
        series_ohm: f64,
        most_a: f64,
        stroke: &sinew_control::StrokeRange,
    ) -> StageWatch {
        let config = sensor.config();
        StageWatch {
            nominal_v,
            series_ohm,
            low_ohm: match config.circuit {
                Circuit::Separate => None,
                Circuit::Shared { low_ohm, .. } => Some(low_ohm),
            },
            least_a: config.min_current_a,
            most_a,
            sigma_v: config.converter.voltage_sigma_v(),
            full_v: 0.999 * config.converter.voltage_range_v,
            noise_tells: sensor.stuck_after().all.is_some(),
            last: Sample::NONE,
            cold_m: stroke.cold_m,
            stroke_m: stroke.stroke_m().abs(),
            low_s: 0.0,
            since_look_s: 0.0,
            look_every_s: LOOK_S,
            looked_m: f64::NAN,
            since_dark_s: f64::INFINITY,
            derated_s: 0.0,
            since_derated_s: f64::INFINITY,
        }
    }

    /// What a sample shows of the stage, `driven` or in the dark. NaN shows nothing.
    #[inline]
    pub fn fault(&mut self, sample: &Sample, reading: &Reading, driven: bool) -> Option<Fault> {
        // A frozen converter repeats the on-phase's current in the dark period: no evidence about the stage.
        let before = std::mem::replace(&mut self.last, *sample);
        let same = before.v3_v == sample.v3_v && before.current_a == sample.current_a;
        if !driven && same && self.noise_tells {
            return None;
        }
        let Sample { v3_v, current_a, supply_v, .. } = *sample;
        if let Some(low_ohm) = self.low_ohm {
            return self.fault_of_shared(current_a * low_ohm, supply_v, low_ohm, driven);
        }
        if !driven {
            // More than the wire can carry is a converter fault, no evidence about the stage.
            return (current_a > self.least_a && current_a < self.most_a).then_some(Fault::StageOn);
        }
        // A V3 above the supply is a converter fault.
        if supply_v > HIGH * self.nominal_v && v3_v < supply_v {
            return Some(Fault::SupplyHigh);
        }
        let lost_v = supply_v - v3_v - current_a * self.series_ohm;
        let weak = reading.health == Health::Ok && lost_v > WEAK * self.nominal_v;
        weak.then_some(Fault::StageWeak)
    }

    #[inline]
    fn fault_of_shared(&self, on_v: f64, off_v: f64, low_ohm: f64, driven: bool) -> Option<Fault> {
        let off_a = off_v / low_ohm;
        let carries = off_a > self.least_a && off_a < self.most_a;
        if !driven {
            return carries.then_some(Fault::StageOn);
        }
        let same = (on_v - off_v).abs() < SAME * off_v + GUARD * self.sigma_v;
        if same && carries {
            return Some(Fault::StageOn);
        }
        if off_v > self.full_v {
            return None;
        }
        // A floating input shows the same in both phases as well, but not the supply.
        if same && off_v > 0.75 * self.nominal_v {
            return Some(Fault::StageWeak);
        }
        (off_v > HIGH * self.nominal_v).then_some(Fault::SupplyHigh)
    }

    /// Whether the next period is to be dark. `low`: no more than the sensing pulse is asked for; `derated`: the supervisor holds
    /// the duty down. `spare_s`: how long a stage that conducts takes to heat the wire beyond its limit.
    #[inline]
    pub fn wants_dark(&mut self, low: bool, derated: bool, spare_s: f64, motion: &Motion, dt_s: f64) -> bool {
        if self.low_ohm.is_some() {
            return false;
        }
        self.since_dark_s += dt_s;
        // One dark period: if it shows a current the supervisor keeps the gate closed for a second one.
        let wants = self.derated_too_long(derated, spare_s, dt_s) | self.moves_unasked(low, spare_s, motion, dt_s);
        if wants {
            self.since_dark_s = 0.0;
        }
        wants
    }

    /// The wire has been derated for a while: if that does not help, the stage may be the reason. One that is told to relax from there is as
    /// hot until the swing is over and its motion tells.
    #[inline]
    fn derated_too_long(&mut self, derated: bool, spare_s: f64, dt_s: f64) -> bool {
        self.since_derated_s = if derated { 0.0 } else { self.since_derated_s + dt_s };
        self.derated_s = if self.since_derated_s <= SWING_S { self.derated_s + dt_s } else { 0.0 };
        let too_long = self.derated_s > DERATED_S.min(spare_s).max(FEWEST_PERIODS * dt_s);
        if too_long {
            self.derated_s = 0.0;
        }
        too_long
    }

    /// The wire moves as only heat can move it, or stays where only heat can hold it, and none was asked for.
    #[inline]
    fn moves_unasked(&mut self, low: bool, spare_s: f64, motion: &Motion, dt_s: f64) -> bool {
        if !low {
            (self.low_s, self.looked_m) = (0.0, f64::NAN);
            return false;
        }
        self.low_s += dt_s;
        let patience_s = PATIENCE * spare_s;
        if self.low_s < SWING_S.min(patience_s) {
            return false;
        }
        let length_m = motion.length_m;
        if self.looked_m.is_nan() {
            (self.looked_m, self.since_look_s) = (length_m, 0.0);
            self.look_every_s = LOOK_S.min(patience_s);
        }
        self.since_look_s += dt_s;
        if self.since_dark_s < FEWEST_PERIODS * dt_s {
            return false;
        }
        let is_cold = length_m >= self.cold_m - COLD_END * self.stroke_m;
        // Without time there is no seeing where it goes (nor where that is not known); and a wire that is much too hot lengthens as well, by expansion.
        let has_time = spare_s >= FEWEST_PERIODS * dt_s;
        if !has_time && !is_cold {
            return true;
        }
        let moved_m = length_m - self.looked_m;
        let shortens = moved_m < -MOVED * self.stroke_m;
        if shortens && self.since_look_s > FEWEST_PERIODS * dt_s {
            (self.looked_m, self.since_look_s) = (length_m, 0.0);
            return true;
        }
        if self.since_look_s < self.look_every_s.min(spare_s).max(WATCHED_PERIODS * dt_s) {
            return false;
        }
        (self.looked_m, self.since_look_s) = (length_m, 0.0);
        let held = !is_cold && moved_m < MOVED * self.stroke_m;
        if held {
            self.look_every_s = (2.0 * self.look_every_s).min(LONGEST_S);
        }
        held
    }
}
