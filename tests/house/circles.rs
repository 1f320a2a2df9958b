//! Circles: files of a crate that name each other, and crates that link each other.
//!
//! A file has an edge to another where it names something that the other defines, through whatever
//! re-exports. A parent has none to its own parts: it is made of them. A part has one to its
//! parent. Methods and fields make no edge, for no types are known here.

use crate::house::House;
use crate::references::{Form, references};
use std::collections::{BTreeMap, BTreeSet};

/// Most files of a circle. More that can only be read together are one file, or wrongly cut.
pub const FILES_MAX: usize = 3;

/// Files, modules or crates that all reach each other, with one edge out of each to another one.
#[derive(Debug)]
pub struct Circle {
    pub members: Vec<String>,
    pub edges: Vec<String>,
}

/// All circles of a workspace.
pub struct Circles {
    /// Of files inside a crate, the largest first.
    pub of_files: Vec<Circle>,
    /// The same, had a parent edges to its own parts where it uses them and does not only declare
    /// or re-export them. For comparison: most are a parent whose types its parts share.
    pub with_parents: Vec<Circle>,
    /// Of crates.
    pub of_crates: Vec<Circle>,
    /// Of the modules directly below the root of a crate, all files of each taken together.
    pub of_subjects: Vec<Circle>,
    /// Paths from `crate`, `self` or `super` that lead nowhere: with any, edges are missing.
    pub unresolved: Vec<String>,
}

type Graph = BTreeMap<String, BTreeMap<String, String>>;

/// Draws the graphs and finds what is strongly connected in them.
pub fn measure(house: &House) -> Circles {
    let (mut files, mut with_parents, mut subjects): (Graph, Graph, Graph) = Default::default();
    let mut unresolved = Vec::new();
    for reference in references(house) {
        let from = house.modules.all[reference.module].file;
        let source = &house.sources[from];
        let path = reference.path.join("::");
        let is_rooted = ["crate", "self", "super"].contains(&reference.path[0].as_str());
        if is_rooted && house.resolve(reference.module, &reference.path).is_empty() {
            unresolved.push(format!("{}:{} {path}", source.path, reference.line));
        }
        for file in house.defining_files(reference.module, &reference.path) {
            let to = &house.sources[file];
            if file == from || to.krate != source.krate {
                continue;
            }
            let is_part = is_part(house, file, from);
            let why = format!("{}:{} names {path} of {}", source.path, reference.line, to.path);
            let keep = |graph: &mut Graph, from: &str, to: &str| {
                graph.entry(from.to_owned()).or_default().entry(to.to_owned()).or_insert_with(|| why.clone());
            };
            if !is_part {
                keep(&mut files, &source.path, &to.path);
            }
            if !(is_part && reference.form == Form::ReExport) {
                keep(&mut with_parents, &source.path, &to.path);
            }
            let (own, other) = (subject(&source.path), subject(&to.path));
            if own != other && !is_part {
                keep(&mut subjects, &own, &other);
            }
        }
    }
    Circles {
        of_files: circles(&files),
        with_parents: circles(&with_parents),
        of_crates: circles(&crates(house)),
        of_subjects: circles(&subjects),
        unresolved,
    }
}

/// `file` holds a module below one of `parent`.
fn is_part(house: &House, file: usize, parent: usize) -> bool {
    let modules = &house.modules;
    let of = |file| move |&module: &usize| modules.all[module].file == file;
    let all = 0..modules.all.len();
    all.clone()
        .filter(of(file))
        .any(|inner| all.clone().filter(of(parent)).any(|outer| modules.is_within(inner, outer)))
}

/// The module directly below the root that a file belongs to: `shared/plant/src/effects` of
/// `shared/plant/src/effects/law.rs`.
fn subject(path: &str) -> String {
    path.trim_end_matches(".rs").split('/').take(4).collect::<Vec<_>>().join("/")
}

/// Links between packages: what manifests say, and files of another crate that are compiled in.
fn crates(house: &House) -> Graph {
    let mut graph = Graph::new();
    for (_, krate) in house.members() {
        for package in &krate.normal {
            if house.members().any(|(_, other)| other.package == *package) {
                let why = format!("{}/Cargo.toml depends on {package}", krate.folder);
                graph.entry(krate.package.clone()).or_default().insert(package.clone(), why);
            }
        }
    }
    for (from, to) in &house.modules.included {
        let [from, to] = [from, to].map(|file| &house.sources[*file]);
        let [own, other] = [from, to].map(|source| house.crates[source.krate].package.clone());
        graph.entry(own).or_default().insert(other, format!("{} includes {}", from.path, to.path));
    }
    graph
}

/// Strongly connected components of two nodes and more, the largest first.
fn circles(graph: &Graph) -> Vec<Circle> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        graph.keys().map(|node| (node.as_str(), reach(graph, node))).collect();
    let mut done = BTreeSet::new();
    let mut found = Vec::new();
    for (node, reach) in &reached {
        let is_mutual = |other: &&&str| reached.get(**other).is_some_and(|back| back.contains(node));
        let members: Vec<&str> = reach.iter().filter(is_mutual).copied().collect();
        if members.len() > 1 && done.insert(members.clone()) {
            let inside = |from: &&str| graph[*from].iter().find(|(to, _)| members.contains(&to.as_str()));
            let edges = members.iter().filter_map(inside).map(|(_, why)| why.clone()).collect();
            found.push(Circle { members: members.iter().map(|member| (*member).to_owned()).collect(), edges });
        }
    }
    found.sort_by_key(|circle| std::cmp::Reverse(circle.members.len()));
    found
}

/// What can be reached from `node` by one edge or more.
fn reach<'a>(graph: &'a Graph, node: &str) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&str> = graph[node].keys().map(String::as_str).collect();
    while let Some(next) = open.pop() {
        if found.insert(next) {
            open.extend(graph.get(next).into_iter().flat_map(BTreeMap::keys).map(String::as_str));
        }
    }
    found
}

/// What a law says when it is broken: every circle with the edges that close it.
fn report(circles: &[&Circle]) -> String {
    let text = |circle: &&Circle| format!("{} files:\n    {}\n", circle.members.len(), circle.edges.join("\n    "));
    circles.iter().map(text).collect()
}

#[test]
fn no_more_than_three_files_of_a_crate_name_each_other_in_a_circle() {
    let circles = &crate::findings().circles;
    assert!(
        circles.unresolved.is_empty(),
        "not resolved, so that edges are missing:\n{}\nCure: teach `resolve` that form.",
        circles.unresolved.join("\n")
    );
    let large: Vec<&Circle> = circles.of_files.iter().filter(|circle| circle.members.len() > FILES_MAX).collect();
    assert!(
        large.is_empty(),
        "{}Cure: move what is shared to a file below all of them, or pass it as an argument.",
        report(&large)
    );
}

#[test]
fn no_crates_link_each_other_in_a_circle() {
    let circles: Vec<&Circle> = crate::findings().circles.of_crates.iter().collect();
    assert!(circles.is_empty(), "{}Cure: move what is shared to a crate below both.", report(&circles));
}

#[cfg(test)]
fn members(circles: &[Circle]) -> Vec<String> {
    let names = |circle: &Circle| {
        circle
            .members
            .iter()
            .map(|m| m.rsplit_once("src/").map_or(m.as_str(), |(_, name)| name))
            .collect::<Vec<_>>()
            .join(" ")
    };
    circles.iter().map(names).collect()
}

#[test]
fn a_circle_is_seen_through_re_exports_and_a_parent_is_made_of_its_parts() {
    let house = House::trial(&[
        ("src/lib.rs", "mod a; mod b; pub use b::B;"),
        ("src/a.rs", "mod one; mod two; use one::One; pub struct Shared(One);"),
        ("src/a/one.rs", "use super::Shared; pub struct One(crate::B);"),
        ("src/a/two.rs", "use super::one::One;"),
        ("src/b.rs", "mod deep; pub use deep::B;"),
        ("src/b/deep.rs", "pub struct B; fn f() { crate::a::one::One::new() }"),
    ]);
    let found = measure(&house);
    assert_eq!(members(&found.of_files), ["a/one.rs b/deep.rs"]);
    assert_eq!(members(&found.with_parents), ["a.rs a/one.rs b/deep.rs"]);
    assert_eq!(members(&found.of_subjects), ["a b"]);
    assert!(
        found.of_files[0].edges[1].contains("b/deep.rs:1 names crate::a::one::One::new of"),
        "{:?}",
        found.of_files
    );
    let broken = measure(&House::trial(&[("src/lib.rs", "mod a;"), ("src/a.rs", "use crate::nowhere::Thing;")]));
    assert_eq!(broken.unresolved, ["shared/trial/src/a.rs:1 crate::nowhere::Thing"]);
}

#[test]
fn crates_that_link_or_include_each_other_are_a_circle() {
    let tree = crate::tree::Tree::of(&[
        ("shared/a/Cargo.toml", "[package]\nname = \"a\"\n[dependencies]\nb = { path = \"../b\" }"),
        ("shared/a/src/lib.rs", ""),
        ("shared/b/Cargo.toml", "[package]\nname = \"b\"\n[dev-dependencies]\na = { path = \"../a\" }"),
        ("shared/b/src/lib.rs", "#[path = \"../../a/src/lib.rs\"] mod a;"),
    ]);
    let found = measure(&House::of(&tree));
    assert_eq!(members(&found.of_crates), ["a b"]);
    assert!(found.of_files.is_empty());
}
