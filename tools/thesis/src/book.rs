//! The whole book: every row, run in parallel, and how many come to what.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::chapter::{Chapter, Place};
use crate::chapters;
use crate::lab::Lab;
use crate::row::{Done, Row, Verdict};

/// A photograph, a drawing or a diagram: nothing in it could agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Apart {
    /// The chapter.
    pub chapter: Chapter,
    /// What the thesis calls it.
    pub place: Place,
    /// What it shows.
    pub shows: &'static str,
}

/// Every row of a chapter.
pub fn rows(chapter: Chapter) -> Vec<Row> {
    match chapter {
        Chapter::Two => chapters::two::rows(),
        Chapter::Three => chapters::three::rows(),
        Chapter::Four => chapters::four::rows(),
        Chapter::Five => chapters::five::rows(),
        Chapter::Six => chapters::six::rows(),
        Chapter::Seven => chapters::seven::rows(),
        Chapter::Eight => chapters::eight::rows(),
        Chapter::Nine => chapters::nine::rows(),
        Chapter::Ten => chapters::ten::rows(),
        Chapter::Eleven => chapters::eleven::rows(),
        Chapter::Twelve => chapters::twelve::rows(),
        Chapter::A => chapters::appendix::rows(),
    }
}

/// The photographs, drawings and diagrams of a chapter.
pub fn apart(chapter: Chapter) -> Vec<Apart> {
    let of = |(number, shows): &(u8, &'static str)| Apart { chapter, place: Place::Figure(*number), shows };
    chapters::apart::figures(chapter).iter().map(of).collect()
}

/// Chapters that were run.
#[derive(Debug, Clone)]
pub struct Book {
    /// The chapters, in order.
    pub chapters: Vec<Chapter>,
    /// Their rows, in order.
    pub done: Vec<Done>,
}

/// Runs chapters, in the thesis' order whatever theirs; on as many threads as the caller's pool of rayon has. `done` gets the
/// share of the work that is, 0 to 1.
pub fn run(chapters: &[Chapter], done: &(dyn Fn(f64) + Sync)) -> Book {
    let chapters: Vec<Chapter> = chapters.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let lab = Lab::of(&chapters);
    let rows: Vec<Row> = chapters.iter().copied().flat_map(rows).collect();
    let (all, count) = (rows.len(), AtomicUsize::new(0));
    // one at a time: some take a thousand times as long as others
    let ran = rows.into_par_iter().with_max_len(1).map(|row| {
        let ran = row.run(&lab);
        done((count.fetch_add(1, Ordering::Relaxed) + 1) as f64 / all as f64);
        ran
    });
    Book { done: ran.collect(), chapters }
}

impl Book {
    /// The rows of a chapter.
    pub fn of(&self, chapter: Chapter) -> impl Iterator<Item = &Done> {
        self.done.iter().filter(move |done| done.row.chapter == chapter)
    }

    /// How many rows of a chapter, or of all, come to each of [`Verdict::WORDS`].
    pub fn counts(&self, chapter: Option<Chapter>) -> [usize; Verdict::WORDS.len()] {
        let of = |done: &&Done| chapter.is_none_or(|chapter| done.row.chapter == chapter);
        Verdict::WORDS.map(|word| self.done.iter().filter(of).filter(|done| done.verdict.word() == word).count())
    }
}
