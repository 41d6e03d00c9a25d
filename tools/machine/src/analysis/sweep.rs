//! Sines of growing frequency: amplitude and phase at each, and where the answer has fallen by 3 dB.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use nalgebra::{DMatrix, DVector};

use super::finding::{Estimate, Finding};
use super::run::Run;
use crate::plan::RoutineKind;
use crate::run::Row;
use crate::stage::Part;

/// What is left of 1 after −3 dB.
const MINUS_3_DB: f64 = FRAC_1_SQRT_2;
/// The lowest frequencies agree when they differ by less than this share: then the answer there is the static one.
const FLAT: f64 = 0.1;

/// A sine in a signal: amplitude and phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fundamental {
    /// Half of peak to peak.
    pub amplitude: Estimate,
    /// rad, of a cosine.
    pub phase: Estimate,
}

/// The answer at one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Hz.
    pub frequency_hz: f64,
    /// Of the answer.
    pub answer: Fundamental,
    /// Amplitude of the answer over that of what drove it.
    pub gain: Estimate,
    /// Behind what drove it, in degrees, negative = later.
    pub phase_deg: Estimate,
    /// Between the extremes of the answer.
    pub peak_to_peak: f64,
    /// RMS of answer less what drove it, where they are the same quantity.
    pub rms: f64,
}

/// The sine of a frequency in samples, beside an offset and a drift; `None` where there are too few.
pub fn fundamental(time_s: &[f64], values: &[f64], frequency_hz: f64) -> Option<Fundamental> {
    let kept: Vec<(f64, f64)> =
        time_s.iter().zip(values).filter(|(_, v)| v.is_finite()).map(|(t, v)| (*t, *v)).collect();
    let n = kept.len();
    if n < 12 {
        return None;
    }
    let (first, last) = (kept[0].0, kept[n - 1].0);
    let span = (last - first).max(1e-9);
    let design = DMatrix::from_fn(n, 4, |row, column| {
        let t = kept[row].0;
        let angle = TAU * frequency_hz * t;
        match column {
            0 => 1.0,
            1 => (t - first) / span - 0.5,
            2 => angle.cos(),
            _ => angle.sin(),
        }
    });
    let values = DVector::from_iterator(n, kept.iter().map(|(_, v)| *v));
    let normal = (design.transpose() * &design).cholesky()?;
    let fit = normal.solve(&(design.transpose() * &values));
    let (c, s) = (fit[2], fit[3]);
    let amplitude = c.hypot(s);
    // harmonics are no noise: what the uncertainty counts is how much neighbouring samples scatter
    let left = &values - &design * &fit;
    let scatter = left.as_slice().windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / (2.0 * (n - 1) as f64);
    let sigma = (2.0 * scatter / n as f64).sqrt();
    let phase_sigma =
        if amplitude > 0.0 { (sigma / amplitude).min(std::f64::consts::PI) } else { std::f64::consts::PI };
    Some(Fundamental {
        amplitude: Estimate { value: amplitude, sigma },
        phase: Estimate { value: (-s).atan2(c), sigma: phase_sigma },
    })
}

/// The answers of a run, by frequency as they were run.
pub fn responses(run: &Run<'_>) -> Vec<Response> {
    let by_law = run.kind.is_closed_loop();
    let answer = |row: &Row| match run.kind {
        RoutineKind::ConstantStrainSweep if row.reading.force_is_new => row.reading.force_n,
        RoutineKind::ConstantStrainSweep => f64::NAN,
        _ => row.reading.position_m,
    };
    let drove = |row: &Row| if by_law { row.directive.target } else { row.directive.heat };
    let of = |stage: &crate::stage::Stage| match stage.part {
        Part::Sweep { frequency_hz } | Part::Track { frequency_hz } => Some(frequency_hz),
        _ => None,
    };
    run.stretches()
        .filter_map(|(stage, rows)| {
            let frequency_hz = of(stage)?;
            let period_s = 1.0 / run.spec.rate_hz;
            // a sample is of the end of its row; heat is of the middle, a reference of the end
            let ends: Vec<f64> = rows.iter().map(|row| row.time_s + period_s).collect();
            let drives: Vec<f64> =
                if by_law { ends.clone() } else { rows.iter().map(|row| row.time_s + 0.5 * period_s).collect() };
            let values: Vec<f64> = rows.iter().map(answer).collect();
            let driven: Vec<f64> = rows.iter().map(drove).collect();
            let out = fundamental(&ends, &values, frequency_hz)?;
            let input = fundamental(&drives, &driven, frequency_hz)?;
            let gain = out.amplitude.scaled(1.0 / input.amplitude.value.max(1e-300));
            // heat shortens and tightens; lengthening is the answer turned over
            let flip = if by_law || run.kind == RoutineKind::ConstantStrainSweep { 0.0 } else { 180.0 };
            let turned = (out.phase.value - input.phase.value).to_degrees() + flip;
            // the answer lags: between −350° and +10°
            let phase = (turned - 10.0).rem_euclid(360.0) - 350.0;
            let (low, high) = values
                .iter()
                .filter(|v| v.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
            let squares: f64 = values.iter().zip(&driven).map(|(v, d)| (v - d).powi(2)).sum();
            Some(Response {
                frequency_hz,
                answer: out,
                gain,
                phase_deg: Estimate { value: phase, sigma: out.phase.sigma.to_degrees() },
                peak_to_peak: high - low,
                rms: (squares / values.len().max(1) as f64).sqrt(),
            })
        })
        .collect()
}

/// Where `of` first falls to `level`, between two frequencies, by straight lines over their logarithms.
fn falls_to(responses: &[Response], level: f64, of: &dyn Fn(&Response) -> Estimate) -> Result<Estimate, String> {
    let mut sorted: Vec<&Response> = responses.iter().collect();
    sorted.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else {
        return Err("no frequency was completed".to_string());
    };
    if of(first).value <= level {
        return Err(format!(
            "it is below that at the lowest frequency already: begin below {} Hz",
            number(first.frequency_hz)
        ));
    }
    for pair in sorted.windows(2) {
        let (a, b) = (of(pair[0]), of(pair[1]));
        if a.value > level && b.value <= level {
            let share = (a.value - level) / (a.value - b.value);
            let (from, to) = (pair[0].frequency_hz.ln(), pair[1].frequency_hz.ln());
            let value = (from + share * (to - from)).exp();
            let noise = a.sigma.hypot(b.sigma) / (a.value - b.value) * (to - from);
            // a curve that bends between the two is off the straight line by an eighth of their distance at most
            let bend = share * (1.0 - share) * (to - from) * 0.5;
            return Ok(Estimate { value, sigma: value * noise.hypot(bend) });
        }
    }
    Err(format!("it does not fall so far up to {} Hz: go further", number(last.frequency_hz)))
}

fn number(value: f64) -> String {
    sinew_plot::quantity::number(value)
}

/// Numbers of an open-loop sweep.
pub fn open_loop(run: &Run<'_>) -> Vec<Finding> {
    let all = responses(run);
    let force = run.kind == RoutineKind::ConstantStrainSweep;
    let (unit, scale) = if force { ("N", 1.0) } else { ("mm", 1e3) };
    let mut findings: Vec<Finding> = all
        .iter()
        .flat_map(|response| {
            let of = format!("{} Hz", number(response.frequency_hz));
            let swing = response.answer.amplitude.scaled(2.0 * scale);
            let how = "least squares of a sine, an offset and a drift; noise from neighbouring samples";
            let name = if force { "Swing of the force" } else { "Stroke" };
            [
                Finding::new(if force { "swing_n" } else { "stroke_mm" }, name, unit, &of, swing, how),
                Finding::new("phase_deg", "Phase behind the heating", "°", &of, response.phase_deg, how),
            ]
        })
        .collect();
    findings.push(held(run));
    findings.extend(bandwidth(
        &all,
        "open_loop_bandwidth_hz",
        "Open-loop bandwidth, −3 dB",
        |r| r.answer.amplitude,
        None,
    ));
    findings
}

/// How well what was to stand still did.
fn held(run: &Run<'_>) -> Finding {
    let rows =
        || run.stretches().filter(|(stage, _)| matches!(stage.part, Part::Sweep { .. })).flat_map(|(_, rows)| rows);
    let rms = |errors: Vec<f64>| {
        let count = errors.len().max(1) as f64;
        let value = (errors.iter().map(|error| error * error).sum::<f64>() / count).sqrt();
        Estimate { value, sigma: value / (2.0 * count).sqrt() }
    };
    if run.kind == RoutineKind::ConstantForceSweep {
        let new = rows().filter(|row| row.reading.force_is_new);
        let errors = new.map(|row| row.reading.force_n - row.directive.target).collect();
        return Finding::new(
            "force_error_n",
            "Force off what was to be held, RMS",
            "N",
            "",
            rms(errors),
            "over all periods that count",
        );
    }
    let positions: Vec<f64> = rows().map(|row| row.reading.position_m).collect();
    let mean = positions.iter().sum::<f64>() / positions.len().max(1) as f64;
    let errors = positions.iter().map(|position| 1e6 * (position - mean)).collect();
    Finding::new(
        "position_error_um",
        "Elongation off what was to be held, RMS",
        "µm",
        "",
        rms(errors),
        "over all periods that count",
    )
}

/// Numbers of a tracking run.
pub fn closed_loop(run: &Run<'_>) -> Vec<Finding> {
    let all = responses(run);
    let mut findings: Vec<Finding> = all
        .iter()
        .flat_map(|response| {
            let of = format!("{} Hz", number(response.frequency_hz));
            let rms = Estimate { value: response.rms * 1e3, sigma: response.answer.amplitude.sigma * 1e3 };
            let how = "least squares of a sine, an offset and a drift; noise from neighbouring samples";
            [
                Finding::new(
                    "tracking_rms_mm",
                    "Tracking error, RMS",
                    "mm",
                    &of,
                    rms,
                    "position less reference, over the whole periods",
                ),
                Finding::new("gain", "Amplitude over that of the reference", "1", &of, response.gain, how),
                Finding::new("phase_deg", "Phase behind the reference", "°", &of, response.phase_deg, how),
            ]
        })
        .collect();
    if run.kind == RoutineKind::TrackingSweep {
        findings.extend(bandwidth(
            &all,
            "closed_loop_bandwidth_hz",
            "Closed-loop bandwidth, −3 dB",
            |r| r.gain,
            Some(1.0),
        ));
    }
    findings
}

/// Where amplitude and phase have fallen; against the lowest frequency where there is no known `reference`.
fn bandwidth(
    all: &[Response],
    key: &'static str,
    name: &'static str,
    of: fn(&Response) -> Estimate,
    reference: Option<f64>,
) -> Vec<Finding> {
    let mut sorted: Vec<&Response> = all.iter().collect();
    sorted.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let lowest = sorted.first().map_or(f64::NAN, |response| of(response).value);
    let against = reference.unwrap_or(lowest);
    let flat = sorted.get(1).is_some_and(|second| (of(second).value / lowest - 1.0).abs() < FLAT);
    let scale = |r: &Response| of(r).scaled(1.0 / against);
    let found = falls_to(all, MINUS_3_DB, &scale);
    let what = match (reference, flat) {
        (Some(_), _) => "against the reference's amplitude".to_string(),
        (None, true) => "against the lowest frequency, where the answer no longer changes".to_string(),
        (None, false) => {
            "against the lowest frequency; the answer still grows there, so the static one is larger".to_string()
        }
    };
    let how = format!("amplitude {what}, straight between frequencies over their logarithm");
    let behind = |degrees: f64| falls_to(all, -degrees, &|r: &Response| r.phase_deg);
    vec![
        Finding::from(key, name, "Hz", "", &found, how),
        Finding::from("phase_45_hz", "45° behind", "Hz", "", &behind(45.0), "phase of the fundamental"),
        Finding::from("phase_90_hz", "90° behind", "Hz", "", &behind(90.0), "phase of the fundamental"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first-order lag has its −3 dB and its 45° at 1/(2πT).
    #[test]
    fn a_lag_has_the_bandwidth_it_has() {
        let lag_s = 0.8;
        let exact = 1.0 / (TAU * lag_s);
        let all: Vec<Response> = crate::plan::spaced(0.01, 2.0, 14)
            .into_iter()
            .map(|frequency_hz| {
                let time_s: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.01 / frequency_hz / 10.0).collect();
                let turn = TAU * frequency_hz * lag_s;
                let (gain, phase) = (1.0 / turn.hypot(1.0), -turn.atan());
                let noise = |i: usize| 1e-4 * ((i * 7919 % 101) as f64 / 50.0 - 1.0);
                let values: Vec<f64> = time_s
                    .iter()
                    .enumerate()
                    .map(|(i, t)| 3.0 + gain * (TAU * frequency_hz * t + phase).cos() + noise(i))
                    .collect();
                let answer = fundamental(&time_s, &values, frequency_hz).unwrap();
                assert!((answer.amplitude.value - gain).abs() < 4.0 * answer.amplitude.sigma + 1e-6);
                let phase_deg = Estimate { value: answer.phase.value.to_degrees(), sigma: 0.01 };
                Response { frequency_hz, answer, gain: answer.amplitude, phase_deg, peak_to_peak: 2.0 * gain, rms: 0.0 }
            })
            .collect();
        let found = falls_to(&all, MINUS_3_DB, &|r| r.gain).unwrap();
        assert!(
            (found.value - exact).abs() < 2.0 * found.sigma && found.sigma < 0.2 * exact,
            "{found:?}, exact {exact}"
        );
        let found = falls_to(&all, -45.0, &|r| r.phase_deg).unwrap();
        assert!((found.value - exact).abs() < 2.0 * found.sigma, "{found:?}, exact {exact}");
        assert!(falls_to(&all[..3], MINUS_3_DB, &|r| r.gain).unwrap_err().contains("go further"));
    }
}
