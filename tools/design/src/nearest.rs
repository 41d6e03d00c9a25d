//! The nearest design that works: of a demand that no wire meets, one number changed as little as it takes.

use crate::demand::{Joint, Method, Motion, Requirement};
use crate::design::{Design, Shortfall, best, designs};
use crate::route::Route;

/// A number is changed by steps of this factor, at most so often, and then halved back so often.
const STEP: f64 = 1.25;
const STEPS: i32 = 20;
const HALVINGS: u32 = 5;
/// So much colder air is looked at, K.
const COLDER_K: u32 = 100;

/// What of a demand is changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// Longest time there and back, s.
    Cycle(f64),
    /// Force, N.
    Force(f64),
    /// Torque, N m.
    Torque(f64),
    /// Stroke, m.
    Stroke(f64),
    /// Angle, rad.
    Angle(f64),
    /// Room, m.
    Span(f64),
    /// Passes over pulleys.
    Passes(u32),
    /// How far a tube is bent, rad.
    Bent(f64),
    /// Wires side by side.
    Wires(u32),
    /// Supply, V.
    Supply(f64),
    /// Current of a current source, A.
    Current(f64),
    /// The most current of the source, A.
    MostCurrent(f64),
    /// Wires in series.
    InSeries(u32),
    /// How a joint's wire is fixed.
    Joint(Joint),
    /// Another way to the wire.
    Method(Method),
    /// Colder air, °C.
    Ambient(f64),
    /// A shorter life, cycles.
    Life(f64),
    /// Another diameter than the one asked for, m.
    Diameter(f64),
}

/// A demand that can be met, and the design that does.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    /// What is asked for instead.
    pub change: Change,
    /// By how much, as the logarithm of the ratio; 0 where there is no number to it.
    pub distance: f64,
    /// What meets that.
    pub design: Design,
}

/// A number of a demand: how it is read, and how the demand is with another.
struct Number {
    now: f64,
    whole: bool,
    with: fn(&Requirement, f64) -> Requirement,
    change: fn(f64) -> Change,
}

/// The demands nearest to one that no wire of these diameters meets, one for each thing that may be changed, the nearest first. `others` are
/// the diameters there are besides.
pub fn nearest(asked: &Requirement, diameters_m: &[f64], others_m: &[f64]) -> Vec<Nearest> {
    let mut found = Vec::new();
    let mut plain = |change: Change, requirement: Requirement, of: &[f64]| {
        if let Some(design) = best(&designs(&requirement, of)).cloned() {
            let change = match change {
                Change::Diameter(_) => Change::Diameter(design.sizing.wire.diameter_m),
                other => other,
            };
            found.push(Nearest { change, distance: 0.0, design });
        }
    };
    if let Motion::Rotary { torque_n_m, angle_rad, joint: Some(joint) } = asked.motion {
        let other = if joint == Joint::Pulley { Joint::Lever } else { Joint::Pulley };
        let motion = Motion::Rotary { torque_n_m, angle_rad, joint: Some(other) };
        plain(Change::Joint(other), Requirement { motion, ..*asked }, diameters_m);
    }
    if asked.method == Some(Method::Stroke) {
        let method = Some(Method::Energy);
        plain(Change::Method(Method::Energy), Requirement { method, ..*asked }, diameters_m);
    }
    if !others_m.is_empty() {
        plain(Change::Diameter(f64::NAN), *asked, others_m);
    }
    if let Some(ambient_c) = colder(asked, diameters_m) {
        plain(Change::Ambient(ambient_c), Requirement { ambient_c, ..*asked }, diameters_m);
    }
    for number in numbers(asked) {
        found.extend(number.nearest(asked, diameters_m));
    }
    found.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    found
}

/// The warmest air, whole degrees below the one asked for, in which wires that do not cool down in that one do all that is asked.
fn colder(asked: &Requirement, diameters_m: &[f64]) -> Option<f64> {
    let of = |ambient_c: f64| designs(&Requirement { ambient_c, ..*asked }, diameters_m);
    let warm = |design: &Design| matches!(design.shortfall, Some(Shortfall::StaysWarm));
    if !of(asked.ambient_c).iter().any(warm) {
        return None;
    }
    (1..=COLDER_K).map(|k| asked.ambient_c.floor() - f64::from(k)).find(|ambient_c| best(&of(*ambient_c)).is_some())
}

fn numbers(asked: &Requirement) -> Vec<Number> {
    let mut all = Vec::new();
    let mut add = |now: Option<f64>, whole: bool, with, change| {
        all.extend(now.map(|now| Number { now, whole, with, change }));
    };
    let (mut force, mut stroke, mut torque, mut angle) = (None, None, None, None);
    match asked.motion {
        Motion::Linear { force_n, stroke_m } => (force, stroke) = (Some(force_n), Some(stroke_m)),
        Motion::Rotary { torque_n_m, angle_rad, .. } => (torque, angle) = (Some(torque_n_m), Some(angle_rad)),
    }
    add(asked.cycle_s, false, |asked, v| Requirement { cycle_s: Some(v), ..*asked }, Change::Cycle);
    add(force, false, |asked, v| moved(asked, Some(v), None), Change::Force);
    add(torque, false, |asked, v| moved(asked, Some(v), None), Change::Torque);
    add(stroke, false, |asked, v| moved(asked, None, Some(v)), Change::Stroke);
    add(angle, false, |asked, v| moved(asked, None, Some(v)), Change::Angle);
    add(asked.life_cycles, false, |asked, v| Requirement { life_cycles: Some(v), ..*asked }, Change::Life);
    add(asked.span_m, false, |asked, v| Requirement { span_m: Some(v), ..*asked }, Change::Span);
    let (mut passes, mut bent) = (None, None);
    match asked.route {
        Route::Straight => {}
        Route::Pulleys(count) => passes = Some(f64::from(count)),
        Route::Tube { bent_rad, .. } => bent = Some(bent_rad).filter(|bent_rad| *bent_rad > 0.0),
    }
    add(
        passes,
        true,
        |asked, v| Requirement { route: Route::Pulleys(v as u32), ..*asked },
        |v| Change::Passes(v as u32),
    );
    add(bent, false, bent_by, Change::Bent);
    add(
        asked.wires.map(f64::from),
        true,
        |asked, v| Requirement { wires: Some(v as u32), ..*asked },
        |v| Change::Wires(v as u32),
    );
    add(asked.source.supply_v, false, |asked, v| sourced(asked, |s| s.supply_v = Some(v)), Change::Supply);
    add(asked.source.current_a, false, |asked, v| sourced(asked, |s| s.current_a = Some(v)), Change::Current);
    add(
        asked.source.most_current_a,
        false,
        |asked, v| sourced(asked, |s| s.most_current_a = Some(v)),
        Change::MostCurrent,
    );
    add(
        asked.source.in_series.map(f64::from),
        true,
        |asked, v| sourced(asked, |s| s.in_series = Some(v as u32)),
        |v| Change::InSeries(v as u32),
    );
    all
}

fn moved(asked: &Requirement, effort: Option<f64>, way: Option<f64>) -> Requirement {
    let motion = match asked.motion {
        Motion::Linear { force_n, stroke_m } => {
            Motion::Linear { force_n: effort.unwrap_or(force_n), stroke_m: way.unwrap_or(stroke_m) }
        }
        Motion::Rotary { torque_n_m, angle_rad, joint } => {
            Motion::Rotary { torque_n_m: effort.unwrap_or(torque_n_m), angle_rad: way.unwrap_or(angle_rad), joint }
        }
    };
    Requirement { motion, ..*asked }
}

fn bent_by(asked: &Requirement, bent_rad: f64) -> Requirement {
    let route = match asked.route {
        Route::Tube { friction, .. } => Route::Tube { bent_rad, friction },
        other => other,
    };
    Requirement { route, ..*asked }
}

fn sourced(asked: &Requirement, change: impl FnOnce(&mut crate::demand::Source)) -> Requirement {
    let mut other = *asked;
    change(&mut other.source);
    other
}

impl Number {
    /// Two digits, or a whole number, away from what is asked for.
    fn round(&self, value: f64) -> f64 {
        let away = |scaled: f64| if value > self.now { (scaled - 1e-9).ceil() } else { (scaled + 1e-9).floor() };
        if self.whole {
            return away(value).max(1.0);
        }
        let digit = 10f64.powf(value.log10().floor() - 1.0);
        away(value / digit) * digit
    }

    /// The nearest value that works, up or down.
    fn nearest(&self, asked: &Requirement, diameters_m: &[f64]) -> Option<Nearest> {
        let asking = |value: f64| (self.with)(asked, value);
        let works = |value: f64| {
            let value = self.round(value);
            let does = |diameter_m: &f64| Design::of(&asking(value), *diameter_m).shortfall.is_none();
            diameters_m.iter().rev().any(does).then_some(value)
        };
        for step in 1..=STEPS {
            for way in [1.0, -1.0] {
                let factor = |steps: f64| self.now * STEP.powf(way * steps);
                let Some(mut found) = works(factor(f64::from(step))) else { continue };
                let (mut near, mut far) = (f64::from(step) - 1.0, f64::from(step));
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (near + far);
                    match works(factor(middle)) {
                        Some(nearer) => (found, far) = (nearer, middle),
                        None => near = middle,
                    }
                }
                let design = best(&designs(&asking(found), diameters_m)).cloned()?;
                return Some(Nearest { change: (self.change)(found), distance: (found / self.now).ln().abs(), design });
            }
        }
        None
    }
}
