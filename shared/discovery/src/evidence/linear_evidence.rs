//! Evidence of a linear problem with the noise free.

use super::marginal::{Bound, cut_at_nothing, log_marginal};
use super::noise::{Linearly, NoisePrior};
use identification::filter::NoiseModel;
use identification::fit::Normal;

/// A linear problem with the noise free: its evidence, that noise, and what its columns have in
/// standard deviations of their priors.
pub(super) struct LinearEvidence {
    pub value: f64,
    pub noise: NoiseModel,
    pub amplitudes: Vec<f64>,
}

/// The evidence of a linear problem, its noise searched from `start`.
pub(super) fn linear_evidence(
    linear: &Linearly<'_>,
    (start, prior): (&NoiseModel, &NoisePrior),
) -> Option<LinearEvidence> {
    let noise = linear.settled(start, prior)?.noise;
    let normal = linear.normal(&noise)?;
    let (_, mut x) = normal.least()?;
    let value = log_marginal(&normal, &bounds_of(&normal))? + linear.log_width_expected(&noise, prior)?;
    Some(LinearEvidence { value, noise, amplitudes: x.split_off(normal.unknowns) })
}

/// Of unknowns and columns whose range is felt; columns stand at nothing.
pub(super) fn bounds_of(normal: &Normal) -> Vec<Bound> {
    let felt = normal.room.iter().enumerate().skip(normal.unknowns);
    let felt = felt.filter(|(_, room)| room.iter().any(|end| end.abs() < 1e3));
    felt.map(|(place, room)| Bound { place, room: *room, prior: cut_at_nothing(room[0]) }).collect()
}
