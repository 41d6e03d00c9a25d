//! A page of Markdown as its reader has it: its blocks in order, its links, its headings.

/// A fenced block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Block {
    /// Line of its opening fence, from 1 on.
    pub line: usize,
    /// The first word after the fence: what it is written in.
    pub language: String,
    /// The other words after the fence, which no reader is shown.
    pub words: Vec<String>,
    /// What stands in it.
    pub text: String,
}

impl Block {
    /// Whether this word stands after the fence.
    pub fn is(&self, word: &str) -> bool {
        self.words.iter().any(|there| there == word)
    }

    /// What stands after `KEY=`.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.words.iter().find_map(|word| word.strip_prefix(key)?.strip_prefix('='))
    }
}

/// The fenced blocks of a page.
///
/// # Panics
/// When the last one is not closed.
pub fn blocks(page: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(info) = line.trim_start().strip_prefix("```") else { continue };
        let indent = line.len() - line.trim_start().len();
        let mut words = info.split([' ', ',']).filter(|word| !word.is_empty()).map(str::to_owned);
        let language = words.next().unwrap_or_default();
        let mut text = String::new();
        loop {
            let (_, line) =
                lines.next().unwrap_or_else(|| panic!("the block from line {} on is not closed", number + 1));
            if line.trim() == "```" {
                break;
            }
            // in a list a block is indented as its fence is
            text += line.get(indent..).unwrap_or_else(|| line.trim_start());
            text.push('\n');
        }
        found.push(Block { line: number + 1, language, words: words.collect(), text });
    }
    found
}

/// The page without its blocks and without `code`: what may hold a link.
fn prose(page: &str) -> String {
    let mut is_in_block = false;
    let mut prose = String::new();
    for line in page.lines() {
        let is_fence = line.trim_start().starts_with("```");
        is_in_block ^= is_fence;
        if !is_in_block && !is_fence {
            prose.extend(line.split('`').step_by(2));
        }
        prose.push('\n');
    }
    prose
}

/// Where the links and pictures of a page lead, in order, each with its line.
pub fn links(page: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (number, line) in prose(page).lines().enumerate() {
        for rest in line.split("](").skip(1) {
            if let Some((target, _)) = rest.split_once(')') {
                found.push((number + 1, target.trim().to_owned()));
            }
        }
    }
    found
}

/// What may follow `#` in a link to this page: its headings as repository pages and mdBook name them.
pub fn anchors(page: &str) -> Vec<String> {
    let mut is_in_block = false;
    let mut found: Vec<String> = Vec::new();
    for line in page.lines() {
        is_in_block ^= line.trim_start().starts_with("```");
        let heading = line.trim_start_matches('#');
        if is_in_block || heading.len() == line.len() || !heading.starts_with(' ') {
            continue;
        }
        let mut anchor = String::new();
        for letter in heading.trim().to_lowercase().chars() {
            match letter {
                ' ' => anchor.push('-'),
                '-' | '_' => anchor.push(letter),
                letter if letter.is_alphanumeric() => anchor.push(letter),
                _ => {}
            }
        }
        found.push(anchor);
    }
    found
}
