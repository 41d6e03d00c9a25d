//! `docs/rig.md`, `docs/effects.md` and `docs/own-physics.md` say what the code does: their tables are those of the keys, the
//! catalogue and the quantities, their examples are read.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-rig --test integration reference::` writes the tables into the pages.

use std::fmt::Write as _;
use std::path::Path;

use sinew_physics::effects::{Entry, Home, QUANTITIES};
use sinew_rig::{Catalogue, FaultKind, FileFormat, Prior, RECORDING_COLUMNS, Rig, WIRE_KINDS, default_priors};

/// The wires by name, with what their sheets say.
fn wires() -> String {
    let mut text = String::from(
        "| `kind` | sold as | diameter | resistance | pull | stretch | current | cools in |\n|---|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for kind in &WIRE_KINDS {
        let gram = |force_n: f64| (force_n / 9.806_65e-3 * 10.0).round() / 10.0;
        let _ = writeln!(
            text,
            "| `{}` | {} | {:.4} mm | {} Ω/m | {} g | {} g | {:.0} mA | {} s |",
            kind.name,
            kind.product,
            kind.diameter_m * 1e3,
            kind.ohm_per_m,
            gram(kind.pull_n),
            gram(kind.stretch_n),
            kind.current_a * 1e3,
            kind.cooling_s
        );
    }
    text
}

fn priors() -> String {
    let mut out = "| key | 1 σ |\n|---|---|\n".to_string();
    for (key, prior) in default_priors() {
        let sigma = match prior {
            // rounding hides that 0.02 · 100 is no whole number
            Prior::Relative(fraction) => format!("{} %", (fraction * 1e4).round() / 1e2),
            Prior::Absolute(sigma) => format!("{sigma}{}", unit_of(key)),
        };
        writeln!(out, "| `{key}` | {sigma} |").unwrap();
    }
    out
}

/// The unit of a key whose prior is not relative.
fn unit_of(key: &str) -> &'static str {
    let units = [("_c", " K"), ("_v", " V"), ("_a", " A"), ("_n", " N"), ("_m", " m")];
    match units.into_iter().find(|(end, _)| key.ends_with(end)) {
        Some((_, unit)) => unit,
        None => {
            assert!(key.starts_with("sensing.gain."), "{key}: a unit, or none?");
            ""
        }
    }
}

fn effects() -> String {
    let mut out = "| id | in | what it does |\n|---|---|---|\n".to_string();
    for effect in sinew_physics::effects::catalogue() {
        let home = match effect.home {
            Home::Material => "`[channel.material]`",
            Home::Table => "a table of its own",
        };
        let anchor = effect.id.replace('.', "");
        writeln!(out, "| [`{}`](effects.md#{anchor}) | {home} | {}. |", effect.id, effect.says).unwrap();
    }
    out
}

fn faults() -> String {
    let mut out = "| kind | `value` | range | default |\n|---|---|---|---|\n".to_string();
    for (word, kind) in FaultKind::ALL {
        match (kind.value_key(), kind.value_range()) {
            (Some(meaning), Some((low, high, default))) => {
                writeln!(out, "| `{word}` | {meaning} | {low} to {high} | {default} |").unwrap();
            }
            _ => writeln!(out, "| `{word}` | none | | |").unwrap(),
        }
    }
    out
}

fn entries() -> String {
    let mut out = "| `enters` | unit | cut off beyond | |\n|---|---|---|---|\n".to_string();
    for (_, word, unit, most, about) in Entry::ALL {
        writeln!(out, "| `{word}` | {unit} | {most} | {about} |").unwrap();
    }
    out
}

fn quantities() -> String {
    let mut out = "| name | unit | |\n|---|---|---|\n".to_string();
    for (name, unit, about) in QUANTITIES {
        writeln!(out, "| `{name}` | {unit} | {about} |").unwrap();
    }
    out
}

fn columns() -> String {
    let quoted: Vec<String> = RECORDING_COLUMNS.iter().map(|c| format!("`{c}`")).collect();
    format!("{}.\n", quoted.join(", "))
}

fn format() -> String {
    let mut out = "| key | |\n|---|---|\n".to_string();
    for (key, takes) in FileFormat::KEYS {
        writeln!(out, "| `{key}` | {} |", takes.replace('|', "\\|")).unwrap();
    }
    out
}

/// Compares what stands between the marks of a page with what the code says, or writes it there.
fn carries(page: &str, marked: &[(&str, String)]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(page);
    let mut text = std::fs::read_to_string(&path).unwrap();
    let bless = std::env::var_os("SINEW_BLESS").is_some();
    for (mark, says) in marked {
        let (open, close) = (format!("<!-- {mark} -->\n"), format!("<!-- /{mark} -->"));
        let start = text.find(&open).expect(mark) + open.len();
        let end = start + text[start..].find(&close).expect(mark);
        if bless {
            text.replace_range(start..end, says);
        } else {
            assert!(
                text[start..end] == *says,
                "docs/{page}: the {mark} are not those of the code; run with SINEW_BLESS=1"
            );
        }
    }
    if bless {
        // whole at once: other tests read the page meanwhile
        let beside = path.with_extension("blessed");
        std::fs::write(&beside, text).unwrap();
        std::fs::rename(beside, path).unwrap();
    }
}

#[test]
fn the_pages_carry_the_tables_of_the_code() {
    let keys = [
        ("keys", sinew_rig::reference()),
        ("wires", wires()),
        ("priors", priors()),
        ("effects", effects()),
        ("columns", columns()),
        ("format", format()),
        ("faults", faults()),
    ];
    carries("rig.md", &keys);
    carries("effects.md", &[("catalogue", sinew_rig::catalogue())]);
    carries("own-physics.md", &[("entries", entries()), ("quantities", quantities())]);
}

#[test]
fn the_examples_of_the_page_are_read() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/rig.md")).unwrap();
    let examples: Vec<&str> = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(examples.len(), 6);
    let smallest = examples[0];
    Rig::parse(smallest, "docs/rig.md").unwrap().check_drivable().unwrap();
    for more in &examples[1..] {
        Rig::parse(&format!("{smallest}\n{more}"), "docs/rig.md").unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn the_laws_of_the_page_are_read() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/own-physics.md")).unwrap();
    let examples: Vec<&str> = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    let [slipstream, set, creep] = examples[..] else { panic!("{} examples", examples.len()) };
    let catalogue = Catalogue::parse(&format!("{slipstream}\n{creep}"), "laws.toml").unwrap_or_else(|e| panic!("{e}"));
    let rig = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/rig.md")).unwrap();
    let smallest = rig.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let rig = Rig::parse_with(&format!("{smallest}\n{set}"), "rig.toml", &catalogue).unwrap_or_else(|e| panic!("{e}"));
    let acting = |id: &str| !rig.channels[0].model.effect(id).unwrap().is_null(&rig.channels[0].model);
    assert!(acting("own.slipstream") && !acting("own.creep"));
}

#[test]
fn keys_and_columns_are_those_of_the_contract() {
    let contract = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/contract");
    let Ok(page) = std::fs::read_to_string(contract.join("rig.md")) else {
        println!("skipped: no ../shared beside the project");
        return;
    };
    // The contract's own example uses every table.
    let example = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let rig = Rig::parse(example, "rig.toml").unwrap_or_else(|e| panic!("{e}"));
    rig.check_drivable().unwrap();
    assert_eq!(rig.effect_parameter(0, "thermal.draught", "end_s"), Some(52.0));

    // Every effect of the contract can be named with all its keys.
    let effects = std::fs::read_to_string(contract.join("effects.md")).unwrap();
    let rows = effects.lines().filter_map(|line| line.strip_prefix("| `"));
    for row in rows {
        let (id, rest) = row.split_once('`').unwrap();
        for key in rest.split('|').nth(1).unwrap().split('`').skip(1).step_by(2) {
            // what begins with dots, or stands for a choice of channel, is no number's name
            let known = rig.effect_parameter(0, id, key).is_some() || key == "channel" || key.starts_with("...");
            assert!(known, "{id} {key}");
        }
    }

    let recording = std::fs::read_to_string(contract.join("recording.md")).unwrap();
    for column in RECORDING_COLUMNS {
        assert!(recording.contains(&format!("`{column}`")), "{column}");
    }
}
