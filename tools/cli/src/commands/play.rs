//! `sinew play`: setpoints from a CSV file, row by row at their times, to a running driver; one request for all channels.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use csv::{ReaderBuilder, StringRecord, Trim};
use sinew_ipc::{Client, CommandKind, Error, Wanted};

use super::monitor::signals;
use super::{live, unknown_channel};
use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::setpoint::Setpoint;

/// First column of the file.
const TIME: &str = "time_s";
/// A lease is renewed so many times before it runs out.
const RENEWALS: f64 = 3.0;
/// The longest sleep: somebody may want it to end.
const NAP: Duration = Duration::from_millis(20);

/// A file as it is to be played.
#[derive(Debug)]
struct Score {
    /// Names of its channels, in the order of its columns.
    channels: Vec<String>,
    rows: Vec<Row>,
}

#[derive(Debug, PartialEq)]
struct Row {
    time_s: f64,
    /// Of each channel what is wanted from then on; `None` as before.
    setpoints: Vec<Option<Setpoint>>,
}

/// Runs the command.
pub fn play(args: &args::Play) -> Outcome {
    let score = read(&args.file)?;
    let client = live::connect(&args.target)?;
    let mut channels = Vec::new();
    for name in &score.channels {
        let known = client.channels().iter().map(|info| info.name.as_str());
        let place = format!("{}: rig {}", args.file.display(), client.info().rig);
        channels.push(client.info().index_of(name).ok_or_else(|| unknown_channel(&place, name, known))?);
    }
    let asked = signals()?;
    let last_s = score.rows.last().map_or(0.0, |row| row.time_s);
    output::note(format_args!(
        "playing {} rows for {} channels of {}, {:.1} s{}; Ctrl-C ends it",
        score.rows.len(),
        channels.len(),
        client.info().rig,
        last_s / args.speed,
        if args.times > 1 { format!(", {} times", args.times) } else { String::new() }
    ));
    let mut player = Player {
        client: &client,
        channels,
        wanted: Vec::new(),
        hold_s: args.hold_s,
        priority: args.priority,
        latest: Duration::ZERO,
    };
    player.claim().map_err(live::failure)?;
    let is_over = || asked.load(Ordering::Relaxed);
    let played = player.play(&score, args.speed, args.times, &is_over);
    // Whatever has happened: the wires are handed back. Were this program killed instead, their leases would see to it.
    let off = if args.keep && played.is_ok() { Ok(()) } else { player.off() };
    // One that is not let go of lapses.
    let _ = client.release(&player.numbers());
    let rows = played.map_err(live::failure)?;
    off.map_err(live::failure)?;
    output::print(format_args!(
        "played {rows} rows, the latest {:.1} ms after its time; {}\n",
        player.latest.as_secs_f64() * 1e3,
        if args.keep { "the last setpoints run out with their lease" } else { "its channels are off" }
    ))
}

/// Plays to a driver.
struct Player<'a> {
    client: &'a Client,
    /// Number of each column's channel.
    channels: Vec<usize>,
    /// What is wanted now.
    wanted: Vec<Wanted>,
    hold_s: f64,
    /// Of the claim of all its channels, if they are claimed.
    priority: Option<u32>,
    /// How long after its time a row was taken, at the most.
    latest: Duration,
}

impl Player<'_> {
    /// All rows, so many times; how many were played.
    fn play(&mut self, score: &Score, speed: f64, times: u32, is_over: &impl Fn() -> bool) -> Result<u64, Error> {
        let mut played = 0;
        for _ in 0..times {
            let started = Instant::now();
            for row in &score.rows {
                let due = started + Duration::from_secs_f64(row.time_s / speed);
                if !self.wait_until(due, is_over)? {
                    return Ok(played);
                }
                self.change(&row.setpoints);
                self.send()?;
                self.latest = self.latest.max(due.elapsed());
                played += 1;
            }
        }
        Ok(played)
    }

    /// Keeps what is wanted until then; false where it is over before.
    fn wait_until(&self, due: Instant, is_over: &impl Fn() -> bool) -> Result<bool, Error> {
        let renewal = Duration::from_secs_f64(self.hold_s / RENEWALS);
        let mut renew = Instant::now() + renewal;
        loop {
            if is_over() {
                return Ok(false);
            }
            let now = Instant::now();
            if now >= due {
                return Ok(true);
            }
            if now >= renew {
                self.send()?;
                renew = now + renewal;
            }
            std::thread::sleep(NAP.min(due.min(renew).saturating_duration_since(now)));
        }
    }

    fn change(&mut self, setpoints: &[Option<Setpoint>]) {
        for (&channel, setpoint) in self.channels.iter().zip(setpoints) {
            let Some(setpoint) = setpoint else { continue };
            let (kind, value) = live::command(*setpoint, &self.client.channels()[channel]);
            let channel = channel as u32;
            self.wanted.retain(|wanted| wanted.channel != channel);
            self.wanted.push(Wanted { channel, kind, value });
        }
    }

    fn numbers(&self) -> Vec<u32> {
        self.channels.iter().map(|channel| *channel as u32).collect()
    }

    fn claim(&self) -> Result<(), Error> {
        let Some(priority) = self.priority else { return Ok(()) };
        self.client.claim(&self.numbers(), priority, Duration::from_secs_f64(self.hold_s)).map(|_| ())
    }

    fn send(&self) -> Result<(), Error> {
        // of channels that nothing is asked of yet, or no longer
        if self.wanted.len() < self.channels.len() {
            self.claim()?;
        }
        let is_off = self.wanted.iter().all(|wanted| wanted.kind == CommandKind::Off);
        let hold = if is_off { Duration::ZERO } else { Duration::from_secs_f64(self.hold_s) };
        if self.wanted.is_empty() { Ok(()) } else { self.client.set_many(&self.wanted, hold).map(|_| ()) }
    }

    /// Every channel that was commanded.
    fn off(&mut self) -> Result<(), Error> {
        for wanted in &mut self.wanted {
            (wanted.kind, wanted.value) = (CommandKind::Off, 0.0);
        }
        self.send()
    }
}

/// Reads a file: `time_s` and a column for each channel, with a setpoint as in the monitor in each cell, or nothing.
fn read(path: &Path) -> Result<Score, Failure> {
    let place = path.display();
    let broken = |error: csv::Error| {
        let failure = Failure::input(format!("{place}: {error}"));
        if error.is_io_error() { failure.hint("check the path") } else { failure.hint(form()) }
    };
    let mut csv = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_path(path).map_err(broken)?;
    let header = csv.headers().map_err(broken)?.clone();
    let channels: Vec<String> = header.iter().skip(1).map(str::to_string).collect();
    if header.get(0) != Some(TIME) || channels.is_empty() {
        return Err(
            Failure::input(format!("{place}:1: no `{TIME}` and a channel for every further column")).hint(form())
        );
    }
    if let Some(twice) =
        channels.iter().enumerate().find_map(|(at, name)| channels[..at].contains(name).then_some(name))
    {
        return Err(
            Failure::input(format!("{place}:1: `{twice}` stands there twice")).hint("a column for each channel")
        );
    }
    let mut rows: Vec<Row> = Vec::new();
    for record in csv.records() {
        let record = record.map_err(broken)?;
        let line = record.position().map_or(0, |position| position.line());
        let row = row(&record, &channels)
            .map_err(|(message, hint)| Failure::input(format!("{place}:{line}: {message}")).hint(hint))?;
        if rows.last().is_some_and(|before| before.time_s >= row.time_s) {
            return Err(Failure::input(format!("{place}:{line}: {TIME} {} is not after the row before", row.time_s))
                .hint("rows stand in the order of their times"));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(Failure::input(format!("{place}: has no rows")).hint(form()));
    }
    Ok(Score { channels, rows })
}

fn row(record: &StringRecord, channels: &[String]) -> Result<Row, (String, String)> {
    let time = record.get(0).unwrap_or_default();
    let time_s = time.parse().ok().filter(|time_s: &f64| time_s.is_finite() && *time_s >= 0.0);
    let time_s =
        time_s.ok_or_else(|| (format!("`{time}` is no time"), "seconds from the start, 0 or more".to_string()))?;
    let setpoint = |(cell, name): (&str, &String)| match cell {
        "" => Ok(None),
        cell => Setpoint::parse_typed(cell).map(Some).map_err(|e| (format!("{name}: {}", e.message), e.hint)),
    };
    let setpoints = record.iter().skip(1).zip(channels).map(setpoint).collect::<Result<_, _>>()?;
    Ok(Row { time_s, setpoints })
}

fn form() -> String {
    format!("a first line such as `{TIME},left,right`, then rows such as `0.5,40%,` or `1.5,164mm,off`")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Score, Failure> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read(file.path())
    }

    #[test]
    fn cells_are_setpoints_and_empty_ones_change_nothing() {
        let score = read_text("time_s, left, right\n# a comment\n0, 10%, off\n0.5, 164mm,\n2,,duty=0.1\n").unwrap();
        assert_eq!(score.channels, ["left", "right"]);
        let rows: Vec<_> = score.rows.iter().map(|row| (row.time_s, row.setpoints.clone())).collect();
        let expected = [
            (0.0, vec![Some(Setpoint::Stroke(0.1)), Some(Setpoint::Off)]),
            (0.5, vec![Some(Setpoint::Length(0.164)), None]),
            (2.0, vec![None, Some(Setpoint::Duty(0.1))]),
        ];
        assert_eq!(rows, expected);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_a_remedy() {
        for (text, message) in [
            ("", "no `time_s`"),
            ("time_s\n0\n", "no `time_s`"),
            ("left,right\n0,1\n", "no `time_s`"),
            ("time_s,left,left\n0,1,1\n", "`left` stands there twice"),
            ("time_s,left\n", "no rows"),
            ("time_s,left\n0,10%\n0,20%\n", ":3: time_s 0 is not after"),
            ("time_s,left\n0,10%\nlater,20%\n", ":3: `later` is no time"),
            ("time_s,left\n0,10%\n1,140%\n", ":3: left: `stroke=140%` is outside"),
            ("time_s,left\n0,10%\n1,20%,30%\n", "3"),
        ] {
            let said = read_text(text).map(|_| ()).expect_err(text).to_string();
            assert!(said.contains(message) && said.contains("hint: "), "{text:?}: {said}");
        }
    }
}
