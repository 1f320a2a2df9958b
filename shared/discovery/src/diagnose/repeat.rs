//! The same experiment once more: what physics does repeats, what noise does not.
//!
//! With `c` the joint direction of what was adopted, at the amplitudes of the first recording, the repeat is asked one question: how many
//! times that direction does it hold? The answer is a ratio of likelihoods with the noise maximised on both sides, by the sign of the
//! multiple: `z = ±√(2 ln p(c) − 2 ln p(0))`. Where the physics is there z expects `|c'|`, else a standard normal.

use super::showing::carried;
use super::{Adopted, Standing};
use crate::score::{Column, columns};
use identification::filter::NoiseModel;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit};
use identification::problem::Problem;

/// One-sided level of 1 %: the repeat is asked one question.
const REPEATS_Z: f64 = 2.33;
/// Relinearisations of the nominal plant on the repeat.
const ROUNDS: usize = 6;

/// What the repeat says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repeat {
    pub z: f64,
    /// What z would be if the first recording's amplitudes were exact.
    pub expected: f64,
}

impl Repeat {
    /// The repeat shows what the first recording did.
    pub fn confirms(&self) -> bool {
        self.z > REPEATS_Z
    }

    /// The repeat would hardly show it even if it were there.
    pub fn silent(&self) -> bool {
        self.expected < 2.0 * REPEATS_Z && !self.confirms()
    }
}

/// Asks `repeat` for `adopted`; `None` where the nominal plant cannot follow it.
pub(super) fn ask(
    repeat: &Problem,
    nominal: (&EstimationSession<'_>, &Fit, &NoiseModel),
    best: &Standing,
    adopted: &[Adopted],
) -> Option<Repeat> {
    let (first, stated, noise) = nominal;
    let problem = repeat.with_plant(&stated.plant);
    let session = EstimationSession::new(&problem, first.threads).ok()?;
    let theta = carried(&session, &first.problem.unknowns, &stated.theta);
    let fitted = fit(&session, &stated.plant, &theta, noise, ROUNDS).ok()?;
    let list: Vec<_> = adopted.iter().map(|own| own.column.candidate.clone()).collect();
    let found = columns((&session, &fitted.linearised), &stated.plant, &fitted.theta, &list);
    let (linearised, theta) = (&fitted.linearised, &fitted.theta);
    let raw = joint(&found, adopted, linearised.nu.len());
    let search = Search { sweeps: 4, colour: true, scan: false };
    let (own, with) = maximise(&session, linearised, theta, &[&raw], &best.noise, search)?;
    let without = [noise, &own].map(|start| maximise(&session, linearised, theta, &[], start, search));
    let without = without.into_iter().flatten().map(|(_, objective)| objective).fold(f64::INFINITY, f64::min);
    let normal = linearised.normal(&session, theta, &own, &[&raw])?;
    let (_, multiple) = normal.minimum()?;
    // in standard errors: the multiple one, as the repeat would measure it
    let (least, at_one) = (normal.minimum_without()?, normal.minimum()?.0);
    let power = (least - at_one).max(0.0).sqrt() / multiple[0].abs().max(f64::MIN_POSITIVE);
    Some(Repeat { z: (without - with).max(0.0).sqrt() * multiple[0].signum(), expected: power })
}

/// Sum of the columns at the amplitudes of the first recording.
fn joint(found: &[Column], adopted: &[Adopted], samples: usize) -> Vec<f64> {
    let mut sum = vec![0.0; samples];
    for own in adopted {
        let Some(column) = found.iter().find(|c| c.candidate.same_law(&own.column.candidate)) else { continue };
        for (raw, amplitude) in column.raw.iter().zip(&own.score.amplitude) {
            sum.iter_mut().zip(raw).for_each(|(sum, c)| *sum += amplitude * c);
        }
    }
    sum
}
