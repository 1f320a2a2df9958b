//! What a crate's `Cargo.toml` says of it: its name in code and what it depends on.

use crate::tree::Tree;
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// One package of the workspace.
pub struct Crate {
    /// Relative to the workspace: `shared/estimation`; `tests` is the root package.
    pub folder: String,
    pub package: String,
    /// Name of the library in `use` declarations of others.
    pub library: String,
    /// Code blocks of its documentation are compiled and run.
    pub runs_doc_tests: bool,
    /// Packages it links: build dependencies are among them, those of its tests are not.
    pub normal: BTreeSet<String>,
    /// Every dependency, those of its tests too: name in code and name of the package.
    pub named: BTreeMap<String, String>,
}

impl Crate {
    /// A package below `services/` or `shared/`, which the laws hold for.
    pub fn is_member(&self) -> bool {
        self.folder != ROOT
    }

    /// A package below `shared/`.
    pub fn is_library_of_the_workspace(&self) -> bool {
        self.folder.starts_with("shared/")
    }
}

const ROOT: &str = "tests";

/// Every package below `services/` and `shared/`, and the root package, whose code is in `tests/`.
pub fn crates(tree: &Tree) -> Vec<Crate> {
    let root = tree.text("Cargo.toml").map(|text| parsed("Cargo.toml", text)).unwrap_or_default();
    let folders = [tree.packages("services"), tree.packages("shared")].concat();
    let manifest = |folder: &String| {
        let path = format!("{folder}/Cargo.toml");
        parsed(&path, tree.text(&path).unwrap_or_default())
    };
    let manifests: Vec<(String, Table)> = folders.iter().map(|folder| (folder.clone(), manifest(folder))).collect();
    let libraries: BTreeMap<String, String> =
        manifests.iter().map(|(_, manifest)| (package(manifest), library(manifest))).collect();
    let all = manifests.iter().map(|(folder, manifest)| (folder.as_str(), manifest)).chain([(ROOT, &root)]);
    all.map(|(folder, manifest)| read(folder, manifest, &root, &libraries)).collect()
}

fn parsed(path: &str, text: &str) -> Table {
    text.parse().unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn package(manifest: &Table) -> String {
    let name = manifest.get("package").and_then(|package| package.get("name")).and_then(Value::as_str);
    name.unwrap_or_default().to_owned()
}

fn library(manifest: &Table) -> String {
    let own = manifest.get("lib").and_then(|lib| lib.get("name")).and_then(Value::as_str);
    own.map_or_else(|| package(manifest).replace('-', "_"), str::to_owned)
}

fn read(folder: &str, manifest: &Table, root: &Table, libraries: &BTreeMap<String, String>) -> Crate {
    let mut normal = BTreeSet::new();
    let mut named = BTreeMap::new();
    for (section, links) in [("dependencies", true), ("build-dependencies", true), ("dev-dependencies", false)] {
        let platforms = manifest.get("target").and_then(Value::as_table).into_iter().flat_map(Table::values);
        let tables = std::iter::once(manifest).chain(platforms.filter_map(Value::as_table));
        for (key, value) in tables.filter_map(|table| table.get(section)).filter_map(Value::as_table).flatten() {
            let renamed = renamed(key, value, root);
            let package = renamed.clone().unwrap_or_else(|| key.clone());
            let name = libraries.get(&package).filter(|_| renamed.is_none());
            named.insert(name.cloned().unwrap_or_else(|| key.replace('-', "_")), package.clone());
            if links {
                normal.insert(package);
            }
        }
    }
    let doctest = manifest.get("lib").and_then(|lib| lib.get("doctest")).and_then(Value::as_bool);
    Crate {
        folder: folder.to_owned(),
        package: package(manifest),
        library: library(manifest),
        runs_doc_tests: doctest.unwrap_or(true),
        normal,
        named,
    }
}

/// The package behind the key of a dependency, where manifest or workspace name another one.
fn renamed(key: &str, value: &Value, root: &Table) -> Option<String> {
    let is_of_workspace = value.get("workspace").and_then(Value::as_bool).unwrap_or(false);
    let shared = root.get("workspace").and_then(|w| w.get("dependencies")).and_then(|d| d.get(key));
    let value = if is_of_workspace { shared? } else { value };
    value.get("package").and_then(Value::as_str).map(str::to_owned)
}

#[test]
fn a_dependency_has_the_name_that_code_gives_it() {
    let tree = Tree::of(&[
        ("Cargo.toml", "[workspace.dependencies]\nb = { package = \"x-b\", path = \"shared/b\" }"),
        (
            "shared/a/Cargo.toml",
            "[package]\nname = \"x-a\"\n[dependencies]\nb.workspace = true\nx-c = { path = \"..\" }",
        ),
        ("shared/b/Cargo.toml", "[package]\nname = \"x-b\"\n[lib]\nname = \"b\"\ndoctest = false"),
        ("shared/c/Cargo.toml", "[package]\nname = \"x-c\"\n[lib]\nname = \"sea\""),
    ]);
    let crates = crates(&tree);
    let [a, b, c, root] = &crates[..] else { panic!("{}", crates.len()) };
    assert_eq!(a.named.iter().map(|(k, v)| format!("{k} {v}")).collect::<Vec<_>>(), ["b x-b", "sea x-c"]);
    assert_eq!((a.library.as_str(), b.library.as_str(), c.library.as_str()), ("x_a", "b", "sea"));
    assert!(a.runs_doc_tests && !b.runs_doc_tests && a.is_member() && !root.is_member());
}
