//! Files of one format in TOML, as tables and stored sequences are: every error at its place.

use crate::plants::utf8_text;
use crate::{Failure, located::Located};
use serde::de::DeserializeOwned;
use std::ops::Range;
use std::path::Path;

/// The format that this build reads.
const FORMAT: u32 = 1;

/// A file's text, and what a user can do about an error in it.
pub(crate) struct TomlFile {
    name: String,
    pub text: String,
    cure: &'static str,
}

impl TomlFile {
    /// # Errors
    /// [`Failure::Input`] where the file cannot be read or is not UTF-8.
    pub fn read(file: &Path, cure: &'static str) -> Result<Self, Failure> {
        let unreadable = |(message, other): (String, Option<String>)| {
            Failure::Input(miette::miette!(help = other.unwrap_or_else(|| cure.into()), "{message}"))
        };
        let text = utf8_text(file).map_err(unreadable)?;
        Ok(TomlFile { name: file.display().to_string(), text, cure })
    }

    /// An error at the bytes `span` of the text.
    pub fn at(&self, span: Range<usize>, message: String) -> Failure {
        Failure::input(Located::new(&self.name, &self.text, span, message, self.cure.into()))
    }

    /// What the text states; `format` is the number that it gives its format.
    ///
    /// # Errors
    /// [`Failure::Input`] at the place that is not valid, or for another format.
    pub fn parsed<T: DeserializeOwned>(&self, format: impl Fn(&T) -> u32) -> Result<T, Failure> {
        let parsed: T = toml::from_str(&self.text)
            .map_err(|error| self.at(error.span().unwrap_or(0..0), error.message().to_string()))?;
        match format(&parsed) {
            FORMAT => Ok(parsed),
            other => Err(self.at(0..0, format!("format = {other}: this build reads format {FORMAT}"))),
        }
    }
}
