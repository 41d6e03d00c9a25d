//! What a page and a terminal's answer must hold, whatever they are made of.

mod specimen;

use sinew_report::{About, html, text};

fn about() -> About {
    About {
        rig: "tensile-bench".into(),
        channel: "wire".into(),
        command: "sinew diagnose bench.toml train.csv.gz --out diagnosis --seed 1".into(),
        version: "0.1.0".into(),
    }
}

/// Also leaves the pages where a person can look at them: `target/tmp/report-*.html`.
#[test]
fn a_page_has_every_section_and_stays_small() {
    for (name, (diagnosis, figures)) in [
        ("missing", specimen::physics_missing()),
        ("agrees", specimen::agrees()),
        ("parameters", specimen::parameters_off()),
        ("unknown", specimen::unknown_physics()),
    ] {
        let page = html(&diagnosis, &figures, &about());
        let path = format!("{}/report-{name}.html", env!("CARGO_TARGET_TMPDIR"));
        std::fs::write(&path, &page).expect("the scratch folder can be written to");
        std::fs::write(format!("{path}.txt"), text(&diagnosis, 110, false)).expect("so can a second file");
        assert!(page.len() < 2_000_000, "{name}: {} bytes", page.len());
        for id in ["answer", "fit", "where", "what", "parameters", "recordings", "next", "warnings", "again"] {
            assert!(page.contains(&format!("<section id=\"{id}\">")), "{name}: no section {id}");
        }
    }
}
