//! Stress over strain of superelastic material (ASTM F2516): pulled over its plateau, let go, and perhaps pulled again until it breaks.

use serde::Serialize;

use crate::error::Error;

/// Strain from which the upper plateau's strength is read while loading.
pub const UPPER_PLATEAU_AT: f64 = 0.03;
/// Strain at which that of the lower plateau is read while unloading.
pub const LOWER_PLATEAU_AT: f64 = 0.025;
/// Stress at which strains begin to count and what stays is read, Pa.
pub const PRELOAD_PA: f64 = 7e6;

/// Fewest samples.
const LEAST_ROWS: usize = 20;
/// A strain that falls so far behind its largest is let go.
const LET_GO: f64 = 0.003;

/// What is read off a tension test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tension {
    /// UPS: stress at 3 % of strain while loading, Pa.
    pub upper_plateau_pa: f64,
    /// LPS: stress at 2.5 % while unloading, Pa; none where it was not let go.
    pub lower_plateau_pa: Option<f64>,
    /// El_r: strain at 7 MPa while unloading, counted from the same stress while loading.
    pub residual_elongation: Option<f64>,
    /// The largest strain before it was let go.
    pub strained_to: f64,
    /// UTS: the largest stress of a second pull, Pa; none where there is none.
    pub tensile_strength_pa: Option<f64>,
    /// El_u: strain at the largest stress.
    pub uniform_elongation: Option<f64>,
}

/// The figures of a tension test, strains as shares, stresses in Pa, in the order they were measured in.
///
/// # Errors
/// What the test lacks.
pub fn tension(strain: &[f64], stress_pa: &[f64]) -> Result<Tension, Error> {
    let rows: Vec<(f64, f64)> =
        strain.iter().copied().zip(stress_pa.iter().copied()).filter(|(e, s)| e.is_finite() && s.is_finite()).collect();
    if rows.len() < LEAST_ROWS || strain.len() != stress_pa.len() {
        return Err(Error::Short { found: rows.len().min(stress_pa.len()), least: LEAST_ROWS });
    }
    let top = first_top(&rows);
    let (pulled, rest) = rows.split_at(top + 1);
    // where it is taut its strain begins
    let zero = crossing(pulled.iter().map(|(e, s)| (*s, *e)), PRELOAD_PA).unwrap_or(pulled[0].0);
    let needed = UPPER_PLATEAU_AT;
    let strained_to = rows[top].0 - zero;
    let upper_plateau_pa = crossing(pulled.iter().map(|(e, s)| (e - zero, *s)), needed)
        .ok_or(Error::LittleStrain { found: strained_to, needed })?;
    if rest.is_empty() {
        return Ok(Tension {
            upper_plateau_pa,
            lower_plateau_pa: None,
            residual_elongation: None,
            strained_to,
            tensile_strength_pa: None,
            uniform_elongation: None,
        });
    }
    let least = rest.iter().enumerate().min_by(|a, b| a.1.0.total_cmp(&b.1.0)).map_or(0, |(i, _)| i);
    let (released, again) = rest.split_at(least + 1);
    let residual = crossing(released.iter().map(|(e, s)| (*s, e - zero)), PRELOAD_PA);
    let lowest_pa = released.iter().map(|(_, s)| *s).fold(f64::INFINITY, f64::min);
    let residual = residual.ok_or(Error::NotUnloaded { found_pa: lowest_pa, needed_pa: PRELOAD_PA })?;
    let lower_plateau_pa = crossing(released.iter().map(|(e, s)| (e - zero, *s)), LOWER_PLATEAU_AT);
    let strongest = again.iter().copied().filter(|(e, _)| e - zero > strained_to).max_by(|a, b| a.1.total_cmp(&b.1));
    Ok(Tension {
        upper_plateau_pa,
        lower_plateau_pa,
        residual_elongation: Some(residual),
        strained_to,
        tensile_strength_pa: strongest.map(|(_, s)| s),
        uniform_elongation: strongest.map(|(e, _)| e - zero),
    })
}

/// Where the strain is largest before it is let go.
fn first_top(rows: &[(f64, f64)]) -> usize {
    let mut top = 0;
    for (i, (strain, _)) in rows.iter().enumerate() {
        if *strain > rows[top].0 {
            top = i;
        } else if rows[top].0 - strain > LET_GO {
            break;
        }
    }
    top
}

/// y where x first passes `at`, between two samples.
fn crossing(points: impl Iterator<Item = (f64, f64)>, at: f64) -> Option<f64> {
    let mut before: Option<(f64, f64)> = None;
    for (x, y) in points {
        if let Some((x0, y0)) = before
            && (x0 - at) * (x - at) <= 0.0
            && x != x0
        {
            return Some(y0 + (y - y0) * (at - x0) / (x - x0));
        }
        before = Some((x, y));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Elastic to 500 MPa, a plateau with a slope, down at 200 MPa, 0.1 % stays; then on to 1200 MPa at 12 %.
    fn pulled() -> Vec<(f64, f64)> {
        let corners = [
            (0.0, 0.0),
            (0.01, 500e6),
            (0.06, 520e6),
            (0.053, 200e6),
            (0.0045, 190e6),
            (0.001, 0.0),
            (0.0112, 500e6),
            (0.06, 520e6),
            (0.12, 1200e6),
            (0.13, 1150e6),
        ];
        let mut rows = Vec::new();
        for pair in corners.windows(2) {
            for i in 0..100 {
                let s = f64::from(i) / 100.0;
                rows.push((pair[0].0 + s * (pair[1].0 - pair[0].0), pair[0].1 + s * (pair[1].1 - pair[0].1)));
            }
        }
        rows
    }

    fn of(rows: &[(f64, f64)]) -> Result<Tension, Error> {
        let (strain, stress): (Vec<f64>, Vec<f64>) = rows.iter().copied().unzip();
        tension(&strain, &stress)
    }

    #[test]
    fn plateaus_are_read_where_the_standard_has_them() {
        let found = of(&pulled()).expect("a whole test");
        // counted from 7 MPa, which are 0.014 %
        let zero = 7e6 / 500e6 * 0.01;
        let near =
            |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-3, "{found}, not {expected}");
        near(found.upper_plateau_pa, 500e6 + 20e6 * (0.03 + zero - 0.01) / 0.05);
        let lower_pa = found.lower_plateau_pa.expect("it is let go");
        near(lower_pa, 200e6 - 10e6 * (0.053 - 0.025 - zero) / (0.053 - 0.0045));
        near(found.residual_elongation.expect("it is let go"), 0.001 + 0.0035 * 7.0 / 190.0 - zero);
        near(found.tensile_strength_pa.expect("pulled again"), 1200e6);
        near(found.uniform_elongation.expect("pulled again"), 0.12 - zero);
    }

    #[test]
    fn what_a_test_lacks_is_said() {
        let rows = pulled();
        let error = of(&rows[..180]).expect("loaded only to 5 %");
        assert_eq!((error.lower_plateau_pa, error.residual_elongation), (None, None));
        assert!(matches!(of(&rows[..90]), Err(Error::LittleStrain { .. })));
        assert!(matches!(of(&rows[..330]), Err(Error::NotUnloaded { .. })));
        assert!(matches!(of(&rows[..5]), Err(Error::Short { .. })));
    }
}
