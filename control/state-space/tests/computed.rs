//! Against what scipy and mpmath compute (`fixture.py` writes `fixture.json`).

use serde::Deserialize;
use sinew_state_space::convert::{continuous, discretise, discretise_noise};
use sinew_state_space::place::{place, place_observer};
use sinew_state_space::riccati::{care, dare, dlqe, dlqr, lqe, lqr};
use sinew_state_space::{Complex, DMatrix, eigenvalues};

type Rows = Vec<Vec<f64>>;

#[derive(Deserialize)]
struct Case {
    name: String,
    dt: f64,
    a: Rows,
    b: Rows,
    c: Rows,
    q: Rows,
    r: Rows,
    noise: Rows,
    sigma: Rows,
    ad: Rows,
    bd: Rows,
    qd: Rows,
    eigenvalues: Vec<[f64; 2]>,
    poles: Option<Vec<[f64; 2]>>,
    k_placed: Option<Rows>,
    care: Option<Rows>,
    lqr: Option<Rows>,
    dare: Option<Rows>,
    dlqr: Option<Rows>,
    observer_poles: Option<Vec<[f64; 2]>>,
    l_placed: Option<Rows>,
    lqe: Option<Rows>,
    dlqe: Option<Rows>,
}

fn matrix(rows: &Rows) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn complex(values: &[[f64; 2]]) -> Vec<Complex<f64>> {
    values.iter().map(|v| Complex::new(v[0], v[1])).collect()
}

/// Every entry to `tolerance` of itself, or of the product of its row's and column's scale where it is next to nothing.
fn close(what: &str, case: &str, found: &DMatrix<f64>, expected: &Rows, tolerance: f64) {
    let expected = matrix(expected);
    assert_eq!(found.shape(), expected.shape(), "{case}: {what}");
    for i in 0..found.nrows() {
        for j in 0..found.ncols() {
            let size = expected[(i, j)].abs().max(1e-6 * expected.row(i).amax().max(expected.column(j).amax()));
            let error = (found[(i, j)] - expected[(i, j)]).abs();
            assert!(error <= tolerance * size, "{case}: {what} at {i}, {j}: {found} expected {expected}");
        }
    }
}

fn cases() -> Vec<Case> {
    serde_json::from_str(include_str!("fixture.json")).unwrap()
}

#[test]
fn conversions() {
    for case in cases() {
        let (a, b) = (matrix(&case.a), matrix(&case.b));
        let (ad, bd) = discretise(&a, &b, case.dt).unwrap();
        close("ad", &case.name, &ad, &case.ad, 1e-11);
        close("bd", &case.name, &bd, &case.bd, 1e-11);
        let qd = discretise_noise(&a, &matrix(&case.noise), case.dt).unwrap();
        close("qd", &case.name, &qd, &case.qd, 1e-9);
        let (ac, bc) = continuous(&matrix(&case.ad), &matrix(&case.bd), case.dt).unwrap();
        let back = (ac - &a).norm() / a.norm();
        assert!(back < 1e-9 && (bc - &b).norm() < 1e-9 * b.norm(), "{}: {back}", case.name);
        let found = eigenvalues(&a).unwrap();
        for wanted in complex(&case.eigenvalues) {
            let nearest = found.iter().map(|v| (v - wanted).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9 * (1.0 + wanted.norm()), "{}: {wanted} among {found:?}", case.name);
        }
    }
}

#[test]
fn gains_of_controllers() {
    let mut count = 0;
    for case in cases() {
        let Some(poles) = &case.poles else { continue };
        let (a, b, q, r) = (matrix(&case.a), matrix(&case.b), matrix(&case.q), matrix(&case.r));
        let (ad, bd) = (matrix(&case.ad), matrix(&case.bd));
        let name = &case.name;
        close("k", name, &place(&a, &b, &complex(poles)).unwrap(), case.k_placed.as_ref().unwrap(), 1e-9);
        close("care", name, &care(&a, &b, &q, &r).unwrap(), case.care.as_ref().unwrap(), 1e-9);
        close("lqr", name, &lqr(&a, &b, &q, &r).unwrap(), case.lqr.as_ref().unwrap(), 1e-9);
        close("dare", name, &dare(&ad, &bd, &q, &r).unwrap(), case.dare.as_ref().unwrap(), 1e-9);
        close("dlqr", name, &dlqr(&ad, &bd, &q, &r).unwrap(), case.dlqr.as_ref().unwrap(), 1e-9);
        count += 1;
    }
    assert!(count >= 6);
}

#[test]
fn gains_of_observers() {
    let mut count = 0;
    for case in cases() {
        let Some(poles) = &case.observer_poles else { continue };
        let (a, c, noise, sigma) = (matrix(&case.a), matrix(&case.c), matrix(&case.noise), matrix(&case.sigma));
        let (ad, qd) = (matrix(&case.ad), matrix(&case.qd));
        let name = &case.name;
        close("l", name, &place_observer(&a, &c, &complex(poles)).unwrap(), case.l_placed.as_ref().unwrap(), 1e-9);
        close("lqe", name, &lqe(&a, &c, &noise, &sigma).unwrap(), case.lqe.as_ref().unwrap(), 1e-9);
        close("dlqe", name, &dlqe(&ad, &c, &qd, &sigma).unwrap(), case.dlqe.as_ref().unwrap(), 1e-9);
        count += 1;
    }
    assert!(count >= 7);
}
