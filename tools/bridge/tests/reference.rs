//! `docs/bridges.md` prints the metrics.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-bridge --test reference` writes it into the page.

use std::path::Path;

#[test]
fn the_page_carries_the_table_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/bridges.md");
    let mut page = std::fs::read_to_string(&path).unwrap();
    let (open, close) = ("<!-- metrics -->\n", "<!-- /metrics -->");
    let start = page.find(open).unwrap() + open.len();
    let end = start + page[start..].find(close).unwrap();
    let table = sinew_bridge::metric_table_markdown();
    if std::env::var_os("SINEW_BLESS").is_some() {
        page.replace_range(start..end, &table);
        std::fs::write(path, page).unwrap();
    } else {
        assert_eq!(page[start..end], table, "docs/bridges.md: another table; run with SINEW_BLESS=1");
    }
}
