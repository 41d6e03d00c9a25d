//! Laws that are told the state, beside the bound.

use sinew_bench::{Choice, ExactStep, Plant, exact_steps};

const STROKES: [f64; 6] = [0.4, 0.8, 0.4, 0.15, 0.3, 0.2];

fn steps(plant: &str, controller: &str) -> Vec<ExactStep> {
    let choice = Choice::default().with(Some(controller), None, None);
    exact_steps(Plant::named(plant).unwrap(), &choice, &STROKES).unwrap()
}

/// With the state known a plan settles within 1.1 times the time-optimal bound, and within the band for good. A thin wire's braking takes
/// a few periods of 1 kHz, and a load that is hardly damped rings: neither is among these.
#[test]
fn prediction_comes_near_the_bound() {
    for plant in ["figure", "rate_5khz", "load_100gf", "load_300gf", "power_1w", "spring"] {
        for step in steps(plant, "model_predictive") {
            let ratio = step.ratio().unwrap();
            // the bound may come to rest at the far edge of the band, and the law may not
            assert!((0.99..=1.11).contains(&ratio), "{plant}: {step:?}");
            assert!(step.overshoot < 0.005 && step.rms < 0.0045, "{plant}: {step:?}");
        }
    }
}

/// The bench is no judge that passes all: PI is told the same and is far off.
#[test]
fn knowing_the_state_alone_is_not_enough() {
    let worst = steps("figure", "pi").iter().filter_map(ExactStep::ratio).fold(0.0, f64::max);
    assert!(worst > 2.0, "{worst}");
}

#[test]
fn a_pair_is_refused() {
    let refused = exact_steps(Plant::named("pair").unwrap(), &Choice::default(), &STROKES).unwrap_err().to_string();
    assert!(refused.contains("pair"), "{refused}");
}
