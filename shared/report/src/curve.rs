//! A curve of a figure, and what it stands for.

/// Role of a line, which decides its style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Black dots.
    Measured,
    /// The model before: grey.
    Before,
    /// The model after: the one colour.
    After,
    /// Dashed.
    Truth,
    /// One of the others: dotted grey.
    Rival,
}

impl Role {
    pub(crate) fn class(self) -> &'static str {
        match self {
            Role::Measured => "line measured",
            Role::Before => "line before",
            Role::After => "line after",
            Role::Truth => "line truth",
            Role::Rival => "line rival",
        }
    }

    /// Order of drawing among the lines: measured ones are wide and lie below, truth lies on top.
    pub(crate) fn layer(self) -> u8 {
        match self {
            Role::Measured => 0,
            Role::Rival => 1,
            Role::Before => 2,
            Role::After => 3,
            Role::Truth => 4,
        }
    }
}

/// A line or a cloud of samples.
#[derive(Clone, Copy, Debug)]
pub struct Curve<'a> {
    pub label: &'a str,
    pub role: Role,
    pub x: &'a [f64],
    pub y: &'a [f64],
}
