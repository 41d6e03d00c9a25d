//! What `sinew record` took from a running driver, replayed, exported and simulated by other processes.

use std::ffi::OsStr;
use std::process::Command;
use std::time::Duration;

use serde_json::Value;
use sinew_recording::{Column, Options, read};
use sinew_tests::{Driver, Process, Rig, recorded_so_far, run, sinew, wait_until};

#[test]
fn a_recording_of_a_running_driver_is_replayed_exported_and_simulated() {
    let rig = Rig::bench(&["left", "right"], "");
    let (driver, client) = Driver::ready(&rig);
    // A driver that has run for a while: what its estimators learn in their first second, a replay that begins later lacks.
    wait_until("the estimators to have settled", || client.latest().cycle > 500);
    let file = rig.file("walk.mcap");
    let mut command = Command::new(sinew());
    command.arg("record").arg(&file).args(["--rig", &rig.name, "--for", "2.5", "--json"]);
    let recorder = Process::start(&mut command);
    wait_until("a chunk of the recording", || !recorded_so_far(&file).is_empty());
    client.set_stroke("left", 0.5, Duration::from_millis(800)).unwrap();
    client.set_duty("right", 0.2, Duration::from_millis(400)).unwrap();
    let recorded = recorder.finish().expect(0).json();
    let missed = driver.stop()["missed"].as_u64().expect("a count");
    assert_eq!(recorded["lost"], 0, "{recorded:#}");

    let sinew = |words: &[&OsStr]| run(words.iter().copied());
    let told: Value = sinew(&["replay".as_ref(), file.as_ref(), "--json".as_ref()]).expect(0).json();
    assert_eq!((&told["cycles"], &told["lost"]), (&recorded["cycles"], &recorded["lost"]), "{told:#}");
    assert!(told["first_cycle"].as_u64().unwrap() > 1, "the driver ran already");
    for channel in told["channel"].as_array().unwrap() {
        let rows = channel["fields"].as_array().unwrap();
        let cycles = |row: &Value| row["cycles"].as_u64().unwrap();
        // A wire that was warm is looked at in the dark now and then, and shows no length there: a replay that begins later takes
        // it for colder, and looks at other moments.
        let dark = rows.iter().find(|row| row["field"] == "flags").map_or(0, cycles);
        for row in rows {
            let measured = ["measured_length_m", "resistance_ohm", "target_m", "asked", "order", "fault"];
            // until the duty of then is in force again, a period that was missed meanwhile later
            let most = 3 + missed + dark;
            assert!(!measured.contains(&row["field"].as_str().unwrap()) || cycles(row) <= most, "{channel:#}");
        }
    }

    let (csv, parquet, model) = (rig.file("walk.csv"), rig.file("walk.parquet"), rig.file("model.csv"));
    sinew(&["export".as_ref(), file.as_ref(), "-o".as_ref(), csv.as_ref(), "--channel".as_ref(), "left".as_ref()])
        .expect(0);
    sinew(&["export".as_ref(), file.as_ref(), "-o".as_ref(), parquet.as_ref()]).expect(0);
    let path = rig.path();
    let simulate = ["simulate".as_ref(), path.as_ref(), file.as_ref(), "-o".as_ref(), model.as_ref()];
    sinew(&[&simulate[..], &["--channel".as_ref(), "left".as_ref()]].concat()).expect(0);
    let left = read(&csv, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let simulated =
        read(&model, &Options { ignore_columns: true, ..Options::default() }).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(left.time_s(), simulated.time_s());
    // all but the first cycle and the last begin a row
    assert_eq!(left.len() as u64, recorded["cycles"].as_u64().unwrap() - 2);
    // the wire was cold and still when the recording began: the model knows it to a converter's noise, moving or not
    let (seen, said) = (left.get(Column::V3V).unwrap(), simulated.get(Column::V3V).unwrap());
    let worst =
        seen.iter().zip(said).filter(|(seen, _)| seen.is_finite()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    assert!(worst < 0.03, "{worst} V");
    assert!(std::fs::read(&parquet).unwrap().starts_with(b"PAR1"));
}
