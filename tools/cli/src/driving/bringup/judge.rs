//! What readings say of the board: pure functions of what the rig file lets expect and of what was seen.

use sinew_control::StrokeRange;
use sinew_ipc::Fault;
use sinew_physics::Wire;
use sinew_physics::formulas::resistance_ohm;
use sinew_rig::{Channel, Correction, Rig};

use super::causes::Cause;
use super::look::{Five, Reading, Seen};

/// What two resistors of a divider, a shunt, a reference and an amplifier of one per cent each may come to; beyond it something has
/// another value than was meant.
const GAIN: f64 = 0.05;
/// What an input may show of nothing, as a share of what it shows with the supply on the wire.
const OFFSET: f64 = 0.01;
/// A reading is none below this share of what is expected, and is expected's own above that.
const NONE: f64 = 0.02;
const SOME: f64 = 0.5;
/// Share of a range at which a reading is at its end.
const FULL: f64 = 0.97;
/// Two clips at one terminal differ by no more once their inputs are corrected.
const CLIP: f64 = 0.1;
/// A first tap's share of the second's voltage errs by no more.
const SHARE: f64 = 0.02;
/// Standard deviations that a tolerance is made of: of what is soldered, and of a wire, whose alloy varies.
const SURE: f64 = 3.0;
const WIRE: f64 = 2.0;
/// Scatter of an input that touches nothing, in what its converter has by itself.
const RESTLESS: f64 = 10.0;

/// A number that was wanted, and one that was seen.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What it is.
    pub what: String,
    /// What was expected, and by how much it may differ.
    pub wanted: f64,
    /// The same unit.
    pub tolerance: f64,
    /// What was seen.
    pub seen: f64,
    /// Its unit.
    pub unit: &'static str,
}

impl Check {
    fn new(what: impl Into<String>, wanted: f64, tolerance: f64, seen: f64, unit: &'static str) -> Check {
        Check { what: what.into(), wanted, tolerance, seen, unit }
    }

    /// Whether it is as it should be.
    pub fn is_good(&self) -> bool {
        (self.seen - self.wanted).abs() <= self.tolerance
    }
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The channel, by its place; `None` = the whole board.
    pub channel: Option<usize>,
    /// What it is called.
    pub cause: Cause,
    /// What shows it.
    pub saw: String,
}

impl Finding {
    pub fn new(channel: impl Into<Option<usize>>, cause: Cause, saw: impl Into<String>) -> Finding {
        Finding { channel: channel.into(), cause, saw: saw.into() }
    }
}

/// What a look has come to.
#[derive(Debug, Clone, Default)]
pub struct Verdict {
    /// The numbers.
    pub checks: Vec<Check>,
    /// What is wrong; the first is the one to mend first.
    pub findings: Vec<Finding>,
    /// Gains and offsets on top of those in force, where a meter's value was there.
    pub corrections: Option<Five<Correction>>,
}

impl Verdict {
    /// Whether nothing is wrong.
    pub fn is_good(&self) -> bool {
        self.findings.is_empty()
    }

    /// That nothing was sampled, where that is so.
    fn misses(&mut self, expected: &Expected, seen: &Seen) -> bool {
        if !seen.is_seen() {
            let fault = seen
                .fault
                .map_or("no fault".into(), |fault| format!("{}: {}; {}", fault.flag(), fault.cause(), fault.remedy()));
            self.find(expected.place, Cause::Unseen, fault);
        }
        !seen.is_seen()
    }

    fn find(&mut self, channel: impl Into<Option<usize>>, cause: Cause, saw: impl Into<String>) {
        self.findings.push(Finding::new(channel, cause, saw));
    }
}

/// What the rig file lets expect of a channel.
#[derive(Debug, Clone)]
pub struct Expected {
    pub name: String,
    place: usize,
    pub supply_v: f64,
    supply_sigma_v: f64,
    shunt_ohm: f64,
    series_ohm: f64,
    series_sigma_ohm: f64,
    /// Stage and leads: what of it lies between supply and the moving end while a shunt is bridged.
    above_ohm: f64,
    pub cold_ohm: f64,
    cold_sigma_ohm: f64,
    cold_m: f64,
    cold_sigma_m: f64,
    diameter_m: f64,
    /// l0 and ls, m.
    taps: Option<(f64, f64)>,
    voltage_noise_v: f64,
    current_range_a: f64,
}

impl Expected {
    /// # Errors
    /// Why the physics does not accept the wire.
    pub fn of(rig: &Rig, place: usize) -> Result<Expected, sinew_physics::Error> {
        let channel = &rig.channels[place];
        let model = &rig.nominal_model(place);
        let (drive, stroke) = (&model.drive, StrokeRange::of(model)?);
        let sigma = |key: &str| sigma(channel, key);
        let length_m = model.geometry.length_m;
        let least = resistance_ohm(model.material.least_resistivity(), length_m, model.geometry.area_m2());
        let cold_ohm = Wire::new(model)?.resistance_ohm().max(least);
        // Relative variances of ρ L / A.
        let relative = |key: &str| sigma(key) / channel.parameter(key).unwrap_or(1.0).abs().max(f64::MIN_POSITIVE);
        let alloy = relative("martensite_resistivity_uohm_cm");
        let (long, thick) = (relative("length_mm"), 2.0 * relative("diameter_mm"));
        let strain = relative("transformation_strain") * (stroke.stroke_m() / stroke.cold_m);
        let apart = relative("ls_mm");
        Ok(Expected {
            current_range_a: channel.adc.current_range_a,
            name: channel.name.clone(),
            place,
            supply_v: drive.supply_v,
            supply_sigma_v: sigma("supply_v"),
            shunt_ohm: drive.shunt_ohm,
            series_ohm: model.outside_ohm(),
            series_sigma_ohm: sigma("shunt_ohm").hypot(sigma("switch_ohm")),
            above_ohm: (model.outside_ohm() - drive.shunt_ohm).max(0.0),
            cold_ohm,
            cold_sigma_ohm: cold_ohm * alloy.hypot(long).hypot(thick),
            cold_m: stroke.cold_m,
            cold_sigma_m: stroke.cold_m * long.hypot(strain).hypot(apart),
            diameter_m: model.geometry.diameter_m,
            taps: model.taps.map(|taps| (taps.l0_m, taps.ls_m)),
            voltage_noise_v: channel.adc.voltage_noise_v.max(channel.adc.voltage_range_v / f64::from(1u32 << 16)),
        })
    }

    /// The voltage leads there are, with their readings.
    fn leads(&self, read: &Five<Reading>) -> Vec<(&'static str, Reading)> {
        let taps = self.taps.map(|_| [("V1", read.v1), ("V2", read.v2)]);
        taps.into_iter().flatten().chain([("V3", read.v3)]).collect()
    }

    /// Where it conducts in the dark, as only a stage does that is stuck on; voltages of inputs that touch nothing are restless.
    pub fn conducts(&self, dark: &Seen) -> bool {
        let v3 = &dark.read.v3;
        let stands = v3.mean > SOME * self.supply_v && !self.is_restless(v3);
        stands || dark.fault == Some(Fault::StageOn) || dark.read.current.mean > SOME * self.supply_v / self.cold_ohm
    }

    fn is_restless(&self, reading: &Reading) -> bool {
        reading.sigma > RESTLESS * self.voltage_noise_v && reading.sigma > NONE * self.supply_v
    }
}

/// One standard deviation of a parameter by the priors in force, in the unit of its key; 0 where there is none.
fn sigma(channel: &Channel, key: &str) -> f64 {
    let value = channel.parameter(key).unwrap_or(0.0);
    channel.priors_in_force().get(key).map_or(0.0, |prior| prior.sigma(value))
}

/// The supply, with nothing put out and nothing connected; `meter_v` as a meter has it.
pub fn supply(board: &[Expected], dark: &[Seen], meter_v: Option<f64>, accepts: bool) -> Verdict {
    let mut verdict = Verdict::default();
    for (expected, seen) in board.iter().zip(dark) {
        if expected.conducts(seen) {
            let (v3, amps) = (seen.read.v3.mean, seen.read.current.mean);
            verdict.find(expected.place, Cause::StageOn, format!("duty 0, and V3 {v3:.2} V, {amps:.3} A"));
        }
    }
    if !verdict.is_good() {
        return verdict;
    }
    for (expected, seen) in board.iter().zip(dark) {
        let (wanted, read) = (expected.supply_v, seen.read.supply.mean);
        let set = SURE * expected.supply_sigma_v;
        if read.is_nan() && meter_v.is_none() {
            continue;
        }
        let tolerance = if meter_v.is_some() { set } else { set + GAIN * wanted };
        let said = meter_v.unwrap_or(read);
        let by = if meter_v.is_some() { "supply by the meter" } else { "supply" };
        let check = Check::new(by, wanted, tolerance, said, "V");
        let level = match () {
            () if said.abs() < NONE * wanted => Some(Cause::SupplyOff),
            () if check.is_good() => None,
            () if said < wanted => Some(Cause::SupplyLow),
            () => Some(Cause::SupplyHigh),
        };
        let is_told = verdict.checks.iter().any(|told| told.what == check.what && told.seen == check.seen);
        if !is_told {
            if let Some(cause) = level {
                verdict.find(None, cause, format!("{said:.3} V where the rig file has {wanted:.3} ± {tolerance:.3} V"));
            }
            verdict.checks.push(check);
        }
        if let Some(meter_v) = meter_v.filter(|_| read.is_finite()) {
            let check = Check::new(format!("{}: supply as read", expected.name), meter_v, GAIN * meter_v, read, "V");
            if read < NONE * meter_v && meter_v > NONE * wanted {
                let saw = format!("the meter has {meter_v:.3} V, the input {read:.3} V");
                if !verdict.findings.iter().any(|finding| finding.cause == Cause::SupplySense) {
                    verdict.find(None, Cause::SupplySense, saw);
                }
            } else if !check.is_good() && level.is_none() && !accepts {
                verdict.find(
                    expected.place,
                    Cause::Gain,
                    format!("the supply reads {read:.3} V where the meter has {meter_v:.3} V"),
                );
            }
            verdict.checks.push(check);
        }
    }
    verdict
}

/// Every stage under the sensing pulse with nothing connected and every clip at the moving end: all of it has to stand there.
pub fn stages(board: &[Expected], dark: &[Seen], lit: &[Seen], supply_v: f64, has_switch: bool) -> Verdict {
    let mut verdict = Verdict::default();
    if board.iter().zip(lit).any(|(expected, seen)| verdict.misses(expected, seen)) {
        return verdict;
    }
    let stands = |(expected, seen): (&Expected, &Seen)| {
        expected.leads(&seen.read).iter().any(|(_, lead)| lead.mean > SOME * supply_v)
    };
    let lit_none = !board.iter().zip(lit).any(stands);
    if lit_none && (has_switch || board.len() > 1) {
        verdict.find(
            None,
            Cause::NoSupplyAtStages,
            format!("every terminal stays at 0 V of {supply_v:.2} V under its pulse"),
        );
        return verdict;
    }
    for ((expected, seen), dark) in board.iter().zip(lit).zip(dark) {
        if !stands((expected, seen)) {
            let v3 = seen.read.v3.mean;
            verdict.find(expected.place, Cause::StageDead, format!("V3 {v3:.3} V of {supply_v:.2} V under its pulse"));
            continue;
        }
        for ((lead, reading), (_, dark)) in expected.leads(&seen.read).into_iter().zip(expected.leads(&dark.read)) {
            let check = Check::new(format!("{}: {lead}", expected.name), supply_v, GAIN * supply_v, reading.mean, "V");
            if expected.is_restless(&dark) || reading.mean < NONE * supply_v || reading.mean.is_nan() {
                let saw = format!("{lead} shows {:.2} V in the dark, {:.2} V under the pulse", dark.mean, reading.mean);
                verdict.find(expected.place, Cause::TapMissing, saw);
            }
            verdict.checks.push(check);
        }
    }
    verdict
}

/// What a resistor at a channel's terminals shows, every clip at the moving end.
pub struct Dummy<'a> {
    pub expected: &'a Expected,
    /// Of the channel alone, with nothing put out.
    pub dark: &'a Seen,
    /// Of the stage with nothing connected, where that was looked at.
    pub open: Option<&'a Seen>,
    /// Under the sensing pulse.
    pub lit: &'a Seen,
    /// By the meter where there is one, else as read.
    pub supply_v: f64,
    /// Whether that is a meter's.
    pub is_metered: bool,
    /// By the meter.
    pub ohm: f64,
    /// Whether gains and offsets beyond a divider's tolerance are meant.
    pub accepts: bool,
}

/// How a resistor's look came out, before it is judged in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shows {
    /// The resistor, or at least a voltage that it loads.
    Load,
    /// Voltage and no current.
    Open,
    /// Nothing at all.
    Nothing,
}

impl Dummy<'_> {
    /// What it shows at all.
    pub fn shows(&self) -> Shows {
        shows(self.expected, self.lit, self.supply_v, self.ohm)
    }

    /// In numbers.
    pub fn judge(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let Dummy { expected, dark, lit, supply_v, ohm, .. } = *self;
        let place = expected.place;
        if verdict.misses(expected, lit) {
            return verdict;
        }
        if expected.conducts(dark) {
            let saw = format!("duty 0, and V3 {:.2} V, {:.3} A", dark.read.v3.mean, dark.read.current.mean);
            verdict.find(place, Cause::StageOn, saw);
            return verdict;
        }
        let full_a = supply_v / (ohm + expected.series_ohm);
        let corrected = |reading: &Reading, open: Option<&Reading>, dark: &Reading| {
            let top = open.map_or(supply_v, |open| open.mean);
            let gain = if open.is_some() { supply_v / (top - dark.mean) } else { 1.0 };
            gain * (reading.mean - dark.mean)
        };
        let v3 = corrected(&lit.read.v3, self.open.map(|open| &open.read.v3), &dark.read.v3);
        self.clips(&mut verdict);
        let amps = lit.read.current.mean - dark.read.current.beyond_scatter();
        if amps < NONE * full_a {
            let fallen_v = self.open.map_or(supply_v, |open| open.read.v3.mean) - lit.read.v3.mean;
            let flows_v = SOME * expected.above_ohm * full_a;
            let is_seen = flows_v > 5.0 * expected.voltage_noise_v;
            let cause = if self.open.is_some() && is_seen && fallen_v > flows_v {
                Cause::CurrentUnseen
            } else {
                Cause::LeadOpen
            };
            verdict.find(
                place,
                cause,
                format!("V3 {:.3} V ({:.0} mV below the open terminal), {amps:.4} A", v3, fallen_v * 1e3),
            );
            return verdict;
        }
        let true_a = v3 / ohm;
        let seen_ohm = (supply_v - v3) / true_a;
        let tolerance_ohm =
            SURE * expected.series_sigma_ohm + SURE * 0.004 * ohm + if self.is_metered { 0.0 } else { GAIN * ohm };
        let ratio = amps / true_a;
        // a shunt of another value is in the circuit, too
        let is_other = (ratio - 1.0).abs() > GAIN;
        let series_ohm = expected.series_ohm + if is_other { expected.shunt_ohm * (ratio - 1.0) } else { 0.0 };
        let series = Check::new("stage, shunt and leads", series_ohm, tolerance_ohm, seen_ohm, "Ω");
        let wanted_v = full_a * ohm;
        let share = wanted_v * (tolerance_ohm / (ohm + expected.series_ohm));
        verdict.checks.push(Check::new("V3 over the resistor", wanted_v, share, v3, "V"));
        verdict.checks.push(Check::new("current", true_a, GAIN * true_a, amps, "A"));
        if !series.is_good() && seen_ohm > series_ohm {
            let saw =
                format!("{seen_ohm:.2} Ω where the rig file has {:.2} ± {tolerance_ohm:.2} Ω", expected.series_ohm);
            verdict.find(place, Cause::StageWeak, saw);
        }
        verdict.checks.push(series);
        if is_other && !self.accepts {
            let is_as = expected.shunt_ohm * ratio;
            let saw = format!(
                "{amps:.4} A where {v3:.3} V over {ohm} Ω make {true_a:.4} A: as if the shunt had {is_as:.3} Ω and not {:.3} Ω",
                expected.shunt_ohm
            );
            verdict.find(place, Cause::ShuntValue, saw);
        }
        self.zeros(&mut verdict, full_a);
        if verdict.is_good() {
            verdict.corrections = self.corrections(ratio);
        }
        verdict
    }

    /// Clips that touch nothing, and inputs that read wrongly.
    fn clips(&self, verdict: &mut Verdict) {
        let Dummy { expected, dark, lit, .. } = *self;
        let reference = self.open.unwrap_or(lit);
        let wanted = if self.open.is_some() {
            self.supply_v
        } else {
            self.supply_v * self.ohm / (self.ohm + expected.series_ohm)
        };
        let leads = expected.leads(&reference.read).into_iter().zip(expected.leads(&dark.read));
        for ((lead, reading), (_, dark)) in leads {
            let seen = reading.mean - dark.mean;
            let ratio = seen / wanted;
            if expected.is_restless(&dark) || ratio.abs() < CLIP || reading.mean.is_nan() {
                let saw = format!("{lead} shows {:.2} V in the dark, {:.2} V under the pulse", dark.mean, reading.mean);
                verdict.find(expected.place, Cause::TapMissing, saw);
            } else if (ratio - 1.0).abs() > GAIN && !self.accepts {
                let saw = format!("{lead} reads {seen:.3} V where there are {wanted:.3} V");
                verdict.find(expected.place, Cause::Gain, saw);
            }
        }
    }

    /// Inputs that show something of nothing: the resistor holds every clip at ground.
    fn zeros(&self, verdict: &mut Verdict, full_a: f64) {
        let Dummy { expected, dark, supply_v, .. } = *self;
        let leads = expected.leads(&dark.read).into_iter().map(|(lead, zero)| (lead, zero, OFFSET * supply_v, "V"));
        for (lead, zero, most, unit) in leads.chain([("current", dark.read.current, OFFSET * full_a, "A")]) {
            if zero.mean.abs() > most && !expected.is_restless(&zero) && !self.accepts {
                let saw = format!(
                    "{lead} shows {:.4} {unit} with the stage off; up to {most:.4} {unit} are corrected",
                    zero.mean
                );
                verdict.find(expected.place, Cause::Offset, saw);
            }
            verdict.checks.push(Check::new(format!("zero of {lead}"), 0.0, most, zero.mean, unit));
        }
    }

    /// Gains and offsets that make of what is read what a meter has; none without a meter.
    fn corrections(&self, ratio: f64) -> Option<Five<Correction>> {
        let open = self.open.filter(|_| self.is_metered)?;
        let (dark, supply_v) = (&self.dark.read, self.supply_v);
        let of = |top: &Reading, zero: &Reading| {
            let zero_v = zero.beyond_scatter();
            let gain = supply_v / (top.mean - zero_v);
            match gain.is_finite() {
                true => Correction { gain, offset: -gain * zero_v },
                false => Correction::NONE,
            }
        };
        let current = 1.0 / ratio;
        let supply = supply_v / self.dark.read.supply.mean;
        Some(Five {
            v1: of(&open.read.v1, &dark.v1),
            v2: of(&open.read.v2, &dark.v2),
            v3: of(&open.read.v3, &dark.v3),
            current: Correction { gain: current, offset: -current * dark.current.beyond_scatter() },
            // its zero cannot be seen: the supply stands
            supply: if supply.is_finite() { Correction { gain: supply, offset: 0.0 } } else { Correction::NONE },
        })
    }
}

/// What a channel shows of a resistor at all.
pub fn shows(expected: &Expected, lit: &Seen, supply_v: f64, ohm: f64) -> Shows {
    shows_by(expected, lit, supply_v, ohm, |reading| reading.mean, true)
}

/// Whether it has shown a resistor at any time: one that is seen only while another channel is on as well.
pub fn has_shown(expected: &Expected, lit: &Seen, supply_v: f64, ohm: f64) -> bool {
    // it comes and goes with the other channel's pulse: that is no input that touches nothing
    shows_by(expected, lit, supply_v, ohm, |reading| reading.most, false) == Shows::Load
}

fn shows_by(
    expected: &Expected,
    lit: &Seen,
    supply_v: f64,
    ohm: f64,
    of: fn(&Reading) -> f64,
    is_steady: bool,
) -> Shows {
    let full_a = supply_v / (ohm + expected.series_ohm);
    let volts = expected.leads(&lit.read).into_iter().map(|(_, lead)| lead);
    let stands = volts.filter(|lead| !is_steady || !expected.is_restless(lead)).any(|lead| of(&lead) > CLIP * supply_v);
    match () {
        () if of(&lit.read.current) > CLIP * full_a && stands => Shows::Load,
        () if stands => Shows::Open,
        () => Shows::Nothing,
    }
}

/// A wire under the sensing pulse, its taps in their places; readings as corrected.
pub fn wire(expected: &Expected, dark: &Seen, lit: &Seen, supply_v: f64) -> Verdict {
    let mut verdict = Verdict::default();
    let place = expected.place;
    if expected.conducts(dark) {
        let saw = format!("duty 0, and V3 {:.2} V, {:.3} A", dark.read.v3.mean, dark.read.current.mean);
        verdict.find(place, Cause::StageOn, saw);
        return verdict;
    }
    let (v1, v2, v3, amps) = (lit.read.v1, lit.read.v2, lit.read.v3, lit.read.current.mean);
    if verdict.misses(expected, lit) {
        return verdict;
    }
    for (lead, reading) in expected.leads(&lit.read) {
        if expected.is_restless(&reading) {
            let saw = format!("{lead} wanders: {:.2} V ± {:.2} V", reading.mean, reading.sigma);
            verdict.find(place, Cause::TapMissing, saw);
        }
    }
    if !verdict.is_good() {
        return verdict;
    }
    let full_a = supply_v / (expected.cold_ohm + expected.series_ohm);
    if amps < NONE * full_a {
        let (cause, saw) = match v3.mean > SOME * supply_v {
            true => (Cause::WireOpen, format!("V3 {:.3} V, {amps:.4} A", v3.mean)),
            false => (Cause::StageDead, format!("V3 {:.3} V, {amps:.4} A under the pulse", v3.mean)),
        };
        verdict.find(place, cause, saw);
        return verdict;
    }
    let mut end_v = v3.mean;
    if expected.taps.is_some() && v2.mean > v3.mean + SHARE * supply_v {
        verdict.find(place, Cause::TapEndExchanged, format!("V2 {:.3} V is above V3 {:.3} V", v2.mean, v3.mean));
        end_v = v2.mean;
    } else if let Some((l0_m, ls_m)) = expected.taps {
        let share = l0_m / (l0_m + ls_m);
        if v1.mean > v2.mean {
            verdict.find(place, Cause::TapsExchanged, format!("V1 {:.3} V is above V2 {:.3} V", v1.mean, v2.mean));
        } else if v2.mean < NONE * supply_v {
            verdict.find(place, Cause::TapMissing, format!("V2 shows {:.3} V of {:.3} V", v2.mean, v3.mean));
        } else {
            let wanted_v = share * v2.mean;
            let first = Check::new("V1", wanted_v, SHARE * v3.mean, v1.mean, "V");
            let length_m = l0_m + ls_m * (v3.mean - v1.mean) / (v2.mean - v1.mean);
            let tolerance_m = WIRE * expected.cold_sigma_m;
            let length = Check::new("length", expected.cold_m * 1e3, tolerance_m * 1e3, length_m * 1e3, "mm");
            if !first.is_good() {
                let saw = format!("V1 {:.3} V where the first tap's share of V2 is {wanted_v:.3} V", v1.mean);
                verdict.find(place, Cause::TapMissing, saw);
            } else if !length.is_good() {
                let saw = format!(
                    "{:.2} mm where {:.2} ± {:.2} mm were expected",
                    length.seen, length.wanted, length.tolerance
                );
                verdict.find(place, Cause::TapsApart, saw);
            }
            verdict.checks.extend([first, length]);
        }
    }
    // a current at the end of its range is more than that: the stage and its leads tell how much
    let is_full = amps > FULL * expected.current_range_a && expected.series_ohm > 0.0;
    let ohm = if is_full { expected.series_ohm * end_v / (supply_v - end_v).max(0.0) } else { end_v / amps };
    let check = Check::new("resistance", expected.cold_ohm, WIRE * expected.cold_sigma_ohm, ohm, "Ω");
    if ohm < SOME * expected.cold_ohm {
        verdict
            .findings
            .insert(0, Finding::new(place, Cause::WireBridged, format!("{ohm:.2} Ω of {:.2} Ω", expected.cold_ohm)));
    } else if !check.is_good() {
        let as_thick = expected.diameter_m * (expected.cold_ohm / ohm).sqrt() * 1e3;
        let saw = format!(
            "{ohm:.2} Ω where {:.2} ± {:.2} Ω were expected: as if it were {as_thick:.3} mm thick",
            check.wanted, check.tolerance
        );
        verdict.find(place, Cause::WrongWire, saw);
    }
    verdict.checks.insert(0, check);
    verdict
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board() -> Vec<Expected> {
        let rig = Rig::hexapod();
        (0..2).map(|place| Expected::of(&rig, place).unwrap()).collect()
    }

    fn reading(mean: f64) -> Reading {
        Reading { mean, sigma: 1e-3, most: mean, count: 40 }
    }

    fn seen(v1: f64, v2: f64, v3: f64, current: f64, supply: f64) -> Seen {
        let read = Five {
            v1: reading(v1),
            v2: reading(v2),
            v3: reading(v3),
            current: reading(current),
            supply: reading(supply),
        };
        Seen { read, fault: None }
    }

    #[test]
    fn corrections_make_of_what_is_read_what_the_meter_has() {
        let board = board();
        let expected = &board[0];
        let (supply_v, ohm) = (expected.supply_v, 12.0);
        let true_a = supply_v / (ohm + expected.series_ohm);
        // V3 reads 2 % too much and 20 mV more, the current 3 % too little and 3 mA less.
        let v3 = |volts: f64| 1.02 * volts + 0.02;
        let amps = |amps: f64| 0.97 * amps - 0.003;
        let show = |volts: f64, a: f64| seen(volts, 0.99 * volts, v3(volts), amps(a), 1.01 * supply_v);
        let (dark, open, lit) = (show(0.0, 0.0), show(supply_v, 0.0), show(true_a * ohm, true_a));
        let dummy = Dummy {
            expected,
            dark: &dark,
            open: Some(&open),
            lit: &lit,
            supply_v,
            is_metered: true,
            ohm,
            accepts: false,
        };
        assert_eq!(dummy.shows(), Shows::Load);
        let verdict = dummy.judge();
        assert!(verdict.is_good(), "{:?}", verdict.findings);
        let five = verdict.corrections.expect("both meters' values are there");
        for volts in [0.0, 3.0, supply_v] {
            assert!((five.v3.apply(v3(volts)) - volts).abs() < 1e-9);
            assert!((five.v2.apply(0.99 * volts) - volts).abs() < 1e-9);
        }
        for a in [0.0, 0.2, true_a] {
            assert!((five.current.apply(amps(a)) - a).abs() < 1e-9);
        }
        assert!((five.supply.apply(1.01 * supply_v) - supply_v).abs() < 1e-9);
        let unmetered = Dummy { is_metered: false, ..dummy };
        assert!(unmetered.judge().corrections.is_none(), "what was not measured corrects nothing");
    }

    #[test]
    fn the_tolerance_of_a_wire_is_that_of_its_priors() {
        let expected = &board()[0];
        let length = expected.cold_m;
        let (l0_m, ls_m) = expected.taps.expect("the hexapod has taps");
        let look = |ohm: f64, length_m: f64| {
            let amps = expected.supply_v / (expected.series_ohm + ohm);
            let per_m = amps * ohm / length_m;
            seen(per_m * l0_m, per_m * (l0_m + ls_m), amps * ohm, amps, expected.supply_v)
        };
        let dark = seen(0.0, 0.0, 0.0, 0.0, expected.supply_v);
        let judge = |ohm: f64, length_m: f64| {
            let verdict = wire(expected, &dark, &look(ohm, length_m), expected.supply_v);
            verdict.findings.first().map(|finding| finding.cause)
        };
        assert_eq!(judge(expected.cold_ohm, length), None);
        assert_eq!(judge(expected.cold_ohm + 1.9 * expected.cold_sigma_ohm, length), None);
        assert_eq!(judge(expected.cold_ohm + 2.1 * expected.cold_sigma_ohm, length), Some(Cause::WrongWire));
        assert_eq!(judge(0.2 * expected.cold_ohm, length), Some(Cause::WireBridged));
        assert_eq!(judge(expected.cold_ohm, length + 1.9 * expected.cold_sigma_m), None);
        assert_eq!(judge(expected.cold_ohm, length - 2.1 * expected.cold_sigma_m), Some(Cause::TapsApart));
    }

    #[test]
    fn an_input_that_touches_nothing_is_no_stage_that_conducts() {
        let expected = &board()[0];
        let mut dark = seen(0.0, 0.0, 0.7 * expected.supply_v, 0.0, expected.supply_v);
        assert!(expected.conducts(&dark));
        dark.read.v3.sigma = 0.5;
        assert!(!expected.conducts(&dark));
    }
}
