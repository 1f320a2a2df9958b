//! Exact parameters of the plant file as further columns of a model.

use super::exact::{Exact, exact};
use super::hypothesis::Hypothesis;
use super::marginal::{Bound, log_marginal};
use super::model::{Ground, Model};
use super::noise::Linearly;
use super::propose::Proposal;
use identification::fit::EstimationSession;

/// Share of its standard deviation over which a number's column is taken.
const COLUMN_STEP: f64 = 0.1;

/// Every exact number as a further column of `model`, whose evidence on its linear problem is
/// `bare`.
///
/// Cost: a pass for each number.
pub(super) fn proposals(
    ground: Ground<'_>,
    session: &EstimationSession<'_>,
    model: &Model,
    bare: f64,
) -> Vec<Proposal> {
    let known =
        |exact: &Exact| model.set.iter().any(|own| matches!(own, Hypothesis::Exact(own) if own.name == exact.name));
    let all = exact(&ground.session.problem.plant).into_iter().filter(|exact| !known(exact));
    all.filter_map(|exact| proposal(ground, session, model, (exact, bare))).collect()
}

fn proposal(
    ground: Ground<'_>,
    session: &EstimationSession<'_>,
    model: &Model,
    (exact, bare): (Exact, f64),
) -> Option<Proposal> {
    let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
    let mut plant = model.problem.plant.clone();
    plant.visit_quantities(&mut |name, _, quantity| {
        if name == exact.name {
            quantity.value += COLUMN_STEP * exact.sigma;
        }
    });
    let moved = session.innovations(&plant, theta, &linearised.linears, &|_| true)?;
    let column = linearised.nu.iter().zip(&moved).map(|(own, moved)| (own - moved) / COLUMN_STEP).collect();
    let down = -exact.value / exact.sigma;
    let (extra, room) = ([column], [[down, f64::INFINITY]]);
    let linear = Linearly { session, linearised, theta, extra: &extra, room: &room };
    let prior = model.prior(ground.session);
    let noise = linear.settled(&model.noise, &prior)?.noise;
    let normal = linear.normal(&noise)?;
    let bound = Bound { place: normal.unknowns, room: room[0], prior: [down, f64::INFINITY] };
    let value = log_marginal(&normal, &[bound])? + linear.log_width_expected(&noise, &prior)?;
    Some(Proposal { instead: false, set: vec![Hypothesis::Exact(exact)], log_bayes: value - bare, noise })
}
