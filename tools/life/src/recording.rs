//! The account of what a recording holds.

use std::path::Path;

use sinew_recording::rows::DRIVER;
use sinew_recording::session::Session;
use sinew_recording::{Column, Options, Recording, read};
use sinew_rig::Rig;

use crate::account::Account;
use crate::error::Error;
use crate::wire::{Sample, Wire};

/// Reckons with a recording: an account for each of its wires, as if they had been new. `rig` says what wires they are; a driver's
/// recording has its rig file with it. `channel` names one of them.
///
/// # Errors
/// [`Error::Recording`], [`Error::NoRig`], [`Error::NotChosen`], [`Error::NoChannel`].
pub fn of_recording(path: &Path, rig: Option<&Rig>, channel: Option<&str>) -> Result<Vec<Account>, Error> {
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("mcap")) {
        let session = Session::open(path)?;
        if session.about().kind == DRIVER {
            return of_session(&session, rig, channel);
        }
    }
    let file = path.display().to_string();
    let no_rig = |reason: String| Error::NoRig { file: file.clone(), reason };
    let rig = rig.ok_or_else(|| no_rig("it does not say of what wire it is".into()))?;
    let index = rig.chosen(channel).map_err(Error::NotChosen)?;
    let options =
        Options { ignore_columns: true, columns: Some(&rig.recording.columns), channel, ..Options::default() };
    let recording = read(path, &options)?;
    Ok(vec![of_columns(rig, index, &recording)])
}

/// A driver's cycles: what it measured and estimated.
fn of_session(session: &Session, rig: Option<&Rig>, channel: Option<&str>) -> Result<Vec<Account>, Error> {
    let no_rig = |reason: String| Error::NoRig { file: session.name().into(), reason };
    let own = match (rig, &session.about().rig_toml) {
        (Some(_), _) => None,
        (None, Some(text)) => Some(Rig::parse(text, session.name()).map_err(|error| no_rig(error.to_string()))?),
        (None, None) => return Err(no_rig("it has no rig file with it".into())),
    };
    let rig = rig.or(own.as_ref()).ok_or_else(|| no_rig("it has no rig file with it".into()))?;
    let layout = session.layout();
    let mut wires = Vec::new();
    for (place, name) in layout.channels.iter().enumerate().filter(|(_, name)| channel.is_none_or(|one| one == *name)) {
        let (index, _) = rig.channel(name).ok_or_else(|| no_rig(format!("the rig file has no channel \"{name}\"")))?;
        let wire = Wire::of(rig, index);
        let account = Account { runs: 1, ..Account::new(&rig.name, name, session.about().simulated, &wire) };
        wires.push((place, wire, account));
    }
    if wires.is_empty() {
        let (name, there) = (channel.unwrap_or_default().into(), layout.channels.clone());
        return Err(Error::NoChannel { file: session.name().into(), name, there });
    }
    // a field that a recording of an earlier version lacks is not known
    let field = |name: &str| layout.field(name).unwrap_or(usize::MAX);
    let fields = ["length_m", "martensite", "temperature_c", "duty", "power_w"].map(field);
    let (rate_hz, mut last) = (session.about().rate_hz, None);
    let mut cycles = session.cycles();
    while let Some(cycle) = cycles.next()? {
        let periods = last.map_or(1, |last| cycle.head.cycle.saturating_sub(last));
        last = Some(cycle.head.cycle);
        let seconds = periods as f64 / rate_hz;
        for (place, wire, account) in &mut wires {
            let [length_m, martensite, temperature_c, duty, power_w] = fields.map(|field| cycle.get(*place, field));
            let elongation_m = length_m - wire.identity.length_m;
            let sample = Sample {
                seconds,
                powered: duty > wire.sensing_duty,
                power_w,
                martensite,
                strain: elongation_m / wire.identity.length_m,
                stress_pa: wire.stress_pa(elongation_m),
                temperature_c,
            };
            account.see(wire, &sample);
        }
    }
    Ok(wires.into_iter().map(|(_, _, account)| account).collect())
}

/// Columns of a laboratory: what was measured.
fn of_columns(rig: &Rig, index: usize, recording: &Recording) -> Account {
    let wire = Wire::of(rig, index);
    let area_m2 = rig.channels[index].model.geometry.area_m2();
    let mut account = Account { runs: 1, ..Account::new(&rig.name, &rig.channels[index].name, false, &wire) };
    for row in 0..recording.len() {
        let of = |column: Column| recording.get(column).map_or(f64::NAN, |values| values[row]);
        let elongation_m = of(Column::PositionM);
        let force_n = of(Column::ForceN);
        let stress_pa = if force_n.is_finite() { force_n.max(0.0) / area_m2 } else { wire.stress_pa(elongation_m) };
        let heated =
            of(Column::Duty) > wire.sensing_duty || [Column::PowerW, Column::CurrentA].iter().any(|c| of(*c) > 0.0);
        let sample = Sample {
            seconds: recording.interval_s(row),
            powered: heated,
            power_w: of(Column::PowerW),
            martensite: f64::NAN,
            strain: elongation_m / wire.identity.length_m,
            stress_pa,
            temperature_c: of(Column::TemperatureC),
        };
        account.see(&wire, &sample);
    }
    account
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;

    #[test]
    fn a_laboratorys_columns_are_reckoned_with_by_what_they_have() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("monday.csv");
        let rig = Rig::hexapod();
        let name = rig.channels[0].name.clone();
        let length_m = rig.channels[0].model.geometry.length_m;
        let force_n = 170e6 * rig.channels[0].model.geometry.area_m2();
        let mut text = String::from("time_s,power_w,force_n,position_m,colour\n");
        for k in 0..1000 {
            let strain = 0.02 + 0.02 * (f64::from(k) / 100.0 * std::f64::consts::TAU).cos();
            writeln!(text, "{},{},{force_n},{},7", 0.01 * f64::from(k), k % 2, strain * length_m).unwrap();
        }
        std::fs::write(&path, text).unwrap();
        let error = of_recording(&path, None, None).unwrap_err();
        assert!(matches!(error, Error::NoRig { .. }) && error.remedy().contains("--rig"), "{error}");
        assert!(of_recording(&path, Some(&rig), None).is_err(), "which of its channels?");
        let accounts = of_recording(&path, Some(&rig), Some(&name)).unwrap();
        let report = accounts[0].report();
        assert!((report.cycles - 10.0).abs() < 0.6, "{}", report.cycles);
        assert!((report.equivalent_cycles / report.cycles - 1.0).abs() < 0.02, "{}", report.equivalent_cycles);
        assert!((report.hours_powered * 3600.0 - 5.0).abs() < 0.02);
        assert!((report.energy_j - 5.0).abs() < 0.02, "{} J", report.energy_j);
        assert!((report.without_temperature_s - 10.0).abs() < 1e-6);
    }
}
