//! A calorimeter's curves as an input of `identify`.

use serde::Serialize;
use sinew_diagnosis::{Measured, MeasuredParameter};
use sinew_material::{Error, Fitted, HeatFlow};
use sinew_rig::Rig;
use sinew_standards::Calorimetry;

use super::curves::CurveFile;
use crate::args;
use crate::failure::Failure;
use crate::table::{columns, number};

/// What is left of a curve, as a share of its peak, from which on its shape is said to be another than the model's.
const MISFIT: f64 = 0.05;

/// Curves, each fitted, and what they say together.
pub struct Curves {
    /// One by one.
    pub each: Vec<Curve>,
    /// All of them.
    pub measured: Measured,
}

/// A curve as it was fitted; part of what `--json` prints.
#[derive(Debug, Serialize)]
pub struct Curve {
    file: String,
    /// Figures of ASTM F2004 off the curve itself.
    f2004: Calorimetry,
    heat_j_per_kg: Option<[f64; 2]>,
    /// How far the calorimeter lags behind, and 1 σ, K.
    lag_k: [f64; 2],
    /// What is left, RMS over the height of the peak, on heating and on cooling.
    misfit: [f64; 2],
    #[serde(skip)]
    lacks: Option<&'static str>,
}

impl Curves {
    /// Reads and fits those that are given; none where none is.
    pub fn read(args: &args::Identify, rig: &Rig, channel: usize) -> Result<Option<Curves>, Failure> {
        let (curves, masses) = (args.dsc.len(), args.mass_mg.len());
        if masses > 1 && masses != curves {
            return Err(Failure::input(format!("--mass-mg is given {masses} times for {curves} curves"))
                .hint("give it once for all of them, or once for each in their order"));
        }
        let (mut each, mut fitted) = (Vec::new(), Vec::new());
        for (i, file) in args.dsc.iter().enumerate() {
            if args.dsc[..i].contains(file) {
                return Err(Failure::input(format!("{}: is given twice", file.display())).hint("give every curve once"));
            }
            let curve = CurveFile::read(file, None, &args.columns)?;
            let mass_mg = args.mass_mg.get(i).or(args.mass_mg.first()).copied();
            let heat_flow = curve.heat_flow(mass_mg, args.rate)?;
            let found = sinew_material::calorimeter(
                rig,
                channel,
                &HeatFlow {
                    temperature_c: &heat_flow.temperature.values,
                    heat_flow: &heat_flow.flow.values,
                    rates_k_per_s: heat_flow.rates_k_per_s,
                    to_w_per_kg: heat_flow.to_w_per_kg,
                },
            );
            let found = found.map_err(|error| match error {
                Error::Curve(error) => curve.failure(error),
                error => Failure::input(format!("{}: {error}", file.display())).hint(match error {
                    Error::NothingMoves => "its curve belongs to criterion = \"driving_temperature\" in [channel.material]",
                    Error::Model(_) => "the model's transformation on cooling is below that on heating: is it the right curve?",
                    _ => "look at it with `sinew astm f2004 FILE -o curve.svg`; other kinetics may suit it, such as \"richards\"",
                }),
            })?;
            each.push(Curve::of(file.display().to_string(), &found, heat_flow.lacks()));
            fitted.push(found);
        }
        let source = match each.as_slice() {
            [one] => one.file.clone(),
            _ => "the calorimeter's curves".to_string(),
        };
        Ok(sinew_material::together(&source, &fitted).map(|measured| Curves { each, measured }))
    }

    /// What a reader must know of them.
    pub fn warnings(&self) -> Vec<String> {
        self.each.iter().flat_map(Curve::warnings).collect()
    }

    /// What they say of each parameter, and beside it what the recordings say alone.
    pub fn table(&self, measured: &std::collections::BTreeMap<String, MeasuredParameter>) -> String {
        let plus_minus = |value: f64, sigma: f64| format!("{} ± {}", number(value), number(sigma));
        let rows = measured.iter().map(|(key, of)| {
            let (by, apart) = of.by_recordings.map_or((String::new(), String::new()), |by| {
                (plus_minus(by.value, by.sigma), format!("{:.1}", by.apart_sigma))
            });
            [key.clone(), plus_minus(of.value, of.sigma), by, apart]
        });
        let head = ["calorimeter, 1 σ", "by the curve", "by recordings alone", "apart, σ"];
        let table = columns(std::iter::once(head.map(String::from)).chain(rows).collect());
        table + &self.each.iter().map(Curve::line).collect::<String>()
    }
}

impl Curve {
    fn of(file: String, found: &Fitted, lacks: Option<&'static str>) -> Curve {
        Curve {
            file,
            f2004: found.reading,
            heat_j_per_kg: found.heats_j_per_kg,
            lag_k: found.lag_k,
            misfit: found.misfit,
            lacks,
        }
    }

    /// How well it is met.
    fn line(&self) -> String {
        let [up, down] = self.misfit.map(|share| number((1e4 * share).round() / 100.0));
        let [lag_k, sigma_k] = self.lag_k.map(|k| format!("{k:.2}"));
        format!(
            "{}: left of its peaks {up} % on heating, {down} % on cooling (RMS); the calorimeter lags {lag_k} ± {sigma_k} K\n",
            self.file
        )
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for (peak, way) in [(&self.f2004.heating, "heating"), (&self.f2004.cooling, "cooling")] {
            if let Some(second_c) = peak.second_c {
                warnings.push(format!(
                    "{}: a second peak at {second_c:.0} °C on {way}, an R-phase's most likely, was left out: the model has no R-phase in \
                     its heat, and what is fitted is the larger peak at {:.0} °C",
                    self.file, peak.peak_c
                ));
            }
        }
        if let Some(lacks) = self.lacks {
            warnings.push(format!("{}: latent_heat_j_per_kg stays as it was: the heat needs {lacks}", self.file));
        }
        let worst = self.misfit[0].max(self.misfit[1]);
        if worst > MISFIT {
            warnings.push(format!(
                "{}: {:.0} % of its peak is left, RMS: its shape is not that of the rig file's kinetics, which widens the intervals; \
                 kinetics = \"richards\" has skewed curves",
                self.file,
                100.0 * worst
            ));
        }
        warnings
    }
}
