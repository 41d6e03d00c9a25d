//! Every row comes out as it declares, points at code that is there, and no place of the thesis is missing or there twice.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use sinew_thesis::{Book, Chapter, How, Place, Verdict, apart, markdown, rows, run};

static BOOK: LazyLock<Book> = LazyLock::new(|| run(&Chapter::ALL, &|_| ()));

fn checkout() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every row of a chapter agrees, or differs as it says, within the tolerances that stand in its source.
fn comes_out(chapter: Chapter) {
    let wrong: Vec<String> = BOOK
        .of(chapter)
        .filter(|done| matches!(done.verdict, Verdict::Unexplained(_)))
        .map(|done| format!("{}, {}: {}", done.row.place, done.row.title, done.verdict))
        .collect();
    assert!(wrong.is_empty(), "{chapter}:\n{}", wrong.join("\n"));
}

#[test]
fn chapter_2_comes_out() {
    comes_out(Chapter::Two);
}

#[test]
fn chapter_3_comes_out() {
    comes_out(Chapter::Three);
}

#[test]
fn chapter_4_comes_out() {
    comes_out(Chapter::Four);
}

#[test]
fn chapter_5_comes_out() {
    comes_out(Chapter::Five);
}

#[test]
fn chapter_6_comes_out() {
    comes_out(Chapter::Six);
}

#[test]
fn chapter_7_comes_out() {
    comes_out(Chapter::Seven);
}

#[test]
fn chapter_8_comes_out() {
    comes_out(Chapter::Eight);
}

#[test]
fn chapter_9_comes_out() {
    comes_out(Chapter::Nine);
}

#[test]
fn chapter_10_comes_out() {
    comes_out(Chapter::Ten);
}

#[test]
fn chapter_11_comes_out() {
    comes_out(Chapter::Eleven);
}

#[test]
fn chapter_12_comes_out() {
    comes_out(Chapter::Twelve);
}

#[test]
fn appendix_a_comes_out() {
    comes_out(Chapter::A);
}

#[test]
fn the_code_that_rows_name_is_there() {
    let mut wrong = Vec::new();
    for row in Chapter::ALL.into_iter().flat_map(rows) {
        for code in &row.code {
            let text = std::fs::read_to_string(checkout().join(code.file)).unwrap_or_default();
            if !text.contains(code.item) {
                wrong.push(format!("{}, {}: no {:?} in {}", row.chapter, row.place, code.item, code.file));
            }
        }
        let computed = !matches!(row.how, How::NotGiven(_) | How::NotBuilt(_));
        if computed && row.code.is_empty() {
            wrong.push(format!("{}, {} names no code", row.chapter, row.place));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The places of the thesis by chapter: numbered equations, how many are displayed without a number, figures, tables.
fn places(chapter: Chapter) -> Vec<Place> {
    // numbers from one up to before another: none where both are the same
    let (equations, displayed, figures, tables) = match chapter {
        Chapter::Two => (1..1, 9, 1..8, 2..4),
        Chapter::Three => (1..27, 8, 8..28, 1..1),
        Chapter::Four => (1..1, 0, 28..34, 1..1),
        Chapter::Five => (1..1, 0, 34..56, 4..6),
        Chapter::Six => (27..36, 11, 56..72, 1..1),
        Chapter::Seven => (36..45, 0, 72..81, 6..8),
        Chapter::Eight => (1..1, 0, 81..89, 8..10),
        Chapter::Nine => (45..55, 10, 89..99, 10..11),
        Chapter::Ten => (55..67, 9, 99..107, 1..1),
        Chapter::Eleven => (67..71, 21, 107..114, 1..1),
        Chapter::Twelve => (1..1, 0, 114..120, 11..12),
        Chapter::A => (1..1, 41, 1..1, 1..1),
    };
    let rules = if chapter == Chapter::Two { 1..18 } else { 1..1 };
    let mut all: Vec<Place> = equations.map(Place::Equation).collect();
    all.extend(rules.map(Place::Rule));
    all.extend((1..=displayed).map(Place::Displayed));
    all.extend(figures.map(Place::Figure));
    all.extend(tables.map(Place::Table));
    all
}

#[test]
fn every_place_of_the_thesis_is_there_once() {
    let mut wrong = Vec::new();
    for chapter in Chapter::ALL {
        let mut found: BTreeMap<Place, u32> = BTreeMap::new();
        let of_rows = rows(chapter).into_iter().map(|row| row.place);
        for place in of_rows.chain(apart(chapter).into_iter().map(|one| one.place)) {
            *found.entry(place).or_default() += 1;
        }
        for place in places(chapter) {
            match found.remove(&place) {
                Some(1) => {}
                Some(count) => wrong.push(format!("{chapter}: {place} is there {count} times")),
                None => wrong.push(format!("{chapter}: {place} is missing")),
            }
        }
        wrong.extend(found.keys().map(|place| format!("{chapter}: there is no {place}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A text as its words and its numbers: digits with a point among them are numbers.
fn parts(text: &str) -> (String, Vec<f64>) {
    let (mut words, mut numbers, mut digits) = (String::new(), Vec::new(), String::new());
    for c in text.chars().chain(['\n']) {
        if c.is_ascii_digit() || (c == '.' && !digits.is_empty()) {
            digits.push(c);
            continue;
        }
        match digits.parse() {
            Ok(number) => {
                numbers.push(number);
                words.push('#');
            }
            Err(_) => words.push_str(&digits),
        }
        digits.clear();
        words.push(c);
    }
    (words, numbers)
}

/// Docs/thesis.md has what the code says: the same words, and numbers to 2 %.
#[test]
fn the_page_has_these_rows() {
    let path = checkout().join("docs/thesis.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let (begin, end) = ("<!-- rows -->\n", "<!-- /rows -->");
    let start = page.find(begin).unwrap() + begin.len();
    let stop = start + page[start..].find(end).unwrap();
    let table = markdown(&BOOK);
    if std::env::var_os("SINEW_BLESS").is_some() {
        std::fs::write(&path, format!("{}{table}{}", &page[..start], &page[stop..])).unwrap();
        return;
    }
    for (written, said) in page[start..stop].lines().zip(table.lines()) {
        let ((words, numbers), (wanted, computed)) = (parts(written), parts(said));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 0.02 * b.abs();
        let same = words == wanted && numbers.iter().zip(&computed).all(near);
        assert!(same, "docs/thesis.md: another row; run with SINEW_BLESS=1\n{written}\n{said}");
    }
    assert_eq!(page[start..stop].lines().count(), table.lines().count(), "docs/thesis.md; run with SINEW_BLESS=1");
}
