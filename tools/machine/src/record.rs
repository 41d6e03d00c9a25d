//! The recording of a run in the common format, with its rig file.
//!
//! In the machine the cross-head determines the position of the wire's end, and the amplifier the current: so for a model the
//! elongation is imposed and the current is the drive, whatever the routine held constant, and force and voltages are
//! predicted by the model. So all recordings of a wire can be fitted together with one rig file.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use sinew_physics::{DriveKind, Load, WireModel};
use sinew_recording::session::{About, Ended, Field, Head, Layout, SessionWriter, WriteOptions};
use sinew_recording::{Column, Error, Recording, TIME, required_inputs};
use sinew_rig::{Machine as Spec, Rig};

use crate::machine::Reading;
use crate::run::{Ending, Row};

/// A column and what of a reading stands in it.
type Measured = (Column, fn(&Reading) -> f64);
/// What a sensor measured, by the contract's columns; NaN where a conversion did not fall into this row.
const SENSORS: [Measured; 6] = [
    // the offset of a meter that shows less than nothing heats no wire
    (Column::CurrentA, |reading| reading.current_a.max(0.0)),
    (Column::V1V, |reading| reading.taps_v.map_or(f64::NAN, |taps| taps[0])),
    (Column::V2V, |reading| reading.taps_v.map_or(f64::NAN, |taps| taps[1])),
    (Column::V3V, |reading| reading.voltage_v),
    (Column::ForceN, |reading| if reading.force_is_new { reading.force_n } else { f64::NAN }),
    (Column::PositionM, |reading| reading.position_m),
];
/// Measured in some rows only: apart, since it is no sensor of the wire.
const AIR: Measured = (Column::AmbientC, |reading| if reading.chamber_is_new { reading.chamber_c } else { f64::NAN });

/// The columns of a wire with or without taps.
fn columns(taps: bool) -> impl Iterator<Item = Measured> {
    let is_tap = |column: Column| matches!(column, Column::V1V | Column::V2V);
    SENSORS.into_iter().chain([AIR]).filter(move |(column, _)| taps || !is_tap(*column))
}

/// What the sensors measured, as a recording in memory.
///
/// # Errors
/// Fewer than three rows.
pub fn recording(name: &str, rows: &[Row]) -> Result<Recording, Error> {
    let mut recording = Recording::new(name, rows.iter().map(|row| row.time_s).collect())?;
    let taps = rows.first().is_some_and(|row| row.reading.taps_v.is_some());
    for (column, value) in columns(taps) {
        recording.set(column, rows.iter().map(|row| value(&row.reading)).collect())?;
    }
    Ok(recording)
}

/// A driver's recording in rows of `count` of its own, as a fit wants them of a fast driver: the inputs' means, and the mean of what was
/// measured around a row's end, as much before as after it, so that noise goes down and nothing is late.
///
/// # Errors
/// So few rows that fewer than three are left.
pub fn in_rows_of(recording: &Recording, count: usize, model: &WireModel) -> Result<Recording, Error> {
    let count = count.max(1);
    let starts = recording.time_s().chunks_exact(count).map(|times| times[0]).collect();
    let mut fewer = Recording::new(recording.name(), starts)?;
    let is_input = |column: Column| required_inputs(model).any(|input| input == column) || INPUTS.contains(&column);
    for (column, values) in recording.columns() {
        let of = |row: usize| {
            let (start, end) = (row * count, (row + 1) * count);
            match is_input(column) {
                true => mean(&values[start..end]),
                false => {
                    // of an even number the one before the end is in the middle of one more
                    let reach = (count - 1) / 2;
                    mean(&values[end - 1 - reach..(end + reach).min(values.len())])
                }
            }
        };
        fewer.set(column, (0..values.len() / count).map(of).collect())?;
    }
    Ok(fewer)
}

/// Columns that are inputs whatever drives the wire.
const INPUTS: [Column; 3] = [Column::SupplyV, Column::AmbientC, Column::DisturbanceN];

/// Mean of those that are numbers; NaN where none is.
fn mean(values: &[f64]) -> f64 {
    let known = values.iter().filter(|value| value.is_finite());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// What a recording holds beside the contract's columns: name, unit, value.
type Extra = (&'static str, &'static str, fn(&Row) -> f64);
const EXTRAS: [Extra; 7] = [
    ("target", "", |row| row.directive.target),
    ("heat_asked", "", |row| row.directive.heat),
    ("heating_power_w", "W", |row| row.reading.power_w()),
    ("crosshead_m", "m", |row| row.reading.crosshead_m),
    ("reckoned_temperature_c", "°C", |row| row.reckoned_c),
    ("stage", "", |row| row.directive.stage as f64),
    ("law_duty", "", |row| row.directive.duty),
];

/// A file that takes the rows of a run as they come: MCAP, one message a row, that the usual viewers open.
pub struct RecordingFile<W: Write + Seek> {
    writer: SessionWriter<W>,
    taps: bool,
    with_disturbance: bool,
    started_ns: u64,
    rows: u64,
    bytes: Vec<u8>,
}

impl<W: Write + Seek> RecordingFile<W> {
    /// Begins a file for channel `channel` of `rig`, whose text is put in as [`rig_in_machine`] has it. `kind` "test" is
    /// filled in, as is nothing else of `about`.
    ///
    /// # Errors
    /// As [`SessionWriter::create`].
    pub fn create(
        sink: W,
        name: &str,
        rig: &Rig,
        channel: usize,
        with_disturbance: bool,
        about: About,
    ) -> Result<RecordingFile<W>, Error> {
        let wire = &rig.channels[channel];
        let taps = wire.model.taps.is_some();
        let mut fields = vec![Field::f64(TIME, "s")];
        fields.extend(columns(taps).map(|(column, _)| Field::f64(column.name(), column.unit())));
        if with_disturbance {
            fields.push(Field::f64(Column::DisturbanceN.name(), "N"));
        }
        fields.extend(EXTRAS.map(|(name, unit, _)| Field::f64(name, unit)));
        let layout = Layout { channels: vec![wire.name.clone()], fields };
        let about = About { kind: "test".into(), rig_toml: Some(rig_in_machine(rig, channel).to_toml()), ..about };
        let started_ns = about.started_monotonic_ns;
        let writer = SessionWriter::create(sink, &about, &layout, WriteOptions::new(name))?;
        let bytes = Vec::with_capacity(layout.bytes());
        Ok(RecordingFile { writer, taps, with_disturbance, started_ns, rows: 0, bytes })
    }

    /// Takes a row. It counts from its start, as its `time_s` does.
    ///
    /// # Errors
    /// As [`SessionWriter::cycle`].
    pub fn row(&mut self, row: &Row) -> Result<(), Error> {
        self.rows += 1;
        self.bytes.clear();
        let measured = columns(self.taps).map(|(_, value)| value(&row.reading));
        let disturbance = self.with_disturbance.then_some(row.directive.disturbance_n);
        let extras = EXTRAS.iter().map(|(_, _, value)| value(row));
        for value in std::iter::once(row.time_s).chain(measured).chain(disturbance).chain(extras) {
            self.bytes.extend(value.to_le_bytes());
        }
        let monotonic_ns = self.started_ns.wrapping_add((row.time_s.max(0.0) * 1e9).round() as u64);
        self.writer.cycle(&Head { cycle: self.rows, monotonic_ns, missed: 0 }, &self.bytes)
    }

    /// Ends the file, saying how the run did.
    ///
    /// # Errors
    /// As [`SessionWriter::finish`].
    pub fn finish(self, ending: &Ending) -> Result<W, Error> {
        self.writer.finish(match ending {
            Ending::Complete => Ended::Complete,
            Ending::Stopped | Ending::Breach(_) | Ending::Failed(_) => Ended::Stopped,
        })
    }
}

/// Noise of the sensors as a fit takes it, by column. The voltage a model answers with is its resistance times the
/// *measured* current, so that the noise of the current is in it too.
pub fn noise(model: &WireModel, spec: &Spec) -> BTreeMap<String, f64> {
    let of = |noise: f64, step: f64| (noise * noise + step * step / 12.0).sqrt();
    let ohm = model.geometry.resistance_ohm(model.material.mean_resistivity());
    let current = of(spec.current_noise_a, spec.current_step_a);
    let voltage = of(spec.voltage_noise_v, spec.voltage_step_v).hypot(ohm * current).max(1e-9);
    let mut noise = BTreeMap::new();
    for column in [Column::V1V, Column::V2V, Column::V3V] {
        let is_tap = column != Column::V3V;
        if !is_tap || model.taps.is_some() {
            noise.insert(column.name().to_string(), voltage);
        }
    }
    noise.insert(Column::ForceN.name().to_string(), spec.force_noise_n.max(1e-9));
    noise
}

/// The rig as a recording of the machine describes it: a current heats channel `channel`, the cross-head moves its end. The
/// rig's own noise is kept where it is given.
pub fn rig_in_machine(rig: &Rig, channel: usize) -> Rig {
    let mut mounted = rig.clone();
    let machine = mounted.machine;
    let Some(wire) = mounted.channels.get_mut(channel) else { return mounted };
    wire.model.drive.kind = DriveKind::Current;
    wire.model.load = Load::ImposedPosition;
    for (column, sigma) in noise(&wire.model, &machine) {
        wire.noise.entry(column).or_insert(sigma);
    }
    mounted
}

#[cfg(test)]
mod tests {
    use sinew_rig::Rig;

    use super::*;

    #[test]
    fn fewer_rows_have_the_inputs_of_their_time_and_what_was_measured_at_their_end() {
        let model = &Rig::hexapod().channels[0].model;
        let mut recording = Recording::new("run", (0..100).map(|i| f64::from(i) * 1e-3).collect()).unwrap();
        let ramp: Vec<f64> = (0..100).map(|i| if i == 17 { f64::NAN } else { f64::from(i) * 1e-6 }).collect();
        recording.set(Column::Duty, (0..100).map(|i| f64::from(u8::from(i >= 25))).collect()).unwrap();
        recording.set(Column::PositionM, ramp).unwrap();
        let fewer = in_rows_of(&recording, 10, model).unwrap();
        assert_eq!((fewer.len(), fewer.time_s()[3]), (10, 0.03));
        let of = |column: Column| fewer.get(column).unwrap();
        assert_eq!(of(Column::Duty)[1..4], [0.0, 0.5, 1.0]);
        // the last sample of a row is the one at its end: 29, not 24.5
        assert!((of(Column::PositionM)[2] - 29e-6).abs() < 1e-12, "{:?}", of(Column::PositionM));
        assert!(in_rows_of(&recording, 1, model).unwrap().get(Column::Duty) == recording.get(Column::Duty));
        assert!(in_rows_of(&recording, 40, model).is_err());
    }
}
