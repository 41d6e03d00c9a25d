//! What a channel has to offer to another simulator: its inputs, outputs and parameters, each under a name with its unit.
//!
//! Units are those of recordings: SI, and °C for temperatures; parameters have the unit of their key in the rig file.

use sinew_physics::{DriveKind, Inputs, Load, Outputs};
use sinew_rig::{Rig, parameters};

/// What a variable is to the other simulator.
#[derive(Debug, Clone, Copy)]
pub enum Role {
    /// Time.
    Independent,
    /// Set before a step, for the whole of it; what is imposed is reached at its end.
    Input(fn(&mut Inputs) -> &mut f64),
    /// As sensors see it at the end of a step.
    Output(fn(&Outputs) -> f64),
    /// Set before the simulation begins: a key of the rig file.
    Parameter(&'static str),
}

/// One variable; its place in the list is its value reference.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Its name, with its unit.
    pub name: String,
    /// Its unit; empty where it has none.
    pub unit: &'static str,
    /// What it is.
    pub about: String,
    /// What it is to the other simulator.
    pub role: Role,
}

/// The variables of a channel, in the order of their value references.
pub fn variables(rig: &Rig, channel: usize) -> Vec<Variable> {
    let model = &rig.channels[channel].model;
    let variable =
        |name: &str, unit, about: &str, role| Variable { name: name.into(), unit, about: about.into(), role };
    let input = |name, unit, about, of| variable(name, unit, about, Role::Input(of));
    let output = |name, unit, about, of| variable(name, unit, about, Role::Output(of));
    let mut list = vec![variable("time", "s", "Time", Role::Independent)];

    let drive: fn(&mut Inputs) -> &mut f64 = |inputs| &mut inputs.drive;
    list.push(match model.drive.kind {
        DriveKind::Pwm | DriveKind::Amplifier(_) => input("duty", "", "Duty of the PWM, 0 to 1", drive),
        DriveKind::Power => input("power_w", "W", "Heating power", drive),
        DriveKind::Current => input("current_a", "A", "Current", drive),
        DriveKind::Temperature => input("temperature_c", "degC", "Wire temperature, imposed", drive),
    });
    let imposed: fn(&mut Inputs) -> &mut f64 = |inputs| &mut inputs.imposed;
    match model.load {
        Load::SpringMassDamper { .. } => {
            let about = "External force on the load, positive pulling the wire longer";
            list.push(input("disturbance_n", "N", about, |inputs| &mut inputs.external_n));
        }
        Load::ImposedPosition => list.push(input("position_m", "m", "Elongation, imposed, positive longer", imposed)),
        Load::ImposedForce => list.push(input("force_n", "N", "Tension, imposed", imposed)),
    }
    if matches!(model.drive.kind, DriveKind::Pwm | DriveKind::Amplifier(_)) {
        list.push(input("supply_v", "V", "Supply voltage", |inputs| &mut inputs.supply_v));
    }
    list.push(input("ambient_c", "degC", "Temperature of the air", |inputs| &mut inputs.ambient_c));

    let taken: Vec<String> = list.iter().map(|variable| variable.name.clone()).collect();
    let outputs = [
        output("position_m", "m", "Elongation over the hot, unloaded length, positive longer", |o| o.position_m),
        output("force_n", "N", "Wire tension", |o| o.force_n),
        output("temperature_c", "degC", "Wire temperature", |o| o.temperature_c),
        output("martensite", "", "Martensite fraction, 0 to 1", |o| o.martensite),
        output("resistance_ohm", "Ohm", "Resistance of the wire", |o| o.resistance_ohm),
        output("power_w", "W", "Mean heating power over the last step", |o| o.power_w),
        output("current_a", "A", "Current in the on-phase", |o| o.current_a),
        output("v1_v", "V", "First tap in the on-phase; 0 without taps", |o| o.v1_v),
        output("v2_v", "V", "Second tap in the on-phase; 0 without taps", |o| o.v2_v),
        output("v3_v", "V", "Moving end in the on-phase", |o| o.v3_v),
    ];
    list.extend(outputs.into_iter().filter(|output| !taken.contains(&output.name)));

    // the air's temperature is an input, and of taps or a mass that are not there no number can be given
    let there = parameters().filter(|p| p.table != "rig" && rig.parameter(channel, p.key).is_some());
    list.extend(there.map(|p| Variable {
        name: format!("{}.{}", p.table.trim_start_matches("channel."), p.key),
        unit: match p.unit {
            "°C" => "degC",
            "Ω" => "Ohm",
            other => other,
        },
        about: p.about.into(),
        role: Role::Parameter(p.key),
    }));
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_every_parameter_has_a_value() {
        let rig = Rig::hexapod();
        let list = variables(&rig, 0);
        let mut names: Vec<&str> = list.iter().map(|variable| variable.name.as_str()).collect();
        assert_eq!(names[..5], ["time", "duty", "disturbance_n", "supply_v", "ambient_c"]);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
        assert!(names.contains(&"material.convection_w_per_m2_k") && names.contains(&"position_m"));
        for variable in &list {
            if let Role::Parameter(key) = variable.role {
                assert!(rig.parameter(0, key).is_some_and(f64::is_finite), "{key}");
            }
        }
    }
}
