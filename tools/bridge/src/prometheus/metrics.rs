//! Every metric: its name, unit, labels and meaning, and how it is read off a driver.
//!
//! What a channel publishes is exported by the table that says what there is, [`ChannelState::FIELDS`]: a field that is added
//! there becomes a metric here. Names follow Prometheus: base units at their end, `_total` at that of a counter. Labels are the
//! rig, the channel, and names of which there is a fixed number, so that a driver never has more than a few thousand series.

use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

use prometheus_client::collector::Collector;
use prometheus_client::encoding::{DescriptorEncoder, NoLabelSet, text};
use prometheus_client::metrics::MetricType;
use prometheus_client::registry::{Registry, Unit};
use sinew_ipc::{
    ChannelField, ChannelInfo, ChannelState, Client, DriverHealth, FAULT_TABLE, FieldKind, Histogram, Info, LoopStats,
    Mode, PROTOCOL, Snapshot,
};

/// The units of fields: as the table of fields has them, at the end of a field's name, and in words as Prometheus wants them.
const UNITS: [(&str, &str, &str); 9] = [
    ("m", "_m", "meters"),
    ("m/s", "_m_s", "meters_per_second"),
    ("m/s²", "_m_s2", "meters_per_second_squared"),
    ("Ω", "_ohm", "ohms"),
    ("°C", "_c", "celsius"),
    ("W", "_w", "watts"),
    ("s", "_s", "seconds"),
    ("V", "_v", "volts"),
    ("A", "_a", "amperes"),
];
/// Fields that are shares of something. Others without a unit have one that changes, and are no metric.
const SHARES: [&str; 2] = ["duty", "martensite"];
/// Bounds of a histogram's buckets, as powers of two and the halves between, in ns: 1 µs to 1 s.
const OCTAVES: std::ops::RangeInclusive<u32> = 10..=30;
/// Shares of all durations for which the longest is given.
const QUANTILES: [(&str, f64); 3] = [("0.5", 0.5), ("0.99", 0.99), ("0.999", 0.999)];
/// What a driver may be doing.
const STATES: [&str; 4] = ["gone", "starting", "running", "stalled"];

/// What follows from a channel's description and state, beside the fields: the metric's name, its unit, what it means, its value.
type Derived = (&'static str, Option<&'static str>, &'static str, fn(&ChannelInfo, &ChannelState) -> f64);
const DERIVED: [Derived; 8] = [
    ("stroke", Some("ratio"), "Share of the stroke at the present length, 0 cold to 1 hot.", |info, state| {
        info.stroke_at_length(state.length_m)
    }),
    ("min_length", Some("meters"), "Shortest length that may be asked for.", |info, _| info.min_length_m),
    ("max_length", Some("meters"), "Longest length that may be asked for.", |info, _| info.max_length_m),
    ("max_duty", Some("ratio"), "Largest duty.", |info, _| info.max_duty),
    ("max_power", Some("watts"), "Largest mean power.", |info, _| info.max_power_w),
    ("max_temperature", Some("celsius"), "Highest estimated temperature.", |info, _| info.max_temperature_c),
    ("sample_good", None, "Whether the present sample is good: 1, else 0.", |_, state| flag(state.health == 0)),
    ("claimed", None, "Whether a client has claimed the channel: 1, else 0.", |_, state| flag(state.owner != 0)),
];

type Labels<'a> = Vec<(&'static str, &'a str)>;

/// A driver at one moment.
#[derive(Debug)]
pub struct Look {
    /// One of [`STATES`].
    state: &'static str,
    /// What there is of it; nothing while it is gone.
    seen: Option<Box<Seen>>,
}

#[derive(Debug)]
struct Seen {
    info: Info,
    snapshot: Snapshot,
    stats: LoopStats,
    age_s: f64,
}

impl Look {
    /// At this driver, or at none.
    pub fn at(client: Option<&Client>) -> Look {
        let gone = Look { state: "gone", seen: None };
        let Some(client) = client else { return gone };
        let state = match client.health() {
            DriverHealth::Stopped | DriverHealth::Died => return gone,
            health => health.name(),
        };
        let (snapshot, stats) = (client.latest(), client.loop_stats());
        let seen = Seen { info: *client.info(), snapshot, stats, age_s: client.age().as_secs_f64() };
        Look { state, seen: Some(Box::new(seen)) }
    }
}

/// What there is to scrape of a rig.
pub fn registry(rig: &str, look: Look) -> Registry {
    let labels = [("rig".into(), rig.to_string().into())];
    let mut registry = Registry::with_prefix_and_labels("sinew", labels.into_iter());
    registry.register_collector(Box::new(look));
    registry
}

impl Collector for Look {
    fn encode(&self, mut out: DescriptorEncoder) -> fmt::Result {
        let up = self.state == "running";
        gauge(&mut out, "up", None, "1 while the driver's loop runs, else 0.", [(vec![], flag(up))])?;
        let states = STATES.iter().map(|state| (vec![("state", *state)], flag(*state == self.state)));
        gauge(&mut out, "driver_state", None, "What the driver is doing: 1 for the one state it is in.", states)?;
        let Some(seen) = &self.seen else { return Ok(()) };
        seen.driver(&mut out)?;
        seen.timing(&mut out)?;
        // what was last published is no state of now once the loop stands still
        if up { seen.channels(&mut out) } else { Ok(()) }
    }
}

impl Seen {
    /// What the driver is and has done.
    fn driver(&self, out: &mut DescriptorEncoder<'_>) -> fmt::Result {
        let Seen { info, snapshot, stats, age_s } = self;
        let (protocol, version) = (info.protocol.to_string(), env!("CARGO_PKG_VERSION"));
        let simulated = if info.simulated != 0 { "true" } else { "false" };
        let labels: Labels = vec![("simulated", simulated), ("protocol", &protocol), ("bridge_version", version)];
        let help = "What the driver is: its wires are simulated or real, the protocol of its messages, the version of the bridge.";
        out.encode_descriptor("driver", help, None, MetricType::Info)?.encode_info(&labels)?;
        let up_s = snapshot.monotonic_ns.saturating_sub(info.started_ns) as f64 * 1e-9;
        for (name, unit, help, value) in [
            ("rate", "hertz", "Rate of the loop by the rig file.", info.rate_hz),
            ("uptime", "seconds", "From the driver's start to its latest cycle.", up_s),
            ("state_age", "seconds", "Age of the latest cycle: a loop that stands still lets it grow.", *age_s),
        ] {
            gauge(out, name, Some(unit), help, [(vec![], value)])?;
        }
        let dead = stats.dead_threads().count() as f64;
        gauge(
            out,
            "dead_threads",
            None,
            "Threads of the driver that have died, without which it goes on.",
            [(vec![], dead)],
        )?;
        let means =
            LoopStats::REALTIME.iter().map(|(bit, name)| (vec![("means", *name)], flag(stats.realtime & bit != 0)));
        gauge(out, "realtime_granted", None, "Whether Linux granted a means of real time: 1, else 0.", means)?;
        for (name, help, value) in [
            ("cycles", "Cycles that ran.", stats.cycles),
            ("missed_periods", "Periods without a cycle because the loop was late.", stats.missed),
            ("overruns", "Cycles that took longer than a period.", stats.overruns),
            ("unpublished_cycles", "Cycles no stream could get.", stats.ring_drops),
            ("loop_allocations", "Allocations inside the loop; 0 unless something is wrong.", stats.allocations),
            ("commands", "Commands taken.", stats.commands),
            ("refused_commands", "Commands refused.", stats.refusals),
        ] {
            out.encode_descriptor(name, help, None, MetricType::Counter)?
                .encode_counter::<NoLabelSet, _, u64>(&value, None)?;
        }
        Ok(())
    }

    /// How the loop keeps its time.
    fn timing(&self, out: &mut DescriptorEncoder<'_>) -> fmt::Result {
        let stats = &self.stats;
        for (name, what, durations) in [
            ("lateness", "How late the loop woke up", &stats.lateness),
            ("cycle_time", "How long a cycle took", &stats.cycle_time),
        ] {
            let unit = Unit::Other("seconds".into());
            let (count, buckets) = buckets(durations);
            out.encode_descriptor(
                name,
                &format!("{what}, since the driver's start."),
                Some(&unit),
                MetricType::Histogram,
            )?
            .encode_histogram::<NoLabelSet>(durations.sum() as f64 / 1e9, count, &buckets, None)?;
            let seconds = |ns: u64| ns as f64 / 1e9;
            let shares = QUANTILES.iter().map(|(share, q)| (vec![("share", *share)], seconds(durations.quantile(*q))));
            let help = format!(
                "{what}, at the most, in that share of all cycles since the driver's start; 3 % too long at worst."
            );
            gauge(out, &format!("{name}_quantile"), Some("seconds"), &help, shares)?;
            let help = format!("{what}, at the most, since the driver's start.");
            gauge(out, &format!("{name}_max"), Some("seconds"), &help, [(vec![], seconds(durations.max()))])?;
        }
        Ok(())
    }

    /// What the channels do.
    fn channels(&self, out: &mut DescriptorEncoder<'_>) -> fmt::Result {
        let each = || {
            self.info
                .channels()
                .iter()
                .zip(self.snapshot.channels())
                .map(|(info, state)| (info.name.as_str(), info, state))
        };
        for field in ChannelState::FIELDS {
            let Some((name, unit)) = exported(field) else { continue };
            let values = each().map(|(channel, _, state)| (vec![("channel", channel)], field.of(state)));
            gauge(out, &name, Some(unit), &plain(field.meaning), values)?;
        }
        for (name, unit, help, value) in DERIVED {
            let values = each().map(|(channel, info, state)| (vec![("channel", channel)], value(info, state)));
            gauge(out, &format!("channel_{name}"), unit, help, values)?;
        }
        let modes = || (0..).map_while(Mode::from_code);
        let values = each().flat_map(|(channel, _, state)| {
            modes().map(move |mode| (vec![("channel", channel), ("mode", mode.name())], flag(state.mode() == mode)))
        });
        gauge(out, "channel_mode", None, "What a channel is doing: 1 for the one mode it is in.", values)?;
        let values = each().flat_map(|(channel, _, state)| {
            FAULT_TABLE.iter().map(move |row| {
                (vec![("channel", channel), ("fault", row.flag)], flag(state.fault() == Some(row.fault)))
            })
        });
        gauge(out, "channel_fault", None, "Whether this fault is latched: 1, else 0.", values)?;
        let values = each().flat_map(|(channel, _, state)| {
            ChannelState::FLAGS
                .iter()
                .map(move |(bit, name)| (vec![("channel", channel), ("flag", *name)], flag(state.flags & bit != 0)))
        });
        let help = "Flags of a channel: limited, heat_budget and temperature_budget say that its duty is held back and by what.";
        gauge(out, "channel_flag", None, help, values)
    }
}

/// One metric with a value for each set of labels.
fn gauge<'a>(
    out: &mut DescriptorEncoder<'_>,
    name: &str,
    unit: Option<&str>,
    help: &str,
    values: impl IntoIterator<Item = (Labels<'a>, f64)>,
) -> fmt::Result {
    let unit = unit.map(|unit| Unit::Other(unit.into()));
    let mut metric = out.encode_descriptor(name, help, unit.as_ref(), MetricType::Gauge)?;
    values.into_iter().try_for_each(|(labels, value)| metric.encode_family(&labels)?.encode_gauge(&value))
}

const fn flag(is: bool) -> f64 {
    if is { 1.0 } else { 0.0 }
}

/// The metric of a field and its unit; none where it has no unit that stays the same.
fn exported(field: &ChannelField) -> Option<(String, &'static str)> {
    if field.kind != FieldKind::Float {
        return None;
    }
    if SHARES.contains(&field.name) {
        return Some((format!("channel_{}", field.name), "ratio"));
    }
    let (_, end, words) = UNITS.iter().find(|(unit, _, _)| *unit == field.unit)?;
    Some((format!("channel_{}", field.name.strip_suffix(end).unwrap_or(field.name)), words))
}

/// A field's meaning without what no line of help can have.
fn plain(meaning: &str) -> String {
    meaning.trim().replace(['`', '\\'], "").replace('"', "'").replace('\n', " ")
}

/// How many durations there are, and how many lie in each bucket; the bounds are those of the histogram's own bins, so that none is
/// counted in the wrong one.
fn buckets(durations: &Histogram) -> (u64, Vec<(f64, u64)>) {
    let bounds: Vec<u64> = OCTAVES.flat_map(|octave| [1 << octave, 3 << (octave - 1)]).collect();
    let bounds = &bounds[..bounds.len() - 1];
    let mut counts = vec![0u64; bounds.len() + 1];
    for (_, last_ns, count) in durations.filled() {
        let bucket = &mut counts[bounds.partition_point(|bound| *bound <= last_ns)];
        *bucket = bucket.saturating_add(count);
    }
    counts[bounds.len()] = durations.overflow();
    let total = counts.iter().fold(0, |sum: u64, count| sum.saturating_add(*count));
    let bounds = bounds.iter().map(|bound| *bound as f64 / 1e9).chain([f64::INFINITY]);
    (total, bounds.zip(counts).collect())
}

/// A driver of one channel about which nothing is known.
fn sample() -> Look {
    let mut info = Info {
        protocol: PROTOCOL,
        pid: 0,
        rig: sinew_ipc::Name::EMPTY,
        rate_hz: 1000.0,
        started_ns: 0,
        channels: 1,
        simulated: 1,
        channel: [ChannelInfo::EMPTY; sinew_ipc::MAX_CHANNELS],
    };
    info.channel[0].name = sinew_ipc::Name::new("left").unwrap_or(sinew_ipc::Name::EMPTY);
    let seen = Seen { info, snapshot: Snapshot::new(1), stats: LoopStats::new(), age_s: 0.001 };
    Look { state: "running", seen: Some(Box::new(seen)) }
}

/// All metrics as a table in Markdown, as it stands in `docs/bridges.md`: off a page of them.
pub fn metric_table_markdown() -> String {
    let mut page = String::new();
    // a String takes everything
    let _ = text::encode(&mut page, &registry("bench", sample()));
    let mut table = String::from("| metric | type | labels | meaning |\n|---|---|---|---|\n");
    let lines: Vec<&str> = page.lines().collect();
    for (place, line) in lines.iter().enumerate() {
        let Some((name, help)) = line.strip_prefix("# HELP ").and_then(|rest| rest.split_once(' ')) else { continue };
        let own = || lines[place + 1..].iter().take_while(|line| !line.starts_with("# HELP "));
        let kind = own().find_map(|line| line.strip_prefix(&format!("# TYPE {name} "))).unwrap_or_default();
        let labels: BTreeSet<&str> =
            own().filter(|line| !line.starts_with('#')).flat_map(|line| labels_of(line)).collect();
        let labels: Vec<String> = labels.iter().map(|label| format!("`{label}`")).collect();
        let end = match kind {
            "counter" => "_total",
            "info" => "_info",
            _ => "",
        };
        let _ = writeln!(table, "| `{name}{end}` | {kind} | {} | {help} |", labels.join(", "));
    }
    table
}

/// Names of the labels of a sample, but those that every metric has or that belong to its type.
fn labels_of(sample: &str) -> impl Iterator<Item = &str> {
    let labels = sample.split_once('{').and_then(|(_, rest)| rest.rsplit_once('}')).map_or("", |(labels, _)| labels);
    labels
        .split("\",")
        .filter_map(|label| label.split_once("=\""))
        .map(|(name, _)| name)
        .filter(|name| !matches!(*name, "rig" | "le"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use prometheus_client::encoding::prometheus_text;
    use sinew_ipc::Fault;

    fn page(look: Look) -> String {
        let mut page = String::new();
        text::encode(&mut page, &registry("bench", look)).unwrap();
        page
    }

    /// The value of a sample.
    #[track_caller]
    fn value(page: &str, sample: &str) -> f64 {
        let line = page.lines().find_map(|line| line.strip_prefix(sample)?.strip_prefix(' '));
        line.unwrap_or_else(|| panic!("no {sample} in:\n{page}")).parse().unwrap()
    }

    #[test]
    fn every_float_that_has_a_unit_of_its_own_is_a_metric_in_that_unit() {
        let left_out: Vec<&str> = ChannelState::FIELDS
            .iter()
            .filter(|field| field.kind == FieldKind::Float && exported(field).is_none())
            .map(|field| field.name)
            .collect();
        assert_eq!(left_out, ["asked"], "in m, N or a share, by what was asked for");
        let names: BTreeSet<_> = ChannelState::FIELDS.iter().filter_map(exported).collect();
        for known in [
            ("channel_length", "meters"),
            ("channel_velocity", "meters_per_second"),
            ("channel_temperature", "celsius"),
            ("channel_resistance", "ohms"),
            ("channel_duty", "ratio"),
            ("channel_v1", "volts"),
        ] {
            assert!(names.contains(&(known.0.to_string(), known.1)), "{known:?}");
        }
    }

    #[test]
    fn a_channel_is_on_the_page_with_what_it_publishes() {
        let mut look = sample();
        let seen = look.seen.as_mut().unwrap();
        seen.info.channel[0].cold_length_m = 0.166;
        seen.info.channel[0].hot_length_m = 0.160;
        let fault = Fault::ProbeStuck;
        seen.snapshot.channel[0] = ChannelState {
            temperature_c: 81.25,
            length_m: 0.163,
            duty: 0.25,
            mode: Mode::Fault.code(),
            fault: fault.code(),
            flags: ChannelState::FLAG_LIMITED | ChannelState::FLAG_HEAT_BUDGET,
            ..ChannelState::UNKNOWN
        };
        let page = page(look);
        let left = |name: &str| value(&page, &format!("sinew_channel_{name}{{rig=\"bench\",channel=\"left\"}}"));
        assert_eq!((left("temperature_celsius"), left("duty_ratio")), (81.25, 0.25));
        assert!(
            (left("stroke_ratio") - 0.5).abs() < 1e-9
                && left("length_meters") == 0.163
                && left("measured_length_meters").is_nan()
        );
        let of = |metric: &str, label: &str, name: &str| {
            value(&page, &format!("sinew_channel_{metric}{{rig=\"bench\",channel=\"left\",{label}=\"{name}\"}}"))
        };
        for row in FAULT_TABLE {
            assert_eq!(of("fault", "fault", row.flag), flag(row.fault == fault), "{}", row.flag);
        }
        assert_eq!([of("mode", "mode", "fault"), of("mode", "mode", "length")], [1.0, 0.0]);
        for (_, name) in ChannelState::FLAGS {
            assert_eq!(of("flag", "flag", name), flag(["limited", "heat_budget"].contains(&name)), "{name}");
        }
        assert_eq!(value(&page, "sinew_up{rig=\"bench\"}"), 1.0);
    }

    #[test]
    fn nothing_is_claimed_of_a_driver_that_is_gone_or_of_wires_whose_loop_stands_still() {
        let gone = page(Look { state: "gone", seen: None });
        assert_eq!(value(&gone, "sinew_up{rig=\"bench\"}"), 0.0);
        assert_eq!(value(&gone, "sinew_driver_state{rig=\"bench\",state=\"gone\"}"), 1.0);
        assert_eq!(gone.lines().filter(|line| !line.starts_with('#')).count(), 1 + STATES.len());
        let stalled = page(Look { state: "stalled", ..sample() });
        assert_eq!(value(&stalled, "sinew_up{rig=\"bench\"}"), 0.0);
        assert_eq!(value(&stalled, "sinew_state_age_seconds{rig=\"bench\"}"), 0.001);
        assert!(!stalled.contains("sinew_channel_"), "{stalled}");
    }

    #[test]
    fn durations_are_counted_in_the_bucket_they_belong_to() {
        let mut durations = Histogram::new();
        let taken = [0, 1023, 1024, 1535, 1536, 70_000, 999_999_999, 1 << 30, 5_000_000_000];
        taken.iter().for_each(|ns| durations.record(*ns));
        let (count, buckets) = buckets(&durations);
        assert_eq!(count, taken.len() as u64);
        let (mut from, mut counted) = (0.0, 0);
        for (bound, in_bucket) in &buckets {
            let truly = taken.iter().filter(|ns| (from..*bound).contains(&(**ns as f64 / 1e9))).count() as u64;
            assert_eq!(*in_bucket, truly, "{from} to {bound} s");
            (from, counted) = (*bound, counted + in_bucket);
        }
        assert_eq!((counted, buckets.last().unwrap().0), (count, f64::INFINITY));
        assert!(buckets.is_sorted_by(|a, b| a.0 < b.0));
        let (none, empty) = super::buckets(&Histogram::new());
        assert_eq!((none, empty.len()), (0, buckets.len()));
    }

    #[test]
    fn names_and_helps_are_as_prometheus_wants_them() {
        let page = page(sample());
        assert!(page.ends_with("# EOF\n"));
        let mut known = BTreeSet::new();
        for line in page.lines() {
            if let Some((name, help)) = line.strip_prefix("# HELP ").and_then(|rest| rest.split_once(' ')) {
                assert!(known.insert(name), "{name} twice");
                assert!(
                    name.starts_with("sinew_")
                        && name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_')
                );
                assert!(help.ends_with('.') && !help.contains(['"', '\\', '`']), "{help}");
            }
        }
        let mut plain = String::new();
        prometheus_text::encode(&mut plain, &registry("bench", sample())).unwrap();
        assert!(plain.contains("# TYPE sinew_cycles_total counter\nsinew_cycles_total{rig=\"bench\"} 0\n"), "{plain}");
        assert!(!plain.contains("# EOF") && !plain.contains("# UNIT"));
    }

    #[test]
    fn a_name_cannot_break_out_of_its_label() {
        let mut look = sample();
        look.seen.as_mut().unwrap().info.channel[0].name = sinew_ipc::Name::new("a\"} 1\nb\\").unwrap();
        let page = page(look);
        assert!(page.contains(r#"sinew_channel_duty_ratio{rig="bench",channel="a\"} 1\nb\\"} 0"#), "{page}");
    }

    #[test]
    fn the_largest_rig_has_a_few_thousand_series() {
        let mut look = sample();
        let seen = look.seen.as_mut().unwrap();
        seen.info.channels = 64;
        seen.snapshot = Snapshot::new(64);
        for (number, channel) in seen.info.channel.iter_mut().enumerate() {
            channel.name = sinew_ipc::Name::new(&format!("wire{number}")).unwrap();
        }
        let series = page(look).lines().filter(|line| !line.starts_with('#')).count();
        assert!((3000..6000).contains(&series), "{series}");
    }
}
