//! Strain over temperature: a whole cycle under constant force (ASTM E3097), or the heating after a strain that was given cold (F2082 where
//! it was bent, E3098 where it was pulled).

use serde::Serialize;

use crate::branch::{Branch, Stretch};
use crate::error::Error;
use crate::transition::{Transition, transition};

/// A cycle under constant force: what E3097 has reported. Strains in the unit they came in.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ThermalCycle {
    /// A_s and A_f.
    pub heating: Transition,
    /// M_s and M_f.
    pub cooling: Transition,
    /// Strain at the upper end of the cycle, hot.
    pub strain_at_uct: f64,
    /// Strain at its lower end before heating, and after cooling.
    pub strain_at_lct: [f64; 2],
    /// What heating took back: from the lower end of the cycle to its upper end.
    pub actuation_strain: f64,
    /// Of it, what the transformation on heating took back, between the base lines.
    pub transformation_strain: f64,
    /// What is left at the lower end after a cycle that was not there before: after cooling less before heating where the cycle heats first; 0
    /// where it cools first.
    pub residual_strain: f64,
    /// Between the middles of both transformations, K.
    pub hysteresis_width_k: f64,
    /// From M_f to A_f, K.
    pub transformation_span_k: f64,
}

/// The figures of a cycle: temperatures in °C and strains, in the order they were measured in; heating first or cooling first.
///
/// # Errors
/// What the curve lacks, and where it would have to be measured.
pub fn thermal_cycle(temperature_c: &[f64], strain: &[f64]) -> Result<ThermalCycle, Error> {
    let up = Branch::of(temperature_c, strain, Stretch::Heating)?;
    let down = Branch::of(temperature_c, strain, Stretch::Cooling)?;
    let (heating, cooling) = (transition(&up)?, transition(&down)?);
    let heats_first = up.from <= down.from;
    let [before, after] = [&up, &down].map(|branch| end(branch, true));
    let strain_at_uct = end(&up, false);
    Ok(ThermalCycle {
        heating,
        cooling,
        strain_at_uct,
        strain_at_lct: [before, after],
        actuation_strain: before - strain_at_uct,
        transformation_strain: heating.step.abs(),
        residual_strain: if heats_first { after - before } else { 0.0 },
        hysteresis_width_k: heating.middle_c() - cooling.middle_c(),
        transformation_span_k: heating.finish_c.value - cooling.finish_c.value,
    })
}

/// A strain that was given cold and goes back on heating.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Recovery {
    /// A_s and A_f, by tangents.
    pub heating: Transition,
    /// Before heating, in the curve's unit.
    pub before: f64,
    /// At its end.
    pub after: f64,
    /// What went back.
    pub recovered: f64,
}

/// The figures of heating after a strain, a bend or a deflection that was given cold.
///
/// # Errors
/// As [`thermal_cycle`].
pub fn recovery(temperature_c: &[f64], strain: &[f64]) -> Result<Recovery, Error> {
    let up = Branch::of(temperature_c, strain, Stretch::Heating)?;
    let (before, after) = (end(&up, true), end(&up, false));
    Ok(Recovery { heating: transition(&up)?, before, after, recovered: before - after })
}

/// The mean of a branch's last samples at its cold or its hot end: one of fifty, three at least.
fn end(branch: &Branch, is_cold: bool) -> f64 {
    let count = (branch.points.len() / 50).max(3).min(branch.points.len());
    let points = if is_cold { &branch.points[..count] } else { &branch.points[branch.points.len() - count..] };
    points.iter().map(|(_, y)| y).sum::<f64>() / count as f64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::STRAIN_SPAN;

    fn logistic(k: f64, x: f64) -> f64 {
        1.0 / (1.0 + (k * x).exp())
    }

    /// A cycle along logistic curves with thermal expansion, sampled so often, from −40 to 160 °C and back.
    fn cycle(k: f64, a: f64, m: f64, strain: f64, step_k: f64) -> (Vec<f64>, Vec<f64>) {
        let count = (200.0 / step_k) as usize;
        let up = (0..=count).map(|i| -40.0 + step_k * i as f64);
        let of = move |t: f64, centre: f64| 0.001 + 1e-5 * (t - 20.0) + strain * logistic(k, t - centre);
        let up_then = up.clone().map(move |t| (t, of(t, a)));
        up_then.chain(up.rev().map(move |t| (t, of(t, m)))).unzip()
    }

    /// The tangent of a logistic curve at its middle meets the base lines 2/k before and after it.
    #[test]
    fn tangents_of_logistic_curves_are_where_closed_form_says() {
        let (t, strain) = cycle(0.31, 93.0, 67.0, 0.04, 0.25);
        let found = thermal_cycle(&t, &strain).expect("a whole cycle");
        let near = |found: f64, expected: f64, within: f64| {
            assert!((found - expected).abs() < within, "{found}, not {expected}")
        };
        near(found.heating.start_c.value, 93.0 - 0.5 * STRAIN_SPAN / 0.31, 0.3);
        near(found.heating.finish_c.value, 93.0 + 0.5 * STRAIN_SPAN / 0.31, 0.3);
        near(found.cooling.start_c.value, 67.0 + 0.5 * STRAIN_SPAN / 0.31, 0.3);
        near(found.cooling.finish_c.value, 67.0 - 0.5 * STRAIN_SPAN / 0.31, 0.3);
        near(found.hysteresis_width_k, 26.0, 0.05);
        near(found.transformation_span_k, 26.0 + STRAIN_SPAN / 0.31, 0.4);
        near(found.transformation_strain, 0.04, 4e-4);
        near(found.actuation_strain, 0.04 - 200e-5, 2e-4);
        near(found.residual_strain, 0.0, 1e-6);
        assert!(found.heating.start_c.by_choice < 1.0, "{:?}", found.heating);
    }

    #[test]
    fn a_cycle_may_begin_hot_and_need_not_be_whole() {
        let (mut t, mut strain) = cycle(0.31, 93.0, 67.0, 0.04, 0.25);
        let half = t.len() / 2;
        t.rotate_left(half);
        strain.rotate_left(half);
        let turned = thermal_cycle(&t, &strain).expect("cooled first");
        assert!((turned.heating.middle_c() - 93.0).abs() < 0.05 && turned.residual_strain == 0.0);
        // ends before it is all austenite
        let keep = t.iter().map(|t| *t < 98.0).collect::<Vec<_>>();
        let short = |values: &[f64]| values.iter().zip(&keep).filter(|(_, k)| **k).map(|(v, _)| *v).collect::<Vec<_>>();
        let error = thermal_cycle(&short(&t), &short(&strain)).expect_err("no base line");
        assert!(error.to_string().contains("after the transformation on heating"), "{error}");
    }

    #[test]
    fn a_straight_line_has_no_transformation() {
        let t: Vec<f64> = (0..200).map(f64::from).chain((0..200).rev().map(f64::from)).collect();
        let strain: Vec<f64> = t.iter().map(|t| 1e-5 * t).collect();
        assert!(thermal_cycle(&t, &strain).is_err());
    }

    /// A column of a CSV file by its name.
    fn column(text: &str, name: &str) -> Vec<f64> {
        let place =
            text.lines().next().and_then(|header| header.split(',').position(|column| column == name)).expect(name);
        text.lines().skip(1).filter_map(|line| line.split(',').nth(place)?.parse().ok()).collect()
    }

    /// Furnace loops of real alloys. Nobody knows their true figures, but what must hold of any: M_f < M_s < A_f, A_s < A_f, start and
    /// finish as more stress has them, higher, and no more strain than there is.
    #[test]
    fn loops_of_real_alloys_are_read_and_stress_shifts_them_upwards() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
        if !folder.exists() {
            eprintln!("skipped: {} is not there", folder.display());
            return;
        }
        for files in [
            ["isobaric-flexinol/50mpa.csv", "isobaric-flexinol/150mpa.csv", "isobaric-flexinol/200mpa.csv"],
            ["isobaric-nitihf/7mpa.csv", "isobaric-nitihf/100mpa.csv", "isobaric-nitihf/300mpa.csv"],
        ] {
            let cycles = files.map(|file| {
                let text = std::fs::read_to_string(folder.join(file)).expect("the file");
                let strain: Vec<f64> = column(&text, "position_m").iter().map(|x| x / 0.1).collect();
                let cycle =
                    thermal_cycle(&column(&text, "temperature_c"), &strain).unwrap_or_else(|e| panic!("{file}: {e}"));
                let ThermalCycle { heating, cooling, .. } = cycle;
                assert!(
                    cooling.finish_c.value < cooling.start_c.value && heating.start_c.value < heating.finish_c.value,
                    "{file}: {cycle:?}"
                );
                assert!(
                    cooling.start_c.value < heating.finish_c.value && cycle.hysteresis_width_k > 10.0,
                    "{file}: {cycle:?}"
                );
                assert!(
                    cycle.transformation_strain > 0.5 * cycle.actuation_strain.abs()
                        && cycle.transformation_strain < 0.05,
                    "{file}: {cycle:?}"
                );
                cycle
            });
            assert!(
                cycles.windows(2).all(|pair| pair[0].cooling.middle_c() < pair[1].cooling.middle_c()),
                "{files:?}: {cycles:?}"
            );
        }
    }

    proptest! {
        /// Noise of a hundredth of the strain moves the middles by less than a kelvin, whatever the curve.
        #[test]
        fn noise_moves_little(k in 0.15f64..0.6, a in 80.0f64..100.0, width in 15.0f64..30.0, seed in 0u64..1000) {
            let (t, mut strain) = cycle(k, a, a - width, 0.04, 0.25);
            let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(1);
            for value in &mut strain {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                *value += 0.04 * 0.01 * ((state >> 40) as f64 / f64::from(1 << 24) - 0.5) * 3.46;
            }
            let found = thermal_cycle(&t, &strain).expect("a whole cycle");
            prop_assert!((found.heating.middle_c() - a).abs() < 1.0, "{found:?}");
            prop_assert!((found.cooling.middle_c() - a + width).abs() < 1.0, "{found:?}");
            prop_assert!((found.heating.span_k() / (STRAIN_SPAN / k) - 1.0).abs() < 0.25, "{found:?}");
        }

        /// Whatever numbers come, there is an answer or an error.
        #[test]
        fn nothing_panics(t in prop::collection::vec(prop::num::f64::ANY, 0..80), y in prop::collection::vec(prop::num::f64::ANY, 0..80)) {
            let _ = thermal_cycle(&t, &y);
            let _ = recovery(&t, &y);
            let _ = crate::calorimetry(&t, &y);
            let _ = crate::tension(&t, &y);
        }
    }
}
