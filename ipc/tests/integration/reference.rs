//! `docs/client.md` prints the tables of the code: the published fields of a channel, and the faults.
//!
//! `SINEW_BLESS=1 cargo test -p sinew-ipc --test integration reference::` writes them into the page.

use std::path::Path;

#[test]
fn the_page_carries_the_tables_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/client.md");
    let mut page = std::fs::read_to_string(&path).unwrap();
    let bless = std::env::var_os("SINEW_BLESS").is_some();
    for (mark, table) in [("fields", sinew_ipc::field_table_markdown()), ("faults", sinew_ipc::fault_table_markdown())]
    {
        let (open, close) = (format!("<!-- {mark} -->\n"), format!("<!-- /{mark} -->"));
        let start = page.find(&open).expect(mark) + open.len();
        let end = start + page[start..].find(&close).expect(mark);
        if bless {
            page.replace_range(start..end, &table);
        }
        assert!(
            bless || page[start..end] == table,
            "docs/client.md: the {mark} are not those of the code; run with SINEW_BLESS=1"
        );
    }
    if bless {
        std::fs::write(path, page).unwrap();
    }
}
