//! The table of threads.

use std::fmt::Write as _;

/// A thread that is there for as long as its program runs, or does its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs, reason = "TABLE says what each is")]
pub enum Thread {
    Main,
    Loop,
    Publisher,
    Desk,
    Signals,
    Keys,
    Words,
    Janitor,
    BlackBox,
    Line,
    Mender,
    Recorder,
    Writer,
    Watcher,
    Reader,
    Herald,
    Account,
    Feeder,
}

/// What comes of a thread's death.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comes {
    /// Its program ends, in order and with exit code 1; a driver's outputs are zero before anything else is done.
    End,
    /// Its program goes on without it, and publishes that.
    Less,
}

/// A row of the [table](TABLE).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Which thread.
    pub thread: Thread,
    /// Its name: for the system (after `sinew-`), for `--json`, and in words.
    pub name: &'static str,
    /// Which programs have it.
    pub of: &'static str,
    /// What it does, as the rest of "the thread that …".
    pub does: &'static str,
    /// What comes of its death.
    pub comes: Comes,
    /// The same, for a person.
    pub words: &'static str,
}

const fn row(
    thread: Thread,
    name: &'static str,
    of: &'static str,
    does: &'static str,
    comes: Comes,
    words: &'static str,
) -> Row {
    Row { thread, name, of, does, comes, words }
}

/// Every thread, in the order of [`Thread`].
pub const TABLE: [Row; 18] = [
    row(
        Thread::Main,
        "main",
        "`run`",
        "shows what the driver does and writes its report",
        Comes::End,
        "the driver ends: outputs are zero before the terminal is touched again",
    ),
    row(
        Thread::Loop,
        "loop",
        "`run`, `bench loop`",
        "measures and moves the wires",
        Comes::End,
        "the driver ends: outputs are zero before anything is said",
    ),
    row(
        Thread::Publisher,
        "publisher",
        "`run`, `bench loop`",
        "hands every cycle on to clients, black box and accounts",
        Comes::End,
        "the driver ends: nobody could see any more what it does",
    ),
    row(
        Thread::Desk,
        "desk",
        "`run`, `bench loop`",
        "answers commands",
        Comes::End,
        "the driver ends: nobody could command it or stop it any more",
    ),
    row(
        Thread::Signals,
        "signals",
        "`run`",
        "hears signals",
        Comes::End,
        "the driver ends: no SIGTERM or Ctrl-C could end it any more",
    ),
    row(
        Thread::Keys,
        "keys",
        "`run` and `monitor` with a screen",
        "reads the keys",
        Comes::End,
        "the screen closes, and `run` ends as if `q` had been pressed; so it does when the terminal is gone",
    ),
    row(
        Thread::Words,
        "words",
        "`run`, `bench loop`, `record`, `scope`, `bridge`, `monitor`",
        "writes messages to the terminal",
        Comes::Less,
        "nothing more is written or shown there; a report in a file is",
    ),
    row(
        Thread::Janitor,
        "janitor",
        "`run`, `bench loop`",
        "clears away what dead clients leave",
        Comes::Less,
        "what dead clients leave stays until the driver is started anew: when 256 places are taken newcomers are refused",
    ),
    row(
        Thread::BlackBox,
        "blackbox",
        "`run`",
        "writes black boxes",
        Comes::Less,
        "there are no black boxes until the driver is started anew",
    ),
    row(
        Thread::Line,
        "line",
        "`run` with a serial front-end",
        "opens a lost line again",
        Comes::Less,
        "a line that is lost stays lost, its wires off, until the driver is started anew",
    ),
    row(
        Thread::Mender,
        "mender",
        "`run` on Linux's own outputs",
        "opens lost devices and starts a lost guard again",
        Comes::Less,
        "what is lost of devices and guard stays lost, the wires off, until the driver is started anew",
    ),
    row(
        Thread::Recorder,
        "recorder",
        "`record`, `scope`",
        "takes the cycles of a recording from the driver",
        Comes::End,
        "the recording ends with a whole file of what had come",
    ),
    row(
        Thread::Writer,
        "writer",
        "`record`, `scope`",
        "writes the cycles of a recording",
        Comes::End,
        "the recording ends; `sinew recording recover` brings back what its last file has",
    ),
    row(
        Thread::Watcher,
        "watcher",
        "`scope`, `bridge foxglove`, `bridge zenoh`",
        "watches the driver for those who look on",
        Comes::End,
        "the scope or the bridge ends: those who look on would be shown a past that looks like the present",
    ),
    row(
        Thread::Reader,
        "reader",
        "`replay`",
        "reads a recording ahead",
        Comes::End,
        "the replay ends with an error, not as if the recording had",
    ),
    row(
        Thread::Herald,
        "herald",
        "`run` as a service",
        "tells the service manager that the loop goes on",
        Comes::End,
        "the driver ends: the service manager would kill it, for want of a word",
    ),
    row(
        Thread::Account,
        "account",
        "`run`",
        "writes the accounts of the wires' lives",
        Comes::Less,
        "nothing is added to the accounts until the driver is started anew",
    ),
    row(
        Thread::Feeder,
        "feeder",
        "`demo`",
        "hands a robot program what its sensor says",
        Comes::End,
        "the driver ends: its robot program would balance blindly",
    ),
];

impl Thread {
    /// Its row.
    pub const fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }

    /// Its bit in what is published of dead threads.
    pub const fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// The rows of dead threads, as they are published: see [`dead`](crate::dead).
pub fn rows(dead: u32) -> impl Iterator<Item = &'static Row> {
    TABLE.iter().filter(move |row| dead & row.thread.bit() != 0)
}

/// The table for `docs/`.
pub fn table_markdown() -> String {
    let mut text = String::from("| thread | of | does | its death |\n|---|---|---|---|\n");
    for Row { name, of, does, comes, words, .. } in &TABLE {
        let comes = match comes {
            Comes::End => "ends",
            Comes::Less => "goes on",
        };
        let _ = writeln!(text, "| `{name}` | {of} | {does} | **{comes}**: {words} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_thread_has_its_row_and_a_name_the_system_takes() {
        for (place, row) in TABLE.iter().enumerate() {
            assert_eq!(row.thread as usize, place, "{}", row.name);
            assert_eq!(row.thread.row(), row);
            // Linux takes fifteen bytes.
            assert!("sinew-".len() + row.name.len() <= 15, "{}", row.name);
        }
        assert_eq!(TABLE.iter().map(|row| row.name).collect::<BTreeSet<_>>().len(), TABLE.len());
        let names = |dead| rows(dead).map(|row| row.name).collect::<Vec<_>>();
        assert_eq!(names(0), [""; 0]);
        assert_eq!(names(Thread::Line.bit() | Thread::Main.bit()), ["main", "line"]);
        assert_eq!(names(u32::MAX).len(), TABLE.len(), "bits of a later version are nobody's here");
    }
}
