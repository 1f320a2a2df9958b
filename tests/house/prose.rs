//! Documentation as text: its lines, its words, its code blocks.

use crate::source::{LineKind, Source};

/// A fenced block of a page.
#[derive(Debug, PartialEq)]
pub struct Block {
    pub line: usize,
    /// What is after the opening fence: `no_run`, `text`, nothing.
    pub info: String,
}

impl Block {
    /// Rust that `cargo test` compiles.
    pub fn is_compiled(&self) -> bool {
        const RUST: [&str; 5] = ["", "rust", "no_run", "should_panic", "compile_fail"];
        let mut parts = self.info.split(',').map(str::trim);
        parts.all(|part| RUST.contains(&part) || part.starts_with("edition"))
    }

    /// Rust that `cargo test` runs.
    pub fn is_run(&self) -> bool {
        self.is_compiled() && !self.info.contains("no_run") && !self.info.contains("compile_fail")
    }
}

/// Documentation of a file outside tests: number of the line, text without the comment's marks.
pub fn documentation(source: &Source) -> Vec<(usize, &str)> {
    source.lines_of(LineKind::Doc).map(|(line, text)| (line, unmarked(text))).collect()
}

/// The page at the top of a file: its `//!` lines.
pub fn front_page(source: &Source) -> Vec<(usize, &str)> {
    let is_of_page = |(_, line): &(usize, &crate::source::Line)| line.text.trim_start().starts_with("//!");
    let page = source.lines.iter().enumerate().skip_while(|line| !is_of_page(line)).take_while(is_of_page);
    page.map(|(place, line)| (place + 1, unmarked(&line.text))).collect()
}

fn unmarked(text: &str) -> &str {
    let text = text.trim();
    let marks = ["///", "//!", "/**", "/*!", "* "];
    let text = marks.iter().find_map(|mark| text.strip_prefix(mark)).unwrap_or(text);
    text.strip_prefix(' ').unwrap_or(text)
}

/// Every fenced block, in order.
pub fn blocks(lines: &[(usize, &str)]) -> Vec<Block> {
    let mut found = Vec::new();
    let mut is_open = false;
    for (line, text) in lines {
        if let Some(info) = text.trim_start().strip_prefix("```") {
            if !is_open {
                found.push(Block { line: *line, info: info.trim().to_owned() });
            }
            is_open = !is_open;
        }
    }
    found
}

/// A word in lower case with its line; `None` is a break that no phrase reaches across.
pub type Word = Option<(String, usize)>;

/// Words outside code, through the ends of lines. Marks of punctuation, blank lines and gaps
/// between comments are breaks.
pub fn words(lines: &[(usize, &str)]) -> Vec<Word> {
    let mut words = Vec::new();
    let (mut is_block, mut is_code, mut last) = (false, false, 0);
    for (line, text) in lines {
        if *line != last + 1 || text.trim().is_empty() {
            words.push(None);
            is_code = false;
        }
        last = *line;
        if text.trim_start().starts_with("```") {
            is_block = !is_block;
            words.push(None);
            continue;
        }
        if is_block {
            continue;
        }
        for (place, part) in text.split('`').enumerate() {
            is_code ^= place > 0;
            if is_code {
                words.push(None);
            } else {
                prose(part, *line, &mut words);
            }
        }
    }
    words
}

fn prose(text: &str, line: usize, words: &mut Vec<Word>) {
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_' || c == '\'';
    let mut word = String::new();
    for c in text.chars().chain([' ']) {
        if is_of_word(c) {
            word.extend(c.to_lowercase());
            continue;
        }
        if !word.is_empty() {
            words.push(Some((std::mem::take(&mut word), line)));
        }
        if !c.is_whitespace() && c != '-' && c != '*' {
            words.push(None);
        }
    }
}

#[test]
fn words_go_on_through_lines_and_end_at_marks_and_code() {
    let text = "/// The plant's numbers are\n/// Left-out. *None* `told in code` is\n///\n/// so\n/// ```text\n/// told\n/// ```\nfn f() {}\n";
    let source = Source::parse("a.rs", 0, text);
    let lines = documentation(&source);
    let shown: Vec<String> = words(&lines)
        .iter()
        .map(|word| word.as_ref().map_or("|".to_owned(), |(word, line)| format!("{word}{line}")))
        .collect();
    let shown = shown.join(" ");
    assert_eq!(shown, "the1 plant's1 numbers1 are1 left2 out2 | none2 | is2 | so4 | |");
    assert_eq!(blocks(&lines), [Block { line: 5, info: "text".to_owned() }]);
}

#[test]
fn blocks_that_run_are_known_from_those_that_do_not() {
    let of = |info: &str| Block { line: 1, info: info.to_owned() };
    assert!(["", "rust", "should_panic", "edition2024"].iter().all(|info| of(info).is_run()));
    assert!(["no_run", "rust,no_run", "compile_fail"].iter().all(|info| of(info).is_compiled() && !of(info).is_run()));
    assert!(["text", "toml", "ignore", "rust,ignore", "sh"].iter().all(|info| !of(info).is_compiled()));
}
