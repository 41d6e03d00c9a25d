//! Makes `include/sinew.h` anew and compares. Calls, structs and codes are read from the sources by cbindgen; what `sinew-ipc` makes of a table
//! (a channel's fields, the faults) is written from that table.

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, ExportConfig, Language, RenameRule, Style};
use sinew_ipc::{ChannelState, FAULT_TABLE, FieldKind, PROTOCOL};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const HEAD: &str = r#"/*
 * sinew.h: the client of a robot program, for C. Written from its sources by cbindgen; do not edit.
 *
 * A program connects to a running driver (`sinew run`), reads its state and gives commands with leases:
 * docs/bindings.md is the guided tour. Link with `pkg-config --cflags --libs sinew`.
 *
 * Results. Every call that can fail gives a SinewStatus: SINEW_OK, SINEW_NOTHING where it waited in vain, or an error below zero,
 * whose words with what to do about it are sinew_last_error(). What a call would have written is then left as it was (handles: null).
 *
 * Threads. Any thread may call anything. A client may be shared between threads; a stream and a fault watch are for one thread at a time,
 * and say so to the second (SINEW_ERROR_IN_USE). The words of an error are those of the thread whose call failed. What is
 * closed while another thread is in a call with it lives until that call ends. A process made by fork() connects anew: handles it has
 * inherited are refused there (SINEW_ERROR_HANDLE), and stay good in the process before.
 *
 * Pointers. Null where something is needed, an odd address, a name without an end, a handle that is closed or is none: an error with its remedy.
 * What is not null has to lead to what the call is said to write or read; that no library can see. Handles are numbers, not addresses.
 *
 * Panics never come through; SINEW_ERROR_PANIC reports one. Names and words are UTF-8. Units are SI. What is not known is NaN.
 */
"#;

const WIDTH: usize = 120;

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The version `build.rs` gives the library.
fn abi() -> String {
    let build = fs::read_to_string(sources().with_file_name("build.rs")).unwrap();
    let line = build.lines().find_map(|line| line.strip_prefix("const ABI: u32 = ")).expect("build.rs says it");
    line.trim_end_matches(';').into()
}

/// What cbindgen cannot read, because macros make it: from the tables.
fn tables() -> String {
    let mut text = format!(
        "\n// Version of the calls and structs below; that of the library is sinew_abi().\n#define SINEW_ABI {}\n\n\
         // Version of the messages it speaks; that of the library is sinew_protocol().\n#define SINEW_PROTOCOL {PROTOCOL}\n\n",
        abi()
    );
    text += "// Why a channel is, or the whole driver went, without power; 0 in messages means no fault. sinew_fault_remedy() says what to do.\n";
    text += "enum SinewFault\n#ifdef __cplusplus\n  : uint32_t\n#endif\n {\n";
    for row in &FAULT_TABLE {
        let (name, code) = (row.flag.to_uppercase(), row.fault.code());
        write!(text, "  // {}.\n  SINEW_FAULT_{name} = {code},\n", row.cause).unwrap();
    }
    text += "};\n#ifndef __cplusplus\ntypedef uint32_t SinewFault;\n#endif\n\n";
    text += "// One channel in one cycle, in SI units. What is not known is NaN.\ntypedef struct SinewChannelState {\n";
    for field in ChannelState::FIELDS {
        let kind = match field.kind {
            FieldKind::Float => "double",
            FieldKind::Code => "uint32_t",
        };
        let unit = if field.unit.is_empty() { String::new() } else { format!(" ({})", field.unit) };
        let meaning = field.meaning.trim().replace("`CommandKind`", "`SinewCommandKind`");
        write!(text, "  //{unit} {meaning}\n  {kind} {};\n", field.name).unwrap();
    }
    text + "} SinewChannelState;"
}

fn header() -> String {
    let words = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
    let config = Config {
        language: Language::C,
        cpp_compat: true,
        style: Style::Type,
        header: Some(HEAD.trim_end().into()),
        include_guard: Some("SINEW_H".into()),
        after_includes: Some(tables()),
        no_includes: true,
        sys_includes: words(&["stddef.h", "stdint.h"]),
        documentation_style: DocumentationStyle::C99,
        usize_is_size_t: true,
        line_length: WIDTH,
        enumeration: EnumConfig { rename_variants: RenameRule::QualifiedScreamingSnakeCase, ..EnumConfig::default() },
        export: ExportConfig {
            prefix: Some("Sinew".into()),
            include: words(&["Mode", "CommandKind", "Outcome", "DriverState"]),
            renaming_overrides_prefixing: true,
            rename: ["MAX_CHANNELS", "NAME_SIZE"].map(|name| (name.to_string(), format!("SINEW_{name}"))).into(),
            ..ExportConfig::default()
        },
        ..Config::default()
    };
    let here = sources();
    let messages = here.join("../../../ipc/src/messages");
    let files = ["channel", "cycle", "command"].map(|file| messages.join(file));
    let own = ["status", "structs", "connection", "state", "command", "setpoints", "faults", "clocks", "last"]
        .map(|file| here.join(file));
    let builder = files
        .into_iter()
        .chain(own)
        .fold(Builder::new().with_config(config), |builder, file| builder.with_src(file.with_extension("rs")));
    let mut made = Vec::new();
    builder.generate().expect("the sources can be read").write(&mut made);
    tidied(&String::from_utf8(made).expect("UTF-8"))
}

/// Without what only Rust's own documentation understands.
fn tidied(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut is_safety = false;
    for line in text.lines() {
        let is_comment = line.trim_start().starts_with("//");
        if line == "// # Safety" {
            is_safety = true;
            // and the empty line before it
            lines.truncate(lines.len() - 1);
        }
        is_safety &= is_comment;
        if !is_safety {
            let line = NAMES.iter().fold(line.to_string(), |line, (rust, c)| line.replace(rust, c));
            lines.extend(if is_comment { wrapped(&line) } else { vec![line] });
        }
    }
    lines.join("\n") + "\n"
}

/// What Rust's documentation says, and how C calls it.
const NAMES: [(&str, &str); 6] = [
    ("[`", "`"),
    ("`]", "`"),
    ("SinewChannelState_FLAG_", "SINEW_FLAG_"),
    ("ChannelState::FLAG_", "SINEW_FLAG_"),
    ("`DriverState`", "`SinewDriverState`"),
    ("`Snapshot::channels`", "`channels`"),
];

/// A comment in lines that are not too long.
fn wrapped(line: &str) -> Vec<String> {
    let (indent, words) = line.split_once("//").expect("a comment");
    let mut lines = vec![format!("{indent}//")];
    for word in words.split_whitespace() {
        let last = lines.last_mut().expect("there is one");
        match last.chars().count() + 1 + word.chars().count() > WIDTH {
            true => lines.push(format!("{indent}// {word}")),
            false => write!(last, " {word}").unwrap(),
        }
    }
    lines
}

#[test]
fn the_header_is_that_of_the_code() {
    let path = sources().with_file_name("include").join("sinew.h");
    let made = header();
    if std::env::var_os("SINEW_BLESS").is_some() {
        fs::write(&path, made).expect("a writable folder");
    } else {
        let found = fs::read_to_string(&path).unwrap_or_default();
        assert_eq!(found, made, "include/sinew.h is another one; SINEW_BLESS=1 writes it anew");
    }
}
