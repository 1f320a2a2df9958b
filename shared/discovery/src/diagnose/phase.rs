//! What a diagnosis is doing.

/// A part of a diagnosis, in the order of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    Fit,
    Noise,
    Compare,
    UnknownLaw,
    Report,
}

impl Phase {
    /// How many there are.
    pub(crate) const COUNT: usize = Self::Report as usize + 1;

    /// `compare sets of hypotheses`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Phase::Fit => "fit the nominal plant",
            Phase::Noise => "noise of the nominal plant",
            Phase::Compare => "compare sets of hypotheses",
            Phase::UnknownLaw => "a law that is not in the catalogue",
            Phase::Report => "report",
        }
    }
}
