//! What a recording says about itself: at its beginning whose it is, at its end what became of it.

use std::collections::BTreeMap;
use std::fmt;

use sinew_clocks::Reading;

use super::layout::Layout;

/// Name of the metadata at the beginning.
pub(super) const ABOUT: &str = "sinew";
/// Name of the metadata at the end.
pub(super) const ENDING: &str = "sinew.end";
/// Name of the attachment with the rig file.
pub(super) const RIG_FILE: &str = "rig.toml";
/// What precedes a channel's identifier where its true name stands.
const CHANNEL: &str = "channel.";
/// Most comparisons of clocks its end has.
const MAX_CLOCKS: usize = 1000;
/// Most gaps a recording lists one by one.
pub(super) const MAX_GAPS: usize = 10_000;

/// Where a recording comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// Name of the rig.
    pub rig: String,
    /// Rate of the cycles, Hz.
    pub rate_hz: f64,
    /// What wrote it: "sinew 0.1.0".
    pub software: String,
    /// What it is a recording of: "driver" or "test".
    pub kind: String,
    /// Whether the wires were simulated.
    pub simulated: bool,
    /// When its time begins to count, ns since 1970 (UTC).
    pub started_unix_ns: u64,
    /// The same moment on the clock of [`super::Head::monotonic_ns`].
    pub started_monotonic_ns: u64,
    /// The rig file as the driver read it.
    pub rig_toml: Option<String>,
    /// Anything else, by name.
    pub extra: BTreeMap<String, String>,
}

impl About {
    /// Time of day of a moment on the monotonic clock, ns since 1970 (UTC).
    pub fn unix_ns(&self, monotonic_ns: u64) -> u64 {
        self.started_unix_ns.wrapping_add(monotonic_ns.wrapping_sub(self.started_monotonic_ns))
    }

    /// Seconds from the start of the recording to a moment on the monotonic clock; negative before it.
    pub fn time_s(&self, monotonic_ns: u64) -> f64 {
        monotonic_ns.wrapping_sub(self.started_monotonic_ns) as i64 as f64 * 1e-9
    }

    pub(super) fn metadata(&self, layout: &Layout) -> BTreeMap<String, String> {
        let mut map = self.extra.clone();
        let channels = layout.identifiers().into_iter().zip(&layout.channels);
        map.extend(channels.map(|(identifier, name)| (format!("{CHANNEL}{identifier}"), name.clone())));
        let own = [
            ("rig", self.rig.clone()),
            ("rate_hz", format!("{:?}", self.rate_hz)),
            ("software", self.software.clone()),
            ("kind", self.kind.clone()),
            ("simulated", self.simulated.to_string()),
            ("started_unix_ns", self.started_unix_ns.to_string()),
            ("started_monotonic_ns", self.started_monotonic_ns.to_string()),
        ];
        map.extend(own.map(|(key, value)| (key.to_string(), value)));
        map
    }

    /// What the metadata says; what is missing or no number is left at nothing, for the cycles can be read without it.
    pub(super) fn parse(mut map: BTreeMap<String, String>, rig_toml: Option<String>, layout: &mut Layout) -> About {
        let mut text = |key: &str| map.remove(key).unwrap_or_default();
        let about = About {
            rig: text("rig"),
            rate_hz: text("rate_hz").parse().unwrap_or(f64::NAN),
            software: text("software"),
            kind: text("kind"),
            simulated: text("simulated") == "true",
            started_unix_ns: text("started_unix_ns").parse().unwrap_or(0),
            started_monotonic_ns: text("started_monotonic_ns").parse().unwrap_or(0),
            rig_toml,
            extra: BTreeMap::new(),
        };
        for channel in &mut layout.channels {
            if let Some(name) = map.remove(&format!("{CHANNEL}{channel}")) {
                *channel = name;
            }
        }
        About { extra: map, ..about }
    }
}

/// Why a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Ended {
    /// Somebody stopped it.
    Stopped,
    /// It ran for as long as it was asked to, or what it recorded was over.
    Complete,
    /// The file had reached its size or time; the recording goes on in the next one.
    Rotated,
    /// The driver stopped in order.
    DriverStopped,
    /// The driver ended without stopping.
    DriverDied,
    /// No more could be written.
    Unwritable,
    /// It broke off; what was left of it was mended.
    Recovered,
}

impl Ended {
    const ALL: [(Ended, &'static str); 7] = [
        (Ended::Stopped, "stopped"),
        (Ended::Complete, "complete"),
        (Ended::Rotated, "rotated"),
        (Ended::DriverStopped, "driver_stopped"),
        (Ended::DriverDied, "driver_died"),
        (Ended::Unwritable, "unwritable"),
        (Ended::Recovered, "recovered"),
    ];

    /// The word for it in files and reports.
    pub fn word(self) -> &'static str {
        Ended::ALL.iter().find(|(ended, _)| *ended == self).map_or("", |(_, word)| word)
    }

    fn from_word(word: &str) -> Option<Ended> {
        Ended::ALL.iter().find(|(_, known)| *known == word).map(|(ended, _)| *ended)
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// Cycles that ran and are not in a recording: from this number to that, both among them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Gap {
    /// The first one lost.
    pub from: u64,
    /// The last one lost.
    pub to: u64,
}

impl Gap {
    /// How many were lost.
    pub fn cycles(&self) -> u64 {
        (self.to - self.from).saturating_add(1)
    }
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.from, self.to)
    }
}

/// What a recording says about its end.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Ending {
    /// Why it ended; `None` for a word of a later version.
    pub ended: Option<Ended>,
    /// Cycles written.
    pub cycles: u64,
    /// Cycles lost: they ran and are not here.
    pub lost: u64,
    /// Which ones; the first ten thousand gaps.
    pub gaps: Vec<Gap>,
    /// Gaps beyond those.
    pub gaps_not_listed: u64,
    /// Periods the driver skipped from the first cycle to the last.
    pub missed: u64,
    /// The clocks of the recording machine beside each other: the first and the last comparison, and those on either side of what became of
    /// the system's clock. [`CLOCKS`](super::CLOCKS) has all of them.
    pub clocks: Vec<Reading>,
}

/// A comparison of clocks in one word.
fn word_of(reading: &Reading) -> String {
    let Reading {
        monotonic_ns, system_ns, system_error_ns, boottime_ns, boottime_error_ns, raw_ns, raw_error_ns, ..
    } = reading;
    let utc = reading.utc_error_ns.map_or(String::new(), |ns| ns.to_string());
    let tai = reading.tai_offset_s.map_or(String::new(), |seconds| seconds.to_string());
    format!(
        "{monotonic_ns},{system_ns},{system_error_ns},{boottime_ns},{boottime_error_ns},{raw_ns},{raw_error_ns},{utc},{tai}"
    )
}

fn reading_of(word: &str) -> Option<Reading> {
    let mut words = word.split(',');
    Some(Reading {
        monotonic_ns: words.next()?.parse().ok()?,
        system_ns: words.next()?.parse().ok()?,
        system_error_ns: words.next()?.parse().ok()?,
        boottime_ns: words.next()?.parse().ok()?,
        boottime_error_ns: words.next()?.parse().ok()?,
        raw_ns: words.next()?.parse().ok()?,
        raw_error_ns: words.next()?.parse().ok()?,
        utc_error_ns: words.next()?.parse().ok(),
        tai_offset_s: words.next()?.parse().ok(),
    })
}

impl Ending {
    /// Takes note of a comparison of clocks.
    pub(super) fn compared(&mut self, reading: &Reading) {
        let same = |from: &Reading, to: &Reading| {
            let change = from.change_to(to);
            change.step().is_none() && change.suspended_ns == 0 && !change.tai_offset_changed
        };
        match self.clocks[..] {
            // between two others nothing became of the clocks: the latest takes the place of the one before
            [.., before, latest] if same(&before, &latest) && same(&latest, reading) => {
                self.clocks.pop();
            }
            _ if self.clocks.len() >= MAX_CLOCKS => return,
            _ => {}
        }
        self.clocks.push(*reading);
    }

    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let gaps: Vec<String> = self.gaps.iter().map(Gap::to_string).collect();
        let clocks: Vec<String> = self.clocks.iter().map(word_of).collect();
        let mut map: BTreeMap<String, String> = [
            ("ended", self.ended.map_or("", Ended::word).to_string()),
            ("cycles", self.cycles.to_string()),
            ("lost", self.lost.to_string()),
            ("gaps", gaps.join(" ")),
            ("gaps_not_listed", self.gaps_not_listed.to_string()),
            ("missed", self.missed.to_string()),
        ]
        .map(|(key, value)| (key.to_string(), value))
        .into();
        if !clocks.is_empty() {
            map.insert("clocks".into(), clocks.join(" "));
        }
        map
    }

    pub(super) fn parse(map: &BTreeMap<String, String>) -> Ending {
        let text = |key: &str| map.get(key).map_or("", String::as_str);
        let number = |key: &str| text(key).parse().unwrap_or(0);
        let gap = |word: &str| {
            let (from, to) = word.split_once('-')?;
            let gap = Gap { from: from.parse().ok()?, to: to.parse().ok()? };
            (gap.from <= gap.to).then_some(gap)
        };
        Ending {
            ended: Ended::from_word(text("ended")),
            cycles: number("cycles"),
            lost: number("lost"),
            gaps: text("gaps").split_whitespace().filter_map(gap).take(MAX_GAPS).collect(),
            gaps_not_listed: number("gaps_not_listed"),
            missed: number("missed"),
            clocks: text("clocks").split_whitespace().filter_map(reading_of).take(MAX_CLOCKS).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::Field;
    use super::*;

    #[test]
    fn what_is_said_is_understood_again() {
        let mut layout = Layout::new(vec!["Bench 1".into(), "b".into()], vec![Field::f64("x", "m")]).unwrap();
        let about = About {
            rig: "bench".into(),
            rate_hz: 1000.0 / 3.0,
            software: "sinew 0.1.0".into(),
            kind: "driver".into(),
            simulated: true,
            started_unix_ns: 1_700_000_000_123_456_789,
            started_monotonic_ns: 5_000_000_000,
            rig_toml: Some("[rig]".into()),
            extra: [("part".to_string(), "2".to_string())].into(),
        };
        let map = about.metadata(&layout);
        assert_eq!(map["channel.bench_1"], "Bench 1");
        let names = std::mem::replace(&mut layout.channels, vec!["bench_1".into(), "b".into()]);
        assert_eq!(About::parse(map, about.rig_toml.clone(), &mut layout), about);
        assert_eq!(layout.channels, names);
        assert_eq!(about.unix_ns(6_000_000_000), 1_700_000_001_123_456_789);
        assert_eq!(about.time_s(4_500_000_000), -0.5);

        let first = Reading { monotonic_ns: 5, system_ns: -3, utc_error_ns: Some(0), ..Reading::default() };
        let after = |seconds: u64, ahead_ns: i64| Reading {
            monotonic_ns: 5 + seconds * 1_000_000_000,
            system_ns: seconds as i64 * 1_000_000_000 + ahead_ns - 3,
            boottime_ns: seconds * 1_000_000_000,
            raw_ns: seconds * 1_000_000_000,
            tai_offset_s: Some(37),
            ..first
        };
        let mut clocks = Ending::default();
        for reading in [first, after(1, 0), after(2, 0), after(3, 0), after(4, 99), after(5, 99), after(6, 99)] {
            clocks.compared(&reading);
        }
        let kept = [first, after(1, 0), after(3, 0), after(4, 99), after(6, 99)];
        assert_eq!(clocks.clocks, kept, "those on either side of a change, and the last");

        let ending = Ending {
            clocks: clocks.clocks,
            ended: Some(Ended::DriverDied),
            cycles: 7,
            lost: 4,
            gaps: vec![Gap { from: 3, to: 5 }, Gap { from: 9, to: 9 }],
            gaps_not_listed: 0,
            missed: 2,
        };
        assert_eq!(Ending::parse(&ending.metadata()), ending);
        let hostile = [("gaps".to_string(), "9-1 x 1- -1 2-3".to_string())].into();
        assert_eq!(Ending::parse(&hostile).gaps, [Gap { from: 2, to: 3 }]);
    }
}
