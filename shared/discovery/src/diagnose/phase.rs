//! What a diagnosis is doing.

/// A part of a diagnosis, in the order of work; [`Phase::Score`] and [`Phase::Compare`] come once a
/// round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    Fit,
    Noise,
    Score,
    Compare,
    SearchAgain,
    HeldOut,
    LowSignificance,
    OneParameterLaw,
    UnknownLaw,
    Report,
}

impl Phase {
    /// How many there are.
    pub(crate) const COUNT: usize = Self::Report as usize + 1;

    /// `compare sets of effects`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Phase::Fit => "fit the nominal plant",
            Phase::Noise => "noise of the nominal plant",
            Phase::Score => "score the catalogue",
            Phase::Compare => "compare sets of effects",
            Phase::SearchAgain => "search again for earlier effects",
            Phase::HeldOut => "held out",
            Phase::LowSignificance => "effects of low significance",
            Phase::OneParameterLaw => "a one-parameter law outside the catalogue",
            Phase::UnknownLaw => "a law that is not in the catalogue",
            Phase::Report => "report",
        }
    }
}
