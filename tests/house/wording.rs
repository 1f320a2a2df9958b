//! Words that are not the field's, in documentation and in the pages for users.
//!
//! `old_words.txt` has one phrase a line with a better one after a tab. A phrase is found word by
//! word, through the ends of lines, and not inside code. Where two phrases begin at one word the
//! longer counts; `ok` after the tab says that it is in order (`told apart`, but not `told`).

use crate::house::House;
use crate::prose::{Word, documentation, words};

/// Quotations and slips.
pub const OCCURRENCES_MAX: usize = 20;
const LIST: &str = include_str!("old_words.txt");
const IN_ORDER: &str = "ok";

struct Phrase<'a> {
    words: Vec<&'a str>,
    better: &'a str,
}

/// `path:line "phrase": better`.
pub fn measure(house: &House) -> Vec<String> {
    found_in(house, &phrases(LIST))
}

fn phrases(list: &str) -> Vec<Phrase<'_>> {
    let lines = list.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let parts = lines.map(|line| line.split_once('\t').unwrap_or_else(|| panic!("no tab in \"{line}\"")));
    let mut all: Vec<Phrase<'_>> =
        parts.map(|(words, better)| Phrase { words: words.split([' ', '-']).collect(), better }).collect();
    all.sort_by_key(|phrase| std::cmp::Reverse(phrase.words.len()));
    all
}

fn found_in(house: &House, phrases: &[Phrase<'_>]) -> Vec<String> {
    let mut found = Vec::new();
    for (_, source) in house.own_sources() {
        search(&source.path, &words(&documentation(source)), phrases, &mut found);
    }
    for (path, text) in &house.pages {
        if path.ends_with("README.md") || path.ends_with("CHANGELOG.md") {
            let lines: Vec<(usize, &str)> = text.lines().enumerate().map(|(place, line)| (place + 1, line)).collect();
            search(path, &words(&lines), phrases, &mut found);
        }
    }
    found
}

fn search(path: &str, words: &[Word], phrases: &[Phrase<'_>], found: &mut Vec<String>) {
    let mut place = 0;
    while place < words.len() {
        let begins = |phrase: &&Phrase<'_>| {
            let here = words[place..].iter().take(phrase.words.len());
            let same =
                here.zip(&phrase.words).filter(|(word, own)| word.as_ref().is_some_and(|(word, _)| word == *own));
            same.count() == phrase.words.len()
        };
        let Some(phrase) = phrases.iter().find(begins) else {
            place += 1;
            continue;
        };
        if phrase.better != IN_ORDER {
            let line = words[place].as_ref().map_or(0, |(_, line)| *line);
            found.push(format!("{path}:{line} \"{}\": {}", phrase.words.join(" "), phrase.better));
        }
        place += phrase.words.len();
    }
}

#[test]
fn documents_speak_the_language_of_the_field() {
    let found = &crate::findings().wording;
    assert!(
        found.len() < OCCURRENCES_MAX,
        "{}\n{} occurrences. Cure: the word after the colon, or a sentence built anew.",
        found.join("\n"),
        found.len()
    );
}

#[test]
fn a_phrase_is_found_across_lines_and_a_longer_one_that_is_in_order_is_not() {
    let list = phrases("# list\n\nborne out\tconfirmed\ntold\treported\ntold apart\tok\n");
    let tree = crate::tree::Tree::of(&[
        ("shared/a/Cargo.toml", "[package]\nname = \"a\""),
        (
            "shared/a/src/lib.rs",
            "//! Is borne\n//! out, told apart, `told`.\n// told\nfn f() {}\n/// Borne. Out\nfn g() {}",
        ),
        ("README.md", "It is Told.\n"),
        ("shared/a/NOTES.md", "told\n"),
    ]);
    let expected = ["shared/a/src/lib.rs:1 \"borne out\": confirmed", "README.md:1 \"told\": reported"];
    assert_eq!(found_in(&House::of(&tree), &list), expected);
}

#[test]
fn the_list_says_each_phrase_once_in_lower_case() {
    let mut all: Vec<String> = phrases(LIST).iter().map(|phrase| phrase.words.join(" ")).collect();
    assert!(all.len() > 50 && all.iter().all(|phrase| *phrase == phrase.to_lowercase()));
    all.sort();
    let twice: Vec<_> = all.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| &pair[0]).collect();
    assert!(twice.is_empty(), "{twice:?}");
}
