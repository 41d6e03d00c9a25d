//! The client of a running driver. States travel as bytes, copied once; `sinew._state` has their dtype from [`fields`].

use std::sync::{Arc, Mutex};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use sinew_ipc::{
    ALL_CHANNELS, ChannelState, ClientOptions, CommandKind, CycleHeader, CycleStream, Error, FAULT_TABLE, FieldKind,
    LoopStats, Mode, Progress, Reason, Refusal, SetpointOptions, Wanted,
};
use zerocopy::IntoBytes;

use crate::failure::{bad_input, with};

/// A driver does not have to be waited for longer than this in one go: so Ctrl-C is obeyed.
const LOOK: Duration = Duration::from_millis(100);

/// A connection to a running driver.
#[pyclass(frozen, module = "sinew._sinew")]
pub struct Client {
    client: Arc<sinew_ipc::Client>,
}

/// Number, time and missed periods of a cycle, then its channels.
type Latest<'py> = (u64, u64, u64, Bound<'py, PyBytes>);

#[pymethods]
impl Client {
    /// Connects to the driver of this rig, waiting so long for one that is just starting, and so long for answers to commands.
    #[staticmethod]
    fn connect(py: Python<'_>, rig: &str, connect_s: f64, answer_s: f64) -> PyResult<Client> {
        let options =
            ClientOptions { connect: seconds(connect_s, "connect_s")?, answer: seconds(answer_s, "answer_s")? };
        let client = py.detach(|| sinew_ipc::Client::connect_with(rig, options)).map_err(|error| of_driver(&error))?;
        Ok(Client { client: Arc::new(client) })
    }

    /// What does not change while the driver runs.
    fn info<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let info = self.client.info();
        let channels = info.channels().iter().map(|channel| {
            let row = PyDict::new(py);
            row.set_item("name", channel.name.as_str())?;
            for (key, value) in [
                ("min_length_m", channel.min_length_m),
                ("max_length_m", channel.max_length_m),
                ("hot_length_m", channel.hot_length_m),
                ("cold_length_m", channel.cold_length_m),
                ("rest_length_m", channel.rest_length_m),
                ("max_duty", channel.max_duty),
                ("max_current_a", channel.max_current_a),
                ("max_power_w", channel.max_power_w),
                ("max_temperature_c", channel.max_temperature_c),
                ("lease_s", channel.lease_s),
            ] {
                row.set_item(key, value)?;
            }
            Ok(row)
        });
        let answer = PyDict::new(py);
        answer.set_item("channels", PyList::new(py, channels.collect::<PyResult<Vec<_>>>()?)?)?;
        answer.set_item("rig", info.rig.as_str())?;
        answer.set_item("pid", info.pid)?;
        answer.set_item("protocol", info.protocol)?;
        answer.set_item("rate_hz", info.rate_hz)?;
        answer.set_item("started_ns", info.started_ns)?;
        answer.set_item("simulated", info.simulated != 0)?;
        Ok(answer)
    }

    /// The latest cycle: one whole one, never parts of two.
    fn latest<'py>(&self, py: Python<'py>) -> Latest<'py> {
        self.client.with_latest(|latest| {
            (latest.cycle, latest.monotonic_ns, latest.missed, PyBytes::new(py, latest.channels().as_bytes()))
        })
    }

    /// Commands several channels in one request, each by its number, the name of the kind and the value: all or none. Returns the
    /// cycle from which on all of it is in force, and the lease as granted.
    fn set_many(&self, py: Python<'_>, wanted: Vec<(u32, String, f64)>, hold_s: f64) -> PyResult<(u64, f64)> {
        let (wanted, hold) = (all_of(&wanted)?, seconds(hold_s, "hold")?);
        let taken = py.detach(|| self.client.set_many(&wanted, hold)).map_err(|error| of_driver(&error))?;
        Ok((taken.cycle, taken.hold_s))
    }

    /// Commands one channel, or all (`channel=None`) where the kind allows it.
    fn command(&self, py: Python<'_>, channel: Option<u32>, name: &str, value: f64, hold_s: f64) -> PyResult<f64> {
        let (kind, hold) = (kind(name)?, seconds(hold_s, "hold")?);
        let channel = channel.unwrap_or(ALL_CHANNELS);
        let reply = py.detach(|| self.client.command(channel, kind, value, hold)).map_err(|error| of_driver(&error))?;
        Ok(reply.hold_s)
    }

    /// Sleeps until the driver has something new, or the time is up; false when nothing came.
    fn wait(&self, py: Python<'_>, timeout_s: f64) -> PyResult<bool> {
        let mut left = seconds(timeout_s, "timeout")?;
        loop {
            let step = left.min(LOOK);
            if py.detach(|| self.client.wait(step)).map_err(|error| of_driver(&error))? {
                return Ok(true);
            }
            py.check_signals()?;
            left = left.saturating_sub(step);
            if left.is_zero() {
                return Ok(false);
            }
        }
    }

    /// How the driver is, in a word.
    fn health(&self) -> &'static str {
        self.client.health().name()
    }

    /// Age of the latest state, s.
    fn age_s(&self) -> f64 {
        self.client.age().as_secs_f64()
    }

    /// How the loop does: counters, and its lateness and cycle times in s.
    fn loop_stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let stats = self.client.loop_stats();
        let answer = PyDict::new(py);
        for (key, value) in [
            ("cycles", stats.cycles),
            ("missed", stats.missed),
            ("overruns", stats.overruns),
            ("ring_drops", stats.ring_drops),
            ("allocations", stats.allocations),
            ("commands", stats.commands),
            ("refusals", stats.refusals),
        ] {
            answer.set_item(key, value)?;
        }
        for (name, histogram) in
            [("lateness", &stats.lateness), ("cycle_time", &stats.cycle_time), ("period", &stats.period)]
        {
            for (quantile, q) in [("p50", 0.5), ("p99", 0.99)] {
                answer.set_item(format!("{name}_{quantile}_s"), histogram.quantile(q) as f64 * 1e-9)?;
            }
            answer.set_item(format!("{name}_max_s"), histogram.max() as f64 * 1e-9)?;
        }
        let granted = LoopStats::REALTIME.iter().filter(|(bit, _)| stats.realtime & bit != 0);
        answer.set_item("realtime", granted.map(|(_, name)| *name).collect::<Vec<_>>())?;
        answer.set_item("dead_threads", stats.dead_threads().map(|row| row.name).collect::<Vec<_>>())?;
        Ok(answer)
    }

    /// The text of the rig file as the driver read it.
    fn rig_text(&self) -> PyResult<Option<String>> {
        self.client.rig_text().map_err(|error| of_driver(&error))
    }

    /// Every cycle from now on.
    fn stream(&self) -> PyResult<Stream> {
        Ok(Stream { stream: Mutex::new(self.client.stream().map_err(|error| of_driver(&error))?) })
    }

    /// A stream of setpoints; without `within_s` a message is carried out whenever it comes.
    fn setpoints(&self, hold_s: f64, over_s: f64, within_s: Option<f64>) -> PyResult<Setpoints> {
        let options = SetpointOptions {
            hold: seconds(hold_s, "hold")?,
            over: seconds(over_s, "over")?,
            within: within_s.map(|within_s| seconds(within_s, "within")).transpose()?,
        };
        Ok(Setpoints { setpoints: Mutex::new(sinew_ipc::Setpoints::new(self.client.clone(), options)) })
    }
}

/// Messages sent, in force, overtaken, late, refused, held back; and the cycle in which the last one was taken.
type Counts = (u64, u64, u64, u64, u64, u64, u64);

/// Setpoints that nobody waits for.
#[pyclass(frozen, module = "sinew._sinew")]
pub struct Setpoints {
    setpoints: Mutex<sinew_ipc::Setpoints<Arc<sinew_ipc::Client>>>,
}

#[pymethods]
impl Setpoints {
    /// Sends a message on its way.
    fn send(&self, py: Python<'_>, wanted: Vec<(u32, String, f64)>) -> PyResult<Counts> {
        let wanted = all_of(&wanted)?;
        self.with(py, |setpoints| setpoints.send(&wanted))
    }

    /// Looks for answers.
    fn poll(&self, py: Python<'_>) -> PyResult<Counts> {
        self.with(py, |setpoints| setpoints.poll())
    }
}

impl Setpoints {
    fn with(
        &self,
        py: Python<'_>,
        ask: impl FnOnce(&mut sinew_ipc::Setpoints<Arc<sinew_ipc::Client>>) -> Result<Progress, Error> + Send,
    ) -> PyResult<Counts> {
        let asked = py.detach(|| {
            // a thread that panicked over it has left whole messages behind
            ask(&mut self.setpoints.lock().unwrap_or_else(|broken| broken.into_inner()))
        });
        let Progress { sent, taken, overtaken, late, refused, held_back, cycle } =
            asked.map_err(|error| of_driver(&error))?;
        Ok((sent, taken, overtaken, late, refused, held_back, cycle))
    }
}

/// Every cycle of a driver, in order.
#[pyclass(frozen, module = "sinew._sinew")]
pub struct Stream {
    stream: Mutex<CycleStream>,
}

#[pymethods]
impl Stream {
    /// Waits up to so long for a cycle, then takes what is there, at most `most`: the heads of the cycles (number, time, missed periods
    /// as 8 bytes each), their channels, and how many cycles are lost for good since the stream was opened.
    fn take<'py>(
        &self,
        py: Python<'py>,
        timeout_s: f64,
        most: usize,
    ) -> PyResult<(Bound<'py, PyBytes>, Bound<'py, PyBytes>, u64)> {
        let mut left = seconds(timeout_s, "timeout")?;
        let (mut heads, mut states) = (Vec::new(), Vec::new());
        loop {
            let step = left.min(LOOK);
            let lost = py.detach(|| -> Result<u64, Error> {
                // a thread that panicked over it has left whole cycles behind
                let mut stream = self.stream.lock().unwrap_or_else(|broken| broken.into_inner());
                let mut copy = |header: &CycleHeader, channels: &[ChannelState]| {
                    heads.extend_from_slice(header.as_bytes());
                    states.extend_from_slice(channels.as_bytes());
                };
                if let Some(cycle) = stream.next_within(step)? {
                    copy(cycle.header, cycle.channels);
                    for _ in 1..most {
                        // what was taken is given away, even where the driver has gone since
                        let Ok(Some(cycle)) = stream.next() else { break };
                        copy(cycle.header, cycle.channels);
                    }
                }
                Ok(stream.lost())
            });
            let lost = lost.map_err(|error| of_driver(&error))?;
            py.check_signals()?;
            left = left.saturating_sub(step);
            if !heads.is_empty() || left.is_zero() {
                return Ok((PyBytes::new(py, &heads), PyBytes::new(py, &states), lost));
            }
        }
    }
}

/// Names of the rigs a driver is running for.
#[pyfunction]
pub fn discover() -> PyResult<Vec<String>> {
    sinew_ipc::Client::discover().map_err(|error| of_driver(&error))
}

/// What a channel publishes: name, dtype, unit and meaning, in the order of the bytes.
#[pyfunction]
pub fn fields() -> Vec<(&'static str, &'static str, &'static str, &'static str)> {
    let row = |field: &sinew_ipc::ChannelField| {
        let dtype = if field.kind == FieldKind::Float { "<f8" } else { "<u4" };
        (field.name, dtype, field.unit, field.meaning.trim())
    };
    ChannelState::FIELDS.iter().map(row).collect()
}

/// The modes of a channel, by their codes.
#[pyfunction]
pub fn modes() -> Vec<(u32, &'static str)> {
    (0..).map_while(|code| Mode::from_code(code).map(|mode| (code, mode.name()))).collect()
}

/// Every fault: code, flag, cause and remedy.
#[pyfunction]
pub fn fault_table() -> Vec<(u32, &'static str, &'static str, &'static str)> {
    FAULT_TABLE.iter().map(|row| (row.fault.code(), row.flag, row.cause, row.remedy)).collect()
}

/// A time as a caller gave it.
fn seconds(value_s: f64, name: &str) -> PyResult<Duration> {
    Duration::try_from_secs_f64(value_s)
        .map_err(|_| bad_input(&format!("{name} = {value_s} is no time"), "give seconds, 0 or more"))
}

/// Setpoints by number, name of the kind and value.
fn all_of(wanted: &[(u32, String, f64)]) -> PyResult<Vec<Wanted>> {
    let one = |(channel, name, value): &(u32, String, f64)| {
        Ok(Wanted { channel: *channel, kind: kind(name)?, value: *value })
    };
    wanted.iter().map(one).collect()
}

/// A kind by its name on the command line.
fn kind(name: &str) -> PyResult<CommandKind> {
    let kinds = || (1..).map_while(CommandKind::from_code);
    kinds().find(|kind| kind.name() == name).ok_or_else(|| {
        let known: Vec<&str> = kinds().map(CommandKind::name).collect();
        bad_input(&format!("there is no command {name:?}"), &format!("there are: {}", known.join(", ")))
    })
}

/// A client's error as the exception that fits it.
fn of_driver(error: &Error) -> PyErr {
    let class = match error {
        Error::NotRunning { .. } | Error::Starting { .. } => "NotRunning",
        Error::DriverGone { .. } => "DriverGone",
        Error::NoAnswer { .. } => "NoAnswer",
        Error::NotAdmitted { .. } => "NotAdmitted",
        Error::UnknownChannel { .. } => "UnknownChannel",
        Error::Refused(_) | Error::RefusedTogether(_) => "Refused",
        _ if error.is_bad_input() => "BadInput",
        _ => "SinewError",
    };
    let refusals: &[Refusal] = match error {
        Error::Refused(refusal) => std::slice::from_ref(refusal),
        Error::RefusedTogether(refusals) => refusals,
        _ => &[],
    };
    Python::attach(|py| {
        let more = PyDict::new(py);
        let made = match refusals {
            [] => Ok(()),
            refusals => refusals
                .iter()
                .map(|refusal| of_refusal(py, refusal))
                .collect::<PyResult<Vec<_>>>()
                .and_then(|rows| more.set_item("refusals", rows)),
        };
        made.and_then(|()| with(py, class, &error.message(), &error.remedy(), Some(&more)))
            .unwrap_or_else(|broken| broken)
    })
}

/// A refusal as `sinew.Refusal`.
fn of_refusal<'py>(py: Python<'py>, refusal: &Refusal) -> PyResult<Bound<'py, PyAny>> {
    let fault = match refusal.reason {
        Reason::Faulted(fault) | Reason::CauseRemains(fault) | Reason::TooHot { fault, .. } => Some(fault.flag()),
        _ => None,
    };
    let (low, high) = match refusal.reason {
        Reason::OutOfRange { low, high }
        | Reason::HoldOutOfRange { low, high }
        | Reason::ApproachOutOfRange { low, high } => (Some(low), Some(high)),
        _ => (None, None),
    };
    let row =
        (&refusal.channel, refusal.kind.name(), refusal.value, refusal.message(), refusal.remedy(), fault, low, high);
    py.import("sinew._errors")?.getattr("Refusal")?.call1(row)
}
