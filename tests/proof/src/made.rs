//! A case of the plan, by the generator it belongs to, in a folder of its own.

use std::fs;
use std::path::Path;

use sinew_concealed::generator::case::{self, Answer, Case};
use sinew_concealed::generator::plan::Spec;
use sinew_concealed::second;

use crate::failure::Failure;
use crate::frozen;

/// Hash of the generators that made the case.
const MADE_BY: &str = "made_by.txt";

/// Makes it.
pub fn make(spec: &Spec) -> Case {
    if spec.second { second::case::make(spec) } else { case::make(spec) }
}

/// Makes it and leaves it in `folder`; that it is whole is written there last.
///
/// # Errors
/// Those of the file system.
pub fn write(spec: &Spec, folder: &Path) -> Result<Answer, Failure> {
    let made_by = folder.join(MADE_BY);
    if made_by.exists() {
        fs::remove_file(&made_by)?;
    }
    let case = make(spec);
    case.write(folder)?;
    fs::write(made_by, frozen::generators()? + "\n")?;
    Ok(case.answer)
}

/// The answer of this very case where `folder` has it already, from the present generators.
///
/// # Errors
/// A file that is there and cannot be read.
pub fn found(spec: &Spec, folder: &Path) -> Result<Option<Answer>, Failure> {
    let made_by = folder.join(MADE_BY);
    if !made_by.exists() || fs::read_to_string(made_by)?.trim() != frozen::generators()? {
        return Ok(None);
    }
    let answer: Answer = serde_json::from_slice(&fs::read(folder.join("answer.json"))?)?;
    let same = answer.seed == spec.seed && answer.generator == 1 + u8::from(spec.second);
    Ok(same.then_some(answer))
}
