//! `sinew design`: a wire from requirements, by the thesis' rules of chapter 2, with its simulated properties.

use std::fmt::Write as _;

use serde::Serialize;
use sinew_control::{
    Candidate, Motion, Prediction, Requirement, STOCK_DIAMETERS_M, Shortfall, best, candidates, load_of, predict,
};
use sinew_physics::Load;
use sinew_rig::Rig;

use crate::args;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Austenite is finished here in the wires the rules are for, °C (Table 2).
const AUSTENITE_FINISH_C: f64 = 90.0;
/// Share of the wire's hot length that the fixed piece of the dual measurement takes.
const FIXED_PIECE: f64 = 0.94;

/// Runs the command.
pub fn design(args: &args::Design) -> Outcome {
    let motion = match (args.force_n, args.stroke_m, args.torque_n_m, args.angle_rad) {
        (Some(force_n), Some(stroke_m), ..) => Motion::Linear { force_n, stroke_m },
        (_, _, Some(torque_n_m), Some(angle_rad)) => Motion::Rotary { torque_n_m, angle_rad },
        _ => return Err(Failure::input("nothing to move").hint("give --force and --stroke, or --torque and --angle")),
    };
    let requirement =
        Requirement { motion, cycle_s: args.cycle_s, span_m: args.span_m, wires: args.wires, supply_v: args.supply_v };
    let sized = match args.diameter_m {
        Some(diameter_m) => candidates(&requirement, &[diameter_m]),
        None => candidates(&requirement, &STOCK_DIAMETERS_M),
    };
    let Some(chosen) = best(&sized) else {
        return Err(Failure::input("no wire does all of that").hint(remedy(&requirement, &sized)));
    };
    let rig_text = rig_file(&requirement, chosen);
    let rig = Rig::parse(&rig_text, "the designed rig").map_err(|error| {
        Failure::input(format!("such a wire is beyond what a rig file takes: {error}"))
            .hint("change what is asked for, or --diameter")
    })?;
    let said = predict(&rig.nominal_model(0)).map_err(Failure::own)?;
    if args.json {
        return output::print_json(&Answer::new(&requirement, &sized, chosen, &said));
    }
    let text = format!("{}\n{}", table(&sized, chosen), answer(&requirement, chosen, &said));
    match &args.output {
        Some(path) => {
            output::write_file(path, &rig_text)?;
            output::note(text);
            output::note(format_args!("written: {} (see `sinew tune` for its bandwidth)", path.display()));
            Ok(())
        }
        None => output::print(text),
    }
}

/// What would help: the demand that most of the wires fail.
fn remedy(requirement: &Requirement, sized: &[Candidate]) -> String {
    let fastest = sized.iter().map(Candidate::cycle_s).fold(f64::INFINITY, f64::min);
    let count =
        |which: fn(&Shortfall) -> bool| sized.iter().filter(|c| c.shortfall.as_ref().is_some_and(which)).count();
    let slow = count(|s| matches!(s, Shortfall::TooSlow { .. }));
    let weak = count(|s| matches!(s, Shortfall::TooWeak { .. }));
    let supply = count(|s| matches!(s, Shortfall::WeakSupply { .. }));
    if supply > 0 && supply >= slow && supply >= weak {
        return "a higher --supply, or a shorter wire by --span (which costs force)".into();
    }
    match requirement.cycle_s {
        Some(_) if slow >= weak => {
            format!(
                "the fastest of them takes {fastest:.2} s there and back: a longer --cycle, a higher --supply, or moving air"
            )
        }
        _ => "more --wires, a thicker --diameter, or less force".into(),
    }
}

/// One line a diameter.
fn table(sized: &[Candidate], chosen: &Candidate) -> String {
    let mut text = String::from(
        "   diameter  wires   length  resistance   supply  current   heats   cools   power\n         mm              mm         ohm        V        A       s       s       W\n",
    );
    for c in sized {
        let mark = if chosen == c { '*' } else { ' ' };
        let why = match c.shortfall {
            None => String::new(),
            Some(Shortfall::TooSlow { cycle_s }) => format!("  too slow: {cycle_s:.2} s"),
            Some(Shortfall::TooWeak { force_n }) => format!("  too weak: {force_n:.2} N"),
            Some(Shortfall::WeakSupply { needed_v }) => format!("  supply below {needed_v:.1} V"),
        };
        let _ = writeln!(
            text,
            " {mark} {:8.3} {:6} {:8.1} {:11.2} {:8.2} {:8.3} {:7.2} {:7.2} {:7.2}{why}",
            c.wire.diameter_m * 1e3,
            c.wires,
            c.wire.length_m * 1e3,
            c.wire.resistance_ohm(),
            c.supply_v,
            c.current_a(),
            c.heating_s,
            c.cooling_s,
            c.power_w(),
        );
    }
    text
}

/// What to build, what its limits are, and what the physics says of it.
fn answer(requirement: &Requirement, c: &Candidate, said: &Prediction) -> String {
    let mut text = String::new();
    let mm = |m: f64| m * 1e3;
    let plural = if c.wires == 1 { "wire" } else { "wires side by side" };
    let _ =
        writeln!(text, "take {} {plural} of {:.3} mm × {:.1} mm", c.wires, mm(c.wire.diameter_m), mm(c.wire.length_m));
    match (requirement.motion, c.radius_m) {
        (Motion::Rotary { .. }, Some(radius)) => {
            let _ = writeln!(text, "  on a pulley or lever of {:.2} mm radius", mm(radius));
            if radius < c.wire.bend_radius_m() {
                let _ = writeln!(
                    text,
                    "  which is too tight to wind the wire around (eq. 5: {:.2} mm): clamp it to a lever",
                    mm(c.wire.bend_radius_m())
                );
            }
        }
        _ if c.lever > 1.0 + 1e-9 => {
            let _ = writeln!(text, "  with a lever that moves the load {:.2} times as far", c.lever);
        }
        _ => {}
    }
    let _ = writeln!(
        text,
        "  each pulls {:.2} N on the load and needs {:.2} N to be stretched again (at most {:.2} N in all)",
        c.useful_n,
        c.wire.preload_n(),
        c.wire.max_force_n()
    );
    let _ = writeln!(
        text,
        "  bears {:.3} A for good (duty {:.0} % of this supply); bend it no tighter than {:.1} mm",
        c.wire.safe_current_a(),
        c.safe_duty() * 100.0,
        mm(c.wire.bend_radius_m())
    );
    let _ = writeln!(
        text,
        "  moving without a pause takes {:.2} W in all, holding it hot {:.2} W a wire in still air; efficiency {:.2} %",
        c.power_w(),
        c.wire.holding_power_w(AUSTENITE_FINISH_C),
        c.efficiency() * 100.0
    );
    let seconds = |s: Option<f64>| s.map_or_else(|| "does not get there".to_string(), |s| format!("{s:.2} s"));
    let _ = writeln!(text, "simulated, one wire lifting {:.2} N:", c.wire.preload_n() + c.useful_n);
    let _ = writeln!(
        text,
        "  stroke {:.2} mm (rule: {:.2}); 10 to 90 % of it: heating {} (rule: {:.2}), cooling {} (rule: {:.2})",
        mm(said.stroke_m),
        mm(c.wire.stroke_m()),
        seconds(said.heating_s),
        c.heating_s,
        seconds(said.cooling_s),
        c.cooling_s
    );
    let _ = writeln!(text, "  at the current it bears for good it settles at {:.0} °C", said.safe_current_c);
    text
}

/// One such wire on the bench.
fn rig_file(requirement: &Requirement, c: &Candidate) -> String {
    let asked = match requirement.motion {
        Motion::Linear { force_n, stroke_m } => format!("{force_n} N over {} mm", fixed(stroke_m * 1e3)),
        Motion::Rotary { torque_n_m, angle_rad } => {
            format!("{} mNm over {} degrees", fixed(torque_n_m * 1e3), fixed(angle_rad.to_degrees()))
        }
    };
    let Load::SpringMassDamper { mass_kg, damping_n_s_per_m, preload_n, .. } = load_of(c) else { return String::new() };
    let length_mm = c.wire.length_m * 1e3;
    format!(
        "# One of {} for {asked}, by the thesis' rules of chapter 2.\n\
         [rig]\nname = \"designed\"\nrate_hz = 1000.0\nambient_c = 25.0\n\n\
         [[channel]]\nname = \"wire\"\n\
         wire = {{ diameter_mm = {}, length_mm = {} }}\n\
         # the fixed piece of the dual measurement; the sliding tap has the rest to travel\n\
         taps = {{ l0_mm = 0.0, ls_mm = {} }}\n\
         drive = {{ supply_v = {}, shunt_ohm = 0.1, switch_ohm = 0.02 }}\n\
         # what the wire works against: the pull that stretches it again and its share of the load\n\
         load = {{ mass_kg = {}, damping_n_s_per_m = {}, preload_n = {} }}\n\
         # what it bears for good (eq. 8)\n\
         limits = {{ maximum_power_w = {} }}\n",
        c.wires,
        fixed(c.wire.diameter_m * 1e3),
        fixed(length_mm),
        fixed(length_mm * FIXED_PIECE),
        fixed(c.supply_v),
        fixed(mass_kg),
        fixed(damping_n_s_per_m),
        fixed(preload_n),
        fixed(c.wire.safe_current_a().powi(2) * c.wire.resistance_ohm()),
    )
}

/// Four digits that matter, with a decimal point.
fn fixed(value: f64) -> String {
    let digits = (3 - value.abs().log10().floor() as i32).clamp(1, 9) as usize;
    let text = format!("{value:.digits$}");
    let short = text.trim_end_matches('0');
    if short.ends_with('.') { format!("{short}0") } else { short.to_string() }
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Answer {
    schema: &'static str,
    cycle_s: Option<f64>,
    span_m: Option<f64>,
    wires: Vec<Row>,
    chosen: Option<usize>,
    simulated: Simulated,
}

#[derive(Debug, Serialize)]
struct Row {
    diameter_m: f64,
    wires: u32,
    length_m: f64,
    lever: f64,
    radius_m: Option<f64>,
    useful_force_n: f64,
    preload_n: f64,
    maximum_force_n: f64,
    stroke_m: f64,
    resistance_ohm: f64,
    supply_v: f64,
    current_a: f64,
    safe_current_a: f64,
    safe_duty: f64,
    heating_s: f64,
    cooling_s: f64,
    power_w: f64,
    efficiency: f64,
    bend_radius_m: f64,
    shortfall: Option<&'static str>,
}

#[derive(Debug, Serialize)]
struct Simulated {
    stroke_m: f64,
    heating_s: Option<f64>,
    cooling_s: Option<f64>,
    safe_current_c: f64,
}

impl Answer {
    fn new(asked: &Requirement, sized: &[Candidate], chosen: &Candidate, said: &Prediction) -> Answer {
        let row = |c: &Candidate| Row {
            diameter_m: c.wire.diameter_m,
            wires: c.wires,
            length_m: c.wire.length_m,
            lever: c.lever,
            radius_m: c.radius_m,
            useful_force_n: c.useful_n,
            preload_n: c.wire.preload_n(),
            maximum_force_n: c.wire.max_force_n(),
            stroke_m: c.wire.stroke_m(),
            resistance_ohm: c.wire.resistance_ohm(),
            supply_v: c.supply_v,
            current_a: c.current_a(),
            safe_current_a: c.wire.safe_current_a(),
            safe_duty: c.safe_duty(),
            heating_s: c.heating_s,
            cooling_s: c.cooling_s,
            power_w: c.power_w(),
            efficiency: c.efficiency(),
            bend_radius_m: c.wire.bend_radius_m(),
            shortfall: c.shortfall.map(|s| match s {
                Shortfall::TooSlow { .. } => "too_slow",
                Shortfall::TooWeak { .. } => "too_weak",
                Shortfall::WeakSupply { .. } => "weak_supply",
            }),
        };
        Answer {
            schema: "sinew.design/1",
            cycle_s: asked.cycle_s,
            span_m: asked.span_m,
            wires: sized.iter().map(row).collect(),
            chosen: sized.iter().position(|s| s == chosen),
            simulated: Simulated {
                stroke_m: said.stroke_m,
                heating_s: said.heating_s,
                cooling_s: said.cooling_s,
                safe_current_c: said.safe_current_c,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_control::WireRules;

    /// Whatever is chosen makes a rig file that reads well and says the same wire.
    #[test]
    fn what_is_chosen_makes_a_rig_file() {
        for (force_n, stroke_m, cycle_s) in [(0.05, 2e-3, 1.0), (2.0, 6e-3, 3.0), (30.0, 12e-3, 20.0)] {
            let motion = Motion::Linear { force_n, stroke_m };
            let asked = Requirement { motion, cycle_s: Some(cycle_s), span_m: None, wires: None, supply_v: None };
            let sized = candidates(&asked, &STOCK_DIAMETERS_M);
            let chosen = best(&sized).unwrap();
            let rig = Rig::parse(&rig_file(&asked, chosen), "designed").unwrap_or_else(|e| panic!("{e}"));
            let WireRules { diameter_m, length_m } = chosen.wire;
            let model = rig.nominal_model(0);
            assert!((model.geometry.diameter_m / diameter_m - 1.0).abs() < 1e-3);
            assert!((model.geometry.length_m / length_m - 1.0).abs() < 1e-3);
            let said = predict(&model).unwrap();
            assert!(answer(&asked, chosen, &said).contains("simulated"), "{said:?}");
        }
    }

    #[test]
    fn numbers_are_short_and_toml() {
        for (value, text) in
            [(6.0, "6.0"), (0.125, "0.125"), (158.04999, "158.0"), (0.00012347, "0.0001235"), (1234.56, "1234.6")]
        {
            assert_eq!(fixed(value), text);
        }
    }
}
