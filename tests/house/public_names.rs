//! Public items: which are documented, and which no other crate names.

use crate::attributes;
use crate::house::House;
use crate::resolve::Target;
use crate::source::Source;
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::{ImplItem, Item, Type, Visibility};

/// Least share of public items with a documentation.
pub const DOCUMENTED_MIN: f64 = 0.9;

/// Public names of one crate.
#[derive(Clone, Default)]
pub struct Names {
    /// `pub` items and inherent `pub` functions and constants.
    pub items: usize,
    /// `path:line name` of those without documentation.
    pub undocumented: Vec<String>,
    /// Names that other crates can reach, and `path:line name` of those that none does.
    pub reachable: usize,
    pub unused: Vec<String>,
}

/// By folder of the crate.
pub type PublicNames = BTreeMap<String, Names>;

/// A reachable name counts as used where its identifier is in a file of another crate, tests
/// included, that names this crate. That is an approximation from both sides: two methods of one
/// name cannot be told apart, and a type that is returned but never named counts as unused.
pub fn measure(house: &House) -> PublicNames {
    let files: Vec<(usize, BTreeSet<String>)> =
        house.sources.iter().map(|source| (source.krate, identifiers(source))).collect();
    let mut found = PublicNames::new();
    for (krate, own) in house.members() {
        let mut names = Names::default();
        let name_in = |user: usize| {
            let named = house.crates[user].named.iter().find(|(_, package)| **package == own.package);
            named.map_or(own.library.as_str(), |(name, _)| name)
        };
        let users = files.iter().filter(|(user, file)| *user != krate && file.contains(name_in(*user)));
        let used: BTreeSet<&String> = users.flat_map(|(_, file)| file).collect();
        let is_used = |name: &String| used.contains(name);
        let reachable = reachable(house, krate);
        for public in items(house, krate) {
            names.items += 1;
            let place = format!("{} {}", public.place, public.name);
            if !public.is_documented {
                names.undocumented.push(place.clone());
            }
            if reachable.contains(&public.owner) {
                names.reachable += 1;
                if !is_used(&public.name) {
                    names.unused.push(place);
                }
            }
        }
        found.insert(own.folder.clone(), names);
    }
    found
}

struct Public {
    name: String,
    /// Itself, or the type it is a part of.
    owner: Target,
    place: String,
    is_documented: bool,
}

/// All that is `pub` outside tests, in modules that may be private.
fn items(house: &House, krate: usize) -> Vec<Public> {
    let mut found = Vec::new();
    let modules = &house.modules.all;
    for (module, own) in modules.iter().enumerate().filter(|(_, own)| own.krate == krate) {
        let declared_inside = own.parent.is_some_and(|parent| modules[parent].file == own.file);
        if !declared_inside && house.sources[own.file].krate == krate {
            collect(house, module, &house.sources[own.file].syntax.items, &mut found);
        }
    }
    found
}

fn collect(house: &House, module: usize, items: &[Item], found: &mut Vec<Public>) {
    let own = &house.modules.all[module];
    let path = &house.sources[own.file].path;
    let mut keep = |name: &syn::Ident, owner: Target, visibility: &Visibility, is_documented: bool| {
        if matches!(visibility, Visibility::Public(_)) {
            let place = format!("{path}:{}", name.span().start().line);
            found.push(Public { name: name.to_string(), owner, place, is_documented });
        }
    };
    let mut inside = Vec::new();
    for item in items.iter().filter(|item| !attributes::is_test(attributes::of(item))) {
        let documented = attributes::is_documented(attributes::of(item));
        let (name, visibility) = match item {
            Item::Const(item) => (&item.ident, &item.vis),
            Item::Enum(item) => (&item.ident, &item.vis),
            Item::Fn(item) => (&item.sig.ident, &item.vis),
            Item::Static(item) => (&item.ident, &item.vis),
            Item::Struct(item) => (&item.ident, &item.vis),
            Item::Trait(item) => (&item.ident, &item.vis),
            Item::Type(item) => (&item.ident, &item.vis),
            Item::Union(item) => (&item.ident, &item.vis),
            Item::Mod(item) => {
                let Some(child) = own.children.get(&item.ident.to_string()) else { continue };
                let page = &house.sources[house.modules.all[*child].file].syntax.attrs;
                let is_documented = documented || item.content.is_none() && attributes::is_documented(page);
                keep(&item.ident, Target::Module(*child), &item.vis, is_documented);
                inside.extend(item.content.as_ref().map(|(_, items)| (*child, items)));
                continue;
            }
            Item::Impl(item) if item.trait_.is_none() => {
                let Type::Path(of) = &*item.self_ty else { continue };
                let of: Vec<String> = of.path.segments.iter().map(|segment| segment.ident.to_string()).collect();
                let Some(owner) = house.resolve(module, &of).into_iter().next() else { continue };
                for part in &item.items {
                    let (name, visibility, attributes) = match part {
                        ImplItem::Fn(part) => (&part.sig.ident, &part.vis, &part.attrs),
                        ImplItem::Const(part) => (&part.ident, &part.vis, &part.attrs),
                        _ => continue,
                    };
                    if !attributes::is_test(attributes) {
                        keep(name, owner.clone(), visibility, attributes::is_documented(attributes));
                    }
                }
                continue;
            }
            _ => continue,
        };
        keep(name, Target::Item(module, name.to_string()), visibility, documented);
    }
    inside.into_iter().for_each(|(child, items)| collect(house, child, items, found));
}

/// Public items and modules that a path from the root of the library leads to.
fn reachable(house: &House, krate: usize) -> BTreeSet<Target> {
    let mut found = BTreeSet::new();
    let mut open: Vec<Target> =
        house.modules.libraries.get(&krate).map(|root| Target::Module(*root)).into_iter().collect();
    while let Some(target) = open.pop() {
        let Target::Module(module) = target else {
            found.insert(target);
            continue;
        };
        if !found.insert(target) {
            continue;
        }
        let own = &house.modules.all[module];
        let public = own.items.iter().filter(|(_, all)| all.iter().any(|definition| definition.is_public));
        open.extend(public.map(|(name, _)| Target::Item(module, name.clone())));
        let children = own.children.values().filter(|child| house.modules.all[**child].is_public);
        open.extend(children.map(|child| Target::Module(*child)));
        for import in own.imports.iter().filter(|import| import.is_public) {
            open.extend(house.resolve(module, &import.path));
        }
    }
    found
}

/// Identifiers of a file, those inside macros included.
fn identifiers(source: &Source) -> BTreeSet<String> {
    fn collect(tokens: &TokenStream, found: &mut BTreeSet<String>) {
        for token in tokens.clone() {
            match token {
                TokenTree::Group(group) => collect(&group.stream(), found),
                TokenTree::Ident(name) => drop(found.insert(name.to_string())),
                _ => {}
            }
        }
    }
    let mut found = BTreeSet::new();
    collect(&source.tokens, &mut found);
    found
}

#[test]
fn nine_in_ten_public_items_are_documented() {
    let found = &crate::findings().names;
    let (mut items, mut list) = (0, Vec::new());
    for names in found.values() {
        items += names.items;
        list.extend(names.undocumented.iter().map(String::as_str));
    }
    assert!(items > 0, "no public items were read");
    let share = 1.0 - list.len() as f64 / items as f64;
    assert!(
        share >= DOCUMENTED_MIN,
        "{}\n{:.1} % of {items} public items are documented. Cure: a line of documentation, or `pub(crate)`.",
        list.join("\n"),
        100.0 * share
    );
}

#[test]
fn an_undocumented_and_an_unused_public_name_are_seen() {
    let tree = crate::tree::Tree::of(&[
        ("shared/a/Cargo.toml", "[package]\nname = \"a\""),
        (
            "shared/a/src/lib.rs",
            "//! Page.\nmod hidden;\npub mod shown;\npub use hidden::Told;\npub(crate) fn own() {}\n#[cfg(test)] pub fn t() {}",
        ),
        (
            "shared/a/src/hidden.rs",
            "/// Doc.\npub struct Told;\npub struct Kept;\nimpl Told {\n pub fn new() {}\n fn f() {} }",
        ),
        ("shared/a/src/shown.rs", "//! Page.\n/// Doc.\npub const USED: u8 = 1;\n/// Doc.\npub type Unused = u8;"),
        ("shared/b/Cargo.toml", "[package]\nname = \"b\"\n[dev-dependencies]\na = { path = \"../a\" }"),
        ("shared/b/tests/t.rs", "use a::Told; fn f() { assert!(a::shown::USED); Told::new() }"),
        ("shared/c/Cargo.toml", "[package]\nname = \"c\""),
        ("shared/c/src/lib.rs", "type X = Unused;"),
    ]);
    let found = measure(&House::of(&tree));
    let a = &found["shared/a"];
    assert_eq!((a.items, a.reachable), (6, 5));
    assert_eq!(a.undocumented, ["shared/a/src/hidden.rs:3 Kept", "shared/a/src/hidden.rs:5 new"]);
    assert_eq!(a.unused, ["shared/a/src/shown.rs:5 Unused"]);
}
