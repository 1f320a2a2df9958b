//! The front page of every crate: what it is, what it may import, and an example that runs.

use crate::house::House;
use crate::manifest::Crate;
use crate::prose::{blocks, documentation, front_page};
use crate::source::Source;

/// What a page says, in any case of letters.
const SAYS: [&str; 3] = ["What it is", "May import", "Must never know"];

/// What the front pages lack, and the examples in all documentation.
pub struct Pages {
    pub crates: usize,
    /// `path: what is missing` of every crate without a complete page.
    pub incomplete: Vec<String>,
    /// Code blocks of libraries that `cargo test` compiles.
    pub doc_tests: usize,
}

/// Reads the page of `src/lib.rs`, or of `src/main.rs` where there is no library.
pub fn measure(house: &House) -> Pages {
    let mut pages = Pages { crates: 0, incomplete: Vec::new(), doc_tests: 0 };
    for (index, krate) in house.members() {
        pages.crates += 1;
        let src = |name: &str| format!("{}/src/{name}", krate.folder);
        let page = [src("lib.rs"), src("main.rs")];
        let page = page.iter().find_map(|path| house.sources.iter().find(|source| source.path == *path));
        let missing = page.map_or(vec!["src/lib.rs"], |page| missing(krate, page));
        if !missing.is_empty() {
            let path = page.map_or(krate.folder.as_str(), |page| page.path.as_str());
            pages.incomplete.push(format!("{path}: {}", missing.join(", ")));
        }
        if krate.runs_doc_tests && house.modules.libraries.contains_key(&index) {
            let own = house.sources_of(index).filter(|source| !source.is_test && source.path != src("main.rs"));
            let compiled = own.flat_map(|source| blocks(&documentation(source))).filter(|block| block.is_compiled());
            pages.doc_tests += compiled.count();
        }
    }
    pages
}

fn missing(krate: &Crate, source: &Source) -> Vec<&'static str> {
    let page = front_page(source);
    let text: Vec<String> = page.iter().map(|(_, text)| text.to_lowercase()).collect();
    let mut missing: Vec<&str> =
        SAYS.into_iter().filter(|says| !text.iter().any(|line| line.contains(&says.to_lowercase()))).collect();
    let blocks = blocks(&page);
    // A service needs shared memory or a terminal to run: its example may be compiled only.
    let is_example = |block: &crate::prose::Block| {
        if krate.is_library_of_the_workspace() { block.is_run() } else { block.is_compiled() }
    };
    if !blocks.iter().any(is_example) {
        missing.push("an example in Rust");
    } else if !krate.runs_doc_tests {
        missing.push("an example that runs (doctest = false in Cargo.toml)");
    }
    missing
}

#[test]
fn every_crate_says_what_it_is_what_it_may_import_and_shows_an_example_that_runs() {
    let pages = &crate::findings().pages;
    assert!(pages.crates > 0);
    assert!(
        pages.incomplete.is_empty(),
        "{}\nCure: add to the page at the top of the file what is missing.",
        pages.incomplete.join("\n")
    );
}

#[test]
fn a_page_without_an_example_or_a_sentence_is_seen() {
    let says = "//! What it is: a. May import: b.\n//! must never know: c.\n";
    let page = |block: &str| format!("{says}//! ```{block}\n//! f();\n//! ```\npub fn f() {{}}\n");
    let of = |folder: &str, lib: &str, manifest: &str| {
        let manifest = format!("[package]\nname = \"a\"\n{manifest}");
        let [cargo, path] = ["Cargo.toml", "src/lib.rs"].map(|name| format!("{folder}/a/{name}"));
        let pages = measure(&House::of(&crate::tree::Tree::of(&[(&cargo, &manifest), (&path, lib)])));
        (pages.incomplete.join("; "), pages.doc_tests)
    };
    assert_eq!(of("shared", &page(""), ""), (String::new(), 1));
    assert_eq!(of("services", &page("no_run"), ""), (String::new(), 1));
    assert_eq!(of("shared", &page("no_run"), ""), ("shared/a/src/lib.rs: an example in Rust".to_owned(), 1));
    assert_eq!(of("services", &page("text"), ""), ("services/a/src/lib.rs: an example in Rust".to_owned(), 0));
    let (switched_off, run) = of("shared", &page(""), "[lib]\ndoctest = false");
    assert!(switched_off.contains("doctest = false") && run == 0, "{switched_off}");
    let (bare, _) = of("shared", "//! A crate.\n", "");
    assert_eq!(bare, "shared/a/src/lib.rs: What it is, May import, Must never know, an example in Rust");
}
