//! `sinew identify`: the same physics with the parameters that fit best, each with its interval.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sinew_diagnosis::{FittedParameter, Identified, MeasuredParameter, Stages};
use sinew_material::{Error, Temperature, Temperatures};
use sinew_physics::{DriveKind, Load};
use sinew_recording::Column;

use super::dsc::{Curve, Curves};
use super::fitting::{Input, spare_inputs, warn, work};
use crate::args;
use crate::failure::Outcome;
use crate::output;
use crate::table::{columns, number};

/// So many σ of its prior from the rig file's value, a parameter is worth a mark.
const FAR_SIGMA: f64 = 2.0;

/// Runs the command.
pub fn identify(args: &args::Identify) -> Outcome {
    let fitting = &args.fitting;
    let to_stdout = args.output == Path::new("-");
    let input = Input::read(fitting, &[])?;
    if !to_stdout {
        output::has_place(&args.output)?;
        spare_inputs(&args.output, fitting, fitting.recordings.iter().chain(&args.dsc))?;
    }
    let curves = Curves::read(args, &input.rig, input.channel)?;
    let measured = curves.as_ref().map(|curves| &curves.measured);
    let mut identified = work(fitting, |settings| {
        sinew_diagnosis::identify(&input.rig, input.channel, &input.recordings, measured, settings)
    })?;
    identified.warnings.extend(curves.iter().flat_map(Curves::warnings));
    let temperatures = named_temperatures(&input, &mut identified);
    let fitted = identified.rig.to_toml();
    let answer = match fitting.json {
        true => output::json(&Answer::of(&input, &identified, curves.as_ref(), &temperatures, fitting.seed))? + "\n",
        false => table(&identified, curves.as_ref(), &temperatures),
    };
    if to_stdout {
        output::note(answer.trim_end());
        output::print(fitted)?;
    } else {
        output::write_file(&args.output, &fitted)?;
        output::print(answer)?;
        output::note(format_args!("written: {}", args.output.display()));
    }
    warn(&identified.warnings);
    Ok(())
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    rig: &'a str,
    channel: &'a str,
    recordings: Vec<&'a str>,
    seed: u64,
    noise: &'a BTreeMap<String, f64>,
    fit: &'a Stages,
    parameters: &'a BTreeMap<String, FittedParameter>,
    /// What was measured elsewhere, by key.
    measured: &'a BTreeMap<String, MeasuredParameter>,
    calorimetry: &'a [Curve],
    temperatures: &'a [Temperatures],
    warnings: &'a [String],
}

impl<'a> Answer<'a> {
    fn of(
        input: &'a Input,
        identified: &'a Identified,
        curves: Option<&'a Curves>,
        temperatures: &'a [Temperatures],
        seed: u64,
    ) -> Answer<'a> {
        Answer {
            schema: "sinew.identify/1",
            rig: &input.rig.name,
            channel: input.channel_name(),
            recordings: input.recordings.iter().map(|r| r.name()).collect(),
            seed,
            noise: &identified.noise,
            fit: &identified.fit,
            parameters: &identified.parameters,
            measured: &identified.measured,
            calorimetry: curves.map_or(&[], |curves| &curves.each),
            temperatures,
            warnings: &identified.warnings,
        }
    }
}

/// The parameters with their intervals, how well each sensor is met, what calorimeters said, and the temperatures as the standards name them.
fn table(identified: &Identified, curves: Option<&Curves>, temperatures: &[Temperatures]) -> String {
    let mut parts = vec![parameters_table(identified)];
    if !identified.noise.is_empty() {
        parts.push(sensors_table(identified));
    }
    parts.extend(curves.map(|curves| curves.table(&identified.measured)));
    if !temperatures.is_empty() {
        parts.push(temperatures_table(temperatures));
    }
    parts.join("\n")
}

/// A force that stays within this share of its middle is a constant one; loops whose stresses are nearer to each other than this, Pa, are
/// under the same.
const ISOBARIC: f64 = 0.15;
const SAME_STRESS_PA: f64 = 1e6;

/// The transformation temperatures of the fitted model without stress, and under that of each recording that is a loop under a constant one.
fn named_temperatures(input: &Input, identified: &mut Identified) -> Vec<Temperatures> {
    let model = &input.rig.channels[input.channel].model;
    let mut stresses_pa = vec![0.0];
    if model.drive.kind == DriveKind::Temperature && model.load == Load::ImposedForce {
        for force_n in input.recordings.iter().filter_map(|recording| recording.get(Column::ForceN)) {
            let mut sorted: Vec<f64> = force_n.iter().copied().filter(|n| n.is_finite()).collect();
            sorted.sort_by(f64::total_cmp);
            let at = |share: f64| sorted.get((share * sorted.len() as f64) as usize).copied().unwrap_or(f64::NAN);
            let (low, middle, high) = (at(0.05), at(0.5), at(0.95));
            let stress_pa = middle / model.geometry.area_m2();
            let is_new = stresses_pa.iter().all(|known: &f64| (known - stress_pa).abs() > SAME_STRESS_PA);
            if is_new && high - low < 2.0 * ISOBARIC * middle {
                stresses_pa.push(stress_pa);
            }
        }
    }
    stresses_pa.sort_by(f64::total_cmp);
    let mut found = Vec::new();
    for stress_pa in stresses_pa {
        match sinew_material::temperatures(&identified.rig, input.channel, &identified.parameters, stress_pa) {
            Ok(temperatures) => found.push(temperatures),
            Err(error) => {
                let why = match error {
                    Error::Curve(_) => "has curves too gentle for tangents and base lines beside them".to_string(),
                    error => error.to_string(),
                };
                let mpa = 1e-6 * stress_pa;
                identified.warnings.push(format!("no A_s, A_f, M_s and M_f at {mpa:.0} MPa: the fitted model {why}"));
            }
        }
    }
    found
}

/// A_s, A_f, M_s and M_f with their intervals.
fn temperatures_table(temperatures: &[Temperatures]) -> String {
    let of = |t: Temperature| format!("{:.1} ({:.1} to {:.1})", t.value_c, t.low_c, t.high_c);
    let rows = temperatures.iter().map(|t| {
        let by = format!("{}, {:.0} MPa", t.standard, 1e-6 * t.stress_pa);
        [by, of(t.austenite_start), of(t.austenite_finish), of(t.martensite_start), of(t.martensite_finish)]
    });
    let head = ["temperatures, °C, 90 % interval", "A_s", "A_f", "M_s", "M_f"];
    columns(std::iter::once(head.map(String::from)).chain(rows).collect())
}

/// The parameters with their intervals.
pub fn parameters_table(identified: &Identified) -> String {
    let rows = identified.parameters.iter().map(|(key, p)| {
        let sigmas = (p.value - p.given) / p.prior_sigma;
        let far = if sigmas.abs() > FAR_SIGMA { " !" } else { "" };
        let moved = if sigmas.is_finite() { format!("{sigmas:+.1}{far}") } else { String::new() };
        let interval = format!("{} to {}", number(p.low), number(p.high));
        let prior = if p.prior_sigma.is_finite() { number(p.prior_sigma) } else { String::new() };
        [key.clone(), number(p.given), number(p.value), interval, prior, moved, p.unit.clone()]
    });
    let head = ["parameter", "given", "fitted", "90 % interval", "prior 1 σ", "moved, σ", "unit"];
    columns(std::iter::once(head.map(String::from)).chain(rows).collect())
}

/// How well each sensor is met.
fn sensors_table(identified: &Identified) -> String {
    let (given, fitted) = (&identified.fit.as_given, &identified.fit.recalibrated);
    let rows = fitted.iter().map(|(column, after)| {
        let before = given.get(column);
        let noise = identified.noise.get(column).copied().unwrap_or(f64::NAN);
        let of = |chi: Option<f64>| chi.map_or(String::new(), |chi| format!("{chi:.2}"));
        [column.clone(), of(before.map(|m| m.chi)), of(Some(after.chi)), number(after.rmse), number(noise)]
    });
    let head = ["sensor", "chi as given", "chi fitted", "error, RMS", "noise, RMS"];
    columns(std::iter::once(head.map(String::from)).chain(rows).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_diagnosis::Misfit;

    #[test]
    fn the_table_says_what_moved_and_how_far() {
        let parameter = FittedParameter {
            given: 121.2,
            value: 60.0,
            low: 55.0,
            high: 65.5,
            unit: "W/(m² K)".into(),
            prior_sigma: 24.24,
        };
        let misfit = |chi: f64| BTreeMap::from([("position_m".to_string(), Misfit { rmse: 1.5e-5 * chi, chi })]);
        let identified = Identified {
            rig: sinew_rig::Rig::hexapod(),
            parameters: BTreeMap::from([("convection_w_per_m2_k".to_string(), parameter)]),
            noise: BTreeMap::from([("position_m".to_string(), 1.5e-5)]),
            fit: Stages { as_given: misfit(66.0), recalibrated: misfit(1.01), improved: BTreeMap::new() },
            measured: BTreeMap::new(),
            warnings: Vec::new(),
        };
        let text = table(&identified, None, &[]);
        let lines: Vec<&str> = text.lines().collect();
        let cells: Vec<&str> = lines[1].split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let expected = ["convection_w_per_m2_k", "121.2", "60", "55 to 65.5", "24.24", "-2.5 !", "W/(m² K)"];
        assert_eq!(cells, expected, "{text}");
        assert!(lines[4].contains("66.00") && lines[4].contains("1.01") && lines[4].contains("1.50e-5"), "{text}");
        // every line's columns end where the head's do
        assert_eq!(lines[0].find("fitted").map(|i| i + 6), lines[1].find("60 ").map(|i| i + 2), "{text}");
    }
}
