//! Maps of a held command that act before delays and lags: pulses too short to be fired, a command
//! that sticks.

use super::FilterKind;

/// An instant meant to lie on an edge must not fall before it by rounding [s].
const EDGE_S: f64 = 1e-9;

/// A map of commands with one state, zero at the start. The other kinds of [`FilterKind`] pass the
/// command unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    kind: FilterKind,
}

impl Gate {
    /// The gate of `kind`; `None` where it lets every command pass.
    pub fn new(kind: FilterKind) -> Option<Self> {
        matches!(kind, FilterKind::MinimumImpulse { .. } | FilterKind::Stuck { .. }).then_some(Self { kind })
    }

    /// The value that passes for `command` in the interval from `t_s` on; `held` is the state of
    /// the gate.
    pub fn pass(&self, held: &mut f64, t_s: f64, command: f64) -> f64 {
        match self.kind {
            FilterKind::MinimumImpulse { impulse_n_s, interval_s } => {
                if command.abs() * interval_s < impulse_n_s {
                    0.0
                } else {
                    command
                }
            }
            FilterKind::Stuck { begin_s, .. } if t_s < begin_s - EDGE_S => {
                *held = command;
                command
            }
            FilterKind::Stuck { share, .. } => command + share * (*held - command),
            _ => command,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pulse_is_fired_whole_or_not_at_all() {
        let gate = Gate::new(FilterKind::MinimumImpulse { impulse_n_s: 0.05, interval_s: 0.1 }).unwrap();
        let fired = |command| gate.pass(&mut 0.0, 0.0, command);
        assert_eq!([0.4999, -0.4999, 0.5001, -3.0].map(fired), [0.0, 0.0, 0.5001, -3.0]);
    }

    #[test]
    fn what_sticks_keeps_the_last_command_before_its_time() {
        let commands = |share| {
            let gate = Gate::new(FilterKind::Stuck { begin_s: 0.3, share }).unwrap();
            let mut held = 0.0;
            [0.0, 0.1, 0.2, 0.3, 0.4].map(|t| gate.pass(&mut held, t, 10.0 * t))
        };
        assert_eq!(commands(1.0), [0.0, 1.0, 2.0, 2.0, 2.0]);
        assert_eq!(commands(0.5), [0.0, 1.0, 2.0, 2.5, 3.0]);
    }

    #[test]
    fn filters_that_are_no_gates_pass() {
        assert!(Gate::new(FilterKind::None).is_none());
        assert!(Gate::new(FilterKind::Delay { delay_s: 1.0 }).is_none());
    }
}
