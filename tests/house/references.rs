//! Every path that code outside tests writes, with the module it is written in.
//!
//! Local variables, parameters and closures hide items of the same name. Fields and methods are no
//! paths: their types are not known here.

use crate::attributes;
use crate::house::House;
use crate::modules::flatten;
use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeSet;
use syn::visit::{self, Visit};
use syn::{Expr, ExprLet, Item, Pat, Path, Visibility};

/// How a path is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// In an expression, a type, a pattern or a macro.
    Inline,
    Use,
    /// `pub use`, `pub(crate) use`, ...
    ReExport,
}

/// A path with its place.
pub struct Reference {
    pub module: usize,
    pub path: Vec<String>,
    pub line: usize,
    pub form: Form,
}

/// All references of the modules of `house`.
pub fn references(house: &House) -> Vec<Reference> {
    let mut found = Vec::new();
    for (module, own) in house.modules.all.iter().enumerate() {
        let declared_inside = own.parent.is_some_and(|parent| house.modules.all[parent].file == own.file);
        if !declared_inside {
            let mut scan = Scan { house, module, scopes: Vec::new(), found: &mut found };
            scan.visit_file(&house.sources[own.file].syntax);
        }
    }
    found
}

struct Scan<'a> {
    house: &'a House,
    module: usize,
    /// Names bound in the blocks around, the innermost last.
    scopes: Vec<BTreeSet<String>>,
    found: &'a mut Vec<Reference>,
}

impl Scan<'_> {
    fn keep(&mut self, path: Vec<String>, line: usize, form: Form) {
        let is_local = |name: &String| self.scopes.iter().any(|scope| scope.contains(name));
        if !(path.len() == 1 && is_local(&path[0])) && path.first().is_some_and(|first| first != "Self") {
            self.found.push(Reference { module: self.module, path, line, form });
        }
    }

    fn scoped(&mut self, inside: impl FnOnce(&mut Self)) {
        self.scopes.push(BTreeSet::new());
        inside(self);
        self.scopes.pop();
    }

    /// Makes the names of a pattern known to the innermost scope. One that begins with a capital
    /// letter is a constant or a variant.
    fn bind(&mut self, pattern: &Pat) {
        struct Names<'a>(&'a mut BTreeSet<String>);
        impl<'a> Visit<'a> for Names<'_> {
            fn visit_pat_ident(&mut self, pattern: &'a syn::PatIdent) {
                let name = pattern.ident.to_string();
                if !name.starts_with(char::is_uppercase) {
                    self.0.insert(name);
                }
                visit::visit_pat_ident(self, pattern);
            }
        }
        if let Some(scope) = self.scopes.last_mut() {
            Names(scope).visit_pat(pattern);
        }
        self.visit_pat(pattern);
    }

    fn function(&mut self, signature: &syn::Signature, block: Option<&syn::Block>) {
        self.scoped(|scan| {
            visit::visit_generics(scan, &signature.generics);
            for input in &signature.inputs {
                if let syn::FnArg::Typed(input) = input {
                    scan.visit_type(&input.ty);
                    scan.bind(&input.pat);
                }
            }
            scan.visit_return_type(&signature.output);
            block.into_iter().for_each(|block| scan.visit_block(block));
        });
    }

    /// Paths among the tokens of a macro: two names or more, or one that is called or begins with a
    /// capital letter.
    fn tokens(&mut self, tokens: &TokenStream) {
        let tokens: Vec<TokenTree> = tokens.clone().into_iter().collect();
        let is =
            |place: usize, mark: char| matches!(tokens.get(place), Some(TokenTree::Punct(p)) if p.as_char() == mark);
        let mut place = 0;
        while place < tokens.len() {
            let start = place;
            place += 1;
            let first = match &tokens[start] {
                TokenTree::Group(group) => {
                    self.tokens(&group.stream());
                    continue;
                }
                TokenTree::Ident(name) => name,
                _ => continue,
            };
            let before = start.checked_sub(1);
            let is_of_macro = before.is_some_and(|before| is(before, '$'));
            if before.is_some_and(|before| is(before, '.') || is(before, '\'')) || is_of_macro && first != "crate" {
                continue;
            }
            let mut path = vec![first.to_string()];
            while is(place, ':') && is(place + 1, ':') {
                let Some(TokenTree::Ident(name)) = tokens.get(place + 2) else { break };
                path.push(name.to_string());
                place += 3;
            }
            let is_called = matches!(tokens.get(place), Some(TokenTree::Group(_))) || is(place, '!');
            if path.len() > 1 || is_called || path[0].starts_with(char::is_uppercase) {
                self.keep(path, first.span().start().line, Form::Inline);
            }
        }
    }
}

impl<'a> Visit<'a> for Scan<'_> {
    fn visit_attribute(&mut self, _: &'a syn::Attribute) {}

    fn visit_visibility(&mut self, _: &'a Visibility) {}

    fn visit_item(&mut self, item: &'a Item) {
        if !attributes::is_test(attributes::of(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        if !attributes::is_test(&item.attrs) {
            self.function(&item.sig, Some(&item.block));
        }
    }

    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        self.function(&item.sig, Some(&item.block));
    }

    fn visit_trait_item_fn(&mut self, item: &'a syn::TraitItemFn) {
        self.function(&item.sig, item.default.as_ref());
    }

    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        let inside = self.house.modules.all[self.module].children.get(&item.ident.to_string());
        if let (Some((_, items)), Some(inside)) = (&item.content, inside) {
            let outside = std::mem::replace(&mut self.module, *inside);
            items.iter().for_each(|item| self.visit_item(item));
            self.module = outside;
        }
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        let form = if matches!(item.vis, Visibility::Inherited) { Form::Use } else { Form::ReExport };
        let line = item.use_token.span.start().line;
        let leading = if item.leading_colon.is_some() { vec![String::new()] } else { Vec::new() };
        let mut leaves = Vec::new();
        flatten(&item.tree, leading, &mut |name, path| leaves.push((name, path)));
        for (name, path) in leaves {
            self.keep(path, line, form);
            // A name that a block imports for itself is known here and nowhere else.
            if let (Some(scope), Some(name)) = (self.scopes.last_mut(), name) {
                scope.insert(name);
            }
        }
    }

    fn visit_path(&mut self, path: &'a Path) {
        let leading = path.leading_colon.iter().map(|_| String::new());
        let names = leading.chain(path.segments.iter().map(|segment| segment.ident.to_string())).collect();
        let line = path.segments.first().map_or(1, |segment| segment.ident.span().start().line);
        self.keep(names, line, Form::Inline);
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'a syn::Macro) {
        self.visit_path(&item.path);
        self.tokens(&item.tokens);
    }

    fn visit_block(&mut self, block: &'a syn::Block) {
        self.scoped(|scan| visit::visit_block(scan, block));
    }

    fn visit_local(&mut self, local: &'a syn::Local) {
        if let Some(init) = &local.init {
            self.visit_expr(&init.expr);
            init.diverge.iter().for_each(|(_, other)| self.visit_expr(other));
        }
        self.bind(&local.pat);
    }

    fn visit_expr(&mut self, expression: &'a Expr) {
        match expression {
            Expr::If(_) | Expr::While(_) => self.scoped(|scan| visit::visit_expr(scan, expression)),
            Expr::Closure(closure) => self.scoped(|scan| {
                closure.inputs.iter().for_each(|input| scan.bind(input));
                scan.visit_return_type(&closure.output);
                scan.visit_expr(&closure.body);
            }),
            Expr::ForLoop(own) => {
                self.visit_expr(&own.expr);
                self.scoped(|scan| {
                    scan.bind(&own.pat);
                    scan.visit_block(&own.body);
                });
            }
            _ => visit::visit_expr(self, expression),
        }
    }

    fn visit_expr_let(&mut self, own: &'a ExprLet) {
        self.visit_expr(&own.expr);
        self.bind(&own.pat);
    }

    fn visit_arm(&mut self, arm: &'a syn::Arm) {
        self.scoped(|scan| {
            scan.bind(&arm.pat);
            arm.guard.iter().for_each(|(_, guard)| scan.visit_expr(guard));
            scan.visit_expr(&arm.body);
        });
    }
}

#[test]
fn what_code_names_is_found_and_what_a_local_variable_hides_is_not() {
    let house = House::trial(&[(
        "src/lib.rs",
        "pub use a::One; use b::{self, Two as Deux};
         fn f(hidden: Tau) -> b::Three { let law = law(hidden); if let Some(x) = law { x(); }
             assert!(c::four(law, called(), $crate::five, s.field)); match law { Six => hidden(), y => y() } }
         mod inner { fn g() { use d::local; local(); (|z| z(free))(1); } }
         #[cfg(test)] mod tests { use super::never; }
         impl Seven { #[cfg(test)] fn h() { never() } fn i(&self) -> Self { for k in eight { k() } } }",
    )]);
    let found = references(&house);
    let text = |own: &Reference| format!("{}{}", "/".repeat(own.module), own.path.join("::"));
    let inline: Vec<String> = found.iter().filter(|own| own.form == Form::Inline).map(text).collect();
    let expected = "Tau b::Three law Some assert c::four called crate::five /free Seven eight";
    assert_eq!(inline.join(" "), expected);
    let uses: Vec<String> = found.iter().filter(|own| own.form != Form::Inline).map(text).collect();
    assert_eq!(uses, ["a::One", "b", "b::Two", "/d::local"]);
}
