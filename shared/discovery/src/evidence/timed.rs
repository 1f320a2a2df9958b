//! The shift of the inputs that a model asks for.

use super::decide::SHIFT_SIGMA;
use super::hypothesis::Hypothesis;
use super::linear_evidence::linear_evidence;
use super::model::{Ground, Model, from};
use super::noise::Linearly;
use super::timing::{ROOM, SHIFTS, is_possible, nearest, shift_of, shifted};
use identification::fit::EstimationSession;

/// `−∂ν` of inputs shifted by a standard deviation of the prior beyond what the set has; `None`
/// where no input is held.
pub(super) fn column(session: &EstimationSession<'_>, model: &Model) -> Option<Vec<f64>> {
    if !is_possible(&model.problem) {
        return None;
    }
    let (plant, linearised) = (&model.problem.plant, &model.fit.linearised);
    let problem = shifted(&model.problem, SHIFT_SIGMA);
    let session = EstimationSession { problem: &problem, ..session.clone() };
    let session = session.in_parts(session.parts).ok()?;
    let nu = session.innovations(plant, &model.fit.theta, &linearised.linears, &|_| true)?;
    Some(linearised.nu.iter().zip(&nu).map(|(own, moved)| own - moved).collect())
}

/// The model at the shift that its linear problem asks for, as long as the evidence rises.
///
/// Cost: a pass and an evaluation of the linear problem, and a fit for each shift.
pub(super) fn timed(ground: Ground<'_>, model: Model) -> Model {
    let mut best = model;
    for _ in 0..SHIFTS.len() {
        let Some(shift) = wanted(ground, &best) else { break };
        let mut set = best.set.clone();
        set.iter_mut().for_each(|own| {
            if let Hypothesis::Timing(known) = own {
                *known = shift;
            }
        });
        match from(ground, &set, best.begin(), 1.0) {
            Some(found) if found.log_marginal > best.log_marginal => best = found,
            _ => break,
        }
    }
    best
}

/// Another shift than the set has, which the linear problem asks for.
fn wanted(ground: Ground<'_>, model: &Model) -> Option<f64> {
    let known = shift_of(&model.set)?;
    let session = model.session(ground)?;
    let extra = [column(&session, model)?];
    let (linearised, theta) = (&model.fit.linearised, &model.fit.theta[..]);
    let linear = Linearly { session: &session, linearised, theta, extra: &extra, room: &[ROOM] };
    let found = linear_evidence(&linear, (&model.noise, &model.prior(ground.session)))?;
    let shift = nearest(known + SHIFT_SIGMA * found.amplitudes[0]);
    (shift != known).then_some(shift)
}

#[cfg(test)]
mod tests;
