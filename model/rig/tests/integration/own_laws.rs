//! Physics that users write: in a catalogue for every rig, or in the rig file itself.

use proptest::prelude::*;
use sinew_physics::effects::{Entry, OwnRole};
use sinew_rig::{Catalogue, Rig};

use crate::mistakes::GOOD;

const SLIPSTREAM: &str = r#"
[effects."own.slipstream"]
says = "The moving wire stirs the air around it."
enters = "heat"
formula = "-gain * surface * abs(velocity) * (temperature - ambient)"
[effects."own.slipstream".parameters.gain]
unit = "W s/(m³ K)"
null = 0.0
range = [0.0, 1e5]
plausible = [100.0, 5000.0]
about = "loss per surface, speed and degree"
"#;

/// A law with everything a law may have.
const CREEP: &str = r#"
[effects."own.creep"]
says = "Under tension the wire flows."
enters = "strain"
formula = "flowed"
[effects."own.creep".parameters]
rate = { unit = "1/s", null = 0, range = [0, 1e-2], plausible = [1e-6, 1e-4], about = "rate at the reference" }
reference = { unit = "MPa", default = 150.0, range = [1.0, 1000.0], about = "stress of that rate" }
[effects."own.creep".states.flowed]
unit = "%"
start = 0.0
rate = "rate * stress / reference"
"#;

fn catalogue() -> Catalogue {
    Catalogue::parse(&format!("{SLIPSTREAM}{CREEP}"), "laws.toml").unwrap()
}

/// The good rig with such lines more, which are lines 23 and on.
fn rig(more: &str, catalogue: &Catalogue) -> Result<Rig, String> {
    Rig::parse_with(&format!("{GOOD}{more}"), "rig.toml", catalogue).map_err(|error| error.to_string())
}

/// What is said of the slipstream with one piece replaced.
#[track_caller]
fn says(from: &str, to: &str, expected: &str) {
    assert_eq!(SLIPSTREAM.matches(from).count(), 1, "{from}");
    let error = Catalogue::parse(&SLIPSTREAM.replace(from, to), "laws.toml").unwrap_err().to_string();
    assert_eq!(error, expected);
}

#[test]
fn laws_of_a_catalogue_are_candidates_until_a_rig_sets_them() {
    let catalogue = catalogue();
    assert_eq!(catalogue.ids().collect::<Vec<_>>(), ["own.creep", "own.slipstream"]);
    let candidate = rig("", &catalogue).unwrap();
    let model = &candidate.channels[0].model;
    for id in catalogue.ids() {
        let effect = model.effect(id).expect("every wire of the rig has it");
        assert!(effect.is_null(model), "{id}");
        assert_eq!(candidate.channels[0].range_of(&format!("{id}.x")), None);
    }
    assert_eq!(candidate.channels[0].range_of("own.slipstream.gain"), Some(("W s/(m³ K)", 0.0, 1e5)));
    let set = rig("[channel.effects.\"own.creep\"]\nrate = 2e-5\n", &catalogue).unwrap();
    let model = &set.channels[0].model;
    let effect = model.effect("own.creep").unwrap();
    assert!(!effect.is_null(model));
    assert_eq!([effect.parameters[0].get(model), effect.parameters[1].get(model)], [2e-5, 150.0]);
    assert!(model.effect("own.slipstream").unwrap().is_null(model));
    assert!(rig("", &Catalogue::default()).unwrap().channels[0].model.effect("own.creep").is_none());
}

#[test]
fn a_written_rig_file_needs_its_catalogue_no_more() {
    let more = "[channel.effects.\"own.creep\"]\nrate = 2e-5\nreference = 120.0\n\n[channel.effects.\"own.slipstream\"]\ngain = 700\n";
    let set = rig(more, &catalogue()).unwrap();
    let written = set.to_toml();
    let again = Rig::parse(&written, "again.toml").unwrap_or_else(|error| panic!("{error}\n{written}"));
    assert_eq!(again.channels[0].model, set.channels[0].model);
    assert_eq!(again.to_toml(), written, "stable");
    // and with it, it is the same law, not another of its name
    assert_eq!(Rig::parse_with(&written, "again.toml", &catalogue()).unwrap().channels[0].model, set.channels[0].model);
    // its own keys stay as they were typed
    assert!(written.contains("gain = 700"), "{written}");
    assert!(written.contains("formula = \"flowed\""), "{written}");
}

#[test]
fn a_law_stands_in_the_rig_file_itself() {
    let inside = CREEP.replace("[effects.", "[channel.effects.").replace("formula =", "rate = 3e-5\nformula =");
    let read = rig(&inside, &Catalogue::default()).unwrap();
    let model = &read.channels[0].model;
    let law = model.effects.own.laws().next().unwrap();
    assert_eq!((law.id(), law.definition.enters), ("own.creep", Entry::Strain));
    assert_eq!(law.definition.parameters[0].role, OwnRole::Switch { null: 0.0 });
    assert_eq!(law.definition.parameters[1].plausible, (1.0, 1000.0), "as the range, where none is given");
    assert_eq!(model.effect("own.creep").unwrap().parameters[0].get(model), 3e-5);
    assert_eq!(read.to_toml(), format!("{GOOD}{inside}"), "nothing to write");
}

#[test]
fn a_law_that_is_not_there_or_twice_is_refused() {
    assert_eq!(
        rig("[channel.effects.\"own.creep\"]\nrate = 2e-5\n", &Catalogue::default()).unwrap_err(),
        "rig.toml:23: channel \"wire\": effects.\"own.creep\" is missing, expected a formula; or read the file with the catalogue \
         that defines it, by --catalogue"
    );
    let other = CREEP.replace("[effects.", "[channel.effects.").replace("\"flowed\"", "\"2 * flowed\"");
    let error = rig(&other, &catalogue()).unwrap_err();
    assert!(error.starts_with("rig.toml:24: channel \"wire\": effects.\"own.creep\" is defined here"), "{error}");
    assert!(error.contains("laws.toml; take one of them out"), "{error}");
    assert_eq!(
        rig("[channel.effects.\"own.creep\"]\nrates = 2e-5\n", &catalogue()).unwrap_err(),
        "rig.toml:24: channel \"wire\": effects.\"own.creep\".rates is unknown, did you mean rate?"
    );
    assert_eq!(
        rig("[channel.effects.\"own.creep\"]\nrate = 1\n", &catalogue()).unwrap_err(),
        "rig.toml:24: channel \"wire\": effects.\"own.creep\".rate is 1, expected 0 to 0.01"
    );
}

#[test]
fn mistakes_are_found_at_their_lines() {
    let of = "laws.toml:5: effects.\"own.slipstream\".formula";
    says(
        "(temperature - ambient)",
        "(temperature - velocity)",
        &format!(
            "{of} is wrong: K and m s^-1 cannot be added; a number carries its unit in brackets: `20 [K]`\n\
             -gain * surface * abs(velocity) * (temperature - velocity)\n\
             {:34}^^^^^^^^^^^^^^^^^^^^^^^^",
            ""
        ),
    );
    says(
        "enters = \"heat\"",
        "enters = \"force\"",
        &format!(
            "{of} is wrong: this is in W, and should be in N\n\
             -gain * surface * abs(velocity) * (temperature - ambient)\n {}",
            "^".repeat("gain * surface * abs(velocity) * (temperature - ambient)".len())
        ),
    );
    says(
        "enters = \"heat\"",
        "",
        "laws.toml:2: effects.\"own.slipstream\".enters is missing, expected where it enters: \
        heat, driving_temperature, strain, force, resistivity, shown_position, shown_force, shown_current, shown_v1, shown_v2, \
        shown_v3",
    );
    says(
        "unit = \"W s/(m³ K)\"",
        "unit = 3",
        "laws.toml:7: effects.\"own.slipstream\".parameters.gain.unit is 3, \
        expected its unit, such as \"W/(m² K)\"; \"1\" where it has none",
    );
    says(
        "null = 0.0",
        "null = 0.0\ndefault = 1.0",
        "laws.toml:9: effects.\"own.slipstream\".parameters.gain.default has a null \
        and a default, expected one of them: null where it turns the effect on and off, default where it says how the effect acts",
    );
    says(
        "range = [0.0, 1e5]",
        "range = [0.0]",
        "laws.toml:9: effects.\"own.slipstream\".parameters.gain.range is an array, \
        expected two numbers, such as [0.0, 10.0]",
    );
    says(
        "range = [0.0, 1e5]",
        "ranges = [0.0, 1e5]",
        "laws.toml:6: effects.\"own.slipstream\".parameters.gain.range is missing, \
        expected two numbers, such as [0.0, 10.0]\n\
        laws.toml:9: effects.\"own.slipstream\".parameters.gain.ranges is unknown, did you mean range?",
    );
    says(
        "says = ",
        "gain = 3\nsays = ",
        "laws.toml:3: effects.\"own.slipstream\".gain is unknown; expected says, enters, formula, \
        parameters, states",
    );
}

#[test]
fn a_file_that_is_no_catalogue_is_refused() {
    let of = |text: &str| Catalogue::parse(text, "laws.toml").unwrap_err().to_string();
    assert_eq!(
        of(""),
        "laws.toml:1: effects is missing, expected at least one table [effects.\"own.NAME\"] with a formula"
    );
    assert!(of("[effects").starts_with("laws.toml:1: not TOML: "), "{}", of("[effects"));
    assert!(of(GOOD).contains("laws.toml:1: rig is unknown"), "{}", of(GOOD));
    let foreign = SLIPSTREAM.replace("own.", "thermal.");
    assert!(of(&foreign).contains("begin with own., such as [effects.\"own.slipstream\"]"), "{}", of(&foreign));
    let error = Catalogue::load("/nowhere/laws.toml".as_ref()).unwrap_err().to_string();
    assert!(error.starts_with("/nowhere/laws.toml: "), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// Whatever stands in a catalogue, the answer names lines that are there.
    #[test]
    fn no_text_is_too_much(at in 0usize..SLIPSTREAM.len() + CREEP.len(), cut in 0usize..40, put in "[\\PC\n]{0,12}") {
        let whole = format!("{SLIPSTREAM}{CREEP}");
        let edge = |at: usize| (at..=whole.len()).find(|at| whole.is_char_boundary(*at)).unwrap();
        let (from, to) = (edge(at), edge((at + cut).min(whole.len())));
        let text = format!("{}{put}{}", &whole[..from], &whole[to..]);
        if let Err(sinew_rig::Error::Invalid { problems }) = Catalogue::parse(&text, "laws.toml") {
            let lines = text.split('\n').count();
            prop_assert!(problems.iter().all(|problem| (1..=lines).contains(&problem.line)), "{problems:?}");
        }
    }
}
