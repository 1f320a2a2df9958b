//! Named numeric constants, and names that a crate gives to two values.

use crate::house::House;
use crate::source::Source;
use std::collections::BTreeMap;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Expr, Type};

/// A named number, or a table of numbers.
pub struct Constant {
    pub name: String,
    /// Without blanks, underscores and the suffix of a type.
    pub value: String,
    pub place: String,
}

/// A name with more than one value inside a crate.
#[derive(Debug)]
pub struct Ambiguous {
    pub name: String,
    /// `value at path:line`, each value once.
    pub values: Vec<String>,
}

/// By folder of the crate.
pub struct Constants {
    pub all: BTreeMap<String, Vec<Constant>>,
    pub ambiguous: BTreeMap<String, Vec<Ambiguous>>,
}

/// Constants of modules, functions and inherent implementations, of a number or of an array, a
/// slice or a tuple of numbers. Those that a trait asks of its implementors are not counted: their
/// names are the trait's.
pub fn measure(house: &House) -> Constants {
    let mut all: BTreeMap<String, Vec<Constant>> = BTreeMap::new();
    for (_, krate) in house.members() {
        all.insert(krate.folder.clone(), Vec::new());
    }
    for (_, source) in house.own_sources() {
        let mut scan = Scan { source, found: Vec::new() };
        scan.visit_file(&source.syntax);
        all.entry(house.crates[source.krate].folder.clone()).or_default().extend(scan.found);
    }
    let ambiguous = all.iter().map(|(krate, constants)| (krate.clone(), ambiguous(constants))).collect();
    Constants { all, ambiguous }
}

fn ambiguous(constants: &[Constant]) -> Vec<Ambiguous> {
    let mut values: BTreeMap<&str, BTreeMap<&str, &str>> = BTreeMap::new();
    for constant in constants {
        values.entry(&constant.name).or_default().entry(&constant.value).or_insert(&constant.place);
    }
    let several = values.into_iter().filter(|(name, values)| *name != "_" && values.len() > 1);
    let text = |(value, place): (&str, &str)| format!("{value} at {place}");
    several
        .map(|(name, values)| Ambiguous { name: name.to_owned(), values: values.into_iter().map(text).collect() })
        .collect()
}

struct Scan<'a> {
    source: &'a Source,
    found: Vec<Constant>,
}

impl Scan<'_> {
    fn keep(&mut self, name: &syn::Ident, of: &Type, value: &Expr) {
        let line = name.span().start().line;
        if is_numeric(of) && !self.source.is_test_at(line) {
            let place = format!("{}:{line}", self.source.path);
            self.found.push(Constant { name: name.to_string(), value: normal(value), place });
        }
    }
}

impl<'a> Visit<'a> for Scan<'_> {
    fn visit_item_const(&mut self, item: &'a syn::ItemConst) {
        self.keep(&item.ident, &item.ty, &item.expr);
        visit::visit_item_const(self, item);
    }

    fn visit_item_impl(&mut self, item: &'a syn::ItemImpl) {
        if item.trait_.is_none() {
            for part in &item.items {
                if let syn::ImplItem::Const(part) = part {
                    self.keep(&part.ident, &part.ty, &part.expr);
                }
            }
        }
        visit::visit_item_impl(self, item);
    }
}

fn is_numeric(of: &Type) -> bool {
    match of {
        Type::Path(path) => path.path.get_ident().is_some_and(|name| is_number(&name.to_string())),
        Type::Array(array) => is_numeric(&array.elem),
        Type::Slice(slice) => is_numeric(&slice.elem),
        Type::Reference(reference) => is_numeric(&reference.elem),
        Type::Tuple(tuple) => !tuple.elems.is_empty() && tuple.elems.iter().all(is_numeric),
        _ => false,
    }
}

fn is_number(name: &str) -> bool {
    let sizes = ["8", "16", "32", "64", "128", "size"];
    name.strip_prefix(['f', 'i', 'u']).is_some_and(|size| sizes.contains(&size))
}

/// `1e-3`, `1.0e-3_f64` and `0.001` are one value.
fn normal(value: &Expr) -> String {
    let text = value.span().source_text().unwrap_or_default();
    let text: String = text.chars().filter(|c| !c.is_whitespace() && *c != '_').collect();
    let number = text.trim_end_matches("f64").trim_end_matches("usize").parse::<f64>();
    number.map_or(text, |number| format!("{number:?}"))
}

#[test]
fn a_name_has_one_value_inside_a_crate() {
    let broken: Vec<String> =
        crate::findings().constants.ambiguous.iter().filter(|(_, names)| !names.is_empty()).map(report).collect();
    assert!(broken.is_empty(), "{}Cure: say in each name what it is of, or keep one value.", broken.concat());
}

fn report((krate, names): (&String, &Vec<Ambiguous>)) -> String {
    let text = |own: &Ambiguous| format!("    {}: {}\n", own.name, own.values.join(", "));
    format!("{krate}: {} names with several values\n{}", names.len(), names.iter().map(text).collect::<String>())
}

#[test]
fn a_name_with_two_values_is_seen_and_two_spellings_of_one_value_are_not() {
    let house = House::trial(&[
        ("src/lib.rs", "mod a; const LIMIT: f64 = 1e-3; const SAME: usize = 1_000; const TABLE: [f64; 2] = [1.0, 2.0];"),
        ("src/a.rs", "const LIMIT: f64 = 2e-3; const SAME: usize = 1000; const NAME: &str = \"x\"; trait T { const K: u8; }
            fn f() { const INNER: (f64, u8) = (1.0, 2); } struct S; impl S { const OWN: i32 = 1; } impl T for S { const K: u8 = 1; }
            #[cfg(test)] mod tests { const SAME: usize = 3; }"),
    ]);
    let found = measure(&house);
    let names: Vec<&str> = found.all["shared/trial"].iter().map(|constant| constant.name.as_str()).collect();
    assert_eq!(names, ["LIMIT", "SAME", "INNER", "OWN", "LIMIT", "SAME", "TABLE"]);
    let [limit] = &found.ambiguous["shared/trial"][..] else { panic!("{:?}", found.ambiguous) };
    assert_eq!(limit.values, ["0.001 at shared/trial/src/lib.rs:1", "0.002 at shared/trial/src/a.rs:1"]);
}
