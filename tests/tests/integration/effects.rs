//! Physics beyond the reference model in a rig file: every effect runs under `simulate`, and a driver meets them on its
//! simulated wires.

use std::fmt::Write as _;
use std::fs;
use std::time::Duration;

use serde_json::Value;
use sinew_ipc::Client;
use sinew_physics::effects::{Home, catalogue};
use sinew_tests::{Driver, Process, Rig, run, wait_for, wait_until};

const LONG: Duration = Duration::from_secs(120);

/// Two heatings, fast and slow, at 100 Hz.
fn inputs() -> String {
    let mut text = "time_s,duty\n".to_string();
    for row in 0..600 {
        let duty = match row {
            0..100 | 300..450 => 0.3,
            _ => 0.02,
        };
        writeln!(text, "{:.2},{duty}", f64::from(row) * 0.01).unwrap();
    }
    text
}

/// The numbers `simulate` writes for this rig.
#[track_caller]
fn simulated(here: &Rig, rig: &sinew_rig::Rig) -> Vec<Vec<f64>> {
    fs::write(here.path(), rig.to_toml()).unwrap();
    let path = |name: &str| here.file(name).into_os_string();
    run(["simulate".into(), path("rig.toml"), path("in.csv"), "-o".into(), path("out.csv")]).expect(0);
    let text = fs::read_to_string(here.file("out.csv")).unwrap();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

#[test]
fn every_effect_of_the_catalogue_runs_in_simulate_and_shows() {
    let here = Rig::bench(&["wire"], "");
    fs::write(here.file("in.csv"), inputs()).unwrap();
    let given = sinew_rig::Rig::load(&here.path()).unwrap();
    let reference = simulated(&here, &given);
    for effect in catalogue() {
        let mut rig = given.clone();
        let model = &mut rig.channels[0].model;
        match effect.home {
            Home::Material => effect.set_null(model),
            Home::Table => {
                for (i, p) in effect.parameters.iter().enumerate() {
                    // of the many terms of a closed form one will do
                    if i == 0 || effect.id.starts_with("sensing.") || !p.is_switch() {
                        let (least, most) = p.plausible;
                        p.set(model, least + 0.8 * (most - least));
                    }
                }
                if effect.id == "thermal.draught" {
                    rig.set_effect(0, effect.id, "start_s", 1.0).unwrap();
                    rig.set_effect(0, effect.id, "end_s", 2.0).unwrap();
                }
            }
        }
        let rows = simulated(&here, &rig);
        assert_eq!(rows.len(), reference.len(), "{}", effect.id);
        assert!(rows.iter().flatten().all(|v| v.is_finite()), "{}", effect.id);
        let shows = |(row, expected): (&Vec<f64>, &Vec<f64>)| {
            row.iter().zip(expected).any(|(a, b)| (a - b).abs() > 1e-5 * (a.abs() + b.abs()))
        };
        assert!(rows.iter().zip(&reference).any(shows), "{} changes nothing", effect.id);
    }
}

const DRAUGHTY: &str = r#"
[channel.effects."thermal.draught"]
gain = 1.0
start_s = 1.0
end_s = 1e6

[channel.effects."mechanical.friction"]
coulomb_n = 0.1

[channel.effects."sensing.contact_resistance"]
ohm = 0.05
"#;

#[test]
fn a_driver_runs_on_a_rig_with_a_draught_friction_and_a_bad_crimp() {
    let rig = Rig::bench(&["wire"], DRAUGHTY);
    let report = rig.file("report.json");
    Process::start(rig.command(&["--for", "10"]).arg("--report").arg(&report)).finish().expect(0);
    let report: Value = serde_json::from_str(&fs::read_to_string(&report).unwrap()).unwrap();
    sinew_tests::check_report(&report);
    assert_eq!(report["channel"][0]["fault"], Value::Null, "{report:#}");
}

#[test]
fn a_controller_that_knows_nothing_of_them_still_reaches_its_length() {
    let rig = Rig::bench(&["wire"], DRAUGHTY);
    let (driver, client) = Driver::ready(&rig);
    client.set_stroke("wire", 0.4, LONG).unwrap();
    wait_until("the length", || {
        let latest = client.latest();
        let state = &latest.channels()[0];
        assert_eq!(state.fault(), None, "{state:?}");
        (state.length_m - state.target_m).abs() < 1.5e-4
    });
    let report = driver.stop();
    assert_eq!(report["channel"][0]["fault"], Value::Null, "{report:#}");
}

/// A law in the rig file itself: a fan that blows harder the hotter the wire is.
const FAN: &str = r#"
[channel.effects."own.fan"]
says = "A fan that is turned up with the temperature."
enters = "heat"
formula = "-gain * max(temperature - 40 [°C], 0)"
gain = 1.5
parameters.gain = { unit = "mW/K", null = 0.0, range = [0.0, 100.0], about = "how strong it is" }
"#;

#[test]
fn a_law_of_ones_own_acts_in_simulate_and_on_the_drivers_wires_and_goes_with_their_recording() {
    let here = Rig::bench(&["wire"], "");
    fs::write(here.file("in.csv"), inputs()).unwrap();
    let reference = simulated(&here, &sinew_rig::Rig::load(&here.path()).unwrap());
    let fan = Rig::bench(&["wire"], FAN);
    fs::write(fan.file("in.csv"), inputs()).unwrap();
    let rows = simulated(&fan, &sinew_rig::Rig::load(&fan.path()).unwrap());
    let hottest = |rows: &[Vec<f64>]| rows.iter().map(|row| row[row.len() - 2]).fold(0.0, f64::max);
    assert!(hottest(&rows) < hottest(&reference) - 2.0, "{} and {}", hottest(&rows), hottest(&reference));

    let laws = fan.file("laws.toml");
    fs::write(&laws, FAN.replace("[channel.", "[").replace("gain = 1.5\n", "")).unwrap();
    let rig = Rig::bench(&["wire"], "[channel.effects.\"own.fan\"]\ngain = 1.5\n");
    let report = rig.file("report.json");
    let mut command = rig.command(&["--for", "10"]);
    command.arg("--catalogue").arg(&laws).arg("--report").arg(&report);
    let driver = Process::start(&mut command);
    // whoever records it needs no catalogue
    let text = wait_for("a driver with its text", || Client::connect(&rig.name).ok()?.rig_text().ok()?);
    let told = sinew_rig::Rig::parse(&text, "told").unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(told.channels[0].model.catalogue().filter(|effect| effect.id.starts_with("own.")).count(), 1, "{text}");
    driver.finish().expect(0);
    sinew_tests::check_report(&serde_json::from_str(&fs::read_to_string(&report).unwrap()).unwrap());
}
