//! What the data of an experiment do to the prior of a parameter: the one rule and its words.
//!
//! With prior information `1/σ₀²` and posterior `1/σ²`, the data hold `(σ₀/σ)² − 1` times the
//! information of the prior.

/// What the data did to the prior of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identifiability {
    /// Posterior sigma below a third of the prior's: the data hold at least eight times the
    /// information of the prior.
    Identified = 1,
    /// The data say something, the prior says more than an eighth of it.
    PriorKept,
    /// Posterior sigma within 1 % of the prior's: the data hold at most 2 % of its information.
    NotExcited,
}

/// Largest ratio of posterior to prior sigma of an identified parameter, and least one of a
/// parameter that is not excited.
const IDENTIFIED_RATIO_MAX: f64 = 1.0 / 3.0;
const NOT_EXCITED_RATIO_MIN: f64 = 0.99;

impl Identifiability {
    /// By the ratio of the posterior to the prior standard deviation, both in one unit.
    ///
    /// Panics where the prior's is not above zero.
    pub fn of(posterior_sd: f64, prior_sd: f64) -> Self {
        assert!(prior_sd > 0.0);
        match posterior_sd / prior_sd {
            ratio if ratio < IDENTIFIED_RATIO_MAX => Self::Identified,
            ratio if ratio < NOT_EXCITED_RATIO_MIN => Self::PriorKept,
            _ => Self::NotExcited,
        }
    }

    /// As it travels in telemetry, where 0 is no prior.
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// For tables and reports.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Identified => "identified",
            Self::PriorKept => "prior kept",
            Self::NotExcited => "not excited",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_is_called_identified_by_what_its_data_did_to_the_prior() {
        assert_eq!(Identifiability::of(0.1, 1.0), Identifiability::Identified);
        assert_eq!(Identifiability::of(0.8, 1.0), Identifiability::PriorKept);
        assert_eq!(Identifiability::of(0.999, 1.0), Identifiability::NotExcited);
        // without a finite sigma nothing was seen
        assert_eq!(Identifiability::of(f64::NAN, 1.0), Identifiability::NotExcited);
    }
}
