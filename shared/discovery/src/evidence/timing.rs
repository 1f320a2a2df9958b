//! Inputs between their samples: held from a stamp on, linear between stamps, or shifted.
//!
//! A shift by a share a of a sample moves that share of every value to the next interval (a lead,
//! a < 0: to the one before); the impulse of every interval is that of the shifted input:
//!
//! ```text
//! u_k ← (1 − |a|) u_k + |a| u_{k−1}   (a > 0),      u_{k+1}   (a < 0)
//! ```
//!
//! Values that are linear between their stamps are a lead of half a sample, exactly so in impulse.
//! The prior of a is normal about zero, [`SHIFT_SIGMA`]: held against sampled. What is later by
//! more is a delay, which the catalogue has.

use super::decide::SHIFT_SIGMA;
use super::hypothesis::Hypothesis;
use identification::problem::{Drive, Problem};

/// Shares of a sample that are fitted.
pub(super) const SHIFTS: [f64; 8] = [-1.0, -0.75, -0.5, -0.25, 0.25, 0.5, 0.75, 1.0];

/// Logarithm of the number of shifts that one was picked from, each by its prior.
pub(super) fn log_points(shift: f64) -> f64 {
    let log_density = |a: f64| -0.5 * (a / SHIFT_SIGMA) * (a / SHIFT_SIGMA);
    libm::log(SHIFTS.iter().map(|a| libm::exp(log_density(*a))).sum()) - log_density(shift)
}

/// The shift of a set; `None` where inputs are as they are stated.
pub(super) fn shift_of(set: &[Hypothesis]) -> Option<f64> {
    set.iter().find_map(|own| if let Hypothesis::Timing(shift) = own { Some(*shift) } else { None })
}

/// Some input is held between recorded stamps.
pub(super) fn is_possible(problem: &Problem) -> bool {
    problem.runs.iter().flat_map(|run| &run.drives).any(|drive| matches!(drive, Drive::Held { .. }))
}

/// `problem` with its recorded inputs as `set` has them.
pub(super) fn as_seen(problem: Problem, set: &[Hypothesis]) -> Problem {
    match shift_of(set) {
        Some(shift) => shifted(&problem, shift),
        None => problem,
    }
}

/// `problem` with all recorded inputs later by a share of their own sample.
pub(super) fn shifted(problem: &Problem, shift: f64) -> Problem {
    let mut problem = problem.clone();
    for drive in problem.runs.iter_mut().flat_map(|run| &mut run.drives) {
        let Drive::Held { value, .. } = drive else { continue };
        let other = |k: usize| if shift > 0.0 { k.saturating_sub(1) } else { (k + 1).min(value.len() - 1) };
        let moved = (0..value.len()).map(|k| value[k] + shift.abs() * (value[other(k)] - value[k])).collect();
        *value = moved;
    }
    problem
}

/// Room of a shift [prior standard deviations]: a sample either way, and what noise adds.
pub(super) const ROOM: [f64; 2] = [-2.0, 2.0];

/// The share that is fitted nearest to one.
pub(super) fn nearest(shift: f64) -> f64 {
    let near = SHIFTS.iter().min_by(|a, b| (**a - shift).abs().total_cmp(&(**b - shift).abs()));
    near.copied().unwrap_or(shift)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, problem, recording};

    fn commands(problem: &Problem) -> Vec<f64> {
        match &problem.runs[0].drives[0] {
            Drive::Held { value, .. } => value.clone(),
            _ => unreachable!("the drive's current is recorded"),
        }
    }

    #[test]
    fn half_a_sample_of_lead_is_the_mean_of_neighbours_and_a_whole_one_the_next_value() {
        let nominal = plant("drive_rig");
        let own = problem(&nominal, recording(&nominal, 3, 1.0));
        let (u, half, later) = (commands(&own), commands(&shifted(&own, -0.5)), commands(&shifted(&own, 1.0)));
        for k in 1..u.len() - 1 {
            assert!((half[k] - 0.5 * (u[k] + u[k + 1])).abs() < 1e-12 && (later[k] - u[k - 1]).abs() < 1e-12);
        }
    }

    #[test]
    fn the_prior_of_all_shifts_adds_to_one() {
        let whole: f64 = SHIFTS.iter().map(|shift| libm::exp(-log_points(*shift))).sum();
        assert!((whole - 1.0).abs() < 1e-12, "{whole}");
    }
}
