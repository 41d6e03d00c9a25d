//! `modelDescription.xml`: what is in an FMU, for the simulator that loads it (FMI 3.0, chapter 2.4).

use std::collections::BTreeSet;
use std::fmt::Write as _;

use sinew_rig::Rig;

use crate::instance::{Instance, Refusal};
use crate::variables::{Role, variables};

/// Name of the library inside the FMU, without its ending.
pub const MODEL_IDENTIFIER: &str = "sinew_fmu";

/// The description of a channel; `token` names what it was made from, and an instance of something else is refused.
///
/// # Errors
/// A wire that cannot be at rest: it has no start values.
pub fn description(rig: &Rig, channel: usize, token: &str) -> Result<String, Refusal> {
    let name = &rig.channels[channel].name;
    let mut start = Instance::new(rig.text(), rig.file(), name)?;
    let list = variables(rig, channel);
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(
        text,
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{}\"\n    description=\"{}\" \
         version=\"{}\" generationTool=\"sinew {}\" variableNamingConvention=\"flat\">",
        escaped(&format!("{}.{name}", rig.name)),
        escaped(token),
        escaped(&format!("The shape memory wire {name} of {}: heat, transformation, load and circuit", rig.name)),
        env!("CARGO_PKG_VERSION"),
        env!("CARGO_PKG_VERSION"),
    );
    let _ = writeln!(
        text,
        "  <CoSimulation modelIdentifier=\"{MODEL_IDENTIFIER}\" canHandleVariableCommunicationStepSize=\"true\" \
         canGetAndSetFMUState=\"true\"/>"
    );
    let units: BTreeSet<&str> = list.iter().map(|variable| variable.unit).filter(|unit| !unit.is_empty()).collect();
    text += "  <UnitDefinitions>\n";
    for unit in units {
        let _ = writeln!(text, "    <Unit name=\"{}\">{}</Unit>", escaped(unit), base_unit(unit));
    }
    text += "  </UnitDefinitions>\n  <DefaultExperiment startTime=\"0\" stopTime=\"10\" stepSize=\"0.01\"/>\n  <ModelVariables>\n";
    for (reference, variable) in list.iter().enumerate() {
        let causality = match variable.role {
            Role::Independent => "causality=\"independent\" variability=\"continuous\"".to_string(),
            Role::Output(_) => "causality=\"output\" variability=\"continuous\"".to_string(),
            Role::Input(_) => {
                format!("causality=\"input\" variability=\"continuous\" start=\"{:?}\"", start.get(reference as u32)?)
            }
            Role::Parameter(_) => {
                format!("causality=\"parameter\" variability=\"fixed\" start=\"{:?}\"", start.get(reference as u32)?)
            }
        };
        let unit =
            if variable.unit.is_empty() { String::new() } else { format!(" unit=\"{}\"", escaped(variable.unit)) };
        let _ = writeln!(
            text,
            "    <Float64 name=\"{}\" valueReference=\"{reference}\" {causality}{unit} description=\"{}\"/>",
            escaped(&variable.name),
            escaped(&variable.about)
        );
    }
    text += "  </ModelVariables>\n  <ModelStructure>\n";
    let outputs = || list.iter().enumerate().filter(|(_, variable)| matches!(variable.role, Role::Output(_)));
    for (reference, _) in outputs() {
        let _ = writeln!(text, "    <Output valueReference=\"{reference}\"/>");
    }
    for (reference, _) in outputs() {
        let _ = writeln!(text, "    <InitialUnknown valueReference=\"{reference}\"/>");
    }
    text += "  </ModelStructure>\n</fmiModelDescription>\n";
    Ok(text)
}

/// What a unit is in SI, where that is one of its powers; tools convert and check by it.
fn base_unit(unit: &str) -> &'static str {
    match unit {
        "s" => "<BaseUnit s=\"1\"/>",
        "m" => "<BaseUnit m=\"1\"/>",
        "mm" => "<BaseUnit m=\"1\" factor=\"0.001\"/>",
        "kg" => "<BaseUnit kg=\"1\"/>",
        "A" => "<BaseUnit A=\"1\"/>",
        "N" => "<BaseUnit kg=\"1\" m=\"1\" s=\"-2\"/>",
        "W" => "<BaseUnit kg=\"1\" m=\"2\" s=\"-3\"/>",
        "V" => "<BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\"/>",
        "Ohm" => "<BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-2\"/>",
        "degC" => "<BaseUnit K=\"1\" offset=\"273.15\"/>",
        "GPa" => "<BaseUnit kg=\"1\" m=\"-1\" s=\"-2\" factor=\"1e9\"/>",
        "N/m" => "<BaseUnit kg=\"1\" s=\"-2\"/>",
        "N s/m" => "<BaseUnit kg=\"1\" s=\"-1\"/>",
        "1/K" => "<BaseUnit K=\"-1\"/>",
        "kg/m³" => "<BaseUnit kg=\"1\" m=\"-3\"/>",
        "J/kg" => "<BaseUnit m=\"2\" s=\"-2\"/>",
        "J/(kg K)" => "<BaseUnit m=\"2\" s=\"-2\" K=\"-1\"/>",
        "W/(m² K)" => "<BaseUnit kg=\"1\" s=\"-3\" K=\"-1\"/>",
        _ => "",
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
