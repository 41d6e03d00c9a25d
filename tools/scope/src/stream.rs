//! A stream of numbers as text, from a pipe or a serial line, as curves: chapter 8's plotter (fig. 84).

pub mod columns;
pub mod lines;

use std::io;
use std::os::fd::OwnedFd;
use std::sync::PoisonError;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use serde::Serialize;
use sinew_server::Figures;

use self::columns::{Came, Column, Columns};
use self::lines::Lines;
use crate::history::{FINEST_HZ, Shape};
use crate::shared::Shared;
use crate::view::{Hello, Panel, json};
use crate::watch::{LOOK, RETRY};

/// For how long at most the curves reach back, s.
const LONGEST_S: f64 = 600.0;
/// Silence for so long is said.
const SILENCE: Duration = Duration::from_secs(3);
/// Rows that come together came no further apart than this, s: a pipe hands over in pieces what was written evenly.
const APART_S: f64 = 0.02;
/// A board's clock that leaps ahead by so much, s, is believed once so many rows on end say so.
const LEAP_S: f64 = 10.0;
const BELIEVED: u32 = 3;
/// A rate is counted over at least this long.
const RATE_SPAN: Duration = Duration::from_secs(1);

/// Opens a line anew.
type Again = Box<dyn FnMut() -> io::Result<OwnedFd> + Send>;

/// Where numbers come from.
pub struct Stream {
    name: String,
    line: OwnedFd,
    again: Option<Again>,
    names: Vec<String>,
}

impl Stream {
    /// What is written into this pipe. The name is that of the page and of the recordings.
    pub fn of_pipe(name: &str, pipe: OwnedFd) -> Stream {
        Stream { name: name.to_string(), line: pipe, again: None, names: Vec::new() }
    }

    /// A line that somebody may be writing on already, and that is opened again when it breaks off.
    pub fn of_line(name: &str, line: OwnedFd, again: impl FnMut() -> io::Result<OwnedFd> + Send + 'static) -> Stream {
        Stream { again: Some(Box::new(again)), ..Stream::of_pipe(name, line) }
    }

    /// The numbers have these names, with their units: `force [N]`, `temp_C`.
    pub fn named(self, names: &[String]) -> Stream {
        Stream { names: names.to_vec(), ..self }
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }
}

/// What the curves of so many columns are kept in.
pub(crate) fn shape(columns: usize, rate_hz: f64) -> Shape {
    Shape { channels: columns, quantities: 1, rate_hz, longest_s: LONGEST_S }
}

/// The numbers as a page is told of them: a panel for each unit, and in which one a column is.
pub(crate) fn hello(name: &str, columns: &[Column], records: bool, shape: &Shape, epoch: u64) -> String {
    #[derive(Serialize)]
    struct Channel<'a> {
        name: &'a str,
        /// Number of its panel.
        panel: usize,
        /// Whether it is the clock of the rows.
        clock: bool,
    }
    let mut units: Vec<&str> = Vec::new();
    let clock = Clock::find(columns).map(|(at, _)| at);
    let channels = columns.iter().enumerate().map(|(at, column)| {
        let panel = units.iter().position(|unit| *unit == column.unit).unwrap_or_else(|| {
            units.push(&column.unit);
            units.len() - 1
        });
        Channel { name: &column.name, panel, clock: clock == Some(at) }
    });
    let channels: Vec<Channel<'_>> = channels.collect();
    let quantities = units.iter().map(|unit| match *unit {
        "" => Panel { name: "numbers", title: "Numbers".into(), unit: "1" },
        unit => Panel { name: unit, title: unit.into(), unit },
    });
    json(&Hello::new("stream", name, records, shape, epoch).with(quantities, channels.into_iter()))
}

#[derive(Serialize)]
struct Status<'a> {
    kind: &'static str,
    /// How the line does: `running`, `waiting`, `silent`, `broken`, `ended`.
    driver: &'static str,
    rate_hz: f64,
    rows: u64,
    odd: u64,
    /// The last line that was none of numbers.
    words: &'a str,
    /// Why a recording has ended.
    problem: &'a str,
    lost: u64,
    recording: Option<crate::record::State>,
    traffic: Figures,
    channels: [u8; 0],
}

/// Reads until the scope is to stop.
pub(crate) fn watch(shared: &Shared, stream: Stream) {
    let Stream { line, mut again, names, .. } = stream;
    let mut reading = Reading::new(shared, Columns::named(&names));
    let mut lines = if again.is_some() { Lines::from_the_middle() } else { Lines::default() };
    let mut line = Some(line);
    let stopping = || shared.stop.load(Ordering::Relaxed) || sinew_threads::is_struck();
    let mut bytes = vec![0; 1 << 16];
    while !stopping() {
        let Some(open) = &line else {
            std::thread::sleep(RETRY);
            reading.look();
            if let Some(Ok(new)) = again.as_mut().map(|again| again()) {
                line = Some(new);
                lines = Lines::from_the_middle();
                reading.goes_on();
            }
            continue;
        };
        let mut ready = [PollFd::new(open, PollFlags::IN)];
        let patience = Timespec { tv_sec: 0, tv_nsec: LOOK.as_nanos() as i64 / 2 };
        let came = match poll(&mut ready, Some(&patience)) {
            Ok(0) | Err(Errno::INTR) => None,
            Ok(_) => Some(rustix::io::read(open, &mut bytes[..])),
            Err(error) => Some(Err(error)),
        };
        match came {
            None | Some(Err(Errno::AGAIN | Errno::INTR)) => {}
            Some(Ok(count)) if count > 0 => reading.take(&mut lines, &bytes[..count]),
            // the end of a pipe, or of a device that was unplugged
            Some(_) => {
                if let Some(last) = lines.rest().filter(|_| again.is_none()) {
                    reading.take(&mut lines, format!("{last}\n").as_bytes());
                }
                reading.breaks_off(again.is_some());
                line = None;
            }
        }
        reading.look();
    }
}

/// What has been read.
struct Reading<'a> {
    shared: &'a Shared,
    columns: Columns,
    clock: Clock,
    state: &'static str,
    rows: u64,
    odd: u64,
    words: String,
    problem: String,
    /// When something last came, and when the last look was.
    came: Instant,
    looked: Option<Instant>,
    /// The rate, and the rows and the moment it is counted from.
    rate_hz: f64,
    since: (u64, Instant),
}

impl<'a> Reading<'a> {
    fn new(shared: &'a Shared, columns: Columns) -> Reading<'a> {
        let now = Instant::now();
        Reading {
            shared,
            columns,
            clock: Clock::default(),
            state: "waiting",
            rows: 0,
            odd: 0,
            words: String::new(),
            problem: String::new(),
            came: now,
            looked: None,
            rate_hz: f64::NAN,
            since: (0, now),
        }
    }

    /// Takes in what has come.
    fn take(&mut self, lines: &mut Lines, bytes: &[u8]) {
        let now_s = self.shared.seconds(sinew_ipc::monotonic_ns());
        let (columns, odd, words) = (&mut self.columns, &mut self.odd, &mut self.words);
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut others = None;
        lines.take(bytes, |line| match line.map(|line| (line, columns.take(line))) {
            Some((_, Came::Nothing | Came::Names)) => {}
            Some((line, Came::Odd)) => {
                *odd += 1;
                *words = line.trim().chars().take(200).collect();
            }
            None => *odd += 1,
            Some((_, came)) => {
                if came == Came::Others {
                    others = Some(rows.len());
                }
                if columns.row().iter().any(|number| !number.is_nan()) {
                    rows.push(columns.row().to_vec());
                }
            }
        });
        if rows.is_empty() && others.is_none() {
            return;
        }
        self.came = Instant::now();
        self.state = "running";
        self.rows += rows.len() as u64;
        if others.is_some() {
            self.clock.column = Clock::find(self.columns.columns());
            self.begin();
        }
        let times = self.clock.times(&rows, now_s);
        let mut recorder = self.shared.recorder.lock().unwrap_or_else(PoisonError::into_inner);
        let mut view = self.shared.view();
        for (row, time) in rows.iter().zip(times) {
            if time.is_anew {
                view.history.gap(time.seconds);
            }
            view.history.push(time.seconds, row.iter().map(|number| *number as f32));
            if let Err(why) = recorder.row(time.seconds, row) {
                self.problem = why;
            }
        }
    }

    /// The columns are these from here on.
    fn begin(&mut self) {
        let columns = self.columns.columns();
        let heads = columns.iter().map(Column::heading).collect();
        let named = self.shared.recorder.lock().unwrap_or_else(PoisonError::into_inner).name_columns(heads);
        if let Err(why) = named {
            self.problem = why;
        }
        let rate_hz = if self.rate_hz > 1.1 * FINEST_HZ { self.rate_hz } else { FINEST_HZ };
        let (name, records) = (&self.shared.name, self.shared.options.commands);
        self.shared
            .view()
            .begin(shape(columns.len(), rate_hz), |shape, epoch| hello(name, columns, records, shape, epoch));
    }

    fn breaks_off(&mut self, is_waited_for: bool) {
        self.state = if is_waited_for { "broken" } else { "ended" };
        self.shared.view().history.gap(self.shared.seconds(sinew_ipc::monotonic_ns()));
        self.looked = None;
    }

    fn goes_on(&mut self) {
        self.state = "waiting";
        self.clock.is_anew = true;
        self.came = Instant::now();
    }

    /// Says how it does, where that is due.
    fn look(&mut self) {
        if self.looked.is_some_and(|at| at.elapsed() < LOOK) {
            return;
        }
        self.looked = Some(Instant::now());
        if self.since.1.elapsed() >= RATE_SPAN {
            self.rate_hz = (self.rows - self.since.0) as f64 / self.since.1.elapsed().as_secs_f64();
            self.since = (self.rows, Instant::now());
            // faster than a bin a row: from here on bins keep the least and the largest
            if self.rate_hz > 1.1 * FINEST_HZ && self.shared.view().history.shape().values() == 1 {
                self.begin();
            }
        }
        if self.state == "running" && self.came.elapsed() > SILENCE {
            self.state = "silent";
        }
        let recording = self.shared.recorder.lock().unwrap_or_else(PoisonError::into_inner).state();
        let status = json(&Status {
            kind: "status",
            driver: self.state,
            rate_hz: self.rate_hz,
            rows: self.rows,
            odd: self.odd,
            words: &self.words,
            problem: &self.problem,
            lost: 0,
            recording,
            traffic: self.shared.figures(),
            channels: [],
        });
        self.shared.view().status = status;
    }
}

/// When rows were made: by a column of times if there is one, else by when they came.
#[derive(Default)]
struct Clock {
    /// Its number, and how long its unit is, s.
    column: Option<(usize, f64)>,
    /// The moment on the curves' axis at which that column says 0, s.
    origin_s: Option<f64>,
    last_s: f64,
    /// How many rows on end were far ahead of it.
    leaps: u32,
    /// Something is missing before the next row.
    is_anew: bool,
}

/// When a row was made.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Time {
    seconds: f64,
    /// Something is missing before it.
    is_anew: bool,
}

impl Clock {
    /// The column that a board or a program writes its clock into: the first, called so and in a unit of time.
    fn find(columns: &[Column]) -> Option<(usize, f64)> {
        let first = columns.first()?;
        let called = ["t", "time", "zeit", "temps", "timestamp", "millis", "micros", "uptime"];
        if !called.contains(&first.name.to_lowercase().as_str()) {
            return None;
        }
        let unit = match (first.unit.as_str(), first.name.to_lowercase().as_str()) {
            ("s", _) => 1.0,
            ("ms", _) | ("", "millis") => 1e-3,
            ("µs", _) | ("", "micros") => 1e-6,
            ("min", _) => 60.0,
            _ => return None,
        };
        Some((0, unit))
    }

    fn times(&mut self, rows: &[Vec<f64>], now_s: f64) -> Vec<Time> {
        let since = (now_s - self.last_s).max(0.0);
        let apart = (since / rows.len().max(1) as f64).min(APART_S);
        let times = rows.iter().enumerate().map(|(at, row)| {
            let arrived = now_s - apart * (rows.len() - 1 - at) as f64;
            let told = self.column.and_then(|(column, unit)| row.get(column).map(|value| value * unit));
            let mut is_anew = std::mem::take(&mut self.is_anew);
            let seconds = match told.filter(|told| told.is_finite()) {
                None => arrived,
                Some(told) => {
                    let by_clock = self.origin_s.map(|origin| origin + told);
                    let leaps = by_clock.is_some_and(|at| at > self.last_s.max(arrived) + LEAP_S);
                    self.leaps = if leaps { self.leaps + 1 } else { 0 };
                    match by_clock.filter(|at| *at > self.last_s && !is_anew && !leaps) {
                        Some(at) => at,
                        // a digit too many, once: else all that follows would lie in the past
                        None if leaps && self.leaps < BELIEVED => self.last_s,
                        // a clock that starts, or goes back because its board has been reset
                        None => {
                            is_anew |= self.origin_s.is_some();
                            self.origin_s = Some(arrived.max(self.last_s) - told);
                            arrived
                        }
                    }
                }
            };
            // two rows are never at one moment, and none is before another
            self.last_s = seconds.max(self.last_s + 1e-6);
            Time { seconds: self.last_s, is_anew }
        });
        times.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(times: &[f64]) -> Vec<Vec<f64>> {
        times.iter().map(|time| vec![*time, 1.0]).collect()
    }

    fn near(times: &[Time], wanted: &[f64]) {
        assert_eq!(times.len(), wanted.len());
        for (time, wanted) in times.iter().zip(wanted) {
            assert!((time.seconds - wanted).abs() < 1e-4, "{times:?}, not {wanted:?}");
        }
    }

    #[test]
    fn rows_that_come_together_were_not_made_together() {
        let mut clock = Clock::default();
        near(&clock.times(&rows(&[0.0]), 5.0), &[5.0]);
        near(&clock.times(&rows(&[0.0; 4]), 5.04), &[5.01, 5.02, 5.03, 5.04]);
        near(&clock.times(&rows(&[0.0; 2]), 9.0), &[8.98, 9.0]);
    }

    #[test]
    fn a_column_of_times_leads_until_its_board_is_reset() {
        let columns = [Column::of("t_ms"), Column::of("force [N]")];
        let mut clock = Clock { column: Clock::find(&columns), ..Clock::default() };
        assert_eq!(clock.column, Some((0, 1e-3)));
        near(&clock.times(&rows(&[1000.0]), 5.0), &[5.0]);
        // late, and yet in their places
        near(&clock.times(&rows(&[1010.0, 1020.0]), 5.5), &[5.01, 5.02]);
        let reset = clock.times(&rows(&[0.0, 10.0]), 6.0);
        near(&reset, &[5.98, 5.99]);
        assert_eq!((reset[0].is_anew, reset[1].is_anew), (true, false));
        // a digit too many is not the time, three of them are
        near(&clock.times(&rows(&[20.0, 99_000.0, 30.0]), 6.05), &[6.0, 6.0, 6.01]);
        near(&clock.times(&rows(&[99_000.0, 99_010.0, 99_020.0, 99_030.0]), 6.2)[2..], &[6.18, 6.19]);
        assert_eq!(Clock::find(&[Column::of("time")]), None, "of no unit");
        assert_eq!(Clock::find(&[Column::of("millis")]), Some((0, 1e-3)));
    }

    #[test]
    fn columns_of_one_unit_share_a_panel() {
        let columns = ["a [N]", "b", "c [N]"].map(Column::of);
        let told = hello("board", &columns, true, &shape(3, FINEST_HZ), 1);
        let told: serde_json::Value = serde_json::from_str(&told).unwrap();
        assert_eq!(
            told["channels"],
            serde_json::json!([
                { "name": "a", "panel": 0, "clock": false },
                { "name": "b", "panel": 1, "clock": false },
                { "name": "c", "panel": 0, "clock": false },
            ])
        );
        assert_eq!(told["quantities"][0]["unit"], "N");
    }
}
