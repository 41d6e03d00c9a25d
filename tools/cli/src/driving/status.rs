//! `sinew status`: the current state of a running driver.

use std::fmt::Write as _;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use sinew_driver::report::Quantiles;
use sinew_ipc::{ChannelState, FieldKind};

use super::live::{self, Live};
use crate::args;
use crate::driving::screen::view::{Row, View, micros, number, percent};
use crate::failure::Outcome;
use crate::output::{self, counted};

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Status<'a> {
    schema: &'static str,
    rig: &'a str,
    pid: u32,
    rate_hz: f64,
    channels: usize,
    seconds: f64,
    cycles: u64,
    missed: u64,
    age_s: f64,
    lateness_us: Quantiles,
    cycle_us: Quantiles,
    allocations_in_loop: u64,
    threads_died: Vec<&'static str>,
    rt: serde_json::Map<String, serde_json::Value>,
    channel: Vec<Channel<'a>>,
}

/// One channel; what is not known is `null`.
#[derive(Debug)]
struct Channel<'a> {
    row: &'a Row,
    age_s: f64,
}

/// The keys of a channel as they have always stood; a field that the table adds comes behind them.
const KEYS: [&str; 14] = [
    "name",
    "mode",
    "length_m",
    "observed_length_m",
    "target_m",
    "stroke",
    "duty",
    "fault",
    "age_s",
    "temperature_c",
    "martensite",
    "resistance_ohm",
    "power_w",
    "lease_s",
];

impl Serialize for Channel<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let added = ChannelState::FIELDS.iter().filter(|field| field.in_status).map(|field| field.name);
        let keys = KEYS.into_iter().chain(added.filter(|name| !KEYS.contains(name)));
        let mut map = serializer.serialize_map(None)?;
        for key in keys {
            match (key, ChannelState::field(key)) {
                ("name", _) => map.serialize_entry(key, &self.row.name)?,
                ("mode", _) => map.serialize_entry(key, self.row.mode())?,
                ("stroke", _) => map.serialize_entry(key, &self.row.stroke())?,
                ("fault", _) => map.serialize_entry(key, &self.row.fault.map(|fault| fault.flag))?,
                ("age_s", _) => map.serialize_entry(key, &self.age_s)?,
                (_, Some(field)) => match field.kind {
                    FieldKind::Float => map.serialize_entry(key, &field.of(&self.row.state))?,
                    FieldKind::Code => map.serialize_entry(key, &(field.of(&self.row.state) as u32))?,
                },
                (_, None) => {}
            }
        }
        map.end()
    }
}

/// Runs the command.
pub fn status(args: &args::Status) -> Outcome {
    let view = Live::new(live::connect(&args.target)?).look();
    match args.json {
        true => output::print_json(&of(&view)),
        false => output::print(text(&view)),
    }
}

fn of(view: &View) -> Status<'_> {
    let channel = view.channels.iter().map(|row| Channel { row, age_s: view.age_s });
    let rt = view.timing.realtime.iter().map(|(name, granted)| (name.replace(' ', "_"), (*granted).into()));
    Status {
        schema: "sinew.status/1",
        rig: &view.rig,
        pid: view.pid,
        rate_hz: view.rate_hz,
        channels: view.channels.len(),
        seconds: view.uptime_s,
        cycles: view.cycle,
        missed: view.timing.missed,
        age_s: view.age_s,
        lateness_us: view.timing.lateness_us,
        cycle_us: view.timing.cycle_us,
        allocations_in_loop: view.timing.allocations,
        threads_died: view.timing.dead.iter().map(|row| row.name).collect(),
        rt: rt.collect(),
        channel: channel.collect(),
    }
}

fn text(view: &View) -> String {
    let q = view.timing.lateness_us;
    let mut text = format!(
        "rig {}  pid {}  {} at {} Hz for {:.1} s\ncycles {}  missed {}  late µs p50 {} p99 {} p999 {} max {}\n\n",
        view.rig,
        view.pid,
        counted(view.channels.len(), "channel"),
        view.rate_hz,
        view.uptime_s,
        view.cycle,
        view.timing.missed,
        micros(q.p50),
        micros(q.p99),
        micros(q.p999),
        micros(q.max),
    );
    if let Some(stands) = view.stands_still() {
        let _ = writeln!(text, "{stands}\n");
    }
    if let Some(lacks) = view.lacks() {
        let _ = writeln!(text, "{lacks}\n");
    }
    let width = view.channels.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max(7);
    let _ = writeln!(
        text,
        "{:<width$} mode     {:>8} {:>8} {:>4} {:>5} {:>7} {:>5} {:>5} {:>6}  fault",
        "channel", "mm", "→ mm", "%", "duty", "Ω", "≈°C", "≈ξ", "W"
    );
    for row in &view.channels {
        let _ = writeln!(
            text,
            "{:<width$} {:<8} {} {} {:>4} {} {} {} {} {}  {}",
            row.name,
            row.mode(),
            number(row.state.length_m * 1e3, 8, 3),
            number(row.state.target_m * 1e3, 8, 3),
            percent(row.stroke()),
            number(row.state.duty, 5, 3),
            number(row.state.resistance_ohm, 7, 3),
            number(row.state.temperature_c, 5, 1),
            number(row.state.martensite, 5, 2),
            number(row.state.power_w, 6, 3),
            match (row.fault, row.held_by) {
                (Some(fault), _) => fault.flag.to_string(),
                (None, Some(held)) => format!("– (held back by {})", held.by()),
                (None, None) => "–".into(),
            },
        );
    }
    for row in &view.channels {
        if let Some(owner) = row.owner() {
            let _ = write!(text, "\n{}: claimed by {owner}\n", row.name);
        }
    }
    if let Some((name, fault)) = view.first_of_several() {
        let _ = write!(text, "\nfirst: {name}, {}\n", fault.flag);
    }
    for row in view.channels.iter() {
        if let Some(fault) = row.fault {
            let _ = write!(text, "\n{}: {}\n  {}\n", row.name, fault.cause, fault.remedy);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driving::screen::view::tests::hexapod;

    #[test]
    fn unknown_numbers_are_null_in_json_and_dashes_in_text() {
        let mut view = hexapod(8);
        (view.channels[0].state.length_m, view.channels[0].state.measured_length_m) = (f64::NAN, f64::NAN);
        let json: serde_json::Value = serde_json::from_str(&output::json(&of(&view)).unwrap()).unwrap();
        assert_eq!(json["schema"], "sinew.status/1");
        assert!(json["channel"][0]["length_m"].is_null());
        assert!(json["channel"][0]["measured_length_m"].is_null());
        assert!(json["channel"][1]["length_m"].is_f64());
        assert_eq!(json["channel"][1]["observed_length_m"], json["channel"][1]["length_m"], "its name of once");
        assert_eq!(json["channel"][6]["fault"], "open_wire");
        assert!(json["channel"][0]["fault"].is_null());
        for key in ["age_s", "temperature_c", "martensite", "resistance_ohm", "power_w", "duty"] {
            assert!(json["channel"][1][key].is_f64(), "{key}");
        }
        let text = text(&view);
        assert!(!text.contains("NaN"), "{text}");
        assert!(text.contains("check the wire"), "{text}");
        assert!(!text.contains("nothing new"), "{text}");
        view.age_s = 3.25;
        let text = super::text(&view);
        assert!(text.contains("nothing new for 3.2 s: the loop stands still"), "{text}");
        assert!(view.plain_line().contains("nothing new for 3.2 s"), "{}", view.plain_line());
    }
}
