//! Real rig files: the built-in one and those of the recordings in `../shared`.

use std::path::{Path, PathBuf};

use sinew_physics::{DriveKind, Load, WireModel};
use sinew_rig::{Rig, Sensing};

#[test]
fn the_hexapod_is_eighteen_wires_that_can_be_driven() {
    let rig = Rig::hexapod();
    assert_eq!(rig.channels.len(), 18);
    assert_eq!(rig.rate_hz, 1000.0);
    rig.check_drivable().unwrap();
    for leg in ["front_left", "front_right", "middle_left", "middle_right", "rear_left", "rear_right"] {
        for joint in ["coxa", "femur", "tibia"] {
            let (_, channel) = rig.channel(&format!("{leg}_{joint}")).unwrap();
            assert_eq!(channel.control.sensing, Sensing::Dual);
            let hot = sinew_physics::hot_length_m(&channel.model).unwrap();
            let cold = sinew_physics::cold_length_m(&channel.model).unwrap();
            assert!(cold - hot > 4e-3, "stroke {} m", cold - hot);
            assert!(channel.limits.min_length_m < hot && cold < channel.limits.max_length_m);
            assert!(least_power_w(&channel.model) >= 3.0, "{} W", least_power_w(&channel.model));
            assert!(greatest_stress_pa(&channel.model) < 250e6, "{} Pa", greatest_stress_pa(&channel.model));
        }
    }
}

/// Full-on power where the wire's resistance is greatest: hot and wholly austenite (eq. 36, 37).
fn least_power_w(model: &WireModel) -> f64 {
    let m = &model.material;
    let hot = m.austenite_temperature_c + 40.0 - m.reference_temperature_c;
    let rho = m.austenite_resistivity_ohm_m + m.austenite_resistivity_slope_ohm_m_per_k * hot;
    let r = rho * sinew_physics::hot_length_m(model).unwrap() / model.geometry.area_m2();
    let current = model.drive.supply_v / (r + model.drive.shunt_ohm + model.drive.switch_ohm + model.drive.lead_ohm);
    current * current * r
}

fn greatest_stress_pa(model: &WireModel) -> f64 {
    let Load::SpringMassDamper { spring_n_per_m, preload_n, .. } = model.load else { panic!("no spring") };
    let hot = sinew_physics::hot_length_m(model).unwrap() - model.geometry.length_m;
    (preload_n - spring_n_per_m * hot) / model.geometry.area_m2()
}

/// Rig files beside the project; empty with a message where they are not at hand.
fn shared_rigs() -> Vec<PathBuf> {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let mut found = Vec::new();
    for folder in ["reference", "real", "concealed"] {
        let Ok(entries) = std::fs::read_dir(shared.join(folder)) else { continue };
        for path in entries.flatten().map(|e| e.path()) {
            if path.extension().is_some_and(|e| e == "toml") {
                found.push(path);
            } else if path.join("rig.toml").is_file() {
                found.push(path.join("rig.toml"));
            }
        }
    }
    if found.is_empty() {
        println!("skipped: no ../shared beside the project, so its rig files are not read");
    }
    found.sort();
    found
}

#[test]
fn shared_rig_files_load_and_survive_being_written() {
    let paths = shared_rigs();
    for path in &paths {
        let rig = Rig::load(path).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(rig.channels.len(), 1, "{}", path.display());
        // Nothing was changed, so not a letter changes.
        assert_eq!(rig.to_toml(), std::fs::read_to_string(path).unwrap());
        rig.channels[0].model.validate().unwrap();
    }
    assert!(paths.is_empty() || paths.len() >= 18, "{} files", paths.len());
}

#[test]
fn shared_rig_files_mean_what_they_say() {
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    if !shared.is_dir() {
        println!("skipped: no ../shared beside the project");
        return;
    }
    let load = |name: &str| Rig::load(&shared.join(name).join("rig.toml")).unwrap();

    let bias = load("bias-spring");
    let model = &bias.channels[0].model;
    assert_eq!(model.geometry.diameter_m, 0.5e-3);
    assert_eq!(model.material.thermoelastic_pa_per_k, 0.0);
    assert_eq!((model.taps, model.drive.shunt_ohm, model.drive.switch_ohm), (None, 0.0, 0.05));
    assert_eq!(bias.channels[0].position_zero, sinew_rig::PositionZero::Free);
    assert_eq!(bias.channels[0].priors["convection_w_per_m2_k"], sinew_rig::Prior::Relative(0.4));
    assert_eq!(bias.channels[0].priors["austenite_temperature_c"], sinew_rig::Prior::Absolute(20.0));
    assert_eq!(bias.channels[0].control.sensing, Sensing::Resistance);
    assert_eq!(model.ambient_c, 24.5);

    let isobaric = load("isobaric-flexinol");
    assert_eq!(isobaric.channels[0].model.load, Load::ImposedForce);
    assert_eq!(isobaric.channels[0].model.drive.kind, DriveKind::Temperature);
    let error = isobaric.check_drivable().unwrap_err().to_string();
    assert!(error.contains("rig.toml:4: rig.rate_hz is 1, expected 10 to 20000"), "{error}");
    assert!(error.contains("channel \"wire\": drive.kind cannot be driven"), "{error}");

    assert_eq!(load("work-loops").channels[0].model.load, Load::ImposedPosition);
    assert_eq!(load("work-loops").channels[0].model.drive.kind, DriveKind::Power);
}
