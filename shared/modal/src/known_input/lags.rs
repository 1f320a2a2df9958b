//! Channels that are late against the input by whole samples.
//!
//! A late channel answers with the same poles and turned residues; only the samples of the response
//! between input and arrival tell it. Its residual at poles of the whole record falls with every
//! sample that it is moved towards its place. Parts of a sample are of no concern: the direct term
//! of the next sample takes them up.

use crate::maximum_likelihood::{Evaluation, Model, Outputs};
use crate::projection::dot;
use crate::record::Record;
use faer::c64;

/// Samples that a channel is moved at most.
const LAG_MAX: usize = 200;
/// Gain in log-likelihood that makes a move significant: as much by chance once in 10⁵ channels
/// (χ² with one degree of freedom beyond 20).
const LAG_GAIN_MIN: f64 = 10.0;

/// Samples that each channel is late (negative: early), at `poles`; `None` if none is, or if rows
/// are absent.
///
/// Cost: one projection per channel and sample moved.
pub(super) fn lags(record: &Record, model: Model, outputs: &Outputs, poles: &[c64]) -> Option<Vec<isize>> {
    if outputs.present.len() < outputs.samples {
        return None;
    }
    let at = Evaluation::new(record, model, outputs, poles);
    let of = |c: usize| {
        let squares = |lag: isize| {
            let mut moved = moved(&outputs.channels[c], lag, |edge| edge);
            at.basis.project_out(&mut moved);
            dot(&moved, &moved)
        };
        let climb = |direction: isize| {
            let (mut lag, mut least) = (0_isize, at.squares[c]);
            while lag.unsigned_abs() < LAG_MAX.min(outputs.samples / 10) {
                let further = squares(lag + direction);
                if further >= least {
                    break;
                }
                (lag, least) = (lag + direction, further);
            }
            (lag, least)
        };
        let (lag, least) = [climb(1), climb(-1)].into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let gain = 0.5 * outputs.samples as f64 * libm::log(at.squares[c] / least.max(f64::MIN_POSITIVE));
        (gain > LAG_GAIN_MIN).then_some(lag)
    };
    let all: Vec<isize> = (0..record.channels).map(|c| of(c).unwrap_or(0)).collect();
    all.iter().any(|lag| *lag != 0).then_some(all)
}

/// The record with each channel moved to its place; rows that lack a channel then are absent.
pub(super) fn in_step(record: &Record, lags: &[isize]) -> Record {
    let mut outputs = record.outputs.clone();
    for (c, lag) in lags.iter().enumerate() {
        let channel = record.channel(c, 0..record.samples());
        let moved = moved(&channel, *lag, |_| f64::NAN);
        outputs.iter_mut().skip(c).step_by(record.channels).zip(moved).for_each(|(y, x)| *y = x);
    }
    Record { outputs, ..record.clone() }
}

/// `y(t + lag)`; beyond the ends what `outside` makes of the last sample.
fn moved(y: &[f64], lag: isize, outside: impl Fn(f64) -> f64) -> Vec<f64> {
    let last = y.len() as isize - 1;
    let at = |t: isize| if (0..=last).contains(&t) { y[t as usize] } else { outside(y[t.clamp(0, last) as usize]) };
    (0..=last).map(|t| at(t + lag)).collect()
}
