//! A recording in memory: columns over one time, and the inputs a simulated wire takes from them.

use sinew_physics::{DriveKind, Inputs, Load, WireModel};

use crate::column::{Column, TIME, drive_column, imposed_column, required_inputs};
use crate::error::{Error, Needed, What};
use crate::smooth;

/// Fewest samples anything can be computed from: two intervals.
pub const MIN_SAMPLES: usize = 3;
/// Longest recording, in s (eleven days). What is longer has its times in another unit, and would be simulated for hours.
pub const MAX_DURATION_S: f64 = 1e6;
/// Rounding allowed at the ends of the duty's range.
pub(crate) const DUTY_SLACK: f64 = 1e-6;

/// The samples of one channel. Times increase and are finite; a missing sample is NaN; nothing is infinite.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    name: String,
    time_s: Vec<f64>,
    columns: [Option<Vec<f64>>; Column::COUNT],
}

impl Recording {
    /// A recording of these times, in s, and no columns yet. `name` is what messages call it, usually the file.
    ///
    /// # Errors
    /// Fewer than [`MIN_SAMPLES`] times, or times that are not finite, do not increase or span over [`MAX_DURATION_S`].
    pub fn new(name: impl Into<String>, time_s: Vec<f64>) -> Result<Recording, Error> {
        let name = name.into();
        let wrong = |what| Error::new(&name, what).in_column(TIME);
        for (i, &found) in time_s.iter().enumerate() {
            if !found.is_finite() {
                return Err(wrong(What::Infinite { found: found.to_string() }));
            }
            if i > 0 && found <= time_s[i - 1] {
                return Err(wrong(What::TimeNotIncreasing { previous: time_s[i - 1], found }));
            }
        }
        let recording = Recording::checked(name, time_s, Default::default());
        let (found, found_s) = (recording.len(), recording.duration_s());
        if found < MIN_SAMPLES {
            return Err(Error::new(&recording.name, What::TooFewSamples { found, least: MIN_SAMPLES }));
        }
        if found_s > MAX_DURATION_S {
            let what = What::TooLong { found_s, limit_s: MAX_DURATION_S };
            return Err(Error::new(&recording.name, what).in_column(TIME));
        }
        Ok(recording)
    }

    /// From parts that are known to be right.
    pub(crate) fn checked(name: String, time_s: Vec<f64>, columns: [Option<Vec<f64>>; Column::COUNT]) -> Recording {
        Recording { name, time_s, columns }
    }

    /// Puts a column in, in its own unit, NaN where a sample is missing; takes the place of one already there.
    ///
    /// # Errors
    /// Another number of samples than times, or an infinite one.
    pub fn set(&mut self, column: Column, values: Vec<f64>) -> Result<(), Error> {
        let wrong = |what| Error::new(&self.name, what).in_column(column.name());
        if values.len() != self.len() {
            return Err(wrong(What::WrongLength { expected: self.len(), found: values.len() }));
        }
        if let Some(bad) = values.iter().find(|v| v.is_infinite()) {
            return Err(wrong(What::Infinite { found: bad.to_string() }));
        }
        self.columns[column.index()] = Some(values);
        Ok(())
    }

    /// Takes a column out.
    pub fn remove(&mut self, column: Column) -> Option<Vec<f64>> {
        self.columns[column.index()].take()
    }

    /// What messages call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Times of the samples, s, increasing.
    pub fn time_s(&self) -> &[f64] {
        &self.time_s
    }

    /// A column, in its own unit; NaN = missing.
    pub fn get(&self, column: Column) -> Option<&[f64]> {
        self.columns[column.index()].as_deref()
    }

    /// The columns there are, in the order of [`Column::ALL`].
    pub fn columns(&self) -> impl Iterator<Item = (Column, &[f64])> {
        Column::ALL.into_iter().filter_map(|c| Some((c, self.get(c)?)))
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Never: an empty file is no recording.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Whether it has the same samples as another one, whatever their files are called.
    pub fn has_the_samples_of(&self, other: &Recording) -> bool {
        // missing samples are not equal to themselves: by their bits
        let same = |a: &[f64], b: &[f64]| a.iter().map(|v| v.to_bits()).eq(b.iter().map(|v| v.to_bits()));
        self.time_s == other.time_s
            && self.columns().map(|(column, _)| column).eq(other.columns().map(|(column, _)| column))
            && self.columns().zip(other.columns()).all(|((_, a), (_, b))| same(a, b))
    }

    /// From the first sample to the last, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// How long the inputs of row `row` hold, s: to the next row; the last row as long as the one before.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn interval_s(&self, row: usize) -> f64 {
        let t = &self.time_s;
        if row + 1 < t.len() { t[row + 1] - t[row] } else { t[row] - t[row - 1] }
    }

    /// The typical interval between samples, s: the median, which gaps do not move.
    pub fn median_interval_s(&self) -> f64 {
        let mut intervals: Vec<f64> = self.time_s.windows(2).map(|w| w[1] - w[0]).collect();
        let middle = intervals.len() / 2;
        *intervals.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// Whether the inputs this wire needs are there, without holes and within their ranges.
    ///
    /// # Errors
    /// The first column that is not, and when. [`read`](crate::read()) with a model has checked this, and names the line.
    pub fn check_inputs(&self, model: &WireModel) -> Result<(), Error> {
        for column in required_inputs(model) {
            let Some(values) = self.get(column) else {
                let present = std::iter::once(TIME).chain(self.columns().map(|(c, _)| c.name()));
                return Err(missing_input(&self.name, column, model, present.map(str::to_string).collect()));
            };
            for (value, &time_s) in values.iter().zip(&self.time_s) {
                check_input(column, *value, time_s)
                    .map_err(|what| Error::new(&self.name, what).in_column(column.name()))?;
            }
        }
        Ok(())
    }

    /// What drives the wire, row by row: its inputs and for how long, in s.
    ///
    /// Start the wire with [`sinew_physics::Wire::with_inputs`] of the first row, then step it through all rows; after
    /// each step its outputs stand beside the measured columns of that row. Where the recording has no supply voltage,
    /// ambient temperature or disturbance, the rig's own (or 0) is taken; where one sample of them is missing, the last one.
    ///
    /// A measured supply and ambient drive the wire by the level beneath their noise, which is found anew at every call:
    /// who simulates the same rows many times collects them once.
    ///
    /// # Errors
    /// As [`Recording::check_inputs`].
    pub fn inputs_for(
        &self,
        model: &WireModel,
    ) -> Result<impl ExactSizeIterator<Item = (Inputs, f64)> + Clone + use<'_>, Error> {
        self.check_inputs(model)?;
        let drive = self.get(drive_column(model.drive.kind)).unwrap_or(&[]);
        let imposed = imposed_column(&model.load).and_then(|c| self.get(c));
        let level = |column: Column| self.get(column).map(|values| smooth::level(&self.time_s, values));
        let (supply, ambient) = (level(Column::SupplyV), level(Column::AmbientC));
        let disturbance = self.get(Column::DisturbanceN);
        let clamp_duty = model.drive.kind == DriveKind::Pwm;
        let known = |column: Option<&[f64]>, fallback: f64| {
            column.and_then(|c| c.iter().copied().find(|v| !v.is_nan())).unwrap_or(fallback)
        };
        // a hole at the very start is filled from the first sample that is there
        let mut supply_v = known(supply.as_deref(), model.drive.supply_v);
        let mut ambient_c = known(ambient.as_deref(), model.ambient_c);
        let mut external_n = known(disturbance, 0.0);
        let hold = |last: &mut f64, column: Option<&[f64]>, row: usize| {
            if let Some(value) = column.map(|c| c[row]).filter(|v| !v.is_nan()) {
                *last = value;
            }
            *last
        };
        Ok((0..self.len()).map(move |row| {
            let inputs = Inputs {
                drive: if clamp_duty { drive[row].clamp(0.0, 1.0) } else { drive[row] },
                supply_v: hold(&mut supply_v, supply.as_deref(), row),
                ambient_c: hold(&mut ambient_c, ambient.as_deref(), row),
                external_n: hold(&mut external_n, disturbance, row),
                imposed: imposed.map_or(0.0, |c| c[row]),
            };
            (inputs, self.interval_s(row))
        }))
    }
}

/// The error of a required column that is not there.
pub(crate) fn missing_input(name: &str, input: Column, model: &WireModel, present: Vec<String>) -> Error {
    let because = match model.load {
        _ if input == drive_column(model.drive.kind) => Needed::Drive(model.drive.kind),
        Load::ImposedForce => Needed::ImposedForce,
        _ => Needed::ImposedPosition,
    };
    Error::new(name, What::MissingInput { input, because, present })
}

/// What is wrong with one sample of an input.
pub(crate) fn check_input(column: Column, value: f64, time_s: f64) -> Result<(), What> {
    if value.is_nan() {
        return Err(What::MissingSample { time_s });
    }
    check_range(column, value, true)
}

/// What is wrong with one sample that is there.
pub(crate) fn check_range(column: Column, value: f64, input: bool) -> Result<(), What> {
    match column {
        Column::Duty if !(-DUTY_SLACK..=1.0 + DUTY_SLACK).contains(&value) => {
            Err(What::DutyOutOfRange { found: value })
        }
        // a measured power has an offset and noise, one that drives the model has not
        Column::PowerW if input && value < 0.0 => Err(What::NegativePower { found: value }),
        Column::TemperatureC | Column::AmbientC if !(-273.15..=1500.0).contains(&value) => {
            Err(What::TemperatureOutOfRange { found: value })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::model;

    fn ramp() -> Recording {
        let mut r = Recording::new("ramp", vec![0.0, 0.1, 0.3, 0.35]).unwrap();
        r.set(Column::Duty, vec![0.0, 0.5, 1.0, 1.0 + 1e-9]).unwrap();
        r
    }

    #[test]
    fn recordings_are_compared_by_their_samples() {
        let recording = |name: &str, values: Vec<f64>| {
            let mut recording = Recording::new(name, vec![0.0, 1.0, 2.0]).unwrap();
            recording.set(Column::Duty, values).unwrap();
            recording
        };
        let one = recording("a", vec![0.0, f64::NAN, 1.0]);
        assert!(one.has_the_samples_of(&recording("b", vec![0.0, f64::NAN, 1.0])));
        assert!(!one.has_the_samples_of(&recording("b", vec![0.0, f64::NAN, 0.9])));
    }

    #[test]
    fn intervals_follow_the_true_times() {
        let r = ramp();
        let dt: Vec<f64> = r.inputs_for(&model()).unwrap().map(|(_, dt)| dt).collect();
        for (found, expected) in dt.iter().zip([0.1, 0.2, 0.05, 0.05]) {
            assert!((found - expected).abs() < 1e-12, "{dt:?}");
        }
        assert!((r.median_interval_s() - 0.1).abs() < 1e-12);
        assert_eq!(r.duration_s(), 0.35);
    }

    #[test]
    fn absent_columns_take_the_rig_and_holes_the_last_value() {
        let mut r = ramp();
        let rows: Vec<Inputs> = r.inputs_for(&model()).unwrap().map(|(i, _)| i).collect();
        assert_eq!(rows[2].supply_v, model().drive.supply_v);
        assert_eq!(rows[2].ambient_c, model().ambient_c);
        assert_eq!((rows[1].drive, rows[3].drive), (0.5, 1.0), "duty is clamped, rounding apart");
        r.set(Column::SupplyV, vec![f64::NAN, 5.9, f64::NAN, 5.8]).unwrap();
        let supply: Vec<f64> = r.inputs_for(&model()).unwrap().map(|(i, _)| i.supply_v).collect();
        assert_eq!(supply, [5.9, 5.9, 5.9, 5.8]);
        r.set(Column::SupplyV, vec![f64::NAN; 4]).unwrap();
        assert_eq!(r.inputs_for(&model()).unwrap().next().unwrap().0.supply_v, model().drive.supply_v);
    }

    #[test]
    fn imposed_quantities_are_inputs_of_their_loads() {
        let mut model = model();
        model.drive.kind = DriveKind::Temperature;
        model.load = Load::ImposedForce;
        let mut r = Recording::new("furnace", vec![0.0, 1.0, 2.0]).unwrap();
        r.set(Column::TemperatureC, vec![25.0, 30.0, 35.0]).unwrap();
        let error = r.check_inputs(&model).unwrap_err();
        assert!(matches!(error.what, What::MissingInput { input: Column::ForceN, .. }), "{error}");
        r.set(Column::ForceN, vec![1.0, f64::NAN, 3.0]).unwrap();
        let error = r.check_inputs(&model).unwrap_err();
        assert_eq!(error.what, What::MissingSample { time_s: 1.0 });
        r.set(Column::ForceN, vec![1.0, 2.0, 3.0]).unwrap();
        let (inputs, _) = r.inputs_for(&model).unwrap().nth(1).unwrap();
        assert_eq!((inputs.drive, inputs.imposed), (30.0, 2.0));
    }

    #[test]
    fn what_a_program_hands_over_is_checked_too() {
        assert!(matches!(Recording::new("x", vec![0.0, 1.0]).unwrap_err().what, What::TooFewSamples { .. }));
        let error = Recording::new("x", vec![0.0, 1.0, 1.0]).unwrap_err();
        assert!(matches!(error.what, What::TimeNotIncreasing { .. }));
        assert!(Recording::new("x", vec![0.0, f64::NAN, 1.0]).is_err());
        assert!(matches!(Recording::new("x", vec![0.0, 1.0, 2e6]).unwrap_err().what, What::TooLong { .. }));
        let mut r = ramp();
        assert!(matches!(r.set(Column::ForceN, vec![0.0]).unwrap_err().what, What::WrongLength { .. }));
        assert!(matches!(r.set(Column::ForceN, vec![f64::INFINITY; 4]).unwrap_err().what, What::Infinite { .. }));
        r.set(Column::Duty, vec![0.0, 2.0, 0.0, 0.0]).unwrap();
        let error = r.inputs_for(&model()).map(|_| ()).unwrap_err();
        assert_eq!(error.what, What::DutyOutOfRange { found: 2.0 });
        r.remove(Column::Duty);
        assert!(matches!(r.check_inputs(&model()).unwrap_err().what, What::MissingInput { .. }));
    }
}
