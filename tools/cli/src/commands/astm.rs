//! `sinew astm`: what material laboratories report, read off their curves.

use std::fmt::Write as _;

use serde::Serialize;
use sinew_figures::{Curve, Field, Figure, Ink, Kind, Panel};
use sinew_import::{Found, Quantity};
use sinew_physics::{Geometry, Material};
use sinew_rig::rounded;
use sinew_standards::{
    Calorimetry, Estimate, Peak, Recovery, Tension, ThermalCycle, Transition, calorimetry, recovery, tension,
    thermal_cycle,
};

use super::curves::{CurveFile, Measured};
use super::plot;
use crate::args::{self, Standard};
use crate::failure::{Failure, Outcome};
use crate::output;

/// Version of the JSON.
const SCHEMA: &str = "sinew.astm/1";

/// Runs the command.
pub fn astm(args: &args::Astm) -> Outcome {
    if let Some(path) = &args.output {
        plot::form(path)?;
        output::has_place(path)?;
    }
    let curve = Curves { args, curve: CurveFile::read(&args.file, args.sheet.as_deref(), &args.columns)? };
    let read = match args.standard {
        Standard::F2004 => curve.calorimetry()?,
        // what is bent has a deflection, and that goes back like a strain
        Standard::F2082 => curve
            .recovery(curve.strain().or_else(|no_strain| curve.of(Quantity::Elongation).map_err(|_| no_strain))?)?,
        Standard::E3098 => curve.recovery(curve.strain()?)?,
        Standard::E3097 => curve.thermal_cycle()?,
        Standard::F2516 => curve.tension()?,
    };
    if let Some(path) = &args.output {
        plot::write(&read.figure(&args.file.display().to_string()), path)?;
    }
    if args.json {
        return output::print_json(&Answer {
            schema: SCHEMA,
            standard: args.standard.name(),
            file: args.file.display().to_string(),
            columns: [&read.x.column, &read.y.column],
            stress_pa: read.stress_pa,
            figures: &read.figures,
            material: read.material.iter().map(|(key, value, _)| (*key, *value)).collect(),
        });
    }
    output::print(read.text(args))
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Answer<'a> {
    schema: &'static str,
    standard: &'static str,
    file: String,
    columns: [&'a str; 2],
    stress_pa: Option<f64>,
    figures: &'a Figures,
    /// Keys of `[channel.material]`.
    material: std::collections::BTreeMap<&'static str, f64>,
}

impl Standard {
    const fn name(self) -> &'static str {
        match self {
            Standard::F2004 => "ASTM F2004",
            Standard::F2082 => "ASTM F2082",
            Standard::F2516 => "ASTM F2516",
            Standard::E3097 => "ASTM E3097",
            Standard::E3098 => "ASTM E3098",
        }
    }
}

/// What was read off, by standard.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Figures {
    Calorimetry {
        #[serde(flatten)]
        peaks: Calorimetry,
        heat_j_per_kg: Option<[f64; 2]>,
    },
    Cycle(ThermalCycle),
    Recovery(Recovery),
    Tension(Tension),
}

/// A curve, and what was read off it.
struct Read {
    x: Found,
    y: Found,
    stress_pa: Option<f64>,
    figures: Figures,
    /// Keys of `[channel.material]`, with a remark.
    material: Vec<(&'static str, f64, String)>,
}

/// A file's columns, and what is said of them.
struct Curves<'a> {
    args: &'a args::Astm,
    curve: CurveFile,
}

impl Curves<'_> {
    fn of(&self, of: Quantity) -> Result<Found, Failure> {
        self.curve.of(of)
    }

    fn failure(&self, error: sinew_standards::Error) -> Failure {
        self.curve.failure(error)
    }

    /// The strain, or the elongation over the sample's length.
    fn strain(&self) -> Result<Found, Failure> {
        let strain = self.of(Quantity::Strain);
        let Some(length_m) = self.args.length else { return strain };
        strain.or_else(|_| {
            let mut found = self.of(Quantity::Elongation)?;
            found.values.iter_mut().for_each(|value| *value /= length_m);
            Ok(found)
        })
    }

    /// The stress, or the force over the wire's cross-section.
    fn stress(&self) -> Result<Found, Failure> {
        let stress = self.of(Quantity::Stress);
        let Some(diameter_m) = self.args.diameter else { return stress };
        stress.or_else(|_| {
            let mut found = self.of(Quantity::Force)?;
            let area_m2 = Geometry { diameter_m, length_m: 1.0 }.area_m2();
            found.values.iter_mut().for_each(|value| *value /= area_m2);
            Ok(found)
        })
    }

    fn calorimetry(&self) -> Result<Read, Failure> {
        let Measured { temperature: x, flow: y, rates_k_per_s, to_w_per_kg } =
            self.curve.heat_flow(self.args.mass_mg, self.args.rate)?;
        let peaks = calorimetry(&x.values, &y.values).map_err(|e| self.failure(e))?;
        let heat_j_per_kg = rates_k_per_s.zip(to_w_per_kg).map(|(rates, to_w_per_kg)| {
            let areas = [peaks.heating.area.abs(), peaks.cooling.area.abs()];
            [areas[0] / rates[0] * to_w_per_kg, areas[1] / rates[1] * to_w_per_kg]
        });
        let Calorimetry { heating, cooling } = &peaks;
        let free = || "without stress".to_string();
        let mut material = vec![
            ("austenite_temperature_c", heating.middle_c(), free()),
            ("martensite_temperature_c", cooling.middle_c(), free()),
            ("heating_steepness_per_k", heating.steepness_per_k(), String::new()),
            ("cooling_steepness_per_k", cooling.steepness_per_k(), String::new()),
        ];
        if let Some([up, down]) = heat_j_per_kg {
            material.push(("latent_heat_j_per_kg", 0.5 * (up + down), "mean of both".into()));
        }
        Ok(Read { x, y, stress_pa: None, figures: Figures::Calorimetry { peaks, heat_j_per_kg }, material })
    }

    fn thermal_cycle(&self) -> Result<Read, Failure> {
        let (x, y) = (self.of(Quantity::Temperature)?, self.strain()?);
        let cycle = thermal_cycle(&x.values, &y.values).map_err(|e| self.failure(e))?;
        let stress_pa = self.args.stress.map(|mpa| mpa * 1e6).or_else(|| {
            let stress = self.stress().ok()?;
            let known: Vec<f64> = stress.values.iter().copied().filter(|value| value.is_finite()).collect();
            Some(known.iter().sum::<f64>() / known.len().max(1) as f64)
        });
        let mut material = Vec::new();
        if let Some(stress_pa) = stress_pa {
            let shift_k_per_pa = Material::default().stress_shift_k_per_pa;
            let shift_k = shift_k_per_pa * stress_pa;
            let remark = format!(
                "less {} K, which {} MPa shift it by {} K/MPa",
                rounded(shift_k),
                rounded(stress_pa * 1e-6),
                rounded(shift_k_per_pa * 1e6)
            );
            material.push(("austenite_temperature_c", cycle.heating.middle_c() - shift_k, remark.clone()));
            material.push(("martensite_temperature_c", cycle.cooling.middle_c() - shift_k, remark));
        }
        material.push(("heating_steepness_per_k", cycle.heating.steepness_per_k(), String::new()));
        material.push(("cooling_steepness_per_k", cycle.cooling.steepness_per_k(), String::new()));
        material.push(("transformation_strain", cycle.transformation_strain, "under this load".into()));
        Ok(Read { x, y, stress_pa, figures: Figures::Cycle(cycle), material })
    }

    fn recovery(&self, y: Found) -> Result<Read, Failure> {
        let x = self.of(Quantity::Temperature)?;
        let found = recovery(&x.values, &y.values).map_err(|e| self.failure(e))?;
        let material = vec![
            ("austenite_temperature_c", found.heating.middle_c(), "without stress".into()),
            ("heating_steepness_per_k", found.heating.steepness_per_k(), String::new()),
        ];
        Ok(Read { x, y, stress_pa: None, figures: Figures::Recovery(found), material })
    }

    fn tension(&self) -> Result<Read, Failure> {
        let (x, y) = (self.strain()?, self.stress()?);
        let found = tension(&x.values, &y.values).map_err(|e| self.failure(e))?;
        Ok(Read { x, y, stress_pa: None, figures: Figures::Tension(found), material: Vec::new() })
    }
}

impl Read {
    fn text(&self, args: &args::Astm) -> String {
        let mut text = format!(
            "{}: {}, \"{}\" over \"{}\"\n\n",
            args.file.display(),
            args.standard.name(),
            self.y.column,
            self.x.column
        );
        for (symbol, words, value) in self.figures.lines(args.standard) {
            // writing to a String cannot fail
            let _ = writeln!(text, "{symbol:<7} {value:<18} {words}");
        }
        if let Figures::Calorimetry { heat_j_per_kg: None, .. } = self.figures {
            let missing = if self.y.is_of_sample && args.mass_mg.is_none() { "--mass-mg" } else { "--rate" };
            let _ = writeln!(text, "\nThe heat needs {missing}.");
        }
        if !self.material.is_empty() {
            text.push_str("\n[channel.material]\n");
        }
        for (key, value, remark) in &self.material {
            let remark = if remark.is_empty() { String::new() } else { format!("   # {remark}") };
            let _ = writeln!(text, "{key} = {}{remark}", rounded(*value));
        }
        text
    }

    /// The curve, and a mark at each temperature or strain that was read off.
    fn figure(&self, file: &str) -> Figure {
        let kind = if matches!(self.figures, Figures::Tension(_)) { Kind::Tension } else { Kind::Hysteresis };
        let finite = || self.y.values.iter().copied().filter(|value| value.is_finite());
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        let curve =
            Curve { ink: Ink::Plain, name: self.y.column.clone(), x: self.x.values.clone(), y: self.y.values.clone() };
        let mark = |(name, x): (&'static str, f64)| Curve {
            ink: Ink::Before,
            name: name.into(),
            x: vec![x, x],
            y: vec![low, high],
        };
        let marks = self.figures.marks();
        let named: Vec<&str> = marks.iter().map(|(name, _)| *name).collect();
        let legend = vec![(Ink::Plain, self.y.column.clone()), (Ink::Before, named.join(", "))];
        let temperature = || Field { title: "Temperature".into(), unit: "°C" };
        let axes = match &self.figures {
            Figures::Tension(_) => {
                (Field { title: "Strain".into(), unit: "1" }, Field { title: "Stress".into(), unit: "Pa" })
            }
            Figures::Calorimetry { .. } => {
                let unit = if self.y.is_of_sample { "W" } else { "W/kg" };
                (temperature(), Field { title: "Heat flow".into(), unit })
            }
            Figures::Cycle(_) => (temperature(), Field { title: "Strain".into(), unit: "1" }),
            Figures::Recovery(_) => (temperature(), Field { title: self.y.column.clone(), unit: "1" }),
        };
        let panel = Panel {
            kind,
            caption: axes.1.title.clone(),
            x: axes.0,
            y: axes.1,
            curves: std::iter::once(curve).chain(marks.into_iter().map(mark)).collect(),
        };
        Figure { title: file.into(), legend, panels: vec![panel], notes: Vec::new() }
    }
}

type Line = (&'static str, &'static str, String);

fn celsius(at: Estimate) -> String {
    format!("{:.1} ± {:.1} °C", at.value, at.by_choice)
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

fn mpa(pa: f64) -> String {
    format!("{:.1} MPa", pa * 1e-6)
}

impl Figures {
    /// Symbol, meaning and value of each figure.
    fn lines(&self, standard: Standard) -> Vec<Line> {
        match self {
            Figures::Calorimetry { peaks, heat_j_per_kg } => {
                let one = |symbols: [&'static str; 3], peak: &Peak, heat: Option<f64>| {
                    let mut lines = vec![
                        (symbols[0], "start", celsius(peak.start_c)),
                        (symbols[1], "peak", format!("{:.1} °C", peak.peak_c)),
                        (symbols[2], "finish", celsius(peak.finish_c)),
                    ];
                    lines.extend(
                        heat.map(|heat| ("ΔH", "heat of the transformation", format!("{:.2} J/g", heat * 1e-3))),
                    );
                    lines.extend(peak.second_c.map(|c| {
                        (
                            "(R)",
                            "a second peak, an R-phase's most likely; figures are the larger's",
                            format!("{c:.1} °C"),
                        )
                    }));
                    lines
                };
                let [up, down] = heat_j_per_kg.map_or([None; 2], |heats| heats.map(Some));
                let mut lines = one(["A_s", "A_p", "A_f"], &peaks.heating, up);
                lines.extend(one(["M_s", "M_p", "M_f"], &peaks.cooling, down));
                lines
            }
            Figures::Cycle(cycle) => {
                let mut lines = ends(["A_s", "A_f"], &cycle.heating);
                lines.extend(ends(["M_s", "M_f"], &cycle.cooling));
                lines.extend([
                    ("e_UCT", "strain at the upper cycle temperature", percent(cycle.strain_at_uct)),
                    ("e_LCT", "strain at the lower one, before heating", percent(cycle.strain_at_lct[0])),
                    ("e_LCT", "the same after cooling", percent(cycle.strain_at_lct[1])),
                    ("e_act", "actuation strain, taken back by heating", percent(cycle.actuation_strain)),
                    ("e_t", "transformation strain, between the base lines", percent(cycle.transformation_strain)),
                    ("e_r", "residual strain of this cycle", percent(cycle.residual_strain)),
                    ("WIDTH", "hysteresis width, between the middles", format!("{:.1} K", cycle.hysteresis_width_k)),
                    ("TSPAN", "transformation span, M_f to A_f", format!("{:.1} K", cycle.transformation_span_k)),
                ]);
                lines
            }
            Figures::Recovery(found) => {
                let shown = |value: f64| match standard {
                    Standard::E3098 => percent(value),
                    _ => rounded(value),
                };
                let mut lines = ends(["A_s", "A_f"], &found.heating);
                lines.extend([
                    ("before", "before heating", shown(found.before)),
                    ("after", "at its end", shown(found.after)),
                    ("back", "recovered", shown(found.recovered)),
                ]);
                lines
            }
            Figures::Tension(found) => {
                let mut lines = vec![
                    ("UPS", "upper plateau strength, loading at 3 % of strain", mpa(found.upper_plateau_pa)),
                    ("to", "strained to, before it was let go", percent(found.strained_to)),
                ];
                lines.extend(
                    found.lower_plateau_pa.map(|pa| ("LPS", "lower plateau strength, unloading at 2.5 %", mpa(pa))),
                );
                lines.extend(found.residual_elongation.map(|e| ("El_r", "residual elongation, at 7 MPa", percent(e))));
                lines.extend(found.tensile_strength_pa.map(|pa| ("UTS", "ultimate tensile strength", mpa(pa))));
                lines.extend(found.uniform_elongation.map(|e| ("El_u", "uniform elongation", percent(e))));
                lines
            }
        }
    }

    /// Where it was read off.
    fn marks(&self) -> Vec<(&'static str, f64)> {
        match self {
            Figures::Calorimetry { peaks, .. } => vec![
                ("A_s", peaks.heating.start_c.value),
                ("A_f", peaks.heating.finish_c.value),
                ("M_s", peaks.cooling.start_c.value),
                ("M_f", peaks.cooling.finish_c.value),
            ],
            Figures::Cycle(cycle) => vec![
                ("A_s", cycle.heating.start_c.value),
                ("A_f", cycle.heating.finish_c.value),
                ("M_s", cycle.cooling.start_c.value),
                ("M_f", cycle.cooling.finish_c.value),
            ],
            Figures::Recovery(found) => {
                vec![("A_s", found.heating.start_c.value), ("A_f", found.heating.finish_c.value)]
            }
            Figures::Tension(_) => {
                vec![
                    ("UPS at 3 %", sinew_standards::UPPER_PLATEAU_AT),
                    ("LPS at 2.5 %", sinew_standards::LOWER_PLATEAU_AT),
                ]
            }
        }
    }
}

fn ends(symbols: [&'static str; 2], transition: &Transition) -> Vec<Line> {
    vec![(symbols[0], "start", celsius(transition.start_c)), (symbols[1], "finish", celsius(transition.finish_c))]
}
