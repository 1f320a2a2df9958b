//! How long files and functions are, and what their lines are.

use crate::house::House;
use crate::source::{LineKind, Source};
use std::collections::BTreeMap;
use syn::visit::{self, Visit};

/// A file with more lines outside tests has two subjects.
const FILE_LINES_MAX: usize = 350;
/// A function longer than this does not fit on a screen.
const FUNCTION_LINES_MAX: usize = 70;
const ASSERTIONS: [&str; 6] =
    ["assert", "assert_eq", "assert_ne", "debug_assert", "debug_assert_eq", "debug_assert_ne"];

/// Of the code of a crate outside tests.
#[derive(Clone, Default)]
pub struct Counts {
    pub files: usize,
    /// Blank ones among them.
    pub lines: usize,
    pub code: usize,
    pub doc: usize,
    pub comments: usize,
    /// Sites of `assert!` and its kin.
    pub assertions: usize,
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.files += other.files;
        self.lines += other.lines;
        self.code += other.code;
        self.doc += other.doc;
        self.comments += other.comments;
        self.assertions += other.assertions;
    }

    /// A number of things per thousand lines of code.
    pub fn per_kline(&self, number: usize) -> f64 {
        1e3 * number as f64 / self.code.max(1) as f64
    }
}

/// Sizes of a workspace, outside tests.
pub struct Sizes {
    /// By folder of the crate.
    pub crates: BTreeMap<String, Counts>,
    pub all: Counts,
    /// Lengths of functions, the shortest first.
    pub functions: Vec<usize>,
    /// `path:line name, n lines` of those that are too long, and `path, n lines` of files.
    pub long_functions: Vec<String>,
    pub long_files: Vec<String>,
}

impl Sizes {
    /// The length that a share of all functions do not exceed.
    pub fn quantile(&self, share: f64) -> usize {
        let place = (share * self.functions.len() as f64).ceil() as usize;
        self.functions.get(place.saturating_sub(1)).copied().unwrap_or(0)
    }
}

/// Counts lines, functions and assertions of every crate.
pub fn measure(house: &House) -> Sizes {
    let mut sizes = Sizes {
        crates: house.members().map(|(_, krate)| (krate.folder.clone(), Counts::default())).collect(),
        all: Counts::default(),
        functions: Vec::new(),
        long_functions: Vec::new(),
        long_files: Vec::new(),
    };
    for (_, source) in house.own_sources() {
        let lines = source.lines.iter().filter(|line| !line.is_test).count();
        let of = |kind| source.lines_of(kind).count();
        let mut scan = Scan { source, functions: Vec::new(), assertions: 0 };
        scan.visit_file(&source.syntax);
        let counts = Counts {
            files: 1,
            lines,
            code: of(LineKind::Code),
            doc: of(LineKind::Doc),
            comments: of(LineKind::Comment),
            assertions: scan.assertions,
        };
        sizes.all.add(&counts);
        sizes.crates.get_mut(&house.crates[source.krate].folder).unwrap().add(&counts);
        if lines > FILE_LINES_MAX {
            sizes.long_files.push(format!("{}, {lines} lines", source.path));
        }
        for (name, line, length) in scan.functions {
            sizes.functions.push(length);
            if length > FUNCTION_LINES_MAX {
                sizes.long_functions.push(format!("{}:{line} {name}, {length} lines", source.path));
            }
        }
    }
    sizes.functions.sort_unstable();
    sizes
}

struct Scan<'a> {
    source: &'a Source,
    /// Name, first line, number of lines from `fn` to the closing brace.
    functions: Vec<(String, usize, usize)>,
    assertions: usize,
}

impl Scan<'_> {
    fn function(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let first = signature.fn_token.span.start().line;
        let last = block.brace_token.span.close().end().line;
        if !self.source.is_test_at(first) {
            self.functions.push((signature.ident.to_string(), first, last + 1 - first));
        }
    }
}

impl<'a> Visit<'a> for Scan<'_> {
    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        self.function(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        self.function(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'a syn::TraitItemFn) {
        item.default.iter().for_each(|block| self.function(&item.sig, block));
        visit::visit_trait_item_fn(self, item);
    }

    fn visit_macro(&mut self, item: &'a syn::Macro) {
        let name = item.path.segments.last().unwrap();
        if ASSERTIONS.iter().any(|own| name.ident == own) && !self.source.is_test_at(name.ident.span().start().line) {
            self.assertions += 1;
        }
    }
}

#[test]
fn lines_functions_and_assertions_outside_tests_are_counted() {
    let long = format!("/// Long.\nfn long() {{\n{}}}\n", "    f();\n".repeat(71));
    let text = format!(
        "{long}{}fn f() {{ assert!(true); debug_assert_eq!(1, 1); }}\n\n{}",
        "// why\n".repeat(276),
        "#[cfg(test)]\nmod tests {\n    #[test]\n    fn g() { assert!(true) }\n}\n"
    );
    let sizes = measure(&House::trial(&[("src/lib.rs", &text)]));
    let own = &sizes.crates["shared/trial"];
    assert_eq!((own.files, own.lines, own.code, own.doc, own.comments, own.assertions), (1, 352, 74, 1, 276, 2));
    assert_eq!((sizes.functions.clone(), sizes.quantile(0.5), sizes.quantile(0.99)), (vec![1, 73], 1, 73));
    assert_eq!(sizes.long_functions, ["shared/trial/src/lib.rs:2 long, 73 lines"]);
    assert_eq!(sizes.long_files, ["shared/trial/src/lib.rs, 352 lines"]);
}
