//! Whether an arc refuses the model whatever steps are still to come.

use crate::fold::FALSE_REFUSALS;
use crate::message::Received;
use identification::statistics::chi_squared_tail;
use nalgebra::{Cholesky, DMatrix};

/// Information that keeps directions which an arc does not see out of its step: that of priors a
/// thousand times as wide as those of the parameters.
const WIDE_PRIOR_INFORMATION: f64 = 1e-6;
/// Common points of linearisation behind which steps count as taken. Two are enough for starts
/// within the priors (design page "study case", 6: one in 14 of 20 cases, two in six).
const STEPS_ENOUGH: u16 = 2;

/// What no parameters of the plant can take from an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainder {
    pub arc: usize,
    /// Lowest `χ²` that the arc's linear model allows, over its rows.
    pub chi2_per_row: f64,
    /// How often noise of the stated size leaves as much.
    pub p: f64,
    /// Share of the excess over the noise that the step to the lowest `χ²` would take.
    promised_share: f64,
}

impl Remainder {
    /// Of one message. About its point `χ²(δ) = χ² − 2g'δ + δ'Nδ`, whose lowest value over all
    /// steps is `χ² − g'N⁻¹g`: whatever other arcs say of the parameters, this arc keeps at least
    /// so much. Of a true model that is a `χ²` of no more than its rows.
    ///
    /// `None` where a number is not finite.
    #[must_use]
    pub fn of(one: &Received) -> Option<Self> {
        let message = &one.message;
        let n = message.gradient.len();
        let weak = DMatrix::identity(n, n) * WIDE_PRIOR_INFORMATION;
        let promised = message.gradient.dot(&Cholesky::new(&message.information + weak)?.solve(&message.gradient));
        let rows = message.rows.max(1) as f64;
        let lowest = message.chi2 - promised;
        Some(Self {
            arc: one.arc,
            chi2_per_row: lowest / rows,
            p: chi_squared_tail(lowest.max(0.0), rows),
            promised_share: promised / (message.chi2 - rows).max(f64::MIN_POSITIVE),
        })
    }
}

/// The arc that keeps most above its noise, where that is impossible under a true model. Messages
/// are of `generation`; `looks` is how many generations are looked at in a run.
///
/// The linear model speaks for the arc near its point alone. So the step must leave more of the
/// excess than it takes, or two common steps must have been taken: a start that is merely far is
/// not refused.
#[must_use]
pub fn unexplained(received: &[Received], generation: u16, looks: usize) -> Option<Remainder> {
    let level = 0.5 * FALSE_REFUSALS / (received.len() * looks).max(1) as f64;
    let stays = |one: &Remainder| generation >= STEPS_ENOUGH || one.promised_share < 0.5;
    let refused = received.iter().filter_map(Remainder::of).filter(|one| one.p < level && stays(one));
    refused.max_by(|a, b| a.chi2_per_row.total_cmp(&b.chi2_per_row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;
    use crate::trial;

    const ROWS: usize = 4000;
    const LOOKS: usize = 7;

    /// An arc `off` posterior sigmas from its optimum in every parameter, where it keeps
    /// `chi2_per_row`.
    fn arc(arc: usize, off: f64, chi2_per_row: f64) -> Received {
        let parameters = Parameters::of_plant(&trial::plant("oscillator")).unwrap();
        let excess = parameters.len() as f64 * off * off / ROWS as f64;
        trial::arc(&parameters, arc, [off / 10.0, chi2_per_row + excess], ROWS)
    }

    #[test]
    fn what_a_step_can_take_is_no_reason_to_refuse() {
        // far off, and all of the excess is promised to the step
        assert_eq!(unexplained(&[arc(0, 80.0, 1.0), arc(1, 0.0, 1.02)], 0, LOOKS), None);
        assert_eq!(unexplained(&[arc(0, 80.0, 1.0)], 2, LOOKS), None);
    }

    #[test]
    fn an_excess_that_no_step_takes_is_refused_at_once_and_the_worst_arc_is_named() {
        let found = unexplained(&[arc(0, 1.0, 1.3), arc(1, 1.0, 2.0), arc(2, 1.0, 1.0)], 0, LOOKS).unwrap();
        assert_eq!(found.arc, 1);
        assert!((found.chi2_per_row - 2.0).abs() < 1e-6 && found.p < 1e-100, "{found:?}");
    }

    #[test]
    fn far_from_the_optimum_an_arc_is_refused_once_steps_were_taken() {
        // the step takes more than it leaves: the linear model is not trusted before
        let far = [arc(0, 80.0, 1.3)];
        assert_eq!((unexplained(&far, 0, LOOKS), unexplained(&far, 1, LOOKS)), (None, None));
        assert_eq!(unexplained(&far, 2, LOOKS).map(|found| found.arc), Some(0));
    }
}
