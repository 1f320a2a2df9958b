//! One parsed file: its syntax, its tokens, and what each of its lines is.

use crate::attributes;
use proc_macro2::{Delimiter, Span, TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// What a line is read as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineKind {
    Blank,
    Code,
    /// `///`, `//!` and their block forms.
    Doc,
    /// Nothing but an ordinary comment.
    Comment,
}

/// One line of a file.
pub struct Line {
    pub text: String,
    pub kind: LineKind,
    /// Compiled for tests only.
    pub is_test: bool,
}

/// A parsed file of a crate.
pub struct Source {
    /// Relative to the workspace.
    pub path: String,
    /// Index of its crate.
    pub krate: usize,
    pub syntax: syn::File,
    pub tokens: TokenStream,
    pub lines: Vec<Line>,
    /// All of it is compiled for tests only.
    pub is_test: bool,
}

impl Source {
    /// Panics with the place if `text` is no Rust.
    pub fn parse(path: &str, krate: usize, text: &str) -> Self {
        let place = |e: &syn::Error| format!("{path}:{}: {e}", e.span().start().line);
        let tokens: TokenStream = text.parse().unwrap_or_else(|e| panic!("{path}: {e}"));
        let syntax: syn::File = syn::parse2(tokens.clone()).unwrap_or_else(|e| panic!("{}", place(&e)));
        let blank = |text: &str| if text.trim().is_empty() { LineKind::Blank } else { LineKind::Comment };
        let line = |text: &str| Line { text: text.to_owned(), kind: blank(text), is_test: false };
        let mut source = Self {
            path: path.to_owned(),
            krate,
            syntax,
            tokens,
            lines: text.lines().map(line).collect(),
            is_test: false,
        };
        let tokens = source.tokens.clone();
        source.cover(tokens);
        let mut tests = TestLines(Vec::new());
        tests.visit_file(&source.syntax);
        for (first, last) in tests.0 {
            source.lines[first - 1..last].iter_mut().for_each(|line| line.is_test = true);
        }
        if attributes::is_test(&source.syntax.attrs) {
            source.mark_as_test();
        }
        source
    }

    /// Makes all of the file test code.
    pub fn mark_as_test(&mut self) {
        self.is_test = true;
        self.lines.iter_mut().for_each(|line| line.is_test = true);
    }

    /// A line, counted from one, is compiled for tests only.
    pub fn is_test_at(&self, line: usize) -> bool {
        self.lines.get(line - 1).is_none_or(|line| line.is_test)
    }

    /// Numbers of the lines of a kind that are not for tests.
    pub fn lines_of(&self, kind: LineKind) -> impl Iterator<Item = (usize, &str)> {
        let own = self.lines.iter().enumerate().filter(move |(_, line)| line.kind == kind && !line.is_test);
        own.map(|(place, line)| (place + 1, line.text.as_str()))
    }

    fn cover(&mut self, tokens: TokenStream) {
        let mut tokens = tokens.into_iter();
        while let Some(token) = tokens.next() {
            if self.is_comment(&token) {
                // A doc comment is the tokens `#`, perhaps `!`, and `[doc = ".."]` at one place.
                let mut last = token.span();
                for part in tokens.by_ref() {
                    last = part.span();
                    if matches!(part, TokenTree::Group(_)) {
                        break;
                    }
                }
                self.mark(last, LineKind::Doc);
                continue;
            }
            match token {
                TokenTree::Group(group) => {
                    if group.delimiter() != Delimiter::None {
                        self.mark(group.span_open(), LineKind::Code);
                        self.mark(group.span_close(), LineKind::Code);
                    }
                    self.cover(group.stream());
                }
                other => self.mark(other.span(), LineKind::Code),
            }
        }
    }

    fn is_comment(&self, token: &TokenTree) -> bool {
        let TokenTree::Punct(punct) = token else { return false };
        let start = punct.span().start();
        punct.as_char() == '#'
            && self.lines.get(start.line - 1).is_some_and(|line| line.text.chars().nth(start.column) == Some('/'))
    }

    fn mark(&mut self, span: Span, kind: LineKind) {
        for line in span.start().line..=span.end().line {
            if let Some(line) = self.lines.get_mut(line - 1)
                && line.kind != LineKind::Code
            {
                line.kind = kind;
            }
        }
    }
}

/// First and last lines of items that are compiled for tests only.
struct TestLines(Vec<(usize, usize)>);

impl TestLines {
    fn keep(&mut self, span: Span) {
        self.0.push((span.start().line, span.end().line));
    }
}

impl<'a> Visit<'a> for TestLines {
    fn visit_item(&mut self, item: &'a syn::Item) {
        if attributes::is_test(attributes::of(item)) { self.keep(item.span()) } else { visit::visit_item(self, item) }
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        if attributes::is_test(&item.attrs) { self.keep(item.span()) } else { visit::visit_impl_item_fn(self, item) }
    }
}

#[test]
fn a_line_is_code_documentation_a_comment_or_blank() {
    let text = "//! Page.\n\n// why\n/// What.\nfn a() {\n    let s = \"\n// no comment\n\n\"; // trailing\n}\n\
                #[cfg(test)]\nmod tests {\n    // in a test\n    fn b() {}\n}\n";
    let source = Source::parse("a.rs", 0, text);
    let kinds: String = source.lines.iter().map(|line| format!("{:?}", line.kind).remove(0)).collect();
    assert_eq!(kinds, "DBCDCCCCCCCCCCC"); // C: code or a comment
    let comments: Vec<_> = source.lines_of(LineKind::Comment).map(|(line, _)| line).collect();
    let code: Vec<_> = source.lines_of(LineKind::Code).map(|(line, _)| line).collect();
    assert_eq!((comments, code), (vec![3], vec![5, 6, 7, 8, 9, 10]));
    assert!(source.is_test_at(11) && source.is_test_at(15) && !source.is_test_at(10));
}
