//! Errors that point at a place in a text file, several at once.

use miette::{Diagnostic, LabeledSpan, NamedSource, Severity, SourceSpan};
use std::ops::Range;

/// Something in a file that cannot be used, and what else in it cannot.
#[derive(Debug, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
pub struct Located {
    file: String,
    line: usize,
    column: usize,
    message: String,
    cure: String,
    document: NamedSource<String>,
    span: SourceSpan,
    others: Vec<Located>,
    severity: Severity,
}

impl Located {
    /// An error at the bytes `span` of `text`, which are the content of `file`; `cure` is what the
    /// user can do.
    #[must_use]
    pub fn new(file: &str, text: &str, span: Range<usize>, message: String, cure: String) -> Self {
        let (line, column) = place(text, span.start);
        let document = NamedSource::new(file, text.to_string());
        let (others, severity) = (Vec::new(), Severity::Error);
        Located { file: file.into(), line, column, message, cure, document, span: span.into(), others, severity }
    }

    /// Possible, but not plausible.
    #[must_use]
    pub fn into_warning(self) -> Self {
        Located { severity: Severity::Warning, ..self }
    }

    /// The first of several errors in a file carries the others with it; `None` of none.
    #[must_use]
    pub fn first_of(errors: Vec<Located>) -> Option<Located> {
        let mut errors = errors.into_iter();
        let mut first = errors.next()?;
        first.others = errors.collect();
        Some(first)
    }
}

impl Diagnostic for Located {
    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        (!self.cure.is_empty()).then(|| Box::new(&self.cure) as Box<dyn std::fmt::Display>)
    }
    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        Some(&self.document)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(std::iter::once(LabeledSpan::underline(self.span))))
    }
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        (!self.others.is_empty())
            .then(|| Box::new(self.others.iter().map(|other| other as &dyn Diagnostic)) as Box<dyn Iterator<Item = _>>)
    }
}

/// Line and column, from 1.
fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = &text[..offset.min(text.len())];
    let line = before.matches('\n').count() + 1;
    let column = before.len() - before.rfind('\n').map_or(0, |newline| newline + 1) + 1;
    (line, column)
}
