//! `docs/trust.md` prints the table of threads.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-threads --test reference` writes it into the page.

use std::path::Path;

#[test]
fn the_page_carries_the_table_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/trust.md");
    let mut page = std::fs::read_to_string(&path).unwrap();
    let (open, close) = ("<!-- threads -->\n", "<!-- /threads -->");
    let start = page.find(open).unwrap() + open.len();
    let end = start + page[start..].find(close).unwrap();
    let table = sinew_threads::table_markdown();
    if std::env::var_os("SINEW_BLESS").is_some() {
        page.replace_range(start..end, &table);
        std::fs::write(path, page).unwrap();
    } else {
        assert_eq!(page[start..end], table, "docs/trust.md: another table; run with SINEW_BLESS=1");
    }
}
