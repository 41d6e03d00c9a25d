//! `docs/rig.md` says what the code does: its tables are those of the schema, its examples are read.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-rig --test reference` writes the tables into the page.

use std::fmt::Write as _;
use std::path::Path;

use sinew_rig::{EFFECTS, EffectParameterKind, FaultKind, Prior, RECORDING_COLUMNS, Rig, default_priors};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/rig.md");

fn priors() -> String {
    let mut out = "| key | 1 σ |\n|---|---|\n".to_string();
    for (key, prior) in default_priors() {
        let sigma = match prior {
            Prior::Relative(fraction) => format!("{} %", (fraction * 100.0).round()),
            Prior::Absolute(kelvin) => format!("{kelvin} K"),
        };
        writeln!(out, "| `{key}` | {sigma} |").unwrap();
    }
    out
}

fn effects() -> String {
    let mut out = "| id | parameters (null) |\n|---|---|\n".to_string();
    for effect in EFFECTS {
        let parameters: Vec<String> = effect
            .parameters
            .iter()
            .map(|p| match p.kind {
                EffectParameterKind::Switch { null } => format!("`{}` ({null})", p.name),
                _ => format!("`{}`", p.name),
            })
            .collect();
        writeln!(out, "| `{}` | {} |", effect.id, parameters.join(", ")).unwrap();
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

fn columns() -> String {
    let quoted: Vec<String> = RECORDING_COLUMNS.iter().map(|c| format!("`{c}`")).collect();
    format!("{}.\n", quoted.join(", "))
}

#[test]
fn the_page_carries_the_tables_of_the_code() {
    let mut page = std::fs::read_to_string(PAGE).unwrap();
    let bless = std::env::var_os("SINEW_BLESS").is_some();
    for (mark, text) in [
        ("keys", sinew_rig::reference()),
        ("priors", priors()),
        ("effects", effects()),
        ("columns", columns()),
        ("faults", faults()),
    ] {
        let (open, close) = (format!("<!-- {mark} -->\n"), format!("<!-- /{mark} -->"));
        let start = page.find(&open).expect(mark) + open.len();
        let end = start + page[start..].find(&close).expect(mark);
        if bless {
            page.replace_range(start..end, &text);
        } else {
            assert!(
                page[start..end] == text,
                "docs/rig.md: the {mark} are not those of the code; run with SINEW_BLESS=1"
            );
        }
    }
    if bless {
        std::fs::write(PAGE, page).unwrap();
    }
}

#[test]
fn the_examples_of_the_page_are_read() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    let examples: Vec<&str> = page.split("```toml\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert_eq!(examples.len(), 3);
    let smallest = examples[0];
    Rig::parse(smallest, "docs/rig.md").unwrap().check_drivable().unwrap();
    for more in &examples[1..] {
        Rig::parse(&format!("{smallest}\n{more}"), "docs/rig.md").unwrap_or_else(|e| panic!("{e}"));
    }
}

#[test]
fn effects_and_columns_are_those_of_the_contract() {
    let contract = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/contract");
    let Ok(catalogue) = std::fs::read_to_string(contract.join("effects.md")) else {
        println!("skipped: no ../shared beside the project");
        return;
    };
    let ids: Vec<&str> = catalogue.lines().filter_map(|l| l.strip_prefix("| `")?.split('`').next()).collect();
    let known: Vec<&str> =
        sinew_rig::COEFFICIENT_EFFECTS.iter().map(|(id, _)| *id).chain(EFFECTS.iter().map(|e| e.id)).collect();
    assert_eq!(known, ids);
    for effect in EFFECTS {
        let line = catalogue.lines().find(|l| l.contains(&format!("`{}`", effect.id))).unwrap();
        let cell = line.split('|').nth(2).unwrap();
        for parameter in effect.parameters {
            assert!(cell.contains(&format!("`{}`", parameter.name)), "{} {}", effect.id, parameter.name);
        }
    }

    // The contract's own example uses every table; its draught is the one thing this version cannot do.
    let page = std::fs::read_to_string(contract.join("rig.md")).unwrap();
    let example = page.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let error = Rig::parse(example, "rig.toml").unwrap_err().to_string();
    assert!(
        error.contains("effects.\"thermal.draught\" has gain switched on: this version does not simulate"),
        "{error}"
    );
    assert_eq!(error.lines().count(), 1, "{error}");
    let rig = Rig::parse(&example.replace("gain = 0.35", "gain = 0.0"), "rig.toml").unwrap();
    rig.check_drivable().unwrap();

    let recording = std::fs::read_to_string(contract.join("recording.md")).unwrap();
    for column in RECORDING_COLUMNS {
        assert!(recording.contains(&format!("`{column}`")), "{column}");
    }
}
