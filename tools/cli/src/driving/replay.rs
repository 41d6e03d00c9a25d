//! `sinew replay`: the driver's cycle run again over a recording, and the differences.

use std::fmt::Write as _;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use serde::Serialize;
use sinew_recorder::layout;
use sinew_recording::Part;
use sinew_recording::session::{About, Ended, Head, Session, SessionWriter, WriteOptions};
use sinew_replay::{Difference, Error, Replay, SessionSource, encode};
use sinew_rig::Rig;
use toml_edit::{DocumentMut, Item, Value};

use crate::args;
use crate::commands::export::spare;
use crate::commands::simulate::recording_failure;
use crate::commands::{load_rig, rig_failure, unknown_channel};
use crate::failure::{Failure, Outcome};
use crate::output::{self, counted};
use crate::progress::Progress;

/// Runs the command.
pub fn replay(args: &args::Replay) -> Outcome {
    if let Some(output) = &args.output {
        output::has_place(output)?;
        spare(output, &args.recording)?;
    }
    let session = Session::open(&args.recording).map_err(recording_failure)?;
    let rig = rig_of(args, &session)?;
    let source = SessionSource::new(&args.recording, &session).map_err(replay_failure)?;
    let mut replay = Replay::new(&rig, source).map_err(replay_failure)?;
    let mut written = match &args.output {
        Some(path) => Some(Written::create(path, &args.recording, &session, &rig)?),
        None => None,
    };

    let progress = Progress::new();
    let all = session.cycle_count().max(1);
    let mut seen = 0u64;
    loop {
        let cycle = replay.cycle(|_| {}).map_err(|error| {
            progress.clear();
            replay_failure(error)
        })?;
        let Some((_, now)) = cycle else { break };
        if let Some(written) = &mut written {
            let head = Head { cycle: now.cycle, monotonic_ns: now.monotonic_ns, missed: now.missed };
            encode(now.channels(), &mut written.bytes);
            written.writer.cycle(&head, &written.bytes).map_err(recording_failure)?;
        }
        seen += 1;
        if seen.is_multiple_of(1024) {
            progress.tell("replaying", seen as f64 / all as f64);
        }
    }
    progress.clear();
    if let Some(written) = written {
        written.finish()?;
    }
    if seen == 0 {
        return Err(Failure::input(format!("{}: has no cycle", session.name()))
            .hint("record again, and let the driver run meanwhile"));
    }

    let report = Report::of(&replay, &session, &rig);
    if args.json {
        output::print_json(&report)?;
    } else {
        output::print(report.text())?;
    }
    match args.expect_identical && !report.identical {
        true => Err(Failure::own("the replay differs from the recording").hint("what differs is listed above")),
        false => Ok(()),
    }
}

/// What the recording is replayed under: its own rig file or another one, with what was set.
fn rig_of(args: &args::Replay, session: &Session) -> Result<Rig, Failure> {
    let rig = match (&args.rig, &session.about().rig_toml) {
        (Some(path), _) => load_rig(Some(path))?,
        (None, Some(text)) => {
            Rig::parse(text, &format!("{}/rig.toml", session.name())).map_err(|error| rig_failure(&error))?
        }
        (None, None) => {
            return Err(Failure::input(format!("{}: has no rig file in it", session.name()))
                .hint("give the one it was recorded with: sinew replay RECORDING.mcap RIG.toml"));
        }
    };
    if args.settings.is_empty() {
        return Ok(rig);
    }
    let names: Vec<&str> = rig.channels.iter().map(|channel| channel.name.as_str()).collect();
    let mut text = rig.text().to_string();
    for setting in &args.settings {
        text = set(&text, &names, setting)?;
    }
    Rig::parse(&text, &format!("{} with --set", rig.file())).map_err(|error| rig_failure(&error))
}

/// The text of a rig file with one key changed.
fn set(text: &str, channels: &[&str], setting: &str) -> Result<String, Failure> {
    let wrong = || {
        Failure::input(format!("--set {setting}: is no KEY=VALUE"))
            .hint("as in control.algorithm=pid, limits.maximum_duty=0.3 or front_left_femur:control.estimator=enthalpy")
    };
    let (path, value) = setting.split_once('=').ok_or_else(wrong)?;
    let (only, path) = match path.split_once(':') {
        Some((channel, path)) => (Some(channel.trim()), path),
        None => (None, path),
    };
    let keys: Vec<&str> = path.trim().split('.').collect();
    let Some((key, tables)) = keys.split_last().filter(|(_, tables)| !tables.is_empty()) else { return Err(wrong()) };
    if keys.iter().any(|key| key.is_empty()) {
        return Err(wrong());
    }
    // a word needs no quotes on a command line
    let value = value.trim();
    let value: Value = value.parse().unwrap_or_else(|_| Value::from(value));
    if let Some(only) = only
        && !channels.contains(&only)
    {
        return Err(unknown_channel("--set", only, channels.iter().copied()));
    }
    // it was read as a rig file already
    let mut document: DocumentMut = text.parse().map_err(|error| Failure::own(format!("rig.toml: {error}")))?;
    let put = |item: &mut Item| -> Option<()> {
        let mut at = item;
        for table in tables {
            at = at.as_table_like_mut()?.entry(table).or_insert_with(|| Item::Table(toml_edit::Table::new()));
        }
        at.as_table_like_mut()?.insert(key, Item::Value(value.clone()));
        Some(())
    };
    let done = if only.is_none() && ["rig", "simulation"].contains(&tables[0]) {
        put(document.as_item_mut())
    } else {
        let Some(wires) = document.get_mut("channel").and_then(Item::as_array_of_tables_mut) else {
            return Err(wrong());
        };
        wires.iter_mut().enumerate().try_for_each(|(index, wire)| {
            if only.is_some_and(|only| channels.get(index) != Some(&only)) {
                return Some(());
            }
            let mut item = Item::Table(std::mem::take(wire));
            let done = put(&mut item);
            if let Item::Table(table) = item {
                *wire = table;
            }
            done
        })
    };
    done.ok_or_else(|| {
        Failure::input(format!("--set {setting}: {} is no table of the rig file", tables.join(".")))
            .hint("docs/rig.md has every table and key")
    })?;
    Ok(document.to_string())
}

/// A replay on its way into a session.
struct Written {
    writer: SessionWriter<BufWriter<File>>,
    part: Part,
    bytes: Vec<u8>,
}

impl Written {
    fn create(path: &Path, recording: &Path, session: &Session, rig: &Rig) -> Result<Written, Failure> {
        let unwritable = |error: std::io::Error| Failure::own(format!("{}: {error}", path.display()));
        let layout = layout(rig.channels.iter().map(|channel| channel.name.clone()).collect())
            .map_err(|trouble| Failure::input(format!("{}: {trouble}", rig.file())))?;
        let mut about = About {
            rig: rig.name.clone(),
            software: concat!("sinew ", env!("CARGO_PKG_VERSION")).into(),
            rig_toml: Some(rig.text().to_string()),
            ..session.about().clone()
        };
        about
            .extra
            .insert("replay_of".into(), recording.file_name().unwrap_or_default().to_string_lossy().into_owned());
        let (part, file) = Part::create(path).map_err(unwritable)?;
        let options = WriteOptions::new(path.to_string_lossy());
        let writer =
            SessionWriter::create(BufWriter::new(file), &about, &layout, options).map_err(recording_failure)?;
        Ok(Written { writer, part, bytes: Vec::new() })
    }

    fn finish(self) -> Outcome {
        let sink = self.writer.finish(Ended::Complete).map_err(recording_failure)?;
        let file = sink.into_inner().map_err(|error| Failure::own(error.error()))?;
        self.part.publish(&file).map_err(Failure::own)
    }
}

/// Why there is no replay, with the remedy.
fn replay_failure(error: Error) -> Failure {
    match error {
        Error::Recording(error) => recording_failure(error),
        Error::Lacks { .. } => Failure::input(error).hint("`sinew record` writes recordings that can be replayed"),
        Error::Channels { .. } => Failure::input(error)
            .hint("give the rig file it was recorded with, changed or not; without one, its own is taken"),
        Error::Died(_) => Failure::own(error).hint("replay it again, and please report this"),
        Error::Driver(_) => Failure::input(error).hint("docs/rig.md has what a driver needs of a rig"),
    }
}

/// What a replay came to.
#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    recording: String,
    rig: String,
    /// What wrote the recording, and what replays it.
    recorded_by: String,
    replayed_by: &'static str,
    cycles: u64,
    first_cycle: u64,
    lost: u64,
    first_lost: Option<u64>,
    identical: bool,
    channel: Vec<ChannelReport>,
}

#[derive(Debug, Serialize)]
struct ChannelReport {
    name: String,
    /// Fields that differ; none where all is bit for bit the same.
    fields: Vec<FieldReport>,
}

#[derive(Debug, Serialize)]
struct FieldReport {
    field: &'static str,
    unit: &'static str,
    cycles: u64,
    /// Cycles in which only one of the two is a number.
    only_one: u64,
    max: f64,
    rms: f64,
    first: First,
}

#[derive(Debug, Serialize)]
struct First {
    cycle: u64,
    time_s: f64,
    recorded: f64,
    replayed: f64,
}

impl Report {
    fn of(replay: &Replay<SessionSource>, session: &Session, rig: &Rig) -> Report {
        let (comparison, complete) = (replay.comparison(), replay.completeness());
        let channel = rig.channels.iter().enumerate().map(|(index, channel)| ChannelReport {
            name: channel.name.clone(),
            fields: comparison
                .of_channel(index)
                .map(|(field, difference)| {
                    let Difference { cycles, max, rms, only_one, first } = difference;
                    let first = First {
                        cycle: first.cycle,
                        time_s: first.time_s,
                        recorded: first.recorded,
                        replayed: first.replayed,
                    };
                    FieldReport { field: field.name, unit: field.unit, cycles, only_one, max, rms, first }
                })
                .collect(),
        });
        Report {
            schema: "sinew.replay/1",
            recording: session.name().into(),
            rig: rig.file().into(),
            recorded_by: session.about().software.clone(),
            replayed_by: concat!("sinew ", env!("CARGO_PKG_VERSION")),
            cycles: comparison.cycles(),
            first_cycle: complete.first_cycle,
            lost: complete.lost,
            first_lost: complete.first_lost,
            identical: comparison.is_identical(),
            channel: channel.collect(),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let channels = self.channel.len();
        let _ = writeln!(
            text,
            "{}: {} cycles of {}, under {}",
            self.recording,
            self.cycles,
            counted(channels, "channel"),
            self.rig
        );
        if self.first_cycle != 1 {
            let _ = writeln!(
                text,
                "  begins with cycle {} of the driver's: what it had learnt until then is not known, so that estimates and duties differ at first",
                self.first_cycle
            );
        }
        if let Some(first) = self.first_lost {
            let _ =
                writeln!(text, "  {} cycles were lost, the first is {first}: from there on it is not exact", self.lost);
        }
        if self.identical {
            let _ = writeln!(text, "identical: every field of every channel, bit for bit");
            return text;
        }
        let same = self.channel.iter().filter(|channel| channel.fields.is_empty()).count();
        let _ = writeln!(text, "{:<22} {:<18} {:>9} {:>11} {:>11}  first", "channel", "field", "cycles", "max", "rms");
        for channel in &self.channel {
            for row in &channel.fields {
                let First { cycle, time_s, recorded, replayed } = row.first;
                let _ = writeln!(
                    text,
                    "{:<22} {:<18} {:>9} {:>11} {:>11}  {time_s:.3} s (cycle {cycle}): {} then, {} now{}",
                    channel.name,
                    row.field,
                    row.cycles,
                    short(row.max),
                    short(row.rms),
                    short(recorded),
                    short(replayed),
                    if row.unit.is_empty() { String::new() } else { format!(" {}", row.unit) },
                );
            }
        }
        if same > 0 {
            let _ = writeln!(text, "{same} of {} the same bit for bit", counted(channels, "channel"));
        }
        let _ = writeln!(
            text,
            "The recorded wire does not answer to another duty: it goes on as it was heated then. What it would have done, only a simulation can say."
        );
        text
    }
}

/// A number in few digits; a dash where there is none.
fn short(value: f64) -> String {
    match value {
        v if v.is_nan() => "-".into(),
        0.0 => "0".into(),
        v if v.fract() == 0.0 && v.abs() < 1e6 => format!("{v}"),
        v if (1e-3..1e6).contains(&v.abs()) => format!("{v:.5}"),
        v => format!("{v:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    const RIG: &str = "[rig]\nname = \"two\"\nrate_hz = 1000.0\n\n[[channel]]\nname = \"a\"  # kept\n[channel.wire]\n\
        diameter_mm = 0.125\n\n[[channel]]\nname = \"b\"\nwire = { diameter_mm = 0.1 }\n";

    #[test]
    fn a_key_is_set_in_every_channel_or_in_one() {
        let set = |setting: &str| super::set(RIG, &["a", "b"], setting).unwrap();
        assert_eq!(set("control.algorithm=pid").matches("algorithm = \"pid\"").count(), 2);
        let one = set("b:wire.diameter_mm=0.15");
        assert!(one.contains("diameter_mm = 0.125\n") && one.contains("diameter_mm = 0.15 "), "{one}");
        assert!(one.contains("# kept"));
        assert!(set("rig.rate_hz=500.0").contains("rate_hz = 500.0"));
        assert!(set("a:limits.maximum_duty=0.3").contains("[channel.limits]\nmaximum_duty = 0.3"));
    }

    #[test]
    fn what_is_no_setting_is_refused_with_an_example() {
        for bad in ["control.algorithm", "algorithm=pid", "=3", "a..b=3", "wire.diameter_mm.x=3"] {
            let failure = super::set(RIG, &["a", "b"], bad).expect_err(bad);
            assert_eq!(failure.code(), 2, "{bad}");
            assert!(failure.to_string().contains("hint: "), "{failure}");
        }
        assert!(
            super::set(RIG, &["a", "b"], "c:wire.diameter_mm=1").unwrap_err().to_string().contains("no channel \"c\"")
        );
    }
}
