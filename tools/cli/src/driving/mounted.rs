//! A wire mounted in the test machine, or one of a running rig, for the commands of `sinew test`: the rig files are read, routines run on
//! it, and their rows go into files.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use sinew_machine::analysis::AtRest;
use sinew_machine::record::RecordingFile;
use sinew_machine::{
    About, Machine, OnRig, Options, Ran, Routine, RoutineKind, Row, SimulatedMachine, Watch, plan, run,
};
use sinew_recording::session;
use sinew_rig::{Channel, Machine as Spec, Rig};

use super::on_rig::{Recorded, RigBench};
use crate::args::TestedWire;
use crate::commands::fitting::command;
use crate::commands::simulate::recording_failure;
use crate::commands::{choose_channel, load_rig};
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
    /// What a reader must know of how a rig did.
    pub notes: Vec<String>,
    /// What the position's sensor showed of the wire at rest, on a rig.
    pub at_rest: Option<AtRest>,
}

/// A wire to be tested: what is believed of it, and where it is.
pub struct Bench {
    /// What is believed.
    pub rig: Rig,
    /// Index of the channel.
    pub channel: usize,
    /// The machine, or what of one a rig has.
    pub spec: Spec,
    place: Place,
}

/// Where the wire is.
enum Place {
    /// In the simulated machine: the rig that is really there, and which channel of it.
    Machine(Box<Rig>, usize),
    /// On a running rig.
    Rig(Box<RigBench>),
}

impl Bench {
    /// Reads the rig files, or what the running driver goes by.
    pub fn read(wire: &TestedWire) -> Result<Bench, Failure> {
        if let Some(name) = &wire.running {
            let (rig, channel, on_rig) = RigBench::connect(name, wire)?;
            let spec = on_rig.spec(&rig);
            return Ok(Bench { rig, channel, spec, place: Place::Rig(Box::new(on_rig)) });
        }
        let rig = load_rig(wire.rig.as_deref())?;
        let name = choose_channel(&rig, wire.channel.as_deref())?.name.clone();
        let (channel, _) = rig.channel(&name).ok_or_else(|| Failure::own("the channel that was just there is gone"))?;
        let truth = match wire.truth.as_deref() {
            Some(path) => load_rig(Some(path))?,
            None => rig.clone(),
        };
        let wanted = if truth.channels.len() == 1 { None } else { Some(name.as_str()) };
        let there = choose_channel(&truth, wanted)?.name.clone();
        let truth_channel = truth.channel(&there).map_or(0, |(index, _)| index);
        Ok(Bench { spec: rig.machine, rig, channel, place: Place::Machine(Box::new(truth), truth_channel) })
    }

    /// The running rig, where it is one.
    pub fn on_rig(&self) -> Option<&RigBench> {
        match &self.place {
            Place::Rig(on_rig) => Some(on_rig),
            Place::Machine(..) => None,
        }
    }

    /// The rig file of the wire that is really in the simulated machine, where that is another one.
    pub fn truth(&self) -> Option<&Rig> {
        match &self.place {
            Place::Machine(truth, _) => Some(&**truth).filter(|truth| **truth != self.rig),
            Place::Rig(_) => None,
        }
    }

    /// Of a running rig: what a report says of its numbers.
    pub fn sources(&self, at_rest: Option<AtRest>) -> Option<OnRig> {
        self.on_rig().map(|on_rig| on_rig.sources(self.wire(), at_rest))
    }

    /// What is believed of the wire.
    pub fn wire(&self) -> &Channel {
        &self.rig.channels[self.channel]
    }

    /// Mounts a fresh wire.
    fn machine(&self, truth: &Rig, channel: usize, seed: u64) -> Result<SimulatedMachine, Failure> {
        let seed = truth.simulation.seed.wrapping_add(seed);
        SimulatedMachine::new(&truth.channels[channel].model, &self.spec, seed)
            .map_err(|error| Failure::input(format!("{}: {error}", truth.file())).hint("mend the rig file"))
    }

    /// Runs a routine on a fresh wire, or on that of the rig, until it ends or a signal asks for its end; its rows go into a file as they
    /// come, and of a rig every cycle of its driver.
    pub fn run(&self, task: &Task<'_>, asked: &AtomicBool) -> Result<Done, Failure> {
        let (truth, channel) = match &self.place {
            Place::Machine(truth, channel) => (truth, *channel),
            Place::Rig(on_rig) => return self.run_on_rig(on_rig, task, asked),
        };
        let mut machine = self.machine(truth, channel, task.seed)?;
        let wire = self.wire();
        let mut routine = plan::routine(task.kind, &wire.model, &self.spec, task.options);
        let mut watch = Watch::new(&wire.model, &wire.limits, &self.spec);
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
        Ok(Done { ran, routine, simulated: machine.is_simulated(), notes: Vec::new(), at_rest: None })
    }

    /// The same on a running rig.
    fn run_on_rig(&self, on_rig: &RigBench, task: &Task<'_>, asked: &AtomicBool) -> Result<Done, Failure> {
        let wire = self.wire();
        let mut routine = plan::routine(task.kind, &wire.model, &self.spec, task.options);
        let mut watch = Watch::of_running(&wire.model);
        let mut recorded = Recorded::of(task.out.map(|out| out.join(format!("{}.mcap", task.name))))?;
        let mut machine = on_rig.claim(&self.rig, wire)?;
        let progress = Progress::new();
        let mut unwritable = None;
        let mut cold_m = Vec::new();
        let mut go_on = |row: &Row, is_recorded: bool, share: f64| {
            progress.tell(task.name, share);
            if !is_recorded {
                cold_m.push(row.reading.position_m);
            }
            match recorded.watch(on_rig, is_recorded) {
                Ok(()) => !asked.load(Ordering::Relaxed),
                Err(error) => {
                    unwritable = Some(error);
                    false
                }
            }
        };
        let ran = run::run(&mut machine, &mut routine, &mut watch, &mut go_on);
        progress.clear();
        // the latter half of the time it was given to get cold
        let at_rest = AtRest::of(&cold_m[cold_m.len() / 2..], 1.0 / self.spec.rate_hz);
        let (simulated, kept) = (machine.is_simulated(), machine.kept());
        drop(machine);
        recorded.finish()?;
        match unwritable {
            Some(error) => Err(error),
            None => Ok(Done { ran, routine, simulated, notes: on_rig.notes(task.kind, &kept, &self.spec), at_rest }),
        }
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
            rate_hz: self.spec.rate_hz,
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
