//! A wire mounted in the test machine, for the commands of `sinew test`: the rig files are read, routines run on it, and their rows
//! go into files.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use sinew_machine::record::RecordingFile;
use sinew_machine::{About, Machine, Options, Ran, Routine, RoutineKind, Row, SimulatedMachine, Watch, plan, run};
use sinew_recording::session;
use sinew_rig::{Channel, Rig};

use super::fitting::command;
use super::simulate::recording_failure;
use super::{choose_channel, load_rig};
use crate::failure::Failure;
use crate::progress::Progress;

/// One run of a routine.
pub struct Task<'a> {
    /// Which.
    pub kind: RoutineKind,
    /// With which numbers.
    pub options: &'a Options,
    /// Added to the seed of the machine's noise.
    pub seed: u64,
    /// What it is called, and its file.
    pub name: &'a str,
    /// The folder of its file, where it has one.
    pub out: Option<&'a Path>,
    /// Whether it keeps to the clock.
    pub real_time: bool,
}

/// What a run leaves.
pub struct Done {
    /// Its rows and its end.
    pub ran: Ran,
    /// With its stages.
    pub routine: Routine,
    /// Whether the machine was computed.
    pub simulated: bool,
}

/// A wire in a machine: what is believed of it, and the rig that is really there.
pub struct Bench {
    /// What is believed.
    pub rig: Rig,
    /// Index of the channel.
    pub channel: usize,
    /// What is simulated.
    pub truth: Rig,
    truth_channel: usize,
}

impl Bench {
    /// Reads the rig files.
    pub fn read(rig: &Path, channel: Option<&str>, truth: Option<&Path>) -> Result<Bench, Failure> {
        let rig = load_rig(Some(rig))?;
        let name = choose_channel(&rig, channel)?.name.clone();
        let (channel, _) = rig.channel(&name).ok_or_else(|| Failure::own("the channel that was just there is gone"))?;
        let truth = match truth {
            Some(path) => load_rig(Some(path))?,
            None => rig.clone(),
        };
        let wanted = if truth.channels.len() == 1 { None } else { Some(name.as_str()) };
        let there = choose_channel(&truth, wanted)?.name.clone();
        let truth_channel = truth.channel(&there).map_or(0, |(index, _)| index);
        Ok(Bench { rig, channel, truth, truth_channel })
    }

    /// What is believed of the wire.
    pub fn wire(&self) -> &Channel {
        &self.rig.channels[self.channel]
    }

    /// Mounts a fresh wire.
    pub fn machine(&self, seed: u64) -> Result<SimulatedMachine, Failure> {
        let model = &self.truth.channels[self.truth_channel].model;
        let seed = self.truth.simulation.seed.wrapping_add(seed);
        SimulatedMachine::new(model, &self.rig.machine, seed)
            .map_err(|error| Failure::input(format!("{}: {error}", self.truth.file())).hint("mend the rig file"))
    }

    /// Runs a routine on a fresh wire until it ends or a signal asks for its end; its rows go into a file as they come.
    pub fn run(&self, task: &Task<'_>, asked: &AtomicBool) -> Result<Done, Failure> {
        let mut machine = self.machine(task.seed)?;
        let wire = self.wire();
        let mut routine = plan::routine(task.kind, &wire.model, &self.rig.machine, task.options);
        let mut watch = Watch::new(&wire.model, &wire.limits, &self.rig.machine);
        let mut file = match task.out {
            Some(out) => Some(self.file(&out.join(format!("{}.mcap", task.name)), task, machine.is_simulated())?),
            None => None,
        };
        let mut unwritable = None;
        let progress = Progress::new();
        let started = Instant::now();
        let mut go_on = |row: &Row, is_recorded: bool, share: f64| {
            progress.tell(task.name, share);
            if let Some(file) = file.as_mut().filter(|_| is_recorded)
                && let Err(error) = file.row(row)
            {
                unwritable = Some(error);
                return false;
            }
            if task.real_time {
                let due = started + Duration::from_secs_f64(row.reading.time_s.max(0.0));
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
            }
            !asked.load(Ordering::Relaxed)
        };
        let ran = run::run(&mut machine, &mut routine, &mut watch, &mut go_on);
        progress.clear();
        if let Some(error) = unwritable {
            return Err(recording_failure(error));
        }
        if let Some(file) = file {
            file.finish(&ran.ending).map_err(recording_failure)?;
        }
        Ok(Done { ran, routine, simulated: machine.is_simulated() })
    }

    /// The file of a recording.
    fn file(&self, path: &Path, task: &Task<'_>, simulated: bool) -> Result<RecordingFile<BufWriter<File>>, Failure> {
        let failed = |error: std::io::Error| {
            Failure::own(format!("{}: cannot be written: {error}", path.display()))
                .hint("check the folder, its free space and that you may write there")
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        let sink = BufWriter::new(File::create(path).map_err(failed)?);
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos() as u64);
        let extra = [("routine", task.kind.word().to_string()), ("command", command())];
        let about = session::About {
            rig: self.rig.name.clone(),
            rate_hz: self.rig.machine.rate_hz,
            software: format!("sinew {}", env!("CARGO_PKG_VERSION")),
            kind: String::new(),
            simulated,
            started_unix_ns: now,
            started_monotonic_ns: 0,
            rig_toml: None,
            extra: extra.map(|(key, value)| (key.to_string(), value)).into(),
        };
        let disturbed = task.kind.is_closed_loop();
        RecordingFile::create(sink, &path.display().to_string(), &self.rig, self.channel, disturbed, about)
            .map_err(recording_failure)
    }

    /// What a report says of where it comes from.
    pub fn about(&self) -> About {
        About {
            rig: self.rig.name.clone(),
            channel: self.wire().name.clone(),
            command: command(),
            version: env!("CARGO_PKG_VERSION").into(),
        }
    }
}
