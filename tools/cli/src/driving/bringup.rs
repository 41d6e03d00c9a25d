//! `sinew bringup`: a soldered board's first hour, step by step. Each step says what to connect, looks under nothing or the sensing pulse,
//! says what was expected and what was seen, and names what is wrong. It is an ordinary driver with its supervisor on the rig's own
//! backend, held to 2 % on the channels that are looked at.

mod causes;
mod judge;
mod look;
mod parts;
mod questions;
mod report;

use std::path::{Path, PathBuf};
use std::time::Duration;

use sinew_rig::{BackendKind, Correction, EnableSignal, NO_PROGRAM, Rig, SamplingCircuit, Sensing};

use super::held::{Hold, MOST_DUTY};
use super::run::{Asked, Driven, drive};
use crate::args::{self, BringupStep as Step};
use crate::failure::{Failure, Outcome};
use crate::log;
use crate::output;

use causes::Cause;
use judge::{Dummy, Expected, Finding, Shows, Verdict};
use look::{Five, Look, Seen};
use parts::{dummy_ohm, dummy_w};
use questions::{Questions, Word};
use report::{Report, Stepped};

pub use parts::parts;

/// How long a button may take to show.
const BUTTON: Duration = Duration::from_secs(3);
/// No length is out of range while something else than a wire may be at the terminals.
const ANY_LENGTH_M: (f64, f64) = (1e-6, 199.0);

/// Runs the command.
pub fn bringup(args: &args::Bringup) -> Outcome {
    let rig = crate::commands::load_rig(Some(&args.rig))?;
    if args.parts {
        return output::print(parts(&rig).map_err(|error| Failure::input(format!("{}: {error}", rig.file())))?);
    }
    let steps = steps(args);
    let chosen = chosen(args, &rig)?;
    refuse(&rig)?;
    if let Some(path) = &args.report {
        output::has_place(path)?;
    }
    let board = (0..rig.channels.len()).map(|place| {
        let place_of =
            |error| Failure::input(format!("{}: channel \"{}\": {error}", rig.file(), rig.channels[place].name));
        Expected::of(&rig, place).map_err(place_of)
    });
    let board: Vec<Expected> = board.collect::<Result<_, _>>()?;
    let hold = Hold::default();
    let mut bench = Bench {
        args,
        in_force: (0..rig.channels.len()).map(|place| in_force(&rig, place)).collect(),
        pending: vec![None; rig.channels.len()],
        dark: Vec::new(),
        open: Vec::new(),
        meter_v: args.supply_meter_v,
        ohm: args.dummy_ohm,
        is_copied: false,
        questions: Questions::default(),
        report: Report::new(&rig),
        chosen,
        board,
        rig: &rig,
        hold: hold.clone(),
    };
    let held = held(&rig);
    let asked = Asked { duration_s: None, report_to: None, leaves_traces: false, hold: Some(hold) };
    // what is latched on the way is not news: each step says what it is
    let hushed = log::hush();
    let driven = drive(&held, &asked, |driven, over| bench.walk(&steps, driven, over));
    drop(hushed);
    let Bench { report, .. } = bench;
    if report.has_looked() {
        output::print(report.text())?;
    }
    if let Some(path) = &args.report {
        let text = output::json(&report)? + "\n";
        if path == Path::new("-") { output::print(text)? } else { output::write_file(path, text)? }
    }
    driven?;
    match report.first() {
        None if report.is_whole(&steps) => Ok(()),
        None => Err(Failure::own("the bring-up is not done").hint("go on with --from STEP")),
        Some(finding) => Err(Failure::own(format!("{}: {}", finding.id, finding.says)).hint(&finding.remedy)),
    }
}

/// The steps that are asked for, in their order.
fn steps(args: &args::Bringup) -> Vec<Step> {
    let all = [Step::Supply, Step::Estop, Step::Stages, Step::Dummy, Step::Wire].into_iter();
    match (args.only, args.from) {
        (Some(only), _) => vec![only],
        (_, Some(from)) => all.skip_while(|step| *step != from).collect(),
        (None, None) => all.collect(),
    }
}

fn chosen(args: &args::Bringup, rig: &Rig) -> Result<Vec<usize>, Failure> {
    if args.channels.is_empty() {
        return Ok((0..rig.channels.len()).collect());
    }
    let place = |name: &String| {
        let known = rig.channels.iter().map(|channel| channel.name.as_str());
        rig.channel(name)
            .map(|(place, _)| place)
            .ok_or_else(|| crate::commands::unknown_channel(rig.file(), name, known))
    };
    args.channels.iter().map(place).collect()
}

/// What there is nothing to bring up of.
fn refuse(rig: &Rig) -> Outcome {
    if rig.backend.kind == BackendKind::Simulated {
        return Err(Failure::input(format!("{}: its wires are simulated: there is no board to bring up", rig.file()))
            .hint("set kind in [backend]; to exercise it without a board: `sinew-front-end RIG.toml --link /tmp/front-end --mount nothing`"));
    }
    rig.check_drivable().map_err(|error| crate::commands::rig_failure(&error))?;
    if let Some(shared) = rig.channels.iter().find(|channel| channel.adc.circuit == SamplingCircuit::Shared) {
        return Err(Failure::input(format!(
            "{}: channel \"{}\": adc.circuit: a shared input shows nothing of an open terminal, which this command goes by",
            rig.file(),
            shared.name
        ))
        .hint("follow docs/bringup.md by hand: `sinew run`, `sinew status --json`"));
    }
    Ok(())
}

/// The rig as it is driven: nobody commands it, nothing but resistance and current is judged by its supervisor, for something else
/// than a wire may be at the terminals, and nobody gets more than the bring-up may give.
fn held(rig: &Rig) -> Rig {
    let mut held = rig.clone();
    held.program = NO_PROGRAM.into();
    held.joints.clear();
    for channel in &mut held.channels {
        channel.control.sensing = Sensing::Resistance;
        // what a rig file keeps below that it does for a thin wire's sake
        let own = Some(channel.control.minimum_duty).filter(|duty| *duty > 0.0);
        channel.control.minimum_duty = own.map_or(MOST_DUTY, |duty| duty.min(MOST_DUTY));
        (channel.limits.min_length_m, channel.limits.max_length_m) = ANY_LENGTH_M;
    }
    held
}

/// Gains and offsets of a channel as the rig file has them.
fn in_force(rig: &Rig, place: usize) -> Five<Correction> {
    let channel = &rig.channels[place].backend;
    match rig.backend.kind {
        BackendKind::Linux => {
            let of = |input: &sinew_rig::LinuxInput| Correction { gain: input.gain, offset: input.offset };
            let linux = &channel.linux;
            Five {
                v1: of(&linux.v1),
                v2: of(&linux.v2),
                v3: of(&linux.v3),
                current: of(&linux.current),
                supply: of(&linux.supply),
            }
        }
        BackendKind::Serial | BackendKind::Simulated => {
            let inputs = channel.serial.inputs;
            Five { v1: inputs.v1, v2: inputs.v2, v3: inputs.v3, current: inputs.current, supply: inputs.supply }
        }
    }
}

/// The same with others in their place.
fn put_in_force(rig: &mut Rig, place: usize, five: &Five<Correction>, measured: &str) {
    let kind = rig.backend.kind;
    let channel = &mut rig.channels[place].backend;
    match kind {
        BackendKind::Linux => {
            let linux = &mut channel.linux;
            let put = |input: &mut sinew_rig::LinuxInput, by: &Correction| {
                if input.name.is_some() {
                    (input.gain, input.offset) = (by.gain, by.offset);
                }
            };
            put(&mut linux.v1, &five.v1);
            put(&mut linux.v2, &five.v2);
            put(&mut linux.v3, &five.v3);
            put(&mut linux.current, &five.current);
            put(&mut linux.supply, &five.supply);
            linux.measured = Some(measured.into());
        }
        BackendKind::Serial | BackendKind::Simulated => {
            let inputs = &mut channel.serial.inputs;
            (inputs.v1, inputs.v2, inputs.v3) = (five.v1, five.v2, five.v3);
            (inputs.current, inputs.supply) = (five.current, five.supply);
            channel.serial.measured = Some(measured.into());
        }
    }
}

/// One correction after another, in as many digits as a meter has, and some more.
fn after(new: &Correction, old: &Correction) -> Correction {
    let rounded = |value: f64| (value * 1e6).round() / 1e6 + 0.0;
    Correction { gain: rounded(new.gain * old.gain), offset: rounded(new.gain * old.offset + new.offset) }
}

/// A board on a bench.
struct Bench<'a> {
    args: &'a args::Bringup,
    rig: &'a Rig,
    board: Vec<Expected>,
    chosen: Vec<usize>,
    hold: Hold,
    questions: Questions,
    report: Report,
    /// Gains and offsets as the driver reads by them.
    in_force: Vec<Five<Correction>>,
    /// Those found, on top.
    pending: Vec<Option<Five<Correction>>>,
    /// Of every channel, in the dark and under the pulse, with nothing connected.
    dark: Vec<Seen>,
    open: Vec<Seen>,
    /// By a meter.
    meter_v: Option<f64>,
    ohm: Option<f64>,
    /// Whether the rig file as it was is kept.
    is_copied: bool,
}

/// What comes after a look.
enum Next {
    Again,
    On,
    End,
}

impl Bench<'_> {
    fn walk(&mut self, steps: &[Step], driven: &Driven<'_>, over: &dyn Fn() -> bool) -> Outcome {
        let mut look = Look::new(&driven.rig.name, driven.driver, self.hold.clone(), over)?;
        output::print(format_args!(
            "{}: {} on {}\nNothing gets more than {:.0} % duty. Enter answers a step that is done, s goes on without it, q ends.\n",
            self.rig.name,
            output::counted(self.rig.channels.len(), "channel"),
            driven.wires,
            MOST_DUTY * 100.0
        ))?;
        for step in steps {
            let is_stopped = self.rig.backend.estop.fitted && !matches!(step, Step::Supply | Step::Estop);
            if is_stopped && !look.reset_stop()? {
                let finding = Finding::new(None, Cause::StopOpen, "the contact is open where it should be closed");
                self.report.add(Stepped::of(
                    *step,
                    None,
                    &Verdict { findings: vec![finding], ..Verdict::default() },
                    self.rig,
                ));
                return Ok(());
            }
            let goes_on = match step {
                Step::Supply => self.repeat(*step, None, &mut look, Bench::supply)?,
                Step::Estop if !self.rig.backend.estop.fitted => true,
                Step::Estop => self.repeat(*step, None, &mut look, Bench::estop)?,
                Step::Stages => self.repeat(*step, None, &mut look, Bench::stages)?,
                Step::Dummy => self.each(*step, &mut look, Bench::dummy)?,
                Step::Wire => self.each(*step, &mut look, Bench::wire)?,
            };
            if !goes_on {
                break;
            }
        }
        Ok(())
    }

    fn each<'l>(
        &mut self,
        step: Step,
        look: &mut Look<'l>,
        body: fn(&mut Self, usize, &mut Look<'l>) -> Result<Option<Verdict>, Failure>,
    ) -> Result<bool, Failure> {
        for place in self.chosen.clone() {
            if !self.repeat(step, Some(place), look, body)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// A step until nothing is wrong, or nobody wants to mend it; whether to go on.
    fn repeat<'l>(
        &mut self,
        step: Step,
        place: Option<usize>,
        look: &mut Look<'l>,
        body: fn(&mut Self, usize, &mut Look<'l>) -> Result<Option<Verdict>, Failure>,
    ) -> Result<bool, Failure> {
        loop {
            let verdict = match body(self, place.unwrap_or(0), look) {
                // only who stands by the rig may reset it, and go on
                Err(_) if look.was_stopped() => {
                    let text = "The emergency stop is open, or was: somebody has pressed it, or the line was late. Release it; Enter resets it and looks again.";
                    if self.asked("estop again", text, look)? && look.reset_stop()? {
                        continue;
                    }
                    let finding = Finding::new(None, Cause::StopOpen, "it cannot be reset");
                    Verdict { findings: vec![finding], ..Verdict::default() }
                }
                verdict => match verdict? {
                    Some(verdict) => verdict,
                    None => return Ok(false),
                },
            };
            let stepped = Stepped::of(step, place, &verdict, self.rig);
            output::print(stepped.text())?;
            let is_good = verdict.is_good();
            let conducts = verdict.findings.iter().any(|finding| finding.cause == Cause::StageOn);
            self.report.add(stepped);
            if is_good {
                return Ok(true);
            }
            match self.next(step, conducts, look)? {
                Next::Again => {}
                Next::On => return Ok(true),
                Next::End => return Ok(false),
            }
        }
    }

    /// What to do with something wrong.
    fn next(&mut self, step: Step, conducts: bool, look: &Look<'_>) -> Result<Next, Failure> {
        let id = format!("mended {}", step.word());
        let text = match conducts {
            true => "Take the supply away, mend it, then Enter looks again; q ends.",
            false => "Mend it, then Enter looks again; s goes on all the same, q ends.",
        };
        loop {
            match self.questions.ask(&id, text, &|| look.is_over())? {
                Word::Done => return Ok(Next::Again),
                Word::Quit => return Ok(Next::End),
                Word::Skip if conducts => {
                    output::print("A wire would be heated without end: not before this is mended.\n")?
                }
                Word::Skip => return Ok(Next::On),
            }
        }
    }

    fn asked(&mut self, id: &str, text: &str, look: &Look<'_>) -> Result<bool, Failure> {
        Ok(self.questions.ask(id, text, &|| look.is_over())? == Word::Done)
    }

    fn meter(&mut self, look: &Look<'_>) -> Result<(), Failure> {
        if self.args.supply_meter_v.is_none() {
            let text = "What does a meter show at the board's supply terminals, V? (Enter: there is no meter; nothing is corrected then)";
            self.meter_v = self.questions.number("supply meter", text, &|| look.is_over())?.or(self.meter_v);
        }
        Ok(())
    }

    fn supply(&mut self, _: usize, look: &mut Look<'_>) -> Result<Option<Verdict>, Failure> {
        let text = "Connect nothing to the wires' terminals, put every voltage clip of a channel (V1, V2, V3) on its moving end's terminal, and switch the supply on.";
        if !self.asked("supply", text, look)? {
            return Ok(None);
        }
        self.meter(look)?;
        self.dark = look.dark()?;
        Ok(Some(judge::supply(&self.board, &self.dark, self.meter_v, self.args.accept_gains)))
    }

    fn estop(&mut self, _: usize, look: &mut Look<'_>) -> Result<Option<Verdict>, Failure> {
        let mut verdict = Verdict::default();
        let released = "Release the emergency stop.";
        if !self.asked("estop released", released, look)? {
            return Ok(None);
        }
        let closed = look.stop_becomes(true, BUTTON)?;
        if !self.asked("estop pressed", "Press the emergency stop.", look)? {
            return Ok(None);
        }
        let opened = look.stop_becomes(false, BUTTON)?;
        if !self.asked("estop released again", released, look)? {
            return Ok(None);
        }
        let cause = match (closed, opened) {
            (true, true) => (!look.stop_becomes(true, BUTTON)?).then_some(Cause::StopOpen),
            (true, false) => Some(Cause::StopBridged),
            // what was open when released either closes with the button or never
            (false, _) if look.stop_becomes(true, Duration::from_millis(100))? => Some(Cause::StopBridged),
            (false, _) => Some(self.pressed_or_never(look)?),
        };
        if let Some(cause) = cause {
            let word = |is: bool| if is { "closed" } else { "open" };
            let saw =
                format!("released {}, pressed {}", word(closed), word(!opened || cause == Cause::StopNormallyOpen));
            verdict.findings.push(Finding::new(None, cause, saw));
        } else if !look.reset_stop()? {
            verdict.findings.push(Finding::new(None, Cause::StopOpen, "it cannot be reset"));
        }
        Ok(Some(verdict))
    }

    /// A contact that is open when released: whether it closes with the button.
    fn pressed_or_never(&mut self, look: &mut Look<'_>) -> Result<Cause, Failure> {
        if !self.asked("estop pressed once more", "Press the emergency stop once more, and hold it.", look)? {
            return Ok(Cause::StopOpen);
        }
        Ok(if look.stop_becomes(true, BUTTON)? { Cause::StopNormallyOpen } else { Cause::StopOpen })
    }

    /// The supply as well as it is known: by a meter, as read, or as it should be.
    fn supply_v(&self) -> f64 {
        let read =
            self.dark.first().map(|seen| seen.read.supply.mean).filter(|read| *read > 0.5 * self.board[0].supply_v);
        self.meter_v.or(read).unwrap_or(self.board[0].supply_v)
    }

    fn stages(&mut self, _: usize, look: &mut Look<'_>) -> Result<Option<Verdict>, Failure> {
        let text = "Leave the terminals open and the clips where they are: every stage gets its sensing pulse in turn.";
        if !self.asked("stages", text, look)? {
            return Ok(None);
        }
        if self.meter_v.is_none() {
            self.meter(look)?;
        }
        self.dark = look.dark_with_supply(self.board.len())?;
        let all: Vec<usize> = (0..self.board.len()).collect();
        if let Some(place) = self.board.iter().zip(&self.dark).position(|(expected, seen)| expected.conducts(seen)) {
            let finding = Finding::new(place, Cause::StageOn, "there is voltage at an open terminal with duty 0");
            return Ok(Some(Verdict { findings: vec![finding], ..Verdict::default() }));
        }
        self.open = look.pulse(&all)?;
        let has_switch = self.rig.backend.enable.signal != EnableSignal::None;
        Ok(Some(judge::stages(&self.board, &self.dark, &self.open, self.supply_v(), has_switch)))
    }

    fn dummy(&mut self, place: usize, look: &mut Look<'_>) -> Result<Option<Verdict>, Failure> {
        let name = self.board[place].name.clone();
        let near = dummy_ohm(self.board[place].cold_ohm);
        let full_w = dummy_w(&self.rig.channels[place].model, near);
        let text = format!(
            "Connect a resistor of about {near} Ω ({full_w:.0} W, should a stage stick) to the terminals of {name}, and to no others; every clip of {name} stays at the moving end."
        );
        if !self.asked(&format!("dummy {name}"), &text, look)? {
            return Ok(None);
        }
        while self.ohm.is_none() {
            let text = "How many Ω does a meter show of the resistor, by itself?";
            self.ohm = self.questions.number("dummy ohm", text, &|| look.is_over())?.filter(|ohm| *ohm > 0.0);
            if self.ohm.is_none() && self.questions.is_at_end() {
                return Ok(None);
            }
        }
        let (Some(ohm), supply_v) = (self.ohm, self.supply_v()) else { return Ok(None) };
        let dark = look.dark()?[place];
        let lit = look.pulse(&[place])?[0];
        let is_metered = self.meter_v.is_some();
        let (open, accepts) = (self.open.get(place), self.args.accept_gains);
        let expected = &self.board[place];
        let dummy = Dummy { expected, dark: &dark, open, lit: &lit, supply_v, is_metered, ohm, accepts };
        let shows = dummy.shows();
        let elsewhere = match shows {
            _ if !lit.is_seen() => None,
            Shows::Load => None,
            Shows::Nothing | Shows::Open => self.search(place, shows, ohm, look)?,
        };
        let verdict = match elsewhere {
            Some(finding) => Verdict { findings: vec![finding], ..Verdict::default() },
            None if shows == Shows::Nothing && lit.is_seen() => {
                let saw = format!("V3 {:.3} V, {:.4} A under the pulse", lit.read.v3.mean, lit.read.current.mean);
                Verdict { findings: vec![Finding::new(place, Cause::StageDead, saw)], ..Verdict::default() }
            }
            None => dummy.judge(),
        };
        if let Some(found) = verdict.corrections {
            self.pending[place] = Some(found);
            if !self.args.keep {
                self.write(place, &found, ohm)?;
            }
        }
        Ok(Some(verdict))
    }

    /// Where the resistor is, when it is not where it was said to be.
    fn search(&self, place: usize, shows: Shows, ohm: f64, look: &mut Look<'_>) -> Result<Option<Finding>, Failure> {
        let supply_v = self.supply_v();
        for other in (0..self.board.len()).filter(|other| *other != place) {
            let is_load = |at: usize, seen: &Seen| judge::has_shown(&self.board[at], seen, supply_v, ohm);
            let by = |cause, saw: String| Ok(Some(Finding::new(place, cause, saw)));
            let (own, others) = (&self.board[place].name, &self.board[other].name);
            if shows == Shows::Open {
                if is_load(other, &look.pulse(&[other])?[0]) {
                    return by(Cause::ChannelsExchanged, format!("the resistor answers to {others}, and not to {own}"));
                }
                continue;
            }
            let both = look.pulse(&[place, other])?;
            if is_load(place, &both[0]) {
                return by(
                    Cause::OutputsExchanged,
                    format!("{own} reads the resistor while {others} is given its pulse"),
                );
            }
            if is_load(other, &both[1]) {
                return by(
                    Cause::SensesExchanged,
                    format!("{others} reads the resistor while {own} is given its pulse"),
                );
            }
        }
        Ok(None)
    }

    fn wire(&mut self, place: usize, look: &mut Look<'_>) -> Result<Option<Verdict>, Failure> {
        let name = self.board[place].name.clone();
        let taps = match self.rig.channels[place].model.taps {
            Some(taps) => format!(
                ", V1 on it {:.1} mm from the fixed end, V2 {:.1} mm further, V3 on the moving end's terminal",
                taps.l0_m * 1e3,
                taps.ls_m * 1e3
            ),
            None => ", V3 on the moving end's terminal".into(),
        };
        let text = format!("Take the resistor off. Mount the wire of {name}, cold and under its load{taps}.");
        if !self.asked(&format!("wire {name}"), &text, look)? {
            return Ok(None);
        }
        let pending = self.pending[place];
        let dark = corrected(look.dark()?[place], pending.as_ref());
        let lit = corrected(look.pulse(&[place])?[0], pending.as_ref());
        let read = Some(lit.read.supply.mean).filter(|read| *read > 0.5 * self.board[place].supply_v);
        let supply_v = self.meter_v.or(read).unwrap_or(self.board[place].supply_v);
        let mut verdict = judge::wire(&self.board[place], &dark, &lit, supply_v);
        // what the supervisor has called wrong is wrong, also where no number of this step is
        if let Some(fault) = lit.fault.filter(|_| verdict.is_good()) {
            let saw = format!("{}: {}; {}", fault.flag(), fault.cause(), fault.remedy());
            verdict.findings.push(Finding::new(place, Cause::Other, saw));
        }
        Ok(Some(verdict))
    }

    /// Writes what was found of a channel into the rig file as it is now, whatever else somebody has changed in it meanwhile.
    fn write(&mut self, place: usize, found: &Five<Correction>, ohm: f64) -> Outcome {
        let path = &self.args.rig;
        let mut file = crate::commands::load_rig(Some(path))?;
        let name = &self.board[place].name;
        let Some((at, _)) = file.channel(name) else {
            return Err(Failure::input(format!("{}: has no channel \"{name}\" any more", path.display())));
        };
        if !self.is_copied {
            let copy = copy_of(path);
            output::write_file(&copy, file.text())?;
            output::print(format_args!("{} as it was is in {}\n", path.display(), copy.display()))?;
            self.report.copy = Some(copy.display().to_string());
            self.is_copied = true;
        }
        let old = &self.in_force[place];
        let five = Five {
            v1: if self.rig.channels[place].model.taps.is_some() { after(&found.v1, &old.v1) } else { old.v1 },
            v2: if self.rig.channels[place].model.taps.is_some() { after(&found.v2, &old.v2) } else { old.v2 },
            v3: after(&found.v3, &old.v3),
            current: after(&found.current, &old.current),
            supply: after(&found.supply, &old.supply),
        };
        let meter_v = self.meter_v.unwrap_or(f64::NAN);
        let now = sinew_recording::Utc::now();
        let measured = format!("{now}, sinew bringup: supply {meter_v} V and resistor {ohm} Ω by a meter");
        put_in_force(&mut file, at, &five, &measured);
        output::write_file(path, file.to_toml())?;
        output::print(format_args!("gains and offsets of {name} are in {}\n", path.display()))?;
        self.report.written.push(name.clone());
        Ok(())
    }
}

/// What was seen, by corrections that the driver does not have yet.
fn corrected(mut seen: Seen, by: Option<&Five<Correction>>) -> Seen {
    let Some(by) = by else { return seen };
    let read = &mut seen.read;
    let pairs = [
        (&mut read.v1, &by.v1),
        (&mut read.v2, &by.v2),
        (&mut read.v3, &by.v3),
        (&mut read.current, &by.current),
        (&mut read.supply, &by.supply),
    ];
    for (reading, by) in pairs {
        (reading.mean, reading.sigma) = (by.apply(reading.mean), by.gain * reading.sigma);
    }
    seen
}

/// Where a rig file is kept as it was.
fn copy_of(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}.before-{}", sinew_recording::Utc::now().stamp()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_correction_comes_after_another_and_keeps_a_meters_digits() {
        let (new, old) = (Correction { gain: 1.02, offset: -0.01 }, Correction { gain: 0.5, offset: 0.1 });
        let both = after(&new, &old);
        for raw in [0.0, 3.0, 12.0] {
            assert!((both.apply(raw) - new.apply(old.apply(raw))).abs() < 1e-5);
        }
        assert_eq!(after(&Correction::NONE, &Correction::NONE), Correction::NONE);
    }
}
