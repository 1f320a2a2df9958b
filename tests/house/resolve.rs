//! What a path names: the file that defines it, through imports, re-exports and globs.

use crate::house::House;
use crate::modules::Module;
use std::collections::BTreeSet;

/// What a path leads to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    Module(usize),
    /// An item: the module that defines it and its name there.
    Item(usize, String),
    /// Something of a crate outside the workspace.
    Foreign,
}

impl House {
    /// Everything that `path`, written in `module`, may name: a function and a module may share a
    /// name. Empty where it is unknown.
    ///
    /// A path through a type (`Plant::new`, `Kind::Wheel`) leads to the type.
    pub fn resolve(&self, module: usize, path: &[String]) -> BTreeSet<Target> {
        self.walk(module, path, &mut BTreeSet::new())
    }

    fn walk(&self, module: usize, path: &[String], seen: &mut BTreeSet<(usize, String)>) -> BTreeSet<Target> {
        let Some((first, mut rest)) = path.split_first() else { return BTreeSet::new() };
        let mut found = match first.as_str() {
            "crate" => BTreeSet::from([Target::Module(self.modules.root_of(module))]),
            "self" => BTreeSet::from([Target::Module(module)]),
            "super" => self.modules.all[module].parent.map(Target::Module).into_iter().collect(),
            "" => {
                let Some((name, after)) = rest.split_first() else { return BTreeSet::new() };
                rest = after;
                self.external(module, name)
            }
            name => {
                let own = self.lookup(module, name, seen);
                if own.is_empty() { self.external(module, name) } else { own }
            }
        };
        for name in rest {
            let mut next = BTreeSet::new();
            for target in found {
                match target {
                    Target::Module(own) if name == "super" => {
                        next.extend(self.modules.all[own].parent.map(Target::Module))
                    }
                    Target::Module(own) if name == "self" => drop(next.insert(Target::Module(own))),
                    Target::Module(own) => next.extend(self.lookup(own, name, seen)),
                    Target::Item(own, item) => {
                        if self.is_type(own, &item) {
                            next.insert(Target::Item(own, item));
                        }
                    }
                    Target::Foreign => drop(next.insert(Target::Foreign)),
                }
            }
            found = next;
        }
        found
    }

    fn is_type(&self, module: usize, item: &str) -> bool {
        let definitions = self.modules.all[module].items.get(item);
        definitions.is_none_or(|all| all.iter().any(|definition| definition.is_type))
    }

    /// A name inside a module: its own, or one that it imports.
    fn lookup(&self, module: usize, name: &str, seen: &mut BTreeSet<(usize, String)>) -> BTreeSet<Target> {
        if !seen.insert((module, name.to_owned())) {
            return BTreeSet::new(); // on the way already: a circle of globs
        }
        let own: &Module = &self.modules.all[module];
        let mut found = BTreeSet::new();
        if own.items.contains_key(name) {
            found.insert(Target::Item(module, name.to_owned()));
        }
        found.extend(own.children.get(name).map(|child| Target::Module(*child)));
        for import in own.imports.iter().filter(|import| import.name.as_deref() == Some(name)) {
            found.extend(self.walk(module, &import.path, seen));
        }
        if found.is_empty() {
            for import in own.imports.iter().filter(|import| import.name.is_none()) {
                for target in self.walk(module, &import.path, seen) {
                    if let Target::Module(target) = target {
                        found.extend(self.lookup(target, name, seen));
                    }
                }
            }
        }
        if found.is_empty() && !is_of_the_language(name) && own.made_by_macros.contains(name) {
            found.insert(Target::Item(module, name.to_owned()));
        }
        seen.remove(&(module, name.to_owned()));
        found
    }

    fn external(&self, module: usize, name: &str) -> BTreeSet<Target> {
        let krate = &self.crates[self.modules.all[module].krate];
        let is_binary = !self.modules.libraries.values().any(|root| *root == self.modules.root_of(module));
        let package = if is_binary && name == krate.library { Some(&krate.package) } else { krate.named.get(name) };
        let Some(package) = package else {
            return ["std", "core", "alloc"].contains(&name).then_some(Target::Foreign).into_iter().collect();
        };
        let member = self.crates.iter().position(|krate| krate.package == *package);
        let library = member.and_then(|krate| self.modules.libraries.get(&krate));
        BTreeSet::from([library.map_or(Target::Foreign, |root| Target::Module(*root))])
    }

    /// The files that `path`, written in `module`, names something of. A module alone counts for no
    /// file: the paths that go through it do.
    pub fn defining_files(&self, module: usize, path: &[String]) -> BTreeSet<usize> {
        let targets = self.resolve(module, path).into_iter();
        let file = |target| match target {
            Target::Item(module, _) => Some(self.modules.all[module].file),
            Target::Module(_) | Target::Foreign => None,
        };
        targets.filter_map(file).collect()
    }
}

/// Of the prelude or primitive: inside a macro such a name is used, not defined.
fn is_of_the_language(name: &str) -> bool {
    const PRELUDE: &str = "Some None Ok Err Option Result Vec String Box Default Clone Copy Debug PartialEq Eq PartialOrd Ord Hash Send Sync \
                           Sized Fn FnMut FnOnce From Into Iterator IntoIterator Drop ToString ToOwned AsRef AsMut Self";
    name.starts_with(char::is_lowercase) || PRELUDE.split_whitespace().any(|own| own == name)
}

#[test]
fn names_lead_through_re_exports_renames_and_globs_to_the_file_that_defines_them() {
    let house = House::trial(&[
        ("src/lib.rs", "mod a; mod b; mod made; pub use a::deep::*; pub use b::Own as Other;"),
        ("src/a.rs", "pub mod deep; pub use deep::law;"),
        ("src/a/deep.rs", "pub fn law() {} pub struct Thing; pub enum Kind { One }"),
        ("src/b.rs", "use crate::a; use super::Kind; pub struct Own; mod inner { use super::super::a as short; }"),
        ("src/made.rs", "samples! { Imu: u64; }"),
    ]);
    let place =
        |path: &str| house.modules.all.iter().position(|module| house.sources[module.file].path.ends_with(path));
    let (root, b) = (place("/lib.rs").unwrap(), place("/b.rs").unwrap());
    let files = |module, path: &str| {
        let path: Vec<String> = path.split("::").map(str::to_owned).collect();
        let files = house.defining_files(module, &path);
        files.iter().map(|file| house.sources[*file].path.rsplit_once("src/").unwrap().1).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(files(b, "a::law"), "a/deep.rs");
    assert_eq!(files(b, "a::deep::law"), "a/deep.rs");
    assert_eq!(files(b, "crate::Thing::new"), "a/deep.rs");
    assert_eq!(files(b, "Kind::One"), "a/deep.rs");
    assert_eq!(files(b, "super::Other"), "b.rs");
    assert_eq!(files(b + 1, "short::deep::law"), "a/deep.rs");
    assert_eq!(files(root, "made::Imu") + &files(root, "made::u64"), "made.rs");
    assert_eq!(files(root, "a::deep"), "", "a module alone");
    assert_eq!(files(root, "a::nothing"), "");
    assert_eq!(house.resolve(root, &["std".to_owned(), "fs".to_owned()]), BTreeSet::from([Target::Foreign]));
}
