//! The plan as it is committed before the first scored run: what is in it, and a hash of the generators that make it. A
//! scoring run with another plan or another generator is refused.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use sha2::{Digest, Sha256};
use sinew_concealed::generator::plan::{Seeds, plan, table};
use sinew_concealed::second::mechanisms::NOVEL;

use crate::failure::Failure;

/// The committed file, in the crate's folder.
const FILE: &str = "plan.csv";
/// The crate of the generators, seen from this one, and what in it makes cases.
const GENERATORS: &str = "../../tools/concealed";
const SOURCES: [&str; 2] = ["src/generator", "src/second"];

fn home() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Everything below the folders that make cases, by its path in their crate, in order.
fn sources() -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> = SOURCES.iter().map(PathBuf::from).collect();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(home().join(GENERATORS).join(&folder))? {
            let entry = entry?;
            let path = folder.join(entry.file_name());
            if entry.file_type()?.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    Ok(files)
}

/// SHA-256 over names and contents of the generators' sources.
///
/// # Errors
/// Those of the file system.
pub fn generators() -> Result<String, Failure> {
    let mut hash = Sha256::new();
    for path in sources()? {
        hash.update(path.to_string_lossy().as_bytes());
        hash.update([0]);
        hash.update(fs::read(home().join(GENERATORS).join(&path))?);
        hash.update([0]);
    }
    Ok(hex(&hash.finalize()))
}

/// SHA-256 of this program: what one build of the diagnosis says is not another's.
///
/// # Errors
/// Those of the file system.
pub fn program() -> Result<String, Failure> {
    static HASH: OnceLock<String> = OnceLock::new();
    if let Some(hash) = HASH.get() {
        return Ok(hash.clone());
    }
    let hash = hex(&Sha256::digest(fs::read(std::env::current_exe()?)?));
    Ok(HASH.get_or_init(|| hash).clone())
}

/// The file as it would be written now.
fn text() -> Result<String, Failure> {
    let cases = table(&plan(Seeds::Score, None));
    let mut text =
        String::from("# The cases of a scoring run; written by `sinew-proof plan`, checked by every scoring run.\n");
    let _ = writeln!(text, "# plan sha256 {}", hex(&Sha256::digest(cases.as_bytes())));
    let _ = writeln!(text, "# generators sha256 {}", generators()?);
    let _ = writeln!(text, "#\n# Mechanisms never used in development:");
    for novel in &NOVEL {
        let _ = writeln!(text, "# - {}: {}", novel.name, novel.equation);
    }
    text += "#\n";
    text += &cases;
    Ok(text)
}

/// Writes the plan with its hashes; says where.
///
/// # Errors
/// Those of the file system.
pub fn write() -> Result<PathBuf, Failure> {
    let path = home().join(FILE);
    fs::write(&path, text()?)?;
    Ok(path)
}

/// The hashes of the committed plan, which is the one that would be made now.
///
/// # Errors
/// There is none, or plan or generators are others: nothing may be scored then.
pub fn check() -> Result<Hashes, Failure> {
    let path = home().join(FILE);
    let committed = fs::read_to_string(&path)
        .map_err(|error| format!("{}: {error}; write it with `sinew-proof plan`", path.display()))?;
    let now = text()?;
    let line = |text: &str, what: &str| {
        let start = format!("# {what} sha256 ");
        text.lines().find_map(|line| line.strip_prefix(&start)).unwrap_or("none").to_string()
    };
    for what in ["plan", "generators"] {
        let (was, is) = (line(&committed, what), line(&now, what));
        if was != is {
            return Err(format!(
                "{}: the {what} were committed with sha256 {was} and are {is} now: what is scored must not change after it was \
                 committed. Take the changes back, or begin anew: `sinew-proof plan`, commit, and score all of it",
                path.display()
            )
            .into());
        }
    }
    if committed != now {
        return Err(format!("{}: was changed by hand; write it with `sinew-proof plan`", path.display()).into());
    }
    Ok(Hashes { plan: line(&now, "plan"), generators: line(&now, "generators") })
}

/// SHA-256 of what was committed before scoring.
#[derive(Debug, Clone, PartialEq)]
pub struct Hashes {
    /// Of the list of cases.
    pub plan: String,
    /// Of the generators' sources.
    pub generators: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_plan_is_the_one_that_would_be_made() {
        let hashes = check().expect("plan and generators as committed");
        assert!(hashes.plan.len() == 64 && hashes.generators.len() == 64 && hashes.plan != hashes.generators);
    }
}
