//! A wire of a running rig for the commands of `sinew test`: its driver is connected to, what cannot be tested there is refused, and every
//! cycle is recorded.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use sinew_control::{AlgorithmKind, EstimatorKind};
use sinew_ipc::{Client, Mode};
use sinew_machine::analysis::AtRest;
use sinew_machine::running::{Kept, most_power_w, position_sensor, spec};
use sinew_machine::{OnRig, Options, OwnLoad, Quantity, RoutineKind, RunningRig};
use sinew_recorder::Recorder;
use sinew_rig::{Channel, Machine as Spec, Rig};

use super::{live, record};
use crate::args::TestedWire;
use crate::commands::recording::gaps;
use crate::commands::{choose_channel, load_rig, unknown_channel};
use crate::failure::{Failure, Outcome};
use crate::output;

/// How long a driver that has just started may take to prove its sensors.
const PROVING: Duration = Duration::from_secs(10);

/// A channel of a running driver, and what pulls at its wire.
pub struct RigBench {
    client: Arc<Client>,
    /// Number of the channel at the driver.
    channel: usize,
    load: OwnLoad,
    priority: u32,
}

impl RigBench {
    /// Connects to the driver; what is believed of its wire is what it goes by itself, unless another rig file is given. Nothing is asked of
    /// the wire yet.
    pub fn connect(name: &str, wire: &TestedWire) -> Result<(Rig, usize, RigBench), Failure> {
        if wire.truth.is_some() {
            return Err(Failure::input("--truth: the wire of a running rig is what it is")
                .hint("leave --truth out; another RIG.toml before --rig says what else is believed of it"));
        }
        let client = Client::connect(name).map_err(live::failure)?;
        let rig = match &wire.rig {
            Some(path) => load_rig(Some(path))?,
            None => read_by(&client)?,
        };
        let chosen = choose_channel(&rig, wire.channel.as_deref())?.name.clone();
        let (index, channel) =
            rig.channel(&chosen).ok_or_else(|| Failure::own("the channel that was just there is gone"))?;
        let place = format!("rig {name}");
        let known = client.channels().iter().map(|info| info.name.as_str());
        let number = client.info().index_of(&chosen).ok_or_else(|| unknown_channel(&place, &chosen, known))?;
        let in_joint = rig.joints.iter().find(|joint| joint.agonist == chosen || joint.antagonist == chosen);
        if let Some(joint) = in_joint {
            return Err(Failure::input(format!(
                "{place}: channel \"{chosen}\" turns joint \"{}\" against another wire: what pulls at it is not known",
                joint.name
            ))
            .hint("give the wire a load of its own: a mass or a spring, in a rig file with [channel.load]"));
        }
        let Some(load) = OwnLoad::of(&channel.model) else {
            return Err(Failure::input(format!("{}: channel \"{chosen}\" has no load of its own", rig.file())).hint(
                "say what pulls at the wire in [channel.load]: mass_kg, and spring_n_per_m where it is a spring",
            ));
        };
        let bench = RigBench { client: Arc::new(client), channel: number, load, priority: wire.priority };
        bench.is_ready(&chosen)?;
        Ok((rig, index, bench))
    }

    /// Whether the channel may be heated at all.
    fn is_ready(&self, name: &str) -> Outcome {
        let since = Instant::now();
        loop {
            let state = self.client.latest().channels()[self.channel];
            if let Some(fault) = state.fault() {
                return Err(Failure::input(format!("{name} has a fault: {}: {}", fault.flag(), fault.cause()))
                    .hint(format!("{}; then `sinew reset {name}`", fault.remedy())));
            }
            if state.mode() != Mode::Waiting || since.elapsed() > PROVING {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// What of a machine the rig has.
    pub fn spec(&self, rig: &Rig) -> Spec {
        spec(rig, self.client.info().rate_hz)
    }

    /// The numbers of a routine where nothing is set.
    pub fn options(&self, kind: RoutineKind, wire: &Channel, spec: &Spec) -> Options {
        let law = AlgorithmKind::named(wire.control.algorithm.word()).unwrap_or(AlgorithmKind::TimeOptimal);
        let estimator = EstimatorKind::named(wire.control.estimator.word()).unwrap_or(EstimatorKind::Fused);
        Options::on_rig(kind, &wire.model, spec, self.load, most_power_w(wire), (law, estimator))
    }

    /// The channel, claimed.
    pub fn claim(&self, rig: &Rig, wire: &Channel) -> Result<RunningRig, Failure> {
        RunningRig::claim(self.client.clone(), self.channel, rig, wire, self.load, self.priority).map_err(live::failure)
    }

    /// What a report says of where its numbers come from.
    pub fn sources(&self, wire: &Channel, at_rest: Option<AtRest>) -> OnRig {
        OnRig { position: position_sensor(wire, at_rest), load: self.load.to_string() }
    }

    /// What no rig can be asked for.
    pub fn check(&self, kind: RoutineKind, options: &Options, wire: &Channel) -> Outcome {
        let refuse = |what: String, hint: String| Err(Failure::input(what).hint(hint));
        let (most_w, most_duty) = (most_power_w(wire), wire.limits.max_duty);
        let most_heat = options.heating.iter().copied().fold(0.0, f64::max);
        let (quantity, most_heat) = match &options.programme {
            Some(programme) => (programme.quantity(), programme.most_heat()),
            None => (options.quantity, most_heat),
        };
        let least_power = "less, or maximum_power_w and maximum_duty of [channel.limits]";
        match quantity {
            Quantity::Power if !kind.is_closed_loop() && most_heat > most_w * (1.0 + 1e-9) => {
                return refuse(
                    format!(
                        "a heating of {most_heat:.3} W is more than {} takes: {most_w:.3} W at its largest duty",
                        wire.name
                    ),
                    least_power.into(),
                );
            }
            Quantity::Duty if most_heat > most_duty => {
                return refuse(
                    format!(
                        "a duty of {:.1} % is above {}'s largest, {:.1} %",
                        100.0 * most_heat,
                        wire.name,
                        100.0 * most_duty
                    ),
                    "less, or maximum_duty of [channel.limits]".into(),
                );
            }
            _ => {}
        }
        if kind.is_closed_loop() {
            let info = &self.client.channels()[self.channel];
            let (low, high) =
                (info.min_length_m / info.rest_length_m - 1.0, info.max_length_m / info.rest_length_m - 1.0);
            if let Some(place) = options.strains.iter().find(|strain| !(low..=high).contains(*strain)) {
                return refuse(
                    format!("--places: a strain of {:.3} % is out of {}'s reach", 100.0 * place, wire.name),
                    format!(
                        "{:.3} to {:.3} %: [channel.limits] and the wire's own stroke bound it",
                        100.0 * low,
                        100.0 * high
                    ),
                );
            }
        }
        Ok(())
    }

    /// What a reader must know of how it went.
    pub fn notes(&self, kind: RoutineKind, kept: &Kept, spec: &Spec) -> Vec<String> {
        let seconds = |rows: u64| rows as f64 / spec.rate_hz;
        let mut notes = Vec::new();
        if kept.held_back > 0 {
            notes.push(format!(
                "the driver gave another duty than was asked in {:.1} of {:.1} s: its limits, or its heat budget; what was measured is of the heat that was given",
                seconds(kept.held_back),
                seconds(kept.rows)
            ));
        }
        if kept.lapsed > 0 {
            notes.push(format!(
                "this program was kept from running, and the lease ran out: the wire was off for {:.1} s where it was not to be",
                seconds(kept.lapsed)
            ));
        }
        if kept.lost > 0 {
            notes.push(format!(
                "{} of the driver were not read in time; the recording has its own count",
                output::counted(kept.lost as usize, "cycle")
            ));
        }
        if kind == RoutineKind::ConstantForceSweep && !self.load.is_constant() {
            notes.push(format!("the load is no constant force but {}", self.load));
        }
        notes
    }
}

/// The rig as its driver read it.
fn read_by(client: &Client) -> Result<Rig, Failure> {
    let name = client.info().rig.to_string();
    let text = client.rig_text().map_err(live::failure)?.ok_or_else(|| {
        Failure::own(format!("the driver of {name} has left no rig file to read"))
            .hint("give the rig file: sinew test ROUTINE RIG.toml --rig NAME")
    })?;
    Rig::parse(&text, &format!("the rig file of the driver of {name}"))
        .map_err(|error| crate::commands::rig_failure(&error))
}

/// The recording of a run: every cycle of the driver from the first row on that belongs to it.
pub struct Recorded {
    path: Option<PathBuf>,
    recorder: Option<Recorder>,
}

impl Recorded {
    /// Into this file, whose folder is made.
    pub fn of(path: Option<PathBuf>) -> Result<Recorded, Failure> {
        if let Some(folder) = path.as_deref().and_then(|path| path.parent()) {
            std::fs::create_dir_all(folder).map_err(|error| {
                Failure::own(format!("{}: cannot be made: {error}", folder.display()))
                    .hint("check that you may write there")
            })?;
        }
        Ok(Recorded { path, recorder: None })
    }

    /// Begins with the first row that is recorded; says when it has ended by itself.
    pub fn watch(&mut self, on_rig: &RigBench, is_recorded: bool) -> Outcome {
        match (&self.recorder, &self.path) {
            (None, Some(path)) if is_recorded => {
                let client = Client::connect(on_rig.client.info().rig.as_str()).map_err(live::failure)?;
                let options = sinew_recorder::Options { overwrite: true, ..sinew_recorder::Options::new(path) };
                self.recorder = Some(Recorder::start(client, options).map_err(record::failure)?);
                Ok(())
            }
            // its own report has the reason
            (Some(recorder), _) if !recorder.is_running() => self.finish_now(),
            _ => Ok(()),
        }
    }

    fn finish_now(&mut self) -> Outcome {
        let Some(recorder) = self.recorder.take() else { return Ok(()) };
        recorder.stop();
        let report = recorder.join();
        match report.failure {
            Some(error) => Err(record::failure(error)),
            None => {
                if report.lost > 0 {
                    output::note(format_args!(
                        "warning: {} lost in the recording: {}",
                        output::counted(report.lost as usize, "cycle"),
                        gaps(&report.gaps, 0)
                    ));
                }
                Ok(())
            }
        }
    }

    /// Ends it: the file is whole.
    pub fn finish(mut self) -> Outcome {
        self.finish_now()
    }
}
