//! The words of `sinew thesis`.

use std::path::PathBuf;

use clap::Args;
use sinew_thesis::Chapter;

/// `sinew thesis`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew thesis --out book                every chapter: book/index.html
  sinew thesis 3 6 --out book            the model and its heat alone
  sinew thesis 11                        the summary, and nothing written
  sinew thesis --list | grep 'fig. 58'   where the code has it, without running anything
  sinew thesis A --list

A row for each equation, table and simulated or measured figure of the thesis: what it states, what this program
computes, and whether both agree, differ (with the reason proven), cannot be made again because something is not
given, or are not yet built. A row that does not come out as its source declares is a defect: exit code 1.")]
pub struct Thesis {
    /// Which chapters, 2 to 12 or A; without one, all of them.
    #[arg(value_name = "CHAPTER", value_parser = chapter)]
    pub chapters: Vec<Chapter>,
    /// Where the book is written: DIR/index.html; made if it is not there.
    #[arg(long, value_name = "DIR", conflicts_with = "list")]
    pub out: Option<PathBuf>,
    /// List the rows instead of running them.
    #[arg(long)]
    pub list: bool,
    /// Threads; without it, as many as there are processors.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub jobs: Option<u16>,
}

fn chapter(text: &str) -> Result<Chapter, String> {
    Chapter::named(text).ok_or_else(|| {
        let words: Vec<&str> = Chapter::ALL.iter().map(|chapter| chapter.word()).collect();
        format!("the thesis has no rows of such a chapter; there are {}", words.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chapters_are_numbers_or_the_appendix() {
        assert_eq!(chapter("11"), Ok(Chapter::Eleven));
        assert_eq!(chapter("a"), Ok(Chapter::A));
        assert!(chapter("13").unwrap_err().contains("2, 3, 4"));
    }
}
