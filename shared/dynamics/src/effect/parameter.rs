//! One parameter of an effect: its range, what it is to the law, and how it is searched and estimated.

/// What a parameter is to its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Where every amplitude of an effect is zero nothing changes; several are the components of a vector.
    Amplitude,
    /// An angle that turns the amplitude; the law repeats `repeats` times while the angle turns once.
    Direction {
        repeats: f64,
    },
    /// Of a resonance or a tone.
    Frequency,
    DampingRatio,
    /// Periods of a ripple while the coordinate turns once.
    Order,
    /// Time at which the law begins to act.
    Onset,
    /// Time for which it acts.
    Duration,
    /// A rate, a distance or a time over which the law unfolds.
    Width,
    /// Rate over which a sign turns: numerics, not physics.
    Smoothing,
    /// Any other number that shapes the law.
    Shape,
}

/// Values at which a law is screened.
///
/// *Motion* is that of the site's coordinate along the filtered trajectories: its range from low to high, the rms of its rate. Without
/// motion, and where a range or a rate is zero, the default is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scan {
    Default,
    At(f64),
    /// Factors on the default.
    TimesDefault(&'static [f64]),
    /// Shares of the rms rate.
    OfRate(&'static [f64]),
    /// Shares of the range.
    OfRange(&'static [f64]),
    /// The same, no finer than what a step of integration can follow at the largest rate.
    OfRangeFollowed(&'static [f64]),
    /// The low end of the motion plus shares of the range.
    FromLow(&'static [f64]),
    /// The high end plus shares of the range.
    FromHigh(&'static [f64]),
    /// Zero where the motion holds it, else its middle.
    Inside,
    /// The recording's duration over this.
    DurationOver(f64),
    /// From three periods over the recording to a third of its rate, and the lines of the innovations' spectrum.
    Frequencies,
    /// Customary orders that the motion resolves, and those at which the innovations repeat.
    Orders,
    /// Times over the recording, and the instants at which the innovations jump.
    Onsets,
    /// To the end of all recordings, or a quarter of one.
    Durations,
}

/// Prior standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    Absolute(f64),
    /// Share of the value.
    Relative(f64),
}

impl Spread {
    pub fn sigma(self, value: f64) -> f64 {
        match self {
            Self::Absolute(sigma) => sigma,
            Self::Relative(share) => share * value,
        }
    }
}

/// Whether a refit estimates the parameter, and from which prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// The parameter stays at the value of the screening.
    Kept,
    Free(Spread),
    /// Estimated unless the value is a whole number.
    FreeUnlessWhole(Spread),
    /// Estimated in a second fit, which stands where BIC prefers it.
    FreeIfPreferred(Spread),
}

impl Prior {
    /// Standard deviation in a first refit from `value`; `None`: the parameter stays.
    pub fn sigma(self, value: f64) -> Option<f64> {
        match self {
            Self::Free(spread) => Some(spread.sigma(value)),
            Self::FreeUnlessWhole(spread) if value.fract() != 0.0 => Some(spread.sigma(value)),
            _ => None,
        }
    }

    /// Standard deviation in the second one.
    pub fn sigma_if_preferred(self, value: f64) -> Option<f64> {
        if let Self::FreeIfPreferred(spread) = self { Some(spread.sigma(value)) } else { None }
    }
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectParameter {
    pub name: &'static str,
    /// SI unit; `*` stands for the unit of the site (rad or m at a joint, m or rad at a tank, of the input at an actuator, of the channel
    /// at a sensor). J/rad is a torque, J/m a force.
    pub unit: &'static str,
    /// Plausible range; the sign is part of it: friction is never negative.
    pub low: f64,
    pub high: f64,
    pub default: f64,
    pub what: &'static str,
    /// Without any effect where everything lies in a plane: planar plants do not list it.
    pub out_of_plane: bool,
    pub role: Role,
    pub scan: Scan,
    pub prior: Prior,
    /// The likelihood has maxima a factor apart: fits start from several values.
    pub multimodal: bool,
}

impl EffectParameter {
    /// Name, unit, plausible range, default, meaning; a shape that stays at its default.
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        [low, high]: [f64; 2],
        default: f64,
        what: &'static str,
    ) -> Self {
        let (role, scan, prior) = (Role::Shape, Scan::Default, Prior::Kept);
        Self { name, unit, low, high, default, what, out_of_plane: false, role, scan, prior, multimodal: false }
    }

    #[must_use]
    pub const fn amplitude(self) -> Self {
        Self { role: Role::Amplitude, ..self }
    }

    /// An angle; see [`Role::Direction`].
    #[must_use]
    pub const fn direction(self, repeats: f64) -> Self {
        Self { role: Role::Direction { repeats }, ..self }
    }

    #[must_use]
    pub const fn frequency(self) -> Self {
        let prior = Prior::Free(Spread::Relative(0.3));
        Self { role: Role::Frequency, scan: Scan::Frequencies, prior, ..self }
    }

    /// Damping ratio of a resonance that is estimated from `at` on.
    #[must_use]
    pub const fn damping_ratio(self, at: f64, spread: Spread) -> Self {
        Self { role: Role::DampingRatio, scan: Scan::At(at), prior: Prior::Free(spread), ..self }
    }

    #[must_use]
    pub const fn order(self) -> Self {
        let prior = Prior::Free(Spread::Relative(0.1));
        Self { role: Role::Order, scan: Scan::Orders, prior, ..self }
    }

    #[must_use]
    pub const fn onset(self) -> Self {
        Self { role: Role::Onset, scan: Scan::Onsets, ..self }
    }

    #[must_use]
    pub const fn duration(self) -> Self {
        Self { role: Role::Duration, scan: Scan::Durations, ..self }
    }

    #[must_use]
    pub const fn width(self, scan: Scan) -> Self {
        let prior = Prior::Free(Spread::Relative(0.7));
        Self { role: Role::Width, scan, prior, multimodal: true, ..self }
    }

    #[must_use]
    pub const fn smoothing(self) -> Self {
        Self { role: Role::Smoothing, scan: Scan::OfRate(&[0.05]), ..self }
    }

    #[must_use]
    pub const fn scanned(self, scan: Scan) -> Self {
        Self { scan, ..self }
    }

    #[must_use]
    pub const fn with_prior(self, prior: Prior) -> Self {
        Self { prior, ..self }
    }

    /// See [`EffectParameter::multimodal`].
    #[must_use]
    pub const fn multimodal(self) -> Self {
        Self { multimodal: true, ..self }
    }

    /// The same parameter as one that planar plants do not feel.
    #[must_use]
    pub const fn out_of_plane(self) -> Self {
        Self { out_of_plane: true, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prior_says_what_a_refit_estimates() {
        let [absolute, relative] = [Spread::Absolute(0.05), Spread::Relative(0.1)];
        assert_eq!(Prior::Kept.sigma(3.0), None);
        assert_eq!(Prior::Free(absolute).sigma(3.0), Some(0.05));
        assert_eq!(Prior::FreeUnlessWhole(relative).sigma(3.0), None);
        assert_eq!(Prior::FreeUnlessWhole(relative).sigma(3.5), Some(0.1 * 3.5));
        assert_eq!(Prior::FreeIfPreferred(relative).sigma(3.5), None);
        assert_eq!(Prior::FreeIfPreferred(relative).sigma_if_preferred(3.5), Some(0.1 * 3.5));
    }
}
