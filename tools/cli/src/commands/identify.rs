//! `sinew identify`: the same physics with the parameters that fit best, each with its interval.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;
use sinew_diagnosis::{FittedParameter, Identified, Stages};

use super::fitting::{Input, spare_inputs, warn, work};
use crate::args;
use crate::failure::Outcome;
use crate::output;

/// So many σ of its prior from the rig file's value, a parameter is worth a mark.
const FAR_SIGMA: f64 = 2.0;

/// Runs the command.
pub fn identify(args: &args::Identify) -> Outcome {
    let fitting = &args.fitting;
    let to_stdout = args.output == Path::new("-");
    let input = Input::read(fitting, &[])?;
    if !to_stdout {
        output::has_place(&args.output)?;
        spare_inputs(&args.output, fitting, fitting.recordings.iter())?;
    }
    let identified =
        work(fitting, |settings| sinew_diagnosis::identify(&input.rig, input.channel, &input.recordings, settings))?;
    let fitted = identified.rig.to_toml();
    let answer = match fitting.json {
        true => output::json(&Answer::of(&input, &identified, fitting.seed))? + "\n",
        false => table(&identified),
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
    warnings: &'a [String],
}

impl<'a> Answer<'a> {
    fn of(input: &'a Input, identified: &'a Identified, seed: u64) -> Answer<'a> {
        Answer {
            schema: "sinew.identify/1",
            rig: &input.rig.name,
            channel: input.channel_name(),
            recordings: input.recordings.iter().map(|r| r.name()).collect(),
            seed,
            noise: &identified.noise,
            fit: &identified.fit,
            parameters: &identified.parameters,
            warnings: &identified.warnings,
        }
    }
}

/// The parameters with their intervals, then how well each sensor is met.
fn table(identified: &Identified) -> String {
    format!("{}\n{}", parameters_table(identified), sensors_table(identified))
}

/// The parameters with their intervals.
pub fn parameters_table(identified: &Identified) -> String {
    let rows = identified.parameters.iter().map(|(key, p)| {
        let sigmas = (p.value - p.given) / p.prior_sigma;
        let far = if sigmas.abs() > FAR_SIGMA { " !" } else { "" };
        let moved = if sigmas.is_finite() { format!("{sigmas:+.1}{far}") } else { String::new() };
        let interval = format!("{} to {}", number(p.low), number(p.high));
        [key.clone(), number(p.given), number(p.value), interval, number(p.prior_sigma), moved, p.unit.clone()]
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

/// Rows of cells as lines, the first column to the left, the last as it is, the others to the right.
pub fn columns<const N: usize>(rows: Vec<[String; N]>) -> String {
    let widths: [usize; N] = std::array::from_fn(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for row in &rows {
        let mut line = String::new();
        for (i, cell) in row.iter().enumerate() {
            let pad = " ".repeat(widths[i].saturating_sub(cell.chars().count()));
            let gap = if i == 0 { "" } else { "  " };
            let (before, after) = if i == 0 || i + 1 == N && N > 5 { ("", pad.as_str()) } else { (pad.as_str(), "") };
            line += &format!("{gap}{before}{cell}{after}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// A number with four digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() {
        return format!("{value}");
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    let places = (3 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.places$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_diagnosis::Misfit;

    #[test]
    fn numbers_have_four_digits() {
        let said = [0.0, 121.2, 0.04, 24200.0, 0.31, 1.5e-5, 113.0449, -2.0].map(number);
        assert_eq!(said, ["0", "121.2", "0.04", "24200", "0.31", "1.50e-5", "113", "-2"]);
    }

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
            warnings: Vec::new(),
        };
        let text = table(&identified);
        let lines: Vec<&str> = text.lines().collect();
        let cells: Vec<&str> = lines[1].split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let expected = ["convection_w_per_m2_k", "121.2", "60", "55 to 65.5", "24.24", "-2.5 !", "W/(m² K)"];
        assert_eq!(cells, expected, "{text}");
        assert!(lines[4].contains("66.00") && lines[4].contains("1.01") && lines[4].contains("1.50e-5"), "{text}");
        // every line's columns end where the head's do
        assert_eq!(lines[0].find("fitted").map(|i| i + 6), lines[1].find("60 ").map(|i| i + 2), "{text}");
    }
}
