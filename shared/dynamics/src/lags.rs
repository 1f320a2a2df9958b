//! Exact discrete filters: lags and delays of actuators and sensors, never stiff states.
//!
//! A lag is advanced over an interval by its own closed form, however short its time constant is
//! beside the interval. On an actuator the input is held, and the acting value is the *mean* of the
//! lag's output over the interval: the impulse is exact, and the plant sees a held input. On a
//! sensor the input moves on a straight line.
//!
//! Gates ([`Gate`]) act on the held command before all that.
//!
//! Delays are no state of a lag: [`HeldDelay`] keeps held commands and splits the interval in two;
//! sensors are evaluated at the delayed instant.

mod delay;
mod gate;
mod lag;

pub use delay::{HeldDelay, HeldDelayState};
pub use gate::Gate;
pub use lag::{Lag, LagState};

/// Kind of a filter, in continuous time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKind {
    /// Passes.
    None,
    /// `1 / (τ s + 1)`.
    FirstOrder { time_constant_s: f64 },
    /// First order with one time constant for growing and another for falling magnitude.
    Asymmetric { rise_s: f64, fall_s: f64 },
    /// `ω² / (s² + 2ζω s + ω²)`.
    SecondOrder { frequency_hz: f64, damping_ratio: f64 },
    /// `u(t − d)`; fractions of a period by splitting the held interval.
    Delay { delay_s: f64 },
    /// A command whose impulse over one control period is below the smallest is not fired; see
    /// [`Gate`].
    MinimumImpulse { impulse_n_s: f64, interval_s: f64 },
    /// From `begin_s` on, this share of the command keeps its value at `begin_s`; see [`Gate`].
    Stuck { share: f64, begin_s: f64 },
}

impl FilterKind {
    /// How long it delays; zero for lags.
    pub fn delay_s(&self) -> f64 {
        if let Self::Delay { delay_s } = *self { delay_s } else { 0.0 }
    }

    /// The same for commands that are held over `period_s`.
    #[must_use]
    pub fn held_over(self, period_s: f64) -> Self {
        match self {
            Self::MinimumImpulse { impulse_n_s, .. } => Self::MinimumImpulse { impulse_n_s, interval_s: period_s },
            other => other,
        }
    }
}
