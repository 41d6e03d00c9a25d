//! The catalogue against the contract: ids, switches, nulls, shapes, ranges.

use sinew_physics::Error;
use sinew_physics::effects::{Home, Nature, Role, catalogue};

use super::common::hanging;
use super::explicit::CONTRACT;

#[test]
fn the_catalogue_is_that_of_the_contract() {
    let model = hanging();
    let mechanisms: Vec<_> = catalogue().filter(|e| matches!(e.nature, Nature::Mechanism | Nature::Shape)).collect();
    assert_eq!(mechanisms.len(), CONTRACT.len());
    for (row, (id, switches, shapes)) in mechanisms.iter().zip(CONTRACT) {
        assert_eq!(row.id, *id);
        assert_eq!(row.equation.name(), id.split('.').next().unwrap());
        let found: Vec<_> =
            row.parameters.iter().filter(|p| p.is_switch()).map(|p| (p.key, p.null(&model).unwrap())).collect();
        assert_eq!(found, *switches, "{id}");
        let found: Vec<_> =
            row.parameters.iter().filter(|p| !matches!(p.role, Role::Switch { .. })).map(|p| p.key).collect();
        assert_eq!(found, *shapes, "{id}");
    }
    let empirical: Vec<_> = catalogue().filter(|e| e.nature == Nature::Empirical).map(|e| e.id).collect();
    let equations = ["thermal", "electrical", "kinetic", "mechanical", "load", "position", "voltage"];
    assert_eq!(empirical, equations.map(|e| format!("empirical.{e}")));
}

#[test]
fn every_parameter_comes_back_as_it_was_set_and_is_checked() {
    for row in catalogue() {
        for p in row.parameters {
            assert!(
                p.low <= p.plausible.0 && p.plausible.0 < p.plausible.1 && p.plausible.1 <= p.high,
                "{} {}",
                row.id,
                p.key
            );
            let mut m = hanging();
            row.set_null(&mut m);
            assert!(row.is_null(&m), "{} {}", row.id, p.key);
            for value in [p.plausible.0, p.plausible.1] {
                p.set(&mut m, value);
                assert!((p.get(&m) - value).abs() <= 1e-12 * value.abs());
            }
            assert_eq!(row.is_null(&m), !p.is_switch(), "{} {}", row.id, p.key);
            row.set_null(&mut m);
            assert!(row.is_null(&m));
            if row.home == Home::Table {
                // on, then out of range
                for other in row.parameters {
                    other.set(&mut m, other.plausible.1);
                }
                m.validate().unwrap_or_else(|e| panic!("{e}"));
                for wrong in [p.high + 1.0 + p.high.abs(), f64::NAN] {
                    p.set(&mut m, wrong);
                    let Err(Error::OutOfRange { key, .. }) = m.validate() else { panic!("{} {}", row.id, p.key) };
                    assert_eq!(key, format!("{}.{}", row.id, p.key));
                }
            }
        }
    }
}
