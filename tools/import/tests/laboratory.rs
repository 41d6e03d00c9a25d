//! Files as laboratories have them, each read, understood, mapped and read again by its mapping: the numbers are those that
//! `make_files.py` put in, or the refusal is the right sentence.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sinew_import::{Bench, confirm, guess, mapping, read, read_bytes, recording};
use sinew_recording::{Column, Recording, TIME};
use sinew_rig::{FileFormat, Mapping, Rig};

/// The wire that all of them are of.
const RIG: &str = "[rig]\nname = \"bench\"\nambient_c = 23.5\n[[channel]]\nname = \"wire\"\n\
    wire = { diameter_mm = 0.125, length_mm = 160.0 }\ndrive = { supply_v = 6.0 }\nload = { mass_kg = 0.2 }\n";

/// What is expected of a file: quantity, row and value as they stand in `expected.csv`.
type Expected = Vec<(String, String, String)>;

fn expected(folder: &Path) -> BTreeMap<String, Expected> {
    let text = std::fs::read_to_string(folder.join("expected.csv")).expect("expected.csv");
    let mut files: BTreeMap<String, Expected> = BTreeMap::new();
    for line in text.lines().skip(1) {
        let mut cells = line.splitn(4, ',');
        let mut cell = || cells.next().expect("four cells").to_string();
        let (file, quantity, row, value) = (cell(), cell(), cell(), cell());
        // a sentence with commas or quotes is in quotes
        let value = value
            .strip_prefix('"')
            .and_then(|v| v.strip_suffix('"'))
            .map_or(value.clone(), |v| v.replace("\"\"", "\""));
        files.entry(file).or_default().push((quantity, row, value));
    }
    files
}

fn column<'r>(recording: &'r Recording, name: &str) -> Option<&'r [f64]> {
    if name == TIME { Some(recording.time_s()) } else { recording.get(Column::from_name(name)?) }
}

/// Everything that is wrong with how a file is read.
fn complaints(path: &Path, expected: &Expected) -> Vec<String> {
    let rig = Rig::parse(RIG, "rig.toml").expect("a rig");
    let bench = Bench::of(&rig.channels[0]);
    let refusal = expected.iter().find(|(quantity, ..)| quantity == "refused");
    let table = match (read(path, &FileFormat::default()), refusal) {
        (Ok(_), Some((.., words))) => return vec![format!("is read, and not refused with {words:?}")],
        (Err(error), Some((.., words))) => {
            let text = error.to_string();
            let right = text.contains(words.as_str()) && !error.hint.is_empty() && !text.contains('\n');
            return if right { Vec::new() } else { vec![format!("{text:?} has no {words:?}")] };
        }
        (Err(error), None) => return vec![format!("is refused: {error}")],
        (Ok(table), None) => table,
    };
    let understood = guess(&table, Some(&bench), None);
    let name = path.file_name().expect("a name").to_string_lossy();
    let said = confirm(&name, &table, &understood);
    let text = mapping(&name, &table, &understood);
    let mut wrong = Vec::new();
    // what is written is what was meant, and reads the file as it was read
    let again = match Mapping::parse(&text, "map.toml") {
        Ok(again) => again,
        Err(error) => return vec![format!("its mapping is none: {error}\n{text}")],
    };
    if again != understood.mapping {
        wrong.push(format!("its mapping reads back as another:\n{text}"));
    }
    let table_again = match read(path, &again.format) {
        Ok(table) => table,
        Err(error) => return vec![format!("by its own mapping it is refused: {error}\n{text}")],
    };
    let recording = match recording(path, &table_again, &again, None) {
        Ok(recording) => recording,
        Err(error) => return vec![format!("by its mapping: {error}\n{said}")],
    };
    for (quantity, row, value) in expected {
        let (of, change) = quantity.split_once(':').map_or((quantity.as_str(), false), |(of, _)| (of, true));
        match of {
            "rows" => {
                if recording.len().to_string() != *value {
                    wrong.push(format!("{} rows, not {value}", recording.len()));
                }
            }
            "says" => {
                if !said.contains(value.as_str()) && !text.contains(value.as_str()) {
                    wrong.push(format!("does not say {value:?}"));
                }
            }
            _ => {
                let Some(values) = column(&recording, of) else {
                    wrong.push(format!("has no {of}"));
                    continue;
                };
                let Some(&found) = row.parse().ok().and_then(|row: usize| values.get(row)) else {
                    wrong.push(format!("{of} has no row {row}"));
                    continue;
                };
                let found = if change { found - values[0] } else { found };
                let right = match value.parse::<f64>() {
                    Ok(value) => (found - value).abs() <= 1e-9 * value.abs() + 1e-9,
                    Err(_) => found.is_nan(),
                };
                if !right {
                    wrong.push(format!("{of} in row {row} is {found}, not {value}"));
                }
            }
        }
    }
    if !wrong.is_empty() {
        wrong.push(said);
    }
    wrong
}

fn all_right(folder: &str, least: usize) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
    let files = expected(&folder);
    assert!(files.len() >= least, "{} files", files.len());
    let mut wrong = Vec::new();
    for (file, expected) in &files {
        assert!(expected.iter().any(|(quantity, ..)| quantity != "says"), "{file}: nothing is expected of it");
        for complaint in complaints(&folder.join(file), expected) {
            wrong.push(format!("{file}: {complaint}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_file_is_read_right_or_refused_with_the_right_sentence() {
    all_right("files", 50);
}

#[test]
fn what_is_not_clear_is_said_and_left_out() {
    let rig = Rig::parse(RIG, "rig.toml").expect("a rig");
    let bench = Bench::of(&rig.channels[0]);
    let rows = |row: &dyn Fn(usize) -> String| (0..40).map(|k| row(k) + "\n").collect::<String>();
    let told = |text: String| {
        let table = sinew_import::read_bytes(text.as_bytes(), &FileFormat::default()).unwrap_or_else(|e| panic!("{e}"));
        let understood = guess(&table, Some(&bench), None);
        (understood.mapping.columns.clone(), confirm("x.csv", &table, &understood))
    };
    // two forces: neither is taken, both are named
    let (columns, said) = told(
        "t [s];Kraft links [N];Kraft rechts [N];Tastgrad [%]\n".to_string()
            + &rows(&|k| format!("{k};2,{k:02};1,{k:02};{}", k % 20)),
    );
    assert!(!columns.contains_key("force_n") && columns.contains_key("duty"), "{said}");
    assert!(said.contains("force_n may be any of \"Kraft links [N]\", \"Kraft rechts [N]\": none is taken"), "{said}");
    // a position that heat says nothing of
    let (_, said) =
        told("t [s],duty,position [mm]\n".to_string() + &rows(&|k| format!("{k},{},{}", (k / 10) % 2, (k * 7) % 5)));
    assert!(said.contains("its direction is not seen"), "{said}");
    // no time, and no drive
    let (columns, said) = told("Weg [mm];Kraft [N]\n".to_string() + &rows(&|k| format!("1,{};2,0", (k * 7) % 5)));
    assert!(!columns.contains_key("time_s"), "{said}");
    assert!(said.contains("--rate") && said.contains("no column is taken for duty"), "{said}");
    // rows of empty cells, as spreadsheets leave them at the end
    let (_, said) = told("t [s];Weg [mm]\n".to_string() + &rows(&|k| format!("{k};1,{k}")) + ";\n;\n");
    assert!(said.contains("40 rows") && !said.contains("empty"), "{said}");
    // a unit that cannot be right
    let (_, said) = told("t [s];Weg [m]\n".to_string() + &rows(&|k| format!("{k};1,{k:02}")));
    assert!(said.contains("is its unit m?"), "{said}");
}

#[test]
fn files_set_aside_until_the_importer_was_done_are_read_right() {
    all_right("unseen", 10);
}

/// Recordings of real wires by other people, which stay where they are: what their names and heat say is what they are.
#[test]
fn real_recordings_are_understood() {
    let real = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/real");
    if !real.is_dir() {
        return eprintln!("skipped: no real recordings beside this checkout");
    }
    let mut files = 0;
    for folder in
        std::fs::read_dir(&real).expect("a folder").flatten().map(|entry| entry.path()).filter(|path| path.is_dir())
    {
        let rig = Rig::load(&folder.join("rig.toml")).expect("a rig");
        let bench = Bench::of(&rig.channels[0]);
        for path in std::fs::read_dir(&folder).expect("a folder").flatten().map(|entry| entry.path()) {
            if path.extension().is_none_or(|end| end != "csv") {
                continue;
            }
            files += 1;
            let table = read(&path, &FileFormat::default()).unwrap_or_else(|e| panic!("{e}"));
            let understood = guess(&table, Some(&bench), None);
            for (quantity, column) in &understood.mapping.columns {
                let said = confirm(&path.display().to_string(), &table, &understood);
                assert_eq!((quantity, column.scale, column.offset), (&column.column, 1.0, 0.0), "{said}");
            }
            assert_eq!(understood.mapping.columns.len(), table.columns.len());
            let own = sinew_recording::read(&path, &sinew_recording::Options::default()).expect("a recording");
            let through = recording(&path, &table, &understood.mapping, None).expect("a recording");
            assert!(through.has_the_samples_of(&own), "{}", path.display());
        }
    }
    assert!(files > 0);
}

/// A wire that was driven by a current, and a rig file that says PWM: the remedy is named.
#[test]
fn another_drive_than_the_rig_files_is_proposed() {
    let rig = Rig::parse(RIG, "rig.toml").expect("a rig");
    let text = "t [s],Current [mA],Position [mm]\n0,100,7.0\n1,150,6.0\n2,200,5.0\n3,250,4.0\n";
    let table = read_bytes(text.as_bytes(), &FileFormat::default()).expect("a table");
    let guess = guess(&table, Some(&Bench::of(&rig.channels[0])), None);
    let said = confirm("lab.csv", &table, &guess);
    assert!(said.contains("if current_a is what drove it, set kind = \"current\" in the channel's drive"), "{said}");
}
