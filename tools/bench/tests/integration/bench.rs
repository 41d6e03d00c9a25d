//! The bench as a whole: choices, plants, figures and their report.

use sinew_bench::score::{self, WINNER, ranking};
use sinew_bench::{Answer, Choice, Family, Filter, Plan, Plant, follow, page, pictures, row, run, sensing};
use sinew_control::StrokeRange;
use sinew_physics::Wire;

fn only(plants: &[&str], controllers: &[&str], estimators: &[&str]) -> Plan {
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect();
    let filter = Filter { plants: words(plants), controllers: words(controllers), estimators: words(estimators) };
    Plan::quick(1).only(&filter)
}

fn dual(mut plan: Plan) -> Plan {
    plan.choices.retain(|choice| choice.sensing == "dual");
    plan
}

fn no_sensing() -> sensing::Report {
    sensing::experiment(&sensing::Plan { loads_gf: vec![200.0], sweep_s: 6.0, ..sensing::Plan::new(1, Vec::new()) })
}

#[test]
fn every_word_of_the_rig_file_is_a_choice() {
    let all = Choice::all();
    for (key, of) in [
        ("algorithm", (|choice: &Choice| choice.controller.clone()) as fn(&Choice) -> String),
        ("estimator", |choice| choice.estimator.clone()),
        ("sensing", |choice| choice.sensing.clone()),
    ] {
        for word in sinew_rig::words("channel.control", key) {
            assert!(all.iter().any(|choice| of(choice) == *word), "{key} {word}");
        }
    }
    assert!(all.contains(&Choice::default()));
}

#[test]
fn every_plant_takes_every_choice() {
    for plant in Plant::all() {
        let pair = plant.family == Family::Pair;
        for choice in if pair { Choice::of_joint() } else { Choice::all() } {
            let believed = plant.believed(&choice, 1).unwrap_or_else(|e| panic!("{} {choice:?}: {e}", plant.name));
            let truth = plant.truth(&believed);
            let misjudged = plant.family == Family::Misjudged || plant.name.ends_with("misjudged");
            assert_eq!(truth == believed, !misjudged, "{}", plant.name);
            truth.channels[0].model.validate().unwrap_or_else(|e| panic!("{}: {e}", plant.name));
        }
    }
}

#[test]
fn the_default_of_a_fresh_rig_file_is_the_recorded_winner() {
    let Choice { controller, estimator, sensing } = Choice::default();
    assert_eq!([controller.as_str(), &estimator, &sensing], WINNER);
}

/// Not the full run, but the nearest rivals on a few plants, on seeds to develop with.
#[test]
fn the_recorded_winner_beats_its_rivals() {
    let plan =
        dual(only(&["figure", "convection_less", "hotter"], &["time_optimal", "sliding_mode"], &["fused", "enthalpy"]));
    let rows: Vec<_> = run(&plan, &|_| ()).into_iter().map(|ran| ran.row).collect();
    let places = ranking(&rows);
    let [controller, estimator, _] = WINNER;
    assert_eq!((places[0].controller.as_str(), places[0].estimator.as_str()), (controller, estimator), "{places:#?}");
}

#[test]
fn the_same_seed_gives_the_same_row_and_another_seed_another() {
    let plan = dual(only(&["figure"], &["pi"], &["enthalpy"]));
    let rows = |seed| {
        let plan = Plan { seeds: vec![seed], ..plan.clone() };
        run(&plan, &|_| ()).remove(0).row
    };
    let (a, b, other) = (rows(1), rows(1), rows(2));
    assert_eq!(a, b);
    assert_ne!(a.figures, other.figures);
}

/// The thesis' findings that hold for whatever the default is; the numbers are the findings' own.
#[test]
fn what_the_thesis_found_is_found_again() {
    let laws = [
        "sliding_mode",
        "sliding_mode_plain",
        "sliding_mode_first_order",
        "pi",
        "input_output_linearised",
        "input_output_linearised_constant",
        "velocity_servo",
    ];
    let default = Choice::default().estimator;
    let mut plan = only(&["figure", "thesis_3w", "thesis_1w", "thesis_no_feedforward"], &laws, &[]);
    let needed = |choice: &Choice| match (choice.controller.as_str(), choice.sensing.as_str()) {
        ("sliding_mode", "resistance") => choice.estimator == default,
        (_, "resistance") => false,
        ("pi", _) => true,
        _ => choice.estimator == default,
    };
    plan.choices.retain(needed);
    let ran = run(&plan, &|_| ());
    let answer = Answer::of(&plan, &ran, no_sensing(), Vec::new(), "a test".into());
    assert_eq!(answer.findings.len(), 7);
    for finding in &answer.findings {
        assert_eq!(finding.reproduced, Some(true), "{finding:#?}");
    }
}

#[test]
fn a_page_has_its_sections_and_fetches_nothing() {
    let plan = only(&["figure", "convection_less"], &["pi", "time_optimal"], &["fused"]);
    let ran = run(&plan, &|_| ());
    let answer = Answer::of(&plan, &ran, no_sensing(), Vec::new(), "sinew bench control <test>".into());
    let page = page(&answer, &ran);
    for id in [
        "ranking",
        "findings",
        "steps",
        "sines",
        "estimates",
        "misjudged",
        "joints",
        "sensing",
        "bound",
        "rows",
        "again",
    ] {
        assert!(page.contains(&format!("href=\"#{id}\"")) && page.contains(&format!("id=\"{id}\"")), "{id}");
    }
    assert!(page.contains("sinew bench control &lt;test&gt;") && !page.contains("<script") && !page.contains("http:"));
    let pictures = pictures(&answer, &ran);
    assert_eq!(pictures.len(), 3);
    for (name, svg) in pictures {
        assert!(svg.starts_with("<svg xmlns") && svg.contains("<polyline") && svg.len() < 400_000, "{name}");
    }
    // as a program reads it
    let json = serde_json::to_value(&answer).unwrap();
    let row = &json["rows"][0];
    assert!(row["controller"].is_string() && row["estimator"].is_string() && row["plant"].is_string(), "{row}");
    assert!(row["overshoot_percent"].is_number() && row["tracking"][0]["rms_percent"].is_number(), "{row}");
    assert_eq!(json["schema"], "sinew.bench.control/1");
}

#[test]
fn a_choice_that_is_refused_is_a_row_that_says_why() {
    let plant = Plant::named("figure").unwrap();
    let choice = Choice { controller: "magic".into(), ..Choice::default() };
    let (row, _) = row::row(plant, &choice, &[1], None, false);
    assert!(row.figures.is_none() && row.refused.as_deref().is_some_and(|why| why.contains("magic")), "{row:?}");
    assert_eq!(score::of_row(&row), None);
}

/// Standing in the middle of a sine leaves its RMS value; what is found has to be better, and cannot be perfect where the wire
/// cools too slowly.
#[test]
fn a_slow_sine_can_be_followed_and_a_quick_one_cannot() {
    let believed = Plant::named("figure").unwrap().believed(&Choice::default(), 1).unwrap();
    let model = &believed.channels[0].model;
    let least = |frequency_hz| {
        let course = follow::Course {
            range: StrokeRange::of(model).unwrap(),
            rest_m: model.geometry.length_m,
            middle: 0.5,
            swing: 0.25,
            frequency_hz,
            max_duty: believed.channels[0].limits.max_duty,
            inputs: model.rest_inputs(),
        };
        follow::least_error(&Wire::new(model).unwrap(), &course)
    };
    let (slow, quick) = (least(0.4), least(1.0));
    assert!(slow < 0.02 && quick > 0.04 && quick < 0.25 / 8f64.sqrt(), "{slow} {quick}");
}

/// The joint's own law on the plant the bench has for it: at 1 Hz two thin wires do what one cannot.
#[test]
fn a_pair_follows_what_a_lone_wire_cannot() {
    let plan = only(&["pair"], &["decoupling"], &[]);
    assert_eq!(plan.rows(), 1);
    let row = run(&plan, &|_| ()).remove(0).row;
    let figures = row.figures.as_ref().unwrap_or_else(|| panic!("{row:?}"));
    assert!(figures.faults.is_empty(), "{row:?}");
    assert!(figures.tracking_percent(1.0) < 0.4, "{:?}", figures.tracking);
    assert!(figures.bound_up_s.is_none(), "no bound is known for two wires");
}

/// Every law of a joint on pairs of wires: those that see the resistances alone have figures that mean something where the resistance
/// is the phase, and are lost where it is the temperature as well.
#[test]
fn the_laws_of_a_joint_are_compared() {
    let plan = only(&["pair_athermal", "pair"], &[], &[]);
    assert_eq!(plan.rows(), 2 * Choice::of_joint().len());
    for ran in run(&plan, &|_| ()) {
        let row = ran.row;
        let figures = row.figures.as_ref().unwrap_or_else(|| panic!("{row:?}"));
        assert!(figures.faults.is_empty(), "{row:?}");
        let found = figures.tracking_percent(0.25);
        match (row.controller.contains("resistance"), row.plant.as_str()) {
            (true, "pair") => assert!(found > 10.0, "{}: {found}", row.controller),
            (true, _) => assert!(found < 4.0, "{}: {found}", row.controller),
            (false, _) => assert!(found < 0.6, "{}: {found}", row.controller),
        }
    }
}
