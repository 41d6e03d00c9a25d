//! A wire that is broken in: after how many cycles it no longer moved, and how far it had by then.

use super::finding::{Estimate, Finding};
use super::run::Run;
use crate::settling::{IN_A_ROW, Settling};
use crate::stage::Part;

/// Every whole cycle of a run, as the routine saw them.
fn seen(run: &Run<'_>) -> Settling {
    let mut settling = Settling::new(run.options.tolerance, run.model, run.spec.rate_hz);
    for (_, rows) in run.stretches().filter(|(stage, _)| matches!(stage.part, Part::Cycle { .. })) {
        rows.iter().for_each(|row| settling.see(row.reading.position_m, row.directive.heat));
        settling.ends_cycle();
    }
    settling
}

/// Every number of a run.
pub fn findings(run: &Run<'_>) -> Vec<Finding> {
    let (settling, tolerance) = (seen(run), &run.options.tolerance);
    let cycles = settling.cycles();
    // counted, not estimated
    let exact = |value: f64| Estimate { value, sigma: f64::NAN };
    let took = match settling.settled_after() {
        Some(count) => Ok(exact(count as f64)),
        None => Err(format!("it still moves after {} cycles: go on with more, or be content with less", cycles.len())),
    };
    let how = format!(
        "the first of {IN_A_ROW} in a row that are like the one before to {} % of strain and {} K",
        sinew_plot::quantity::number(100.0 * tolerance.strain),
        sinew_plot::quantity::number(tolerance.kelvin)
    );
    let mut findings = vec![
        Finding::from("cycles_to_settle", "Cycles until it had settled", "1", "", &took, how),
        Finding::new("cycles", "Cycles in all", "1", "", exact(cycles.len() as f64), "whole ones"),
    ];
    let (Some(first), Some(last)) = (cycles.first(), cycles.last()) else { return findings };
    let mut moved = |key: &'static str, name: &'static str, unit: &'static str, by: f64, how: &str| {
        findings.push(Finding::new(key, name, unit, "", exact(by), how));
    };
    let ends = "last cycle less the first";
    moved("cold_moved_percent", "Strain of the cold wire moved", "%", 100.0 * (last.cold - first.cold), ends);
    moved("hot_moved_percent", "Strain of the hot wire moved", "%", 100.0 * (last.hot - first.hot), ends);
    let halves = "where half of the way is done, reckoned from the power; last cycle less the first";
    moved("heating_moved_k", "Transformation on heating moved", "K", last.up_k - first.up_k, halves);
    moved("cooling_moved_k", "Transformation on cooling moved", "K", last.down_k - first.down_k, halves);
    let stroke = (last.cold - last.hot) * run.model.geometry.length_m * 1e3;
    moved("stroke_mm", "Stroke it has now", "mm", stroke, "of the last cycle");
    findings
}
