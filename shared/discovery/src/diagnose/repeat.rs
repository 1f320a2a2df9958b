//! Repetition of the experiment: a physical effect recurs, noise does not.
//!
//! With `c` the joint direction of the adopted effects, at the amplitudes of the first recording,
//! one parameter is tested on the repeat: the multiple of `c` that it holds. The statistic is a
//! likelihood ratio with the noise maximised on both sides, signed by the multiple:
//! `z = ±√(2 ln p(c) − 2 ln p(0))`. Under the effect its expectation is `|c'|`, else z is standard
//! normal.

use super::Adopted;
use super::held_out_evidence::carried;
use crate::compete::FittedModel;
use crate::score::{Column, columns};
use identification::filter::NoiseModel;
use identification::fit::noise::{Search, maximise};
use identification::fit::{EstimationSession, Fit, fit};
use identification::problem::Problem;

/// One-sided 1 % quantile of the standard normal distribution: one test on the repeat.
const REPEATS_Z: f64 = 2.33;
/// Relinearisations of the nominal plant on the repeat.
const REPEAT_ROUNDS: usize = 6;

/// Result of the repeat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repeat {
    pub z: f64,
    /// Expectation of z if the first recording's amplitudes were exact.
    pub expected: f64,
}

impl Repeat {
    /// The repeat shows the effects at the level of [`REPEATS_Z`].
    pub fn confirms(&self) -> bool {
        self.z > REPEATS_Z
    }

    /// The repeat has no power: it would hardly show the effects even if they were present.
    pub fn lacks_power(&self) -> bool {
        self.expected < 2.0 * REPEATS_Z && !self.confirms()
    }
}

/// Tests `adopted` on `repeat`; `None` where the nominal plant cannot be fitted to it.
pub(super) fn test_on_repeat(
    repeat: &Problem,
    nominal: (&EstimationSession<'_>, &Fit, &NoiseModel),
    best: &FittedModel,
    adopted: &[Adopted],
) -> Option<Repeat> {
    let (first, stated, noise) = nominal;
    let problem = repeat.with_plant(&stated.plant);
    let session = EstimationSession::counted(&problem, first.threads, first.work.beside()).ok()?;
    let theta = carried(&session, &first.problem.unknowns, &stated.theta);
    let fitted = fit(&session, &stated.plant, &theta, noise, REPEAT_ROUNDS).ok()?;
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
