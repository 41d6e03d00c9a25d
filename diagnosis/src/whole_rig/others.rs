//! What wires do to each other: the courses of all of them, by their models, and what those mean for one of them.

use nalgebra::DVector;
use rayon::prelude::*;
use sinew_physics::{DriveKind, Surroundings, drawn_meanwhile_a};
use sinew_rig::Rig;

use crate::data::Data;
use crate::fit::Fit;
use crate::simulate;
use crate::space::Space;

/// What one wire does in every recording.
pub(crate) struct Courses {
    channel: usize,
    runs: Vec<Course>,
}

/// What one wire does in one recording, by row.
struct Course {
    /// When a row begins, s.
    begins_s: Vec<f64>,
    /// When it ends, s, and how warm the wire is then, °C.
    ends_s: Vec<f64>,
    temperature_c: Vec<f64>,
    /// Share of the time it draws current, and how much then, A.
    duty: Vec<f64>,
    current_a: Vec<f64>,
}

impl Courses {
    /// Of the model at `z`; `None` where it cannot be simulated.
    pub(crate) fn of(channel: usize, data: &Data, space: &Space, z: &[f64]) -> Option<Courses> {
        Courses::of_model(channel, data, space, z, &space.model(z)?)
    }

    /// Of the model at `z` with what `rig` says of the effects that tie wires together.
    pub(crate) fn with(channel: usize, data: &Data, space: &Space, z: &[f64], rig: &Rig) -> Option<Courses> {
        let mut model = space.model(z)?;
        let tied = &rig.channels.get(channel)?.model.effects;
        if rig.neighbour_of(channel).is_some() {
            model.effects.thermal.neighbour = tied.thermal.neighbour;
        }
        if rig.at_supply_of(channel).next().is_some() {
            model.effects.electrical.supply_sag = tied.electrical.supply_sag;
        }
        Courses::of_model(channel, data, space, z, &model)
    }

    fn of_model(
        channel: usize,
        data: &Data,
        space: &Space,
        z: &[f64],
        model: &sinew_physics::WireModel,
    ) -> Option<Courses> {
        let course = |r: usize| {
            let run = space.run(data, r, z);
            let states = simulate::states(model, &run)?;
            let draws = |drive: f64, current_a: f64| match model.drive.kind {
                DriveKind::Pwm => (drive, current_a),
                DriveKind::Current => (1.0, drive),
                DriveKind::Amplifier(_) => (1.0, current_a),
                // nobody knows what for
                DriveKind::Power | DriveKind::Temperature => (0.0, 0.0),
            };
            let (duty, current_a) =
                run.inputs.iter().zip(&states).map(|((inputs, _), state)| draws(inputs.drive, state.current_a)).unzip();
            Some(Course {
                begins_s: run.time_s.clone(),
                ends_s: run.time_s.iter().zip(&run.inputs).map(|(time_s, (_, dt_s))| time_s + dt_s).collect(),
                temperature_c: states.iter().map(|state| state.temperature_c).collect(),
                duty,
                current_a,
            })
        };
        Some(Courses { channel, runs: (0..data.runs.len()).map(course).collect::<Option<_>>()? })
    }
}

/// What of its course a wire acts on others by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Acts {
    /// How warm it is.
    Warmth,
    /// What it draws.
    Current,
}

/// How well a fitted wire says what it does to others: the standard deviation of the size of that, as a share of it.
pub(crate) fn uncertainty(data: &Data, fit: &Fit, acts: Acts) -> Option<f64> {
    let strength = |z: &[f64]| {
        let model = fit.space.model(z)?;
        let courses = Courses::of_model(0, data, &fit.space, z, &model)?;
        Some(courses.runs.iter().map(|course| course.strength(acts, model.ambient_c)).sum::<f64>().sqrt())
    };
    let here = strength(&fit.z)?;
    let gradient: Vec<f64> = (0..fit.space.len())
        .into_par_iter()
        .map(|i| {
            let c = &fit.space.coordinates[i];
            let step = if fit.z[i] + c.step <= c.high { c.step } else { -c.step };
            let mut moved = fit.z.clone();
            moved[i] += step;
            Some((strength(&moved)? - here) / (step * here))
        })
        .collect::<Option<_>>()?;
    let gradient = DVector::from_vec(gradient);
    let spread = fit.information.clone().cholesky()?.solve(&gradient);
    Some(gradient.dot(&spread).max(0.0).sqrt())
}

impl Course {
    /// The square of what it acts on others by, summed over its rows.
    fn strength(&self, acts: Acts, ambient_c: f64) -> f64 {
        match acts {
            Acts::Warmth => self.temperature_c.iter().map(|temperature_c| (temperature_c - ambient_c).powi(2)).sum(),
            Acts::Current => self.duty.iter().zip(&self.current_a).map(|(duty, a)| duty * a * a).sum(),
        }
    }

    /// Whether anything is known of that time.
    fn covers(&self, time_s: f64) -> bool {
        let ends = (self.begins_s.first(), self.ends_s.last());
        matches!(ends, (Some(begin), Some(end)) if (*begin..=*end).contains(&time_s))
    }

    /// Temperature at a time, °C.
    fn temperature_c(&self, time_s: f64) -> f64 {
        let after = self.ends_s.partition_point(|end_s| *end_s < time_s).min(self.ends_s.len() - 1);
        let before = after.saturating_sub(1);
        let (from, to) = (self.temperature_c[before], self.temperature_c[after]);
        let span_s = self.ends_s[after] - self.ends_s[before];
        if span_s > 0.0 { from + (to - from) * ((time_s - self.ends_s[before]) / span_s).clamp(0.0, 1.0) } else { to }
    }

    /// What it draws on the mean over the on-phase of a wire with a duty of its own, A.
    fn drawn_meanwhile_a(&self, own_duty: f64, time_s: f64) -> f64 {
        let row = self.begins_s.partition_point(|begin_s| *begin_s <= time_s).saturating_sub(1);
        drawn_meanwhile_a(own_duty, self.duty[row], self.current_a[row])
    }
}

/// What other wires do to the wire of `channel`, by recording and row of its `data`, tied as `rig` has it; nothing
/// where it is tied to none of them.
pub(crate) fn around(rig: &Rig, channel: usize, data: &Data, courses: &[Courses]) -> Vec<Vec<Surroundings>> {
    let of = |channel: usize| courses.iter().find(|courses| courses.channel == channel);
    let neighbour = rig.neighbour_of(channel).and_then(of);
    let at_supply: Vec<&Courses> = rig.at_supply_of(channel).filter_map(of).collect();
    if neighbour.is_none() && at_supply.is_empty() {
        return vec![Vec::new(); data.runs.len()];
    }
    let of_run = |r: usize| {
        let run = &data.runs[r];
        let there = |courses: &&Courses, middle_s: f64| courses.runs.get(r).is_some_and(|run| run.covers(middle_s));
        let row = |(time_s, (inputs, dt_s)): (&f64, &(sinew_physics::Inputs, f64))| {
            let middle_s = time_s + 0.5 * dt_s;
            let known = neighbour.filter(|courses| there(courses, middle_s));
            let drawing = at_supply.iter().filter(|courses| there(courses, middle_s));
            Surroundings {
                neighbour_c: known.map(|courses| courses.runs[r].temperature_c(middle_s)),
                others_a: drawing.map(|courses| courses.runs[r].drawn_meanwhile_a(inputs.drive, middle_s)).sum(),
            }
        };
        run.time_s.iter().zip(&run.inputs).map(row).collect()
    };
    (0..data.runs.len()).map(of_run).collect()
}
