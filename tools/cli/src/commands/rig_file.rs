//! `sinew check` and `sinew schema`: a rig file on its own.

use std::fmt::Write as _;

use serde::Serialize;
use sinew_control::StrokeRange;
use sinew_rig::{Channel, Doubt, Rig};

use super::load_rig_with;
use crate::args;
use crate::failure::Outcome;
use crate::output;

/// Version of the JSON.
const CHECK: &str = "sinew.check/1";

/// What a rig file says, where it is right.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    file: &'a str,
    rig: &'a str,
    rate_hz: f64,
    backend: &'static str,
    /// Why `sinew run` refuses it all the same; null where it does not.
    not_driven: Option<String>,
    /// What is allowed and hardly meant.
    doubts: Vec<Doubted>,
    channel: Vec<Wire<'a>>,
}

/// A number that is allowed and hardly meant.
#[derive(Debug, Serialize)]
struct Doubted {
    line: usize,
    channel: String,
    key: &'static str,
    says: String,
}

impl From<Doubt> for Doubted {
    fn from(Doubt { line, channel, key, says }: Doubt) -> Doubted {
        Doubted { line, channel, key, says }
    }
}

/// One wire in short; what cannot be worked out is null.
#[derive(Debug, Serialize)]
struct Wire<'a> {
    name: &'a str,
    diameter_mm: f64,
    length_mm: f64,
    stroke_mm: Option<f64>,
    maximum_current_a: f64,
    maximum_temperature_c: f64,
}

impl Wire<'_> {
    fn of<'a>(rig: &Rig, index: usize, channel: &'a Channel) -> Wire<'a> {
        let stroke = StrokeRange::of(&rig.nominal_model(index)).ok().map(|range| range.stroke_m() * 1e3);
        let geometry = channel.model.geometry;
        Wire {
            name: &channel.name,
            diameter_mm: geometry.diameter_m * 1e3,
            length_mm: geometry.length_m * 1e3,
            stroke_mm: stroke.filter(|stroke| stroke.is_finite()),
            maximum_current_a: channel.limits.max_current_a,
            maximum_temperature_c: channel.limits.max_temperature_c,
        }
    }
}

/// `sinew check`.
pub fn check(args: &args::Check) -> Outcome {
    let rig = load_rig_with(Some(&args.rig), &args.laws)?;
    // what moves it without anybody's command belongs to it: a mistake there is one here
    #[cfg(driver)]
    crate::driving::program(&rig)?;
    let answer = Answer {
        schema: CHECK,
        file: rig.file(),
        rig: &rig.name,
        rate_hz: rig.rate_hz,
        backend: rig.backend.kind.word(),
        not_driven: rig.check_drivable().err().map(|error| error.to_string()),
        doubts: rig.doubts().into_iter().map(Doubted::from).collect(),
        channel: rig.channels.iter().enumerate().map(|(index, channel)| Wire::of(&rig, index, channel)).collect(),
    };
    if args.json { output::print_json(&answer) } else { output::print(text(&answer)) }
}

fn text(answer: &Answer<'_>) -> String {
    let Answer { file, rig, rate_hz, backend, not_driven, doubts, channel, .. } = answer;
    let wires = if channel.len() == 1 { "wire" } else { "wires" };
    let mut text = format!("{file}: right. Rig {rig}: {} {wires} at {rate_hz} Hz, {backend}\n\n", channel.len());
    let width = channel.iter().map(|wire| wire.name.chars().count()).max().unwrap_or(0).max(7);
    // writing to a String cannot fail
    let _ = writeln!(
        text,
        "{:<width$}  {:>8}  {:>8}  {:>9}  {:>6}  {:>6}",
        "channel", "⌀ mm", "mm", "stroke mm", "≤ A", "≤ °C"
    );
    for wire in channel {
        let stroke = wire.stroke_mm.map_or("–".into(), |stroke| format!("{stroke:.2}"));
        let _ = writeln!(
            text,
            "{:<width$}  {:>8}  {:>8}  {stroke:>9}  {:>6.2}  {:>6.0}",
            wire.name,
            shown(wire.diameter_mm),
            shown(wire.length_mm),
            wire.maximum_current_a,
            wire.maximum_temperature_c
        );
    }
    if !doubts.is_empty() {
        text.push_str("\nIs this meant?\n");
    }
    for Doubted { line, channel, key, says } in doubts {
        let _ = writeln!(text, "{file}:{line}: channel \"{channel}\": {key}: {says}");
    }
    if let Some(why) = not_driven {
        let _ = writeln!(text, "\nIt can be simulated and fitted; `sinew run` refuses it:\n{why}");
    }
    text
}

/// A number of millimetres, without the digits that inches leave.
fn shown(number: f64) -> f64 {
    (number * 1e4).round() / 1e4
}

/// `sinew schema`.
pub fn schema(_: &args::Schema) -> Outcome {
    output::print_json(&sinew_rig::schema())
}
