//! `sinew design`: a wire from requirements, by the thesis' rules of chapter 2, with what it will do as predicted and as simulated.

mod answer;
mod text;

use sinew_design::{
    Change, Design, Joint, Lack, Method, Motion, Nearest, Requirement, Route, STOCK_DIAMETERS_M, Shortfall, Source,
    TUBE_FRICTION, Task, best, compromise, designs, nearest, simulate,
};

use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

use answer::Answer;
use text::{answer, mechanisms, shortfall, table};

/// As many nearest demands are named.
const NAMED: usize = 3;
/// Strokes that λ is said for, and how wrong parameters may be: what `tune` takes.
const STROKES: (f64, f64) = (0.1, 0.9);

/// Runs the command.
pub fn design(args: &args::Design) -> Outcome {
    let requirement = requirement(args)?;
    let diameters = match &args.diameter_m {
        Some(diameter_m) => std::slice::from_ref(diameter_m),
        None => &STOCK_DIAMETERS_M[..],
    };
    let all = designs(&requirement, diameters);
    let chosen = best(&all);
    if let Some(path) = &args.plot {
        output::write_file(path, compromise(&all, chosen))?;
        output::note(format_args!("written: {}", path.display()));
    }
    let Some(chosen) = chosen else { return Err(refused(&requirement, &all)) };
    let rig = chosen.rig().map_err(Failure::own)?;
    let task = Task::new(&rig, chosen.sizing.wire.stroke_m())
        .map_err(|obstacle| Failure::own(format!("what was designed is none: {obstacle:?}")))?;
    let simulated = simulate(&rig, &task).map_err(Failure::own)?;
    let reach = crate::commands::tune::reach_of(&rig.channels[0], &rig.nominal_model(0), STROKES, 0.0).as_modelled();
    if args.json {
        return output::print_json(&Answer::new(&requirement, &all, chosen, &simulated, reach));
    }
    let mut text = format!("{}\n{}", table(&all, chosen), answer(&requirement, chosen, &simulated, reach));
    if args.mechanisms {
        text.push_str(&mechanisms(&chosen.sizing.wire));
    }
    if args.board {
        text.push_str(&format!(
            "\nOn a board (docs/board.md):\n{}",
            super::bringup::parts(&rig).map_err(Failure::own)?
        ));
    }
    match &args.output {
        Some(path) if path.as_os_str() == "-" => {
            output::note(text);
            output::print(&chosen.rig_text)
        }
        Some(path) => {
            output::write_file(path, &chosen.rig_text)?;
            output::note(text);
            output::note(format_args!("written: {} (see `sinew tune` for its bandwidth)", path.display()));
            Ok(())
        }
        None => output::print(text),
    }
}

fn requirement(args: &args::Design) -> Result<Requirement, Failure> {
    let joint = args.joint.map(|joint| match joint {
        args::Joint::Pulley => Joint::Pulley,
        args::Joint::Lever => Joint::Lever,
    });
    let motion = match (args.force_n, args.stroke_m, args.torque_n_m, args.angle_rad) {
        (Some(force_n), Some(stroke_m), ..) => Motion::Linear { force_n, stroke_m },
        (_, _, Some(torque_n_m), Some(angle_rad)) => Motion::Rotary { torque_n_m, angle_rad, joint },
        _ => return Err(Failure::input("nothing to move").hint("give --force and --stroke, or --torque and --angle")),
    };
    if let (Some(wires), Some(in_series)) = (args.wires, args.in_series)
        && !wires.is_multiple_of(in_series)
    {
        return Err(Failure::input(format!("{wires} wires make no rows of {in_series} in series"))
            .hint(format!("--wires {}, or an --in-series that divides {wires}", wires.next_multiple_of(in_series))));
    }
    let source = Source {
        supply_v: args.supply_v,
        current_a: args.current_a,
        most_current_a: args.most_current_a,
        internal_ohm: args.internal_ohm.unwrap_or(0.0),
        charge_c: args.capacity_c,
        in_series: args.in_series,
    };
    let route = match (args.pulleys, args.tube_rad) {
        (Some(passes), _) => Route::Pulleys(passes),
        (_, Some(bent_rad)) => Route::Tube { bent_rad, friction: args.friction.unwrap_or(TUBE_FRICTION) },
        _ => Route::Straight,
    };
    let method = args.method.map(|method| match method {
        args::Method::Energy => Method::Energy,
        args::Method::Stroke => Method::Stroke,
    });
    let args::Design { cycle_s, span_m, wires, ambient_c, life_cycles, .. } = *args;
    Ok(Requirement { motion, method, cycle_s, span_m, route, wires, source, ambient_c, life_cycles })
}

/// That no wire does it, why the one that comes nearest does not, and what can be asked for instead.
fn refused(requirement: &Requirement, all: &[Design]) -> Failure {
    let limit = all
        .iter()
        .filter_map(|design| Some((design, design.shortfall.as_ref()?)))
        .min_by(|a, b| far(requirement, a.1).total_cmp(&far(requirement, b.1)));
    let mut failure = Failure::input("no wire does all of that");
    if let Some((design, why)) = limit {
        failure = failure.also(format_args!(
            "nearest to it: {} of {:.3} mm, but {}",
            design.sizing.wires,
            design.sizing.wire.diameter_m * 1e3,
            shortfall(requirement, design, why)
        ));
    }
    let tried: Vec<f64> = all.iter().map(|design| design.sizing.wire.diameter_m).collect();
    let others: &[f64] = if tried == STOCK_DIAMETERS_M { &[] } else { &STOCK_DIAMETERS_M };
    let found = nearest(requirement, &tried, others);
    if found.is_empty() {
        return failure.hint("no single change of what is asked for helps: ask for less of several things at once");
    }
    let said: Vec<String> = found.iter().take(NAMED).map(instead).collect();
    failure.hint(format!("what works instead: {}", said.join("; or ")))
}

/// How far a wire is from doing what is asked, as a logarithm; what has no measure is farthest.
fn far(requirement: &Requirement, why: &Shortfall) -> f64 {
    let ratio = match (why, requirement.motion, requirement.source) {
        (Shortfall::TooSlow(cycle_s), ..) => requirement.cycle_s.map(|asked| cycle_s / asked),
        (Shortfall::WeakSupply(volts), _, source) => source.supply_v.map(|has| volts / has),
        (Shortfall::LowCompliance(volts), _, source) => source.supply_v.map(|has| volts / has),
        (Shortfall::WeakCurrent(amps), _, source) => source.current_a.map(|has| amps / has),
        (Shortfall::TooMuchCurrent(amps), _, source) => source.most_current_a.map(|has| amps / has),
        (Shortfall::Lack(Lack::Pull(has)), Motion::Linear { force_n, .. }, _) => Some(force_n / has),
        (Shortfall::Lack(Lack::Pull(has)), Motion::Rotary { torque_n_m, .. }, _) => Some(torque_n_m / has),
        (Shortfall::Lack(Lack::Strain(has)), Motion::Linear { stroke_m, .. }, _) => Some(stroke_m / has),
        (Shortfall::Lack(Lack::Angle(has)), Motion::Rotary { angle_rad, .. }, _) => Some(angle_rad / has),
        _ => None,
    };
    ratio.map_or(f64::MAX, |ratio| ratio.ln().abs())
}

/// A demand that can be met, as options, with what meets it.
fn instead(nearest: &Nearest) -> String {
    let option = match nearest.change {
        Change::Cycle(s) => format!("--cycle {}", text::digits(s)),
        Change::Force(n) => format!("--force {}N", text::digits(n)),
        Change::Torque(n_m) => format!("--torque {}mNm", text::digits(n_m * 1e3)),
        Change::Stroke(m) => format!("--stroke {}mm", text::digits(m * 1e3)),
        Change::Angle(rad) => format!("--angle {}deg", text::digits((rad.to_degrees() * 10.0).floor() / 10.0)),
        Change::Span(m) => format!("--span {}mm", text::digits(m * 1e3)),
        Change::Passes(passes) => format!("--pulleys {passes}"),
        Change::Bent(rad) => format!("--tube {}deg", text::digits((rad.to_degrees() * 10.0).floor() / 10.0)),
        Change::Wires(wires) => format!("--wires {wires}"),
        Change::Supply(v) => format!("--supply {}V", text::digits(v)),
        Change::Current(a) => format!("--current {}A", text::digits(a)),
        Change::MostCurrent(a) => format!("--most-current {}A", text::digits(a)),
        Change::InSeries(count) => format!("--in-series {count}"),
        Change::Life(cycles) => format!("--life {}", text::digits(cycles)),
        Change::Ambient(celsius) => format!("--ambient {celsius}"),
        Change::Joint(Joint::Pulley) => "--joint pulley".into(),
        Change::Joint(Joint::Lever) => "--joint lever".into(),
        Change::Method(Method::Energy) => "--method energy".into(),
        Change::Method(Method::Stroke) => "--method stroke".into(),
        Change::Diameter(m) => format!("--diameter {}mm", text::digits(m * 1e3)),
    };
    let sizing = &nearest.design.sizing;
    let (wires, mm) = (sizing.wires, sizing.wire.diameter_m * 1e3);
    format!("{option} ({wires} of {mm:.3} mm × {:.1} mm)", sizing.wire.length_m * 1e3)
}
