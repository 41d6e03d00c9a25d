//! `[simulation]` and `[[simulation.fault]]`: the simulated backend and the faults it plays.

use std::collections::BTreeSet;

use toml_edit::{ArrayOfTables, Item, Table as Written, TableLike};

use crate::declare::rows::*;
use crate::edit::{remove, table_at};
use crate::error::What;
use crate::notes::Reader;
use crate::tree::{Node, Tree};
use crate::value::{channel_choices, in_range, not_a_choice, number as any_number, unknown_hint};

/// The simulated backend.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Seed of all noise.
    pub seed: u64,
    /// Whether simulated time keeps to the clock.
    pub pace: Pace,
    /// Simulated seconds in a second, from 1 on.
    pub speed: f64,
    /// Faults to play, in the order of the file.
    pub faults: Vec<SimulatedFault>,
}

words! {
    /// Whether simulated time keeps to the clock.
    pub enum Pace, default RealTime {
        /// One simulated second takes one second.
        RealTime = "real_time",
        /// As fast as the machine can.
        AsFastAsPossible = "as_fast_as_possible",
    }
}

/// Keys of `[simulation]`; its faults are read apart.
pub(crate) fn section() -> Section<Simulation> {
    Section {
        table: "simulation",
        about: "The simulated backend.",
        optional: false,
        keys: keys! {
            Simulation;
            /// Seed of all noise: same seed, same run.
            "seed" = at(seed), integer(0, i64::MAX), Integer(1);
            /// Whether simulated time keeps to the clock.
            "pace" = at(pace), Pace::KIND, Pace::DEFAULT;
            /// How many simulated seconds are to pass in a second; leases and `--for` count simulated ones. `sinew run --speed` sets it.
            "speed" = at(speed), number(si("1"), 1.0, 10_000.0), Number(1.0);
        },
        check: None,
    }
}

impl Simulation {
    /// One of which nothing is read yet.
    pub(crate) fn unread() -> Simulation {
        Simulation { seed: u64::UNREAD, pace: Pace::UNREAD, speed: f64::UNREAD, faults: Vec::new() }
    }
}

/// A fault the simulated backend plays.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedFault {
    /// Index of the channel it strikes; `None` = all.
    pub channel: Option<usize>,
    /// What breaks.
    pub kind: FaultKind,
    /// When it begins, in s of simulated time.
    pub start_s: f64,
    /// When it ends, in s of simulated time; infinite = never.
    pub end_s: f64,
    /// Its size in the unit of its kind, see [`FaultKind::value_key`]; `None` = the kind's default.
    pub value: Option<f64>,
}

impl SimulatedFault {
    /// Whether it acts at `time_s`.
    pub fn acts_at(&self, time_s: f64) -> bool {
        self.start_s <= time_s && time_s < self.end_s
    }

    /// Its size in the unit of its kind, the kind's default where the file gives none; 0 where the kind has no size.
    pub fn size(&self) -> f64 {
        self.value.or(self.kind.value_range().map(|(_, _, default)| default)).unwrap_or(0.0)
    }
}

words! {
    /// What breaks in a simulated fault.
    pub enum FaultKind, default OpenWire {
        /// No current flows.
        OpenWire = "open_wire",
        /// The wire is bridged by `value` Ω.
        ShortedWire = "shorted_wire",
        /// Tap `value` (1, 2 or 3 for the moving end) touches nothing.
        ProbeLost = "probe_lost",
        /// `value` Ω at the moving end, inside V_3.
        ContactResistance = "contact_resistance",
        /// Tap `value` (1 or 2) no longer slides: it sticks to its place on the wire and moves with it.
        ProbeStuck = "probe_stuck",
        /// The supply falls to the fraction `value` of itself.
        SupplyDip = "supply_dip",
        /// The supply rises to `value` times itself.
        SupplyHigh = "supply_high",
        /// The output stage conducts through the whole period, whatever its duty.
        StageOn = "stage_on",
        /// The output stage conducts only through `value` Ω more; by default so many that it does not conduct.
        StageWeak = "stage_weak",
        /// The output stage takes no duty any more and says so: it keeps the one it has, until its own watchdog acts.
        WriteFails = "write_fails",
        /// The load stands still, however the wire pulls; not in a joint.
        Jammed = "jammed",
        /// Every sample repeats the last one.
        AdcStuck = "adc_stuck",
        /// Every sample is at full scale.
        AdcSaturated = "adc_saturated",
        /// Every sample is NaN.
        AdcNan = "adc_nan",
        /// The backend's exchange fails.
        BackendError = "backend_error",
        /// The emergency stop's contact is open; of the whole rig, where one is fitted.
        EstopOpen = "estop_open",
        /// The emergency stop's reset button is pressed: no fault, but how one is left where nobody sits at a terminal.
        EstopReset = "estop_reset",
    }
}

/// What the `value` of a kind of fault is.
struct Size {
    about: &'static str,
    low: f64,
    high: f64,
    default: f64,
    /// Where only these whole numbers make sense, those in words.
    whole: Option<&'static str>,
}

impl FaultKind {
    /// `None` where it has no size.
    fn sized(self) -> Option<Size> {
        let size = |about, low, high, default| Some(Size { about, low, high, default, whole: None });
        let tap = |about, high, whole| Some(Size { about, low: 1.0, high, default: 2.0, whole: Some(whole) });
        match self {
            FaultKind::ShortedWire => size("Ω that bridge the wire", 0.0, 1000.0, 0.05),
            FaultKind::ProbeLost => tap("the tap: 1, 2, or 3 for the moving end", 3.0, "1, 2 or 3"),
            FaultKind::ContactResistance => size("Ω inside V_3", 0.0, 1000.0, 0.5),
            FaultKind::ProbeStuck => tap("the tap: 1 or 2", 2.0, "1 or 2"),
            FaultKind::SupplyDip => size("fraction of the supply that is left", 0.0, 1.0, 0.5),
            FaultKind::SupplyHigh => size("the supply as a multiple of itself", 1.0, 3.0, 1.4),
            FaultKind::StageWeak => size("Ω more in the output stage", 0.0, 1e6, 1e6),
            FaultKind::OpenWire
            | FaultKind::StageOn
            | FaultKind::WriteFails
            | FaultKind::Jammed
            | FaultKind::AdcStuck
            | FaultKind::AdcSaturated
            | FaultKind::AdcNan
            | FaultKind::BackendError
            | FaultKind::EstopOpen
            | FaultKind::EstopReset => None,
        }
    }

    /// What `value` means for this kind, in words; `None` where it has no size.
    pub fn value_key(self) -> Option<&'static str> {
        self.sized().map(|size| size.about)
    }

    /// Least, largest and default `value` of this kind; `None` where it has no size.
    pub fn value_range(self) -> Option<(f64, f64, f64)> {
        self.sized().map(|size| (size.low, size.high, size.default))
    }

    /// What is wrong with a `value` of this kind.
    fn mistake(self, found: f64) -> Option<What> {
        let Some(Size { low, high, whole, .. }) = self.sized() else {
            return Some(What::Contradiction { message: "makes no sense with this kind; take it out".into() });
        };
        if !(low..=high).contains(&found) {
            return Some(What::OutOfRange { found, low, high, defaulted: false });
        }
        let expected = whole.filter(|_| found.fract() != 0.0)?;
        Some(What::Contradiction { message: format!("is {found}, expected {expected}") })
    }
}

/// Keys of a simulated fault.
const FAULT_KEYS: [&str; 5] = ["channel", "kind", "start_s", "end_s", "value"];

/// Reads the faults; `channels` are the names of the rig's.
pub(crate) fn faults(reader: &mut Reader<'_>, node: &Node, channels: &[&str]) -> Vec<SimulatedFault> {
    let Tree::Array(nodes) = &node.value else {
        let expected = "an array of tables: [[simulation.fault]], with two brackets".into();
        let what = What::WrongType { found: node.value.describe(), expected };
        reader.problem(node.line, None, "simulation.fault", what);
        return Vec::new();
    };
    nodes.iter().filter_map(|node| fault(reader, node, channels)).collect()
}

fn fault(reader: &mut Reader<'_>, node: &Node, channels: &[&str]) -> Option<SimulatedFault> {
    let table = reader.table(node, None, "simulation.fault", "[[simulation.fault]]")?;
    let before = reader.found();
    let mut fault =
        SimulatedFault { channel: None, kind: FaultKind::USUAL, start_s: 0.0, end_s: f64::INFINITY, value: None };
    let mut seen = BTreeSet::new();
    for (name, node) in table {
        seen.insert(name.as_str());
        if let Err(what) = fault_key(&mut fault, name, node, channels) {
            reader.problem(node.line, None, format!("simulation.fault.{name}"), what);
        }
    }
    for (key, expected) in [("kind", "what breaks, such as \"open_wire\""), ("start_s", "when it begins, in s")] {
        if !seen.contains(key) {
            let what = What::Missing { expected: expected.into() };
            reader.problem(node.line, None, format!("simulation.fault.{key}"), what);
        }
    }
    if reader.found() > before {
        return None;
    }
    let line = |key: &str| table.get(key).map_or(node.line, |n| n.line);
    if fault.end_s <= fault.start_s {
        let message = format!("is {}, expected more than start_s, {}", fault.end_s, fault.start_s);
        reader.problem(line("end_s"), None, "simulation.fault.end_s", What::Contradiction { message });
    }
    if let Some(what) = fault.value.and_then(|found| fault.kind.mistake(found)) {
        reader.problem(line("value"), None, "simulation.fault.value", what);
    }
    Some(fault)
}

fn fault_key(fault: &mut SimulatedFault, name: &str, node: &Node, channels: &[&str]) -> Result<(), What> {
    match (name, &node.value) {
        ("channel", Tree::Text(name)) => {
            let found = channels.iter().position(|channel| channel == name);
            let unknown =
                || What::NotAChoice { found: name.clone(), expected: channel_choices(name, channels.iter().copied()) };
            fault.channel = Some(found.ok_or_else(unknown)?);
        }
        ("kind", Tree::Text(word)) => {
            let found = FaultKind::ALL.iter().find(|(w, _)| w == word);
            fault.kind = found.ok_or_else(|| not_a_choice(word, &FaultKind::ALL.map(|(w, _)| w)))?.1;
        }
        ("channel" | "kind", other) => {
            return Err(What::WrongType { found: other.describe(), expected: "text in quotes".into() });
        }
        ("start_s", _) => fault.start_s = in_range(node, 0.0, 1e9)?,
        ("end_s", _) => fault.end_s = in_range(node, 0.0, 1e9)?,
        ("value", _) => fault.value = Some(any_number(node, "a number")?),
        _ => return Err(What::Unknown { hint: unknown_hint(name, "", FAULT_KEYS) }),
    }
    Ok(())
}

/// A fault with the name of the channel it strikes instead of its index.
pub(crate) type NamedFault = (Option<String>, SimulatedFault);

impl SimulatedFault {
    /// The fault by the name of the channel it strikes: channels may move.
    pub(crate) fn named<'c>(&self, name: impl FnOnce(usize) -> Option<&'c str>) -> NamedFault {
        (self.channel.and_then(name).map(str::to_string), SimulatedFault { channel: None, ..self.clone() })
    }
}

/// Writes the faults where they differ from those of `base`.
pub(crate) fn write_faults(root: &mut dyn TableLike, faults: Vec<NamedFault>, base: &[NamedFault]) {
    if faults == base {
        return;
    }
    remove(root, &["simulation"], "fault");
    if faults.is_empty() {
        return;
    }
    let mut tables = ArrayOfTables::new();
    for (channel, fault) in faults {
        let mut table = Written::new();
        if let Some(name) = channel {
            table.insert("channel", toml_edit::value(name));
        }
        table.insert("kind", toml_edit::value(fault.kind.word()));
        table.insert("start_s", toml_edit::value(fault.start_s));
        if fault.end_s.is_finite() {
            table.insert("end_s", toml_edit::value(fault.end_s));
        }
        if let Some(value) = fault.value {
            table.insert("value", toml_edit::value(value));
        }
        tables.push(table);
    }
    if let Some(simulation) = table_at(root, &["simulation"]) {
        simulation.insert("fault", Item::ArrayOfTables(tables));
    }
}
