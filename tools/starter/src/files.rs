//! The files of a bench.

use std::path::{Path, PathBuf};

use crate::bench::Bench;

/// What the first robot program is written in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Language {
    /// Python, with the package `sinew`.
    Python,
    /// Rust, with the crate `sinew-ipc` of the sources in this folder.
    Rust {
        /// A checkout of the project.
        sources: PathBuf,
    },
}

/// A file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Where, from the bench's folder.
    pub path: PathBuf,
    /// What stands in it.
    pub text: String,
}

/// What stands for the rig's name in the templates.
const PLACEHOLDER: &str = "RIG_NAME";
/// Where the schema lies.
const SCHEMA: &str = "rig.schema.json";

/// All files of a bench; `schema` is that of a rig file, for editors.
pub fn files(bench: &Bench, language: &Language, schema: &str) -> Vec<File> {
    let name = &bench.name;
    let file = |path: &str, text: String| File { path: Path::new(path).into(), text };
    let mut files = vec![file(&format!("{name}.toml"), bench.rig_file())];
    match language {
        Language::Python => {
            files.push(file("robot.py", include_str!("../templates/robot.py").replace(PLACEHOLDER, name)));
        }
        Language::Rust { sources } => {
            let ipc = sources.join("ipc");
            // no member of a workspace that may lie around it
            let manifest = format!(
                "[package]\nname = \"robot\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n[dependencies]\n\
                 sinew-ipc = {{ path = {:?} }}\n\n[workspace]\n",
                ipc.display().to_string()
            );
            files.push(file("Cargo.toml", manifest));
            files.push(file("src/main.rs", include_str!("../templates/robot.rs").replace(PLACEHOLDER, name)));
        }
    }
    files.push(file(SCHEMA, schema.into()));
    // Even Better TOML in VS Code, and taplo by itself, complete and check by the schema.
    files.push(file(
        ".vscode/settings.json",
        format!("{{\n  \"evenBetterToml.schema.associations\": {{ \".*/{name}\\\\.toml\": \"./{SCHEMA}\" }}\n}}\n"),
    ));
    files.push(file(
        ".taplo.toml",
        format!("[[rule]]\ninclude = [\"{name}.toml\"]\n\n[rule.schema]\npath = \"./{SCHEMA}\"\n"),
    ));
    files
}

#[cfg(test)]
mod tests {
    use super::*;
    use sinew_rig::WireKind;

    #[test]
    fn every_file_is_what_its_reader_takes() {
        let bench = Bench::of("arm.2", WireKind::of("flexinol-150-lt").expect("one of the library"));
        let rust = Language::Rust { sources: "/a \"b\"".into() };
        for (language, robot) in [(&Language::Python, "robot.py"), (&rust, "src/main.rs")] {
            let files = files(&bench, language, "{}");
            let of = |path: &str| &files.iter().find(|file| file.path == Path::new(path)).expect(path).text;
            assert!(of(robot).contains("arm.2") && !of(robot).contains(PLACEHOLDER), "{}", of(robot));
            sinew_rig::Rig::parse(of("arm.2.toml"), "arm.2.toml").expect("a rig file");
            let settings: serde_json::Value = serde_json::from_str(of(".vscode/settings.json")).expect("JSON");
            let pattern = settings["evenBetterToml.schema.associations"].as_object().expect("a table");
            assert!(pattern.contains_key(".*/arm.2\\.toml"), "{pattern:?}");
            let taplo: toml::Table = of(".taplo.toml").parse().expect("TOML");
            assert_eq!(taplo["rule"][0]["include"][0].as_str(), Some("arm.2.toml"));
            if language == &rust {
                let manifest: toml::Table = of("Cargo.toml").parse().expect("TOML");
                assert_eq!(manifest["dependencies"]["sinew-ipc"]["path"].as_str(), Some("/a \"b\"/ipc"));
            }
        }
    }
}
