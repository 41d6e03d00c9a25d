//! What `sinew design --json` prints.

use serde::Serialize;
use sinew_control::Limits;
use sinew_design::{Cycle, Design, HeldBack, Joint, Lack, Mechanism, Requirement, Shortfall, Simulated, Worth};

#[derive(Debug, Serialize)]
pub(super) struct Answer {
    schema: &'static str,
    cycle_s: Option<f64>,
    span_m: Option<f64>,
    ambient_c: f64,
    life_cycles: Option<f64>,
    allowed_stress_pa: f64,
    allowed_strain: f64,
    wires: Vec<Row>,
    chosen: Option<usize>,
    simulated: Motion,
    as_modelled: Rates,
    rig_file: String,
    battery_lasts_s: Option<f64>,
    mechanisms: Vec<Mechanised>,
}

/// What a mechanism makes of the chosen wire.
#[derive(Debug, Serialize)]
struct Mechanised {
    name: String,
    stroke_m: f64,
    force_n: f64,
    cycle_s: f64,
    wire_m: f64,
    cost_usd: f64,
    parts: u32,
}

#[derive(Debug, Serialize)]
struct Row {
    diameter_m: f64,
    wires: u32,
    length_m: f64,
    lever: f64,
    joint: Option<&'static str>,
    radius_m: Option<f64>,
    in_series: u32,
    rows: u32,
    path_ohm: f64,
    useful_force_n: f64,
    preload_n: f64,
    maximum_force_n: f64,
    stroke_m: f64,
    resistance_ohm: f64,
    supply_v: f64,
    wire_v: f64,
    current_a: f64,
    source_a: f64,
    safe_current_a: f64,
    safe_duty: f64,
    duty: f64,
    heating_s: f64,
    cooling_s: f64,
    power_w: f64,
    least_power_w: f64,
    holding_power_w: f64,
    efficiency: f64,
    stated_efficiency: f64,
    bend_radius_m: f64,
    cost_usd: f64,
    predicted: Option<Motion>,
    shortfall: Option<&'static str>,
    shortfall_at: Option<f64>,
}

/// What one wire does over and over, as predicted or simulated.
#[derive(Debug, Serialize)]
struct Motion {
    stroke_m: f64,
    pull_n: Option<f64>,
    heating_s: Option<f64>,
    cooling_s: Option<f64>,
    first_s: Option<f64>,
    hottest_c: Option<f64>,
    power_w: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    safe_current_c: Option<f64>,
}

/// Largest λ as modelled, 1/s.
#[derive(Debug, Serialize)]
struct Rates {
    heating_per_s: Option<f64>,
    cooling_per_s: Option<f64>,
    load_per_s: f64,
}

impl Motion {
    fn new(stroke_m: f64, cycle: Option<&Cycle>, safe_current_c: Option<f64>) -> Motion {
        Motion {
            stroke_m,
            pull_n: cycle.map(|c| c.pull_n),
            heating_s: cycle.map(|c| c.heating_s),
            cooling_s: cycle.map(|c| c.cooling_s),
            first_s: cycle.map(|c| c.first_s),
            hottest_c: cycle.map(|c| c.hottest_c),
            power_w: cycle.map(|c| c.power_w),
            safe_current_c,
        }
    }
}

/// The word for what keeps a wire from its work, and how much it has or takes, in SI.
fn shortfall(why: &Shortfall) -> (&'static str, Option<f64>) {
    match why {
        Shortfall::Lack(Lack::Pull(has)) => ("too_weak", Some(*has)),
        Shortfall::Lack(Lack::Strain(has_m)) => ("beyond_strain", Some(*has_m)),
        Shortfall::Lack(Lack::Radius(radius_m)) => ("bent_too_tight", Some(*radius_m)),
        Shortfall::Lack(Lack::Angle(rad)) => ("beyond_lever", Some(*rad)),
        Shortfall::Lack(Lack::Friction(most)) => ("friction", Some(*most)),
        Shortfall::TooSlow(cycle_s) => ("too_slow", Some(*cycle_s)),
        Shortfall::WeakSupply(volts) => ("weak_supply", Some(*volts)),
        Shortfall::WeakCurrent(amps) => ("weak_current", Some(*amps)),
        Shortfall::TooMuchCurrent(amps) => ("too_much_current", Some(*amps)),
        Shortfall::LowCompliance(volts) => ("low_compliance", Some(*volts)),
        Shortfall::HeldBack(HeldBack::Heat) => ("held_back_by_heat", None),
        Shortfall::HeldBack(HeldBack::Temperature) => ("held_back_by_temperature", None),
        Shortfall::StaysWarm => ("stays_warm", None),
        Shortfall::TooShort(has) => ("too_short", Some(*has)),
        Shortfall::Refused(_) => ("refused", None),
    }
}

fn row(design: &Design) -> Row {
    let s = &design.sizing;
    let why = design.shortfall.as_ref().map(shortfall);
    Row {
        diameter_m: s.wire.diameter_m,
        wires: s.wires,
        length_m: s.wire.length_m,
        lever: s.lever,
        joint: s.joint.map(|joint| match joint {
            Joint::Pulley => "pulley",
            Joint::Lever => "lever",
        }),
        radius_m: s.radius_m,
        in_series: s.path.in_series,
        rows: s.path.rows,
        path_ohm: s.path.resistance_ohm(&s.wire),
        useful_force_n: s.useful_n,
        preload_n: s.route.preload_n(&s.wire),
        maximum_force_n: s.wire.max_force_n(),
        stroke_m: s.wire.stroke_m(),
        resistance_ohm: s.wire.resistance_ohm(),
        supply_v: s.supply_v,
        wire_v: s.wire_v(),
        current_a: s.current_a(),
        source_a: s.source_a(),
        safe_current_a: s.wire.safe_current_a(),
        safe_duty: s.safe_duty(),
        duty: design.duty,
        heating_s: s.heating_s(),
        cooling_s: s.cooling_s(),
        power_w: s.power_w(),
        least_power_w: s.least_power_w(),
        holding_power_w: s.holding_power_w(),
        efficiency: s.efficiency(),
        stated_efficiency: s.stated_efficiency(),
        bend_radius_m: s.wire.bend_radius_m(),
        cost_usd: s.cost_usd(),
        predicted: design
            .prediction
            .as_ref()
            .map(|said| Motion::new(said.stroke_m, Some(&said.cycle), Some(said.safe_current_c))),
        shortfall: why.map(|(word, _)| word),
        shortfall_at: why.and_then(|(_, at)| at),
    }
}

fn mechanised(mechanism: &Mechanism, chosen: &Design) -> Mechanised {
    let worth = mechanism.worth(&chosen.sizing.wire);
    let Worth { stroke_m, force_n, cycle_s, wire_m, parts } = worth;
    Mechanised { name: mechanism.name(), stroke_m, force_n, cycle_s, wire_m, cost_usd: worth.cost_usd(), parts }
}

impl Answer {
    pub(super) fn new(
        asked: &Requirement,
        all: &[Design],
        chosen: &Design,
        simulated: &Simulated,
        reach: Limits,
    ) -> Answer {
        let Limits { heating_per_s, cooling_per_s, load_per_s } = reach;
        Answer {
            schema: "sinew.design/2",
            cycle_s: asked.cycle_s,
            span_m: asked.span_m,
            ambient_c: asked.ambient_c,
            life_cycles: asked.life_cycles,
            allowed_stress_pa: chosen.sizing.wire.allowed.stress_pa,
            allowed_strain: chosen.sizing.wire.allowed.strain,
            wires: all.iter().map(row).collect(),
            chosen: all.iter().position(|design| design == chosen),
            simulated: Motion::new(simulated.stroke_m, simulated.cycle.as_ref(), None),
            as_modelled: Rates { heating_per_s, cooling_per_s, load_per_s },
            rig_file: chosen.rig_text.clone(),
            mechanisms: Mechanism::ALL.iter().map(|one| mechanised(one, chosen)).collect(),
            battery_lasts_s: asked.source.charge_c.and_then(|charge_c| chosen.lasts_s(charge_c)),
        }
    }
}
