//! The words of the page and of the terminal's answer: verdicts, sensors, equations, effects.

use sinew_diagnosis::{Diagnosis, Grade, Location, Verdict};
use sinew_physics::effects::Equation;
use sinew_plot::quantity::{chi, fixed, percent};
use sinew_recording::Column;

/// The answer as a headline.
pub(crate) fn headline(diagnosis: &Diagnosis) -> String {
    let found = diagnosis.effects.iter().filter(|e| e.grade != Grade::Suspected);
    let found = list(&found.map(|e| effect_name(&e.id)).collect::<Vec<_>>());
    match diagnosis.verdict {
        Verdict::Agrees if diagnosis.is_explained() => "The simulation agrees with the recording".into(),
        Verdict::ParametersOff if diagnosis.is_explained() => "The physics suffices; its parameters were off".into(),
        Verdict::Agrees => format!("Not explained: {}", left(diagnosis)),
        Verdict::ParametersOff if diagnosis.curves.is_some() => {
            format!("Parameters are off, and the curves have a shape of their own; {}", left(diagnosis))
        }
        Verdict::ParametersOff => format!("Parameters are off, but do not explain the recording: {}", left(diagnosis)),
        Verdict::PhysicsMissing if found.is_empty() => "Physics is missing".into(),
        Verdict::PhysicsMissing => format!("Physics is missing: {found}"),
        Verdict::UnknownPhysics if found.is_empty() => "Something is missing that is not in the catalogue".into(),
        Verdict::UnknownPhysics => format!("Something is missing that is not in the catalogue, beside {found}"),
    }
}

/// What nothing that was tried explains.
fn left(diagnosis: &Diagnosis) -> String {
    format!("an error of {} times the noise is left", chi(diagnosis.remains.chi))
}

/// The verdict in a word or two.
pub(crate) fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "agrees",
        Verdict::ParametersOff => "parameters off",
        Verdict::PhysicsMissing => "physics missing",
        Verdict::UnknownPhysics => "unknown physics",
    }
}

/// What a sensor measures, and the unit of its column.
pub(crate) fn column(column: Column) -> (&'static str, &'static str) {
    match column {
        Column::Duty => ("Duty", "1"),
        Column::PowerW => ("Heating power", "W"),
        Column::TemperatureC => ("Wire temperature", "°C"),
        Column::SupplyV => ("Supply voltage", "V"),
        Column::CurrentA => ("Current", "A"),
        Column::V1V => ("Voltage V₁, first tap", "V"),
        Column::V2V => ("Voltage V₂, second tap", "V"),
        Column::V3V => ("Voltage V₃, moving end", "V"),
        Column::ForceN => ("Tension", "N"),
        Column::PositionM => ("Elongation", "m"),
        Column::AmbientC => ("Ambient temperature", "°C"),
        Column::DisturbanceN => ("Disturbing force", "N"),
    }
}

/// The same by the column's name in a file; the name itself where there is no such column.
pub(crate) fn column_by_name(name: &str) -> (&str, &'static str) {
    match Column::from_name(name) {
        Some(known) => column(known),
        None => (name, ""),
    }
}

/// `thermal.end_conduction` is "end conduction".
pub(crate) fn effect_name(id: &str) -> String {
    id.split_once('.').map_or(id, |(_, name)| name).replace('_', " ")
}

/// What an equation is about, for readers who do not know the names.
pub(crate) fn equation_about(name: &str) -> &'static str {
    match Equation::ALL.into_iter().find(|e| e.name() == name) {
        Some(Equation::Thermal) => "heat into and out of the wire",
        Some(Equation::Electrical) => "resistance and circuit",
        Some(Equation::Kinetic) => "when the phase changes",
        Some(Equation::Mechanical) => "strain, load and friction",
        Some(Equation::Sensing) => "what the sensors make of it",
        None => "",
    }
}

/// "a", "a and b", "a, b and c".
pub(crate) fn list<S: AsRef<str>>(items: &[S]) -> String {
    match items {
        [] => String::new(),
        [one] => one.as_ref().into(),
        [most @ .., last] => {
            let most: Vec<&str> = most.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", most.join(", "), last.as_ref())
        }
    }
}

/// A recording without the folders it lies in.
pub(crate) fn short(recording: &str) -> &str {
    recording.rsplit(['/', '\\']).next().unwrap_or(recording)
}

/// When and under which conditions, as sentences without their full stops; at most so many of each.
pub(crate) fn places(location: &Location, most: usize) -> Vec<String> {
    let windows = location.windows.iter().take(most).map(|w| {
        let [start, end] = [w.start_s, w.end_s].map(|t| fixed(t, 1));
        format!("{} of what is left lies between {start} s and {end} s of {}", percent(w.share), short(&w.recording))
    });
    let conditions = location
        .conditions
        .iter()
        .take(most)
        .map(|c| format!("{} of it: {} ({} of the samples)", percent(c.share), c.when, percent(c.of_time)));
    windows.chain(conditions).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_read_as_sentences_do() {
        assert_eq!(list::<&str>(&[]), "");
        assert_eq!(list(&["a"]), "a");
        assert_eq!(list(&["a", "b", "c"]), "a, b and c");
    }

    #[test]
    fn a_recording_is_called_by_its_file() {
        assert_eq!(short("bench/monday/run1.csv"), "run1.csv");
        assert_eq!(short("run1.csv"), "run1.csv");
        assert_eq!(short(""), "");
    }

    #[test]
    fn an_effect_is_named_without_its_equation() {
        assert_eq!(effect_name("thermal.end_conduction"), "end conduction");
        assert_eq!(effect_name("odd"), "odd");
        assert_eq!(effect_name(""), "");
    }

    #[test]
    fn every_column_and_equation_has_words() {
        for column in Column::ALL {
            assert_eq!(column_by_name(column.name()), self::column(column));
        }
        assert_eq!(column_by_name("odd"), ("odd", ""));
        for equation in Equation::ALL {
            assert!(!equation_about(equation.name()).is_empty());
        }
        assert_eq!(equation_about("odd"), "");
    }
}
