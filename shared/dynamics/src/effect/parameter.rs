//! One parameter of an effect: its range, its role in the law, and how it is screened and
//! estimated.
//!
//! A [`Role`] states the meaning of the parameter, a [`Scan`] the values at which the law is
//! screened before any refit, a [`Prior`] whether a refit estimates it. The builders of
//! [`EffectParameter`] set the three together.

/// Meaning of a parameter in its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Size of the effect: zero in all amplitudes is no effect. Several are the components of a
    /// vector.
    Amplitude,
    /// An angle that turns the amplitude; the law repeats `repeats` times while the angle turns
    /// once.
    Direction {
        /// Periods of the law per turn of the angle.
        repeats: f64,
    },
    /// Frequency of a resonance or a tone.
    Frequency,
    /// Damping ratio of a resonance.
    DampingRatio,
    /// Periods of a ripple per turn of the coordinate.
    Order,
    /// Time at which the law begins to act.
    Onset,
    /// Time for which it acts.
    Duration,
    /// A rate, a distance or a time over which the law unfolds.
    Width,
    /// Rate over which a sign function is smoothed: numerics, not physics.
    Smoothing,
    /// Any other parameter of the form of the law.
    Shape,
}

/// Prior standard deviation of an amplitude where an effect is fitted, in amplitudes that were
/// estimated before it: its data alone say how large it is.
pub const AMPLITUDE_PRIOR_RATIO: f64 = 30.0;
/// Prior standard deviation of a direction there \[rad\]: no direction is preferred.
pub const DIRECTION_PRIOR_RAD: f64 = 1.5;

/// Values at which a law is screened.
///
/// *Motion* is that of the site's coordinate along the filtered trajectories: its range from low to
/// high, the rms of its rate. Without motion, or if a range or a rate is zero, the scan is the
/// default of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scan {
    /// The default of the parameter.
    Default,
    /// One given value.
    At(f64),
    /// Several given values.
    Each(&'static [f64]),
    /// Factors on the default.
    TimesDefault(&'static [f64]),
    /// Shares of the rms rate.
    OfRate(&'static [f64]),
    /// So many of the inverse of the time between two samples.
    OfSampling(&'static [f64]),
    /// Shares of the range of motion.
    OfRange(&'static [f64]),
    /// Shares of the range of motion, no smaller than a step of integration resolves at the largest
    /// rate.
    OfRangeFollowed(&'static [f64]),
    /// The low end of the motion plus shares of the range.
    FromLow(&'static [f64]),
    /// The high end of the motion plus shares of the range.
    FromHigh(&'static [f64]),
    /// Zero if the motion passes through it, else the middle of the motion.
    Inside,
    /// Mean specific force along the axis of a tank that no slosh axis has
    /// ([`Tank::axial`](crate::description::Tank::axial)).
    SpecificForce,
    /// Duration of the recording, divided by this value.
    DurationOver(f64),
    /// From three periods per recording to a third of its sample rate, and the lines in the
    /// spectrum of the innovations.
    Frequencies,
    /// Usual orders that the motion resolves, and the orders at which the innovations are periodic
    /// in the coordinate.
    Orders,
    /// Times across the recording, and the instants at which the innovations jump.
    Onsets,
    /// To the end of all recordings, or a quarter of one.
    Durations,
}

/// Standard deviation of a prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// In the unit of the parameter.
    Absolute(f64),
    /// Share of the screened value.
    Relative(f64),
}

impl Spread {
    /// Standard deviation at a screened `value`, in the unit of the parameter.
    pub fn sigma(self, value: f64) -> f64 {
        match self {
            Self::Absolute(sigma) => sigma,
            Self::Relative(share) => share * value.abs(),
        }
    }
}

/// Whether a refit estimates the parameter, and from which prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// The parameter stays at the value of the screening.
    Kept,
    /// Estimated, with this standard deviation about the screened value.
    Free(Spread),
    /// Estimated unless the screened value is an integer.
    FreeUnlessWhole(Spread),
    /// Estimated in a second fit, which replaces the first if BIC prefers it.
    FreeIfPreferred(Spread),
}

impl Prior {
    /// Standard deviation in the first refit from `value`; `None`: the parameter is not estimated.
    pub fn sigma(self, value: f64) -> Option<f64> {
        match self {
            Self::Free(spread) => Some(spread.sigma(value)),
            Self::FreeUnlessWhole(spread) if value.fract() != 0.0 => Some(spread.sigma(value)),
            _ => None,
        }
    }

    /// Standard deviation in the second refit; `None`: there is no second refit.
    pub fn sigma_if_preferred(self, value: f64) -> Option<f64> {
        if let Self::FreeIfPreferred(spread) = self { Some(spread.sigma(value)) } else { None }
    }
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectParameter {
    /// Name in files and on the command line, snake case; unique in its effect.
    pub name: &'static str,
    /// SI unit; `*` stands for the unit of the site (rad or m at a joint, m or rad at a tank, of
    /// the input at an actuator, of the channel at a sensor). J/rad is a torque, J/m a force.
    pub unit: &'static str,
    /// Lower end of the plausible range; the sign is part of the range: friction is never negative.
    pub low: f64,
    /// Upper end of the plausible range.
    pub high: f64,
    /// Value where a file states none, and of [`Scan::Default`].
    pub default: f64,
    /// Meaning and symbol, for help and reports.
    pub what: &'static str,
    /// Component that leaves the plane: planar plants do not have the parameter.
    pub out_of_plane: bool,
    /// Its meaning in the law.
    pub role: Role,
    /// Values at which the law is screened.
    pub scan: Scan,
    /// Whether and how a refit estimates it.
    pub prior: Prior,
    /// The likelihood has maxima a factor apart: a refit starts from several values.
    pub multimodal: bool,
}

impl EffectParameter {
    /// A shape that keeps its default, from name, unit, plausible range, default and meaning.
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

    /// As an amplitude; amplitudes come first in the list of an effect.
    #[must_use]
    pub const fn amplitude(self) -> Self {
        Self { role: Role::Amplitude, ..self }
    }

    /// An angle that turns the amplitude; the law has `repeats` periods per turn.
    #[must_use]
    pub const fn direction(self, repeats: f64) -> Self {
        Self { role: Role::Direction { repeats }, ..self }
    }

    /// As a frequency \[Hz\]: screened over the spectrum, estimated within 30 % of the screened
    /// value.
    #[must_use]
    pub const fn frequency(self) -> Self {
        let prior = Prior::Free(Spread::Relative(0.3));
        Self { role: Role::Frequency, scan: Scan::Frequencies, prior, ..self }
    }

    /// Damping ratio of a resonance, screened at `at` and estimated.
    #[must_use]
    pub const fn damping_ratio(self, at: f64, spread: Spread) -> Self {
        Self { role: Role::DampingRatio, scan: Scan::At(at), prior: Prior::Free(spread), ..self }
    }

    /// As an order of a ripple: screened over the orders that the motion resolves, estimated within
    /// 10 %.
    #[must_use]
    pub const fn order(self) -> Self {
        let prior = Prior::Free(Spread::Relative(0.1));
        Self { role: Role::Order, scan: Scan::Orders, prior, ..self }
    }

    /// As an onset \[s\]: screened over the recording, not estimated.
    #[must_use]
    pub const fn onset(self) -> Self {
        Self { role: Role::Onset, scan: Scan::Onsets, ..self }
    }

    /// As a duration \[s\]: screened, not estimated.
    #[must_use]
    pub const fn duration(self) -> Self {
        Self { role: Role::Duration, scan: Scan::Durations, ..self }
    }

    /// As a rate, distance or time over which the law unfolds: screened at `scan`, estimated within
    /// 70 %, from several starts.
    #[must_use]
    pub const fn width(self, scan: Scan) -> Self {
        let prior = Prior::Free(Spread::Relative(0.7));
        Self { role: Role::Width, scan, prior, multimodal: true, ..self }
    }

    /// As a smoothing rate: 5 % of the rms rate, not estimated.
    #[must_use]
    pub const fn smoothing(self) -> Self {
        Self { role: Role::Smoothing, scan: Scan::OfRate(&[0.05]), ..self }
    }

    /// With the values of `scan` in the screening.
    #[must_use]
    pub const fn scanned(self, scan: Scan) -> Self {
        Self { scan, ..self }
    }

    /// With the prior of a refit.
    #[must_use]
    pub const fn with_prior(self, prior: Prior) -> Self {
        Self { prior, ..self }
    }

    /// With a likelihood of several maxima: a refit starts from several values.
    #[must_use]
    pub const fn multimodal(self) -> Self {
        Self { multimodal: true, ..self }
    }

    /// As a component that planar plants do not have.
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
