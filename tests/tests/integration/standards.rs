//! `sinew astm` on files as laboratories have them.

use std::fs;
use std::path::Path;
use std::process::Command;

use sinew_tests::{checkout, sinew};

/// A calorimeter's export: remarks above, semicolons, decimal commas, Windows-1252; logistic transformations of k = 0.4/K at 93 and 67 °C,
/// 24.2 J/g at 10 K/min.
fn calorimeter(folder: &Path) {
    let peak = |x: f64| 0.1 / (0.2 * x).cosh().powi(2);
    let rate = 10.0 / 60.0;
    let row = |minutes: f64, t: f64, flow: f64| format!("{minutes:.4};{t:.2};{flow:.6}\r\n").replace('.', ",");
    let mut text = String::from("Probe;NiTi 7\r\nMasse;12,4 mg\r\n\r\nZeit/min;Temp./°C;DSC/(mW/mg)\r\n");
    let up = (0..900).map(|i| -20.0 + 0.2 * f64::from(i));
    for (i, t) in up.clone().enumerate() {
        text += &row(0.02 * i as f64, t, 0.05 + 24.2 * rate * peak(t - 93.0));
    }
    for (i, t) in up.rev().enumerate() {
        text += &row(18.0 + 0.02 * i as f64, t, -0.05 - 24.2 * rate * peak(t - 67.0));
    }
    let bytes: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).expect("Latin letters")).collect();
    fs::write(folder.join("dsc.csv"), bytes).expect("a file");
}

fn run(folder: &Path, words: &[&str]) -> (bool, String, String) {
    let done = Command::new(sinew()).args(words).current_dir(folder).output().expect("sinew starts");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (done.status.success(), text(done.stdout), text(done.stderr))
}

#[test]
fn a_calorimeters_file_gives_temperatures_heat_and_a_picture() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    calorimeter(folder.path());
    let (is_well, text, errors) = run(folder.path(), &["astm", "f2004", "dsc.csv", "-o", "dsc.svg"]);
    assert!(is_well, "{errors}");
    assert!(text.contains("[channel.material]\naustenite_temperature_c = 93.0"), "{text}");
    assert!(fs::read_to_string(folder.path().join("dsc.svg")).expect("a picture").contains("A_s, A_f, M_s, M_f"));
    let (_, json, _) = run(folder.path(), &["astm", "f2004", "dsc.csv", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let number = |place: &str| json.pointer(place).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let half = 0.5 * 6.098 / 0.4;
    for (place, expected, within) in [
        ("/figures/heating/start_c/value", 93.0 - half, 0.4),
        ("/figures/heating/finish_c/value", 93.0 + half, 0.4),
        ("/figures/cooling/start_c/value", 67.0 + half, 0.4),
        ("/figures/cooling/peak_c", 67.0, 0.4),
        ("/figures/heat_j_per_kg/0", 24_200.0, 300.0),
        ("/material/latent_heat_j_per_kg", 24_200.0, 300.0),
    ] {
        assert!((number(place) - expected).abs() < within, "{place}: {json}");
    }
}

#[test]
fn what_is_missing_is_told_with_what_there_is() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    calorimeter(folder.path());
    let (is_well, text, errors) = run(folder.path(), &["astm", "e3097", "dsc.csv"]);
    assert!(!is_well && text.is_empty());
    assert!(errors.contains("--column strain=NAME") && errors.contains("\"DSC/(mW/mg)\""), "{errors}");
    let half: String = "temperature_c,strain_percent\n".to_string()
        + &(0..100).map(|i| format!("{},{}\n", 40 + i / 2, 4.0 - 0.04 * f64::from(i))).collect::<String>();
    fs::write(folder.path().join("half.csv"), half).expect("a file");
    let (is_well, _, errors) = run(folder.path(), &["astm", "e3097", "half.csv"]);
    assert!(!is_well && errors.contains("half.csv: shows no cooling"), "{errors}");
}

/// The page shows what the example gives.
#[test]
fn the_page_shows_what_the_example_gives() {
    let (is_well, text, errors) = run(checkout(), &["astm", "f2004", "examples/dsc.csv"]);
    assert!(is_well, "{errors}");
    let page = fs::read_to_string(checkout().join("docs/standards.md")).expect("the page");
    assert!(
        page.contains(&format!("$ sinew astm f2004 examples/dsc.csv\n{text}```")),
        "docs/standards.md shows otherwise:\n{text}"
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let fitted = folder.path().join("fitted.toml").display().to_string();
    let words = ["identify", "examples/messung.toml", "--dsc", "examples/dsc.csv", "-o", &fitted];
    let (is_well, text, errors) = run(checkout(), &words);
    assert!(is_well, "{errors}");
    let shown = "$ sinew identify examples/messung.toml --dsc examples/dsc.csv -o fitted.toml";
    assert!(page.contains(&format!("{shown}\n{text}```")), "docs/standards.md shows otherwise:\n{text}");
}

/// A wire in a furnace under constant force, whose rig file believes what default priors hold.
const FURNACE: &str = "[rig]\nname = \"furnace\"\nrate_hz = 1.0\n\n[[channel]]\nname = \"wire\"\nwire = { diameter_mm = 0.5, length_mm = 100.0 }\n\
                       drive = { kind = \"temperature\" }\nload = { kind = \"imposed_force\" }\n";

/// What `identify` gives of these files and words: exit code, stdout, stderr, and the fitted rig file.
fn identified(folder: &Path, words: &[&str]) -> (Option<i32>, String, String, String) {
    let args = ["identify", "rig.toml"].iter().chain(words).chain(&["-o", "fitted.toml"]);
    let done = Command::new(sinew()).args(args).current_dir(folder).output().expect("sinew starts");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    let fitted = fs::read_to_string(folder.join("fitted.toml")).unwrap_or_default();
    (done.status.code(), text(done.stdout), text(done.stderr), fitted)
}

fn number(json: &serde_json::Value, place: &str) -> f64 {
    json.pointer(place).and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN)
}

#[test]
fn identify_takes_a_calorimeters_curve_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    calorimeter(folder.path());
    fs::write(folder.path().join("rig.toml"), FURNACE).expect("a file");
    let (code, text, errors, fitted) = identified(folder.path(), &["--dsc", "dsc.csv", "--json"]);
    assert_eq!(code, Some(0), "{errors}");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["schema"], "sinew.identify/1");
    let half = 0.5 * 6.098 / 0.4;
    for (place, expected, within) in [
        ("/parameters/austenite_temperature_c/value", 93.0, 0.3),
        ("/parameters/martensite_temperature_c/value", 67.0, 0.3),
        ("/parameters/heating_steepness_per_k/value", 0.4, 0.01),
        ("/parameters/latent_heat_j_per_kg/value", 24_200.0, 200.0),
        ("/measured/austenite_temperature_c/sigma", 1.0, 0.2),
        ("/temperatures/0/austenite_start/value_c", 93.0 - half, 0.5),
        ("/temperatures/0/martensite_start/value_c", 67.0 + half, 0.5),
    ] {
        assert!((number(&json, place) - expected).abs() < within, "{place}: {json}");
    }
    // what the curve does not tell stays, and what it tells stands there with what it is uncertain by
    assert!(json["parameters"].as_object().is_some_and(|parameters| parameters.len() == 5), "{json}");
    let rig: toml::Value = toml::from_str(&fitted).expect("a rig file");
    let channel = &rig["channel"][0];
    assert!((channel["priors"]["austenite_temperature_c"].as_float().expect("a prior") - 1.0).abs() < 0.2, "{fitted}");
    assert!((channel["material"]["heating_steepness_per_k"].as_float().expect("a number") - 0.4).abs() < 0.01);
    // and a table for people
    let (_, text, ..) = identified(folder.path(), &["--dsc", "dsc.csv"]);
    assert!(text.contains("ASTM F2004, 0 MPa") && text.contains("by the curve") && text.contains("lags"), "{text}");
}

#[test]
fn identify_says_what_a_calorimeters_file_lacks() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("a file");
    calorimeter(folder.path());
    file("rig.toml", FURNACE);
    // what is seen on heating at a temperature is seen on cooling 20 K below it
    let curve = |flow: &dyn Fn(f64) -> f64, unit: &str| {
        let up = (0..600).map(|i| -20.0 + 0.3 * f64::from(i));
        let heats: String = up.clone().map(|t| format!("{t},{}\n", flow(t))).collect();
        let cools: String = up.rev().map(|t| format!("{t},{}\n", flow(t + 20.0))).collect();
        (format!("Temp (C),Heat Flow ({unit})\n{heats}"), cools)
    };
    let (flat, back) = curve(&|t| 0.1 + 1e-4 * t + 1e-3 * (37.0 * t).sin(), "mW/mg");
    file("flat.csv", &(flat + &back));
    let peak = |x: f64| 0.1 / (0.2 * x).cosh().powi(2);
    let (heating, cooling) = curve(&|t| 0.1 + 4.0 * peak(t - 80.0), "mW");
    file("half.csv", &heating);
    file("sample.csv", &(heating + &cooling));
    file("tension.csv", "time_s,strain_percent,stress_mpa\n0,0,0\n1,1,100\n2,2,200\n");
    file("text.csv", "this is no table\n");
    for (words, said) in [
        (&["--dsc", "flat.csv"][..], &["flat.csv: shows no transformation on heating", "--column"][..]),
        (&["--dsc", "half.csv"], &["half.csv: shows no cooling", "measure the whole sweep again"]),
        (&["--dsc", "tension.csv"], &["tension.csv", "--column temperature=NAME"]),
        (&["--dsc", "text.csv"], &["text.csv"]),
        (&["--dsc", "nowhere.csv"], &["nowhere.csv"]),
        (&["--dsc", "dsc.csv", "--dsc", "dsc.csv"], &["dsc.csv: is given twice", "once"]),
        (&["--dsc", "dsc.csv", "--mass-mg", "1", "--mass-mg", "2"], &["--mass-mg is given 2 times for 1 curves"]),
        (&["--mass-mg", "12"], &["--dsc"]),
        (&[], &["RECORDING"]),
    ] {
        let (code, text, errors, fitted) = identified(folder.path(), words);
        assert!(code == Some(2) && text.is_empty() && fitted.is_empty(), "{words:?}: {code:?} {text}{errors}");
        assert!(said.iter().all(|said| errors.contains(said)), "{words:?}: {errors}");
    }
    // the whole sample's heat flow: temperatures without its mass, the heat with it
    let (code, text, errors, _) = identified(folder.path(), &["--dsc", "sample.csv", "--json"]);
    assert!(code == Some(0) && !text.contains("\"latent_heat_j_per_kg\": {"), "{errors}");
    assert!(errors.contains("latent_heat_j_per_kg stays as it was: the heat needs --mass-mg"), "{errors}");
    let (_, text, ..) =
        identified(folder.path(), &["--dsc", "sample.csv", "--mass-mg", "10", "--rate", "10", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    // 4 mW K under a peak, over 10 mg and 1/6 K/s
    assert!((number(&json, "/parameters/latent_heat_j_per_kg/value") - 2400.0).abs() < 30.0, "{json}");
}

/// A loop under 150 MPa of a wire whose transformation on heating is here, on cooling at 67 °C without stress.
fn loop_of(folder: &Path, austenite_c: f64) {
    let truth = format!(
        "{FURNACE}material = {{ austenite_temperature_c = {austenite_c}, heating_steepness_per_k = 0.4, cooling_steepness_per_k = 0.4 }}\n"
    );
    fs::write(folder.join("truth.toml"), truth).expect("a file");
    let force_n = 150e6 * std::f64::consts::FRAC_PI_4 * 0.5e-3_f64.powi(2);
    let sweep = (0..480).map(|i| if i < 240 { 30.0 + 0.6 * f64::from(i) } else { 30.0 + 0.6 * f64::from(479 - i) });
    let rows: String = sweep.enumerate().map(|(i, t)| format!("{i},{t:.2},{force_n}\n")).collect();
    fs::write(folder.join("inputs.csv"), format!("time_s,temperature_c,force_n\n{rows}")).expect("a file");
    let (is_well, text, errors) = run(folder, &["simulate", "truth.toml", "inputs.csv", "-o", "-"]);
    assert!(is_well, "{errors}");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let places = ["time_s", "temperature_c", "force_n", "position_m"]
        .map(|name| head.iter().position(|column| *column == name).expect("a column"));
    let mut seed = 1_u64;
    let mut noise = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut recording = "time_s,temperature_c,force_n,position_m\n".to_string();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let [time, temperature, force, position] = places.map(|place| cells[place]);
        let position: f64 = position.parse().expect("a number");
        recording += &format!("{time},{temperature},{force},{:.7}\n", position + 3e-5 * noise());
    }
    fs::write(folder.join("loop.csv"), recording).expect("a file");
}

#[test]
fn a_curve_and_a_loop_are_fitted_together_and_contradict_each_other_aloud() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    calorimeter(folder.path());
    fs::write(folder.path().join("rig.toml"), FURNACE).expect("a file");
    loop_of(folder.path(), 93.6);
    let (code, text, errors, _) = identified(folder.path(), &["loop.csv", "--dsc", "dsc.csv", "--json"]);
    assert!(code == Some(0) && !errors.contains("apart"), "{errors}");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let sigma = |place: &str| {
        let of = |end: &str| number(&json, &format!("/parameters/{place}/{end}"));
        (of("high") - of("low")) / (2.0 * 1.6449)
    };
    // the curve tells where it is without stress, the loop how far stress has moved it: 0.125 K/MPa
    assert!((number(&json, "/parameters/austenite_temperature_c/value") - 93.6).abs() < 1.5, "{json}");
    assert!((number(&json, "/parameters/stress_shift_k_per_mpa/value") - 0.125).abs() < 0.01, "{json}");
    assert!(sigma("austenite_temperature_c") < 1.2 && sigma("stress_shift_k_per_mpa") < 0.01, "{json}");
    assert!((number(&json, "/parameters/latent_heat_j_per_kg/value") - 24_200.0).abs() < 300.0, "{json}");
    // and the loop's temperatures are those that are read off it
    let (is_well, read, errors) =
        run(folder.path(), &["astm", "e3097", "loop.csv", "--length", "100mm", "--diameter", "0.5mm", "--json"]);
    assert!(is_well, "{errors}");
    let read: serde_json::Value = serde_json::from_str(&read).expect("JSON");
    for (name, place) in [
        ("austenite_start", "/figures/heating/start_c/value"),
        ("austenite_finish", "/figures/heating/finish_c/value"),
        ("martensite_start", "/figures/cooling/start_c/value"),
        ("martensite_finish", "/figures/cooling/finish_c/value"),
    ] {
        let named = number(&json, &format!("/temperatures/1/{name}/value_c"));
        assert!((named - number(&read, place)).abs() < 0.7, "{name}: {named}, read {read}");
    }
    // a wire that is 12 K apart on heating alone is no error of a thermometer, nor one of stress
    loop_of(folder.path(), 105.0);
    let (code, _, errors, _) = identified(folder.path(), &["loop.csv", "--dsc", "dsc.csv"]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(errors.contains("the recordings alone say") && errors.contains("σ apart"), "{errors}");
}

/// Loops as a laboratory recorded them: what the fitted model's temperatures differ by from those that are read off the loops.
#[test]
fn fitted_temperatures_are_those_of_real_loops() {
    let real = checkout().parent().map(|folder| folder.join("shared/real")).filter(|folder| folder.is_dir());
    let Some(real) = real else {
        println!("skipped: no ../shared/real beside this checkout");
        return;
    };
    for (name, loops) in [
        ("isobaric-flexinol", ["50mpa.csv", "150mpa.csv", "200mpa.csv"]),
        ("isobaric-nitihf", ["7mpa.csv", "100mpa.csv", "300mpa.csv"]),
    ] {
        let rig = real.join(name).join("rig.toml");
        let geometry: toml::Value = toml::from_str(&fs::read_to_string(&rig).expect("a rig file")).expect("TOML");
        let wire = &geometry["channel"][0]["wire"];
        let of = |key: &str| format!("{}mm", wire[key].as_float().expect("a size"));
        // a fit that has lost the loop names no temperature, and says why
        let mut far: f64 = 0.0;
        for file in loops {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let recording = real.join(name).join(file).display().to_string();
            let rig = rig.display().to_string();
            let words = ["identify", &rig, &recording, "-o", "fitted.toml", "--json"];
            let (is_well, text, errors) = run(folder.path(), &words);
            assert!(is_well, "{errors}");
            let fitted: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            if fitted.pointer("/temperatures/1").is_none() {
                println!("{name}/{file}: {}", fitted["warnings"]);
                continue;
            }
            let (length, diameter) = (of("length_mm"), of("diameter_mm"));
            let words = ["astm", "e3097", &recording, "--length", &length, "--diameter", &diameter, "--json"];
            let (is_well, text, errors) = run(folder.path(), &words);
            if !is_well {
                println!("{name}/{file}: {errors}");
                continue;
            }
            let read: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            for (symbol, name_of, place) in [
                ("A_s", "austenite_start", "/figures/heating/start_c/value"),
                ("A_f", "austenite_finish", "/figures/heating/finish_c/value"),
                ("M_s", "martensite_start", "/figures/cooling/start_c/value"),
                ("M_f", "martensite_finish", "/figures/cooling/finish_c/value"),
            ] {
                let (by_fit, by_eye) =
                    (number(&fitted, &format!("/temperatures/1/{name_of}/value_c")), number(&read, place));
                println!(
                    "{name}/{file}: {symbol} {by_fit:.1} °C fitted, {by_eye:.1} °C read, {:+.1} K",
                    by_fit - by_eye
                );
                far = far.max((by_fit - by_eye).abs());
            }
        }
        assert!(far < 10.0, "{name}: {far} K apart");
    }
}
