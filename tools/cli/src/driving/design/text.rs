//! What `sinew design` prints: the wires compared, and the chosen one by the rules, as predicted, and as simulated.

use std::fmt::Write as _;

use sinew_control::Limits;
use sinew_design::{
    Allowed, Design, HeldBack, Joint, Lack, Mechanism, Motion, Requirement, Route, Shortfall, Simulated, TUBE_BORE,
    TUBE_OUTER, WireRules,
};
use sinew_physics::formulas::{CycleUse, cycles_to_failure};

/// Tension over what a wire bears that is said.
const WORTH_SAYING: f64 = 0.05;

/// As few digits as say a number of two or three digits that matter.
pub(super) fn digits(value: f64) -> String {
    let places = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Four digits that matter, for a column; thousands stay whole.
fn number(value: f64) -> String {
    let places = (3 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 3) as usize;
    format!("{value:.places$}")
}

/// A number of cycles.
fn count(cycles: f64) -> String {
    if cycles < 1e6 { format!("{cycles:.0}") } else { format!("{cycles:.1e}") }
}

/// One line a diameter.
pub(super) fn table(all: &[Design], chosen: &Design) -> String {
    let [mm, v, a, usd, heat, cool, w] = ["mm", "V", "A", "$", "heat", "cool", "W"];
    let mut text = format!(
        "{:>21} {:>6} {:>13} {:>5} {:>12} {:>18}\n\
         {mm:>8} {:>5} {mm:>6} {:>6} {v:>6} {a:>6} {usd:>5} {heat:>5} {cool:>6} {heat:>5} {cool:>6} {w:>5}\n",
        "wires", "", "source", "cost", "by rules", "predicted", "wires", "in row"
    );
    for design in all {
        let mark = if chosen == design { '*' } else { ' ' };
        let s = &design.sizing;
        let said = match (&design.shortfall, &design.prediction) {
            (None, Some(said)) => format!(
                "{:5.2} {:6.2} {}",
                said.cycle.heating_s,
                said.cycle.cooling_s,
                column(design.power_w().unwrap_or(f64::NAN), 5)
            ),
            (Some(why), _) => brief(why),
            (None, None) => String::new(),
        };
        let _ = writeln!(
            text,
            "{mark} {:6.3} {:5} {:6.1} {:6} {} {} {} {:5.2} {:6.2} {said}",
            s.wire.diameter_m * 1e3,
            s.wires,
            s.wire.length_m * 1e3,
            s.path.in_series,
            column(s.supply_v, 6),
            column(s.source_a(), 6),
            column(s.cost_usd(), 5),
            s.heating_s(),
            s.cooling_s(),
        );
    }
    text
}

/// As many digits as a column of this width takes.
fn column(value: f64, width: usize) -> String {
    let whole = value.abs().max(1.0).log10().floor() as usize + 1;
    let places = width.saturating_sub(whole + 1).min(3);
    format!("{value:width$.places$}")
}

/// Why a wire will not do, in a column.
fn brief(why: &Shortfall) -> String {
    match why {
        Shortfall::Lack(Lack::Pull(has)) => format!("pulls {}", digits(*has)),
        Shortfall::Lack(Lack::Strain(has_m)) => format!("strains {} mm", digits(has_m * 1e3)),
        Shortfall::Lack(Lack::Radius(m)) => format!("bends to {} mm", digits(m * 1e3)),
        Shortfall::Lack(Lack::Angle(rad)) => format!("turns {} deg", digits(rad.to_degrees())),
        Shortfall::Lack(Lack::Friction(_)) => "does not move".into(),
        Shortfall::TooSlow(cycle_s) => format!("too slow: {} s", digits(*cycle_s)),
        Shortfall::WeakSupply(volts) => format!("needs {} V", digits(*volts)),
        Shortfall::WeakCurrent(amps) => format!("needs {} A", digits(*amps)),
        Shortfall::TooMuchCurrent(amps) => format!("draws {} A", digits(*amps)),
        Shortfall::LowCompliance(volts) => format!("needs {} V", digits(*volts)),
        Shortfall::HeldBack(HeldBack::Heat) => "held back: heat".into(),
        Shortfall::HeldBack(HeldBack::Temperature) => "held back: hot".into(),
        Shortfall::StaysWarm => "stays warm".into(),
        Shortfall::TooShort(_) => "too short".into(),
        Shortfall::Refused(_) => "not driven".into(),
    }
}

/// Why a wire will not do, as a sentence's end that begins with the limit.
pub(super) fn shortfall(requirement: &Requirement, design: &Design, why: &Shortfall) -> String {
    let linear = matches!(requirement.motion, Motion::Linear { .. });
    match why {
        Shortfall::Lack(Lack::Pull(has)) if linear => {
            format!(
                "they pull {} N beyond what stretches them again, at the {} that a wire bears",
                digits(*has),
                bears(design)
            )
        }
        Shortfall::Lack(Lack::Pull(has)) => {
            format!(
                "they turn {} mNm beyond what stretches them again, at the {} that a wire bears",
                digits(has * 1e3),
                bears(design)
            )
        }
        Shortfall::Lack(Lack::Strain(has_m)) => format!(
            "a wire contracts by {} %, which is {} mm of the room there is, and --method stroke allows no lever",
            digits(100.0 * design.sizing.wire.allowed.strain),
            digits(has_m * 1e3)
        ),
        Shortfall::Lack(Lack::Radius(radius_m)) => format!(
            "the wire turns the joint that far on a pulley of {} mm radius only, and bears being bent to {} mm (eq. 5)",
            digits(design.sizing.radius_m.unwrap_or(f64::NAN) * 1e3),
            digits(radius_m * 1e3)
        ),
        Shortfall::Lack(Lack::Angle(rad)) => {
            format!(
                "a lever turns {} degrees at the most: beyond that the wire hardly has an arm",
                digits(rad.to_degrees())
            )
        }
        Shortfall::Lack(Lack::Friction(most)) => format!(
            "friction leaves nothing of its pull when it has stretched the wire again: {} at the most",
            match requirement.route {
                Route::Pulleys(_) => format!("{most:.0} passes over pulleys"),
                _ => format!("a tube may be bent by {} degrees", digits(most.to_degrees())),
            }
        ),
        Shortfall::TooSlow(cycle_s) => format!("there and back takes {} s", digits(*cycle_s)),
        Shortfall::WeakSupply(volts) => {
            format!(
                "the air takes all that {} V give before it is hot enough; it takes more than {} V",
                digits(design.sizing.supply_v),
                digits(*volts)
            )
        }
        Shortfall::WeakCurrent(amps) => {
            format!(
                "the air takes all that this current gives before it is hot enough; it takes more than {} A",
                digits(*amps)
            )
        }
        Shortfall::TooMuchCurrent(amps) => format!("all wires on draw {} A", digits(*amps)),
        Shortfall::LowCompliance(volts) => format!("that current through its wires takes {} V", digits(*volts)),
        Shortfall::HeldBack(HeldBack::Heat) => {
            "moving on and on, it takes in more heat than the driver's supervisor allows".into()
        }
        Shortfall::HeldBack(HeldBack::Temperature) => "it gets hotter than the driver's supervisor allows".into(),
        Shortfall::StaysWarm => {
            "the air is too warm, or its sensing pulse too strong, for it to be stretched again".into()
        }
        Shortfall::TooShort(has) if linear => format!("its whole stroke is {} mm", digits(has * 1e3)),
        Shortfall::TooShort(_) => "its whole stroke leaves no end beyond the one asked for".into(),
        Shortfall::Refused(words) => format!("the driver does not take it: {words}"),
    }
}

/// The stress a wire bears for as long as it is to last.
fn bears(design: &Design) -> String {
    format!("{} MPa", digits(design.sizing.wire.allowed.stress_pa / 1e6))
}

/// What to build.
fn build(requirement: &Requirement, design: &Design) -> String {
    let mut text = String::new();
    let s = &design.sizing;
    let mm = |m: f64| m * 1e3;
    let plural = if s.wires == 1 { "wire" } else { "wires side by side" };
    let _ = writeln!(
        text,
        "take {} {plural} of {:.3} mm × {:.1} mm ({} US$ by eq. 13)",
        s.wires,
        mm(s.wire.diameter_m),
        mm(s.wire.length_m),
        digits(s.cost_usd())
    );
    match (s.joint, s.radius_m) {
        (Some(Joint::Pulley), Some(radius_m)) => {
            let _ = writeln!(text, "  on a pulley of {:.2} mm radius", mm(radius_m));
        }
        (Some(Joint::Lever), Some(radius_m)) => {
            let _ =
                writeln!(text, "  on a lever of {:.2} mm, square to the wire in the middle of its way", mm(radius_m));
        }
        _ if (s.lever - 1.0).abs() > 1e-9 => {
            let _ = writeln!(text, "  with a lever that moves the load {:.2} times as far", s.lever);
        }
        _ => {}
    }
    if s.wires > 1 {
        let rows = match (s.path.in_series, s.path.rows) {
            (1, _) => "all in parallel".into(),
            (_, 1) => "a zig-zag through all of them".to_string(),
            (in_series, rows) => format!("{rows} rows in parallel, each a zig-zag through {in_series}"),
        };
        let ends = match s.path.in_series {
            1 => "",
            _ if s.path.ends_where_it_began() => ", both contacts at one end",
            _ => ", one contact at each end",
        };
        let _ = writeln!(
            text,
            "  the current: {rows}{ends};\n  {:.1} mm and {} ohm from contact to contact",
            mm(s.path.length_m(&s.wire)),
            digits(s.path.resistance_ohm(&s.wire))
        );
    }
    let _ = writeln!(
        text,
        "  heated with {} V and {} A, {} V a wire{}",
        digits(s.supply_v),
        digits(s.source_a()),
        digits(s.wire_v()),
        match design.duty < 1.0 {
            true =>
                format!(",\n  at a duty of {:.0} %: with more the wire is faster than its load", 100.0 * design.duty),
            false => String::new(),
        }
    );
    match s.route {
        Route::Straight => {}
        Route::Pulleys(passes) => {
            let _ = writeln!(text, "  each {passes} times through the room, around {} pulleys", passes - 1);
        }
        Route::Tube { bent_rad, friction } => {
            let _ = writeln!(
                text,
                "  each through a tube that is bent by {:.0} degrees (friction {friction}); bore {:.2} mm,\n  \
                 {:.2} mm outside: loses {:.1} times the heat of a bare wire",
                bent_rad.to_degrees(),
                TUBE_BORE * mm(s.wire.diameter_m),
                TUBE_OUTER * mm(s.wire.diameter_m),
                s.route.cooling_gain(s.wire.diameter_m)
            );
        }
    }
    let _ = writeln!(
        text,
        "  each pulls {:.2} N, needs {:.2} N to be stretched again, and bears {:.2} N",
        s.useful_n,
        s.route.preload_n(&s.wire),
        s.wire.max_force_n()
    );
    let _ = writeln!(
        text,
        "  bears {:.3} A for good (duty {:.0} %); bend it no tighter than {:.1} mm",
        s.wire.safe_current_a(),
        s.safe_duty() * 100.0,
        mm(s.wire.bend_radius_m())
    );
    if let Some(lasts_s) = requirement.source.charge_c.and_then(|charge_c| design.lasts_s(charge_c)) {
        let cycles = design.prediction.map_or(f64::NAN, |said| lasts_s / said.cycle.cycle_s());
        let _ = writeln!(
            text,
            "  the battery lasts {} h of motion without a pause, {:.0} times there and back",
            digits(lasts_s / 3600.0),
            cycles
        );
    }
    text
}

/// What to build, and what it will do by the rules, as predicted, and as simulated.
pub(super) fn answer(requirement: &Requirement, design: &Design, simulated: &Simulated, reach: Limits) -> String {
    let mut text = build(requirement, design);
    if let Some(cycles) = requirement.life_cycles {
        let Allowed { stress_pa, strain } = design.sizing.wire.allowed;
        let life = cycles_to_failure(&CycleUse { peak_stress_pa: stress_pa, strain, ..CycleUse::TABLE });
        let _ = writeln!(
            text,
            "  for a life of {} cycles: at most {} and {} % of strain (docs/life.md: most such wires\n  last {:.1e} to {:.1e} of them)",
            count(cycles),
            bears(design),
            digits(100.0 * strain),
            life.least,
            life.most
        );
    }
    let Some(said) = &design.prediction else { return text };
    let (s, cycle) = (&design.sizing, simulated.cycle.as_ref());
    let wires = f64::from(s.wires);
    text.push_str("\n                                       rules   predicted   simulated\n");
    let mut row = |name: &str, rule: Option<f64>, predicted: Option<f64>, simulated: Option<f64>| {
        let shown = |value: Option<f64>| value.map_or_else(String::new, number);
        let line = format!("{name:32} {:>11} {:>11} {:>11}", shown(rule), shown(predicted), shown(simulated));
        let _ = writeln!(text, "{}", line.trim_end());
    };
    row(
        "whole stroke of the wire, mm",
        Some(s.wire.stroke_m() * 1e3),
        Some(said.stroke_m * 1e3),
        Some(simulated.stroke_m * 1e3),
    );
    row("most tension, N", Some(s.tension_n()), Some(said.cycle.pull_n), cycle.map(|c| c.pull_n));
    row("heating, s", Some(s.heating_s()), Some(said.cycle.heating_s), cycle.map(|c| c.heating_s));
    row("cooling, s", Some(s.cooling_s()), Some(said.cycle.cooling_s), cycle.map(|c| c.cooling_s));
    row("there and back, s", Some(s.cycle_s()), Some(said.cycle.cycle_s()), cycle.map(|c| c.cycle_s()));
    row("the first time, from cold, s", None, Some(said.cycle.first_s), cycle.map(|c| c.first_s));
    row("hottest, °C", None, Some(said.cycle.hottest_c), cycle.map(|c| c.hottest_c));
    row("at the current it bears, °C", None, Some(said.safe_current_c), None);
    row("power without a pause, W", Some(s.power_w()), design.power_w(), cycle.map(|c| wires * c.power_w));
    row("  work over 2 % of the time, W", Some(s.least_power_w()), None, None);
    row("power to hold it, W (eq. 15)", Some(s.holding_power_w()), None, None);
    let work_j = s.useful_n * s.wire.stroke_m();
    row(
        "efficiency, %",
        Some(100.0 * s.efficiency()),
        design.efficiency().map(|share| 100.0 * share),
        cycle.map(|c| 100.0 * work_j / (c.power_w * c.cycle_s())),
    );
    row("  as printed (eq. 17), %", Some(100.0 * s.stated_efficiency()), None, None);
    let over = said.cycle.pull_n / s.wire.max_force_n() - 1.0;
    if over > WORTH_SAYING {
        let _ = writeln!(
            text,
            "\nmoving, it bears {:.0} % more than {}: take more wires for its life",
            100.0 * over,
            if requirement.life_cycles.is_some() { bears(design) } else { "eq. 2's 170 MPa".into() }
        );
    }
    let lambda = |limit: Option<f64>| limit.map_or_else(|| "none".into(), digits);
    let _ = writeln!(
        text,
        "\nλ as modelled (`sinew tune`), 1/s:\n  {} shortening, {} lengthening, {} for its load",
        lambda(reach.heating_per_s),
        lambda(reach.cooling_per_s),
        digits(reach.load_per_s)
    );
    text
}

/// What mechanisms make of a wire, one a line.
pub(super) fn mechanisms(wire: &WireRules) -> String {
    let mut text = format!(
        "\nmechanisms with wire of {:.3} mm in a room of {:.1} mm, by the rules\n\
         {:36} stroke  force    rate   wire   cost parts\n\
         {:36}     mm      N      Hz     mm      $\n",
        wire.diameter_m * 1e3,
        wire.length_m * 1e3,
        "",
        "",
    );
    for mechanism in Mechanism::ALL {
        let worth = mechanism.worth(wire);
        let _ = writeln!(
            text,
            "{:36} {} {} {} {:6.0} {} {:5}",
            mechanism.name(),
            column(worth.stroke_m * 1e3, 6),
            column(worth.force_n, 6),
            column(worth.bandwidth_hz(), 7),
            worth.wire_m * 1e3,
            column(worth.cost_usd(), 6),
            worth.parts
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_what_matters() {
        for (value, text) in [(0.0412, "0.0412"), (6.0, "6"), (12.345, "12.3"), (1234.0, "1234"), (0.5, "0.5")] {
            assert_eq!(digits(value), text);
        }
        for (value, text) in [(1234.6, "1235"), (12.345, "12.35"), (0.1234, "0.123")] {
            assert_eq!(number(value), text);
        }
        assert_eq!(
            (column(1.23456, 6), column(123.456, 6), column(12345.6, 6)),
            (" 1.235".into(), "123.46".into(), " 12346".into())
        );
    }
}
