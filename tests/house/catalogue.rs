//! The catalogue of effects as it is written: which crate holds it, its kinds, their parameters.

use crate::house::House;
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Expr, ExprStruct, Lit};

/// The effects of the crate that defines most of them.
pub struct Catalogue {
    /// Index of the crate that defines most effects.
    pub krate: usize,
    pub kinds: BTreeSet<String>,
    pub parameters: BTreeSet<String>,
}

/// Reads every `Effect { kind: "..", parameters: &[..], .. }` in constants and statics. `None`
/// where no crate has any.
pub fn read(house: &House) -> Option<Catalogue> {
    let mut found: BTreeMap<usize, Catalogue> = BTreeMap::new();
    for (_, source) in house.own_sources() {
        let mut scan = Scan { is_constant: false, effects: Vec::new() };
        scan.visit_file(&source.syntax);
        let empty = || Catalogue { krate: source.krate, kinds: BTreeSet::new(), parameters: BTreeSet::new() };
        for (_, kind, parameters) in scan.effects.into_iter().filter(|(line, ..)| !source.is_test_at(*line)) {
            let own = found.entry(source.krate).or_insert_with(empty);
            own.kinds.insert(kind);
            own.parameters.extend(parameters);
        }
    }
    found.into_values().max_by_key(|catalogue| catalogue.kinds.len())
}

struct Scan {
    /// Inside the value of a constant or a static.
    is_constant: bool,
    /// Line, kind, names of parameters.
    effects: Vec<(usize, String, Vec<String>)>,
}

impl<'a> Visit<'a> for Scan {
    fn visit_item_static(&mut self, item: &'a syn::ItemStatic) {
        self.is_constant = true;
        visit::visit_item_static(self, item);
        self.is_constant = false;
    }

    fn visit_item_const(&mut self, item: &'a syn::ItemConst) {
        self.is_constant = true;
        visit::visit_item_const(self, item);
        self.is_constant = false;
    }

    fn visit_expr_struct(&mut self, value: &'a ExprStruct) {
        let name = &value.path.segments.last().unwrap().ident;
        if self.is_constant
            && name == "Effect"
            && let Some(kind) = field(value, "kind").and_then(text)
        {
            let parameters = field(value, "parameters").map(names).unwrap_or_default();
            self.effects.push((name.span().start().line, kind, parameters));
        }
        visit::visit_expr_struct(self, value);
    }
}

fn field<'a>(value: &'a ExprStruct, name: &str) -> Option<&'a Expr> {
    let own = |member: &syn::Member| matches!(member, syn::Member::Named(own) if own == name);
    value.fields.iter().find(|field| own(&field.member)).map(|field| &field.expr)
}

fn text(value: &Expr) -> Option<String> {
    match value {
        Expr::Lit(literal) => match &literal.lit {
            Lit::Str(text) => Some(text.value()),
            _ => None,
        },
        _ => None,
    }
}

/// The first text of every element of an array: the name of a parameter, however it is built.
fn names(list: &Expr) -> Vec<String> {
    match list {
        Expr::Reference(list) => names(&list.expr),
        Expr::Array(list) => list.elems.iter().filter_map(first_text).map(|(name, _)| name).collect(),
        _ => Vec::new(),
    }
}

/// The first string literal of an expression, with its line.
pub fn first_text(value: &Expr) -> Option<(String, usize)> {
    struct First(Option<(String, usize)>);
    impl<'a> Visit<'a> for First {
        fn visit_lit_str(&mut self, literal: &'a syn::LitStr) {
            self.0.get_or_insert_with(|| (literal.value(), literal.span().start().line));
        }

        fn visit_macro(&mut self, item: &'a syn::Macro) {
            if let Some(text) = texts(&item.tokens).into_iter().next() {
                self.0.get_or_insert(text);
            }
        }
    }
    let mut first = First(None);
    first.visit_expr(value);
    first.0
}

/// Every string literal among tokens, with its line.
pub fn texts(tokens: &TokenStream) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    for token in tokens.clone() {
        match token {
            TokenTree::Group(group) => found.extend(texts(&group.stream())),
            TokenTree::Literal(literal) => {
                let line = literal.span().start().line;
                if let Ok(text) = syn::parse_str::<syn::LitStr>(&literal.to_string()) {
                    found.push((text.value(), line));
                }
            }
            _ => {}
        }
    }
    found
}

#[cfg(test)]
pub const TRIAL: &str = "pub static EFFECT: Effect = Effect { kind: \"joint_rub\", parameters: &[
    EffectParameter::new(\"force\", \"N\").scanned(3), EffectParameter { name: \"rate\", unit: \"m/s\" }], law: \"no kind\" };";

#[test]
fn kinds_and_parameters_are_read_from_the_effects_themselves() {
    let house = House::trial(&[
        (
            "src/lib.rs",
            "mod laws; const OTHER: Thing = Thing { kind: \"thing\" }; fn f() { Effect { kind: \"none\" } }",
        ),
        ("src/laws.rs", "mod rub;"),
        ("src/laws/rub.rs", TRIAL),
    ]);
    let catalogue = read(&house).unwrap();
    assert_eq!(catalogue.kinds, BTreeSet::from(["joint_rub".to_owned()]));
    assert_eq!(catalogue.parameters, BTreeSet::from(["force".to_owned(), "rate".to_owned()]));
    assert!(read(&House::trial(&[("src/lib.rs", "")])).is_none());
}
