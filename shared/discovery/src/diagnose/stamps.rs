//! Time stamps that jitter about an even grid.
//!
//! A sensor that is read evenly and stamped unevenly seems to read too early or too late. Beside an
//! edge of a command the stamp lies on the wrong side of it, which no noise model describes. The
//! recording decides whether the readings are even: the nominal plant is fitted to both and the
//! better one is kept.

use super::{Diagnosis, Options};
use identification::fit::{EstimationSession, fit};
use identification::problem::{Drive, Problem, Samples};
use identification::work::Work;
use std::sync::Arc;

/// Fewest stamps of a grid, and residuals about it as shares of the interval: below the first the
/// stamps are even, beyond the second there is no grid. Chosen, no derivation.
const STAMPS_LEAST: usize = 16;
const EVEN_SHARE: f64 = 1e-3;
const GRID_SHARE: f64 = 0.35;
/// Standard errors of the grid within which a reading is taken as synchronous with an edge of a
/// command.
const EDGE_SIGMAS: f64 = 4.0;
/// Gain in `−2 ln p` from which even readings are preferred: odds of exp(5) = 150 : 1. Chosen, no
/// derivation.
const EVEN_STAMPS_GAIN_MIN: f64 = 10.0;
/// Relinearisations of each fit.
const STAMP_ROUNDS: usize = 3;

/// A diagnosis by `each` on even stamps, where they explain the recordings better.
pub(crate) fn even_stamps(
    problem: &Problem,
    options: &Options,
    work: &Arc<Work>,
    each: &mut dyn FnMut(&Problem, &Options) -> Result<Diagnosis, String>,
) -> Result<Diagnosis, String> {
    let Some(mut evened) = evened(problem, options.threads, work) else { return each(problem, options) };
    let note = "the readings are even and their stamps are not: the stamps were replaced by their grid";
    evened.notes.push(note.to_owned());
    let held_out = options.held_out.as_ref().map(|other| even(other).unwrap_or_else(|| other.clone()));
    each(&evened, &Options { held_out, ..options.clone() })
}

/// `problem` with even stamps, where they explain its recording better.
fn evened(problem: &Problem, threads: usize, work: &Arc<Work>) -> Option<Problem> {
    let even = even(problem)?;
    let objective = |problem: &Problem| {
        let session = EstimationSession::counted(problem, threads, work.clone()).ok()?;
        Some(fit(&session, &problem.plant, &session.prior(), &session.noise, STAMP_ROUNDS).ok()?.objective)
    };
    (objective(&even)? < objective(problem)? - EVEN_STAMPS_GAIN_MIN).then_some(even)
}

/// Every channel on the grid that its stamps jitter about; `None` where no channel has one.
fn even(problem: &Problem) -> Option<Problem> {
    let mut even = problem.clone();
    let mut moved = false;
    for run in &mut even.runs {
        let edges = edges(&run.drives);
        for samples in &mut run.samples {
            if let Some((mut grid, sigma_s)) = grid(samples) {
                grid.iter_mut().for_each(|t| *t = beside(*t, &edges, EDGE_SIGMAS * sigma_s));
                samples.time_s = grid;
                moved = true;
            }
        }
    }
    moved.then_some(even)
}

/// Instants at which recorded commands change.
fn edges(drives: &[Drive]) -> Vec<f64> {
    let held =
        drives.iter().filter_map(|drive| if let Drive::Held { time_s, .. } = drive { Some(time_s) } else { None });
    let mut edges: Vec<f64> = held.flatten().copied().collect();
    edges.sort_by(f64::total_cmp);
    edges
}

/// The edge next to `t_s` if it lies within the uncertainty of the grid: a mean of stamps does not
/// determine the side of an edge.
fn beside(t_s: f64, edges: &[f64], apart_s: f64) -> f64 {
    let after = edges.partition_point(|edge| *edge < t_s);
    let near = edges[after.saturating_sub(1)..(after + 1).min(edges.len())].iter();
    let nearest = near.copied().min_by(|a, b| (a - t_s).abs().total_cmp(&(b - t_s).abs()));
    nearest.filter(|edge| (edge - t_s).abs() < apart_s).unwrap_or(t_s)
}

/// The straight line through stamps over their number, where they scatter about it by a part of the
/// interval, and its standard error at the ends.
fn grid(samples: &Samples) -> Option<(Vec<f64>, f64)> {
    let n = samples.time_s.len();
    if n < STAMPS_LEAST {
        return None;
    }
    let middle = 0.5 * (n - 1) as f64;
    let mean = samples.time_s.iter().sum::<f64>() / n as f64;
    let slope = samples.time_s.iter().enumerate().map(|(i, t)| (i as f64 - middle) * (t - mean)).sum::<f64>();
    let interval_s = slope / (n as f64 * (n as f64 * n as f64 - 1.0) / 12.0);
    let grid: Vec<f64> = (0..n).map(|i| mean + interval_s * (i as f64 - middle)).collect();
    let residual = || samples.time_s.iter().zip(&grid).map(|(t, g)| (t - g).abs());
    let apart = residual().fold(0.0, f64::max) / interval_s;
    // of a mean 1, of a line at its ends 2 over the root of n
    let sigma_s = 2.0 * (residual().map(|r| r * r).sum::<f64>()).sqrt() / n as f64;
    (interval_s > 0.0 && apart > EVEN_SHARE && apart < GRID_SHARE).then_some((grid, sigma_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{plant, problem, recording};

    fn jittered(problem: &mut Problem, share: f64) {
        let period_s = problem.plant.simulation.period_s;
        let mut draw = crate::noise::Noise::new(7);
        for samples in problem.runs.iter_mut().flat_map(|run| &mut run.samples) {
            samples.time_s.iter_mut().for_each(|t| *t += share * period_s * draw.normal());
        }
    }

    #[test]
    fn even_readings_with_uneven_stamps_are_put_back_on_their_grid() {
        let nominal = plant("oscillator");
        let straight = problem(&nominal, recording(&nominal, 3, 2.0));
        assert!(evened(&straight, 1, &Arc::default()).is_none());
        let mut uneven = straight.clone();
        jittered(&mut uneven, 0.05);
        let even = evened(&uneven, 1, &Arc::default()).expect("the even grid explains the readings better");
        let pairs = even.runs[0].samples[0].time_s.iter().zip(&straight.runs[0].samples[0].time_s);
        // mean of n stamps of 5 % each, and the slope's share at the ends
        let n = even.runs[0].samples[0].time_s.len() as f64;
        let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / nominal.simulation.period_s;
        assert!(worst < 4.0 * 2.0 * 0.05 / n.sqrt(), "{worst}");
    }

    #[test]
    fn readings_that_are_truly_uneven_stay_where_they_are() {
        let nominal = plant("oscillator");
        let mut uneven = problem(&nominal, recording(&nominal, 3, 2.0));
        jittered(&mut uneven, 0.05);
        // read at the stamped times, interpolated linearly between the simulated readings
        let period_s = nominal.simulation.period_s;
        for samples in uneven.runs.iter_mut().flat_map(|run| &mut run.samples) {
            let value = samples.value.clone();
            for (i, y) in samples.value.iter_mut().enumerate() {
                let at = samples.time_s[i] / period_s;
                let from = (at.max(0.0) as usize).min(value.len() - 2);
                *y = value[from] + (at - from as f64) * (value[from + 1] - value[from]);
            }
        }
        uneven.runs[0].samples.truncate(1);
        uneven.runs[0].samples.push(Samples::default());
        assert!(evened(&uneven, 1, &Arc::default()).is_none());
    }
}
