//! Reads every recording that lies beside the project: measured, concealed and reference. Skipped where they are not.

use std::path::{Path, PathBuf};

use sinew_physics::Wire;
use sinew_recording::{Column, Options, read};
use sinew_rig::Rig;

/// A folder of the material beside the checkout, if it is there.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(folder);
    if !path.is_dir() {
        eprintln!("skipped: no {}", path.display());
        return None;
    }
    Some(path)
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

/// Each recording below `folder` with its rig, `RIG/rig.toml` and `RIG/*.csv*`.
fn recordings(folder: &Path) -> Vec<(Rig, PathBuf)> {
    let mut found = Vec::new();
    for rig_folder in entries(folder).into_iter().filter(|p| p.join("rig.toml").is_file()) {
        let rig = Rig::load(&rig_folder.join("rig.toml")).unwrap_or_else(|e| panic!("{e}"));
        for path in entries(&rig_folder) {
            let name = path.to_string_lossy().into_owned();
            if name.ends_with(".csv") || name.ends_with(".csv.gz") {
                found.push((rig.clone(), path));
            }
        }
    }
    assert!(!found.is_empty(), "no recordings below {}", folder.display());
    found
}

#[test]
fn measured_and_concealed_recordings_are_read_and_drive_their_wire() {
    for folder in ["real", "concealed"].into_iter().filter_map(shared) {
        for (rig, path) in recordings(&folder) {
            let model = &rig.channels[0].model;
            let options = Options { columns: Some(&rig.recording.columns), model: Some(model), ..Options::default() };
            let recording = read(&path, &options).unwrap_or_else(|e| panic!("{e}"));
            let rows = recording.inputs_for(model).unwrap();
            assert_eq!(rows.len(), recording.len());
            let (first, _) = rows.clone().next().unwrap();
            let mut wire = Wire::with_inputs(model, &first).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            for (inputs, dt_s) in rows.take(500) {
                wire.step(&inputs, dt_s);
            }
            for column in Column::ALL {
                let finite = column.of_outputs(&wire.outputs()).is_none_or(f64::is_finite);
                assert!(finite, "{}: {}", path.display(), column.name());
            }
        }
    }
}

#[test]
fn the_reference_needs_ignore_columns_and_its_rows_end_their_intervals() {
    let Some(folder) = shared("reference") else { return };
    for path in entries(&folder).into_iter().filter(|p| p.extension().is_some_and(|e| e == "csv")) {
        let rig = Rig::load(&path.with_extension("toml")).unwrap_or_else(|e| panic!("{e}"));
        let model = &rig.channels[0].model;
        let mut options = Options { model: Some(model), ..Options::default() };
        let error = read(&path, &options).unwrap_err();
        assert!(error.to_string().contains("column \"martensite\": is unknown"), "{error}");
        options.ignore_columns = true;
        let recording = read(&path, &options).unwrap_or_else(|e| panic!("{e}"));
        // the convention of a row: stepped through its interval, the wire is where the row says
        let start = Wire::new(model).unwrap();
        for column in [Column::TemperatureC, Column::PositionM, Column::CurrentA] {
            let measured = recording.get(column).unwrap();
            let (low, high) = measured.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
            let mut wire = start.clone();
            let mut worst = 0.0f64;
            for ((inputs, dt_s), expected) in recording.inputs_for(model).unwrap().zip(measured).take(300) {
                wire.step(&inputs, dt_s);
                worst = worst.max((column.of_outputs(&wire.outputs()).unwrap() - expected).abs());
            }
            assert!(worst < 0.004 * (high - low), "{}: {} is off by {worst}", path.display(), column.name());
        }
    }
}
