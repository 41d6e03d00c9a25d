//! `sinew test`: the routines of the test machine, on a simulated one or a running rig, with their recordings and reports.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use sinew_control::{AlgorithmKind, EstimatorKind};
use sinew_machine::hanging::{DAMPING_NOTE, playable};
use sinew_machine::plan::{CHARACTERISE, CHARACTERISE_ABOUT, DAMPING, spaced, strokes};
use sinew_machine::{Ending, MachineError, Options, Programme, Quantity, Report, RoutineKind, analysis, record};

use super::mounted::{Bench, Done, Task};
use crate::args::{self, TestRoutine};
use crate::commands::diagnose::write_all;
use crate::commands::simulate::recording_failure;
use crate::ending;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Frequencies of a range.
const SPACED: usize = 7;

/// Runs the command.
pub fn test(args: &args::Test) -> Outcome {
    match &args.routine {
        TestRoutine::List(args) => list(args.json),
        TestRoutine::Characterise(args) => super::characterise::characterise(args),
        TestRoutine::DirectStrain(args) => routine(RoutineKind::DirectStrain, &args.mounted, &[], &|options, _| {
            direct(options, &args.direct);
            set(&mut options.strains, args.strain.as_ref());
        }),
        TestRoutine::DirectLoad(args) => routine(RoutineKind::DirectLoad, &args.mounted, &[], &|options, _| {
            direct(options, &args.direct);
            set(&mut options.loads_n, args.load.as_ref());
        }),
        TestRoutine::ConstantForceSweep(args) => {
            let of_machine = [("--load", args.load.is_some())];
            routine(RoutineKind::ConstantForceSweep, &args.mounted, &of_machine, &|options, _| {
                sweep(options, &args.sweep);
                set(&mut options.loads_n, args.load.as_ref());
            })
        }
        TestRoutine::ConstantStrainSweep(args) => {
            routine(RoutineKind::ConstantStrainSweep, &args.mounted, &[], &|options, _| {
                sweep(options, &args.sweep);
                set(&mut options.strains, args.strain.as_ref());
            })
        }
        TestRoutine::PositionRegulation(args) => {
            routine(RoutineKind::PositionRegulation, &args.mounted, &of_hanging(&args.hanging), &|options, bench| {
                hanging(options, &args.hanging, bench);
                cycles(options, args.cycles);
                options.hold_s = args.hold.unwrap_or(options.hold_s);
            })
        }
        TestRoutine::PositionTracking(args) => {
            routine(RoutineKind::PositionTracking, &args.mounted, &of_hanging(&args.hanging), &|options, bench| {
                hanging(options, &args.hanging, bench);
                cycles(options, args.cycles);
                frequencies(options, args.frequency.as_ref());
                options.shape = args.wave.unwrap_or(options.shape);
            })
        }
        TestRoutine::TrackingSweep(args) => {
            routine(RoutineKind::TrackingSweep, &args.mounted, &of_hanging(&args.hanging), &|options, bench| {
                hanging(options, &args.hanging, bench);
                cycles(options, args.cycles);
                frequencies(options, args.frequencies.as_ref());
            })
        }
        TestRoutine::BreakIn(args) => {
            let of_machine = [("--load", args.load.is_some())];
            routine(RoutineKind::BreakIn, &args.mounted, &of_machine, &|options, _| {
                heating(options, args.heating.as_ref());
                cycles(options, args.cycles);
                frequencies(options, args.frequency.as_ref());
                set(&mut options.loads_n, args.load.as_ref());
                let typed = args.strain_within.as_ref().and_then(|within| within.values.first());
                options.tolerance.strain = typed.copied().unwrap_or(options.tolerance.strain);
                options.tolerance.kelvin = args.kelvin_within.unwrap_or(options.tolerance.kelvin);
            })
        }
        TestRoutine::Programme(args) => {
            let programme = Arc::new(read_programme(&args.programme, args.mounted.wire.running.is_some())?);
            routine(RoutineKind::Programme, &args.mounted, &[], &|options, _| {
                options.programme = Some(Arc::clone(&programme));
            })
        }
    }
}

/// What of the closed loops a rig has itself.
fn of_hanging(typed: &args::Hanging) -> [(&'static str, bool); 10] {
    [
        ("--load", typed.load.is_some()),
        ("--mass", typed.mass.is_some()),
        ("--damping", typed.damping.is_some()),
        ("--heating", typed.heating.is_some()),
        ("--controller", typed.controller.is_some()),
        ("--estimator", typed.estimator.is_some()),
        ("--lambda", typed.lambda.is_some()),
        ("--gains", typed.gains.is_some()),
        ("--switched", typed.switched),
        ("--disturb", !typed.disturb.is_empty()),
    ]
}

/// Refuses, before anything is connected to, what a running rig has not: the routine's own needs, and options that are of the machine.
fn is_for_rigs(kind: RoutineKind, mounted: &args::Mounted, of_machine: &[(&str, bool)]) -> Outcome {
    let Some(name) = &mounted.wire.running else { return Ok(()) };
    if let Some(needs) = kind.needs_machine() {
        return Err(Failure::input(format!("{} needs {needs}, which the running rig {name} has not", kind.word()))
            .hint(format!(
                "{}; or the test machine: sinew test {} RIG.toml",
                kind.on_rig().replace('`', ""),
                kind.word()
            )));
    }
    let chamber = [("--chamber", mounted.chamber.is_some())];
    let Some((option, _)) = of_machine.iter().chain(&chamber).find(|(_, is_typed)| *is_typed) else { return Ok(()) };
    let (has_not, hint) = match *option {
        "--chamber" => ("has no chamber", "leave it out; ambient_c of the rig file says how warm the air is"),
        "--load" | "--mass" | "--damping" | "--disturb" => (
            "changes no load: what hangs on the wire pulls at it",
            "leave it out; [channel.load] of the rig file says what hangs there",
        ),
        "--heating" => ("heats as its driver's law says", "leave it out; [channel.limits] bound the power"),
        _ => (
            "is controlled by its driver's own law",
            "leave it out; [channel.control] of the driver's rig file has the law and its numbers",
        ),
    };
    Err(Failure::input(format!("{option}: the running rig {name} {has_not}")).hint(hint))
}

/// A programme from its file.
fn read_programme(path: &Path, on_rig: bool) -> Result<Programme, Failure> {
    let options = sinew_recording::Options::default();
    let recording = sinew_recording::read(path, &options).map_err(recording_failure)?;
    let programme = if on_rig { Programme::on_rig(&recording) } else { Programme::of(&recording) };
    programme.map_err(|error| Failure::input(format!("{}: {error}", path.display())).hint(error.remedy()))
}

/// What there is.
fn list(json: bool) -> Outcome {
    #[derive(Serialize)]
    struct Entry {
        name: &'static str,
        about: &'static str,
        on_rig: bool,
        needs: Option<&'static str>,
    }
    let entry = |kind: RoutineKind| Entry {
        name: kind.word(),
        about: kind.about(),
        on_rig: kind.needs_machine().is_none(),
        needs: kind.needs_machine(),
    };
    let last = Entry { name: CHARACTERISE, about: CHARACTERISE_ABOUT, on_rig: true, needs: None };
    let entries = RoutineKind::ALL.map(entry).into_iter().chain([last]);
    if json {
        return output::print_json(&entries.collect::<Vec<_>>());
    }
    let text: String = entries.map(|Entry { name, about, .. }| format!("{name:<22}  {about}\n")).collect();
    output::print(format_args!("{text}\n{}", sinew_machine::plan::rigs_table_text()))
}

/// Runs a routine and says what it came to.
fn routine(
    kind: RoutineKind,
    mounted: &args::Mounted,
    of_machine: &[(&str, bool)],
    choose: &dyn Fn(&mut Options, &Bench),
) -> Outcome {
    is_for_rigs(kind, mounted, of_machine)?;
    let bench = Bench::read(&mounted.wire)?;
    if let Some(out) = &mounted.out {
        output::can_become_folder(out)?;
    }
    let (model, spec) = (&bench.wire().model, &bench.spec);
    let mut options = match bench.on_rig() {
        Some(on_rig) => on_rig.options(kind, bench.wire(), spec),
        None => Options::default_for(kind, model, spec),
    };
    options.chamber_c = mounted.chamber;
    choose(&mut options, &bench);
    check(kind, &options, &bench)?;
    let asked = ending::asked()?;
    let task = Task {
        kind,
        options: &options,
        seed: 0,
        name: kind.word(),
        out: mounted.out.as_deref(),
        real_time: mounted.real_time,
    };
    let Done { ran, routine, simulated, notes: went, at_rest } = bench.run(&task, &asked)?;
    let run =
        analysis::Run { kind, options: &options, stages: routine.stages(), rows: &ran.rows, model, spec, at_rest };
    let notes = notes(kind, &options, &bench).into_iter().chain(went).collect();
    let report = Report::of(&run, &ran, simulated, bench.sources(at_rest), bench.about(), notes);
    let json = output::json(&report)? + "\n";
    if let Some(out) = &mounted.out {
        let mounted_rig = match bench.on_rig() {
            Some(_) => bench.rig.to_toml(),
            None => record::rig_in_machine(&bench.rig, bench.channel).to_toml(),
        };
        let (page, picture) = (sinew_machine::page(&run, &report), sinew_machine::picture(&run));
        let files =
            [("report.html", page), ("report.json", json.clone()), ("picture.svg", picture), ("rig.toml", mounted_rig)];
        let files: Vec<(&str, &str)> = files.iter().map(|(name, text)| (*name, text.as_str())).collect();
        write_all(out, &files)?;
        output::note(format_args!("written: {}", out.display()));
    }
    if mounted.json { output::print(json) } else { output::print(report.text()) }?;
    // a machine's limits end a run in order; what ends it on a rig, somebody has to look after
    match &ran.ending {
        Ending::Failed(error) if bench.on_rig().is_some() => Err(ended(kind.word(), error, mounted.out.as_deref())),
        _ => Ok(()),
    }
}

/// Why a run on a rig ended, what to do, and where what was recorded until then is.
pub fn ended(name: &str, error: &MachineError, out: Option<&Path>) -> Failure {
    let failure = Failure::own(format!("{name}: ended by the rig: {error}"));
    let failure = match out {
        Some(out) => failure.also(format_args!(
            "what was recorded until then is whole, in {}",
            out.join(format!("{name}.mcap")).display()
        )),
        None => failure,
    };
    match error {
        MachineError::Ended { remedy, .. } => failure.hint(remedy),
        _ => failure.hint("look at the driver: `sinew status`"),
    }
}

fn set(values: &mut Vec<f64>, typed: Option<&args::Values>) {
    if let Some(typed) = typed {
        values.clone_from(&typed.values);
    }
}

fn cycles(options: &mut Options, typed: Option<u16>) {
    options.cycles = typed.map_or(options.cycles, usize::from);
}

fn heating(options: &mut Options, typed: Option<&args::Heating>) {
    if let Some(typed) = typed {
        options.quantity = typed.quantity;
        options.heating.clone_from(&typed.values.values);
    }
}

fn frequencies(options: &mut Options, typed: Option<&args::Values>) {
    match typed {
        Some(typed) if typed.is_range => {
            options.frequencies_hz = spaced(typed.values[0], typed.values[1], SPACED);
        }
        typed => set(&mut options.frequencies_hz, typed),
    }
}

fn direct(options: &mut Options, typed: &args::Direct) {
    heating(options, typed.heating.as_ref());
    cycles(options, typed.cycles);
    options.speed_m_s = typed.rate.unwrap_or(options.speed_m_s);
    if typed.no_reset {
        options.reset_w = None;
    }
}

fn sweep(options: &mut Options, typed: &args::Sweep) {
    heating(options, typed.heating.as_ref());
    cycles(options, typed.cycles);
    frequencies(options, typed.frequencies.as_ref());
    options.shape = typed.wave.unwrap_or(options.shape);
}

fn hanging(options: &mut Options, typed: &args::Hanging, bench: &Bench) {
    set(&mut options.strains, typed.places.as_ref());
    // the rest is the driver's
    if bench.on_rig().is_some() {
        return;
    }
    let (model, spec) = (&bench.wire().model, &bench.spec);
    heating(options, typed.heating.as_ref());
    let load_n = typed.load.as_ref().and_then(|load| load.values.first().copied()).unwrap_or(options.plant.load_n);
    options.plant = playable(model, load_n, typed.damping.unwrap_or(DAMPING), typed.mass, spec);
    let full_power_w = options.heating.iter().copied().fold(0.0, f64::max);
    let shares: &[f64] = &[0.3, 0.7];
    options.strains = strokes(model, &options.plant, full_power_w, shares);
    set(&mut options.strains, typed.places.as_ref());
    options.law = typed.controller.unwrap_or(AlgorithmKind::TimeOptimal);
    options.estimator = typed.estimator.unwrap_or(EstimatorKind::Fused);
    options.settings.lambda_per_s = typed.lambda;
    options.settings.pid = typed.gains;
    if typed.switched {
        options.settings.modulation = sinew_control::Modulation::WholePeriods;
    }
    options.disturbances.clone_from(&typed.disturb);
}

/// What no routine can be run with.
fn check(kind: RoutineKind, options: &Options, bench: &Bench) -> Outcome {
    let (spec, geometry) = (&bench.spec, &bench.wire().model.geometry);
    let refuse = |what: String, hint: String| Err(Failure::input(what).hint(hint));
    let played = options.programme.as_deref();
    match bench.on_rig() {
        Some(on_rig) => on_rig.check(kind, options, bench.wire())?,
        None if options.quantity == Quantity::Duty => {
            return refuse(
                "--heating: the machine's amplifier has no duty".into(),
                "write power=0-1.3W; a running rig (--rig NAME) switches its wires".into(),
            );
        }
        None => {}
    }
    if let Some(programme) = played
        && programme.quantity() == Quantity::Current
        && programme.most_heat() > bench.wire().limits.max_current_a
    {
        return refuse(
            format!("{}: a current of {:.3} A is beyond the wire's limit", programme.name(), programme.most_heat()),
            format!("at most {:.3} A (max_current_a of the channel's limits)", bench.wire().limits.max_current_a),
        );
    }
    let longest = played.map_or(0.0, |programme| programme.longest_m() / geometry.length_m);
    let most_strain = options.strains.iter().copied().fold(longest, f64::max);
    if most_strain > spec.max_strain {
        let hint = format!("at most {:.3} % (machine.max_strain)", spec.max_strain * 100.0);
        return refuse(format!("a strain of {:.3} % is beyond the machine's limit", most_strain * 100.0), hint);
    }
    if bench.on_rig().is_none() && most_strain * geometry.length_m > 0.5 * spec.travel_m {
        let hint = "a shorter wire, a smaller strain, or machine.travel_mm".into();
        return refuse(format!("a strain of {:.3} % is beyond the cross-head's travel", most_strain * 100.0), hint);
    }
    let most_n = options.loads_n.iter().copied().chain([options.plant.load_n]);
    let most_n = most_n.fold(played.map_or(0.0, Programme::largest_n), f64::max);
    if most_n > spec.max_force_n {
        let hint = format!("at most {} N (machine.max_force_n)", spec.max_force_n);
        return refuse(format!("a load of {most_n} N is beyond the load cell's"), hint);
    }
    if kind == RoutineKind::DirectStrain && options.strains.len() != 2 {
        return refuse("--strain: takes two ends".into(), "write --strain 0-4%".into());
    }
    if kind == RoutineKind::DirectLoad && options.loads_n.len() != 2 {
        return refuse("--load: takes two ends".into(), "write --load 0.1-3N".into());
    }
    if kind.is_closed_loop() {
        if options.strains.len() < 2 {
            return refuse("--places: takes two or more".into(), "write --places 1,3%".into());
        }
        if options.quantity != Quantity::Power {
            return refuse(
                "--heating: a law sets a power".into(),
                "write --heating power=4W: the power at duty 1".into(),
            );
        }
    } else if kind == RoutineKind::BreakIn && options.quantity != Quantity::Power {
        return refuse(
            "--heating: a break-in sets a power, by which temperatures are reckoned".into(),
            "write --heating power=0-1.3W".into(),
        );
    } else if matches!(kind, RoutineKind::ConstantForceSweep | RoutineKind::ConstantStrainSweep | RoutineKind::BreakIn)
        && options.heating.len() > 2
    {
        return refuse("--heating: a sweep has two ends".into(), "write --heating power=0-1.3W".into());
    }
    if let Some(chamber_c) = options.chamber_c
        && !(spec.chamber_min_c..=spec.chamber_max_c).contains(&chamber_c)
    {
        let hint = format!(
            "{} to {} °C (machine.chamber_min_c, machine.chamber_max_c)",
            spec.chamber_min_c, spec.chamber_max_c
        );
        return refuse(format!("--chamber: {chamber_c} °C is beyond the chamber's range"), hint);
    }
    let most_hz = options.frequencies_hz.iter().copied().fold(0.0, f64::max);
    let is_of_frequencies = !matches!(
        kind,
        RoutineKind::DirectStrain | RoutineKind::DirectLoad | RoutineKind::PositionRegulation | RoutineKind::Programme
    );
    if is_of_frequencies && most_hz > 0.1 * spec.rate_hz {
        let hint = format!("at most {} Hz: a tenth of machine.rate_hz", 0.1 * spec.rate_hz);
        return refuse(format!("a frequency of {most_hz} Hz is too fast for the machine"), hint);
    }
    Ok(())
}

/// What a reader must know of how a routine was run.
fn notes(kind: RoutineKind, options: &Options, bench: &Bench) -> Vec<String> {
    let mut notes = Vec::new();
    let weighs_kg = options.plant.load_n / sinew_physics::formulas::STANDARD_GRAVITY_M_S2;
    if kind.is_closed_loop() && bench.on_rig().is_none() && options.plant.mass_kg > 1.001 * weighs_kg {
        notes.push(format!(
            "the mass is played as {:.3} kg, the load as {:.3} N: {DAMPING_NOTE}",
            options.plant.mass_kg, options.plant.load_n
        ));
    }
    if let Some(truth) = bench.truth() {
        notes.push(format!("the wire in the machine is that of {}", truth.file()));
    }
    notes
}
