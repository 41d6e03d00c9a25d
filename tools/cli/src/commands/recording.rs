//! `sinew recording`: the contents of a recording, its integrity check, and recovery of a damaged one.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sinew_recording::session::{Checkup, Compression, Gap, Head, Recovered, Session, check, recover as mend, size};
use sinew_recording::{Error, Utc, What};

use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// Versions of the JSON.
const INFO: &str = "sinew.recording/1";
const DOCTOR: &str = "sinew.recording-doctor/1";
const RECOVER: &str = "sinew.recover/1";
/// Gaps that are listed one by one for a person.
const GAPS_SHOWN: usize = 10;
/// Channels that are named for a person.
const CHANNELS_SHOWN: usize = 24;

/// `sinew recording info`.
pub fn info(args: &args::RecordingInfo) -> Outcome {
    let session = Session::open(&args.file).map_err(failure)?;
    let span = session.span().map_err(failure)?;
    let clocks = ClocksInfo::of(&session).map_err(failure)?;
    let info = Info::of(&session, span, clocks);
    if args.json { output::print_json(&info) } else { output::print(info.text()) }
}

/// What a recording says of itself.
#[derive(Debug, Serialize)]
struct Info<'a> {
    schema: &'static str,
    file: &'a str,
    rig: &'a str,
    kind: &'a str,
    simulated: bool,
    software: &'a str,
    rate_hz: f64,
    started_unix_ns: u64,
    started: String,
    clocks: Option<ClocksInfo>,
    seconds: f64,
    channels: &'a [String],
    fields: Vec<FieldInfo<'a>>,
    cycles: u64,
    first_cycle: Option<u64>,
    last_cycle: Option<u64>,
    lost: Option<u64>,
    gaps: Vec<[u64; 2]>,
    missed: Option<u64>,
    ended: Option<&'static str>,
    summary: bool,
    rig_file: bool,
    bytes: u64,
    chunks: usize,
    compression: Option<&'static str>,
    packed_bytes: u64,
    unpacked_bytes: u64,
    extra: &'a std::collections::BTreeMap<String, String>,
}

/// What the clocks showed beside each other.
#[derive(Debug, Serialize)]
struct ClocksInfo {
    system_error_ns: u64,
    utc_error_ns: Option<u64>,
    tai_offset_s: Option<i32>,
    slew_ppm: f64,
    slew_error_ppm: f64,
    steps: Vec<StepInfo>,
    suspended_s: f64,
    #[serde(skip)]
    said: String,
}

#[derive(Debug, Serialize)]
struct StepInfo {
    after_s: f64,
    before_s: f64,
    by_s: f64,
}

impl ClocksInfo {
    fn of(session: &Session) -> Result<Option<ClocksInfo>, Error> {
        let about = session.about();
        let Some(history) = session.clock_history()? else { return Ok(None) };
        let (first, change) = (&history.readings()[0], history.change());
        Ok(Some(ClocksInfo {
            system_error_ns: first.system_error_ns,
            utc_error_ns: first.utc_error_ns,
            tai_offset_s: first.tai_offset_s,
            slew_ppm: change.slew_ppm,
            slew_error_ppm: change.slew_error_ppm,
            steps: history
                .steps()
                .map(|step| StepInfo {
                    after_s: about.time_s(step.after_ns),
                    before_s: about.time_s(step.before_ns),
                    by_s: step.by_ns as f64 * 1e-9,
                })
                .collect(),
            suspended_s: change.suspended_ns as f64 * 1e-9,
            said: history.said(about.started_monotonic_ns),
        }))
    }
}

#[derive(Debug, Serialize)]
struct FieldInfo<'a> {
    name: &'a str,
    unit: &'a str,
}

impl Info<'_> {
    fn of(session: &Session, span: Option<(Head, Head)>, clocks: Option<ClocksInfo>) -> Info<'_> {
        let (about, layout, ending, size) = (session.about(), session.layout(), session.ending(), session.size());
        let ns = span.map_or(0, |(first, last)| last.monotonic_ns.saturating_sub(first.monotonic_ns));
        Info {
            schema: INFO,
            file: session.name(),
            rig: &about.rig,
            kind: &about.kind,
            simulated: about.simulated,
            software: &about.software,
            rate_hz: about.rate_hz,
            started_unix_ns: about.started_unix_ns,
            started: Utc::of_unix_ns(about.started_unix_ns).to_string(),
            clocks,
            seconds: ns as f64 * 1e-9,
            channels: &layout.channels,
            fields: layout.fields.iter().map(|field| FieldInfo { name: &field.name, unit: &field.unit }).collect(),
            cycles: session.cycle_count(),
            first_cycle: span.map(|(first, _)| first.cycle),
            last_cycle: span.map(|(_, last)| last.cycle),
            lost: ending.map(|ending| ending.lost),
            gaps: ending.map_or(Vec::new(), |ending| pairs(&ending.gaps)),
            missed: span.map(|(first, last)| last.missed.saturating_sub(first.missed)),
            ended: ending.and_then(|ending| ending.ended).map(|ended| ended.word()),
            summary: session.has_summary(),
            rig_file: about.rig_toml.is_some(),
            bytes: size.file,
            chunks: size.chunks,
            compression: size.compression.map(Compression::name),
            packed_bytes: size.packed,
            unpacked_bytes: size.unpacked,
            extra: &about.extra,
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let mut row = |what: &str, value: String| {
            let _ = writeln!(text, "{what:<10}{value}");
        };
        let wires = if self.simulated { "simulated" } else { "real" };
        row("rig", format!("{} ({wires}), recorded by {}", self.rig, self.software));
        row("started", self.started.clone());
        row("clocks", self.clocks.as_ref().map_or("not compared".into(), |c| c.said.clone()));
        row("time", format!("{:.3} s at {} Hz", self.seconds, self.rate_hz));
        let range = match (self.first_cycle, self.last_cycle) {
            (Some(first), Some(last)) => format!(" ({first} to {last})"),
            _ => String::new(),
        };
        row("cycles", format!("{}{range}", self.cycles));
        let listed: Vec<Gap> = self.gaps.iter().map(|&[from, to]| Gap { from, to }).collect();
        row(
            "lost",
            match self.lost {
                None => "not known: it broke off".into(),
                Some(0) => "0".into(),
                Some(n) => format!("{n}: {}", gaps(&listed, 0)),
            },
        );
        row("missed", format!("{} periods the driver skipped", self.missed.unwrap_or(0)));
        row("ended", self.ended.unwrap_or("not: `sinew recording recover` makes a whole file of it").into());
        let more = self.channels.len().saturating_sub(CHANNELS_SHOWN);
        let names = self.channels.iter().take(CHANNELS_SHOWN).cloned().collect::<Vec<_>>().join(", ");
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        row("channels", format!("{}: {names}{more}", self.channels.len()));
        let fields = self.fields.iter().map(|f| f.name).collect::<Vec<_>>().join(", ");
        row("fields", format!("{}: {fields}", self.fields.len()));
        row("rig file", if self.rig_file { "attached" } else { "none" }.into());
        row(
            "size",
            format!(
                "{}: {} chunks, {}, {:.0} % of {}",
                size(self.bytes),
                self.chunks,
                self.compression.unwrap_or("none"),
                100.0 * self.packed_bytes as f64 / self.unpacked_bytes.max(1) as f64,
                size(self.unpacked_bytes)
            ),
        );
        text
    }
}

/// `sinew recording doctor`.
pub fn doctor(args: &args::RecordingInfo) -> Outcome {
    let progress = Progress::new();
    let checkup = check(&args.file, |done, all| progress.count("checking", done, all));
    progress.clear();
    let checkup = checkup.map_err(failure)?;
    if args.json {
        output::print_json(&Doctor::of(&checkup))?
    } else {
        output::print(doctor_text(&checkup))?
    }
    if checkup.is_whole() {
        return Ok(());
    }
    let name = args.file.display();
    Err(Failure::own(format!("{name}: is damaged")).hint(format!(
        "`sinew recording recover {name}` writes {} with the {} cycles that can be read",
        recovered_path(&args.file).display(),
        checkup.cycles
    )))
}

/// A check as JSON.
#[derive(Debug, Serialize)]
struct Doctor<'a> {
    schema: &'static str,
    whole: bool,
    cycles: u64,
    lost: u64,
    gaps: Vec<[u64; 2]>,
    missed: u64,
    chunks: u64,
    damaged_chunks: u64,
    findings: Vec<FindingInfo<'a>>,
}

#[derive(Debug, Serialize)]
struct FindingInfo<'a> {
    damage: bool,
    text: &'a str,
}

impl Doctor<'_> {
    fn of(checkup: &Checkup) -> Doctor<'_> {
        Doctor {
            schema: DOCTOR,
            whole: checkup.is_whole(),
            cycles: checkup.cycles,
            lost: checkup.lost,
            gaps: pairs(&checkup.gaps),
            missed: checkup.missed,
            chunks: checkup.chunks,
            damaged_chunks: checkup.damaged_chunks,
            findings: checkup.findings.iter().map(|f| FindingInfo { damage: f.damage, text: &f.text }).collect(),
        }
    }
}

fn doctor_text(checkup: &Checkup) -> String {
    let mut text = String::new();
    for finding in &checkup.findings {
        let _ = writeln!(text, "{}  {}", if finding.damage { "damage" } else { "note  " }, finding.text);
    }
    if checkup.more > 0 {
        let _ = writeln!(text, "damage  {} more of these", checkup.more);
    }
    if checkup.lost > 0 {
        let _ = writeln!(text, "lost    {} cycles: {}", checkup.lost, gaps(&checkup.gaps, 0));
    }
    let Checkup { cycles, chunks, damaged_chunks, .. } = checkup;
    let verdict = if checkup.is_whole() { "whole" } else { "damaged" };
    let _ = writeln!(text, "{verdict}: {cycles} cycles in {} of {chunks} chunks can be read", chunks - damaged_chunks);
    text
}

/// `sinew recording recover`.
pub fn recover(args: &args::RecordingRecover) -> Outcome {
    let target = args.output.clone().unwrap_or_else(|| recovered_path(&args.file));
    output::has_place(&target)?;
    let same = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if same(&args.file, &target) {
        return Err(Failure::input(format!("{}: is the damaged recording itself", target.display()))
            .hint("name another file: what is damaged is left as it is"));
    }
    if target.exists() && !args.force {
        return Err(Failure::input(format!("{}: is there already", target.display()))
            .hint("choose another name with -o, or --force to replace it"));
    }
    let progress = Progress::new();
    let recovered = mend(&args.file, &target, |done, all| progress.count("recovering", done, all));
    progress.clear();
    let recovered = recovered.map_err(failure)?;
    if args.json {
        return output::print_json(&Mended::of(&recovered, &target));
    }
    output::print(recovered_text(&recovered, &target))
}

/// What was kept and lost as JSON.
#[derive(Debug, Serialize)]
struct Mended<'a> {
    schema: &'static str,
    file: &'a Path,
    cycles: u64,
    unchecked: u64,
    lost: u64,
    gaps: Vec<[u64; 2]>,
    damaged_chunks: usize,
    left_over_bytes: u64,
    passed_over: u64,
}

impl Mended<'_> {
    fn of<'a>(recovered: &Recovered, file: &'a Path) -> Mended<'a> {
        Mended {
            schema: RECOVER,
            file,
            cycles: recovered.cycles,
            unchecked: recovered.unchecked,
            lost: recovered.lost,
            gaps: pairs(&recovered.gaps),
            damaged_chunks: recovered.damaged.len(),
            left_over_bytes: recovered.left_over,
            passed_over: recovered.passed_over,
        }
    }
}

fn recovered_text(recovered: &Recovered, target: &Path) -> String {
    let Recovered { cycles, unchecked, lost, damaged, left_over, passed_over, .. } = recovered;
    let mut text = format!("{}: {cycles} cycles\n", target.display());
    if *unchecked > 0 {
        let _ = writeln!(text, "  {unchecked} of them out of the chunk that broke off; no checksum vouches for those");
    }
    for (_, reason) in damaged {
        let _ = writeln!(text, "  not kept: a chunk that {reason}");
    }
    if *left_over > 0 {
        let _ = writeln!(text, "  {} at the end were no complete chunk", size(*left_over));
    }
    if *passed_over > 0 {
        let _ = writeln!(text, "  {passed_over} messages were passed over: they are not as they should be");
    }
    match lost {
        0 => text += "  nothing is missing between the first cycle and the last\n",
        n => text += &format!("  {n} cycles are missing: {}\n", gaps(&recovered.gaps, 0)),
    }
    text
}

fn pairs(gaps: &[Gap]) -> Vec<[u64; 2]> {
    gaps.iter().map(|gap| [gap.from, gap.to]).collect()
}

fn recovered_path(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-recovered.mcap"))
}

/// A recording's error, with its remedy as the hint.
pub fn failure(error: Error) -> Failure {
    let own = matches!(error.what, What::Unwritable { .. });
    let failure = if own { Failure::own(error.message()) } else { Failure::input(error.message()) };
    failure.hint(error.hint())
}

/// Gaps for a person: the first few.
pub fn gaps(gaps: &[Gap], more: u64) -> String {
    let shown: Vec<String> = gaps.iter().take(GAPS_SHOWN).map(Gap::to_string).collect();
    let hidden = gaps.len().saturating_sub(GAPS_SHOWN) as u64 + more;
    match hidden {
        0 => shown.join(", "),
        _ => format!("{} and {hidden} more gaps", shown.join(", ")),
    }
}
