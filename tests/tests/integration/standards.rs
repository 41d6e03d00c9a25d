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
}
