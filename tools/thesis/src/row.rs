//! A row of the book: where the thesis has it, where the code has it, what is stated, and how it is judged.

use std::fmt;

use crate::chapter::{Chapter, Place};
use crate::found::{Found, Tried};
use crate::lab::Lab;

/// How computing a row ends.
pub type Computed = Tried<()>;

/// Computes what a row compares, by the project's own code.
pub type Compute = fn(&Lab, &mut Found) -> Computed;

/// A place in the code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// The file, from the checkout's root.
    pub file: &'static str,
    /// Words that stand in it: the item that is meant.
    pub item: &'static str,
}

/// What is done with a row.
#[derive(Debug, Clone, Copy)]
pub enum How {
    /// It is computed and agrees.
    Computed(Compute),
    /// It is computed and differs, for this reason, which the row proves as well.
    Differs(&'static str, Compute),
    /// It cannot be made again: this is not given.
    NotGiven(&'static str),
    /// There is no code for it yet: this is missing.
    NotBuilt(&'static str),
}

/// A row of the book.
#[derive(Debug, Clone)]
pub struct Row {
    /// The chapter.
    pub chapter: Chapter,
    /// What the thesis calls it.
    pub place: Place,
    /// What it is.
    pub title: &'static str,
    /// Where the code has it.
    pub code: Vec<Code>,
    /// What the thesis states about it, in our words.
    pub states: &'static str,
    /// What is done with it.
    pub how: How,
}

impl Row {
    /// A row that has yet to say where the code has it and how it is judged.
    pub(crate) fn new(chapter: Chapter, place: Place, title: &'static str, states: &'static str) -> Row {
        let how = How::NotBuilt("the row says nothing yet");
        Row { chapter, place, title, code: Vec::new(), states, how }
    }

    /// Where the code has it.
    pub(crate) fn code(mut self, file: &'static str, item: &'static str) -> Row {
        self.code.push(Code { file, item });
        self
    }

    /// It agrees, by these numbers.
    pub(crate) fn agrees(self, compute: Compute) -> Row {
        Row { how: How::Computed(compute), ..self }
    }

    /// It differs, by these numbers and for this reason.
    pub(crate) fn differs(self, because: &'static str, compute: Compute) -> Row {
        Row { how: How::Differs(because, compute), ..self }
    }

    /// It cannot be made again, because this is not given.
    pub(crate) fn not_given(self, what: &'static str) -> Row {
        Row { how: How::NotGiven(what), ..self }
    }

    /// It is not there yet.
    pub(crate) fn not_built(self, what: &'static str) -> Row {
        Row { how: How::NotBuilt(what), ..self }
    }

    /// Computes and judges it.
    pub fn run(self, lab: &Lab) -> Done {
        let mut found = Found::default();
        let ran = match self.how {
            How::Computed(compute) | How::Differs(_, compute) => compute(lab, &mut found),
            How::NotGiven(_) | How::NotBuilt(_) => Ok(()),
        };
        let verdict = judge(self.how, ran, &found);
        Done { row: self, found, verdict }
    }
}

/// What a row comes to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Everything stated came out, within the tolerances declared.
    Agrees,
    /// Something stated did not come out, and why is proven.
    Differs(&'static str),
    /// It cannot be made again: this is not given.
    NotGiven(&'static str),
    /// There is no code for it yet: this is missing.
    NotBuilt(&'static str),
    /// It did not come out as its row declares: a defect of the book or of the code.
    Unexplained(String),
}

impl Verdict {
    /// The word for it.
    pub fn word(&self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::Differs(_) => "differs",
            Verdict::NotGiven(_) => "not reproducible",
            Verdict::NotBuilt(_) => "not yet built",
            Verdict::Unexplained(_) => "unexplained",
        }
    }

    /// What goes with the word.
    pub fn reason(&self) -> Option<&str> {
        match self {
            Verdict::Agrees => None,
            Verdict::Differs(reason) | Verdict::NotGiven(reason) | Verdict::NotBuilt(reason) => Some(reason),
            Verdict::Unexplained(reason) => Some(reason),
        }
    }

    /// Its class in the page.
    pub(crate) fn class(&self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::Differs(_) => "differs",
            Verdict::NotGiven(_) => "not_given",
            Verdict::NotBuilt(_) => "not_built",
            Verdict::Unexplained(_) => "unexplained",
        }
    }

    /// Every word, in the order the summary has them.
    pub const WORDS: [&'static str; 5] = ["agrees", "differs", "not reproducible", "not yet built", "unexplained"];
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, self.reason()) {
            (Verdict::Differs(_), Some(reason)) => write!(f, "differs because {reason}"),
            (_, Some(reason)) => write!(f, "{}: {reason}", self.word()),
            (_, None) => f.write_str(self.word()),
        }
    }
}

/// A row with what came out of it.
#[derive(Debug, Clone)]
pub struct Done {
    /// The row.
    pub row: Row,
    /// What came out.
    pub found: Found,
    /// What it comes to.
    pub verdict: Verdict,
}

fn judge(how: How, ran: Computed, found: &Found) -> Verdict {
    let because = match how {
        How::Computed(_) => None,
        How::Differs(because, _) => Some(because),
        How::NotGiven(what) => return Verdict::NotGiven(what),
        How::NotBuilt(what) => return Verdict::NotBuilt(what),
    };
    if let Err(error) = ran {
        return Verdict::Unexplained(format!("it cannot be computed: {error}"));
    }
    let fails = |proof: bool| -> Vec<String> {
        let of_kind = found.checks.iter().filter(|check| check.proof == proof && !check.holds());
        of_kind.map(|check| format!("{}: {} where {} is wanted", check.what, check.value(), check.demand())).collect()
    };
    let (stated, proofs) = (fails(false), fails(true));
    match because {
        _ if found.checks.iter().all(|check| check.proof) => Verdict::Unexplained("nothing is compared".into()),
        _ if !proofs.is_empty() => Verdict::Unexplained(format!("the proof fails: {}", proofs.join("; "))),
        None if stated.is_empty() => Verdict::Agrees,
        None => Verdict::Unexplained(stated.join("; ")),
        Some(_) if stated.is_empty() => Verdict::Unexplained("declared to differ, and agrees".into()),
        Some(because) => Verdict::Differs(because),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row that finds this number where 1 ± 0.1 is stated.
    fn near_one<const HUNDREDTHS: u32>(_: &Lab, found: &mut Found) -> Computed {
        found.near("x", "1", 1.0, 0.1, f64::from(HUNDREDTHS) / 100.0);
        Ok(())
    }

    fn verdict(row: impl FnOnce(Row) -> Row) -> Verdict {
        let blank = Row::new(Chapter::Two, Place::Displayed(1), "", "");
        row(blank).run(&Lab::empty()).verdict
    }

    #[test]
    fn a_row_agrees_only_where_a_number_does() {
        assert_eq!(verdict(|row| row.agrees(near_one::<105>)), Verdict::Agrees);
        for compute in [
            (|_, _| Ok(())) as Compute,
            near_one::<120>,
            |_, found| {
                found.near("x", "1", 1.0, 0.1, f64::NAN);
                Ok(())
            },
            |_, found| {
                found.near("x", "1", 1.0, 0.1, 1.0);
                Err("it broke".into())
            },
        ] {
            assert!(matches!(verdict(|row| row.agrees(compute)), Verdict::Unexplained(_)));
        }
    }

    #[test]
    fn a_row_differs_only_where_a_number_does_and_the_reason_is_proven() {
        let differs = |compute: Compute| verdict(|row| row.differs("so it is", compute));
        let proven: Compute = |_, found| {
            found.near("x", "1", 1.0, 0.1, 2.0);
            found.proof();
            found.near("y", "1", 2.0, 0.1, 2.0);
            Ok(())
        };
        assert_eq!(differs(proven), Verdict::Differs("so it is"));
        let unproven: Compute = |_, found| {
            found.near("x", "1", 1.0, 0.1, 2.0);
            found.proof();
            found.near("y", "1", 2.0, 0.1, 3.0);
            Ok(())
        };
        assert!(matches!(differs(unproven), Verdict::Unexplained(_)));
        assert!(matches!(differs(near_one::<100>), Verdict::Unexplained(_)));
    }
}
