//! Chapter 6: heat and heating circuits.

use sinew_control::{Coupling, LpvModel, OperatingPoint};
use sinew_design::WireRules;
use sinew_physics::formulas::{cooling_time_s, current_a, heating_power_w, relaxed, resistance_ohm};
use sinew_physics::{Convection, Drive, DriveKind, Geometry, Inputs, Kinetics, Load, Material, Wire, WireModel};
use sinew_plot::Ink;

use super::{amplifier, segments};
use crate::axes::{STRAIN, STRESS, TEMPERATURE, TIME};
use crate::chapter::Chapter::Six;
use crate::chapter::Place::{Displayed, Equation, Figure};
use crate::found::{Found, Tried};
use crate::row::Row;
use crate::wires::{BY_POWER, STEP_S, Way, by, hanging, largest, least, stretched};

const THERMAL: &str = "model/physics/src/formulas/thermal.rs";
const ELECTRICAL: &str = "model/physics/src/formulas/electrical.rs";
const BALANCE: &str = "model/physics/src/step/balance.rs";
const SIGNALS: &str = "model/physics/src/signals.rs";

/// The text's resistivity of a wire, Ω m: the mean of both phases'.
const RESISTIVITY_OHM_M: f64 = 80e-8;

fn equation(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Six, Equation(number), title, states)
}

fn displayed(nth: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Six, Displayed(nth), title, states)
}

fn figure(number: u8, title: &'static str, states: &'static str) -> Row {
    Row::new(Six, Figure(number), title, states)
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = balance();
    rows.extend(electrical());
    rows.extend(to_the_air());
    rows
}

/// A hanging wire heated with 1 W through its transformation, with its energy.
fn heated() -> Tried<(WireModel, Wire, f64)> {
    let model = hanging();
    let mut wire = Wire::new(&model)?;
    let (mut strain_work, mut before) = (0.0, (wire.stress_pa(), wire.martensite()));
    for _ in 0..4000 {
        wire.step(&Inputs { drive: 1.0, ..model.rest_inputs() }, STEP_S);
        let now = (wire.stress_pa(), wire.martensite());
        strain_work += 0.5 * (now.0 + before.0) * model.material.transformation_strain * (now.1 - before.1);
        before = now;
    }
    let volume = model.geometry.volume_m3();
    Ok((model, wire, strain_work * volume))
}

/// A wire that loses nothing.
fn insulated(material: Material) -> Material {
    Material { convection_w_per_m2_k: 0.0, ..material }
}

/// Heat a loop leaves in a wire (sensible, latent), and the areas ∮ A L σ ε_L dξ and ∮ A L σ dε, J.
fn insulated_loop(material: Material, ambient_c: f64, to_mpa: f64) -> Tried<([f64; 2], [f64; 2], Way)> {
    let (way, energy, model) = stretched(insulated(material), ambient_c, &[0.0, to_mpa, 0.0], 4.0)?;
    let volume = model.geometry.volume_m3();
    let areas = [way.work_pa(&way.martensite) * model.material.transformation_strain, way.work_pa(&way.strain)];
    Ok(([energy.sensible_j, energy.latent_j], areas.map(|area| volume * area), way))
}

fn draw_stretch(found: &mut Found, name: &str, ink: Ink, way: Way) {
    found.legend(ink, name);
    found.line(TIME, TEMPERATURE, ink, (way.time_s, way.temperature_c));
    found.line(STRAIN, STRESS, ink, (way.strain, way.stress_mpa));
}

fn balance() -> Vec<Row> {
    vec![
        equation(
            27,
            "the heat balance",
            "Sensible and latent heat are what power and the work of \
            transformation bring, less what the air takes.",
        )
        .code(BALANCE, "heat (eq. 48)")
        .code(SIGNALS, "pub fn residual_j")
        .agrees(|_, found| {
            let (_, wire, _) = heated()?;
            found.nothing("what does not add up, of 4 J", "J", 1e-9, wire.energy().residual_j());
            Ok(())
        }),
        equation(
            28,
            "the heat balance by temperature and stress",
            "The phase's share by temperature acts as more thermal mass, that by \
            stress as a source.",
        )
        .code("control/src/lpv.rs", "Q: sensible and latent heat of a kelvin")
        .agrees(|_, found| {
            let model = hanging();
            let mut wire = Wire::new(&model)?;
            let mut before = (wire.temperature_c(), wire.martensite(), wire.stress_pa());
            while wire.martensite() > 0.5 && wire.temperature_c() < 140.0 {
                before = (wire.temperature_c(), wire.martensite(), wire.stress_pa());
                wire.step(&Inputs { drive: 1.0, ..model.rest_inputs() }, STEP_S);
            }
            let m = &model.material;
            let (rate, xi_rate) = ((wire.temperature_c() - before.0) / STEP_S, (wire.martensite() - before.1) / STEP_S);
            let at = OperatingPoint {
                temperature_c: wire.temperature_c(),
                martensite: wire.martensite(),
                stress_pa: wire.stress_pa(),
                heating: true,
            };
            let slope = LpvModel::new(&model, Coupling::Full)?.slope_per_k(&at);
            let by_stress = -m.stress_shift_k_per_pa * slope * (wire.stress_pa() - before.2) / STEP_S;
            let work = model.geometry.volume_m3() * wire.stress_pa() * m.transformation_strain * xi_rate;
            let loss = model.constant_loss_w_per_k() * (wire.temperature_c() - model.ambient_c);
            let mass = model.heat_capacity_j_per_k() - model.latent_heat_j() * slope;
            let stated = (1.0 + work + model.latent_heat_j() * by_stress - loss) / mass;
            found.near("Ṫ half way through the transformation", "K/s", stated, 0.02 * stated.abs(), rate);
            Ok(())
        }),
        displayed(1, "sensible heat", "m c_p Ṫ; table 6's wire weighs 12.6 mg.")
            .code(THERMAL, "pub fn heat_capacity_j_per_k")
            .agrees(|_, found| {
                let model = hanging();
                found.near("mass of table 6's wire", "mg", 12.6, 0.1, model.geometry.mass_kg(&model.material) * 1e6);
                found.near(
                    "m c_p over m",
                    "J/(kg K)",
                    836.0,
                    1e-9,
                    model.heat_capacity_j_per_k() / model.geometry.mass_kg(&model.material),
                );
                Ok(())
            }),
        displayed(
            2,
            "latent heat",
            "−m ΔH ξ̇: martensite that forms gives heat, by temperature or by \
            stress.",
        )
        .code(THERMAL, "pub fn latent_heat_j")
        .agrees(|_, found| {
            let (model, wire, _) = heated()?;
            let mass = model.geometry.mass_kg(&model.material);
            let stated = mass * 24_200.0 * (1.0 - wire.martensite());
            found.near("heat taken up by a wire that became austenite", "J", stated, 1e-6, wire.energy().latent_j);
            Ok(())
        }),
        displayed(3, "heat to the air", "−h A_s (T − T_∞).").code(THERMAL, "pub fn loss_w_per_k").agrees(|_, found| {
            let stated = 121.2 * std::f64::consts::PI * 0.125e-3 * 0.16 * 60.0;
            found.near("loss at 60 K over the air", "W", stated, 1e-12, hanging().loss_w_per_k(60.0) * 60.0);
            Ok(())
        }),
        displayed(4, "work of transformation", "A L σ ε_L ξ̇, as pressure times change of volume.")
            .code(SIGNALS, "pub work_j")
            .agrees(|_, found| {
                let (_, wire, work) = heated()?;
                found.near("work of a contraction", "J", -work, 1e-6 * work.abs(), wire.energy().work_j);
                Ok(())
            }),
        figure(
            57,
            "latent heat in a step of power",
            "A wire that transforms between 40 and 60 °C warms later than a \
            common mass, and to the same temperature.",
        )
        .code(BALANCE, "heat (eq. 48)")
        .agrees(latent_heat),
        equation(
            29,
            "heat kept by a loop",
            "The area of the stress-strain loop is that of σ ε_L dξ, and stays in \
            an insulated wire as m c_p (T_final − T_∞).",
        )
        .code(SIGNALS, "pub work_j")
        .code("model/physics/src/effects/thermal.rs", "`thermal.elastic_work`")
        .differs(
            "the area under σ dε also has what the change of stiffness with the \
                    phase and thermal strain add, which eq. 27 has no heat for; with \
                    equal moduli and without thermal strain the areas are one and the \
                    heat is theirs, and ∮ A L σ ε_L dξ is in any case. \
                    `thermal.elastic_work` gives the wire the elastic part",
            |_, found| {
                let bounded = by(Kinetics::LiangRogers);
                let ([sensible, latent], [by_phase, by_strain], _) = insulated_loop(bounded, 120.0, 900.0)?;
                found.near("∮ A L σ dε over the heat kept", "1", 1.0, 1e-6, by_strain / sensible);
                found.proof();
                found.nothing("latent heat left by a whole loop", "J", 1e-12, latent);
                found.near("∮ A L σ ε_L dξ over the heat kept", "1", 1.0, 1e-6, by_phase / sensible);
                let plain = Material {
                    martensite_modulus_pa: bounded.austenite_modulus_pa,
                    thermoelastic_pa_per_k: 0.0,
                    ..bounded
                };
                let ([sensible, _], [_, by_strain], _) = insulated_loop(plain, 120.0, 900.0)?;
                found.near("∮ A L σ dε over it, equal moduli, θ = 0", "1", 1.0, 1e-6, by_strain / sensible);
                // what is between both areas, term by term: ∮ σ d(ε − ε_L ξ)
                let ([sensible, _], [by_phase, by_strain], _) =
                    insulated_loop(Material { thermoelastic_pa_per_k: 0.0, ..bounded }, 120.0, 900.0)?;
                found.above(
                    "what stiffness alone adds, of the heat",
                    "%",
                    1.0,
                    100.0 * (by_strain - by_phase).abs() / sensible,
                );
                Ok(())
            },
        ),
        figure(
            58,
            "an insulated wire, stretched and released",
            "It warms while it is stretched, cools while it is released, and ends \
            warmer than it was, by the work of the loop.",
        )
        .code(SIGNALS, "pub work_j")
        .agrees(|_, found| {
            let ([sensible, latent], [by_phase, _], way) = insulated_loop(Material::default(), 100.0, 700.0)?;
            found.above("warmer than at first while stretched", "K", 10.0, largest(&way.temperature_c) - 100.0);
            found.above("warmer than at first at the end", "K", 0.5, way.ends_at_c() - 100.0);
            found.near(
                "heat kept, sensible and latent, over ∮ A L σ ε_L dξ",
                "1",
                1.0,
                1e-6,
                (sensible + latent) / by_phase,
            );
            draw_stretch(found, "insulated", Ink::Series(0), way);
            Ok(())
        }),
        figure(
            59,
            "a wire in air of 100 °C, stretched and released",
            "The air evens it out; released, it cools below the air.",
        )
        .code(THERMAL, "pub fn loss_w_per_k")
        .agrees(|_, found| {
            // the tail of the transformation goes on for half a minute
            let legs = [0.0, 700.0, 700.0, 700.0, 700.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let (way, _, _) = stretched(Material::default(), 100.0, &legs, 3.0)?;
            found.above("warmest over the air", "K", 5.0, largest(&way.temperature_c) - 100.0);
            found.below("coldest, released", "K", -5.0, least(&way.temperature_c) - 100.0);
            found.nothing("off the air at the end", "K", 0.5, way.ends_at_c() - 100.0);
            let (insulated, _, _) = stretched(insulated(Material::default()), 100.0, &legs, 3.0)?;
            draw_stretch(found, "in air", Ink::Series(0), way);
            draw_stretch(found, "insulated", Ink::Series(1), insulated);
            Ok(())
        }),
    ]
}

fn latent_heat(_: &crate::lab::Lab, found: &mut Found) -> crate::row::Computed {
    let material = Material {
        austenite_temperature_c: 50.0,
        martensite_temperature_c: 40.0,
        heating_steepness_per_k: 9.21 / 20.0,
        cooling_steepness_per_k: 9.21 / 20.0,
        stress_shift_k_per_pa: 0.0,
        ..Material::default()
    };
    let power_w = 0.5;
    let run = |latent: f64| -> Tried<(Vec<f64>, Vec<f64>)> {
        // a common mass takes no work of transformation either
        let transformation_strain = if latent > 0.0 { material.transformation_strain } else { 0.0 };
        let material = Material { latent_heat_j_per_kg: latent, transformation_strain, ..material };
        let model = WireModel { material, ambient_c: 20.0, ..hanging() };
        let mut wire = Wire::new(&model)?;
        let mut way = (Vec::new(), Vec::new());
        for k in 0..15_000 {
            way.0.push(f64::from(k) * STEP_S);
            way.1.push(wire.temperature_c());
            wire.step(&Inputs { drive: power_w, ..model.rest_inputs() }, STEP_S);
        }
        Ok(way)
    };
    let (with, without) = (run(24_200.0)?, run(0.0)?);
    let end_c = 20.0 + power_w / hanging().loss_w_per_k(60.0);
    let reaches =
        |way: &(Vec<f64>, Vec<f64>), c: f64| way.1.iter().position(|t| *t > c).map_or(f64::NAN, |i| i as f64 * STEP_S);
    let model = hanging();
    let constants =
        reaches(&without, relaxed(20.0, end_c, 1.0)) * model.loss_w_per_k(60.0) / model.heat_capacity_j_per_k();
    found.near("common mass: 63 % of the way after, in time constants", "1", 1.0, 0.02, constants);
    found.near("both end at", "°C", end_c, 0.1, with.1[14_999]);
    found.near("both end at", "°C", end_c, 0.1, without.1[14_999]);
    let later = hanging().latent_heat_j() / (power_w - hanging().loss_w_per_k(60.0) * 30.0);
    found.near(
        "the wire reaches 62 °C later by",
        "s",
        later,
        0.25 * later,
        reaches(&with, 62.0) - reaches(&without, 62.0),
    );
    found.legend(Ink::Series(0), "common mass");
    found.legend(Ink::Series(1), "with phase change");
    found.line(TIME, TEMPERATURE, Ink::Series(0), without);
    found.line(TIME, TEMPERATURE, Ink::Series(1), with);
    Ok(())
}

/// The alloy with one resistivity at every phase and temperature, and no latent heat.
fn plain() -> Material {
    Material {
        austenite_resistivity_ohm_m: RESISTIVITY_OHM_M,
        martensite_resistivity_ohm_m: RESISTIVITY_OHM_M,
        austenite_resistivity_slope_ohm_m_per_k: 0.0,
        martensite_resistivity_slope_ohm_m_per_k: 0.0,
        latent_heat_j_per_kg: 0.0,
        transformation_strain: 0.0,
        convection_w_per_m2_k: 0.0,
        ..Material::default()
    }
}

/// How fast an insulated wire warms by a source, in K/s, simulated: next to no length or stress changes its resistance.
fn warming(drive: Drive, input: f64, geometry: Geometry) -> Tried<f64> {
    let model = WireModel { geometry, material: plain(), drive, load: Load::ImposedForce, ..hanging() };
    let mut wire = Wire::new(&model)?;
    let start = wire.temperature_c();
    wire.step(&Inputs { drive: input, ..model.rest_inputs() }, STEP_S);
    Ok((wire.temperature_c() - start) / STEP_S)
}

const SOURCE: Drive = Drive { kind: DriveKind::Pwm, supply_v: 6.0, ..BY_POWER };
const REGULATED: Drive = Drive { kind: DriveKind::Current, ..SOURCE };

fn wire(diameter_m: f64, length_m: f64) -> Geometry {
    Geometry { diameter_m, length_m }
}

fn electrical() -> Vec<Row> {
    vec![
        equation(30, "resistance of a wire", "R = ρ L/A = 4 ρ L/(π D²), with 80 µΩ cm on average of both phases.")
            .code(ELECTRICAL, "pub fn resistance_ohm")
            .agrees(|_, found| {
                let g = wire(0.125e-3, 0.16);
                let stated = 4.0 * RESISTIVITY_OHM_M * 0.16 / (std::f64::consts::PI * 0.125e-3f64.powi(2));
                found.near(
                    "0.125 mm × 160 mm",
                    "Ω",
                    stated,
                    1e-9,
                    resistance_ohm(RESISTIVITY_OHM_M, g.length_m, g.area_m2()),
                );
                found.near(
                    "mean resistivity of the nomenclature",
                    "µΩ cm",
                    80.0,
                    1.0,
                    Material::default().mean_resistivity() * 1e8,
                );
                Ok(())
            }),
        displayed(5, "electrical power", "P = I² R = V²/R = V I.").code(ELECTRICAL, "pub fn heating_power_w").agrees(
            |_, found| {
                let i = current_a(6.0, 10.0, 0.0);
                found.equal("I² R at 6 V and 10 Ω", "W", 36.0 / 10.0, heating_power_w(1.0, i, 10.0));
                found.equal("I² R over V I", "1", 1.0, heating_power_w(1.0, i, 10.0) / (6.0 * i));
                Ok(())
            },
        ),
        equation(31, "what a voltage does to an insulated wire", "V² π D²/(4 ρ L) goes into δ π D² L/4 · C Ṫ.")
            .code("model/physics/src/step/wire.rs", "pub fn step")
            .agrees(|_, found| {
                let g = wire(0.125e-3, 0.16);
                let power = 36.0 / g.resistance_ohm(RESISTIVITY_OHM_M);
                found.near(
                    "Ṫ at 6 V, simulated",
                    "K/s",
                    power / g.heat_capacity_j_per_k(&plain()),
                    0.2,
                    warming(SOURCE, 1.0, g)?,
                );
                Ok(())
            }),
        equation(32, "heating rate at a voltage", "Ṫ = V²/(ρ δ C L²), whatever the diameter.")
            .code("model/physics/src/step/wire.rs", "pub fn step")
            .agrees(|_, found| {
                let stated = 36.0 / (RESISTIVITY_OHM_M * 6450.0 * 836.0 * 0.16 * 0.16);
                for diameter_m in [0.05e-3, 0.125e-3, 0.5e-3] {
                    let what = format!("Ṫ of {} mm × 160 mm at 6 V", diameter_m * 1e3);
                    found.near(&what, "K/s", stated, 1e-3 * stated, warming(SOURCE, 1.0, wire(diameter_m, 0.16))?);
                }
                Ok(())
            }),
        displayed(6, "what a current does to an insulated wire", "I² 4 ρ L/(π D²) goes into δ π D² L/4 · C Ṫ.")
            .code("model/physics/src/step/wire.rs", "pub fn step")
            .agrees(|_, found| {
                let g = wire(0.125e-3, 0.16);
                let power = 0.09 * g.resistance_ohm(RESISTIVITY_OHM_M);
                let stated = power / g.heat_capacity_j_per_k(&plain());
                found.near("Ṫ at 0.3 A, simulated", "K/s", stated, 1e-3 * stated, warming(REGULATED, 0.3, g)?);
                Ok(())
            }),
        equation(33, "heating rate at a current", "Ṫ = 16 ρ I²/(π² δ C D⁴), whatever the length.")
            .code("model/physics/src/step/wire.rs", "pub fn step")
            .agrees(|_, found| {
                let d4 = 0.125e-3f64.powi(4);
                let stated = 16.0 * RESISTIVITY_OHM_M * 0.09 / (std::f64::consts::PI.powi(2) * 6450.0 * 836.0 * d4);
                for length_m in [0.05, 0.16, 0.4] {
                    let what = format!("Ṫ of 0.125 mm × {} mm at 0.3 A", length_m * 1e3);
                    found.near(&what, "K/s", stated, 1e-3 * stated, warming(REGULATED, 0.3, wire(0.125e-3, length_m))?);
                }
                Ok(())
            }),
        displayed(7, "power by duty", "P = duty · V_s²/R: duty scales power, not voltage.")
            .code(ELECTRICAL, "pub fn heating_power_w")
            .agrees(|_, found| {
                let i = current_a(6.0, 10.0, 0.0);
                found.equal("at 6 V, 10 Ω and a duty of 0.3", "W", 0.3 * 3.6, heating_power_w(0.3, i, 10.0));
                Ok(())
            }),
        displayed(8, "voltage of the same power", "√duty · V_s heats as much all the time.")
            .code(ELECTRICAL, "pub fn heating_power_w")
            .agrees(|_, found| {
                let pulses = heating_power_w(0.3, current_a(6.0, 10.0, 0.0), 10.0);
                let steady = heating_power_w(1.0, current_a(0.3f64.sqrt() * 6.0, 10.0, 0.0), 10.0);
                found.equal("steady over pulsed power", "1", 1.0, steady / pulses);
                Ok(())
            }),
        figure(
            61,
            "a circuit with a shunt",
            "The voltage over a shunt of 0.1 Ω or less is the current, and with \
                the supply the wire's resistance.",
        )
        .code("model/physics/src/params.rs", "pub shunt_ohm")
        .code(ELECTRICAL, "pub fn on_current_a")
        .agrees(|_, found| {
            let drive = Drive { shunt_ohm: 0.1, switch_ohm: 0.0, ..SOURCE };
            let over_shunt = drive.on_current_a(10.43) * drive.shunt_ohm;
            let current = over_shunt / 0.1;
            found.near("resistance, from shunt and supply", "Ω", 10.43, 1e-9, (6.0 - over_shunt) / current);
            Ok(())
        }),
        figure(
            62,
            "a circuit with one input",
            "One input reads the supply while the switch is open and the shunt \
                while it conducts: enough for current, resistance and power.",
        )
        .code(ELECTRICAL, "pub fn low_ohm")
        .agrees(|_, found| {
            let drive = Drive { shunt_ohm: 0.1, switch_ohm: 0.02, ..SOURCE };
            let (open, conducting) = (drive.supply_v, drive.on_current_a(10.43) * drive.low_ohm());
            let current = conducting / drive.low_ohm();
            let resistance = (open - conducting) / current;
            found.near("resistance, from two readings", "Ω", 10.43, 1e-9, resistance);
            found.near("power, from them", "W", drive.on_power_w(10.43), 1e-9, current * current * resistance);
            Ok(())
        }),
        figure(
            64,
            "a current amplifier",
            "PWM through an RC of 40 Hz, then a regulated current, whatever the \
                wire's resistance.",
        )
        .code("model/physics/src/params.rs", "pub struct Amplifier")
        .code("model/physics/src/formulas/electrical.rs", "pub fn regulated_a")
        .agrees(amplifier::regulated),
        figure(
            66,
            "binary segments",
            "Taps at doubling lengths, segments wholly hot or cold: n taps give \
                2^n lengths, without a sensor.",
        )
        .code("control/src/laws/segment.rs", "pub struct BinarySegment")
        .agrees(segments::all_lengths),
    ]
}

/// λ = 1/time constant by the material's own h, 1/s.
fn lambda(material: &Material, diameter_m: f64) -> f64 {
    let g = wire(diameter_m, 0.16);
    1.0 / cooling_time_s(g.heat_capacity_j_per_k(material), g.loss_w_per_k(material.convection_at(diameter_m, 60.0)))
}

fn natural() -> Material {
    Material { convection: Convection::Natural, ..Material::default() }
}

fn to_the_air() -> Vec<Row> {
    vec![
        displayed(
            9,
            "a wire's heat balance by its size",
            "The left side counts ρ π L c_p/4 as heat capacity, the right side h \
            D² L as loss.",
        )
        .code(THERMAL, "pub fn loss_w_per_k")
        .differs(
            "the printed line has lost D² on the left and has D² for π D on the \
                    right; the next line is that of the whole equation",
            |_, found| {
                let model = hanging();
                let (capacity, loss) = (model.heat_capacity_j_per_k(), model.loss_w_per_k(60.0));
                let printed = 6450.0 * std::f64::consts::PI * 0.16 * 836.0 / 4.0;
                let printed_loss = 121.2 * 0.125e-3f64.powi(2) * 0.16;
                found.near("heat capacity", "J/K", printed, 0.01 * printed, capacity);
                found.near("loss", "W/K", printed_loss, 0.01 * printed_loss, loss);
                found.proof();
                found.near(
                    "heat capacity over the printed one times D²",
                    "1",
                    1.0,
                    1e-9,
                    capacity / (printed * 0.125e-3f64.powi(2)),
                );
                let ratio = loss / printed_loss * 0.125e-3 / std::f64::consts::PI;
                found.near("loss over the printed one, times D/π", "1", 1.0, 1e-9, ratio);
                Ok(())
            },
        ),
        displayed(
            10,
            "the pole of cooling",
            "λ = 4h/(ρ D c_p): no matter the length, and inverse to the diameter. \
            With the measured h = 121.8 that is chapter 9's 0.7228/s.",
        )
        .code(THERMAL, "pub fn cooling_time_s")
        .agrees(|_, found| {
            let measured = Material { convection_w_per_m2_k: 121.8, ..Material::default() };
            found.near("λ of 0.125 mm", "1/s", 0.7228, 1e-4, lambda(&measured, 0.125e-3));
            found.near(
                "λ of 0.25 mm over that",
                "1",
                0.5,
                1e-12,
                lambda(&measured, 0.25e-3) / lambda(&measured, 0.125e-3),
            );
            Ok(())
        }),
        displayed(11, "power that holds a temperature", "P = h π D² L (T − T_∞).")
            .code(THERMAL, "pub fn loss_w_per_k")
            .differs(
                "the surface of a wire is π D L; the printed D² would make 0.125 µm² \
                of it a metre",
                |_, found| {
                    let printed = 121.2 * std::f64::consts::PI * 0.125e-3f64.powi(2) * 0.16 * 60.0;
                    let holding = hanging().loss_w_per_k(60.0) * 60.0;
                    found.near("power at 60 K over the air", "W", printed, 0.01 * printed, holding);
                    found.proof();
                    let meant = 121.2 * std::f64::consts::PI * 0.125e-3 * 0.16 * 60.0;
                    found.near("power with π D L", "W", meant, 1e-12, holding);
                    Ok(())
                },
            ),
        equation(
            34,
            "convection by temperature and diameter",
            "h = 65.5 e^(−D/4) (T − T_∞)^(1/6), D in mm; 100 to 130 W/(m² K) for \
            thin wires; 121.8 was measured on 0.25 mm.",
        )
        .code(THERMAL, "pub fn convection_at")
        .agrees(|_, found| {
            let h = |diameter_m: f64, above_k: f64| natural().convection_at(diameter_m, above_k);
            let stated = 65.5 * (-0.125f64 / 4.0).exp() * 40f64.powf(1.0 / 6.0);
            found.near("0.125 mm, 40 K over the air", "W/(m² K)", stated, 1e-9, h(0.125e-3, 40.0));
            found.near("0.25 mm, 60 K over the air: the measured one", "W/(m² K)", 121.8, 1.0, h(0.25e-3, 60.0));
            found.between("0.25 mm, 20 K over the air", "W/(m² K)", 100.0, 130.0, h(0.25e-3, 20.0));
            found.between("0.25 mm, 80 K over the air", "W/(m² K)", 100.0, 130.0, h(0.25e-3, 80.0));
            Ok(())
        }),
        equation(35, "the pole of cooling, simplified", "λ ≈ 0.0086/D², D in mm; a wire is cold after 3/λ.")
            .code(THERMAL, "pub fn cooling_time_s")
            .differs(
                "by its own derivation λ goes with 1/D, and h by eq. 34 changes that \
                    by 3 % from 0.125 to 0.25 mm; both meet near 0.09 mm alone. 3/λ of \
                    0.125 mm is 5.5 s by it where table 3's eq. 6 has 0.91 s",
                |_, found| {
                    let by_35 = |d_mm: f64| 0.0086 / (d_mm * d_mm);
                    for d_mm in [0.125, 0.25] {
                        let what = format!("λ of {d_mm} mm, with h of eq. 34");
                        found.near(&what, "1/s", by_35(d_mm), 0.05 * by_35(d_mm), lambda(&natural(), d_mm * 1e-3));
                    }
                    found.proof();
                    let ratio = lambda(&natural(), 0.25e-3) / lambda(&natural(), 0.125e-3);
                    found.near("λ of 0.25 mm over that of 0.125 mm", "1", 0.5 * (-0.125f64 / 4.0).exp(), 1e-9, ratio);
                    found.near(
                        "λ of 0.0924 mm",
                        "1/s",
                        by_35(0.0924),
                        0.01 * by_35(0.0924),
                        lambda(&natural(), 0.0924e-3),
                    );
                    found.near("3/λ of 0.125 mm by eq. 35, over eq. 6", "1", 6.0, 0.1, {
                        3.0 / by_35(0.125) / WireRules::of(0.125e-3, 0.16).cooling_time_s()
                    });
                    Ok(())
                },
            ),
        figure(69, "force against bandwidth", "A thicker wire pulls more and moves more slowly.")
            .code("tools/design/src/rules.rs", "pub fn cooling_time_s")
            .agrees(|_, found| {
                let rules = |d_mm: f64| WireRules::of(d_mm * 1e-3, 0.16);
                let diameters: Vec<f64> = (5..=100).map(|i| 0.005 * f64::from(i)).collect();
                let force: Vec<f64> = diameters.iter().map(|d| rules(*d).max_force_n()).collect();
                let bandwidth: Vec<f64> = diameters.iter().map(|d| 1.0 / rules(*d).cooling_time_s()).collect();
                found.above(
                    "least rise of force from one diameter to the next",
                    "N",
                    0.0,
                    least(&force.windows(2).map(|p| p[1] - p[0]).collect::<Vec<_>>()),
                );
                found.below(
                    "largest rise of bandwidth",
                    "Hz",
                    0.0,
                    largest(&bandwidth.windows(2).map(|p| p[1] - p[0]).collect::<Vec<_>>()),
                );
                found.equal(
                    "force times bandwidth, over that of another diameter",
                    "1",
                    1.0,
                    force[0] * bandwidth[0] / (force[90] * bandwidth[90]),
                );
                let across = ("Diameter, mm", "1");
                found.line(across, ("Largest pull", "N"), Ink::Series(0), (diameters.clone(), force));
                found.line(across, ("Cooling times a second", "Hz"), Ink::Series(0), (diameters, bandwidth));
                for drawing in &mut found.picture.drawings {
                    drawing.decades = (true, true);
                }
                Ok(())
            }),
        figure(
            70,
            "a slow controller in still and in calm air",
            "Smooth in a chamber, disturbed by the draughts of a room.",
        )
        .not_given("the controller, its gains and the air's motion"),
    ]
}
