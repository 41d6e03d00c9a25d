//! Runs a routine on a machine, period by period, with the limits checked, until either ends.

use crate::machine::{Machine, MachineError, Order, Reading};
use crate::routine::{Directive, Routine};
use crate::watch::{Breach, Watch};

/// One period: what was commanded, and what was measured at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Its start, s from the first row that is recorded.
    pub time_s: f64,
    /// What the routine wanted.
    pub directive: Directive,
    /// What the machine measured.
    pub reading: Reading,
    /// Temperature reckoned from the power, °C.
    pub reckoned_c: f64,
}

/// How a run ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Ending {
    /// All of the routine is done.
    Complete,
    /// The end was requested.
    Stopped,
    /// A limit was exceeded.
    Breach(Breach),
    /// The machine does not answer.
    Failed(MachineError),
}

impl std::fmt::Display for Ending {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Ending::Complete => write!(f, "complete"),
            Ending::Stopped => write!(f, "stopped before its end"),
            Ending::Breach(breach) => write!(f, "ended by a limit: {breach}"),
            Ending::Failed(error) => write!(f, "ended by a failure: {error}"),
        }
    }
}

/// What a run leaves.
#[derive(Debug, Clone)]
pub struct Ran {
    /// Every recorded period.
    pub rows: Vec<Row>,
    /// How it ended.
    pub ending: Ending,
}

/// Runs a routine to its end, the first breach of a limit, or until `go_on` says no. `go_on` gets every period (also those
/// that are not recorded) and the share that is done. Whatever the end, the outputs are zero after it.
pub fn run(
    machine: &mut dyn Machine,
    routine: &mut Routine,
    watch: &mut Watch,
    go_on: &mut dyn FnMut(&Row, bool, f64) -> bool,
) -> Ran {
    let mut rows = Vec::new();
    let ending = periods(machine, routine, watch, go_on, &mut rows);
    // off in any case; a machine that does not answer switches off by itself
    let off = machine.exchange(&Order::REST);
    let ending = match (ending, off) {
        (Ending::Complete, Err(error)) => Ending::Failed(error),
        (ending, _) => ending,
    };
    Ran { rows, ending }
}

fn periods(
    machine: &mut dyn Machine,
    routine: &mut Routine,
    watch: &mut Watch,
    go_on: &mut dyn FnMut(&Row, bool, f64) -> bool,
    rows: &mut Vec<Row>,
) -> Ending {
    let period_s = 1.0 / machine.spec().rate_hz;
    let mut reading = match machine.exchange(&Order::REST) {
        Ok(reading) => reading,
        Err(error) => return Ending::Failed(error),
    };
    let mut started_s = None;
    while let Some(directive) = routine.next(&reading) {
        reading = match machine.exchange(&directive.order) {
            Ok(reading) => reading,
            Err(error) => return Ending::Failed(error),
        };
        let is_recorded = routine.stages()[directive.stage].is_recorded;
        let start_s = reading.time_s - period_s;
        let looked = watch.look(&reading);
        let time_s = start_s - if is_recorded { *started_s.get_or_insert(start_s) } else { start_s };
        let row = Row { time_s, directive, reading, reckoned_c: watch.temperature_c() };
        if is_recorded {
            rows.push(row);
        }
        if let Err(breach) = looked {
            return Ending::Breach(breach);
        }
        if !go_on(&row, is_recorded, routine.progress()) {
            return Ending::Stopped;
        }
    }
    Ending::Complete
}
