//! The data the screen shows, independent of their source: filled from a client of the driver, or by hand in tests.

use sinew_driver::report::Quantiles;
use sinew_ipc::{ChannelInfo, ChannelState, Detail, FaultRow, Mode};
use sinew_physics::formulas::heating_power_w;

/// Share of its limit beyond which the hottest wire's temperature is worth a look.
pub const NEAR: f64 = 0.9;

/// One look at a driver.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Name of the rig.
    pub rig: String,
    /// Process id of the driver.
    pub pid: u32,
    /// Rate the loop is meant to run at, Hz.
    pub rate_hz: f64,
    /// Cycles since the start.
    pub cycle: u64,
    /// Since the driver started, s.
    pub uptime_s: f64,
    /// Since the driver wrote this, s.
    pub age_s: f64,
    /// Every channel, in the rig's order.
    pub channels: Vec<Row>,
    /// How the loop does.
    pub timing: Timing,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// Length at no stroke, m.
    pub cold_m: f64,
    /// Length at full stroke, m.
    pub hot_m: f64,
    /// Highest temperature it may be estimated at, °C.
    pub limit_c: f64,
    /// All that the driver publishes of it.
    pub state: ChannelState,
    /// The latched fault, if any.
    pub fault: Option<&'static FaultRow>,
    /// What is wrong with the present sample, if anything.
    pub health: Option<&'static str>,
    /// What holds its duty back, if anything does.
    pub held_by: Option<HeldBack>,
    /// What its wire's account comes to, where this user has it.
    pub account: Option<Account>,
}

/// What an account of a wire comes to, in words: `sinew life` has all of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Account {
    /// What has been used of its life.
    pub used: String,
    /// The electrical energy it has taken in.
    pub energy: String,
}

/// What keeps a channel's duty below what is asked of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeldBack {
    /// The emergency stop.
    Stop,
    /// The heat budget.
    Heat,
    /// The temperature budget.
    Temperature,
    /// The largest power.
    Power,
    /// The limits of the tension.
    Tension,
    /// There is no room for heat at all.
    Cooling,
    /// The output has not confirmed what it was given.
    Unconfirmed,
}

impl HeldBack {
    /// What holds a channel back in this state.
    pub fn of(info: &ChannelInfo, state: &ChannelState) -> Option<HeldBack> {
        let has = |flag: u32| state.flags & flag != 0;
        if has(ChannelState::FLAG_STOPPED) {
            return Some(HeldBack::Stop);
        }
        // as the driver cuts it: to what the largest power leaves of the on-phase's
        let most = info.max_power_w / heating_power_w(1.0, state.current_a, state.resistance_ohm);
        match () {
            () if has(ChannelState::FLAG_HEAT_BUDGET) => Some(HeldBack::Heat),
            () if has(ChannelState::FLAG_TEMPERATURE_BUDGET) => Some(HeldBack::Temperature),
            () if has(ChannelState::FLAG_LIMITED) && state.duty == 0.0 => Some(HeldBack::Cooling),
            () if has(ChannelState::FLAG_LIMITED) && (state.duty / most - 1.0).abs() < 1e-6 => Some(HeldBack::Power),
            () if has(ChannelState::FLAG_LIMITED) => Some(HeldBack::Tension),
            () if has(ChannelState::FLAG_UNCONFIRMED) => Some(HeldBack::Unconfirmed),
            () => None,
        }
    }

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            HeldBack::Stop => "stopped",
            HeldBack::Heat => "heat",
            HeldBack::Temperature => "temperature",
            HeldBack::Power => "power",
            HeldBack::Tension => "tension",
            HeldBack::Cooling => "cooling",
            HeldBack::Unconfirmed => "unconfirmed",
        }
    }

    /// As the rest of "held back by …".
    pub fn by(self) -> &'static str {
        match self {
            HeldBack::Stop => "the emergency stop",
            HeldBack::Heat => "its heat budget",
            HeldBack::Temperature => "its temperature budget",
            HeldBack::Power => "maximum_power_w",
            HeldBack::Tension => "the limits of its tension",
            HeldBack::Cooling => "its heat: not even the sensing pulse has room",
            HeldBack::Unconfirmed => "its output, which has not confirmed its duty",
        }
    }
}

/// How the loop does, from its own histograms.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// Rate over the last look or so, Hz; NaN at the first.
    pub rate_hz: f64,
    /// Cycles skipped because the loop was late.
    pub missed: u64,
    /// Wake-up lateness, µs.
    pub lateness_us: Quantiles,
    /// Time a cycle takes, µs.
    pub cycle_us: Quantiles,
    /// Calls to the allocator inside the loop.
    pub allocations: u64,
    /// Threads of the driver that have died, without which it goes on.
    pub dead: Vec<&'static sinew_threads::Row>,
    /// Each means of real time and whether the machine granted it.
    pub realtime: Vec<(&'static str, bool)>,
}

impl Row {
    /// Share of the stroke at a length: 0 cold, 1 hot. NaN where there is none.
    pub fn stroke_at(&self, length_m: f64) -> f64 {
        let range = self.cold_m - self.hot_m;
        if range > 0.0 { (self.cold_m - length_m) / range } else { f64::NAN }
    }

    /// Present share of the stroke.
    pub fn stroke(&self) -> f64 {
        self.stroke_at(self.state.length_m)
    }

    /// Commanded share of the stroke.
    pub fn target(&self) -> f64 {
        self.stroke_at(self.state.target_m)
    }

    /// What the channel does, in one word.
    pub fn mode(&self) -> &'static str {
        self.state.mode().name()
    }

    /// Who has claimed it, in words: its process, by name where that can be seen.
    pub fn owner(&self) -> Option<String> {
        let pid = self.state.owner;
        let name = std::fs::read_to_string(format!("/proc/{pid}/comm")).ok();
        let name = name.map_or(String::new(), |name| format!(" ({})", name.trim()));
        (pid != 0).then(|| format!("process {pid}{name}, priority {}", self.state.priority))
    }

    /// What is wrong with it, or keeps it back, in words: the cause of every state that is not as it should be.
    pub fn trouble(&self) -> Option<String> {
        match (self.fault, self.health, self.held_by) {
            (Some(fault), _, _) => Some(format!("{}: {}; {}", words(fault.flag), fault.cause, fault.remedy)),
            (None, Some(health), _) => Some(format!("sample: {health}")),
            (None, None, Some(held)) => Some(format!("held back by {}", held.by())),
            (None, None, None) => match self.state.mode() {
                Mode::Waiting => Some("waits until its sensors have reported".into()),
                Mode::Lapsed => Some("off: the lease of its setpoint ran out".into()),
                _ => None,
            },
        }
    }

    /// All that is to be said of it besides: what it is, and the value.
    pub fn details(&self) -> Vec<(&'static str, String)> {
        let mut pairs = Vec::new();
        let (first, rest) = DETAILS.split_at(DETAILS.len() / 2);
        self.fields(first.iter().copied(), &mut pairs);
        let lease_s = self.state.lease_s;
        let setpoint = match lease_s.is_finite() {
            true => format!("held for {lease_s:.1} s more"),
            false if self.state.mode() == Mode::Program => "the driver's own".into(),
            false => "none".into(),
        };
        pairs.push(("setpoint", setpoint));
        if let Some(owner) = self.owner() {
            pairs.push(("claimed by", owner));
        }
        match &self.account {
            Some(Account { used, energy }) => {
                pairs.push(("life used", used.clone()));
                pairs.push(("energy", energy.clone()));
            }
            None => pairs.push(("life used", "no account here yet".into())),
        }
        let added = ChannelState::FIELDS.iter().map(|field| field.name).filter(|name| !DETAILS.contains(name));
        self.fields(rest.iter().copied().chain(added), &mut pairs);
        pairs
    }

    /// Those of these fields that have their line among the details.
    fn fields(&self, names: impl Iterator<Item = &'static str>, pairs: &mut Vec<(&'static str, String)>) {
        for field in names.filter_map(ChannelState::field) {
            let Some(detail) = field.detail else { continue };
            let value = in_its_unit(field.of(&self.state), field.unit, &detail);
            match field.name {
                "temperature_c" => {
                    pairs.push((detail.label, value));
                    pairs.push(("at most", format!("{:.0} °C", self.limit_c)));
                }
                "target_m" => {
                    pairs.push((detail.label, value));
                    pairs.push(("range", format!("{:.1} … {:.1} mm", self.hot_m * 1e3, self.cold_m * 1e3)));
                }
                _ => pairs.push((detail.label, value)),
            }
        }
    }

    /// Whether its fault was the first of all that are latched now.
    pub fn is_first(&self) -> bool {
        self.state.flags & ChannelState::FLAG_FIRST != 0
    }

    /// Whether an emergency stop holds it off.
    pub fn is_stopped(&self) -> bool {
        self.state.flags & ChannelState::FLAG_STOPPED != 0
    }
}

/// The details' fields in their order: what is asked for most comes first, what is known of the wire's use between the two halves, and a field that
/// the table adds last.
const DETAILS: [&str; 7] =
    ["length_m", "target_m", "temperature_c", "power_w", "velocity_m_s", "resistance_ohm", "martensite"];

/// A flag as a person would write it.
pub fn words(flag: &str) -> String {
    flag.replace('_', " ")
}

/// A value as the details show it: lengths and speeds in mm, a dash where it is not known.
fn in_its_unit(value: f64, unit: &str, detail: &Detail) -> String {
    let (factor, unit) = match unit {
        "m" => (1e3, "mm"),
        "m/s" => (1e3, "mm/s"),
        other => (1.0, other),
    };
    let decimals = detail.decimals;
    let text = match value.is_finite() {
        true => format!("{:.decimals$} {unit}", value * factor).trim_end().to_string(),
        false => "–".into(),
    };
    if detail.is_estimate { format!("{text} (estimated)") } else { text }
}

impl View {
    /// The wire that is estimated to be the hottest.
    pub fn hottest(&self) -> Option<&Row> {
        let known = self.channels.iter().filter(|row| row.state.temperature_c.is_finite());
        known.max_by(|a, b| a.state.temperature_c.total_cmp(&b.state.temperature_c))
    }

    /// The fault that was first of several, with its channel: the others may be what came of it.
    pub fn first_of_several(&self) -> Option<(&str, &'static FaultRow)> {
        let several = self.channels.iter().filter(|row| row.fault.is_some()).count() > 1;
        let first = self.channels.iter().find(|row| row.is_first()).filter(|_| several)?;
        Some((&first.name, first.fault?))
    }

    /// A warning that what is shown is old, when it is: the loop has not written for half a second and twenty periods.
    pub fn stands_still(&self) -> Option<String> {
        (self.age_s > 0.5 + 20.0 / self.rate_hz.max(1.0)).then(|| {
            format!("nothing new for {:.1} s: the loop stands still, and all of this is from before", self.age_s)
        })
    }

    /// Threads of the driver that have died, by their names.
    pub fn dead_names(&self) -> String {
        self.timing.dead.iter().map(|row| row.name).collect::<Vec<_>>().join(", ")
    }

    /// What is lost with threads of the driver that have died, where any have.
    pub fn lacks(&self) -> Option<String> {
        let lost = |row: &&sinew_threads::Row| format!("the thread that {} has died: {}", row.does, row.words);
        let lost: Vec<String> = self.timing.dead.iter().map(lost).collect();
        (!lost.is_empty()).then(|| lost.join("\n"))
    }

    /// One line of plain text: what is printed once a second where there is no screen.
    pub fn plain_line(&self) -> String {
        if let Some(stands) = self.stands_still() {
            return format!("{:.1} s  cycle {}  {stands}", self.uptime_s, self.cycle);
        }
        let t = &self.timing;
        let strokes: Vec<String> =
            self.channels.iter().map(|row| percent(row.stroke()).trim_start().to_string()).collect();
        let faults: Vec<String> = self
            .channels
            .iter()
            .filter_map(|row| row.fault.map(|fault| format!("{}: {}", row.name, fault.flag)))
            .collect();
        let faults = if faults.is_empty() { "none".to_string() } else { faults.join(", ") };
        let dead = match self.dead_names() {
            names if names.is_empty() => String::new(),
            names => format!("  threads died: {names}"),
        };
        format!(
            "{:.1} s  cycle {}  missed {}  late p50 {} p99 {} max {} µs  stroke % {}  faults {faults}{dead}",
            self.uptime_s,
            self.cycle,
            t.missed,
            micros(t.lateness_us.p50),
            micros(t.lateness_us.p99),
            micros(t.lateness_us.max),
            strokes.join(" "),
        )
    }
}

/// A share as whole percent, three wide; a dash where it is not known.
pub fn percent(share: f64) -> String {
    match share.is_finite() {
        // adding zero turns the −0 of a rounded-off undershoot into 0
        true => format!("{:3.0}", (share * 100.0).round().clamp(-99.0, 999.0) + 0.0),
        false => "  –".into(),
    }
}

/// A number with so many decimals, `width` wide; a dash where it is not known.
pub fn number(value: f64, width: usize, decimals: usize) -> String {
    match value.is_finite() {
        true => format!("{value:width$.decimals$}"),
        false => format!("{:>width$}", "–"),
    }
}

/// Microseconds short enough for a line: `7`, `1.2k`, `35k`.
pub fn micros(us: f64) -> String {
    match us {
        us if !us.is_finite() => "–".into(),
        us if us < 9.95 => format!("{us:.1}"),
        us if us < 999.5 => format!("{us:.0}"),
        us if us < 9950.0 => format!("{:.1}k", us / 1e3),
        us => format!("{:.0}k", us / 1e3),
    }
}

#[cfg(test)]
pub mod tests {
    use sinew_ipc::{Fault, Mode};

    use super::*;

    const LEGS: [&str; 6] = ["front_left", "front_right", "middle_left", "middle_right", "rear_left", "rear_right"];
    const JOINTS: [&str; 3] = ["coxa", "femur", "tibia"];

    /// A fault in words that nothing else has.
    const OPEN: FaultRow = FaultRow {
        cause: "no current flows",
        remedy: "check the wire and its clamps, then reset",
        ..*Fault::OpenWire.row()
    };

    /// A made-up rig of `count` wires in various states.
    pub fn hexapod(count: usize) -> View {
        let row = |index: usize| {
            let share = (index as f64 * 0.37).fract();
            let (cold_m, hot_m) = (0.1673, 0.1605);
            let faulty = index == 6;
            Row {
                name: match index < 18 {
                    true => format!("{}_{}", LEGS[index / 3], JOINTS[index % 3]),
                    false => format!("wire_{index}"),
                },
                cold_m,
                hot_m,
                limit_c: 140.0,
                state: ChannelState {
                    mode: if faulty { Mode::Fault } else { Mode::Program }.code(),
                    measured_length_m: cold_m - share * (cold_m - hot_m),
                    length_m: cold_m - share * (cold_m - hot_m),
                    target_m: if faulty { f64::NAN } else { cold_m - (share + 0.02) * (cold_m - hot_m) },
                    velocity_m_s: -0.0012,
                    duty: 0.3 * share,
                    resistance_ohm: 10.2 - share,
                    temperature_c: 40.0 + 60.0 * share,
                    martensite: 1.0 - share,
                    power_w: 2.5 * share,
                    lease_s: if index == 3 { 1.4 } else { f64::NAN },
                    flags: if faulty { ChannelState::FLAG_FIRST } else { 0 },
                    ..ChannelState::UNKNOWN
                },
                fault: faulty.then_some(&OPEN),
                health: (index == 9).then_some("out of range"),
                held_by: (index == 11).then_some(HeldBack::Heat),
                account: None,
            }
        };
        View {
            rig: "hexapod".into(),
            pid: 4242,
            rate_hz: 1000.0,
            cycle: 754_321,
            uptime_s: 754.321,
            age_s: 0.02,
            channels: (0..count).map(row).collect(),
            timing: Timing {
                rate_hz: 999.8,
                missed: 3,
                lateness_us: Quantiles { p50: 7.2, p99: 61.0, p999: 143.0, max: 1830.0 },
                cycle_us: Quantiles { p50: 14.1, p99: 22.0, p999: 40.0, max: 212.0 },
                allocations: 0,
                dead: Vec::new(),
                realtime: vec![
                    ("SCHED_FIFO", true),
                    ("memory locked", true),
                    ("pinned to a core", true),
                    ("cpu_dma_latency held", false),
                ],
            },
        }
    }

    #[test]
    fn the_plain_line_names_the_faults() {
        let line = hexapod(8).plain_line();
        assert_eq!(line.lines().count(), 1);
        assert!(line.contains("cycle 754321") && line.contains("faults middle_left_coxa: open_wire"), "{line}");
    }

    #[test]
    fn what_holds_a_channel_back_is_told_by_its_flags_and_its_power() {
        let info = ChannelInfo { max_power_w: 2.0, ..ChannelInfo::EMPTY };
        let of = |flags: u32, duty: f64| {
            let state = ChannelState { flags, duty, current_a: 0.5, resistance_ohm: 10.0, ..ChannelState::UNKNOWN };
            HeldBack::of(&info, &state)
        };
        type C = ChannelState;
        assert_eq!(of(0, 0.5), None);
        assert_eq!(of(C::FLAG_SATURATED | C::FLAG_SETTLED | C::FLAG_DARK, 0.0), None, "as the law wants it");
        assert_eq!(of(C::FLAG_LIMITED | C::FLAG_HEAT_BUDGET, 0.3), Some(HeldBack::Heat));
        assert_eq!(of(C::FLAG_LIMITED | C::FLAG_TEMPERATURE_BUDGET, 0.3), Some(HeldBack::Temperature));
        // 2.5 W in the on-phase
        assert_eq!(of(C::FLAG_LIMITED, 0.8), Some(HeldBack::Power));
        assert_eq!(of(C::FLAG_LIMITED, 0.4), Some(HeldBack::Tension));
        assert_eq!(of(C::FLAG_LIMITED | C::FLAG_DARK, 0.0), Some(HeldBack::Cooling));
        assert_eq!(of(C::FLAG_UNCONFIRMED, 0.4), Some(HeldBack::Unconfirmed));
        assert_eq!(of(C::FLAG_STOPPED | C::FLAG_LIMITED, 0.0), Some(HeldBack::Stop));
    }

    #[test]
    fn the_hottest_is_found_among_those_that_are_known() {
        let mut view = hexapod(18);
        view.channels[4].state.temperature_c = f64::NAN;
        view.channels[5].state.temperature_c = 131.0;
        assert_eq!(view.hottest().unwrap().name, view.channels[5].name);
        view.channels.iter_mut().for_each(|row| row.state.temperature_c = f64::NAN);
        assert_eq!(view.hottest(), None);
    }

    #[test]
    fn of_several_faults_the_first_is_named() {
        let mut view = hexapod(8);
        assert_eq!(view.first_of_several(), None, "one alone needs no word");
        view.channels[2].fault = view.channels[6].fault;
        let (name, fault) = view.first_of_several().unwrap();
        assert_eq!((name, fault.flag), ("middle_left_coxa", "open_wire"));
    }

    #[test]
    fn numbers_stay_short_and_never_say_nan() {
        assert_eq!(percent(0.423), " 42");
        assert_eq!(percent(-0.001), "  0");
        assert_eq!(percent(f64::NAN), "  –");
        assert_eq!(number(f64::NAN, 5, 1), "    –");
        assert_eq!(number(4.56, 5, 1), "  4.6");
        assert_eq!(micros(7.24), "7.2");
        assert_eq!(micros(9.97), "10");
        assert_eq!(micros(1234.0), "1.2k");
        assert_eq!(micros(f64::NAN), "–");
    }
}
