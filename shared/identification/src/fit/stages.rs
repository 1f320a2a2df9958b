//! A fit of long recordings by way of their beginnings.
//!
//! Most of what is wrong with a start shows on a beginning, where a step costs its share of one on
//! the whole, and a number that slips cycles slips fewer. Each stage starts where the last one
//! ended.

use super::continuation::{Way, continued};
use super::{EstimationSession, Fit, FitError, Rounds};

/// Readings of the first beginning; the factor to the next one, and by which recordings are longer
/// than the last. Budgets.
pub const FIRST_READINGS: usize = 6000;
const GROWTH: usize = 4;
pub const LONGER_MIN: usize = 3;

/// [`super::fit_by_continuation`], of long recordings from where beginnings end.
///
/// # Errors
/// Those of [`super::fit`].
pub fn fit_in_stages(session: &EstimationSession<'_>, rounds: impl Into<Rounds>) -> Result<Fit, FitError> {
    let rounds = rounds.into();
    let mut begin: Option<(Vec<f64>, bool)> = None;
    let mut readings = FIRST_READINGS;
    while session.samples >= LONGER_MIN * readings {
        if let Some(found) = stage(session, readings, begin.as_ref(), rounds) {
            begin = Some((found.theta.clone(), found.is_near()));
        }
        readings *= GROWTH;
    }
    next(session, begin.as_ref(), rounds)
}

fn stage(
    session: &EstimationSession<'_>,
    readings: usize,
    begin: Option<&(Vec<f64>, bool)>,
    rounds: Rounds,
) -> Option<Fit> {
    let problem = session.problem.split(readings as f64 / session.samples as f64).0;
    let own = EstimationSession::counted(&problem, session.threads, session.work.clone()).ok()?;
    next(&EstimationSession { along: session.along, ..own }, begin, rounds).ok()
}

/// From the priors by way of disturbances; from where a beginning ended by way of them only where
/// what that followed is missed now.
fn next(session: &EstimationSession<'_>, begin: Option<&(Vec<f64>, bool)>, rounds: Rounds) -> Result<Fit, FitError> {
    match begin {
        None => continued(session, &session.prior(), Way::WhereFar, rounds),
        Some((theta, was_near)) => {
            continued(session, theta, if *was_near { Way::WhereFar } else { Way::Direct }, rounds)
        }
    }
}
