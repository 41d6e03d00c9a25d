//! `sinew design`: from requirements to a rig file that the other commands take.

use crate::support::Scratch;

/// A number of a JSON answer.
fn number(answer: &serde_json::Value, path: &str) -> f64 {
    answer.pointer(path).and_then(serde_json::Value::as_f64).unwrap_or_else(|| panic!("{path} in {answer}"))
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error} in {text}"))
}

#[test]
fn a_designed_wire_is_a_rig() {
    let scratch = Scratch::new();
    scratch.sinew(["design", "--force", "1.5N", "--stroke", "6mm", "--cycle", "3s", "-o", "muscle.toml"]).done();
    let tuned = scratch.sinew(["tune", "muscle.toml"]).done();
    assert!(tuned.contains("as modelled"), "{tuned}");
    let joint = ["design", "--torque", "30mNm", "--angle", "60deg", "--span", "200mm", "--joint", "pulley"];
    let joint = scratch.sinew(joint).done();
    assert!(joint.contains("pulley of 7.64 mm"), "{joint}");
}

/// What is said of a design is what `tune` says of its rig file, and what is predicted is what is simulated.
#[test]
fn design_agrees_with_tune_and_with_the_simulation() {
    let scratch = Scratch::new();
    let demand = ["--force", "1.5N", "--stroke", "6mm", "--supply", "5V"];
    let said = json(&scratch.sinew(["design"].into_iter().chain(demand).chain(["--json"])).done());
    scratch.sinew(["design"].into_iter().chain(demand).chain(["-o", "muscle.toml"])).done();
    assert_eq!(said["rig_file"].as_str(), std::fs::read_to_string(scratch.path("muscle.toml")).ok().as_deref());
    let tuned = json(&scratch.sinew(["tune", "muscle.toml", "--json"]).done());
    for rate in ["heating_per_s", "cooling_per_s", "load_per_s"] {
        let (here, there) = (format!("/as_modelled/{rate}"), format!("/channels/0/as_modelled/{rate}"));
        assert_eq!(number(&said, &here), number(&tuned, &there), "{rate}");
    }
    let chosen = said["chosen"].as_u64().unwrap();
    for what in ["stroke_m", "pull_n", "heating_s", "cooling_s", "first_s", "power_w"] {
        let predicted = number(&said, &format!("/wires/{chosen}/predicted/{what}"));
        let simulated = number(&said, &format!("/simulated/{what}"));
        assert!((predicted / simulated - 1.0).abs() < 0.1, "{what}: {predicted} {simulated}");
    }
}

/// Its tables fit a terminal of 80 columns, and the picture is one.
#[test]
fn what_is_printed_fits_and_the_plot_is_drawn() {
    let scratch = Scratch::new();
    let battery = ["--supply", "7.4V", "--most-current", "9A", "--internal", "0.1ohm", "--capacity", "850mAh"];
    let demand = ["design", "--force", "12N", "--stroke", "6mm", "--plot", "compromise.svg"];
    let said = scratch.sinew(demand.into_iter().chain(battery)).done();
    let wide: Vec<&str> = said.lines().filter(|line| line.chars().count() > 80).collect();
    assert!(wide.is_empty(), "{}", wide.join("\n"));
    assert!(said.contains("the battery lasts") && said.contains("predicted") && said.contains("eq. 17"), "{said}");
    let picture = std::fs::read_to_string(scratch.path("compromise.svg")).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("Bandwidth"), "{picture}");
}

#[test]
fn what_cannot_be_done_says_what_can() {
    let scratch = Scratch::new();
    let refused = |demand: &str, words: &[&str]| {
        scratch.sinew(["design"].into_iter().chain(demand.split(' '))).refused(words);
    };
    refused("--force 20N --stroke 6mm --cycle 0.1", &["no wire does all of that", "there and back takes", "--cycle"]);
    refused("--force 2N --stroke 6mm --supply 1V", &["the air takes all that 1 V give", "--supply"]);
    refused("--force 2N --stroke 6mm --method stroke --span 80mm", &["contracts by 4 %", "3.2 mm", "--method energy"]);
    refused("--force 90N --stroke 6mm --wires 2", &["170 MPa", "--wires", "--force"]);
    refused("--force 20N --stroke 6mm --supply 6V --most-current 0.5A", &["draw", "--most-current"]);
    refused(
        "--torque 30mNm --angle 170deg --joint lever --span 200mm",
        &["a lever turns 115 degrees", "--joint pulley"],
    );
    refused("--torque 30mNm --angle 60deg --joint pulley --span 30mm --diameter 0.2mm", &["bent", "--joint lever"]);
    refused("--force 20N --stroke 6mm --wires 4 --in-series 3", &["4 wires make no rows of 3", "--wires 6"]);
    refused("--force 2N --stroke 6mm --ambient 95", &["too warm", "--ambient"]);
    refused("--force 2 --stroke 6mm", &["as in 2N"]);
    refused("--force 2N", &["--stroke"]);
    refused("--force 2N --stroke 6mm --internal 1ohm", &["--supply"]);
    scratch.sinew(["design"]).refused(&["--force"]);
}
