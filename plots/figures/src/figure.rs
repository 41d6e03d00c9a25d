//! The content of a figure: which curves of which recordings on which axes, gathered in one pass over each.

use std::collections::BTreeMap;

use sinew_control::default_lambda;
use sinew_plot::quantity::number;
use sinew_plot::{Field, Ink};
use sinew_rig::Rig;

use crate::source::{Sample, Source};
use crate::thin::Thin;
use crate::{Error, Kind, Order};

/// Curves over time that are drawn by default, of those that exist …
const USUAL: [&str; 9] = [
    "length_m",
    "position_m",
    "force_n",
    "duty",
    "power_w",
    "temperature_c",
    "resistance_ohm",
    "current_a",
    "ambient_c",
];
/// … and how many of them.
const USUAL_PANELS: usize = 5;
/// Channels that are drawn where none is named. More can be requested.
pub const USUAL_CHANNELS: usize = 6;
/// How many times the stretches of a curve over time a loop may have.
const LOOP: usize = 6;
/// A histogram's bins, in each of which a duration is at most this much longer than in the one before.
const BIN: f64 = 1.15;

/// A figure: panels under one title and legend.
pub struct Figure {
    /// On top.
    pub title: String,
    /// What the inks stand for.
    pub legend: Vec<(Ink, String)>,
    /// The panels.
    pub panels: Vec<Panel>,
    /// What a reader should know who misses something.
    pub notes: Vec<String>,
}

/// Curves on two axes.
pub struct Panel {
    /// What kind of figure it belongs to.
    pub kind: Kind,
    /// Above it; its vertical axis' name where it has no text.
    pub caption: String,
    /// Across.
    pub x: Field,
    /// Up.
    pub y: Field,
    /// The curves, in the order they are drawn.
    pub curves: Vec<Curve>,
}

/// A curve; NaN breaks it.
pub struct Curve {
    /// What with.
    pub ink: Ink,
    /// What it is of.
    pub name: String,
    /// Across.
    pub x: Vec<f64>,
    /// Up; as many.
    pub y: Vec<f64>,
}

/// A channel of a recording that is drawn, and its ink.
struct Subject {
    source: usize,
    channel: usize,
    ink: Ink,
    name: String,
}

/// Where a coordinate comes from.
#[derive(Clone, Copy)]
enum Take {
    Time,
    Field(usize),
    /// One field less another: the control error.
    Difference(usize, usize),
}

impl Take {
    #[inline]
    fn of(self, time_s: f64, sample: &Sample<'_>, channel: usize) -> f64 {
        match self {
            Take::Time => time_s,
            Take::Field(field) => sample.get(channel, field),
            Take::Difference(field, from) => sample.get(channel, field) - sample.get(channel, from),
        }
    }
}

/// A curve that is being gathered.
struct Gathered {
    panel: usize,
    subject: usize,
    ink: Ink,
    x: Take,
    y: Take,
    thin: Thin,
}

/// Reads the recordings and gathers what is requested.
///
/// # Errors
/// Unknown names, kinds without the fields they need, damaged files; [`Error::Nothing`] where there is nothing to draw.
pub fn gather(sources: &[Source], order: &Order, progress: &mut dyn FnMut(u64, u64)) -> Result<Figure, Error> {
    let (subjects, mut notes) = subjects(sources, order)?;
    let (mut panels, wanted) = panels(sources, order, &subjects)?;
    let each = order.points / wanted.len().max(1);
    let mut curves: Vec<Gathered> = wanted
        .into_iter()
        .map(|(panel, subject, ink, x, y)| {
            // a loop has its whole length to show, not only the width of the paper
            let most = if matches!(x, Take::Time) { order.stretches } else { LOOP * order.stretches };
            Gathered { panel, subject, ink, x, y, thin: Thin::new(each.clamp(200, most)) }
        })
        .collect();
    for (number, source) in sources.iter().enumerate() {
        let mut own: Vec<&mut Gathered> =
            curves.iter_mut().filter(|curve| subjects[curve.subject].source == number).collect();
        if own.is_empty() {
            continue;
        }
        source.each((order.from_s, order.to_s), progress, |time_s, missing, sample| {
            for curve in &mut own {
                let channel = subjects[curve.subject].channel;
                if missing {
                    curve.thin.gap();
                }
                curve.thin.push(curve.x.of(time_s, sample, channel), curve.y.of(time_s, sample, channel));
            }
        })?;
    }
    for curve in curves.into_iter().filter(|curve| !curve.thin.is_empty()) {
        let (x, y) = curve.thin.points();
        let name = subjects[curve.subject].name.clone();
        panels[curve.panel].curves.push(Curve { ink: curve.ink, name, x, y });
    }
    let drawn: Vec<Ink> = panels.iter().flat_map(|panel| &panel.curves).map(|curve| curve.ink).collect();
    let mut legend: Vec<(Ink, String)> = subjects
        .iter()
        .filter(|subject| drawn.contains(&subject.ink))
        .map(|subject| (subject.ink, subject.name.clone()))
        .collect();
    if drawn.contains(&Ink::Measured) {
        legend.push((Ink::Measured, "asked for".into()));
    }
    surfaces(sources, &subjects, &mut panels, &mut legend);
    if order.kinds.contains(&Kind::Lateness) {
        match lateness(sources)? {
            Some(panel) => {
                let several = sources.len() > 1;
                for curve in &panel.curves {
                    let name = if several { format!("{}: {}", panel.caption, curve.name) } else { curve.name.clone() };
                    if !legend.iter().any(|(ink, had)| *ink == curve.ink && *had == name) {
                        legend.push((curve.ink, name));
                    }
                }
                panels.push(panel);
            }
            None if order.insists => {
                return Err(Error::Lacks {
                    kind: Kind::Lateness.name(),
                    needs: "the figures of the driver's loop",
                    remedy: "a session taken by `sinew record` has them",
                });
            }
            None => {}
        }
    }
    panels.retain(|panel| !panel.curves.is_empty());
    if panels.is_empty() {
        return Err(Error::Nothing);
    }
    for kind in order.kinds.iter().filter(|_| order.insists) {
        if !panels.iter().any(|panel| panel.kind == *kind) {
            notes.push(format!("{}: nothing was recorded of it in that time", kind.name()));
        }
    }
    let title = order.title.clone().unwrap_or_else(|| {
        let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
        names.join(", ")
    });
    Ok(Figure { title, legend, panels, notes })
}

/// Who is drawn: of each recording the channels requested, or the first few.
fn subjects(sources: &[Source], order: &Order) -> Result<(Vec<Subject>, Vec<String>), Error> {
    for name in &order.channels {
        if !sources.iter().any(|source| source.channels.contains(name)) {
            let mut known: Vec<String> = sources.iter().flat_map(|source| source.channels.clone()).collect();
            known.dedup();
            return Err(Error::NoChannel { name: name.clone(), known });
        }
    }
    let mut notes = Vec::new();
    let mut subjects = Vec::new();
    for (number, source) in sources.iter().enumerate() {
        let all: Vec<usize> = (0..source.channels.len()).collect();
        let channels: Vec<usize> = match order.channels.is_empty() {
            true => all,
            false => all.into_iter().filter(|i| order.channels.contains(&source.channels[*i])).collect(),
        };
        let most = if order.channels.is_empty() { USUAL_CHANNELS } else { usize::MAX };
        if channels.len() > most {
            let left: Vec<&str> = channels[most..].iter().map(|i| source.channels[*i].as_str()).collect();
            notes.push(format!("{}: not drawn (choose with --channel): {}", source.name, left.join(", ")));
        }
        for channel in channels.into_iter().take(most) {
            let own = &source.channels[channel];
            let name = match (sources.len() > 1, source.has_channels()) {
                (true, true) => format!("{}: {own}", source.name),
                _ => own.clone(),
            };
            let ink = Ink::Series((subjects.len() % usize::from(Ink::SERIES)) as u8);
            subjects.push(Subject { source: number, channel, ink, name });
        }
    }
    Ok((subjects, notes))
}

type Wanted = (usize, usize, Ink, Take, Take);

/// The panels of the kinds requested, still empty, and the curves that belong into them.
fn panels(sources: &[Source], order: &Order, subjects: &[Subject]) -> Result<(Vec<Panel>, Vec<Wanted>), Error> {
    let mut panels: Vec<Panel> = Vec::new();
    let mut wanted: Vec<Wanted> = Vec::new();
    let field = |subject: &Subject, name: &str| sources[subject.source].field(name);
    if order.kinds.contains(&Kind::Time) {
        for name in quantities(sources, order)? {
            let at = panels.len();
            let y = Field::of(&name);
            panels.push(Panel {
                kind: Kind::Time,
                caption: y.title.clone(),
                x: Field::of("time_s"),
                y,
                curves: Vec::new(),
            });
            let asked = if name == "length_m" || name == "measured_length_m" { "target_m" } else { "" };
            for (ink, name) in [(Some(Ink::Measured), asked), (None, name.as_str())] {
                for (number, subject) in subjects.iter().enumerate() {
                    if let Some(field) = field(subject, name) {
                        wanted.push((at, number, ink.unwrap_or(subject.ink), Take::Time, Take::Field(field)));
                    }
                }
            }
        }
    }
    // the first of several fields that a subject has
    let first =
        |subject: &Subject, of: &[&'static str]| of.iter().find_map(|name| Some((*name, field(subject, name)?)));
    const LENGTH: [&str; 3] = ["length_m", "measured_length_m", "position_m"];
    for (kind, across, up, needs, remedy) in [
        (
            Kind::Hysteresis,
            &["temperature_c", "reckoned_temperature_c"][..],
            &LENGTH[..],
            "a length and a temperature",
            "a session has both, the temperature as the driver believes it; a CSV file needs position_m and temperature_c",
        ),
        (
            Kind::Resistance,
            &LENGTH[..],
            &["resistance_ohm"][..],
            "a length and a resistance",
            "a session of a driver has both; the columns of CSV have no resistance",
        ),
        (
            Kind::Tension,
            &LENGTH[..],
            &["force_n"][..],
            "a length and a tension",
            "the test machine measures both; in CSV they are position_m and force_n",
        ),
    ] {
        if !order.kinds.contains(&kind) {
            continue;
        }
        let mut found = false;
        for (number, subject) in subjects.iter().enumerate() {
            let (Some((x, x_field)), Some((y, y_field))) = (first(subject, across), first(subject, up)) else {
                continue;
            };
            found = true;
            let (x, y) = (Field::of(x), Field::of(y));
            let at = panels.iter().position(|p| p.kind == kind && p.x == x && p.y == y).unwrap_or_else(|| {
                let caption = format!("{} against {}", y.title, x.title.to_lowercase());
                panels.push(Panel { kind, caption, x, y, curves: Vec::new() });
                panels.len() - 1
            });
            wanted.push((at, number, subject.ink, Take::Field(x_field), Take::Field(y_field)));
        }
        if !found && order.insists {
            return Err(Error::Lacks { kind: kind.name(), needs, remedy });
        }
    }
    if order.kinds.contains(&Kind::Phase) {
        let at = panels.len();
        let (x, y) =
            (Field { title: "Error e, length less the one asked for".into(), unit: "m" }, Field::of("velocity_m_s"));
        let caption = "Phase plane: speed over error".to_owned();
        panels.push(Panel { kind: Kind::Phase, caption, x, y, curves: Vec::new() });
        let before = wanted.len();
        for (number, subject) in subjects.iter().enumerate() {
            let fields = ["length_m", "target_m", "velocity_m_s"].map(|name| field(subject, name));
            if let [Some(length), Some(target), Some(speed)] = fields {
                wanted.push((at, number, subject.ink, Take::Difference(length, target), Take::Field(speed)));
            }
        }
        if wanted.len() == before && order.insists {
            return Err(Error::Lacks {
                kind: Kind::Phase.name(),
                needs: "lengths, targets and speeds",
                remedy: "a session of a driver has them; CSV has not",
            });
        }
    }
    Ok((panels, wanted))
}

/// The quantities over time: those requested, or the usual ones among those recorded.
fn quantities(sources: &[Source], order: &Order) -> Result<Vec<String>, Error> {
    let known = || sources.iter().flat_map(Source::known);
    if order.quantities.is_empty() {
        let usual = USUAL.into_iter().filter(|name| known().any(|known| known == *name)).take(USUAL_PANELS);
        let usual: Vec<String> = usual.map(str::to_owned).collect();
        return Ok(if usual.is_empty() { known().take(USUAL_PANELS).map(str::to_owned).collect() } else { usual });
    }
    order
        .quantities
        .iter()
        .map(|asked| {
            let exact = known().find(|name| name == asked);
            exact.or_else(|| known().find(|name| Field::is_meant(asked, name))).map(str::to_owned).ok_or_else(|| {
                let mut names: Vec<String> = known().map(str::to_owned).collect();
                names.sort();
                names.dedup();
                Error::NoQuantity { name: asked.clone(), known: names }
            })
        })
        .collect()
}

/// λ of a channel's surface, 1/s: the rig file's, or the default the driver takes.
fn lambda(rig: &Rig, channel: &str) -> Option<f64> {
    let (number, channel) = rig.channel(channel)?;
    channel.control.lambda_per_s.or_else(|| {
        let power_w = channel.limits.max_power_w.min(channel.limits.max_duty * channel.full_power_w());
        let default = default_lambda(&rig.nominal_model(number), power_w).value;
        (default > 0.0 && default.is_finite()).then_some(default)
    })
}

/// Draws the surface into the phase plane: what moves on σ = ë + 2λė + λ²e = 0 arrives along ė = −λe, the double root's
/// own direction; on the first-order surface it moves on that line itself.
fn surfaces(sources: &[Source], subjects: &[Subject], panels: &mut [Panel], legend: &mut Vec<(Ink, String)>) {
    let Some(panel) = panels.iter_mut().find(|panel| panel.kind == Kind::Phase && !panel.curves.is_empty()) else {
        return;
    };
    let lambdas: Vec<f64> = subjects
        .iter()
        .filter_map(|subject| {
            let source = &sources[subject.source];
            lambda(source.rig.as_ref()?, &source.channels[subject.channel])
        })
        .collect();
    let Some((least, most)) = sinew_plot::extent(lambdas.into_iter()) else { return };
    let Some((left, right)) = sinew_plot::extent(panel.curves.iter().flat_map(|curve| curve.x.iter().copied())) else {
        return;
    };
    let Some((low, high)) = sinew_plot::extent(panel.curves.iter().flat_map(|curve| curve.y.iter().copied())) else {
        return;
    };
    let name = match (number(least), number(most)) {
        (one, other) if one == other => format!("surface: ė = −λe, λ = {one}/s"),
        (one, other) => format!("surface: ė = −λe, λ = {one} to {other}/s"),
    };
    for lambda in if most - least > 1e-3 * most { vec![least, most] } else { vec![most] } {
        // as far as the curves go, so that the line does not widen the axes
        let ends = [(left.min(0.0)).max(-high.max(0.0) / lambda), (right.max(0.0)).min(-low.min(0.0) / lambda)];
        let y = ends.iter().map(|e| -lambda * e).collect();
        panel.curves.push(Curve { ink: Ink::Plain, name: name.clone(), x: ends.to_vec(), y });
    }
    legend.push((Ink::Plain, name));
}

/// How late the loop was woken, and how long its cycles took: shares of all cycles while it was recorded.
fn lateness(sources: &[Source]) -> Result<Option<Panel>, Error> {
    let mut curves = Vec::new();
    let mut inks = 0..Ink::SERIES;
    for source in sources {
        let figures = source.loop_figures()?;
        let (Some(first), Some(last)) = (figures.first(), figures.last()) else { continue };
        // the driver counts from its start: what it had counted by the first look is taken off, where there are two
        let before = (figures.len() > 1).then_some(first);
        for (name, late) in [("woken late by", true), ("cycle took", false)] {
            let of = |figures: &sinew_recording::session::LoopFigures| -> BTreeMap<u64, u64> {
                let durations = if late { &figures.lateness } else { &figures.cycle_time };
                durations.up_to_ns.iter().copied().zip(durations.count.iter().copied()).collect()
            };
            let before = before.map(of).unwrap_or_default();
            let counted =
                of(last).into_iter().map(|(ns, n)| (ns, n.saturating_sub(before.get(&ns).copied().unwrap_or(0))));
            let (x, y) = histogram(counted);
            let name = if sources.len() > 1 { format!("{}: {name}", source.name) } else { name.to_owned() };
            if let Some(ink) = inks.next().filter(|_| !x.is_empty()) {
                curves.push(Curve { ink: Ink::Series(ink), name, x, y });
            }
        }
    }
    let x = Field { title: "Duration".into(), unit: "s" };
    let y = Field { title: "Share of cycles".into(), unit: "1" };
    let caption = "The loop: share of cycles by duration".to_owned();
    Ok((!curves.is_empty()).then_some(Panel { kind: Kind::Lateness, caption, x, y, curves }))
}

/// The outline of a histogram over durations in s, as shares.
fn histogram(counted: impl Iterator<Item = (u64, u64)>) -> (Vec<f64>, Vec<f64>) {
    let mut bins: BTreeMap<i32, u64> = BTreeMap::new();
    for (ns, count) in counted.filter(|(_, count)| *count > 0) {
        // what is below 100 ns is one bin: nothing on this axis is so quick
        *bins.entry(((ns as f64).max(100.0).ln() / BIN.ln()).floor() as i32).or_default() += count;
    }
    let total: u64 = bins.values().sum();
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let least = 0.5 / total.max(1) as f64;
    let edge = |bin: i32| BIN.powi(bin) * 1e-9;
    let mut last = None;
    for (&bin, &count) in &bins {
        if last != Some(bin) {
            if let Some(last) = last {
                x.push(edge(last));
                y.push(least);
            }
            x.push(edge(bin));
            y.push(least);
        }
        let share = count as f64 / total as f64;
        x.extend([edge(bin), edge(bin + 1)]);
        y.extend([share, share]);
        last = Some(bin + 1);
    }
    if let Some(last) = last {
        x.push(edge(last));
        y.push(least);
    }
    (x, y)
}
