//! Decisions on the name of an effect or of its parameter, outside the catalogue.
//!
//! An effect has a role, a scan and a prior. Code that compares its name instead knows something of
//! it that the catalogue should say, and misses the next effect of that sort.

use crate::catalogue::{Catalogue, first_text, read, texts};
use crate::house::House;
use crate::source::Source;
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, Lit};

/// Has a menu of truths of its own, whose names are the catalogue's on purpose.
const OWN_MENU: &str = "shared/challenge";

/// What was read of the catalogue, and where else its names are.
pub struct Matches {
    pub kinds: usize,
    pub parameters: usize,
    /// `path:line "name"`, one for every line.
    pub lines: Vec<String>,
    /// Names of parameters that are passed to a function, `place("begin")`: mostly a lookup, now
    /// and then a word to show. No law holds for them.
    pub arguments: Vec<String>,
}

/// Decisions are lines where a kind is in a pattern, a comparison or a list, is looked up among
/// the effects or made into one; and, in files that speak of effects, lines where the name of a
/// parameter is in a pattern or a comparison. A key of a file that is spelled like a kind does not
/// count.
pub fn measure(house: &House) -> Matches {
    let mut matches = Matches { kinds: 0, parameters: 0, lines: Vec::new(), arguments: Vec::new() };
    let Some(catalogue) = read(house) else { return matches };
    matches.kinds = catalogue.kinds.len();
    matches.parameters = catalogue.parameters.len();
    let none = BTreeSet::new();
    for (_, source) in house.own_sources() {
        if source.krate == catalogue.krate || house.crates[source.krate].folder == OWN_MENU {
            continue;
        }
        let speaks = speaks_of_effects(house, source, &catalogue);
        let mut scan = Scan {
            kinds: &catalogue.kinds,
            parameters: if speaks { &catalogue.parameters } else { &none },
            decisions: BTreeMap::new(),
            arguments: BTreeMap::new(),
        };
        scan.visit_file(&source.syntax);
        let places = |lines: BTreeMap<usize, String>| {
            let own = lines.into_iter().filter(|(line, _)| !source.is_test_at(*line));
            own.map(|(line, text)| format!("{}:{line} \"{text}\"", source.path)).collect::<Vec<_>>()
        };
        matches.lines.extend(places(scan.decisions));
        matches.arguments.extend(places(scan.arguments));
    }
    matches
}

/// Files that speak of effects, of crates that depend on the catalogue's.
fn speaks_of_effects(house: &House, source: &Source, catalogue: &Catalogue) -> bool {
    fn has(tokens: &TokenStream) -> bool {
        tokens.clone().into_iter().any(|token| match token {
            TokenTree::Group(group) => has(&group.stream()),
            TokenTree::Ident(name) => name == "effect" || name == "effects" || name == "Effect",
            _ => false,
        })
    }
    let package = &house.crates[catalogue.krate].package;
    house.crates[source.krate].named.values().any(|own| own == package) && has(&source.tokens)
}

/// Names by line.
struct Scan<'a> {
    kinds: &'a BTreeSet<String>,
    parameters: &'a BTreeSet<String>,
    decisions: BTreeMap<usize, String>,
    arguments: BTreeMap<usize, String>,
}

impl Scan<'_> {
    fn decide(&mut self, value: &Expr) {
        match value {
            Expr::Lit(literal) => self.decide_literal(&literal.lit),
            Expr::Tuple(tuple) => tuple.elems.iter().for_each(|part| self.decide(part)),
            _ => {}
        }
    }

    fn decide_literal(&mut self, literal: &Lit) {
        if let Lit::Str(text) = literal {
            self.decide_text(text.value(), text.span().start().line);
        }
    }

    fn decide_text(&mut self, text: String, line: usize) {
        if self.kinds.contains(&text) || self.parameters.contains(&text) {
            self.decisions.entry(line).or_insert(text);
        }
    }

    /// A kind in a list, passed to a function of effects or made into one.
    fn kind(&mut self, value: &Expr) {
        let own = first_text(value).filter(|(text, _)| self.kinds.contains(text));
        self.decisions.extend(own.map(|(text, line)| (line, text)));
    }
}

fn is_of_effects(name: &syn::Ident) -> bool {
    name.to_string().contains("effect")
}

impl<'a> Visit<'a> for Scan<'_> {
    fn visit_pat(&mut self, pattern: &'a syn::Pat) {
        if let syn::Pat::Lit(pattern) = pattern {
            self.decide_literal(&pattern.lit);
        }
        visit::visit_pat(self, pattern);
    }

    fn visit_expr_binary(&mut self, binary: &'a syn::ExprBinary) {
        if matches!(binary.op, BinOp::Eq(_) | BinOp::Ne(_)) {
            self.decide(&binary.left);
            self.decide(&binary.right);
        }
        visit::visit_expr_binary(self, binary);
    }

    fn visit_expr_array(&mut self, array: &'a syn::ExprArray) {
        array.elems.iter().for_each(|part| self.kind(part));
        visit::visit_expr_array(self, array);
    }

    fn visit_field_value(&mut self, field: &'a syn::FieldValue) {
        if matches!(&field.member, syn::Member::Named(name) if name == "kind") {
            self.kind(&field.expr);
        }
        visit::visit_field_value(self, field);
    }

    fn visit_expr_call(&mut self, call: &'a syn::ExprCall) {
        if let Expr::Path(function) = &*call.func
            && is_of_effects(&function.path.segments.last().unwrap().ident)
        {
            call.args.iter().for_each(|argument| self.kind(argument));
        }
        for argument in &call.args {
            if let Expr::Lit(literal) = argument
                && let Lit::Str(text) = &literal.lit
                && self.parameters.contains(&text.value())
            {
                self.arguments.insert(text.span().start().line, text.value());
            }
        }
        visit::visit_expr_call(self, call);
    }

    /// `effect.kind.starts_with("appendage")`, `plant.add_effect("joint_coulomb", ..)`.
    fn visit_expr_method_call(&mut self, call: &'a syn::ExprMethodCall) {
        let is_kind = matches!(&*call.receiver, Expr::Field(field)
            if matches!(&field.member, syn::Member::Named(name) if name == "kind"));
        if let (true, Some(Expr::Lit(literal))) = (is_kind, call.args.first())
            && let Lit::Str(text) = &literal.lit
            && self.kinds.iter().any(|kind| kind.contains(&text.value()))
        {
            self.decisions.insert(text.span().start().line, text.value());
        }
        if is_of_effects(&call.method) {
            call.args.iter().for_each(|argument| self.kind(argument));
        }
        visit::visit_expr_method_call(self, call);
    }

    fn visit_macro(&mut self, item: &'a syn::Macro) {
        if item.path.is_ident("matches") {
            texts(&item.tokens).into_iter().for_each(|(text, line)| self.decide_text(text, line));
        }
    }
}

#[test]
fn no_code_outside_the_catalogue_decides_on_the_name_of_an_effect() {
    let found = &crate::findings().matches;
    assert!(found.kinds > 0 && found.parameters > 0, "no effects were read: the catalogue is written in another way");
    let list = found.lines.join("\n");
    assert!(
        found.lines.is_empty(),
        "{list}\n{} lines. Cure: let the effect or its parameter say what is decided here (role, scan, prior).",
        found.lines.len()
    );
}

#[cfg(test)]
fn found_in(user: &str) -> [Vec<String>; 2] {
    let tree = crate::tree::Tree::of(&[
        ("shared/laws/Cargo.toml", "[package]\nname = \"laws\""),
        ("shared/laws/src/lib.rs", "pub struct Effect; pub mod rub; fn own() { \"joint_rub\" }"),
        ("shared/laws/src/rub.rs", crate::catalogue::TRIAL),
        ("shared/user/Cargo.toml", "[package]\nname = \"user\"\n[dependencies]\nlaws = { path = \"../laws\" }"),
        ("shared/user/src/lib.rs", user),
        ("shared/challenge/Cargo.toml", "[package]\nname = \"challenge\""),
        ("shared/challenge/src/lib.rs", "fn menu() { \"joint_rub\" }"),
    ]);
    let place = |line: String| line.strip_prefix("shared/user/src/lib.rs:").unwrap().to_owned();
    let found = measure(&House::of(&tree));
    [found.lines, found.arguments].map(|lines| lines.into_iter().map(place).collect())
}

#[test]
fn a_decision_on_a_kind_or_a_parameter_is_seen_and_a_key_of_the_same_spelling_is_not() {
    let text = "use laws::Effect;\nfn f(e: &Effect) {\n match e.name {\n \"rate\" => 1,\n _ => 2 };\n e.name == \"force\";\n\
                matches!(e.name, \"rate\");\n e.kind.starts_with(\"joint\");\n e.kind == \"joint_rub\" && e.name == \"rate\";\n\
                show(\"force\");\n}\n#[cfg(test)]\nmod tests { fn g() { x == \"joint_rub\" } }";
    let [lines, arguments] = found_in(text);
    assert_eq!(lines, ["4 \"rate\"", "6 \"force\"", "7 \"rate\"", "8 \"joint\"", "9 \"joint_rub\""]);
    assert_eq!(arguments, ["10 \"force\""]);
    let elsewhere = "const OF: [&str; 1] = [\"joint_rub\"];\nfn f(n: &str) {\n n == \"rate\";\n plant.add_effect(\"joint_rub\");\n\
                     Use { kind: \"joint_rub\".into() };\n file.number(\"joint_rub\");\n (\"joint_rub\", 1) != x\n}";
    let [lines, _] = found_in(elsewhere);
    assert_eq!(lines, ["1 \"joint_rub\"", "4 \"joint_rub\"", "5 \"joint_rub\"", "7 \"joint_rub\""]);
}
