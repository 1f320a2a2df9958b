//! The tree of modules of every crate, with what each defines, imports and re-exports.

use crate::attributes;
use crate::manifest::Crate;
use crate::source::Source;
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::{Item, ItemMod, UseTree, Visibility};

/// An item by its name.
pub struct Definition {
    pub is_public: bool,
    /// A struct, enum, trait, union or alias: what a path can go on from.
    pub is_type: bool,
}

/// One name, or all names of a module, made known by `use`.
pub struct Import {
    /// Name in this module; `None` where everything is imported.
    pub name: Option<String>,
    pub path: Vec<String>,
    pub is_public: bool,
}

/// A module with the names that it knows.
#[derive(Default)]
pub struct Module {
    /// Index of its crate and of its file.
    pub krate: usize,
    pub file: usize,
    /// Index of the module that declares it; none of `lib.rs` and `main.rs`.
    pub parent: Option<usize>,
    pub is_public: bool,
    pub items: BTreeMap<String, Vec<Definition>>,
    pub children: BTreeMap<String, usize>,
    pub imports: Vec<Import>,
    /// Identifiers inside macros at module level: one may be the name of an item made there.
    pub made_by_macros: BTreeSet<String>,
}

/// All modules that are not for tests, and the files that are.
#[derive(Default)]
pub struct Modules {
    pub all: Vec<Module>,
    /// Module of `lib.rs` by index of the crate.
    pub libraries: BTreeMap<usize, usize>,
    /// Module of every `lib.rs`, `main.rs` and `bin/*.rs`.
    pub roots: Vec<usize>,
    /// Files of one crate that a module of another is made of: the declaring file, the other one.
    pub included: Vec<(usize, usize)>,
    /// Files that only test modules declare.
    pub test_files: BTreeSet<usize>,
}

impl Modules {
    /// Follows `mod` declarations from the roots of every crate.
    pub fn of(crates: &[Crate], sources: &[Source]) -> Self {
        let files = sources.iter().enumerate().map(|(file, source)| (source.path.as_str(), file)).collect();
        let mut builder = Builder { sources, files, modules: Self::default(), tests: BTreeSet::new() };
        for (krate, own) in crates.iter().enumerate() {
            let src = format!("{}/src/", own.folder);
            let roots = builder.files.iter().filter_map(|(path, file)| Some((path.strip_prefix(&src)?, *file)));
            let is_root = |name: &str| name == "lib.rs" || name == "main.rs" || is_binary(name);
            let roots: Vec<_> = roots.filter(|(name, _)| is_root(name)).collect();
            for (name, file) in roots {
                let folder = sources[file].path.rsplit_once('/').unwrap().0.to_owned();
                let root = builder.module(krate, file, None, &sources[file].syntax.items, &folder);
                builder.modules.all[root].is_public = name == "lib.rs";
                builder.modules.roots.push(root);
                if name == "lib.rs" {
                    builder.modules.libraries.insert(krate, root);
                }
            }
        }
        let own: BTreeSet<usize> = builder.modules.all.iter().map(|module| module.file).collect();
        builder.modules.test_files = builder.tests.difference(&own).copied().collect();
        builder.modules
    }

    /// The root of the crate that a module belongs to.
    pub fn root_of(&self, mut module: usize) -> usize {
        while let Some(parent) = self.all[module].parent {
            module = parent;
        }
        module
    }

    /// `module` itself or one below it.
    pub fn is_within(&self, inner: usize, module: usize) -> bool {
        let mut open = Some(inner);
        while let Some(own) = open {
            if own == module {
                return true;
            }
            open = self.all[own].parent;
        }
        false
    }
}

fn is_binary(name: &str) -> bool {
    name.strip_prefix("bin/").is_some_and(|rest| !rest.contains('/') || rest.ends_with("/main.rs"))
}

struct Builder<'a> {
    sources: &'a [Source],
    files: BTreeMap<&'a str, usize>,
    modules: Modules,
    tests: BTreeSet<usize>,
}

impl Builder<'_> {
    /// The module made of `items` of `file`; `folder` is where the files of its children are.
    fn module(&mut self, krate: usize, file: usize, parent: Option<usize>, items: &[Item], folder: &str) -> usize {
        let place = self.modules.all.len();
        self.modules.all.push(Module { krate, file, parent, ..Module::default() });
        for item in items.iter().filter(|item| !attributes::is_test(attributes::of(item))) {
            match item {
                Item::Mod(child) => self.child(place, child, folder),
                Item::Use(item) => {
                    let is_public = matches!(item.vis, Visibility::Public(_));
                    let leading = if item.leading_colon.is_some() { vec![String::new()] } else { Vec::new() };
                    flatten(&item.tree, leading, &mut |name, path| {
                        self.modules.all[place].imports.push(Import { name, path, is_public });
                    });
                }
                Item::Macro(item) => identifiers(&item.mac.tokens, &mut self.modules.all[place].made_by_macros),
                _ => {}
            }
            if let Some((name, definition)) = definition(item) {
                self.modules.all[place].items.entry(name).or_default().push(definition);
            }
        }
        for item in items {
            if let Item::Mod(child) = item
                && attributes::is_test(&child.attrs)
            {
                self.test_module(child, folder, file);
            }
        }
        place
    }

    fn child(&mut self, parent: usize, child: &ItemMod, folder: &str) {
        let name = child.ident.to_string();
        let (krate, file) = (self.modules.all[parent].krate, self.modules.all[parent].file);
        let below = format!("{folder}/{name}");
        let place = if let Some((_, items)) = &child.content {
            self.module(krate, file, Some(parent), items, &below)
        } else {
            let Some(own) = self.file_of(child, folder, file) else { return };
            if self.sources[own].krate != krate {
                self.modules.included.push((file, own));
            }
            self.module(krate, own, Some(parent), &self.sources[own].syntax.items, &below)
        };
        self.modules.all[place].is_public = matches!(child.vis, Visibility::Public(_));
        self.modules.all[parent].children.insert(name, place);
    }

    /// Marks the files of a test module and of all below it.
    fn test_module(&mut self, module: &ItemMod, folder: &str, file: usize) {
        let below = format!("{folder}/{}", module.ident);
        let (items, file) = match &module.content {
            Some((_, items)) => (items, file),
            None => match self.file_of(module, folder, file) {
                Some(own) => {
                    self.tests.insert(own);
                    (&self.sources[own].syntax.items, own)
                }
                None => return,
            },
        };
        for item in items {
            if let Item::Mod(child) = item {
                self.test_module(child, &below, file);
            }
        }
    }

    fn file_of(&self, module: &ItemMod, folder: &str, declared_in: usize) -> Option<usize> {
        let name = &module.ident;
        let candidates = match attributes::value_of(&module.attrs, "path") {
            Some(path) => {
                let own = self.sources[declared_in].path.rsplit_once('/').unwrap().0;
                vec![joined(own, &path)]
            }
            None => vec![format!("{folder}/{name}.rs"), format!("{folder}/{name}/mod.rs")],
        };
        candidates.iter().find_map(|path| self.files.get(path.as_str()).copied())
    }
}

/// `path` as seen from `folder`, without `..`.
fn joined(folder: &str, path: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').collect();
    for part in path.split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()),
            other => parts.push(other),
        }
    }
    parts.join("/")
}

/// Every leaf of a `use` tree: its name here (`None` for `*`) and its path.
pub fn flatten(tree: &UseTree, mut path: Vec<String>, leaf: &mut impl FnMut(Option<String>, Vec<String>)) {
    match tree {
        UseTree::Path(part) => {
            path.push(part.ident.to_string());
            flatten(&part.tree, path, leaf);
        }
        UseTree::Name(part) => {
            let own = part.ident.to_string();
            if own != "self" {
                path.push(own);
            }
            leaf(path.last().cloned(), path);
        }
        UseTree::Rename(part) => {
            if part.ident != "self" {
                path.push(part.ident.to_string());
            }
            leaf(Some(part.rename.to_string()), path);
        }
        UseTree::Glob(_) => leaf(None, path),
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, path.clone(), leaf)),
    }
}

fn definition(item: &Item) -> Option<(String, Definition)> {
    let public = Visibility::Public(syn::token::Pub::default());
    let (name, visibility, is_type) = match item {
        Item::Const(item) => (&item.ident, &item.vis, false),
        Item::Enum(item) => (&item.ident, &item.vis, true),
        Item::Fn(item) => (&item.sig.ident, &item.vis, false),
        Item::Macro(item) => {
            let is_exported = item.attrs.iter().any(|attribute| attribute.path().is_ident("macro_export"));
            (item.ident.as_ref()?, if is_exported { &public } else { &Visibility::Inherited }, false)
        }
        Item::Static(item) => (&item.ident, &item.vis, false),
        Item::Struct(item) => (&item.ident, &item.vis, true),
        Item::Trait(item) => (&item.ident, &item.vis, true),
        Item::TraitAlias(item) => (&item.ident, &item.vis, true),
        Item::Type(item) => (&item.ident, &item.vis, true),
        Item::Union(item) => (&item.ident, &item.vis, true),
        _ => return None,
    };
    let is_public = matches!(visibility, Visibility::Public(_));
    Some((name.to_string(), Definition { is_public, is_type }))
}

fn identifiers(tokens: &TokenStream, found: &mut BTreeSet<String>) {
    for token in tokens.clone() {
        match token {
            TokenTree::Group(group) => identifiers(&group.stream(), found),
            TokenTree::Ident(name) => drop(found.insert(name.to_string())),
            _ => {}
        }
    }
}
