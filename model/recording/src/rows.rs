//! The cycles of a session as the rows of a recording: one channel, in the contract's columns.
//!
//! **A driver's cycles.** What a cycle decided on goes out with the next one and is in force until the one after that, whose
//! sample comes from it:
//!
//! ```text
//! cycle        k−1            k             k+1
//! decides      d(k−1)
//! puts out                    d(k−1) ──────▶
//! samples                                   s(k+1)
//! row at                      time of k: duty = d(k−1), measured = s(k+1)
//! ```
//!
//! So the row of a cycle takes its duty from the cycle before and what was measured from the cycle after. Times are those
//! of the periods, which the samples are apart however late the loop woke; missed periods are longer rows. Where cycles
//! were lost, the last duty that is known is held to the next one. A wire that was not driven has no voltages.
//!
//! **Other cycles** (the test machine's, imported ones) are rows already: the fields with the contract's names are the
//! columns, the field `time_s` is the time.

use sinew_physics::WireModel;
use sinew_rig::{Rig, SamplingCircuit, Sensing};

use crate::column::{Column, TIME};
use crate::error::{Error, What};
use crate::options::Options;
use crate::recording::{MIN_SAMPLES, Recording, check_range};
use crate::session::{CycleView, Head, Session};

/// What kind of session comes from a driver: its cycles tell of decisions and samples, not of rows.
pub const DRIVER: &str = "driver";

/// Field of a driver's cycle that a column comes from.
const fn driver_field(column: Column) -> &'static str {
    match column {
        // raw: models of noise see what no observer has been at
        Column::PositionM => "measured_length_m",
        column => column.name(),
    }
}

/// How to read a driver's samples of one wire.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wire {
    /// Hot and unloaded: what the elongation is counted from, m.
    rest_m: f64,
    /// Switch and shunt under the wire where one input sees them: the taps stand on their voltage, Ω.
    low_ohm: Option<f64>,
    /// Whether it has taps.
    taps: bool,
    /// Whether its length is measured by them, and not guessed from its resistance.
    measured: bool,
}

/// Makes rows of one channel's cycles, handed over one by one.
#[derive(Debug)]
pub struct Rows {
    name: String,
    channel: usize,
    columns: Vec<Column>,
    /// The field each column comes from.
    fields: Vec<usize>,
    cells: Vec<f64>,
    last_s: Option<f64>,
    from: From,
}

#[derive(Debug)]
enum From {
    Driver(Driver),
    Plain {
        /// Field of the time; without one, the clock.
        time: Option<usize>,
        /// Since when the clock counts, ns.
        started_ns: u64,
    },
}

#[derive(Debug)]
struct Driver {
    wire: Wire,
    duty: usize,
    backend: Option<usize>,
    rate_hz: f64,
    /// Number of the first cycle's period, and its time in periods.
    first: Option<(u64, f64)>,
    started_ns: u64,
    /// Number of the cycle before and the duty it decided on.
    before: Option<(u64, f64)>,
    /// The row that waits for its samples: its time, and the duty in force.
    pending: Option<(f64, f64)>,
    /// Cycles the session lacks.
    lost: u64,
}

impl Rows {
    /// Rows of a channel of a session, by its index there. The session's own rig file says how its samples are to be read;
    /// `model`, where given, is the wire its elongation is counted from.
    ///
    /// # Errors
    /// A session whose cycles are not such; one without a rig file, or with one that cannot be read, where it is needed.
    pub fn new(session: &Session, channel: usize, model: Option<&WireModel>) -> Result<Rows, Error> {
        let (about, layout) = (session.about(), session.layout());
        let field = |name: &str| layout.fields.iter().position(|field| field.name == name);
        let wrong = |what| Err(Error::new(session.name(), what));
        let (wanted, from): (Vec<Column>, From) = if about.kind == DRIVER {
            let wire = wire(session, channel, model)?;
            let Some(duty) = field("duty") else { return wrong(What::LacksField { field: "duty" }) };
            let columns = [
                (Column::Duty, true),
                (Column::SupplyV, true),
                (Column::CurrentA, true),
                (Column::V1V, wire.taps),
                (Column::V2V, wire.taps),
                (Column::V3V, wire.low_ohm.is_none()),
                (Column::PositionM, wire.measured),
            ];
            let driver = Driver {
                wire,
                duty,
                backend: field("backend"),
                rate_hz: about.rate_hz,
                first: None,
                started_ns: about.started_monotonic_ns,
                before: None,
                pending: None,
                lost: 0,
            };
            (
                columns.into_iter().filter(|(_, is_there)| *is_there).map(|(column, _)| column).collect(),
                From::Driver(driver),
            )
        } else {
            (Column::ALL.to_vec(), From::Plain { time: field(TIME), started_ns: about.started_monotonic_ns })
        };
        let source = |column: Column| match &from {
            From::Driver(_) => field(driver_field(column)),
            From::Plain { .. } => field(column.name()),
        };
        let (columns, fields): (Vec<Column>, Vec<usize>) =
            wanted.into_iter().filter_map(|column| Some((column, source(column)?))).unzip();
        if columns.is_empty() {
            return wrong(What::NoColumns { fields: layout.fields.iter().map(|field| field.name.clone()).collect() });
        }
        let cells = vec![f64::NAN; columns.len()];
        Ok(Rows { name: session.name().into(), channel, columns, fields, cells, last_s: None, from })
    }

    /// The columns of its rows, in the order of their cells.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Cycles that the session lacks among those handed over.
    pub fn lost(&self) -> u64 {
        match &self.from {
            From::Driver(driver) => driver.lost,
            From::Plain { .. } => 0,
        }
    }

    /// Hands over the next cycle and takes the row that is complete by it, where one is: its time in s, and its cells, NaN
    /// where nothing was measured.
    ///
    /// # Errors
    /// A cycle that does not come after the one before, or a number that is infinite.
    pub fn feed(&mut self, cycle: &CycleView<'_>) -> Result<Option<(f64, &[f64])>, Error> {
        let seen = |field: usize| cycle.get(self.channel, field);
        let time_s = match &mut self.from {
            From::Plain { time, started_ns } => {
                for (cell, field) in self.cells.iter_mut().zip(&self.fields) {
                    *cell = seen(*field);
                }
                time.map_or_else(|| since_s(cycle.head.monotonic_ns, *started_ns), seen)
            }
            From::Driver(driver) => {
                let failed = driver.backend.is_some_and(|field| seen(field) != 0.0);
                let Some((time_s, duty)) = driver.advance(&cycle.head, seen(driver.duty), failed) else {
                    return Ok(None);
                };
                for ((cell, field), column) in self.cells.iter_mut().zip(&self.fields).zip(&self.columns) {
                    *cell = match column {
                        Column::Duty => duty,
                        Column::SupplyV => seen(*field),
                        // without an on-phase there is nothing to see but what the converter shows of nothing
                        _ if duty == 0.0 => f64::NAN,
                        Column::PositionM => seen(*field) - driver.wire.rest_m,
                        _ => seen(*field),
                    };
                }
                if let Some(low_ohm) = driver.wire.low_ohm {
                    let at = |column| self.columns.iter().position(|c| *c == column);
                    let current_a = at(Column::CurrentA).map_or(f64::NAN, |i| self.cells[i]);
                    for tap in [Column::V1V, Column::V2V].into_iter().filter_map(at) {
                        self.cells[tap] -= low_ohm * current_a;
                    }
                }
                time_s
            }
        };
        let wrong = |what, column: &str| Err(Error::new(&self.name, what).in_column(column));
        if !time_s.is_finite() {
            return wrong(What::Infinite { found: time_s.to_string() }, TIME);
        }
        if let Some(previous) = self.last_s.replace(time_s)
            && time_s <= previous
        {
            return wrong(What::TimeNotIncreasing { previous, found: time_s }, TIME);
        }
        if let Some((bad, column)) = self.cells.iter().zip(&self.columns).find(|(cell, _)| cell.is_infinite()) {
            return wrong(What::Infinite { found: bad.to_string() }, column.name());
        }
        Ok(Some((time_s, &self.cells)))
    }
}

impl Driver {
    /// The row that ends with this cycle, if one does: its time and its duty.
    fn advance(&mut self, head: &Head, decided: f64, failed: bool) -> Option<(f64, f64)> {
        let period = head.cycle.wrapping_add(head.missed);
        let time_s = if self.rate_hz.is_finite() && self.rate_hz > 0.0 {
            // whole periods since the recording began
            let (first, offset) = *self
                .first
                .get_or_insert_with(|| (period, (since_s(head.monotonic_ns, self.started_ns) * self.rate_hz).round()));
            (period.wrapping_sub(first) as i64 as f64 + offset) / self.rate_hz
        } else {
            since_s(head.monotonic_ns, self.started_ns)
        };
        let in_force = match self.before.replace((head.cycle, decided)) {
            // a backend that failed has put its outputs to zero
            _ if failed => Some(0.0),
            _ if head.cycle == 1 => Some(0.0),
            Some((before, decided)) if before.wrapping_add(1) == head.cycle => Some(decided),
            Some((before, _)) => {
                self.lost = self.lost.saturating_add(head.cycle.saturating_sub(before).saturating_sub(1));
                None
            }
            None => None,
        };
        // a duty nobody knows: what was in force is held until one is known again
        let duty = in_force.filter(|duty| duty.is_finite())?;
        self.pending.replace((time_s, duty))
    }
}

/// Seconds from one moment to another on the monotonic clock.
fn since_s(ns: u64, start_ns: u64) -> f64 {
    ns.wrapping_sub(start_ns) as i64 as f64 * 1e-9
}

/// How a driver's samples of a channel are to be read.
fn wire(session: &Session, channel: usize, model: Option<&WireModel>) -> Result<Wire, Error> {
    let (about, name) = (session.about(), &session.layout().channels[channel]);
    let Some(text) = &about.rig_toml else {
        let Some(model) = model else { return Err(Error::new(session.name(), What::NoRig { reason: None })) };
        let taps = model.taps.is_some();
        return Ok(Wire { rest_m: model.geometry.length_m, low_ohm: None, taps, measured: taps });
    };
    let unusable = |reason: String| Error::new(session.name(), What::NoRig { reason: Some(reason) });
    let rig = Rig::parse(text, "rig.toml").map_err(|error| unusable(error.to_string()))?;
    let Some((_, channel)) = rig.channel(name) else {
        return Err(unusable(format!("it has no channel {name:?}")));
    };
    let drive = &channel.model.drive;
    let taps = channel.model.taps.is_some();
    Ok(Wire {
        rest_m: model.unwrap_or(&channel.model).geometry.length_m,
        low_ohm: (channel.adc.circuit == SamplingCircuit::Shared).then_some(drive.low_ohm()),
        taps,
        measured: taps && channel.control.sensing == Sensing::Dual,
    })
}

/// The index of the channel meant: the named one, or the only one.
///
/// # Errors
/// [`What::WhichChannel`] with those there are.
pub fn channel_of(session: &Session, name: Option<&str>) -> Result<usize, Error> {
    let channels = &session.layout().channels;
    let index = match name {
        // a recording of a single wire needs no name, whatever the rig file calls it
        _ if channels.len() == 1 => Some(0),
        Some(name) => channels.iter().position(|channel| channel == name),
        None => None,
    };
    index.ok_or_else(|| {
        let what = What::WhichChannel { asked: name.map(str::to_string), channels: channels.clone() };
        Error::new(session.name(), what)
    })
}

/// One channel of a session as a recording in memory.
pub(crate) fn recording(session: &Session, options: &Options<'_>) -> Result<Recording, Error> {
    let mut rows = Rows::new(session, channel_of(session, options.channel)?, options.model)?;
    let mut times = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); rows.columns().len()];
    let mut cycles = session.cycles();
    while let Some(cycle) = cycles.next()? {
        let Some((time_s, cells)) = rows.feed(&cycle)? else { continue };
        if times.len() == options.max_rows {
            return Err(Error::new(session.name(), What::TooManyRows { limit: options.max_rows }));
        }
        times.push(time_s);
        for (column, cell) in columns.iter_mut().zip(cells) {
            column.push(*cell);
        }
    }
    if times.len() < MIN_SAMPLES {
        let what = What::TooFewSamples { found: times.len(), least: MIN_SAMPLES };
        return Err(Error::new(session.name(), what));
    }
    let mut recording = Recording::new(session.name(), times)?;
    for (column, values) in rows.columns().to_vec().into_iter().zip(columns) {
        if let Some(what) = values.iter().filter(|v| !v.is_nan()).find_map(|v| check_range(column, *v, false).err()) {
            return Err(Error::new(session.name(), what).in_column(column.name()));
        }
        recording.set(column, values)?;
    }
    if let Some(model) = options.model {
        recording.check_inputs(model)?;
    }
    Ok(recording)
}
