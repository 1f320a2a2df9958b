//! The workspace as it is measured: its crates, their parsed files, their modules, its pages.

use crate::manifest::{Crate, crates};
use crate::modules::Modules;
use crate::source::Source;
use crate::tree::Tree;
use std::path::PathBuf;

/// A parsed workspace.
pub struct House {
    pub crates: Vec<Crate>,
    /// Every Rust file of every crate, in the order of paths.
    pub sources: Vec<Source>,
    pub modules: Modules,
    /// Markdown by path.
    pub pages: Vec<(String, String)>,
}

impl House {
    /// Parses a tree and finds out which of its files are test code.
    pub fn of(tree: &Tree) -> Self {
        let crates = crates(tree);
        let mut sources = Vec::new();
        for (path, text) in tree.files().filter(|(path, _)| path.ends_with(".rs")) {
            let is_of = |krate: &Crate| path.strip_prefix(&krate.folder).is_some_and(|rest| rest.starts_with('/'));
            if let Some(krate) = crates.iter().position(is_of) {
                sources.push(Source::parse(path, krate, text));
            }
        }
        let modules = Modules::of(&crates, &sources);
        for (file, source) in sources.iter_mut().enumerate() {
            let inside = source.path.strip_prefix(&crates[source.krate].folder).unwrap();
            if !inside.starts_with("/src/") || is_test_path(inside) || modules.test_files.contains(&file) {
                source.mark_as_test();
            }
        }
        let pages = tree.files().filter(|(path, _)| path.ends_with(".md"));
        let pages = pages.map(|(path, text)| (path.to_owned(), text.to_owned())).collect();
        Self { crates, sources, modules, pages }
    }

    /// One crate `shared/trial`, for self-tests: paths of `files` are relative to it.
    #[cfg(test)]
    pub fn trial(files: &[(&str, &str)]) -> Self {
        let mut all = vec![("shared/trial/Cargo.toml".to_owned(), "[package]\nname = \"trial\"".to_owned())];
        all.extend(files.iter().map(|(path, text)| (format!("shared/trial/{path}"), (*text).to_owned())));
        let all: Vec<_> = all.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
        Self::of(&Tree::of(&all))
    }

    /// Files outside test code, of crates that the laws hold for.
    pub fn own_sources(&self) -> impl Iterator<Item = (usize, &Source)> {
        let own = |(_, source): &(usize, &Source)| !source.is_test && self.crates[source.krate].is_member();
        self.sources.iter().enumerate().filter(own)
    }

    /// Crates that the laws hold for, with their index.
    pub fn members(&self) -> impl Iterator<Item = (usize, &Crate)> {
        self.crates.iter().enumerate().filter(|(_, krate)| krate.is_member())
    }

    /// All files of a crate, test code included.
    pub fn sources_of(&self, krate: usize) -> impl Iterator<Item = &Source> {
        self.sources.iter().filter(move |source| source.krate == krate)
    }
}

fn is_test_path(path: &str) -> bool {
    path.ends_with("/tests.rs") || path.contains("/tests/")
}

/// The workspace to measure: `OBSID_HOUSE`, or the one that this test belongs to.
pub fn root() -> PathBuf {
    let own = || PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    std::env::var_os("OBSID_HOUSE").map_or_else(own, PathBuf::from)
}

#[test]
fn test_code_is_known_by_its_declaration_and_by_its_path() {
    let house = House::trial(&[
        ("src/lib.rs", "mod a; #[cfg(test)] mod synthetic; #[cfg(test)] mod both;"),
        ("src/a.rs", "#[path = \"both.rs\"] mod both; #[cfg(test)] mod tests;"),
        ("src/a/tests.rs", "mod inner;"),
        ("src/a/tests/inner.rs", ""),
        ("src/synthetic.rs", "mod below;"),
        ("src/synthetic/below.rs", ""),
        ("src/both.rs", ""),
        ("tests/outside.rs", ""),
        ("examples/shown.rs", ""),
    ]);
    let own: Vec<&str> = house.own_sources().map(|(_, source)| source.path.rsplit_once("src/").unwrap().1).collect();
    assert_eq!(own, ["a.rs", "both.rs", "lib.rs"]);
}
