//! Why a plant cannot be simulated.

use dynamics::signal::SignalError;
use dynamics::system::SystemError;

/// What is wrong with a plant, its settings or a checkpoint.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulationError {
    #[error(transparent)]
    System(#[from] SystemError),
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// A number outside its range.
    #[error("{what} = {value}: {why}")]
    Setting { what: String, value: f64, why: &'static str },
    /// A controller that lacks something.
    #[error("controller '{controller}': {why}")]
    Controller { controller: String, why: String },
    /// A sensor names a clock that does not exist.
    #[error("sensor '{sensor}' names source '{source_name}', which does not exist")]
    UnknownSource { sensor: String, source_name: String },
    /// Exact zero-order hold asked of a plant that is not linear in its state: linearisations at
    /// two states differ by `difference`, relative to their size.
    #[error(
        "exact zero-order hold needs equations linear in state and time-invariant, but {what} differs by {difference:.1e} between two states; use runge_kutta_4"
    )]
    NotLinear { what: &'static str, difference: f64 },
    /// Exact zero-order hold asked of a plant whose inputs are not held.
    #[error("exact zero-order hold needs held inputs, but '{actuator}' prescribes a motion; use runge_kutta_4")]
    NotHeld { actuator: String },
    /// The motion left the numbers: a step too long for a stiff part, or an unstable loop.
    #[error("at {time_s} s '{state}' is no longer finite: a step too long for a stiff part, or a motion without bound")]
    NotFinite { time_s: f64, state: String },
    /// A checkpoint of another plant.
    #[error("the checkpoint belongs to another plant: {what} has {got} numbers instead of {expected}")]
    ForeignState { what: &'static str, got: usize, expected: usize },
}
