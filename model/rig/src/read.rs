//! From the text of a rig file to a [`Rig`], collecting every mistake on the way.

use std::collections::{BTreeMap, BTreeSet};

use sinew_physics::effects::{Effects, Home};
use sinew_physics::{DriveKind, Geometry, Initial, Kinetics, Load, Material, WireModel};

use crate::derive;
use crate::effects;
use crate::error::{Error, Problem, What};
use crate::parameters::{self, Prior};
use crate::schema::{
    self, ACCESS, BACKEND, BACKEND_LINUX, BACKEND_SERIAL, BLACK_BOX, CHANNEL, Default, JOINT, Key, Kind, MACHINE, RIG,
    SIMULATION, Section, UNREAD_MACHINE, Value, local,
};
use crate::suggest::nearest;
use crate::tree::{self, Node, Table, Tree};
use crate::types::*;

/// The columns a recording can have, by the contract.
pub(crate) const COLUMNS: [&str; 13] = [
    "time_s",
    "duty",
    "power_w",
    "temperature_c",
    "supply_v",
    "current_a",
    "v1_v",
    "v2_v",
    "v3_v",
    "force_n",
    "position_m",
    "ambient_c",
    "disturbance_n",
];

/// Tables of a channel that are more than a plain list of keys.
const OTHER_CHANNEL_TABLES: [&str; 2] = ["priors", "effects"];
/// Names of a rig or channel: the rule in words.
const NAME_RULE: &str = "letters, digits, '-', '_' and '.', a letter or digit first";
/// Keys of a simulated fault.
const FAULT_KEYS: [&str; 5] = ["channel", "kind", "start_s", "end_s", "value"];

/// Reads a rig file's text.
pub(crate) fn rig(text: &str, file: &str) -> Result<Rig, Error> {
    let mut reader = Reader { file, problems: Vec::new() };
    // A byte-order mark is no mistake; it is cut off only for the parser, lines stay as they are.
    let rig = match tree::parse(text.strip_prefix('\u{feff}').unwrap_or(text)) {
        Err(errors) => {
            for (line, message) in errors {
                reader.problem(line, None, "", What::Syntax { message: format!("not TOML: {message}") });
            }
            None
        }
        Ok(root) => reader.root(&root),
    };
    let mut problems = reader.problems;
    match rig {
        Some(mut rig) if problems.is_empty() => {
            rig.source = Source { file: file.to_string(), text: text.to_string() };
            Ok(rig)
        }
        _ => {
            problems.sort_by_key(|p| p.line);
            Err(Error::Invalid { problems })
        }
    }
}

/// The line of a channel's key in a rig's text, or of the nearest thing above it; for checks after reading.
pub(crate) fn line_of(source: &Source, channel: Option<usize>, path: &str) -> usize {
    let Ok(root) = tree::parse(source.text.strip_prefix('\u{feff}').unwrap_or(&source.text)) else { return 1 };
    let mut line = 1;
    let mut table = &root;
    if let Some(index) = channel {
        let Some(Node { value: Tree::Array(channels), line: first }) = root.get("channel") else { return line };
        line = *first;
        let Some(Node { value: Tree::Table(t), line: header }) = channels.get(index) else { return line };
        line = *header;
        table = t;
    }
    for part in path.split('.').filter(|p| !p.is_empty()) {
        let Some(node) = table.get(part) else { break };
        line = node.line;
        let Tree::Table(t) = &node.value else { break };
        table = t;
    }
    line
}

/// What a channel's file gives itself, as (table, key), with lines.
type Given = BTreeMap<(&'static str, &'static str), usize>;

/// What is kept of a channel that was read until it can be completed.
struct Read {
    given: Given,
    /// Line of its header.
    header: usize,
    /// What messages call it.
    label: String,
}

struct Reader<'a> {
    file: &'a str,
    problems: Vec<Problem>,
}

impl Reader<'_> {
    fn problem(&mut self, line: usize, channel: Option<&str>, key: impl Into<String>, what: What) {
        let (file, channel) = (self.file.to_string(), channel.map(str::to_string));
        self.problems.push(Problem { file, line, channel, key: key.into(), what });
    }

    fn root(&mut self, root: &Table) -> Option<Rig> {
        const TABLES: [&str; 9] =
            ["rig", "access", "channel", "joint", "recording", "backend", "black_box", "simulation", "machine"];
        for (name, node) in root {
            if !TABLES.contains(&name.as_str()) {
                let hint = unknown_hint(name, "", TABLES);
                self.problem(node.line, None, name.as_str(), What::Unknown { hint });
            }
        }
        let mut rig = Rig {
            name: String::new(),
            rate_hz: f64::NAN,
            ambient_c: f64::NAN,
            realtime: Realtime { mode: RealtimeMode::Try, priority: 0, cpu: None },
            access: Access::default(),
            channels: Vec::new(),
            joints: Vec::new(),
            columns: ColumnMap::new(),
            backend: schema::UNREAD_BACKEND,
            black_box: schema::UNREAD_BLACK_BOX,
            simulation: Simulation { seed: 0, pace: Pace::RealTime, faults: Vec::new() },
            machine: UNREAD_MACHINE,
            source: Source::default(),
        };
        let given = self.section(&RIG, root.get("rig"), &[], None, 1, &mut rig);
        self.rig_checks(&rig, &given);
        self.section(&ACCESS, root.get("access"), &[], None, 1, &mut rig);
        let backend = root.get("backend");
        self.section(&BACKEND, backend, &["serial", "linux"], None, 1, &mut rig);
        let header = backend.map_or(1, |node| node.line);
        let given = self.section(&BACKEND_SERIAL, descend(root, "backend.serial"), &[], None, header, &mut rig);
        self.backend_checks(&rig, &given, header);
        self.section(&BACKEND_LINUX, descend(root, "backend.linux"), &[], None, header, &mut rig);
        self.section(&BLACK_BOX, root.get("black_box"), &[], None, 1, &mut rig);
        let given = self.section(&SIMULATION, root.get("simulation"), &["fault"], None, 1, &mut rig);
        if rig.backend.kind != BackendKind::Simulated
            && rig.simulation.pace != Pace::RealTime
            && let Some(line) = given.get(&("simulation", "pace"))
        {
            let message = "makes no sense with wires that are not simulated; take it out".into();
            self.problem(*line, None, "simulation.pace", What::Contradiction { message });
        }
        let given = self.section(&MACHINE, root.get("machine"), &[], None, 1, &mut rig);
        self.machine_checks(&rig, &given);
        rig.joints = root.get("joint").map_or_else(Vec::new, |node| self.joints(node));
        let read = self.channels(root.get("channel"), &mut rig);
        if let Some(node) = root.get("joint") {
            self.complete_joints(node, &mut rig);
        }
        self.complete_channels(&read, &mut rig);
        if let Some(Node { value: Tree::Array(nodes), .. }) = root.get("channel") {
            self.front_end_places(nodes, &rig);
            self.linux_places(nodes, &rig);
        }
        if let Some(node) = root.get("recording") {
            rig.columns = self.recording(node);
        }
        if let Some(Node { value: Tree::Table(simulation), .. }) = root.get("simulation")
            && let Some(faults) = simulation.get("fault")
        {
            rig.simulation.faults = self.faults(faults, &rig.channels);
        }
        Some(rig)
    }

    fn rig_checks(&mut self, rig: &Rig, given: &Given) {
        if rig.realtime.mode == RealtimeMode::Off {
            for key in ["realtime_priority", "realtime_cpu"] {
                if let Some(line) = given.get(&("rig", key)) {
                    let message = "makes no sense with realtime = \"off\"; take one of the two out".into();
                    self.problem(*line, None, format!("rig.{key}"), What::Contradiction { message });
                }
            }
        }
    }

    /// What a kind of backend cannot do without.
    fn backend_checks(&mut self, rig: &Rig, given: &Given, header: usize) {
        if rig.backend.kind == BackendKind::Serial && !given.contains_key(&("backend.serial", "port")) {
            let expected = "the device the front-end is on, such as \"/dev/ttyACM0\"".into();
            self.problem(header, None, "backend.serial.port", What::Missing { expected });
        }
    }

    /// No two channels can be the same one of a front-end.
    fn front_end_places(&mut self, nodes: &[Node], rig: &Rig) {
        if rig.backend.kind != BackendKind::Serial {
            return;
        }
        let mut taken: BTreeMap<u32, &str> = BTreeMap::new();
        for (index, (channel, node)) in rig.channels.iter().zip(nodes).enumerate() {
            let Some(place) = rig.front_end_index(index) else { continue };
            if let Some(other) = taken.insert(place, &channel.name) {
                let message = format!(
                    "is {place}, where channel \"{other}\" is already; expected a place of its own (without an index it \
                     is the place in the file, from 0)"
                );
                let line = line_in(node, &["front_end", "index"]);
                self.problem(line, Some(&channel.name), "front_end.index", What::Contradiction { message });
            }
        }
    }

    /// What a channel on Linux's own interfaces cannot do without, and what these cannot do.
    fn linux_places(&mut self, nodes: &[Node], rig: &Rig) {
        for (channel, node) in rig.channels.iter().zip(nodes) {
            let linux = &channel.linux;
            for (key, input) in [("v1_gain", &linux.v1), ("v2_gain", &linux.v2), ("v3_gain", &linux.v3)]
                .into_iter()
                .chain([("current_gain", &linux.current), ("supply_gain", &linux.supply)])
            {
                if input.gain == 0.0 {
                    let message =
                        "is 0: nothing could be measured; expected what one volt at the converter stands for".into();
                    let line = line_in(node, &["linux", key]);
                    self.problem(line, Some(&channel.name), format!("linux.{key}"), What::Contradiction { message });
                }
            }
            if rig.backend.kind != BackendKind::Linux {
                continue;
            }
            let line = line_in(node, &["linux"]);
            let mut needed = vec![
                ("pwm", &linux.pwm, "the output, such as \"pwmchip0/1\""),
                ("v3", &linux.v3.name, "the moving end's input, such as \"1-0048:in_voltage2\""),
                ("current", &linux.current.name, "the current's input, such as \"1-0048:in_current0\""),
            ];
            if channel.control.sensing == Sensing::Dual && channel.model.taps.is_some() {
                needed.push(("v1", &linux.v1.name, "the first tap's input, such as \"1-0048:in_voltage0\""));
                needed.push(("v2", &linux.v2.name, "the second tap's input, such as \"1-0048:in_voltage1\""));
            }
            for (key, value, expected) in needed {
                if value.is_none() {
                    self.problem(
                        line,
                        Some(&channel.name),
                        format!("linux.{key}"),
                        What::Missing { expected: expected.into() },
                    );
                }
            }
            if channel.adc.circuit == SamplingCircuit::Shared {
                let message =
                    "cannot be sampled by backend \"linux\", which knows no off-phase; expected \"separate_taps\""
                        .into();
                let line = line_in(node, &["adc", "circuit"]);
                self.problem(line, Some(&channel.name), "adc.circuit", What::Contradiction { message });
            }
        }
    }

    fn machine_checks(&mut self, rig: &Rig, given: &Given) {
        let (low, high) = (rig.machine.chamber_min_c, rig.machine.chamber_max_c);
        if low > high {
            let line = given.get(&("machine", "chamber_max_c")).or(given.get(&("machine", "chamber_min_c")));
            let message = format!("is {high}, below chamber_min_c = {low}, expected a warmer one");
            self.problem(line.copied().unwrap_or(1), None, "machine.chamber_max_c", What::Contradiction { message });
        }
    }

    /// Reads a plain table into `target` and applies its defaults. `others` are sub-tables read elsewhere.
    /// Gives the keys that were there; those with a mistake too, so that no default talks over it.
    fn section<T>(
        &mut self,
        section: &'static Section<T>,
        node: Option<&Node>,
        others: &[&str],
        channel: Option<&str>,
        header: usize,
        target: &mut T,
    ) -> Given {
        let table_name = local(section.table);
        let path = |key: &str| if table_name.is_empty() { key.to_string() } else { format!("{table_name}.{key}") };
        let mut given = Given::new();
        let empty = Table::new();
        let (table, header) = match node {
            None => (&empty, header),
            Some(Node { value: Tree::Table(table), line }) => (table, *line),
            Some(Node { value, line }) => {
                let expected = format!("a table: [{}]", section.table);
                self.problem(*line, channel, table_name, What::WrongType { found: value.describe(), expected });
                return given;
            }
        };
        if section.optional && node.is_none() {
            return given;
        }
        for (name, node) in table {
            if !section.keys.iter().any(|k| k.name == name) && !others.contains(&name.as_str()) {
                let keys = section.keys.iter().map(|k| k.name).chain(others.iter().copied());
                let hint = unknown_hint(name, section.table, keys);
                self.problem(node.line, channel, path(name), What::Unknown { hint });
            }
        }
        // In the order of the schema: what selects a kind comes before the keys of that kind.
        for key in section.keys {
            match table.get(key.name) {
                Some(node) => {
                    given.insert((table_name, key.name), node.line);
                    match value(key, node) {
                        Ok(value) => (key.set)(target, value),
                        Err(what) => self.problem(node.line, channel, path(key.name), what),
                    }
                }
                None => match &key.default {
                    Default::Required(expected) => {
                        self.problem(header, channel, path(key.name), What::Missing { expected: (*expected).into() });
                        // Said once: what depends on it keeps quiet.
                        given.insert((table_name, key.name), header);
                    }
                    Default::Number(in_file) => {
                        if let Kind::Number { scale, .. } = key.kind {
                            (key.set)(target, Value::Number(scale.to_si(*in_file)));
                        }
                    }
                    Default::Integer(i) => (key.set)(target, Value::Integer(*i)),
                    Default::Text(t) => (key.set)(target, Value::Text((*t).into())),
                    Default::Computed(_) => {}
                },
            }
        }
        given
    }

    /// Reads the channels; what of each stood in the file, with its line and name, for those that are right key by key.
    fn channels(&mut self, node: Option<&Node>, rig: &mut Rig) -> Vec<Option<Read>> {
        let mut read = Vec::new();
        let nodes = match node {
            Some(Node { value: Tree::Array(nodes), .. }) if !nodes.is_empty() => nodes,
            Some(Node { value: Tree::Array(_), line }) => {
                let expected = "at least one [[channel]]".into();
                self.problem(*line, None, "channel", What::Missing { expected });
                return read;
            }
            Some(Node { value, line }) => {
                let found = match value {
                    Tree::Table(_) => "a single table [channel]".into(),
                    other => other.describe(),
                };
                let expected = "an array of tables: [[channel]], with two brackets".into();
                self.problem(*line, None, "channel", What::WrongType { found, expected });
                return read;
            }
            None => {
                let expected = "at least one [[channel]]".into();
                self.problem(1, None, "channel", What::Missing { expected });
                return read;
            }
        };
        if let Some(extra) = nodes.get(MAX_CHANNELS) {
            let message = format!(
                "has {} entries, expected at most {MAX_CHANNELS}; split the rig in two files with names of their own",
                nodes.len()
            );
            self.problem(extra.line, None, "channel", What::Contradiction { message });
        }
        let mut first_use: BTreeMap<String, usize> = BTreeMap::new();
        for (index, node) in nodes.iter().take(MAX_CHANNELS).enumerate() {
            let Tree::Table(table) = &node.value else {
                let (found, expected) = (node.value.describe(), "a table: [[channel]]".into());
                self.problem(node.line, Some(&format!("#{}", index + 1)), "", What::WrongType { found, expected });
                continue;
            };
            let (channel, given) = self.channel(index, node.line, table, rig);
            if !channel.name.is_empty() {
                let line = table.get("name").map_or(node.line, |n| n.line);
                match first_use.get(&channel.name) {
                    Some(&first_line) => {
                        let name = channel.name.clone();
                        self.problem(
                            line,
                            Some(&format!("#{}", index + 1)),
                            "name",
                            What::Duplicate { name, first_line },
                        );
                    }
                    None => {
                        first_use.insert(channel.name.clone(), line);
                    }
                }
            }
            rig.channels.push(channel);
            read.push(given);
        }
        self.neighbours(nodes, &rig.channels);
        read
    }

    fn channel(&mut self, index: usize, header: usize, table: &Table, rig: &Rig) -> (Channel, Option<Read>) {
        let before = self.problems.len();
        let mut channel = blank_channel(rig.ambient_c);
        // The name first: every message about the channel carries it.
        let place = format!("#{}", index + 1);
        let label = match table.get("name").map(|n| &n.value) {
            Some(Tree::Text(name)) if is_name(name, MAX_CHANNEL_NAME) => name.clone(),
            _ => place,
        };
        let label = label.as_str();

        let tables: Vec<&str> = CHANNEL.iter().map(|s| local(s.table)).chain(OTHER_CHANNEL_TABLES).collect();
        let mut given = Given::new();
        for section in CHANNEL {
            let name = local(section.table);
            if name.is_empty() {
                // The channel's own table is at hand already and its sub-tables are no unknown keys.
                let own = Node { line: header, value: Tree::Table(table.clone()) };
                given.extend(self.section(
                    section,
                    Some(&own),
                    &within(&tables, ""),
                    Some(label),
                    header,
                    &mut channel,
                ));
            } else {
                let node = descend(table, name);
                given.extend(self.section(section, node, &within(&tables, name), Some(label), header, &mut channel));
            }
        }
        let joint = rig.joints.iter().find(|joint| joint.side(&channel.name).is_some());
        if let Some(joint) = joint {
            self.load_in_joint(&mut channel, joint, &mut given, label);
        }
        if let Some(node) = table.get("priors") {
            channel.priors = self.priors(node, label);
        }
        if let Some(node) = table.get("effects") {
            self.effects(node, label, &mut channel);
        }
        self.requirements(&mut channel, &given, table, header, label);
        let read = Read { given, header, label: label.to_string() };
        (channel, (self.problems.len() == before).then_some(read))
    }

    /// Computed defaults and cross-checks, which only make sense of channels that are right key by key, and of those in a
    /// joint only if that is right too.
    fn complete_channels(&mut self, read: &[Option<Read>], rig: &mut Rig) {
        for (channel, read) in rig.channels.iter_mut().zip(read) {
            let Some(Read { given, header, label }) = read else { continue };
            let joint = rig.joints.iter().find(|joint| joint.side(&channel.name).is_some());
            if joint.is_some_and(|joint| joint.tension_n.is_nan()) {
                continue;
            }
            derive::fill(channel, joint, &|table, key| given.iter().any(|((t, k), _)| *t == table && *k == key));
            self.physics(channel, given, *header, label);
            self.relations(channel, given, *header, label);
        }
    }

    /// A wire in a joint has no load but that.
    fn load_in_joint(&mut self, channel: &mut Channel, joint: &Joint, given: &mut Given, label: &str) {
        let allowed = |key: &str| key == "kind" && channel.model.load == LOAD_IN_JOINT;
        for (&(_, key), &line) in given.iter().filter(|((table, key), _)| *table == "load" && !allowed(key)) {
            let message = format!(
                "makes no sense: the wire turns joint \"{}\" and has no load of its own; take [channel.load] out",
                joint.name
            );
            self.problem(line, Some(label), format!("load.{key}"), What::Contradiction { message });
        }
        for key in ["minimum_force_n", "maximum_force_n"] {
            if let Some(line) = given.get(&("limits", key)) {
                let message = format!(
                    "makes no sense: the tension of a joint's wires is limited by joint \"{}\"; use its minimum_tension_n and maximum_tension_n",
                    joint.name
                );
                self.problem(*line, Some(label), format!("limits.{key}"), What::Contradiction { message });
            }
        }
        // Said once.
        given.retain(|(table, _), _| *table != "load");
        channel.model.load = LOAD_IN_JOINT;
    }

    /// Reads the joints key by key; what depends on their channels waits for [`Reader::complete_joints`].
    fn joints(&mut self, node: &Node) -> Vec<Joint> {
        let Tree::Array(nodes) = &node.value else {
            let found = match &node.value {
                Tree::Table(_) => "a single table [joint]".into(),
                other => other.describe(),
            };
            let expected = "an array of tables: [[joint]], with two brackets".into();
            self.problem(node.line, None, "joint", What::WrongType { found, expected });
            return Vec::new();
        };
        let mut joints = Vec::new();
        for node in nodes {
            let mut joint = blank_joint();
            self.section(&JOINT, Some(node), &[], None, node.line, &mut joint);
            joints.push(joint);
        }
        joints
    }

    /// Who turns which joint, then the joints' computed defaults and what the physics says to them.
    fn complete_joints(&mut self, node: &Node, rig: &mut Rig) {
        let Tree::Array(nodes) = &node.value else { return };
        // where each name was used first: of joints and channels, and as a wire of a joint
        let mut names: BTreeMap<String, usize> = BTreeMap::new();
        let mut wires: BTreeMap<String, (String, usize)> = BTreeMap::new();
        for (index, node) in nodes.iter().enumerate() {
            let before = self.problems.len();
            let Tree::Table(table) = &node.value else { continue };
            let line = |key: &str| table.get(key).map_or(node.line, |n| n.line);
            let joint = &rig.joints[index];
            if !joint.name.is_empty() {
                if rig.channel(&joint.name).is_some() {
                    let message = format!("\"{}\" is a channel's; expected a name of its own", joint.name);
                    self.problem(line("name"), None, "joint.name", What::Contradiction { message });
                }
                if let Some(&first_line) = names.get(&joint.name) {
                    let name = joint.name.clone();
                    self.problem(line("name"), None, "joint.name", What::Duplicate { name, first_line });
                }
                names.entry(joint.name.clone()).or_insert(line("name"));
            }
            for (key, name) in [("agonist", &joint.agonist), ("antagonist", &joint.antagonist)] {
                if name.is_empty() {
                    continue;
                }
                let place = format!("joint.{key}");
                if rig.channel(name).is_none() {
                    let expected = channel_choices(name, &rig.channels);
                    self.problem(line(key), None, place, What::NotAChoice { found: name.clone(), expected });
                } else if key == "antagonist" && *name == joint.agonist {
                    let message = format!("is the agonist \"{name}\" itself, expected another channel");
                    self.problem(line(key), None, place, What::Contradiction { message });
                } else if let Some((other, first)) = wires.get(name) {
                    let message = format!(
                        "is \"{name}\", which turns joint \"{other}\" already (line {first}); expected another channel"
                    );
                    self.problem(line(key), None, place, What::Contradiction { message });
                } else {
                    wires.insert(name.clone(), (joint.name.clone(), line(key)));
                }
            }
            let places = rig.channels_of(joint);
            let right = self.problems.len() == before && self.is_read(table);
            let (Some([agonist, antagonist]), true) = (places, right) else { continue };
            let models = [&rig.channels[agonist].model, &rig.channels[antagonist].model];
            if models.iter().any(|model| !model.geometry.area_m2().is_finite()) {
                continue;
            }
            let joint = &mut rig.joints[index];
            derive::fill_joint(joint, models, &|key| table.contains_key(key));
            if let Err(sinew_physics::Error::OutOfRange { key, found, low, high }) = joint.mechanics.validate(models) {
                let (found, low, high) = (tidy(found), tidy(low), tidy(high));
                let defaulted = !table.contains_key(key);
                let what = What::OutOfRange { found, low, high, defaulted };
                self.problem(line(key), None, format!("joint.{key}"), what);
            }
            let (least, kept, most) = (joint.min_tension_n, joint.tension_n, joint.max_tension_n);
            if !(least < kept && kept <= most) {
                let keys = ["tension_n", "minimum_tension_n", "maximum_tension_n", "pretension_n"];
                let key = keys.into_iter().find(|key| table.contains_key(*key)).unwrap_or("tension_n");
                let message = format!(
                    "leaves no tension: minimum_tension_n {}, tension_n {}, maximum_tension_n {}; expected them in this order",
                    tidy(least),
                    tidy(kept),
                    tidy(most)
                );
                self.problem(line(key), None, format!("joint.{key}"), What::Contradiction { message });
            }
        }
    }

    /// Whether nothing was found wrong in the lines of a joint's table.
    fn is_read(&self, table: &Table) -> bool {
        let wrong = |line: usize| self.problems.iter().any(|p| p.line == line && p.key.starts_with("joint."));
        let required = JOINT.keys.iter().filter(|key| matches!(key.default, Default::Required(_)));
        required.into_iter().all(|key| table.contains_key(key.name)) && !table.values().any(|node| wrong(node.line))
    }

    /// Keys that are required, or out of place, depending on a kind.
    fn requirements(&mut self, channel: &mut Channel, given: &Given, table: &Table, header: usize, label: &str) {
        let line_of_table = |name: &str| table.get(name).map_or(header, |n| n.line);
        if channel.model.drive.kind == DriveKind::Pwm {
            if !given.contains_key(&("drive", "supply_v")) {
                let expected = "the supply voltage in V, such as 6.0 (or another drive kind)".into();
                self.problem(line_of_table("drive"), Some(label), "drive.supply_v", What::Missing { expected });
            }
        } else if let Some(line) = given.get(&("limits", "maximum_duty")) {
            let message = "makes no sense: duty belongs to drive kind \"pwm\"; take it out or change the drive".into();
            self.problem(*line, Some(label), "limits.maximum_duty", What::Contradiction { message });
        }
        match channel.model.load {
            Load::SpringMassDamper { .. } => {
                if !given.contains_key(&("load", "mass_kg")) {
                    let expected = "the moving mass in kg, such as 0.2 (or another load kind)".into();
                    self.problem(line_of_table("load"), Some(label), "load.mass_kg", What::Missing { expected });
                }
            }
            Load::ImposedPosition | Load::ImposedForce => {
                for key in ["mass_kg", "damping_n_s_per_m", "spring_n_per_m", "preload_n"] {
                    if let Some(line) = given.get(&("load", key)) {
                        let message = "makes no sense with an imposed position or force; \
                                       take it out, or set kind = \"spring_mass_damper\""
                            .into();
                        self.problem(*line, Some(label), format!("load.{key}"), What::Contradiction { message });
                    }
                }
            }
        }
        if !matches!(channel.model.material.kinetics, Kinetics::Richards { .. }) {
            for key in ["heating_skew", "cooling_skew"] {
                if let Some(line) = given.get(&("material", key)) {
                    let message = "makes no sense without kinetics = \"richards\"; add that or take it out".into();
                    self.problem(*line, Some(label), format!("material.{key}"), What::Contradiction { message });
                }
            }
        }
        let algorithm = channel.control.algorithm;
        for (key, laws) in KEYS_OF_LAWS.iter().filter(|(key, _)| !algorithm.takes(key)) {
            if let Some(line) = given.get(&("control", *key)) {
                let (found, others) = (algorithm.word(), laws.iter().map(|law| law.word()).collect::<Vec<_>>());
                let message =
                    format!("makes no sense with algorithm = \"{found}\"; take it out or choose {}", choices(&others));
                self.problem(*line, Some(label), format!("control.{key}"), What::Contradiction { message });
            }
        }
        if channel.model.taps.is_none()
            && table.get("taps").is_none()
            && channel.control.sensing == Sensing::Dual
            && let Some(line) = given.get(&("control", "sensing"))
        {
            let message = "is \"dual\" but there is no [channel.taps]; add the taps or use \"resistance\"".into();
            self.problem(*line, Some(label), "control.sensing", What::Contradiction { message });
        }
    }

    /// What the physics finds wrong with the model, at the line of the key it names.
    fn physics(&mut self, channel: &Channel, given: &Given, header: usize, label: &str) {
        let Err(error) = channel.model.validate() else { return };
        let sinew_physics::Error::OutOfRange { key, found, low, high } = error;
        let place = given.iter().find(|((_, k), _)| *k == key);
        let table = place.map(|((t, _), _)| *t).or_else(|| schema::tables_with(key).first().map(|t| local(t)));
        let path = table.map_or(key.to_string(), |t| format!("{t}.{key}"));
        let line = place.map_or(header, |(_, line)| *line);
        let what =
            What::OutOfRange { found: tidy(found), low: tidy(low), high: tidy(high), defaulted: place.is_none() };
        self.problem(line, Some(label), path, what);
    }

    /// Limits and ranges that stand against each other.
    fn relations(&mut self, channel: &Channel, given: &Given, header: usize, label: &str) {
        let mut contradiction = |keys: &[(&'static str, &'static str)], message: String| {
            let found = keys.iter().find_map(|k| given.get(k).map(|line| (*k, *line)));
            let ((table, key), line) = found.unwrap_or((keys[0], header));
            self.problem(line, Some(label), format!("{table}.{key}"), What::Contradiction { message });
        };
        let Channel { limits, adc, control, model, .. } = channel;
        if limits.min_length_m >= limits.max_length_m {
            contradiction(
                &[("limits", "minimum_length_mm"), ("limits", "maximum_length_mm")],
                format!(
                    "leaves no length: minimum_length_mm is {}, maximum_length_mm {}; expected the minimum below the maximum",
                    tidy(limits.min_length_m * 1e3),
                    tidy(limits.max_length_m * 1e3)
                ),
            );
        }
        if limits.max_temperature_c <= model.ambient_c {
            let (hottest, ambient) = (limits.max_temperature_c, model.ambient_c);
            contradiction(
                &[("limits", "maximum_temperature_c")],
                format!("is {hottest}, expected more than the ambient temperature, {ambient}"),
            );
        }
        if let (Some(least), Some(most)) = (limits.min_force_n, limits.max_force_n)
            && least >= most
        {
            contradiction(
                &[("limits", "minimum_force_n"), ("limits", "maximum_force_n")],
                format!(
                    "leaves no tension: minimum_force_n is {least}, maximum_force_n {most}; expected the minimum below the maximum"
                ),
            );
        }
        if limits.lease_s > limits.max_lease_s {
            contradiction(
                &[("limits", "default_hold_s"), ("limits", "maximum_hold_s")],
                format!(
                    "leaves no lease: default_hold_s {} is above maximum_hold_s {}",
                    limits.lease_s, limits.max_lease_s
                ),
            );
        }
        if model.drive.kind != DriveKind::Pwm {
            return;
        }
        if control.minimum_duty >= limits.max_duty {
            contradiction(
                &[("control", "sensing_duty"), ("limits", "maximum_duty"), ("limits", "maximum_power_w")],
                format!(
                    "leaves nothing to control with: sensing_duty {} is not below the largest duty, {}",
                    control.minimum_duty,
                    tidy(limits.max_duty)
                ),
            );
        }
        if adc.circuit == SamplingCircuit::Shared {
            shared_input(channel, &mut contradiction);
        } else if adc.current_range_a <= limits.max_current_a {
            contradiction(
                &[("adc", "current_range_a"), ("limits", "maximum_current_a")],
                format!(
                    "hides an over-current: current_range_a {} must be above maximum_current_a {}",
                    tidy(adc.current_range_a),
                    tidy(limits.max_current_a)
                ),
            );
        }
        if let Some(on) = derive::full_on(channel, limits.max_temperature_c)
            && limits.max_current_a < on.least_current_a
        {
            contradiction(
                &[("limits", "maximum_current_a")],
                format!(
                    "is {}, but this supply drives {:.3} to {:.3} A through this wire whenever it is on; expected more",
                    tidy(limits.max_current_a),
                    on.least_current_a,
                    on.largest_current_a
                ),
            );
        }
    }

    fn priors(&mut self, node: &Node, label: &str) -> BTreeMap<String, Prior> {
        let mut priors = BTreeMap::new();
        let Some(table) = self.table(node, Some(label), "priors", "[channel.priors]") else { return priors };
        for (key, node) in table {
            let path = format!("priors.{key}");
            if !parameters::is_parameter(key) {
                let known: Vec<&str> = parameters::parameters().map(|p| p.key).collect();
                let hint = match nearest(key, known.iter().copied()) {
                    Some(near) => format!(", did you mean {near}?"),
                    None if effects::in_tables().any(|e| e.id.split('.').next() == Some(key)) => {
                        "; write the name of an effect's number in quotes, such as \"thermal.draught.gain\"".into()
                    }
                    None => "; expected a numeric key of wire, taps, drive, load, initial or material, ambient_c, \
                             or a number of an effect, such as \"thermal.draught.gain\""
                        .into(),
                };
                self.problem(node.line, Some(label), path, What::Unknown { hint });
                continue;
            }
            match prior(node) {
                Ok(prior) => {
                    priors.insert(key.clone(), prior);
                }
                Err(what) => self.problem(node.line, Some(label), path, what),
            }
        }
        priors
    }

    fn effects(&mut self, node: &Node, label: &str, channel: &mut Channel) {
        let Some(table) = self.table(node, Some(label), "effects", "[channel.effects.\"ID\"]") else { return };
        for (id, node) in table {
            let path = format!("effects.\"{id}\"");
            let Some(effect) = effects::in_tables().find(|e| e.id == id) else {
                self.problem(node.line, Some(label), path, What::Unknown { hint: unknown_effect(id) });
                continue;
            };
            let Some(keys) = self.table(node, Some(label), &path, &format!("[channel.effects.\"{id}\"]")) else {
                continue;
            };
            let before = self.problems.len();
            for (key, node) in keys {
                let result = if let Some(p) = effect.parameters.iter().find(|p| p.key == key) {
                    in_range(node, p.low, p.high).map(|value| (p.set)(&mut channel.model, value))
                } else if let Some(word) = effects::words(effect).find(|word| word.key == key) {
                    match &node.value {
                        Tree::Text(text) => (word.set)(channel, Some(text)),
                        other => Err(What::WrongType { found: other.describe(), expected: "a name in quotes".into() }),
                    }
                } else {
                    let known = effect.parameters.iter().map(|p| p.key).chain(effects::words(effect).map(|w| w.key));
                    Err(What::Unknown { hint: unknown_hint(key, "", known) })
                };
                if let Err(what) = result {
                    self.problem(node.line, Some(label), format!("{path}.{key}"), what);
                }
            }
            if self.problems.len() > before || effect.is_null(&channel.model) {
                continue;
            }
            if id == effects::DRAUGHT {
                self.draught(node.line, keys, label);
            }
            if !effect.applies_to(&channel.model) {
                let message = "has nothing to act on with this drive, load and taps; take it out".into();
                self.problem(node.line, Some(label), path, What::Contradiction { message });
            }
        }
    }

    /// A draught that blows does so for a while, and only the file can say when.
    fn draught(&mut self, header: usize, keys: &Table, label: &str) {
        let path = |key: &str| format!("effects.\"{}\".{key}", effects::DRAUGHT);
        let mut times = [0.0; 2];
        for (time, (key, moment)) in times.iter_mut().zip([("start_s", "begins"), ("end_s", "ends")]) {
            match keys.get(key).map(|node| number(node, "")) {
                Some(Ok(found)) => *time = found,
                _ => {
                    let expected = format!("when it {moment}, in s from the first sample");
                    return self.problem(header, Some(label), path(key), What::Missing { expected });
                }
            }
        }
        let [start, end] = times;
        if end <= start {
            let message = format!("is {end}, expected more than start_s, {start}");
            let line = keys.get("end_s").map_or(header, |node| node.line);
            self.problem(line, Some(label), path("end_s"), What::Contradiction { message });
        }
    }

    /// Neighbours named by effects must be other channels.
    fn neighbours(&mut self, nodes: &[Node], channels: &[Channel]) {
        for (channel, node) in channels.iter().zip(nodes) {
            let Some(name) = &channel.neighbour else { continue };
            let what = if *name == channel.name {
                What::Contradiction {
                    message: "is the channel itself, expected another, or none for a body at ambient".into(),
                }
            } else if channels.iter().any(|c| c.name == *name) {
                continue;
            } else {
                What::NotAChoice { found: name.clone(), expected: channel_choices(name, channels) }
            };
            let line = line_in(node, &["effects", "thermal.neighbour", "channel"]);
            self.problem(line, Some(&channel.name), "effects.\"thermal.neighbour\".channel", what);
        }
    }

    fn recording(&mut self, node: &Node) -> ColumnMap {
        let mut columns = ColumnMap::new();
        let Some(table) = self.table(node, None, "recording", "[recording]") else { return columns };
        for (name, node) in table {
            if name != "columns" {
                let hint = unknown_hint(name, "", ["columns"]);
                self.problem(node.line, None, format!("recording.{name}"), What::Unknown { hint });
                continue;
            }
            let Some(table) = self.table(node, None, "recording.columns", "[recording.columns]") else { continue };
            for (name, node) in table {
                let path = format!("recording.columns.{name}");
                if !COLUMNS.contains(&name.as_str()) {
                    let hint = match nearest(name, COLUMNS) {
                        Some(near) => format!(", did you mean {near}?"),
                        None => format!("; the columns of a recording are {}", COLUMNS.join(", ")),
                    };
                    self.problem(node.line, None, path, What::Unknown { hint });
                } else if let Some(column) = self.column(node, &path) {
                    columns.insert(name.clone(), column);
                }
            }
        }
        columns
    }

    fn column(&mut self, node: &Node, path: &str) -> Option<Column> {
        let expected = "the foreign column's name, or { column = \"Pos\", scale = -1.0, offset = 0.0 }";
        let table = match &node.value {
            Tree::Text(column) => return Some(Column { column: column.clone(), scale: 1.0, offset: 0.0 }),
            Tree::Table(table) => table,
            other => {
                let (found, expected) = (other.describe(), expected.into());
                self.problem(node.line, None, path, What::WrongType { found, expected });
                return None;
            }
        };
        let mut column = Column { column: String::new(), scale: 1.0, offset: 0.0 };
        for (name, node) in table {
            let key = format!("{path}.{name}");
            let result = match name.as_str() {
                "column" => match &node.value {
                    Tree::Text(text) => {
                        column.column = text.clone();
                        Ok(())
                    }
                    other => Err(What::WrongType { found: other.describe(), expected: "the column's name".into() }),
                },
                "scale" => number(node, "a number other than 0").and_then(|scale| {
                    column.scale = scale;
                    if scale == 0.0 {
                        let message = "is 0, expected the factor from the foreign unit to the contract's".into();
                        return Err(What::Contradiction { message });
                    }
                    Ok(())
                }),
                "offset" => number(node, "a number").map(|offset| column.offset = offset),
                _ => Err(What::Unknown { hint: unknown_hint(name, "", ["column", "scale", "offset"]) }),
            };
            if let Err(what) = result {
                self.problem(node.line, None, key, what);
            }
        }
        if !table.contains_key("column") {
            let expected = "the foreign column's name".into();
            self.problem(node.line, None, format!("{path}.column"), What::Missing { expected });
        }
        Some(column)
    }

    fn faults(&mut self, node: &Node, channels: &[Channel]) -> Vec<SimulatedFault> {
        let Tree::Array(nodes) = &node.value else {
            let expected = "an array of tables: [[simulation.fault]], with two brackets".into();
            let what = What::WrongType { found: node.value.describe(), expected };
            self.problem(node.line, None, "simulation.fault", what);
            return Vec::new();
        };
        nodes.iter().filter_map(|node| self.fault(node, channels)).collect()
    }

    fn fault(&mut self, node: &Node, channels: &[Channel]) -> Option<SimulatedFault> {
        let table = self.table(node, None, "simulation.fault", "[[simulation.fault]]")?;
        let before = self.problems.len();
        let mut fault = SimulatedFault {
            channel: None,
            kind: FaultKind::OpenWire,
            start_s: 0.0,
            end_s: f64::INFINITY,
            value: None,
        };
        let mut seen = BTreeSet::new();
        for (name, node) in table {
            seen.insert(name.as_str());
            let result = match (name.as_str(), &node.value) {
                ("channel", Tree::Text(name)) => match channels.iter().position(|c| c.name == *name) {
                    Some(index) => {
                        fault.channel = Some(index);
                        Ok(())
                    }
                    None => Err(What::NotAChoice { found: name.clone(), expected: channel_choices(name, channels) }),
                },
                ("kind", Tree::Text(word)) => match FaultKind::ALL.iter().find(|(w, _)| w == word) {
                    Some((_, kind)) => {
                        fault.kind = *kind;
                        Ok(())
                    }
                    None => Err(not_a_choice(word, &FaultKind::ALL.map(|(w, _)| w))),
                },
                ("channel" | "kind", other) => {
                    Err(What::WrongType { found: other.describe(), expected: "text in quotes".into() })
                }
                ("start_s", _) => in_range(node, 0.0, 1e9).map(|v| fault.start_s = v),
                ("end_s", _) => in_range(node, 0.0, 1e9).map(|v| fault.end_s = v),
                ("value", _) => number(node, "a number").map(|v| fault.value = Some(v)),
                _ => Err(What::Unknown { hint: unknown_hint(name, "", FAULT_KEYS) }),
            };
            if let Err(what) = result {
                self.problem(node.line, None, format!("simulation.fault.{name}"), what);
            }
        }
        for (key, expected) in [("kind", "what breaks, such as \"open_wire\""), ("start_s", "when it begins, in s")] {
            if !seen.contains(key) {
                let what = What::Missing { expected: expected.into() };
                self.problem(node.line, None, format!("simulation.fault.{key}"), what);
            }
        }
        if self.problems.len() > before {
            return None;
        }
        let line = |key: &str| table.get(key).map_or(node.line, |n| n.line);
        if fault.end_s <= fault.start_s {
            let message = format!("is {}, expected more than start_s, {}", fault.end_s, fault.start_s);
            self.problem(line("end_s"), None, "simulation.fault.end_s", What::Contradiction { message });
        }
        if let Some(found) = fault.value {
            let what = match fault.kind.value_range() {
                None => Some(What::Contradiction { message: "makes no sense with this kind; take it out".into() }),
                Some((low, high, _)) if !(low..=high).contains(&found) => {
                    Some(What::OutOfRange { found, low, high, defaulted: false })
                }
                Some(_) if fault.kind == FaultKind::ProbeLost && found.fract() != 0.0 => {
                    Some(What::Contradiction { message: format!("is {found}, expected 1, 2 or 3") })
                }
                Some(_) if fault.kind == FaultKind::ProbeStuck && found.fract() != 0.0 => {
                    Some(What::Contradiction { message: format!("is {found}, expected 1 or 2") })
                }
                Some(_) => None,
            };
            if let Some(what) = what {
                self.problem(line("value"), None, "simulation.fault.value", what);
            }
        }
        Some(fault)
    }

    fn table<'n>(&mut self, node: &'n Node, channel: Option<&str>, key: &str, header: &str) -> Option<&'n Table> {
        if let Tree::Table(table) = &node.value {
            return Some(table);
        }
        let (found, expected) = (node.value.describe(), format!("a table: {header}"));
        self.problem(node.line, channel, key, What::WrongType { found, expected });
        None
    }
}

/// The tables that stand in `table`, of a list of paths.
fn within<'p>(paths: &[&'p str], table: &str) -> Vec<&'p str> {
    let inside = |path: &&'p str| match table {
        "" => Some(*path),
        _ => path.strip_prefix(table)?.strip_prefix('.'),
    };
    paths.iter().filter_map(inside).filter(|path| !path.is_empty() && !path.contains('.')).collect()
}

/// What stands at a path of tables, such as `sensors.noise`.
fn descend<'n>(table: &'n Table, path: &str) -> Option<&'n Node> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(first, rest)| (first, Some(rest)));
    let node = table.get(first)?;
    match (rest, &node.value) {
        (None, _) => Some(node),
        (Some(rest), Tree::Table(inner)) => descend(inner, rest),
        (Some(_), _) => None,
    }
}

/// A joint before anything is read. Numbers that only the file or a computed default can give are NaN.
fn blank_joint() -> Joint {
    Joint {
        name: String::new(),
        agonist: String::new(),
        antagonist: String::new(),
        mechanics: sinew_physics::Joint {
            radius_m: f64::NAN,
            inertia_kg_m2: f64::NAN,
            damping_n_m_s: f64::NAN,
            spring_n_m: f64::NAN,
            torque_n_m: f64::NAN,
            pretension_n: f64::NAN,
        },
        min_tension_n: f64::NAN,
        tension_n: f64::NAN,
        max_tension_n: f64::NAN,
    }
}

/// A channel before anything is read. Numbers that only the file or a computed default can give are NaN.
fn blank_channel(ambient_c: f64) -> Channel {
    Channel {
        name: String::new(),
        model: WireModel {
            geometry: Geometry { diameter_m: f64::NAN, length_m: f64::NAN },
            material: Material::default(),
            taps: None,
            drive: sinew_physics::Drive {
                kind: DriveKind::Pwm,
                supply_v: 0.0,
                shunt_ohm: 0.0,
                switch_ohm: 0.0,
                lead_ohm: 0.0,
            },
            load: schema::UNREAD_LOAD,
            initial: Initial::default(),
            ambient_c,
            effects: Effects::default(),
        },
        position_zero: PositionZero::Known,
        noise: BTreeMap::new(),
        priors: BTreeMap::new(),
        adc: Adc {
            circuit: SamplingCircuit::SeparateTaps,
            bits: 0,
            voltage_range_v: f64::NAN,
            current_range_a: f64::NAN,
            voltage_noise_v: f64::NAN,
            current_noise_a: f64::NAN,
            voltage_offset_v: f64::NAN,
            current_offset_a: f64::NAN,
            supply_noise_v: f64::NAN,
        },
        front_end_index: None,
        linux: schema::UNREAD_LINUX,
        limits: Limits {
            min_length_m: f64::NAN,
            max_length_m: f64::NAN,
            max_duty: f64::NAN,
            max_power_w: f64::NAN,
            max_current_a: f64::NAN,
            max_temperature_c: f64::NAN,
            continuous_current_a: f64::NAN,
            energy_budget_j: f64::NAN,
            energy_drain_w: f64::NAN,
            lease_s: f64::NAN,
            min_force_n: None,
            max_force_n: None,
            max_lease_s: f64::NAN,
        },
        control: Control {
            algorithm: Algorithm::TimeOptimal,
            estimator: Estimator::Fused,
            lambda_per_s: None,
            rapid_heating: RapidHeating::Off,
            heat_loss_feedforward: None,
            sensing: Sensing::Resistance,
            minimum_duty: f64::NAN,
            pi_proportional_per_m: f64::NAN,
            pi_integral_per_m_s: f64::NAN,
            pid_derivative_s_per_m: f64::NAN,
            relay_band_m: None,
        },
        neighbour: None,
    }
}

/// A key's value in SI, or what is wrong with it.
fn value<T>(key: &Key<T>, node: &Node) -> Result<Value, What> {
    match &key.kind {
        Kind::Number { scale, low, high, .. } => {
            in_range(node, *low, *high).map(|found| Value::Number(scale.to_si(found)))
        }
        Kind::Integer { low, high } => match &node.value {
            Tree::Integer(i) => match i64::try_from(*i) {
                Ok(i) if (*low..=*high).contains(&i) => Ok(Value::Integer(i)),
                _ => Err(What::OutOfRange { found: *i as f64, low: *low as f64, high: *high as f64, defaulted: false }),
            },
            other => {
                let expected = format!("a whole number, {low} to {high}");
                Err(What::WrongType { found: other.describe(), expected })
            }
        },
        Kind::Boolean => match &node.value {
            Tree::Boolean(on) => Ok(Value::Boolean(*on)),
            other => Err(What::WrongType { found: other.describe(), expected: "true or false".into() }),
        },
        Kind::Choice(words) => match &node.value {
            Tree::Text(word) if words.contains(&word.as_str()) => Ok(Value::Text(word.clone())),
            Tree::Text(word) => Err(not_a_choice(word, words)),
            other => {
                let expected = choices(words);
                Err(What::WrongType { found: other.describe(), expected })
            }
        },
        Kind::Name { longest } => match &node.value {
            Tree::Text(name) if is_name(name, *longest) => Ok(Value::Text(name.clone())),
            Tree::Text(name) => {
                let found = name.chars().take(60).flat_map(char::escape_debug).collect();
                Err(What::BadName { found, expected: format!("{NAME_RULE}, at most {longest}") })
            }
            other => Err(What::WrongType { found: other.describe(), expected: "a name in quotes".into() }),
        },
        Kind::Text { what, longest } => match &node.value {
            Tree::Text(text) if is_text(text, *longest) => Ok(Value::Text(text.clone())),
            Tree::Text(text) => {
                let found = text.chars().take(60).flat_map(char::escape_debug).collect();
                let expected = format!("{what}: text without control characters, 1 to {longest} bytes");
                Err(What::BadName { found, expected })
            }
            other => Err(What::WrongType { found: other.describe(), expected: format!("{what} in quotes") }),
        },
    }
}

/// Whether a text can name something of the operating system's.
fn is_text(text: &str, longest: usize) -> bool {
    (1..=longest).contains(&text.len()) && !text.chars().any(char::is_control)
}

/// Whether a text can be a name: it becomes part of service names, columns and commands.
fn is_name(name: &str, longest: usize) -> bool {
    name.len() <= longest
        && name.starts_with(|c: char| c.is_ascii_alphanumeric())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.'))
}

/// Any number TOML can hold: its integers have 64 bits.
fn number(node: &Node, expected: &str) -> Result<f64, What> {
    match &node.value {
        Tree::Integer(i) if i64::try_from(*i).is_err() => {
            let expected = format!("{expected}; TOML's integers have 64 bits, write a larger one with a decimal point");
            Err(What::WrongType { found: format!("{i}"), expected })
        }
        _ => any_number(node, expected),
    }
}

fn any_number(node: &Node, expected: &str) -> Result<f64, What> {
    match &node.value {
        Tree::Integer(i) => Ok(*i as f64),
        Tree::Float(f, _) if f.is_finite() => Ok(*f),
        Tree::Float(_, text) => Err(What::NotFinite { found: text.clone(), expected: expected.into() }),
        other => Err(What::WrongType { found: other.describe(), expected: expected.into() }),
    }
}

fn in_range(node: &Node, low: f64, high: f64) -> Result<f64, What> {
    let found = any_number(node, &format!("a number, {low} to {high}"))?;
    if (low..=high).contains(&found) { Ok(found) } else { Err(What::OutOfRange { found, low, high, defaulted: false }) }
}

fn prior(node: &Node) -> Result<Prior, What> {
    const EXPECTED: &str = "1 sigma, 0 or more: a number in the key's unit, or text such as \"20 %\"";
    let Tree::Text(text) = &node.value else {
        return match number(node, EXPECTED)? {
            found if found < 0.0 => Err(What::WrongType { found: node.value.describe(), expected: EXPECTED.into() }),
            sigma => Ok(Prior::Absolute(sigma)),
        };
    };
    let wrong = || What::WrongType { found: node.value.describe(), expected: EXPECTED.into() };
    let percent: f64 = text.strip_suffix('%').and_then(|t| t.trim().parse().ok()).ok_or_else(wrong)?;
    if !percent.is_finite() {
        return Err(What::NotFinite { found: format!("\"{text}\""), expected: EXPECTED.into() });
    }
    if !(0.0..=1000.0).contains(&percent) {
        return Err(What::OutOfRange { found: percent, low: 0.0, high: 1000.0, defaulted: false });
    }
    Ok(Prior::Relative(percent / 100.0))
}

fn choices(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|w| format!("\"{w}\"")).collect();
    match quoted.as_slice() {
        [one] => one.clone(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
        [] => "nothing".into(),
    }
}

pub(crate) fn not_a_choice(word: &str, words: &[&str]) -> What {
    let expected = match nearest(word, words.iter().copied()) {
        Some(near) => format!("{}; did you mean \"{near}\"?", choices(words)),
        None => choices(words),
    };
    What::NotAChoice { found: word.chars().take(60).flat_map(char::escape_debug).collect(), expected }
}

fn channel_choices(name: &str, channels: &[Channel]) -> String {
    let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).filter(|n| !n.is_empty()).collect();
    match nearest(name, names.iter().copied()) {
        Some(near) => format!("the name of a channel; did you mean \"{near}\"?"),
        None => format!("the name of a channel: {}", choices(&names)),
    }
}

/// The line of what stands at a path, or of the nearest thing above it.
fn line_in(node: &Node, path: &[&str]) -> usize {
    let mut at = node;
    for part in path {
        let Tree::Table(table) = &at.value else { break };
        let Some(next) = table.get(*part) else { break };
        at = next;
    }
    at.line
}

/// What an unknown effect was probably meant to be.
fn unknown_effect(id: &str) -> String {
    let known = sinew_physics::effects::catalogue();
    if let Some(effect) = known.clone().find(|e| e.id == id && e.home == Home::Material) {
        let keys: Vec<&str> = effect.parameters.iter().map(|p| p.key).collect();
        return format!(" here: it is part of the reference model, set {} in [channel.material]", keys.join(" and "));
    }
    if known.clone().any(|e| e.id.split('.').next() == Some(id)) {
        // [channel.effects.thermal.draught] without quotes is a table in a table.
        return " as an effect; write its id in quotes, such as [channel.effects.\"thermal.draught\"]".into();
    }
    match nearest(id, known.map(|e| e.id)) {
        Some(near) => format!(", did you mean \"{near}\"?"),
        None => "; the effects are listed in docs/effects.md".into(),
    }
}

/// What an unknown key was probably meant to be: a key of the same table, one that lives in another, or the list.
fn unknown_hint<'k>(name: &str, table: &str, keys: impl IntoIterator<Item = &'k str>) -> String {
    let keys: Vec<&str> = keys.into_iter().collect();
    // What a sensor's noise is called after belongs elsewhere by that name, but is not what was meant here.
    let elsewhere = schema::tables_with(name);
    if !table.is_empty()
        && table != schema::NOISE
        && let Some(other) = elsewhere.iter().find(|t| **t != table)
    {
        return format!(" here: it belongs in [{other}]");
    }
    match nearest(name, keys.iter().copied()) {
        Some(near) => format!(", did you mean {near}?"),
        None if keys.len() <= 12 => format!("; expected {}", keys.join(", ")),
        None => format!("; the keys of [{table}] are listed in docs/rig.md"),
    }
}

/// A number as one would write it: conversions between units leave dust in the last digits.
fn tidy(n: f64) -> f64 {
    format!("{n:.9e}").parse().unwrap_or(n)
}

/// Table and key.
type Place = (&'static str, &'static str);

/// What one input for supply and shunt needs: something to show the current by, room for the supply, and an off-phase.
fn shared_input(channel: &Channel, contradiction: &mut dyn FnMut(&[Place], String)) {
    /// How far the current must stand clear of the input's noise, in standard deviations.
    const CLEAR: f64 = 16.0;
    let Channel { limits, adc, control, model, .. } = channel;
    let drive = &model.drive;
    let low_ohm = drive.low_ohm();
    let on_v = derive::full_on(channel, limits.max_temperature_c).map_or(0.0, |on| on.least_current_a * low_ohm);
    if on_v <= CLEAR * adc.voltage_noise_v {
        contradiction(
            &[("adc", "circuit"), ("drive", "shunt_ohm")],
            format!(
                "is \"shared\", but shunt_ohm + switch_ohm = {low_ohm} Ω show the current by {:.2} mV only, in {} mV of \
                 noise; expected more than {CLEAR} times the noise: a larger shunt, or a better converter",
                tidy(on_v * 1e3),
                tidy(adc.voltage_noise_v * 1e3)
            ),
        );
    }
    if adc.voltage_range_v <= drive.supply_v {
        contradiction(
            &[("adc", "voltage_range_v")],
            format!(
                "is {}, but the shared input sees the whole supply_v, {}; expected more",
                adc.voltage_range_v, drive.supply_v
            ),
        );
    }
    if limits.max_current_a * low_ohm >= adc.voltage_range_v {
        contradiction(
            &[("limits", "maximum_current_a")],
            format!(
                "is {}, but a shared input over {low_ohm} Ω ends at {} A; expected less",
                tidy(limits.max_current_a),
                tidy(adc.voltage_range_v / low_ohm)
            ),
        );
    }
    if limits.max_duty + control.minimum_duty > 1.0 {
        contradiction(
            &[("limits", "maximum_duty"), ("control", "sensing_duty")],
            format!(
                "leaves no off-phase to see the supply in: maximum_duty {} and sensing_duty {} must not be more than 1 together",
                limits.max_duty, control.minimum_duty
            ),
        );
    }
}
