//! What a column over frequency or time is: a response, a spectrum of an output, a coherence, …

/// Kind of a function, where the file says it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FunctionKind {
    /// The file does not say: every column of CSV, type 0 of a universal file.
    #[default]
    Unknown,
    /// Samples over time.
    Time,
    /// Correlation over lag.
    Correlation,
    /// Response over its input: frequency response, transmissibility, cross spectrum over the auto
    /// spectrum of the input.
    Response,
    /// Auto spectrum of an output. Its column holds magnitudes; `power` says that the file holds
    /// their squares.
    AutoSpectrum { power: bool },
    /// Power (or energy) spectral density of an output. Its column holds the square root without
    /// the constant `1/√Hz`: modes do not depend on a constant factor.
    PowerSpectralDensity,
    /// Spectrum of an output. Its column holds magnitudes.
    Spectrum,
    /// Cross spectrum of two outputs.
    CrossSpectrum,
    /// Coherence of an output with one or several inputs.
    Coherence,
    /// Anything else: mode indicator, shock response, order function, …
    Other,
}

impl FunctionKind {
    /// Whether peaks of such a column are resonances: not those of a coherence, a cross spectrum or
    /// a mode indicator.
    #[must_use]
    pub fn has_resonances(self) -> bool {
        !matches!(self, FunctionKind::CrossSpectrum | FunctionKind::Coherence | FunctionKind::Other)
    }

    /// Whether a complex column of this kind may be fitted as the response to an input.
    #[must_use]
    pub fn is_response(self) -> bool {
        matches!(self, FunctionKind::Response | FunctionKind::Unknown)
    }

    /// Whether it is a spectrum of an output alone.
    #[must_use]
    pub fn is_of_output(self) -> bool {
        matches!(self, FunctionKind::AutoSpectrum { .. } | FunctionKind::PowerSpectralDensity | FunctionKind::Spectrum)
    }

    /// Of one function and of several.
    #[must_use]
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            FunctionKind::Unknown => ("function of unknown type", "functions of unknown type"),
            FunctionKind::Time => ("time history", "time histories"),
            FunctionKind::Correlation => ("correlation", "correlations"),
            FunctionKind::Response => ("response", "responses"),
            FunctionKind::AutoSpectrum { .. } => ("auto spectrum", "auto spectra"),
            FunctionKind::PowerSpectralDensity => ("power spectral density", "power spectral densities"),
            FunctionKind::Spectrum => ("spectrum", "spectra"),
            FunctionKind::CrossSpectrum => ("cross spectrum", "cross spectra"),
            FunctionKind::Coherence => ("coherence function", "coherence functions"),
            FunctionKind::Other => ("function of another type", "functions of another type"),
        }
    }

    /// `2 coherence functions`.
    pub(crate) fn counted(self, count: usize) -> String {
        let (one, several) = self.words();
        format!("{count} {}", if count == 1 { one } else { several })
    }

    /// Which kind is taken where nobody chose: responses and time histories before spectra and
    /// correlations; `None` for what holds no resonances.
    pub(crate) fn precedence(self) -> Option<u8> {
        match self {
            FunctionKind::Time | FunctionKind::Response => Some(0),
            other => other.has_resonances().then_some(1),
        }
    }
}
