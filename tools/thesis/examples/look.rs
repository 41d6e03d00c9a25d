//! Looks.
use sinew_thesis::*;
fn main() {
    let chapters: Vec<Chapter> = std::env::args().skip(1).filter_map(|w| Chapter::named(&w)).collect();
    let book = run(&chapters, &|_| ());
    for done in &book.done {
        println!("{} {} — {}\n    {}", done.row.chapter, done.row.place, done.row.title, done.verdict);
        for c in &done.found.checks {
            println!(
                "      {} {}{}: {}  [{}]",
                if c.holds() { "ok " } else { "NO " },
                if c.proof { "(proof) " } else { "" },
                c.what,
                c.found,
                c.demand()
            );
        }
    }
    println!("{}", summary(&book));
}
