//! Stress over strain: moduli, transformation stresses by intersecting tangents, hysteresis, and what several
//! temperatures say of the phase diagram.

use super::finding::{Estimate, Finding, mean};
use super::line::Line;
use super::run::Run;
use crate::plan::holding_power_w;
use crate::run::Row;
use crate::stage::Part;
use crate::wave::Quantity;

/// Elastic lines are laid through this share of the stress there is …
const ELASTIC_SHARE: f64 = 0.2;
/// … and tangents to the plateau through this share of the strain.
const TANGENT_SHARE: f64 = 0.12;
/// Fewest points of a line.
const LEAST_POINTS: usize = 12;
/// A wire counts as taut above this stress, Pa, or so many σ of the load cell.
const TAUT_PA: f64 = 2e6;
const TAUT_SIGMA: f64 = 6.0;
/// What gets taut at less than this strain began as austenite.
const AUSTENITE_STRAIN: f64 = 0.004;
/// Its slope is the modulus only if it is known this well, as a share: one that bends from the first is transformation.
const STRAIGHT: f64 = 0.1;
/// A plateau is where the tangent falls below this share of the elastic slope.
const PLATEAU: f64 = 0.6;
/// The wire is all martensite where it is as stiff when it is pulled further as when it is let go, within this share.
const ALIKE: f64 = 0.15;
/// Loading that ends this much stiffer than the plateau has left it.
const BEYOND_PLATEAU: f64 = 1.5;
/// Uncertainty of the loss to the air where nothing measured it, 1 σ, as a share.
const LOSS_SIGMA: f64 = 0.2;

/// Stress over strain of one way, in the order it was measured.
pub type Curve = Vec<(f64, f64)>;

/// One cycle: pulled, let go.
#[derive(Debug, Clone)]
pub struct Cycle {
    /// Which heating level.
    pub level: usize,
    /// Strain, stress in Pa.
    pub loading: Curve,
    /// Strain, stress in Pa.
    pub unloading: Curve,
}

/// What one cycle says.
#[derive(Debug, Clone)]
pub struct Loop {
    /// Pa.
    pub austenite_modulus: Result<Estimate, String>,
    /// Pa.
    pub martensite_modulus: Result<Estimate, String>,
    /// Start of the transformation under load, Pa.
    pub loading_start: Result<Estimate, String>,
    /// Its end, Pa.
    pub loading_finish: Result<Estimate, String>,
    /// Its middle: the stress where the tangent is flattest, Pa.
    pub loading_plateau: Result<Estimate, String>,
    /// Start of the transformation back, Pa.
    pub unloading_start: Result<Estimate, String>,
    /// Its end, Pa.
    pub unloading_finish: Result<Estimate, String>,
    /// Its middle, Pa.
    pub unloading_plateau: Result<Estimate, String>,
    /// Stress between both ways in the middle of the strain, Pa.
    pub width: Result<Estimate, String>,
    /// Area of the loop, J/m³.
    pub energy: Result<Estimate, String>,
    /// Strain at which the wire went slack when it was let go.
    pub residual: Result<Estimate, String>,
}

impl Loop {
    /// Whether the wire was austenite again when it went slack, or never did.
    fn came_back(&self) -> bool {
        self.residual.as_ref().map_or(true, |residual| residual.value < AUSTENITE_STRAIN)
    }
}

/// How much a number moves with the stress of either plateau: per Pa, in its own SI unit.
fn by_warmth(key: &str, run: &Run<'_>) -> f64 {
    match key {
        "hysteresis_width_mpa" => 2.0,
        "loop_energy_mj" | "loop_energy_mj_per_m3" => 2.0 * run.model.material.transformation_strain,
        "austenite_modulus_gpa" | "martensite_modulus_gpa" | "residual_strain_percent" => 0.0,
        _ => 1.0,
    }
}

/// How far the heat of transformation moves the stress, Pa: the wire is off its temperature by the heat that its speed
/// sets free, over what the air takes away.
fn heat_of_transformation(run: &Run<'_>) -> f64 {
    let (m, g) = (&run.model.material, &run.model.geometry);
    let per_s = run.options.speed_m_s / (m.transformation_strain * g.length_m).max(1e-12);
    let watts = run.model.latent_heat_j() * per_s;
    let kelvins = watts / holding_power_w(run.model, 1.0, 0.0).max(1e-12);
    if m.stress_shift_k_per_pa > 0.0 { kelvins / m.stress_shift_k_per_pa } else { 0.0 }
}

/// The cycles of a run.
pub fn cycles(run: &Run<'_>) -> Vec<Cycle> {
    let (length, area) = (run.model.geometry.length_m, run.model.geometry.area_m2());
    let curve = |rows: &[Row]| -> Curve {
        let new = rows.iter().filter(|row| row.reading.force_is_new);
        new.map(|row| (row.reading.position_m / length, row.reading.force_n / area)).collect()
    };
    let mut cycles: Vec<Cycle> = Vec::new();
    for (stage, rows) in run.stretches() {
        match stage.part {
            Part::Loading { level, .. } => {
                cycles.push(Cycle { level, loading: curve(rows), unloading: Vec::new() });
            }
            Part::Unloading { .. } => {
                if let Some(cycle) = cycles.last_mut() {
                    cycle.unloading = curve(rows);
                }
            }
            _ => {}
        }
    }
    cycles.retain(|cycle| !cycle.unloading.is_empty());
    cycles
}

/// A line through the first `share` of `points` by stress, its slope's uncertainty with what halving the share does.
fn elastic(points: &[(f64, f64)], share: f64) -> Option<Line> {
    let (first, most) = (points.first()?.1, points.iter().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max));
    let least = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    let span = (most - first).max(first - least);
    let within = |share: f64| points.iter().take_while(|p| (p.1 - first).abs() <= share * span).count();
    let line = |share: f64| Line::through(&points[..within(share).max(LEAST_POINTS).min(points.len())]);
    let (whole, half) = (line(share)?, line(0.5 * share)?);
    let bend = (whole.slope.value - half.slope.value).abs();
    Some(Line { slope: half.slope.and(bend), ..half })
}

/// The flattest tangent: the line, and how much its height moves with the window.
fn plateau(points: &[(f64, f64)]) -> Option<Line> {
    let span = (points.last()?.0 - points.first()?.0).abs();
    let windowed = |share: f64| {
        let width = share * span;
        let mut best: Option<Line> = None;
        let mut from = 0;
        for to in 0..points.len() {
            while from < to && (points[to].0 - points[from].0).abs() > width {
                from += 1;
            }
            if from == 0 || to + 1 - from < LEAST_POINTS {
                continue;
            }
            if let Some(line) = Line::through(&points[from..=to])
                && best.as_ref().is_none_or(|best| line.slope.value < best.slope.value)
            {
                best = Some(line);
            }
        }
        best
    };
    let (whole, half) = (windowed(TANGENT_SHARE)?, windowed(0.6 * TANGENT_SHARE)?);
    // the middle of the flattest stretch is only known to some part of the window
    let moved = (whole.height.value - half.at(whole.middle)).abs();
    let shifted = 0.5 * (whole.middle - half.middle).abs() * whole.slope.value.abs();
    Some(Line { height: whole.height.and(moved.hypot(shifted)), ..whole })
}

/// What a cycle says. `noise_pa` is a sample's.
pub fn analyse(cycle: &Cycle, noise_pa: f64) -> Loop {
    let taut_pa = TAUT_PA.max(TAUT_SIGMA * noise_pa);
    let taut: &[(f64, f64)] = match cycle.loading.iter().rposition(|p| p.1 < taut_pa) {
        Some(last) => &cycle.loading[last + 1..],
        None => &cycle.loading,
    };
    let down: &[(f64, f64)] = match cycle.unloading.iter().position(|p| p.1 < taut_pa) {
        Some(first) => &cycle.unloading[..first],
        None => &cycle.unloading,
    };
    let never = "the wire was never taut: pull further, or heat more";
    let up_line = if taut.len() >= 2 * LEAST_POINTS { elastic(taut, ELASTIC_SHARE) } else { None };
    let down_line = if down.len() >= 2 * LEAST_POINTS { elastic(down, ELASTIC_SHARE) } else { None };
    let starts_austenite = taut.first().is_some_and(|p| p.0 < AUSTENITE_STRAIN);
    let austenite = match &up_line {
        None => Err(never.to_string()),
        Some(_) if !starts_austenite => Err("the wire was martensite, or partly so, when it got taut".to_string()),
        Some(line) if line.slope.sigma > STRAIGHT * line.slope.value => {
            Err("it began to transform as soon as it was pulled: heat more".to_string())
        }
        Some(line) => Ok(*line),
    };
    let up_flat = plateau(taut);
    let flat = |line: &Option<Line>, steep: &Option<Line>| match (line, steep) {
        (Some(flat), Some(steep)) if flat.slope.value < PLATEAU * steep.slope.value => Ok(*flat),
        (None, _) | (_, None) => Err(never.to_string()),
        _ => Err("no part of the curve is flat: pull further, or at another temperature".to_string()),
    };
    let up_flat = flat(&up_flat, &up_line);
    // martensite: as stiff at the end of the pull as when it is let go, and off the plateau
    let end_line = {
        let mut back: Vec<(f64, f64)> = taut.to_vec();
        back.reverse();
        if back.len() >= 2 * LEAST_POINTS { elastic(&back, 0.5 * ELASTIC_SHARE) } else { None }
    };
    let martensite = match (&down_line, &end_line, &up_flat) {
        (Some(down), Some(end), Ok(flat)) => {
            let alike = (end.slope.value / down.slope.value - 1.0).abs() < ALIKE;
            if alike && end.slope.value > BEYOND_PLATEAU * flat.slope.value.max(0.0) {
                Ok((*down, (end.slope.value - down.slope.value).abs()))
            } else {
                Err("the pull ended before all of the wire was martensite: pull further".to_string())
            }
        }
        (Some(down), Some(end), Err(_)) if !starts_austenite => {
            match (end.slope.value / down.slope.value - 1.0).abs() < ALIKE {
                true => Ok((*down, (end.slope.value - down.slope.value).abs())),
                false => Err("the wire was neither phase alone".to_string()),
            }
        }
        _ => Err("the wire was not pulled into martensite".to_string()),
    };
    let down_flat = flat(&plateau(down), &down_line);
    let residual = match cycle.unloading.iter().position(|p| p.1 < taut_pa) {
        Some(at) => Ok(Estimate { value: cycle.unloading[at].0, sigma: noise_pa / 30e9 + 1e-5 }),
        None => Err("the wire stayed taut to the end".to_string()),
    };
    let came_back = residual.as_ref().map_or(true, |residual: &Estimate| residual.value < AUSTENITE_STRAIN);
    let meet = |a: &Result<Line, String>, b: &Result<Line, String>| match (a, b) {
        (Ok(a), Ok(b)) => a.meets(b).ok_or_else(|| "the tangents do not meet".to_string()),
        (Err(why), _) | (_, Err(why)) => Err(why.clone()),
    };
    let martensite_line = martensite.as_ref().map(|(line, _)| *line).map_err(Clone::clone);
    let down_steep = down_line.ok_or_else(|| never.to_string());
    let stays = || Err("the wire did not come back to austenite: it went slack as martensite".to_string());
    let (width, energy) = hysteresis(cycle, noise_pa);
    Loop {
        austenite_modulus: austenite.as_ref().map(|line| line.slope).map_err(Clone::clone),
        martensite_modulus: martensite.as_ref().map(|(line, by)| line.slope.and(*by)).map_err(Clone::clone),
        loading_start: meet(&austenite, &up_flat),
        loading_finish: meet(&martensite_line, &up_flat),
        loading_plateau: match starts_austenite {
            true => up_flat.as_ref().map(|line| line.height).map_err(Clone::clone),
            false => Err("the wire was martensite, or partly so, when it got taut".to_string()),
        },
        unloading_start: meet(&down_steep, &down_flat),
        unloading_finish: if came_back { meet(&austenite, &down_flat) } else { stays() },
        unloading_plateau: match came_back {
            true => down_flat.map(|line| line.height),
            false => stays(),
        },
        width,
        energy,
        residual,
    }
}

/// Stress between the ways in the middle of the strain they share, and the area between them.
fn hysteresis(cycle: &Cycle, noise_pa: f64) -> (Result<Estimate, String>, Result<Estimate, String>) {
    let span = |curve: &Curve| {
        let strains = || curve.iter().map(|p| p.0);
        (strains().fold(f64::INFINITY, f64::min), strains().fold(f64::NEG_INFINITY, f64::max))
    };
    let (up, down) = (span(&cycle.loading), span(&cycle.unloading));
    let (low, high) = (up.0.max(down.0), up.1.min(down.1));
    let near = |curve: &Curve| {
        let middle = 0.5 * (low + high);
        let points: Vec<(f64, f64)> =
            curve.iter().copied().filter(|p| (p.0 - middle).abs() < 0.03 * (high - low)).collect();
        let line = Line::through(&points)?;
        Some(Estimate { value: line.at(middle), sigma: line.height.sigma })
    };
    let width = match (near(&cycle.loading), near(&cycle.unloading)) {
        (Some(up), Some(down)) if high > low => {
            Ok(Estimate { value: up.value - down.value, sigma: up.sigma.hypot(down.sigma) })
        }
        _ => Err("both ways share too little strain".to_string()),
    };
    let area = |curve: &Curve| -> f64 { curve.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum() };
    let count = (cycle.loading.len() + cycle.unloading.len()).max(1) as f64;
    // what the two ways do not share at their ends is not enclosed
    let gap = (up.0 - down.0).abs() * noise_pa.max(TAUT_PA);
    let energy = Estimate {
        value: area(&cycle.loading) + area(&cycle.unloading),
        sigma: (noise_pa * (high - low) * 2.0 / count.sqrt()).hypot(gap),
    };
    (width, Ok(energy))
}

/// Temperature of a wire that is heated by a steady power for long, and its uncertainty, °C; `None` where the heating is
/// not known as a power.
fn temperature(run: &Run<'_>, level: usize) -> Option<(f64, f64)> {
    let value = run.options.heating.get(level).copied()?;
    let air = {
        let seen = run.rows.iter().filter(|row| row.reading.chamber_is_new).map(|row| row.reading.chamber_c);
        let (sum, count) = seen.fold((0.0, 0.0), |(sum, count), c| (sum + c, count + 1.0));
        sum / count
    };
    if run.options.quantity != Quantity::Power && value > 0.0 {
        return None;
    }
    // rise per watt by the assumed loss
    let rise = value / holding_power_w(run.model, 1.0, 0.0).max(1e-12);
    Some((air + rise, LOSS_SIGMA * rise))
}

/// A number that every cycle gives.
struct OfCycle {
    key: &'static str,
    name: &'static str,
    unit: &'static str,
    scale: Scale,
    pick: fn(&Loop) -> &Result<Estimate, String>,
    how: &'static str,
}

/// From SI to the unit that is shown.
enum Scale {
    Times(f64),
    /// From J/m³ to mJ of the whole wire.
    Volume,
}

impl Scale {
    fn of(&self, run: &Run<'_>) -> f64 {
        match self {
            Scale::Times(scale) => *scale,
            Scale::Volume => run.model.geometry.volume_m3() * 1e3,
        }
    }
}

const OF_CYCLE: [OfCycle; 12] = [
    OfCycle {
        key: "austenite_modulus_gpa",
        name: "Austenite's modulus",
        unit: "GPa",
        scale: Scale::Times(1e-9),
        pick: |l| &l.austenite_modulus,
        how: "slope of the first tenth of the stress on loading; halving the part is in the uncertainty",
    },
    OfCycle {
        key: "martensite_modulus_gpa",
        name: "Martensite's modulus",
        unit: "GPa",
        scale: Scale::Times(1e-9),
        pick: |l| &l.martensite_modulus,
        how: "slope when the wire is let go after it was stiff again; that on loading is in the uncertainty",
    },
    OfCycle {
        key: "loading_start_mpa",
        name: "Transformation on loading starts",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.loading_start,
        how: "where the tangents of austenite and plateau meet",
    },
    OfCycle {
        key: "loading_plateau_mpa",
        name: "Plateau on loading",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.loading_plateau,
        how: "stress where the tangent is flattest: half of the wire is transformed",
    },
    OfCycle {
        key: "loading_finish_mpa",
        name: "Transformation on loading ends",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.loading_finish,
        how: "where the tangents of plateau and martensite meet",
    },
    OfCycle {
        key: "unloading_start_mpa",
        name: "Transformation on unloading starts",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.unloading_start,
        how: "where the tangents of the wire let go and of the plateau meet",
    },
    OfCycle {
        key: "unloading_plateau_mpa",
        name: "Plateau on unloading",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.unloading_plateau,
        how: "stress where the tangent is flattest",
    },
    OfCycle {
        key: "unloading_finish_mpa",
        name: "Transformation on unloading ends",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.unloading_finish,
        how: "where the tangents of plateau and austenite meet",
    },
    OfCycle {
        key: "hysteresis_width_mpa",
        name: "Width of the hysteresis",
        unit: "MPa",
        scale: Scale::Times(1e-6),
        pick: |l| &l.width,
        how: "stress on loading less that on unloading, at the middle of the strain",
    },
    OfCycle {
        key: "loop_energy_mj_per_m3",
        name: "Energy of a cycle, per volume",
        unit: "MJ/m³",
        scale: Scale::Times(1e-6),
        pick: |l| &l.energy,
        how: "area of the loop",
    },
    OfCycle {
        key: "loop_energy_mj",
        name: "Energy of a cycle",
        unit: "mJ",
        scale: Scale::Volume,
        pick: |l| &l.energy,
        how: "area of the loop times the wire's volume",
    },
    OfCycle {
        key: "residual_strain_percent",
        name: "Strain when it went slack",
        unit: "%",
        scale: Scale::Times(100.0),
        pick: |l| &l.residual,
        how: "first sample without tension when it was let go",
    },
];

/// Every number of a run.
pub fn findings(run: &Run<'_>) -> Vec<Finding> {
    let noise_pa = run.spec.force_noise_n / run.model.geometry.area_m2();
    let cycles = cycles(run);
    let loops: Vec<(usize, Loop)> = cycles.iter().map(|cycle| (cycle.level, analyse(cycle, noise_pa))).collect();
    let levels = cycles.iter().map(|cycle| cycle.level + 1).max().unwrap_or(0);
    if levels == 0 {
        let why = "no cycle was completed";
        return vec![Finding::unknown("loading_plateau_mpa", "Plateau on loading", "MPa", "", why)];
    }
    let mut all = Vec::new();
    for level in 0..levels {
        all.extend(findings_of_level(run, &loops, level));
        if let Some(cycle) = cycles.iter().find(|cycle| cycle.level == level) {
            all.extend(by_standard(cycle, &level_name(run, level)));
        }
    }
    all.extend(phase_diagram(run, &loops, levels));
    all
}

/// The numbers that the cycles of one level give.
fn findings_of_level(run: &Run<'_>, loops: &[(usize, Loop)], level: usize) -> Vec<Finding> {
    let mut of_level: Vec<&Loop> = loops.iter().filter(|(of, _)| *of == level).map(|(_, l)| l).collect();
    // a wire that stays martensite begins its next cycle as another wire
    let came_back = of_level.first().is_none_or(|first| first.came_back());
    if !came_back {
        of_level.truncate(1);
    }
    let of = level_name(run, level);
    let warmth_pa = heat_of_transformation(run);
    OF_CYCLE
        .iter()
        .map(|OfCycle { key, name, unit, scale, pick, how }| {
            let known: Vec<Estimate> = of_level.iter().filter_map(|l| pick(l).as_ref().ok().copied()).collect();
            let found = match mean(&known) {
                // what transforms is warmer or colder than what was before by its own heat, either way
                Some(value) => Ok(value.and(warmth_pa * by_warmth(key, run)).scaled(scale.of(run))),
                None => Err(of_level.iter().find_map(|l| pick(l).as_ref().err().cloned()).unwrap_or_default()),
            };
            let repeated = match known.len() {
                0 | 1 if came_back => String::new(),
                0 | 1 => "; of the first cycle: the wire did not come back".to_string(),
                cycles => format!("; mean of {cycles} cycles"),
            };
            Finding::from(key, name, unit, &of, &found, format!("{how}{repeated}"))
        })
        .collect()
}

/// The figures of ASTM F2516 of a level's first cycle, where that is pulled and let go as far as the standard has it.
fn by_standard(cycle: &Cycle, of: &str) -> Vec<Finding> {
    let (strain, stress_pa): (Vec<f64>, Vec<f64>) = cycle.loading.iter().chain(&cycle.unloading).copied().unzip();
    let Ok(found) = sinew_standards::tension(&strain, &stress_pa) else { return Vec::new() };
    // the standard reads a curve, and says nothing of how sure that is
    let read = |value: f64| Estimate { value, sigma: f64::NAN };
    let finding = |key, name, unit, value: f64, how: &str| {
        Finding::new(key, name, unit, of, read(value), format!("ASTM F2516, strain from 7 MPa on: {how}"))
    };
    let upper =
        finding("ups_mpa", "Upper plateau strength, UPS", "MPa", 1e-6 * found.upper_plateau_pa, "at 3 %, loading");
    let lower = found
        .lower_plateau_pa
        .map(|pa| finding("lps_mpa", "Lower plateau strength, LPS", "MPa", 1e-6 * pa, "at 2.5 %, unloading"));
    let residual = found.residual_elongation.map(|strain| {
        finding("residual_elongation_percent", "Residual elongation, El_r", "%", 100.0 * strain, "at 7 MPa, unloading")
    });
    [Some(upper), lower, residual].into_iter().flatten().collect()
}

/// What a level is called.
pub fn level_name(run: &Run<'_>, level: usize) -> String {
    let value = run.options.heating.get(level).copied().unwrap_or(f64::NAN);
    format!("{} {}", sinew_plot::quantity::number(value), run.options.quantity.unit())
}

/// Plateaus over temperature: their slope (Clausius–Clapeyron), and where they would be without stress.
fn phase_diagram(run: &Run<'_>, loops: &[(usize, Loop)], levels: usize) -> Vec<Finding> {
    type Pick = fn(&Loop) -> &Result<Estimate, String>;
    let ways: [(&'static str, &'static str, &'static str, &'static str, Pick); 2] = [
        (
            "loading_slope_mpa_per_k",
            "Stress of transformation per kelvin, loading",
            "martensite_temperature_c",
            "Centre of the transformation to martensite without stress",
            |l| &l.loading_plateau,
        ),
        (
            "unloading_slope_mpa_per_k",
            "Stress of transformation per kelvin, unloading",
            "austenite_temperature_c",
            "Centre of the transformation to austenite without stress",
            |l| &l.unloading_plateau,
        ),
    ];
    let mut all = Vec::new();
    for (slope_key, slope_name, centre_key, centre_name, pick) in ways {
        let points: Vec<(f64, f64, Estimate)> = (0..levels)
            .filter_map(|level| {
                let known: Vec<Estimate> = loops
                    .iter()
                    .filter(|(of, _)| *of == level)
                    .filter_map(|(_, l)| pick(l).as_ref().ok().copied())
                    .collect();
                let (celsius, sigma) = temperature(run, level)?;
                Some((celsius, sigma, mean(&known)?.and(heat_of_transformation(run))))
            })
            .collect();
        let found = diagram_line(&points);
        let how = format!(
            "line through the plateaus of {} temperatures, reckoned as air + power/(h A), h from the rig file ± {} %",
            points.len(),
            100.0 * LOSS_SIGMA
        );
        let slope = found.as_ref().map(|(slope, _)| *slope).map_err(Clone::clone);
        let centre = found.map(|(_, centre)| centre);
        all.push(Finding::from(slope_key, slope_name, "MPa/K", "", &slope, how.clone()));
        all.push(Finding::from(centre_key, centre_name, "°C", "", &centre, how));
    }
    all
}

/// Slope in MPa/K and temperature at zero stress of plateaus over temperature (°C, its σ, stress in Pa).
fn diagram_line(points: &[(f64, f64, Estimate)]) -> Result<(Estimate, Estimate), String> {
    let spread = {
        let all = || points.iter().map(|p| p.0);
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    if points.len() < 2 || spread < 2.0 {
        return Err("it takes plateaus at two temperatures or more: give several --heating levels".to_string());
    }
    // temperatures err together: all too high or all too low, by their σ
    let line = |by: f64| -> Option<(f64, f64)> {
        let at: Vec<(f64, f64)> = points.iter().map(|p| (p.0 + by * p.1, p.2.value)).collect();
        let n = at.len() as f64;
        let middle = at.iter().map(|p| p.0).sum::<f64>() / n;
        let height = at.iter().map(|p| p.1).sum::<f64>() / n;
        let sxx: f64 = at.iter().map(|p| (p.0 - middle).powi(2)).sum();
        let slope = at.iter().map(|p| (p.0 - middle) * (p.1 - height)).sum::<f64>() / sxx;
        (slope > 0.0).then(|| (slope * 1e-6, middle - height / slope))
    };
    let falls = || "the plateaus do not rise with temperature".to_string();
    let (slope, centre) = line(0.0).ok_or_else(falls)?;
    let (warmer, cooler) = (line(1.0).ok_or_else(falls)?, line(-1.0).ok_or_else(falls)?);
    let stress_sigma = points.iter().map(|p| p.2.sigma).fold(0.0, f64::max);
    let own_slope = stress_sigma * 1e-6 * 2f64.sqrt() / spread;
    let own_centre = stress_sigma * 1e-6 / slope;
    Ok((
        Estimate { value: slope, sigma: 0.5 * (warmer.0 - cooler.0).abs() }.and(own_slope),
        Estimate { value: centre, sigma: 0.5 * (warmer.1 - cooler.1).abs() }.and(own_centre),
    ))
}
