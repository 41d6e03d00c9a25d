//! One concealed case: rig file, two recordings, answer.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

use super::bench::{Bench, Kin, Sensor, Set};
use super::laws;
use super::levels::sized;
use super::magnitudes::{CATALOGUE, Drawn, OUTSIDE};
use super::plan::{Null, Spec, Trap, What};
use super::programme::programme;
use super::signals::{Errors, Put, Table, record};
use super::truth::{Effects, Truth};

/// What is concealed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The case's name.
    pub name: String,
    /// What it was drawn with.
    pub seed: u64,
    /// `null`, `single`, `several`, `outside` or `trap`.
    pub group: String,
    /// What kind of it, in words.
    pub kind: String,
    /// The verdict that is right.
    pub verdict: String,
    /// The effects that are there.
    pub accept: Vec<String>,
    /// Sets of effects that are the same circuit on any bench: either name is right.
    pub same: Vec<Vec<String>>,
    /// The guilty equation of the first, and others that would be right.
    pub equation: Option<String>,
    /// All equations that would be right.
    pub equations: Vec<String>,
    /// The effects' parameters, in the rig file's units.
    pub effects: Effects,
    /// Which of them make the effect's size.
    pub sizes: BTreeMap<String, Vec<String>>,
    /// The level meant to be left after refitting, RMS over the noise; none where nothing is.
    pub target: Option<f64>,
    /// The level that is left, of everything together.
    pub level: f64,
    /// The level that each effect leaves by itself.
    pub levels: BTreeMap<String, f64>,
    /// Standard deviation of each effect's size in a fit of the true model to what is diagnosed, as a share of the size.
    pub deviations: BTreeMap<String, f64>,
    /// Keys that the rig file holds at their null.
    pub left_out: BTreeMap<String, f64>,
    /// True noise by column.
    pub noise: BTreeMap<String, f64>,
    /// The uncertain parameters as they truly are.
    pub parameters: BTreeMap<String, f64>,
    /// Which generator made it: 1 or 2.
    pub generator: u8,
    /// A wire and load unlike those of development.
    pub unlike: bool,
    /// Effects that the structure of this truth holds, too: to name them is neither right nor wrong. With a dot at the
    /// end, all of that equation.
    pub allowed: Vec<String>,
}

/// A case as it is handed out.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The rig file.
    pub rig_toml: String,
    /// The recording to diagnose.
    pub train: Table,
    /// Another recording to diagnose beside it, where there is one.
    pub beside: Option<Table>,
    /// Another recording of the same wire, for judging only.
    pub held: Table,
    /// Candidates of a laboratory's own, where it has some.
    pub laws: Option<String>,
    /// What is concealed.
    pub answer: Answer,
}

/// Draws of bench and size before a target is given up.
const ATTEMPTS: u64 = 3;

/// Everything of one draw.
struct Draw {
    bench: Bench,
    truth: Truth,
    effects: Effects,
    sizes: BTreeMap<String, Vec<String>>,
    left_out: BTreeMap<String, f64>,
    levels: BTreeMap<String, f64>,
    deviations: BTreeMap<String, f64>,
    level: f64,
    errors: Errors,
    train: Vec<f64>,
    rng: SmallRng,
}

/// Makes the case of a plan's entry.
pub fn make(spec: &Spec) -> Case {
    finish(spec, nearest(spec, draw, |draw| &draw.levels))
}

/// The draw whose least visible member is nearest to what the plan requests; the first one that is near enough.
pub fn nearest<D>(spec: &Spec, draw: impl Fn(&Spec, u64) -> D, levels: impl Fn(&D) -> &BTreeMap<String, f64>) -> D {
    let mut best: Option<(f64, D)> = None;
    for attempt in 0..ATTEMPTS {
        let draw = draw(spec, attempt);
        let least = levels(&draw).values().copied().fold(f64::INFINITY, f64::min);
        let off = spec.target.map_or(0.0, |target| (least / target).max(1e-3).ln().abs());
        if best.as_ref().is_none_or(|(least_off, _)| off < *least_off) {
            best = Some((off, draw));
        }
        if off < 0.5 || spec.target.is_none() {
            break;
        }
    }
    let Some((_, draw)) = best else { unreachable!("there is at least one attempt") };
    draw
}

fn draw(spec: &Spec, attempt: u64) -> Draw {
    let mut rng = SmallRng::seed_from_u64(spec.seed.wrapping_mul(31).wrapping_add(attempt));
    let ids: Vec<&str> = match &spec.what {
        What::Effects(ids) => ids.iter().map(String::as_str).collect(),
        What::Outside(name) | What::Own(name) => vec![name.as_str()],
        What::Null(_) | What::Trap(_) => Vec::new(),
    };
    let needs: Vec<Sensor> = CATALOGUE.iter().filter(|k| ids.contains(&k.id)).filter_map(|k| k.needs).collect();
    let encoder = ids.iter().any(|id| id.contains("encoder"));
    // hard ones and traps get every sensor there is
    let all = attempt > 0 || needs.contains(&Sensor::V2) || ids.len() > 1 || matches!(spec.what, What::Trap(_));
    let mut bench = Bench::random(&mut rng, spec.kin, all.then_some(Set::All), spec.long);
    while needs.iter().any(|s| !bench.sensors.contains_key(s))
        || (encoder && !bench.sensors.contains_key(&Sensor::Position))
    {
        bench = Bench::random(&mut rng, spec.kin, None, spec.long);
    }
    let drawn: Vec<Drawn> = ids.iter().map(|id| Drawn::new(&mut rng, id)).collect();
    let mut left_out = BTreeMap::new();
    for effect in &drawn {
        for (key, null) in effect.null(&bench.believed) {
            bench.believed.set(key, null);
            left_out.insert(key.to_string(), null);
        }
    }
    let mut base =
        if spec.what == What::Null(Null::Exact) { bench.believed.clone() } else { bench.scattered(&mut rng) };
    for (key, null) in &left_out {
        let null = if key == "martensite_modulus_gpa" { base.get("austenite_modulus_gpa") } else { *null };
        base.set(key, null);
    }
    let train = programme(&mut rng, &bench.believed, bench.rate_hz, bench.seconds);
    let mut truth = base.clone();
    let (mut effects, mut sizes) = (Effects::new(), BTreeMap::new());
    let (mut levels, mut deviations) = (BTreeMap::new(), BTreeMap::new());
    let found = sized(&mut rng, &bench, &base, &drawn, spec.target.unwrap_or(3.0), &train);
    for ((effect, (size, level)), deviation) in drawn.iter().zip(&found.each).zip(&found.deviations) {
        effect.put(&bench, &mut truth, *size, &mut effects);
        let (_, keys) = effect.parameters(&bench, &base, *size);
        sizes.insert(effect.id().to_string(), keys.iter().map(ToString::to_string).collect());
        levels.insert(effect.id().to_string(), *level);
        // two recordings know twice as much
        let deviation = if spec.both { deviation / 2f64.sqrt() } else { *deviation };
        deviations.insert(effect.id().to_string(), deviation);
    }
    let level = found.level;
    let errors = match &spec.what {
        What::Null(Null::Coloured) => Errors::Coloured(rng.random_range(0.3..=0.9)),
        What::Null(Null::Quantised) => Errors::Quantised(rng.random_range(2.0..=8.0)),
        What::Null(Null::Missing) => Errors::Missing(rng.random_range(0.03..=0.15)),
        _ => Errors::White,
    };
    truth.beyond.uniform_nodes = spec.what == What::Null(Null::Nodes);
    Draw { bench, truth, effects, sizes, left_out, levels, deviations, level, errors, train, rng }
}

/// An effect of the catalogue at `size` natural units on a bench with every sensor, its level not sought: rig file,
/// a recording, and everything that is true.
#[cfg(test)]
pub fn plain(id: &str, size: f64, seed: u64) -> Case {
    let mut rng = SmallRng::seed_from_u64(seed);
    let bench = Bench { seconds: 30.0, ..Bench::random(&mut rng, Kin::Alike, Some(Set::All), false) };
    let effect = Drawn::new(&mut rng, id);
    let mut truth = bench.scattered(&mut rng);
    let mut effects = Effects::new();
    effect.put(&bench, &mut truth, size, &mut effects);
    let train = programme(&mut rng, &bench.believed, bench.rate_hz, bench.seconds);
    let draw = Draw {
        bench,
        truth,
        effects,
        sizes: BTreeMap::new(),
        left_out: BTreeMap::new(),
        levels: BTreeMap::new(),
        deviations: BTreeMap::new(),
        level: f64::NAN,
        errors: Errors::White,
        train,
        rng,
    };
    let what = What::Effects(vec![id.to_string()]);
    let spec = Spec { name: "plain".into(), seed, what, target: None, long: false, ..Spec::default() };
    finish(&spec, draw)
}

fn finish(spec: &Spec, mut draw: Draw) -> Case {
    let rng = &mut draw.rng;
    let (bench, truth) = (&draw.bench, &draw.truth);
    let mut put = Put::new();
    let mut train = record(rng, bench, truth, &draw.train, draw.errors, &mut put);
    let beside = spec.both.then(|| {
        let other = programme(rng, &bench.believed, bench.rate_hz, bench.seconds);
        record(rng, bench, truth, &other, draw.errors, &mut put)
    });
    let other = programme(rng, &bench.believed, bench.rate_hz, bench.seconds);
    let held = record(rng, bench, truth, &other, draw.errors, &mut put);
    let mut rig_toml = bench.rig_toml(&spec.name);
    if let What::Trap(trap) = spec.what {
        spoil(rng, trap, &mut train, &mut rig_toml);
    }
    let accept: Vec<String> = match &spec.what {
        What::Own(name) => laws::id_of(name).into_iter().collect(),
        _ => draw.effects.keys().cloned().collect(),
    };
    let equations: Vec<String> = match &spec.what {
        What::Outside(name) | What::Own(name) => OUTSIDE
            .iter()
            .find(|(n, _, _)| n == name)
            .map(|(_, equations, _)| equations.iter().map(ToString::to_string).collect())
            .unwrap_or_default(),
        _ => accept.iter().filter_map(|id| id.split('.').next()).map(String::from).collect(),
    };
    let (group, kind, verdict) = match &spec.what {
        What::Null(Null::Exact) => ("null", Null::Exact.words().to_string(), "agrees"),
        What::Null(null) => ("null", null.words().to_string(), "parameters_off"),
        What::Effects(ids) if ids.len() == 1 => ("single", ids[0].clone(), "physics_missing"),
        What::Effects(ids) => ("several", ids.join(" + "), "physics_missing"),
        What::Own(name) => ("own", name.clone(), "physics_missing"),
        What::Outside(name) => ("outside", name.clone(), "unknown_physics"),
        What::Trap(trap) => ("trap", trap.words().to_string(), "none"),
    };
    let quantised = matches!(draw.errors, Errors::Quantised(_));
    let noise = bench
        .sensors
        .iter()
        .map(|(sensor, noise)| {
            let put_on = put.get(sensor).map_or(*noise, |(squares, count)| (squares / count).sqrt());
            (sensor.column().to_string(), if quantised { put_on } else { *noise })
        })
        .collect();
    let parameters = super::bench::PRIORS.iter().map(|(key, _)| (key.to_string(), truth.get(key))).collect();
    let series = ["electrical.lead_resistance", "electrical.supply_sag"];
    let same = if accept.iter().any(|id| series.contains(&id.as_str())) {
        vec![series.iter().map(ToString::to_string).collect()]
    } else {
        Vec::new()
    };
    let answer = Answer {
        name: spec.name.clone(),
        seed: spec.seed,
        group: group.into(),
        kind,
        verdict: verdict.into(),
        accept,
        same,
        equation: equations.first().cloned(),
        equations,
        effects: draw.effects,
        sizes: draw.sizes,
        target: spec.target,
        level: draw.level,
        levels: draw.levels,
        deviations: draw.deviations,
        left_out: draw.left_out,
        noise,
        parameters,
        generator: 1,
        unlike: spec.kin == Kin::Unlike,
        allowed: Vec::new(),
    };
    let laws = matches!(spec.what, What::Own(_)).then(|| laws::CANDIDATES.to_string());
    Case { rig_toml, train, beside, held, laws, answer }
}

/// Breaks a recording, or what it is declared to belong to.
fn spoil(rng: &mut SmallRng, trap: Trap, table: &mut Table, rig_toml: &mut String) {
    let rows = table.time_s.len();
    match trap {
        Trap::ClockScaled => table.time_s.iter_mut().for_each(|t| *t *= 2.0),
        Trap::Restamped => {
            // samples are lost three times, and the clock does not know
            for _ in 0..3 {
                let len = table.time_s.len();
                let (from, lost) = (rng.random_range(len / 8..len / 2), len / 12);
                for (_, values) in &mut table.columns {
                    values.drain(from..from + lost);
                }
                table.time_s.truncate(len - lost);
            }
        }
        Trap::Saturated => {
            for name in ["v3_v", "position_m", "force_n"] {
                if let Some(values) = table.column(name) {
                    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    let top = low + 0.6 * (high - low);
                    values.iter_mut().for_each(|v| *v = v.min(top));
                    break;
                }
            }
        }
        Trap::Stuck => {
            if let Some(values) = table.column("position_m") {
                let stuck = values[rows / 3];
                values[rows / 3..].fill(stuck);
            }
        }
        Trap::Millimetres => {
            if let Some(values) = table.column("position_m") {
                values.iter_mut().for_each(|v| *v *= 1e3);
            }
        }
        Trap::Milliamperes => {
            if let Some(values) = table.column("current_a") {
                values.iter_mut().for_each(|v| *v *= 1e3);
            }
        }
        Trap::TwoSamples => {
            table.time_s.truncate(2);
            table.columns.iter_mut().for_each(|(_, values)| values.truncate(2));
        }
        Trap::NoExcitation => {
            let first: Vec<(&str, f64)> = table.columns.iter().map(|(name, values)| (*name, values[0])).collect();
            for ((name, values), (_, first)) in table.columns.iter_mut().zip(first) {
                let spread = if name == &"duty" { 0.0 } else { 1e-4 * first.abs() };
                for v in values.iter_mut() {
                    *v = first + spread * rng.random_range(-1.0..=1.0);
                }
            }
        }
        Trap::OtherWire => {
            *rig_toml = rig_toml
                .lines()
                .map(|line| match line.strip_prefix("diameter_mm = ").and_then(|d| d.parse::<f64>().ok()) {
                    Some(diameter) => format!("diameter_mm = {}\n", 2.0 * diameter),
                    None => format!("{line}\n"),
                })
                .collect();
        }
        Trap::Exchanged => {
            let moved = table.column("v2_v").map(std::mem::take);
            if let (Some(v2), Some(v3)) = (moved, table.column("v3_v")) {
                let v3 = std::mem::replace(v3, v2);
                if let Some(place) = table.column("v2_v") {
                    *place = v3;
                }
            }
        }
    }
}

impl Case {
    /// Writes its files into a folder.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        fs::create_dir_all(folder)?;
        fs::write(folder.join("rig.toml"), &self.rig_toml)?;
        fs::write(folder.join("answer.json"), serde_json::to_string_pretty(&self.answer)? + "\n")?;
        self.train.write(&folder.join("train.csv.gz"))?;
        if let Some(beside) = &self.beside {
            beside.write(&folder.join("beside.csv.gz"))?;
        }
        if let Some(laws) = &self.laws {
            fs::write(folder.join("laws.toml"), laws)?;
        }
        self.held.write(&folder.join("held.csv.gz"))
    }
}

impl Table {
    fn write(&self, path: &Path) -> io::Result<()> {
        let mut file = io::BufWriter::new(GzEncoder::new(File::create(path)?, Compression::fast()));
        write!(file, "time_s")?;
        for (name, _) in &self.columns {
            write!(file, ",{name}")?;
        }
        writeln!(file)?;
        for (i, time) in self.time_s.iter().enumerate() {
            write!(file, "{}", (time * 1e6).round() / 1e6)?;
            for (_, values) in &self.columns {
                match values[i] {
                    v if v.is_nan() => write!(file, ",")?,
                    v => write!(file, ",{v}")?,
                }
            }
            writeln!(file)?;
        }
        file.into_inner().map_err(io::IntoInnerError::into_error)?.finish()?;
        Ok(())
    }
}
