//! `sinew conceal`: a recording with something hidden in it. `sinew reveal`: what it was, beside what a diagnosis found.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sinew_concealed::generator::case::Answer;
use sinew_concealed::generator::signals::Table;
use sinew_concealed::judged::{Judged, Level};
use sinew_concealed::reported::Reported;
use sinew_concealed::{Choice, Order, Sealed};
use sinew_physics::effects;
use sinew_recording::{Column, Recording};
use sinew_rig::nearest;

use super::diagnose::{JSON, as_csv, write_all};
use super::fitting::sha256;
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Progress;

/// The answer in its envelope.
const SEALED: &str = "answer.sealed";
/// What is believed of the rig.
const RIG: &str = "rig.toml";
/// What was recorded on it.
const RECORDINGS: [&str; 2] = ["recording.csv", "second.csv"];
/// Where the diagnosis is to write.
const ANSWER: &str = "answer";
/// Most effects at once: beyond, no recording of this length has enough in it.
const MOST_EFFECTS: usize = 3;

/// Runs `sinew conceal`.
pub fn conceal(args: &args::Conceal) -> Outcome {
    let Some(folder) = args.folder.as_deref().filter(|_| !args.list) else { return output::print(list()) };
    if folder.exists() {
        return Err(Failure::input(format!("{}: is there already", folder.display()))
            .hint("choose another name: nothing is overwritten"));
    }
    output::can_become_folder(folder)?;
    let choice = choice(args)?;
    let (name, seed) = (name(folder), args.seed.map_or_else(random, Ok)?);
    let order = Order { name, choice, level: args.level, seed, second_recording: args.recordings > 1 };
    let progress = Progress::new();
    progress.tell("making a rig, and looking for a size that leaves so much", 0.0);
    let case = order.make();
    progress.clear();

    let mut files = vec![(RIG, case.rig_toml)];
    for (name, table) in RECORDINGS.into_iter().zip(std::iter::once(&case.train).chain(&case.beside)) {
        files.push((name, as_csv(&recording(name, table)?)?));
    }
    let hashes = files.iter().map(|(name, text)| (name.to_string(), sha256(text.as_bytes()))).collect();
    let (envelope, seal) = Sealed { answer: case.answer, files: hashes }
        .seal()
        .map_err(|error| Failure::own(format!("{SEALED}: cannot be written: {error}")))?;
    let recordings: Vec<&str> = files.iter().skip(1).map(|(name, _)| *name).collect();
    let next = next_steps(folder, &recordings, &seal);
    files.push((SEALED, envelope));
    write_all(folder, &files.iter().map(|(name, text)| (*name, text.as_str())).collect::<Vec<_>>())?;
    output::print(next)
}

/// What comes next, in the order it is typed.
fn next_steps(folder: &Path, recordings: &[&str], seal: &str) -> String {
    let place = |name: &str| folder.join(name).display().to_string();
    let recordings = recordings.iter().map(|name| place(name)).collect::<Vec<_>>().join(" ");
    format!(
        "{}: made, and the answer sealed in {}.\n\
         seal {seal}\n\
         It is no secret, only an envelope; whoever keeps the seal sees that nobody changed it. Next:\n\n  \
         sinew diagnose {} {recordings} --out {}\n  \
         sinew reveal {}\n",
        folder.display(),
        place(SEALED),
        place(RIG),
        place(ANSWER),
        folder.display(),
    )
}

/// What may be hidden, with a sentence on each.
fn list() -> String {
    let mut text = String::from("In the catalogue (docs/effects.md):\n");
    for id in sinew_concealed::effects() {
        // writing to a String cannot fail
        let _ = writeln!(text, "  {id:<34} {}", effects::effect(id).map_or("", |effect| effect.says));
    }
    text += "\nOutside it, alone; right is an answer that says that something is missing which it has no name for:\n";
    for name in sinew_concealed::outside() {
        let _ = writeln!(text, "  \"{name}\"");
    }
    text
}

fn choice(args: &args::Conceal) -> Result<Choice, Failure> {
    if args.nothing {
        return Ok(Choice::Nothing);
    }
    let mut ids = Vec::new();
    for wanted in &args.effects {
        if let Some(name) = sinew_concealed::outside().find(|name| name == wanted) {
            if args.effects.len() > 1 {
                return Err(Failure::input(format!("--effect {name:?}: is outside the catalogue, and hidden alone"))
                    .hint("give it without another --effect"));
            }
            return Ok(Choice::Outside(name));
        }
        let Some(id) = sinew_concealed::effects().find(|id| id == wanted) else { return Err(unknown(wanted)) };
        if ids.contains(&id) {
            return Err(Failure::input(format!("--effect {id}: is given twice")).hint("give every effect once"));
        }
        ids.push(id);
    }
    match ids.len() {
        0 => Ok(Choice::Random),
        1..=MOST_EFFECTS => Ok(Choice::Effects(ids)),
        count => Err(Failure::input(format!("--effect: {count} effects are more than a recording can tell of"))
            .hint(format!("hide {MOST_EFFECTS} at most"))),
    }
}

fn unknown(wanted: &str) -> Failure {
    let failure = Failure::input(format!("--effect {wanted:?}: nothing of that name can be hidden"));
    let known = sinew_concealed::effects().chain(sinew_concealed::outside());
    match nearest(wanted, known) {
        Some(near) => failure.hint(format!("did you mean {near:?}? `sinew conceal --list` has them all")),
        None => failure.hint("`sinew conceal --list` has them all"),
    }
}

/// The rig is called like the folder, as far as a rig may be.
fn name(folder: &Path) -> String {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let plain: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || "-_.".contains(*c)).take(32).collect();
    if plain.starts_with(|c: char| c.is_ascii_alphanumeric()) { plain } else { "concealed".into() }
}

fn random() -> Result<u32, Failure> {
    getrandom::u32().map_err(|error| Failure::own(format!("no random numbers: {error}")).hint("give a --seed"))
}

fn recording(name: &str, table: &Table) -> Result<Recording, Failure> {
    let broken = |error: sinew_recording::Error| Failure::own(format!("{name}: {}", error.message()));
    // a clock counts microseconds
    let times = table.time_s.iter().map(|time| (time * 1e6).round() / 1e6).collect();
    let mut recording = Recording::new(name, times).map_err(broken)?;
    for (name, values) in &table.columns {
        let column = Column::from_name(name).ok_or_else(|| Failure::own(format!("{name}: is no column")))?;
        recording.set(column, values.clone()).map_err(broken)?;
    }
    Ok(recording)
}

/// `sinew reveal --json`.
#[derive(Serialize)]
struct Revealed<'a> {
    schema: &'static str,
    seal: &'a str,
    /// Files that are not as they were sealed.
    changed: &'a [String],
    hidden: &'a Answer,
    /// Null where there is no answer of a diagnosis.
    found: Option<&'a Reported>,
    right: Option<bool>,
    /// What is wrong, where something is.
    wrong: Option<&'static str>,
}

/// Runs `sinew reveal`.
pub fn reveal(args: &args::Reveal) -> Outcome {
    let path = args.folder.join(SEALED);
    let text = fs::read_to_string(&path).map_err(|error| {
        Failure::input(format!("{}: cannot be read: {error}", path.display()))
            .hint("name a folder that `sinew conceal` made")
    })?;
    let (sealed, seal) = Sealed::open(&text).map_err(|error| {
        Failure::input(format!("{}: {error}", path.display())).hint("take the file as `sinew conceal` wrote it")
    })?;
    if let Some(kept) = args.seal.as_deref().map(|kept| kept.trim_end_matches(['…', '.']))
        && (kept.len() < 4 || !seal.starts_with(&kept.to_lowercase()))
    {
        return Err(Failure::input(format!("{}: has the seal {seal}, not {kept}", path.display())).hint(
            "it is another envelope than the one whose seal was kept; without --seal it is opened all the same",
        ));
    }
    let changed = changed(&args.folder, &sealed.files);
    let reported = reported(args)?;
    let judged = reported.map(|reported| Judged { answer: sealed.answer.clone(), reported, long: false });
    if args.json {
        return output::print_json(&Revealed {
            schema: "sinew.reveal/1",
            seal: &seal,
            changed: &changed,
            hidden: &sealed.answer,
            found: judged.as_ref().map(|judged| &judged.reported),
            right: judged.as_ref().map(Judged::right),
            wrong: judged.as_ref().and_then(Judged::failure),
        });
    }
    for name in &changed {
        output::note(format_args!(
            "warning: {}: is not as it was sealed: what is hidden was hidden in another",
            args.folder.join(name).display()
        ));
    }
    let mut text = hidden(&sealed.answer);
    match &judged {
        Some(judged) => text += &beside(judged),
        None => {
            let folder = answer_folder(args);
            let _ =
                writeln!(text, "No answer lies in {} to set beside it: `sinew diagnose` writes one.", folder.display());
        }
    }
    output::print(text)
}

fn answer_folder(args: &args::Reveal) -> PathBuf {
    args.answer.clone().unwrap_or_else(|| args.folder.join(ANSWER))
}

/// What a diagnosis reported, where there is one. One that was asked for has to be there.
fn reported(args: &args::Reveal) -> Result<Option<Reported>, Failure> {
    let path = answer_folder(args).join(JSON);
    if args.answer.is_none() && !path.exists() {
        return Ok(None);
    }
    let hint = "--answer names the folder that `sinew diagnose --out` wrote";
    let text = fs::read(&path)
        .map_err(|error| Failure::input(format!("{}: cannot be read: {error}", path.display())).hint(hint))?;
    let reported = Reported::read(&text)
        .map_err(|error| Failure::input(format!("{}: is no answer: {error}", path.display())).hint(hint))?;
    Ok(Some(reported))
}

/// Files that are not, or no longer, those that were sealed.
fn changed(folder: &Path, files: &BTreeMap<String, String>) -> Vec<String> {
    let differs =
        |(name, hash): &(&String, &String)| fs::read(folder.join(name)).map_or(true, |bytes| sha256(&bytes) != **hash);
    files.iter().filter(differs).map(|(name, _)| name.clone()).collect()
}

fn hidden(answer: &Answer) -> String {
    let what = match answer.group.as_str() {
        "null" => "nothing: only parameters are off, within their tolerances".to_string(),
        "outside" => format!("{}, which is outside the catalogue", answer.kind),
        _ => answer.kind.clone(),
    };
    let mut text = format!("Hidden: {what}\n");
    if answer.group != "null" {
        let _ = writeln!(
            text,
            "        {:.1} times the noise is left of it once all parameters are refitted",
            answer.level
        );
    }
    text
}

/// What was found, and the sizes beside each other.
fn beside(judged: &Judged) -> String {
    let Judged { answer, reported, .. } = judged;
    let named: Vec<&str> = reported.effects.iter().map(|effect| effect.id.as_str()).collect();
    let names = if named.is_empty() { String::new() } else { format!(": {}", named.join(", ")) };
    let mut text = format!("Found:  {}{names}\n", reported.verdict.as_deref().unwrap_or("no answer"));
    let rows = sizes(judged);
    if !rows.is_empty() {
        let widths: [usize; 3] =
            std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
        text.push('\n');
        for row in &rows {
            let [a, b, c] = widths;
            let _ = writeln!(text, "  {:<a$}  {:>b$}  {:>c$}  {}", row[0], row[1], row[2], row[3]);
        }
    }
    let known = reported.parameters.iter().filter_map(|(key, ends)| Some((answer.parameters.get(key)?, ends)));
    let (held, of) = known
        .fold((0, 0), |(held, of), (truth, [low, high])| (held + usize::from(low <= truth && truth <= high), of + 1));
    if of > 0 {
        let _ = writeln!(
            text,
            "\n{held} of {of} parameters that the rig file did not know exactly lie in their 90 % intervals"
        );
    }
    let hidden_by_fit = answer.group == "single" && Level::of(answer.level) == Level::Hidden;
    let _ = match judged.failure() {
        None if hidden_by_fit => writeln!(text, "Right: so little is left of it that nothing else had to be named."),
        None => writeln!(text, "Right."),
        Some(wrong) => writeln!(text, "Not right: {wrong}."),
    };
    text
}

/// A row for every parameter of what is hidden: its name, its value, what was found, the interval.
fn sizes(judged: &Judged) -> Vec<[String; 4]> {
    let mut rows = Vec::new();
    for (id, parameters) in &judged.answer.effects {
        let found = judged.reported.effects.iter().find(|named| named.id == *id);
        for (key, truth) in parameters {
            let size = found.and_then(|named| named.sizes.get(key));
            let [value, interval] = match size {
                Some([value, low, high]) => [digits(*value), format!("{} to {}", digits(*low), digits(*high))],
                None => ["not found".into(), String::new()],
            };
            rows.push([format!("{id}.{key}"), digits(*truth), value, interval]);
        }
    }
    if !rows.is_empty() {
        rows.insert(0, ["".into(), "hidden".into(), "found".into(), "90 % interval".into()]);
    }
    rows
}

/// Four digits.
fn digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals = 3 - value.abs().log10().floor() as i32;
    if (-6..=9).contains(&decimals) { format!("{value:.*}", decimals.max(0) as usize) } else { format!("{value:.3e}") }
}
