//! One row of `sinew doctor`: requirement, finding, cost if missing, command that fixes it.

use serde::Serialize;

/// How a check came out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Verdict {
    /// As it should be.
    Good,
    /// Works without, but not as well.
    Advice,
    /// Real time or the rig suffers.
    Lacking,
}

/// One thing looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Check {
    /// Short name, stable for programs.
    pub id: &'static str,
    pub verdict: Verdict,
    /// What is wanted.
    pub wanted: String,
    /// What was found.
    pub found: String,
    /// What it costs to do without; empty when good.
    pub cost: String,
    /// What to type or to change; empty when good.
    pub remedy: String,
}

/// A check that is good, or else of the given verdict with its cost and remedy.
pub(super) fn check(
    id: &'static str,
    wanted: &str,
    found: String,
    otherwise: Option<(Verdict, &str, String)>,
) -> Check {
    let wanted = wanted.to_string();
    match otherwise {
        None => Check { id, verdict: Verdict::Good, wanted, found, cost: String::new(), remedy: String::new() },
        Some((verdict, cost, remedy)) => Check { id, verdict, wanted, found, cost: cost.into(), remedy },
    }
}
